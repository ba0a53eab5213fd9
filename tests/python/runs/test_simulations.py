"""Many simulations stepped together: each equals a separate simulation."""

import copy
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lissom

COUNT = 7
#: Defined for one second.
MOVED = lissom.BaseMotion(axis=(0, 1, 0), angle=([0.0, 1.0], [0.0, 1.0]))


def swing(t):
    """A load that other processes find by name."""
    return (0.0, 0.0, 0.05 * np.sin(20.0 * t))


def arm(length=0.3, **changes):
    """A soft arm with two inputs."""
    soft = lissom.Segment(length, 0.01, 1e6, 4e5, 1000.0, {"bend_y": 2, "bend_z": 1}, retardation_time=0.01)
    tendons = [
        lissom.Tendon(name, [lissom.Along("rod", offset)], tension=lissom.Input(name))
        for name, offset in (("upper", (0.0, 0.008)), ("side", (0.008, 0.0)))
    ]
    return lissom.Rod([soft], actuators=tendons, **changes)


def starts(n, count=COUNT, seed=0):
    q0, v0 = 0.3 * np.random.default_rng(seed).standard_normal((2, count, n))
    return {"q0": q0, "v0": v0}


def tensions(steps, count=COUNT, seed=1):
    return np.random.default_rng(seed).uniform(0.0, 1.0, (steps, count, 2))


def singles(models, begin, **options):
    """A simulation for each row."""
    return [
        lissom.Simulation(model, q0=q0, v0=v0, **options)
        for model, q0, v0 in zip(models, begin["q0"], begin["v0"], strict=True)
    ]


def assert_same(many, alone):
    for name in ("t", "q", "v", "a", "u"):
        np.testing.assert_array_equal(getattr(many, name), [getattr(one, name) for one in alone], name)
    assert many.status == [one.status for one in alone]
    np.testing.assert_array_equal(many.success, [one.success for one in alone])
    assert [many.message(i) for i in range(len(many))] == [one.message for one in alone]


@pytest.mark.parametrize("workers", [1, 2, 5])
@pytest.mark.parametrize("method", ["newmark", "generalised_alpha", "radau", "rk45"])
def test_rows_are_simulations_to_the_bit(method, workers):
    model, options = arm(), {"dt": 2e-3, "method": method}
    begin = starts(model.n)
    many = lissom.Simulations(model, COUNT, workers=workers, **begin, **options)
    alone = singles([model] * COUNT, begin, **options)
    assert_same(many, alone)
    for i, u in enumerate(tensions(5)):
        # Short steps run in the calling thread, long ones in others.
        duration = (None, 0.05, 0.003)[i % 3]
        success = many.step(u, duration)
        expected = [one.step(row, duration) == "finished" for one, row in zip(alone, u, strict=True)]
        np.testing.assert_array_equal(success, expected)
    assert_same(many, alone)


def test_models_may_differ_from_row_to_row():
    models = [arm(length) for length in np.linspace(0.2, 0.4, COUNT)]
    begin = starts(models[0].n)
    many = lissom.Simulations(iter(models), dt=2e-3, **begin)
    assert many.models == tuple(models)
    alone = singles(models, begin, dt=2e-3)
    for u in tensions(3):
        many.step(u, 0.1)
        for one, row in zip(alone, u, strict=True):
            one.step(row, 0.1)
    assert_same(many, alone)


def test_one_vector_is_of_all_rows():
    model = arm()
    q0 = [0.1, -0.2, 0.3]
    many = lissom.Simulations(model, 3, dt=2e-3, q0=q0, t0=1.5)
    np.testing.assert_array_equal(many.q, [q0] * 3)
    np.testing.assert_array_equal(many.t, [1.5] * 3)
    many.step([0.5, 0.1], 0.2)
    one = lissom.Simulation(model, dt=2e-3, q0=q0, t0=1.5)
    one.step([0.5, 0.1], 0.2)
    assert_same(many, [one] * 3)


@settings(max_examples=20, deadline=None)
@given(
    which=st.lists(st.integers(-COUNT, COUNT - 1), unique_by=lambda i: i % COUNT, max_size=COUNT),
    is_mask=st.booleans(),
)
def test_some_rows_begin_again(which, is_mask):
    model = arm()
    begin = starts(model.n)
    many = lissom.Simulations(model, COUNT, dt=2e-3, **begin)
    alone = singles([model] * COUNT, begin, dt=2e-3)
    many.step(tensions(1)[0])
    for one, u in zip(alone, tensions(1)[0], strict=True):
        one.step(u)
    q0 = starts(model.n, len(which), seed=3)["q0"]
    chosen = which
    if is_mask:
        which = sorted(i % COUNT for i in which)
        chosen = np.isin(np.arange(COUNT), which)
    many.reset(chosen, q0=q0.reshape(len(which), model.n), t0=0.25)
    for i, q in zip(which, q0, strict=True):
        alone[i].reset(q0=q, t0=0.25)
    assert_same(many, alone)
    many.step(tensions(1, seed=5)[0])
    for one, u in zip(alone, tensions(1, seed=5)[0], strict=True):
        one.step(u)
    assert_same(many, alone)


def test_all_begin_again_as_they_began():
    model = arm()
    many = lissom.Simulations(model, COUNT, dt=2e-3, **starts(model.n))
    first = many.copy()
    many.step([0.3, 0.4], 0.1)
    many.reset()
    assert_same(many, list(first))


@pytest.mark.parametrize(
    "way", [lissom.Simulations.copy, copy.copy, copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))]
)
@pytest.mark.parametrize("method", ["newmark", "radau"])
def test_copies_go_on_to_the_bit(method, way):
    model = arm(loads=[lissom.Load(force=swing)])
    many = lissom.Simulations(model, COUNT, dt=2e-3, method=method, workers=3, **starts(model.n))
    many.step(tensions(1)[0], 0.02)
    other = way(many)
    assert (other.count, other.workers, len(other)) == (COUNT, 3, COUNT)
    assert_same(other, list(many))
    for u in tensions(3, seed=2):
        many.step(u, 0.05)
    assert (other.t < many.t).all()
    for u in tensions(3, seed=2):
        other.step(u, 0.05)
    assert_same(other, list(many))


def test_rows_are_handed_out_as_copies():
    model = arm()
    many = lissom.Simulations(model, COUNT, dt=2e-3, **starts(model.n))
    one, last = many[1], many[-1]
    assert one.model is model
    np.testing.assert_array_equal(last.q, many.q[COUNT - 1])
    one.step([1.0, 0.0])
    np.testing.assert_array_equal(many.t, np.zeros(COUNT))
    many.q[:] = 7.0
    assert np.abs(many.q).max() < 2.0
    for row in (COUNT, -COUNT - 1):
        with pytest.raises(IndexError, match=rf"row: got {row}, expected a row of {COUNT} simulations"):
            many[row]
        with pytest.raises(IndexError, match=rf"row: got {row}, expected a row of {COUNT} simulations"):
            many.message(row)


def test_a_row_that_fails_disturbs_no_other():
    model = lissom.SpringPendulum()
    begin = {"q0": np.tile([-0.7, 0.5], (5, 1)), "v0": np.zeros((5, 2))}
    begin["v0"][2] = 1e200
    many = lissom.Simulations(model, 5, dt=0.05, **begin)
    alone = singles([model] * 5, begin, dt=0.05)
    for duration in (0.05, 50.0):
        success = many.step(duration=duration)
        assert success.tolist() == [True, True, False, True, True]
        for one in alone:
            one.step(duration=duration)
        assert_same(many, alone)
    assert many.status[2] != "finished"
    assert len(many.message(2)) > 20
    many.reset([2], v0=[0.0, 0.0])
    assert many.step().all()


@pytest.mark.parametrize(
    ("arguments", "error", "match"),
    [
        ({"count": None}, TypeError, "count: missing, expected the number of rows"),
        ({"count": 0}, ValueError, "count: got 0, expected a whole number > 0"),
        ({"count": 10**12}, ValueError, "count: got 1000000000000, expected what fits in memory"),
        ({"workers": 0}, ValueError, "workers: got 0, expected a whole number > 0"),
        ({"q0": np.zeros((4, 3))}, ValueError, r"q0: expected shape \(3,\) or \(2, 3\), got \(4, 3\)"),
        ({"q0": np.zeros((2, 4))}, ValueError, r"q0: expected shape \(k, 3\), got \(2, 4\)"),
        ({"v0": [[0, 0, 0], [0, np.nan, 0]]}, ValueError, r"v0\[1, 1\]: got NaN, expected a finite number"),
        ({"dt": -1.0}, ValueError, "dt: got -1"),
        ({"method": "auto", "rtol": 0.5}, ValueError, "rtol: got 0.5"),
        ({"methud": "radau"}, TypeError, "methud"),
        ({"model": 3}, TypeError, "model: expected a Model .* or a sequence of them, got int"),
        ({"model": [], "count": None}, ValueError, "model: got 0 models, expected at least one"),
        ({"model": [arm()] * 3}, ValueError, "model: got 3 models, expected 2"),
        ({"model": [arm(), 3]}, TypeError, r"model\[1\]: expected a Model"),
        (
            {"model": [arm(), lissom.SpringPendulum()]},
            ValueError,
            r"model\[1\]: got 2 coordinates, expected 3",
        ),
        (
            {"model": [arm(), lissom.Rod([lissom.Segment(0.3, 0.01, 1e6, 4e5, 1e3, {"bend_y": 3})])]},
            ValueError,
            r'model\[1\]: got inputs \[\], expected \["upper", "side"\]',
        ),
        ({"model": [arm(), arm(base_motion=MOVED)], "t0": 2.0}, ValueError, r"row 1: .*within \[0, 1\]"),
    ],
)
def test_bad_arguments_are_refused(arguments, error, match):
    with pytest.raises(error, match=match):
        lissom.Simulations(**{"model": arm(), "count": 2, "dt": 2e-3} | arguments)


@pytest.mark.parametrize(
    ("which", "error", "match"),
    [
        ([0, 3], ValueError, r"which\[1\]: got 3, expected a row, from 0 to 2"),
        ([0, -3], ValueError, r"which\[1\]: row -3 is listed twice"),
        ([True, False], TypeError, r"which: expected a mask of shape \(3,\)"),
        ([[True, False, True]], TypeError, r"which: expected a mask of shape \(3,\)"),
        ([0.5], TypeError, r"which: expected a mask of shape \(3,\) or numbers of rows"),
        ("all", TypeError, r"which: expected a mask of shape \(3,\) or numbers of rows"),
    ],
)
def test_rows_that_do_not_exist_are_refused(which, error, match):
    many = lissom.Simulations(arm(), 3, dt=2e-3)
    with pytest.raises(error, match=match):
        many.reset(which)


@pytest.mark.parametrize(
    ("u", "match"),
    [
        ([0.0], r"u: expected 2 values, got 1"),
        (np.zeros((2, 2)), r"u: expected shape \(2,\) or \(3, 2\), got \(2, 2\)"),
        (np.zeros((3, 3)), r"u: expected shape \(k, 2\), got \(3, 3\)"),
        ([[0, 0], [0, np.inf], [0, 0]], r"u\[1, 1\]: got inf, expected a finite number"),
    ],
)
def test_inputs_that_make_no_sense_change_nothing(u, match):
    many = lissom.Simulations(arm(), 3, dt=2e-3)
    with pytest.raises(ValueError, match=match):
        many.step(u)
    assert many.status == ["ready"] * 3
    with pytest.raises(ValueError, match="duration: got -1"):
        many.step([1.0, 1.0], duration=-1.0)
    np.testing.assert_array_equal(many.u, np.zeros((3, 2)))


@pytest.mark.parametrize("count", [1, 40])
def test_exceptions_of_functions_come_through_and_it_goes_on(count):
    def load(t):
        if t > limit:
            raise ZeroDivisionError("here")
        return (0.0, 0.0, 0.01)

    limit = 0.05
    many = lissom.Simulations(arm(loads=[lissom.Load(force=load)]), count, dt=0.01, workers=3)
    with pytest.raises(ZeroDivisionError, match="here"):
        many.step(duration=0.1)
    assert many.t.max() == 0.05
    assert set(many.status) == {"interrupted"}
    limit = 1.0
    assert many.step(duration=0.02).all()


def test_a_function_that_asks_gets_an_answer():
    def load(t):
        if many is not None:
            try:
                many.step()
            except RuntimeError as error:
                answers.append(str(error))
        return (0.0, 0.0, 0.01)

    many, answers = None, []
    many = lissom.Simulations(arm(loads=[lissom.Load(force=load)]), 50, dt=0.01)
    assert many.step(duration=0.1).all()
    assert set(answers) == {"the simulations are in the middle of a step"}


def test_interrupts_end_long_steps():
    many = lissom.Simulations(arm(), 4, dt=1e-6, workers=2)
    threading.Timer(0.3, signal.raise_signal, [signal.SIGINT]).start()
    before = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        many.step(duration=1e3)
    assert time.perf_counter() - before < 5.0
    assert 0.0 < many.t.max() < 1e3
    assert many.step().all()


def test_a_forked_process_goes_on():
    """The threads of a pool would not exist after a fork."""
    code = """
import os, sys, warnings, numpy as np, lissom
warnings.simplefilter("ignore")
many = lissom.Simulations(lissom.SpringPendulum(), 50, dt=1e-3, workers=2)
many.step(duration=1.0)
child = os.fork()
many.step(duration=1.0)
if child == 0:
    os._exit(0 if (many.t == 2.0).all() else 1)
sys.exit(os.waitpid(child, 0)[1])
"""
    if not hasattr(__import__("os"), "fork"):
        pytest.skip("this system has no fork")
    assert subprocess.run([sys.executable, "-c", code], timeout=60).returncode == 0


def test_damaged_pickles_are_refused():
    restore, (rows, workers) = lissom.Simulations(arm(), 2, dt=2e-3).__reduce__()
    with pytest.raises(ValueError, match="expected at least one"):
        restore([], workers)
    with pytest.raises(ValueError, match="got 2 coordinates, expected 3"):
        restore([rows[0], lissom.Simulation(lissom.SpringPendulum(), dt=1e-3)], workers)
    assert repr(restore(rows, 2)) == "Simulations(count=2, n=3, workers=2)"
