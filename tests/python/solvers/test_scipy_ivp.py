"""SciPy's own tests of `solve_ivp`, from the installed SciPy, run with lissom.

In SciPy's test module, the function and the three classes that lissom has are replaced by lissom's; other
methods use SciPy's function. Tests that are not run are listed here with the reason; the same list is in
docs/ode.md.
"""

import types

import numpy as np
import pytest
import scipy.integrate
from scipy.integrate._ivp.tests import test_ivp as scipy_tests
from scipy.integrate._ivp.tests import test_rk as scipy_rk_tests

import lissom

NOT_RUN = {
    "test_integration_complex": "complex states are refused: see test_complex_states_are_refused",
    "test_OdeSolution": "tests SciPy's internal classes only",
    "test_ConstantDenseOutput": "tests SciPy's internal classes only",
    "test_num_jac": "tests SciPy's internal functions only",
    "test_num_jac_sparse": "tests SciPy's internal functions only",
    "test_inital_maxstep": "tests SciPy's internal functions only",
    "test_event_dense_output_LSODA": "tests a method that lissom does not have",
}

LISSOM_METHODS = ("RK45", "DOP853", "Radau", lissom.RK45, lissom.DOP853, lissom.Radau)

calls = {"lissom": 0}


def solve_ivp(fun, t_span, y0, method="RK45", **options):
    if method not in LISSOM_METHODS:
        return scipy.integrate.solve_ivp(fun, t_span, y0, method=method, **options)
    calls["lissom"] += 1
    result = lissom.solve_ivp(fun, t_span, y0, method=method, **options)
    if result.t.size:
        return result
    # SciPy returns empty lists if no time of `t_eval` was reached, and its test uses their truth value;
    # lissom always returns arrays.
    names = [name for name in dir(result) if not name.startswith("_")]
    return types.SimpleNamespace(**{name: getattr(result, name) for name in names} | {"t": [], "y": []})


@pytest.fixture(autouse=True)
def _lissom_in_place_of_scipy(monkeypatch):
    monkeypatch.setattr(scipy_tests, "solve_ivp", solve_ivp)
    for name in ("RK45", "DOP853", "Radau"):
        monkeypatch.setattr(scipy_tests, name, getattr(lissom, name))


@pytest.fixture
def num_parallel_threads():
    """Replacement for the value of pytest-run-parallel."""
    return 1


for _name, _test in vars(scipy_tests).items():
    if _name.startswith("test_") and callable(_test) and _name not in NOT_RUN:
        globals()[_name] = _test


def test_the_list_of_tests_that_are_not_run_is_up_to_date():
    assert set(NOT_RUN) <= set(vars(scipy_tests))


def test_lissom_is_what_the_tests_run():
    before = calls["lissom"]
    scipy_tests.test_zero_interval("RK45")
    assert calls["lissom"] == before + 1


@pytest.mark.parametrize("method", ["rk45", "dop853", "radau"])
def test_complex_states_are_refused(method):
    with pytest.raises(TypeError, match="y0: complex states are not supported"):
        lissom.solve_ivp(scipy_tests.fun_complex, [0, 1], [0.5 + 1j], method=method)
    with pytest.raises(TypeError, match=r"fun: expected .*real numbers, got .*complex128"):
        lissom.solve_ivp(lambda t, y: 1j * y, [0, 1], [1.0], method=method)


class RK45(lissom.RK45):
    """With the private names that SciPy's test uses."""

    K = None

    def _estimate_error(self, stages, step):
        return self.error_estimate()


class DOP853(lissom.DOP853):
    """With the private names that SciPy's test uses."""

    K = None

    def _estimate_error(self, stages, step):
        return self.error_estimate()


@pytest.mark.parametrize("solver", [RK45, DOP853])
def test_coefficient_properties(solver):
    scipy_rk_tests.test_coefficient_properties(solver)


@pytest.mark.parametrize("solver", [RK45, DOP853])
def test_error_estimation(solver):
    scipy_rk_tests.test_error_estimation(solver)


@pytest.mark.parametrize("name", ["RK45", "DOP853"])
def test_error_estimates_are_those_of_scipy(name):
    def fun(t, y):
        return np.array([y[1], -np.sin(y[0]) - 0.1 * y[1]])

    ours = getattr(lissom, name)(fun, 0.0, [1.0, 0.0], 5.0)
    theirs = getattr(scipy.integrate, name)(fun, 0.0, [1.0, 0.0], 5.0)
    for _ in range(3):
        ours.step()
        theirs.step()
        estimate = theirs._estimate_error(theirs.K, theirs.h_previous)
        np.testing.assert_allclose(ours.error_estimate(), estimate, rtol=1e-6, atol=1e-16)
