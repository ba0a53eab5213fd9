"""Measured data for `fit`: motions, static shapes and natural frequencies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from reprlib import repr
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import Robot, finite_array
from .equilibria import differentiated, equilibrium_sensitivity, numbers_of
from .sensitivities import sensitivity

Array = NDArray[np.float64]

#: Links and arc lengths of measured points.
Places = Sequence[tuple[str, float | None]]


@dataclass(frozen=True, eq=False)
class StaticShapes:
    """Measured positions of points in one or more equilibria.

    Parameters
    ----------
    positions : array_like, shape (k, 3) or (k, places, 3)
        World positions of one or several points in each of k equilibria, metres.
    u : array_like, shape (k, m), optional
        Inputs in each equilibrium; by default the defaults of the inputs.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.
    """

    # Pickles refer to the class by this module, whatever moves.
    __module__ = "lissom"

    positions: ArrayLike
    u: ArrayLike | None = None

    def __post_init__(self) -> None:
        positions = finite_array(self.positions, "positions")
        if positions.ndim not in (2, 3) or positions.shape[-1] != 3 or not positions.size:
            raise ValueError(f"positions: got shape {positions.shape}, expected (k, 3) or (k, places, 3)")
        object.__setattr__(self, "positions", positions)
        if self.u is not None:
            u = finite_array(self.u, "u")
            if u.ndim != 2 or len(u) != len(positions):
                raise ValueError(
                    f"u: got shape {u.shape}, expected ({len(positions)}, m): inputs of every shape"
                )
            object.__setattr__(self, "u", u)


@dataclass(frozen=True, eq=False)
class NaturalFrequencies:
    """Measured natural frequencies about an equilibrium.

    Parameters
    ----------
    values : array_like, shape (k,)
        The lowest k natural frequencies in increasing order, hertz.
    u : array_like, shape (m,), optional
        Inputs; by default their defaults.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.
    """

    # Pickles refer to the class by this module, whatever moves.
    __module__ = "lissom"

    values: ArrayLike
    u: ArrayLike | None = None

    def __post_init__(self) -> None:
        values = finite_array(self.values, "values")
        if values.ndim != 1 or not len(values):
            raise ValueError(f"values: got shape {values.shape}, expected (k,)")
        if values[0] <= 0 or (np.diff(values) <= 0).any():
            raise ValueError(f"values: got {repr(values.tolist())}, expected frequencies > 0 that increase")
        object.__setattr__(self, "values", values)
        if self.u is not None:
            object.__setattr__(self, "u", finite_array(self.u, "u"))


class Measured(Protocol):
    """Measured numbers, and the model's prediction of them."""

    #: The numbers, and their unit.
    numbers: Array
    unit: str

    def predicted(
        self, model: Robot, names: Sequence[str], start: Mapping[str, Array], options: Mapping[str, Any]
    ) -> tuple[Array, Array]:
        """Predicted numbers and their derivatives with respect to the parameters, shape (size, p)."""


@dataclass
class OfMotion:
    """Positions of places over time."""

    numbers: Array
    times: Array
    places: Places
    t0: float
    dt: float
    unit: str = "metres"

    def predicted(
        self, model: Robot, names: Sequence[str], start: Mapping[str, Array], options: Mapping[str, Any]
    ) -> tuple[Array, Array]:
        """See `Measured`."""
        given: dict[str, Any] = {"t0": self.t0, "dt": self.dt, **start, **options}
        run = sensitivity(model, self.times[-1], names, **given)
        found = [run.position(X, link=link, t=self.times) for link, X in self.places]
        positions, derivatives = (np.stack(part, 1) for part in zip(*found, strict=True))
        return positions, derivatives.reshape(self.numbers.size, len(names))


@dataclass
class OfShapes:
    """Positions of places in equilibria."""

    numbers: Array
    inputs: Sequence[Array | None]
    places: Places
    unit: str = "metres"
    #: Equilibria of the previous model, used as starting points for the next one.
    last: dict[int, Array] = field(default_factory=dict)

    def predicted(
        self, model: Robot, names: Sequence[str], start: Mapping[str, Array], options: Mapping[str, Any]
    ) -> tuple[Array, Array]:
        """See `Measured`."""
        found = []
        wanted = numbers_of(model, names)
        for row, u in enumerate(self.inputs):
            shape = differentiated(model, wanted, self.last.get(row, start.get("q0")), u=u, **options)
            self.last[row] = shape.q
            found += [shape.position(X, link=link) for link, X in self.places]
        positions, derivatives = (np.array(part) for part in zip(*found, strict=True))
        return positions.reshape(self.numbers.shape), derivatives.reshape(self.numbers.size, len(names))


@dataclass
class OfFrequencies:
    """Natural frequencies about an equilibrium."""

    numbers: Array
    inputs: Array | None
    unit: str = "hertz"
    last: Array | None = None

    def predicted(
        self, model: Robot, names: Sequence[str], start: Mapping[str, Array], options: Mapping[str, Any]
    ) -> tuple[Array, Array]:
        """See `Measured`."""
        q0 = start.get("q0") if self.last is None else self.last
        found = equilibrium_sensitivity(
            model, names, q0, frequencies=len(self.numbers), u=self.inputs, **options
        )
        self.last = found.q
        if np.isnan(found.dfrequencies).any():
            raise ValueError(
                f"data: the model has the frequencies {found.frequencies.round(6).tolist()} Hz, expected "
                "different ones: equal ones, as of a round rod in two directions, cannot be told apart"
            )
        return found.frequencies, found.dfrequencies
