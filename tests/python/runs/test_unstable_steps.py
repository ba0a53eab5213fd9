"""Conditionally stable members of Newmark's family beyond their limit: what grows has a status."""

from __future__ import annotations

import pickle
import re
import warnings

import numpy as np
import pytest

import lissom

#: gamma / 2 - beta of each method; one over its root is the limit in radians of the fastest vibration.
LACKS = {"linear_acceleration": 1 / 12, "fox_goodwin": 1 / 6, "central_difference": 1 / 4}
STIFFNESS, MASS = 1e4, 1.0
#: Steps in which what grows is large and does not overflow, by damping.
STEPS = {0.0: 60, 1e3: 400}
FREQUENCY = np.sqrt(STIFFNESS / MASS)


def carried(damping=0.0, motion=None):
    """A mass between a spring and a damper on a rail that moves as prescribed."""
    moves = lissom.Harmonic(0.01, 0.5) if motion is None else motion
    rail = lissom.Link("rail", joint=lissom.Prismatic((1, 0, 0), motion=moves), body=lissom.Body(1.0))
    spring = lissom.Prismatic((1, 0, 0), stiffness=STIFFNESS, damping=damping)
    mass = lissom.Link("mass", parent="rail", joint=spring, body=lissom.Body(MASS), position=(0.1, 0, 0))
    return lissom.Robot([rail, mass], gravity=(0, 0, 0))


def run(model, ratio, method, steps, **options):
    """Steps of so many times the limit of stability."""
    dt = ratio / np.sqrt(LACKS[method]) / FREQUENCY
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lissom.AccuracyWarning)
        return lissom.simulate(model, steps * dt, dt=dt, method=method, **options)


@pytest.mark.parametrize("method", LACKS)
@pytest.mark.parametrize("damping", [0.0, 1e3], ids=["undamped", "overdamped"])
def test_what_grows_beyond_the_limit_is_unstable(method, damping):
    found = run(carried(damping), 1.5, method, STEPS[damping])
    assert (found.status, found.success) == ("unstable", False)
    assert np.abs(found.q).max() > 1e3
    limit = float(re.search(r"this method, (\S+) s for the vibration of 15.915 Hz", found.message)[1])
    assert limit == pytest.approx(1 / np.sqrt(LACKS[method]) / FREQUENCY, rel=0.05)


@pytest.mark.parametrize("method", LACKS)
@pytest.mark.parametrize("damping", [0.0, 1e3], ids=["undamped", "overdamped"])
def test_the_growth_in_each_step_is_that_of_the_states(method, damping):
    """The last two states differ by the spectral radius of the amplification matrix."""
    found = run(carried(damping), 1.5, method, STEPS[damping])
    growth = abs(found.q[-1, 0] / found.q[-2, 0])
    assert f"by a factor of {growth:.3f} in each step" in found.message


@pytest.mark.parametrize("method", LACKS)
@pytest.mark.parametrize("damping", [0.0, 1e3], ids=["undamped", "overdamped"])
def test_steps_within_the_limit_finish(method, damping):
    found = run(carried(damping), 0.95, method, 400)
    assert found.status == "finished"
    assert np.abs(found.q).max() < 0.1


@pytest.mark.parametrize("method", ["newmark", "generalised_alpha", "hht"])
def test_unconditionally_stable_members_finish(method):
    found = lissom.simulate(carried(1e3), 40.0, dt=0.1, method=method)
    assert found.status == "finished"
    assert np.abs(found.q).max() < 0.1


def test_a_vibration_that_nothing_excites_may_rest():
    """Beyond the limit, but at rest to rounding."""
    found = run(carried(motion=lissom.Harmonic()), 1.5, "linear_acceleration", 400)
    assert found.status == "finished"
    assert np.abs(found.q).max() == 0.0


def test_runs_in_intervals_and_from_memory_say_the_same():
    dt = 1.5 / np.sqrt(1 / 12) / FREQUENCY
    whole = lissom.Simulation(carried(1e3), dt=dt, method="linear_acceleration")
    whole.step(duration=10 * dt)
    later = pickle.loads(pickle.dumps(whole))
    for stepped in (whole, later):
        assert stepped.step(duration=390 * dt) == "unstable"
    assert whole.q.tolist() == later.q.tolist()


def test_a_rod_on_a_base_that_moves():
    """Overdamped waves along a rod whose slow bending is resolved."""
    segment = lissom.Segment(
        1.0, 0.01, 1e7, poisson_ratio=0.4, density=1000, modes={"bend_y": 3}, retardation_time=0.5
    )
    base = lissom.BaseMotion(translation=lissom.Harmonic((0, 0, 0.05), 1.0))
    rod = lissom.Rod([segment], base_motion=base)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lissom.AccuracyWarning)
        found = lissom.simulate(rod, 20.0, dt=0.1, method="linear_acceleration")
        finer = lissom.simulate(rod, 2.0, dt=0.02, method="linear_acceleration")
    assert not found.success
    assert found.status in ("unstable", "newton_not_converged", "unresolved")
    assert finer.status == "finished"
