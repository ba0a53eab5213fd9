"""Animated views of a motion: a rod in space, the spring pendulum in its plane."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._lissom import Rod, SpringPendulum
from ..results import Run, sections
from ..studies import Slides
from . import theme

Array = NDArray[np.float64]

#: Frames of an animation, at most: about eight seconds at the pace of a film.
MAX_FRAMES = 200

#: Slowest and fastest playback, milliseconds a frame.
PACE = (25.0, 200.0)

#: Corners of the drawn cross-section.
CORNERS = 12

#: A rod is drawn at least this thick, relative to its length, so that a wire can be seen.
LEAST_RADIUS = 0.006

#: Points of the path of a tip, at most.
MAX_PATH = 3000

#: Diagonal of the box around a rod, in plotly's units, in which the camera's distance is about 1.8.
SPACE_SIZE = 1.65

#: Largest height of that box that still fits into the view.
SPACE_HEIGHT = 1.1

#: Windings of the drawn spring.
WINDINGS = 11


#: What can be animated: shapes of a scene's model at instants.
Animated = Run | Slides


def animation(run: Animated) -> Any:
    """The motion as a plotly figure with play, pause and a slider."""
    model = run.scene.model
    if isinstance(model, Rod):
        return _rod(run, model)
    assert isinstance(model, SpringPendulum), "a scene has a rod or a spring pendulum"
    return _pendulum(run, model)


def _pace(run: Animated, frames: NDArray[np.intp]) -> float:
    """Milliseconds a frame: real time where that can be watched."""
    if len(frames) < 2:
        return PACE[1]
    milliseconds = 1e3 * float(run.t[frames[-1]] - run.t[frames[0]]) / (len(frames) - 1)
    return float(np.clip(milliseconds, *PACE))


def _label(run: Animated) -> tuple[str, str]:
    return run.label if isinstance(run, Slides) else ("t = ", " s")


def _labels(times: Array) -> list[str]:
    return [f"{time:.3g}" if time < 1.0 else f"{time:.2f}" for time in times]


def _rod(run: Animated, rod: Rod) -> Any:
    import plotly.graph_objects as go

    stations = sections(rod)
    outline = _outline(rod, stations)
    faces = _faces(len(stations))
    tip_path = _tips(run, rod)

    def tube(i: int) -> go.Mesh3d:
        pose = _poses(run, rod, i, stations)
        x, y, z = _skin(pose, outline).T.astype(np.float32)
        return go.Mesh3d(
            x=x,
            y=y,
            z=z,
            **dict(zip("ijk", faces.T, strict=True)),
            intensity=_along(stations / rod.length),
            colorscale=theme.ROD_SCALE,
            showscale=False,
            flatshading=False,
            lighting={"ambient": 0.55, "diffuse": 0.75, "specular": 0.35, "roughness": 0.45, "fresnel": 0.1},
            lightposition={"x": 2e4, "y": -3e4, "z": 4e4},
            hoverinfo="skip",
            name="rod",
        )

    def moving(i: int) -> list[Any]:
        """What changes from frame to frame: the positions alone."""
        x, y, z = _skin(_poses(run, rod, i, stations), outline).T.astype(np.float32)
        tip = _poses(run, rod, i, rod.length)[:3, 3]
        return [go.Mesh3d(x=x, y=y, z=z), go.Scatter3d(x=tip[:1], y=tip[1:2], z=tip[2:])]

    first = _poses(run, rod, 0, stations)[:, :3, 3]
    tip = first[-1]
    line = {"mode": "lines", "hoverinfo": "skip"}
    dot = {"size": 4, "color": theme.ORANGE}
    figure = go.Figure(
        [
            tube(0),
            go.Scatter3d(
                x=tip[:1], y=tip[1:2], z=tip[2:], mode="markers", marker=dot, name="tip", hoverinfo="skip"
            ),
            go.Scatter3d(
                **_xyz(tip_path),
                **line,
                line={"color": theme.ORANGE, "width": 2},
                opacity=0.55,
                name="path of the tip",
            ),
            go.Scatter3d(
                **_xyz(first),
                **line,
                line={"color": theme.GREY, "width": 3, "dash": "dot"},
                name="initial shape",
            ),
        ]
    )
    at = run.instants(MAX_FRAMES)
    frames = [go.Frame(data=moving(i), traces=[0, 1], name=str(k)) for k, i in enumerate(at)]
    figure.frames = frames
    every = np.concatenate([_poses(run, rod, at, stations)[..., :3, 3].reshape(-1, 3), tip_path])
    figure.update_layout(
        **theme.layout(
            640,
            margin={"l": 0, "r": 0, "t": 10, "b": 90},
            scene=_space(every, margin=2.0 * float(np.abs(outline).max())),
            legend={"orientation": "h", "y": 1.0, "x": 0.5, "xanchor": "center", "yanchor": "top"},
            uirevision="kept",
        ),
        **theme.player(frames, _labels(run.t[at]), _pace(run, at), label=_label(run)),
    )
    return figure


def _outline(rod: Rod, stations: Array) -> Array:
    """Corners of the sections in their y and z, (stations, CORNERS, 2); at a joint, of the one before."""
    angle = 2.0 * np.pi * np.arange(CORNERS) / CORNERS
    round_corners = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    # Rays half a corner further meet a square's corners too.
    rays = np.stack([np.cos(angle + np.pi / CORNERS), np.sin(angle + np.pi / CORNERS)], axis=-1)
    square_corners = rays / np.abs(rays).max(axis=1, keepdims=True)
    ends = np.cumsum([segment.length for segment in rod.segments])
    outline = np.empty((len(stations), CORNERS, 2))
    for k, station in enumerate(stations):
        i = min(int(np.searchsorted(ends, station)), len(ends) - 1)
        segment = rod.segments[i]
        fraction = (station - (ends[i] - segment.length)) / segment.length
        size = np.array(segment.section.half_extents(min(max(fraction, 0.0), 1.0)))
        corners = square_corners if segment.section.shape == "rectangle" else round_corners
        outline[k] = np.maximum(size, LEAST_RADIUS * rod.length) * corners
    return outline


def _skin(pose: Array, outline: Array) -> Array:
    """Vertices of a tube, shape (vertices, 3): middle of the base, rings of corners, middle of the tip."""
    centre, y, z = (pose[:, None, :3, column] for column in (3, 1, 2))
    rings = centre + outline[..., :1] * y + outline[..., 1:] * z
    return np.concatenate([pose[:1, :3, 3], rings.reshape(-1, 3), pose[-1:, :3, 3]])


def _along(fraction: Array) -> Array:
    """A value for each vertex of the skin."""
    return np.concatenate([fraction[:1], np.repeat(fraction, CORNERS), fraction[-1:]])


def _faces(stations: int) -> NDArray[np.int32]:
    """Triangles of the skin, shape (faces, 3)."""
    corner = np.arange(CORNERS)
    after = (corner + 1) % CORNERS
    faces = []
    for ring in range(stations - 1):
        near, far = 1 + ring * CORNERS, 1 + (ring + 1) * CORNERS
        faces += [
            np.stack([near + corner, far + corner, near + after], axis=1),
            np.stack([near + after, far + corner, far + after], axis=1),
        ]
    last = 1 + (stations - 1) * CORNERS
    faces += [
        np.stack([np.zeros_like(corner), 1 + corner, 1 + after], axis=1),
        np.stack([np.full_like(corner, last + CORNERS), last + after, last + corner], axis=1),
    ]
    return np.concatenate(faces).astype(np.int32)


def _poses(run: Animated, rod: Rod, at: Any, places: Any) -> Array:
    """Poses at some instants; slides show the rod as it is at time zero."""
    return rod.pose(run.q[at], places, t=run.scene.simulation.t0 if isinstance(run, Slides) else run.t[at])


def _tips(run: Animated, rod: Rod) -> Array:
    at = run.instants(MAX_PATH)
    return _poses(run, rod, at, rod.length)[:, :3, 3]


def _xyz(points: Array) -> dict[str, Array]:
    return dict(zip("xyz", points.T.astype(np.float32), strict=True))


def _space(points: Array, margin: float) -> dict[str, Any]:
    """Three equal axes around the points, seen across the plane in which most of the motion happens."""
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    # A motion in a plane still gets some room across it.
    least = 0.25 * float((high - low).max())
    centre, size = 0.5 * (low + high), np.maximum(high - low, least)
    low, high = centre - 0.5 * size, centre + 0.5 * size
    thin = int(np.argmin(size))
    eye = {0: (1.6, -0.7, 0.55), 1: (0.45, -1.6, 0.45), 2: (0.55, -1.15, 1.3)}[thin]
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
        "aspectmode": "manual",
        "aspectratio": dict(zip("xyz", (float(r) for r in ratio), strict=True)),
        "camera": {
            "eye": dict(zip("xyz", eye, strict=True)),
            "center": {"x": 0, "y": 0, "z": -0.08},
            "projection": {"type": "perspective"},
        },
    }


def _pendulum(run: Animated, pendulum: SpringPendulum) -> Any:
    import plotly.graph_objects as go

    path = _masses(pendulum, run.q[run.instants(MAX_PATH)])

    def bodies(q: Array) -> list[Any]:
        spring = _spring(pendulum, q)
        mass = _masses(pendulum, q[None])[0]
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
        **theme.player(frames, _labels(run.t[at]), _pace(run, at), label=_label(run), y=-0.12),
    )
    return figure


def _masses(pendulum: SpringPendulum, q: Array) -> Array:
    """Positions of the mass, shape (m, 2)."""
    r = pendulum.length + q[:, 1]
    return np.stack([r * np.cos(q[:, 0]), r * np.sin(q[:, 0])], axis=1)


def _spring(pendulum: SpringPendulum, q: Array) -> Array:
    """A zigzag from the hinge to the mass, shape (points, 2)."""
    r, angle = pendulum.length + q[1], q[0]
    along = np.concatenate([[0.0, 0.12], np.linspace(0.12, 0.88, 2 * WINDINGS + 1)[1:-1], [0.88, 1.0]])
    across = np.zeros_like(along)
    across[2:-2] = 0.05 * pendulum.length * (-1.0) ** np.arange(len(along) - 4)
    x, y = r * along, across
    return np.stack([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)], axis=1)
