"""Tendons that do not stretch, by methods that stop where these change: against closed forms and SciPy."""

import pickle

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from test_inextensible import MASS, ROPE, G, along, finger

import lissom

METHODS = ("radau", "rk45", "dop853")


def rope(length=ROPE, name="rope", anchor=(0, 0, 0), **changes):
    return lissom.Tendon(
        name, [lissom.Via(None, anchor), lissom.Via("bob", (0, 0, 0))], length=length, **changes
    )


def bob(*ropes, gravity=G, loops=()):
    """A small ball on ropes."""
    body = lissom.Body(MASS, inertia=np.diag([1e-5] * 3))
    link = lissom.Link("bob", joint=lissom.Free(), body=body)
    return lissom.Robot([link], gravity=(0, 0, -gravity), actuators=list(ropes) or [rope()], loops=loops)


def place(x, z, vx=0.0, vz=0.0):
    q, v = np.zeros(6), np.zeros(6)
    q[[0, 2]], v[[0, 2]] = (x, z), (vx, vz)
    return {"q0": q, "v0": v}


def run(robot, t_end, method, rtol=1e-8, **start):
    tolerances = {"rtol": rtol} if method == "auto" else {"rtol": rtol, "atol": 1e-2 * rtol}
    return lissom.simulate(robot, t_end, method=method, **tolerances, **start)


def swing(t, y):
    return [y[1], -G / ROPE * np.sin(y[0])]


def pendulum(angle, rate, t_span):
    motion = solve_ivp(swing, t_span, [angle, rate], method="DOP853", rtol=1e-13, atol=1e-13)
    angle, rate = motion.y[:, -1]
    return ROPE * np.array([np.sin(angle), -np.cos(angle)]), rate


def fallen(x, t_end):
    """Where a bob is that falls from beside its anchor, and what it loses as the rope becomes taut."""
    depth = np.sqrt(ROPE**2 - x**2)
    taut_at = np.sqrt(2 * depth / G)
    angle = np.arctan2(x, depth)
    place, _ = pendulum(angle, -G * taut_at * np.sin(angle) / ROPE, (taut_at, t_end))
    return place, 0.5 * MASS * (G * taut_at * np.cos(angle)) ** 2


def gone_over(speed, after):
    """Where a bob is that swings with this speed at the bottom, falls where v^2 = g l cos, and swings on."""

    def tension(_, y):
        return G * np.cos(y[0]) + ROPE * y[1] ** 2

    tension.terminal = True
    motion = solve_ivp(
        swing, (0, 5), [0, speed / ROPE], method="DOP853", rtol=1e-13, atol=1e-13, events=tension
    )
    (slack_at,), ((angle, rate),) = motion.t_events[0], motion.y_events[0]
    start = ROPE * np.array([np.sin(angle), -np.cos(angle)])
    velocity = ROPE * rate * np.array([np.cos(angle), np.sin(angle)])

    def flight(t):
        return start + velocity * t - [0, G / 2 * t**2]

    flown = brentq(lambda t: np.hypot(*flight(t)) - ROPE, 1e-2, 2, xtol=1e-15)
    x, z = flight(flown)
    angle = np.arctan2(x, -z)
    across = (velocity - [0, G * flown]) @ [np.cos(angle), np.sin(angle)]
    taut_at = slack_at + flown
    end, _ = pendulum(angle, across / ROPE, (taut_at, taut_at + after))
    return slack_at, taut_at, end


# A bob on a rope


@pytest.mark.parametrize("method", METHODS)
def test_a_ball_that_falls_into_its_rope_keeps_the_speed_across_it(method):
    end, lost = fallen(0.3, 0.6)
    errors = []
    for rtol in (1e-5, 1e-7, 1e-9):
        motion = run(bob(), 0.6, method, rtol, **place(0.3, 0.0))
        assert motion.success, motion.message
        errors.append(np.hypot(*(motion.q[-1][[0, 2]] - end)))
        assert motion.balance.drift < 100 * rtol
        assert motion.balance.dissipated[-1] == pytest.approx(lost, rel=1e-12)
        assert np.hypot(motion.q[:, 0], motion.q[:, 2]).max() < ROPE + 1e-11
    assert (np.array(errors) < [2e-5, 2e-7, 2e-9]).all()
    assert motion.slack == ["rope"]


@pytest.mark.parametrize("method", METHODS)
def test_a_ball_that_goes_over_the_top_falls_where_nothing_pulls(method):
    speed = np.sqrt(3.5 * G * ROPE)
    slack_at, taut_at, end = gone_over(speed, 0.3)
    for rtol in (1e-6, 1e-9):
        motion = run(bob(), taut_at + 0.3, method, rtol, t_eval="steps", **place(0, -ROPE, speed))
        assert motion.success, motion.message
        assert np.hypot(*(motion.q[-1][[0, 2]] - end)) < 10 * rtol
        assert motion.balance.drift < 100 * rtol
        # A step ends at each change.
        assert np.abs(motion.t - slack_at).min() < 100 * rtol
        assert np.abs(motion.t - taut_at).min() < 100 * rtol
        radii = np.hypot(motion.q[:, 0], motion.q[:, 2])
        taut = (motion.t < slack_at) | (motion.t > taut_at)
        np.testing.assert_allclose(radii[taut], ROPE, rtol=1e-9)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("excess", [0.0, 1e-12, -1e-9, 1e-9, 1e-6, 1e-3])
def test_a_ball_that_grazes_the_end_of_its_rope(method, excess):
    """It loses the rest of its speed there, or nothing."""
    speed = np.sqrt(2 * G * ROPE) + excess
    motion = run(bob(), 0.5, method, **place(0, 0, 0, speed))
    assert motion.success, motion.message
    rest = max(speed**2 - 2 * G * ROPE, 0.0)
    at = (speed - np.sqrt(rest)) / G
    wanted = ROPE - G / 2 * (0.5 - at) ** 2 if rest > 0 else speed * 0.5 - G / 2 * 0.25
    # What is taken up where it is longer by 1e-10 is not seen where it is less.
    assert motion.q[-1][2] == pytest.approx(wanted, abs=2e-6 if abs(excess) < 1e-8 else 1e-9)
    assert motion.balance.drift < 1e-12


@pytest.mark.parametrize("method", METHODS)
def test_nothing_happens_without_tension(method):
    """At rest without gravity, and on a circle."""
    robot = bob(gravity=0.0)
    still = run(robot, 1.0, method, **place(0, -ROPE))
    assert still.success
    np.testing.assert_array_equal(still.q, np.tile(still.q[0], (len(still.q), 1)))
    circling = run(robot, 1.0, method, **place(0, -ROPE, 1.0))
    wanted = ROPE * np.array([np.sin(1 / ROPE), -np.cos(1 / ROPE)])
    np.testing.assert_allclose(circling.q[-1][[0, 2]], wanted, atol=1e-7)
    assert circling.slack == []


# Lengths that vary


@pytest.mark.parametrize("method", METHODS)
def test_a_winch_that_runs_ahead_stops_and_lifts(method):
    """The bob falls freely behind the winch, stops dead at the end, and is jerked up at a corner."""
    robot = bob(rope(([0.0, 0.1, 0.2, 0.5, 0.8], [0.5, 0.5, 0.8, 0.8, 0.6])))
    times = np.array([0.05, 0.25, 0.34, 0.4, 0.45, 0.6, 0.7])
    motion = run(robot, 0.7, method, t_eval=times, **place(0, -0.5))
    assert motion.success, motion.message
    lift = 2 / 3
    heights = [
        -0.5,
        *(-0.5 - G / 2 * (times[1:3] - 0.1) ** 2),
        -0.8,
        -0.8,
        *(-0.8 + lift * (times[5:] - 0.5)),
    ]
    np.testing.assert_allclose(motion.q[:, 2], heights, atol=1e-10)
    np.testing.assert_allclose(motion.v[-2:, 2], lift, rtol=1e-9)
    impact = MASS * G * 0.3
    jerk = 0.5 * MASS * lift**2
    np.testing.assert_allclose(
        motion.balance.dissipated, [0, 0, 0, impact, impact, impact + jerk, impact + jerk], atol=1e-10
    )
    assert motion.balance.drift < 1e-10


@pytest.mark.parametrize("method", METHODS)
def test_a_hoist_follows_its_rope(method):
    amplitude, frequency = 0.02, 1.5
    omega = 2 * np.pi * frequency
    robot = bob(rope(lissom.Harmonic(amplitude, frequency, mean=ROPE)))
    motion = run(robot, 1.0, method, max_step=0.02, **place(0, -ROPE, 0, -amplitude * omega))
    assert motion.success, motion.message
    length = ROPE + amplitude * np.sin(omega * motion.t)
    np.testing.assert_allclose(motion.q[:, 2], -length, atol=1e-10)
    np.testing.assert_allclose(motion.v[:, 2], -amplitude * omega * np.cos(omega * motion.t), atol=1e-9)
    tension = robot.actuator_force("rope", motion.q[-1], motion.v[-1], t=motion.t[-1], qdd=motion.a[-1])
    acceleration = amplitude * omega**2 * np.sin(omega * motion.t[-1])
    assert tension == pytest.approx(MASS * (G + acceleration), rel=1e-9)
    assert motion.balance.drift < 1e-3
    assert motion.slack == []


# Two at once


def plate():
    """Hung up by two vertical cords, at its ends."""
    body = lissom.Body(1.0, inertia=np.diag([1e-2, 5e-3, 1e-2]))
    cords = [
        lissom.Tendon(name, [lissom.Via(None, (x, 0, 0)), lissom.Via("plate", (x, 0, 0))], length=0.3)
        for name, x in (("left", -0.2), ("right", 0.2))
    ]
    link = lissom.Link("plate", joint=lissom.Free(), body=body)
    return lissom.Robot([link], gravity=(0, 0, -G), actuators=cords)


def tilted(angle):
    start = place(0, -0.2)
    start["q0"][4] = angle
    return start


@pytest.mark.parametrize("method", METHODS)
def test_a_plate_that_falls_flat_stops_in_both_cords(method):
    motion = run(plate(), 1.0, method, **tilted(0.0))
    assert motion.success, motion.message
    np.testing.assert_allclose(motion.q[-1], [0, 0, -0.3, 0, 0, 0], atol=1e-10)
    assert motion.balance.dissipated[-1] == pytest.approx(G * 0.1, rel=1e-9)
    assert motion.balance.drift < 1e-12


@pytest.mark.parametrize("tilt", [0.05, 0.3])
def test_a_plate_that_falls_askew_rocks_until_both_cords_are_taut(tilt):
    """Infinitely many impacts in a finite time end; Newmark's steps come to the same."""
    robot = plate()
    found = {method: run(robot, 1.0, method, **tilted(tilt)) for method in METHODS}
    ends = {method: motion.q[-1] for method, motion in found.items()}
    for motion in found.values():
        assert motion.success, motion.message
        assert motion.balance.drift < 1e-6
        assert (np.diff(motion.balance.dissipated) > -1e-9).all()
        for name in ("left", "right"):
            assert robot.actuator_length(name, motion.q[-1]) == pytest.approx(0.3, abs=1e-10)
    np.testing.assert_allclose(ends["rk45"], ends["radau"], atol=1e-6)
    np.testing.assert_allclose(ends["dop853"], ends["radau"], atol=1e-6)
    errors = []
    for dt in (2e-3, 1e-3, 5e-4, 2.5e-4):
        motion = lissom.simulate(robot, 1.0, dt=dt, **tilted(tilt))
        errors.append(np.abs(motion.q[-1] - ends["radau"]).max())
    assert errors[-1] < 2e-5
    assert errors[0] / errors[-1] > 4.0


@pytest.mark.parametrize("method", METHODS)
def test_a_ball_between_two_ropes(method):
    """It falls into one that ends on the left, swings into the other, and comes to rest below both."""
    ropes = [rope(0.5, "left", (-0.3, 0, 0)), rope(0.5, "right", (0.3, 0, 0))]
    robot = bob(*ropes)
    motion = run(robot, 4.0, method, t_eval="steps", **place(-0.25, -0.1))
    assert motion.success, motion.message
    assert motion.balance.drift < 1e-6
    for name in ("left", "right"):
        assert robot.actuator_length(name, motion.q).max() < 0.5 + 1e-9
    np.testing.assert_allclose(motion.q[-1][[0, 2]], [0.0, -0.4], atol=1e-8)
    np.testing.assert_allclose(motion.v[-1][[0, 2]], 0.0, atol=1e-8)


@pytest.mark.parametrize("seed", range(12))
def test_a_body_on_cords_moves_alike_by_all_methods(seed):
    """One to four cords to anywhere, some of them on winches: dozens of impacts in space."""
    rng = np.random.default_rng(seed)
    body = lissom.Body(1.0, inertia=np.diag(rng.uniform(6e-3, 1e-2, 3)))
    cords = []
    for i in range(rng.integers(1, 5)):
        point, anchor = rng.uniform(-0.2, 0.2, 3), rng.uniform((-0.5, -0.5, -0.1), (0.5, 0.5, 0.9))
        length = np.linalg.norm(anchor - point) * rng.uniform(1.0, 1.5)
        if rng.random() < 0.3:
            length = lissom.Harmonic(0.05 * length, rng.uniform(0.5, 3.0), mean=1.1 * length)
        path = [lissom.Via(None, tuple(anchor)), lissom.Via("body", tuple(point))]
        cords.append(lissom.Tendon(f"cord {i}", path, length=length))
    link = lissom.Link("body", joint=lissom.Free(), body=body)
    robot = lissom.Robot([link], gravity=(0, 0, -G), actuators=cords)
    v0 = rng.normal(size=6) * [0.5, 0.5, 0.5, 2, 2, 2]
    found = [run(robot, 1.0, method, v0=v0) for method in METHODS]
    for motion in found:
        assert motion.success, motion.message
        # What long steps of high order leave of the work of winches.
        assert motion.balance.drift < 5e-4
    places = [motion.q[:, :3] for motion in found]
    np.testing.assert_allclose(places[1], places[0], atol=1e-5)
    np.testing.assert_allclose(places[2], places[0], atol=1e-5)


# With closed loops, along rods


@pytest.mark.parametrize("method", METHODS)
def test_a_bead_on_a_rail_stops_where_its_rope_ends(method):
    """The rail is a closed loop, inclined; the rope is anchored at its upper end."""
    slope = 0.4
    along = (np.cos(slope), 0.0, -np.sin(slope))
    rail = lissom.Loop(("bob", None), (None, None), lissom.Prismatic(along))
    motion = run(bob(loops=[rail]), 1.0, method, q0=0.1 * np.array([*along, 0, 0, 0]), t_eval=[0.2, 0.4, 0.9])
    assert motion.success, motion.message
    travelled = motion.q[:, :3] @ along
    np.testing.assert_allclose(travelled[:2], 0.1 + G / 2 * np.sin(slope) * motion.t[:2] ** 2, atol=1e-9)
    assert travelled[2] == pytest.approx(ROPE, abs=1e-10)
    robot = bob(loops=[rail])
    tension = robot.actuator_force("rope", motion.q[-1], motion.v[-1], qdd=motion.a[-1])
    assert tension == pytest.approx(MASS * G * np.sin(slope), rel=1e-9)
    assert motion.balance.drift < 1e-10


@pytest.mark.parametrize("size", [1e-9, 1e-6, 1e-3, 1e3])
@pytest.mark.parametrize("is_beside", [False, True])
@pytest.mark.parametrize("method", ["generalised_alpha", "hht", *METHODS])
def test_ropes_are_as_long_as_they_are_whatever_is_beside(method, is_beside, size):
    """A bead on a straight rail has no size of its own; its rope is measured by its own length."""
    bead = lissom.Link("bead", joint=lissom.Prismatic((1, 0, 0)), body=lissom.Body(1.0))
    path = [lissom.Via(None, (-size, 0, 0)), lissom.Via("bead", (0, 0, 0))]
    arm = lissom.Link("arm", joint=lissom.Revolute((0, 1, 0)), body=lissom.Body(10.0, centre=(3, 0, 0)))
    rope = lissom.Tendon("rope", path, length=1.1 * size)
    robot = lissom.Robot([bead, arm] if is_beside else [bead], actuators=[rope], gravity=(0, 0, 0))
    start = {"v0": [0.5 * size, 1.0][: robot.n], "t_eval": [0.1, 1.0]}
    step = {"dt": 0.01} if method in ("generalised_alpha", "hht") else {"rtol": 1e-6}
    tolerance = {"atol": 1e-9 * min(size, 1)} if method in ("radau", "rk45", "dop853") else {}
    motion = lissom.simulate(robot, 1.0, method=method, **step, **tolerance, **start)
    assert motion.success, motion.message
    np.testing.assert_allclose(motion.q[:, 0] / size, [0.05, 0.1], atol=1e-6)


def distance(robot, motion, other):
    tips = [robot.pose(q, 0.3)[:, :3, 3] for q in (motion.q, other.q)]
    return np.abs(tips[0] - tips[1]).max()


def test_a_finger_that_is_pulled_and_let_go():
    """Newmark's steps come to it with their order, and tendons with their stiffness."""
    times, grid = ([0.0, 0.2, 0.4], [0.2999, 0.296, 0.31]), np.linspace(0.0, 0.4, 41)
    robot = finger([along(length=times)])
    start = {"q0": lissom.statics(robot, t=0.0).q, "t_eval": grid}
    wanted = run(robot, 0.4, "radau", 1e-8, **start)
    assert wanted.success, wanted.message
    assert wanted.slack == ["pull"]
    for method in METHODS:
        for rtol in (1e-5, 1e-7):
            motion = run(robot, 0.4, method, rtol, **start)
            assert motion.success, motion.message
            assert distance(robot, motion, wanted) < rtol
            assert motion.balance.drift < 10 * rtol
    errors = [
        distance(robot, lissom.simulate(robot, 0.4, dt=dt, **start), wanted) for dt in (1e-3, 5e-4, 2.5e-4)
    ]
    assert errors[0] > 1.8 * errors[1] > 3.2 * errors[2]
    errors = []
    for stiffness in (2e5, 2e6, 2e7):
        stiff = finger([along(length=times, stiffness=stiffness)])
        errors.append(distance(robot, run(stiff, 0.4, "radau", 1e-7, **start), wanted))
    np.testing.assert_allclose(np.array(errors[:2]) / errors[1:], 10.0, rtol=0.1)


@pytest.mark.parametrize("method", METHODS)
def test_a_finger_that_falls_into_two_cords(method):
    cords = [along("up", (0.0, 0.008), length=0.3005), along("down", (0.0, -0.008), length=0.3005)]
    robot, grid = finger(cords), np.linspace(0.0, 0.5, 51)
    wanted = run(robot, 0.5, "radau", 1e-8, t_eval=grid)
    motion = run(robot, 0.5, method, 1e-6, t_eval=grid)
    assert motion.success, motion.message
    assert distance(robot, motion, wanted) < 1e-7
    assert motion.balance.drift < 1e-5
    assert sorted(motion.slack) == ["down", "up"]
    for name in ("up", "down"):
        assert robot.actuator_length(name, motion.q).max() < 0.3005 + 1e-9


# To an accuracy


@pytest.mark.parametrize("rtol", [1e-3, 1e-5, 1e-7])
def test_an_accuracy_is_reached_and_reported(rtol):
    speed = np.sqrt(3.5 * G * ROPE)
    _, taut_at, over = gone_over(speed, 0.3)
    fell, _ = fallen(0.3, 0.6)
    cases = [(over, taut_at + 0.3, place(0, -ROPE, speed)), (fell, 0.6, place(0.3, 0.0))]
    for end, t_end, start in cases:
        motion = run(bob(), t_end, "auto", rtol, **start)
        assert motion.status == "finished", motion.message
        assert "tensions are not estimated" in motion.message
        # The length of a robot without rods is one metre.
        error = np.hypot(*(motion.q[-1][[0, 2]] - end))
        assert error < motion.stats.time_error <= rtol


# From outside


@pytest.mark.parametrize("method", METHODS)
def test_steps_from_outside_and_pickles(method):
    end, _ = fallen(0.3, 0.6)
    stepped = lissom.Simulation(bob(), dt=1e-2, method=method, rtol=1e-8, atol=1e-10, **place(0.3, 0.0))
    again = lissom.Simulation(bob(), dt=1e-2, method=method, rtol=1e-8, atol=1e-10, **place(0.3, 0.0))
    for _ in range(60):
        stepped.step()
        again = pickle.loads(pickle.dumps(again))
        again.step()
    np.testing.assert_array_equal(stepped.q, again.q)
    np.testing.assert_array_equal(stepped.v, again.v)
    np.testing.assert_allclose(stepped.q[[0, 2]], end, atol=1e-7)


def test_many_runs_are_those_of_one():
    starts = [place(x, 0.0)["q0"] for x in (0.1, 0.2, 0.3)]
    many = lissom.simulate_many(bob(), 0.6, q0=np.array(starts), method="radau")
    for q, start in zip(many.q, starts, strict=True):
        np.testing.assert_array_equal(q, lissom.simulate(bob(), 0.6, q0=start, method="radau").q)


@pytest.mark.parametrize("method", METHODS)
def test_a_length_that_is_set_from_outside(method):
    """Let out, the tendon is slack; taken in at once, no finite force follows."""
    robot = bob(rope(lissom.Input("length", ROPE)))

    def out(t, q, v):
        return [ROPE + 0.05 * t]

    start = place(0.1, -np.sqrt(ROPE**2 - 0.01))
    motion = lissom.simulate(robot, 0.5, method=method, control=out, control_step=1e-2, **start)
    assert motion.success, motion.message
    assert np.hypot(*motion.q[-1][[0, 2]]) <= ROPE + 0.05 * 0.49 + 1e-9
    assert motion.balance.drift < 1e-4

    def inwards(t, q, v):
        return [ROPE - 0.1 * t]

    motion = lissom.simulate(robot, 0.5, method=method, control=inwards, control_step=1e-2, **start)
    assert motion.status == "loop_open"
    assert "jumps, by 1.0e-3 m" in motion.message
    assert motion.t[-1] == 0.01


# What cannot be


@pytest.mark.parametrize("method", METHODS)
def test_a_length_that_jumps_ends_a_run(method):
    """Whether it pulls or is slack after that."""
    for after in (0.4, 0.6):
        robot = bob(rope(lambda t, after=after: ROPE if t < 0.1 else after))
        motion = run(robot, 0.5, method, **place(0.1, -np.sqrt(ROPE**2 - 0.01)))
        assert not motion.success
        assert motion.t[-1] <= 0.1
        assert motion.status in ("loop_open", "step_too_small", "singular_position")
        assert "jump" in motion.message or method == "radau"


@pytest.mark.parametrize("method", METHODS)
def test_a_length_that_jumps_over_a_slack_tendon_takes_it_up(method):
    robot = bob(rope(lambda t: 1.0 if t < 0.1 else 0.5))
    motion = run(robot, 0.3, method, **place(0.3, 0.0))
    end, _ = fallen(0.3, 0.3)
    assert motion.success, motion.message
    np.testing.assert_allclose(motion.q[-1][[0, 2]], end, atol=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_lengths_that_conflict_on_the_way_end_a_run(method):
    """At 0.4 s the lower rope has come in as far as the upper one lets it."""
    robot = bob(rope(), rope(lambda t: 0.9 - 0.5 * t, "low", (0, 0, -1.2)))
    motion = run(robot, 1.0, method, 1e-6, **place(0, -ROPE))
    assert motion.status == "loop_open"
    assert "conflict" in motion.message
    assert motion.t[-1] == pytest.approx(0.4, abs=0.011)


@pytest.mark.parametrize("method", METHODS)
def test_a_rope_that_is_hardly_too_short_stops_a_free_flight(method):
    """A bob flies by in long steps; without its rope it would be too far away by 2.5 mm for a moment."""
    length = 0.4637
    link = lissom.Link("bob", joint=lissom.Planar((0, 1, 0)), body=lissom.Body(1.0, inertia=np.eye(3) * 0.01))
    robot = lissom.Robot([link], gravity=(0, 0, -G), actuators=[rope(length)])
    # The second coordinate of this joint points down.
    q, v = np.array([-0.462, 0.0]), np.array([1.242, -2.986])

    def flight(t):
        return q + v * t + np.array([0, 0.5 * G * t * t])

    def excess(t):
        return np.linalg.norm(flight(t)) - length

    times = np.linspace(0.0, 0.6, 20001)
    values = np.array([excess(t) for t in times])
    first = int(np.argmax(values > 0))
    after = first + int(np.argmax(values[first:] <= 0))
    assert 2e-3 < values[first:after].max() < 3e-3
    taut = brentq(excess, times[first - 1], times[first], xtol=1e-14)
    motion = run(robot, taut + 1e-9, method, q0=[*q, 0.0], v0=[*v, 0.0])
    out = flight(taut) / length
    speed = v + np.array([0, G * taut])
    kept = speed - out * (speed @ out)
    np.testing.assert_allclose(motion.v[-1, :2], kept, atol=1e-6)
    whole = run(robot, 0.6, method, q0=[*q, 0.0], v0=[*v, 0.0])
    assert whole.success, whole.message
    np.testing.assert_allclose(whole.q[-1, :2], [0.30434, 0.02915], atol=1e-5)


@pytest.mark.parametrize("method", [*METHODS, "auto", "newmark"])
def test_the_length_of_a_slack_tendon_must_be_finite(method):
    wire = rope(lambda t: 1.0 if t < 0.15 else np.nan)
    motion = lissom.simulate(bob(wire), 0.6, method=method, **place(0.0, -0.5))
    assert not motion.success
    assert motion.status == "non_finite"
    assert "rope" in motion.message


def test_gaps_with_a_length_that_varies():
    wire = rope(lissom.Harmonic(0.01, 1.0, mean=1.2))
    robot = bob(wire)
    q = place(1.0, 0.0)["q0"]
    assert robot.loop_gaps(q, t=0.25).shape == (1,)
    with pytest.raises(TypeError, match="t: got none"):
        robot.loop_gaps(q)


def test_a_linear_model_without_what_slack_tendons_hold():
    link = lissom.Link("bob", joint=lissom.Prismatic((1, 0, 0), stiffness=100.0), body=lissom.Body(1.0))
    wire = rope(0.5, anchor=(-0.1, 0, 0))
    robot = lissom.Robot([link], gravity=(0, 0, 0), actuators=[wire])
    linear = lissom.linearise(robot, lissom.statics(robot).q)
    np.testing.assert_allclose(np.abs(np.linalg.eigvals(linear.A)), 10.0)
    taut = lissom.Robot(
        [link],
        gravity=(0, 0, 0),
        actuators=[rope(0.1, anchor=(-0.1, 0, 0))],
        loads=[lissom.Load(force=(5.0, 0, 0), link="bob")],
    )
    assert lissom.linearise(taut, [0.0]).states == ()
