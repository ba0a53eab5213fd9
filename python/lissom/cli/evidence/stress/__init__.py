"""The stress test: a matrix of hard cases, each of which must succeed or give a reason.

A cell is a function that returns an outcome (``cell``). Groups of cells are heat maps, with one module for
each theme. ``judge`` decides whether results are correct; ``table`` compares them with the committed ones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ...._lissom import __version__
from ....results.files import write_report, write_summary
from ....results.folders import MARK
from . import ill_posed, lab_scene, loads, long_runs, scaling, shapes, steps, sweeps, touching
from .cell import KINDS, Cell, Group, Kind, Outcome

#: Groups in the order of the report.
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
    touching.group,
    long_runs.group,
    ill_posed.models,
    ill_posed.motions,
    lab_scene.group,
)


@dataclass(frozen=True)
class Done:
    """A group and the outcomes of its cells, in order."""

    group: Group
    outcomes: tuple[Outcome, ...]

    @property
    def counts(self) -> dict[Kind, int]:
        """Number of cells by outcome."""
        kinds = [outcome.kind for outcome in self.outcomes]
        return {kind: kinds.count(kind) for kind in KINDS}


def run(quick: bool) -> Iterator[Done]:
    """Run the groups of the matrix, or of its short version."""
    for make in GROUPS:
        group = make()
        cells = [cell for cell in group.cells if cell.quick or not quick]
        chosen = Group(**{**vars(group), "cells": cells})
        yield Done(chosen, tuple(cell.run() for cell in cells))


def total(done: list[Done]) -> dict[Kind, int]:
    """Counts over all groups."""
    return {kind: sum(group.counts[kind] for group in done) for kind in KINDS}


def numbers(done: list[Done], quick: bool, regressions: list[str]) -> dict[str, Any]:
    """The matrix as plain JSON."""
    return {
        MARK: __version__,
        "study": "stress",
        "quick": quick,
        "whole": len(done) == len(GROUPS),
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
    folder: Path,
    quick: bool,
    regressions: list[str],
    report: Callable[[list[Done], list[str], Path], None] | None,
) -> list[str]:
    """Write the files into an empty folder; return problems with writing, like ``files.write``."""
    write_summary(numbers(done, quick, regressions), folder)
    pages = None if report is None else partial(report, done)
    return write_report(pages, regressions, folder / "report.html")


__all__ = ["GROUPS", "Cell", "Done", "Group", "Outcome", "numbers", "run", "total", "write"]
