"""Sensors as outputs of linear models."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import LissomError, Model, jacobian
from ..sensors.forces import ForceTorque
from ..sensors.sensor import Sensor

Array = NDArray[np.float64]


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
            # It measures all forces beyond it, but knows only those of its robot.
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
        found = jacobian(reading, np.zeros(3 * n + len(inputs)), x_scale=_scales(q, n, len(inputs)))
        if not np.isfinite(found).all():
            raise LissomError(f"the reading of {sensor.name!r} has no derivatives at q and t = {t:g}")
        return found

    return list(sensor.channels), rows


def _scales(q: Array, n: int, inputs: int) -> Array:
    """Sizes of coordinates, velocities, accelerations and inputs, from which steps of differences follow."""
    return np.concatenate([np.maximum(np.abs(q), 1.0), np.ones(2 * n + inputs)])
