"""Simulated sensors on robots, with noise, bias, sampling and delay.

A sensor belongs to a `Robot` and to a place or joint of it. There are four ways to use it:

- `measure`: the ideal measurement in one or many states, a function of the state only;
- `read`: the current reading in a loop, with sampling rate, noise, bias and delay;
- `observe`: the same for an object that has the state, such as a `Simulation`;
- `record`: the same over a finished run, all at once.

Without noise, `read` and `record` agree bit for bit. With noise of the same seed they do, too, if the noise
is additive (that of orientations is a rotation).
"""

from .actuators import ActuatorForce, ActuatorLength
from .contacts import ContactForce, Tactile
from .forces import ForceTorque
from .joints import Encoder, Tachometer
from .motion import Accelerometer, Gyroscope, Imu, Marker, PoseTracker, Velocimeter
from .sensor import Sensor
from .strain import CurvatureSensor, StrainGauge

__all__ = [
    "Accelerometer",
    "ActuatorForce",
    "ActuatorLength",
    "ContactForce",
    "CurvatureSensor",
    "Encoder",
    "ForceTorque",
    "Gyroscope",
    "Imu",
    "Marker",
    "PoseTracker",
    "Sensor",
    "StrainGauge",
    "Tachometer",
    "Tactile",
    "Velocimeter",
]
