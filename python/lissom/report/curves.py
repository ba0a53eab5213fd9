"""Curves over time: coordinates, tip, energies."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..results import Run
from ..results import energies as named_energies
from ..views import Coordinate, Frame
from . import theme

#: Points of a curve, at most; between them nothing can be seen.
MAX_POINTS = 4000

#: Line styles of successive segments.
DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")

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


def position(run: Run, frame: Frame) -> Any:
    """Position of a frame over time."""
    import plotly.graph_objects as go

    at = run.instants(MAX_POINTS)
    positions = frame.pose(run.q[at], run.t[at])[:, :3, 3]
    traces = [
        go.Scatter(x=run.t[at], y=positions[:, i], name=name, line={"color": colour, "width": 1.8})
        for i, (name, colour) in enumerate(zip("xyz", (theme.RED, theme.GREEN, theme.BLUE), strict=True))
    ]
    figure = go.Figure(traces)
    figure.update_layout(
        **theme.layout(360, xaxis=theme.axis(TIME), yaxis=theme.axis(f"position of the {frame.name} (m)"))
    )
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
