"""The validation gallery: questions with known answers, asked of lissom and shown as one table.

Every module of this package holds the cases of one theme; ``exact`` computes wanted values with NumPy alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from .._lissom import __version__
from ..results import MARK, SUMMARY, atomic_folder, write_summary
from . import buckling, dynamics, frame, frequencies, peers, rotation, statics, supports
from .case import Case, Outcome, run

__all__ = ["CASES", "Case", "Outcome", "run", "run_all", "write"]

#: All cases, in the order of the table.
CASES: tuple[Case, ...] = (
    *statics.CASES,
    *buckling.CASES,
    *supports.CASES,
    *frequencies.CASES,
    *dynamics.CASES,
    *rotation.CASES,
    *frame.CASES,
    *peers.CASES,
)


def run_all(
    cases: Sequence[Case] = CASES, progress: Callable[[Outcome], object] = lambda outcome: None
) -> list[Outcome]:
    """Run cases one after the other; ``progress`` hears of each that is done or left out."""
    outcomes = []
    for case in cases:
        outcomes.append(run(case))
        progress(outcomes[-1])
    return outcomes


def write(
    outcomes: Sequence[Outcome], target: Path, report: Callable[[Sequence[Outcome], Path], None] | None
) -> list[Path]:
    """Write the results folder of the gallery; return its files. Raises NotOurs like ``results.write``."""
    files = [target / SUMMARY]
    with atomic_folder(target) as folder:
        if report is not None:
            report(outcomes, folder / "report.html")
            files.insert(0, target / "report.html")
        numbers = {
            MARK: __version__,
            "study": "validation",
            "good": not any(outcome.outside for outcome in outcomes),
            "cases": [outcome.numbers for outcome in outcomes],
        }
        write_summary(numbers, folder)
    return files
