"""Parameter identification from measured motions, static shapes and natural frequencies."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import LissomError, Robot, finite_array
from ..common.arguments import number, sequence, whole
from ..common.extras import missing
from ..model import paths
from .base import ParameterResult
from .measurements import (
    Measured,
    NaturalFrequencies,
    OfFrequencies,
    OfMotion,
    OfShapes,
    Places,
    StaticShapes,
)
from .parameters import START, OfArgument, check_shared, model_with, names_of
from .profiles import OutOfRuns, Profile, on_scale

Array = NDArray[np.float64]

#: The data do not determine directions whose singular value of the scaled Jacobian is below this fraction of
#: the largest.
RANK = 1e-8

#: Where the search ends: relative changes of the sum of squares and of the values, and the gradient.
FTOL, XTOL, GTOL = 1e-10, 1e-10, 1e-14

#: What the statuses of SciPy's `least_squares` mean.
MESSAGES = (
    "Not converged: {runs} runs (max_runs) did not suffice; a better guess or more of them may.",
    f"Converged: the gradient of the cost is below gtol = {GTOL:g}.",
    f"Converged: the change of the cost is below ftol = {FTOL:g} of the cost.",
    f"Converged: the change of the parameters is below xtol = {XTOL:g} of them.",
    f"Converged: the changes of cost and parameters are below ftol = {FTOL:g} and xtol = {XTOL:g} of them.",
)

#: A parameter counts as undetermined if its component of an undetermined direction is at least this large.
PART = 0.1


@dataclass(frozen=True, eq=False, repr=False)
class FitResult(ParameterResult):
    """Best-fit parameters, and how well the data determine them.

    It can be copied, pickled and saved; `report(path)` writes a page with values, intervals, correlations and
    residuals, `plot()` draws the measurements and the fitted model, `to_xarray()` returns a dataset.

    Attributes
    ----------
    names : tuple of str
        Names of the p parameters.
    values : ndarray, shape (p,)
        Their values.
    model : Robot
        The model with these values. Fitted initial states are not part of it.
    covariance : ndarray, shape (p, p)
        Covariance of the values, from the Jacobian at the solution and the noise. For undetermined parameters
        the diagonal is infinite and the rest of the row and column NaN.
    intervals : ndarray, shape (p, 2)
        Confidence intervals from Student's t distribution, exact if the model is linear in the parameters and
        the noise is normal and independent. Those of parameters whose lower bound is not negative are
        intervals of their logarithms if half the width is not more than the value. Where an interval leaves
        the bounds, or the value is at one, the profile of the likelihood gives both ends, or the bound is an
        end.
    undetermined : tuple of str
        Parameters that the data do not determine, alone or together.
    residuals : ndarray, shape (k, places, 3) or (k,)
        Model minus data: positions in metres, or frequencies in hertz.
    noise : float
        Standard deviation of the residuals, in their unit: the given one, or an estimate with as many degrees
        of freedom as measured numbers minus parameters.
    runs : int
        Number of evaluations of the model with derivatives.
    success : bool
        Whether the solver converged.
    message : str
        Reason for termination, the parameters that the data do not determine, those at a bound, and the
        number of failed trial runs.
    at_bounds : tuple of str
        Parameters that ended at a bound, which is one end of their intervals.
    confidence : float
        Coverage probability of the intervals.
    measured : ndarray, shape as of the residuals
        The measurements.
    t : ndarray, shape (k,), or None
        The times of a motion, seconds.
    places : tuple of str
        Where positions were measured: link and arc length in metres; empty for frequencies.
    """

    # Pickles refer to the class by this module, where it has its methods.
    __module__ = "lissom"

    names: tuple[str, ...]
    values: Array
    model: Robot
    covariance: Array
    intervals: Array
    undetermined: tuple[str, ...]
    residuals: Array
    noise: float
    runs: int
    success: bool
    message: str
    at_bounds: tuple[str, ...]
    confidence: float
    measured: Array
    t: Array | None
    places: tuple[str, ...]

    def __repr__(self) -> str:
        values = ", ".join(
            f"{name} = {value:.6g}" for name, value in zip(self.names, self.values, strict=True)
        )
        outcome = "converged" if self.success else "not converged"
        return f"<FitResult: {outcome}, {values}, {self.runs} runs>"


def fit(
    model: Robot | Callable[..., Robot],
    data: tuple[ArrayLike, ArrayLike] | StaticShapes | NaturalFrequencies,
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
    **options: Any,
) -> FitResult:
    """Fit model parameters to measured data by least squares; needs SciPy.

    Parameters
    ----------
    model : Rod, Robot or callable
        The measured model; or a function that returns it, whose arguments are the parameters, as for `sweep`.
    data : (t, positions), StaticShapes or NaturalFrequencies
        A motion as increasing times, shape (k,), seconds, not before `t0`, and world positions, metres, shape
        (k, 3) for one point or (k, places, 3); or positions in equilibria; or the lowest natural frequencies
        about an equilibrium.
    parameters : mapping of str to float or (lowest, guess, highest)
        Initial values by name, optionally with bounds. Names are those of `sensitivity`, such as
        'segments[0].young_modulus', or 'segments[*].young_modulus' for one value that all segments share;
        initial states are given coordinate by coordinate, such as 'q0[0]'. For a function its arguments.
    places : sequence, optional
        Measured points: arc lengths of the last link, names of links (their tips), or pairs (link, arc
        length). The last tip by default.
    t0, q0, v0 : optional
        Initial state, as for `simulate`; for equilibria `q0`, as for `statics`.
    dt : float
        Step size of motions, seconds.
    noise : float, optional
        Standard deviation of the measured numbers, metres or hertz, if known; otherwise it is estimated from
        the residuals.
    confidence : float
        Coverage probability of the intervals.
    max_runs : int
        Maximum number of evaluations of the model for the search, and as many again for profiles.
    **options
        As for `sensitivity`, among them the inputs `u` and `control_step` of a driven motion; for equilibria
        as for `equilibrium_sensitivity`.

    Returns
    -------
    FitResult
        `values`, `intervals`, `covariance`, `undetermined`, `residuals`, `model`.

    Notes
    -----
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
            f"parameters: got {type(parameters).__name__}, expected a mapping of names to guesses"
        )
    names = names_of(parameters)
    make = _OfFunction(model) if callable(model) and not isinstance(model, Robot) else _OfModel(model)
    bounds = _bounds(make, names, parameters)
    model = make.first(dict(zip(names, bounds[1].tolist(), strict=True)))
    _check(model, noise, confidence, max_runs, t0, dt)
    measured = _measured(model, data, places, t0, dt)
    if v0 is not None and not isinstance(measured, OfMotion):
        raise ValueError("v0: expected None: equilibria have no velocities")
    _check_starts(model, names)
    for name in names:
        if START.fullmatch(name) and not isinstance(measured, OfMotion):
            raise ValueError(
                f"parameters: got {name!r}, expected numbers of the model: equilibria have no start"
            )
    size = measured.numbers.size
    if size < len(names):
        raise ValueError(f"data: got {size} numbers, expected at least {len(names)}: one for each parameter")
    start = {}
    if isinstance(measured, OfMotion) or q0 is not None:
        start["q0"] = _state(q0, model.n, "q0")
    if isinstance(measured, OfMotion):
        start["v0"] = _state(v0, model.n, "v0")
    return _Search(make, measured, names, start, options, noise, confidence, bounds, max_runs).best_fit()


def _check(model: Robot, noise: Any, confidence: Any, max_runs: Any, t0: Any, dt: Any) -> None:
    if not 0.0 < number("confidence", confidence) < 1.0:
        raise ValueError(f"confidence: got {confidence!r}, expected a number between 0 and 1")
    if whole("max_runs", max_runs) < 1:
        raise ValueError(f"max_runs: got {max_runs!r}, expected a whole number > 0")
    if noise is not None and not 0.0 < number("noise", noise) < np.inf:
        raise ValueError(f"noise: got {noise!r}, expected a number > 0 in metres or hertz")
    # Validate the options even if there is nothing to fit.
    for name, value in (("t0", t0), ("dt", dt)):
        if finite_array(value, name).ndim or (name == "dt" and value <= 0.0):
            raise ValueError(f"{name}: got {value!r}, expected a number of seconds" + " > 0" * (name == "dt"))


@dataclass(frozen=True)
class _OfModel:
    """A model whose numbers are fitted."""

    model: Any

    def __call__(self, values: Mapping[str, float]) -> Robot:
        """The model with these values, apart from initial states."""
        changed: Robot = model_with(self.model, _of_model(values))
        return changed

    def first(self, values: Mapping[str, float]) -> Robot:
        """A model whose coordinates and places are those of all."""
        return self._checked()

    def check(self, name: str) -> None:
        """Raise ValueError unless there is a number with this name."""
        check_shared(self._checked(), name)

    def wanted(self, model: Robot, values: Mapping[str, float]) -> list[Any]:
        """The parameters of the derivatives, for the model with these values."""
        return list(values)

    def _checked(self) -> Robot:
        return _robot(self.model, "model: expected a Rod or a Robot, or a function that makes one, got")


@dataclass(frozen=True)
class _OfFunction:
    """A function that makes a model, whose arguments are fitted."""

    build: Callable[..., Any]

    def __call__(self, values: Mapping[str, float]) -> Robot:
        """The model with these values, apart from initial states."""
        return _robot(
            self.build(**_of_model(values)), "model: expected a function that makes a Rod or a Robot, got"
        )

    def first(self, values: Mapping[str, float]) -> Robot:
        """A model whose coordinates and places are those of all."""
        return self(values)

    def check(self, name: str) -> None:
        """Raise ValueError unless the function has this argument."""
        known = inspect.signature(self.build).parameters
        if name not in known and not any(each.kind is each.VAR_KEYWORD for each in known.values()):
            raise ValueError(f"parameters: got {name!r}, {paths.meant(name, known)}")

    def wanted(self, model: Robot, values: Mapping[str, float]) -> list[Any]:
        """The parameters of the derivatives, for the model with these values."""

        def of(name: str) -> str | OfArgument:
            if START.fullmatch(name):
                return name
            make = partial(self._with, values, name)
            return OfArgument(name, values[name], None, model, make=make)

        return [of(name) for name in values]

    def _with(self, values: Mapping[str, float], name: str, value: float) -> Robot:
        return self({**values, name: value})


def _robot(model: Any, expected: str) -> Robot:
    if not isinstance(model, Robot):
        raise TypeError(f"{expected} {type(model).__name__}, which has no places")
    return model


@dataclass
class _Search:
    """The search for the parameters whose predictions are nearest to the measurements."""

    make: _OfModel | _OfFunction
    measured: Measured
    names: Sequence[str]
    #: Initial states without the parameters.
    start: Mapping[str, Array]
    options: dict[str, Any]
    noise: float | None
    confidence: float
    #: Lowest values, guesses and highest values (p,).
    bounds: tuple[Array, Array, Array]
    max_runs: int
    runs: int = 0
    failures: int = 0
    #: The last trial that failed.
    failed: str = ""
    #: Sum of squares, scaled values, residuals and Jacobian of the best run.
    best: tuple[float, Array, Array, Array] | None = None

    def best_fit(self) -> FitResult:
        from scipy.optimize import least_squares

        lowest, guess, highest = self.bounds
        # Scale, so that parameters of very different magnitude have equal weight.
        self._scale = np.where(guess != 0.0, np.abs(guess), 1.0)
        #: Residuals and Jacobian of the last values: the solver asks for both in turn.
        self._cached: dict[bytes, tuple[Array, Array]] = {}
        try:
            solved = least_squares(
                lambda z: self._evaluated(z)[0],
                guess / self._scale,
                lambda z: self._evaluated(z)[1],
                bounds=(lowest / self._scale, highest / self._scale),
                x_scale="jac",
                max_nfev=self.max_runs,
                ftol=FTOL,
                xtol=XTOL,
                gtol=GTOL,
            )
            at_end = self._evaluated(solved.x)
        except KeyboardInterrupt as error:
            if self.best is not None:
                message = f"Interrupted after {self.runs} runs; these are the best values until then."
                nowhere = np.zeros(len(self.names))
                error.result = self._result(  # type: ignore[attr-defined]
                    *self.best[1:], nowhere, False, message
                )
            else:
                # That of the first run, or of its equilibrium, is no FitResult.
                vars(error).pop("result", None)
            raise
        words = MESSAGES[min(max(solved.status, 0), 4)].format(runs=self.max_runs)
        found = solved.x, *at_end, solved.active_mask, bool(solved.status > 0)
        try:
            return self._result(*found, words, self._within_bounds)
        except KeyboardInterrupt as error:
            words += (
                f" Interrupted after {self.runs} runs, at the profiles: the intervals are those of the "
                "covariance, cut at their bounds."
            )
            error.result = self._result(*found, words)  # type: ignore[attr-defined]
            raise

    def _evaluated(self, z: Array) -> tuple[Array, Array]:
        """Residuals and their Jacobian at scaled values."""
        key = z.tobytes()
        if key in self._cached:
            return self._cached[key]
        self._cached.clear()
        wanted = self.measured.numbers
        values = dict(zip(self.names, (z * self._scale).tolist(), strict=True))
        try:
            predicted, derivatives = self._predicted(values)
        except (LissomError, ValueError) as error:
            if not self.runs:
                # Errors in the call itself are raised at once.
                kind = LissomError if isinstance(error, LissomError) else ValueError
                raise kind(f"with {values}: {error}" if kind is LissomError else str(error)) from None
            # Non-finite residuals make the solver shorten its steps.
            self.failures, self.failed = self.failures + 1, f"with {values}: {error}"
            found = np.full(wanted.size, np.inf), np.zeros((wanted.size, len(z)))
        else:
            residual = (predicted - wanted).ravel()
            found = residual, derivatives * self._scale
            square = float(residual @ residual)
            if self.best is None or square < self.best[0]:
                self.best = square, z.copy(), *found
        self._cached[key] = found
        self.runs += 1
        return found

    def _predicted(self, values: Mapping[str, float]) -> tuple[Array, Array]:
        """Predictions of the measurements, and their derivatives with respect to the parameters."""
        begin = {which: state.copy() for which, state in self.start.items()}
        for name, value in values.items():
            if found := START.fullmatch(name):
                begin[found["which"]][int(found["index"])] = value
        changed = self.make(values)
        return self.measured.predicted(changed, self.make.wanted(changed, values), begin, self.options)

    def _within_bounds(
        self,
        intervals: Array,
        z: Array,
        residual: Array,
        jacobian: Array,
        more: float,
        active: Array,
    ) -> str:
        """Move the ends of intervals that leave the bounds; what there is to say."""
        lowest, _, highest = self.bounds
        last = self.runs + self.max_runs

        def evaluated(at: Array) -> tuple[Array, Array]:
            if self.runs >= last:
                raise OutOfRuns
            return self._evaluated(at)

        limits = lowest / self._scale, highest / self._scale
        profile = Profile(evaluated, z, jacobian, float(residual @ residual), more, *limits)
        cut: list[str] = []
        for i, name in enumerate(self.names):
            guess = intervals[i] / self._scale[i]
            leaves = intervals[i, 0] < lowest[i] or intervals[i, 1] > highest[i]
            intervals[i] = np.clip(intervals[i], lowest[i], highest[i])
            # Intervals of what the data do not determine are infinite.
            if not (leaves or active[i]) or not np.isfinite(guess).all() or more <= 0.0:
                continue
            try:
                for k, side in enumerate((-1, 1)):
                    if active[i] == side:
                        intervals[i, k] = (lowest, highest)[k][i]
                    else:
                        intervals[i, k] = profile.end(i, side, guess[k]) * self._scale[i]
            except OutOfRuns:
                cut.append(name)
        if not cut:
            return ""
        return (
            f" Ends of the intervals of {', '.join(cut)} are those of the covariance, cut at their bounds: "
            f"{self.max_runs} runs (max_runs) did not find them."
        )

    def _result(
        self,
        z: Array,
        residual: Array,
        jacobian: Array,
        active: Array,
        success: bool,
        message: str,
        refine: Callable[..., str] | None = None,
    ) -> FitResult:
        from scipy.special import stdtrit

        measured, names, values = self.measured, self.names, z * self._scale
        freedom = measured.numbers.size - len(names)
        if self.noise is not None:
            noise = self.noise
        else:
            noise = float(np.sqrt(residual @ residual / freedom)) if freedom else np.inf
        covariance, undetermined = _covariance(jacobian, self._scale, noise, names)
        of_student = np.inf if self.noise is not None else max(freedom, 1)
        quantile = float(stdtrit(of_student, 0.5 * (1.0 + self.confidence)))
        lowest, _, highest = self.bounds
        intervals = on_scale(values, quantile * np.sqrt(np.diag(covariance)), lowest)
        at_bounds = tuple(name for name, is_there in zip(names, active, strict=True) if is_there)
        if undetermined:
            message += f" The data do not determine {', '.join(undetermined)}."
        if at_bounds:
            message += f" At a bound: {', '.join(at_bounds)}; the intervals end there."
        if refine is not None:
            message += refine(intervals, z, residual, jacobian, (quantile * noise) ** 2, active)
        else:
            intervals = np.clip(intervals, lowest[:, None], highest[:, None])
        if self.failures:
            message += f" {self.failures} of {self.runs} trial runs failed, the last one {self.failed}"
        model = self.make(dict(zip(names, values.tolist(), strict=True)))
        return FitResult(
            names=tuple(names),
            values=values,
            model=model,
            covariance=covariance,
            intervals=intervals,
            undetermined=undetermined,
            residuals=residual.reshape(measured.numbers.shape),
            noise=noise,
            runs=self.runs,
            success=success,
            message=message,
            at_bounds=at_bounds,
            confidence=self.confidence,
            measured=np.array(measured.numbers),
            t=np.array(measured.times) if isinstance(measured, OfMotion) else None,
            places=_names_of(model, measured),
        )


def _of_model(values: Mapping[str, float]) -> dict[str, float]:
    """The parameters that are no initial states."""
    return {name: value for name, value in values.items() if not START.fullmatch(name)}


def _names_of(model: Robot, measured: Measured) -> tuple[str, ...]:
    if isinstance(measured, OfFrequencies):
        return ()
    assert isinstance(measured, OfMotion | OfShapes)
    lengths = {link.name: sum(segment.length for segment in link.rod or ()) for link in model.links}
    return tuple(f"{link}, {lengths[link] if X is None else X:g} m" for link, X in measured.places)


def _covariance(
    jacobian: Array, scale: Array, spread: float, names: Sequence[str]
) -> tuple[Array, tuple[str, ...]]:
    """Covariance of the parameters, and the parameters that the data do not determine."""
    lengths = np.linalg.norm(jacobian, axis=0)
    silent = lengths <= RANK * lengths.max()
    lengths[silent] = 1.0
    _, singular, rows = np.linalg.svd(jacobian / lengths, full_matrices=False)
    is_known = singular > RANK * singular[0]
    is_free = silent | (np.abs(rows[~is_known]) > PART).any(axis=0)
    inverse = rows[is_known].T / singular[is_known]
    factor = inverse * (scale / lengths)[:, None]
    covariance = np.asarray(spread**2 * factor @ factor.T)
    covariance[is_free, :] = np.nan
    covariance[:, is_free] = np.nan
    covariance[is_free, is_free] = np.inf
    return covariance, tuple(name for name, free in zip(names, is_free, strict=True) if free)


def _measured(model: Robot, data: Any, places: Sequence[Any] | None, t0: float, dt: float) -> Measured:
    if isinstance(data, NaturalFrequencies):
        if places is not None:
            raise ValueError("places: expected None: frequencies have no places")
        numbers = np.asarray(data.values)
        if len(numbers) > model.n:
            raise ValueError(
                f"data: got {len(numbers)} frequencies, expected at most {model.n}, one of each coordinate"
            )
        return OfFrequencies(numbers, None if data.u is None else np.asarray(data.u))
    where = _places(model, places)
    if isinstance(data, StaticShapes):
        numbers = np.asarray(data.positions)
        if numbers.ndim == 2 and len(where) == 1:
            numbers = numbers[:, None]
        expected = (len(numbers), len(where), 3)
        if numbers.shape != expected:
            raise ValueError(f"data: positions have shape {numbers.shape}, expected {expected}")
        inputs = [None] * len(numbers) if data.u is None else list(np.asarray(data.u))
        return OfShapes(numbers, inputs, where)
    times, numbers = _data(data, len(where), t0)
    return OfMotion(numbers, times, where, t0, dt)


def _places(model: Robot, places: Sequence[Any] | None) -> Places:
    last = model.links[-1].name
    if places is None:
        return [(last, None)]
    if not sequence("places", places, "arc lengths, links or pairs of them"):
        raise ValueError(
            f"places: got {places!r}, expected a sequence of arc lengths, links or pairs of them"
        )
    found: list[tuple[str, float | None]] = []
    for place in places:
        match place:
            case str():
                found.append((place, None))
            case (str() as link, X):
                found.append((link, number("places", X)))
            case _:
                found.append((last, number("places", place)))
        link, X = found[-1]
        # Reject a place that is not on this robot before reading the next one.
        model.jacobian(np.zeros(model.n), X, link=link)
    return found


def _data(data: tuple[ArrayLike, ArrayLike], places: int, t0: float) -> tuple[Array, Array]:
    if not isinstance(data, tuple) or len(data) != 2:
        raise TypeError(
            f"data: got {type(data).__name__}, expected a pair (t, positions), StaticShapes or "
            "NaturalFrequencies"
        )
    try:
        times, measured = (np.asarray(part, float) for part in data)
    except (TypeError, ValueError, OverflowError) as error:
        raise TypeError(f"data: expected a pair (t, positions) of arrays of numbers: {error}") from None
    if times.ndim != 1 or not len(times):
        raise ValueError(f"data: times have shape {times.shape}, expected (k,) with at least one")
    if measured.ndim == 2 and places == 1:
        measured = measured[:, None]
    if measured.shape != (len(times), places, 3):
        raise ValueError(f"data: positions have shape {measured.shape}, expected {(len(times), places, 3)}")
    for name, part in (("times", times), ("positions", measured)):
        if not np.isfinite(part).all():
            raise ValueError(
                f"data: {name} are not finite, expected finite numbers (leave out what was not seen)"
            )
    if times[0] < t0 or (np.diff(times) <= 0).any():
        raise ValueError(f"data: times have to increase and not to be before t0 = {t0}")
    if times[-1] == t0:
        raise ValueError(f"data: the only time is t0 = {t0}, expected some motion after it")
    return times, measured


def _bounds(
    make: _OfModel | _OfFunction, names: Sequence[str], parameters: Mapping[str, Any]
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


def _check_starts(model: Robot, names: Sequence[str]) -> None:
    for name in names:
        start = START.fullmatch(name)
        if start and (start["index"] is None or int(start["index"]) >= model.n):
            raise ValueError(
                f"parameters: got {name!r}, expected a single coordinate such as '{start['which']}[0]'"
            )


def _state(state: ArrayLike | None, n: int, name: str) -> Array:
    found = np.zeros(n) if state is None else finite_array(state, name)
    if found.shape != (n,):
        raise ValueError(f"{name}: got shape {found.shape}, expected ({n},)")
    return found
