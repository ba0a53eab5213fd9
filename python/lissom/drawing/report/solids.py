"""Links: rods as tubes with their sections, rigid bodies as ellipsoids."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...model import fibres, views
from . import quantities
from .layers import Solid, Tube, quaternions

Array = NDArray[np.float64]

#: Largest radius of a rod with given section properties as drawn, relative to its length, because its inertia
#: need not be that of any figure.
MOST_RADIUS = 0.03


def tube(
    link: views.Link, q: Array, v: Array, t: Array, u: Array, least_radius: float, opacity: float = 1.0
) -> Tube:
    """A rod in several shapes, with at least this radius."""
    poses = link.pose(q, link.stations, t)
    at = fibres.segments(link, link.stations)
    half, hole = sections(link, at, least_radius)
    return Tube(
        link.name,
        poses[..., :3, 3],
        quaternions(poses[..., :3, :3]),
        link.stations,
        half,
        hole,
        [link.segments[i].section.shape == "rectangle" for i in at],
        at,
        quantities.along(link, q, v, t, u, sections(link, at, 0.0)[0], at),
        opacity,
    )


def widest(link: views.Link, least_radius: float) -> float:
    """Largest distance of a rod's surface from its axis as drawn, metres."""
    half, _ = sections(link, fibres.segments(link, link.stations), least_radius)
    return float(half.max())


def ellipsoid(solid: views.Solid, q: Array, t: Array, least_radius: float) -> Solid:
    """A rigid body in several shapes, with at least this size."""
    poses = np.broadcast_to(solid.pose(q, t), (len(q), 4, 4))
    size = np.maximum(solid.semi_axes, least_radius)
    return Solid(solid.name, "bodies", "ellipsoid", size, poses[:, :3, 3], quaternions(poses[:, :3, :3]))


def placed(poses: Array, points: Array) -> Array:
    """Transform points (points, 3) in frames (..., 4, 4) to the world, (..., points, 3)."""
    return points @ np.swapaxes(poses[..., :3, :3], -1, -2) + poses[..., None, :3, 3]


def sections(link: views.Link, at: list[int], least_radius: float) -> tuple[Array, Array]:
    """Half extents along y and z (stations, 2), metres, and relative radii of holes (stations,)."""
    half, hole = np.empty((len(at), 2)), np.zeros(len(at))
    for k, (fraction, i) in enumerate(zip(fibres.fractions(link, link.stations, at), at, strict=True)):
        section = link.segments[i].section
        size = np.array(section.half_extents(fraction))
        if section.shape == "given":
            size = np.minimum(size, MOST_RADIUS * link.length)
        if section.shape == "hollow_circle":
            # The second moment of a circle of radius r is A r²/4, of a ring A (r² + inner²)/4.
            inner = 4.0 * section.second_moments(fraction)[0] / section.area(fraction) - size[0] ** 2
            hole[k] = np.sqrt(max(inner, 0.0)) / size[0]
        half[k] = np.maximum(size, least_radius)
    return half, hole
