"""Geometry of supports."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..._lissom import Body, Robot, Support
from .joints import Pose
from .places import place_of

Array = NDArray[np.float64]


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


def support_glyph(robot: Robot, support: Support) -> SupportGlyph:
    """The glyph of a support."""
    link, at = place_of(robot, support)

    def pose(q: Array, t: float | Array) -> Array:
        return robot.pose(q, at, link=link.name, t=t)

    if support.position is None:
        resting = _at_rest(robot)
        anchor = resting.pose(np.zeros(resting.n), at, link=link.name)[:3, 3]
    else:
        anchor = np.asarray(support.position, float)
    return SupportGlyph(link.name, anchor, pose, any(support.stiffness) or any(support.damping))


def _at_rest(robot: Robot) -> Robot:
    """The links of a robot with prescribed joint motions replaced by ordinary coordinates."""
    links = []
    for link in robot.links:
        prescribed = {name: None for name in ("motion", "mimic") if hasattr(link.joint, name)}
        links.append(replace(link, joint=replace(link.joint, **prescribed)))
    # Prescribed joints may lack inertia, coordinates must have it.
    bodies = [Body(1.0, inertia=(1.0, 1.0, 1.0), link=link.name) for link in links]
    return Robot(links, bodies=bodies)
