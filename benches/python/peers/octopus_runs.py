"""Run time against error of the octopus: in water lissom alone, without water lissom beside its peers."""

import statistics
import sys
import warnings
from collections.abc import Callable, Iterator

import numpy as np
import octopus
import octopus_mujoco
from octopus import OUTPUT_STEP
from rigid_arms import elapsed

import lissom

# What counts: relative to the length of an arm, which is 0.2 m.
ONE_PERCENT = 1e-2

# Of the reference, which has many modes and small steps.
FINE_MODES, FINER_MODES = 10, 14
FINE_STEP, QUICK_FINE_STEP = 5e-4, 2e-3

MODES, QUICK_MODES = (4, 5, 6, 8), (4, 8)
STEPS, QUICK_STEPS = (4e-2, 2e-2, 1e-2, 5e-3, 2.5e-3), (4e-2, 1e-2)
AUTO_MODES = 8
# A run is repeated until so many seconds or runs.
SECONDS, MOST_RUNS = 1.0, 7

# Pieces of an arm; steps between two output times, as far as they may be needed for one percent.
PIECES, QUICK_PIECES = (5, 10, 16, 20, 28), (5, 10)
STEPS_PER_OUTPUT = {"Euler": (16, 64, 256, 512, 1024), "RK4": (8, 32, 128, 256, 512)}
# A series of ever shorter steps ends with the first run that takes longer, in seconds.
LONGEST_RUN, QUICK_LONGEST_RUN = 12.0, 1.0


def timed(run: Callable[[], np.ndarray]) -> tuple[np.ndarray, float]:
    """What the run returns, and the median of its processor times in seconds."""
    found: list[np.ndarray] = []
    times: list[float] = []
    while not times or (sum(times) < SECONDS and len(times) < MOST_RUNS):
        times.append(elapsed(lambda: found.append(run()), 1))
    return found[-1], statistics.median(times)


def row(water: bool, code: str, discretisation: str, step: str, seconds: float, error: float) -> dict:
    return {
        "part": "octopus",
        "water": water,
        "code": code,
        "discretisation": discretisation,
        "step": step,
        "seconds": seconds,
        "error": error if error < 1e3 else None,
    }


def lissom_runs(water: bool, reference, quick: bool) -> Iterator[dict]:
    for modes in QUICK_MODES if quick else MODES:
        model, name = octopus.robot(modes, water), f"{modes} + {octopus.MODES_ACROSS} modes an arm"
        for step in QUICK_STEPS if quick else STEPS:
            tips, seconds = timed(lambda model=model, step=step: octopus.tips(model, dt=step))
            yield row(
                water, "lissom", name, f"Newmark, dt = {step:g}", seconds, octopus.error(tips, reference)
            )
    model, name = octopus.robot(AUTO_MODES, water), f"{AUTO_MODES} + {octopus.MODES_ACROSS} modes an arm"
    tips, seconds = timed(lambda: octopus.tips(model, method="auto", rtol=ONE_PERCENT))
    error = octopus.error(tips, reference)
    yield row(water, "lissom, with its error estimate", name, f"auto, rtol = {ONE_PERCENT:g}", seconds, error)


def mujoco_runs(reference, quick: bool) -> Iterator[dict]:
    longest = QUICK_LONGEST_RUN if quick else LONGEST_RUN
    for pieces in QUICK_PIECES if quick else PIECES:
        for integrator, counts in STEPS_PER_OUTPUT.items():
            for count in counts:
                # Not the compilation of the model.
                octopus_mujoco.model(pieces, integrator, OUTPUT_STEP / count)
                tips, seconds = timed(
                    lambda pieces=pieces, integrator=integrator, count=count: octopus_mujoco.tips(
                        pieces, integrator, count
                    )
                )
                yield row(
                    False,
                    "MuJoCo",
                    f"{pieces} links an arm, {integrator}",
                    f"dt = {OUTPUT_STEP / count:.1e}",
                    seconds,
                    octopus.error(tips, reference),
                )
                if seconds > longest:
                    break


def measure(quick: bool) -> Iterator[dict]:
    # Coarse runs are coarse on purpose.
    warnings.simplefilter("ignore", lissom.AccuracyWarning)
    step = QUICK_FINE_STEP if quick else FINE_STEP
    exact = {"rtol": 1e-9, "atol": 1e-11}
    for water in (True, False):
        print(f"octopus {'in water' if water else 'without water'}: reference", file=sys.stderr)
        fine = octopus.robot(FINE_MODES, water)
        reference = octopus.tips(fine, dt=step, **exact)
        coarser = octopus.tips(fine, dt=2.0 * step, **exact)
        finer = octopus.tips(octopus.robot(FINER_MODES, water), dt=2.0 * step, **exact)
        yield {
            "part": "octopus reference",
            "water": water,
            "modes": FINE_MODES,
            "step": step,
            "twice the step": octopus.error(coarser, reference),
            "more modes": octopus.error(finer, coarser),
        }
        for run in lissom_runs(water, reference, quick):
            yield tell(run)
    for run in mujoco_runs(reference, quick):
        yield tell(run)


def tell(run: dict) -> dict:
    error = "fails" if run["error"] is None else f"{run['error']:.2g}"
    print(
        f"{run['code']}, {run['discretisation']}, {run['step']}: {run['seconds']:.3g} s, {error}",
        file=sys.stderr,
    )
    return run
