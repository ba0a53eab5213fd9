"""The pile of rods that `benches/python/peers/pile.py` compares: what others are loaded, distances, times."""

import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import lissom

ROOT = Path(__file__).parents[3]
sys.path.insert(0, str(ROOT / "benches" / "python"))
sys.path.insert(0, str(ROOT / "benches" / "python" / "peers"))
import pile_lissom  # noqa: E402
import pile_report  # noqa: E402
import pile_scene  # noqa: E402
from speed import contact  # noqa: E402

seeds = st.integers(0, 10_000)


def test_others_are_told_what_the_rods_of_lissom_are(tmp_path):
    file = tmp_path / "scene.json"
    pile_scene.write({5: pile_lissom.scene(5)}, file)
    loaded = pile_scene.read(file)[5]
    robot = contact.pile(5)
    q, v = np.zeros(robot.n), np.zeros(robot.n)
    mass = 5 * pile_scene.DENSITY * pile_scene.AREA * pile_scene.LENGTH
    middles = loaded.starts + 0.5 * pile_scene.LENGTH * loaded.directions
    weight = pile_scene.GRAVITY * mass
    assert_allclose(robot.energy(q, v).gravitational, weight * middles[:, 2].mean(), rtol=1e-12)
    for rod in range(5):
        end = loaded.starts[rod] + pile_scene.LENGTH * loaded.directions[rod]
        assert_allclose(robot.pose(q, pile_scene.LENGTH, link=f"rod {rod}")[:3, 3], end, atol=1e-15)


@pytest.mark.parametrize("side", range(len(pile_scene.WALLS)))
def test_others_are_told_the_walls_and_their_stiffness(side):
    # A rod that lies along a wall, sunk into it: the force is that of a line of springs.
    point, normal = (np.array(each) for each in pile_scene.WALLS[side])
    depth = 1e-4
    along = np.cross(normal, [0.3, 0.5, 0.7])
    along /= np.linalg.norm(along)
    start = 0.15 * np.array([0, 0, 1.0]) * (side > 0) - 0.5 * pile_scene.LENGTH * along
    start += normal * (pile_scene.RADIUS - depth - normal @ (start - point))
    across = np.cross(along, normal)
    axes = np.column_stack([along, across, np.cross(along, across)])
    x, y, z, w = Rotation.from_matrix(axes).as_quat()
    robot = lissom.Robot(
        [
            lissom.Link(
                "rod 0",
                joint=lissom.Weld(),
                rod=contact.pile(1).links[0].rod,
                position=start,
                orientation=(w, x, y, z),
            )
        ],
        contacts=contact.pile(1).contacts,
    )
    name = f"rod 0 on {list(contact.WALLS)[side]}"
    force = robot.contact_forces(np.zeros(robot.n), np.zeros(robot.n), name=name)[3:]
    assert_allclose(force @ normal, pile_scene.STIFFNESS * depth * pile_scene.LENGTH, rtol=1e-9)


@given(seeds)
def test_distances_of_segments_are_those_of_many_points(seed):
    random = np.random.default_rng(seed)
    a, b = random.normal(size=(2, 3))
    u, v = random.normal(size=(2, 3)) * random.uniform(0.1, 2.0, size=(2, 1))
    if seed % 4 == 0:
        v = random.uniform(-2.0, 2.0) * u
    places = np.linspace(0.0, 1.0, 401)
    one, other = a + places[:, None] * u, b + places[:, None] * v
    nearest = np.linalg.norm(one[:, None] - other[None], axis=-1).min()
    found = pile_scene.segment_distances(a, u, b, v)
    spacing = (np.linalg.norm(u) + np.linalg.norm(v)) / 800
    assert found <= nearest + 1e-12
    assert nearest <= found + spacing


def test_the_largest_overlap_is_found():
    places = np.linspace(-0.15, 0.15, 7)
    zeros = np.zeros(7)
    low = np.column_stack([places, zeros, zeros + 0.0099])
    high = np.column_stack([zeros, places, zeros + 0.0297])
    assert_allclose(pile_scene.largest_overlap(np.array([low])), 1e-4, rtol=1e-9)
    assert_allclose(pile_scene.largest_overlap(np.array([low, high])), 2e-4, rtol=1e-9)
    state = pile_scene.settled(pile_scene.State(np.array([low, high]), 0.5))
    assert_allclose(state["height"], 0.0198, rtol=1e-12)


def run(size, step, seconds, error, code="one"):
    return {
        "code": code,
        "rods": 5,
        "size": size,
        "discretisation": f"{size} links",
        "step": step,
        "seconds": seconds,
        "errors": [0.1 * error, error],
        "reference": False,
    }


def test_times_are_interpolated_between_runs():
    runs = [run(4, 1e-3, 1.0, 1e-1), run(4, 1e-4, 10.0, 1e-3), run(8, 1e-3, 20.0, 1e-2)]
    best = pile_report.frontier(runs)
    assert best == [(1.0, 1e-1), (10.0, 1e-3)]
    assert pile_report.time_at(best, 1e-2) == "3.2 s"
    assert pile_report.time_at(best, 0.2) == "≤ 1 s"
    assert pile_report.time_at(best, 1e-4) == "– (1.0e-03 in 10 s)"


def test_an_error_that_grows_with_smaller_steps_was_small_by_chance():
    runs = [run(4, 1e-3, 1.0, 1e-5), run(4, 1e-4, 10.0, 1e-2)]
    assert pile_report.frontier(runs) == [(1.0, 1e-2)]


def test_only_rods_that_have_touched_count():
    pile = pile_lissom.scene(10)
    along = pile_scene.LENGTH * np.array([0.0, 0.5, 1.0])
    starts = pile.starts[:, None] + along[:, None] * pile.directions[:, None]
    fall = 0.5 * pile_scene.GRAVITY * np.array(pile_scene.TIMES) ** 2
    falling = starts[None] - np.array([0.0, 0.0, 1.0]) * fall[:, None, None, None]
    reference = falling.copy()
    reference[-1, 3, :, 2] += 0.01
    points = reference.copy()
    points[..., 0] += 0.003
    assert pile_report.touched(reference, pile).sum(axis=1).tolist() == [0, 0, 0, 1]
    assert_allclose(pile_report.errors(points, reference, pile), [0.0, 0.0, 0.0, 0.01], atol=1e-12)
