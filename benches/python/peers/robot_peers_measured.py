"""Robots by lissom, Pinocchio and MuJoCo, in one process and on one core; run by robot_peers.py.

Its environment has the peers; lissom is the one of this source tree, as it is built there.
"""

import json
import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[3] / "python"))
import agreement
import arms
import octopus_runs
from cases import packages, quick_requested


def main() -> None:
    quick = quick_requested(__doc__)
    if hasattr(os, "sched_setaffinity"):
        # One core for all, and for all threads that anything starts.
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    packages("pin", "mujoco", "numpy")
    for part in (agreement.measure, agreement.away, arms.measure, octopus_runs.measure):
        for row in part(quick):
            print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
