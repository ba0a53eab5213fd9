"""Order conditions, a plain fixed-step integrator, and the problems of the literature.

Sources: Hairer, Norsett, Wanner (1993), "Solving Ordinary Differential Equations I" (HNW); Hairer, Wanner
(1996), "Solving Ordinary Differential Equations II" (HW).
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import prod

import numpy as np
from scipy.special import ellipj

# ----------------------------------------------------------------------------------------- order conditions


@lru_cache
def rooted_trees(order):
    """All rooted trees with `order` vertices, each as the sorted tuple of the root's subtrees (HNW, II.2)."""
    if order == 1:
        return ((),)
    trees = set()
    for largest in range(1, order):
        for branch in rooted_trees(largest):
            for rest in rooted_trees(order - largest):
                trees.add(tuple(sorted((branch, *rest))))
    return tuple(sorted(trees))


def order_of(tree):
    return 1 + sum(map(order_of, tree))


def density(tree):
    """gamma(t): the product of the orders of all subtrees, the tree itself included."""
    return order_of(tree) * prod(map(density, tree))


def stage_weights(tree, a):
    """Phi_i(t) for all stages i: the order condition of the tree is sum_i b_i Phi_i(t) = 1 / gamma(t)."""
    stages = range(len(a))
    result = [a[0][0] * 0 + 1 for _ in stages]
    for branch, multiplicity in Counter(tree).items():
        inner = stage_weights(branch, a)
        sums = [sum((a[i][j] * inner[j] for j in stages), start=a[0][0] * 0) for i in stages]
        result = [value * factor**multiplicity for value, factor in zip(result, sums, strict=True)]
    return result


def order_condition_residual(tree, a, b):
    weights = stage_weights(tree, a)
    return sum(b_i * phi for b_i, phi in zip(b, weights, strict=True)) - Fraction(1, density(tree))


# -------------------------------------------------------------------------------------- Dormand-Prince 5(4)


def _fractions(text):
    return [Fraction(word) for word in text.split()]


# HNW, table II.5.2, written with seven stages: the last row is b.
DORMAND_PRINCE_A = [
    _fractions("0 0 0 0 0 0 0"),
    _fractions("1/5 0 0 0 0 0 0"),
    _fractions("3/40 9/40 0 0 0 0 0"),
    _fractions("44/45 -56/15 32/9 0 0 0 0"),
    _fractions("19372/6561 -25360/2187 64448/6561 -212/729 0 0 0"),
    _fractions("9017/3168 -355/33 46732/5247 49/176 -5103/18656 0 0"),
    _fractions("35/384 0 500/1113 125/192 -2187/6784 11/84 0"),
]
DORMAND_PRINCE_B = DORMAND_PRINCE_A[-1]
DORMAND_PRINCE_B_EMBEDDED = _fractions("5179/57600 0 7571/16695 393/640 -92097/339200 187/2100 1/40")
DORMAND_PRINCE_C = _fractions("0 1/5 3/10 4/5 8/9 1 1")


def quadrature(weights, power, h):
    """One step from 0 of size h on y' = t^power, y(0) = 0."""
    return h * sum(w * (c * h) ** power for w, c in zip(weights, DORMAND_PRINCE_C, strict=True))


def dormand_prince(fun, t_span, y0, steps):
    """Fixed-step integration; the state at the end."""
    t, end = t_span
    h = (end - t) / steps
    y = np.array(y0, dtype=float)
    a = np.array(DORMAND_PRINCE_A, dtype=float)
    c = np.array(DORMAND_PRINCE_C, dtype=float)
    for _ in range(steps):
        k = []
        for i in range(6):
            k.append(np.asarray(fun(t + c[i] * h, y + h * sum(a[i, j] * k[j] for j in range(i)))))
        y = y + h * sum(a[6, j] * k[j] for j in range(6))
        t += h
    return y


# ------------------------------------------------------------------------------------------------- problems


@dataclass(frozen=True)
class Problem:
    """y' = fun(t, y), y(t_span[0]) = y0; `exact` is the solution as a function of time, if it is known."""

    name: str
    fun: Callable
    t_span: tuple
    y0: np.ndarray
    exact: Callable | None = None


def spring_pendulum():
    """Cartesian; m = 1, k = 40, rest length 1."""

    def fun(t, y):
        x, z, vx, vz = y
        r = np.hypot(x, z)
        tension = -40.0 * (r - 1.0) / r
        return np.array([vx, vz, tension * x, tension * z - 9.81])

    return Problem("spring pendulum", fun, (0.0, 10.0), np.array([1.1, 0.0, 0.0, 0.0]))


def pleiades():
    """Seven stars in a plane (HNW, II.10)."""
    masses = np.arange(1.0, 8.0)

    def fun(t, y):
        x, z, vx, vz = y.reshape(4, 7)
        dx, dz = x - x[:, None], z - z[:, None]
        cubed = (dx * dx + dz * dz) ** 1.5
        np.fill_diagonal(cubed, 1.0)
        return np.concatenate([vx, vz, (masses * dx / cubed).sum(axis=1), (masses * dz / cubed).sum(axis=1)])

    x = [3, 3, -1, -3, 2, -2, 2]
    z = [3, -3, 2, 0, 0, -4, 4]
    vx = [0, 0, 0, 0, 0, 1.75, -1.5]
    vz = [0, 0, 0, -1.25, 1, 0, 0]
    return Problem("Pleiades", fun, (0.0, 3.0), np.array([*x, *z, *vx, *vz], dtype=float))


def arenstorf():
    """A periodic orbit of the restricted three-body problem (HNW, II.0)."""
    mu = 0.012277471
    mu_1 = 1.0 - mu

    def fun(t, y):
        x, z, vx, vz = y
        d = ((x + mu) ** 2 + z * z) ** 1.5
        d_1 = ((x - mu_1) ** 2 + z * z) ** 1.5
        return np.array(
            [
                vx,
                vz,
                x + 2.0 * vz - mu_1 * (x + mu) / d - mu * (x - mu_1) / d_1,
                z - 2.0 * vx - mu_1 * z / d - mu * z / d_1,
            ]
        )

    y0 = np.array([0.994, 0.0, 0.0, -2.00158510637908252240537862224])
    # The period: the orbit ends at its start.
    return Problem("Arenstorf", fun, (0.0, 17.0652165601579625588917206249), y0)


def rigid_body():
    """Euler's equations without moments, principal moments 1/2, 2, 3; exact by elliptic functions."""

    def fun(t, y):
        return np.array([-2.0 * y[1] * y[2], 1.25 * y[0] * y[2], -0.5 * y[0] * y[1]])

    def exact(t):
        # y = (a cn, b sn, c dn)(p t) with a p = 2 b c, b p = 1.25 a c, c m p = 0.5 a b.
        a, c = 1.0, 0.9
        p = c * np.sqrt(2.0 * 1.25)
        b = a * p / (2.0 * c)
        m = 0.5 * a * b / (c * p)
        sn, cn, dn, _ = ellipj(p * t, m)
        return np.array([a * cn, b * sn, c * dn])

    return Problem("rigid body", fun, (0.0, 20.0), np.array([1.0, 0.0, 0.9]), exact)


def pendulum():
    """theta'' = -sin theta with amplitude 2, from the lowest point; exact by elliptic functions."""
    k = np.sin(1.0)

    def fun(t, y):
        return np.array([y[1], -np.sin(y[0])])

    def exact(t):
        sn, cn, _, _ = ellipj(t, k * k)
        return np.array([2.0 * np.arcsin(k * sn), 2.0 * k * cn])

    return Problem("pendulum", fun, (0.0, 10.0), np.array([0.0, 2.0 * k]), exact)


def van_der_pol(mu=1000.0):
    """The oscillator in the time of HW, IV.1 (the relaxation oscillation has period about 0.8 mu)."""

    def fun(t, y):
        return np.array([y[1], mu * (1.0 - y[0] ** 2) * y[1] - y[0]])

    return Problem("Van der Pol", fun, (0.0, 2.0 * mu), np.array([2.0, 0.0]))


def van_der_pol_jacobian(t, y, mu=1000.0):
    return np.array([[0.0, 1.0], [-2.0 * mu * y[0] * y[1] - 1.0, mu * (1.0 - y[0] ** 2)]])


def robertson():
    """Three chemical reactions (HW, IV.1)."""

    def fun(t, y):
        slow, fast, merge = 0.04 * y[0], 3e7 * y[1] ** 2, 1e4 * y[1] * y[2]
        return np.array([-slow + merge, slow - merge - fast, fast])

    return Problem("Robertson", fun, (0.0, 1e5), np.array([1.0, 0.0, 0.0]))


def robertson_jacobian(t, y):
    a, b, c = 1e4 * y[2], 1e4 * y[1], 6e7 * y[1]
    return np.array([[-0.04, a, b], [0.04, -a - c, -b], [0.0, c, 0.0]])
