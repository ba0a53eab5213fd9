"""Adaptive steps of `lissom.newmark`: the estimate of Zienkiewicz and Xie, and its blind spots."""

from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import lissom
from reference import newmark as reference

# The documented constants of the step control.
SMALLEST_VELOCITY_COEFFICIENT = 0.01
BLIND = 0.01
LARGEST_FACTOR = 5.0

SEEING = ["newmark", "fox_goodwin", "central_difference", "hht", "generalised_alpha"]


def oscillator(omega, zeta=0.0):
    return lambda t, q, v, a: a + 2.0 * zeta * omega * v + omega**2 * q


def swing(t, q, v, a):
    angle, elongation = q
    length = 1.0 + elongation
    return [
        length * (length * a[0] + 2.0 * v[0] * v[1] + 9.81 * np.cos(angle)),
        a[1] - length * v[0] ** 2 + 10.0 * elongation + 9.81 * np.sin(angle),
    ]


def adaptive(*args, **options):
    result = lissom.newmark(*args, **({"dt": 0.1} | options), adaptive=True)
    assert result.success, result.message
    return result


def slope(x, y):
    return np.polyfit(np.log(x), np.log(y), 1)[0]


def test_defaults():
    """The default scheme and tolerances, with `adaptive` only."""
    found = adaptive(oscillator(2.0), (0.0, 3.0), [1.0], [0.0])
    assert found.t[-1] == 3.0
    assert found.stats.steps == found.t.size - 1
    assert np.ptp(np.diff(found.t)) > 0.0
    assert_allclose(found.q[:, 0], np.cos(2.0 * found.t), atol=1e-3)


@pytest.mark.parametrize("method", SEEING)
def test_errors_follow_the_tolerance(method):
    exact = lissom.newmark(
        swing, (0.0, 2.0), [-0.7, 0.5], [0.0, 0.0], dt=1e-4, method="fox_goodwin", rtol=1e-12, atol=1e-12
    )
    tolerances = 10.0 ** -np.arange(3.0, 7.0)
    errors, steps = [], []
    for tolerance in tolerances:
        found = adaptive(
            swing, (0.0, 2.0), [-0.7, 0.5], [0.0, 0.0], method=method, rtol=tolerance, atol=tolerance
        )
        errors.append(np.abs(found.q[-1] - exact.q[-1]).max())
        steps.append(found.stats.steps)
        assert errors[-1] <= 10.0 * found.stats.steps * tolerance
    assert np.all(np.diff(errors) < 0.0)
    # Order 2: local errors of order 3 stay below the tolerance.
    assert slope(steps, errors) == pytest.approx(-2.0, abs=0.3)
    # h ~ tolerance^(1/3) for the displacements' estimate, ^(1/2) for the velocities' smallest coefficient.
    assert -0.52 < slope(tolerances, steps) < -0.32


@given(
    rtol=st.sampled_from([0.0, 1e-3, 1e-5]),
    atol=st.sampled_from([1e-3, 1e-5]),
    beta=st.one_of(st.floats(0.0, 1 / 6 - 0.02), st.floats(1 / 6 + 0.02, 0.5)),
    gamma=st.sampled_from([0.5, 0.504, 0.6, 1.0]),
    dt=st.floats(1e-3, 1.0),
)
def test_accepted_steps_have_small_estimates(rtol, atol, beta, gamma, dt):
    """The estimate of the reference, from the returned states, for every accepted step."""
    found = adaptive(
        swing, (0.0, 0.5), [-0.7, 0.5], [0.0, 0.0], dt=dt, rtol=rtol, atol=atol, beta=beta, gamma=gamma
    )
    errors = reference.estimated_error(found, beta, gamma, rtol, atol, SMALLEST_VELOCITY_COEFFICIENT)
    assert errors.max() <= 1.0 + 1e-6
    h = np.diff(found.t)
    # The last step may be any remainder.
    assert np.all(h[1:-1] <= LARGEST_FACTOR * h[:-2] * (1.0 + 1e-9))
    # Steps are not much smaller than necessary, once their size has settled.
    settled = errors[3:-1]
    if settled.size > 10:
        assert np.median(settled) > 0.05


@pytest.mark.parametrize(
    "options",
    [
        *({"alpha": alpha} for alpha in (-0.05, -0.1, -0.3)),
        *({"rho_inf": rho_inf} for rho_inf in (0.0, 0.5, 0.8)),
        {"beta": 0.3, "gamma": 0.6},
    ],
    ids=str,
)
def test_the_estimate_of_a_first_step_is_what_the_method_makes_wrong(options):
    """Against linear acceleration; the estimate decides at which tolerance the step is taken."""
    name, parameters = "newmark", reference.Parameters(0.3, 0.6)
    if "alpha" in options:
        name, parameters = "hht", reference.hht(options["alpha"])
    elif "rho_inf" in options:
        name, parameters = "generalised_alpha", reference.generalised_alpha(options["rho_inf"])
    h, residual = 0.2, oscillator(2.0)
    q, v, a = (x[:, 0] for x in reference.integrate(residual, [0.0, h], [1.0], [0.5], parameters))
    of_displacement = q[1] - q[0] - h * v[0] - h**2 * (2 * a[0] + a[1]) / 6
    # To leading order, and the rest: in a first step algorithmic accelerations are not ahead of true ones.
    p = parameters
    shift = p.alpha_m - p.alpha_f
    of_memory = v[1] - v[0] - h * (a[0] + a[1]) / 2 - h * (p.gamma + shift - 0.5) * (a[1] - a[0])
    coefficient = max(abs(p.gamma + shift - 0.5), SMALLEST_VELOCITY_COEFFICIENT)
    of_velocity = h * coefficient * abs(a[1] - a[0]) + abs(of_memory)
    estimate = np.sqrt((of_displacement**2 + of_velocity**2) / 2)
    for factor, rejects in ((1.0001, False), (0.9999, True)):
        found = adaptive(
            residual, (0.0, h), [1.0], [0.5], dt=h, method=name, rtol=0.0, atol=factor * estimate, **options
        )
        assert (found.stats.rejected > 0) == rejects


def test_rejected_steps_are_counted_and_not_returned():
    found = adaptive(oscillator(10.0), (0.0, 1.0), [1.0], [0.0], dt=1.0, rtol=1e-4, atol=1e-4)
    assert found.stats.rejected > 0
    assert found.stats.unsolved == 0
    assert found.stats.steps == found.t.size - 1
    assert found.t[1] < 0.1
    assert_allclose(found.q[:, 0], np.cos(10.0 * found.t), atol=0.02)


def test_tolerances_of_each_coordinate():
    """Two uncoupled oscillations: the one with a loose tolerance does not require steps."""

    def both(t, q, v, a):
        return [a[0] + q[0], a[1] + 400.0 * q[1]]

    start = ((0.0, 3.0), [1.0, 1.0], [0.0, 0.0])
    strict = adaptive(both, *start, rtol=1e-5, atol=1e-5)
    lenient = adaptive(both, *start, rtol=[1e-5, 1e3], atol=[1e-5, 1e3])
    assert lenient.stats.steps < 0.2 * strict.stats.steps
    assert_allclose(lenient.q[-1, 0], np.cos(3.0), atol=1e-3)


# --------------------------------------------------------------------------------------------- blind spots


@pytest.mark.parametrize(
    "options",
    [
        {"method": "linear_acceleration"},
        {"beta": 1 / 6},
        {"beta": 1 / 6 + 0.009},
        {"beta": 1 / 6 - 0.009, "gamma": 0.509},
    ],
)
def test_schemes_whose_errors_the_estimate_does_not_see_are_refused(options):
    def never(*_):
        pytest.fail("evaluated")

    with pytest.raises(ValueError, match=r"adaptive: got beta = 0\.1") as refused:
        lissom.newmark(never, (0.0, 1.0), [1.0], [0.0], dt=0.1, adaptive=True, **options)
    message = str(refused.value)
    assert "a beta at least 0.01 away from 0.1667 or a gamma at least 0.01 away from 0.5000" in message
    assert "blind" in message
    assert "fixed steps" in message


@pytest.mark.parametrize(
    "options", [{"beta": 1 / 6 + 0.011}, {"beta": 1 / 6 - 0.011}, {"beta": 1 / 6, "gamma": 0.511}]
)
def test_schemes_outside_of_the_blind_band_are_taken(options):
    found = adaptive(oscillator(1.0), (0.0, 1.0), [1.0], [0.0], rtol=1e-4, atol=1e-4, **options)
    assert_allclose(found.q[-1, 0], np.cos(1.0), atol=5e-3)


@pytest.mark.parametrize("method", SEEING)
def test_a_fast_oscillation_is_not_lost(method):
    """Its displacements are small and the estimate for the velocity vanishes for order 2."""
    omega = 1000.0
    found = adaptive(
        oscillator(omega), (0.0, 0.05), [0.0], [1.0], dt=0.05, rtol=1e-5, atol=1e-5, method=method
    )
    assert np.abs(found.v[:, 0] - np.cos(omega * found.t)).max() < 0.1


def test_an_estimate_of_zero_does_not_let_the_step_grow():
    """Constant accelerations are exact for any step; the subsequent motion may not be."""
    found = adaptive(lambda t, q, v, a: a + 9.75, (0.0, 10.0), [0.0], [0.0], dt=0.125)
    assert_array_equal(np.diff(found.t), 0.125)


def test_a_knock_after_a_rest_is_not_jumped_over():
    def knock(t, q, v, a):
        return a - (100.0 * np.sin(np.pi * (t - 5.0) / 0.4) ** 2 if 5.0 < t < 5.4 else 0.0)

    found = adaptive(knock, (0.0, 10.0), [0.0], [0.0], dt=0.125, rtol=1e-4, atol=1e-4)
    assert_array_equal(np.diff(found.t)[:39], 0.125)
    assert_allclose(found.v[-1, 0], 20.0, rtol=1e-3)


def test_nothing_to_tolerate_and_no_error_is_no_error():
    """0 / 0: a coordinate at rest with zero tolerance."""
    found = adaptive(
        lambda t, q, v, a: [a[0] + q[0], a[1] + q[1]],
        (0.0, 1.0),
        [1.0, 0.0],
        [1.0, 0.0],
        dt=0.01,
        rtol=1e-4,
        atol=[1e-4, 0.0],
    )
    assert_array_equal(found.q[:, 1], 0.0)
    assert_allclose(found.q[-1, 0], np.cos(1.0) + np.sin(1.0), atol=1e-3)


# -------------------------------------------------------------------------------------------------- limits


def test_largest_and_smallest_steps():
    run = partial(lissom.newmark, oscillator(3.0), (0.0, 2.0), [1.0], [0.0], adaptive=True)
    bounded = run(dt=1.0, max_step=0.05, rtol=0.1, atol=0.1)
    assert bounded.success
    assert np.diff(bounded.t).max() <= 0.05 * (1.0 + 1e-9)
    assert run(dt=1.0, max_step=np.inf, rtol=0.1, atol=0.1).stats.steps < bounded.stats.steps
    stopped = run(dt=1.0, min_step=0.01, rtol=1e-8, atol=1e-8)
    assert (stopped.success, stopped.status) == (False, "step_too_small")
    assert "fell below its limit at t = 0 after" in stopped.message
    assert "reduce `min_step`" in stopped.message
    assert stopped.t.tolist() == [0.0]
    longer = run(dt=1e-6, min_step=0.01, rtol=10.0, atol=10.0)
    assert longer.success
    assert np.diff(longer.t)[:-1].min() >= 0.01 * (1 - 1e-9)
    # The remainder of an interval may be shorter than the smallest step.
    rest = run(dt=0.7, min_step=0.7, max_step=0.7, rtol=10.0, atol=10.0)
    assert_allclose(np.diff(rest.t), [0.7, 0.7, 0.6])


@pytest.mark.parametrize(
    ("message", "options"),
    [
        ("min_step: got 0.2, expected at most max_step = 0.1", {"min_step": 0.2, "max_step": 0.1}),
        ("max_step: got 0, expected a number > 0", {"max_step": 0.0}),
        ("max_step: got NaN", {"max_step": np.nan}),
        ("min_step: got -1, expected a finite number >= 0", {"min_step": -1.0}),
    ],
)
def test_wrong_limits_are_refused(message, options):
    with pytest.raises(ValueError, match=message):
        adaptive(oscillator(1.0), (0.0, 1.0), [1.0], [0.0], **options)


def test_the_step_limit_counts_accepted_steps():
    found = lissom.newmark(oscillator(5.0), (0.0, 9.0), [1.0], [0.0], dt=1.0, adaptive=True, max_steps=7)
    assert (found.status, found.stats.steps, found.t.size) == ("too_many_steps", 7, 8)
    assert found.stats.rejected > 0


@given(st.lists(st.floats(0.0, 2.0), unique=True, min_size=1, max_size=8).map(sorted))
@settings(max_examples=20)
def test_output_times_do_not_change_the_steps(times):
    run = partial(adaptive, oscillator(3.0), (0.0, 2.0), [1.0], [0.0], rtol=1e-5, atol=1e-5)
    steps, found = run(), run(t_eval=times)
    assert found.stats.nfev == steps.stats.nfev
    assert_allclose(found.q[:, 0], np.cos(3.0 * np.array(times)), atol=5e-3)
    common = np.isin(times, steps.t)
    assert_array_equal(found.q[common], steps.q[np.isin(steps.t, times)])


# ----------------------------------------------------------------------------------------- unsolved steps


def test_a_step_that_cannot_be_solved_is_cut():
    """There is no solution beyond q = 1.5, where long steps search for it."""

    def walled(t, q, v, a):
        return a + 4.0 * q if q[0] < 1.5 else [np.nan]

    found = adaptive(walled, (0.0, 3.0), [0.0], [2.9], dt=1.0, rtol=1e-4, atol=1e-4)
    assert found.stats.unsolved > 0
    assert_allclose(found.q[:, 0], 1.45 * np.sin(2.0 * found.t), atol=0.05)


def test_equations_without_a_solution_end_the_run_where_they_begin():
    def residual(t, q, v, a):
        return a - 1.0 if t < 0.35 else a**2 + 1.0

    found = lissom.newmark(residual, (0.0, 1.0), [0.0], [0.0], dt=0.1, adaptive=True)
    assert (found.success, found.status) == (False, "step_too_small")
    assert "unsolved steps" in found.message
    assert found.t[-1] == pytest.approx(0.35, abs=1e-9)
    assert found.stats.unsolved >= found.stats.full_newton > 0
    assert_allclose(found.q[:, 0], 0.5 * found.t**2, atol=1e-12)


def test_an_unsolved_step_of_fixed_size_is_not_cut_but_ends_the_run():
    def walled(t, q, v, a):
        return a + 4.0 * q if q[0] < 1.5 else [np.nan]

    found = lissom.newmark(walled, (0.0, 3.0), [0.0], [4.0], dt=0.1)
    assert (found.success, found.status, found.stats.unsolved) == (False, "non_finite", 0)
    assert "adaptive" in found.message
    assert found.q.max() < 1.5


@given(factor=st.sampled_from([1e-6, 0.3, 1.5, 3.0, 100.0]))
@settings(max_examples=5)
def test_a_wrong_jacobian_never_makes_a_wrong_motion(factor):
    pendulum = lissom.SpringPendulum()
    start = ((0.0, 0.5), [-0.7, 0.5], [0.0, 0.0])
    found = lissom.newmark(
        swing,
        *start,
        dt=0.1,
        a0=pendulum.forward_dynamics(*start[1:]),
        adaptive=True,
        rtol=1e-4,
        atol=1e-4,
        jac=lambda t, q, v, a: [factor * part for part in pendulum.tangent(q, v, a)],
    )
    exact = lissom.newmark(swing, *start, dt=1e-3, t_eval=found.t)
    assert np.abs(found.q - exact.q[: found.t.size]).max() <= 10.0 * found.stats.steps * 1e-4
    assert found.success or found.status == "step_too_small"


def test_the_alpha_methods_keep_their_order_as_steps_change():
    """A motion whose time scale changes by a factor of 20."""

    def stiffening(t, q, v, a):
        return a + (1.0 + 400.0 * np.exp(-((t - 1.0) ** 2) / 0.02)) * q

    exact = lissom.newmark(stiffening, (0.0, 2.0), [1.0], [0.0], dt=2e-5, method="fox_goodwin", t_eval=[2.0])
    for method in ("hht", "generalised_alpha"):
        steps, errors = [], []
        for tolerance in (1e-4, 1e-5, 1e-6):
            found = adaptive(
                stiffening, (0.0, 2.0), [1.0], [0.0], rtol=tolerance, atol=tolerance, method=method, dt=0.01
            )
            h = np.diff(found.t)[:-1]
            assert h.max() > 3.0 * h.min()
            steps.append(found.stats.steps)
            errors.append(abs(found.q[-1, 0] - exact.q[-1, 0]))
        assert slope(steps, errors) == pytest.approx(-2.0, abs=0.4), method
