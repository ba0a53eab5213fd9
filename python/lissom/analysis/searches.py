"""The search for the parameters whose predictions are nearest to measured data."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .._lissom import LissomError, Robot, SpaceError, Tendon
from .advice import implausible_units
from .doubts import without_doubts
from .fitted import FitResult, FittedData
from .makers import ArgumentsOfFunction, NumbersOfModel
from .parameters import START
from .predictions import Measured, OfFrequencies, OfMotion, OfShapes
from .profiles import OutOfRuns, Profile, on_scale

Array = NDArray[np.float64]

#: The data do not determine directions whose singular value of the scaled Jacobian is below this fraction of
#: the largest.
RANK = 1e-8

#: Where the search ends: relative changes of the sum of squares and of the values, and the gradient.
FTOL, XTOL, GTOL = 1e-10, 1e-10, 1e-14

#: It also ends where the values are this near to the best ones, relative to their own uncertainty (Bates and
#: Watts 1981, Technometrics 23, 179, who propose this number). Where runs choose their steps, the sum of
#: squares is not smooth, and tolerances of its change are not reached.
OFFSET = 1e-3

#: The status of that, after those of SciPy's `least_squares`, and what they mean.
SETTLED = 5
MESSAGES = (
    "Not converged: {runs} (max_runs) did not suffice; a better guess or more of them may.",
    f"Converged: the gradient of the cost is below gtol = {GTOL:g}.",
    f"Converged: the change of the cost is below ftol = {FTOL:g} of the cost.",
    f"Converged: the change of the parameters is below xtol = {XTOL:g} of them.",
    f"Converged: the changes of cost and parameters are below ftol = {FTOL:g} and xtol = {XTOL:g} of them.",
    f"Converged: the values are within {OFFSET:g} of their uncertainty from the best ones.",
)

#: A parameter counts as undetermined if its component of an undetermined direction is at least this large.
PART = 0.1

#: Sums of squares that differ by less than this part are those of one minimum.
SAME = 1e-3

#: Residuals of a motion are more than noise if neighbours have a larger correlation than this, which means
#: that half of their square is not white, and their root mean square is above this part of the data's spread:
#: errors of the time steps below it are expected.
ALIKE, NOTABLE = 0.5, 0.01

#: Errors of the time steps are reported that change a value by more than this part of its interval's half
#: width.
OF_STEPS = 0.25

#: Measured positions that are farther off than this multiple of the robot's length are in other units.
FAR = 10.0

#: With this probability residuals that are noise alone are taken for more, if the noise is known.
BY_CHANCE = 1e-3


class _Settled(Exception):
    """The values are near enough to the best ones."""

    def __init__(self, z: Array) -> None:
        super().__init__()
        self.z = z


@dataclass(frozen=True)
class _Found:
    """Where a search ended: scaled values, residuals, Jacobian, active bounds (-1, 0, 1) and the status."""

    z: Array
    residual: Array
    jacobian: Array
    active: Array
    status: int

    @property
    def square(self) -> float:
        return float(self.residual @ self.residual)


@dataclass
class Search:
    """The search for the best values, from one or several starting points."""

    make: NumbersOfModel | ArgumentsOfFunction
    measured: Sequence[Measured]
    names: Sequence[str]
    confidence: float
    #: Lowest values, guesses and highest values (p,).
    bounds: tuple[Array, Array, Array]
    max_runs: int
    #: Number of starting points: the guess, and others within the bounds.
    starts: int = 1
    runs: int = 0
    failures: int = 0
    #: The last trial that failed.
    failed: str = ""
    #: Sum of squares, scaled values, residuals and Jacobian of the best run.
    best: tuple[float, Array, Array, Array] | None = None
    #: Warnings of unresolved vibrations in that run; those at trial values do not matter.
    unresolved: list[str] = field(default_factory=list)
    #: Warning of a fitted model that has too few modes.
    coarse: list[str] = field(default_factory=list)
    #: Residuals and Jacobian of the last values: the solver asks for both in turn.
    _cached: dict[bytes, tuple[Array, Array]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        guess = self.bounds[1]
        # Scale, so that parameters of very different magnitude have equal weight.
        self._scale = np.where(guess != 0.0, np.abs(guess), 1.0)
        self._is_weighted = all(each.noise is not None for each in self.measured)
        sizes = [each.numbers.size for each in self.measured]
        self._size, self._ends = sum(sizes), np.cumsum(sizes)[:-1]

    def best_fit(self) -> FitResult:
        """The result; KeyboardInterrupt has that of the best values until then."""
        found: list[_Found] = []
        try:
            for begin in self._beginnings():
                one = self._searched(begin)
                if one is not None:
                    found.append(one)
        except KeyboardInterrupt as error:
            if self.best is not None:
                message = f"Interrupted after {self.runs} runs; these are the best values until then."
                ended = _Found(*self.best[1:], active=np.zeros(len(self.names)), status=0)
                error.result = self._result(ended, message)  # type: ignore[attr-defined]
            else:
                # That of the first run, or of its equilibrium, is no FitResult.
                vars(error).pop("result", None)
            raise
        best = min(found, key=lambda each: each.square)
        words = MESSAGES[min(max(best.status, 0), SETTLED)].format(
            runs="1 run" if self.max_runs == 1 else f"{self.max_runs} runs"
        )
        words += _of_starts(found, best, self.starts)
        try:
            return self._result(best, words, self._within_bounds)
        except KeyboardInterrupt as error:
            words += (
                f" Interrupted after {self.runs} runs, at the profiles: the intervals are those of the "
                "covariance, cut at their bounds."
            )
            error.result = self._result(best, words)  # type: ignore[attr-defined]
            raise

    def _beginnings(self) -> list[Array]:
        """The scaled starting points: the guess, and points that fill the box of the bounds (Halton 1960).

        Where bounds are positive, their logarithms are filled.
        """
        lowest, guess, highest = self.bounds
        points = [guess / self._scale]
        if self.starts > 1:
            from scipy.stats import qmc

            # The first point of the sequence is a corner.
            part = qmc.Halton(len(guess), scramble=False).fast_forward(1).random(self.starts - 1)
            is_scale = lowest > 0.0
            linear = lowest + part * (highest - lowest)
            base = np.where(is_scale, lowest, 1.0)
            scaled = base * (np.where(is_scale, highest, 1.0) / base) ** part
            points += list(np.where(is_scale, scaled, linear) / self._scale)
        return points

    def _searched(self, begin: Array) -> _Found | None:
        """Where the search from one point ends; None if no run is possible at this point."""
        from scipy.optimize import least_squares

        if not np.isfinite(self._evaluated(begin)[0]).all():
            return None
        lowest, _, highest = self.bounds
        limits = lowest / self._scale, highest / self._scale

        def jacobian(z: Array) -> Array:
            residual, found = self._evaluated(z)
            if _is_settled(z, residual, found, *limits):
                raise _Settled(z)
            # A parameter without influence stays at its guess: rounding would send it to a bound.
            return np.where(_is_silent(found), 0.0, found)

        try:
            solved = least_squares(
                lambda z: self._evaluated(z)[0],
                begin,
                jacobian,
                bounds=limits,
                x_scale="jac",
                max_nfev=self.max_runs,
                ftol=FTOL,
                xtol=XTOL,
                gtol=GTOL,
            )
        except _Settled as settled:
            z = settled.z
            return _Found(z, *self._evaluated(z), active=np.zeros(len(z)), status=SETTLED)
        return _Found(solved.x, *self._evaluated(solved.x), active=solved.active_mask, status=solved.status)

    def _evaluated(self, z: Array) -> tuple[Array, Array]:
        """Residuals, relative to their noise if it is known, and their Jacobian at scaled values."""
        key = z.tobytes()
        if key in self._cached:
            return self._cached[key]
        self._cached.clear()
        values = dict(zip(self.names, (z * self._scale).tolist(), strict=True))
        try:
            (residual, derivatives), unresolved = without_doubts(lambda: self._predicted(values))
        except (LissomError, ValueError) as error:
            if not self.runs:
                # Errors in the call itself are raised at once.
                kind = LissomError if isinstance(error, LissomError) else ValueError
                raise kind(f"with {values}: {error}" if kind is LissomError else str(error)) from None
            # Non-finite residuals make the solver shorten its steps.
            self.failures, self.failed = self.failures + 1, f"with {values}: {error}"
            found = np.full(self._size, np.inf), np.zeros((self._size, len(z)))
        else:
            found = residual, derivatives * self._scale
            square = float(residual @ residual)
            if self.best is None or square < self.best[0]:
                self.best, self.unresolved = (square, z.copy(), *found), unresolved
        self._cached[key] = found
        self.runs += 1
        return found

    def _predicted(
        self, values: Mapping[str, float], measured: Sequence[Measured] | None = None
    ) -> tuple[Array, Array]:
        """Residuals, relative to their noise if it is known, and derivatives by the parameters."""
        model = self.make(values)
        wanted = self.make.wanted(model, values)
        starts = {name: value for name, value in values.items() if START.fullmatch(name)}
        residuals, derivatives = [], []
        for each in self.measured if measured is None else measured:
            predicted, derivative = each.predicted(model, wanted, starts)
            weight = self._weight(each)
            residuals.append((predicted - each.numbers).ravel() * weight)
            derivatives.append(derivative * weight)
        return np.concatenate(residuals), np.concatenate(derivatives)

    def _weight(self, measured: Measured) -> float:
        return 1.0 / measured.noise if self._is_weighted and measured.noise is not None else 1.0

    def _within_bounds(self, intervals: Array, found: _Found, more: float) -> str:
        """Move the ends of intervals that leave the bounds; what there is to say."""
        lowest, _, highest = self.bounds
        last = self.runs + self.max_runs

        def evaluated(at: Array) -> tuple[Array, Array]:
            if self.runs >= last:
                raise OutOfRuns
            return self._evaluated(at)

        limits = lowest / self._scale, highest / self._scale
        profile = Profile(evaluated, found.z, found.jacobian, found.square, more, *limits)
        cut: list[str] = []
        for i, name in enumerate(self.names):
            guess = intervals[i] / self._scale[i]
            leaves = intervals[i, 0] < lowest[i] or intervals[i, 1] > highest[i]
            intervals[i] = np.clip(intervals[i], lowest[i], highest[i])
            # Intervals of what the data do not determine are infinite.
            if not (leaves or found.active[i]) or not np.isfinite(guess).all() or more <= 0.0:
                continue
            try:
                for k, side in enumerate((-1, 1)):
                    if found.active[i] == side:
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

    def _result(self, found: _Found, message: str, refine: Callable[..., str] | None = None) -> FitResult:
        from scipy.special import stdtrit

        names, values = self.names, found.z * self._scale
        freedom = self._size - len(names)
        # Of the residuals of the search: of those relative to their noise, it is one.
        spread = 1.0 if self._is_weighted else np.sqrt(found.square / freedom) if freedom else np.inf
        covariance, undetermined = _covariance(found.jacobian, self._scale, float(spread), names)
        of_student = np.inf if self._is_weighted else max(freedom, 1)
        quantile = float(stdtrit(of_student, 0.5 * (1.0 + self.confidence)))
        lowest, _, highest = self.bounds
        intervals = on_scale(values, quantile * np.sqrt(np.diag(covariance)), lowest)
        at_bounds = tuple(name for name, is_there in zip(names, found.active, strict=True) if is_there)
        model = self.make(dict(zip(names, values.tolist(), strict=True)))
        data = self._data(model, found.residual, float(spread))
        message += self._of_inputs(model) + self._doubts(model, found, data, freedom)
        if not np.isfinite(spread):
            message += (
                " There are as many measured numbers as parameters, which leaves nothing to estimate the "
                "noise and the intervals from: give `noise`."
            )
        if undetermined:
            message += f" The data do not determine {', '.join(undetermined)}."
            message += self._of_sliding(model, undetermined)
        if at_bounds:
            message += f" At a bound: {', '.join(at_bounds)}; the intervals end there."
        if refine is not None:
            message += self._of_steps(found, 0.5 * (intervals[:, 1] - intervals[:, 0]))
            message += self._of_accuracy(model, values)
            message += refine(intervals, found, (quantile * spread) ** 2)
        else:
            intervals = np.clip(intervals, lowest[:, None], highest[:, None])
        space_error = self._space_error(model)
        message += "".join(f" {each}" for each in dict.fromkeys((*self.unresolved, *self.coarse)))
        message += "".join(f" {each}" for each in implausible_units(model))
        if self.failures:
            message += f" {self.failures} of {self.runs} trial runs failed, the last one {self.failed}"
        return FitResult(
            names=tuple(names),
            values=values,
            model=model,
            covariance=covariance,
            intervals=intervals,
            undetermined=undetermined,
            data=data,
            runs=self.runs,
            success=found.status > 0,
            message=message,
            at_bounds=at_bounds,
            confidence=self.confidence,
            space_error=space_error,
        )

    def _space_error(self, model: Robot) -> SpaceError | None:
        """The largest error of the measured equilibria due to the modes, after noting its warning."""
        self.coarse = []
        worst: SpaceError | None = None
        for find in (find for each in self.measured for find in each.equilibria(model)):
            found, doubts = without_doubts(find)
            error = found.space_error
            if error is not None and (worst is None or error.relative > worst.relative):
                worst, self.coarse = error, doubts
        return worst

    def _of_inputs(self, model: Robot) -> str:
        """Whether data of a robot with inputs came without them."""
        if not model.inputs or all(each.has_inputs for each in self.measured):
            return ""
        given = zip(model.inputs, np.asarray(model.u0).tolist(), strict=True)
        values = ", ".join(f"{name!r} = {value:g}" for name, value in given)
        return f" No `u` was given with the data: inputs are at their defaults, {values}."

    def _of_sliding(self, model: Robot, undetermined: Sequence[str]) -> str:
        """Why static shapes do not determine the friction of tendons."""
        is_static = any(isinstance(each, OfShapes) for each in self.measured)
        is_open = any(isinstance(each, Tendon) and each.sliding is None for each in model.actuators)
        if not (is_static and is_open and any(name.endswith("friction") for name in undetermined)):
            return ""
        return (
            " At rest nothing slides, and static shapes leave the friction of tendons out: `sliding` of a "
            "tendon says which way it acts, 1 while the tendon is pulled."
        )

    def _of_steps(self, found: _Found, widths: Array) -> str:
        """Whether errors of the time steps count beside the uncertainty, by a run with steps half as long."""
        halved = [each.with_half_steps() if isinstance(each, OfMotion) else None for each in self.measured]
        finer = [each if half is None else half for each, half in zip(self.measured, halved, strict=True)]
        if not any(halved) or not np.isfinite(found.residual).all():
            return ""
        values = dict(zip(self.names, (found.z * self._scale).tolist(), strict=True))
        try:
            (residual, _), _ = without_doubts(lambda: self._predicted(values, finer))
        except (LissomError, ValueError):
            return ""
        self.runs += 1
        # The errors of second order are four thirds of their change, and move the values to first order.
        change = np.linalg.lstsq(found.jacobian, 4.0 / 3.0 * (found.residual - residual), rcond=RANK)[0]
        moved = np.abs(change * self._scale)
        parts = np.where(
            (widths > 0.0) & np.isfinite(widths), moved / np.where(widths > 0.0, widths, 1.0), 0.0
        )
        worst = int(np.argmax(parts))
        if parts[worst] <= OF_STEPS:
            return ""
        shorter = np.ceil(np.sqrt(parts[worst] / OF_STEPS))
        return (
            f" The time steps move {self.names[worst]} by about {moved[worst]:.2g}, {parts[worst]:.2g} times "
            f"the half width of its interval: take steps that are {shorter:g} times as short."
        )

    def _of_accuracy(self, model: Robot, values: Array) -> str:
        """Errors of runs to an accuracy with the fitted values; a doubt about larger ones than asked."""
        message = ""
        named = dict(zip(self.names, values.tolist(), strict=True))
        starts = {name: value for name, value in named.items() if START.fullmatch(name)}
        for each in self.measured:
            if isinstance(each, OfMotion) and each.accurate is not None:
                sentence, doubt = each.accurate.verdict(model, **each.begin(starts))
                message += sentence
                self.unresolved += [doubt] if doubt else []
        return message

    def _data(self, model: Robot, residual: Array, spread: float) -> tuple[FittedData, ...]:
        """The data with their residuals in their own units."""
        return tuple(
            FittedData(
                kind=_KINDS[type(each)],
                t=np.array(each.times) if isinstance(each, OfMotion) else None,
                places=_names_of(model, each),
                measured=np.array(each.numbers),
                residuals=part.reshape(each.numbers.shape) / self._weight(each),
                noise=each.noise if self._is_weighted and each.noise is not None else spread,
            )
            for each, part in zip(self.measured, np.split(residual, self._ends), strict=True)
        )

    def _doubts(self, model: Robot, found: _Found, data: Sequence[FittedData], freedom: int) -> str:
        """Whether residuals are more than noise, or data not in metres."""
        from scipy.special import chdtri

        others = (
            "" if self.starts > 1 else ", or other values fit better (`starts=10` searches from ten points)"
        )
        if self._is_weighted and freedom and found.square > chdtri(freedom, BY_CHANCE):
            ratio = float(np.sqrt(found.square / freedom))
            return (
                f" The residuals are {ratio:.3g} times as large as the noise: the model leaves out "
                f"something{others}."
            )
        length = sum(segment.length for link in model.links for segment in link.rod or ())
        for i, each in enumerate(data):
            if each.places and each.misfit > FAR * length > 0.0:
                return (
                    f" The measured positions are {each.misfit:.3g} m off, the robot is {length:.3g} m long: "
                    "are they in metres?"
                )
            extent = float(np.sqrt(np.mean((each.measured - each.measured.mean(axis=0)) ** 2)))
            if each.correlation > ALIKE and each.misfit > NOTABLE * extent:
                which = f" of data[{i}]" if len(data) > 1 else ""
                return (
                    f" Most of the residuals{which} ({each.misfit:.3g} {each.unit}) are not noise: "
                    f"neighbours have a correlation of {each.correlation:.2f}. The model leaves out "
                    f"something{others}."
                )
        return ""


def _of_starts(found: Sequence[_Found], best: _Found, starts: int) -> str:
    """How many of the searches came to the best values."""
    if starts == 1:
        return ""
    same = sum(each.square <= (1.0 + SAME) * best.square for each in found)
    said = f" The best of {starts} searches from different points; {same} of them ended there"
    others = [each.square for each in found if each.square > (1.0 + SAME) * best.square]
    if others and best.square > 0.0:
        said += f", the next best with {np.sqrt(min(others) / best.square):.3g} times the residuals"
    return f"{said}."


def _is_settled(z: Array, residual: Array, jacobian: Array, lowest: Array, highest: Array) -> bool:
    """Whether the best values of the linearised model are near, relative to their uncertainty."""
    freedom = len(residual) - len(z)
    if freedom <= 0:
        return False
    step, _, rank, _ = np.linalg.lstsq(jacobian, -residual, rcond=RANK)
    if rank < len(z) or (z + step < lowest).any() or (z + step > highest).any():
        return False
    along = jacobian @ step
    beyond = residual + along
    return bool(along @ along / len(z) <= OFFSET**2 * (beyond @ beyond) / freedom)


_KINDS = {OfMotion: "motion", OfShapes: "shapes", OfFrequencies: "frequencies"}


def _names_of(model: Robot, measured: Measured) -> tuple[str, ...]:
    if isinstance(measured, OfFrequencies):
        return ()
    assert isinstance(measured, OfMotion | OfShapes)
    lengths = {link.name: sum(segment.length for segment in link.rod or ()) for link in model.links}
    return tuple(f"{link}, {lengths[link] if X is None else X:g} m" for link, X in measured.places)


def _is_silent(jacobian: Array) -> NDArray[np.bool_]:
    """The parameters on which the data do not depend, but for rounding."""
    lengths = np.linalg.norm(jacobian, axis=0)
    return np.asarray(lengths <= RANK * lengths.max())


def _covariance(
    jacobian: Array, scale: Array, spread: float, names: Sequence[str]
) -> tuple[Array, tuple[str, ...]]:
    """Covariance of the parameters, and the parameters that the data do not determine."""
    lengths, silent = np.linalg.norm(jacobian, axis=0), _is_silent(jacobian)
    lengths[silent] = 1.0
    _, singular, rows = np.linalg.svd(jacobian / lengths, full_matrices=False)
    is_known = singular > RANK * singular[0]
    is_free = silent | (np.abs(rows[~is_known]) > PART).any(axis=0)
    inverse = rows[is_known].T / singular[is_known]
    factor = inverse * (scale / lengths)[:, None]
    if not np.isfinite(spread):
        # As many numbers as parameters, of unknown noise.
        return np.where(np.eye(len(scale)) > 0.0, np.inf, np.nan), ()
    covariance = np.asarray(spread**2 * factor @ factor.T)
    covariance[is_free, :] = np.nan
    covariance[:, is_free] = np.nan
    covariance[is_free, is_free] = np.inf
    return covariance, tuple(name for name, free in zip(names, is_free, strict=True) if free)
