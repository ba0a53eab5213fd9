"""Distribution of the points of a sweep over executors, in tasks of suitable size."""

from __future__ import annotations

import os
import queue
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError
from typing import Any

from .source import Source
from .work import Record, Wants, run_points

#: Target duration of a task in seconds: a thousand times the cost of its submission, short enough for a
#: progress bar.
TASK = 1.0

#: Number of queued tasks per worker, so that no worker is idle while results are transferred.
WAITING = 2

#: Number of attempts for points whose task was cancelled, for example because a worker of the scheduler died.
ATTEMPTS = 3

#: Interval in seconds between checks for Ctrl-C.
LOOK = 0.2

Points = Callable[[int], Mapping[str, Any]]
Write = Callable[[Sequence[int], Sequence[Record]], None]


class Chunks:
    """Chooses the number of points of the next task from the durations of earlier ones."""

    def __init__(self, left: Sequence[int], workers: int | None, longest: int) -> None:
        self.left = deque(left)
        #: Number of workers; None if tasks run one after the other.
        self.workers = workers
        #: Maximum number of points per task, limited by memory.
        self.longest = longest
        self._points = 0
        self._seconds = 0.0

    def took(self, points: int, seconds: float) -> None:
        """Record the duration of a task."""
        self._points += points
        self._seconds += seconds

    def next(self) -> list[int]:
        """Points of the next task."""
        if self._points == 0:
            size = 1
        else:
            size = min(int(TASK * self._points / max(self._seconds, 1e-9)), self.longest)
            if self.workers is not None:
                # Finally, at least as many tasks as workers, so that all workers finish at the same time.
                size = min(size, -(-len(self.left) // (WAITING * self.workers)))
            size = max(1, size)
        return [self.left.popleft() for _ in range(min(size, len(self.left)))]


def here(source: Source, point: Points, wants: Wants, chunks: Chunks, write: Write) -> None:
    """Run all points in this process, on all processors."""
    while chunks.left:
        which = chunks.next()
        records, seconds = run_points(source, [point(i) for i in which], wants)
        write(which, records)
        chunks.took(len(which), seconds)


def by(executor: Any, source: Source, point: Points, wants: Wants, chunks: Chunks, write: Write) -> None:
    """Run all points by an executor."""
    ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
    under_way: dict[Any, list[int]] = {}
    attempts: dict[int, int] = {}
    most = WAITING * (chunks.workers or 1)
    try:
        while chunks.left or under_way:
            while chunks.left and len(under_way) < most:
                which = chunks.next()
                future = executor.submit(run_points, source, [point(i) for i in which], wants)
                under_way[future] = which
                future.add_done_callback(ended.put)
            try:
                future = ended.get(timeout=LOOK)
            except queue.Empty:
                continue
            which = under_way.pop(future)
            try:
                records, seconds = future.result()
            except CancelledError:
                for i in which:
                    attempts[i] = attempts.get(i, 0) + 1
                    if attempts[i] == ATTEMPTS:
                        raise
                chunks.left.extendleft(reversed(which))
                continue
            write(which, records)
            chunks.took(len(which), seconds)
    except BaseException:
        for future in under_way:
            future.cancel()
        raise


def adapted(executor: Any) -> tuple[Any, int]:
    """The executor with the interface of `concurrent.futures`, and its number of workers."""
    if hasattr(executor, "get_executor") and hasattr(executor, "nthreads"):
        # A client of Dask. Impure, so that equal tasks are not merged.
        return executor.get_executor(pure=False), max(1, sum(executor.nthreads().values()))
    if not hasattr(executor, "submit"):
        raise TypeError(
            f"executor: got {type(executor).__name__}, expected None, an executor as of concurrent.futures, "
            "or a client of dask.distributed"
        )
    return executor, getattr(executor, "_max_workers", None) or os.cpu_count() or 1
