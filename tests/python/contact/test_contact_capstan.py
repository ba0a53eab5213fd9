"""A cable around a drum: the tension grows exponentially with the angle (Euler 1769, Eytelwein 1808)."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

DRUM, RADIUS, LOAD, SPEED = 0.05, 0.002, 5.0, 0.02
#: Bending radius of the cable's axis on the drum.
BEND = DRUM + RADIUS
YOUNG = 5e6
ARC = np.pi * BEND


def cable(friction, speed):
    """The cable lies around half of a drum with a load at its tip, and its base moves along x."""

    def part(length, modes):
        return lissom.Segment(
            length, radius=RADIUS, young_modulus=YOUNG, poisson_ratio=0.5, density=1000,
            modes={"bend_y": modes}, retardation_time=1e-3,
        )  # fmt: skip

    base = lissom.Prismatic((1, 0, 0), motion=lambda t: speed * (t - 0.02 * (1 - np.exp(-t / 0.02))))
    segments = [part(0.1, 3)] + [part(ARC / 12, 2)] * 12 + [part(0.1, 3)]
    link = lissom.Link("cable", rod=segments, joint=base, position=(-0.1, 0, BEND))
    drum = lissom.Contact(
        "cable", lissom.Capsule((0, -1, 0), (0, 1, 0), DRUM), stiffness=1e7, friction=friction
    )
    load = lissom.Load(force=(-LOAD, 0, 0), link="cable")
    robot = lissom.Robot([link], contacts=[drum], loads=[load], gravity=(0, 0, 0))
    q0 = np.zeros(robot.n)
    q0[3:27:2] = 1 / BEND
    start = lissom.statics(robot, q0, space_error=False)
    assert start.success, start.message
    return robot, start.q


def exponent(friction):
    """Exponent of the tension as a function of the angle, for a cable that is not thin.

    Friction acts at the drum's radius R, tension T and shear Q at R + r; the moment is constant. With the
    pressure N per angle: T' (R + r) = mu N R, T' + Q = mu N, N = T - Q', solved by N ~ exp(lambda phi) with
    lambda (1 + mu p lambda) = mu (1 - p), p = r / (R + r).
    """
    p = RADIUS / BEND
    return (np.sqrt(1 + 4 * friction**2 * p * (1 - p)) - 1) / (2 * friction * p)


def torques(robot, state, X, t):
    """Torques about the drum's axis through sections, and the angles of these sections."""
    poses = robot.pose(state[0], X, t=t)
    wrenches = robot.internal_wrench(*state, X, t=t)
    moments, forces = (np.einsum("kij,kj->ki", poses[:, :3, :3], part) for part in np.split(wrenches, 2, 1))
    places = poses[:, :3, 3]
    return (np.cross(places, forces) + moments)[:, 1], np.arctan2(places[:, 0], places[:, 2])


@pytest.mark.parametrize("friction", [0.3, 0.6])
@pytest.mark.parametrize("side", [1, -1])
def test_tension_grows_with_the_angle_against_the_motion(friction, side):
    # 1: the base lifts the load; -1: it lowers the load.
    robot, q0 = cable(friction, -side * SPEED)
    result = lissom.simulate(robot, 0.1, dt=2e-3, q0=q0)
    assert result.success, result.message
    state = result.q[-1], result.v[-1], result.a[-1]
    t = result.t[-1]
    torque, angle = torques(robot, state, 0.1 + ARC * np.array([0.25, 0.75]), t)
    # Without the constant moment of the bent cable, which is the same in all sections.
    bending = YOUNG * np.pi / 4 * RADIUS**4 / BEND
    grows = np.diff(np.log(np.abs(torque + bending))) / np.diff(angle)
    # The overlap reduces the radius by 4e-4; the pressure oscillates with the modes, so that the part of it
    # between two sections varies.
    assert_allclose(grows, -side * exponent(friction), rtol=2e-3)
    # From end to end, where bending at the points of departure moves these places.
    base = robot.joint_wrench(*state, link="cable", t=t)[3]
    assert_allclose(np.log(-base / LOAD) / np.pi, side * exponent(friction), rtol=bending / (LOAD * BEND))


def test_without_friction_a_drum_has_no_torque():
    robot, q = cable(0.0, 0.0)
    rest = np.zeros_like(q)
    torque, _ = torques(robot, (q, rest, rest), 0.1 + ARC * np.linspace(0.1, 0.9, 5), 0.0)
    assert_allclose(torque, torque[0], rtol=1e-9)
    assert_allclose(torque, -LOAD * BEND, rtol=1e-2)
    assert_allclose(robot.contact_forces(q, rest, t=0.0)[3:], [2 * LOAD, 0, 0], atol=1e-2 * LOAD)


def test_slow_motions_without_inertia_have_the_same_tension():
    robot, q0 = cable(0.3, -SPEED)
    result = lissom.simulate(robot, 0.1, dt=1e-2, q0=q0, method="quasi_static")
    assert result.success, result.message
    state = result.q[-1], result.v[-1], result.a[-1]
    torque, angle = torques(robot, state, 0.1 + ARC * np.array([0.25, 0.75]), result.t[-1])
    bending = YOUNG * np.pi / 4 * RADIUS**4 / BEND
    grows = np.diff(np.log(np.abs(torque + bending))) / np.diff(angle)
    assert_allclose(grows, -exponent(0.3), rtol=2e-3)
