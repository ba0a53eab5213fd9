"""Inputs of `statics`, `modes`, `linearise`, `continuation`: closed forms, differences, folds, errors."""

import re

import control
import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

RADIUS, LENGTH, MODULUS, OFFSET = 2e-3, 0.2, 1e9, 0.01
STIFFNESS = MODULUS * np.pi / 4 * RADIUS**4
MODES = {"bend_y": 4, "bend_z": 4}


def tendon(name, y, z, default=0.0, **more):
    given = {"tension": lissom.Input(name, default)} | more
    return lissom.Tendon(name, [lissom.Along(offset=(y, z))], **given)


def finger(actuators, modes=MODES, **more):
    segment = lissom.Segment(LENGTH, RADIUS, MODULUS, 4e8, 1200, modes, retardation_time=1e-3)
    return lissom.Rod([segment], actuators=actuators, **{"gravity": (0, 0, 0)} | more)


def pair(**more):
    return finger([tendon("a", 0.0, OFFSET, 2.0), tendon("b", 0.0, -OFFSET)], **more)


def test_statics_is_done_at_the_inputs_that_are_given():
    rod = pair()
    for u in ([2.0, 0.0], [5.0, 1.0], [0.0, 3.0]):
        curvature = -(u[0] - u[1]) * OFFSET / STIFFNESS
        found = lissom.statics(rod, u=u)
        assert found.success
        assert found.slack == []
        assert_allclose(rod.strain(found.q, 0.1)[1], curvature, rtol=1e-9)
    assert_allclose(lissom.statics(rod).q, lissom.statics(rod, u=rod.u0).q, atol=0)
    # From a nearby start and by Newton's method the result is the same.
    near = lissom.statics(rod, u=[5.0, 1.0]).q
    for method in ("descent", "newton"):
        assert_allclose(
            lissom.statics(rod, near, u=[5.5, 1.0], method=method).q,
            lissom.statics(rod, u=[5.5, 1.0]).q,
            atol=1e-9,
        )


def test_stiff_tendons_of_given_length_do_not_stop_newtons_method():
    lengths = [
        tendon(name, y, z, tension=None, length=lissom.Input(name, LENGTH - 1e-4), stiffness=1e6)
        for name, y, z in (("a", 0, OFFSET), ("b", OFFSET, -OFFSET), ("c", -OFFSET, -OFFSET))
    ]
    rod = finger(lengths, gravity=(0, 0, 9.81))
    near = lissom.statics(rod)
    for change in (0.0, 1e-5, 2e-4):
        found = lissom.statics(rod, near.q, u=rod.u0 + np.array([change, -change, 0.0]), method="newton")
        assert found.status == "converged"
        assert found.step_norm <= 1e-10
        assert_allclose(
            found.q, lissom.statics(rod, near.q, u=rod.u0 + np.array([change, -change, 0.0])).q, atol=1e-7
        )


def test_the_result_says_which_tendons_are_slack_and_which_were_told_to_push():
    rod = finger(
        [
            tendon("a", 0.0, OFFSET),
            tendon("b", 0.0, -OFFSET),
            tendon("c", OFFSET, 0.0, tension=None, length=1.01 * LENGTH, stiffness=1e3),
        ]
    )
    found = lissom.statics(rod, u=[1.0, -2.0])
    assert found.slack == ["b", "c"] or found.slack == ["c", "b"]
    assert "Slack: " in found.message
    assert "The commanded tension of 'b' is -2 N: a tendon never pushes." in found.message
    assert "'a'" not in found.message
    assert_allclose(found.q, lissom.statics(rod, u=[1.0, 0.0]).q, atol=1e-12)
    assert lissom.statics(pair()).message == "The forces are in equilibrium."


def test_modes_are_those_of_the_robot_with_constant_tensions():
    u = [6.0, 2.0]
    rod = pair(gravity=(0, 0, -9.81))
    constant = finger(
        [tendon("a", 0.0, OFFSET, tension=6.0), tendon("b", 0.0, -OFFSET, tension=2.0)], gravity=(0, 0, -9.81)
    )
    q = lissom.statics(rod, u=u).q
    assert_allclose(q, lissom.statics(constant).q, atol=1e-12)
    given = lissom.modes(rod, q, u=u)
    assert given.residual_norm < 1e-12
    assert_allclose(given.frequency, lissom.modes(constant, q).frequency, rtol=1e-12)
    assert lissom.modes(rod, q).residual_norm > 1e-3


def pushed():
    """Two tendons and a force."""
    load = lissom.Load(force=lissom.Input("push", (0.0, 0.01, 0.02)), at=LENGTH)
    return pair(loads=[load], gravity=(0, 0, -9.81))


@pytest.mark.parametrize("names", ["inputs", "a", ("b", "push.y"), "push", ("forces", "a")])
def test_linear_models_have_the_inputs_of_the_model(names):
    robot, u = pushed(), np.array([0.1, -0.2, 0.05, 4.0, 1.0])
    assert robot.inputs == ("push.x", "push.y", "push.z", "a", "b")
    q = lissom.statics(robot, u=u).q
    linear = lissom.linearise(robot, q, inputs=names, outputs="tip_position", u=u)
    wanted = []
    for name in [names] if isinstance(names, str) else names:
        wanted += {
            "inputs": list(robot.inputs),
            "push": [f"push.{axis}" for axis in "xyz"],
            "forces": [f"force{i}" for i in range(robot.n)],
        }.get(name, [name])
    assert linear.inputs == tuple(wanted)
    rest, step = np.zeros(robot.n), 1e-4
    for column, name in zip(linear.B[robot.n :].T, wanted, strict=True):
        if name not in robot.inputs:
            continue
        change = step * (np.array(robot.inputs) == name)
        after, before = (robot.forward_dynamics(q, rest, u=u + sign * change) for sign in (1, -1))
        assert_allclose(column, (after - before) / (2 * step), atol=1e-7 * np.abs(column).max())


def test_gains_of_linear_models_are_the_sensitivities_of_equilibria():
    robot, u, step = pushed(), np.array([0.0, 0.0, 0.0, 4.0, 1.0]), 1e-4
    q = lissom.statics(robot, u=u).q
    system = control.ss(*lissom.linearise(robot, q, inputs="inputs", outputs="tip_position", u=u))
    gain = system.dcgain()
    for k in range(len(u)):
        change = step * np.eye(len(u))[k]
        after, before = (
            robot.pose(lissom.statics(robot, q, u=u + sign * change).q)[:3, 3] for sign in (1, -1)
        )
        assert_allclose(gain[:, k], (after - before) / (2 * step), atol=2e-6 * np.abs(gain[:, k]).max())


def test_what_linear_models_are_not_asked_for():
    with pytest.raises(ValueError, match=r"inputs: got 'inputs', expected 'forces'"):
        lissom.linearise(lissom.SpringPendulum(), [0.0, 0.1], inputs="inputs")
    with pytest.raises(ValueError, match=r"inputs: got 'c', expected 'forces', .*'inputs'"):
        lissom.linearise(pair(), np.zeros(8), inputs="c")


WEIGHT = 2.0 * 9.81 * 0.5


def arm(stiffness):
    """A hinge about -y, so that positive angles lift: the torque m g l cos(angle) + k angle holds it."""
    body = lissom.Body(2.0, centre=(0.5, 0, 0), inertia=(0.1, 0.1, 0.1))
    joint = lissom.Revolute((0, -1, 0), stiffness=stiffness)
    motor = lissom.Motor("arm", torque=lissom.Input("torque", 0.0))
    return lissom.Robot([lissom.Link("arm", body=body, joint=joint)], actuators=[motor])


@pytest.mark.parametrize("stiffness", [0.0, 3.0])
def test_paths_of_inputs_turn_where_there_is_no_equilibrium_beyond(stiffness):
    def torque(angle):
        return WEIGHT * np.cos(angle) + stiffness * angle

    robot, lowest, highest = arm(stiffness), -np.pi / 2, np.arcsin(stiffness / WEIGHT)
    inputs = {"torque": (torque(lowest), 2 * WEIGHT)}
    found = lissom.continuation(robot, [lowest], inputs=inputs, bounds=(-0.1, 1.0))
    assert found.success
    fold = found.path.critical_points[0]
    assert fold.kind == "limit"
    assert_allclose(fold.u, [torque(highest)], rtol=1e-8)
    assert_allclose(fold.q, [highest], atol=1e-4)
    torques, angles = found.path.u[:, 0], found.path.q[:, 0]
    assert_allclose(torques, torque(angles), atol=1e-8)
    assert_allclose(
        torques,
        np.interp(found.path.load_factor, [-0.1, 1.0], [1.1 * torque(lowest) - 0.2 * WEIGHT, 2 * WEIGHT]),
        atol=1e-12,
    )
    stable = np.array([word == "stable" for word in found.path.stability])
    assert stable[angles < highest - 0.01].all()
    assert not stable[(angles > highest + 0.01) & (angles < 2.5)].any()


def buckled_column():
    """A column at one and a half times its buckling load, with a tendon on each side."""
    critical = np.pi**2 / 4 * STIFFNESS / LENGTH**2
    return finger(
        [tendon("left", 0.0, OFFSET), tendon("right", 0.0, -OFFSET)],
        {"bend_y": 6},
        tip_force=(-1.5 * critical, 0, 0),
    )


def test_a_column_that_is_pulled_over_snaps_at_the_limit_point_of_its_tension():
    column = buckled_column()
    start = lissom.statics(column, 0.1 / LENGTH * np.eye(6)[0])
    side = np.sign(column.pose(start.q)[2, 3])
    softer = lissom.statics(column, start.q, u=[1e-3, 0]).lowest_eigenvalue < start.lowest_eigenvalue
    against, pulling = ("left", np.array([1.0, 0.0])) if softer else ("right", np.array([0.0, 1.0]))
    found = lissom.continuation(column, start.q, inputs={against: (0.0, 10.0)})
    fold = found.path.critical_points[0]
    assert fold.kind == "limit"
    tension = max(fold.u)
    before, beyond = (lissom.statics(column, fold.q, u=part * tension * pulling) for part in (0.999, 1.001))
    assert before.is_stable
    assert beyond.is_stable
    assert np.sign(column.pose(before.q)[2, 3]) == side
    assert np.sign(column.pose(beyond.q)[2, 3]) == -side


def test_paths_of_inputs_pass_through_the_equilibria_of_statics():
    robot = pushed()
    found = lissom.continuation(
        robot, inputs={"a": (0.0, 8.0), "push": ((0, 0, 0), (0, 0.1, 0))}, u=[0, 0, 0, 0, 1.0]
    )
    assert found.status == "finished"
    assert found.path.u.shape == (len(found.path.load_factor), 5)
    assert_allclose(found.path.u[[0, -1]], [[0, 0, 0, 0, 1], [0, 0.1, 0, 8, 1]], atol=1e-12)
    for u, q in zip(found.path.u, found.path.q, strict=True):
        assert_allclose(lissom.statics(robot, q, u=u).q, q, atol=1e-7)
    assert lissom.continuation(robot).path.u is None


def test_paths_of_inputs_take_loads_at_their_time():
    table = ([0.0, 1.0], [(0, 0, 0), (0, 0, 0.3)])
    robot = pair(loads=[lissom.Load(force=table, at=LENGTH)])
    found = lissom.continuation(robot, inputs={"a": (0.0, 5.0)}, t=0.5)
    assert_allclose(
        found.path.q[-1], lissom.statics(robot, found.path.q[-1], t=0.5, u=[5.0, 0.0]).q, atol=1e-7
    )
    assert np.abs(found.path.q[-1] - lissom.statics(robot, u=[5.0, 0.0]).q).max() > 0.1


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"u": [1.0]}, "u: expected 2 values, got 1"),
        ({"u": [1.0, np.nan]}, r"u\[1\]: got NaN"),
        (
            {"inputs": {"aa": (0, 1)}},
            "inputs: got 'aa', expected one of the inputs: 'a', 'b'; did you mean 'a'",
        ),
        ({"inputs": {"a": 3.0}}, r"inputs\['a'\]: expected a pair of values, got float"),
        ({"inputs": {"a": (1.0, 1.0)}}, "inputs: got the same `from` and `to`"),
        ({"inputs": {"a": (0.0, np.inf)}}, "got inf"),
        ({"inputs": [1.0, 2.0]}, "inputs: expected a mapping from names of inputs to pairs"),
    ],
)
def test_inputs_that_make_no_sense_are_refused(given, message):
    with pytest.raises((ValueError, TypeError), match=message):
        lissom.continuation(pair(), **given)


@pytest.mark.parametrize(
    "ask",
    [
        lissom.statics,
        lambda rod, u: lissom.modes(rod, np.zeros(8), u=u),
        lambda rod, u: lissom.linearise(rod, np.zeros(8), u=u),
    ],
)
def test_wrong_inputs_are_refused_everywhere(ask):
    with pytest.raises(ValueError, match="u: expected 2 values, got 3"):
        ask(pair(), u=[1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match=r"u\[0\]: got inf"):
        ask(pair(), u=[np.inf, 2.0])


@pytest.mark.parametrize("stretches", [False, True])
def test_paths_go_on_where_a_tendon_becomes_slack(stretches):
    """The path has a corner there, beyond which no tangent leads."""
    modes = {"bend_y": 2} | ({"stretch": 1} if stretches else {})
    tendon = lissom.Tendon(
        "t", [lissom.Along(offset=(0.0, 0.006))], length=lissom.Input("l", 0.29), stiffness=300.0
    )
    soft = lissom.Segment(0.3, 0.006, 2e6, 8e5, 1100.0, modes)
    model = lissom.Rod([soft], gravity=(0, 0, 0), tip_force=(0, 0, 0.02), actuators=[tendon])
    slack = lissom.statics(model, u=[0.32])
    threshold = model.actuator_length("t", slack.q)
    assert 0.28 < threshold < 0.32
    for span in ((0.28, 0.32), (0.32, 0.28)):
        found = lissom.continuation(model, inputs={"l": span})
        assert found.status == "finished", found.message
        lengths = found.path.u[:, 0]
        assert_allclose(lengths[[0, -1]], span, rtol=1e-9)
        assert (np.sign(np.diff(lengths)) == np.sign(span[1] - span[0])).all()
        for length, q in zip(lengths, found.path.q, strict=True):
            assert_allclose(q, lissom.statics(model, u=[length]).q, rtol=0, atol=1e-6)
        beyond = found.path.q[lengths > threshold + 1e-6]
        assert_allclose(beyond, np.tile(slack.q, (len(beyond), 1)), rtol=0, atol=1e-6)


def pulled_to_a_point(joint):
    """A body pulled to a point of the world by two newtons, which is more than its weight."""
    body = lissom.Body(0.1, inertia=(1e-3,) * 3)
    path = [lissom.Via(None, (0.1, 0.0, 0.0)), lissom.Via("body", (0.0, 0.0, 0.0))]
    tendon = lissom.Tendon("t", path, tension=2.0)
    link = lissom.Link("body", joint=joint, body=body)
    return lissom.Robot([link], gravity=(-9.81, 0, 0), actuators=[tendon])


@pytest.mark.parametrize("joint", [lissom.Free(), lissom.Prismatic((1, 0, 0))])
def test_what_a_tendon_pulls_together_is_no_equilibrium(joint):
    found = lissom.statics(pulled_to_a_point(joint))
    assert not found.success, found.message
    assert found.status in ("collapsed", "stalled", "step_too_small", "no_start", "iteration_limit")


def test_motions_end_where_a_tendon_pulls_two_points_together():
    damped = pulled_to_a_point(lissom.Prismatic((1, 0, 0), damping=100.0))
    motion = lissom.simulate(damped, 100.0, dt=0.1, method="radau")
    assert motion.status == "collapsed", motion.message
    assert "tendon number 1 has pulled together" in motion.message
    # The damper limits the speed to the value at which it balances the excess of the pull over the weight.
    assert_allclose(motion.t[-1], 0.1 / ((2.0 - 0.981) / 100.0), rtol=1e-2)
    # Fixed steps go over the point, where the force turns round.
    assert not lissom.simulate(damped, 100.0, dt=0.1).success


def test_points_that_belong_together_may_touch():
    """Without a force, or on one body."""
    body = lissom.Body(0.1, inertia=(1e-3,) * 3)
    touching = [lissom.Via(None, (0.0, 0.0, 0.0)), lissom.Via("body", (0.0, 0.0, 0.0))]
    together = [lissom.Via("body", (0.0, 0.1, 0.0))] * 2
    for path, tension in ((touching, 0.0), ([*together, lissom.Via(None, (1.0, 0.0, 0.0))], 1.0)):
        tendon = lissom.Tendon("t", path, tension=tension)
        link = lissom.Link("body", joint=lissom.Prismatic((1, 0, 0), stiffness=10.0), body=body)
        model = lissom.Robot([link], gravity=(0, 0, 0), actuators=[tendon])
        assert lissom.simulate(model, 0.1, dt=0.01).success
        assert lissom.statics(model).success


def with_a_force():
    load = lissom.Load(force=lissom.Input("u", (0, 0, 0)))
    return finger([tendon("pull", 0.0, OFFSET)], loads=[load])


REFUSED_PATHS = {
    "a number for a vector": (
        {"u": (0, 0.1)},
        "inputs['u'][0]: got 0, expected 3 numbers: the input is a vector",
    ),
    "a number at its end": (
        {"u": ((0, 0, 0), 0.1)},
        "inputs['u'][1]: got 0.1, expected 3 numbers: the input is a vector",
    ),
    "two numbers for a vector": (
        {"u": ((0, 0), (0, 1))},
        "inputs['u'][0]: got 2 values, expected 3 values",
    ),
    "three numbers for one": (
        {"pull": (0, (1, 2, 3))},
        "inputs['pull'][1]: got 3 values, expected 1 values",
    ),
    "a vector and its entry": (
        {"u": ((0, 0, 0), (0, 0, 0.01)), "u.z": (0, 0.02)},
        "inputs: 'u' and 'u.z' both set 'u.z': give only one of them",
    ),
    "an entry and its vector": (
        {"u.z": (0, 0.02), "u": ((0, 0, 0), (0, 0, 0.01))},
        "inputs: 'u.z' and 'u' both set 'u.x', 'u.y', 'u.z': give only one of them",
    ),
    "no number": ({"pull": (0, np.nan)}, "inputs['pull'][1]: got NaN, expected a finite number"),
    "no number of a vector": (
        {"u": ((0, 0, 0), (0, np.inf, 0))},
        "inputs['u'][1][1]: got inf, expected a finite number",
    ),
}


@pytest.mark.parametrize("case", REFUSED_PATHS)
def test_paths_of_inputs_are_refused_by_their_names(case):
    inputs, said = REFUSED_PATHS[case]
    with pytest.raises(ValueError, match=f"^{re.escape(said)}$"):
        lissom.continuation(with_a_force(), inputs=inputs)


def test_a_vector_is_led_by_two_triples_or_entry_by_entry():
    rod = with_a_force()
    whole = lissom.continuation(rod, inputs={"u": ((0, 0, 0), (0, 0, 0.01))}).path
    entry = lissom.continuation(rod, inputs={"u.z": (0, 0.01), "u.x": (0, 0)}).path
    assert_allclose(whole.u[-1], [0, 0, 0.01, 0])
    assert_allclose(entry.u[-1], whole.u[-1])


@pytest.mark.parametrize("sliding", [-5.0, -1.5, -0.5, 0.0, 0.7, 3.0])
def test_a_direction_of_sliding_is_held_within_one(sliding):
    rubbing = tendon("t", 0.0, OFFSET, tension=2.0, friction=0.3, sliding=lissom.Input("s", 0.0))
    rod = finger([rubbing])
    q, step = np.full(rod.n, 0.5), 1e-5
    rest = np.zeros(rod.n)

    def forces(s):
        return rod.inverse_dynamics(q, rest, rest, u=[s])

    held = np.clip(sliding, -1.0, 1.0)
    assert_allclose(forces(sliding), forces(held), atol=0)
    by_differences = (forces(sliding + step) - forces(sliding - step)) / (2 * step)
    assert_allclose(rod.input_tangent(q, u=[sliding])[:, 0], by_differences, rtol=0, atol=1e-9)
    if abs(sliding) < 1:
        assert np.abs(by_differences).max() > 1e-6
