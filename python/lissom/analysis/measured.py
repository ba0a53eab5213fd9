"""Sensors as outputs of linear models."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import LissomError, Model
from ..sensors.forces import ForceTorque
from ..sensors.sensor import Sensor

Array = NDArray[np.float64]

#: Steps of differences in SI units: the cube root of rounding, where central differences are best, and
#: shorter ones for what bends sooner, such as contacts of micrometres.
STEPS = (6e-6, 2e-7, 6e-9, 2e-10)

#: Differences to both sides that are this equal, relative to the largest of the channels, show no kink.
SAME = 1e-2

#: Changes of readings below this number of rounding units are no kink: readings are sums of larger terms.
ROUNDINGS = 100.0


def sensors_of(model: Model, outputs: Any, inputs: Sequence[str]) -> list[Sensor]:
    """The sensors among the outputs, validated."""
    found = [
        each for each in ([outputs] if isinstance(outputs, Sensor) else outputs) if isinstance(each, Sensor)
    ]
    for sensor in found:
        if sensor.robot != model:
            raise ValueError(
                f"outputs: got the sensor {sensor.name!r} of another robot, expected sensors of this model"
            )
        others = [name for name in inputs if name not in model.inputs]
        if isinstance(sensor, ForceTorque) and others:
            # The sensor measures all forces beyond it, but the robot contains only its own.
            raise ValueError(
                f"inputs: got {others[0]!r}, expected inputs of the model where {sensor.name!r} measures "
                "forces: give the robot a load that is an `Input`"
            )
    if len({sensor.name for sensor in found}) < len(found):
        raise ValueError("outputs: got two sensors of one name, expected different names")
    return found


def readings(
    sensor: Sensor, inputs: Sequence[str], q: Array, t: float, u: ArrayLike | None
) -> tuple[list[str], Callable[[], Array]]:
    """The channels of a sensor, and their derivatives by coordinates, velocities, accelerations and inputs.

    About rest, by central differences: (channels, 3 n + inputs).
    """
    robot, n = sensor.robot, len(q)
    u0 = np.array(robot.u0 if u is None else u, float)
    columns = [robot.inputs.index(name) if name in robot.inputs else None for name in inputs]

    def reading(x: Array) -> Array:
        given = u0.copy()
        for column, value in zip(columns, x[3 * n :], strict=True):
            if column is not None:
                given[column] += value
        return sensor.measure(t, q + x[:n], x[n : 2 * n], x[2 * n : 3 * n], given if len(given) else None)

    def rows() -> Array:
        return _derivatives(sensor.name, reading, 3 * n + len(inputs))

    return list(sensor.channels), rows


def _derivatives(name: str, reading: Callable[[Array], Array], count: int) -> Array:
    """Derivatives of a reading at zero by central differences.

    Contacts, slack tendons, friction and angles bend within small distances, or have kinks and jumps: steps
    become shorter until differences to both sides are the same, and the next shorter step says so too.
    """
    here = reading(np.zeros(count))
    tries = [_differences(reading, here, step, count) for step in STEPS]
    found = np.empty((len(here), count))
    for k in range(count):
        good = (i for i in range(len(STEPS) - 1) if _is_derivative(tries[i], tries[i + 1], k))
        best = next(good, None)
        if best is None:
            raise LissomError(
                f"the reading of {name!r} has a kink or a jump at this state (a surface that just touches, "
                "a tendon without tension or of a length that does not stretch, a rotation by half a turn): "
                "there is no derivative; take a state beside it, or outputs by name"
            )
        found[:, k] = tries[best].middle[:, k]
    return found


@dataclass(frozen=True)
class _Differences:
    """Differences of a reading by all variables with one step."""

    #: Means and half the differences of those to both sides, (channels, variables).
    middle: Array
    uneven: Array
    #: What rounding does to them.
    rounding: float


def _differences(reading: Callable[[Array], Array], here: Array, step: float, count: int) -> _Differences:
    moved = step * np.eye(count)
    ahead = np.array([reading(x) - here for x in moved]).T / step
    behind = np.array([here - reading(-x) for x in moved]).T / step
    middle = 0.5 * (ahead + behind)
    # Rounding of the state counts as well as that of the reading.
    size = np.abs(here).max(initial=0.0) + np.abs(middle).max(initial=0.0)
    return _Differences(middle, 0.5 * (ahead - behind), float(ROUNDINGS * np.finfo(float).eps * size / step))


def _is_derivative(this: _Differences, shorter: _Differences, k: int) -> bool:
    """Whether differences by a variable are the same to both sides and with shorter steps."""
    allowed = SAME * np.abs(this.middle[:, k]).max(initial=0.0) + shorter.rounding
    change = np.abs(this.middle[:, k] - shorter.middle[:, k]).max(initial=0.0)
    uneven = max(np.abs(each.uneven[:, k]).max(initial=0.0) for each in (this, shorter))
    return bool(max(change, uneven) <= allowed)
