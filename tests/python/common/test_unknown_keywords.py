"""Keyword arguments that functions and classes do not have: what they have, and what may be meant."""

import inspect

import numpy as np
import pytest

import lissom


def rod():
    return lissom.Rod([lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 2})])


#: A call with a wrong keyword, by the right one.
CALLS = {
    "simulate": ("method", lambda name: lissom.simulate(rod(), 0.1, **{name: "radau"})),
    "simulate_many": ("workers", lambda name: lissom.simulate_many(rod(), 0.1, **{name: 1})),
    "statics": ("max_iter", lambda name: lissom.statics(rod(), **{name: 10})),
    "continuation": ("max_steps", lambda name: lissom.continuation(rod(), **{name: 3})),
    "modes": ("u", lambda name: lissom.modes(rod(), np.zeros(2), **{name: []})),
    "actuate": ("limits", lambda name: lissom.actuate(rod(), (0, 0, 0), **{name: 1})),
    "root": ("method", lambda name: lissom.root(lambda x: x, [1.0], **{name: "newton"})),
    "solve_ivp": ("method", lambda name: lissom.solve_ivp(lambda t, x: x, (0, 1), [1.0], **{name: "rk45"})),
    "newmark": (
        "beta",
        lambda name: lissom.newmark(lambda *_: 0, (0, 1), [1.0], [0.0], dt=0.1, **{name: 0.25}),
    ),
    "Simulation": ("method", lambda name: lissom.Simulation(rod(), dt=1e-3, **{name: "radau"})),
    "SpringPendulum": ("stiffness", lambda name: lissom.SpringPendulum(**{name: 10.0})),
}


@pytest.mark.parametrize("function", CALLS)
def test_misspelt_keywords_are_answered_with_the_right_one(function):
    right, call = CALLS[function]
    wrong = right[0] + right[2] + right[1] + right[3:] if len(right) > 2 else f"{right}x"
    with pytest.raises(TypeError) as caught:
        call(wrong)
    known = [name for name in inspect.signature(getattr(lissom, function)).parameters if name != "self"]
    begin = f"{function}() got an unexpected keyword argument '{wrong}', expected {', '.join(known)}"
    assert str(caught.value).startswith(begin)
    if len(right) > 2:
        assert str(caught.value) == f"{begin}; did you mean '{right}'?"


def test_symbols_are_known_by_their_names():
    with pytest.raises(
        TypeError, match="'k', expected length, mass, stiffness, gravity; did you mean 'stiffness'"
    ):
        lissom.SpringPendulum(k=3.0)


def test_what_means_nothing_has_no_suggestion():
    with pytest.raises(TypeError) as caught:
        lissom.SpringPendulum(zzzz=1)
    assert str(caught.value).endswith("expected length, mass, stiffness, gravity")


def test_names_of_joints_are_answered_with_the_objects():
    for kind, right in (("weld", "Weld"), ("revolut", "Revolute"), ("Distance", "Distance")):
        with pytest.raises(
            TypeError, match=rf"kind: expected lissom\.Weld, .*; did you mean lissom\.{right}\(...\)\?"
        ):
            lissom.Loop("a", "b", kind=kind)
    with pytest.raises(TypeError, match=r"got str$"):
        lissom.Loop("a", "b", kind="zzzz")


LOOP = """version = 1
[[link]]
name = "a"
joint = { type = "free" }
body = { mass = 1, inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }
[[link]]
name = "b"
joint = { type = "free" }
body = { mass = 1, inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }
[[loop]]
a = { link = "a" }
b = { link = "b" }
kind = "KIND"
[simulation]
t_end = 1
"""


def test_scenes_say_which_table_to_write():
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(LOOP.replace("KIND", "weld"))
    (problem,) = [each for each in caught.value.problems if each.key == "loop[0].kind"]
    assert problem.wrong == 'got the text "weld"'
    assert problem.right == 'expected a table, such as { type = "weld" }'
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(LOOP.replace("KIND", "zzzz"))
    (problem,) = [each for each in caught.value.problems if each.key == "loop[0].kind"]
    assert problem.right == "expected a table"
