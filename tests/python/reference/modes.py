"""Independent vibrations: NumPy's general eigenvalue solver with matrices from central differences."""

import numpy as np
from scipy.optimize import brentq


def matrices(model, q):
    """M, D, K at rest by central differences of the inverse dynamics, which are quadratic in velocities."""

    def derivative(argument, step):
        columns = []
        for k in range(model.n):
            delta = np.zeros((3, model.n))
            delta[argument, k] = step
            ahead = model.inverse_dynamics(q + delta[0], delta[1], delta[2])
            behind = model.inverse_dynamics(q - delta[0], -delta[1], -delta[2])
            columns.append((ahead - behind) / (2 * step))
        return np.transpose(columns)

    return derivative(2, 1.0), derivative(1, 1.0), derivative(0, 1e-5)


def eigenvalues(M, D, K):
    """All 2 n eigenvalues s of ``(s^2 M + s D + K) x = 0``, sorted by the size of their imaginary parts."""
    n = len(M)
    state = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]])
    found = np.linalg.eigvals(state)
    return found[np.lexsort([found.imag, np.abs(found)])]


def cantilever(EI, mass_per_length, L, count):
    """Frequencies in hertz of a clamped-free Euler-Bernoulli beam: cos b cosh b = -1."""
    roots = [
        brentq(lambda b: np.cos(b) + 1 / np.cosh(b), np.pi * (k + 0.1), np.pi * (k + 0.9))
        for k in range(count)
    ]
    return np.square(roots) / (2 * np.pi * L**2) * np.sqrt(EI / mass_per_length)
