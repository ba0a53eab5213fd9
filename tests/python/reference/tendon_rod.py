"""Equilibrium of one rod with tendons, by shooting: balance of rod and tendons together.

A cut through the rod and its frictionless tendons carries the force n, the weight beyond it, and the moment
m, both in world axes, with m' = -p' x n and m = 0 at the free tip. In the section's axes the strains (u, v)
minimise

    1/2 u.K_u u + 1/2 (v - e_x).K_v (v - e_x) + sum T |v + u x d + d'| - m.u - n.v

a convex function for any tensions T. There are no modes: the equations are integrated along the rod.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import root

from reference.rod import hat

TOLERANCE = 1e-12
NEWTON_STEPS = 50


def parallel(y, z):
    """A tendon at a constant offset: d and d' at an arc length."""
    return lambda X: (np.array([0.0, y, z]), np.zeros(3))


def helical(distance, start, rate):
    """A tendon that winds around the rod's axis by `rate` radians per metre."""

    def routing(X):
        angle = start + rate * X
        around = np.array([0.0, np.cos(angle), np.sin(angle)])
        return distance * around, rate * distance * np.array([0.0, -around[2], around[1]])

    return routing


@dataclass(frozen=True)
class TendonRod:
    """A circular rod with its base at the world's origin; `R` is the orientation of the base."""

    length: float
    radius: float
    young_modulus: float
    shear_modulus: float
    density: float
    routings: Sequence[Callable]
    gravity: Sequence[float] = (0, 0, 0)
    R: np.ndarray = None

    @property
    def stiffness(self):
        """Stiffness of torsion and bending about y and z; of stretch and shear."""
        A, I = np.pi * self.radius**2, np.pi * self.radius**4 / 4
        E, G = self.young_modulus, self.shear_modulus
        return np.array([2 * G * I, E * I, E * I, E * A, G * A, G * A])

    def strains(self, X, tensions, moment, force):
        """u, v of the section at X for this moment and force, in its axes, by Newton's method."""
        K, rest = self.stiffness, np.array([0, 0, 0, 1.0, 0, 0])
        strain = rest.copy()
        for _ in range(NEWTON_STEPS):
            gradient, curvature = K * (strain - rest) - np.concatenate([moment, force]), np.diag(K)
            for routing, tension in zip(self.routings, tensions, strict=True):
                d, slope = routing(X)
                way = np.hstack([-hat(d), np.eye(3)])
                along = way @ strain + slope
                speed = np.linalg.norm(along)
                t = along / speed
                gradient = gradient + tension * way.T @ t
                curvature = curvature + tension * way.T @ (np.eye(3) - np.outer(t, t)) @ way / speed
            step = np.linalg.solve(curvature, gradient)
            strain = strain - step
            if np.abs(step).max() < 1e-14 * max(1, np.abs(strain).max()):
                return strain
        raise RuntimeError(f"no strains at X = {X}: last step {np.abs(step).max()}")

    def _shot(self, tensions, base_moment):
        weight = np.pi * self.radius**2 * self.density * np.asarray(self.gravity, float)

        def rate(X, y):
            R, m = y[:9].reshape(3, 3), y[12:15]
            n = weight * (self.length - X)
            strain = self.strains(X, tensions, R.T @ m, R.T @ n)
            p_X = R @ strain[3:]
            lengths = [
                np.linalg.norm(strain[3:] + np.cross(strain[:3], d) + slope)
                for d, slope in (routing(X) for routing in self.routings)
            ]
            return np.concatenate([(R @ hat(strain[:3])).ravel(), p_X, -np.cross(p_X, n), lengths])

        R = np.eye(3) if self.R is None else self.R
        start = np.concatenate([R.ravel(), np.zeros(3), base_moment, np.zeros(len(self.routings))])
        ends = (0, self.length)
        return solve_ivp(rate, ends, start, method="DOP853", rtol=TOLERANCE, atol=1e-3 * TOLERANCE).y[:, -1]

    def equilibrium(self, tensions, base_moment=(0, 0, 0)):
        """Tip (3,), lengths of the tendons and the moment at the base, in world axes."""
        scale = self.stiffness[1] / self.length
        found = root(
            lambda x: self._shot(tensions, scale * x)[12:15] / scale,
            np.asarray(base_moment) / scale,
            tol=TOLERANCE,
        )
        if np.abs(found.fun).max() > 1e-10:
            raise RuntimeError(found.message)
        end = self._shot(tensions, scale * found.x)
        return end[9:12], end[15:], scale * found.x


#: Rotates x to the vertical z, and z to -x.
UP = np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]])

#: The tendon robot of JohnDTill/ContinuumRobotExamples (01_Statics/05_Tendon_Robot), with gravity along +x;
#: of its four tendons only the one on the side of +x.
TILL = TendonRod(0.5, 1e-3, 200e9, 80e9, 8000.0, [parallel(0.0, -15.06e-3)], (9.81, 0, 0), UP)
#: By tension: x and z of the tip, length of the tendon, moment about y at the base.
TILL_VALUES = {
    0.0: (0.01225672712603, 0.4998282811910, 0.499507718742, 0.03081161453861),
    5.0: (0.07158721934242, 0.4933229060842, 0.495899967198, 0.03060083605622),
    10.0: (0.1287620456721, 0.4775894094345, 0.492300429771, 0.03010370193973),
    15.0: (0.1822116945404, 0.4532292709337, 0.488708659833, 0.02933383185885),
    20.0: (0.2305250632385, 0.4211162152456, 0.485124018385, 0.02831044122014),
}

#: The robot of Rucker and Webster (2011) with three parallel tendons, as in Tummers et al. (2023),
#: with G = E / (2 (1 + nu)); its first tendon is on the side of +x.
RUCKER_AND_WEBSTER = TendonRod(
    0.242,
    0.4e-3,
    210e9,
    210e9 / (2 * 1.3125),
    95000.0,
    [parallel(8e-3 * np.sin(angle), -8e-3 * np.cos(angle)) for angle in 2 * np.pi / 3 * np.arange(3)],
    (0, 0, -9.81),
    UP,
)
#: Position of the tip by tensions.
RUCKER_AND_WEBSTER_TIPS = {
    (1.0, 0.0, 0.0): (0.06624412338, 0.0, 0.22980149963),
    (5.0, 0.0, 0.0): (0.17756775618, 0.0, 0.04713904666),
    (3.0, 2.0, 0.0): (0.112137011009, 0.097113498969, 0.1668553845),
    (5.0, 5.0, 0.0): (0.088779685799, 0.153770926485, 0.047138368417),
}


def helix(rod: TendonRod, rate, tension):
    """The tip (4, 4) of a weightless rod pulled by one helical tendon that begins at angle 0.

    In axes that rotate with the tendon, strains do not depend on X: the axis is a helix. The rod has only
    this tendon.
    """
    strain = rod.strains(0.0, [tension], np.zeros(3), np.zeros(3))
    turn = np.array([rate, 0, 0])
    screw = np.zeros((4, 4))
    screw[:3, :3], screw[:3, 3] = hat(strain[:3] + turn), strain[3:]
    back = np.zeros((4, 4))
    back[:3, :3] = -hat(turn)
    return expm(rod.length * screw) @ expm(rod.length * back)
