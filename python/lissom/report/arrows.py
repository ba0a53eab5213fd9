"""Arrows in space: shafts and heads."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .layers import LEGEND, Trace

Array = NDArray[np.float64]

#: The head of an arrow, relative to what it is scaled to: its length and its radius; and at most this part of
#: the arrow.
HEAD, HEAD_RADIUS, MOST_HEAD = 0.08, 0.026, 0.6

#: Corners of the head of an arrow.
CORNERS = 6


def arrows(layer: str, tails: Array, arrows: Array, size: float, text: str | list[str]) -> list[Trace]:
    """Arrows (shapes, arrows, 3) of a layer: shafts and heads."""
    length = np.linalg.norm(arrows, axis=-1, keepdims=True)
    head = np.minimum(HEAD * size, MOST_HEAD * length)
    along = unit(arrows)
    necks = tails + arrows - head * along
    breaks = np.full_like(tails, np.nan)
    shafts = np.stack([tails, necks, breaks], axis=2).reshape(len(tails), -1, 3)
    texts = text if isinstance(text, str) else [each for each in text for _ in range(3)]
    colour = LEGEND[layer]["line"]["color"]
    looks: dict[str, Any] = {**LEGEND[layer], "text": texts, "hoverinfo": "text"}
    return [
        Trace(layer, "scatter3d", shafts, looks),
        cones(layer, colour, necks, head * along, HEAD_RADIUS / HEAD),
    ]


def cones(layer: str, colour: str, base: Array, heads: Array, slenderness: float) -> Trace:
    """Heads of arrows (shapes, heads, 3) on points: cones of a radius of length times slenderness."""
    radius = slenderness * np.linalg.norm(heads, axis=-1)[..., None, None]
    first = across(heads)
    second = np.cross(unit(heads), first)
    angle = 2.0 * np.pi * np.arange(CORNERS)[:, None] / CORNERS
    circle = base[..., None, :] + radius * (
        np.cos(angle) * first[..., None, :] + np.sin(angle) * second[..., None, :]
    )
    points = np.concatenate([(base + heads)[..., None, :], circle], axis=2)
    number = points.shape[1]
    one = [(0, 1 + a, 1 + b) for a, b in pairwise([*range(CORNERS), 0])]
    one += [(1, 1 + b, 1 + a) for a, b in pairwise(range(1, CORNERS))]
    faces = (np.array(one)[None] + (CORNERS + 1) * np.arange(number)[:, None, None]).reshape(-1, 3)
    looks = {
        **dict(zip("ijk", faces.astype(np.int32).T, strict=True)),
        "color": colour,
        "flatshading": True,
        "hoverinfo": "skip",
    }
    return Trace(layer, "mesh3d", points.reshape(len(points), -1, 3), looks)


def unit(vectors: Array) -> Array:
    """Vectors (..., 3) of length one; those of length zero stay."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: Array = vectors / np.where(length > 0.0, length, 1.0)
    return unit


def across(vectors: Array) -> Array:
    """Unit vectors across vectors (..., 3)."""
    least = np.eye(3)[np.argmin(np.abs(vectors), axis=-1)]
    return unit(np.cross(vectors, least))
