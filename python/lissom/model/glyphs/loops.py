"""Geometry, forces and gaps of closed loops, for drawings and plots.

Plain geometry and numbers, as functions of coordinates and time; reports decide how they look.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..._lissom import (
    Body,
    Cylindrical,
    Distance,
    Gear,
    Link,
    Loop,
    LoopEnd,
    Planar,
    Prismatic,
    Revolute,
    Robot,
    Spherical,
    Universal,
    Weld,
)
from .joints import JointGlyph, Pose, joint_glyphs

Array = NDArray[np.float64]

#: Number of constraints in metres, and number of differences of cosines, by type of joint.
ROWS: Mapping[type, tuple[int, int]] = {
    Weld: (3, 3),
    Revolute: (3, 2),
    Prismatic: (2, 3),
    Cylindrical: (2, 2),
    Universal: (3, 1),
    Planar: (1, 2),
    Spherical: (3, 0),
    Distance: (1, 0),
}


@dataclass(frozen=True)
class LoopGlyph:
    """A joint that closes a loop, for drawings and plots."""

    name: str
    kind: Literal["joint", "weld", "distance", "gear"]
    #: Description of the two ends.
    between: str
    #: Glyphs of its joint: axes, planes or points.
    joints: Sequence[JointGlyph]
    #: The frames of its ends, each with the pose of its section or body, or None in the world; empty for a
    #: gear.
    ends: Sequence[tuple[Pose, Pose | None]]
    #: Moment about the second end and force there, in world axes, (k, 6), or the generalised force of a gear,
    #: (k,), for (k, n) coordinates, velocities, accelerations, (k,) times and (k, m) inputs.
    force: Callable[[Array, Array, Array, Array, Array], Array]
    #: Largest gap, (k,), by unit, for (k, n) coordinates and (k,) times.
    gaps: Callable[[Array, Array], Mapping[str, Array]]


def loop_glyphs(robot: Robot) -> list[LoopGlyph]:
    """Glyphs of all closed loops of a robot."""
    # Gears come last.
    first = 0
    places: dict[str, int] = {}
    for closed in sorted(robot.loops, key=lambda closed: isinstance(closed.kind, Gear)):
        places[closed.name] = first
        first += sum(_rows(closed))
    return [_glyph(robot, closed, places[closed.name]) for closed in robot.loops]


def _rows(closed: Loop) -> tuple[int, int]:
    return ROWS.get(type(closed.kind), (1, 0))


def _glyph(robot: Robot, closed: Loop, first: int) -> LoopGlyph:
    def force(q: Array, v: Array, a: Array, t: Array, u: Array) -> Array:
        return np.asarray(robot.loop_forces(q, v, a, name=closed.name, t=t, u=u), float)

    gaps = partial(_gaps, robot, closed, first)
    if isinstance(closed.kind, Gear):
        return LoopGlyph(closed.name, "gear", f"{closed.a} and {closed.b}", (), (), force, gaps)
    ends = [_end(robot, end) for end in (closed.a, closed.b)]
    names = [end.link or "the world" for end in (closed.a, closed.b) if isinstance(end, LoopEnd)]
    joints: Sequence[JointGlyph] = ()
    kind: Literal["joint", "weld", "distance"] = "distance"
    if not isinstance(closed.kind, Distance):
        joints = joint_glyphs(closed.name, closed.kind, ends[0][0], ends[1][0])
        kind = "joint" if joints else "weld"
    return LoopGlyph(closed.name, kind, " and ".join(names), joints, ends, force, gaps)


def _end(robot: Robot, end: object) -> tuple[Pose, Pose | None]:
    """The frame of an end, and the pose of its link."""
    # `Robot` has converted all forms of an end to `LoopEnd`.
    assert isinstance(end, LoopEnd)
    place = Link("frame", body=Body(1.0), position=end.position, orientation=end.orientation)
    local = Robot([place]).pose(np.zeros(0))
    if end.link is None:

        def in_world(q: Array, t: float | Array) -> Array:
            return np.broadcast_to(local, (*np.shape(q)[:-1], 4, 4))

        return in_world, None
    on = partial(_on_link, robot, end.link, end.at)
    return partial(_beside, on, local), on


def _on_link(robot: Robot, link: str, at: float | None, q: Array, t: float | Array) -> Array:
    return robot.pose(q, at, link=link, t=t)


def _beside(on: Pose, local: Array, q: Array, t: float | Array) -> Array:
    return on(q, t) @ local


def _gaps(robot: Robot, closed: Loop, first: int, q: Array, t: Array) -> dict[str, Array]:
    lengths, cosines = _rows(closed)
    gaps = np.abs(robot.loop_gaps(q, t=t)[..., first : first + lengths + cosines])
    if isinstance(closed.kind, Gear):
        return {"coordinate": gaps.max(axis=-1)}
    found = {"m": gaps[..., :lengths].max(axis=-1)}
    if cosines:
        found["cosine"] = gaps[..., lengths:].max(axis=-1)
    return found
