"""Ctrl-C, and exceptions of functions of time, keep what a search had computed."""

import signal
import threading
import time

import numpy as np
import pytest

import lissom

L, RADIUS, E, G = 0.3, 2e-3, 1e9, 4e8


def finger(force=(0.0, 0.0, 0.0), modes=4, **more):
    """A rod with three tendons."""
    tendons = [
        lissom.Tendon(
            name,
            [lissom.Along(offset=(0.01 * np.cos(angle), 0.01 * np.sin(angle)))],
            tension=lissom.Input(name, 1.0),
        )
        for name, angle in zip("abc", 2 * np.pi * np.arange(3) / 3, strict=True)
    ]
    segment = lissom.Segment(L, RADIUS, E, G, 1200, modes={"bend_y": modes, "bend_z": modes}, **more)
    return lissom.Rod([segment], actuators=tendons, loads=[lissom.Load(force=force, at=L)])


FORCE = (0.0, 0.01, 0.0)


class Interrupting:
    """A constant force that can be evaluated so often."""

    def __init__(self, most=10**9, error=KeyboardInterrupt):
        self.calls, self.most, self.error = 0, most, error

    def __call__(self, t):
        if self.calls == self.most:
            raise self.error
        self.calls += 1
        return FORCE


def interrupted(function, *arguments, error=KeyboardInterrupt, **options):
    with pytest.raises(error) as caught:
        function(*arguments, **options)
    return caught.value.result


def ctrl_c(function, *arguments, after=0.1, **options):
    """The result kept after Ctrl-C so many seconds after the call."""
    timer = threading.Timer(after, signal.raise_signal, [signal.SIGINT])
    timer.start()
    try:
        return interrupted(function, *arguments, **options)
    finally:
        timer.join()


def is_usable(found, model, tmp_path):
    """It says that it was interrupted, and can be saved and loaded."""
    assert (found.status, found.success) == ("interrupted", False)
    assert "interrupted" in repr(found)
    assert "interrupted" in found.message
    path = tmp_path / "found.lissom"
    found.save(path)
    again = lissom.load(path)
    assert (again.status, again.nit, again.message) == (found.status, found.nit, found.message)
    return True


# ----------------------------------------------------------------------------------------------- continuation

INPUTS = {"a": (0.0, 20.0)}


@pytest.mark.parametrize(
    ("part", "error"), [(0.2, KeyboardInterrupt), (0.6, ValueError), (0.9, KeyboardInterrupt)]
)
def test_a_path_keeps_its_points(part, error, tmp_path):
    counted = Interrupting()
    whole = lissom.continuation(finger(counted), inputs=INPUTS, max_step=0.05)
    assert whole.success
    model = finger(Interrupting(int(part * counted.calls), error))
    found = interrupted(lissom.continuation, model, inputs=INPUTS, max_step=0.05, error=error)
    points = len(found.path.q)
    assert 0.5 * part * len(whole.path.q) < points < len(whole.path.q)
    for name in ("q", "load_factor", "lowest_eigenvalue"):
        np.testing.assert_array_equal(getattr(found.path, name), getattr(whole.path, name)[:points])
    assert found.path.stability[:-1] == whole.path.stability[:points][:-1]
    assert found.path.u.shape == (points, 3)
    assert is_usable(found, model, tmp_path)


def test_a_path_that_is_complete_is_kept_without_its_error():
    """The last calls are those of the estimate of the error by the modes."""
    counted = Interrupting()
    whole = lissom.continuation(finger(counted), inputs=INPUTS, max_step=0.05)
    found = interrupted(
        lissom.continuation, finger(Interrupting(counted.calls - 1)), inputs=INPUTS, max_step=0.05
    )
    np.testing.assert_array_equal(found.path.q, whole.path.q)
    assert whole.space_error is not None
    assert found.space_error is None


def test_a_path_keeps_its_critical_points(tmp_path):
    """A column beyond its buckling load, in steps so short that the path never ends."""
    euler = np.pi**2 / 4 * E * np.pi / 4 * RADIUS**4 / L**2
    segment = lissom.Segment(L, RADIUS, E, G, 1000, modes={"bend_y": 4})
    column = lissom.Rod([segment], gravity=(0, 0, 0), tip_force=(-1.5 * euler, 0, 0))
    begin = {"load_factor": 0.66, "max_step": 1e-2, "bounds": (0.0, 1e9), "max_steps": 10**9}
    found = ctrl_c(lissom.continuation, column, np.zeros(4), **begin)
    (point,) = found.path.critical_points[:1]
    assert point.load_factor == pytest.approx(2 / 3, rel=1e-5)
    assert found.path.stability[point.index : point.index + 2] == ["stable", "divergence"]
    assert is_usable(found, column, tmp_path)


# ---------------------------------------------------------------------------------------------------- statics


def loaded(factor=1.0):
    segment = lissom.Segment(L, RADIUS, E, G, 1e-6, modes={"bend_y": 6, "stretch": 2})
    force = np.array([0.1, 0.0, 0.4]) * factor
    return lissom.Rod([segment], gravity=(0, 0, 0), tip_force=force)


def test_a_load_path_keeps_its_points(tmp_path):
    """The last one is the equilibrium under this part of the load."""
    steps = np.linspace(1e-6, 1.0, 10**6)
    found = ctrl_c(lissom.statics, loaded(), load_steps=steps, max_steps=10**9)
    assert 0.0 < found.load_factor < 1.0
    assert found.load_factor == found.path.load_factor[-1]
    np.testing.assert_array_equal(found.q, found.path.q[-1])
    part = lissom.statics(loaded(found.load_factor))
    np.testing.assert_allclose(found.q, part.q, atol=1e-8 * np.abs(part.q).max())
    assert found.residual_norm < 1e-8
    assert is_usable(found, loaded(), tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["newton", "descent"])
def test_a_search_from_a_shape_keeps_its_last_shape(method, tmp_path):
    """The rod has so many coordinates that a search runs in a thread of its own."""
    segment = lissom.Segment(1.0, 5e-3, 1e6, 4e5, 1000, modes={"bend_y": 3, "bend_z": 3, "torsion": 3})
    rod = lissom.Rod([segment] * 60)
    q0 = np.random.default_rng(1).normal(size=rod.n)
    begin = time.perf_counter()
    whole = lissom.statics(rod, q0, method=method, max_iter=20)
    assert whole.nit >= 8
    quarter = 0.25 * (time.perf_counter() - begin)
    found = ctrl_c(lissom.statics, rod, q0, after=quarter, method=method, max_iter=10**6)
    rest = np.zeros(rod.n)
    assert (found.q.shape, found.load_factor, found.path) == ((rod.n,), 1.0, None)
    assert np.isfinite(found.residual_norm)
    assert np.isfinite(rod.inverse_dynamics(found.q, rest, rest)).all()
    assert is_usable(found, rod, tmp_path)


def test_a_path_that_could_not_begin_has_no_points():
    counted = Interrupting()
    model = finger(counted)
    counted.most = counted.calls + 1
    found = interrupted(lissom.continuation, model, inputs=INPUTS)
    assert (len(found.path.q), found.path.critical_points, found.status) == (0, [], "interrupted")


# ------------------------------------------------------------------------------------------ reach and actuate


def test_a_search_for_a_shape_keeps_the_best_one(tmp_path):
    """The target is out of reach by exactly this distance."""
    rod = finger()
    found = ctrl_c(rod.reach, None, (1.0, 0.0, 0.0), q0=np.full(rod.n, 3.0), restarts=100_000)
    assert found.starts > 1
    assert found.position_error == pytest.approx(1.0 - L, abs=1e-6)
    np.testing.assert_allclose(found.pose, rod.pose(found.q))
    assert is_usable(found, rod, tmp_path)


@pytest.mark.parametrize("part", [0.0, 0.1, 0.3, 0.6, 0.99])
def test_a_search_for_inputs_keeps_the_best_ones(part, tmp_path):
    plain, counted = finger(FORCE), Interrupting()
    target = plain.pose(lissom.statics(plain, u=[8.0, 1.0, 3.0]).q)[:3, 3]
    assert lissom.actuate(finger(counted), target).success
    found = interrupted(lissom.actuate, finger(Interrupting(max(1, int(part * counted.calls)))), target)
    if part > 0.0:
        # The shape is the equilibrium at the inputs, and they are no worse than the initial ones.
        np.testing.assert_allclose(found.q, lissom.statics(plain, u=found.u).q, atol=1e-8)
        start = np.linalg.norm(plain.pose(lissom.statics(plain).q)[:3, 3] - target)
        assert found.position_error <= start * (1 + 1e-9)
        assert found.position_error < 0.1 * start or part < 0.6
    np.testing.assert_allclose(found.pose, plain.pose(found.q))
    assert is_usable(found, plain, tmp_path)


# --------------------------------------------------------------------------------------- modes and iterations


def test_a_choice_of_modes_keeps_those_needed_so_far():
    def model(force):
        wire = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800, modes={}, retardation_time=1e-4)
        return lissom.Rod([wire], gravity=(0, 0, 0), loads=[lissom.Load(force=force, at=1.0)])

    counted = Interrupting()
    whole = lissom.choose_modes(model(counted), 0.02, rtol=1e-2)
    last = interrupted(lissom.choose_modes, model(Interrupting(counted.calls - 5)), 0.02, rtol=1e-2)
    assert isinstance(last, lissom.Rod)
    assert all(last.segments[0].modes[name] >= count for name, count in whole.segments[0].modes.items())
    first = interrupted(lissom.choose_modes, model(Interrupting(5)), 0.02, rtol=1e-2)
    assert first.segments[0].modes == {"bend_y": 2, "bend_z": 2}
    assert (first.length, first.gravity) == (last.length, last.gravity)


def test_a_root_search_keeps_its_best_iterate():
    def fun(x):
        calls.append(x)
        if len(calls) > 9:
            raise KeyboardInterrupt
        return np.array([x[0] ** 2 - 2.0, x[1] ** 3 - 3.0])

    calls = []
    found = interrupted(lissom.root, fun, [50.0, 50.0], method="line_search")
    assert (found.status, found.success) == ("interrupted", False)
    assert found.nit > 0
    best = min(calls[:9], key=lambda x: np.linalg.norm([x[0] ** 2 - 2.0, x[1] ** 3 - 3.0]))
    np.testing.assert_allclose(found.x, best, rtol=1e-6)
    np.testing.assert_allclose(found.fun, [found.x[0] ** 2 - 2.0, found.x[1] ** 3 - 3.0])
    assert found.residual_norm == pytest.approx(np.linalg.norm(found.fun))


def test_derivatives_keep_their_run():
    def objective(t, q, v):
        raise KeyboardInterrupt

    run = lissom.simulate(finger(), 0.05)
    kept = interrupted(lissom.sensitivity, finger(), 0.05, ["q0"], objective=objective)
    np.testing.assert_array_equal(kept.q, run.q)

    def of_shape(q):
        raise KeyboardInterrupt

    kept = interrupted(
        lissom.equilibrium_sensitivity, finger(), ["segments[0].young_modulus"], objective=of_shape
    )
    np.testing.assert_array_equal(kept.q, lissom.statics(finger()).q)


def test_exceptions_of_functions_come_from_large_models_too():
    """These are computed in a thread of their own."""
    segment = lissom.Segment(L / 40, RADIUS, E, G, 1200, modes={"bend_y": 3, "bend_z": 3})
    pull = lissom.Tendon("a", [lissom.Along(offset=(0.01, 0.0))], tension=lissom.Input("a", 1.0))
    counted = Interrupting()
    rod = lissom.Rod([segment] * 40, actuators=[pull], loads=[lissom.Load(force=counted, at=L)])
    assert rod.n >= 200
    counted.most = counted.calls + 12
    counted.error = error = ZeroDivisionError("own")
    with pytest.raises(ZeroDivisionError) as caught:
        lissom.continuation(rod, inputs={"a": (0.0, 1.0)})
    assert caught.value is error
    assert caught.value.result.status == "interrupted"
