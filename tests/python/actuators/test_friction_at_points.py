"""Friction of tendons at points between straight parts: a slider between anchors, in closed form."""

import numpy as np
import pytest
from scipy.optimize import brentq

import lissom

FRICTION = 0.4
TENSION = 3.0
STIFFNESS = 50.0
FIRST, LAST = np.array([0.0, 0.0, 0.3]), np.array([0.4, 0.0, 0.1])


def slider(sliding):
    joint = lissom.Prismatic((1, 0, 0), stiffness=STIFFNESS)
    body = lissom.Body(0.1, inertia=np.diag([1e-4] * 3))
    path = [lissom.Via(None, tuple(FIRST)), lissom.Via("slider", (0, 0, 0)), lissom.Via(None, tuple(LAST))]
    tendon = lissom.Tendon("pull", path, tension=TENSION, friction=FRICTION, sliding=sliding)
    return lissom.Robot(
        [lissom.Link("slider", joint=joint, body=body)], gravity=(0, 0, 0), actuators=[tendon]
    )


def force(x, sliding):
    """Force on the slider: the tension decreases by ``exp(-friction * angle)`` where the tendon turns."""
    place = np.array([x, 0.0, 0.0])
    before = (place - FIRST) / np.linalg.norm(place - FIRST)
    after = (LAST - place) / np.linalg.norm(LAST - place)
    beyond = TENSION * np.exp(-FRICTION * sliding * np.arccos(before @ after))
    return STIFFNESS * x + TENSION * before[0] - beyond * after[0]


@pytest.mark.parametrize("sliding", [1.0, -1.0, 0.5])
def test_equilibria_are_those_of_the_closed_form(sliding):
    robot = slider(sliding)
    found = lissom.statics(robot)
    assert found.success
    assert found.q[0] == pytest.approx(brentq(force, -0.3, 0.3, args=(sliding,), xtol=1e-14), abs=1e-12)


@pytest.mark.parametrize("x", [-0.1, 0.05, 0.3])
def test_forces_are_those_of_the_closed_form(x):
    found = slider(1.0).inverse_dynamics([x], [0.0], [0.0])
    assert found[0] == pytest.approx(force(x, 1.0), rel=1e-12)


def test_a_straight_path_loses_nothing():
    """The angle of a straight tendon is zero, and smooth there."""
    path = [lissom.Via(None, (-0.2, 0, 0)), lissom.Via("a", (0, 0, 0)), lissom.Via(None, (0.3, 0, 0))]
    tendon = lissom.Tendon("pull", path, tension=TENSION, friction=FRICTION, sliding=1.0)
    body = lissom.Body(0.1, inertia=np.diag([1e-4] * 3))
    robot = lissom.Robot(
        [lissom.Link("a", joint=lissom.Prismatic((0, 0, 1), stiffness=1.0), body=body)],
        gravity=(0, 0, 0),
        actuators=[tendon],
    )
    assert robot.inverse_dynamics([0.0], [0.0], [0.0])[0] == 0.0
    assert lissom.statics(robot, [1e-3]).success
