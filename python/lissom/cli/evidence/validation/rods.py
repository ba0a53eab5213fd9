"""Rods used by several cases, and plots of their shapes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...._lissom import Rod, Segment, StaticsResult, statics
from .case import Answer, Array, Curve, Plot

#: Number of points of a centre line in a plot.
POINTS = 121

#: A circular rod of one metre with slenderness 1 / 100; the results do not depend on its material.
LENGTH, RADIUS, YOUNG, SHEAR = 1.0, 0.01, 1e9, 4e8
BENDING = YOUNG * np.pi / 4 * RADIUS**4
WEIGHTLESS = (0.0, 0.0, 0.0)

#: Default gravity of rods, m/s^2.
GRAVITY = 9.81


def round_rod(modes: dict[str, int], *, density: float = 1000.0, nodes: int | None = None, **rod: Any) -> Rod:
    """This rod, without weight unless ``gravity`` is given."""
    segment = Segment(LENGTH, RADIUS, YOUNG, SHEAR, density, modes=modes, nodes=nodes)
    return Rod([segment], **({"gravity": WEIGHTLESS} | rod))


def density_for(weight: float) -> float:
    """Density for a weight per length of ``weight`` E I / L^3."""
    return weight * BENDING / LENGTH**3 / (GRAVITY * np.pi * RADIUS**2)


#: Reference points of a plot: name and two coordinates.
Points = Sequence[tuple[str, Any, Any]]


@dataclass(frozen=True)
class Plane:
    """Two world axes of a plot."""

    names: tuple[str, str] = ("x", "z")

    def of(self, positions: Array) -> tuple[Array, Array]:
        """Both coordinates of positions (..., 3)."""
        first, second = ("xyz".index(name) for name in self.names)
        return positions[..., first], positions[..., second]


XZ = Plane()


def centre_line(rod: Rod, q: Array) -> Array:
    """Positions along a rod, shape (points, 3)."""
    return rod.pose(q, np.linspace(0.0, rod.length, POINTS))[:, :3, 3]


def tip(rod: Rod, q: Array) -> Array:
    """Tip position for one state or many."""
    return rod.pose(q, rod.length)[..., :3, 3]


def shape_plot(lines: Sequence[tuple[str, Array]], points: Points, plane: Plane = XZ) -> Plot:
    """lissom's centre lines beside reference points."""
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
    """Values of several rods at equilibrium, and their shapes."""
    found: list[tuple[str, Rod, StaticsResult]] = [
        (name, rod, statics(rod, starts(rod))) for name, rod in models
    ]
    wrong = [result.message for _, _, result in found if not result.success]
    return Answer(
        np.concatenate([np.atleast_1d(values(rod, result.q)) for _, rod, result in found]),
        lambda: shape_plot([(name, centre_line(rod, r.q)) for name, rod, r in found], points(), plane),
        failure=" ".join(wrong),
    )
