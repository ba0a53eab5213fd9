"""Rotation vectors phi and what they make of rates, from their power series alone.

Every function takes complex numbers too, so that an imaginary step of 1e-30 gives its derivative to rounding
(Squire and Trapp 1998).
"""

from collections.abc import Callable
from math import factorial

import numpy as np

IMAGINARY_STEP = 1e-30
# Of the series; at |phi| = pi the first that is left out is below 1e-25.
TERMS = 20


def series(s: complex, start: int) -> complex:
    """The sum of (-s)^k / (2 k + start)!: sin(x) / x for start 1 and s = x^2."""
    return sum((-s) ** k / factorial(2 * k + start) for k in range(TERMS))


def derivative_of_series(s: complex, start: int) -> complex:
    return sum(-k * (-s) ** (k - 1) / factorial(2 * k + start) for k in range(1, TERMS))


def rotated(phi: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """exp(phi) times the vector."""
    s, once = phi @ phi, np.cross(phi, vector)
    return vector + series(s, 1) * once + series(s, 2) * np.cross(phi, once)


def quaternion(phi: np.ndarray) -> np.ndarray:
    """Of exp(phi): w, x, y, z."""
    half = 0.5 * phi
    return np.array([series(half @ half, 0), *(series(half @ half, 1) * half)])


def angular_velocity(phi: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """In the axes that turn, for the rate of the rotation vector; linear in it."""
    s, once = phi @ phi, np.cross(phi, rate)
    return rate - series(s, 2) * once + series(s, 3) * np.cross(phi, once)


def angular_acceleration_at_constant_rate(phi: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """What the angular velocity changes by while the rotation vector changes at a constant rate."""
    s, change, once = phi @ phi, 2.0 * (phi @ rate), np.cross(phi, rate)
    return (
        -change * derivative_of_series(s, 2) * once
        + change * derivative_of_series(s, 3) * np.cross(phi, once)
        + series(s, 3) * np.cross(rate, once)
    )


def derivative(function: Callable[[np.ndarray], np.ndarray], at: np.ndarray) -> np.ndarray:
    """Of a vector by a vector, one column for each component of `at`."""
    steps = 1j * IMAGINARY_STEP * np.eye(at.size)
    return np.array([np.imag(function(at + step)) / IMAGINARY_STEP for step in steps]).T
