"""What is drawn of a robot beside its links: joints, loads, supports, gravity, the current.

Plain geometry: where everything is and where it points, as functions of coordinates and time. How that looks
is the reports' business.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._lissom import Harmonic, Load, Robot, Support
from .links import Cylindrical, Free, Joint, Link, Planar, Prismatic, Revolute, Spherical, Universal, Weld

Array = NDArray[np.float64]

#: Poses of shape (..., 4, 4): of coordinates (..., n) and a time or as many times.
Pose = Callable[[Array, float | Array], Array]

#: Places at which a force, or a moment, is drawn that is spread along a rod.
PLACES_OF_FORCES, PLACES_OF_MOMENTS = 5, 3


@dataclass(frozen=True)
class JointMark:
    """An axis, a plane or a point of a joint."""

    #: The link that the joint moves.
    name: str
    kind: Literal["turning", "sliding", "plane", "ball"]
    #: The frame of the mark: x along the axis, or along the normal of the plane.
    pose: Pose
    #: The coordinates that are displacements: along x of a sliding mark, along y and z of a plane.
    travel: slice = field(default_factory=lambda: slice(0))


@dataclass(frozen=True)
class LoadMark:
    """A force or a moment on a link."""

    #: The link that it acts on.
    name: str
    kind: Literal["force", "moment"]
    is_spread: bool
    #: Poses (..., places, 4, 4) of the places where it acts.
    pose: Pose
    #: Newtons or newton metres, per metre where it is spread, shape (..., 3): of times (...).
    value: Callable[[float | Array], Array]
    #: Whether these are in the axes of the places, and not in those of the world.
    follows: bool
    #: Where the rod ends there: 1 at its tip, -1 at its base, 0 elsewhere and on bodies.
    outwards: int = 0


@dataclass(frozen=True)
class SupportMark:
    """Springs or dampers to the world."""

    #: The link that it holds.
    name: str
    #: The pose (4, 4) of its anchor, and those of what it holds.
    anchor: Array
    pose: Pose
    #: Whether it holds places, and not directions alone.
    holds_places: bool


@dataclass(frozen=True)
class Marks:
    """All that is drawn of a robot beside its links."""

    joints: Sequence[JointMark] = ()
    loads: Sequence[LoadMark] = ()
    supports: Sequence[SupportMark] = ()
    #: Where links are welded to the world, or to the base that moves.
    clamps: Sequence[Pose] = ()
    #: In the world, m/s^2.
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    #: Velocity of the fluid in the world, m/s.
    current: tuple[float, float, float] = (0.0, 0.0, 0.0)


def marks(robot: Robot, loads: Sequence[Load]) -> Marks:
    """What is drawn of a robot on which these loads act."""
    return Marks(
        joints=[mark for link in robot.links for mark in _joint(robot, link)],
        loads=[mark for load in loads for mark in _load(robot, load)],
        supports=[_support(robot, support) for support in robot.supports],
        clamps=[
            partial(_base, robot, link)
            for link in robot.links
            if link.parent is None and isinstance(link.joint, Weld)
        ],
        gravity=robot.gravity,
        current=robot.fluid.velocity if robot.fluid is not None else (0.0, 0.0, 0.0),
    )


def _base(robot: Robot, link: Link, q: Array, t: float | Array) -> Array:
    """Poses of the base of a link."""
    return robot.pose(q, None if link.rod is None else 0.0, link=link.name, t=t)


def _joint(robot: Robot, link: Link) -> list[JointMark]:
    """The marks of the joint of a link."""
    first = robot.slice(link.name).start
    joint: Joint = link.joint

    def mark(
        kind: Literal["turning", "sliding", "plane", "ball"],
        place: Callable[[Array, Array], Array],
        travel: int = 0,
    ) -> JointMark:
        def pose(q: Array, t: float | Array) -> Array:
            return place(_base(robot, link, q, t), q[..., first:])

        return JointMark(link.name, kind, pose, slice(first, first + travel))

    match joint:
        case Revolute(axis=axis):
            return [mark("turning", partial(_turned, _along(axis)))]
        case Prismatic(axis=axis):
            return [mark("sliding", partial(_before_slide, _along(axis)), 1)]
        case Cylindrical(axis=axis):
            return [
                mark("sliding", partial(_before_slide, _along(axis)), 1),
                mark("turning", partial(_turned, _along(axis))),
            ]
        case Universal(axis1=axis1, axis2=axis2):
            return [
                mark("turning", partial(_before_second_turn, _along(axis1), _along(axis2))),
                mark("turning", partial(_turned, _along(axis2))),
            ]
        case Planar(normal=normal):
            return [
                mark("plane", partial(_before_plane_motion, _plane(normal)), 2),
                mark("turning", partial(_turned, _along(normal))),
            ]
        case Spherical():
            return [mark("ball", partial(_turned, np.eye(3)))]
        case Weld() | Free() | _:
            # A weld is no motion, and nothing joins what is free.
            return []


# The base of a link is the frame of its joint, moved by the joint. An axis about which the link turns last,
# or along which it slides, is the same in both; elsewhere the motion is taken back.


def _turned(axes: Array, base: Array, q: Array) -> Array:
    """The base with other axes."""
    pose = base.copy()
    pose[..., :3, :3] = base[..., :3, :3] @ axes
    return pose


def _before_slide(axes: Array, base: Array, q: Array) -> Array:
    """Where the base was before it slid along the first of the axes."""
    pose = _turned(axes, base, q)
    pose[..., :3, 3] -= pose[..., :3, 0] * q[..., :1]
    return pose


def _before_second_turn(first: Array, second: Array, base: Array, q: Array) -> Array:
    """The first axis of a cross, which does not follow the turn about the second one."""
    return _turned(_rotation(second[:, 0], -q[..., 1]) @ first, base, q)


def _before_plane_motion(axes: Array, base: Array, q: Array) -> Array:
    """Where the base was before it moved along the last two axes and turned about the first one."""
    pose = _turned(_rotation(axes[:, 0], -q[..., 2]) @ axes, base, q)
    pose[..., :3, 3] -= np.einsum("...ij,...j->...i", pose[..., :3, 1:3], q[..., :2])
    return pose


def _rotation(axis: Array, angle: Array) -> Array:
    """Rotations (..., 3, 3) by angles (...) about a unit vector: Rodrigues' formula."""
    cross = np.cross(np.eye(3), axis)
    sine, cosine = np.sin(angle)[..., None, None], np.cos(angle)[..., None, None]
    return np.eye(3) + sine * cross + (1.0 - cosine) * (cross @ cross)


def _along(axis: ArrayLike) -> Array:
    """Axes of which the first is this one."""
    x = _unit(np.asarray(axis, float))
    y = _unit(np.cross(np.eye(3)[int(np.argmin(np.abs(x)))], x))
    return np.stack([x, y, np.cross(x, y)], axis=1)


def _plane(normal: ArrayLike) -> Array:
    """Axes of a plane: its normal, then x less its part along that (y where the normal is along x)."""
    n = _unit(np.asarray(normal, float))
    start = np.eye(3)[1 if np.linalg.norm(np.cross(n, [1.0, 0.0, 0.0])) == 0.0 else 0]
    first = _unit(start - (start @ n) * n)
    return np.stack([n, first, np.cross(n, first)], axis=1)


def _unit(vector: Array) -> Array:
    unit: Array = vector / np.linalg.norm(vector)
    return unit


def _load(robot: Robot, load: Load) -> list[LoadMark]:
    """The force and the moment of a load, those that there are."""
    name = load.link or robot.links[0].name
    link = next(link for link in robot.links if link.name == name)
    length = sum(segment.length for segment in link.rod or ())
    is_spread = load.along is not None
    at = length if load.at is None else load.at
    outwards = 0
    if link.rod is not None and not is_spread:
        outwards = 1 if np.isclose(at, length) else -1 if at == 0.0 else 0

    def mark(kind: Literal["force", "moment"], signal: Any, places: int) -> list[LoadMark]:
        if isinstance(signal, tuple) and len(signal) == 3 and not any(signal):
            return []
        X = None
        if load.along is not None:
            X = np.linspace(*load.along, places)
        elif link.rod is not None:
            X = np.array([at])
        pose, value = partial(_places, robot, name, X), partial(value_at, signal)
        return [LoadMark(name, kind, is_spread, pose, value, load.frame == "body", outwards)]

    return [
        *mark("force", load.force, PLACES_OF_FORCES),
        *mark("moment", load.moment, PLACES_OF_MOMENTS),
    ]


def _places(robot: Robot, link: str, X: Array | None, q: Array, t: float | Array) -> Array:
    """Poses (..., places, 4, 4) of places of a rod, or of the one of a body."""
    found = robot.pose(q, X, link=link, t=t)
    return found if X is not None else found[..., None, :, :]


def value_at(signal: Any, t: float | Array) -> Array:
    """Values (..., 3) at times (...) of what a `Load` takes as force or moment."""
    times = np.asarray(t, float)
    found: Array
    if isinstance(signal, Harmonic):
        phase = 2.0 * np.pi * signal.frequency * times[..., None] + signal.phase
        steady = np.asarray(signal.mean) + np.asarray(signal.rate) * times[..., None]
        found = steady + np.asarray(signal.amplitude) * np.sin(phase)
    elif callable(signal):
        found = np.reshape([signal(float(time)) for time in times.ravel()], (*times.shape, 3))
    elif len(signal) == 2:
        stations, values = (np.asarray(part, float) for part in signal)
        found = np.stack([np.interp(times, stations, column) for column in values.T], axis=-1)
    else:
        found = np.asarray(signal, float)
    return np.broadcast_to(found, (*times.shape, 3))


def _support(robot: Robot, support: Support) -> SupportMark:
    name = support.link or robot.links[0].name
    link = next(link for link in robot.links if link.name == name)
    at = support.at
    if at is None and link.rod is not None:
        at = sum(segment.length for segment in link.rod)

    def pose(q: Array, t: float | Array) -> Array:
        return robot.pose(q, at, link=name, t=t)

    anchor = np.array(_at_rest(robot).pose(np.zeros(robot.n), at, link=name))
    if support.position is not None:
        anchor[:3, 3] = support.position
    return SupportMark(name, anchor, pose, any(support.stiffness) or any(support.damping))


def _at_rest(robot: Robot) -> Robot:
    """The robot on a base that does not move, where it does."""
    if robot.base_motion is None:
        return robot
    positional, named = robot.__getnewargs_ex__()
    return type(robot)(*positional, **(named | {"base_motion": None}))
