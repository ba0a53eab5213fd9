"""A code's runs of the pile, from coarse to fine, one line of JSON for each."""

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import pile_scene
from pile_scene import Motion, Pile, State


class Moving(Protocol):
    """A pile that has not moved yet; it can do one of the two, once."""

    def motion(self) -> Motion: ...

    def state(self, time: float) -> State: ...


@dataclass(frozen=True)
class Resolutions:
    """Sizes and steps of the runs, the reference, and what settles: a size and a step each."""

    pairs: tuple[tuple[int, float], ...]
    reference: tuple[int, float]
    settling: tuple[int, float]


def one_core() -> None:
    """For this process and for all threads that anything starts."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def runs(
    code: str,
    unit: str,
    piles: dict[int, Pile],
    resolutions: Callable[[int], Resolutions],
    build: Callable[[Pile, int, float], Moving],
    settles: Iterable[int],
) -> Iterable[dict]:
    """Every run of each pile; those in `settles` are also followed until they have settled."""
    for rods, pile in piles.items():
        steps = resolutions(rods)
        for size, step in (*steps.pairs, steps.reference):
            # A pile can move once only.
            motion = pile_scene.repeated(
                lambda pile=pile, size=size, step=step: build(pile, size, step).motion()
            )
            run = pile_scene.record(code, rods, size, f"{size} {unit}", step, motion)
            print(f"{rods} rods, {code}, {size} {unit}, {step:g} s: {run['seconds']:.3g} s", file=sys.stderr)
            yield run
        if rods in settles:
            size, step = steps.settling
            state = build(pile, size, step).state(pile_scene.SETTLED)
            yield {"code": code, "rods": rods, "settled": pile_scene.settled(state)}


def arguments(description: str | None) -> tuple[dict[int, Pile], bool]:
    """The piles to run, and whether quickly."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--quick", action="store_true", help="small piles only")
    parser.add_argument("--scene", type=Path, required=True, help="where the rods start; pile.py writes it")
    options = parser.parse_args()
    return pile_scene.read(options.scene), options.quick


def print_all(found: Iterable[dict]) -> None:
    for run in found:
        print(json.dumps(run), flush=True)
