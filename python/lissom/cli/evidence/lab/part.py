"""A part of the lab: sections of the page, and numbers."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from statistics import median
from typing import Any, TypeVar

from ...._lissom import AccuracyWarning, MotionResult
from ....drawing.report.page import Section
from ....drawing.report.text import quantity

T = TypeVar("T")

#: Timed runs are repeated for at least this time in seconds, or this number of times; the median counts.
TIMING_SECONDS = 0.5
MOST_REPEATS = 25


@dataclass(frozen=True)
class Part:
    """Sections of the page, and the same results as numbers."""

    sections: Sequence[Section]
    numbers: dict[str, Any]


@contextmanager
def steps_too_long_on_purpose() -> Iterator[None]:
    """Suppress warnings about steps that are too long, because the lab demonstrates their effect."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)
        yield


def timed(work: Callable[[], T]) -> tuple[T, float]:
    """The result of ``work`` and its run time in seconds."""
    times: list[float] = []
    while True:
        start = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - start)
        if sum(times) > TIMING_SECONDS or len(times) >= MOST_REPEATS:
            return result, median(times)


def seconds(value: float) -> str:
    """A run time, including the report's infinite one."""
    return "“infinite”" if math.isinf(value) else quantity(value, "s")


def timed_run(beside: float | None, run: Callable[[], MotionResult]) -> tuple[MotionResult, dict[str, Any]]:
    """A motion, and its row in a table beside the report's run time, None if it has none."""
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


def stopped(what: str, motion: MotionResult) -> str:
    """A sentence about a run that did not reach its end, with a space before it; empty otherwise."""
    return "" if motion.success else f" {what} stopped at {motion.t[-1]:g} s."


#: Columns common to all tables of run times, and the names of those with numbers.
RUN_COLUMNS = ("report", "lissom", "faster", "steps", "outcome")
NUMERIC = frozenset({"report", "lissom", "faster", "steps"})


def run_cells(run: dict[str, Any]) -> tuple[str, ...]:
    """Cells of these columns. Runs that did not reach their end have no speed-up."""
    published, found = run["report_seconds"], run["lissom_seconds"]
    report = "–" if published is None else seconds(published)
    if not run["success"]:
        faster, outcome = "–", f"stopped at {run['reached_seconds']:g} s"
    elif published is None or math.isinf(published):
        faster, outcome = "–", "finished"
    else:
        faster, outcome = f"{float(f'{published / found:.2g}'):,.10g} ×", "finished"
    return (report, seconds(found), faster, f"{run['steps']:,}", outcome)
