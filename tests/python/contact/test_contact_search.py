"""No overlap along a rod is overlooked: beside distances of many places from shapes, computed in NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial import cKDTree
from test_contact_shapes import CUBE, CUBE_FACES

import lissom

LENGTH, PLACES = 2.0, 4001
X = np.linspace(0.0, LENGTH, PLACES)
FINE = np.linspace(0.0, LENGTH, 16001)


def rod(radius, name="rod", **place):
    segment = lissom.Segment(
        LENGTH / 4,
        radius=radius,
        young_modulus=5e7,
        poisson_ratio=0.4,
        density=1500.0,
        modes={"torsion": 1, "bend_y": 3, "bend_z": 3},
    )
    return lissom.Link(name, rod=[segment] * 4, **place)


def unit(vector):
    return vector / np.linalg.norm(vector)


def axes(quaternion):
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def from_box(places, centre, turned, half):
    beyond = np.abs((places - centre) @ axes(turned)) - half
    return np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)


def from_segment(places, start, end):
    way = end - start
    x = np.clip((places - start) @ way / (way @ way), 0, 1)
    return np.linalg.norm(places - start - x[:, None] * way, axis=1)


def random_shape(kind, random, radius):
    """A shape as a function of where its centre is, and distances of places from it."""
    half, turned = random.uniform(0.02, 0.3, 3), unit(random.normal(size=4))
    if kind == "box":
        return (
            lambda at: lissom.Box(at, half, turned),
            lambda places, at: from_box(places, at, turned, half),
        )
    if kind == "mesh":
        corners = (CUBE * half) @ axes(turned).T
        return (
            lambda at: lissom.ConvexMesh(at + corners, CUBE_FACES, radius=0.3 * radius),
            lambda places, at: from_box(places, at, turned, half) - 0.3 * radius,
        )
    size = radius * random.choice([0.3, 1.0, 5.0])
    if kind == "sphere":
        return (
            lambda at: lissom.Sphere(at, size),
            lambda places, at: np.linalg.norm(places - at, axis=1) - size,
        )
    way = 0.3 * unit(random.normal(size=3))
    return (
        lambda at: lissom.Capsule(at - way, at + way, size),
        lambda places, at: from_segment(places, at - way, at + way) - size,
    )


def deepest_unseen(overlaps, touched):
    """The largest overlap of a stretch of places in which nothing is reported."""
    ends = np.flatnonzero(np.diff(np.r_[0, (overlaps > 0).astype(int), 0]))
    step = X[1]
    unseen = [
        overlaps[begin:end].max()
        for begin, end in zip(ends[::2], ends[1::2], strict=True)
        if not any(X[begin] - step <= x <= X[end - 1] + step for x in touched)
    ]
    return max(unseen, default=0.0)


@pytest.mark.parametrize("kind", ["box", "mesh", "capsule", "sphere"])
@pytest.mark.parametrize("radius", [5e-4, 2e-3, 2e-2])
def test_no_crossing_of_a_shape_is_overlooked(kind, radius):
    free = lissom.Robot([rod(radius)])
    for seed in range(5):
        random = np.random.default_rng(seed)
        q = random.normal(size=free.n) * random.choice([0.02, 0.2, 0.5])
        places = free.pose(q, X, link="rod")[:, :3, 3]
        near = random.integers(PLACES // 8, 7 * PLACES // 8)
        across = unit(np.cross(places[near + 1] - places[near - 1], random.normal(size=3)))
        shape, distances = random_shape(kind, random, radius)
        for overlap in (0.01, 0.1, 0.5):
            # From far away towards the rod, until the deepest place overlaps by so much.
            def excess(way):
                return distances(places, places[near] + way * across).min() - (1 - overlap) * radius  # noqa: B023

            ways = np.linspace(1.2, 0.0, 25)
            first = next(i for i, way in enumerate(ways) if excess(way) < 0.0)
            way = brentq(excess, ways[first], ways[first - 1], xtol=1e-12)
            contact = lissom.Contact("rod", shape(places[near] + way * across))
            robot = lissom.Robot([rod(radius)], contacts=[contact])
            touched = [touch.along[0] for touch in robot.touches(q, np.zeros(robot.n))]
            unseen = deepest_unseen(radius - distances(places, places[near] + way * across), touched)
            assert unseen < 1e-3 * radius, (seed, overlap, unseen / radius)


@pytest.mark.slow
@pytest.mark.parametrize("radius", [5e-4, 2e-2])
def test_no_crossing_of_another_rod_is_overlooked(radius):
    for seed in range(4):
        random = np.random.default_rng(seed)
        other_radius = radius * random.choice([0.3, 1.0, 3.0])
        links = [rod(radius), rod(other_radius, "other")]
        n = lissom.Robot(links[:1]).n
        q = random.normal(size=2 * n) * np.repeat([0.2, random.choice([0.02, 0.2])], n)
        turned = unit(random.normal(size=4))
        base = lissom.Robot([rod(radius, "other", orientation=turned)])
        there = base.pose(q[n:], FINE, link="other")[:, :3, 3]
        places = lissom.Robot(links[:1]).pose(q[:n], X, link="rod")[:, :3, 3]
        near = random.integers(PLACES // 8, 7 * PLACES // 8)
        across = unit(np.cross(places[near + 1] - places[near - 1], random.normal(size=3)))
        begin = places[near] - there[len(FINE) // 2]
        tree, smaller = cKDTree(there), min(radius, other_radius)
        # A few places are enough to find a way by which they overlap about that much.
        few = places[near % 20 :: 20]
        for overlap in (0.01, 0.1, 0.5):

            def excess(way):
                nearest = tree.query(few - begin - way * across)[0].min()  # noqa: B023
                return nearest - radius - other_radius + overlap * smaller  # noqa: B023

            apart = next(way for way in np.geomspace(0.5 * radius, 2.0, 40) if excess(way) > 0.0)
            way = brentq(excess, 0.0, apart, xtol=1e-2 * smaller)
            position = begin + way * across
            pair = [links[0], rod(other_radius, "other", position=position, orientation=turned)]
            robot = lissom.Robot(pair, contacts=[lissom.Contact("rod", "other")])
            touched = [touch.along[0] for touch in robot.touches(q, np.zeros(robot.n))]
            overlaps = radius + other_radius - tree.query(places - position)[0]
            # The nearest place of the other rod may be between two.
            shallow = (FINE[1] / 2) ** 2 / (radius + other_radius)
            unseen = deepest_unseen(overlaps, touched)
            assert unseen < 1e-3 * smaller + shallow, (seed, overlap, unseen / smaller)
