"""Predictions of measured data by a model, with derivatives with respect to its parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import Robot, StaticsResult, finite_array, inputs_by_name, statics
from ..common.arguments import keywords, number, sequence
from .accurate import AccurateRuns, asked, of_rows
from .equilibria import OF_STATICS, differentiated, equilibrium_sensitivity, numbers_of
from .measurements import OF_PLACES, NaturalFrequencies, RecordedMotion, StaticShapes
from .parameters import START
from .sensitivities import OF_SCHEME, OF_STEPS, held_rows, number_of_control_steps, sensitivity
from .shorthand import shorthand

Array = NDArray[np.float64]

#: Links and arc lengths of measured points.
Places = Sequence[tuple[str, float | None]]

Data = RecordedMotion | StaticShapes | NaturalFrequencies

#: Options of motions beside those of equilibria.
OF_MOTIONS = ("method", *OF_SCHEME, *OF_STEPS)

#: Keywords of `fit` itself.
OF_FIT = ("places", "t0", "q0", "v0", "dt", "noise", "confidence", "max_runs", "starts")

EXPECTED = "a pair (t, positions), RecordedMotion, StaticShapes or NaturalFrequencies"


class Measured(Protocol):
    """Measured numbers, and the model's prediction of them."""

    #: The numbers, their unit, and their standard deviation if it is known.
    numbers: Array
    unit: str
    noise: float | None

    @property
    def has_inputs(self) -> bool:
        """Whether the inputs are given; otherwise they are at their defaults."""

    def predicted(
        self, model: Robot, wanted: Sequence[Any], starts: Mapping[str, float]
    ) -> tuple[Array, Array]:
        """Predicted numbers and their derivatives with respect to the parameters, shape (size, p).

        `wanted` are parameters of the model, and as text the names of initial states; these are in `starts`.
        """

    def equilibria(self, model: Robot) -> Iterator[Callable[[], StaticsResult]]:
        """What finds the measured equilibria of a model again; nothing for motions."""


@dataclass
class OfMotion:
    """Positions of places over time."""

    numbers: Array
    times: Array
    places: Places
    q0: Array
    v0: Array
    options: Mapping[str, Any]
    noise: float | None
    unit: str = "metres"
    #: Runs by the method that 'auto' has chosen.
    accurate: AccurateRuns | None = None

    def predicted(
        self, model: Robot, wanted: Sequence[Any], starts: Mapping[str, float]
    ) -> tuple[Array, Array]:
        """See `Measured`."""
        run = sensitivity(model, self.times[-1], wanted, **self.begin(starts), **self.options)
        at = [run.position(X, link=link, t=self.times) for link, X in self.places]
        positions, derivatives = (np.stack(part, 1) for part in zip(*at, strict=True))
        return positions, derivatives.reshape(self.numbers.size, len(wanted))

    def begin(self, starts: Mapping[str, float]) -> dict[str, Any]:
        """The initial state with these coordinates and velocities by name."""
        found = {"q0": self.q0.copy(), "v0": self.v0.copy()}
        for name, value in starts.items():
            start = START.fullmatch(name)
            assert start is not None
            found[start["which"]][int(start["index"])] = value
        return found

    def choose(self, model: Robot, starts: Mapping[str, float]) -> None:
        """Choose method and tolerances for what is asked of 'auto', for this and all later runs."""
        method, options = shorthand(self.options.get("method"), dict(self.options))
        if method != "auto":
            return
        kept = ("t0", "dt", "u", "control_step", "method")
        auto, _ = asked({name: value for name, value in options.items() if name not in kept})
        t0, t_end = self.options["t0"], float(self.times[-1])
        dt, step = self.options["dt"], self.options.get("control_step")
        held, step = held_rows(model, self.options.get("u"), step, t_end - t0, dt)
        motion = {"t0": t0, "dt": dt, **self.begin(starts), **of_rows(held, step, t0)}
        self.accurate = AccurateRuns(model, t_end, motion, auto, self.times).chosen()
        given = {name: self.options[name] for name in kept if name in self.options}
        self.options = {**given, **self.accurate.options}

    @property
    def has_inputs(self) -> bool:
        """See `Measured`."""
        return self.options.get("u") is not None

    def equilibria(self, model: Robot) -> Iterator[Callable[[], StaticsResult]]:
        """See `Measured`."""
        return iter(())

    def with_half_steps(self) -> OfMotion | None:
        """The same with steps half as long; None if the method chooses them."""
        if shorthand(self.options.get("method"), {})[0] == "radau":
            return None
        dt = self.options["dt"]
        options = {**self.options, "dt": 0.5 * dt}
        if np.ndim(options.get("u", 0.0)) == 2:
            # By default, rows of inputs are held constant for a step.
            options.setdefault("control_step", dt)
        return replace(self, options=options)


@dataclass
class OfShapes:
    """Positions of places in equilibria."""

    numbers: Array
    inputs: Sequence[Array | None]
    places: Places
    q0: Array | None
    options: Mapping[str, Any]
    noise: float | None
    unit: str = "metres"
    #: Equilibria of the previous model, used as starting points for the next one.
    last: dict[int, Array] = field(default_factory=dict)

    @property
    def has_inputs(self) -> bool:
        """See `Measured`."""
        return any(u is not None for u in self.inputs)

    def predicted(
        self, model: Robot, wanted: Sequence[Any], starts: Mapping[str, float]
    ) -> tuple[Array, Array]:
        """See `Measured`."""
        found = []
        numbers = numbers_of(model, [each for each in wanted if not isinstance(each, str)])
        for row, u in enumerate(self.inputs):
            shape = differentiated(model, numbers, self.last.get(row, self.q0), u=u, **self.options)
            self.last[row] = shape.q
            found += [shape.position(X, link=link) for link, X in self.places]
        positions, derivatives = (np.array(part) for part in zip(*found, strict=True))
        by_numbers = derivatives.reshape(self.numbers.size, len(numbers))
        return positions.reshape(self.numbers.shape), _with_starts(by_numbers, wanted)

    def equilibria(self, model: Robot) -> Iterator[Callable[[], StaticsResult]]:
        """See `Measured`."""
        for row, u in enumerate(self.inputs):
            q0 = self.last.get(row, self.q0)
            yield partial(statics, model, q0, u=u, stability=False, **self.options)


@dataclass
class OfFrequencies:
    """Natural frequencies about an equilibrium."""

    numbers: Array
    inputs: Array | None
    q0: Array | None
    options: Mapping[str, Any]
    noise: float | None
    unit: str = "hertz"
    last: Array | None = None

    @property
    def has_inputs(self) -> bool:
        """See `Measured`."""
        return self.inputs is not None

    def predicted(
        self, model: Robot, wanted: Sequence[Any], starts: Mapping[str, float]
    ) -> tuple[Array, Array]:
        """See `Measured`."""
        q0 = self.q0 if self.last is None else self.last
        numbers = [each for each in wanted if not isinstance(each, str)]
        found = equilibrium_sensitivity(
            model, numbers, q0, frequencies=len(self.numbers), u=self.inputs, **self.options
        )
        self.last = found.q
        if np.isnan(found.dfrequencies).any():
            raise ValueError(
                f"data: the model has the frequencies {found.frequencies.round(6).tolist()} Hz, expected "
                "different ones: equal ones, as of a round rod in two directions, cannot be distinguished"
            )
        return found.frequencies, _with_starts(found.dfrequencies, wanted)

    def equilibria(self, model: Robot) -> Iterator[Callable[[], StaticsResult]]:
        """See `Measured`."""
        q0 = self.q0 if self.last is None else self.last
        yield partial(statics, model, q0, u=self.inputs, stability=False, **self.options)


def _with_starts(derivatives: Array, wanted: Sequence[Any]) -> Array:
    """Derivatives (size, p) of an equilibrium: zero with respect to initial states."""
    found = np.zeros((len(derivatives), len(wanted)))
    found[:, [not isinstance(each, str) for each in wanted]] = derivatives
    return found


@dataclass(frozen=True)
class Defaults:
    """Arguments of `fit` that hold for all data that do not say otherwise."""

    places: Sequence[Any] | None
    t0: float
    dt: float
    q0: ArrayLike | None
    v0: ArrayLike | None
    noise: float | None
    options: Mapping[str, Any]


def measured_of(model: Robot, data: Any, defaults: Defaults) -> list[Measured]:
    """The measured data, each with its own arguments.

    Raises ValueError and TypeError for what is invalid, with the number of the data if there are several.
    """
    if not isinstance(data, list) or not data:
        (one,) = _without_places([_read(data)], defaults)
        is_motion = isinstance(one, RecordedMotion)
        if not is_motion and "u" in defaults.options:
            raise ValueError(f"u: {type(one).__name__} has its own inputs: leave `u` out")
        known = ("u", "control_step", *OF_MOTIONS) if is_motion else OF_STATICS
        keywords("fit", defaults.options, (*OF_FIT, *known))
        return [_one(model, one, defaults, defaults.options)]
    read = _without_places([_numbered(i, _read, each) for i, each in enumerate(data)], defaults)
    for name in ("u", "control_step"):
        if name in defaults.options:
            raise ValueError(f"{name}: each RecordedMotion has its own `{name}`: leave it out")
    is_both = len({isinstance(each, NaturalFrequencies) for each in read}) > 1
    if is_both and defaults.noise is not None:
        raise ValueError(
            "noise: data in metres and in hertz need a noise each: give it to them, not to `fit`"
        )
    options = [defaults.options] * len(read)
    motions = {isinstance(each, RecordedMotion) for each in read}
    of_all = [name for one in motions for name in (OF_MOTIONS if one else OF_STATICS)]
    keywords("fit", defaults.options, dict.fromkeys((*OF_FIT, *of_all)))
    if len(motions) > 1:
        of_equilibria = [name for name in OF_STATICS if name not in OF_MOTIONS]
        options = [
            {
                name: value
                for name, value in defaults.options.items()
                if name in (OF_MOTIONS if isinstance(each, RecordedMotion) else of_equilibria)
            }
            for each in read
        ]
    found = [
        _numbered(i, _one, model, each, defaults, own)
        for i, (each, own) in enumerate(zip(read, options, strict=True))
    ]
    _check_weights(found)
    return found


def _numbered(i: int, function: Any, *arguments: Any) -> Any:
    """The result of a function, whose errors have the number of the data."""
    try:
        return function(*arguments)
    except (ValueError, TypeError) as error:
        words = str(error)
        words = (
            words.replace("data:", f"data[{i}]:", 1) if words.startswith("data:") else f"data[{i}].{words}"
        )
        raise (TypeError if isinstance(error, TypeError) else ValueError)(words) from None


def _check_weights(found: Sequence[Measured]) -> None:
    """Raise ValueError unless all data can be weighted: by their noise, or equally if they have one unit."""
    if all(each.noise is not None for each in found):
        return
    units = {each.unit for each in found}
    if len(units) == 1 and all(each.noise is None for each in found):
        return
    i, first = next((i, each) for i, each in enumerate(found) if each.noise is None)
    why = "weights compare metres with hertz" if len(units) > 1 else "the other data have one"
    raise ValueError(
        f"data[{i}].noise: expected the standard deviation of its numbers in {first.unit}, such as "
        f"noise={'1e-3' if first.unit == 'metres' else '0.1'}: {why}"
    )


def _read(data: Any) -> Data:
    if isinstance(data, RecordedMotion | StaticShapes | NaturalFrequencies):
        return data
    if not isinstance(data, tuple) or len(data) != 2:
        shapes = ": equilibria are `lissom.StaticShapes(positions, u=u)`" if np.ndim(data) > 1 else ""
        raise TypeError(f"data: got {type(data).__name__}, expected {EXPECTED}, or a list of these{shapes}")
    if np.ndim(data[0]) > 1:
        raise ValueError(
            f"data: t: got shape {np.shape(data[0])}, expected increasing times; equilibria with "
            "inputs are `lissom.StaticShapes(positions, u=u)`"
        )
    try:
        return RecordedMotion(*data)
    except (ValueError, TypeError) as error:
        raise type(error)(f"data: {error}") from None


def _without_places(data: list[Data], defaults: Defaults) -> list[Data]:
    """The data; raises ValueError for places that none of them has."""
    if defaults.places is not None and all(isinstance(each, NaturalFrequencies) for each in data):
        raise ValueError("places: frequencies have no places: leave `places` out")
    return data


def _one(model: Robot, data: Data, defaults: Defaults, options: Mapping[str, Any]) -> Measured:
    noise = defaults.noise if data.noise is None else data.noise
    q0 = None if defaults.q0 is None else _state(defaults.q0, model.n, "q0")
    if isinstance(data, NaturalFrequencies):
        numbers = np.asarray(data.values)
        if len(numbers) > model.n:
            raise ValueError(
                f"data: got {len(numbers)} frequencies, expected at most {model.n}, one of each coordinate"
            )
        u = None if data.u is None else finite_array(inputs_by_name(data.u, [model]), "u")
        return OfFrequencies(numbers, u, q0, options, noise)
    where = places_of(model, defaults.places if data.places is None else data.places)
    numbers = np.asarray(data.positions)
    if numbers.ndim == 2 and len(where) == 1:
        numbers = numbers[:, None]
    expected = (len(numbers), len(where), 3)
    if numbers.shape != expected:
        raise ValueError(f"data: positions have shape {numbers.shape}, expected {expected}")
    if isinstance(data, StaticShapes):
        inputs = _rows_of_inputs(model, data.u, len(numbers))
        return OfShapes(numbers, inputs, where, q0, options, noise)
    times = np.asarray(data.t)
    if times[0] < defaults.t0:
        raise ValueError(f"data: the first time, {times[0]:g}, is before t0 = {defaults.t0:g}")
    if times[-1] == defaults.t0:
        raise ValueError(f"data: the only time is t0 = {defaults.t0}, expected some motion after it")
    q0 = _state(defaults.q0 if data.q0 is None else data.q0, model.n, "q0")
    v0 = _state(defaults.v0 if data.v0 is None else data.v0, model.n, "v0")
    own = {name: getattr(data, name) for name in ("u", "control_step") if getattr(data, name) is not None}
    given = {"t0": defaults.t0, "dt": defaults.dt, **options, **own}
    if given.get("u") is not None:
        u = finite_array(inputs_by_name(given["u"], [model]), "u")
        given["u"] = _until(times[-1] - defaults.t0, u, given.get("control_step", given["dt"]))
    return OfMotion(numbers, times, where, q0, v0, given, noise)


def _rows_of_inputs(model: Robot, u: Any, count: int) -> Sequence[Array | None]:
    """Inputs of measured equilibria, of which each has a row."""
    if u is None:
        return [None] * count
    rows = finite_array(inputs_by_name(u, [model]), "u")
    if rows.ndim != 2 or len(rows) != count:
        raise ValueError(f"u: got shape {rows.shape}, expected ({count}, m): inputs of every shape")
    return list(rows)


def _until(duration: float, u: Array, control_step: Any) -> Array:
    """Inputs up to the last measured time: later ones have no effect."""
    is_step = isinstance(control_step, int | float) and control_step > 0.0
    return u[: number_of_control_steps(duration, control_step)] if u.ndim == 2 and is_step else u


def places_of(model: Robot, places: Sequence[Any] | None) -> Places:
    """Links and arc lengths of measured points."""
    last = model.links[-1].name
    if places is None:
        return [(last, None)]
    if not sequence("places", places, OF_PLACES):
        raise ValueError(f"places: got {places!r}, expected a sequence of {OF_PLACES}")
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


def _state(state: ArrayLike | None, n: int, name: str) -> Array:
    found = np.zeros(n) if state is None else finite_array(state, name)
    if found.shape != (n,):
        raise ValueError(f"{name}: got shape {found.shape}, expected ({n},)")
    return found
