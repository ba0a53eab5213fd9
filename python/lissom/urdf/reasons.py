"""Reasons for which content of a URDF file is not imported."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from functools import lru_cache

from .problems import LONGEST_KEY

NO_MIMIC = "this joint has not one coordinate that could follow another one"
NO_STOPS = "stops are stiff springs, and URDF has no stiffness for them: give limit_stiffness"
NO_ROOM = (
    "lower and upper are the same: stops need room between them; write type='fixed' for a joint that stays"
)
NO_LIMIT = "URDF asks for a <limit> of a joint of this type, and there is none: the joint moves without stops"
NO_LIMITS = "a joint of this type has no stops in lissom"
MENDED = "no body has such moments of inertia: the nearest ones that a body can have are taken"
NO_FORCES = "joints of this type have no damping and friction in lissom"
NO_AXIS = "a joint of this type has no axis"
_EFFORT = "a limit of the drive: robots have none until a `Motor` with `limits` is given to them"
_DRIVE = "a limit of the drive; a `Motor` limits torque and force only"
_PICTURE = "only for pictures"
PICTURES_ON_REQUEST = "only for pictures; read on request: give visuals=True"
NO_TEXTURE = "textures are not read; the part has one colour"
_CONTACT = "shapes for contact are not read"
ON_REQUEST = "shapes for contact are read on request: give collisions=True"
NO_MESH = "meshes are not read as shapes for contact; a `ConvexMesh` holds a convex hull"
NO_LOOPS_HERE = "loops are read in Python only: the robot stays open there, unless the scene has a loop"
SIMPLIFIED = "for pictures the mesh is simplified to {most} triangles: it has {triangles}"
NAMESPACE = "a namespace declaration says nothing about the robot"
TEXT = "text means nothing here: URDF says all in elements and attributes"

#: Entries that affect the robot's motion come first in a summary.
FIRST = (NO_LOOPS_HERE, NO_MIMIC, MENDED, NO_STOPS, NO_ROOM, NO_LIMIT, NO_LIMITS, NO_FORCES)

_OTHER_SIMULATORS = "settings of another simulator"
_CONTROL = "drives and controllers are not part of a robot here"
REASONS: Mapping[str, Mapping[str, str]] = {
    "robot": {
        "@version": "the file is read in the same way whatever its version",
        "material": _PICTURE,
        "transmission": "gears and drives are not read; `armature` of a joint is the inertia of its rotor",
        "gazebo": _OTHER_SIMULATORS,
        "mujoco": _OTHER_SIMULATORS,
        "drake": _OTHER_SIMULATORS,
        "sensor": "a sensor does not move the robot",
        "ros2_control": _CONTROL,
    },
    "link": {
        "visual": _PICTURE,
        "collision": _CONTACT,
        "contact": _CONTACT,
        "sensor": "a sensor does not move the robot",
        "gazebo": _OTHER_SIMULATORS,
    },
    "joint": {
        "safety_controller": _CONTROL,
        "calibration": _CONTROL,
        "gazebo": _OTHER_SIMULATORS,
    },
    "collision": {"material": _PICTURE, "drake:proximity_properties": _OTHER_SIMULATORS},
    "loop_joint": {"limit": NO_LIMITS, "dynamics": NO_FORCES},
    "limit": {"@effort": _EFFORT, "@velocity": _DRIVE, "@acceleration": _DRIVE, "@jerk": _DRIVE},
}


def nearest(word: str, words: Iterable[str], likeness: float = 0.6) -> str | None:
    if len(word) > LONGEST_KEY:
        return None
    return next(iter(get_close_matches(word, words, 1, likeness)), None)


@lru_cache(1000)
def unknown(what: str, name: str, known: tuple[str, ...]) -> str:
    """Reason for not importing an unknown element or attribute, with a suggestion if there is one."""
    guess = nearest(name.lower(), known, 0.75)
    return f"an unknown {what}; did you mean {guess}?" if guess else f"an unknown {what}"
