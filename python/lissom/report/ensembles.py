"""The report of many runs: how they spread, and which of them failed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .._lissom import EnsembleResult, Model
from ..datasets import coordinates
from ..results import Array
from ..spread import BAND, quantiles
from ..views import Coordinate
from . import page, plots, theme

#: Rows of the table of runs that failed.
LISTED = 20

#: Most coordinates that are shown; the first ones.
SHOWN = 12

#: Plots in a row of a figure.
BESIDE = 2


def build(result: EnsembleResult, title: str, model: Model | None) -> page.Page:
    """What the report says."""
    good, count = int(np.count_nonzero(result.success)), len(result)
    known = coordinates(model, result.q.shape[-1])
    sections = [page.Section("Coordinates", [_coordinates(result, known)])] if good else []
    if result.mean is not None and good:
        sections.append(page.Section("Places", [_places(result)]))
    if good < count:
        sections.append(page.Section("Runs that failed", [_failed(result)]))
    doubts = [doubt for doubt in result.doubt if doubt]
    rows = [
        ("runs", f"{count:,}, of which {good:,} came to their end"),
        ("what was kept", result.keep),
        ("accepted steps", f"{int(np.nansum(result.stats['steps'])):,}"),
        ("time of all runs", f"{result.wall_time:.3g} s, at most {result.workers} at once"),
        ("memory of the arrays", f"{result.nbytes / 1e6:.3g} MB"),
    ]
    sections.append(page.Section("Result", [page.Table(("", ""), rows)]))
    return page.Page(
        title=title,
        lead=f"{count:,} runs, {result.q.shape[-1]} generalised coordinates.",
        outcome=(f"{good:,} of {count:,} runs came to their end", good == count),
        advice=[f"{len(doubts):,} of {count:,} runs: {doubts[0]}"] if doubts else (),
        sections=sections,
    )


def _in_rows(shown: list[plots.Plot]) -> list[list[plots.Plot]]:
    return [shown[i : i + BESIDE] for i in range(0, len(shown), BESIDE)]


def _coordinates(result: EnsembleResult, known: Sequence[Coordinate]) -> page.Figure:
    bands = quantiles(result) if result.keep == "states" else None
    shown = []
    for i, coordinate in enumerate(known[:SHOWN]):
        axis = plots.Axis(f"{coordinate.name} ({coordinate.unit})" if coordinate.unit else coordinate.name)
        shown.append(_ends(result, i, axis) if bands is None else _over_time(result.t, bands[:, :, i], axis))
    rest = f" The first {SHOWN} of {len(known)} coordinates." if len(known) > SHOWN else ""
    if result.keep == "states":
        low, high = (f"{100 * level:g}" for level in BAND)
        caption = f"Median, {low} and {high} percent quantiles of the runs that came to their end.{rest}"
    else:
        caption = f"The last coordinates of each run that came to its end.{rest}"
    return page.Figure(plots.Figure(_in_rows(shown), 240, "", legend=result.keep == "states"), caption)


def _over_time(t: Array, band: Array, axis: plots.Axis) -> plots.Plot:
    low, middle, high = band
    curves = [
        plots.Curve("median", t, middle, theme.BLUE),
        plots.Curve("low and high", t, low, theme.GREY, "dash"),
        plots.Curve("low and high", t, high, theme.GREY, "dash"),
    ]
    return plots.Plot(plots.Axis("time (s)"), axis, curves)


def _ends(result: EnsembleResult, i: int, axis: plots.Axis) -> plots.Plot:
    rows = np.flatnonzero(result.success)
    marks = plots.Curve("", rows.astype(float), result.q[rows, i], theme.BLUE, joined=False, mark="disc")
    return plots.Plot(plots.Axis("row"), axis, [marks])


def _places(result: EnsembleResult) -> page.Figure:
    assert result.mean is not None
    assert result.variance is not None
    deviation: Array = np.sqrt(result.variance)
    shown = []
    for k in range(result.mean.shape[1]):
        curves = []
        for i, (name, colour) in enumerate(zip("xyz", theme.SERIES, strict=False)):
            mean, width = result.mean[:, k, i], deviation[:, k, i]
            curves.append(plots.Curve(name, result.t, mean, colour))
            curves += [plots.Curve("", result.t, mean + sign * width, colour, "dot", 1.0) for sign in (-1, 1)]
        shown.append(plots.Plot(plots.Axis("time (s)"), plots.Axis(f"position of place {k} (m)"), curves))
    caption = "Mean of the runs that came to their end, and one standard deviation to both sides."
    return page.Figure(plots.Figure(_in_rows(shown), 260, ""), caption)


def _failed(result: EnsembleResult) -> page.Table:
    bad = np.flatnonzero(~result.success)
    rows = [
        (str(row), str(result.status[row]), f"{result.reached[row]:.6g}", result.message[row])
        for row in bad[:LISTED]
    ]
    more = f" The first {LISTED} of {len(bad):,}." if len(bad) > LISTED else ""
    return page.Table(("row", "status", "reached (s)", "message"), rows, caption=f"Rows count from 0.{more}")
