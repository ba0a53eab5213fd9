"""Geometry of what is drawn besides links: joints and effects, each in a file of its own, and surroundings.

Positions and directions as functions of coordinates and time; reports decide how they look.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..._lissom import Body, Link, Load, Robot, Weld
from .actuators import ActuatorGlyph, actuator_glyphs
from .contacts import NOTHING_TOUCHES, Touching, contact_glyphs
from .joints import JointGlyph, Pose, joint_glyphs
from .loads import LoadGlyph, load_glyphs
from .loops import LoopGlyph, loop_glyphs
from .magnets import MagnetGlyph, field, magnet_glyphs
from .supports import SupportGlyph, support_glyph

Array = NDArray[np.float64]


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
        loads=[glyph for load in loads for glyph in load_glyphs(robot, load)],
        supports=[support_glyph(robot, support) for support in robot.supports],
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
