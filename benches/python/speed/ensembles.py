"""Runs per second: `python benches/python/speed/ensembles.py` prints the tables of docs/run_times.md.

A loop of `simulate`, `simulate_many` on one thread and on all threads, and a process pool alternate, so that
other processes on the machine affect all of them. Other processes can only slow runs down, so the fastest
round counts. Takes about two minutes.
"""

import concurrent.futures
import multiprocessing
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import lissom

sys.path.insert(0, str(Path(__file__).parents[1]))
import machine

from rods import KERNELS, rod, soft

ROUNDS = 7
STEP = 1e-2
#: Duration of the motion, seconds.
DURATION = 1.0
CORES = os.cpu_count() or 1


def hand() -> lissom.Robot:
    """A palm with three soft fingers of 12 coordinates each."""
    palm = lissom.Link("palm", body=lissom.Body(0.1))
    fingers = [
        lissom.Link(
            f"finger {i}",
            parent="palm",
            position=(0.02 * np.cos(angle), 0.02 * np.sin(angle), 0.0),
            rod=[lissom.Segment(**soft(0.15, (4, 4, 4, 0, 0, 0)))],
        )
        for i, angle in enumerate(2 * np.pi / 3 * np.arange(3))
    ]
    return lissom.Robot([palm, *fingers])


#: Models with the number of runs per round.
MODELS = {
    "lab's rod": (lambda: rod(KERNELS["lab-3"]), 1000),
    "rod, two segments": (lambda: rod(KERNELS["two-12"]), 200),
    "hand with three soft fingers": (hand, 60),
}

#: Seconds for 256 runs of 1 s with SoRoMoX on an RTX 5090, from its authors' tables
#: (github.com/tud-phi/soromox, paper_results/secIVb_parallel_rollouts_gpu/data, "gvs" by segments; steps of
#: 0.1 ms, output every 10 ms): from the paper, and since September 2026.
SOROMOX = {6: (71.9, 10.9), 12: (175.3, 13.6)}


def done(result: lissom.EnsembleResult) -> lissom.EnsembleResult:
    """Returns the result, after a check that no run failed: failed runs are quick."""
    assert result.success.all(), set(result.message)
    return result


def starts(model: lissom.Model, count: int) -> np.ndarray:
    """Initial shapes with different small bends."""
    return 0.01 * np.random.default_rng(0).standard_normal((count, model.n))


def fastest(*works, rounds: int = ROUNDS) -> list[float]:
    """Shortest times of all works, seconds, in rounds of one after the other."""
    best = [np.inf] * len(works)
    for _ in range(rounds):
        for i, work in enumerate(works):
            before = time.perf_counter()
            work()
            best[i] = min(best[i], time.perf_counter() - before)
    return best


def some(task: tuple[lissom.Model, np.ndarray]) -> list[np.ndarray]:
    """The work of a process: runs one after the other, whose states are sent back."""
    model, q0 = task
    return [lissom.simulate(model, DURATION, dt=STEP, q0=start).q for start in q0]


def rates(model: lissom.Model, count: int, pool) -> dict[str, float]:
    """Runs per second."""
    q0 = starts(model, count)
    parts = [(model, part) for part in np.array_split(q0, 4 * CORES)]

    def loop():
        for start in q0:
            assert lissom.simulate(model, DURATION, dt=STEP, q0=start).success

    def many(workers):
        return lambda: done(lissom.simulate_many(model, DURATION, dt=STEP, q0=q0, workers=workers))

    def processes():
        for _ in pool.map(some, parts):
            pass

    works = {"loop": loop, "one": many(1), "all": many(CORES), "processes": processes}
    return {name: count / took for name, took in zip(works, fastest(*works.values()), strict=True)}


def kept(model: lissom.Model, count: int) -> dict[str, tuple[float, float]]:
    """Runs per second and megabytes of the saved results."""
    q0 = starts(model, count)
    found = {}
    for keep in ("states", "final", "summary"):

        def many(keep=keep):
            return done(lissom.simulate_many(model, DURATION, dt=STEP, q0=q0, keep=keep))

        (took,) = fastest(many)
        found[keep] = (count / took, many().nbytes / 1e6)
    return found


def beside_soromox(n: int, dt: float) -> float:
    """Seconds for 256 runs of segments with constant strain."""
    segments = n // 6
    model = rod([soft(0.3 / segments, (1,) * 6)] * segments)
    q0 = 1e-3 * np.random.default_rng(0).standard_normal((256, n))
    t_eval = np.linspace(0.0, DURATION, 101)

    def many():
        done(lissom.simulate_many(model, DURATION, dt=dt, q0=q0, t_eval=t_eval))

    return fastest(many)[0]


def sweeps() -> dict[str, float]:
    """Milliseconds per point: of `simulate_many`, a local sweep, one with a store, and one by Dask."""
    from distributed import Client, LocalCluster

    values = np.linspace(1.9e11, 2.3e11, 1000)
    model = rod(KERNELS["lab-3"])
    parameters = {"segments[0].young_modulus": values}
    options = {"t_end": DURATION, "dt": STEP}
    models = [
        lissom.Rod([lissom.Segment(**(KERNELS["lab-3"][0] | {"young_modulus": value}))]) for value in values
    ]

    def sweep(**more):
        return lambda: lissom.sweep(model, parameters, **more, **options)

    def stored():
        with tempfile.TemporaryDirectory() as folder:
            sweep(store=Path(folder) / "s")()

    cluster = {"n_workers": CORES, "threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": None}
    with LocalCluster(**cluster) as local, Client(local) as client:
        works = {
            "`simulate_many`": lambda: lissom.simulate_many(models, **options),
            "`sweep`": sweep(),
            "`sweep` with a store": stored,
            "`sweep` by Dask": sweep(executor=client),
        }
        return {
            name: took / len(values) * 1e3
            for name, took in zip(works, fastest(*works.values(), rounds=3), strict=True)
        }


def main() -> None:
    """Print the tables."""
    print(machine.description())
    print("\n| model | coordinates | loop of `simulate` | 1 thread | ", end="")
    print(f"{CORES} threads | scaling | {CORES} processes |\n|---|---|---|---|---|---|---|")
    with concurrent.futures.ProcessPoolExecutor(
        CORES, mp_context=multiprocessing.get_context("spawn")
    ) as pool:
        for name, (make, count) in MODELS.items():
            model = make()
            found = rates(model, count, pool)
            numbers = " | ".join(f"{found[key]:.0f}" for key in ("loop", "one", "all"))
            scaling = found["all"] / found["one"]
            print(f"| {name} | {model.n} | {numbers} | {scaling:.2f} | {found['processes']:.0f} |")
    print("\n| keep | runs a second | kept of 200 runs, MB |\n|---|---|---|")
    for keep, (rate, megabytes) in kept(rod(KERNELS["two-12"]), 200).items():
        print(f"| {keep} | {rate:.0f} | {megabytes:.2f} |")
    print("\n| coordinates | dt = 2 ms | dt = 1 ms | SoRoMoX, paper | since September 2026 |")
    print("|---|---|---|---|---|")
    for n, (paper, since) in SOROMOX.items():
        print(f"| {n} | {beside_soromox(n, 2e-3):.3f} | {beside_soromox(n, 1e-3):.3f} | {paper} | {since} |")
    print("\n| 1000 points of the lab's rod | ms a point |\n|---|---|")
    for name, milliseconds in sweeps().items():
        print(f"| {name} | {milliseconds:.3f} |")


if __name__ == "__main__":
    main()
