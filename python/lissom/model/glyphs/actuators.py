"""Geometry and time histories of a robot's actuators, for drawings and plots.

Plain geometry and numbers, as functions of coordinates and time; reports decide how they look.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..._lissom import ActiveStrain, Along, Chamber, Input, Motor, Profile, Robot, Tendon, Via

Array = NDArray[np.float64]

#: Points along an embedded part of a path.
POINTS_OF_PART = 17


@dataclass(frozen=True)
class ActuatorGlyph:
    """An actuator in drawings and plots."""

    name: str
    kind: Literal["tendon", "chamber", "motor", "active strain"]
    #: Names and units of its force and its length.
    quantities: tuple[str, str]
    #: Tension, pressure, torque, force or amount, (k,), for (k, n) coordinates and velocities, (k,) times and
    #: (k, m) inputs.
    force: Callable[[Array, Array, Array, Array], Array]
    #: Length, volume or coordinate, (k,), for (k, n) coordinates and (k,) times.
    length: Callable[[Array, Array], Array]
    #: Its path as a polyline, (k, points, 3); None if it has none. With the keyword `fineness`, so many times
    #: the usual number of chords.
    way: Callable[..., Array] | None = None
    #: For a chamber, the radius of the circle with its area, metres.
    radius: float = 0.0
    #: The coordinate that a motor moves: its link, and its name within the joint.
    coordinate: tuple[str, str] | None = None
    #: Whether it is a tendon with a commanded length, which is slack if its path is shorter.
    is_let_out: bool = False
    #: Name of the input that gives its tension, which is never negative.
    pulled_by: str | None = None


def actuator_glyphs(robot: Robot) -> list[ActuatorGlyph]:
    """Glyphs of all actuators of a robot."""
    return [_glyph(robot, actuator) for actuator in robot.actuators]


def _glyph(robot: Robot, actuator: object) -> ActuatorGlyph:
    kind: Literal["tendon", "chamber", "motor", "active strain"]
    way, radius, coordinate, is_let_out, pulled_by = None, 0.0, None, False, None
    match actuator:
        case Tendon(name=name, path=path, length=given, tension=tension):
            kind, quantities = "tendon", ("tension (N)", "length (m)")
            way, is_let_out = partial(_way, robot, path), given is not None
            pulled_by = tension.name if isinstance(tension, Input) else None
        case Chamber(name=name, path=path, area=area):
            kind, quantities = "chamber", ("pressure (Pa)", "volume (m³)")
            way, radius = partial(_way, robot, path), float(np.sqrt(area / np.pi))
        case Motor(name=str(name), joint=joint):
            link, _, moved = joint.rpartition(".")
            is_turning = moved.startswith("angle")
            kind, coordinate = "motor", (link, moved)
            quantities = ("torque (N m)", "angle (rad)") if is_turning else ("force (N)", "displacement (m)")
        case ActiveStrain(name=str(name)):
            kind, quantities = "active strain", ("amount", "conjugate strain")
        case _:
            raise TypeError(f"no drawing of {actuator!r}")

    def force(q: Array, v: Array, t: Array, u: Array) -> Array:
        return np.asarray(robot.actuator_force(name, q, v, t=t, u=u), float)

    def length(q: Array, t: Array) -> Array:
        return np.asarray(robot.actuator_length(name, q, t=t), float)

    return ActuatorGlyph(
        name, kind, quantities, force, length, way, radius, coordinate, is_let_out, pulled_by
    )


def _way(robot: Robot, path: Sequence[Along | Via], q: Array, t: Array, fineness: int = 1) -> Array:
    """Points (k, points, 3) of a path, part after part."""
    count = fineness * (POINTS_OF_PART - 1) + 1
    return np.concatenate([_points(robot, part, q, t, count) for part in path], axis=1)


def _points(robot: Robot, part: Along | Via, q: Array, t: Array, count: int) -> Array:
    if isinstance(part, Via):
        point = np.asarray(part.point, float)
        if part.link is None:
            return np.broadcast_to(point, (len(q), 1, 3))
        pose = robot.pose(q, part.at, link=part.link, t=t)
        return _beside(pose[:, None], point[None])
    # `Robot` has already filled in omitted links.
    assert part.link is not None
    rod = next(link.rod for link in robot.links if link.name == part.link)
    length = sum(segment.length for segment in rod or ())
    X = np.linspace(*(part.along or (0.0, length)), count)
    beside = np.stack([np.zeros_like(X), *(_along(offset, X) for offset in part.offset)], axis=-1)
    return _beside(robot.pose(q, X, link=part.link, t=t), beside)


def _beside(poses: Array, points: Array) -> Array:
    """Points (points, 3), each given in its frame (k, points, 4, 4), in world axes."""
    seen: Array = np.einsum("kpij,pj->kpi", poses[..., :3, :3], points) + poses[..., :3, 3]
    return seen


def _along(offset: Any, X: Array) -> Array:
    """Evaluate an offset of a robot's path at arc lengths of its part.

    It is a number, two numbers at the ends of the part, a table or a profile.
    """
    if isinstance(offset, tuple) and isinstance(offset[0], tuple):
        stations, values = offset
        offset = Profile(stations[-1], stations=stations, values=values)
    if isinstance(offset, Profile):
        # The end of the rod is subject to rounding.
        return np.asarray(offset(np.clip(X, 0.0, offset.length)), float)
    if isinstance(offset, tuple):
        start, end = offset
        return np.linspace(start, end, len(X))
    return np.full_like(X, offset)
