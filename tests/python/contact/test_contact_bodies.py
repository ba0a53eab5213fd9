"""Contact between boxes, capsules and meshes, and with hilly ground."""

import itertools
import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import lissom
from lissom import Body, Box, Capsule, Contact, ConvexMesh, Free, HeightField, Link

GRAVITY = 9.81
STIFFNESS = 1e5
TETRAHEDRON = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / math.sqrt(3)
TETRAHEDRON_FACES = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
OCTAHEDRON = np.vstack([np.eye(3), -np.eye(3)])
CUBE = np.array(list(itertools.product((-1, 1), repeat=3)), dtype=float)
CUBE_FACES = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
CUBE_FACES += [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
OCTAHEDRON_FACES = [[x, y, z] for x in (0, 3) for y in (1, 4) for z in (2, 5)]


def turned(rotation):
    """A quaternion as lissom writes it."""
    return tuple(rotation.as_quat(scalar_first=True))


def cuboid(mass, half):
    """A homogeneous box as a rigid body."""
    squares = np.square(half)
    return Body(mass, inertia=mass / 3 * (squares.sum() - squares))


def free(name, half, mass=0.5, **place):
    """A box as a free body."""
    return Link(name, joint=Free(), body=cuboid(mass, half), **place)


def box(name, half):
    return Box((0, 0, 0), half, link=name)


def held(link, surface, below, *, friction=0.3):
    """Touches of a body placed on what is below it, after some time at rest."""
    contact = Contact(surface, below, stiffness=STIFFNESS, friction=friction)
    robot = lissom.Robot([link], contacts=[contact])
    run = lissom.simulate(robot, 0.3, dt=1e-3)
    assert run.success, run.message
    assert abs(run.q).max() < 1e-8
    force = robot.contact_forces(run.q[-1], run.v[-1])[3:] / (0.5 * GRAVITY)
    assert_allclose(force, [0, 0, 1], atol=1e-6)
    return robot.touches(run.q[-1], run.v[-1])


# Rest


@pytest.mark.parametrize("sizes", [[1.0, 1.0, 1.0], [1.2, 1.0, 0.8]])
def test_boxes_on_boxes_carry_their_weight_and_stay(sizes):
    """Three boxes on a fixed one, flush or not: forces equal weights, and nothing drifts for a second."""
    half, weight = np.array([0.05, 0.04, 0.03]), 0.5 * GRAVITY
    names, links, height = ["low", "middle", "high"], [], 0.0
    surfaces = [Box((0, 0, -0.1), (0.3, 0.3, 0.1))]
    for i, (name, size) in enumerate(zip(names, sizes, strict=True)):
        # Four corners and four edges press, and as many below them if boxes are flush.
        places = 16 if i > 0 and size == sizes[i - 1] else 8
        height -= (3 - i) * weight / (places * STIFFNESS)
        links.append(free(name, size * half, position=(0, 0, height + size * 0.03)))
        surfaces.append(box(name, size * half))
        height += 2 * size * 0.03
    contacts = [
        Contact(upper, lower, name=f"on {i}", stiffness=STIFFNESS, friction=0.5)
        for i, (lower, upper) in enumerate(itertools.pairwise(surfaces))
    ]
    robot = lissom.Robot(links, contacts=contacts)
    run = lissom.simulate(robot, 1.0, dt=1e-3)
    assert run.success, run.message
    for i in range(3):
        force = robot.contact_forces(run.q[-1], run.v[-1], name=f"on {i}")[3:]
        assert_allclose(force, [0, 0, (3 - i) * weight], atol=1e-6 * weight)
    assert abs(run.q).max() < 1e-8
    for touch in robot.touches(run.q[-1], run.v[-1]):
        assert abs(touch.normal[2]) == pytest.approx(1.0, abs=1e-9)


def test_capsules_cross():
    """The force acts where the axes cross, half of it from each of the two."""
    down = 0.5 * GRAVITY / (2 * STIFFNESS)
    link = free("bar", (0.02, 0.1, 0.02), position=(0, 0, 0.04 - down))
    upper = Capsule((0, -0.1, 0), (0, 0.1, 0), 0.02, link="bar")
    touches = held(link, upper, Capsule((-0.1, 0, 0), (0.1, 0, 0), 0.02))
    assert len(touches) == 2
    for touch in touches:
        assert touch.overlap == pytest.approx(down, rel=1e-6)
        assert_allclose(touch.position, [0, 0, 0.02], atol=2 * down)


def test_a_capsule_lies_across_a_box():
    """Its middle presses on the upper face, and two upper edges of the box press on it."""
    down = 0.5 * GRAVITY / (3 * STIFFNESS)
    link = free("bar", (0.02, 0.1, 0.02), position=(0, 0, 0.02 - down))
    bar = Capsule((0, -0.1, 0), (0, 0.1, 0), 0.02, link="bar")
    touches = held(link, bar, Box((0, 0, -0.05), (0.05, 0.05, 0.05)))
    assert_allclose(sorted(touch.position[1] for touch in touches), [-0.05, 0.0, 0.05], atol=1e-3)


@pytest.mark.parametrize(
    ("points", "faces", "downwards"),
    [(TETRAHEDRON, TETRAHEDRON_FACES, -TETRAHEDRON[3]), (OCTAHEDRON, OCTAHEDRON_FACES, [1, 1, 1])],
)
def test_meshes_lie_on_boxes(points, faces, downwards):
    """A mesh lies on one of its faces, in contact by three corners and three edges."""
    turn, _ = Rotation.align_vectors([[0, 0, -1]], [downwards])
    points = turn.apply(0.06 * np.asarray(points, float))
    down = 0.5 * GRAVITY / (6 * STIFFNESS)
    link = free("mesh", (0.04,) * 3, position=(0, 0, -points[:, 2].min() - down))
    touches = held(link, ConvexMesh(points, faces, link="mesh"), Box((0, 0, -0.1), (0.3, 0.3, 0.1)))
    assert len(touches) == 6
    assert_allclose([touch.overlap for touch in touches], down, rtol=1e-4)


@pytest.mark.filterwarnings("ignore:Impacts are shorter:lissom.AccuracyWarning")
def test_a_box_stands_on_the_edge_of_a_table_up_to_its_middle():
    """It tips when its centre of mass passes the edge, which is rounded by 0.04 of 20 mm."""
    half = (0.05, 0.04, 0.02)
    table = Box((-0.2, 0, -0.1), (0.2, 0.3, 0.1))

    def tilt(x):
        link = free("box", half, position=(x, 0, 0.02 - 0.5 * GRAVITY / (4 * STIFFNESS)))
        contact = Contact(box("box", half), table, stiffness=STIFFNESS, friction=0.5)
        robot = lissom.Robot([link], contacts=[contact])
        run = lissom.simulate(robot, 0.4, dt=1e-3)
        assert run.success, run.message
        return robot.pose(run.q[-1], link="box")[2, 2]

    assert tilt(-0.002) > 1 - 1e-4
    assert tilt(0.0005) < 0.99


# Motion


@pytest.mark.parametrize("friction", [0.2, 0.5])
def test_a_box_slides_on_a_box_or_creeps(friction):
    """On a slope of 0.3 rad."""
    angle, half = 0.3, (0.05, 0.04, 0.02)
    turn = Rotation.from_rotvec([0, angle, 0])
    down = 0.5 * GRAVITY * math.cos(angle) / (8 * STIFFNESS)
    link = free("box", half, position=tuple(turn.apply([-0.8, 0, 0.02 - down])), orientation=turned(turn))
    slope = Box(tuple(turn.apply([0, 0, -0.1])), (1, 0.3, 0.1), turned(turn))
    contact = Contact(box("box", half), slope, stiffness=STIFFNESS, friction=friction)
    robot = lissom.Robot([link], contacts=[contact])
    run = lissom.simulate(robot, 0.5, dt=1e-3)
    assert run.success, run.message
    places = [robot.pose(q, link="box")[:3, 3] for q in (run.q[0], run.q[-1])]
    way = turn.inv().apply(places[1] - places[0])
    if friction < math.tan(angle):
        wanted = GRAVITY * (math.sin(angle) - friction * math.cos(angle)) * 0.5**2 / 2
        assert way[0] == pytest.approx(wanted, rel=5e-3)
    else:
        ratio = math.tan(angle) / friction
        assert way[0] == pytest.approx(1e-4 * ratio / math.sqrt(1 - ratio**2) * 0.5, rel=2e-1)
    assert abs(way[1:]).max() < 1e-5


SHAPES = {
    "box": lambda name: box(name, (0.05, 0.04, 0.03)),
    "capsule": lambda name: Capsule((-0.05, 0, 0), (0.05, 0.01, 0), 0.03, link=name),
    "tetrahedron": lambda name: ConvexMesh(0.06 * TETRAHEDRON, TETRAHEDRON_FACES, link=name),
    "octahedron": lambda name: ConvexMesh(0.05 * OCTAHEDRON, OCTAHEDRON_FACES, 0.005, link=name),
}


@pytest.mark.parametrize(("a", "b"), [("box", "box"), ("box", "capsule"), ("capsule", "capsule"),
                                      ("octahedron", "tetrahedron"), ("tetrahedron", "box")])  # fmt: skip
def test_bodies_that_collide_keep_their_momentum_and_say_what_they_lose(a, b):
    turn = turned(Rotation.from_rotvec([0.4, 0.3, 0.5]))
    links = [
        free("a", (0.05, 0.04, 0.03)),
        free("b", (0.04, 0.06, 0.03), 0.3, position=(0.02, 0.01, 0.11), orientation=turn),
    ]
    contact = Contact(SHAPES[a]("a"), SHAPES[b]("b"), stiffness=2e5, friction=0.4, slip_velocity=1e-2)
    robot = lissom.Robot(links, contacts=[contact], gravity=(0, 0, 0))
    v0 = np.zeros(robot.n)
    v0[robot.slice("b")] = [0.1, 0.05, -1, 1, 2, 3]
    run = lissom.simulate(robot, 0.15, method="radau", rtol=1e-7, atol=1e-10, v0=v0, t_eval="steps")
    assert run.success, run.message
    assert run.balance.dissipated[-1] > 0.02 * run.balance.total[0]
    assert abs(run.balance.drift) < 1e-5 * run.balance.total[0]
    assert_allclose(robot.momentum(run.q[-1], run.v[-1]), robot.momentum(run.q[0], v0), atol=1e-10)


def test_forces_are_those_of_all_who_move_along():
    """A carrier moves two boxes: their forces are those at rest, rotated."""
    half = (0.05, 0.04, 0.03)
    carrier = Link("carrier", joint=Free(), body=cuboid(1.0, (0.1, 0.2, 0.3)))
    boxes = [Link(name, joint=Free(), body=cuboid(0.5, half), parent="carrier") for name in "ab"]
    contact = Contact(box("a", half), box("b", half), stiffness=1e4, friction=0.4, patch_radius=0.01)
    robot = lissom.Robot([carrier, *boxes], contacts=[contact])
    q, v = np.zeros((2, robot.n))
    q[robot.slice("b")] = [0.03, 0.01, 0.0592, 0.002, 0.003, 0.4]
    v[robot.slice("b")] = [0.1, -0.2, 0.3, 0.5, 0.4, -0.6]
    wanted = robot.contact_forces(q, v)
    assert len(robot.touches(q, v)) > 2
    own = robot.slice("carrier")
    q[own], v[own] = [0.4, -0.2, 0.7, 0.5, -0.9, 0.3], [0.6, 0.3, -0.5, 0.8, 1.1, -0.4]
    turn = robot.pose(q, link="carrier")[:3, :3]
    assert_allclose(robot.contact_forces(q, v)[3:], turn @ wanted[3:], atol=1e-11 * abs(wanted).max())


def test_a_box_falls_on_the_edge_of_another():
    """First edge on crossing edge, then further contacts: the energy balance closes."""
    half = (0.05, 0.04, 0.03)
    link = free(
        "box", half, position=(0.05, 0, 0.1), orientation=turned(Rotation.from_rotvec([0.2, 0.8, 0.3]))
    )
    block = Box((-0.2, 0, -0.1), (0.22, 0.3, 0.1))
    robot = lissom.Robot([link], contacts=[Contact(box("box", half), block, stiffness=1e6, friction=0.3)])
    run = lissom.simulate(robot, 0.4, method="radau", rtol=1e-6)
    assert run.success, run.message
    assert run.balance.dissipated[-1] > 0.01
    assert abs(run.balance.drift) < 1e-5


@pytest.mark.parametrize("shape", ["box", "capsule"])
def test_bodies_slide_on_hilly_ground(shape):
    """A slope of 0.3 rad, as a height field."""
    angle, friction = 0.3, 0.1
    x = np.linspace(-1, 1, 21)
    ground = HeightField(np.tile(math.tan(angle) * x[:, None], 21), 0.1, (-1, -1, 0))
    surfaces = {
        "box": box("body", (0.05, 0.04, 0.02)),
        "capsule": Capsule((-0.08, 0, 0), (0.08, 0, 0), 0.02, link="body"),
    }
    turn = Rotation.from_rotvec([0, -angle, 0])
    link = free(
        "body", (0.05, 0.04, 0.02), position=tuple(turn.apply([0.3, 0, 0.02])), orientation=turned(turn)
    )
    contact = Contact(surfaces[shape], ground, stiffness=STIFFNESS, friction=friction)
    robot = lissom.Robot([link], contacts=[contact])
    run = lissom.simulate(robot, 0.4, dt=1e-3)
    assert run.success, run.message
    places = [robot.pose(q, link="body")[:3, 3] for q in (run.q[0], run.q[-1])]
    way = turn.inv().apply(places[1] - places[0])
    wanted = -GRAVITY * (math.sin(angle) - friction * math.cos(angle)) * 0.4**2 / 2
    assert_allclose(way, [wanted, 0, 0], atol=2e-4)


def test_nothing_passes_through_a_body():
    """A box thrown at a plate of 4 mm, with 30 mm per step."""
    half = (0.03, 0.03, 0.03)
    robot = lissom.Robot(
        [free("box", half, position=(0, 0, 0.1))],
        contacts=[Contact(box("box", half), Box((0, 0, 0), (0.3, 0.3, 0.002)), stiffness=1e8)],
        gravity=(0, 0, 0),
    )
    run = lissom.simulate(robot, 0.05, dt=3e-3, v0=[0, 0, -10, 0, 0, 0])
    assert run.success or run.status in {"passed_through", "deep_penetration"}, run.message
    assert run.q[-1][2] > -0.1


# What no corner tells


@pytest.mark.parametrize("centre", [0.0, 1e-18])
def test_stiff_boxes_do_not_gain_energy(centre):
    """A centre of mass that is rounding is no length to compare with. An impact takes a third of a step."""
    half = (0.03, 0.03, 0.03)
    body = Body(0.3, centre=(centre, 0, 0), inertia=(1.5e-4,) * 3)
    tilted = turned(Rotation.from_rotvec([0.5, 0.3, 0.1]))
    link = Link("box", joint=Free(), body=body, position=(0, 0, 0.2), orientation=tilted)
    for stiffness in (1e6, 1e7):
        contact = Contact(box("box", half), lissom.HalfSpace(), stiffness=stiffness, friction=0.3)
        run = lissom.simulate(lissom.Robot([link], contacts=[contact]), 0.5, dt=1e-3)
        assert run.success, run.message
        balance = run.balance
        energy = balance.kinetic + balance.elastic + balance.gravitational
        fallen = 0.3 * GRAVITY * 0.2
        assert np.maximum(np.diff(energy), 0).sum() < 0.05 * fallen
        assert run.doubt is None


@pytest.mark.parametrize(
    ("a", "b", "place"),
    [
        (Box((0, 0, 0), (0.05, 0.04, 0.03), link="a"), box("b", (0.05, 0.04, 0.03)), (0, 0, 0)),
        (box("a", (0.2, 0.02, 0.02)), box("b", (0.02, 0.2, 0.02)), (0, 0, 0.012)),
        (ConvexMesh(0.03 * OCTAHEDRON, OCTAHEDRON_FACES, link="a"), box("b", (0.05, 0.04, 0.03)), (0, 0, 0)),
        (
            Capsule((-0.1, 0, 0), (0.1, 0, 0), 0.02, link="a"),
            Capsule((0, -0.1, 0), (0, 0.1, 0), 0.02, link="b"),
            (0, 0, 0),
        ),
    ],
    ids=["one box", "crossed bars", "octahedron in a box", "crossed capsules"],
)
def test_bodies_that_are_in_each_other_are_refused(a, b, place):
    """No corner or edge of some of them is in the other one, or only just."""
    links = [free("a", (0.05,) * 3), free("b", (0.05,) * 3, position=place)]
    robot = lissom.Robot(links, gravity=(0, 0, 0), contacts=[Contact(a, b, stiffness=1e5)])
    with pytest.raises(ValueError, match=r"overlaps by 0\.0"):
        lissom.simulate(robot, 0.1, dt=1e-3)


@pytest.mark.parametrize("top", ["box", "ball", "mesh"])
@pytest.mark.parametrize("start", [0.02, -0.03])
def test_bodies_on_what_is_moved_start_where_they_are(top, start):
    """A slider that follows a table of its position is nowhere before its time is known."""
    half = np.array([0.05, 0.05, 0.02])
    tops = {
        "box": box("top", half),
        "ball": lissom.Ball("top", 0.02),
        "mesh": ConvexMesh(half * CUBE, CUBE_FACES, link="top"),
    }
    table = ConvexMesh(CUBE * [0.5, 0.5, 0.1] + [0, 0, -0.1], CUBE_FACES, link="slider")
    slider = Link(
        "slider",
        joint=lissom.Prismatic((1, 0, 0), motion=lissom.Harmonic(0.02, 2.0)),
        body=Body(1.0, inertia=(1,) * 3),
    )
    links = [slider, free("top", half, position=(0, 0, start - 6e-6))]
    robot = lissom.Robot(links, contacts=[Contact(tops[top], table, stiffness=1e5, friction=0.3)])
    if start > 0:
        assert lissom.simulate(robot, 0.05, dt=1e-3).success
    else:
        with pytest.raises(ValueError, match=r"overlaps by 0\.0"):
            lissom.simulate(robot, 0.05, dt=1e-3)


def test_a_flat_face_of_triangles_is_as_stiff_as_one():
    """Corners of a block lie above sides that divide the faces of a mesh: these are no edges."""
    corners = CUBE * [0.3, 0.3, 0.1] - [0, 0, 0.1]
    half = (0.05, 0.05, 0.02)
    tangents = []
    for table in (ConvexMesh(corners, CUBE_FACES), Box((0, 0, -0.1), (0.3, 0.3, 0.1))):
        contact = Contact(box("block", half), table, stiffness=STIFFNESS)
        springs = lissom.Support(link="block", stiffness=2000.0, rotational_stiffness=1.0)
        robot = lissom.Robot(
            [free("block", half, position=(0, 0, 0.021))], contacts=[contact], supports=[springs]
        )
        found = lissom.statics(robot)
        assert (found.success, found.stability) == (True, "stable")
        tangents.append(robot.tangent(found.q, np.zeros(6), np.zeros(6))[0])
    assert_allclose(tangents[0], tangents[1], rtol=1e-6, atol=1e-3)
