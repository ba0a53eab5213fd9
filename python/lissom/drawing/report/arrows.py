"""Arrows in space, and unit vectors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .layers import Arrows

Array = NDArray[np.float64]

#: Proportions of arrows, relative to their scale: length and radius of the head, radius of the shaft.
HEAD, HEAD_RADIUS, SHAFT = 0.08, 0.026, 0.009


def arrows(layer: str, tails: Array, vectors: Array, size: float, names: list[str]) -> Arrows:
    """A layer of arrows (shapes, arrows, 3)."""
    return Arrows(names, layer, tails, vectors, HEAD * size, HEAD_RADIUS * size, SHAFT * size)


def unit(vectors: Array) -> Array:
    """Normalise vectors (..., 3); zero vectors are unchanged."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: Array = vectors / np.where(length > 0.0, length, 1.0)
    return unit


def across(vectors: Array) -> Array:
    """Unit vectors perpendicular to vectors (..., 3)."""
    least = np.eye(3)[np.argmin(np.abs(vectors), axis=-1)]
    return unit(np.cross(vectors, least))
