"""The spring pendulum in Cartesian coordinates: Newton's law for the mass, projected by virtual work.

Shares no formula with the Rust code: positions come from the map (angle, elongation) -> (x, y), its first
and second derivatives from complex steps and central differences, forces from springs and weights.
"""

import numpy as np


def position(q, length):
    """Position of the mass: (x, y), for real or complex q = (angle, elongation)."""
    return (length + q[1]) * np.array([np.cos(q[0]), np.sin(q[0])])


def jacobian(q, length):
    """d(x, y)/dq by complex steps: exact to rounding."""
    step = 1e-30
    return np.column_stack([position(q + 1j * step * e, length).imag / step for e in np.eye(2)])


def acceleration(q, qd, qdd, length):
    """Acceleration of the mass in the plane: J qdd + (dJ/dt) qd."""
    step = 1e-5
    jacobian_rate = (jacobian(q + step * qd, length) - jacobian(q - step * qd, length)) / (2 * step)
    return jacobian(q, length) @ qdd + jacobian_rate @ qd


def inverse_dynamics(q, qd, qdd, length=1.0, mass=1.0, stiffness=10.0, gravity=9.81):
    """Generalised forces required by a motion, by virtual work of the applied forces."""
    q, qd, qdd = (np.asarray(x, dtype=float) for x in (q, qd, qdd))
    place = position(q, length)
    distance = length + q[1]
    spring = -stiffness * (distance - length) * place / distance
    weight = np.array([0.0, -mass * gravity])
    return jacobian(q, length).T @ (mass * acceleration(q, qd, qdd, length) - spring - weight)


def energy(q, qd, length=1.0, mass=1.0, stiffness=10.0, gravity=9.81):
    """(kinetic, elastic, gravitational) in joules."""
    q, qd = (np.asarray(x, dtype=float) for x in (q, qd))
    velocity = jacobian(q, length) @ qd
    elongation = np.linalg.norm(position(q, length)) - length
    return (
        0.5 * mass * velocity @ velocity,
        0.5 * stiffness * elongation**2,
        mass * gravity * position(q, length)[1],
    )
