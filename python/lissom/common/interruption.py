"""Ctrl-C in the command line: recorded from the start, and handled when no data are lost.

Imports nothing slow, because it is used before NumPy and the extension module are imported.
"""

from __future__ import annotations

import operator
import os
import signal
import time

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from types import FrameType
    from typing import TypeVar

    T = TypeVar("T")

#: Message after Ctrl-C if no exception is raised.
STOPPING = "The simulation stops at its next step; what it computed is saved."
SAVING = "What was computed is being saved; that ends by itself."

#: Seconds after a KeyboardInterrupt during which another Ctrl-C is ignored, so that cleanup can finish.
CALM = 1.0


class Interruption:
    """Whether Ctrl-C was pressed, and the effect of the next one."""

    def __init__(self) -> None:
        #: True from the first Ctrl-C on.
        self.requested = False
        self._raises = False
        self._calm_until = 0.0
        self._word = b""

    def install(self) -> None:
        """Record Ctrl-C from now on without raising, until ``answer``."""
        signal.signal(signal.SIGINT, self._on_interrupt)

    def answer(self) -> None:
        """From now on Ctrl-C raises KeyboardInterrupt; so does an earlier one."""
        self._raises = True
        if self.requested:
            raise KeyboardInterrupt

    def defer(self, word: str = "") -> None:
        """Record Ctrl-C from now on, and only print a message."""
        self._raises = False
        self._word = f"{word}\n".encode() if word else b""

    def collect(self, computed: Iterable[T]) -> list[T]:
        """The results computed until Ctrl-C, which is deferred; raise KeyboardInterrupt if there are none."""
        found: list[T] = []
        try:
            # `extend` consumes the iterator in C. In a Python loop, Ctrl-C could lose the current item.
            found.extend(computed)
            self.defer(SAVING)
        except KeyboardInterrupt:
            self.defer(SAVING)
            if not found:
                raise
        return found

    def finish(self, compute: Callable[[], T]) -> T:
        """What a computation finds, or had found by Ctrl-C, which is deferred.

        Raises KeyboardInterrupt if it had found nothing.
        """
        try:
            (found,) = self.collect(map(operator.call, [compute]))
        except KeyboardInterrupt as error:
            if not hasattr(error, "result"):
                raise
            found = error.result
        return found

    def _on_interrupt(self, number: int, frame: FrameType | None) -> None:
        self.requested = True
        if self._raises:
            if time.monotonic() >= self._calm_until:
                self._calm_until = time.monotonic() + CALM
                raise KeyboardInterrupt
        elif self._word:
            # The interrupted code may be writing to sys.stderr, which is not reentrant.
            os.write(2, self._word)


class Keeping:
    """Within this block a KeyboardInterrupt gets a result that was computed before."""

    def __init__(self, result: object) -> None:
        self._result = result

    def __enter__(self) -> None: ...

    def __exit__(self, kind: object, error: BaseException | None, traceback: object) -> None:
        if isinstance(error, KeyboardInterrupt):
            error.result = self._result  # type: ignore[attr-defined]


#: The instance of this process.
interruption = Interruption()
