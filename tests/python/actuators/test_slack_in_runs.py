"""Reports of runs about tendons that became slack or had negative commands."""

import copy
import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

LENGTH = 0.2
FINGER = lissom.Segment(LENGTH, 4e-3, 1e7, 4e6, 1200, {"bend_y": 2}, retardation_time=5e-3)


def tendon(name="pull", side=1, **command):
    return lissom.Tendon(name, [lissom.Along(offset=(0, side * 0.01))], **command)


def run(*actuators, t_end=0.2, method="newmark", **options):
    rod = lissom.Rod([FINGER], gravity=(0, 0, 0), actuators=actuators)
    return lissom.simulate(rod, t_end, dt=1e-3, method=method, **options)


@pytest.mark.parametrize("method", ["newmark", "radau", "dop853"])
def test_a_tension_told_below_zero_is_said(method):
    found = run(tendon(tension=lambda t: 0.1 - t, name="back"), tendon(tension=0.1), method=method)
    assert found.success
    assert found.slack == ["back"]
    assert "The commanded tension of 'back' is as low as -0.1 N, first negative at t = 0.10" in found.message
    assert found.message.endswith(": a tendon never pushes.")


def test_a_controller_that_pushes_is_told_so():
    pulls = [tendon("a", tension=lissom.Input("a")), tendon("b", -1, tension=lissom.Input("b", 0.1))]
    found = run(*pulls, control=lambda t, q, v: [0.1, -2.0 if t > 0.05 else 0.1], control_step=0.01)
    assert found.slack == ["b"]
    assert "as low as -2 N, first negative at t = 0.06" in found.message
    assert run(*pulls).slack == []


def test_a_tendon_of_given_length_that_goes_slack_is_said():
    spring = tendon("spring", length=lambda t: LENGTH * (0.99 + 0.1 * t), stiffness=100.0)
    found = run(spring, tendon("taut", -1, length=0.9 * LENGTH, stiffness=1.0))
    assert found.slack == ["spring"]
    model = found.model
    force = model.actuator_force("spring", found.q, found.v, t=found.t)
    first = found.t[np.flatnonzero(force == 0.0)[0]]
    assert 0.0 < first < 0.2
    assert f"'spring' is slack, first at t = {first:.15g}" in found.message
    # Only at the times of the result.
    assert run(spring, t_eval=[0.0, first / 2]).slack == []


def test_what_stays_taut_is_not_said():
    found = run(
        tendon(tension=lissom.Harmonic(0.05, 3.0, mean=0.1)), lissom.ActiveStrain(None, "bend_y", 1, 0.1)
    )
    assert found.slack == []
    assert found.message == "The end of the interval was reached."
    assert lissom.simulate(lissom.SpringPendulum(), 0.1).slack == []


def test_what_a_run_says_survives_copies_and_pickles():
    found = run(tendon(tension=lissom.Input("pull")), control=lambda t, q, v: [-1.0])
    for twin in (copy.deepcopy(found), pickle.loads(pickle.dumps(found))):
        assert twin.slack == found.slack == ["pull"]
        assert twin.message == found.message


def test_motors_reach_their_limits_however_far_beyond_they_are_commanded():
    arm = lissom.Link("arm", body=lissom.Body(1, inertia=(1, 1, 1)), joint=lissom.Revolute((0, 1, 0)))
    for limit in (1e-9, 1.0, 1e9):
        motor = lissom.Motor("arm", lissom.Input("u"), limits=(-limit, limit))
        robot = lissom.Robot([arm], actuators=[motor])
        for u in (1e12, -1e12, 1e300):
            found = robot.actuator_force("arm", [0.0], [0.0], u=[u])
            assert_allclose(found, np.sign(u) * limit, rtol=1e-6)
