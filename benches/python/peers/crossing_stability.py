"""Stability of the symmetric state of the experiment `crossing` of cosseratbench, without lissom.

    pip install cosseratbench
    python benches/python/peers/crossing_stability.py

Both ropes are quintic B-splines of position with energies of stretch, bending and weight; that they touch in
one point, without friction, is a constraint. Newton's method finds the symmetric equilibrium, and the second
derivative of the Lagrangian there, where the constraint holds, has the squares of the frequencies.
"""

import numpy as np
from cosseratbench.experiments import crossing
from scipy.interpolate import BSpline
from scipy.linalg import block_diag, eigh, null_space

DEGREE = 5
MODULUS, DROP = 1e6, 0.1
AREA = np.pi * crossing.RADIUS**2
STRETCH, BENDING = MODULUS * AREA, MODULUS * AREA * crossing.RADIUS**2 / 4.0
MASS = crossing.DENSITY * AREA
APART = 2.0 * crossing.RADIUS
#: Step of the differences of the gradient, m.
DIFFERENCE = 1e-6


class Ropes:
    """Two ropes with `spans` pieces each, shorter in the middle: control points as one vector."""

    def __init__(self, spans: int, slope: float) -> None:
        u = np.linspace(-1.0, 1.0, spans + 1)
        breaks = 0.5 + 0.5 * (slope * u + (1.0 - slope) * u**3)
        self.shortest = float(np.diff(breaks).min())
        self.knots = np.concatenate([np.zeros(DEGREE), breaks, np.ones(DEGREE)])
        self.n = spans + DEGREE
        x, w = np.polynomial.legendre.leggauss(8)
        halves = np.diff(breaks)[:, None] / 2.0
        self.places = (breaks[:-1, None] + halves * (1.0 + x)).ravel()
        self.weights = (halves * w).ravel()
        self.values = [self.basis(self.places, order) for order in range(3)]
        free = np.ones((2, self.n, 3), dtype=bool)
        free[:, [0, -1]] = False
        self.free = free.ravel()

    def basis(self, places: np.ndarray | float, order: int = 0) -> np.ndarray:
        spline = BSpline(self.knots, np.eye(self.n), DEGREE)
        return (spline.derivative(order) if order else spline)(places)

    def start(self) -> np.ndarray:
        """The reference's shapes."""
        arc, *curves = crossing._shapes(MODULUS, DROP, APART)
        half = crossing.SPAN / 2.0
        pins = ([[-half, 0.0, 0.0], [half, 0.0, 0.0]], [[0.0, -half, -DROP], [0.0, half, -DROP]])
        found = []
        for curve, ends in zip(curves, pins, strict=True):
            seen = np.stack([np.interp(self.places, arc, curve[:, k]) for k in range(3)], axis=1)
            control = np.linalg.lstsq(self.values[0], seen, rcond=None)[0]
            control[[0, -1]] = ends
            found.append(control.ravel())
        return np.concatenate(found)

    def gradient(self, x: np.ndarray) -> np.ndarray:
        """Of the energy."""
        found = []
        for control in x.reshape(2, self.n, 3):
            r1, r2 = self.values[1] @ control, self.values[2] @ control
            length = np.linalg.norm(r1, axis=1)[:, None]
            along = r1 / length
            p, b = (r1 * r2).sum(axis=1)[:, None], (r2 * r2).sum(axis=1)[:, None]
            # The square of the bend per unstretched length is b / l^2 - p^2 / l^4.
            g1 = STRETCH * (length - 1.0) * along
            g1 += BENDING * (-b / length**3 * along - p * r2 / length**4 + 2.0 * p**2 / length**5 * along)
            g2 = BENDING * (r2 / length**2 - p * r1 / length**4)
            w = self.weights[:, None]
            forces = self.values[1].T @ (w * g1) + self.values[2].T @ (w * g2)
            forces[:, 2] += self.values[0].T @ (self.weights * MASS * crossing.GRAVITY)
            found.append(forces.ravel())
        return np.concatenate(found)

    def gap(self, x: np.ndarray) -> tuple[float, np.ndarray]:
        """Distance of the axes at their nearest places, and its gradient."""
        lower, upper = x.reshape(2, self.n, 3)
        s = np.array([0.5, 0.5])
        for _ in range(50):
            (a, a1, a2), (b, b1, b2) = (
                [self.basis(s[k], order) @ control for order in range(3)]
                for k, control in enumerate((lower, upper))
            )
            d = a - b
            slope = np.array([d @ a1, -d @ b1])
            tangent = np.array([[a1 @ a1 + d @ a2, -a1 @ b1], [-a1 @ b1, b1 @ b1 - d @ b2]])
            step = np.linalg.solve(tangent, slope)
            s = s - step
            if np.abs(step).max() < 1e-14:
                break
        d = self.basis(s[0]) @ lower - self.basis(s[1]) @ upper
        distance = float(np.linalg.norm(d))
        parts = [np.outer(self.basis(s[0]), d / distance), -np.outer(self.basis(s[1]), d / distance)]
        return distance, np.concatenate(parts).ravel()

    def forces(self, x: np.ndarray, contact: float) -> np.ndarray:
        return (self.gradient(x) - contact * self.gap(x)[1])[self.free]

    def stiffness(self, x: np.ndarray, contact: float) -> np.ndarray:
        columns = []
        for i in np.flatnonzero(self.free):
            step = np.zeros_like(x)
            step[i] = DIFFERENCE
            columns.append((self.forces(x + step, contact) - self.forces(x - step, contact)) / 2.0)
        found = np.array(columns) / DIFFERENCE
        return (found + found.T) / 2.0

    def equilibrium(self) -> tuple[np.ndarray, float]:
        """Shape and contact force."""
        x, contact = self.start(), crossing._contact_force(MODULUS, DROP, crossing._mid_height)
        for _ in range(30):
            distance, normal = self.gap(x)
            left = np.append(self.forces(x, contact), APART - distance)
            if np.abs(left).max() < 1e-11:
                return x, contact
            normal = normal[self.free][:, None]
            matrix = np.block([[self.stiffness(x, contact), -normal], [-normal.T, np.zeros((1, 1))]])
            step = np.linalg.solve(matrix, left)
            x[self.free] -= step[:-1]
            contact -= step[-1]
        raise RuntimeError("Newton's method did not converge")

    def squares(self, x: np.ndarray, contact: float) -> np.ndarray:
        """Squares of the angular frequencies, 1/s²."""
        one = np.kron(MASS * (self.values[0].T * self.weights) @ self.values[0], np.eye(3))
        mass = block_diag(one, one)[np.ix_(self.free, self.free)]
        kept = null_space(self.gap(x)[1][self.free][None])
        matrices = [kept.T @ part @ kept for part in (self.stiffness(x, contact), mass)]
        return eigh(*matrices, eigvals_only=True)


def main() -> None:
    damping = 2.0 * crossing.build(MODULUS, DROP).slowest_frequency()
    for spans, slope in ((16, 0.35), (24, 0.35), (24, 0.1), (48, 0.1)):
        ropes = Ropes(spans, slope)
        x, contact = ropes.equilibrium()
        squares = ropes.squares(x, contact)
        rate = (-damping + np.sqrt(damping**2 - 4.0 * squares[0])) / 2.0
        print(
            f"{spans} spans, {1e3 * ropes.shortest:.2f} mm in the middle: contact {contact:.6f} N, "
            f"{squares[:3]} 1/s², growth {rate:.3f} 1/s",
            flush=True,
        )


if __name__ == "__main__":
    main()
