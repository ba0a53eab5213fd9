"""Calls as they are in other programs are answered with a line that works."""

import re

import numpy as np
import pytest

import lissom
from lissom import sensors

#: Few modes are enough for messages.
pytestmark = pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")

YOUNG = "segments[0].young_modulus"


def segment(**options):
    return lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 2}, retardation_time=0.01, **options)


def rod(**options):
    return lissom.Rod([segment()], **options)


def pulled():
    path = [lissom.Along(offset=(0, 0.005))]
    return rod(actuators=[lissom.Tendon(name, path, tension=lissom.Input(name)) for name in "ab"])


def said_by(call):
    with pytest.raises((TypeError, ValueError, AttributeError)) as caught:
        call()
    return str(caught.value)


#: Functions of models, called with something else.
OF_MODELS = {
    "simulate": lambda model: lissom.simulate(model),
    "simulate with an end": lambda model: lissom.simulate(model, 1.0),
    "statics": lambda model: lissom.statics(model),
    "continuation": lambda model: lissom.continuation(model),
    "modes": lambda model: lissom.modes(model),
    "Simulation": lambda model: lissom.Simulation(model),
    "linearise": lambda model: lissom.linearise(model, [0.0]),
    "sensitivity": lambda model: lissom.sensitivity(model, 1.0, [YOUNG]),
    "equilibrium_sensitivity": lambda model: lissom.equilibrium_sensitivity(model, [YOUNG]),
    "statics_many": lambda model: lissom.statics_many(model),
}


@pytest.mark.parametrize("function", OF_MODELS)
def test_what_is_no_model_is_answered_with_what_makes_one(function):
    call = OF_MODELS[function]
    scene = rod().to_scene(t_end=0.02)
    assert '; `scene = lissom.Scene.load("arm.toml")` reads a scene: ' in said_by(lambda: call("arm.toml"))
    assert '; `lissom.Robot.from_urdf("arm.urdf")` reads a robot' in said_by(lambda: call("arm.urdf"))
    assert said_by(lambda: call("arm")).endswith("got str")
    assert said_by(lambda: call(3)).endswith("got int")
    if function != "statics_many":
        assert "`scene.run()` simulates a scene, and `scene.model` is its" in said_by(lambda: call(scene))
        assert said_by(lambda: call(segment())).endswith("; a model is `lissom.Rod([segment])`")
        assert said_by(lambda: call([segment()])).endswith("; a model is `lissom.Rod(segments)`")
        assert said_by(lambda: call(lissom.Link("a", body=lissom.Body(1.0)))).endswith(
            "`lissom.Robot([link])`"
        )
        assert said_by(lambda: call(lambda t, y: y)).endswith("there are newmark and solve_ivp")


def test_files_in_place_of_parts_are_answered_with_what_reads_them(tmp_path):
    for made in (lissom.Rod, lissom.Robot):
        assert '`scene = lissom.Scene.load("arm.toml")` reads a scene' in said_by(
            lambda made=made: made("arm.toml")
        )
        assert '`lissom.Robot.from_urdf("arm.urdf")`' in said_by(lambda made=made: made("arm.urdf"))
    assert "`lissom.Scene.load(path)` from a file" in said_by(lambda: lissom.Scene("arm.toml"))
    path = tmp_path / "arm.toml"
    rod().to_scene(t_end=0.02).save(path)
    scene = lissom.Scene.load(path)
    assert scene.run().success
    assert lissom.statics(scene.model).success


def test_shapes_are_said_where_they_are_missing():
    model = rod()
    assert "such as `lissom.statics(model).q`" in said_by(lambda: lissom.modes(model))
    assert "such as `lissom.statics(model).q`" in said_by(lambda: lissom.linearise(model))
    assert lissom.modes(model, lissom.statics(model).q).frequency[0] > 0
    assert len(lissom.linearise(model, lissom.statics(model).q).A) == 4
    rest, motion = lissom.statics(model), lissom.simulate(model, 0.02)
    for call in (
        lambda q: lissom.modes(model, q),
        lambda q: lissom.linearise(model, q),
        lambda q: lissom.simulate(model, 0.02, q0=q),
        lambda q: lissom.Simulation(model, dt=0.01, q0=q),
        lambda q: model.pose(q),
    ):
        assert said_by(lambda call=call: call(rest)).endswith("StaticsResult; its coordinates are its `q`")
        assert said_by(lambda call=call: call(motion)).endswith("; its last coordinates are its `q[-1]`")
        call(rest.q)
        call(motion.q[-1])


#: Calls of functions, how these are called, and functions that take something else.
FORMS = {
    "newmark": (
        lambda f, **more: lissom.newmark(f, (0, 0.1), [1.0], [0.0], dt=0.1, **more),
        "residual(t, q, v, a)",
        lambda t, q: q,
    ),
    "newmark, jac": (
        lambda f: lissom.newmark(lambda t, q, v, a: a, (0, 0.1), [1.0], [0.0], dt=0.1, jac=f),
        "jac(t, q, v, a)",
        lambda q: q,
    ),
    "newmark, callback": (
        lambda f: lissom.newmark(lambda t, q, v, a: a, (0, 0.1), [1.0], [0.0], dt=0.1, callback=f),
        "callback(t, q, v, a)",
        lambda q: q,
    ),
    "root": (lambda f, **more: lissom.root(f, 1.0, **more), "fun(x)", lambda: 1),
    "root, jac": (lambda f: lissom.root(np.sin, 1.0, jac=f), "jac(x)", lambda x, y: 1),
    "jacobian": (lambda f: lissom.jacobian(f, [1.0]), "fun(x)", lambda x, y: x),
    "solve_ivp": (lambda f, **more: lissom.solve_ivp(f, (0, 1), [1.0], **more), "fun(t, y)", lambda y: -y),
    "RK45": (lambda f: lissom.RK45(f, 0.0, [1.0], 1.0), "fun(t, y)", lambda y: -y),
    "solve_ivp, jac": (
        lambda f: lissom.solve_ivp(lambda t, y: -y, (0, 1), [1.0], method="radau", jac=f),
        "jac(t, y)",
        lambda y: -1,
    ),
    "events": (
        lambda f: lissom.solve_ivp(lambda t, y: -y, (0, 1), [1.0], events=f),
        "event(t, y)",
        lambda y: y[0],
    ),
    "progress": (lambda f: lissom.simulate(rod(), 1.0, progress=f), "progress(t)", lambda: None),
    "control": (lambda f: lissom.simulate(pulled(), 0.1, control=f), "control(t, q, v)", lambda t: [0, 0]),
    "radius": (lambda f: lissom.Segment(0.3, f, 1e6, 4e5, 1e3, modes={"bend_y": 1}), "radius(X)", lambda: 1),
}


@pytest.mark.parametrize("function", FORMS)
def test_functions_are_told_how_they_are_called(function):
    call, form, other = FORMS[function]
    name = form.partition("(")[0]
    said = said_by(lambda: call(other))
    takes = re.escape(f"{name}: is called as {form}, but takes (")
    assert re.match(rf"{takes}.*\): write `def {re.escape(form)}: \.\.\.`", said), said


def test_arguments_of_ones_own_are_given_as_args():
    def with_one(*names):
        return eval(f"lambda {', '.join(names)}, k: k * {names[1] if len(names) > 1 else names[0]}")

    for function, names in (("root", "x"), ("solve_ivp", "ty")):
        call, form, _ = FORMS[function]
        said = said_by(lambda call=call, names=names: call(with_one(*names)))
        assert said.endswith(f"`def {form}: ...`, or give the others as `args=(...)`")
        call(with_one(*names), args=(2.0,))
    call, *_ = FORMS["newmark"]
    assert "residual(t, q, v, a, arg0), but takes (t, q, v, a)" in said_by(
        lambda: call(lambda t, q, v, a: a, args=(2.0,))
    )


def test_errors_within_functions_are_raised_unchanged():
    def broken(x):
        return broken(x, 1)

    def of_types(x):
        return x + "a"

    for function in (broken, of_types, "abc".join):
        with pytest.raises(TypeError) as caught:
            lissom.root(function, 1.0)
        assert "is called as" not in str(caught.value)


def test_what_is_advised_for_rows_of_inputs_works():
    model, dt = pulled(), 0.01
    u = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.5]])
    said = said_by(lambda: lissom.simulate(model, 0.03, u=u))
    (code,) = re.findall(r"write `control=(.*)`$", said)
    motion = lissom.simulate(model, 0.03, dt=dt, control=eval(code, {"u": u, "dt": dt}))
    np.testing.assert_array_equal(motion.u[:3], u)

    columns = {"a": np.arange(5.0), "b": np.ones(5)}
    said = said_by(lambda: lissom.simulate(model, 0.03, u=columns))
    (code,) = re.findall(r"write `control=(.*)`$", said)
    motion = lissom.simulate(model, 0.03, dt=dt, control=eval(code, {"u": columns, "dt": dt}))
    np.testing.assert_array_equal(motion.u[:3], [[0, 1], [1, 1], [2, 1]])

    times, values = [0.0, 0.02], np.array([[0.0, 1.0], [2.0, 1.0]])
    said = said_by(lambda: lissom.simulate(model, 0.03, u=(times, values)))
    (code,) = re.findall(r"write `control=(.*)`$", said)
    control = eval(code, {"numpy": np, "times": times, "values": values})
    motion = lissom.simulate(model, 0.03, dt=dt, control=control)
    np.testing.assert_allclose(motion.u[:3], [[0, 1], [1, 1], [2, 1]])


def test_rows_of_inputs_elsewhere():
    model, u = pulled(), np.ones((3, 2))
    assert said_by(lambda: lissom.statics(model, u=u)).endswith(
        "; `lissom.statics_many(model, u)` takes one set of inputs in each row"
    )
    assert len(lissom.statics_many(model, u)) == 3
    simulation = lissom.Simulation(model, dt=0.01)
    assert said_by(lambda: simulation.step(u, 0.01)).endswith("`for row in u: simulation.step(row, dt)`")
    for row in u:
        simulation.step(row, 0.01)
    assert "write `simulation.step(u(simulation.t), dt)`" in said_by(lambda: simulation.step(lambda t: u[0]))
    # A wrong number, and a wrong name beside a vector, are no rows.
    assert said_by(lambda: lissom.simulate(model, 0.1, u=[1, 2, 3])).endswith("expected 2 values, got 3")
    assert "control" not in said_by(lambda: lissom.simulate(model, 0.1, u={"c": (1, 0, 0)}))


def test_data_of_fits():
    model = pulled()
    u = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 2.0]])
    tips = model.pose(lissom.statics_many(model, u).q)[:, :3, 3]
    guess = {YOUNG: (8.1e5, 9e5, 1.1e6)}
    assert "`lissom.StaticShapes(positions, u=u)`" in said_by(lambda: lissom.fit(model, (u, tips), guess))
    assert "`lissom.StaticShapes(positions, u=u)`" in said_by(lambda: lissom.fit(model, tips, guess))
    assert f'such as {{"{YOUNG}": 1e6}}' in said_by(lambda: lissom.fit(model, tips, [YOUNG]))
    assert f'such as {{"{YOUNG}": 1e6}}' in said_by(lambda: lissom.fit(model, tips))
    found = lissom.fit(model, lissom.StaticShapes(tips, u=u), guess)
    assert found.values[0] == pytest.approx(1e6, rel=1e-6)
    assert "No `u`" not in found.message
    without = lissom.fit(model, lissom.StaticShapes(tips), guess)
    assert (
        "No `u` was given with the data: inputs are at their defaults, 'a' = 0, 'b' = 0." in without.message
    )
    # Without inputs there is nothing to give.
    plain = lissom.fit(rod(), lissom.StaticShapes(tips[:1]), guess)
    assert "No `u`" not in plain.message


def test_sensors_say_what_reads_simulations():
    model = rod()
    marker, simulation = sensors.Marker(model), lissom.Simulation(model, dt=0.01)
    for call in (marker.read, marker.measure):
        assert "`observe(simulation)` reads a simulation" in said_by(lambda call=call: call(simulation))
    assert marker.observe(simulation).shape == (3,)
    assert marker.record(lissom.simulate(model, 0.02)).shape[1] == 3


def test_one_curve_is_drawn_as_advised():
    motion = lissom.simulate(rod(), 0.02)
    said = said_by(lambda: motion.plot("z"))
    assert said.startswith("MotionResult.plot() takes no arguments but 1 were given")
    (code,) = re.findall(r"`matplotlib.pyplot.plot\((.*)\)`", said)
    t, z = eval(code, {"result": motion})
    assert t.shape == z.shape


#: Calls with words of other programs, and what is said.
WORDS = {
    "bracket": (
        lambda: lissom.root(np.cos, bracket=[1, 2]),
        "such as x0=0.5 * (a + b); `scipy.optimize.brentq(fun, a, b)` takes a bracket",
    ),
    "tendon at an angle": (
        lambda: lissom.Tendon("t", radius=0.01, angle=0.1, tension=1.0),
        "'angle' (it runs along a rod at the distances (y, z) from its axis: at radius r and angle phi "
        "path=[lissom.Along(offset=(r * cos(phi), r * sin(phi)))])",
    ),
    "joint of a motor": (lambda: lissom.Motor(torque=1.0), "'joint': the name of the link whose joint it"),
    "offset of a link": (lambda: lissom.Link("a", offset=(0, 0, 1)), "did you mean 'position'?"),
    "pos of a link": (lambda: lissom.Link("a", pos=(0, 0, 1)), "did you mean 'position'?"),
    "quat of a link": (lambda: lissom.Link("a", quat=(1, 0, 0, 0)), "did you mean 'orientation'?"),
    "load of the tip": (lambda: rod(tip_load=(0, 0, -1)), "did you mean 'tip_force'?"),
    "position of a target": (lambda: lissom.Target("a", position=(0, 0, 1)), "did you mean 'pose'?"),
    "callback": (lambda: lissom.simulate(rod(), 1.0, callback=print), "did you mean 'progress'?"),
    "t_max": (lambda: lissom.simulate(rod(), t_max=1.0), "did you mean 't_end'?"),
    "section by its stiffness": (
        lambda: lissom.Section(EI=1.0),
        "base of other classes: lissom.Section.circle(radius), ",
    ),
}


@pytest.mark.parametrize("what", WORDS)
def test_words_of_other_programs(what):
    call, expected = WORDS[what]
    said = said_by(call)
    assert expected in said, said
    assert said.count(expected[:40]) == 1


def test_rotation_matrices_are_answered_with_their_quaternions():
    turned = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    said = said_by(lambda: rod(base_orientation=turned))
    (code,) = re.findall(r"the quaternion \(w, x, y, z\) of this matrix is (.*)$", said)
    pose = rod(base_orientation=eval(code)).pose([0.0, 0.0], 0.0)
    np.testing.assert_allclose(pose[:3, :3], turned, atol=1e-15)
    assert "quaternion" not in said_by(lambda: rod(base_orientation=np.eye(2)))


#: Words of other programs, and what is said of them.
ANSWERS = {
    "gains=(kp, kd)": lambda: lissom.Motor("hinge", position=0.1, kp=3.0),
    "`limits` belong to what it drives": lambda: lissom.Input("pull", min=0.0),
    "the accuracy of the shape is `rtol`": lambda: lissom.statics(rod(), accuracy=1e-4),
    "frequency=omega / (2 * pi)": lambda: lissom.Harmonic(amplitude=1.0, omega=3.0),
    "did you mean 'rate'": lambda: sensors.Imu(rod(), "rod", frequency=100.0),
    "did you mean 'noise'": lambda: sensors.Imu(rod(), "rod", std=0.1),
    "got the class Free": lambda: lissom.Link("a", joint=lissom.Free),
    "got Link; its `name` is one": lambda: lissom.Link("b", parent=lissom.Link("a")),
}


@pytest.mark.parametrize("sentence", ANSWERS)
def test_words_and_parts_of_other_programs_are_answered(sentence):
    assert sentence in said_by(ANSWERS[sentence])
