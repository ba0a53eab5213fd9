"""`lissom.urdf`: contents of a file become a robot, are listed, or are rejected with line and column."""

import contextlib
import gc
import pickle
import re
import time
import warnings
from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import lissom
from lissom.urdf import Imported, Left, UrdfError, UrdfProblem, UrdfWarning, read_urdf, robot_from_urdf

few = settings(max_examples=25)

ENTRIES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")

#: Marks the place in a text that a message names.
HERE = "▮"

INERTIAL = '<inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
PAIR = '<link name="a"/><link name="b"/>'
ENDS = '<parent link="a"/><child link="b"/>'


def written(folder, text, name="robot.urdf"):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8"))
    return path


@pytest.fixture
def read(tmp_path):
    """Reads a text as a file."""
    return lambda text, **options: read_urdf(written(tmp_path, text), **options)


def one_joint(kind, inside=""):
    return (
        f'<robot name="r"><link name="a"/><link name="b">{INERTIAL}</link>'
        f'<joint name="j" type="{kind}">{ENDS}{inside}</joint></robot>'
    )


def listed(imported):
    """The content that was not imported, without places."""
    return [left.path for left in imported.not_taken]


# Results of a file


TWO_LINKS = """<?xml version="1.0"?>
<!-- An arm in the plane of x and y. -->
<robot name="planar arm">
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="{c1} 0 0" rpy="0 {quarter} 0"/>
      <mass value="{m1}"/>
      <inertia ixx="{I1}" ixy="0" ixz="0" iyy="{I1}" iyz="0" izz="0.001"/>
    </inertial>
  </link>
  <link name="lower">
    <inertial>
      <origin xyz="{c2} 0 0"/>
      <mass value="{m2}"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="{I2}" iyz="0" izz="{I2}"/>
    </inertial>
  </link>
  <joint name="shoulder" type="continuous">
    <parent link="base"/>
    <child link="upper"/>
    <axis xyz="0 0 2"/>
    <dynamics damping="0.3"/>
  </joint>
  <joint name="elbow" type="continuous">
    <origin xyz="{l1} 0 0"/>
    <parent link="upper"/>
    <child link="lower"/>
    <axis xyz="0 0 1"/>
  </joint>
</robot>
"""


def test_an_arm_of_two_links_in_closed_form(read):
    """Mass matrix, centrifugal and gravity terms of the planar arm, as in textbooks."""
    sizes = {"l1": 0.7, "c1": 0.3, "m1": 1.1, "I1": 0.05, "c2": 0.4, "m2": 0.8, "I2": 0.03}
    l1, c1, m1, I1, c2, m2, I2 = sizes.values()
    imported = read(TWO_LINKS.format(**sizes, quarter=np.pi / 2))
    assert imported.not_taken == ()
    assert imported.name == "planar arm"
    assert imported.joints == {"shoulder": "upper", "elbow": "lower"}
    g = 9.81
    robot = lissom.Robot(imported.links, gravity=(0, -g, 0))
    assert robot.coordinates == ("upper.angle", "lower.angle")
    for q, v, a in np.random.default_rng(1).standard_normal((5, 3, 2)):
        across = m2 * l1 * c2 * np.cos(q[1])
        second = I2 + m2 * c2**2
        first = I1 + m1 * c1**2 + m2 * l1**2 + second + 2 * across
        mass = np.array([[first, second + across], [second + across, second]])
        assert_allclose(robot.mass_matrix(q), mass, rtol=1e-12)
        h = m2 * l1 * c2 * np.sin(q[1])
        tau = mass @ a + [-h * (2 * v[0] * v[1] + v[1] ** 2) + 0.3 * v[0], h * v[0] ** 2]
        outer = m2 * c2 * g * np.cos(q[0] + q[1])
        tau += [(m1 * c1 + m2 * l1) * g * np.cos(q[0]) + outer, outer]
        assert_allclose(robot.inverse_dynamics(q, v, a), tau, rtol=1e-11, atol=1e-12)


def test_rpy_turns_about_fixed_axes_x_y_z(read):
    text = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
    <joint name="ab" type="fixed"><parent link="a"/><child link="b"/>
    <origin xyz="1 2 3" rpy="0.3 -0.5 1.1"/></joint>
    <joint name="bc" type="revolute"><parent link="b"/><child link="c"/><axis xyz="1 -2 2"/>
    <limit lower="-1" upper="1"/><origin xyz="-1 0.5 2" rpy="-2 0.4 0.7"/></joint></robot>"""
    links = read(text).links
    robot = lissom.Robot(links[:2])
    frame = np.eye(4)
    frame[:3, :3] = Rotation.from_euler("xyz", [0.3, -0.5, 1.1]).as_matrix()
    frame[:3, 3] = 1, 2, 3
    assert_allclose(robot.pose([], link="b"), frame, atol=1e-15)
    # The definition in other words: about x first, about z last.
    x, y, z = (
        Rotation.from_rotvec(angle * axis) for angle, axis in zip([0.3, -0.5, 1.1], np.eye(3), strict=True)
    )
    assert_allclose(robot.pose([], link="b")[:3, :3], (z * y * x).as_matrix(), atol=1e-15)
    w, *vector = links[2].orientation
    turn = Rotation.from_quat([*vector, w]).as_matrix()
    assert_allclose(turn, Rotation.from_euler("xyz", [-2, 0.4, 0.7]).as_matrix(), atol=1e-15)
    assert links[2].joint.axis == (1, -2, 2)
    assert links[2].position == (-1, 0.5, 2)


def test_quaternions_of_urdf_1_1(read):
    turn = Rotation.from_euler("xyz", [0.3, -0.5, 1.1])
    words = " ".join(f"{x:.5f}" for x in turn.as_quat())
    link = read(one_joint("fixed", f'<origin quat_xyzw="{words}"/>')).links[1]
    same = read(one_joint("fixed", '<origin rpy="0.3 -0.5 1.1"/>')).links[1]
    assert_allclose(link.orientation, same.orientation, atol=1e-5)
    assert_allclose(np.linalg.norm(link.orientation), 1, rtol=1e-15)


def test_inertia_is_turned_into_the_axes_of_the_link(read):
    tensor = np.array([[0.3, 0.02, -0.01], [0.02, 0.4, 0.03], [-0.01, 0.03, 0.5]])
    entries = zip(ENTRIES, tensor[np.triu_indices(3)].tolist(), strict=True)
    inertia = " ".join(f'{name}="{value}"' for name, value in entries)
    text = f"""<robot name="r"><link name="a"><inertial><origin xyz="1 2 3" rpy="0.3 -0.5 1.1"/>
    <mass value="4"/><inertia {inertia}/></inertial></link></robot>"""
    body = read(text).links[0].body
    R = Rotation.from_euler("xyz", [0.3, -0.5, 1.1]).as_matrix()
    assert body.mass == 4
    assert body.centre == (1, 2, 3)
    assert_allclose(body.inertia, R @ tensor @ R.T, atol=1e-15)


@pytest.mark.parametrize(
    ("kind", "inside", "joint"),
    [
        ("fixed", "", lissom.Weld()),
        ("floating", "", lissom.Free()),
        ("planar", '<axis xyz="0 1 0"/>', lissom.Planar((0, 1, 0))),
        ("planar", "", lissom.Planar((1, 0, 0))),
        ("continuous", "", lissom.Revolute((1, 0, 0))),
        ("continuous", '<axis xyz="0 3 4"/>', lissom.Revolute((0, 3, 4))),
        ("continuous", '<dynamics friction="2e-1"/>', lissom.Revolute((1, 0, 0), friction=0.2)),
        ("revolute", '<limit lower="-1" upper="2"/>', lissom.Revolute((1, 0, 0))),
        ("prismatic", '<limit upper="2"/>', lissom.Prismatic((1, 0, 0))),
        (
            "prismatic",
            '<limit upper=".5"/><axis xyz="0 0 -1"/><dynamics damping="3." friction="+4"/>',
            lissom.Prismatic((0, 0, -1), damping=3, friction=4),
        ),
    ],
)
def test_joints(read, kind, inside, joint):
    base, link = read(one_joint(kind, inside)).links
    assert base == lissom.Link("a")
    body = lissom.Body(2, inertia=(1, 1, 1))
    assert link == lissom.Link("b", parent="a", joint=joint, body=body)


def test_limits_become_stops_where_their_stiffness_is_given(read):
    text = one_joint("revolute", '<limit lower="-1" upper="2" effort="3" velocity="4"/>')
    stops = read(text, limit_stiffness=50.0)
    expected = lissom.Revolute((1, 0, 0), limits=(-1, 2), limit_stiffness=50.0)
    assert stops.links[1].joint == expected
    assert listed(stops) == ["robot/joint[j]/limit@effort", "robot/joint[j]/limit@velocity"]
    none = read(text)
    assert listed(none) == [
        f"robot/joint[j]/limit@{name}" for name in ("lower", "upper", "effort", "velocity")
    ]
    assert "limit_stiffness" in none.not_taken[0].reason
    # URDF's default of a limit is zero.
    one_sided = read(one_joint("prismatic", '<limit upper="2"/>'), limit_stiffness=5)
    assert one_sided.links[1].joint.limits == (0, 2)


@pytest.mark.parametrize("limit_stiffness", [None, 10.0])
def test_limits_that_are_none_are_listed(read, limit_stiffness):
    def left(kind, inside):
        imported = read(one_joint(kind, inside), limit_stiffness=limit_stiffness)
        assert getattr(imported.links[1].joint, "limits", None) is None
        return listed(imported)

    assert left("revolute", '<limit lower="1" upper="1"/>') == [
        "robot/joint[j]/limit@lower",
        "robot/joint[j]/limit@upper",
    ]
    assert left("revolute", "<limit/>") == ["robot/joint[j]/limit"]
    assert left("revolute", "") == ["robot/joint[j]@type"]
    assert left("continuous", '<limit lower="-1" upper="1"/>') == ["robot/joint[j]/limit"]
    assert left("fixed", '<limit lower="-1" upper="1"/>') == ["robot/joint[j]/limit"]


@pytest.mark.parametrize("limit_stiffness", [0, -1.0, float("nan"), float("inf")])
def test_a_stiffness_that_is_none_is_refused(read, limit_stiffness):
    with pytest.raises(ValueError, match=r"^limit_stiffness: got .*, expected a finite number >=? 0"):
        read(one_joint("fixed"), limit_stiffness=limit_stiffness)


def test_what_a_joint_cannot_have_is_listed(read):
    """Exporters write zero axes for fixed joints, and dynamics for all joints."""
    inside = '<axis xyz="0 0 0"/><dynamics damping="1"/><safety_controller k_velocity="1"/><calibration/>'
    names = ["axis", "dynamics", "safety_controller", "calibration"]
    for kind in ("fixed", "floating"):
        assert listed(read(one_joint(kind, inside))) == [f"robot/joint[j]/{name}" for name in names]
    planar = read(one_joint("planar", inside.replace("0 0 0", "0 0 1")))
    assert listed(planar) == [f"robot/joint[j]/{name}" for name in names[1:]]


GRIPPER = """<robot name="gripper">
<link name="palm"/><link name="left"/><link name="right"/>
<joint name="l" type="continuous"><parent link="palm"/><child link="left"/></joint>
<joint name="r" type="continuous"><parent link="palm"/><child link="right"/>
  <mimic joint="l" multiplier="-1.5" offset="0.1"/></joint>
</robot>"""


def test_mimic_ties_a_joint_to_another(read):
    imported = read(GRIPPER)
    mimic = lissom.Mimic("left", multiplier=-1.5, offset=0.1)
    assert imported.links[2].joint == lissom.Revolute((1, 0, 0), mimic=mimic)
    assert imported.links[1].joint == lissom.Revolute((1, 0, 0))
    assert not imported.not_taken
    default = read(GRIPPER.replace('multiplier="-1.5" offset="0.1"', ""))
    assert default.links[2].joint.mimic == lissom.Mimic("left")
    both = read(
        GRIPPER.replace('"left"/></joint>', '"left"/><mimic joint="x"/></joint>').replace(
            "</robot>",
            '<link name="third"/><joint name="x" type="prismatic"><parent link="palm"/>'
            '<child link="third"/></joint></robot>',
        )
    )
    chain = {link.name: link.joint.mimic.link for link in both.links if getattr(link.joint, "mimic", None)}
    assert chain == {"left": "third", "right": "left"}
    inertia = (
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    solid = read(re.sub(r'<link name="(left|right)"/>', rf'<link name="\1">{inertia}</link>', GRIPPER))
    robot = lissom.Robot(solid.links)
    assert robot.coordinates == ("left.angle",)
    # The equal inertia of both, one of them behind a gear of 1.5.
    assert_allclose(robot.mass_matrix([0.3]), [[1 + 1.5**2]], rtol=1e-14)


def test_what_has_not_one_coordinate_mimics_nothing(read):
    for kind in ("fixed", "floating", "planar"):
        text = GRIPPER.replace('"r" type="continuous"', f'"r" type="{kind}"')
        imported = read(text)
        assert listed(imported) == ["robot/joint[r]/mimic"]
        assert (imported.not_taken[0].line, imported.not_taken[0].column) == (5, 3)


@pytest.mark.parametrize(
    ("old", "new", "line", "wrong", "right"),
    [
        ('joint="l"', 'joint="ll"', 5, 'got "ll", which is no joint of this file', 'did you mean "l"?'),
        (
            'joint="l"',
            'joint="r"',
            5,
            "got a circle of joints that mimic each other: r -> r",
            "expected one that moves by itself",
        ),
        ('"l" type="continuous"', '"l" type="fixed"', 5, 'got "l", a fixed joint', "expected a revolute"),
        (
            '"left"/></joint>',
            '"left"/><mimic joint="r"/></joint>',
            5,
            "got a circle of joints",
            "expected one that moves",
        ),
    ],
)
def test_mimics_of_nothing_and_in_circles_are_refused(read, old, new, line, wrong, right):
    with pytest.raises(UrdfError) as caught:
        read(GRIPPER.replace(old, new))
    (problem,) = caught.value.problems
    assert (problem.line, problem.key) == (line, "robot/joint[r]/mimic@joint")
    assert problem.wrong.startswith(wrong)
    assert problem.right.startswith(right)


def joint(parent, child, kind="fixed"):
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{parent}{child}" type="{kind}">{ends}</joint>'


def test_parents_stand_before_their_children_in_the_order_of_the_joints(read):
    links = "".join(f'<link name="{name}"/>' for name in "fedcba")
    joints = joint("b", "f") + joint("a", "c") + joint("c", "e") + joint("a", "b") + joint("c", "d")
    imported = read(f'<robot name="r">{joints}{links}</robot>')
    assert [(link.name, link.parent) for link in imported.links] == [
        ("a", None),
        ("c", "a"),
        ("e", "c"),
        ("d", "c"),
        ("b", "a"),
        ("f", "b"),
    ]


def test_the_root_is_welded_or_floats(read):
    text = one_joint("fixed")
    assert read(text).links[0].joint == lissom.Weld()
    floating = read(text, floating=True).links
    assert floating[0].joint == lissom.Free()
    assert floating[1].joint == lissom.Weld()
    assert lissom.Robot(floating).n == 6


def test_links_without_inertial_are_frames(read):
    assert read('<robot name="r"><link name="a"/></robot>').links == (lissom.Link("a"),)


def test_a_joint_without_mass_behind_it_is_for_the_robot_to_say(tmp_path):
    path = written(tmp_path, one_joint("continuous").replace(INERTIAL, ""))
    assert len(read_urdf(path).links) == 2
    with pytest.raises(ValueError, match=r"links\[1\]\.joint: "):
        robot_from_urdf(path)


def test_long_chains(read):
    n = 3000
    links = "\n".join(f'<link name="{i}"><visual/></link>' for i in range(n))
    joints = "\n".join(
        f'<joint name="{i}" type="fixed"><parent link="{i}"/><child link="{i + 1}"/></joint>'
        for i in range(n - 1)
    )
    imported = read(f'<robot name="r">{links}{joints}</robot>')
    assert [link.name for link in imported.links] == [str(i) for i in range(n)]
    assert len(imported.not_taken) == n


# Inertia that no body can have


TOO_LONG = INERTIAL.replace('izz="1"', 'izz="4"')


def test_inertia_is_mended_on_request_only(read):
    text = f'<robot name="r"><link name="a">\n{TOO_LONG}</link></robot>'
    with pytest.raises(UrdfError, match=r"principal moments 1, 1, 4.*mend_inertia=True"):
        read(text)
    imported = read(text, mend_inertia=True)
    # Moved along (1, 1, -1) up to (a, b, a + b).
    assert_allclose(imported.links[0].body.inertia, np.diag([5, 5, 10]) / 3, atol=1e-14)
    (left,) = imported.not_taken
    assert (left.line, left.column) == (2, 1 + INERTIAL.index("<inertia "))
    assert left.what == "robot/link/inertial/inertia"
    right = text.replace(TOO_LONG, INERTIAL)
    assert read(right, mend_inertia=True) == read(right)


numbers = st.floats(-2, 2).map(lambda x: round(x, 3))


@few
@given(moments=st.tuples(numbers, numbers, numbers), angles=st.tuples(numbers, numbers, numbers))
def test_mended_inertia_is_the_nearest_that_a_body_can_have(tmp_path_factory, moments, angles):
    """A projection on the cone spanned by thin rods along the three axes."""
    axes = Rotation.from_euler("xyz", angles).as_matrix()
    tensor = axes * moments @ axes.T
    entries = zip(ENTRIES, tensor[np.triu_indices(3)].tolist(), strict=True)
    inertia = " ".join(f'{name}="{value}"' for name, value in entries)
    link = f'<link name="a"><inertial><mass value="1"/><inertia {inertia}/></inertial></link>'
    path = written(tmp_path_factory.mktemp("mended"), f'<robot name="r">{link}</robot>')
    mended = read_urdf(path, mend_inertia=True).links[0].body.inertia
    missing = tensor - mended
    assert_allclose(np.sum(missing * mended), 0, atol=1e-9)
    for i in range(3):
        needle = axes * (np.arange(3) != i) @ axes.T
        assert np.sum(missing * needle) <= 1e-9


# Robots


def test_robot_from_urdf_adds_links_and_says_once_what_is_missing(tmp_path):
    inside = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    path = written(tmp_path, one_joint("revolute", inside).replace("</link>", "<visual/><visual/></link>"))
    soft = lissom.Segment(0.1, 8e-3, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 3})
    finger = lissom.Link("finger", rod=[soft], parent="b", position=(0.1, 0, 0))
    load = lissom.Load(force=(0, 0, 1), link="finger")
    with pytest.warns(UrdfWarning) as caught:
        robot = robot_from_urdf(path, links=[finger], loads=[load], gravity=(0, 0, -1.6), limit_stiffness=9)
    assert len(caught) == 1
    assert caught[0].filename == __file__
    assert str(caught[0].message) == str(read_urdf(path, limit_stiffness=9))
    assert issubclass(UrdfWarning, UserWarning)
    assert isinstance(robot, lissom.Robot)
    assert robot.gravity == (0, 0, -1.6)
    assert [link.name for link in robot.links] == ["a", "b", "finger"]
    assert robot.links[1].joint.limits == (-1, 1)
    assert robot.loads[0].link == "finger"


def test_no_warning_where_everything_was_taken_over(tmp_path):
    # Floating links have inertia of their own.
    text = one_joint("continuous").replace('<link name="a"/>', f'<link name="a">{INERTIAL}</link>')
    path = written(tmp_path, text)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot = robot_from_urdf(path, floating=True)
    assert robot.n == 7
    assert robot.gravity == (0, 0, -9.81)
    mended = written(tmp_path, one_joint("continuous").replace(INERTIAL, TOO_LONG))
    with pytest.warns(UrdfWarning, match="nearest"):
        robot_from_urdf(mended, mend_inertia=True)


@dataclass
class Node:
    """An element with each attribute on a separate line."""

    tag: str
    attributes: dict = field(default_factory=dict)
    children: list = field(default_factory=list)
    text: str = ""

    def lines(self):
        """Pairs of text and the node to which it belongs, (node, attribute) or (node, None)."""
        yield f"<{self.tag}", (self, "")
        for name, value in self.attributes.items():
            yield f'{name}="{value}"', (self, name)
        yield f">{self.text}", (self, "text()")
        for child in self.children:
            yield from child.lines()
        yield f"</{self.tag}>", None

    def __str__(self):
        return "\n".join(line for line, _ in self.lines())


def words(values):
    return " ".join(map(repr, values))


KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
seeds = st.integers(0, 2**32 - 1)


def drawn(rng, count=3):
    """Neither zero nor one, so not a default."""
    return tuple(float(x) for x in rng.uniform(0.1, 0.9, count))


def shuffled(rng, items):
    return [items[i] for i in rng.permutation(len(items))]


def random_body(rng):
    """As an element and in lissom, rotated by SciPy."""
    centre, angles, (mass,) = drawn(rng), drawn(rng), drawn(rng, 1)
    points = rng.uniform(-0.5, 0.5, (4, 3))
    tensor = mass * (np.sum(points**2) * np.eye(3) - points.T @ points)
    entries = tensor[np.triu_indices(3)].tolist()
    inner = [
        Node("origin", {"xyz": words(centre), "rpy": words(angles)}),
        Node("mass", {"value": mass}),
        Node("inertia", dict(zip(ENTRIES, entries, strict=True))),
    ]
    R = Rotation.from_euler("xyz", angles).as_matrix()
    body = lissom.Body(mass, centre=centre, inertia=R @ tensor @ R.T)
    return Node("inertial", {}, shuffled(rng, inner)), body


def random_joint(rng, kind, name, parent, child):
    """As an element, and the arguments of a `Link`."""
    position, angles, axis, bounds = drawn(rng), drawn(rng), drawn(rng), drawn(rng, 2)
    forces = dict(zip(("damping", "friction"), drawn(rng, 2), strict=True))
    limits = {"limits": (-bounds[0], bounds[1]), "limit_stiffness": 40.0}
    inner = [
        Node("parent", {"link": parent}),
        Node("child", {"link": child}),
        Node("origin", {"xyz": words(position), "rpy": words(angles)}),
    ]
    if kind in ("revolute", "continuous", "prismatic"):
        inner.append(Node("dynamics", dict(forces)))
    if kind in ("revolute", "prismatic"):
        inner.append(Node("limit", {"lower": -bounds[0], "upper": bounds[1]}))
    if kind not in ("fixed", "floating"):
        inner.append(Node("axis", {"xyz": words(axis)}))
    joint = {
        "revolute": lambda: lissom.Revolute(axis, **forces, **limits),
        "continuous": lambda: lissom.Revolute(axis, **forces),
        "prismatic": lambda: lissom.Prismatic(axis, **forces, **limits),
        "fixed": lissom.Weld,
        "floating": lissom.Free,
        "planar": lambda: lissom.Planar(axis),
    }[kind]()
    x, y, z, w = Rotation.from_euler("xyz", angles).as_quat()
    place = {"joint": joint, "parent": parent, "position": position, "orientation": (w, x, y, z)}
    return Node("joint", {"name": name, "type": kind}, shuffled(rng, inner)), place


@st.composite
def trees(draw, floating=False):
    """The root element of a robot, and its links in lissom."""
    kinds = draw(st.lists(st.sampled_from(KINDS), max_size=5))
    parents = [draw(st.integers(0, i)) for i in range(len(kinds))]
    rng = np.random.default_rng(draw(seeds))
    links, joints, made = [], [], []
    for i in range(len(kinds) + 1):
        link = Node("link", {"name": f"l{i}"})
        body = None
        kind = kinds[i - 1] if i else ("floating" if floating else "fixed")
        # Moving links have mass.
        if kind != "fixed" or rng.random() < 0.5:
            inertial, body = random_body(rng)
            link.children.append(inertial)
        place = {"joint": lissom.Free() if floating else lissom.Weld()}
        if i:
            node, place = random_joint(rng, kind, f"j{i}", f"l{parents[i - 1]}", f"l{i}")
            joints.append(node)
        links.append(link)
        made.append(lissom.Link(f"l{i}", body=body, **place))
    root = Node("robot", {"name": "random"}, shuffled(rng, [*links, *joints]))

    def behind(link):
        """A link and those behind it; children in the order of their joints in the file."""
        order = [int(node.attributes["name"][1:]) for node in root.children if node.tag == "joint"]
        return [link] + [other for i in order if made[i].parent == link.name for other in behind(made[i])]

    return root, behind(made[0])


@given(data=st.data(), floating=st.booleans(), seed=seeds)
def test_a_tree_that_is_written_and_read_is_the_same_robot(tmp_path_factory, data, floating, seed):
    root, links = data.draw(trees(floating))
    path = written(tmp_path_factory.mktemp("tree"), str(root))
    imported = read_urdf(path, floating=floating, limit_stiffness=40.0)
    assert imported.not_taken == ()
    assert [link.name for link in imported.links] == [link.name for link in links]
    found, direct = lissom.Robot(imported.links), lissom.Robot(links)
    assert found.coordinates == direct.coordinates
    q, v, a = np.random.default_rng(seed).standard_normal((3, direct.n))
    pairs = [
        (found.mass_matrix(q), direct.mass_matrix(q)),
        (found.inverse_dynamics(q, v, a), direct.inverse_dynamics(q, v, a)),
    ]
    for actual, desired in pairs:
        assert_allclose(actual, desired, rtol=0, atol=1e-12 * np.abs(desired).max(initial=0))


# Nothing is dropped silently


ODD = (
    "visual",
    "collision",
    "sensor",
    "odd",
    "gazebo",
    "material",
    "mass",
    "origin",
    "limit",
    "link",
    "color",
)


KNOWN = {
    "robot": {"link", "joint"},
    "link": {"inertial"},
    "inertial": {"origin", "mass", "inertia"},
    "joint": {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"},
}


@st.composite
def decorated(draw):
    """A tree with other elements, attributes and texts at random places."""
    root, _ = draw(trees())
    rng = np.random.default_rng(draw(seeds))
    waiting = [root]
    kinds = ("revolute", "continuous", "prismatic")
    singles = [node for node in root.children if node.tag == "joint" and node.attributes["type"] in kinds]
    while waiting:
        node = waiting.pop()
        # Elements that exist or are read at a place would not be unknown.
        known = {child.tag for child in node.children} | KNOWN.get(node.tag, set())
        waiting.extend(node.children)
        if rng.random() < 0.3:
            node.attributes[str(rng.choice(["odd", "note", "xmlns:x"]))] = "a b"
        if rng.random() < 0.3:
            inner = Node("odder", {"name": "n"}, [Node("mass", {"value": 3})], text="words")
            tag = str(rng.choice([tag for tag in ODD if tag not in known]))
            node.children.insert(int(rng.integers(len(node.children) + 1)), Node(tag, {"a": "b"}, [inner]))
        if rng.random() < 0.2:
            node.text = "\n some text"
        others = singles[: singles.index(node)] if node in singles else singles
        if node.tag == "joint" and others and rng.random() < 0.3:
            other = others[rng.integers(len(others))].attributes["name"]
            node.children.append(Node("mimic", {"joint": other, "multiplier": 2, "offset": 3}))
        if node.tag == "joint" and "axis" not in known and rng.random() < 0.5:
            node.children.append(Node("axis", {"xyz": "0 0 0"}))
    return root


def above(root):
    """The parent of every node, by identity."""
    found, waiting = {}, [root]
    while waiting:
        node = waiting.pop()
        for child in node.children:
            found[id(child)] = node
            waiting.append(child)
    return found


def outcome(path, root, limit_stiffness):
    """The imported content of a tree; or its problems if it is rejected."""
    path.write_text(str(root), encoding="utf-8")
    try:
        imported = read_urdf(path, limit_stiffness=limit_stiffness)
    except UrdfError as error:
        return [problem.wrong for problem in error.problems]
    return imported.links, imported.joints, imported.name


@pytest.mark.slow
@settings(max_examples=12)
@given(root=decorated(), limit_stiffness=st.sampled_from([None, 40.0]))
def test_everything_in_a_file_is_used_or_listed(tmp_path_factory, root, limit_stiffness):
    """Unlisted content changes the robot if it is changed or removed; listed content does not."""
    path = written(tmp_path_factory.mktemp("odd"), str(root))
    imported = read_urdf(path, limit_stiffness=limit_stiffness)
    lines = [item for text, item in root.lines() for _ in range(text.count("\n") + 1)]
    entries = set()
    for left in imported.not_taken:
        node, what = lines[left.line - 1]
        entries.add((id(node), what))
        # Its place and its path are the same.
        end = left.what.rsplit("/", 1)[-1]
        assert end == (what if what == "text()" else node.tag + (f"@{what}" if what else ""))
    parents, taken = above(root), outcome(path, root, limit_stiffness)
    assert not isinstance(taken, list)

    def is_covered(node, what):
        if (id(node), what) in entries or (id(node), "") in entries:
            return True
        return id(node) in parents and is_covered(parents[id(node)], "")

    def is_empty(node):
        """Whether all content of an element is listed."""
        return bool(node.attributes) and all(is_covered(node, name) for name in node.attributes)

    for node, what in {(id(item[0]), item[1]): item for item in lines if item}.values():
        if node is root and what == "":
            continue
        if what == "":
            siblings = parents[id(node)].children
            place = next(i for i, other in enumerate(siblings) if other is node)
            del siblings[place]
            after = outcome(path, root, limit_stiffness)
            siblings.insert(place, node)
        elif what == "text()":
            if not node.text:
                continue
            text, node.text = node.text, ""
            after = outcome(path, root, limit_stiffness)
            node.text = text
        else:
            before = dict(node.attributes)
            node.attributes = {name: "?" if name == what else value for name, value in before.items()}
            if is_covered(node, what):
                del node.attributes[what]
            after = outcome(path, root, limit_stiffness)
            node.attributes = before
        if is_covered(node, what):
            assert after == taken, (node.tag, what)
        elif what or not is_empty(node):
            assert after != taken, (node.tag, what)


def test_the_list_has_places_and_reasons(read):
    text = """<?xml version="1.0"?>
<!DOCTYPE robot>
<?xml-stylesheet href="a.css"?>
<!-- A comment says nothing. -->
<robot name="r" version="1.0" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="ä" type="arm" colour = 'red'>words
    <Inertial/>
    <visual><geometry><mesh filename="package://robot/mesh.dae"/></geometry></visual>
  </link><gazebo reference="ä"/>
  <sensor:camera name="c"/> <gazebo/>
</robot>
<?end?>"""
    imported = read(text)
    assert [str(left).removesuffix(f": {left.reason}") for left in imported.not_taken] == [
        "2:1: <!DOCTYPE>",
        "3:1: <?xml-stylesheet?>",
        "5:17: robot@version",
        "5:31: robot@xmlns:xacro",
        "6:3: robot/material[red]",
        "7:18: robot/link[ä]@type",
        "7:29: robot/link[ä]@colour",
        "7:44: robot/link[ä]/text()",
        "8:5: robot/link[ä]/Inertial: an unknown element; did you mean inertial?"[
            : len("8:5: robot/link[ä]/Inertial")
        ],
        "9:5: robot/link[ä]/visual",
        "10:10: robot/gazebo",
        "11:3: robot/sensor:camera[c]",
        "11:29: robot/gazebo",
        "13:1: <?end?>",
    ]
    assert imported.not_taken[8].reason == "an unknown element; did you mean inertial?"
    assert all(left.reason for left in imported.not_taken)
    assert imported.links == (lissom.Link("ä"),)
    assert imported.not_taken[0] == Left(2, 1, "<!DOCTYPE>", "<!DOCTYPE>", imported.not_taken[0].reason)


def test_the_summary_has_a_line_for_each_kind(read):
    links = "\n".join(f'<link name="{name}"><visual/></link>' for name in "abcde")
    joints = "".join(joint("a", name, "revolute").replace("</j", '<limit upper="1"/></j') for name in "bcde")
    imported = read(f'<robot name="r">\n{links}\n{joints}</robot>')
    assert len(imported.not_taken) == 9
    head, limits, visuals = str(imported).splitlines()
    assert head.endswith('robot.urdf: robot "r", 5 links, 4 joints; not taken over:')
    assert limits.startswith(
        "  robot/joint/limit@upper (4; lines 7, 7, 7 and 1 more): stops are stiff springs"
    )
    reason = "only for pictures; read on request: give visuals=True"
    assert visuals == f"  robot/link/visual (5; lines 2, 3, 4 and 2 more): {reason}"
    single = read('<robot name="r"><link name="a"/></robot>')
    assert str(single).endswith('robot "r", 1 link, 0 joints; everything was taken over')


# Invalid files


def body(inside):
    return f'<robot name="r">\n  <link name="a">\n    <inertial>{inside}</inertial>\n  </link>\n</robot>'


MASS = '<mass value="1"/>'
ROUND = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'

REFUSED = {
    "another root": (f'{HERE}<sdf version="1.6"/>', "sdf", "got the element <sdf>", "<robot>"),
    "no links": (f'<!-- -->\n {HERE}<robot name="r"/>', "robot", "got no links", "at least one"),
    "a link without a name": (
        f'<robot name="r">\n\t{HERE}<link/></robot>',
        "robot/link@name",
        "got no attribute name",
        "a name",
    ),
    "an empty name": (
        f'<robot name="r"><link name="{HERE}"/></robot>',
        "robot/link[]@name",
        'got ""',
        "a name",
    ),
    "two links of one name": (
        f'<robot name="r">\n<link name="a"/>\n<link name="{HERE}a"/></robot>',
        "robot/link[a]@name",
        'got "a", which the link in line 2 has',
        "a new name",
    ),
    "two joints of one name": (
        f'<robot name="r"><link name="a"/><link name="b"/><link name="c"/>\n{joint("a", "b")}\n'
        + joint("a", "c").replace('name="ac"', f'name="{HERE}ab"')
        + "</robot>",
        "robot/joint[ab]@name",
        'got "ab", which the joint in line 2 has',
        "a new name",
    ),
    "an unknown parent": (
        f'<robot name="r">{PAIR}\n<joint name="j" type="fixed"><parent link="{HERE}x"/><child link="b"/>'
        "</joint></robot>",
        "robot/joint[j]/parent@link",
        'got "x", which is no link of this file',
        "the name of a link",
    ),
    "an unknown child": (
        '<robot name="r"><link name="elbow"/>\n<joint name="j" type="fixed"><parent link="elbow"/>'
        f"<child\n link='{HERE}elbov'/></joint></robot>",
        "robot/joint[j]/child@link",
        'got "elbov", which is no link of this file',
        'did you mean "elbow"?',
    ),
    "no parent": (
        f'<robot name="r">{PAIR}{HERE}<joint name="j" type="fixed"><child link="b"/></joint></robot>',
        "robot/joint[j]",
        "got no <parent>",
        "<parent link=",
    ),
    "a child without a link": (
        f'<robot name="r"><link name="a"/><joint name="j" type="fixed"><parent link="a"/>{HERE}<child/>'
        "</joint></robot>",
        "robot/joint[j]/child@link",
        "got no attribute link",
        "the name of a link",
    ),
    "two parents": (
        f'<robot name="r">{PAIR}<link name="c"/>\n{joint("a", "b")}{joint("a", "c")}\n'
        + joint("c", "b").replace('child link="', f'child link="{HERE}')
        + "</robot>",
        "robot/joint[cb]/child@link",
        'got "b", which the joint "ab" in line 2 has as its child already',
        "without another parent",
    ),
    "two roots": (
        f'<robot name="r">\n<link name="a"/>\n  {HERE}<link name="b"/></robot>',
        "robot/link[b]",
        'got a second root; the first one is "a" in line 2',
        "a joint with this link as its child",
    ),
    "a circle": (
        f'<robot name="r">{PAIR}<link name="c"/>\n{joint("a", "b")}{joint("b", "c")}\n'
        f"{HERE}{joint('c', 'a')}</robot>",
        "robot/joint[ca]",
        "got a circle of links: a -> b -> c -> a",
        "expected a tree",
    ),
    "a circle beside a tree": (
        f'<robot name="r"><link name="r"/>{PAIR}<link name="c"/>\n{joint("b", "c")}{joint("a", "b")}\n'
        f"{HERE}{joint('b', 'a')}</robot>",
        "robot/joint[ba]",
        "got a circle of links: a -> b -> a",
        "expected a tree",
    ),
    "a link behind itself": (
        f'<robot name="r"><link name="a"/>{HERE}{joint("a", "a")}</robot>',
        "robot/joint[aa]",
        "got a circle of links: a -> a",
        "expected a tree",
    ),
    "an unknown type": (
        one_joint(f"{HERE}revolut"),
        "robot/joint[j]@type",
        'got "revolut"',
        "did you mean revolute?",
    ),
    "a type that is far off": (
        one_joint(f"{HERE}ball"),
        "robot/joint[j]@type",
        'got "ball"',
        "one of revolute, continuous, prismatic, fixed, floating, planar",
    ),
    "no type": (
        f'<robot name="r">{PAIR}{HERE}<joint name="j">{ENDS}</joint></robot>',
        "robot/joint[j]@type",
        "got no attribute type",
        "one of revolute",
    ),
    "no mass": (
        body(ROUND).replace("<inertial>", f"{HERE}<inertial>"),
        "robot/link[a]/inertial",
        "got no <mass>",
        "kilograms",
    ),
    "no inertia": (
        body(MASS).replace("<inertial>", f"{HERE}<inertial>"),
        "robot/link[a]/inertial",
        "got no <inertia>",
        "ixx, ixy",
    ),
    "no number": (
        body(f"{HERE}<mass/>{ROUND}"),
        "robot/link[a]/inertial/mass@value",
        "got no attribute value",
        "a finite number",
    ),
    "a negative mass": (
        body(f'<mass value="{HERE}-2"/>{ROUND}'),
        "robot/link[a]/inertial/mass@value",
        "got -2",
        "expected a finite number >= 0 (kilograms)",
    ),
    "inertia that no body has": (
        body(MASS + HERE + ROUND.replace('izz="1"', 'izz="3"')),
        "robot/link[a]/inertial/inertia",
        "got the principal moments 1, 1, 3",
        "none larger than the other two together",
    ),
    "inertia without an entry": (
        body(MASS + HERE + ROUND.replace('iyz="0"', "")),
        "robot/link[a]/inertial/inertia@iyz",
        "got no attribute iyz",
        "a finite number",
    ),
    "nan": (
        body(f'<mass value="{HERE}nan"/>{ROUND}'),
        "robot/link[a]/inertial/mass@value",
        'got "nan"',
        "finite",
    ),
    "an infinite number": (
        body(MASS + ROUND.replace('izz="1"', f'izz="{HERE}1e999"')),
        "robot/link[a]/inertial/inertia@izz",
        'got "1e999"',
        "a finite number",
    ),
    "a zero axis": (
        one_joint("continuous", f'<axis xyz="{HERE}0 0 0"/>'),
        "robot/joint[j]/axis@xyz",
        "got [0.0, 0.0, 0.0]",
        "a direction",
    ),
    "a zero normal": (
        one_joint("planar", f'<axis xyz="{HERE}0 0 0"/>'),
        "robot/joint[j]/axis@xyz",
        "got [0.0, 0.0, 0.0]",
        "a direction",
    ),
    "two numbers": (
        one_joint("fixed", f'<origin rpy="0 0 0"\n\txyz = "{HERE}1 2"/>'),
        "robot/joint[j]/origin@xyz",
        'got 2 numbers: "1 2"',
        "3 finite numbers",
    ),
    "commas": (
        one_joint("fixed", f'<origin rpy="{HERE}1, 2, 3"/>'),
        "robot/joint[j]/origin@rpy",
        'got "1, 2, 3"',
        "3 finite numbers",
    ),
    "an underscore": (
        one_joint("continuous", f'<dynamics damping="{HERE}1_0"/>'),
        "robot/joint[j]/dynamics@damping",
        'got "1_0"',
        "a finite number",
    ),
    "negative damping": (
        one_joint("prismatic", f'<limit upper="1"/><dynamics friction="1" damping="{HERE}-1"/>'),
        "robot/joint[j]/dynamics@damping",
        "got -1",
        "a finite number >= 0",
    ),
    "negative friction": (
        one_joint("continuous", f'<dynamics friction="{HERE}-0.5"/>'),
        "robot/joint[j]/dynamics@friction",
        "got -0.5",
        "a finite number >= 0",
    ),
    "limits in the wrong order": (
        one_joint("revolute", f'{HERE}<limit lower="1" upper="-1"/>'),
        "robot/joint[j]/limit",
        "got lower 1 above upper -1",
        "below the upper one",
    ),
    "an infinite limit": (
        one_joint("revolute", f'<limit lower="0" upper="{HERE}inf"/>'),
        "robot/joint[j]/limit@upper",
        'got "inf"',
        "a finite number",
    ),
    "a second origin": (
        one_joint("fixed", f"<origin/>\n{HERE}<origin/>"),
        "robot/joint[j]/origin",
        "got a second <origin>; the first one is in line 1",
        "one at most",
    ),
    "angles beside a quaternion": (
        one_joint("fixed", f'<origin rpy="{HERE}0 0 0" quat_xyzw="0 0 0 1"/>'),
        "robot/joint[j]/origin@rpy",
        "got rpy beside quat_xyzw",
        "one of them",
    ),
    "a quaternion that is none": (
        one_joint("fixed", f'<origin quat_xyzw="{HERE}0 0 0 2"/>'),
        "robot/joint[j]/origin@quat_xyzw",
        "got a quaternion of norm 2",
        "norm 1",
    ),
    "a mimic of nothing": (
        one_joint("continuous", f"{HERE}<mimic/>"),
        "robot/joint[j]/mimic@joint",
        "got no attribute joint",
        "the name of a joint",
    ),
    "a garbled multiplier": (
        one_joint("continuous", f'<mimic joint="k" multiplier="{HERE}two"/>'),
        "robot/joint[j]/mimic@multiplier",
        'got "two"',
        "a finite number",
    ),
    "xacro": (
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">\n'
        f'  {HERE}<xacro:macro name="m"><xacro:if/></xacro:macro></robot>',
        "",
        "got <xacro:macro> and 1 more of xacro",
        "run xacro first",
    ),
    "xacro by another name": (
        f'<robot name="r" xmlns:x="http://wiki.ros.org/xacro">\n<link name="a"/>{HERE}<x:include file="f"/>'
        "</robot>",
        "",
        "got <x:include>, which is xacro",
        "run xacro first",
    ),
    "an expression in a number": (
        one_joint("fixed", f'<origin xyz="{HERE}${{length}} 0 0"/>'),
        "robot/joint[j]/origin@xyz",
        'got "${length} 0 0"',
        "run xacro first",
    ),
    "an expression in a name": (
        f'<robot name="r"><link name="{HERE}$(arg prefix)a"/></robot>',
        "robot/link[$(arg prefix)a]@name",
        'got "$(arg prefix)a"',
        "run xacro first",
    ),
    "broken XML": (
        f'<robot name="r">\n  <link name="a">\n </{HERE}robot>',
        "",
        "not well-formed XML: mismatched tag",
        "",
    ),
    "XML that ends early": (f'<robot name="r">\n{HERE}', "", "not well-formed XML: no element found", ""),
    "an attribute that comes twice": (
        f'<robot name="é" {HERE}name="r"/>',
        "",
        "not well-formed XML: duplicate attribute",
        "",
    ),
    "an entity": (
        f'<?xml version="1.0"?>\n {HERE}<!DOCTYPE r [<!ENTITY a "b">]><robot name="&a;"/>',
        "",
        "got a document type with declarations (DOCTYPE)",
        "expected none",
    ),
    "an external entity": (
        f'{HERE}<!DOCTYPE robot\n SYSTEM "file:///etc/hostname"><robot name="r"/>',
        "",
        "got a document type with declarations (DOCTYPE)",
        "expected none",
    ),
    "an unknown encoding": (
        f'{HERE}<?xml version="1.0" encoding="klingon"?><robot/>',
        "",
        'got the encoding "klingon"',
        "UTF-8",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused_at_its_line_and_column(tmp_path, name):
    text, key, wrong, right = REFUSED[name]
    before, after = text.split(HERE)
    path = written(tmp_path, before + after)
    with pytest.raises(UrdfError) as caught:
        read_urdf(path)
    (problem,) = caught.value.problems
    assert (problem.line, problem.column) == (before.count("\n") + 1, len(before.rpartition("\n")[2]) + 1)
    assert problem.key == key
    assert problem.wrong == wrong
    assert right in problem.right
    place = f"{path}:{problem.line}:{problem.column}: "
    assert str(problem).startswith(place + (f"{key}: " if key else "") + wrong)
    assert str(caught.value).startswith(str(problem))


def test_all_problems_come_at_once_in_the_order_of_the_file(read):
    text = """<robot name="r">
  <joint name="j" type="hinge">
    <parent link="a"/><child link="nobody"/>
    <axis xyz="1 2"/>
    <dynamics damping="-1"/>
  </joint>
  <link name="a"><inertial><mass value="x"/><inertia ixx="1"/></inertial></link>
  <link name="a"/>
</robot>"""
    with pytest.raises(UrdfError) as caught:
        read(text)
    error = caught.value
    places = [(problem.line, problem.column) for problem in error.problems]
    assert places == [(2, 25), (3, 36), (4, 16), (5, 24), (7, 41), *[(7, 45)] * 5, (8, 15)]
    assert isinstance(error, ValueError)
    assert all(str(problem) in str(error) for problem in error.problems)
    first = error.problems[0]
    assert first.snippet == '  |\n2 |   <joint name="j" type="hinge">\n  |                         ^^^^^'
    assert first.file.endswith("robot.urdf")
    again = pickle.loads(pickle.dumps(error))
    assert again.problems == error.problems
    assert str(again) == str(error)


def test_messages_are_short_whatever_the_file(read):
    name = "n" * 5000 + "&#10;"
    with pytest.raises(UrdfError) as caught:
        read('<robot name="r">' + "\n".join(f'<link name="{name}"/>' for _ in range(150)) + "</robot>")
    assert len(caught.value.problems) == 149
    message = str(caught.value)
    assert message.endswith("\nand 49 more problems")
    assert message.count("\n") == 400
    assert max(map(len, message.splitlines())) < 2000


BOMB = (
    "<!DOCTYPE r ["
    + '<!ENTITY a0 "ha">'
    + "".join(f'<!ENTITY a{i + 1} "{f"&a{i};" * 10}">' for i in range(20))
    + ']><robot name="&a20;"><link name="&a20;"/></robot>'
)


def test_entities_are_not_expanded(read):
    with pytest.raises(UrdfError, match="DOCTYPE"):
        read(BOMB)
    # Predefined entities of XML are.
    assert read('<robot name="&lt;&#65;&quot;"><link name="&amp;"/></robot>').name == '<A"'


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_urdf(tmp_path / "nothing.urdf")
    with pytest.raises(IsADirectoryError):
        read_urdf(tmp_path)
    path = written(tmp_path, one_joint("fixed"))
    assert read_urdf(str(path)) == read_urdf(path)
    with pytest.raises(UrdfError, match=r"robot.urdf:2:13: not text in UTF-8") as caught:
        read_urdf(written(tmp_path, b'<robot name="r">\n<link name="\xff"/></robot>'))
    assert caught.value.problems[0].key == ""


# Encodings


@pytest.mark.parametrize(
    ("encoding", "declared"),
    [
        ("utf-8", None),
        ("utf-8", "UTF-8"),
        ("utf-8-sig", None),
        ("utf-8-sig", "utf-8"),
        ("latin-1", "ISO-8859-1"),
        ("cp1252", "windows-1252"),
        ("shift_jis", "Shift_JIS"),
        ("utf-16", "UTF-16"),
        ("utf-16", None),
        ("utf-16-le", "utf-16"),
        ("utf-16-be", "utf-16"),
        ("utf-32", "utf-32"),
        # Declarations that some writers use for UTF-8.
        ("utf-8", "utf-16"),
    ],
)
@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_encodings(tmp_path, encoding, declared, newline):
    name = "腕" if encoding == "shift_jis" else "größe"
    declaration = f'<?xml version="1.0" encoding="{declared}"?>' if declared else '<?xml version="1.0"?>'
    lines = [declaration, '<robot name="r">', f'<link name="{name}" odd="1">', "</link>", "</robot>"]
    path = written(tmp_path, newline.join(lines).encode(encoding))
    imported = read_urdf(path)
    assert imported.links[0].name == name
    (left,) = imported.not_taken
    assert (left.line, left.column) == (3, 15 + len(name))


# Arbitrary files


SEED = TWO_LINKS.format(l1=0.7, c1=0.3, m1=1.1, I1=0.05, c2=0.4, m2=0.8, I2=0.03, quarter=1.5)


@settings(max_examples=200)
@given(data=st.data())
def test_broken_files_are_read_or_refused(tmp_path_factory, data):
    """Parts of a file in any order give a result, or problems with places in the file."""
    pieces = re.findall(r"<[^>]*>|\S+|\s+", SEED)
    text = list(pieces)
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(text)))
        what = data.draw(st.sampled_from(["cut", "copy", "noise"]))
        if what == "cut":
            del text[place : place + data.draw(st.integers(1, 3))]
        elif what == "copy":
            text.insert(place, data.draw(st.sampled_from(pieces)))
        else:
            text.insert(place, data.draw(st.text(max_size=5).filter(lambda text: text.isprintable())))
    text = "".join(text)
    path = written(tmp_path_factory.mktemp("broken"), text)
    problems = []
    try:
        imported = read_urdf(path)
    except UrdfError as error:
        problems, message = error.problems, str(error)
    else:
        message = str(imported)
        assert isinstance(imported, Imported)
    assert message.startswith(str(path))
    for problem in problems:
        assert isinstance(problem, UrdfProblem)
        assert 1 <= problem.line <= text.count("\n") + 1
        assert 1 <= problem.column <= max(map(len, text.split("\n"))) + 1


@given(content=st.binary(max_size=40))
def test_any_bytes_are_read_or_refused(tmp_path_factory, content):
    path = written(tmp_path_factory.mktemp("bytes"), content)
    with pytest.raises(UrdfError):
        read_urdf(path)


@pytest.mark.parametrize("encoding", ["idna", "punycode", "unicode_escape", "undefined", "rot13", "none"])
def test_encodings_that_no_file_has_are_refused(encoding, tmp_path):
    path = tmp_path / "x.urdf"
    path.write_bytes(
        f'<?xml version="1.0" encoding="{encoding}"?>\n<robot name="\u00e4.{"a" * 80}"/>'.encode()
    )
    with pytest.raises(UrdfError, match="encoding"):
        read_urdf(path)


@pytest.mark.slow
def test_reading_takes_time_in_proportion_to_the_file(tmp_path):
    def seconds(text):
        path = tmp_path / "x.urdf"
        path.write_text(text, encoding="utf-8")
        # Collecting garbage takes time in proportion to what all other tests have left.
        gc.collect()
        gc.disable()
        try:
            begun = time.process_time()
            with contextlib.suppress(UrdfError):
                read_urdf(path)
            return time.process_time() - begun
        finally:
            gc.enable()

    def attributes(count, between=" "):
        listed = between.join(f"x{i}='1'" for i in range(count))
        return f'<robot name="r"><link name="a"{between}{listed}/></robot>'

    def lines(count):
        return attributes(count, "\n")

    def children(count):
        return f'<robot name="r"><link name="{"a" * 10 * count}">{"<b/>" * count}</link></robot>'

    def problems(count):
        return f'<robot name="r"><link name="a"/>{"<joint/>" * count}</robot>'

    for make in (attributes, lines, children, problems):
        seconds(make(100))
        # Four times the file: sixteen times the time if it were quadratic.
        small = max(seconds(make(5_000)), 0.02)
        assert seconds(make(20_000)) < 9.0 * small, make.__name__
