"""What to use in place of names that do not exist, in words of other programs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

#: Names of other programs and of American English, by what lissom has.
NAMES: Mapping[str, str] = {
    "linearize": "linearise",
    "integrate": "simulate",
    "solve": "simulate",
    "run": "simulate",
    "odeint": "solve_ivp",
    "fsolve": "root",
    "equilibrium": "statics",
    "eigenmodes": "modes",
    "Beam": "Rod",
    "CosseratRod": "Rod",
    "Spring": "Support",
    "Cable": "Tendon",
    "Wire": "Rod",
    "Force": "Load",
    "Gravity": "Robot",
    "Plane": "HalfSpace",
    "Floor": "HalfSpace",
    "Ground": "HalfSpace",
    "Cylinder": "Capsule",
    "Mesh": "ConvexMesh",
    "Hinge": "Revolute",
    "Slider": "Prismatic",
    "Fixed": "Weld",
    "Muscle": "Chamber",
    "Material": "Segment",
}


def of_package(name: str, known: Iterable[str]) -> str:
    """What to use in place of a name of the package; empty if there is nothing like it."""
    if name in NAMES:
        return f"; use lissom.{NAMES[name]}"
    from .._lissom import meant

    # Names of Python's own protocols, such as `__path__`, stand for nothing.
    if name.startswith("_"):
        return ""
    names = list(known)
    close = next((each for each in names if each.lower() == name.lower()), None) or meant(name, names)
    return f"; did you mean {close!r}?" if close else ""
