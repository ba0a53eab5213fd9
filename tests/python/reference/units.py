"""Descriptions of robots and their coordinates in other units of length, mass and time."""

import dataclasses

import numpy as np

import lissom

#: Powers of length, mass and time.
L, M, T = np.eye(3)
ONE, FORCE = np.zeros(3), L + M - 2 * T

#: Fields of descriptions with their dimensions, or None for names and for numbers without dimension. Fields
#: of dataclasses that are not listed are converted themselves.
FIELDS = {
    "Link": {"at": L, "position": L},
    "Revolute": {
        "stiffness": FORCE + L,
        "damping": FORCE + L + T,
        "friction": FORCE + L,
        "friction_velocity": -T,
        "limit_stiffness": FORCE + L,
        "limit_dissipation": T,
        "armature": M + 2 * L,
    },
    "Prismatic": {
        "stiffness": FORCE - L,
        "rest": L,
        "damping": FORCE - L + T,
        "friction": FORCE,
        "friction_velocity": L - T,
        "limits": L,
        "limit_stiffness": FORCE - L,
        "limit_dissipation": T - L,
        "armature": M,
    },
    "Body": {"mass": M, "at": L, "centre": L, "inertia": M + 2 * L, "link": None},
    "Segment": {
        "length": L,
        "radius": L,
        "young_modulus": FORCE - 2 * L,
        "shear_modulus": FORCE - 2 * L,
        "density": M - 3 * L,
        "modes": None,
        "retardation_time": T,
        "nodes": None,
    },
    "Load": {"force": FORCE, "moment": FORCE + L, "at": L, "frame": None, "link": None},
    "Via": {"point": L, "at": L},
    "Along": {"offset": L, "along": L},
    "Tendon": {
        "tension": FORCE,
        "length": L,
        "stiffness": FORCE - L,
        "damping": FORCE - L + T,
        "friction_velocity": L - T,
    },
    "LoopEnd": {"at": L, "position": L},
    "Distance": {"length": L},
    "HalfSpace": {"point": L, "at": L},
    "Ball": {"radius": L, "at": L, "position": L},
    "Contact": {
        "stiffness": FORCE - L,
        "dissipation": T - L,
        "slip_velocity": L - T,
        "stribeck_velocity": L - T,
        "patch_radius": L,
    },
}

#: What a unit of coordinates is, by how their names end.
COORDINATES = {"x": L, "y": L, "z": L, "displacement": L, "bend_y": -L, "bend_z": -L, "torsion": -L}


def scaled(value, dimension, units):
    """A number, an array or an input in other units."""
    if isinstance(value, lissom.Input):
        return lissom.Input(value.name, scaled(value.default, dimension, units))
    factor = float(np.prod(np.asarray(units, float) ** dimension))
    return (factor * np.asarray(value, float)).tolist()


def converted(thing, units):
    """A whole description, or a part of one, in other units."""
    if isinstance(thing, lissom.Robot):
        parts = ("loads", "bodies", "supports", "actuators", "loops", "contacts")
        parts = {part: converted(getattr(thing, part), units) for part in parts}
        return lissom.Robot(
            converted(thing.links, units), gravity=scaled(thing.gravity, L - 2 * T, units), **parts
        )
    if isinstance(thing, list | tuple) and not isinstance(thing[0] if thing else 0.0, float | int):
        return [converted(part, units) for part in thing]
    fields = FIELDS.get(type(thing).__name__, {})
    names = (
        [field.name for field in dataclasses.fields(thing)]
        if dataclasses.is_dataclass(thing)
        else list(fields)
    )
    if not names:
        return thing
    values = {}
    for name in names:
        value, dimension = getattr(thing, name), fields.get(name, ONE)
        if value is None or dimension is None:
            values[name] = value
        elif dimension is ONE:
            values[name] = converted(value, units)
        else:
            values[name] = scaled(value, dimension, units)
    return type(thing)(**values)


def shape(robot, q, units):
    """Coordinates in other units."""
    dimensions = [COORDINATES.get(name.split(".")[-1].split("[")[0], ONE) for name in robot.coordinates]
    return np.array([scaled(x, dimension, units) for x, dimension in zip(q, dimensions, strict=True)])


def same(robot, found, expected, units, tolerance=1e-6):
    """Whether a shape is the expected one in other units, beside the largest coordinate of each dimension."""
    expected = shape(robot, expected, units)
    kinds = [name.split(".")[-1].split("[")[0] for name in robot.coordinates]
    for kind in set(kinds):
        own = [k for k, other in enumerate(kinds) if COORDINATES.get(other) is COORDINATES.get(kind)]
        size = max(
            np.abs(expected[own]).max(),
            1e-3 * np.prod(np.asarray(units, float) ** COORDINATES.get(kind, ONE)),
        )
        np.testing.assert_allclose(found[own], expected[own], rtol=0, atol=tolerance * size)
