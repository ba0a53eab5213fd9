"""The same rod at other sizes, compared by dimensional analysis."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import numpy as np

from ...._lissom import Rod, modes, statics
from ....results.runs import Array
from . import judge, rods
from .cell import Cell, Group, Outcome

#: Lengths in metres; the reference has one metre.
LENGTHS = (1e-4, 1e-3, 1e-2, 1e-1, 1e1, 1e2, 1e3)

#: Tolerances of dimensionless results: for direct computations and fixed steps, which should differ only by
#: rounding, and for adaptive steps, whose tolerances depend on numbers rather than units.
EXACT, ADAPTIVE = 1e-7, 1e-4

#: Duration in seconds of the motion of the reference rod, and number of fixed steps.
DURATION, STEPS = 1.0, 500


def similar(length: float) -> Rod:
    """A similar rod: with equal gravity and density, E is proportional to the length, and times to its square
    root."""
    return rods.rod(
        length=length,
        radius=0.02 * length,
        young_modulus=1e7 * length,
        retardation_time=1e-3 * np.sqrt(length),
    )


def at_rest(length: float) -> Array:
    """Tip position at equilibrium in units of the length."""
    rod = similar(length)
    found = statics(rod, space_error=False)
    return np.asarray(rod.pose(found.q, length)[:3, 3] / length) if found.success else np.full(3, np.nan)


def frequencies(length: float) -> Array:
    """Natural frequencies in units of sqrt(g / length), relative to the largest."""
    found = modes(similar(length), np.zeros(5)).eigenvalues * np.sqrt(length)
    return np.asarray(np.sort(np.abs(found)))


def path(length: float, method: str) -> Array:
    """Path of the tip in units of the length."""
    rod = similar(length)
    duration = DURATION * float(np.sqrt(length))
    times = np.linspace(0.0, duration, STEPS + 1)
    # Absolute tolerances have units of strain, velocity and acceleration: make them negligible.
    options = {"rtol": 1e-9, "atol": 1e-30} if method in FIXED else judge.tolerances(rod, 1e-7)
    if method in FIXED:
        options["dt"] = duration / STEPS
    motion = judge.run(rod, duration, method=method, t_eval=times, **options)
    return judge.tip(rod, motion) / length if motion.success else np.full((1, 3), np.nan)


FIXED = ("newmark", "generalised_alpha")

RESULTS: dict[str, tuple[Callable[[float], Array], float]] = {
    "statics": (at_rest, EXACT),
    "modes": (frequencies, EXACT),
    "newmark": (partial(path, method="newmark"), EXACT),
    "generalised_alpha": (partial(path, method="generalised_alpha"), EXACT),
    "radau": (partial(path, method="radau"), ADAPTIVE),
    "rk45": (partial(path, method="rk45"), ADAPTIVE),
}


@cache
def of_one_metre(column: str) -> Array:
    """Result of the reference rod."""
    return RESULTS[column][0](1.0)


def compared(length: float, column: str) -> Outcome:
    """Comparison with the reference rod."""
    compute, tolerance = RESULTS[column]
    found, right = compute(length), of_one_metre(column)
    if not np.isfinite(right).all():
        return Outcome("failed", "the rod of one metre does not get to the end")
    if not np.isfinite(found).all():
        return Outcome("failed", "does not get to the end, other than the rod of one metre")
    error = float(np.abs(found - right).max() / np.abs(right).max())
    if not error <= tolerance:
        return Outcome("wrong", f"differs from the rod of one metre by {error:.1e}", error)
    return Outcome("accurate", "beside the rod of one metre", error)


def group() -> Group:
    """Lengths over seven orders of magnitude."""
    return Group(
        "scaling",
        "Length scales",
        "length (m)",
        "result, without dimension",
        [
            Cell(f"{length:.0e}", column, partial(compared, length, column), quick=length in (1e-4, 1e3))
            for length in LENGTHS
            for column in RESULTS
        ],
        "Similar rods: radius and Young's modulus go with the length, times with its root. Results without "
        "dimension "
        f"must be those of the rod of one metre: to {EXACT:g} for fixed steps, equilibria and frequencies, "
        "to "
        f"{ADAPTIVE:g} for adaptive steps.",
    )
