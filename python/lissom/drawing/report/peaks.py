"""The table of largest values."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..._lissom import LissomError, Model
from ...analysis.peaks import States, largest_of, peaks_of
from ...results.runs import MAX_SHAPES, Made, Run
from . import page
from .text import quantity

if TYPE_CHECKING:
    from ...results.studies import Setting

Array = NDArray[np.float64]


def of_motion(run: Run | Made) -> list[page.Section]:
    """Those of a motion; nothing for a model without rods, actuators and contacts."""
    at = run.instants(MAX_SHAPES)
    states = States(run.view, run.q[at], run.v[at], run.a[at], run.clock[at], run.u[at])
    model = run.scene.model if isinstance(run, Run) else run.model
    some = "" if len(at) == len(run.t) else f" At {len(at):,} of {len(run.t):,} times."
    return _section(model, states, ("t (s)",), some)


def of_equilibrium(setting: Setting, q: Array) -> list[page.Section]:
    """Those of an equilibrium under the whole loads."""
    return _section(setting.model, States.at_rest(setting.view, q, setting.t, setting.u), ())


def _section(model: Model, states: States, times: tuple[str, ...], some: str = "") -> list[page.Section]:
    try:
        found = largest_of(peaks_of(model, states))
    except (ValueError, LissomError):
        # The last state of a failed run can overflow.
        return []
    rows = [
        (
            peak.quantity,
            quantity(peak.value, "" if peak.unit == "1" else peak.unit, 4),
            peak.part,
            "" if peak.X is None else f"{peak.X:.4g}",
            *(f"{peak.t:.4g}" for _ in times),
        )
        for peak in found
    ]
    columns = ("largest", "value", "of", "at X (m)", *times)
    caption = (
        "Curvature of bending; stretch and shear relative to rest; strain and stress of the "
        "outermost fibre along the rod; moments and forces in sections by the balance of forces." + some
    )
    table = page.Table(columns, rows, frozenset(columns) - {"largest", "of"}, caption)
    return [page.Section("Largest values", [table])] if rows else []
