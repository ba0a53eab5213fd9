"""An overhand knot: a rope that touches itself in several places while it is pulled."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def example():
    return runpy.run_path(str(ROOT / "examples" / "python" / "overhand_knot.py"))


def test_the_rope_has_the_shape_that_was_tied(example):
    robot, q = example["rope"](0.1)
    arc, points = example["tied"]()
    X = np.linspace(0, arc[-1] * (1 - 1e-12), 101)
    wanted = np.column_stack([np.interp(X, arc, column) for column in points.T])
    # Modes smooth the bends at the ends of the polynomial; a millimetre is a fifth of the radius.
    assert_allclose(robot.pose(q, X)[:, :3, 3], wanted, atol=4e-3)
    assert robot.touches(q) == []


def test_a_knot_that_is_pulled_touches_itself_and_loses_energy(example):
    robot, q0 = example["rope"](example["BENDING"] / (2 * 0.06**2))
    motion = lissom.simulate(robot, 0.105, dt=5e-4, q0=q0)
    assert motion.success, motion.message
    total = [robot.energy(q, v).total for q, v in zip(motion.q[::10], motion.v[::10], strict=True)]
    assert np.diff(total).max() < 1e-3 * abs(total[-1] - total[0])
    touches = robot.touches(motion.q[-1], motion.v[-1], t=motion.t[-1])
    assert max(touch.overlap for touch in touches) < 0.1 * example["RADIUS"]
    # Each place is reported from both sides.
    places = np.array([touch.along for touch in touches])
    assert np.any(places[:, 0] < places[:, 1])
    assert np.any(places[:, 0] > places[:, 1])


def curved(robot, q):
    """Radius of the middle of the loop, and sum of the contact forces."""
    touches = robot.touches(q)
    along = np.sort([touch.along for touch in touches], axis=1)
    X = np.linspace(along[:, 0].max(), along[:, 1].min(), 1001)
    radius = 1.0 / np.median(np.linalg.norm(robot.strain(q, X)[:, 1:3], axis=1))
    return radius, sum(np.linalg.norm(touch.force) for touch in touches)


@pytest.mark.slow
def test_friction_of_a_knot_that_is_drawn_tight_is_that_of_its_contact_forces(example):
    """A rope is drawn until friction holds it: its tension is that without friction and mu times the force.

    Of loose knots (Audoly, Clauvelin and Neukirch 2007): both strands slide along each other by what the ends
    are drawn apart.
    """
    friction, bending = 0.1, example["BENDING"]

    def rope(loop, **contact):
        free, q = example["rope"](bending / (2 * loop**2))
        touch = lissom.Contact("rope", "rope", stiffness=5e4, **contact)
        syrup = lissom.Fluid(density=1e-9, viscous_drag=(0.6, 0.6))
        parts = {"loads": free.loads, "gravity": (0, 0, 0)}
        return lissom.Robot(free.links, contacts=[touch], fluid=syrup, **parts), q

    q = None
    for loop in (0.06, 0.07, 0.085):
        robot, start = rope(loop)
        found = lissom.statics(robot, start if q is None else q, space_error=False)
        assert found.success, found.message
        q = found.q
    robot, _ = rope(0.06, friction=friction, slip_velocity=1e-5)
    motion = lissom.simulate(robot, 8.0, dt=1e-2, q0=q)
    assert motion.success, motion.message
    held, _ = curved(robot, motion.q[-1])
    # The rope without friction whose loop is as large.
    loops, q = [0.075, 0.08, 0.085], motion.q[-1]
    radii, forces = [], []
    for loop in loops:
        robot, _ = rope(loop)
        found = lissom.statics(robot, q, space_error=False)
        assert found.success, found.message
        q = found.q
        radius, force = curved(robot, q)
        radii.append(radius)
        forces.append(force)
    assert radii[0] < held < radii[-1]
    free = bending / (2 * np.interp(held, radii, loops) ** 2)
    taken = bending / (2 * 0.06**2) - free
    assert_allclose(taken / (friction * np.interp(held, radii, forces)), 1.0, atol=0.1)
