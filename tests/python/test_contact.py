"""Contact against closed forms: bounces, slopes, wheels, belts, rods on floors and between walls."""

from __future__ import annotations

import pickle

import lissom
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

G = 9.81
FLOOR = lissom.HalfSpace((0, 0, 0), (0, 0, 1))


def body(mass=1.0, radius=0.1):
    """A solid sphere."""
    return lissom.Body(mass, inertia=np.eye(3) * 0.4 * mass * radius**2)


def ball_on_floor(joint, *, radius=0.1, gravity=(0, 0, -G), floor=FLOOR, **constants):
    link = lissom.Link("ball", joint=joint, body=body(radius=radius))
    contact = lissom.Contact(lissom.Ball("ball", radius), floor, **constants)
    return lissom.Robot([link], gravity=gravity, contacts=[contact])


# Balls


@pytest.mark.parametrize(("speed", "dissipation"), [(1.0, 0.0), (1.0, 0.2), (0.1, 1.0), (3.0, 0.5)])
def test_a_ball_bounces_as_hunt_and_crossley_say(speed, dissipation):
    # m x'' = -k x (1 + c x') in the overlap x: with u = x', u / (1 + c u) du = -k x / m dx, whose integral is the same
    # before and after. Without gravity.
    robot = ball_on_floor(
        lissom.Prismatic((0, 0, 1)), gravity=(0, 0, 0), stiffness=1e4, dissipation=dissipation
    )
    q0 = [0.1 + 0.01 * speed]
    result = lissom.simulate(robot, 0.1, dt=1e-3, q0=q0, v0=[-speed], method="dop853", rtol=1e-10, atol=1e-12)
    assert result.success
    rebound = result.v[-1, 0]
    if dissipation == 0.0:
        wanted = speed
    else:
        c = dissipation
        invariant = lambda u: u / c - np.log1p(c * u) / c**2  # noqa: E731
        wanted = brentq(lambda v: invariant(-v) - invariant(speed), 0.0, min(speed, (1 - 1e-12) / c))
    assert_allclose(rebound, wanted, rtol=1e-7)


def test_steps_far_longer_than_an_impact_keep_a_ball_out_of_the_floor():
    robot = ball_on_floor(lissom.Prismatic((0, 0, 1)), stiffness=1e8)
    result = lissom.simulate(robot, 2.0, dt=1e-3, q0=[0.6])
    assert result.success
    height = result.q[:, 0]
    assert height.min() > 0.1 - 0.012
    # It comes to rest on the floor: the overlap carries the weight.
    assert_allclose(height[-1], 0.1 - G / 1e8, atol=1e-7)
    force = robot.contact_forces(result.q[-1], result.v[-1])
    assert_allclose(force, [0, 0, 0, 0, 0, G], atol=1e-3)
    # Damping only takes energy.
    energy = np.array([robot.energy(q, v).total for q, v in zip(result.q, result.v, strict=True)])
    assert energy.max() < energy[0] + 1e-3


@pytest.mark.parametrize("speed", [10.0, 100.0])
def test_fast_balls_do_not_pass_through_a_floor(speed):
    robot = ball_on_floor(lissom.Prismatic((0, 0, 1)), stiffness=1e7)
    result = lissom.simulate(robot, 0.2, dt=1e-3, q0=[0.5], v0=[-speed])
    assert result.success
    assert result.q[-1, 0] > 0.0
    assert abs(result.v[-1, 0]) <= speed


# Slopes


def slope(angle):
    return lissom.HalfSpace((0, 0, 0), (-np.sin(angle), 0, np.cos(angle)))


def block(angle, friction, **constants):
    """A ball that hardly turns, at rest on a slope, and where it is then: coordinates along x and along -z."""
    link = lissom.Link(
        "block", joint=lissom.Planar((0, 1, 0)), body=lissom.Body(1.0, inertia=np.eye(3) * 1e9)
    )
    contact = lissom.Contact(
        lissom.Ball("block", 0.1), slope(angle), stiffness=1e5, friction=friction, **constants
    )
    height = 0.1 - G * np.cos(angle) / 1e5
    return lissom.Robot([link], contacts=[contact]), [-np.sin(angle) * height, -np.cos(angle) * height, 0.0]


@pytest.mark.parametrize("mu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("method", ["newmark", "radau"])
def test_a_block_slides_down_a_slope(mu, method):
    angle = 0.5
    robot, q0 = block(angle, mu)
    result = lissom.simulate(robot, 1.0, dt=1e-3, q0=q0, method=method)
    assert result.success
    way = np.hypot(*(result.q[-1] - q0)[:2])
    assert_allclose(way, 0.5 * G * (np.sin(angle) - mu * np.cos(angle)), rtol=5e-4)


@pytest.mark.parametrize("slip_velocity", [1e-4, 1e-2])
def test_a_block_that_sticks_creeps_as_slowly_as_it_says(slip_velocity):
    angle, mu = 0.5, 0.8
    robot, q0 = block(angle, mu, slip_velocity=slip_velocity)
    result = lissom.simulate(robot, 1.0, dt=1e-3, q0=q0)
    assert result.success
    part = np.tan(angle) / mu
    creep = slip_velocity * part / np.sqrt(1 - part**2)
    assert_allclose(np.hypot(*result.v[-1, :2]), creep, rtol=1e-6)
    assert creep < slip_velocity
    (touch,) = robot.touches(result.q[-1], result.v[-1])
    assert_allclose(touch.force, [0, 0, G], atol=1e-6)
    assert_allclose(touch.normal, [-np.sin(angle), 0, np.cos(angle)], atol=1e-15)


# Wheels


def test_a_sphere_that_slides_begins_to_roll():
    speed, mu, radius = 2.0, 0.2, 0.1
    robot = ball_on_floor(lissom.Free(), radius=radius, stiffness=1e6, friction=mu, dissipation=0.0)
    q0 = [0, 0, radius - G / 1e6, 0, 0, 0]
    rolls_after = 2 * speed / (7 * mu * G)
    times = np.array([0.5, 0.99, 1.2, 2.0]) * rolls_after
    result = lissom.simulate(robot, times[-1], dt=2e-4, q0=q0, v0=[speed, 0, 0, 0, 0, 0], t_eval=times)
    assert result.success
    velocities = [robot.velocity(q, v, link="ball") for q, v in zip(result.q, result.v, strict=True)]
    spin, forward = np.array([[velocity[1], velocity[3]] for velocity in velocities]).T
    wanted = np.where(times < rolls_after, speed - mu * G * times, 5 / 7 * speed)
    assert_allclose(forward, wanted, rtol=1e-3)
    assert_allclose(spin[-2:] * radius, 5 / 7 * speed, rtol=1e-3)


def test_a_sphere_rolls_down_a_slope():
    angle, radius = 0.3, 0.1
    link = lissom.Link("ball", joint=lissom.Free(), body=body(radius=radius))
    contact = lissom.Contact(lissom.Ball("ball", radius), slope(angle), stiffness=1e6, friction=0.5)
    robot = lissom.Robot([link], contacts=[contact])
    normal = np.array([-np.sin(angle), 0, np.cos(angle)])
    q0 = np.r_[normal * (radius - G * np.cos(angle) / 1e6), 0, 0, 0]
    result = lissom.simulate(robot, 1.0, dt=1e-3, q0=q0)
    assert result.success
    way = np.linalg.norm(result.q[-1, :3] - q0[:3])
    # The regularised law lets it slip by a part of the stated velocity.
    assert_allclose(way, 0.5 * G * np.sin(angle) / 1.4, rtol=1e-3)


# Rods


def rod_segment(length, **options):
    return lissom.Segment(length, radius=0.005, young_modulus=1e6, poisson_ratio=0.5, density=1000, **options)


def test_a_rod_clamped_above_a_floor_comes_to_rest_on_it():
    # Small slopes: the free length is (72 EI h / w)^(1/4), and the floor answers w l / 3 at a point there, then w.
    radius, length, height = 0.005, 0.6, 2e-3
    segment = rod_segment(length, modes={"bend_y": 10})
    stiffness = np.pi / 4 * radius**4 * 1e6
    weight = 1000 * np.pi * radius**2 * G
    free = (72 * stiffness * height / weight) ** 0.25
    floor = lissom.Contact("rod", lissom.HalfSpace((0, 0, -height - radius), (0, 0, 1)))
    rod = lissom.Rod([segment] * 3, contacts=[floor])
    result = lissom.statics(rod)
    assert result.success, result.message
    force = rod.contact_forces(result.q, np.zeros_like(result.q))
    assert_allclose(force[5], weight * (rod.length - free) + weight * free / 3, rtol=2e-2)
    touches = rod.touches(result.q)
    first = min(touch.along[0] for touch in touches)
    assert_allclose(first, free, rtol=0.1)


def test_contacts_pickle_and_compare():
    contact = lissom.Contact("rod", lissom.Box((0, 0, -1), (1, 1, 0.5)), friction=(0.1, 0.2, 0.3))
    rod = lissom.Rod([rod_segment(0.3, modes={"bend_y": 3})], contacts=[contact])
    assert rod.contacts == (contact,)
    assert pickle.loads(pickle.dumps(rod)).contacts == (contact,)
    assert contact.name == "rod on box"


# What is refused


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: lissom.Contact(FLOOR, "rod"), "a: got an obstacle"),
        (lambda: lissom.Contact("rod", lissom.Sphere((0, 0, 0), -1.0)), "b.radius"),
        (lambda: lissom.Contact(lissom.Ball("rod", 0.1), FLOOR), "stiffness"),
        (lambda: lissom.Contact("rod", FLOOR, friction=-0.1), "friction"),
        (lambda: lissom.Contact("rod", FLOOR, slip_velocity=0.0), "slip_velocity"),
        (lambda: lissom.Contact("rod", lissom.HalfSpace((0, 0, 0), (0, 0, 0))), "b.normal"),
        (lambda: lissom.Contact("rod", "rood") and rod_on("rood"), "did you mean 'rod'"),
        (lambda: lissom.Contact(lissom.Ball("rod", 0.1), FLOOR, stiffness=1, friction=(1, 2, 3)), "friction"),
    ],
)
def test_what_makes_no_sense_is_refused(make, message):
    with pytest.raises((ValueError, TypeError), match=message):
        make()


def rod_on(other):
    return lissom.Rod([rod_segment(0.3, modes={"bend_y": 3})], contacts=[lissom.Contact("rod", other)])
