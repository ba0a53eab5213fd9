"""The Cosserat rod once more: Newton-Euler in the body frame, integrated along X by adaptive Runge-Kutta.

Outward, for pose (R, p), body twist eta and its rate (Boyer, Lebastard, Candelier and Renda 2021, "Dynamics
of continuum and soft robots: a strain parameterization based approach", IEEE T-RO 37(3)):

    R' = R kappa^,   p' = R gamma,   eta' = xi_t - ad_xi eta,   eta_t' = xi_tt - ad_xi_t eta - ad_xi eta_t

Inward, for the body wrench F that the rest of the rod needs and the generalised forces tau:

    F' = ad_xi^T F - (M eta_t - ad_eta^T M eta - gravity)
    tau = int (B Phi)^T (F + H (xi - xi0) + mu H xi_t)

Twists and wrenches are angular first, a subscript t is a time derivative. Slow on purpose: nothing is shared
with the code under test, neither the frame nor the quadrature nor the way rotations are integrated.
"""

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import legvander
from scipy.integrate import quad_vec, solve_ivp
from scipy.spatial.transform import Rotation

STRAINS = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")
RTOL = 1e-12
ATOL = 1e-13


class Energy(NamedTuple):
    """Joules. `loads` counts the tip force only: a constant spatial moment has no potential."""

    kinetic: float
    elastic: float
    gravitational: float
    loads: float

    @property
    def total(self):
        return sum(self)


@dataclass(frozen=True)
class Segment:
    """Same arguments as `lissom.Segment`."""

    length: float
    radius: float | Sequence[float]
    young_modulus: float
    shear_modulus: float
    density: float
    modes: Mapping[str, int]
    retardation_time: float = 0.0
    reference_strain: Sequence[float] = (0, 0, 0, 1, 0, 0)
    shear_correction: float = 1.0

    @cached_property
    def coordinates(self):
        """Strain component and Legendre degree of each coordinate: two index arrays (n,)."""
        pairs = [(i, k) for i, name in enumerate(STRAINS) for k in range(self.modes.get(name, 0))]
        return np.array(pairs, int).reshape(-1, 2).T

    @property
    def n(self):
        return self.coordinates.shape[1]

    def basis(self, X):
        """B Phi(X), shape (6, n)."""
        strains, degrees = self.coordinates
        B_Phi = np.zeros((6, self.n))
        B_Phi[strains, range(self.n)] = legvander([2 * X / self.length - 1], degrees.max(initial=0))[
            0, degrees
        ]
        return B_Phi

    def section(self, X):
        """Area A and second moment of area I of the circular section at X."""
        base, tip = np.broadcast_to(self.radius, 2)
        radius = base + (tip - base) * X / self.length
        return np.pi * radius**2, np.pi * radius**4 / 4

    def stiffness(self, X):
        """Diagonal of H(X)."""
        A, I = self.section(X)
        EA, EI = self.young_modulus * A, self.young_modulus * I
        GA, GJ = self.shear_correction * self.shear_modulus * A, self.shear_modulus * 2 * I
        return np.array([GJ, EI, EI, EA, GA, GA])

    def inertia(self, X):
        """Diagonal of the inertia per length M(X)."""
        A, I = self.section(X)
        return self.density * np.array([2 * I, I, I, A, A, A])

    def stress(self, X, q, qd):
        """Elastic and damping part of the internal wrench."""
        return self.stiffness(X) * (self.basis(X) @ (q + self.retardation_time * qd))


def hat(w):
    """Matrix of the cross product with w."""
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def ad(twist):
    """Matrix of the Lie bracket with a twist."""
    bracket = np.zeros((6, 6))
    bracket[:3, :3] = bracket[3:, 3:] = hat(twist[:3])
    bracket[3:, :3] = hat(twist[3:])
    return bracket


def unpack(y):
    """Pose R, p, twist eta (6,) and its rates eta_t (6, m) of the m motions, from one flat state."""
    return y[:9].reshape(3, 3), y[9:12], y[12:18], y[18:].reshape(6, -1)


def integrate(rate, X0, X1, y0, atol=ATOL):
    """States at the steps of the integrator, one per row, from X0 to X1 in either direction."""
    return solve_ivp(rate, (X0, X1), y0, method="DOP853", rtol=RTOL, atol=atol).y.T


class Rod:
    """Same arguments as `lissom.Rod`. Accelerations are (n,) or (n, m): m motions from one state at once."""

    def __init__(
        self,
        segments: Iterable[Segment],
        base_position=(0, 0, 0),
        base_orientation=(1, 0, 0, 0),
        gravity=(0, 0, -9.81),
        tip_force=(0, 0, 0),
        tip_moment=(0, 0, 0),
        tip_mass=0.0,
    ):
        w, x, y, z = base_orientation
        R = Rotation.from_quat([x, y, z, w]).as_matrix()
        self.base = np.concatenate([R.ravel(), base_position, np.zeros(6)])
        self.segments = list(segments)
        self.gravity, self.tip_force, self.tip_moment = map(np.asarray, (gravity, tip_force, tip_moment))
        self.tip_mass = tip_mass
        ends = np.cumsum([0, *(segment.n for segment in self.segments)])
        self.dofs = [slice(start, end) for start, end in pairwise(ends)]
        self.n = ends[-1]

    def poses(self, q, X):
        """Poses (m, 4, 4) at arc lengths X (m,), counted from the rod's base."""
        q, rest, poses = np.asarray(q, float), np.zeros(self.n), np.tile(np.eye(4), (len(X), 1, 1))
        starts = np.cumsum([0, *(segment.length for segment in self.segments)])
        ends = self._outward(q, rest, np.empty((self.n, 0)))
        for pose, at in zip(poses, X, strict=True):
            i = min(np.searchsorted(starts, at, side="right"), len(self.segments)) - 1
            rate = self._motion_rate(i, q, rest, np.empty((self.n, 0)))
            R, p, *_ = unpack(integrate(rate, 0, at - starts[i], ends[i][0])[-1])
            pose[:3, :3], pose[:3, 3] = R, p
        return poses

    def inverse_dynamics(self, q, qd, qdd):
        """Generalised forces tau that the motion needs, of the shape of qdd."""
        q, qd, motions = (
            np.asarray(q, float),
            np.asarray(qd, float),
            np.reshape(qdd, (self.n, -1)).astype(float),
        )
        tau = self._forces_of_motion(q, qd, motions) + self.elastic_forces(q, qd)[:, None]
        return tau.reshape(np.shape(qdd))

    def elastic_forces(self, q, qd):
        """K q + D qd, the part of the generalised forces that elasticity and damping need."""
        forces = np.empty(self.n)
        for segment, dof in zip(self.segments, self.dofs, strict=True):

            def density(X, segment=segment, dof=dof):
                return segment.basis(X).T @ segment.stress(X, q[dof], qd[dof])

            forces[dof], _ = quad_vec(density, 0, segment.length, epsrel=RTOL)
        return forces

    def mass_matrix(self, q):
        """Column by column: what unit accelerations need of a rod that neither gravity nor loads act on."""
        free = copy(self)
        free.gravity, free.tip_force, free.tip_moment = np.zeros((3, 3))
        return free._forces_of_motion(np.asarray(q, float), np.zeros(self.n), np.eye(self.n))

    def forward_dynamics(self, q, qd):
        """Accelerations of the free motion."""
        return -np.linalg.solve(self.mass_matrix(q), self.inverse_dynamics(q, qd, np.zeros(self.n)))

    def energy(self, q, qd):
        """Energies in joules; the gravitational one is zero at the world's origin."""
        q, qd, none = np.asarray(q, float), np.asarray(qd, float), np.empty((self.n, 0))
        elastic, state = 0.0, np.concatenate([self.base, [0.0, 0.0]])
        for i, segment in enumerate(self.segments):
            dof, motion_rate = self.dofs[i], self._motion_rate(i, q, qd, none)

            def rate(X, state, segment=segment, motion_rate=motion_rate):
                _, p, eta, _ = unpack(state[:18])
                inertia = segment.inertia(X)
                densities = [eta @ (inertia * eta) / 2, -inertia[3] * self.gravity @ p]
                return np.concatenate([motion_rate(X, state[:18]), densities])

            def strain_energy(X, segment=segment, dof=dof):
                return (segment.basis(X) @ q[dof]) @ segment.stress(X, q[dof], 0 * q[dof]) / 2

            state = integrate(rate, 0, segment.length, state)[-1]
            elastic += quad_vec(strain_energy, 0, segment.length, epsrel=RTOL)[0]
        _, p, eta, _ = unpack(state[:18])
        kinetic = state[18] + self.tip_mass * eta[3:] @ eta[3:] / 2
        gravitational = state[19] - self.tip_mass * self.gravity @ p
        return Energy(kinetic, elastic, gravitational, -self.tip_force @ p)

    def _forces_of_motion(self, q, qd, qdd):
        """What inertia, gravity and the loads at the tip need, (n, m)."""
        m = qdd.shape[1]
        paths = self._outward(q, qd, qdd)
        F = self._tip_wrench(paths[-1][-1])
        # Absolute tolerances follow the largest force of each motion: a rod may weigh a gram or a ton.
        loads = [self._load(i, 0, y) for i, path in enumerate(paths) for y in path]
        largest = np.abs([F, *loads]).max(axis=(0, 1))

        tau = np.empty((self.n, m))
        for i, segment in reversed(list(enumerate(self.segments))):
            dof, motion_rate, size = self.dofs[i], self._motion_rate(i, q, qd, qdd), 18 + 6 * m

            def rate(X, state, i=i, segment=segment, motion_rate=motion_rate, size=size):
                y, F = state[:size], state[size : size + 6 * m].reshape(6, m)
                F_X = ad(self._strain(i, X, q)).T @ F - self._load(i, X, y)
                tau_X = -segment.basis(X).T @ F
                return np.concatenate([motion_rate(X, y), F_X.ravel(), tau_X.ravel()])

            start = np.concatenate([paths[i][-1], F.ravel(), np.zeros(segment.n * m)])
            scale = np.concatenate([np.ones(size), np.tile(np.where(largest > 0, largest, 1), 6 + segment.n)])
            end = integrate(rate, segment.length, 0, start, ATOL * scale)[-1]
            F = end[size : size + 6 * m].reshape(6, m)
            tau[dof] = end[size + 6 * m :].reshape(-1, m)
        return tau

    def _strain(self, i, X, q):
        return self.segments[i].reference_strain + self.segments[i].basis(X) @ q[self.dofs[i]]

    def _motion_rate(self, i, q, qd, qdd):
        """The outward equations of segment i."""
        segment, dof = self.segments[i], self.dofs[i]

        def rate(X, y):
            R, _, eta, eta_t = unpack(y)
            B_Phi = segment.basis(X)
            xi, xi_t, xi_tt = self._strain(i, X, q), B_Phi @ qd[dof], B_Phi @ qdd[dof]
            return np.concatenate(
                [
                    (R @ hat(xi[:3])).ravel(),
                    R @ xi[3:],
                    xi_t - ad(xi) @ eta,
                    (xi_tt - (ad(xi_t) @ eta)[:, None] - ad(xi) @ eta_t).ravel(),
                ]
            )

        return rate

    def _outward(self, q, qd, qdd):
        """States along every segment, base to tip."""
        paths, y = [], np.concatenate([self.base, np.zeros(6 * qdd.shape[1])])
        for i, segment in enumerate(self.segments):
            paths.append(integrate(self._motion_rate(i, q, qd, qdd), 0, segment.length, y))
            y = paths[-1][-1]
        return paths

    def _load(self, i, X, y):
        """Body wrench per length that inertia needs beyond what gravity gives, (6, m)."""
        R, _, eta, eta_t = unpack(y)
        M = self.segments[i].inertia(X)[:, None]
        weight = np.concatenate([np.zeros(3), R.T @ self.gravity])
        return M * eta_t - (ad(eta).T @ (M[:, 0] * eta))[:, None] - M * weight[:, None]

    def _tip_wrench(self, y):
        """Body wrench that the point mass needs beyond what gravity and the dead loads give, (6, m)."""
        R, _, eta, eta_t = unpack(y)
        acceleration = eta_t[3:] + np.cross(eta[:3], eta[3:])[:, None] - (R.T @ self.gravity)[:, None]
        force = self.tip_mass * acceleration - (R.T @ self.tip_force)[:, None]
        moment = np.broadcast_to(-(R.T @ self.tip_moment)[:, None], force.shape)
        return np.vstack([moment, force])
