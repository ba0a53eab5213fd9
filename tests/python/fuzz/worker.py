"""A process that runs cases: one line of JSON as input and one as output for each.

It limits its own memory and processor time, so that the death of the process is also an outcome.
"""

import importlib
import json
import math
import os
import re
import resource
import signal
import sys
import time
from pathlib import Path

from fuzz import HARNESSES, judge

#: Address space in addition to that after the imports, bytes: four times the memory that a case may use.
ADDRESS_SPACE = 2 * 2**30
#: Ctrl-C is repeated after this many seconds of processor time, and the process dies after as many more.
PATIENCE = 2.0
#: `ru_maxrss` counts kibibytes, and bytes on macOS.
UNIT = 1 if sys.platform == "darwin" else 1024


def resident() -> int:
    """Peak resident memory, bytes."""
    try:
        status = Path("/proc/self/status").read_text()
    except OSError:
        status = ""
    # `getrusage` starts with the peak of the parent process.
    if peak := re.search(r"^VmHWM:\s+(\d+) kB$", status, re.MULTILINE):
        return int(peak[1]) * 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * UNIT


def limit_memory() -> None:
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[0])
    except OSError:
        return  # elsewhere the limit does not count what libraries reserve
    taken = pages * resource.getpagesize() + ADDRESS_SPACE
    resource.setrlimit(resource.RLIMIT_AS, (taken, taken))


def limit_time(seconds: float) -> None:
    """Send Ctrl-C after this processor time; end the process if that has no effect."""
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    last = math.ceil(time.process_time() + seconds + 2 * PATIENCE)
    resource.setrlimit(resource.RLIMIT_CPU, (last, hard))
    signal.setitimer(signal.ITIMER_PROF, seconds, PATIENCE)


class Clock:
    """Whether the time of a case is over."""

    over = False

    def __call__(self, number, frame) -> None:
        self.over = True
        signal.raise_signal(signal.SIGINT)


def main() -> None:
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    orders = os.fdopen(os.dup(0), buffering=1)
    said = Path(sys.argv[1]) / "said.txt"
    output = os.open(said, os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND)
    for descriptor in (1, 2):
        os.dup2(output, descriptor)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    clock = Clock()
    signal.signal(signal.SIGPROF, clock)
    harnesses = {name: importlib.import_module(f"fuzz.{name}") for name in HARNESSES}
    for harness in harnesses.values():
        harness.prepare()
    limit_memory()
    print(json.dumps({"verdict": "ready", "resident": resident()}), file=answers)
    for line in orders:
        order = json.loads(line)
        os.ftruncate(output, 0)
        harness, path = harnesses[order["harness"]], Path(order["path"])
        before, clock.over = resident(), False
        limit_time(order["limit"])
        try:
            outcome = harness.run(path, clock)
        except KeyboardInterrupt:
            outcome = judge.Outcome("slow", "ended by Ctrl-C")
        except MemoryError as error:
            outcome = judge.Outcome("refused", f"MemoryError: {error}")
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
        grown = resident() - before
        if grown > max(judge.MEMORY, judge.MEMORY_OF_TEXT * path.stat().st_size) and not outcome.bad:
            outcome = judge.found("memory", harness.where(path), f"{grown >> 20} MiB")
        print(json.dumps(outcome.plain() | {"resident": resident()}), file=answers)


if __name__ == "__main__":
    main()
