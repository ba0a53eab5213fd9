"""Equilibria of a model under many inputs, from many starts, or of many models."""

from __future__ import annotations

import operator
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import (
    AccuracyWarning,
    Model,
    StaticsResult,
    check_model,
    finite_array,
    inputs_by_name,
    machine,
    statics,
)
from ..common.arguments import flag, keywords, number, suggesting, whole
from ..common.elsewhere import no_attribute
from .base import ReadOnly
from .doubts import without_doubts
from .equilibria import OF_STATICS

if TYPE_CHECKING:
    from ..common.arguments import InputRows

Array = NDArray[np.float64]

#: Options that are those of `statics`.
OPTIONS = (*OF_STATICS, "stability", "space_error")


_POSES = (
    "`model.pose(found.q)` has the poses of the tips: their positions are `model.pose(found.q)[:, :3, 3]`"
)
_OF_ROWS = "`found[i]` is the `StaticsResult` of row i, which has it"

#: What to use in place of attributes that results of many rows do not have.
INSTEAD: Mapping[str, str] = {
    **dict.fromkeys(("tip", "tips", "pose", "poses", "position", "positions"), _POSES),
    "x": "coordinates are `q`, one row each",
    "y": "coordinates are `q`, one row each",
    "plot": "`found[i].plot(model)` draws the shape of row i",
    "picture": "`found[i].picture(path, model)` draws the shape of row i",
    "report": "`found[i].report(path, model)` writes the page of row i",
    "animate": "rows have no times: `found[i].picture(path, model)` draws one of them",
    "save": "`found[i].save(path)` saves row i, `numpy.savez(path, q=found.q, u=found.u)` all coordinates",
    "to_xarray": "`found[i].to_xarray()` makes the dataset of row i",
    **dict.fromkeys(("slack", "stability", "lowest_eigenvalue", "space_error", "peaks", "path"), _OF_ROWS),
    "energy": "`model.energy(q, 0 * q)` of a row `q` of `found.q` has the energies",
}


@dataclass(frozen=True, eq=False, repr=False)
class EquilibriaResult(ReadOnly):
    """Equilibria, one per row.

    ``found[i]`` is the `StaticsResult` of row i, with `slack`, `space_error`, `peaks`, `picture`, `report`.

    Attributes
    ----------
    q : ndarray, shape (k, n)
        Coordinates; where no equilibrium was found, those at which the search ended. NaN in rows that Ctrl-C
        left out.
    success : ndarray of bool, shape (k,)
        Whether an equilibrium was found.
    status : ndarray of str, shape (k,)
        As of `StaticsResult`, or 'not_run' after Ctrl-C.
    message : tuple of str
        The statuses in words.
    is_stable : tuple of (bool or None)
        As of `StaticsResult`.
    residual_norm : ndarray, shape (k,)
        As of `StaticsResult`.
    nit : ndarray of int, shape (k,)
        Numbers of iterations.
    u : ndarray, shape (k, m)
        Inputs of each row.
    """

    # Pickles refer to the class by this module.
    __module__ = "lissom"

    q: Array
    success: NDArray[np.bool_]
    status: NDArray[np.str_]
    message: tuple[str, ...]
    is_stable: tuple[bool | None, ...]
    residual_norm: Array
    nit: NDArray[np.int64]
    u: Array
    _rows: tuple[StaticsResult | None, ...]

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            no_attribute(self, name, INSTEAD)

    def __len__(self) -> int:
        return len(self.q)

    def __getitem__(self, row: int) -> StaticsResult:
        try:
            found = self._rows[operator.index(row)]
        except TypeError:
            raise TypeError(f"row: expected a whole number, got {type(row).__name__}") from None
        except IndexError:
            raise IndexError(f"row: got {row}, expected one of {len(self)} rows") from None
        if found is None:
            raise LookupError(f"row: {row} was not run, because of Ctrl-C")
        return found

    def __repr__(self) -> str:
        found = int(self.success.sum())
        return f"<EquilibriaResult: {found} of {len(self)} equilibria found, n = {self.q.shape[1]}>"


@suggesting
def statics_many(
    model: Model | Iterable[Model],
    u: InputRows | None = None,
    q0: ArrayLike | None = None,
    *,
    t: float = 0.0,
    follow: bool = False,
    workers: int | None = None,
    **options: Any,
) -> EquilibriaResult:
    """Find many equilibria: of a model under many inputs, from many starts, or of many models.

    Every row is what `statics` finds, in threads; or, with `follow`, a quasi-static motion.

    Parameters
    ----------
    model : Model, or iterable of Model
        A model for all rows, or one for each. All must have the same number of coordinates.
    u : array_like, shape (k, m) or (m,), or dict, optional
        Inputs of each row, or in shape (m,) of all; by default those that are the inputs' defaults. Some of
        them by name: a dict for each row, or one dict whose values have rows, such as
        ``{"pull": [1, 2, 3]}``.
    q0 : array_like, shape (n,) or (k, n), optional
        Start of all rows, or of each, as for `statics`.
    t : float
        Time, seconds, as for `statics`.
    follow : bool
        Start each row at the equilibrium of the one before, as when inputs change slowly from row to row.
        This is faster for rows that are near each other. Where a model has several equilibria, the row then
        stays on the branch on which it is; by itself `statics` comes from the rest. Rows after one without
        equilibrium start as the first.
    workers : int, optional
        Number of threads; by default as many as the processor has. Results do not depend on it. With `follow`
        rows come one after the other.
    **options
        `method`, `load_steps`, `tol`, `max_iter`, `max_steps`, `stability`, `space_error` as for `statics`.

    Returns
    -------
    EquilibriaResult
        `q` of shape (k, n), `success`, `status`, `message` and more; ``found[i]`` is the result of row i.
        Rows without equilibrium do not raise.

    Warns
    -----
    AccuracyWarning
        Once, with the number of rows whose modes or nodes leave a doubtful error, and the largest of these.

    Raises
    ------
    ValueError, TypeError
        Before the first row, if an argument is invalid; with the number of the row if it is one of a row.
    KeyboardInterrupt
        On Ctrl-C. Its attribute `result` is the EquilibriaResult with the rows until then.

    Examples
    --------
    >>> import lissom, numpy as np
    >>> finger = lissom.Segment(0.2, 0.01, 3e5, poisson_ratio=0.45, density=1100, modes={"bend_y": 3})
    >>> pull = lissom.Tendon("pull", [lissom.Along(offset=(0, 0.006))], tension=lissom.Input("pull", 0.0))
    >>> rod = lissom.Rod([finger], actuators=[pull])
    >>> found = lissom.statics_many(rod, {"pull": np.linspace(0, 4, 100)})
    >>> found
    <EquilibriaResult: 100 of 100 equilibria found, n = 3>
    >>> rod.pose(found.q)[:, :3, 3].shape  # tips
    (100, 3)
    """
    keywords("statics_many", options, ("u", "q0", "t", "follow", "workers", *OPTIONS))
    models = _models(model)
    n = models[0].n
    inputs = np.array([one.u0 for one in models]) if u is None else inputs_by_name(u, models)
    names = models[0].inputs
    inputs = inputs if u is None else finite_array(inputs, "u")
    # One row of inputs is for all rows, as of `simulate_many`.
    is_of_all = inputs.shape == (len(names),)
    if u is not None and not is_of_all:
        inputs = _input_rows(inputs, names)
    starts = None if q0 is None else finite_array(q0, "q0")
    if starts is not None and starts.ndim != 1:
        starts = _rows("q0", starts, n, "coordinates")
    elif starts is not None and starts.shape != (n,):
        raise ValueError(f"q0: got shape {starts.shape}, expected ({n},) or (k, {n})")
    count = _count(models, None if u is None or is_of_all else inputs, starts)
    inputs = np.broadcast_to(inputs, (count, len(models[0].inputs))).copy()
    time, follows = number("t", t), flag("follow", follow)
    if workers is not None and whole("workers", workers) < 1:
        raise ValueError(f"workers: got {workers!r}, expected a whole number > 0")

    def row(i: int, start: Array | None) -> StaticsResult:
        one = models[i if len(models) > 1 else 0]
        try:
            return statics(one, start, t=time, u=None if u is None else inputs[i], **options)
        except (ValueError, TypeError) as error:
            raise type(error)(f"row {i}: {error}") from None

    def start(i: int) -> Array | None:
        return starts[i] if starts is not None and starts.ndim == 2 else starts

    found: list[StaticsResult | None] = [None] * count

    def fill() -> None:
        if follows:
            last = None
            for i in range(count):
                found[i] = one = row(i, start(i) if last is None else last)
                last = one.q if one.success else None
        else:
            for i, one in enumerate(_in_threads(lambda i: row(i, start(i)), count, workers)):
                found[i] = one

    try:
        _, doubts = without_doubts(fill)
    except KeyboardInterrupt as error:
        error.result = _collected(found, n, inputs)  # type: ignore[attr-defined]
        raise
    result = _collected(found, n, inputs)
    if doubts:
        _warn(doubts, result)
    return result


def _warn(doubts: list[str], result: EquilibriaResult) -> None:
    """One warning for all rows, with the doubt of the one whose modes lack most."""
    lacking = [row for row in result._rows if row is not None and row.space_error is not None]
    worst = max(lacking, key=lambda row: row.space_error.relative if row.space_error else 0.0, default=None)
    largest = next((doubt for doubt in doubts if worst is not None and doubt in worst.message), doubts[0])
    try:
        warnings.warn(f"{len(doubts)} of {len(result)} rows: {largest}", AccuracyWarning, stacklevel=4)
    except AccuracyWarning as raised:  # where warnings are errors
        raised.result = result  # type: ignore[attr-defined]
        raise


def _in_threads(function: Any, count: int, workers: int | None) -> Iterator[StaticsResult]:
    """Results in order; threads that have not begun are cancelled where one fails."""
    with ThreadPoolExecutor(workers or machine()[1]) as executor:
        try:
            # The first alone, so that what is wrong with all rows is raised at once.
            yield function(0)
            yield from executor.map(function, range(1, count))
        except BaseException:
            executor.shutdown(wait=True, cancel_futures=True)
            raise


def _models(model: Any) -> list[Model]:
    if isinstance(model, Model):
        return [model]
    try:
        models = [] if isinstance(model, str) else list(model)
    except TypeError:
        models = []
    for i, one in enumerate(models):
        check_model(one, f"model[{i}]")
        if one.n != models[0].n or one.inputs != models[0].inputs:
            raise ValueError(
                f"model[{i}]: got one with {one.n} coordinates and {len(one.inputs)} inputs, expected those "
                f"of model[0]: {models[0].n} and {len(models[0].inputs)}"
            )
    if not models:
        check_model(model, "model")
    return models


def _rows(name: str, values: ArrayLike, width: int, what: str) -> Array:
    rows = finite_array(values, name)
    if rows.ndim != 2 or rows.shape[1] != width or not len(rows):
        raise ValueError(f"{name}: got shape {rows.shape}, expected (k, {width}): (rows, {what})")
    return rows


def _input_rows(inputs: Array, names: Sequence[str]) -> Array:
    """Rows of inputs; for other shapes a message with the right ones."""
    if inputs.ndim == 2 and inputs.shape[1] == len(names) and len(inputs):
        return inputs
    if not names:
        raise ValueError(
            "u: the model has no inputs: leave `u` out, or give loads or actuators a lissom.Input"
        )
    width = len(names)
    listed = f"the inputs {', '.join(map(repr, names))}" if width > 1 else f"the input '{names[0]}'"
    column = f"; numpy.reshape(u, (-1, 1)) or {{'{names[0]}': u}} has a row for each number"
    raise ValueError(
        f"u: got shape {inputs.shape}, expected (k, {width}): a row of {listed} for each of k equilibria, "
        f"or ({width},) for all" + (column if width == 1 and inputs.ndim == 1 else "")
    )


def _count(models: list[Model], inputs: Array | None, starts: Array | None) -> int:
    """The number of rows on which models, inputs and starts agree."""
    counts = {"model": len(models)} if len(models) > 1 else {}
    if inputs is not None:
        counts["u"] = len(inputs)
    if starts is not None and starts.ndim == 2:
        counts["q0"] = len(starts)
    if len(set(counts.values())) > 1:
        listed = ", ".join(f"{count} of {name}" for name, count in counts.items())
        raise ValueError(f"{list(counts)[-1]}: got {listed}, expected as many rows of each")
    return next(iter(counts.values()), 1)


def _collected(found: list[StaticsResult | None], n: int, u: Array) -> EquilibriaResult:
    return EquilibriaResult(
        q=np.array([np.full(n, np.nan) if one is None else one.q for one in found]).reshape(len(found), n),
        success=np.array([one is not None and one.success for one in found]),
        status=np.array(["not_run" if one is None else one.status for one in found]),
        message=tuple("Not run." if one is None else one.message for one in found),
        is_stable=tuple(None if one is None else one.is_stable for one in found),
        residual_norm=np.array([np.nan if one is None else one.residual_norm for one in found]),
        nit=np.array([0 if one is None else one.nit for one in found]),
        u=u,
        _rows=tuple(found),
    )
