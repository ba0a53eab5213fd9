"""Skins of links: rods as tubes, rigid bodies as ellipsoids."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..views import Link, Solid
from . import theme
from .layers import Trace

Array = NDArray[np.float64]

#: Corners of the drawn cross-section.
CORNERS = 12

#: Rings of corners of an ellipsoid, without its poles.
RINGS = 5

#: A given section, whose inertia need not be that of any figure, is drawn at most this thick, relative to
#: the rod's length.
MOST_RADIUS = 0.03

#: How light falls on skins.
LIGHT = {
    "flatshading": False,
    "lighting": {"ambient": 0.55, "diffuse": 0.75, "specular": 0.35, "roughness": 0.45, "fresnel": 0.1},
    "lightposition": {"x": 2e4, "y": -3e4, "z": 4e4},
}


def tube(link: Link, q: Array, t: Array, least_radius: float, opacity: float = 1.0) -> Trace:
    """The skin of a rod in several shapes, drawn at least so thick."""
    stations = link.stations
    skin = _skin(link.pose(q, stations, t), _outline(link, least_radius))
    looks = {
        **dict(zip("ijk", _faces(len(stations)).T, strict=True)),
        "intensity": _along(stations / link.length),
        "colorscale": theme.ROD_SCALE,
        "showscale": False,
        "opacity": opacity,
        "hoverinfo": "name",
        "name": link.name,
    }
    return Trace("rods", "mesh3d", skin, looks | LIGHT)


def widest(link: Link, least_radius: float) -> float:
    """How far the skin of a rod is from its axis, at most, metres."""
    return float(np.abs(_outline(link, least_radius)).max())


def ellipsoid(solid: Solid, q: Array, t: Array, least_radius: float) -> Trace:
    """The skin of a rigid body in several shapes, drawn at least so large."""
    latitude = np.linspace(-np.pi / 2, np.pi / 2, RINGS + 2)[1:-1]
    longitude = 2.0 * np.pi * np.arange(CORNERS) / CORNERS
    rings = np.stack(
        [
            np.repeat(np.sin(latitude), CORNERS),
            np.outer(np.cos(latitude), np.cos(longitude)).ravel(),
            np.outer(np.cos(latitude), np.sin(longitude)).ravel(),
        ],
        axis=1,
    )
    sphere = np.concatenate([[[-1.0, 0.0, 0.0]], rings, [[1.0, 0.0, 0.0]]])
    skin = placed(solid.pose(q, t), sphere * np.maximum(solid.semi_axes, least_radius))
    looks = {
        **dict(zip("ijk", _faces(RINGS).T, strict=True)),
        "color": theme.GREY,
        "hoverinfo": "name",
        "name": solid.name,
    }
    return Trace("bodies", "mesh3d", skin, looks | LIGHT)


def placed(poses: Array, points: Array) -> Array:
    """Points (points, 3) in frames (..., 4, 4), seen from the world, (..., points, 3)."""
    return points @ np.swapaxes(poses[..., :3, :3], -1, -2) + poses[..., None, :3, 3]


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


def _skin(poses: Array, outline: Array) -> Array:
    """Vertices of a tube, (shapes, vertices, 3): middle of the base, rings of corners, middle of the tip."""
    centre, y, z = (poses[:, :, None, :3, column] for column in (3, 1, 2))
    rings = centre + outline[..., :1] * y + outline[..., 1:] * z
    return np.concatenate(
        [poses[:, :1, :3, 3], rings.reshape(len(poses), -1, 3), poses[:, -1:, :3, 3]], axis=1
    )


def _along(fraction: Array) -> Array:
    """A value for each vertex of the skin."""
    return np.concatenate([fraction[:1], np.repeat(fraction, CORNERS), fraction[-1:]])


def _faces(rings: int) -> NDArray[np.int32]:
    """Triangles of a skin of a point, so many rings of corners and a point, shape (faces, 3)."""
    corner = np.arange(CORNERS)
    after = (corner + 1) % CORNERS
    faces = []
    for ring in range(rings - 1):
        near, far = 1 + ring * CORNERS, 1 + (ring + 1) * CORNERS
        faces += [
            np.stack([near + corner, far + corner, near + after], axis=1),
            np.stack([near + after, far + corner, far + after], axis=1),
        ]
    last = 1 + (rings - 1) * CORNERS
    faces += [
        np.stack([np.zeros_like(corner), 1 + corner, 1 + after], axis=1),
        np.stack([np.full_like(corner, last + CORNERS), last + after, last + corner], axis=1),
    ]
    return np.concatenate(faces).astype(np.int32)
