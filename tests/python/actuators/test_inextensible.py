"""Tendons that do not stretch: one-sided constraints, against closed forms and SciPy's pendulums."""

import pickle

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lissom

G = 9.81
ROPE = 0.5
MASS = 0.2


def finger(tendons, **changes):
    segment = lissom.Segment(
        0.3,
        0.01,
        1e6,
        4e5,
        1000.0,
        modes={"bend_y": 3, "bend_z": 2, "stretch": 1},
        retardation_time=0.01,
    )
    return lissom.Rod([segment], gravity=(0, 0, -G), actuators=tendons, **changes)


def along(name="pull", offset=(0.0, 0.008), **drive):
    return lissom.Tendon(name, [lissom.Along(offset=offset)], **drive)


def bob(length=ROPE, **changes):
    """A small ball on a rope from the origin."""
    body = lissom.Body(MASS, inertia=np.diag([1e-5] * 3))
    rope = lissom.Tendon(
        "rope", [lissom.Via(None, (0, 0, 0)), lissom.Via("bob", (0, 0, 0))], length=length, **changes
    )
    return lissom.Robot(
        [lissom.Link("bob", joint=lissom.Free(), body=body)], gravity=(0, 0, -G), actuators=[rope]
    )


def place(x, z, vx=0.0, vz=0.0):
    q, v = np.zeros(6), np.zeros(6)
    q[[0, 2]], v[[0, 2]] = (x, z), (vx, vz)
    return q, v


def pendulum(angle, rate, t_span):
    return solve_ivp(
        lambda _, y: [y[1], -G / ROPE * np.sin(y[0])], t_span, [angle, rate], rtol=1e-12, atol=1e-12
    ).y[:, -1]


# Equilibria


@pytest.mark.parametrize("tension", [0.02, 0.5, 3.0])
@pytest.mark.parametrize("start", ["zero", "shape", "newton"])
def test_lengths_given_tensions_found(tension, start):
    pulled = finger([along(tension=tension)])
    wanted = lissom.statics(pulled)
    length = pulled.actuator_length("pull", wanted.q)
    held = finger([along(length=length)])
    assert held.constraints == 1
    if start == "zero":
        found = lissom.statics(held)
    else:
        method = {} if start == "shape" else {"method": "newton"}
        found = lissom.statics(held, 0.9 * wanted.q, **method)
    assert found.success, found.message
    rest = np.zeros(held.n)
    np.testing.assert_allclose(found.q, wanted.q, atol=1e-9)
    assert held.actuator_force("pull", found.q, rest, qdd=rest) == pytest.approx(tension, rel=1e-8)
    assert held.actuator_force("pull", found.q, rest) == pytest.approx(tension, rel=1e-8)
    assert abs(held.actuator_length("pull", found.q) - length) < 1e-12


def test_a_slack_tendon_changes_nothing():
    free = lissom.statics(finger([]))
    held = finger([along(length=0.32)])
    found = lissom.statics(held)
    np.testing.assert_allclose(found.q, free.q, atol=1e-10)
    assert found.slack == ["pull"]
    assert "Slack: 'pull'" in found.message
    assert held.actuator_force("pull", found.q, 0 * found.q) == 0.0


def test_of_two_that_oppose_each_other_the_right_one_is_taut():
    tip = 0.05
    for sign in (1.0, -1.0):
        load = lissom.Load(force=(0, 0, sign * tip))
        pair = [along("up", (0.0, 0.008), length=0.3), along("down", (0.0, -0.008), length=0.3)]
        robot = finger(pair, loads=[load])
        found = lissom.statics(robot)
        rest = np.zeros(robot.n)
        tensions = {name: robot.actuator_force(name, found.q, rest, qdd=rest) for name in ("up", "down")}
        excess = {name: robot.actuator_length(name, found.q) - 0.3 for name in tensions}
        assert all(tension >= 0.0 for tension in tensions.values())
        assert all(gap <= 1e-9 for gap in excess.values())
        assert all(tension == 0.0 or abs(excess[name]) < 1e-9 for name, tension in tensions.items())
        assert max(tensions.values()) > 0.1


def test_a_stiff_tendon_comes_to_the_one_that_does_not_stretch():
    inextensible = lissom.statics(finger([along(length=0.295)])).q
    errors = []
    for stiffness in (1e4, 1e5, 1e6):
        stiff = lissom.statics(finger([along(length=0.295, stiffness=stiffness)])).q
        errors.append(np.linalg.norm(stiff - inextensible))
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(10.0, rel=0.1)


# Paths of equilibria


def lengths(robot, path, name="pull"):
    return np.array([robot.actuator_length(name, q) for q in path.q])


def tensions(robot, path, name="pull"):
    rest = np.zeros(robot.n)
    inputs = [None] * len(path.q) if path.u is None else path.u
    return np.array(
        [robot.actuator_force(name, q, rest, qdd=rest, u=u) for q, u in zip(path.q, inputs, strict=True)]
    )


def test_a_tendon_becomes_taut_as_loads_grow():
    """Up to there the path is that without the tendon; behind, the tendon keeps its length."""
    load = lissom.Load(force=(0, 0, -0.3))
    held = finger([along(length=0.301)], loads=[load])
    found = lissom.continuation(held)
    assert found.success, found.message
    path = found.path
    free = finger([along(tension=0.0)], loads=[load])
    corner = np.argmax(tensions(held, path) > 0.0)
    assert 3 < corner < len(path.q) - 3
    for q, factor in zip(path.q[1:corner:3], path.load_factor[1:corner:3], strict=True):
        alone = lissom.continuation(free, bounds=(0.0, factor)).path
        np.testing.assert_allclose(q, alone.q[-1], atol=1e-8)
    assert free.actuator_length("pull", path.q[corner - 1]) == pytest.approx(0.301, abs=1e-6)
    np.testing.assert_allclose(lengths(held, path)[corner:], 0.301, atol=1e-11)
    assert (np.diff(tensions(held, path)[corner:]) > 0.0).all()
    np.testing.assert_allclose(path.q[-1], lissom.statics(held, path.q[-1]).q, atol=1e-9)


@pytest.mark.parametrize("way", [(0.305, 0.28), (0.28, 0.305), (0.29, 0.33), (0.33, 0.29)])
def test_a_path_of_lengths(way):
    """The length is as commanded, by the tension that `statics` finds, or more than it needs: slack."""
    robot = finger([along(length=lissom.Input("length", way[0]))])
    found = lissom.continuation(robot, inputs={"length": way})
    assert found.success, found.message
    commanded = found.path.u[:, 0]
    np.testing.assert_allclose(commanded, way[0] + found.path.load_factor * (way[1] - way[0]), atol=1e-14)
    pulls, excess = tensions(robot, found.path), lengths(robot, found.path) - commanded
    assert (pulls >= 0.0).all()
    # What is let go is taken up again where it is longer by 1e-10.
    assert (excess < 2e-10).all()
    assert ((pulls == 0.0) | (np.abs(excess) < 1e-11)).all()
    assert (pulls.min() == 0.0) == (max(way) > 0.32)
    for k in (0, len(commanded) // 2, -1):
        alone = lissom.statics(robot, u=found.path.u[k])
        np.testing.assert_allclose(found.path.q[k], alone.q, atol=1e-8)


def test_antagonists_take_turns():
    pair = [
        along("up", (0.0, 0.008), length=lissom.Input("up", 0.3)),
        along("down", (0.0, -0.008), length=lissom.Input("down", 0.3)),
    ]
    robot = finger(pair)
    found = lissom.continuation(robot, inputs={"up": (0.29, 0.32), "down": (0.32, 0.29)})
    assert found.success, found.message
    up, down = (tensions(robot, found.path, name) for name in ("up", "down"))
    assert up[0] > 0.0 == down[0]
    assert down[-1] > 0.0 == up[-1]
    np.testing.assert_allclose(found.path.q[-1], lissom.statics(robot, u=[0.32, 0.29]).q, atol=1e-8)


def test_a_column_that_is_pulled_to_its_foot_buckles():
    """The line of the force goes through the foot: the load is that of a column between pins (Euler)."""
    length, radius, modulus = 0.4, 2e-3, 1e9
    column = lissom.Segment(length, radius, modulus, modulus / 2.6, 1000.0, modes={"bend_y": 6, "stretch": 1})
    line = lissom.Tendon(
        "line",
        [lissom.Via("rod", (0, 0, 0), at=0.0), lissom.Via("rod", (0, 0, 0), at=length)],
        length=lissom.Input("length", length),
    )
    rod = lissom.Rod([column], gravity=(0, 0, 0), actuators=[line])
    found = lissom.continuation(rod, inputs={"length": (length, length * (1.0 - 1e-4))})
    assert found.success, found.message
    point = next(point for point in found.path.critical_points if point.kind == "bifurcation")
    rest = np.zeros(rod.n)
    tension = rod.actuator_force("line", point.q, rest, qdd=rest, u=point.u)
    bending = modulus * np.pi / 4 * radius**4
    assert tension == pytest.approx(np.pi**2 * bending / length**2, rel=1e-3)
    buckled = lissom.continuation(
        rod,
        point.q,
        inputs={"length": (length, 0.9 * length)},
        load_factor=(length - point.u[0]) / (0.1 * length),
        direction=point.directions[0],
    )
    assert buckled.success, buckled.message
    assert buckled.path.stability[-1] == "stable"
    pulls = tensions(rod, buckled.path, "line")
    assert 1.0 < pulls[-1] / tension < 1.1


def test_equal_tendons_share_and_are_redundant():
    length = 0.295
    one, two = finger([along(length=length)]), finger([along("a", length=length), along("b", length=length)])
    alone, together = lissom.statics(one), lissom.statics(two)
    assert together.success
    np.testing.assert_allclose(together.q, alone.q, atol=1e-9)
    rest = np.zeros(one.n)
    sum_of_both = sum(two.actuator_force(name, together.q, rest, qdd=rest) for name in "ab")
    assert sum_of_both == pytest.approx(one.actuator_force("pull", alone.q, rest, qdd=rest), rel=1e-7)
    assert sum(two.redundant_constraints(together.q).values()) == 1


# Motion


def test_a_ball_on_a_rope_is_a_pendulum():
    robot = bob()
    q0, v0 = place(ROPE * np.sin(1.0), -ROPE * np.cos(1.0))
    angle, rate = pendulum(1.0, 0.0, (0.0, 2.0))
    errors = []
    for dt in (0.01, 0.005, 0.0025):
        run = lissom.simulate(robot, 2.0, q0=q0, v0=v0, dt=dt)
        assert run.success, run.message
        x, z = run.q[-1][[0, 2]]
        errors.append(np.hypot(x - ROPE * np.sin(angle), z + ROPE * np.cos(angle)))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.05)
    tension = robot.actuator_force("rope", run.q[-1], run.v[-1], qdd=run.a[-1])
    assert tension == pytest.approx(MASS * (G * np.cos(angle) + ROPE * rate**2), rel=1e-3)
    assert np.abs(np.hypot(run.q[:, 0], run.q[:, 2]) - ROPE).max() < 1e-9
    assert run.slack == []


def test_a_ball_that_falls_into_its_rope_keeps_the_speed_across_it():
    robot = bob()
    q0, v0 = place(0.3, 0.0)
    taut_at = np.sqrt(2 * 0.4 / G)
    angle = np.arctan2(0.3, 0.4)
    rate = -G * taut_at * np.sin(angle) / ROPE
    angle, rate = pendulum(angle, rate, (taut_at, 0.6))
    errors = []
    for dt in (2e-3, 1e-3, 5e-4):
        run = lissom.simulate(robot, 0.6, q0=q0, v0=v0, dt=dt)
        assert run.success, run.message
        x, z = run.q[-1][[0, 2]]
        errors.append(np.hypot(x - ROPE * np.sin(angle), z + ROPE * np.cos(angle)))
        assert np.hypot(run.q[:, 0], run.q[:, 2]).max() < ROPE + 1e-8
    assert errors[-1] < 2e-3
    assert errors[0] / errors[-1] > 3.0
    fallen = run.t < taut_at
    np.testing.assert_allclose(run.q[fallen, 2], -G / 2 * run.t[fallen] ** 2, atol=1e-9)
    assert run.slack == ["rope"]


def test_a_rope_never_pushes():
    """Thrown upwards the ball flies freely."""
    robot = bob()
    q0, v0 = place(0.0, -ROPE, 0.0, 3.0)
    run = lissom.simulate(robot, 0.3, q0=q0, v0=v0, dt=1e-3)
    np.testing.assert_allclose(run.q[:, 2], -ROPE + 3.0 * run.t - G / 2 * run.t**2, atol=1e-9)


def test_a_hoist_follows_its_rope():
    amplitude, frequency = 0.02, 1.5
    omega = 2 * np.pi * frequency
    robot = bob(lissom.Harmonic(amplitude, frequency, mean=ROPE))
    q0, v0 = place(0.0, -ROPE, 0.0, -amplitude * omega)
    for dt in (4e-3, 2e-3, 1e-3):
        run = lissom.simulate(robot, 1.0, q0=q0, v0=v0, dt=dt)
        assert run.success, run.message
        length = ROPE + amplitude * np.sin(omega * run.t)
        np.testing.assert_allclose(run.q[:, 2], -length, atol=1e-9)
        np.testing.assert_allclose(run.v[:, 2], -amplitude * omega * np.cos(omega * run.t), atol=1e-12)
    tension = robot.actuator_force("rope", run.q[-1], run.v[-1], t=run.t[-1], qdd=run.a[-1])
    acceleration = amplitude * omega**2 * np.sin(omega * run.t[-1])
    assert tension == pytest.approx(MASS * (G + acceleration), rel=1e-3)


@pytest.mark.parametrize("length", [lambda t: 0.5 - 0.1 * t**2, ([0.0, 1.0], [0.5, 0.45])])
def test_functions_and_tables_pull(length):
    robot = bob(length)
    q0, v0 = place(0.0, -ROPE)
    run = lissom.simulate(robot, 0.5, q0=q0, v0=v0, dt=1e-3)
    wanted = 0.5 - 0.1 * 0.5**2 if callable(length) else 0.475
    assert run.success, run.message
    assert run.q[-1][2] == pytest.approx(-wanted, abs=1e-9)


def test_steps_from_outside_and_pickles():
    robot = bob(lissom.Input("length", ROPE))
    q0, v0 = place(0.1, -np.sqrt(ROPE**2 - 0.01))
    stepped = lissom.Simulation(robot, dt=1e-3, q0=q0, v0=v0)
    lengths = ROPE - 1e-4 * np.arange(1, 101)
    for length in lengths[:50]:
        stepped.step([length])
    again = pickle.loads(pickle.dumps(stepped))
    for length in lengths[50:]:
        stepped.step([length])
        again.step([length])
    assert np.hypot(*stepped.q[[0, 2]]) == pytest.approx(lengths[-1], abs=1e-9)
    np.testing.assert_array_equal(stepped.q, again.q)
    np.testing.assert_array_equal(stepped.v, again.v)


def test_a_finger_that_is_pulled_and_let_go():
    """Against a tendon of 2000 times the stiffness of the rod against stretch, in steps that resolve it."""
    times = ([0.0, 0.2, 0.4], [0.2999, 0.296, 0.31])
    robot = finger([along(length=times)])
    stiff_robot = finger([along(length=times, stiffness=2e6)])
    start = lissom.statics(robot, t=0.0).q
    run = lissom.simulate(robot, 0.4, q0=start, dt=5e-4)
    stiff = lissom.simulate(stiff_robot, 0.4, q0=start, dt=1.25e-4, method="generalised_alpha")
    assert run.success
    assert stiff.success
    assert run.slack == ["pull"]
    tips, stiff_tips = (robot.pose(q, 0.3)[:, :3, 3] for q in (run.q[::20], stiff.q[::80]))
    assert np.abs(tips - stiff_tips).max() < 4e-5
    excess = robot.actuator_length("pull", run.q) - np.interp(run.t, *times)
    assert excess.max() < 1e-9


# Small motions


def test_the_frequencies_of_a_pendulum():
    robot = bob()
    q0, _ = place(0.0, -ROPE)
    modes = lissom.modes(robot, q0)
    frequencies = np.sort(np.asarray(modes.frequency))
    assert len(frequencies) == 5
    np.testing.assert_allclose(frequencies[-2:] * 2 * np.pi, np.sqrt(G / ROPE), rtol=1e-8)


def test_a_linear_model_holds_it_and_takes_what_else_acts():
    """The steady gain is that of equilibria."""
    held = along(length=0.29)
    pulls = [along(f"pull{k}", (0.005, 0.004 * k), tension=lissom.Input(f"T{k}", 1.0)) for k in (-1, 1)]
    robot = finger([held, *pulls])
    q = lissom.statics(robot).q
    assert robot.actuator_force("pull", q, 0 * q) > 1.0
    A, B, C, _ = lissom.linearise(robot, q, "inputs", "tip_position")

    def tip(u):
        return robot.pose(lissom.statics(robot, u=u).q)[:3, 3]

    gains = [(tip(robot.u0 + step) - tip(robot.u0 - step)) / 2e-3 for step in 1e-3 * np.eye(2)]
    assert np.allclose(-C @ np.linalg.solve(A, B), np.transpose(gains), rtol=1e-6, atol=1e-9)


def test_a_linear_model_has_no_input_that_is_its_length():
    other = along("other", (0.005, 0.0), tension=lissom.Input("force", 1.0))
    robot = finger([along(length=lissom.Input("winch", 0.29)), other])
    q = lissom.statics(robot).q
    for inputs in ("inputs", "winch", ["force", "winch"]):
        with pytest.raises(ValueError, match="inputs: got 'winch', the length of the tendon 'pull' that"):
            lissom.linearise(robot, q, inputs)
    assert np.abs(lissom.linearise(robot, q, "force").B).max() > 0.0
    assert lissom.linearise(robot, q).B.any()


def test_the_modes_of_a_slack_robot_are_those_without_a_tendon():
    held, free = finger([along(length=0.35)]), finger([])
    q = lissom.statics(free).q
    np.testing.assert_allclose(lissom.modes(held, q).frequency, lissom.modes(free, q).frequency, rtol=1e-9)


# What is refused


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"damping": 1.0}, "does not stretch"),
        ({"friction": 0.2}, "friction along a tendon that does not stretch is not supported"),
        ({"stiffness": 0.0}, "stiffness"),
    ],
)
def test_what_belongs_to_a_spring_is_refused(changes, words):
    with pytest.raises(ValueError, match=words):
        along(length=0.3, **changes)


def test_lengths_that_cannot_be_are_refused():
    robot = bob(0.2)
    anchored = lissom.Tendon(
        "short", [lissom.Via(None, (0, 0, 2.0)), lissom.Via("bob", (0, 0, 0))], length=0.2
    )
    conflict = lissom.Robot(robot.links, gravity=(0, 0, -G), actuators=[*robot.actuators, anchored])
    with pytest.raises(ValueError, match=r"too long: actuators\[\d\]"):
        lissom.simulate(conflict, 0.1, dt=1e-3, q0=np.full(6, 0.1))


def test_it_is_explained():
    robot = finger([along(length=0.3)])
    assert "never longer than the commanded length" in robot.explain()
    assert "1 constraint held by multipliers" in robot.explain()
    assert robot.actuators[0].stiffness is None


def rising(t):
    return 0.296 - 0.004 * np.sin(2 * np.pi * t) ** 2


def test_the_work_of_a_winch_is_in_the_balance():
    robot = finger([along(length=rising)])
    run = lissom.simulate(robot, 1.0, dt=1e-3, q0=lissom.statics(robot).q)
    powers = [
        robot.supplied_power(q, v, qdd=a, t=t) for t, q, v, a in zip(run.t, run.q, run.v, run.a, strict=True)
    ]
    assert abs(run.balance.work[-1] - np.trapezoid(powers, run.t)) < 1e-3 * run.balance.scale
    assert run.balance.drift < 1e-3


def test_lengths_that_reach_a_target():
    """The lengths that tensions make reach what these reach."""
    places = {"a": (0.0, 0.008), "b": (0.007, -0.004), "c": (-0.007, -0.004)}
    pulled = finger([along(name, offset, tension=lissom.Input(name, 1.0)) for name, offset in places.items()])
    tensions = [1.5, 0.7, 0.4]
    shape = lissom.statics(pulled, u=tensions).q
    lengths = {name: pulled.actuator_length(name, shape) for name in places}
    start = lissom.statics(pulled, u=[1.0, 0.8, 0.6]).q
    held = finger(
        [
            along(name, offset, length=lissom.Input(name, pulled.actuator_length(name, start)))
            for name, offset in places.items()
        ]
    )
    found = lissom.actuate(held, pulled.pose(shape)[:3, 3])
    assert found.status == "reached", found.message
    assert found.position_error < 1e-9
    # Three lengths and three coordinates of the tip: there is one answer.
    np.testing.assert_allclose(found.u, [lengths[name] for name in places], atol=1e-7)
    rest = np.zeros(held.n)
    reached = [held.actuator_force(name, found.q, rest, qdd=rest, u=found.u) for name in places]
    np.testing.assert_allclose(reached, tensions, rtol=1e-3)


def test_simulations_say_what_is_slack_and_what_is_told_to_push():
    slack = finger([along(length=0.4)])
    simulation = lissom.Simulation(slack, dt=1e-3)
    simulation.step()
    assert simulation.message == "The end of the interval was reached. Slack: 'pull'."
    commanded = finger([along(tension=lissom.Input("tension", 1.0))])
    simulation = lissom.Simulation(commanded, dt=1e-3)
    simulation.step([0.5])
    assert simulation.message == "The end of the interval was reached."
    simulation.step([-0.5])
    assert "commanded tension of 'pull' is -0.5 N: a tendon never pushes" in simulation.message
    other = simulation.copy()
    assert simulation.message == other.message
