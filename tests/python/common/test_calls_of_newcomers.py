"""What newcomers type first is answered with what to write."""

import re

import numpy as np
import pytest

import lissom
from lissom import sensors

PENDULUM = lissom.SpringPendulum()


def rod(**options):
    return lissom.Rod([lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 2})], **options)


def pulled():
    path = [lissom.Along(offset=(0, 0.01))]
    return rod(actuators=[lissom.Tendon(name, path, tension=lissom.Input(name)) for name in "ab"])


def body(**options):
    link = lissom.Link(
        "arm",
        joint=lissom.Revolute((0, 1, 0), stiffness=10.0, damping=0.1),
        body=lissom.Body(0.5, centre=(0.2, 0, 0), inertia=np.diag([1e-4, 5e-3, 5e-3])),
    )
    return lissom.Robot([link], **options)


def oscillator(t, q, v, a):
    return a + q


#: Calls with more arguments without names than there are, and what the message says.
POSITIONAL = {
    "simulate": (lambda: lissom.simulate(PENDULUM, 10, [0.1, 0.2]), "(model, t_end) but 3", "`q0=...`"),
    "simulate_many": (lambda: lissom.simulate_many(PENDULUM, 10, [[0.1, 0.2]]), "3 were given", "`q0=...`"),
    "newmark": (
        lambda: lissom.newmark(oscillator, (0, 1), [1.0], [0.0], 0.1),
        "4 positional arguments (residual, t_span, q0, v0) but 5 were given",
        "`dt=...`",
    ),
    "Simulation": (lambda: lissom.Simulation(PENDULUM, 0.1), "(model) but 2", "`dt=...`"),
    "Simulations": (lambda: lissom.Simulations(PENDULUM, 3, 0.1), "(model, count) but 3", "`dt=...`"),
    "statics": (lambda: lissom.statics(pulled(), [0, 0], [1.0, 0.0]), "(model, q0) but 3", "by name"),
    "continuation": (lambda: lissom.continuation(rod(), [0, 0], 0.5), "(model, q0) but 3", "load_factor"),
    "modes": (lambda: lissom.modes(rod(), [0, 0], 0.0), "(model, q) but 3", "`t=...`"),
    "actuate": (lambda: lissom.actuate(pulled(), (0, 0, 0), ["a"]), "(robot, target) but 3", "inputs"),
    "root": (lambda: lissom.root(np.sin, 3.0, np.cos), "(fun, x0) but 3", "`jac=...`"),
    "choose_modes": (lambda: lissom.choose_modes(rod(), 0.1, 1e-3), "(rod, t_end) but 3", "rtol"),
    "Robot.pose": (lambda: rod().pose([0, 0], 0.1, "rod"), "(q, X) but 3", "`link=...`"),
    "Input": (lambda: lissom.Input("a", [0, 1], [1, 2]), "(name, default) but 3 were given", ""),
    # Written in Python.
    "linearise": (lambda: lissom.linearise(rod(), [0, 0], "forces", "coordinates", 0.0), "but 5", "held"),
    "MotionResult.animate": (
        lambda: lissom.simulate(rod(), 0.01).animate("x.gif", 25),
        "1 positional arguments (path) but 2 were given",
        "by name, of fps, speed",
    ),
}


@pytest.mark.parametrize("function", POSITIONAL)
def test_arguments_that_need_names_are_told_them(function):
    call, counted, named = POSITIONAL[function]
    with pytest.raises(TypeError) as caught:
        call()
    said = str(caught.value)
    assert said.startswith(f"{function}() takes ")
    assert counted in said
    assert named in said


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda: lissom.newmark(oscillator, (0, 1), 1.0, 0.0, dt=0.1),
            "q0: .*; a vector of this number is [1]",
        ),
        (lambda: lissom.newmark(oscillator, (0, 1), [1.0], 0.5, dt=0.1), "v0: .* this number is [0.5]"),
        (lambda: lissom.solve_ivp(lambda t, y: -y, (0, 1), 1.5), "y0: .* this number is [1.5]"),
        (lambda: lissom.RK45(lambda t, y: -y, 0.0, 2, 1.0), "y0: .* this number is [2]"),
        (
            lambda: lissom.statics(pulled(), u=[[1, 2]]),
            "got list of shape (1, 2); its single row, of shape (2,), is one",
        ),
        (lambda: lissom.simulate(pulled(), 0.1, u=np.zeros((1, 2))), "its single row, of shape (2,), is one"),
        (
            lambda: lissom.sensitivity(pulled(), 0.1, ["segments[0].radius"], u=[1, 2, 3]),
            "u: got shape (1, 3), expected (2,): one number per input",
        ),
    ],
)
def test_vectors_are_shown_as_they_are_written(call, said):
    pattern = ".*".join(map(re.escape, said.split(".*")))
    with pytest.raises((TypeError, ValueError), match=pattern):
        call()


def test_a_vector_of_several_entries_is_not_one_of_this_number():
    with pytest.raises(TypeError, match=r"array of 2 real numbers, got float$"):
        lissom.simulate(PENDULUM, 1.0, q0=1.0)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: lissom.newmark(oscillator, (0, 1), [1.0], [0.0], dt=0.1, method="HHT"), '"hht"?'),
        (
            lambda: lissom.newmark(oscillator, (0, 1), [1.0], [0.0], dt=0.1, method="verlet"),
            '"central_difference"?',
        ),
        (lambda: lissom.simulate(PENDULUM, 0.1, method="HHT"), '"hht"?'),
        (lambda: lissom.simulate(PENDULUM, 0.1, method="BDF"), '"radau"?'),
        (lambda: lissom.solve_ivp(lambda t, y: -y, (0, 1), [1.0], method="rk4"), "'rk45'?"),
        (lambda: lissom.solve_ivp(lambda t, y: -y, (0, 1), [1.0], method="LSODA"), "'radau'?"),
        (lambda: lissom.root(np.sin, 3.0, method="hybr"), "'trust_region'?"),
        (lambda: lissom.root(np.sin, 3.0, method="linesearch"), "'line_search'?"),
    ],
)
def test_methods_of_other_programs_are_answered_with_those_of_lissom(call, said):
    with pytest.raises(ValueError, match=rf"; did you mean {re.escape(said)}$"):
        call()


TABLE = [[0.0, 0.0], [1.0, 1.0]]


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: lissom.simulate(pulled(), 0.1, control=TABLE), r"`control=lambda t, q, v: \[numpy.interp"),
        (
            lambda: lissom.simulate(pulled(), 0.1, control=np.array(TABLE)),
            r"for inputs that are held `u=\.\.\.`",
        ),
        (
            lambda: lissom.Input("a", np.zeros(5)),
            r"one number, or three; a table .* \(times, values\), or by",
        ),
        (lambda: lissom.Input([0, 1, 2]), r"name: expected a string, got list; an input has a name and one"),
    ],
)
def test_tables_in_place_of_inputs_say_what_to_write(call, said):
    with pytest.raises((TypeError, ValueError), match=said):
        call()


def test_what_is_advised_for_tables_works():
    times, values = [0.0, 0.1], [0.0, 2.0]
    motion = lissom.simulate(pulled(), 0.1, control=lambda t, q, v: [np.interp(t, times, values), 0.0])
    assert motion.u[-2, 0] > 1.0
    path = [lissom.Along(offset=(0, 0.01))]
    table = rod(actuators=[lissom.Tendon("a", path, tension=(times, values))])
    assert lissom.simulate(table, 0.1).success


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda: lissom.sensitivity(rod(), 0.1, ["segments[0].radius"], objective=lambda run: run.q[-1]),
            r"objective\(t, q, v\), with the whole run: times .* but takes \(run\): write `def",
        ),
        (
            lambda: lissom.sensitivity(rod(), 0.1, ["segments[0].radius"], objective=lambda t, q, v: 1.0),
            r"returned float, expected \(value, dvalue/dq, dvalue/dv\): a number of the whole run",
        ),
        (
            lambda: lissom.equilibrium_sensitivity(
                rod(), ["segments[0].radius"], objective=lambda t, q, v: 1.0
            ),
            r"objective\(q\), with the coordinates of the equilibrium \(n,\), but takes \(t, q, v\)",
        ),
        (lambda: sensors.Marker(body(), link="arm", X=0.1), r"did you mean 'at'\?"),
        (
            lambda: sensors.Marker(body(), link="arm", at=0.1),
            r"^at: got 0.1, but link 'arm' has no .*: leave it out$",
        ),
    ],
)
def test_functions_and_places_are_asked_for_as_they_are_called(call, said):
    with pytest.raises((TypeError, ValueError), match=said):
        call()


def test_saturated_motors_are_pointed_out_by_linear_models():
    motor = lissom.Motor("arm", lissom.Input("u"), limits=(-0.1, 0.1))
    robot = body(actuators=[motor], gravity=(0, 0, 0))
    at_limit = lissom.statics(robot, u=[1.0]).q
    with pytest.warns(
        lissom.AccuracyWarning, match=r"Motors at their limits: 'arm' \(0.1, limits -0.1 and 0.1\)"
    ):
        lost = lissom.linearise(robot, at_limit, "inputs", u=[1.0])
    # Within the limits there is no warning, which would fail the test.
    within = lissom.linearise(robot, lissom.statics(robot, u=[0.02]).q, "inputs", u=[0.02])
    assert abs(lost.B).max() < 1e-2 * abs(within.B).max()


def test_energy_that_rises_where_something_acts_is_said_so():
    free = body()
    runs = {
        "a motor": lissom.Robot(free.links, actuators=[lissom.Motor("arm", torque=1.0)]),
        "an input": lissom.Robot(free.links, actuators=[lissom.Motor("arm", torque=lissom.Input("u", 1.0))]),
    }
    for robot in runs.values():
        link = lissom.Link("arm", joint=lissom.Revolute((0, 1, 0)), body=free.links[0].body)
        spun = lissom.Robot([link], actuators=robot.actuators)
        with pytest.warns(
            lissom.AccuracyWarning,
            match="kinetic energy, beyond what loads, motors and inputs supply: steps of",
        ):
            lissom.simulate(spun, 5.0, dt=0.2)


def test_a_run_shorter_than_a_step_names_the_step_that_it_takes():
    stopped = lissom.newmark(lambda t, q, v, a: a * np.nan if t > 0 else a, (0, 1), [1.0], [0.0], dt=5.0)
    assert "(step size 1)" in stopped.message
