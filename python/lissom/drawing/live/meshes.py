"""Meshes: vertices and triangles of rods with their true sections, and of bars between points."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..report import arrows
from ..report.layers import Strand, Tube

Array = NDArray[np.float64]
Triangles = NDArray[np.uint32]

#: Number of corners of a section: six per side of a rectangle, whose edges are sharp.
CORNERS = 24
STRAND_CORNERS = 10

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
    y, z = np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle)
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

    def __init__(self, tube: Tube) -> None:
        stations = len(tube.stations)
        ends = np.unique(np.linspace(0, stations - 1, min(BANDS, stations - 1) + 1).round().astype(int))
        #: First and last station of each band.
        self.bands = list(zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True))
        #: Positions of the middles of the bands along the rod, from 0 to 1.
        self.middles = 0.5 * (ends[:-1] + ends[1:]) / (stations - 1)
        outline = np.stack([OUTLINES[bool(is_square)] for is_square in tube.square])
        self._outer = outline * tube.half[:, None]
        self._inner = self._outer * np.minimum(tube.hole, 0.999)[:, None, None]
        self._is_hollow = bool(np.any(tube.hole > 0.0))
        self.triangles = [self._triangles(a, b) for a, b in self.bands]

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

    def vertices(self, centres: Array, turns: Array) -> list[Array]:
        """Vertices (v, 3) of each band, from centres (stations, 3) and axes (stations, 3, 3)."""
        outer = _placed(self._outer, centres, turns)
        inner = _placed(self._inner, centres, turns)
        found = []
        for a, b in self.bands:
            parts = [outer[a : b + 1]]
            for end in self._ends(a, b):
                at = a if end < 0 else b
                parts += [outer[at : at + 1], inner[at : at + 1]]
            if self._is_hollow:
                parts.append(inner[a : b + 1])
            found.append(np.concatenate(parts).reshape(-1, 3))
        return found


def _placed(outline: Array, centres: Array, turns: Array) -> Array:
    """Corners (stations, corners, 3) in the world."""
    across = turns[:, :, 1:]
    return np.asarray(centres[:, None] + np.einsum("kcj,kij->kci", outline, across))


def strand(thing: Strand) -> tuple[Array, Triangles]:
    """Vertices and triangles of a strand's first shape; empty if it has breaks everywhere."""
    radius = float(thing.radius[0])
    vertices, triangles = [np.zeros((0, 3))], [np.zeros((0, 3), np.uint32)]
    count = 0
    for run in _runs(thing.points[0]):
        rings = _rings(run, radius)
        vertices.append(rings.reshape(-1, 3))
        triangles.append(_wall(len(rings), STRAND_CORNERS, count))
        count += len(rings) * STRAND_CORNERS
    return np.concatenate(vertices), np.concatenate(triangles)


def _runs(points: Array) -> Iterator[Array]:
    """The parts of a line between its breaks."""
    is_there = np.asarray(np.isfinite(points).all(axis=1), int)
    changes = np.flatnonzero(np.diff(is_there)) + 1
    for part in np.split(np.arange(len(points)), changes):
        if len(part) > 1 and bool(np.isfinite(points[part]).all()):
            yield points[part]


def _rings(points: Array, radius: float) -> Array:
    """Closed rings (rings, corners, 3) around a line, with minimal rotation of the corners."""
    along = arrows.unit(np.diff(points, axis=0, prepend=points[:1], append=points[-1:]))
    along = arrows.unit(along[:-1] + along[1:])
    first = np.empty_like(points)
    first[0] = arrows.across(along[:1])[0]
    for k in range(1, len(points)):
        turned = first[k - 1] - (first[k - 1] @ along[k]) * along[k]
        first[k] = turned / (np.sqrt(turned @ turned) or 1.0)
    angle = 2.0 * np.pi * np.arange(STRAND_CORNERS) / STRAND_CORNERS
    outline = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    sides = np.stack([first, np.cross(along, first)], axis=1)
    rings = points[:, None] + radius * np.einsum("cj,kji->kci", outline, sides)
    at = np.broadcast_to(points[:, None], rings.shape)
    return np.concatenate([at[:1], rings, at[-1:]])
