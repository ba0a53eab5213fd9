"""Playback in real time, which drops frames and slows down rather than block."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

from .motion import Motion

#: Maximum computing time in seconds before a frame is drawn, even if the motion lags behind; the lag is
#: dropped, so that playback is slower than requested.
PATIENCE = 0.1

#: Time in seconds over which the real-time factor is measured.
MEASURED = 1.0

#: Largest lag after a frame, in chunks: just below one because of rounding.
ROUNDING = 1e-9


class Playback:
    """Advances a motion to the time of a clock.

    Parameters
    ----------
    motion : Motion
        The motion to advance.
    speed : float
        Simulated seconds per second.
    is_paused : bool
        Whether playback is initially paused.
    clock : callable
        Function that returns increasing times in seconds.
    """

    def __init__(
        self,
        motion: Motion,
        speed: float = 1.0,
        is_paused: bool = False,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        self.motion = motion
        self.speed = speed
        self.is_paused = is_paused
        self._clock = clock
        self._last: float | None = None
        self._owed = 0.0
        #: Wall times, times of the motion and computing times of the last frames.
        self._history: deque[tuple[float, float, float]] = deque()
        self._computed = 0.0

    def frame(self) -> None:
        """Advance the motion to the time of the clock."""
        now = self._clock()
        self._owed += self.speed * (now - (now if self._last is None else self._last))
        self._last = now
        if self.is_paused or self.motion.trouble:
            self._owed = 0.0
            self._history.clear()
            return
        self._catch_up(now + PATIENCE)
        if self.motion.trouble:
            self._history.clear()
            return
        done = self._clock()
        self._computed += done - now
        self._history.append((now, self.motion.t, self._computed))
        while self._history[-1][0] - self._history[0][0] > MEASURED:
            self._history.popleft()

    def _catch_up(self, deadline: float) -> None:
        chunk = self.motion.chunk
        while self._owed >= chunk * (1.0 - ROUNDING):
            if not self.motion.advance(chunk):
                self.is_paused = True
                return
            self._owed -= chunk
            if self._clock() >= deadline:
                # Drop any larger lag.
                self._owed = min(self._owed, chunk * (1.0 - 2.0 * ROUNDING))

    def hold(self) -> None:
        """Skip the elapsed time without advancing the motion."""
        self._last = None
        self._history.clear()

    def step(self) -> None:
        """Pause, and advance by one step."""
        self.is_paused = True
        if not self.motion.trouble:
            self.motion.advance(self.motion.step_size)

    def reset(self) -> None:
        """Return to the initial state, and continue if it was playing or had failed."""
        if self.motion.trouble:
            self.is_paused = False
        self.motion.reset()
        self._owed = 0.0
        self._history.clear()

    @property
    def real_time_factor(self) -> float | None:
        """Simulated seconds per second, over the last second; None if paused."""
        return self._rate(1)

    @property
    def load(self) -> float | None:
        """Fraction of the time spent on computing, over the last second; None if paused."""
        return self._rate(2)

    def _rate(self, column: int) -> float | None:
        if len(self._history) < 2:
            return None
        first, last = self._history[0], self._history[-1]
        return (last[column] - first[column]) / (last[0] - first[0])
