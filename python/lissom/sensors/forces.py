"""Instruments of force: force-torque sensors in joints and sections."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import suggesting
from . import places
from .places import known
from .sensor import Sensor, number
from .states import States
from .turning import turned_back

Array = NDArray[np.float64]


@suggesting
@dataclass(frozen=True, eq=False)
class ForceTorque(Sensor):
    """A massless force-torque sensor: moment and force on the part beyond it, including inertia.

    In newton metres and newtons. In a joint, the moment is about the origin of the joint frame, and the axes
    are those of the link's base. In a section of a rod, both belong to the section, and the forces of
    embedded tendons and chambers are included (`Robot.internal_wrench` by balance).

    Parameters
    ----------
    robot : Robot
        Robot that carries the sensor.
    link : str, optional
        Link whose joint or rod has the sensor; optional if the robot has only one.
    at : float, optional
        Arc length of the link's unstretched rod, 0 <= at <= length, metres; by default the sensor is in the
        joint.
    name, noise, bias, rate, delay, seed
        Those of every `Sensor`.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.

    See Also
    --------
    Robot.joint_wrench, Robot.internal_wrench : the measured quantity.
    """

    link: str | None = None
    at: float | None = None
    _where: str = field(init=False, repr=False)
    #: Arc length of the axes on the link.
    _base: float | None = field(init=False, repr=False)

    NEEDS: ClassVar[str] = "va"

    def _check(self) -> None:
        if self.at is not None:
            self._set("at", number(self.at, "at"))
        where = places.check(self.robot, self.link, self.at, of_rod=self.at is not None)
        self._set("_where", where)
        names = [link.name for link in self.robot.links]
        link = self.robot.links[names.index(self.link) if self.link is not None else 0]
        self._set("link", link.name)
        self._set("_base", None if link.rod is None else 0.0)

    def _place(self) -> str:
        return self._where

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured quantities."""
        return tuple(f"{self.name}.{what}_{axis}" for what in ("moment", "force") for axis in "xyz")

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return ("N m",) * 3 + ("N",) * 3

    def _ideal(self, given: States) -> Array:
        motion = (given.q, known(given.v), known(given.a))
        if self.at is not None:
            return self.robot.internal_wrench(*motion, self.at, link=self.link, t=given.t, **given.inputs)
        assert self.link is not None, "its name is known"
        wrenches = self.robot.joint_wrench(*motion, link=self.link, t=given.t, **given.inputs)
        rotations = self.robot.pose(given.q, self._base, link=self.link, t=given.t)[:, :3, :3]
        halves = [turned_back(rotations, half) for half in (wrenches[:, :3], wrenches[:, 3:])]
        return np.concatenate(halves, axis=1)
