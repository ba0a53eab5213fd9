"""The stress test: a matrix of hard cases, each of which has to end well or to say why it does not.

A cell is a function that returns an outcome (``cell``); groups of cells are heat maps, one
module for each theme. What is right is decided in ``judge``; what was committed is compared in ``table``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .._lissom import __version__
from ..results import MARK, atomic_folder, write_summary
from . import ill_posed, lab_scene, loads, long_runs, scaling, shapes, steps, sweeps
from .cell import KINDS, Cell, Group, Kind, Outcome

#: The groups in the order of the report.
GROUPS: tuple[Callable[[], Group], ...] = (
    sweeps.slenderness,
    sweeps.modulus,
    sweeps.density,
    sweeps.taper,
    scaling.group,
    steps.wire_group,
    steps.arm_group,
    sweeps.modes,
    sweeps.segments,
    sweeps.masses,
    shapes.circles,
    shapes.far_from_rest,
    loads.buckling,
    loads.follower,
    loads.snap_through,
    long_runs.group,
    ill_posed.models,
    ill_posed.motions,
    lab_scene.group,
)


@dataclass(frozen=True)
class Done:
    """A group and how its cells ended, in the order of the cells."""

    group: Group
    outcomes: tuple[Outcome, ...]

    @property
    def counts(self) -> dict[Kind, int]:
        """How many cells ended in which way."""
        kinds = [outcome.kind for outcome in self.outcomes]
        return {kind: kinds.count(kind) for kind in KINDS}


def run(quick: bool, progress: Callable[[str], object] = lambda name: None) -> list[Done]:
    """Run the matrix, or the short version of it; ``progress`` hears the name of every group that begins."""
    done = []
    for make in GROUPS:
        group = make()
        cells = [cell for cell in group.cells if cell.quick or not quick]
        progress(group.title)
        chosen = Group(**{**vars(group), "cells": cells})
        done.append(Done(chosen, tuple(cell.run() for cell in cells)))
    return done


def total(done: list[Done]) -> dict[Kind, int]:
    """Counts over all groups."""
    return {kind: sum(group.counts[kind] for group in done) for kind in KINDS}


def numbers(done: list[Done], quick: bool, regressions: list[str]) -> dict[str, Any]:
    """The matrix as plain JSON."""
    return {
        MARK: __version__,
        "study": "stress",
        "quick": quick,
        "counts": total(done),
        "regressions": regressions,
        "groups": {group.group.name: _group(group) for group in done},
    }


def _group(done: Done) -> dict[str, Any]:
    cells = [
        {
            "row": cell.row,
            "column": cell.column,
            "outcome": outcome.kind,
            "reason": outcome.reason,
            "error": outcome.error,
            "evaluations": outcome.evaluations,
            "seconds": round(outcome.seconds, 3),
        }
        for cell, outcome in zip(done.group.cells, done.outcomes, strict=True)
    ]
    return {"title": done.group.title, "counts": done.counts, "cells": cells}


def write(
    done: list[Done],
    target: Path,
    quick: bool,
    regressions: list[str],
    report: Callable[[list[Done], list[str], Path], None] | None,
) -> list[Path]:
    """Write the results folder; return its files. Raises NotOurs like ``results.write``."""
    with atomic_folder(target) as folder:
        write_summary(numbers(done, quick, regressions), folder)
        files = [target / "summary.json"]
        if report is not None:
            report(done, regressions, folder / "report.html")
            files.append(target / "report.html")
    return files


__all__ = ["GROUPS", "Cell", "Done", "Group", "Outcome", "numbers", "run", "total", "write"]
