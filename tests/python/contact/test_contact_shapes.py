"""Height fields and convex meshes compared with closed forms, and with equivalent simpler shapes; what
distances cost."""

from __future__ import annotations

import pickle
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.interpolate import CubicSpline

import lissom

G = 9.81
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
CUBE_FACES = [
    *([0, 1, 3], [0, 3, 2], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4]),
    *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 3, 7], [1, 7, 5]),
]


def hill(height=0.1, length=1.0, number=81, width=2.0):
    """Ground with a cosine profile along x, constant along y."""
    x = np.linspace(0.0, 2.0 * length, number)
    heights = 0.5 * height * (1.0 - np.cos(2.0 * np.pi * x / (2.0 * length)))
    return lissom.HeightField(np.stack([heights, heights], axis=1), (x[1], width), (-length, -0.5 * width, 0))


def ball_on(obstacle, joint, radius=0.05, gravity=(0, 0, -G), **constants):
    inertia = np.eye(3) * 0.4 * radius**2
    link = lissom.Link("ball", joint=joint, body=lissom.Body(1.0, inertia=inertia))
    contact = lissom.Contact(lissom.Ball("ball", radius), obstacle, **constants)
    return lissom.Robot([link], gravity=gravity, contacts=[contact])


def beam(obstacle, **constants):
    segment = lissom.Segment(
        0.6,
        radius=0.01,
        young_modulus=1e6,
        poisson_ratio=0.4,
        density=1000,
        modes={"bend_y": 4, "bend_z": 2, "torsion": 1},
    )
    rod = lissom.Link("rod", joint=lissom.Free(), rod=[segment])
    return lissom.Robot([rod], contacts=[lissom.Contact("rod", obstacle, friction=0.3, **constants)])


def shapes(robot, number=3, seed=1):
    """Shapes and velocities of a rod near the ground."""
    random = np.random.default_rng(seed)
    for _ in range(number):
        q = 0.2 * random.standard_normal(robot.n)
        q[:3] = [-0.3, 0.0, 0.0]
        q[3:6] *= 0.1
        yield q, random.standard_normal(robot.n)


# Height fields


def test_a_flat_field_is_a_half_space():
    """A plane in any direction, also beyond the rectangle of the field."""
    turn = (0.96, 0.0, 0.28, 0.0)
    normal = np.array([2 * 0.96 * 0.28, 0.0, 1 - 2 * 0.28**2])
    flat = beam(lissom.HeightField(np.zeros((3, 4)), 0.05, (0.1, 0.2, 0.02), turn))
    plane = beam(lissom.HalfSpace((0.1, 0.2, 0.02), normal))
    for q, v in shapes(flat):
        # The rod extends across the plane.
        q[:3] = np.array([0.1, 0.2, 0.02]) - [0.3, 0, 0]
        wanted = plane.contact_forces(q, v)
        assert np.abs(wanted).max() > 1.0
        assert_allclose(flat.contact_forces(q, v), wanted, rtol=1e-8, atol=1e-8 * np.abs(wanted).max())


@pytest.mark.parametrize("method", ["newmark", "radau", "dop853"])
def test_a_ball_slides_over_a_hill_and_keeps_its_energy(method):
    """Without friction `v^2 = v0^2 - 2 g h` for the rise h of its centre; the ball does not rotate."""
    robot = ball_on(hill(), lissom.Planar((0, 1, 0)), stiffness=1e6, dissipation=0.0)
    sink = G / 1e6
    q0 = [-0.9, -(0.05 - sink) - 0.5 * 0.1 * (1 - np.cos(np.pi * 0.1)), 0.0]
    run = lissom.simulate(robot, 0.8, dt=2e-4, q0=q0, v0=[3.0, 0.0, 0.0], method=method)
    assert run.success, run.message
    assert run.q[-1, 0] > 0.9
    energy = [robot.energy(q, v).total for q, v in zip(run.q, run.v, strict=True)]
    assert np.ptp(energy) < 2e-3 * 4.5
    assert np.abs(run.v[:, 2]).max() < 1e-9
    top = np.argmax(-run.q[:, 1])
    rise = q0[1] - run.q[top, 1]
    assert abs(run.q[top, 0]) < 0.05
    assert_allclose(np.sum(run.v[top, :2] ** 2), 9.0 - 2 * G * rise, rtol=1e-3)


def test_a_ball_rolls_over_a_bump():
    """Without slip the energy of a solid sphere is 7/10 m v^2, at the foot and on the top."""
    robot = ball_on(
        hill(), lissom.Planar((0, 1, 0)), stiffness=1e7, dissipation=0.0, friction=1.0, slip_velocity=1e-5
    )
    v0 = 2.5
    q0 = [-1.0, -(0.05 - G / 1e7), 0.0]
    run = lissom.simulate(robot, 0.5, q0=q0, v0=[v0, 0.0, v0 / 0.05], method="radau", rtol=1e-7, atol=1e-9)
    assert run.success, run.message
    top = np.argmax(-run.q[:, 1])
    assert abs(run.q[top, 0]) < 0.05
    rise = q0[1] - run.q[top, 1]
    assert_allclose(rise, 0.1, atol=1e-3)
    speed = np.hypot(*run.v[top, :2])
    assert_allclose(speed**2, v0**2 - 10 / 7 * G * rise, rtol=3e-3)
    assert_allclose(run.v[top, 2] * 0.05, speed, rtol=1e-3)


def test_a_ball_rests_in_a_hollow():
    """Curved along both axes: the ball rests where the slope is zero, and oscillates like a pendulum."""
    x = np.linspace(-1.0, 1.0, 41)
    # Approximately a sphere's lower half.
    bowl = 1.0 - np.sqrt(4.0 - x[:, None] ** 2 - x**2) + 1.0
    field = lissom.HeightField(bowl, x[1] - x[0], (-1, -1, 0))
    # In a bowl of radius 2 the centre of a ball of 0.1 without friction is a pendulum of length 1.9.
    robot = ball_on(field, lissom.Free(), radius=0.1, stiffness=1e5, dissipation=0.0)
    q0 = np.zeros(robot.n)
    q0[:3] = [0.05, 0.03, 0.0]
    q0[2] = 2.0 - np.sqrt(1.9**2 - 0.05**2 - 0.03**2) - G / 1e5
    period = 2 * np.pi * np.sqrt((1.9 + G / 1e5) / G)
    run = lissom.simulate(robot, period, dt=1e-3, q0=q0, method="newmark")
    assert run.success, run.message
    # The period of a pendulum increases by a sixteenth of the amplitude squared: 4e-5 here.
    assert_allclose(run.q[-1, :2], q0[:2], atol=1e-4)
    half = run.q[len(run.q) // 2, :2]
    assert_allclose(half, -q0[:2], atol=1e-3)


def test_a_heavy_rod_lies_in_a_valley():
    """The ground carries its weight, with forces along its normals."""
    segment = lissom.Segment(
        0.6, radius=0.01, young_modulus=1e6, poisson_ratio=0.4, density=1000, modes={"bend_y": 5}
    )
    rod = lissom.Link("rod", position=(-0.3, 0, -0.04), joint=lissom.Planar((0, 1, 0)), rod=[segment])
    valley = hill(height=-0.1, length=0.5)
    robot = lissom.Robot([rod], contacts=[lissom.Contact("rod", valley, stiffness=1e4)])
    found = lissom.statics(robot)
    assert found.success, found.message
    touches = robot.touches(found.q)
    weight = 1000 * np.pi * 1e-4 * 0.6 * G
    assert_allclose(sum(touch.force for touch in touches), [0, 0, weight], atol=1e-6 * weight)
    # It is symmetric, and is carried at two places.
    places = np.array([touch.position[0] for touch in touches])
    assert_allclose(places.mean(), 0.0, atol=1e-3)
    for touch in touches:
        slope = -0.05 * 2 * np.pi * np.sin(2 * np.pi * (touch.position[0] + 0.5))
        assert_allclose(touch.normal, [-slope, 0, 1] / np.hypot(slope, 1), atol=5e-3)


def test_the_surface_is_the_natural_spline():
    """A small ball is pressed on the field, also at its borders; compared with SciPy's spline."""
    random = np.random.default_rng(5)
    x = np.arange(6) * 0.2
    heights = 0.05 * random.standard_normal(6)
    field = lissom.HeightField(np.stack([heights] * 3, axis=1), (0.2, 1.0), (0, -1, 0))
    spline = CubicSpline(x, heights, bc_type="natural")
    robot = ball_on(field, lissom.Free(), radius=0.01, stiffness=1e5)
    for at in np.linspace(-0.0, 1.0, 23):
        height, slope = spline(at), spline(at, 1)
        normal = np.array([-slope, 0, 1]) / np.hypot(slope, 1)
        q = np.zeros(robot.n)
        q[:3] = [at, 0.1, height] + 0.008 * normal
        (touch,) = robot.touches(q, np.zeros(robot.n))
        assert_allclose(touch.overlap, 0.002, rtol=1e-9)
        assert_allclose(touch.normal, normal, atol=1e-9)


def tangents_agree(robot, q, v, atol):
    """The tangent of contact compared with differences of its forces, which must not vanish."""
    free = lissom.Robot(robot.links, gravity=robot.gravity)
    a = np.zeros(robot.n)

    def forces(q, v):
        return robot.inverse_dynamics(q, v, a) - free.inverse_dynamics(q, v, a)

    h, units = 1e-7, np.eye(robot.n)
    moved = np.transpose([(forces(q + h * e, v) - forces(q - h * e, v)) / (2 * h) for e in units])
    faster = np.transpose([(forces(q, v + h * e) - forces(q, v - h * e)) / (2 * h) for e in units])
    stiffness, damping, _ = (
        mine - other for mine, other in zip(robot.tangent(q, v, a), free.tangent(q, v, a), strict=True)
    )
    assert np.abs(moved).max() > 1.0
    assert_allclose(stiffness, moved, atol=atol * np.abs(moved).max())
    assert_allclose(damping, faster, atol=atol * np.abs(faster).max())


def test_tangents_on_a_field_are_exact():
    """A ball on curved ground, with friction: the quadrature points do not move."""
    random = np.random.default_rng(2)
    field = lissom.HeightField(0.015 * random.standard_normal((8, 7)), (0.1, 0.12), (-0.35, -0.36, 0))
    robot = ball_on(field, lissom.Free(), stiffness=1e4, friction=0.4, patch_radius=0.01)
    tried = 0
    for _ in range(30):
        q = np.zeros(robot.n)
        q[:3] = random.uniform([-0.2, -0.2, 0.03], [0.2, 0.2, 0.06])
        v = 0.1 * random.standard_normal(robot.n)
        if robot.touches(q, v) and robot.touches(q, v)[0].overlap < 0.02:
            tangents_agree(robot, q, v, atol=1e-5)
            tried += 1
    assert tried > 5


# Convex meshes


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_cube_of_triangles_is_a_box(seed):
    """Up to rounding for balls. Integrals along rods are split at other places: 5e-3, as documented."""
    shape, triangles = lissom.Box((0, 0, -0.1), (0.2, 0.1, 0.1)), CUBE * [0.2, 0.1, 0.1] + [0, 0, -0.1]
    random = np.random.default_rng(seed)
    box, mesh = (
        ball_on(obstacle, lissom.Free(), stiffness=1e4, friction=0.3)
        for obstacle in (shape, lissom.ConvexMesh(triangles, CUBE_FACES))
    )
    for _ in range(5):
        q, v = np.zeros(6), random.standard_normal(6)
        q[:3] = random.uniform([-0.25, -0.15, -0.25], [0.25, 0.15, 0.05])
        wanted = box.contact_forces(q, v)
        # Inside, two faces may be equally near.
        sides = np.sort(np.abs([0.2, 0.1, 0.1]) - np.abs(q[:3] - [0, 0, -0.1]))
        if sides[0] < 0 or sides[1] - sides[0] > 1e-9:
            assert_allclose(
                mesh.contact_forces(q, v), wanted, rtol=0, atol=1e-9 + 1e-9 * np.abs(wanted).max()
            )
    box, mesh = beam(shape), beam(lissom.ConvexMesh(triangles, CUBE_FACES))
    for q, v in shapes(box, number=1, seed=seed):
        wanted = box.contact_forces(q, v)
        assert_allclose(mesh.contact_forces(q, v), wanted, rtol=0, atol=1e-9 + 5e-3 * np.abs(wanted).max())


def test_a_rounded_edge_has_its_radius():
    """A ball on the edge of a wedge is as on a cylinder with that radius."""
    points = [[-1, -1, -1], [1, -1, -1], [0, -1, 0], [-1, 1, -1], [1, 1, -1], [0, 1, 0]]
    faces = [[0, 1, 2], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [0, 2, 5], [0, 5, 3]]
    wedge = ball_on(lissom.ConvexMesh(points, faces, 0.2), lissom.Free(), stiffness=1e4, friction=0.3)
    bar = ball_on(lissom.Capsule((0, -1, 0), (0, 1, 0), 0.2), lissom.Free(), stiffness=1e4, friction=0.3)
    random = np.random.default_rng(3)
    for angle in np.linspace(-0.7, 0.7, 7):
        q = np.zeros(wedge.n)
        q[:3] = [0.24 * np.sin(angle), 0.1, 0.24 * np.cos(angle)]
        v = 0.1 * random.standard_normal(wedge.n)
        wanted = bar.contact_forces(q, v)
        assert np.abs(wanted).max() > 1.0
        assert_allclose(wedge.contact_forces(q, v), wanted, atol=1e-9 * np.abs(wanted).max())


def test_a_block_slides_down_the_face_of_a_mesh():
    angle, mu = 0.5, 0.3
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    mesh = lissom.ConvexMesh((CUBE * [3, 1, 0.5] - [0, 0, 0.5]) @ turn.T, CUBE_FACES, 0.0)
    link = lissom.Link(
        "block", joint=lissom.Planar((0, 1, 0)), body=lissom.Body(1.0, inertia=np.eye(3) * 1e9)
    )
    contact = lissom.Contact(lissom.Ball("block", 0.1), mesh, stiffness=1e5, friction=mu)
    robot = lissom.Robot([link], gravity=(0, 0, -G), contacts=[contact])
    height = 0.1 - G * np.cos(angle) / 1e5
    q0 = [np.sin(angle) * height, -np.cos(angle) * height, 0.0]
    v0 = [0.2 * np.cos(angle), 0.2 * np.sin(angle), 0.0]
    run = lissom.simulate(robot, 1.0, dt=1e-3, q0=q0, v0=v0)
    assert run.success, run.message
    way = np.hypot(*(run.q[-1] - q0)[:2])
    assert_allclose(way, 0.2 + 0.5 * G * (np.sin(angle) - mu * np.cos(angle)), rtol=1e-4)


# Sections that are not round


def ribbon(obstacle, sections, modes, **constants):
    segment = lissom.Segment(
        0.6, section=sections, young_modulus=1e6, poisson_ratio=0.4, density=1000, modes=modes
    )
    rod = lissom.Link("rod", joint=lissom.Free(), rod=[segment])
    return lissom.Robot([rod], contacts=[lissom.Contact("rod", obstacle, **constants)])


ELLIPSE = lissom.Section.ellipse(0.02, 0.005)


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.0, np.pi / 2])
def test_an_ellipse_rests_on_its_support(angle):
    """Its extent downwards is `sqrt((a sin)^2 + (b cos)^2)`; it presses there with a moment."""
    robot = ribbon(lissom.HalfSpace(), ELLIPSE, {"bend_y": 2}, stiffness=1e4)
    reach = np.hypot(0.02 * np.sin(angle), 0.005 * np.cos(angle))
    q = np.zeros(robot.n)
    q[2:4] = reach - 0.001, angle
    force = robot.contact_forces(q, np.zeros(robot.n))
    assert_allclose(force[3:], [0, 0, 1e4 * 0.001 * 0.6], rtol=1e-9, atol=1e-9)
    # The derivative of that height gives the lateral position of the place.
    beside = (0.02**2 - 0.005**2) * np.sin(angle) * np.cos(angle) / reach
    touches = robot.touches(q)
    assert_allclose([touch.position[1] for touch in touches], -beside, atol=1e-9)
    assert_allclose(force[0], -beside * force[5], atol=1e-9)


def test_a_ribbon_is_a_rod_where_it_is_round():
    """Nearly equal half extents act as a circle, if the rod lies along what it touches."""
    modes = {"bend_y": 3, "torsion": 2, "stretch": 1}
    obstacles = [
        lissom.HalfSpace((0, 0, 0), (0, 0.2, 1)),
        lissom.Capsule((-2, 0.01, -0.05), (2, 0.01, -0.05), 0.05),
        lissom.Box((0, 0, -0.1), (2, 0.015, 0.1)),
    ]
    random = np.random.default_rng(8)
    for obstacle in obstacles:
        nearly, round_one = (
            ribbon(obstacle, lissom.Section.ellipse(0.01, z), modes, friction=0.3) for z in (0.0100001, 0.01)
        )
        for _ in range(5):
            q, v = np.zeros(nearly.n), 0.1 * random.standard_normal(nearly.n)
            q[:4] = -0.3, random.uniform(-0.008, 0.008), 0.005, random.uniform(-3, 3)
            wanted = round_one.contact_forces(q, v)
            assert np.abs(wanted).max() > 1e-2
            assert_allclose(nearly.contact_forces(q, v), wanted, atol=1e-4 * np.abs(wanted).max())


def test_tangents_of_ribbons_are_exact_on_a_floor():
    """Bent, twisted and rotated, sliding, with contact along the complete ribbon."""
    random = np.random.default_rng(4)
    modes = {"bend_y": 2, "bend_z": 1, "torsion": 2, "stretch": 1}
    robot = ribbon(
        lissom.HalfSpace(), ELLIPSE, modes, stiffness=1e4, friction=(0.2, 0.3, 0.6), slip_velocity=0.05
    )
    for _ in range(3):
        q = 0.05 * random.standard_normal(robot.n)
        q[2] = -0.02
        q[3:6] = [0.5, 0.0, 0.0]
        tangents_agree(robot, q, 0.05 * random.standard_normal(robot.n), atol=1e-5)


def test_tangents_of_ribbons_on_a_ball_know_the_rolling_place():
    """The ends of the contact move: as exact as those of round rods on curved obstacles."""
    random = np.random.default_rng(6)
    modes = {"bend_y": 2, "bend_z": 1, "torsion": 2}
    robot = ribbon(
        lissom.Sphere((0, 0, -0.5), 0.5), ELLIPSE, modes, stiffness=1e4, friction=0.3, slip_velocity=0.05
    )
    for _ in range(3):
        q = 0.02 * random.standard_normal(robot.n)
        q[:4] = [-0.3, 0.0, 0.008, 0.5]
        tangents_agree(robot, q, 0.02 * random.standard_normal(robot.n), atol=2e-3)


def test_a_ribbon_falls_flat_and_keeps_its_energy():
    """Released on its edge at an angle it tips over, and loses only the dissipated energy."""
    robot = ribbon(lissom.HalfSpace(), ELLIPSE, {"bend_y": 1}, stiffness=1e5, dissipation=0.0)
    q0 = np.zeros(robot.n)
    angle = 1.2
    q0[2:4] = np.hypot(0.02 * np.sin(angle), 0.005 * np.cos(angle)), angle
    run = lissom.simulate(robot, 0.3, q0=q0, method="dop853", rtol=1e-8, atol=1e-10)
    assert run.success, run.message
    energy = [robot.energy(q, v).total for q, v in zip(run.q, run.v, strict=True)]
    weight = 1000 * np.pi * 0.02 * 0.005 * 0.6 * G
    assert np.ptp(energy) < 1e-4 * weight * 0.02
    assert run.q[:, 2].min() > 0.003
    assert run.q[:, 2].min() < 0.008


def test_a_wide_ribbon_lies_on_a_thin_plate():
    """It does not count as having passed through the plate, although the plate is thinner than the ribbon."""
    modes = {"bend_y": 2}
    robot = ribbon(
        lissom.Box((0.3, 0, -0.002), (0.4, 0.1, 0.002)), ELLIPSE, modes, stiffness=1e5, friction=0.5
    )
    q0 = np.zeros(robot.n)
    q0[2] = 0.0055
    run = lissom.simulate(robot, 0.3, dt=1e-3, q0=q0)
    assert run.success, run.message
    weight = 1000 * np.pi * 0.02 * 0.005 * 0.6 * G
    assert_allclose(run.q[-1, 2], 0.005 - weight / 0.6 / 1e5, atol=2e-5)


def test_in_a_plane_rods_are_as_thick_as_they_are_in_it():
    for joint, thickness in (((0, 1, 0), 0.005), ((0, 0, 1), 0.02)):
        segment = lissom.Segment(
            0.6, section=ELLIPSE, young_modulus=1e6, poisson_ratio=0.4, density=1000, modes={}
        )
        rod = lissom.Link("rod", joint=lissom.Planar(joint), rod=[segment])
        wall = lissom.HalfSpace((0, 0, 0), (0, 0, 1) if joint[1] else (0, 1, 0))
        robot = lissom.Robot([rod], contacts=[lissom.Contact("rod", wall, stiffness=1e3)])
        for away, is_touched in ((thickness + 1e-4, False), (thickness - 1e-4, True)):
            q = np.zeros(3)
            q[1] = -away if joint[1] else away
            assert bool(robot.touches(q)) == is_touched


# Integrals over edges


@pytest.mark.parametrize("size", [0.002, 0.01, 0.03])
@pytest.mark.parametrize("shift", [0.0, 0.013])
def test_forces_of_small_edges_are_integrated(size, shift):
    """A straight rod across a bar narrower than the distance of its nodes, compared with SciPy's integral."""
    radius, overlap, k = 0.01, 0.004, 1e4
    points = CUBE * [size, 0.1, 0.05] - [0, 0, 0.05]
    obstacles = {
        "box": (lissom.Box((0, 0, -0.05), (size, 0.1, 0.05)), 0.0, 0.0),
        "mesh": (lissom.ConvexMesh(points, CUBE_FACES), 0.0, 0.0),
        "bar": (lissom.Capsule((-size, 0, -0.01), (size, 0, -0.01), 0.01), 0.01, 0.01),
    }
    for obstacle, below, thick in obstacles.values():
        segment = lissom.Segment(
            1.0,
            radius=radius,
            young_modulus=1e6,
            poisson_ratio=0.4,
            density=1000,
            modes={"bend_y": 2},
            nodes=8,
        )
        rod = lissom.Link("rod", joint=lissom.Free(), rod=[segment])
        robot = lissom.Robot([rod], contacts=[lissom.Contact("rod", obstacle, stiffness=k)])
        q = np.zeros(robot.n)
        q[:3] = shift - 0.5, 0.0, radius - overlap

        def pressed(x, below=below, thick=thick):
            beside, above = max(abs(x) - size, 0.0), radius - overlap + below
            distance = np.hypot(beside, above)
            return k * max(radius + thick - distance, 0.0) * above / distance

        wanted = sum(
            quad(pressed, *ends, epsabs=1e-12)[0] for ends in ((-0.1, -size), (-size, size), (size, 0.1))
        )
        found = robot.contact_forces(q, np.zeros(robot.n))[5]
        assert_allclose(found, wanted, rtol=5e-3)


# Friction against spinning


@pytest.mark.parametrize("method", ["newmark", "radau"])
def test_a_ball_that_spins_on_a_floor_slows_down(method):
    """`I w' = -mu m g r`: constant deceleration to rest."""
    mu, patch, spin = 0.4, 0.01, 5.0
    robot = ball_on(lissom.HalfSpace(), lissom.Free(), stiffness=1e5, friction=mu, patch_radius=patch)
    inertia = 0.4 * 0.05**2
    rate = mu * G * patch / inertia
    q0 = np.zeros(robot.n)
    q0[2] = 0.05 - G / 1e5
    v0 = np.zeros(robot.n)
    v0[5] = spin
    end = 0.9 * spin / rate
    run = lissom.simulate(robot, end, dt=end / 200, q0=q0, v0=v0, method=method)
    assert run.success, run.message
    assert_allclose(run.v[:, 5], spin - rate * run.t, atol=1e-3 * spin)
    assert_allclose(run.v[:, :5], 0.0, atol=1e-6)
    # After that it creeps at most with the slip velocity at the edge of the patch.
    run = lissom.simulate(robot, 2 * end, dt=end / 200, q0=q0, v0=v0, method=method)
    assert abs(run.v[-1, 5]) < 1e-4 / patch


def test_without_a_patch_it_spins_on():
    robot = ball_on(lissom.HalfSpace(), lissom.Free(), stiffness=1e5, friction=0.4)
    q0, v0 = np.zeros(robot.n), np.zeros(robot.n)
    q0[2], v0[5] = 0.05 - G / 1e5, 5.0
    run = lissom.simulate(robot, 0.1, dt=1e-3, q0=q0, v0=v0)
    assert_allclose(run.v[-1, 5], 5.0, rtol=1e-9)


# Both


SHAPES = {
    "field": lissom.HeightField([[0, 0.1, 0], [0.1, 0.2, 0.1], [0, 0.1, 0]], 0.1, (0, 0, -0.5)),
    "mesh": lissom.ConvexMesh(CUBE * 0.1 - [0, 0, 0.5], CUBE_FACES, 0.02),
}


@pytest.mark.parametrize("name", SHAPES)
def test_they_are_kept(name):
    shape = SHAPES[name]
    assert pickle.loads(pickle.dumps(shape)) == shape
    assert beam(shape).contacts[0].b == shape


@pytest.mark.filterwarnings("ignore:Impacts are shorter:lissom.AccuracyWarning")
@pytest.mark.parametrize("dt", [1e-2, 5e-2])
@pytest.mark.parametrize("method", [None, "radau", "rk45"])
def test_nothing_passes_through_a_ridge_or_a_plate(dt, method):
    """A ball without weight that would be on the other side after a step."""
    x = np.arange(41) * 0.05
    ridge = np.exp(-(((x - 1.0) / 0.1) ** 2))
    plate = lissom.ConvexMesh(CUBE * [5e-4, 1, 1] + [1, 0, 0], CUBE_FACES)
    for obstacle in (plate, lissom.HeightField(np.stack([ridge] * 2, axis=1), (0.05, 2.0), (0, -1, -0.5))):
        robot = ball_on(obstacle, lissom.Free(), gravity=(0, 0, 0), stiffness=1e8, dissipation=0.0)
        q0 = np.zeros(robot.n)
        keys = {"dt": dt} if method is None else {"method": method}
        run = lissom.simulate(robot, 0.5, q0=q0, v0=[10, 0, 0, 0, 0, 0], **keys)
        assert run.success, run.message
        assert not np.any((run.q[:, 0] > 1.0) & (run.q[:, 2] < 0.3))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: lissom.HeightField([[0, 1], [0]], 0.1), "different lengths"),
        (lambda: lissom.HeightField([0, 1], 0.1), "two: rows"),
        (lambda: lissom.HeightField([["a", "b"], ["c", "d"]], 0.1), "rows of numbers"),
        (lambda: beam(lissom.HeightField([[0, 1]], 0.1)), "two or more along each axis"),
        (lambda: beam(lissom.HeightField([[0, 1], [0, np.nan]], 0.1)), "heights"),
        (lambda: beam(lissom.HeightField([[0, 1], [0, 1]], -0.1)), "spacing"),
        (lambda: beam(lissom.HeightField([[0, 1], [0, 1]], 0.1, orientation=(2, 0, 0, 0))), "norm"),
        (lambda: beam(lissom.ConvexMesh(CUBE, CUBE_FACES[1:])), "closed surface"),
        (lambda: beam(lissom.ConvexMesh(CUBE, [[0, 1, 9], *CUBE_FACES[1:]])), "points among the 8"),
        (lambda: beam(lissom.ConvexMesh(CUBE, [[0, 1, 0.5], *CUBE_FACES[1:]])), "no place of a point"),
        (lambda: beam(lissom.ConvexMesh(CUBE, CUBE_FACES, -1.0)), "radius"),
        (lambda: beam(lissom.ConvexMesh(np.vstack([CUBE[:7], [[0, 0, 0]]]), CUBE_FACES)), "both sides"),
    ],
)
def test_what_makes_no_sense_is_refused(make, message):
    with pytest.raises((ValueError, TypeError), match=message):
        make()


#: Seconds that an evaluation may take anywhere: ten times the longest one seen, on a busy machine. It was 24
#: near the centre of curvature of a hill, where many places of the ground are almost equally near.
MOST_SECONDS = 0.5


def seconds(rod, q):
    """The median time of an evaluation in shapes that differ, each of which is searched anew."""
    rest = np.zeros(rod.n)
    rod.inverse_dynamics(q, rest, rest)
    times = []
    for k in range(7):
        shape = q * (1.0 + 0.1 * k)
        begin = time.perf_counter()
        rod.inverse_dynamics(shape, rest, rest)
        times.append(time.perf_counter() - begin)
    return float(np.median(times))


@pytest.mark.parametrize(
    "height",
    [
        lambda x, y: 0.05 * np.sin(7 * x) * np.cos(5 * y),
        lambda x, y: -0.2 * (x**2 + y**2),
        lambda x, y: 0.2 * (x**2 + y**2),
        lambda x, y: 0.02 * np.sin(1e4 * (x + np.pi * y)),
    ],
    ids=["waves", "hill", "bowl", "rough"],
)
@pytest.mark.parametrize("depth", [0.3, 1.0, 2.4, 2.6, 10.0])
def test_deep_places_are_found_in_time(height, depth):
    x = np.linspace(-1.0, 1.0, 41)
    heights = height(x[:, None], x[None, :])

    def at(z):
        """A rod in the middle of the ground, so high above it."""
        ground = lissom.HeightField(heights, x[1] - x[0], (-1.0, -1.0, -z))
        segment = lissom.Segment(0.3, 0.01, 1e7, 4e6, 1000, modes={"bend_y": 2})
        return lissom.Rod([segment], contacts=[lissom.Contact("rod", ground, stiffness=1e4)])

    q = np.array([0.1, -0.05])
    level = float(height(0.0, 0.0))
    assert seconds(at(level - depth), q) < MOST_SECONDS


def cost_beside(shape, *, modes=1, seconds=0.05, repeats=3):
    """Processor time of a rod in the air with this shape far away, over that without."""
    names = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")
    segment = lissom.Segment(0.15, 0.01, 1e6, 4e5, 1000.0, dict.fromkeys(names, modes), retardation_time=0.01)
    links = [lissom.Link("rod", rod=[segment] * 2)]
    robots = [lissom.Robot(links), lissom.Robot(links, contacts=[lissom.Contact("rod", shape)])]
    times = [[], []]
    for _ in range(repeats):
        for robot, own in zip(robots, times, strict=True):
            start = time.process_time()
            lissom.simulate(robot, seconds, dt=1e-3)
            own.append(time.process_time() - start)
    return np.median(times[1]) / np.median(times[0])


def test_ground_that_nothing_reaches_costs_hardly_anything():
    """Distances from 3600 cells are not searched for, which costs 1000 times the rest of the run."""
    heights = 0.2 * np.random.default_rng(0).normal(size=(60, 60)) - 5.0
    assert cost_beside(lissom.HeightField(heights, (4 / 60, 4 / 60), (-2, -2, 0))) < 2.0


def test_runs_do_not_depend_on_shapes_that_nothing_reaches():
    heights = 0.2 * np.random.default_rng(0).normal(size=(8, 8)) - 5.0
    shapes = [
        lissom.HalfSpace((0, 0, -5)),
        lissom.Tube([(-1, 0, -5), (0, 0.2, -5), (1, 0, -5)], 0.1),
        lissom.HeightField(heights, (0.5, 0.5), (-2, -2, 0)),
        lissom.ConvexMesh(0.3 * CUBE + [0, 0, -5], CUBE_FACES),
    ]
    runs = [lissom.simulate(beam(shape), 0.1, dt=1e-3) for shape in shapes]
    for run in runs[1:]:
        assert np.array_equal(run.q, runs[0].q)


@pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")
@pytest.mark.parametrize("speed", [3.0, 30.0])
def test_what_was_far_is_found_when_it_arrives(speed):
    """The gap that is known far away does not last: a plate stops a rod that falls on it from two metres."""
    robot = beam(lissom.Box((0, 0, -2.0), (1.0, 1.0, 0.01)))
    v0 = np.zeros(robot.n)
    v0[2] = -speed
    run = lissom.simulate(robot, 2.5 / speed, dt=1e-3, v0=v0)
    heights = robot.pose(run.q, [0.0, 0.3, 0.6], link="rod")[..., 2, 3]
    assert heights.min() < -1.9
    assert heights.min() > -2.0
