"""Runs of the pile in MuJoCo; started by pile.py."""

from itertools import product

from cases import packages
from pile_mujoco import Simulated
from pile_runs import Resolutions, arguments, one_core, print_all, runs

STEPS = (5e-4, 2e-4, 1e-4, 5e-5)


def resolutions(rods: int) -> Resolutions:
    """Of pieces of each rod and steps; finer references of many rods would take many minutes."""
    if rods < 50:
        reference = (40, 2.5e-5) if rods < 20 else (30, 2.5e-5)
        return Resolutions(tuple(product((6, 10, 20), STEPS)), reference, (20, 1e-4))
    pairs = (*product((6, 10), STEPS), *((20, step) for step in STEPS[1:]))
    return Resolutions(pairs, (30, 5e-5), (10, 2e-4))


def main() -> None:
    piles, quick = arguments(__doc__)
    one_core()
    packages("mujoco", "numpy")
    print_all(runs("MuJoCo", "pieces", piles, resolutions, Simulated, () if quick else piles))


if __name__ == "__main__":
    main()
