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
    "Harmonic": ("frequency", lambda name: lissom.Harmonic(1.0, **{name: 2.0})),
    "Input": ("default", lambda name: lissom.Input("pull", **{name: 1.0})),
    "Profile": ("stations", lambda name: lissom.Profile(0.3, **{name: [0.0, 0.3]})),
    "choose_modes": ("segments", lambda name: lissom.choose_modes(rod(), **{name: [0]})),
    "jacobian": ("method", lambda name: lissom.jacobian(np.sin, [1.0], **{name: "forward"})),
    "check_jacobian": ("x_scale", lambda name: lissom.check_jacobian(np.sin, np.cos, [1.0], **{name: 1.0})),
    "RK45": ("first_step", lambda name: lissom.RK45(lambda t, y: y, 0.0, [1.0], 1.0, **{name: 0.1})),
    "DOP853": ("controller", lambda name: lissom.DOP853(lambda t, y: y, 0.0, [1.0], 1.0, **{name: "PI"})),
    "Radau": ("jac_sparsity", lambda name: lissom.Radau(lambda t, y: y, 0.0, [1.0], 1.0, **{name: [[1]]})),
}

#: Calls in which the name of a required argument is misspelt, and what is meant.
REQUIRED = {
    "statics": (lambda: lissom.statics(modle=rod()), "model"),
    "modes": (lambda: lissom.modes(rod(), qq=[0, 0]), "q"),
    "simulate": (lambda: lissom.simulate(modle=rod(), t_end=1.0), "model"),
    "Simulations": (lambda: lissom.Simulations(modle=rod(), count=2, dt=0.1), "model"),
    "Robot.pose": (lambda: rod().pose(qq=[0, 0]), "q"),
    "Robot.actuator_length": (lambda: with_input().actuator_length(nmae="pull", q=[0, 0]), "name"),
    "Scene.loads": (lambda: lissom.Scene.loads(txt="version = 1"), "text"),
    "Input": (lambda: lissom.Input(nmae="pull"), "name"),
    "RK45": (lambda: lissom.RK45(lambda t, y: y, 0.0, [1.0], tbound=1.0), "t_bound"),
    "solve_ivp": (lambda: lissom.solve_ivp(lambda t, y: y, tspan=(0, 1), y0=[1.0]), "t_span"),
    "fit": (lambda: lissom.fit(rod(), daat=([0.1], [[0, 0, 0]]), parameters={}), "data"),
    "statics_many": (lambda: lissom.statics_many(modle=rod()), "model"),
    "sweep": (lambda: lissom.sweep(rod(), paramters={}, t_end=1.0), "parameters"),
    "robot_from_urdf": (lambda: lissom.Robot.from_urdf(pth="robot.urdf"), "path"),
    "load": (lambda: lissom.load(pth="run.lissom"), "path"),
    "MotionResult.save": (lambda: lissom.simulate(rod(), 0.01).save(pth="run.lissom"), "path"),
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


@pytest.mark.parametrize("function", REQUIRED)
def test_misspelt_names_of_required_arguments_are_answered_with_the_right_ones(function):
    call, meant = REQUIRED[function]
    with pytest.raises(TypeError) as caught:
        call()
    assert str(caught.value).startswith(f"{function}() got an unexpected keyword argument '")
    assert str(caught.value).endswith(f"; did you mean '{meant}'?")


def test_arguments_without_names_are_counted():
    with pytest.raises(
        TypeError, match=r"^Load\(\) takes no positional arguments: give them by name, of force, moment, "
    ):
        lissom.Load((0, 0, 1))
    with pytest.raises(TypeError, match=r"^Model\.energy\(\) missing required arguments: 'q', 'qd'$"):
        rod().energy()


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


def with_input():
    segment = lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 2})
    pull = lissom.Tendon("pull", [lissom.Along(offset=(0, 0.01))], tension=lissom.Input("pull"))
    return lissom.Rod([segment], gravity=(0, 0, 0), actuators=[pull])


#: Calls of methods with a word that other programs have, and what is meant.
OF_METHODS = {
    "Robot.pose": (lambda: rod().pose([0, 0], s=0.1), "X"),
    "Robot.velocity": (lambda: rod().velocity([0, 0], [0, 0], links="rod"), "link"),
    "Robot.reach": (lambda: rod().reach("rod", (0, 0, 0), maxiter=3), "max_iter"),
    "Model.energy": (lambda: rod().energy([0, 0], [0, 0], time=0.0), "t"),
    "Model.mass_matrix": (lambda: rod().mass_matrix([0, 0], time=0.0), "t"),
    "Simulation.step": (lambda: lissom.Simulation(rod(), dt=1e-3).step(inputs=[]), "u"),
    "Simulation.reset": (lambda: lissom.Simulation(rod(), dt=1e-3).reset(x0=[0, 0]), "q0"),
    "Simulations.step": (lambda: lissom.Simulations(rod(), 2, dt=1e-3).step(dt=0.1), "duration"),
    "MotionResult.report": (lambda: lissom.simulate(rod(), 0.01).report("x.html", titel="x"), "title"),
    "Visual": (lambda: lissom.Visual("a", [(0, 0, 0)], [(0, 0, 0)], color="#112233"), "colour"),
    "Target": (lambda: lissom.Target("rod", (0, 0, 0), arc_length=0.1), "X"),
    "Marker": (lambda: lissom.sensors.Marker(rod(), lnik="rod"), "link"),
    "linearise": (lambda: lissom.linearise(rod(), [0, 0], output="tip_position_z"), "outputs"),
}


@pytest.mark.parametrize("method", OF_METHODS)
def test_methods_and_classes_of_python_answer_alike(method):
    call, meant = OF_METHODS[method]
    with pytest.raises(TypeError) as caught:
        call()
    assert str(caught.value).startswith(f"{method}() got an unexpected keyword argument '")
    assert str(caught.value).endswith(f"; did you mean '{meant}'?")


def test_required_arguments_are_asked_for_after_wrong_words():
    for call in (
        lambda: lissom.simulate(rod(), T=1.0),
        lambda: lissom.simulate(rod(), duration=1.0),
        lambda: lissom.simulate_many(rod(), tf=1.0),
    ):
        with pytest.raises(TypeError, match=r"; did you mean 't_end'\?$"):
            call()
    with pytest.raises(TypeError, match=r"; did you mean 'dt'\?$"):
        lissom.Simulation(rod(), step=0.1)
    with pytest.raises(TypeError, match=r"simulate\(\) missing required arguments: 't_end'"):
        lissom.simulate(rod())
    with pytest.raises(TypeError, match=r"Simulation\(\) missing required arguments: 'dt'"):
        lissom.Simulation(rod())


def test_stiffness_of_a_section_names_where_it_is_given():
    for word in ("EI", "GJ", "bending_stiffness", "mass_per_length"):
        with pytest.raises(TypeError, match=rf"'{word}'.*section=lissom\.Section\.given\(stiffness="):
            lissom.Segment(0.3, **{word: 1.0})
    with pytest.raises(TypeError, match="did you mean 'modes'"):
        lissom.Segment(0.3, n_modes=3)


def test_inputs_by_name_are_those_of_the_array():
    model = with_input()
    found = lissom.statics(model, u={"pull": 0.5})
    np.testing.assert_array_equal(found.q, lissom.statics(model, u=[0.5]).q)
    assert abs(found.q).max() > 1e-3
    # What is not named has its default.
    np.testing.assert_array_equal(lissom.statics(model, u={}).q, lissom.statics(model).q)
    np.testing.assert_array_equal(
        lissom.modes(model, found.q, u={"pull": 0.5}).frequency,
        lissom.modes(model, found.q, u=[0.5]).frequency,
    )
    zero = np.zeros(2)
    by_name = model.inverse_dynamics(found.q, zero, zero, u={"pull": 0.5})
    np.testing.assert_array_equal(by_name, model.inverse_dynamics(found.q, zero, zero, u=[0.5]))
    by_name = model.internal_wrench(found.q, zero, zero, 0.1, u={"pull": 0.5})
    np.testing.assert_array_equal(by_name, model.internal_wrench(found.q, zero, zero, 0.1, u=[0.5]))
    simulation = lissom.Simulation(model, dt=1e-3)
    simulation.step({"pull": 0.2})
    assert simulation.u == [0.2]
    simulation.step({})
    assert simulation.u == [0.2]


def test_inputs_by_wrong_names_are_refused():
    model = with_input()
    with pytest.raises(
        ValueError, match="u: got 'pul', expected one of the inputs: 'pull'; did you mean 'pull'"
    ):
        lissom.statics(model, u={"pul": 1.0})
    with pytest.raises(ValueError, match=r"u\['pull'\]: got NaN"):
        lissom.statics(model, u={"pull": float("nan")})
    with pytest.raises(TypeError, match="u: expected names of inputs, got"):
        lissom.statics(model, u={1: 1.0})
