"""The report of an ensemble: spread and failed runs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..._lissom import EnsembleResult, Model
from ...analysis.quantiles import BAND, band, quantiles
from ...model.views import Coordinate
from ...results.datasets import coordinates
from ...results.runs import Array
from . import page, plots, theme

#: Maximum number of rows in the table of failed runs.
LISTED = 20

#: Maximum number of coordinates shown.
SHOWN = 12

#: Number of plots per row of a figure.
BESIDE = 2


def build(result: EnsembleResult, title: str, model: Model | None) -> page.Page:
    """Content of the report."""
    good, count = int(np.count_nonzero(result.success)), len(result)
    known = coordinates(model, result.q.shape[-1])
    sections = []
    if good:
        sections.append(page.Section("Coordinates", [_coordinates(result, known), _extremes(result, known)]))
        if places := _places(result):
            sections.append(page.Section("Places", [places]))
    if good < count:
        sections.append(page.Section("Runs that failed", [_by_status(result), _failed(result)]))
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
        outcome=(
            f"{good:,} of {count:,} runs came to their end{_with(len(doubts))}",
            good == count and not doubts,
        ),
        advice=[f"{len(doubts):,} of {count:,} runs: {doubts[0]}"] if doubts else (),
        sections=sections,
    )


def _with(doubts: int) -> str:
    return f", {doubts:,} with doubts" if doubts else ""


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


def _extremes(result: EnsembleResult, known: Sequence[Coordinate]) -> page.Table:
    """Minimum and maximum of each coordinate over the completed runs."""
    lowest = result.q if result.lowest is None else result.lowest
    highest = result.q if result.highest is None else result.highest
    times = tuple(range(result.q[result.success].ndim - 1))
    low, high = lowest[result.success].min(axis=times), highest[result.success].max(axis=times)
    rows = [
        (
            f"{coordinate.name} ({coordinate.unit})" if coordinate.unit else coordinate.name,
            f"{a:.6g}",
            f"{b:.6g}",
        )
        for coordinate, a, b in zip(known[:SHOWN], low, high, strict=False)
    ]
    when = "of their last states" if result.keep == "final" else "at any time"
    return page.Table(("coordinate", "lowest", "highest"), rows, caption=f"Of all these runs, {when}.")


def _places(result: EnsembleResult) -> page.Figure | None:
    """Positions of the places over time; None if they were not stored."""
    if result.mean is not None and result.variance is not None:
        width: Array = np.sqrt(result.variance)
        low, middle, high = result.mean - width, result.mean, result.mean + width
        caption = "Mean of the runs that came to their end, and one standard deviation to both sides."
    elif result.keep == "states" and result.poses is not None:
        low, middle, high = band(result.poses[result.success][..., :3, 3])
        below, above = (f"{100 * level:g}" for level in BAND)
        caption = f"Median, {below} and {above} percent quantiles of the runs that came to their end."
    else:
        return None
    shown = []
    for k in range(middle.shape[1]):
        curves = []
        for i, (name, colour) in enumerate(zip("xyz", theme.SERIES, strict=False)):
            curves.append(plots.Curve(name, result.t, middle[:, k, i], colour))
            edges = (low[:, k, i], high[:, k, i])
            curves += [plots.Curve("", result.t, edge, colour, "dot", 1.0) for edge in edges]
        shown.append(plots.Plot(plots.Axis("time (s)"), plots.Axis(f"position of place {k} (m)"), curves))
    return page.Figure(plots.Figure(_in_rows(shown), 260, ""), caption)


def _by_status(result: EnsembleResult) -> page.Table:
    """Number of runs by status."""
    known, counts = np.unique(result.status, return_counts=True)
    order = np.argsort(-counts, kind="stable")
    return page.Table(("status", "runs"), [(str(known[i]), f"{counts[i]:,}") for i in order])


def _failed(result: EnsembleResult) -> page.Table:
    bad = np.flatnonzero(~result.success)
    rows = [
        (str(row), str(result.status[row]), f"{result.reached[row]:.6g}", result.message[row])
        for row in bad[:LISTED]
    ]
    more = f" The first {LISTED} of {len(bad):,}." if len(bad) > LISTED else ""
    return page.Table(("row", "status", "reached (s)", "message"), rows, caption=f"Rows count from 0.{more}")
