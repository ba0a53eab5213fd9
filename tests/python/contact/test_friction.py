"""Friction: the tension of a cable around a drum, which grows exponentially with the angle (Euler 1769,
Eytelwein 1808); friction at rest that is larger than that of sliding, of blocks and on a belt.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

DRUM, RADIUS, LOAD, CABLE_SPEED = 0.05, 0.002, 5.0, 0.02
#: Bending radius of the cable's axis on the drum.
BEND = DRUM + RADIUS
YOUNG = 5e6
ARC = np.pi * BEND


def cable(friction, speed):
    """The cable lies around half of a drum with a load at its tip, and its base moves along x."""

    def part(length, modes):
        return lissom.Segment(
            length, radius=RADIUS, young_modulus=YOUNG, poisson_ratio=0.5, density=1000,
            modes={"bend_y": modes}, retardation_time=1e-3,
        )  # fmt: skip

    base = lissom.Prismatic((1, 0, 0), motion=lambda t: speed * (t - 0.02 * (1 - np.exp(-t / 0.02))))
    segments = [part(0.1, 3)] + [part(ARC / 12, 2)] * 12 + [part(0.1, 3)]
    link = lissom.Link("cable", rod=segments, joint=base, position=(-0.1, 0, BEND))
    drum = lissom.Contact(
        "cable", lissom.Capsule((0, -1, 0), (0, 1, 0), DRUM), stiffness=1e7, friction=friction
    )
    load = lissom.Load(force=(-LOAD, 0, 0), link="cable")
    robot = lissom.Robot([link], contacts=[drum], loads=[load], gravity=(0, 0, 0))
    q0 = np.zeros(robot.n)
    q0[3:27:2] = 1 / BEND
    start = lissom.statics(robot, q0, space_error=False)
    assert start.success, start.message
    return robot, start.q


def exponent(friction):
    """Exponent of the tension as a function of the angle, for a cable that is not thin.

    Friction acts at the drum's radius R, tension T and shear Q at R + r; the moment is constant. With the
    pressure N per angle: T' (R + r) = mu N R, T' + Q = mu N, N = T - Q', solved by N ~ exp(lambda phi) with
    lambda (1 + mu p lambda) = mu (1 - p), p = r / (R + r).
    """
    p = RADIUS / BEND
    return (np.sqrt(1 + 4 * friction**2 * p * (1 - p)) - 1) / (2 * friction * p)


def torques(robot, state, X, t):
    """Torques about the drum's axis through sections, and the angles of these sections."""
    poses = robot.pose(state[0], X, t=t)
    wrenches = robot.internal_wrench(*state, X, t=t)
    moments, forces = (np.einsum("kij,kj->ki", poses[:, :3, :3], part) for part in np.split(wrenches, 2, 1))
    places = poses[:, :3, 3]
    return (np.cross(places, forces) + moments)[:, 1], np.arctan2(places[:, 0], places[:, 2])


@pytest.mark.parametrize("friction", [0.3, 0.6])
@pytest.mark.parametrize("side", [1, -1])
def test_tension_grows_with_the_angle_against_the_motion(friction, side):
    # 1: the base lifts the load; -1: it lowers the load.
    robot, q0 = cable(friction, -side * CABLE_SPEED)
    result = lissom.simulate(robot, 0.1, dt=2e-3, q0=q0)
    assert result.success, result.message
    state = result.q[-1], result.v[-1], result.a[-1]
    t = result.t[-1]
    torque, angle = torques(robot, state, 0.1 + ARC * np.array([0.25, 0.75]), t)
    # Without the constant moment of the bent cable, which is the same in all sections.
    bending = YOUNG * np.pi / 4 * RADIUS**4 / BEND
    grows = np.diff(np.log(np.abs(torque + bending))) / np.diff(angle)
    # The overlap reduces the radius by 4e-4; the pressure oscillates with the modes, so that the part of it
    # between two sections varies.
    assert_allclose(grows, -side * exponent(friction), rtol=2e-3)
    # From end to end, where bending at the points of departure moves these places.
    base = robot.joint_wrench(*state, link="cable", t=t)[3]
    assert_allclose(np.log(-base / LOAD) / np.pi, side * exponent(friction), rtol=bending / (LOAD * BEND))


def test_without_friction_a_drum_has_no_torque():
    robot, q = cable(0.0, 0.0)
    rest = np.zeros_like(q)
    torque, _ = torques(robot, (q, rest, rest), 0.1 + ARC * np.linspace(0.1, 0.9, 5), 0.0)
    assert_allclose(torque, torque[0], rtol=1e-9)
    assert_allclose(torque, -LOAD * BEND, rtol=1e-2)
    assert_allclose(robot.contact_forces(q, rest, t=0.0)[3:], [2 * LOAD, 0, 0], atol=1e-2 * LOAD)


def test_slow_motions_without_inertia_have_the_same_tension():
    robot, q0 = cable(0.3, -CABLE_SPEED)
    result = lissom.simulate(robot, 0.1, dt=1e-2, q0=q0, method="quasi_static")
    assert result.success, result.message
    state = result.q[-1], result.v[-1], result.a[-1]
    torque, angle = torques(robot, state, 0.1 + ARC * np.array([0.25, 0.75]), result.t[-1])
    bending = YOUNG * np.pi / 4 * RADIUS**4 / BEND
    grows = np.diff(np.log(np.abs(torque + bending))) / np.diff(angle)
    assert_allclose(grows, -exponent(0.3), rtol=2e-3)


MASS, GRAVITY, STATIC, KINETIC = 2.0, 9.81, 0.6, 0.4
WEIGHT = MASS * GRAVITY
#: Of what moves up and down only, kg.
LITTLE = 1e-7


def block(spring=0.0, floor=None, loads=(), **constants):
    """A mass on a rail above a floor, which presses with its weight, held by a spring along the rail."""
    up = lissom.Link("up", joint=lissom.Prismatic((0, 0, 1)), body=lissom.Body(mass=LITTLE))
    along = lissom.Link(
        "along",
        joint=lissom.Prismatic((1, 0, 0), stiffness=spring),
        parent="up",
        body=lissom.Body(mass=MASS - LITTLE),
    )
    ball = lissom.Ball("along", 0.1, position=(0, 0, 0.1))
    contact = lissom.Contact(
        ball,
        floor or lissom.HalfSpace(),
        stiffness=1e6,
        friction=KINETIC,
        static_friction=STATIC,
        **constants,
    )
    belt = [] if floor is None else [lissom.Link("belt", joint=lissom.Prismatic((1, 0, 0), motion=_belt))]
    return lissom.Robot([up, along, *belt], loads=loads, contacts=[contact])


BELT_SPEED = 0.1


def _belt(t):
    return BELT_SPEED * t


#: Here loads grow slowly, or all slides: steps need not resolve how velocities grow from rest.
LONG = pytest.mark.filterwarnings("ignore:.*long for static friction")


@LONG
@pytest.mark.parametrize("velocities", [(1e-4, 1e-2), (1e-3, 5e-3)])
@pytest.mark.parametrize(("part", "slides"), [(0.99, False), (1.01, True)])
def test_blocks_slide_from_static_friction_on(part, slides, velocities):
    slip, stribeck = velocities
    force = part * STATIC * WEIGHT
    load = lissom.Load(force=([0.0, 1.0], [(0, 0, 0), (force, 0, 0)]), link="along")
    robot = block(loads=[load], slip_velocity=slip, stribeck_velocity=stribeck)
    start = [-WEIGHT / 1e6, 0.0]
    motion = lissom.simulate(robot, 3.0, q0=start, dt=1e-3)
    assert motion.success
    speed = motion.v[:, 1]
    if not slides:
        # It creeps at the speed at which friction is the load, below that of the largest friction.
        assert 0 < speed[-1] < np.sqrt(slip * stribeck)
        return
    # Once it slides, kinetic friction is left, and the acceleration is that of the difference.
    acceleration = (speed[-1] - speed[len(speed) // 2]) / (motion.t[-1] - motion.t[len(speed) // 2])
    assert speed[-1] > 10 * stribeck
    assert acceleration == pytest.approx(part * STATIC * GRAVITY - KINETIC * GRAVITY, rel=2e-3)


def test_a_load_that_jumps_is_held_by_steps_that_follow_it():
    load = lissom.Load(force=(0.98 * STATIC * WEIGHT, 0, 0), link="along")
    motion = lissom.simulate(block(loads=[load]), 1.0, q0=[-WEIGHT / 1e6, 0.0], method="radau")
    assert motion.success
    assert 0 < motion.v[-1, 1] < 1e-3


def test_fixed_steps_that_may_let_go_of_what_sticks_are_doubted():
    load = lissom.Load(force=(0.9 * STATIC * WEIGHT, 0, 0), link="along")
    start = [-WEIGHT / 1e6, 0.0]
    with pytest.warns(lissom.AccuracyWarning, match="long for static friction"):
        lissom.simulate(block(loads=[load]), 1.0, q0=start, dt=1e-2)
    motion = lissom.simulate(block(loads=[load]), 1.0, q0=start, dt=1e-3)
    assert motion.doubt is None
    assert 0 < motion.q[-1, 1] < 1e-2


@LONG
def test_what_slides_fast_has_kinetic_friction():
    robot = block(stribeck_velocity=1e-2)
    motion = lissom.simulate(robot, 1.0, q0=[-WEIGHT / 1e6, 0.0], v0=[0.0, 3.0], dt=1e-3)
    stop = 3.0 / (KINETIC * GRAVITY)
    sliding = motion.t < 0.95 * stop
    exact = 3.0 * motion.t - 0.5 * KINETIC * GRAVITY * motion.t**2
    assert np.abs(motion.q[sliding, 1] - exact[sliding]).max() < 1e-4
    assert motion.v[-1, 1] < 1e-9


def stick_and_slip(spring):
    """Period, and largest and least force of the spring, with friction that jumps (Coulomb)."""
    # Slip: m x'' = -k x + mu N, from x = mu_s N / k at the belt's speed.
    omega = np.sqrt(spring / MASS)
    middle = KINETIC * WEIGHT / spring
    start = STATIC * WEIGHT / spring - middle

    # It sticks again where its velocity is the belt's: BELT_SPEED (1 - cos) = -start omega sin.
    slip = 2 * (np.pi - np.arctan(start * omega / BELT_SPEED)) / omega
    amplitude = np.hypot(start, BELT_SPEED / omega)
    return slip + 2 * start / BELT_SPEED, spring * (middle + amplitude), spring * (middle - amplitude)


@LONG
@pytest.mark.parametrize("dt", [1e-3, 2e-4])
def test_stick_and_slip_on_a_belt(dt):
    spring = 400.0
    period, most, least = stick_and_slip(spring)
    # Short against the velocities of slipping, so that friction jumps.
    robot = block(
        spring, lissom.HalfSpace(link="belt"), slip_velocity=2e-6, stribeck_velocity=2e-4, dissipation=1.0
    )
    motion = lissom.simulate(robot, 6 * period, q0=[-WEIGHT / 1e6, 0.0], v0=[0.0, BELT_SPEED], dt=dt)
    assert motion.success
    x = motion.q[:, 1]
    settled = motion.t > 2 * period
    assert spring * x[settled].max() == pytest.approx(most, rel=1e-2)
    assert spring * x[settled].min() == pytest.approx(least, abs=2e-2 * most)
    middle = 0.5 * (x[settled].max() + x[settled].min())
    falls = motion.t[1:][settled[1:] & (x[1:] < middle) & (x[:-1] >= middle)]
    assert np.diff(falls).mean() == pytest.approx(period, rel=1e-2)


def test_equal_coefficients_are_one():
    plain = lissom.Contact("a", lissom.HalfSpace(), friction=0.5)
    same = lissom.Contact("a", lissom.HalfSpace(), friction=0.5, static_friction=0.5)
    rod = lissom.Link(
        "a",
        rod=[
            lissom.Segment(
                0.3, radius=0.01, young_modulus=1e6, poisson_ratio=0.45, density=1000, modes={"bend_y": 2}
            )
        ],
    )
    runs = [
        lissom.simulate(
            lissom.Robot([rod], gravity=(1, 0, -9.81), contacts=[contact]), 0.1, q0=[0.0, 0.0], dt=1e-3
        )
        for contact in (plain, same)
    ]
    np.testing.assert_array_equal(runs[0].q, runs[1].q)


@pytest.mark.parametrize(
    ("constants", "words"),
    [
        ({"static_friction": 0.3}, "static_friction: got 0.3"),
        ({"static_friction": -0.3}, "static_friction"),
        ({"static_friction": 0.6, "friction": (0.4, 0.4, 0.5)}, "one number"),
        ({"static_friction": 0.6, "friction": 0.0}, "above zero"),
        ({"static_friction": 0.6, "stribeck_velocity": 2e-4}, "stribeck_velocity: got 0.0002"),
    ],
)
def test_what_is_no_static_friction_is_refused(constants, words):
    with pytest.raises(ValueError, match=r"friction|stribeck") as raised:
        lissom.Contact("a", lissom.HalfSpace(), **{"friction": 0.4, **constants})
    assert words in str(raised.value)


def block_on_slope(friction, slip_velocity):
    """A block of 1 kg, 0.2 m long, on a slope of 0.3 rad."""
    slope = 0.3
    gravity = (9.81 * np.sin(slope), 0.0, -9.81 * np.cos(slope))
    body = lissom.Body(1.0, inertia=(1e-3, 1e-3, 1e-3))
    block = lissom.Link("block", joint=lissom.Planar((0, 1, 0)), body=body, position=(0, 0, 0.05))
    box = lissom.Box((0, 0, 0), (0.1, 0.1, 0.05), link="block")
    contact = lissom.Contact(
        box, lissom.HalfSpace(), stiffness=1e5, friction=friction, slip_velocity=slip_velocity
    )
    return lissom.Robot([block], gravity=gravity, contacts=[contact])


@pytest.mark.parametrize("method", ["newmark", "quasi_static"])
def test_contacts_that_creep_are_doubted(method):
    """Below its angle of friction a block goes on for ever, about as fast as its `slip_velocity`."""
    times = {"dt": 1e-2, "method": method, "t_eval": np.linspace(0, 100, 401)}

    def run(slip_velocity):
        robot = block_on_slope(0.32, slip_velocity)
        return lissom.simulate(robot, 100.0, q0=lissom.statics(robot).q, **times)

    with pytest.warns(lissom.AccuracyWarning, match="creeps below"):
        result = run(1e-4)
    assert abs(result.q[-1] - result.q[0]).max() > 0.03
    assert 'the contact "block on halfspace"' in result.doubt
    assert "`slip_velocity` of 0.0001 m/s" in result.doubt
    enough = float(result.doubt.rsplit("Give it ", 1)[1].split()[0])
    assert run(enough).doubt is None


def test_contacts_that_slide_are_not_doubted():
    result = lissom.simulate(block_on_slope(0.2, 1e-4), 1.0, dt=1e-2)
    assert result.doubt is None


def test_two_coefficients_are_those_at_rest_and_of_sliding():
    pair = lissom.Contact("a", lissom.HalfSpace(), friction=(0.6, 0.4))
    assert pair == lissom.Contact("a", lissom.HalfSpace(), static_friction=0.6, friction=0.4)
    assert (pair.static_friction, pair.friction) == (0.6, (0.4, 0.4, 0.4))
    with pytest.raises(ValueError, match="one of both"):
        lissom.Contact("a", lissom.HalfSpace(), static_friction=0.7, friction=(0.6, 0.4))
    with pytest.raises(ValueError, match=r"static_friction: got 0.3, expected at least `friction`"):
        lissom.Contact("a", lissom.HalfSpace(), friction=(0.3, 0.4))
    with pytest.raises(ValueError, match="2 or 3"):
        lissom.Contact("a", lissom.HalfSpace(), friction=(0.3, 0.4, 0.5, 0.6))


#: Radius and length of a rod on a floor, where its second segment begins along it, and its overlap, m.
THICK, LONG, JOINT, PRESSED = 0.01, 0.4, 0.12, 1e-4


def rod_on_floor(friction, **options):
    """A rod of two straight segments; the coordinates are those of its base."""
    segments = [
        lissom.Segment(
            length, radius=THICK, young_modulus=1e7, poisson_ratio=0.3, density=1000, modes={"bend_y": 1}
        )
        for length in (JOINT, LONG - JOINT)
    ]
    link = lissom.Link("rod", joint=lissom.Free(), rod=segments, position=(0, 0, THICK))
    floor = lissom.Contact("rod", lissom.HalfSpace(), friction=friction, stiffness=1e5, **options)
    return lissom.Robot([link], contacts=[floor])


def dragged(robot):
    """The contact forces on a rod that is pressed into the floor and dragged forward and sideways."""
    q, v = np.zeros((2, robot.n))
    q[2], v[:2] = -PRESSED, (0.6, 0.8)
    return robot.contact_forces(q, v)


def test_each_part_of_a_rod_has_its_own_friction():
    rough, slippery, step = 0.5, 0.1, 1e-6
    stations = [0, JOINT - step, JOINT + step, LONG]
    wrench = dragged(rod_on_floor((stations, [rough, rough, slippery, slippery])))
    first, second = 1e5 * PRESSED * np.array([JOINT, LONG - JOINT])
    assert_allclose(wrench[5], first + second, rtol=1e-9)
    # The speed is 1 m/s: the slip velocity changes friction by 5e-9.
    friction = np.array([rough * first, slippery * second])
    assert_allclose(wrench[3:5], -friction.sum() * np.array([0.6, 0.8]), rtol=1e-7)
    # Sideways friction turns the rod about its base by the distances of the middles of the segments.
    middles = np.array([JOINT / 2, (JOINT + LONG) / 2])
    assert_allclose(wrench[2], -0.8 * friction @ middles, rtol=1e-7)


def test_friction_that_is_linear_along_a_rod_is_integrated():
    robot = rod_on_floor(([0, LONG], [0.0, 0.6]))
    wrench = dragged(robot)
    normal = 1e5 * PRESSED * LONG
    assert_allclose(wrench[3:5], -0.3 * normal * np.array([0.6, 0.8]), rtol=1e-7)
    # int mu(s) s ds / L = 0.6 L / 3
    assert_allclose(wrench[2], -0.8 * normal * 0.2 * LONG, rtol=1e-7)


def test_a_constant_table_of_friction_is_its_number():
    table, number = (dragged(rod_on_floor(mu)) for mu in [([0, 0.1, LONG], [0.3] * 3), 0.3])
    assert np.array_equal(table, number)


def test_friction_along_a_rod_is_kept_in_scenes():
    robot = rod_on_floor(([0, 0.1, LONG], [0.5, 0.3, 0.1]))
    assert robot.contacts[0].friction == ((0.0, 0.1, LONG), (0.5, 0.3, 0.1))
    assert robot.to_scene().model == robot
    assert "0.5 along the rod" in robot.explain()


@pytest.mark.parametrize(
    ("friction", "options", "words"),
    [
        (([0, LONG], [0.1, -0.2]), {}, r"friction\.values\[1\]"),
        (([0, 0.3], [0.1, 0.2]), {}, r"friction\.stations\[1\]: got 0.3"),
        (([0, 0.5], [0.1, 0.2]), {}, r"friction\.stations\[1\]: got 0.5"),
        (([0.1, LONG], [0.1, 0.2]), {}, r"friction\.stations\[0\]"),
        (([0, LONG], [0.1, 0.2]), {"static_friction": 0.5}, "table of `friction`"),
    ],
)
def test_what_is_no_friction_along_a_rod_is_refused(friction, options, words):
    with pytest.raises(ValueError, match=words):
        rod_on_floor(friction, **options)


def test_bodies_have_no_friction_along_them():
    ball = lissom.Ball("rod", 0.01)
    with pytest.raises(ValueError, match="a table"):
        lissom.Contact(ball, lissom.HalfSpace(), stiffness=1e4, friction=([0, 1], [0.1, 0.2]))
