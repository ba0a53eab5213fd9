"""Comparison of rods with another code: PyElastica, if it is installed.

PyElastica (Gazzola and others 2018) uses nodes and elements, lissom functions of the arc length; both share
only the equations of a Cosserat rod.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

from ...._lissom import Rod, Section, Segment, simulate
from .case import Answer, Array, Case, Curve, Package, Plot

THEME = "Beside PyElastica"
PYELASTICA = Package("PyElastica", module="elastica", install="pip install pyelastica")

#: The rubber rod of the benchmarks, released from horizontal; SI units.
LENGTH, RADIUS, YOUNG, DENSITY = 1.0, 0.02, 5e6, 1000.0
SHEAR = YOUNG / 3.0
AREA = np.pi * RADIUS**2
SECOND_MOMENT = AREA * RADIUS**2 / 4.0
GRAVITY = 9.81

#: Times at which the tip is compared.
TIMES = np.linspace(0.0, 1.0, 101)
OUTPUT_STEP = TIMES[1]
#: Indices of the times in the table.
SHOWN = (25, 50, 75, 100)

#: PyElastica's sections keep their volume: a relative stretch reduces the bending stiffness by three times
#: its value. lissom's sections keep their shape. With this factor of the stiffness in stretch and shear, the
#: rod hardly stretches, and the difference between both models is reduced to a hundredth.
STIFFENING = 100.0

ELEMENTS = (10, 20, 40, 80)
#: PyElastica's step relative to the largest stable one.
STEP_FRACTION = 0.45

#: Modes of bending, of stretch and of shear, and Newmark's step: halving it moves the tip by 7e-6 m, four
#: more of each kind of mode by 1e-5 m (for the rod that hardly stretches; 5e-5 m for the other one, because
#: of waves along the rod).
BENDS, STRETCHES, STEP = 16, 10, 2e-4


def lissom_tips(stiffening: float) -> Array:
    """Path of the tip by lissom, shape (times, 3); not finite if the run fails."""
    stretch, shear = stiffening * YOUNG * AREA, stiffening * SHEAR * AREA
    bend, inertia = YOUNG * SECOND_MOMENT, DENSITY * SECOND_MOMENT
    section = Section.given(
        np.diag([2.0 * SHEAR * SECOND_MOMENT, bend, bend, stretch, shear, shear]),
        mass=DENSITY * AREA,
        inertia=(2.0 * inertia, inertia, inertia),
    )
    strains = {"bend_y": BENDS, "stretch": STRETCHES, "shear_z": STRETCHES}
    rod = Rod([Segment(LENGTH, section=section, modes=strains)], gravity=(0.0, 0.0, -GRAVITY))
    motion = simulate(rod, TIMES[-1], dt=STEP, t_eval=TIMES)
    if not motion.success:
        return np.full((len(TIMES), 3), np.nan)
    return rod.pose(motion.q, LENGTH)[:, :3, 3]


@cache
def peer_tips(elements: int, stiffening: float) -> Array:
    """Path of the tip by PyElastica, shape (times, 3).

    PyElastica fixes the frame of the first element, half an element away from the node that it fixes too.
    Here the rod starts half an element before the clamp, so that this frame is at the clamp. With the rod
    starting at the clamp, as in its examples, the error is of first order.
    """
    elastica: Any = import_module("elastica")
    element = LENGTH / (elements - 0.5)
    rod = elastica.CosseratRod.straight_rod(
        elements,
        np.array([-0.5 * element, 0.0, 0.0]),
        np.array([1.0, 0.0, 0.0]),
        np.array([0.0, 1.0, 0.0]),
        elements * element,
        RADIUS,
        DENSITY,
        youngs_modulus=YOUNG,
        shear_modulus=SHEAR,
    )
    # Its shear correction of 27/28 is fixed.
    for axis in (0, 1):
        rod.shear_matrix[axis, axis] = SHEAR * AREA
    rod.shear_matrix *= stiffening
    parts = (elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing)
    simulator = type("Simulator", parts, {})()
    simulator.append(rod)
    simulator.constrain(rod).using(
        elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
    )
    simulator.add_forcing_to(rod).using(elastica.GravityForces, acc_gravity=np.array([0.0, 0.0, -GRAVITY]))
    simulator.finalize()

    stepper, now = elastica.PositionVerlet(), 0.0
    steps = int(np.ceil(OUTPUT_STEP / (STEP_FRACTION * largest_stable_step(element, stiffening))))
    tips = [rod.position_collection[:, -1].copy()]
    for _ in TIMES[1:]:
        for _ in range(steps):
            now = stepper.step(simulator, now, OUTPUT_STEP / steps)
        tips.append(rod.position_collection[:, -1].copy())
    return np.array(tips)


def largest_stable_step(element: float, stiffening: float) -> float:
    """Stability limit of Verlet's method, 2 / frequency: for neighbours in stretch, and for shear that
    rotates sections."""
    stretching = 2.0 * np.sqrt(YOUNG / DENSITY) / element
    shearing = np.sqrt(4.0 * SHEAR / (DENSITY * RADIUS**2))
    return float(2.0 / (np.sqrt(stiffening) * np.hypot(stretching, shearing)))


def extrapolated(stiffening: float) -> Array:
    """Path of the tip for zero element length: errors are quadratic in the length (Richardson)."""
    coarse, fine = (peer_tips(elements, stiffening) for elements in ELEMENTS[-2:])
    ratio = (lengths()[-2] / lengths()[-1]) ** 2
    return np.asarray(fine + (fine - coarse) / (ratio - 1.0))


def lengths() -> Array:
    """Lengths of the elements."""
    return LENGTH / (np.array(ELEMENTS) - 0.5)


def shown(tips: Array) -> Array:
    """x and z at the times of the table."""
    return np.asarray(tips[list(SHOWN)][:, [0, 2]].ravel())


def tip(stiffening: float) -> Answer:
    """Tip positions at the given times."""
    found = lissom_tips(stiffening)

    def plot() -> Plot:
        wanted = extrapolated(stiffening)
        axes = (("x", 0), ("z", 2))
        return Plot(
            "time (s)",
            "tip (m)",
            [
                *(Curve(f"{name}, lissom", TIMES, found[:, axis]) for name, axis in axes),
                *(
                    Curve(f"{name}, PyElastica", TIMES[::5], wanted[::5, axis], joined=False)
                    for name, axis in axes
                ),
            ],
        )

    return Answer(shown(found), plot)


def refined() -> list[Array]:
    """Paths of the tip with increasing numbers of elements."""
    return [peer_tips(elements, STIFFENING) for elements in ELEMENTS]


def second_order() -> list[float]:
    """Reference value of the order; PyElastica runs here, because the time of the case is lissom's."""
    refined()
    return [2.0]


def order() -> Answer:
    """Order of convergence of PyElastica's elements to lissom's result."""
    found = lissom_tips(STIFFENING)
    distances = [np.sqrt(np.mean(np.sum((tips - found) ** 2, axis=1))) for tips in refined()]
    if not np.isfinite(distances).all():
        return Answer([np.nan], lambda: Plot("", "", []), "one of the codes has not reached the end")
    slope, offset = np.polyfit(np.log(lengths()), np.log(distances), 1)
    return Answer(
        [slope],
        lambda: Plot(
            "log10 of the length of an element / m",
            "log10 of the distance of the tips / m",
            [
                Curve("fit", np.log10(lengths()), (slope * np.log(lengths()) + offset) / np.log(10.0)),
                Curve("PyElastica to lissom", np.log10(lengths()), np.log10(distances), joined=False),
            ],
        ),
    )


CASES = (
    Case(
        "Rubber rod, PyElastica",
        THEME,
        "The rubber rod above, by PyElastica with 40 and 80 elements, extrapolated. PyElastica's section "
        "keeps its volume and gets thinner where the rod is stretched, lissom's does not: they differ by "
        "some millimetres however fine the elements.",
        "PyElastica, Verlet's method",
        "computed",
        "tip x, z at 0.25, 0.5, 0.75, 1 s (m)",
        lambda: shown(extrapolated(1.0)),
        lambda: tip(1.0),
        5e-3,
        scale=LENGTH,
        needs=PYELASTICA,
    ),
    Case(
        "Stiffened rod, PyElastica",
        THEME,
        "The same, a hundred times as stiff in stretch and shear: now that difference is a hundredth.",
        "PyElastica, Verlet's method",
        "computed",
        "tip x, z at 0.25, 0.5, 0.75, 1 s (m)",
        lambda: shown(extrapolated(STIFFENING)),
        lambda: tip(STIFFENING),
        2e-4,
        scale=LENGTH,
        needs=PYELASTICA,
    ),
    Case(
        "Stiffened rod, refined",
        THEME,
        "Mean distance (root of the mean square over the second) between the tips by PyElastica with 10, 20, "
        "40 and 80 elements and by lissom. Elements with the clamp in the middle of the first are of second "
        "order.",
        "PyElastica, order of its elements",
        "exact",
        "power of the length of an element with which the distance falls",
        second_order,
        order,
        0.1,
        scale=1.0,
        needs=PYELASTICA,
    ),
)
