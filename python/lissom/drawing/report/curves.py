"""Curves over time: coordinates, tip, energies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle

import numpy as np
from numpy.typing import NDArray

from ..._lissom import LissomError
from ...model.views import Coordinate, Frame, Member
from ...results.runs import Array, Made, Run
from ...results.runs import energies as named_energies
from . import theme
from .plots import MOTION, Axis, Curve, Figure, Plot, Style

Instants = NDArray[np.intp]

#: Maximum number of points per curve; more are not visible.
MAX_POINTS = 2000

#: Maximum number of values in the curves of all links together.
MAX_NUMBERS = 200_000

#: Line styles of successive segments.
STYLES: tuple[Style, ...] = ("solid", "dash", "dot")

#: Colours of components along the axes of the world.
AXIS_COLOURS = {"x": theme.RED, "y": theme.GREEN, "z": theme.BLUE}

TIME = Axis("time (s)")

#: Axis of a plot above others, which share the time axis below.
UNNAMED = Axis("")

#: Rounding of a sum of energies, relative to the largest of its terms.
ROUNDING = 8.0 * np.finfo(float).eps

#: Heights of a row in pixels: with several plots, and with one.
ROW, ALONE = 210, 320


def coordinates(run: Run | Made) -> Figure:
    """All coordinates over time, one plot for each kind."""
    all_of_them = run.view.coordinates
    several = any(coordinate.segment > 0 for coordinate in all_of_them)
    at = run.instants(MAX_POINTS)
    t, q = run.t[at], run.q[at]
    plots: dict[str, list[Curve]] = {}
    for i, coordinate in enumerate(all_of_them):
        number = i if coordinate.degree is None else coordinate.degree
        curve = Curve(
            _label(coordinate, several),
            t,
            q[:, i],
            theme.SERIES[number % len(theme.SERIES)],
            STYLES[coordinate.segment % len(STYLES)],
        )
        plots.setdefault(f"{coordinate.kind} ({coordinate.unit})", []).append(curve)
    return _one_above_the_other(plots, legend=len(all_of_them) > 1)


def _label(coordinate: Coordinate, several: bool) -> str:
    """Label of a coordinate among those of its kind, for models with one or several segments."""
    if coordinate.degree is None:
        return coordinate.kind
    degree = f"P{str(coordinate.degree).translate(str.maketrans('0123456789', '₀₁₂₃₄₅₆₇₈₉'))}"
    return f"segment {coordinate.segment + 1}, {degree}" if several else degree


def position(run: Run | Made, frame: Frame, at: Instants | None = None) -> Figure:
    """Position of a frame over time, at the given indices or at as many as are visible."""
    at = run.instants(MAX_POINTS) if at is None else at
    positions = frame.pose(run.q[at], run.t[at])[:, :3, 3]
    t = run.t[at]
    curves = [
        Curve(name, t, positions[:, i], colour) for i, (name, colour) in enumerate(AXIS_COLOURS.items())
    ]
    return over_time(f"position of the {frame.name} (m)", curves)


def over_time(title: str, curves: Sequence[Curve], height: int = ALONE, legend: bool = True) -> Figure:
    """One plot over the time of the motion."""
    return Figure([[Plot(TIME, Axis(title), curves)]], height, MOTION, legend)


def instants(run: Run | Made) -> Instants:
    """Instants for the curves of the links: fewer if there are many curves."""
    # Three components of the position and six of the wrench.
    curves = run.q.shape[1] + 9 * len(run.view.members)
    return run.instants(int(np.clip(MAX_NUMBERS // curves, 2, MAX_POINTS)))


def coordinates_of(run: Run | Made, member: Member, at: Instants) -> Figure | None:
    """The coordinates of a link by name, one plot per kind; None without coordinates."""
    own = list(enumerate(run.view.coordinates))[member.coordinates]
    kinds: dict[tuple[str, str], list[tuple[str, Array]]] = {}
    for i, coordinate in own:
        curve = (coordinate.name, run.q[at, i])
        kinds.setdefault((coordinate.kind, coordinate.unit), []).append(curve)
    plots = {f"{kind} ({unit})": curves for (kind, unit), curves in kinds.items()}
    return stacked(run.t[at], plots) if plots else None


def wrench_of(run: Run | Made, member: Member, at: Instants) -> Figure | None:
    """Force and moment transmitted through a link's joint; None without accelerations."""
    known = at[np.isfinite(run.a[at]).all(axis=1)]
    if len(known) == 0:
        return None
    try:
        wrench = member.wrench(run.q[known], run.v[known], run.a[known], run.t[known], run.u[known])
    except (ValueError, LissomError):
        # The last state of a failed run can overflow.
        return None
    plots = {
        name: list(zip("xyz", wrench[:, rows].T, strict=True))
        for name, rows in (("force (N)", slice(3, 6)), ("moment (N m)", slice(3)))
    }
    return stacked(run.t[known], plots)


def stacked(t: Array, plots: Mapping[str, Sequence[tuple[str, Array]]]) -> Figure:
    """Plots over time, one above the other; each contains curves by name."""
    made = {
        title: [
            Curve(name, t, values, AXIS_COLOURS.get(name, colour))
            for (name, values), colour in zip(curves, cycle(theme.SERIES), strict=False)
        ]
        for title, curves in plots.items()
    }
    return _one_above_the_other(made)


def _one_above_the_other(plots: Mapping[str, Sequence[Curve]], legend: bool = True) -> Figure:
    last = len(plots) - 1
    rows = [
        [Plot(TIME if i == last else UNNAMED, Axis(title), curves)]
        for i, (title, curves) in enumerate(plots.items())
    ]
    return Figure(rows, ROW if last else ALONE, MOTION, legend)


def energies(run: Run | Made) -> Figure:
    """Parts of the energy over time; parts that are always zero are omitted."""
    at = run.instants(MAX_POINTS)
    t = run.t[at]
    return over_time(
        "energy (J)",
        [
            Curve(name, t, values[at], theme.ENERGY_COLOURS[name], width=2.4 if name == "total" else 1.8)
            for name, values in named_energies(run.balance).items()
            if name in ("kinetic", "total") or np.any(values)
        ],
        380,
    )


def drift(run: Run | Made) -> Figure:
    """Change of the total energy, which is constant for an exact motion."""
    at = run.instants(MAX_POINTS)
    with np.errstate(invalid="ignore"):
        # After an overflow the difference is not defined.
        change = (run.balance.total - run.balance.total[0])[at]
        terms = np.abs(np.stack(list(named_energies(run.balance).values())))
        change[np.abs(change) <= ROUNDING * np.nanmax(terms, initial=0.0)] = 0.0
    curve = Curve("defect", run.t[at], change, theme.ENERGY_COLOURS["total"], width=1.5)
    return over_time("total − its start (J)", [curve], ROW, legend=False)
