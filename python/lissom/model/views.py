"""Views of models for results, reports, advice and linear models, apart from the equations.

Each kind of model is described here once, as a `View`. Other modules use the view (links, frames, a sketch)
and never distinguish kinds of models. A new kind of model needs one new function here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial, singledispatch
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .._lissom import Body, Load, Model, Robot, Rod, Segment, SpringPendulum
from .visuals import Visual, checked

if TYPE_CHECKING:
    from .._lissom import Link as Joined
    from .glyphs import Glyphs

Array = NDArray[np.float64]

#: Kinds and units of strains in their order: torsion and bending are curvatures, the others ratios.
STRAINS = {
    "torsion": ("torsion", "rad/m"),
    "bend_y": ("bending about y", "rad/m"),
    "bend_z": ("bending about z", "rad/m"),
    "stretch": ("stretch", "1"),
    "shear_y": ("shear along y", "1"),
    "shear_z": ("shear along z", "1"),
}

#: Kinds and units of joint coordinates, by the beginnings of their names.
JOINTS = {
    "angle": ("joint angle", "rad"),
    "displacement": ("joint displacement", "m"),
    "rotation": ("rotation vector", "rad"),
    "x": ("position", "m"),
    "y": ("position", "m"),
    "z": ("position", "m"),
}

#: Least number of sections along each segment at which the centre line is saved and drawn.
SECTIONS_PER_SEGMENT = 24

#: Number of places along a segment at which its section is evaluated.
PLACES = 32

#: Windings of the drawn spring.
WINDINGS = 11


@dataclass(frozen=True)
class Coordinate:
    """Description of a generalised coordinate."""

    name: str
    unit: str
    #: The measured quantity; coordinates of the same kind share a plot.
    kind: str
    #: Segment and degree of the mode whose amplitude it is; no degree for other coordinates.
    segment: int = 0
    degree: int | None = None


@dataclass(frozen=True)
class Link:
    """A slender part of a model: a sequence of segments, and their poses."""

    name: str
    segments: Sequence[Segment]
    #: Length without load, metres.
    length: float
    #: Poses of sections as from `Rod.pose`, for coordinates, arc lengths X and a time.
    pose: Callable[[Array, Array, float | Array], Array]
    #: Strains (k, m, 6) of sections as from `Rod.strain`, for (k, n) coordinates and arc lengths (m,).
    strain: Callable[[Array, Array], Array] | None = None
    #: Velocities (k, 6) of a section, angular first, in world axes, for (k, n) coordinates and velocities, an
    #: arc length and (k,) times.
    velocity: Callable[[Array, Array, float, Array], Array] | None = None
    #: Moments and forces (k, m, 6) in sections as from `Rod.internal_wrench`, for (k, n) coordinates,
    #: velocities and accelerations, arc lengths (m,), (k,) times and (k, inputs) inputs.
    wrench: Callable[[Array, Array, Array, Array, Array, Array], Array] | None = None
    #: The part of it that the material exerts by its elasticity, for coordinates, arc lengths, times, inputs.
    elastic_wrench: Callable[[Array, Array, Array, Array], Array] | None = None
    #: Arc lengths at which loads, bodies and supports act: forces jump there.
    marks: Sequence[float] = ()
    #: Number of sections along each segment at which it is saved and drawn.
    per_segment: int = SECTIONS_PER_SEGMENT

    @cached_property
    def stations(self) -> Array:
        """Arc lengths of the sections at which the link is saved and drawn, shape (s,), metres."""
        ends = np.concatenate([[0.0], np.cumsum([segment.length for segment in self.segments])])
        inner = [np.linspace(a, b, self.per_segment, endpoint=False) for a, b in pairwise(ends)]
        # The sum of the lengths may differ from the link's length by rounding.
        return np.append(np.concatenate(inner), self.length)

    def half_extents(self) -> list[float]:
        """Half extents of the link along y and z, at places along each segment."""
        places = [i / PLACES for i in range(PLACES + 1)]
        return [size for part in self.segments for x in places for size in part.section.half_extents(x)]


@dataclass(frozen=True)
class Solid:
    """A rigid body, drawn as the ellipsoid of uniform density with the same mass and inertia."""

    name: str
    #: Semi-axes (3,), metres; zero if the size is unknown.
    semi_axes: Array
    #: Poses of shape (..., 4, 4) of centre and principal axes, for coordinates (..., n) and a time.
    pose: Callable[[Array, float | Array], Array]
    #: The link whose body it is; empty for bodies that are attached to links.
    link: str = ""


@dataclass(frozen=True)
class Carried:
    """A visual on its link."""

    visual: Visual
    #: Poses of shape (..., 4, 4) of the link's frame, for coordinates (..., n) and a time.
    pose: Callable[[Array, float | Array], Array]


@dataclass(frozen=True)
class Frame:
    """A frame of a model at which forces can act and motion is measured: a tip."""

    name: str
    #: Poses of shape (..., 4, 4), for coordinates (..., n) and a time.
    pose: Callable[[Array, float | Array], Array]
    #: Geometric Jacobian (6, n), angular first, in world axes, for coordinates (n,) and a time.
    jacobian: Callable[[Array, float], Array]
    #: The link whose end it is; None for a `Rod`.
    link: str | None = None
    #: For prescribed motions: the velocity (6,) that they alone cause, angular first, in world axes, for
    #: coordinates (n,) and a time.
    carried: Callable[[Array, float], Array] | None = None


@dataclass(frozen=True)
class Member:
    """A link of a robot with several links, with its own curves."""

    name: str
    #: Its tip, or the frame of its body.
    frame: Frame
    #: Slice of the coordinates of its joint and its rod.
    coordinates: slice
    #: Moment (N m) and force (N) that it receives through its joint, (k, 6), for (k, n) coordinates,
    #: velocities, accelerations, (k,) times and (k, m) inputs.
    wrench: Callable[[Array, Array, Array, Array, Array], Array]
    #: Description of the body that exerts them.
    carrier: str


@dataclass(frozen=True)
class Sketch:
    """Drawing of a planar model: a mass on a line from the origin, in the world's x and y."""

    #: Positions of the mass (m, 2), metres, for coordinates (m, n).
    mass: Callable[[Array], Array]
    #: Corners of the line (points, 2), metres, for coordinates (n,).
    line: Callable[[Array], Array]


@dataclass(frozen=True)
class View:
    """Everything about a model apart from its equations."""

    #: Short description of the model.
    title: str
    coordinates: Sequence[Coordinate]
    #: Description of the drawing.
    caption: str = ""
    #: Slender parts, drawn in space.
    links: Sequence[Link] = ()
    #: Rigid bodies, drawn in space.
    solids: Sequence[Solid] = ()
    #: Meshes that stand for links in drawings.
    visuals: Sequence[Carried] = ()
    #: The robot whose joints, loops, supports and surroundings are drawn in space, and its loads.
    glyphs_of: tuple[Robot, Sequence[Load]] | None = None
    #: Frames at which forces act and motions are measured.
    frames: Sequence[Frame] = ()
    #: The links of a model with several links.
    members: Sequence[Member] = ()
    #: Drawing of a model without links.
    sketch: Sketch | None = None
    #: Angular velocity (3,) of the base, rad/s in world axes, for a time; None if the base is fixed.
    carrier_velocity: Callable[[float], Array] | None = None
    #: The same model with these additional loads; None for a model that accepts no loads.
    with_loads: Callable[[Sequence[Load]], Model] | None = None
    #: Numbers of multiplications of the solvers' computations, by name.
    multiplications: Callable[[], Mapping[str, int] | None] = lambda: None

    #: Number of redundant constraints of closed loops, by the loops' names, for coordinates (n,).
    redundant: Callable[[Array], Mapping[str, int]] = lambda q: {}

    #: Names of the coordinates in linear models; None if they are numbered.
    signals: Sequence[str] | None = None
    #: Length in metres to which deflections are relative; by default that of all slender parts.
    reach: float | None = None

    @cached_property
    def glyphs(self) -> Glyphs:
        """Joints, loops, loads, supports and surroundings, drawn in space."""
        from .glyphs import Glyphs, glyphs

        return Glyphs() if self.glyphs_of is None else glyphs(*self.glyphs_of)

    @property
    def size(self) -> float:
        """Length in metres to which deflections are relative."""
        return sum(link.length for link in self.links) if self.reach is None else self.reach

    @property
    def is_spatial(self) -> bool:
        """Whether the model has parts to draw in space."""
        return bool(self.links or self.solids or self.visuals)


@singledispatch
def view(model: Model) -> View:
    """Return the view of a model; for an unknown kind it has numbered coordinates only."""
    return View(type(model).__name__, [Coordinate(f"q{i}", "", "coordinate") for i in range(model.n)])


def drawn(model: Model, visuals: Iterable[Visual] = ()) -> View:
    """The view of a model with visuals, which stand for the bodies of their links.

    Raises
    ------
    ValueError, TypeError
        If a visual is none, or names no link of the model.
    """
    seen = view(model)
    names = [link.name for link in model.links] if isinstance(model, Robot) else []
    carried = [Carried(each, partial(_pose_of_base, model, each.link)) for each in checked(visuals, names)]
    shown = {each.visual.link for each in carried}
    solids = [solid for solid in seen.solids if solid.link not in shown]
    return replace(seen, visuals=carried, solids=solids) if carried else seen


def _pose_of_base(model: Model, link: str, q: Array, t: float | Array) -> Array:
    """Poses of a rigid link, or of the first section of a rod."""
    assert isinstance(model, Robot), "visuals are on links"
    has_rod = next(each.rod is not None for each in model.links if each.name == link)
    return model.pose(q, 0.0 if has_rod else None, link=link, t=t)


def is_rod(model: Model) -> bool:
    """Whether the parts of a model are named as those of a rod in scenes, not as those of links."""
    return isinstance(model, Rod)


@view.register(Rod)
def of_rod(rod: Rod) -> View:
    """One link from the clamped base to the tip."""
    count = len(rod.segments)
    return View(
        f"Cosserat rod, {rod.length:.3g} m long, {count} segment{'s' if count > 1 else ''}",
        coordinates=[
            Coordinate(f"segment{i}.{strain}.{degree}", unit, kind, i, degree)
            for i, segment in enumerate(rod.segments)
            for strain, (kind, unit) in STRAINS.items()
            for degree in range(segment.modes.get(strain, 0))
        ],
        caption="The coloured body is the rod, from its clamped base (dark) to its tip (yellow)",
        links=[
            Link(
                "rod",
                rod.segments,
                rod.length,
                lambda q, X, t: rod.pose(q, X, t=t),
                lambda q, X: rod.strain(q, X),
                lambda q, v, X, t: rod.velocity(q, v, X, t=t),
                lambda q, v, a, X, t, u: rod.internal_wrench(q, v, a, X, t=t, u=u),
                partial(_elastic_wrench_along, rod, None),
                _marks(rod, None),
            )
        ],
        glyphs_of=(rod, [Load(force=rod.tip_force, moment=rod.tip_moment), *rod.loads]),
        frames=[
            Frame(
                "tip",
                lambda q, t: rod.pose(q, rod.length, t=t),
                lambda q, t: rod.jacobian(q, rod.length, t=t),
            )
        ],
        carrier_velocity=None if rod.base_motion is None else partial(_base_velocity, rod),
        with_loads=partial(_with_loads, rod),
        multiplications=lambda: rod.multiplications,
    )


def _base_velocity(rod: Rod, t: float) -> Array:
    rest = np.zeros(rod.n)
    return rod.velocity(rest, rest, 0.0, t=t)[:3]


def _with_loads(robot: Robot, loads: Sequence[Load]) -> Model:
    return replace(robot, loads=[*robot.loads, *loads])


@view.register(Robot)
def of_robot(robot: Robot) -> View:
    """All rods, all rigid bodies, and the tips of the links without children."""
    links = robot.links
    parents = {link.parent for link in links}
    return View(
        f"Robot of {len(links)} link{'s' if len(links) > 1 else ''}",
        coordinates=list(map(_coordinate_of_robot, robot.coordinates)),
        caption="Rods in colour, from base (dark) to tip (yellow); bodies as ellipsoids of their inertia",
        links=[
            Link(
                link.name,
                link.rod,
                _length(link.rod),
                partial(_pose_along, robot, link.name),
                partial(_strain_along, robot, link.name),
                partial(_velocity_along, robot, link.name),
                partial(_wrench_along, robot, link.name),
                partial(_elastic_wrench_along, robot, link.name),
                _marks(robot, link.name),
            )
            for link in links
            if link.rod is not None
        ],
        solids=[
            *(
                _solid(robot, link.name, link.name, None, link.body)
                for link in links
                if link.body is not None
            ),
            *(
                _solid(robot, f"body {i + 1}", body.link or links[0].name, body.at, body)
                for i, body in enumerate(robot.bodies)
            ),
        ],
        frames=[
            Frame(
                link.name,
                partial(_pose_of_tip, robot, link.name),
                partial(_jacobian_of_tip, robot, link.name),
                link.name,
                partial(_velocity_of_tip, robot, link.name) if _is_prescribed(robot) else None,
            )
            for link in links
            if link.name not in parents
        ],
        glyphs_of=(robot, robot.loads),
        members=[_member(robot, link) for link in links] if len(links) > 1 else (),
        signals=robot.coordinates,
        reach=_reach(robot),
        with_loads=partial(_with_loads, robot),
        multiplications=lambda: robot.multiplications,
        redundant=robot.redundant_constraints,
    )


def _member(robot: Robot, link: Joined) -> Member:
    """Views of a link."""

    def wrench(q: Array, v: Array, a: Array, t: Array, u: Array) -> Array:
        return robot.joint_wrench(q, v, a, link=link.name, t=t, u=u)

    frame = Frame(
        f"{'base' if link.rod is None else 'tip'} of {link.name}",
        partial(_pose_of_tip, robot, link.name),
        partial(_jacobian_of_tip, robot, link.name),
    )
    return Member(link.name, frame, robot.slice(link.name), wrench, link.parent or "the world")


def _coordinate_of_robot(name: str) -> Coordinate:
    """`left.bend_y[0]`, `left.segment[1].bend_y[0]`, `trunk.angle`."""
    of_link = name.rpartition(".")[2]
    base, _, number = of_link.partition("[")
    if base in STRAINS:
        kind, unit = STRAINS[base]
        segment = name.partition(".segment[")[2].partition("]")[0]
        return Coordinate(name, unit, kind, int(segment or 0), int(number.rstrip("]")))
    kind, unit = JOINTS[base.partition("_")[0]]
    return Coordinate(name, unit, kind)


def _length(segments: Sequence[Segment]) -> float:
    return sum(segment.length for segment in segments)


def _reach(robot: Robot) -> float:
    """Distance that the links reach when stretched out, metres."""
    reach: dict[str | None, float] = {None: 0.0}
    for link in robot.links:
        own = _length(link.rod) if link.rod is not None else 0.0
        if link.body is not None:
            own = float(np.linalg.norm(link.body.centre))
        offset = float(np.linalg.norm(link.position)) if link.parent is not None else 0.0
        reach[link.name] = reach[link.parent] + offset + own
    return max(reach.values()) or 1.0


def _pose_along(robot: Robot, link: str, q: Array, X: Array, t: float | Array) -> Array:
    return robot.pose(q, X, link=link, t=t)


def _strain_along(robot: Robot, link: str, q: Array, X: Array) -> Array:
    return robot.strain(q, X, link=link)


def _velocity_along(robot: Robot, link: str, q: Array, v: Array, X: float, t: Array) -> Array:
    return robot.velocity(q, v, X, link=link, t=t)


def _elastic_wrench_along(robot: Robot, link: str | None, q: Array, X: Array, t: Array, u: Array) -> Array:
    rest = np.zeros_like(q)
    return robot.internal_wrench(q, rest, rest, X, link=link, t=t, u=u, by="material")


def _marks(robot: Robot, link: str | None) -> list[float]:
    """Arc lengths of a link's rod at which loads, bodies and supports act."""
    places = [
        *((load.link, load.at) for load in robot.loads),
        *((body.link, body.at) for body in robot.bodies),
        *((support.link, support.at) for support in robot.supports),
    ]
    return sorted({float(at) for name, at in places if name in (link, None) and at is not None})


def _wrench_along(
    robot: Robot, link: str, q: Array, v: Array, a: Array, X: Array, t: Array, u: Array
) -> Array:
    return robot.internal_wrench(q, v, a, X, link=link, t=t, u=u)


def _pose_of_tip(robot: Robot, link: str, q: Array, t: float | Array) -> Array:
    return robot.pose(q, link=link, t=t)


def _jacobian_of_tip(robot: Robot, link: str, q: Array, t: float) -> Array:
    return robot.jacobian(q, link=link, t=t)


def _is_prescribed(robot: Robot) -> bool:
    of_joints = (getattr(link.joint, "motion", None) for link in robot.links)
    return robot.base_motion is not None or any(motion is not None for motion in of_joints)


def _velocity_of_tip(robot: Robot, link: str, q: Array, t: float) -> Array:
    return robot.velocity(q, np.zeros(robot.n), link=link, t=t)


def _solid(robot: Robot, name: str, link: str, at: float | None, body: Body) -> Solid:
    """The ellipsoid of a body: with uniform density its moments are m (b^2 + c^2) / 5 and so on."""
    moments, axes = np.linalg.eigh(np.asarray(body.inertia))
    local = np.eye(4)
    local[:3, :3], local[:3, 3] = axes * np.sign(np.linalg.det(axes)), body.centre
    squares = (moments.sum() / 2 - moments) * (5 / body.mass if body.mass else 0.0)
    return Solid(
        name,
        np.sqrt(np.maximum(squares, 0.0)),
        lambda q, t: robot.pose(q, at, link=link, t=t) @ local,
        link if at is None and name == link else "",
    )


@view.register(SpringPendulum)
def of_pendulum(pendulum: SpringPendulum) -> View:
    """A mass on a spring, in its plane."""
    return View(
        "Spring pendulum",
        coordinates=[Coordinate("angle", "rad", "angle"), Coordinate("elongation", "m", "elongation")],
        caption="The mass on its spring, with the path it takes",
        sketch=Sketch(partial(_masses, pendulum), partial(_spring, pendulum)),
    )


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
