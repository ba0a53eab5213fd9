"""Springs that pull tips, and visible ranges of inputs, from the linear model about a shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..._lissom import Model
from ...model.views import Frame

Array = NDArray[np.float64]

#: Phase angle of a tip that swings on the spring alone while its force is constant. The force lags behind the
#: tip by this angle, which the damping compensates.
ANGLE = 0.3

#: Stiffness of the spring relative to that of the tip, so that stiffly held tips can be deflected.
SHARE = 0.2

#: Time scale in seconds: for a free tip, the spring's stiffness follows from the inertia that resists a force
#: of this duration.
SLOW = 0.3


@dataclass(frozen=True)
class Spring:
    """A spring between a tip and a position."""

    #: Stiffness in N/m and damping in N s/m.
    stiffness: float
    damping: float


def spring(model: Model, tip: Frame, q: Array, t: float, u: Array, held: float) -> Spring:
    """A spring that moves a tip visibly, and is stable when its force is constant for ``held`` seconds."""
    stiffness, damping, mass = _tangents(model, q, t, u)
    across = tip.jacobian(q, t)[3:]
    # Resistance to a force that acts for this time (Newmark's method, average acceleration).
    short = _resistance(across, mass + 0.5 * held * damping + 0.25 * held**2 * stiffness)
    long = _resistance(across, stiffness + mass / SLOW**2)
    frequency = ANGLE / held
    return Spring(frequency**2 * short + SHARE * long, frequency * short)


def deflections(model: Model, tips: list[Frame], q: Array, t: float, u: Array) -> Array:
    """Displacements of the tips per unit of each input, (inputs,), metres; of the coordinates without
    tips."""
    stiffness, _, mass = _tangents(model, q, t, u)
    rest = np.zeros(model.n)
    moved = np.linalg.pinv(stiffness + mass / SLOW**2) @ model.input_tangent(q, rest, rest, t=t, u=u)
    if tips:
        moved = np.concatenate([tip.jacobian(q, t)[3:] @ moved for tip in tips])
    return np.asarray(np.linalg.norm(moved, axis=0))


def _tangents(model: Model, q: Array, t: float, u: Array) -> tuple[Array, Array, Array]:
    rest = np.zeros(model.n)
    parts = model.tangent(q, rest, rest, t=t, u=u)
    stiffness, damping, mass = (np.nan_to_num(part) for part in parts)
    return stiffness, damping, mass


def _resistance(across: Array, matrix: Array) -> float:
    """Smallest resistance to a force at a tip; zero if it cannot move."""
    mobility = across @ np.linalg.pinv(matrix) @ across.T
    largest = float(np.linalg.norm(mobility, 2)) if np.isfinite(mobility).all() else 0.0
    return 1.0 / largest if largest > 0.0 else 0.0
