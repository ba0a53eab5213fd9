"""Compiled right-hand sides, without Python in the loop."""

import ctypes
import signal
import threading
import time

import numba
import numpy as np
import pytest
from numba import types
from scipy import LowLevelCallable

import lissom
from reference import ode as reference

METHODS = ["rk45", "dop853", "radau"]
POINTER = types.CPointer(types.double)
SIGNATURE = types.void(types.double, POINTER, POINTER, POINTER)


@numba.cfunc(SIGNATURE)
def pendulum(t, y, dydt, args):
    dydt[0] = y[1]
    dydt[1] = -np.sin(y[0])


@numba.cfunc(SIGNATURE)
def oscillator(t, y, dydt, args):
    dydt[0] = y[1]
    dydt[1] = -args[0] * y[0] - args[1] * y[1]


@numba.cfunc(SIGNATURE)
def robertson(t, y, dydt, args):
    dydt[0] = -0.04 * y[0] + 1e4 * y[1] * y[2]
    dydt[2] = 3e7 * y[1] * y[1]
    dydt[1] = -dydt[0] - dydt[2]


@numba.cfunc(SIGNATURE)
def robertson_jacobian(t, y, jac, args):
    jac[0], jac[1], jac[2] = -0.04, 1e4 * y[2], 1e4 * y[1]
    jac[6], jac[7], jac[8] = 0.0, 6e7 * y[1], 0.0
    for i in range(3):
        jac[3 + i] = -jac[i] - jac[6 + i]


def of_address(function):
    """A function known only by its address."""
    pointer = ctypes.POINTER(ctypes.c_double)
    return ctypes.CFUNCTYPE(None, ctypes.c_double, pointer, pointer, pointer)(function.address)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "wrap",
    [lambda f: f, lambda f: LowLevelCallable(f.ctypes), lambda f: f.ctypes, of_address],
    ids=["cfunc", "LowLevelCallable", "ctypes", "address"],
)
def test_a_compiled_function_gives_what_python_gives(method, wrap):
    problem = reference.pendulum()
    times = np.linspace(*problem.t_span, 31)
    options = {"t_eval": times, "rtol": 1e-9, "atol": 1e-9}
    compiled = lissom.solve_ivp(wrap(pendulum), problem.t_span, problem.y0, method, **options)
    python = lissom.solve_ivp(problem.fun, problem.t_span, problem.y0, method, **options)
    np.testing.assert_allclose(compiled.y, problem.exact(times), atol=1e-6)
    np.testing.assert_allclose(compiled.y, python.y, atol=1e-12)
    assert compiled.nfev == python.nfev


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "args", [(4.0, 0.1), [4.0, 0.1], np.array([4.0, 0.1]), np.array([4, 0.1], dtype=object)]
)
def test_args_are_numbers(method, args):
    result = lissom.solve_ivp(oscillator, (0.0, 3.0), [1.0, 0.0], method, args=args, rtol=1e-9, atol=1e-9)
    omega = np.sqrt(4.0 - 0.05**2)
    exact = np.exp(-0.15) * (np.cos(3.0 * omega) + 0.05 / omega * np.sin(3.0 * omega))
    assert result.y[0, -1] == pytest.approx(exact, abs=1e-7)


def test_user_data_of_a_low_level_callable_takes_the_place_of_args():
    numbers = np.array([4.0, 0.1])
    user_data = ctypes.cast(numbers.ctypes.data, ctypes.c_void_p)
    fun = LowLevelCallable(oscillator.ctypes, user_data)
    result = lissom.solve_ivp(fun, (0.0, 3.0), [1.0, 0.0])
    expected = lissom.solve_ivp(oscillator, (0.0, 3.0), [1.0, 0.0], args=numbers)
    np.testing.assert_array_equal(result.y, expected.y)
    with pytest.raises(ValueError, match="args: fun is a LowLevelCallable with user_data"):
        lissom.solve_ivp(fun, (0.0, 3.0), [1.0, 0.0], args=numbers)


@pytest.mark.parametrize(
    "jac",
    [
        None,
        robertson_jacobian,
        robertson_jacobian.ctypes,
        of_address(robertson_jacobian),
        reference.robertson_jacobian,
    ],
    # An address in a name would differ between processes.
    ids=["differences", "cfunc", "ctypes", "address", "python"],
)
def test_jacobians_of_compiled_functions(jac):
    problem = reference.robertson()
    options = {"method": "radau", "rtol": 1e-8, "atol": 1e-12}
    result = lissom.solve_ivp(robertson, problem.t_span, problem.y0, jac=jac, **options)
    expected = lissom.solve_ivp(problem.fun, problem.t_span, problem.y0, **options)
    assert (result.nfev_jac == 0) == (jac is not None)
    np.testing.assert_allclose(result.y[:, -1], expected.y[:, -1], rtol=1e-6)


def test_events_and_callbacks_may_be_python():
    seen = []
    result = lissom.solve_ivp(
        pendulum,
        (0.0, 10.0),
        [1.0, 0.0],
        events=lambda t, y: y[0],
        callback=lambda t, y: seen.append(t),
    )
    assert result.t_events[0].size == 3
    assert len(seen) == result.naccepted


def test_steppers_take_compiled_functions():
    stepper = lissom.RK45(pendulum, 0.0, [1.0, 0.0], 10.0)
    result = lissom.solve_ivp(pendulum, (0.0, 10.0), [1.0, 0.0])
    while stepper.status == "running":
        stepper.step()
    np.testing.assert_array_equal(stepper.y, result.y[:, -1])


def test_other_signatures_are_refused():
    two = numba.cfunc(types.double(types.double, types.double))(lambda x, y: x + y)
    returning = numba.cfunc(types.double(types.double, POINTER, POINTER, POINTER))(lambda t, y, d, a: t)
    undeclared = ctypes.CDLL(None).atan2
    for wrong in (two, returning, LowLevelCallable(two.ctypes), two.ctypes, undeclared):
        with pytest.raises(
            TypeError, match=r"fun: expected a compiled function of signature void \(double t"
        ):
            lissom.solve_ivp(wrong, (0.0, 1.0), [1.0, 0.0])
    with pytest.raises(TypeError, match="jac: expected a compiled function"):
        lissom.solve_ivp(pendulum, (0.0, 1.0), [1.0, 0.0], "radau", jac=two)
    with pytest.raises(TypeError, match="args: expected numbers for a compiled function, got tuple"):
        lissom.solve_ivp(oscillator, (0.0, 1.0), [1.0, 0.0], args=("a", "b"))

    null = ctypes.cast(None, ctypes.CFUNCTYPE(None, ctypes.c_double, *[ctypes.c_void_p] * 3))
    with pytest.raises(ValueError, match="the address of the compiled function is 0"):
        lissom.solve_ivp(null, (0.0, 1.0), [1.0, 0.0])


class Imposter:
    """Looks like a numba function, and would crash the process."""

    address = 2**20

    def __init__(self):
        self.ctypes = self
        self.argtypes = pendulum.ctypes.argtypes
        self.restype = None
        self.signature = "void (double, double *, double *, double *)"


class LowLevelImposter(tuple):
    """A tuple with the right name and type."""

    signature = "void (double, double *, double *, double *)"


LowLevelImposter.__name__ = "LowLevelCallable"


def test_functions_are_known_by_their_types_alone():
    for imposter in (Imposter(), LowLevelImposter((2**20, None, None))):
        with pytest.raises(TypeError, match="fun: expected a callable, a compiled function"):
            lissom.solve_ivp(imposter, (0.0, 1.0), [1.0, 0.0])
        with pytest.raises(
            TypeError, match=r"jac: expected a two-dimensional array|jac.*: expected a real number"
        ):
            lissom.solve_ivp(pendulum, (0.0, 1.0), [1.0, 0.0], "radau", jac=imposter)

    class Callable(Imposter):
        def __call__(self, t, y):
            return [y[1], -np.sin(y[0])]

    result = lissom.solve_ivp(Callable(), (0.0, 1.0), [1.0, 0.0])
    assert result.y.tolist() == lissom.solve_ivp(pendulum, (0.0, 1.0), [1.0, 0.0]).y.tolist()


@pytest.mark.parametrize("number", [True, False, 0, 3, -1, 2**64, 2**20])
def test_numbers_are_no_functions(number):
    with pytest.raises(TypeError, match=r"fun: expected a callable, a compiled function .*, got (int|bool)"):
        lissom.solve_ivp(number, (0.0, 1.0), [1.0, 0.0])
    with pytest.raises(
        TypeError, match=r"jac: expected a two-dimensional array of real numbers, got (int|bool)"
    ):
        lissom.solve_ivp(pendulum, (0.0, 1.0), [1.0, 0.0], "radau", jac=number)


def test_the_interpreter_is_free_meanwhile():
    """Another thread makes progress during a long run."""
    counter = {"value": 0, "stop": False}

    def count():
        while not counter["stop"]:
            counter["value"] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    try:
        before = counter["value"]
        lissom.solve_ivp(pendulum, (0.0, 2e5), [1.0, 0.0], t_eval=[2e5], rtol=1e-8)
        progress = counter["value"] - before
    finally:
        counter["stop"] = True
        thread.join()
    assert progress > 3


def test_ctrl_c_stops_a_compiled_run():
    def interrupt(*_):
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.1)
    try:
        with pytest.raises(KeyboardInterrupt):
            lissom.solve_ivp(pendulum, (0.0, 1e9), [1.0, 0.0], t_eval=[1e9])
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
