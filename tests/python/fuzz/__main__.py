"""``python -m fuzz``: tries cases for a limited time and reports findings, or repeats stored cases."""

import argparse
import hashlib
import importlib
import itertools
import os
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from fuzz import HARNESSES, judge, minimise, pool

FOUND = Path(__file__).parent / "corpus" / "found"
OPEN = Path(__file__).parent / "corpus" / "open.txt"


@dataclass(frozen=True)
class Case:
    """A case; its name describes how to recreate it."""

    name: str
    text: bytes
    suffix: str


def number_of(harness: str) -> int:
    """A number for a harness, so that each harness has its own random numbers."""
    return HARNESSES.index(harness)


def random_case(harness, seed: int, number: int) -> Case:
    """Case `number` of a seed, the same on every machine."""
    rng = np.random.default_rng([seed, number_of(harness.NAME), number])
    return Case(f"seed {seed}, case {number}", harness.make(rng), harness.SUFFIX)


def found_before(harness) -> list[Case]:
    """The corpus of earlier findings: "<harness>-<what>.<suffix>"."""
    return [
        Case(path.name, path.read_bytes(), path.suffix)
        for path in sorted(FOUND.glob(f"{harness.NAME}-*{harness.SUFFIX}"))
    ]


def known_faults() -> set[str]:
    """Signatures of known faults that are not fixed yet."""
    return set(filter(None, OPEN.read_text(encoding="utf-8").splitlines()))


def cases(harness, seed: int, deadline: float, count: int | None):
    """Earlier findings, then random cases until the time or their number is over."""
    yield from found_before(harness)
    for number in itertools.count() if count is None else range(count):
        if time.monotonic() > deadline:
            return
        yield random_case(harness, seed, number)


@dataclass
class Fault:
    """The first case with a signature, and all places with this signature."""

    harness: str
    name: str
    outcome: judge.Outcome
    places: Counter = field(default_factory=Counter)
    path: Path | None = None


class Findings:
    """Results: number of verdicts, and the first case of each fault, minimised and stored."""

    def __init__(self, folder: Path | None) -> None:
        self.folder = folder
        self.known = known_faults()
        self.counts: dict[str, Counter] = {}
        self.faults: dict[str, Fault] = {}

    def of(self, harness):
        counts = self.counts.setdefault(harness.NAME, Counter())

        def done(case, outcome, worker) -> None:
            counts[outcome.verdict] += 1
            if not outcome.bad:
                return
            fault = self.faults.get(outcome.signature)
            if fault is None:
                print(f"{harness.NAME}, {case.name}: {outcome.signature}", flush=True)
                fault = self.faults[outcome.signature] = Fault(harness.NAME, case.name, outcome)
                if self.folder is not None and outcome.signature not in self.known:
                    fault.path = self._store(harness, case, outcome, worker)
            fault.places[outcome.place] += 1

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
        """Table of verdicts (rows) and harnesses (columns), in Markdown."""
        names = list(self.counts)
        rows = [["", *names], ["---"] * (1 + len(names))]
        for verdict in (*judge.GOOD, *judge.BAD):
            row = [self.counts[name][verdict] for name in names]
            if any(row):
                rows.append([verdict, *map(str, row)])
        rows.append(["all", *(str(sum(self.counts[name].values())) for name in names)])
        return "\n".join("| " + " | ".join(row) + " |" for row in rows)

    def report(self) -> str:
        """Each fault, its places and how to reproduce it."""
        lines = []
        for signature, fault in self.faults.items():
            head = f"\n{fault.places.total()} x {signature}" + (" (known)" if signature in self.known else "")
            lines += [head, f"    {fault.harness}, {fault.name}"]
            lines += [f"    {line}" for line in fault.outcome.detail.splitlines()[:6]]
            lines.append("    at: " + ", ".join(f"{place} ({n})" for place, n in fault.places.most_common()))
            if fault.path is not None:
                lines.append(f"    again: make fuzz FUZZ_FILES={fault.path}")
        return "\n".join(lines)


def again(paths: list[Path], limit: float) -> int:
    """Repeat stored cases; the first word of a name gives the harness."""
    bad = 0
    with pool.Worker(limit) as worker:
        for path in paths:
            path = path.resolve()
            word = path.name.partition("-")[0]
            name = word if word in HARNESSES else "scenes" if path.suffix == ".toml" else "api"
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
    try:
        for harness in harnesses:
            deadline = time.monotonic() + given.seconds / len(harnesses)
            todo = cases(harness, seed, deadline, given.count)
            pool.run_all(harness, todo, given.jobs, given.limit, findings.of(harness))
    except KeyboardInterrupt:
        print("interrupted")
    finally:
        print(findings.report())
        print()
        print(findings.table())
    return 1 if findings.faults else 0


if __name__ == "__main__":
    sys.exit(main())
