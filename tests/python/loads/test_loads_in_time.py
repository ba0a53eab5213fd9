"""Time-dependent loads: tables, harmonic loads, callables."""

import copy
import pickle
import re
import threading

import numpy as np
import pytest

import lissom

WIRE = lissom.Segment(0.5, 0.01, 1e6, 4e5, 1000.0, {"bend_y": 3, "bend_z": 2, "torsion": 1})
THICK = lissom.Segment(0.4, 0.02, 1e6, 4e5, 1000.0, {"bend_y": 2, "stretch": 1, "shear_z": 1})
WEIGHTLESS = {"gravity": (0.0, 0.0, 0.0)}


def swing(t):
    return (0.0, 0.1 * np.sin(3.0 * t), -0.2)


TABLE = ([0.0, 0.5, 1.0], [[0.0, 0.0, 0.0], [0.0, 0.01, 0.0], [0.02, 0.0, 0.01]])
HARMONIC = lissom.Harmonic((0.0, 0.02, 0.05), 1.5, phase=0.3, mean=(0.1, 0.0, 0.0), rate=(0.0, 0.0, 0.2))
VARYING = [
    {"force": HARMONIC, "moment": (0.01, 0.0, 0.0)},
    {"moment": TABLE, "at": 0.3, "frame": "body"},
    {"force": swing, "along": (0.1, 0.6)},
    {"force": (0.1, 0.2, 0.3), "moment": HARMONIC, "along": (0.0, 0.45), "frame": "body"},
    {"force": TABLE, "moment": swing, "at": 0.5},
]


def value(signal, t):
    """Value of a signal at a time, according to its definition."""
    if isinstance(signal, lissom.Harmonic):
        sine = np.sin(2.0 * np.pi * signal.frequency * t + signal.phase)
        return np.array(signal.mean) + np.array(signal.rate) * t + np.array(signal.amplitude) * sine
    if callable(signal):
        return np.array(signal(t))
    if isinstance(signal, tuple) and len(signal) == 2:
        times, values = signal
        return np.array([np.interp(t, times, column) for column in np.transpose(values)])
    return np.array(signal)


def frozen(load, t):
    """The load with its values at one time."""
    return load | {name: value(load[name], t) for name in ("force", "moment") if name in load}


def rod_of(loads, segments=(WIRE, THICK), **changes):
    return lissom.Rod(list(segments), loads=[lissom.Load(**load) for load in loads], **changes)


def states(n, seed=0):
    return np.random.default_rng(seed).standard_normal((3, n))


@pytest.mark.parametrize("t", [0.0, 0.25, 0.9, 7.0, -1.0])
def test_at_every_time_forces_and_tangents_are_those_of_the_loads_that_act_then(t):
    varying, constant = rod_of(VARYING), rod_of([frozen(load, t) for load in VARYING])
    q, v, a = states(varying.n)
    tau = constant.inverse_dynamics(q, v, a)
    np.testing.assert_allclose(varying.inverse_dynamics(q, v, a, t=t), tau, rtol=1e-13, atol=1e-13)
    for found, wanted in zip(varying.tangent(q, v, a, t=t), constant.tangent(q, v, a), strict=True):
        np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-12)
    found = varying.forward_dynamics(q, v, t=t)
    np.testing.assert_allclose(found, constant.forward_dynamics(q, v), rtol=1e-9)
    if t != 0.0:
        assert abs(varying.inverse_dynamics(q, v, a, t=0.0) - tau).max() > 1e-4, "they vary"


def test_the_planar_kernel_and_long_chains_see_the_time():
    planar = lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, {"bend_y": 3})
    for segments, loads in [((planar,), VARYING[:1]), ((planar,) * 9, VARYING[:3])]:
        rod, t = rod_of(loads, segments), 0.4
        constant = rod_of([frozen(load, t) for load in loads], segments)
        q, v, a = 0.1 * states(rod.n)
        assert rod.kernel == "planar"
        np.testing.assert_allclose(
            rod.inverse_dynamics(q, v, a, t=t), constant.inverse_dynamics(q, v, a), atol=1e-13
        )
        np.testing.assert_allclose(
            lissom.simulate(rod, 0.02, dt=1e-3, q0=q).q[-1],
            lissom.simulate(rod, 0.02, dt=1e-3, q0=q, jac="central").q[-1],
            atol=1e-6,
        )


def test_statics_modes_and_linear_models_take_the_loads_at_their_time():
    rod, t = rod_of(VARYING[:1], [WIRE]), 0.3
    constant = rod_of([frozen(VARYING[0], t)], [WIRE])
    sagging = lissom.statics(rod, t=t, space_error=False)
    np.testing.assert_allclose(sagging.q, lissom.statics(constant, space_error=False).q, atol=1e-9)
    assert abs(sagging.q - lissom.statics(rod, space_error=False).q).max() > 1e-2
    frequency = lissom.modes(rod, sagging.q, t=t).frequency
    np.testing.assert_allclose(frequency, lissom.modes(constant, sagging.q).frequency, rtol=1e-9)
    found = lissom.linearise(rod, sagging.q, t=t).A
    np.testing.assert_allclose(found, lissom.linearise(constant, sagging.q).A, rtol=1e-9, atol=1e-9)


def test_the_same_signal_as_table_harmonic_and_callable_gives_the_same_motion():
    harmonic = lissom.Harmonic((0.0, 0.0, 0.05), 1.0)
    times = np.linspace(0.0, 1.0, 2001)
    table = (times, [value(harmonic, t) for t in times])
    forms = [harmonic, lambda t: value(harmonic, t), table, lambda t: tuple(value(harmonic, t))]
    tips = []
    for force in forms:
        rod = rod_of([{"force": force}], [WIRE], **WEIGHTLESS)
        motion = lissom.simulate(rod, 1.0, method="rk45", rtol=1e-8, atol=1e-8, t_eval=[0.3, 1.0])
        tips.append(rod.pose(motion.q, rod.length)[:, :3, 3])
    np.testing.assert_allclose(tips[1], tips[0], atol=1e-12)
    np.testing.assert_allclose(tips[2], tips[0], atol=1e-6)
    np.testing.assert_array_equal(tips[3], tips[1])


# ------------------------------------------------------------------------------------------- against theory


@pytest.mark.parametrize("ratio", [0.5, 0.97, 2.0])
def test_a_small_harmonic_force_gives_the_response_of_the_modes(ratio):
    """M q'' + K q = b F sin(Omega t) from rest: each mode is a driven oscillator, with beats at resonance."""
    wire = lissom.Segment(1.0, 2e-3, 2e9, 8e8, 1000.0, {"bend_y": 2})
    at_rest = lissom.Rod([wire], **WEIGHTLESS)
    rest = np.zeros(2)
    modes = lissom.modes(at_rest, rest)
    omega, shapes = modes.angular_frequency, modes.shapes
    driving = ratio * omega[0]
    force = 1e-7
    load = lissom.Load(force=lissom.Harmonic((0, 0, force), driving / (2 * np.pi)))
    rod = lissom.Rod([wire], loads=[load], **WEIGHTLESS)
    period = 2 * np.pi / omega[0]
    t = np.linspace(0.0, 12.0 * period, 25)
    found = lissom.simulate(rod, t[-1], method="dop853", rtol=1e-8, atol=1e-13, t_eval=t).q
    pull = shapes.T @ at_rest.jacobian(rest, 1.0)[5] * force
    swings = (np.sin(driving * t[:, None]) - driving / omega * np.sin(omega * t[:, None])) * pull
    wanted = swings / (omega**2 - driving**2) @ shapes.T
    np.testing.assert_allclose(found, wanted, atol=1e-5 * abs(wanted).max())


@pytest.mark.parametrize("method", ["newmark", "generalised_alpha"])
def test_fixed_steps_keep_their_order(method):
    rod = rod_of([{"force": HARMONIC}, {"moment": lissom.Harmonic((0, 0.01, 0), 2.0), "at": 0.2}], [WIRE])
    exact = lissom.simulate(rod, 0.4, method="dop853", rtol=1e-12, atol=1e-12, t_eval=[0.4]).q[-1]
    steps = np.array([4e-3, 2e-3, 1e-3])
    errors = [
        abs(lissom.simulate(rod, 0.4, method=method, dt=dt, rtol=1e-12, atol=1e-12).q[-1] - exact).max()
        for dt in steps
    ]
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert order == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize(
    ("method", "runs"),
    [
        ("radau", [{"rtol": tolerance, "atol": tolerance} for tolerance in (1e-5, 1e-7, 1e-9)]),
        # With tolerances that are always satisfied nearly all steps have the maximum size.
        ("rk45", [{"rtol": 1e9, "atol": 1e9, "max_step": step} for step in (0.01, 0.005, 0.0025)]),
    ],
)
def test_runge_kutta_methods_keep_their_order(method, runs):
    soft = lissom.Segment(0.5, 0.01, 3e5, 1e5, 1000.0, {"bend_y": 1})
    rod = rod_of([{"force": lissom.Harmonic((0, 0, 0.05), 1.5, phase=0.3)}], [soft])
    exact = lissom.simulate(rod, 0.4, method="dop853", rtol=1e-13, atol=1e-13, t_eval=[0.4]).q[-1]
    steps, errors = [], []
    for options in runs:
        motion = lissom.simulate(rod, 0.4, method=method, t_eval=[0.4], **options)
        steps.append(motion.stats.steps)
        errors.append(abs(motion.q[-1] - exact).max())
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 4.6 < order < 6.2


# ----------------------------------------------------------------------------------------------- energy


def test_the_power_of_a_force_that_varies_is_work_and_it_has_no_potential():
    rod = rod_of([{"force": swing}], [WIRE], **WEIGHTLESS)
    q, v, _ = states(rod.n)
    t = 0.4
    tip = rod.jacobian(q, rod.length)[3:] @ v
    assert rod.supplied_power(q, v, t=t) == pytest.approx(np.dot(swing(t), tip), rel=1e-12)
    assert rod.energy(q, v, t=t).loads == 0.0
    constant = rod_of([{"force": swing(t)}], [WIRE], **WEIGHTLESS)
    assert constant.supplied_power(q, v) == 0.0
    assert constant.energy(q, v).loads != 0.0


@pytest.mark.parametrize("method", ["radau", "rk45", "dop853"])
def test_the_balance_of_a_driven_motion_closes(method):
    damped = lissom.Segment(0.5, 0.01, 1e6, 4e5, 1000.0, {"bend_y": 2, "bend_z": 2}, retardation_time=0.01)
    loads = [VARYING[0], VARYING[2] | {"along": (0.1, 0.4)}, {"moment": HARMONIC, "at": 0.3, "frame": "body"}]
    rod = rod_of(loads, [damped])
    found = lissom.simulate(rod, 0.5, method=method, dt=0.05, rtol=1e-8, atol=1e-9).balance
    assert abs(found.work[-1]) > 0.01 * found.scale
    assert found.drift < 1e-5


def test_the_balance_of_fixed_steps_closes_with_their_order():
    rod = rod_of(VARYING[:2], [WIRE])
    drifts = [lissom.simulate(rod, 0.3, dt=dt).balance.drift for dt in (2e-3, 1e-3)]
    assert drifts[0] < 1e-2
    assert drifts[1] < 0.3 * drifts[0]


def test_the_balance_of_a_driven_linear_motion_is_exact_whatever_the_step():
    wire = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800.0, {"bend_y": 2}, retardation_time=0.02)
    rod = rod_of([{"force": lissom.Harmonic((0, 0, 1e-8), 3.0)}], [wire], **WEIGHTLESS)
    found = lissom.simulate(rod, 1.0, dt=1e-2, rtol=1e-12, atol=1e-30).balance
    assert found.work[-1] > 0.1 * found.scale
    assert found.drift < 1e-9


# ---------------------------------------------------------------------------------------------- callables


class Broken(Exception):
    pass


@pytest.mark.parametrize("method", ["newmark", "generalised_alpha", "radau", "rk45", "dop853", "auto"])
def test_exceptions_of_a_callable_come_through_unchanged(method):
    raised = Broken("no force left")

    def force(t):
        if t > 0.02:
            raise raised
        return (0, 0, 1)

    with pytest.raises(Broken) as caught:
        lissom.simulate(rod_of([{"force": force}], [WIRE]), 0.1, method=method)
    assert caught.value is raised
    # No state remains for later computations.
    assert lissom.simulate(rod_of([], [WIRE]), 0.01).success


def test_exceptions_come_through_wherever_a_callable_is_called():
    def force(t):
        raise Broken

    rod = rod_of([{"force": force}], [WIRE])
    q, v, a = states(rod.n)
    for ask in (
        lambda: rod.inverse_dynamics(q, v, a, t=0.0),
        lambda: rod.forward_dynamics(q, v, t=0.0),
        lambda: rod.tangent(q, v, a, t=0.0),
        lambda: rod.energy(q, v, t=0.0),
        lambda: rod.supplied_power(q, v, t=0.0),
        lambda: lissom.statics(rod),
        lambda: lissom.continuation(rod),
        lambda: lissom.modes(rod, q),
        lambda: lissom.linearise(rod, q),
        lambda: lissom.solve_ivp(rod, (0.0, 0.1), np.zeros(2 * rod.n)),
        lambda: lissom.RK45(rod, 0.0, np.zeros(2 * rod.n), 0.1),
    ):
        with pytest.raises(Broken):
            ask()
    rod.mass_matrix(q)
    rod.pose(q, 0.1)


def test_exceptions_come_through_when_results_are_computed_later():
    broken = False

    def force(t):
        if broken:
            raise Broken
        return (0, 0, 1)

    motion = lissom.simulate(rod_of([{"force": force}], [WIRE]), 0.01, method="rk45")
    broken = True
    with pytest.raises(Broken):
        _ = motion.balance
    with pytest.raises(Broken):
        _ = motion.a
    broken = False
    assert motion.a.shape == motion.q.shape
    assert motion.balance.drift < 1e-3


def test_ctrl_c_in_a_callable_keeps_what_was_computed():
    def force(t):
        if t > 0.05:
            raise KeyboardInterrupt
        return (0, 0, 1)

    for method in ("newmark", "radau", "rk45"):
        with pytest.raises(KeyboardInterrupt) as caught:
            lissom.simulate(rod_of([{"force": force}], [WIRE]), 0.1, method=method, dt=1e-2)
        result = caught.value.result
        assert result.status == "interrupted"
        assert 0.0 < result.t[-1] <= 0.05


def test_what_is_not_finite_is_named_step_by_step_and_before_a_search():
    model = rod_of([{"force": lambda t: (0, 0, np.nan if t > 0.05 else 1)}], [WIRE])
    simulation = lissom.Simulation(model, dt=0.01)
    assert simulation.step(duration=0.1) == "non_finite"
    assert re.match(
        r"loads\[0\]\.force is NaN at t = 0\.06, .*: the result ends at t = 0\.05\.", simulation.message
    )
    for search in (
        lambda: lissom.statics(model, t=0.1),
        lambda: lissom.continuation(model, t=0.1),
        lambda: lissom.modes(model, np.zeros(model.n), t=0.1),
    ):
        with pytest.raises(
            ValueError, match=r"^loads\[0\]\.force is NaN at t = 0\.1, expected finite numbers$"
        ):
            search()


@pytest.mark.parametrize("method", ["newmark", "radau", "rk45", "auto"])
def test_a_force_that_is_not_finite_ends_the_run_with_a_reason(method):
    def force(t):
        return (0, 0, np.nan if t > 0.05 else 1)

    motion = lissom.simulate(rod_of([{"force": force}], [WIRE]), 0.1, method=method)
    assert (motion.success, motion.status) == (False, "non_finite")
    assert motion.t[-1] <= 0.05 + 1e-9
    assert np.isfinite(motion.q).all()
    if method != "auto":
        assert re.match(r"loads\[0\]\.force is NaN at t = 0\.0[5-9]", motion.message)


def test_a_load_that_is_not_finite_is_named_wherever_it_is_asked_for():
    still = lissom.Load(force=(0, 0, 1.0))
    for value in (np.nan, np.inf):
        broken = lissom.Load(moment=lambda t, value=value: (0.0, value if t > 0.5 else 1.0, 0.0))
        rod = lissom.Rod([WIRE], loads=[still, broken])
        q, v, a = states(rod.n)
        for ask in (
            lambda t, rod=rod, q=q: lissom.linearise(rod, q, t=t, held=True),
            lambda t, rod=rod, q=q, v=v, a=a: rod.inverse_dynamics(q, v, a, t=t),
            lambda t, rod=rod, q=q, v=v: rod.forward_dynamics(q, v, t=t),
            lambda t, rod=rod, q=q, v=v, a=a: rod.tangent(q, v, a, t=t),
            lambda t, rod=rod, q=q, v=v: rod.energy(q, v, t=t),
            lambda t, rod=rod, q=q, v=v: rod.supplied_power(q, v, t=t),
        ):
            ask(0.3)
            with pytest.raises(ValueError, match=r"loads\[1\]\.moment is (NaN|inf) at t = 0\.7"):
                ask(0.7)


def test_states_of_models_that_vary_need_their_time():
    """A default time of zero would give wrong results."""
    rod, still = rod_of([{"force": HARMONIC}], [WIRE]), rod_of([{"force": (0, 0, 1)}], [WIRE])
    q, v, a = states(rod.n)
    asked = {
        "inverse_dynamics": (q, v, a),
        "forward_dynamics": (q, v),
        "tangent": (q, v, a),
        "energy": (q, v),
        "supplied_power": (q, v),
        "dissipated_power": (q, v),
        "base_wrench": (q, v, a),
    }
    for name, arguments in asked.items():
        with pytest.raises(TypeError, match="t: got none, expected the time of the state in seconds"):
            getattr(rod, name)(*arguments)
        getattr(rod, name)(*arguments, t=0.1)
        getattr(still, name)(*arguments)
    # Positions and velocities do not depend on loads.
    rod.pose(q, 0.1), rod.jacobian(q, 0.1), rod.velocity(q, v, 0.1)


def test_a_callable_may_ask_its_own_rod():
    asked = []

    def force(t):
        q = np.zeros(rod.n)
        asked.append(rod.pose(q, rod.length)[0, 3])
        rod.mass_matrix(q)
        lissom.simulate(rod_of([{"force": HARMONIC}], [WIRE]), 1e-3, dt=1e-3)
        if t == 0.0 and len(asked) < 3:
            rod.energy(q, q, t=0.0)
            rod.inverse_dynamics(q, q, q, t=0.0)
        return (0, 0, 1)

    rod = rod_of([{"force": force}], [WIRE])
    assert lissom.simulate(rod, 0.02, dt=1e-2).success
    rod.energy(np.zeros(rod.n), np.zeros(rod.n), t=0.0)
    assert len(asked) > 3
    assert set(asked) == {rod.pose(np.zeros(rod.n), rod.length)[0, 3]}


def test_threads_share_a_rod_with_a_callable():
    rod = rod_of([{"force": swing}], [WIRE])
    found = [None] * 4

    def run(index):
        rod.energy(np.zeros(rod.n), np.zeros(rod.n), t=0.1 * index)
        found[index] = lissom.simulate(rod, 0.05, dt=1e-3).q

    threads = [threading.Thread(target=run, args=(index,)) for index in range(len(found))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for q in found:
        np.testing.assert_array_equal(q, found[0])


def test_a_callable_is_called_once_for_each_time():
    times = []

    def force(t):
        times.append(t)
        return (0, 0, 1)

    motion = lissom.simulate(rod_of([{"force": force}], [WIRE]), 0.05, dt=1e-2)
    assert motion.stats.nfev > 2 * motion.stats.steps
    # Both ends of every step: once for its equations, once for its power.
    assert len(times) <= 3 * motion.stats.steps + 2


def test_callables_that_return_something_else_are_refused():
    for value, error, match in [
        ((1, 2), ValueError, r"force\(t\): expected 3 values, got 2"),
        (None, TypeError, r"force\(t\): returned None"),
        ("up", TypeError, r"force\(t\)"),
    ]:
        rod = rod_of([{"force": lambda t, value=value: value}], [WIRE])
        with pytest.raises(error, match=match):
            lissom.simulate(rod, 0.1)


# ------------------------------------------------------------------------------------------ plain data


def test_loads_return_what_they_were_made_of_and_can_be_copied():
    load = lissom.Load(force=HARMONIC, moment=TABLE)
    assert load.force == HARMONIC
    for found, wanted in zip(load.moment, TABLE, strict=True):
        np.testing.assert_array_equal(found, wanted)
    assert lissom.Load(force=swing).force is swing
    for same in (
        copy.deepcopy(load),
        pickle.loads(pickle.dumps(load)),
        lissom.Load(force=load.force, moment=load.moment),
    ):
        assert same == load
    of_callable = lissom.Load(force=swing)
    assert of_callable == lissom.Load(force=swing) == pickle.loads(pickle.dumps(of_callable))
    assert of_callable != lissom.Load(force=lambda t: swing(t))
    rod = pickle.loads(pickle.dumps(rod_of(VARYING)))
    assert list(rod.loads) == [lissom.Load(**load) for load in VARYING]
    assert "3 loads" not in rod.explain()
    assert "5 loads: evaluated once for each time" in rod.explain()


def test_harmonic_signals_are_plain_data():
    number = lissom.Harmonic(0.1, 2.0, phase=0.3)
    assert (number.amplitude, number.frequency, number.phase) == (0.1, 2.0, 0.3)
    assert (number.mean, number.rate) == (0.0, 0.0)
    assert repr(number) == "Harmonic(0.1, 2.0, phase=0.3)"
    assert eval(repr(HARMONIC), {"Harmonic": lissom.Harmonic}) == HARMONIC
    assert pickle.loads(pickle.dumps(HARMONIC)) == HARMONIC == copy.copy(HARMONIC)
    assert number != HARMONIC
    assert lissom.Harmonic(rate=2.0).amplitude == 0.0


@pytest.mark.parametrize(
    ("force", "error", "message"),
    [
        (([0.0], [[0, 0, 1]]), ValueError, r"force\.times: got 1 times, expected at least two"),
        (([0, 1, 1], [[0, 0, 1]] * 3), ValueError, r"force\.times\[2\]: got 1, expected a time > times\[1\]"),
        (([0, 1], [[0, 0, 1]] * 3), ValueError, r"force\.values: got 3 values, expected one for each"),
        (([0, 1], [[0, 0, np.nan]] * 2), ValueError, r"force\.values\[0\]\[2\]: got NaN"),
        (([0, np.inf], [[0, 0, 1]] * 2), ValueError, r"force\.times\[1\]: got inf"),
        (([0, 1], [[0, 1], [2, 3]]), TypeError, r"force\.values: expected an array of shape \(2, 3\)"),
        (([0, 1], "ab"), TypeError, r"force\.values"),
        (
            lissom.Harmonic(0.1, 2.0),
            ValueError,
            "force: expected a Harmonic of three numbers, got one of one",
        ),
        ((1, 2, 3, 4), ValueError, "force: expected 3 values"),
        ("up", TypeError, "force"),
    ],
)
def test_signals_that_make_no_sense_are_refused(force, error, message):
    with pytest.raises(error, match=message):
        lissom.Load(force=force)


def test_harmonic_signals_that_make_no_sense_are_refused():
    for arguments, message in [
        ({"amplitude": np.nan}, r"amplitude\[0\]: got NaN"),
        ({"amplitude": (1, 2)}, "amplitude: expected three numbers"),
        ({"amplitude": 1.0, "mean": (1, 2, 3)}, "mean: expected a number, as the others are"),
        ({"frequency": -1.0}, "frequency: got -1"),
        ({"phase": np.inf}, "phase: got inf"),
    ]:
        with pytest.raises(ValueError, match=message):
            lissom.Harmonic(**arguments)
    for t in (np.nan, np.inf):
        with pytest.raises(ValueError, match="t: got"):
            rod_of(VARYING).energy(np.zeros(10), np.zeros(10), t=t)


def test_scenes_take_tables_and_harmonic_loads():
    text = """
        version = 1
        [[rod]]
        [[rod.load]]
        force = { amplitude = [0, 0.02, 0.05], frequency = 1.5, phase = 0.3 }
        [[rod.load]]
        moment = { times = [0, 1], values = [[0, 0, 0], [0, 0.01, 0]] }
        frame = "body"
        [[rod.segment]]
        length = 0.5
        radius = 0.01
        young_modulus = 1e6
        shear_modulus = 4e5
        density = 1000
        modes = { bend_y = 2 }
        [simulation]
        t_end = 0.1
    """
    scene = lissom.Scene.loads(text)
    assert isinstance(scene.model, lissom.Rod)
    assert scene.model.loads == (
        lissom.Load(force=lissom.Harmonic((0, 0.02, 0.05), 1.5, phase=0.3)),
        lissom.Load(moment=([0, 1], [[0, 0, 0], [0, 0.01, 0]]), frame="body"),
    )
    assert scene.run().success
    wrong = text.replace("frequency = 1.5", "frequency = -1.5").replace("times = [0, 1]", "times = [1, 0]")
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(wrong)
    assert [problem.key for problem in caught.value.problems] == [
        "rod[0].load[0].force.frequency",
        "rod[0].load[1].moment.times[1]",
    ]


def _soft_arm(force) -> lissom.Rod:
    segment = lissom.Segment(0.4, (0.012, 0.006), 3e5, 1e5, 1070.0, {"bend_y": 4}, retardation_time=0.02)
    return lissom.Rod([segment], gravity=(0, 0, 0), loads=[lissom.Load(force=force)])


PULSE = ([0.5, 0.51, 0.52], [[0, 0, 0], [0, 0, 1.0], [0, 0, 0]])


@pytest.mark.parametrize(
    ("method", "options", "tolerance"),
    [
        ("auto", {"rtol": 1e-2}, 1e-2),
        ("auto", {"rtol": 1e-5}, 1e-5),
        ("radau", {}, 1e-6),
        ("rk45", {}, 1e-6),
        ("dop853", {}, 1e-6),
        ("newmark", {"adaptive": True}, 1e-5),
    ],
)
def test_no_method_steps_over_a_pulse_from_rest(method, options, tolerance):
    rod = _soft_arm(PULSE)
    right = lissom.simulate(rod, 1.0, method="radau", rtol=1e-9, atol=1e-11, max_step=1e-3)
    found = lissom.simulate(rod, 1.0, method=method, **options)
    assert found.success
    tips = [rod.pose(motion.q[-1], 0.4)[:3, 3] for motion in (right, found)]
    assert np.linalg.norm(tips[0] - rod.pose(np.zeros(rod.n), 0.4)[:3, 3]) > 0.04
    assert np.linalg.norm(tips[1] - tips[0]) <= tolerance * 0.4


def test_a_pulse_of_a_callable_is_seen_with_a_largest_step():
    rod = _soft_arm(lambda t: (0, 0, 1.0 if 0.9 < t < 0.902 else 0.0))
    found = lissom.simulate(rod, 1.0, method="auto", rtol=1e-2, max_step=1e-3)
    assert found.success
    assert np.abs(found.q).max() > 0.1


def test_fixed_steps_that_cannot_see_an_oscillation_are_refused():
    rod = _soft_arm(lissom.Harmonic((0, 0, 1.0), 100.0))
    with pytest.raises(ValueError, match=r"dt: got 0\.01 s .* period of 0\.01 s, expected less than half"):
        lissom.simulate(rod, 0.1, dt=0.01)
    assert lissom.simulate(rod, 0.1, dt=0.004).success


@pytest.mark.parametrize(
    "options", [{"adaptive": True}, {"method": "radau"}, {"method": "rk45"}, {"method": "auto"}]
)
def test_adaptive_steps_see_every_oscillation(options):
    rod = _soft_arm(lissom.Harmonic((0, 0, 1e-3), 100.0))
    right = lissom.simulate(rod, 0.1, method="radau", rtol=1e-10, atol=1e-13, max_step=2e-4)
    found = lissom.simulate(rod, 0.1, **options)
    assert np.abs(found.q[-1] - right.q[-1]).max() < 1e-4 * np.abs(right.q).max()
