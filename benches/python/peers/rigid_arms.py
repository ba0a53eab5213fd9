"""Serial chains of rigid links with revolute joints about x, y and z in turn, and timing of calls on them.

The same robots as in benches/robot.rs. Imports none of the other codes: each has an environment of its own.
"""

import statistics
import time
import timeit
from collections.abc import Callable

import numpy as np
from rigid_trees import Member, Tree

LINK, MASS, CENTRE, INERTIA = 0.1, 0.1, (0.05, 0.01, 0.0), 1e-4
NO_TURN = np.array([1.0, 0.0, 0.0, 0.0])

# A sample lasts at least so many seconds, so that the clock's resolution does not count.
SAMPLE = 2e-3


def arm(joints: int) -> Tree:
    return Tree(
        tuple(
            Member(
                parent=index - 1 if index else None,
                position=np.array([LINK if index else 0.0, 0.0, 0.0]),
                orientation=NO_TURN,
                kind="revolute",
                axes=(np.eye(3)[index % 3],),
                armature=0.0,
                mass=MASS,
                centre=np.array(CENTRE),
                principal=np.full(3, INERTIA),
                principal_axes=NO_TURN,
            )
            for index in range(joints)
        ),
        np.array([0.0, 0.0, -9.81]),
    )


def elapsed(run: Callable[[], object], calls: int) -> float:
    """Processor time in seconds: what a quiet machine would take, though others wait for the core as well."""
    return timeit.timeit(run, timer=time.process_time, number=calls)


def in_turn(runs: dict[str, Callable[[], object]], samples: int) -> dict[str, float]:
    """Medians of the times of a call, in seconds."""
    calls = {}
    for name, run in runs.items():
        calls[name] = 1
        while elapsed(run, calls[name]) < SAMPLE:
            calls[name] *= 2
    times: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(samples):
        for name, run in runs.items():
            times[name].append(elapsed(run, calls[name]) / calls[name])
    return {name: statistics.median(found) for name, found in times.items()}
