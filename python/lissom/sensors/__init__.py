"""Sensors of robots: what instruments on a robot show in a motion, with noise, bias, sampling and delay.

A sensor belongs to a `Robot` and a place or joint of it. It can be asked in four ways:

- `measure`: what an ideal one shows in a state, or in many: a function of the state and nothing else;
- `read`: what it shows now, in a loop, a state at a time, with its own rate, noise, bias and delay;
- `observe`: the same of an object that has the state, such as a `Simulation`;
- `record`: the same over a finished run, all at once.

Without noise `read` and `record` give the same numbers to the bit, and so they do with noise of the same
seed, as far as the noise is added (that of orientations is a rotation).
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
