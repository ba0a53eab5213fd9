"""Run times of the lab's scenes compared with those of the lab report: the table of README.md.

python benches/python/speed/lab.py [--json FILE]
"""

import argparse
import json
import statistics
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import lissom

REPETITIONS = 15
STEP = 1e-2

# Seconds, from tables 1 and 2 of the report, which does not name the Jacobian; one of its runs never ended.
REPORT_RELEASED = {"implicit": 46.239, "explicit": float("inf")}
REPORT_HANGING = {"implicit": 5.8227, "explicit": 5.6295}
REPORT_PENDULUM = {
    1.0: {"implicit": 0.2586, "explicit": 0.24964},
    1e-2: {"implicit": 98.0278, "explicit": 0.79022},
}

Case = tuple[str, float, Callable[[], Any]]


def rod_cases(title: str, orientation: tuple[float, ...], report: dict[str, float]) -> Iterator[Case]:
    """The lab's rod for 3 s: implicit with each Jacobian, and explicit."""
    wire = lissom.Segment(
        length=1.0,
        radius=1e-3,
        young_modulus=210e9,
        shear_modulus=80e9,
        density=7800.0,
        modes={"bend_y": 3},
        retardation_time=1e-4,
    )
    rod = lissom.Rod([wire], base_orientation=orientation)
    for jac in ("analytic", "forward", "central"):
        name = f"{title}, 3 s, implicit, step {STEP:g} s, {jac} Jacobian"
        yield name, report["implicit"], lambda jac=jac: lissom.simulate(rod, 3.0, dt=STEP, jac=jac)
    name = f"{title}, 3 s, explicit (RK45)"
    yield name, report["explicit"], lambda: lissom.simulate(rod, 3.0, method="rk45", dt=STEP)


def pendulum_cases(dt: float, report: dict[str, float]) -> Iterator[Case]:
    """The spring pendulum for 1000 s."""

    def run(method: str) -> Callable[[], Any]:
        pendulum = lissom.SpringPendulum()
        return lambda: lissom.simulate(pendulum, 1000.0, q0=[-np.pi / 4, 0.5], method=method, dt=dt)

    yield f"spring pendulum, 1000 s, implicit, step {dt:g} s", report["implicit"], run("newmark")
    yield f"spring pendulum, 1000 s, explicit (RK45), every {dt:g} s", report["explicit"], run("rk45")


def cases() -> Iterator[Case]:
    """Names, times of the report in seconds, and runs."""
    yield from rod_cases("rod, released", (1, 0, 0, 0), REPORT_RELEASED)
    yield from rod_cases("rod, hanging", (np.sqrt(0.5), 0, np.sqrt(0.5), 0), REPORT_HANGING)
    for dt, report in REPORT_PENDULUM.items():
        yield from pendulum_cases(dt, report)


def measure(run: Callable[[], Any], repetitions: int) -> tuple[float, Any]:
    """Median wall time of a simulation as seen by its caller, seconds, and its result."""
    times = []
    for _ in range(repetitions):
        start = time.perf_counter()
        result = run()
        times.append(time.perf_counter() - start)
    return statistics.median(times), result


def rows(repetitions: int = REPETITIONS) -> Iterator[dict[str, Any]]:
    """Every case: time of the report (None if the run never ended), our time, evaluations, and status."""
    for name, report, run in cases():
        seconds, result = measure(run, repetitions)
        end = "finished" if result.success else f"{result.status} at t = {result.t[-1]:g} s"
        yield {
            "case": name,
            "report": report if np.isfinite(report) else None,
            "seconds": seconds,
            "nfev": result.stats.nfev,
            "end": end,
        }


def main() -> None:
    parser = argparse.ArgumentParser(description="Run times of the lab's scenes beside the lab report's.")
    parser.add_argument("--json", type=Path, help="write the numbers there")
    options = parser.parse_args()
    found = []
    print("| | the lab's report | lissom | |\n|---|---|---|---|")
    for row in rows():
        found.append(row)
        quoted = "never ends" if row["report"] is None else f"{row['report']:.4g} s"
        print(f"| {row['case']} | {quoted} | {1e3 * row['seconds']:.3g} ms | {row['end']} |")
    if options.json:
        options.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
