"""Time steps from a microsecond to a second, for the lab's wire and for a soft spatial arm."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import numpy as np

from ...._lissom import MotionResult, Rod
from ....results.runs import Array
from ..lab.rod import WIRE
from . import judge, rods
from .cell import Cell, Group, Outcome

STEPS = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0)

#: Maximum duration in seconds, and maximum number of steps.
DURATION, MOST = 3.0, 20_000

#: Number of instants at which motions are compared.
INSTANTS = 51

FIXED = ("newmark", "generalised_alpha")
ADAPTIVE = ("radau", "rk45")


def wire() -> Rod:
    """The lab's scene: a steel wire released from horizontal."""
    return rods.rod(WIRE)


def arm() -> Rod:
    """A soft arm that bends, twists and stretches under a force out of its plane."""
    modes = {"torsion": 2, "bend_y": 2, "bend_z": 2, "stretch": 1}
    return rods.rod(radius=(0.02, 0.01), modes=modes, of_rod={"tip_force": (0.0, 0.2, 0.0)})


@cache
def _right(make: Callable[[], Rod], duration: float) -> tuple[Array, MotionResult | None]:
    times = np.linspace(0.0, duration, INSTANTS)
    return times, judge.reference(make(), times)


def _cell(make: Callable[[], Rod], method: str, dt: float) -> Outcome:
    rod = make()
    times, right = _right(make, min(DURATION, MOST * dt))
    if method in ADAPTIVE:
        return judge.adaptive(rod, times, right, method, max_step=dt, max_steps=2 * MOST)
    if dt >= times[1]:
        # Compare only at ends of steps, because interpolation has its own error.
        times = np.append(np.arange(0.0, times[-1], dt), times[-1])
        right = judge.reference(rod, times)
    return judge.fixed(rod, times, right, method, dt)


def _group(name: str, title: str, make: Callable[[], Rod], text: str) -> Group:
    cells = [
        Cell(f"{dt:.0e}", method, partial(_cell, make, method, dt), quick=dt >= 1e-3)
        for dt in STEPS
        for method in (*FIXED, *ADAPTIVE)
    ]
    return Group(
        name,
        title,
        "step (s)",
        "method",
        cells,
        text
        + f" For {DURATION:g} s, but {MOST:,} steps at most. Radau and RK45 choose their steps; here they "
        "are no "
        "longer than the step given.",
        "Fixed steps that are too long are not refused: what they lose is in no status. The energy balance, "
        "or "
        'method="auto", tells.',
    )


def wire_group() -> Group:
    """The lab's scene."""
    return _group("steps_wire", "Time steps: the lab's wire", wire, "A steel wire let go from horizontal.")


def arm_group() -> Group:
    """The soft arm."""
    return _group("steps_arm", "Time steps: a soft arm in space", arm, "It bends, twists and stretches.")
