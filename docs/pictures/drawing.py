"""Shapes of models drawn with matplotlib: rods as tubes, rigid bodies as ellipsoids."""

import numpy as np
from matplotlib import colormaps
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import NDArray

from lissom.model.contacts import Box, Capsule, ConvexMesh, HalfSpace, HeightField, Sphere
from lissom.model.glyphs.contacts import ground
from lissom.model.views import Link, Solid, View

Array = NDArray[np.float64]

#: Points around a tube, and around and along an ellipsoid.
AROUND = 16

#: A rod is drawn at least and at most this thick, relative to its model: a wire can be seen, and a
#: section of a given stiffness, of which only the inertia is known, hides nothing.
LEAST_RADIUS, LARGEST_RADIUS = 0.006, 0.05

#: Faces without edges.
FLAT = {"shade": False, "linewidth": 0}

COLOURS = colormaps["viridis"]
GREY = np.array([0.45, 0.5, 0.58, 1.0])
FLOOR = np.array([0.86, 0.88, 0.91, 1.0])

#: Direction of the light, and how bright a surface is that faces away from it.
LIGHT, SHADE = np.array([-0.4, -0.5, 0.77]), 0.55


def tube(link: Link, q: Array, t: float, size: float) -> Array:
    """Points (stations, AROUND, 3) of the skin of a rod, metres; its ends are closed."""
    poses = link.pose(q, link.stations, t)
    ends = np.concatenate([[0.0], np.cumsum([segment.length for segment in link.segments])])
    radii = np.empty(len(link.stations))
    for i, X in enumerate(link.stations):
        k = min(np.searchsorted(ends, X, side="right") - 1, len(link.segments) - 1)
        part = link.segments[k]
        drawn = max(part.section.half_extents(min((X - ends[k]) / part.length, 1.0)))
        radii[i] = size * np.clip(drawn / size, LEAST_RADIUS, LARGEST_RADIUS)
    angles = np.linspace(0.0, 2.0 * np.pi, AROUND)
    ring = np.outer(np.cos(angles), [0, 1, 0]) + np.outer(np.sin(angles), [0, 0, 1])
    skin = poses[:, None, :3, 3] + radii[:, None, None] * np.einsum("sij,aj->sai", poses[:, :3, :3], ring)
    closed = [np.repeat(poses[i, None, None, :3, 3], AROUND, axis=1) for i in (0, -1)]
    return np.concatenate([closed[0], skin, closed[1]])


def ellipsoid(solid: Solid, q: Array, t: float) -> Array:
    """Points (AROUND, AROUND, 3) of the surface of a rigid body, metres."""
    pose = solid.pose(q, t)
    u, v = np.meshgrid(np.linspace(0, np.pi, AROUND), np.linspace(0, 2 * np.pi, AROUND), indexing="ij")
    unit = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], axis=-1)
    return pose[:3, 3] + (unit * solid.semi_axes) @ pose[:3, :3].T


def surfaces(view: View, q: Array, t: float) -> list[tuple[Array, Array]]:
    """Points and colours of all that is drawn of a shape."""
    found = []
    for link in view.links:
        skin = tube(link, q, t, view.size)
        along = np.linspace(0.15, 0.95, len(skin) - 1)
        found.append((skin, np.repeat(COLOURS(along)[:, None], AROUND - 1, axis=1)))
    for solid in view.solids:
        if np.all(solid.semi_axes > 0.0):
            found.append((ellipsoid(solid, q, t), np.broadcast_to(GREY, (AROUND - 1, AROUND - 1, 4))))
    return found


def obstacles(view: View, low: Array, high: Array) -> list[Array]:
    """Points of what is fixed in the world and can be touched, below or beside a box, metres."""
    found = []
    for glyph in view.glyphs.contacts.pairs:
        match glyph.obstacle:
            case HalfSpace(point, normal):
                found.append(patch(np.asarray(point), np.asarray(normal), low, high))
            case Sphere(centre, radius):
                found.append(capsule(np.asarray(centre), np.add(centre, [0, 0, 1e-9]), radius))
            case Capsule(start, end, radius):
                found.append(capsule(np.asarray(start), np.asarray(end), radius))
            case Box(centre, half, (w, x, y, z)):
                cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
                turn = np.eye(3) + 2 * w * cross + 2 * cross @ cross
                square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
                rings = [(0.0, -1), (1.0, -1), (1.0, 1), (0.0, 1)]
                unit = np.array([[[*(wide * corner), side] for corner in square] for wide, side in rings])
                found.append(np.asarray(centre) + (unit * half) @ turn.T)
            case HeightField():
                found.append(ground(glyph.obstacle))
            case ConvexMesh(points, faces):
                triangles = np.asarray(points)[np.asarray(faces, dtype=int)]
                found += [corners[[[0, 1], [0, 2]]] for corners in triangles]
    return found


def across(normal: Array) -> Array:
    """Two unit vectors (2, 3) across a direction."""
    normal = normal / np.linalg.norm(normal)
    first = np.eye(3)[np.argmin(np.abs(normal))]
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first)])


def patch(point: Array, normal: Array, low: Array, high: Array) -> Array:
    """The part (2, 2, 3) of a plane that is next to a box."""
    axes = across(normal)
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
    along = (corners - point) @ axes.T
    (a, b), (c, d) = along.min(axis=0), along.max(axis=0)
    return point + np.array([[[a, b], [a, d]], [[c, b], [c, d]]]) @ axes


def capsule(start: Array, end: Array, radius: float) -> Array:
    """Points of all that is within a radius of a line."""
    along = (end - start) / np.linalg.norm(end - start)
    axes = across(along)
    angles = np.linspace(0.0, 2.0 * np.pi, AROUND)
    ring = np.outer(np.cos(angles), axes[0]) + np.outer(np.sin(angles), axes[1])
    rows = []
    for centre, angle in [(start, -a) for a in np.linspace(np.pi / 2, 0, 6)] + [
        (end, a) for a in np.linspace(0, np.pi / 2, 6)
    ]:
        rows.append(centre + radius * (np.sin(angle) * along + np.cos(angle) * ring))
    return np.array(rows)


def lit(points: Array, colours: Array) -> Array:
    """Colours by how the faces turn to the light."""
    across = points[1:, 1:] - points[:-1, :-1]
    normals = np.cross(across, points[1:, :-1] - points[:-1, 1:])
    norms = np.linalg.norm(normals, axis=-1, keepdims=True)
    facing = np.abs(normals @ LIGHT / np.maximum(norms[..., 0], 1e-30))
    shaded = np.array(colours, dtype=float)
    shaded[..., :3] *= (SHADE + (1.0 - SHADE) * facing)[..., None]
    return shaded


def draw(axes: Axes3D, view: View, q: Array, t: float, alpha: float = 1.0) -> None:
    """Adds one shape to the axes."""
    for points, colours in surfaces(view, q, t):
        faces = lit(points, colours)
        faces[..., 3] = alpha
        axes.plot_surface(*np.moveaxis(points, -1, 0), facecolors=faces, rstride=1, cstride=1, **FLAT)


def frame(axes: Axes3D, view: View, motion, elevation: float, azimuth: float, zoom: float = 1.0) -> None:
    """Fits the axes around a whole motion, to scale, and takes grid and ticks away."""
    instants = np.linspace(0, len(motion.t) - 1, 24).astype(int)
    points = np.concatenate(
        [p.reshape(-1, 3) for i in instants for p, _ in surfaces(view, motion.q[i], float(motion.t[i]))]
    )
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = 0.5 * (low + high), np.maximum(0.5 * (high - low), 0.05 * view.size)
    reach = 0.1 * (high - low).max()
    around = obstacles(view, low - reach, high + reach)
    if around:
        points = np.concatenate([points, *(p.reshape(-1, 3) for p in around)])
        low, high = points.min(axis=0), points.max(axis=0)
    for surface in around:
        colour = FLOOR if len(surface) == 2 else GREY
        faces = lit(surface, np.broadcast_to(colour, (*np.subtract(surface.shape[:2], 1), 4)))
        axes.plot_surface(*np.moveaxis(surface, -1, 0), facecolors=faces, rstride=1, cstride=1, **FLAT)
    axes.set(
        xlim=(middle[0] - half[0], middle[0] + half[0]),
        ylim=(middle[1] - half[1], middle[1] + half[1]),
        zlim=(middle[2] - half[2], middle[2] + half[2]),
    )
    axes.set_box_aspect(half, zoom=zoom)
    axes.view_init(elevation, azimuth)
    axes.set_axis_off()
