"""Joints: pose of the base of a link in the joint's frame, and its body twist.

    R = R(q), p = p(q),   [angular; linear] = S(q) v in the axes of the base,   its rate S a + (dS/dt) v

Every formula is analytic in q, so that dS/dt is a complex step along v, exact to rounding (Squire and Trapp
1998). Rotation vectors: R = exp(phi^) by the quaternion of half the angle, angular velocity T(phi) phi_t with

    T(phi) = int_0^1 exp(-s phi^) ds

by a Gauss rule. No series, no special case at zero.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss

from reference.rod import hat

#: Length of a complex step; nothing is subtracted, so it only must be negligible when squared.
STEP = 1e-30
#: Nodes and weights on (0, 1): the rule is exact to rounding up to two turns.
NODES, WEIGHTS = np.add(leggauss(14), [[1], [0]]) / 2


def unit(axis):
    return np.asarray(axis, float) / np.linalg.norm(axis)


def exp(phi):
    """The rotation matrix of a rotation vector."""
    half = np.sqrt(phi @ phi) / 2
    scalar, vector = np.cos(half), hat(np.sinc(half / np.pi) * phi / 2)
    return np.eye(3) + 2 * scalar * vector + 2 * vector @ vector


def tangent(phi):
    """T(phi), (3, 3): the angular velocity in the turned axes is T(phi) phi_t."""
    return sum(weight * exp(-s * phi) for s, weight in zip(NODES, WEIGHTS, strict=True))


def along(function, q, v):
    """The derivative of an analytic function of q in the direction v."""
    return np.imag(function(q + 1j * STEP * np.asarray(v))) / STEP


def turns_alike(phi, phi_t, phi_tt):
    """The equivalent rotation vector of length up to 2 pi, with its rates."""
    size = np.linalg.norm(phi)
    other = (1 - 2 * np.pi / size) * phi
    omega = tangent(phi) @ phi_t
    omega_t = tangent(phi) @ phi_tt + along(tangent, phi, phi_t) @ phi_t
    other_t = np.linalg.solve(tangent(other), omega)
    other_tt = np.linalg.solve(tangent(other), omega_t - along(tangent, other, other_t) @ other_t)
    return other, other_t, other_tt


class Joint:
    """Common properties of joints; by itself a joint without coordinates."""

    n = 0
    #: Slice of the coordinates that form a rotation vector.
    rotation_vector = slice(0, 0)
    # Only joints with one coordinate have these.
    stiffness = rest = damping = armature = 0.0

    def motion(self, q):
        """R (3, 3) and p (3,) of the base in the joint's frame."""
        return np.eye(3), np.zeros(3)

    def jacobian(self, q):
        """S, (6, n)."""
        return np.zeros((6, 0))

    def twist(self, q, v, a):
        """Body twist of the base relative to the joint's frame, (6,), and its rates for a (n, m), (6, m)."""
        S = self.jacobian(q)
        return S @ v, S @ a + (along(self.jacobian, q, v) @ v)[:, None]

    def force(self, q, v, a):
        """Generalised forces required by spring, damper and armature, (n, m)."""
        return (self.stiffness * (q - self.rest) + self.damping * v)[:, None] + self.armature * a

    def wrapped(self, q, v, a):
        """The same motion with a rotation vector of at most pi."""
        phi = self.rotation_vector
        if np.linalg.norm(q[phi]) > np.pi:
            q, v, a = np.array([q, v, a])
            q[phi], v[phi], a[phi] = turns_alike(q[phi], v[phi], a[phi])
        return q, v, a


def screw(angular=(0, 0, 0), linear=(0, 0, 0)):
    return np.concatenate([angular, linear])


@dataclass(frozen=True)
class Weld(Joint):
    pass


@dataclass(frozen=True)
class Revolute(Joint):
    axis: Sequence[float]
    stiffness: float = 0.0
    rest: float = 0.0
    damping: float = 0.0
    armature: float = 0.0
    n = 1

    def motion(self, q):
        return exp(q[0] * unit(self.axis)), np.zeros(3)

    def jacobian(self, q):
        return screw(angular=unit(self.axis))[:, None]


@dataclass(frozen=True)
class Prismatic(Joint):
    axis: Sequence[float]
    stiffness: float = 0.0
    rest: float = 0.0
    damping: float = 0.0
    armature: float = 0.0
    n = 1

    def motion(self, q):
        return np.eye(3), q[0] * unit(self.axis)

    def jacobian(self, q):
        return screw(linear=unit(self.axis))[:, None]


@dataclass(frozen=True)
class Screw(Joint):
    axis: Sequence[float]
    lead: float
    stiffness: float = 0.0
    rest: float = 0.0
    damping: float = 0.0
    armature: float = 0.0
    n = 1

    def motion(self, q):
        return exp(q[0] * unit(self.axis)), self.lead * q[0] / (2 * np.pi) * unit(self.axis)

    def jacobian(self, q):
        axis = unit(self.axis)
        return screw(angular=axis, linear=self.lead / (2 * np.pi) * axis)[:, None]


@dataclass(frozen=True)
class Cylindrical(Joint):
    axis: Sequence[float]
    n = 2

    def motion(self, q):
        return exp(q[1] * unit(self.axis)), q[0] * unit(self.axis)

    def jacobian(self, q):
        return np.column_stack([screw(linear=unit(self.axis)), screw(angular=unit(self.axis))])


@dataclass(frozen=True)
class Universal(Joint):
    axis1: Sequence[float]
    axis2: Sequence[float]
    n = 2

    def motion(self, q):
        return exp(q[0] * unit(self.axis1)) @ exp(q[1] * unit(self.axis2)), np.zeros(3)

    def jacobian(self, q):
        first = exp(-q[1] * unit(self.axis2)) @ unit(self.axis1)
        return np.column_stack([screw(angular=first), screw(angular=unit(self.axis2))])


@dataclass(frozen=True)
class Planar(Joint):
    normal: Sequence[float]
    n = 3

    @property
    def axes(self):
        """Two axes perpendicular to the normal, (2, 3)."""
        normal = unit(self.normal)
        x, y = np.eye(3)[:2]
        across = y if np.allclose(np.cross(normal, x), 0, atol=1e-9) else x
        first = unit(across - (across @ normal) * normal)
        return np.array([first, np.cross(normal, first)])

    def motion(self, q):
        return exp(q[2] * unit(self.normal)), q[:2] @ self.axes

    def jacobian(self, q):
        first, second = self.axes @ exp(q[2] * unit(self.normal))
        return np.column_stack([screw(linear=first), screw(linear=second), screw(angular=unit(self.normal))])


@dataclass(frozen=True)
class Spherical(Joint):
    n = 3
    rotation_vector = slice(0, 3)

    def motion(self, q):
        return exp(q), np.zeros(3)

    def jacobian(self, q):
        T = tangent(q)
        return np.concatenate([T, np.zeros_like(T)])


@dataclass(frozen=True)
class Free(Joint):
    n = 6
    rotation_vector = slice(3, 6)

    def motion(self, q):
        return exp(q[3:]), q[:3]

    def jacobian(self, q):
        zero = np.zeros((3, 3))
        return np.block([[zero, tangent(q[3:])], [exp(q[3:]).T, zero]])
