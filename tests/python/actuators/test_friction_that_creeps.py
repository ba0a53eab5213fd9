"""Smoothed friction that creeps where dry friction holds is doubted."""

import numpy as np
import pytest

import lissom

PULL = 0.6


def robot(velocity, friction=0.3):
    segment = lissom.Segment(
        0.15, 0.006, 250e3, poisson_ratio=0.49, density=1070, modes={"bend_y": 4}, retardation_time=0.3
    )
    ramp = ([0.0, 1.0, 100.0], [0.0, PULL, PULL])
    path = [lissom.Along(offset=(0.0, 0.004))]
    pull = lissom.Tendon("pull", path, tension=ramp, friction=friction, friction_velocity=velocity)
    return lissom.Rod([segment], gravity=(0, 0, 0), actuators=[pull])


def run(velocity, t_end=20.0, friction=0.3):
    return lissom.simulate(robot(velocity, friction), t_end, dt=0.02, method="quasi_static")


def test_a_hold_of_seconds_is_doubted():
    with pytest.warns(lissom.AccuracyWarning, match="friction_velocity"):
        found = run(1e-3)
    assert (
        'Friction of the tendon "pull" is smoothed over its `friction_velocity` of 0.001 m/s' in found.doubt
    )
    assert found.doubt in found.message


def test_the_velocity_that_is_suggested_needs_no_doubt():
    with pytest.warns(lissom.AccuracyWarning):
        doubt = run(1e-3).doubt
    suggested = float(doubt.rpartition("Give it ")[2].split()[0])
    assert run(suggested).doubt is None


def test_without_friction_nothing_creeps():
    assert run(1e-3, friction=0.0).doubt is None


def test_many_runs_say_it_too():
    with pytest.warns(lissom.AccuracyWarning):
        found = lissom.simulate_many([robot(1e-3), robot(1e-5)], 20.0, dt=0.02, method="quasi_static")
    assert "friction_velocity" in found.doubt[0]
    assert found.doubt[1] is None


@pytest.mark.parametrize("joint", ["Revolute", "Prismatic"])
def test_joints_that_creep_are_doubted(joint):
    """Under half of its friction a joint creeps with 0.58 of the velocity over which it is smoothed."""
    made = getattr(lissom, joint)((0, 0, 1), friction=2.0, friction_velocity=0.02)
    load = {"moment": (0, 0, 1.0)} if joint == "Revolute" else {"force": (0, 0, 1.0)}
    body = lissom.Body(1.0, inertia=[0.01] * 3)
    arm = lissom.Link("arm", body=body, joint=made)
    held = lissom.Robot([arm], gravity=(0, 0, 0), loads=[lissom.Load(link="arm", **load)])
    with pytest.warns(lissom.AccuracyWarning):
        found = lissom.simulate(held, 20.0, dt=0.01, method="radau")
    unit = "rad/s" if joint == "Revolute" else "m/s"
    assert (
        f'Friction of the joint of "arm" is smoothed over its `friction_velocity` of 0.02 {unit}'
        in found.doubt
    )
    np.testing.assert_allclose(found.v[-1], 0.02 / np.sqrt(3.0), rtol=1e-3)
    assert lissom.simulate(held, 0.5, dt=0.01, method="radau").doubt is None
