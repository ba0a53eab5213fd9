"""Coordinates of a joint in another code, as functions of lissom's, and what this makes of whole robots.

Where lissom has q, v = dq/dt and a = dv/dt, others have a configuration and velocities that are linear in v,
`w = rate(q, v)`, with the accelerations `rate(q, a) + bias(q, v)`. Both functions take complex numbers, so
that their derivatives are exact.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from rotation_vectors import derivative

Array = np.ndarray


def same(q: Array, v: Array) -> Array:
    return v


def nothing(q: Array, v: Array) -> Array:
    return 0.0 * v


@dataclass(frozen=True)
class JointCoordinates:
    size: int
    configuration: Callable[[Array], Array] = field(default=lambda q: q)
    rate: Callable[[Array, Array], Array] = same
    bias: Callable[[Array, Array], Array] = nothing

    def matrix(self, q: Array) -> Array:
        """B of w = B v."""
        return np.array([self.rate(q, unit) for unit in np.eye(self.size)]).T


class Coordinates:
    """Those of all joints of a robot, one after the other."""

    def __init__(self, joints: list[JointCoordinates]) -> None:
        ends = np.cumsum([joint.size for joint in joints])
        self.joints = [(joint, slice(end - joint.size, end)) for joint, end in zip(joints, ends, strict=True)]

    def configuration(self, q: Array) -> Array:
        return np.concatenate([joint.configuration(q[own]) for joint, own in self.joints])

    def rate(self, q: Array, v: Array) -> Array:
        return np.concatenate([joint.rate(q[own], v[own]) for joint, own in self.joints])

    def bias(self, q: Array, v: Array) -> Array:
        return np.concatenate([joint.bias(q[own], v[own]) for joint, own in self.joints])

    def blocks(self, block: Callable[[JointCoordinates, slice], Array]) -> Array:
        """The matrix that has a block for each joint on its diagonal."""
        n = self.joints[-1][1].stop
        matrix = np.zeros((n, n))
        for joint, own in self.joints:
            matrix[own, own] = block(joint, own)
        return matrix

    def matrix(self, q: Array) -> Array:
        """B of w = B v."""
        return self.blocks(lambda joint, own: joint.matrix(q[own]))

    def acceleration(self, q: Array, v: Array, foreign: Array) -> Array:
        """lissom's, of the accelerations in the other code."""
        return np.linalg.solve(self.matrix(q), foreign - self.bias(q, v))

    def tangents(
        self, q: Array, v: Array, a: Array, tau: Array, tangents: tuple[Array, Array, Array]
    ) -> tuple[Array, Array, Array]:
        """lissom's derivatives of inverse dynamics by q, v and a, from those in the other code.

        There `tau` belongs to w, and the derivative by the configuration is one along a displacement B dq:
        the chain rule of tau_lissom = B^T tau(configuration(q), B v, B a + bias).
        """
        by_configuration, by_rate, mass = tangents

        def by_q(function: Callable[[JointCoordinates, slice, Array], Array]) -> Array:
            return self.blocks(lambda joint, own: derivative(lambda x: function(joint, own, x), q[own]))

        B = self.matrix(q)
        force_by_q = by_q(lambda joint, own, x: tau[own] @ joint.matrix(x))
        rate_by_q = by_q(lambda joint, own, x: joint.rate(x, v[own]))
        acceleration_by_q = by_q(lambda joint, own, x: joint.rate(x, a[own]) + joint.bias(x, v[own]))
        bias_by_v = self.blocks(lambda joint, own: derivative(lambda x: joint.bias(q[own], x), v[own]))
        inner = by_configuration @ B + by_rate @ rate_by_q + mass @ acceleration_by_q
        return force_by_q + B.T @ inner, B.T @ (by_rate @ B + mass @ bias_by_v), B.T @ mass @ B
