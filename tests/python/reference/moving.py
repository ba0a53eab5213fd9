"""Generalised forces of a rod on a moving base, by d'Alembert's principle in the world frame.

    tau_j = int [rho A (x'' - g) . dx/dq_j + h' . dtheta/dq_j] dX + m (x_tip'' - g) . dx_tip/dq_j + (K q)_j

Positions x and rotations R in the world are those of the base times those of the reference rod. All
derivatives are numerical: in time along a motion (x'', the angular velocity, the rate of the angular momentum
h of the sections), and with respect to the coordinates. There are no moving frames and no velocities along
the rod. The error is about 1e-7.
"""

import numpy as np
from scipy.spatial.transform import Rotation

#: Gauss-Legendre nodes along the segment.
NODES = 9
#: Increments of fourth-order differences: in time (seconds) and in the coordinates.
DT = 2e-3
DQ = 1e-3
FIRST = np.array([1, -8, 0, 8, -1]) / 12.0
SECOND = np.array([-1, 16, -30, 16, -1]) / 12.0


def generalised_forces(rod, base, q, qd, qdd, t, tip_mass=0.0, gravity=(0, 0, 0)):
    """Forces of a reference rod with one segment of constant radius, without loads, with its base at the
    origin.

    `base` is a function of time that returns the rotation matrix and the position of the base.
    """
    [segment] = rod.segments
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    X = np.append(0.5 * segment.length * (nodes + 1.0), segment.length)
    weights = 0.5 * segment.length * weights

    def world(q, t):
        R, p = base(t)
        shape = rod.poses(q, X)
        return R @ shape[:, :3, :3], shape[:, :3, 3] @ R.T + p

    times = DT * np.arange(-4, 5)
    motion = [world(q + qd * s + 0.5 * qdd * s * s, t + s) for s in times]
    rotations, positions = (np.array(part) for part in zip(*motion, strict=True))
    acceleration = np.tensordot(SECOND, positions[2:7], 1) / DT**2 - np.array(gravity)
    area, second_moment, *_ = segment.shape.figure(0.0)
    inertia = segment.density * second_moment * np.diag([2.0, 1.0, 1.0])

    def angular_momentum(k):
        rate = np.tensordot(FIRST, rotations[k - 2 : k + 3], 1) / DT
        omega = axial(rate @ rotations[k].transpose(0, 2, 1))
        return np.einsum("xij,jk,xlk,xl->xi", rotations[k], inertia, rotations[k], omega)

    moment = np.tensordot(FIRST, [angular_momentum(k) for k in range(2, 7)], 1) / DT
    tau = np.zeros(len(q))
    for j, unit in enumerate(np.eye(len(q))):
        moved = [world(q + DQ * k * unit, t) for k in (-2, -1, 0, 1, 2)]
        turned, shifted = (np.tensordot(FIRST, part, 1) / DQ for part in zip(*moved, strict=True))
        turned = axial(turned @ rotations[4].transpose(0, 2, 1))
        density = segment.density * area * np.sum(acceleration * shifted, 1) + np.sum(moment * turned, 1)
        tau[j] = weights @ density[:-1] + tip_mass * acceleration[-1] @ shifted[-1]
    stiffness = np.array(
        [
            sum(
                w * segment.basis(x).T @ segment.stiffness(x) @ segment.basis(x)[:, j]
                for w, x in zip(weights, X, strict=False)
            )
            for j in range(len(q))
        ]
    )
    return tau + stiffness @ q


def axial(skew):
    """Axial vectors of skew-symmetric matrices (m, 3, 3)."""
    return 0.5 * np.stack(
        [skew[:, 2, 1] - skew[:, 1, 2], skew[:, 0, 2] - skew[:, 2, 0], skew[:, 1, 0] - skew[:, 0, 1]], 1
    )


def body_twist(base, t):
    """Body twist of the base and its rate at a time, from nearby poses by fourth-order differences."""
    rotations, positions = (
        np.array(part) for part in zip(*(base(t + DT * k) for k in range(-2, 3)), strict=True)
    )
    to_body = rotations[2].T
    velocity = to_body @ np.tensordot(FIRST, positions, 1) / DT
    acceleration = to_body @ np.tensordot(SECOND, positions, 1) / DT**2
    angular = axial(to_body @ np.tensordot(FIRST, rotations, 1)[None] / DT)[0]
    # R'' = R ([angular rate] + [angular]^2), where the square is symmetric.
    angular_rate = axial(to_body @ np.tensordot(SECOND, rotations, 1)[None] / DT**2)[0]
    eta_t = np.concatenate([angular_rate, acceleration - np.cross(angular, velocity)])
    return np.concatenate([angular, velocity]), eta_t


def pose(translation, rotation_vector):
    """The base as a function of time, from functions of time."""
    return lambda t: (Rotation.from_rotvec(rotation_vector(t)).as_matrix(), np.array(translation(t)))
