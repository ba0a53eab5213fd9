"""What results say of contacts: the deepest overlap, messages about contacts that are too soft or hold up a
run, times at which contact begins and ends, and wrenches inside a rod where it touches something.
"""

from __future__ import annotations

import copy
import itertools
import pickle
import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

FLOOR = lissom.HalfSpace()
CABLE_RADIUS = 5e-3


def cable(stiffness=None, height=0.05, young=5e7, **options):
    """A clamped rod above a floor on which it comes to lie."""
    segment = lissom.Segment(
        0.5, CABLE_RADIUS, young, poisson_ratio=0.4, density=1500, modes={"bend_y": 4}, retardation_time=0.02
    )
    contact = lissom.Contact("rod", FLOOR, stiffness=stiffness, name="ground")
    link = lissom.Link("rod", rod=[segment], position=(0, 0, height))
    return lissom.Robot([link], contacts=[contact], **options)


def test_statics_has_the_deepest_overlap():
    robot = cable(1e4)
    found = lissom.statics(robot)
    assert found.success
    deepest = max(touch.overlap for touch in robot.touches(found.q))
    assert found.deepest.contact == "ground"
    assert found.deepest.t is None
    assert_allclose(found.deepest.depth, deepest, rtol=1e-9)
    assert_allclose(found.deepest.share, deepest / CABLE_RADIUS, rtol=1e-9)
    assert lissom.statics(cable(1e4, height=1.0)).deepest is None
    assert lissom.statics(lissom.Robot(robot.links)).deepest is None


@pytest.mark.parametrize("method", ["newmark", "radau"])
def test_motions_have_the_deepest_overlap_of_their_steps(method):
    robot = cable(1e5)
    motion = lissom.simulate(robot, 0.4, dt=2e-3, method=method)
    assert motion.success
    overlaps = [
        max((touch.overlap for touch in robot.touches(q, v)), default=0.0)
        for q, v in zip(motion.q, motion.v, strict=True)
    ]
    deepest = motion.deepest
    assert deepest.contact == "ground"
    assert_allclose(deepest.share, deepest.depth / CABLE_RADIUS, rtol=1e-12)
    if method == "newmark":
        # Its steps are all states of the result.
        assert_allclose(deepest.depth, max(overlaps), rtol=1e-9)
        assert deepest.t == motion.t[np.argmax(overlaps)]
    else:
        assert deepest.depth >= 0.9 * max(overlaps)
    assert lissom.simulate(cable(1e5, height=1.0), 0.05, dt=5e-3, method=method).deepest is None


def test_results_keep_it(tmp_path):
    robot = cable(1e5)
    for result in (lissom.statics(robot), lissom.simulate(robot, 0.2, dt=2e-3)):
        path = tmp_path / f"{type(result).__name__}.nc"
        result.save(path)
        for again in (pickle.loads(pickle.dumps(result)), copy.copy(result), lissom.load(path)):
            deepest = again.deepest
            known = result.deepest
            assert (deepest.contact, deepest.depth, deepest.share, deepest.t) == (
                known.contact,
                known.depth,
                known.share,
                known.t,
            )
    assert repr(result.deepest).startswith('<Overlap of "ground": ')


def advised(message):
    """The stiffness that a message advises."""
    (number,) = re.findall(r"raise `stiffness` from \S+ to ([\d.e+-]+) N/m\^2", message)
    return float(number)


def test_contacts_that_are_too_soft_are_named_with_a_number_that_helps():
    soft = lissom.statics(cable(2000.0))
    assert soft.success
    assert soft.deepest.share > 0.35
    assert 'The contact "ground" is soft for its load' in soft.message
    better = lissom.statics(cable(advised(soft.message)))
    assert better.success
    assert better.deepest.share < 0.2
    assert "soft" not in better.message
    # Without rebounds it does not sink in.
    stopped = lissom.methods.Newmark(impacts="stopped")
    motion = lissom.simulate(cable(1e4), 0.3, dt=2e-3, method=stopped)
    assert motion.success
    assert motion.deepest.share > 0.35
    assert_allclose(advised(motion.message), 1e4 * (motion.deepest.share / 0.15) ** 1.5, rtol=0.1)
    better = lissom.simulate(cable(advised(motion.message)), 0.3, dt=2e-3, method=stopped)
    assert better.deepest.share < 0.35
    assert "soft" not in better.message
    assert "soft" not in lissom.simulate(cable(), 0.3, dt=2e-3).message


def test_what_touches_where_a_search_fails_is_named():
    failed = lissom.statics(cable("material"), max_iter=10)
    assert not failed.success
    place = r'contact "ground" overlaps most at \((\S+), \S+, \S+\) m, (\S+) m along "rod", (\S+) m deep'
    x, along, deep = map(float, re.search(place, failed.message).groups())
    touches = cable("material").touches(failed.q)
    most = max(touches, key=lambda touch: touch.overlap)
    assert_allclose([x, along], [most.position[0], most.along[0]], atol=1e-4)
    assert_allclose(deep, most.overlap, rtol=0.1)
    # With a number that does not hold it up.
    (number,) = re.findall(r"It is stiff for its load: `stiffness=(\S+)` in place of 4.7e7", failed.message)
    assert_allclose(float(number), cable()._contact_stiffness()[0], rtol=0.1)
    # What is as stiff as it must be, is not called stiff.
    failed = lissom.statics(cable(), max_iter=10)
    assert not failed.success
    assert 'contact "ground" overlaps most' in failed.message
    assert "stiff for its load" not in failed.message


def test_steps_into_a_first_touch_that_fail_say_what_meets():
    # Of impacts that no step follows: the last state touches nothing.
    wire = lissom.Segment(
        6.0, 5e-4, 2e11, poisson_ratio=0.4, density=1500, modes={"bend_y": 8}, retardation_time=0.01
    )
    contact = lissom.Contact("wire", lissom.HalfSpace((0, 0, -0.3)), stiffness="material", name="ground")
    robot = lissom.Robot([lissom.Link("wire", rod=[wire])], contacts=[contact])
    motion = lissom.simulate(robot, 1.0, dt=5e-2)
    assert not motion.success
    assert motion.deepest is None
    assert re.search(
        r'meet in the next step: those of contact "ground" near \(\S+, \S+, -0.3', motion.message
    )
    assert re.search(r"`stiffness=\S+e6` in place of 1.9e11 N/m\^2", motion.message)


def test_runs_that_end_early_say_what_touches():
    def stop(t):
        return (0.0, 0.0, np.nan if t > 0.3 else 0.0)

    robot = cable(1e5, loads=[lissom.Load(force=stop)])
    motion = lissom.simulate(robot, 0.5, dt=2e-3)
    assert motion.status == "non_finite"
    assert 'contact "ground" overlaps most at' in motion.message
    by_steps = lissom.Simulation(robot, dt=2e-3)
    by_steps.step(duration=0.5)
    assert by_steps.status == "non_finite"
    assert 'contact "ground" overlaps most at' in by_steps.message


G = 9.81
BALL_STIFFNESS = 2e4
MASS = 0.1
BALL_RADIUS = 0.05


def ball(joint, **constants):
    link = lissom.Link("ball", body=lissom.Body(MASS, inertia=[1e-4] * 3), joint=joint)
    floor = lissom.HalfSpace((0, 0, 0), (0, 0, 1))
    contact = lissom.Contact(
        lissom.Ball("ball", BALL_RADIUS),
        floor,
        stiffness=BALL_STIFFNESS,
        dissipation=0.0,
        name="bounce",
        **constants,
    )
    return lissom.Robot([link], contacts=[contact])


def bounces(height, duration):
    """A ball falls on a linear spring: parabolas and parts of a cosine, in turn."""
    omega = np.sqrt(BALL_STIFFNESS / MASS)
    fall, speed = np.sqrt(2 * height / G), np.sqrt(2 * G * height)
    sag = G / omega**2
    # x'' = -omega^2 (x - sag) in the overlap x, starting at zero with the impact speed, until zero again.
    pressed = 2 * (np.pi - np.arctan2(speed / omega, sag)) / omega
    found, t = [], fall
    while t < duration:
        found.append((t, "touch"))
        if t + pressed < duration:
            found.append((t + pressed, "lift_off"))
        t += pressed + 2 * speed / G
    return found


@pytest.mark.parametrize(
    ("method", "accuracy"), [("radau", 1e-8), ("rk45", 1e-7), ("dop853", 1e-7), ("newmark", 1e-4)]
)
def test_a_ball_bounces_when_it_should(method, accuracy):
    options = {"t_eval": "steps", "rtol": 1e-9, "atol": 1e-11} if method != "newmark" else {"dt": 1e-4}
    run = lissom.simulate(
        ball(lissom.Prismatic((0, 0, 1))), 1.5, q0=[0.5 + BALL_RADIUS], method=method, **options
    )
    events, expected = run.contact_events(), bounces(0.5, 1.5)
    assert [event.kind for event in events] == [kind for _, kind in expected]
    assert {event.contact for event in events} == {"bounce"}
    for event, (t, _) in zip(events, expected, strict=True):
        assert abs(event.t - t) < accuracy
        # The state at the event: the height of the ball is its radius, and its speed that of the impact.
        assert abs(event.q[0] - BALL_RADIUS) < 10 * accuracy
        assert abs(abs(event.v[0]) - np.sqrt(2 * G * 0.5)) < 1e3 * accuracy


def test_several_contacts_are_told_apart():
    finger = lissom.Segment(0.3, 0.01, 3e5, 1e5, 1100, modes={"bend_y": 2}, retardation_time=0.05)
    floor = lissom.HalfSpace((0, 0, -0.1), (0, 0, 1))
    contacts = [
        lissom.Contact(lissom.Ball("finger", 0.02, at=0.3), floor, stiffness=1e4, name="tip"),
        lissom.Contact(lissom.Ball("finger", 0.02, at=0.15), floor, stiffness=1e4, name="middle"),
    ]
    robot = lissom.Robot([lissom.Link("finger", rod=[finger])], contacts=contacts)
    run = lissom.simulate(robot, 1.0, method="radau", t_eval="steps")
    events = run.contact_events()
    assert [event.t for event in events] == sorted(event.t for event in events)
    first = next(event for event in events if event.contact == "tip")
    assert first.kind == "touch"
    height = robot.pose(first.q, link="finger")[2, 3]
    assert abs(height - (-0.1 + 0.02)) < 1e-9
    # Between its events a contact does not change.
    for name in ("tip", "middle"):
        kinds = [event.kind for event in events if event.contact == name]
        assert all(a != b for a, b in itertools.pairwise(kinds))


def test_without_contacts_there_are_no_events():
    rod = lissom.Rod([lissom.Segment(0.3, 0.01, 3e5, 1e5, 1100, modes={"bend_y": 2})])
    assert lissom.simulate(rod, 0.05).contact_events() == []
    pendulum = lissom.simulate(lissom.SpringPendulum(), 0.05, q0=[-0.5, 0.1])
    assert pendulum.contact_events() == []
    own = lissom.newmark(lambda t, q, v, a: a + q, (0.0, 0.1), [1.0], [0.0], dt=0.01)
    with pytest.raises(ValueError, match="newmark"):
        own.contact_events()


def test_what_touches_all_the_time_has_no_events():
    robot = ball(lissom.Prismatic((0, 0, 1)))
    rest = BALL_RADIUS - MASS * G / BALL_STIFFNESS
    assert lissom.simulate(robot, 0.1, q0=[rest], dt=1e-3).contact_events() == []


LENGTH, RADIUS, STIFFNESS = 0.5, 0.01, 1e5


def rod(name, size):
    segment = lissom.Segment(
        LENGTH * size, RADIUS * size, 1e6, poisson_ratio=0.4, density=1e3, modes={"bend_y": 3}
    )
    return lissom.Link(name, rod=[segment], joint=lissom.Free())


def force_beyond(links, contact, q, link, places):
    """Upward force of contact on what lies beyond places of a link."""
    touching, bare = lissom.Robot(links, contacts=[contact]), lissom.Robot(links)
    rest = np.zeros_like(q)

    def force(place):
        wrenches = [robot.internal_wrench(q, rest, rest, place, link=link) for robot in (bare, touching)]
        return (touching.pose(q, place, link=link)[:3, :3] @ (wrenches[0] - wrenches[1])[3:])[2]

    return np.array([force(place) for place in places])


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_pressure_of_a_floor_beyond_a_cut(size):
    """A straight rod, tilted, in a floor along its whole length: depth and force per length are linear."""
    tilt, depth = 0.004, 1e-3 * size
    q = np.zeros(6 + 3)
    q[2], q[4] = RADIUS * size - depth, tilt
    floor = lissom.Contact("rod", lissom.HalfSpace((0, 0, 0)), stiffness=STIFFNESS)
    length = LENGTH * size
    places = np.linspace(0, length, 101)
    found = force_beyond([rod("rod", size)], floor, q, "rod", places)
    exact = STIFFNESS * (depth * (length - places) + np.sin(tilt) * (length**2 - places**2) / 2)
    np.testing.assert_allclose(found, exact, atol=3e-6 * exact[0])


@pytest.mark.parametrize("is_turned", [False, True])
def test_rods_that_lie_on_each_other_balance_beyond_every_cut(is_turned):
    """Forces per length are the same all along, on both rods, also where these go opposite ways."""
    q = np.zeros(2 * (6 + 3))
    q[9 + 2] = 1.9 * RADIUS
    if is_turned:
        q[9], q[9 + 5] = LENGTH, np.pi
    links, contact = [rod("lower", 1), rod("upper", 1)], lissom.Contact("lower", "upper", stiffness=STIFFNESS)
    places = np.linspace(0, LENGTH, 101)
    exact = STIFFNESS * 0.1 * RADIUS * (LENGTH - places)
    for link, sign in (("lower", -1), ("upper", 1)):
        found = force_beyond(links, contact, q, link, places)
        np.testing.assert_allclose(found, sign * exact, atol=1e-9 * exact[0])


def test_what_touches_in_part_is_cut_without_jumps():
    """A tilted rod, of which one half is in the floor: the force beyond a cut is continuous."""
    q = np.zeros(6 + 3)
    q[2], q[4] = RADIUS + 1e-3, 0.004
    floor = lissom.Contact("rod", lissom.HalfSpace((0, 0, 0)), stiffness=STIFFNESS)
    places = np.linspace(0, LENGTH, 1001)
    found = force_beyond([rod("rod", 1)], floor, q, "rod", places)
    depth = np.maximum(np.sin(0.004) * places - 1e-3, 0)
    assert np.all(np.abs(np.diff(found)) <= 1.02 * STIFFNESS * depth.max() * places[1])
    first = 1e-3 / np.sin(0.004)
    beyond = np.maximum(places, first)
    exact = STIFFNESS * np.sin(0.004) * ((LENGTH - first) ** 2 - (beyond - first) ** 2) / 2
    np.testing.assert_allclose(found, exact, atol=1e-5 * exact[0])


@pytest.mark.parametrize("place", [-0.006, -0.005, -0.002])
def test_a_start_within_an_obstacle_is_refused_with_its_largest_overlap(place):
    """A rod of 0.9 mm beside the axis of a capsule of 8 mm: of several places, the deepest."""
    segment = lissom.Segment(1.0, 0.9e-3, 5e10, 2e10, 6450.0, {"bend_y": 8})
    obstacle = lissom.Capsule((0.2, -0.05, place), (0.2, 0.05, place), 0.008)
    link = lissom.Link("catheter", rod=[segment], position=(-0.55, 0, 0))
    contact = lissom.Contact("catheter", obstacle, stiffness=1e5)
    robot = lissom.Robot([link], contacts=[contact], gravity=(0, 0, 0))
    rest = np.zeros(robot.n)
    deepest = max(touch.overlap for touch in robot.touches(rest, rest))
    assert deepest == pytest.approx(0.0089 + place, rel=0.1)
    with pytest.raises(ValueError, match=f"overlaps by {deepest:.4f} m".replace(".", r"\.")):
        lissom.simulate(robot, 0.01, dt=1e-3)
