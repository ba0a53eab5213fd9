"""Rods that several cases share, and how their shapes are drawn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..._lissom import Rod, Segment, StaticsResult, statics
from .case import Answer, Array, Curve, Plot

#: Points of a centre line in a plot.
POINTS = 121

#: A round rod of one metre with slenderness 1 / 100; the results do not depend on its material.
LENGTH, RADIUS, YOUNG, SHEAR = 1.0, 0.01, 1e9, 4e8
BENDING = YOUNG * np.pi / 4 * RADIUS**4
WEIGHTLESS = (0.0, 0.0, 0.0)

#: Standard gravity of lissom's rods, m/s^2.
GRAVITY = 9.81


def round_rod(modes: dict[str, int], *, density: float = 1000.0, nodes: int | None = None, **rod: Any) -> Rod:
    """That rod, without weight unless ``gravity`` is given."""
    segment = Segment(LENGTH, RADIUS, YOUNG, SHEAR, density, modes=modes, nodes=nodes)
    return Rod([segment], **({"gravity": WEIGHTLESS} | rod))


def density_for(weight: float) -> float:
    """The density that gives it a weight per length of ``weight`` E I / L^3."""
    return weight * BENDING / LENGTH**3 / (GRAVITY * np.pi * RADIUS**2)


#: Wanted points in a plot: name and two coordinates.
Points = Sequence[tuple[str, Any, Any]]


@dataclass(frozen=True)
class Plane:
    """Two world axes to draw in."""

    names: tuple[str, str] = ("x", "z")

    def of(self, positions: Array) -> tuple[Array, Array]:
        """The two coordinates of positions (..., 3)."""
        first, second = ("xyz".index(name) for name in self.names)
        return positions[..., first], positions[..., second]


XZ = Plane()


def centre_line(rod: Rod, q: Array) -> Array:
    """Positions along a rod, shape (points, 3)."""
    return rod.pose(q, np.linspace(0.0, rod.length, POINTS))[:, :3, 3]


def tip(rod: Rod, q: Array) -> Array:
    """Position of the tip of one state or of many."""
    return rod.pose(q, rod.length)[..., :3, 3]


def shape_plot(lines: Sequence[tuple[str, Array]], points: Points, plane: Plane = XZ) -> Plot:
    """Centre lines by lissom beside wanted points."""
    curves = [Curve(name, *plane.of(line)) for name, line in lines]
    curves += [Curve(name, x, y, joined=False) for name, x, y in points]
    return Plot(f"{plane.names[0]} (m)", f"{plane.names[1]} (m)", curves, to_scale=True)


def at_rest(
    models: Sequence[tuple[str, Rod]],
    values: Callable[[Rod, Array], Any],
    points: Callable[[], Points],
    plane: Plane = XZ,
    starts: Callable[[Rod], Array | None] = lambda rod: None,
) -> Answer:
    """The values of rods at rest, one after the other, and their shapes."""
    found: list[tuple[str, Rod, StaticsResult]] = [
        (name, rod, statics(rod, starts(rod))) for name, rod in models
    ]
    wrong = [result.message for _, _, result in found if not result.success]
    return Answer(
        np.concatenate([np.atleast_1d(values(rod, result.q)) for _, rod, result in found]),
        lambda: shape_plot([(name, centre_line(rod, r.q)) for name, rod, r in found], points(), plane),
        failure=" ".join(wrong),
    )
