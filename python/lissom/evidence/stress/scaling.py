"""The same rod at other sizes: what dimensional analysis says must come out."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import numpy as np

from ..._lissom import Rod, modes, statics
from ...results import Array
from . import judge, rods
from .cell import Cell, Group, Outcome

#: Lengths in metres; the rod of one metre is what they are compared with.
LENGTHS = (1e-4, 1e-3, 1e-2, 1e-1, 1e1, 1e2, 1e3)

#: Largest difference of results without dimension: of direct computations and fixed steps, which should
#: differ
#: by rounding only, and of adaptive steps, whose tolerances see the numbers and not their units.
EXACT, ADAPTIVE = 1e-7, 1e-4

#: Seconds of the motion of the rod of one metre, and fixed steps in it.
DURATION, STEPS = 1.0, 500


def similar(length: float) -> Rod:
    """A similar rod: gravity and density are the same, so E goes with the length and times with its root."""
    return rods.rod(
        length=length,
        radius=0.02 * length,
        young_modulus=1e7 * length,
        retardation_time=1e-3 * np.sqrt(length),
    )


def at_rest(length: float) -> Array:
    """The tip in equilibrium, in lengths."""
    rod = similar(length)
    found = statics(rod)
    return np.asarray(rod.pose(found.q, length)[:3, 3] / length) if found.success else np.full(3, np.nan)


def frequencies(length: float) -> Array:
    """Natural frequencies in units of sqrt(g / length), relative to the largest."""
    found = modes(similar(length), np.zeros(5)).eigenvalues * np.sqrt(length)
    return np.asarray(np.sort(np.abs(found)))


def path(length: float, method: str) -> Array:
    """The tip on its way, in lengths."""
    rod = similar(length)
    duration = DURATION * float(np.sqrt(length))
    times = np.linspace(0.0, duration, STEPS + 1)
    # Absolute tolerances are in units of strain, of velocity and of acceleration: too small to count.
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
    """What the others are compared with."""
    return RESULTS[column][0](1.0)


def compared(length: float, column: str) -> Outcome:
    """A result beside that of the rod of one metre."""
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
