"""`Robot.coordinates_of`: inverse of `pose`, circles, helices and catenaries in closed form, units, turns,
errors."""

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import lissom

BENDS = {"bend_y": 4, "bend_z": 4}
ALL = {"torsion": 2, "bend_y": 3, "bend_z": 3, "stretch": 2, "shear_y": 1, "shear_z": 1}


def segment(modes, length=0.5, **changes):
    return lissom.Segment(length, 0.01, 1e6, poisson_ratio=0.4, density=1000, modes=modes, **changes)


def rod(modes, segments=2, length=1.0, **changes):
    return lissom.Rod([segment(modes, length / segments)] * segments, **changes)


def quaternions(rotations):
    return Rotation.from_matrix(rotations).as_quat(scalar_first=True)


def circle(radius, angle, k=40):
    turns = np.linspace(0.0, angle, k)
    return radius * np.column_stack([np.sin(turns), 1 - np.cos(turns), 0 * turns])


def helix(radius, pitch, turns, k):
    """Points and Frenet frames (tangent, normal, binormal), from the origin along the x axis; and the
    length."""
    angle = np.linspace(0.0, 2 * np.pi * turns, k)
    slope = pitch / (2 * np.pi)
    size = np.hypot(radius, slope)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), slope * angle])
    tangents = np.column_stack([-radius * np.sin(angle), radius * np.cos(angle), slope + 0 * angle]) / size
    normals = np.column_stack([-np.cos(angle), -np.sin(angle), 0 * angle])
    frames = np.stack([tangents, normals, np.cross(tangents, normals)], axis=2)
    base = frames[0].T
    return (points - points[0]) @ base.T, base @ frames, size * angle[-1]


states = st.integers(0, 2**32 - 1)


@settings(max_examples=20)
@given(states)
def test_points_of_a_rod_that_bends_and_stretches_give_its_coordinates_back(seed):
    random = np.random.default_rng(seed)
    model = rod(BENDS | {"stretch": 2}, segments=int(random.integers(1, 5)))
    q = random.uniform(-4.0, 4.0, model.n) * np.where(
        ["stretch" in name for name in model.coordinates], 0.02, 1
    )
    X = np.linspace(0.0, 1.0, 60)
    found = model.coordinates_of(model.pose(q, X)[:, :3, 3], X=X)
    assert found.success
    assert found.status == "fitted"
    assert_allclose(found.q, q, rtol=0, atol=1e-8)
    assert found.largest_distance < 1e-11
    assert found.rms_distance <= found.largest_distance


@settings(max_examples=20)
@given(states)
def test_frames_give_torsion_and_shear_back(seed):
    random = np.random.default_rng(seed)
    model = rod(ALL, segments=2)
    small = [name.split(".")[-1].startswith(("stretch", "shear")) for name in model.coordinates]
    q = random.uniform(-4.0, 4.0, model.n) * np.where(small, 0.02, 1)
    X = np.linspace(0.0, 1.0, 40)
    poses = model.pose(q, X)
    for frames in (poses[:, :3, :3], quaternions(poses[:, :3, :3])):
        found = model.coordinates_of(poses[:, :3, 3], frames, X=X)
        assert_allclose(found.q, q, rtol=0, atol=1e-8)
        assert found.largest_distance < 1e-11
        assert found.angle.max() < 1e-11


@pytest.mark.parametrize("angle", [0.5, np.pi, 2 * np.pi, 6 * np.pi, 20 * np.pi])
def test_a_circle_is_a_constant_curvature_whatever_its_turns(angle):
    radius = 1.0 / angle
    model = rod({"bend_y": 2, "bend_z": 2}, segments=max(4, round(2 * angle / np.pi)))
    found = model.coordinates_of(circle(radius, angle, k=400))
    wanted = [angle if name.endswith("bend_z[0]") else 0.0 for name in model.coordinates]
    assert_allclose(found.q, wanted, rtol=1e-9, atol=1e-9 * angle)
    assert found.largest_distance < 1e-12
    assert_allclose(found.X, np.linspace(0, 1, 400), atol=1e-12)


@pytest.mark.parametrize("turns", [0.4, 3, 6])
def test_a_helix_is_constant_curvature_and_torsion(turns):
    points, frames, length = helix(0.05, 0.08, turns, k=300)
    pieces = max(3, round(4 * turns))
    # Nodes that resolve turns of constant strain to rounding.
    piece = segment({"torsion": 1, "bend_y": 1, "bend_z": 1}, length / pieces, nodes=16)
    model = lissom.Rod([piece] * pieces)
    X = np.linspace(0.0, length, len(points))
    found = model.coordinates_of(points, frames, X=X)
    size = 0.05**2 + (0.08 / (2 * np.pi)) ** 2
    curvature, torsion = 0.05 / size, 0.08 / (2 * np.pi) / size
    kinds = {"torsion": torsion, "bend_y": 0.0, "bend_z": curvature}
    wanted = [kinds[name.split(".")[-1].split("[")[0]] for name in model.coordinates]
    assert_allclose(found.q, wanted, rtol=1e-9, atol=1e-9)
    assert found.largest_distance < 1e-12
    # Its points alone, without twist: as near as the modes follow a curvature that turns.
    smooth = rod({"bend_y": 6, "bend_z": 6, "torsion": 3}, segments=pieces, length=length)
    alone = smooth.coordinates_of(points, X=X)
    assert alone.success
    assert alone.largest_distance < 1e-6
    assert not alone.q[["torsion" in name for name in smooth.coordinates]].any()


def test_a_catenary_is_followed_to_the_order_of_the_modes():
    length, span = 1.0, 0.8
    # Length 2 a sinh(span / 2 a) in closed form.
    a = brentq(lambda a: 2 * a * np.sinh(span / (2 * a)) - length, 0.05, 5.0)
    s = np.linspace(-length / 2, length / 2, 201)
    points = np.column_stack([a * np.arcsinh(s / a), 0 * s, np.hypot(a, s)])
    points -= points[0]
    links = lambda segments: lissom.Robot(  # noqa: E731
        [lissom.Link("cable", joint=lissom.Spherical(), rod=[segment(BENDS, length / segments)] * segments)]
    )
    misses = [
        links(segments).coordinates_of(points, X=s + length / 2).largest_distance for segments in (2, 4, 8)
    ]
    # Cubic curvature: of sixth order in the angle, at least of fourth in the place.
    assert misses[0] < 1e-4
    assert misses[1] < misses[0] / 12
    assert misses[2] < misses[1] / 12
    found = links(4).coordinates_of(points, X=s + length / 2)
    curvature = a / (a**2 + (s[100]) ** 2)
    strain = links(4).strain(found.q, 0.5)
    assert_allclose(np.hypot(strain[1], strain[2]), curvature, rtol=1e-3)


def test_units_do_not_matter():
    points = helix(0.1, 0.5, 1.3, k=80)[0]
    found = [rod(BENDS, length=1e3**p).coordinates_of(points * 1e3**p) for p in (-1, 0, 1)]
    for p, one in zip((-1, 0, 1), found, strict=True):
        assert_allclose(one.q * 1e3**p, found[1].q, rtol=1e-6, atol=1e-6)
        assert_allclose(one.largest_distance / 1e3**p, found[1].largest_distance, rtol=1e-6)


def test_a_link_that_is_turned_and_moved_has_its_points_in_its_own_axes():
    turn = Rotation.from_rotvec([0.3, -1.1, 2.0])
    place = np.array([0.3, -0.2, 5.0])
    straight = rod(BENDS)
    turned = rod(BENDS, base_position=place, base_orientation=turn.as_quat(scalar_first=True))
    points = circle(0.4, 2.5)
    both = [model.coordinates_of(points) for model in (straight, turned)]
    assert_allclose(both[0].q, both[1].q, rtol=0, atol=1e-12)
    there = turned.pose(both[1].q, both[1].X)[:, :3, 3]
    assert_allclose(
        np.linalg.norm(there - (turn.apply(points) + place), axis=1), both[1].distance, atol=1e-12
    )


@pytest.mark.parametrize("joint", [lissom.Free(), lissom.Spherical(), lissom.Revolute((0, 1, 0))])
def test_the_base_turns_to_the_points(joint):
    link = lissom.Link("rod", joint=joint, rod=[segment(BENDS)] * 2, position=(1.0, 2.0, 3.0))
    about = [0.0, 2.6, 0.0] if isinstance(joint, lissom.Revolute) else [0.5, -1.5, 2.2]
    away = [0.1, 0.2, -0.3] if isinstance(joint, lissom.Free) else np.zeros(3)
    points = Rotation.from_rotvec(about).apply(circle(0.4, 2.5)) + away
    robot = lissom.Robot([link])
    found = robot.coordinates_of(points)
    assert_allclose(found.distance, 0.0, atol=2e-5)
    there = robot.pose(found.q, found.X)[:, :3, 3] - [1.0, 2.0, 3.0]
    assert_allclose(there, points, atol=2e-5)
    assert_allclose(np.linalg.norm(there - points, axis=1), found.distance, atol=1e-12)


def test_one_link_of_several_keeps_the_others():
    upper = lissom.Link("upper", rod=[segment(BENDS)])
    lower = lissom.Link("lower", joint=lissom.Revolute((0, 1, 0)), rod=[segment(BENDS)], parent="upper")
    robot = lissom.Robot([upper, lower])
    before = np.arange(float(robot.n)) / 10
    points = circle(0.5, 1.0)
    found = robot.coordinates_of(points, link="upper", q0=before)
    assert_allclose(found.q[robot.slice("lower")], before[robot.slice("lower")])
    assert_allclose(robot.pose(found.q, found.X, link="upper")[:, :3, 3], points, atol=1e-9)
    with pytest.raises(ValueError, match="link"):
        robot.coordinates_of(points)


def test_the_result_is_a_start():
    model = rod(BENDS)
    points = circle(0.4, 2.5)
    found = model.coordinates_of(points)
    assert_allclose(np.asarray(found), found.q)
    motion = lissom.simulate(model, 0.01, q0=found, dt=1e-3)
    assert_allclose(motion.q[0], found.q)
    assert_allclose(motion.pose([0.5, 1.0])[0], model.pose(found.q, [0.5, 1.0]))
    for other in (copy.copy(found), copy.deepcopy(found), pickle.loads(pickle.dumps(found))):
        assert (other.q == found.q).all()
        assert other.message == found.message
    assert "fitted" in repr(found)
    assert "Distance from the points: at most " in found.message


def test_what_the_modes_cannot_follow_is_said_by_the_distance():
    stiff = rod({"bend_z": 1}, segments=1)
    points = circle(0.3, 1.0) * [1, 1, 0] + [0, 0, 0.1]
    found = stiff.coordinates_of(points)
    assert found.success
    assert 0.09 < found.rms_distance <= found.largest_distance
    # The best of all curvatures, by trying them.
    tried = [
        np.linalg.norm(stiff.pose([q], found.X)[:, :3, 3] - points)
        for q in found.q[0] + np.linspace(-1, 1, 201)
    ]
    assert np.argmin(tried) == 100


def test_two_points_are_enough():
    model = rod({"bend_y": 2, "bend_z": 2})
    found = model.coordinates_of([[0, 0, 0], [1.0, 0, 0]])
    assert_allclose(found.q, 0.0, atol=1e-12)
    part = model.coordinates_of(circle(0.5, 0.6, k=9), X=np.linspace(0, 0.3, 9))
    assert part.largest_distance < 1e-9


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"points": [[0, 0, 0]]}, "points: got 1 points, expected at least two"),
        ({"points": np.zeros((0, 3))}, "points: got 0 points, expected at least two"),
        ({"points": [[0, 0], [1, 0]]}, "points: expected an array of shape"),
        ({"points": [[0, 0, 0], [0, 0, 0], [1, 0, 0]]}, r"points\[1\]: .*another point than points\[0\]"),
        ({"points": [[0, 0, 0], [np.nan, 0, 0]]}, r"points\[1\]\[0\]: got NaN"),
        ({"frames": [np.eye(3)]}, "frames: got 1, expected 3"),
        ({"frames": [2 * np.eye(3)] * 3}, r"frames\[0\].orientation"),
        ({"frames": [[2.0, 0, 0, 0]] * 3}, r"frames\[0\]: got a quaternion of norm 2"),
        ({"frames": np.zeros((3, 2))}, "frames: expected rotation matrices"),
        ({"X": [0, 0.5]}, "X: got 2 values, expected 3"),
        ({"X": [0, 0.5, 0.4]}, r"X\[2\]: got 0.4, expected more than X\[1\]"),
        ({"X": [0, 0.5, 1.5]}, r"X\[2\]: got 1.5, expected an arc length"),
        ({"q0": [0.0]}, "q0"),
        ({"link": "no"}, "link"),
    ],
)
def test_bad_input_is_named(changes, message):
    given = {"points": [[0, 0, 0], [0.5, 0, 0], [1.0, 0, 0]]} | changes
    with pytest.raises(ValueError, match=message):
        rod(BENDS).coordinates_of(**given)


def test_a_link_without_a_rod_is_refused():
    robot = lissom.Robot([lissom.Link("body", body=lissom.Body(1.0), joint=lissom.Prismatic((0, 0, 1)))])
    with pytest.raises(ValueError, match="link: got body, expected a link with a rod"):
        robot.coordinates_of([[0, 0, 0], [1, 0, 0]])
