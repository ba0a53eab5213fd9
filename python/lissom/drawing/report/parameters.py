"""Reports of derivatives and of parameter identification."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from ..._lissom import Robot
from ...analysis.equilibria import EquilibriumSensitivityResult
from ...analysis.fitted import FitResult, FittedData
from ...analysis.sensitivities import SensitivityResult
from ...model.units import unit_of, with_unit
from ...results.datasets import coordinates
from ...results.runs import Array
from . import page, plots, theme

#: Maximum number of parameters with separate curves; the first ones.
SHOWN = 24

#: Maximum number of places of a fit that are shown; the first ones.
PLACES = 12

#: Maximum number of parameters in a table of correlations.
LARGEST_TABLE = 12

#: Number of plots per row of a figure.
BESIDE = 2

#: Correlations of successive residuals beyond this number of standard deviations of white noise are reported.
NOTABLE = 3.0

#: Residuals are reported that are larger than a known noise by this factor.
LARGER = 1.5


def build(
    result: SensitivityResult | EquilibriumSensitivityResult | FitResult, title: str | None
) -> page.Page:
    """Content of the report."""
    if isinstance(result, FitResult):
        return _fit(result, title or "Identification")
    if isinstance(result, SensitivityResult):
        return _run(result, title or "Derivatives of a run")
    return _equilibrium(result, title or "Derivatives of an equilibrium")


def _number(count: int) -> str:
    return "1 parameter" if count == 1 else f"{count} parameters"


def _rows(shown: list[plots.Plot]) -> list[list[plots.Plot]]:
    return [shown[i : i + BESIDE] for i in range(0, len(shown), BESIDE)]


def _table(names: Sequence[str], columns: Mapping[str, Iterable[float]], caption: str = "") -> page.Table:
    values = np.array([list(column) for column in columns.values()]).T
    # Beside a derivative across a plane, those in it are rounding.
    largest = np.nanmax(np.abs(values), axis=1, initial=0.0, keepdims=True)
    values = np.where(np.abs(values) < plots.ROUNDING * largest, 0.0, values)
    rows = [
        (with_unit(name), *(f"{value:.6g}" for value in row)) for name, row in zip(names, values, strict=True)
    ]
    return page.Table(("parameter", *columns), rows, frozenset(columns), caption)


def _gradient(result: SensitivityResult | EquilibriumSensitivityResult) -> page.Section:
    assert result.gradient is not None
    caption = f"The objective is {result.value:.6g}. Derivatives are per unit of each parameter."
    return page.Section("Gradient", [_table(result.names, {"derivative": result.gradient}, caption)])


def _run(result: SensitivityResult, title: str) -> page.Page:
    sections = [_gradient(result)] if result.dq is None else [_curves(result), _last(result)]
    count, duration = len(result.names), result.t[-1] - result.t[0]
    return page.Page(
        title=title,
        lead=f"{_number(count)}, {result.q.shape[1]} generalised coordinates, {duration:.4g} s.",
        sections=sections,
    )


def _of_place(result: SensitivityResult) -> tuple[Array, list[str], str]:
    """Quantities shown over time, with names: the tip of a robot, otherwise coordinates."""
    assert result.dq is not None
    if isinstance(result._model, Robot):
        return result.position()[1], ["x", "y", "z"], "tip (m)"
    known = coordinates(result._model, result.q.shape[1])
    return result.dq, [coordinate.name for coordinate in known], "coordinates"


def _curves(result: SensitivityResult) -> page.Section:
    values, names, what = _of_place(result)
    shown = []
    for i, parameter in enumerate(result.names[:SHOWN]):
        curves = [
            plots.Curve(name, result.t, values[:, k, i], theme.SERIES[k % len(theme.SERIES)])
            for k, name in enumerate(names)
        ]
        shown.append(
            # The name is above the plot, because it may be longer than the axis.
            plots.Plot(
                plots.Axis("time (s)"), plots.Axis(f"{what} per unit"), curves, title=with_unit(parameter)
            )
        )
    more = f" The first {SHOWN} of {len(result.names)} parameters." if len(result.names) > SHOWN else ""
    caption = f"How the {what.partition(' ')[0]} moves with each parameter, all others being held.{more}"
    return page.Section("Over time", [page.Figure(plots.Figure(_rows(shown), 240, ""), caption)])


def _last(result: SensitivityResult) -> page.Section:
    values, names, what = _of_place(result)
    columns = dict(zip(names, values[-1], strict=True))
    table = _table(result.names, columns, f"Derivatives of the {what} at the end of the run.")
    return page.Section("At the end", [table])


def _equilibrium(result: EquilibriumSensitivityResult, title: str) -> page.Page:
    sections = [_gradient(result)] if result.gradient is not None else []
    if result.dq is not None and isinstance(result._model, Robot):
        position, derivative = result.position()
        where = ", ".join(f"{x:.6g}" for x in position)
        caption = f"Derivatives of the tip in metres per unit of each parameter. The tip is at ({where}) m."
        table = _table(result.names, dict(zip("xyz", derivative, strict=True)), caption)
        sections.append(page.Section("Tip", [table]))
    if result.dq is not None:
        names = [coordinate.name for coordinate in coordinates(result._model, len(result.q))]
        sections.append(
            page.Section("Coordinates", [_table(result.names, dict(zip(names, result.dq, strict=True)))])
        )
    if len(result.frequencies):
        columns = {
            f"{own:.6g} Hz": row for own, row in zip(result.frequencies, result.dfrequencies, strict=True)
        }
        caption = "Derivatives of the natural frequencies in hertz per unit of each parameter."
        sections.append(page.Section("Natural frequencies", [_table(result.names, columns, caption)]))
    return page.Page(
        title=title,
        lead=f"{_number(len(result.names))}, {len(result.q)} generalised coordinates.",
        sections=sections,
    )


def _fit(result: FitResult, title: str) -> page.Page:
    size = sum(each.measured.size for each in result.data)
    advice = _advice(result)
    parts: list[page.Part] = [_values(result)]
    if 1 < len(result.names) <= LARGEST_TABLE:
        parts.append(_correlations(result))
    several = "" if len(result.data) == 1 else f" in {len(result.data)} recordings"
    rows = [
        ("message", result.message),
        ("runs", f"{result.runs}"),
        ("measured numbers", f"{size:,}{several}, for {_number(len(result.names))}"),
    ]
    return page.Page(
        title=title,
        lead=f"{_number(len(result.names))} from {size:,} measured numbers{several}.",
        outcome=_outcome(result, advice),
        advice=advice,
        sections=[
            page.Section("Parameters", parts),
            *(_recording(each, name) for each, name in zip(result.data, _titles(result), strict=True)),
            page.Section("Result", [page.Table(("", ""), [*rows, *_left(result)])]),
        ],
    )


def _outcome(result: FitResult, advice: Sequence[str]) -> tuple[str, bool]:
    """The outcome of a fit, and whether it is good: without a doubt."""
    if not result.success:
        return f"Not converged: {result.message}", False
    return ("Converged, with doubts: see below.", False) if advice else ("Converged.", True)


def _titles(result: FitResult) -> list[str]:
    if len(result.data) == 1:
        return ["Measured and fitted"]
    return [f"Measured and fitted: data[{i}], {each.kind}" for i, each in enumerate(result.data)]


def _advice(result: FitResult) -> list[str]:
    """Advice from the residuals, the Jacobian and the message, whose first sentence is the outcome."""
    advice = []
    for i, each in enumerate(result.data):
        # Of white noise it has this standard deviation.
        if abs(each.correlation) > NOTABLE / np.sqrt(each.residuals.size):
            which = "" if len(result.data) == 1 else f" of data[{i}]"
            advice.append(
                f"Neighbouring residuals{which} are correlated ({each.correlation:.2f}): the model leaves "
                "out something, and the intervals, which take the noise for independent, are too narrow."
            )
        if each.misfit > LARGER * each.noise:
            advice.append(
                f"The residuals of data[{i}] are {each.misfit / each.noise:.2g} times as large as its noise: "
                "the model leaves out something, the noise is larger, or these values are not the best ones."
            )
    if result.undetermined:
        names = ", ".join(result.undetermined)
        advice.append(
            f"The data do not determine {names}: other values fit as well. Fix one of them, or measure "
            "something that they change differently."
        )
    if result.at_bounds:
        advice.append(f"At a bound: {', '.join(result.at_bounds)}. The intervals end there.")
    _, _, more = result.message.partition(". ")
    return advice or ([more] if result.success and more else [])


def _left(result: FitResult) -> list[tuple[str, str]]:
    """The residuals, as rows of a table."""
    rows = []
    for i, each in enumerate(result.data):
        which = "" if len(result.data) == 1 else f"data[{i}], {each.kind}: "
        rows.append((f"{which}root mean square of the residuals", f"{each.misfit:.4g} {each.unit}"))
        rows.append((f"{which}standard deviation of the noise", f"{each.noise:.4g} {each.unit}"))
        if np.isfinite(each.correlation):
            rows.append((f"{which}correlation of neighbouring residuals", f"{each.correlation:.2f}"))
    return rows


def _values(result: FitResult) -> page.Table:
    low, high = result.intervals.T
    caption = f"The interval from low to high has a confidence of {100 * result.confidence:g} percent."
    if not all(map(unit_of, result.names)):
        caption += " Values without a unit here are in SI units, or in those of your own function."
    table = _table(result.names, {"value": result.values, "low": low, "high": high}, caption)
    said = dict.fromkeys(result.names, "")
    said |= dict.fromkeys(result.at_bounds, "at a bound") | dict.fromkeys(
        result.undetermined, "not determined"
    )
    if not any(said.values()):
        return table
    rows = [(*row, said[name]) for row, name in zip(table.rows, result.names, strict=True)]
    return page.Table((*table.columns, "note"), rows, table.numeric, caption)


def _correlations(result: FitResult) -> page.Table:
    spread = np.sqrt(np.diag(result.covariance))
    with np.errstate(invalid="ignore"):
        # Infinite variances have none.
        correlation = result.covariance / np.outer(spread, spread)
    cells = [["" if np.isnan(x) else f"{x:.3f}" for x in row] for row in correlation]
    rows = [(name, *row) for name, row in zip(result.names, cells, strict=True)]
    caption = "Correlations of the values; empty for what the data do not determine."
    return page.Table(("", *result.names), rows, frozenset(result.names), caption)


def _recording(data: FittedData, title: str) -> page.Section:
    if not data.places:
        numbers = [f"{k + 1}" for k in range(len(data.measured))]
        columns = {
            "measured (Hz)": data.measured,
            "fitted (Hz)": data.fitted,
            "residual (Hz)": data.residuals,
        }
        table = _table(numbers, columns)
        return page.Section(title, [page.Table(("mode", *table.columns[1:]), table.rows, table.numeric)])
    x: Array = np.arange(1.0, 1.0 + len(data.measured)) if data.t is None else np.asarray(data.t)
    axis = plots.Axis("shape" if data.t is None else "time (s)")
    rows = []
    for k, place in enumerate(data.places[:PLACES]):
        both, rest = [], []
        for i, (name, colour) in enumerate(zip("xyz", theme.SERIES, strict=False)):
            both.append(plots.Curve(name, x, data.fitted[:, k, i], colour))
            both.append(plots.Curve("", x, data.measured[:, k, i], colour, joined=False, mark="disc"))
            rest.append(
                plots.Curve(name, x, data.residuals[:, k, i], colour, joined=data.t is not None, mark="disc")
            )
        rows.append(
            [
                plots.Plot(axis, plots.Axis(f"position of {place} (m)"), both),
                plots.Plot(axis, plots.Axis("residual (m)"), rest),
            ]
        )
    more = f" The first {PLACES} of {len(data.places)} places." if len(data.places) > PLACES else ""
    caption = (
        f"Measured positions as discs, the fitted model as lines; residuals are model minus measured.{more}"
    )
    return page.Section(title, [page.Figure(plots.Figure(rows, 260, ""), caption)])
