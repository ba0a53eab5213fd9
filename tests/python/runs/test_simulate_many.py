"""Ensembles: each row equals a run of `simulate`, and rows do not affect each other."""

import copy
import os
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

COUNT = 5
T_END = 0.05
METHODS = {
    "newmark": {"dt": 2e-3},
    "hht": {"method": "hht", "alpha": -0.2, "dt": 3e-3},
    "generalised_alpha": {"method": "generalised_alpha", "dt": 2e-3},
    "adaptive": {"adaptive": True, "dt": 2e-3, "t_eval": [0.0, 0.011, T_END]},
    "radau": {"method": "radau", "dt": 1e-2},
    "rk45": {"method": "rk45", "dt": 1e-2},
    "dop853": {"method": "dop853", "t_eval": [0.01, 0.03]},
    "auto": {"method": "auto", "rtol": 1e-3, "dt": 1e-2},
}


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


def wire(gravity=0.0):
    """A stiff wire, in equilibrium when straight."""
    steel = lissom.Segment(0.4, 1e-3, 2e11, 8e10, 7800, {"bend_y": 3})
    return lissom.Rod([steel], gravity=(0, 0, -gravity))


def starts(n, count=COUNT, seed=0):
    q0, v0 = 0.3 * np.random.default_rng(seed).standard_normal((2, count, n))
    return {"q0": q0, "v0": v0}


def assert_row(result, row, alone):
    """A row is bitwise equal to a run."""
    m = len(alone.t)
    np.testing.assert_array_equal(result.t[:m], alone.t)
    for name in ("q", "v"):
        np.testing.assert_array_equal(getattr(result, name)[row, :m], getattr(alone, name))
        assert np.isnan(getattr(result, name)[row, m:]).all()
    assert (result.status[row], result.message[row]) == (alone.status, alone.message)
    assert (result.success[row], result.doubt[row]) == (alone.success, alone.doubt)
    assert list(result.slack[row]) == alone.slack
    np.testing.assert_equal(result.reached[row], alone.t[-1] if m else np.nan)
    for name, values in result.stats.items():
        if name != "wall_time":
            expected = getattr(alone.stats, name)
            np.testing.assert_equal(values[row], np.nan if expected is None else expected)


@pytest.mark.parametrize("workers", [1, 2, 5])
@pytest.mark.parametrize("options", METHODS.values(), ids=METHODS)
def test_rows_are_runs_to_the_bit(options, workers):
    model = arm()
    begin = starts(model.n)
    result = lissom.simulate_many(model, T_END, workers=workers, **begin, **options)
    assert result.success.all()
    for row in range(COUNT):
        start = {name: values[row] for name, values in begin.items()}
        assert_row(result, row, lissom.simulate(model, T_END, **start, **options))


def test_each_row_may_have_a_model():
    models = [arm(length) for length in (0.2, 0.3, 0.4)]
    result = lissom.simulate_many(iter(models), T_END, q0=[0.1, 0.2, 0.3], dt=2e-3, t0=0.01)
    for row, model in enumerate(models):
        assert_row(result, row, lissom.simulate(model, T_END, q0=[0.1, 0.2, 0.3], dt=2e-3, t0=0.01))


@pytest.mark.parametrize("method", ["newmark", "radau", "rk45"])
def test_inputs_are_held_as_by_control(method):
    model, options = arm(), {"method": method, "dt": 2e-3}
    held = np.random.default_rng(2).uniform(0, 1, (COUNT, 2))
    result = lissom.simulate_many(model, T_END, u=held, **options)
    for row, u in enumerate(held):
        alone = lissom.simulate(model, T_END, control=lambda *_, u=u: u, control_step=T_END, **options)
        assert_row(result, row, alone)
    for_all = lissom.simulate_many(model, T_END, u=held[0], q0=np.zeros((2, 3)), **options)
    np.testing.assert_array_equal(for_all.q, result.q[[0, 0]])


@given(steps=st.integers(1, 7), dt=st.floats(1e-3, 0.03), t0=st.sampled_from([0.0, -0.3, 1.1]))
@settings(max_examples=30, deadline=None)
def test_inputs_in_steps_are_those_of_control(steps, dt, t0):
    pull = lissom.Load(force=lissom.Input("push", (0, 0, 0)))
    wire = lissom.Segment(0.4, 1e-3, 2e11, 8e10, 7800, {"bend_y": 1}, retardation_time=1e-2)
    rod = lissom.Rod([wire], loads=[pull])
    u = np.random.default_rng(steps).uniform(-0.1, 0.1, (2, steps, 3))
    step = 0.1 / steps
    result = lissom.simulate_many(rod, t0 + 0.1, t0=t0, u=u, control_step=step, dt=dt)
    for row in range(2):
        calls = iter(u[row])
        alone = lissom.simulate(
            rod, t0 + 0.1, t0=t0, control=lambda *_, calls=calls: next(calls), control_step=step, dt=dt
        )
        assert next(calls, None) is None
        assert len(alone.t) == len(result.t)
        assert_row(result, row, alone)


@pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")
@given(t0=st.floats(-2, 2), duration=st.floats(0, 1), dt=st.floats(1e-3, 2))
@settings(max_examples=60, deadline=None)
def test_times_are_those_of_a_run(t0, duration, dt):
    for method in ("newmark", "rk45"):
        alone = lissom.simulate(
            lissom.SpringPendulum(), t0 + duration, t0=t0, dt=dt, method=method, v0=[0.1, 0]
        )
        many = lissom.simulate_many(
            lissom.SpringPendulum(), t0 + duration, t0=t0, dt=dt, method=method, v0=[[0.1, 0]]
        )
        np.testing.assert_array_equal(many.t[: len(alone.t)], alone.t)
        assert len(many.t) == len(alone.t) or not alone.success


def test_the_last_states_and_a_summary_are_those_of_all_states():
    model, begin = arm(), starts(3, 300)
    options = begin | {"dt": 2e-3, "places": [0.1, 0.3]}
    every = lissom.simulate_many(model, T_END, **options)
    final = lissom.simulate_many(model, T_END, keep="final", **options)
    summary = lissom.simulate_many(model, T_END, keep="summary", **options)
    for result in (final, summary):
        for name in ("q", "v", "poses"):
            np.testing.assert_array_equal(getattr(result, name), getattr(every, name)[:, -1])
        np.testing.assert_array_equal(result.reached, T_END)
    assert final.nbytes < summary.nbytes < every.nbytes
    np.testing.assert_array_equal(summary.lowest, every.q.min(axis=1))
    np.testing.assert_array_equal(summary.highest, every.q.max(axis=1))
    positions = every.poses[..., :3, 3]
    np.testing.assert_allclose(summary.mean, positions.mean(axis=0), rtol=0, atol=1e-15)
    np.testing.assert_allclose(summary.variance, positions.var(axis=0, ddof=1), rtol=1e-10, atol=1e-18)
    assert (every.lowest, every.mean, final.highest, final.variance) == (None,) * 4


@pytest.mark.parametrize("workers", [2, 5])
def test_a_summary_has_the_same_bits_for_any_number_of_threads(workers):
    options = starts(3, 400) | {"dt": 5e-3, "keep": "summary"}
    one = lissom.simulate_many(arm(), T_END, workers=1, **options)
    many = lissom.simulate_many(arm(), T_END, workers=workers, **options)
    for name in ("q", "v", "poses", "lowest", "highest", "mean", "variance"):
        np.testing.assert_array_equal(getattr(one, name), getattr(many, name))


def test_poses_are_those_of_the_model():
    robot = lissom.Robot(
        [
            lissom.Link("base", joint=lissom.Revolute((0, 1, 0)), body=lissom.Body(0.1)),
            lissom.Link("arm", parent="base", rod=[lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000, {"bend_y": 2})]),
        ],
        base_motion=lissom.BaseMotion(translation=lissom.Harmonic((0.0, 0.0, 0.01), 2.0)),
    )
    places = ["base", "arm", ("arm", 0.1)]
    result = lissom.simulate_many(robot, T_END, q0=0.1 * np.eye(3), dt=5e-3, places=places)
    assert result.poses.shape == (3, 11, 3, 4, 4)
    for row, q in enumerate(result.q):
        for i, (link, X) in enumerate([("base", None), ("arm", None), ("arm", 0.1)]):
            np.testing.assert_array_equal(
                result.poses[row, :, i], robot.pose(q, X, link=link, t=result.t), f"{link} {X}"
            )
    tip = lissom.simulate_many(robot, T_END, q0=0.1 * np.eye(3), dt=5e-3, keep="summary")
    np.testing.assert_array_equal(tip.poses[:, 0], result.poses[:, -1, 1])


def test_the_mass_of_a_pendulum_is_its_tip():
    pendulum = lissom.SpringPendulum()
    every = lissom.simulate_many(pendulum, 0.1, v0=[[0.1, 0.0], [0.3, 0.0]])
    summary = lissom.simulate_many(pendulum, 0.1, v0=[[0.1, 0.0], [0.3, 0.0]], keep="summary")
    assert every.poses is None
    assert summary.mean.shape == (11, 1, 3)
    assert np.ptp(summary.poses[:, 0, :3, 3], axis=0).max() > 1e-3


def test_a_run_that_fails_is_a_row_with_its_status():
    model = arm(loads=[lissom.Load(force=([0.0, 0.02, 0.021], [(0, 0, 0), (0, 0, 0), (0, 0, 1e300)]))])
    good = arm(loads=[lissom.Load(force=([0.0, 1.0], [(0, 0, 0), (0, 0, 0.1)]))])
    models = [good, model, good]
    # Steps end at the corners of tables, which differ: the times are those that all share.
    options = {"dt": 2e-3, "t_eval": np.linspace(0.0, T_END, round(T_END / 2e-3) + 1)}
    result = lissom.simulate_many(models, T_END, workers=2, places=[0.3], dt=2e-3)
    np.testing.assert_allclose(result.t, options["t_eval"])
    assert result.success.tolist() == [True, False, True]
    for row, one in enumerate(models):
        assert_row(result, row, lissom.simulate(one, T_END, **options))
    assert 0 < result.reached[1] < T_END
    assert np.isnan(result.poses[1, -1]).all()
    final = lissom.simulate_many(models, T_END, keep="final", **options)
    known = int(np.searchsorted(result.t, result.reached[1]))
    np.testing.assert_array_equal(final.q[1], result.q[1, known])
    summary = lissom.simulate_many(models, T_END, keep="summary", **options)
    alone = lissom.simulate_many(good, T_END, places=[0.3], **options)
    np.testing.assert_array_equal(summary.mean, alone.poses[0, :, :, :3, 3])
    np.testing.assert_array_equal(summary.variance, 0)


def test_too_large_a_step_is_a_row_that_failed():
    stiff = wire()
    v0 = np.zeros((3, 3))
    v0[1] = 1e5
    result = lissom.simulate_many(stiff, 0.1, v0=v0, dt=0.05, rtol=1e-9)
    alone = lissom.simulate(stiff, 0.1, v0=v0[1], dt=0.05, rtol=1e-9)
    assert not alone.success
    assert_row(result, 1, alone)
    assert result.success.tolist() == [True, False, True]


def test_slack_tendons_and_doubts_are_told_of_each_row():
    result = lissom.simulate_many(arm(), T_END, u=[[0.0, 1.0], [-1.0, 1.0]], dt=2e-3)
    assert result.slack == ((), ("upper",))
    assert "upper" in result.message[1]
    with pytest.warns(lissom.AccuracyWarning, match=r"^1 of 2 runs: "):
        result = lissom.simulate_many([wire(), wire(9.81)], 0.1, dt=0.05)
    with pytest.warns(lissom.AccuracyWarning):
        alone = lissom.simulate(wire(9.81), 0.1, dt=0.05)
    assert result.doubt == (None, alone.doubt)


@pytest.mark.parametrize("keep", ["states", "final", "summary"])
def test_no_rows_are_an_empty_result(keep):
    result = lissom.simulate_many(arm(), 0.1, q0=np.zeros((0, 3)), keep=keep, places=[0.1])
    assert len(result) == 0
    assert result.q.shape == ((0, 11, 3) if keep == "states" else (0, 3))
    assert result.status.shape == (0,)
    if keep == "summary":
        assert np.isnan(result.mean).all()
        assert result.mean.shape == (11, 1, 3)


def test_a_robot_without_coordinates_has_rows_too():
    plate = lissom.Robot([lissom.Link("plate", body=lissom.Body(1.0))])
    result = lissom.simulate_many(plate, 0.1, q0=np.zeros((3, 0)), places=["plate"])
    assert result.success.all()
    assert result.q.shape == (3, 11, 0)
    np.testing.assert_array_equal(result.poses[1, 5, 0], np.eye(4))


REFUSED = {
    "count of starts": ({"v0": np.zeros((3, 3))}, "v0: got 3 rows, expected 2 as q0 has"),
    "nan": ({"q0": [[0, 0, 0], [0, np.nan, 0]]}, r"q0\[1, 1\]: got NaN"),
    "unresolved": ({"q0": [[0, 0, 0], [0, 1e5, 0]]}, r"row 1: q0"),
    "inputs of many": ({"u": np.zeros((2, 5))}, r"u: expected shape"),
    "steps of inputs": ({"u": np.zeros((2, 5, 2))}, r"u: expected shape \(count, 10, 2\), got \(2, 5, 2\)"),
    "nan in steps": ({"u": np.full((2, 10, 2), np.nan)}, r"u\[0, 0, 0\]: got NaN"),
    "control step": ({"u": [0, 0], "control_step": 0.1}, "control_step: got 0.1, but only inputs of shape"),
    "step of auto": ({"u": np.zeros((2, 5, 2)), "method": "auto", "control_step": 0.0}, "control_step"),
    "workers": ({"workers": 0}, "workers: got 0"),
    "keep": ({"keep": "all"}, 'keep: got "all", expected "states"'),
    "link": ({"places": ["rud"]}, r"places\[0\]: got 'rud', expected one of the links: 'rod'"),
    "place": ({"places": [0.1, 0.4]}, r"places\[1\]: X: got 0.4"),
    "times": ({"t_eval": [0.2]}, r"t_eval\[0\]"),
    "memory": ({"memory_limit": 1000}, r"keep: 2 rows of 11 times and 3 coordinates take .*memory"),
    "many": ({"dt": 1e-12}, "number of output times|keep: "),
    "limit": ({"memory_limit": np.nan}, "memory_limit: got"),
    "t_end": ({"t_end": -1.0}, "t_end: got -1"),
}


@pytest.mark.parametrize(("changes", "message"), REFUSED.values(), ids=REFUSED)
def test_what_makes_no_sense_is_refused(changes, message):
    options = {"model": arm(), "t_end": 0.1, "q0": np.zeros((2, 3))} | changes
    with pytest.raises(ValueError, match=message):
        lissom.simulate_many(**options)


def test_models_of_different_sizes_are_refused():
    wire = lissom.Rod([lissom.Segment(0.4, 1e-3, 2e11, 8e10, 7800, {"bend_y": 2})])
    with pytest.raises(ValueError, match=r"model\[1\]: got 2 coordinates, expected 3"):
        lissom.simulate_many([arm(), wire], 0.1)
    with pytest.raises(ValueError, match="model: got no models"):
        lissom.simulate_many([], 0.1)
    with pytest.raises(TypeError, match="model: expected a Model"):
        lissom.simulate_many(None, 0.1)
    with pytest.raises(TypeError, match="places: this model has no links"):
        lissom.simulate_many(lissom.SpringPendulum(), 0.1, places=[0.1])
    with pytest.raises(TypeError, match="t_eval: missing"):
        lissom.simulate_many(arm(), 0.1, adaptive=True)
    with pytest.raises(TypeError, match="progress: expected"):
        lissom.simulate_many(arm(), 0.1, progress=3)


def test_adaptive_steps_of_which_only_the_last_state_is_wanted_need_no_times():
    q0 = [[0.1, 0.0, 0.0], [0.3, 0.2, 0.0]]
    result = lissom.simulate_many(arm(), T_END, q0=q0, adaptive=True, dt=2e-3, keep="final")
    for row in range(2):
        alone = lissom.simulate(arm(), T_END, q0=q0[row], adaptive=True, dt=2e-3)
        np.testing.assert_array_equal(result.q[row], alone.q[-1])


def test_functions_of_time_are_called_by_all_threads():
    model = arm(loads=[lissom.Load(force=swing)])
    threads = set()

    def noted(t):
        threads.add(threading.get_ident())
        time.sleep(1e-4)
        return swing(t)

    many = arm(loads=[lissom.Load(force=noted)])
    result = lissom.simulate_many(many, T_END, q0=np.zeros((4, 3)), dt=2e-3, workers=2)
    assert len(threads - {threading.get_ident()}) >= 2
    for row in range(4):
        assert_row(result, row, lissom.simulate(model, T_END, dt=2e-3))


def test_what_a_function_of_time_raises_comes_through_with_what_was_done():
    class Enough(Exception):
        pass

    def failing(t):
        if t > 0.03:
            raise Enough
        return (0, 0, 0)

    models = [arm(), arm(loads=[lissom.Load(force=failing)]), arm()]
    with pytest.raises(Enough) as caught:
        lissom.simulate_many(models, T_END, dt=1e-3, workers=1)
    result = caught.value.result
    assert result.status.tolist() == ["finished", "interrupted", "not_begun"]
    np.testing.assert_array_equal(result.q[0], lissom.simulate(arm(), T_END, dt=1e-3).q)
    assert 0.02 < result.reached[1] <= 0.031
    assert np.isnan(result.q[2]).all()
    assert np.isnan(result.reached[2])


def test_progress_is_told_and_may_end_the_rest():
    reported = []
    lissom.simulate_many(arm(), T_END, q0=np.zeros((20, 3)), dt=1e-3, progress=reported.append)
    assert reported == sorted(reported)
    assert reported[-1] == 20

    reported.clear()
    models = [arm(), arm(loads=[lissom.Load(force=([0.0, 0.01], [(0, 0, 0), (0, 0, 1e300)]))])]
    assert not lissom.simulate_many(models, T_END, progress=reported.append).success[1]
    assert reported[-1] == 2

    def enough(done):
        return done >= 2

    result = lissom.simulate_many(arm(), 0.5, q0=np.zeros((5000, 3)), dt=1e-4, progress=enough, keep="final")
    assert 2 <= result.success.sum() < 5000
    assert set(result.status) == {"finished", "interrupted", "not_begun"}
    done = result.success
    # Whichever came to their ends.
    assert (result.q[done] == result.q[done][0]).all()

    def broken(done):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError) as caught:
        lissom.simulate_many(arm(), 0.5, q0=np.zeros((500, 3)), dt=1e-4, progress=broken, keep="final")
    assert len(caught.value.result) == 500


def test_a_bar_shows_progress(capsys):
    lissom.simulate_many(arm(), T_END, q0=np.zeros((20, 3)), progress=True)
    assert "20/20" in capsys.readouterr().err


def test_ctrl_c_raises_with_what_was_done():
    timer = threading.Timer(0.5, signal.raise_signal, [signal.SIGINT])
    timer.start()
    begun = time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt) as caught:
            lissom.simulate_many(arm(), 2.0, q0=np.zeros((100_000, 3)), dt=1e-4, keep="final", workers=2)
    finally:
        timer.join()
    assert time.monotonic() - begun < 20
    result = caught.value.result
    assert "not_begun" in result.status
    assert result.success.sum() < 100_000


def test_results_are_read_only_and_can_be_copied_and_pickled():
    result = lissom.simulate_many(arm(), T_END, q0=np.zeros((3, 3)), keep="summary")
    for twin in (copy.deepcopy(result), pickle.loads(pickle.dumps(result))):
        for name in ("t", "q", "v", "poses", "lowest", "highest", "mean", "variance", "reached", "status"):
            np.testing.assert_array_equal(getattr(twin, name), getattr(result, name))
            with pytest.raises(ValueError, match="read-only"):
                getattr(twin, name)[0] = getattr(result, name)[0]
        assert (twin.message, twin.doubt, twin.slack) == (result.message, result.doubt, result.slack)
        assert twin.stats.keys() == result.stats.keys()
    assert repr(result).startswith("<EnsembleResult: 3 of 3 runs succeeded")


@pytest.mark.slow
def test_what_is_kept_bounds_the_memory():
    """Ten thousand runs of 2001 times with the memory of the last states; all states would be a gigabyte."""
    program = """
import resource, numpy as np, lissom
rod = lissom.Rod([lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000, {"bend_y": 1}, retardation_time=0.1)])
q0 = np.linspace(0, 0.5, 10_000)[:, None]
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
result = lissom.simulate_many(rod, 0.2, dt=1e-4, q0=q0, keep="final")
assert result.success.all()
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024)
"""
    shown = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert float(shown.stdout) < 60


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_fork_goes_on_as_it_should():
    program = """
import os, numpy as np, lissom
pendulum = lissom.SpringPendulum()
q0 = np.linspace(-0.5, 0.5, 20)[:, None] * [1.0, 0.1]
many = lambda: lissom.simulate_many(pendulum, 1.0, q0=q0).q
before = many()
child = os.fork()
same = (many() == before).all()
if child == 0:
    os._exit(0 if same else 1)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0 and same
"""
    subprocess.run([sys.executable, "-W", "ignore", "-c", program], check=True, timeout=60)


def test_several_threads_of_python_may_ask_at_once():
    q0, found = np.random.default_rng(0).uniform(-0.2, 0.2, (50, 3)), [None] * 3

    def ask(i):
        found[i] = lissom.simulate_many(arm(), T_END, q0=q0, dt=2e-3).q

    threads = [threading.Thread(target=ask, args=[i]) for i in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all((q == found[0]).all() for q in found)
