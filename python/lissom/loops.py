"""Closed loops: constraints between links beyond the tree of the robot.

These classes only hold data. They validate it when they are created; the compiled core does the computing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from math import isfinite
from typing import TYPE_CHECKING, cast

from ._lissom import Joint, check_loop
from .plain import in_floats, with_number, with_text

if TYPE_CHECKING:
    from typing import Any, TypeAlias

    Vector: TypeAlias = Sequence[float]
    #: Accepted forms of an end: the name of a link, None for the world, entries in order or by name.
    Place: TypeAlias = "LoopEnd | str | Sequence[object] | Mapping[str, object] | None"


@dataclass(frozen=True)
class LoopEnd:
    """A frame at one end of a loop.

    Parameters
    ----------
    link : str, optional
        Name of the link; by default the world.
    at : float, optional
        Arc length of the link's unstretched rod, metres; by default the tip, or the base of a rigid link.
    position : array_like, shape (3,)
        Position of the frame relative to the section or body, in its axes, or in the world; metres.
    orientation : array_like, shape (4,)
        Orientation of the frame relative to these axes: unit quaternion (w, x, y, z).
    """

    link: str | None = None
    at: float | None = None
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Vector = (1.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if self.link is not None:
            with_text(self, "link")
        in_floats(self, "position", "orientation")
        if self.at is not None:
            with_number(self, "at")


@dataclass(frozen=True)
class Distance:
    """A constant distance between two points: a massless rigid bar with ball joints.

    Parameters
    ----------
    length : float
        Distance, metres, > 0.
    """

    length: float

    def __post_init__(self) -> None:
        with_number(self, "length")
        _check_finite("length", self.length)


@dataclass(frozen=True)
class Gear:
    """A linear coupling: a coordinate of the robot is ``ratio`` times another one plus ``offset``.

    The ends of such a loop are names of coordinates (see `Robot.coordinates`). Joints can also mimic each
    other (`Mimic`), which costs less; a gear couples any two coordinates, and its force can be computed.

    Parameters
    ----------
    ratio : float
        Ratio of the coordinates, not zero.
    offset : float
        Offset, in the unit of the first coordinate.
    """

    ratio: float = 1.0
    _: KW_ONLY
    offset: float = 0.0

    def __post_init__(self) -> None:
        with_number(self, "ratio")
        with_number(self, "offset")
        _check_finite("ratio", self.ratio)
        _check_finite("offset", self.offset)


def _check_finite(name: str, value: float) -> None:
    if not isfinite(value):
        raise ValueError(f"{name}: got {value}, expected a finite number")


def _end(place: Place) -> LoopEnd:
    """Convert any accepted form of an end to a `LoopEnd`."""
    if isinstance(place, LoopEnd):
        return place
    if place is None or isinstance(place, str):
        return LoopEnd(place)
    if isinstance(place, Mapping):
        return LoopEnd(**cast("Mapping[str, Any]", place))
    return LoopEnd(*cast("Sequence[Any]", place))


@dataclass(frozen=True)
class Loop:
    """A joint that closes a loop, between two links or between a link and the world.

    Every step and every equilibrium satisfies the constraints of the loop to rounding. `Robot.loop_forces`
    returns the constraint forces.

    Parameters
    ----------
    a, b : LoopEnd, str, tuple, dict or None
        Ends of the loop: a `LoopEnd`; the name of a link, for its tip or base; a tuple ``(link, at, position,
        orientation)``, whose last entries may be left out; or None for the origin of the world. For a `Gear`,
        the names of two coordinates.
    kind : Joint, Distance or Gear
        Relative motion that the loop allows the frame of `b` in the frame of `a`: a joint without spring,
        damping or friction and not `Free`, a constant distance, or a gear.
    name : str, optional
        Name in messages. By default made of the ends, such as "hand to the world"; robots number equal
        default names: "hand to the world 2".

    Raises
    ------
    ValueError, TypeError
        If a value is invalid by itself; the robot checks that the links exist.

    Examples
    --------
    A four-bar linkage: a tree of three bars, whose last one is hinged to the world.

    >>> import lissom
    >>> hinge = lissom.Revolute((0, 1, 0))
    >>> body = lissom.Body(0.1, centre=(0.1, 0, 0), inertia=[[1e-5, 0, 0], [0, 4e-4, 0], [0, 0, 4e-4]])
    >>> def bar(name, parent=None):
    ...     offset = (0, 0, 0) if parent is None else (0.2, 0, 0)
    ...     return lissom.Link(name, parent=parent, position=offset, joint=hinge, body=body)
    >>> links = [bar("crank"), bar("coupler", "crank"), bar("rocker", "coupler")]
    >>> pin = lissom.Loop(("rocker", None, (0.2, 0, 0)), (None, None, (0.2, 0, 0)), hinge, name="ground pin")
    >>> robot = lissom.Robot(links, loops=[pin])
    >>> robot.constraints
    5
    """

    a: Place
    b: Place
    kind: Joint | Distance | Gear
    _: KW_ONLY
    name: str = ""

    def __post_init__(self) -> None:
        if isinstance(self.kind, Gear):
            for place in ("a", "b"):
                if not isinstance(getattr(self, place), str):
                    message = f"{place}: expected the name of a coordinate, as the kind is a Gear"
                    raise TypeError(f"{message}, got {type(getattr(self, place)).__name__}")
        else:
            ends = {}
            for place in ("a", "b"):
                try:
                    ends[place] = _end(getattr(self, place))
                except (TypeError, ValueError) as error:
                    expected = (
                        "a LoopEnd, the name of a link, None, (link, at, position, orientation) or a dict"
                    )
                    raise TypeError(f"{place}: expected {expected}; {error}") from None
                object.__setattr__(self, place, ends[place])
        with_text(self, "name")
        if not self.name:
            object.__setattr__(self, "name", self._default_name())
        check_loop(self)

    def _default_name(self) -> str:
        a, b = (end.link or "the world" if isinstance(end, LoopEnd) else str(end) for end in (self.a, self.b))
        return f"{a} to {b}"
