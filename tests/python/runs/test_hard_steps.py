"""Which steps of a run were attempted again, why, and what they cost."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import lissom
from lissom.results.hard_steps import where_spent

RADIUS = 0.05
FLOOR = lissom.HalfSpace()


def dropped_ball(speed=3.0, **contact):
    """A ball of 1 kg without weight that flies down onto a floor from 1 m above it, and its start."""
    joint = lissom.Prismatic((0, 0, 1))
    ball = lissom.Link("ball", body=lissom.Body(1.0), joint=joint, position=(0, 0, 1.05))
    contacts = [lissom.Contact(lissom.Ball("ball", RADIUS), FLOOR, name="landing", **contact)]
    return lissom.Robot([ball], gravity=(0, 0, 0), contacts=contacts), {"v0": [-speed]}


def cable(**contact):
    """A clamped rod above a floor on which it comes to lie."""
    segment = lissom.Segment(
        0.5, 5e-3, 5e7, poisson_ratio=0.4, density=1500, modes={"bend_y": 4}, retardation_time=0.02
    )
    link = lissom.Link("rod", rod=[segment], position=(0, 0, 0.05))
    return lissom.Robot([link], contacts=[lissom.Contact("rod", FLOOR, name="ground", **contact)])


def wire(**options):
    """A rod that swings freely."""
    return lissom.Rod(
        [lissom.Segment(0.5, 5e-3, 5e7, poisson_ratio=0.4, density=1500, modes={"bend_y": 2})], **options
    )


def test_smooth_runs_have_none():
    motion = lissom.simulate(wire(), 0.2, dt=2e-3)
    assert motion.success
    assert len(motion.hard_steps) == 0
    assert where_spent(motion) is None
    assert lissom.newmark(lambda t, q, v, a: a + q, (0.0, 1.0), [1.0], [0.0], dt=0.1).hard_steps is None


@pytest.mark.parametrize("impacts", ["stopped", "resolved"])
@pytest.mark.filterwarnings("ignore:Impacts are shorter:lissom.AccuracyWarning")
def test_impacts_are_found_where_the_ball_lands(impacts):
    robot, start = dropped_ball(stiffness=1e8)
    motion = lissom.simulate(robot, 0.5, dt=0.01, method=lissom.methods.Newmark(impacts=impacts), **start)
    assert motion.success
    hard = motion.hard_steps
    # It touches the floor after 1/3 s.
    assert hard.t[0] == pytest.approx(0.33, abs=1e-9)
    assert hard.dt[0] == pytest.approx(0.01, rel=1e-9)
    assert hard.reasons[0] == "impact"
    assert hard.attempts[0] >= 2
    assert np.all(hard.t < 0.36)
    if impacts == "stopped":
        assert hard.contacts[0] == "landing"


def test_steps_cost_what_results_count():
    """Of fixed steps, all of which are times of the result."""
    motion = lissom.simulate(cable(), 0.4, dt=2e-3)
    assert motion.success
    hard = motion.hard_steps
    assert len(hard) > 0
    assert hard.t[0] > 0.05
    assert set(hard.contacts) == {"ground"}
    steps = np.searchsorted(motion.t, hard.t)
    assert_array_equal(motion.t[steps], hard.t)
    assert_array_equal(np.diff(motion.evaluations)[steps], hard.evaluations)
    assert np.all(hard.iterations <= hard.evaluations)
    assert hard.iterations.sum() <= motion.stats.newton_iterations
    assert hard.tangents.sum() <= motion.stats.njev


@pytest.mark.parametrize("method", ["radau", "rk45", "dop853", lissom.methods.Newmark(adaptive=True)])
def test_adaptive_steps_are_attempted_again_as_often_as_counted(method):
    motion = lissom.simulate(cable(), 0.2, method=method)
    assert motion.success
    hard, stats = motion.hard_steps, motion.stats
    again = hard.attempts - 1
    assert again.sum() == stats.rejected + stats.unsolved > 0
    assert np.all(again[np.array(hard.reasons) == "slow_convergence"] == 0)
    assert np.all(hard.halvings == 0)
    reasons = set(hard.reasons)
    assert "error" in reasons
    assert reasons <= {"error", "not_converged", "slow_convergence", "impact", "missed"}
    assert ("not_converged" in reasons) == (stats.unsolved > 0)
    assert hard.evaluations.sum() <= stats.nfev


def test_tendons_that_become_taut_are_events():
    body = lissom.Body(0.1, inertia=np.diag([1e-5] * 3))
    rope = lissom.Tendon("rope", [lissom.Via(None, (0, 0, 0)), lissom.Via("bob", (0, 0, 0))], length=0.5)
    bob = lissom.Robot([lissom.Link("bob", joint=lissom.Free(), body=body)], actuators=[rope])
    start = np.zeros(6)
    start[2] = -0.3
    taut = np.sqrt(2 * 0.2 / 9.81)
    for method in ("generalised_alpha", "radau", "dop853"):
        motion = lissom.simulate(bob, 0.3, q0=start, dt=0.01, method=method)
        assert motion.success, motion.message
        hard = motion.hard_steps
        events = [t for t, reason in zip(hard.t, hard.reasons, strict=True) if reason == "event"]
        assert len(events) > 0, method
        assert abs(events[0] - taut) < 0.11, method


@pytest.mark.filterwarnings("ignore:Impacts are shorter:lissom.AccuracyWarning")
def test_surfaces_that_would_pass_are_named():
    """A ball that passes a thin plate within a step, of which nothing is seen at its ends."""
    ball = lissom.Link("ball", body=lissom.Body(1.0, inertia=[1e-3] * 3), joint=lissom.Free())
    plate = lissom.Box((1, 0, 0), (5e-4, 1, 1))
    contact = lissom.Contact(lissom.Ball("ball", RADIUS), plate, stiffness=1e8, dissipation=0.0)
    robot = lissom.Robot([ball], gravity=(0, 0, 0), contacts=[contact])
    start = {"v0": [10, 0, 0, 0, 0, 0]}
    fixed = lissom.simulate(robot, 0.24, dt=0.06, method=lissom.methods.Newmark(impacts="stopped"), **start)
    assert fixed.success
    assert fixed.hard_steps.reasons[0] == "passed_through"
    assert fixed.hard_steps.halvings[0] > 0
    free = lissom.simulate(robot, 0.2, method="radau", **start)
    assert free.success
    assert "missed" in free.hard_steps.reasons


def test_the_step_that_ends_a_run_is_the_last_one():
    """A force that is no number any more after some time."""

    def force(t):
        return 0.0, 0.0, np.nan if t > 0.055 else -0.01

    motion = lissom.simulate(wire(loads=[lissom.Load(force=force, at=0.5)]), 0.3, dt=0.01)
    assert motion.status == "non_finite"
    hard = motion.hard_steps
    assert hard.reasons[-1] == "non_finite"
    assert hard.dt[-1] == 0
    assert hard.t[-1] == motion.t[-1] == pytest.approx(0.05)


def test_hard_steps_can_be_copied():
    hard = lissom.simulate(cable(), 0.2, dt=2e-3).hard_steps
    for other in (copy.copy(hard), pickle.loads(pickle.dumps(hard))):
        assert len(other) == len(hard)
        assert other.reasons == hard.reasons
        assert other.contacts == hard.contacts
        assert_array_equal(other.evaluations, hard.evaluations)
    with pytest.raises(ValueError, match="read-only"):
        hard.t[0] = 1.0


def test_results_say_where_a_run_spends_its_work():
    motion = lissom.simulate(cable(), 0.4, dt=2e-3)
    hard = motion.hard_steps
    spent = where_spent(motion)
    share = hard.evaluations.sum() / motion.stats.nfev
    steps = f"{len(hard)} of {motion.stats.steps} steps"
    assert spent.startswith(f"{share:.0%} of the evaluations in {steps}, most from ")
    assert spent.endswith("contact 'ground'")
    start, end = (float(word) for word in spent.split("most from ")[1].split(" s: ")[0].split(" s to "))
    within = (hard.t >= start * 0.999) & (hard.t + hard.dt <= end * 1.001)
    assert hard.evaluations[within].sum() >= 0.8 * hard.evaluations.sum()
