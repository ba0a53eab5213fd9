"""Geometry of joints for drawings: axes, planes and points where two frames meet."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..._lissom import Cylindrical, Joint, Planar, Prismatic, Revolute, Screw, Spherical, Universal

Array = NDArray[np.float64]

#: Poses of shape (..., 4, 4), for coordinates (..., n) and a time or an array of times.
Pose = Callable[[Array, float | Array], Array]


@dataclass(frozen=True)
class JointGlyph:
    """An axis, a plane or a point of a joint."""

    #: The link that the joint moves, or the loop that it closes.
    name: str
    kind: Literal["turning", "sliding", "plane", "ball"]
    #: The frame of the glyph: x along the axis, or along the normal of the plane.
    pose: Pose
    #: The frame that the joint moves: the base of the link.
    base: Pose

    def travel(self, q: Array, t: float | Array) -> Array:
        """Displacement of the base relative to the glyph, along the axes of the glyph, (..., 3), metres."""
        glyph, base = self.pose(q, t), self.base(q, t)
        moved: Array = np.einsum("...ij,...i->...j", glyph[..., :3, :3], base[..., :3, 3] - glyph[..., :3, 3])
        return moved


def joint_glyphs(name: str, joint: Joint, frame: Pose, base: Pose) -> list[JointGlyph]:
    """The glyphs of a joint between its frame and the base that it moves."""

    def glyph(kind: Literal["turning", "sliding", "plane", "ball"], pose: Pose, axes: Array) -> JointGlyph:
        return JointGlyph(name, kind, partial(_turned, pose, axes), base)

    match joint:
        case Revolute(axis=axis):
            return [glyph("turning", frame, _along(axis))]
        case Prismatic(axis=axis):
            return [glyph("sliding", frame, _along(axis))]
        case Cylindrical(axis=axis) | Screw(axis=axis):
            return [glyph("sliding", frame, _along(axis)), glyph("turning", base, _along(axis))]
        case Universal(axis1=axis1, axis2=axis2):
            # The joint rotates the second axis about the first one, and the link about the second one.
            return [glyph("turning", frame, _along(axis1)), glyph("turning", base, _along(axis2))]
        case Planar(normal=normal):
            return [glyph("plane", frame, _plane(normal)), glyph("turning", base, _along(normal))]
        case Spherical():
            return [glyph("ball", frame, np.eye(3))]
        case _:
            # Welds and free joints have no glyphs.
            return []


def _turned(pose: Pose, axes: Array, q: Array, t: float | Array) -> Array:
    """Frames with other axes, the columns of a matrix."""
    turn = np.eye(4)
    turn[:3, :3] = axes
    return pose(q, t) @ turn


def _along(axis: ArrayLike) -> Array:
    """A frame with this axis as its first."""
    x = _unit(np.asarray(axis, float))
    y = _unit(np.cross(np.eye(3)[int(np.argmin(np.abs(x)))], x))
    return np.stack([x, y, np.cross(x, y)], axis=1)


def _plane(normal: ArrayLike) -> Array:
    """Axes of a plane: its normal, then x projected onto the plane (y if the normal is along x)."""
    n = _unit(np.asarray(normal, float))
    start = np.eye(3)[1 if np.linalg.norm(np.cross(n, [1.0, 0.0, 0.0])) == 0.0 else 0]
    first = _unit(start - (start @ n) * n)
    return np.stack([n, first, np.cross(n, first)], axis=1)


def _unit(vector: Array) -> Array:
    unit: Array = vector / np.linalg.norm(vector)
    return unit
