"""Actuators: tendons, fluidic chambers, motors and active strains.

These classes only hold data. They validate it when they are created; the compiled core does the computing.
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
    """Convert sequences to tuples, so that equal objects compare equal."""
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
    """Convert a pair of numbers or sequences to tuples; return anything else unchanged."""
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
        The link; optional if the robot has only one.
    offset : pair (y, z)
        Offset from the rod's axis in the plane of the section, metres. It may lie outside the section, as
        with guide disks. Each of y and z is a number; two numbers, interpolated linearly between the ends of
        the part; or a table ``(stations, values)``, a callable or a `Profile` of the arc length of the link's
        rod.
    along : (float, float), optional
        Arc lengths of the unstretched rod between which the part runs, metres; by default the whole rod.

    Raises
    ------
    ValueError, TypeError
        If parameters are invalid; the message lists all of them. The robot checks whether they fit the link.
    """

    link: str | None = None
    offset: tuple[AlongRod, AlongRod] = field(default=(0.0, 0.0), hash=False)
    along: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        check_path(self)
        _keep(self)


@dataclass(frozen=True)
class Via:
    """A point that a tendon passes through. It runs straight from the previous part and to the next one.

    Parameters
    ----------
    link : str or None
        Link that carries the point. None means the world for a `Robot`, where the point does not move with
        the base, and the rod for a `Rod`.
    point : array_like, shape (3,)
        Position in the axes of the body, of the rod's section, or of the world, metres.
    at : float, optional
        Arc length of the rod's section, metres; by default the tip.

    Raises
    ------
    ValueError, TypeError
        If parameters are invalid; the message lists all of them. The robot checks whether they fit the link.
    """

    link: str | None
    point: Sequence[float]
    at: float | None = None

    def __post_init__(self) -> None:
        check_path(self)
        _keep(self)


@dataclass(frozen=True)
class _Actuator:
    """Base class of all actuators."""

    def __post_init__(self) -> None:
        check_actuator(self)
        _keep(self)


@dataclass(frozen=True)
class Tendon(_Actuator):
    """A cable that pulls along its path and cannot push.

    Give either `tension` or `length`. With `length` and `stiffness` the tendon is a spring that cannot push.
    With `length` alone it is inextensible: a one-sided constraint keeps its path no longer than `length`, and
    the tension is the multiplier.

    Parameters
    ----------
    name : str
        Name of the tendon.
    path : sequence of Along and Via
        Path from the actuated end to the fixed end. The tendon runs straight between parts that are not
        adjacent in the same rod.
    tension : float, (times, values), Harmonic, Input or callable, optional
        Tension, newtons. Negative values of functions, inputs and controllers mean a slack tendon; numbers,
        tables, defaults and oscillations below zero are rejected.
    length : float, (times, values), Harmonic, Input or callable, optional
        Length above which the tendon is taut, metres, >= 0. With `stiffness` the tension is
        ``max(0, stiffness * (path - length) + damping * rate of path)``.
    stiffness : float, optional
        Stiffness, newtons per metre. Without it the tendon is inextensible; it then has neither damping nor
        friction, and `simulate` takes every method except the Newmark family with adaptive steps.
        ``"radau"``, ``"auto"`` and the explicit methods end a step where the tendon becomes taut or slack,
        and a run where the length of a taut tendon jumps, as an `Input` does that is shortened.
    damping : float
        Damping, newton seconds per metre.
    friction : float
        Coefficient of friction. Where the tendon turns by an angle, the tension changes by
        ``exp(-friction * angle)``, as on a capstan: it decreases away from the actuated end while the tendon
        is pulled, and increases while it is released. This holds along embedded parts and at points between
        straight parts.
    friction_velocity : float
        Rate of change of the path length below which friction is smoothed, metres per second.
    sliding : float, (times, values), Harmonic, Input or callable, optional
        Direction of sliding: 1 as if pulled, -1 as if released, 0 for no friction; values outside [-1, 1] are
        clipped. By default the rate of change of the path length determines it; this rate is zero in statics,
        which then has no friction.

    Raises
    ------
    ValueError, TypeError
        If parameters are invalid; the message lists all of them.

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

    `area` is measured in the plane of the rod's section, so the volume is ``area`` times the integral of the
    middle line's axial slope, and the generalised forces of a pressure do not depend on the shape.

    Parameters
    ----------
    name : str
        Name of the chamber.
    path : sequence of Along
        Middle line of the chamber.
    area : float
        Area in the plane of the section, square metres.
    pressure : float, (times, values), Harmonic, Input or callable
        Gauge pressure, pascals.

    Raises
    ------
    ValueError, TypeError
        If parameters are invalid; the message lists all of them.

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

    Give either `torque`, or `position` and `gains`.

    Parameters
    ----------
    joint : str
        Name of a link whose joint has one coordinate, or name of a joint coordinate as listed in
        `Robot.coordinates`. Joints with `mimic` can have motors; spherical joints, free joints and joints
        with a prescribed motion cannot.
    torque : float, (times, values), Harmonic, Input or callable, optional
        Torque, newton metres, or force, newtons.
    position : float, (times, values), Harmonic, Input or callable, optional
        Set point, radians or metres. The motor applies
        ``gains[0] * (position - coordinate) - gains[1] * velocity``.
    gains : (float, float), optional
        Stiffness and damping of a motor with a set point.
    limits : (float, float), optional
        Lowest and highest torque or force. Saturation is smooth, over a thousandth of the range.
    name : str, optional
        Name of the motor; by default that of `joint`.

    Raises
    ------
    ValueError, TypeError
        If parameters are invalid; the message lists all of them.

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
            object.__setattr__(self, "name", self._default_name())

    def _default_name(self) -> str:
        return self.joint


@dataclass(frozen=True)
class ActiveStrain(_Actuator):
    """An actuated reference strain: a muscle, a shape-memory wire, a swimming gait.

    The stress depends on the strain minus the reference strain of the segments and minus ``amount * shape``.
    Two active strains make a travelling wave: ``sin(k X - w t)`` has the shapes ``sin(k X)`` and ``cos(k X)``
    with the amounts ``cos(w t)`` and ``-sin(w t)``.

    Parameters
    ----------
    link : str, optional
        The link; optional if the robot has only one.
    strain : str
        'torsion', 'bend_y', 'bend_z', 'stretch', 'shear_y' or 'shear_z'. The rod needs modes of this strain.
    shape : float, pair, table, Profile or callable
        Strain along the link's rod for an amount of one, in radians per metre or metres per metre: a number;
        two numbers, interpolated linearly from base to tip; or a table ``(stations, values)``, a callable or
        a `Profile` of the arc length.
    amount : float, (times, values), Harmonic, Input or callable
        Amplitude.
    name : str, optional
        Name of the actuator; by default made of the link and the strain.

    Raises
    ------
    ValueError, TypeError
        If parameters are invalid; the message lists all of them.

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
            object.__setattr__(self, "name", self._default_name())
        super().__post_init__()

    def _default_name(self) -> str:
        return self.strain if self.link is None else f"{self.link}.{self.strain}"
