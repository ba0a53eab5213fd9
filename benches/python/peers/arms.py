"""Run times of arms: serial chains of rigid links with revolute joints about x, y and z in turn.

The same robots as in benches/robot.rs. Everything runs on one core, in short repetitions of all codes in
turn, so that what else the machine does meets all of them alike; medians count.
"""

import sys
from collections.abc import Callable, Iterator
from itertools import cycle

import mujoco
import numpy as np
import pinocchio
from mujoco_trees import MujocoTree
from pinocchio_trees import PinocchioTree
from rigid_arms import arm, in_turn
from rigid_trees import robot

import lissom

JOINTS = (7, 30, 64, 100)
STEP, END = 1e-3, 1.0
# Errors of a step are looked at before long chains have forgotten where they started.
SHORT_END, FINER = 0.1, 64
INTEGRATORS = {
    "MuJoCo, Euler": mujoco.mjtIntegrator.mjINT_EULER,
    "MuJoCo, implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
}

SAMPLES, QUICK_SAMPLES = 101, 11
# Of a thousand steps.
RUNS, QUICK_RUNS = 21, 3


def start(joints: int) -> np.ndarray:
    """Coordinates of the first state; the arm starts at rest."""
    return 0.1 * np.sin(np.arange(joints))


def functions(joints: int) -> dict[str, Callable[[], object]]:
    """Single evaluations, at two states in turn: lissom remembers the last one."""
    tree = arm(joints)
    ours, theirs = robot(tree), PinocchioTree(tree)
    model, data = theirs.model, theirs.data
    indices = np.arange(joints)
    pair = [tuple(size * np.sin(indices + shift) for size in (0.1, 0.2, 0.3)) for shift in (0.0, 1.0)]
    states = cycle(pair)
    none = np.zeros(joints)

    return {
        "lissom, inverse dynamics": lambda: ours.inverse_dynamics(*next(states)),
        "Pinocchio, inverse dynamics (RNEA)": lambda: pinocchio.rnea(model, data, *next(states)),
        "lissom, forward dynamics": lambda: ours.forward_dynamics(*next(states)[:2]),
        "Pinocchio, forward dynamics (ABA)": lambda: pinocchio.aba(model, data, *next(states)[:2], none),
        "lissom, derivatives": lambda: ours.tangent(*next(states)),
        "Pinocchio, derivatives": lambda: pinocchio.computeRNEADerivatives(model, data, *next(states)),
    }


def lissom_steps(ours: lissom.Robot, step: float = STEP, end: float = END, **options: object):
    return lissom.simulate(ours, end, q0=start(ours.n), dt=step, t_eval=[end], **options)


def mujoco_steps(theirs: MujocoTree, integrator: int, step: float = STEP, end: float = END) -> np.ndarray:
    """The last coordinates."""
    theirs.model.opt.integrator, theirs.model.opt.timestep = integrator, step
    mujoco.mj_resetData(theirs.model, theirs.data)
    theirs.data.qpos[:] = start(theirs.model.nq)
    mujoco.mj_step(theirs.model, theirs.data, nstep=round(end / step))
    assert not any(warning.number for warning in theirs.data.warning), "MuJoCo warns"
    return theirs.data.qpos.copy()


def steps(joints: int, samples: int) -> dict[str, float]:
    """Medians of the times of a step."""
    tree = arm(joints)
    ours, theirs = robot(tree), MujocoTree(tree)
    runs: dict[str, Callable[[], object]] = {
        "lissom": lambda: lissom_steps(ours),
        "lissom, every tangent": lambda: lissom_steps(ours, reuse_jacobian=False),
    }
    runs |= {
        name: (lambda integrator=integrator: mujoco_steps(theirs, integrator))
        for name, integrator in INTEGRATORS.items()
    }
    count = END / STEP
    return {name: seconds / count for name, seconds in in_turn(runs, samples).items()}


def errors(joints: int) -> dict[str, float]:
    """Largest of the coordinates in radians after a short time, against lissom's run with fine steps."""
    tree = arm(joints)
    ours, theirs = robot(tree), MujocoTree(tree)
    euler = INTEGRATORS["MuJoCo, Euler"]
    fine = STEP / FINER
    right = lissom_steps(ours, fine, SHORT_END, rtol=1e-10, atol=1e-12).q[-1]
    found = {
        "lissom": lissom_steps(ours, STEP, SHORT_END).q[-1],
        "MuJoCo": mujoco_steps(theirs, euler, STEP, SHORT_END),
        "MuJoCo, fine": mujoco_steps(theirs, euler, fine, SHORT_END),
    }
    return {name: float(np.abs(q - right).max()) for name, q in found.items()}


def measure(quick: bool) -> Iterator[dict]:
    for joints in (1, *JOINTS):
        print(f"arms: {joints} joints", file=sys.stderr)
        samples = QUICK_SAMPLES if quick else SAMPLES
        work = lissom_steps(robot(arm(joints))).stats
        yield {
            "part": "arms",
            "joints": joints,
            "functions": in_turn(functions(joints), samples),
            "steps": steps(joints, QUICK_RUNS if quick else RUNS),
            "iterations": work.newton_iterations / work.steps,
            "tangents": work.njev / work.steps,
            "errors": errors(joints),
        }
