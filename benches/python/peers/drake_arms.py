"""Rigid arms by lissom and Drake: agreement, and processor times of single evaluations.

    pip install drake==1.58.0        # Python 3.12 or newer
    python benches/python/peers/drake_arms.py

Needs lissom built in release mode on the path of modules. The arms are those of arms.py, in a MultibodyPlant
as its documentation builds one, with continuous time. One core; medians of many repetitions of both codes in
turn; states differ from call to call. Prints a table.
"""

from collections.abc import Callable
from importlib.metadata import version
from itertools import cycle

import numpy as np
from cases import on_one_core
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    MultibodyForces,
    RevoluteJoint,
    SpatialInertia,
    UnitInertia,
)
from rigid_arms import CENTRE, INERTIA, MASS, arm, in_turn
from rigid_trees import Tree, robot

import lissom

JOINTS = (1, 7, 30, 64, 100)
SAMPLES = 101


def plant_of(tree: Tree) -> MultibodyPlant:
    plant = MultibodyPlant(0.0)
    unit = UnitInertia(*[INERTIA / MASS] * 3).ShiftFromCenterOfMass(-np.array(CENTRE))
    inertia = SpatialInertia(MASS, CENTRE, unit)
    parent = plant.world_body()
    for index, member in enumerate(tree.members):
        place = FixedOffsetFrame(f"place{index}", parent.body_frame(), RigidTransform(member.position))
        body = plant.AddRigidBody(f"link{index}", inertia)
        frame = plant.AddFrame(place)
        plant.AddJoint(RevoluteJoint(f"joint{index}", frame, body.body_frame(), member.axes[0]))
        parent = body
    plant.mutable_gravity_field().set_gravity_vector(tree.gravity)
    plant.Finalize()
    return plant


def calls(joints: int) -> dict[str, Callable[[], np.ndarray]]:
    """Single evaluations, at two states in turn."""
    tree = arm(joints)
    ours, plant = robot(tree), plant_of(tree)
    context = plant.CreateDefaultContext()
    indices = np.arange(joints)
    pair = [tuple(size * np.sin(indices + shift) for size in (0.1, 0.2, 0.3)) for shift in (0.0, 1.0)]
    states = cycle(pair)

    def inverse() -> np.ndarray:
        q, v, a = next(states)
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)
        forces = MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, forces)
        return plant.CalcInverseDynamics(context, a, forces)

    def forward() -> np.ndarray:
        q, v, _ = next(states)
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)
        return plant.EvalTimeDerivatives(context).CopyToVector()[joints:]

    return {
        "lissom, inverse dynamics": lambda: ours.inverse_dynamics(*next(states)),
        "Drake, inverse dynamics": inverse,
        "lissom, forward dynamics": lambda: ours.forward_dynamics(*next(states)[:2]),
        "Drake, forward dynamics": forward,
    }


def main() -> None:
    on_one_core()
    print(f"drake {version('drake')}, lissom {lissom.__version__}, numpy {np.__version__}")
    for joints in JOINTS:
        runs = calls(joints)
        # Each pair of calls sees both states: the first of each pair is at the first state.
        values = [run() for run in runs.values() for _ in range(2)]
        deviations = [
            float(np.abs(theirs - mine).max() / np.abs(mine).max())
            for mine, theirs in ((values[0], values[2]), (values[4], values[6]))
        ]
        times = in_turn(runs, SAMPLES)
        cells = [f"{1e6 * seconds:.3g} µs" for seconds in times.values()]
        print(
            "| " + " | ".join([str(joints), *cells, *(f"{each:.1e}" for each in deviations)]) + " |",
            flush=True,
        )


if __name__ == "__main__":
    main()
