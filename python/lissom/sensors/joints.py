"""Instruments of joints: encoders and tachometers."""

from __future__ import annotations

from dataclasses import dataclass, field
from reprlib import repr
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from .._lissom import Robot
from ..common.arguments import suggesting, text
from ..model.views import JOINTS, STRAINS
from .places import known
from .sensor import Sensor
from .states import States

Array = NDArray[np.float64]


def _within(coordinate: str) -> str:
    """Name of a coordinate within its link: "angle", or "bend_y" for "arm.bend_y[0]"."""
    return coordinate.rpartition(".")[2].partition("[")[0]


def _of_joints(robot: Robot) -> list[int]:
    return [i for i, name in enumerate(robot.coordinates) if _within(name) not in STRAINS]


def indices(robot: Robot, joint: str) -> list[int]:
    """Indices of the coordinates of a link's joint, or of a single coordinate, by name; empty for unknown
    names."""
    of_joints = _of_joints(robot)
    named = [i for i in of_joints if robot.coordinates[i] == joint]
    if named or joint not in (link.name for link in robot.links):
        return named
    own = range(robot.n)[robot.slice(joint)]
    return [i for i in of_joints if i in own]


def unit(coordinate: str) -> str:
    """Unit of a joint's coordinate."""
    return JOINTS[_within(coordinate).partition("_")[0]][1]


@dataclass(frozen=True, eq=False)
class OfJoint(Sensor):
    """An instrument at a joint."""

    joint: str | None = None
    #: Indices and names of its coordinates.
    _indices: tuple[int, ...] = field(init=False, repr=False)
    _names: tuple[str, ...] = field(init=False, repr=False)

    def _check(self) -> None:
        names, of_joints = self.robot.coordinates, _of_joints(self.robot)
        joint = self.joint
        if joint is None and len(of_joints) == 1:
            joint = names[of_joints[0]]
        found = indices(self.robot, text("joint", joint)) if joint is not None else []
        if not found:
            expected = ", ".join(repr(names[i]) for i in of_joints) or "none in this robot"
            raise ValueError(
                f"joint: got {repr(joint)}, expected a link whose joint has coordinates, or one of them: "
                f"{expected}"
            )
        self._set("joint", joint)
        self._set("_indices", tuple(found))
        self._set("_names", tuple(names[i] for i in found))

    def _place(self) -> str:
        return str(self.joint)

    @property
    def _units(self) -> tuple[str, ...]:
        return tuple(map(unit, self._names))


@suggesting
@dataclass(frozen=True, eq=False)
class Encoder(OfJoint):
    """An encoder: the coordinates of a joint, radians and metres.

    The channels have the names of the coordinates. Joints with a prescribed motion or `mimic` have none.

    Parameters
    ----------
    robot : Robot
        Robot with the joint.
    joint : str, optional
        Name of a link, for all coordinates of its joint, or one of `Robot.coordinates`. Optional if the robot
        has only one joint coordinate.
    name, noise, bias, rate, delay, seed
        Those of every `Sensor`.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.
    """

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured quantities."""
        return self._names

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return self._units

    def _ideal(self, given: States) -> Array:
        return given.q[:, self._indices]


@suggesting
@dataclass(frozen=True, eq=False)
class Tachometer(OfJoint):
    """A tachometer: the rates of a joint's coordinates, radians and metres per second.

    Parameters
    ----------
    robot : Robot
        Robot with the joint.
    joint : str, optional
        Name of a link, for all coordinates of its joint, or one of `Robot.coordinates`. Optional if the robot
        has only one joint coordinate.
    name, noise, bias, rate, delay, seed
        Those of every `Sensor`.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.
    """

    NEEDS: ClassVar[str] = "v"

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured quantities."""
        return tuple(f"{name}.rate" for name in self._names)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return tuple(f"{unit}/s" for unit in self._units)

    def _ideal(self, given: States) -> Array:
        return known(given.v)[:, self._indices]
