"""Control steps of the tendon arm: what each code takes for 10 ms, and how far off its tip is.

A code runs with ever finer discretisations and steps; of those within a wanted error the fastest counts. The
fastest ones are then measured in turn, in one process and on one core.
"""

import sys
from collections.abc import Callable, Iterator
from dataclasses import replace

import mujoco
import numpy as np
import tendon_arm as arm
import tendon_arm_mujoco
import tendon_arm_soromox
from candidates import Candidate, within
from rigid_arms import elapsed, in_turn

import lissom

TOLERANCES = (1e-2, 5e-3, 2e-3)

MODES, LISSOM_STEPS = (2, 3), (1, 2, 4, 10)
PIECES, MUJOCO_STEPS = (6, 8, 10, 14, 20, 28), (1, 2, 4, 8, 16)
# Fewer than 30 steps of Tsit5 are unstable; Newton iterations of Kvaerno3 fail, with two steps as well.
SOROMOX_STEPS = {"Kvaerno3": 1, "Tsit5": 32}
SOROMOX_NODES = (5, 10, 20)
# Many arms at once, all on this core, for a few control steps.
ROWS, ROW_STEPS = 64, 10

SAMPLES, QUICK_SAMPLES = 11, 3


def lissom_run(modes: int, substeps: int) -> Callable[[], np.ndarray]:
    simulation = lissom.Simulation(arm.arm(modes), dt=arm.CONTROL_STEP / substeps)
    inputs = arm.tensions()
    return lambda: arm.moved(simulation, inputs)


def rows_of_tensions() -> np.ndarray:
    """Of many arms, shape (ROW_STEPS, ROWS, 4): each begins a step later than the one before."""
    return np.array([np.roll(arm.tensions(), -row, axis=0)[:ROW_STEPS] for row in range(ROWS)]).swapaxes(0, 1)


def lissom_rows(modes: int, substeps: int) -> Callable[[], None]:
    simulations = lissom.Simulations(arm.arm(modes), ROWS, dt=arm.CONTROL_STEP / substeps, workers=1)
    inputs = rows_of_tensions()

    def run() -> None:
        simulations.reset()
        for u in inputs:
            assert simulations.step(u, arm.CONTROL_STEP).all()
            simulations.q  # noqa: B018

    return run


def mujoco_run(built: mujoco.MjModel) -> Callable[[], np.ndarray]:
    data, inputs = mujoco.MjData(built), arm.tensions()
    return lambda: tendon_arm_mujoco.moved(built, data, inputs)


def soromox_run(method: str, substeps: int) -> Callable[[], np.ndarray]:
    step, inputs = tendon_arm_soromox.stepper(method, substeps), arm.tensions()
    return lambda: tendon_arm_soromox.moved(step, arm.arm().n, inputs)


def timed(run: Callable[[], object]) -> float:
    """Of a control step, the second time."""
    run()
    return elapsed(run, 1) / arm.STEPS


def candidates(reference: np.ndarray) -> Iterator[Candidate]:
    """Every way to move the arm, except for many arms at once."""

    def error(tips: np.ndarray) -> float:
        return float(np.linalg.norm(tips - reference, axis=1).max() / arm.LENGTH)

    def of_coordinates(modes: int, q: np.ndarray) -> float:
        return error(arm.arm(modes).pose(q)[:, :3, 3]) if np.isfinite(q).all() else np.inf

    for modes in MODES:
        model = arm.arm(modes)
        for substeps in LISSOM_STEPS:
            run = lissom_run(modes, substeps)
            found = of_coordinates(modes, run())
            yield Candidate("lissom", modes, f"{model.n} coordinates", substeps, found, timed(run), run)
    for kind in ("spatial", "fixed"):
        for pieces in PIECES:
            for substeps in MUJOCO_STEPS:
                built = tendon_arm_mujoco.model(pieces, kind, arm.CONTROL_STEP / substeps)
                run = mujoco_run(built)
                found = error(tendon_arm_mujoco.tips(built))
                code, links = f"MuJoCo, {kind} tendons", f"{pieces + 1} links"
                yield Candidate(code, pieces, links, substeps, found, timed(run), run)
    for method, substeps in SOROMOX_STEPS.items():
        print(f"tendon arm: SoRoMoX, {method}", file=sys.stderr)
        run = soromox_run(method, substeps)
        found = of_coordinates(arm.MODES, run())
        kind = f"{arm.arm().n} coordinates, {method}"
        yield Candidate("SoRoMoX", arm.MODES, kind, substeps, found, timed(run), run)


def row(one: Candidate, part: str) -> dict:
    return {
        "part": part,
        "code": one.code,
        "discretisation": one.discretisation,
        "step": arm.CONTROL_STEP / one.substeps,
        "error": one.error if np.isfinite(one.error) else None,
        "seconds": one.seconds,
    }


def measure(quick: bool) -> Iterator[dict]:
    print("tendon arm", file=sys.stderr)
    reference = arm.tips(arm.REFERENCE_MODES, arm.REFERENCE_STEP)
    others = {
        "twice the step": arm.tips(arm.REFERENCE_MODES, 2.0 * arm.REFERENCE_STEP),
        "more modes": arm.tips(arm.REFERENCE_MODES + 2, arm.REFERENCE_STEP),
    }
    yield {
        "part": "tendon arm reference",
        "modes": arm.REFERENCE_MODES,
        "step": arm.REFERENCE_STEP,
        **{
            name: float(np.linalg.norm(tips - reference, axis=1).max() / arm.LENGTH)
            for name, tips in others.items()
        },
        "reach": float(np.ptp(reference, axis=0).max()),
    }
    for nodes in SOROMOX_NODES:
        yield {"part": "tendon arm agreement", "nodes": nodes, **tendon_arm_soromox.deviations(nodes)}
    found = list(candidates(reference))
    for one in found:
        yield row(one, "tendon arm candidate")
    chosen = {tolerance: within(found, tolerance) for tolerance in TOLERANCES}
    samples = QUICK_SAMPLES if quick else SAMPLES
    for tolerance, best in chosen.items():
        medians = in_turn({one.code: one.run for one in best}, samples)
        for one in best:
            seconds = medians[one.code] / arm.STEPS
            yield {**row(replace(one, seconds=seconds), "tendon arm"), "tolerance": tolerance}
    (ours,) = (one for one in chosen[TOLERANCES[0]] if one.code == "lissom")
    seconds = in_turn({"rows": lissom_rows(ours.size, ours.substeps)}, samples)["rows"] / (ROWS * ROW_STEPS)
    yield {**row(replace(ours, seconds=seconds), "tendon arms"), "rows": ROWS}
