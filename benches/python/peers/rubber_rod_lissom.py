"""What lissom does with the cases: references that have converged, and runs of every cost."""

import math
import sys
from functools import partial
from itertools import product

import numpy as np
from peers.cases import (
    DURATION,
    RUBBER_ROD,
    SEGMENT,
    SEGMENT_GRAVITY,
    SEGMENT_ORIENTATION,
    SEGMENT_VISCOSITY,
    SEGMENTS,
    TIMES,
    record,
    shortest,
)

import lissom

# Bending, stretch and shear modes. The release sends waves of stretch and shear along the rod whose kinks no
# polynomial resolves, so that errors fall with a power of the number of modes.
FINE, FINER = (20, 14, 14), (24, 16, 16)
FINE_BENDING, FINER_BENDING = (20, 0, 0), (24, 0, 0)
REFERENCE_STEP = 5e-5
REFERENCE_SEGMENT_STEP = 1e-5
REFERENCE_RTOL = 1e-8
MORE_NODES = 48
# Modes with which the reference's steps are compared with those of a method that shares none of its code.
CROSS_CHECK_MODES = (6, 3, 3)

MODES = (
    (3, 0, 0),
    (4, 0, 0),
    (5, 0, 0),
    (6, 0, 0),
    (8, 0, 0),
    (12, 0, 0),
    (4, 1, 1),
    (5, 1, 1),
    (5, 2, 2),
    (5, 3, 3),
    (6, 3, 3),
    (7, 4, 4),
    (8, 6, 6),
    (12, 8, 8),
)
QUICK_MODES = ((4, 0, 0), (6, 0, 0), (8, 0, 0), (4, 1, 1), (5, 2, 2), (6, 3, 3), (8, 6, 6))
STEPS = (5e-2, 4e-2, 2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4)
QUICK_STEPS = (2e-2, 1e-2, 5e-3, 1e-3)
TOLERANCES = (1e-3, 1e-5)
# Only with these modes: others would show the same.
ALL_METHODS_MODES = ((4, 0, 0), (5, 2, 2))
METHODS = {
    "generalised alpha": {"method": "generalised_alpha"},
    "HHT": {"method": "hht"},
    "RK45": {"method": "rk45"},
    "DOP853": {"method": "dop853"},
    "Radau": {"method": "radau"},
}
IN_STEPS = ("Newmark", "generalised alpha", "HHT")


def rubber_rod(bending: int, stretch: int, shear: int, nodes: int | None = None) -> lissom.Rod:
    rod = RUBBER_ROD
    modes = {"bend_y": bending, "stretch": stretch, "shear_z": shear}
    segment = lissom.Segment(
        rod.length,
        rod.radius,
        rod.young_modulus,
        rod.shear_modulus,
        rod.density,
        {strain: count for strain, count in modes.items() if count},
        nodes=nodes,
    )
    return lissom.Rod([segment])


def two_segments(nodes: int | None = None) -> lissom.Rod:
    rod = SEGMENT
    segment = lissom.Segment(
        rod.length,
        rod.radius,
        rod.young_modulus,
        rod.shear_modulus,
        rod.density,
        {"bend_y": 2, "bend_z": 2, "stretch": 2},
        retardation_time=3.0 * SEGMENT_VISCOSITY / rod.young_modulus,
        nodes=nodes,
    )
    return lissom.Rod([segment] * SEGMENTS, gravity=SEGMENT_GRAVITY, base_orientation=SEGMENT_ORIENTATION)


def tips_of(rod: lissom.Rod, **options) -> np.ndarray:
    """The motion and where it takes the tip, of shape (101, 3)."""
    motion = lissom.simulate(rod, DURATION, t_eval=TIMES, **options)
    if not motion.success:
        return np.full((TIMES.size, 3), math.inf)
    return rod.pose(motion.q, rod.length)[:, :3, 3]


def difference(one: np.ndarray, other: np.ndarray) -> float:
    """Largest distance of two tips over the motion."""
    return float(np.linalg.norm(one - other, axis=1).max())


def references(quick: bool) -> tuple[dict[str, np.ndarray], dict[str, float]]:
    """The converged tips of each model, and what more modes, nodes and smaller steps change."""
    step = 4.0 * REFERENCE_STEP if quick else REFERENCE_STEP
    exact = {"rtol": REFERENCE_RTOL, "dt": step}
    coarser = {"rtol": REFERENCE_RTOL, "dt": 2.0 * step}
    tips, changes = {}, {}
    for name, fine, finer in (
        ("rubber rod", FINE, FINER),
        ("rubber rod, bending only", FINE_BENDING, FINER_BENDING),
    ):
        tips[name] = tips_of(rubber_rod(*finer), **exact)
        changes[f"{name}: {finer} instead of {fine} modes"] = difference(
            tips_of(rubber_rod(*fine), **exact), tips[name]
        )
        changes[f"{name}: half the step"] = difference(tips_of(rubber_rod(*finer), **coarser), tips[name])
        changes[f"{name}: {MORE_NODES} instead of {rubber_rod(*finer).nodes[0]} nodes"] = difference(
            tips_of(rubber_rod(*finer, nodes=MORE_NODES), **coarser),
            tips_of(rubber_rod(*finer), **coarser),
        )
    radau = tips_of(rubber_rod(*CROSS_CHECK_MODES), method="radau", rtol=1e-8, atol=1e-10)
    changes[f"rubber rod, {CROSS_CHECK_MODES} modes: Radau instead of Newmark"] = difference(
        tips_of(rubber_rod(*CROSS_CHECK_MODES), **exact), radau
    )
    name = "two segments"
    tips[name] = tips_of(two_segments(), method="radau", rtol=1e-10, atol=1e-12)
    changes[f"{name}: Newmark instead of Radau"] = difference(
        tips_of(two_segments(), dt=REFERENCE_SEGMENT_STEP, rtol=REFERENCE_RTOL), tips[name]
    )
    changes[f"{name}: {MORE_NODES} instead of {two_segments().nodes[0]} nodes"] = difference(
        tips_of(two_segments(nodes=MORE_NODES), method="radau", rtol=1e-10, atol=1e-12), tips[name]
    )
    return tips, changes


def describe(bending: int, stretch: int, shear: int) -> tuple[str, str]:
    if stretch == shear == 0:
        return "lissom, bending only", f"{bending} bending"
    return "lissom", f"{bending} bending, {stretch} stretch, {shear} shear"


def measure(case: str, code: str, discretisation: str, step: str, longest: float, run) -> dict:
    tips, seconds = shortest(run, longest)
    print(f"{code}, {discretisation}, {step}: {1e3 * seconds:.3g} ms", file=sys.stderr)
    return record(case, code, discretisation, step, seconds, tips)


def runs(quick: bool, longest: float):
    """Every run of lissom as a dictionary."""
    steps = QUICK_STEPS if quick else STEPS
    for modes in QUICK_MODES if quick else MODES:
        code, discretisation = describe(*modes)
        for step in steps:
            run = partial(lambda modes, step: tips_of(rubber_rod(*modes), dt=step), modes, step)
            yield measure("rubber rod", code, discretisation, f"Newmark, dt = {step:.0e}", longest, run)
    for modes, (method, options) in product(ALL_METHODS_MODES, METHODS.items()):
        code, discretisation = describe(*modes)
        for value in steps if method in IN_STEPS else TOLERANCES:
            setting = {"dt": value} if method in IN_STEPS else {"rtol": value, "atol": value}
            label = "dt" if method in IN_STEPS else "rtol"
            run = partial(
                lambda modes, given: tips_of(rubber_rod(*modes), **given), modes, {**options, **setting}
            )
            yield measure(
                "rubber rod", code, discretisation, f"{method}, {label} = {value:.0e}", longest, run
            )
    for step in steps:
        run = partial(lambda step: tips_of(two_segments(), dt=step), step)
        yield measure("two segments", "lissom", "12 coordinates", f"Newmark, dt = {step:.0e}", longest, run)
    for tolerance in TOLERANCES:
        run = partial(
            lambda tolerance: tips_of(two_segments(), method="radau", rtol=tolerance, atol=tolerance),
            tolerance,
        )
        yield measure(
            "two segments", "lissom", "12 coordinates", f"Radau, rtol = {tolerance:.0e}", longest, run
        )
