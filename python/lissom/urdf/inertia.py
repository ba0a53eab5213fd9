"""Rotations and inertia tensors of URDF files."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin

import numpy as np
from numpy.typing import NDArray

#: Tolerance for rounding errors of a tensor, relative to its largest entry, as for `Body`.
_INERTIA_TOLERANCE = 1e-9


def quaternion(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """Quaternion of rotations about the fixed axes x, y, z in this order: Rz(yaw) Ry(pitch) Rx(roll)."""
    (cr, sr), (cp, sp), (cy, sy) = ((cos(angle / 2), sin(angle / 2)) for angle in (roll, pitch, yaw))
    return (
        cy * cp * cr + sy * sp * sr,
        cy * cp * sr - sy * sp * cr,
        cy * sp * cr + sy * cp * sr,
        sy * cp * cr - cy * sp * sr,
    )


def rotation(q: Sequence[float]) -> NDArray[np.float64]:
    """Matrix of a unit quaternion (w, x, y, z)."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def rotated(tensor: NDArray[np.float64], q: Sequence[float]) -> NDArray[np.float64]:
    """R I R^T: a tensor in the rotated axes."""
    R = rotation(q)
    turned: NDArray[np.float64] = R @ tensor @ R.T
    return (turned + turned.T) / 2


def mended(tensor: NDArray[np.float64]) -> NDArray[np.float64]:
    """The nearest valid inertia tensor in the Frobenius norm; the same object if it is valid.

    Principal moments a <= b <= c are valid if c <= a + b; it follows that none is negative.
    """
    (a, b, c), axes = np.linalg.eigh(tensor)
    excess = (c - a - b) / 3
    if 3 * excess <= _INERTIA_TOLERANCE * np.abs(tensor).max():
        return tensor
    moments = np.array([a + excess, b + excess, c - excess])
    if moments[1] > moments[2]:
        # The moments would change their order; the nearest tensor is that of a needle, or zero.
        moments = np.array([0.0, 1.0, 1.0]) * max(0.0, (b + c) / 2)
    mended: NDArray[np.float64] = axes * moments @ axes.T
    return (mended + mended.T) / 2
