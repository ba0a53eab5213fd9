"""Runs of the rubber rod by a compiled model of MuJoCo, of whichever version."""

import time
from functools import partial

import mujoco
import numpy as np
from cases import OUTPUT_STEP, TIMES, record, shortest


def tips_of(model: mujoco.MjModel, steps: int, tip) -> np.ndarray:
    """The points `tip(data)` at the output times, infinite for a run that becomes unstable."""
    data = mujoco.MjData(model)
    tips = np.empty((TIMES.size, 3))
    mujoco.mj_kinematics(model, data)
    for output in range(TIMES.size):
        if output > 0:
            mujoco.mj_step(model, data, nstep=steps)
            mujoco.mj_kinematics(model, data)
        tips[output] = tip(data)
    # MuJoCo starts anew from the initial state when it finds a state that is not finite.
    unstable = any(
        data.warning[kind].number
        for kind in (
            mujoco.mjtWarning.mjWARN_BADQPOS,
            mujoco.mjtWarning.mjWARN_BADQVEL,
            mujoco.mjtWarning.mjWARN_BADQACC,
        )
    )
    return np.full_like(tips, np.inf) if unstable else tips


def measured(code: str, name: str, build, tip_of, steps: int, longest: float):
    """The record of a run of `build(step)`, with the tip `tip_of(model)` and `steps` steps per output."""
    step = OUTPUT_STEP / steps
    start = time.perf_counter()
    model = build(step)
    compile_seconds = time.perf_counter() - start
    tips, seconds = shortest(partial(tips_of, model, steps, tip_of(model)), longest)
    return record("rubber rod", code, name, f"dt = {step:.2e}", seconds, tips, compile_seconds)
