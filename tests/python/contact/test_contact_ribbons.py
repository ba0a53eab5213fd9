"""Contact of rods with elliptic sections, with each other and with themselves."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

WIDE, THIN = 0.02, 0.005
BENDING = {"torsion": 1, "bend_y": 2, "bend_z": 2}


def turned(about_x, about_z):
    """Quaternion of a rotation about x followed by one about z."""
    (cx, sx), (cz, sz) = ((np.cos(a / 2), np.sin(a / 2)) for a in (about_x, about_z))
    return (cz * cx, cz * sx, sz * sx, sz * cx)


def ribbon(name, section=(WIDE, THIN), modes=BENDING, **place):
    shape = lissom.Section.ellipse(*section)
    material = {"young_modulus": 1e6, "shear_modulus": 4e5, "density": 1000}
    rod = [lissom.Segment(0.4, section=shape, modes=modes, **material)]
    return lissom.Link(name, joint=lissom.Free(), rod=rod, **place)


def crossed(height, about_x=0.0, about_z=np.pi / 2, first=(WIDE, THIN), second=(WIDE, THIN), **options):
    """Two ribbons crossing above each other at their middles."""
    half = 0.2 * np.array([np.cos(about_z), np.sin(about_z), 0.0])
    links = [
        ribbon("lower", second),
        ribbon("upper", first, position=(0.2, 0, height) - half, orientation=turned(about_x, about_z)),
    ]
    contact = lissom.Contact("upper", "lower", **options)
    return lissom.Robot(links, gravity=(0, 0, 0), contacts=[contact])


def deepest(robot, q=None):
    q = np.zeros(robot.n) if q is None else q
    return max((touch.overlap for touch in robot.touches(q, np.zeros(robot.n))), default=0.0)


@pytest.mark.parametrize(
    ("about_x", "first", "distance"),
    [
        (0.0, (WIDE, THIN), 2 * THIN),
        (np.pi / 2, (WIDE, THIN), WIDE + THIN),
        (0.0, (0.01, 0.01), 0.01 + THIN),
        (0.7, (WIDE, THIN), np.hypot(WIDE * np.sin(0.7), THIN * np.cos(0.7)) + THIN),
    ],
)
@pytest.mark.parametrize("about_z", [np.pi / 2, 1.0])
def test_they_touch_with_their_own_half_extents(about_x, first, distance, about_z):
    apart, pressed = (crossed(distance + by, about_x, about_z, first) for by in (1e-5, -1e-4))
    assert deepest(apart) == 0.0
    # Quadrature points lie beside the middle, where the overlap is smaller.
    assert 0.5e-4 < deepest(pressed) <= 1e-4 + 1e-9
    # In either order of the links.
    links = pressed.links
    swapped = lissom.Robot(links, gravity=(0, 0, 0), contacts=[lissom.Contact("lower", "upper")])
    assert 0.5e-4 < deepest(swapped) <= 1e-4 + 1e-9


def test_nearly_round_rods_press_as_round_ones():
    """Rods along each other; crossed rods with sections that are not round touch only with their edges."""
    random = np.random.default_rng(3)
    nearly, exact = (
        crossed(0.018, 0.4, 0.0, (0.01, width), (0.01, width), friction=0.3) for width in (0.0100001, 0.01)
    )
    for _ in range(5):
        q = np.zeros(nearly.n)
        q[nearly.n // 2 :][3:6] = [random.uniform(-3, 3), 0.0, 0.0]
        v = 0.1 * random.standard_normal(nearly.n)
        wanted = exact.inverse_dynamics(q, v, 0 * q)
        assert np.abs(exact.contact_forces(q, v)).max() > 1e-2
        assert_allclose(nearly.inverse_dynamics(q, v, 0 * q), wanted, atol=1e-3 * np.abs(wanted).max())


def test_forces_are_the_gradient_of_the_energy():
    """Bent, twisted and rotated rods, up to the accuracy of the quadrature at the ends of the contact."""
    random = np.random.default_rng(5)
    robot = crossed(0.0085, 0.15, 0.8, dissipation=0.0)
    bare = lissom.Robot(robot.links, gravity=(0, 0, 0))
    rest = np.zeros(robot.n)
    h, pressed = 1e-6, 0
    for _ in range(20):
        q = np.concatenate([1e-3 * random.standard_normal(3), 0.05 * random.standard_normal(robot.n - 3)])
        q[robot.n // 2 :][:3] = 1e-3 * random.standard_normal(3)
        if not 0.0 < deepest(robot, q) < 0.9 * THIN:
            continue
        pressed += 1
        force = robot.inverse_dynamics(q, rest, rest) - bare.inverse_dynamics(q, rest, rest)

        def stored(q):
            return robot.energy(q, rest).elastic - bare.energy(q, rest).elastic

        slope = [(stored(q + h * e) - stored(q - h * e)) / (2 * h) for e in np.eye(robot.n)]
        assert np.abs(force).max() > 1e-3
        assert_allclose(force, slope, atol=0.02 * np.abs(force).max())
    assert pressed >= 3


def test_tangents_agree_with_differences():
    robot = crossed(0.0085, 0.15, 0.8, friction=0.3, stiffness=1e4, slip_velocity=0.05)
    bare = lissom.Robot(robot.links, gravity=(0, 0, 0))
    random = np.random.default_rng(6)
    h, units = 1e-7, np.eye(robot.n)
    q, v = 0.02 * random.standard_normal((2, robot.n))
    q[:3] = q[robot.n // 2 :][:3] = 0.0
    a = np.zeros(robot.n)

    def forces(q, v):
        return robot.inverse_dynamics(q, v, a) - bare.inverse_dynamics(q, v, a)

    assert np.abs(forces(q, v)).max() > 1e-3
    moved = np.transpose([(forces(q + h * e, v) - forces(q - h * e, v)) / (2 * h) for e in units])
    faster = np.transpose([(forces(q, v + h * e) - forces(q, v - h * e)) / (2 * h) for e in units])
    stiffness, damping, _ = (
        mine - other for mine, other in zip(robot.tangent(q, v, a), bare.tangent(q, v, a), strict=True)
    )
    assert_allclose(damping, faster, atol=1e-5 * np.abs(faster).max())
    assert_allclose(stiffness, moved, atol=0.03 * np.abs(moved).max())


@pytest.mark.slow
def test_a_ribbon_that_falls_on_another_keeps_momentum_and_energy():
    robot = crossed(0.0115, 0.0, 1.2, dissipation=0.0, stiffness=1e4)
    v0 = np.zeros(robot.n)
    v0[robot.n // 2 + 2] = -0.05
    run = lissom.simulate(robot, 0.3, method="radau", rtol=1e-7, v0=v0, t_eval=np.linspace(0, 0.3, 16))
    assert run.success, run.message
    touched = [deepest(robot, q) for q in run.q]
    assert max(touched) > 0.0
    momenta = [robot.momentum(q, v) for q, v in zip(run.q, run.v, strict=True)]
    assert_allclose(momenta, np.broadcast_to(momenta[0], np.shape(momenta)), atol=1e-8)
    energies = [robot.energy(q, v).total for q, v in zip(run.q, run.v, strict=True)]
    assert_allclose(energies, energies[0], rtol=5e-3)


def test_a_flat_loop_touches_itself_with_its_thin_side():
    """A ribbon bent to more than a circle, with its ends beside each other along their flat sides."""
    loop = ribbon("loop", modes={"bend_y": 3})
    robot = lissom.Robot([loop], gravity=(0, 0, 0), contacts=[lissom.Contact("loop", "loop")])
    q = np.zeros(robot.n)

    def overlap(curvature, climb):
        q[:] = 0.0
        q[6], q[7] = curvature, climb
        return deepest(robot, q)

    # On a helix the ends are closer the less it climbs; with the wide side as radius all would touch.
    full = 2 * np.pi / 0.4
    overlaps = [overlap(1.35 * full, climb) for climb in np.linspace(0, 12, 13)]
    assert overlaps[0] > 0.0
    assert overlaps[-1] == 0.0
    assert max(overlaps) < 2 * THIN + 1e-9
