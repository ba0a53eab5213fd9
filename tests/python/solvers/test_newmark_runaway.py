"""Equations whose solutions grow without bound, and steps that let others grow: messages tell them apart."""

import numpy as np
import pytest

import lissom

#: Equations and the times at which their solutions from q = 1 at rest are infinite.
BEYOND = {
    "a power": (lambda t, q, v, a: a - 6 * q**2, 1.2144),
    "an exponential": (lambda t, q, v, a: a - np.exp(q), 1.3472),
    "only one of two": (lambda t, q, v, a: [a[0] + q[0], a[1] - 6 * q[1] ** 2], 1.2144),
}


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("equation", BEYOND)
@pytest.mark.parametrize("adaptive", [False, True])
def test_motions_that_run_away_are_called_so(equation, adaptive):
    residual, end = BEYOND[equation]
    n = 2 if equation == "only one of two" else 1
    motion = lissom.newmark(residual, (0.0, 10.0), np.ones(n), np.zeros(n), dt=0.01, adaptive=adaptive)
    assert not motion.success
    assert abs(motion.t[-1] - end) < 0.05
    assert motion.message.startswith("The motion grows without bound: from t = ")
    assert f"the velocity of coordinate {n - 1} grows by a factor of " in motion.message


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_growth_until_overflow_is_called_so():
    motion = lissom.newmark(lambda t, q, v, a: a - 100.0 * q, (0.0, 100.0), [1.0], [0.0], dt=0.01)
    assert motion.message.startswith("The motion grows without bound")


def stops_at(t, q, v, a):
    """An oscillator whose equations end at t = 1."""
    return a + 4.0 * q if t < 1.0 else a * np.nan


def hits_a_wall(t, q, v, a):
    """Falls on something that no step resolves."""
    return a + 9.81 - (1e12 * np.sign(-q) if q < 0.0 else 0.0)


@pytest.mark.parametrize("residual", [stops_at, hits_a_wall])
def test_other_failures_are_not(residual):
    motion = lissom.newmark(residual, (0.0, 2.0), [1.0], [0.0], dt=0.01)
    assert not motion.success
    assert "without bound" not in motion.message


def test_growth_that_does_not_fail_is_not_reported():
    motion = lissom.newmark(lambda t, q, v, a: a - 9.0 * q, (0.0, 4.0), [1.0], [0.0], dt=0.01)
    assert motion.success
    assert motion.v[-1, 0] > 1e4
    assert motion.message == "The end of the interval was reached."


#: Conditionally stable methods and their limits: largest `omega dt`.
LIMITS = {"central_difference": 2.0, "linear_acceleration": 12**0.5, "fox_goodwin": 6**0.5}
OMEGA = 100.0


def vibration(damping=0.0, force=lambda t: 0.0):
    return lambda t, q, v, a: a + damping * v + OMEGA**2 * q - force(t)


@pytest.mark.parametrize("method", LIMITS)
@pytest.mark.parametrize("damping", [0.0, 10.0, 1e3])
@pytest.mark.parametrize("at_end", [False, True])
def test_steps_beyond_the_limit_are_unstable(method, damping, at_end):
    """Also where the result has the end alone, and where the last step is a shorter one."""
    dt = 1.4 * LIMITS[method] / OMEGA
    end = 250.5 * dt
    motion = lissom.newmark(
        vibration(damping), (0.0, end), [1.0], [0.0], dt=dt, method=method, t_eval=[end] if at_end else None
    )
    assert (motion.status, motion.success) == ("unstable", False)
    assert motion.message.startswith(
        "The steps are unstable: coordinate 0 changes its sign with each of them"
    )
    assert f"only for step sizes below {LIMITS[method]:.4f} / (largest natural" in motion.message
    assert abs(motion.q[-1, 0]) > 1e3
    stable = lissom.newmark(vibration(damping), (0, 5), [1.0], [0.0], dt=dt, method="average_acceleration")
    assert stable.success
    assert np.abs(stable.q).max() <= 1.0 + 1e-9


@pytest.mark.parametrize("method", LIMITS)
def test_the_growth_that_is_said_is_that_of_the_states(method):
    dt = 1.2 * LIMITS[method] / OMEGA
    motion = lissom.newmark(vibration(), (0.0, 60 * dt), [1.0], [0.0], dt=dt, method=method)
    factor = abs(motion.q[-1, 0] / motion.q[-2, 0])
    assert f"grows by a factor of {factor:.3f}, until t = " in motion.message


@pytest.mark.parametrize("method", LIMITS)
def test_steps_within_the_limit_finish(method):
    dt = 0.98 * LIMITS[method] / OMEGA
    for residual in (vibration(), vibration(1.0, lambda t: 1e4 * np.sin(OMEGA * t)), vibration(0.0, np.sign)):
        motion = lissom.newmark(residual, (0.0, 400 * dt), [1.0], [0.0], dt=dt, method=method)
        assert motion.status == "finished", motion.message


GROWS_BY_ITSELF = {
    "an exponential": lambda t, q, v, a: a - q,
    "a vibration in a dozen steps a period": lambda t, q, v, a: a - 0.4 * v + 25.0 * q,
    "bounces": lambda t, q, v, a: a + 1e3 * q * (q > 0.0) - 9.81,
    "noise in each step": lambda t, q, v, a: a - np.random.default_rng(int(1e6 * t)).normal(),
}


@pytest.mark.parametrize("equation", GROWS_BY_ITSELF)
def test_motions_that_grow_by_themselves_are_not_unstable(equation):
    residual = GROWS_BY_ITSELF[equation]
    motion = lissom.newmark(residual, (0.0, 200.0), [1.0], [0.0], dt=0.05, method="central_difference")
    assert motion.status == "finished", motion.message


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_overflow_of_unstable_steps_is_no_fault_of_the_equations():
    stiff = np.array([[2e4, -1e4], [-1e4, 1e4]])
    start = ([1.0, 0.0], [0.0, 0.0])
    motion = lissom.newmark(
        lambda t, q, v, a: a + stiff @ q, (0, 100), *start, dt=0.017, method="central_difference"
    )
    assert motion.status == "unstable"
    assert "without bound" not in motion.message
