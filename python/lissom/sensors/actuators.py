"""Instruments of actuators: lengths and tensions of tendons, volumes, pressures, torques."""

from __future__ import annotations

from dataclasses import dataclass, field
from reprlib import repr
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from .._lissom import Motor
from ..common.arguments import suggesting, text
from .joints import indices, unit
from .places import known
from .sensor import Sensor
from .states import States

Array = NDArray[np.float64]

#: Units of the lengths and forces of actuators, by kind.
UNITS = {"Tendon": ("m", "N"), "Chamber": ("m^3", "Pa"), "ActiveStrain": ("J", "1")}

#: The same for motors, by the unit of their coordinate.
UNITS_OF_MOTORS = {"rad": ("rad", "N m"), "m": ("m", "N")}


@dataclass(frozen=True, eq=False)
class OfActuator(Sensor):
    """An instrument on an actuator."""

    actuator: str | None = None
    _units: tuple[str, str] = field(init=False, repr=False)

    def _check(self) -> None:
        given: tuple[Any, ...] = self.robot.actuators
        actuators = {str(each.name): each for each in given}
        name = self.actuator
        if name is None and len(actuators) == 1:
            (name,) = actuators
        if name is not None:
            name = text("actuator", name)
        if name not in actuators:
            names = ", ".join(map(repr, actuators)) or "none in this robot"
            raise ValueError(f"actuator: got {repr(name)}, expected one of the actuators: {names}")
        self._set("actuator", name)
        found = actuators[name]
        if isinstance(found, Motor):
            (moved,) = indices(self.robot, found.joint)
            self._set("_units", UNITS_OF_MOTORS[unit(self.robot.coordinates[moved])])
        else:
            self._set("_units", UNITS[type(found).__name__])

    def _place(self) -> str:
        return str(self.actuator)

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured quantities."""
        return (self.name,)


@suggesting
@dataclass(frozen=True, eq=False)
class ActuatorLength(OfActuator):
    """Length of an actuator: the path length of a tendon, as from a winch encoder, or a chamber's volume.

    Metres or cubic metres; for a motor its coordinate, radians or metres.

    Parameters
    ----------
    robot : Robot
        Robot with the actuator.
    actuator : str, optional
        Name of the actuator; optional if the robot has only one.
    name, noise, bias, rate, delay, seed
        Those of every `Sensor`.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.

    See Also
    --------
    Robot.actuator_length : the measured quantity.
    """

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return self._units[:1]

    def _ideal(self, given: States) -> Array:
        lengths: Array = self.robot.actuator_length(str(self.actuator), given.q, t=given.t)
        return lengths[:, None]


@suggesting
@dataclass(frozen=True, eq=False)
class ActuatorForce(OfActuator):
    """Force of an actuator: the tension of a tendon, as from a load cell, a pressure or a torque.

    Newtons, pascals or newton metres; for an active strain its amount.

    Parameters
    ----------
    robot : Robot
        Robot with the actuator.
    actuator : str, optional
        Name of the actuator; optional if the robot has only one.
    name, noise, bias, rate, delay, seed
        Those of every `Sensor`.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.

    See Also
    --------
    Robot.actuator_force : the measured quantity.
    """

    NEEDS: ClassVar[str] = "v"

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return self._units[1:]

    def _ideal(self, given: States) -> Array:
        state = (given.q, known(given.v))
        forces: Array = self.robot.actuator_force(str(self.actuator), *state, t=given.t, **given.inputs)
        return forces[:, None]
