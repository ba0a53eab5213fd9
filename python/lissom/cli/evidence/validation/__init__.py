"""The validation gallery: comparisons with known solutions, in one table.

Every module contains the cases of one theme; ``exact`` computes reference values with NumPy alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from ...._lissom import __version__
from ....results.files import write_report, write_summary
from ....results.folders import MARK
from . import (
    beams,
    buckling,
    contacts,
    dynamics,
    frame,
    frequencies,
    jumper,
    lines,
    paths,
    peers,
    rotation,
    rotor,
    sorosim,
    statics,
    supports,
    turbine,
)
from .case import Case, Outcome, run

__all__ = ["CASES", "Case", "Outcome", "run", "run_all", "write"]

#: All cases, in the order of the table.
CASES: tuple[Case, ...] = (
    *statics.CASES,
    *buckling.CASES,
    *supports.CASES,
    *lines.CASES,
    *contacts.CASES,
    *beams.CASES,
    *paths.CASES,
    *frequencies.CASES,
    *dynamics.CASES,
    *jumper.CASES,
    *rotation.CASES,
    *rotor.CASES,
    *turbine.CASES,
    *frame.CASES,
    *sorosim.CASES,
    *peers.CASES,
)


def run_all(cases: Sequence[Case] = CASES) -> Iterator[Outcome]:
    """Run cases one after the other."""
    yield from map(run, cases)


def write(
    outcomes: Sequence[Outcome], folder: Path, report: Callable[[Sequence[Outcome], Path], None] | None
) -> list[str]:
    """Write the files of the gallery into an empty folder; return problems with writing, as in
    ``results``."""
    numbers = {
        MARK: __version__,
        "study": "validation",
        "whole": len(outcomes) == len(CASES),
        "good": not any(outcome.outside for outcome in outcomes),
        "cases": [outcome.numbers for outcome in outcomes],
    }
    write_summary(numbers, folder)
    return write_report(report, outcomes, folder / "report.html")
