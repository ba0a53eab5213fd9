"""Equations whose solutions grow without bound: the message says so, of others it does not."""

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
