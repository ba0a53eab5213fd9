"""Forces, energies and inertia of a robot from places alone, in NumPy.

A robot is taken apart into points that are fixed to its bodies and sections; their places are `Robot.pose`.
Bodies and sections are six masses each. Loads are forces on points; elongations of springs and cords,
overlaps and strains are functions of places. All forces then follow from differences of places by virtual
work, and stiffness and inertia from differences and squares: no formula is shared with lissom.

Rotation vectors are turned by small rotations of their bodies, so that forces are true moments: those along a
rotation vector itself vanish at a full turn, whatever the moment is.
"""

from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.linalg import eigh, null_space
from scipy.spatial.transform import Rotation

#: Steps of differences of order four, in natural sizes of coordinates: of first and second derivatives, and
#: in time.
FIRST, SECOND, MOTION = 2e-3, 1e-2, 5e-3
#: Gauss points of a segment, and of a rod that touches: contact ends somewhere between them.
NODES, TOUCHING_NODES = 12, 240
#: Forces of springs are unsure by this many roundings of places, and by this part of a natural size.
ROUNDED, NEAR_REST = 1e6, 1e-4
#: Singular values of loops below this part of the largest one are redundant constraints.
REDUNDANT = 1e-8


@dataclass
class Springs:
    """Energies t s + k s^2 / 2 of elongations s; one-sided ones have none for s < 0."""

    elongations: list = field(default_factory=list)
    stiffness: list[float] = field(default_factory=list)
    tension: list[float] = field(default_factory=list)
    one_sided: list[bool] = field(default_factory=list)

    def add(self, elongation, stiffness, tension=0.0, one_sided=False) -> None:
        """`elongation` maps (k, n) coordinates and (k, N, 3) places to (k, m) elongations."""
        self.elongations.append(elongation)
        self.stiffness.extend(np.atleast_1d(stiffness))
        self.tension.extend(np.broadcast_to(tension, np.shape(np.atleast_1d(stiffness))))
        self.one_sided.extend(np.broadcast_to(one_sided, np.shape(np.atleast_1d(stiffness))))


class Points:
    """A robot as points: `recipe` says what it is made of, `model` where its parts are.

    `cut`, a link and an arc length, selects what is beyond: `beyond` says so of each point.
    """

    def __init__(self, recipe: dict, model, cut: tuple[str, float] | None = None) -> None:
        self.recipe, self.model, self.cut = recipe, model, cut
        self.links = {link["name"]: link for link in recipe["link"]}
        self.gravity = np.array(recipe["scene"]["gravity"], float)
        self.local: dict[tuple[str | None, float | None], list] = {}
        self._order: list[tuple[tuple, int]] = []
        self.sizes = self._natural_sizes()
        self.masses: list[tuple[int, float]] = []
        self.loads: list[tuple[list[int], np.ndarray, np.ndarray, bool]] = []
        self.springs = Springs()
        self.gaps: list = []
        #: Pressed points: the point, the ends of unit vectors there, radius, weighted stiffness, contact.
        self.pressed: list[tuple[list[int], float, float, dict]] = []
        #: Forces of cords and supports on points: functions of places that yield (point, force).
        self.pulls: list = []
        for link in recipe["link"]:
            self._add_link(link)
        for tendon in recipe.get("tendon", ()):
            self._add_tendon(tendon)
        for contact in recipe.get("contact", ()):
            self._add_contact(contact)
        for loop in recipe.get("loop", ()):
            self._add_loop(loop)

    # What it is made of.

    def point(self, link: str | None, at: float | None, local) -> int:
        """A point fixed to a link; the number of the point."""
        rows = self.local.setdefault((link, at), [])
        rows.append(np.array(local, float))
        self._order.append(((link, at), len(rows) - 1))
        return len(self._order) - 1

    def _mass(self, link, at, centre, mass, covariance) -> None:
        """Six points with the mass and with the second moments `covariance` about the centre."""
        moments, axes = np.linalg.eigh(covariance)
        for moment, axis in zip(moments, axes.T, strict=True):
            arm = np.sqrt(3 * max(moment, 0.0) / mass) * axis
            for sign in (-1, 1):
                self.masses.append((self.point(link, at, np.add(centre, sign * arm)), mass / 6))

    def _add_link(self, link: dict) -> None:
        name = link["name"]
        joint = link.get("joint", {"type": "weld"})
        first = self.model.slice(name).start
        if "body" in link:
            body = link["body"]
            inertia = np.array(body.get("inertia", np.zeros((3, 3))), float)
            inertia = np.diag(inertia) if inertia.ndim == 1 else inertia
            covariance = np.trace(inertia) / 2 * np.eye(3) - inertia
            self._mass(name, None, body.get("centre", (0, 0, 0)), body["mass"], covariance)
        if joint.get("stiffness"):
            self.springs.add(lambda q, _: q[:, [first]] - joint.get("rest", 0.0), joint["stiffness"])
        if "limits" in joint:
            low, high = joint["limits"]
            stops = [joint["limit_stiffness"]] * 2
            self.springs.add(
                lambda q, _: np.stack([low - q[:, first], q[:, first] - high], -1), stops, one_sided=True
            )
        if "rod" in link:
            self._add_rod(link, first + len(COORDINATES[joint["type"]]))
        for load in link.get("load", ()):
            self._add_load(name, load)
        for support in link.get("support", ()):
            self._add_support(name, support)

    def _add_rod(self, link: dict, first: int) -> None:
        start = 0.0
        for segment in link["rod"]["segment"]:
            length, radius = segment["length"], segment["radius"]
            area = np.pi * radius**2
            for X, weight in self._quadrature(link["name"], start, length, NODES):
                mass = segment["density"] * area * weight
                covariance = mass * radius**2 / 4 * np.diag([0.0, 1.0, 1.0])
                self._mass(link["name"], X, (0, 0, 0), mass, covariance)
            E = segment["young_modulus"]
            G = segment.get("shear_modulus") or E / 2 / (1 + segment["poisson_ratio"])
            bending = np.pi / 4 * radius**4
            rigidity = dict(
                zip(
                    STRAINS,
                    [2 * G * bending, E * bending, E * bending, E * area, G * area, G * area],
                    strict=True,
                )
            )
            for strain in STRAINS:
                modes = segment["modes"].get(strain, 0)
                if modes:
                    # Legendre polynomials are orthogonal: each mode is a spring of its own.
                    stiffness = rigidity[strain] * length / (2 * np.arange(modes) + 1)
                    part = slice(first, first + modes)
                    self.springs.add(lambda q, _, part=part: q[:, part], stiffness)
                    first += modes
            start += length

    def _quadrature(self, name, start, length, nodes):
        """Arc lengths and weights on a segment, divided where it is cut."""
        x, w = np.polynomial.legendre.leggauss(nodes)
        ends = [start, start + length]
        if self.cut and self.cut[0] == name and start < self.cut[1] < start + length:
            ends.insert(1, self.cut[1])
        for low, high in pairwise(ends):
            yield from zip((low + high + (high - low) * x) / 2, (high - low) / 2 * w, strict=True)

    def _add_load(self, name: str, load: dict) -> None:
        """A force, and a moment as forces on the ends of three unit vectors."""
        force, moment = (np.array(load.get(key, (0, 0, 0)), float) for key in ("force", "moment"))
        places = [(load.get("at"), 1.0)]
        if "along" in load:
            low, high = load["along"]
            x, w = np.polynomial.legendre.leggauss(NODES)
            places = list(zip((low + high + (high - low) * x) / 2, (high - low) / 2 * w, strict=True))
        for at, weight in places:
            points = [self.point(name, at, e) for e in np.vstack([np.zeros(3), np.eye(3)])]
            self.loads.append((points, weight * force, weight * moment, load.get("frame") == "body"))

    def _add_support(self, name: str, support: dict) -> None:
        anchor = np.array(support["position"], float)
        point = self.point(name, support.get("at"), (0, 0, 0))
        stiffness = np.broadcast_to(support["stiffness"], 3)
        self.springs.add(lambda _, P: P[:, point] - anchor, stiffness)
        self.pulls.append(lambda P: [(point, stiffness * (anchor - P[point]))])

    def _add_tendon(self, tendon: dict) -> None:
        points = [self.point(part.get("link"), part.get("at"), part["point"]) for part in tendon["path"]]

        def length(_, P):
            return np.linalg.norm(np.diff(P[:, points], axis=1), axis=-1).sum(-1, keepdims=True)

        rest, stiffness = tendon.get("length", 0.0), tendon.get("stiffness", 0.0)
        tension = tendon.get("tension", 0.0)
        self.springs.add(lambda q, P: length(q, P) - rest, stiffness, tension, one_sided=True)

        def pulls(P):
            ways = np.diff(P[points], axis=0)
            lengths = np.linalg.norm(ways, axis=1)
            pull = tension + stiffness * max(0.0, lengths.sum() - rest)
            for one, other, way, size in zip(points[:-1], points[1:], ways, lengths, strict=True):
                yield one, pull * way / size
                yield other, -pull * way / size

        self.pulls.append(pulls)

    def _add_contact(self, contact: dict) -> None:
        """A ball or a round rod on a half-space: each of its points within the radius is pressed out."""
        if isinstance(contact["a"], dict):
            ball = contact["a"]
            places = [(ball["link"], ball.get("at"), ball.get("position", (0, 0, 0)), ball["radius"], 1.0)]
        else:
            places, start = [], 0.0
            segments = self.links[contact["a"]]["rod"]["segment"]
            for segment in segments:
                nodes = TOUCHING_NODES // len(segments)
                for X, w in self._quadrature(contact["a"], start, segment["length"], nodes):
                    places.append((contact["a"], X, (0, 0, 0), segment["radius"], w))
                start += segment["length"]
        points = []
        for link, at, local, radius, weight in places:
            rubs = contact.get("friction", 0.0) > 0
            rows = np.add(local, np.vstack([np.zeros(3), np.eye(3)] if rubs else [np.zeros(3)]))
            numbers = [self.point(link, at, row) for row in rows]
            self.pressed.append((numbers, radius, weight * contact["stiffness"], contact))
            points.append(numbers[0])
        radii, weights = (np.array([place[i] for place in places]) for i in (3, 4))
        normal, on = _plane(contact)
        self.springs.add(
            lambda _, P: radii - (P[:, points] - on) @ normal, contact["stiffness"] * weights, one_sided=True
        )

    def _add_loop(self, loop: dict) -> None:
        kind = loop["kind"]
        frames = []
        for end in ("a", "b"):
            given = loop.get(end, {})
            turned = _rotation(given.get("orientation", (1, 0, 0, 0))).as_matrix()
            at = np.array(given.get("position", (0, 0, 0)), float)
            rows = np.vstack([at, at + turned.T])
            frames.append([self.point(given.get("link"), given.get("at"), row) for row in rows])
        a, b = frames
        if kind["type"] == "distance":
            self.gaps.append(
                lambda P: np.linalg.norm(P[:, a[0]] - P[:, b[0]], axis=-1, keepdims=True) - kind["length"]
            )
            return
        self.gaps.append(lambda P: P[:, a[0]] - P[:, b[0]])
        if kind["type"] == "spherical":
            return

        def axes(P, frame):
            return P[:, frame[1:]] - P[:, frame[:1]]

        if kind["type"] == "weld":
            self.gaps.append(lambda P: sum(np.cross(axes(P, a)[:, i], axes(P, b)[:, i]) for i in range(3)))
        if kind["type"] == "revolute":
            axis = np.array(kind["axis"], float) / np.linalg.norm(kind["axis"])
            self.gaps.append(lambda P: np.cross(axis @ axes(P, a), axis @ axes(P, b)))

    # Where it is.

    def positions(self, q: np.ndarray) -> np.ndarray:
        """Places of all points, (k, N, 3), for (k, n) coordinates."""
        q = np.atleast_2d(q)
        by_link: dict = {}
        for link, at in self.local:
            by_link.setdefault(link, []).append(at)
        found = {}
        for link, places in by_link.items():
            if link is None:
                found[link, None] = np.broadcast_to(
                    self.local[link, None], (len(q), len(self.local[link, None]), 3)
                )
                continue
            along = [at for at in places if at is not None]
            poses = {}
            if along:
                stacked = self.model.pose(q, along, link=link)
                poses = {at: stacked[:, i] for i, at in enumerate(along)}
            if None in places:
                poses[None] = self.model.pose(q, link=link)
            for at, pose in poses.items():
                rows = np.array(self.local[link, at])
                found[link, at] = pose[:, None, :3, 3] + rows @ np.swapaxes(pose[:, :3, :3], 1, 2)
        starts = dict(zip(self.local, np.cumsum([0, *map(len, self.local.values())]), strict=False))
        order = [starts[place] + i for place, i in self._order]
        return np.concatenate([found[place] for place in self.local], axis=1)[:, order]

    def all_springs(self, q: np.ndarray, P: np.ndarray) -> np.ndarray:
        parts = [elongation(q, P) for elongation in self.springs.elongations]
        return np.concatenate(parts, axis=1) if parts else np.zeros((len(q), 0))

    def all_gaps(self, P: np.ndarray) -> np.ndarray:
        parts = [gap(P) for gap in self.gaps]
        return np.concatenate(parts, axis=1) if parts else np.zeros((len(P), 0))

    # Charts.

    @cached_property
    def turns(self) -> list[int]:
        """First coordinates of rotation vectors."""
        return [i for i, name in enumerate(self.model.coordinates) if name.endswith(".rotation_x")]

    def _natural_sizes(self) -> np.ndarray:
        """A radian, for a whole rod; a length of the link that is moved; a tenth of stretch and shear."""
        sizes = []
        for name, _, kind in plan(self.recipe):
            link = self.links[name]
            body = link.get("body", {"mass": 1.0})
            lengths = [sum(part["length"] for part in link.get("rod", {}).get("segment", ()))]
            lengths.append(np.sqrt(np.sum(np.abs(body.get("inertia", 0.0))) / body["mass"]))
            lengths.append(np.linalg.norm(link.get("position", 0.0)))
            length = next((each for each in lengths if each > 0), 1.0)
            sizes.append({"angle": 1.0, "shift": length, "curvature": 1 / length, "strain": 0.1}[kind])
        return np.array(sizes)

    def moved(self, q: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Coordinates after (k, n) small motions: rotation vectors are followed by rotations."""
        found = q + x
        for i in self.turns:
            part = slice(i, i + 3)
            found[:, part] = (Rotation.from_rotvec(q[part]) * Rotation.from_rotvec(x[:, part])).as_rotvec()
        return found

    def differences(self, q: np.ndarray, turned: bool = True):
        """Derivatives of places (n, N, 3), elongations (n, S) and gaps (n, G), of order four."""
        n = self.model.n
        steps = np.diag(FIRST * self.sizes)
        x = np.concatenate([steps, -steps, 2 * steps, -2 * steps])
        states = self.moved(q, x) if turned else q + x
        P = self.positions(states)

        def slope(values):
            up, down, up2, down2 = values.reshape(4, n, *values.shape[1:])
            h = (FIRST * self.sizes).reshape(n, *[1] * (values.ndim - 1))
            return (8 * (up - down) - (up2 - down2)) / (12 * h)

        return slope(P), slope(self.all_springs(states, P)), slope(self.all_gaps(P))

    def motion(self, q: np.ndarray, v: np.ndarray, a: np.ndarray):
        """Places, velocities and accelerations of all points, (N, 3), by differences in time."""
        rate = np.abs(v / self.sizes).max(initial=0.0) + np.sqrt(np.abs(a / self.sizes).max(initial=0.0))
        h = MOTION / max(float(rate), 1e-3)
        t = h * np.arange(-2.0, 3.0)[:, None]
        P = self.positions(q + v * t + a * t**2 / 2)
        speeds = (8 * (P[3] - P[1]) - (P[4] - P[0])) / (12 * h)
        return P[2], speeds, (16 * (P[3] + P[1]) - (P[4] + P[0]) - 30 * P[2]) / (12 * h**2)

    # Forces.

    def forces(self, P: np.ndarray) -> np.ndarray:
        """Forces of weight and loads on all points, (N, 3), at places (N, 3)."""
        found = np.zeros_like(P)
        for point, mass in self.masses:
            found[point] += mass * self.gravity
        for points, force, moment, follows in self.loads:
            axes = P[points[1:]] - P[points[0]]
            if follows:
                force, moment = force @ axes, moment @ axes
            found[points[0]] += force
            arms = np.cross(moment, axes) / 2
            for point, arm in zip(points[1:], arms, strict=True):
                found[point] += arm
                found[points[0]] -= arm
        return found

    def cord_forces(self, P: np.ndarray) -> np.ndarray:
        """Forces of cords and supports on all points."""
        found = np.zeros_like(P)
        for pulls in self.pulls:
            for point, force in pulls(P):
                found[point] += force
        return found

    def contact_forces(self, P: np.ndarray, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places and forces of contact, pressure of Hunt and Crossley (1975) and smoothed dry friction."""
        places, forces = np.zeros((2, len(self.pressed), 3))
        for i, (numbers, radius, stiffness, contact) in enumerate(self.pressed):
            normal, on = _plane(contact)
            at, speed = P[numbers[0]], speeds[numbers[0]]
            overlap = radius - normal @ (at - on)
            pressure = stiffness * max(overlap, 0.0)
            pressure *= max(0.0, 1 - contact.get("dissipation", 1.0) * normal @ speed)
            places[i], forces[i] = at - radius * normal, pressure * normal
            if len(numbers) > 1:
                arms = (P[numbers[1:]] - at) @ (-radius * normal)
                slides = speed + arms @ (speeds[numbers[1:]] - speed)
                slides = slides - normal * (normal @ slides)
                smooth = np.hypot(np.linalg.norm(slides), contact.get("slip_velocity", 1e-4))
                forces[i] -= contact["friction"] * pressure * slides / smooth
        return places, forces

    def beyond(self, link: str, X: float) -> np.ndarray:
        """Which points are beyond a section of a rod: on it, or on links that it carries there."""

        def is_beyond(name, at):
            while name is not None:
                if name == link:
                    return at is None or at > X
                name, at = self.links[name].get("parent"), self.links[name].get("at")
            return False

        return np.array([is_beyond(*place) for place, _ in self._order], bool)

    def spring_forces(self, s: np.ndarray) -> np.ndarray:
        """Forces of springs at elongations s."""
        pull = np.array(self.springs.tension) + np.array(self.springs.stiffness) * s
        return np.where(np.array(self.springs.one_sided, bool) & (s < 0), 0.0, pull)

    def balance(self, q: np.ndarray) -> "Balance":
        """What is left of the forces on a robot at rest."""
        q = np.array(q, float)
        P = self.positions(q)[0]
        dP, ds, dg = self.differences(q)
        forces, pulls = self.forces(P), self.spring_forces(self.all_springs(q[None], P[None])[0])
        left = ds @ pulls - np.einsum("inc,nc->i", dP, forces)
        strength = np.abs(ds) @ np.abs(pulls)
        strength += np.linalg.norm(dP, axis=-1) @ np.linalg.norm(forces, axis=-1)
        strength += self._unsure(P, ds)
        multipliers = np.zeros(dg.shape[1])
        if dg.shape[1]:
            rows = self.sizes[:, None]
            multipliers = -np.linalg.lstsq(rows * dg, rows[:, 0] * left, rcond=REDUNDANT)[0]
            left = left + dg @ multipliers
            strength += np.abs(dg) @ np.abs(multipliers)
        for i in self.turns:
            strength[i : i + 3] = strength[i : i + 3].max()
        return Balance(self, q, P, dP, ds, dg, forces, pulls, multipliers, left, strength)

    def _unsure(self, P: np.ndarray, ds: np.ndarray) -> np.ndarray:
        """Forces of springs over what rounds their elongations, and over what ends an iteration near rest."""
        k, one_sided = np.array(self.springs.stiffness), np.array(self.springs.one_sided, bool)
        rounded = np.finfo(float).eps * np.abs(P).max(initial=0.0)
        near = np.where(
            one_sided, 0.0, NEAR_REST * (np.abs(ds) * self.sizes[:, None]).max(axis=0, initial=0.0)
        )
        return np.abs(ds) @ (k * (ROUNDED * rounded + near))


@dataclass
class Balance:
    """Forces on a robot at rest, and their derivatives."""

    points: Points
    q: np.ndarray
    P: np.ndarray
    dP: np.ndarray
    ds: np.ndarray
    dg: np.ndarray
    forces: np.ndarray
    pulls: np.ndarray
    multipliers: np.ndarray
    left: np.ndarray
    #: What the forces along each coordinate could do.
    strength: np.ndarray

    @property
    def error(self) -> float:
        """The largest part of the forces that nothing balances, relative to the forces."""
        return float(np.max(np.abs(self.left) / np.maximum(self.strength, 1e-300), initial=0.0))

    @property
    def open(self) -> float:
        """The largest gap of a loop."""
        return float(np.abs(self.points.all_gaps(self.P[None])).max(initial=0.0))

    @property
    def mass(self) -> np.ndarray:
        """Inertia for the small motions of `moved`."""
        numbers, masses = zip(*self.points.masses, strict=True)
        J = self.dP[:, list(numbers)] * np.sqrt(masses)[:, None]
        return np.einsum("inc,jnc->ij", J, J)

    def curvatures(self, directions: np.ndarray):
        """Second derivatives of places, elongations and gaps along (k, n) directions."""
        h = SECOND / np.abs(directions / self.points.sizes).max(axis=1)
        x = np.concatenate([factor * h[:, None] * directions for factor in (1, -1, 2, -2)])
        states = self.points.moved(self.q, np.vstack([x, np.zeros_like(self.q)]))
        P = self.points.positions(states)

        def second(values):
            up, down, up2, down2 = values[:-1].reshape(4, len(h), *values.shape[1:])
            step = (h**2).reshape(-1, *[1] * (values.ndim - 1))
            return (16 * (up + down) - (up2 + down2) - 30 * values[-1]) / (12 * step)

        return second(P), second(self.points.all_springs(states, P)), second(self.points.all_gaps(P))

    @property
    def active(self) -> np.ndarray:
        """Stiffness of the springs that are stretched."""
        springs = self.points.springs
        return np.array(springs.stiffness) * ((self.pulls != 0) | ~np.array(springs.one_sided, bool))

    def stiffness(self, basis: np.ndarray) -> np.ndarray:
        """Stiffness in the columns of a basis: squares of stretched springs, differences of frozen forces."""
        m = basis.shape[1]
        stretch = np.sqrt(self.active)[:, None] * (self.ds.T @ basis)
        found = stretch.T @ stretch
        i, j = np.triu_indices(m)
        sums = (basis[:, i] + basis[:, j]).T
        apart = i != j
        second = np.zeros((2, len(i)))
        second[0] = self._frozen(sums)
        second[1, apart] = self._frozen((basis[:, i] - basis[:, j]).T[apart])
        found[i, j] += (second[0] - second[1]) / 4
        found[j, i] = found[i, j]
        return found

    def _frozen(self, directions: np.ndarray) -> np.ndarray:
        """Second derivatives along directions of the potential that has the present forces everywhere."""
        if not len(directions):
            return np.zeros(0)
        P, s, g = self.curvatures(directions)
        return s @ self.pulls - np.einsum("knc,nc->k", P, self.forces) + g @ self.multipliers

    def resistance(self, direction: np.ndarray) -> tuple[float, float]:
        """Second derivative of the energy along a direction, and the sum of the sizes of its parts."""
        P, s, g = (part[0] for part in self.curvatures(direction[None]))
        squares = self.active @ (direction @ self.ds) ** 2
        parts = [squares, s * self.pulls, -np.sum(P * self.forces, axis=1), g * self.multipliers]
        # What forces of this strength resist, if they turn with what they act on.
        size = self.strength @ np.abs(direction) * np.abs(direction / self.points.sizes).max()
        return sum(map(np.sum, parts)), size + sum(np.abs(part).sum() for part in parts)

    def eigenpairs(self) -> tuple[np.ndarray, np.ndarray]:
        """Squares of angular frequencies, ascending, and their motions in columns."""
        basis = self.free()
        K, M = self.stiffness(basis), basis.T @ self.mass @ basis
        if not basis.shape[1]:
            return np.zeros(0), basis
        lowest = eigh(K, M, eigvals_only=True)[0]
        # The inverse keeps the digits of slow motions beside stiff ones.
        shift = max(-2 * lowest, 1e-3 * np.median(np.diag(K) / np.diag(M)).clip(0), 1e-300)
        try:
            inverse, motions = eigh(M, K + shift * M)
        except np.linalg.LinAlgError:
            values, motions = eigh(K, M)
            return values, basis @ motions
        return (1 / inverse - shift)[::-1], basis @ motions[:, ::-1]

    def free(self) -> np.ndarray:
        """A basis of the motions that keep loops closed, in natural sizes."""
        sizes = np.diag(self.points.sizes)
        if not self.dg.shape[1]:
            return sizes
        rows = (sizes @ self.dg).T
        scale = np.linalg.norm(rows, axis=1, keepdims=True)
        return sizes @ null_space(rows / np.maximum(scale, 1e-300), rcond=REDUNDANT)


#: Coordinates of joints.
COORDINATES = {
    "weld": (),
    "revolute": ("angle",),
    "prismatic": ("shift",),
    "screw": ("angle",),
    "cylindrical": ("shift", "angle"),
    "universal": ("angle", "angle"),
    "planar": ("shift", "shift", "angle"),
    "spherical": ("angle",) * 3,
    "free": ("shift",) * 3 + ("angle",) * 3,
}
STRAINS = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")


def plan(recipe: dict) -> list[tuple[str, int, str]]:
    """Link, number within the link and kind of all coordinates: angle, shift, curvature or strain."""
    found = []
    for link in recipe["link"]:
        joint = link.get("joint", {"type": "weld"})["type"]
        kinds = list(COORDINATES[joint])
        for segment in link.get("rod", {}).get("segment", ()):
            for number, strain in enumerate(STRAINS):
                kinds += ["curvature" if number < 3 else "strain"] * segment["modes"].get(strain, 0)
        found += [(link["name"], number, kind) for number, kind in enumerate(kinds)]
    return found


def _rotation(quaternion) -> Rotation:
    return Rotation.from_quat(np.roll(quaternion, -1))


def _plane(contact: dict) -> tuple[np.ndarray, np.ndarray]:
    """Outward normal and a point of the half-space of a contact."""
    plane = contact["b"]
    normal = np.array(plane.get("normal", (0, 0, 1)), float)
    return normal / np.linalg.norm(normal), np.array(plane.get("point", (0, 0, 0)), float)
