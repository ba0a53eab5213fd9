"""`max_seconds`: a limit of wall-clock time with a status of its own, and the states until then."""

import copy
import pickle
import time
from pathlib import Path

import numpy as np
import pytest

import lissom

PENDULUM = lissom.SpringPendulum()
START = {"q0": [-0.8, 0.5]}
#: Far more seconds of motion than a processor computes in the limits below.
LONG = 1e5


def waiting(t, q, v):
    """A controller that takes its time."""
    time.sleep(0.02)
    return [0.0, 0.0, 0.0]


@pytest.mark.parametrize("method", ["newmark", "generalised_alpha", "radau", "rk45", "dop853"])
def test_a_run_ends_when_its_time_is_up_and_keeps_its_states(method):
    started = time.perf_counter()
    options = {"t_eval": np.arange(0.0, LONG)} | START
    result = lissom.simulate(PENDULUM, LONG, method=method, max_seconds=0.1, **options)
    assert time.perf_counter() - started < 5.0
    assert result.status == "time_limit"
    assert not result.success
    assert 0 < result.t[-1] < LONG
    assert len(result.q) == len(result.t) > 1
    assert "0.1 s of wall-clock time" in result.message
    assert "`max_seconds`" in result.message
    # What there is is what a run without a limit computes.
    until = result.t[len(result.t) // 2]
    whole = lissom.simulate(PENDULUM, LONG, method=method, progress=lambda t: t > until, **options)
    common = min(len(whole.t), len(result.t)) - 1
    assert common > 0
    assert (whole.q[:common] == result.q[:common]).all()


def falling():
    """A rope whose weight nothing holds: a step without inertia is made in thousands of parts."""
    rubber = lissom.Segment(0.3, 0.01, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 4})
    peg = lissom.Contact(
        "rope", lissom.Capsule((0.15, -1, 0), (0.15, 1, 0), 0.03), stiffness=1e7, friction=0.2
    )
    rope = lissom.Link("rope", rod=[rubber] * 4, joint=lissom.Free(), position=(-0.55, 0, 0.06))
    return lissom.Robot([rope], contacts=[peg])


ONE_STEP = {"dt": 1.0, "method": "quasi_static"}


def test_a_step_that_takes_long_is_given_up():
    with pytest.warns(lissom.AccuracyWarning, match="no equilibrium is near"):
        whole = lissom.simulate(falling(), 1.0, **ONE_STEP)
    assert whole.stats.newton_iterations > 1000
    limit = 0.1 * whole.stats.wall_time
    part = lissom.simulate(falling(), 1.0, **ONE_STEP, max_seconds=limit)
    assert part.status == "time_limit"
    assert part.t.tolist() == [0.0]
    assert part.stats.newton_iterations < 0.5 * whole.stats.newton_iterations
    # So does whoever looks at the progress.
    asked = []
    part = lissom.simulate(falling(), 1.0, **ONE_STEP, progress=lambda t: asked.append(t) or True)
    assert (part.status, asked) == ("interrupted", [0.0])
    # A simulation that is advanced step by step is where it was.
    simulation = lissom.Simulation(falling(), **ONE_STEP, max_seconds=limit)
    assert (simulation.step(), simulation.t) == ("time_limit", 0.0)
    assert not np.any(simulation.q)


def test_auto_ends_as_well():
    result = lissom.simulate(
        PENDULUM, LONG, method="auto", t_eval=[0.0, LONG / 2, LONG], max_seconds=0.2, **START
    )
    assert result.status == "time_limit"
    assert not result.success


def test_a_controller_that_waits_counts():
    rubber = lissom.Segment(0.3, 0.01, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 3})
    rod = lissom.Rod([rubber], loads=[lissom.Load(force=lissom.Input("force", (0, 0, 0)))])
    result = lissom.simulate(rod, 10.0, control=waiting, max_seconds=0.15)
    assert result.status == "time_limit"
    assert 0.0 < result.t[-1] < 1.0


def test_a_run_that_reaches_its_end_is_finished_however_late():
    late = lissom.simulate(PENDULUM, 0.01, dt=0.01, max_seconds=1e-9, **START)
    assert late.status == "finished"
    assert late.t[-1] == 0.01
    with_time = lissom.simulate(PENDULUM, 1.0, max_seconds=1e9, **START)
    assert (with_time.q == lissom.simulate(PENDULUM, 1.0, **START).q).all()


def test_rows_have_limits_of_their_own():
    rows = lissom.simulate_many(
        PENDULUM,
        LONG,
        q0=[[-0.8, 0.5], [-0.7, 0.4]],
        t_eval=np.arange(0.0, LONG, 10),
        max_seconds=0.1,
        workers=2,
    )
    assert rows.status.tolist() == ["time_limit"] * 2
    assert not rows.success.any()
    assert (rows.reached > 0).all()
    assert (rows.reached < LONG).all()
    assert all("max_seconds" in message for message in rows.message)
    first = rows.q[:, : int(rows.reached.min() // 10) + 1]
    assert np.isfinite(first).all()
    assert np.isnan(rows.q[:, -1]).all()
    both = lissom.simulate_many(PENDULUM, 1.0, q0=[[-0.8, 0.5]] * 2, max_seconds=100.0)
    assert both.success.all()


def test_a_step_of_a_simulation_ends_and_goes_on():
    simulation = lissom.Simulation(PENDULUM, dt=1e-3, max_seconds=0.05, **START)
    assert simulation.step(duration=LONG) == "time_limit"
    t = simulation.t
    assert 0 < t < LONG
    assert not simulation.success
    assert "max_seconds" in simulation.message
    other = pickle.loads(pickle.dumps(simulation))
    assert (other.status, other.t, other.message) == ("time_limit", t, simulation.message)
    for one in (simulation, other, copy.copy(simulation)):
        assert one.step(duration=1e-3) == "finished"
        assert one.t > t
    assert other.step(duration=LONG) == "time_limit"
    simulation.reset()
    assert simulation.step(duration=LONG) == "time_limit"


def test_rows_of_simulations_end_and_go_on():
    swarm = lissom.Simulations(PENDULUM, 2, dt=1e-3, max_seconds=0.05, workers=2, **START)
    assert not swarm.step(duration=LONG).any()
    assert swarm.status == ["time_limit"] * 2
    assert (swarm.t > 0).all()
    assert (swarm.t < LONG).all()
    assert "max_seconds" in swarm.message(0)
    assert swarm.step(duration=1e-3).all()
    swarm.reset([0])
    assert not swarm.step(duration=LONG).any()


def test_a_scene_takes_it_as_an_option():
    text = (Path(__file__).parents[3] / "scenes" / "lab-pendulum.toml").read_text(encoding="utf-8")
    scene = lissom.Scene.loads(text)
    assert scene.run(t_end=LONG, t_eval=[LONG], max_seconds=0.05).status == "time_limit"


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_bad_limits_are_named(value):
    message = "max_seconds: got .*, expected a finite number > 0"
    for call in (
        lambda: lissom.simulate(PENDULUM, 1.0, max_seconds=value),
        lambda: lissom.simulate_many(PENDULUM, 1.0, max_seconds=value),
        lambda: lissom.Simulation(PENDULUM, dt=0.01, max_seconds=value),
        lambda: lissom.Simulations(PENDULUM, 2, dt=0.01, max_seconds=value),
    ):
        with pytest.raises(ValueError, match=message):
            call()
    with pytest.raises(TypeError, match="max_seconds"):
        lissom.simulate(PENDULUM, 1.0, max_seconds="long")


def lying(young_modulus=1e9):
    """A rod that falls on a box."""
    segment = lissom.Segment(0.5, 2e-3, young_modulus, poisson_ratio=0.3, density=7800.0, modes={"bend_y": 4})
    bench = lissom.Box((0.5, 0.0, -0.1), (0.1, 0.1, 0.1))
    contact = lissom.Contact("rod", bench, name="rod on bench")
    return lissom.Robot([lissom.Link("rod", rod=[segment] * 2)], contacts=[contact])


@pytest.mark.parametrize("method", ["newmark", "radau", "auto"])
def test_a_limit_of_time_names_what_touches(method):
    """Contacts are what most runs take long for; other failures name them, too."""
    start = lissom.statics(lying()).q
    options = {"radau": {"max_step": 1e-3}, "auto": {"rtol": 1e-6, "max_step": 1e-3}}.get(method, {})
    result = lissom.simulate(lying(), 1e3, method=method, q0=start, max_seconds=1.0, **options)
    assert result.status == "time_limit"
    assert 'contact "rod on bench"' in result.message
