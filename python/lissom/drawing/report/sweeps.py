"""The report of a sweep: response curves and maps."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ...common import disk
from ...model.units import unit_of, with_unit
from ...results.datasets import coordinates
from ...results.runs import Array
from ...results.sweeps import SweepStudy
from . import page, plots, theme

#: Number of colours of a map.
SHADES = 9

#: Maximum number of rows and columns of a map.
LARGEST_MAP = 40

#: Maximum number of curves per plot.
CURVES = 5

#: Maximum number of rows in the table of failed runs.
LISTED = 20


def write(study: SweepStudy, path: Path) -> None:
    """Write the report of a sweep to ``path``."""
    disk.write(path, page.render(build(study)))


def build(study: SweepStudy) -> page.Page:
    """Content of the report."""
    options = [(name, list(_shown(study, name, values))) for name, values in responses(study)]
    parts: list[page.Part] = [page.Choice("Response", options)] if options else []
    sections = [page.Section("Responses", parts)] if parts else []
    if not study.is_good:
        sections.append(page.Section("Runs that failed", [_failed(study)]))
    sections += [
        page.Section("Result", [page.Table(("", ""), study.summary)]),
        page.Section("Scene", [page.Source("The scene file", study.scene.text)]),
    ]
    return page.Page(
        title=study.scene.name,
        lead=f"{study.points} runs over {' and '.join(study.parameters)}.",
        outcome=(study.outcome, study.is_good),
        sections=sections,
    )


def responses(study: SweepStudy) -> Iterator[tuple[str, Array]]:
    """Responses over the parameters, by name: arrays with the shape of the grid."""
    found = study.found
    if "position" in found:
        for k, place in enumerate(found.place.values):
            for i, axis in reversed(list(enumerate("xyz"))):
                for kind, name in (("", "at the end"), ("_lowest", "lowest"), ("_highest", "highest")):
                    values = found[f"position{kind}"].values[..., k, i]
                    if np.isfinite(values).any():
                        yield f"{axis} of {place} {name} (m)", values
        return
    names = found.coordinate.values if "q" in found else ()
    units = [each.unit for each in coordinates(study.scene.model, len(names))] if len(names) else ()
    for i, (name, unit) in enumerate(zip(names, units, strict=True)):
        of_unit = f" ({unit})" if unit else ""
        for kind, when in (("q", "at the end"), ("lowest", "lowest"), ("highest", "highest")):
            yield f"{name} {when}{of_unit}", found[kind].values[..., i]


def _axes(study: SweepStudy) -> list[Array]:
    return [study.found[name].values for name in study.parameters]


def _shown(study: SweepStudy, response: str, values: Array) -> Iterator[page.Part]:
    axes = _axes(study)
    # Parameters that are not shown have their middle values.
    middle = tuple(len(axis) // 2 for axis in axes)
    if len(axes) > 1:
        rest = "".join(
            f", {_at(name, axis[i])}"
            for name, axis, i in list(zip(study.parameters, axes, middle, strict=True))[2:]
        )
        if max(len(axes[0]), len(axes[1])) <= LARGEST_MAP:
            shown: tuple[Any, ...] = (slice(None), slice(None), *middle[2:])
            yield _map(study, response, values[shown], rest)
    numeric = [k for k, axis in enumerate(axes) if axis.dtype.kind in "if" and len(axis) > 1]
    for k in numeric:
        # Each plot has a legend of its own: the values of another parameter.
        plot = _curves(study, response, values, k, middle)
        caption = _caption(study) if k == numeric[-1] else ""
        yield page.Figure(plots.Figure([[plot]], 300, "", legend=len(axes) > 1), caption)


def _caption(study: SweepStudy) -> str:
    if len(study.parameters) == 1:
        return "Each mark is a run."
    return "Each mark is a run. Parameters that are not shown have their middle values."


def _curves(study: SweepStudy, response: str, values: Array, k: int, middle: tuple[int, ...]) -> plots.Plot:
    """The response over a parameter, for some values of the next parameter."""
    axes, names = _axes(study), study.parameters
    x = axes[k].astype(float)
    other = (k + 1) % len(axes)
    chosen = (
        [middle[other]]
        if other == k
        else np.unique(np.linspace(0, len(axes[other]) - 1, CURVES).round().astype(int)).tolist()
    )
    curves = []
    for colour, i in zip(theme.SERIES, chosen, strict=False):
        at: list[Any] = list(middle)
        at[other] = i
        at[k] = slice(None)
        y = values[tuple(at)]
        name = "" if other == k else _at(names[other], axes[other][i])
        known = np.isfinite(y)
        curves.append(plots.Curve(name, x[known], y[known], colour, mark="disc"))
    ratios = x[1:] / x[:-1] if (x > 0).all() else np.array([1.0, 2.0])
    is_log = len(x) > 2 and bool(np.ptp(ratios) < 1e-6 * ratios.mean())
    return plots.Plot(plots.Axis(with_unit(names[k]), log=is_log), plots.Axis(response), curves)


def _map(study: SweepStudy, response: str, values: Array, rest: str) -> page.Cells:
    """The response over the first two parameters."""
    rows, columns = _axes(study)[:2]
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    bounds = np.linspace(low, high, SHADES + 1)
    colours = theme.sample(theme.ROD_SCALE, np.linspace(0.0, 1.0, SHADES))
    # With enough digits to distinguish the bounds; a constant response has one shade.
    kinds = next(
        (names for digits in range(4, 18) if len(set(names := _froms(bounds, digits))) == SHADES),
        [f"{low:.4g}"],
    )
    legend = dict(zip(kinds, colours, strict=False))

    def cell(i: int, j: int) -> page.Cell | None:
        value = values[i, j]
        if not np.isfinite(value):
            return None
        shade = min(int((value - low) / (high - low) * SHADES), SHADES - 1) if len(legend) > 1 else 0
        where = ", ".join(map(_at, study.parameters[:2], (rows[i], columns[j])))
        return page.Cell(kinds[shade], f"{value:.3g}", f"{value:.6g} at {where}")

    cells = [[cell(i, j) for j in range(len(columns))] for i in range(len(rows))]
    corner = " \\ ".join(map(with_unit, study.parameters[:2]))
    caption = f"{response}{rest}. Cells without a number are runs that have none."
    return page.Cells(corner, [*map(_text, rows)], [*map(_text, columns)], cells, legend, caption)


def _froms(bounds: Array, digits: int) -> list[str]:
    return [f"from {bound:.{digits}g}" for bound in bounds[:-1]]


def _failed(study: SweepStudy) -> page.Table:
    found = study.found
    bad = np.argwhere(~found.success.values & found.is_done.values)
    rows = []
    for index in bad[:LISTED]:
        at = tuple(int(i) for i in index)
        values = [_text(axis[i]) for axis, i in zip(_axes(study), at, strict=True)]
        rows.append((*values, str(found.status.values[at]), str(found.message.values[at])))
    more = f" The first {LISTED} of {len(bad)}." if len(bad) > LISTED else ""
    return page.Table(
        (*map(with_unit, study.parameters), "status", "message"), rows, caption=f"Runs without an end.{more}"
    )


def _at(parameter: str, value: Any) -> str:
    """A parameter at a value, with its unit."""
    return f"{parameter} = {_text(value)} {unit_of(parameter)}".rstrip()


def _text(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float | np.floating) else str(value)
