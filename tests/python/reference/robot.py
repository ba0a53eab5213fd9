"""Trees of rods and rigid bodies: Newton-Euler equations in body frames, link by link.

A frame at (R, p) in the axes of another frame, which moves relative to it with the body twist s, has

    eta = Ad eta_0 + s,   eta_t = Ad eta_t0 - ad_s Ad eta_0 + s_t,   Ad = [[R^T, 0], [-R^T p^, R^T]]

where eta_0 is the twist of the other frame, to which the frame transmits the wrench F as Ad^T F. A rigid body
requires M eta_t - ad_eta^T M eta minus weight and loads. A rod is that of `rod`; wrenches of attached links
act at its places. Generalised forces of a joint are S^T F.

Twists and wrenches have the angular part first. Accelerations may be (n,) or (n, m) for m motions from one
state. Robots can be described by dictionaries of plain values, see `build`.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from reference import rod
from reference.joint import Joint, Weld
from reference.rod import Energy, Held, Section, Segment, ad, hat


@dataclass(frozen=True)
class Load(rod.Load):
    """A load on a link; for a rigid body in its frame."""

    link: str = field(kw_only=True)


@dataclass(frozen=True)
class Body(rod.Body):
    """A rigid body: that of a link, or an additional one on a named link."""

    link: str | None = field(default=None, kw_only=True)


@dataclass(frozen=True)
class Link:
    """A joint followed by a rod, a rigid body, or only a frame."""

    name: str
    _: KW_ONLY
    rod: Sequence[Segment] | None = None
    body: Body | None = None
    joint: Joint = Weld()  # noqa: RUF009
    parent: str | None = None
    at: float | None = None
    position: Sequence[float] = (0, 0, 0)
    orientation: Sequence[float] = (1, 0, 0, 0)


class State(NamedTuple):
    """A frame: pose R, p, body twist eta (6,) and its rates eta_t (6, m)."""

    R: np.ndarray
    p: np.ndarray
    eta: np.ndarray
    eta_t: np.ndarray

    def weight(self, gravity):
        """Gravity as the rate of a twist in the axes of the frame, (6,)."""
        return np.concatenate([np.zeros(3), self.R.T @ gravity])


class Step(NamedTuple):
    """From one frame to another: the relative pose, body twist and its rates."""

    R: np.ndarray
    p: np.ndarray
    twist: np.ndarray
    twist_t: np.ndarray

    @property
    def adjoint(self):
        """Transforms twists from the axes of the first frame to those of the second, (6, 6)."""
        return np.block([[self.R.T, np.zeros((3, 3))], [-self.R.T @ hat(self.p), self.R.T]])

    def taken_from(self, state):
        carried = self.adjoint @ state.eta
        rates = self.adjoint @ state.eta_t - (ad(self.twist) @ carried)[:, None] + self.twist_t
        return State(state.R @ self.R, state.p + state.R @ self.p, carried + self.twist, rates)


class Momentum(NamedTuple):
    """Mass, first moment m p, linear momentum and angular momentum about the world's origin, in the world."""

    mass: float
    first: np.ndarray
    linear: np.ndarray
    angular: np.ndarray

    @staticmethod
    def of(inertia, centre, R, p, eta):
        """Momentum of a body with the spatial inertia (6, 6) in a section with rotation R at p."""
        moment, linear = np.reshape(inertia @ eta, (2, 3)) @ R.T
        mass = inertia[5, 5]
        return Momentum(mass, mass * (p + R @ centre), linear, moment + np.cross(p, linear))

    def flat(self):
        return np.concatenate([[self.mass], self.first, self.linear, self.angular])

    @staticmethod
    def from_flat(values):
        return Momentum(values[0], *np.split(values[1:], 3))


class RigidBody:
    """Bodies and loads in one frame, with the methods of a rod."""

    n = 0
    length = None

    def __init__(self, gravity, loads, bodies):
        self.gravity, self.loads, self.bodies = np.asarray(gravity, float), loads, bodies

    def state(self, base, q, v, a, X):
        return base

    def balance(self, base, q, v, a, held):
        F = np.zeros_like(base.eta_t)
        for body in self.bodies:
            F += body.matrix @ (base.eta_t - base.weight(self.gravity)[:, None])
            F -= (ad(base.eta).T @ body.matrix @ base.eta)[:, None]
        for load in self.loads:
            F -= load.wrench(base.R)[:, None]
        return np.zeros((0, F.shape[1])), F + sum(wrench for _, wrench in held)

    def elastic_forces(self, q, v):
        return np.zeros(0)

    def energy(self, base, q, v):
        kinetic = sum(base.eta @ body.matrix @ base.eta / 2 for body in self.bodies)
        height = sum(body.mass * self.gravity @ (base.p + base.R @ body.centre) for body in self.bodies)
        return Energy(kinetic, 0.0, -height, sum(load.potential(base.p) for load in self.loads))

    def momentum(self, base, q, v):
        flat = np.zeros(10)
        for body in self.bodies:
            flat += Momentum.of(body.matrix, np.array(body.centre), base.R, base.p, base.eta).flat()
        return flat


class Limb:
    """The rod of a link."""

    def __init__(self, segments, gravity, loads, bodies):
        self.rod = rod.Rod(segments, gravity=gravity, loads=loads, bodies=bodies)
        self.n, self.length = int(self.rod.n), self.rod.starts[-1]

    def state(self, base, q, v, a, X):
        """The section at the arc length X; None for the tip."""
        [state] = self.rod.on_base(*base).states(q, v, a, [self.length if X is None else X])
        return State(*state)

    def through(self, X, base, q, v, a, held):
        """The wrench transmitted through the section at X > 0, (6, m)."""
        moved, found = self.rod.on_base(*base), {}
        # An item with zero wrench makes X one of the places.
        moved.held = [Held(at, wrench) for at, wrench in [*held, (X, np.zeros((6, a.shape[1])))] if at != 0]
        moved.balance(q, v, a, found)
        return found[min(found, key=lambda place: abs(place - X))]

    def balance(self, base, q, v, a, held):
        """Forces (n, m), without elastic ones, and the wrench at the base, (6, m).

        `held` are pairs of an arc length and the wrench of what is attached there.
        """
        moved = self.rod.on_base(*base)
        moved.held = [Held(at, wrench) for at, wrench in held if at != 0]
        forces, F = moved.balance(q, v, a)
        return forces, F + sum(wrench for at, wrench in held if at == 0)

    def elastic_forces(self, q, v):
        return self.rod.elastic_forces(q, v)

    def energy(self, base, q, v):
        return self.rod.on_base(base.R, base.p, base.eta, np.zeros(6)).energy(q, v)

    def momentum(self, base, q, v):
        moved, none = self.rod.on_base(base.R, base.p, base.eta, np.zeros(6)), np.empty((self.n, 0))
        state = np.concatenate([moved.base, np.zeros(10)])
        for i, segment in enumerate(moved.segments):
            motion_rate = moved._motion_rate(i, q, v, none)

            def rate(X, state, segment=segment, motion_rate=motion_rate):
                R, p, eta, _ = rod.unpack(state[:18])
                density = Momentum.of(segment.inertia(X), segment.centre, R, p, eta)
                return np.concatenate([motion_rate(X, state[:18]), density.flat()])

            for X0, X1, _ in moved._pieces(i):
                state = rod.integrate(rate, X0, X1, state)[-1]
                R, p, eta, _ = rod.unpack(state[:18])
                for body in moved._there(moved.bodies, i, X1):
                    state[18:] += Momentum.of(body.matrix, np.array(body.centre), R, p, eta).flat()
        return state[18:]


class Robot:
    """Links in order, parents first. Coordinates by link: those of the joint, then those of the rod."""

    def __init__(
        self,
        links: Iterable[Link],
        *,
        gravity: Sequence[float] = (0, 0, -9.81),
        loads: Sequence[Load] = (),
        bodies: Sequence[Body] = (),
    ):
        self.links = list(links)
        self.names = [link.name for link in self.links]
        self.parents = [
            None if link.parent is None else self.names.index(link.parent, 0, i)
            for i, link in enumerate(self.links)
        ]
        self.gravity, self.loads, self.bodies = np.asarray(gravity, float), list(loads), list(bodies)
        self.parts = [self._part(link) for link in self.links]
        self.joint_dofs, self.rod_dofs, self.n = [], [], 0
        for link, part in zip(self.links, self.parts, strict=True):
            middle, end = self.n + link.joint.n, self.n + link.joint.n + part.n
            self.joint_dofs.append(slice(self.n, middle))
            self.rod_dofs.append(slice(middle, end))
            self.n = end

    def _part(self, link):
        loads = [load for load in self.loads if load.link == link.name]
        bodies = [body for body in self.bodies if body.link == link.name]
        if link.rod is not None:
            return Limb(link.rod, self.gravity, loads, bodies)
        return RigidBody(self.gravity, loads, bodies if link.body is None else [link.body, *bodies])

    def slice(self, link):
        """The coordinates of a link, those of its joint first."""
        i = self.names.index(link)
        return slice(self.joint_dofs[i].start, self.rod_dofs[i].stop)

    def length(self, link):
        """The length of a link's rod; None for a body."""
        return self.parts[self.names.index(link)].length

    # Motion

    def _step(self, link, q, v, a):
        """From the place on the parent to the base of the link."""
        w, x, y, z = link.orientation
        placed = Rotation.from_quat([x, y, z, w]).as_matrix()
        R, p = link.joint.motion(q)
        return Step(placed @ R, np.asarray(link.position, float) + placed @ p, *link.joint.twist(q, v, a))

    def _outward(self, q, v, a):
        """The relative motion of every link, and the state of its base."""
        steps, bases = [], []
        world = State(np.eye(3), np.zeros(3), np.zeros(6), np.zeros((6, a.shape[1])))
        for link, parent, dofs in zip(self.links, self.parents, self.joint_dofs, strict=True):
            steps.append(self._step(link, q[dofs], v[dofs], a[dofs]))
            place = world if parent is None else self._place(parent, bases[parent], q, v, a, link.at)
            bases.append(steps[-1].taken_from(place))
        return steps, bases

    def _place(self, i, base, q, v, a, X):
        dofs = self.rod_dofs[i]
        return self.parts[i].state(base, q[dofs], v[dofs], a[dofs], X)

    def state(self, q, v, a, *, link, X=None):
        """The state of a section, or of the frame of a body, for given accelerations (n, m)."""
        q, v, a = np.asarray(q, float), np.asarray(v, float), np.asarray(a, float)
        i = self.names.index(link)
        return self._place(i, self._outward(q, v, a)[1][i], q, v, a, X)

    def pose(self, q, X=None, *, link):
        """Pose (4, 4) of the section at the arc length X, None for the tip, or of the frame of a body."""
        R, p, *_ = self.state(q, np.zeros(self.n), np.empty((self.n, 0)), link=link, X=X)
        return np.block([[R, p[:, None]], [np.zeros(3), 1.0]])

    def velocity(self, q, v, X=None, *, link):
        """Angular velocity and velocity of this frame in world axes, (6,)."""
        R, _, eta, _ = self.state(q, v, np.empty((self.n, 0)), link=link, X=X)
        return np.concatenate([R @ eta[:3], R @ eta[3:]])

    def acceleration(self, q, v, a, X=None, *, link):
        """Angular acceleration and acceleration of this frame in world axes, (6,)."""
        R, _, eta, eta_t = self.state(q, v, np.reshape(a, (self.n, 1)), link=link, X=X)
        angular, linear = np.reshape(eta_t, (2, 3))
        return np.concatenate([R @ angular, R @ (linear + np.cross(eta[:3], eta[3:]))])

    def wrap(self, q, v, a):
        """The same motion with rotation vectors of at most pi."""
        q, v, a = np.array([q, v, a], float)
        for link, dofs in zip(self.links, self.joint_dofs, strict=True):
            q[dofs], v[dofs], a[dofs] = link.joint.wrapped(q[dofs], v[dofs], a[dofs])
        return q, v, a

    # Forces

    def inverse_dynamics(self, q, v, a):
        """Generalised forces tau required by the motion, with the shape of a."""
        q, v, motions = np.asarray(q, float), np.asarray(v, float), np.reshape(a, (self.n, -1)).astype(float)
        tau = self._forces_of_motion(q, v, motions)
        for link, part, joint_dofs, rod_dofs in self._links():
            tau[rod_dofs] += part.elastic_forces(q[rod_dofs], v[rod_dofs])[:, None]
            tau[joint_dofs] += link.joint.force(q[joint_dofs], v[joint_dofs], motions[joint_dofs])
        return tau.reshape(np.shape(a))

    def mass_matrix(self, q):
        """Column by column: forces for unit accelerations without gravity, loads and springs."""
        inertia = self._unloaded()._forces_of_motion(np.asarray(q, float), np.zeros(self.n), np.eye(self.n))
        for link, _, dofs, _ in self._links():
            inertia[dofs, dofs] += link.joint.armature * np.eye(link.joint.n)
        return inertia

    def forward_dynamics(self, q, v):
        """Accelerations of the free motion."""
        return -np.linalg.solve(self.mass_matrix(q), self.inverse_dynamics(q, v, np.zeros(self.n)))

    def _links(self):
        return zip(self.links, self.parts, self.joint_dofs, self.rod_dofs, strict=True)

    def _unloaded(self):
        return Robot(self.links, gravity=np.zeros(3), bodies=self.bodies)

    def internal_wrench(self, q, v, a, X, *, link):
        """Wrench through the section of a rod at X > 0 on the part beyond it, in the section's axes."""
        through = (link, X)
        return self._forces_of_motion(
            np.asarray(q, float), np.asarray(v, float), np.reshape(a, (self.n, 1)), through
        )[:, 0]

    def _forces_of_motion(self, q, v, a, through=(None, None)):
        """Forces required by inertia, gravity and loads, (n, m); or the wrench through a section, (6, m)."""
        steps, bases = self._outward(q, v, a)
        tau, held = np.zeros_like(a), [[] for _ in self.links]
        for i, (link, part, joint_dofs, dofs) in reversed(list(enumerate(self._links()))):
            if link.name == through[0]:
                return part.through(through[1], bases[i], q[dofs], v[dofs], a[dofs], held[i])
            tau[dofs], F = part.balance(bases[i], q[dofs], v[dofs], a[dofs], held[i])
            tau[joint_dofs] = link.joint.jacobian(q[joint_dofs]).T @ F
            if self.parents[i] is not None:
                held[self.parents[i]].append((link.at, steps[i].adjoint.T @ F))
        return tau

    # Sums over the links

    def energy(self, q, v):
        """Energies in joules; the gravitational one is zero at the world's origin."""
        q, v = np.asarray(q, float), np.asarray(v, float)
        _, bases = self._outward(q, v, np.empty((self.n, 0)))
        total = np.zeros(4)
        for base, (link, part, joint_dofs, dofs) in zip(bases, self._links(), strict=True):
            total += part.energy(base, q[dofs], v[dofs])
            total[0] += link.joint.armature * np.sum(v[joint_dofs] ** 2) / 2
            total[1] += link.joint.stiffness * np.sum((q[joint_dofs] - link.joint.rest) ** 2) / 2
        return Energy(*total)

    def momentum(self, q, v):
        """`Momentum` of all links."""
        q, v = np.asarray(q, float), np.asarray(v, float)
        _, bases = self._outward(q, v, np.empty((self.n, 0)))
        total = np.zeros(10)
        for base, (_, part, _, dofs) in zip(bases, self._links(), strict=True):
            total += part.momentum(base, q[dofs], v[dofs])
        return Momentum.from_flat(total)

    def centre_of_mass(self, q):
        """Position in the world, (3,)."""
        momentum = self.momentum(q, np.zeros(self.n))
        return momentum.first / momentum.mass


#: Classes for building a robot; `lissom` has the same names.
PARTS = SimpleNamespace(
    Robot=Robot,
    Link=Link,
    Load=Load,
    Body=Body,
    Segment=Segment,
    Section=Section,
    **{kind.__name__: kind for kind in Joint.__subclasses__()},
)


def build(description: Mapping, package=PARTS):
    """The robot of a description, built by this reference or by another package with the same class names.

    A description contains the arguments as plain values, like a scene file:

        {"gravity": [...],
         "links": [{"name": ..., "joint": {"type": "revolute", "axis": [...], ...},
                    "rod": [segment, ...] or "body": {"mass": ..., ...},
                    "parent": ..., "at": ..., "position": [...], "orientation": [w, x, y, z]}, ...],
         "loads": [{"link": ..., "force": [...], ...}], "bodies": [{"link": ..., "mass": ..., ...}]}

    Missing entries have their defaults. A segment has the arguments of `lissom.Segment`, a section of another
    shape {"shape": "rectangle", "width": ..., ...}.
    """

    def segment(arguments):
        if "section" not in arguments:
            return package.Segment(**arguments)
        shape = dict(arguments["section"])
        section = getattr(package.Section, shape.pop("shape"))(**shape)
        return package.Segment(**arguments | {"section": section})

    def joint_of(arguments):
        arguments = dict(arguments)
        return getattr(package, arguments.pop("type").capitalize())(**arguments)

    def link(arguments):
        made = dict(arguments)
        if "joint" in made:
            made["joint"] = joint_of(made["joint"])
        if "rod" in made:
            made["rod"] = [segment(each) for each in made["rod"]]
        if "body" in made:
            made["body"] = package.Body(**made["body"])
        return package.Link(made.pop("name"), **made)

    made = dict(description)
    links = [link(each) for each in made.pop("links")]
    for kind, key in ((package.Load, "loads"), (package.Body, "bodies")):
        made[key] = [kind(**each) for each in made.get(key, ())]
    return package.Robot(links, **made)
