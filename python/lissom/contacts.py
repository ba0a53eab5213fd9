"""Contact: the surfaces that can touch, and their pressure and friction.

These classes only hold data. They validate it when they are created; the compiled core does the computing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING

import numpy as np

from ._lissom import check_contact
from .plain import in_floats, in_floats_for_each, with_number, with_text

if TYPE_CHECKING:
    from typing import TypeAlias

    from numpy.typing import NDArray

    Vector: TypeAlias = Sequence[float]
    #: A surface: the name of a link with a rod, a ball on a link, a shape in the world or on a link.
    Surface: TypeAlias = "str | Ball | HalfSpace | Sphere | Capsule | Box | HeightField | ConvexMesh"


def _in_rows(shape: object, name: str, expected: str) -> None:
    """Convert the rows of a shape to tuples of floats."""
    value = getattr(shape, name)
    if np.ma.is_masked(value):
        raise TypeError(f"{name}: got masked values, expected {expected}")
    try:
        found = np.asarray(value)
    except ValueError:
        raise ValueError(f"{name}: rows of different lengths, expected {expected} of one length") from None
    if found.dtype.kind not in "iuf":
        raise TypeError(f"{name}: expected {expected}, got {value!r:.80}")
    if found.ndim != 2:
        raise ValueError(f"{name}: {found.ndim} dimensions, expected two: {expected}")
    object.__setattr__(shape, name, tuple(tuple(float(x) for x in row) for row in found))


def _place(shape: object) -> None:
    """Check the place on a link, if given."""
    for name, convert in (("link", with_text), ("at", with_number)):
        if getattr(shape, name) is not None:
            convert(shape, name)


@dataclass(frozen=True)
class HalfSpace:
    """A floor or a wall: the region behind a plane.

    Parameters
    ----------
    point : array_like, shape (3,)
        A point on the plane, metres.
    normal : array_like, shape (3,)
        Outward normal, pointing away from the solid. Its length does not matter.
    link : str, optional
        Link to which the shape is fixed; by default the world. On a link, positions and orientations are in
        the axes of the section or body.
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
    """A sphere fixed in the world or to a link.

    Parameters
    ----------
    centre : array_like, shape (3,)
        Centre, metres.
    radius : float
        Radius, metres, > 0.
    link : str, optional
        Link to which the shape is fixed; by default the world. On a link, positions and orientations are in
        the axes of the section or body.
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
    """A capsule fixed in the world, such as a peg, bar or pipe: the points within a radius of a line segment.

    Parameters
    ----------
    start, end : array_like, shape (3,)
        End points of the line segment, metres.
    radius : float
        Radius, metres, > 0.
    link : str, optional
        Link to which the shape is fixed; by default the world. On a link, positions and orientations are in
        the axes of the section or body.
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
    """A box with sharp edges, fixed in the world or to a link.

    Against boxes, meshes and capsules its edges are rounded by 0.04 of half the thickness of the thinner
    body.

    Parameters
    ----------
    centre : array_like, shape (3,)
        Centre, metres.
    half_extents : array_like, shape (3,)
        Half the edge lengths, metres, > 0.
    orientation : array_like, shape (4,)
        Orientation of its axes: unit quaternion (w, x, y, z).
    link : str, optional
        Link to which the shape is fixed; by default the world. On a link, positions and orientations are in
        the axes of the section or body.
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
    """Uneven ground: the region below a smooth surface that interpolates heights on a rectangular grid.

    The surface is the natural cubic spline through the heights in both directions, so forces vary smoothly
    along it. It is extended linearly beyond the grid. Steps in the heights make the spline overshoot.

    Parameters
    ----------
    heights : array_like, shape (k, l)
        Heights along the z axis, metres: k >= 2 along the x axis, l >= 2 along the y axis.
    spacing : float or array_like, shape (2,)
        Distance between neighbouring heights, metres, > 0; give two numbers for different spacings along x
        and y.
    corner : array_like, shape (3,)
        Position of the first grid point, from which its height is measured, metres.
    orientation : array_like, shape (4,)
        Orientation of its axes: unit quaternion (w, x, y, z).
    link : str, optional
        Link to which the shape is fixed; by default the world. On a link, positions and orientations are in
        the axes of the section or body.
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
        in_floats_for_each(self, "spacing", 2)
        in_floats(self, "corner", "orientation")
        _in_rows(self, "heights", "rows of numbers")
        _place(self)


@dataclass(frozen=True)
class ConvexMesh:
    """A convex body with flat faces, rounded by a radius.

    Parameters
    ----------
    points : array_like, shape (k, 3)
        Corners, metres; 4 to 2000. Every corner belongs to a face.
    faces : array_like of int, shape (l, 3)
        Triangles, as indices into `points` (from 0) in any order. They must enclose the body.
    radius : float
        Rounding radius, metres, >= 0. The body grows by this radius on all sides.
    link : str, optional
        Link to which the shape is fixed; by default the world. On a link, positions and orientations are in
        the axes of the section or body.
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
    """A ball fixed to a link, such as a finger tip, a sliding wheel or the outline of a body.

    It has no mass; add a `Body` for that.

    Parameters
    ----------
    link : str
        Name of the link.
    radius : float
        Radius, metres, > 0.
    at : float, optional
        Arc length of the link's unstretched rod, metres; by default the tip, or the base of a rigid link.
    position : array_like, shape (3,)
        Centre of the ball in the axes of the section or body, metres.
    """

    link: str
    radius: float
    _: KW_ONLY
    at: float | None = None
    position: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        with_text(self, "link")
        in_floats(self, "position")
        with_number(self, "radius")
        _place(self)


@dataclass(frozen=True)
class Contact:
    """A pair of surfaces that can touch.

    Where the surfaces overlap by d, they press on each other with ``f = k d max(0, 1 + c d')`` (Hunt and
    Crossley 1975), in newtons per metre along a rod, or in newtons if neither surface is a rod. Friction is
    ``-mu f v / sqrt(|v|^2 + v_s^2)`` with the sliding velocity v. The page "Contact" of the documentation
    explains how these constants affect step sizes and accuracy.

    Parameters
    ----------
    a : str, Ball, HalfSpace, Sphere, Capsule, Box, HeightField or ConvexMesh
        The moving surface: a ball, a shape with a `link`, or the name of a link for the surface of its rod.
        The rod's sections are ellipses with its two half extents.
    b : str, Ball, HalfSpace, Sphere, Capsule, Box, HeightField or ConvexMesh
        The other surface, on another link or in the world. The name of the same link means self-contact of
        its rod; places closer than about three diameters along the rod are left out. If both surfaces are
        shapes, one of them must be a `Sphere`, `Capsule`, `Box` or `ConvexMesh`: these touch each other,
        half-spaces and height fields, with their corners, edges or ends.
    stiffness : float, optional
        Stiffness k. With a rod in N/m^2, per metre of overlap and per metre of rod; the default follows from
        the rods' material, ``pi/4 E / (1 - nu^2)`` (Popov 2010, eq. 5.33). Without a rod in N/m, and
        required; boxes, meshes and capsules have it at each corner, end and edge that touches.
    dissipation : float
        Dissipation c, s/m, >= 0. The rebound speed after a slow impact at the speed v is ``v (1 - 2 c v /
        3)``.
    friction : float or array_like, shape (3,)
        Coefficient of friction mu, >= 0. Three numbers are for a rod that slides forward along its axis,
        backward, and sideways.
    slip_velocity : float
        Velocity v_s, m/s, > 0. Sticking contacts creep at up to about this speed.
    patch_radius : float
        Radius r of the contact patch, metres, >= 0. Friction then also resists spinning, with the torque
        ``-mu f r w / sqrt(w^2 + (v_s/r)^2)``, where w is the angular velocity about the normal and mu the
        sideways coefficient. Zero means no such resistance.
    name : str, optional
        Name in messages and results. By default made of the surfaces, such as "rod on halfspace"; robots
        number equal default names: "rod on halfspace 2".

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
        in_floats_for_each(self, "friction", 3)
        with_text(self, "name")
        if not self.name:
            object.__setattr__(self, "name", self._default_name())
        check_contact(self)

    def _default_name(self) -> str:
        a, b = (
            surface
            if isinstance(surface, str)
            else getattr(surface, "link", None) or type(surface).__name__.lower()
            for surface in (self.a, self.b)
        )
        return f"{a} on {b}"


@dataclass(frozen=True)
class Touch:
    """A place where two surfaces touch. A contact along a rod consists of several.

    Attributes
    ----------
    contact : str
        Name of the contact.
    position : ndarray, shape (3,)
        Position on the first surface, metres; if that is a shape, on the rod or ball that touches it.
    normal : ndarray, shape (3,)
        Unit vector from the second surface to the first.
    force : ndarray, shape (3,)
        Force on the first surface, newtons, friction included.
    overlap : float
        Overlap, metres.
    sliding : ndarray, shape (3,)
        Velocity of the first surface relative to the second, along the surface, m/s.
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
