"""Extreme numbers and many problems are rejected quickly; Ctrl-C stops any computation."""

import os
import signal
import threading
import time

import numba
import numpy as np
import pytest

import lissom

# Time limit in seconds, in any build on a busy machine; without bounds it took minutes.
AT_ONCE = 5.0


@pytest.fixture(autouse=True)
def quick():
    start = time.monotonic()
    yield
    assert time.monotonic() - start < AT_ONCE


def segment(length=1.0, radius=1e-3, young=210e9, **options):
    options = {"modes": {"bend_y": 3}, **options}
    return lissom.Segment(length, radius, young, 0.38 * young, 7800, **options)


@pytest.mark.parametrize(
    ("length", "curvature"), [(1, 3e3), (1, 1e15), (1, 1e300), (43e3, 0.1), (1, 1.7e308)]
)
def test_reference_curvature_has_a_bound(length, curvature):
    with pytest.raises(ValueError, match=r"reference_strain: got .* turns .* at most 1024 quadrature nodes"):
        segment(length, reference_strain=(0, curvature, 0, 1, 0, 0))


@pytest.mark.parametrize("size", [1e-300, 1e-100, 1e100, 1e200, 1.7e308, 5e-324])
@pytest.mark.parametrize("shape", ["ellipse", "rectangle"])
def test_sections_at_the_edges_of_doubles(shape, size):
    for sizes in [(size, size), (size, 1e-3)]:
        with pytest.raises(ValueError, match=r"section"):
            segment(
                radius=None, section=getattr(lissom.Section, shape)(*sizes), modes={"torsion": 2, "bend_y": 3}
            )


def test_stiffness_that_overflows():
    with pytest.raises(ValueError, match=r"section: got a stiffness of .* between 1e-100 and 1e100"):
        segment(young=1.7e308)


MANY = 100_000


@pytest.mark.parametrize(
    "solve",
    [
        lambda x: lissom.root(lambda x: x, x),
        lambda x: lissom.jacobian(lambda x: x, x),
        lambda x: lissom.newmark(lambda t, q, v, a: a, (0, 1), x, x, dt=0.1),
        lambda x: lissom.solve_ivp(lambda t, y: y, (0, 1), x, method="radau"),
        lambda x: lissom.solve_ivp(lambda t, y: y, (0, 1), x, t_eval=np.linspace(0, 1, 1_000_000)),
    ],
    ids=["root", "jacobian", "newmark", "radau", "t_eval"],
)
def test_what_does_not_fit_in_memory_is_refused(solve):
    with pytest.raises(ValueError, match=r"expected what fits in memory; this takes .* GB"):
        solve(np.ones(MANY))


def test_too_many_load_steps():
    with pytest.raises(
        ValueError, match="load_steps: got 2147483648, expected a whole number between 1 and 1000000"
    ):
        lissom.statics(lissom.Rod([segment()]), load_steps=2**31)


@pytest.mark.parametrize(("method", "end"), [("rk45", 17.976931), ("dop853", 17.976931)])
def test_states_that_overflow_end_an_integration(method, end):
    result = lissom.solve_ivp(lambda t, y: [1e307], (0, 100), [0.0], method=method)
    assert not result.success
    assert "the state is NaN or infinite" in result.message
    assert np.isfinite(result.y).all()
    assert result.t[-1] == pytest.approx(end, rel=1e-6)


@pytest.mark.parametrize(
    "body",
    [
        "".join(f"k{i} = 1\n" for i in range(20_000)),
        "[[rod]]\n" + "[[rod.segment]]\nlength = -1\nradius = -1\n" * 4000,
    ],
    ids=["keys", "segments"],
)
def test_many_problems_are_refused_in_time_and_in_few_words(body):
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads("version = 1\n" + body)
    message = str(caught.value)
    assert len(caught.value.problems) == 100
    assert len(message) < 100_000
    assert message.splitlines()[-1].startswith("and ")
    assert message.endswith(" more problems")


def heard(action):
    """Seconds from Ctrl-C, half a second after the start, until `action` ends with KeyboardInterrupt."""
    sent = []

    def send():
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.5, send)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            action()
        return time.monotonic() - sent[0]
    finally:
        timer.cancel()


@pytest.fixture(scope="module")
def large():
    modes = dict.fromkeys(("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"), 4)
    return lissom.Rod([segment(0.01, modes=modes) for _ in range(30)])


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize(
    "search",
    [
        lambda rod: lissom.modes(rod, np.zeros(rod.n)),
        # Far more steps than possible in half a second: each needs tangents of 720 coordinates.
        lambda rod: lissom.statics(rod, load_steps=100_000, max_steps=1_000_000),
        lambda rod: lissom.continuation(rod, max_step=1e-5, max_steps=1_000_000),
    ],
    ids=["modes", "statics", "continuation"],
)
def test_ctrl_c_is_heard_by_large_models(large, search):
    assert heard(lambda: search(large)) < 1.0


POINTER = numba.types.CPointer(numba.types.double)


@numba.cfunc(numba.types.void(numba.types.double, POINTER, POINTER, POINTER))
def slow(t, y, dydt, args):
    total = 0.0
    for i in range(10_000_000):
        total += np.sin(t + i)
    dydt[0] = y[0] + 1e-30 * total


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("method", ["rk45", "dop853", "radau"])
def test_ctrl_c_is_heard_while_a_slow_compiled_function_is_evaluated(method):
    assert heard(lambda: lissom.solve_ivp(slow, (0, 10), [1.0], method)) < 1.0


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_is_heard_where_a_million_states_are_compared():
    rod = lissom.Rod([segment(retardation_time=1e-3)])
    times = np.linspace(0, 1, 1_000_000)
    assert heard(lambda: lissom.simulate(rod, 1.0, method="auto", rtol=1e-3, t_eval=times)) < 1.0
