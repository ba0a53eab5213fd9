"""Simulated sensors on robots, with noise, bias, sampling and delay.

A sensor belongs to a `Robot` and to a place or joint of it. There are four ways to use it:

- `measure`: the ideal measurement in one or many states, a function of the state only;
- `read`: the current reading in a loop, with sampling rate, noise, bias and delay;
- `observe`: the same for an object that has the state, such as a `Simulation`;
- `record`: the same over a finished run, all at once.

Without noise, `read` and `record` agree bit for bit. With noise of the same seed they do, too, if the noise
is additive (that of orientations is a rotation).
"""

from typing import TYPE_CHECKING, NoReturn

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

#: Instruments in words of other programs.
INSTEAD = {
    **dict.fromkeys(("IMU", "InertialMeasurementUnit"), "Imu"),
    **dict.fromkeys(("TendonLength", "CableLength", "StringPot"), "ActuatorLength"),
    **dict.fromkeys(("TendonForce", "TendonTension", "Tension", "Pressure", "MotorTorque"), "ActuatorForce"),
    **dict.fromkeys(("LoadCell", "ForceSensor", "FTSensor", "Force", "Torque", "Wrench"), "ForceTorque"),
    **dict.fromkeys(("Position", "FramePos", "Mocap", "MotionCapture", "Tip"), "Marker"),
    **dict.fromkeys(("Pose", "Frame", "Orientation", "FrameQuat"), "PoseTracker"),
    "Gyro": "Gyroscope",
    **dict.fromkeys(("JointPosition", "JointPos", "Angle", "Potentiometer"), "Encoder"),
    **dict.fromkeys(("JointVelocity", "JointVel"), "Tachometer"),
    **dict.fromkeys(("Touch", "TouchSensor", "Contact"), "ContactForce"),
    **dict.fromkeys(("FlexSensor", "BendSensor", "FBG", "ShapeSensor", "Curvature"), "CurvatureSensor"),
}

if not TYPE_CHECKING:

    def __getattr__(name: str) -> NoReturn:
        from ..common.elsewhere import of_module

        raise AttributeError(of_module(__name__, name, __all__, INSTEAD), name=name)
