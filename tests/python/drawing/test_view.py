"""Live views: motion in real time, user interaction, drawing, the page, the command."""

import contextlib
import gzip
import http.client
import os
import re
import signal
import subprocess
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
import viser

import lissom
from lissom.drawing import live, meshes
from lissom.drawing.live import controls, gate, messages
from lissom.drawing.live.controls import STRONGEST, readout
from lissom.drawing.live.motion import HELD, HELD_WHILE_PULLED, Motion
from lissom.drawing.live.playback import PATIENCE, Playback
from lissom.drawing.live.server import LiveView
from lissom.drawing.live.shape import SHADE, Shape
from lissom.drawing.live.sliders import sliders
from lissom.drawing.live.trace import PLACES, Trace
from lissom.drawing.report import quantities
from lissom.drawing.report.layers import Arrows, Solid, Strand, Tube
from lissom.model.views import view

SOFT = lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 3, "bend_z": 3}, retardation_time=0.02)
UPPER = lissom.Tendon("upper", [lissom.Along("rod", (0.0, 0.008))], tension=lissom.Input("upper", 0.5))
PUSHED = lissom.Load(force=lissom.Input("push", (0.0, 0.0, 0.0)))
FINGER = lissom.Rod([SOFT], actuators=[UPPER], loads=[PUSHED])

SCENE = """version = 1
[[link]]
name = "finger"
[[link.rod.segment]]
length = 0.2
radius = 0.01
young_modulus = 3e5
poisson_ratio = 0.5
density = 1070
retardation_time = 0.01
modes = { bend_y = 2 }
[[tendon]]
name = "pull"
path = [{ offset = [0, 0.008] }]
tension = { input = "pull", default = 0.5 }
[simulation]
t_end = 1
dt = 2e-3
"""


class Clock:
    """A clock that tests advance; computing takes time on it."""

    def __init__(self):
        self.now, self.cost = 100.0, 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def motion():
    return Motion(lissom.Simulation(FINGER, dt=1e-3))


def costly(motion, clock, seconds):
    """Makes each chunk of the motion take this many seconds."""
    advance = motion.advance

    def slow(duration=None):
        clock.now += seconds
        return advance(duration)

    motion.advance = slow
    return motion


# The clock.


@pytest.mark.parametrize("speed", [0.1, 1.0, 4.0])
def test_a_motion_keeps_up_with_the_clock(speed, motion, clock):
    playback = Playback(motion, speed, clock=clock)
    playback.frame()
    for _ in range(60):
        clock.now += 1 / 30
        playback.frame()
        assert -1e-9 < speed * (clock.now - 100.0) - motion.t < motion.chunk + 1e-9
    assert playback.real_time_factor == pytest.approx(speed, abs=motion.chunk)


def test_pictures_are_dropped_not_time(motion, clock):
    """A page that takes half a second per picture still shows the motion at the right time."""
    playback = Playback(motion, clock=clock)
    playback.frame()
    for _ in range(6):
        clock.now += 0.5
        playback.frame()
    assert motion.t == pytest.approx(3.0, abs=motion.chunk)


def test_what_is_too_slow_falls_behind_and_still_draws(motion, clock):
    playback = Playback(costly(motion, clock, 4 * motion.chunk), clock=clock)
    playback.frame()
    longest = 0.0
    for _ in range(100):
        clock.now += 1 / 30
        begun = clock.now
        playback.frame()
        longest = max(longest, clock.now - begun)
    assert longest < PATIENCE + 4 * motion.chunk + 1e-9
    assert motion.t == pytest.approx((clock.now - 100.0) / 4, rel=0.5)
    assert playback.real_time_factor == pytest.approx(0.2, abs=0.06)
    assert playback.load > 0.7


def test_what_is_owed_is_dropped(motion, clock):
    """A motion that was too slow for a while does not catch up later."""
    slow = costly(motion, clock, 1.0)
    playback = Playback(slow, clock=clock)
    playback.frame()
    clock.now += 10.0
    playback.frame()
    then = motion.t
    assert then < 2 * motion.chunk
    del slow.advance
    clock.now += 0.1
    playback.frame()
    # Only the last second of computing is made up, not the ten before.
    assert motion.t - then < 1.2


def test_pause_step_and_reset(motion, clock):
    playback = Playback(motion, clock=clock)
    playback.frame()
    clock.now += 0.5
    playback.frame()
    playback.is_paused = True
    at = motion.t
    clock.now += 3.0
    playback.frame()
    assert motion.t == at
    assert playback.real_time_factor is None
    playback.step()
    assert motion.t == pytest.approx(at + 1e-3)
    playback.is_paused = False
    clock.now += 0.1
    playback.frame()
    # The pause is not made up.
    assert motion.t == pytest.approx(at + 0.1, abs=2 * motion.chunk)
    playback.reset()
    assert motion.t == 0.0
    np.testing.assert_array_equal(motion.q, np.zeros(6))
    assert not playback.is_paused
    playback.step()
    assert playback.is_paused


def test_time_without_a_page_does_not_pass(motion, clock):
    playback = Playback(motion, clock=clock)
    playback.frame()
    playback.hold()
    clock.now += 100.0
    playback.frame()
    assert motion.t == 0.0


# The motion.


def test_without_hands_it_is_the_simulation(motion):
    simulation = lissom.Simulation(FINGER, dt=1e-3)
    for _ in range(20):
        assert motion.advance()
        simulation.step(duration=motion.chunk)
    assert motion.t == simulation.t
    np.testing.assert_allclose(motion.q, simulation.q, rtol=1e-9, atol=1e-12)


def test_the_simulation_stays_as_it_is():
    simulation = lissom.Simulation(FINGER, dt=1e-3, method="generalised_alpha", rho_inf=0.7)
    simulation.step([0.0, 0.0, 0.1, 2.0], duration=0.1)
    before = simulation.copy()
    motion = Motion(simulation)
    assert (motion.t, motion.u.tolist()) == (simulation.t, [0.0, 0.0, 0.1, 2.0])
    motion.pull(0, motion.place(0) + 0.1)
    motion.advance(0.1)
    assert simulation.t == before.t
    np.testing.assert_array_equal(simulation.q, before.q)
    motion.reset()
    assert motion.t == simulation.t
    np.testing.assert_array_equal(motion.q, simulation.q)


def test_a_slider_moves_its_input_alone(motion):
    assert motion.u.tolist() == [0.0, 0.0, 0.0, 0.5]
    motion.set("upper", 3.0)
    motion.set("push.y", 0.05)
    assert motion.u.tolist() == [0.0, 0.05, 0.0, 3.0]
    held = lissom.Simulation(FINGER, dt=1e-3)
    for _ in range(20):
        motion.advance()
        held.step([0.0, 0.05, 0.0, 3.0], duration=motion.chunk)
    np.testing.assert_allclose(motion.q, held.q, rtol=1e-9, atol=1e-12)


def test_a_pull_moves_the_tip_and_ends(motion):
    for _ in range(100):
        motion.advance()
    rest, target = motion.place(0), motion.place(0) + np.array([0.0, 0.1, 0.05])
    motion.pull(0, target)
    for _ in range(2000):
        assert motion.advance()
    moved = motion.place(0) - rest
    across = (target - rest) / np.linalg.norm(target - rest)
    assert 0.02 < moved @ across < 1.01 * np.linalg.norm(target - rest)
    # In equilibrium with that force as load at the tip.
    loaded = lissom.Rod([SOFT], actuators=[UPPER], loads=[lissom.Load(force=motion.force)])
    rest_of = loaded.inverse_dynamics(motion.q, np.zeros(6), np.zeros(6))
    assert np.linalg.norm(rest_of) < 1e-6 * np.linalg.norm(motion.force) * loaded.length
    assert np.linalg.norm(motion.force) > 0.0
    motion.release()
    assert not motion.force.any()
    free = lissom.Simulation(FINGER, dt=1e-3, q0=motion.q, v0=motion.v, t0=motion.t)
    for _ in range(20):
        motion.advance()
        free.step(duration=motion.chunk)
    np.testing.assert_allclose(motion.q, free.q, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("dt", [1e-3, 5e-3, 2e-2])
@pytest.mark.parametrize("strength", [0.5, STRONGEST])
def test_pulls_are_stable_at_all_steps(dt, strength):
    motion = Motion(lissom.Simulation(FINGER, dt=dt))
    motion.strength = strength
    motion.pull(0, motion.place(0) + np.array([-0.1, 0.15, 0.1]))
    while motion.t < 4.0:
        assert motion.advance()
    assert motion.release_reason == ""
    assert np.abs(motion.v).max() < 0.05


def test_each_tip_can_be_pulled():
    links = [
        lissom.Link("trunk", rod=[SOFT]),
        lissom.Link("left", rod=[SOFT], parent="trunk", orientation=(0.96, 0.0, 0.28, 0.0)),
        lissom.Link("right", rod=[SOFT], parent="trunk", orientation=(0.96, 0.0, -0.28, 0.0)),
    ]
    motion = Motion(lissom.Simulation(lissom.Robot(links, gravity=(0, 0, 0)), dt=2e-3))
    assert [tip.name for tip in motion.tips] == ["left", "right"]
    starts = [motion.place(i) for i in range(2)]
    motion.pull(1, starts[1] + np.array([0.0, 0.1, 0.0]))
    for _ in range(300):
        assert motion.advance()
    moved = [float((motion.place(i) - starts[i])[1]) for i in range(2)]
    assert moved[1] > 0.05
    motion.pull(0, starts[0])
    assert motion.pulled[0] == 0
    np.testing.assert_allclose(motion.pulled[1], motion.place(0))


def test_a_pull_that_the_method_cannot_follow_is_let_go(motion):
    motion.pull(0, motion.place(0))
    motion.strength = 1e12
    motion.pull(0, np.array([1e3, 1e3, 1e3]))
    while not motion.release_reason and motion.t < 1.0:
        motion.advance()
    assert "did not converge" in motion.release_reason or motion.release_reason
    assert motion.pulled is None
    assert np.isfinite(motion.q).all()


def test_names_of_pulls_do_not_meet_inputs():
    load = lissom.Load(force=lissom.Input("pull of tip", (0.0, 0.0, 0.0)))
    motion = Motion(lissom.Simulation(lissom.Rod([SOFT], loads=[load]), dt=1e-3))
    motion.pull(0, motion.place(0) + 0.1)
    assert motion.advance()
    assert motion.u.tolist() == [0.0, 0.0, 0.0]


def test_how_long_inputs_are_held():
    for dt, free, pulled in [(1e-3, 17e-3, 2e-3), (4e-3, 16e-3, 4e-3), (0.1, 0.1, 0.1)]:
        motion = Motion(lissom.Simulation(FINGER, dt=dt))
        assert (motion.chunk, motion.step_size) == (pytest.approx(free), dt)
        motion.pull(0, motion.place(0))
        assert motion.chunk == pytest.approx(pulled)
    motion = Motion(lissom.Simulation(FINGER, dt=1e-3, method="radau"))
    assert motion.chunk == motion.step_size == HELD
    motion.pull(0, motion.place(0))
    assert motion.chunk == HELD_WHILE_PULLED


def test_a_motion_that_fails_says_so_and_can_be_reset(clock):
    def breaks(t):
        if t > 0.2:
            raise RuntimeError("the valve *stuck*")
        return (0.0, 0.0, 0.01)

    motion = Motion(lissom.Simulation(lissom.Rod([SOFT], loads=[lissom.Load(force=breaks)]), dt=1e-3))
    playback = Playback(motion, clock=clock)
    playback.frame()
    for _ in range(20):
        clock.now += 1 / 30
        playback.frame()
    assert motion.trouble == "RuntimeError: the valve *stuck*"
    assert playback.is_paused
    assert motion.t < 0.21
    playback.step()
    assert motion.t < 0.21
    playback.reset()
    assert (motion.t, motion.trouble, playback.is_paused) == (0.0, "", False)


def test_a_status_of_failure_is_the_trouble(clock):
    # Newton's method cannot follow a force from zero to meganewtons in a step.
    table = ([0.0, 0.1, 0.1001, 1.0], [(0, 0, 0), (0, 0, 0), (0, 0, 1e9), (0, 0, 1e9)])
    motion = Motion(lissom.Simulation(lissom.Rod([SOFT], loads=[lissom.Load(force=table)]), dt=5e-3))
    playback = Playback(motion, clock=clock)
    playback.frame()
    clock.now += 0.5
    playback.frame()
    assert re.search(r"Newton|step|resolve", motion.trouble)
    assert playback.is_paused
    assert readout(playback).count("paused") == 1


def test_the_readout_has_time_energy_and_speed(motion, clock):
    playback = Playback(motion, clock=clock)
    playback.frame()
    clock.now += 0.5
    playback.frame()
    said = readout(playback)
    assert f"| time | {motion.t:.3f} s |" in said
    assert f"| energy | {motion.energy.total:.4g} J |" in said
    assert re.search(r"real-time factor \| (1\.0|0\.99)", said)


# Sliders.


def test_sliders_reach_as_far_as_the_tip_bends(motion):
    found = {each.name: each for each in sliders(motion)}
    assert list(found) == ["push.x", "push.y", "push.z", "upper"]
    assert found["upper"].low == 0.0, "tendons do not push"
    assert found["push.y"].low == -found["push.y"].high
    # Linear theory of a cantilever with a force at its tip.
    second_moment = np.pi * 0.01**4 / 4
    exact = 3 * 1e6 * second_moment * (0.5 * 0.3) / 0.3**3
    assert exact < found["push.y"].high < 2.6 * exact
    assert found["upper"].start == 0.5


def test_sliders_by_ranges(motion):
    found = {each.name: each for each in sliders(motion, {"upper": (1.0, 4), "push.x": [-1, 2]})}
    # Values that are set can be kept.
    assert (found["upper"].low, found["upper"].high) == (0.5, 4.0)
    assert (found["push.x"].low, found["push.x"].high) == (-1.0, 2.0)


@pytest.mark.parametrize(
    ("ranges", "error", "message"),
    [
        ({"lower": (0, 1)}, ValueError, "no input 'lower'; its inputs: push.x, push.y, push.z, upper"),
        ({"upper": 3.0}, ValueError, "is not a pair of numbers"),
        ({"upper": (1.0, 1.0)}, ValueError, "its second number above its first"),
        ({"upper": (0.0, np.inf)}, ValueError, "finite"),
        ([("upper", (0, 1))], TypeError, "a list is no mapping"),
    ],
)
def test_ranges_that_make_no_sense(ranges, error, message, motion):
    with pytest.raises(error, match=re.escape(message)):
        sliders(motion, ranges)


def test_a_free_body_has_sliders_too():
    body = lissom.Link("body", body=lissom.Body(1.0, inertia=(1e-3, 1e-3, 1e-3)), joint=lissom.Free())
    robot = lissom.Robot([body], loads=[lissom.Load(force=lissom.Input("push", (0.0, 0.0, 0.0)))])
    found = sliders(Motion(lissom.Simulation(robot, dt=1e-3)))
    assert all(0.0 < each.high < 1e3 for each in found)


# What is drawn.


def volume(vertices, triangles):
    """Volume within a closed surface, by the divergence theorem; negative if it is inverted."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    return float(np.einsum("ti,ti->", a, np.cross(b, c)) / 6.0)


@pytest.mark.parametrize(
    ("section", "exact"),
    [
        (lissom.Section.ellipse(0.02, 0.01), np.pi * 0.02 * 0.01),
        (lissom.Section.rectangle(0.03, 0.01), 3e-4),
        (lissom.Section.hollow_circle(0.02, 0.015), np.pi * (0.02**2 - 0.015**2)),
    ],
)
def test_skins_of_rods_have_the_volume_of_their_sections(section, exact):
    segment = lissom.Segment(
        0.3, young_modulus=1e6, poisson_ratio=0.4, density=1e3, modes={"bend_y": 1}, section=section
    )
    rod = lissom.Rod([segment])
    shape = Shape(view(rod), np.zeros(1), np.zeros(1), 0.0, np.zeros(0))
    (tube,) = [
        thing
        for thing in shape.things(np.array([1.0]), np.zeros(1), 0.0, np.zeros(0))
        if isinstance(thing, Tube)
    ]
    skin = meshes.TubeSkin(tube)
    turns = rod.pose(np.array([1.0]), tube.stations)[:, :3, :3]
    parts = zip(skin.vertices(tube.centres[0], turns), skin.triangles, strict=True)
    # A circle of 24 corners has a one percent smaller area.
    assert sum(volume(*part) for part in parts) == pytest.approx(0.3 * exact, rel=0.015)
    assert len(skin.bands) == meshes.BANDS


def test_skins_of_strands_balls_and_boxes():
    points = np.array([[[0, 0, 0], [0, 0, 1], [0, 0, 2], [np.nan] * 3, [2, 0, 0], [3, 0, 0]]], float)
    vertices, triangles = meshes.strand(Strand("s", "tendons", points, np.array([0.01])))
    assert volume(vertices, triangles) == pytest.approx(3 * np.pi * 1e-4, rel=0.1)
    assert len(meshes.strand(Strand("s", "tendons", points * np.nan, np.array([0.01])))[0]) == 0
    assert volume(*meshes.BOX) == pytest.approx(8.0)
    assert volume(*meshes.BALL) == pytest.approx(4 / 3 * np.pi, rel=0.05)
    two = meshes.balls(np.array([[0, 0, 0], [3, 0, 0]], float), 0.5)
    assert volume(*two) == pytest.approx(2 * volume(*meshes.BALL) / 8)


def test_everything_of_a_robot_is_drawn():
    tendon = lissom.Tendon("pull", [lissom.Along("arm", (0.0, 0.008))], tension=2.0)
    robot = lissom.Robot(
        [
            lissom.Link("arm", rod=[SOFT], joint=lissom.Revolute((0, 1, 0))),
            lissom.Link("tool", parent="arm", body=lissom.Body(0.1, inertia=(1e-4, 1e-4, 1e-4))),
        ],
        loads=[lissom.Load(link="arm", at=0.1, force=(0, 0, 0.1))],
        supports=[lissom.Support(link="arm", stiffness=3.0)],
        actuators=[tendon],
        contacts=[lissom.Contact("arm", lissom.HalfSpace(normal=(0, 0, 1), point=(0, 0, -1)))],
        fluid=lissom.Fluid(1.0, velocity=(0.1, 0, 0), viscous_drag=(0.1, 0.1)),
    )
    n = robot.n
    shape = Shape(view(robot), np.zeros(n), np.zeros(n), 0.0, np.zeros(0))
    layers = {thing.layer for thing in shape.things(np.zeros(n), np.zeros(n), 0.0, np.zeros(0))}
    assert layers >= {"rods", "bodies", "joints", "tendons", "forces", "supports", "obstacles"}
    assert {thing.layer for thing in shape.stage.around} == {"gravity", "current"}
    assert (shape.stage.low < shape.stage.high).all()


def test_scales_are_those_of_all_shapes_before():
    """When a force halves, it is drawn half as long; a released tendon is drawn thin."""
    shape = Shape(view(FINGER), np.zeros(6), np.zeros(6), 0.0, np.array([0, 0, 2.0, 4.0]))

    def drawn(push, pull):
        things = shape.things(np.zeros(6), np.zeros(6), 0.0, np.array([0, 0, push, pull]))
        (arrow,) = [thing for thing in things if isinstance(thing, Arrows)]
        (tendon,) = [thing for thing in things if thing.layer == "tendons"]
        return np.linalg.norm(arrow.vectors[0, 0]), tendon.radius[0]

    long, thick = drawn(2.0, 4.0)
    short, thin = drawn(1.0, 0.0)
    assert short == pytest.approx(0.5 * long)
    assert thin < 0.5 * thick
    assert drawn(2.0, 4.0) == (pytest.approx(long), pytest.approx(thick))


def drawn_tube(shape, q, v):
    things = shape.things(np.asarray(q), np.asarray(v), 0.0, np.zeros(4))
    (tube,) = [thing for thing in things if isinstance(thing, Tube)]
    return tube


def test_rods_are_coloured_by_what_somebody_picks():
    shape = Shape(view(FINGER), np.zeros(6), np.zeros(6), 0.0, np.zeros(4))
    assert shape.colours == [quantities.CURVATURE, quantities.STRESS, quantities.SPEED]
    bent, rest = np.array([2.0, 1.0, 0, 0, 0, 0]), np.zeros(6)
    assert drawn_tube(shape, bent, rest).quantities == {}
    shape.colour = quantities.CURVATURE
    # The curvature is 2 - 1 at the base and 2 + 1 at the tip.
    shade = drawn_tube(shape, bent, rest).quantities[SHADE][0]
    np.testing.assert_allclose(shade[[0, -1]], [1 / 3, 1.0], rtol=1e-12)
    assert shape.largest == pytest.approx(3.0)
    # The scale remains that of the largest one.
    shade = drawn_tube(shape, 0.5 * bent, rest).quantities[SHADE][0]
    np.testing.assert_allclose(shade[[0, -1]], [1 / 6, 0.5], rtol=1e-12)
    shape.colour = quantities.SPEED
    assert not drawn_tube(shape, bent, rest).quantities[SHADE].any()
    assert drawn_tube(shape, bent, bent).quantities[SHADE][0, -1] == 1.0


def test_a_trace_is_where_the_tip_was(motion):
    trace, places = Trace(motion.view), []
    for _ in range(5):
        trace.follow(motion.q, motion.t)
        places.append(motion.place(0))
        trace.follow(motion.q, motion.t)
        motion.advance(0.02)
    points = trace.line.points[0]
    assert np.isnan(points[-1]).all()
    np.testing.assert_allclose(points[-6:-1], places, atol=1e-12)
    np.testing.assert_allclose(points[: PLACES - 5], np.tile(places[0], (PLACES - 5, 1)), atol=1e-12)
    for k in range(PLACES):
        trace.follow(motion.q, motion.t + k)
    assert trace.line.points.shape == (1, PLACES + 1, 3)
    np.testing.assert_allclose(trace.line.points[0, 0], motion.place(0), atol=1e-12)
    # At the start it is reset.
    motion.reset()
    trace.follow(motion.q, motion.t)
    np.testing.assert_allclose(trace.line.points[0, :-1], np.tile(motion.place(0), (PLACES, 1)), atol=1e-12)


def test_the_mass_of_a_pendulum_leaves_a_trace():
    pendulum = lissom.SpringPendulum(length=1.0)
    trace = Trace(view(pendulum))
    trace.follow(np.array([0.0, 0.5]), 0.0)
    np.testing.assert_allclose(trace.line.points[0, 0], [1.5, 0.0, 0.0])


def test_a_pendulum_is_drawn_and_has_no_handle():
    motion = Motion(lissom.Simulation(lissom.SpringPendulum(), dt=1e-2, q0=[-0.7, 0.5]))
    assert motion.tips == ()
    shape = Shape(motion.view, motion.q, motion.v, motion.t, motion.u)
    kinds = {type(thing) for thing in shape.things(motion.q, motion.v, motion.t, motion.u)}
    assert {Strand, Solid} <= kinds
    assert motion.advance()


# The page.


@pytest.fixture
def shown():
    with live.open_view(lissom.Simulation(FINGER, dt=1e-3), port=0) as page:
        page.start()
        yield page


def test_the_page_is_served_and_waits_for_somebody(shown):
    from urllib.request import urlopen

    assert re.fullmatch(r"http://localhost:\d+", shown.url)
    with urlopen(shown.url, timeout=20) as answer:
        assert b"<html" in answer.read().lower()
    assert shown.t == 0.0
    shown.stop()
    assert not shown.is_open
    shown.stop()


def answered(url, **headers):
    """Status of the answer to a request with these headers, and whether it opened a WebSocket."""
    connection = http.client.HTTPConnection("127.0.0.1", int(url.rpartition(":")[2]), timeout=20)
    try:
        connection.request("GET", "/", headers=headers)
        return connection.getresponse().status
    finally:
        connection.close()


SOCKET = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
}


@pytest.mark.parametrize("headers", [{}, SOCKET], ids=["page", "socket"])
def test_only_its_own_page_may_use_a_view(headers, shown):
    own = shown.url.removeprefix("http://")
    good = 101 if headers else 200
    assert answered(shown.url, **headers, Host=own) == good
    assert answered(shown.url, **headers, Host=own, Origin=f"http://{own}") == good
    # Names have no case.
    assert answered(shown.url, **headers, Host=own.upper(), Origin=f"http://{own}") == good
    # Forwarded to another port of this machine.
    assert answered(shown.url, **headers, Host="localhost:9000", Origin="http://localhost:9000") == good
    for host, origin in [
        (own, "http://evil.example"),
        (own, "http://localhost:3000"),
        (own, "null"),
        (own, ""),
        (own, "http://["),
        (own, f"ftp://{own}"),
        (own, f"http://{own}@evil.example"),
        (f"evil.example@{own}", f"http://evil.example@{own}"),
        ("0.0.0.0", "http://0.0.0.0"),
        ("evil.example", "http://evil.example"),
        ("localhost.evil.example", "http://localhost.evil.example"),
        ("[", "http://["),
        (f"{own}.evil.example", f"http://{own}.evil.example"),
    ]:
        assert answered(shown.url, **headers, Host=host, Origin=origin) == 403, (host, origin)
    assert answered(shown.url, **headers, Host="evil.example") == 403


def test_named_hosts_may_use_a_view():
    simulation = lissom.Simulation(FINGER, dt=1e-3)
    with simulation.view(port=0, paused=True, block=False, allow_hosts=["Hub.example"]) as page:
        assert answered(page.url, Host="hub.example", Origin="https://hub.example") == 200
        assert answered(page.url, Host="localhost", Origin="https://hub.example:8443") == 200
        assert answered(page.url, Host="localhost", Origin="https://other.example") == 403
    with pytest.raises(TypeError, match="allow_hosts"):
        simulation.view(port=0, block=False, allow_hosts="hub.example")


def test_names_of_hosts_are_names_alone():
    assert gate.names_of(["Hub.Example", "[FE80::1]", "10.0.0.2", "my_pc"]) == {
        *("hub.example", "fe80::1", "10.0.0.2", "my_pc")
    }
    for wrong in ("", "*", "hub:80", "http://hub", "hub/x", "a b", "[", "hub; default-src *", "höst"):
        with pytest.raises(ValueError, match="allow_hosts"):
            gate.names_of([wrong])


def test_other_pages_cannot_frame_a_view(shown):
    connection = http.client.HTTPConnection("127.0.0.1", int(shown.url.rpartition(":")[2]), timeout=20)
    with contextlib.closing(connection):
        connection.request("GET", "/", headers={"Host": "localhost"})
        policy = connection.getresponse().getheader("Content-Security-Policy")
    assert policy == "frame-ancestors 127.0.0.1:* localhost:*"


def test_a_page_cannot_open_a_tunnel(shown):
    from viser import _messages

    server = shown._server
    assert server.request_share_url() is None
    for handler in server._websock_server._incoming_handlers[_messages.ShareUrlRequest]:
        handler(0, _messages.ShareUrlRequest())
    time.sleep(0.2)
    assert server._share_tunnel is None


def test_bad_messages_do_not_end_a_view(shown, capfd):
    """Bytes that are no messages, and values that sliders do not have."""
    import viser
    from websockets.sync.client import connect

    def talk(*messages):
        address = shown.url.replace("http", "ws", 1)
        with connect(address, subprotocols=[f"viser-v{viser.__version__}"]) as page:
            for message in messages:
                page.send(message)
            time.sleep(0.2)

    for message in (b"", b"\xc1", b"\x00" * 100, "text", b"\x81\xa4type\xa4none"):
        with contextlib.suppress(Exception):
            talk(message)
    controls, _, motion = controls_of(shown)
    before = motion.u.copy()
    for value in (np.nan, np.inf, 1e300, "x", None, [1]):
        controls._sliders[3]._impl.value = value
        for callback in list(controls._sliders[3]._impl.update_cb):
            callback(None)
        controls.do()
    np.testing.assert_array_equal(motion.u, before)
    controls._todo.put(lambda: controls._drag("start", np.full(3, np.nan)))
    controls.do()
    assert motion.pulled is None
    assert shown.is_open
    assert answered(shown.url, Host="localhost") == 200
    assert "Traceback" not in "".join(capfd.readouterr())


CAMERA = {"wxyz": [1, 0, 0, 0], "position": [1, 1, 1], "fov": 1.0, "near": 0.1, "far": 10.0} | {
    "image_height": 400,
    "image_width": 400,
    "look_at": [0, 0, 0],
    "up_direction": [0, 0, 1],
}
MOVED = {"type": "TransformControlsUpdateMessage", "name": "/handle", "wxyz": [1, 0, 0, 0]}


@pytest.mark.parametrize(
    "message",
    [
        # Attributes of viser's own objects.
        {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"props": 5}},
        {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": True, "removed": True}},
        {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"update_cb": [1]}},
        {"type": "GuiUpdateMessage", "uuid": "x", "updates": {}},
        {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": np.nan}},
        {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": [1, 2]}},
        {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": "x" * 5000}},
        MOVED | {"position": [1, 2]},
        MOVED | {"position": [np.inf, 0, 0]},
        MOVED | {"position": ["a", "b", "c"]},
        {"type": "ViewerCameraMessage"} | CAMERA | {"wxyz": ["a", "b"]},
        {"type": "ViewerCameraMessage"} | CAMERA | {"fov": 1e300},
        {"type": "ShareUrlRequest"},
        {"type": "FileTransferStartUpload", "part_count": 10**9},
        {"type": ["GuiUpdateMessage"]},
        [1],
    ],
    ids=lambda message: str(message)[:80],
)
def test_only_messages_of_the_controls_are_heard(message):
    import msgspec

    assert not messages.is_message(msgspec.msgpack.encode(message))


def test_messages_of_the_controls_are_heard():
    import msgspec

    for message in (
        *({"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": value}} for value in (True, 1, 0.5)),
        {"type": "TransformControlsDragStartMessage", "name": "/handle", "owner": ""},
        MOVED | {"position": [1, 2, 3], "owner": ""},
        {"type": "ViewerCameraMessage"} | CAMERA,
    ):
        assert messages.is_message(msgspec.msgpack.encode(message))
    for other in ("text", b"", b"\xc1", b"\x91" * 60_000 + b"\x01"):
        assert not messages.is_message(other)


def test_attributes_of_controls_cannot_be_set(shown, capfd):
    """The main loop reads the label of the button; it ended with an AttributeError."""
    import msgspec
    import viser
    from websockets.sync.client import connect

    controls, *_ = controls_of(shown)
    uuid = controls._run._impl.uuid
    address = shown.url.replace("http", "ws", 1)
    with connect(address, subprotocols=[f"viser-v{viser.__version__}"], max_size=None) as page:
        page.send(msgspec.msgpack.encode({"type": "ViewerCameraMessage"} | CAMERA))
        for updates in ({"props": 5}, {"removed": True}, {"update_cb": [1]}, {"value": True}):
            page.send(msgspec.msgpack.encode({"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates}))
        page.send(msgspec.msgpack.encode(MOVED | {"position": [1, 2]}))
        time.sleep(0.5)
    assert shown.is_open
    assert not controls._run._impl.removed
    assert answered(shown.url, Host="localhost") == 200
    assert capfd.readouterr().err == ""


def test_many_requests_leave_time_for_frames():
    done = []

    def slow():
        done.append(time.sleep(0.02))

    with live.open_view(lissom.Simulation(FINGER, dt=1e-3), port=0) as page:
        for _ in range(100):
            page._controls._todo.put(slow)
        page._controls.do()
    assert 1 <= len(done) <= PATIENCE / 0.02 + 1


def controls_of(page):
    return page._controls, page._playback, page._motion


def test_what_controls_do():
    """Without a browser: the loop performs the requests of callbacks, not the callbacks."""
    with LiveView(
        lissom.Simulation(FINGER, dt=1e-3), port=0, speed=1.0, paused=True, ranges=None, title="finger"
    ) as page:
        controls, playback, motion = controls_of(page)
        controls._later(controls._toggle)(None)
        assert playback.is_paused
        controls.do()
        assert not playback.is_paused
        controls._sliders[3].value = 2.0
        controls._put_back(sliders(motion))
        assert controls._sliders[3].value == 0.5
        assert motion.u[3] == 0.5
        controls._drag("update", np.ones(3))
        assert motion.pulled is None, "what was let go is not taken up by a late word"
        controls._drag("start", np.ones(3))
        assert motion.pulled is not None
        ends = controls.follow()
        np.testing.assert_array_equal(ends[0], motion.place(0))
        page._draw()
        controls._reset()
        assert motion.pulled is None
        assert controls.follow() is None


@pytest.mark.parametrize("dark", [False, True])
def test_a_page_is_dark_or_light_and_has_a_switch_for_it(dark, monkeypatch):
    shown = []
    monkeypatch.setattr(
        viser.GuiApi, "configure_theme", lambda self, *, dark_mode, **more: shown.append(dark_mode)
    )
    simulation = lissom.Simulation(FINGER, dt=1e-3)
    with simulation.view(port=0, paused=True, block=False, dark=dark) as page:
        assert shown == [dark]
        page._controls._is_dark.value = not dark
        until = time.monotonic() + 10.0
        while len(shown) < 2 and time.monotonic() < until:
            time.sleep(0.01)
    assert shown == [dark, not dark]


def test_the_page_draws_traces_and_colours():
    simulation = lissom.Simulation(FINGER, dt=1e-3)
    with LiveView(simulation, port=0, speed=1.0, paused=True, ranges=None, title="finger") as page:
        controls, _, motion = controls_of(page)
        nodes = page._canvas._nodes
        before = {name: node.color for name, node in nodes.items() if name.startswith("/rods")}
        assert "/paths/trace" not in nodes
        controls.is_traced = True
        page._shape.colour = quantities.SPEED
        for _ in range(3):
            motion.advance(0.05)
            page._draw()
        trace = nodes["/paths/trace"]
        assert trace.visible
        np.testing.assert_allclose(trace.points[-1, 1], motion.place(0), atol=1e-6)
        coloured = {name: nodes[name].color for name in before}
        # The base rests, as before; the tip is fastest.
        assert coloured != before
        assert len(set(coloured.values())) > 3
        controls.update()
        assert controls._scale.content == f"blue: 0, yellow: {page._shape.largest:.3g}"
        controls.is_traced, page._shape.colour = False, None
        page._draw()
        assert not trace.visible
        assert {name: nodes[name].color for name in before} == before


def test_the_page_says_why_a_motion_ended():
    def breaks(t):
        raise RuntimeError("the valve *stuck*")

    rod = lissom.Rod([SOFT], loads=[lissom.Load(force=lambda t: (0, 0, 0) if t <= 0.0 else breaks(t))])
    with LiveView(
        lissom.Simulation(rod, dt=1e-3), port=0, speed=1.0, paused=False, ranges=None, title="rod"
    ) as page:
        controls, playback, _ = controls_of(page)
        playback.step()
        controls.update()
        assert controls._trouble.visible
        assert "The motion has ended" in controls._trouble.content
        assert r"the valve \*stuck\*" in controls._trouble.content
        assert controls._run.disabled
        controls._reset()
        controls.update()
        assert not controls._trouble.visible


def test_view_of_a_simulation_in_a_thread():
    simulation = lissom.Simulation(FINGER, dt=1e-3)
    with simulation.view(port=0, paused=True, block=False, ranges={"upper": (0, 2)}) as page:
        assert page.is_open
        taken = int(page.url.rpartition(":")[2])
        with simulation.view(port=taken, block=False) as other:
            assert other.url != page.url
    assert not page.is_open
    assert simulation.t == 0.0
    assert not any(thread.name == "lissom view" for thread in threading.enumerate())


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"port": 65536}, ValueError, "port: 65536 is not between 0 and 65535"),
        ({"port": 1.5}, TypeError, "port: expected a whole number, got float"),
        ({"speed": 0.0}, ValueError, "speed: 0 is not a finite number above zero"),
        ({"speed": np.nan}, ValueError, "speed: nan"),
        ({"speed": "fast"}, TypeError, "speed: expected a real number, got str"),
        ({"paused": 1}, TypeError, "paused: expected True or False, got int"),
        ({"dark": 1}, TypeError, "dark: expected True or False, got int"),
        ({"block": None}, TypeError, "block: a NoneType is not True or False"),
        ({"ranges": {"x": (0, 1)}}, ValueError, "no input 'x'"),
    ],
)
def test_options_that_make_no_sense(options, error, message):
    with pytest.raises(error, match=re.escape(message)):
        lissom.Simulation(FINGER, dt=1e-3).view(**{"port": 0, "block": False} | options)


def test_without_viser_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(ImportError, match=re.escape("pip install 'lissom[view]'")):
        lissom.Simulation(FINGER, dt=1e-3).view(block=False)


# Scenes and the command.


@pytest.mark.parametrize(
    ("method", "expected"),
    [
        ("newmark", "newmark"),
        ("radau", "radau"),
        ("auto", "radau"),
        ("generalised_alpha", "generalised_alpha"),
    ],
)
def test_a_scene_begins_as_its_run(method, expected):
    scene = lissom.Scene.loads(SCENE + f'method = "{method}"\n')
    simulation = live.simulation_of(scene)
    assert f"'{expected}'" in repr(simulation.__reduce__()[1][1])
    assert simulation.step(duration=0.1) == "finished"
    motion = scene.run()
    at = np.searchsorted(motion.t, 0.1 - 1e-9)
    assert simulation.t == pytest.approx(motion.t[at], abs=1e-9)
    tolerance = {"newmark": 1e-12, "generalised_alpha": 1e-12}.get(method, 1e-3)
    np.testing.assert_allclose(simulation.q, motion.q[at], atol=tolerance * np.abs(motion.q).max())


def command(*arguments, cwd, without=()):
    hide = f"import sys; sys.modules.update(dict.fromkeys({list(without)!r}))"
    program = f"{hide}\nfrom lissom.__main__ import main; main()"
    return [sys.executable, "-c", program, "view", *map(str, arguments)], {"cwd": cwd, "text": True}


def test_the_command_serves_until_ctrl_c(tmp_path):
    (tmp_path / "finger.toml").write_text(SCENE)
    line, options = command("finger.toml", "--port", "0", cwd=tmp_path)
    with subprocess.Popen(
        line,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
        **options,
    ) as process:
        try:
            said = process.stdout.readline()
            assert re.fullmatch(r"finger: open http://localhost:\d+ in a browser; Ctrl-C ends\.\n", said)
            process.send_signal(signal.SIGINT)
            rest, complaints = process.communicate(timeout=30)
        finally:
            process.kill()
    assert process.returncode == 130
    assert (rest, complaints) == ("", "")


@pytest.mark.parametrize(
    ("arguments", "text", "without", "code", "message"),
    [
        (["--port", "70000"], SCENE, (), 2, "70000 is not in the range"),
        (["--speed", "0"], SCENE, (), 2, "0.0 is not in the range"),
        ([], SCENE.replace("0.01", "-0.01"), (), 2, "scene.toml:"),
        ([], SCENE, ("viser",), 1, "pip install 'lissom[view]'"),
    ],
)
def test_what_the_command_refuses(arguments, text, without, code, message, tmp_path):
    (tmp_path / "scene.toml").write_text(text)
    line, options = command("scene.toml", *arguments, cwd=tmp_path, without=without)
    done = subprocess.run(line, capture_output=True, timeout=60, check=False, **options)
    assert done.returncode == code, done.stderr
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_the_command_has_help(tmp_path):
    line, options = command("--help", cwd=tmp_path)
    done = subprocess.run(line, capture_output=True, timeout=60, check=True, **options)
    assert "Usage: lissom view [OPTIONS] SCENE" in done.stdout
    assert "[default: 8080" in done.stdout


@pytest.mark.parametrize("encoding", ["gzip", "identity"])
def test_the_page_has_a_style_for_phones(encoding):
    with lissom.Simulation(FINGER, dt=2e-3).view(port=0, block=False) as view:
        connection = http.client.HTTPConnection("localhost", int(view.url.rsplit(":", 1)[1]), timeout=20)
        connection.request("GET", "/", headers={"Accept-Encoding": encoding})
        with contextlib.closing(connection):
            response = connection.getresponse()
            page = response.read()
        assert int(response.getheader("Content-Length")) == len(page)
        if encoding == "gzip":
            page = gzip.decompress(page)
        assert page.count(b"@media (max-width: 600px)") == 1
        assert page.index(b"@media (max-width: 600px)") < page.index(b"</head>")


def test_pages_that_are_high_see_the_whole_model_across():
    with lissom.Simulation(FINGER, dt=2e-3).view(port=0, block=False) as view:
        first = view._server.initial_camera
        away = np.asarray(first.position) - np.asarray(first.look_at)
        for aspect, further in ((0.5, 2.0), (1.5, 1.0)):
            camera = SimpleNamespace(aspect=aspect, position=first.position, look_at=first.look_at)
            controls._step_back(camera, first)
            np.testing.assert_allclose(camera.position - np.asarray(camera.look_at), further * away)
