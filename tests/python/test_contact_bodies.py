"""Boxes, capsules and meshes that touch each other and hilly ground."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import lissom
from lissom import Body, Box, Capsule, Contact, ConvexMesh, Free, HeightField, Link

GRAVITY = 9.81
TETRAHEDRON = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / math.sqrt(3)
OCTAHEDRON = np.vstack([np.eye(3), -np.eye(3)])
TETRAHEDRON_FACES = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
OCTAHEDRON_FACES = [[x, y, z] for x in (0, 3) for y in (1, 4) for z in (2, 5)]


def turned(rotation):
    """A quaternion as lissom writes it."""
    return tuple(rotation.as_quat(scalar_first=True))


def cuboid(mass, half):
    """A homogeneous box as a rigid body."""
    squares = np.square(half)
    return Body(mass, inertia=mass / 3 * (squares.sum() - squares))


def free(name, half, mass=0.5, **place):
    """A box as a free body."""
    return Link(name, joint=Free(), body=cuboid(mass, half), **place)


def box(name, half):
    return Box((0, 0, 0), half, link=name)


def test_boxes_on_boxes_carry_their_weight_and_stay():
    """Three of one size, flush with each other, on a fixed one: forces are weights, and nothing drifts for a second."""
    half, mass = (0.05, 0.04, 0.03), 0.5
    table = Box((0, 0, -0.1), (0.3, 0.3, 0.1))
    names = ["low", "middle", "high"]
    links = [free(name, half, mass, position=(0, 0, 0.03 + 0.06 * i)) for i, name in enumerate(names)]
    law = {"stiffness": 1e5, "friction": 0.5}
    surfaces = [table] + [box(name, half) for name in names]
    contacts = [
        Contact(upper, lower, name=f"on {i}", **law)
        for i, (lower, upper) in enumerate(zip(surfaces[:-1], surfaces[1:], strict=True))
    ]
    robot = lissom.Robot(links, contacts=contacts)
    run = lissom.simulate(robot, 1.0, dt=1e-3)
    assert run.success, run.message
    for i in range(3):
        force = robot.contact_forces(run.q[-1], run.v[-1], name=f"on {i}")
        assert_allclose(force[3:], [0, 0, (3 - i) * mass * GRAVITY], atol=1e-3 * mass * GRAVITY)
    halfway = np.searchsorted(run.t, 0.5)
    assert_allclose(run.q[-1], run.q[halfway], atol=1e-7)
    # Corners and edges of both bodies press with their stiffness.
    touches = [t for t in robot.touches(run.q[-1], run.v[-1]) if t.contact == "on 1"]
    assert len(touches) == 16
    for touch in touches:
        assert touch.overlap == pytest.approx(2 * mass * GRAVITY / (16 * 1e5), rel=1e-2)
        assert abs(touch.normal[2]) == pytest.approx(1.0, abs=1e-6)
