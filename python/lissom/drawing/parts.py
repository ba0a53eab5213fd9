"""Parts of a model as meshes in space: what files of meshes and pictures show.

Each vertex is fixed in a frame that moves with the model, a *bone*: a section of a rod, a point of a tendon,
a body. Rods have their true sections, which reports draw thicker where they would be invisible.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial, singledispatch

import numpy as np
from numpy.typing import NDArray

from ..model.contacts import (
    Box,
    Capsule,
    ConvexMesh,
    DistanceGrid,
    HalfSpace,
    HeightField,
    Mesh,
    Sphere,
    Tube,
)
from ..model.glyphs.contacts import Obstacle, ground, outline, skin, turn_of
from ..model.views import Link, View
from . import meshes
from .meshes import Triangles
from .report import actuators, contacts, layers, magnets, solids, visuals
from .report import motion as drawing
from .report.layers import DrawnStates, quaternions, rotations
from .report.loads import drawn_lengths
from .report.symbols import LEGEND

Array = NDArray[np.float64]

#: Layers of strands that are parts of a model, not symbols.
STRANDS = ("tendons", "chambers")

#: Largest angle between neighbouring sections of smooth rods, radians: chords of a circle of radius r leave
#: it by r / 800. At most so many times the usual number of sections are drawn for it.
CHORD, FINEST = 0.1, 8

#: Number of chords of smooth tendons and chambers, relative to reports: a part of a path may cross a rod of
#: many segments.
FINE_STRANDS = 6

#: Names of parts whose surface is open: seen from both sides.
OPEN = HeightField | Tube | DistanceGrid | Mesh


@dataclass(frozen=True)
class Part:
    """A mesh whose vertices are fixed to bones."""

    name: str
    #: The layer of reports whose colour it has.
    layer: str
    #: Vertices (v, 3) in the frames of their bones, metres, and the bones (v,).
    corners: Array
    bone: NDArray[np.intp]
    #: Triangles (m, 3), anticlockwise seen from outside.
    triangles: Triangles
    #: Places (shapes, bones, 3), metres, and unit quaternions (shapes, bones, 4), scalar first, of the bones.
    centres: Array
    turns: Array
    opacity: float = 1.0
    #: Whether the surface has an edge, and is seen from both sides.
    is_open: bool = False
    #: A hexadecimal colour of its own.
    own_colour: str | None = None
    #: Thickness of the wall around a bore, whose surface this is, metres; zero for other surfaces.
    wall: float = 0.0

    @property
    def colour(self) -> str:
        """Its hexadecimal colour."""
        return LEGEND[self.layer] if self.own_colour is None else self.own_colour

    def vertices(self, shape: int) -> Array:
        """Vertices (v, 3) in the world, metres."""
        turns = rotations(self.turns[shape])[self.bone]
        return np.asarray(self.centres[shape][self.bone] + np.einsum("vij,vj->vi", turns, self.corners))


def parts(
    seen: View, q: Array, v: Array, u: Array, t: Array, is_smooth: bool = False
) -> tuple[list[Part], NDArray[np.bool_]]:
    """All parts of a model in several shapes, and which of the shapes they have: those that are finite.

    For coordinates and velocities (shapes, n), inputs (shapes, inputs) and times (shapes,). Rods have so many
    sections that chords are not seen if they are to be smooth, and those of results otherwise.
    """
    links = [_smooth(link, q, t) for link in seen.links] if is_smooth else seen.links
    tubes = [
        solids.tube(link, q, np.zeros_like(v), t, u, _least_radius(seen, link), _opacity(seen))
        for link in links
    ]
    bodies = [solids.ellipsoid(solid, q, t, _least(seen, solid.semi_axes)) for solid in seen.solids]
    pictured = visuals.meshes(seen.visuals, q, t)
    low, high = layers.extent([*tubes, *bodies, *pictured])
    low, high = drawing.box(low, high, 0.04 * float((high - low).max()))
    found = [*map(_of_tube, tubes), *map(_of_solid, bodies), *map(_of_mesh, pictured)]
    found += _strands(seen, q, v, u, t, is_smooth)
    found += _magnets(seen, q, t)
    touching = seen.glyphs.contacts
    for name, shape, poses in contacts.shapes(touching, q, t):
        layer = "obstacles" if poses is None else "shapes"
        half = 0.5 * seen.size * np.ones(3)
        box = (low, high) if poses is None else (_middle(shape) - half, _middle(shape) + half)
        vertices, triangles = surface(shape, *box)
        poses = np.broadcast_to(np.eye(4), (len(q), 4, 4)) if poses is None else poses
        opacity = contacts.OPACITY if isinstance(shape, Tube) else 1.0
        part = _carried(name, layer, vertices, triangles, poses, isinstance(shape, OPEN), opacity)
        wall = (shape.wall or shape.radius) if isinstance(shape, Tube) else 0.0
        found.append(replace(part, wall=wall))
    for ball in contacts.balls(touching, q, t, bodies):
        unit, triangles = meshes.BALL
        found.append(_rigid(ball.name, ball.layer, ball.radius * unit, triangles, ball.points))
    found = [_repeated(part, len(q)) for part in found]
    is_there = np.all([np.isfinite(part.centres).all(axis=(1, 2)) for part in found], axis=0)
    return [
        replace(part, centres=part.centres[is_there], turns=part.turns[is_there])
        for part in map(_tidy, found)
    ], is_there


def _smooth(link: Link, q: Array, t: Array) -> Link:
    """The link with so many sections that its chords are not seen in any of the shapes."""
    turns = link.pose(q, link.stations, t)[..., :3, :3]
    # Cosines of the angles between neighbouring sections; none where a shape is not finite.
    traces = np.einsum("...ij,...ij->...", turns[..., 1:, :, :], turns[..., :-1, :, :])
    cosines = 0.5 * (traces[np.isfinite(traces)] - 1.0)
    largest = float(np.arccos(np.clip(cosines.min(initial=1.0), -1.0, 1.0)))
    return replace(link, per_segment=link.per_segment * min(max(math.ceil(largest / CHORD), 1), FINEST))


def _opacity(seen: View) -> float:
    """Rods are transparent if there is something inside, as in reports."""
    is_hollow = bool(seen.glyphs.magnets) or any(glyph.way is not None for glyph in seen.glyphs.actuators)
    return drawing.OPACITY_AROUND_ACTUATORS if is_hollow else 1.0


def _least(seen: View, semi_axes: Array) -> float:
    """Bodies without a size are drawn as small balls, as in reports."""
    return 0.0 if np.all(semi_axes > 0.0) else 2.0 * drawing.LEAST_RADIUS * seen.size


def _least_radius(seen: View, link: Link) -> float:
    """Rods of given sections without inertia have no size, and are drawn thin, as in reports."""
    return 0.0 if min(link.half_extents()) > 0.0 else drawing.LEAST_RADIUS * seen.size


def _middle(shape: Obstacle) -> Array:
    return np.asarray(shape.point, float) if isinstance(shape, HalfSpace) else np.zeros(3)


def _of_tube(tube: layers.Tube) -> Part:
    skin = meshes.TubeSkin(tube, bands=1)
    corners, bone = skin.corners[0]
    return Part(
        tube.name, "rods", corners, bone, skin.triangles[0], tube.centres, tube.turns, opacity=tube.opacity
    )


def _of_solid(solid: layers.Solid) -> Part:
    unit, triangles = meshes.BOX if solid.form == "box" else meshes.BALL
    corners = unit * np.asarray(solid.size)
    centres, turns = solid.centres[:, None], solid.turns[:, None]
    return Part(solid.name, solid.layer, corners, np.zeros(len(corners), np.intp), triangles, centres, turns)


def _of_mesh(mesh: layers.Mesh) -> Part:
    centres, turns = mesh.centres[:, None], mesh.turns[:, None]
    bone, triangles = np.zeros(len(mesh.corners), np.intp), mesh.faces.astype(np.uint32)
    return Part(
        mesh.name,
        mesh.layer,
        mesh.corners,
        bone,
        triangles,
        centres,
        turns,
        mesh.opacity,
        is_open=mesh.is_open,
        own_colour=mesh.colour,
    )


def _strands(seen: View, q: Array, v: Array, u: Array, t: Array, is_smooth: bool) -> list[Part]:
    """Tendons, as thick as reports draw their largest tension, and chambers."""
    shown = DrawnStates(q, v, u, t, np.ones(len(q)), seen.size, 0.0, 0.0)
    glyphs = [
        glyph
        if glyph.way is None or not is_smooth
        else replace(glyph, way=partial(glyph.way, fineness=FINE_STRANDS))
        for glyph in seen.glyphs.actuators
    ]
    found = []
    for strand in actuators.actuators(glyphs, (), shown):
        if strand.layer not in STRANDS:
            continue
        for run in meshes.runs(strand.points[0]):
            corners, bone, triangles = meshes.bar(len(run), float(strand.radius.max()))
            centres = strand.points[:, run]
            turns = quaternions(meshes.axes_along(centres))
            # Legends say the largest tension after the name.
            name = strand.name.partition(",")[0]
            found.append(Part(name, strand.layer, corners, bone, triangles, centres, turns, strand.opacity))
    return found


def _magnets(seen: View, q: Array, t: Array) -> list[Part]:
    """Arrows from south to north poles, which move with their magnets."""
    found = []
    # Moments and magnetisations have separate scales, as in reports.
    for is_spread in (False, True):
        chosen = [glyph for glyph in seen.glyphs.magnets if glyph.is_spread == is_spread]
        moments = [glyph.moment[None] for glyph in chosen]
        drawn = (
            drawn_lengths(moments, magnets.ARROW * seen.size, layers.Largest(), "magnets") if chosen else []
        )
        for glyph, vectors in zip(chosen, drawn, strict=True):
            poses = np.broadcast_to(glyph.pose(q, t), (len(q), *vectors.shape[1:2], 4, 4))
            places = np.flatnonzero(np.any(vectors[0], axis=-1))
            if not len(places):
                continue
            own = [meshes.arrow(vectors[0, k], seen.size) for k in places]
            corners = np.concatenate([each for each, _ in own])
            count = len(corners) // len(places)
            triangles = np.concatenate([each + np.uint32(count * k) for k, (_, each) in enumerate(own)])
            centres, turns = poses[..., :3, 3], quaternions(poses[..., :3, :3])
            bone = np.repeat(places, count)
            found.append(Part(glyph.name, "magnets", corners, bone, triangles, centres, turns))
    return found


def _carried(
    name: str,
    layer: str,
    vertices: Array,
    triangles: Triangles,
    poses: Array,
    is_open: bool,
    opacity: float,
) -> Part:
    """A mesh given in axes with the poses (shapes, 4, 4)."""
    bone = np.zeros(len(vertices), np.intp)
    centres, turns = poses[:, None, :3, 3], quaternions(poses[:, None, :3, :3])
    return Part(name, layer, vertices, bone, triangles, centres, turns, opacity=opacity, is_open=is_open)


def _rigid(name: str, layer: str, vertices: Array, triangles: Triangles, centres: Array) -> Part:
    """A mesh that moves without turning, with centres (shapes, 1, 3)."""
    turns = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (*centres.shape[:2], 4))
    return Part(name, layer, vertices, np.zeros(len(vertices), np.intp), triangles, centres, turns)


def _repeated(part: Part, count: int) -> Part:
    """With a pose in each shape, also of what does not move."""
    centres, turns = (
        np.broadcast_to(values, (count, *values.shape[1:])) for values in (part.centres, part.turns)
    )
    return replace(part, centres=centres, turns=turns)


def _tidy(part: Part) -> Part:
    """Without triangles of which two corners coincide, and without vertices of no triangle."""
    _, place = np.unique(
        np.concatenate([part.corners, part.bone[:, None]], axis=1), axis=0, return_inverse=True
    )
    a, b, c = place.reshape(-1)[part.triangles].T
    triangles = part.triangles[(a != b) & (b != c) & (c != a)]
    used, renamed = np.unique(triangles, return_inverse=True)
    return replace(
        part,
        corners=part.corners[used],
        bone=part.bone[used],
        triangles=renamed.reshape(triangles.shape).astype(np.uint32),
    )


def normals(vertices: Array, triangles: Triangles) -> Array:
    """Unit normals (v, 3) at vertices: means of those of their triangles, weighted by areas."""
    a, b, c = (vertices[corner] for corner in triangles.T)
    of_triangle = np.cross(b - a, c - a)
    summed = np.zeros_like(vertices)
    for corner in triangles.T:
        np.add.at(summed, corner, of_triangle)
    length = np.linalg.norm(summed, axis=1, keepdims=True)
    # Where areas underflow, any direction serves.
    return np.where(length > 0.0, summed / np.where(length > 0.0, length, 1.0), [1.0, 0.0, 0.0])


@singledispatch
def surface(shape: Obstacle, low: Array, high: Array) -> tuple[Array, Triangles]:
    """Vertices (v, 3) and triangles of the surface of a shape; a half space is cut to a box."""
    raise TypeError(f"no surface of {shape!r}")


@surface.register
def _(shape: HalfSpace, low: Array, high: Array) -> tuple[Array, Triangles]:
    plate = contacts.plate("", shape, low, high)
    unit, triangles = meshes.BOX
    return (unit * plate.size) @ rotations(plate.turns[0]).T + plate.centres[0], triangles


@surface.register
def _(shape: Box, low: Array, high: Array) -> tuple[Array, Triangles]:
    unit, triangles = meshes.BOX
    return (unit * np.asarray(shape.half_extents)) @ turn_of(shape.orientation).T + shape.centre, triangles


@surface.register
def _(shape: Sphere, low: Array, high: Array) -> tuple[Array, Triangles]:
    unit, triangles = meshes.BALL
    return shape.radius * unit + shape.centre, triangles


@surface.register
def _(shape: Capsule, low: Array, high: Array) -> tuple[Array, Triangles]:
    return meshes.capsule(np.asarray(shape.start, float), np.asarray(shape.end, float), shape.radius)


@surface.register
def _(shape: ConvexMesh, low: Array, high: Array) -> tuple[Array, Triangles]:
    points, faces = np.asarray(shape.points, float), np.asarray(shape.faces, np.uint32)
    return meshes.rounded(points, faces, shape.radius) if shape.radius > 0.0 else meshes.convex(points, faces)


@surface.register
def _(shape: Tube, low: Array, high: Array) -> tuple[Array, Triangles]:
    return meshes.pipe(outline(shape), shape.radius)


@surface.register
def _(shape: HeightField, low: Array, high: Array) -> tuple[Array, Triangles]:
    return meshes.grid(ground(shape))


@surface.register
def _(shape: DistanceGrid, low: Array, high: Array) -> tuple[Array, Triangles]:
    points, faces, _ = visuals.creased(*skin(shape))
    return points, faces.astype(np.uint32)


@surface.register
def _(shape: Mesh, low: Array, high: Array) -> tuple[Array, Triangles]:
    points, faces, _ = visuals.creased(*skin(shape))
    return points, faces.astype(np.uint32)


def named(seen: Sequence[Part]) -> list[str]:
    """Names of parts, with numbers where several have the same one."""
    names = [part.name for part in seen]
    return [
        name if names.count(name) == 1 else f"{name} ({names[: k + 1].count(name)})"
        for k, name in enumerate(names)
    ]
