"""How a soft fish should beat to swim farthest: a search along the gradient beside CMA-ES, each run counted.

Four muscles along the fish bend it with one frequency; how much and when each of them does is searched for,
eight numbers, within bounds. `lissom.sensitivity` finds the gradient of the distance by the adjoint, SciPy's
L-BFGS-B goes along it. CMA-ES (package `cma`) knows distances only.

    python examples/python/gait_search.py [--time seconds] [--evaluations number] [--seed number]
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field

import cma
import numpy as np
from scipy.optimize import minimize

import lissom

LENGTH, MUSCLES, FREQUENCY = 0.3, 4, 1.0
STRONGEST = 10.0  # active curvature, radians per metre
DT = 0.01
NAMES = [f"actuators[{i}].amount.{key}" for key in ("amplitude", "phase") for i in range(MUSCLES)]
LOW = np.array([0.0] * MUSCLES + [-2 * np.pi] * MUSCLES)
HIGH = np.array([STRONGEST] * MUSCLES + [2 * np.pi] * MUSCLES)


def fish(gait) -> lissom.Robot:
    """A silicone eel in still water that swims in a plane; `gait` has the amplitudes, then the phases."""
    segment = lissom.Segment(
        LENGTH,
        radius=0.01,
        young_modulus=3e5,
        poisson_ratio=0.5,
        density=1000.0,
        modes={"bend_z": 4},
        retardation_time=0.02,
    )
    stations = np.linspace(0, LENGTH, MUSCLES)
    muscles = [
        lissom.ActiveStrain(
            "fish",
            "bend_z",
            (stations, np.eye(MUSCLES)[i]),
            lissom.Harmonic(gait[i], FREQUENCY, phase=gait[MUSCLES + i]),
            name=f"muscle {i}",
        )
        for i in range(MUSCLES)
    ]
    return lissom.Robot(
        [lissom.Link("fish", joint=lissom.Planar((0, 0, 1)), rod=[segment])],
        gravity=(0, 0, 0),
        actuators=muscles,
        fluid=lissom.Fluid(1000.0, drag_coefficients=(1.2, 0.01)),
    )


def distance_of_head(t, q, v):
    """How far the head is ahead at the end (it leads towards -x), and its derivatives."""
    weight = np.zeros_like(q)
    weight[-1, 0] = -1.0
    return -q[-1, 0], weight, np.zeros_like(q)


@dataclass
class Swim:
    """The distance that a gait swims, with and without its gradient; both are counted."""

    t_end: float
    runs: int = field(default=0, init=False)
    gradients: int = field(default=0, init=False)

    def gradient(self, gait):
        """The distance and its gradient, each one run and one adjoint."""
        self.gradients += 1
        found = lissom.sensitivity(fish(gait), self.t_end, NAMES, dt=DT, objective=distance_of_head)
        return found.value, found.gradient

    def distances(self, gaits):
        """Of many gaits, on all processors; a run that fails swims nowhere."""
        self.runs += len(gaits)
        found = lissom.simulate_many([fish(gait) for gait in gaits], self.t_end, dt=DT, keep="final")
        return np.where(found.success, -found.q[:, 0], 0.0)


def along_gradient(swim: Swim, start):
    """The best gait that L-BFGS-B finds, and the best distance after each gradient."""
    best = []

    def loss(x):
        value, gradient = swim.gradient(LOW + (HIGH - LOW) * x)
        best.append(max([value, *best[-1:]]))
        return -value, -(HIGH - LOW) * gradient

    found = minimize(loss, scaled(start), jac=True, method="L-BFGS-B", bounds=[(0, 1)] * len(NAMES))
    return LOW + (HIGH - LOW) * found.x, np.array(best)


def by_evolution(swim: Swim, start, evaluations: int, seed: int):
    """The best gait that CMA-ES finds, and the best distance after each run."""
    settings = {"bounds": [0, 1], "seed": seed, "maxfevals": evaluations, "verbose": -9}
    strategy = cma.CMAEvolutionStrategy(scaled(start), 0.2, settings)
    best = []
    while not strategy.stop():
        gaits = strategy.ask()
        values = swim.distances([LOW + (HIGH - LOW) * x for x in gaits])
        strategy.tell(gaits, list(-values))
        for value in values:
            best.append(max([value, *best[-1:]]))
    return LOW + (HIGH - LOW) * strategy.result.xbest, np.array(best)


def scaled(gait):
    return (np.asarray(gait) - LOW) / (HIGH - LOW)


def main(argv=None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--time", type=float, default=3.0)
    parser.add_argument("--evaluations", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(argv)
    # Half the strength, in a wave from head to tail.
    start = [0.5 * STRONGEST] * MUSCLES + list(-np.linspace(0, 2, MUSCLES))
    swim = Swim(options.time)
    print(f"The start swims {1e3 * swim.distances([start])[0]:.1f} mm in {options.time:g} s.")
    swim.runs = 0
    begin = time.perf_counter()
    gait, by_gradient = along_gradient(swim, start)
    between = time.perf_counter()
    evolved, by_chance = by_evolution(swim, start, options.evaluations, options.seed)
    end = time.perf_counter()
    level = 0.99 * max(by_gradient[-1], by_chance[-1])
    print(
        "           best [mm]  evaluations  until 99 % of the better  time [s]  amplitudes [1/m] and phases"
    )
    for name, numbers, best, seconds in (
        ("L-BFGS-B", gait, by_gradient, between - begin),
        ("CMA-ES", evolved, by_chance, end - between),
    ):
        reached = str(np.argmax(best >= level) + 1) if best[-1] >= level else "never"
        print(
            f"{name:9}  {1e3 * best[-1]:9.1f}  {len(best):11}  {reached:>24}  {seconds:8.1f}  "
            + " ".join(f"{number:.2f}" for number in numbers)
        )


if __name__ == "__main__":
    main()
