"""Contacts in reports: obstacles, balls and shapes on links, and contact forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..._lissom import LissomError
from ...model.contacts import Box, ConvexMesh, DistanceGrid, HalfSpace, HeightField, Mesh, Sphere, Touch, Tube
from ...model.glyphs.contacts import WORDS, ContactGlyph, Obstacle, Touching, outline, skin, turn_of
from ...results.runs import Made, Run
from . import arrows, curves, layers, plots, theme, visuals
from .layers import Dots, DrawnStates, Line, Solid, Strand, Thing, quaternions

Array = NDArray[np.float64]

LAYERS: dict[str, str] = {"obstacles": theme.STEEL, "balls": theme.ORANGE, "shapes": theme.ORANGE}

#: Opacity of obstacles: what moves behind or inside them is seen.
OPACITY = 0.5

#: Half the thickness of the plate that represents a half space, and its margin around the scene, relative to
#: the size of the scene.
PLATE, BEYOND = 0.004, 0.08

#: Thickness of the edges of moving shapes, relative to the size of the model.
EDGE = 0.003

#: Length of the arrow of a large force, relative to the model's size.
ARROW = 0.22

#: Arrows have their full length from this quantile of the largest forces over all shapes: with the maximum
#: instead, impacts would make all other arrows invisibly short.
LARGE = 0.9

#: Balls are the same if sizes and places differ by less than this part of the radius.
SAME = 0.01

#: Maximum number of arrows per shape; beyond, neighbours along a rod are merged.
MOST_ARROWS = 12

#: Maximum number of instants at which forces are plotted: more than for other curves, because impacts are
#: short.
INSTANTS = 2000


def contacts(
    touching: Touching, shown: DrawnStates, low: Array, high: Array, drawn: Sequence[Thing] = ()
) -> list[Thing]:
    """All objects drawn for contacts within a box around the motion, beside what is drawn already."""
    things: list[Thing] = []
    for name, shape, poses in shapes(touching, shown.q, shown.t):
        if poses is None:
            around = _obstacle(name, shape, low, high)
            things += [
                thing if isinstance(thing, Line) else replace(thing, opacity=OPACITY) for thing in around
            ]
        else:
            things += _moving(name, shape, poses, shown.size)
    return [*things, *balls(touching, shown.q, shown.t, drawn), *_forces(touching, shown)]


def shapes(touching: Touching, q: Array, t: Array) -> list[tuple[str, Obstacle, Array | None]]:
    """Names, obstacles and shapes on links, each once, and the poses (k, 4, 4) of what carries them."""
    found: list[tuple[str, Obstacle, Array | None]] = []

    def is_new(shape: Obstacle) -> bool:
        return all(shape != other for _, other, _ in found)

    for glyph in touching.pairs:
        if glyph.obstacle is not None and is_new(glyph.obstacle):
            found.append((glyph.name, glyph.obstacle, None))
        for shape, pose in glyph.shapes:
            if is_new(shape):
                name = f"{WORDS[type(shape)]} on {shape.link}"
                found.append((name, shape, np.broadcast_to(pose(q, t), (len(q), 4, 4))))
    return found


def balls(touching: Touching, q: Array, t: Array, drawn: Sequence[Thing] = ()) -> list[Dots]:
    """Balls on links, each once: neither again for another contact nor over a body of the same size."""
    found: list[Dots] = []
    for glyph in touching.pairs:
        for pose, radius in glyph.balls:
            places = np.broadcast_to(pose(q, t), (len(q), 4, 4))[:, None, :3, 3]
            if not any(_is_there(thing, places, radius) for thing in (*drawn, *found)):
                found.append(Dots([f"ball of {glyph.name}"], "balls", places, radius))
    return found


def _is_there(thing: Thing, places: Array, radius: float) -> bool:
    """Whether something is drawn as a ball of this size at these places."""
    if isinstance(thing, Dots) and thing.layer == "balls":
        size, centres = np.array([thing.radius]), thing.points
    elif isinstance(thing, Solid) and thing.form == "ellipsoid":
        size, centres = np.asarray(thing.size), thing.centres[:, None]
    else:
        return False
    apart = np.nanmax(np.abs(centres - places), initial=0.0)
    return bool(np.all(np.abs(size - radius) <= SAME * radius) and apart <= SAME * radius)


def _obstacle(
    name: str, obstacle: Obstacle, low: Array, high: Array
) -> Sequence[Solid | Dots | Strand | Line | layers.Mesh]:
    if isinstance(obstacle, HalfSpace):
        return [plate(name, obstacle, low, high)]
    if isinstance(obstacle, Box):
        turns = np.asarray([obstacle.orientation], float)
        half = np.asarray(obstacle.half_extents, float)
        return [Solid(name, "obstacles", "box", half, np.asarray([obstacle.centre], float), turns)]
    if isinstance(obstacle, Sphere):
        return [Dots([name], "obstacles", np.asarray([[obstacle.centre]], float), obstacle.radius)]
    if isinstance(obstacle, Tube):
        return [Strand(name, "obstacles", outline(obstacle)[None], np.array([obstacle.radius]))]
    if isinstance(obstacle, DistanceGrid | Mesh):
        return [_skin(name, "obstacles", obstacle, np.eye(4)[None])]
    if isinstance(obstacle, HeightField | ConvexMesh):
        points = outline(obstacle)[None]
        if isinstance(obstacle, ConvexMesh) and obstacle.radius > 0.0:
            return [Strand(name, "obstacles", points, np.array([obstacle.radius]))]
        return [Line(name, "obstacles", points)]
    ends = np.asarray([[obstacle.start, obstacle.end]], float)
    radius = np.array([obstacle.radius])
    return [
        Strand(name, "obstacles", ends, radius),
        Dots([name, name], "obstacles", ends, obstacle.radius),
    ]


def _moving(name: str, shape: Obstacle, poses: Array, size: float) -> list[Thing]:
    """A shape on a link, whose axes have the poses (shapes, 4, 4)."""
    turns, places = poses[:, :3, :3], poses[:, :3, 3]

    def placed(points: Array) -> Array:
        moved: Array = np.einsum("kij,pj->kpi", turns, np.asarray(points, float)) + places[:, None]
        return moved

    layer = "shapes"
    if isinstance(shape, HalfSpace):
        cut = plate(name, shape, *(np.asarray(shape.point) + 0.5 * side * size for side in (-1, 1)))
        w, x, y, z = cut.turns[0]
        centre, own, half = cut.centres, turn_of((w, x, y, z)), cut.size
    elif isinstance(shape, Box):
        centre, own, half = (
            np.array([shape.centre]),
            turn_of(shape.orientation),
            np.array(shape.half_extents),
        )
    elif isinstance(shape, Sphere):
        return [Dots([name], layer, placed(np.array([shape.centre])), shape.radius)]
    elif isinstance(shape, Tube):
        return [Strand(name, layer, placed(outline(shape)), np.array([shape.radius]), opacity=OPACITY)]
    elif isinstance(shape, DistanceGrid | Mesh):
        return [_skin(name, layer, shape, poses)]
    elif isinstance(shape, HeightField | ConvexMesh):
        radius = max(getattr(shape, "radius", 0.0), EDGE * size)
        return [Strand(name, layer, placed(outline(shape)), np.array([radius]))]
    else:
        ends = placed(np.array([shape.start, shape.end]))
        bar = Strand(name, layer, ends, np.array([shape.radius]))
        return [bar, Dots([name, name], layer, ends, shape.radius)]
    return [Solid(name, layer, "box", half, placed(centre)[:, 0], quaternions(turns @ own))]


def _skin(name: str, layer: str, shape: DistanceGrid | Mesh, poses: Array) -> layers.Mesh:
    """The surface of a shape whose axes have the poses (shapes, 4, 4)."""
    corners, faces, normals = visuals.creased(*skin(shape))
    centres, turns = poses[:, :3, 3], quaternions(poses[:, :3, :3])
    is_open = not visuals.is_closed(corners, faces)
    return layers.Mesh(name, layer, corners, normals, faces, centres, turns, is_open=is_open)


def plate(name: str, floor: HalfSpace, low: Array, high: Array) -> Solid:
    """A plate whose upper side lies in the plane, below a box."""
    normal = np.asarray(floor.normal, float)
    normal = normal / np.linalg.norm(normal)
    # Align its sides with the world axes as far as possible.
    first = np.eye(3)[np.argmin(np.abs(normal))]
    first = arrows.unit(first - (first @ normal) * normal)
    axes = np.stack([first, np.cross(normal, first), normal], axis=1)
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
    from_plane = (corners - np.asarray(floor.point, float)) @ axes
    size = float(np.linalg.norm(high - low))
    least, most = from_plane.min(axis=0) - BEYOND * size, from_plane.max(axis=0) + BEYOND * size
    half = np.array([*(0.5 * (most - least)[:2]), PLATE * size])
    middle = np.array([*(0.5 * (most + least)[:2]), -PLATE * size])
    centre = np.asarray(floor.point, float) + axes @ middle
    return Solid(name, "obstacles", "box", half, centre[None], quaternions(axes[None]))


def _forces(touching: Touching, shown: DrawnStates) -> list[Thing]:
    """Arrows of the forces on the first surfaces, starting at the contact points."""
    if touching.touches is None:
        return []
    places: list[Array] = []
    for q, v, t in zip(shown.q, shown.v, np.broadcast_to(shown.t, len(shown.q)), strict=True):
        try:
            places.append(_merged(touching.touches(q, v, float(t))))
        except (ValueError, LissomError):
            # The last state of a failed run can overflow.
            places.append(np.zeros((0, 2, 3)))
    number = max(len(of_shape) for of_shape in places)
    if number == 0:
        return []
    found = np.zeros((len(places), number, 2, 3))
    for of_shape, place in zip(found, places, strict=True):
        # Missing arrows have zero length, at the position of an existing one.
        of_shape[:, 0] = place[0, 0] if len(place) else _any_place(places)
        of_shape[: len(place)] = place
    sizes = np.linalg.norm(found[:, :, 1], axis=-1)
    largest = sizes.max(axis=1)
    large = float(np.quantile(largest[largest > 0.0], LARGE)) if largest.any() else 0.0
    large = float(shown.largest.of("contact", large)) or 1.0
    length = ARROW * shown.size * np.minimum(sizes / large, 1.0)
    vectors = arrows.unit(found[:, :, 1]) * length[..., None]
    names = ["force of contact"] * number
    return [arrows.arrows("contact", found[:, :, 0], vectors, ARROW * shown.size, names)]


def _any_place(places: Sequence[Array]) -> Array:
    """Position of any contact point."""
    return next(np.asarray(of_shape[0, 0]) for of_shape in places if len(of_shape))


def _merged(touches: Sequence[Touch]) -> Array:
    """Positions and forces (arrows, 2, 3) of contact points, with neighbours merged if there are many."""
    if not touches:
        return np.zeros((0, 2, 3))
    merged = []
    for part in np.array_split(np.arange(len(touches)), min(len(touches), MOST_ARROWS)):
        forces = np.array([touches[i].force for i in part])
        positions = np.array([touches[i].position for i in part])
        weights = np.linalg.norm(forces, axis=1) + 1e-300
        merged.append([weights @ positions / weights.sum(), forces.sum(axis=0)])
    return np.array(merged)


def forces(run: Run | Made, glyph: ContactGlyph) -> plots.Figure | None:
    """Normal force and friction of a contact over time; None if they are unknown."""
    at = run.instants(INSTANTS)
    t = run.t[at]
    try:
        pressed = glyph.force(run.q[at], run.v[at], t)
    except (ValueError, LissomError):
        # The last state of a failed run can overflow.
        return None
    return curves.stacked(t, {"force (N)": list(zip("xyz", pressed.T, strict=True))})
