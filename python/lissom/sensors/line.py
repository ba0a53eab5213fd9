"""Sampling and delay between a sensor and its reader."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: So much of a period or a delay is left to rounding of the times: what is due then is not late.
ROUNDING = 1e-6


class Line:
    """Sample and hold: a reading is the last sample that is at least the delay old, or the first one.

    Parameters
    ----------
    rate : float or None
        Samples per second, counted from the first reading; by default every reading is one.
    delay : float
        Seconds.
    """

    def __init__(self, rate: float | None, delay: float) -> None:
        self.rate = rate
        self.delay = delay
        # The ring: times and values of the samples that are shown now or later.
        self.samples: deque[tuple[float, Array]] = deque()
        self.first = self.last = np.nan
        self.number = 0

    def read(self, t: float, sample: Callable[[], Array]) -> Array:
        """What is shown at a time, not before that of the last reading. Takes a sample where one is due."""
        if t < self.last:
            raise ValueError(
                f"t: got {t}, expected no time before the last reading's, {self.last}; `reset` begins anew"
            )
        if not self.samples:
            self.first = t
        # Equal times have one sample.
        number = self._number(t, self.first)
        if not self.samples or (t > self.last if number is None else number > self.number):
            self.samples.append((t, sample()))
            self.number = 0 if number is None else int(number)
        self.last = t
        while len(self.samples) > 1 and self.samples[1][0] <= self._shown_until(t):
            self.samples.popleft()
        return self.samples[0][1]

    def taken(self, t: Array) -> NDArray[np.bool_]:
        """At which of these times, which do not decrease, samples are taken, from the first one on."""
        number = self._number(t, t[:1])
        return np.diff(t if number is None else number, prepend=-np.inf) > 0

    def shown(self, t: Array, taken: Array) -> NDArray[np.intp]:
        """Which of the samples that are taken at some times are shown at others."""
        arrived: NDArray[np.intp] = np.searchsorted(taken, self._shown_until(t), side="right")
        return np.maximum(arrived - 1, 0)

    # The same for one time and for many, so that these cannot differ.

    def _number(self, t: Any, first: Any) -> Any:
        """How many samples after the first one are due."""
        return None if self.rate is None else np.floor((t - first) * self.rate + ROUNDING)

    def _shown_until(self, t: Any) -> Any:
        """Samples up to this time have arrived."""
        return t - (1 - ROUNDING) * self.delay
