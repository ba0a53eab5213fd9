"""Cost of closed loops. Other processes can only slow runs down, so the fastest of several rounds counts.

python benches/python/speed/loops.py            # steps of a shaken rod, its tip free or held
python benches/python/speed/loops.py --statics  # equilibria of six wires with a plate
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

import lissom

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[3] / "tests" / "python" / "loops"))
import machine
import test_loops_shooting as wires

ROUNDS = 12
STEPS = 1000
MODES = {"torsion": 3, "bend_y": 3, "bend_z": 3, "stretch": 3, "shear_y": 3, "shear_z": 3}
#: Joint by which the loop holds the tip: none, a point (3 rows), or a point and its directions (6 rows).
KINDS = {"none": None, "spherical": lissom.Spherical(), "weld": lissom.Weld()}


def rod(kind: lissom.Joint | None) -> lissom.Robot:
    """A rod clamped at its base, straight without load, with its tip held there by the loop."""
    segments = [lissom.Segment(0.15, 0.01, 1e6, 4e5, 1000.0, MODES, retardation_time=0.01)] * 2
    shaken = lissom.Load(link="rod", at=0.15, force=lissom.Harmonic((0, 0.5, 0.3), 4.0))
    loops = [] if kind is None else [lissom.Loop("rod", (None, None, (0.3, 0, 0)), kind)]
    return lissom.Robot([lissom.Link("rod", rod=segments)], loads=[shaken], loops=loops)


def steps() -> None:
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


def equilibria() -> None:
    robot = wires.six_wires({"torsion": 2, "bend_y": 3, "bend_z": 3})
    bent = wires.bent_like_an_s(robot)
    rest = lissom.statics(robot, bent, method="descent")
    noise = np.random.default_rng(0).standard_normal(robot.n)
    starts = {"as an S": bent, "2 percent off": rest.q * (1 + 0.02 * noise), "at rest": rest.q}
    print(f"\n{robot.n} coordinates, {robot.constraints} constraints")
    print("\n| start | method | ms | iterations | distance from the shape that descent finds |")
    print("|---|---|---|---|---|")
    best = dict.fromkeys([(start, method) for start in starts for method in ("newton", "descent")], np.inf)
    found = {}
    for _ in range(ROUNDS):
        for start, method in best:
            before = time.perf_counter()
            result = lissom.statics(robot, starts[start], method=method)
            best[start, method] = min(best[start, method], time.perf_counter() - before)
            assert result.success, result.message
            found[start, method] = result
    for (start, method), result in found.items():
        away = np.abs(result.q - rest.q).max()
        print(f"| {start} | {method} | {1e3 * best[start, method]:.2f} | {result.nit} | {away:.1e} |")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--statics", action="store_true", help="equilibria in place of steps")
    arguments = parser.parse_args()
    print(machine.description())
    if arguments.statics:
        equilibria()
    else:
        steps()


if __name__ == "__main__":
    main()
