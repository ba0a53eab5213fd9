"""CPU time of starts: imports and commands in new processes.

    python benches/python/speed/start.py [--runs N]

Prints medians of user and system time in seconds, and the limit of each case as a multiple of `import numpy`,
which most of them contain: times of processes depend on the machine, their ratio much less. Exits with 1 if
a case takes longer than its limit.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

ROOT = Path(__file__).parents[3]
SCENE = ROOT / "scenes" / "lab-horizontal.toml"

#: Cases and their generous limits, in multiples of the time of `import numpy`.
CASES: dict[str, tuple[list[str], float]] = {
    "import lissom": (["-c", "import lissom"], 1.0),
    "import lissom; lissom.Rod": (["-c", "import lissom; lissom.Rod"], 2.0),
    "lissom --help": (["-m", "lissom", "--help"], 2.0),
    "lissom --version": (["-m", "lissom", "--version"], 2.5),
    "lissom check": (["-m", "lissom", "check", str(SCENE)], 3.0),
    "lissom run --no-report": (["-m", "lissom", "run", str(SCENE), "-o", "out", "--no-report"], 6.0),
    "lissom run": (["-m", "lissom", "run", str(SCENE), "-o", "out"], 6.0),
}


def cpu_time(arguments: list[str], folder: str) -> float:
    """User and system time of a Python process, seconds."""
    before = os.times()
    subprocess.run([sys.executable, *arguments], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=10, help="runs of each case")
    runs = parser.parse_args().runs
    cases = {"import numpy": (["-c", "import numpy"], float("inf")), **CASES}
    times: dict[str, list[float]] = {name: [] for name in cases}
    with tempfile.TemporaryDirectory() as folder:
        for arguments, _ in cases.values():
            # Compiles bytecode.
            cpu_time(arguments, folder)
        for _ in range(runs):
            # One after the other, so that all of them meet the same disturbances.
            for name, (arguments, _) in cases.items():
                times[name].append(cpu_time(arguments, folder))
    unit = median(times["import numpy"])
    slow = False
    for name, (_, limit) in cases.items():
        taken = median(times[name])
        slow |= taken > limit * unit
        print(f"{name:<28} {taken:6.3f} s  {taken / unit:5.2f} x numpy  (limit {limit:g})")
    return int(slow)


if __name__ == "__main__":
    sys.exit(main())
