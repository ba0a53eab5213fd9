"""Tubes: rods and balls in bores, through rings and beside pipes, against closed forms and SciPy."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import lissom

G = 9.81
#: A vessel with bends to all sides, metres.
VESSEL = np.array(
    [(0, 0, 0), (0.1, 0.02, 0), (0.2, -0.02, 0.03), (0.3, 0.03, 0.05), (0.4, 0, -0.02), (0.5, 0.01, 0)]
)


def ball_in(tube, radius=0.01, gravity=(0, 0, -G), stiffness=1e5, joint=None, **constants):
    """A ball of 0.1 kg."""
    body = lissom.Body(0.1, inertia=0.04 * radius**2 * np.eye(3))
    link = lissom.Link("ball", joint=joint or lissom.Free(), body=body)
    contact = lissom.Contact(lissom.Ball("ball", radius), tube, stiffness=stiffness, **constants)
    return lissom.Robot([link], gravity=gravity, contacts=[contact])


def centre_line(points, number=2001):
    """Places of the cubic spline through points over their chords, by SciPy, and their directions."""
    chords = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
    if len(points) == 2:
        x = np.linspace(0.0, 1.0, number)[:, None]
        places = points[0] + x * (points[1] - points[0])
        return places, np.broadcast_to((points[1] - points[0]) / chords[-1], places.shape)
    spline = CubicSpline(chords, points)
    x = np.linspace(0.0, chords[-1], number)
    slopes = spline(x, 1)
    return spline(x), slopes / np.linalg.norm(slopes, axis=1, keepdims=True)


# Shapes of walls


def test_balls_touch_the_wall_where_it_is():
    """In the bore, at the rim, at the flat end of the wall and outside."""
    tube = lissom.Tube([(0, 0, 0), (1, 0, 0)], 0.05, wall=0.02)
    robot = ball_in(tube)
    corner = np.array([0.005, 0, 0.006]) / np.hypot(0.005, 0.006)
    for place, overlap, normal in [
        ((0.5, 0, 0.042), 0.002, (0, 0, -1)),
        ((0.5, 0.078, 0), 0.002, (0, 1, 0)),
        ((1.008, 0, 0.06), 0.002, (1, 0, 0)),
        ((-0.008, -0.06, 0), 0.002, (-1, 0, 0)),
        ((1.005, 0, 0.044), 0.01 - np.hypot(0.005, 0.006), corner * [1, 1, -1]),
        ((1.005, 0, 0.076), 0.01 - np.hypot(0.005, 0.006), corner),
    ]:
        (touch,) = robot.touches([*place, 0, 0, 0])
        assert touch.overlap == pytest.approx(overlap, abs=1e-12)
        assert_allclose(touch.normal, normal, atol=1e-12)
    for place in [(0.5, 0, 0), (0.5, 0.03, 0.02), (1.02, 0, 0.045), (2, 0, 0), (0.5, 0.09, 0)]:
        assert not robot.touches([*place, 0, 0, 0])


def test_the_centre_line_is_the_spline_through_the_points():
    """Walls of a bent vessel, by the nearest of many places of SciPy's spline."""
    robot = ball_in(lissom.Tube(VESSEL, 0.02))
    places, along = centre_line(VESSEL, 40001)
    random = np.random.default_rng(0)
    for k in random.integers(500, 39500, 40):
        outward = np.cross(along[k], random.normal(size=3))
        outward *= random.uniform(0.0105, 0.0195) / np.linalg.norm(outward)
        point = places[k] + outward
        distance = np.linalg.norm(places - point, axis=1).min()
        (touch,) = robot.touches([*point, 0, 0, 0])
        assert touch.overlap == pytest.approx(0.01 - (0.02 - distance), abs=1e-9)
        assert touch.normal @ outward < 0


def test_a_finer_line_through_the_same_curve_is_the_same_tube():
    fine, _ = centre_line(VESSEL, 201)
    coarse, same = (ball_in(lissom.Tube(points, 0.02)) for points in (VESSEL, fine))
    q = [*(fine[77] + [0.002, 0.009, -0.008]), 0, 0, 0]
    (first,), (second,) = coarse.touches(q), same.touches(q)
    assert first.overlap == pytest.approx(second.overlap, abs=1e-9)
    assert_allclose(first.normal, second.normal, atol=1e-4)


LENGTH, PLACES = 0.6, 3001


def random_rod(radius):
    segment = lissom.Segment(
        LENGTH / 4, radius, 1e7, 4e6, 1000, modes={"bend_y": 3, "bend_z": 3, "torsion": 1}
    )
    return lissom.Link("rod", joint=lissom.Free(), rod=[segment] * 4)


@pytest.mark.parametrize("clearance", [1e-3, 5e-3, 2e-2])
@pytest.mark.parametrize(
    "points", [VESSEL, VESSEL[[0, 5]], VESSEL[[2, 3]]], ids=["vessel", "straight", "short"]
)
def test_no_overlap_is_overlooked(points, clearance):
    """Rods that cross the bore and its ends at random, beside distances of many places."""
    radius = 2e-3
    tube = lissom.Tube(points, radius + clearance, wall=0.01)
    robot = lissom.Robot([random_rod(radius)], contacts=[lissom.Contact("rod", tube, stiffness=1e4)])
    x = np.linspace(0.0, LENGTH, PLACES)
    line, along = centre_line(points, 4001)
    tree = cKDTree(line)
    met = 0
    for seed in range(8):
        random = np.random.default_rng(seed)
        q = random.normal(size=robot.n) * random.choice([0.03, 0.2])
        q[:6] = 0.0
        middle = random.integers(len(line))
        turn = Rotation.align_vectors(along[middle][None], [[1, 0, 0]])[0] * Rotation.from_rotvec(
            random.normal(size=3) * random.choice([0.01, 0.1, 0.3])
        )
        q[3:6] = turn.as_rotvec()
        there = robot.pose(q, 0.5 * LENGTH, link="rod")[:3, 3]
        q[:3] += line[middle] + clearance * random.uniform(-0.5, 0.5, 3) - there
        found = robot.pose(q, x, link="rod")[:, :3, 3]
        distance, nearest = tree.query(found)
        inner = (nearest > 8) & (nearest < len(line) - 9)
        overlap = np.where(
            inner, np.minimum(distance - clearance, clearance + 0.01 + 2 * radius - distance), -1.0
        )
        touched = [touch.along[0] for touch in robot.touches(q)]
        ends = np.flatnonzero(np.diff(np.r_[0, (overlap > 1e-5).astype(int), 0]))
        for begin, end in zip(ends[::2], ends[1::2], strict=True):
            met += 1
            assert any(x[begin] - 1e-3 <= at <= x[end - 1] + 1e-3 for at in touched), (
                seed,
                overlap[begin:end].max(),
            )
    assert met > 1


# Motions of balls


@pytest.mark.parametrize("friction", [0.0, 1.0])
def test_a_ball_swings_across_a_tube(friction):
    """Period of a pendulum as long as the clearance; one that rolls is 7/5 as heavy."""
    bore, radius = 0.06, 0.01
    robot = ball_in(lissom.Tube([(-1, 0, 0), (1, 0, 0)], bore), radius, friction=friction, slip_velocity=1e-6)
    length, swing = bore - radius + 0.1 * G / 1e5, 0.02
    q0 = [0, length * np.sin(swing), -length * np.cos(swing), 0, 0, 0]
    inertia = 1.4 if friction else 1.0
    period = 2 * np.pi * np.sqrt(inertia * length / G) * (1 + swing**2 / 16)
    run = lissom.simulate(
        robot, 2 * period, q0=q0, method="radau", rtol=1e-8, t_eval=np.linspace(0, 2 * period, 401)
    )
    assert run.success, run.message
    y = run.q[:, 1] / q0[1]
    assert_allclose(y, np.cos(2 * np.pi * run.t / period), atol=6e-3)


def test_a_ball_runs_round_bends_without_loss():
    """Without friction and weight it keeps its speed, and leaves through the end along the centre line."""
    line, along = centre_line(VESSEL)
    robot = ball_in(lissom.Tube(VESSEL, 0.0102), 0.01, gravity=(0, 0, 0), stiffness=1e6, dissipation=0.0)
    q0 = np.r_[line[20], 0, 0, 0]
    run = lissom.simulate(robot, 0.8, q0=q0, v0=np.r_[along[20], 0, 0, 0], method="radau", rtol=1e-8)
    assert run.success, run.message
    energy = [robot.energy(q, v) for q, v in zip(run.q, run.v, strict=True)]
    assert max(abs(each.total - energy[0].total) for each in energy) < 1e-4 * energy[0].total
    assert (run.q[-1, :3] - line[-1]) @ along[-1] > 0.05
    assert np.linalg.norm(run.v[-1, :3]) == pytest.approx(1.0, rel=1e-3)
    # All the way it is within the bore.
    inside = run.q[(run.q[:, 0] > 0.01) & (run.q[:, 0] < 0.49), :3]
    assert len(inside) > 50
    assert max(np.linalg.norm(line - place, axis=1).min() for place in inside) < 6e-4


def test_a_tube_that_is_carried_is_one_at_rest():
    """A rod in a tube on a link that is turned feels the forces of the turned tube."""
    turn = Rotation.from_rotvec([0.3, -0.8, 0.4])
    place = np.array([0.2, -0.1, 0.3])
    carrier = lissom.Link("carrier", joint=lissom.Free(), body=lissom.Body(1.0, inertia=(1, 1, 1)))
    tube = lissom.Tube(VESSEL, 5e-3, link="carrier")
    still = lissom.Tube(turn.apply(VESSEL) + place, 5e-3)
    base = lissom.Link("rod", joint=lissom.Free(), rod=random_rod(2e-3).rod)
    moving = lissom.Robot(
        [carrier, base], contacts=[lissom.Contact("rod", tube, stiffness=1e4, friction=0.3)]
    )
    fixed = lissom.Robot(
        [carrier, base], contacts=[lissom.Contact("rod", still, stiffness=1e4, friction=0.3)]
    )
    random = np.random.default_rng(3)
    q = 0.02 * random.normal(size=moving.n)
    q[:6] = [*place, *turn.as_rotvec()]
    q[6:12] = [*(turn.apply([0.02, 0.004, 0.001]) + place), *turn.as_rotvec()]
    v = 0.1 * random.normal(size=moving.n)
    v[:6] = 0.0
    mine, other = (robot.contact_forces(q, v)[3:] for robot in (moving, fixed))
    assert np.linalg.norm(other) > 0.5
    assert_allclose(mine, other, rtol=1e-9, atol=1e-9)


# Rods


def heavy(length, radius, parts=8, modes=3, young_modulus=2e9, density=2000.0, **more):
    segment = lissom.Segment(
        length / parts,
        radius,
        young_modulus,
        young_modulus / 2.6,
        density,
        modes={"bend_y": modes, "bend_z": modes, "torsion": 1},
        **more,
    )
    return [segment] * parts


def test_a_ring_props_a_cantilever():
    """It carries 3/8 of the weight at the tip, less what bends the rod through the clearance."""
    length, radius, clearance, at = 0.5, 2e-3, 1e-4, 0.49
    rod = lissom.Link("rod", rod=heavy(length, radius, parts=5))
    ring = lissom.Tube([(at - 1e-3, 0, 0), (at + 1e-3, 0, 0)], radius + clearance, wall=2e-3)
    robot = lissom.Robot([rod], contacts=[lissom.Contact("rod", ring, stiffness=1e7)])
    found = lissom.statics(robot)
    assert found.success, found.message
    stiffness = 2e9 * np.pi * radius**4 / 4
    weight = 2000.0 * np.pi * radius**2 * G
    # Deflection of a cantilever at the place of the prop, by its weight and by a force there.
    by_weight = weight * at**2 * (6 * length**2 - 4 * length * at + at**2) / (24 * stiffness)
    wanted = (by_weight - clearance) * 3 * stiffness / at**3
    force = robot.contact_forces(found.q, np.zeros(robot.n))[5]
    assert force == pytest.approx(wanted, rel=0.01)
    assert 0.35 * weight * length < force < 0.42 * weight * length


def winding(turn=None, mirror=1.0, scale=1.0, number=41):
    """Points of a vessel that begins straight along x and winds about it, seen by somebody else."""
    x = np.linspace(0.0, 0.4, number)
    growth = np.minimum(x / 0.1, 1.0) ** 2 * (3.0 - 2.0 * np.minimum(x / 0.1, 1.0))
    angle = 2 * np.pi * x / 0.2
    beside = 0.01 * growth * np.sin(angle), 0.008 * growth * (np.cos(angle) - 1.0)
    points = np.column_stack([x, mirror * beside[0], beside[1]])
    return scale * (turn or Rotation.identity()).apply(points)


def first(line, length):
    """Those of many places along a line that come within a length."""
    return line[np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))] < length]


def hung(turn=None, mirror=1.0, scale=1.0, **law):
    """A rod of rubber that hangs in that vessel, and its equilibrium.

    There are `scale` units of length to the metre, and forces are kilograms times these per square second.
    """
    turn = turn or Rotation.identity()
    segments = heavy(
        0.35 * scale, 2e-3 * scale, parts=7, modes=3, young_modulus=2e7 / scale, density=2000.0 / scale**3
    )
    rod = lissom.Link("rod", rod=segments, orientation=tuple(np.roll(turn.as_quat(), 1)))
    vessel = lissom.Tube(winding(turn, mirror, scale), 5e-3 * scale)
    contact = lissom.Contact("rod", vessel, stiffness=1e5 / scale, **law)
    gravity = scale * turn.apply([0, mirror * -3.0, -9.0])
    robot = lissom.Robot([rod], gravity=tuple(gravity), contacts=[contact])
    # In the axes of the rod's base.
    start = robot.coordinates_of(first(winding(None, mirror, scale, 401), 0.35 * scale))
    found = lissom.statics(robot, start.q)
    assert found.success, found.message
    return robot, found.q


@pytest.mark.parametrize("change", ["turned", "mirrored", "millimetres"])
def test_equilibria_do_not_depend_on_who_looks(change):
    """A rod that hangs in a vessel: turned with gravity, mirrored, and in other units of length."""
    turn = Rotation.from_rotvec([0.4, 0.2, -0.3]) if change == "turned" else Rotation.identity()
    mirror = -1.0 if change == "mirrored" else 1.0
    scale = 1e3 if change == "millimetres" else 1.0
    shapes = []
    for seen in ({}, {"turn": turn, "mirror": mirror, "scale": scale}):
        robot, q = hung(**seen)
        assert len(robot.touches(q)) > 20
        length = 0.35 * seen.get("scale", 1.0)
        shapes.append(robot.pose(q, np.linspace(0, length, 21), link="rod")[:, :3, 3])
    assert_allclose(scale * turn.apply(shapes[0] * [1, mirror, 1]), shapes[1], atol=2e-6 * scale)


def test_tangents_are_exact():
    """Beside differences, where a rod lies in bends of the vessel, and with friction."""
    robot, q = hung(friction=0.3, slip_velocity=0.1)
    free = lissom.Robot(robot.links, gravity=robot.gravity)
    random = np.random.default_rng(1)
    v, a, h = 0.1 * random.normal(size=robot.n), np.zeros(robot.n), 1e-6

    def forces(q, v):
        return robot.inverse_dynamics(q, v, a) - free.inverse_dynamics(q, v, a)

    units = np.eye(robot.n)
    moved = np.transpose([(forces(q + h * e, v) - forces(q - h * e, v)) / (2 * h) for e in units])
    faster = np.transpose([(forces(q, v + h * e) - forces(q, v - h * e)) / (2 * h) for e in units])
    tangents = zip(robot.tangent(q, v, a), free.tangent(q, v, a), strict=True)
    stiffness, damping, _ = (mine - other for mine, other in tangents)
    # As on other curved obstacles: the Gauss points move with the ends of the overlap.
    assert_allclose(stiffness, moved, atol=1e-3 * np.abs(moved).max())
    assert_allclose(damping, faster, atol=1e-7 * np.abs(faster).max())


def test_a_tangent_of_a_ball_is_exact():
    robot = ball_in(lissom.Tube(VESSEL, 0.02), friction=0.3, slip_velocity=0.1)
    free = lissom.Robot(robot.links, gravity=robot.gravity)
    line, along = centre_line(VESSEL)
    a, h = np.zeros(6), 1e-6
    for k, side in [(400, (0, 1, 1)), (1100, (0, -1, 0)), (1990, (0, 0, -1))]:
        beside = np.cross(along[k], side)
        beside *= 0.012 / np.linalg.norm(beside)
        q, v = np.r_[line[k] + beside, 0.1, -0.2, 0.3], np.array([0.1, 0.2, -0.1, 1.0, 2.0, -1.0])

        def forces(q, v):
            return robot.inverse_dynamics(q, v, a) - free.inverse_dynamics(q, v, a)

        assert robot.touches(q, v)
        units = np.eye(6)
        moved = np.transpose([(forces(q + h * e, v) - forces(q - h * e, v)) / (2 * h) for e in units])
        stiffness = robot.tangent(q, v, a)[0] - free.tangent(q, v, a)[0]
        assert_allclose(stiffness, moved, atol=1e-7 * np.abs(moved).max())


# A catheter in a vessel


def five_bends(number=26):
    """Points of a planar vessel that begins straight along the x axis, and winds about it."""
    x = np.linspace(0.0, 0.25, number)
    part = np.minimum(x / 0.05, 1.0)
    fade = part**2 * (3.0 - 2.0 * part)
    return np.column_stack([x, 0 * x, 8e-3 * fade * np.sin(2 * np.pi * x / 0.1)])


RADIUS, CLEARANCE, LONG, BENDING, WALL = 0.5e-3, 1e-3, 0.24, 2e-5, 1e5


def energies(angles, line, along):
    """Square roots of twice the energies of a chain of bars between walls: of bending and of overlaps."""
    bar = LONG / len(angles)
    steps = bar * np.column_stack([np.cos(angles), np.sin(angles)])
    ends = np.cumsum(steps, axis=0)
    middles = ends - 0.5 * steps
    # The nearest place of the centre line, as that of the parabola through three places.
    k = np.clip(np.linalg.norm(middles[:, None] - line[None], axis=2).argmin(axis=1), 1, len(line) - 2)
    way = middles - line[k]
    distance = np.abs(along[k, 0] * way[:, 1] - along[k, 1] * way[:, 0])
    overlap = np.maximum(distance - CLEARANCE, 0.0)
    bends = np.diff(angles, prepend=0.0) * np.sqrt(np.r_[2.0, np.ones(len(angles) - 1)])
    return np.r_[np.sqrt(BENDING / bar) * bends, np.sqrt(WALL * bar) * overlap]


@pytest.mark.slow
def test_a_catheter_in_five_bends_is_an_elastica_between_two_walls():
    """Beside a chain of bars of least energy, by SciPy; and the same vessel of ten times as many points."""
    points = five_bends()
    young = 4 * BENDING / (np.pi * RADIUS**4)
    segment = lissom.Segment(LONG / 12, RADIUS, young, young / 2.6, 1000.0, modes={"bend_y": 3})
    x = np.linspace(0.0, LONG, 241)
    shapes, forces = [], []
    for tube in (points, centre_line(points, 251)[0]):
        contact = lissom.Contact("rod", lissom.Tube(tube, RADIUS + CLEARANCE), stiffness=WALL)
        rod = lissom.Link("rod", rod=[segment] * 12)
        robot = lissom.Robot([rod], contacts=[contact], gravity=(0, 0, 0))
        start = robot.coordinates_of(first(centre_line(points, 501)[0], LONG))
        found = lissom.statics(robot, start.q)
        assert found.success, found.message
        shapes.append(robot.pose(found.q, x, link="rod")[:, [0, 2], 3])
        touches = robot.touches(found.q)
        forces.append(sum(touch.force @ touch.normal for touch in touches))
        sides = {np.sign(touch.normal[2]) for touch in touches}
        assert sides == {-1.0, 1.0}
    assert_allclose(shapes[0], shapes[1], atol=1e-6)
    assert forces[0] == pytest.approx(forces[1], rel=1e-3)

    line, along = (values[:, [0, 2]] for values in centre_line(points, 4001))
    bars = 240
    start = np.arctan2(*np.diff(shapes[0], axis=0).T[::-1])
    best = least_squares(energies, start, args=(line, along), method="lm", xtol=1e-14, ftol=1e-14)
    bar = LONG / bars
    ends = np.cumsum(bar * np.column_stack([np.cos(best.x), np.sin(best.x)]), axis=0)
    assert_allclose(ends, shapes[0][1:], atol=2e-5)
    overlap = energies(best.x, line, along)[bars:] / np.sqrt(WALL * bar)
    assert WALL * bar * overlap.sum() == pytest.approx(forces[0], rel=0.01)


def facets(points, number, thickness):
    """Capsules in the plane that are both walls of a vessel: chords of the curves beside its centre line."""
    line, along = centre_line(points, 20001)
    across = np.column_stack([-along[:, 2], 0 * along[:, 0], along[:, 0]])
    for side in (1, -1):
        wall = line + side * (RADIUS + CLEARANCE + thickness) * across
        way = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(wall, axis=0), axis=1))]
        stations = np.linspace(0.0, way[-1], number + 1)
        ends = np.column_stack([np.interp(stations, way, each) for each in wall.T])
        yield from (lissom.Capsule(tuple(start), tuple(end), thickness) for start, end in pairwise(ends))


@pytest.mark.parametrize("number", [50, 100])
def test_a_vessel_of_five_bends_is_that_of_many_capsules(number):
    """Within what the facets of the capsules cut off or add."""
    points, thickness, stiffness = five_bends(), 2e-3, 1e7
    young = 4 * BENDING / (np.pi * RADIUS**4)
    segment = lissom.Segment(LONG / 12, RADIUS, young, young / 2.6, 1000.0, modes={"bend_y": 3})
    walls = {"tube": [lissom.Tube(points, RADIUS + CLEARANCE)], "capsules": facets(points, number, thickness)}
    shapes, forces = {}, {}
    for kind, shape in walls.items():
        contacts = [
            lissom.Contact("rod", each, stiffness=stiffness, name=f"wall {k}") for k, each in enumerate(shape)
        ]
        rod = lissom.Link("rod", rod=[segment] * 12)
        robot = lissom.Robot([rod], contacts=contacts, gravity=(0, 0, 0))
        start = robot.coordinates_of(first(centre_line(points, 501)[0], LONG))
        found = lissom.statics(robot, start.q)
        assert found.success, found.message
        shapes[kind] = robot.pose(found.q, np.linspace(0.0, LONG, 241), link="rod")[:, :3, 3]
        forces[kind] = sum(touch.force @ touch.normal for touch in robot.touches(found.q))
    # Height of the arc over a chord, where the vessel bends most.
    line, along = centre_line(points, 20001)
    way = np.linalg.norm(np.diff(line, axis=0), axis=1)
    bend = (np.linalg.norm(np.diff(along, axis=0), axis=1) / way).max()
    facet = bend * (way.sum() / number) ** 2 / 8
    assert facet < 0.15 * CLEARANCE
    # The rod touches corners: between two of them it may be off by as much again.
    assert_allclose(shapes["capsules"], shapes["tube"], atol=2 * facet)
    assert forces["capsules"] == pytest.approx(forces["tube"], rel=facet / CLEARANCE)


def guided(kind, seed):
    """A wire with a load in a guide that it passes through, or in a bend from its clamp on, and a start."""
    random = np.random.default_rng(seed)
    length, radius = 10.0 ** random.uniform(-1, 0.3), 10.0 ** random.uniform(-3.6, -2.3)
    radius *= length
    young, density = ((2.1e11, 7800.0), (5e10, 6450.0))[seed % 2]
    parts = 1 + seed % 3
    segment = lissom.Segment(
        length / parts, radius, young, poisson_ratio=0.3, density=density, modes={"bend_y": 4}
    )
    s = np.linspace(0, length, 300)
    curvature = 0.0 if kind == "guide" else random.uniform(0.3, 1.5) / length

    def place(s):
        if curvature == 0.0:
            return np.column_stack([s, 0 * s, 0 * s])
        return np.column_stack([np.sin(curvature * s), 0 * s, 1 - np.cos(curvature * s)]) / [
            curvature,
            1,
            curvature,
        ]

    ends = (0.3 * length, 0.9 * length) if kind == "guide" else (0.0, 1.1 * length)
    points = place(np.linspace(*ends, 2 if kind == "guide" else 23))
    tube = lissom.Tube(points, radius * random.uniform(1.3, 3.5))
    force = young * np.pi * radius**4 / 4 / length**2 * 10 ** random.uniform(-1, 1)
    load = lissom.Load(link="rod", force=(0, 0, force * random.choice([-1, 1])))
    robot = lissom.Robot(
        [lissom.Link("rod", rod=[segment] * parts)], contacts=[lissom.Contact("rod", tube)], loads=[load]
    )
    start = np.zeros(robot.n) if kind == "guide" else robot.coordinates_of(place(s)).q
    return robot, start, tube, radius, length


@pytest.mark.parametrize("kind", ["guide", "bend"])
@pytest.mark.parametrize("seed", range(12))
@pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")
def test_wires_come_to_rest_in_guides_and_bends(kind, seed):
    """Forces jumped: overlaps beside ends of tubes, and those of long parts with a wall, were overlooked."""
    robot, start, tube, radius, length = guided(kind, seed)
    found = lissom.statics(robot, start)
    assert found.success, found.message
    assert found.njev <= 300
    # Nothing is overlooked: the wire is in the wall only near contact points.
    s = np.linspace(0, length, 2001)
    places = robot.pose(found.q, s, link="rod")[:, :3, 3]
    line = centre_line(np.array(tube.points), 20001)[0]
    distance, nearest = cKDTree(line).query(places)
    is_beside = (nearest > 0) & (nearest < len(line) - 1)
    is_deep = is_beside & (distance + radius - tube.radius > 1e-2 * radius)
    touched = np.array([touch.along[0] for touch in robot.touches(found.q)])
    for at in s[is_deep]:
        assert np.abs(touched - at).min() < 0.02 * length


# What is refused


def in_tube(tube, segment=None, surface="rod"):
    rod = lissom.Link(
        "rod", rod=[segment or lissom.Segment(0.3, 2e-3, 1e7, 4e6, 1000, modes={"bend_y": 2, "bend_z": 2})]
    )
    return lissom.Robot([rod], contacts=[lissom.Contact(surface, tube, stiffness=1e4)])


LINE = [(0, 0, 0), (1, 0, 0)]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: in_tube(lissom.Tube([(0, 0, 0)], 0.1)), "1 points.*2 to 1000"),
        (lambda: in_tube(lissom.Tube([(0, 0, 0), (0, 0, 0), (1, 0, 0)], 0.1)), r"points\[1\].*another point"),
        (lambda: in_tube(lissom.Tube([(0, 0, 0), (np.nan, 0, 0)], 0.1)), r"points\[1\]|finite"),
        (lambda: in_tube(lissom.Tube([(0, 0), (1, 0)], 0.1)), "points"),
        (lambda: in_tube(lissom.Tube(LINE, 0.0)), "radius"),
        (lambda: in_tube(lissom.Tube(LINE, 0.1, wall=-1.0)), "wall"),
        (lambda: in_tube(lissom.Tube(VESSEL, 0.08)), r"radius.*less than 0\.0\d+ m.*bends as tightly"),
        # A hairpin, whose legs are 2 cm apart.
        (
            lambda: in_tube(
                lissom.Tube([(0, 0, 0), (0.5, 0, 0), (0.6, 0.1, 0), (0.5, 0.02, 0.1), (0, 0.02, 0)], 0.02)
            ),
            "comes as near to itself",
        ),
        (lambda: in_tube(lissom.Tube(LINE, 2e-3)), r"contacts\[0\]\.a.*0\.002 m thick.*< 0\.002 m.*Capsule"),
        (lambda: in_tube(lissom.Tube(LINE, 0.1), surface=lissom.Ball("rod", 0.1)), r"0\.1 m thick"),
        (
            lambda: in_tube(
                lissom.Tube(LINE, 0.1),
                lissom.Segment(
                    0.3,
                    section=lissom.Section.rectangle(2e-3, 4e-3),
                    young_modulus=1e7,
                    shear_modulus=4e6,
                    density=1000,
                    modes={"bend_y": 2, "bend_z": 2},
                ),
            ),
            "round sections",
        ),
        (
            lambda: in_tube(lissom.HalfSpace(), surface=lissom.Tube(LINE, 0.1, link="rod")),
            "a half-space for a tube|a tube for a half-space|half-spaces, height fields and tubes",
        ),
    ],
)
def test_what_makes_no_sense_is_refused(make, message):
    with pytest.raises((ValueError, TypeError), match=message):
        make()


def test_a_rod_that_starts_in_the_wall_is_refused_and_one_outside_stays_there():
    segment = lissom.Segment(0.3, 2e-3, 1e7, 4e6, 1000, modes={"bend_y": 2, "bend_z": 2})
    for height, message in [(0.015, "sunk into what it touches"), (0.05, None)]:
        rod = lissom.Link("rod", joint=lissom.Free(), rod=[segment], position=(0.1, 0, height))
        tube = lissom.Contact("rod", lissom.Tube(LINE, 0.01, wall=0.02), stiffness=1e4)
        robot = lissom.Robot([rod], contacts=[tube])
        if message:
            with pytest.raises(ValueError, match=message):
                lissom.simulate(robot, 0.1, dt=1e-3)
            continue
        run = lissom.simulate(robot, 0.3, dt=1e-3)
        assert run.success, run.message
        assert 0.031 < run.q[:, 2].min() + height < 0.032


@pytest.mark.parametrize("length", [2e-3, 4e-2])
@pytest.mark.parametrize("unit", [1.0, 1e-3])
def test_a_soft_rod_rests_on_the_ring_that_it_sags_in(length, unit):
    """However short the ring: the search for the equilibrium does not step through its wall."""
    segment = lissom.Segment(
        1.0 / unit,
        0.004 / unit,
        1e8 * unit,
        poisson_ratio=0.45,
        density=1000 * unit**3,
        modes={"bend_y": 8},
    )
    points = np.array([(0.7 - length / 2, 0, 0), (0.7 + length / 2, 0, 0)]) / unit
    ring = lissom.Tube(points, 0.012 / unit)
    robot = lissom.Robot(
        [lissom.Link("rod", rod=[segment])],
        contacts=[lissom.Contact("rod", ring)],
        gravity=(0, 0, -9.81 / unit),
    )
    found = lissom.statics(robot, space_error=False)
    assert found.success
    height = robot.pose(found.q, [0.7 / unit], link="rod")[0, 2, 3] * unit
    assert -0.0105 < height < -0.0075


def in_a_bend(points, radius=3e-3):
    """A rod of 0.09 m in the straight part of a tube, which bends after 0.1 m."""
    segment = lissom.Segment(0.09, 1e-3, 5e7, poisson_ratio=0.4, density=1200.0, modes={"bend_y": 3})
    tube = lissom.Tube(points, radius=radius)
    return lissom.Rod([segment], contacts=[lissom.Contact("rod", tube)], gravity=(0, 0, 0))


BULGING = [(0, 0, 0), (0.1, 0, 0), (0.15, 0, 0.05)]


def test_refusals_say_where_the_centre_line_leaves_its_points():
    rod = in_a_bend(BULGING)
    # The parabola through the three points, by hand over the lengths of the chords.
    times = np.cumsum([0.0, 0.1, np.hypot(0.05, 0.05)])
    parabola = np.polynomial.Polynomial(
        np.linalg.solve(np.vander(times, 3, increasing=True), np.array(BULGING)[:, 2])
    )
    bulge = -parabola(np.linspace(0.0, 0.1, 1000)).min()
    written = f"{bulge:.1e}".replace("e-02", "e-2")
    said = f"m is {written} m beside the straight line between two of them "
    said += "(the radius of the bore is 0.003 m): give more points"
    with pytest.raises(ValueError, match="is sunk into what it touches") as refused:
        lissom.simulate(rod, 0.01)
    assert said in str(refused.value)
    assert said in lissom.statics(rod, method="descent").message
    # As a scene.
    with pytest.raises(ValueError, match="overlap") as refused:
        rod.to_scene()
    assert said in " ".join(str(refused.value).split())


def test_more_points_in_the_straight_part_are_what_helps():
    straight = [(x, 0, 0) for x in (0, 0.03, 0.06, 0.08, 0.1)]
    assert lissom.simulate(in_a_bend([*straight, (0.125, 0, 0.012), (0.15, 0, 0.05)]), 0.01).success


def test_other_refusals_say_nothing_of_it():
    """A rod across a straight tube, whose centre line is that of its points."""
    across = in_a_bend([(0.05, 0, -0.1), (0.05, 0, 0.1)])
    with pytest.raises(ValueError, match="is sunk into what it touches") as refused:
        lissom.simulate(across, 0.01)
    assert "centre line" not in str(refused.value)
