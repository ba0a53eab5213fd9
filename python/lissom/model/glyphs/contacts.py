"""Geometry and forces of contacts, for drawings and plots: obstacles, and balls and shapes on links.

Plain geometry and numbers, as functions of coordinates and time; reports decide how they look.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..._lissom import Robot, centre_line
from ..contacts import (
    Ball,
    Box,
    Capsule,
    Contact,
    ConvexMesh,
    DistanceGrid,
    HalfSpace,
    HeightField,
    Mesh,
    Sphere,
    Touch,
    Tube,
)
from .isosurface import isosurface
from .joints import Pose

Array = NDArray[np.float64]

#: Display names of shapes.
WORDS = {
    HalfSpace: "a half space",
    Sphere: "a sphere",
    Capsule: "a capsule",
    Box: "a box",
    HeightField: "a height field",
    ConvexMesh: "a convex mesh",
    Tube: "a tube",
    DistanceGrid: "a distance grid",
    Mesh: "a mesh",
}

Obstacle = HalfSpace | Sphere | Capsule | Box | HeightField | ConvexMesh | Tube | DistanceGrid | Mesh

#: Maximum number of lines along each axis in drawings of a height field.
MOST_LINES = 60

#: Separator between polylines.
BREAK = np.full((1, 3), np.nan)


@dataclass(frozen=True)
class ContactGlyph:
    """A pair of surfaces that can touch."""

    name: str
    #: Description of the pair.
    between: str
    #: The obstacle fixed in the world, if one of the two is.
    obstacle: Obstacle | None
    #: Poses of the centres of the balls of the pair that are on links, and their radii, metres.
    balls: Sequence[tuple[Pose, float]]
    #: Shapes of the pair that are on links, and the poses of the axes in which they are given.
    shapes: Sequence[tuple[Obstacle, Pose]]
    #: Force on the first surface in world axes, (k, 3), newtons, for (k, n) coordinates and velocities and
    #: (k,) times.
    force: Callable[[Array, Array, Array], Array]


@dataclass(frozen=True)
class Touching:
    """All contact pairs of a robot."""

    pairs: Sequence[ContactGlyph] = ()
    #: Touching places, for (n,) coordinates and velocities, and a time.
    touches: Callable[[Array, Array, float], Sequence[Touch]] | None = None


#: A robot without contacts.
NOTHING_TOUCHES: Touching = Touching()


def contact_glyphs(robot: Robot) -> Touching:
    """Glyphs of all contacts of a robot."""
    if not robot.contacts:
        return NOTHING_TOUCHES
    return Touching([_glyph(robot, contact) for contact in robot.contacts], partial(_touches, robot))


def turn_of(orientation: Sequence[float]) -> Array:
    """The rotation matrix of a unit quaternion."""
    w, a, b, c = orientation
    cross = np.array([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    turn: Array = np.eye(3) + 2 * w * cross + 2 * cross @ cross
    return turn


def ground(obstacle: HeightField) -> Array:
    """Grid points of a height field, (k, l, 3), metres."""
    heights = np.asarray(obstacle.heights, float)
    spacing = np.broadcast_to(obstacle.spacing, 2)
    x, y = (step * np.arange(number) for step, number in zip(spacing, heights.shape, strict=True))
    grid = np.stack([*np.meshgrid(x, y, indexing="ij"), heights], axis=-1)
    placed: Array = np.asarray(obstacle.corner, float) + grid @ turn_of(obstacle.orientation).T
    return placed


def outline(obstacle: HeightField | ConvexMesh | Tube) -> Array:
    """Lines (points, 3) on a surface, with NaN between them, metres: through heights, or along edges.

    Of a tube it is the centre line.
    """
    if isinstance(obstacle, Tube):
        return centre_line(obstacle.points)
    if isinstance(obstacle, ConvexMesh):
        corners = np.sort(np.asarray(obstacle.faces, int), axis=1)
        edges = np.unique(np.concatenate([corners[:, pair] for pair in ([0, 1], [1, 2], [0, 2])]), axis=0)
        ends = np.asarray(obstacle.points, float)[edges]
        return np.concatenate([part for pair in ends for part in (pair, BREAK)][:-1])
    grid = ground(obstacle)
    lines: list[Array] = []
    for rows in (grid, np.swapaxes(grid, 0, 1)):
        some = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), MOST_LINES)).round().astype(int))
        lines += [part for row in rows[some] for part in (row, BREAK)]
    return np.concatenate(lines[:-1])


def skin(obstacle: DistanceGrid | Mesh) -> tuple[Array, NDArray[np.int64]]:
    """Corners (v, 3), metres, and triangles (m, 3) of a surface, anticlockwise seen from outside."""
    if isinstance(obstacle, Mesh):
        points, faces = np.asarray(obstacle.points, float), np.asarray(obstacle.faces, np.int64)
        a, b, c = (points[corner] for corner in faces.T)
        is_inwards = np.einsum("fi,fi->", a, np.cross(b, c)) < 0.0
        return points, faces[:, ::-1] if is_inwards else faces
    points, faces = isosurface(np.asarray(obstacle.values, float), obstacle.spacing)
    return np.asarray(obstacle.corner, float) + points @ turn_of(obstacle.orientation).T, faces


def _touches(robot: Robot, q: Array, v: Array, t: float) -> Sequence[Touch]:
    return robot.touches(q, v, t=t)


def _glyph(robot: Robot, contact: Contact) -> ContactGlyph:
    def force(q: Array, v: Array, t: Array) -> Array:
        return np.asarray(robot.contact_forces(q, v, name=contact.name, t=t), float)[..., 3:]

    surfaces = (contact.a, contact.b)
    others = [surface for surface in surfaces if not isinstance(surface, str | Ball)]
    obstacle = next((shape for shape in others if shape.link is None), None)
    balls = [(partial(_ball, robot, ball), ball.radius) for ball in surfaces if isinstance(ball, Ball)]
    shapes = [(shape, partial(_axes, robot, shape)) for shape in others if shape.link is not None]
    between = " and ".join(_word(surface) for surface in surfaces)
    return ContactGlyph(contact.name, between, obstacle, balls, shapes, force)


def _word(surface: object) -> str:
    if isinstance(surface, Ball):
        return f"a ball on {surface.link}"
    if isinstance(surface, str):
        return surface
    word = WORDS[type(surface)]
    link = getattr(surface, "link", None)
    return word if link is None else f"{word} on {link}"


def _ball(robot: Robot, ball: Ball, q: Array, t: float | Array) -> Array:
    """Poses of the centre of a ball."""
    beside = np.eye(4)
    beside[:3, 3] = ball.position
    return robot.pose(q, ball.at, link=ball.link, t=t) @ beside


def _axes(robot: Robot, shape: Obstacle, q: Array, t: float | Array) -> Array:
    """Poses of the axes in which a shape on a link is given."""
    return robot.pose(q, shape.at, link=shape.link, t=t)
