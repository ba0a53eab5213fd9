"""Twenty-three systems of nonlinear equations for comparing root finders.

The first fourteen are those of Moré, Garbow and Hillstrom (1981), "Testing unconstrained optimization
software", ACM TOMS 7, in the form of MINPACK's tests of HYBRJ. Later additions: two matrix square roots by
Hammarling, the example of Dennis and Schnabel, two singular systems, a cubic with a double root, Freudenstein
and Roth, Boggs, and Chandrasekhar's H-equation. Each problem has its Jacobian and its standard start; as in
MINPACK, factors of 10 and 100 make the start harder.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

FACTORS = (1, 10, 100)


@dataclass(frozen=True)
class Problem:
    name: str
    fun: Callable[[np.ndarray], np.ndarray]
    jac: Callable[[np.ndarray], np.ndarray]
    standard_start: np.ndarray

    def start(self, factor):
        """The standard start times a factor; if the start is zero, all unknowns equal the factor."""
        if factor != 1 and not self.standard_start.any():
            return np.full_like(self.standard_start, factor)
        return factor * self.standard_start


PROBLEMS: list[Problem] = []


def problem(name, start, jac):
    """Registers the decorated residual."""

    def register(fun):
        PROBLEMS.append(Problem(name, fun, jac, np.array(start, dtype=float)))
        return fun

    return register


# 1


def rosenbrock_jac(x):
    jacobian = np.diag(np.full(len(x), 10.0)) - np.diag(20 * x[:-1], -1)
    jacobian[0, 0] = -1
    return jacobian


@problem("Generalized Rosenbrock", [-1.2] + 9 * [1], rosenbrock_jac)
def rosenbrock(x):
    return np.concatenate(([1 - x[0]], 10 * (x[1:] - x[:-1] ** 2)))


# 2


def powell_singular_jac(x):
    a, b = 2 * (x[1] - 2 * x[2]), 2 * np.sqrt(10) * (x[0] - x[3])
    return np.array(
        [[1, 10, 0, 0], [0, 0, np.sqrt(5), -np.sqrt(5)], [0, a, -2 * a, 0], [b, 0, 0, -b]], dtype=float
    )


@problem("Powell singular", [3, -1, 0, 1], powell_singular_jac)
def powell_singular(x):
    return np.array(
        [
            x[0] + 10 * x[1],
            np.sqrt(5) * (x[2] - x[3]),
            (x[1] - 2 * x[2]) ** 2,
            np.sqrt(10) * (x[0] - x[3]) ** 2,
        ]
    )


# 3


def powell_badly_scaled_jac(x):
    return np.array([[1e4 * x[1], 1e4 * x[0]], [-np.exp(-x[0]), -np.exp(-x[1])]])


@problem("Powell badly scaled", [0, 1], powell_badly_scaled_jac)
def powell_badly_scaled(x):
    return np.array([1e4 * x[0] * x[1] - 1, np.exp(-x[0]) + np.exp(-x[1]) - 1.0001])


# 4


def wood_jac(x):
    return np.array(
        [
            [-200 * (x[1] - 3 * x[0] ** 2) + 1, -200 * x[0], 0, 0],
            [-400 * x[0], 220.2, 0, 19.8],
            [0, 0, -180 * (x[3] - 3 * x[2] ** 2) + 1, -180 * x[2]],
            [0, 19.8, -360 * x[2], 200.2],
        ]
    )


@problem("Wood", [-3, -1, -3, -1], wood_jac)
def wood(x):
    a, b = x[1] - x[0] ** 2, x[3] - x[2] ** 2
    return np.array(
        [
            -200 * x[0] * a - (1 - x[0]),
            200 * a + 20.2 * (x[1] - 1) + 19.8 * (x[3] - 1),
            -180 * x[2] * b - (1 - x[2]),
            180 * b + 20.2 * (x[3] - 1) + 19.8 * (x[1] - 1),
        ]
    )


# 5


def helical_valley_jac(x):
    square = x[0] ** 2 + x[1] ** 2
    radius = np.sqrt(square)
    angle = 50 / (np.pi * square)
    return np.array(
        [
            [angle * x[1], -angle * x[0], 10],
            [10 * x[0] / radius, 10 * x[1] / radius, 0],
            [0, 0, 1],
        ]
    )


@problem("Helical valley", [-1, 0, 0], helical_valley_jac)
def helical_valley(x):
    # The angle in turns, with a branch cut along the negative second axis.
    turns = np.arctan2(x[1], x[0]) / (2 * np.pi)
    if turns < -0.25:
        turns += 1
    return np.array([10 * (x[2] - 10 * turns), 10 * (np.hypot(x[0], x[1]) - 1), x[2]])


# 6: a gradient of a sum of squares


def watson_squares(x):
    """The 31 residuals (31,) and their Jacobian (31, n)."""
    t = np.arange(1, 30)[:, None] / 29
    k = np.arange(len(x))
    powers = t**k
    slopes = k * t ** np.maximum(k - 1, 0)
    value = powers @ x
    r = np.concatenate((slopes @ x - value**2 - 1, [x[0], x[1] - x[0] ** 2 - 1]))
    last = np.zeros((2, len(x)))
    last[0, 0] = 1
    last[1, :2] = -2 * x[0], 1
    return r, np.vstack((slopes - 2 * value[:, None] * powers, last)), powers


def watson_jac(x):
    r, jacobian, powers = watson_squares(x)
    hessian = jacobian.T @ jacobian - 2 * powers.T @ (r[:29, None] * powers)
    hessian[0, 0] -= 2 * r[30]
    return hessian


@problem("Watson", 6 * [0], watson_jac)
def watson(x):
    r, jacobian, _ = watson_squares(x)
    return jacobian.T @ r


# 7


def chebyquad_jac(x):
    n = len(x)
    return np.array([chebyshev.chebval(x, chebyshev.chebder(np.eye(n + 1)[i])) for i in range(1, n + 1)]) / n


@problem("Chebyquad", (2 * np.arange(1, 8) - 8) / 8, chebyquad_jac)
def chebyquad(x):
    n = len(x)
    i = np.arange(1, n + 1)
    means = chebyshev.chebvander(x, n)[:, 1:].mean(axis=0)
    integrals = np.where(i % 2 == 0, -1 / np.where(i % 2 == 0, i**2 - 1.0, 1.0), 0.0)
    return means - integrals


# 8


def brown_jac(x):
    n = len(x)
    jacobian = np.ones((n, n)) + np.eye(n)
    jacobian[-1] = [np.prod(np.delete(x, j)) for j in range(n)]
    return jacobian


@problem("Brown almost linear", 10 * [0.5], brown_jac)
def brown(x):
    return np.append(x[:-1] + x.sum() - (len(x) + 1), np.prod(x) - 1)


# 9


def grid(n):
    return np.arange(1, n + 1) / (n + 1)


BOUNDARY_START = grid(10) * (grid(10) - 1)


def boundary_value_jac(x):
    n = len(x)
    h = 1 / (n + 1)
    diagonal = 2 + 1.5 * h**2 * (x + grid(n) + 1) ** 2
    return np.diag(diagonal) - np.eye(n, k=1) - np.eye(n, k=-1)


@problem("Discrete boundary value", BOUNDARY_START, boundary_value_jac)
def boundary_value(x):
    n = len(x)
    h = 1 / (n + 1)
    padded = np.concatenate(([0], x, [0]))
    return 2 * x - padded[:-2] - padded[2:] + h**2 / 2 * (x + grid(n) + 1) ** 3


# 10


def green(n):
    """Green's function of the second derivative on the grid, (n, n)."""
    t, s = grid(n)[:, None], grid(n)[None, :]
    return np.where(s <= t, (1 - t) * s, t * (1 - s))


def integral_equation_jac(x):
    n = len(x)
    return np.eye(n) + 1.5 / (n + 1) * green(n) * (x + grid(n) + 1) ** 2


@problem("Discrete integral equation", BOUNDARY_START, integral_equation_jac)
def integral_equation(x):
    n = len(x)
    return x + green(n) @ (x + grid(n) + 1) ** 3 / (2 * (n + 1))


# 11


def trigonometric_jac(x):
    n = len(x)
    i = np.arange(1, n + 1)
    return np.tile(np.sin(x), (n, 1)) + np.diag(i * np.sin(x) - np.cos(x))


@problem("Trigonometric", 10 * [0.1], trigonometric_jac)
def trigonometric(x):
    n = len(x)
    i = np.arange(1, n + 1)
    return n - np.cos(x).sum() + i * (1 - np.cos(x)) - np.sin(x)


# 12


def variably_dimensioned_jac(x):
    i = np.arange(1, len(x) + 1)
    s = i @ (x - 1)
    return np.eye(len(x)) + (1 + 6 * s**2) * np.outer(i, i)


@problem("Variably dimensioned", 1 - np.arange(1, 11) / 10, variably_dimensioned_jac)
def variably_dimensioned(x):
    i = np.arange(1, len(x) + 1)
    s = i @ (x - 1)
    return x - 1 + i * s * (1 + 2 * s**2)


# 13


def broyden_tridiagonal_jac(x):
    n = len(x)
    return np.diag(3 - 4 * x) - np.eye(n, k=-1) - 2 * np.eye(n, k=1)


@problem("Broyden tridiagonal", 10 * [-1], broyden_tridiagonal_jac)
def broyden_tridiagonal(x):
    padded = np.concatenate(([0], x, [0]))
    return (3 - 2 * x) * x - padded[:-2] - 2 * padded[2:] + 1


# 14


def band(n):
    """Ones from the fifth subdiagonal to the first superdiagonal, except on the diagonal."""
    return np.tri(n, k=1) - np.tri(n, k=-6) - np.eye(n)


def broyden_banded_jac(x):
    return np.diag(2 + 15 * x**2) - band(len(x)) * (1 + 2 * x)


@problem("Broyden banded", 10 * [-1], broyden_banded_jac)
def broyden_banded(x):
    return x * (2 + 5 * x**2) + 1 - band(len(x)) @ (x * (1 + x))


# 15, 16: X^2 = A


def square_root_jac(x):
    n = round(np.sqrt(len(x)))
    matrix = x.reshape(n, n)
    return np.kron(matrix, np.eye(n)) + np.kron(np.eye(n), matrix.T)


@problem("Hammarling 2 x 2 square root", np.eye(2).ravel(), square_root_jac)
def square_root_2(x):
    return (x.reshape(2, 2) @ x.reshape(2, 2) - [[1e-4, 1], [0, 1e-4]]).ravel()


@problem("Hammarling 3 x 3 square root", np.eye(3).ravel(), square_root_jac)
def square_root_3(x):
    return (x.reshape(3, 3) @ x.reshape(3, 3) - [[1e-4, 1, 0], [0, 1e-4, 0], [0, 0, 1e-4]]).ravel()


# 17


def dennis_schnabel_jac(x):
    return np.array([[1, 1], [2 * x[0], 2 * x[1]]])


@problem("Dennis and Schnabel", [1, 5], dennis_schnabel_jac)
def dennis_schnabel(x):
    return np.array([x[0] + x[1] - 3, x[0] ** 2 + x[1] ** 2 - 9])


# 18


def bell(t):
    """(1 - exp(-t^2)) / t and its derivative, for t = 0 by continuity."""
    if t == 0:
        return 0.0, 1.0
    value = -np.expm1(-(t**2)) / t
    return value, 2 * np.exp(-(t**2)) - value / t


def sample_18_jac(x):
    (a, da), (b, db) = bell(x[0]), bell(x[1])
    return np.array([[x[1] ** 2 * da, 2 * x[1] * a], [b, x[0] * db]])


@problem("Sample problem 18", [2, 2], sample_18_jac)
def sample_18(x):
    return np.array([x[1] ** 2 * bell(x[0])[0], x[0] * bell(x[1])[0]])


# 19


def sample_19_jac(x):
    return (x @ x) * np.eye(2) + 2 * np.outer(x, x)


@problem("Sample problem 19", [3, 3], sample_19_jac)
def sample_19(x):
    return x * (x @ x)


# 20


def double_root_jac(x):
    return np.array([[(x[0] - 5) * (3 * x[0] - 5)]])


@problem("Scalar x (x - 5)^2", [1], double_root_jac)
def double_root(x):
    return x * (x - 5) ** 2


# 21


def freudenstein_roth_jac(x):
    return np.array([[1, ((-3 * x[1] + 10) * x[1]) - 2], [1, (3 * x[1] + 2) * x[1] - 14]])


@problem("Freudenstein and Roth", [0.5, -2], freudenstein_roth_jac)
def freudenstein_roth(x):
    return np.array([x[0] - 13 + ((5 - x[1]) * x[1] - 2) * x[1], x[0] - 29 + ((x[1] + 1) * x[1] - 14) * x[1]])


# 22


def boggs_jac(x):
    return np.array([[2 * x[0], -1], [1, np.pi / 2 * np.sin(np.pi / 2 * x[1])]])


@problem("Boggs", [1, 0], boggs_jac)
def boggs(x):
    return np.array([x[0] ** 2 - x[1] + 1, x[0] - np.cos(np.pi / 2 * x[1])])


# 23


def scattering(n, albedo=0.9):
    mu = (np.arange(1, n + 1) - 0.5) / n
    return albedo / (2 * n) * mu[:, None] / (mu[:, None] + mu)


def chandrasekhar_jac(x):
    kernel = scattering(len(x))
    return np.eye(len(x)) - kernel / (1 - kernel @ x)[:, None] ** 2


@problem("Chandrasekhar", 10 * [1], chandrasekhar_jac)
def chandrasekhar(x):
    return x - 1 / (1 - scattering(len(x)) @ x)
