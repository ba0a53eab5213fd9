"""The table of largest values."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..._lissom import LissomError, Model
from ...analysis import limits as of_segments
from ...analysis.limits import exceeded
from ...analysis.peaks import Peak, States, largest_of, peaks_of
from ...results.runs import MAX_SHAPES, Made, Run
from . import page
from .text import quantity

if TYPE_CHECKING:
    from ...results.studies import Setting

Array = NDArray[np.float64]


def of_motion(run: Run | Made) -> list[page.Section]:
    """Those of a motion; nothing for a model without rods, actuators and contacts."""
    states = _states(run)
    some = "" if len(states.q) == len(run.t) else f" At {len(states.q):,} of {len(run.t):,} times."
    return _section(_found(_model(run), states), ("t (s)",), some)


def of_equilibrium(setting: Setting, q: Array) -> list[page.Section]:
    """Those of an equilibrium under the whole loads."""
    return _section(_found(setting.model, _at_rest(setting, q)), ())


def exceeded_in_motion(run: Run | Made) -> list[str]:
    """A sentence about each limit of a segment that a motion exceeds."""
    return exceeded(_model(run), _states(run))


def exceeded_at_rest(setting: Setting, q: Array) -> list[str]:
    """A sentence about each limit of a segment that an equilibrium exceeds."""
    return exceeded(setting.model, _at_rest(setting, q))


def _model(run: Run | Made) -> Model:
    return run.scene.model if isinstance(run, Run) else run.model


def _states(run: Run | Made) -> States:
    at = run.instants(MAX_SHAPES)
    return States(run.view, run.q[at], run.v[at], run.a[at], run.clock[at], run.u[at])


def _at_rest(setting: Setting, q: Array) -> States:
    return States.at_rest(setting.view, q, setting.t, setting.u)


def _found(model: Model, states: States) -> list[Peak]:
    try:
        return peaks_of(model, states)
    except (ValueError, LissomError):
        # The last state of a failed run can overflow.
        return []


def _section(peaks: list[Peak], times: tuple[str, ...], some: str = "") -> list[page.Section]:
    found = largest_of(peaks)
    limits = ("limit",) if any(peak.limit is not None for peak in found) else ()
    named = [peak.quantity for peak in found]
    rows = [
        (
            # Rods and tendons have a tension.
            peak.quantity if named.count(peak.quantity) == 1 else f"{peak.quantity} {_where(peak)}",
            _sized(peak.value, peak),
            *("" if peak.limit is None else _sized(peak.limit, peak) for _ in limits),
            peak.part,
            "" if peak.X is None else f"{peak.X:.4g}",
            *(f"{peak.t:.4g}" for _ in times),
        )
        for peak in found
    ]
    columns = ("largest", "value", *limits, "of", "at X (m)", *times)
    caption = (
        "Curvature of bending; stretch and shear relative to rest; strain and stress of the "
        "outermost fibre along the rod; moments and forces in sections by the balance of forces." + some
    )
    table = page.Table(columns, rows, frozenset(columns) - {"largest", "of"}, caption)
    lessons = [page.Lesson(sentence) for sentence in of_segments.sentences(peaks)]
    return [page.Section("Largest values", [*lessons, table])] if rows else []


def _where(peak: Peak) -> str:
    return "of an actuator" if peak.X is None else "in a section"


def _sized(value: float, peak: Peak) -> str:
    return quantity(value, "" if peak.unit == "1" else peak.unit, 4)
