"""Links and joints, the parts of a `Robot`.

These classes only hold data. They validate it when they are created; the compiled core does the computing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass, field, fields
from typing import TYPE_CHECKING

from ._lissom import check_joint, check_link, check_mimic

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import Any, Literal, TypeAlias

    from numpy.typing import ArrayLike

    from ._lissom import BaseMotion, Body, Harmonic, Segment

    Vector = Sequence[float]
    Number: TypeAlias = (
        float
        | tuple[ArrayLike, ArrayLike]
        | tuple[ArrayLike, ArrayLike, Literal["linear", "monotone", "cubic"]]
        | Harmonic
        | Callable[[float], Any]
    )


def _keep(instance: object) -> None:
    """Convert vectors to tuples of floats, so that equal objects compare equal."""
    for each in fields(instance):  # type: ignore[arg-type]
        value = getattr(instance, each.name)
        if each.name == "motion":
            if isinstance(value, tuple | list):
                columns = tuple(tuple(float(x) for x in column) for column in value[:2])
                table = (*columns, *value[2:])
                object.__setattr__(instance, each.name, table)
        elif hasattr(value, "__len__") and not isinstance(value, str) and each.name != "rod":
            object.__setattr__(instance, each.name, tuple(float(x) for x in value))


@dataclass(frozen=True)
class Joint:
    """Base class of all joints."""

    def __post_init__(self) -> None:
        check_joint(self)
        _keep(self)


@dataclass(frozen=True)
class Weld(Joint):
    """A rigid connection."""


@dataclass(frozen=True)
class Mimic:
    """A joint coordinate that follows another one, as in gears or coupled fingers.

    The coordinate is ``multiplier * other + offset``, as in URDF's `mimic`.

    Parameters
    ----------
    link : str
        Link whose joint is followed. That joint is revolute or prismatic, anywhere in the robot; it may
        itself mimic a third joint or have a prescribed motion.
    multiplier : float
        Ratio of this coordinate to the other one, in radians or metres per radian or metre.
    offset : float
        Value of this coordinate when the other one is zero, in radians or metres.

    Examples
    --------
    >>> import lissom
    >>> left = lissom.Link("left", body=lissom.Body(0.1), joint=lissom.Prismatic((0, 1, 0)))
    >>> opposite = lissom.Mimic("left", multiplier=-1.0)
    >>> right = lissom.Link(
    ...     "right", body=lissom.Body(0.1), joint=lissom.Prismatic((0, 1, 0), mimic=opposite)
    ... )
    >>> lissom.Robot([left, right]).coordinates
    ('left.displacement',)
    """

    link: str
    _: KW_ONLY
    multiplier: float = 1.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        check_mimic(self)


@dataclass(frozen=True)
class _WithForces(Joint):
    """A joint with one coordinate, which can have a spring, damping, friction, stops and an armature."""

    _: KW_ONLY
    stiffness: float = 0.0
    rest: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    friction_velocity: float = 1e-3
    limits: tuple[float, float] | None = None
    limit_stiffness: float = 0.0
    limit_dissipation: float = 0.0
    armature: float = 0.0
    motion: Number | None = field(default=None, hash=False)
    mimic: Mimic | None = None


@dataclass(frozen=True)
class Revolute(_WithForces):
    """A hinge: the link rotates about an axis. The coordinate `angle` is in radians.

    Parameters
    ----------
    axis : array_like, shape (3,)
        Direction of the axis in the joint frame. Its length does not matter.
    stiffness : float
        Stiffness of a spring on the coordinate, newton metres per radian.
    rest : float
        Angle at which the spring is unloaded, radians.
    damping : float
        Viscous damping, newton metre seconds per radian.
    friction : float
        Dry friction torque, newton metres. At the velocity v, the torque
        ``friction * v / sqrt(v**2 + friction_velocity**2)`` opposes the motion.
    friction_velocity : float
        Velocity below which dry friction is smoothed, radians per second. A sticking joint creeps more slowly
        than this.
    limits : (float, float), optional
        Lowest and highest angle, radians. Stiff springs act beyond them.
    limit_stiffness : float
        Stiffness of the stops, newton metres per radian; required with `limits`.
    limit_dissipation : float
        Dissipation of the stops, seconds per radian. At x beyond a limit the torque is
        ``limit_stiffness * x * max(0, 1 + limit_dissipation * dx/dt)`` (Hunt and Crossley 1975).
    armature : float
        Inertia added to this coordinate only, such as that of a geared rotor, kg m^2.
    motion : float, (times, values), (times, values, interpolation), Harmonic or callable, optional
        Prescribed angle, radians, as a function of time (`BaseMotion` lists the forms).
        The joint then adds no coordinate to the robot, and its drive does work on the robot.
    mimic : Mimic, optional
        Makes the angle follow that of another joint; the joint then adds no coordinate either. Spring,
        damping, limits and armature act on this joint's own motion.

    Raises
    ------
    ValueError, TypeError
        If parameters are invalid; the message lists all of them.
    """

    axis: Vector


@dataclass(frozen=True)
class Prismatic(_WithForces):
    """A slider: the link translates along an axis. The coordinate `displacement` is in metres.

    Parameters
    ----------
    axis : array_like, shape (3,)
        Direction of the axis in the joint frame. Its length does not matter.
    stiffness : float
        Stiffness of a spring on the coordinate, newtons per metre.
    rest : float
        Displacement at which the spring is unloaded, metres.
    damping : float
        Viscous damping, newton seconds per metre.
    friction : float
        Dry friction force, newtons. At the velocity v, the force
        ``friction * v / sqrt(v**2 + friction_velocity**2)`` opposes the motion.
    friction_velocity : float
        Velocity below which dry friction is smoothed, metres per second. A sticking joint creeps more slowly
        than this.
    limits : (float, float), optional
        Lowest and highest displacement, metres. Stiff springs act beyond them.
    limit_stiffness : float
        Stiffness of the stops, newtons per metre; required with `limits`.
    limit_dissipation : float
        Dissipation of the stops, seconds per metre. At x beyond a limit the force is
        ``limit_stiffness * x * max(0, 1 + limit_dissipation * dx/dt)`` (Hunt and Crossley 1975).
    armature : float
        Inertia added to this coordinate only, kilograms.
    motion : float, (times, values), (times, values, interpolation), Harmonic or callable, optional
        Prescribed displacement, metres, as a function of time (`BaseMotion` lists the
        forms). The joint then adds no coordinate to the robot, and its drive does work on the robot.
    mimic : Mimic, optional
        Makes the displacement follow that of another joint; the joint then adds no coordinate either. Spring,
        damping, limits and armature act on this joint's own motion.

    Raises
    ------
    ValueError, TypeError
        If parameters are invalid; the message lists all of them.
    """

    axis: Vector


@dataclass(frozen=True)
class Cylindrical(Joint):
    """A cylindrical joint: the link slides along an axis and rotates about it.

    The coordinates are `displacement`, in metres, and `angle`, in radians.

    Parameters
    ----------
    axis : array_like, shape (3,)
        Direction of the axis in the joint frame. Its length does not matter.
    """

    axis: Vector


@dataclass(frozen=True)
class Universal(Joint):
    """A universal joint: the link rotates about one axis, then about a second one that the first one carries.

    The coordinates `angle[0]` and `angle[1]` are in radians.

    Parameters
    ----------
    axis1, axis2 : array_like, shape (3,)
        Directions of the axes in the joint frame when both angles are zero. They must not be parallel; their
        lengths do not matter.
    """

    axis1: Vector
    axis2: Vector


@dataclass(frozen=True)
class Planar(Joint):
    """A planar joint: the link translates in a plane and rotates about its normal.

    The coordinates are `displacement[0]` and `displacement[1]`, in metres, and `angle`, in radians. The first
    displacement is along the x axis of the joint frame, projected onto the plane (along y if the normal is
    along x); the second one is along the cross product of the normal and that direction.

    Parameters
    ----------
    normal : array_like, shape (3,)
        Normal of the plane in the joint frame. Its length does not matter.
    """

    normal: Vector


@dataclass(frozen=True)
class Spherical(Joint):
    """A ball joint: the link rotates about a point.

    The coordinates `rotation_x`, `rotation_y`, `rotation_z` are the rotation vector in radians; results keep
    its length at most pi. Their velocities are its time derivatives, not the angular velocity.
    """


@dataclass(frozen=True)
class Free(Joint):
    """Six degrees of freedom: coordinates `x`, `y`, `z` (metres) and a rotation vector as in `Spherical`.

    Parameters
    ----------
    motion : BaseMotion, optional
        Prescribed motion of the base of the link, in the axes of the joint frame. The joint then adds no
        coordinate to the robot, and its drive does work on the robot.
    """

    _: KW_ONLY
    motion: BaseMotion | None = field(default=None, hash=False)


@dataclass(frozen=True)
class Link:
    """A joint followed by a rod, a rigid body, or a frame alone.

    `position` and `orientation` place the joint frame on the parent, in the axes of the section or body
    there. The joint moves the base of the link relative to that frame. A rod starts at the base, along its x
    axis.

    Parameters
    ----------
    name : str
        Name by which loads, child links and results refer to the link.
    rod : sequence of Segment, optional
        Segments of the rod, from base to tip.
    body : Body, optional
        Rigid body; its centre and inertia are in the axes of the link's base.
    joint : Joint
        Joint between the link and its parent; by default a rigid connection.
    parent : str, optional
        Link that carries this one; it must come earlier in the robot. By default the world.
    at : float, optional
        Arc length of the parent's rod at which the link is attached, metres; by default the tip. None if the
        parent is rigid.
    position : array_like, shape (3,)
        Position of the joint frame on the parent, metres.
    orientation : array_like, shape (4,)
        Orientation of the joint frame: unit quaternion (w, x, y, z) that maps its axes to those of the
        parent.

    Raises
    ------
    ValueError, TypeError
        If parameters are invalid; the message lists all of them. `Robot` checks that parent and place exist.

    Examples
    --------
    >>> import lissom
    >>> palm = lissom.Link("palm", body=lissom.Body(0.3), joint=lissom.Prismatic((0, 1, 0)))
    >>> soft = lissom.Segment(0.1, 8e-3, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 3})
    >>> finger = lissom.Link("finger", rod=[soft], parent="palm", position=(0.05, 0, 0))
    """

    name: str
    _: KW_ONLY
    rod: Sequence[Segment] | None = field(default=None, hash=False)
    body: Body | None = field(default=None, hash=False)
    joint: Joint = Weld()
    parent: str | None = None
    at: float | None = None
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Vector = (1.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if isinstance(self.rod, Iterable):
            # Iterators can be read only once.
            object.__setattr__(self, "rod", tuple(self.rod))
        check_link(self)
        _keep(self)
