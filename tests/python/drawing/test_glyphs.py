"""Drawings of joints, loads and supports of robots."""

import numpy as np
import pytest

import lissom
from lissom.model.glyphs import glyphs
from lissom.model.glyphs.loads import value_at

SOFT = lissom.Segment(
    0.2, 0.01, 3e5, poisson_ratio=0.4, density=1000, modes={"torsion": 1, "bend_y": 2, "bend_z": 2}
)
BODY = lissom.Body(0.1, centre=(0.02, 0.01, 0), inertia=(1e-4, 1e-4, 1e-4))
TURNED = (0.5, 0.5, -0.5, 0.5)
PLACE = (0.1, -0.2, 0.3)
AXIS = (1.0, 2.0, -0.5)
MOVED = lissom.BaseMotion(
    translation=lissom.Harmonic((0.1, 0, 0.2), 1.0), axis=(1, 1, 0), angle=lissom.Harmonic(0.5, 2.0)
)

JOINTS = [
    lissom.Revolute(AXIS),
    lissom.Prismatic(AXIS),
    lissom.Screw(AXIS, 0.3),
    lissom.Cylindrical(AXIS),
    lissom.Universal(AXIS, (0, 1, 1)),
    lissom.Planar(AXIS),
    lissom.Planar((1, 0, 0)),
    lissom.Spherical(),
]


def one(joint, **options):
    link = lissom.Link("link", body=BODY, joint=joint, position=PLACE, orientation=TURNED)
    return lissom.Robot([link], **options)


@pytest.mark.parametrize("joint", JOINTS, ids=lambda joint: type(joint).__name__)
def test_what_a_joint_moves_in_stays_where_the_joint_is(joint):
    """The frame of a joint on a moving base is that of a link welded there."""
    robot = one(joint, base_motion=MOVED)
    welded = one(lissom.Weld(), base_motion=MOVED)
    rng = np.random.default_rng(1)
    q, t = rng.uniform(-0.7, 0.7, (6, robot.n)), rng.uniform(0.0, 1.0, 6)
    frame = welded.pose(np.zeros((6, 0)), link="link", t=t)
    first, *others = glyphs(robot, ()).joints
    pose = first.pose(q, t)
    # A rail, a plane, and an axis that the joint does not rotate; axes of rotation are at the link.
    is_fixed = first.kind in ("sliding", "plane") or not others
    np.testing.assert_allclose(pose[:, :3, 3], frame[:, :3, 3], atol=1e-12)
    if first.kind != "ball" and is_fixed:
        along = np.array(getattr(joint, "axis", getattr(joint, "normal", None)))
        expected = frame[:, :3, :3] @ (along / np.linalg.norm(along))
        np.testing.assert_allclose(pose[:, :3, 0], expected, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(pose[:, :3, :3]), 1.0, rtol=1e-12)


def test_a_plane_is_spanned_by_what_the_link_moves_along():
    robot = one(lissom.Planar(AXIS))
    plane, turning = glyphs(robot, ()).joints
    q = np.array([0.3, -0.2, 0.9])
    pose, base = plane.pose(q, 0.0), robot.pose(q, link="link")
    np.testing.assert_allclose(plane.travel(q, 0.0), [0.0, *q[:2]], atol=1e-14)
    np.testing.assert_allclose(turning.pose(q, 0.0)[:3, 3], base[:3, 3], atol=1e-14)
    np.testing.assert_allclose(turning.pose(q, 0.0)[:3, 0], pose[:3, 0], atol=1e-14)


def test_a_cross_has_an_axis_on_either_side():
    robot = one(lissom.Universal((0, 1, 0), (0, 0, 1)))
    first, second = glyphs(robot, ()).joints
    rest, q = np.zeros(2), np.array([0.8, -1.1])
    frame, base = robot.pose(rest, link="link"), robot.pose(q, link="link")
    # The first axis is fixed in the parent, the second one in the link.
    np.testing.assert_allclose(first.pose(q, 0.0)[:3, 0], frame[:3, 1], atol=1e-14)
    np.testing.assert_allclose(second.pose(q, 0.0)[:3, 0], base[:3, 2], atol=1e-14)


def test_a_slide_also_turns_where_it_is_cylindrical():
    robot = one(lissom.Cylindrical(AXIS))
    rail, axis = glyphs(robot, ()).joints
    assert (rail.kind, axis.kind) == ("sliding", "turning")
    q = np.array([0.4, 2.0])
    np.testing.assert_allclose(rail.travel(q, 0.0), [q[0], 0.0, 0.0], atol=1e-14)
    rail, axis = rail.pose(q, 0.0), axis.pose(q, 0.0)
    np.testing.assert_allclose(rail[:3, 3] + q[0] * rail[:3, 0], axis[:3, 3], atol=1e-14)
    np.testing.assert_allclose(rail[:3, 0], axis[:3, 0], atol=1e-14)


def test_joints_that_are_driven_have_no_coordinates_but_are_drawn():
    """Rails of prescribed joints, or of mimics, on a moving link."""
    slide = lissom.Prismatic((0, 1, 0), motion=lissom.Harmonic(0.1, 1.0))
    robot = lissom.Robot(
        [
            lissom.Link("palm", body=BODY, joint=lissom.Free()),
            lissom.Link("left", body=BODY, joint=slide, parent="palm", position=PLACE, orientation=TURNED),
            lissom.Link(
                "right",
                body=BODY,
                joint=lissom.Prismatic((0, 1, 0), mimic=lissom.Mimic("left", multiplier=-2.0)),
                parent="palm",
            ),
        ]
    )
    assert robot.n == 6
    t = np.linspace(0.0, 1.0, 7)
    q = np.random.default_rng(3).uniform(-1, 1, (7, 6))
    left, right = glyphs(robot, ()).joints
    along = np.array([1.0, 0.0, 0.0])
    displacement = 0.1 * np.sin(2 * np.pi * t)[:, None]
    np.testing.assert_allclose(left.travel(q, t), displacement * along, atol=1e-14)
    np.testing.assert_allclose(right.travel(q, t), -2.0 * displacement * along, atol=1e-14)
    palm = robot.pose(q, link="palm", t=t)
    np.testing.assert_allclose(right.pose(q, t)[:, :3, 3], palm[:, :3, 3], atol=1e-14)
    np.testing.assert_allclose(left.pose(q, t)[:, :3, 3], (palm @ [*PLACE, 1.0])[:, :3], atol=1e-14)


def test_anchors_are_where_driven_joints_have_not_moved():
    slide = lissom.Prismatic((1, 0, 0), motion=lissom.Harmonic(0.1, 1.0, mean=0.5))
    links = [lissom.Link("sled", joint=slide, position=PLACE), lissom.Link("arm", rod=[SOFT], parent="sled")]
    robot = lissom.Robot(links, supports=[lissom.Support(stiffness=3.0, link="arm")])
    (support,) = glyphs(robot, ()).supports
    np.testing.assert_allclose(support.anchor, np.add(PLACE, (0.2, 0, 0)), atol=1e-15)
    # The spring's elongation is the displacement of the sled: this is its force.
    q, rest = np.zeros(robot.n), np.zeros(robot.n)
    free = lissom.Robot(links)
    gap = support.anchor - support.pose(q, 0.1)[:3, 3]
    held = robot.base_wrench(q, rest, rest, t=0.1) - free.base_wrench(q, rest, rest, t=0.1)
    np.testing.assert_allclose(held[3:], -3.0 * gap, atol=1e-12)


def test_nothing_joins_what_is_free_or_welded():
    assert glyphs(one(lissom.Free()), ()).joints == []
    welded = glyphs(one(lissom.Weld()), ())
    assert welded.joints == []
    assert len(welded.clamps) == 1
    assert len(glyphs(one(lissom.Free()), ()).clamps) == 0
    arm = lissom.Robot([lissom.Link("a", body=BODY), lissom.Link("b", rod=[SOFT], parent="a")])
    assert len(glyphs(arm, ()).clamps) == 1, "what is welded to another link is not clamped to the world"


TABLE = ([0.0, 1.0, 3.0], [[0, 0, 0], [1, -2, 4], [1, 0, 0]])


@pytest.mark.parametrize(
    ("signal", "expected"),
    [
        ((1, 2, 3), lambda t: [1, 2, 3]),
        (TABLE, lambda t: [np.interp(t, TABLE[0], np.array(TABLE[1], float)[:, i]) for i in range(3)]),
        (
            lissom.Harmonic((1, 0, 2), 0.7, phase=0.3, mean=(0, 5, 1), rate=(0, 0, 2)),
            lambda t: np.array([0, 5, 1 + 2 * t]) + np.array([1, 0, 2]) * np.sin(2 * np.pi * 0.7 * t + 0.3),
        ),
        (lambda t: (t, t**2, 0.0), lambda t: [t, t**2, 0.0]),
    ],
    ids=["constant", "table", "harmonic", "callable"],
)
def test_what_varies_in_time_is_followed(signal, expected):
    load = lissom.Load(force=signal)
    times = np.array([-0.5, 0.0, 0.4, 1.0, 2.2, 9.0])
    np.testing.assert_allclose(value_at(load.force, times), [expected(t) for t in times], rtol=1e-14)
    np.testing.assert_allclose(value_at(load.force, 0.4), expected(0.4), rtol=1e-14)


def test_the_work_of_drawn_forces_is_that_of_the_robot():
    """Places, axes and values of the glyphs give the power that the loads supply."""
    loads = [
        lissom.Load(force=lissom.Harmonic((1, 2, 3), 1.5), link="finger", at=0.07),
        lissom.Load(force=(-1, 0.5, 0.2), moment=(0.1, 0.2, 0.3), frame="body", link="finger"),
        lissom.Load(moment=(0.3, 0, 0.1), link="palm"),
    ]
    links = [
        lissom.Link("palm", body=BODY, joint=lissom.Spherical()),
        lissom.Link("finger", rod=[SOFT], parent="palm", position=(0.1, 0, 0)),
    ]
    robot = lissom.Robot(links, gravity=(0, 0, 0), loads=loads)
    unloaded = lissom.Robot(links, gravity=(0, 0, 0))
    rng = np.random.default_rng(2)
    q, v, t = rng.uniform(-0.5, 0.5, robot.n), rng.uniform(-1, 1, robot.n), 0.13
    a = np.zeros(robot.n)
    force = unloaded.inverse_dynamics(q, v, a) - robot.inverse_dynamics(q, v, a, t=t)
    power = 0.0
    for glyph in glyphs(robot, robot.loads).loads:
        ((place),) = glyph.pose(q, t)
        (value,) = glyph.value(np.array([t]), np.zeros((1, 0)))
        world = place[:3, :3] @ value if glyph.follows else value
        X = {"palm": None, "finger": 0.2}[glyph.name]
        velocity = robot.velocity(q, v, 0.07 if glyph.outwards == 0 and X else X, link=glyph.name)
        power += world @ (velocity[3:] if glyph.kind == "force" else velocity[:3])
    assert power == pytest.approx(force @ v, rel=1e-10)


def test_spread_loads_have_places_along_their_part():
    load = lissom.Load(force=(0, 0, -1), moment=(1, 0, 0), along=(0.05, 0.15))
    force, moment = glyphs(lissom.Robot([lissom.Link("rod", rod=[SOFT])]), [load]).loads
    at = [glyph.pose(np.zeros((4, 5)), 0.0)[:, :, 0, 3] for glyph in (force, moment)]
    np.testing.assert_allclose(at[0], np.tile(np.linspace(0.05, 0.15, 5), (4, 1)), atol=1e-15)
    np.testing.assert_allclose(at[1], np.tile([0.05, 0.1, 0.15], (4, 1)), atol=1e-15)
    assert force.is_spread
    assert force.outwards == 0
    tip, base = (glyphs(lissom.Rod([SOFT]), [lissom.Load(force=AXIS, at=at)]).loads[0] for at in (None, 0.0))
    assert (tip.outwards, base.outwards) == (1, -1)


def test_supports_are_anchored_where_the_robot_holds_them():
    """At the anchor, springs are without force, also on a moving base."""
    supports = [
        lissom.Support(stiffness=5.0, at=0.12),
        lissom.Support(rotational_stiffness=2.0, position=PLACE),
    ]
    rod = lissom.Rod([SOFT], base_position=(0.3, 0, 0), base_motion=MOVED, supports=supports)
    held, directed = glyphs(rod, ()).supports
    np.testing.assert_allclose(held.anchor, [0.42, 0, 0], atol=1e-15)
    np.testing.assert_allclose(directed.anchor, PLACE)
    assert held.holds_places
    assert not directed.holds_places
    resting = lissom.Rod([SOFT], base_position=(0.3, 0, 0))
    q = np.array([0.3, 1.0, -2.0, 0.5, 1.0])
    np.testing.assert_allclose(held.pose(q, 0.25), rod.pose(q, 0.12, t=0.25))
    np.testing.assert_allclose(directed.pose(q, 0.25), rod.pose(q, 0.2, t=0.25))
    assert glyphs(resting, ()).supports == []
