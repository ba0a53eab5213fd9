"""Instruction counts of fixed cases by callgrind; unlike run times, they are reproducible.

    python benches/python/instructions.py            # count and compare with benches/instructions.json
    python benches/python/instructions.py --update   # count and write that file

Fails if a case needs over five percent more instructions than in the file. Counts depend on the compiler and
the kind of machine: with another compiler, without valgrind or without AVX2, nothing is compared and the
output gives the reason. Part of `make test-all`.
"""

import argparse
import json
import platform
import shutil
import signal
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
COUNTS = ROOT / "benches" / "instructions.json"
GROWTH = 1.05

# Numbers of repetitions that are counted: steps differ from each other, sweeps do not.
CASES = {
    **{
        f"{kind}/{rod}": 100
        for kind in ("residual", "tangent", "forward")
        for rod in ("lab-3", "two-12", "two-36")
    },
    "residual/two-12-tendon": 100,
    "residual/two-12-tendons": 100,
    "tangent/two-12-tendon": 100,
    "tangent/two-12-tendons": 100,
    "newton/chain-16": 20,
    "newton/chain-64": 5,
    "forward/chain-64": 5,
    "newmark/lab-3": 300,
    "newmark/two-12": 100,
    "newmark/pendulum": 1000,
    "simulate/lab-3": 300,
    "simulate/pendulum": 1000,
    "simulate/two-12": 100,
    "simulate/two-12-tendon": 100,
    "simulate/two-12-loop": 100,
    "simulate/two-12-floor": 100,
    "simulate/two-36": 100,
    "radau/two-12": 20,
    "rk45/lab-3": 100,
    "rk45/pendulum": 1000,
}


def output_of(*command: str) -> str:
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


def build() -> str:
    """Builds the cases; returns the path of the executable."""
    messages = output_of(
        "cargo",
        "bench",
        "--locked",
        "--quiet",
        "--package",
        "lissom",
        "--no-default-features",
        "--bench",
        "instructions",
        "--no-run",
        "--message-format=json",
    )
    artifacts = (json.loads(line) for line in messages.splitlines())
    return next(a["executable"] for a in artifacts if a.get("target", {}).get("name") == "instructions")


def instructions(executable: str, case: str, count: int) -> int:
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", executable, case, str(count)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    if done.returncode == -signal.SIGILL:
        # Compilers occasionally choose rare encodings; another order of the same sums avoids them.
        unknown = [line for line in done.stderr.splitlines() if "unhandled instruction bytes" in line]
        sys.exit(f"{case}: valgrind does not know an instruction of this build\n" + "\n".join(unknown))
    done.check_returncode()
    return int(done.stderr.split("Collected :")[1].split()[0])


def count(executable: str) -> dict[str, int]:
    """Instructions of one repetition of each case, without the start of the program."""
    counts = {}
    for case, repetitions in CASES.items():
        few, many = (instructions(executable, case, n * repetitions) for n in (1, 2))
        counts[case] = round((many - few) / repetitions)
    return counts


def obstacle() -> str | None:
    """The reason why counting is not possible here, if any."""
    if shutil.which("valgrind") is None:
        return "valgrind is not installed"
    cpu = Path("/proc/cpuinfo")
    if platform.machine() != "x86_64" or not cpu.exists() or " avx2 " not in cpu.read_text():
        return "the counts are those of x86-64 with AVX2"
    return None


def main() -> int:
    parser = argparse.ArgumentParser(description="Count the instructions of fixed cases.")
    parser.add_argument("--update", action="store_true", help=f"write {COUNTS.relative_to(ROOT)}")
    options = parser.parse_args()
    if reason := obstacle():
        print(f"Instructions are not counted: {reason}.")
        return 0
    compiler = output_of("rustc", "--version").strip()
    known = json.loads(COUNTS.read_text()) if COUNTS.exists() else {"compiler": None, "instructions": {}}
    if not options.update and known["compiler"] != compiler:
        print(
            f"Instructions are not compared: they were counted with {known['compiler']}, this is {compiler}."
        )
        return 0
    counts = count(build())
    grown = []
    for case, now in counts.items():
        before = known["instructions"].get(case)
        change = "" if before is None else f"{100 * (now / before - 1):+6.1f} %"
        print(f"{case:20} {now:>9,} {change}")
        if before is not None and now > GROWTH * before:
            grown.append(case)
    if options.update:
        COUNTS.write_text(json.dumps({"compiler": compiler, "instructions": counts}, indent=1) + "\n")
    elif missing := counts.keys() ^ known["instructions"].keys():
        print(f"Run with --update: {', '.join(sorted(missing))} changed its name or is new.")
        return 1
    elif grown:
        print(f"More than five percent more: {', '.join(grown)}. If that is wanted, run with --update.")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
