"""Analyses of every rod of a sweep: its equilibrium, its modes, and its motion by four methods."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache, partial

import numpy as np

from ...._lissom import MotionResult, Rod, modes, statics
from ....results.runs import Array
from . import judge, rods
from .cell import Cell, Outcome

#: Duration of motions in periods of the slowest mode of the unloaded rod, or of a pendulum of its length.
PERIODS = 1.0

#: Number of fixed steps per period.
STEPS_PER_PERIOD = 1000

#: Number of instants at which motions are compared.
INSTANTS = 101

GRAVITY = 9.81

Make = Callable[[], Rod]


def duration(rod: Rod) -> float:
    """Shorter one of the slowest period of the unloaded rod and that of the pendulum, seconds."""
    slowest = float(modes(rod, np.zeros(rod.n)).frequency.min())
    pendulum = 2.0 * np.pi * np.sqrt(rod.length / GRAVITY)
    return min(1.0 / slowest if slowest > 0.0 else np.inf, float(pendulum))


@cache
def _release(make: Make) -> tuple[Array, MotionResult | None]:
    """Release of a rod from its unloaded shape: times, and reference solution."""
    rod = make()
    times = np.linspace(0.0, PERIODS * duration(rod), INSTANTS)
    return times, judge.reference(rod, times)


def equilibrium(make: Make) -> Outcome:
    """Equilibrium from the unloaded state."""
    rod = make()
    return judge.equilibrium(rod, statics(rod, space_error=False))


def frequencies(make: Make) -> Outcome:
    """Frequencies about the unloaded shape, without damping."""
    rod = rods.undamped(make())
    straight = np.zeros(rod.n)
    return judge.vibrations(rod, straight, modes(rod, straight))


def requested(make: Make) -> Outcome:
    """Motion to a requested accuracy."""
    return judge.requested(make(), *_release(make))


def adaptive(make: Make, method: str) -> Outcome:
    """Motion with adaptive steps."""
    return judge.adaptive(make(), *_release(make), method)


def fixed(make: Make, method: str) -> Outcome:
    """Motion with fixed steps."""
    times, right = _release(make)
    return judge.fixed(make(), times, right, method, float(times[-1]) / (PERIODS * STEPS_PER_PERIOD))


ANALYSES: dict[str, Callable[[Make], Outcome]] = {
    "statics": equilibrium,
    "modes": frequencies,
    "auto": requested,
    "newmark": partial(fixed, method="newmark"),
    "generalised_alpha": partial(fixed, method="generalised_alpha"),
    "radau": partial(adaptive, method="radau"),
    "rk45": partial(adaptive, method="rk45"),
}

TEXT = (
    "Let go from the unloaded shape under gravity, for a period of the slowest mode or of a pendulum of the "
    "rod's length, whichever is shorter; the tip is compared with a run of high order and tight tolerances "
    "on the "
    "same modes. Equilibria are judged by the balance of forces and the eigenvalues of the stiffness, "
    "frequencies "
    "by those that NumPy finds."
)


def cells(rods: Iterable[tuple[str, Make]], quick: Iterable[str] = ()) -> list[Cell]:
    """All analyses of the rods; the short run contains the rows named in ``quick``."""
    short = set(quick)
    return [
        Cell(row, column, partial(analysis, make), quick=row in short)
        for row, make in rods
        for column, analysis in ANALYSES.items()
    ]
