"""Root finding: `root`, `jacobian`, `check_jacobian`."""

import functools
import inspect
import signal
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal

import lissom
import reference.roots as reference
from problems.roots import PROBLEMS

EPS = np.finfo(float).eps
METHODS = ("newton", "line_search", "trust_region")


def lab(x):
    """The lab's f = (x^2 - 2x + 1/2)^2: double roots at 1 -+ sqrt(1/2), a maximum at 1."""
    return x**4 - 4 * x**3 + 5 * x**2 - 2 * x + 0.25


def lab_slope(x):
    return 4 * x**3 - 12 * x**2 + 10 * x - 2


def circle_and_hyperbola(x):
    return np.array([x[0] ** 2 + x[1] ** 2 - 4, x[0] * x[1] - 1])


def circle_and_hyperbola_jac(x):
    return np.array([[2 * x[0], 2 * x[1]], [x[1], x[0]]])


ROOT = np.array([2 * np.cos(np.pi / 12), 2 * np.sin(np.pi / 12)])

coordinates = st.floats(-10, 10, allow_nan=False)
well_conditioned = arrays(float, (3, 3), elements=st.floats(-1, 1)).map(lambda a: a + 4 * np.eye(3))


# The lab


@pytest.mark.parametrize("jac", [lab_slope, "forward", "central"], ids=["analytic", "forward", "central"])
@pytest.mark.parametrize("method", METHODS)
def test_the_labs_stationary_point_is_named_and_never_a_success(jac, method):
    result = lissom.root(lab, 1.0, jac=jac, method=method)
    assert (result.status, result.success, result.x) == ("stationary_point", False, 1.0)
    assert result.nfev <= 4
    assert "not a root" in result.message


@pytest.mark.parametrize("jac", [lab_slope, "forward", "central"], ids=["analytic", "forward", "central"])
@pytest.mark.parametrize(("x0", "root"), [(6, 1 + np.sqrt(0.5)), (0.7, 1 - np.sqrt(0.5))])
def test_the_labs_double_roots_are_recognised_and_stepped_over(jac, x0, root):
    plain = lissom.root(lab, x0, jac=jac)
    assert plain.success
    assert plain.multiplicity == 2
    assert "multiplicity 2" in plain.message
    accelerated = lissom.root(lab, x0, jac=jac, accelerate=True)
    assert accelerated.success
    assert accelerated.multiplicity == 2
    assert accelerated.nit <= 6
    assert 2 * accelerated.nit <= plain.nit
    assert_allclose([plain.x, accelerated.x], root, atol=1e-3)


def test_the_labs_shifted_function_starts_on_a_root():
    result = lissom.root(lambda x: lab(x) - 0.25, 1.0)
    assert (result.status, result.nfev, result.nit) == ("already_root", 1, 0)


@pytest.mark.parametrize("multiplicity", [2, 3, 5])
def test_multiplicities_are_estimated(multiplicity):
    result = lissom.root(lambda x: (x - 1) ** multiplicity * (x + 2), 3.0, tol=1e-10)
    assert result.multiplicity == multiplicity
    assert lissom.root(lambda x: (x - 1) * (x + 2), 3.0, tol=1e-10).multiplicity is None


def test_a_singular_root_in_several_dimensions_is_recognised():
    singular = PROBLEMS[1]
    result = lissom.root(singular.fun, singular.standard_start, jac=singular.jac, tol=1e-12)
    assert result.multiplicity == 2
    assert lissom.root(circle_and_hyperbola, [3, 1]).multiplicity is None


# Comparison with the reference, and invariances of Newton's method


# Without runs through Jacobians so ill-conditioned that rounding determines the path. Long runs are also
# chaotic, so only their beginnings are compared.
TAME = [p for p in PROBLEMS if p.name not in {"Generalized Rosenbrock", "Chebyquad", "Brown almost linear"}]
COMPARED = 20


@pytest.mark.parametrize("problem", TAME, ids=lambda problem: problem.name)
def test_iterates_agree_with_the_reference(problem):
    start = problem.standard_start
    expected = reference.newton(problem.fun, problem.jac, start, max_iter=COMPARED)
    result = lissom.root(problem.fun, start, jac=problem.jac, max_iter=COMPARED, history=True)
    found = result.history["x"]
    assert found.shape == expected.shape
    size = np.abs(expected).max()
    assert_allclose(found, expected, rtol=1e-6, atol=1e-8 * size)


@given(arrays(float, 3, elements=coordinates), well_conditioned)
def test_multiplying_the_equations_changes_no_iterate(start, matrix):
    assume(np.linalg.norm(start) > 1e-3)

    def fun(x):
        return np.array([x[0] ** 3 + x[1] - 1, x[1] ** 3 - x[2] + 1, x[2] ** 3 + x[0] + 5])

    def jac(x):
        return np.array([[3 * x[0] ** 2, 1, 0], [0, 3 * x[1] ** 2, -1], [1, 0, 3 * x[2] ** 2]])

    assume(np.linalg.cond(jac(start)) < 1e4)
    plain = lissom.root(fun, start, jac=jac, max_iter=2, tol=0, history=True)
    mixed = lissom.root(
        lambda x: matrix @ fun(x), start, jac=lambda x: matrix @ jac(x), max_iter=2, tol=0, history=True
    )
    first, second = plain.history["x"][1:], mixed.history["x"][1:]
    assert_allclose(first[0], second[0], rtol=1e-9, atol=1e-9 * np.abs(first[0]).max())


@given(st.permutations(range(3)), arrays(float, 3, elements=st.floats(0.1, 10)))
def test_order_and_units_do_not_matter(order, units):
    """Unknowns in another order and other units, with scales in these units, take the same path."""
    problem = PROBLEMS[4]  # helical valley
    order = np.array(order)
    back = np.argsort(order)

    def inner(y):
        return (y * units)[back]

    def jac(y):
        return problem.jac(inner(y))[:, order] * units

    start = problem.standard_start
    for method in METHODS:
        plain = lissom.root(problem.fun, start, jac=problem.jac, method=method, history=True)
        moved = lissom.root(
            lambda y: problem.fun(inner(y)),
            start[order] / units,
            jac=jac,
            method=method,
            x_scale=1 / units,
            history=True,
        )
        assert moved.nit == plain.nit
        path = np.array([inner(y) for y in moved.history["x"]])
        assert_allclose(path, plain.history["x"], rtol=1e-7, atol=1e-7)


@given(well_conditioned, arrays(float, 3, elements=coordinates), arrays(float, 3, elements=coordinates))
@pytest.mark.parametrize("method", METHODS)
def test_linear_systems_take_one_step(method, matrix, root, start):
    assume(np.linalg.norm(matrix @ (start - root)) > 1e-3)
    result = lissom.root(lambda x: matrix @ (x - root), start, jac=lambda _: matrix, method=method)
    assert (result.status, result.nit, result.njev, result.nlu) == ("converged_residual", 1, 1, 1)
    assert_allclose(result.x, root, atol=1e-12)


@given(
    arrays(float, 3, elements=st.floats(-3, 3)),
    st.floats(0.01, 10),
    st.floats(-5, 5),
    st.sampled_from(METHODS),
    st.sampled_from(["forward", "central", "analytic"]),
    st.booleans(),
)
def test_where_there_is_no_root_there_is_no_success(coefficients, gap, start, method, jac, accelerate):
    polynomial = np.polynomial.Polynomial(coefficients)
    slope = polynomial.deriv()
    with np.errstate(all="ignore"):
        result = lissom.root(
            lambda x: polynomial(x) ** 2 + gap,
            start,
            jac=(lambda x: 2 * polynomial(x) * slope(x)) if jac == "analytic" else jac,
            method=method,
            accelerate=accelerate,
            max_iter=50,
        )
    assert not result.success
    assert result.fun >= gap


PLANAR_PROBLEMS = [p for p in PROBLEMS if len(p.standard_start) == 2]
POWELL_BADLY_SCALED = next(p for p in PLANAR_PROBLEMS if p.name == "Powell badly scaled")


@given(
    arrays(float, 2, elements=st.floats(-20, 20)),
    st.sampled_from(["line_search", "trust_region"]),
    st.sampled_from(PLANAR_PROBLEMS),
)
@example(np.array([2.22507386e-309, 0.0]), "line_search", POWELL_BADLY_SCALED)
def test_globalised_methods_only_go_down(start, method, problem):
    with np.errstate(all="ignore"):
        result = lissom.root(problem.fun, start, jac=problem.jac, method=method, max_iter=50, history=True)
    assert np.all(np.diff(result.history["residual_norm"]) < 0)
    assert result.residual_norm == result.history["residual_norm"][-1]


def test_reruns_are_bit_identical_also_in_threads():
    def run(_=None):
        result = lissom.root(circle_and_hyperbola, [3.0, 1.0], method="trust_region", history=True)
        return result.history["x"].tobytes()

    with ThreadPoolExecutor(4) as pool:
        assert set(pool.map(run, range(16))) == {run()}


def test_the_rate_is_quadratic():
    history = lissom.root(
        circle_and_hyperbola, [3, 1], jac=circle_and_hyperbola_jac, tol=1e-14, history=True
    ).history
    errors = np.linalg.norm(history["x"] - ROOT, axis=1)
    constants = errors[1:-1] / errors[:-2] ** 2
    assert len(constants) >= 3
    assert constants.max() < 0.5
    assert errors[-1] < 1e-14


def test_the_rate_at_a_double_root_is_one_half():
    history = lissom.root(
        lambda x: x * (x - 5) ** 2, 10.0, jac=lambda x: (x - 5) * (3 * x - 5), history=True
    ).history
    errors = np.abs(history["x"] - 5)
    assert_allclose(errors[-3:] / errors[-4:-1], 0.5, atol=0.01)


# Jacobians


def test_increments_stand_near_the_bottom_of_the_v_curve():
    """For smaller steps, truncation errors decrease and rounding errors grow; defaults are near optimal."""

    def fun(x):
        return np.array([np.exp(x[0]) * np.sin(x[1]), x[0] / x[1] + x[1] ** 3])

    x = np.array([0.8, 1.3])
    exact = np.array(
        [
            [np.exp(0.8) * np.sin(1.3), np.exp(0.8) * np.cos(1.3)],
            [1 / 1.3, -0.8 / 1.3**2 + 3 * 1.3**2],
        ]
    )
    steps = 10.0 ** np.arange(-13, 0)
    for method, differences, order in [
        ("forward", reference.forward_jacobian, 1),
        ("central", reference.central_jacobian, 2),
    ]:
        errors = np.array([np.abs(differences(fun, x, step) - exact).max() for step in steps])
        best = steps[errors.argmin()]
        optimum = EPS ** (1 / (order + 1))
        assert 1e-2 < best / optimum < 1e2
        # Right of the minimum the error is truncation, with the order as slope.
        slope = np.polyfit(np.log(steps[-4:-1]), np.log(errors[-4:-1]), 1)[0]
        assert abs(slope - order) < 0.1
        found = np.abs(lissom.jacobian(fun, x, method=method) - exact).max()
        assert found < 30 * errors.min()
        assert found < 100 * EPS ** (order / (order + 1))


@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.name)
def test_the_jacobians_of_the_problems_are_right(problem):
    x = problem.standard_start + np.linspace(0.1, 0.3, len(problem.standard_start))
    check = lissom.check_jacobian(problem.fun, problem.jac, x)
    assert check.relative_difference < 1e-7
    wrong = problem.jac(x)
    row, column = np.unravel_index(np.abs(wrong).argmax(), wrong.shape)
    wrong[row, column] *= 1.01
    check = lissom.check_jacobian(problem.fun, lambda _: wrong, x)
    assert (check.row, check.column) == (row, column)
    assert_allclose(check.relative_difference, 0.01, rtol=0.05)
    assert_allclose([check.given, check.difference], wrong[row, column] * np.array([1, 1 / 1.01]), rtol=1e-6)


def test_a_jacobian_that_is_not_finite_is_found():
    check = lissom.check_jacobian(lambda x: x**2, lambda x: [[2 * x[0], 0], [0, np.nan]], [1.0, 2.0])
    assert (check.relative_difference, check.row, check.column) == (np.inf, 1, 1)
    assert "row=1" in repr(check)


def test_increments_follow_the_scale():
    seen = []

    def fun(x):
        seen.append(x[0])
        return x

    lissom.jacobian(fun, [0.0], x_scale=1e-3)
    assert_allclose(np.abs(seen[1:]), EPS ** (1 / 3) * 1e-3)
    seen.clear()
    lissom.jacobian(fun, [-4.0], method="forward")
    assert_array_equal(seen, [-4.0, -4.0 * (1 + np.sqrt(EPS))])


def test_jacobian_counts_and_shapes():
    calls = []

    def fun(x, factor):
        calls.append(1)
        return factor * np.array([x[0], x[0] * x[1], x[1]])

    assert lissom.jacobian(fun, [1.0, 2.0], args=(2,)).shape == (3, 2)
    assert len(calls) == 5
    calls.clear()
    found = lissom.jacobian(fun, [1.0, 2.0], "forward", args=(2,))
    assert len(calls) == 3
    assert_allclose(found, [[2, 0], [4, 2], [0, 2]], atol=1e-6)
    assert_allclose(lissom.jacobian(np.sin, 1.0), [[np.cos(1)]])


# The interface


def test_documented_defaults_are_the_real_ones():
    defaults = {
        name: parameter.default
        for name, parameter in inspect.signature(lissom.root).parameters.items()
        if parameter.default is not inspect.Parameter.empty
    }
    assert defaults == {
        "args": (),
        "jac": "forward",
        "method": "newton",
        "tol": 1e-6,
        "max_iter": 1000,
        "xtol": 0.0,
        "xtol_abs": 0.0,
        "x_scale": None,
        "f_scale": None,
        "max_step": None,
        "keep_jacobian": False,
        "accelerate": False,
        "history": False,
        "raise_on_failure": False,
    }

    def run(**options):
        result = lissom.root(lambda x: np.append(lab(x[0]), x[1] ** 3 - 8), [6.0, 3.0], **options)
        return result.x.tobytes(), result.nfev, result.status

    assert run() == run(**defaults)
    changes = {"jac": "central", "method": "line_search", "tol": 1e-7, "max_iter": 3, "x_scale": 10.0}
    for name, value in changes.items():
        if name != "method":  # no step needs to be shortened here
            assert run() != run(**{name: value})
    assert lissom.root(lambda x: x**2 + 1, 0.7).nit == 1000
    assert inspect.signature(lissom.jacobian).parameters["method"].default == "central"


def test_fields_of_the_result():
    result = lissom.root(circle_and_hyperbola, [3, 1], history=True)
    assert_allclose(result.x, ROOT, atol=1e-7)
    assert_array_equal(result.fun, circle_and_hyperbola(result.x))
    assert result.residual_norm == pytest.approx(np.linalg.norm(result.fun), rel=1e-12)
    assert (result.njev, result.nlu) == (result.nit, result.nit)
    assert result.nfev_jac == 2 * result.njev
    assert result.nfev == 1 + result.nit + result.nfev_jac
    history = result.history
    assert history["x"].shape == (result.nit + 1, 2)
    assert_array_equal(history["x"][0], [3, 1])
    assert_array_equal(history["x"][-1], result.x)
    assert_allclose(
        history["step_norm"][1:], np.linalg.norm(np.diff(history["x"], axis=0), axis=1), rtol=1e-6
    )
    assert_array_equal(history["step_length"][1:], 1)
    assert_allclose(history["rate"][1:], history["residual_norm"][1:] / history["residual_norm"][:-1])
    assert np.isnan(history["rate"][0])
    assert lissom.root(circle_and_hyperbola, [3, 1]).history is None
    for text in ("converged_residual", "nfev", "message"):
        assert text in repr(result)
    with pytest.raises(AttributeError):
        result.x = 1


def test_evaluations_are_counted_as_they_are_made():
    calls = {"fun": 0, "jac": 0}

    def fun(x):
        calls["fun"] += 1
        return circle_and_hyperbola(x)

    def jac(x):
        calls["jac"] += 1
        return circle_and_hyperbola_jac(x)

    for method in METHODS:
        for choice in ("forward", "central", jac):
            calls.update(fun=0, jac=0)
            result = lissom.root(fun, [3.0, -1.0], jac=choice, method=method)
            assert result.nfev == calls["fun"]
            assert calls["jac"] == (result.njev if choice is jac else 0)


def test_numbers_in_numbers_out():
    result = lissom.root(lambda x: x * x - 2, 1)
    assert type(result.x) is float
    assert type(result.fun) is float
    assert lissom.root(lambda x: [x[0] ** 2 - 2], [1]).x.shape == (1,)
    # A vector of one unknown and a scalar residual.
    assert type(lissom.root(lambda x: x[0] ** 2 - 2, [1.0]).fun) is float
    assert lissom.root(lambda x: np.float32(x) - 1, np.float32(3)).success
    assert lissom.root(lambda x: np.array(x) - 1, np.array(3.0)).success


def test_any_array_like_will_do():
    expected = lissom.root(circle_and_hyperbola, np.array([3.0, 1.0])).x
    frozen = np.array([3.0, 1.0])
    frozen.flags.writeable = False
    starts = [
        [3, 1],
        (3.0, 1.0),
        np.array([3, 1]),
        np.array([3, 1], dtype=np.float32),
        np.array([3.0, 9.0, 1.0, 9.0])[::2],
        np.array([[3.0, 1.0], [9.0, 9.0]], order="F")[0],
        np.array([3.0, 1.0], dtype=">f8"),
        frozen,
    ]
    for start in starts:
        assert_array_equal(lissom.root(circle_and_hyperbola, start).x, expected)
    assert_array_equal(frozen, [3, 1])
    results = [
        lambda x: list(circle_and_hyperbola(x)),
        lambda x: np.repeat(circle_and_hyperbola(x), 2)[::2],
    ]
    for fun in results:
        assert_array_equal(lissom.root(fun, [3, 1]).x, expected)
    jacobians = [
        lambda x: circle_and_hyperbola_jac(x).tolist(),
        lambda x: np.asfortranarray(circle_and_hyperbola_jac(x)),
        lambda x: np.repeat(circle_and_hyperbola_jac(x), 2, axis=1)[:, ::2],
    ]
    expected = lissom.root(circle_and_hyperbola, [3, 1], jac=circle_and_hyperbola_jac).x
    for jac in jacobians:
        assert_array_equal(lissom.root(circle_and_hyperbola, [3, 1], jac=jac).x, expected)


def test_the_argument_of_fun_may_be_kept():
    kept = []
    result = lissom.root(lambda x: kept.append(x) or circle_and_hyperbola(x), [3.0, 1.0])
    assert_array_equal(kept[0], [3, 1])
    assert len({id(x) for x in kept}) == len(kept) == result.nfev


def test_extra_arguments():
    result = lissom.root(lambda x, a, b: x**a - b, 1.0, args=(3, 8.0), jac=lambda x, a, b: a * x ** (a - 1))
    assert result.x == pytest.approx(2)


def test_gradients_and_derivatives_pass_for_jacobians():
    assert lissom.root(lambda x: x**3 - 8, 1.0, jac=lambda x: 3 * x**2).success
    plane = lissom.root(lambda x: x.sum() - 6, np.zeros(3), jac=lambda x: np.ones(3))
    assert_allclose(plane.x, 2)
    curve = lissom.root(lambda t: np.array([t - 1, t * t - 1]), 3.0, jac=lambda t: np.array([1, 2 * t]))
    assert curve.success
    assert curve.x == pytest.approx(1)
    assert lissom.root(lambda x: x.sum() - 6, np.zeros(3), jac=lambda x: [[1, 1, 1]]).success


@pytest.mark.parametrize("method", METHODS)
def test_systems_that_are_not_square(method):
    # The point of the plane nearest to the start.
    start = np.array([1.0, -2.0, 0.5])
    plane = lissom.root(lambda x: np.array([x.sum() - 6]), start, method=method)
    assert_allclose(plane.x, start + (6 - start.sum()) / 3, atol=1e-6)
    # Three circles through one point.
    centres = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]])
    point = np.array([1.0, 1.0])
    radii = np.linalg.norm(centres - point, axis=1)
    fit = lissom.root(lambda x: np.linalg.norm(centres - x, axis=1) - radii, [2.0, 2.5], method=method)
    assert fit.status == "converged_residual"
    assert_allclose(fit.x, point, atol=1e-6)
    # A least-squares solution that is not a root is not reported as one.
    misfit = lissom.root(lambda x: np.linalg.norm(centres - x, axis=1) - 1.9, [2.0, 2.5], method=method)
    assert (misfit.status, misfit.success) == ("stationary_point", False)
    assert misfit.residual_norm > 0.1
    gradient = lissom.jacobian(lambda x: np.linalg.norm(centres - x, axis=1), misfit.x).T @ misfit.fun
    assert_allclose(gradient, 0, atol=1e-6)


def test_singular_jacobians_take_the_shortest_step():
    # The same equation twice.
    result = lissom.root(lambda x: np.array([x.sum() - 2, x.sum() - 2]), [0.0, 0.0])
    assert_allclose(result.x, [1, 1], atol=1e-7)


def test_scales():
    def fun(x):
        return 1e9 * circle_and_hyperbola(x)

    scaled = lissom.root(fun, [3, 1], f_scale=1e9)
    assert scaled.status == "converged_residual"
    assert scaled.residual_norm <= 1e-6
    assert np.linalg.norm(scaled.fun) > 1e-6
    assert_array_equal(scaled.x, lissom.root(fun, [3, 1], f_scale=[1e9, 1e9]).x)
    unscaled = lissom.root(fun, [3, 1])
    assert unscaled.nit > scaled.nit


def test_the_step_rule():
    def fun(x):
        return 1e20 * (x * x - 2)

    result = lissom.root(fun, 1.0, xtol=1e-3)
    assert result.status == "converged_step"
    assert result.x == pytest.approx(np.sqrt(2), rel=1e-5)
    assert lissom.root(fun, 1.0, xtol_abs=1e-3).status == "converged_step"
    # Otherwise rounding ends the search, at the root.
    result = lissom.root(fun, 1.0)
    assert result.status == "converged_step"
    assert result.x == pytest.approx(np.sqrt(2), rel=1e-15)


def test_small_steps_at_a_pole_are_no_convergence():
    result = lissom.root(lambda x: 1 / x, 1e-12, jac=lambda x: -1 / x**2, xtol_abs=1e-6, max_iter=50)
    assert not result.success


def test_keeping_the_jacobian_saves_factorisations():
    options = {"jac": circle_and_hyperbola_jac, "tol": 1e-12}
    plain = lissom.root(circle_and_hyperbola, [2.2, 0.6], **options)
    kept = lissom.root(circle_and_hyperbola, [2.2, 0.6], keep_jacobian=True, **options)
    assert kept.success
    assert kept.nlu < plain.nlu
    assert_allclose(kept.x, plain.x, atol=1e-12)


def test_the_line_search_shortens_and_the_newton_method_does_not():
    plain = lissom.root(np.arctan, 2.0)
    assert (plain.status, plain.x) == ("diverged", 2.0)
    searched = lissom.root(np.arctan, 2.0, method="line_search", history=True)
    assert searched.success
    assert searched.history["step_length"][1:].min() < 1
    assert np.all(np.diff(searched.history["residual_norm"]) < 0)
    trusted = lissom.root(np.arctan, 2.0, method="trust_region")
    assert trusted.success


def test_tiny_residuals_are_judged_by_their_own_size():
    """Squares of residuals must not underflow into a false zero gradient."""
    for method in METHODS:
        for jac in ("forward", "central", lambda x: 1e-300):
            result = lissom.root(lambda x: 1e-300 * (x - 1), 5.0, jac=jac, method=method, tol=1e-307)
            assert result.status == "converged_residual"
            assert result.x == pytest.approx(1)


def test_steps_may_be_limited():
    history = lissom.root(lambda x: x - 10, 0.0, max_step=3.0, history=True, max_iter=4).history
    assert_allclose(history["x"], [0, 3, 6, 9, 10])
    endless = lissom.root(lambda x: np.exp(-x), 0.0, max_step=0.1, tol=1e-12, method="line_search")
    assert endless.status == "longest_steps"


# Failures


def test_a_failure_returns_the_best_iterate_and_says_what_to_do():
    result = lissom.root(lambda x: x * x + 1, 3.0)
    assert (result.status, result.success, result.nit) == ("iteration_limit", False, 1000)
    assert abs(result.x) < 0.1
    assert result.fun == result.x**2 + 1
    assert '`method="trust_region"` or "line_search"' in result.message
    assert lissom.root(lambda x: x * x - 2, 1.0, max_iter=0).status == "iteration_limit"


@pytest.mark.parametrize("method", METHODS)
def test_non_finite_values_are_named(method):
    assert lissom.root(lambda x: np.nan, 0.3, method=method).status == "non_finite_residual"
    assert (
        lissom.root(lambda x: x - 1, 0.3, jac=lambda x: np.inf, method=method).status == "non_finite_jacobian"
    )
    assert lissom.root(lambda x: [x[0], np.inf], [1.0, 1.0], method=method).status == "non_finite_residual"


def test_a_step_out_of_the_domain():
    def fun(x):
        return np.log(x) - 1 if x > 0 else np.nan

    plain = lissom.root(fun, 20.0)
    assert (plain.status, plain.x) == ("non_finite_residual", 20.0)
    for method in ("line_search", "trust_region"):
        assert lissom.root(fun, 20.0, method=method).x == pytest.approx(np.e)


def test_a_wrong_jacobian_is_no_success():
    result = lissom.root(lambda x: 1.0, 3.0, jac=lambda x: 1e20)
    assert result.status == "stalled"
    for method in ("line_search", "trust_region"):
        assert not lissom.root(lambda x: x**2 + x - 3, 3.0, jac=lambda x: -1.0, method=method).success


def test_raising_carries_the_result():
    with pytest.raises(lissom.ConvergenceError, match="stationary point") as caught:
        lissom.root(lab, 1.0, raise_on_failure=True)
    assert isinstance(caught.value, lissom.LissomError)
    assert caught.value.result.status == "stationary_point"
    assert lissom.root(lab, 6.0, raise_on_failure=True).success


@pytest.mark.parametrize("exception", [KeyError("own"), KeyboardInterrupt(), ZeroDivisionError("own")])
def test_exceptions_come_through_unchanged(exception):
    def failing(after):
        calls = iter(range(100))

        def fun(x):
            if next(calls) == after:
                raise exception
            return x * x - 2

        return fun

    def failing_jac(x):
        raise exception

    for after in (0, 1, 2):
        with pytest.raises(type(exception)) as caught:
            lissom.root(failing(after), 1.0)
        assert caught.value is exception
        with pytest.raises(type(exception)):
            lissom.jacobian(failing(after), 1.0)
    with pytest.raises(type(exception)) as caught:
        lissom.root(lambda x: x * x - 2, 1.0, jac=failing_jac)
    assert caught.value is exception
    with pytest.raises(type(exception)):
        lissom.check_jacobian(lambda x: x, failing_jac, 1.0)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="timers are a POSIX feature")
def test_ctrl_c_stops_a_search_among_builtin_functions():
    def interrupt(*_):
        raise KeyboardInterrupt

    # 1**x has no root: x diverges slowly, and no Python code runs that could handle a signal.
    one = functools.partial(pow, 1.0)
    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    try:
        with pytest.raises(KeyboardInterrupt):
            lissom.root(one, 0.0, jac=one, max_iter=10**9)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"x0": [1.0, np.nan]}, ValueError, r"x0\[1\]"),
        ({"x0": [[1.0, 2.0]]}, TypeError, "x0: expected a one-dimensional"),
        ({"x0": "start"}, TypeError, "x0"),
        ({"x0": [1 + 2j, 0]}, TypeError, "x0"),
        ({"x0": np.array([1 + 2j, 0])}, TypeError, "x0"),
        ({"fun": 3}, TypeError, "fun: expected a callable"),
        ({"fun": lambda x: "text"}, TypeError, r"fun\(x\)"),
        ({"fun": lambda x: np.eye(2)}, TypeError, r"fun\(x\)"),
        ({"fun": lambda x: x + 1j}, TypeError, r"fun\(x\)"),
        ({"fun": lambda x: None}, TypeError, r"fun\(x\)"),
        ({"jac": "backward"}, ValueError, "jac: got 'backward', expected 'forward', 'central' or a callable"),
        ({"jac": True}, TypeError, "jac"),
        ({"jac": lambda x: np.eye(3)}, ValueError, r"jac\(x\): expected shape \(2, 2\), got \(3, 3\)"),
        ({"jac": lambda x: x}, TypeError, r"jac\(x\)"),
        ({"method": "bisection"}, ValueError, "method: got 'bisection'"),
        ({"tol": -1.0}, ValueError, "^tol: got -1, expected a finite number >= 0"),
        ({"tol": np.nan, "xtol_abs": np.inf}, ValueError, "^tol: got NaN.*\nxtol_abs: got inf"),
        ({"xtol": -1.0}, ValueError, "^xtol: got -1"),
        ({"max_iter": -1}, ValueError, "^max_iter: got -1, expected a whole number >= 0"),
        ({"max_step": 0.0}, ValueError, "^max_step: got 0"),
        ({"x_scale": [1.0, 0.0]}, ValueError, r"x_scale\[1\]"),
        ({"x_scale": [1.0]}, ValueError, "x_scale: expected 2 values"),
        ({"f_scale": -1.0}, ValueError, r"f_scale\[0\]"),
        ({"args": 3}, TypeError, "args"),
    ],
)
def test_senseless_input_is_refused(options, error, message):
    arguments = {"fun": lambda x: x - 1.0, "x0": [2.0, 3.0]} | options
    fun, x0 = arguments.pop("fun"), arguments.pop("x0")
    with pytest.raises(error, match=message):
        lissom.root(fun, x0, **arguments)


def test_a_residual_that_changes_its_length_is_refused():
    lengths = iter([2, 3])
    with pytest.raises(ValueError, match=r"fun\(x\): expected 2 values as at x0, got 3"):
        lissom.root(lambda x: np.ones(next(lengths)), [1.0, 2.0])


def test_options_are_keywords():
    with pytest.raises(TypeError):
        lissom.root(lab, 1.0, "central")


RUNAWAYS = {
    "exp(-x)": (lambda x: np.exp(-x), 0.0),
    "1/x": (lambda x: 1.0 / x, 1.0),
    "1/x^2": (lambda x: 1.0 / x**2, 1.0),
    "two": (lambda x: np.array([np.exp(-x[0]), x[1] - 1.0]), [0.0, 0.0]),
}


@pytest.mark.parametrize("name", RUNAWAYS)
@pytest.mark.parametrize("jac", ["forward", "central"])
def test_residuals_that_vanish_far_away_are_doubted(name, jac):
    fun, x0 = RUNAWAYS[name]
    result = lissom.root(fun, x0, jac=jac)
    assert result.status == "converged_residual"
    assert result.doubt.startswith("The last steps became no shorter")
    assert result.doubt in result.message


@pytest.mark.parametrize("multiplicity", [1, 2, 3, 5, 8])
def test_multiple_roots_are_not_doubted(multiplicity):
    result = lissom.root(lambda x: (x - 1.0) ** multiplicity, 3.0)
    assert result.success
    assert result.doubt is None


@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.name)
def test_roots_are_not_doubted(problem):
    for method in METHODS:
        result = lissom.root(problem.fun, problem.start(1), jac=problem.jac, method=method)
        assert result.doubt is None, (method, result.message)


#: Newton's iterates of these repeat: functions, derivatives, starts and periods.
CYCLES = {
    "0, 1, 0, ...": (lambda x: x**3 - 2 * x + 2, lambda x: 3 * x**2 - 2, 0.0, 2),
    "beside it": (lambda x: x**3 - 2 * x + 2, lambda x: 3 * x**2 - 2, 0.05, 2),
    "a vector": (
        lambda x: np.array([x[0] ** 3 - 2 * x[0] + 2, x[1] - 3]),
        lambda x: np.diag([3 * x[0] ** 2 - 2, 1.0]),
        [0.0, 0.0],
        2,
    ),
}


@pytest.mark.parametrize("case", CYCLES)
def test_cycles_are_named(case):
    fun, jac, start, period = CYCLES[case]
    found = lissom.root(fun, start, jac=jac)
    assert found.status == "iteration_limit"
    assert (
        f"the iterates go round in a cycle of {period} steps, and more of them do not help" in found.message
    )
    assert 'method="trust_region"' in found.message


def test_iterations_that_do_not_repeat_are_no_cycle():
    """Chaotic ones, slow ones, and searches that are stopped on their way."""
    for search in (
        lissom.root(lambda x: x * x + 1, 3.0, jac=lambda x: 2 * x),
        lissom.root(lambda x: x**8, 1.0, jac=lambda x: 8 * x**7, tol=0.0, max_iter=50),
        lissom.root(lambda x: x * x - 2, 1.0, max_iter=2, tol=0.0),
    ):
        assert search.status == "iteration_limit"
        assert "cycle" not in search.message
