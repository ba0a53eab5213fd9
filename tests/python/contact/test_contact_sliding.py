"""Tangents where nearest places slide along rods when these move, against differences of the forces."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

LENGTH = 0.5
MODES = {"torsion": 1, "bend_y": 3, "bend_z": 3, "stretch": 1}


def about(axis, angle):
    axis = np.asarray(axis) / np.linalg.norm(axis)
    return np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * axis])


def product(a, b):
    return np.concatenate(
        [[a[0] * b[0] - a[1:] @ b[1:]], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])]
    )


def rotated(quaternion, vector):
    inverse = quaternion * [1, -1, -1, -1]
    return product(product(quaternion, np.concatenate([[0.0], vector])), inverse)[1:]


def free_rod(name, radius, position=(0, 0, 0), orientation=(1, 0, 0, 0), unit=1.0):
    radius = np.multiply(radius, unit)
    segment = lissom.Segment(
        LENGTH * unit, radius=tuple(radius) if np.ndim(radius) else float(radius), young_modulus=1e6 / unit,
        poisson_ratio=0.45, density=1000, modes=MODES,
    )  # fmt: skip
    place = np.multiply(position, unit)
    return lissom.Link(name, joint=lissom.Free(), rod=[segment], position=place, orientation=orientation)


def crossed(gap, angle, radii, *, turn=(1.0, 0, 0, 0), unit=1.0, **constants):
    """A rod and another one above it, at this angle, `gap` between the axes; in other units, and turned."""
    turn = np.asarray(turn) / np.linalg.norm(turn)
    place = (0.22 - 0.23 * np.cos(angle), -0.23 * np.sin(angle), gap)
    over = product(turn, about((0, 0, 1), angle))
    links = [
        free_rod("a", radii[0], orientation=turn, unit=unit),
        free_rod("b", radii[1], rotated(turn, place), over, unit=unit),
    ]
    contact = lissom.Contact(
        "a", "b", stiffness=1e5, slip_velocity=0.05 * unit, dissipation=1.0 / unit, **constants
    )
    return lissom.Robot(links, gravity=(0, 0, 0), contacts=[contact])


def sizes_of(robot, unit=1.0):
    """A unit of each coordinate, as it is without the unit of length: metres, radians, strains per metre."""
    sizes = np.ones(robot.n)
    for link in robot.links:
        own = robot.slice(link.name)
        sizes[own.start : own.start + 3] = unit
        if own.stop - own.start > 6:
            sizes[own.start + 6 : own.stop - 1] = 1 / unit
    return sizes


def compared(robot, q, v, sizes):
    """Stiffness of contact by differences; errors of tangents and of that, relative to the largest entry."""
    a = np.zeros(robot.n)
    free = lissom.Robot(robot.links, gravity=robot.gravity)

    def forces(q, v):
        return (robot.inverse_dynamics(q, v, a) - free.inverse_dynamics(q, v, a)) * sizes

    def differences(change, h):
        def along(e):
            steps = zip((8.0, -8.0, -1.0, 1.0), (h, -h, 2 * h, -2 * h), strict=True)
            return sum(weight * change(step * e) for weight, step in steps) / (12 * h)

        return np.transpose([along(e) for e in np.diag(sizes)])

    moved, wider = (differences(lambda d: forces(q + d, v), h) for h in (1e-6, 2e-6))
    faster = differences(lambda d: forces(q, v + d), 1e-4)
    stiffness, damping, _ = (
        (mine - other) * np.outer(sizes, sizes)
        for mine, other in zip(robot.tangent(q, v, a), free.tangent(q, v, a), strict=True)
    )
    largest = np.abs(moved).max()
    if largest == 0.0:
        return moved, 0.0, 0.0, 0.0
    error_of_damping = np.abs(damping - faster).max() / max(np.abs(faster).max(), 1e-300)
    return (
        moved,
        np.abs(stiffness - moved).max() / largest,
        error_of_damping,
        np.abs(moved - wider).max() / largest,
    )


def bent(robot, seed, sizes, strain=0.05):
    random = np.random.default_rng(seed)
    q = strain * random.standard_normal(robot.n)
    for link in robot.links:
        start = robot.slice(link.name).start
        q[start : start + 6] = 1e-4 * random.standard_normal(6)
    return q * sizes, 0.05 * random.standard_normal(robot.n) * sizes


PLACEMENTS = [
    (1.0, (1.0, 0.0, 0.0, 0.0), 0.0),
    (1e-3, (0.3, -0.5, 0.7, 0.2), 0.5),
    (30.0, (-0.4, 0.1, 0.2, 0.9), (0.2, 0.4, 0.7)),
]


@pytest.mark.parametrize(("unit", "turn", "friction"), PLACEMENTS)
@pytest.mark.parametrize("angle", [1.57, 0.5, 0.17])
def test_tangents_of_rods_that_cross_lack_the_error_of_the_quadrature_alone(angle, unit, turn, friction):
    """That grows with the square of the overlap, what nearest places that slide do with the overlap."""
    for share in (0.01, 0.03):
        robot = crossed(0.02 - 0.01 * share, angle, (0.01, 0.01), turn=turn, unit=unit, friction=friction)
        sizes = sizes_of(robot, unit)
        q, v = bent(robot, 3, sizes, 1e-4)
        moved, error, of_damping, of_differences = compared(robot, q, v, sizes)
        assert np.abs(moved).max() > 0.0
        assert of_differences < 1e-7
        assert error < 0.06 * share**2
        assert of_damping < 1e-7
        at_rest, *_ = robot.tangent(q, np.zeros(robot.n), np.zeros(robot.n))
        stiffness = at_rest * np.outer(sizes, sizes)
        assert_allclose(stiffness, stiffness.T, atol=1e-12 * np.abs(stiffness).max())


@pytest.mark.parametrize(("unit", "turn", "friction"), PLACEMENTS)
@pytest.mark.parametrize("radii", [(0.01, 0.008), ((0.012, 0.008), (0.009, 0.012))], ids=["round", "tapered"])
def test_tangents_of_rods_that_touch_all_along_are_exact(radii, unit, turn, friction):
    """No end of an overlap slides there."""
    robot = crossed(0.013, 0.01, radii, turn=turn, unit=unit, friction=friction)
    sizes = sizes_of(robot, unit)
    moved, error, of_damping, of_differences = compared(robot, *bent(robot, 3, sizes), sizes)
    assert np.abs(moved).max() > 0.0
    assert of_differences < 1e-8
    assert error < 1e-8
    assert of_damping < 1e-8


def test_tangents_of_a_coil_on_itself_are_those_of_its_forces():
    radius, bend, windings = 0.005, 40.0, 1.3
    length = 2 * windings * np.pi / np.hypot(bend, 2.4)
    modes = {"torsion": 2, "bend_y": 3, "bend_z": 3, "stretch": 1}
    segment = lissom.Segment(length, radius, young_modulus=1e6, poisson_ratio=0.45, density=1000, modes=modes)
    contact = lissom.Contact("a", "a", stiffness=1e5, slip_velocity=0.05, friction=0.3)
    links = [lissom.Link("a", joint=lissom.Free(), rod=[segment, segment])]
    robot = lissom.Robot(links, gravity=(0, 0, 0), contacts=[contact])
    random = np.random.default_rng(1)
    q, v = 0.05 * random.standard_normal((2, robot.n))
    first = robot.slice("a").start + 6
    for start in (first, first + sum(modes.values())):
        q[start] += 2.4
        q[start + 2] += bend
    assert robot.touches(q)
    _, error, of_damping, of_differences = compared(robot, q, v, np.ones(robot.n))
    assert of_differences < 1e-7
    # Of the quadrature; 1e-1 without the slide of nearest places.
    assert error < 3e-3
    assert of_damping < 1e-7


def test_forces_on_tapered_rods_are_gradients_of_the_energy_of_their_overlap():
    """Along a taper of 1 in 6 as well: with the normal of the axis they would miss a sixth of the force."""
    radii = ((0.014, 0.006), (0.05, 0.008))
    robot = crossed(0.0408, 1.2, radii)
    free = lissom.Robot(robot.links, gravity=(0, 0, 0))
    rest, h = np.zeros(robot.n), 1e-7
    q, _ = bent(robot, 5, np.ones(robot.n))
    force = robot.inverse_dynamics(q, rest, rest) - free.inverse_dynamics(q, rest, rest)

    def stored(q):
        return robot.energy(q, rest).elastic - free.energy(q, rest).elastic

    slope = np.array([(stored(q + h * e) - stored(q - h * e)) / (2 * h) for e in np.eye(robot.n)])
    assert np.abs(force).max() > 0.01
    # Of the three Gauss points.
    assert_allclose(force, slope, atol=5e-3 * np.abs(force).max())


def test_two_crossing_ropes_balance_unstably():
    """The upper rope of two hanging ones lies on the middle of the lower one, and slides off.

    The rate, without damping by the medium, is that of the motion from a small disturbance.
    """
    span, drop, parts = 0.8, 0.1, 4
    modes = {"torsion": 1, "bend_y": 4, "bend_z": 2}
    part = lissom.Segment(1 / parts, 0.005, 1e6, 1e6 / 3, 1000.0, modes)
    across = about((0, 0, 1), np.pi / 2)
    links = [
        lissom.Link("low", joint=lissom.Spherical(), rod=[part] * parts, position=(-span / 2, 0, 0)),
        lissom.Link(
            "high", joint=lissom.Spherical(), rod=[part] * parts, position=(0, -span / 2, -drop),
            orientation=across,
        ),
    ]  # fmt: skip
    ends = {"low": (span / 2, 0, 0), "high": (0, span / 2, -drop)}
    loops = [
        lissom.Loop(lissom.LoopEnd(name, 1.0), lissom.LoopEnd(position=place), lissom.Spherical(), name=name)
        for name, place in ends.items()
    ]
    pushed = [lissom.Load(force=(0, 0, f), link=name, at=0.5) for name, f in (("low", -0.27), ("high", 0.27))]
    gravity = (0, 0, -9.81)
    apart = lissom.Robot(links, loops=loops, loads=pushed, gravity=gravity)
    # Arcs in vertical planes: sin(a) / a is the span.
    q0, angle, n = np.zeros(apart.n), 1.1311, sum(modes.values())
    bends = [robot_slice.start + 3 + n * i for robot_slice in map(apart.slice, ends) for i in range(parts)]
    for name in ends:
        q0[apart.slice(name).start + 1] = angle
    for first in bends:
        q0[first + 1] = -2 * angle
    start = lissom.statics(apart, q0)
    assert start.success
    planar = start.q.copy()
    for name in ends:
        planar[[apart.slice(name).start, apart.slice(name).start + 2]] = 0.0
    for first in bends:
        planar[[first, first + 5, first + 6]] = 0.0
    robot = lissom.Robot(links, loops=loops, contacts=[lissom.Contact("low", "high")], gravity=gravity)
    found = lissom.statics(robot, planar, method="newton")
    assert found.success
    assert found.stability == "divergence"
    assert all(abs(touch.position[1]) < 1e-5 for touch in robot.touches(found.q))
    rate = lissom.modes(robot, found.q).eigenvalues.real.max()
    disturbed = found.q.copy()
    disturbed[robot.slice("low").start] += 1e-6
    run = lissom.simulate(robot, 1.6, q0=disturbed, dt=4e-3, t_eval=np.linspace(0, 1.6, 17))
    assert run.success
    aside = np.abs([robot.pose(q, 0.5, link="low")[1, 3] for q in run.q])
    assert_allclose(np.log(aside[-1] / aside[-4]) / 0.3, rate, rtol=0.02)
