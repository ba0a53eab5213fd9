"""Contact compared with closed forms: bounces, slopes, wheels, belts, rods on floors and between walls."""

from __future__ import annotations

import pickle
import re
import warnings

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq, minimize_scalar

import lissom

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
    # m x'' = -k x (1 + c x') in the overlap x: with u = x', u / (1 + c u) du = -k x / m dx, whose
    # integral is the same before and after. Without gravity.
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
    # The steps end near the kink, not at it.
    assert_allclose(rebound, wanted, rtol=2e-6)


@pytest.mark.parametrize(("stiffness", "dt"), [(1e6, 1e-2), (1e8, 1e-2), (1e8, 1e-3), (1e11, 1e-3)])
def test_what_meets_within_a_step_may_be_stopped(stiffness, dt):
    # The impact takes pi sqrt(m / k), less than three steps: it is not resolved, and energy is only lost.
    robot = ball_on_floor(lissom.Prismatic((0, 0, 1)), stiffness=stiffness)
    result = lissom.simulate(robot, 2.0, dt=dt, q0=[0.6], method=STOPPED)
    assert result.success
    height = result.q[:, 0]
    assert height.min() > 0.1 - 1e-3
    assert_allclose(height[-1], 0.1 - G / stiffness, atol=1e-9)
    assert_allclose(robot.contact_forces(result.q[-1], result.v[-1]), [0, 0, 0, 0, 0, G], atol=1e-3)
    energy = np.array([robot.energy(q, v).total for q, v in zip(result.q, result.v, strict=True)])
    assert np.all(np.diff(energy) < 1e-3)
    landing = np.sqrt(2 * 0.5 / G)
    assert np.all(height[result.t > landing + 3 * dt] < 0.1 + 1e-6)


@pytest.mark.parametrize("method", ["newmark", "radau", "rk45", "dop853"])
def test_all_methods_find_the_bounces_that_they_resolve(method):
    robot = ball_on_floor(lissom.Prismatic((0, 0, 1)), stiffness=1e4, dissipation=0.3)
    ends = [
        lissom.simulate(robot, 1.0, dt=2e-4, q0=[0.4], method=method).q[-1, 0]
        for method in (method, "dop853")
    ]
    assert_allclose(ends[0], ends[1], atol=2e-4)


@pytest.mark.parametrize("speed", [10.0, 100.0])
def test_fast_balls_do_not_pass_through_a_floor(speed):
    robot = ball_on_floor(lissom.Prismatic((0, 0, 1)), stiffness=1e7)
    result = lissom.simulate(robot, 0.2, q0=[0.5], v0=[-speed])
    assert result.success
    assert result.q[:, 0].min() > 0.0
    assert abs(result.v[-1, 0]) <= speed


# Slopes


def slope(angle):
    return lissom.HalfSpace((0, 0, 0), (-np.sin(angle), 0, np.cos(angle)))


def block(angle, friction, **constants):
    """A ball with little rotation on a slope, and its equilibrium there: coordinates along x and along -z."""
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
    angle, speed = 0.5, 0.2
    robot, q0 = block(angle, mu)
    v0 = [-speed * np.cos(angle), speed * np.sin(angle), 0.0]
    result = lissom.simulate(robot, 1.0, dt=1e-3, q0=q0, v0=v0, method=method)
    assert result.success
    way = np.hypot(*(result.q[-1] - q0)[:2])
    assert_allclose(way, speed + 0.5 * G * (np.sin(angle) - mu * np.cos(angle)), rtol=2e-5)


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
    # The regularised law lets it slip by a part of the slip velocity.
    assert_allclose(way, 0.5 * G * np.sin(angle) / 1.4, rtol=1e-3)


# Rods


def rod_segment(length, **options):
    return lissom.Segment(length, radius=0.005, young_modulus=1e6, poisson_ratio=0.5, density=1000, **options)


def stiff_rod_on_floor(friction, length=0.4, radius=0.01, **options):
    """A rod with little bending on a floor; the coordinates are those of its base."""
    segment = lissom.Segment(
        length, radius=radius, young_modulus=1e7, poisson_ratio=0.3, density=1000, modes={"bend_y": 1}
    )
    link = lissom.Link("rod", joint=lissom.Free(), rod=[segment], position=(0, 0, radius))
    contact = lissom.Contact("rod", FLOOR, friction=friction, **options)
    return lissom.Robot([link], contacts=[contact])


@pytest.mark.parametrize(("direction", "which"), [((1, 0), 0), ((-1, 0), 1)])
def test_a_rod_slides_along_its_axis_with_the_friction_of_its_direction(direction, which):
    friction = (0.1, 0.2, 0.4)
    robot = stiff_rod_on_floor(friction)
    v0 = np.zeros(robot.n)
    v0[:2] = direction
    result = lissom.simulate(robot, 0.2, dt=5e-4, v0=v0)
    assert result.success
    wanted = np.array(direction) * (1 - friction[which] * G * 0.2)
    assert_allclose(result.v[-1, :2], wanted, atol=2e-3)


def test_friction_of_a_rod_points_where_its_coefficients_say():
    forward, _, sideways = friction = (0.1, 0.2, 0.4)
    robot = stiff_rod_on_floor(friction)
    q = np.zeros(robot.n)
    q[2] = -1e-6
    v = np.zeros(robot.n)
    v[:2] = [0.6, 0.8]
    wrench = robot.contact_forces(q, v)
    assert wrench[5] > 0
    assert_allclose(wrench[3:5] / wrench[5], [-forward * 0.6, -sideways * 0.8], rtol=1e-6)


def test_a_rod_that_slides_sideways_begins_to_roll():
    # A cylinder: 2 / 3 of its speed, independent of the friction.
    robot = stiff_rod_on_floor(0.3)
    v0 = np.zeros(robot.n)
    v0[1] = 1.0
    result = lissom.simulate(robot, 0.5, dt=5e-4, v0=v0)
    assert result.success
    velocity = robot.velocity(result.q[-1], result.v[-1], 0.2)
    assert_allclose(velocity[4], 2 / 3, rtol=5e-3)
    assert_allclose(velocity[0] * 0.01, -2 / 3, rtol=5e-3)


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_rods_that_collide_keep_their_momentum(friction):
    segment = lissom.Segment(
        0.5, radius=0.01, young_modulus=1e6, poisson_ratio=0.45, density=1000,
        modes={"bend_y": 4, "bend_z": 4, "torsion": 1},
    )  # fmt: skip
    turned = (np.sqrt(0.5), 0, 0, np.sqrt(0.5))
    links = [
        lissom.Link("a", joint=lissom.Free(), rod=[segment]),
        lissom.Link("b", joint=lissom.Free(), rod=[segment], position=(0.2, -0.2, 0.03), orientation=turned),
    ]
    contact = lissom.Contact("a", "b", friction=friction)
    robot = lissom.Robot(links, gravity=(0, 0, 0), contacts=[contact])
    v0 = np.zeros(robot.n)
    start = robot.slice("b").start
    v0[start : start + 3] = [0.3, 0.0, -1.0]
    drift = []
    for dt in (4e-4, 2e-4):
        result = lissom.simulate(robot, 0.1, dt=dt, v0=v0)
        assert result.success
        momentum = np.array([robot.momentum(q, v) for q, v in zip(result.q, result.v, strict=True)])
        size = np.abs(momentum).max()
        drift.append(np.abs(momentum - momentum[0]).max() / size)
        energy = np.array([robot.energy(q, v).total for q, v in zip(result.q, result.v, strict=True)])
        assert (energy - np.minimum.accumulate(energy)).max() < 2e-3 * energy[0]
        assert energy[-1] < 0.95 * energy[0]
        assert any(robot.touches(q) for q in result.q)
    # Drift of the method, which is of order 2.
    assert drift[1] < 1e-3
    assert drift[1] < 0.5 * drift[0]


def test_tangents_of_rods_that_cross_lack_the_error_of_the_quadrature_alone():
    segment = lissom.Segment(
        0.5, radius=0.01, young_modulus=1e6, poisson_ratio=0.45, density=1000,
        modes={"bend_y": 4, "bend_z": 4, "torsion": 1},
    )  # fmt: skip
    turned = (np.sqrt(0.5), 0, 0, np.sqrt(0.5))
    rng = np.random.default_rng(1)
    errors = []
    for distance in (0.0199, 0.019):
        place = (0.2, -0.2, distance)
        links = [
            lissom.Link("a", joint=lissom.Free(), rod=[segment]),
            lissom.Link("b", joint=lissom.Free(), rod=[segment], position=place, orientation=turned),
        ]
        contact = lissom.Contact("a", "b", friction=0.5, slip_velocity=0.05)
        robots = [lissom.Robot(links, gravity=(0, 0, 0), contacts=contacts) for contacts in ([contact], [])]
        n = robots[0].n
        q, v, a = 1e-4 * rng.normal(size=n), 0.05 * rng.normal(size=n), np.zeros(n)

        def forces(q, v, robots=robots, a=a):
            return robots[0].inverse_dynamics(q, v, a) - robots[1].inverse_dynamics(q, v, a)

        stiffness, damping, _ = (
            with_contact - without
            for with_contact, without in zip(*(robot.tangent(q, v, a) for robot in robots), strict=True)
        )
        h, units = 1e-7, np.eye(n)
        moved = np.transpose([(forces(q + h * e, v) - forces(q - h * e, v)) / (2 * h) for e in units])
        faster = np.transpose([(forces(q, v + h * e) - forces(q, v - h * e)) / (2 * h) for e in units])
        assert_allclose(damping, faster, atol=1e-7 * np.abs(faster).max())
        errors.append(np.abs(stiffness - moved).max() / np.abs(moved).max())
    # 5e-4 without the slide of nearest places.
    assert errors[0] < 2e-5
    assert errors[0] < 0.5 * errors[1]


def test_a_coil_touches_itself_where_a_helix_does():
    # A helix with constant strains: a closed form gives the nearest points of its turns.
    radius, curvature, torsion = 0.005, 40.0, 2.0
    length = 1.5 * 2 * np.pi / np.hypot(curvature, torsion)
    segment = lissom.Segment(
        length, radius=radius, young_modulus=1e6, poisson_ratio=0.5, density=1000,
        modes={"torsion": 1, "bend_y": 1}, nodes=24,
    )  # fmt: skip
    rod = lissom.Rod([segment], contacts=[lissom.Contact("rod", "rod", stiffness=1e4)])
    q = np.array([torsion, curvature])
    turn = np.hypot(curvature, torsion)
    a, b = curvature / turn**2, torsion / turn**2

    def distance(s):
        # Distance of points half of s before and behind one.
        return np.sqrt((2 * a * np.sin(turn * s / 2)) ** 2 + (b * turn * s) ** 2)

    nearest = minimize_scalar(
        distance, bounds=(0.7 * 2 * np.pi / turn, 1.1 * 2 * np.pi / turn), method="bounded"
    )
    touches = rod.touches(q)
    assert touches
    deepest = max(touches, key=lambda touch: touch.overlap)
    assert_allclose(deepest.overlap, 2 * radius - nearest.fun, rtol=1e-5)
    inner = [
        touch for touch in touches if 0.05 * length < min(touch.along) and max(touch.along) < 0.95 * length
    ]
    for touch in inner:
        assert_allclose(abs(touch.along[1] - touch.along[0]), nearest.x, rtol=1e-5)


def test_a_rod_clamped_above_a_floor_comes_to_rest_on_it():
    # Small slopes: a free length (72 EI h / w)^(1/4), then w l / 3 at a point, then w per metre.
    radius, length, height = 0.005, 0.6, 0.01
    segment = rod_segment(length, modes={"bend_y": 10})
    stiffness = np.pi / 4 * radius**4 * 1e6
    weight = 1000 * np.pi * radius**2 * G
    free = (72 * stiffness * height / weight) ** 0.25
    floor = lissom.Contact("rod", lissom.HalfSpace((0, 0, -height - radius), (0, 0, 1)))
    rod = lissom.Rod([segment] * 3, contacts=[floor])
    result = lissom.statics(rod)
    assert result.success, result.message
    force = rod.contact_forces(result.q, np.zeros_like(result.q))
    assert_allclose(force[5], weight * (rod.length - free) + weight * free / 3, rtol=5e-3)


@pytest.mark.filterwarnings("ignore:Impacts are shorter:lissom.AccuracyWarning")
def test_a_planar_robot_is_computed_as_in_space():
    floor = lissom.Contact("rod", lissom.HalfSpace((0, 0, -0.02), (0.1, 0, 1)), friction=0.4)
    rods = [
        lissom.Rod([rod_segment(0.3, modes={"bend_y": 3} | more)], contacts=[floor])
        for more in ({}, {"bend_z": 1})
    ]
    assert [rod.kernel for rod in rods] == ["planar", "spatial"]
    # Steps that resolve impacts choose their sizes: errors of these are larger.
    motions = [lissom.simulate(rod, 0.3, dt=1e-3, method=STOPPED) for rod in rods]
    assert all(motion.success for motion in motions)
    tips = [rod.pose(motion.q) for rod, motion in zip(rods, motions, strict=True)]
    # Up to the tolerance of Newton's method.
    assert_allclose(tips[0], tips[1], atol=1e-7)
    assert rods[0].touches(motions[0].q[-1])


def test_stepping_gives_the_bits_of_a_run_also_after_pickling():
    robot = stiff_rod_on_floor(0.3)
    v0 = np.zeros(robot.n)
    v0[:3] = [1.0, 0.5, -0.5]
    whole = lissom.simulate(robot, 0.05, dt=1e-3, v0=v0)
    stepped = lissom.Simulation(robot, dt=1e-3, v0=v0)
    for k in range(50):
        if k == 20:
            stepped = pickle.loads(pickle.dumps(stepped))
        stepped.step()
    np.testing.assert_array_equal(stepped.q, whole.q[-1])
    np.testing.assert_array_equal(stepped.v, whole.v[-1])


def test_starts_and_motions_in_which_surfaces_are_sunk_are_told():
    robot = ball_on_floor(lissom.Prismatic((0, 0, 1)), stiffness=1e4)
    with pytest.raises(ValueError, match="sunk into what it touches"):
        lissom.simulate(robot, 0.1, q0=[-0.05])
    soft = ball_on_floor(lissom.Prismatic((0, 0, 1)), stiffness=1.0)
    result = lissom.simulate(soft, 2.0, q0=[0.2])
    assert result.status == "deep_penetration"
    assert "stiffness" in result.message


def test_contacts_pickle_and_compare():
    contact = lissom.Contact("rod", lissom.Box((0, 0, -1), (1, 1, 0.5)), friction=(0.1, 0.2, 0.3))
    rod = lissom.Rod([rod_segment(0.3, modes={"bend_y": 3})], contacts=[contact])
    assert rod.contacts == (contact,)
    assert pickle.loads(pickle.dumps(rod)).contacts == (contact,)
    assert contact.name == "rod on box"


# Invalid arguments


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


# Impacts that steps do not resolve


def dropped(height=10.0, dissipation=0.0, stiffness=1e7, **ball):
    robot = ball_on_floor(lissom.Prismatic((0, 0, 1)), dissipation=dissipation, stiffness=stiffness, **ball)
    return robot, [height + 0.1]


def rod_on_its_end():
    segment = lissom.Segment(
        0.2, 0.01, modes={"stretch": 3}, young_modulus=1e8, poisson_ratio=0.4, density=1000.0
    )
    along = lissom.Link("rod", joint=lissom.Prismatic((1, 0, 0)), rod=[segment])
    floor = lissom.Contact("rod", lissom.HalfSpace((0, 0, 0), (1, 0, 0)), dissipation=0.0)
    return lissom.Robot([along], gravity=(-G, 0, 0), contacts=[floor]), [1.0, 0.0, 0.0, 0.0]


def many_balls():
    links = [lissom.Link(f"ball {i}", joint=lissom.Prismatic((0, 0, 1)), body=body()) for i in range(3)]
    contacts = [
        lissom.Contact(lissom.Ball(link.name, 0.1), FLOOR, stiffness=1e7, dissipation=0.0) for link in links
    ]
    return lissom.Robot(links, contacts=contacts), [1.0, 2.0, 3.0]


UNRESOLVED = "Impacts are shorter than steps of"
STOPPED = lissom.methods.Newmark(impacts="stopped")


@pytest.mark.parametrize("scene", [dropped, rod_on_its_end, many_balls])
def test_impacts_that_stop_what_should_rebound_are_doubted(scene):
    robot, q0 = scene()
    with pytest.warns(lissom.AccuracyWarning, match=UNRESOLVED):
        result = lissom.simulate(robot, 1.6, q0=q0, method=STOPPED)
    assert result.success
    assert result.message.endswith(result.doubt)
    with pytest.warns(lissom.AccuracyWarning, match=UNRESOLVED):
        many = lissom.simulate_many(robot, 1.6, q0=np.array([q0, q0]), method=STOPPED)
    assert many.doubt == (result.doubt, result.doubt)
    steps = lissom.Simulation(robot, dt=1e-2, q0=q0, method=STOPPED)
    assert steps.doubt is None
    steps.step(duration=1.6)
    assert steps.doubt == result.doubt
    assert steps.message.endswith(steps.doubt)
    assert steps.copy().doubt == pickle.loads(pickle.dumps(steps)).doubt == steps.doubt


@pytest.mark.parametrize("steps_of_impact", [2.9, 3.05, 3.2, 3.5])
def test_impacts_of_few_steps_that_lose_energy_are_doubted(steps_of_impact):
    """A ball without dissipation keeps its energy, in so few steps it loses a third."""
    fall, duration = 0.5, 0.01
    robot, q0 = dropped(fall, stiffness=(np.pi / duration) ** 2)
    dt = duration / steps_of_impact
    t = dt * np.round(1.8 * np.sqrt(2 * fall / G) / dt)

    def kept(motion):
        return (0.5 * motion.v[-1, 0] ** 2 + G * (motion.q[-1, 0] - 0.1)) / (G * fall)

    with pytest.warns(lissom.AccuracyWarning, match="Impacts take only a few steps") as caught:
        result = lissom.simulate(robot, t, q0=q0, dt=dt, method=STOPPED)
    assert kept(result) < 0.75
    said = float(re.search(r"J, (\d+) % of its largest", str(caught[0].message))[1]) / 100
    assert abs(said - (1 - kept(result))) < 0.1
    step = float(re.search(r"`dt=([\d.e-]+)`", result.doubt)[1])
    finer = lissom.simulate(robot, t, q0=q0, dt=step, method=STOPPED)
    assert finer.doubt is None
    assert kept(finer) == pytest.approx(1, abs=0.1)
    stepped = lissom.Simulation(robot, dt=dt, q0=q0, method=STOPPED)
    stepped.step(duration=t)
    assert stepped.doubt == result.doubt
    assert pickle.loads(pickle.dumps(stepped)).doubt == result.doubt


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.5, 0.75])
@pytest.mark.parametrize("steps_of_impact", [3.5, 4, 5, 6, 7, 10, 16])
def test_losses_that_nothing_explains_are_doubted(steps_of_impact, phase):
    """A ball without dissipation and without weight comes back as fast as it came."""
    dt, speed = 1e-2, 2.0
    stiffness = (np.pi / (steps_of_impact * dt)) ** 2
    ball = lissom.Link("ball", joint=lissom.Prismatic((0, 0, 1)), body=body(1.0))
    floor = lissom.Contact(lissom.Ball("ball", 5.0), FLOOR, stiffness=stiffness, dissipation=0.0)
    robot = lissom.Robot([ball], contacts=[floor], gravity=(0, 0, 0))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lissom.AccuracyWarning)
        start = {"q0": [5.3 + phase * dt * speed], "v0": [-speed]}
        motion = lissom.simulate(robot, 1.0, dt=dt, **start, method=STOPPED)
    lost = 1 - (motion.v[-1, 0] / speed) ** 2
    assert lost < 0.06 or motion.doubt
    assert steps_of_impact < 10 or motion.doubt is None


def test_steps_without_memory_have_the_impulse_of_a_load():
    """A ball is pushed out of the floor; beside it a force pushes a weight on a rail for a few steps."""
    dt, stroke = 1e-3, 2e-3
    links = [
        lissom.Link("ball", joint=lissom.Prismatic((0, 0, 1)), body=body()),
        lissom.Link("weight", joint=lissom.Prismatic((1, 0, 0)), body=lissom.Body(2.0)),
    ]
    floor = lissom.Contact(lissom.Ball("ball", 0.1), FLOOR, stiffness=1e8, dissipation=0.0)
    for times, values in (
        ([0, dt, stroke], [0, 300, 0]),
        ([0, 0.3 * dt, dt], [0, 300, 0]),
        ([0, 1e-9, stroke, stroke + 1e-9], [0, 300, 300, 0]),
        ([0, stroke], [0, 300]),
    ):
        load = lissom.Load(force=(times, np.outer(values, (1, 0, 0))), link="weight")
        robot = lissom.Robot(links, contacts=[floor], loads=[load])
        impulse = np.trapezoid(values, times)
        for start in (0.099, 0.1003):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", lissom.AccuracyWarning)
                run = lissom.simulate(robot, 3 * dt, q0=[start, 0], v0=[-1, 0], dt=dt, method=STOPPED)
            assert run.success
            assert_allclose(run.v[-1, 1], (impulse + (dt * 300 if len(values) == 2 else 0)) / 2.0, rtol=1e-6)


def test_the_doubt_names_the_impact_its_energy_and_a_step_that_resolves_it():
    robot, q0 = dropped(stiffness=1e8)
    with pytest.warns(lissom.AccuracyWarning, match=UNRESOLVED):
        doubt = lissom.simulate(robot, 2.0, dt=5e-3, q0=q0, method=STOPPED).doubt
    energy, percent, at = (
        float(re.search(pattern, doubt).group(1))
        for pattern in (r"loses ([\d.e+]+) J", r"([\d.]+) % of", r"contacts\[0\] at t = ([\d.]+) s")
    )
    assert_allclose(energy, 10 * G, rtol=0.02)
    assert_allclose(percent, 100, atol=2)
    assert_allclose(at, np.sqrt(20 / G), atol=6e-3)
    dt = float(re.search(r"`dt=([\d.e-]+)`", doubt).group(1))
    # Twenty steps of an impact that takes pi sqrt(m / k).
    assert_allclose(dt, np.pi * 1e-4 / 20, rtol=0.05)
    remedied = lissom.simulate(robot, 1.45, dt=dt, q0=q0, method=STOPPED)
    assert remedied.doubt is None
    assert remedied.v[-1, 0] > 0.9 * np.sqrt(20 * G)
    assert lissom.simulate(robot, 1.45, method="radau", q0=q0).v[-1, 0] > 0.9 * np.sqrt(20 * G)


@pytest.mark.parametrize(
    ("stiffness", "dissipation", "height"), [(1e4, 0.0, 1.0), (1e8, 10.0, 1.0), (1e8, 1.0, 10.0)]
)
def test_impacts_that_are_resolved_or_do_not_rebound_anyway_are_not_doubted(stiffness, dissipation, height):
    robot, q0 = dropped(height, dissipation, stiffness)
    assert lissom.simulate(robot, 3.0, dt=1e-3, q0=q0, method=STOPPED).doubt is None


def beside(robot, q0, other):
    """The same robot with another link that moves by itself, and how both begin."""
    links = [*robot.links, other]
    more = lissom.Robot(links, contacts=robot.contacts, gravity=robot.gravity)
    return more, [*q0, *[0.0] * (more.n - robot.n)]


HEAVY = lissom.Link("heavy", joint=lissom.Prismatic((1, 0, 0)), body=lissom.Body(1e3), position=(0, 5, 0))
FALLING = lissom.Link("falling", joint=lissom.Prismatic((0, 0, 1)), body=lissom.Body(1e3), position=(0, 5, 0))
FLYWHEEL = lissom.Link("wheel", joint=lissom.Revolute((1, 0, 0)), body=body(1e3), position=(0, 5, 0))


@pytest.mark.parametrize("other", [HEAVY, FALLING, FLYWHEEL], ids=lambda link: link.name)
@pytest.mark.parametrize("options", [{}, {"rho_inf": 0.8}], ids=["default", "alpha"])
@pytest.mark.parametrize("stiffness", [1e8, (np.pi / 0.032) ** 2], ids=["within a step", "in a few steps"])
def test_impacts_are_doubted_beside_what_takes_no_part(stiffness, options, other):
    """Whatever moves beside a ball, and however much energy it has."""
    method = lissom.methods.Newmark(impacts="stopped", **options)
    robot, q0 = dropped(1.0, stiffness=stiffness)
    more, q0_more = beside(robot, q0, other)
    start = {"q0": q0_more, "v0": [0.0, 100.0]}
    with pytest.warns(lissom.AccuracyWarning, match="Impacts"):
        alone = lissom.simulate(robot, 0.8, dt=0.01, q0=q0, method=method)
    with pytest.warns(lissom.AccuracyWarning, match="Impacts"):
        found = lissom.simulate(more, 0.8, dt=0.01, **start, method=method)
    assert_allclose(found.q[:, 0], alone.q[:, 0], atol=1e-6)
    percents = [int(re.search(r"J, (\d+) % of", doubt)[1]) for doubt in (found.doubt, alone.doubt)]
    assert abs(percents[0] - percents[1]) <= 2
    assert other is FALLING or found.doubt == alone.doubt
    if not options:
        stepped = lissom.Simulation(more, dt=0.01, **start, method=method)
        stepped.step(duration=0.8)
        assert stepped.doubt == found.doubt
    # Warnings are errors here: impacts of thirty steps are no reason to doubt.
    duration = np.pi / np.sqrt(stiffness)
    start = {"q0": [0.1, 0], "v0": [-4.4, 100.0]}
    finer = lissom.simulate(more, 4 * duration, dt=duration / 30, **start, method=method)
    assert finer.doubt is None


def test_default_names_of_contacts_do_not_collide():
    links = [lissom.Link("b", body=lissom.Body(1.0, inertia=(1e-3,) * 3), joint=lissom.Free())]
    floor, wall = lissom.HalfSpace((0, 0, -1)), lissom.HalfSpace((0, 1, 0), (0, -1, 0))

    def contact(ground, **more):
        return lissom.Contact(lissom.Ball("b", 0.1), ground, stiffness=1e3, **more)

    given = [contact(floor), contact(wall), contact(floor, name="b on halfspace 2"), contact(floor, name="c")]
    robot = lissom.Robot(links, contacts=given)
    names = ["b on halfspace", "b on halfspace 3", "b on halfspace 2", "c"]
    assert [each.name for each in robot.contacts] == names
    for again in (lissom.Robot(links, contacts=robot.contacts), pickle.loads(pickle.dumps(robot))):
        assert [each.name for each in again.contacts] == names
    q = [0, 0, -0.95, 0, 0, 0]
    assert {touch.contact for touch in robot.touches(q)} == {names[0], names[2], names[3]}
    with pytest.raises(ValueError, match=r'contacts\[1\].name: got "c", the name of another contact'):
        lissom.Robot(links, contacts=[contact(floor, name="c"), contact(wall, name="c")])
    segment = lissom.Segment(0.3, 0.01, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 1})
    rod = lissom.Rod([segment], contacts=[lissom.Contact("rod", floor), lissom.Contact("rod", wall)])
    assert [each.name for each in rod.contacts] == ["rod on halfspace", "rod on halfspace 2"]
