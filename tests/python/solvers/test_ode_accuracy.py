"""Tableaus, orders of convergence, tolerances of the methods."""

from fractions import Fraction
from functools import cache

import numpy as np
import pytest
import scipy.integrate
from scipy.linalg import expm

import lissom
from problems.ode import PROBLEMS
from reference import ode as reference

CLASSES = {"rk45": lissom.RK45, "dop853": lissom.DOP853, "radau": lissom.Radau}
METHODS = list(CLASSES)
EXPLICIT = ["rk45", "dop853"]


def scipy_solve_ivp(fun, t_span, y0, method="rk45", **options):
    """SciPy's function with lissom's names of the methods."""
    return scipy.integrate.solve_ivp(fun, t_span, y0, method=CLASSES[method].__name__, **options)


def fixed_steps(problem_fun, t_span, y0, steps, method, **options):
    """Integration with a fixed step: the tolerances accept any error."""
    size = abs(t_span[1] - t_span[0]) / steps
    return lissom.solve_ivp(
        problem_fun, t_span, y0, method, rtol=1.0, atol=1e200, first_step=size, max_step=size, **options
    )


def slope(sizes, errors):
    return np.polyfit(np.log(sizes), np.log(errors), 1)[0]


# ------------------------------------------------------------------------------------------------- tableaus


def test_the_tableau_is_that_of_dormand_and_prince_to_the_last_bit():
    six_rows = np.array(reference.DORMAND_PRINCE_A, dtype=float)[:6, :6]
    np.testing.assert_array_equal(lissom.RK45.A, six_rows)
    np.testing.assert_array_equal(lissom.RK45.B, np.array(reference.DORMAND_PRINCE_B, dtype=float)[:6])
    np.testing.assert_array_equal(lissom.RK45.C, np.array(reference.DORMAND_PRINCE_C, dtype=float)[:6])


@pytest.mark.parametrize(
    ("weights", "order", "conditions"),
    [(reference.DORMAND_PRINCE_B, 5, 17), (reference.DORMAND_PRINCE_B_EMBEDDED, 4, 8)],
)
def test_order_conditions_in_exact_arithmetic(weights, order, conditions):
    trees = [tree for size in range(1, order + 1) for tree in reference.rooted_trees(size)]
    assert len(trees) == conditions
    residuals = [
        reference.order_condition_residual(tree, reference.DORMAND_PRINCE_A, weights) for tree in trees
    ]
    assert residuals == [0] * conditions
    # Sharp: the next order is not reached.
    higher = reference.rooted_trees(order + 1)
    assert any(
        reference.order_condition_residual(tree, reference.DORMAND_PRINCE_A, weights) for tree in higher
    )


def test_row_sums_are_the_times_of_the_stages():
    for row, c in zip(reference.DORMAND_PRINCE_A, reference.DORMAND_PRINCE_C, strict=True):
        assert sum(row) == c
    for solver in (lissom.RK45, lissom.DOP853):
        np.testing.assert_allclose(solver.A.sum(axis=1), solver.C, rtol=1e-14, atol=1e-16)


def test_all_200_order_conditions_of_dop853():
    a, b = lissom.DOP853.A.tolist(), lissom.DOP853.B.tolist()
    trees = [tree for size in range(1, 9) for tree in reference.rooted_trees(size)]
    assert len(trees) == 200
    residuals = [float(reference.order_condition_residual(tree, a, b)) for tree in trees]
    assert np.abs(residuals).max() < 1e-14


# -------------------------------------------------------------------------------------------- polynomials


def power(k):
    return lambda t, y: [t**k]


@pytest.mark.parametrize("h", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("k", range(6))
def test_polynomial_ladder_of_rk45(k, h):
    """One step on y' = t^k is exact up to k = 4 and has the error -h^6/5400 at 5.

    The embedded solution is exact up to 3 and has the error -71 h^5/270000 at 4.
    """
    solver = lissom.RK45(power(k), 0.0, [0.0], h, rtol=1.0, atol=1e200, first_step=h)
    solver.step()
    assert solver.t == h
    exact = h ** (k + 1) / (k + 1)
    expected = exact + {5: -(h**6) / 5400}.get(k, 0.0)
    assert solver.y[0] == pytest.approx(expected, rel=2e-15)
    embedded = solver.y[0] + solver.error_estimate()[0]
    wanted = float(reference.quadrature(reference.DORMAND_PRINCE_B_EMBEDDED, k, Fraction(h)))
    assert embedded == pytest.approx(wanted, rel=2e-15, abs=1e-16)
    if k <= 3:
        assert embedded == pytest.approx(exact, rel=2e-15)
    elif k == 4:
        assert embedded - exact == pytest.approx(-71 / 270000 * h**5, rel=1e-10)


@pytest.mark.parametrize(("method", "degree"), [("rk45", 4), ("dop853", 7), ("radau", 3)])
def test_dense_output_is_exact_for_polynomials_up_to_its_order(method, degree):
    times = np.linspace(0.0, 1.0, 23)
    for k in range(degree + 2):
        result = fixed_steps(power(k), (0.0, 1.0), [0.0], 1, method, dense_output=True)
        error = np.abs(result.sol(times)[0] - times ** (k + 1) / (k + 1)).max()
        # The integral of t^k has degree k + 1.
        assert (error < 1e-14) == (k + 1 <= degree), (k, error)


def test_dense_output_agrees_with_state_and_derivative_at_both_ends():
    problem = reference.pendulum()
    for method in METHODS:
        solver = CLASSES[method](problem.fun, 0.0, problem.y0, 10.0)
        for _ in range(4):
            y_old = solver.y
            solver.step()
            sol = solver.dense_output()
            np.testing.assert_allclose(sol(solver.t_old), y_old, rtol=1e-15, atol=1e-15)
            np.testing.assert_allclose(sol(solver.t), solver.y, rtol=1e-14, atol=1e-15)
            if method == "radau":
                continue  # its polynomial is continuous only
            for t, y in ((solver.t_old, y_old), (solver.t, solver.y)):
                d = 1e-6 * solver.step_size
                derivative = (sol(t + d) - sol(t - d)) / (2 * d)
                np.testing.assert_allclose(derivative, problem.fun(t, y), rtol=1e-7, atol=1e-7)


# -------------------------------------------------------------------------------------- order by regression


def smooth_linear_system():
    """A smooth linear system with three modes; eigenvalues of size up to 3."""
    matrix = np.array(
        [[-0.3, 2.0, 0.0, 0.4], [-2.0, -0.3, 0.5, 0.0], [0.1, 0.0, -1.0, 1.0], [0.0, 0.2, -0.7, 0.1]]
    )
    return matrix, np.array([1.0, -0.5, 0.3, 2.0])


@pytest.mark.parametrize(
    ("method", "order", "steps"),
    [("rk45", 5, [64, 96, 128, 192, 256]), ("dop853", 8, [4, 6, 8, 12]), ("radau", 5, [12, 16, 24, 32, 48])],
)
def test_order_on_a_linear_system(method, order, steps):
    matrix, y0 = smooth_linear_system()
    exact = expm(3.0 * matrix) @ y0
    options = {"jac": matrix} if method == "radau" else {}
    errors = []
    for n in steps:
        result = fixed_steps(lambda t, y: matrix @ y, (0.0, 3.0), y0, n, method, **options)
        assert result.naccepted == n
        errors.append(np.abs(result.y[:, -1] - exact).max())
    assert slope(3.0 / np.array(steps), errors) == pytest.approx(order, abs=0.15)


def test_order_on_the_pendulum():
    problem = reference.pendulum()
    steps = np.array([160, 240, 320, 480, 640])
    exact = problem.exact(problem.t_span[1])
    errors = [
        np.abs(fixed_steps(problem.fun, problem.t_span, problem.y0, n, "rk45").y[:, -1] - exact).max()
        for n in steps
    ]
    assert slope(10.0 / steps, errors) == pytest.approx(5, abs=0.15)


def test_order_of_the_embedded_solution():
    """Local error of order h^5, hence a method of order 4."""
    matrix, y0 = smooth_linear_system()
    sizes = np.array([0.05, 0.07, 0.1, 0.14, 0.2])
    errors = []
    for h in sizes:
        solver = lissom.RK45(lambda t, y: matrix @ y, 0.0, y0, h, rtol=1.0, atol=1e200, first_step=h)
        solver.step()
        embedded = solver.y + solver.error_estimate()
        errors.append(np.abs(embedded - expm(h * matrix) @ y0).max())
    assert slope(sizes, errors) == pytest.approx(5, abs=0.15)


@pytest.mark.parametrize(
    ("method", "order", "largest"), [("rk45", 4, 0.1), ("dop853", 7, 0.4), ("radau", 3, 0.1)]
)
def test_order_of_the_dense_output(method, order, largest):
    """Local error of order h^(order + 1) between the ends of a step."""
    matrix, y0 = smooth_linear_system()
    sizes = largest / np.array([1.0, 2.0, 3.0, 4.0])
    options = {"jac": matrix} if method == "radau" else {}
    errors = []
    for h in sizes:
        result = fixed_steps(lambda t, y: matrix @ y, (0.0, h), y0, 1, method, dense_output=True, **options)
        errors.append(
            max(np.abs(result.sol(x * h) - expm(x * h * matrix) @ y0).max() for x in (0.25, 0.45, 0.7))
        )
    assert slope(sizes, errors) == pytest.approx(order + 1, abs=0.15)


def test_fixed_steps_agree_with_a_plain_integrator():
    problem = reference.rigid_body()
    ours = fixed_steps(problem.fun, problem.t_span, problem.y0, 64, "rk45").y[:, -1]
    theirs = reference.dormand_prince(problem.fun, problem.t_span, problem.y0, 64)
    np.testing.assert_allclose(ours, theirs, rtol=1e-13)


# ----------------------------------------------------------------------------------------------- tolerances


def solution_at(problem, times):
    """States, one per column: exact, or far more accurate than needed."""
    if problem.exact is not None:
        return problem.exact(times)
    options = {"method": "dop853", "rtol": 3e-14, "atol": 1e-14, "t_eval": times}
    return scipy_solve_ivp(problem.fun, problem.t_span, problem.y0, **options).y


@pytest.mark.parametrize(
    ("method", "make", "loosest"),  # where the error begins to follow the tolerance
    [
        ("rk45", reference.rigid_body, 1e-3),
        ("rk45", reference.pendulum, 1e-3),
        ("rk45", reference.pleiades, 1e-4),
        ("rk45", reference.arenstorf, 1e-6),
        ("dop853", reference.rigid_body, 1e-3),
        ("dop853", reference.pendulum, 1e-3),
        ("dop853", reference.pleiades, 1e-4),
        ("dop853", reference.arenstorf, 1e-6),
        ("radau", reference.rigid_body, 1e-3),
        ("radau", reference.pendulum, 1e-3),
    ],
)
def test_the_error_is_proportional_to_the_tolerance(method, make, loosest):
    problem = make()
    times = np.linspace(*problem.t_span, 21)
    exact = solution_at(problem, times)
    tightest = 1e-8 if method == "radau" else 1e-11
    tolerances = 10.0 ** np.arange(np.log10(loosest), np.log10(tightest) - 0.5, -1.0)
    errors = []
    for tolerance in tolerances:
        options = {"method": method, "t_eval": times, "rtol": tolerance, "atol": tolerance}
        result = lissom.solve_ivp(problem.fun, problem.t_span, problem.y0, **options)
        assert result.success
        errors.append(np.abs(result.y - exact).max())
    # Radau's estimate is of order 3, its solution of order 5: the error decreases as the tolerance^(5/4).
    exponent = 1.25 if method == "radau" else 1.0
    decades = np.log10(errors) - exponent * np.log10(tolerances)
    assert slope(tolerances, errors) == pytest.approx(exponent, abs=0.2)
    assert np.abs(decades - np.median(decades)).max() < 1.0


def test_the_arenstorf_orbit_is_periodic():
    problem = reference.arenstorf()
    options = {"method": "dop853", "rtol": 1e-12, "atol": 1e-12}
    result = lissom.solve_ivp(problem.fun, problem.t_span, problem.y0, **options)
    np.testing.assert_allclose(result.y[:, -1], problem.y0, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_stiff_problems(tolerance):
    for make, jac in [
        (reference.van_der_pol, reference.van_der_pol_jacobian),
        (reference.robertson, reference.robertson_jacobian),
    ]:
        problem = make()
        exact = lissom.solve_ivp(
            problem.fun, problem.t_span, problem.y0, "radau", jac=jac, rtol=1e-12, atol=1e-14
        ).y[:, -1]
        for given in (None, jac):
            result = lissom.solve_ivp(
                problem.fun,
                problem.t_span,
                problem.y0,
                "radau",
                jac=given,
                rtol=tolerance,
                atol=1e-3 * tolerance,
            )
            assert result.success
            assert result.nfev < 50_000
            scale = 1e-3 + np.abs(exact)
            assert (np.abs(result.y[:, -1] - exact) / scale).max() < 30 * tolerance


def test_the_reference_of_the_stiff_problems_is_that_of_scipy():
    problem = reference.robertson()
    options = {"method": "radau", "rtol": 1e-10, "atol": 1e-13, "jac": reference.robertson_jacobian}
    ours = lissom.solve_ivp(problem.fun, problem.t_span, problem.y0, **options).y[:, -1]
    theirs = scipy_solve_ivp(problem.fun, problem.t_span, problem.y0, **options).y[:, -1]
    np.testing.assert_allclose(ours, theirs, rtol=1e-8)


# ------------------------------------------------------------------------------------ SciPy's step sequence

STEP_PROBLEMS = [reference.pendulum, reference.rigid_body, reference.spring_pendulum, reference.pleiades]


@pytest.mark.parametrize("make", [reference.pendulum, reference.rigid_body, reference.spring_pendulum])
def test_the_steps_of_rk45_are_those_of_scipy(make):
    problem = make()
    for t_span in (problem.t_span, problem.t_span[::-1]):
        theirs = scipy_solve_ivp(problem.fun, t_span, problem.y0)
        # A step of the right size: see the next test.
        first_step = np.abs(np.diff(theirs.t)).max() / 8
        theirs = scipy_solve_ivp(problem.fun, t_span, problem.y0, first_step=first_step)
        ours = lissom.solve_ivp(problem.fun, t_span, problem.y0, first_step=first_step)
        assert ours.nfev == theirs.nfev
        np.testing.assert_allclose(ours.t, theirs.t, rtol=0.0, atol=1e-12 * np.ptp(t_span))
        np.testing.assert_allclose(ours.y, theirs.y, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("make", STEP_PROBLEMS)
@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("rtol", [1e-3, 1e-5, 1e-7])
def test_the_steps_are_those_of_scipy_up_to_rounding(make, method, rtol):
    """Error estimates are differences with cancellation, the more so the smaller the estimate.

    A change in the last bit of SciPy's right-hand side shows the resulting change of step sizes.
    """
    problem = make()
    random = np.random.default_rng(1)

    def last_bit_changed(t, y):
        return np.nextafter(problem.fun(t, y), random.choice([-np.inf, np.inf], y.size))

    for t_span in (problem.t_span, problem.t_span[::-1]):
        options = {"method": method, "rtol": rtol, "atol": 1e-3 * rtol}
        ours = lissom.solve_ivp(problem.fun, t_span, problem.y0, **options)
        theirs = scipy_solve_ivp(problem.fun, t_span, problem.y0, **options)
        changed = [scipy_solve_ivp(last_bit_changed, t_span, problem.y0, **options) for _ in range(3)]
        assert ours.nfev == theirs.nfev
        assert ours.t.shape == theirs.t.shape
        assert ours.t[1] - t_span[0] == pytest.approx(theirs.t[1] - t_span[0], rel=1e-12)
        rounding = max(np.abs(result.t - theirs.t).max() for result in changed)
        np.testing.assert_allclose(ours.t, theirs.t, rtol=0.0, atol=30 * rounding + 1e-13 * np.ptp(t_span))


def test_the_steps_of_radau_are_close_to_those_of_scipy():
    """Not identical: lissom follows Hairer and Wanner in some details where SciPy does not."""
    for make in (reference.van_der_pol, reference.robertson):
        problem = make()
        options = {"method": "radau", "rtol": 1e-6, "atol": 1e-9}
        ours = lissom.solve_ivp(problem.fun, problem.t_span, problem.y0, **options)
        theirs = scipy_solve_ivp(problem.fun, problem.t_span, problem.y0, **options)
        assert ours.success
        assert ours.nfev <= 1.1 * theirs.nfev
        assert ours.njev <= 1.3 * theirs.njev
        assert ours.nlu <= 1.3 * theirs.nlu


# ---------------------------------------------------------------------------- accuracy and cost beside SciPy

POINTS = 21


@cache
def exact_solution(number):
    """States of a problem at equal distances in time, far more accurate than needed."""
    problem = PROBLEMS[number]
    times = np.linspace(*problem.t_span, POINTS)
    # Not by lissom; the relay's jumps cost any method many small steps.
    options = {"method": "dop853", "rtol": 1e-12, "atol": 1e-14, "t_eval": times}
    return scipy_solve_ivp(problem.fun, problem.t_span, problem.y0, **options).y


def errors_and_costs(solve, method, rtol):
    """Largest error and number of evaluations for every problem."""
    found = []
    for number, problem in enumerate(PROBLEMS):
        times = np.linspace(*problem.t_span, POINTS)
        options = {"method": method, "rtol": rtol, "atol": 1e-3 * rtol, "t_eval": times}
        result = solve(problem.fun, problem.t_span, problem.y0, **options)
        assert result.success, problem.name
        # Without those of Jacobians, which SciPy does not count.
        found.append((np.abs(result.y - exact_solution(number)).max(), result.nfev))
    return np.array(found).T


@pytest.mark.parametrize(
    ("method", "tolerances"),
    [("rk45", [1e-3, 1e-4, 1e-5]), ("dop853", [1e-3, 1e-5, 1e-7, 1e-9]), ("radau", [1e-3])],
)
def test_accuracy_and_cost_are_those_of_scipy(method, tolerances):
    """At equal tolerances, over the problems of DETEST and others.

    At loose tolerances the error of a single problem depends on luck: the last
    bit of the right-hand side changes it by factors of two, for SciPy as well.
    """
    ratios = []
    for rtol in tolerances:
        ours, theirs = (
            errors_and_costs(solve, method, rtol) for solve in (lissom.solve_ivp, scipy_solve_ivp)
        )
        ratios.append(ours / theirs)
    error, cost = np.exp(np.log(ratios).mean(axis=(0, 2)))
    assert error < 1.1
    assert cost < 1.02
