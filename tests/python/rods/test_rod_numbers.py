"""`lissom.Rod` compared with independent numbers: equilibria, frequencies, deflections, a release."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import root

import lissom
from rod_cases import Case

NO_GRAVITY = (0, 0, 0)


def lab_rod(modes, **rod):
    segment = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800.0, {"bend_y": modes}, retardation_time=1e-4)
    return lissom.Rod([segment], **rod)


def bending_rod(modes, weight=0.0, **rod):
    """One metre that only bends about y: E I = 1 and, under unit gravity, this weight per length."""
    area, second_moment = np.pi * 1e-4, np.pi * 1e-8 / 4
    density = weight / area if weight else 1.0
    segment = lissom.Segment(1.0, 1e-2, 1 / second_moment, 1 / second_moment, density, {"bend_y": modes})
    return lissom.Rod([segment], **({"gravity": NO_GRAVITY} | rod))


def equilibrium(rod, start=None):
    """Root of the inverse dynamics at rest, with the exact tangent."""
    rest = np.zeros(rod.n)
    solution = root(
        lambda q: rod.inverse_dynamics(q, rest, rest),
        rest if start is None else start,
        jac=lambda q: rod.tangent(q, rest, rest)[0],
        tol=1e-14,
    )
    tau = rod.inverse_dynamics(solution.x, rest, rest)
    straight = rod.inverse_dynamics(rest, rest, rest)
    assert_allclose(tau, 0, atol=1e-10 * np.abs(straight).max(), err_msg=solution.message)
    return solution.x


@pytest.mark.parametrize(
    "q",
    [[0.2408062382], [0.2381234153, -0.3586538798], [0.238212308, -0.3585635333, 0.1214608904]],
    ids=len,
)
def test_lab_rod_sags_under_its_weight(q):
    assert_allclose(equilibrium(lab_rod(len(q))), q, atol=1e-10)


def test_tip_of_the_sagging_lab_rod():
    three = lab_rod(3)
    assert_allclose(three.pose(equilibrium(three), 1.0)[:3, 3], [0.9818006251, 0, -0.1775638079], atol=1e-10)
    # With more modes the solution converges to that of the differential equation.
    eight = lab_rod(8)
    exact = [0.981801548109, 0, -0.177564708339]
    assert_allclose(eight.pose(equilibrium(eight), 1.0)[:3, 3], exact, atol=1e-11)


def test_hanging_lab_rod_is_in_equilibrium():
    rest = np.zeros(3)
    hanging = lab_rod(3, base_orientation=(0.7071068, 0, 0.7071068, 0))
    assert_allclose(hanging.inverse_dynamics(rest, rest, rest), 0, atol=1e-15)
    assert_allclose(hanging.pose(rest, 1.0)[:3, 3], [0, 0, -1], atol=1e-15)


@pytest.mark.parametrize(
    ("modes", "frequencies", "digit"),
    [
        (3, [1.452225, 9.18028, 48.78], [6e-7, 6e-6, 6e-3]),
        (6, [1.451787, 9.098290, 25.48286], [6e-7, 6e-7, 6e-6]),
    ],
)
def test_natural_frequencies(modes, frequencies, digit):
    rod, rest = lab_rod(modes, gravity=NO_GRAVITY), np.zeros(modes)
    stiffness, _, _ = rod.tangent(rest, rest, rest)
    omega = np.sqrt(eigh(stiffness, rod.mass_matrix(rest), eigvals_only=True))
    assert np.all(np.abs(omega[:3] / (2 * np.pi) - frequencies) < digit)


def test_natural_frequencies_converge_to_euler_and_bernoulli():
    rod, rest = lab_rod(9, gravity=NO_GRAVITY), np.zeros(9)
    stiffness, _, _ = rod.tangent(rest, rest, rest)
    omega = np.sqrt(eigh(stiffness, rod.mass_matrix(rest), eigvals_only=True))
    # The rod has rotary inertia, the beam does not: a relative difference of about (r / L)^2 or more.
    assert_allclose(omega[:3] / (2 * np.pi), [1.451788, 9.098201, 25.475226], rtol=3e-5)


def test_condition_of_the_lab_rods_mass_matrix():
    """Its determinant of 1e-13 is meaningless; the condition number matters."""
    mass = lab_rod(3).mass_matrix(np.zeros(3))
    assert np.linalg.det(mass) < 1e-12
    assert 2.5e3 < np.linalg.cond(mass) < 3.5e3


@pytest.mark.parametrize(
    ("load", "shortening", "deflection", "angle"),
    [
        (1, 0.05643324, 0.30172077, 0.46135195),
        (5, 0.38762836, 0.71379152, 1.21536812),
        (10, 0.55499560, 0.81060902, 1.43028554),
    ],
)
def test_elastica_under_a_dead_tip_force(load, shortening, deflection, angle):
    q = np.zeros(12)
    for part in np.linspace(0, load, 5)[1:]:
        rod = bending_rod(12, tip_force=(0, 0, -part))
        q = equilibrium(rod, q)
    pose = rod.pose(q, 1.0)
    assert_allclose(pose[:3, 3], [1 - shortening, 0, -deflection], atol=1e-8)
    assert_allclose(np.arctan2(-pose[2, 0], pose[0, 0]), angle, atol=1e-8)


@pytest.mark.parametrize(
    ("weight", "x", "z"), [(5, 0.8466571800, -0.4959050446), (20, 0.4452320522, -0.8298814434)]
)
def test_heavy_elastica(weight, x, z):
    q = np.zeros(14)
    for part in np.linspace(0, weight, 5)[1:]:
        rod = bending_rod(14, weight=part, gravity=(0, 0, -1))
        q = equilibrium(rod, q)
    assert_allclose(rod.pose(q, 1.0)[:3, 3], [x, 0, z], atol=1e-9)


def test_tip_moment_closes_a_circle():
    rod = bending_rod(1, tip_moment=(0, 2 * np.pi, 0))
    q = equilibrium(rod)
    assert_allclose(q, [2 * np.pi], rtol=1e-13)
    assert_allclose(rod.pose(q, 1.0), np.eye(4), atol=1e-11)


def test_45_degree_bend():
    """Bathe and Bolourchi (1979): a curved cantilever of 1 x 1 section, loaded out of its plane.

    A square section with side a has EA = E a^2, EI = E a^4 / 12 and here G J = G a^4 / 6; the circle with
    radius a / sqrt(3) and moduli multiplied by 3 / pi has the same three values.
    """
    radius, factor = 1 / np.sqrt(3), 3 / np.pi
    pieces, R = 2, 100.0
    segment = {
        "length": R * np.pi / 4 / pieces,
        "radius": radius,
        "young_modulus": factor * 1e7,
        "shear_modulus": factor * 5e6,
        "density": 1.0,
        "modes": dict.fromkeys(("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"), 5),
        "reference_strain": (0, 0, 1 / R, 1, 0, 0),
        "shear_correction": 5 / 6,
    }
    q = np.zeros(30 * pieces)
    for load in np.linspace(0, 600, 7)[1:]:
        case = Case([segment] * pieces, gravity=NO_GRAVITY, tip_force=(0, 0, load))
        q = equilibrium(case.lissom, q)
    tip = case.lissom.pose(q, case.length)[:3, 3]
    unloaded = [R * np.sin(np.pi / 4), R * (1 - np.cos(np.pi / 4)), 0]
    assert_allclose(case.lissom.pose(0 * q, case.length)[:3, 3], unloaded, atol=1e-10)
    assert_allclose(tip - unloaded, [-23.560582, -13.604632, 53.475478], atol=1e-5)
    # The reference is in equilibrium at the same place.
    assert_allclose(case.reference.inverse_dynamics(q, 0 * q, 0 * q), 0, atol=1e-8 * 600 * case.length)
    assert_allclose(case.reference.poses(q, [case.length])[0, :3, 3], tip, atol=1e-8)


def test_lab_rod_released_from_horizontal():
    """With SciPy as the integrator, so that only the rod is tested."""
    rod = lab_rod(3)
    times, tips = (
        [0.1, 0.5, 1.0, 3.0],
        [
            [0.9970663766, -0.0712500678],
            [0.9807178651, -0.1838140514],
            [0.9273593387, -0.3468061965],
            [0.9338616378, -0.333168186],
        ],
    )

    def rate(_, y):
        return np.concatenate([y[3:], rod.forward_dynamics(y[:3], y[3:])])

    run = solve_ivp(rate, (0, 3), np.zeros(6), method="DOP853", t_eval=times, rtol=1e-10, atol=1e-12)
    assert run.success
    found = [rod.pose(q, 1.0)[[0, 2], 3] for q in run.y[:3].T]
    assert_allclose(found, tips, atol=1e-8)
