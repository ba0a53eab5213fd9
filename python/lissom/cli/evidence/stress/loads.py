"""Buckling columns, follower loads, and arcs that snap through."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ...._lissom import Load, Rod, StaticsResult, continuation, statics
from . import judge, rods
from .cell import Cell, Group, Outcome

#: Loads relative to Euler's load of a clamped column, pi² E I / (4 L²).
EULER_LOADS = (0.5, 0.9, 0.99, 1.01, 1.1, 1.5, 2.0, 3.0, 5.0)

#: Follower loads in units of E I / L². Beck's column flutters above 20.05 (Beck 1952).
BECK_LOADS = (5.0, 15.0, 19.0, 19.9, 20.2, 21.0, 30.0, 50.0)
BECK = 20.05

#: Natural curvatures, in radians over the length, of rods bent in the opposite direction by twice Euler's
#: load.
ARCS = (0.01, 0.03, 0.1, 0.3)

#: Initial curvature for a buckled shape, and moment of an imperfection relative to E I / L.
SEED, IMPERFECTION = 1e-2, 1e-4

#: Largest error of the tip of buckled columns, relative to the length.
ELASTICA_TOLERANCE = 1e-5

#: The column: slender enough to be inextensible, and straight without load.
COLUMN: dict[str, Any] = {
    **rods.BENDING,
    "radius": 0.01,
    "young_modulus": 1e9,
    "modes": {"bend_y": 14},
    "nodes": 64,
}
STIFFNESS = 1e9 * np.pi / 4.0 * 0.01**4
EULER = np.pi**2 / 4.0 * STIFFNESS

#: Load factors, relative to the limit point, at which an arc must remain bent and must snap through.
BEFORE, AFTER = 1.05, 0.95


def column(ratio: float, **changes: object) -> Rod:
    """A column under a dead load."""
    return rods.rod(COLUMN, of_rod={"gravity": (0, 0, 0), "tip_force": (-ratio * EULER, 0, 0)}, **changes)


def integrals(modulus: float) -> tuple[float, float]:
    """Complete elliptic integrals K and E by the arithmetic-geometric mean (DLMF 19.8.6)."""
    a, g, c = 1.0, np.sqrt(1.0 - modulus**2), modulus
    total, weight = c * c / 2.0, 1.0
    while abs(c) > 1e-16:
        a, g, c = (a + g) / 2.0, np.sqrt(a * g), (a - g) / 2.0
        total += weight * c * c
        weight *= 2.0
    K = float(np.pi / (2.0 * a))
    return K, K * (1.0 - float(total))


def elastica(ratio: float) -> tuple[float, float]:
    """Tip position of a buckled column, along and perpendicular to it (Timoshenko and Gere 1961, section
    2.7)."""
    if ratio <= 1.0:
        return 1.0, 0.0
    low, high = 0.0, 1.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        if integrals(middle)[0] < np.pi / 2.0 * np.sqrt(ratio):
            low = middle
        else:
            high = middle
    K, E = integrals(low)
    return 2.0 * E / K - 1.0, 2.0 * low / K


def straight(ratio: float) -> Outcome:
    """From the unloaded state a perfect column remains straight; the test is whether it is reported as
    stable."""
    rod = column(ratio)
    found = statics(rod, space_error=False)
    outcome = judge.equilibrium(rod, found)
    if outcome.kind == "accurate" and found.is_stable != (ratio < 1.0):
        return Outcome("wrong", f"called {found.stability} at {ratio:g} of Euler's load")
    return outcome


def seeded(ratio: float, side: float) -> Outcome:
    """Release from a slight bend to one side."""
    rod = column(ratio)
    seed = np.zeros(rod.n)
    seed[0] = side * SEED
    return _beside_elastica(rod, statics(rod, seed, space_error=False), ratio, 0.0)


def imperfect(ratio: float) -> Outcome:
    """From the unloaded state with a slight natural curvature: bends to the side of the curvature, slightly
    more than the elastica."""
    rod = column(ratio, reference_strain=(0, IMPERFECTION, 0, 1, 0, 0))
    # The tip displacement due to the imperfection is amplified by the inverse distance to the critical load,
    # or is proportional to the cube root of the imperfection at the critical load.
    return _beside_elastica(
        rod,
        statics(rod, space_error=False),
        ratio,
        min(IMPERFECTION / abs(ratio - 1.0), 2 * IMPERFECTION ** (1 / 3)),
    )


def _beside_elastica(rod: Rod, found: StaticsResult, ratio: float, allowed: float) -> Outcome:
    outcome = judge.equilibrium(rod, found)
    if outcome.kind != "accurate":
        return outcome
    if not found.is_stable:
        return Outcome("failed", f"ends where it is {found.stability}", None, found.nfev)
    x, y = elastica(ratio)
    tip = rod.pose(found.q, rod.length)[:3, 3]
    error = max(abs(tip[0] - x), abs(abs(tip[2]) - y))
    if not error <= ELASTICA_TOLERANCE + allowed:
        return Outcome(
            "wrong", f"the tip is off the elastica by {error:.1e} of the length", error, found.nfev
        )
    return judge.right_motion(error, found.nfev, "tip, beside the elastica")


def buckling() -> Group:
    """Dead loads around Euler's load."""
    ways: dict[str, Callable[[float], Outcome]] = {
        "straight": straight,
        "seed, one side": partial(seeded, side=1.0),
        "seed, other side": partial(seeded, side=-1.0),
        "natural curvature": imperfect,
    }
    return Group(
        "buckling",
        "Buckling",
        "load / Euler's load",
        "way there",
        [
            Cell(f"{ratio:g}", name, partial(way, ratio), quick=ratio in (0.5, 1.5, 5.0))
            for ratio in EULER_LOADS
            for name, way in ways.items()
        ],
        "A clamped column with 14 bending modes under a dead load along it. The straight shape has to be "
        "called unstable "
        "above Euler's load; a column let go from a slight bend has to end at the elastica, to which the "
        "tip is "
        f"compared (to {ELASTICA_TOLERANCE:g} of the length, and what a natural curvature of "
        f"{IMPERFECTION:g} may add).",
    )


def beck(load: float, modes: int) -> Outcome:
    """A follower load: the straight shape flutters above Beck's load."""
    pushed = Load(force=(-load * STIFFNESS, 0, 0), frame="body")
    rod = rods.rod(COLUMN, modes={"bend_y": modes}, of_rod={"gravity": (0, 0, 0), "loads": [pushed]})
    found = statics(rod, space_error=False)
    outcome = judge.equilibrium(rod, found)
    right = "stable" if load < BECK else "flutter"
    # Beck's load is that of the undamped column; a little damping lowers it (Ziegler 1952).
    if outcome.kind == "accurate" and found.undamped_stability != right:
        return Outcome("wrong", f"called {found.undamped_stability}, is {right}")
    return outcome


def follower() -> Group:
    """Beck's column."""
    return Group(
        "follower",
        "Follower loads",
        "load / (E I / L²)",
        "bending modes",
        [
            Cell(
                f"{load:g}", str(modes), partial(beck, load, modes), quick=load in (19.0, 21.0) and modes == 6
            )
            for load in BECK_LOADS
            for modes in (6, 10, 14)
        ],
        f"A load that stays tangential to the tip of a column: it flutters above {BECK:g} E I / L² (Beck "
        "1952).",
    )


def snap(curvature: float, after: bool) -> Outcome:
    """A bent rod held in the opposite direction by its load: it remains so above the limit point and snaps
    through below it."""
    ratio = 2.0
    rod = column(ratio, reference_strain=(0, curvature, 0, 1, 0, 0))
    bent = np.zeros(rod.n)
    # Coordinates are curvatures beyond the natural one; start near the elastica of this load.
    bent[0] = -2.0
    start = statics(rod, bent, space_error=False)
    if not start.success or np.sign(start.q[0] + curvature) != -1.0:
        return Outcome("failed", "not held the other way")
    inwards = np.zeros(rod.n)
    inwards[0] = 1.0
    path = continuation(rod, start.q, load_factor=1.0, direction=inwards, bounds=(0.0, 1.0)).path
    limits = [point for point in path.critical_points if point.kind == "limit"]
    if not limits:
        return Outcome("wrong", "no limit point is found on the way back")
    limit = limits[0]
    load = ratio * limit.load_factor * (AFTER if after else BEFORE)
    rod = column(load, reference_strain=(0, curvature, 0, 1, 0, 0))
    # From the bent shape next to the limit point, on the side of the larger load.
    nearest = path.q[np.flatnonzero(path.load_factor >= BEFORE * limit.load_factor)]
    held = [q for q in nearest if q[0] + curvature < limit.q[0] + curvature][-1:]
    found = statics(rod, held[0] if held else limit.q, space_error=False)
    outcome = judge.equilibrium(rod, found)
    if outcome.kind != "accurate":
        return outcome
    across = rod.pose(found.q, rod.length)[2, 3] * np.sign(rod.pose(limit.q, rod.length)[2, 3])
    stays = bool(across > 0.0)
    if stays == after:
        return Outcome("wrong", "snapped too early" if after is False else "did not snap")
    what = f"limit point at {ratio * limit.load_factor:.4g} of Euler's load"
    return judge.right_motion(outcome.error or 0.0, found.nfev, what)


def snap_through() -> Group:
    """Arcs bent in the opposite direction."""
    sides = {"above the limit point": False, "below it": True}
    return Group(
        "snap_through",
        "Snap-through",
        "natural curvature × length",
        "load",
        [
            Cell(f"{curvature:g}", name, partial(snap, curvature, after), quick=curvature == 0.1)
            for curvature in ARCS
            for name, after in sides.items()
        ],
        "A bent rod is held bent the other way by twice Euler's load. The limit point on the way back is "
        "found by "
        f"continuation; at {BEFORE:g} times its load the rod has to stay, at {AFTER:g} times it has to snap "
        "through.",
    )
