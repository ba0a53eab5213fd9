"""Visuals of links: triangle meshes with sharp and smooth edges."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...model.views import Carried
from .layers import Mesh, quaternions

Array = NDArray[np.float64]

#: Name of the layer.
LAYER = "visuals"

#: Neighbouring triangles with a larger angle between their normals meet in a sharp edge, radians.
SHARP = math.radians(40.0)


def meshes(carried: Sequence[Carried], q: Array, t: Array) -> list[Mesh]:
    """Visuals in several shapes."""
    return [mesh(each, q, t) for each in carried]


def mesh(carried: Carried, q: Array, t: Array) -> Mesh:
    """A visual in several shapes."""
    visual = carried.visual
    points, faces, normals = creased(np.asarray(visual.points, float), np.asarray(visual.faces, np.int64))
    is_open = not is_closed(points, faces)
    nowhere, upright = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]])
    found = Mesh(
        visual.name, LAYER, points, normals, faces, nowhere, upright, visual.colour, visual.opacity, is_open
    )
    return moved(found, carried, q, t)


def moved(mesh: Mesh, carried: Carried, q: Array, t: Array) -> Mesh:
    """The mesh of a visual in other shapes."""
    poses = np.broadcast_to(carried.pose(q, t), (len(q), 4, 4))
    return replace(mesh, centres=poses[:, :3, 3], turns=quaternions(poses[:, :3, :3]))


def is_closed(points: Array, faces: NDArray[np.int64]) -> bool:
    """Whether each edge is one of two triangles, which go along it in opposite directions."""
    _, merged = np.unique(points, axis=0, return_inverse=True)
    corners = merged.reshape(-1)[faces]
    start, end = corners.reshape(-1), np.roll(corners, -1, axis=1).reshape(-1)
    forth, back = np.lexsort([end, start]), np.lexsort([start, end])
    return bool(
        np.array_equal(start[forth], end[back])
        and np.array_equal(end[forth], start[back])
        and len(np.unique(np.stack([start, end], axis=1), axis=0)) == len(start)
    )


def creased(points: Array, faces: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64], Array]:
    """Corners (v, 3), triangles (m, 3) and unit normals (v, 3), with corners of their own along sharp edges.

    Corners of triangles that meet smoothly are one; its normal is the mean of those of its triangles,
    weighted by their angles there, so that it does not matter how walls are cut into triangles.
    """
    points, merged = np.unique(points, axis=0, return_inverse=True)
    faces = merged.reshape(-1)[faces]
    a, b, c = (points[corner] for corner in faces.T)
    areas = np.cross(b - a, c - a)
    sizes = np.linalg.norm(areas, axis=1, keepdims=True)
    units = areas / np.where(sizes > 0.0, sizes, 1.0)
    # Corners that are the same: ends of edges between triangles that meet smoothly.
    first, second = _smooth_edges(faces, units)
    label = np.arange(faces.size)
    while True:
        least = np.minimum(label[first], label[second])
        new = label.copy()
        np.minimum.at(new, first, least)
        np.minimum.at(new, second, least)
        # Labels of labels: fans of many triangles need few passes.
        new = new[new]
        if np.array_equal(new, label):
            break
        label = new
    kept, renamed = np.unique(label, return_inverse=True)
    renamed = renamed.reshape(-1, 3)
    summed = np.zeros((len(kept), 3))
    for corner, here, left, right in zip(renamed.T, (a, b, c), (b, c, a), (c, a, b), strict=True):
        cosine = np.einsum("ij,ij->i", left - here, right - here)
        np.add.at(summed, corner, np.arctan2(sizes[:, 0], cosine)[:, None] * units)
    length = np.linalg.norm(summed, axis=1, keepdims=True)
    normals = np.where(length > 0.0, summed / np.where(length > 0.0, length, 1.0), [1.0, 0.0, 0.0])
    return points[faces.reshape(-1)[kept]], renamed, normals


def _smooth_edges(faces: NDArray[np.int64], normals: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs of corners of triangles, counted from 3 f for triangle f, that smooth edges join."""
    start = np.arange(faces.size)
    end = 3 * (start // 3) + (start + 1) % 3
    flat = faces.reshape(-1)
    low, high = np.minimum(flat[start], flat[end]), np.maximum(flat[start], flat[end])
    order = np.lexsort([high, low])
    one, other = order[:-1], order[1:]
    cosines = np.einsum("ij,ij->i", normals[one // 3], normals[other // 3])
    is_smooth = (
        (low[one] == low[other])
        & (high[one] == high[other])
        # Neighbours go along their edge in opposite directions.
        & (flat[start[one]] == flat[end[other]])
        & (cosines > math.cos(SHARP))
    )
    one, other = one[is_smooth], other[is_smooth]
    return np.concatenate([start[one], end[one]]), np.concatenate([end[other], start[other]])
