"""lissom's laws of contact and damping, as PyElastica's interfaces for contacts and dampers want them.

PyElastica's own contact of two rods has no friction, and its own dampers also slow a rod that falls.
"""

import elastica
import numpy as np
from elastica.dissipation import DamperBase
from numba import njit
from pile_scene import (
    AREA,
    DENSITY,
    DISSIPATION,
    FRICTION,
    RADIUS,
    RETARDATION_TIME,
    SECOND_MOMENT,
    SHEAR_MODULUS,
    SLIP_VELOCITY,
    STIFFNESS,
    YOUNG_MODULUS,
)

# What the surface of a cylinder that rolls and slides weighs per metre: 1/m + r^2/J with J = m r^2/2.
SURFACE_MASS = DENSITY * AREA / 3.0
# Damped couples of bending about two axes and of torsion, N m^2 s.
VISCOSITY = RETARDATION_TIME * np.array(
    [YOUNG_MODULUS * SECOND_MOMENT, YOUNG_MODULUS * SECOND_MOMENT, 2.0 * SHEAR_MODULUS * SECOND_MOMENT]
)


@njit(cache=True)
def force_on(normal, depth, velocity, stiffness, surface_mass, step):
    """Of a contact, by the normal towards it and the velocity of its surface past the other one.

    Within a step friction must not turn the velocity around: an explicit step could not stick otherwise.
    """
    approach = -(normal[0] * velocity[0] + normal[1] * velocity[1] + normal[2] * velocity[2])
    push = stiffness * depth * max(0.0, 1.0 + DISSIPATION * approach)
    sliding = velocity + approach * normal
    speed = np.sqrt(sliding[0] ** 2 + sliding[1] ** 2 + sliding[2] ** 2 + SLIP_VELOCITY**2)
    return push * normal - min(FRICTION * push / speed, surface_mass / step) * sliding


@njit(cache=True)
def cross(a, b):
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


@njit(cache=True)
def surface_velocity(along, arm, element, velocities, omegas, directors):
    """At an arm from the place `along` an element, from 0 to 1."""
    omega = directors[:, :, element].T @ omegas[:, element]
    return (1.0 - along) * velocities[:, element] + along * velocities[:, element + 1] + cross(omega, arm)


@njit(cache=True)
def apply_force(force, along, arm, element, forces, torques, directors):
    forces[:, element] += (1.0 - along) * force
    forces[:, element + 1] += along * force
    torques[:, element] += directors[:, :, element] @ cross(arm, force)


@njit(cache=True)
def touch_wall(origin, normal, step, x, v, w, q, lengths, forces, torques):
    for i in range(lengths.shape[0]):
        gap = 0.0
        for axis in range(3):
            gap += normal[axis] * (0.5 * (x[axis, i] + x[axis, i + 1]) - origin[axis])
        if gap >= RADIUS:
            continue
        arm = -RADIUS * normal
        force = force_on(
            normal,
            RADIUS - gap,
            surface_velocity(0.5, arm, i, v, w, q),
            STIFFNESS * lengths[i],
            SURFACE_MASS * lengths[i],
            step,
        )
        apply_force(force, 0.5, arm, i, forces, torques, q)


@njit(cache=True)
def far(x, y):
    """Whether boxes around the rods do not touch."""
    for axis in range(3):
        if x[axis].min() > y[axis].max() + 2.0 * RADIUS or y[axis].min() > x[axis].max() + 2.0 * RADIUS:
            return True
    return False


@njit(cache=True)
def touch_rod(step, x1, v1, w1, q1, lengths, forces1, torques1, x2, v2, w2, q2, forces2, torques2):
    """The force on each element of the first rod, from the nearest place of the second rod."""
    if far(x1, x2):
        return
    for i in range(lengths.shape[0]):
        place = 0.5 * (x1[:, i] + x1[:, i + 1])
        nearest, element, along = 4.0 * RADIUS**2, -1, 0.0
        for j in range(x2.shape[1] - 1):
            dot, square = 0.0, 0.0
            for axis in range(3):
                edge = x2[axis, j + 1] - x2[axis, j]
                dot += edge * (place[axis] - x2[axis, j])
                square += edge * edge
            share = min(1.0, max(0.0, dot / square))
            distance = 0.0
            for axis in range(3):
                edge = x2[axis, j + 1] - x2[axis, j]
                distance += (place[axis] - x2[axis, j] - share * edge) ** 2
            if distance < nearest:
                nearest, element, along = distance, j, share
        if element < 0:
            continue
        other = (1.0 - along) * x2[:, element] + along * x2[:, element + 1]
        distance = np.sqrt(nearest)
        normal = (place - other) / distance
        arm = -0.5 * distance * normal
        velocity = surface_velocity(0.5, arm, i, v1, w1, q1) - surface_velocity(
            along, -arm, element, v2, w2, q2
        )
        force = force_on(
            normal,
            2.0 * RADIUS - distance,
            velocity,
            0.5 * STIFFNESS * lengths[i],
            0.5 * SURFACE_MASS * lengths[i],
            step,
        )
        apply_force(force, 0.5, arm, i, forces1, torques1, q1)
        apply_force(-force, along, -arm, element, forces2, torques2, q2)


class WallContact(elastica.NoContact):
    def __init__(self, step: float) -> None:
        super().__init__()
        self._step = step

    @property
    def _allowed_system_two(self) -> list[type]:
        return [elastica.Plane]

    def apply_contact(self, system_one, system_two, time: float = 0.0) -> None:
        touch_wall(
            system_two.origin[:, 0],
            system_two.normal,
            self._step,
            system_one.position_collection,
            system_one.velocity_collection,
            system_one.omega_collection,
            system_one.director_collection,
            system_one.rest_lengths,
            system_one.external_forces,
            system_one.external_torques,
        )


class RodContact(elastica.NoContact):
    def __init__(self, step: float) -> None:
        super().__init__()
        self._step = step

    def apply_contact(self, system_one, system_two, time: float = 0.0) -> None:
        touch_rod(
            self._step,
            system_one.position_collection,
            system_one.velocity_collection,
            system_one.omega_collection,
            system_one.director_collection,
            system_one.rest_lengths,
            system_one.external_forces,
            system_one.external_torques,
            system_two.position_collection,
            system_two.velocity_collection,
            system_two.omega_collection,
            system_two.director_collection,
            system_two.external_forces,
            system_two.external_torques,
        )


@njit(cache=True)
def damp(step, omegas, directors, inertia, spacings):
    """Angular velocities after an implicit step of viscous couples between neighbouring elements.

    In the axes of the world, where elements that turn together have the same angular velocity: a block
    tridiagonal system, eliminated from the first element to the last and solved backwards.
    """
    count = omegas.shape[1]
    turning = np.empty((count, 3))
    viscous = np.empty((count, 3, 3))
    blocks = np.empty((count, 3, 3))
    for i in range(count):
        q = np.ascontiguousarray(directors[:, :, i])
        mass = q.T @ np.ascontiguousarray(inertia[:, :, i]) @ q
        turning[i] = mass @ (q.T @ np.ascontiguousarray(omegas[:, i]))
        blocks[i] = mass
        if i < count - 1:
            viscous[i] = q.T @ np.diag(step / spacings[i] * VISCOSITY) @ q
    for i in range(count):
        if i < count - 1:
            blocks[i] += viscous[i]
        if i > 0:
            factor = np.linalg.solve(blocks[i - 1], viscous[i - 1])
            blocks[i] += viscous[i - 1] - viscous[i - 1] @ factor
            turning[i] += viscous[i - 1] @ np.linalg.solve(blocks[i - 1], turning[i - 1])
    for i in range(count - 1, -1, -1):
        right = turning[i]
        if i < count - 1:
            right = right + viscous[i] @ turning[i + 1]
        turning[i] = np.linalg.solve(blocks[i], right)
        omegas[:, i] = np.ascontiguousarray(directors[:, :, i]) @ turning[i]


class RetardedCouples(DamperBase):
    """Kelvin and Voigt's law for bending and torsion."""

    def __init__(self, step: float, **options) -> None:
        super().__init__(**options)
        self._step = step

    def dampen_rates(self, system, time: float) -> None:
        damp(
            self._step,
            system.omega_collection,
            system.director_collection,
            system.mass_second_moment_of_inertia,
            system.rest_voronoi_lengths,
        )
