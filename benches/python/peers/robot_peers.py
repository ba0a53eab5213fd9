"""Robots beside Pinocchio, MuJoCo and SoRoMoX: agreement, run times, the octopus, a tendon arm: `make peers`.

    python benches/python/peers/robot_peers.py [--quick] [--only PART] [-o DIR]

Needs lissom built in release mode and numpy. Makes a virtual environment for the peers in results/peers,
once, from requirements/peers.txt. Writes the tables of DIR/peers.md (DIR is docs unless given) and all
numbers to results/peers/robots.json. Ends with an error if the robots are not those of the peers to rounding.
"""

import argparse
import json
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

import lissom._lissom

sys.path.insert(0, str(Path(__file__).parents[1]))
import machine
from peers import robot_peers_report
from peers.environment import Unavailable, measure
from speed.report import with_section

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "results" / "peers"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="few repetitions: to try the command")
    parser.add_argument(
        "--only", metavar="PART", help="agreement, arms, octopus or tendon-arm: its tables alone"
    )
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs", metavar="DIR")
    options = parser.parse_args()
    if lissom._lissom.build_profile != "release":
        sys.exit("This is not a release build of lissom; build it in release mode first.")
    described = machine.description()
    start = time.perf_counter()
    try:
        only = ["--only", options.only] if options.only else []
        peers = measure("robots", FOLDER.resolve(), options.quick, *only)
    except Unavailable as reason:
        sys.exit(f"The peers {reason}")
    if peers.failure is not None:
        sys.exit(f"The measurement {peers.failure}")
    versions = {"lissom": lissom.__version__, **peers.versions}
    about = (
        f"{described}; {', '.join(f'{name} {number}' for name, number in versions.items())}; "
        f"{datetime.now(UTC):%Y-%m-%d}; `make peers{' QUICK=1' if options.quick else ''}`, "
        f"{time.perf_counter() - start:.0f} s."
    )
    if options.only:
        about = about.replace("`make peers", f"the part {options.only} of `make peers")
    (FOLDER / "robots.json").write_text(json.dumps({"about": about, "rows": peers.runs}))
    page = options.output / "peers.md"
    text = page.read_text(encoding="utf-8")
    for name, section in robot_peers_report.sections(peers.runs, about).items():
        text = with_section(text, name, section)
    page.write_text(text, encoding="utf-8")
    print(f"See {page}", file=sys.stderr)
    if not all(row["agrees"] for row in peers.runs if row["part"] == "agreement"):
        sys.exit(f"lissom's robots are not those of its peers to rounding: see {page}")


if __name__ == "__main__":
    main()
