"""Distance grids and meshes that are not convex beside closed forms, simpler shapes and brute force."""

from __future__ import annotations

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import lissom
from lissom import Ball, Body, Contact, DistanceGrid, Free, HalfSpace, Link, Mesh

G = 9.81


def sampled(distance, low, high, spacing, **more):
    """A grid of a function of places (..., 3)."""
    axes = [np.arange(a, b + 0.5 * spacing, spacing) for a, b in zip(low, high, strict=True)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    return DistanceGrid(distance(places), spacing, low, **more)


def torus(large, small):
    def distance(at):
        return np.hypot(np.hypot(at[..., 0], at[..., 1]) - large, at[..., 2]) - small

    return distance


def cuboid(half):
    def distance(at):
        beyond = np.abs(at) - half
        return np.linalg.norm(np.maximum(beyond, 0), axis=-1) + np.minimum(beyond.max(axis=-1), 0)

    return distance


def ball_on(obstacle, radius=0.05, joint=None, gravity=(0, 0, -G), unit=1.0, **constants):
    """A homogeneous ball of 1 kg; lengths in other units than metres, with the forces of these units."""
    body = Body(1.0, inertia=np.eye(3) * 0.4 * (radius * unit) ** 2)
    link = Link("ball", joint=joint or Free(), body=body)
    contact = Contact(Ball("ball", radius * unit), obstacle, **constants)
    return lissom.Robot([link], gravity=np.multiply(unit, gravity), contacts=[contact])


def overlap(robot, at):
    """The overlap of a ball at a place; NaN if it does not touch."""
    q = np.zeros(robot.n)
    q[:3] = at
    touches = robot.touches(q)
    return touches[0].overlap if touches else np.nan


# Shapes


@pytest.mark.parametrize(
    ("distance", "number", "order", "most"),
    [
        (lambda at: np.linalg.norm(at, axis=-1) - 0.5, 16, 3.5, 1e-4),
        (torus(0.5, 0.25), 16, 3.5, 1e-3),
        (cuboid([0.5, 0.4, 0.3]), 20, 0.8, 0.03),
    ],
    ids=["sphere", "torus", "box"],
)
def test_overlaps_are_those_of_the_shape_to_the_order_of_the_grid(distance, number, order, most):
    """Smooth shapes to the fourth order; the edges of a box are rounded by a part of a cell."""
    generator = np.random.default_rng(2)
    places = generator.uniform(-0.85, 0.85, (3000, 3))
    places = places[np.abs(distance(places) - 0.1) < 0.05][:300]
    errors = []
    for cells in (number, 2 * number):
        grid = sampled(distance, (-1, -1, -1), (1, 1, 1), 2.0 / cells)
        robot = ball_on(grid, radius=0.15, stiffness=1.0)
        found = np.nan_to_num([overlap(robot, place) for place in places])
        errors.append(np.abs(found - (0.15 - distance(places))).max())
    assert errors[1] < most
    assert np.log2(errors[0] / errors[1]) > order


@pytest.mark.parametrize("unit", [1.0, 1000.0])
def test_a_ball_that_rolls_and_bounces_on_a_grid_is_one_on_a_half_space(unit):
    """A plane across the grid, turned, in metres and in millimetres; the ball leaves the grid as well."""
    turn = Rotation.from_rotvec([0.3, -0.2, 0.5])
    normal = turn.apply([0, 0, 1])
    values = np.broadcast_to(np.linspace(-0.2, 0.2, 5), (4, 6, 5)) * unit
    corner = np.array([0.01, 0.02, 0.03]) * unit - turn.apply([0, 0, 0.2]) * unit
    grid = DistanceGrid(values, 0.1 * unit, corner, tuple(turn.as_quat(scalar_first=True)))
    plane = HalfSpace(np.array([0.01, 0.02, 0.03]) * unit, normal)
    ends = []
    for obstacle in (grid, plane):
        robot = ball_on(
            obstacle,
            unit=unit,
            stiffness=1e4,
            friction=0.4,
            dissipation=0.2 / unit,
            slip_velocity=1e-3 * unit,
            gravity=-G * np.array([0, 0, 1]),
        )
        q0 = np.zeros(robot.n)
        q0[:3] = (np.array([0.1, 0.1, 0]) + [0.01, 0.02, 0.03] + 0.09 * normal) * unit
        run = lissom.simulate(robot, 0.8, dt=1e-3, q0=q0)
        assert run.success, run.message
        assert len(run.contact_events()) >= 2
        ends.append(np.concatenate([run.q[-1], run.v[-1]]))
    # The grid is 0.3 m by 0.5 m large.
    assert np.linalg.norm(ends[1][:3]) > 0.6 * unit
    assert_allclose(ends[0], ends[1], rtol=1e-7, atol=1e-7 * unit)


def bowl(at):
    """The lower half of a thick shell, with a round rim."""
    radius, height = np.hypot(at[..., 0], at[..., 1]), at[..., 2]
    shell = np.abs(np.hypot(radius, height) - 0.35) - 0.05
    rim = np.hypot(radius - 0.35, height) - 0.05
    return np.where(height < 0, shell, rim)


def test_a_ball_swings_in_a_bowl_and_keeps_its_energy():
    """Its centre is a pendulum; without friction and dissipation the energy is that of the start."""
    grid = sampled(bowl, (-0.5, -0.5, -0.5), (0.5, 0.5, 0.2), 0.025)
    robot = ball_on(grid, radius=0.06, stiffness=1e5, dissipation=0.0)
    length = 0.3 - 0.06 + G / 1e5
    q0 = np.zeros(robot.n)
    q0[:3] = length * np.array([np.sin(0.1), 0, -np.cos(0.1)])
    # A sixteenth of the square of the amplitude more.
    period = 2 * np.pi * np.sqrt(length / G) * (1 + 0.1**2 / 16)
    run = lissom.simulate(robot, 2 * period, dt=5e-4, q0=q0, method="newmark")
    assert run.success, run.message
    energy = np.array([robot.energy(q, v).total for q, v in zip(run.q, run.v, strict=True)])
    lift = G * length * (1 - np.cos(0.1))
    assert np.ptp(energy) < 0.02 * lift
    assert_allclose(run.q[-1, :3], q0[:3], atol=2e-3)
    assert run.q[np.argmin(np.abs(run.t - 0.5 * period)), 0] < -0.9 * q0[0]


def test_a_ball_that_is_dropped_stays_in_the_bowl():
    grid = sampled(bowl, (-0.5, -0.5, -0.5), (0.5, 0.5, 0.2), 0.025)
    robot = ball_on(grid, radius=0.06, stiffness=1e4, friction=0.3, dissipation=0.5)
    q0 = np.zeros(robot.n)
    q0[:3] = [0.08, 0.05, 0.1]
    run = lissom.simulate(robot, 2.0, dt=1e-3, q0=q0)
    assert run.success, run.message
    assert np.linalg.norm(run.q[-1, :3]) < 0.25
    assert run.q[-1, 2] < -0.2


def rod():
    material = {"young_modulus": 1e6, "poisson_ratio": 0.4, "density": 1000}
    modes = {"bend_y": 4, "bend_z": 4}
    return [lissom.Segment(length, radius=0.01, modes=modes, **material) for length in (0.4, 0.2)]


def test_a_rod_through_a_ring_lies_on_its_inner_side():
    """The hole of a torus; the equilibrium is that on the capsule which fits the place of contact."""
    # The axis of the ring is the x axis, and its lowest inner place is 0.04 below the base of the rod.
    turn = Rotation.from_euler("y", 90, degrees=True)
    grid = sampled(torus(0.06, 0.02), (-0.1, -0.1, -0.05), (0.1, 0.1, 0.05), 0.005)
    corner = np.add((0.4, 0, 0), turn.apply(grid.corner))
    ring = DistanceGrid(grid.values, grid.spacing, corner, tuple(turn.as_quat(scalar_first=True)))
    found = {}
    bar = lissom.Capsule((0.4, -0.2, -0.06), (0.4, 0.2, -0.06), 0.02)
    for name, obstacle in {"ring": ring, "bar": bar}.items():
        robot = lissom.Robot([Link("rod", rod=rod())], contacts=[Contact("rod", obstacle)])
        result = lissom.statics(robot)
        assert result.success, result.message
        touches = robot.touches(result.q)
        assert touches, name
        found[name] = sum(touch.force for touch in touches), result.q
    assert found["bar"][0][2] > 0.1
    # The ring is hollow along y, which the bar is not: to its curvature.
    assert_allclose(found["ring"][0], found["bar"][0], rtol=0.01, atol=1e-3)


def test_a_far_grid_changes_and_costs_nothing():
    """The same run as beside a far ball, bit by bit, with the same evaluations."""
    grid = sampled(torus(0.06, 0.02), (-0.1, -0.1, -0.05), (0.1, 0.1, 0.05), 0.005)
    points, faces = ring_mesh()
    runs = []
    for obstacle in (
        lissom.Sphere((2, 2, 2), 0.1),
        DistanceGrid(grid.values, grid.spacing, (2, 2, 2)),
        Mesh(points + 2, faces),
    ):
        robot = lissom.Robot([Link("rod", rod=rod())], contacts=[Contact("rod", obstacle)])
        runs.append(lissom.simulate(robot, 0.2, dt=2e-3))
        assert runs[-1].success, runs[-1].message
    for run in runs[1:]:
        assert np.array_equal(run.q, runs[0].q)
        assert np.array_equal(run.evaluations, runs[0].evaluations)


# Meshes


def ring_mesh(around=24, across=12, large=0.2, small=0.08):
    """A torus of flat faces."""
    a, b = np.meshgrid(
        2 * np.pi * np.arange(around) / around, 2 * np.pi * np.arange(across) / across, indexing="ij"
    )
    radius = large + small * np.cos(b)
    points = np.stack([radius * np.cos(a), radius * np.sin(a), small * np.sin(b)], axis=-1).reshape(-1, 3)
    number = np.arange(around * across).reshape(around, across)
    p, q = number, np.roll(number, -1, axis=0)
    r, s = np.roll(q, -1, axis=1), np.roll(p, -1, axis=1)
    faces = np.concatenate([np.stack([p, q, r], axis=-1), np.stack([p, r, s], axis=-1)]).reshape(-1, 3)
    return points, faces


def brute(points, faces, places):
    """Unsigned distances by all triangles: inside by their planes, else by their sides."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    found = np.empty(len(places))
    for n, place in enumerate(places):
        least = np.inf
        for start, end in ((a, b), (b, c), (c, a)):
            along = end - start
            share = np.clip(
                np.einsum("fi,fi->f", place - start, along) / np.einsum("fi,fi->f", along, along), 0, 1
            )
            least = min(least, np.linalg.norm(place - start - share[:, None] * along, axis=1).min())
        over = np.einsum("fi,fi->f", place - a, normal)
        foot = place - over[:, None] * normal
        is_within = np.ones(len(faces), bool)
        for start, end in ((a, b), (b, c), (c, a)):
            is_within &= np.einsum("fi,fi->f", np.cross(end - start, foot - start), normal) >= 0
        found[n] = min(least, np.abs(over[is_within]).min(initial=np.inf))
    return found


def test_a_mesh_that_is_not_convex_has_the_distances_of_brute_force():
    points, faces = ring_mesh()
    cell = 0.008
    robot = ball_on(Mesh(points, faces, cell), radius=0.06, stiffness=1.0)
    generator = np.random.default_rng(5)
    places = generator.uniform([-0.35, -0.35, -0.15], [0.35, 0.35, 0.15], (2000, 3))
    exact = torus(0.2, 0.08)(places)
    places = places[(exact > 0.015) & (exact < 0.05)][:150]
    found = np.array([overlap(robot, place) for place in places])
    errors = np.abs(found - (0.06 - brute(points, faces, places)))
    # Edges between its faces are blunt, by no more than the explanation says.
    rounding = float(re.search(r"rounded by up to (\S+) m", str(robot.explain()))[1])
    assert errors.max() < rounding < 0.2 * cell
    assert np.median(errors) < 0.02 * cell
    assert len(places) > 100
    # Faces in any order, and turned in any way, are the same.
    turned = np.where(generator.random(len(faces))[:, None] < 0.5, faces[:, ::-1], faces)
    other = ball_on(Mesh(points, generator.permutation(turned), cell), radius=0.06, stiffness=1.0)
    assert_allclose([overlap(other, place) for place in places], found, rtol=1e-9)


CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
CUBE_FACES = [
    *([0, 1, 3], [0, 3, 2], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4]),
    *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 3, 7], [1, 7, 5]),
]


@pytest.mark.parametrize(("cells", "most"), [(1.5, 0.1), (2, 0.05), (3, 0.04)])
def test_walls_of_two_cells_are_met(cells, most):
    """A plate across a grid whose axes are turned."""
    cell, turn = 0.02, Rotation.from_rotvec([0.4, 0.3, 0.2])
    half = 0.5 * cells * cell
    plate = Mesh(turn.apply(CUBE * [0.2, 0.2, half]), CUBE_FACES, cell)
    robot = ball_on(plate, stiffness=1.0)
    beside = np.random.default_rng(0).uniform(-0.12, 0.12, (60, 2))
    places = turn.apply(np.column_stack([beside, np.full(60, half + 0.03)]))
    errors = np.array([overlap(robot, place) for place in places]) - 0.02
    assert np.abs(errors).max() < most * cell


def test_explanations_have_the_rounding_of_edges():
    points, faces = ring_mesh()
    text = str(ball_on(Mesh(points, faces, 0.008), stiffness=1.0).explain())
    assert "a mesh of 576 faces (edges rounded by up to" in text
    grid = sampled(torus(0.06, 0.02), (-0.1, -0.1, -0.05), (0.1, 0.1, 0.05), 0.005)
    text = str(ball_on(grid, stiffness=1.0).explain())
    assert "a distance grid of 41 x 41 x 21 (edges rounded by up to 5.0e-3 m)" in text


def test_a_start_within_a_mesh_is_refused():
    points, faces = ring_mesh()
    robot = lissom.Robot(
        [Link("rod", rod=rod(), position=(-0.3, 0, 0))], contacts=[Contact("rod", Mesh(points, faces))]
    )
    with pytest.raises(ValueError, match="overlap"):
        lissom.simulate(robot, 0.1)


L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]


def prism(outline, height, scale=0.1):
    number = len(outline)
    points = [(scale * x, scale * y, z) for z in (0, height) for x, y in outline]
    caps = [(0, k, k + 1) for k in range(1, number - 1)]
    walls = [(k, (k + 1) % number) for k in range(number)]
    faces = [(a, c, b) for a, b, c in caps]
    faces += [(a + number, b + number, c + number) for a, b, c in caps]
    for p, q in walls:
        faces += [(p, q, q + number), (p, q + number, p + number)]
    return points, faces


def test_what_is_not_convex_names_the_other_class():
    points, faces = prism(L_SHAPE, 0.1)
    with pytest.raises(ValueError, match="others are a `Mesh`"):
        ball_on(lissom.ConvexMesh(points, faces), stiffness=1.0)
    robot = ball_on(Mesh(points, faces), radius=0.02, stiffness=1.0)
    # In the notch the ball is beside both walls.
    assert_allclose(overlap(robot, (0.115, 0.16, 0.05)), 0.005, atol=1e-4)
    assert_allclose(overlap(robot, (0.16, 0.115, 0.05)), 0.005, atol=1e-4)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda points, faces: Mesh(points, faces[1:]),
            r"faces: got 1 face with the edge between points 0 and",
        ),
        (lambda points, faces: Mesh(points, [*faces[1:], (0, 1, 99)]), r"faces\[\d+\]: got \(0, 1, 99\)"),
        (lambda points, faces: Mesh(points, faces, 0.2), "cell: got .* thinnest wall"),
        (lambda points, faces: Mesh(points, faces, 1e-5), "cell: got .* larger cells"),
        (
            lambda points, faces: Mesh(
                [*points, *np.add(points, 0.05)], [*faces, *np.add(faces, len(points))]
            ),
            "passes through the face .* intersect itself",
        ),
        (lambda points, faces: DistanceGrid(np.ones((3, 3, 3)), 0.1), "no negative number"),
        (lambda points, faces: DistanceGrid(-np.ones((3, 3, 3)), 0.1), "no positive number"),
        (lambda points, faces: DistanceGrid(np.ones((3, 3)), 0.1), "values: dimensions 2, expected three"),
        (lambda points, faces: DistanceGrid(np.ones((3, 3, 1)), 0.1), "3 x 3 x 1 numbers"),
        (lambda points, faces: DistanceGrid([[[1, np.nan], [1, 1]]] * 2, 0.1), r"values\[0\]\[0\]\[1\]"),
    ],
)
def test_what_makes_no_sense_is_refused(make, message):
    points, faces = prism(L_SHAPE, 0.1)
    with pytest.raises((ValueError, TypeError), match=message):
        ball_on(make(points, faces), stiffness=1.0)


@pytest.mark.parametrize("method", ["newmark", "radau"])
def test_nothing_passes_through_a_wall(method):
    """A fast ball and a thin plate, in steps in which it would be on the other side."""
    grid = sampled(cuboid([0.3, 0.3, 0.02]), (-0.4, -0.4, -0.1), (0.4, 0.4, 0.1), 0.01)
    robot = ball_on(grid, radius=0.03, gravity=(0, 0, 0), stiffness=1e5, dissipation=0.0)
    q0, v0 = np.zeros((2, robot.n))
    q0[2], v0[2] = 0.5, -40.0
    run = lissom.simulate(robot, 0.05, dt=5e-3, q0=q0, v0=v0, method=method)
    assert run.q[-1, 2] > 0.0


@pytest.mark.parametrize("size", [1e-4, 1e-2, 1.0, 1e3])
def test_functions_with_the_same_zeros_have_the_same_surface(size):
    """The slope of the square of a radius is proportional to it: neither size nor factors matter."""

    def square(at):
        return (at**2).sum(axis=-1) - size**2

    grid = sampled(square, (-2 * size,) * 3, (2 * size,) * 3, 0.1 * size)
    robot = ball_on(grid, 0.2 * size, stiffness=1.0)
    assert_allclose(overlap(robot, (0, 0, 1.1 * size)), 0.1 * size, rtol=1e-6)
    scaled = DistanceGrid(np.asarray(grid.values) * 1e-7, grid.spacing, grid.corner)
    assert_allclose(
        overlap(ball_on(scaled, 0.2 * size, stiffness=1.0), (0, 0, 1.1 * size)), 0.1 * size, rtol=1e-6
    )
