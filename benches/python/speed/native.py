"""Times measured by criterion, without Python: `cargo bench --bench rod`."""

import json
import os
import statistics
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[3]

#: Measurement time in seconds and number of samples for each benchmark.
FULL = ("--warm-up-time", "0.2", "--measurement-time", "1", "--sample-size", "30")
QUICK = ("--warm-up-time", "0.05", "--measurement-time", "0.2", "--sample-size", "20")


@dataclass(frozen=True)
class Estimate:
    """The times of the fastest sample and of the median sample, seconds, and the number of operations in a
    sample.

    Other processes on the machine can only slow samples down.
    """

    seconds: float
    median: float
    elements: int = 1

    @property
    def each(self) -> float:
        """Seconds per operation."""
        return self.seconds / self.elements


def measure(group: str, quick: bool) -> dict[str, Estimate]:
    """Build in release mode and run the benchmarks of a group; returns estimates by name.

    Raises
    ------
    subprocess.CalledProcessError
        If building or running fails; stderr has the messages.
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
    """Reads the results that criterion wrote for a group."""
    found = {}
    for path in sorted(folder.glob("*/new/sample.json")):
        benchmark = json.loads((path.parent / "benchmark.json").read_text())
        sample = json.loads(path.read_text())
        times = [1e-9 * time / count for time, count in zip(sample["times"], sample["iters"], strict=True)]
        elements = (benchmark["throughput"] or {}).get("Elements", 1)
        found[benchmark["function_id"]] = Estimate(min(times), statistics.median(times), elements)
    return found
