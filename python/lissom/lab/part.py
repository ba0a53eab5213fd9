"""What every part of the lab hands over."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from statistics import median
from typing import Any, TypeVar

from .._lissom import AccuracyWarning, MotionResult
from ..report.page import Section
from ..report.text import quantity

T = TypeVar("T")

#: A run is timed again until so many seconds are spent, or so often; the median counts.
TIMING_SECONDS = 0.5
MOST_REPEATS = 25


@dataclass(frozen=True)
class Part:
    """Sections of the page, and the same in numbers."""

    sections: Sequence[Section]
    numbers: dict[str, Any]


@contextmanager
def steps_too_long_on_purpose() -> Iterator[None]:
    """Within it nobody is warned: the lab shows what comes of such steps."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)
        yield


def timed(work: Callable[[], T]) -> tuple[T, float]:
    """The result of ``work`` and the seconds it takes."""
    times: list[float] = []
    while True:
        start = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - start)
        if sum(times) > TIMING_SECONDS or len(times) >= MOST_REPEATS:
            return result, median(times)


def seconds(value: float) -> str:
    """A run time, the report's infinite one included."""
    return "“infinite”" if math.isinf(value) else quantity(value, "s")


def timed_run(beside: float, run: Callable[[], MotionResult]) -> tuple[MotionResult, dict[str, Any]]:
    """A motion, and the numbers of its row in a table beside the report's run time."""
    motion, taken = timed(run)
    numbers = {
        "report_seconds": beside,
        "lissom_seconds": taken,
        "steps": motion.stats.steps,
        "success": motion.success,
        "reached_seconds": float(motion.t[-1]),
        "message": motion.message,
    }
    return motion, numbers


#: The columns that all tables of run times share, with those of numbers named again.
RUN_COLUMNS = ("report", "lissom", "faster", "steps", "outcome")
NUMERIC = frozenset({"report", "lissom", "faster", "steps"})


def run_cells(run: dict[str, Any]) -> tuple[str, ...]:
    """The cells of these columns. A run that did not reach its end is not faster than one that did."""
    published, found = run["report_seconds"], run["lissom_seconds"]
    if not run["success"]:
        faster, outcome = "–", f"stopped at {run['reached_seconds']:g} s"
    elif math.isinf(published):
        faster, outcome = "–", "finished"
    else:
        faster, outcome = f"{float(f'{published / found:.2g}'):,.10g} ×", "finished"
    return (seconds(published), seconds(found), faster, f"{run['steps']:,}", outcome)
