"""Contact: what touches what, and how surfaces press and rub on each other.

Plain data: everything is checked where it is written, and computed in the core.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING

import numpy as np

from ._lissom import check_contact
from .plain import in_floats, with_number

if TYPE_CHECKING:
    from typing import TypeAlias

    from numpy.typing import NDArray

    Vector: TypeAlias = Sequence[float]
    #: What can touch: the name of a link with a rod, a ball on a link, a shape in the world or on a link.
    Surface: TypeAlias = "str | Ball | HalfSpace | Sphere | Capsule | Box | HeightField | ConvexMesh"


def _in_rows(shape: object, name: str, expected: str) -> None:
    """Makes tuples of tuples of floats of the rows of a shape."""
    value = getattr(shape, name)
    if np.ma.is_masked(value):
        raise TypeError(f"{name}: got masked values, expected {expected}")
    try:
        found = np.asarray(value)
    except ValueError:
        raise ValueError(f"{name}: rows of different lengths, expected {expected} of one length") from None
    if found.dtype.kind not in "biuf":
        raise TypeError(f"{name}: expected {expected}, got {value!r:.80}")
    if found.ndim != 2:
        raise ValueError(f"{name}: {found.ndim} dimensions, expected two: {expected}")
    object.__setattr__(shape, name, tuple(tuple(float(x) for x in row) for row in found))


def _place(shape: object) -> None:
    """Makes a float of the place on a link, if there is one."""
    if getattr(shape, "at", None) is not None:
        with_number(shape, "at")


@dataclass(frozen=True)
class HalfSpace:
    """A floor or a wall: all that lies behind a plane.

    Parameters
    ----------
    point : array_like, shape (3,)
        A point of the plane, metres.
    normal : array_like, shape (3,)
        Outward normal, away from the filled half; of any length.
    link : str, optional
        The link that it is fixed to; by default it is fixed in the world. On a link positions and orientation
        are in the axes of the section or body.
    at : float, optional
        Arc length of the link's unstretched rod, metres; by default the tip, or the base of a rigid link.
    """

    point: Vector = (0.0, 0.0, 0.0)
    normal: Vector = (0.0, 0.0, 1.0)
    _: KW_ONLY
    link: str | None = None
    at: float | None = None

    def __post_init__(self) -> None:
        in_floats(self, "point", "normal")
        _place(self)


@dataclass(frozen=True)
class Sphere:
    """A ball that is fixed in the world, or to a link.

    Parameters
    ----------
    centre : array_like, shape (3,)
        Metres.
    radius : float
        Metres, > 0.
    link : str, optional
        The link that it is fixed to; by default it is fixed in the world. On a link positions and orientation
        are in the axes of the section or body.
    at : float, optional
        Arc length of the link's unstretched rod, metres; by default the tip, or the base of a rigid link.
    """

    centre: Vector
    radius: float
    _: KW_ONLY
    link: str | None = None
    at: float | None = None

    def __post_init__(self) -> None:
        in_floats(self, "centre")
        with_number(self, "radius")
        _place(self)


@dataclass(frozen=True)
class Capsule:
    """All that is within a radius of a straight line between two points: a peg, a bar, a pipe.

    Parameters
    ----------
    start, end : array_like, shape (3,)
        Where the line begins and ends, metres.
    radius : float
        Metres, > 0.
    link : str, optional
        The link that it is fixed to; by default it is fixed in the world. On a link positions and orientation
        are in the axes of the section or body.
    at : float, optional
        Arc length of the link's unstretched rod, metres; by default the tip, or the base of a rigid link.
    """

    start: Vector
    end: Vector
    radius: float
    _: KW_ONLY
    link: str | None = None
    at: float | None = None

    def __post_init__(self) -> None:
        in_floats(self, "start", "end")
        with_number(self, "radius")
        _place(self)


@dataclass(frozen=True)
class Box:
    """A box with sharp edges.

    Parameters
    ----------
    centre : array_like, shape (3,)
        Metres.
    half_extents : array_like, shape (3,)
        Half the lengths of its edges, metres, > 0.
    orientation : array_like, shape (4,)
        Of its axes: unit quaternion (w, x, y, z).
    link : str, optional
        The link that it is fixed to; by default it is fixed in the world. On a link positions and orientation
        are in the axes of the section or body.
    at : float, optional
        Arc length of the link's unstretched rod, metres; by default the tip, or the base of a rigid link.
    """

    centre: Vector
    half_extents: Vector
    orientation: Vector = (1.0, 0.0, 0.0, 0.0)
    _: KW_ONLY
    link: str | None = None
    at: float | None = None

    def __post_init__(self) -> None:
        in_floats(self, "centre", "half_extents", "orientation")
        _place(self)


@dataclass(frozen=True)
class HeightField:
    """Hilly ground: all that lies below a smooth surface through heights above a rectangle.

    The surface is the natural cubic spline through the heights in both directions: forces change smoothly
    along it. Beyond the rectangle it continues straight. Steps in the heights make it overshoot.

    Parameters
    ----------
    heights : array_like, shape (k, l)
        Metres, along the z axis; k along the x axis, l along the y axis, two or more each.
    spacing : float or array_like, shape (2,)
        Distance of neighbouring heights, metres, > 0; two numbers are along x and along y.
    corner : array_like, shape (3,)
        Position above which the first height stands, metres.
    orientation : array_like, shape (4,)
        Of its axes: unit quaternion (w, x, y, z).
    link : str, optional
        The link that it is fixed to; by default it is fixed in the world. On a link positions and orientation
        are in the axes of the section or body.
    at : float, optional
        Arc length of the link's unstretched rod, metres; by default the tip, or the base of a rigid link.
    """

    heights: Sequence[Vector]
    spacing: float | Vector
    corner: Vector = (0.0, 0.0, 0.0)
    orientation: Vector = (1.0, 0.0, 0.0, 0.0)
    _: KW_ONLY
    link: str | None = None
    at: float | None = None

    def __post_init__(self) -> None:
        if np.ndim(self.spacing) == 0:
            object.__setattr__(self, "spacing", (self.spacing, self.spacing))
        in_floats(self, "spacing", "corner", "orientation")
        _in_rows(self, "heights", "rows of numbers")
        _place(self)


@dataclass(frozen=True)
class ConvexMesh:
    """A convex body with flat faces, rounded by a radius.

    Parameters
    ----------
    points : array_like, shape (k, 3)
        Its corners, metres, 4 to 2000; a face has every one of them.
    faces : array_like of int, shape (l, 3)
        Triangles by the places of their corners in `points`, from 0, in any order. They enclose the body.
    radius : float
        Of the rounded edges, by which the body grows on all sides, metres, >= 0.
    link : str, optional
        The link that it is fixed to; by default it is fixed in the world. On a link positions and orientation
        are in the axes of the section or body.
    at : float, optional
        Arc length of the link's unstretched rod, metres; by default the tip, or the base of a rigid link.
    """

    points: Sequence[Vector]
    faces: Sequence[Sequence[int]]
    radius: float = 0.0
    _: KW_ONLY
    link: str | None = None
    at: float | None = None

    def __post_init__(self) -> None:
        _in_rows(self, "points", "points")
        _in_rows(self, "faces", "triangles")
        faces = self.faces
        if all(float(corner).is_integer() for face in faces for corner in face):
            object.__setattr__(self, "faces", tuple(tuple(int(corner) for corner in face) for face in faces))
        with_number(self, "radius")
        _place(self)


@dataclass(frozen=True)
class Ball:
    """A ball that is fixed to a link: a finger tip, a wheel that slides, a body's shape.

    It has no mass; add a `Body` for that.

    Parameters
    ----------
    link : str
        The link.
    radius : float
        Metres, > 0.
    at : float, optional
        Arc length of the link's unstretched rod, metres; by default the tip, or the base of a rigid link.
    position : array_like, shape (3,)
        The centre relative to the section or body, in its axes, metres.
    """

    link: str
    radius: float
    _: KW_ONLY
    at: float | None = None
    position: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        in_floats(self, "position")
        with_number(self, "radius")


@dataclass(frozen=True)
class Contact:
    """A pair of surfaces that can touch: they press on each other where they overlap.

    With the overlap d they press with ``f = k d max(0, 1 + c d')``: newtons a metre along a rod, newtons
    if neither is a rod (Hunt and Crossley 1975). Friction is ``-mu f v / sqrt(|v|^2 + v_s^2)`` with the
    velocity v at which the surfaces slide. "Contact" in the documentation says what these constants mean for
    steps and accuracy.

    Parameters
    ----------
    a : str, Ball, HalfSpace, Sphere, Capsule, Box, HeightField or ConvexMesh
        The moving surface: the name of a link, for its rod, with elliptic sections of their two half
        extents (round against other rods, with the larger one); a ball on a link; or a shape with a `link`.
    b : str, Ball, HalfSpace, Sphere, Capsule, Box, HeightField or ConvexMesh
        What it touches, on another link or in the world. The name of the same link stands for contact of a
        rod with itself, except between places that are nearer to each other along the rod than about three
        diameters. Of two shapes one is a `HalfSpace` or a `Sphere`: boxes, meshes and capsules touch
        half-spaces with their corners or ends.
    stiffness : float, optional
        k: newtons per metre of overlap and metre of rod, N/m^2. By default that of the rods' material,
        ``pi/4 E / (1 - nu^2)`` (Popov 2010, eq. 5.33). Where neither is a rod N/m, and to be given; boxes,
        meshes and capsules have it at each corner or end that touches a half-space.
    dissipation : float
        c, s/m, >= 0. After a slow impact at the speed v the rebound has ``1 - 2 c v / 3`` of it.
    friction : float or array_like, shape (3,)
        mu, >= 0. Three numbers are for rods that slide forward along their axis, backward and sideways.
    slip_velocity : float
        v_s, m/s, > 0. Sticking contacts creep at up to about this speed.
    patch_radius : float
        r, metres, >= 0: radius of the patch over which friction resists spinning by
        ``-mu f r w / sqrt(w^2 + (v_s/r)^2)``, with mu sideways and the angular velocity w about the normal.
        Zero is no resistance.
    name : str, optional
        Its name in messages and results.

    Raises
    ------
    ValueError, TypeError
        If a value is invalid by itself; the robot checks that links and surfaces exist.

    Examples
    --------
    A rod that rests on a floor:

    >>> import lissom
    >>> rubber = {"young_modulus": 1e6, "poisson_ratio": 0.5, "density": 1000}
    >>> segment = lissom.Segment(0.5, radius=0.01, modes={"bend_y": 4}, **rubber)
    >>> floor = lissom.Contact("rod", lissom.HalfSpace((0, 0, -0.05)), friction=0.5)
    >>> rod = lissom.Rod([segment], contacts=[floor])
    >>> result = lissom.statics(rod)
    >>> result.success, len(rod.touches(result.q)) > 0
    (True, True)
    """

    a: Surface
    b: Surface
    _: KW_ONLY
    stiffness: float | None = None
    dissipation: float = 1.0
    friction: float | Vector = 0.0
    slip_velocity: float = 1e-4
    patch_radius: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        friction = np.atleast_1d(np.asarray(self.friction, dtype=float))
        if friction.shape == (1,):
            friction = np.repeat(friction, 3)
        object.__setattr__(self, "friction", tuple(float(mu) for mu in friction))
        if not self.name:

            def of(surface: Surface) -> str:
                if isinstance(surface, str):
                    return surface
                return surface.link or type(surface).__name__.lower()

            object.__setattr__(self, "name", f"{of(self.a)} on {of(self.b)}")
        check_contact(self)


@dataclass(frozen=True)
class Touch:
    """A place where two surfaces touch. Along a rod a contact is the sum of several.

    Attributes
    ----------
    contact : str
        The name of the contact.
    position : ndarray, shape (3,)
        Where on the first surface, metres; where that is a shape, on the rod or ball that touches it.
    normal : ndarray, shape (3,)
        From the second surface to the first, unit vector.
    force : ndarray, shape (3,)
        On the first surface, newtons, friction included.
    overlap : float
        Metres.
    sliding : ndarray, shape (3,)
        Velocity of the first surface along the second, m/s.
    along : tuple of float or None
        Arc lengths on the rods of the two surfaces, metres; None for a surface that is not a rod.
    """

    contact: str
    position: NDArray[np.float64]
    normal: NDArray[np.float64]
    force: NDArray[np.float64]
    overlap: float
    sliding: NDArray[np.float64]
    along: tuple[float | None, float | None]

    def __post_init__(self) -> None:
        with_number(self, "overlap")
