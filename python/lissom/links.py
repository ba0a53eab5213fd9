"""Links and the joints between them: what a `Robot` is made of.

Plain data: everything is checked where it is written, and computed in the core.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass, field, fields
from typing import TYPE_CHECKING

from ._lissom import check_joint, check_link, check_mimic

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import Any, TypeAlias

    from numpy.typing import ArrayLike

    from ._lissom import BaseMotion, Body, Harmonic, Segment

    Vector = Sequence[float]
    Number: TypeAlias = float | tuple[ArrayLike, ArrayLike] | Harmonic | Callable[[float], Any]


def _keep(instance: object) -> None:
    """Makes tuples of floats of all vectors, so that what is equal compares equal."""
    for each in fields(instance):  # type: ignore[arg-type]
        value = getattr(instance, each.name)
        if each.name == "motion":
            if isinstance(value, tuple | list):
                table = tuple(tuple(float(x) for x in column) for column in value)
                object.__setattr__(instance, each.name, table)
        elif hasattr(value, "__len__") and not isinstance(value, str) and each.name != "rod":
            object.__setattr__(instance, each.name, tuple(float(x) for x in value))


@dataclass(frozen=True)
class Joint:
    """How a link moves on its parent: the base class of all joints."""

    def __post_init__(self) -> None:
        check_joint(self)
        _keep(self)


@dataclass(frozen=True)
class Weld(Joint):
    """No motion at all."""


@dataclass(frozen=True)
class Mimic:
    """What ties the coordinate of a joint to that of another one: gears, fingers that close together.

    The coordinate is ``multiplier * other + offset``, as of URDF's `mimic`.

    Parameters
    ----------
    link : str
        The link with the other joint, which is a revolute or prismatic one, anywhere in the robot. That may
        mimic a third one itself, or move as prescribed.
    multiplier : float
        Radians or metres for each radian or metre of the other one.
    offset : float
        In radians or metres.

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
    """A joint of one coordinate, on which something may act."""

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
    """A hinge: the link turns about an axis. Its coordinate `angle` is in radians.

    Parameters
    ----------
    axis : array_like, shape (3,)
        Its direction in the joint's frame, of any length.
    stiffness : float
        Of a spring on the coordinate, newton metres per radian.
    rest : float
        Where that spring is free of force, radians.
    damping : float
        Viscous, newton metre seconds.
    friction : float
        Dry friction, newton metres: ``friction * v / sqrt(v**2 + friction_velocity**2)`` against the
        velocity v.
    friction_velocity : float
        Below it dry friction is smoothed, radians per second: what sticks creeps at less than this.
    limits : (float, float), optional
        Stops: stiff springs beyond these angles, radians.
    limit_stiffness : float
        Of the stops, newton metres per radian; needed where there are limits.
    limit_dissipation : float
        Of the stops, seconds per radian: beyond a limit by x they answer
        ``limit_stiffness * x * max(0, 1 + limit_dissipation * dx/dt)`` (Hunt and Crossley 1975).
    armature : float
        Inertia of what turns with the coordinate alone, such as a rotor behind a gear, kg m^2.
    motion : float, (times, values), Harmonic or callable, optional
        Prescribes the angle, radians, as a function of time with two derivatives (`BaseMotion` has the
        forms): the joint then adds no coordinate to the robot, and what moves it does work on the robot.
    mimic : Mimic, optional
        Ties the angle to that of another joint: it then adds no coordinate either. Spring, dampers,
        limits and armature act on the joint's own motion.

    Raises
    ------
    ValueError, TypeError
        Naming every invalid parameter.
    """

    axis: Vector


@dataclass(frozen=True)
class Prismatic(_WithForces):
    """A slider: the link moves along an axis. Its coordinate `displacement` is in metres.

    Parameters
    ----------
    axis : array_like, shape (3,)
        Its direction in the joint's frame, of any length.
    stiffness : float
        Of a spring on the coordinate, newtons per metre.
    rest : float
        Where that spring is free of force, metres.
    damping : float
        Viscous, newton seconds per metre.
    friction : float
        Dry friction, newtons: ``friction * v / sqrt(v**2 + friction_velocity**2)`` against the velocity v.
    friction_velocity : float
        Below it dry friction is smoothed, metres per second: what sticks creeps at less than this.
    limits : (float, float), optional
        Stops: stiff springs beyond these displacements, metres.
    limit_stiffness : float
        Of the stops, newtons per metre; needed where there are limits.
    limit_dissipation : float
        Of the stops, seconds per metre: beyond a limit by x they answer
        ``limit_stiffness * x * max(0, 1 + limit_dissipation * dx/dt)`` (Hunt and Crossley 1975).
    armature : float
        Inertia of what moves with the coordinate alone, kilograms.
    motion : float, (times, values), Harmonic or callable, optional
        Prescribes the displacement, metres, as a function of time with two derivatives (`BaseMotion` has the
        forms): the joint then adds no coordinate to the robot, and what moves it does work on the robot.
    mimic : Mimic, optional
        Ties the displacement to that of another joint: it then adds no coordinate either. Spring, dampers,
        limits and armature act on the joint's own motion.

    Raises
    ------
    ValueError, TypeError
        Naming every invalid parameter.
    """

    axis: Vector


@dataclass(frozen=True)
class Cylindrical(Joint):
    """The link slides along an axis and turns about it.

    Its coordinates are `displacement`, in metres, and `angle`, in radians.

    Parameters
    ----------
    axis : array_like, shape (3,)
        Its direction in the joint's frame, of any length.
    """

    axis: Vector


@dataclass(frozen=True)
class Universal(Joint):
    """A cross: the link turns about one axis, then about a second one that the first one turns.

    Its coordinates `angle[0]` and `angle[1]` are in radians.

    Parameters
    ----------
    axis1, axis2 : array_like, shape (3,)
        Their directions in the joint's frame where both angles are zero, of any length, not parallel.
    """

    axis1: Vector
    axis2: Vector


@dataclass(frozen=True)
class Planar(Joint):
    """The link moves across a normal and turns about it.

    Its coordinates are `displacement[0]` along the x axis of the joint's frame less its part along the normal
    (along y, where the normal is along x), `displacement[1]` along the normal times that direction, both in
    metres, and `angle` in radians.

    Parameters
    ----------
    normal : array_like, shape (3,)
        Its direction in the joint's frame, of any length.
    """

    normal: Vector


@dataclass(frozen=True)
class Spherical(Joint):
    """A ball: the link turns about a point.

    Its coordinates `rotation_x`, `rotation_y`, `rotation_z` are the rotation vector in radians; results keep
    its length up to pi. Their velocities are its derivatives, not the angular velocity.
    """


@dataclass(frozen=True)
class Free(Joint):
    """No connection: coordinates `x`, `y`, `z` (metres) and a rotation vector as that of `Spherical`.

    Parameters
    ----------
    motion : BaseMotion, optional
        Prescribes where the base of the link is, in the axes of the joint's frame, as a function of time: the
        joint then adds no coordinate to the robot, and what moves it does work on the robot.
    """

    _: KW_ONLY
    motion: BaseMotion | None = field(default=None, hash=False)


@dataclass(frozen=True)
class Link:
    """A joint followed by a rod, a rigid body, or nothing but a frame.

    The joint's frame lies on the parent at `position` with `orientation`, in the axes of the section or body
    there; the joint moves the base of the link in that frame. A rod leaves its base along the base's x axis.

    Parameters
    ----------
    name : str
        What loads, children and results call it.
    rod : sequence of Segment, optional
        From base to tip.
    body : Body, optional
        Its centre and inertia are in the axes of the link's base.
    joint : Joint
        How it moves on its parent; by default not at all.
    parent : str, optional
        The link that carries it, which stands before it in the robot; by default the world.
    at : float, optional
        Arc length of the parent's rod where it is attached, metres; by default the tip. None where the parent
        is rigid.
    position : array_like, shape (3,)
        Of the joint's frame on the parent, metres.
    orientation : array_like, shape (4,)
        Of the joint's frame: unit quaternion (w, x, y, z) that turns its axes into those of the parent.

    Raises
    ------
    ValueError, TypeError
        Naming every invalid parameter; the `Robot` checks whether parent and place exist.

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
            # What can be read but once is kept.
            object.__setattr__(self, "rod", tuple(self.rod))
        check_link(self)
        _keep(self)
