"""A run or a search that fails names what holds it: contact, edge, stop of a joint, tendon."""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom


def nothing_after(t_end):
    """A force of zero that is no number any more after some time, so that runs end there."""
    return lambda t: (0.0, 0.0, np.nan if t > t_end else 0.0)


def falling_arm(limits=(-0.5, 1.0), **forces):
    joint = lissom.Revolute((0, 1, 0), limits=limits, limit_stiffness=200.0, limit_dissipation=5.0, **forces)
    bar = lissom.Body(1.0, centre=(0.5, 0, 0), inertia=(0.01, 0.1, 0.1))
    end = lissom.Load(link="arm", force=nothing_after(1.5))
    return lissom.Robot([lissom.Link("arm", joint=joint, body=bar)], loads=[end])


def test_a_stop_is_named_with_its_place_and_force():
    failed = lissom.simulate(falling_arm(), 3.0, dt=2e-3)
    assert failed.status == "non_finite"
    pattern = r'joint of "arm" is (\S+) rad beyond its stop at (\S+) rad, which presses with (\S+) N m'
    beyond, limit, force = map(float, re.search(pattern, failed.message).groups())
    assert limit == 1.0
    assert_allclose(beyond, failed.q[-1, 0] - 1.0, rtol=0.1)
    assert_allclose(force, 200.0 * beyond, rtol=0.1)
    assert "`limit_stiffness`" in failed.message


def test_a_stop_that_is_not_reached_is_not_named():
    failed = lissom.simulate(falling_arm((-5.0, 5.0), damping=2.0), 3.0, dt=2e-3)
    assert failed.status == "non_finite"
    assert "stop" not in failed.message
    succeeded = lissom.simulate(falling_arm(), 1.0, dt=2e-3)
    assert succeeded.success
    assert succeeded.q[-1, 0] > 1.0
    assert "stop" not in succeeded.message


def test_the_stop_of_a_slide_has_units_of_lengths_behind_driven_joints():
    turned = lissom.Revolute((0, 0, 1), motion=lambda t: 0.3 * t)
    slide = lissom.Prismatic(
        (0, 0, 1), limits=(-0.2, 0.2), limit_stiffness=1e4, limit_dissipation=10.0, damping=20.0
    )
    block = lissom.Body(2.0, inertia=(0.01, 0.01, 0.01))
    links = [
        lissom.Link("turntable", joint=turned, body=block),
        lissom.Link("block", parent="turntable", joint=slide, body=block),
    ]
    robot = lissom.Robot(links, loads=[lissom.Load(link="block", force=nothing_after(1.5))])
    failed = lissom.simulate(robot, 3.0, dt=2e-3)
    assert failed.status == "non_finite"
    assert re.search(
        r'joint of "block" is \S+ m beyond its stop at -0.2 m, which presses with \S+ N:', failed.message
    )


def hanging_ball(length, **tendon):
    ball = lissom.Link("ball", joint=lissom.Free(), body=lissom.Body(1.0, inertia=1e-3 * np.eye(3)))
    rope = lissom.Tendon(
        "rope", [lissom.Via(None, (0, 0, 0)), lissom.Via("ball", (0, 0, 0))], length=length, **tendon
    )
    end = lissom.Load(link="ball", force=nothing_after(0.2))
    return lissom.Robot([ball], actuators=[rope], loads=[end])


@pytest.mark.parametrize("stiffness", [None, 1e4])
def test_a_taut_tendon_is_named_and_a_slack_one_is_not(stiffness):
    q0 = np.zeros(6)
    q0[2] = -0.5
    taut = lissom.simulate(hanging_ball(0.5, stiffness=stiffness), 0.4, q0=q0, dt=2e-3)
    assert not taut.success
    assert 'tendon "rope" is taut' in taut.message
    slack = lissom.simulate(hanging_ball(0.9, stiffness=stiffness), 0.4, q0=q0, dt=2e-3)
    assert not slack.success
    assert "is taut" not in slack.message


@pytest.mark.parametrize(("half_length", "is_edge"), [(0.4, True), (3.0, False)])
def test_an_edge_is_named_and_a_face_is_not(half_length, is_edge):
    # The cable of 2 m hangs over the edge at 1.4 m, or lies on the face.
    segment = lissom.Segment(1.0, 5e-3, 1e8, poisson_ratio=0.4, density=1500, modes={"bend_y": 6})
    table = lissom.Box((1.0, 0, -0.42), (half_length, 1.0, 0.4))
    robot = lissom.Robot(
        [lissom.Link("cable", rod=[segment] * 2)],
        contacts=[lissom.Contact("cable", table, stiffness=1e5, name="table")],
    )
    failed = lissom.statics(robot, max_iter=20)
    assert not failed.success
    deepest = max(robot.touches(failed.q), key=lambda touch: touch.overlap)
    # On the face the normal is upright.
    assert (deepest.normal[2] < 0.9999) == is_edge
    assert ("on an edge" in failed.message) == is_edge
    assert 'contact "table" overlaps most' in failed.message


def test_the_loop_that_holds_is_named():
    bar = lissom.Body(1.0, centre=(0.5, 0, 0), inertia=(0.01, 0.1, 0.1))
    hinge = lissom.Revolute((0, 1, 0))
    links = [
        lissom.Link("upper", joint=hinge, body=bar),
        lissom.Link("lower", parent="upper", position=(1, 0, 0), joint=hinge, body=bar),
    ]
    ends = lissom.LoopEnd("lower", position=(1, 0, 0)), lissom.LoopEnd(None, position=(1.9999, 0, 0))
    robot = lissom.Robot(links, loops=[lissom.Loop(*ends, hinge)], gravity=(0, 0, -9.81))
    start = {"q0": [-0.01, 0.02]}
    failed = lissom.simulate(robot, 2.0, method="radau", min_step=0.05, rtol=1e-9, **start)
    assert failed.status == "step_too_small"
    assert 'The loop between "lower" and the world (loops[0]) holds there' in failed.message
    assert "loop" not in lissom.simulate(robot, 0.01, dt=1e-3, **start).message
