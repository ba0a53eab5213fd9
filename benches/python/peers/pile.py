"""Run time against error for rods dropped into a box: lissom, MuJoCo, PyElastica.

    python benches/python/peers/pile.py [--rods 5 10 20 50] [-o DIR] [--quick] [--peers NAME ...]

Needs lissom built in release mode and numpy. Makes a virtual environment for each of the others in
DIR/environments, once, from their public packages; one that cannot be installed is named with the reason.
Writes DIR/pile.json (all runs with their points) and .md (tables).

Piles are chaotic and the laws of contact differ, so that each code is compared with its own finest run: root
mean square distance of the ends and middles of the rods that have touched something, the largest one of 0.08,
0.1, 0.12 and 0.15 s after the start. The first rods touch the floor after 0.06 s.
Run time: processor time of one thread for 0.1 s of motion, without building the model; medians of three runs
where they are short. `--quick` runs 5 and 10 rods and follows no pile until it has settled.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

# Before NumPy and the peers start threads.
os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", NUMBA_NUM_THREADS="1")

import lissom._lissom

sys.path.insert(0, str(Path(__file__).parents[1]))
import machine
import pile_lissom
import pile_report
import pile_runs
import pile_scene
from environment import PILES, Unavailable, measure


def run(output: Path, numbers: list[int], quick: bool, peers: list[str]) -> str:
    """Measure one code after the other; write the files, return the tables."""
    begun = time.perf_counter()
    output.mkdir(parents=True, exist_ok=True)
    lines = [f"- {machine.description()}; {time.strftime('%Y-%m-%d')}"]
    piles = {number: pile_lissom.scene(number) for number in numbers}
    scene = output.resolve() / "scene.json"
    pile_scene.write(piles, scene)
    pile_runs.one_core()
    found = list(
        pile_runs.runs(
            "lissom", "modes", piles, pile_lissom.resolutions, pile_lissom.Simulated, () if quick else piles
        )
    )
    versions = {"lissom": lissom.__version__}
    for name in peers:
        try:
            peer = measure(name, output.resolve() / "environments", quick, "--scene", str(scene))
        except Unavailable as reason:
            lines.append(f"- not measured: {name}: {reason}")
            continue
        versions |= peer.versions
        found += peer.runs
        if peer.failure is not None:
            lines.append(f"- {name}: {peer.failure}")
    lines.append("- " + ", ".join(f"{package} {version}" for package, version in versions.items()))
    lines.append(f"- `python {' '.join(sys.argv)}`, {time.perf_counter() - begun:.0f} s")
    runs, states = ([each for each in found if ("points" in each) is moved] for moved in (True, False))
    (output / "pile.json").write_text(json.dumps({"machine": lines, "runs": runs, "settled": states}))
    text = pile_report.markdown(runs, states, piles, lines)
    (output / "pile.md").write_text(text)
    return text


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, default=Path("results/pile"))
    parser.add_argument("--quick", action="store_true", help="5 and 10 rods, some minutes")
    parser.add_argument("--rods", type=int, nargs="+", help="5 10 20 50 by default")
    parser.add_argument("--peers", nargs="*", choices=list(PILES), default=list(PILES), help="all by default")
    arguments = parser.parse_args()
    if lissom._lissom.build_profile != "release":
        sys.exit("This is a debug build of lissom; build it in release mode first.")
    numbers = arguments.rods or ([5, 10] if arguments.quick else [5, 10, 20, 50])
    print(run(arguments.output, numbers, arguments.quick, arguments.peers))


if __name__ == "__main__":
    main()
