"""Balls in a row without weight, by Hunt and Crossley's law: flights in closed form, contacts by SciPy."""

import numpy as np
from scipy.integrate import solve_ivp


class BallRow:
    """Balls of these masses on a line, all of one radius.

    Neighbours push each other apart by the force k d max(0, 1 + c d') in the overlap d.
    """

    def __init__(self, masses, radius, stiffness, dissipation=0.0):
        self.masses = np.asarray(masses, dtype=float)
        self.radius, self.stiffness, self.dissipation = radius, stiffness, dissipation

    def gaps(self, x):
        return np.diff(x) - 2 * self.radius

    def energy(self, x, v):
        """Of the overlaps, and kinetic in the frame of the common centre of mass."""
        drift = self.masses @ v / self.masses.sum()
        overlaps = np.maximum(0.0, -self.gaps(x))
        return 0.5 * self.masses @ (v - drift) ** 2 + 0.5 * self.stiffness * overlaps @ overlaps

    def rates(self, _t, y):
        x, v = np.split(y, 2)
        overlaps = np.maximum(0.0, -self.gaps(x))
        push = self.stiffness * overlaps * np.maximum(0.0, 1 - self.dissipation * np.diff(v))
        force = np.concatenate([-push, [0.0]]) + np.concatenate([[0.0], push])
        return np.concatenate([v, force / self.masses])

    def run(self, x, v, duration):
        """State after this time, and the number of contacts on the way."""
        x, v = np.array(x, dtype=float), np.array(v, dtype=float)
        t, contacts = 0.0, 0
        reduced = self.masses[:-1] * self.masses[1:] / (self.masses[:-1] + self.masses[1:])
        shortest = np.sqrt(reduced.min() / self.stiffness)

        def let_go(_t, y):
            return self.gaps(y[: len(x)]).min()

        let_go.terminal, let_go.direction = True, 1
        while t < duration:
            closing = -np.diff(v)
            gaps = self.gaps(x)
            times = np.where(closing > 0, np.maximum(gaps, 0.0) / np.where(closing > 0, closing, 1.0), np.inf)
            flight = min(times.min(), duration - t)
            x, t = x + flight * v, t + flight
            if t >= duration:
                break
            # A hair inside: the event is where gaps open again.
            nudge = 1e-6 * shortest
            y = np.concatenate([x + nudge * v, v])
            solved = solve_ivp(
                self.rates,
                (t + nudge, duration),
                y,
                method="DOP853",
                events=let_go,
                rtol=1e-10,
                atol=1e-13,
                max_step=shortest,
            )
            (x, v), t = np.split(solved.y[:, -1], 2), solved.t[-1]
            contacts += 1
        return x, v, contacts

    def follow(self, x, v, duration):
        """The same state by SciPy alone, also where balls touch from the start or by many at once."""
        reduced = self.masses[:-1] * self.masses[1:] / (self.masses[:-1] + self.masses[1:])
        shortest = np.sqrt(reduced.min() / self.stiffness)
        start = np.concatenate([x, v])
        solved = solve_ivp(
            self.rates, (0, duration), start, method="DOP853", rtol=1e-9, atol=1e-12, max_step=shortest
        )
        assert solved.success
        return np.split(solved.y[:, -1], 2)
