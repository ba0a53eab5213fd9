"""Times that criterion measures, without Python in them: `cargo bench --bench rod`."""

import json
import os
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]

#: Seconds of measuring and number of samples for each benchmark.
FULL = ("--warm-up-time", "0.2", "--measurement-time", "1", "--sample-size", "30")
QUICK = ("--warm-up-time", "0.05", "--measurement-time", "0.1", "--sample-size", "10")


@dataclass(frozen=True)
class Estimate:
    """A median time with its confidence interval, in seconds, and how many things were done in it."""

    seconds: float
    low: float
    high: float
    elements: int = 1

    @property
    def each(self) -> float:
        """Seconds for one of the things."""
        return self.seconds / self.elements


def measure(group: str, quick: bool) -> dict[str, Estimate]:
    """Build in release mode, run the benchmarks of a group; estimates by their names.

    Raises
    ------
    subprocess.CalledProcessError
        Building or running failed; what it said is on stderr.
    """
    with tempfile.TemporaryDirectory() as home:
        command = [
            "cargo",
            "bench",
            "--locked",
            "--bench",
            "rod",
            "--",
            *(QUICK if quick else FULL),
            f"^{group}/",
        ]
        environment = os.environ | {"CRITERION_HOME": home}
        subprocess.run(command, cwd=ROOT, check=True, env=environment, stdout=subprocess.DEVNULL)
        return estimates(Path(home) / group)


def estimates(folder: Path) -> dict[str, Estimate]:
    """What criterion wrote about a group."""
    found = {}
    for path in sorted(folder.glob("*/new/estimates.json")):
        benchmark = json.loads((path.parent / "benchmark.json").read_text())
        median = json.loads(path.read_text())["median"]
        interval = median["confidence_interval"]
        elements = (benchmark["throughput"] or {}).get("Elements", 1)
        times = [median["point_estimate"], interval["lower_bound"], interval["upper_bound"]]
        found[benchmark["function_id"]] = Estimate(*(1e-9 * time for time in times), elements)
    return found
