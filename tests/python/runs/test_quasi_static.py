"""Motions without inertia: equilibria under what moves slowly, with friction and damping."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import brentq

import lissom

WEIGHT, STIFFNESS, SPEED = 5.0, 200.0, 0.02


def rod(**options):
    return lissom.Segment(
        0.4,
        radius=0.005,
        young_modulus=1e6,
        poisson_ratio=0.45,
        density=1000,
        modes={"bend_y": 5, "bend_z": 5},
        **options,
    )


def test_without_damping_every_step_ends_in_the_equilibrium():
    times = np.linspace(0.0, 2.0, 9)
    force = lissom.Load(force=(times, np.outer(times, (0.0, 0.02, -0.05))))
    robot = lissom.Rod([rod()], loads=[force])
    motion = lissom.simulate(robot, 2.0, dt=0.25, method="quasi_static", rtol=1e-10)
    assert motion.success
    assert not motion.a.any()
    for t, q in zip(motion.t[1:], motion.q[1:], strict=True):
        rest = lissom.statics(lissom.Rod([rod()], loads=[lissom.Load(force=(0.0, 0.02 * t, -0.05 * t))]))
        assert_allclose(q, rest.q, rtol=1e-7, atol=1e-9)
    # The first step leads from the start to the equilibrium, in parts.
    assert_allclose((np.diff(motion.q, axis=0) / 0.25)[1:], motion.v[2:], atol=1e-12)


def test_one_step_is_enough_without_damping_and_friction():
    robot = lissom.Rod([rod()], loads=[lissom.Load(force=(0, 0.1, 0.1))])
    motion = lissom.simulate(robot, 1.0, dt=1.0, method=lissom.methods.QuasiStatic())
    assert_allclose(motion.q[-1], lissom.statics(robot).q, rtol=1e-5, atol=1e-8)


def crank(damping, stiffness=3.0, torque=1.5):
    joint = lissom.Revolute((0, 1, 0), stiffness=stiffness, damping=damping)
    link = lissom.Link("crank", joint=joint, body=lissom.Body(mass=0.7, inertia=np.eye(3)))
    return lissom.Robot([link], gravity=(0, 0, 0), loads=[lissom.Load(moment=(0, torque, 0), link="crank")])


def test_dampers_creep_with_order_one():
    errors = []
    for dt in (0.1, 0.05, 0.025):
        motion = lissom.simulate(crank(2.0), 3.0, dt=dt, method="quasi_static")
        exact = 0.5 * (1 - np.exp(-1.5 * motion.t))
        errors.append(np.abs(motion.q[:, 0] - exact).max())
    assert_allclose(np.divide(errors[:-1], errors[1:]), 2.0, rtol=0.05)
    assert errors[-1] < 5e-3


def dragged(motion, friction=0.4, unit=1.0, **contact):
    """A block on a floor behind a spring whose other end is moved."""
    up = lissom.Link("up", joint=lissom.Prismatic((0, 0, 1)), body=lissom.Body(mass=1e-7))
    driver = lissom.Link("driver", joint=lissom.Prismatic((1, 0, 0), motion=motion), parent="up")
    spring = lissom.Prismatic((1, 0, 0), stiffness=STIFFNESS)
    block = lissom.Link("block", joint=spring, parent="driver", body=lissom.Body(mass=WEIGHT / 9.81 - 1e-7))
    touch = lissom.Contact(
        lissom.Ball("block", 0.1, position=(0, 0, 0.1)),
        lissom.HalfSpace(),
        stiffness=1e6,
        friction=friction,
        slip_velocity=1e-5,
        **contact,
    )
    return lissom.Robot([up, driver, block], contacts=[touch])


def there_and_back(t):
    return SPEED * t * (2.0 - t)


@pytest.mark.parametrize("dt", [0.01, 0.05])
def test_what_is_dragged_sticks_slides_and_goes_back_by_another_way(dt):
    robot = dragged(there_and_back)
    start = [-WEIGHT / 1e6, 0.0]
    motion = lissom.simulate(robot, 3.0, q0=start, dt=dt, method="quasi_static")
    assert motion.success, motion.message
    # Coulomb: the spring stretches until friction is overcome, and by twice that much on the way back.
    force, most = 0.0, 0.4 * WEIGHT
    end = 0.0
    for t, q in zip(motion.t, motion.q, strict=True):
        moved = STIFFNESS * (there_and_back(t) - end)
        end = there_and_back(t)
        force = np.clip(force + moved, -most, most)
        # It creeps at the slip velocity times up to a few while it sticks.
        assert -STIFFNESS * q[1] == pytest.approx(force, abs=2e-2 * most)


def test_static_friction_lets_go():
    robot = dragged(
        [np.array([0.0, 4.0]), np.array([0.0, 4 * SPEED])], static_friction=0.6, stribeck_velocity=1e-3
    )
    with pytest.warns(lissom.AccuracyWarning, match="a contact begins to slip"):
        motion = lissom.simulate(robot, 4.0, q0=[-WEIGHT / 1e6, 0.0], dt=5e-3, method="quasi_static")
    assert motion.success, motion.message
    force = -STIFFNESS * motion.q[:, 1]
    assert force.max() == pytest.approx(0.6 * WEIGHT, rel=2e-2)
    # Then it slides until kinetic friction carries the spring, and goes on with the driver.
    drops = np.flatnonzero(np.diff(force) < -0.1 * WEIGHT)
    assert len(drops) == 1
    assert_allclose(force[drops[0] + 2 :], 0.4 * WEIGHT, rtol=1e-6)


def test_motions_are_those_with_inertia_where_these_are_slow():
    ramp = [np.array([0.0, 20.0]), np.array([0.0, SPEED])]
    start = [-WEIGHT / 1e6, 0.0]
    slow = lissom.simulate(dragged(ramp), 20.0, q0=start, dt=0.1, method="quasi_static")
    full = lissom.simulate(dragged(ramp), 20.0, q0=start, dt=5e-3)
    assert -STIFFNESS * slow.q[-1, 1] == pytest.approx(0.4 * WEIGHT, rel=1e-4)
    at = np.searchsorted(full.t, slow.t)
    assert_allclose(full.q[at, 1], slow.q[:, 1], atol=1e-2 * SPEED)


def test_closed_loops_are_held():
    def robot(force):
        joint = lissom.Revolute((0, 1, 0), stiffness=0.5, rest=-1.3)
        bars = [
            lissom.Link(
                "a", joint=joint, body=lissom.Body(mass=0.1, centre=(0.2, 0, 0), inertia=1e-3 * np.eye(3))
            ),
            lissom.Link(
                "b",
                joint=lissom.Revolute((0, 1, 0)),
                parent="a",
                position=(0.4, 0, 0),
                body=lissom.Body(mass=0.1, inertia=1e-3 * np.eye(3)),
            ),
            lissom.Link(
                "c",
                joint=lissom.Revolute((0, 1, 0)),
                position=(0.3, 0, 0),
                body=lissom.Body(mass=0.1, inertia=1e-3 * np.eye(3)),
            ),
        ]
        tie = lissom.Loop(
            lissom.LoopEnd("b", position=(0.3, 0, 0)),
            lissom.LoopEnd("c", position=(0.4, 0, 0)),
            lissom.Revolute((0, 1, 0)),
        )
        return lissom.Robot(bars, gravity=(0, 0, 0), loops=[tie], loads=[lissom.Load(force=force, link="a")])

    start = lissom.statics(robot((0, 0, 0.0)), q0=[-1.3, 1.3, -1.3]).q
    times = np.array([0.0, 1.0])
    moved = lissom.simulate(
        robot((times, [(0, 0, 0.0), (0.6, 0, 0)])), 1.0, q0=start, dt=0.1, method="quasi_static"
    )
    assert moved.success, moved.message
    assert_allclose(moved.q[-1], lissom.statics(robot((0.6, 0, 0)), q0=start).q, atol=1e-6)


def test_what_snaps_goes_over_to_the_next_equilibrium():
    # An upright mass on a torsion spring that is too soft to hold it, and a force that pushes it over.
    stiffness, mass, length = 4.5, 1.0, 0.5
    joint = lissom.Revolute((0, 1, 0), stiffness=stiffness)
    rocker = lissom.Link("rocker", joint=joint)
    head = lissom.Link("head", parent="rocker", position=(0, 0, length), body=lissom.Body(mass=mass))
    push = lissom.Load(force=([0.0, 1.0], [(0, 0, 0), (0.5, 0, 0)]), link="head")

    def moment(angle, force):
        return stiffness * angle - mass * 9.81 * length * np.sin(angle) - force * length * np.cos(angle)

    left = brentq(moment, -3.0, -0.3, args=(0.0,))
    robot = lissom.Robot([rocker, head], loads=[push])
    with pytest.warns(lissom.AccuracyWarning, match="no equilibrium is near"):
        motion = lissom.simulate(robot, 1.0, q0=[left], dt=0.01, method="quasi_static")
    assert motion.success, motion.message
    # The branch ends where the moment has a minimum of zero between two angles.
    angles = np.linspace(left, 0.0, 20001)
    forces = moment(angles, 0.0) / (length * np.cos(angles))
    snap = forces.max() / 0.5
    # It takes the time that falling over takes.
    before, after = motion.t < snap - 0.011, motion.t > snap + 0.3
    assert before.sum() > 10
    assert after.sum() > 10
    assert motion.q[before, 0].max() < 0 < motion.q[after, 0].min()
    for t, (angle,) in zip(motion.t[after], motion.q[after], strict=True):
        assert angle == pytest.approx(brentq(moment, 0.3, 3.0, args=(0.5 * t,)), abs=1e-5)


def test_what_nothing_holds_falls_with_inertia_and_is_said():
    stone = lissom.Link("stone", joint=lissom.Prismatic((0, 0, 1)), body=lissom.Body(mass=1.0))
    floor = lissom.Contact(lissom.Ball("stone", 0.1), lissom.HalfSpace(point=(0, 0, -0.2)), stiffness=1e5)
    with pytest.warns(lissom.AccuracyWarning, match="a part is not supported"):
        motion = lissom.simulate(lissom.Robot([stone], contacts=[floor]), 1.0, dt=0.01, method="quasi_static")
    assert motion.success
    assert motion.q[-1, 0] == pytest.approx(-0.1 - 9.81 / 1e5, abs=1e-9)


def test_what_just_touches_its_floor_settles_on_it():
    stone = lissom.Link("stone", joint=lissom.Prismatic((0, 0, 1)), body=lissom.Body(mass=1.0))
    floor = lissom.Contact(lissom.Ball("stone", 0.1), lissom.HalfSpace(point=(0, 0, -0.1)), stiffness=1e5)
    with pytest.warns(lissom.AccuracyWarning):
        motion = lissom.simulate(lissom.Robot([stone], contacts=[floor]), 1.0, dt=0.1, method="quasi_static")
    assert motion.success
    assert motion.q[-1, 0] == pytest.approx(-9.81 / 1e5, rel=1e-6)


@pytest.mark.parametrize("dt", [1.0, 0.5, 0.25])
@pytest.mark.parametrize("stiffness", [1e3, 1e6])
def test_stops_are_reached_and_left(dt, stiffness):
    joint = lissom.Prismatic(
        (1, 0, 0), stiffness=50.0, limits=(-0.1, 0.2), limit_stiffness=stiffness, limit_dissipation=0.0
    )
    link = lissom.Link("slider", joint=joint, body=lissom.Body(mass=1.0))
    times = np.array([0.0, 1.0, 2.0, 3.0])
    push = lissom.Load(force=(times, [(f, 0, 0) for f in (0.0, 20.0, -20.0, 20.0)]), link="slider")
    robot = lissom.Robot([link], gravity=(0, 0, 0), loads=[push])
    with warnings.catch_warnings():
        # Long steps over stops are jumps.
        warnings.simplefilter("ignore", lissom.AccuracyWarning)
        motion = lissom.simulate(robot, 3.0, dt=dt, method="quasi_static")
    assert motion.success
    force = np.interp(motion.t, times, (0.0, 20.0, -20.0, 20.0))
    free = force / 50.0
    held = np.where(free > 0.2, (force + 0.2 * stiffness) / (50.0 + stiffness), free)
    held = np.where(free < -0.1, (force - 0.1 * stiffness) / (50.0 + stiffness), held)
    assert_allclose(motion.q[:, 0], held, atol=1e-7)


def test_between_steps_shapes_are_between_them():
    joint = lissom.Prismatic((0, 0, 1), stiffness=100.0)
    link = lissom.Link("mass", joint=joint, body=lissom.Body(mass=1.0))
    times = np.linspace(0.0, 0.5, 21)
    motion = lissom.simulate(lissom.Robot([link]), 0.5, dt=0.1, t_eval=times, method="quasi_static")
    at_rest = -9.81 / 100.0
    assert_allclose(motion.q[times >= 0.1, 0], at_rest, rtol=1e-9)
    assert_allclose(motion.q[times < 0.1, 0], at_rest * times[times < 0.1] / 0.1, rtol=1e-9)


def test_unstable_equilibria_are_doubted():
    joint = lissom.Revolute((0, 1, 0), stiffness=4.5)
    rocker = lissom.Link("rocker", joint=joint)
    head = lissom.Link("head", parent="rocker", position=(0, 0, 0.5), body=lissom.Body(mass=1.0))
    with pytest.warns(lissom.AccuracyWarning, match="unstable equilibrium"):
        motion = lissom.simulate(lissom.Robot([rocker, head]), 1.0, dt=0.1, method="quasi_static")
    assert motion.success
    assert motion.q[-1, 0] == 0.0


def test_flows_that_push_by_added_mass_are_refused():
    water = lissom.Fluid(1000.0, velocity=(0.5, 0, 0))
    with pytest.raises(ValueError, match="added_mass_coefficient"):
        lissom.simulate(lissom.Rod([rod()], fluid=water), 1.0, dt=0.1, method="quasi_static")


def test_scenes_and_names_are_the_same():
    robot = lissom.Rod([rod()], loads=[lissom.Load(force=(0, 0, 0.05))])
    scene = robot.to_scene(t_end=1.0, method="quasi_static", dt=0.5)
    by_scene = scene.run()
    by_name = lissom.simulate(scene.model, 1.0, dt=0.5, method="quasi_static")
    assert_array_equal(by_scene.q, by_name.q)


def test_what_has_no_meaning_without_inertia_is_refused():
    with pytest.raises(ValueError, match=r"v0: .*without inertia"):
        lissom.simulate(crank(1.0), 1.0, v0=[1.0], dt=0.1, method="quasi_static")
    with pytest.raises(ValueError, match="rho_inf"):
        lissom.simulate(crank(1.0), 1.0, dt=0.1, method="quasi_static", rho_inf=0.5)
    with pytest.raises(ValueError, match="method"):
        lissom.sensitivity(crank(1.0), 1.0, ["q0"], dt=0.1, method="quasi_static")


def catheter(friction, speed=0.2):
    """A soft catheter of 0.24 m that lies down in a bent vessel and is fed with a speed in m/s."""
    x = np.linspace(0.0, 0.25, 40)
    bends = 0.015 * np.sin(x / 0.25 * 5 * np.pi) * np.minimum(1, x / 0.06)
    points = np.column_stack([x, bends, 0.008 * np.cos(x / 0.04) * np.minimum(1, x / 0.08)])
    points = np.vstack([[(-0.15, *points[0, 1:]), (-0.075, *points[0, 1:])], points])
    vessel = lissom.Tube(points, radius=0.003, wall=0.002)
    part = lissom.Segment(
        0.24 / 4,
        radius=0.8e-3,
        modes={"bend_y": 4, "bend_z": 4, "torsion": 1},
        young_modulus=2e8,
        poisson_ratio=0.33,
        density=6450,
    )
    feed = lissom.Prismatic((1, 0, 0), motion=([0, 0.2 / speed], [0.0, 0.2], "linear"))
    link = lissom.Link("catheter", joint=feed, rod=[part] * 4, position=(-0.24, *points[0, 1:]))
    wall = lissom.Contact("catheter", vessel, friction=friction)
    return lissom.Robot([link], gravity=(0, 0, -9.81), contacts=[wall])


def test_catheters_end_each_step_in_equilibrium():
    """Where contacts begin all along a catheter."""
    robot = catheter(0.0)
    motion = lissom.simulate(robot, 0.12, dt=0.01, method="quasi_static")
    assert motion.success
    for t, q in zip(motion.t[1:], motion.q[1:], strict=True):
        rest = lissom.statics(robot, q, t=t, space_error=False)
        assert rest.success
        assert np.abs(rest.q - q).max() < 1e-3 * np.abs(q).max(), t


def test_catheters_with_friction_go_downhill():
    """Friction held at the forces of one equilibrium finds the next one, without parts that have inertia."""
    # So slow that the inertia in the joint's wrench is nothing beside friction.
    robot = catheter(0.1, speed=0.01)
    motion = lissom.simulate(robot, 2.4, dt=0.2, method="quasi_static")
    assert motion.success
    assert "no equilibrium is near" not in motion.message
    assert motion.stats.newton_iterations < 200 * 12
    # In each step forces balance: what pushes the base along x is what walls and their friction push back.
    for t, q, v in zip(motion.t[2:], motion.q[2:], motion.v[2:], strict=True):
        pushed = robot.joint_wrench("catheter", q, v, 0.0 * v, t=t)[3]
        touches = robot.touches(q, v, t=t)
        along = sum(touch.force[0] for touch in touches)
        normal = sum(abs(touch.force @ touch.normal) for touch in touches)
        assert abs(pushed + along) < 1e-3 * normal
        sliding = [touch.force - (touch.force @ touch.normal) * touch.normal for touch in touches]
        assert max(np.linalg.norm(s) for s in sliding) <= 0.1 * normal
    finer = lissom.simulate(robot, 2.4, dt=0.1, method="quasi_static")
    assert finer.success
    ends = [robot.pose(run.q[-1], 0.24, link="catheter", t=2.4)[:3, 3] for run in (motion, finer)]
    assert np.linalg.norm(ends[0] - ends[1]) < 0.01 * 0.24
