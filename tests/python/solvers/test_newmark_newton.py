"""Newton's method in implicit steps: small accelerations and rounding do not decide what ends it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

ALPHA = {"method": "generalised_alpha"}


def rope(name: str, start, end, *, radius: float = 5e-3, segments: int = 3, modes: int = 3):
    """A rope of one metre between two pins, about whose line it may spin."""
    start, end = np.array(start), np.array(end)
    along = end - start
    half = 0.5 * np.arctan2(along[1], along[0])
    segment = lissom.Segment(
        1.0 / segments,
        radius,
        1e6,
        poisson_ratio=0.5,
        density=1000,
        modes={"torsion": 1, "bend_y": modes, "bend_z": modes, "stretch": 1},
        retardation_time=0.02,
    )
    link = lissom.Link(
        name,
        joint=lissom.Spherical(),
        rod=[segment] * segments,
        position=start,
        orientation=(np.cos(half), 0, 0, np.sin(half)),
    )
    return link, lissom.Loop(name, (None, None, end), lissom.Spherical(), name=f"end of {name}")


def hanging(**options) -> lissom.Robot:
    link, loop = rope("rope", (-0.4, 0, 0), (0.4, 0, 0), **options)
    return lissom.Robot([link], loops=[loop])


def largest_gap(robot: lissom.Robot, q, ends) -> float:
    return max(np.linalg.norm(robot.pose(q, link=name)[:3, 3] - end) for name, end in ends.items())


@pytest.mark.parametrize("reuse", [True, False])
@pytest.mark.parametrize(
    "shape", [{"radius": 5e-3}, {"radius": 3e-3}, {"segments": 8}], ids=["thick", "thin", "long"]
)
@pytest.mark.parametrize("dt", [2.5e-3, 5e-3, 1e-2])
def test_a_pinned_rope_at_rest_stays_there(dt, shape, reuse):
    """Its spin has hardly any inertia, so that rounding moves it by thousands of spacings."""
    robot = hanging(**shape)
    rest = lissom.statics(robot)
    assert rest.success, rest.message
    run = lissom.simulate(robot, 60 * dt, q0=rest.q, dt=dt, reuse_jacobian=reuse, **ALPHA)
    assert run.success, run.message
    assert run.stats.newton_iterations < 6 * run.stats.steps
    middle = [robot.pose(q, 0.5, link="rope")[:3, 3] for q in (rest.q, run.q[-1])]
    assert_allclose(middle[1], middle[0], rtol=0, atol=1e-7)
    assert largest_gap(robot, run.q[-1], {"rope": (0.4, 0, 0)}) < 1e-12


def crossing() -> tuple[lissom.Robot, np.ndarray]:
    """A rope between pins that swings down onto another one, which hangs across it a little higher."""
    upper = rope("upper", (-0.4, 0, 0), (0.4, 0, 0))
    lower = rope("lower", (0, -0.4, 0.03), (0, 0.4, 0.03))
    start = []
    for (link, loop), gravity in ((upper, (0, 9.81, 0)), (lower, (0, 0, -9.81))):
        alone = lissom.Robot([link], loops=[loop], gravity=gravity)
        rest = lissom.statics(alone, np.zeros(alone.n))
        assert rest.success, rest.message
        start.append(rest.q)
    links, loops = zip(upper, lower, strict=True)
    robot = lissom.Robot(links, loops=loops, contacts=[lissom.Contact("upper", "lower")])
    return robot, np.concatenate(start)


def test_ropes_that_press_against_each_other_take_few_iterations():
    """Guesses of zero, and increments refused for accelerations near zero, took hundreds of them."""
    robot, start = crossing()
    iterations = []
    # Rounding of the start decides whether one more step is made in parts, which takes a third more.
    for rounding in range(5):
        q0 = start * (1 + 1e-15 * rounding)
        run = lissom.simulate(robot, 0.25, q0=q0, dt=5e-3, **ALPHA)
        assert run.success, run.message
        touching = [len(robot.touches(q, v)) > 0 for q, v in zip(run.q, run.v, strict=True)]
        assert sum(touching) > 10
        iterations.append(run.stats.newton_iterations / run.stats.steps)
    assert np.mean(iterations) <= 12
    fine = lissom.simulate(robot, 0.25, q0=start, dt=1e-3, t_eval=[0.25], **ALPHA)
    ends = [robot.pose(q, 0.5, link="upper")[:3, 3] for q in (run.q[-1], fine.q[-1])]
    assert_allclose(ends[0], ends[1], rtol=0, atol=5e-3)


@pytest.mark.parametrize("dt", [2.5e-4, 1e-4])
def test_loops_stay_closed_in_short_steps(dt):
    robot, start = crossing()
    run = lissom.simulate(robot, 100 * dt, q0=start, dt=dt, **ALPHA)
    assert run.success, run.message
    assert largest_gap(robot, run.q[-1], {"upper": (0.4, 0, 0), "lower": (0, 0.4, 0.03)}) < 1e-12


def clamped(modes: int, segments: int, force: float) -> lissom.Robot:
    """A straight rod without torsion modes between two clamps, knocked in two planes at two places."""
    segment = lissom.Segment(
        1.0 / segments,
        1e-2,
        1e6,
        poisson_ratio=0.5,
        density=1000,
        modes={"bend_y": modes, "bend_z": modes, "stretch": 1},
    )
    loads = [
        lissom.Load(force=([0, 0.005, 0.01], [np.zeros(3), direction, np.zeros(3)]), at=at, link="rod")
        for direction, at in ((np.array([0, force, 0]), 0.3), (np.array([0, 0, force]), 0.6))
    ]
    end = lissom.Loop("rod", (None, None, (1.0, 0, 0)), lissom.Weld())
    rod = lissom.Link("rod", rod=[segment] * segments)
    return lissom.Robot([rod], loops=[end], loads=loads, gravity=(0, 0, 0))


@pytest.mark.parametrize(("modes", "segments", "force"), [(3, 1, 0.1), (2, 2, 3.0), (2, 2, 0.03)])
def test_a_knocked_rod_between_clamps_moves_alike_whatever_the_step(modes, segments, force):
    """The start is singular: what holds its end against twist hardly moves in the first steps."""
    robot = clamped(modes, segments, force)
    times = np.linspace(0.0, 0.4, 21)
    places = []
    for dt in (2.5e-3, 5e-3, 1e-2):
        run = lissom.simulate(robot, 0.4, dt=dt, t_eval=times)
        assert run.success, run.message
        assert max(np.abs(robot.loop_gaps(q)).max() for q in run.q) < 1e-9
        places.append([robot.pose(q, 0.5, link="rod")[1:3, 3] for q in run.q])
    size = np.abs(places[0]).max()
    assert_allclose(places[1], places[0], rtol=0, atol=0.02 * size)
    assert_allclose(places[2], places[0], rtol=0, atol=0.1 * size)


@pytest.mark.parametrize("method", ["newmark", "hht", "generalised_alpha"])
@pytest.mark.parametrize("force", [0.03, 0.1, 3.0])
def test_a_knocked_rod_between_clamps_moves_as_radau_says(force, method):
    """Rows of its loop that begin to hold late are closed by a blow, whose speed must not stay."""
    robot = clamped(2, 2, force)
    times = [0.0, 0.05]
    wanted = lissom.simulate(robot, 0.05, method="radau", rtol=1e-7, atol=1e-10, t_eval=times)
    place = robot.pose(wanted.q[-1], 0.5, link="rod")[1:3, 3]
    for dt in (1e-4, 1.5e-4, 2.5e-4, 3e-4, 5e-4, 7e-4, 1e-3, 1.3e-3, 2e-3, 2.5e-3, 3e-3, 5e-3):
        run = lissom.simulate(robot, 0.05, dt=dt, t_eval=times, method=method)
        assert run.success, run.message
        assert run.doubt is None
        found = robot.pose(run.q[-1], 0.5, link="rod")[1:3, 3]
        assert_allclose(found, place, rtol=0, atol=0.05 * np.linalg.norm(place))


def pendulum_beside_a_slider(push=None) -> lissom.Robot:
    """They have nothing to do with each other."""
    body = lissom.Body(1.0, centre=(1, 0, 0), inertia=(0.01, 0.01, 0.01))
    links = [lissom.Link("pendulum", joint=lissom.Revolute((0, 1, 0)), body=body)]
    loads = []
    if push:
        links.append(lissom.Link("slider", joint=lissom.Prismatic((1, 0, 0)), body=body))
        loads = [lissom.Load(force=push, link="slider")]
    return lissom.Robot(links, loads=loads)


@pytest.mark.parametrize("force", [1e-20, 1.0])
def test_what_jerks_beside_a_pendulum_does_not_end_its_iteration(force):
    """Increments of what was at rest are so large that they hid all others, and their rate is another one."""
    dt = 0.05
    exact = lissom.simulate(pendulum_beside_a_slider(), 2.0, q0=[0.3], dt=dt, rtol=1e-12, atol=0)

    def push(t):
        return (force * (1 + t) if round(t / dt) % 2 else 0.0, 0, 0)

    run = lissom.simulate(pendulum_beside_a_slider(push), 2.0, q0=[0.3, 0], dt=dt, atol=0)
    assert run.success, run.message
    assert_allclose(run.q[:, 0], exact.q[:, 0], rtol=0, atol=2e-7)


def eel(unit: float, tick: float) -> lissom.Robot:
    """A rod in a fluid that bends far within a step; units of length and time in metres and seconds."""
    segment = lissom.Segment(
        0.3 / unit,
        radius=0.01 / unit,
        young_modulus=3e5 * unit * tick**2,
        poisson_ratio=0.5,
        density=1000.0 * unit**3,
        modes={"bend_z": 4},
        retardation_time=0.02 / tick,
    )
    phases = (0.18665977, 0.03239279, -1.83122032, -2.25818362)
    stations = np.linspace(0, 0.3 / unit, 4)
    muscles = [
        lissom.ActiveStrain(
            "eel", "bend_z", (stations, np.eye(4)[i]), lissom.Harmonic(5.1 * unit, tick, phase=phases[i])
        )
        for i in range(4)
    ]
    return lissom.Robot(
        [lissom.Link("eel", joint=lissom.Planar((0, 0, 1)), rod=[segment])],
        gravity=(0, 0, 0),
        actuators=muscles,
        fluid=lissom.Fluid(1000.0 * unit**3, drag_coefficients=(1.2, 0.01)),
    )


def test_jacobians_of_another_place_do_not_shorten_increments():
    """Drag that reverses in a step made it fail: its increments were those of a Jacobian from before."""
    for dt in (0.01, 0.005):
        run = lissom.simulate(eel(1.0, 1.0), 0.3, dt=dt)
        assert run.success, run.message


@pytest.mark.parametrize("dt", [2.5e-3, 5e-3, 1e-2])
@pytest.mark.parametrize(("unit", "tick"), [(1e-3, 1.0), (1.0, 1e-3), (2.0**-10, 2.0**-10)])
def test_iterations_are_the_same_in_other_units(dt, unit, tick):
    """From rest as well, where nothing tells how large accelerations are."""
    counts = []
    for length, time in ((1.0, 1.0), (unit, tick)):
        stats = lissom.simulate(eel(length, time), 0.3 / time, dt=dt / time, atol=0.0).stats
        counts.append([stats.steps, stats.newton_iterations, stats.njev])
    assert counts[0] == counts[1]


@pytest.mark.parametrize("method", ["newmark", "generalised_alpha"])
@pytest.mark.parametrize("modulus", [1e5, 1e7])
def test_rods_that_tumble_need_no_short_steps(modulus, method):
    """Free rods that turn by 0.15 rad a step, past half a turn; thin ones, with small axial inertia."""
    modes = {"bend_y": 3, "bend_z": 3, "torsion": 1}
    segment = lissom.Segment(0.5, 0.01, modulus, modulus / 3, 1100.0, modes, retardation_time=1e-3)
    robot = lissom.Robot([lissom.Link("rod", joint=lissom.Free(), rod=[segment])], gravity=(0, 0, 0))
    for seed in range(12):
        v0 = np.zeros(robot.n)
        axis = np.random.default_rng(seed).normal(size=3)
        v0[3:6] = 15 * axis / np.linalg.norm(axis)
        motion = lissom.simulate(robot, 2.0, v0=v0, dt=0.01, method=method)
        assert motion.success, motion.message
        assert motion.stats.newton_iterations < 6 * motion.stats.steps


@pytest.mark.parametrize("chord", [0.5, 0.7])
def test_a_rope_that_cracks_between_two_hooks_goes_on(chord):
    """It falls from a wide arch; where it whips around no step of this size can be solved as a whole."""
    # A rope of 1 m and 1 N: E A and E I / L^2 are 1000 N and 1 mN.
    radius = 2e-3
    area = np.pi * radius**2
    modulus = 1e3 / area
    segment = lissom.Segment(
        0.25, radius, modulus, 0.4 * modulus, 1 / (9.81 * area), {"bend_y": 4, "bend_z": 4}
    )
    hooked = lissom.Loop(("rope",), (None, None, (chord, 0, 0.1)), lissom.Spherical())
    robot = lissom.Robot([lissom.Link("rope", joint=lissom.Spherical(), rod=[segment] * 4)], loops=[hooked])
    run = lissom.simulate(robot, 0.2, dt=2e-3)
    assert run.success, run.message
    assert max(np.abs(robot.loop_gaps(q)).max() for q in run.q) < 1e-9
    fine = lissom.simulate(robot, 0.2, dt=5e-4)
    assert fine.success, fine.message
    middle, exact = (robot.pose(result.q[-1], 0.5, link="rope")[:3, 3] for result in (run, fine))
    assert_allclose(middle, exact, rtol=0, atol=2e-3)
