"""Limits of segments that a result exceeds, as sentences of its message."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .._lissom import LissomError
from ..model.views import view
from .peaks import Peak, States, has_limit, peaks_of_rod

if TYPE_CHECKING:
    from .._lissom import Model, MotionResult

Array = NDArray[np.float64]

#: A motion is looked at in at most this many of its times, as in the tables of reports.
MOST_TIMES = 2000

#: Arguments of segments that limit a quantity.
ARGUMENTS = {"curvature": "min_bend_radius", "axial strain": "max_strain", "axial stress": "max_stress"}


def sentences(peaks: Sequence[Peak]) -> list[str]:
    """A sentence about each peak beyond its limit."""
    return [
        f"Beyond `{ARGUMENTS[peak.quantity]}`, {peak.share:.3g} times what is allowed: {peak}."
        for peak in peaks
        if peak.share is not None and peak.share > 1.0
    ]


def exceeded(model: Model, states: States) -> list[str]:
    """Sentences about limits that states exceed, for the largest value and the one furthest beyond."""
    # What has overflowed at the end of a failed run is beyond anything.
    finite = np.isfinite(states.q).all(axis=1) & np.isfinite(states.v).all(axis=1)
    states = states.at(np.flatnonzero(finite & np.isfinite(states.a).all(axis=1)))
    rods = [link for link in states.view.links if any(has_limit(segment) for segment in link.segments)]
    if not rods or len(states.q) == 0:
        return []
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            return sentences([peak for link in rods for peak in peaks_of_rod(model, link, states)])
    except (ValueError, LissomError):
        # The last state of a failed run can be so large that its forces are not numbers.
        return []


def exceeded_by_motion(result: MotionResult) -> list[str]:
    """Sentences about limits that a motion exceeds at its times, or at many of them."""
    model = result.model
    if model is None:
        return []
    at = np.linspace(0, len(result.t) - 1, min(len(result.t), MOST_TIMES)).round().astype(np.intp)
    return exceeded(
        model, States(view(model), result.q[at], result.v[at], result.a[at], result.t[at], result.u[at])
    )


def exceeded_at_rest(model: Model, q: Array, t: float, u: Array) -> list[str]:
    """A sentence about each limit that an equilibrium exceeds."""
    return exceeded(model, States.at_rest(view(model), q, t, u))
