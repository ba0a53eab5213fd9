"""Springs that pull tips, and visible ranges of inputs, from the linear model about a shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._lissom import Model
from ..views import Frame

Array = NDArray[np.float64]

#: The angle by which a tip that hangs on the spring alone swings while its force is held: the force follows
#: the tip that much late, and the damping makes up for it.
ANGLE = 0.3

#: Part of the tip's own stiffness that the spring has beside that: a tip that is held firmly can be bent.
SHARE = 0.2

#: Seconds: what nothing holds is as stiff as the inertia that resists a force of this duration.
SLOW = 0.3


@dataclass(frozen=True)
class Spring:
    """From a tip to a place."""

    #: N/m and N s/m.
    stiffness: float
    damping: float


def spring(model: Model, tip: Frame, q: Array, t: float, u: Array, held: float) -> Spring:
    """A spring that moves a tip visibly, and stably where its force is held for so many seconds."""
    stiffness, damping, mass = _tangents(model, q, t, u)
    across = tip.jacobian(q, t)[3:]
    # What a force meets that acts for this long (Newmark's method, average acceleration).
    short = _resistance(across, mass + 0.5 * held * damping + 0.25 * held**2 * stiffness)
    long = _resistance(across, stiffness + mass / SLOW**2)
    frequency = ANGLE / held
    return Spring(frequency**2 * short + SHARE * long, frequency * short)


def deflections(model: Model, tips: list[Frame], q: Array, t: float, u: Array) -> Array:
    """How far the tips move for a unit of each input, (inputs,), metres; without tips, the coordinates."""
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
    """The least resistance to a force at a tip; zero where it cannot move."""
    mobility = across @ np.linalg.pinv(matrix) @ across.T
    largest = float(np.linalg.norm(mobility, 2)) if np.isfinite(mobility).all() else 0.0
    return 1.0 / largest if largest > 0.0 else 0.0
