"""Parts of a model as polygons in a plane: which of them are seen, in which colour, and which hides which.

They are painted from the farthest to the nearest. Where a model is shown in several shapes, later ones are
painted over earlier ones, as if each were nearer; obstacles are translucent, and dim what is behind them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .parts import STRANDS, Part
from .report import contacts

Array = NDArray[np.float64]

#: Share of white in the first of several shapes.
PALEST = 0.7

#: Light on surfaces that face away from it, and its direction: to the right, upwards, to the viewer.
SHADE, LIGHT = 0.5, np.array([-0.35, 0.55, 0.76])

#: Larger triangles are cut, relative to the diagonal of the figure: they are sorted by their middles.
LARGEST = 0.04

#: Depth inside an obstacle up to which triangles are not hidden, relative to the longest sides of triangles.
TOUCHING = 0.25

#: Width of the edges of polygons, points: they cover the seams between neighbours, also at the 120 pixels per
#: inch of films.
HAIR = 0.4

#: Rounding of the place of a point in a triangle, and of depths relative to the sides of triangles.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Triangles:
    """Corners (m, 3, 3) in the axes of the figure, the third towards the viewer, and colours (m, 4)."""

    corners: Array
    colours: Array
    #: Whether each (m,) belongs to something inside a rod, and is painted before the wall over it.
    is_inside: NDArray[np.bool_]
    #: Depth (m,) up to which what is behind each counts as before it, metres; NaN where the size of triangles
    #: says it.
    margin: Array

    def of(self, chosen: Any) -> Triangles:
        """Those at indices, or where a mask is true."""
        of_each = (self.corners, self.colours, self.is_inside, self.margin)
        return Triangles(*(values[chosen] for values in of_each))


def view_axes(towards: Array, up: Array) -> Array:
    """Axes of a figure as rows: to the right, upwards, to the viewer, who is in a direction."""
    towards = towards / np.linalg.norm(towards)
    if abs(towards @ up) > 1.0 - 1e-9:
        # Seen from above or below: the next axis is up.
        up = np.roll(np.abs(up), -1)
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(towards, right), towards])


def triangles(found: Sequence[Part], axes: Array, shapes: Iterable[int] | None = None) -> Triangles:
    """All triangles that face the viewer, in the order in which they are painted.

    `shapes` are those that are shown, the last one in full colours; all by default.
    """
    shown = list(range(len(found[0].centres)) if shapes is None else shapes)
    still = [_facing(part, shown[0], axes, 0.0) for part in found if part.layer == "obstacles"]
    moving = []
    for place, k in enumerate(shown):
        pale = PALEST * (1.0 - place / (len(shown) - 1)) if len(shown) > 1 else 0.0
        moving.append([_facing(part, k, axes, pale) for part in found if part.layer != "obstacles"])
    every = np.concatenate([part.corners.reshape(-1, 3) for part in sum(moving, still)])
    most = LARGEST * float(np.linalg.norm(np.ptp(every, axis=0)))
    obstacles = _cut(_joined(still), most)
    painted = [_cut(_joined(of_shape), most) for of_shape in moving]
    # Obstacles are painted after the last shape that they hide somewhere, but not over what is before them.
    after, is_free = np.full(len(obstacles.corners), -1), np.ones(len(obstacles.corners), bool)
    for place, of_shape in enumerate(painted):
        hides, is_hidden = _hiding(obstacles, of_shape.corners, most)
        is_free &= ~is_hidden
        after[hides & is_free] = place
    order = np.concatenate([after + 0.5, *(np.full(len(part.corners), k) for k, part in enumerate(painted))])
    together = _joined([obstacles, *painted])
    # The middle of a wall over a tendon may be farther than that of the tendon, by the size of a triangle.
    depth = together.corners[..., 2].mean(axis=1) - most * together.is_inside
    depth[: len(after)] = _of_faces(depth[: len(after)], after, obstacles.colours)
    return together.of(np.lexsort([depth, order]))


def _of_faces(depth: Array, after: NDArray[np.intp], colours: Array) -> Array:
    """Mean depths per colour: the pieces of a cut face follow each other, and become one polygon."""
    if not len(depth):
        return depth
    _, face = np.unique(np.column_stack([after, colours]), axis=0, return_inverse=True)
    face = face.reshape(-1)
    return np.asarray((np.bincount(face, depth) / np.bincount(face))[face])


def _facing(part: Part, shape: int, axes: Array, pale: float) -> Triangles:
    """The triangles of a part that face the viewer, in the light."""
    base = part.colour
    colour = np.array([int(base[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    corners = (part.vertices(shape) @ axes.T)[part.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    # What is in a bore is behind the near wall and before the far one, also where it presses into them.
    margin = (
        0.5 * part.wall * np.where(normal[:, 2] > 0.0, -1.0, 1.0)
        if part.wall
        else np.full(len(normal), np.nan)
    )
    if part.is_open:
        normal *= np.where(normal[:, 2:] < 0.0, -1.0, 1.0)
    is_seen = normal[:, 2] > 0.0
    light = SHADE + (1.0 - SHADE) * np.maximum(normal[is_seen] @ LIGHT, 0.0)
    shaded = (light[:, None] * colour) * (1.0 - pale) + pale
    opacity = contacts.OPACITY if part.layer == "obstacles" else part.opacity
    colours = np.column_stack([shaded, np.full(len(shaded), opacity)])
    return Triangles(corners[is_seen], colours, np.full(len(shaded), part.layer in STRANDS), margin[is_seen])


def _joined(several: Sequence[Triangles]) -> Triangles:
    return Triangles(
        np.concatenate([np.zeros((0, 3, 3)), *(part.corners for part in several)]),
        np.concatenate([np.zeros((0, 4)), *(part.colours for part in several)]),
        np.concatenate([np.zeros(0, bool), *(part.is_inside for part in several)]),
        np.concatenate([np.zeros(0), *(part.margin for part in several)]),
    )


def _cut(whole: Triangles, most: float) -> Triangles:
    """Triangles whose longest sides are halved until they are short."""
    done: list[Triangles] = []
    while len(whole.corners):
        sides = np.linalg.norm(np.roll(whole.corners, -1, axis=1) - whole.corners, axis=-1)
        is_short = sides.max(axis=1) <= most
        done.append(whole.of(is_short))
        whole, longest = whole.of(~is_short), sides[~is_short].argmax(axis=1)
        rows = np.arange(len(longest))
        a, b, c = (whole.corners[rows, (longest + i) % 3] for i in range(3))
        middle = 0.5 * (a + b)
        halves = [np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)]
        whole = _joined([replace(whole, corners=half) for half in halves])
    return _joined(done)


class _Grid:
    """Squares of a grid in the plane, with numbers, around points (..., 3)."""

    def __init__(self, points: Array, side: float) -> None:
        flat = points.reshape(-1, points.shape[-1])[:, :2]
        self._low, self._side = flat.min(axis=0), side
        columns, rows = ((flat.max(axis=0) - self._low) // side).astype(int) + 1
        self._strides = np.array([1, columns])
        self.size = int(columns * rows)

    def of(self, points: Array) -> NDArray[np.intp]:
        """The squares (...) of points (..., 3)."""
        return np.asarray(((points[..., :2] - self._low) // self._side).astype(int) @ self._strides)

    def of_triangles(self, corners: Array) -> NDArray[np.intp]:
        """The squares (4, m) in which triangles (m, 3, 3) can lie, which are no larger than these."""
        ends = (corners[..., :2].min(axis=1), corners[..., :2].max(axis=1))
        return np.stack([self.of(np.stack([x[:, 0], y[:, 1]], axis=-1)) for x in ends for y in ends])


def _hiding(walls: Triangles, shape: Array, side: float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which triangles of obstacles are before and behind triangles (n, 3, 3) of a shape somewhere.

    They are before all of it in one of their squares, or before or behind it at the middle of one of both; no
    side is longer than `side`. Parts that reach a little into an obstacle count as before it.
    """
    obstacles = walls.corners
    is_before, is_behind = np.zeros((2, len(obstacles)), bool)
    if not len(obstacles) or not len(shape):
        return is_before, is_behind
    least = np.where(np.isnan(walls.margin), TOUCHING * side, walls.margin)
    most = np.minimum(least, -ROUNDING * side)
    grid = _Grid(np.concatenate([obstacles, shape]), side)
    front = np.full(grid.size, np.inf)
    of_shape = grid.of_triangles(shape)
    front[of_shape] = shape[..., 2].min()
    # `at` of NumPy 2.4 reads beyond values that it has to repeat.
    np.maximum.at(front, of_shape.reshape(-1), np.tile(shape[..., 2].max(axis=1), len(of_shape)))
    is_before |= (obstacles[..., 2].min(axis=1) > front[grid.of_triangles(obstacles)]).any(axis=0)
    point, triangle, depth = _over(shape.mean(axis=1), obstacles, side)
    over = depth - shape.mean(axis=1)[point, 2]
    is_before[triangle[over > least[triangle]]] = True
    is_behind[triangle[over < most[triangle]]] = True
    point, triangle, depth = _over(obstacles.mean(axis=1), shape, side)
    over = obstacles.mean(axis=1)[point, 2] - depth
    is_before[point[over > least[point]]] = True
    is_behind[point[over < most[point]]] = True
    return is_before, is_behind


def _over(
    points: Array, corners: Array, side: float
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
    """Pairs of points (p, 3) and triangles (m, 3, 3) over each other, with the depths of the triangles there.

    Points meet only triangles of their square of a grid: its squares are as large as the longest sides, so
    that a triangle lies in at most four.
    """
    grid = _Grid(np.concatenate([points, corners.reshape(-1, 3)]), side)
    squares, of_corners = grid.of(points), grid.of_triangles(corners).reshape(-1)
    number = np.tile(np.arange(len(corners)), 4)
    by_square = np.argsort(of_corners, kind="stable")
    begin, end = (np.searchsorted(of_corners[by_square], squares, where) for where in ("left", "right"))
    count = end - begin
    point = np.repeat(np.arange(len(points)), count)
    within = np.arange(len(point)) - np.repeat(np.cumsum(count) - count, count)
    triangle = number[by_square[np.repeat(begin, count) + within]]
    a, b, c = (corners[triangle, i] for i in range(3))
    to_b, to_c, to_point = b - a, c - a, points[point] - a
    area = to_b[:, 0] * to_c[:, 1] - to_b[:, 1] * to_c[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        # Barycentric coordinates; edges on, triangles have none.
        s = (to_point[:, 0] * to_c[:, 1] - to_point[:, 1] * to_c[:, 0]) / area
        t = (to_b[:, 0] * to_point[:, 1] - to_b[:, 1] * to_point[:, 0]) / area
        is_over = (s >= -ROUNDING) & (t >= -ROUNDING) & (s + t <= 1.0 + ROUNDING)
        depth = a[:, 2] + s * to_b[:, 2] + t * to_c[:, 2]
    return point[is_over], triangle[is_over], depth[is_over]


def polygons(drawn: Triangles) -> Any:
    """The triangles as a collection of Matplotlib."""
    from matplotlib.collections import PathCollection, PolyCollection
    from matplotlib.path import Path

    # Edges in the colour of the faces close the gaps that viewers leave between neighbours.
    edges = np.where(drawn.colours[:, 3:] < 1.0, 0.0, drawn.colours)
    # Of an array paths are made at once.
    flat: Any = drawn.corners[..., :2]
    options: Any = {"linewidths": HAIR, "snap": False}
    every = PolyCollection(flat, facecolors=drawn.colours, edgecolors=edges, **options)
    # Translucent neighbours of one colour are one polygon: edges would be seen, and so would gaps.
    is_next = (np.diff(drawn.colours, axis=0) == 0.0).all(axis=1) & (drawn.colours[1:, 3] < 1.0)
    if not is_next.any():
        return every
    first = np.flatnonzero(np.concatenate([[True], ~is_next])).tolist()
    paths = every.get_paths()
    joined = [
        paths[a] if b == a + 1 else Path.make_compound_path(*paths[a:b])
        for a, b in zip(first, [*first[1:], len(paths)], strict=True)
    ]
    return PathCollection(joined, facecolors=drawn.colours[first], edgecolors=edges[first], **options)
