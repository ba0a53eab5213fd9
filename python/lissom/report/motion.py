"""Animated views of a motion: links in space, a mass on a line in its plane."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..views import Sketch, View
from . import layers, page, solids, symbols, theme

Array = NDArray[np.float64]

#: Frames of an animation, at most: about eight seconds at the pace of a film.
MAX_FRAMES = 200

#: Points of skins in all frames together, at most, and frames that there are whatever they cost.
MAX_POINTS, MIN_FRAMES = 1_000_000, 25

#: Slowest and fastest playback, milliseconds a frame.
PACE = (25.0, 200.0)

#: Of the skin of rods with tendons or chambers inside.
OPACITY_AROUND_ACTUATORS = 0.45

#: A rod is drawn at least this thick, relative to its length, so that a wire can be seen.
LEAST_RADIUS = 0.006

#: Points of the path of a tip, at most.
MAX_PATH = 3000

#: Symbols are scaled to the size of the model, or to this part of the diagonal of all that is shown.
LEAST_SIZE = 0.25

#: Diagonal of the box around a rod, in plotly's units, in which the camera's distance is about 1.8.
SPACE_SIZE = 1.65

#: Largest height of that box that still fits into the view.
SPACE_HEIGHT = 1.1


class Animated(Protocol):
    """What can be animated: a model in one shape after the other."""

    @property
    def view(self) -> View:
        """What there is to be drawn."""

    @property
    def t(self) -> Array:
        """What the shapes are labelled by, shape (m,)."""

    @property
    def q(self) -> Array:
        """Coordinates, shape (m, n)."""

    @property
    def v(self) -> Array:
        """Velocities, shape (m, n)."""

    @property
    def clock(self) -> Array:
        """Times at which the model is shown, seconds, shape (m,)."""

    @property
    def load_factor(self) -> Array:
        """How much of the loads acts, shape (m,)."""

    @property
    def opens_at(self) -> int:
        """Index of the shape that is shown first."""

    @property
    def label(self) -> tuple[str, str]:
        """What stands around a label."""

    def instants(self, most: int) -> NDArray[np.intp]:
        """Indices of at most so many shapes, evenly spread, first and last included."""


def sections(title: str, run: Animated, caption: str) -> list[page.Section]:
    """The motion with play, pause and a slider; nothing of a model that cannot be drawn."""
    if run.view.is_spatial:
        figure = _in_space(run)
    elif run.view.sketch is not None:
        figure = _in_plane(run, run.view.sketch)
    else:
        return []
    return [page.Section(title, [page.Figure(figure, caption)])]


def _pace(run: Animated, frames: NDArray[np.intp]) -> float:
    """Milliseconds a frame: real time where that can be watched."""
    if len(frames) < 2:
        return PACE[1]
    milliseconds = 1e3 * float(run.t[frames[-1]] - run.t[frames[0]]) / (len(frames) - 1)
    return float(np.clip(milliseconds, *PACE))


def _labels(times: Array) -> list[str]:
    return [f"{time:.3g}" if time < 1.0 else f"{time:.2f}" for time in times]


def _in_space(run: Animated) -> Any:
    """Links as tubes and ellipsoids, what joins them and acts on them, and the paths of their tips."""
    seen = run.view
    least = LEAST_RADIUS * seen.size
    at = _frames(run)
    q, t = run.q[at], run.clock[at]
    is_hollow = any(mark.way is not None for mark in seen.marks.actuators)
    opacity = OPACITY_AROUND_ACTUATORS if is_hollow else 1.0
    skins = [solids.tube(link, q, t, least, opacity) for link in seen.links]
    skins += [solids.ellipsoid(solid, q, t, 2.0 * least) for solid in seen.solids]
    drawn = [*skins, *_tips(run, at)]
    low, high = layers.extent(drawn)
    # What flies far is small in its box.
    size = max(seen.size, LEAST_SIZE * float(np.linalg.norm(high - low)))
    widest = max((solids.widest(link, least) for link in seen.links), default=0.0)
    shown = layers.Shown(q, run.v[at], t, run.load_factor[at], size, widest, _half_axis(run, size))
    traces = [*drawn, *symbols.symbols(seen.marks, shown)]
    low, high = layers.extent(traces)
    low, high = _box(low, high, 0.04 * float((high - low).max()))
    eye = _eye(high - low)
    traces += symbols.around(seen.marks, low, high, eye)
    opens_at = int(np.searchsorted(at, run.opens_at))
    singular = {"rods": "rod", "bodies": "body", "tips": "tip", "paths": "path of the tip"}
    numbers = {"rods": seen.links, "bodies": seen.solids, "tips": seen.frames, "paths": seen.frames}
    names = {name: singular[name] for name, number in numbers.items() if len(number) == 1}
    figure = layers.figure(traces, len(at), opens_at, names)
    figure.update_layout(
        **theme.layout(
            640,
            margin={"l": 0, "r": 0, "t": 10, "b": 90},
            scene=_space(low, high, eye),
            legend={"orientation": "h", "y": 1.0, "x": 0.5, "xanchor": "center", "yanchor": "top"},
            uirevision="kept",
        ),
        **theme.player(figure.frames, _labels(run.t[at]), _pace(run, at), label=run.label, active=opens_at),
    )
    return figure


def _frames(run: Animated) -> NDArray[np.intp]:
    """The shapes that are shown: fewer of what has many points."""
    points = sum(solids.CORNERS * len(link.stations) for link in run.view.links)
    points += solids.CORNERS * solids.RINGS * len(run.view.solids)
    return run.instants(int(np.clip(MAX_POINTS // max(points, 1), MIN_FRAMES, MAX_FRAMES)))


def _half_axis(run: Animated, size: float) -> float:
    """Half the length of the axes of joints: they stick out of bodies, unless these are large."""
    widest = max((float(solid.semi_axes.max()) for solid in run.view.solids), default=0.0)
    return float(np.clip(1.3 * widest, symbols.AXIS * size, 2.0 * symbols.AXIS * size))


def _tips(run: Animated, at: NDArray[np.intp]) -> list[layers.Trace]:
    """Tips with the paths that they take, and the shape at the start."""
    seen, path = run.view, run.instants(MAX_PATH)
    traces = []
    if seen.frames:
        tips = [frame.pose(run.q[at], run.clock[at])[:, None, :3, 3] for frame in seen.frames]
        names = {"text": [frame.name for frame in seen.frames], "hoverinfo": "text"}
        dots = {"mode": "markers", "marker": {"size": 4, "color": theme.ORANGE}}
        traces.append(layers.Trace("tips", "scatter3d", np.concatenate(tips, axis=1), dots | names))
        paths = [frame.pose(run.q[path], run.clock[path])[:, :3, 3] for frame in seen.frames]
        looks = {**layers.LEGEND["paths"], "opacity": 0.55, "hoverinfo": "skip"}
        traces.append(layers.Trace("paths", "scatter3d", _in_one_line(paths), looks))
    if seen.links:
        starts = [link.pose(run.q[0], link.stations, run.clock[0])[:, :3, 3] for link in seen.links]
        looks = {**layers.LEGEND["initial shape"], "hoverinfo": "skip"}
        traces.append(layers.Trace("initial shape", "scatter3d", _in_one_line(starts), looks))
    return traces


def _in_one_line(lines: list[Array]) -> Array:
    """Lines (points, 3) one behind the other, with breaks between them, (1, points, 3)."""
    return np.concatenate([part for line in lines for part in (line, layers.BREAK)])[None]


def _box(low: Array, high: Array, margin: float) -> tuple[Array, Array]:
    """A box around another one; what happens in a plane still gets some room across it."""
    low, high = low - margin, high + margin
    centre, size = 0.5 * (low + high), np.maximum(high - low, 0.25 * float((high - low).max()))
    return centre - 0.5 * size, centre + 0.5 * size


def _eye(size: Array) -> Array:
    """From where a box of that size is seen: across the plane in which most of the motion happens."""
    return np.array([(1.6, -0.7, 0.55), (0.45, -1.6, 0.45), (0.55, -1.15, 1.3)][int(np.argmin(size))])


def _space(low: Array, high: Array, eye: Array) -> dict[str, Any]:
    """Three equal axes of a box, seen from there."""
    size = high - low
    ratio = size * min(SPACE_SIZE / float(np.linalg.norm(size)), SPACE_HEIGHT / float(size[2]))
    axes = {
        f"{name}axis": {
            "range": [float(a), float(b)],
            "title": {"text": f"{name} (m)"},
            "gridcolor": theme.SPACE_GRID,
            "gridwidth": 1,
            "zeroline": False,
            "showbackground": False,
            "nticks": max(2, round(7.0 * r)),
        }
        for name, a, b, r in zip("xyz", low, high, ratio, strict=True)
    }
    return {
        **axes,
        # The legend stands above it.
        "domain": {"y": [0.0, 0.93]},
        "aspectmode": "manual",
        "aspectratio": dict(zip("xyz", (float(r) for r in ratio), strict=True)),
        "camera": {
            "eye": dict(zip("xyz", eye.tolist(), strict=True)),
            "center": {"x": 0, "y": 0, "z": -0.08},
            "projection": {"type": "perspective"},
        },
    }


def _in_plane(run: Animated, sketch: Sketch) -> Any:
    """A mass on a line, with the path that it takes."""
    import plotly.graph_objects as go

    path = sketch.mass(run.q[run.instants(MAX_PATH)])

    def bodies(q: Array) -> list[Any]:
        spring = sketch.line(q)
        mass = sketch.mass(q[None])[0]
        return [go.Scatter(x=spring[:, 0], y=spring[:, 1]), go.Scatter(x=mass[:1], y=mass[1:])]

    spring, mass = bodies(run.q[0])
    spring.update(mode="lines", line={"color": theme.GREY, "width": 2}, name="spring", hoverinfo="skip")
    mass.update(mode="markers", marker={"size": 20, "color": theme.BLUE}, name="mass")
    trail = go.Scatter(
        x=path[:, 0],
        y=path[:, 1],
        mode="lines",
        line={"color": theme.ORANGE, "width": 1},
        opacity=0.5,
        name="path",
    )
    hinge = go.Scatter(
        x=[0],
        y=[0],
        mode="markers",
        marker={"size": 9, "color": theme.GREY, "symbol": "square"},
        showlegend=False,
    )
    figure = go.Figure([trail, spring, mass, hinge])
    at = run.instants(MAX_FRAMES)
    frames = [go.Frame(data=bodies(run.q[i]), traces=[1, 2], name=str(k)) for k, i in enumerate(at)]
    figure.frames = frames
    points = np.concatenate([path, np.zeros((1, 2))])
    margin = 0.08 * float(np.ptp(points, axis=0).max())
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    figure.update_layout(
        **theme.layout(
            600,
            margin={"l": 75, "r": 20, "t": 30, "b": 130},
            xaxis=theme.axis("x (m)", range=[low[0], high[0]]),
            yaxis=theme.axis("y (m)", range=[low[1], high[1]], scaleanchor="x", scaleratio=1),
        ),
        **theme.player(frames, _labels(run.t[at]), _pace(run, at), label=run.label, y=-0.12),
    )
    return figure
