"""Animated views of a motion: links in space, a mass on a line in its plane."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..views import Link, Sketch, Solid, View
from . import page, theme

Array = NDArray[np.float64]

#: Frames of an animation, at most: about eight seconds at the pace of a film.
MAX_FRAMES = 200

#: Slowest and fastest playback, milliseconds a frame.
PACE = (25.0, 200.0)

#: Corners of the drawn cross-section.
CORNERS = 12

#: A rod is drawn at least this thick, relative to its length, so that a wire can be seen.
LEAST_RADIUS = 0.006

#: A given section, whose inertia need not be that of any figure, is drawn at most this thick, relative to
#: the rod's length.
MOST_RADIUS = 0.03

#: Points of the path of a tip, at most.
MAX_PATH = 3000

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
    def clock(self) -> Array:
        """Times at which the model is shown, seconds, shape (m,)."""

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
    """Links as tubes, frames as points with the paths that they take."""
    import plotly.graph_objects as go

    least = LEAST_RADIUS * run.view.size
    skins: list[Tube | Ellipsoid] = [Tube(link, least) for link in run.view.links]
    skins += [Ellipsoid(solid, least) for solid in run.view.solids]
    path = run.instants(MAX_PATH)
    paths = [frame.pose(run.q[path], run.clock[path])[:, :3, 3] for frame in run.view.frames]

    def moving(i: int) -> list[Any]:
        """What changes from frame to frame: the positions alone."""
        points = [frame.pose(run.q[i], run.clock[i])[:3, 3] for frame in run.view.frames]
        return [skin.trace(run, i) for skin in skins] + [
            go.Scatter3d(x=x[None], y=y[None], z=z[None]) for x, y, z in points
        ]

    first = moving(0)
    for skin, trace in zip(skins, first, strict=False):
        trace.update(skin.looks())
    dot = {"size": 4, "color": theme.ORANGE}
    for frame, trace in zip(run.view.frames, first[len(skins) :], strict=True):
        trace.update(mode="markers", marker=dot, name=frame.name, hoverinfo="skip")
    starts = [skin.centre_line(run, 0) for skin in skins if isinstance(skin, Tube)]
    figure = go.Figure([*first, *_paths(run.view, paths), *_initial_shapes(starts)])
    at = run.instants(MAX_FRAMES)
    frames = [go.Frame(data=moving(i), traces=list(range(len(first))), name=str(k)) for k, i in enumerate(at)]
    figure.frames = frames
    every = np.concatenate([skin.centre_line(run, at).reshape(-1, 3) for skin in skins] + paths)
    figure.update_layout(
        **theme.layout(
            640,
            margin={"l": 0, "r": 0, "t": 10, "b": 90},
            scene=_space(every, margin=2.0 * max(skin.widest for skin in skins)),
            legend={"orientation": "h", "y": 1.0, "x": 0.5, "xanchor": "center", "yanchor": "top"},
            uirevision="kept",
        ),
        **theme.player(frames, _labels(run.t[at]), _pace(run, at), label=run.label),
    )
    return figure


class Ellipsoid:
    """The skin of a rigid body, drawn at least so thick."""

    def __init__(self, solid: Solid, least_radius: float) -> None:
        self.solid = solid
        latitude, longitude = np.meshgrid(
            np.linspace(-np.pi / 2, np.pi / 2, CORNERS // 2 + 1),
            np.linspace(-np.pi, np.pi, CORNERS, endpoint=False),
            indexing="ij",
        )
        sphere = [
            np.cos(latitude) * np.cos(longitude),
            np.cos(latitude) * np.sin(longitude),
            np.sin(latitude),
        ]
        self.skin = np.stack(sphere, axis=-1).reshape(-1, 3) * np.maximum(solid.semi_axes, 2.0 * least_radius)

    @property
    def widest(self) -> float:
        """How far the skin is from the centre, at most, metres."""
        return float(np.abs(self.skin).max())

    def centre_line(self, run: Animated, at: Any) -> Array:
        """Positions of the centre (..., 1, 3) in the shapes of these indices."""
        return self.solid.pose(run.q[at], run.clock[at])[..., None, :3, 3]

    def trace(self, run: Animated, i: int) -> Any:
        """The vertices of the skin in one shape."""
        import plotly.graph_objects as go

        pose = self.solid.pose(run.q[i], run.clock[i])
        return go.Mesh3d(**_xyz(self.skin @ pose[:3, :3].T + pose[:3, 3]))

    def looks(self) -> dict[str, Any]:
        """The faces, which stay the same, and how they look."""
        rings, around = CORNERS // 2, np.arange(CORNERS)
        here = (np.arange(rings)[:, None] * CORNERS + around).ravel()
        beside = (np.arange(rings)[:, None] * CORNERS + (around + 1) % CORNERS).ravel()
        i, j, k = np.stack(
            [[here, beside, here + CORNERS], [beside, beside + CORNERS, here + CORNERS]], axis=1
        )
        return {
            "i": i.ravel(),
            "j": j.ravel(),
            "k": k.ravel(),
            "color": theme.GREY,
            "flatshading": False,
            "name": self.solid.name,
            "hoverinfo": "name",
        }


def _paths(view: View, paths: list[Array]) -> list[Any]:
    """Where the frames go."""
    import plotly.graph_objects as go

    return [
        go.Scatter3d(
            **_xyz(path),
            mode="lines",
            hoverinfo="skip",
            line={"color": theme.ORANGE, "width": 2},
            opacity=0.55,
            name=f"path of the {frame.name}",
        )
        for frame, path in zip(view.frames, paths, strict=True)
    ]


def _initial_shapes(centre_lines: list[Array]) -> list[Any]:
    import plotly.graph_objects as go

    return [
        go.Scatter3d(
            **_xyz(line),
            mode="lines",
            hoverinfo="skip",
            line={"color": theme.GREY, "width": 3, "dash": "dot"},
            name="initial shape",
        )
        for line in centre_lines
    ]


class Tube:
    """The skin of a link, drawn at least so thick."""

    def __init__(self, link: Link, least_radius: float) -> None:
        self.link = link
        self.outline = _outline(link, least_radius)

    @property
    def widest(self) -> float:
        """How far the skin is from the axis, at most, metres."""
        return float(np.abs(self.outline).max())

    def centre_line(self, run: Animated, at: Any) -> Array:
        """Positions (..., stations, 3) in the shapes of these indices."""
        return self.link.pose(run.q[at], self.link.stations, run.clock[at])[..., :3, 3]

    def trace(self, run: Animated, i: int) -> Any:
        """The vertices of the skin in one shape."""
        import plotly.graph_objects as go

        pose = self.link.pose(run.q[i], self.link.stations, run.clock[i])
        return go.Mesh3d(**_xyz(_skin(pose, self.outline)))

    def looks(self) -> dict[str, Any]:
        """What does not change: faces, colours, light."""
        stations = self.link.stations
        return {
            **dict(zip("ijk", _faces(len(stations)).T, strict=True)),
            "intensity": _along(stations / self.link.length),
            "colorscale": theme.ROD_SCALE,
            "showscale": False,
            "flatshading": False,
            "lighting": {
                "ambient": 0.55,
                "diffuse": 0.75,
                "specular": 0.35,
                "roughness": 0.45,
                "fresnel": 0.1,
            },
            "lightposition": {"x": 2e4, "y": -3e4, "z": 4e4},
            "hoverinfo": "skip",
            "name": self.link.name,
        }


def _outline(link: Link, least_radius: float) -> Array:
    """Corners of the sections in their y and z, (stations, CORNERS, 2); at a joint, of the one before."""
    stations = link.stations
    angle = 2.0 * np.pi * np.arange(CORNERS) / CORNERS
    round_corners = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    # Rays half a corner further meet a square's corners too.
    rays = np.stack([np.cos(angle + np.pi / CORNERS), np.sin(angle + np.pi / CORNERS)], axis=-1)
    square_corners = rays / np.abs(rays).max(axis=1, keepdims=True)
    ends = np.cumsum([segment.length for segment in link.segments])
    outline = np.empty((len(stations), CORNERS, 2))
    for k, station in enumerate(stations):
        i = min(int(np.searchsorted(ends, station)), len(ends) - 1)
        segment = link.segments[i]
        fraction = (station - (ends[i] - segment.length)) / segment.length
        size = np.array(segment.section.half_extents(min(max(fraction, 0.0), 1.0)))
        if segment.section.shape == "given":
            size = np.minimum(size, MOST_RADIUS * link.length)
        corners = square_corners if segment.section.shape == "rectangle" else round_corners
        outline[k] = np.maximum(size, least_radius) * corners
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
