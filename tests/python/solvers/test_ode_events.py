"""Events of `solve_ivp`: times and numbers of occurrences."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lissom

METHODS = ["rk45", "dop853", "radau"]
TIGHT = {"rtol": 1e-9, "atol": 1e-11}


def oscillator(t, y):
    return [y[1], -y[0]]


def event(function, terminal=None, direction=None):
    def wrapped(t, y):
        return function(t, y)

    if terminal is not None:
        wrapped.terminal = terminal
    if direction is not None:
        wrapped.direction = direction
    return wrapped


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("t_end", [20.0, -20.0])
@pytest.mark.parametrize("direction", [-1, 0, 1])
def test_zeros_of_a_sine(method, t_end, direction):
    crossing = event(lambda t, y: y[0], direction=direction)
    result = lissom.solve_ivp(oscillator, (0.0, t_end), [0.0, 1.0], method, events=crossing, **TIGHT)
    (times,) = result.t_events
    (states,) = result.y_events
    # sin(t) rises at even multiples of pi in either direction of time; the zero at the start is not an event.
    multiples = np.arange(1, 7) * np.sign(t_end)
    if direction:
        # Forward, sin t rises at even multiples of pi; backward it falls there.
        even = direction == np.sign(t_end)
        multiples = multiples[(multiples % 2 == 0) == even]
    np.testing.assert_allclose(times, multiples * np.pi, atol=1e-7)
    assert states.shape == (times.size, 2)
    np.testing.assert_allclose(states[:, 0], 0.0, atol=1e-14)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("terminal", [True, 1, 2, 4])
def test_the_integration_ends_at_the_wanted_occurrence(method, terminal):
    crossing = event(lambda t, y: y[0], terminal=terminal)
    options = {"events": crossing, "dense_output": True, **TIGHT}
    result = lissom.solve_ivp(oscillator, (0.0, 100.0), [1.0, 0.0], method, **options)
    assert (result.success, result.status, result.reason) == (True, 1, "event")
    assert result.message == "A termination event occurred."
    assert result.t_events[0].size == terminal
    assert result.t[-1] == result.t_events[0][-1] == result.sol.t_max
    np.testing.assert_array_equal(result.y[:, -1], result.y_events[0][-1])
    np.testing.assert_array_equal(result.sol(result.t[-1]), result.y[:, -1])
    times = np.linspace(0.0, result.t[-1], 50)
    np.testing.assert_allclose(result.sol(times)[0], np.cos(times), atol=1e-7)


@pytest.mark.parametrize("terminal", [-1, 1.5, "often", np.nan])
def test_a_meaningless_terminal_is_refused(terminal):
    with pytest.raises(ValueError, match=r"events\[0\]: The `terminal` attribute of each event must be"):
        lissom.solve_ivp(oscillator, (0.0, 1.0), [1.0, 0.0], events=event(lambda t, y: 1.0, terminal))


@pytest.mark.parametrize("terminal", [None, False, 0])
def test_an_event_need_not_be_terminal(terminal):
    result = lissom.solve_ivp(
        oscillator, (0.0, 10.0), [1.0, 0.0], events=event(lambda t, y: y[0], terminal=terminal)
    )
    assert result.reason == "finished"
    assert result.t_events[0].size == 3


def test_points_asked_for_after_a_terminal_event_are_left_out():
    stop = event(lambda t, y: y[0], terminal=True)
    times = np.linspace(0.0, 3.0, 31)
    result = lissom.solve_ivp(oscillator, (0.0, 3.0), [1.0, 0.0], t_eval=times, events=stop, **TIGHT)
    np.testing.assert_array_equal(result.t, times[times <= np.pi / 2])
    result = lissom.solve_ivp(oscillator, (0.0, 3.0), [1.0, 0.0], t_eval=[2.0, 3.0], events=stop)
    assert result.t.shape == (0,)
    assert result.y.shape == (2, 0)


@pytest.mark.parametrize("method", METHODS)
def test_two_zeros_in_one_step_are_found(method):
    """The state is linear, hence the steps are huge; SciPy finds none of them."""
    narrow = event(lambda t, y: (y[0] - 41.3) * (y[0] - 47.9))
    options = {"first_step": 50.0, "events": narrow}
    result = lissom.solve_ivp(lambda t, y: [1.0], (0.0, 100.0), [0.0], method, **options)
    assert result.naccepted <= 3
    np.testing.assert_allclose(result.t_events[0], [41.3, 47.9], rtol=1e-12)
    ends_only = lissom.solve_ivp(lambda t, y: [1.0], (0.0, 100.0), [0.0], method, event_samples=1, **options)
    assert ends_only.t_events[0].size == 0


@pytest.mark.parametrize("method", METHODS)
def test_several_events_in_one_step_come_in_order(method):
    """The first terminal event ends the integration, also if others are listed before it."""
    levels = [70.0, 10.0, 30.0, 50.0]
    events = [event(lambda t, y, level=level: y[0] - level, terminal=level == 50.0) for level in levels]
    options = {"first_step": 80.0, "events": events}
    result = lissom.solve_ivp(lambda t, y: [1.0], (0.0, 100.0), [0.0], method, **options)
    assert result.reason == "event"
    assert result.t[-1] == pytest.approx(50.0, rel=1e-14)
    assert [times.size for times in result.t_events] == [0, 1, 1, 1]
    assert [states.shape for states in result.y_events] == [(0,), (1, 1), (1, 1), (1, 1)]


def test_a_zero_at_a_step_is_counted_once():
    options = {"first_step": 0.25, "max_step": 0.25, "events": event(lambda t, y: t - 0.5)}
    result = lissom.solve_ivp(lambda t, y: [1.0], (0.0, 1.0), [0.0], **options)
    assert result.t_events[0].tolist() == [0.5]


def test_touching_zero_is_counted_only_where_it_is_seen():
    """A double zero at the end of a step counts once; one between samples cannot be detected."""
    options = {"first_step": 0.25, "max_step": 0.25}
    seen = event(lambda t, y: (t - 0.5) ** 2)
    result = lissom.solve_ivp(lambda t, y: [1.0], (0.0, 1.0), [0.0], events=seen, **options)
    assert result.t_events[0].tolist() == [0.5]


def test_a_function_that_is_always_zero_never_happens():
    result = lissom.solve_ivp(
        oscillator, (0.0, 10.0), [1.0, 0.0], events=event(lambda t, y: 0.0, terminal=True)
    )
    assert result.reason == "finished"
    assert result.t_events[0].size == 0


def test_a_bouncing_ball_can_be_restarted_at_its_events():
    """An integration that starts at an event does not find it again: the ball leaves the ground."""
    ground = event(lambda t, y: y[0], terminal=True, direction=-1)
    t, y, hits = 0.0, [1.0, 0.0], []
    for _ in range(4):
        result = lissom.solve_ivp(lambda t, y: [y[1], -9.81], (t, t + 10.0), y, events=ground, **TIGHT)
        t = result.t[-1]
        hits.append(t)
        y = [0.0, -0.8 * result.y[1, -1]]
    fall = np.sqrt(2.0 / 9.81)
    expected = fall * np.cumsum([1.0, *(2.0 * 0.8**k for k in (1, 2, 3))])
    np.testing.assert_allclose(hits, expected, rtol=1e-7)


def test_events_that_are_not_numbers_are_named():
    for value in (None, "high", [1.0, 2.0], 1j):
        with pytest.raises(TypeError, match=r"events\[1\]: expected a real number, got"):
            lissom.solve_ivp(
                oscillator, (0.0, 1.0), [1.0, 0.0], events=[lambda t, y: 1.0, lambda t, y, value=value: value]
            )


def test_an_event_that_is_not_a_number_for_a_while_is_passed_over():
    def root(t, y):
        return np.sqrt(y[0]) - 0.5 if y[0] >= 0.0 else np.nan

    result = lissom.solve_ivp(oscillator, (0.0, 6.0), [1.0, 0.0], events=root, **TIGHT)
    np.testing.assert_allclose(result.t_events[0], [np.arccos(0.25), 2 * np.pi - np.arccos(0.25)], rtol=1e-6)


def test_no_events_and_an_empty_list_of_them():
    assert lissom.solve_ivp(oscillator, (0.0, 1.0), [1.0, 0.0]).t_events is None
    result = lissom.solve_ivp(oscillator, (0.0, 1.0), [1.0, 0.0], events=[])
    assert result.t_events == result.y_events == []


@given(st.lists(st.floats(0.01, 0.99), min_size=1, max_size=6, unique=True), st.sampled_from(METHODS))
def test_every_level_of_a_monotone_solution_is_found(levels, method):
    events = [event(lambda t, y, level=level: y[0] - level) for level in levels]
    result = lissom.solve_ivp(lambda t, y: -y, (0.0, 6.0), [1.0], method, events=events, **TIGHT)
    for level, times in zip(levels, result.t_events, strict=True):
        np.testing.assert_allclose(times, [-np.log(level)], rtol=1e-5)


# --------------------------------------------------------------------------------------------- units of time

UNITS = [1e-15, 1e-12, 1e-6, 1e3, 1e9, 1e15]


def swing_in_units(unit, method, *, start=0.0, sign=1.0, **options):
    """A damped and driven swing for 20 units of time, with events of every kind."""

    def fun(t, y):
        time = t / unit - start
        return [y[1] / unit, (-np.sin(y[0]) - 0.1 * y[1] + 0.3 * np.cos(0.7 * time)) / unit]

    events = [
        event(lambda t, y: y[0]),
        event(lambda t, y: y[1], direction=-1),
        event(lambda t, y: y[1] - 0.2, direction=1),
        # A time as far below the steps as the spacing of numbers.
        event(lambda t, y: t / unit - start - sign * 1e-9),
        event(lambda t, y: y[0] - y[1], terminal=3),
    ]
    t_span = (start * unit, (start + 20.0 * sign) * unit)
    # The choice of the first step has a unit of time, as that of SciPy.
    options = {"first_step": 0.01 * unit} | options
    return lissom.solve_ivp(fun, t_span, [1.0, 0.0], method, events=events, **options)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("rtol", [1e-3, 1e-8])
def test_events_do_not_depend_on_the_unit_of_time(method, sign, rtol):
    def run(unit):
        # Jacobians by differences would turn the rounding of other units into changes of 1e-8.
        jac = {"jac": lambda t, y: np.array([[0.0, 1.0], [-np.cos(y[0]), -0.1]]) / unit}
        options = jac if method == "radau" else {}
        return swing_in_units(unit, method, sign=sign, rtol=rtol, **options)

    seconds = run(1.0)
    assert seconds.reason == "event"
    assert min(times.size for times in seconds.t_events) > 0
    np.testing.assert_allclose(seconds.t_events[3], [sign * 1e-9], rtol=1e-14)
    for unit in UNITS:
        scaled = run(unit)
        assert scaled.reason == "event"
        for times, in_seconds in zip(scaled.t_events, seconds.t_events, strict=True):
            # Weights of up to 43 in DOP853 magnify the rounding of times in other units.
            np.testing.assert_allclose(times / unit, in_seconds, rtol=1e-11)
        for states, expected in zip(scaled.y_events, seconds.y_events, strict=True):
            np.testing.assert_allclose(states, expected, rtol=0.0, atol=1e-10)
        assert scaled.nfev == seconds.nfev


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("power", [-50, -20, 7, 50])
def test_powers_of_two_of_the_unit_of_time_change_exponents_only(method, power):
    unit = 2.0**power
    seconds, scaled = swing_in_units(1.0, method), swing_in_units(unit, method)
    np.testing.assert_array_equal(scaled.t, unit * seconds.t)
    np.testing.assert_array_equal(scaled.y, seconds.y)
    for times, in_seconds in zip(scaled.t_events, seconds.t_events, strict=True):
        np.testing.assert_array_equal(times, unit * in_seconds)


@pytest.mark.parametrize("method", METHODS)
def test_events_late_in_time_are_as_accurate_as_numbers_there(method):
    """At 1e6 units, numbers are 1e-10 apart."""
    early = swing_in_units(1.0, method, rtol=1e-6)
    for unit in (1e-12, 1.0, 1e12):
        late = swing_in_units(unit, method, start=1e6, rtol=1e-6)
        for k in (0, 1, 2, 4):
            np.testing.assert_allclose(late.t_events[k] / unit - 1e6, early.t_events[k], rtol=0.0, atol=3e-9)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("unit", [1e-12, 1.0, 1e12])
def test_an_event_at_time_zero(method, unit):
    """Within an integration, and at its start, where it does not count."""

    def fun(t, y):
        return [1.0 / unit]

    clock = event(lambda t, y: t)
    result = lissom.solve_ivp(fun, (-0.7 * unit, unit), [0.0], method, events=clock)
    np.testing.assert_allclose(result.t_events[0], [0.0], rtol=0.0, atol=1e-30 * unit)
    result = lissom.solve_ivp(fun, (0.0, unit), [0.0], method, events=clock)
    assert result.t_events[0].size == 0
