"""`lissom.simulate`: all methods, compared with SciPy and the definition of the Newmark family; failures."""

import inspect
import pickle
import re
import signal
import threading
import warnings
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_ivp

import lissom
from reference import newmark as reference
from reference import pendulum as pendulum_reference

NEWMARK = list(reference.PRESETS)
ADAPTIVE = ["rk45", "dop853", "radau"]
SCENES = Path(__file__).parents[3] / "scenes"
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
        "t0": 0.0,
        "q0": None,
        "v0": None,
        "u": None,
        "method": "newmark",
        "dt": 1e-2,
        "jac": "analytic",
        "rtol": 1e-6,
        "atol": None,
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
        "control": None,
        "control_step": None,
        "max_seconds": None,
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


@pytest.mark.parametrize(("method", "peer"), [("rk45", "RK45"), ("dop853", "DOP853"), ("radau", "Radau")])
@pytest.mark.parametrize("damping", [0.0, 0.1])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-7])
def test_as_many_steps_as_scipy_takes(method, peer, damping, tolerance):
    """What a step's error is estimated to be decides how many there are: two masses on springs."""
    joints = [lissom.Prismatic((1, 0, 0), stiffness=c, damping=d) for c, d in ((1.0, damping), (3.0, 0.0))]
    first, second = (lissom.Body(m) for m in (1.0, 0.5))
    links = [
        lissom.Link("first", body=first, joint=joints[0]),
        lissom.Link("second", body=second, joint=joints[1], parent="first"),
    ]
    M, D, K = np.array([[1.5, 0.5], [0.5, 0.5]]), np.diag([damping, 0.0]), np.diag([1.0, 3.0])
    q0, v0 = [1.0, 0.3], [0.0, 0.2]
    found = simulate(
        lissom.Robot(links, gravity=(0, 0, 0)),
        60.0,
        method=method,
        rtol=tolerance,
        atol=tolerance,
        q0=q0,
        v0=v0,
    )
    of_state = np.block([[0 * M, np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]])
    jacobian = {"jac": of_state} if peer == "Radau" else {}
    expected = solve_ivp(
        lambda t, y: of_state @ y, (0.0, 60.0), q0 + v0, peer, rtol=tolerance, atol=tolerance, **jacobian
    )
    steps = len(expected.t) - 1
    # The first steps and the last one may differ.
    assert found.stats.steps == pytest.approx(steps, abs=3 + 0.005 * steps)


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
    """The pendulum's equations are also those of the reference: Newton's law in the plane."""
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
    # Sizes of adaptive steps depend on the remaining error of the solution of a step.
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
    """Tight tolerances cost more; every method accepts one per coordinate."""
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
        ("t_end: got -1, expected at least t0 = 0", {"t_end": -1.0}),
        ("t0: got NaN, expected a finite number", {"t0": np.nan}),
        ("t_end: got 1, expected at least t0 = 2", {"t0": 2.0}),
        (r"t_eval\[0\]: got 0.2", {"t0": 0.5, "t_eval": [0.2]}),
        ("dt: got 0.01, expected a step that rounding", {"t0": 1e16, "t_end": 1.1e16}),
        ("t_end: got inf", {"t_end": np.inf}),
        ("t_end: got NaN", {"t_end": np.nan}),
        ("q0: expected 2 values, got 3", {"q0": [0.0] * 3}),
        (r"v0\[1\]: got NaN", {"v0": [0.0, np.nan]}),
        ("dt: got 0, expected", {"dt": 0.0}),
        ("dt: got -1, expected", {"dt": -1.0, "method": "rk45"}),
        (
            'method: got "euler", expected one of "newmark", .*"rk45", "dop853", "radau", '
            '"quasi_static", "auto"$',
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
        ("beta: .*rho_inf and beta are parameters of different methods", {"rho_inf": 0.5, "beta": 0.3}),
        ("alpha: got 1, ", {"method": "hht", "alpha": 1.0}),
        (
            "beta: an option of the Newmark family, which the method .rk45. does not have",
            {"method": "rk45", "beta": 0.3},
        ),
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
    """The spring is compressed to a point, where the angle has no inertia."""
    for method in ("newmark", "hht", *ADAPTIVE):
        found = lissom.simulate(pendulum(), 1.0, q0=[0.0, -1.0], method=method)
        assert (found.success, found.status, found.t.size) == (False, "no_initial_acceleration", 0)
        assert "mass matrix" in found.message
        assert found.q.shape == (0, 2)


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
    with pytest.raises(ValueError, match=f"^{name}: an option of the Newmark family, which the method"):
        lissom.simulate(pendulum(), 1.0, method=method, **{name: FAMILY_OPTIONS[name]}, **START)


@pytest.mark.parametrize("method", ["newmark", "rk45"])
def test_exceptions_of_the_progress_callback_come_back_unchanged(method):
    mishap = RuntimeError("here")

    def fail(t):
        raise mishap

    with pytest.raises(RuntimeError) as caught:
        lissom.simulate(pendulum(), 1.0, method=method, progress=fail, **START)
    assert caught.value is mishap
    with pytest.raises(TypeError, match=r"^progress: expected a function, got int"):
        lissom.simulate(pendulum(), 1.0, method=method, progress=3, **START)


@pytest.mark.parametrize("method", ["newmark", "rk45"])
def test_ctrl_c_is_answered_and_keeps_what_was_computed(method):
    """Without a callback. Years of motion, interrupted after a tenth of a second of computing."""
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
    """Two runs that end only after the other one has begun, which is impossible if the GIL is held."""
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


MOVING_BASES = {
    "shaken": {"translation": lambda t: (0.05 * np.sin(9 * t), 0.02 * np.cos(7 * t), 0)},
    "turned": {"axis": (0, 0, 1), "angle": lambda t: 0.6 * np.sin(5 * t)},
}


@pytest.mark.parametrize("base", MOVING_BASES)
@pytest.mark.parametrize("is_behind_a_frame", [False, True])
def test_rods_alone_on_moving_bases_move_as_with_implicit_steps(is_behind_a_frame, base):
    """Explicit steps have kernels of their own for such rods; implicit ones do not use these."""
    modes = {"bend_y": 3, "bend_z": 2}
    segment = lissom.Segment(
        0.4, 0.01, 1e6, poisson_ratio=0.45, density=1050, modes=modes, retardation_time=0.02
    )
    placed = {"position": (0.1, 0.2, 0.3), "orientation": (0.6, 0, 0.8, 0)}
    links = [lissom.Link("rod", parent="frame" if is_behind_a_frame else None, rod=[segment], **placed)]
    if is_behind_a_frame:
        links.insert(0, lissom.Link("frame", position=(0, 0, 0.1)))
    robot = lissom.Robot(links, base_motion=lissom.BaseMotion(**MOVING_BASES[base]))
    accurate = {"rtol": 1e-8, "atol": 1e-10, "t_eval": np.linspace(0, 0.5, 6)}
    explicit, implicit = (
        lissom.simulate(robot, 0.5, method=method, **accurate) for method in ("rk45", "radau")
    )
    assert explicit.success
    assert implicit.success
    assert_allclose(explicit.q, implicit.q, rtol=0, atol=1e-8 * np.abs(implicit.q).max())


def test_accelerations_of_explicit_runs_are_those_of_the_forward_dynamics():
    pendulum = lissom.SpringPendulum()
    for method in ("rk45", "dop853"):
        motion = lissom.simulate(pendulum, 0.2, q0=[-0.8, 0.5], method=method, t_eval=[0.0, 0.1, 0.2])
        states = zip(motion.q, motion.v, strict=True)
        wanted = [pendulum.forward_dynamics(q, v) for q, v in states]
        assert motion.a is motion.a
        assert_allclose(motion.a, wanted, rtol=1e-14)


# ------------------------------------------------------------------------------------- the start of the time

ALL_METHODS = ["newmark", "hht", "generalised_alpha", "radau", "rk45", "dop853", "auto"]


def driven_wire(force, **segment):
    wire = lissom.Segment(0.5, 2e-3, 2e9, 8e8, 1200.0, {"bend_y": 2}, retardation_time=2e-3)
    return lissom.Rod([wire], gravity=(0, 0, 0), loads=[lissom.Load(force=force)])


FORCE = {
    "harmonic": lissom.Harmonic((0.0, 0.0, 0.05), 2.0, phase=0.3),
    "table": (
        np.linspace(0.0, 2.0, 81),
        [(0, 0, 0.05 * np.sin(12.6 * t + 0.3)) for t in np.linspace(0, 2, 81)],
    ),
    "callable": lambda t: (0.0, 0.0, 0.05 * np.sin(4.0 * np.pi * t + 0.3)),
}


@pytest.mark.parametrize("method", ALL_METHODS)
def test_a_run_may_begin_at_any_time(method):
    """With the load shifted in time, the motion is the same, shifted."""
    late = 3.25
    dt = 1.0 / 256.0
    turned = lissom.Harmonic((0.0, 0.0, 0.05), 2.0, phase=0.3 + 4.0 * np.pi * late)
    options = {"method": method, "dt": dt, "q0": [0.1, 0.0], "v0": [0.0, 1.0]}
    wanted = lissom.simulate(driven_wire(turned), 0.25, **options)
    found = lissom.simulate(driven_wire(FORCE["harmonic"]), late + 0.25, t0=late, **options)
    assert found.t[0] == late
    assert found.t[-1] == late + 0.25
    assert_allclose(found.t, late + wanted.t, rtol=0, atol=1e-12)
    atol = 1e-4 if method in ("rk45", "dop853", "radau", "auto") else 1e-9
    assert_allclose(found.q, wanted.q, rtol=0, atol=atol * abs(wanted.q).max())
    assert_allclose(found.a, wanted.a, rtol=0, atol=10 * atol * abs(wanted.a).max())
    assert_allclose(found.balance.work, wanted.balance.work, rtol=0, atol=10 * atol * wanted.balance.scale)
    assert found.balance.work[0] == found.balance.dissipated[0] == 0.0
    assert found.balance.drift == pytest.approx(wanted.balance.drift, rel=0.1, abs=1e-5)


@pytest.mark.parametrize("form", FORCE)
@pytest.mark.parametrize("method", ["newmark", "radau", "dop853"])
def test_a_run_in_ten_pieces_is_the_whole_run(method, form):
    rod = driven_wire(FORCE[form])
    options = {"method": method, "dt": 1e-3}
    if method != "newmark":
        options |= {"rtol": 1e-7, "atol": 1e-9}
    whole = lissom.simulate(rod, 1.0, t_eval=np.linspace(0.0, 1.0, 11), **options)
    q, v, works = np.zeros(2), np.zeros(2), [0.0]
    for k in range(10):
        piece = lissom.simulate(rod, (k + 1) / 10, t0=k / 10, q0=q, v0=v, **options)
        assert (piece.t[0], piece.t[-1]) == (k / 10, (k + 1) / 10)
        q, v = piece.q[-1], piece.v[-1]
        works.append(works[-1] + piece.balance.work[-1])
        assert_allclose(q, whole.q[k + 1], rtol=0, atol=1e-5 * abs(whole.q).max())
    assert abs(whole.q[-1]).max() > 0.05
    assert_allclose(works, whole.balance.work, rtol=0, atol=1e-4 * whole.balance.scale)


@pytest.mark.parametrize("method", ["newmark", "radau", "rk45", "dop853"])
def test_times_that_only_rounding_separates_are_the_same(method):
    """A step from 0.3 to 0.1 + 0.2, of 6e-17 s, would consist of rounding errors."""
    assert 0.1 + 0.2 > 0.3
    tables = [
        ([0.0, time, 0.6], [(0, 0, 0), (0, 0, 0.05), (0, 0, 0)]) for time in (0.3, 0.1 + 0.2, 0.3 + 1e-15)
    ]
    options = {"method": method, "dt": 0.01} | ({"adaptive": True} if method == "newmark" else {})
    options |= {"rtol": 1e-7, "atol": 1e-8}
    wire = driven_wire((0, 0, 0)).segments[0]
    found = [
        lissom.Rod([wire], gravity=(0, 0, 0), loads=[lissom.Load(force=table) for table in chosen])
        for chosen in ([tables[0]] * 3, tables)
    ]
    for t0, t_end in ((0.0, 0.6), (0.3, 0.6), (0.1 + 0.2, 0.6), (0.0, 0.3), (0.0, 0.1 + 0.2)):
        start = {"q0": [0.3, 0.0], "v0": [0.0, 1.0], "t0": t0}
        motions = [lissom.simulate(rod, t_end, **start, **options) for rod in found]
        # Up to the tolerance of the runs.
        assert_allclose(motions[1].q, motions[0].q, rtol=0, atol=1e-7)
        assert_allclose(motions[1].v, motions[0].v, rtol=0, atol=1e-4)
        assert abs(motions[1].stats.steps - motions[0].stats.steps) <= 3


def test_the_times_of_a_run_are_those_asked_for():
    rod = driven_wire(FORCE["callable"])
    for method in ALL_METHODS:
        found = lissom.simulate(rod, -0.5, t0=-1.0, method=method, t_eval=[-1.0, -0.7, -0.5])
        assert found.t.tolist() == [-1.0, -0.7, -0.5]
        assert found.q.shape == found.a.shape == (3, 2)
        assert len(found.balance.work) == 3
    assert lissom.simulate(rod, 1.5, t0=1.5).t.tolist() == [1.5]


def test_modes_are_chosen_for_the_time_of_the_run():
    """A load that acts late affects only runs at that time."""
    wire = lissom.Segment(0.5, 5e-3, 2e9, 8e8, 1200.0, {}, retardation_time=2e-3)
    load = lissom.Load(force=([1.0, 1.1, 1.2, 1.3], [(0, 0, 0), (0, 3, 0), (0, 3, 0), (0, 0, 0)]))
    rod = lissom.Rod([wire], gravity=(0, 0, 0), loads=[load])
    early, late = (lissom.choose_modes(rod, t0 + 0.4, t0=t0, rtol=1e-2) for t0 in (0.0, 1.0))
    assert "bend_z" in late.segments[0].modes
    assert late.n > early.n
    with pytest.raises(ValueError, match="t_end: got 1, expected a finite number > 1"):
        lissom.choose_modes(rod, 1.0, t0=1.0)


SCENE_LATE = """
version = 1
[[rod]]
[rod.base_motion.translation]
times = [2, 2.5, 2.7, 3]
values = [[0, 0, 0], [0, 0, 0.1], [0, 0, 0], [0, 0, 0]]
[[rod.segment]]
length = 0.5
radius = 0.005
young_modulus = 2e9
shear_modulus = 8e8
density = 1200
retardation_time = 1e-3
modes = {{ bend_y = 2 }}
[simulation]
t0 = {t0}
t_end = {t_end}
dt = 1e-3
output.dt = 0.1
"""


def test_scenes_begin_at_their_time():
    scene = lissom.Scene.loads(SCENE_LATE.format(t0=2.1, t_end=2.6))
    assert (scene.simulation.t0, scene.simulation.t_end) == (2.1, 2.6)
    found = scene.run()
    assert_allclose(found.t, [2.1, 2.2, 2.3, 2.4, 2.5, 2.6], rtol=1e-15)
    wanted = lissom.simulate(scene.model, 2.6, t0=2.1, dt=1e-3, t_eval=found.t)
    assert_array_equal(found.q, wanted.q)
    from lissom.analysis.advice import advice

    advice(scene)
    for t0, t_end in ((1.9, 2.4), (2.6, 3.1)):
        with pytest.raises(lissom.SceneError, match="expected that its tables cover the run from"):
            lissom.Scene.loads(SCENE_LATE.format(t0=t0, t_end=t_end))
    with pytest.raises(lissom.SceneError, match="t0"):
        lissom.Scene.loads(SCENE_LATE.format(t0="inf", t_end=0.5))
    # The end of the table up to rounding.
    assert lissom.Scene.loads(SCENE_LATE.format(t0=2.7, t_end=2.7 + 0.3)).run().success


# ------------------------------------------------------------------------------------- steps that do not see


def stiff_wire(hertz, load=None, damping=0.0, **options):
    """A wire of 0.5 m with this first frequency."""
    density, radius, length = 1200.0, 2.5e-3, 0.5
    E = density * (2.0 * np.pi * hertz * length**2 / 3.5160 / (radius / 2.0)) ** 2
    wire = lissom.Segment(length, radius, E, E / 3, density, {"bend_y": 2}, retardation_time=damping)
    loads = [] if load is None else [lissom.Load(force=load(3 * E * np.pi * radius**4 / 4 / length**3))]
    return lissom.Rod([wire], gravity=(0, 0, 0), loads=loads, **options)


def error_of(rod, found, **options):
    right = lissom.simulate(rod, found.t[-1], method="radau", rtol=1e-7, atol=1e-8, t_eval=found.t, **options)
    tips = [rod.pose(motion.q, rod.length)[:, :3, 3] for motion in (found, right)]
    return np.linalg.norm(tips[0] - tips[1], axis=1).max() / rod.length


UNSEEN = {
    "let go": ({}, {"q0": [0.25, 0.0]}),
    "pushed": ({}, {"v0": [60.0, 0.0]}),
    "sudden load": ({"load": lambda K: (0.0, 0.0, 0.08 * K)}, {}),
    "late pulse": (
        {"load": lambda K: ([0.2, 0.201, 0.22], [(0, 0, 0), (0, 0, 0.16 * K), (0, 0, 0)])},
        {},
    ),
}


def test_a_step_beyond_the_end_is_the_run():
    rod = stiff_wire(25.0)
    with pytest.warns(
        lissom.AccuracyWarning, match=r"^The step of 0\.05 s \(the whole run, shorter than `dt` of 0\.5 s\) "
    ):
        lissom.simulate(rod, 0.05, dt=0.5, q0=[0.25, 0.0])


@pytest.mark.parametrize("hertz", [25.0, 74.0])
@pytest.mark.parametrize("what", UNSEEN)
def test_fixed_steps_say_what_they_do_not_see(what, hertz):
    arguments, start = UNSEEN[what]
    rod = stiff_wire(hertz, **arguments)
    with pytest.warns(
        lissom.AccuracyWarning, match="The step of 0.01 s does not resolve a vibration of"
    ) as caught:
        found = lissom.simulate(rod, 0.4, **start)
    assert caught[0].filename == __file__
    assert found.success
    assert found.message.endswith(found.doubt)
    assert found.doubt == str(caught[0].message)
    error = error_of(rod, found, **start)
    assert error > 0.03
    said = float(re.search(r"error of the tip is about ([\d.]+) %", found.doubt)[1]) / 100
    assert 0.4 * error < said < 2.5 * error
    # The suggested step is sufficient, and so are the other suggestions.
    step = float(re.search(r"steps of ([\d.e-]+) s, adaptive", found.doubt)[1])
    if what != "late pulse":
        # Shorter steps resolve more of a pulse.
        finer = lissom.simulate(rod, 0.4, dt=step, **start)
        assert finer.doubt is None
        assert error_of(rod, finer, **start) < 0.015
    assert lissom.simulate(rod, 0.1, method="auto", rtol=1e-2, **start).doubt is None


@pytest.mark.parametrize(
    ("arguments", "start"),
    [
        # Not excited, too small to be visible, damped, or following a slow load.
        ({}, {}),
        ({}, {"q0": [0.008, 0.0]}),
        ({"damping": 1.0}, {"q0": [0.8, 0.0]}),
        ({"load": lambda K: lissom.Harmonic((0.0, 0.0, 0.08 * K), 0.5)}, {}),
        ({"load": lambda K: ([0.0, 0.4], [(0, 0, 0), (0, 0, 0.08 * K)])}, {}),
    ],
)
def test_fixed_steps_say_nothing_where_all_is_well(arguments, start):
    rod = stiff_wire(25.0, **arguments)
    found = lissom.simulate(rod, 0.4, **start)
    assert found.doubt is None
    assert error_of(rod, found, **start) < 0.01


def test_the_labs_steps_are_fine():
    for name in ("lab-horizontal", "lab-hanging"):
        scene = lissom.Scene.load(SCENES / f"{name}.toml")
        assert scene.run().doubt is None


def test_a_warning_that_is_an_error_keeps_the_result():
    with warnings.catch_warnings():
        warnings.simplefilter("error", lissom.AccuracyWarning)
        with pytest.raises(lissom.AccuracyWarning) as caught:
            lissom.simulate(stiff_wire(25.0), 0.1, q0=[0.8, 0.0])
    assert caught.value.result.success
    assert len(caught.value.result.t) == 11


ROD_OF_A_KILOGRAM = lissom.Body(1.0, centre=(0.5, 0, 0), inertia=(0, 1 / 12, 1 / 12))
DOUBLE_PENDULUM = lissom.Robot(
    [
        lissom.Link("upper", joint=lissom.Revolute((0, 1, 0)), body=ROD_OF_A_KILOGRAM),
        lissom.Link(
            "lower",
            joint=lissom.Revolute((0, 1, 0)),
            body=ROD_OF_A_KILOGRAM,
            parent="upper",
            position=(1, 0, 0),
        ),
    ]
)
TUMBLING = lissom.Robot(
    [lissom.Link("body", joint=lissom.Free(), body=lissom.Body(1.0, inertia=(1e-3, 2e-3, 2.5e-3)))],
    gravity=(0, 0, 0),
)


def energy_change(motion):
    """Largest gain and loss of energy since the start, by the largest kinetic energy."""
    balance = motion.balance
    total = balance.kinetic + balance.elastic + balance.gravitational
    return (total.max() - total[0]) / balance.kinetic.max(), (total[0] - total.min()) / balance.kinetic.max()


@pytest.mark.parametrize(
    ("robot", "v0", "dt"),
    [(DOUBLE_PENDULUM, (0, 0), 0.05), (TUMBLING, (0, 0, 0, 33, 100, 20), 0.01)],
    ids=["double pendulum", "tumbling body"],
)
def test_energy_that_steps_add_or_take_out_is_doubted(robot, v0, dt):
    with pytest.warns(
        lissom.AccuracyWarning, match=r"energy (rises|falls) by [\d.]+ % of the largest"
    ) as caught:
        found = lissom.simulate(robot, 2.0, v0=v0, dt=dt)
    assert found.success
    assert found.doubt == str(caught[0].message)
    change = max(energy_change(found))
    assert change > 0.01
    # Warnings are errors here: a tenth of the step is no reason to doubt.
    found = lissom.simulate(robot, 2.0, v0=v0, dt=0.1 * dt)
    assert found.doubt is None
    assert max(energy_change(found)) < 0.1 * change


@pytest.mark.parametrize(
    ("robot", "v0", "dt"),
    [(DOUBLE_PENDULUM, (0, 0), 0.05), (TUMBLING, (0, 0, 0, 33, 100, 20), 0.01)],
    ids=["double pendulum", "tumbling body"],
)
def test_a_motion_that_is_advanced_step_by_step_is_doubted_as_well(robot, v0, dt):
    with pytest.warns(lissom.AccuracyWarning):
        found = lissom.simulate(robot, 2.0, v0=v0, dt=dt)
    stepped = lissom.Simulation(robot, v0=v0, dt=dt)
    for _ in range(30):
        stepped.step()
    half_way = pickle.loads(pickle.dumps(stepped))
    for simulation in (stepped, half_way, stepped.copy()):
        simulation.step(duration=2.0 - simulation.t)
        assert simulation.doubt == found.doubt
        assert simulation.message.endswith(found.doubt)
    finer = lissom.Simulation(robot, v0=v0, dt=0.1 * dt)
    finer.step(duration=2.0)
    assert finer.doubt is None


HEAVY = lissom.Link("heavy", joint=lissom.Prismatic((1, 0, 0)), body=lissom.Body(1e3), position=(0, 5, 0))
FLYWHEEL = lissom.Link("wheel", joint=lissom.Revolute((0, 0, 1)), body=lissom.Body(1.0, inertia=np.eye(3)))


@pytest.mark.parametrize("other", [HEAVY, FLYWHEEL], ids=lambda link: link.name)
def test_energy_that_steps_add_is_doubted_beside_what_moves_uniformly(other):
    """A double pendulum is as wrong beside a heavy slider as alone."""
    both = lissom.Robot([*DOUBLE_PENDULUM.links, other])
    doubts = []
    for robot, v0 in ((DOUBLE_PENDULUM, [0, 0]), (both, [0, 0, 300])):
        with pytest.warns(lissom.AccuracyWarning, match="energy rises"):
            found = lissom.simulate(robot, 2.0, v0=v0, dt=0.05)
        stepped = lissom.Simulation(robot, v0=v0, dt=0.05)
        for _ in range(20):
            stepped.step()
        stepped = pickle.loads(pickle.dumps(stepped))
        stepped.step(duration=2.0 - stepped.t)
        assert stepped.doubt == found.doubt
        doubts.append(found.doubt)
        assert lissom.simulate(robot, 2.0, v0=v0, dt=0.005).doubt is None
    assert doubts[0] == doubts[1]


def test_what_inputs_supply_is_not_doubted():
    """Nobody knows what the jumps of a controller add."""
    link = lissom.Link("weight", joint=lissom.Prismatic((1, 0, 0)), body=lissom.Body(1.0))
    load = lissom.Load(force=lissom.Input("force", (0, 0, 0)), link="weight")
    stepped = lissom.Simulation(lissom.Robot([link], gravity=(0, 0, 0), loads=[load]), dt=0.01)
    for k in range(50):
        stepped.step([k % 7, 0, 0])
    assert stepped.energy.kinetic > 0.1
    assert stepped.doubt is None


def carried(motion, **joint):
    """A weight on a rail that moves as prescribed."""
    links = [
        lissom.Link("rail", body=lissom.Body(1.0), joint=lissom.Prismatic((1, 0, 0), motion=motion)),
        lissom.Link(
            "weight", parent="rail", body=lissom.Body(1.0), joint=lissom.Prismatic((1, 0, 0), **joint)
        ),
    ]
    return lissom.Robot(links, gravity=(0, 0, 0))


def quintic(steps):
    return lambda t: (lambda s: s**3 * (10 - 15 * s + 6 * s * s))(min(max((t - 0.1) / (steps * 0.01), 0), 1))


@pytest.mark.parametrize("method", ["newmark", "generalised_alpha"])
@pytest.mark.parametrize("kind", ["table", "function"])
@pytest.mark.parametrize("steps", [1, 2, 3, 5, 40])
def test_moves_of_few_steps_that_drag_along_what_is_free_are_doubted(method, kind, steps):
    """Without friction the weight stays where it is, to two percent of the way, or there is a doubt."""
    table = ([0, 0.1, 0.1 + 0.01 * steps, 1.0], [0, 0, 1.0, 1.0], "monotone")
    robot = carried(table if kind == "table" else quintic(steps))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = lissom.simulate(robot, 0.6, dt=0.01, method=method)
    off = abs(run.q[-1, 0] + 1)
    assert bool(run.doubt) == (off > 0.02), off
    assert [str(warning.message) for warning in caught] == ([run.doubt] if run.doubt else [])
    stepped = lissom.Simulation(robot, dt=0.01, method=method)
    stepped.step(duration=0.3)
    half_way = pickle.loads(pickle.dumps(stepped)) if kind == "table" else stepped.copy()
    half_way.step(duration=0.3)
    assert half_way.doubt == run.doubt
    if run.doubt:
        said = float(re.search(r"dragged along by up to (\d+) %", run.doubt)[1]) / 100
        assert said == pytest.approx(off, rel=0.5)
    if run.doubt and kind == "table" and steps > 2:
        # Functions also leave a velocity.
        step = float(re.search(r"Take steps of ([\d.e-]+) s", run.doubt)[1])
        finer = lissom.simulate(robot, 0.6, dt=step, method=method)
        assert abs(finer.q[-1, 0] + 1) < 0.04


@pytest.mark.parametrize("steps", [12, 24, 80])
def test_moves_whose_accelerations_jump_within_steps_leave_velocities_that_are_doubted(steps):
    """A cosine that begins and ends between the ends of steps; exactly, the weight stays at rest."""
    robot = carried(lambda t: 0.5 - 0.5 * np.cos(np.pi * min(max((t - 0.1037) / (steps * 0.01), 0), 1)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lissom.AccuracyWarning)
        run = lissom.simulate(robot, 1.2, dt=0.01)
    fastest = 0.5 * np.pi / (steps * 0.01)
    off = abs(run.v[-1, 0]) / fastest
    assert off > 0.005
    assert bool(run.doubt) == (off > 0.02), off
    if steps == 24:
        # What the begin leaves counts less after 24 steps: springs and dampers would have taken it.
        said = float(re.search(r"keeps up to (\d+) % of its largest velocity", run.doubt)[1]) / 100
        assert said == pytest.approx(off, rel=0.5)


def test_moves_of_few_steps_of_what_is_held_are_not_doubted():
    """A stiff spring brings the weight along."""
    for motion in (([0, 0.1, 0.15, 1.0], [0, 0, 1.0, 1.0], "monotone"), quintic(5)):
        run = lissom.simulate(carried(motion, stiffness=1e6, damping=1e3), 0.6, dt=0.01)
        assert run.doubt is None
        assert abs(run.q[-1, 0]) < 1e-3


@pytest.mark.parametrize("method", ["newmark", "generalised_alpha"])
def test_what_accelerates_from_the_start_is_of_order_two(method):
    """A function whose acceleration jumps at the start of the run: what was before does not count."""

    def ramp(t):
        s = min(max(t / 0.5, 0), 1)
        return 0.1 * s * s * (3 - 2 * s)

    robot = carried(ramp, stiffness=16.0)
    bend, change = 0.1 * 6 / 0.25, -0.1 * 12 / 0.125

    def exact(t):
        """Of `y'' = -16 (y - ramp)` from rest, while the ramp lasts."""
        free = bend / 16 * np.cos(4 * t) + change / 64 * np.sin(4 * t)
        return ramp(t) - (bend + change * t) / 16 + free

    errors = []
    for dt in (0.01, 0.005, 0.0025):
        run = lissom.simulate(robot, 0.4, dt=dt, method=method)
        errors.append(abs(run.q[-1, 0] + ramp(0.4) - exact(0.4)))
    assert errors[0] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.15)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.15)


def test_a_loss_without_damping_is_doubted_and_one_by_a_method_that_damps_is_not():
    v0 = (0, 0, 0, 10, 30, 6)
    with pytest.warns(
        lissom.AccuracyWarning, match=r"falls by [\d.]+ % of .*, though nothing dissipates any"
    ):
        found = lissom.simulate(TUMBLING, 0.6, v0=v0, dt=0.02)
    assert energy_change(found)[1] > 0.03
    found = lissom.simulate(TUMBLING, 0.6, v0=v0, dt=0.02, method="generalised_alpha", rho_inf=0.8)
    assert found.doubt is None


def test_energy_that_is_supplied_is_not_doubted():
    """A force pushes the body, constant, by a controller, and as a function of time."""
    link = lissom.Link("weight", joint=lissom.Prismatic((1, 0, 0)), body=lissom.Body(1.0))
    commanded = lissom.Load(force=lissom.Input("force", (1, 0, 0)), link="weight")
    driven = lissom.Load(force=lambda t: (t, 0, 0), link="weight")
    robot = lissom.Robot([link], loads=[commanded])
    runs = [
        lissom.simulate(robot, 1.0),
        lissom.simulate(robot, 1.0, control=lambda t, q, v: [t, 0, 0], control_step=0.02),
        lissom.simulate(lissom.Robot([link], loads=[driven]), 1.0),
    ]
    for run in runs:
        assert run.doubt is None
        assert run.balance.kinetic[-1] > 0.1


def test_energy_that_steps_add_is_doubted_where_loads_vary_in_time():
    """Next to what a force supplies that varies, as without it."""
    force = lissom.Load(force=lambda t: (np.sin(5 * t), 0, 0), link="body")
    robot = lissom.Robot(TUMBLING.links, gravity=(0, 0, 0), loads=[force])
    v0 = (0, 0, 0, 33, 100, 20)
    with pytest.warns(lissom.AccuracyWarning, match=r"energy rises by [\d.]+ % of the largest"):
        lissom.simulate(robot, 2.0, v0=v0, dt=0.01)
    assert lissom.simulate(robot, 2.0, v0=v0, dt=0.001).doubt is None


def test_work_of_what_varies_in_time_is_not_doubted():
    """Of muscles, of a load on a rod that vibrates in steps that hardly resolve it, and of nothing at all."""
    segment = lissom.Segment(
        1.0, 1e-2, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 3, "stretch": 2}
    )
    pulses = ([0, 0.02, 0.04, 0.06], [(0, 0, 0), (0, 0, 0.1), (0, 0, -0.1), (0, 0, 0)])
    knock = lissom.Load(force=pulses, link="rod", at=0.7)
    muscle = lissom.ActiveStrain("rod", "bend_y", 1.0, lissom.Harmonic(1.0, 3.0), name="muscle")
    link = lissom.Link("rod", rod=[segment])
    for more in ({"loads": [knock]}, {"actuators": [muscle]}):
        for dt in (1e-3, 2e-3):
            run = lissom.simulate(lissom.Robot([link], gravity=(0, 0, 0), **more), 0.5, dt=dt)
            assert run.success, run.message
            assert run.doubt is None
    # Between two clamps one mode of bending cannot move.
    held = lissom.Loop("rod", (None, None, (1.0, 0, 0)), lissom.Weld())
    stiff = lissom.Segment(
        1.0, 1e-2, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 1, "bend_z": 1, "stretch": 1}
    )
    robot = lissom.Robot([lissom.Link("rod", rod=[stiff])], loops=[held], loads=[knock], gravity=(0, 0, 0))
    still = lissom.simulate(robot, 0.2, dt=5e-3)
    assert np.abs(still.q).max() < 1e-12
    assert still.doubt is None


@pytest.mark.parametrize("step", [0.01, 0.03])
def test_radau_follows_inputs_in_free_fall(step):
    """The prediction is exact there: corrections are rounding, which does not contract."""
    link = lissom.Link("weight", joint=lissom.Prismatic((0, 0, 1)), body=lissom.Body(1.0))
    load = lissom.Load(force=lissom.Input("force", (0, 0, 0)), link="weight")
    robot = lissom.Robot([link], loads=[load])
    end = 16 * step
    motion = lissom.simulate(
        robot, end, method="radau", control=lambda t, q, v: [0, 0, 2 * t], control_step=step
    )
    assert motion.success, motion.message
    # Held over each step: accelerations 2 k step - g.
    k = np.arange(16)
    speed = (2 * k * step - 9.81).sum() * step
    assert motion.v[-1, 0] == pytest.approx(speed, rel=1e-12)


# Hinges in a row on massless links: at 90 degrees of the second one the first and the third have one axis.
GIMBAL = {"q0": [0.3, 0.5 * np.pi, 0.2], "v0": [0.1, 0.2, 0.3]}


def gimbal():
    body = lissom.Body(1.0, inertia=(0.01, 0.01, 0.01), centre=(0.1, 0, 0))
    hinges = [lissom.Revolute(axis) for axis in ((0, 0, 1), (0, 1, 0), (1, 0, 0))]
    first = lissom.Link("a", joint=hinges[0])
    second = lissom.Link("b", parent="a", joint=hinges[1])
    return lissom.Robot([first, second, lissom.Link("c", parent="b", joint=hinges[2], body=body)])


@pytest.mark.parametrize("method", ["newmark", "hht", "generalised_alpha", "radau", "rk45", "dop853", "auto"])
def test_starts_with_a_singular_mass_end_before_the_first_step(method):
    """Rounding makes factors of such a mass, and finished motions at 1e100 rad/s."""
    robot = gimbal()
    with pytest.raises(lissom.LissomError, match="not positive definite"):
        robot.forward_dynamics(GIMBAL["q0"], GIMBAL["v0"])
    found = lissom.simulate(robot, 0.1, dt=0.01, method=method, **GIMBAL)
    assert (found.success, found.status, found.t.size) == (False, "no_initial_acceleration", 0)
    assert "the mass matrix is singular" in found.message
    assert np.isfinite(lissom.simulate(robot, 0.1, dt=0.01, method=method, q0=[0.3, 0.5, 0.2]).q).all()


def test_simulations_and_ensembles_refuse_singular_masses_as_well():
    run = lissom.Simulation(gimbal(), dt=0.01, **GIMBAL)
    assert run.step() == "no_initial_acceleration"
    assert "the mass matrix is singular" in run.message
    many = lissom.simulate_many(gimbal(), 0.1, dt=0.01, q0=[GIMBAL["q0"], [0.3, 0.5, 0.2]])
    assert list(many.status) == ["no_initial_acceleration", "finished"]


@pytest.mark.parametrize("method", ["newmark", "radau", "dop853", "auto"])
def test_evaluations_show_where_a_run_does_its_work(method):
    ball = lissom.Link(
        "ball", body=lissom.Body(0.1), joint=lissom.Prismatic((0, 0, 1)), position=(0, 0, 0.21)
    )
    floor = lissom.Contact(lissom.Ball("ball", 0.01), lissom.HalfSpace(), stiffness=1e4, name="floor")
    robot = lissom.Robot([ball], contacts=[floor])
    options = {"dt": 2e-3} if method == "newmark" else {}
    times = np.linspace(0.0, 0.3, 61)
    found = simulate(robot, 0.3, method=method, t_eval=times, **options)
    assert found.evaluations.dtype == np.int64
    assert found.evaluations.shape == times.shape
    work = np.diff(found.evaluations)
    assert (work >= 0).all()
    assert 0 < found.evaluations[-1] <= found.stats.nfev
    # It lands at 0.2 s.
    assert work[39:42].max() >= work[5:35].max()
    copied = pickle.loads(pickle.dumps(found))
    assert_array_equal(copied.evaluations, found.evaluations)


def test_evaluations_of_all_steps_add_up_to_those_of_the_run():
    found = simulate(pendulum(), 0.1, method="newmark", dt=1e-2, **START)
    assert len(found.evaluations) == len(found.t) == 11
    assert found.evaluations[-1] == found.stats.nfev
    assert not found.evaluations.flags.writeable
