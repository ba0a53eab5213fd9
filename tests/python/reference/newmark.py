"""The Newmark family, solved directly from its definition, and by the textbooks' matrices.

Shares no formula with the Rust code, where a step has n unknowns, the accelerations, and everything else is
affine in them. Here a step is the root of all its 4 n equations, by Newton's method with a Jacobian by
central differences. For linear systems there is also the original form of the alpha methods, with forces
averaged over the step, as one matrix.

Sources: Newmark (1959); Hilber, Hughes and Taylor (1977); Chung and Hulbert (1993); Arnold and Bruels (2007);
Zienkiewicz and Xie (1991); Hughes (1987), "The Finite Element Method", chapter 9.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np


@dataclass(frozen=True)
class Parameters:
    beta: float
    gamma: float
    alpha_m: float = 0.0
    alpha_f: float = 0.0


def hht(alpha):
    """Hilber, Hughes and Taylor: alpha in [-1/3, 0]."""
    return Parameters((1 - alpha) ** 2 / 4, (1 - 2 * alpha) / 2, 0.0, -alpha)


def generalised_alpha(rho_inf):
    """Chung and Hulbert's optimal parameters in terms of rho_inf."""
    return Parameters(
        beta=1 / (1 + rho_inf) ** 2,
        gamma=(3 - rho_inf) / (2 + 2 * rho_inf),
        alpha_m=(2 * rho_inf - 1) / (1 + rho_inf),
        alpha_f=rho_inf / (1 + rho_inf),
    )


# The presets with their names and the options of lissom.
PRESETS = {
    "newmark": Parameters(1 / 4, 1 / 2),
    "average_acceleration": Parameters(1 / 4, 1 / 2),
    "linear_acceleration": Parameters(1 / 6, 1 / 2),
    "fox_goodwin": Parameters(1 / 12, 1 / 2),
    "central_difference": Parameters(0.0, 1 / 2),
    "hht": hht(-0.1),
    "generalised_alpha": generalised_alpha(0.8),
}


# --------------------------------------------------------------------------------------------- any equations


def root(equations, z):
    """Newton's method with a new Jacobian by central differences in each iteration, until rounding."""
    size = np.inf
    for _ in range(50):
        steps = 1e-6 * np.maximum(1.0, np.abs(z))
        columns = [
            (equations(z + h * e) - equations(z - h * e)) / (2 * h)
            for h, e in zip(steps, np.eye(z.size), strict=True)
        ]
        increment = np.linalg.solve(np.column_stack(columns), equations(z))
        z = z - increment
        last, size = size, np.max(np.abs(increment) / np.maximum(1.0, np.abs(z)))
        if size == 0.0 or 0.1 * last <= size < 1e-9:
            return z
    raise ArithmeticError("Newton's method did not converge")


def integrate(residual, times, q0, v0, parameters):
    """Displacements, velocities and accelerations at `times`, which must be equidistant for the alpha
    methods.

    Unknowns of a step are q, v, the true accelerations a and the algorithmic ones s at its end.
    """
    p = parameters
    q, v = (np.array(x, dtype=float) for x in (q0, v0))
    a = root(lambda a: np.asarray(residual(times[0], q, v, a)), np.zeros(q.size))
    s = a
    motion = [(q, v, a)]
    for t_old, t in pairwise(times):
        h = t - t_old

        def equations(z, t=t, h=h, q=q, v=v, a=a, s=s):
            q1, v1, a1, s1 = np.split(z, 4)
            return np.concatenate(
                [
                    (q1 - q - h * v) / h**2 - ((0.5 - p.beta) * s + p.beta * s1),
                    (v1 - v) / h - ((1 - p.gamma) * s + p.gamma * s1),
                    (1 - p.alpha_m) * s1 + p.alpha_m * s - (1 - p.alpha_f) * a1 - p.alpha_f * a,
                    np.asarray(residual(t, q1, v1, a1)),
                ]
            )

        q, v, a, s = np.split(root(equations, np.concatenate([q, v, a, s])), 4)
        motion.append((q, v, a))
    return tuple(map(np.array, zip(*motion, strict=True)))


# ------------------------------------------------------------------------------------------ linear equations


def step_matrix(M, C, K, h, parameters):
    """The matrix of a free step of the original methods for (q, v, s),

    (1 - alpha_m) M s1 + alpha_m M s0 + (1 - alpha_f) (C v1 + K q1) + alpha_f (C v0 + K q0) = 0,

    where s is the only acceleration.
    """
    p = parameters
    M, C, K = (np.atleast_2d(x) for x in (M, C, K))
    one, zero = np.eye(len(M)), np.zeros_like(M)
    new = np.block(
        [
            [one, zero, -p.beta * h**2 * one],
            [zero, one, -p.gamma * h * one],
            [(1 - p.alpha_f) * K, (1 - p.alpha_f) * C, (1 - p.alpha_m) * M],
        ]
    )
    old = np.block(
        [
            [one, h * one, (0.5 - p.beta) * h**2 * one],
            [zero, one, (1 - p.gamma) * h * one],
            [-p.alpha_f * K, -p.alpha_f * C, -p.alpha_m * M],
        ]
    )
    return np.linalg.solve(new, old)


def free_linear_motion(M, C, K, q0, v0, h, steps, parameters):
    """Displacements and velocities of M a + C v + K q = 0 by the original methods."""
    n = len(q0)
    step = step_matrix(M, C, K, h, parameters)
    state = np.concatenate([q0, v0, -np.linalg.solve(M, np.dot(C, v0) + np.dot(K, q0))])
    states = [state]
    for _ in range(steps):
        state = step @ state
        states.append(state)
    states = np.array(states)
    return states[:, :n], states[:, n : 2 * n]


# --------------------------------------------------------------------------------------------- error estimate


def estimated_error(motion, beta, gamma, rtol, atol, smallest_velocity_coefficient):
    """Zienkiewicz and Xie: local errors of all steps of Newmark's method in units of the tolerances.

    The acceleration is assumed linear in a step, which gives the third-order Taylor terms; they are compared
    with the method. The coefficient of the velocity's error is at least the last argument.
    """
    h = np.diff(motion.t)[:, None]
    jerk = np.diff(motion.a, axis=0) / h
    q, v = motion.q, motion.v
    taylor, newmark = h**3 * jerk / 6, beta * h**3 * jerk
    displacement = newmark - taylor
    velocity = max(abs(gamma - 1 / 2), smallest_velocity_coefficient) * h**2 * jerk
    ratios = [
        error / (atol + rtol * np.maximum(np.abs(x[1:]), np.abs(x[:-1])))
        for error, x in ((displacement, q), (velocity, v))
    ]
    return np.sqrt(np.mean(np.square(np.hstack(ratios)), axis=1))
