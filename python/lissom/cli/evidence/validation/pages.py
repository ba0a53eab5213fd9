"""The report of the validation gallery: the table, and one plot per case."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from ....common import disk
from ....drawing.report import page, plots, theme
from ....drawing.report.text import quantity
from . import table
from .case import Outcome, Plot

COLUMNS = ("case", "source", "wanted", "lissom", "error", "tolerance", "time", "")
NUMERIC = frozenset({"wanted", "lissom", "error", "tolerance", "time", "difference"})

LEAD = (
    "Questions with known answers: closed forms, the same equations solved by other means, published "
    "numbers. Run again with “lissom validate”."
)


def write(outcomes: Sequence[Outcome], path: Path) -> None:
    """Write the report to ``path``."""
    disk.write(path, page.render(build(outcomes)))


def build(outcomes: Sequence[Outcome]) -> page.Page:
    """Content of the report."""
    good = sum(outcome.good for outcome in outcomes)
    asked = sum(not outcome.not_run for outcome in outcomes)
    caption = "Of several values the one that is furthest off; the others are below."
    overview = page.Table(COLUMNS, [_row(outcome) for outcome in outcomes], NUMERIC, caption)
    return page.Page(
        title="Validation gallery",
        lead=LEAD,
        outcome=(table.verdict(outcomes), good == asked),
        tiles=[
            (f"{good} of {asked}", "within tolerance"),
            (
                quantity(sum(outcome.seconds for outcome in outcomes if not outcome.not_run), "s"),
                "lissom's time, all cases",
            ),
        ],
        sections=[page.Section("All cases", [overview]), *map(_section, outcomes)],
        contents=True,
    )


def _row(outcome: Outcome) -> tuple[str, ...]:
    if outcome.not_run:
        return outcome.case.name, table.source(outcome.case), "–", "–", "–", "–", "–", "not run"
    wanted, found = table.worst(outcome)
    return (
        outcome.case.name,
        table.source(outcome.case),
        table.number(wanted),
        table.number(found),
        *_measures(outcome),
        "good" if outcome.good else "outside",
    )


def _measures(outcome: Outcome) -> tuple[str, str, str]:
    time = quantity(outcome.seconds, "s")
    return table.error(outcome), f"{outcome.case.tolerance:.0e}", time


def _section(outcome: Outcome) -> page.Section:
    case = outcome.case
    parts: list[page.Part] = [case.setting]
    if outcome.not_run:
        return page.Section(case.name, [*parts, page.Lesson(f"Not run: {outcome.not_run}.")])
    if outcome.failure:
        parts.append(page.Lesson(outcome.failure))
    if outcome.plot is not None:
        parts.append(page.Figure(figure(outcome.plot)))
    columns = ("wanted", "lissom", "difference")
    rows = [
        (f"{wanted:.10g}", f"{found:.10g}", f"{found - wanted:.1e}")
        for wanted, found in zip(outcome.wanted, outcome.found, strict=False)
    ]
    error, tolerance, time = _measures(outcome)
    caption = (
        f"Values: {case.quantity}. Source: {table.source(case)}. "
        f"{f'Others: {case.others}. ' if case.others else ''}"
        f"Error {error}, tolerance {tolerance}, time {time}."
    )
    parts.append(page.Table(columns, rows, NUMERIC, caption))
    return page.Section(case.name, parts)


def figure(plot: Plot) -> plots.Figure:
    """The plot of a case: lissom's curves as lines, reference values as open circles."""
    curves, counts = [], {True: 0, False: 0}
    for curve in plot.curves:
        colour = theme.SERIES[counts[curve.joined] % len(theme.SERIES)]
        counts[curve.joined] += 1
        x, y = np.asarray(curve.x, float), np.asarray(curve.y, float)
        mark: Literal["", "ring"] = "" if curve.joined else "ring"
        curves.append(plots.Curve(curve.name, x, y, colour, width=2.2, joined=curve.joined, mark=mark))
    made = plots.Plot(plots.Axis(plot.x), plots.Axis(plot.y), curves, to_scale=plot.to_scale)
    return plots.Figure([[made]], 420)
