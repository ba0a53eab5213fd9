"""Independent Cosserat rod: Newton-Euler in the body frame, integrated over X by adaptive Runge-Kutta.

Outward, for pose (R, p), body twist eta and its rate (Boyer, Lebastard, Candelier and Renda 2021, "Dynamics
of continuum and soft robots: a strain parameterization based approach", IEEE T-RO 37(3)):

    R' = R kappa^,   p' = R gamma,   eta' = xi_t - ad_xi eta,   eta_t' = xi_tt - ad_xi_t eta - ad_xi eta_t

Inward, for the body wrench F required by the rest of the rod, and the generalised forces tau:

    F' = ad_xi^T F - (M eta_t - ad_eta^T M eta - gravity - loads per length)
    F jumps by the wrench that bodies and other attached items require, minus the loads there
    tau = int (B Phi)^T (F + H (xi - xi0) + mu H xi_t)

Twists and wrenches have the angular part first; a subscript t is a time derivative. Slow on purpose: nothing
is shared with the code under test, neither the frame nor the quadrature nor the integration of rotations.
"""

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.integrate import quad_vec, solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import eval_legendre

STRAINS = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")
RTOL = 1e-12
ATOL = 1e-13


class Energy(NamedTuple):
    """Joules. `loads` includes dead forces only: moments and follower loads have no potential."""

    kinetic: float
    elastic: float
    gravitational: float
    loads: float

    @property
    def total(self):
        return sum(self)


@dataclass(frozen=True)
class Section:
    """Created like `lissom.Section`; sizes may be pairs, at base and tip."""

    shape: str
    parameters: Mapping[str, object]

    @staticmethod
    def circle(radius):
        return Section("circle", {"radius": radius})

    @staticmethod
    def hollow_circle(outer, inner):
        return Section("hollow_circle", {"outer": outer, "inner": inner})

    @staticmethod
    def rectangle(width, height):
        return Section("rectangle", {"width": width, "height": height})

    @staticmethod
    def ellipse(semi_axis_y, semi_axis_z):
        return Section("ellipse", {"semi_axis_y": semi_axis_y, "semi_axis_z": semi_axis_z})

    @staticmethod
    def given(stiffness, mass, inertia=(0, 0, 0), centre=(0, 0)):
        parameters = {"stiffness": stiffness, "mass": mass, "inertia": inertia, "centre": centre}
        return Section("given", parameters)

    def sizes(self, x):
        """Sizes at the fraction x of the segment."""
        for size in self.parameters.values():
            base, tip = (size, size) if np.isscalar(size) else size
            yield base + (tip - base) * x

    def figure(self, x):
        """Area, second moments of area about y and z, torsion constant."""
        if self.shape in ("circle", "hollow_circle"):
            outer, inner = (*self.sizes(x), 0.0)[:2]
            A, I = np.pi * (outer**2 - inner**2), np.pi * (outer**4 - inner**4) / 4
            return A, I, I, 2 * I
        if self.shape == "rectangle":
            w, h = self.sizes(x)
            return w * h, w * h**3 / 12, h * w**3 / 12, torsion_of_rectangle(max(w, h), min(w, h))
        a, b = self.sizes(x)
        A = np.pi * a * b
        return A, A * b**2 / 4, A * a**2 / 4, A * a**2 * b**2 / (a**2 + b**2)


def torsion_of_rectangle(a, b):
    """Prandtl's membrane on a x b with a >= b, by a sine series across a."""
    n = np.arange(1, 4000, 2)
    return b * a**3 / 3 * (1 - 192 * a / (np.pi**5 * b) * np.sum(np.tanh(n * np.pi * b / (2 * a)) / n**5.0))


@dataclass(frozen=True)
class Segment:
    """Same arguments as `lissom.Segment`."""

    length: float
    radius: float | Sequence[float] | None = None
    young_modulus: float | None = None
    shear_modulus: float | None = None
    density: float | None = None
    modes: Mapping[str, int] | None = None
    retardation_time: float = 0.0
    reference_strain: Sequence[float] = (0, 0, 0, 1, 0, 0)
    shear_correction: float | Sequence[float] = 1.0
    section: Section | None = None

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
        B_Phi[strains, np.arange(self.n)] = eval_legendre(degrees, 2 * X / self.length - 1)
        return B_Phi

    @property
    def shape(self):
        return self.section if self.section is not None else Section.circle(self.radius)

    def stiffness(self, X):
        """H(X), (6, 6)."""
        if self.shape.shape == "given":
            H = np.array(self.shape.parameters["stiffness"], float)
            return np.diag(H) if H.ndim == 1 else H
        A, I_y, I_z, J = self.shape.figure(X / self.length)
        E, G = self.young_modulus, self.shear_modulus
        k_y, k_z = np.broadcast_to(self.shear_correction, 2)
        return np.diag([G * J, E * I_y, E * I_z, E * A, k_y * G * A, k_z * G * A])

    def inertia(self, X):
        """Inertia per length M(X) for twists of the section, as that of a body one metre long, (6, 6)."""
        if self.shape.shape == "given":
            given = self.shape.parameters
            return Body(given["mass"], centre=(0, *given["centre"]), inertia=given["inertia"]).matrix
        A, I_y, I_z, _ = self.shape.figure(X / self.length)
        return self.density * np.diag([I_y + I_z, I_y, I_z, A, A, A])

    def outline_area(self, X):
        """Area within the outline, including a hole."""
        if self.shape.shape == "hollow_circle":
            outer, _ = self.shape.sizes(X / self.length)
            return np.pi * outer**2
        return self.shape.figure(X / self.length)[0]

    @property
    def centre(self):
        """Centre of mass of the sections in their axes, (3,)."""
        return np.array([0, *self.shape.parameters.get("centre", (0, 0))], float)

    def stress(self, X, q, qd):
        """Elastic and damping part of the internal wrench."""
        return self.stiffness(X) @ (self.basis(X) @ (q + self.retardation_time * qd))


@dataclass(frozen=True)
class Load:
    """Same arguments as `lissom.Load`."""

    force: Sequence[float] = (0, 0, 0)
    moment: Sequence[float] = (0, 0, 0)
    at: float | None = None
    along: Sequence[float] | None = None
    frame: str = "world"

    def wrench(self, R):
        """Body wrench at a section with rotation R, per length for a distributed load, (6,)."""
        turn = R.T if self.frame == "world" else np.eye(3)
        return np.concatenate([turn @ self.moment, turn @ self.force])

    def potential(self, p):
        return -np.dot(self.force, p) if self.frame == "world" else 0.0


@dataclass(frozen=True)
class Body:
    """Same arguments as `lissom.Body`."""

    mass: float
    at: float | None = None
    centre: Sequence[float] = (0, 0, 0)
    inertia: Sequence = (0, 0, 0)

    @property
    def matrix(self):
        """Inertia for twists of the section, (6, 6)."""
        inertia = np.array(self.inertia, float)
        to_centre = np.block([[np.eye(3), np.zeros((3, 3))], [-hat(self.centre), np.eye(3)]])
        about_centre = np.zeros((6, 6))
        about_centre[:3, :3] = np.diag(inertia) if inertia.ndim == 1 else inertia
        about_centre[3:, 3:] = self.mass * np.eye(3)
        return to_centre.T @ about_centre @ to_centre


@dataclass(frozen=True)
class Held:
    """Wrench required by an attached item, in the axes of the section there, (6, m)."""

    at: float | None
    wrench: np.ndarray


def hat(w):
    """Matrix of the cross product with w."""
    x, y, z = np.asarray(w).tolist()
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def ad(twist):
    """Matrix of the Lie bracket with a twist."""
    # In one go: the references spend most of their time in small matrices.
    a, b, c, x, y, z = np.asarray(twist).tolist()
    return np.array(
        [
            [0, -c, b, 0, 0, 0],
            [c, 0, -a, 0, 0, 0],
            [-b, a, 0, 0, 0, 0],
            [0, -z, y, 0, -c, b],
            [z, 0, -x, c, 0, -a],
            [-y, x, 0, -b, a, 0],
        ]
    )


def unpack(y):
    """Pose R, p, twist eta (6,) and its rates eta_t (6, m) of the m motions, from one flat state."""
    return y[:9].reshape(3, 3), y[9:12], y[12:18], y[18:].reshape(6, -1)


def integrate(rate, X0, X1, y0, atol=ATOL):
    """States at the steps of the integrator, one per row, from X0 to X1 in either direction."""
    return solve_ivp(rate, (X0, X1), y0, method="DOP853", rtol=RTOL, atol=atol).y.T


class Rod:
    """Same arguments as `lissom.Rod`. Accelerations are (n,) or (n, m) for m motions from one state."""

    def __init__(
        self,
        segments: Iterable[Segment],
        base_position=(0, 0, 0),
        base_orientation=(1, 0, 0, 0),
        gravity=(0, 0, -9.81),
        tip_force=(0, 0, 0),
        tip_moment=(0, 0, 0),
        tip_mass=0.0,
        loads=(),
        bodies=(),
    ):
        w, x, y, z = base_orientation
        R = Rotation.from_quat([x, y, z, w]).as_matrix()
        self.base = np.concatenate([R.ravel(), base_position, np.zeros(6)])
        self.base_rate = np.zeros(6)
        self.segments = list(segments)
        self.gravity = np.asarray(gravity)
        self.loads = [Load(tip_force, tip_moment), *loads]
        self.bodies = [Body(tip_mass), *bodies]
        self.held = []
        self.starts = np.cumsum([0, *(segment.length for segment in self.segments)])
        ends = np.cumsum([0, *(segment.n for segment in self.segments)])
        self.dofs = [slice(start, end) for start, end in pairwise(ends)]
        self.n = ends[-1]

    def on_base(self, R, p, eta, eta_t):
        """The same rod with its base at this pose, with this body twist and rate, (6,) or (6, m)."""
        moved = copy(self)
        moved.base, moved.base_rate = np.concatenate([np.ravel(R), p, eta]), np.asarray(eta_t, float)
        return moved

    def poses(self, q, X):
        """Poses (m, 4, 4) at arc lengths X (m,), counted from the rod's base."""
        poses = np.tile(np.eye(4), (len(X), 1, 1))
        states = self.states(np.asarray(q, float), np.zeros(self.n), np.empty((self.n, 0)), X)
        for pose, (R, p, *_) in zip(poses, states, strict=True):
            pose[:3, :3], pose[:3, 3] = R, p
        return poses

    def states(self, q, qd, qdd, X):
        """R, p, eta and eta_t (6, m) at each of the arc lengths X, for m motions qdd (n, m)."""
        paths, states = self._outward(q, qd, qdd), []
        for at in X:
            i = min(np.searchsorted(self.starts, at, side="right"), len(self.segments)) - 1
            if at == self.starts[i + 1]:
                states.append(unpack(paths[i][-1]))
                continue
            rate = self._motion_rate(i, q, qd, qdd)
            states.append(unpack(integrate(rate, 0, at - self.starts[i], paths[i][0])[-1]))
        return states

    def inverse_dynamics(self, q, qd, qdd):
        """Generalised forces tau required by the motion, with the shape of qdd."""
        q, qd, motions = (
            np.asarray(q, float),
            np.asarray(qd, float),
            np.reshape(qdd, (self.n, -1)).astype(float),
        )
        tau = self._forces_of_motion(q, qd, motions) + self.elastic_forces(q, qd)[:, None]
        return tau.reshape(np.shape(qdd))

    def elastic_forces(self, q, qd):
        """K q + D qd, the generalised forces required by elasticity and damping."""
        forces = np.empty(self.n)
        for segment, dof in zip(self.segments, self.dofs, strict=True):

            def density(X, segment=segment, dof=dof):
                return segment.basis(X).T @ segment.stress(X, q[dof], qd[dof])

            forces[dof], _ = quad_vec(density, 0, segment.length, epsrel=RTOL)
        return forces

    def mass_matrix(self, q):
        """Column by column: forces for unit accelerations without gravity and loads."""
        free = copy(self)
        free.gravity, free.loads = np.zeros(3), []
        return free._forces_of_motion(np.asarray(q, float), np.zeros(self.n), np.eye(self.n))

    def forward_dynamics(self, q, qd):
        """Accelerations of the free motion."""
        return -np.linalg.solve(self.mass_matrix(q), self.inverse_dynamics(q, qd, np.zeros(self.n)))

    def energy(self, q, qd):
        """Energies in joules; the gravitational one is zero at the world's origin."""
        q, qd, none = np.asarray(q, float), np.asarray(qd, float), np.empty((self.n, 0))
        elastic, state = 0.0, np.concatenate([self.base, [0.0, 0.0, 0.0]])
        for i, segment in enumerate(self.segments):
            dof, motion_rate = self.dofs[i], self._motion_rate(i, q, qd, none)

            def strain_energy(X, segment=segment, dof=dof):
                return (segment.basis(X) @ q[dof]) @ segment.stress(X, q[dof], 0 * q[dof]) / 2

            elastic += quad_vec(strain_energy, 0, segment.length, epsrel=RTOL)[0]
            for X0, X1, spread in self._pieces(i):

                def rate(X, state, segment=segment, motion_rate=motion_rate, spread=spread):
                    R, p, eta, _ = unpack(state[:18])
                    inertia = segment.inertia(X)
                    loads = sum(load.potential(p) for load in spread)
                    weight = inertia[3, 3] * self.gravity
                    densities = [eta @ inertia @ eta / 2, -weight @ (p + R @ segment.centre), loads]
                    return np.concatenate([motion_rate(X, state[:18]), densities])

                state = integrate(rate, X0, X1, state)[-1]
                R, p, eta, _ = unpack(state[:18])
                for body in self._there(self.bodies, i, X1):
                    kinetic = eta @ body.matrix @ eta / 2
                    state[18:20] += kinetic, -body.mass * self.gravity @ (p + R @ body.centre)
                state[20] += sum(load.potential(p) for load in self._there(self.loads, i, X1))
        return Energy(state[18], elastic, state[19], state[20])

    def _there(self, things, i, X):
        """The loads or bodies at the place X > 0 of segment i."""
        at = self.starts[i] + X
        places = [self.starts[-1] if thing.at is None else thing.at for thing in things]
        spread = [getattr(thing, "along", None) is not None for thing in things]
        return [
            thing
            for thing, place, along in zip(things, places, spread, strict=True)
            if not along and np.isclose(place, at, rtol=0, atol=1e-12)
        ]

    def _pieces(self, i):
        """Smooth pieces of segment i: start, end, and the loads distributed there."""
        start, length = self.starts[i], self.segments[i].length
        places = [thing.at for thing in (*self.loads, *self.bodies, *self.held) if thing.at is not None]
        spread = [load for load in self.loads if load.along is not None]
        places += [end for load in spread for end in load.along]
        inside = [at - start for at in places if 1e-12 < at - start < length - 1e-12]
        for X0, X1 in pairwise(np.unique([0, *inside, length])):
            middle = start + (X0 + X1) / 2
            yield X0, X1, [load for load in spread if load.along[0] < middle < load.along[1]]

    def _forces_of_motion(self, q, qd, qdd):
        """Forces required by inertia, gravity, loads and attached items, (n, m)."""
        return self.balance(q, qd, qdd)[0]

    def balance(self, q, qd, qdd, through=None):
        """The result of `_forces_of_motion`, and the wrench required at the base, (6, m).

        `through` records the wrenches through the sections with items at X > 0.
        """
        m = qdd.shape[1]
        paths = self._outward(q, qd, qdd)
        # Absolute tolerances scale with the largest force of each motion: a rod may weigh a gram or a ton.
        loads = [self._load(i, 0, y, self.loads) for i, path in enumerate(paths) for y in path]
        ends = [self._at_point(i, self.segments[i].length, path[-1]) for i, path in enumerate(paths)]
        held = [thing.wrench for thing in self.held]
        largest = np.abs([*ends, *loads, *held]).max(axis=(0, 1))

        F, tau = np.zeros((6, m)), np.empty((self.n, m))
        for i, segment in reversed(list(enumerate(self.segments))):
            dof, motion_rate, size = self.dofs[i], self._motion_rate(i, q, qd, qdd), 18 + 6 * m
            scale = np.concatenate([np.ones(size), np.tile(np.where(largest > 0, largest, 1), 6 + segment.n)])
            state = np.concatenate([paths[i][-1], F.ravel(), np.zeros(segment.n * m)])
            for X0, X1, spread in reversed(list(self._pieces(i))):

                def rate(X, state, i=i, segment=segment, motion_rate=motion_rate, size=size, spread=spread):
                    y, F = state[:size], state[size : size + 6 * m].reshape(6, m)
                    B_Phi = segment.basis(X)
                    F_X = ad(self._strain(i, X, B_Phi, q)).T @ F - self._load(i, X, y, spread)
                    tau_X = -B_Phi.T @ F
                    return np.concatenate([motion_rate(X, y), F_X.ravel(), tau_X.ravel()])

                state[size : size + 6 * m] += self._at_point(i, X1, state[:size]).ravel()
                if through is not None:
                    through[self.starts[i] + X1] = state[size : size + 6 * m].reshape(6, m).copy()
                state = integrate(rate, X1, X0, state, ATOL * scale)[-1]
            F = state[size : size + 6 * m].reshape(6, m)
            tau[dof] = state[size + 6 * m :].reshape(-1, m)
        return tau, F

    def _strain(self, i, X, B_Phi, q):
        return self.segments[i].reference_strain + B_Phi @ q[self.dofs[i]]

    def _motion_rate(self, i, q, qd, qdd):
        """The outward equations of segment i."""
        segment, dof = self.segments[i], self.dofs[i]

        def rate(X, y):
            R, _, eta, eta_t = unpack(y)
            B_Phi = segment.basis(X)
            xi, xi_t, xi_tt = self._strain(i, X, B_Phi, q), B_Phi @ qd[dof], B_Phi @ qdd[dof]
            ad_xi = ad(xi)
            return np.concatenate(
                [
                    (R @ ad_xi[:3, :3]).ravel(),
                    R @ xi[3:],
                    xi_t - ad_xi @ eta,
                    (xi_tt - (ad(xi_t) @ eta)[:, None] - ad_xi @ eta_t).ravel(),
                ]
            )

        return rate

    def _outward(self, q, qd, qdd):
        """States along every segment, base to tip."""
        rates = np.broadcast_to(np.reshape(self.base_rate, (6, -1)), (6, qdd.shape[1]))
        paths, y = [], np.concatenate([self.base, rates.ravel()])
        for i, segment in enumerate(self.segments):
            paths.append(integrate(self._motion_rate(i, q, qd, qdd), 0, segment.length, y))
            y = paths[-1][-1]
        return paths

    def _load(self, i, X, y, spread):
        """Body wrench per length required by inertia, minus gravity and distributed loads, (6, m)."""
        R, _, eta, eta_t = unpack(y)
        M = self.segments[i].inertia(X)
        weight = np.concatenate([np.zeros(3), R.T @ self.gravity])
        given = sum((load.wrench(R) for load in spread), np.zeros(6))
        return M @ eta_t - (ad(eta).T @ M @ eta + M @ weight + given)[:, None]

    def _at_point(self, i, X, y):
        """Body wrench required by bodies and attached items, minus gravity and loads, (6, m)."""
        R, _, eta, eta_t = unpack(y)
        weight = np.concatenate([np.zeros(3), R.T @ self.gravity])[:, None]
        wrench = np.zeros_like(eta_t)
        for body in self._there(self.bodies, i, X):
            wrench += body.matrix @ (eta_t - weight) - (ad(eta).T @ body.matrix @ eta)[:, None]
        for load in self._there(self.loads, i, X):
            wrench -= load.wrench(R)[:, None]
        for thing in self._there(self.held, i, X):
            wrench += thing.wrench
        return wrench
