"""Bends of many turns, and motions that start far from rest."""

from __future__ import annotations

from functools import cache, partial
from typing import Any

import numpy as np

from ...._lissom import MotionResult, Rod, statics
from ....results.runs import Array
from . import judge, rods
from .cell import Cell, Group, Outcome

TURNS = (0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 50.0)

#: Quadrature nodes of wound-up rods: enough for the largest number of turns in the motions; and nodes per
#: turn for the circles (resolving a turn needs more than pi), if that is more.
NODES = 128
NODES_OF_TURN = 5

#: Largest error of a circle's curvature, relative.
CIRCLE_TOLERANCE = 1e-9

#: Curls that are released, in turns, and initial angular velocities, in turns of the tip's section per
#: second.
CURLS = (0.25, 0.5, 1.0, 2.0, 5.0)
SPINS = (1.0, 10.0, 100.0)

#: Duration of the motion in seconds, number of instants of the comparison, number of fixed steps.
DURATION, INSTANTS, STEPS = 0.5, 51, 5000


def _curvature(turns: float) -> float:
    return 2.0 * np.pi * turns / float(rods.SOFT["length"])


def circle(turns: float, modes: dict[str, int]) -> Outcome:
    """A tip moment bends a rod to a circle with the exact curvature moment / (E I)."""
    right = _curvature(turns)
    radius = float(rods.SOFT["radius"])
    stiffness = float(rods.SOFT["young_modulus"]) * np.pi / 4.0 * radius**4
    loaded = {"gravity": (0.0, 0.0, 0.0), "tip_moment": (0.0, stiffness * right, 0.0)}
    default = rods.rod(modes=modes, of_rod=loaded)
    nodes = max(default.nodes[0], round(NODES_OF_TURN * turns))
    rod = rods.rod(modes=modes, nodes=nodes, of_rod=loaded)
    found = statics(rod, space_error=False)
    if not found.success:
        return judge.failure(found)
    expected = np.zeros(rod.n)
    expected[modes.get("torsion", 0)] = right
    error = float(np.abs(found.q - expected).max()) / right
    if not error <= CIRCLE_TOLERANCE:
        return Outcome("wrong", f"the curvature is off by {error:.1e}", error, found.nfev)
    return judge.right_motion(error, found.nfev, "curvature, beside moment / (E I)")


def circles() -> Group:
    """Circles of many turns."""
    shapes: dict[str, dict[str, int]] = {
        "1 mode": {"bend_y": 1},
        "6 modes": {"bend_y": 6},
        "plane, all strains": {"bend_y": 3, "stretch": 2, "shear_z": 2},
        "space": {"torsion": 2, "bend_y": 3, "bend_z": 3},
    }
    return Group(
        "turns",
        "Bending through many turns",
        "turns",
        "modes",
        [
            Cell(f"{turns:g}", name, partial(circle, turns, modes), quick=turns == 2.0)
            for turns in TURNS
            for name, modes in shapes.items()
        ],
        "Equilibria under a moment at the tip, from the unloaded state, compared with the circle. "
        f"{NODES_OF_TURN} nodes a turn.",
    )


def _wound() -> Rod:
    return rods.rod(rods.BENDING, nodes=NODES, of_rod={"gravity": (0.0, 0.0, 0.0)})


def _curl(turns: float) -> dict[str, Array]:
    return {"q0": np.array([_curvature(turns), 0.0, 0.0])}


def _spin(turns: float) -> dict[str, Array]:
    return {"v0": np.array([_curvature(turns), 0.0, 0.0])}


STATES = {
    **{f"curl of {turns:g} turns": partial(_curl, turns) for turns in CURLS},
    **{f"spin of {turns:g} turns/s": partial(_spin, turns) for turns in SPINS},
}


@cache
def _right(row: str) -> tuple[Array, MotionResult | None]:
    times = np.linspace(0.0, DURATION, INSTANTS)
    return times, judge.reference(_wound(), times, **STATES[row]())


def released(row: str, method: str) -> Outcome:
    """Release without gravity, far from rest."""
    rod, state = _wound(), STATES[row]()
    times, right = _right(row)
    options: dict[str, Any] = {**state}
    if method == "auto":
        return judge.requested(rod, times, right, **options)
    if method in ("radau", "rk45"):
        return judge.adaptive(rod, times, right, method, **options)
    return judge.fixed(rod, times, right, method, DURATION / STEPS, **options)


def far_from_rest() -> Group:
    """Released curls and spinning rods."""
    return Group(
        "far_from_rest",
        "Initial states far from rest",
        "initial state",
        "method",
        [
            Cell(row, method, partial(released, row, method), quick=row == "curl of 0.5 turns")
            for row in STATES
            for method in ("auto", "newmark", "generalised_alpha", "radau", "rk45")
        ],
        f"No gravity; {DURATION:g} s, {STEPS:,} fixed steps; {NODES} nodes. The tip is compared with a "
        "tight run.",
    )
