"""Places on the links of a robot, and instruments fixed there."""

from __future__ import annotations

import re
from dataclasses import KW_ONLY, dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import Robot, finite_array
from .sensor import Sensor, number
from .states import States
from .turning import matrix_of, turned_back

Array = NDArray[np.float64]

#: Tolerated deviation of a quaternion's norm from one, as for a `Link`.
QUATERNION_TOLERANCE = 1e-3


def check(robot: Robot, link: str | None, at: ArrayLike | None, *, of_rod: bool = False) -> str:
    """Reject an invalid place of a robot, or a place that is not on a rod; return a name for the place."""
    # An empty set of states checks only the place.
    none = np.empty((0, robot.n))
    try:
        if of_rod:
            robot.strain(none, at, link=link)
        else:
            robot.pose(none, at, link=link, t=np.empty(0))
    except (ValueError, TypeError) as refused:
        # The core calls arc lengths X.
        raise type(refused)(re.sub(r"^X\b", "at", str(refused))) from None
    name = robot.links[0].name if link is None else link
    return name if at is None else f"{name}[{', '.join(f'{x:g}' for x in np.atleast_1d(np.asarray(at)))}]"


@dataclass(frozen=True, eq=False)
class Placed(Sensor):
    """An instrument at a point of a link."""

    link: str | None = None
    at: float | None = None
    _: KW_ONLY
    point: ArrayLike = (0.0, 0.0, 0.0)
    _where: str = field(init=False, repr=False)
    #: The point, if it is not the origin of the section or body.
    _lever: Array | None = field(init=False, repr=False)

    def _check(self) -> None:
        if self.at is not None:
            self._set("at", number(self.at, "at"))
        self._set("_where", check(self.robot, self.link, self.at))
        self._set("point", _vector(self.point, "point", 3))
        lever = np.array(self.point, dtype=float)
        self._set("_lever", lever if lever.any() else None)

    def _place(self) -> str:
        return self._where

    def _poses(self, given: States) -> tuple[Array, Array]:
        """Rotations (k, 3, 3) and positions (k, 3) of the section or body."""
        poses = self.robot.pose(given.q, self.at, link=self.link, t=given.t)
        return poses[:, :3, :3], poses[:, :3, 3]

    def _velocities(self, given: States) -> tuple[Array, Array]:
        """Angular velocities and velocities (k, 3) of the section or body."""
        found = self.robot.velocity(given.q, known(given.v), self.at, link=self.link, t=given.t)
        return found[:, :3], found[:, 3:]

    def _accelerations(self, given: States) -> tuple[Array, Array]:
        """Angular accelerations and accelerations (k, 3) of the section or body."""
        motion = (given.q, known(given.v), known(given.a))
        found = self.robot.acceleration(*motion, self.at, link=self.link, t=given.t)
        return found[:, :3], found[:, 3:]


@dataclass(frozen=True, eq=False)
class Mounted(Placed):
    """An instrument at a place of a link with its own axes."""

    _: KW_ONLY
    orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0)
    #: Rotation of its axes, if they differ from those of the section or body.
    _axes: Array | None = field(init=False, repr=False)

    def _check(self) -> None:
        super()._check()
        orientation = _vector(self.orientation, "orientation", 4)
        norm = float(np.linalg.norm(orientation))
        if abs(norm - 1) > QUATERNION_TOLERANCE:
            expected = "expected a quaternion (w, x, y, z) of norm 1"
            raise ValueError(f"orientation: got a quaternion of norm {norm:g}, {expected}")
        orientation = tuple(x / norm for x in orientation)
        self._set("orientation", orientation)
        self._set("_axes", matrix_of(orientation) if any(orientation[1:]) else None)

    def _in_axes(self, rotations: Array, vectors: Array) -> Array:
        """Convert world vectors (k, 3) to the axes of the instrument."""
        seen = turned_back(rotations, vectors)
        return seen if self._axes is None else turned_back(self._axes, seen)


def known(part: Array | None) -> Array:
    assert part is not None, "states have what a sensor needs"
    return part


def _vector(value: ArrayLike, name: str, size: int) -> tuple[float, ...]:
    array = finite_array(value, name)
    if array.shape != (size,):
        raise ValueError(f"{name}: expected {size} numbers, got shape {array.shape}")
    return tuple(array.tolist())
