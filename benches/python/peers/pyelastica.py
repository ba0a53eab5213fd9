"""The rubber rod by PyElastica: discrete Cosserat elements, position Verlet."""

import time
from functools import partial

import elastica
import numpy as np
from cases import (
    GRAVITY,
    LONGEST_RUN,
    OUTPUT_STEP,
    QUICK_LONGEST_RUN,
    RUBBER_ROD,
    SECONDS,
    TIMES,
    on_one_core,
    packages,
    quick_requested,
    record,
    run_series,
    shortest,
    steps_per_output,
)

# Where the first element, whose node and frame are held, lies: PyElastica's cantilever examples start the rod
# at the clamp, which holds its frame half an element further out; starting the rod half an element
# earlier puts that frame at the clamp.
CLAMPS = {"clamp as documented": 0.0, "clamp in mid-element": 0.5}
ELEMENTS = {
    "clamp as documented": (20, 40, 80, 160, 240, 320, 480),
    "clamp in mid-element": (5, 10, 20, 40, 80, 160, 320),
}
# Of the largest stable step.
STEP_FRACTIONS = (0.9, 0.45)
# PyElastica's section keeps its volume and thins as it is stretched, lissom's does not. Made so many times as
# stiff in stretch and shear, the rod hardly stretches and both should agree.
STIFFENING = 100.0
STIFFENED_ELEMENTS = (20, 40, 80)


class Simulator(elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing):
    """A rod that is held and has weight."""


def element_length(elements: int, shift: float) -> float:
    return RUBBER_ROD.length / (elements - shift)


def build(elements: int, shift: float, stiffening: float):
    rod = RUBBER_ROD
    length = element_length(elements, shift)
    simulator = Simulator()
    cosserat_rod = elastica.CosseratRod.straight_rod(
        elements,
        np.array([-shift * length, 0.0, 0.0]),
        np.array([1.0, 0.0, 0.0]),
        np.array([0.0, 1.0, 0.0]),
        elements * length,
        rod.radius,
        rod.density,
        youngs_modulus=rod.young_modulus,
        shear_modulus=rod.shear_modulus,
    )
    # PyElastica multiplies the shear stiffness with a fixed correction of 27/28; the others here do not.
    for axis in (0, 1):
        cosserat_rod.shear_matrix[axis, axis, :] = rod.shear_modulus * rod.area
    cosserat_rod.shear_matrix *= stiffening
    simulator.append(cosserat_rod)
    simulator.constrain(cosserat_rod).using(
        elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
    )
    simulator.add_forcing_to(cosserat_rod).using(
        elastica.GravityForces, acc_gravity=np.array([0.0, 0.0, -GRAVITY])
    )
    simulator.finalize()
    return simulator, cosserat_rod


def largest_stable_step(length: float, stiffening: float) -> float:
    """Of an explicit scheme of second order: 2 over the largest frequency.

    That is the one of stretch of neighbouring nodes, 2 c / h, or the one of shear against rotary inertia,
    sqrt(G A / (rho I)), or a little more than both together.
    """
    rod = RUBBER_ROD
    shear = np.sqrt(4.0 * rod.shear_modulus / (rod.density * rod.radius**2))
    return 2.0 / (np.sqrt(stiffening) * np.hypot(2.0 * rod.sound_speed / length, shear))


def tips_of(simulator, cosserat_rod, steps: int) -> np.ndarray:
    stepper = elastica.PositionVerlet()
    tips = np.empty((TIMES.size, 3))
    tips[0] = cosserat_rod.position_collection[:, -1]
    step, now = OUTPUT_STEP / steps, 0.0
    for output in range(1, TIMES.size):
        for _ in range(steps):
            now = stepper.step(simulator, now, step)
        tips[output] = cosserat_rod.position_collection[:, -1]
    return tips


def series(
    case: str, clamp: str, counts: tuple[int, ...], stiffening: float, compile_seconds: float, longest: float
):
    """Runs with ever more elements, each with the steps that are stable."""
    shift = CLAMPS[clamp]
    for elements in counts:
        largest = largest_stable_step(element_length(elements, shift), stiffening)
        for steps in steps_per_output(largest, STEP_FRACTIONS):

            def measure(elements=elements, steps=steps):
                # A simulator can run only once.
                seconds, spent = np.inf, 0.0
                while spent == 0.0 or spent < min(SECONDS, longest):
                    model = build(elements, shift, stiffening)
                    tips, elapsed = shortest(partial(tips_of, *model, steps), 0.0)
                    seconds, spent = min(seconds, elapsed), spent + elapsed
                return record(
                    case,
                    f"PyElastica, {clamp}",
                    f"{elements} elements",
                    f"dt = {OUTPUT_STEP / steps:.2e}",
                    seconds,
                    tips,
                    compile_seconds,
                )

            yield measure


def main() -> None:
    on_one_core()
    longest = QUICK_LONGEST_RUN if quick_requested(__doc__) else LONGEST_RUN
    packages("pyelastica", "numba", "numpy")
    start = time.perf_counter()
    simulator, _ = build(10, 0.0, 1.0)
    elastica.PositionVerlet().step(simulator, 0.0, 1e-5)
    compile_seconds = time.perf_counter() - start
    for clamp, counts in ELEMENTS.items():
        run_series(series("rubber rod", clamp, counts, 1.0, compile_seconds, longest), longest)
    run_series(
        series(
            "stiffened rubber rod",
            "clamp in mid-element",
            STIFFENED_ELEMENTS,
            STIFFENING,
            compile_seconds,
            longest,
        ),
        longest,
    )


if __name__ == "__main__":
    main()
