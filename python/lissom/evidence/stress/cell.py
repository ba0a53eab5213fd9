"""What a cell of the stress test is, and how it ends."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from ..._lissom import LissomError

Kind = Literal["accurate", "slow", "refused", "failed", "wrong"]

#: From the best to the worst: a cell that moves towards the end has regressed.
KINDS: tuple[Kind, ...] = ("accurate", "slow", "refused", "failed", "wrong")

#: What they mean, for people.
MEANINGS: dict[Kind, str] = {
    "accurate": "the result is right",
    "slow": "the result is right, and took more evaluations than it should",
    "refused": "bad input was refused before any work, with a reason",
    "failed": "no result of the accuracy wanted, and lissom says why",
    "wrong": "a wrong result was called success: this must never happen",
}

#: Evaluations of the equations of motion above which a right result is called slow.
SLOW_EVALUATIONS = 100_000


@dataclass(frozen=True)
class Outcome:
    """How a cell ended."""

    kind: Kind
    #: Why it did not end better; else what was compared with what.
    reason: str = ""
    #: Error, relative to the size of what is compared; None where there is nothing to compare.
    error: float | None = None
    #: Evaluations of the equations of motion.
    evaluations: int = 0
    #: Wall time, references included.
    seconds: float = 0.0


@dataclass(frozen=True)
class Cell:
    """One hard case."""

    row: str
    column: str
    work: Callable[[], Outcome]
    #: Whether the short run has it as well.
    quick: bool = False

    def run(self) -> Outcome:
        """Do the work. Refusals and failures that are raised are outcomes like others."""
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
    """Cells of one theme: one heat map."""

    name: str
    title: str
    #: What the rows are, and what the columns are.
    rows: str
    columns: str
    cells: Sequence[Cell]
    #: What is done in them and what it is compared with.
    text: str
    #: What there is to learn from it.
    lesson: str = ""


def one_line(message: object) -> str:
    """A message without line breaks."""
    return " ".join(str(message).split())
