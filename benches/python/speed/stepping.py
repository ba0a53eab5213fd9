"""Cost of a step from Python: `python benches/python/speed/stepping.py`.

The native step is that of one call for many steps. Both alternate, so that other processes affect both. Other
processes can only slow calls down, so the fastest round counts.
"""

import os
import sys
import time
from pathlib import Path

import numpy as np

import lissom

sys.path.insert(0, str(Path(__file__).parents[1]))
import machine

ROUNDS = 40
STEPS = 500
#: Duration of constant inputs, seconds.
CONTROL_STEP = 10e-3


def arm(modes: dict[str, int], segments: int = 1, with_tendons: bool = True) -> lissom.Rod:
    """A soft arm of 30 cm with four tendons along it, with tensions as inputs."""
    segment = lissom.Segment(0.3 / segments, 0.01, 1e6, 4e5, 1000.0, modes, retardation_time=0.01)
    offsets = [(0.008, 0.0), (-0.008, 0.0), (0.0, 0.008), (0.0, -0.008)]
    tendons = [
        lissom.Tendon(f"t{i}", [lissom.Along("rod", offset)], tension=lissom.Input(f"t{i}", 0.0))
        for i, offset in enumerate(offsets)
    ]
    return lissom.Rod([segment] * segments, actuators=tendons if with_tendons else [])


MODELS = {
    "spring pendulum": lissom.SpringPendulum,
    "planar rod, 3 coordinates": lambda: arm({"bend_y": 3}, with_tendons=False),
    "rod, 12 coordinates": lambda: arm(
        {"torsion": 2, "bend_y": 2, "bend_z": 2}, segments=2, with_tendons=False
    ),
    "the same with four tendons": lambda: arm({"torsion": 2, "bend_y": 2, "bend_z": 2}, segments=2),
}


def fastest(*works) -> list[float]:
    """Shortest times of all works, seconds, in rounds of one after the other."""
    best = [np.inf] * len(works)
    for _ in range(ROUNDS):
        for i, work in enumerate(works):
            before = time.perf_counter()
            work()
            best[i] = min(best[i], time.perf_counter() - before)
    return best


def overhead(model: lissom.Model, dt: float) -> dict[str, float]:
    """Nanoseconds of a native step; of the overhead of calls, without inputs and with constant inputs; of
    reading q."""
    simulation = lissom.Simulation(model, dt=dt)
    simulation.step(duration=STEPS * dt)
    u = simulation.u

    def restart():
        simulation.reset()
        simulation.step()

    def native():
        restart()
        simulation.step(duration=STEPS * dt)

    def calls():
        restart()
        step = simulation.step
        for _ in range(STEPS):
            step()

    def calls_with_inputs():
        restart()
        step = simulation.step
        for _ in range(STEPS):
            step(u)

    def reads():
        restart()
        for _ in range(STEPS):
            simulation.q  # noqa: B018

    works = {"restart": restart, "native": native, "step()": calls, "step(u)": calls_with_inputs, "q": reads}
    times = dict(zip(works, fastest(*works.values()), strict=True))
    each = {name: (seconds - times["restart"]) / STEPS * 1e9 for name, seconds in times.items()}
    return {
        "native": each["native"],
        "step()": each["step()"] - each["native"],
        "step(u)": each["step(u)"] - each["native"],
        "q": each["q"],
    }


def control_steps(model: lissom.Model, dt: float) -> tuple[float, float]:
    """Control steps per second with changing inputs: of a loop in Python, and of `simulate`."""
    inputs = 0.1 + 0.05 * np.random.default_rng(0).standard_normal((STEPS, 4)).clip(-1, 1)
    simulation = lissom.Simulation(model, dt=dt)
    kept = iter(())

    def loop():
        simulation.reset()
        for u in inputs:
            simulation.step(u, CONTROL_STEP)
            simulation.q  # noqa: B018

    def control(t, q, v):
        return next(kept)

    def run():
        nonlocal kept
        kept = iter(inputs)
        t_end = STEPS * CONTROL_STEP
        lissom.simulate(model, t_end, dt=dt, control=control, control_step=CONTROL_STEP)

    return tuple(STEPS / seconds for seconds in fastest(loop, run))


def control_steps_of_many(model: lissom.Model, dt: float, count: int, workers: int) -> float:
    """Control steps per second of all rows together, with changing inputs."""
    steps = max(STEPS // count, 10)
    inputs = 0.1 + 0.05 * np.random.default_rng(0).standard_normal((steps, count, 4)).clip(-1, 1)
    many = lissom.Simulations(model, count, dt=dt, workers=workers)

    def loop():
        many.reset()
        for u in inputs:
            many.step(u, CONTROL_STEP)
            many.q  # noqa: B018

    return steps * count / fastest(loop)[0]


def main() -> None:
    """Print the tables of docs/run_times.md."""
    print(machine.description())
    print("\n| model | native step | `step()` adds | `step(u)` adds | `q` |\n|---|---|---|---|---|")
    for name, make in MODELS.items():
        row = overhead(make(), 1e-3)
        print(
            f"| {name} | {row['native']:.0f} | {row['step()']:.0f} | {row['step(u)']:.0f} | {row['q']:.0f} |"
        )
    print("\n| steps of | `Simulation` | `simulate(control=...)` |\n|---|---|---|")
    model = MODELS["the same with four tendons"]()
    for dt in (10e-3, 5e-3, 2e-3, 1e-3):
        loop, run = control_steps(model, dt)
        print(f"| {dt * 1e3:g} ms | {loop:.0f} | {run:.0f} |")
    cores = os.cpu_count() or 1
    print(f"\n| rows of `Simulations` | 1 worker | {cores} workers |\n|---|---|---|")
    for count in (1, 8, 64, 512):
        one, all_of_them = (control_steps_of_many(model, 10e-3, count, workers) for workers in (1, cores))
        print(f"| {count} | {one:.0f} | {all_of_them:.0f} |")


if __name__ == "__main__":
    main()
