"""What to use in place of names that do not exist, in words of other programs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NoReturn

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


#: Materials, which have no names in lissom.
MATERIALS = ("steel", "aluminium", "aluminum", "nitinol", "rubber", "silicone", "ecoflex")


def no_attribute(thing: object, name: str, instead: Mapping[str, str]) -> NoReturn:
    """Raise AttributeError for an attribute that a thing does not have, with what to use instead."""
    sentence = f"'lissom.{type(thing).__name__}' object has no attribute {name!r}"
    hint = instead.get(name)
    raise AttributeError(f"{sentence}: {hint}" if hint else sentence, name=name, obj=thing)


def of_package(name: str, known: Iterable[str]) -> str:
    """What to use in place of a name of the package; empty if there is nothing like it."""
    if name in NAMES:
        return f"; use lissom.{NAMES[name]}"
    from .._lissom import did_you_mean, meant

    if name.lower() in MATERIALS:
        return f"; {did_you_mean('material', ('young_modulus', 'density'))}"
    # Names of Python's own protocols, such as `__path__`, stand for nothing.
    if name.startswith("_"):
        return ""
    names = list(known)
    close = next((each for each in names if each.lower() == name.lower()), None) or meant(name, names)
    return f"; did you mean {close!r}?" if close else ""
