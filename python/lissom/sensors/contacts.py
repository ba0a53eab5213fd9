"""Instruments of touch: contact forces and tactile strips."""

from __future__ import annotations

from dataclasses import dataclass, field
from reprlib import repr
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import finite_array
from ..common.arguments import suggesting, text
from .places import known
from .sensor import Sensor
from .states import States

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class OfContact(Sensor):
    """An instrument on a contact."""

    contact: str | None = None

    NEEDS: ClassVar[str] = "v"

    def _check(self) -> None:
        names = [contact.name for contact in self.robot.contacts]
        name = self.contact
        if name is None and len(names) == 1:
            (name,) = names
        if name is not None:
            name = text("contact", name)
        if name not in names:
            expected = ", ".join(map(repr, names)) or "none in this robot"
            raise ValueError(f"contact: got {repr(name)}, expected one of the contacts: {expected}")
        self._set("contact", name)

    def _place(self) -> str:
        return str(self.contact)


@suggesting
@dataclass(frozen=True, eq=False)
class ContactForce(OfContact):
    """Force of a contact on its first surface, friction included, in world axes, newtons.

    Parameters
    ----------
    robot : Robot
        Robot with the contact.
    contact : str, optional
        Name of the contact; optional if the robot has only one.
    name, noise, bias, rate, delay, seed
        Those of every `Sensor`.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.

    See Also
    --------
    Robot.contact_forces : the measured quantity.

    Examples
    --------
    >>> import lissom
    >>> from lissom import sensors
    >>> ball = lissom.Link("ball", joint=lissom.Free(), body=lissom.Body(0.1, inertia=(4e-6, 4e-6, 4e-6)))
    >>> floor = lissom.Contact(lissom.Ball("ball", 0.01), lissom.HalfSpace((0, 0, -0.01)), stiffness=981)
    >>> scales = sensors.ContactForce(lissom.Robot([ball], contacts=[floor]))
    >>> scales.measure(0, [0, 0, -1e-3, 0, 0, 0], [0] * 6)  # one millimetre deep
    array([0.   , 0.   , 0.981])
    """

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured quantities."""
        return tuple(f"{self.name}.{axis}" for axis in "xyz")

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return ("N",) * 3

    def _ideal(self, given: States) -> Array:
        state = (given.q, known(given.v))
        wrenches: Array = self.robot.contact_forces(*state, name=self.contact, t=given.t)
        return wrenches[:, 3:]


@suggesting
@dataclass(frozen=True, eq=False)
class Tactile(OfContact):
    """A tactile strip: the normal force between the surfaces of a contact, newtons.

    Friction is not included. Along a rod the strip can have several cells; each measures the force on its
    part.

    Parameters
    ----------
    robot : Robot
        Robot with the contact.
    contact : str, optional
        Name of the contact; optional if the robot has only one.
    cells : array_like, shape (m + 1,), optional
        Increasing arc lengths, metres, that bound the m cells on the contact's first surface, a rod. By
        default one cell covers everything.
    name, noise, bias, rate, delay, seed
        Those of every `Sensor`.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.

    See Also
    --------
    Robot.touches : the measured quantity, place by place.

    Notes
    -----
    The force along a rod is known at its quadrature nodes; cells shorter than the node spacing change in
    jumps.
    """

    cells: ArrayLike | None = None
    _edges: Array | None = field(init=False, repr=False)

    def _check(self) -> None:
        super()._check()
        self._set("_edges", None)
        if self.cells is None:
            return
        edges = finite_array(self.cells, "cells")
        if edges.ndim != 1 or len(edges) < 2 or (np.diff(edges) <= 0).any():
            raise ValueError(f"cells: got {repr(self.cells)}, expected two or more arc lengths that increase")
        names = [contact.name for contact in self.robot.contacts]
        first = self.robot.contacts[names.index(str(self.contact))].a
        if not isinstance(first, str):
            word = type(first).__name__.lower()
            raise ValueError(
                f"cells: got {len(edges) - 1}, expected None: {first.link!r} touches with a {word}, not a rod"
            )
        self._set("cells", tuple(edges.tolist()))
        self._set("_edges", edges)

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured quantities."""
        if self._edges is None:
            return (self.name,)
        return tuple(f"{self.name}[{i}]" for i in range(len(self._edges) - 1))

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return ("N",) * len(self.channels)

    def _ideal(self, given: States) -> Array:
        pressed = np.zeros((len(given.t), len(self.channels)))
        for row, (t, q, v) in enumerate(zip(given.t, given.q, known(given.v), strict=True)):
            for touch in self.robot.touches(q, v, t=t):
                if touch.contact == self.contact:
                    self._add(pressed[row], touch.along[0], float(touch.normal @ touch.force))
        return pressed

    def _add(self, cells: Array, along: float | None, force: float) -> None:
        if self._edges is None:
            cells[0] += force
        elif along is not None:
            cell = int(np.searchsorted(self._edges, along, side="right")) - 1
            # The last cell includes its upper end.
            if along == self._edges[-1]:
                cell -= 1
            if 0 <= cell < len(cells):
                cells[cell] += force
