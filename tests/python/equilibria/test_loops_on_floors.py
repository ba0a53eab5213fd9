"""Equilibria of rods closed by loops that lie on floors: stability beside the energy of closed shapes."""

import numpy as np
import pytest
import scipy.linalg

import lissom

HINGE = lissom.Revolute((0, 1, 0))
#: Distance of the supports of the arch, whose rod is 1 m long.
SPAN = 0.8
#: Steps of coordinates for differences of energy, 1/m.
STEP = 1e-4


def arch(joint, closing, floor):
    """A rod that sags between two supports, onto a floor this far below them."""
    segment = lissom.Segment(
        1.0, 6e-3, 5e6, poisson_ratio=0.5, density=1100, modes={"bend_y": 6}, retardation_time=0.0
    )
    return lissom.Robot(
        [lissom.Link("rod", rod=[segment], joint=joint)],
        loops=[lissom.Loop("rod", (None, None, (SPAN, 0, 0)), closing)],
        contacts=[
            lissom.Contact(
                "rod", lissom.HalfSpace((0, 0, -floor)), stiffness=1e5, dissipation=0.0, friction=0.0
            )
        ],
    )


def gaps(robot, q, closing):
    pose = robot.pose(q)
    gap = pose[[0, 2], 3] - [SPAN, 0.0]
    return np.append(gap, np.arctan2(pose[2, 0], pose[0, 0])) if isinstance(closing, lissom.Weld) else gap


def differences(robot, q, closing):
    columns = [
        (gaps(robot, q + 1e-6 * e, closing) - gaps(robot, q - 1e-6 * e, closing)) / 2e-6
        for e in np.eye(len(q))
    ]
    return np.transpose(columns)


def lowest_stiffness(robot, q, closing):
    """Smallest eigenvalue of the second differences of the potential energy over closed shapes, s^-2."""
    free = scipy.linalg.null_space(differences(robot, q, closing))

    def potential(y):
        shape = q + free @ y
        for _ in range(6):
            jacobian = differences(robot, shape, closing)
            shape = shape - np.linalg.pinv(jacobian) @ gaps(robot, shape, closing)
        energy = robot.energy(shape, 0.0 * q)
        return energy.elastic + energy.gravitational

    m = free.shape[1]
    steps, zero = STEP * np.eye(m), potential(np.zeros(m))
    hessian = np.empty((m, m))
    for i, a in enumerate(steps):
        hessian[i, i] = potential(a) - 2 * zero + potential(-a)
        for j, b in enumerate(steps[:i]):
            mixed = potential(a + b) - potential(a - b) - potential(b - a) + potential(-a - b)
            hessian[i, j] = hessian[j, i] = mixed / 4
    mass = free.T @ robot.mass_matrix(q) @ free
    return scipy.linalg.eigh(hessian / STEP**2, mass, eigvals_only=True)[0]


@pytest.mark.parametrize("floor", [0.15, 0.2, 0.25])
@pytest.mark.parametrize(
    ("joint", "closing"),
    [(lissom.Weld(), lissom.Weld()), (HINGE, HINGE), (lissom.Weld(), HINGE)],
    ids=["clamped", "hinged", "clamped and hinged"],
)
def test_stability_is_that_of_the_energy(joint, closing, floor):
    robot = arch(joint, closing, floor)
    q0 = np.zeros(robot.n)
    # Several waves: the shape falls onto the floor from there.
    q0[robot.coordinates.index("rod.bend_y[2]")] = 4.0
    found = lissom.statics(robot, q0, space_error=False)
    assert found.success, found.message
    assert robot.contact_forces(found.q, 0 * found.q)[5] > 0.1
    lowest = lowest_stiffness(robot, found.q, closing)
    assert abs(lowest) > 1.0
    assert found.stability == ("stable" if lowest > 0.0 else "divergence")
    modes = lissom.modes(robot, found.q)
    assert found.stability == modes.stability
    # The ends of the contact move with the shape: differences see a little of that.
    np.testing.assert_allclose((2 * np.pi * modes.frequency[0]) ** 2, lowest, rtol=0.03)
