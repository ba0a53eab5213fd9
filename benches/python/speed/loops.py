"""What closed loops cost: `python benches/python/speed/loops.py`.

A rod of 36 coordinates, shaken in the middle, with a free tip and with one that is held by a loop: the time
of a step of 1 ms. Whatever else runs on the machine makes it longer, so the fastest of several rounds counts.
"""

import sys
import time
from pathlib import Path

import numpy as np

import lissom

sys.path.insert(0, str(Path(__file__).parents[1]))
import machine

ROUNDS = 12
STEPS = 1000
MODES = {"torsion": 3, "bend_y": 3, "bend_z": 3, "stretch": 3, "shear_y": 3, "shear_z": 3}
#: Where the loop holds the tip: none, a point (3 rows), a point and its directions (6 rows).
KINDS = {"none": None, "spherical": lissom.Spherical(), "weld": lissom.Weld()}


def rod(kind: lissom.Joint | None) -> lissom.Robot:
    """Clamped at its base, straight where nothing acts, and held there by the loop."""
    segments = [lissom.Segment(0.15, 0.01, 1e6, 4e5, 1000.0, MODES, retardation_time=0.01)] * 2
    shaken = lissom.Load(link="rod", at=0.15, force=lissom.Harmonic((0, 0.5, 0.3), 4.0))
    loops = [] if kind is None else [lissom.Loop("rod", (None, None, (0.3, 0, 0)), kind)]
    return lissom.Robot([lissom.Link("rod", rod=segments)], loads=[shaken], loops=loops)


def main() -> None:
    print(machine.description())
    print("\n| loop | rows | µs a step | beside none | iterations a step | Jacobians a step |")
    print("|---|---|---|---|---|---|")
    robots = {name: rod(kind) for name, kind in KINDS.items()}
    best = dict.fromkeys(robots, np.inf)
    stats = {}
    for _ in range(ROUNDS):
        for name, robot in robots.items():
            before = time.perf_counter()
            run = lissom.simulate(robot, 1e-3 * STEPS, dt=1e-3, method="generalised_alpha", rho_inf=0.8)
            best[name] = min(best[name], time.perf_counter() - before)
            assert run.success, run.message
            stats[name] = run.stats
    for name, robot in robots.items():
        counts = [getattr(stats[name], what) / STEPS for what in ("newton_iterations", "njev")]
        print(
            f"| {name} | {robot.constraints} | {1e6 * best[name] / STEPS:.1f} "
            f"| {best[name] / best['none']:.2f} | {counts[0]:.2f} | {counts[1]:.2f} |"
        )


if __name__ == "__main__":
    main()
