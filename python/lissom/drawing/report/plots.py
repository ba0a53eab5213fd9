"""Plots as plain data; ``player/plots.js`` draws them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from .numerals import typeset
from .packing import Numbers, Type

#: Name of the clock of a report's motion, which synchronises curves over time.
MOTION = "motion"

#: Curves are rounding, and shown as zero, below this relative to the largest of their unit in a figure.
ROUNDING = 1e-12

Style = Literal["solid", "dash", "dot"]


@dataclass(frozen=True)
class Axis:
    """An axis; its range is that of the curves by default."""

    title: str
    log: bool = False
    range: tuple[float, float] | None = None


@dataclass(frozen=True)
class Curve:
    """Points, joined by a line, marked, or both."""

    #: Curves with the same name share an entry of the legend; unnamed curves have none.
    name: str
    x: NDArray[Any]
    y: NDArray[Any]
    colour: str
    style: Style = "solid"
    width: float = 1.8
    joined: bool = True
    mark: Literal["", "disc", "ring", "diamond"] = ""


@dataclass(frozen=True)
class Note:
    """A dotted line across a plot, with a label at its end."""

    #: Axis and position of the line.
    axis: Literal["x", "y"]
    at: float
    colour: str
    text: str = ""


@dataclass(frozen=True)
class Plot:
    """Curves with their axes."""

    x: Axis
    y: Axis
    curves: Sequence[Curve]
    title: str = ""
    notes: Sequence[Note] = ()
    #: Whether both axes have the same scale.
    to_scale: bool = False
    #: Width relative to the other plots of its row.
    width: float = 1.0


@dataclass(frozen=True)
class Figure:
    """Plots in rows, with one legend."""

    rows: Sequence[Sequence[Plot]]
    #: Height of a row, pixels.
    height: int
    #: The clock whose time is the x axis of all plots; empty for other x axes.
    clock: str = ""
    legend: bool = True

    @property
    def plots(self) -> list[Plot]:
        """All plots, row by row."""
        return [plot for row in self.rows for plot in row]

    @property
    def curves(self) -> list[Curve]:
        """All curves, plot by plot."""
        return [curve for plot in self.plots for curve in plot.curves]


@dataclass
class _SharedArrays:
    """Arrays for packing: an array shared by several curves remains shared."""

    known: dict[tuple[int, Type], Numbers] = field(default_factory=dict)

    def numbers(self, values: NDArray[Any], log: bool, kind: Type = "u2") -> Numbers:
        kind = "f4" if log else kind
        return self.known.setdefault((id(values), kind), Numbers(values, kind))


def document(figure: Figure) -> dict[str, Any]:
    """The player's document, with arrays for `packing.pack`."""
    arrays, figure = _SharedArrays(), without_rounding(figure)
    return {
        "height": figure.height,
        "clock": figure.clock,
        "legend": figure.legend,
        "rows": [[_plot(plot, arrays) for plot in row] for row in figure.rows],
    }


def without_rounding(figure: Figure) -> Figure:
    """The figure with zeros for curves that are rounding: motions in a plane have 1e-17 m across it."""
    largest: dict[str, float] = {}
    for plot in figure.plots:
        sizes = [_size(curve) for curve in plot.curves]
        largest[_unit(plot)] = max([largest.get(_unit(plot), 0.0), *sizes])
    rows = [[_zeroed(plot, ROUNDING * largest[_unit(plot)]) for plot in row] for row in figure.rows]
    return replace(figure, rows=rows)


def _unit(plot: Plot) -> str:
    """The text in the parentheses of the title, or all of it."""
    return plot.y.title.partition(" (")[2] or plot.y.title


def _size(curve: Curve) -> float:
    y = np.abs(np.asarray(curve.y, float))
    return float(y[np.isfinite(y)].max(initial=0.0))


def _zeroed(plot: Plot, least: float) -> Plot:
    """The plot with zeros for curves that stay below a value."""
    if plot.y.log:
        return plot
    curves = [
        replace(curve, y=np.where(np.isfinite(curve.y), 0.0, np.nan)) if _size(curve) < least else curve
        for curve in plot.curves
    ]
    return replace(plot, curves=curves)


def _plot(plot: Plot, arrays: _SharedArrays) -> dict[str, Any]:
    return {
        "title": typeset(plot.title),
        "x": _axis(plot.x),
        "y": _axis(plot.y),
        "toScale": plot.to_scale,
        "width": plot.width,
        "label": typeset(in_words(plot)),
        "notes": [{**vars(note), "text": typeset(note.text)} for note in plot.notes],
        "curves": [
            {
                **vars(curve),
                "name": typeset(curve.name),
                "x": arrays.numbers(curve.x, plot.x.log, "u4"),
                "y": arrays.numbers(curve.y, plot.y.log),
            }
            for curve in plot.curves
        ],
    }


def _axis(axis: Axis) -> dict[str, Any]:
    return {"title": axis.title, "log": axis.log, "range": axis.range}


def in_words(plot: Plot) -> str:
    """Text alternative of a plot: its axes, and the range of each curve."""
    parts = []
    for curve in plot.curves:
        y = np.asarray(curve.y, float)
        known = y[np.isfinite(y)]
        name = curve.name or plot.y.title
        if len(known) == 0:
            parts.append(f"{name}: no finite values")
        else:
            first, last = known[0], known[-1]
            parts.append(
                f"{name}: from {first:.3g} to {last:.3g}, least {known.min():.3g}, largest {known.max():.3g}"
            )
    title = f"{plot.title}: " if plot.title else ""
    return f"{title}{plot.y.title or 'value'} over {plot.x.title or 'x'}. {'; '.join(parts)}."
