"""Sampling and delay between a sensor and its reader."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Tolerance for rounding of times, relative to a period or a delay.
ROUNDING = 1e-6


class Line:
    """Sample and hold: a reading is the latest sample that is at least as old as the delay, or the first one.

    Parameters
    ----------
    rate : float or None
        Samples per second, starting at the first reading; by default every reading is a sample.
    delay : float
        Delay, seconds.
    """

    def __init__(self, rate: float | None, delay: float) -> None:
        self.rate = rate
        self.delay = delay
        # Times and values of the samples that readings return now or later.
        self.samples: deque[tuple[float, Array]] = deque()
        self.first = self.last = np.nan
        self.number = 0

    def read(self, t: float, sample: Callable[[], Array]) -> Array:
        """Reading at a time, not before that of the last reading. Takes a sample if one is due."""
        if t < self.last:
            raise ValueError(f"t: got {t}, before the last reading at {self.last}: `reset` starts again")
        if not self.samples:
            self.first = t
        # One sample for equal times.
        number = self._number(t, self.first)
        if not self.samples or (t > self.last if number is None else number > self.number):
            self.samples.append((t, sample()))
            self.number = 0 if number is None else int(number)
        self.last = t
        while len(self.samples) > 1 and self.samples[1][0] <= self._shown_until(t):
            self.samples.popleft()
        return self.samples[0][1]

    def taken(self, t: Array) -> NDArray[np.bool_]:
        """Which of these non-decreasing times have a sample, including the first one."""
        number = self._number(t, t[:1])
        return np.diff(t if number is None else number, prepend=-np.inf) > 0

    def shown(self, t: Array, taken: Array) -> NDArray[np.intp]:
        """Indices of the samples that readings at these times return, given which times have samples."""
        arrived: NDArray[np.intp] = np.searchsorted(taken, self._shown_until(t), side="right")
        return np.maximum(arrived - 1, 0)

    # Common formulas for single and many times, so that both agree exactly.

    def _number(self, t: Any, first: Any) -> Any:
        """Number of samples due after the first one."""
        return None if self.rate is None else np.floor((t - first) * self.rate + ROUNDING)

    def _shown_until(self, t: Any) -> Any:
        """Latest time of the samples that have arrived."""
        return t - (1 - ROUNDING) * self.delay
