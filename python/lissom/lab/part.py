"""What every part of the lab hands over."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any, TypeVar

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


def times_faster(published: float, found: float) -> str:
    """How many times faster than the report."""
    ratio = published / found
    return "finishes" if math.isinf(ratio) else f"{float(f'{ratio:.2g}'):,.10g} ×"
