"""Geometry of what is drawn besides links: joints, loops, contacts, loads, supports, magnets, surroundings.

Positions and directions as functions of coordinates and time; reports decide how they look.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..._lissom import Body, Harmonic, Input, Link, Load, Robot, Support, Weld
from .actuators import ActuatorGlyph, actuator_glyphs
from .contacts import NOTHING_TOUCHES, Touching, contact_glyphs
from .joints import JointGlyph, Pose, joint_glyphs
from .loops import LoopGlyph, loop_glyphs
from .magnets import MagnetGlyph, field, magnet_glyphs

Array = NDArray[np.float64]

#: Number of places at which a distributed force or moment is drawn.
PLACES_OF_FORCES, PLACES_OF_MOMENTS = 5, 3


@dataclass(frozen=True)
class LoadGlyph:
    """A force or a moment on a link."""

    #: The link on which it acts.
    name: str
    kind: Literal["force", "moment"]
    is_spread: bool
    #: Poses (..., places, 4, 4) of the places at which it acts.
    pose: Pose
    #: Newtons or newton metres, per metre if distributed, shape (k, 3), for (k,) times and (k, m) inputs.
    value: Callable[[Array, Array], Array]
    #: Whether the components are in the axes of the places, not in world axes.
    follows: bool
    #: 1 at the tip of a rod, -1 at its base, 0 elsewhere and on bodies.
    outwards: int = 0


@dataclass(frozen=True)
class SupportGlyph:
    """Springs or dampers to the world."""

    #: The link that it holds.
    name: str
    #: Position of its anchor (3,), and the poses of the supported places.
    anchor: Array
    pose: Pose
    #: Whether it restrains positions, not only orientations.
    holds_places: bool


@dataclass(frozen=True)
class Glyphs:
    """Everything drawn of a robot besides its links."""

    joints: Sequence[JointGlyph] = ()
    loads: Sequence[LoadGlyph] = ()
    supports: Sequence[SupportGlyph] = ()
    #: Frames at which links are welded to the world or to a moving base.
    clamps: Sequence[Pose] = ()
    actuators: Sequence[ActuatorGlyph] = ()
    loops: Sequence[LoopGlyph] = ()
    magnets: Sequence[MagnetGlyph] = ()
    #: Contact pairs.
    contacts: Touching = NOTHING_TOUCHES
    #: Gravity in world axes, m/s^2.
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    #: Velocity of the fluid in world axes, m/s.
    current: tuple[float, float, float] = (0.0, 0.0, 0.0)
    #: Constant magnetic field in world axes, tesla.
    field: tuple[float, float, float] = (0.0, 0.0, 0.0)


def glyphs(robot: Robot, loads: Sequence[Load]) -> Glyphs:
    """Create the glyphs of a robot with these loads."""
    return Glyphs(
        joints=[glyph for link in robot.links for glyph in _joint(robot, link)],
        loads=[glyph for load in loads for glyph in _load(robot, load)],
        supports=[_support(robot, support) for support in robot.supports],
        clamps=[
            partial(_base, robot, link)
            for link in robot.links
            if link.parent is None and isinstance(link.joint, Weld)
        ],
        actuators=actuator_glyphs(robot),
        loops=loop_glyphs(robot),
        magnets=magnet_glyphs(robot),
        contacts=contact_glyphs(robot),
        gravity=robot.gravity,
        current=robot.fluid.velocity if robot.fluid is not None else (0.0, 0.0, 0.0),
        field=field(robot),
    )


def _base(robot: Robot, link: Link, q: Array, t: float | Array) -> Array:
    """Poses of the base of a link."""
    return robot.pose(q, None if link.rod is None else 0.0, link=link.name, t=t)


def _frame(robot: Robot, link: Link) -> Pose:
    """Poses of the frame of the joint of a link, before the joint moves the link."""
    if link.parent is None:
        # Links on the world move with a moving base, about the frame of the first link's joint.
        first = robot.links[0]
        fixed = Robot(
            [_welded("first", first), _welded("frame", link)],
            base_motion=robot.base_motion,
        )

        def on_world(q: Array, t: float | Array) -> Array:
            return fixed.pose(q[..., :0], link="frame", t=t)

        return on_world
    place = Robot([_welded("frame", link)]).pose(np.zeros(0))
    parent = next(other for other in robot.links if other.name == link.parent)

    def on_parent(q: Array, t: float | Array) -> Array:
        return robot.pose(q, link.at, link=parent.name, t=t) @ place

    return on_parent


def _welded(name: str, link: Link) -> Link:
    """A body fixed in the world, at the pose at which a link is attached to its parent."""
    return Link(name, body=Body(1.0), position=link.position, orientation=link.orientation)


def _joint(robot: Robot, link: Link) -> list[JointGlyph]:
    """The glyphs of the joint of a link."""
    return joint_glyphs(link.name, link.joint, _frame(robot, link), partial(_base, robot, link))


def _load(robot: Robot, load: Load) -> list[LoadGlyph]:
    """The force and the moment of a load, if nonzero."""
    name = load.link or robot.links[0].name
    link = next(link for link in robot.links if link.name == name)
    length = sum(segment.length for segment in link.rod or ())
    is_spread = load.along is not None
    at = length if load.at is None else load.at
    outwards = 0
    if link.rod is not None and not is_spread:
        outwards = 1 if np.isclose(at, length) else -1 if at == 0.0 else 0

    def glyph(kind: Literal["force", "moment"], signal: Any, places: int) -> list[LoadGlyph]:
        if isinstance(signal, tuple) and len(signal) == 3 and not any(signal):
            return []
        X = None
        if load.along is not None:
            X = np.linspace(*load.along, places)
        elif link.rod is not None:
            X = np.array([at])
        pose, value = partial(_places, robot, name, X), partial(_value, robot, signal)
        return [LoadGlyph(name, kind, is_spread, pose, value, load.frame == "body", outwards)]

    return [
        *glyph("force", load.force, PLACES_OF_FORCES),
        *glyph("moment", load.moment, PLACES_OF_MOMENTS),
    ]


def _places(robot: Robot, link: str, X: Array | None, q: Array, t: float | Array) -> Array:
    """Poses (..., places, 4, 4) of places on a rod, or of the single one of a body."""
    found = robot.pose(q, X, link=link, t=t)
    return found if X is not None else found[..., None, :, :]


def _value(robot: Robot, signal: Any, t: Array, u: Array) -> Array:
    """Values (k, 3) of the force or moment of a load of a robot at times (k,), with inputs (k, m)."""
    if isinstance(signal, Input):
        own = [i for i, name in enumerate(robot.inputs) if name.rpartition(".")[0] == signal.name]
        return u[:, own]
    return value_at(signal, t)


def value_at(signal: Any, t: float | Array) -> Array:
    """Values (..., 3) at times (...) of anything that `Load` accepts as force or moment."""
    times = np.asarray(t, float)
    found: Array
    if isinstance(signal, Input):
        # The default of the input.
        found = np.asarray(signal.default, float)
    elif isinstance(signal, Harmonic):
        phase = 2.0 * np.pi * signal.frequency * times[..., None] + signal.phase
        steady = np.asarray(signal.mean) + np.asarray(signal.rate) * times[..., None]
        found = steady + np.asarray(signal.amplitude) * np.sin(phase)
    elif callable(signal):
        found = np.reshape([signal(float(time)) for time in times.ravel()], (*times.shape, 3))
    elif len(signal) == 2 or isinstance(signal[2], str):
        stations, values = (np.asarray(part, float) for part in signal[:2])
        found = np.stack([np.interp(times, stations, column) for column in values.T], axis=-1)
    else:
        found = np.asarray(signal, float)
    return np.broadcast_to(found, (*times.shape, 3))


def _support(robot: Robot, support: Support) -> SupportGlyph:
    name = support.link or robot.links[0].name
    link = next(link for link in robot.links if link.name == name)
    at = support.at
    if at is None and link.rod is not None:
        at = sum(segment.length for segment in link.rod)

    def pose(q: Array, t: float | Array) -> Array:
        return robot.pose(q, at, link=name, t=t)

    if support.position is None:
        resting = _at_rest(robot)
        anchor = resting.pose(np.zeros(resting.n), at, link=name)[:3, 3]
    else:
        anchor = np.asarray(support.position, float)
    return SupportGlyph(name, anchor, pose, any(support.stiffness) or any(support.damping))


def _at_rest(robot: Robot) -> Robot:
    """The links of a robot with prescribed joint motions replaced by ordinary coordinates."""
    links = []
    for link in robot.links:
        prescribed = {name: None for name in ("motion", "mimic") if hasattr(link.joint, name)}
        links.append(replace(link, joint=replace(link.joint, **prescribed)))
    # Prescribed joints may lack inertia, coordinates must have it.
    bodies = [Body(1.0, inertia=(1.0, 1.0, 1.0), link=link.name) for link in links]
    return Robot(links, bodies=bodies)
