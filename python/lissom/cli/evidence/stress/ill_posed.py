"""Invalid input, and physically impossible input."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ...._lissom import Rod, Segment, modes, statics
from ..lab.rod import WIRE
from . import judge, rods
from .cell import Cell, Group, Outcome

VALUES = {"NaN": math.nan, "infinite": math.inf, "zero": 0.0, "negative": -1.0}

#: Parameters that may be zero: damping and tip mass.
MAY_BE_ZERO = frozenset({"retardation_time", "tip_mass"})

SEGMENT_PARAMETERS = ("length", "radius", "young_modulus", "shear_modulus", "density", "retardation_time")

#: Coordinates far outside the range of a rod of one metre.
SHAPES = {
    "q0 NaN": math.nan,
    "q0 infinite": math.inf,
    "q0 1e4": 1e4,
    "q0 1e8": 1e8,
    "q0 1e16": 1e16,
    "q0 1e100": 1e100,
    "q0 1e300": 1e300,
}
SPEEDS = {"v0 NaN": math.nan, "v0 1e4": 1e4, "v0 1e8": 1e8, "v0 1e100": 1e100, "v0 1e300": 1e300}

#: Other invalid arguments.
ARGUMENTS: dict[str, dict[str, Any]] = {
    "duration NaN": {"t_end": math.nan},
    "duration infinite": {"t_end": math.inf},
    "duration negative": {"t_end": -1.0},
    "step NaN": {"dt": math.nan},
    "step zero": {"dt": 0.0},
    "rtol NaN": {"rtol": math.nan},
    "rtol negative": {"rtol": -1e-3},
    "q0 too short": {"q0": [0.0]},
}

METHODS = ("newmark", "generalised_alpha", "radau", "rk45", "auto")

#: Cases of the short run; with the others "auto" works until the deadline.
QUICK = frozenset({*ARGUMENTS, "q0 NaN", "q0 infinite", "q0 1e300", "v0 NaN", "v0 1e300"})

#: Duration of the motions in seconds, and the limit of adaptive steps.
DURATION, MOST_STEPS = 0.1, 2_000


def built(parameter: str, value: float) -> Outcome:
    """Create a rod with such a parameter."""
    if parameter in SEGMENT_PARAMETERS:
        Rod([Segment(**(WIRE | {parameter: value}))])
    else:
        of_rod: dict[str, Any] = {parameter: (0.0, 0.0, value) if parameter == "gravity" else value}
        Rod([Segment(**WIRE)], **of_rod)
    return Outcome("wrong", "accepted")


def run(method: str, options: dict[str, Any]) -> Outcome:
    """Motion of the lab's wire with such arguments. A success must be finite and conserve energy."""
    rod = rods.rod(WIRE)
    given = {"t_end": DURATION, "method": method, **options}
    if method in ("radau", "rk45"):
        given["max_steps"] = MOST_STEPS
    motion = judge.run(rod, given.pop("t_end"), **given)
    if not motion.success:
        return judge.failure(motion)
    if not np.isfinite(motion.q).all():
        return Outcome("wrong", "the states are not finite")
    drift = judge.defect(motion)
    if not drift <= judge.BALANCE_TOLERANCE:
        return Outcome("wrong", f"the energy balance is off by {drift:.1e}", drift, motion.stats.nfev)
    return judge.right_motion(drift, motion.stats.nfev, "by the energy balance")


def at_rest(analysis: str, options: dict[str, Any]) -> Outcome:
    """Statics or modes at such a shape."""
    rod = rods.rod(WIRE)
    if analysis == "statics":
        return judge.equilibrium(rod, statics(rod, options["q0"], max_iter=MOST_STEPS, space_error=False))
    return judge.vibrations(rod, np.asarray(options["q0"]), modes(rod, options["q0"]))


def models() -> Group:
    """Impossible rods."""
    cells = [
        Cell(parameter, name, partial(built, parameter, value), quick=True)
        for parameter in (*SEGMENT_PARAMETERS, "tip_mass", "gravity")
        for name, value in VALUES.items()
        if not (value == 0.0 and parameter in MAY_BE_ZERO)
        and not (parameter == "gravity" and value in (0.0, -1.0))
    ]
    return Group(
        "ill_posed_models",
        "Ill-posed models",
        "parameter",
        "value",
        cells,
        "Each of them has to be refused before any work, with a message that names the parameter and what "
        "would be "
        "right. Stiffness is never zero, so neither is a rod without stiffness and damping.",
    )


def motions() -> Group:
    """Invalid initial states and arguments."""
    states: dict[str, dict[str, Any]] = {
        **{name: {"q0": [value, 0.0, 0.0]} for name, value in SHAPES.items()},
        **{name: {"v0": [value, 0.0, 0.0]} for name, value in SPEEDS.items()},
    }
    works: list[tuple[str, str, Callable[[], Outcome]]] = [
        *[(row, method, partial(run, method, state)) for row, state in states.items() for method in METHODS],
        *[
            (row, analysis, partial(at_rest, analysis, states[row]))
            for row in SHAPES
            for analysis in ("statics", "modes")
        ],
        *[
            (row, method, partial(run, method, options))
            for row, options in ARGUMENTS.items()
            for method in METHODS
        ],
    ]
    return Group(
        "ill_posed_motions",
        "Ill-posed motions",
        "input",
        "method",
        [Cell(row, method, work, quick=row in QUICK) for row, method, work in works],
        "The lab's wire from states far outside of any physical range, and with arguments that make no "
        "sense: "
        "a refusal, or a failure that says why, or a result that keeps the energy balance. Coordinates are "
        "curvatures "
        "in radians per metre; rounding makes sines of 1e16 meaningless.",
    )
