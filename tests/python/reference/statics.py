"""Independent equilibria of planar inextensible rods, by collocation and in closed form.

With the angle phi below the horizontal, weight w per length, dead tip force (H, 0, -P) and tip moment M:

    EI phi'' = -(w (L - X) + P) cos phi + H sin phi,   phi(0) = 0,   EI phi'(L) = M
"""

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_bvp
from scipy.optimize import brentq
from scipy.special import ellipeinc, ellipk, ellipkinc


class Shape(NamedTuple):
    """Tip position (x, z) and tip angle below the horizontal."""

    x: float
    z: float
    angle: float


def planar_rod(EI, L, *, weight=0.0, force=(0.0, 0.0), moment=0.0, steps=20):
    """The equilibrium reached by increasing loads; `force` is (x, z). Fourth-order collocation."""
    H, P = force[0], -force[1]

    def shape(part, start):
        def rate(X, y):
            phi, bend, *_ = y
            load = weight * (L - X) + P
            return np.array(
                [
                    bend,
                    part * (H * np.sin(phi) - load * np.cos(phi)) / EI,
                    np.cos(phi),
                    -np.sin(phi),
                ]
            )

        def ends(a, b):
            return np.array([a[0], a[2], a[3], b[1] - part * moment / EI])

        found = solve_bvp(rate, ends, start[0], start[1], tol=1e-8, max_nodes=100_000)
        assert found.success, found.message
        return found.x, found.y

    X = np.linspace(0, L, 50)
    start = X, np.array([0 * X, 0 * X, X, 0 * X])
    for part in np.linspace(0, 1, steps + 1)[1:]:
        start = shape(part, start)
    phi, _, x, z = start[1][:, -1]
    return Shape(x, z, phi)


def buckled_column(ratio, L=1.0):
    """Tip of a clamped-free column under `ratio` > 1 times its Euler load: (x along it, deflection, angle).

    Timoshenko and Gere (1961), Theory of Elastic Stability, section 2.7: K(p) = k L, p = sin(alpha / 2).
    """
    kL = np.pi / 2 * np.sqrt(ratio)
    m = brentq(lambda m: ellipk(m) - kL, 1e-12, 1 - 1e-12, xtol=1e-15)
    along = 2 * ellipeinc(np.pi / 2, m) / ellipkinc(np.pi / 2, m) - 1
    return along * L, 2 * np.sqrt(m) / kL * L, 2 * np.arcsin(np.sqrt(m))
