"""Chains of rigid links that stand on their base: equations in absolute angles, with SciPy's DOP853.

Links of length l and mass m are uniform and point upwards (along x) where all angles vanish; joints have
springs and dampers, the weight acts downwards, and a force follows the last link, towards its base. Angles
turn about y.
"""

import numpy as np
from scipy.integrate import solve_ivp


class Chain:
    def __init__(self, lengths, masses, springs=0.0, dampers=0.0, gravity=0.0, follower=0.0, radius=0.01):
        self.n = len(lengths)
        self.lengths, self.masses = np.array(lengths, float), np.array(masses, float)
        self.springs, self.dampers = (np.broadcast_to(x, self.n).astype(float) for x in (springs, dampers))
        self.gravity, self.follower = gravity, follower
        self.radii = radius * self.lengths
        above = np.cumsum(self.masses[::-1])[::-1] - self.masses
        levers = self.lengths * (self.masses / 2 + above)
        self.inertia = np.empty((self.n, self.n))
        for i in range(self.n):
            self.inertia[i, i:] = self.inertia[i:, i] = self.lengths[i] * levers[i:]
        turning = self.masses * (self.lengths**2 / 12 + self.radii**2 / 4)
        own = turning + self.masses * self.lengths**2 / 4 + self.lengths**2 * above
        np.fill_diagonal(self.inertia, own)
        self.weight = gravity * levers
        relative = self.relative = np.eye(self.n) - np.eye(self.n, k=-1)
        self.stiffness = relative.T @ np.diag(self.springs) @ relative
        self.damping = relative.T @ np.diag(self.dampers) @ relative

    def rates(self):
        """Eigenvalues of small motions about the upright shape."""
        geometric = -np.diag(self.weight) - self.follower * np.diag(self.lengths)
        geometric[:, -1] += self.follower * self.lengths
        solve = np.linalg.solve
        lower = [-solve(self.inertia, self.stiffness + geometric), -solve(self.inertia, self.damping)]
        zero = np.zeros((self.n, self.n))
        return np.linalg.eigvals(np.block([[zero, np.eye(self.n)], lower]))

    def rhs(self, t, state):
        angles, rates = state[: self.n], state[self.n :]
        apart = angles[:, None] - angles
        forces = -(self.inertia * np.sin(apart)) @ rates**2 + self.weight * np.sin(angles)
        forces -= self.stiffness @ angles + self.damping @ rates
        forces -= self.follower * self.lengths * np.sin(angles[-1] - angles)
        return np.concatenate([rates, np.linalg.solve(self.inertia * np.cos(apart), forces)])

    def tips(self, q0, v0, times, rtol=1e-12):
        """Ends of all links, shape (times, links, 3), from relative angles and their rates."""
        start = np.concatenate([np.linalg.solve(self.relative, x) for x in (q0, v0)])
        smallest = 1e-3 * rtol * max(np.abs(start).max(), 1e-10)
        span = (0.0, times[-1])
        found = solve_ivp(self.rhs, span, start, "DOP853", times, rtol=rtol, atol=smallest)
        assert found.success, found.message
        angles = found.y[: self.n]
        along = np.stack([np.cos(angles), np.zeros_like(angles), -np.sin(angles)], axis=-1)
        return np.cumsum(self.lengths[:, None, None] * along, axis=0).transpose(1, 0, 2)
