"""Reference values: closed forms, and equations solved by methods that share nothing with lissom's rods.

Requires only NumPy. Planar rods are solved by Chebyshev collocation, spatial rods by shooting.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Vector = tuple[float, float]
#: Positions, rotations and internal moments of sections, in world axes.
State = tuple[Array, Array, Array]

#: Relative increment of differences in Newton's method for small systems: between rounding and truncation
#: errors.
DIFFERENCE = 1e-6
#: Newton's method has converged when a step is shorter than this.
SMALL_STEP = 1e-11
MOST_STEPS = 50

#: Numbers of points of Gauss-Legendre quadrature and of Chebyshev collocation: sufficient for rounding here.
GAUSS_POINTS = 80
CHEBYSHEV_DEGREE = 48

#: Number of frequencies at which a frequency equation is checked for sign changes.
FREQUENCY_GRID = 1000
#: Number of terms of a power series: more change nothing at the speeds of the gallery.
SERIES_TERMS = 120

#: Number of Runge-Kutta steps along a spatial rod.
STEPS_ALONG = 120


def bisect(function: Callable[[float], float], low: float, high: float) -> float:
    """Root, to rounding, of a function with a sign change between two points."""
    rising = function(high) > 0.0
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return middle
        if (function(middle) > 0.0) == rising:
            high = middle
        else:
            low = middle


def newton(residual: Callable[[Array], Array], x: Array) -> Array:
    """Newton's method with forward differences."""
    for _ in range(MOST_STEPS):
        value = residual(x)
        steps = DIFFERENCE * np.maximum(1.0, np.abs(x))
        columns = [
            (residual(x + step * unit) - value) / step
            for step, unit in zip(steps, np.eye(len(x)), strict=True)
        ]
        change = -np.linalg.solve(np.transpose(columns), value)
        x = x + change
        if np.abs(change).max() <= SMALL_STEP * max(1.0, np.abs(x).max()):
            return x
    raise ArithmeticError("Newton's method has not converged")


def elliptic(k: float, start: float = 0.0) -> Vector:
    """Legendre's integrals of the first and second kind with modulus k, from ``start`` to pi / 2."""
    nodes, weights = _gauss()
    angle = start + (0.5 * np.pi - start) * 0.5 * (nodes + 1.0)
    root = np.sqrt(1.0 - (k * np.sin(angle)) ** 2)
    half = 0.5 * (0.5 * np.pi - start)
    return float(half * weights @ (1.0 / root)), float(half * weights @ root)


@cache
def _gauss() -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    return nodes, weights


def elastica(alpha: float) -> tuple[float, float, float]:
    """Tip of a cantilever under a transverse tip force alpha E I / L^2: x / L, deflection / L, angle.

    Bisshopp and Drucker (1945), Large deflection of cantilever beams, Quarterly of Applied Mathematics 3.
    """

    def integrals(angle: float) -> tuple[float, float]:
        k = np.sqrt(0.5 * (1.0 + np.sin(angle)))
        return elliptic(k, float(np.arcsin(np.sqrt(0.5) / k)))

    angle = bisect(lambda angle: integrals(angle)[0] - np.sqrt(alpha), 1e-6, 0.5 * np.pi - 1e-6)
    deflection = float(1.0 - 2.0 * integrals(angle)[1] / np.sqrt(alpha))
    return float(np.sqrt(2.0 * np.sin(angle) / alpha)), deflection, angle


def buckled_column(ratio: float) -> tuple[float, float, float]:
    """Tip of a clamped-free column under ``ratio`` > 1 times its Euler load: x / L, deflection / L, angle.

    Timoshenko and Gere (1961), Theory of Elastic Stability, section 2.7.
    """
    length = 0.5 * np.pi * np.sqrt(ratio)
    k = bisect(lambda k: elliptic(k)[0] - length, 0.0, 1.0 - 1e-9)
    first, second = elliptic(k)
    return 2.0 * second / first - 1.0, float(2.0 * k / length), 2.0 * float(np.arcsin(k))


def self_buckling() -> float:
    """Critical weight per length of a standing column, in units of E I / L^3.

    Greenhill (1881), Determination of the greatest height consistent with stability: 9 j^2 / 4 with the
    first zero j of the Bessel function of order -1/3, here by its power series.
    """

    def bessel(x: float) -> float:
        term, total = 1.0, 1.0
        for m in range(1, 40):
            term *= -((0.5 * x) ** 2) / (m * (m - 1.0 / 3.0))
            total += term
        return total

    return 2.25 * bisect(bessel, 1.0, 3.0) ** 2


def lateral_buckling() -> float:
    """Critical tip force of a deep narrow cantilever for lateral buckling, in units of sqrt(E I_z G J_t) /
    L^2.

    Prandtl (1899), Kipp-Erscheinungen, 4.0126: twice the first zero of the Bessel function of order -1/4,
    here by its power series.
    """

    def bessel(x: float) -> float:
        term, total = 1.0, 1.0
        for m in range(1, 40):
            term *= -((0.5 * x) ** 2) / (m * (m - 0.25))
            total += term
        return total

    return 2.0 * bisect(bessel, 1.0, 3.0)


def becks_column() -> float:
    """Critical follower force of a cantilever for flutter, in units of E I / L^2.

    Beck (1952), Die Knicklast des einseitig eingespannten, tangential gedrückten Stabes, ZAMP 3: where two
    roots of the frequency equation coincide, so that its derivative vanishes too.
    """

    def equation(p: float, w: float) -> float:
        root = np.hypot(0.5 * p, w)
        slow, fast = np.sqrt(root - 0.5 * p), np.sqrt(root + 0.5 * p)
        return float(
            p**2 + 2.0 * w**2 * (1.0 + np.cosh(slow) * np.cos(fast)) + p * w * np.sinh(slow) * np.sin(fast)
        )

    def meeting(x: Array) -> Array:
        p, w = x
        slope = (equation(p, w + 1e-4) - equation(p, w - 1e-4)) / 2e-4
        return np.array([equation(p, w), slope])

    return float(newton(meeting, np.array([20.0, 11.0]))[0])


def greenhill_root() -> float:
    """The first positive root of tan u = u, 4.4934.

    A shaft between clamps under an axial moment M buckles when M L / (2 E I) equals this root (Greenhill
    1883, On the strength of shafting when exposed both to torsion and to end thrust; Love 1927, section 272);
    a column between a clamp and a pin when P L^2 / (E I) equals its square.
    """
    return bisect(lambda u: float(np.sin(u) - u * np.cos(u)), np.pi, 1.5 * np.pi)


def held_beam_roots(count: int, *, is_clamped: bool) -> Array:
    """The first roots b of tan b = tanh b, for a beam between a clamp and a pin, or of cos b cosh b = 1,
    between two clamps: frequencies are b^2 sqrt(E I / (rho A L^4)) / 2 pi."""

    def equation(b: float) -> float:
        return float(np.cos(b) - 1.0 / np.cosh(b) if is_clamped else np.sin(b) - np.cos(b) * np.tanh(b))

    low = np.pi if is_clamped else 0.75 * np.pi
    return np.array([bisect(equation, low + np.pi * i, low + np.pi * (i + 1)) for i in range(count)])


def cantilever_roots(count: int) -> Array:
    """The first roots b of cos b cosh b = -1: frequencies are b^2 sqrt(E I / (rho A L^4)) / 2 pi."""

    def equation(b: float) -> float:
        return float(np.cos(b) + 1.0 / np.cosh(b))

    return np.array([bisect(equation, np.pi * i, np.pi * (i + 1)) for i in range(count)])


def timoshenko_frequencies(
    EI: float, GA: float, mass: float, rotary: float, length: float, count: int
) -> Array:
    """Angular frequencies of a clamped-free beam with shear and rotary inertia (Timoshenko 1921).

    ``mass`` and ``rotary`` inertia are per length, ``GA`` includes the shear correction. Zeros of the
    determinant of the block of the transfer matrix that maps moment and shear force at the clamp to those at
    the free end.
    """

    def free_end(omega: float) -> float:
        # (deflection, slope, moment, shear force) along the beam.
        change = np.array(
            [
                [0.0, 1.0, 0.0, 1.0 / GA],
                [0.0, 0.0, 1.0 / EI, 0.0],
                [0.0, -rotary * omega**2, 0.0, -1.0],
                [-mass * omega**2, 0.0, 0.0, 0.0],
            ]
        )
        values, vectors = np.linalg.eig(change)
        transfer = (vectors * np.exp(values * length)) @ np.linalg.inv(vectors)
        return float(np.linalg.det(transfer[2:, 2:].real))

    slender = cantilever_roots(count) ** 2 * np.sqrt(EI / mass) / length**2
    grid = np.linspace(0.05 * slender[0], 1.05 * slender[-1], 1500)
    signs = np.array([free_end(omega) for omega in grid]) > 0.0
    changes = np.flatnonzero(signs[1:] != signs[:-1])[:count]
    return np.array([bisect(free_end, grid[i], grid[i + 1]) for i in changes])


def frame_frequencies(
    leg: float,
    stiffness: Sequence[float],
    mass: float,
    inertia: Sequence[float],
    count: int,
    highest: float,
) -> Array:
    """Angular frequencies, up to ``highest``, of a frame of two equal legs at a right angle, clamped at one
    end.

    ``stiffness`` contains (torsion, bend_y, bend_z, stretch, shear_y, shear_z); ``mass``, and ``inertia``
    about the axes of the section, are per length. Small vibrations of a spatial Timoshenko beam: along a leg
    the rotation theta, the displacement u, the moment m and the force n satisfy

        theta' = m / (G J, E I, E I),         u' = n / (E A, G A, G A) + theta x e_x,
        m' = -w^2 rho I theta - e_x x n,      n' = -w^2 rho A u.

    The frequencies are zeros of the determinant of the block of the transfer matrix that maps moment and
    force at the clamp to those at the free end.
    """
    turned = np.kron(np.eye(4), [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    across = np.cross(np.eye(3), [1.0, 0.0, 0.0]).T
    # Units of rotation, displacement, moment and force for which all entries have similar size.
    soft = float(np.min(stiffness[:3]))
    units = np.repeat([1.0, leg, soft / leg, soft / leg**2], 3)

    def free_end(omega: float) -> float:
        change = np.zeros((12, 12))
        change[:6, 6:] = np.diag(1.0 / np.array(stiffness))
        change[3:6, :3] = change[6:9, 9:] = across
        change[6:9, :3] = -(omega**2) * np.diag(inertia)
        change[9:, 3:6] = -(omega**2) * mass * np.eye(3)
        values, vectors = np.linalg.eig(change * units / units[:, None])
        transfer = ((vectors * np.exp(values * leg)) @ np.linalg.inv(vectors)).real
        return float(np.linalg.det((transfer @ turned @ transfer)[6:, 6:]))

    grid = np.linspace(highest / FREQUENCY_GRID, highest, FREQUENCY_GRID).tolist()
    signs = np.array([free_end(omega) for omega in grid]) > 0.0
    changes = np.flatnonzero(signs[1:] != signs[:-1])[:count]
    return np.array([bisect(free_end, grid[i], grid[i + 1]) for i in changes])


def flapping_blade(speed: float) -> float:
    """First flapping frequency of a blade clamped at the axis of its rotation, times L^2 sqrt(rho A / (E I)).

    Power series of w'''' - speed^2 / 2 ((1 - x^2) w')' = frequency^2 w, the ``speed`` in the same unit, as in
    Wright, Smith, Thresher and Wang (1982), Vibration modes of centrifugally stiffened beams, Journal of
    Applied Mechanics 49.
    """
    k = np.arange(SERIES_TERMS + 2)

    def free_end(frequency: float) -> float:
        ends = []
        for start in np.eye(2):
            # At a clamp the series begins with x^2 and x^3.
            a = np.zeros(SERIES_TERMS + 4)
            a[2:4] = start
            for i in range(SERIES_TERMS):
                pull = 0.5 * speed**2 * (i + 1) * ((i + 2) * a[i + 2] - i * a[i])
                a[i + 4] = (pull + frequency**2 * a[i]) / ((i + 4) * (i + 3) * (i + 2) * (i + 1))
            bend = (k + 2) * (k + 1) * a[2:]
            ends.append((bend.sum(), k @ bend))
        return float(np.linalg.det(ends))

    # Between the frequency of a rotating string, which is the speed itself, and an upper bound above
    # Southwell's sum of squares.
    return bisect(free_end, max(3.0, speed), float(np.hypot(4.0, 1.2 * speed)))


@dataclass(frozen=True)
class PlanarShape:
    """A planar rod: angles above the horizontal and positions at points along it, starting at the base."""

    X: Array
    angle: Array
    x: Array
    z: Array


def planar_rod(
    length: float,
    bending: Callable[[Array], Array],
    *,
    weight: Callable[[Array], Array] | None = None,
    force: Vector = (0.0, 0.0),
    moment: float = 0.0,
    follows: bool = False,
    EA: float = np.inf,
    GA: float = np.inf,
    parts: int = 10,
    degree: int = CHEBYSHEV_DEGREE,
) -> PlanarShape:
    """A clamped rod at equilibrium (Reissner 1972), computed by increasing the loads in ``parts`` steps.

    ``bending`` stiffness and ``weight`` per length are functions of X; the weight acts along -z. ``force``
    (x, z) acts at the tip, in the axes of the tip if it ``follows``.
    """
    nodes, derivative = chebyshev(degree)
    X = 0.5 * length * (1.0 + nodes)
    D = derivative * 2.0 / length
    # Antiderivative that vanishes at the base: inverse of D without the row and column of the base.
    integral = np.zeros_like(D)
    integral[1:, 1:] = np.linalg.inv(D[1:, 1:])
    load = np.zeros_like(X) if weight is None else weight(X)
    weight_beyond = (integral @ load)[-1] - integral @ load
    stiffness = bending(X)

    def slopes(part: float, angle: Array) -> tuple[Array, Array, Array, Array]:
        """Slopes of x and z, and the internal force."""
        fx, fz = force
        if follows:
            cos, sin = np.cos(angle[-1]), np.sin(angle[-1])
            fx, fz = fx * cos - fz * sin, fx * sin + fz * cos
        nx, nz = part * fx + 0.0 * X, part * (fz - weight_beyond)
        cos, sin = np.cos(angle), np.sin(angle)
        stretch = 1.0 + (nx * cos + nz * sin) / EA
        shear = (nz * cos - nx * sin) / GA
        return stretch * cos - shear * sin, stretch * sin + shear * cos, nx, nz

    def residual(part: float, angle: Array) -> Array:
        dx, dz, nx, nz = slopes(part, angle)
        bend = stiffness * (D @ angle)
        balance = (D @ bend + dx * nz - dz * nx) * length**2 / stiffness[0]
        balance[0] = angle[0]
        balance[-1] = (bend[-1] - part * moment) * length / stiffness[0]
        return np.asarray(balance)

    angle = np.zeros_like(X)
    for part in np.linspace(0.0, 1.0, parts + 1)[1:]:
        angle = newton(partial(residual, float(part)), angle)
    dx, dz, _, _ = slopes(1.0, angle)
    return PlanarShape(X, angle, integral @ dx, integral @ dz)


def held_planar_rod(length: float, bending: float, weight: float) -> PlanarShape:
    """A clamped heavy rod whose tip is held at the height and in the direction of the base, and can slide."""

    def shape(unknown: Array) -> PlanarShape:
        return planar_rod(
            length,
            lambda X: bending + 0.0 * X,
            weight=lambda X: weight + 0.0 * X,
            force=(0.0, float(unknown[0])),
            moment=float(unknown[1]),
        )

    def residual(unknown: Array) -> Array:
        found = shape(unknown)
        return np.array([found.z[-1] / length, found.angle[-1]])

    linear = np.array([weight * length / 2.0, -weight * length**2 / 12.0])
    return shape(newton(residual, linear))


def interpolated(X: Array, values: Array, at: float) -> float:
    """Interpolation polynomial through collocation values at a point (barycentric formula)."""
    scale = 4.0 / (X.max() - X.min())
    weights = np.array([1.0 / np.prod(scale * (x - np.delete(X, i))) for i, x in enumerate(X)])
    if at in X:
        return float(values[list(X).index(at)])
    shares = weights / (at - X)
    return float(shares @ values / shares.sum())


def chebyshev(degree: int) -> tuple[Array, Array]:
    """Extreme points of a Chebyshev polynomial from -1 to 1, and the differentiation matrix.

    Trefethen (2000), Spectral Methods in MATLAB, chapter 6.
    """
    nodes = -np.cos(np.pi * np.arange(degree + 1) / degree)
    signs = (-1.0) ** np.arange(degree + 1)
    signs[[0, -1]] *= 2.0
    difference = nodes[:, None] - nodes[None]
    D = np.outer(signs, 1.0 / signs) / (difference + np.eye(degree + 1))
    return nodes, D - np.diag(D.sum(axis=1))


@cache
def space_rod(
    length: float,
    stiffness: tuple[float, ...],
    curvature: tuple[float, float, float],
    forces: tuple[tuple[float, float, float], ...],
) -> tuple[Array, ...]:
    """Centre lines, shape (points, 3), of a clamped spatial rod under several dead tip forces.

    ``stiffness`` contains (torsion, bend_y, bend_z, stretch, shear_y, shear_z), ``curvature`` is that of the
    unloaded rod. Shooting for the moment at the clamp such that the moment at the tip vanishes.
    """
    bending, straining = np.array(stiffness[:3]), np.array(stiffness[3:])
    unloaded, along = np.array(curvature), np.array([1.0, 0.0, 0.0])
    h = length / STEPS_ALONG

    def slopes(state: State, n: Array) -> State:
        _, R, m = state
        kappa = unloaded + np.einsum("...ji,...j->...i", R, m) / bending
        nu = along + np.einsum("...ji,j->...i", R, n) / straining
        dr = np.einsum("...ij,...j->...i", R, nu)
        # R' = R hat(kappa): its rows r change by r x kappa.
        return dr, np.cross(R, kappa[..., None, :]), -np.cross(dr, n)

    def moved(state: State, step: float, slope: State) -> State:
        r, R, m = (y + step * k for y, k in zip(state, slope, strict=True))
        return r, R, m

    def shoot(moments: Array, n: Array) -> tuple[Array, Array]:
        """Positions along the rods and moments at the tips, for moments at the clamp of shape (k, 3)."""
        state = (np.zeros_like(moments), np.tile(np.eye(3), (len(moments), 1, 1)), moments)
        line = [state[0]]
        for _ in range(STEPS_ALONG):
            k1 = slopes(state, n)
            k2 = slopes(moved(state, 0.5 * h, k1), n)
            k3 = slopes(moved(state, 0.5 * h, k2), n)
            k4 = slopes(moved(state, h, k3), n)
            for k, weight in ((k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)):
                state = moved(state, h * weight / 6.0, k)
            line.append(state[0])
        return np.array(line), state[2]

    lines, moment = [], np.zeros(3)
    for force in forces:
        n = np.array(force)
        for _ in range(MOST_STEPS):
            size = DIFFERENCE * max(1.0, float(np.abs(moment).max()))
            _, left = shoot(moment + size * np.vstack([np.zeros(3), np.eye(3)]), n)
            change = -np.linalg.solve((left[1:] - left[0]).T / size, left[0])
            moment = moment + change
            if np.abs(change).max() <= 1e-9 * max(1.0, float(np.abs(moment).max())):
                break
        else:
            raise ArithmeticError("shooting has not converged")
        lines.append(shoot(moment[None], n)[0][:, 0])
    return tuple(lines)


def helix(moment: Sequence[float], bending: float, X: Array) -> Array:
    """Centre line of a circular rod, clamped along x, under a moment that is constant in space, (points, 3).

    The tangent rotates about the moment at the rate |M| / (E I) for any torsional stiffness, because the
    component of the moment along the tangent does not bend.
    """
    size = float(np.linalg.norm(moment))
    axis = np.array(moment) / size
    along = axis[0] * axis
    across = np.array([1.0, 0.0, 0.0]) - along
    rate = size / bending
    turn = rate * X[:, None]
    return np.asarray(
        along * X[:, None] + (np.sin(turn) * across + (1.0 - np.cos(turn)) * np.cross(axis, across)) / rate
    )


def catenary(weight: float, pull: float, X: Array) -> tuple[Array, Array]:
    """A rope between two points of equal height, by arc length: x and z; ``pull`` is the horizontal force."""
    middle = 0.5 * X[-1]
    slope = weight * (X - middle) / pull
    x = pull / weight * (np.arcsinh(slope) - np.arcsinh(slope[0]))
    z = pull / weight * (np.hypot(1.0, slope) - np.hypot(1.0, slope[0]))
    return x, z


def turned_beam(
    bend: float, mass: float, span: float, turned: Callable[[float], tuple[float, float, float]], end: float
) -> tuple[Array, Array]:
    """Times and tip deflection of a beam whose clamped end is rotated, by linear theory.

    rho A (w'' + psi'' x - psi'^2 w) + E I w_xxxx - (P w_x)_x = 0 with the centrifugal force
    P = rho A psi'^2 (L^2 - x^2) / 2 (Kane, Ryan and Banerjee 1987): Galerkin's method with polynomials
    x^2 ... x^6, integrated by the Runge-Kutta method of order 4. Valid if the deflection is small compared
    with the length.

    Parameters
    ----------
    bend, mass, span : float
        E I, rho A and L.
    turned : callable
        t -> angle psi, its rate and its acceleration.
    end : float
        End time, seconds.
    """
    powers = np.arange(2, 7)
    nodes, weights = np.polynomial.legendre.leggauss(10)
    x, w = 0.5 * (nodes + 1.0), 0.5 * weights * span
    shape, slope = x[:, None] ** powers, powers * x[:, None] ** (powers - 1) / span
    curvature = powers * (powers - 1) * x[:, None] ** (powers - 2) / span**2
    inertia = mass * shape.T @ (w[:, None] * shape)
    elastic = bend * curvature.T @ (w[:, None] * curvature)
    pull = 0.5 * mass * span**2 * slope.T @ ((w * (1.0 - x**2))[:, None] * slope)
    inverse = np.linalg.inv(inertia)
    stiffness, turning = inverse @ elastic, inverse @ (pull - inertia)
    load = inverse @ (mass * span * shape.T @ (w * x))

    def rate(t: float, y: Array) -> Array:
        _, speed, acceleration = turned(t)
        return np.array([y[1], -(stiffness @ y[0]) - speed**2 * (turning @ y[0]) - acceleration * load])

    h, y = 2e-3, np.zeros((2, len(powers)))
    t = np.array([h * i for i in range(round(end / h) + 1)])
    tips = [0.0]
    for start in t[:-1].tolist():
        a = rate(start, y)
        b = rate(start + h / 2, y + h / 2 * a)
        c = rate(start + h / 2, y + h / 2 * b)
        d = rate(start + h, y + h * c)
        y = y + h / 6 * (a + 2 * b + 2 * c + d)
        tips.append(float(y[0].sum()))
    return t, np.array(tips)
