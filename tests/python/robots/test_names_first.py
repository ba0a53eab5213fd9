"""Names may stand before the state of which wrenches are asked."""

import numpy as np
import pytest

import lissom

SEGMENT = lissom.Segment(0.2, 0.01, 3e5, poisson_ratio=0.45, density=1100, modes={"bend_y": 2})
JOINT = lissom.Revolute((0, 1, 0), damping=1e-3)


def arm():
    links = [
        lissom.Link("upper", rod=[SEGMENT], joint=JOINT),
        lissom.Link("lower", rod=[SEGMENT], joint=JOINT, parent="upper"),
    ]
    return lissom.Robot(links)


def closed():
    """An arm whose tip is pinned to the world."""
    pin = lissom.Loop(("lower", None), (None, None, (0.4, 0, 0)), lissom.Revolute((0, 1, 0)), name="pin")
    return lissom.Robot(arm().links, loops=[pin])


def state(robot):
    return [0.1 * np.sin(np.arange(robot.n) + shift) for shift in (0.0, 1.0, 2.0)]


def test_names_first():
    robot = arm()
    q, qd, qdd = state(robot)
    right = robot.joint_wrench(q, qd, qdd, link="lower")
    np.testing.assert_array_equal(robot.joint_wrench("lower", q, qd, qdd), right)
    many = robot.joint_wrench("lower", np.stack([q, q]), np.stack([qd, qd]), np.stack([qdd, qdd]))
    np.testing.assert_array_equal(many, [right, right])


def test_names_of_loops_first():
    robot = closed()
    q, qd, qdd = np.zeros((3, robot.n))
    right = robot.loop_forces(q, qd, qdd, name="pin")
    np.testing.assert_array_equal(robot.loop_forces("pin", q, qd, qdd), right)


CALLS = {
    "got two names": lambda q, qd, qdd: arm().joint_wrench("lower", q, qd, qdd, link="upper"),
    "got a name and two arrays": lambda q, qd, qdd: arm().joint_wrench("lower", q, qd),
    "got a fourth argument behind the state": lambda q, qd, qdd: arm().joint_wrench(q, qd, qdd, "lower"),
}


@pytest.mark.parametrize("found", CALLS)
def test_other_orders_are_refused_with_the_right_calls(found):
    calls = r"expected joint_wrench\(link, q, qd, qdd\) or joint_wrench\(q, qd, qdd, link=\.\.\.\)"
    with pytest.raises(TypeError, match=f"link: {found}, {calls}"):
        CALLS[found](*state(arm()))


def test_a_link_that_is_not_there_is_named():
    with pytest.raises(ValueError, match="did you mean 'lower'"):
        arm().joint_wrench("lwer", *state(arm()))
