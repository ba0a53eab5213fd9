"""`lissom.simulate`: every method, against SciPy and the definition of the Newmark family, and in trouble."""

import inspect
import signal
import threading

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_ivp

import lissom
from reference import newmark as reference
from reference import pendulum as pendulum_reference

NEWMARK = list(reference.PRESETS)
ADAPTIVE = ["rk45", "dop853", "radau"]
START = {"q0": [-0.7, 0.5], "v0": [0.3, -0.2]}


def pendulum():
    return lissom.SpringPendulum()


def rod(**options):
    """A soft rod that bends, twists and stretches, with a force at its tip."""
    segments = [
        lissom.Segment(0.3, (0.02, 0.012), 5e5, 2e5, 1100.0, {"bend_y": 2, "bend_z": 1, "torsion": 1}, 0.02),
        lissom.Segment(0.2, 0.012, 5e5, 2e5, 1100.0, {"bend_y": 1, "stretch": 1}, 0.02),
    ]
    return lissom.Rod(segments, **({"tip_force": (0.0, 0.3, 0.0)} | options))


MODELS = {"pendulum": (pendulum, START), "rod": (rod, {})}


def simulate(*args, **options):
    result = lissom.simulate(*args, **options)
    assert result.success, result.message
    return result


# ------------------------------------------------------------------------------------------------ defaults


@pytest.mark.parametrize("name", MODELS)
def test_defaults(name):
    make, _ = MODELS[name]
    model = make()
    found = lissom.simulate(model, 0.5)
    assert (found.success, found.status) == (True, "finished")
    assert_allclose(found.t, np.linspace(0.0, 0.5, 51), atol=1e-15)
    assert found.q.shape == found.v.shape == found.a.shape == (51, model.n)
    assert_array_equal(found.q[0], 0.0)
    assert_array_equal(found.v[0], 0.0)
    assert_allclose(found.a[0], model.forward_dynamics(found.q[0], found.v[0]), rtol=1e-6, atol=1e-6)
    assert found.stats.steps == 50
    assert found.stats.nfev_jac == 0
    assert found.stats.wall_time > 0.0


def test_the_documented_defaults_are_the_real_ones():
    parameters = inspect.signature(lissom.simulate).parameters
    options = {name: p.default for name, p in parameters.items() if p.kind is p.KEYWORD_ONLY}
    assert options == {
        "q0": None,
        "v0": None,
        "method": "newmark",
        "dt": 1e-2,
        "jac": "analytic",
        "rtol": 1e-6,
        "atol": 1e-9,
        "t_eval": None,
        "progress": None,
        "beta": 0.25,
        "gamma": 0.5,
        "alpha": None,
        "rho_inf": None,
        "adaptive": False,
        "max_step": None,
        "min_step": 0.0,
        "max_steps": None,
        "predictor": "best",
        "reuse_jacobian": True,
    }
    plain = simulate(pendulum(), 1.0, **START)
    given = {name: value for name, value in options.items() if value is not None}
    spelled_out = simulate(pendulum(), 1.0, **(given | START))
    assert_array_equal(plain.q, spelled_out.q)
    assert plain.stats.nfev == spelled_out.stats.nfev
    for change in (
        {"method": "radau"},
        {"dt": 0.02},
        {"jac": "forward"},
        {"rtol": 1e-4},
        {"atol": 1e-3},
        {"beta": 0.3},
        {"gamma": 0.6},
        {"adaptive": True},
        {"predictor": "zero"},
        {"reuse_jacobian": False},
    ):
        other = simulate(pendulum(), 1.0, **(START | change))
        assert not np.array_equal(other.q, plain.q), change
    # The first-order methods have the same tolerances, not those of solve_ivp.
    plain, spelled_out = (
        simulate(pendulum(), 1.0, method="rk45", **options, **START)
        for options in ({}, {"rtol": 1e-6, "atol": 1e-9})
    )
    assert_array_equal(plain.q, spelled_out.q)


# -------------------------------------------------------------------------------------- against other codes


def spring_and_mass(t, y):
    """The spring pendulum of the lab in Cartesian coordinates."""
    x, z, vx, vz = y
    length = np.hypot(x, z)
    pull = -10.0 * (length - 1.0) / length
    return [vx, vz, pull * x, pull * z - 9.81]


@pytest.mark.parametrize("method", ADAPTIVE)
def test_the_pendulum_against_scipy_in_other_coordinates(method):
    times = np.linspace(0.0, 5.0, 11)
    found = simulate(pendulum(), 5.0, method=method, rtol=1e-10, atol=1e-12, t_eval=times, **START)
    q0, v0 = (np.array(START[x]) for x in ("q0", "v0"))
    start = [*pendulum_reference.position(q0, 1.0), *(pendulum_reference.jacobian(q0, 1.0) @ v0)]
    expected = solve_ivp(spring_and_mass, (0.0, 5.0), start, "DOP853", t_eval=times, rtol=1e-12, atol=1e-13).y
    places = [pendulum_reference.position(q, 1.0) for q in found.q]
    speeds = [pendulum_reference.jacobian(q, 1.0) @ v for q, v in zip(found.q, found.v, strict=True)]
    assert_allclose(places, expected[:2].T, atol=2e-7)
    assert_allclose(speeds, expected[2:].T, atol=1e-6)
    for q, v, a in zip(found.q, found.v, found.a, strict=True):
        assert_allclose(pendulum_reference.inverse_dynamics(q, v, a), 0.0, atol=1e-7)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_rod_against_scipy(method):
    model, times = rod(), np.linspace(0.0, 0.5, 6)
    n = model.n
    found = simulate(model, 0.5, method=method, rtol=1e-9, atol=1e-11, t_eval=times)
    expected = solve_ivp(
        lambda t, y: np.concatenate([y[n:], model.forward_dynamics(y[:n], y[n:])]),
        (0.0, 0.5),
        np.zeros(2 * n),
        "Radau" if method == "radau" else "DOP853",
        t_eval=times,
        rtol=1e-9,
        atol=1e-11,
    ).y.T
    scale = np.abs(expected).max(axis=0)
    assert np.abs(found.q - expected[:, :n]).max(axis=0) == pytest.approx(0.0, abs=1e-5 * scale[:n].max())
    assert np.abs(found.v - expected[:, n:]).max(axis=0) == pytest.approx(0.0, abs=1e-4 * scale[n:].max())


# Steps of the others would have to be shorter than the rod's fastest vibration.
UNCONDITIONALLY_STABLE = ["newmark", "average_acceleration", "hht", "generalised_alpha"]


@pytest.mark.parametrize(
    ("name", "method"),
    [*(("pendulum", method) for method in NEWMARK), *(("rod", method) for method in UNCONDITIONALLY_STABLE)],
)
def test_newmark_has_order_two(name, method):
    make, start = MODELS[name]
    model = make()
    t_end = 0.2
    exact = simulate(model, t_end, method="radau", rtol=1e-11, atol=1e-13, t_eval=[t_end], **start)
    steps = (2e-3 if name == "rod" else 2e-2) / 2.0 ** np.arange(3)
    errors = []
    for h in steps:
        found = simulate(model, t_end, method=method, dt=h, rtol=1e-10, atol=1e-10, **start)
        errors.append(np.linalg.norm(found.q[-1] - exact.q[-1]))
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("method", NEWMARK)
def test_the_family_against_its_definition(method):
    """The pendulum's equations are those of the reference, too: Newton's law in the plane."""
    found = simulate(pendulum(), 0.5, method=method, dt=0.025, rtol=1e-12, atol=1e-12, **START)
    expected = reference.integrate(
        lambda t, q, v, a: pendulum_reference.inverse_dynamics(q, v, a),
        found.t,
        START["q0"],
        START["v0"],
        reference.PRESETS[method],
    )
    for x, y in zip((found.q, found.v, found.a), expected, strict=True):
        assert_allclose(x, y, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("options", [{}, {"method": "hht"}, {"adaptive": True, "rtol": 1e-4, "atol": 1e-6}])
@pytest.mark.parametrize("name", MODELS)
def test_simulate_is_newmark_of_the_inverse_dynamics(name, options):
    make, start = MODELS[name]
    model = make()
    native = simulate(model, 0.2, **start, **options)
    zeros = np.zeros(model.n)
    python = lissom.newmark(
        lambda t, q, v, a: model.inverse_dynamics(q, v, a),
        (0.0, 0.2),
        start.get("q0", zeros),
        start.get("v0", zeros),
        dt=1e-2,
        jac=lambda t, q, v, a: model.tangent(q, v, a),
        **options,
    )
    # Sizes of adaptive steps show what the solution of a step may leave.
    exactness = 1e-4 if "adaptive" in options else 1e-6
    assert_allclose(python.t, native.t, rtol=exactness)
    assert_allclose(python.q, native.q, atol=exactness * np.abs(native.q).max())
    assert python.stats.steps == native.stats.steps


@pytest.mark.parametrize("method", ["newmark", "hht"])
@pytest.mark.parametrize("name", MODELS)
def test_all_jacobians_find_the_same_motion(method, name):
    make, start = MODELS[name]
    model = make()
    motions = {
        jac: simulate(model, 0.2, method=method, jac=jac, dt=5e-3, **start)
        for jac in ("analytic", "forward", "central")
    }
    exact = motions["analytic"]
    scale = np.abs(exact.q).max()
    for jac, found in motions.items():
        assert_allclose(found.q, exact.q, atol=1e-5 * scale)
        evaluations = {"analytic": 0, "forward": model.n, "central": 2 * model.n}[jac]
        assert found.stats.nfev_jac == evaluations * found.stats.njev
        assert found.stats.njev == found.stats.nlu > 0


def test_all_methods_agree():
    exact = simulate(pendulum(), 1.0, method="dop853", rtol=1e-11, atol=1e-11, t_eval=[1.0], **START)
    for method in (*NEWMARK, "generalized_alpha", *ADAPTIVE):
        found = simulate(pendulum(), 1.0, method=method, dt=1e-3, **START)
        assert_allclose(found.q[-1], exact.q[-1], atol=1e-4)
    for options in (
        {"method": "hht", "alpha": -0.3},
        {"method": "generalised_alpha", "rho_inf": 0.0},
        {"beta": 0.3, "gamma": 0.5},
    ):
        found = simulate(pendulum(), 1.0, dt=1e-3, **options, **START)
        assert_allclose(found.q[-1], exact.q[-1], atol=1e-4)


# ------------------------------------------------------------------------------------------ times and steps


@pytest.mark.parametrize("method", ["newmark", "generalised_alpha", *ADAPTIVE])
def test_times(method):
    found = simulate(pendulum(), 0.55, method=method, dt=0.1, **START)
    assert_allclose(found.t, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.55])
    assert found.t[-1] == 0.55
    times = [0.0, 0.05, 0.1, 0.33, 0.55]
    asked = simulate(pendulum(), 0.55, method=method, dt=0.1, t_eval=times, **START)
    assert asked.t.tolist() == times
    assert asked.q.shape == asked.v.shape == asked.a.shape == (5, 2)
    assert_allclose(asked.q[[0, 2, 4]], found.q[[0, 1, 6]], atol=1e-12)
    zero = simulate(pendulum(), 0.0, method=method, **START)
    assert (zero.t.tolist(), zero.q.tolist(), zero.v.tolist()) == ([0.0], [START["q0"]], [START["v0"]])
    assert_allclose(
        zero.a[0], pendulum().forward_dynamics(**{"q": START["q0"], "qd": START["v0"]}), atol=1e-6
    )
    assert simulate(pendulum(), 1.0, method=method, t_eval=[], **START).q.shape == (0, 2)


def test_adaptive_steps():
    found = simulate(pendulum(), 2.0, adaptive=True, rtol=1e-5, atol=1e-5, **START)
    assert np.ptp(np.diff(found.t)[:-1]) > 1e-3
    exact = simulate(pendulum(), 2.0, method="dop853", rtol=1e-10, atol=1e-10, t_eval=[2.0], **START)
    assert_allclose(found.q[-1], exact.q[-1], atol=10 * found.stats.steps * 1e-5)
    bounded = simulate(pendulum(), 2.0, adaptive=True, rtol=0.1, atol=0.1, max_step=0.02, **START)
    assert np.diff(bounded.t).max() < 0.02 * (1 + 1e-9)
    for method in ("newmark", "rk45", "radau"):
        options = {"adaptive": True} if method == "newmark" else {"method": method}
        stuck = lissom.simulate(
            pendulum(), 2.0, rtol=1e-9, atol=1e-9, min_step=0.1, dt=0.5, **options, **START
        )
        assert (stuck.success, stuck.status) == (False, "step_too_small")
        assert "min_step" in stuck.message
    fine = simulate(pendulum(), 1.0, method="rk45", max_step=1e-3, **START)
    assert fine.stats.steps >= 1000


def test_tolerances():
    """Tight ones cost more; one for each coordinate is understood by every method."""
    for options in ({}, {"adaptive": True}, {"method": "rk45"}, {"method": "radau"}):
        loose, tight = (
            simulate(pendulum(), 1.0, rtol=rtol, atol=rtol, **options, **START).stats.nfev
            for rtol in (1e-4, 1e-8)
        )
        assert tight > loose
        same = simulate(
            pendulum(), 1.0, rtol=[1e-4] * 2, atol=np.full(2, 1e-4), **options, **START
        ).stats.nfev
        assert same == loose


# --------------------------------------------------------------------------------------------- what goes in


@pytest.mark.parametrize(
    "make",
    [
        np.array,
        list,
        tuple,
        lambda x: np.array(x, dtype=np.float32),
        lambda x: np.repeat(np.array(x), 2)[::2],
        lambda x: np.array(x, dtype=">f8"),
    ],
    ids=["array", "list", "tuple", "float32", "strided", "big-endian"],
)
def test_any_array_will_do(make):
    def frozen(x):
        x = make(x)
        if isinstance(x, np.ndarray):
            x.flags.writeable = False
        return x

    found = simulate(
        pendulum(),
        1.0,
        q0=frozen([-0.5, 0.25]),
        v0=frozen([0.5, 0.0]),
        t_eval=frozen([0.0, 0.5, 1.0]),
        rtol=frozen([0.0625, 0.0625]),
        atol=frozen([0.0625, 0.0625]),
    )
    plain = simulate(
        pendulum(), 1.0, q0=[-0.5, 0.25], v0=[0.5, 0.0], t_eval=[0, 0.5, 1], rtol=0.0625, atol=0.0625
    )
    assert_array_equal(found.q, plain.q)


@pytest.mark.parametrize(
    ("message", "options"),
    [
        ("t_end: got -1, expected a finite number >= 0", {"t_end": -1.0}),
        ("t_end: got inf", {"t_end": np.inf}),
        ("t_end: got NaN", {"t_end": np.nan}),
        ("q0: expected 2 values, got 3", {"q0": [0.0] * 3}),
        (r"v0\[1\]: got NaN", {"v0": [0.0, np.nan]}),
        ("dt: got 0, expected", {"dt": 0.0}),
        ("dt: got -1, expected", {"dt": -1.0, "method": "rk45"}),
        (
            'method: got "euler", expected one of "newmark", .*"rk45", "dop853", "radau", "auto"$',
            {"method": "euler"},
        ),
        ('jac: got "exact", expected "analytic", "forward" or "central"', {"jac": "exact"}),
        ("rtol: got -1", {"rtol": -1.0}),
        ("rtol: got 3 values, expected 2", {"rtol": [1e-3] * 3}),
        ("rtol: got 3 values, expected 2", {"rtol": [1e-3] * 3, "method": "radau"}),
        ("atol: got 4 values, expected 2", {"atol": [1e-3] * 4, "method": "rk45"}),
        (r"t_eval\[1\]: got 2", {"t_eval": [0.5, 2.0]}),
        (r"t_eval\[1\]: got 2", {"t_eval": [0.5, 2.0], "method": "dop853"}),
        ("beta: got 2, expected", {"beta": 2.0}),
        ('rho_inf: .*"newmark" has no rho_inf', {"rho_inf": 0.5}),
        ("alpha: got 1, ", {"method": "hht", "alpha": 1.0}),
        ("beta: .*an option of the Newmark family, the method is .rk45.", {"method": "rk45", "beta": 0.3}),
        ("gamma: .*an option of the Newmark family", {"method": "radau", "gamma": 0.6}),
        ("alpha: .*an option of the Newmark family", {"method": "radau", "alpha": -0.1}),
        ("rho_inf: .*an option of the Newmark family", {"method": "dop853", "rho_inf": 0.1}),
        ("adaptive: .*an option of the Newmark family", {"method": "rk45", "adaptive": True}),
        (r"max_step: .*adaptive steps \(adaptive=True\)", {"max_step": 0.1}),
        (r"min_step: .*adaptive steps \(adaptive=True\)", {"min_step": 0.1}),
        ("max_steps: got -3, expected a whole number >= 0", {"max_steps": -3}),
        ('predictor: got "none"', {"predictor": "none"}),
        ("adaptive: .* blind", {"method": "linear_acceleration", "adaptive": True}),
        ("number of output times: got .*4 GiB", {"t_end": 1e9, "dt": 1e-3}),
        ("number of output times: got .*4 GiB", {"t_end": 1e9, "dt": 1e-3, "method": "rk45"}),
    ],
)
def test_wrong_values_are_refused_with_what_would_be_right(message, options):
    with pytest.raises(ValueError, match=message):
        lissom.simulate(pendulum(), **({"t_end": 1.0} | options))


def test_wrong_types_are_refused():
    with pytest.raises(
        TypeError, match=r"model: expected a Model .*for equations of your own there are newmark"
    ):
        lissom.simulate(lambda t, q, v, a: a, 1.0)
    with pytest.raises(TypeError, match="q0: expected a one-dimensional array"):
        lissom.simulate(pendulum(), 1.0, q0="left")
    with pytest.raises(TypeError):
        lissom.simulate(pendulum(), 1.0, [0.0, 0.0])
    with pytest.raises(TypeError, match="unexpected keyword"):
        lissom.simulate(pendulum(), 1.0, step=0.1)


def test_the_model_is_not_changed():
    model = rod()
    before = model.inverse_dynamics(*[np.full(model.n, 0.1)] * 3)
    simulate(model, 0.1)
    assert_array_equal(model.inverse_dynamics(*[np.full(model.n, 0.1)] * 3), before)


def test_reruns_are_equal_bit_by_bit():
    for method in ("newmark", "rk45"):
        first, second = (simulate(rod(), 0.1, method=method) for _ in range(2))
        for x in ("t", "q", "v", "a"):
            assert_array_equal(getattr(first, x), getattr(second, x))


# ------------------------------------------------------------------------------------------------- failures


def test_a_singular_start():
    """The spring is compressed to a point: the angle has no inertia there."""
    for method in ("newmark", "hht", "radau"):
        found = lissom.simulate(pendulum(), 1.0, q0=[0.0, -1.0], method=method)
        assert (found.success, found.status, found.t.size) == (False, "no_initial_acceleration", 0)
        assert "mass matrix" in found.message
        assert found.q.shape == (0, 2)
    for method in ("rk45", "dop853"):
        found = lissom.simulate(pendulum(), 1.0, q0=[0.0, -1.0], method=method)
        assert (found.success, found.status) == (False, "non_finite")


@pytest.mark.parametrize("method", ["newmark", *ADAPTIVE])
def test_the_step_limit(method):
    found = lissom.simulate(pendulum(), 1.0, method=method, max_steps=5, dt=1e-3, **START)
    assert (found.success, found.status, found.stats.steps) == (False, "too_many_steps", 5)
    assert "max_steps" in found.message
    assert 0.0 < found.t[-1] < 1.0
    whole = simulate(pendulum(), 1.0, method=method, dt=1e-3, **START)
    assert_allclose(found.q, whole.q[: found.t.size], atol=1e-12)


def test_steps_beyond_the_stability_limit_end_with_the_reason():
    found = lissom.simulate(rod(), 3.0, method="central_difference", dt=0.05)
    assert not found.success
    assert found.status in ("non_finite", "newton_not_converged", "singular_jacobian")
    assert np.isfinite(found.q).all()
    assert "step from t = " in found.message


# ------------------------------------------------------------------------------------- progress, signals, GIL


@pytest.mark.parametrize("method", ["newmark", "rk45", "radau"])
def test_progress(method):
    seen = []
    found = simulate(pendulum(), 1.0, method=method, progress=seen.append, **START)
    assert 1 <= len(seen) <= found.stats.steps
    assert 0.0 < seen[0] <= 1.0
    assert type(seen[0]) is float
    stopped = lissom.simulate(pendulum(), 1.0, method=method, progress=lambda t: True, **START)
    assert (stopped.success, stopped.status, stopped.stats.steps) == (False, "interrupted", 1)
    assert "stopped" in stopped.message

    def stop(t):
        raise StopIteration

    stopped = lissom.simulate(pendulum(), 1.0, method=method, progress=stop, **START)
    assert (stopped.success, stopped.status, stopped.stats.steps) == (False, "interrupted", 1)
    finished = lissom.simulate(pendulum(), 0.1, method=method, progress=lambda t: "no truth", **START)
    assert finished.success


FAMILY_OPTIONS = {
    "jac": "analytic",
    "beta": 0.25,
    "gamma": 0.5,
    "alpha": -0.1,
    "rho_inf": 0.8,
    "adaptive": False,
    "predictor": "best",
    "reuse_jacobian": True,
}


@pytest.mark.parametrize("method", ["rk45", "dop853", "radau"])
@pytest.mark.parametrize("name", FAMILY_OPTIONS)
def test_first_order_methods_refuse_options_of_the_newmark_family_even_with_their_defaults(method, name):
    with pytest.raises(ValueError, match=f"^{name}: expected nothing: it is an option of the Newmark family"):
        lissom.simulate(pendulum(), 1.0, method=method, **{name: FAMILY_OPTIONS[name]}, **START)


@pytest.mark.parametrize("method", ["newmark", "rk45"])
def test_exceptions_of_the_progress_callback_come_back_unchanged(method):
    mishap = RuntimeError("here")

    def fail(t):
        raise mishap

    with pytest.raises(RuntimeError) as caught:
        lissom.simulate(pendulum(), 1.0, method=method, progress=fail, **START)
    assert caught.value is mishap
    with pytest.raises(TypeError, match="not callable"):
        lissom.simulate(pendulum(), 1.0, method=method, progress=3, **START)


@pytest.mark.parametrize("method", ["newmark", "rk45"])
def test_ctrl_c_is_answered_and_keeps_what_was_computed(method):
    """Without a callback. Years of motion, of which a tenth of a second of computing is wanted."""
    timer = threading.Timer(0.1, signal.raise_signal, [signal.SIGINT])
    timer.start()
    with pytest.raises(KeyboardInterrupt) as caught:
        lissom.simulate(pendulum(), 1e8, method=method, dt=1e-3, t_eval=[0.0, 0.5, 1e8], **START)
    timer.join()
    result = caught.value.result
    assert (result.success, result.status) == (False, "interrupted")
    assert result.t.tolist() == [0.0, 0.5]
    assert result.stats.steps > 500


def test_other_threads_run_meanwhile():
    """Two runs that end only when the other one has begun: with the GIL held, neither would."""
    begun = [threading.Event(), threading.Event()]
    results = [None, None]

    def run(i):
        def progress(t):
            begun[i].set()
            return begun[1 - i].is_set()

        results[i] = lissom.simulate(pendulum(), 1e8, dt=1e-3, t_eval=[], progress=progress, **START)

    threads = [threading.Thread(target=run, args=(i,)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20.0)
    assert [result.status for result in results] == ["interrupted"] * 2


def test_accelerations_of_explicit_runs_are_those_of_the_forward_dynamics():
    pendulum = lissom.SpringPendulum()
    for method in ("rk45", "dop853"):
        motion = lissom.simulate(pendulum, 0.2, q0=[-0.8, 0.5], method=method, t_eval=[0.0, 0.1, 0.2])
        states = zip(motion.q, motion.v, strict=True)
        wanted = [pendulum.forward_dynamics(q, v) for q, v in states]
        assert motion.a is motion.a
        assert_allclose(motion.a, wanted, rtol=1e-14)
