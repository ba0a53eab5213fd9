"""``python -m fuzz``: tries cases for a bounded time, and says what it found; or runs files of cases again."""

import argparse
import hashlib
import importlib
import itertools
import os
import sys
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fuzz import judge, minimise, pool

HARNESSES = ("scenes", "api", "solvers")


@dataclass(frozen=True)
class Case:
    """What is tried: the name says how to make it again."""

    name: str
    text: bytes
    suffix: str


def number_of(harness: str) -> int:
    """A harness as a number, so that each has random numbers of its own."""
    return HARNESSES.index(harness)


def random_case(harness, seed: int, number: int) -> Case:
    """Case `number` of a seed: the same on every machine."""
    rng = np.random.default_rng([seed, number_of(harness.NAME), number])
    return Case(f"seed {seed}, case {number}", harness.make(rng), harness.SUFFIX)


def corpus(harness) -> list[Case]:
    return [
        Case(path.name, path.read_bytes(), path.suffix)
        for path in sorted(harness.CORPUS.iterdir())
        if path.suffix == harness.SUFFIX
    ]


def cases(harness, seed: int, deadline: float, count: int | None):
    """The corpus, then random cases until the time or their number is over."""
    yield from corpus(harness)
    for number in itertools.count() if count is None else range(count):
        if time.monotonic() > deadline:
            return
        yield random_case(harness, seed, number)


class Findings:
    """What came out: verdicts counted, and the first case of each fault, made smaller and stored."""

    def __init__(self, folder: Path | None) -> None:
        self.folder = folder
        self.counts: dict[str, Counter] = {}
        self.faults: dict[str, list] = {}
        self.example: dict[str, str] = {}

    def of(self, harness):
        counts = self.counts.setdefault(harness.NAME, Counter())

        def done(case, outcome, worker) -> None:
            counts[outcome.verdict] += 1
            if not outcome.bad:
                return
            known = self.faults.get(outcome.signature)
            if known:
                known[0] += 1
                return
            print(f"{harness.NAME}, {case.name}: {outcome.signature}", flush=True)
            self.faults[outcome.signature] = [1, harness.NAME, case.name, outcome, None]
            if self.folder is not None:
                self.faults[outcome.signature][4] = self._store(harness, case, outcome, worker)

        return done

    def _store(self, harness, case, outcome, worker) -> Path:
        text = case.text
        if outcome.verdict not in ("hang", "memory"):
            text = minimise.fewer_lines(
                text, lambda less: worker.run(harness, less, case.suffix).signature == outcome.signature
            )
        digest = hashlib.sha256(outcome.signature.encode()).hexdigest()[:8]
        self.folder.mkdir(parents=True, exist_ok=True)
        path = self.folder / f"{harness.NAME}-{outcome.verdict}-{digest}{case.suffix}"
        path.write_bytes(text)
        return path

    def table(self) -> str:
        """Verdicts in rows, harnesses in columns, as Markdown."""
        names = list(self.counts)
        rows = [["", *names], ["---"] * (1 + len(names))]
        for verdict in (*judge.GOOD, *judge.BAD):
            row = [self.counts[name][verdict] for name in names]
            if any(row):
                rows.append([verdict, *map(str, row)])
        rows.append(["all", *(str(sum(self.counts[name].values())) for name in names)])
        return "\n".join("| " + " | ".join(row) + " |" for row in rows)

    def report(self) -> str:
        lines = []
        for count, harness, name, outcome, path in self.faults.values():
            lines += [f"\n{count} x {outcome.signature}", f"    {harness}, {name}"]
            lines += [f"    {line}" for line in outcome.detail.splitlines()[:6]]
            if path is not None:
                lines.append(f"    again: make fuzz FUZZ_FILES={path}")
        return "\n".join(lines)


def again(paths: list[Path], limit: float) -> int:
    """Run stored cases; the harness is known by the ending and by the first word of the name or the folder."""
    bad = 0
    with pool.Worker(limit) as worker:
        for path in paths:
            path = path.resolve()
            name = next(
                (n for n in HARNESSES if path.name.startswith(f"{n}-") or n in path.parent.parts[-1:]),
                "scenes" if path.suffix == ".toml" else "api",
            )
            outcome = worker.run(importlib.import_module(f"fuzz.{name}"), path.read_bytes(), path.suffix)
            print(f"{path.name}: {outcome.verdict} {outcome.signature}\n    {outcome.detail}")
            bad += outcome.bad
    return 1 if bad else 0


def main() -> int:
    parser = argparse.ArgumentParser(prog="fuzz", description=__doc__)
    parser.add_argument("files", nargs="*", type=Path, help="stored cases to run again, and nothing else")
    parser.add_argument("--harness", nargs="+", choices=HARNESSES, default=list(HARNESSES))
    parser.add_argument("--seconds", type=float, default=300.0, help="for all harnesses together")
    parser.add_argument("--count", type=int, help="random cases of each harness at most")
    parser.add_argument("--seed", type=int, default=None, help="another one each time unless given")
    parser.add_argument("--only", type=int, help="this random case of the seed: print it, run it")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--limit", type=float, default=judge.LIMIT, help="processor seconds of a case")
    parser.add_argument("--findings", type=Path, default=Path("results/fuzz"))
    given = parser.parse_args()
    if given.files:
        return again(given.files, given.limit)
    seed = int.from_bytes(os.urandom(3)) if given.seed is None else given.seed
    harnesses = [importlib.import_module(f"fuzz.{name}") for name in given.harness]
    if given.only is not None:
        case = random_case(harnesses[0], seed, given.only)
        sys.stdout.buffer.write(case.text + b"\n")
        with pool.Worker(given.limit) as worker:
            outcome = worker.run(harnesses[0], case.text, case.suffix)
        print(f"{outcome.verdict} {outcome.signature}\n{outcome.detail}")
        return 1 if outcome.bad else 0
    print(f"seed {seed}, {given.seconds:g} s, {given.jobs} processes", flush=True)
    findings = Findings(given.findings)
    for harness in harnesses:
        deadline = time.monotonic() + given.seconds / len(harnesses)
        todo = cases(harness, seed, deadline, given.count)
        pool.run_all(harness, todo, given.jobs, given.limit, findings.of(harness))
    print(findings.report())
    print()
    print(findings.table())
    return 1 if findings.faults else 0


if __name__ == "__main__":
    sys.exit(main())
