"""Independent actuators from their geometry in space: cables are curves, chambers are solids.

Points are attached to sections of `robot.Robot`. Adaptive integration gives the poses of the sections, and
their velocities for a unit rate of each coordinate. Between places with possible kinks, a curve is the
Chebyshev polynomial through its points p(X):

    length = sum int |p'| dX,   d length/dq = int t . (dp/dq)' dX,   turned angle = int |p' x p''| / |p'|^2 dX

A chamber is the solid swept by a disc of its area. V is one third of the flux of x through its surface, and
dV/dq the flux of dx/dq (Gauss, Reynolds). An active strain is the difference of two elastic energies. Unlike
the code under test, this one uses neither strains nor slopes in the axes of sections.

Signals are plain numbers here. Classes have the names and arguments of those in `lissom`.
"""

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev
from scipy.integrate import cumulative_simpson, quad, simpson
from scipy.interpolate import PchipInterpolator

from reference.robot import Robot
from reference.rod import STRAINS, hat, integrate, unpack

#: Number of points for the polynomial of a smooth piece of a curve.
POINTS = 25
NODES = -np.cos(np.pi * np.arange(POINTS) / (POINTS - 1))
#: Number of points for Simpson's rule on a piece: a kink of |p' x p''| causes an error of second order.
PLACES = 2001
#: Number of points around a disc: the trapezoidal rule is exact for these trigonometric polynomials.
AROUND = 16


@dataclass(frozen=True)
class Along:
    """A part embedded in the rod of a link, with `offset` (y, z) from its axis."""

    link: str
    offset: Sequence = (0.0, 0.0)
    along: Sequence[float] | None = None


@dataclass(frozen=True)
class Via:
    """A point of a link, or of the world."""

    link: str | None
    point: Sequence[float] = (0.0, 0.0, 0.0)
    at: float | None = None


@dataclass(frozen=True)
class Tendon:
    """A cable along a path, pulled at the start of the path."""

    name: str
    path: Sequence
    _: KW_ONLY
    tension: float | None = None
    length: float | None = None
    stiffness: float | None = None
    damping: float = 0.0
    friction: float = 0.0
    friction_velocity: float = 1e-3
    sliding: float | None = None


@dataclass(frozen=True)
class Chamber:
    """A volume with constant cross-section in the axes of the sections."""

    name: str
    path: Sequence[Along]
    area: float
    pressure: float = 0.0


@dataclass(frozen=True)
class Motor:
    """A torque about a joint with one coordinate, or a servo, without limits."""

    joint: str
    torque: float | None = None
    _: KW_ONLY
    position: float | None = None
    gains: Sequence[float] | None = None


@dataclass(frozen=True)
class ActiveStrain:
    """A reference strain `amount` times `shape`, in addition to that of the segments."""

    link: str
    strain: str
    shape: object = 1.0
    amount: float = 0.0


def profile(values, start, end) -> tuple[Callable[[float], float], list[float]]:
    """A function from a number, a pair (start, end), a table or a callable; and its possible kinks."""
    if callable(values):
        return values, []
    if np.ndim(values) == 0:
        return lambda X: float(values), []
    first, second = values
    if np.ndim(first) == 0:
        return lambda X: first + (second - first) * (X - start) / (end - start), []
    return PchipInterpolator(first, second), list(first)


class Curve:
    """A smooth piece of a curve, from its points (POINTS, 3) and their gradients (POINTS, 3, n)."""

    def __init__(self, points, gradients):
        self.place = np.linspace(-1, 1, PLACES)
        self.first, self.last = (points[0], gradients[0]), (points[-1], gradients[-1])
        slope = chebyshev.chebder(fitted(points))
        self.slope = chebyshev.chebval(self.place, slope).T
        self.bend = chebyshev.chebval(self.place, chebyshev.chebder(slope)).T
        self.gradients = gradients

    @cached_property
    def speed(self):
        return np.linalg.norm(self.slope, axis=1)

    @property
    def length(self):
        return simpson(self.speed, x=self.place)

    @cached_property
    def stretched(self):
        """d |p'|/dq at every place, (n, PLACES)."""
        slopes = chebyshev.chebval(self.place, chebyshev.chebder(fitted(self.gradients)))
        return np.einsum("pi,ikp->kp", self.slope / self.speed[:, None], slopes)

    @cached_property
    def turned(self):
        """Angle by which the tangent has turned from the start to each place."""
        rate = np.linalg.norm(np.cross(self.slope, self.bend), axis=1) / self.speed**2
        return cumulative_simpson(rate, x=self.place, initial=0)

    def pulled(self, tension):
        """The work of tensions at all places per unit rate of each coordinate, (n,)."""
        return simpson(tension * self.stretched, x=self.place)


class Straight:
    """A straight line between two points; points and their gradients as pairs."""

    def __init__(self, first, last):
        self.across, self.gradient = last[0] - first[0], last[1] - first[1]

    @property
    def length(self):
        return np.linalg.norm(self.across)

    def pulled(self, tension):
        return tension * (self.across @ self.gradient) / self.length


class Actuated:
    """A robot of the reference with actuators, at one shape q."""

    def __init__(self, robot: Robot, q, gradients=True):
        self.robot, self.q = robot, np.asarray(q, float)
        # From rest, with one unit acceleration each: the rates of twists are the columns of the Jacobian.
        unit = np.eye(robot.n) if gradients else np.empty((robot.n, 0))
        self.motion = (self.q, np.zeros(robot.n), unit)
        self.bases = robot._outward(*self.motion)[1]
        self.fits, self.paths = {}, {}

    def rod(self, link):
        return self.robot.parts[self.robot.names.index(link)].rod

    def _fits(self, link):
        """Polynomials of the flat state along every segment of a rod."""
        if link not in self.fits:
            i = self.robot.names.index(link)
            q, v, a = (values[self.robot.rod_dofs[i]] for values in self.motion)
            rod, self.fits[link] = self.rod(link).on_base(*self.bases[i]), []
            for k, (segment, path) in enumerate(zip(rod.segments, rod._outward(q, v, a), strict=True)):
                rate, y = rod._motion_rate(k, q, v, a), path[0]
                values = [y]
                for ends in pairwise((NODES + 1) / 2 * segment.length):
                    y = integrate(rate, *ends, y)[-1]
                    values.append(y)
                self.fits[link].append(fitted(np.array(values)))
        return self.fits[link]

    def states(self, link, places):
        """R, p and the Jacobian of the body twist (6, n) of sections at places within one segment."""
        starts = self.rod(link).starts
        k = int(np.searchsorted(starts, (places[0] + places[-1]) / 2, side="right")) - 1
        fraction = (np.asarray(places) - starts[k]) / (starts[k + 1] - starts[k])
        for y in chebyshev.chebval(2 * fraction - 1, self._fits(link)[k]).T:
            R, p, _, twists = unpack(y)
            yield R, p, twists

    def point(self, via):
        """Position of a `Via`, and its derivatives (3, n)."""
        point = np.asarray(via.point, float)
        if via.link is None:
            return point, np.zeros((3, self.motion[2].shape[1]))
        i = self.robot.names.index(via.link)
        state = self.robot._place(i, self.bases[i], *self.motion, via.at)
        return carried(state.R, state.p, state.eta_t, point)

    def pieces(self, along):
        """Smooth pieces of a part along a rod: states of sections at the nodes, and offsets."""
        starts = self.rod(along.link).starts
        start, end = along.along if along.along is not None else (0.0, starts[-1])
        (y, y_kinks), (z, z_kinks) = (profile(each, start, end) for each in along.offset)
        kinks = [X for X in (*starts, *y_kinks, *z_kinks) if start + 1e-12 < X < end - 1e-12]
        for ends in pairwise(np.unique([start, *kinks, end])):
            places = np.mean(ends) + np.ptp(ends) / 2 * NODES
            places[[0, -1]] = ends
            yield list(self.states(along.link, places)), [np.array([0.0, y(X), z(X)]) for X in places]

    def curves(self, along):
        for states, offsets in self.pieces(along):
            yield Curve(*stacked(carried(*state, at) for state, at in zip(states, offsets, strict=True)))

    def parts(self, path):
        """Curves and straight lines in order."""
        if id(path) not in self.paths:
            # A reference to the path is kept, so that its id is not reused.
            self.paths[id(path)] = path, list(self._parts(path))
        return self.paths[id(path)][1]

    def _parts(self, path):
        last = None
        for part in path:
            curves = list(self.curves(part)) if isinstance(part, Along) else []
            first = curves[0].first if curves else self.point(part)
            if last is not None and np.linalg.norm(first[0] - last[0]) > 1e-12:
                yield Straight(last, first)
            yield from curves
            last = curves[-1].last if curves else first

    # Tendons

    def length(self, tendon):
        return sum(part.length for part in self.parts(tendon.path))

    def length_gradient(self, tendon):
        """d length/dq, (n,)."""
        return self.tendon_force(replace(tendon, friction=0.0), 1.0, 0.0)

    def tension(self, tendon, v):
        """Tension at the start of the path, newtons."""
        if tendon.tension is not None:
            return tendon.tension
        stretch = self.length(tendon) - tendon.length
        rate = self.length_gradient(tendon) @ v
        return max(0.0, tendon.stiffness * stretch + tendon.damping * rate)

    def sliding(self, tendon, v):
        if tendon.sliding is not None:
            return tendon.sliding
        rate = self.length_gradient(tendon) @ v
        return -rate / np.hypot(rate, tendon.friction_velocity)

    def tendon_force(self, tendon, tension, sliding):
        """Contribution of a tendon to the required forces, (n,), with capstan friction on every curve."""
        total, turned = np.zeros(self.robot.n), 0.0
        for part in self.parts(tendon.path):
            angle = turned + (part.turned if isinstance(part, Curve) else 0.0)
            total += part.pulled(tension * np.exp(-tendon.friction * sliding * angle))
            turned = angle[-1] if isinstance(part, Curve) else angle
        return total

    # Chambers

    def volume_and_gradient(self, chamber):
        volume, gradient = 0.0, np.zeros(self.motion[2].shape[1])
        for along in chamber.path:
            for curve_volume, curve_gradient in self._solids(along, chamber.area):
                volume, gradient = volume + curve_volume, gradient + curve_gradient
        return volume, gradient

    def _solids(self, along, area):
        """Volume and its gradient of every smooth piece of a chamber, each with caps."""
        turn = 2 * np.pi * np.arange(AROUND) / AROUND
        ring = np.column_stack([np.zeros(AROUND), np.cos(turn), np.sin(turn)]) * np.sqrt(area / np.pi)
        gauss, weights = np.polynomial.legendre.leggauss(POINTS)
        for states, offsets in self.pieces(along):
            points, motions = stacked(
                stacked(carried(*state, at + spoke) for spoke in ring)
                for state, at in zip(states, offsets, strict=True)
            )
            surface = fitted(points)
            moved = chebyshev.chebval(gauss, fitted(motions))
            at = chebyshev.chebval(gauss, surface)
            ahead = chebyshev.chebval(gauss, chebyshev.chebder(surface))
            outward = np.cross(derivative_around(at), ahead, axis=1) * (2 * np.pi / AROUND) * weights
            volume = np.sum(at * outward) / 3
            gradient = np.einsum("aip,aikp->k", outward, moved)
            for sign, k in ((-1, 0), (1, -1)):
                cap = sign * area * states[k][0][:, 0]
                centre, motion = carried(*states[k], offsets[k])
                volume += centre @ cap / 3
                gradient += cap @ motion
            yield volume, gradient

    # All actuators.

    def force(self, actuator, v, t=0.0):
        """Contribution of an actuator to `inverse_dynamics`, (n,)."""
        v = np.asarray(v, float)
        if isinstance(actuator, Tendon):
            tension, sliding = self.tension(actuator, v), self.sliding(actuator, v)
            return self.tendon_force(actuator, tension, sliding)
        if isinstance(actuator, Chamber):
            return -actuator.pressure * self.volume_and_gradient(actuator)[1]
        if isinstance(actuator, Motor):
            return self._motor_force(actuator, v)
        return self._active_force(actuator)

    def _motor_force(self, motor, v):
        force, k = np.zeros(self.robot.n), self.robot.slice(motor.joint).start
        if motor.torque is not None:
            force[k] = -motor.torque
        else:
            stiffness, damping = motor.gains
            force[k] = -stiffness * (motor.position - self.q[k]) + damping * v[k]
        return force

    def _active_force(self, active):
        """Central differences of energies, which are quadratic in q."""
        i = self.robot.names.index(active.link)
        rod, dofs = self.robot.parts[i].rod, self.robot.rod_dofs[i]
        shape, kinks = profile(active.shape, 0.0, rod.starts[-1])
        unit, force = np.eye(6)[STRAINS.index(active.strain)], np.zeros(self.robot.n)
        for segment, own, start in zip(rod.segments, rod.dofs, rod.starts[:-1], strict=True):
            inside = [X - start for X in kinks if 0 < X - start < segment.length]
            q = self.q[dofs][own]

            def energy(q, amount, segment=segment, start=start, inside=inside):
                return strain_energy(segment, q, amount * unit, shape, start, inside)

            for k, step in enumerate(np.eye(segment.n)):
                difference = [energy(q + step, on) - energy(q - step, on) for on in (active.amount, 0)]
                force[dofs.start + own.start + k] += (difference[0] - difference[1]) / 2
        return force


def strain_energy(segment, q, driven, shape, start, kinks):
    """Elastic energy of a segment from `start` on, with the additional reference strain `driven * shape`."""

    def density(X):
        strain = segment.basis(X) @ q - driven * shape(start + X)
        return strain @ segment.stiffness(X) @ strain / 2

    return quad(density, 0, segment.length, points=kinks or None, epsabs=0, epsrel=1e-12)[0]


def carried(R, p, twists, point):
    """A point of a section, and its derivatives: v + omega x point in the axes of the section."""
    return p + R @ point, R @ (twists[3:] - hat(point) @ twists[:3])


def stacked(pairs):
    """Two arrays from pairs of arrays."""
    return tuple(np.array(each) for each in zip(*pairs, strict=True))


def fitted(values):
    """Coefficients of the Chebyshev polynomials through values at the nodes, of the same shape."""
    return chebyshev.chebfit(NODES, values.reshape(POINTS, -1), POINTS - 1).reshape(values.shape)


def derivative_around(values):
    """Derivative with respect to the angle around the first axis, by a Fourier series."""
    orders = 1j * np.fft.fftfreq(AROUND, 1 / AROUND)
    return np.real(np.fft.ifft(orders[:, None, None] * np.fft.fft(values, axis=0), axis=0))
