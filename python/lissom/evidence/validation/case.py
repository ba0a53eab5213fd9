"""What a case of the gallery is, and how it is run."""

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

#: Where a wanted value comes from: a formula; equations solved by other means; a publication.
Origin = Literal["exact", "computed", "published"]

#: A case is run again until so many seconds are spent, or so often; the median of the run times counts.
TIMING_SECONDS = 0.05
MOST_REPEATS = 9


@dataclass(frozen=True)
class Curve:
    """One line of a plot, or points where it is not ``joined``."""

    name: str
    x: ArrayLike
    y: ArrayLike
    joined: bool = True


@dataclass(frozen=True)
class Plot:
    """What the plot of a case shows."""

    x: str
    y: str
    curves: Sequence[Curve]
    #: Whether a metre is as long in both directions.
    to_scale: bool = False


@dataclass(frozen=True)
class Answer:
    """What lissom says."""

    values: ArrayLike
    #: Makes the plot, after the time was taken.
    plot: Callable[[], Plot]
    #: What went wrong; then the values do not count.
    failure: str = ""


@dataclass(frozen=True)
class Package:
    """A Python package that some cases need."""

    name: str
    module: str
    #: The command that installs it.
    install: str

    @property
    def missing(self) -> str:
        """Why it cannot be used here; nothing if it can."""
        found = self.module in sys.modules or find_spec(self.module) is not None
        return "" if found else f"{self.name} is not installed ({self.install})"


@dataclass(frozen=True)
class Case:
    """One question with a known answer."""

    name: str
    theme: str
    #: The rod and its loads in a sentence or two.
    setting: str
    #: Author, year, where.
    source: str
    origin: Origin
    #: What the values are, with units.
    quantity: str
    wanted: Callable[[], ArrayLike]
    solve: Callable[[], Answer]
    #: Largest error that is good.
    tolerance: float
    #: What errors are divided by; the largest wanted value unless given.
    scale: float | None = None
    #: Without it the case is not run.
    needs: Package | None = None


@dataclass(frozen=True)
class Outcome:
    """A case that was run, or why it was not."""

    case: Case
    wanted: Array
    found: Array
    #: Largest difference, relative to the scale; infinite where nothing was found.
    error: float
    #: Median run time of lissom's answer, model included, in seconds.
    seconds: float
    plot: Plot | None
    failure: str = ""
    #: What the case needs and is not here; then nothing else counts.
    not_run: str = ""

    @property
    def good(self) -> bool:
        """Whether the case was run and its error is within the tolerance."""
        return not self.not_run and self.error <= self.case.tolerance

    @property
    def outside(self) -> bool:
        """Whether the case was run and its error is not."""
        return not self.not_run and not self.good

    @property
    def numbers(self) -> dict[str, Any]:
        """The outcome as plain JSON."""
        case = self.case
        return {
            "case": case.name,
            "theme": case.theme,
            "source": case.source,
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
    """Ask lissom, take the time, compare; not where what the case needs is missing."""
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
