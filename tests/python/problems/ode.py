"""Initial value problems for comparing integrators.

A1 to E5 are the nonstiff problems DETEST of Hull, Enright, Fellen and Sedgwick (1972), "Comparing numerical
methods for ordinary differential equations", SIAM J. Numer. Anal. 9, all from t = 0 to 20. The others are
from SciPy's tests of `solve_ivp`, from Hairer, Norsett and Wanner (1993), "Solving Ordinary Differential
Equations I", and two that are hard at loose tolerances: a right-hand side that hardly damps errors, and one
that jumps.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Problem:
    """y' = fun(t, y), y(t_span[0]) = y0."""

    name: str
    fun: Callable
    t_span: tuple[float, float]
    y0: np.ndarray


PROBLEMS: list[Problem] = []


def problem(name, y0, t_span=(0.0, 20.0)):
    """Registers the decorated right-hand side."""

    def register(fun):
        PROBLEMS.append(Problem(name, fun, t_span, np.array(y0, dtype=float)))
        return fun

    return register


# A: single equations


@problem("A1", [1.0])
def decay(t, y):
    return -y


@problem("A2", [1.0])
def riccati(t, y):
    return -0.5 * y**3


@problem("A3", [1.0])
def oscillating(t, y):
    return y * np.cos(t)


@problem("A4", [1.0])
def logistic(t, y):
    return 0.25 * y * (1.0 - y / 20.0)


@problem("A5", [4.0])
def spiral(t, y):
    return (y - t) / (y + t)


# B: small systems


@problem("B1", [1.0, 3.0])
def predator_and_prey(t, y):
    return np.array([2.0 * (y[0] - y[0] * y[1]), -(y[1] - y[0] * y[1])])


@problem("B2", [2.0, 0.0, 1.0])
def linear_reaction(t, y):
    return np.array([-y[0] + y[1], y[0] - 2.0 * y[1] + y[2], y[1] - y[2]])


@problem("B3", [1.0, 0.0, 0.0])
def nonlinear_reaction(t, y):
    return np.array([-y[0], y[0] - y[1] ** 2, y[1] ** 2])


@problem("B4", [3.0, 0.0, 0.0])
def torus(t, y):
    r = np.hypot(y[0], y[1])
    return np.array([-y[1] - y[0] * y[2] / r, y[0] - y[1] * y[2] / r, y[0] / r])


@problem("B5", [0.0, 1.0, 1.0])
def rigid_body(t, y):
    return np.array([y[1] * y[2], -y[0] * y[2], -0.51 * y[0] * y[1]])


# C: larger systems


def unit(n):
    return np.eye(n)[0]


@problem("C1", unit(10))
def radioactive_chain(t, y):
    rates = np.diff(y, prepend=0.0)
    return np.append(-rates[:-1], y[-2])


@problem("C2", unit(10))
def radioactive_chain_with_growing_rates(t, y):
    loss = np.append(np.arange(1.0, 10.0) * y[:-1], 0.0)
    return np.append(0.0, loss[:-1]) - loss


def conduction(t, y):
    padded = np.concatenate(([0.0], y, [0.0]))
    return padded[:-2] - 2.0 * y + padded[2:]


problem("C3", unit(10))(conduction)
problem("C4", unit(51))(conduction)

# Gravitational constant and masses, relative to the sun's, of the five outer planets.
GRAVITY = 2.95912208286
SUN = 1.00000597682
MASSES = np.array(
    [0.000954786104043, 0.000285583733151, 0.0000437273164546, 0.0000517759138449, 0.00000277777777778]
)
PLANETS = [
    [3.42947415189, 3.35386959711, 1.35494901715],
    [6.64145542550, 5.97156957878, 2.18231499728],
    [11.2630437207, 14.6952576794, 6.27960525067],
    [-30.1552268759, 1.65699966404, 1.43785752721],
    [-21.1238353380, 28.4465098142, 15.3882659679],
]
VELOCITIES = [
    [-0.557160570446, 0.505696783289, 0.230578543901],
    [-0.415570776342, 0.365682722812, 0.169143213293],
    [-0.325325669158, 0.189706021964, 0.0877265322780],
    [-0.0240476254170, -0.287659532608, -0.117219543175],
    [-0.176860753121, -0.216393453025, -0.0148647893090],
]


@problem("C5", np.ravel([PLANETS, VELOCITIES]))
def five_planets(t, y):
    place, velocity = y.reshape(2, 5, 3)
    apart = place - place[:, None]
    cubed = (apart**2).sum(axis=2) ** 1.5
    np.fill_diagonal(cubed, 1.0)
    of_sun = place / ((place**2).sum(axis=1) ** 1.5)[:, None]
    pull = (MASSES[:, None] * (apart / cubed[:, :, None] - of_sun)).sum(axis=1)
    return np.ravel([velocity, GRAVITY * (pull - SUN * of_sun)])


# D: orbits of a planet with the eccentricities 0.1, 0.3, ..., 0.9


def orbit(t, y):
    cubed = np.hypot(y[0], y[1]) ** 3
    return np.array([y[2], y[3], -y[0] / cubed, -y[1] / cubed])


for _number, _e in enumerate([0.1, 0.3, 0.5, 0.7, 0.9], start=1):
    problem(f"D{_number}", [1.0 - _e, 0.0, 0.0, np.sqrt((1.0 + _e) / (1.0 - _e))])(orbit)


# E: equations of second order


@problem("E1", [0.6713967071418030, 0.09540051444747446])
def bessel(t, y):
    return np.array([y[1], -(y[1] / (t + 1.0) + (1.0 - 0.25 / (t + 1.0) ** 2) * y[0])])


@problem("E2", [2.0, 0.0])
def van_der_pol(t, y):
    return np.array([y[1], (1.0 - y[0] ** 2) * y[1] - y[0]])


@problem("E3", [0.0, 0.0])
def duffing(t, y):
    return np.array([y[1], y[0] ** 3 / 6.0 - y[0] + 2.0 * np.sin(2.78535 * t)])


@problem("E4", [30.0, 0.0])
def falling_body(t, y):
    return np.array([y[1], 0.032 - 0.4 * y[1] ** 2])


@problem("E5", [0.0, 0.0])
def pursuit(t, y):
    return np.array([y[1], np.sqrt(1.0 + y[1] ** 2) / (25.0 - t)])


# SciPy's tests


@problem("rational", [1 / 3, 2 / 9], (5.0, 9.0))
def rational(t, y):
    return np.array([y[1] / t, y[1] * (y[0] + 2.0 * y[1] - 1.0) / (t * (y[0] - 1.0))])


@problem("rational, backward", [1 / 3, 2 / 9], (5.0, 1.0))
def rational_backward(t, y):
    return rational(t, y)


@problem("linear", [0.0, 2.0], (0.0, 2.0))
def linear(t, y):
    return np.array([-y[0] - 5.0 * y[1], y[0] + y[1]])


# Hairer, Norsett and Wanner


@problem("Brusselator", [1.5, 3.0])
def brusselator(t, y):
    return np.array([1.0 + y[0] ** 2 * y[1] - 4.0 * y[0], 3.0 * y[0] - y[0] ** 2 * y[1]])


@problem("Lorenz", [-8.0, 8.0, 27.0], (0.0, 4.0))
def lorenz(t, y):
    return np.array([10.0 * (y[1] - y[0]), 28.0 * y[0] - y[1] - y[0] * y[2], y[0] * y[1] - 8.0 / 3.0 * y[2]])


@problem("rope", np.zeros(40), (0.0, 3.723))
def rope(t, y):
    """A hanging chain of 20 links at small angles, pushed at a link (after HNW, eq. II.10.24)."""
    angle, rate = y.reshape(2, 20)
    tension = np.arange(20.0, 0.0, -1.0)
    force = tension * angle
    stretch = np.diff(force, prepend=0.0, append=0.0)
    push = np.zeros(20)
    push[13] = 1.0 / np.cosh(4.0 * t - 2.5) ** 4
    return np.ravel([rate, 20.0 * np.diff(stretch) - np.sin(angle) + 20.0 * push])


# Hard at loose tolerances


@problem("neutral", [0.2], (0.0, 300.0))
def neutral(t, y):
    return y**2 * np.cos(t + y)


@problem("relay", [1.0, 0.0])
def relay(t, y):
    return np.array([y[1], -np.where(y[0] > 0.0, 1.0, -0.5)])
