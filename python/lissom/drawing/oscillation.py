"""Natural modes as visible motions: their shapes at a suitable amplitude."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._lissom import ModesResult
from ..results.studies import Setting

Array = NDArray[np.float64]

#: Largest deflection in drawings of a mode, relative to the model's size; in coordinates for a pendulum.
AMPLITUDE = 0.15


#: Frequencies below this part of the highest one are rounding: squares err by 1e-15 of the highest one.
ROUNDING = 1e-7


def mode_motion(setting: Setting, q: Array, shape: NDArray[np.number], phase: Array) -> Array:
    """Coordinates (m, n) of a mode with shape (n,) about ``q``, at fractions (m,) of its period."""
    scaled = shape * (AMPLITUDE / _deflection(setting, q, shape))
    moved: Array = q + np.real(np.exp(2j * np.pi * phase)[:, None] * scaled)
    return moved


def is_rounding(found: ModesResult, k: int) -> bool:
    """Whether a mode does not oscillate."""
    return bool(found.frequency[k] <= ROUNDING * found.frequency.max())


def is_overdamped(found: ModesResult, k: int) -> bool:
    """Whether a mode returns without oscillation: its eigenvalue is real."""
    s = found.eigenvalues[k]
    return bool(s.real < 0.0 and abs(s.imag) <= ROUNDING * abs(s)) and not is_rounding(found, k)


def oscillates(found: ModesResult, k: int) -> bool:
    """Whether a mode has a frequency."""
    return not (is_rounding(found, k) or is_overdamped(found, k))


def frequency(found: ModesResult, k: int) -> str:
    """The frequency of a mode as text."""
    hertz = found.frequency[k]
    if is_overdamped(found, k):
        return "overdamped, without oscillation"
    if not is_rounding(found, k):
        return f"{hertz:.4g} Hz"
    return "grows without oscillation" if found.eigenvalues[k].real > 0 else "rigid-body motion"


def _deflection(setting: Setting, q: Array, shape: NDArray[np.number]) -> float:
    """Largest deflection of a shape, relative to the model's size; without links its largest coordinate."""
    seen = setting.view
    if not seen.is_spatial:
        return float(np.abs(shape).max())

    def largest(part: Array) -> float:
        # Linearised: the shape itself, added to q, could bend the rod by many turns.
        size = float(np.abs(part).max()) * seen.size
        if size == 0.0:
            return 0.0
        small = part * (1e-4 / size)
        moved = 0.0
        for link in seen.links:
            bent, straight = (link.pose(at, link.stations, setting.t)[:, :3, 3] for at in (q + small, q))
            moved = max(moved, float(np.linalg.norm(bent - straight, axis=1).max()))
        for solid in seen.solids:
            there, here = (solid.pose(at, setting.t)[:3, 3] for at in (q + small, q))
            moved = max(moved, float(np.linalg.norm(there - here)))
        return moved * (size / 1e-4) / seen.size

    deflection = float(np.hypot(largest(np.real(shape)), largest(np.imag(shape))))
    # Torsion of a straight rod has no deflection; an angle of one radian is used.
    return (
        deflection
        if deflection > 1e-9 * float(np.abs(shape).max()) * seen.size
        else float(np.abs(shape).max() * seen.size * AMPLITUDE)
    )
