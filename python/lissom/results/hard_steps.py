"""Where a run spends its evaluations, in words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from .._lissom import HardSteps, MotionResult

#: Why steps were attempted again, in words.
REASONS = {
    "not_converged": "Newton's method did not converge",
    "singular": "a singular Jacobian",
    "non_finite": "a number that is not finite",
    "error": "an error estimate above the tolerance",
    "impact": "an impact",
    "missed": "a contact or stop within the step",
    "invalid_end": "an invalid end, such as surfaces deep in each other",
    "passed_through": "surfaces would have passed through each other",
    "energy_gain": "a gain of energy",
    "event": "a tendon became slack or taut",
    "in_parts": "made in parts like the step before",
    "slow_convergence": "slow convergence of Newton's method",
}

#: A smaller share of the evaluations in hard steps says nothing of why a run is slow.
LEAST_SHARE = 0.1

#: The time that is named has this part of the evaluations of hard steps.
NAMED_PART = 0.8

#: Most reasons and contacts that are named, the most expensive ones.
MOST_NAMED = 3


def where_spent(motion: MotionResult) -> str | None:
    """Which steps take much of the work of a run, when and why; None if it is spread over all steps."""
    hard = motion.hard_steps
    if hard is None or len(hard) == 0:
        return None
    share = hard.evaluations.sum() / max(motion.stats.nfev, 1)
    if share < LEAST_SHARE:
        return None
    start, end = _shortest(hard)
    reasons = [f"{REASONS[name]} ({hard.reasons.count(name)})" for name in _dearest(hard, hard.reasons)]
    contacts = [f"'{name}'" for name in _dearest(hard, hard.contacts)]
    touching = f"; contact {', '.join(contacts)}" if contacts else ""
    return (
        f"{share:.0%} of the evaluations in {len(hard):,} of {motion.stats.steps:,} steps, most from "
        f"{start:.4g} s to {end:.4g} s: {', '.join(reasons)}{touching}"
    )


def _dearest(hard: HardSteps, names: Sequence[str | None]) -> list[str]:
    """The names whose steps take most evaluations, the most expensive one first."""
    cost: Counter[str] = Counter()
    for name, evaluations in zip(names, hard.evaluations.tolist(), strict=True):
        if name is not None:
            cost[name] += evaluations
    return [name for name, _ in cost.most_common(MOST_NAMED)]


def _shortest(hard: HardSteps) -> tuple[float, float]:
    """The shortest time whose hard steps have `NAMED_PART` of the evaluations of all of them."""
    before = np.concatenate([[0], np.cumsum(hard.evaluations)])
    # For each first step the last one, where there is one.
    last = np.searchsorted(before, before[:-1] + NAMED_PART * before[-1]) - 1
    first = np.flatnonzero(last < len(hard))
    ends = hard.t[last[first]] + hard.dt[last[first]]
    best = int(np.argmin(ends - hard.t[first]))
    return float(hard.t[first[best]]), float(ends[best])
