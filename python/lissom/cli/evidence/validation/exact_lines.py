"""Reference values of lines without bending stiffness, and of cables with a little of it, with NumPy "
"alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .exact import SMALL_STEP, Array, bisect, chebyshev, newton

#: Relative increments of differences, and largest relative steps of Newton's method for end forces.
FORCE_STEP = 1e-7
LARGEST_PART = 0.5


@dataclass(frozen=True)
class Line:
    """A line from A to B, which lies ``x`` beside and ``z`` above it; SI units.

    ``weight`` is per unstretched length, negative if the line floats.
    """

    x: float
    z: float
    length: float
    EA: float
    weight: float


def hanging(line: Line) -> tuple[float, float]:
    """Horizontal and upward force that hold end B of a line that touches nothing.

    Elastic catenary: Irvine (1981), Cable Structures, section 1.3.
    """
    chord = np.hypot(line.x, line.z)
    slack = 3.0 * ((line.length**2 - line.z**2) / line.x**2 - 1.0)
    sag = np.sqrt(slack) if line.length > chord else 0.25
    size = abs(line.weight)
    start = np.array(
        [
            size * line.x / (2.0 * sag),
            line.weight / 2.0 * (line.z / np.tanh(sag) + line.length),
        ]
    )

    def miss(forces: Array) -> Array:
        x, z = hanging_shape(line, forces, np.array(line.length))
        return np.array([x - line.x, z - line.z])

    return _forces(miss, start)


def hanging_shape(line: Line, forces: Array | tuple[float, float], s: Array) -> tuple[Array, Array]:
    """Points of a hanging line at unstretched lengths from A, for the forces at B."""
    H, V = forces
    low, up = V - line.weight * line.length, V - line.weight * (line.length - s)
    x = H / line.weight * (np.arcsinh(up / H) - np.arcsinh(low / H)) + H * s / line.EA
    z = H / line.weight * (np.hypot(1.0, up / H) - np.hypot(1.0, low / H))
    return x, z + (up**2 - low**2) / (2.0 * line.weight * line.EA)


def resting(line: Line, friction: float = 0.0) -> tuple[float, float]:
    """Horizontal and upward force that hold end B of a line that rests on a floor at the height of A.

    Jonkman (2007), Dynamics modeling and loads analysis of an offshore floating wind turbine, equations 2-37:
    friction acts along the whole length that rests, up to where it has taken up the force.
    """

    def miss(forces: Array) -> Array:
        H, V = forces
        x, z = resting_shape(line, forces, np.array(line.length))
        bottom = line.length - V / line.weight
        if friction > 0.0:
            held = friction * line.weight
            loose = max(bottom - H / held, 0.0)
            x += held / (2.0 * line.EA) * ((bottom - H / held) * loose - bottom**2)
        return np.array([x - line.x, z - line.z])

    return _forces(miss, np.array([line.weight * line.z, 1.2 * line.weight * line.z]))


def resting_shape(line: Line, forces: Array | tuple[float, float], s: Array) -> tuple[Array, Array]:
    """Points of a line that rests on the floor, without friction, at unstretched lengths from A."""
    H, V = forces
    bottom = line.length - V / line.weight
    up = line.weight * np.maximum(s - bottom, 0.0)
    x = np.minimum(s, bottom) + H / line.weight * np.arcsinh(up / H) + H * s / line.EA
    z = H / line.weight * (np.hypot(1.0, up / H) - 1.0) + up**2 / (2.0 * line.weight * line.EA)
    return x, z


def _forces(miss: Callable[[Array], Array], start: Array) -> tuple[float, float]:
    """Newton's method for end forces, in which the horizontal one stays positive."""
    forces = start
    for _ in range(200):
        value = miss(forces)
        columns = [
            (miss(forces + FORCE_STEP * abs(part) * unit) - value) / (FORCE_STEP * abs(part))
            for part, unit in zip(forces, np.eye(2), strict=True)
        ]
        change = -np.linalg.solve(np.transpose(columns), value)
        part = float(np.abs(change / forces).max())
        forces = forces + min(1.0, LARGEST_PART / max(part, SMALL_STEP)) * change
        if part < 1e-13:
            break
    return float(forces[0]), float(forces[1])


def stiff_cable(line: Line, bending: float, degree: int = 80) -> tuple[float, float, Array, Array]:
    """Horizontal and upward force at B, x and z of a cable with bending stiffness between two hooks.

    Kirchhoff's rod with stretch in the plane, by Chebyshev collocation for angles and forces.
    """
    nodes, derivative = chebyshev(degree)
    s = 0.5 * line.length * (1.0 + nodes)
    D = derivative * 2.0 / line.length
    integral = np.zeros_like(D)
    integral[1:, 1:] = np.linalg.inv(D[1:, 1:])
    size = abs(line.weight) * line.length

    def slopes(unknown: Array) -> tuple[Array, Array, Array, Array]:
        angle, H, V = unknown[:-2], size * unknown[-2], size * unknown[-1]
        up = V - line.weight * (line.length - s)
        stretch = 1.0 + (H * np.cos(angle) + up * np.sin(angle)) / line.EA
        return stretch * np.cos(angle), stretch * np.sin(angle), H + 0.0 * s, up

    def residual(unknown: Array) -> Array:
        dx, dz, nx, nz = slopes(unknown)
        bend = bending * (D @ unknown[:-2])
        balance = (D @ bend + dx * nz - dz * nx) / size
        balance[0], balance[-1] = bend[0] / (size * line.length), bend[-1] / (size * line.length)
        ends = [(integral @ dx)[-1] - line.x, (integral @ dz)[-1] - line.z]
        return np.concatenate([balance, np.array(ends) / line.length])

    H, V = hanging(line)
    start = np.arctan2(V - line.weight * (line.length - s), H)
    unknown = newton(residual, np.concatenate([start, [H / size, V / size]]))
    dx, dz, _, _ = slopes(unknown)
    return size * float(unknown[-2]), size * float(unknown[-1]), integral @ dx, integral @ dz


def swinging_cable(
    length: float, EA: float, bending: float, mass: float, rotary: float, gravity: float, degree: int = 64
) -> Array:
    """Angular frequencies of a heavy cable that hangs from a pin, stretched by its weight.

    Small motions of Kirchhoff's rod with stretch, ``mass`` and ``rotary`` inertia per unstretched length:

        u' = nu phi,   E I phi'' = nu (T phi - n) - w^2 rho I phi,   n' = -w^2 rho A u,

    with the tension T, the stretch nu = 1 + T / (E A) and the horizontal force n; Chebyshev collocation.
    """
    nodes, derivative = chebyshev(degree)
    s = 0.5 * length * (1.0 + nodes)
    D = derivative * 2.0 / length
    from_pin, from_tip = np.zeros_like(D), np.zeros_like(D)
    from_pin[1:, 1:] = np.linalg.inv(D[1:, 1:])
    from_tip[:-1, :-1] = np.linalg.inv(D[:-1, :-1])
    tension = mass * gravity * (length - s)
    stretch = 1.0 + tension / EA
    stiffness = np.diag(stretch * tension) - bending * D @ D
    inertia = -mass * stretch[:, None] * (from_tip @ from_pin) * stretch + rotary * np.eye(len(s))
    # No moment at the ends: their angles follow from the others.
    ends = [0, degree]
    inner = np.arange(1, degree)
    others = -np.linalg.solve(D[ends][:, ends], D[ends][:, inner])
    fill = np.zeros((degree + 1, degree - 1))
    fill[inner, np.arange(degree - 1)] = 1.0
    fill[ends] = others
    squares = 1.0 / np.linalg.eigvals(np.linalg.solve((stiffness @ fill)[inner], (inertia @ fill)[inner]))
    return np.asarray(np.sqrt(np.sort(squares.real[squares.real > 0.0])))


def pressed_cable(line: Line, bending: float, load: float, degree: int = 60) -> tuple[Array, Array, Array]:
    """Half of a cable between two hooks of equal height with a load at its middle: s, x and z from the hook.

    As `stiff_cable`, but symmetric, so that the middle is level; the load presses down.
    """
    nodes, derivative = chebyshev(degree)
    half = 0.5 * line.length
    s = 0.5 * half * (1.0 + nodes)
    D = derivative * 2.0 / half
    integral = np.zeros_like(D)
    integral[1:, 1:] = np.linalg.inv(D[1:, 1:])
    size = line.weight * line.length
    up = -0.5 * load - line.weight * (half - s)

    def slopes(unknown: Array) -> tuple[Array, Array, Array]:
        angle, H = unknown[:-1], size * unknown[-1]
        stretch = 1.0 + (H * np.cos(angle) + up * np.sin(angle)) / line.EA
        return stretch * np.cos(angle), stretch * np.sin(angle), H + 0.0 * s

    def residual(unknown: Array) -> Array:
        dx, dz, nx = slopes(unknown)
        bend = bending * (D @ unknown[:-1])
        balance = (D @ bend + dx * up - dz * nx) / size
        balance[0], balance[-1] = bend[0] / (size * line.length), unknown[-2]
        return np.append(balance, ((integral @ dx)[-1] - 0.5 * line.x) / line.length)

    H, _ = hanging(line)
    dx, dz, _ = slopes(newton(residual, np.append(np.arctan2(up, H), H / size)))
    return s, integral @ dx, integral @ dz


def crossing_cables(line: Line, bending: float, drop: float, distance: float) -> tuple[float, float, float]:
    """Heights of the middles of two equal cables that cross at right angles, and the force between them.

    The hooks of the second one are by ``drop`` lower, but it lies on the first one, ``distance`` above it.
    """

    def gap(load: float) -> float:
        return float(pressed_cable(line, bending, -load)[2][-1] - pressed_cable(line, bending, load)[2][-1])

    # Up to where the load is still small enough for the start of the collocation.
    load = bisect(lambda load: gap(load) - drop - distance, 0.0, 0.36 * line.weight * line.length)
    low = float(pressed_cable(line, bending, load)[2][-1])
    return low, low + distance, load
