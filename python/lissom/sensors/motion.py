"""Instruments of motion at a place: markers, trackers, velocimeters, gyroscopes, accelerometers, IMUs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import suggesting
from .places import Mounted, Placed
from .states import States
from .turning import cross, exponentials, products, quaternions_of, turned, upright

Array = NDArray[np.float64]


def _axes(name: str, *what: str) -> tuple[str, ...]:
    return tuple(f"{name}.{each}{axis}" for each in what for axis in "xyz")


@suggesting
@dataclass(frozen=True, eq=False)
class Marker(Placed):
    """A motion-capture marker: the world position of its point, metres.

    Parameters
    ----------
    robot : Robot
        Robot that carries the sensor.
    link : str, optional
        Name of the link; optional if the robot has only one.
    at : float, optional
        Arc length of the link's unstretched rod, 0 <= at <= length, metres; by default its tip. None for a
        rigid link.
    point : array_like, shape (3,)
        Position of the sensor in the axes of the section or body, metres.
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
        return _axes(self.name, "")

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return ("m",) * 3

    def _ideal(self, given: States) -> Array:
        rotations, positions = self._poses(given)
        return positions if self._lever is None else positions + turned(rotations, self._lever)


@suggesting
@dataclass(frozen=True, eq=False)
class PoseTracker(Mounted):
    """An optical or electromagnetic tracker: its world position, metres, and orientation.

    The orientation is a unit quaternion (w, x, y, z) with w >= 0. Noise and bias have six components:
    position along the world axes, metres, and a rotation vector in the axes of the tracker, radians.

    Parameters
    ----------
    robot : Robot
        Robot that carries the sensor.
    link : str, optional
        Name of the link; optional if the robot has only one.
    at : float, optional
        Arc length of the link's unstretched rod, 0 <= at <= length, metres; by default its tip. None for a
        rigid link.
    point : array_like, shape (3,)
        Position of the sensor in the axes of the section or body, metres.
    orientation : array_like, shape (4,)
        Quaternion (w, x, y, z) of the sensor's axes in those of the section or body.
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
        return (*_axes(self.name, ""), *(f"{self.name}.q{part}" for part in "wxyz"))

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return ("m",) * 3 + ("1",) * 4

    def _ideal(self, given: States) -> Array:
        rotations, positions = self._poses(given)
        if self._lever is not None:
            positions = positions + turned(rotations, self._lever)
        quaternions = quaternions_of(rotations)
        if self._axes is not None:
            quaternions = upright(products(quaternions, np.array([self.orientation])))
        return np.concatenate([positions, quaternions], axis=1)

    def _errors(self) -> int:
        return 6

    def _with_errors(self, ideal: Array, errors: Array) -> Array:
        turns = upright(products(ideal[:, 3:], exponentials(errors[:, 3:])))
        return np.concatenate([ideal[:, :3] + errors[:, :3], turns], axis=1)


@suggesting
@dataclass(frozen=True, eq=False)
class Velocimeter(Mounted):
    """A velocimeter: the world velocity of its point in its own axes, metres per second.

    Parameters
    ----------
    robot : Robot
        Robot that carries the sensor.
    link : str, optional
        Name of the link; optional if the robot has only one.
    at : float, optional
        Arc length of the link's unstretched rod, 0 <= at <= length, metres; by default its tip. None for a
        rigid link.
    point : array_like, shape (3,)
        Position of the sensor in the axes of the section or body, metres.
    orientation : array_like, shape (4,)
        Quaternion (w, x, y, z) of the sensor's axes in those of the section or body.
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
        return _axes(self.name, "velocity_")

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return ("m/s",) * 3

    def _ideal(self, given: States) -> Array:
        rotations, _ = self._poses(given)
        rates, velocities = self._velocities(given)
        if self._lever is not None:
            velocities = velocities + cross(rates, turned(rotations, self._lever))
        return self._in_axes(rotations, velocities)


@dataclass(frozen=True, eq=False)
class Inertial(Mounted):
    """Base class of gyroscopes and accelerometers."""

    def _proper_accelerations(self, given: States, rotations: Array, rates: Array) -> Array:
        """The specific force on an instrument: its acceleration minus that of gravity."""
        growths, accelerations = self._accelerations(given)
        felt = accelerations - np.array(self.robot.gravity)
        if self._lever is not None:
            lever = turned(rotations, self._lever)
            felt = felt + cross(growths, lever) + cross(rates, cross(rates, lever))
        return self._in_axes(rotations, felt)


@suggesting
@dataclass(frozen=True, eq=False)
class Gyroscope(Inertial):
    """A gyroscope: its angular velocity in its own axes, radians per second.

    Its position on the section or body does not matter.

    Parameters
    ----------
    robot : Robot
        Robot that carries the sensor.
    link : str, optional
        Name of the link; optional if the robot has only one.
    at : float, optional
        Arc length of the link's unstretched rod, 0 <= at <= length, metres; by default its tip. None for a
        rigid link.
    point : array_like, shape (3,)
        Position of the sensor in the axes of the section or body, metres.
    orientation : array_like, shape (4,)
        Quaternion (w, x, y, z) of the sensor's axes in those of the section or body.
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
        return _axes(self.name, "angular_velocity_")

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return ("rad/s",) * 3

    def _ideal(self, given: States) -> Array:
        return self._in_axes(self._poses(given)[0], self._velocities(given)[0])


@suggesting
@dataclass(frozen=True, eq=False)
class Accelerometer(Inertial):
    """An accelerometer: the specific force at its point in its own axes, metres per second squared.

    The specific force is the acceleration minus that of gravity: 9.81 m/s^2 upwards at rest, zero in free
    fall.

    Parameters
    ----------
    robot : Robot
        Robot that carries the sensor.
    link : str, optional
        Name of the link; optional if the robot has only one.
    at : float, optional
        Arc length of the link's unstretched rod, 0 <= at <= length, metres; by default its tip. None for a
        rigid link.
    point : array_like, shape (3,)
        Position of the sensor in the axes of the section or body, metres.
    orientation : array_like, shape (4,)
        Quaternion (w, x, y, z) of the sensor's axes in those of the section or body.
    name, noise, bias, rate, delay, seed
        Those of every `Sensor`.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.
    """

    NEEDS: ClassVar[str] = "va"

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured quantities."""
        return _axes(self.name, "specific_force_")

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return ("m/s^2",) * 3

    def _ideal(self, given: States) -> Array:
        return self._proper_accelerations(given, self._poses(given)[0], self._velocities(given)[0])


@suggesting
@dataclass(frozen=True, eq=False)
class Imu(Inertial):
    """An inertial measurement unit: a gyroscope and an accelerometer.

    It measures angular velocity, radians per second, and specific force, metres per second squared, at its
    point in its own axes. The channels are those of a `Gyroscope` followed by those of an `Accelerometer`.

    Parameters
    ----------
    robot : Robot
        Robot that carries the sensor.
    link : str, optional
        Name of the link; optional if the robot has only one.
    at : float, optional
        Arc length of the link's unstretched rod, 0 <= at <= length, metres; by default its tip. None for a
        rigid link.
    point : array_like, shape (3,)
        Position of the sensor in the axes of the section or body, metres.
    orientation : array_like, shape (4,)
        Quaternion (w, x, y, z) of the sensor's axes in those of the section or body.
    name, noise, bias, rate, delay, seed
        Those of every `Sensor`.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.

    Examples
    --------
    At the end of a pendulum that passes its lowest point at 3 rad/s:

    >>> import lissom
    >>> bob = lissom.Body(0.1, centre=(0.5, 0, 0))
    >>> robot = lissom.Robot([lissom.Link("bob", joint=lissom.Revolute((0, 1, 0)), body=bob)])
    >>> imu = lissom.sensors.Imu(robot, point=(0.5, 0, 0))
    >>> q, v = [lissom.statics(robot, [1.5]).q[0]], [3.0]
    >>> imu.measure(0.0, q, v, robot.forward_dynamics(q, v)).round(9) + 0.0
    array([  0.  ,   3.  ,   0.  , -14.31,   0.  ,   0.  ])
    """

    NEEDS: ClassVar[str] = "va"

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured quantities."""
        return _axes(self.name, "angular_velocity_", "specific_force_")

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return ("rad/s",) * 3 + ("m/s^2",) * 3

    def _ideal(self, given: States) -> Array:
        rotations, _ = self._poses(given)
        rates, _ = self._velocities(given)
        turns = self._in_axes(rotations, rates)
        return np.concatenate([turns, self._proper_accelerations(given, rotations, rates)], axis=1)
