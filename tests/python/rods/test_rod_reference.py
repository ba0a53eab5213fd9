"""The NumPy reference of the rod, validated before its use.

Statics, frequencies and large deflections are compared with independent numbers. Dynamics is compared with
Lagrange's equations of the energies, which share only the velocities with the Newton-Euler recursion.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import eigh
from scipy.optimize import root

from reference.rod import STRAINS, Rod, Segment

NO_GRAVITY = (0, 0, 0)


def lab_segment(modes):
    return Segment(1.0, 1e-3, 210e9, 80e9, 7800.0, {"bend_y": modes}, retardation_time=1e-4)


def bending_segment(flexural_rigidity=1.0, weight=0.0, modes=6):
    """One metre that only bends about y, with given E I and, under unit gravity, weight per length."""
    area, second_moment = np.pi * 1e-4, np.pi * 1e-8 / 4
    density = weight / area if weight else 1.0
    return Segment(1.0, 1e-2, flexural_rigidity / second_moment, 1e9, density, {"bend_y": modes})


def equilibrium(rod):
    rest = np.zeros(rod.n)
    solution = root(lambda q: rod.inverse_dynamics(q, rest, rest), rest, tol=1e-12)
    # Compared by the residual: if only rounding remains, MINPACK reports slow progress on some machines.
    assert_allclose(solution.fun, 0.0, atol=1e-11, err_msg=solution.message)
    return solution.x


def tip(rod, q):
    return rod.poses(q, [sum(segment.length for segment in rod.segments)])[0]


@pytest.mark.parametrize(
    "q",
    [[0.2408062382], [0.2381234153, -0.3586538798], [0.238212308, -0.3585635333, 0.1214608904]],
    ids=len,
)
def test_lab_rod_sags_under_its_weight(q):
    rod = Rod([lab_segment(len(q))])
    assert_allclose(equilibrium(rod), q, atol=1e-10)
    if len(q) == 3:
        assert_allclose(tip(rod, q)[:3, 3], [0.9818006251, 0, -0.1775638079], atol=1e-10)


@pytest.mark.parametrize("frequencies", [[1.452225, 9.18028, 48.78], [1.451787, 9.098290, 25.48286]])
def test_lab_rod_natural_frequencies(frequencies):
    n = 3 if frequencies[-1] > 40 else 6
    rod, rest = Rod([lab_segment(n)], gravity=NO_GRAVITY), np.zeros(n)
    stiffness = np.column_stack([rod.inverse_dynamics(unit, rest, rest) for unit in np.eye(n)])
    omega = np.sqrt(eigh(stiffness, rod.mass_matrix(rest), eigvals_only=True))
    assert_allclose(omega[:3] / (2 * np.pi), frequencies, rtol=1e-4)
    assert_allclose(omega[0] / (2 * np.pi), frequencies[0], rtol=5e-7)


@pytest.mark.parametrize(
    ("load", "shortening", "deflection", "angle"),
    [(1, 0.05643324, 0.30172077, 0.46135195), (5, 0.38762836, 0.71379152, 1.21536812)],
)
def test_elastica_under_a_dead_tip_force(load, shortening, deflection, angle):
    rod = Rod([bending_segment()], gravity=NO_GRAVITY, tip_force=(0, 0, -load))
    pose = tip(rod, equilibrium(rod))
    assert_allclose(pose[:3, 3], [1 - shortening, 0, -deflection], atol=1e-7)
    assert_allclose(np.arctan2(-pose[2, 0], pose[0, 0]), angle, atol=1e-7)


def test_heavy_elastica():
    rod = Rod([bending_segment(weight=5.0, modes=8)], gravity=(0, 0, -1))
    assert_allclose(tip(rod, equilibrium(rod))[:3, 3], [0.8466571800, 0, -0.4959050446], atol=1e-8)


def test_tip_moment_closes_a_circle():
    rod = Rod([bending_segment(modes=1)], gravity=NO_GRAVITY, tip_moment=(0, 2 * np.pi, 0))
    q = equilibrium(rod)
    assert_allclose(q, [2 * np.pi], rtol=1e-12)
    assert_allclose(tip(rod, q), np.eye(4), atol=1e-11)
    assert_allclose(rod.poses(q, [0.5])[0][:3, 3], [0, 0, -1 / np.pi], atol=1e-11)


def spatial_rod():
    """All features: two tapered, curved, twisted segments on a rotated base, tip mass and force."""
    first = Segment(
        *(0.7, (0.02, 0.01), 5e6, 2e6, 1000.0, {"torsion": 1, "bend_y": 2, "stretch": 1}),
        reference_strain=(0.1, 0.2, 0.3, 1.1, 0.1, -0.1),
        shear_correction=0.8,
    )
    second = Segment(1.3, (0.01, 0.015), 5e6, 2e6, 1200.0, {"bend_z": 2, "shear_y": 1})
    return Rod(
        [first, second],
        base_position=(1, 2, 3),
        base_orientation=(0.5, 0.5, -0.5, 0.5),
        gravity=(1, 2, -9),
        tip_force=(0.1, 0.2, 0.3),
        tip_mass=0.05,
    )


def central_difference(function, step):
    """Fourth-order difference at zero."""
    near, far = function(step) - function(-step), function(2 * step) - function(-2 * step)
    return (8 * near - far) / (12 * step)


def test_power_of_the_generalised_forces_is_the_rate_of_the_energy():
    rod, rng = spatial_rod(), np.random.default_rng(1)
    q, qd, qdd = 0.3 * rng.standard_normal((3, rod.n))
    rate = central_difference(
        lambda t: rod.energy(q + t * qd + t**2 / 2 * qdd, qd + t * qdd).total, step=1e-3
    )
    assert_allclose(qd @ rod.inverse_dynamics(q, qd, qdd), rate, rtol=1e-8)


def test_lagranges_equations():
    rod, rng = spatial_rod(), np.random.default_rng(2)
    q, qd, qdd = 0.3 * rng.standard_normal((3, rod.n))

    def momentum(t):
        # The kinetic energy is quadratic in the velocities, so that this difference is exact.
        at, velocity = q + t * qd + t**2 / 2 * qdd, qd + t * qdd
        sides = [[rod.energy(at, velocity + s * unit).kinetic for s in (1, -1)] for unit in np.eye(rod.n)]
        return np.subtract(*np.transpose(sides)) / 2

    def lagrangian(at):
        energy = rod.energy(at, qd)
        return 2 * energy.kinetic - energy.total

    force = central_difference(momentum, step=1e-3)
    gradient = [
        central_difference(lambda h, u=unit: lagrangian(q + h * u), step=1e-3) for unit in np.eye(rod.n)
    ]
    tau = rod.inverse_dynamics(q, qd, qdd)
    assert_allclose(tau, force - gradient, rtol=1e-8, atol=1e-8 * np.abs(tau).max())


def test_mass_matrix_is_symmetric_and_gives_the_kinetic_energy():
    rod, rng = spatial_rod(), np.random.default_rng(3)
    q, qd = rng.standard_normal((2, rod.n))
    mass = rod.mass_matrix(q)
    assert_allclose(mass, mass.T, atol=1e-11 * np.abs(mass).max())
    assert_allclose(qd @ mass @ qd / 2, rod.energy(q, qd).kinetic, rtol=1e-11)


def test_several_motions_at_once_are_the_same_as_one_by_one():
    rod, rng = spatial_rod(), np.random.default_rng(4)
    q, qd = 0.3 * rng.standard_normal((2, rod.n))
    motions = rng.standard_normal((rod.n, 3))
    one_by_one = np.column_stack([rod.inverse_dynamics(q, qd, motion) for motion in motions.T])
    assert_allclose(rod.inverse_dynamics(q, qd, motions), one_by_one, rtol=1e-10)


def test_damping_is_stiffness_times_retardation_time():
    for name in STRAINS:
        elastic = Rod([Segment(0.6, (0.02, 0.01), 5e6, 2e6, 1000.0, {name: 2})], gravity=NO_GRAVITY)
        damped = Rod(
            [Segment(0.6, (0.02, 0.01), 5e6, 2e6, 1000.0, {name: 2}, retardation_time=0.03)],
            gravity=NO_GRAVITY,
        )
        q, qd, rest = np.array([0.1, -0.2]), np.array([0.3, 0.1]), np.zeros(2)
        spring = elastic.inverse_dynamics(qd, rest, rest)
        extra = damped.inverse_dynamics(q, qd, rest) - elastic.inverse_dynamics(q, qd, rest)
        assert_allclose(extra, 0.03 * spring, rtol=1e-9)
