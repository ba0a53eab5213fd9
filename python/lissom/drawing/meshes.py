"""Meshes: vertices and triangles of rods with their true sections, of bars between points, and of shapes.

The live view, files of meshes and pictures draw these; the player of reports has its own copy in JavaScript.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .report import arrows
from .report.layers import Strand, Tube

Array = NDArray[np.float64]
Triangles = NDArray[np.uint32]

#: Number of corners of a section: six per side of a rectangle, whose edges are sharp.
CORNERS = 24
STRAND_CORNERS = 10

#: A head is at most this part of its arrow.
MOST_HEAD = 0.6

#: Below this sine, the old side of a bar does not say where its new one is.
TURNED_OVER = 1e-6

#: Number of parts of a rounded edge.
ROUND = 8

#: Number of parts of a rod with different colours.
BANDS = 10


def _outline(is_square: bool) -> Array:
    """Corners (corners, 2) of a section with unit half extents."""
    if not is_square:
        angle = 2.0 * np.pi * (np.arange(CORNERS) + 0.5) / CORNERS - 0.25 * np.pi
        return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    along = np.linspace(-1.0, 1.0, CORNERS // 4)
    one = np.ones_like(along)
    sides = [(one, along), (-along, one), (-one, -along), (along, -one)]
    return np.concatenate([np.stack(side, axis=-1) for side in sides])


OUTLINES = (_outline(False), _outline(True))


def _wall(rings: int, corners: int, first: int = 0, is_inner: bool = False) -> Triangles:
    """Triangles between successive rings of corners."""
    ring, corner = np.meshgrid(np.arange(rings - 1), np.arange(corners), indexing="ij")
    a = first + ring * corners + corner
    b = first + ring * corners + (corner + 1) % corners
    c, d = a + corners, b + corners
    triangles = np.stack([a, b, d, a, d, c], axis=-1).reshape(-1, 3)
    return np.asarray(triangles[:, ::-1] if is_inner else triangles, np.uint32)


def _ball(around: int = 24, along: int = 12) -> tuple[Array, Triangles]:
    """A unit ball: circles of latitude from pole to pole."""
    polar = np.linspace(0.0, np.pi, along + 1)[:, None]
    angle = 2.0 * np.pi * np.arange(around) / around
    x = np.broadcast_to(-np.cos(polar), (along + 1, around))
    # Poles are points, up to the last bit.
    radius = np.sin(polar) * (np.abs(np.cos(polar)) < 1.0)
    y, z = radius * np.cos(angle), radius * np.sin(angle)
    return np.stack([x, y, z], axis=-1).reshape(-1, 3), _wall(along + 1, around)


def _box() -> tuple[Array, Triangles]:
    """A cube with sides of length two and sharp edges."""
    vertices: list[Array] = []
    triangles: list[Triangles] = []
    for i in range(3):
        for side in (-1.0, 1.0):
            corners = np.zeros((4, 3))
            corners[:, i] = side
            corners[:, (i + 1) % 3] = side * np.array([-1.0, 1.0, 1.0, -1.0])
            corners[:, (i + 2) % 3] = [-1.0, -1.0, 1.0, 1.0]
            triangles.append(np.array([[0, 1, 2], [0, 2, 3]], np.uint32) + 4 * len(vertices))
            vertices.append(corners)
    return np.concatenate(vertices), np.concatenate(triangles).astype(np.uint32)


BALL, BOX = _ball(), _box()


def balls(points: Array, radius: float) -> tuple[Array, Triangles]:
    """Vertices and triangles of balls at points (balls, 3)."""
    unit, triangles = BALL
    vertices = (points[:, None] + radius * unit).reshape(-1, 3)
    starts = len(unit) * np.arange(len(points))
    return vertices, (triangles + starts[:, None, None]).reshape(-1, 3).astype(np.uint32)


class TubeSkin:
    """The mesh of a rod in bands along it: walls, end caps, and the hole of a tube."""

    def __init__(self, tube: Tube, bands: int = BANDS) -> None:
        stations = len(tube.stations)
        ends = np.unique(np.linspace(0, stations - 1, min(bands, stations - 1) + 1).round().astype(int))
        #: First and last station of each band.
        self.bands = list(zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True))
        #: Positions of the middles of the bands along the rod, from 0 to 1.
        self.middles = 0.5 * (ends[:-1] + ends[1:]) / (stations - 1)
        outline = np.stack([OUTLINES[bool(is_square)] for is_square in tube.square])
        self._outer = outline * tube.half[:, None]
        self._inner = self._outer * np.minimum(tube.hole, 0.999)[:, None, None]
        self._is_hollow = bool(np.any(tube.hole > 0.0))
        self.triangles = [self._triangles(a, b) for a, b in self.bands]
        #: Vertices (v, 3) of each band in the axes of their sections, and the stations (v,) of these.
        self.corners = [self._corners(a, b) for a, b in self.bands]

    def means(self, values: Array) -> Array:
        """Mean of values (stations,) over each band."""
        return np.array([values[a : b + 1].mean() for a, b in self.bands])

    def _triangles(self, a: int, b: int) -> Triangles:
        rings = b - a + 1
        parts = [_wall(rings, CORNERS)]
        first = rings * CORNERS
        for end in self._ends(a, b):
            # From the wall to the hole, or to the axis.
            parts.append(_wall(2, CORNERS, first, end < 0))
            first += 2 * CORNERS
        if self._is_hollow:
            parts.append(_wall(rings, CORNERS, first, True))
        # Rods are along body x, with outlines from y to z.
        return np.concatenate(parts)

    def _ends(self, a: int, b: int) -> list[int]:
        last = len(self._outer) - 1
        return [side for side, is_there in ((-1, a == 0), (1, b == last)) if is_there]

    def _corners(self, a: int, b: int) -> tuple[Array, NDArray[np.intp]]:
        rings, stations = [self._outer[a : b + 1]], [np.arange(a, b + 1)]
        for end in self._ends(a, b):
            at = np.array([a if end < 0 else b])
            rings += [self._outer[at], self._inner[at]]
            stations += [at, at]
        if self._is_hollow:
            rings.append(self._inner[a : b + 1])
            stations.append(np.arange(a, b + 1))
        across = np.concatenate(rings).reshape(-1, 2)
        return np.pad(across, ((0, 0), (1, 0))), np.repeat(np.concatenate(stations), CORNERS)

    def vertices(self, centres: Array, turns: Array) -> list[Array]:
        """Vertices (v, 3) of each band, from centres (stations, 3) and axes (stations, 3, 3)."""
        return [
            centres[station] + np.einsum("vij,vj->vi", turns[station], corner)
            for corner, station in self.corners
        ]


def strand(thing: Strand) -> tuple[Array, Triangles]:
    """Vertices and triangles of a strand's first shape; empty if it has breaks everywhere."""
    vertices, triangles = [np.zeros((0, 3))], [np.zeros((0, 3), np.uint32)]
    count = 0
    for run in runs(thing.points[0]):
        points = thing.points[0, run]
        corners, at, of_run = bar(len(run), float(thing.radius[0]))
        vertices.append(points[at] + np.einsum("vij,vj->vi", axes_along(points[None])[0, at], corners))
        triangles.append(of_run + np.uint32(count))
        count += len(corners)
    return np.concatenate(vertices), np.concatenate(triangles)


def runs(points: Array) -> Iterator[NDArray[np.intp]]:
    """Indices of the parts of a line (points, 3) between its breaks."""
    is_there = np.asarray(np.isfinite(points).all(axis=1), int)
    changes = np.flatnonzero(np.diff(is_there)) + 1
    for part in np.split(np.arange(len(points)), changes):
        if len(part) > 1 and bool(np.isfinite(points[part]).all()):
            yield part


def bar(count: int, radius: float) -> tuple[Array, NDArray[np.intp], Triangles]:
    """A round bar along points: vertices (v, 3) in the axes at the points, these points (v,), triangles."""
    angle = 2.0 * np.pi * np.arange(STRAND_CORNERS) / STRAND_CORNERS
    outline = radius * np.stack([np.zeros_like(angle), np.cos(angle), np.sin(angle)], axis=-1)
    # The ends have rings of their own, since their edges are sharp.
    at = np.concatenate([[0, 0], np.arange(count), [count - 1, count - 1]])
    rings = np.broadcast_to(outline, (len(at), *outline.shape)).copy()
    rings[[0, -1]] = 0.0
    return rings.reshape(-1, 3), np.repeat(at, STRAND_CORNERS), _wall(len(at), STRAND_CORNERS)


def pipe(points: Array, radius: float) -> tuple[Array, Triangles]:
    """The wall of a tube along points (k, 3), without its ends."""
    unit = 2.0 * np.pi * np.arange(CORNERS) / CORNERS
    ring = radius * np.stack([np.zeros_like(unit), np.cos(unit), np.sin(unit)], axis=-1)
    vertices = points[:, None] + np.einsum("kij,cj->kci", axes_along(points[None])[0], ring)
    return vertices.reshape(-1, 3), _wall(len(points), CORNERS)


def arrow(vector: Array, size: float) -> tuple[Array, Triangles]:
    """An arrow whose middle is the origin, with the head for models of a size."""
    length = float(np.linalg.norm(vector))
    head = min(arrows.HEAD * size, MOST_HEAD * length)
    shaft, wide = (radius * head / arrows.HEAD for radius in (arrows.SHAFT, arrows.HEAD_RADIUS))
    # Sharp edges have rings of their own.
    along = np.array([0.0, 0.0, 0.0, *[length - head] * 4, length])
    radius = np.array([0.0, shaft, shaft, shaft, shaft, wide, wide, 0.0])
    angle = 2.0 * np.pi * np.arange(STRAND_CORNERS) / STRAND_CORNERS
    across = radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    rings = np.concatenate([np.broadcast_to(along[:, None, None], (*across.shape[:2], 1)), across], axis=-1)
    rings[..., 0] -= 0.5 * length
    axes = axes_along(np.stack([np.zeros(3), vector])[None])[0, 0]
    return rings.reshape(-1, 3) @ axes.T, _wall(len(along), STRAND_CORNERS)


def axes_along(points: Array) -> Array:
    """Axes (shapes, points, 3, 3) along lines (shapes, points, 3): tangents first, the others turn least.

    In the first shape they turn least from point to point, afterwards from shape to shape.
    """
    along = np.diff(points, axis=1, prepend=points[:, :1], append=points[:, -1:])
    along = arrows.unit(along)
    along = arrows.unit(along[:, :-1] + along[:, 1:])
    first = np.empty_like(points)
    first[0, 0] = arrows.across(along[0, :1])[0]
    for k in range(1, points.shape[1]):
        first[0, k] = _turned_least(first[0, k - 1], along[0, k])
    for shape in range(1, len(points)):
        first[shape] = _turned_least(first[shape - 1], along[shape])
    return np.stack([along, first, np.cross(along, first)], axis=-1)


def _turned_least(vectors: Array, along: Array) -> Array:
    """Unit vectors (..., 3) perpendicular to `along`, close to others."""
    turned = vectors - np.sum(vectors * along, axis=-1, keepdims=True) * along
    length = np.linalg.norm(turned, axis=-1, keepdims=True)
    return np.where(length > TURNED_OVER, turned / np.maximum(length, TURNED_OVER), arrows.across(along))


def capsule(start: Array, end: Array, radius: float) -> tuple[Array, Triangles]:
    """Two half balls and the wall between them."""
    unit, _ = _ball(CORNERS)
    axes = axes_along(np.stack([start, end])[None])[0, 0]
    # Poles are along x; the circle in the middle belongs to both halves, but for the wall between them.
    middle = len(unit) // 2 - CORNERS // 2
    rings = np.concatenate([unit[: middle + CORNERS], unit[middle:]])
    centres = np.repeat([start, end], [middle + CORNERS, len(unit) - middle], axis=0)
    return radius * rings @ axes.T + centres, _wall(len(rings) // CORNERS, CORNERS)


def convex(points: Array, faces: Triangles) -> tuple[Array, Triangles]:
    """A convex body with flat faces, which have corners of their own, and sharp edges."""
    corners = points[_outwards(points, faces)[0]]
    return corners.reshape(-1, 3), np.arange(3 * len(faces), dtype=np.uint32).reshape(-1, 3)


def rounded(points: Array, faces: Triangles, radius: float) -> tuple[Array, Triangles]:
    """A convex body with a ball of this radius around each of its points.

    Its faces, moved outwards; parts of cylinders along its edges; parts of balls at its corners.
    """
    faces, normals = _outwards(points, faces)
    vertices = [(points[faces] + radius * normals[:, None]).reshape(-1, 3)]
    triangles = [np.arange(3 * len(faces), dtype=np.uint32).reshape(-1, 3)]
    #: The face to the left of each edge, and the next corner of that face.
    left = {(f[k], f[k - 2]): (i, f[k - 1]) for i, f in enumerate(faces.tolist()) for k in range(3)}
    part = np.linspace(0.0, 1.0, ROUND + 1)[:, None]

    def across(a: int, b: int) -> Array:
        """Directions from the normal to the left of an edge to that to its right."""
        return arrows.unit((1.0 - part) * normals[left[a, b][0]] + part * normals[left[b, a][0]])

    def add(rings: Array, is_closed: bool) -> None:
        first = sum(map(len, vertices))
        vertices.append(rings.reshape(-1, 3))
        corners = rings.shape[1]
        wall = _wall(len(rings), corners, first, is_inner=is_closed)
        # An open strip lacks the wall from its last corner to its first.
        triangles.append(
            wall if is_closed else wall.reshape(len(rings) - 1, corners, 2, 3)[:, :-1].reshape(-1, 3)
        )

    for a, b in left:
        if a < b:
            add(np.stack([points[end] + radius * across(a, b) for end in (a, b)]), is_closed=False)
    starts = dict(left.keys())
    for a, start in starts.items():
        # Around the corner, from face to face.
        around, b = [across(a, start)[:-1]], left[start, a][1]
        while b != start:
            around.append(across(a, b)[:-1])
            b = left[b, a][1]
        edge = np.concatenate(around)
        inwards = (1.0 - part[:, None]) * edge + part[:, None] * arrows.unit(edge.sum(axis=0))
        add(points[a] + radius * arrows.unit(inwards), is_closed=True)
    return np.concatenate(vertices), np.concatenate(triangles)


def _outwards(points: Array, faces: Triangles) -> tuple[Triangles, Array]:
    """Faces of a convex body, anticlockwise seen from outside, and their unit normals."""
    a, b, c = (points[corner] for corner in faces.T)
    normals = arrows.unit(np.cross(b - a, c - a))
    is_inwards = np.einsum("fi,fi->f", normals, (a + b + c) / 3.0 - points.mean(axis=0)) < 0.0
    faces = np.where(is_inwards[:, None], faces[:, ::-1], faces)
    return faces, np.where(is_inwards[:, None], -normals, normals)


def grid(points: Array) -> tuple[Array, Triangles]:
    """A surface through a grid of points (k, l, 3).

    Seen from outside, the second direction is to the left of the first.
    """
    rows, columns = points.shape[:2]
    number = np.arange(rows * columns, dtype=np.uint32).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    triangles = np.stack([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)], axis=2)
    return points.reshape(-1, 3), triangles.reshape(-1, 3)
