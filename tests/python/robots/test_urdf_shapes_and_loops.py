"""Shapes for contact and closed loops in URDF files."""

import warnings

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom
from lissom.urdf import UrdfError, UrdfWarning, imported_from, read_urdf, robot_from_urdf

INERTIAL = """<inertial><origin xyz="0.1 0 0"/><mass value="0.1"/>
<inertia ixx="1e-5" ixy="0" ixz="0" iyy="4e-4" iyz="0" izz="4e-4"/></inertial>"""

#: The four-bar linkage in the documentation of `Loop`; the fourth bar is the link "ground".
FOUR_BARS = f"""<robot name="linkage">
<link name="ground"/>
<link name="crank">{INERTIAL}</link>
<link name="coupler">{INERTIAL}</link>
<link name="rocker">{INERTIAL}</link>
<joint name="a" type="continuous"><parent link="ground"/><child link="crank"/><axis xyz="0 1 0"/></joint>
<joint name="b" type="continuous"><parent link="crank"/><child link="coupler"/>
<origin xyz="0.2 0 0"/><axis xyz="0 1 0"/></joint>
<joint name="c" type="continuous"><parent link="coupler"/><child link="rocker"/>
<origin xyz="0.2 0 0"/><axis xyz="0 1 0"/></joint>
<loop_joint name="pin" type="revolute">
<link1 link="rocker" xyz="0.2 0 0"/><link2 link="ground" xyz="0.2 0 0"/><axis xyz="0 1 0"/>
</loop_joint>
</robot>"""


def hand(shapes):
    return f"""<robot name="hand"><link name="palm">{INERTIAL}
<collision name="c"><origin xyz="0 0 0.1" rpy="0 1.5707963267948966 0"/>
<geometry>{shapes}</geometry></collision>
</link></robot>"""


@pytest.fixture
def file(tmp_path):
    def written(text):
        path = tmp_path / "robot.urdf"
        path.write_text(text)
        return path

    return written


# Loops


def test_a_loop_joint_is_a_loop(file):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot = robot_from_urdf(file(FOUR_BARS))
    hinge = lissom.Revolute((0, 1, 0))
    body = lissom.Body(0.1, centre=(0.1, 0, 0), inertia=np.diag([1e-5, 4e-4, 4e-4]))

    def bar(name, parent=None):
        offset = (0, 0, 0) if parent is None else (0.2, 0, 0)
        return lissom.Link(name, parent=parent, position=offset, joint=hinge, body=body)

    links = [bar("crank"), bar("coupler", "crank"), bar("rocker", "coupler")]
    pin = lissom.Loop(("rocker", None, (0.2, 0, 0)), (None, None, (0.2, 0, 0)), hinge)
    same = lissom.Robot(links, loops=[pin])
    assert robot.constraints == same.constraints == 5
    start = np.array([0.3, 0.9, 1.2])
    found, expected = (
        lissom.simulate(model, 0.3, q0=start, dt=2e-3, t_eval=[0.3]) for model in (robot, same)
    )
    assert_allclose(found.q, expected.q, atol=1e-9)
    assert read_urdf(file(FOUR_BARS)).loops[0].name == "pin"
    assert "1 loop" in str(read_urdf(file(FOUR_BARS)))


def test_further_loops_stand_beside_those_of_the_file(file):
    more = lissom.Loop("coupler", None, lissom.Planar((0, 1, 0)), name="more")
    robot = robot_from_urdf(file(FOUR_BARS), loops=[more])
    assert [loop.name for loop in robot.loops] == ["pin", "more"]


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        ("continuous", lissom.Revolute((0, 1, 0))),
        ("prismatic", lissom.Prismatic((0, 1, 0))),
        ("planar", lissom.Planar((0, 1, 0))),
        ("ball", lissom.Spherical()),
        ("fixed", lissom.Weld()),
    ],
)
def test_kinds_of_loops(kind, expected, file):
    imported = read_urdf(file(FOUR_BARS.replace('name="pin" type="revolute"', f'name="pin" type="{kind}"')))
    assert imported.loops[0].kind == expected
    axes = [left.path for left in imported.not_taken]
    assert axes == (["robot/loop_joint[pin]/axis"] if kind in ("ball", "fixed") else [])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'link2 link="ground"',
            'link2 link="grond"',
            'got "grond", which is no link of this file; did you mean',
        ),
        ('link2 link="ground"', 'link2 link="rocker"', 'got "rocker" at both ends'),
        ('name="pin" type="revolute"', 'name="pin" type="revolut"', "did you mean revolute?"),
        ('<link1 link="rocker" xyz="0.2 0 0"/>', "", "got no <link1>"),
        (
            '<link1 link="rocker" xyz="0.2 0 0"/>',
            '<link1 link="rocker" xyz="0.2 0"/>',
            "expected 3 finite numbers",
        ),
    ],
)
def test_wrong_loops_are_problems_with_their_place(old, new, message, file):
    with pytest.raises(UrdfError, match="loop_joint") as refused:
        read_urdf(file(FOUR_BARS.replace(old, new)))
    assert message in str(refused.value)


def test_scenes_list_loops_which_they_have_themselves():
    imported = imported_from("robot.urdf", FOUR_BARS.encode())
    (left,) = imported.not_taken
    assert left.what == "robot/loop_joint"
    assert "the robot stays open" in left.reason
    assert imported.loops == ()


# Shapes for contact


def test_shapes_are_read_on_request(file):
    path = file(hand('<sphere radius="0.03"/>'))
    (left,) = read_urdf(path).not_taken
    assert "give collisions=True" in left.reason
    imported = read_urdf(path, collisions=True)
    assert imported.not_taken == ()
    assert imported.shapes == (lissom.Sphere((0, 0, 0.1), 0.03, link="palm"),)
    with pytest.warns(UrdfWarning, match="collisions=True"):
        robot_from_urdf(path, floating=True)


def test_boxes_and_capsules_stand_where_the_file_says(file):
    """Their axes are turned by a quarter about y: z of the shape is x of the link."""
    (box,) = read_urdf(file(hand('<box size="0.2 0.04 0.02"/>')), collisions=True).shapes
    assert_allclose(box.half_extents, [0.1, 0.02, 0.01])
    assert_allclose(box.orientation, [np.sqrt(0.5), 0, np.sqrt(0.5), 0])
    (bar,) = read_urdf(file(hand('<capsule radius="0.01" length="0.2"/>')), collisions=True).shapes
    ends = sorted([bar.start, bar.end])
    assert_allclose(ends, [[-0.1, 0, 0.1], [0.1, 0, 0.1]], atol=1e-15)


def test_a_cylinder_is_a_prism_of_its_volume(file):
    import trimesh

    (shape,) = read_urdf(file(hand('<cylinder radius="0.03" length="0.2"/>')), collisions=True).shapes
    solid = trimesh.Trimesh(np.array(shape.points), np.array(shape.faces), process=False)
    assert solid.is_watertight
    assert abs(solid.volume) == pytest.approx(np.pi * 0.03**2 * 0.2, rel=1e-9)
    assert_allclose(solid.bounds[:, 0], [-0.1, 0.1], atol=1e-15)
    assert_allclose(solid.centroid, [0, 0, 0.1], atol=1e-12)


@pytest.mark.parametrize("shapes", ['<box size="0.1 0.06 0.04"/>', '<cylinder radius="0.03" length="0.1"/>'])
def test_a_body_lies_on_its_shape(shapes, file):
    imported = read_urdf(file(hand(shapes)), collisions=True, floating=True)
    (shape,) = imported.shapes
    floor = lissom.Contact(shape, lissom.HalfSpace((0, 0, 0)), stiffness=1e4, dissipation=0.5, friction=0.5)
    robot = lissom.Robot(imported.links, contacts=[floor])
    q0 = np.zeros(robot.n)
    q0[2] = 0.02
    result = lissom.simulate(robot, 1.0, q0=q0, method="auto", rtol=1e-3)
    assert result.success
    # The centre of mass, 0.1 m beside the shape, falls; the shape stays above the floor.
    assert 1e-6 < result.deepest.depth < 1e-2


def test_meshes_are_listed(file):
    imported = read_urdf(file(hand('<mesh filename="palm.stl"/>')), collisions=True)
    (left,) = imported.not_taken
    assert left.what == "robot/link/collision/geometry/mesh"
    assert "`ConvexMesh` holds a convex hull" in left.reason
    assert imported.shapes == ()


@pytest.mark.parametrize(
    ("shapes", "message"),
    [
        ('<box size="0.1 0.1"/>', "expected 3 finite numbers"),
        ('<sphere radius="-1"/>', "got the sizes -1"),
        ('<cylinder radius="0.1" length="0"/>', "got the sizes 0.1, 0; expected positive ones"),
        ("<sphere/>", "got no attribute radius"),
        ("", "got no shapes; expected one"),
        ('<sphere radius="0.1"/><box size="1 1 1"/>', "got 2 shapes; expected one"),
    ],
)
def test_wrong_shapes_are_problems_with_their_place(shapes, message, file):
    with pytest.raises(UrdfError, match="geometry") as refused:
        read_urdf(file(hand(shapes)), collisions=True)
    assert message in str(refused.value)


def test_a_collision_needs_a_geometry(file):
    text = hand("").replace("<geometry></geometry>", "")
    with pytest.raises(UrdfError, match="got no <geometry>"):
        read_urdf(file(text), collisions=True)
