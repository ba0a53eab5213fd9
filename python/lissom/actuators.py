"""Actuators: what moves a robot when it is told to.

Plain data: everything is checked where it is written, and computed in the core.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, field, fields
from typing import TYPE_CHECKING

import numpy as np

from ._lissom import check_actuator, check_path

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import TypeAlias

    from numpy.typing import ArrayLike

    from ._lissom import Harmonic, Input, Profile

    #: A number that may vary in time.
    Signal: TypeAlias = float | tuple[ArrayLike, ArrayLike] | Harmonic | Input | Callable[[float], float]
    #: A number that may vary along a rod.
    AlongRod: TypeAlias = (
        float | tuple[float, float] | tuple[ArrayLike, ArrayLike] | Profile | Callable[[float], float]
    )

#: Attributes that are vectors of plain numbers.
_VECTORS = ("along", "point", "gains", "limits")


def _keep(instance: object) -> None:
    """Makes tuples of sequences, so that what is equal compares equal."""
    for each in fields(instance):  # type: ignore[arg-type]
        value = getattr(instance, each.name)
        if each.name in _VECTORS and value is not None:
            object.__setattr__(instance, each.name, tuple(float(x) for x in value))
        elif each.name == "path":
            object.__setattr__(instance, each.name, tuple(value))
        elif each.name == "offset":
            object.__setattr__(instance, each.name, tuple(_plain(part) for part in value))
        elif isinstance(value, tuple | list):
            object.__setattr__(instance, each.name, _plain(value))


def _plain(value: object) -> object:
    """A pair of numbers or of sequences as tuples; all else as it is."""
    if isinstance(value, np.ndarray) and value.ndim == 1:
        return tuple(value.tolist())
    if isinstance(value, tuple | list):
        return tuple(_plain(part) for part in value)
    return value


@dataclass(frozen=True)
class Along:
    """A part of a path that is embedded in a rod.

    Parameters
    ----------
    link : str, optional
        The link; may be left out where there is one.
    offset : pair (y, z)
        Where it lies in the sections, from the rod's axis, metres; it may lie outside of them, as through the
        holes of disks. Each one a number; two numbers, from which
        it varies linearly between the ends of the part; a table ``(stations, values)``, a callable or a
        `Profile` of the arc length of the whole rod of the link.
    along : (float, float), optional
        Arc lengths of the unstretched rod between which it lies, metres; by default the whole of it.

    Raises
    ------
    ValueError, TypeError
        Naming every invalid parameter; the robot checks what must fit the link.
    """

    link: str | None = None
    offset: tuple[AlongRod, AlongRod] = field(default=(0.0, 0.0), hash=False)
    along: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        check_path(self)
        _keep(self)


@dataclass(frozen=True)
class Via:
    """A point through which a tendon runs, straight from the part before and to the part behind.

    Parameters
    ----------
    link : str or None
        The link that has the point; None is the world, where it stays when the base moves, and on a `Rod`
        the rod.
    point : array_like, shape (3,)
        In the axes of the body, of the section of a rod, or of the world, metres.
    at : float, optional
        Arc length of the section of a rod, metres; by default its tip.

    Raises
    ------
    ValueError, TypeError
        Naming every invalid parameter; the robot checks what must fit the link.
    """

    link: str | None
    point: Sequence[float]
    at: float | None = None

    def __post_init__(self) -> None:
        check_path(self)
        _keep(self)


@dataclass(frozen=True)
class _Actuator:
    """What all actuators have in common."""

    def __post_init__(self) -> None:
        check_actuator(self)
        _keep(self)


@dataclass(frozen=True)
class Tendon(_Actuator):
    """A cable that pulls along its path and cannot push.

    Give `tension`, or `length`. A tendon of given length has a `stiffness`, or else it does not stretch: its
    path is never longer than `length`, by the tension that this takes (a constraint, held by a multiplier).

    Parameters
    ----------
    name : str
        The name.
    path : sequence of Along and Via
        Its path, from the end where it is pulled to the one where it is fixed. Between parts that do not
        adjoin in the same rod it runs straight.
    tension : float, (times, values), Harmonic, Input or callable, optional
        Newtons. What a function, an input or a controller tells to be less than zero is slack; numbers,
        tables, defaults and oscillations below zero are refused.
    length : float, (times, values), Harmonic, Input or callable, optional
        The length above which the tendon is taut, metres, not negative. With `stiffness` its tension is
        ``max(0, stiffness * (path - length) + damping * rate of path)``.
    stiffness : float, optional
        Newtons per metre. Without it the tendon does not stretch; it then has neither damping nor friction,
        and motions take method ``"generalised_alpha"`` (the default) or ``"hht"``.
    damping : float
        Newton seconds per metre.
    friction : float
        Coefficient of friction along embedded parts: the tension falls by
        ``exp(-friction * angle)`` where the tendon turns by that angle, as on a capstan, away from the end
        where it is pulled, and grows while it is let out; at points between straight parts, too.
    friction_velocity : float
        Rate of the path's length below which friction is smoothed, metres per second.
    sliding : float, (times, values), Harmonic, Input or callable, optional
        The direction of sliding: 1 as while it is pulled, -1 as while it is let out, 0 without friction. By
        default the rate of its length tells; statics, where that is zero, then knows no friction. What an
        input, a table or a function tells beyond is held within [-1, 1].

    Raises
    ------
    ValueError, TypeError
        Naming every invalid parameter.

    Examples
    --------
    >>> import lissom
    >>> finger = lissom.Segment(0.2, 2e-3, 1e9, 4e8, 1200, {"bend_y": 2, "bend_z": 2})
    >>> pull = lissom.Tendon("pull", [lissom.Along(offset=(0, 0.01))], tension=lissom.Input("pull", 2.0))
    >>> robot = lissom.Rod([finger], actuators=[pull], gravity=(0, 0, 0))
    >>> robot.inputs
    ('pull',)
    >>> bent = lissom.statics(robot)
    >>> round(robot.actuator_length("pull", bent.q), 6)
    0.196817
    """

    name: str
    path: Sequence[Along | Via]
    _: KW_ONLY
    tension: Signal | None = field(default=None, hash=False)
    length: Signal | None = field(default=None, hash=False)
    stiffness: float | None = None
    damping: float = 0.0
    friction: float = 0.0
    friction_velocity: float = 1e-3
    sliding: Signal | None = field(default=None, hash=False)


@dataclass(frozen=True)
class Chamber(_Actuator):
    """A fluidic chamber along rods, with caps at its ends.

    Its area is that of its cut with the sections, so that its volume is ``area`` times the integral of its
    slope along the rod, and the generalised forces of a pressure do not depend on the shape.

    Parameters
    ----------
    name : str
        The name.
    path : sequence of Along
        Its middle line.
    area : float
        Square metres.
    pressure : float, (times, values), Harmonic, Input or callable
        Over that around, pascals.

    Raises
    ------
    ValueError, TypeError
        Naming every invalid parameter.

    Examples
    --------
    >>> import lissom
    >>> modes = {"bend_y": 1, "stretch": 1}
    >>> finger = lissom.Segment(0.1, 0.01, 1e6, poisson_ratio=0.5, density=1100, modes=modes)
    >>> chamber = lissom.Chamber("left", [lissom.Along(offset=(0, 0.005))], 2e-5, 1e4)
    >>> robot = lissom.Rod([finger], actuators=[chamber], gravity=(0, 0, 0))
    >>> round(robot.actuator_length("left", [0.0, 0.0]), 12)
    2e-06
    """

    name: str
    path: Sequence[Along]
    area: float
    pressure: Signal = field(default=0.0, hash=False)


@dataclass(frozen=True)
class Motor(_Actuator):
    """A motor on a joint: a torque about its axis, or a force along it.

    Give `torque`, or `position` with `gains`.

    Parameters
    ----------
    joint : str
        The name of a link whose joint has one coordinate, or of a coordinate of a joint as
        `Robot.coordinates` has them. Spherical and free joints have no motors, nor has one whose motion is
        prescribed; one that mimics another has.
    torque : float, (times, values), Harmonic, Input or callable, optional
        Newton metres, or newtons.
    position : float, (times, values), Harmonic, Input or callable, optional
        Radians or metres: the motor answers ``gains[0] * (position - coordinate) - gains[1] * velocity``.
    gains : (float, float), optional
        Stiffness and damping of a motor that holds a position.
    limits : (float, float), optional
        The lowest and the highest torque or force. It approaches them smoothly, within a thousandth of the
        range between them.
    name : str, optional
        The name; by default as `joint`.

    Raises
    ------
    ValueError, TypeError
        Naming every invalid parameter.

    Examples
    --------
    >>> import lissom
    >>> arm = lissom.Link("arm", body=lissom.Body(1.0, centre=(0.5, 0, 0)), joint=lissom.Revolute((0, 1, 0)))
    >>> robot = lissom.Robot([arm], actuators=[lissom.Motor("arm", position=0.3, gains=(50.0, 2.0))])
    >>> float(round(lissom.statics(robot).q[0], 6))
    0.390707
    """

    joint: str
    torque: Signal | None = field(default=None, hash=False)
    _: KW_ONLY
    position: Signal | None = field(default=None, hash=False)
    gains: tuple[float, float] | None = None
    limits: tuple[float, float] | None = None
    name: str | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.name is None:
            object.__setattr__(self, "name", self.joint)


@dataclass(frozen=True)
class ActiveStrain(_Actuator):
    """An actuated reference strain: a muscle, a shape-memory wire, a swimming gait.

    The stress depends on the strain minus ``amount * shape`` and minus the reference strain of the segments.
    A travelling wave is the sum of two: ``sin(k X - w t)`` has the shapes ``sin(k X)`` and ``cos(k X)`` with
    the amounts ``cos(w t)`` and ``-sin(w t)``.

    Parameters
    ----------
    link : str or None
        The link; may be None where there is one.
    strain : str
        'torsion', 'bend_y', 'bend_z', 'stretch', 'shear_y' or 'shear_z'; it needs modes to follow.
    shape : float, pair, table, Profile or callable
        Along the whole rod of the link, in radians per metre, or metres per metre, for an amount of one: a
        number; two numbers, linear from base to tip; a table ``(stations, values)``, a callable or a
        `Profile` of the arc length.
    amount : float, (times, values), Harmonic, Input or callable
        The amplitude.
    name : str, optional
        The name; by default the link and the strain.

    Raises
    ------
    ValueError, TypeError
        Naming every invalid parameter.

    Examples
    --------
    >>> import lissom
    >>> soft = lissom.Segment(0.1, 0.01, 1e6, poisson_ratio=0.5, density=1100, modes={"bend_y": 1})
    >>> muscle = lissom.ActiveStrain(None, "bend_y", 2.0, 1.5)
    >>> lissom.statics(lissom.Rod([soft], actuators=[muscle], gravity=(0, 0, 0))).q
    array([3.])
    """

    link: str | None
    strain: str
    shape: AlongRod = field(default=1.0, hash=False)
    amount: Signal = field(default=0.0, hash=False)
    _: KW_ONLY
    name: str | None = None

    def __post_init__(self) -> None:
        if self.name is None and isinstance(self.strain, str):
            name = self.strain if self.link is None else f"{self.link}.{self.strain}"
            object.__setattr__(self, "name", name)
        super().__post_init__()
