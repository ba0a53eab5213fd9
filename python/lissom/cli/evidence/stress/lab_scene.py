"""The lab's wire with both of its bases, by the lab's kinds of methods."""

from __future__ import annotations

from functools import cache, partial

import numpy as np

from ...._lissom import MotionResult
from ....results.runs import Array
from ..lab.rod import BASES, DURATION, lab_rod, mass_matrices, tip_motion
from . import judge
from .cell import Cell, Group, Outcome

#: Steps of the implicit methods, seconds.
STEPS = (1.0, 1e-1, 1e-2, 1e-3)

#: Tolerated motion of the hanging wire's tip, in metres: the base's quaternion has seven digits.
STILL = 1e-5

#: Number of instants at which motions are compared.
INSTANTS = 301


@cache
def _right(base: str) -> tuple[Array, MotionResult | None]:
    times = np.linspace(0.0, DURATION, INSTANTS)
    return times, judge.reference(lab_rod(base), times)


def implicit(base: str, dt: float) -> Outcome:
    """Newmark's method, compared at its own steps."""
    rod = lab_rod(base)
    times, right = _right(base)
    if dt > times[1]:
        times = np.linspace(0.0, DURATION, round(DURATION / dt) + 1)
        right = judge.reference(rod, times)
    outcome = judge.fixed(rod, times, right, "newmark", dt)
    return _still(base, judge.run(rod, DURATION, dt=dt), outcome)


def explicit(base: str, method: str) -> Outcome:
    """An explicit method with the forward dynamics."""
    rod = lab_rod(base)
    times, right = _right(base)
    outcome = judge.adaptive(rod, times, right, method)
    return _still(base, judge.run(rod, DURATION, method=method), outcome)


def _still(base: str, motion: MotionResult, outcome: Outcome) -> Outcome:
    if base == "hanging" and outcome.kind == "accurate":
        moved = tip_motion(lab_rod(base), motion)
        if moved > STILL:
            return Outcome("wrong", f"hanging is an equilibrium, but the tip moves by {moved:.1e} m", moved)
    return outcome


def explanation() -> str:
    """Why the report's explicit run never ended, with the correction."""
    rod = lab_rod("horizontal")
    _, right = _right("horizontal")
    if right is None:
        return ""
    conditions, determinants = mass_matrices(rod, right.q)
    return (
        f"The determinant of the mass matrix is {determinants.min():.1e} to {determinants.max():.1e} "
        "because the wire is "
        f"light, which says nothing: its condition number is {conditions.min():.0f} to "
        f"{conditions.max():.0f}, so it is far "
        "from singular, and the explicit method ends once the stiffness and the damping are in its forward "
        "model."
    )


def group() -> Group:
    """Both bases."""
    rows = {
        **{f"implicit, step {dt:g} s": partial(implicit, dt=dt) for dt in STEPS},
        **{f"explicit, {method}": partial(explicit, method=method) for method in ("rk45", "dop853")},
    }
    return Group(
        "lab",
        "The lab's scenes",
        "method",
        "initial configuration",
        [Cell(row, base, partial(work, base), quick=True) for row, work in rows.items() for base in BASES],
        "The steel wire let go from horizontal, and hanging, which is its equilibrium.",
        explanation(),
    )
