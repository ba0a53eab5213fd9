"""The report of the stress test: a heat map for every group."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ...report import page, theme
from . import Done, total
from .cell import KINDS, MEANINGS, Kind, Outcome

#: From good to bad, and apart for eyes that do not tell red from green.
COLOURS: dict[Kind, str] = {
    "accurate": theme.GREEN,
    "slow": "#e3c34a",
    "refused": theme.BLUE,
    "failed": theme.ORANGE,
    "wrong": "#8b1a2b",
}

#: Height of a row of a heat map, and of what is around it, pixels.
ROW, AROUND = 30, 130

#: Letters of a reason before it goes on in a new line, where the pointer is.
LINE = 70


def write(done: list[Done], regressions: list[str], path: Path) -> None:
    """Write the report to ``path``. Needs plotly."""
    path.write_text(page.render(build(done, regressions)), encoding="utf-8")


def build(done: list[Done], regressions: Sequence[str]) -> page.Page:
    """What the report says."""
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
    parts: list[page.Part] = [page.Figure(_map(done), group.text)]
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


def _map(done: Done) -> Any:
    import plotly.graph_objects as go

    group = done.group
    rows = list(dict.fromkeys(cell.row for cell in group.cells))
    columns = list(dict.fromkeys(cell.column for cell in group.cells))
    figure = go.Figure([_heat(done, rows, columns), *_legend()])
    category: dict[str, Any] = {"type": "category", "showgrid": False, "zeroline": False, "ticks": ""}
    figure.update_layout(
        **theme.layout(
            AROUND + ROW * len(rows),
            xaxis=theme.axis(group.columns, **category),
            yaxis=theme.axis(group.rows, **category, autorange="reversed"),
            margin={"l": 75, "r": 20, "t": 40, "b": 70},
        )
    )
    return figure


def _heat(done: Done, rows: list[str], columns: list[str]) -> Any:
    """The cells in the colours of their outcomes."""
    import plotly.graph_objects as go

    colour: list[list[int | None]] = [[None] * len(columns) for _ in rows]
    label = [[""] * len(columns) for _ in rows]
    hover = [[""] * len(columns) for _ in rows]
    for cell, outcome in zip(done.group.cells, done.outcomes, strict=True):
        i, j = rows.index(cell.row), columns.index(cell.column)
        colour[i][j] = KINDS.index(outcome.kind)
        label[i][j] = _label(outcome)
        hover[i][j] = f"<b>{cell.row}, {cell.column}: {outcome.kind}</b><br>{_hover(outcome)}"
    last = len(KINDS) - 1
    # Bands of one colour each: every number is in the middle of its own.
    scale = [
        [edge, COLOURS[kind]]
        for k, kind in enumerate(KINDS)
        for edge in (k / (last + 1), (k + 1) / (last + 1))
    ]
    return go.Heatmap(
        x=columns,
        y=rows,
        z=colour,
        text=label,
        customdata=hover,
        texttemplate="%{text}",
        textfont={"color": "#ffffff", "size": 12},
        hovertemplate="%{customdata}<extra></extra>",
        hoverongaps=False,
        colorscale=scale,
        zmin=-0.5,
        zmax=last + 0.5,
        xgap=2,
        ygap=2,
        showscale=False,
    )


def _legend() -> list[Any]:
    """A heat map has no legend: empty curves of the same colours stand in for it."""
    import plotly.graph_objects as go

    return [
        go.Scatter(
            x=[None],
            y=[None],
            mode="markers",
            name=kind,
            marker={"color": COLOURS[kind], "size": 12, "symbol": "square"},
        )
        for kind in KINDS
    ]


def _label(outcome: Outcome) -> str:
    """What stands in a cell: the error where there is one."""
    if outcome.error is None or outcome.kind in ("refused", "failed"):
        return outcome.kind
    return f"{outcome.error:.0e}"


def _hover(outcome: Outcome) -> str:
    words, lines = outcome.reason.split(), [""]
    for word in words:
        if len(lines[-1]) + len(word) > LINE:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    facts = [f"{outcome.seconds:.2g} s"]
    if outcome.error is not None:
        facts.insert(0, f"error {outcome.error:.1e}")
    if outcome.evaluations:
        facts.append(f"{outcome.evaluations:,} evaluations")
    return "<br>".join([*(line.replace("<", "&lt;") for line in lines), ", ".join(facts)])
