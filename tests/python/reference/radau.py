"""The collocation method with three stages at Radau's nodes, with given steps and without tables."""

import numpy as np
from numpy.polynomial import Polynomial


def coefficients():
    """Nodes of the collocation method with three stages, and integration matrix, computed without a table."""
    nodes = np.sort((Polynomial([0, 1]) ** 2 * Polynomial([-1, 1]) ** 3).deriv(2).roots().real)
    integrals = np.empty((3, 3))
    for j in range(3):
        others = [i for i in range(3) if i != j]
        lagrange = Polynomial.fromroots(nodes[others]) / np.prod(nodes[j] - nodes[others])
        integrals[:, j] = lagrange.integ()(nodes)
    return nodes, integrals


def solved(residual, x):
    """A root by Newton's method with finite differences, to rounding accuracy."""
    last = np.inf
    for _ in range(30):
        left = residual(x)
        steps = 1e-6 * (1.0 + np.abs(x))
        jacobian = np.column_stack([(residual(x + h) - left) / h.max() for h in np.diag(steps)])
        change = np.linalg.solve(jacobian, left)
        size = np.abs(change).max()
        if size >= 0.5 * last or size < 1e-100:
            return x
        x, last = x - change, size
    raise AssertionError(f"no root: the last change was {size}")


def run(model, t, q, v, u=None):
    """States at the ends of these steps, with inputs for each step."""
    nodes, integrals = coefficients()
    states = [(q, v)]
    for k, h in enumerate(np.diff(t)):

        def stages(a, k=k, h=h, q=q, v=v):
            a = a.reshape(3, -1)
            rates = v + h * integrals @ a
            return q + h * integrals @ rates, rates, a

        def residual(a, k=k, h=h, stages=stages):
            times = t[k] + h * nodes
            inputs = None if u is None else u[k]
            rows = zip(times, *stages(a), strict=True)
            return np.concatenate([model.inverse_dynamics(q, v, a, t=t, u=inputs) for t, q, v, a in rows])

        a = solved(residual, np.zeros(3 * len(q)))
        q, v = (x[-1] for x in stages(a)[:2])
        states.append((q, v))
    return [np.array(x) for x in zip(*states, strict=True)]
