"""Layers of a 3-D view: tubes, solids, meshes, strands, arrows, dots and lines.

Geometry for all displayed shapes as plain data. One function of ``player/tubes.js``,
``player/visuals.js`` or ``player/marks.js`` draws each kind.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from .packing import Numbers

Array = NDArray[np.float64]

#: Changes below this fraction of the largest coordinate count as no motion.
SEEN = 1e-6

#: Break of a line.
BREAK = np.full((1, 3), np.nan)


class Largest:
    """The largest values of objects that are drawn to scale.

    A report shows all shapes at once, and its scales follow from all of them. A live view shows one shape
    after the other, and keeps these values from shape to shape, so that growth is visible.
    """

    def __init__(self) -> None:
        self._found: dict[str, Array] = {}

    def of(self, name: str, values: Array | float) -> Array:
        """Element-wise maximum of the values with this name so far, including these."""
        found = np.maximum(values, self._found.get(name, values))
        self._found[name] = found
        return found


@dataclass(frozen=True)
class DrawnStates:
    """The shapes in which a model is displayed."""

    #: Coordinates, velocities (shapes, n) and inputs (shapes, inputs), times and load factors (shapes,).
    q: Array
    v: Array
    u: Array
    t: Array
    load_factor: Array
    #: Reference length of symbols, metres.
    size: float
    #: Radius of the thickest rod as drawn, and half the length of a joint's axis, metres.
    radius: float
    half_axis: float
    #: Scales of forces and of joint displacements.
    largest: Largest = field(default_factory=Largest)


@dataclass(frozen=True)
class Tube:
    """A rod with its sections."""

    name: str
    #: Centres (shapes, stations, 3), metres, and unit quaternions (shapes, stations, 4) of the sections,
    #: scalar first.
    centres: Array
    turns: Array
    #: Arc lengths (stations,) and half extents along y and z (stations, 2), metres.
    stations: Array
    half: Array
    #: Radius of the hole relative to that of the section, (stations,).
    hole: Array
    #: Whether the section at each station is a rectangle, not an ellipse.
    square: Sequence[bool]
    #: Index of the segment of each station.
    segment: Sequence[int]
    #: Quantities for colours: values (shapes, stations) by name.
    quantities: Mapping[str, Array] = field(default_factory=dict)
    opacity: float = 1.0
    layer: str = "rods"
    kind: Literal["tube"] = "tube"

    @property
    def points(self) -> Array:
        """Points that the view must include."""
        reach = np.abs(self.half).max(axis=1)[:, None]
        return np.concatenate([self.centres - reach, self.centres + reach], axis=1)

    @property
    def numbers(self) -> dict[str, Any]:
        """The data of the player, apart from the name."""
        return {
            "centres": still(self.centres),
            "turns": still(self.turns),
            "stations": self.stations,
            "half": self.half,
            "hole": self.hole,
            "square": [int(is_square) for is_square in self.square],
            "segment": list(self.segment),
            "quantities": {name: Numbers(values, "u1") for name, values in self.quantities.items()},
            "opacity": self.opacity,
        }


@dataclass(frozen=True)
class Solid:
    """A rigid body: an ellipsoid given by its semi-axes, or a box given by half its sides."""

    name: str
    layer: str
    form: Literal["ellipsoid", "box"]
    size: Array
    #: Centres (shapes, 3), metres, and unit quaternions (shapes, 4).
    centres: Array
    turns: Array
    opacity: float = 1.0
    kind: Literal["solid"] = "solid"

    @property
    def points(self) -> Array:
        """Points that the view must include."""
        if self.form == "box":
            w, x, y, z = self.turns.T
            axes = 2.0 * np.array(
                [
                    [x * x + w * w, x * y - w * z, x * z + w * y],
                    [x * y + w * z, y * y + w * w, y * z - w * x],
                    [x * z - w * y, y * z + w * x, z * z + w * w],
                ]
            )
            axes -= np.eye(3)[:, :, None]
            # Poses that are constant over the shapes are stored only once.
            reach = np.einsum("ijk,j->ki", np.abs(axes), self.size)
        else:
            reach = np.full((1, 3), np.max(self.size))
        return np.stack([self.centres - reach, self.centres + reach], axis=1)

    @property
    def numbers(self) -> dict[str, Any]:
        """The data of the player, apart from the name."""
        centres, turns = still(self.centres[:, None]), still(self.turns[:, None])
        return {
            "form": self.form,
            "size": np.asarray(self.size).tolist(),
            "centres": centres,
            "turns": turns,
            "opacity": self.opacity,
        }


@dataclass(frozen=True)
class Mesh:
    """A rigid triangle mesh."""

    name: str
    layer: str
    #: Corners (v, 3), metres, with unit normals (v, 3), and triangles (m, 3), in the axes of the mesh.
    corners: Array
    normals: Array
    faces: NDArray[np.int64]
    #: Places of the origin (shapes, 3), metres, and unit quaternions (shapes, 4).
    centres: Array
    turns: Array
    #: A hexadecimal colour; that of the layer if None.
    colour: str | None = None
    opacity: float = 1.0
    #: Whether its surface has an edge, and is seen from both sides.
    is_open: bool = False
    kind: Literal["mesh"] = "mesh"

    @property
    def points(self) -> Array:
        """Points that the view must include: the corners of its box in its own axes."""
        low, high = self.corners.min(axis=0), self.corners.max(axis=0)
        box = np.array(np.meshgrid(*np.stack([low, high], axis=-1))).reshape(3, -1)
        return np.asarray(np.swapaxes(rotations(self.turns) @ box, -1, -2) + self.centres[:, None])

    @property
    def numbers(self) -> dict[str, Any]:
        """The data of the player, apart from the name."""
        return {
            "corners": self.corners,
            "normals": Numbers(self.normals, "u1"),
            # Whole numbers: the player rounds.
            "faces": Numbers(self.faces, "u2" if len(self.corners) < 1 << 15 else "u4"),
            "centres": still(self.centres[:, None]),
            "turns": still(self.turns[:, None]),
            "opacity": self.opacity,
            **({} if self.colour is None else {"colour": self.colour}),
        }


@dataclass(frozen=True)
class Strand:
    """Round bars between points: tendons, springs, axes."""

    name: str
    layer: str
    #: Points (shapes, points, 3), metres; NaN breaks the strand.
    points: Array
    #: Metres, (shapes,).
    radius: Array
    opacity: float = 1.0
    kind: Literal["strand"] = "strand"

    @property
    def numbers(self) -> dict[str, Any]:
        """The data of the player, apart from the name."""
        return {
            "points": still(self.points),
            "radius": still(self.radius[:, None], exact=True),
            "opacity": self.opacity,
        }


@dataclass(frozen=True)
class Arrows:
    """Arrows of one layer."""

    #: Names of the arrows, (arrows,).
    names: Sequence[str]
    layer: str
    #: Tails and vectors (shapes, arrows, 3), metres.
    tails: Array
    vectors: Array
    #: Length and radius of a head, and radius of a shaft, metres; a head is at most the fraction ``most`` of
    #: its arrow.
    head: float
    head_radius: float
    radius: float
    most: float = 0.6
    kind: Literal["arrows"] = "arrows"

    @property
    def name(self) -> str:
        """The names of all arrows."""
        return ", ".join(dict.fromkeys(self.names))

    @property
    def points(self) -> Array:
        """Points that the view must include."""
        return np.concatenate([self.tails, self.tails + self.vectors], axis=1)

    @property
    def numbers(self) -> dict[str, Any]:
        """The data of the player, apart from the name."""
        return {
            "tails": still(self.tails),
            "vectors": still(self.vectors),
            "head": self.head,
            "headRadius": self.head_radius,
            "radius": self.radius,
            "most": self.most,
        }


@dataclass(frozen=True)
class Dots:
    """Balls of equal size."""

    names: Sequence[str]
    layer: str
    #: Points (shapes, dots, 3) and radius, metres.
    points: Array
    radius: float
    opacity: float = 1.0
    kind: Literal["dots"] = "dots"

    @property
    def name(self) -> str:
        """The names of all balls."""
        return ", ".join(dict.fromkeys(self.names))

    @property
    def numbers(self) -> dict[str, Any]:
        """The data of the player, apart from the name."""
        return {"points": still(self.points), "radius": self.radius, "opacity": self.opacity}


@dataclass(frozen=True)
class Line:
    """A thin static line, with a constant width on the screen."""

    name: str
    layer: str
    #: Points (1, points, 3), metres; NaN breaks the line.
    points: Array
    dashed: bool = False
    kind: Literal["line"] = "line"

    @property
    def numbers(self) -> dict[str, Any]:
        """The data of the player, apart from the name."""
        return {"points": self.points, "dashed": self.dashed}


Thing = Tube | Solid | Mesh | Strand | Arrows | Dots | Line


def still(values: Array, exact: bool = False) -> Array:
    """Values over the shapes; only those of the first shape if they are constant up to rounding."""
    apart = np.nan_to_num(np.abs(values - values[:1]))
    least = 0.0 if exact else SEEN * float(np.nan_to_num(np.abs(values)).max())
    return values if float(apart.max(initial=0.0)) > least else values[:1]


def extent(things: Sequence[Thing]) -> tuple[Array, Array]:
    """Corners of the bounding box of all points."""
    every = np.concatenate([thing.points.reshape(-1, 3) for thing in things])
    return np.nanmin(every, axis=0), np.nanmax(every, axis=0)


def quaternions(turns: Array) -> Array:
    """Unit quaternions, scalar first, (..., 4) of rotation matrices (..., 3, 3).

    The signs are chosen to avoid jumps along the first axis.

    Computed from the component of largest magnitude, to avoid cancellation (Shepperd 1978).
    """
    m = np.nan_to_num(turns)
    xx, yy, zz = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    trace = xx + yy + zz
    a, b, c = m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]
    d, e, f = m[..., 0, 1] + m[..., 1, 0], m[..., 0, 2] + m[..., 2, 0], m[..., 1, 2] + m[..., 2, 1]
    # Each row is four times the quaternion times one of its components.
    rows = np.stack(
        [
            np.stack([1 + trace, a, b, c], axis=-1),
            np.stack([a, 1 + 2 * xx - trace, d, e], axis=-1),
            np.stack([b, d, 1 + 2 * yy - trace, f], axis=-1),
            np.stack([c, e, f, 1 + 2 * zz - trace], axis=-1),
        ],
        axis=-2,
    )
    largest = np.argmax(np.diagonal(rows, axis1=-2, axis2=-1), axis=-1)
    found = np.take_along_axis(rows, largest[..., None, None], axis=-2)[..., 0, :]
    found = found / np.linalg.norm(found, axis=-1, keepdims=True)
    signs = np.sign(np.einsum("k...i,k...i->k...", found[1:], found[:-1]))
    found[1:] *= np.cumprod(np.where(signs < 0.0, -1.0, 1.0), axis=0)[..., None]
    return np.asarray(found)


def rotations(turns: Array) -> Array:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4), scalar first."""
    w, x, y, z = np.moveaxis(turns, -1, 0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
