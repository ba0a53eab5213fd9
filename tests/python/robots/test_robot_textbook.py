"""The NumPy reference of robots compared with hand-written equations and motions computed elsewhere."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from reference.robot import build

G = 9.81
Y_HINGE = {"type": "revolute", "axis": (0, 1, 0)}
DOWN = (0.5**0.5, 0.0, 0.5**0.5, 0.0)
"""Rotates x to -z: a link that hangs at angle zero."""


def states(n, count=3, size=1.5):
    return size * np.random.default_rng(n).standard_normal((count, 3, n))


def test_rigid_pendulum():
    """(I + m c^2) a + m g c sin q = tau: a bar on a hinge, with its centre at c."""
    m, c, I = 1.3, 0.4, 0.02
    body = {"mass": m, "centre": (c, 0, 0), "inertia": (0.001, I, 0.03)}
    robot = build({"links": [{"name": "bar", "joint": Y_HINGE, "body": body, "orientation": DOWN}]})
    for q, v, a in states(1):
        tau = (I + m * c**2) * a + m * G * c * np.sin(q)
        assert_allclose(robot.inverse_dynamics(q, v, a), tau, rtol=1e-13)


def double_pendulum(l1, c1, m1, I1, c2, m2, I2):
    links = [
        {"name": "upper", "body": {"mass": m1, "centre": (c1, 0, 0), "inertia": (0, I1, I1)}},
        {
            "name": "lower",
            "parent": "upper",
            "position": (l1, 0, 0),
            "body": {"mass": m2, "centre": (c2, 0, 0), "inertia": (0, I2, I2)},
        },
    ]
    links[0]["orientation"] = DOWN
    return build({"links": [{"joint": Y_HINGE} | link for link in links]})


def test_double_pendulum():
    """Lagrange's equations for absolute angles t1, t2 from the downward vertical; q2 = t2 - t1."""
    l1, c1, m1, I1, c2, m2, I2 = 0.7, 0.3, 1.1, 0.05, 0.4, 0.8, 0.03
    robot = double_pendulum(l1, c1, m1, I1, c2, m2, I2)
    to_absolute = np.array([[1, 0], [1, 1]])
    for q, v, a in states(2):
        (t1, t2), (w1, w2), (a1, a2) = (to_absolute @ x for x in (q, v, a))
        cos, sin = np.cos(t1 - t2), np.sin(t1 - t2)
        first = (I1 + m1 * c1**2 + m2 * l1**2) * a1 + m2 * l1 * c2 * (a2 * cos + w2**2 * sin)
        first += (m1 * c1 + m2 * l1) * G * np.sin(t1)
        second = (I2 + m2 * c2**2) * a2 + m2 * l1 * c2 * (a1 * cos - w1**2 * sin) + m2 * G * c2 * np.sin(t2)
        assert_allclose(robot.inverse_dynamics(q, v, a), to_absolute.T @ [first, second], rtol=1e-12)


def rotation_rates(phi, phi_t, phi_tt):
    """R, and omega and its rate in body axes, by differences of SciPy's rotations in time."""
    h = 1e-3
    times = h * np.arange(-2, 3)
    turns = [Rotation.from_rotvec(phi + t * phi_t + t**2 / 2 * phi_tt).as_matrix() for t in times]
    R = turns[2]
    first = np.tensordot(np.array([1, -8, 0, 8, -1]) / 12, turns, 1) / h
    second = np.tensordot(np.array([-1, 16, -30, 16, -1]) / 12, turns, 1) / h**2

    def axial(A):
        A = (A - A.T) / 2
        return np.array([A[2, 1], A[0, 2], A[1, 0]])

    # R'' = R ([rate] + [omega]^2), where the square is symmetric.
    return R, axial(R.T @ first), axial(R.T @ second)


def turns_of_coordinates(phi):
    """Columns: small rotations in body axes for unit changes of a rotation vector."""
    return np.column_stack([rotation_rates(phi, unit, np.zeros(3))[1] for unit in np.eye(3)])


I_BODY = np.array([[0.3, 0.02, -0.01], [0.02, 0.4, 0.03], [-0.01, 0.03, 0.5]])


def test_eulers_equations_of_a_body_on_a_ball():
    """I omega_t + omega x I omega - c x m R^T g about the fixed point, by the virtual work of this moment."""
    m, c = 1.5, np.array([0.1, -0.2, 0.3])
    body = {"mass": m, "centre": c, "inertia": I_BODY}
    robot = build({"links": [{"name": "top", "joint": {"type": "spherical"}, "body": body}]})
    about_point = I_BODY + m * (c @ c * np.eye(3) - np.outer(c, c))
    for q, v, a in states(3, size=0.8):
        R, omega, omega_t = rotation_rates(q, v, a)
        moment = about_point @ omega_t + np.cross(omega, about_point @ omega)
        moment -= np.cross(c, m * R.T @ [0, 0, -G])
        assert_allclose(robot.inverse_dynamics(q, v, a), turns_of_coordinates(q).T @ moment, atol=1e-8)


def test_free_body():
    """Newton's law for the centre of mass, Euler's equations about it."""
    m, c = 1.5, np.array([0.1, -0.2, 0.3])
    body = {"mass": m, "centre": c, "inertia": I_BODY}
    robot = build({"links": [{"name": "stone", "joint": {"type": "free"}, "body": body}]})
    for q, v, a in states(6, size=0.8):
        R, omega, omega_t = rotation_rates(q[3:], v[3:], a[3:])
        centre = a[:3] + R @ (np.cross(omega_t, c) + np.cross(omega, np.cross(omega, c)))
        force = m * (centre - [0, 0, -G])
        moment = I_BODY @ omega_t + np.cross(omega, I_BODY @ omega) + np.cross(c, R.T @ force)
        tau = np.concatenate([force, turns_of_coordinates(q[3:]).T @ moment])
        assert_allclose(robot.inverse_dynamics(q, v, a), tau, atol=1e-7)


def test_heavy_top_in_eulers_angles():
    """Lagrange's symmetric top: precession, nutation and spin as three hinges z, x, z."""
    m, l, A, C = 1.2, 0.3, 0.2, 0.05
    top = {"mass": m, "centre": (0, 0, l), "inertia": (A - m * l**2, A - m * l**2, C)}
    axes = {"precession": (0, 0, 1), "nutation": (1, 0, 0), "spin": (0, 0, 1)}
    links = [{"name": name, "joint": {"type": "revolute", "axis": axis}} for name, axis in axes.items()]
    links[1]["parent"], links[2]["parent"], links[2]["body"] = "precession", "nutation", top
    robot = build({"links": links})
    for q, v, a in states(3):
        theta, (precession, nutation, spin) = q[1], v
        sin, cos = np.sin(theta), np.cos(theta)
        along = C * (spin + precession * cos)
        along_rate = C * (a[2] + a[0] * cos - precession * nutation * sin)
        upright = A * (a[0] * sin**2 + 2 * precession * nutation * sin * cos)
        upright += along_rate * cos - along * nutation * sin
        tilt = A * a[1] - A * precession**2 * sin * cos + along * precession * sin - m * G * l * sin
        assert_allclose(robot.inverse_dynamics(q, v, a), [upright, tilt, along_rate], rtol=1e-11, atol=1e-12)


def test_ball_sliding_in_a_turning_tube():
    """A point mass in a tube that rotates in a plane: m (r'' - r w^2) and d/dt (m r^2 w)."""
    m = 0.7
    tube = {"name": "tube", "joint": {"type": "revolute", "axis": (0, 0, 1)}}
    ball = {"name": "ball", "parent": "tube", "joint": {"type": "prismatic", "axis": (1, 0, 0)}}
    robot = build({"gravity": (0, 0, 0), "links": [tube, ball | {"body": {"mass": m}}]})
    for (_, r), (w, speed), (turning, a) in states(2):
        tau = robot.inverse_dynamics([0.4, r], [w, speed], [turning, a])
        expected = [m * (r**2 * turning + 2 * r * speed * w), m * (a - r * w**2)]
        assert_allclose(tau, expected, rtol=1e-13, atol=1e-13)


# Motions computed elsewhere


def moved(robot, q, v, duration, pieces=1, tolerance=1e-10):
    """The free motion, with rotation vectors wrapped after every part of the time."""
    y = np.array([q, v], float)
    for _ in range(pieces):

        def change(t, y):
            q, v = y.reshape(2, -1)
            return np.concatenate([v, robot.forward_dynamics(q, v)])

        path = solve_ivp(
            change, (0, duration / pieces), y.ravel(), method="DOP853", rtol=tolerance, atol=tolerance
        )
        y = path.y[:, -1].reshape(2, -1)
        y = np.array(robot.wrap(*y, np.zeros(robot.n))[:2])
    return y


@pytest.mark.parametrize(
    ("I", "c", "angles"),
    [(0.0, 1.0, (0.570472051233, 1.203875111158)), (1 / 12, 0.5, (0.448142625932, 1.041962887304))],
    ids=["points", "bars"],
)
def test_double_pendulum_from_horizontal(I, c, angles):
    """Absolute angles after half a second, from Lagrange's equations with tolerances of 1e-13."""
    robot = double_pendulum(1.0, c, 1.0, I, c, 1.0, I)
    q, _ = moved(robot, [np.pi / 2, 0], [0, 0], 0.5)
    assert_allclose(np.cumsum(q), angles, atol=1e-8)


def test_torque_free_body():
    """Rotation nearly about its middle axis: Euler's equations for the angular velocity at 2 s."""
    body = {"mass": 1.0, "inertia": (1, 2, 3)}
    robot = build({"links": [{"name": "T", "joint": {"type": "free"}, "body": body}], "gravity": (0, 0, 0)})
    q, v = moved(robot, np.zeros(6), [0, 0, 0, 0.1, 2.0, 0.1], 2.0, pieces=4)
    turn = robot.pose(q, link="T")[:3, :3]
    omega = turn.T @ robot.velocity(q, v, link="T")[:3]
    assert_allclose(omega, [-0.3535142808, 1.9710473493, 0.2198274677], atol=1e-8)


def test_spherical_pendulum():
    """A point mass at 1 m from a ball joint, 60 degrees from the vertical, pushed sideways; after 0.5 s."""
    start = np.array([np.sin(np.pi / 3), 0, -np.cos(np.pi / 3)])
    bob = {"mass": 1.0, "centre": start, "inertia": 0.01 * np.outer(start, start)}
    robot = build({"links": [{"name": "bob", "joint": {"type": "spherical"}, "body": bob}]})
    # Sideways with an azimuth rate of 1 rad/s, without spin about the thread.
    omega = np.cross(start, np.cross([0, 0, 1], start))
    q, _ = moved(robot, np.zeros(3), omega, 0.5)
    place = robot.pose(q, link="bob")[:3, :3] @ start
    assert_allclose(place, [0.08045081808, 0.25096246207, -0.96464786762], atol=1e-8)


def test_fast_heavy_top():
    """150 rad/s over several turns, as in published benchmarks; position of its centre at 0.1 s."""
    body = {"mass": 15.0, "centre": (0, 1, 0), "inertia": (0.234375, 0.46875, 0.234375)}
    robot = build({"links": [{"name": "top", "joint": {"type": "spherical"}, "body": body}]})
    q, _ = moved(robot, np.zeros(3), [0, 150, -4.61538], 0.1, pieces=10, tolerance=1e-9)
    centre = robot.pose(q, link="top")[:3, 1]
    assert_allclose(centre, [0.4212966589, 0.8945719743, -0.1491647006], atol=1e-7)


# Small vibrations of rods


@pytest.mark.parametrize(
    ("joint", "rigid", "roots"),
    [
        ({"type": "free"}, 6, (4.7300407449, 7.8532046241)),
        (Y_HINGE, 1, (3.9266023120, 7.0685827456)),
    ],
    ids=["free", "hinged"],
)
def test_natural_frequencies_of_beams(joint, rigid, roots):
    """Roots of cos cosh = 1 and of tan = tanh, and a zero for each rigid motion."""
    L, r, E, rho = 0.5, 1e-4, 1e9, 1000.0
    beam = {"length": L, "radius": r, "young_modulus": E, "shear_modulus": E, "density": rho}
    link = {"name": "beam", "joint": joint, "rod": [beam | {"modes": {"bend_y": 8}}]}
    robot = build({"links": [link], "gravity": (0, 0, 0)})
    rest = np.zeros(robot.n)
    stiffness = np.column_stack([robot.inverse_dynamics(unit, rest, rest) for unit in np.eye(robot.n)])
    squares = eigh(stiffness, robot.mass_matrix(rest), eigvals_only=True)
    # (beta L)^4 = rho A omega^2 L^4 / (E I). Rotary inertia reduces it by about (beta r)^2.
    scaled = 4 * rho * squares * L**4 / (E * r**2)
    assert_allclose(scaled[:rigid], 0, atol=1e-3)
    assert_allclose(scaled[rigid : rigid + 2] ** (1 / 4), roots, rtol=1e-6)
