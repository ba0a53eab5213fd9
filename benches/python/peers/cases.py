"""The two cases that every code simulates, and how a run is timed and reported.

Needs nothing but Python and NumPy: it is imported by scripts that run in an environment of their own.
"""

import argparse
import json
import os
import sys
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np

GRAVITY = 9.81
DURATION = 1.0
# The tip is compared at these times, a hundredth of a second apart.
TIMES = np.linspace(0.0, DURATION, 101)
OUTPUT_STEP = 0.01

# A run is repeated until so many seconds or runs, and the shortest counts.
SECONDS = 1.0
MOST_RUNS = 20
# A series of ever finer runs ends with the first that takes longer than this, in seconds.
LONGEST_RUN = 60.0
QUICK_LONGEST_RUN = 2.0


@dataclass(frozen=True)
class Rod:
    """A straight rod of circular section without a shear correction; SI units."""

    length: float
    radius: float
    young_modulus: float
    density: float

    @property
    def shear_modulus(self) -> float:
        """Of an incompressible material: Poisson's ratio is 1/2."""
        return self.young_modulus / 3.0

    @property
    def area(self) -> float:
        return np.pi * self.radius**2

    @property
    def sound_speed(self) -> float:
        """Of waves of stretch."""
        return float(np.sqrt(self.young_modulus / self.density))


# Clamped at the origin along world x, gravity along -z, undamped, let go at rest.
RUBBER_ROD = Rod(length=1.0, radius=0.02, young_modulus=5e6, density=1000.0)

# SoRoMoX's own benchmark (spatial GVS of its paper, arXiv 2608.06650, section IV-A): two segments, each with
# linear bending about y and z and linear stretch, gravity across the rod, material damping.
SEGMENT = Rod(length=0.3, radius=0.03, young_modulus=1e6, density=1000.0)
SEGMENTS = 2
SEGMENT_GRAVITY = (-GRAVITY, -GRAVITY, 0.0)
SEGMENT_ORIENTATION = (0.5, 0.5, 0.5, -0.5)  # w, x, y, z
SEGMENT_VISCOSITY = 1e4  # Pa s; bending and stretch are damped by three times as much (Trouton's ratio)


def packages(*names: str) -> None:
    """Print the versions of the packages that are measured."""
    print(json.dumps({"versions": {name: version(name) for name in names}}), flush=True)


def on_one_core() -> None:
    """Keep this process and its threads on one core, as the processor times of all threads add up."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def shortest(run: Callable[[], np.ndarray], longest: float) -> tuple[np.ndarray, float]:
    """The result of the run, and its shortest processor time in seconds: other programs count little."""
    best, spent, runs = np.inf, 0.0, 0
    while runs == 0 or (spent < min(SECONDS, longest) and runs < MOST_RUNS):
        start = time.process_time()
        outcome = run()
        elapsed = time.process_time() - start
        best, spent, runs = min(best, elapsed), spent + elapsed, runs + 1
    return outcome, best


def record(
    case: str,
    code: str,
    discretisation: str,
    step: str,
    seconds: float,
    tips: np.ndarray,
    compile_seconds: float = 0.0,
) -> dict:
    """One run: `step` says how it steps in time, `tips` of shape (101, 3) is where the tip is at TIMES."""
    return {
        "case": case,
        "code": code,
        "discretisation": discretisation,
        "step": step,
        "seconds": seconds,
        "compile_seconds": compile_seconds,
        "tips": np.where(np.isfinite(tips), tips, np.inf).tolist(),
    }


def print_run(run: dict) -> None:
    """One line of JSON for the driver, one to read."""
    print(json.dumps(run), flush=True)
    print(f"{run['code']}, {run['discretisation']}, {run['step']}: {run['seconds']:.3g} s", file=sys.stderr)


def run_series(series: Iterable[Callable[[], dict]], longest: float) -> None:
    """Print one run after the other until one takes too long."""
    for make in series:
        run = make()
        print(json.dumps(run), flush=True)
        print(
            f"{run['code']}, {run['discretisation']}, {run['step']}: {run['seconds']:.3g} s", file=sys.stderr
        )
        if run["seconds"] > longest:
            return


def quick_requested(description: str) -> bool:
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--quick", action="store_true", help="only runs of a few seconds")
    return parser.parse_args().quick


def steps_per_output(largest_step: float, fractions: Iterable[float]) -> list[int]:
    """How many equal steps fit between two output times when none may be larger than fractions of this."""
    return sorted({int(np.ceil(OUTPUT_STEP / (fraction * largest_step))) for fraction in fractions})
