"""Joints with prescribed motion, or that mimic other joints.

Everything is compared with the same robot with free joints, whose forces come from the NumPy reference or
from `lissom`: driven coordinates are ``q_all = G q + o(t)``, forces ``G.T @ tau_all``."""

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import lissom
from lissom import BaseMotion, Body, Free, Harmonic, Link, Mimic, Prismatic, Revolute, Robot
from reference.random_robots import random_states, robots, seeds
from reference.robot import build

few = settings(max_examples=10)
SOFT = lissom.Segment(
    0.3,
    (0.012, 0.008),
    4e5,
    poisson_ratio=0.4,
    density=1100,
    modes={"torsion": 1, "bend_y": 2, "bend_z": 2},
    retardation_time=0.01,
)
BALL = Body(0.3, centre=(0.1, 0.02, -0.03), inertia=(4e-4, 6e-4, 7e-4))
SWAY = Harmonic(0.4, 1.3, phase=0.3, mean=0.2, rate=0.5)
METHODS = ("newmark", "hht", "generalised_alpha", "rk45", "dop853", "radau", "auto")


def sway(t):
    """`SWAY` with its derivatives."""
    w = 2 * np.pi * 1.3
    s, c = np.sin(w * t + 0.3), np.cos(w * t + 0.3)
    return 0.2 + 0.5 * t + 0.4 * s, 0.5 + 0.4 * w * c, -0.4 * w * w * s


def assert_close(actual, desired, tolerance=1e-10):
    """Compares relative to the largest value, because entries may vanish."""
    assert_allclose(actual, desired, rtol=0, atol=tolerance * max(1e-6, np.abs(desired).max(initial=0)))


def state(n, seed=1, size=0.4):
    return size * np.random.default_rng(seed).standard_normal((3, n))


def test_accelerations_know_what_is_driven():
    """The time derivative of the velocity, for links with driven and with free joints."""
    links = [
        Link("driven", body=BALL, joint=Revolute((0, 0, 1), motion=SWAY)),
        Link("free", parent="driven", position=(0.2, 0, 0), rod=[SOFT], joint=Revolute((0, 1, 0))),
        Link("mimic", parent="free", body=BALL, joint=Revolute((1, 0, 0), mimic=Mimic("free"))),
    ]
    moved = BaseMotion(translation=Harmonic((0.1, 0, 0.2), 1.1), axis=(1, 0, 0), angle=Harmonic(0.3, 0.9))
    robot = Robot(links, base_motion=moved)
    q, v, a = state(robot.n)
    now, step = 0.4, 1e-4
    for link in robot.links:

        def velocity(t, link=link.name):
            return robot.velocity(q + v * t + a * t**2 / 2, v + a * t, link=link, t=now + t)

        near, far = (velocity(h) - velocity(-h) for h in (step, 2 * step))
        found = robot.acceleration(q, v, a, link=link.name, t=now)
        assert_close(found, (8 * near - far) / (12 * step), 1e-9)


def derivatives(robot, q, v, a, **at):
    """Tangents by central differences."""
    step, found = 1e-6, []
    for part in range(3):
        columns = np.empty((robot.n, robot.n))
        for k in range(robot.n):
            shift = np.zeros((3, robot.n))
            shift[part, k] = step
            plus, minus = (np.array([q, v, a]) + sign * shift for sign in (1, -1))
            columns[:, k] = robot.inverse_dynamics(*plus, **at) - robot.inverse_dynamics(*minus, **at)
        found.append(columns / (2 * step))
    return found


def assert_tangents_are_derivatives(robot, q, v, a, **at):
    rounding = 1e-15 / 1e-6 * np.abs(robot.inverse_dynamics(q, v, a, **at)).max(initial=0)
    for tangent, differences in zip(
        robot.tangent(q, v, a, **at), derivatives(robot, q, v, a, **at), strict=True
    ):
        size = np.abs(differences).max(initial=0)
        assert_allclose(tangent, differences, rtol=0, atol=1e-6 * size + 10 * rounding)


# Motions


def turret(joint, **options):
    """A rod and a rigid link on a joint."""
    return Robot(
        [
            Link("turret", body=BALL, joint=joint, position=(0, 0, 0.2)),
            Link("arm", rod=[SOFT], parent="turret", position=(0.1, 0, 0)),
            Link("ball", body=BALL, joint=Revolute((0, 1, 0), damping=0.01), parent="arm", at=0.15),
        ],
        **options,
    )


@pytest.mark.parametrize("axis", [(0, 0, 1), (0.3, -0.5, 0.8)])
def test_a_prescribed_hinge_is_a_base_that_turns(axis):
    driven = turret(Revolute(axis, motion=SWAY))
    moved = turret(lissom.Weld(), base_motion=BaseMotion(axis=axis, angle=SWAY))
    assert driven.n == moved.n == 6
    assert "turret.angle" not in driven.coordinates
    q, v, a = state(6)
    t = 0.37
    assert_close(driven.inverse_dynamics(q, v, a, t=t), moved.inverse_dynamics(q, v, a, t=t))
    for of_driven, of_moved in zip(driven.tangent(q, v, a, t=t), moved.tangent(q, v, a, t=t), strict=True):
        assert_close(of_driven, of_moved)
    assert_close(driven.forward_dynamics(q, v, t=t), moved.forward_dynamics(q, v, t=t))
    for link in ("turret", "arm", "ball"):
        assert_close(driven.pose(q, link=link, t=t), moved.pose(q, link=link, t=t))
        assert_close(driven.velocity(q, v, link=link, t=t), moved.velocity(q, v, link=link, t=t))
        assert_close(driven.jacobian(q, link=link, t=t), moved.jacobian(q, link=link, t=t))
    assert_close(driven.momentum(q, v, t=t), moved.momentum(q, v, t=t))
    assert_close(driven.centre_of_mass(q, t=t), moved.centre_of_mass(q, t=t))
    assert_close(
        driven.joint_wrench(q, v, a, link="ball", t=t), moved.joint_wrench(q, v, a, link="ball", t=t)
    )
    assert_close(driven.supplied_power(q, v, a, t=t), moved.supplied_power(q, v, a, t=t))
    assert_close(driven.energy(q, v, t=t).total, moved.energy(q, v, t=t).total)


def test_a_link_in_the_middle_of_a_rod_moves_as_prescribed():
    """Its free joint follows a BaseMotion; forces are those of the free robot in the same motion."""
    motion = BaseMotion(
        translation=Harmonic((0.01, 0.02, -0.015), 2.0, phase=0.4),
        axis=(0.3, 0.5, -0.8),
        angle=Harmonic(rate=5.0),
    )

    def robot(joint):
        return Robot(
            [
                Link("rod", rod=[SOFT], joint=Revolute((0, 1, 0))),
                Link("shaker", body=BALL, joint=joint, parent="rod", at=0.12, position=(0, 0, 0.02)),
                Link("whip", rod=[SOFT], parent="shaker", orientation=(0.6, 0, 0.8, 0)),
            ]
        )

    driven, free = robot(Free(motion=motion)), robot(Free())
    assert (driven.n, free.n) == (11, 17)
    own = np.r_[0:6, 12:17]
    q, v, a = state(11)
    # Beyond half a turn the short rotation vector represents the same rotation.
    for t in (0.0, 0.1, 0.3, 0.7):
        whole = np.zeros((3, 17))
        whole[:, own] = q, v, a
        angle = (5 * t + np.pi) % (2 * np.pi) - np.pi
        w, phase = 2 * np.pi * 2.0, 2 * np.pi * 2.0 * t + 0.4
        size = np.array([0.01, 0.02, -0.015])
        axis = np.array([0.3, 0.5, -0.8]) / np.linalg.norm([0.3, 0.5, -0.8])
        whole[0, 6:12] = *(size * np.sin(phase)), *(angle * axis)
        whole[1, 6:12] = *(size * w * np.cos(phase)), *(5 * axis)
        whole[2, 6:9] = -size * w * w * np.sin(phase)
        assert_close(driven.inverse_dynamics(q, v, a, t=t), free.inverse_dynamics(*whole)[own], 1e-9)
        assert_close(driven.pose(q, link="whip", t=t), free.pose(whole[0], link="whip"))
        assert_close(driven.velocity(q, v, link="whip", t=t), free.velocity(*whole[:2], link="whip"))
        drive = np.setdiff1d(np.arange(17), own)
        power = free.inverse_dynamics(*whole)[drive] @ whole[1, drive]
        assert_close(driven.supplied_power(q, v, a, t=t), power, 1e-9)
    assert_tangents_are_derivatives(driven, q, v, a, t=0.3)


def test_rotations_by_quaternions_and_about_an_axis_are_the_same_motion():
    def quaternion(t):
        angle, speed, acceleration = sway(t)
        axis = np.array([0.6, 0, 0.8])
        return (np.cos(angle / 2), *(np.sin(angle / 2) * axis)), speed * axis, acceleration * axis

    turned = turret(Free(motion=BaseMotion(axis=(0.6, 0, 0.8), angle=SWAY)))
    other = turret(Free(motion=BaseMotion(rotation=quaternion)))
    hinge = turret(Revolute((0.6, 0, 0.8), motion=lambda t: sway(t)))
    q, v, a = state(6)
    for t in (0.1, 0.8):
        wanted = hinge.inverse_dynamics(q, v, a, t=t)
        assert_close(turned.inverse_dynamics(q, v, a, t=t), wanted, 1e-9)
        assert_close(other.inverse_dynamics(q, v, a, t=t), wanted, 1e-9)


def test_forms_of_a_motion_agree():
    """A table is a spline; derivatives of a function without them are differences."""
    times = np.linspace(-0.5, 1.5, 4001)
    forms = [SWAY, (times, [sway(t)[0] for t in times]), lambda t: sway(t)[0], lambda t: sway(t)]
    q, v, a = state(6)
    first, *others = (
        turret(Revolute((0, 0, 1), motion=form)).inverse_dynamics(q, v, a, t=0.4) for form in forms
    )
    for other in others:
        assert_close(other, first, 1e-6)
    held = turret(Revolute((0, 0, 1), motion=0.7))
    fixed = turret(Revolute((0, 0, 1), motion=Harmonic(mean=0.7)))
    # A constant motion needs no time.
    assert_close(held.inverse_dynamics(q, v, a), fixed.inverse_dynamics(q, v, a, t=3.0))


def test_where_a_driven_robot_is_takes_a_time():
    robot = turret(Revolute((0, 0, 1), motion=SWAY))
    for ask in (robot.pose, robot.centre_of_mass):
        with pytest.raises(TypeError, match="t: got none, expected the time"):
            ask(np.zeros(6), **({"link": "arm"} if ask == robot.pose else {}))
    many = robot.pose(np.zeros((3, 6)), link="arm", t=[0.0, 0.1, 0.2])
    for pose, t in zip(many, (0.0, 0.1, 0.2), strict=True):
        assert_allclose(pose, robot.pose(np.zeros(6), link="arm", t=t), rtol=0, atol=1e-15)


@pytest.mark.parametrize("method", METHODS)
def test_every_method_moves_it_as_a_moving_base_does(method):
    options = {"method": method}
    if method in ("newmark", "hht", "generalised_alpha"):
        options["dt"] = 1e-3
    elif method != "auto":
        options["rtol"] = options["atol"] = 1e-8
    angle = Harmonic(0.3, 2.0)
    driven = lissom.simulate(turret(Revolute((0, 0, 1), motion=angle)), 0.3, t_eval=[0.15, 0.3], **options)
    base = BaseMotion(axis=(0, 0, 1), angle=angle)
    moved = lissom.simulate(turret(lissom.Weld(), base_motion=base), 0.3, t_eval=[0.15, 0.3], **options)
    assert driven.success, driven.message
    assert moved.success, moved.message
    tolerance = 1e-3 if method == "auto" else 1e-6
    assert_allclose(driven.q, moved.q, rtol=0, atol=tolerance * np.abs(moved.q).max())
    assert_allclose(driven.balance.work, moved.balance.work, rtol=0.02, atol=1e-6)


def test_the_balance_closes_with_the_work_of_the_drives():
    """The error of the balance decreases with the square of the step; the work is most of the energy."""
    robot = Robot(
        [
            Link("rail", body=BALL, joint=Prismatic((0, 1, 0), motion=Harmonic(0.05, 2.0))),
            Link(
                "wrist",
                body=BALL,
                joint=Revolute((1, 0, 0), mimic=Mimic("elbow", multiplier=0.5)),
                parent="rail",
            ),
            Link("elbow", rod=[SOFT], joint=Revolute((0, 1, 0), stiffness=2.0, damping=0.02), parent="wrist"),
            Link(
                "tool", body=BALL, joint=Free(motion=BaseMotion(axis=(1, 2, 0), angle=SWAY)), parent="elbow"
            ),
        ]
    )
    drifts = []
    for dt in (2e-3, 1e-3):
        run = lissom.simulate(robot, 0.4, dt=dt)
        assert run.success, run.message
        assert abs(run.balance.work[-1]) > 1e-3
        drifts.append(run.balance.drift)
    assert drifts[1] < 1e-3
    assert drifts[1] < 0.35 * drifts[0]
    exact = lissom.simulate(robot, 0.4, method="dop853", rtol=1e-10, atol=1e-12, max_step=1e-3)
    assert exact.balance.drift < 1e-8


def test_statics_and_modes_turn_with_a_rotor():
    """As with a rotating base: centrifugal stiffening, and the equilibrium under centrifugal forces."""
    blade = lissom.Segment(1.0, 0.01, 7e10, 2.6e10, 2700, {"bend_y": 4})
    spin = Harmonic(rate=100.0)
    driven = Robot([Link("blade", rod=[blade], joint=Revolute((0, 0, 1), motion=spin))], gravity=(0, 0, 0))
    moved = lissom.Rod([blade], gravity=(0, 0, 0), base_motion=BaseMotion(axis=(0, 0, 1), angle=spin))
    found, wanted = (lissom.modes(model, [0] * 4, t=0.3) for model in (driven, moved))
    assert_allclose(found.frequency, wanted.frequency, rtol=1e-9)
    heavy = Robot([Link("blade", rod=[blade], joint=Revolute((0, 0, 1), motion=spin))])
    same = lissom.Rod([blade], base_motion=BaseMotion(axis=(0, 0, 1), angle=spin))
    rest, steady = (lissom.statics(model, t=0.3) for model in (heavy, same))
    assert rest.success
    assert steady.success
    assert_allclose(rest.q, steady.q, rtol=1e-9, atol=1e-15)
    linear, other = (lissom.linearise(model, rest.q, t=0.3) for model in (heavy, same))
    assert_allclose(linear.A, other.A, rtol=1e-8, atol=1e-6)


@pytest.mark.parametrize("make", ["hinge", "base", "inner"])
def test_linear_models_see_velocities_of_what_is_prescribed(make):
    """Outputs of the linear model agree with those of the robot nearby, to first order."""
    spin = Harmonic(rate=7.0)
    if make == "hinge":
        robot = turret(Revolute((0, 0, 1), motion=spin))
    elif make == "base":
        robot = turret(lissom.Weld(), base_motion=BaseMotion(axis=(0, 0, 1), angle=spin))
    else:
        robot = Robot(
            [
                Link("arm", rod=[SOFT]),
                Link("rotor", body=BALL, joint=Revolute((0, 0, 1), motion=spin), parent="arm"),
                Link("ball", body=BALL, joint=Revolute((0, 1, 0)), parent="rotor", position=(0.1, 0, 0)),
            ]
        )
    q, t, step = 0.1 * np.ones(6), 0.3, 1e-6
    outputs = ("ball_position", "ball_velocity", "ball_angular_velocity")
    linear = lissom.linearise(robot, q, outputs=outputs, t=t, held=True)
    assert linear.states == (*robot.coordinates, *(f"{name}.rate" for name in robot.coordinates))
    assert linear.inputs[0] == f"{robot.coordinates[0]}.force"

    def measured(x):
        velocity = robot.velocity(x[:6], x[6:], link="ball", t=t)
        return np.concatenate([robot.pose(x[:6], link="ball", t=t)[:3, 3], velocity[3:], velocity[:3]])

    x = np.append(q, np.zeros(6))
    differences = np.transpose(
        [(measured(x + step * e) - measured(x - step * e)) / (2 * step) for e in np.eye(12)]
    )
    assert_allclose(linear.C, differences, rtol=0, atol=1e-7 * np.abs(differences).max())


def test_motions_that_end_or_fail_say_so():
    table = ([0.0, 0.1, 0.2], [0.0, 0.1, 0.0])
    robot = turret(Revolute((0, 0, 1), motion=table))
    with pytest.raises(ValueError, match=r"0\.2"):
        lissom.simulate(robot, 0.3)
    with pytest.raises(ValueError, match=r"t: got 0\.5"):
        robot.pose(np.zeros(6), link="arm", t=0.5)

    def wild(t):
        return float("nan") if t > 0.05 else (0.1 * t, 0.1, 0.0)

    robot = turret(Revolute((0, 0, 1), motion=wild))
    with pytest.raises(ValueError, match=r"motion\(t\): got NaN at t = 0\.06, expected finite") as caught:
        lissom.simulate(robot, 0.3)
    assert caught.value.result.t[-1] <= 0.05
    with pytest.raises(ZeroDivisionError):
        turret(Revolute((0, 0, 1), motion=lambda t: 1 / 0)).pose(np.zeros(6), link="arm", t=0.0)


def test_a_robot_without_coordinates_of_its_own_has_none():
    robot = Robot([Link("crank", body=BALL, joint=Revolute((0, 1, 0), motion=SWAY))])
    assert robot.n == 0
    angle, speed, acceleration = sway(0.2)
    free = Robot([Link("crank", body=BALL, joint=Revolute((0, 1, 0)))])
    torque = free.inverse_dynamics([angle], [speed], [acceleration])[0]
    assert_close(robot.supplied_power([], [], [], t=0.2), torque * speed)
    assert_close(robot.pose([], link="crank", t=0.2), free.pose([angle], link="crank"))
    wrench = robot.joint_wrench([], [], [], link="crank", t=0.2)
    assert_close(wrench, free.joint_wrench([angle], [speed], [acceleration], link="crank"))


# Mimics


def gripper(**joint):
    """Two soft fingers, one of which may mimic the other."""
    return Robot(
        [
            Link("palm", body=BALL, joint=Prismatic((0, 0, 1), stiffness=40.0)),
            Link(
                "left",
                rod=[SOFT],
                joint=Revolute((0, 0, 1), stiffness=0.3),
                parent="palm",
                position=(0, 0.03, 0),
            ),
            Link(
                "right",
                rod=[SOFT],
                joint=Revolute((0, 0, 1), damping=0.02, armature=1e-3, **joint),
                parent="palm",
                position=(0, -0.03, 0),
            ),
        ]
    )


def test_a_gripper_moves_as_its_reduction():
    driven, free = gripper(mimic=Mimic("left", multiplier=-1.5, offset=0.2)), gripper()
    assert driven.coordinates == tuple(name for name in free.coordinates if name != "right.angle")
    assert driven.slice("right") == slice(7, 12, 1)
    G = np.delete(np.eye(free.n), 7, axis=1)
    G[7, 1] = -1.5
    o = np.zeros(free.n)
    o[7] = 0.2
    q, v, a = state(driven.n)
    M, h = free.mass_matrix(G @ q + o), free.inverse_dynamics(G @ q + o, G @ v, np.zeros(free.n))
    assert_close(driven.mass_matrix(q), G.T @ M @ G)
    assert_close(driven.forward_dynamics(q, v), -np.linalg.solve(G.T @ M @ G, G.T @ h), 1e-9)
    for reduced, whole in zip(driven.tangent(q, v, a), free.tangent(G @ q + o, G @ v, G @ a), strict=True):
        assert_close(reduced, G.T @ whole @ G)
    assert_close(driven.jacobian(q, link="right"), free.jacobian(G @ q + o, link="right") @ G)
    energy, of_free = driven.energy(q, v), free.energy(G @ q + o, G @ v)
    assert_close([energy.kinetic, energy.elastic], [of_free.kinetic, of_free.elastic])
    assert_close(driven.dissipated_power(q, v), free.dissipated_power(G @ q + o, G @ v))
    assert "follows another joint" in driven.explain()


def test_two_geared_pendulums_swing_with_their_frequency():
    """Small oscillation of ``(I1 + k^2 I2) a = -g m (l1 sin(q) + k l2 sin(k q))`` in closed form."""
    mass, first, second, k, g = 0.5, 0.4, 0.25, -2.0, 9.81
    robot = Robot(
        [
            Link("one", body=Body(mass, centre=(0, 0, -first)), joint=Revolute((0, 1, 0))),
            Link(
                "two",
                body=Body(mass, centre=(0, 0, -second)),
                joint=Revolute((0, 1, 0), mimic=Mimic("one", multiplier=k)),
            ),
        ]
    )
    assert robot.n == 1
    inertia = mass * (first**2 + k**2 * second**2)
    stiffness = mass * g * (first + k**2 * second)
    frequency = np.sqrt(stiffness / inertia) / (2 * np.pi)
    assert_allclose(lissom.modes(robot, [0.0]).frequency, [frequency], rtol=1e-12)
    for q in (0.3, -1.2, 2.5):
        torque = mass * g * (first * np.sin(q) + k * second * np.sin(k * q))
        assert_allclose(robot.forward_dynamics([q], [0.7]), [-torque / inertia], rtol=1e-12)
    run = lissom.simulate(robot, 2.0, q0=[0.5], method="dop853", rtol=1e-10, atol=1e-12)
    assert run.balance.drift < 1e-8


def test_mimics_of_mimics_and_of_motions():
    """Factors of a chain multiply, in any order of the links; a chain may end at a prescribed joint."""

    def chain(**last):
        hinge = {"axis": (0, 1, 0)}
        return Robot(
            [
                Link("a", body=BALL, joint=Revolute(**hinge, mimic=Mimic("b", multiplier=2.0, offset=0.1))),
                Link(
                    "b",
                    body=BALL,
                    joint=Revolute(**hinge, mimic=Mimic("c", multiplier=-0.5, offset=0.3)),
                    parent="a",
                ),
                Link("c", body=BALL, joint=Revolute(**hinge, **last), parent="b"),
                Link("d", body=BALL, joint=Revolute((1, 0, 0)), parent="c"),
            ]
        )

    free = Robot(
        [Link(x.name, body=x.body, joint=Revolute(x.joint.axis), parent=x.parent) for x in chain().links]
    )
    G = np.array([[-1.0, 0], [-0.5, 0], [1, 0], [0, 1]])
    o = np.array([0.7, 0.3, 0, 0])
    q, v, a = state(2)
    robot = chain()
    assert robot.coordinates == ("c.angle", "d.angle")
    assert_close(robot.inverse_dynamics(q, v, a), G.T @ free.inverse_dynamics(G @ q + o, G @ v, G @ a))
    given = chain(motion=SWAY)
    assert given.coordinates == ("d.angle",)
    x, speed, acceleration = sway(0.4)
    whole = (
        G @ [x, q[1]] + o,
        G @ [speed, v[1]],
        G @ [acceleration, a[1]],
    )
    assert_close(given.inverse_dynamics(q[1:], v[1:], a[1:], t=0.4), free.inverse_dynamics(*whole)[3:])


def test_what_mimics_needs_no_mass_of_its_own():
    """But the joint that it mimics has inertia behind it, or behind what follows it."""
    light = Robot(
        [
            Link("knob", joint=Revolute((0, 1, 0))),
            Link("wheel", body=BALL, joint=Revolute((0, 1, 0), mimic=Mimic("knob"))),
        ]
    )
    heavy = Robot([Link("wheel", body=BALL, joint=Revolute((0, 1, 0)))])
    assert_close(light.forward_dynamics([0.3], [0.1]), heavy.forward_dynamics([0.3], [0.1]))
    Robot(
        [
            Link("wheel", body=BALL, joint=Revolute((0, 1, 0))),
            Link("pointer", joint=Revolute((1, 0, 0), motion=SWAY)),
        ]
    )
    with pytest.raises(
        ValueError, match=r"links\[0\]\.joint: got no inertia against a motion of knob\.angle"
    ):
        Robot(
            [
                Link("knob", joint=Revolute((0, 1, 0))),
                Link("hand", joint=Revolute((0, 1, 0), mimic=Mimic("knob"))),
            ]
        )


def test_supports_hold_what_follows():
    """Springs of supports, also in statics, are reduced correctly."""

    def robot(**joint):
        fingers = gripper(**joint)
        supports = [
            lissom.Support(link="right", stiffness=30.0, rotational_stiffness=0.2, position=(0.25, -0.1, 0))
        ]
        return Robot(fingers.links, supports=supports)

    driven, free = robot(mimic=Mimic("left", multiplier=-1.0)), robot()
    rest = lissom.statics(driven, space_error=False)
    assert rest.success, rest.message
    G = np.delete(np.eye(free.n), 7, axis=1)
    G[7, 1] = -1.0
    zero = np.zeros(free.n)
    forces = free.inverse_dynamics(G @ rest.q, zero, zero)
    assert_allclose(G.T @ forces, 0, atol=1e-7)
    assert np.abs(forces).max() > 1e-3
    assert lissom.modes(driven, rest.q).stability == "stable"


# Random robots


@st.composite
def driven_robots(draw):
    """A description, and the same with some driven joints, with G, o and its derivatives at a time."""
    description = draw(robots())
    plain = copy.deepcopy(description)
    single = [
        i for i, link in enumerate(plain["links"]) if link["joint"]["type"] in ("revolute", "prismatic")
    ]
    driven = copy.deepcopy(description)
    free = draw(st.sets(st.sampled_from(single))) if single else set()
    followers = {}
    for i in single:
        if i in free:
            continue
        others = sorted(free - {i})
        if others and draw(st.booleans()):
            of = draw(st.sampled_from(others))
            multiplier, offset = draw(st.sampled_from([-2.0, 0.5, 1.0])), draw(st.sampled_from([0.0, 0.3]))
            mimic = Mimic(plain["links"][of]["name"], multiplier=multiplier, offset=offset)
            driven["links"][i]["joint"]["mimic"] = mimic
            followers[i] = (of, multiplier, offset)
        else:
            driven["links"][i]["joint"]["motion"] = SWAY
            followers[i] = None
    for i, link in enumerate(plain["links"]):
        if link["joint"]["type"] == "free" and draw(st.booleans()):
            motion = BaseMotion(
                translation=Harmonic((0.1, 0.2, -0.1), 1.0), axis=(1, 2, 3), angle=Harmonic(0.5, 1.0)
            )
            driven["links"][i]["joint"]["motion"] = motion
            followers[i] = "free"
    return plain, driven, followers


@settings(max_examples=25)
@given(driven_robots(), seeds)
def test_random_robots_are_reductions_of_the_reference(drawn, seed):
    plain, description, followers = drawn
    reference, free = build(plain), build(plain, lissom)
    robot = build(description, lissom)
    names = list(free.coordinates)
    assert set(robot.coordinates) <= set(names)
    own = [names.index(name) for name in robot.coordinates]
    G = np.zeros((free.n, robot.n))
    G[own, range(robot.n)] = 1
    o = np.zeros((3, free.n))
    t = 0.3
    for i, follower in followers.items():
        first = free.slice(plain["links"][i]["name"]).start
        if follower is None:
            o[:, first] = sway(t)
        elif follower == "free":
            w = 2 * np.pi
            s, c = np.sin(w * t), np.cos(w * t)
            size = np.array([0.1, 0.2, -0.1, *(0.5 * np.array([1, 2, 3]) / np.sqrt(14))])
            o[:, first : first + 6] = size * s, size * w * c, -size * w * w * s
        else:
            of, multiplier, offset = follower
            G[first] += multiplier * G[free.slice(plain["links"][of]["name"]).start]
            o[0, first] = offset
    q, v, a = random_states(reference, seed)[:, own]
    whole = [G @ x + part for x, part in zip((q, v, a), o, strict=True)]
    tau = robot.inverse_dynamics(q, v, a, t=t)
    forces = free.inverse_dynamics(*whole)
    size = np.abs(forces).max(initial=1e-6)
    assert_allclose(tau, G.T @ forces, rtol=0, atol=1e-10 * size)
    if not any("rod" in link for link in plain["links"]):
        # The reference's rods have other nodes.
        assert_allclose(tau, G.T @ reference.inverse_dynamics(*whole), rtol=0, atol=1e-9 * size)
    for reduced, matrix in zip(robot.tangent(q, v, a, t=t), free.tangent(*whole), strict=True):
        assert_allclose(reduced, G.T @ matrix @ G, rtol=0, atol=1e-10 * np.abs(matrix).max(initial=1e-6))
    for link in robot.links:
        assert_close(robot.jacobian(q, link=link.name, t=t), free.jacobian(whole[0], link=link.name) @ G)
        assert_close(robot.velocity(q, v, link=link.name, t=t), free.velocity(*whole[:2], link=link.name))
    power = free.supplied_power(*whole) + forces @ o[1]
    assert_allclose(
        robot.supplied_power(q, v, a, t=t),
        power,
        rtol=0,
        atol=1e-9 * size * (1 + np.abs(whole[1]).max(initial=0)),
    )
    again = pickle.loads(pickle.dumps(robot))
    assert_allclose(again.inverse_dynamics(q, v, a, t=t), tau, rtol=0, atol=0)


# Descriptions


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: Revolute((0, 1, 0), motion=SWAY, mimic=Mimic("a")),
            "mimic: got both motion and mimic, expected one",
        ),
        (lambda: Revolute((0, 1, 0), motion=float("nan")), r"motion: got NaN, expected"),
        (lambda: Revolute((0, 1, 0), motion=Harmonic(1.0, -2.0)), r"frequency: got -2"),
        (lambda: Revolute((0, 1, 0), motion=([0, 0], [1, 2])), r"motion.times\[1\]: got 0"),
        (lambda: Revolute((0, 1, 0), mimic=Mimic("a", multiplier=float("inf"))), "multiplier: got inf"),
        (lambda: Prismatic((0, 1, 0), mimic=Mimic("a", offset=float("nan"))), "offset: got NaN"),
    ],
)
def test_what_makes_no_sense_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Revolute((0, 1, 0), motion=BaseMotion()), "motion: expected"),
        (lambda: Revolute((0, 1, 0), motion="fast"), "motion: expected"),
        (lambda: Free(motion=SWAY), "motion: expected lissom.BaseMotion or None"),
        (lambda: Revolute((0, 1, 0), mimic="a"), "mimic: expected lissom.Mimic or None"),
        (lambda: Revolute((0, 1, 0), mimic=Mimic(3)), "link: expected a str, got int"),
        (lambda: Revolute((0, 1, 0), mimic=Mimic("a", multiplier="2")), "multiplier: expected a real number"),
        (lambda: lissom.Weld(motion=SWAY), "motion"),
        (lambda: lissom.Spherical(mimic=Mimic("a")), "mimic"),
    ],
)
def test_what_is_of_another_type_is_refused(make, message):
    with pytest.raises(TypeError, match=message):
        make()


@pytest.mark.parametrize(
    ("mimics", "message"),
    [
        (
            {"a": "a"},
            r"links\[0\]\.joint\.mimic\.link: got the joint itself, expected joints that do not mimic",
        ),
        ({"a": "b", "b": "a"}, r'links\[0\]\.joint\.mimic\.link: got "b", which mimics this joint'),
        (
            {"a": "b", "b": "c", "c": "b"},
            r"links\[1\]\.joint\.mimic\.link: got \"c\", which mimics this joint",
        ),
        (
            {"a": "x"},
            r"links\[0\]\.joint\.mimic\.link: got 'x', expected one of the links: 'a', 'b', 'c', 'ball'",
        ),
        ({"a": "ball"}, r'links\[0\]\.joint\.mimic\.link: got "ball", whose joint is a spherical joint'),
    ],
)
def test_mimics_of_nothing_and_in_circles_are_refused(mimics, message):
    links = [
        Link(
            name, body=BALL, joint=Revolute((0, 1, 0), mimic=Mimic(mimics[name]) if name in mimics else None)
        )
        for name in "abc"
    ]
    with pytest.raises(ValueError, match=message):
        Robot([*links, Link("ball", body=BALL, joint=lissom.Spherical())])


def test_driven_joints_are_plain_data():
    table = (np.array([0, 1.0, 2]), [0.0, 0.1, 0.4])
    for joint in (
        Revolute((0, 1, 0), motion=SWAY),
        Revolute((0, 1, 0), motion=table),
        Prismatic((0, 1, 0), motion=0.3),
        Prismatic((0, 1, 0), mimic=Mimic("other", multiplier=-2, offset=1)),
        Free(motion=BaseMotion(axis=(0, 1, 0), angle=SWAY)),
    ):
        assert joint == pickle.loads(pickle.dumps(joint)) == copy.deepcopy(joint)
        assert hash(joint) == hash(copy.deepcopy(joint))
        other = Link("other", body=BALL, joint=Revolute((1, 0, 0)))
        robot = Robot([Link("link", body=BALL, joint=joint), other])
        back = robot.links[0].joint
        assert type(back) is type(joint)
        if "motion" in repr(joint) and not isinstance(joint.motion, tuple):
            assert back == joint
        assert pickle.loads(pickle.dumps(robot)).links[1] == robot.links[1]
    assert Revolute((0, 1, 0)) != Revolute((0, 1, 0), motion=0.0)
    assert {Link("a", body=BALL), Link("a", body=BALL)} == {Link("a", body=BALL)}


SCENE = """
version = 1
[[link]]
name = "crank"
joint = { type = "revolute", axis = [0, 1, 0], motion = { amplitude = 0.3, frequency = 2, mean = 0.1 } }
body = { mass = 0.1, centre = [0.1, 0, 0] }
[[link]]
name = "left"
parent = "crank"
joint = { type = "revolute", axis = [0, 1, 0], stiffness = 1 }
body = { mass = 0.1, centre = [0.1, 0, 0] }
q0 = [0.2]
[[link]]
name = "right"
parent = "crank"
joint = { type = "revolute", axis = [0, 1, 0], mimic = { link = "left", multiplier = -1, offset = 0.1 } }
body = { mass = 0.1, centre = [0.1, 0, 0] }
[[link]]
name = "tool"
body = { mass = 0.1 }
[link.joint]
type = "free"
[link.joint.motion]
translation = { rate = [0, 1, 0] }
axis = [0, 0, 1]
angle = { times = [0, 1], values = [0, 1] }
[simulation]
t_end = 0.1
"""


def test_scenes_drive_joints():
    scene = lissom.Scene.loads(SCENE)
    assert isinstance(scene.model, Robot)
    crank, _, right, tool = (link.joint for link in scene.model.links)
    assert crank.motion == Harmonic(0.3, 2.0, mean=0.1)
    assert right.mimic == Mimic("left", multiplier=-1.0, offset=0.1)
    assert tool.motion.axis == (0, 0, 1)
    assert scene.model.coordinates == ("left.angle",)
    assert scene.run().success


@pytest.mark.parametrize(
    ("old", "new", "key", "says"),
    [
        ('link = "left"', 'link = "lefd"', "link[2].joint.mimic.link", 'did you mean "left"?'),
        ('link = "left"', 'link = "right"', "link[2].joint.mimic.link", "the joint itself"),
        ('link = "left"', 'link = "tool"', "link[2].joint.mimic.link", "free joint"),
        ("stiffness = 1 }", 'mimic = { link = "right" } }', "link[1].joint.mimic.link", "mimics this joint"),
        (
            "offset = 0.1 }",
            "offset = 0.1 }, motion = { rate = 1 }",
            "link[2].joint.mimic",
            "both motion and mimic",
        ),
        (
            "mean = 0.1",
            "mean = 0.1, times = [0, 1], values = [0, 1]",
            "link[0].joint.motion",
            "both a table and a formula",
        ),
        ("mean = 0.1", "angle = { rate = 1 }", "link[0].joint.motion.angle", "it belongs in [base_motion]"),
        ("frequency = 2", "frequency = -2", "link[0].joint.motion.frequency", "-2"),
        ("axis = [0, 0, 1]", "", "link[3].joint.motion.angle", "angle without axis"),
        (
            "translation = {",
            "rate = 1\ntranslation = {",
            "link[3].joint.motion.rate",
            "unknown key",
        ),
        ("times = [0, 1]", "times = [0, 0.05]", "link[3].joint.motion", "known from 0 to 0.05"),
        ('type = "free"', 'type = "spherical"', "link[3].joint.motion", "does not take it"),
    ],
)
def test_scenes_name_what_is_wrong_with_a_drive(old, new, key, says):
    assert old in SCENE
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(SCENE.replace(old, new))
    found = {problem.key: f"{problem.wrong}; {problem.right}" for problem in caught.value.problems}
    assert key in found
    assert says in found[key]


def test_the_mass_matrix_of_what_moves_by_itself_takes_a_time():
    """A point mass that slides along a rotating bar: m r(t)^2 plus the inertia of the bar."""
    bar = Body(1.0, centre=(0.3, 0, 0), inertia=(0.01, 0.01, 0.01))
    slide = Prismatic((1, 0, 0), motion=Harmonic(0.2, 1.0, mean=1.0))
    robot = Robot(
        [
            Link("bar", joint=Revolute((0, 0, 1)), body=bar),
            Link("bead", parent="bar", joint=slide, body=Body(1.0)),
        ]
    )
    distance = 1 + 0.2 * np.sin(2 * np.pi * 0.1)
    assert_allclose(robot.mass_matrix([0.4], t=0.1), [[0.1 + distance**2]], rtol=1e-14)
    with pytest.raises(TypeError, match="t: got none"):
        robot.mass_matrix([0.4])


@pytest.mark.parametrize("method", ["newmark", "radau", "rk45", "dop853", "auto"])
def test_a_robot_that_is_driven_throughout_moves_and_takes_work(method):
    body = Body(1.0, centre=(0.3, 0, 0), inertia=(0.01, 0.01, 0.01))
    robot = Robot([Link("crank", joint=Revolute((0, 1, 0), motion=Harmonic(1.0, 1.0)), body=body)])
    motion = lissom.simulate(robot, 1.0, method=method, t_eval=[0.0, 0.3, 0.55, 1.0])
    assert motion.success
    assert_allclose(motion.t, [0.0, 0.3, 0.55, 1.0])
    assert motion.balance.drift < 2e-3


def test_links_cost_only_their_own_coordinates():
    links = [Link("a", joint=Revolute((0, 1, 0)), body=Body(1.0, centre=(0.1, 0, 0)))]
    links.append(
        Link("b", parent="a", joint=Revolute((0, 1, 0), mimic=Mimic("a")), body=Body(1.0, centre=(0.1, 0, 0)))
    )
    costs = Robot(links).explain().split("cost of links")[1]
    assert "1 coordinate" in costs.splitlines()[1]
    assert "0 coordinates" in costs.splitlines()[2]


@pytest.mark.parametrize("method", ["radau", "rk45", "dop853"])
@pytest.mark.parametrize("start", [0.0, 0.1, 0.25])
def test_adaptive_steps_pass_a_jump_of_the_acceleration_of_a_function(start, method):
    """The smooth step of robotics, and what hangs on it: a particular solution and a vibration."""
    w, rise, stroke = 4.0, 0.5, 0.1

    def motion(t):
        s = min(max((t - start) / rise, 0.0), 1.0)
        return stroke * s * s * (3 - 2 * s)

    carriage = Link("carriage", body=Body(1.0), joint=Prismatic((1, 0, 0), motion=motion))
    load = Link("load", parent="carriage", body=Body(1.0), joint=Prismatic((1, 0, 0), stiffness=w * w))
    run = lissom.simulate(Robot([carriage, load], gravity=(0, 0, 0)), 1.0, method=method, rtol=1e-8)
    assert run.success, run.message
    # x'' + w^2 x = -f'' with f'' = a + b t in the rise, from rest; x is linear in t and a vibration.
    a, b = 6 * stroke / rise**2, -12 * stroke / rise**3
    x = a / w**2 * np.cos(w * rise) + b / w**3 * np.sin(w * rise) - (a + b * rise) / w**2
    v = -a / w * np.sin(w * rise) + b / w**2 * np.cos(w * rise) - b / w**2
    rest = 1.0 - start - rise
    assert_allclose(run.q[-1, 0], x * np.cos(w * rest) + v / w * np.sin(w * rest), rtol=0, atol=1e-6)
