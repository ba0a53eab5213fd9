"""User functions in native computations: ownership, depth of nesting, concurrency."""

import functools
import gc
import math
import sys
import threading
import time
import weakref

import numpy as np
import pytest

import lissom

WIRE = lissom.Segment(0.4, 1e-3, 2e11, 8e10, 7800, {"bend_y": 3}, retardation_time=1e-4)


class Thing:
    """An object to which a function refers."""


def rod_and_load(function):
    load = lissom.Load(force=function)
    return [load, lissom.Rod([WIRE], loads=[load])]


def rods_own_parts(function):
    rod = lissom.Rod([WIRE], loads=[lissom.Load(moment=function)])
    return [rod, rod.loads[0], lissom.Rod([WIRE], loads=rod.loads)]


def moving_base(function):
    motion = lissom.BaseMotion(translation=function)
    rod = lissom.Rod([WIRE], base_motion=motion)
    return [motion, rod, rod.base_motion]


def turning_base(function):
    motion = lissom.BaseMotion(axis=(0, 0, 1), angle=lambda t: function(t)[0])
    return [motion, lissom.Rod([WIRE], base_motion=motion)]


def result_of(function):
    return [lissom.simulate(lissom.Rod([WIRE], loads=[lissom.Load(force=function)]), 0.02)]


def result_of_auto(function):
    rod = lissom.Rod([WIRE], loads=[lissom.Load(force=function)])
    return [lissom.simulate(rod, 0.02, method="auto", rtol=1e-2)]


def chosen_modes(function):
    rod = lissom.Rod([WIRE], loads=[lissom.Load(force=function)])
    return [lissom.choose_modes(rod, 0.02, rtol=1e-1)]


def solver(method):
    def make(function):
        return [method(lambda t, y: function(t), 0.0, [0.0] * 3, 1.0)]

    return make


def solver_with_args(function):
    return [lissom.RK45(lambda t, y, function: function(t), 0.0, [0.0] * 3, 1.0, args=(function,))]


def solver_with_jacobian(function):
    return [
        lissom.Radau(lambda t, y: -y, 0.0, [1.0] * 3, 1.0, jac=lambda t, y: np.diag(function(t)) - np.eye(3))
    ]


def solver_of_a_rod(function):
    return [lissom.RK45(lissom.Rod([WIRE], loads=[lissom.Load(force=function)]), 0.0, [0.0] * 6, 1e-3)]


def a_result_in_its_own_list(function):
    result = lissom.solve_ivp(lambda t, y: -y, (0, 1), [1.0], events=lambda t, y: y[0] - 0.5)
    result.t_events.append(function)
    result.t_events.append(result)
    return [result]


def a_result_in_its_own_history(function):
    result = lissom.root(lambda x: x, 1.0, history=True)
    result.history["function"] = function
    result.history["result"] = result
    return [result]


def a_result_in_its_own_path(function):
    result = lissom.continuation(lissom.Rod([WIRE]))
    result.path.critical_points.append(function)
    result.path.critical_points.append(result)
    return [result]


MAKERS = {
    "rod and load": rod_and_load,
    "parts of a rod": rods_own_parts,
    "moving base": moving_base,
    "turning base": turning_base,
    "result": result_of,
    "result of auto": result_of_auto,
    "chosen modes": chosen_modes,
    "RK45": solver(lissom.RK45),
    "DOP853": solver(lissom.DOP853),
    "Radau": solver(lissom.Radau),
    "args": solver_with_args,
    "jac": solver_with_jacobian,
    "solver of a rod": solver_of_a_rod,
    "list": a_result_in_its_own_list,
    "history": a_result_in_its_own_history,
    "path": a_result_in_its_own_path,
}


def function_of(thing):
    return lambda t: (0.0, 0.0, 1e-6 if thing else 0.0)


class Method(Thing):
    """A cycle through a bound method, which the collector cannot clear."""

    def __bool__(self):
        return True

    def force(self, t):
        return (0.0, 0.0, 1e-6)


THROUGH = {
    "closure": function_of,
    "method": lambda thing: thing.force,
    "partial": lambda thing: functools.partial(Method.force, thing),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", MAKERS)
@pytest.mark.parametrize("through", THROUGH)
def test_cycles_through_functions_are_freed(kind, through):
    thing = Method()
    function = THROUGH[through](thing)
    thing.made = MAKERS[kind](function)
    ghost = weakref.ref(thing)
    gc.collect()
    assert ghost() is not None
    # Still alive, and nothing has been collected.
    for made in thing.made:
        if isinstance(made, lissom.Model):
            assert math.isfinite(made.energy([0.0] * made.n, [0.0] * made.n, t=0.5).total)
        elif isinstance(made, lissom.OdeSolver):
            made.step()
    del thing, function, made
    gc.collect()
    assert ghost() is None


def test_functions_live_as_long_as_what_calls_them():
    """After the loads and bases are deleted, the rod owns their functions; likewise a solver owns the rod."""

    def rod():
        thing = Method()
        motion = lissom.BaseMotion(translation=lambda t: [1e-3 * t if thing else 0.0] * 3)
        return lissom.Rod([WIRE], loads=[lissom.Load(force=thing.force)], base_motion=motion)

    kept = rod()
    gc.collect()
    assert lissom.simulate(kept, 0.02).success
    assert kept.loads[0].force(0.0) == (0.0, 0.0, 1e-6)
    model = lissom.simulate(rod(), 0.02).model
    gc.collect()
    assert lissom.simulate(model, 0.02).success
    stepper = lissom.RK45(rod(), 0.0, [0.0] * 6, 1e-3)
    loads, base = rod().loads, rod().base_motion
    gc.collect()
    stepper.step()
    assert loads[0].force(1.0) == (0.0, 0.0, 1e-6)
    assert base.translation(1.0) == [1e-3] * 3
    assert (
        lissom.Rod([WIRE], loads=loads, base_motion=base).energy([0.0] * 3, [0.0] * 3, t=1.0).total < np.inf
    )


def test_callables_without_weak_references_will_do():
    class Slotted:
        __slots__ = ()

        def __call__(self, t):
            return (0.0, 0.0, math.sin(t))

    assert lissom.simulate(lissom.Rod([WIRE], loads=[lissom.Load(force=Slotted())]), 0.02).success


@pytest.mark.slow
def test_a_collection_in_the_middle_of_a_step():
    def fun(t, y):
        gc.collect()
        return -y

    stepper = lissom.RK45(fun, 0.0, [1.0], 1.0)
    while stepper.status == "running":
        stepper.step()
    assert stepper.y[0] == pytest.approx(math.exp(-1.0), rel=1e-3)


def simulated(function):
    return lissom.simulate(lissom.Rod([WIRE], loads=[lissom.Load(force=function)]), 0.02)


#: Computations that call a function with one argument.
NESTED = {
    "simulate": lambda f: simulated(lambda t: (0.0, 0.0, f(t))),
    "simulate, auto": lambda f: lissom.simulate(
        lissom.Rod([WIRE], loads=[lissom.Load(force=lambda t: (0.0, 0.0, f(t)))]),
        0.02,
        method="auto",
        rtol=1e-2,
    ),
    "progress": lambda f: lissom.simulate(lissom.Rod([WIRE]), 0.02, progress=lambda t: f(t) is None),
    "base": lambda f: lissom.Rod(
        [WIRE], base_motion=lissom.BaseMotion(translation=lambda t: [f(t)] * 3)
    ).pose([0.0] * 3, 0.1, t=0.0),
    "solve_ivp": lambda f: lissom.solve_ivp(lambda t, y: [f(t)], (0.0, 1.0), [1.0]),
    "Radau": lambda f: lissom.solve_ivp(lambda t, y: [f(t)], (0.0, 1.0), [1.0], "radau"),
    "events": lambda f: lissom.solve_ivp(lambda t, y: -y, (0.0, 1.0), [1.0], events=lambda t, y: f(t) or 1.0),
    "RK45": lambda f: lissom.RK45(lambda t, y: [f(t)], 0.0, [1.0], 1.0).step(),
    "newmark": lambda f: lissom.newmark(lambda t, q, v, a: a + f(t), (0.0, 1.0), [0.0], [0.0], dt=0.5),
    "root": lambda f: lissom.root(lambda x: x - f(x), 1.0),
    "jacobian": lambda f: lissom.jacobian(lambda x: x - f(x), 1.0),
    "statics": lambda f: lissom.statics(
        lissom.Rod([WIRE], loads=[lissom.Load(force=lambda t: (0.0, 0.0, f(t)))])
    ),
    "Segment": lambda f: lissom.Segment(0.4, lambda X: 1e-3 + f(X), 2e11, 8e10, 7800, {"bend_y": 3}),
    "__array__": lambda f: lissom.root(lambda x: x, Converting(f)),
}


class Converting:
    """Calls a function when NumPy requests an array."""

    def __init__(self, function):
        self.function = function

    def __array__(self, dtype=None, copy=None):
        return np.array([1.0 + self.function(0.0)])


@pytest.mark.parametrize("stack", [None, 2**20], ids=["usual stack", "1 MB"])
@pytest.mark.parametrize("kind", NESTED)
def test_endless_nesting_is_a_recursion_error(kind, stack):
    calls = []

    def again(_):
        calls.append(len(calls))
        NESTED[kind](again)
        return 0.0

    def run():
        try:
            NESTED[kind](again)
        except RecursionError as error:
            caught.append(error)

    caught = []
    before = threading.stack_size(stack or 0)
    try:
        thread = threading.Thread(target=run)
        thread.start()
    finally:
        threading.stack_size(before)
    thread.join()
    assert len(caught) == 1
    # Deep enough to be useful, but not a tree of calls: a function that failed is not called again.
    assert 8 <= len(calls) <= 40


def test_some_nesting_is_fine():
    """A shooting method within a static problem within a motion."""

    def height(t):
        def miss(v0):
            return lissom.solve_ivp(lambda s, y: [y[1], -1.0], (0.0, 1.0), [0.0, v0]).y[0, -1] - t

        return lissom.root(miss, 0.0).x

    result = simulated(lambda t: (0.0, 0.0, 1e-6 * height(t)))
    assert result.success
    with pytest.raises(RecursionError):
        NESTED["root"](lambda x: NESTED["root"].__call__(lambda y: endless(y)))
    # Afterwards everything works as before.
    assert height(0.25) == pytest.approx(0.75)


def endless(x):
    return lissom.root(lambda y: endless(y), 1.0)


def test_the_first_exception_ends_a_computation():
    for method in ("newmark", "radau", "rk45", "auto"):
        calls = []

        def force(t, calls=calls):
            calls.append(t)
            raise ValueError(f"call {len(calls)}")

        rod = lissom.Rod([WIRE], loads=[lissom.Load(force=force)])
        with pytest.raises(ValueError, match=r"call 1$"):
            lissom.simulate(rod, 0.02, method=method)
        assert len(calls) == 1


def test_one_model_from_eight_threads_gives_the_same_bits():
    """All threads call the same function of time, and evaluate, pose and simulate the same rod."""
    calls = []

    def force(t):
        calls.append(t)
        return (0.0, 0.0, 1e-3 * math.sin(100.0 * t))

    rod = lissom.Rod([WIRE], loads=[lissom.Load(force=force)])
    q = np.array([0.1, -0.2, 0.05])
    stations = np.linspace(0.0, 0.4, 300)

    def work():
        motion = lissom.simulate(rod, 0.05)
        adaptive = lissom.simulate(rod, 0.02, method="radau")
        return [
            motion.q,
            motion.balance.total,
            adaptive.q,
            rod.pose(motion.q, stations, t=motion.t),
            rod.inverse_dynamics(q, q, q, t=0.01),
            lissom.statics(rod, t=0.01).q,
            lissom.modes(rod, q, t=0.01).frequency,
            lissom.solve_ivp(rod, (0.0, 1e-3), np.zeros(6)).y,
        ]

    expected = work()
    found = [None] * 8
    start = threading.Barrier(8)

    def run(index):
        start.wait()
        found[index] = work()

    threads = [threading.Thread(target=run, args=(index,), daemon=True) for index in range(8)]
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(100.0)
    finally:
        sys.setswitchinterval(interval)
    assert not any(thread.is_alive() for thread in threads)
    for results in found:
        for one, other in zip(results, expected, strict=True):
            np.testing.assert_array_equal(one, other)


def longest_pause(work):
    """Runs native work in a thread; returns its time and the longest pause of the calling thread."""
    thread = threading.Thread(target=work)
    pause, start = 0.0, time.perf_counter()
    thread.start()
    last = time.perf_counter()
    while thread.is_alive():
        time.sleep(1e-4)
        now = time.perf_counter()
        pause, last = max(pause, now - last), now
    return time.perf_counter() - start, pause


BIG = lissom.Segment(1.0, 1e-2, 1e6, 4e5, 1000, dict.fromkeys(["bend_y", "bend_z", "torsion"], 16), nodes=256)
BIG_ROD = lissom.Rod([BIG])
MANY = (
    "version = 1\n[[rod]]\n"
    + 1300
    * (
        "[[rod.segment]]\nlength = 0.4\nradius = 1e-3\n"
        "young_modulus = 2e11\nshear_modulus = 8e10\ndensity = 7800.0\n"
        "modes = { bend_y = 3 }\n"
    )
    + "[simulation]\nt_end = 1.0\n"
)


@pytest.mark.parametrize(
    "work",
    [
        lambda: [lissom.Rod([BIG] * 4) for _ in range(4)],
        lambda: BIG_ROD.pose(np.zeros((200, 48)), np.linspace(0.0, 1.0, 100)),
        lambda: lissom.Radau(BIG_ROD, 0.0, np.full(96, 1e-3), 1.0).step(),
        lambda: lissom.Scene.loads(MANY),
    ],
    ids=["Rod", "pose", "step", "Scene"],
)
def test_other_threads_run_meanwhile(work):
    """In the best of ten runs: a busy machine may take this thread's processor away for one of them."""
    work()
    shares = []
    for _ in range(10):
        total, pause = longest_pause(work)
        shares.append(pause / total)
    assert min(shares) < 0.5
