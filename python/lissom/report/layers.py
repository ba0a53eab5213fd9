"""Layers of an animated view in space: what moves, what stands still, and the legend that switches them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import theme

Array = NDArray[np.float64]

#: Relative to the largest coordinate: what moves less stands still.
SEEN = 1e-6

#: How the layers look in the legend, in the order in which they stand there.
LEGEND: dict[str, dict[str, Any]] = {
    "rods": {"mode": "markers", "marker": {"symbol": "square", "size": 9, "color": theme.ROD_SCALE[1][1]}},
    "bodies": {"mode": "markers", "marker": {"symbol": "circle", "size": 9, "color": theme.GREY}},
    "joints": {"mode": "lines", "line": {"color": theme.PURPLE, "width": 6}},
    "tendons": {"mode": "lines", "line": {"color": theme.GOLD, "width": 4}},
    "chambers": {"mode": "lines", "line": {"color": theme.CYAN, "width": 6}},
    "motors": {"mode": "markers", "marker": {"symbol": "square", "size": 9, "color": theme.PURPLE}},
    "forces": {"mode": "lines", "line": {"color": theme.RED, "width": 4}},
    "moments": {"mode": "lines", "line": {"color": theme.MAGENTA, "width": 4}},
    "supports": {"mode": "lines", "line": {"color": theme.GREEN, "width": 4}},
    "current": {"mode": "lines", "line": {"color": theme.CYAN, "width": 4}},
    "gravity": {"mode": "lines", "line": {"color": theme.GREY, "width": 4}},
    "floor": {"mode": "markers", "marker": {"symbol": "square-open", "size": 9, "color": theme.GREY}},
    "tips": {"mode": "markers", "marker": {"size": 5, "color": theme.ORANGE}},
    "paths": {"mode": "lines", "line": {"color": theme.ORANGE, "width": 2}},
    "initial shape": {"mode": "lines", "line": {"color": theme.GREY, "width": 3, "dash": "dot"}},
}


#: Break of a line.
BREAK = np.full((1, 3), np.nan)


@dataclass(frozen=True)
class Shown:
    """The shapes in which something is shown."""

    #: Coordinates and velocities (shapes, n), times and load factors (shapes,).
    q: Array
    v: Array
    t: Array
    load_factor: Array
    #: Length in metres to which symbols are scaled.
    size: float
    #: Radius of the thickest rod as it is drawn, and half the length of the axis of a joint, metres.
    radius: float
    half_axis: float


@dataclass(frozen=True)
class Trace:
    """Something that is drawn."""

    #: Its layer, out of `LEGEND`.
    layer: str
    kind: Literal["mesh3d", "scatter3d"]
    #: Its points in every shape that is shown, (shapes, points, 3), or in the only one. NaN breaks lines.
    points: Array
    #: What plotly is told beside the points.
    looks: dict[str, Any] = field(default_factory=dict)

    @property
    def moves(self) -> bool:
        """Whether the points are not the same in all shapes, but for rounding."""
        apart = np.nan_to_num(np.abs(self.points - self.points[:1]))
        return bool(apart.max() > SEEN * np.nan_to_num(np.abs(self.points)).max())


def figure(traces: Sequence[Trace], shapes: int, first: int, names: dict[str, str]) -> Any:
    """A figure that opens at shape ``first``, with one frame for each of so many shapes.

    ``names`` are those of layers in the legend that are called otherwise here.
    """
    import plotly.graph_objects as go

    moving = [i for i, trace in enumerate(traces) if trace.moves]
    data = [
        {
            "type": trace.kind,
            **_xyz(trace.points[first if trace.moves else 0]),
            "legendgroup": trace.layer,
            "showlegend": False,
            "name": trace.layer,
            **trace.looks,
        }
        for trace in traces
    ]
    shown = {trace.layer for trace in traces}
    legend = [
        # A point that is nowhere: meshes, and layers of several traces, have no entry of their own.
        {
            "type": "scatter3d",
            **{axis: [None] for axis in "xyz"},
            "legendgroup": layer,
            "showlegend": True,
            "name": names.get(layer, layer),
            **looks,
        }
        for layer, looks in LEGEND.items()
        if layer in shown
    ]
    frames = [
        go.Frame(
            data=[{"type": traces[i].kind, **_xyz(traces[i].points[shape])} for i in moving],
            traces=moving,
            name=str(shape),
        )
        for shape in range(shapes)
    ]
    return go.Figure(data=data + legend, frames=frames)


def extent(traces: Sequence[Trace]) -> tuple[Array, Array]:
    """The corners of the box around all points."""
    every = np.concatenate([trace.points.reshape(-1, 3) for trace in traces])
    return np.nanmin(every, axis=0), np.nanmax(every, axis=0)


def _xyz(points: Array) -> dict[str, NDArray[np.float32]]:
    return dict(zip("xyz", points.T.astype(np.float32), strict=True))
