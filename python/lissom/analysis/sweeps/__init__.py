"""Parameter sweeps over grids of values, by threads or executors, with stores that can be resumed."""

from __future__ import annotations

import contextlib
import inspect
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._lissom import Model, Scene, __version__, simulate
from ...common.arguments import keywords, one_of, path_of, sequence, suggesting, whole
from ...common.extras import missing
from ...model import paths
from ...model.views import view
from . import executors
from .source import Case, Source, source_of
from .store import Memory, Zarr
from .work import Array, Record, Wants, places_of, run_points

if TYPE_CHECKING:
    import os

    import xarray

__all__ = ["sweep"]

#: Maximum size of the results of a task, bytes.
TASK_BYTES = 2**26

#: Keywords of `sweep` itself, beside options of `simulate`.
OWN = ("executor", "store", "combine", "keep", "places", "measure", "workers", "progress")

#: Options of `simulate` that sweeps do not have: functions, which a store could not distinguish.
NO_OPTIONS = ("control", "control_step")

#: Variables stored per point, in addition to the results of `measure`: the dimensions after those of the
#: parameters, and a description.
VARIABLES: dict[str, tuple[tuple[str, ...], str]] = {
    "q": (("coordinate",), "generalised coordinates"),
    "v": (("coordinate",), "generalised velocities"),
    "lowest": (("coordinate",), "lowest generalised coordinates over time"),
    "highest": (("coordinate",), "highest generalised coordinates over time"),
    "position": (("place", "axis"), "position in the world"),
    "position_lowest": (("place", "axis"), "lowest position over time, axis by axis"),
    "position_highest": (("place", "axis"), "highest position over time, axis by axis"),
    "success": ((), "the end was reached"),
    "status": ((), "how the run ended"),
    "message": ((), "the status in words"),
    "is_doubtful": ((), "fixed steps do not resolve the motion"),
    "reached": ((), "last time that the run has"),
    "steps": ((), "accepted steps"),
    "wall_time": ((), "run time"),
}

#: Variables with time as first dimension if states are kept.
STATES = ("q", "v", "position")


@suggesting
def sweep(
    model: Scene | Model | Callable[..., Scene | Model],
    parameters: Mapping[str, Iterable[Any]],
    *,
    executor: Any = None,
    store: str | os.PathLike[str] | None = None,
    combine: str = "product",
    keep: str = "final",
    places: Sequence[Any] | None = None,
    measure: Callable[[Any], Any] | None = None,
    workers: int | None = None,
    progress: bool | Callable[[int], object] = False,
    **options: Any,
) -> xarray.Dataset:
    """Simulate over a grid of parameter values; needs the extra `sweep`.

    Every value of every parameter is checked before the first run. Points with invalid combinations of values
    have the status 'refused', and failed runs have the status of their failure; neither affects other points.

    Parameters
    ----------
    model : Scene, Model or callable
        A scene, a model, or a function of the parameters that returns one. Executors with processes must be
        able to import the function by its name.
    parameters : mapping of str to sequence
        Values by parameter: numbers, booleans or strings. For a scene the names are key paths, such as
        ``rod[0].segment[0].young_modulus`` or ``simulation.dt``, including keys left at their defaults; for a
        model the same paths, or attributes (``segments[0].radius``); for a function its arguments. A star
        sets all entries of a list (``segments[*].radius``).
    executor : executor, optional
        Executor for the simulations, with the interface of `concurrent.futures`, or a client of
        `dask.distributed`. By default threads on all processors. Points are grouped into tasks of about one
        second, estimated from earlier ones.
    store : path-like, optional
        Zarr store for finished runs. A call with the same arguments resumes from it.
    combine : {'product', 'zip'}
        'product': all combinations of values. 'zip': the first values of all parameters, then the second
        ones, and so on; the sequences have the same length, and the dataset has one dimension ``point``.
    keep : {'final', 'states'}
        Keep the final states and positions, or those at all times, which must then be the same for all
        points.
    places : sequence, optional
        Points of a robot whose positions are kept, as for `simulate_many`; by default the tip of the last
        link.
    measure : callable, optional
        Called as ``measure(result)`` with the `MotionResult` of each point, which takes a second run; returns
        a number, an array, or a mapping of names to these. Its exceptions are raised. Executors with
        processes must be able to import it by its name.
    workers : int, optional
        Threads per task; by default one with an executor, and all processors without.
    progress : bool or callable, optional
        True shows a bar in the terminal; a callable is called as ``progress(done)`` with the number of
        finished points.
    **options
        Options of `simulate`, except `control` and `control_step`. They override those of a scene; models
        and functions that return models need `t_end`.

    Returns
    -------
    xarray.Dataset
        Arrays whose first dimensions are the parameters: `q`, `v`, `lowest`, `highest` (of the coordinates
        over time), `position`, `position_lowest`, `position_highest` (of the places), `success`, `status`,
        `message`, `is_doubtful`, `reached`, `steps`, `wall_time`, and the results of `measure`. Missing
        values are NaN; so are arrays whose shape differs from that of the first point, such as coordinates in
        a sweep over numbers of modes.

    Raises
    ------
    ValueError, TypeError
        Before the first run, if a parameter does not exist, a value is invalid, or the store belongs to
        another sweep.
    ImportError
        If xarray is missing, or zarr for a store.
    KeyboardInterrupt
        On Ctrl-C. Its attribute `result` is the dataset of the finished runs; errors of executors have it,
        too.

    Examples
    --------
    >>> import lissom
    >>> soft = lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000, {"bend_y": 2}, retardation_time=0.02)
    >>> found = lissom.sweep(
    ...     lissom.Rod([soft]), {"rod[0].segment[0].radius": [8e-3, 1e-2, 1.2e-2]}, t_end=0.5, dt=5e-3
    ... )
    >>> found.sizes["rod[0].segment[0].radius"], bool(found.success.all())
    (3, True)
    """
    needed = ["xarray"] + ["zarr"] * (store is not None)
    if absent := missing(*needed):
        raise ImportError(f"sweeps need {' and '.join(absent)}: pip install 'lissom[sweep]'")
    grid = Grid(parameters, combine)
    wants = _wants(keep, places, measure, workers if executor is None else workers or 1)
    source = source_of(model, options)
    for name in NO_OPTIONS:
        if name in options:
            raise TypeError(f"{name}: sweeps have no such option: leave it out")
    others = ("model", *NO_OPTIONS, *OWN)
    of_simulate = [name for name in inspect.signature(simulate).parameters if name not in others]
    keywords("sweep", options, (*OWN, *of_simulate))
    source.check_names(list(grid.values))
    adapted, threads = (None, None) if executor is None else executors.adapted(executor)
    first = _check(source, grid, wants)
    kept = _kept(store, grid, _identity(source, grid, wants))
    # The first point shows whether the store fits this sweep.
    left = np.flatnonzero(~kept.done).tolist()
    with _Progress(progress, len(kept.done)) as report:
        report(int(kept.done.sum()))

        def write(which: Sequence[int], records: Sequence[Record]) -> None:
            kept.begin(_pattern(records))
            kept.write(which, records)
            report(int(kept.done.sum()))

        try:
            if left:
                # Start with a small task, because the time of a run is not known yet.
                begun = left[:1]
                records, seconds = run_points(source, [grid.point(begun[0])], wants)
                write(begun, records)
                size = sum(value.nbytes for value in records[0].values())
                chunks = executors.Chunks(left[1:], threads, max(1, TASK_BYTES // max(size, 1)))
                chunks.took(1, seconds)
                if adapted is None:
                    executors.here(source, grid.point, wants, chunks, write)
                else:
                    executors.by(adapted, source, grid.point, wants, chunks, write)
        except BaseException as error:
            # Replaces a `result` attribute of the exception in a task.
            with contextlib.suppress(AttributeError):
                error.result = _dataset(kept, grid, first, wants)  # type: ignore[attr-defined]
            raise
    return _dataset(kept, grid, first, wants)


class Grid:
    """Points of a sweep by index: the last parameter varies fastest."""

    def __init__(self, parameters: Mapping[str, Iterable[Any]], combine: str) -> None:
        one_of("combine", combine, ("product", "zip"))
        if not isinstance(parameters, Mapping) or not parameters:
            raise TypeError("parameters: expected a mapping of at least one parameter to its values")
        self.values = {str(name): _values(str(name), values) for name, values in parameters.items()}
        lengths = [len(values) for values in self.values.values()]
        self.together = combine == "zip"
        if self.together and len(set(lengths)) > 1:
            raise ValueError(f"parameters: got {lengths} values, expected as many of each with combine='zip'")
        self.shape = tuple(lengths[:1] if self.together else lengths)
        self.dimensions = ("point",) if self.together else tuple(self.values)
        self.size = math.prod(self.shape)

    def point(self, number: int) -> dict[str, Any]:
        """Parameters of a point."""
        if self.together:
            return {name: values[number] for name, values in self.values.items()}
        at = np.unravel_index(number, self.shape)
        return {name: values[int(i)] for (name, values), i in zip(self.values.items(), at, strict=True)}

    def tried(self) -> Iterable[tuple[str, int, dict[str, Any]]]:
        """Points that contain every value of every parameter, with first values for the others."""
        if self.together:
            name = next(iter(self.values))
            return ((name, i, self.point(i)) for i in range(self.size))
        firsts = {name: values[0] for name, values in self.values.items()}
        return (
            (name, i, firsts | {name: value})
            for name, values in self.values.items()
            for i, value in enumerate(values)
        )


def _values(name: str, values: Iterable[Any]) -> list[Any]:
    """Plain values of a parameter."""
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise TypeError(f"parameters[{name!r}]: expected a sequence of values, got {type(values).__name__}")
    plain = [value.item() if isinstance(value, np.generic) else value for value in values]
    if not plain:
        raise ValueError(f"parameters[{name!r}]: got no values, expected at least one")
    for i, value in enumerate(plain):
        if not isinstance(value, bool | int | float | str):
            found = type(value).__name__
            raise TypeError(
                f"parameters[{name!r}][{i}]: got {found}, expected a number, a boolean or a string"
            )
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f"parameters[{name!r}][{i}]: got {value}, expected a finite number")
        if value in plain[:i]:
            # Equal values would share a coordinate of the dataset.
            raise ValueError(f"parameters[{name!r}][{i}]: {value!r} is listed twice: give each value once")
    return plain


def _wants(keep: str, places: Sequence[Any] | None, measure: Any, workers: int | None) -> Wants:
    one_of("keep", keep, ("final", "states"))
    if measure is not None and not callable(measure):
        raise TypeError(f"measure: expected a callable, got {type(measure).__name__}")
    if workers is not None and whole("workers", workers) < 1:
        raise ValueError(f"workers: got {workers}, expected a whole number > 0")
    where = None if places is None else sequence("places", places, "arc lengths, links or pairs of them")
    return Wants(keep, where, measure, workers)


def _check(source: Source, grid: Grid, wants: Wants) -> Case:
    """Reject invalid values; return the first case."""
    first: Case | None = None
    for name, i, point in grid.tried():
        try:
            case = source.case(point)
            times = _times(case)
            if first is None:
                first, times_of_all = case, times
        except (ValueError, TypeError) as error:
            where = f"point {i}" if grid.together else f"parameters[{name!r}][{i}]"
            value = point if grid.together else point[name]
            raise type(error)(f"{where}: got {value!r}: {error}") from None
        if wants.keep == "states" and not np.array_equal(times, times_of_all):
            raise ValueError(
                f"keep: got 'states', expected 'final', or `t_eval`: {name!r} changes the times of the states"
            )
    assert first is not None, "a grid has points"
    return first


def _times(case: Case) -> Array:
    """Times of a run; raises as `simulate_many` does."""
    from ..._lissom import simulate_many

    options = case.options | {"q0": np.zeros((0, case.model.n)), "v0": None}
    if "t_end" not in options:
        raise TypeError("t_end: missing: a model does not say how long it is simulated")
    return simulate_many(case.model, **options).t


def _identity(source: Source, grid: Grid, wants: Wants) -> dict[str, Any]:
    """Data that distinguish a sweep from others."""
    return {
        "model": source.identity(),
        "parameters": [[name, values] for name, values in grid.values.items()],
        "combine": "zip" if grid.together else "product",
        "options": paths.plain(source.options),
        "keep": wants.keep,
        "places": paths.plain(wants.places),
        "measure": paths.plain(wants.measure),
        "version": __version__,
    }


def _kept(store: str | os.PathLike[str] | None, grid: Grid, identity: Mapping[str, Any]) -> Memory:
    if store is None:
        return Memory(grid.size)
    return Zarr(path_of(store, "store"), grid.size, identity)


def _pattern(records: Sequence[Record]) -> Record:
    """The first entry of each kind."""
    pattern: Record = {}
    for record in records:
        pattern = {**record, **pattern}
    return pattern


class _Progress:
    """Reports the number of finished points."""

    def __init__(self, progress: bool | Callable[[int], object], total: int) -> None:
        self._bar: Any = None
        self._progress = progress
        if progress is True:
            from tqdm import tqdm

            self._bar = tqdm(total=total, unit=" runs")
        elif progress is not False and not callable(progress):
            raise TypeError(f"progress: expected a bool or a callable, got {type(progress).__name__}")

    def __enter__(self) -> Callable[[int], None]:
        return self._report

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()

    def _report(self, done: int) -> None:
        if self._bar is not None:
            self._bar.update(done - self._bar.n)
        elif callable(self._progress):
            self._progress(done)


def _dataset(kept: Memory, grid: Grid, first: Case, wants: Wants) -> xarray.Dataset:
    """The stored results as a dataset with named dimensions."""
    import xarray

    arrays = dict(kept.read())
    coordinates: dict[str, Any] = {
        name: (("point" if grid.together else name,), values) for name, values in grid.values.items()
    }
    places = places_of(first.model, wants)
    sizes: dict[str, Any] = {
        "coordinate": [coordinate.name for coordinate in view(first.model).coordinates],
        "place": [_name(place) for place in places or ()],
        "axis": ["x", "y", "z"],
        "time": _times(first),
    }
    data: dict[str, Any] = {}
    for name, values in arrays.items():
        own, title = VARIABLES.get(name, ((), "what was measured"))
        own = ("time", *own) if wants.keep == "states" and name in STATES else own
        if name not in VARIABLES:
            own = tuple(f"{name}_{i}" for i in range(values.ndim - 1))
        for dimension, size in zip(own, values.shape[1:], strict=True):
            if dimension in sizes and len(sizes[dimension]) == size:
                coordinates[dimension] = ((dimension,), sizes[dimension])
        if values.dtype.kind == "S":
            values = np.char.decode(values, "utf-8", "replace")
        shaped = values.reshape(*grid.shape, *values.shape[1:])
        data[name] = ((*grid.dimensions, *own), shaped, {"long_name": title})
    data["is_done"] = (grid.dimensions, kept.done.reshape(grid.shape), {"long_name": "the run was made"})
    return xarray.Dataset(data, coordinates, {"source": f"lissom {__version__}"})


def _name(place: Any) -> str:
    if isinstance(place, str):
        return place
    if isinstance(place, int | float):
        return f"X = {place:g}"
    link, X = place
    return f"{link}, X = {X:g}"
