"""Ctrl-C in the command line: heard from the first moment on, and answered where nothing is lost by it.

Imports nothing that takes time: it is there before NumPy and the extension module are.
"""

from __future__ import annotations

import os
import signal
import time

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable
    from types import FrameType
    from typing import TypeVar

    T = TypeVar("T")

#: What Ctrl-C is answered where it raises nothing.
STOPPING = "The simulation stops at its next step; what it computed is saved."
SAVING = "What was computed is being saved; that ends by itself."

#: Seconds after a KeyboardInterrupt in which another Ctrl-C raises none, so that cleaning up ends.
CALM = 1.0


class Interruption:
    """Whether somebody pressed Ctrl-C, and what the next one does."""

    def __init__(self) -> None:
        #: True from the first Ctrl-C on.
        self.requested = False
        self._raises = False
        self._calm_until = 0.0
        self._word = b""

    def install(self) -> None:
        """Note Ctrl-C from here on; it raises nothing until ``answer``."""
        signal.signal(signal.SIGINT, self._hear)

    def answer(self) -> None:
        """From here on Ctrl-C raises KeyboardInterrupt; so does one that was pressed earlier."""
        self._raises = True
        if self.requested:
            raise KeyboardInterrupt

    def defer(self, word: str = "") -> None:
        """From here on Ctrl-C is noted, and answered by a word alone."""
        self._raises = False
        self._word = f"{word}\n".encode() if word else b""

    def collect(self, computed: Iterable[T]) -> list[T]:
        """What is computed until Ctrl-C, which is deferred then; KeyboardInterrupt if that is nothing."""
        found: list[T] = []
        try:
            # Not a loop of Python's, between whose steps Ctrl-C would lose what has just been computed.
            found.extend(computed)
            self.defer(SAVING)
        except KeyboardInterrupt:
            self.defer(SAVING)
            if not found:
                raise
        return found

    def _hear(self, number: int, frame: FrameType | None) -> None:
        self.requested = True
        if self._raises:
            if time.monotonic() >= self._calm_until:
                self._calm_until = time.monotonic() + CALM
                raise KeyboardInterrupt
        elif self._word:
            # What was interrupted may be writing to sys.stderr, which cannot be entered twice.
            os.write(2, self._word)


#: The one of this process.
interruption = Interruption()
