"""Energy drift in runs of up to a million steps."""

from __future__ import annotations

from functools import cache, partial
from typing import Any

import numpy as np

from ...._lissom import Model, MotionResult, SpringPendulum
from ....results.runs import Array
from ..lab.rod import WIRE
from . import judge, rods
from .cell import Cell, Group, Outcome

#: Largest change of the energy over a run, relative to the energy that moves.
DRIFT_TOLERANCE = 1e-2

#: Time in seconds at which the motion of the chaotic pendulum is compared, and the largest error at this
#: time.
SHORT, SHORT_TOLERANCE = 3.0, 1e-2

#: Number of instants at which energies are evaluated.
INSTANTS = 1001

Start = dict[str, Any]

#: Model, initial state, step in seconds.
CASES: dict[str, tuple[Model, Start, float]] = {
    "chaotic pendulum": (SpringPendulum(), {"q0": [-0.8, 0.5]}, 1e-2),
    "pendulum, small motion": (SpringPendulum(), {"q0": [0.01, 0.99]}, 1e-2),
    "undamped wire": (rods.rod(WIRE, retardation_time=0.0), {}, 5e-4),
    "undamped rod, all strains": (rods.undamped(rods.rod()), {}, 1e-4),
}

LENGTHS = (10_000, 100_000, 1_000_000)
METHODS = ("newmark", "generalised_alpha")


def energy(case: str, method: str, steps: int) -> Outcome:
    """Energy of an undamped run, after a check of its first seconds."""
    model, state, dt = CASES[case]
    times = np.linspace(0.0, steps * dt, INSTANTS)
    motion = judge.run(model, times[-1], method=method, dt=dt, t_eval=times, **state)
    if not motion.success:
        return judge.failure(motion)
    cost = motion.stats.nfev
    if not np.isfinite(motion.q).all():
        return Outcome("wrong", "the states are not finite", None, cost)
    early = short_error(case, method)
    if early is None:
        return Outcome("failed", f"nothing to compare with after {judge.DEADLINE:g} s", None, cost)
    if early > SHORT_TOLERANCE:
        return Outcome("wrong", f"off by {early:.1e} after {SHORT:g} s", early, cost)
    drift = judge.defect(motion)
    if not drift <= DRIFT_TOLERANCE:
        return Outcome("failed", f"the energy changes by {drift:.1e}, as the run's balance says", drift, cost)
    return Outcome(
        "accurate", f"energy over {steps:,} steps; off by {early:.1e} after {SHORT:g} s", drift, cost
    )


def short_error(case: str, method: str) -> float | None:
    """Largest error in the first seconds, relative to the largest coordinate; None if a run fails."""
    model, state, dt = CASES[case]
    times, right = first_seconds(case)
    found = judge.run(model, SHORT, method=method, dt=dt, t_eval=times, **state)
    if not (found.success and right.success):
        return None
    return float(np.abs(found.q - right.q).max() / np.abs(right.q).max())


@cache
def first_seconds(case: str) -> tuple[Array, MotionResult]:
    """Times, and the motion by a method of high order, which both methods are compared with."""
    model, state, _ = CASES[case]
    times = np.linspace(0.0, SHORT, INSTANTS)
    return times, judge.run(model, SHORT, method="radau", rtol=1e-9, atol=1e-11, t_eval=times, **state)


def group() -> Group:
    """Energy drift."""
    return Group(
        "long_runs",
        "Long runs",
        "model",
        "method, steps",
        [
            Cell(case, f"{method}, {steps:.0e}", partial(energy, case, method, steps), quick=steps == 10_000)
            for case in CASES
            for steps in LENGTHS
            for method in METHODS
        ],
        "Undamped, fixed steps. The energy is judged over the whole run, the states over the first "
        f"{SHORT:g} s only: the pendulum is chaotic, and errors of phase add up in every motion. The error "
        "shown is the "
        "largest change of the energy, relative to the energy that moves.",
        "Generalised-alpha takes energy out by design; average acceleration keeps it within bounds.",
    )
