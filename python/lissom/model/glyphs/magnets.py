"""Geometry of magnets and magnetised segments."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..._lissom import Link, Magnet, Profile, Robot
from .joints import Pose
from .places import place_of, poses

Array = NDArray[np.float64]

#: Number of places at which the magnetisation of a segment is drawn.
PLACES = 3


@dataclass(frozen=True)
class MagnetGlyph:
    """A magnet, or the magnetisation of a segment."""

    #: Its name: the link that carries it.
    name: str
    is_spread: bool
    #: Poses (..., places, 4, 4) of the places at which it is drawn.
    pose: Pose
    #: A m^2, or A/m of segments, in the axes of the places, shape (places, 3).
    moment: Array


def magnet_glyphs(robot: Robot) -> list[MagnetGlyph]:
    """The glyphs of everything that is magnetic in a robot."""
    magnets = [_magnet(robot, magnet) for magnet in robot.magnets]
    return magnets + [glyph for link in robot.links for glyph in _segments(robot, link)]


def field(robot: Robot) -> tuple[float, float, float]:
    """The magnetic field of a robot in tesla, zero unless it is constant."""
    match robot.field:
        case (float(x), float(y), float(z)):
            return x, y, z
    return 0.0, 0.0, 0.0


def _magnet(robot: Robot, magnet: Magnet) -> MagnetGlyph:
    link, at = place_of(robot, magnet)
    place = np.eye(4)
    place[:3, 3] = magnet.position
    pose = partial(_poses, robot, link.name, None if at is None else np.array([at]), place)
    return MagnetGlyph(f"magnet on {link.name}", False, pose, np.array([magnet.moment]))


def _segments(robot: Robot, link: Link) -> list[MagnetGlyph]:
    """The glyphs of the magnetised segments of a link."""
    found, start = [], 0.0
    for segment in link.rod or ():
        # In the middle of equal parts.
        X = segment.length * (np.arange(PLACES) + 0.5) / PLACES
        along = segment.magnetisation
        moment = along(X) if isinstance(along, Profile) else np.tile(along, (PLACES, 1))
        if np.any(moment):
            pose = partial(_poses, robot, link.name, start + X, np.eye(4))
            found.append(MagnetGlyph(f"magnetisation of {link.name}", True, pose, moment))
        start += segment.length
    return found


def _poses(robot: Robot, link: str, X: Array | None, place: Array, q: Array, t: float | Array) -> Array:
    """Poses (..., places, 4, 4) on a rod, or the single one on a body."""
    return poses(robot, link, X, q, t) @ place
