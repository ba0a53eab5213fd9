"""Run times of the lab's scenes beside the lab report's: the table of README.md.

    python benches/python/lab.py [--json FILE]
"""

import argparse
import json
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import lissom

REPETITIONS = 15
SCENES = Path(__file__).parents[2] / "scenes"

# Seconds, tables 1 and 2 of the report; it names no Jacobian.
REPORT_HORIZONTAL = {"newmark": 46.239, "rk45": float("inf")}
REPORT_HANGING = {"newmark": 5.8227, "rk45": 5.6295}
REPORT_PENDULUM = {("newmark", 1.0): 0.2586, ("rk45", 1.0): 0.24964, ("newmark", 1e-2): 98.0278, ("rk45", 1e-2): 0.79022}


def measure(run: Callable[[], Any]) -> tuple[float, Any]:
    """Median wall time of a simulation as its caller sees it, in seconds, and its result."""
    times = []
    for _ in range(REPETITIONS):
        start = time.perf_counter()
        result = run()
        times.append(time.perf_counter() - start)
    return statistics.median(times), result


def cases():
    """What is run: name, the report's time, the run."""
    steel = dict(length=1.0, radius=1e-3, young_modulus=210e9, shear_modulus=80e9, density=7800.0)
    wire = lissom.Segment(**steel, modes={"bend_y": 3}, retardation_time=1e-4)
    horizontal = lissom.Rod([wire])
    hanging = lissom.Rod([wire], base_orientation=(np.sqrt(0.5), 0, np.sqrt(0.5), 0))
    for title, rod, report in (
        ("rod released from horizontal", horizontal, REPORT_HORIZONTAL),
        ("rod hanging", hanging, REPORT_HANGING),
    ):
        for jac in ("analytic", "forward", "central"):
            yield (
                f"{title}, 3 s, implicit at 10 ms, {jac} Jacobian",
                report["newmark"],
                lambda rod=rod, jac=jac: lissom.simulate(rod, 3.0, dt=1e-2, jac=jac),
            )
        yield f"{title}, 3 s, explicit (RK45)", report["rk45"], lambda rod=rod: lissom.simulate(rod, 3.0, method="rk45")

    start = {"q0": [-np.pi / 4, 0.5], "v0": [0.0, 0.0]}
    pendulum = lissom.SpringPendulum()
    for dt in (1.0, 1e-2):
        for method, word in (("newmark", "implicit"), ("rk45", "explicit (RK45)")):
            yield (
                f"spring pendulum, 1000 s, {word}, {'step' if method == 'newmark' else 'output every'} {dt:g} s",
                REPORT_PENDULUM[method, dt],
                lambda method=method, dt=dt: lissom.simulate(pendulum, 1000.0, method=method, dt=dt, **start),
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, help="write the numbers there")
    options = parser.parse_args()
    rows = []
    print("| | the lab report | lissom | ends |\n|---|---|---|---|")
    for name, report, run in cases():
        seconds, result = measure(run)
        ends = f"after {result.t[-1]:g} s: {result.message}" if not result.success else "finished"
        rows.append({"case": name, "report_s": report, "lissom_s": seconds, "nfev": result.stats.nfev, "ends": ends})
        print(f"| {name} | {report:.4g} s | {1e3 * seconds:.3g} ms | {ends} |")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
