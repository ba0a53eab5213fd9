"""Control steps per second of environments for reinforcement learning.

`python benches/python/speed/environments.py`: one thread, random actions; for comparison, the times of the
robots alone. Other processes on the machine can only slow both down, so the fastest of several rounds counts.
Times are processor times.
"""

import sys
import time
from pathlib import Path

import gymnasium
import numpy as np

import lissom.gym  # noqa: F401 (registers them)

sys.path.insert(0, str(Path(__file__).parents[1]))
import machine

ROUNDS = 12
STEPS = 50


def fastest(*works) -> list[float]:
    """Shortest processor times of all works, seconds."""
    best = [np.inf] * len(works)
    for _ in range(ROUNDS):
        for i, work in enumerate(works):
            before = time.process_time()
            work()
            best[i] = min(best[i], time.process_time() - before)
    return best


def rates(name: str, count: int) -> list[float]:
    """Rates of many environments, of their robots alone, and of single environments one after the other."""
    envs = gymnasium.make_vec(name, num_envs=count, workers=1)
    one = gymnasium.make(name).unwrapped
    envs.reset(seed=0)
    envs.action_space.seed(0)
    actions = [envs.action_space.sample() for _ in range(STEPS)]
    inputs = [envs.task.inputs(each.astype(float)) for each in actions]

    def together():
        for each in actions:
            envs.step(each)

    def robots():
        # Both start from the same states: poles that are not caught would keep rotating.
        envs.reset(seed=0)
        for each in inputs:
            envs.simulations.step(each, envs.task.control_step)

    def begin():
        envs.reset(seed=0)

    def single():
        one.reset(seed=0)
        for each in actions:
            one.step(each[0])

    of_envs, of_robots, of_reset, of_one = fastest(together, robots, begin, single)
    return [count * STEPS / of_envs, count * STEPS / (of_robots - of_reset), STEPS / of_one]


def main() -> None:
    print(machine.description())
    print("| environment | 64 together | their robots alone | one alone |\n|---|---|---|---|")
    for name in ("Reach", "Balance", "Swim"):
        together, robots, single = rates(f"lissom/{name}-v0", 64)
        print(f"| {name} | {together:.0f} | {robots:.0f} | {single:.0f} |")


if __name__ == "__main__":
    main()
