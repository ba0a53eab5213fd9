"""Robots by lissom, Pinocchio, MuJoCo and SoRoMoX, in one process and on one core; run by robot_peers.py.

Its environment has the peers; lissom is the one of this source tree, as it is built there.
"""

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[3] / "python"))
import agreement
import arms
import octopus_runs
import tendon_arm_runs
from cases import on_one_core, packages

PARTS = {
    "agreement": (agreement.measure, agreement.away),
    "arms": (arms.measure,),
    "octopus": (octopus_runs.measure,),
    "tendon-arm": (tendon_arm_runs.measure,),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="few repetitions")
    parser.add_argument("--only", choices=PARTS, help="one part of it")
    options = parser.parse_args()
    on_one_core()
    packages("pin", "mujoco", "soromox", "jax", "numpy")
    for part in [options.only] if options.only else PARTS:
        for measure in PARTS[part]:
            for row in measure(options.quick):
                print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
