"""The report of the stress test: a map of cells for every group."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ....common import disk
from ....drawing.report import page, theme
from . import Done, total
from .cell import KINDS, MEANINGS, Kind, Outcome

#: From good to bad; distinguishable without red-green vision.
COLOURS: dict[Kind, str] = {
    "accurate": theme.GREEN,
    "slow": "#e3c34a",
    "refused": theme.BLUE,
    "failed": theme.ORANGE,
    "wrong": "#8b1a2b",
}


def write(done: list[Done], regressions: list[str], path: Path) -> None:
    """Write the report to ``path``."""
    disk.write(path, page.render(build(done, regressions)))


def build(done: list[Done], regressions: Sequence[str]) -> page.Page:
    """Content of the report."""
    counts = total(done)
    good = not regressions
    return page.Page(
        title="Stress test",
        lead="Hard cases for a rod simulator: each of them ends well, or says why it does not.",
        outcome=("Nothing regressed" if good else f"{len(regressions)} cells regressed or are wrong", good),
        tiles=[(f"{counts[kind]:,}", kind) for kind in KINDS],
        sections=[_summary(done, regressions), *(_section(group) for group in done)],
        contents=True,
    )


def _summary(done: list[Done], regressions: Sequence[str]) -> page.Section:
    rows = [
        (group.group.title, *(str(group.counts[kind]) for kind in KINDS), f"{_seconds(group):.1f} s")
        for group in done
    ]
    columns = ("group", *KINDS, "time")
    parts: list[page.Part] = [
        page.Table(columns, rows, frozenset(columns[1:])),
        page.Table(("outcome", "means"), list(MEANINGS.items())),
    ]
    if regressions:
        parts.append(
            page.Table(("worse than in the committed table, or wrong",), [(cell,) for cell in regressions])
        )
    return page.Section("Summary", parts)


def _seconds(done: Done) -> float:
    return sum(outcome.seconds for outcome in done.outcomes)


def _section(done: Done) -> page.Section:
    group = done.group
    parts: list[page.Part] = [_map(done)]
    if group.lesson:
        parts.append(page.Lesson(group.lesson))
    bad = [
        (cell.row, cell.column, outcome.kind, outcome.reason)
        for cell, outcome in zip(group.cells, done.outcomes, strict=True)
        if outcome.kind != "accurate"
    ]
    if bad:
        lines = "\n".join(f"{row}, {column}: {kind}. {reason}" for row, column, kind, reason in bad)
        parts.append(page.Source(f"The {len(bad)} cells that are not accurate, and why", lines))
    return page.Section(group.title, parts)


def _map(done: Done) -> page.Cells:
    """The cells in the colours of their outcomes."""
    group = done.group
    rows = list(dict.fromkeys(cell.row for cell in group.cells))
    columns = list(dict.fromkeys(cell.column for cell in group.cells))
    cells: list[list[page.Cell | None]] = [[None] * len(columns) for _ in rows]
    for cell, outcome in zip(group.cells, done.outcomes, strict=True):
        details = f"{cell.row}, {cell.column}: {outcome.kind}. {_details(outcome)}"
        shown = page.Cell(outcome.kind, _label(outcome), details)
        cells[rows.index(cell.row)][columns.index(cell.column)] = shown
    colours: dict[str, str] = {kind: COLOURS[kind] for kind in KINDS}
    return page.Cells(f"{group.rows} \\ {group.columns}", rows, columns, cells, colours, group.text)


def _label(outcome: Outcome) -> str:
    """Text of a cell: the error if there is one."""
    if outcome.error is None or outcome.kind in ("refused", "failed"):
        return outcome.kind
    return f"{outcome.error:.0e}"


def _details(outcome: Outcome) -> str:
    facts = [f"{outcome.seconds:.2g} s"]
    if outcome.error is not None:
        facts.insert(0, f"error {outcome.error:.1e}")
    if outcome.evaluations:
        facts.append(f"{outcome.evaluations:,} evaluations")
    return f"{outcome.reason} ({', '.join(facts)})"
