"""`lissom.newmark`: the family compared with its definition and theory, and robustness to user input."""

import doctest
import inspect
import signal
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import lissom
from reference import newmark as reference

PRESETS = list(reference.PRESETS)
TIGHT = {"rtol": 1e-13, "atol": 1e-13}


def oscillator(t, q, v, a):
    return a + 4.0 * q


def swing(t, q, v, a):
    """The spring pendulum of the lab, undamped, l = m = 1, k = 10."""
    angle, elongation = q
    length = 1.0 + elongation
    return [
        length * (length * a[0] + 2.0 * v[0] * v[1] + 9.81 * np.cos(angle)),
        a[1] - length * v[0] ** 2 + 10.0 * elongation + 9.81 * np.sin(angle),
    ]


def chain(t, q, v, a):
    """Three masses, hardening springs, drag, a time-dependent load, and inertia that depends on q."""
    mass = 1.0 + 0.3 * np.sin(q)
    spring = np.diff(q, prepend=0.0)
    force = 5.0 * spring + 20.0 * spring**3
    return mass * a + 0.3 * v * np.abs(v) + force - np.append(force[1:], np.sin(3.0 * t))


SYSTEMS = {
    "spring pendulum": (swing, [-0.7, 0.5], [0.0, 0.0]),
    "chain": (chain, [0.2, -0.1, 0.3], [0.0, 1.0, -0.5]),
}


def linear(M, C, K):
    return lambda t, q, v, a: M @ a + C @ v + K @ q


def tangents(M, C, K):
    return lambda t, q, v, a: (K, C, M)


def newmark(*args, **options):
    result = lissom.newmark(*args, **options)
    assert result.success, result.message
    return result


def slope(x, y):
    return np.polyfit(np.log(x), np.log(np.abs(y)), 1)[0]


def errors_of_solution(found, residual, rtol, atol):
    """Errors of average acceleration's accelerations relative to exactly solved steps, in tolerances."""
    errors = []
    for i, dt in enumerate(np.diff(found.t)):
        t, q, v, a = found.t[i + 1], found.q[i], found.v[i], found.a[i]

        def end(a1, dt=dt, t=t, q=q, v=v, a=a):
            mean = 0.5 * (a + a1)
            return np.asarray(residual(t, q + dt * v + 0.5 * dt**2 * mean, v + dt * mean, a1))

        exact = reference.root(end, found.a[i + 1])
        tolerated = atol + rtol * np.maximum(np.abs(a), np.abs(exact))
        errors.append(np.sqrt(np.mean(((found.a[i + 1] - exact) / tolerated) ** 2)))
    return np.array(errors)


# ----------------------------------------------------------------------------------------- words and defaults


def test_the_examples_of_the_documentation():
    page = Path(__file__).parents[3] / "docs" / "newmark.md"
    failed, attempted = doctest.testfile(str(page), module_relative=False)
    assert (failed, attempted > 15) == (0, True)
    for documented in (lissom.newmark, lissom.simulate):
        example = doctest.DocTestParser().get_doctest(documented.__doc__, {}, "example", None, None)
        assert example.examples
        assert doctest.DocTestRunner().run(example).failed == 0


def test_defaults():
    result = lissom.newmark(oscillator, (0.0, 1.0), [1.0], [0.0], dt=0.01)
    assert (result.success, result.status) == (True, "finished")
    assert "end of the interval" in result.message
    assert_allclose(result.t, np.linspace(0.0, 1.0, 101), rtol=1e-15)
    assert result.q.shape == result.v.shape == result.a.shape == (101, 1)
    assert {x.dtype for x in (result.t, result.q, result.v, result.a)} == {np.dtype(np.float64)}
    assert_allclose(result.q[:, 0], np.cos(2.0 * result.t), atol=1e-4)
    assert_allclose(result.a, -4.0 * result.q, rtol=1e-6)
    stats = result.stats
    assert (stats.steps, stats.rejected, stats.unsolved) == (100, 0, 0)
    assert stats.nfev == stats.newton_iterations
    assert stats.nfev_jac == stats.njev == stats.nlu == 2
    assert stats.wall_time > 0.0
    assert repr(result).startswith('MotionResult(success=True, status="finished"')
    assert "t=<101 times>, q=<101 x 1>, stats=Statistics(wall_time=" in repr(result)


def test_the_documented_defaults_are_the_real_ones():
    parameters = inspect.signature(lissom.newmark).parameters
    options = {name: p.default for name, p in parameters.items() if p.kind is p.KEYWORD_ONLY}
    assert options.pop("dt") is inspect.Parameter.empty
    assert options == {
        "beta": 0.25,
        "gamma": 0.5,
        "jac": "forward",
        "method": "newmark",
        "alpha": None,
        "rho_inf": None,
        "rtol": 1e-6,
        "atol": None,
        "adaptive": False,
        "max_step": None,
        "min_step": 0.0,
        "max_steps": None,
        "t_eval": None,
        "a0": None,
        "predictor": "best",
        "reuse_jacobian": True,
        "args": None,
        "callback": None,
    }
    with pytest.raises(TypeError):
        lissom.newmark(*SYSTEMS["chain"], 0.01)
    problem = (chain, (0.0, 1.0), *SYSTEMS["chain"][1:])
    plain = newmark(*problem, dt=0.02)
    options = {name: value for name, value in options.items() if value is not None}
    spelled_out = newmark(*problem, dt=0.02, **options)
    assert_array_equal(plain.q, spelled_out.q)
    assert plain.stats.nfev == spelled_out.stats.nfev
    # Every one of these changes the run, which distinguishes the defaults from other values.
    for change in (
        {"beta": 0.3},
        {"gamma": 0.6},
        {"jac": "central"},
        {"method": "hht"},
        {"rtol": 1e-9},
        {"atol": 1e-5},
        {"predictor": "zero"},
        {"reuse_jacobian": False},
        {"adaptive": True},
    ):
        other = newmark(*problem, dt=0.02, **change)
        assert other.stats.nfev + other.stats.nfev_jac != plain.stats.nfev + plain.stats.nfev_jac or (
            not np.array_equal(other.q, plain.q)
        ), change


def test_default_parameters_of_the_alpha_methods():
    problem = (chain, (0.0, 1.0), *SYSTEMS["chain"][1:])
    for method, default in (("hht", {"alpha": -0.1}), ("generalised_alpha", {"rho_inf": 0.8})):
        plain = newmark(*problem, dt=0.02, method=method)
        assert_array_equal(plain.q, newmark(*problem, dt=0.02, method=method, **default).q)
    american = newmark(*problem, dt=0.02, method="generalized_alpha")
    assert_array_equal(plain.q, american.q)


# -------------------------------------------------------------------------------------- against the reference


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("method", PRESETS)
def test_presets_against_the_reference(method, system):
    residual, q0, v0 = SYSTEMS[system]
    found = newmark(residual, (0.5, 1.5), q0, v0, dt=0.05, method=method, **TIGHT)
    expected = reference.integrate(residual, found.t, q0, v0, reference.PRESETS[method])
    for x, y in zip((found.q, found.v, found.a), expected, strict=True):
        assert_allclose(x, y, rtol=1e-7, atol=1e-7)


def test_names_are_their_parameters():
    problem = (swing, (0.0, 1.0), *SYSTEMS["spring pendulum"][1:])
    for method in ("average_acceleration", "linear_acceleration", "fox_goodwin", "central_difference"):
        p = reference.PRESETS[method]
        by_numbers = newmark(*problem, dt=0.02, beta=p.beta, gamma=p.gamma)
        assert_array_equal(newmark(*problem, dt=0.02, method=method).q, by_numbers.q)
    average = newmark(*problem, dt=0.02)
    assert_array_equal(newmark(*problem, dt=0.02, method="hht", alpha=0.0).q, average.q)


@given(beta=st.floats(0.0, 1.0), gamma=st.floats(0.5, 1.5), dt=st.floats(0.01, 0.1))
@settings(max_examples=25)
def test_newmark_of_any_parameters_against_the_reference(beta, gamma, dt):
    residual, q0, v0 = SYSTEMS["chain"]
    # The last step is shorter.
    t_end = 9.5 * dt
    found = newmark(residual, (0.0, t_end), q0, v0, dt=dt, beta=beta, gamma=gamma, **TIGHT)
    assert_allclose(np.diff(found.t), [*[dt] * 9, dt / 2], rtol=1e-9)
    expected = reference.integrate(residual, found.t, q0, v0, reference.Parameters(beta, gamma))
    for x, y in zip((found.q, found.v, found.a), expected, strict=True):
        assert_allclose(x, y, rtol=1e-6, atol=1e-6)


@given(rho_inf=st.floats(0.0, 1.0), alpha=st.floats(-1 / 3, 0.0))
@settings(max_examples=15)
def test_alpha_methods_of_any_parameter_against_the_reference(rho_inf, alpha):
    residual, q0, v0 = SYSTEMS["spring pendulum"]
    for method, option, parameters in (
        ("hht", {"alpha": alpha}, reference.hht(alpha)),
        ("generalised_alpha", {"rho_inf": rho_inf}, reference.generalised_alpha(rho_inf)),
    ):
        found = newmark(residual, (0.0, 0.5), q0, v0, dt=0.05, method=method, **option, **TIGHT)
        expected = reference.integrate(residual, found.t, q0, v0, parameters)
        for x, y in zip((found.q, found.v, found.a), expected, strict=True):
            assert_allclose(x, y, rtol=1e-6, atol=1e-6)


@st.composite
def linear_systems(draw, damped=True):
    """(M, C, K, q0, v0) with frequencies up to some 10 rad/s."""
    n = draw(st.integers(1, 4))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    M, K, C = (x @ x.T for x in random.normal(size=(3, n, n)))
    M += n * np.eye(n)
    # Damping and stiffness need not be symmetric.
    C, K = (0.3 * C + 0.2 * random.normal(size=(n, n)), 5.0 * K) if damped else (0.0 * C, 5.0 * K)
    return M, C, K, random.normal(size=n), random.normal(size=n)


@given(
    system=linear_systems(),
    method=st.sampled_from(PRESETS),
    jac=st.sampled_from(["forward", "central", tangents]),
    dt=st.floats(1e-3, 0.1),
)
def test_linear_systems_against_the_original_methods(system, method, jac, dt):
    *matrices, q0, v0 = system
    jac = jac(*matrices) if callable(jac) else jac
    found = newmark(linear(*matrices), (0.0, 20 * dt), q0, v0, dt=dt, method=method, jac=jac, **TIGHT)
    parameters = reference.PRESETS[method]
    q, v = reference.free_linear_motion(*matrices, q0, v0, dt, 20, parameters)
    scale = 1.0 + np.abs(q).max()
    assert_allclose(found.q, q, atol=1e-9 * scale)
    assert_allclose(found.v, v, atol=1e-8 * scale)
    # The returned accelerations are the true ones, those of the equations of motion.
    M, C, K = matrices
    assert_allclose(M @ found.a.T, -C @ found.v.T - K @ found.q.T, atol=1e-8 * scale)


@given(system=linear_systems(), seed=st.integers(0, 2**32 - 1))
@settings(max_examples=25)
def test_equations_may_be_combined_at_will(system, seed):
    """A r = 0 has the same Newton iterates as r = 0 for every regular matrix A, and the same motion."""
    *matrices, q0, v0 = system
    A = np.random.default_rng(seed).normal(size=matrices[0].shape) + 3.0 * np.eye(q0.size)
    residual = linear(*matrices)
    plain, combined = (
        newmark(r, (0.0, 1.0), q0, v0, dt=0.05)
        for r in (residual, lambda t, q, v, a: A @ residual(t, q, v, a))
    )
    assert_allclose(combined.q, plain.q, atol=1e-6 * (1.0 + np.abs(plain.q).max()))


# ---------------------------------------------------------------------------------------------------- theory


def test_the_table_of_the_documentation():
    """The table contains all presets."""
    page = (Path(__file__).parents[3] / "docs" / "newmark.md").read_text()
    assert all(f'| `"{name}"' in page for name in PRESETS)


@pytest.mark.parametrize("method", PRESETS)
def test_order_two(method):
    residual, q0, v0 = SYSTEMS["spring pendulum"]
    exact = newmark(residual, (0.0, 1.0), q0, v0, dt=2e-4, method="fox_goodwin", **TIGHT)
    steps = 0.02 / 2.0 ** np.arange(4)
    ends = [newmark(residual, (0.0, 1.0), q0, v0, dt=h, method=method, **TIGHT) for h in steps]
    for quantity in ("q", "v", "a"):
        end = getattr(exact, quantity)[-1]
        errors = [np.linalg.norm(getattr(found, quantity)[-1] - end) for found in ends]
        assert slope(steps, errors) == pytest.approx(2.0, abs=0.1), quantity


def test_order_one_where_gamma_is_not_one_half():
    steps = 0.01 / 2.0 ** np.arange(4)
    errors = [
        newmark(oscillator, (0.0, 1.0), [1.0], [0.0], dt=h, beta=0.36, gamma=0.7).q[-1, 0] - np.cos(2.0)
        for h in steps
    ]
    assert slope(steps, errors) == pytest.approx(1.0, abs=0.05)


def test_steps_that_do_not_fill_the_interval_keep_the_order():
    """The alpha methods carry accelerations over from step to step, also into a last step of another size."""
    for method in ("newmark", "hht", "generalised_alpha"):
        steps = 0.03 / 2.0 ** np.arange(4)
        errors = [
            newmark(oscillator, (0.0, 1.0), [1.0], [0.0], dt=h, method=method).q[-1, 0] - np.cos(2.0)
            for h in steps
        ]
        assert slope(steps, errors) == pytest.approx(2.0, abs=0.15), method


@pytest.mark.parametrize("method", PRESETS)
def test_constant_acceleration_is_exact(method):
    found = newmark(lambda t, q, v, a: a + 9.75, (0.0, 12.5), [3.0], [-2.0], dt=0.125, method=method)
    t = found.t[:, None]
    assert_allclose(found.v, -2.0 - 9.75 * t, rtol=1e-13)
    assert_allclose(found.q, 3.0 - 2.0 * t - 4.875 * t**2, rtol=1e-12, atol=1e-12)


@given(
    omega=st.floats(0.01, 100.0),
    zeta=st.floats(0.0, 1.0),
    parameters=st.one_of(
        st.builds(
            lambda beta, gamma: ({"beta": beta, "gamma": gamma}, reference.Parameters(beta, gamma)),
            st.floats(0.0, 1.0),
            st.floats(0.5, 1.5),
        ),
        st.floats(-1 / 3, 0.0).map(lambda alpha: ({"method": "hht", "alpha": alpha}, reference.hht(alpha))),
        st.floats(0.0, 1.0).map(
            lambda rho: (
                {"method": "generalised_alpha", "rho_inf": rho},
                reference.generalised_alpha(rho),
            )
        ),
    ),
)
def test_the_motion_obeys_the_amplification_matrix(omega, zeta, parameters):
    """Cayley-Hamilton: the characteristic polynomial of the matrix annihilates every motion."""
    options, parameters = parameters
    damping, stiffness = 2.0 * zeta * omega, omega**2
    found = newmark(
        lambda t, q, v, a: a + damping * v + stiffness * q,
        (0.0, 8.0),
        [1.0],
        [0.5],
        dt=1.0,
        rtol=1e-14,
        **options,
    )
    polynomial = np.poly(reference.step_matrix(1.0, damping, stiffness, 1.0, parameters))
    windows = np.lib.stride_tricks.sliding_window_view(found.q[:, 0], 4)
    # A displacement is the difference of numbers as large as its acceleration.
    rounding = 1e-13 * (1.0 + np.abs(found.a).max())
    assert np.abs(windows @ polynomial[::-1]).max() < 100.0 * rounding
    assert np.abs(windows).max() > 1e3 * rounding


@pytest.mark.parametrize("rho_inf", [0.0, 0.3, 0.8, 1.0])
def test_infinitely_fast_oscillations_are_multiplied_with_rho_inf(rho_inf):
    """All three eigenvalues are -rho_inf (Chung and Hulbert 1993): (E + rho)^3 q = 0 with the shift E."""
    omega = 1e4
    found = newmark(
        lambda t, q, v, a: a + omega**2 * q,
        (0.0, 8.0),
        [1.0],
        [0.0],
        dt=1.0,
        method="generalised_alpha",
        rho_inf=rho_inf,
        rtol=1e-14,
    )
    windows = np.lib.stride_tricks.sliding_window_view(found.q[:, 0], 4)
    binomial = np.poly([-rho_inf] * 3)
    assert_allclose(windows @ binomial[::-1], 0.0, atol=1e-5)
    radius = np.abs(
        np.linalg.eigvals(
            reference.step_matrix(1.0, 0.0, omega**2, 1.0, reference.generalised_alpha(rho_inf))
        )
    ).max()
    # A triple eigenvalue changes with the third root of the distance from infinity.
    assert radius == pytest.approx(rho_inf, abs=1e-2)


@pytest.mark.parametrize("beta", [1 / 4, 1 / 6, 1 / 12, 0.0])
def test_periods_are_elongated_as_theory_says(beta):
    """By (beta/2 - 1/24) (omega h)^2 (Hughes 1987, section 9.1): a twelfth for average acceleration."""
    h = 0.05
    found = newmark(oscillator, (0.0, 2 * h), [1.0], [0.0], dt=h, beta=beta, **TIGHT)
    start, middle, end = found.q[:, 0]
    angle = np.arccos((start + end) / (2.0 * middle))
    assert 2.0 * h / angle - 1.0 == pytest.approx((beta / 2 - 1 / 24) * (2.0 * h) ** 2, abs=2e-6)


@given(system=linear_systems(damped=False), dt=st.floats(1e-3, 10.0))
def test_average_acceleration_conserves_the_energy_of_linear_systems(system, dt):
    M, C, K, q0, v0 = system
    found = newmark(linear(M, C, K), (0.0, 40 * dt), q0, v0, dt=dt, jac=tangents(M, C, K), **TIGHT)
    energy = 0.5 * np.einsum("ti,ij,tj->t", found.v, M, found.v)
    energy += 0.5 * np.einsum("ti,ij,tj->t", found.q, K, found.q)
    assert_allclose(energy, energy[0], rtol=1e-9)


@pytest.mark.parametrize(
    ("method", "limit"),
    [("central_difference", 2.0), ("fox_goodwin", np.sqrt(6.0)), ("linear_acceleration", np.sqrt(12.0))],
)
def test_stability_limits(method, limit):
    def largest(omega_h):
        found = lissom.newmark(
            lambda t, q, v, a: a + omega_h**2 * q, (0.0, 200.0), [1.0], [0.0], dt=1.0, method=method
        )
        return found.status, np.abs(found.q).max()

    status, below = largest(0.99 * limit)
    assert status == "finished"
    assert below < 1.001
    status, beyond = largest(1.01 * limit)
    assert status == "unstable"
    assert beyond > 1e6


def test_beyond_the_stability_limit_the_failure_says_why():
    with np.errstate(all="ignore"):
        found = lissom.newmark(oscillator, (0.0, 1e4), [1.0], [0.0], dt=1.5, method="central_difference")
    assert (found.success, found.status) == (False, "unstable")
    assert "stable only for step sizes below 2.0000 / (largest natural frequency" in found.message
    assert np.isfinite(found.q).all()
    assert np.abs(found.q).max() > 1e100
    # A growing motion is computed until it overflows.
    assert found.stats.njev < 10
    stable = newmark(oscillator, (0.0, 1e4), [1.0], [0.0], dt=1.5)
    assert np.abs(stable.q).max() < 1.1


# --------------------------------------------------------------------------------------- Jacobians, iteration


@pytest.mark.parametrize("method", ["newmark", "central_difference", "generalised_alpha"])
def test_all_ways_to_solve_a_step_find_the_same_motion(method):
    pendulum = lissom.SpringPendulum()
    problem = (swing, (0.0, 2.0), *SYSTEMS["spring pendulum"][1:])
    exact = newmark(*problem, dt=0.01, method=method, **TIGHT)
    for jac in ("forward", "central", lambda t, q, v, a: pendulum.tangent(q, v, a)):
        for predictor in ("best", "last", "zero"):
            for reuse_jacobian in (True, False):
                found = newmark(
                    *problem,
                    dt=0.01,
                    method=method,
                    jac=jac,
                    predictor=predictor,
                    reuse_jacobian=reuse_jacobian,
                )
                assert np.abs(found.q - exact.q).max() < 1e-6
                stats = found.stats
                per_jacobian = {"forward": 2, "central": 4}.get(jac, 0)
                assert stats.nfev_jac == per_jacobian * stats.njev
                assert stats.nlu == stats.njev
                if not reuse_jacobian:
                    assert stats.njev >= stats.steps


def test_counters_count_calls():
    calls = {"residual": 0, "jac": 0}

    def counted(t, q, v, a):
        calls["residual"] += 1
        return swing(t, q, v, a)

    def jac(t, q, v, a):
        calls["jac"] += 1
        return lissom.SpringPendulum().tangent(q, v, a)

    start = SYSTEMS["spring pendulum"][1:]
    for options in ({}, {"jac": "central"}, {"jac": jac}, {"adaptive": True, "rtol": 1e-3}):
        calls |= {"residual": 0, "jac": 0}
        stats = newmark(counted, (0.0, 1.0), *start, dt=0.01, **options).stats
        assert stats.nfev + stats.nfev_jac == calls["residual"]
        assert calls["jac"] == (stats.njev if "jac" in options and callable(options["jac"]) else 0)


def test_a_linear_system_takes_one_jacobian_and_one_iteration_a_step():
    found = newmark(lambda t, q, v, a: a + 4.0 * q - np.sin(t), (0.0, 10.0), [1.0], [0.0], dt=0.01)
    stats = found.stats
    assert (stats.steps, stats.njev, stats.reuse_failures, stats.full_newton) == (1000, 2, 0, 0)
    # One step in sixteen measures the rate of convergence, as do steps that differ from the previous one.
    assert stats.newton_iterations <= 1130


def test_jacobians_are_kept_while_they_serve():
    problem = (swing, (0.0, 5.0), *SYSTEMS["spring pendulum"][1:])
    kept, fresh = (newmark(*problem, dt=1e-3, reuse_jacobian=reuse).stats for reuse in (True, False))
    assert kept.njev < 0.5 * kept.steps
    assert fresh.njev > fresh.steps
    assert kept.nfev + kept.nfev_jac < fresh.nfev + fresh.nfev_jac


def test_the_ladder_refresh():
    """The mass changes its sign: the old Jacobian makes Newton's method diverge, a new one helps."""

    def residual(t, q, v, a):
        return (1.0 if t < 0.505 else -3.0) * (a + 4.0 * q)

    found = newmark(residual, (0.0, 1.0), [1.0], [0.0], dt=0.01)
    plain = newmark(oscillator, (0.0, 1.0), [1.0], [0.0], dt=0.01)
    assert_allclose(found.q, plain.q, atol=1e-7)
    assert (found.stats.reuse_failures, found.stats.full_newton) == (1, 0)
    assert found.stats.njev == plain.stats.njev + 1


def test_the_ladder_full_newton():
    """arctan(x) = 0, where undamped Newton iterations with reused Jacobians diverge from |x| > 1.39."""

    def residual(t, q, v, a):
        return np.arctan(a - (0.0 if t < 0.5 else 10.0))

    found = newmark(residual, (0.0, 1.0), [0.0], [0.0], dt=0.1, predictor="last")
    assert found.stats.full_newton >= 1
    assert_allclose(found.a[-1], 10.0, rtol=1e-6)
    assert_allclose(found.a[4], 0.0, atol=1e-9)


def test_the_ladder_gives_up():
    """There is no solution: the run ends, with the results so far and a reason."""

    def residual(t, q, v, a):
        return a - 1.0 if t < 0.45 else a**2 + 1.0

    found = lissom.newmark(residual, (0.0, 1.0), [0.0], [0.0], dt=0.1)
    assert (found.success, found.status) == (False, "newton_not_converged")
    assert "did not converge in the step from t = 0.4 (step size 0.1); the result ends there" in found.message
    assert_allclose(found.q[:, 0], 0.5 * found.t**2, atol=1e-12)
    assert found.t[-1] == 0.4
    assert (found.stats.reuse_failures, found.stats.full_newton) == (1, 1)
    assert "jac" not in found.message

    def jac(t, q, v, a):
        none = np.zeros((1, 1))
        return none, none, np.eye(1) if t < 0.45 else 2.0 * np.diag(a) + 0.1

    own = lissom.newmark(residual, (0.0, 1.0), [0.0], [0.0], dt=0.1, jac=jac)
    assert "Check `jac`, too" in own.message


@given(
    factor=st.one_of(st.floats(0.3, 4.0), st.floats(-1.0, -0.1), st.sampled_from([1e-3, 1e3, 1e6])),
    reuse=st.booleans(),
)
def test_a_wrong_jacobian_never_makes_a_wrong_motion(factor, reuse):
    """Slow or failed, but not wrong, because the rate of the iteration is measured."""
    start = SYSTEMS["spring pendulum"][1:]
    pendulum = lissom.SpringPendulum()

    def wrong(t, q, v, a):
        return [factor * part for part in pendulum.tangent(q, v, a)]

    found = lissom.newmark(swing, (0.0, 0.5), *start, dt=0.01, jac=wrong, reuse_jacobian=reuse)
    exact = newmark(swing, (0.0, 0.5), *start, dt=0.01, **TIGHT)
    reached = found.t.size
    assert_allclose(found.q, exact.q[:reached], atol=1e-7)
    if found.success:
        assert reached == 51
    else:
        assert found.status in ("newton_not_converged", "no_initial_acceleration")
        assert not 0.9 < factor < 1.1


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("system", SYSTEMS)
def test_every_step_is_solved_to_the_tolerance(system, rtol):
    residual, q0, v0 = SYSTEMS[system]
    found = newmark(residual, (0.0, 2.0), q0, v0, dt=0.02, rtol=rtol)
    errors = errors_of_solution(found, residual, rtol, 1e-9)
    assert errors.size == 100
    assert np.quantile(errors, 0.9) < 0.3
    assert errors.max() < 1.0


ABRUPT = {
    "soft contact": lambda t, q, v, a: a + 9.81 - 1e3 * np.maximum(0.0, -q),
    "hard contact": lambda t, q, v, a: a + 9.81 - 1e6 * np.maximum(0.0, -q),
    "friction": lambda t, q, v, a: a + 0.5 * np.tanh(50.0 * v) + 4.0 * q - np.sin(2.0 * t),
    "mass doubles": lambda t, q, v, a: (1.0 if t < 0.505 else 2.0) * (a + 4.0 * q),
    "mass halves": lambda t, q, v, a: (1.0 if t < 0.505 else 0.5) * (a + 4.0 * q),
    "mass changes sign": lambda t, q, v, a: (1.0 if t < 0.505 else -3.0) * (a + 4.0 * q),
}


@pytest.mark.parametrize("name", ABRUPT)
def test_steps_are_solved_where_the_jacobian_jumps(name):
    """The convergence of earlier steps says nothing about the iteration there."""
    residual = ABRUPT[name]
    found = newmark(residual, (0.0, 2.0), [0.5], [0.0], dt=2e-3)
    assert errors_of_solution(found, residual, 1e-6, 1e-9).max() < 1.0


@pytest.mark.parametrize("jac", ["forward", "central", "given"])
@pytest.mark.parametrize("stiffness", [1.0, 1e6, 1e13, 1e18])
@pytest.mark.parametrize("atol", [0.0, 1e-9])
def test_the_sizes_of_forces_and_accelerations_need_not_be_known(stiffness, atol, jac):
    """Zero tolerances, or forces larger than the inertia, do not count as singular mass matrices."""
    jac = tangents([[1.0]], [[0.0]], [[stiffness]]) if jac == "given" else jac
    period = stiffness**-0.5

    def residual(t, q, v, a):
        return a + stiffness * q

    found = newmark(residual, (0.0, period), [1.0], [0.0], dt=0.05 * period, atol=atol, jac=jac)
    assert_allclose(found.q[-1], np.cos(1.0), atol=1e-3)
    at_rest = newmark(residual, (0.0, period), [0.0], [0.0], dt=0.05 * period, atol=atol, jac=jac)
    assert_array_equal(at_rest.q, 0.0)


def test_tolerances_of_each_coordinate():
    problem = (swing, (0.0, 1.0), *SYSTEMS["spring pendulum"][1:])
    plain = newmark(*problem, dt=0.01)
    each = newmark(*problem, dt=0.01, rtol=[1e-6, 1e-6], atol=np.full(2, 1e-9))
    assert_array_equal(each.q, plain.q)
    loose = newmark(*problem, dt=0.01, rtol=[1e-2, 1e-2], atol=1e-2)
    assert loose.stats.newton_iterations < plain.stats.newton_iterations
    # A tight tolerance for one of them suffices for more iterations.
    loosest, *tight = (
        newmark(*problem, dt=0.01, rtol=rtol, atol=atol).stats.newton_iterations
        for rtol, atol in (
            ([1e10, 1e10], [1e10, 1e10]),
            ([1e-10, 1e10], [1e-10, 1e10]),
            ([1e10, 1e-10], [1e10, 1e-10]),
        )
    )
    assert min(tight) > 1.5 * loosest


# ----------------------------------------------------------------------------------------------- intervals


def test_intervals():
    assert newmark(oscillator, (2.0, 2.0), [1.0], [0.5], dt=0.1).t.tolist() == [2.0]
    at_start = newmark(oscillator, (2.0, 2.0), [1.0], [0.5], dt=0.1)
    assert (at_start.q.tolist(), at_start.v.tolist()) == ([[1.0]], [[0.5]])
    assert_allclose(at_start.a, [[-4.0]])
    # Rounding causes no extra step; a remainder causes one; the end is hit exactly.
    assert newmark(oscillator, (0.0, 1.1), [1.0], [0.0], dt=0.1).stats.steps == 11
    short = newmark(oscillator, (0.0, 0.25), [1.0], [0.0], dt=0.1)
    assert_allclose(np.diff(short.t), [0.1, 0.1, 0.05])
    assert short.t[-1] == 0.25
    long = newmark(oscillator, (0.0, 0.25), [1.0], [0.0], dt=5.0)
    assert long.t.tolist() == [0.0, 0.25]


def test_an_interval_elsewhere_is_the_same_for_equations_without_time():
    here, there = (newmark(oscillator, (t0, t0 + 2.0), [1.0], [0.0], dt=0.125) for t0 in (0.0, -512.0))
    assert_array_equal(here.q, there.q)
    assert_array_equal(here.t - 512.0, there.t)


def test_nothing_is_evaluated_outside_of_the_interval_and_loads_come_at_their_time():
    times = []

    def residual(t, q, v, a):
        times.append(t)
        return a - t

    # Accelerations that are linear in time are exact for beta = 1/6.
    found = newmark(residual, (1.0, 2.05), [0.0], [0.0], dt=0.1, method="linear_acceleration")
    assert (min(times), max(times)) == (1.0, 2.05)
    t = found.t
    assert_allclose(found.q[:, 0], t**3 / 6 - t / 2 + 1 / 3, atol=1e-12)


def test_output_times():
    problem = (lambda t, q, v, a: a - t, (0.0, 1.0), [0.0], [0.0])
    options = {"dt": 0.25, "method": "linear_acceleration"}
    steps = newmark(*problem, **options)
    times = [0.0, 0.1, 0.25, 0.3, 0.4, 0.75, 1.0]
    found = newmark(*problem, **options, t_eval=times)
    assert found.t.tolist() == times
    assert_allclose(found.q[:, 0], np.array(times) ** 3 / 6, atol=1e-12)
    assert_allclose(found.v[:, 0], np.array(times) ** 2 / 2, atol=1e-12)
    assert_allclose(found.a[:, 0], times, atol=1e-12)
    for i, j in ((0, 0), (2, 1), (5, 3), (6, 4)):
        assert found.q[i, 0] == steps.q[j, 0]
    assert found.stats.steps == 4
    nothing = newmark(*problem, **options, t_eval=[])
    assert (nothing.t.shape, nothing.q.shape) == ((0,), (0, 1))


@given(st.lists(st.floats(0.0, 1.0), unique=True, max_size=10).map(sorted))
@settings(max_examples=20)
def test_output_times_do_not_change_the_motion(times):
    problem = (swing, (0.0, 1.0), *SYSTEMS["spring pendulum"][1:])
    everything = newmark(*problem, dt=0.1, t_eval=np.union1d(times, [0.33, 0.5]))
    some = newmark(*problem, dt=0.1, t_eval=times)
    assert_array_equal(some.q, everything.q[np.isin(everything.t, times)])


def test_the_step_limit():
    found = lissom.newmark(oscillator, (0.0, 1.0), [1.0], [0.0], dt=0.125, max_steps=3)
    assert (found.success, found.status, found.t[-1]) == (False, "too_many_steps", 0.375)
    assert "The limit of 3 steps was reached at t = 0.375" in found.message
    assert "max_steps" in found.message
    assert newmark(oscillator, (0.0, 1.0), [1.0], [0.0], dt=0.125, max_steps=8).t[-1] == 1.0
    assert lissom.newmark(oscillator, (0.0, 1.0), [1.0], [0.0], dt=0.125, max_steps=0).t.tolist() == [0.0]


def test_given_initial_accelerations_are_taken():
    found = newmark(oscillator, (0.0, 0.1), [1.0], [0.0], dt=0.1, a0=[7.0])
    assert found.a[0, 0] == 7.0
    expected = reference.integrate(oscillator, found.t, [1.0], [0.0], reference.Parameters(1 / 4, 1 / 2))
    assert abs(found.q[-1, 0] - expected[0][-1, 0]) > 1e-3
    # Without masses there is no initial acceleration, but steps are possible.
    massless = newmark(lambda t, q, v, a: v + q, (0.0, 1.0), [1.0], [-1.0], dt=0.01, a0=[1.0])
    assert_allclose(massless.q[-1, 0], np.exp(-1.0), atol=1e-4)


def test_reruns_are_equal_bit_by_bit():
    first, second = (newmark(chain, (0.0, 1.0), *SYSTEMS["chain"][1:], dt=0.01) for _ in range(2))
    for x in ("t", "q", "v", "a"):
        assert_array_equal(getattr(first, x), getattr(second, x))


# ----------------------------------------------------------------------------------------------- what goes in


@pytest.mark.parametrize(
    "make",
    [
        np.array,
        list,
        tuple,
        lambda x: np.array(x, dtype=np.float32),
        lambda x: np.array(x, dtype=int),
        lambda x: np.repeat(np.array(x), 2, axis=0)[::2],
        lambda x: np.array(x, dtype=">f8"),
        np.asfortranarray,
    ],
    ids=["array", "list", "tuple", "float32", "int", "strided", "big-endian", "column-major"],
)
def test_any_array_will_do(make):
    """As initial state, tolerance, times, residual, Jacobian; read-only, if possible."""

    def frozen(x):
        x = make(x)
        if isinstance(x, np.ndarray):
            x.flags.writeable = False
        return x

    def residual(t, q, v, a):
        # Integers only, so that all array types can represent them.
        return frozen([float(round(a[0])) + 4.0, float(round(a[1]))])

    def jac(t, q, v, a):
        zero, one = (frozen([[x, 0.0], [0.0, x]]) for x in (0.0, 1.0))
        return zero, zero, one

    found = newmark(
        residual,
        frozen([0, 2]),
        frozen([2, 0]),
        frozen([0, 1]),
        dt=0.5,
        jac=jac,
        a0=frozen([-4, 0]),
        t_eval=frozen([0, 1, 2]),
        atol=frozen([1, 1]),
    )
    assert_array_equal(found.t, [0.0, 1.0, 2.0])
    assert_array_equal(found.q, [[2.0, 0.0], [0.0, 1.0], [-6.0, 2.0]])


def test_one_equation_may_return_a_number():
    for value in (lambda r: r, lambda r: r[0], lambda r: float(r[0]), lambda r: np.array(r[0])):
        found = newmark(lambda t, q, v, a, f=value: f(a + 4.0 * q), (0, 1), [1], [0], dt=0.01)
        assert_allclose(found.q[-1, 0], np.cos(2.0), atol=1e-4)


def test_arguments():
    def residual(t, q, v, a, stiffness, *, load=0.0):
        return a + stiffness * q - load

    def jac(t, q, v, a, stiffness):
        return [[stiffness]], [[0.0]], [[1.0]]

    plain = newmark(oscillator, (0.0, 1.0), [1.0], [0.0], dt=0.1)
    assert_array_equal(newmark(residual, (0, 1), [1], [0], dt=0.1, args=(4.0,)).q, plain.q)
    assert_allclose(newmark(residual, (0, 1), [1], [0], dt=0.1, args=(4.0,), jac=jac).q, plain.q, atol=1e-8)


def test_functions_get_arrays_of_their_own():
    kept = []

    def residual(t, q, v, a):
        assert type(t) is float
        assert all(x.shape == (1,) and x.dtype == np.float64 for x in (q, v, a))
        r = a + 4.0 * q
        kept.append(q)
        q[:] = v[:] = a[:] = np.nan
        return r

    def callback(t, q, v, a):
        q[:] = v[:] = a[:] = np.nan

    found = newmark(residual, (0.0, 1.0), [1.0], [0.0], dt=0.1, callback=callback)
    assert_array_equal(found.q, newmark(oscillator, (0.0, 1.0), [1.0], [0.0], dt=0.1).q)
    assert len({id(x) for x in kept}) == len(kept)


def test_no_coordinates_at_all():
    found = newmark(lambda t, q, v, a: a, (0.0, 1.0), [], [], dt=0.1)
    assert (found.t.size, found.q.shape) == (11, (11, 0))


# ---------------------------------------------------------------------------------------------- invalid input


def refuse(error, message, *args, **options):
    """The call is rejected with this message before anything is evaluated."""

    def never(*_):
        pytest.fail("evaluated")

    given = {"residual": never, "t_span": (0.0, 1.0), "q0": [1.0], "v0": [0.0], "dt": 0.1} | options
    with pytest.raises(error, match=message):
        lissom.newmark(**given)


@pytest.mark.parametrize(
    ("message", "options"),
    [
        (r"t_span\[1\]: got 0, expected at least t_span\[0\] = 1: .* forward in time", {"t_span": (1, 0)}),
        (r"t_span\[1\]: got inf, expected a finite number", {"t_span": (0, np.inf)}),
        (r"t_span\[0\]: got NaN, expected a finite number", {"t_span": (np.nan, 1)}),
        ("v0: expected 1 values, got 2", {"v0": [0.0, 1.0]}),
        (r"q0\[0\]: got inf", {"q0": [np.inf]}),
        (r"v0\[0\]: got NaN", {"v0": [np.nan]}),
        (r"a0\[0\]: got NaN", {"a0": [np.nan]}),
        ("a0: got 2 values, expected 1", {"a0": [0.0, 0.0]}),
        ("dt: got 0, expected a finite number > 0", {"dt": 0.0}),
        ("dt: got -0.1, expected a finite number > 0", {"dt": -0.1}),
        ("dt: got NaN", {"dt": np.nan}),
        ("dt: .* rounding of the time does not swallow", {"dt": 1e-20}),
        ("number of output times: got .*4 GiB .*increase `dt`", {"dt": 1e-12}),
        ("beta: got -0.1, expected a number in .*: below 0 short oscillations grow", {"beta": -0.1}),
        ("beta: got 1.1, ", {"beta": 1.1}),
        ("gamma: got 0.49, expected a number in .* below 0.5 oscillations grow", {"gamma": 0.49}),
        ("gamma: got NaN", {"gamma": np.nan}),
        ("alpha: got 0.1, expected a number in .*stable whatever", {"method": "hht", "alpha": 0.1}),
        ("alpha: got -0.4, ", {"method": "hht", "alpha": -0.4}),
        ("rho_inf: got 1.1, .*spectral radius", {"method": "generalised_alpha", "rho_inf": 1.1}),
        ("rho_inf: got NaN", {"method": "generalised_alpha", "rho_inf": np.nan}),
        (
            'rho_inf: got 0.5, expected nothing: method "hht" has no rho_inf',
            {"method": "hht", "rho_inf": 0.5},
        ),
        ("alpha: .* rho_inf and alpha are parameters of different methods", {"alpha": -0.1, "rho_inf": 0.5}),
        ('beta: .* method "fox_goodwin" has no beta', {"method": "fox_goodwin", "beta": 0.2}),
        ('gamma: .* method "hht" has no gamma', {"method": "hht", "gamma": 0.6}),
        ('method: got "euler", expected one of "newmark", .*"generalised_alpha"$', {"method": "euler"}),
        ("jac: got 'exact', expected 'forward', 'central' or a callable", {"jac": "exact"}),
        ("jac: got 3, expected", {"jac": 3}),
        ('predictor: got "first", expected "best", "last" or "zero"', {"predictor": "first"}),
        ("rtol: got -1, expected a finite number >= 0", {"rtol": -1.0}),
        (r"atol\[0\]: got NaN", {"atol": [np.nan]}),
        ("rtol: got 2 values, expected 1", {"rtol": [1e-3, 1e-3]}),
        ("max_steps: got -1, expected a whole number >= 0", {"max_steps": -1}),
        (
            r"t_eval\[1\]: got 0.2, expected a time from 0 to 1, after the one before",
            {"t_eval": [0.5, 0.2]},
        ),
        (r"t_eval\[1\]: got 0.5", {"t_eval": [0.5, 0.5]}),
        (r"t_eval\[0\]: got -1", {"t_eval": [-1.0]}),
        (r"t_eval\[0\]: got NaN", {"t_eval": [np.nan]}),
        (r"max_step: .*for adaptive steps \(adaptive=True\)", {"max_step": 0.1}),
        (r"min_step: .*for adaptive steps \(adaptive=True\)", {"min_step": 0.1}),
    ],
)
def test_wrong_values_are_refused_with_what_would_be_right(message, options):
    refuse(ValueError, message, **options)


@pytest.mark.parametrize(
    ("message", "options"),
    [
        ("residual: expected a callable, got int", {"residual": 3}),
        ("residual: .*the motion of a Model is for simulate", {"residual": lissom.SpringPendulum()}),
        ("t_span: expected two numbers", {"t_span": 1.0}),
        ("t_span: expected two numbers", {"t_span": (0.0, 1.0, 2.0)}),
        ("q0: expected a one-dimensional array of real numbers", {"q0": 1.0}),
        ("q0: expected a one-dimensional array of real numbers", {"q0": [[1.0]]}),
        ("q0: expected a one-dimensional array of real numbers", {"q0": np.array([1.0 + 2.0j])}),
        ("v0: expected a one-dimensional array of 1 real number, got str", {"v0": "fast"}),
        ("rtol: expected", {"rtol": "small"}),
        ("'args' cannot be unpacked", {"args": 3}),
        ("dt: expected a real number, got str", {"dt": "short"}),
        ("callback: expected a function, got int", {"callback": 3, "residual": oscillator}),
        ("unexpected keyword argument", {"step": 0.1}),
    ],
)
def test_wrong_types_are_refused(message, options):
    refuse(TypeError, message, **options)


@pytest.mark.parametrize(
    "method",
    ["average_acceleration", "linear_acceleration", "central_difference", "hht", "generalised_alpha"],
)
@pytest.mark.parametrize(("name", "default"), [("beta", 0.25), ("gamma", 0.5)])
def test_parameters_of_other_methods_are_refused_even_with_their_defaults(method, name, default):
    refuse(
        ValueError,
        f"{name}: got {default}, expected nothing: .* has no {name}",
        method=method,
        **{name: default},
    )


def test_extreme_numbers_in_messages_are_short():
    refuse(ValueError, "^dt: got -1e-300, expected a finite number > 0", dt=-1e-300)


def test_all_problems_are_reported_at_once():
    refuse(ValueError, r"(?s)v0\[0\]: got NaN.*dt: got -1", v0=[np.nan], dt=-1.0)
    refuse(ValueError, r"(?s)beta: got -1.*gamma: got 0", beta=-1.0, gamma=0.0)


@pytest.mark.parametrize(
    ("value", "error", "message"),
    [
        (None, TypeError, "residual: returned None"),
        ([1.0], ValueError, "residual: expected 2 values, got 1"),
        (np.zeros(3), ValueError, "residual: expected 2 values, got 3"),
        ("ab", TypeError, "value of residual: expected a one-dimensional array of real numbers, got str"),
        (np.zeros((2, 1)), TypeError, r"value of residual: .*shape \(2, 1\)"),
        (np.zeros(2, dtype=complex), TypeError, "value of residual: .*complex128"),
    ],
)
def test_wrong_values_of_the_residual_are_named(value, error, message):
    with pytest.raises(error, match=message):
        lissom.newmark(lambda t, q, v, a: value, (0.0, 1.0), [1.0, 0.0], [0.0, 0.0], dt=0.1)


@pytest.mark.parametrize(
    ("value", "error", "message"),
    [
        (None, TypeError, r"jac: expected three \(1, 1\) arrays, dr/dq, dr/dv, dr/da, got NoneType"),
        (np.eye(1), TypeError, "jac: expected three"),
        (([[1.0]], [[1.0]]), TypeError, "jac: expected three"),
        (
            ([[1.0]], np.eye(2), [[1.0]]),
            ValueError,
            r"jac\[1\], dr/dv: expected shape \(1, 1\), got \(2, 2\)",
        ),
        (([[1.0]], [[1.0]], "mass"), TypeError, r"jac\[2\], dr/da: expected a two-dimensional array"),
    ],
)
def test_wrong_values_of_the_jacobian_are_named(value, error, message):
    with pytest.raises(error, match=message):
        lissom.newmark(oscillator, (0.0, 1.0), [1.0], [0.0], dt=0.1, jac=lambda t, q, v, a: value)


# -------------------------------------------------------------------------------------------------- failures


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_residuals_that_are_not_finite(bad):
    def from_half(t, q, v, a):
        return (a + 4.0 * q) * (1.0 if t < 0.45 else bad)

    found = lissom.newmark(from_half, (0.0, 1.0), [1.0], [0.0], dt=0.1)
    assert (found.success, found.status, found.t[-1]) == (False, "non_finite", 0.4)
    assert "NaN or infinite in the step from t = 0.4" in found.message
    whole = newmark(oscillator, (0.0, 1.0), [1.0], [0.0], dt=0.1)
    assert_array_equal(found.q, whole.q[:5])
    found = lissom.newmark(lambda t, q, v, a: a + bad, (0.0, 1.0), [1.0], [0.0], dt=0.1)
    assert (found.success, found.status, found.t.size) == (False, "no_initial_acceleration", 0)
    assert "NaN or infinite at the initial state" in found.message


@pytest.mark.parametrize("jac", ["forward", "central", "given"])
def test_singular_mass_matrices(jac):
    M = np.array([[1.0, 1.0], [1.0, 1.0]])
    residual = linear(M, np.eye(2), np.eye(2))
    jac = tangents(M, np.eye(2), np.eye(2)) if jac == "given" else jac
    found = lissom.newmark(residual, (0.0, 1.0), [1.0, 2.0], [0.0, 0.0], dt=0.1, jac=jac)
    assert (found.success, found.status, found.t.size) == (False, "no_initial_acceleration", 0)
    if jac != "central":
        # Central differences give a determinant of the size of their error.
        assert "mass matrix" in found.message
        assert "singular" in found.message
        assert "`a0`" in found.message


def test_singular_jacobians_of_a_step():
    """From some time on, the equations do not contain the unknowns."""
    found = lissom.newmark(
        lambda t, q, v, a: a - 1.0 if t < 0.45 else 0.0 * a + 1.0, (0.0, 1.0), [0.0], [0.0], dt=0.1
    )
    assert (found.success, found.status, found.t[-1]) == (False, "singular_jacobian", 0.4)
    assert "do not determine the accelerations" in found.message


class Mishap(Exception):
    pass


@pytest.mark.parametrize("where", ["residual", "jac", "callback"])
def test_exceptions_come_back_unchanged(where):
    mishap = Mishap("here")

    def fail_at(place, t):
        if place == where and t > 0.5:
            raise mishap

    def residual(t, q, v, a):
        fail_at("residual", t)
        return oscillator(t, q, v, a)

    def jac(t, q, v, a):
        fail_at("jac", t)
        return [[4.0]], [[0.0]], [[1.0]]

    def callback(t, q, v, a):
        fail_at("callback", t)

    with pytest.raises(Mishap) as caught:
        lissom.newmark(
            residual, (0, 1), [1], [0], dt=0.1, jac=jac, callback=callback, reuse_jacobian=where != "jac"
        )
    assert caught.value is mishap
    assert "fail_at" in [entry.name for entry in caught.traceback]


def test_system_exit_is_no_numerical_failure():
    with pytest.raises(SystemExit):
        lissom.newmark(lambda t, q, v, a: sys.exit(3), (0, 1), [1], [0], dt=0.1)


@pytest.mark.parametrize("where", ["residual", "callback"])
def test_ctrl_c_keeps_what_was_computed(where):
    def maybe(place, t):
        if place == where and t >= 0.5:
            signal.raise_signal(signal.SIGINT)

    def residual(t, q, v, a):
        maybe("residual", t)
        return oscillator(t, q, v, a)

    with pytest.raises(KeyboardInterrupt) as caught:
        lissom.newmark(
            residual, (0, 10), [1], [0], dt=0.125, callback=lambda t, q, v, a: maybe("callback", t)
        )
    result = caught.value.result
    assert (result.success, result.status) == (False, "interrupted")
    assert result.t[-1] == (0.375 if where == "residual" else 0.5)
    assert_allclose(result.q[:, 0], np.cos(2.0 * result.t), atol=1e-2)


def test_callbacks_see_every_step_and_may_stop():
    seen = []
    found = newmark(
        oscillator, (0, 1), [1], [0], dt=0.125, callback=lambda *state: seen.append(np.hstack(state))
    )
    expected = np.column_stack([found.t, found.q, found.v, found.a])
    assert_array_equal(seen, expected[1:])

    def raise_at_half(t, q, v, a):
        if t >= 0.5:
            raise StopIteration
        return q  # without meaning, like all values but True

    for callback in (raise_at_half, lambda t, q, v, a: t >= 0.5, lambda t, q, v, a: np.float64(t) >= 0.5):
        found = lissom.newmark(oscillator, (0, 1), [1], [0], dt=0.125, callback=callback)
        assert (found.success, found.status, found.t[-1]) == (False, "interrupted", 0.5)
        assert "stopped at t = 0.5, as asked for" in found.message


def test_results_cannot_be_changed_by_accident():
    found = newmark(oscillator, (0, 1), [1], [0], dt=0.1)
    for thing, name in ((found, "t"), (found, "success"), (found.stats, "nfev")):
        with pytest.raises(AttributeError):
            setattr(thing, name, 3)
