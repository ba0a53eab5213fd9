"""Fixed robots with values of the NumPy reference: `tests/data/robots.json`, for tests of the crate.

    cd tests/python && python -m reference.robot_table        # writes the file anew

The file is an object with the one key "robots", a list of objects:

    name         of the robot
    description  plain values, the arguments of `lissom.Robot`, `Link`, joints, `Segment`, `Body`, `Load`, see
                 `reference.robot.build`; what is absent is as the defaults are, gravity too: (0, 0, -9.81)
    n            number of coordinates
    states       two objects; q is zero in the first, rotation vectors are 3.1 long in the second:
        q, v, a           the state, n numbers each
        tau               forces that the motion needs, n numbers: of inertia, gravity, loads, elasticity,
                          damping, springs and armatures of joints
        mass_matrix       n rows of n numbers
        energy            kinetic, elastic, gravitational, loads (dead forces)
        momentum          of the whole robot, in world axes: 3 numbers
        angular_momentum  about the world's origin, in world axes: 3 numbers
        links             by name, of a rod's tip or a body's frame: "pose", 4 rows of 4 numbers, and
                          "velocity", 6 numbers, angular first, in world axes

SI units. The values are correct to about ten digits of the largest number in each array, as rods are
integrated with tolerances of 1e-12; those of rigid robots to twelve. Quaternions are (w, x, y, z).
"""

import json
import re
from itertools import pairwise
from pathlib import Path

import numpy as np

from reference.random_robots import random_states
from reference.robot import build

PATH = Path(__file__).parents[2] / "data" / "robots.json"
#: Number of digits of the largest number of an array; all numbers of an array have the same decimal places.
DIGITS = 13
#: Length of the rotation vectors in the second state, just within pi.
NEARLY_PI = 3.1

BLOCK = {"mass": 0.4, "centre": [0.05, -0.02, 0.1]}
BLOCK["inertia"] = [[2e-3, 1e-4, -2e-4], [1e-4, 3e-3, 3e-4], [-2e-4, 3e-4, 4e-3]]
BALL = {"mass": 0.1, "centre": [0.06, 0.01, -0.02], "inertia": [1e-4, 1e-4, 1e-4]}
RUBBER = {"young_modulus": 1e5, "shear_modulus": 4e4, "density": 1000.0, "retardation_time": 0.01}
FINGER = {"length": 0.2, "radius": 0.012, **RUBBER, "modes": {"bend_y": 2, "bend_z": 1}}
#: Curved, tapered, with every strain.
TENTACLE = {
    "length": 0.4,
    "radius": [0.02, 0.012],
    **RUBBER,
    "modes": {"torsion": 1, "bend_y": 2, "bend_z": 2, "stretch": 1, "shear_y": 1, "shear_z": 1},
    "reference_strain": [0.3, -0.5, 0.2, 1.02, 0.01, -0.02],
}
STRIP = {
    "length": 0.3,
    "section": {"shape": "rectangle", "width": 0.03, "height": [0.012, 0.008]},
    **RUBBER,
    "modes": {"torsion": 1, "bend_y": 1, "bend_z": 1},
}
PLACED = {"position": [0.1, -0.2, 0.3], "orientation": [0.5, 0.1, -0.7, 0.5]}
PLACED["orientation"] = (np.array(PLACED["orientation"]) / np.linalg.norm(PLACED["orientation"])).tolist()
HINGE = {"type": "revolute", "axis": [0, 1, 0]}
SPRUNG = {"stiffness": 3.0, "rest": 0.2, "damping": 0.4, "armature": 0.05}


def one_joint(joint):
    """A body on a joint with a general pose in the world, and a ball on a hinge attached to it."""
    return {
        "links": [
            {"name": "block", "joint": joint, "body": BLOCK, **PLACED},
            {"name": "ball", "parent": "block", "position": [0.2, 0, 0.1], "joint": HINGE, "body": BALL},
        ]
    }


def chain(links):
    """Links in a chain."""
    for parent, link in pairwise(links):
        link["parent"] = parent["name"]
    return links


DESCRIPTIONS = {
    "revolute": one_joint({"type": "revolute", "axis": [1, 2, -2], **SPRUNG}),
    "prismatic": one_joint({"type": "prismatic", "axis": [1, 2, -2], **SPRUNG}),
    "cylindrical": one_joint({"type": "cylindrical", "axis": [1, 2, -2]}),
    "universal": one_joint({"type": "universal", "axis1": [1, 0, 0], "axis2": [1, 2, 0]}),
    "planar": one_joint({"type": "planar", "normal": [1, 2, -2]}),
    "planar across x": one_joint({"type": "planar", "normal": [-2, 0, 0]}),
    "spherical": one_joint({"type": "spherical"}),
    "free": one_joint({"type": "free"}),
    "welded rods": {
        "gravity": [1.0, -2.0, -9.0],
        "links": chain(
            [
                {"name": "tentacle", "rod": [TENTACLE], **PLACED},
                {"name": "strip", "position": [0, 0, 0.02], "rod": [STRIP]},
                {"name": "tool", "body": BLOCK},
            ]
        ),
        "loads": [
            {"link": "strip", "force": [0.1, -0.2, 0.3], "moment": [0.01, 0.02, -0.03], "at": 0.1},
            {"link": "tentacle", "force": [0.2, 0.1, -0.4], "along": [0.1, 0.3], "frame": "body"},
            {"link": "tool", "force": [0.3, 0.2, 0.1], "moment": [0.02, -0.01, 0.01], "frame": "body"},
        ],
    },
    "flexible double pendulum": {
        "links": chain(
            [
                {"name": "upper", "joint": HINGE, "rod": [FINGER]},
                {"name": "lower", "joint": {**HINGE, **SPRUNG}, "rod": [FINGER]},
            ]
        )
    },
    "flying rod": {
        "gravity": [0, 0, 0],
        "links": [{"name": "rod", "joint": {"type": "free"}, "rod": [TENTACLE]}],
        "loads": [{"link": "rod", "force": [0.2, 0.0, 0.3], "moment": [0.0, -0.1, 0.2]}],
    },
    "hand on a rail": {
        "links": [
            {"name": "rail", "joint": {"type": "prismatic", "axis": [0, 1, 0]}, "body": BALL},
            {"name": "palm", "parent": "rail", "joint": HINGE, "body": BLOCK},
            {"name": "thumb", "parent": "palm", "position": [0.1, 0.05, 0], "rod": [FINGER]},
            {
                "name": "finger",
                "parent": "palm",
                "joint": {"type": "universal", "axis1": [0, 1, 0], "axis2": [0, 0, 1]},
                "position": [0.1, -0.05, 0],
                "rod": [FINGER, {**STRIP, "length": 0.1}],
            },
            {
                "name": "ring",
                "parent": "finger",
                "at": 0.08,
                "joint": {"type": "cylindrical", "axis": [1, 0, 0]},
                "body": BALL,
            },
        ]
    },
    "swimmer": {
        "links": [
            {"name": "head", "joint": {"type": "free"}, "body": BLOCK},
            {"name": "left", "parent": "head", "position": [0, 0.1, 0], "rod": [FINGER]},
            {
                "name": "right",
                "parent": "head",
                "position": [0, -0.1, 0],
                "orientation": [0.8, 0, 0, -0.6],
                "joint": {"type": "spherical"},
                "rod": [FINGER],
            },
            {"name": "tail", "parent": "right", "at": 0.0, "joint": {**HINGE, **SPRUNG}, "body": BALL},
        ]
    },
    "five in a row": {
        "links": chain(
            [
                {"name": "trunk", "joint": {"type": "planar", "normal": [0, 0, 1]}, "body": BLOCK, **PLACED},
                {"name": "arm", "joint": {"type": "spherical"}, "rod": [FINGER]},
                {"name": "elbow", "at": 0.15, "joint": HINGE, "body": BLOCK},
                {
                    "name": "slide",
                    "joint": {"type": "prismatic", "axis": [1, 0, 1]},
                    "rod": [STRIP],
                    **PLACED,
                },
                {"name": "end", "at": 0.3, "joint": {"type": "spherical"}, "body": BALL},
            ]
        )
    },
    "screw": one_joint({"type": "screw", "axis": [1, 2, -2], "lead": 0.7, **SPRUNG}),
}


def states(robot, seed):
    """Two states, (2, 3, n), with short decimal numbers."""
    at_zero, far = (random_states(robot, [seed, k]).round(3) for k in range(2))
    at_zero[0] = 0.0
    for link, dofs in zip(robot.links, robot.joint_dofs, strict=True):
        phi = far[0, dofs][link.joint.rotation_vector]
        if phi.size:
            phi[:] = (phi * NEARLY_PI / np.linalg.norm(phi)).round(3) if np.any(phi) else (0, NEARLY_PI, 0)
    return np.array([at_zero, far])


def values(robot, q, v, a):
    """The values of the file for a state, arrays unrounded."""
    links = {}
    for name in robot.names:
        velocity = robot.velocity(q, v, link=name)
        links[name] = {"pose": robot.pose(q, link=name), "velocity": velocity}
    momentum = robot.momentum(q, v)
    return {
        "tau": robot.inverse_dynamics(q, v, a),
        "mass_matrix": robot.mass_matrix(q),
        "energy": np.array(robot.energy(q, v)),
        "momentum": momentum.linear,
        "angular_momentum": momentum.angular,
        "links": links,
    }


def table():
    """The contents of the file, arrays unrounded."""
    robots = []
    for seed, (name, description) in enumerate(DESCRIPTIONS.items()):
        robot = build(description)
        found = [{"q": q, "v": v, "a": a} | values(robot, q, v, a) for q, v, a in states(robot, seed)]
        robots.append({"name": name, "description": description, "n": robot.n, "states": found})
    return {"robots": robots}


def rounded(values):
    """Lists in place of arrays, with the significant digits."""
    if isinstance(values, dict):
        return {key: rounded(value) for key, value in values.items()}
    if isinstance(values, list):
        return [rounded(value) for value in values]
    if not isinstance(values, np.ndarray):
        return values
    size = np.abs(values).max(initial=0)
    decimals = DIGITS - int(np.ceil(np.log10(size))) if size > 0 else 0
    # Adding zero turns negative zeros into zeros.
    return (values.round(decimals) + 0.0).tolist()


def text(values):
    """JSON with rows of numbers on separate lines."""
    lines = json.dumps(values, indent=1)
    return re.sub(r"\[[^\[\]{}]*\]", lambda row: " ".join(row[0].split()), lines) + "\n"


if __name__ == "__main__":
    PATH.parent.mkdir(exist_ok=True)
    PATH.write_text(text(rounded(table())), encoding="utf-8")
