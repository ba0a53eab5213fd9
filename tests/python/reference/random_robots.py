"""Hypothesis strategies for robots, as descriptions for `robot.build`, and for their states.

Trees with chains of up to five links, all joints, rods and bodies, attached to the world, to bodies, and at
the base, in the middle or at the tip of rods. Every coordinate has inertia: links without mass are not drawn.
Sizes are those of tabletop objects: decimetres, kilograms, soft rubber.
"""

import numpy as np
from hypothesis import strategies as st

from reference.robot import build
from reference.rod import STRAINS

DEPTH = 5
#: Rounding must not make a rotation vector longer than pi.
ALMOST_PI = np.pi * (1 - 1e-15)
#: Numbers are drawn with this many digits, so that failing examples are readable.
DIGITS = 3
JOINTS = ("weld", "revolute", "prismatic", "screw", "cylindrical", "universal", "planar", "spherical", "free")

seeds = st.integers(0, 2**32 - 1)


def numbers(low, high):
    return st.floats(low, high).map(lambda x: round(x, DIGITS))


def vectors(size):
    return st.tuples(*[numbers(-size, size)] * 3)


#: Nonzero vectors of any length; arguments that are axes are normalised.
axes = vectors(2.0).filter(lambda axis: np.linalg.norm(axis) > 0.1)


@st.composite
def quaternions(draw):
    """Unit quaternions of all rotations, up to rounding."""
    q = np.array(draw(st.tuples(*[numbers(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)))
    return tuple((q / np.linalg.norm(q)).tolist())


@st.composite
def inertia_tensors(draw, mass):
    """Inertia of four equal masses within decimetres, and of a small sphere."""
    points = np.array(draw(st.tuples(*[vectors(0.15)] * 4)))
    points = points - points.mean(axis=0)
    tensor = mass * (np.trace(points.T @ points) * np.eye(3) - points.T @ points) / 4
    return (tensor + 1e-3 * mass * np.eye(3)).tolist()


@st.composite
def rigid_bodies(draw):
    mass = draw(numbers(0.05, 2.0))
    return {"mass": mass, "centre": draw(vectors(0.1)), "inertia": draw(inertia_tensors(mass))}


@st.composite
def segments(draw, max_modes):
    """Soft rubber with reference strains of all kinds."""
    radius, bend, shear = numbers(0.01, 0.04), numbers(-1.5, 1.5), numbers(-0.1, 0.1)
    return {
        "length": draw(numbers(0.1, 0.5)),
        "radius": draw(st.one_of(radius, st.tuples(radius, radius))),
        "young_modulus": 1e5,
        "shear_modulus": 4e4,
        "density": draw(numbers(500, 2000)),
        "modes": draw(st.dictionaries(st.sampled_from(STRAINS), st.integers(1, max_modes), max_size=3)),
        "retardation_time": draw(st.sampled_from([0.0, 0.01])),
        "reference_strain": draw(st.tuples(bend, bend, bend, numbers(0.9, 1.1), shear, shear)),
    }


def apart(first, second):
    """Whether two axes are at least about ten degrees apart."""
    return np.linalg.norm(np.cross(first, second)) > 0.2 * np.linalg.norm(first) * np.linalg.norm(second)


@st.composite
def joints(draw, kinds):
    """A joint; those with one coordinate may have a spring, a damper and an armature."""
    joint = {"type": draw(st.sampled_from(kinds))}
    if joint["type"] in ("revolute", "prismatic", "screw", "cylindrical"):
        joint["axis"] = draw(axes)
    if joint["type"] == "screw":
        joint["lead"] = draw(numbers(-2, 2))
    if joint["type"] == "universal":
        joint["axis1"] = first = draw(axes)
        joint["axis2"] = draw(axes.filter(lambda axis: apart(first, axis)))
    if joint["type"] == "planar":
        joint["normal"] = draw(axes)
    if joint["type"] in ("revolute", "prismatic", "screw") and draw(st.booleans()):
        joint["stiffness"], joint["rest"] = draw(numbers(0, 5)), draw(numbers(-1, 1))
        joint["damping"], joint["armature"] = draw(numbers(0, 1)), draw(numbers(0, 0.1))
    return joint


def length(link):
    return sum(segment["length"] for segment in link["rod"])


@st.composite
def links(draw, others, depths, kinds, max_modes):
    """A link attached to one of the others, or to the world."""
    name = f"link{len(others)}"
    link = {"name": name, "joint": draw(joints(kinds))}
    if draw(st.booleans()):
        link["rod"] = draw(st.lists(segments(max_modes), min_size=1, max_size=2))
    else:
        link["body"] = draw(rigid_bodies())
    if draw(st.booleans()):
        link["position"], link["orientation"] = draw(vectors(0.2)), draw(quaternions())
    parents = [other for other in others if depths[other["name"]] < DEPTH]
    # Mostly attached to the last link, so that trees become deep.
    parent = draw(st.sampled_from([None, *parents, *parents[-1:] * 3]))
    depths[name] = 1
    if parent is not None:
        link["parent"], depths[name] = parent["name"], depths[parent["name"]] + 1
        fraction = draw(st.sampled_from([None, 0.0, 0.37, 0.5, 1.0]))
        if "rod" in parent and fraction is not None:
            link["at"] = fraction * length(parent)
    return link


@st.composite
def loads(draw, link):
    """A dead or follower load anywhere on a link."""
    load = {
        "link": link["name"],
        "force": draw(vectors(2.0)),
        "moment": draw(vectors(0.3)),
        "frame": draw(st.sampled_from(["world", "body"])),
    }
    place = draw(st.sampled_from(["tip", "at", "along"]))
    if "rod" in link and place == "at":
        load["at"] = draw(st.sampled_from([0.3, 0.5, 1.0])) * length(link)
    elif "rod" in link and place == "along":
        load["along"] = (0.1 * length(link), draw(st.sampled_from([0.6, 1.0])) * length(link))
    return load


@st.composite
def robots(draw, max_links=6, kinds=JOINTS, floating=False, max_modes=2):
    """A description with at least one coordinate; `floating`: one tree whose first link has a free joint."""
    made, depths = [], {}
    for _ in range(draw(st.integers(1, max_links))):
        link = draw(links(made, depths, kinds, max_modes))
        if floating and not made:
            link["joint"] = {"type": "free"}
        elif floating and "parent" not in link:
            link["parent"], depths[link["name"]] = made[0]["name"], 2
        made.append(link)
    description = {"gravity": draw(vectors(10.0)), "links": made}
    if build(description).n == 0:
        made[-1]["joint"] = {"type": "spherical"}
    description["loads"] = draw(st.lists(st.sampled_from(made).flatmap(loads), max_size=2))
    return description


def coordinate_scale(robot):
    """The unit of each coordinate: one for joints, a radian over a segment or a tenth for rods."""
    scale = np.ones(robot.n)
    for link, dofs in zip(robot.links, robot.rod_dofs, strict=True):
        scale[dofs] = [
            1 / segment.length if strain < 3 else 0.1
            for segment in link.rod or ()
            for strain in segment.coordinates[0]
        ]
    return scale


def random_states(robot, seed, size=0.5):
    """q, v, a, shape (3, n). Rotation vectors have any length up to pi, including zero and pi."""
    rng = np.random.default_rng(seed)
    states = size * coordinate_scale(robot) * rng.standard_normal((3, robot.n))
    for link, dofs in zip(robot.links, robot.joint_dofs, strict=True):
        phi = states[0, dofs][link.joint.rotation_vector]
        angle = rng.choice([0.0, ALMOST_PI, *rng.uniform(0, np.pi, 6)])
        if phi.size:
            phi[:] *= angle / np.linalg.norm(phi)
    return states
