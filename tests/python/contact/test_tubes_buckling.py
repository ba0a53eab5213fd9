"""Long rods in straight tubes under axial force: waves and helices, against the theory of pipes in wells.

Rods with the bending stiffness B at the bottom of a horizontal tube, with the radial clearance r and the
weight w per length, buckle in waves at F = 2 sqrt(B w / r) (Dawson and Paslay 1984). Without weight a helix
presses with F^2 r / (4 B) per length on the wall at the pitch p = sqrt(8 pi^2 B / F) (Lubinski, Althouse and
Logan 1962).
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

G, LENGTH, RADIUS, CLEARANCE = 9.81, 2.0, 2e-3, 3e-3
YOUNG, DENSITY = 2e9, 4000.0
BENDING = YOUNG * np.pi * RADIUS**4 / 4
WEIGHT = DENSITY * np.pi * RADIUS**2 * G
STIFFNESS = 1e6
#: Distance of the axis at rest from that of the tube.
REST = CLEARANCE + WEIGHT / STIFFNESS
WAVES = 2.0 * np.sqrt(BENDING * WEIGHT / REST)
PARTS, MODES = 16, 3


def pipe(force, weight=1.0):
    """A rod between pins at the bottom of the tube, which hold it compressed by a force."""
    strain = force / (YOUNG * np.pi * RADIUS**2)
    part = lissom.Segment(
        LENGTH / PARTS,
        RADIUS,
        YOUNG,
        YOUNG / 2.6,
        DENSITY,
        modes={"bend_y": MODES, "bend_z": MODES, "stretch": 1},
    )
    hinge = lissom.Universal((0, 1, 0), (0, 0, 1))
    link = lissom.Link("rod", rod=[part] * PARTS, joint=hinge, position=(0, 0, -REST))
    pin = lissom.Loop(
        (None, None, (LENGTH * (1 - strain), 0, -REST)), ("rod",), lissom.Spherical(), name="pin"
    )
    tube = lissom.Tube([(-1, 0, 0), (LENGTH + 1, 0, 0)], RADIUS + CLEARANCE)
    wall = lissom.Contact("rod", tube, stiffness=STIFFNESS)
    robot = lissom.Robot([link], loops=[pin], contacts=[wall], gravity=(0, 0, -weight * G))
    q = np.zeros(robot.n)
    q[2 + 2 * MODES :: 2 * MODES + 1] = -strain
    return robot, q


def coordinates(robot, q, curvature):
    """Coordinates with a curvature (y, z) of arc length, projected onto the modes."""
    q = q.copy()
    x, weights = np.polynomial.legendre.leggauss(8)
    for part in range(PARTS):
        values = np.array([curvature((part + (at + 1) / 2) * LENGTH / PARTS) for at in x])
        for k in range(MODES):
            shape = np.polynomial.legendre.Legendre.basis(k)(x) * (k + 0.5) * weights
            start = 2 + part * (2 * MODES + 1)
            q[start + k], q[start + MODES + k] = shape @ values
    return q


def half_waves(number, force):
    """Square of the angular frequency of so many half waves, from the linear theory."""
    beta = number * np.pi / LENGTH
    return (BENDING * beta**4 - force * beta**2 + WEIGHT / REST) / (WEIGHT / G)


def test_a_heavy_rod_loses_its_stiffness_at_the_force_of_dawson_and_paslay():
    number = min(
        range(1, 20),
        key=lambda n: BENDING * (n * np.pi / LENGTH) ** 2 + WEIGHT / REST / (n * np.pi / LENGTH) ** 2,
    )
    beta = number * np.pi / LENGTH
    critical = BENDING * beta**2 + WEIGHT / (REST * beta**2)
    assert critical == pytest.approx(WAVES, rel=0.01)
    for share in (0.5, 0.9, 0.99):
        robot, q = pipe(share * critical)
        found = lissom.statics(robot, q)
        assert found.success, found.message
        # Straight, as it was.
        line = robot.pose(found.q, np.linspace(0, LENGTH, 50), link="rod")[:, :3, 3]
        assert np.abs(line[:, 1]).max() < 1e-7
        square = lissom.modes(robot, found.q).angular_frequency.min() ** 2
        wanted = min(half_waves(n, share * critical) for n in range(1, 30))
        assert square == pytest.approx(wanted, abs=2e-3 * half_waves(number, 0.0))


def test_beyond_that_force_it_lies_in_waves():
    """From a small wave, which decays below the force of buckling and grows above it."""
    number = min(range(1, 30), key=lambda n: abs(half_waves(n, WAVES)))
    beta = number * np.pi / LENGTH
    critical = BENDING * beta**2 + WEIGHT / (REST * beta**2)
    angles = []
    for share in (0.95, 1.1):
        robot, q = pipe(share * critical)
        q0 = coordinates(robot, q, lambda x: (0.0, -0.1 * REST * beta**2 * np.sin(beta * x)))
        q0[1] = 0.1 * REST * beta
        found = lissom.statics(robot, q0)
        assert found.success, found.message
        line = robot.pose(found.q, np.linspace(0, LENGTH, 400), link="rod")[:, :3, 3]
        angles.append(np.arctan2(line[:, 1], -line[:, 2]))
    assert np.abs(angles[0]).max() < 1e-6
    assert 0.1 < np.abs(angles[1]).max() < 2.0
    crossings = np.count_nonzero(np.diff(np.sign(angles[1][5:-5])))
    assert abs(crossings - (number - 1)) <= 1


def helix(turns, force, weight=0.0):
    """A rod between pins in a tube without weight, wound about the axis from its start on."""
    robot, q = pipe(force, weight)
    beta = 2 * np.pi * turns / LENGTH
    # From the bottom about the axis: curvature REST beta^2 towards it.
    q0 = coordinates(robot, q, lambda x: REST * beta**2 * np.array([-np.cos(beta * x), np.sin(beta * x)]))
    q0[1] = REST * beta
    return robot, q0


@pytest.mark.parametrize("share", [1.0, 2.0])
def test_helices_of_weightless_rods_press_as_hard_as_their_pitch_asks_for(share):
    """By F r w^2 - B r w^4 at the rate w of the turns, which is Lubinski's F^2 r / (4 B) at his pitch."""
    beta = 2 * np.pi * 4 / LENGTH
    robot, q0 = helix(4, share * 2 * BENDING * beta**2)
    found = lissom.statics(robot, q0)
    assert found.success, found.message
    line = robot.pose(found.q, np.linspace(0.6, 1.4, 101), link="rod")[:, :3, 3]
    radius = np.hypot(line[:, 1], line[:, 2])
    assert_allclose(radius, CLEARANCE, rtol=1e-3)
    rates = np.diff(np.unwrap(np.arctan2(line[:, 1], line[:, 2]))) / np.diff(line[:, 0])
    rate = rates.mean()
    assert_allclose(rates, rate, rtol=0.01)
    rest = np.zeros(robot.n)
    force = robot.base_wrench(found.q, rest, rest)[3]
    touches = [touch for touch in robot.touches(found.q) if 0.6 < touch.along[0] < 1.4]
    pressed = sum(touch.force @ touch.normal for touch in touches) / 0.8
    wanted = force * CLEARANCE * rate**2 - BENDING * CLEARANCE * rate**4
    # Places at the ends of the part count by whole Gauss points.
    assert pressed == pytest.approx(wanted, rel=0.01)
