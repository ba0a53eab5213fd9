"""Reference values of plane frames and arches, by shooting with NumPy alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .exact import DIFFERENCE, MOST_STEPS, Array, bisect

#: Number of Runge-Kutta steps along a leg: twice as many change no digit of the gallery.
STEPS = 80
#: Relative change with which Newton's method ends, and part of the first step with which secants end: a load
#: is
#: extremal, and right to the square of that.
SMALL_CHANGE, SMALL_PART = 1e-8, 1e-3


@dataclass(frozen=True)
class Beam:
    """A plane beam that does not shear; ``curvature`` bends its axis upwards where it is unloaded."""

    length: float
    EI: float
    EA: float
    curvature: float = 0.0


def marched(
    start: Array, beam: Beam, length: float, pressure: Array | float = 0.0, steps: int = STEPS
) -> Array:
    """States along a beam, shape (steps + 1, 6, columns): x, z, angle, moment and force (x, z).

    ``pressure`` pushes per unstretched length along the normal, to the right of the direction of the beam. A
    negative ``length`` marches backwards.
    """

    def slopes(y: Array) -> Array:
        _, _, angle, moment, nx, nz = y
        cos, sin = np.cos(angle), np.sin(angle)
        stretch = 1.0 + (nx * cos + nz * sin) / beam.EA
        dx, dz = stretch * cos, stretch * sin
        bend = beam.curvature + moment / beam.EI
        return np.array([dx, dz, bend, nx * dz - nz * dx, -pressure * sin, pressure * cos])

    h, y = length / steps, start
    line = [y]
    for _ in range(steps):
        a = slopes(y)
        b = slopes(y + 0.5 * h * a)
        c = slopes(y + 0.5 * h * b)
        y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + slopes(y + h * c))
        line.append(y)
    return np.array(line)


def limit_point(miss: Callable[[Array], Array], start: Array, further: float) -> Array:
    """Limit point of a path: unknowns of which the first leads along the path, and the last is the load.

    ``miss`` maps columns of unknowns to columns of one equation less. Where the load is extremal, its rate
    along the path vanishes: secants, from the start and ``further`` along the path.
    """
    found = start

    def rate(lead: float) -> float:
        """Rate of the load where the path has this leading unknown; moves ``found`` there."""
        nonlocal found
        found = np.concatenate([[lead], found[1:]])
        for _ in range(MOST_STEPS):
            steps = DIFFERENCE * np.maximum(1.0, np.abs(found))
            values = miss(found[:, None] + np.column_stack([np.zeros_like(found), np.diag(steps)]))
            rates = (values[:, 1:] - values[:, :1]) / steps
            change = -np.linalg.solve(rates[:, 1:], values[:, 0])
            found = found + np.concatenate([[0.0], change])
            if np.abs(change).max() <= SMALL_CHANGE * np.abs(found).max():
                return float(-np.linalg.solve(rates[:, 1:], rates[:, 0])[-1])
        raise ArithmeticError("shooting has not converged")

    last, lead = float(start[0]), float(start[0]) + further
    before, now = rate(last), rate(lead)
    for _ in range(MOST_STEPS):
        last, lead, before = lead, lead - now * (lead - last) / (now - before), now
        now = rate(lead)
        if abs(lead - last) <= SMALL_PART * abs(further):
            return found
    raise ArithmeticError("the secants have not converged")


@dataclass(frozen=True)
class LeeFrame:
    """Two equal legs at a right angle between pins, the first one upright, with a load on the second one.

    Lee, Manuel and Rossow (1968), Large deflections and stability of elastic frames.
    """

    leg: Beam
    #: Distance of the load from the corner.
    at: float
    follows: bool

    def ends(self, unknown: Array) -> tuple[Array, Array]:
        """States at the load and at the second foot, for unknown columns of the first foot's angle, its force
        (x, z) and the load; forces in units of E I / L^2."""
        angle, nx, nz, load = unknown
        unit = self.leg.EI / self.leg.length**2
        zero = np.zeros_like(angle)
        y = np.array([zero, zero, 0.5 * np.pi + angle, zero, unit * nx, unit * nz])
        y = marched(y, self.leg, self.leg.length)[-1]
        y = y - np.array([0.0, 0.0, 0.5 * np.pi, 0.0, 0.0, 0.0])[:, None]
        loaded = marched(y, self.leg, self.at, steps=STEPS // 4)[-1]
        turn = loaded[2] if self.follows else zero
        push = unit * load * np.array([zero, zero, zero, zero, np.sin(turn), -np.cos(turn)])
        return loaded, marched(loaded - push, self.leg, self.leg.length - self.at)[-1]

    def miss(self, unknown: Array) -> Array:
        """What the second foot misses, relative."""
        _, end = self.ends(unknown)
        length = self.leg.length
        return np.array([end[0] / length - 1.0, end[1] / length - 1.0, end[3] * length / self.leg.EI])

    def at_limit(self, start: tuple[float, float, float, float]) -> Array:
        """The unknowns at a limit of the load near a start."""
        return limit_point(self.miss, np.array(start), 1e-2)

    def limit(self, start: tuple[float, float, float, float]) -> tuple[float, float, float]:
        """A limit load, and how far the loaded point has moved to the right and down, near a start."""
        found = self.at_limit(start)
        loaded, _ = self.ends(found[:, None])
        load = float(found[3]) * self.leg.EI / self.leg.length**2
        return load, float(loaded[0, 0]) - self.at, self.leg.length - float(loaded[1, 0])


def bent_frame(leg: Beam, force: float) -> tuple[float, float, float]:
    """Displacement (x, z) of the tip of a frame, and its turn clockwise, under a force that stays normal "
    "to it.

    The first leg is clamped and points along x, the second one hangs from its end. From the tip inwards the
    force is known: an initial value problem.
    """
    y = np.array([0.0, 0.0, 0.0, 0.0, 0.0, -force])[:, None]
    y = marched(y, leg, -leg.length)[-1]
    y = y + np.array([0.0, 0.0, 0.5 * np.pi, 0.0, 0.0, 0.0])[:, None]
    x, z, angle, *_ = marched(y, leg, -leg.length)[-1][:, 0]
    cos, sin = np.cos(-angle), np.sin(-angle)
    tip = -np.array([x * cos - z * sin, x * sin + z * cos])
    return float(tip[0] - leg.length), float(tip[1] + leg.length), float(angle - 0.5 * np.pi)


def arch_limit(leg: Beam, opening: float, start: tuple[float, float, float, float]) -> tuple[float, float]:
    """First limit of the pressure on an arch between clamps that stays symmetric, times R^3 / (E I), and how
    far its crown has come down, in units of R. Near a start of drop, thrust, moment and pressure."""
    radius = 1.0 / abs(leg.curvature)
    half = 0.5 * opening

    def miss(unknown: Array) -> Array:
        drop, thrust, moment, load = unknown
        zero = np.zeros_like(drop)
        unit = leg.EI / radius**2
        y = np.array([zero, zero - drop * radius, zero, moment * leg.EI / radius, -unit * thrust, zero])
        end = marched(y, leg, 0.5 * leg.length, unit / radius * load, 2 * STEPS)[-1]
        place = radius * np.array([np.sin(half), np.cos(half) - 1.0])
        return np.array([*((end[:2] - place[:, None]) / radius), end[2] + half])

    found = limit_point(miss, np.array(start), 1e-3)
    return float(found[3]), float(found[0])


def arch_sway(opening: float) -> float:
    """Pressure q R^3 / (E I) at which an arch between clamps, which cannot stretch, sways: k^2 - 1 with
    k tan(a) cot(k a) = 1 and half the opening a (Timoshenko and Gere 1961, section 7.6)."""
    half = 0.5 * opening

    def equation(k: float) -> float:
        return float(k * np.sin(half) * np.cos(k * half) - np.cos(half) * np.sin(k * half))

    return bisect(equation, np.pi / half, 1.75 * np.pi / half) ** 2 - 1.0
