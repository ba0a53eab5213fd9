"""Simulations stepped from Python, and runs with a controller."""

import copy
import dataclasses
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
    """A load that other processes find by name."""
    return (0.0, 0.0, 0.05 * np.sin(20.0 * t))


def rod(**changes):
    return lissom.Rod([SOFT], **changes)


def hinged():
    """A rod on a ball joint with fast rotation: its rotation vectors pass pi."""
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
    return simulation.t, *(
        array.tolist() for array in (simulation.q, simulation.v, simulation.a, simulation.u)
    )


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
    states = stepped(simulation, 1000)
    for i, values in enumerate((result.t, result.q, result.v, result.a)):
        np.testing.assert_array_equal([state[i] for state in states], values[1:])
    if name == "spherical":
        lengths = np.linalg.norm(result.q[:, :3], axis=1)
        assert 3.0 < lengths.max() <= np.pi


@pytest.mark.parametrize("method", ["newmark", "hht", "linear_acceleration"])
@pytest.mark.parametrize("of_base", [True, False])
def test_corners_of_motions_on_steps_are_the_same_steps(of_base, method):
    """Velocities jump at ends of steps, also where times of the table differ from these by rounding."""
    table = ([0.0, 0.1, 0.3, 0.57, 0.7], [0.0, 0.2, -0.1, 0.4, 0.3], "linear")
    assert 57 * 1e-2 != 0.57
    spring = lissom.Prismatic((0, 0, 1), stiffness=40.0)
    mass = lissom.Link("mass", joint=spring, body=lissom.Body(1.0))
    if of_base:
        base = lissom.BaseMotion(translation=(table[0], [(0, 0, z) for z in table[1]], "linear"))
        model = lissom.Robot([mass], base_motion=base)
    else:
        clamp = lissom.Link("clamp", joint=lissom.Prismatic((0, 0, 1), motion=table), body=lissom.Body(1.0))
        model = lissom.Robot([clamp, dataclasses.replace(mass, parent="clamp")])
    result = lissom.simulate(model, 0.8, dt=1e-2, method=method)
    simulation = lissom.Simulation(model, dt=1e-2, method=method)
    states = stepped(simulation, 80)
    for i, values in enumerate((result.t, result.q, result.v, result.a)):
        np.testing.assert_array_equal([state[i] for state in states], values[1:])
    assert result.doubt is simulation.doubt is None


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
        # The copy is independent.
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
    # Two and a half steps are three equal ones.
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
        ({"dt": 1e-3, "method": "auto", "atol": 1e-6}, "atol"),
        ({"dt": 1e-3, "method": "auto", "rtol": 0.5}, "rtol"),
        ({"dt": 1e-3, "method": "euler"}, "method"),
        ({"dt": 1e-3, "q0": [0.0]}, "q0: expected 4 values"),
        ({"dt": 1e-3, "v0": [np.nan] * 4}, "v0"),
        ({"dt": 1e-3, "t0": np.inf}, "t0"),
        ({"dt": 1e-3, "t0": 1e18}, "dt"),
        ({"dt": 1e-3, "rho_inf": 1.5}, "rho_inf"),
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
    with pytest.raises((ValueError, TypeError), match=r"u: (expected|got a function)"):
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


def test_shapes_that_mean_nothing_end_a_step():
    simulation = lissom.Simulation(rod(), dt=1e-4, v0=[0, 1e4, 0, 0])
    assert simulation.step(duration=0.02) == "unresolved"
    assert 0.0 < simulation.t < 0.02
    # It stops at such a step.
    assert simulation.step() == "unresolved"
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
    # If the interpreter were held, there would be one tick per step.
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


# Inputs and control.


def pushed():
    """A rod with four inputs, and a load that depends on time."""
    loads = [
        lissom.Load(force=lissom.Input("push", default=(0.0, 0.01, 0.0))),
        lissom.Load(force=lissom.Harmonic((0, 0, 0.02), 3.0), at=0.1),
    ]
    tendon = lissom.Tendon("pull", [lissom.Along("rod", (0.0, 0.005))], tension=lissom.Input("tension", 0.1))
    return rod(loads=loads, actuators=[tendon])


def law(t, q, v):
    """Inputs that depend on the state and jump."""
    return np.array(
        [0.0, 0.02 * np.sign(np.sin(40 * t)), -0.01 * v[0], 0.2 + 0.1 * np.cos(9 * t) - 0.01 * q[0]]
    )


@pytest.mark.parametrize("control_step", [2e-3, 1e-2, 5e-3])
@pytest.mark.parametrize("method", METHODS)
def test_a_controlled_run_is_a_simulation_to_the_bit(method, control_step):
    model, dt, t0 = pushed(), 2e-3, 0.1
    simulation = lissom.Simulation(model, dt=dt, t0=t0, method=method, **start(model))
    states, inputs = [state(simulation)], []
    for i in range(30):
        if i == 17:
            simulation = pickle.loads(pickle.dumps(simulation))
        inputs.append(law(simulation.t, simulation.q, simulation.v))
        assert simulation.step(inputs[-1], control_step) == "finished"
        states.append(state(simulation))
    times = [t for t, *_ in states]
    result = lissom.simulate(
        model, times[-1], t0=t0, dt=dt, method=method, control=law, control_step=control_step, t_eval=times,
        **start(model),
    )  # fmt: skip
    assert result.success
    np.testing.assert_array_equal(result.q, [q for _, q, *_ in states])
    np.testing.assert_array_equal(result.v, [v for _, _, v, *_ in states])
    np.testing.assert_array_equal(result.u, [*inputs, inputs[-1]])


def test_inputs_keep_their_defaults_without_control():
    model = pushed()
    constant = lissom.Rod(
        [SOFT],
        loads=[lissom.Load(force=lissom.Harmonic((0, 0, 0.02), 3.0), at=0.1)],
        tip_force=(0.0, 0.01, 0.0),
        actuators=[lissom.Tendon("pull", [lissom.Along("rod", (0.0, 0.005))], tension=0.1)],
    )
    result = lissom.simulate(model, 0.2, dt=1e-3, **start(model))
    wanted = lissom.simulate(constant, 0.2, dt=1e-3, **start(model))
    np.testing.assert_allclose(result.q, wanted.q, atol=1e-10)
    np.testing.assert_array_equal(result.u, np.tile(model.u0, (201, 1)))
    simulation = lissom.Simulation(model, dt=1e-3, **start(model))
    np.testing.assert_array_equal(simulation.u, model.u0)
    stepped(simulation, 200)
    np.testing.assert_array_equal(simulation.q, result.q[-1])


@pytest.mark.parametrize("method", METHODS)
def test_the_work_of_inputs_closes_the_balance(method):
    model = pushed()
    within = {} if method in FAMILY else {"rtol": 1e-8, "atol": 1e-10}
    result = lissom.simulate(
        model, 0.5, dt=1e-3, method=method, control=law, control_step=1e-2, **within, **start(model)
    )
    assert np.ptp(result.balance.work) > 1e-5
    assert result.balance.drift < (2e-3 if method in FAMILY else 1e-4)


def test_an_active_strain_that_jumps_does_work():
    amount = lissom.ActiveStrain("rod", "bend_y", amount=lissom.Input("amount"))
    model = rod(actuators=[amount], gravity=(0, 0, 0))
    control = lambda t, q, v: [1.0 if t > 0.05 else 0.0]  # noqa: E731
    result = lissom.simulate(model, 0.3, dt=5e-4, control=control, control_step=1e-2)
    assert result.balance.drift < 2e-3
    assert np.ptp(result.balance.kinetic) > 0.0


def test_motions_are_those_of_accelerations_that_jump():
    """Half a step of delay would be a first-order error."""
    model = pushed()
    times = np.linspace(0.0, 0.2, 21)
    arguments = {"control": law, "control_step": 1e-2, "t_eval": times, **start(model)}
    exact = lissom.simulate(model, 0.2, method="dop853", rtol=1e-10, atol=1e-12, **arguments)
    errors = []
    for dt in (1e-3, 5e-4, 2.5e-4):
        result = lissom.simulate(model, 0.2, dt=dt, rtol=1e-10, atol=1e-12, **arguments)
        errors.append(np.abs(result.q - exact.q).max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders.min() > 1.8


def test_accelerations_are_those_of_the_inputs_beside_them():
    model = pushed()
    for method in ("newmark", "rk45"):
        result = lissom.simulate(model, 0.1, dt=2e-3, method=method, control=law, control_step=1e-2)
        for t, q, v, a, u in zip(result.t, result.q, result.v, result.a, result.u, strict=True):
            tau = model.inverse_dynamics(q, v, a, t=t, u=u)
            scale = np.abs(model.mass_matrix(q)) @ np.abs(a) + 1e-3
            assert (np.abs(tau) < 1e-4 * scale).all()


def test_control_is_asked_when_it_is_said():
    asked = []

    def control(t, q, v):
        asked.append((t, q.copy(), v.copy()))
        return model.u0

    model = pushed()
    result = lissom.simulate(model, 0.35, t0=0.1, dt=1e-2, control=control, control_step=0.1, **start(model))
    np.testing.assert_allclose([t for t, *_ in asked], [0.1, 0.2, 0.3], rtol=1e-15)
    for t, q, v in asked:
        i = np.searchsorted(result.t, t)
        np.testing.assert_array_equal(q, result.q[i])
        np.testing.assert_array_equal(v, result.v[i])
    asked.clear()
    lissom.simulate(model, 0.35, t0=0.1, dt=1e-2, control=control)
    assert len(asked) == 25


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("returned", "match"),
    [
        ([0.0], "control: expected 4 values, got 1 .at t = 0.02"),
        ([0.0, 0.0, np.nan, 0.0], r"control\[2\].*at t = 0.02"),
        (None, "control: returned None.*at t = 0.02"),
        ("0000", "control: expected .*at t = 0.02"),
    ],
)
def test_inputs_that_make_no_sense_are_refused_with_their_time(method, returned, match):
    model = pushed()

    def control(t, q, v):
        return returned if t > 0.015 else model.u0

    with pytest.raises((ValueError, TypeError), match=match) as caught:
        lissom.simulate(model, 0.1, dt=5e-3, method=method, control=control, control_step=1e-2)
    result = caught.value.result
    assert result.status == "interrupted"
    assert result.t[-1] == pytest.approx(0.02)
    assert len(result.u) == len(result.t) == len(result.q)


def test_errors_of_control_come_through_with_what_was_computed():
    model = pushed()

    def control(t, q, v):
        if t > 0.045:
            raise ZeroDivisionError("here")
        return model.u0

    with pytest.raises(ZeroDivisionError, match="here") as caught:
        lissom.simulate(model, 0.1, dt=1e-3, control=control, control_step=1e-2)
    result = caught.value.result
    assert result.t[-1] == pytest.approx(0.05)
    assert result.balance.drift < 1e-2


@pytest.mark.parametrize("control_step", [0.0, -0.1, np.nan, np.inf, 1e-20])
def test_control_steps_that_make_no_sense_are_refused(control_step):
    with pytest.raises(ValueError, match="control_step"):
        lissom.simulate(pushed(), 0.1, control=law, control_step=control_step)


@pytest.mark.parametrize("method", METHODS)
def test_after_a_step_that_fails_other_inputs_go_on(method):
    model = pushed()
    simulation = lissom.Simulation(model, dt=1e-3, method=method, **start(model))
    stepped(simulation, 5)
    before = state(simulation)
    assert simulation.step([0.0, 1e308, 0.0, 0.0]) != "finished"
    assert not simulation.success
    assert len(simulation.message) > 40
    assert state(simulation)[:3] == before[:3]
    other = simulation.copy()
    assert simulation.step(model.u0) == "finished"
    assert other.step(model.u0) == "finished"
    assert state(simulation) == state(other)
    np.testing.assert_allclose(simulation.t, before[0] + 1e-3)
    reference = lissom.Simulation(model, dt=1e-3, method=method, **start(model))
    stepped(reference, 6)
    np.testing.assert_allclose(simulation.q, reference.q, rtol=1e-5, atol=1e-9)


@pytest.mark.parametrize(
    "u", [[0.1], [0.1] * 5, [0.1, 0.2, np.nan, 0.0], [[0.1] * 4], "abcd", {"nothing": 0.1}]
)
def test_inputs_of_a_step_that_make_no_sense_are_refused(u):
    simulation = lissom.Simulation(pushed(), dt=1e-3)
    simulation.step()
    before = state(simulation)
    with pytest.raises((ValueError, TypeError), match=r"^u"):
        simulation.step(u)
    assert state(simulation) == before
    # Rejected calls have no side effects.
    other = lissom.Simulation(pushed(), dt=1e-3)
    other.step()
    assert stepped(simulation, 3) == stepped(other, 3)


def test_control_takes_a_model_with_inputs_and_a_step_takes_control():
    with pytest.raises(ValueError, match="this model has no inputs"):
        lissom.simulate(rod(), 0.1, control=lambda t, q, v: [])
    with pytest.raises(ValueError, match="control_step"):
        lissom.simulate(rod(), 0.1, control_step=0.1)
    with pytest.raises(TypeError, match="control: expected a callable"):
        lissom.simulate(pushed(), 0.1, control=3)
    with pytest.raises(ValueError, match="control_step"):
        lissom.simulate(pushed(), 0.1, method="auto", control=law, control_step=-1.0)


def test_results_have_their_inputs():
    result = lissom.simulate(rod(), 0.1)
    assert result.u.shape == (11, 0)
    assert pickle.loads(pickle.dumps(result)).u.shape == (11, 0)
    result = lissom.simulate(pushed(), 0.1, control=law)
    other = pickle.loads(pickle.dumps(result))
    np.testing.assert_array_equal(other.u, result.u)
    assert other.balance.drift == result.balance.drift
    assert not result.u.flags.writeable


@pytest.mark.parametrize("dt", [1e-3, 1e-2])
@pytest.mark.parametrize("method", ["newmark", "generalised_alpha"])
@pytest.mark.parametrize(
    "drive", [{"tension": 1.0}, {"length": 0.299, "stiffness": 1e4}, {"length": 0.299, "stiffness": 1e6}]
)
def test_what_rests_stays_at_rest(drive, method, dt):
    """Increments there are rounding errors; requiring smaller ones ended runs."""
    soft = lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, {"bend_y": 3, "bend_z": 1}, retardation_time=0.02)
    tendon = lissom.Tendon("t", [lissom.Along("rod", (0.0, 0.008))], **drive)
    model = lissom.Rod([soft], actuators=[tendon])
    rest = lissom.statics(model).q
    simulation = lissom.Simulation(model, dt=dt, method=method, q0=rest)
    for _ in range(20):
        assert simulation.step(duration=500 * dt) == "finished", (simulation.t, simulation.message)
    np.testing.assert_allclose(simulation.q, rest, rtol=0, atol=1e-5 * np.abs(rest).max())


def test_what_came_to_rest_stays_there():
    model = rod(tip_force=(0, 0, 0.1))
    simulation = lissom.Simulation(model, dt=1e-3)
    assert simulation.step(duration=100.0) == "finished", simulation.message
    np.testing.assert_allclose(simulation.q, lissom.statics(model).q, rtol=0, atol=1e-4)


@pytest.mark.parametrize("t0", [np.nan, np.inf, -np.inf])
def test_a_start_at_no_time_is_refused_by_its_name_alone(t0):
    said = "t0: got NaN, expected" if np.isnan(t0) else f"t0: got {t0}, expected"
    simulation = lissom.Simulation(lissom.SpringPendulum(), dt=1e-3)
    several = lissom.Simulations(lissom.SpringPendulum(), 2, dt=1e-3)
    for begin in (
        lambda: lissom.Simulation(lissom.SpringPendulum(), dt=1e-3, t0=t0),
        lambda: simulation.reset(t0=t0),
        lambda: lissom.Simulations(lissom.SpringPendulum(), 2, dt=1e-3, t0=t0),
        lambda: several.reset(t0=t0),
    ):
        with pytest.raises(ValueError, match=f"^{said} a finite number \\(seconds\\)$"):
            begin()
    # The state is unchanged.
    assert simulation.t == 0.0
    assert simulation.step() == "finished"
