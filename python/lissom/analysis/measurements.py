"""Measured data for `fit`: motions, static shapes and natural frequencies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from reprlib import repr
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import finite_array
from ..common.arguments import is_by_name, number, sequence, suggesting

if TYPE_CHECKING:
    from ..common.arguments import InputRows, Inputs

Array = NDArray[np.float64]

#: What places are.
OF_PLACES = "arc lengths, links or pairs of them"


@suggesting
@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """Measured positions of points over time.

    Parameters
    ----------
    t : array_like, shape (k,)
        Increasing times, seconds, not before `t0` of `fit`.
    positions : array_like, shape (k, 3) or (k, places, 3)
        World positions of one or several points, metres.
    u : array_like, shape (steps, inputs) or (inputs,), or dicts, optional
        Inputs of the motion, or some of them by name, one row for each control step; by default the defaults
        of the inputs. Rows after the last time have no effect.
    control_step : float, optional
        For how long each row of `u` is held, seconds; by default the step `dt` of `fit`.
    q0, v0 : array_like, shape (n,), optional
        Initial state; by default that of `fit`.
    places : sequence, optional
        Measured points, as for `fit`; by default those of `fit`.
    noise : float, optional
        Standard deviation of the positions, metres.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.
    """

    # Pickles refer to the class by this module, whatever moves.
    __module__ = "lissom"

    t: ArrayLike
    positions: ArrayLike
    u: InputRows | None = None
    control_step: float | None = None
    q0: ArrayLike | None = field(default=None, kw_only=True)
    v0: ArrayLike | None = field(default=None, kw_only=True)
    places: Sequence[float | str | tuple[str, float]] | None = field(default=None, kw_only=True)
    noise: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        times, positions = _array("t", self.t), _array("positions", self.positions)
        if times.ndim != 1 or not len(times):
            raise ValueError(f"t: got shape {times.shape}, expected (k,) with at least one time")
        count = len(times)
        if positions.ndim not in (2, 3) or positions.shape[-1] != 3 or len(positions) != count:
            raise ValueError(
                f"positions: got shape {positions.shape}, expected ({count}, 3) or ({count}, places, 3)"
            )
        for name, part in (("t", times), ("positions", positions)):
            if not np.isfinite(part).all():
                raise ValueError(
                    f"{name}: got numbers that are not finite, expected finite ones (leave out what was not "
                    "seen)"
                )
        if (np.diff(times) <= 0).any():
            raise ValueError("t: got times that do not increase, expected each later than the one before")
        _set(self, t=times, positions=positions)
        for name in ("u", "q0", "v0"):
            given = getattr(self, name)
            if given is not None and not (name == "u" and is_by_name(given)):
                _set(self, **{name: finite_array(given, name)})
        if self.control_step is not None and not 0.0 < number("control_step", self.control_step) < np.inf:
            raise ValueError(f"control_step: got {self.control_step!r}, expected a number of seconds > 0")
        _check_places(self.places)
        check_noise(self.noise, "metres")


@suggesting
@dataclass(frozen=True, eq=False)
class StaticShapes:
    """Measured positions of points in one or more equilibria.

    Parameters
    ----------
    positions : array_like, shape (k, 3) or (k, places, 3)
        World positions of one or several points in each of k equilibria, metres.
    u : array_like, shape (k, m), or dicts, optional
        Inputs in each equilibrium, or some of them by name; by default the defaults of the inputs.
    places : sequence, optional
        Measured points, as for `fit`; by default those of `fit`.
    noise : float, optional
        Standard deviation of the positions, metres.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.
    """

    # Pickles refer to the class by this module, whatever moves.
    __module__ = "lissom"

    positions: ArrayLike
    u: InputRows | None = None
    places: Sequence[float | str | tuple[str, float]] | None = field(default=None, kw_only=True)
    noise: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        positions = finite_array(self.positions, "positions")
        if positions.ndim not in (2, 3) or positions.shape[-1] != 3 or not positions.size:
            raise ValueError(f"positions: got shape {positions.shape}, expected (k, 3) or (k, places, 3)")
        _set(self, positions=positions)
        if self.u is not None and not is_by_name(self.u):
            u = finite_array(self.u, "u")
            if u.ndim != 2 or len(u) != len(positions):
                raise ValueError(
                    f"u: got shape {u.shape}, expected ({len(positions)}, m): inputs of every shape"
                )
            _set(self, u=u)
        _check_places(self.places)
        check_noise(self.noise, "metres")


@suggesting
@dataclass(frozen=True, eq=False)
class NaturalFrequencies:
    """Measured natural frequencies about an equilibrium.

    Parameters
    ----------
    values : array_like, shape (k,)
        The lowest k natural frequencies in increasing order, hertz.
    u : array_like, shape (m,), or dict, optional
        Inputs, or some of them by name; by default their defaults.
    noise : float, optional
        Standard deviation of the frequencies, hertz.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.
    """

    # Pickles refer to the class by this module, whatever moves.
    __module__ = "lissom"

    values: ArrayLike
    u: Inputs | None = None
    noise: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        values = finite_array(self.values, "values")
        if values.ndim != 1 or not len(values):
            raise ValueError(f"values: got shape {values.shape}, expected (k,)")
        if values[0] <= 0 or (np.diff(values) <= 0).any():
            raise ValueError(f"values: got {repr(values.tolist())}, expected frequencies > 0 that increase")
        _set(self, values=values)
        if self.u is not None and not is_by_name(self.u):
            _set(self, u=finite_array(self.u, "u"))
        check_noise(self.noise, "hertz")


def check_noise(noise: Any, unit: str) -> None:
    """Raise ValueError unless a standard deviation is None or positive."""
    if noise is not None and not 0.0 < number("noise", noise) < np.inf:
        raise ValueError(f"noise: got {noise!r}, expected a number > 0 in {unit}")


def _check_places(places: Any) -> None:
    """Raise TypeError unless places are a sequence; which there are, the model says."""
    if places is not None:
        sequence("places", places, OF_PLACES)


def _array(name: str, values: Any) -> Array:
    """An array of numbers, which need not be finite yet."""
    try:
        return np.asarray(values, float)
    except (TypeError, ValueError, OverflowError) as error:
        raise TypeError(f"{name}: expected an array of numbers: {error}") from None


def _set(thing: Any, **values: Any) -> None:
    """Set attributes of a frozen dataclass."""
    for name, value in values.items():
        object.__setattr__(thing, name, value)
