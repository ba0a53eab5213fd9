"""Runs of the pile in PyElastica; started by pile.py."""

import warnings
from functools import partial

from cases import packages
from pile_elastica import Simulated, largest_stable_step
from pile_runs import Resolutions, arguments, one_core, print_all, runs

ELEMENTS, STEPS = (10, 20, 40), (4e-4, 2e-4, 1e-4)
# Of the largest stable step of the rods, which contacts make a little smaller.
MARGIN = 0.95


def resolutions(rods: int) -> Resolutions:
    """Of elements of each rod and steps."""
    pairs = tuple(
        (elements, step)
        for elements in ELEMENTS
        for step in STEPS
        if step <= MARGIN * largest_stable_step(elements)
    )
    return Resolutions(pairs, (80, 5e-5) if rods < 50 else (60, 1e-4), (40, 2e-4))


def main() -> None:
    piles, quick = arguments(__doc__)
    one_core()
    # PyElastica warns of its own deprecated arguments.
    warnings.simplefilter("ignore")
    packages("pyelastica", "numba", "numpy")
    for code, built_in in {"PyElastica": False, "PyElastica, its own contacts": True}.items():
        build = partial(Simulated, built_in=built_in)
        # Numba compiles, or loads what it has compiled before.
        build(piles[min(piles)], 10, 1e-4).state(0.1)
        # With its own contacts 50 rods would say no more than 20, and take as long as all the others.
        own = {rods: pile for rods, pile in piles.items() if not built_in or rods < 50}
        print_all(runs(code, "elements", own, resolutions, build, () if quick else own))


if __name__ == "__main__":
    main()
