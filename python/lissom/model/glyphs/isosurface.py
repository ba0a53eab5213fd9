"""Surfaces of functions that are given on a grid, for drawings."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Values are at least this part of the largest change between neighbours: triangles at zeros on the grid
#: would have no area.
LEAST = 1e-4

#: Maximum number of cells along an axis: more are not seen, and make reports large.
MOST_CELLS = 48


def isosurface(values: Array, spacing: Sequence[float]) -> tuple[Array, NDArray[np.int64]]:
    """Corners (v, 3), metres from the first value, and triangles (m, 3) where values are zero.

    Triangles are anticlockwise seen from where values are positive (marching tetrahedra; Payne and Toga
    1990).
    """
    kept = [_kept(number) for number in values.shape]
    coarse = values[np.ix_(*kept)]
    # Parts that are thinner than the coarse grid.
    if (coarse > 0.0).all() or (coarse <= 0.0).all():
        kept, coarse = [np.arange(number) for number in values.shape], values
    least = LEAST * max(float(np.abs(np.diff(coarse, axis=axis)).max()) for axis in range(3))
    coarse = np.where(np.abs(coarse) < least, -least, coarse)
    x, y, z = (step * places for step, places in zip(spacing, kept, strict=True))
    places = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(coarse.size).reshape(coarse.shape)
    rows, columns, layers = (size - 1 for size in coarse.shape)
    flat = coarse.reshape(-1)
    cuts = []
    # Six tetrahedra around a diagonal of each cell (Kuhn 1960): ways along the axes in all orders.
    for order in permutations(range(3)):
        corners = [np.zeros(3, int)]
        for axis in order:
            corners.append(corners[-1] + np.eye(3, dtype=int)[axis])
        tetrahedra = np.stack(
            [number[i : i + rows, j : j + columns, k : k + layers].reshape(-1) for i, j, k in corners], axis=1
        )
        cuts.append(_cut(tetrahedra, flat, places))
    edges = np.concatenate(cuts)
    ends, triangles = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    start, end = flat[ends[:, 0]], flat[ends[:, 1]]
    share = (start / (start - end))[:, None]
    points = (1.0 - share) * places[ends[:, 0]] + share * places[ends[:, 1]]
    return points, triangles.reshape(-1, 3)


def _kept(number: int) -> NDArray[np.int64]:
    """Places of the values along an axis of which drawings are made."""
    return np.unique(np.linspace(0, number - 1, min(number, MOST_CELLS + 1)).round().astype(np.int64))


def _cut(tetrahedra: NDArray[np.int64], values: Array, places: Array) -> NDArray[np.int64]:
    """Triangles within tetrahedra: the ends (m, 3, 2) of the edges on which their corners are."""
    is_inside = values[tetrahedra] <= 0.0
    number = is_inside.sum(axis=1)
    is_cut = (number > 0) & (number < 4)
    tetrahedra, is_inside, number = tetrahedra[is_cut], is_inside[is_cut], number[is_cut]
    # Corners inside come first.
    sorted_corners = np.take_along_axis(tetrahedra, np.argsort(~is_inside, axis=1, kind="stable"), axis=1)
    found = []
    for inside, corners in (
        (1, [[(0, 1), (0, 2), (0, 3)]]),
        (2, [[(0, 2), (0, 3), (1, 3)], [(0, 2), (1, 3), (1, 2)]]),
        (3, [[(0, 3), (1, 3), (2, 3)]]),
    ):
        own = sorted_corners[number == inside]
        middle = places[own[:, inside:]].mean(axis=1) - places[own[:, :inside]].mean(axis=1)
        for triangle in corners:
            edges = np.sort(np.stack([own[:, list(edge)] for edge in triangle], axis=1), axis=2)
            at = places[edges].mean(axis=2)
            normal = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0])
            is_inwards = np.einsum("mi,mi->m", normal, middle) < 0.0
            edges[is_inwards] = edges[is_inwards][:, ::-1]
            found.append(edges)
    return np.concatenate(found)
