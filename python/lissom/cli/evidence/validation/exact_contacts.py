"""Reference values of ropes in contact, with NumPy alone: ropes on drums, chains on floors, plies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import exact_lines
from .exact import Array, bisect
from .exact_lines import Line

#: Steps of the Runge-Kutta method of fourth order for a rope that slides.
SLIDING_STEPS = 400
#: Winding angles of plies, rad: at pi / 4 theory ends.
SMALLEST_ANGLE, LARGEST_ANGLE = 1e-3, 0.78
#: Factor of the shorter side beyond which no friction of the gallery holds the longer one.
MUCH_LONGER = 100.0


@dataclass(frozen=True)
class Drum:
    """A rope without bending stiffness and stretch over the upper half of a drum."""

    #: Of the rope's axis, m.
    radius: float
    #: Of the rope, m: friction acts so much nearer to the axis of the drum.
    thickness: float
    friction: float
    #: Length of the side that is lifted, m.
    short: float
    gravity: float


def acceleration(drum: Drum, long: float, moved: float = 0.0, speed: float = 0.0) -> float:
    """Acceleration in units of gravity of a rope that slides to its long side; negative if it is held.

    With the contact force N per angle, the weight 1 per length, p = thickness / radius and the shear force
    Q = mu p N that carries the moment of friction,

        T' = mu (1 - p) N + R (cos phi + a),   N = T - Q' + R sin phi - v^2 / g,

    which is linear: N = C exp(s phi) + b cos phi + c sin phi + d a. Capstan equation for p = 0.
    """
    mu, R = drum.friction, drum.radius
    p = drum.thickness / R
    s = (np.sqrt(1.0 + 4.0 * mu**2 * p * (1.0 - p)) - 1.0) / (2.0 * mu * p)
    c = 2.0 * R / (1.0 + mu**2)
    b, d = -mu * c, -R / (mu * (1.0 - p))

    def tension(phi: float, unknown: Array) -> float:
        growing, steady = unknown[0] * np.exp(s * phi), d * unknown[1]
        force = growing + b * np.cos(phi) + c * np.sin(phi) + steady
        change = s * growing - b * np.sin(phi) + c * np.cos(phi)
        return float(force + mu * p * change - R * np.sin(phi) + speed**2 / drum.gravity)

    def miss(unknown: Array) -> Array:
        a = unknown[1]
        light, heavy = drum.short - moved, long + moved
        return np.array(
            [
                tension(0.0, unknown) - light * (1.0 + a),
                tension(np.pi, unknown) - heavy * (1.0 - a),
            ]
        )

    nothing = miss(np.zeros(2))
    columns = [miss(unit) - nothing for unit in np.eye(2)]
    return float(np.linalg.solve(np.transpose(columns), -nothing)[1])


def longest(drum: Drum) -> float:
    """Length of the other side up to which friction holds the rope, m."""
    return bisect(lambda long: acceleration(drum, long), drum.short, MUCH_LONGER * drum.short)


def sliding(drum: Drum, long: float, times: Array) -> Array:
    """How far a rope that is let go has slid, m."""
    state, moved = np.zeros(2), [0.0]

    def rate(y: Array) -> Array:
        return np.array([y[1], drum.gravity * max(acceleration(drum, long, y[0], y[1]), 0.0)])

    grid = np.linspace(0.0, float(times[-1]), SLIDING_STEPS + 1)
    step = grid[1]
    for _ in grid[1:]:
        first = rate(state)
        second = rate(state + 0.5 * step * first)
        third = rate(state + 0.5 * step * second)
        fourth = rate(state + step * third)
        state = state + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
        moved.append(float(state[0]))
    return np.interp(times, grid, moved)


def dragged(line: Line, friction: float) -> tuple[float, float]:
    """Tension at the end and at the anchor of a line that was drawn over a floor, all of it outwards."""
    H, V = exact_lines.resting(line, friction)
    bottom = line.length - V / line.weight
    return float(np.hypot(H, V)), max(H - friction * line.weight * bottom, 0.0)


def ply(tension: float) -> tuple[float, float]:
    """Winding angle and torque of a ply of two strands without friction that touch, in units of B and radius.

    Clauvelin, Audoly and Neukirch 2009, equations 9: T = sin^3 a (cos a tan 2a - sin(a) / 2).
    """

    angle = bisect(lambda angle: ply_tension(angle) - tension, SMALLEST_ANGLE, LARGEST_ANGLE)
    torque = 2.0 / np.sin(2.0 * angle) * (0.5 * np.sin(angle) ** 4 + tension)
    return angle, float(torque)


def ply_tension(angle: float) -> float:
    """The tension at which a ply has a winding angle."""
    return float(np.sin(angle) ** 3 * (np.cos(angle) * np.tan(2.0 * angle) - 0.5 * np.sin(angle)))
