"""Worker processes that return an outcome for each case, even if the process dies."""

import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import fuzz
import lissom
from fuzz import judge

#: Ratio of wall-clock time to processor time that indicates a deadlock; a busy machine stays below.
WALL = 30.0
#: Timeout for the start of a worker, seconds: imports on a busy machine.
START = 600.0
#: A worker is replaced if its resident memory exceeds that of a new worker by this many bytes.
REPLACED = 256 * 2**20


class Worker:
    """One process at a time; the next one starts after a case has killed it."""

    def __init__(self, limit: float) -> None:
        self.limit = limit
        self.folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
        self.process: subprocess.Popen | None = None
        self.fresh = 0

    def run(self, harness, text: bytes, suffix: str) -> judge.Outcome:
        if self.process is None:
            self._start()
        path = self.folder / f"case{suffix}"
        path.write_bytes(text)
        order = {"harness": harness.NAME, "path": str(path), "limit": self.limit}
        self.process.stdin.write(json.dumps(order).encode() + b"\n")
        answer = self._answer(WALL * self.limit)
        if answer is None:
            code = self.close()
            where = harness.where(path)
            if code is None:
                return judge.found("hang", where, "no end in sight (a deadlock, or Ctrl-C is not heard)")
            return judge.of_death(code, where, self._said())
        memory = answer.pop("resident")
        if memory - self.fresh > REPLACED:
            self.close()
        return judge.Outcome(**answer)

    def _start(self) -> None:
        # The process starts in another folder, where relative entries of the path are invalid.
        places = [Path(fuzz.__file__).parents[1], Path(lissom.__file__).parents[1]]
        path = os.pathsep.join(map(str, places))
        # One thread for linear algebra, because the workers use all cores.
        environment = os.environ | {"PYTHONPATH": path, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "fuzz.worker", str(self.folder)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd=self.folder,
            env=environment,
            bufsize=0,
            start_new_session=True,  # Ctrl-C is for the parent
        )
        ready = self._answer(START)
        if ready is None:
            self.close()
            raise RuntimeError(f"the worker did not start: {self._said()}")
        self.fresh = ready["resident"]

    def _answer(self, seconds: float) -> dict | None:
        """The next line of output of the process; None if it has died or the time is over."""
        line = b""
        while not line.endswith(b"\n"):
            ready, _, _ = select.select([self.process.stdout], [], [], seconds)
            piece = os.read(self.process.stdout.fileno(), 1 << 16) if ready else b""
            if not piece:
                return None
            line += piece
        return json.loads(line)

    def close(self) -> int | None:
        """End the process; returns its exit code, or None if it had to be killed."""
        process, self.process = self.process, None
        if process is None:
            return None
        process.stdin.close()
        try:
            code = process.wait(2.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            code = None
        process.stdout.close()
        return code

    def _said(self) -> str:
        said = self.folder / "said.txt"
        return said.read_bytes()[-20_000:].decode(errors="replace") if said.exists() else ""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
        shutil.rmtree(self.folder, ignore_errors=True)


def run_all(harness, cases, jobs: int, limit: float, done) -> None:
    """Run the cases of an iterator in `jobs` workers; `done(case, outcome, worker)` runs once at a time."""
    lock = threading.Lock()
    cases = iter(cases)
    failures: list[BaseException] = []

    def work() -> None:
        try:
            with Worker(limit) as worker:
                while not failures:
                    with lock:
                        case = next(cases, None)
                    if case is None:
                        return
                    outcome = worker.run(harness, case.text, case.suffix)
                    with lock:
                        done(case, outcome, worker)
        except BaseException as error:
            failures.append(error)

    threads = [threading.Thread(target=work) for _ in range(jobs)]
    for thread in threads:
        thread.start()
    try:
        for thread in threads:
            thread.join()
    except KeyboardInterrupt as error:
        failures.append(error)  # the cases that run are ended, no more are started
        for thread in threads:
            thread.join()
    if failures:
        raise failures[0]
