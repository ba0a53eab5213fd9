"""Equilibria in stiff contact: closed forms, and numbers of tangents that hardly depend on the stiffness."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp
from scipy.spatial.transform import Rotation

import lissom

G = 9.81

# Tangents of a search for bodies on floors, whatever their stiffness is.
MOST = 60

STIFFNESSES = [1e3, 1e5, 1e7, 1e9, 1e11, 1e12]


def ball(stiffness, length=1.0, beside=()):
    """A ball of 1 kg above a floor, in units in which a metre is this long."""
    inertia = np.eye(3) * 4e-3 * length**2
    link = lissom.Link(
        "b", joint=lissom.Free(), body=lissom.Body(1.0, inertia=inertia), position=(0, 0, length)
    )
    contact = lissom.Contact(lissom.Ball("b", 0.1 * length), lissom.HalfSpace(), stiffness=stiffness)
    robot = lissom.Robot([link, *beside], contacts=[contact], gravity=(0, 0, -G * length))
    return robot, np.r_[np.array([0.1, 0.2, -0.3]) * length, 0, 0, 0.5]


def overlaps(robot, q):
    """Overlaps of all that touches."""
    return np.array([touch.overlap for touch in robot.touches(q, np.zeros(robot.n))])


@pytest.mark.parametrize("stiffness", STIFFNESSES)
def test_ball_on_a_floor(stiffness):
    robot, q0 = ball(stiffness)
    found = lissom.statics(robot, q0)
    assert found.success, found.message
    assert found.njev <= MOST
    # The height of the ball is rounded to 1e-16 m.
    np.testing.assert_allclose(overlaps(robot, found.q), G / stiffness, rtol=1e-9, atol=2.3e-16)


@pytest.mark.parametrize("stiffness", STIFFNESSES)
def test_body_on_a_ball_joint_leans_on_a_floor(stiffness):
    """The centre of mass is at 0.6 of the length: the floor carries 0.6 of the weight at any slope."""
    body = lissom.Body(2.0, centre=(0.3, 0, 0), inertia=np.eye(3) * 0.05)
    links = [
        lissom.Link("bar", joint=lissom.Spherical(), body=body),
        lissom.Link("tip", parent="bar", position=(0.5, 0, 0)),
    ]
    floor = lissom.HalfSpace((0, 0, -0.3))
    robot = lissom.Robot(
        links, contacts=[lissom.Contact(lissom.Ball("tip", 0.1), floor, stiffness=stiffness)]
    )
    found = lissom.statics(robot, [0.4, -0.9, 0.3])
    assert found.success, found.message
    assert found.njev <= MOST
    np.testing.assert_allclose(overlaps(robot, found.q), 0.6 * 2 * G / stiffness, rtol=1e-6, atol=1e-15)


@pytest.mark.parametrize("stiffness", STIFFNESSES)
def test_two_balls_on_each_other(stiffness):
    rail = lissom.Prismatic((0, 0, 1))
    links = [
        lissom.Link("low", joint=rail, body=lissom.Body(1.0), position=(0, 0, 0.3)),
        lissom.Link("high", joint=rail, body=lissom.Body(2.0), position=(0, 0, 0.8)),
    ]
    low, high = lissom.Ball("low", 0.1), lissom.Ball("high", 0.1)
    contacts = [
        lissom.Contact(low, lissom.HalfSpace(), stiffness=stiffness),
        lissom.Contact(high, low, stiffness=stiffness),
    ]
    robot = lissom.Robot(links, contacts=contacts)
    found = lissom.statics(robot, [0.0, 0.0])
    assert found.success, found.message
    assert found.njev <= 140
    np.testing.assert_allclose(
        sorted(overlaps(robot, found.q)), np.array([2, 3]) * G / stiffness, rtol=1e-9, atol=5e-16
    )


def test_units_and_a_heavy_part_beside_do_not_matter():
    plain, q0 = ball(1e8)
    numbers = [lissom.statics(plain, q0).njev]
    small, q_small = ball(1e8, length=1e3)
    found = lissom.statics(small, q_small)
    assert found.success
    np.testing.assert_allclose(overlaps(small, found.q), 1e3 * G / 1e8, rtol=1e-7)
    numbers.append(found.njev)
    sprung = lissom.Prismatic((0, 0, 1), stiffness=1e9)
    heavy = lissom.Link("heavy", joint=sprung, body=lissom.Body(1e6), position=(50, 0, 0))
    both, q_both = ball(1e8, beside=[heavy])
    found = lissom.statics(both, np.r_[q_both, 0.0])
    assert found.success
    np.testing.assert_allclose(overlaps(both, found.q), G / 1e8, rtol=1e-7)
    numbers.append(found.njev)
    assert max(numbers) <= min(numbers) + 8, numbers


def cable(height, obstacles, stiffness=None):
    """A cable from a clamp, of the length over which it bends seven times under its weight."""
    radius, young = 5e-3, 5e7
    weight, bending = 1500 * G * np.pi * radius**2, young * np.pi * radius**4 / 4
    length = 7 * (bending / weight) ** (1 / 3)
    segment = lissom.Segment(
        length / 4,
        radius=radius,
        young_modulus=young,
        poisson_ratio=0.4,
        density=1500,
        modes={"torsion": 2, "bend_y": 4, "bend_z": 4},
    )
    law = {} if stiffness is None else {"stiffness": stiffness}
    contacts = [
        lissom.Contact("rod", obstacle, name=f"o{i}", **law) for i, obstacle in enumerate(obstacles(length))
    ]
    robot = lissom.Robot(
        [lissom.Link("rod", rod=[segment] * 4, position=(0, height * length, 0))], contacts=contacts
    )
    return robot, length


def floor(length):
    return [lissom.HalfSpace((0, 0, -0.15 * length))]


def edge(length):
    return [lissom.Box((1.625 * length, 0, -0.25 * length), (1.375 * length, length, 0.15 * length))]


@pytest.mark.parametrize("obstacles", [floor, edge])
def test_cables_of_the_stiffness_of_their_material(obstacles):
    stiff, length = cable(0.0, obstacles, stiffness="material")
    found = lissom.statics(stiff)
    assert found.success, found.message
    assert found.njev <= 120
    # An independent way to it: from a shape of soft contacts, by Newton's method.
    soft, _ = cable(0.0, obstacles, stiffness=1e6)
    shape = lissom.statics(soft).q
    for stiffness in (4e6, 1.6e7):
        nearby, _ = cable(0.0, obstacles, stiffness=stiffness)
        shape = lissom.statics(nearby, shape, method="newton").q
    shape = lissom.statics(stiff, shape, method="newton").q
    places = np.linspace(0, length, 50)
    here, there = (stiff.pose(q, places, link="rod")[:, :3, 3] for q in (found.q, shape))
    assert np.abs(here - there).max() < 1e-6 * length
    assert 0 < overlaps(stiff, found.q).max() < 1e-3 * 5e-3


@pytest.mark.parametrize("beside", [None, 1.0, 10.0, 1e4])
def test_body_that_swings_clear_of_the_floor(beside):
    """It touches the floor on the way while contacts are soft, and hangs clear of it in the end."""
    body = lissom.Body(0.73, centre=(0.3, 0, 0), inertia=np.eye(3) * 0.0365)
    links = [
        lissom.Link("bar", joint=lissom.Spherical(), body=body),
        lissom.Link("tip", parent="bar", position=(0.6, 0, 0), body=lissom.Body(0.0073)),
    ]
    if beside:
        heavy = lissom.Body(beside, centre=(beside, 0, 0), inertia=np.eye(3) * beside)
        joint = lissom.Revolute((0, 1, 0), stiffness=1e6 * beside)
        links.append(lissom.Link("other", position=(0, 50, 0), joint=joint, body=heavy))
    path = [lissom.Via(None, (0.3, 0.4, 0.8)), lissom.Via("tip", (0, 0, 0))]
    floor = lissom.HalfSpace((0, 0, -0.28), (-0.425, 0.182, 1))
    robot = lissom.Robot(
        links,
        contacts=[lissom.Contact(lissom.Ball("tip", 0.139), floor, stiffness=3.56e8)],
        actuators=[lissom.Tendon("t", path, length=0.8, stiffness=219.3)],
    )
    q0 = np.zeros(robot.n)
    q0[:3] = [-0.16, -0.192, 0.4524]
    found = lissom.statics(robot, q0)
    assert found.success, found.message
    assert found.njev <= MOST
    assert not robot.touches(found.q, np.zeros(robot.n))
    # Without a floor, the same height of the tip.
    free = lissom.Robot(links, actuators=robot.actuators)
    height = [lissom.statics(free, q0).q, found.q]
    height = [free.pose(q, link="tip")[2, 3] for q in height]
    np.testing.assert_allclose(*height, rtol=1e-6)


def test_two_bars_that_fall_onto_floor_and_ball():
    """Soft contacts lead deep into the ball, and the way to equilibrium with less soft ones is long."""
    body = lissom.Body(0.7, centre=(0.2, 0, 0), inertia=np.eye(3) * 0.014)
    hinge, sprung = lissom.Revolute((0, 1, 0)), lissom.Revolute((0, 1, 0), stiffness=0.1)
    links = [
        lissom.Link("a", joint=hinge, body=body),
        lissom.Link("c", parent="a", position=(0.4, 0, 0), joint=sprung, body=body),
        lissom.Link("tip", parent="c", position=(0.4, 0, 0), body=lissom.Body(0.007)),
    ]
    tip, stiffness = lissom.Ball("tip", 0.0369), 7.23e10
    floor = lissom.HalfSpace((0, 0, -0.2429), (0.0984, -0.0337, 1))
    ball = lissom.Sphere((0.5, 0.1, -0.4429), 0.25)
    robot = lissom.Robot(
        links, contacts=[lissom.Contact(tip, each, stiffness=stiffness) for each in (floor, ball)]
    )
    found = lissom.statics(robot, [-0.155, -0.319], max_iter=300)
    assert found.success, found.message
    assert found.njev <= 150
    assert overlaps(robot, found.q).max(initial=0.0) < 1e-9


# Two ropes between clamps, one across the other.
LENGTH, CHORD, RADIUS, YOUNG_MODULUS, DENSITY = 1.0, 0.9, 5e-3, 1e6, 1000.0
WEIGHT = DENSITY * G * np.pi * RADIUS**2
BENDING = YOUNG_MODULUS * np.pi * RADIUS**4 / 4


def hanging_elastica(force):
    """Half of an inextensible elastica between clamps, under its weight and a force down at its middle.

    E I theta'' = H sin(theta) + V cos(theta), where H is the horizontal tension and V what hangs below.
    """
    s = np.linspace(0, LENGTH / 2, 101)
    turn = 2 * np.pi / LENGTH
    guess = [s * CHORD / LENGTH, -0.1 * (1 - np.cos(turn * s)), -0.4 * np.sin(turn * s)]
    guess, tension = [*guess, -0.4 * turn * np.cos(turn * s)], [0.8 * WEIGHT]

    def ends(a, b, _):
        return [a[0], a[1], a[2], b[2], b[0] - CHORD / 2]

    for part in (0.0, 0.5, 1.0):

        def slopes(s, y, tension, part=part):
            below = 0.5 * part * force + WEIGHT * (LENGTH / 2 - s)
            bend = (tension[0] * np.sin(y[2]) + below * np.cos(y[2])) / BENDING
            return [np.cos(y[2]), np.sin(y[2]), y[3], bend]

        found = solve_bvp(slopes, ends, s, guess, p=tension, tol=1e-8, max_nodes=20000)
        assert found.success, found.message
        s, guess, tension = found.x, found.y, found.p
    return found.sol


def clamped_rope(name, height, segments):
    """A rope along the x axis, or across it if it is the lower one, and the loop that clamps its end."""
    h = np.sqrt(0.5)
    turned = (h, 0, 0, h) if name == "lower" else (1, 0, 0, 0)
    start = np.array((0, -CHORD / 2, height) if name == "lower" else (-CHORD / 2, 0, height))
    segment = lissom.Segment(
        LENGTH / segments,
        RADIUS,
        YOUNG_MODULUS,
        poisson_ratio=0.5,
        density=DENSITY,
        modes={"torsion": 1, "bend_y": 4, "bend_z": 4},
    )
    link = lissom.Link(name, rod=[segment] * segments, position=start, orientation=turned)
    return link, lissom.Loop((name,), (None, None, start * (-1, -1, 1), turned), lissom.Weld(), name=name)


def crossing_ropes(height, segments):
    """The upper rope lies on the lower one, whose clamps are at this height over those of the upper one."""
    ropes = clamped_rope("upper", 0, segments), clamped_rope("lower", height, segments)
    links, loops = zip(*ropes, strict=True)
    contact = lissom.Contact("upper", "lower", stiffness=1e7)
    return lissom.Robot(links, loops=loops, contacts=[contact])


@pytest.mark.parametrize("share", [0.05, 0.15])
def test_ropes_that_cross_against_two_elasticas(share):
    """A force of that share of the weight between the ropes bends them to shapes two radii apart."""
    force = share * WEIGHT * LENGTH
    shapes = {"upper": hanging_elastica(-force), "lower": hanging_elastica(force)}
    sags = {name: -shape(LENGTH / 2)[1] for name, shape in shapes.items()}
    height = sags["lower"] - sags["upper"] - 2 * RADIUS
    start = []
    for name, more in (("upper", 1.5 * force), ("lower", -1.5 * force)):
        link, loop = clamped_rope(name, 0.0, 8)
        load = lissom.Load(link=name, at=LENGTH / 2, force=(0, 0, more))
        start.append(lissom.statics(lissom.Robot([link], loops=[loop], loads=[load])).q)
    robot = crossing_ropes(height, 8)
    found = lissom.statics(robot, np.concatenate(start))
    assert found.success, found.message
    assert found.stability == "stable"
    s = np.linspace(0, LENGTH / 2, 21)
    for name, (across, z) in {"upper": (0, 0.0), "lower": (1, height)}.items():
        x, depth = shapes[name](s)[:2]
        places = robot.pose(found.q, s, link=name)[:, :3, 3]
        np.testing.assert_allclose(places[:, across], x - CHORD / 2, atol=1e-4 * LENGTH)
        np.testing.assert_allclose(places[:, 2], z + depth, atol=1e-4 * LENGTH)


def test_a_refused_step_is_not_tried_again():
    """Its length over the radius is rounded: the search for this shape did not end."""
    found = lissom.statics(crossing_ropes(-0.003579879015462214, 4))
    assert found.success, found.message
    assert found.nit <= 100


@pytest.mark.parametrize("start", [(2.9, 0, 0), (2.9, 0.1, 0.05), (2.0, 0.1, 0.05)])
@pytest.mark.parametrize("seed", [None, 1, 2])
def test_a_hanging_arm_may_be_turned_by_pi(start, seed):
    """A capsule hangs on a ball joint that is turned by pi there; a ball on a spring goes past it.

    Rotation vectors change by 2 pi on the way, which is no turn of the capsule.
    """
    spring, rest = 300.0, 0.15
    turn = Rotation.identity() if seed is None else Rotation.random(random_state=seed)
    place = np.zeros(3) if seed is None else np.array([3.0, -8.0, 5.0])
    x, y, z, w = turn.as_quat()
    frame = lissom.Link("frame", position=place, orientation=(w, x, y, z))
    arm = lissom.Body(1.0, centre=(0, 0, 0.7), inertia=(0.01, 0.01, 0.002))
    rail = lissom.Prismatic((0, 1, 0), stiffness=spring, rest=rest)
    links = [
        frame,
        lissom.Link("arm", parent="frame", joint=lissom.Spherical(), body=arm),
        lissom.Link("ball", parent="frame", joint=rail, position=(0, 0, -0.8), body=lissom.Body(0.1)),
    ]
    capsule = lissom.Capsule((0, 0, 0), (0, 0, 1), 0.05, link="arm")
    contact = lissom.Contact(lissom.Ball("ball", 0.06), capsule, stiffness=1e5)
    robot = lissom.Robot(links, contacts=[contact], gravity=turn.apply((0, 0, -G)))
    found = lissom.statics(robot, [*start, -0.45])
    assert found.success, found.message

    direction = turn.inv().apply(robot.pose(found.q, link="arm")[:3, 2])
    np.testing.assert_allclose(direction, (0, 0, -1), rtol=0, atol=1e-7)
    assert found.q[3] == pytest.approx(rest, abs=1e-8)
    assert found.stability == "neutral"


def pushed_plate(seed, unit, turn, place):
    """A plate about a ball joint in its middle, and a ball on a spring rail that stays within its reach.

    Also the start (the plate turned by 2.2 to pi), middle and direction of the rail, and side of the ball.
    """
    random = np.random.default_rng(seed)
    thickness, radius = 10 ** random.uniform(-2, -1.2), random.uniform(0.04, 0.1)
    centre, gravity = random.normal(size=3) * 0.2, random.normal(size=3) * 6
    spring, stiffness = 10 ** random.uniform(1, 4), 10 ** random.uniform(5.6, 7)
    axis, middle = random.normal(size=3), np.zeros(3)
    axis /= np.linalg.norm(axis)
    while not radius + thickness + 0.12 < np.linalg.norm(middle) < 0.6:
        middle = random.normal(size=3) * 0.4
        middle -= axis * (axis @ middle)
    start, rest = random.uniform(-1, 1, 2) * np.sqrt(0.9**2 - middle @ middle)
    while True:
        vector = random.normal(size=3)
        vector *= random.uniform(2.2, np.pi) / np.linalg.norm(vector)
        height = Rotation.from_rotvec(vector).apply([0, 0, 1]) @ (middle + axis * start)
        if abs(height) > radius + thickness + 0.01:
            break
    x, y, z, w = turn.as_quat()
    rail = lissom.Prismatic(axis, stiffness=spring, rest=rest * unit)
    body = lissom.Body(1.0, centre=centre * unit, inertia=np.diag([1, 1, 2]) * unit**2)
    links = [
        lissom.Link("frame", position=place * unit, orientation=(w, x, y, z)),
        lissom.Link("plate", parent="frame", joint=lissom.Spherical(), body=body),
        lissom.Link("ball", parent="frame", joint=rail, position=middle * unit, body=lissom.Body(0.2)),
    ]
    plate = lissom.Box((0, 0, 0), np.array([2, 2, thickness]) * unit, link="plate")
    contact = lissom.Contact(lissom.Ball("ball", radius * unit), plate, stiffness=stiffness)
    robot = lissom.Robot(links, contacts=[contact], gravity=turn.apply(gravity) * unit)
    return robot, [*vector, start * unit], middle, axis, np.sign(height)


@pytest.mark.parametrize("seed", [15, 110, 127, 142, 154, 196, 198, 273])
@pytest.mark.parametrize("unit", [1.0, 1e3, 1e-3])
@pytest.mark.parametrize("turned", [None, 5])
def test_a_ball_stays_on_its_side_of_a_plate(seed, unit, turned):
    """Nothing but the plate is in its way, and the edges of the plate are out of its reach."""
    turn = Rotation.identity() if turned is None else Rotation.random(random_state=turned)
    place = np.zeros(3) if turned is None else np.array([3.0, -8.0, 5.0])
    robot, start, middle, axis, side = pushed_plate(seed, unit, turn, place)
    found = lissom.statics(robot, start)
    assert found.success, found.message
    normal = Rotation.from_rotvec(np.array(found.q[:3])).apply([0, 0, 1])
    assert side * (normal @ (middle + axis * found.q[3] / unit)) > 0
