"""Parameter identification from measured motions, static shapes and natural frequencies."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import AccuracyWarning, Robot, finite_array
from ..common.arguments import explaining, number, whole
from ..common.extras import missing
from .fitted import FitResult, FittedData
from .makers import ArgumentsOfFunction, NumbersOfModel
from .measurements import check_noise
from .parameters import START, names_of
from .predictions import Data, Defaults, Measured, OfMotion, measured_of
from .searches import Search

__all__ = ["FitResult", "FittedData", "fit"]

Array = NDArray[np.float64]


@explaining(parameters='guesses by name, such as {"segments[0].young_modulus": 1e6}')
def fit(
    model: Robot | Callable[..., Robot],
    data: Data | tuple[ArrayLike, ArrayLike] | Sequence[Data | tuple[ArrayLike, ArrayLike]],
    parameters: Mapping[str, float | tuple[float, float, float]],
    *,
    places: Sequence[float | str | tuple[str, float]] | None = None,
    t0: float = 0.0,
    q0: ArrayLike | None = None,
    v0: ArrayLike | None = None,
    dt: float = 1e-2,
    noise: float | None = None,
    confidence: float = 0.95,
    max_runs: int = 100,
    starts: int = 1,
    **options: Any,
) -> FitResult:
    """Fit model parameters to measured data by least squares; needs SciPy.

    Parameters
    ----------
    model : Rod, Robot or callable
        The measured model; or a function that returns it, whose arguments are the parameters, as for `sweep`.
    data : (t, positions), RecordedMotion, StaticShapes, NaturalFrequencies, or list of these
        A motion as increasing times, shape (k,), seconds, not before `t0`, and world positions, metres, shape
        (k, 3) for one point or (k, places, 3), or with inputs and start of its own as a `RecordedMotion`; or
        positions in equilibria; or the lowest natural frequencies about an equilibrium. A list has several
        recordings, also of several kinds, which are weighted by their `noise`.
    parameters : mapping of str to float or (lowest, guess, highest)
        Initial values by name, optionally with bounds. Names are those of `sensitivity`, such as
        'segments[0].young_modulus', or 'segments[*].young_modulus' for one value that all segments share;
        initial states are given coordinate by coordinate, such as 'q0[0]'. For a function its arguments.
    places : sequence, optional
        Measured points: arc lengths of the last link, names of links (their tips), or pairs (link, arc
        length). The last tip by default.
    t0, q0, v0 : optional
        Initial state, as for `simulate`; for equilibria `q0`, as for `statics`. A `RecordedMotion` may have
        its own.
    dt : float
        Step size of motions, seconds.
    noise : float, optional
        Standard deviation of the measured numbers, metres or hertz, if known; otherwise it is estimated from
        the residuals. Positions and frequencies together need a noise each, as their weights.
    confidence : float
        Coverage probability of the intervals.
    max_runs : int
        Maximum number of evaluations of the model for a search, and as many again for profiles.
    starts : int
        Number of searches: from the guess, and from points that fill the bounds (their logarithms where the
        lowest value is positive), the same in every call. The best result counts. Motions of lightly damped
        robots have local minima far from a good guess.
    **options
        As for `sensitivity`, among them the inputs `u` and `control_step` of a driven motion; for equilibria
        as for `equilibrium_sensitivity`. With both kinds of data `method` is that of motions. 'auto' chooses
        tolerances for the first values, for all runs; the message has the errors with the fitted ones.

    Returns
    -------
    FitResult
        `values`, `intervals`, `covariance`, `undetermined`, `data` with residuals, `model`. `print` it to
        read all of it.

    Notes
    -----
    An evaluation costs a run and its derivatives for each recording; see `sensitivity`. For a function the
    derivatives with respect to each argument take four models, but no further runs. The search is SciPy's
    trust-region method. It ends where the values are nearer to the best ones than a thousandth of their
    uncertainty (Bates and Watts 1981), or at tolerances of 1e-10.

    Trial values that the model rejects, or for which a run fails, get a very large residual, so that the
    search turns back; the message reports their number. With the initial values the run must succeed.

    Raises
    ------
    ValueError, TypeError
        Before the first run, if an argument is invalid, a name is unknown, bounds are reversed, or there are
        fewer measured numbers than parameters.
    KeyboardInterrupt
        After Ctrl-C; its attribute `result` is the FitResult of the best run until then, if one was complete,
        or that of the search if only profiles were left.
    LissomError
        If with the initial values a run fails or no equilibrium is found; the message lists the parameters.
    ImportError
        Without SciPy, the extra `fit`.

    Examples
    --------
    >>> import lissom
    >>> finger = lissom.Segment(0.3, 0.01, 3e5, 4e5, 1100, modes={"bend_y": 2}, retardation_time=0.02)
    >>> rod = lissom.Rod([finger])
    >>> run = lissom.simulate(rod, 0.5)
    >>> tips = [rod.pose(q)[:3, 3] for q in run.q[1:]]
    >>> found = lissom.fit(rod, (run.t[1:], tips), {"segments[0].young_modulus": (1e5, 5e5, 1e6)})
    >>> bool(abs(found.values[0] - 3e5) < 1)
    True
    """
    if missing("scipy"):
        raise ImportError("fit needs SciPy: pip install 'lissom[fit]'")
    if not isinstance(parameters, Mapping):
        raise TypeError(
            f"parameters: got {type(parameters).__name__}, expected a mapping of names to guesses, such as "
            '{"segments[0].young_modulus": 1e6}'
        )
    names = names_of(parameters)
    if callable(model) and not isinstance(model, Robot):
        make: NumbersOfModel | ArgumentsOfFunction = ArgumentsOfFunction(model)
    else:
        make = NumbersOfModel(model)
    bounds = _bounds(make, names, parameters)
    first = make.first(dict(zip(names, bounds[1].tolist(), strict=True)))
    _check(noise, confidence, max_runs, t0, dt)
    _check_starts(starts, names, bounds)
    measured = measured_of(first, data, Defaults(places, t0, dt, q0, v0, noise, options))
    _check_states(first, measured, names, v0)
    size = sum(each.numbers.size for each in measured)
    if size < len(names):
        raise ValueError(f"data: got {size} numbers, expected at least {len(names)}: one for each parameter")
    values = dict(zip(names, bounds[1].tolist(), strict=True))
    for recording in measured:
        if isinstance(recording, OfMotion):
            recording.choose(first, {name: value for name, value in values.items() if START.fullmatch(name)})
    search = Search(make, measured, names, confidence, bounds, max_runs, starts)
    found = search.best_fit()
    for each in dict.fromkeys((*search.unresolved, *search.coarse)):
        warnings.warn(each, AccuracyWarning, stacklevel=3)
    return found


def _check(noise: Any, confidence: Any, max_runs: Any, t0: Any, dt: Any) -> None:
    if not 0.0 < number("confidence", confidence) < 1.0:
        raise ValueError(f"confidence: got {confidence!r}, expected a number between 0 and 1")
    if whole("max_runs", max_runs) < 1:
        raise ValueError(f"max_runs: got {max_runs!r}, expected a whole number > 0")
    check_noise(noise, "metres or hertz")
    # Validate the options even if there is nothing to fit.
    for name, value in (("t0", t0), ("dt", dt)):
        if finite_array(value, name).ndim or (name == "dt" and value <= 0.0):
            raise ValueError(f"{name}: got {value!r}, expected a number of seconds" + " > 0" * (name == "dt"))


def _bounds(
    make: NumbersOfModel | ArgumentsOfFunction, names: Sequence[str], parameters: Mapping[str, Any]
) -> tuple[Array, Array, Array]:
    rows = []
    for name in names:
        given = parameters[name]
        row = (-np.inf, given, np.inf) if isinstance(given, Real) else given
        is_triple = isinstance(row, tuple | list | np.ndarray) and len(row) == 3
        if not is_triple or not all(isinstance(x, Real) for x in row):
            raise TypeError(
                f"parameters: {name!r} has {given!r}, expected a guess or (lowest, guess, highest)"
            )
        lowest, guess, highest = (float(x) for x in row)
        if not (lowest < highest):
            raise ValueError(
                f"parameters: {name!r} has bounds {lowest} and {highest}, expected the lower one first"
            )
        if not lowest <= guess <= highest or not np.isfinite(guess):
            raise ValueError(
                f"parameters: {name!r} has the guess {guess}, expected one in [{lowest}, {highest}]"
            )
        if not START.fullmatch(name):
            make.check(name)
        rows.append((lowest, guess, highest))
    lowest, guess, highest = np.array(rows, float).T
    return lowest, guess, highest


def _check_starts(starts: Any, names: Sequence[str], bounds: tuple[Array, Array, Array]) -> None:
    if whole("starts", starts) < 1:
        raise ValueError(f"starts: got {starts!r}, expected a whole number > 0")
    for name, lowest, highest in zip(names, bounds[0], bounds[2], strict=True):
        if starts > 1 and not np.isfinite([lowest, highest]).all():
            raise ValueError(
                f"starts: got {starts}, expected bounds within which to start: give {name!r} as "
                "(lowest, guess, highest)"
            )


def _check_states(model: Robot, measured: Sequence[Measured], names: Sequence[str], v0: Any) -> None:
    """Reject initial states of what has none, or of several motions."""
    motions = sum(isinstance(each, OfMotion) for each in measured)
    if v0 is not None and not motions:
        raise ValueError("v0: equilibria have no velocities: leave `v0` out")
    for name in names:
        start = START.fullmatch(name)
        if start is None:
            continue
        if start["index"] is None or int(start["index"]) >= model.n:
            raise ValueError(
                f"parameters: got {name!r}, expected a single coordinate such as '{start['which']}[0]'"
            )
        if motions != 1:
            why = (
                f"there are {motions} motions, each with its own start"
                if motions
                else "equilibria have no start"
            )
            raise ValueError(f"parameters: got {name!r}, expected numbers of the model: {why}")
