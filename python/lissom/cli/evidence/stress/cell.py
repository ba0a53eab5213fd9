"""Cells of the stress test and their outcomes."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from ...._lissom import LissomError

Kind = Literal["accurate", "slow", "refused", "failed", "wrong"]

#: Outcomes from best to worst: a cell that moves towards the end has regressed.
KINDS: tuple[Kind, ...] = ("accurate", "slow", "refused", "failed", "wrong")

#: Descriptions of the outcomes.
MEANINGS: dict[Kind, str] = {
    "accurate": "the result is right",
    "slow": "the result is right, and took more evaluations than it should",
    "refused": "bad input was refused before any work, with a reason",
    "failed": "no result of the accuracy wanted, and lissom says why",
    "wrong": "a wrong result was called success: this must never happen",
}

#: Number of evaluations of the equations of motion above which a correct result counts as slow.
SLOW_EVALUATIONS = 100_000


@dataclass(frozen=True)
class Outcome:
    """Outcome of a cell."""

    kind: Kind
    #: Reason of an outcome that is not the best; otherwise what was compared.
    reason: str = ""
    #: Error relative to the size of the compared quantity; None without a comparison.
    error: float | None = None
    #: Number of evaluations of the equations of motion.
    evaluations: int = 0
    #: Wall time, including references.
    seconds: float = 0.0


@dataclass(frozen=True)
class Cell:
    """One hard case."""

    row: str
    column: str
    work: Callable[[], Outcome]
    #: Whether the short run includes the cell.
    quick: bool = False

    def run(self) -> Outcome:
        """Run the cell. Exceptions for refusals and failures are outcomes too."""
        start = time.perf_counter()
        try:
            outcome = self.work()
        except (ValueError, TypeError) as error:
            outcome = Outcome("refused", one_line(error))
        except LissomError as error:
            outcome = Outcome("failed", one_line(error))
        except Exception as error:
            outcome = Outcome("wrong", f"raised {type(error).__name__}: {one_line(error)}")
        return replace(outcome, seconds=time.perf_counter() - start)


@dataclass(frozen=True)
class Group:
    """Cells of one theme, shown as a heat map."""

    name: str
    title: str
    #: Meaning of the rows and of the columns.
    rows: str
    columns: str
    cells: Sequence[Cell]
    #: Description of the computation and of the comparison.
    text: str
    #: Conclusion from the results.
    lesson: str = ""


def one_line(message: object) -> str:
    """A message without line breaks."""
    return " ".join(str(message).split())
