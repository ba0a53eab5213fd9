"""States of a motion between two that it keeps."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .._lissom import MotionResult

Array = NDArray[np.float64]

#: Larger changes between two states are jumps of the coordinates: rotation vectors jump at half a turn.
LARGEST_CHANGE = np.pi


def state_at(result: MotionResult, t: float) -> tuple[Array, Array]:
    """Coordinates and velocities (n,) at a time within a motion; the nearest ones where they jump."""
    k = min(max(int(np.searchsorted(result.t, t, side="right")) - 1, 0), len(result.t) - 1)
    if t == result.t[k]:
        return result.q[k], result.v[k]
    part = float((t - result.t[k]) / (result.t[k + 1] - result.t[k]))
    if np.abs(result.q[k + 1] - result.q[k]).max() > LARGEST_CHANGE:
        part = round(part)
    return quintic(result, k)(part)


def quintic(result: MotionResult, k: int) -> Callable[[float], tuple[Array, Array]]:
    """Coordinates and velocities between state k, at 0, and the next one, at 1.

    The quintic polynomial matches the coordinates, velocities and accelerations of both states.
    """
    h = result.t[k + 1] - result.t[k]
    (q, next_q), (v, next_v), (a, next_a) = (x[k : k + 2] for x in (result.q, result.v, result.a))
    curvature = 0.5 * h**2 * a
    left = np.stack([next_q - q - h * v - curvature, h * (next_v - v) - 2.0 * curvature, h**2 * (next_a - a)])
    # Contributions of the cubic, quartic and quintic terms at the end: value, first and second derivative.
    higher = np.linalg.solve([[1.0, 1.0, 1.0], [3.0, 4.0, 5.0], [6.0, 12.0, 20.0]], left)
    terms = np.stack([q, h * v, curvature, *higher])
    powers = np.arange(6.0)

    def at(x: float) -> tuple[Array, Array]:
        if x in (0.0, 1.0):
            return (q, v) if x == 0.0 else (next_q, next_v)
        slopes = powers[1:] * x ** powers[:-1]
        return x**powers @ terms, slopes @ terms[1:] / h

    return at
