"""Cost of gradients of a run relative to the run: docs/run_times.md, "Derivatives of runs".

python benches/python/speed/sensitivities.py [--repeats 7]
"""

from __future__ import annotations

import argparse
import time
from statistics import median

import numpy as np

import lissom

SEGMENTS = 25
T_END = 1.0
CONTROL_STEP = 0.02


def rod(**options) -> lissom.Rod:
    segment = lissom.Segment(0.02, 0.01, 4e5, 1.5e5, 1100, modes={"bend_y": 1}, retardation_time=0.02)
    return lissom.Rod([segment] * SEGMENTS, **options)


def last(t, q, v):
    """Half the square of the last coordinate, the farthest from the base, at the final time."""
    weight = np.zeros_like(q)
    weight[-1, -1] = q[-1, -1]
    return 0.5 * q[-1, -1] ** 2, weight, np.zeros_like(q)


def of_each(*keys: str) -> list[str]:
    return [f"segments[{i}].{key}" for i in range(SEGMENTS) for key in keys]


def tried():
    """Names and functions to be timed, the run first."""
    plain = rod()
    tendon = lissom.Tendon("pull", [lissom.Along(offset=(0, -0.006))], tension=lissom.Input("pull", 0.1))
    steered = rod(actuators=[tendon])
    held = {"u": np.full((round(T_END / CONTROL_STEP), 1), 0.1), "control_step": CONTROL_STEP}

    def gradient(names, model=plain, **options):
        return lambda: lissom.sensitivity(model, T_END, names, objective=last, **options)

    yield "the run", lambda: lissom.simulate(plain, T_END)
    yield "its gradient, 50 coordinates and velocities at the start", gradient(["q0", "v0"])
    yield "25 moduli and 25 retardation times", gradient(of_each("young_modulus", "retardation_time"))
    yield "25 radii and 25 densities", gradient(of_each("radius", "density"))
    yield "25 lengths", gradient(of_each("length"))
    yield "50 control steps of a tendon", gradient(["u"], steered, **held)
    names = of_each("young_modulus", "retardation_time")
    yield "all states, 25 moduli and 25 retardation times", lambda: lissom.sensitivity(plain, T_END, names)


def identified():
    """A fit of five parameters to two points of a finger over 3 s, with noise of 0.1 mm."""

    def segment(young_modulus, retardation_time, radius):
        options = {"modes": {"bend_y": 2}, "retardation_time": retardation_time}
        return lissom.Segment(0.15, radius, young_modulus, 5e5, 1100, **options)

    finger = lissom.Rod([segment(3e5, 0.02, 0.01), segment(2.5e5, 0.015, 0.009)], tip_mass=0.005)
    run = lissom.simulate(finger, 3.0)
    places = [0.15, 0.3]
    points = np.stack([finger.pose(run.q[1:], X)[:, :3, 3] for X in places], axis=1)
    points += 1e-4 * np.random.default_rng(0).standard_normal(points.shape)
    guesses = {
        "segments[0].young_modulus": (1e5, 4e5, 1e6),
        "segments[1].young_modulus": (1e5, 3e5, 1e6),
        "segments[0].retardation_time": (1e-3, 0.01, 0.1),
        "segments[1].retardation_time": (1e-3, 0.01, 0.1),
        "tip_mass": (1e-4, 3e-3, 2e-2),
    }
    return lambda: lissom.fit(finger, (run.t[1:], points), guesses, places=places)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=7)
    repeats = parser.parse_args().repeats
    functions = dict(tried())
    seconds: dict[str, list[float]] = {name: [] for name in functions}
    for _ in range(repeats):
        # In turn, so that other processes affect all alike.
        for name, function in functions.items():
            start = time.perf_counter()
            function()
            seconds[name].append(time.perf_counter() - start)
    run = seconds["the run"]
    for name, times in seconds.items():
        ratio = median(t / r for t, r in zip(times, run, strict=True))
        print(f"{name:60} {1e3 * median(times):8.1f} ms {ratio:8.1f} runs")
    fit = identified()
    # The first fit imports SciPy.
    fit()
    walls, processor = [], []
    for _ in range(repeats):
        start = time.perf_counter(), time.process_time()
        found = fit()
        walls.append(time.perf_counter() - start[0])
        processor.append(time.process_time() - start[1])
    print(
        f"{f'fit of five parameters to 3 s, {found.runs} runs':60} {1e3 * median(walls):8.1f} ms, "
        f"{1e3 * median(processor):.1f} ms of processor time"
    )


if __name__ == "__main__":
    main()
