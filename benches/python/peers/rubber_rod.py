"""Processor time against error for a released rubber rod: lissom, PyElastica, MuJoCo, SoRoMoX.

    python benches/python/peers/rubber_rod.py [-o DIR] [--quick] [--peers NAME ...] [--repeats N]

Needs lissom built in release mode, numpy and matplotlib. Makes a virtual environment for each of the others
in DIR/environments, once, from their public packages; one that cannot be installed is named with the reason.
Everything is measured in this one invocation, one after the other. Writes DIR/rubber_rod.json (all runs
with their tips), .md (tables) and .png (plot).

Error: largest distance of the tip, over the whole second, from a reference that has converged in modes, steps
and quadrature nodes. Time: processor time of one core, the shortest of several runs from the state at rest to
the tip's positions, without building and compiling the model. With `--repeats` all codes are measured so many
times in turn, and the median of these counts.
"""

import argparse
import json
import os
import platform
import statistics
import sys
from pathlib import Path

import numpy as np

import lissom._lissom

sys.path.insert(0, str(Path(__file__).parents[1]))
from machine import processor
from peers import rubber_rod_lissom, rubber_rod_report
from peers.cases import LONGEST_RUN, QUICK_LONGEST_RUN, on_one_core
from peers.environment import RODS, Unavailable, measure


def medians(repeats: list[list[dict]]) -> list[dict]:
    """Each run of the first repetition with the median time of all repetitions that have it."""
    seconds: dict[tuple, list[float]] = {}
    for runs in repeats:
        for run in runs:
            key = run["case"], run["code"], run["discretisation"], run["step"]
            seconds.setdefault(key, []).append(run["seconds"])
    found = {(run["case"], run["code"], run["discretisation"], run["step"]): run for run in repeats[0]}
    return [{**run, "seconds": statistics.median(seconds[key])} for key, run in found.items()]


def run(output: Path, quick: bool, peers: list[str], repeats: int) -> str:
    """Measure lissom and the peers one after the other; write the files, return the tables."""
    longest = QUICK_LONGEST_RUN if quick else LONGEST_RUN
    system = f"{processor()}, {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}"
    machine = [
        f"- {system}",
        f"- load at the start: {os.getloadavg()[0]:.2f}",
        "- `python benches/python/peers/rubber_rod.py"
        + (" --quick" if quick else "")
        + (f" --repeats {repeats}`: medians" if repeats > 1 else "`"),
    ]
    references, changes = rubber_rod_lissom.references(quick)
    versions = {"lissom": {"lissom": lissom.__version__, "numpy": np.__version__}}
    left_out = {}
    repeated: list[list[dict]] = []
    for _ in range(repeats):
        repeated.append(list(rubber_rod_lissom.runs(quick, longest)))
        for name in peers:
            try:
                peer = measure(name, output.resolve() / "environments", quick)
            except Unavailable as reason:
                left_out[name] = str(reason)
                continue
            versions[name] = peer.versions
            repeated[-1] += peer.runs
            if peer.failure is not None:
                left_out[f"the rest of {name}"] = peer.failure
    runs = medians(repeated)

    output.mkdir(parents=True, exist_ok=True)
    data = {
        "machine": machine,
        "versions": versions,
        "left_out": left_out,
        "reference_changes": changes,
        "references": {name: tips.tolist() for name, tips in references.items()},
        "runs": runs,
    }
    (output / "rubber_rod.json").write_text(json.dumps(data))
    text = rubber_rod_report.markdown(runs, references, changes, left_out, machine, versions)
    (output / "rubber_rod.md").write_text(text)
    rubber_rod_report.plot(runs, references, output / "rubber_rod.png")
    return text


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, default=Path("results/rubber_rod"))
    parser.add_argument("--quick", action="store_true", help="only runs of a few seconds")
    parser.add_argument("--peers", nargs="*", choices=list(RODS), default=list(RODS), help="all by default")
    parser.add_argument("--repeats", type=int, default=1, help="how many times, for medians; 1 by default")
    arguments = parser.parse_args()
    if lissom._lissom.build_profile != "release":
        sys.exit("This is a debug build of lissom; build it in release mode first.")
    on_one_core()
    print(run(arguments.output, arguments.quick, arguments.peers, arguments.repeats))


if __name__ == "__main__":
    main()
