"""Reference values of spatial rods and of vibrating beams, with NumPy alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from .exact import DIFFERENCE, MOST_STEPS, Array, State, bisect, chebyshev

#: Number of Runge-Kutta steps along a rod.
STEPS_ALONG = 120

#: Matrices hat(e) of the axes, as rows: hat(v) w = v x w.
HATS = np.cross(np.eye(3)[:, None], np.eye(3)[None]).transpose(0, 2, 1).reshape(3, 9)


def pushed_rod(
    length: float,
    stiffness: Sequence[float],
    curvature: Sequence[float],
    force: Sequence[float],
    moment: Sequence[float],
    *,
    follows: bool = False,
) -> Array:
    """Centre line, shape (points, 3), of a clamped rod under a dead force and a moment at its tip.

    The moment is fixed in space, or turns with the tip if it ``follows``. ``stiffness`` contains (torsion,
    bend_y, bend_z, stretch, shear_y, shear_z). Shooting for the moment at the clamp, by Runge-Kutta steps.
    """
    bending, straining = np.array(stiffness[:3]), np.array(stiffness[3:])
    unloaded, n, wanted = np.array(curvature), np.array(force), np.array(moment)
    h = length / STEPS_ALONG

    def slopes(state: State) -> State:
        _, R, m = state
        kappa = unloaded + (m[:, None] @ R)[:, 0] / bending
        nu = np.array([1.0, 0.0, 0.0]) + (n @ R) / straining
        dr = (R @ nu[:, :, None])[..., 0]
        # R' = R hat(kappa); the moment changes by -dr x n = n x dr = hat(n) dr.
        return dr, R @ (kappa @ HATS).reshape(-1, 3, 3), dr @ (n @ HATS).reshape(3, 3).T

    def moved(state: State, step: float, slope: State) -> State:
        r, R, m = (y + step * k for y, k in zip(state, slope, strict=True))
        return r, R, m

    def shoot(moments: Array) -> tuple[Array, Array]:
        count = len(moments)
        state: State = (np.zeros((count, 3)), np.tile(np.eye(3), (count, 1, 1)), moments)
        line = [state[0]]
        for _ in range(STEPS_ALONG):
            k1 = slopes(state)
            k2 = slopes(moved(state, 0.5 * h, k1))
            k3 = slopes(moved(state, 0.5 * h, k2))
            k4 = slopes(moved(state, h, k3))
            for k, weight in ((k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)):
                state = moved(state, h * weight / 6.0, k)
            line.append(state[0])
        _, R, m = state
        applied = np.einsum("kij,j->ki", R, wanted) if follows else wanted
        return np.array(line), m - applied

    found = np.zeros(3)
    for part in (0.5, 1.0):
        n, wanted = part * np.array(force), part * np.array(moment)
        for _ in range(MOST_STEPS):
            size = DIFFERENCE * max(1.0, float(np.abs(found).max()))
            _, left = shoot(found + size * np.vstack([np.zeros(3), np.eye(3)]))
            change = -np.linalg.solve((left[1:] - left[0]).T / size, left[0])
            found = found + change
            if np.abs(change).max() <= 1e-10 * max(1.0, float(np.abs(found).max())):
                break
        else:
            raise ArithmeticError("shooting has not converged")
    return shoot(found[None])[0][:, 0]


def twisted_under_tension(tension: float) -> float:
    """Critical M L / (E I) of a rod between clamps, one of which slides, under the tension T L^2 / (E I).

    E I psi'''' - i M psi''' - T psi'' = 0 for the complex deflection psi = y + i z (Love 1927, section 272);
    with a = M L / (2 E I) and b^2 = a^2 - T L^2 / (E I) the condition is 2 b (cos b - cos a) = T sin b.
    """

    def equation(a: float) -> float:
        b = np.sqrt(a**2 - tension)
        return float(2.0 * b * (np.cos(b) - np.cos(a)) - tension * np.sin(b))

    # The root lies between that without tension and the limit 2 sqrt(T) of a long rod, and above both.
    low = max(4.0, float(np.sqrt(tension)) * (1.0 + 1e-6))
    grid = np.linspace(low, low + 10.0, 2001)
    signs = np.array([equation(float(a)) for a in grid]) > 0.0
    first = int(np.flatnonzero(signs[1:] != signs[:-1])[0])
    return 2.0 * bisect(equation, float(grid[first]), float(grid[first + 1]))


def beam_roots(ends: str, count: int) -> Array:
    """The first roots b of the frequency equations of slender beams; frequencies are b^2 sqrt(E I / (rho "
    "A L^4)).

    ``ends``: two of clamped, pinned, sliding and free by their first letters (Blevins 1979, table 8-1).
    """

    def equation(b: float) -> float:
        if ends in ("cc", "ff"):
            return float(np.cos(b) - 1.0 / np.cosh(b))
        if ends == "cf":
            return float(np.cos(b) + 1.0 / np.cosh(b))
        if ends == "cp":
            return float(np.sin(b) - np.cos(b) * np.tanh(b))
        return float(np.sin(b) + np.cos(b) * np.tanh(b))

    if ends == "pp":
        return np.asarray(np.pi * np.arange(1, count + 1))
    low = {"cc": np.pi, "ff": np.pi, "cf": 0.0, "cp": 0.75 * np.pi, "cs": 0.5 * np.pi}[ends]
    return np.array([bisect(equation, low + np.pi * i, low + np.pi * (i + 1)) for i in range(count)])


@dataclass(frozen=True)
class Vibration:
    """A beam that is let go: points along it, deflection and angle of its start, and what the middle does."""

    x: Array
    start: Array
    angle: Array
    middle: Array
    #: Angular frequencies.
    omega: Array


def clamped_motion(
    EI: float, GA: float, mass: float, shape: Callable[[Array], Array], times: Array, degree: int = 40
) -> Vibration:
    """Motion of a beam of length 1 between clamps, let go from a deflection.

    Timoshenko's linear beam without rotary inertia, whose angle theta follows the deflection w at once:

        rho A w_tt = (G A (w' - theta))',      0 = (E I theta')' + G A (w' - theta).

    Chebyshev collocation in space, modes in time.
    """
    nodes, derivative = chebyshev(degree)
    x, D = 0.5 * (1.0 + nodes), 2.0 * derivative
    inner = slice(1, degree)
    shear = EI * D @ D - GA * np.eye(degree + 1)
    turn = np.zeros((degree + 1, degree + 1))
    turn[inner] = np.linalg.solve(shear[inner, inner], (-GA * D)[inner])
    operator = (GA * D @ (D - turn) / mass)[inner, inner]
    squares, shapes = np.linalg.eig(-operator)
    order = np.argsort(squares.real)
    omega, shapes = np.sqrt(np.maximum(squares.real[order], 0.0)), shapes.real[:, order]
    parts = np.linalg.solve(shapes, shape(x)[inner])
    middle = np.asarray(np.cos(np.outer(times, omega)) @ (shapes[degree // 2 - 1] * parts))
    return Vibration(x, shape(x), turn @ shape(x), middle, omega)


def hubbed_blade(EI: float, mass: float, length: float, hub: float, speed: float, count: int) -> Array:
    """Angular frequencies of flapping of a slender straight blade on a hub of radius ``hub`` that turns.

    E I w'''' - (P w')' = w^2 rho A w with P = rho A speed^2 ((L^2 - x^2) / 2 + hub (L - x)), by Ritz's method
    with x^2 times Legendre polynomials.
    """
    points, weights = np.polynomial.legendre.leggauss(60)
    x, weights = 0.5 * length * (1.0 + points), 0.5 * length * weights
    shapes = [
        np.polynomial.Polynomial([0.0, 0.0, 1.0])
        * np.polynomial.Legendre.basis(k, [0.0, length]).convert(kind=np.polynomial.Polynomial)
        for k in range(12)
    ]
    w, slope, bend = (np.array([shape.deriv(order)(x) for shape in shapes]) for order in range(3))
    pull = mass * speed**2 * (0.5 * (length**2 - x**2) + hub * (length - x))
    inertia = (mass * weights * w) @ w.T
    stiffness = (EI * weights * bend) @ bend.T + (pull * weights * slope) @ slope.T
    root = np.linalg.inv(np.linalg.cholesky(inertia))
    return np.asarray(np.sqrt(np.linalg.eigvalsh(root @ stiffness @ root.T)[:count]))
