"""`solve_ivp` and the step-by-step solvers from the user's perspective."""

import inspect
import operator
import signal
import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.sparse import csc_matrix

import lissom
from reference import ode as reference

METHODS = ["rk45", "dop853", "radau"]
EXPLICIT = ["rk45", "dop853"]
CLASSES = [lissom.RK45, lissom.DOP853, lissom.Radau]


def decay(t, y):
    return -y


def oscillator(t, y):
    return [y[1], -y[0]]


# ------------------------------------------------------------------------------------------------- defaults


def test_defaults():
    result = lissom.solve_ivp(oscillator, (0.0, 10.0), [1.0, 0.0])
    assert result.success
    assert (result.status, result.reason) == (0, "finished")
    assert result.t[0] == 0.0
    assert result.t[-1] == 10.0
    assert result.y.shape == (2, result.t.size)
    assert result.y.dtype == result.t.dtype == np.float64
    assert np.abs(result.y[0] - np.cos(result.t)).max() < 2e-2
    assert result.sol is None
    assert result.t_events is None
    assert result.y_events is None
    assert (result.njev, result.nlu, result.nfev_jac) == (0, 0, 0)
    assert result.naccepted == result.t.size - 1
    assert result.nfev == 2 + 6 * (result.naccepted + result.nrejected)
    assert result.stiff_at is None
    assert "success=True" in repr(result)


def test_the_documented_defaults_are_the_real_ones():
    def defaults(function, first_keyword):
        names = list(inspect.signature(function).parameters.items())
        start = [name for name, _ in names].index(first_keyword)
        return {name: parameter.default for name, parameter in names[start:]}

    given = defaults(lissom.solve_ivp, "method")
    assert given["method"] == "rk45"
    assert (given["rtol"], given["atol"]) == (1e-3, 1e-6)
    plain = lissom.solve_ivp(oscillator, (0.0, 10.0), [1.0, 0.0])
    spelled_out = lissom.solve_ivp(oscillator, (0.0, 10.0), [1.0, 0.0], **given)
    np.testing.assert_array_equal(plain.t, spelled_out.t)
    np.testing.assert_array_equal(plain.y, spelled_out.y)
    for solver in CLASSES:
        plain = solver(oscillator, 0.0, [1.0, 0.0], 10.0)
        spelled_out = solver(oscillator, 0.0, [1.0, 0.0], 10.0, **defaults(solver, "args"))
        for _ in range(4):
            plain.step()
            spelled_out.step()
            assert plain.t == spelled_out.t


# --------------------------------------------------------------------------------------------- what goes in


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "convert",
    [
        np.array,
        list,
        tuple,
        lambda y: np.array(y, dtype=np.float32),
        lambda y: np.array(y, dtype=int),
        lambda y: np.repeat(np.array(y), 2)[::2],
        lambda y: np.array(y, dtype=">f8"),
    ],
)
def test_any_array_will_do(method, convert):
    y0 = convert([1.0, 0.0])
    if isinstance(y0, np.ndarray):
        y0.flags.writeable = False
    result = lissom.solve_ivp(lambda t, y: convert(oscillator(t, y)), (0, 1), y0, method, rtol=1e-3)
    # Rounded to integers, derivatives are inaccurate; the others are accurate to three digits.
    if np.asarray(y0).dtype != int:
        np.testing.assert_allclose(result.y[:, -1], [np.cos(1.0), -np.sin(1.0)], atol=5e-3)
    assert result.success


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "value", [lambda y: -y, lambda y: -y[0], lambda y: -float(y[0]), lambda y: np.array(-y[0])]
)
def test_one_equation_may_return_a_number(method, value):
    result = lissom.solve_ivp(lambda t, y: value(y), (0.0, 1.0), [1.0], method)
    assert result.y[0, -1] == pytest.approx(np.exp(-1.0), rel=5e-3)


@pytest.mark.parametrize(
    ("value", "error", "message"),
    [
        (None, TypeError, "fun: returned None"),
        ([1.0], ValueError, "fun: expected 2 values, got 1"),
        (np.zeros(3), ValueError, "fun: expected 2 values, got 3"),
        (1.0, ValueError, "fun: expected 2 values, got a single number"),
        ("ab", TypeError, "value of fun: expected a one-dimensional array of real numbers, got str"),
        (np.zeros((2, 1)), TypeError, r"value of fun: .*shape \(2, 1\)"),
        (np.zeros(2, dtype=complex), TypeError, "value of fun: .*complex128"),
    ],
)
@pytest.mark.parametrize("method", METHODS)
def test_wrong_values_of_fun_are_named(method, value, error, message):
    with pytest.raises(error, match=message):
        lissom.solve_ivp(lambda t, y: value, (0.0, 1.0), [1.0, 0.0], method)


def test_states_given_to_fun_may_be_kept_and_changed():
    kept = []

    def fun(t, y):
        kept.append(y)
        derivative = [y[1], -y[0]]
        y[:] = np.nan
        return derivative

    spoiled = lissom.solve_ivp(fun, (0.0, 10.0), [1.0, 0.0])
    clean = lissom.solve_ivp(oscillator, (0.0, 10.0), [1.0, 0.0])
    np.testing.assert_array_equal(spoiled.y, clean.y)
    assert len({id(y) for y in kept}) == len(kept) == clean.nfev


def test_the_initial_state_is_not_changed():
    y0 = np.array([1.0, 0.0])
    lissom.solve_ivp(oscillator, (0.0, 10.0), y0)
    np.testing.assert_array_equal(y0, [1.0, 0.0])


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"rtol": -1.0}, ValueError, "rtol: got -1"),
        ({"rtol": np.nan}, ValueError, "rtol: got NaN"),
        ({"atol": [1e-6, -1e-6]}, ValueError, r"atol\[1\]: got -0.000001"),
        ({"atol": [1e-6]}, ValueError, "atol: got 1 values, expected 2 values"),
        ({"rtol": "tight"}, TypeError, "rtol: expected"),
        ({"first_step": 0.0}, ValueError, "first_step: got 0"),
        ({"first_step": 11.0}, ValueError, "first_step: got 11, expected at most the length of t_span, 10"),
        ({"max_step": 0.0}, ValueError, "max_step: got 0, expected a number > 0"),
        ({"min_step": -1.0}, ValueError, "min_step: got -1"),
        ({"min_step": 1.0, "max_step": 0.5}, ValueError, "min_step: got 1, expected at most max_step, 0.5"),
        ({"method": "RK23"}, ValueError, "method: got 'RK23', expected 'rk45', 'dop853' or 'radau'"),
        ({"method": dict}, ValueError, "method: got <class 'dict'>"),
        ({"controller": "PID"}, ValueError, "controller: got 'PID', expected 'I' or 'PI'"),
        ({"event_samples": 0}, ValueError, "event_samples: got 0"),
        ({"t_eval": [1.0, 0.5]}, ValueError, r"t_eval\[1\]: got 0.5, expected a time larger than"),
        ({"t_eval": [1.0, 20.0]}, ValueError, r"t_eval\[1\]: got 20, expected a time within t_span"),
        ({"t_eval": [[1.0], [2.0]]}, TypeError, "t_eval: expected a one-dimensional array"),
        ({"events": 3}, TypeError, "events: expected a callable or a list of them, got int"),
        ({"events": [3]}, TypeError, r"events\[0\]: expected a callable, got int"),
        ({"args": 3}, TypeError, "Supplied 'args' cannot be unpacked"),
        ({"method": "radau", "jac": np.eye(3)}, ValueError, r"jac: expected shape \(2, 2\), got \(3, 3\)"),
        ({"method": "radau", "jac": lambda t, y: np.eye(3)}, ValueError, r"jac: expected shape \(2, 2\)"),
        ({"method": "radau", "jac_sparsity": np.eye(3)}, ValueError, "jac_sparsity: expected shape"),
        ({"unknown": 1}, TypeError, "unexpected keyword argument 'unknown'"),
    ],
)
def test_wrong_options_are_refused(options, error, message):
    with pytest.raises(error, match=message):
        lissom.solve_ivp(oscillator, (0.0, 10.0), [1.0, 0.0], **options)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ((3, (0, 1), [1.0]), TypeError, "fun: expected a callable, a compiled function .* got int"),
        ((decay, (0, 1, 2), [1.0]), TypeError, r"t_span: expected two numbers, \(t0, tf\), got tuple"),
        ((decay, 5.0, [1.0]), TypeError, "t_span: expected two numbers"),
        ((decay, (np.nan, 1.0), [1.0]), ValueError, r"t_span\[0\]: got NaN"),
        ((decay, (np.inf, 1.0), [1.0]), ValueError, r"t_span\[0\]: got inf"),
        ((decay, (0.0, np.nan), [1.0]), ValueError, r"t_span\[1\]: got NaN"),
        ((decay, (0.0, 1.0), [np.inf]), ValueError, r"y0\[0\]: got inf"),
        ((decay, (0.0, 1.0), 1.0), TypeError, "y0: expected a one-dimensional array"),
        ((decay, (0.0, 1.0), [[1.0]]), TypeError, "y0: expected a one-dimensional array"),
        ((decay, (0.0, 1.0), ["a"]), TypeError, r"y0\[0\]: expected a real number, got 'a'"),
    ],
)
def test_wrong_arguments_are_refused(arguments, error, message):
    with pytest.raises(error, match=message):
        lissom.solve_ivp(*arguments)


def test_all_problems_are_reported_at_once():
    with pytest.raises(ValueError, match="rtol") as caught:
        lissom.solve_ivp(decay, (0.0, 1.0), [1.0], rtol=-1.0, max_step=-1.0, first_step=2.0)
    assert str(caught.value).count("\n") == 2


def test_args_reach_everybody():
    def fun(t, y, a, b):
        return [a * y[0] + b]

    def jac(t, y, a, b):
        return [[a]]

    def event(t, y, a, b):
        return y[0] - b

    for args in ((-2.0, 1.0), [-2.0, 1.0], np.array([-2.0, 1.0])):
        result = lissom.solve_ivp(
            fun, (0.0, 3.0), [3.0], "radau", args=args, jac=jac, events=event, rtol=1e-8
        )
        assert result.y[0, -1] == pytest.approx(0.5 + 2.5 * np.exp(-6.0), rel=1e-5)
        assert result.t_events[0] == pytest.approx([np.log(5.0) / 2.0], rel=1e-5)
    with pytest.raises(TypeError):
        lissom.solve_ivp(fun, (0.0, 3.0), [3.0], args=(-2.0,))


def test_jac_without_effect_warns():
    with pytest.warns(UserWarning, match="no effect for a chosen solver: `jac`"):
        lissom.solve_ivp(decay, (0.0, 1.0), [1.0], jac=[[-1.0]])


# ------------------------------------------------------------------------------------------- what comes out


@pytest.mark.parametrize("method", METHODS)
def test_t_eval(method):
    for times in ([], [0.0], [10.0], [0.0, 10.0], [0.1, 2.0, 9.9], np.linspace(0.0, 10.0, 57)):
        result = lissom.solve_ivp(
            oscillator, (0.0, 10.0), [1.0, 0.0], method, t_eval=times, rtol=1e-8, atol=1e-10
        )
        np.testing.assert_array_equal(result.t, times)
        assert result.y.shape == (2, len(times))
        np.testing.assert_allclose(result.y[0], np.cos(times), atol=1e-6)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("t_span", [(0.0, 10.0), (10.0, 0.0), (-5.0, 2.0)])
def test_dense_output(method, t_span):
    y0 = [np.cos(t_span[0]), -np.sin(t_span[0])]
    result = lissom.solve_ivp(oscillator, t_span, y0, method, dense_output=True, rtol=1e-8, atol=1e-10)
    sol = result.sol
    assert (sol.t_min, sol.t_max) == (min(t_span), max(t_span))
    np.testing.assert_array_equal(sol.ts, result.t)
    times = np.linspace(*t_span, 100)
    np.testing.assert_allclose(sol(times)[0], np.cos(times), atol=1e-6)
    assert sol(times).shape == (2, 100)
    assert sol(1.0).shape == sol(np.float64(1.0)).shape == sol(np.array(1.0)).shape == (2,)
    assert sol([]).shape == (2, 0)
    np.testing.assert_array_equal(sol(times)[:, 7], sol(times[7]))
    np.testing.assert_allclose(sol(result.t), result.y, rtol=0.0, atol=1e-14)
    assert "DenseOutput(t_min=" in repr(sol)
    for wrong in ([[1.0]], "a", None):
        with pytest.raises(ValueError, match=r"`t` must be a float or a 1-D array"):
            sol(wrong)


@pytest.mark.parametrize("method", METHODS)
def test_zero_length_and_empty_problems(method):
    result = lissom.solve_ivp(decay, (4.0, 4.0), [2.0, 3.0], method, dense_output=True, t_eval=[4.0])
    assert result.success
    np.testing.assert_array_equal(result.y, [[2.0], [3.0]])
    np.testing.assert_array_equal(result.sol([3.0, 4.0]), [[2.0, 2.0], [3.0, 3.0]])
    result = lissom.solve_ivp(lambda t, y: y, (0.0, np.inf), [], method, dense_output=True)
    assert result.success
    assert result.y.shape[0] == 0
    assert result.sol(5.0).shape == (0,)


@pytest.mark.parametrize("method", METHODS)
def test_infinite_intervals_end_at_events(method):
    def half(t, y):
        return y[0] - 0.5

    half.terminal = True
    result = lissom.solve_ivp(decay, (0.0, np.inf), [1.0], method, events=half, rtol=1e-8, atol=1e-10)
    assert result.t[-1] == pytest.approx(np.log(2.0), rel=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_step_size_limits(method):
    options = {"first_step": 0.01, "max_step": 0.3}
    result = lissom.solve_ivp(oscillator, (0.0, 5.0), [1.0, 0.0], method, **options)
    steps = np.diff(result.t)
    assert steps[0] == pytest.approx(0.01)
    assert steps.max() <= 0.3 + 1e-15
    assert result.t[-1] == 5.0


@pytest.mark.parametrize("method", METHODS)
def test_nothing_is_evaluated_outside_of_the_interval(method):
    for t_span in ((0.0, 0.3), (0.3, 0.0), (0.0, 1e-9), (1e8, 1e8 + 1.0), (0.0, 1 / 3), (-2.0, 1.1)):
        times = []

        def fun(t, y, times=times):
            times.append(t)
            return -y

        result = lissom.solve_ivp(fun, t_span, [1.0], method, dense_output=True, events=lambda t, y: y[0])
        assert result.t[-1] == t_span[1]
        assert min(t_span) <= min(times)
        assert max(times) <= max(t_span)


# ------------------------------------------------------------------------------------------------- failures


@pytest.mark.parametrize("method", METHODS)
def test_a_singularity_is_reported(method):
    result = lissom.solve_ivp(lambda t, y: y**2, (0.0, 2.0), [1.0], method)
    assert not result.success
    assert (result.status, result.reason) == (-1, "step_too_small")
    assert "singularity" in result.message
    assert result.t[-1] == pytest.approx(1.0, abs=1e-2)
    assert np.isfinite(result.y).all()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_right_hand_side_that_is_not_finite_is_reported(method, bad):
    def fun(t, y):
        return [bad] if t > 0.5 else -y

    result = lissom.solve_ivp(fun, (0.0, 1.0), [1.0], method)
    assert (result.success, result.reason) == (False, "non_finite")
    assert np.isfinite(result.y).all()
    assert result.t[-1] == pytest.approx(0.5, abs=1e-6)
    result = lissom.solve_ivp(lambda t, y: [bad], (0.0, 1.0), [1.0], method)
    assert (result.success, result.reason) == (False, "non_finite")
    assert result.t.tolist() == [0.0]


@pytest.mark.parametrize("name", ["max_steps", "event_samples"])
def test_negative_numbers_of_things_are_refused(name):
    with pytest.raises(ValueError, match=f"{name}: got -1, expected a whole number >= 0"):
        lissom.solve_ivp(decay, (0, 1), [1.0], **{name: -1})


@pytest.mark.parametrize("solver", CLASSES)
def test_a_negative_limit_of_steps_is_refused(solver):
    with pytest.raises(ValueError, match="max_steps: got -1"):
        solver(decay, 0, [1.0], 1, max_steps=-1)


@pytest.mark.parametrize("method", METHODS)
def test_limits_are_reported_with_their_names(method):
    result = lissom.solve_ivp(oscillator, (0.0, 100.0), [1.0, 0.0], method, max_steps=5)
    assert (result.success, result.reason, result.naccepted) == (False, "too_many_steps", 5)
    assert "increase `max_steps`" in result.message
    options = {"min_step": 1.0, "rtol": 1e-11, "atol": 1e-11}
    result = lissom.solve_ivp(oscillator, (0.0, 100.0), [1.0, 0.0], method, **options)
    assert (result.success, result.reason) == (False, "step_too_small")
    assert "decrease `min_step`" in result.message


@pytest.mark.parametrize("method", METHODS)
def test_a_component_that_stays_zero_needs_no_tolerance(method):
    result = lissom.solve_ivp(lambda t, y: [0.0, -y[1]], (0.0, 1.0), [0.0, 1.0], method, atol=0.0)
    assert result.success
    np.testing.assert_array_equal(result.y[0], 0.0)


@pytest.mark.parametrize("jac", [lambda t, y: [[np.nan if t > 0.5 else -1.0]], [[np.inf]]])
def test_a_jacobian_that_is_not_finite_is_named_at_once(jac):
    result = lissom.solve_ivp(lambda t, y: -(y**3), (0.0, 10.0), [1.0], "radau", jac=jac)
    assert (result.success, result.reason) == (False, "non_finite_jacobian")
    assert result.nrejected < 10
    last = f"{result.t[-1]:.10g}"
    assert (
        f"The Jacobian of the right-hand side is NaN or infinite at t = {last}: check `jac`" in result.message
    )


@pytest.mark.parametrize(
    ("events", "message"),
    [
        (3, "events: expected a callable or a list of them, got int"),
        ([lambda t, y: y[0], 3], r"events\[1\]: expected a callable, got int"),
    ],
)
def test_wrong_events_are_named(events, message):
    with pytest.raises(TypeError, match=message):
        lissom.solve_ivp(decay, (0.0, 1.0), [1.0], events=events)


def test_wrong_directions_of_events_are_named():
    def event(t, y):
        return y[0]

    event.direction = "up"
    with pytest.raises(TypeError, match=r"events\[0\].direction: expected a real number, got str"):
        lissom.solve_ivp(decay, (0.0, 1.0), [1.0], events=event)


def test_extreme_numbers_in_messages_are_short():
    with pytest.raises(ValueError, match="max_step: got -1e-300, expected") as caught:
        lissom.solve_ivp(decay, (0.0, 1.0), [1.0], max_step=-1e-300)
    assert len(str(caught.value)) < 100
    result = lissom.solve_ivp(decay, (-1e300, 0.0), [1.0], max_steps=0)
    assert "was reached at t = -1e300, before" in result.message


class Unusual(Exception):
    """An exception with a payload."""


@pytest.mark.parametrize("method", METHODS)
def test_exceptions_come_back_unchanged(method):
    raised = Unusual("from the callback", 42)

    def failing(t, y):
        if t > 0.5:
            raise raised
        return y[0]

    for options in (
        {"events": failing},
        {"callback": failing},
        {"jac": lambda t, y: [[failing(t, y)]]} if method == "radau" else {"events": [failing]},
    ):
        with pytest.raises(Unusual) as caught:
            lissom.solve_ivp(lambda t, y: y**2, (0.0, 0.9), [1.0], method, **options)
        assert caught.value is raised
    with pytest.raises(Unusual) as caught:
        lissom.solve_ivp(failing, (0.0, 1.0), [1.0], method)
    assert caught.value is raised


@pytest.mark.parametrize("solver", CLASSES)
def test_a_step_that_raised_can_be_tried_again(solver):
    state = {"fails": False}

    def fun(t, y):
        if state["fails"]:
            raise Unusual
        return -y

    interrupted = solver(fun, 0.0, [1.0], 5.0)
    smooth = solver(decay, 0.0, [1.0], 5.0)
    while smooth.status == "running":
        state["fails"] = True
        with pytest.raises(Unusual):
            interrupted.step()
        state["fails"] = False
        interrupted.step()
        smooth.step()
        assert (interrupted.t, interrupted.y, interrupted.status) == (smooth.t, smooth.y, smooth.status)


@pytest.fixture
def ctrl_c_soon():
    """KeyboardInterrupt from a signal handler, as by Ctrl-C, because the test runner uses SIGINT."""

    def interrupt(*_):
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.1)
    yield
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.usefixtures("ctrl_c_soon")
@pytest.mark.parametrize("method", METHODS)
def test_ctrl_c_stops_a_python_callback(method):
    with pytest.raises(KeyboardInterrupt) as caught:
        lissom.solve_ivp(oscillator, (0.0, 1e9), [1.0, 0.0], method, t_eval=[0.0, 0.1, 1e9])
    kept = caught.value.result
    assert (kept.success, kept.reason, kept.t.tolist()) == (False, "interrupted", [0.0, 0.1])
    assert kept.y[0] == pytest.approx(np.cos(kept.t), abs=1e-2)


@pytest.mark.usefixtures("ctrl_c_soon")
def test_ctrl_c_stops_a_native_run():
    with pytest.raises(KeyboardInterrupt) as caught:
        lissom.solve_ivp(lissom.SpringPendulum(), (0.0, 1e9), [0.1, 0.1, 0.0, 0.0], t_eval=[0.5, 1e9])
    assert (caught.value.result.reason, caught.value.result.t.tolist()) == ("interrupted", [0.5])


@pytest.mark.usefixtures("ctrl_c_soon")
def test_ctrl_c_stops_builtin_functions():
    """No Python code runs that could handle the signal."""
    with pytest.raises(KeyboardInterrupt):
        lissom.solve_ivp(operator.truediv, (0.0, 1e9), [1.0], max_step=1.0, t_eval=[1e9])


# ------------------------------------------------------------------------------------------------- progress


@pytest.mark.parametrize("method", METHODS)
def test_the_callback_sees_every_step_and_can_stop(method):
    seen = []

    def watch(t, y):
        seen.append((t, y))

    result = lissom.solve_ivp(oscillator, (0.0, 10.0), [1.0, 0.0], method, callback=watch)
    np.testing.assert_array_equal([t for t, _ in seen], result.t[1:])
    np.testing.assert_array_equal(np.array([y for _, y in seen]).T, result.y[:, 1:])

    def stop(t, y):
        if t > 3.0:
            raise StopIteration
        return y  # without meaning, like all values but True

    for callback in (stop, lambda t, y: t > 3.0, lambda t, y: np.float64(t) > 3.0):
        result = lissom.solve_ivp(oscillator, (0.0, 10.0), [1.0, 0.0], method, callback=callback)
        assert (result.success, result.status, result.reason) == (False, -1, "interrupted")
        assert result.t[-2] <= 3.0 < result.t[-1] < 10.0


# ---------------------------------------------------------------------------------------------- controllers


@pytest.mark.parametrize("method", EXPLICIT)
def test_both_controllers_meet_the_tolerance(method):
    problem = reference.pendulum()
    for controller in ("I", "PI"):
        options = {"controller": controller, "rtol": 1e-8, "atol": 1e-8}
        result = lissom.solve_ivp(problem.fun, problem.t_span, problem.y0, method, **options)
        np.testing.assert_allclose(result.y, problem.exact(result.t), atol=1e-6)


def test_the_pi_controller_rejects_less_where_stability_limits_the_step():
    def stiff(t, y):
        return [-200.0 * (y[0] - np.cos(t))]

    rejected = {
        controller: lissom.solve_ivp(stiff, (0.0, 5.0), [1.0], controller=controller).nrejected
        for controller in ("I", "PI")
    }
    assert rejected["PI"] < 0.7 * rejected["I"]


@pytest.mark.parametrize("method", EXPLICIT)
def test_stiffness_is_noticed_and_the_remedy_named(method):
    problem = reference.van_der_pol(mu=1000.0)
    result = lissom.solve_ivp(problem.fun, (0.0, 5.0), problem.y0, method)
    assert result.success
    assert 0.0 < result.stiff_at < 5.0
    assert 'method="radau"' in result.message
    relaxed = lissom.solve_ivp(oscillator, (0.0, 3000.0), [1.0, 0.0], method, rtol=1e-8, t_eval=[])
    assert relaxed.naccepted > 2000
    assert relaxed.stiff_at is None


# ---------------------------------------------------------------------------------------------------- Radau


def test_every_kind_of_jacobian_gives_the_same_solution():
    problem = reference.robertson()
    options = {"method": "radau", "rtol": 1e-7, "atol": 1e-11, "t_eval": np.geomspace(1e-3, 1e5, 20)}

    def jac(t, y):
        return reference.robertson_jacobian(t, y)

    def vectorized(t, y):
        assert y.ndim == 2
        return problem.fun(t, y)

    pattern = [[1, 1, 1], [1, 1, 1], [0, 1, 0]]
    variants = {
        "differenced": lissom.solve_ivp(problem.fun, problem.t_span, problem.y0, **options),
        "callable": lissom.solve_ivp(problem.fun, problem.t_span, problem.y0, jac=jac, **options),
        "sparse": lissom.solve_ivp(
            problem.fun, problem.t_span, problem.y0, jac=lambda t, y: csc_matrix(jac(t, y)), **options
        ),
        "lists": lissom.solve_ivp(
            problem.fun, problem.t_span, problem.y0, jac=lambda t, y: jac(t, y).tolist(), **options
        ),
        "pattern": lissom.solve_ivp(problem.fun, problem.t_span, problem.y0, jac_sparsity=pattern, **options),
        "vectorized": lissom.solve_ivp(vectorized, problem.t_span, problem.y0, vectorized=True, **options),
    }
    for name, result in variants.items():
        assert result.success, name
        np.testing.assert_allclose(result.y, variants["callable"].y, rtol=1e-5, atol=1e-10)
        assert (result.nfev_jac > 0) == (name in ("differenced", "pattern", "vectorized"))
        assert result.njev > 0
        assert result.nlu > 0


def test_a_constant_jacobian_is_never_evaluated():
    matrix = np.array([[-1000.0, 999.0], [1.0, -2.0]])
    result = lissom.solve_ivp(lambda t, y: matrix @ y, (0.0, 3.0), [1.0, 0.0], "radau", jac=matrix, rtol=1e-8)
    assert (result.njev, result.nfev_jac) == (0, 0)
    np.testing.assert_allclose(result.y[:, -1], expm(3.0 * matrix) @ [1.0, 0.0], rtol=1e-4)


def test_a_system_too_large_for_dense_matrices_is_refused():
    with pytest.raises(ValueError, match=r"y0: got 1000000 values, .* takes 56000.0 GB"):
        lissom.solve_ivp(decay, (0.0, 1.0), np.zeros(1_000_000), "radau")


def test_a_jacobian_pattern_saves_evaluations():
    n = 60
    pattern = np.eye(n) + np.eye(n, k=1) + np.eye(n, k=-1)

    def diffusion(t, y):
        padded = np.concatenate([[0.0], y, [0.0]])
        return n * n * (padded[2:] - 2.0 * y + padded[:-2])

    y0 = np.sin(np.pi * np.arange(1, n + 1) / (n + 1))
    dense = lissom.solve_ivp(diffusion, (0.0, 0.1), y0, "radau")
    sparse = lissom.solve_ivp(diffusion, (0.0, 0.1), y0, "radau", jac_sparsity=csc_matrix(pattern))
    assert (dense.nfev_jac, sparse.nfev_jac) == (n * dense.njev, 3 * sparse.njev)
    np.testing.assert_allclose(sparse.y[:, -1], dense.y[:, -1], rtol=1e-6)


# --------------------------------------------------------------------------------------------------- models


def test_a_model_is_a_right_hand_side():
    pendulum = lissom.SpringPendulum(length=1.0, mass=1.0, stiffness=40.0, gravity=9.81)
    problem = reference.spring_pendulum()
    times = np.linspace(0.0, 10.0, 41)
    options = {"t_eval": times, "rtol": 1e-10, "atol": 1e-12}
    cartesian = lissom.solve_ivp(problem.fun, problem.t_span, problem.y0, "dop853", **options).y
    for method in METHODS:
        result = lissom.solve_ivp(pendulum, (0.0, 10.0), [0.0, 0.1, 0.0, 0.0], method, **options)
        assert result.success
        angle, elongation = result.y[:2]
        position = (1.0 + elongation) * np.array([np.cos(angle), np.sin(angle)])
        np.testing.assert_allclose(position, cartesian[:2], atol=1e-6)
        # Its Jacobian is exact.
        assert result.nfev_jac == 0
    energies = [pendulum.energy(y[:2], y[2:]).total for y in result.y.T]
    np.testing.assert_allclose(energies, energies[0], atol=1e-6)


def test_what_has_no_meaning_for_a_model_is_refused():
    pendulum = lissom.SpringPendulum()
    with pytest.raises(ValueError, match="y0: got 2 values, expected 4 values"):
        lissom.solve_ivp(pendulum, (0.0, 1.0), [0.0, 0.1])
    for options in ({"args": (1.0,)}, {"jac": np.eye(4), "method": "radau"}):
        with pytest.raises(TypeError, match="has no meaning for a model"):
            lissom.solve_ivp(pendulum, (0.0, 1.0), np.zeros(4), **options)


def test_models_integrate_side_by_side():
    pendulum = lissom.SpringPendulum()
    results = [None] * 4

    def run(index):
        results[index] = lissom.solve_ivp(pendulum, (0.0, 200.0), [0.0, 0.1, 0.0, 0.0], rtol=1e-8)

    threads = [threading.Thread(target=run, args=(index,)) for index in range(len(results))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for result in results[1:]:
        np.testing.assert_array_equal(result.y, results[0].y)


# --------------------------------------------------------------------------------------------- step by step


@pytest.mark.parametrize("solver", CLASSES)
@pytest.mark.parametrize("t_bound", [10.0, -10.0])
def test_stepping_is_what_solve_ivp_does(solver, t_bound):
    result = lissom.solve_ivp(oscillator, (0.0, t_bound), [1.0, 0.0], solver)
    stepper = solver(oscillator, 0.0, [1.0, 0.0], t_bound)
    assert (stepper.t_old, stepper.step_size, stepper.status) == (None, None, "running")
    assert (stepper.n, stepper.t_bound, stepper.direction) == (2, t_bound, np.sign(t_bound))
    for t_old, t, y in zip(result.t, result.t[1:], result.y.T[1:], strict=False):
        assert stepper.step() is None
        assert (stepper.t_old, stepper.t, stepper.step_size) == (t_old, t, abs(t - t_old))
        np.testing.assert_array_equal(stepper.y, y)
        np.testing.assert_allclose(stepper.dense_output()(t), y, rtol=1e-14, atol=5e-15)
        assert stepper.error_estimate().shape == (2,)
    assert stepper.status == "finished"
    assert (stepper.naccepted, stepper.nrejected) == (result.naccepted, result.nrejected)
    assert (stepper.njev, stepper.nlu, stepper.nfev_jac) == (result.njev, result.nlu, result.nfev_jac)
    with pytest.raises(RuntimeError, match="finished"):
        stepper.step()


@pytest.mark.parametrize("solver", CLASSES)
def test_the_last_step_outlives_a_failed_one(solver):
    stepper = solver(lambda t, y: [np.nan] if t > 0.3 else -y, 0.0, [1.0], 2.0)
    while stepper.status == "running":
        y_old, old = stepper.y, stepper.t_old
        if stepper.t > 0.0:
            before = stepper.error_estimate()
            sol = stepper.dense_output()
        stepper.step()
    assert stepper.status == "failed"
    np.testing.assert_array_equal(stepper.y, y_old)
    np.testing.assert_array_equal(stepper.error_estimate(), before)
    fresh = solver(lambda t, y: [np.nan] if t > 0.3 else -y, 0.0, [1.0], 2.0)
    while fresh.status == "running":
        fresh.step()
    # Evaluated only now.
    times = np.linspace(old, stepper.t, 5)
    np.testing.assert_array_equal(fresh.dense_output()(times), sol(times))


@pytest.mark.parametrize("solver", CLASSES)
def test_a_failed_stepper_says_why(solver):
    stepper = solver(lambda t, y: y**2, 0.0, [1.0], 2.0)
    message = None
    while stepper.status == "running":
        message = stepper.step()
    assert stepper.status == "failed"
    assert "singularity" in message
    for name in ("dense_output", "error_estimate"):
        fresh = solver(decay, 0.0, [1.0], 2.0)
        with pytest.raises(RuntimeError, match="after a successful step"):
            getattr(fresh, name)()


def test_a_stepper_cannot_be_used_inside_of_its_own_step():
    def fun(t, y):
        if steppers:
            steppers[0].step()
        return -y

    steppers = []
    steppers.append(lissom.RK45(fun, 0.0, [1.0], 1.0))
    with pytest.raises(RuntimeError, match="in the middle of a step"):
        steppers[0].step()


# ----------------------------------------------------------------------------------------------- properties

angles = st.floats(-2.0, 2.0)
states = st.tuples(angles, angles).map(np.array)


def swing(t, y):
    return np.array([y[1], -np.sin(y[0])])


TIGHT = {"rtol": 1e-10, "atol": 1e-11}


@given(states, st.sampled_from(METHODS), st.floats(0.5, 3.0))
def test_time_reversal_returns_to_the_start(y0, method, end):
    there = lissom.solve_ivp(swing, (0.0, end), y0, method, **TIGHT).y[:, -1]
    back = lissom.solve_ivp(swing, (end, 0.0), there, method, **TIGHT).y[:, -1]
    np.testing.assert_allclose(back, y0, atol=1e-7)


@given(states, st.sampled_from(METHODS), st.floats(0.05, 0.95))
def test_an_interval_can_be_split(y0, method, split):
    whole = lissom.solve_ivp(swing, (0.0, 3.0), y0, method, **TIGHT).y[:, -1]
    middle = lissom.solve_ivp(swing, (0.0, 3.0 * split), y0, method, **TIGHT).y[:, -1]
    halves = lissom.solve_ivp(swing, (3.0 * split, 3.0), middle, method, **TIGHT).y[:, -1]
    np.testing.assert_allclose(halves, whole, atol=1e-7)


@given(st.sets(st.integers(0, 60), min_size=1), st.sampled_from(METHODS), st.booleans())
def test_values_do_not_depend_on_what_else_is_asked_for(chosen, method, dense):
    times = np.linspace(0.0, 6.0, 61)
    every = lissom.solve_ivp(swing, (0.0, 6.0), [1.0, 0.0], method, t_eval=times)
    some = sorted(chosen)
    result = lissom.solve_ivp(swing, (0.0, 6.0), [1.0, 0.0], method, t_eval=times[some], dense_output=dense)
    np.testing.assert_array_equal(result.y, every.y[:, some])


@given(states, st.sampled_from(METHODS), st.floats(1e-9, 1e-3), st.floats(1e-9, 1e-3))
def test_a_scalar_tolerance_is_a_constant_vector(y0, method, rtol, atol):
    scalar = lissom.solve_ivp(swing, (0.0, 2.0), y0, method, rtol=rtol, atol=atol)
    vector = lissom.solve_ivp(swing, (0.0, 2.0), y0, method, rtol=[rtol, rtol], atol=np.full(2, atol))
    np.testing.assert_array_equal(scalar.t, vector.t)
    np.testing.assert_array_equal(scalar.y, vector.y)


@given(states, st.sampled_from(METHODS), st.integers(-8, 8))
def test_time_can_be_shifted(y0, method, shift):
    plain = lissom.solve_ivp(swing, (0.0, 2.0), y0, method, **TIGHT).y[:, -1]
    shifted = lissom.solve_ivp(swing, (float(shift), shift + 2.0), y0, method, **TIGHT).y[:, -1]
    np.testing.assert_allclose(shifted, plain, atol=1e-8)


@given(states, st.sampled_from(METHODS), st.floats(0.0, 6.3))
def test_linear_systems_commute_with_rotations(y0, method, angle):
    matrix = np.array([[-0.1, 1.0], [-2.0, -0.3]])
    rotation = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    rotated = rotation @ matrix @ rotation.T
    plain = lissom.solve_ivp(lambda t, y: matrix @ y, (0.0, 2.0), y0, method, **TIGHT).y[:, -1]
    other = lissom.solve_ivp(lambda t, y: rotated @ y, (0.0, 2.0), rotation @ y0, method, **TIGHT).y[:, -1]
    np.testing.assert_allclose(other, rotation @ plain, atol=1e-8)
    np.testing.assert_allclose(plain, expm(2.0 * matrix) @ y0, atol=1e-8)


@given(st.floats(0.1, 50.0), st.sampled_from(METHODS))
def test_powers_of_two_scale_out(scale, method):
    """Scaling state and absolute tolerance by a power of two changes nothing but the exponents."""
    factor = 2.0 ** round(np.log2(scale))
    matrix = np.array([[0.0, 1.0], [-1.0, -0.2]])
    options = {"jac": matrix} if method == "radau" else {}

    def run(size):
        return lissom.solve_ivp(
            lambda t, y: matrix @ y, (0.0, 5.0), [size, 0.0], method, atol=1e-6 * size, **options
        )

    plain, scaled = run(1.0), run(factor)
    np.testing.assert_array_equal(plain.t, scaled.t)
    np.testing.assert_array_equal(factor * plain.y, scaled.y)


def test_results_are_the_same_every_time():
    problem = reference.pleiades()
    for method in METHODS:
        first, second = (lissom.solve_ivp(problem.fun, (0.0, 1.0), problem.y0, method) for _ in range(2))
        np.testing.assert_array_equal(first.y, second.y)
