"""Newton's method as used in the lab: x <- x - pinv(J) R until ||R|| < tol."""

import numpy as np


def newton(fun, jac, x0, tol=1e-6, max_iter=1000):
    """All iterates, shape (steps + 1, n)."""
    x = np.array(x0, dtype=float)
    iterates = [x]
    while np.linalg.norm(fun(x)) > tol and len(iterates) <= max_iter:
        x = x - np.linalg.pinv(jac(x)) @ fun(x)
        iterates.append(x)
    return np.array(iterates)


def forward_jacobian(fun, x, step):
    """Columns (R(x + h e_j) - R(x)) / h."""
    return np.column_stack([(fun(x + step * e) - fun(x)) / step for e in np.eye(len(x))])


def central_jacobian(fun, x, step):
    """Columns (R(x + h e_j) - R(x - h e_j)) / 2h."""
    return np.column_stack([(fun(x + step * e) - fun(x - step * e)) / (2 * step) for e in np.eye(len(x))])
