"""Simulations that are stepped from outside, and runs with a controller."""

import copy
import gc
import pickle
import signal
import threading
import time
import weakref

import numpy as np
import pytest

import lissom

SOFT = lissom.Segment(0.3, 0.008, 1e6, 4e5, 1000.0, {"bend_y": 3, "torsion": 1}, retardation_time=0.01)
TABLE = ([0.0, 0.05, 0.1, 5.0], [[0, 0, 0], [0, 0, 0.05], [0, 0, 0], [0, 0, 0.02]])


def swing(t):
    """A load that other processes find by its name."""
    return (0.0, 0.0, 0.05 * np.sin(20.0 * t))


def rod(**changes):
    return lissom.Rod([SOFT], **changes)


def hinged():
    """A rod on a ball joint that turns fast: its rotation vectors pass pi."""
    return lissom.Robot([lissom.Link("arm", rod=[SOFT], joint=lissom.Spherical())])


MODELS = {
    "still": lambda: rod(tip_force=(0, 0, 0.1)),
    "harmonic": lambda: rod(loads=[lissom.Load(force=lissom.Harmonic((0, 0, 0.05), 3.0, phase=0.4))]),
    "table": lambda: rod(loads=[lissom.Load(force=TABLE, at=0.2)]),
    "callable": lambda: rod(loads=[lissom.Load(force=swing)]),
    "moving": lambda: rod(base_motion=lissom.BaseMotion(axis=(0, 1, 0), angle=lissom.Harmonic(0.2, 2.0))),
    "spherical": hinged,
    "pendulum": lissom.SpringPendulum,
}
FAMILY = ["newmark", "hht", "generalised_alpha", "linear_acceleration"]
METHODS = [*FAMILY, "radau", "rk45", "dop853"]
WAYS = {
    "copy": lambda simulation: simulation.copy(),
    "copy.copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda simulation: pickle.loads(pickle.dumps(simulation)),
}


def start(model, seed=0):
    q0, v0 = 0.1 * np.random.default_rng(seed).standard_normal((2, model.n))
    if isinstance(model, lissom.Robot) and not isinstance(model, lissom.Rod):
        v0[:3] = (20.0, 3.0, -5.0)
    return {"q0": q0, "v0": v0}


def state(simulation):
    return simulation.t, *(array.tolist() for array in (simulation.q, simulation.v, simulation.a, simulation.u))


def stepped(simulation, steps, **arguments):
    states = []
    for _ in range(steps):
        assert simulation.step(**arguments) == "finished", simulation.message
        states.append(state(simulation))
    return states


@pytest.mark.parametrize("method", FAMILY)
@pytest.mark.parametrize("name", MODELS)
def test_a_thousand_steps_are_simulate_to_the_bit(name, method):
    model, dt, t0 = MODELS[name](), 1e-3, 0.25
    result = lissom.simulate(model, t0 + 1000 * dt, t0=t0, dt=dt, method=method, **start(model))
    simulation = lissom.Simulation(model, dt=dt, t0=t0, method=method, **start(model))
    for i, (t, q, v, a, _) in enumerate(stepped(simulation, 1000), 1):
        np.testing.assert_array_equal(t, result.t[i])
        # Results have no rotation vector that is longer than pi; a step of a simulation may end with one.
        if name != "spherical" or np.linalg.norm(q[:3]) <= np.pi:
            np.testing.assert_array_equal(q, result.q[i])
            np.testing.assert_array_equal(v, result.v[i])
            np.testing.assert_array_equal(a, result.a[i])


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ["harmonic", "callable", "moving", "spherical"])
def test_a_copy_goes_on_to_the_bit(name, method, way):
    model = MODELS[name]()
    simulation = lissom.Simulation(model, dt=2e-3, t0=0.1, method=method, **start(model))
    for _ in range(4):
        stepped(simulation, 7)
        other = WAYS[way](simulation)
        assert state(other) == state(simulation)
        assert other.status == simulation.status
        assert other.message == simulation.message
        assert stepped(other, 9) == stepped(WAYS[way](simulation), 9)
        # The copy has a life of its own.
        assert other.t > simulation.t
    other = WAYS[way](simulation)
    assert stepped(other, 20) == stepped(simulation, 20)


@pytest.mark.parametrize("method", METHODS)
def test_a_reset_is_a_new_simulation(method):
    model = MODELS["harmonic"]()
    fresh = lissom.Simulation(model, dt=2e-3, method=method, t0=0.3, **start(model, 1))
    used = lissom.Simulation(model, dt=2e-3, method=method, **start(model))
    stepped(used, 5)
    used.reset(t0=0.3, **start(model, 1))
    assert used.status == "ready"
    assert state(used) == state(fresh)
    wanted = stepped(fresh, 10)
    assert stepped(used, 10) == wanted
    used.reset()
    assert stepped(used, 10) == wanted
    used.reset(q0=np.zeros(model.n))
    np.testing.assert_array_equal(used.q, 0.0)
    np.testing.assert_array_equal(used.v, start(model, 1)["v0"])
    before = state(used)
    with pytest.raises(ValueError, match="q0"):
        used.reset(q0=[0.0])
    assert state(used) == before


def test_durations_are_whole_steps_or_equal_ones():
    model = MODELS["harmonic"]()
    many = lissom.Simulation(model, dt=1e-3, **start(model))
    once = lissom.Simulation(model, dt=1e-3, **start(model))
    stepped(many, 50)
    stepped(once, 1, duration=0.05)
    assert state(once) == state(many)
    # Two steps and a half are three equal ones.
    other = lissom.Simulation(model, dt=2.5e-3 / 3, **start(model))
    parts = lissom.Simulation(model, dt=1e-3, **start(model))
    stepped(parts, 1, duration=2.5e-3)
    stepped(other, 3)
    np.testing.assert_allclose(parts.q, other.q, rtol=1e-9)
    assert parts.t == 2.5e-3


@pytest.mark.parametrize("method", METHODS)
def test_pieces_of_any_length_are_near_the_whole(method):
    model = MODELS["table"]()
    within = {"rtol": 1e-8, "atol": 1e-10}
    result = lissom.simulate(model, 0.3, dt=1e-4, **start(model))
    simulation = lissom.Simulation(model, dt=1e-4, method=method, **within, **start(model))
    while simulation.t < 0.3 - 1e-9:
        duration = min(0.3 - simulation.t, 0.0123)
        assert simulation.step(duration=duration) == "finished", simulation.message
    np.testing.assert_allclose(simulation.q, result.q[-1], atol=2e-4 * np.abs(result.q).max())


@pytest.mark.parametrize("duration", [0.0, -1.0, np.nan, np.inf, 1e-30, "1", [0.1]])
def test_durations_that_make_no_sense_are_refused(duration):
    simulation = lissom.Simulation(rod(), dt=1e-3)
    simulation.step()
    before = state(simulation)
    with pytest.raises((ValueError, TypeError), match="duration"):
        simulation.step(duration=duration)
    assert state(simulation) == before
    assert simulation.success


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ({"dt": 0.0}, "dt"),
        ({"dt": np.nan}, "dt"),
        ({"dt": 1e-3, "method": "auto"}, "auto"),
        ({"dt": 1e-3, "method": "euler"}, "method"),
        ({"dt": 1e-3, "q0": [0.0]}, "q0: expected 4 values"),
        ({"dt": 1e-3, "v0": [np.nan] * 4}, "v0"),
        ({"dt": 1e-3, "t0": np.inf}, "t0"),
        ({"dt": 1e-3, "t0": 1e18}, "dt"),
        ({"dt": 1e-3, "rho_inf": 0.5}, "rho_inf"),
        ({"dt": 1e-3, "max_step": 0.5}, "max_step"),
    ],
)
def test_bad_arguments_are_refused(arguments, match):
    with pytest.raises(ValueError, match=match):
        lissom.Simulation(rod(), **arguments)


def test_models_alone_are_simulated():
    with pytest.raises(TypeError, match="model: expected a Model"):
        lissom.Simulation(SOFT, dt=1e-3)


@pytest.mark.parametrize("u", [[0.1], [[]], "u", None.__class__, [np.nan]])
def test_a_model_without_inputs_takes_none(u):
    simulation = lissom.Simulation(rod(), dt=1e-3)
    with pytest.raises((ValueError, TypeError), match="u: expected"):
        simulation.step(u)
    assert simulation.step([]) == "finished"
    assert simulation.u.shape == (0,)


def test_a_step_that_fails_keeps_the_state_before_it():
    limit = 0.05
    broken = lissom.Load(force=lambda t: (0, 0, np.nan if t > limit else 0.01))
    simulation = lissom.Simulation(rod(loads=[broken]), dt=0.01)
    status = simulation.step(duration=0.2)
    assert status == simulation.status == "non_finite"
    assert not simulation.success
    assert simulation.t == 0.05
    assert "NaN" in simulation.message
    other = lissom.Simulation(rod(loads=[broken]), dt=0.01)
    stepped(other, 5)
    np.testing.assert_array_equal(simulation.q, other.q)
    limit = 10.0
    assert simulation.step() == "finished"
    assert simulation.t == pytest.approx(0.06)


def test_shapes_that_mean_nothing_end_a_step():
    simulation = lissom.Simulation(rod(), dt=1e-2, v0=[3e5, 0, 0, 0])
    assert simulation.step(duration=0.1) in ("unresolved", "inverted")
    assert "shorter steps" in simulation.message


def test_energies_are_those_of_the_model():
    model = MODELS["harmonic"]()
    simulation = lissom.Simulation(model, dt=1e-3, **start(model))
    stepped(simulation, 5)
    wanted = model.energy(simulation.q, simulation.v, t=simulation.t)
    assert simulation.energy.total == wanted.total


def test_what_is_handed_out_is_a_copy():
    simulation = lissom.Simulation(rod(), dt=1e-3)
    q = simulation.q
    stepped(simulation, 3)
    np.testing.assert_array_equal(q, 0.0)
    wanted = simulation.q
    simulation.q[:] = 7.0
    np.testing.assert_array_equal(simulation.q, wanted)


def test_damaged_pickles_are_refused():
    simulation = lissom.Simulation(rod(), dt=1e-3)
    stepped(simulation, 3)
    restore, (model, options, begun, numbers, outcome) = simulation.__reduce__()
    for wrong in (numbers[:-1], numbers[:0], np.append(numbers, 0.0), np.full_like(numbers, np.nan)):
        with pytest.raises(ValueError, match="memory"):
            restore(model, options, begun, wrong, outcome)


def test_exceptions_of_functions_come_through_and_it_goes_on():
    def load(t):
        if t > limit:
            raise ZeroDivisionError("here")
        return (0.0, 0.0, 0.01)

    limit = 0.05
    simulation = lissom.Simulation(rod(loads=[lissom.Load(force=load)]), dt=0.01)
    with pytest.raises(ZeroDivisionError, match="here"):
        simulation.step(duration=0.1)
    assert simulation.t == 0.05
    assert simulation.status == "interrupted"
    limit = 1.0
    stepped(simulation, 5)
    whole = lissom.Simulation(rod(loads=[lissom.Load(force=lambda t: (0.0, 0.0, 0.01))]), dt=0.01)
    stepped(whole, 10)
    np.testing.assert_array_equal(simulation.q, whole.q)


def test_a_function_that_asks_the_simulation_gets_an_answer():
    def load(t):
        if simulation is not None:
            try:
                simulation.step()
            except RuntimeError as error:
                answers.append(str(error))
        return (0.0, 0.0, 0.01)

    simulation, answers = None, []
    simulation = lissom.Simulation(rod(loads=[lissom.Load(force=load)]), dt=0.01)
    assert simulation.step() == "finished"
    assert set(answers) == {"the simulation is in the middle of a step"}


@pytest.mark.parametrize("seconds", [0.3])
def test_other_threads_run_during_long_steps(seconds):
    model = rod()
    simulation = lissom.Simulation(model, dt=1e-5)
    simulation.step()
    ticks, is_over = [], threading.Event()

    def tick():
        while not is_over.is_set():
            ticks.append(time.perf_counter())
            time.sleep(1e-3)

    thread = threading.Thread(target=tick)
    thread.start()
    before = time.perf_counter()
    while time.perf_counter() - before < seconds:
        simulation.step(duration=0.2)
    is_over.set()
    thread.join()
    # With the interpreter held there would be one tick a step.
    assert len(ticks) > 20


def test_interrupts_end_long_steps():
    simulation = lissom.Simulation(rod(), dt=1e-6)
    timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
    timer.start()
    before = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        simulation.step(duration=1e3)
    assert time.perf_counter() - before < 5.0
    assert 0.0 < simulation.t < 1e3
    assert simulation.step() == "finished"


def test_simulations_in_circles_are_freed():
    class Load:
        def __call__(self, t):
            return (0.0, 0.0, 0.01)

    load = Load()
    load.simulation = lissom.Simulation(rod(loads=[lissom.Load(force=load)]), dt=0.01)
    alive = weakref.ref(load)
    del load
    gc.collect()
    assert alive() is None


# Control.


def test_control_takes_a_model_with_inputs_and_a_step_takes_control():
    with pytest.raises(ValueError, match="this model has no inputs"):
        lissom.simulate(rod(), 0.1, control=lambda t, q, v: [])
    with pytest.raises(ValueError, match="control_step"):
        lissom.simulate(rod(), 0.1, control_step=0.1)
    with pytest.raises(TypeError, match="control: expected a callable"):
        lissom.simulate(rod(), 0.1, control=3)


def test_results_without_inputs_have_no_columns():
    result = lissom.simulate(rod(), 0.1)
    assert result.u.shape == (11, 0)
    assert pickle.loads(pickle.dumps(result)).u.shape == (11, 0)
