"""Ropes and rods that touch themselves: an overhand knot that is pulled, and a twisted rod that forms a loop
and coils around itself, compared with published theory.
"""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def overhand_knot():
    return runpy.run_path(str(ROOT / "examples" / "python" / "overhand_knot.py"))


def test_the_rope_has_the_shape_that_was_tied(overhand_knot):
    robot, q = overhand_knot["rope"](0.1)
    arc, points = overhand_knot["tied"]()
    X = np.linspace(0, arc[-1] * (1 - 1e-12), 101)
    wanted = np.column_stack([np.interp(X, arc, column) for column in points.T])
    # Modes smooth the bends at the ends of the polynomial; a millimetre is a fifth of the radius.
    assert_allclose(robot.pose(q, X)[:, :3, 3], wanted, atol=4e-3)
    assert robot.touches(q) == []


def test_a_knot_that_is_pulled_touches_itself_and_loses_energy(overhand_knot):
    robot, q0 = overhand_knot["rope"](overhand_knot["BENDING"] / (2 * 0.06**2))
    motion = lissom.simulate(robot, 0.105, dt=5e-4, q0=q0)
    assert motion.success, motion.message
    total = [robot.energy(q, v).total for q, v in zip(motion.q[::10], motion.v[::10], strict=True)]
    assert np.diff(total).max() < 1e-3 * abs(total[-1] - total[0])
    touches = robot.touches(motion.q[-1], motion.v[-1], t=motion.t[-1])
    assert max(touch.overlap for touch in touches) < 0.1 * overhand_knot["RADIUS"]
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
def test_friction_of_a_knot_that_is_drawn_tight_is_that_of_its_contact_forces(overhand_knot):
    """A rope is drawn until friction holds it: its tension is that without friction and mu times the force.

    Of loose knots (Audoly, Clauvelin and Neukirch 2007): both strands slide along each other by what the ends
    are drawn apart.
    """
    friction, bending = 0.1, overhand_knot["BENDING"]

    def rope(loop, **contact):
        free, q = overhand_knot["rope"](bending / (2 * loop**2))
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


@pytest.fixture(scope="module")
def plectoneme():
    return runpy.run_path(str(ROOT / "examples" / "python" / "plectoneme.py"))


@pytest.fixture(scope="module")
def twisted(plectoneme):
    """Up to the first coil, and some time at rest."""
    robot = plectoneme["rod"]((2.0,))
    motion = plectoneme["twist"](robot, 1.0, 5e-3)
    assert motion.success, motion.message
    return robot, motion


def test_a_rod_buckles_beyond_the_torque_of_a_long_one(plectoneme, twisted):
    # 2 sqrt(B T), Love 1944, art. 272; clamps and viscous drag delay it a little.
    robot, motion = twisted
    torques = np.array([plectoneme["torque"](robot, motion, step) for step in range(1, len(motion.t))])
    critical = 2 * np.sqrt(plectoneme["BENDING"] * plectoneme["TENSION"])
    largest = int(np.argmax(torques))
    assert 1.0 < torques[largest] / critical < 1.3
    ends = robot.pose(motion.q, t=motion.t)[:, 0, 3]
    before = np.flatnonzero(torques[:largest] < 0.9 * critical)
    assert_allclose(ends[before], plectoneme["LENGTH"], rtol=5e-3)
    assert torques[-1] < 0.6 * critical
    assert ends[-1] < 0.7 * plectoneme["LENGTH"]


def test_a_plectoneme_has_the_torque_of_theory(plectoneme, twisted):
    robot, motion = twisted
    radius = plectoneme["distance"](robot, motion, -1)
    wanted, _ = plectoneme["theory"](radius)
    # Errors from the modes and the end loop.
    assert_allclose(plectoneme["torque"](robot, motion, -1), wanted, rtol=0.01)
    # Theory distinguishes this from the torque before coiling, and from that of a thinner rod.
    assert abs(plectoneme["theory"](0.9 * radius)[0] / wanted - 1) > 0.03


def test_windings_touch_in_pairs_around_the_loop(twisted):
    robot, motion = twisted
    touches = robot.touches(motion.q[-1], motion.v[-1], t=motion.t[-1])
    places = np.array([touch.along for touch in touches])
    apart = np.abs(np.diff(places, axis=1)).ravel()
    # A continuous line of contact, with places symmetric about the top of the loop.
    assert np.ptp(apart) > 0.05
    tops = places.mean(axis=1)
    assert np.ptp(tops) < 0.02
    # The forces on both strands are equal up to quadrature errors.
    forces = np.array([touch.force for touch in touches])
    assert np.linalg.norm(forces.sum(axis=0)) < 0.01 * np.linalg.norm(forces, axis=1).sum()
