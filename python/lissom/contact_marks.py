"""What is drawn and plotted of what touches: obstacles, balls on links, where surfaces press and how hard.

Plain geometry and numbers, as functions of coordinates and time; how that looks is the reports' business.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ._lissom import Robot
from .contacts import Ball, Box, Capsule, Contact, HalfSpace, Sphere, Touch
from .joint_marks import Pose

Array = NDArray[np.float64]

#: What obstacles are called.
WORDS = {HalfSpace: "a half space", Sphere: "a sphere", Capsule: "a capsule", Box: "a box"}


@dataclass(frozen=True)
class ContactMark:
    """Two surfaces that can touch."""

    name: str
    #: What touches what, in words.
    between: str
    #: What is fixed in the world, if it is one of the two.
    obstacle: HalfSpace | Sphere | Capsule | Box | None
    #: Poses of the centres of the balls on links among the two, and their radii, metres.
    balls: Sequence[tuple[Pose, float]]
    #: Force on the first surface in world axes, (k, 3), newtons: of (k, n) coordinates and velocities and
    #: (k,) times.
    force: Callable[[Array, Array, Array], Array]


@dataclass(frozen=True)
class Touching:
    """All that can touch of a robot."""

    pairs: Sequence[ContactMark] = ()
    #: Where surfaces touch: of (n,) coordinates and velocities, and a time.
    touches: Callable[[Array, Array, float], Sequence[Touch]] | None = None


#: Of a robot without contacts.
NOTHING_TOUCHES: Touching = Touching()


def contact_marks(robot: Robot) -> Touching:
    """What there is to draw and plot of the contacts of a robot."""
    if not robot.contacts:
        return NOTHING_TOUCHES
    return Touching([_mark(robot, contact) for contact in robot.contacts], partial(_touches, robot))


def _touches(robot: Robot, q: Array, v: Array, t: float) -> Sequence[Touch]:
    return robot.touches(q, v, t=t)


def _mark(robot: Robot, contact: Contact) -> ContactMark:
    def force(q: Array, v: Array, t: Array) -> Array:
        return np.asarray(robot.contact_forces(q, v, name=contact.name, t=t), float)[..., 3:]

    surfaces = (contact.a, contact.b)
    obstacle = None if isinstance(contact.b, str | Ball) else contact.b
    balls = [(partial(_ball, robot, ball), ball.radius) for ball in surfaces if isinstance(ball, Ball)]
    between = " and ".join(_word(surface) for surface in surfaces)
    return ContactMark(contact.name, between, obstacle, balls, force)


def _word(surface: object) -> str:
    if isinstance(surface, Ball):
        return f"a ball on {surface.link}"
    return surface if isinstance(surface, str) else WORDS[type(surface)]


def _ball(robot: Robot, ball: Ball, q: Array, t: float | Array) -> Array:
    """Poses of the centre of a ball."""
    beside = np.eye(4)
    beside[:3, 3] = ball.position
    return robot.pose(q, ball.at, link=ball.link, t=t) @ beside
