"""Curves over time: coordinates, tip, energies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._lissom import LissomError
from ..results import Array, Run
from ..results import energies as named_energies
from ..views import Coordinate, Frame, Member
from . import theme

Instants = NDArray[np.intp]

#: Points of a curve, at most; between them nothing can be seen.
MAX_POINTS = 4000

#: Numbers in the curves of all links together, at most.
MAX_NUMBERS = 200_000

#: Line styles of successive segments.
DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")

#: Colours of components along the axes of the world.
AXIS_COLOURS = {"x": theme.RED, "y": theme.GREEN, "z": theme.BLUE}

TIME = "time (s)"


def coordinates(run: Run) -> Any:
    """All coordinates over time, one plot for each kind."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    all_of_them = run.view.coordinates
    kinds = list(dict.fromkeys(coordinate.kind for coordinate in all_of_them))
    several = any(coordinate.segment > 0 for coordinate in all_of_them)
    figure = make_subplots(rows=len(kinds), cols=1, shared_xaxes=True, vertical_spacing=0.09 / len(kinds))
    at = run.instants(MAX_POINTS)
    t, q = run.t[at], run.q[at]
    named = set()
    for i, coordinate in enumerate(all_of_them):
        row = kinds.index(coordinate.kind) + 1
        label = _label(coordinate, several)
        trace = go.Scatter(
            x=t,
            y=q[:, i],
            name=label,
            legendgroup=label,
            showlegend=label not in named and len(all_of_them) > 1,
            line={
                "color": theme.SERIES[
                    (i if coordinate.degree is None else coordinate.degree) % len(theme.SERIES)
                ],
                "dash": DASHES[coordinate.segment % len(DASHES)],
                "width": 1.8,
            },
        )
        named.add(label)
        figure.add_trace(trace, row=row, col=1)
        figure.update_yaxes(theme.axis(f"{coordinate.kind} ({coordinate.unit})"), row=row, col=1)
    figure.update_xaxes(theme.axis(""))
    figure.update_xaxes(theme.axis(TIME), row=len(kinds), col=1)
    figure.update_layout(**theme.layout(130 + max(260, 200 * len(kinds))))
    return figure


def _label(coordinate: Coordinate, several: bool) -> str:
    """What one coordinate is called among those of its kind, of a model of one segment or several."""
    if coordinate.degree is None:
        return coordinate.kind
    degree = f"P<sub>{coordinate.degree}</sub>"
    return f"segment {coordinate.segment + 1}, {degree}" if several else degree


def position(run: Run, frame: Frame, at: Instants | None = None) -> Any:
    """Position of a frame over time: at these indices, or as many as can be seen."""
    import plotly.graph_objects as go

    at = run.instants(MAX_POINTS) if at is None else at
    positions = frame.pose(run.q[at], run.t[at])[:, :3, 3]
    traces = [
        go.Scatter(x=run.t[at], y=positions[:, i], name=name, line={"color": colour, "width": 1.8})
        for i, (name, colour) in enumerate(AXIS_COLOURS.items())
    ]
    figure = go.Figure(traces)
    figure.update_layout(
        **theme.layout(360, xaxis=theme.axis(TIME), yaxis=theme.axis(f"position of the {frame.name} (m)"))
    )
    return figure


def instants(run: Run) -> Instants:
    """The instants at which the curves of the links are drawn, fewer where there are many curves."""
    # Three of the position, six of the wrench.
    curves = run.q.shape[1] + 9 * len(run.view.members)
    return run.instants(int(np.clip(MAX_NUMBERS // curves, 2, MAX_POINTS)))


def coordinates_of(run: Run, member: Member, at: Instants) -> Any | None:
    """The coordinates of a link by their names, one plot for each kind; None where it has none."""
    own = list(enumerate(run.view.coordinates))[member.coordinates]
    kinds: dict[tuple[str, str], list[tuple[str, Array]]] = {}
    for i, coordinate in own:
        curve = (coordinate.name, run.q[at, i])
        kinds.setdefault((coordinate.kind, coordinate.unit), []).append(curve)
    plots = {f"{kind} ({unit})": curves for (kind, unit), curves in kinds.items()}
    return stacked(run.t[at], plots) if plots else None


def wrench_of(run: Run, member: Member, at: Instants) -> Any | None:
    """Force and moment that a link gets through its joint; None where no accelerations are known."""
    known = at[np.isfinite(run.a[at]).all(axis=1)]
    if len(known) == 0:
        return None
    try:
        wrench = member.wrench(run.q[known], run.v[known], run.a[known], run.t[known])
    except (ValueError, LissomError):
        # The end of a run that failed can be beyond all numbers.
        return None
    plots = {
        name: list(zip("xyz", wrench[:, rows].T, strict=True))
        for name, rows in (("force (N)", slice(3, 6)), ("moment (N m)", slice(3)))
    }
    return stacked(run.t[known], plots)


def stacked(t: Array, plots: Mapping[str, Sequence[tuple[str, Array]]]) -> Any:
    """Plots over time, one above the other: the curves of each by name."""
    from plotly.subplots import make_subplots

    figure = make_subplots(rows=len(plots), cols=1, shared_xaxes=True, vertical_spacing=0.09 / len(plots))
    named = set()
    for row, (title, curves) in enumerate(plots.items(), start=1):
        for (name, values), colour in zip(curves, cycle(theme.SERIES), strict=False):
            colour = AXIS_COLOURS.get(name, colour)
            figure.add_scatter(
                x=t.astype(np.float32),
                y=values.astype(np.float32),
                name=name,
                legendgroup=name,
                showlegend=name not in named,
                line={"color": colour, "width": 1.8},
                row=row,
                col=1,
            )
            named.add(name)
        figure.update_yaxes(theme.axis(title), row=row, col=1)
    figure.update_xaxes(theme.axis(""))
    figure.update_xaxes(theme.axis(TIME), row=len(plots), col=1)
    figure.update_layout(**theme.layout(130 + max(260, 200 * len(plots))))
    return figure


def energies(run: Run) -> Any:
    """Where the energy is over time; parts that are never there are left out."""
    import plotly.graph_objects as go

    at = run.instants(MAX_POINTS)
    traces = [
        go.Scatter(
            x=run.t[at],
            y=values[at],
            name=name,
            line={"color": theme.ENERGY_COLOURS[name], "width": 2.4 if name == "total" else 1.8},
        )
        for name, values in named_energies(run.balance).items()
        if name in ("kinetic", "total") or np.any(values)
    ]
    figure = go.Figure(traces)
    figure.update_layout(**theme.layout(400, xaxis=theme.axis(TIME), yaxis=theme.axis("energy (J)")))
    return figure


def drift(run: Run) -> Any:
    """Change of the total, which an exact motion keeps constant."""
    import plotly.graph_objects as go

    at = run.instants(MAX_POINTS)
    with np.errstate(invalid="ignore"):
        # Of a run that overflowed there is no difference to show.
        change = (run.balance.total - run.balance.total[0])[at]
    colour = theme.ENERGY_COLOURS["total"]
    figure = go.Figure(
        [go.Scatter(x=run.t[at], y=change, line={"color": colour, "width": 1.5}, name="defect")]
    )
    figure.update_layout(
        **theme.layout(
            260, xaxis=theme.axis(TIME), yaxis=theme.axis("total − its start (J)"), showlegend=False
        )
    )
    return figure
