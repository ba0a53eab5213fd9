"""What a case of the gallery is, and how it is run."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
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


@dataclass(frozen=True)
class Outcome:
    """A case that was run."""

    case: Case
    wanted: Array
    found: Array
    #: Largest difference, relative to the scale; infinite where nothing was found.
    error: float
    #: Median run time of lissom's answer, model included, in seconds.
    seconds: float
    plot: Plot | None
    failure: str = ""

    @property
    def good(self) -> bool:
        """Whether the error is within the tolerance."""
        return self.error <= self.case.tolerance

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
            "good": self.good,
            "failure": self.failure,
            "run_seconds": self.seconds,
        }


def run(case: Case) -> Outcome:
    """Ask lissom, take the time, compare."""
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
