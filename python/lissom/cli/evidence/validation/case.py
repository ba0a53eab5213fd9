"""Cases of the gallery, and their execution."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from statistics import median
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

#: Origin of a reference value: a formula; equations solved by other means; a publication.
Origin = Literal["exact", "computed", "published"]

#: Timed runs are repeated for at least this time in seconds, or this number of times; the median counts.
TIMING_SECONDS = 0.05
MOST_REPEATS = 9


@dataclass(frozen=True)
class Curve:
    """A line of a plot, or points if it is not ``joined``."""

    name: str
    x: ArrayLike
    y: ArrayLike
    joined: bool = True


@dataclass(frozen=True)
class Plot:
    """Content of a case's plot."""

    x: str
    y: str
    curves: Sequence[Curve]
    #: Whether both axes have the same scale.
    to_scale: bool = False


@dataclass(frozen=True)
class Answer:
    """Result of lissom."""

    values: ArrayLike
    #: Creates the plot, after the timing.
    plot: Callable[[], Plot]
    #: Reason of a failure; the values are then invalid.
    failure: str = ""


@dataclass(frozen=True)
class Package:
    """A Python package that some cases need."""

    name: str
    module: str
    #: Installation command.
    install: str

    @property
    def missing(self) -> str:
        """Reason why it cannot be used; empty if it can."""
        found = self.module in sys.modules or find_spec(self.module) is not None
        return "" if found else f"{self.name} is not installed ({self.install})"


@dataclass(frozen=True)
class Case:
    """A question with a known answer."""

    name: str
    theme: str
    #: The rod and its loads in one or two sentences.
    setting: str
    #: Author, year and reference.
    source: str
    origin: Origin
    #: The compared quantity with units.
    quantity: str
    wanted: Callable[[], ArrayLike]
    solve: Callable[[], Answer]
    #: Largest acceptable error.
    tolerance: float
    #: Divisor of errors; by default the largest reference value.
    scale: float | None = None
    #: Package without which the case is skipped.
    needs: Package | None = None
    #: Errors of other codes in this case, as their authors published them.
    others: str = ""


@dataclass(frozen=True)
class Outcome:
    """Outcome of a case, or the reason why it was skipped."""

    case: Case
    wanted: Array
    found: Array
    #: Largest difference relative to the scale; infinite without a result.
    error: float
    #: Median run time of lissom in seconds, including the creation of the model.
    seconds: float
    plot: Plot | None
    failure: str = ""
    #: Missing requirement of a skipped case; all other fields are then invalid.
    not_run: str = ""

    @property
    def good(self) -> bool:
        """Whether the case was run with an error within the tolerance."""
        return not self.not_run and self.error <= self.case.tolerance

    @property
    def outside(self) -> bool:
        """Whether the case was run with an error beyond the tolerance."""
        return not self.not_run and not self.good

    @property
    def numbers(self) -> dict[str, Any]:
        """The outcome as plain JSON."""
        case = self.case
        return {
            "case": case.name,
            "theme": case.theme,
            "source": case.source,
            "others": case.others,
            "origin": case.origin,
            "quantity": case.quantity,
            "wanted": self.wanted.tolist(),
            "found": [value if np.isfinite(value) else None for value in self.found.tolist()],
            "error": self.error if np.isfinite(self.error) else None,
            "tolerance": case.tolerance,
            "good": None if self.not_run else self.good,
            "failure": self.failure,
            "not_run": self.not_run,
            "run_seconds": None if self.not_run else self.seconds,
        }


def run(case: Case) -> Outcome:
    """Run lissom, measure the time, and compare; skip the case if a requirement is missing."""
    if case.needs is not None and case.needs.missing:
        nothing = np.empty(0)
        return Outcome(case, nothing, nothing, np.inf, np.nan, None, not_run=case.needs.missing)
    wanted = np.atleast_1d(np.asarray(case.wanted(), dtype=float))
    times: list[float] = []
    while sum(times) < TIMING_SECONDS and len(times) < MOST_REPEATS:
        start = time.perf_counter()
        answer = case.solve()
        times.append(time.perf_counter() - start)
    seconds = median(times)
    if answer.failure:
        return Outcome(case, wanted, np.full_like(wanted, np.nan), np.inf, seconds, None, answer.failure)
    found = np.atleast_1d(np.asarray(answer.values, dtype=float))
    scale = np.abs(wanted).max() if case.scale is None else case.scale
    difference = np.abs(found - wanted) if found.shape == wanted.shape else np.array(np.inf)
    error = float(np.max(difference) / scale)
    return Outcome(case, wanted, found, error if np.isfinite(error) else np.inf, seconds, answer.plot())
