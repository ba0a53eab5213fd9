"""Requested and achieved accuracy of `method="auto"`, and its cost, for the scenes and some rods.

    python benches/python/accuracy/auto.py [--scene TEXT ...]

Prints a Markdown table. Error: largest distance of the tip from that of a reference solution (Radau; DOP853
for the pendulum; with tolerances far below the tightest request), relative to the length, over the output
times. Run times are the shortest of several runs, relative to the least accurate request of the same scene.
"""

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import lissom

SCENES = Path(__file__).parents[3] / "scenes"
REQUESTS = (1e-2, 1e-4, 1e-6, 1e-8)
REPEATS = 3
# Errors below this count as zero.
ROUNDING = 1e-15
# Interval of the compared times.
STEP = 0.02
REFERENCE = {"rtol": 1e-11, "atol": 1e-12}


@dataclass(frozen=True)
class Problem:
    name: str
    model: lissom.Rod | lissom.SpringPendulum
    duration: float
    reference: str = "radau"
    q0: np.ndarray | None = None

    def run(self, **options):
        return lissom.simulate(self.model, self.duration, q0=self.q0, dt=STEP, **options)

    def tips(self, motion):
        """Positions of the tip relative to the length, shape (m, 2 or 3)."""
        if isinstance(self.model, lissom.Rod):
            return self.model.pose(motion.q, [self.model.length])[:, 0, :3, 3] / self.model.length
        angle, elongation = motion.q.T
        radius = 1.0 + elongation / self.model.length
        return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def scene(file, name, duration, **options):
    loaded = lissom.Scene.load(SCENES / file)
    return Problem(f"{name}, {duration:g} s", loaded.model, duration, q0=loaded.q0, **options)


def rubber():
    """A rod that only bends, with undamped waves."""
    return lissom.Rod([lissom.Segment(1.0, 0.02, 5e6, 5e6 / 3, 1000.0, {"bend_y": 5})])


def two_segments():
    """A rod that bends and twists out of its plane; damped, and stiff in torsion."""
    modes = {"torsion": 2, "bend_y": 2, "bend_z": 2}
    segment = lissom.Segment(0.3, 0.02, 1e6, 4e5, 1e3, modes, retardation_time=0.01)
    return lissom.Rod([segment, segment], tip_force=(0.0, 0.05, 0.0))


GALLERY: list[Callable[[], Problem]] = [
    lambda: scene("lab-horizontal.toml", "lab rod, horizontal", 3.0),
    lambda: scene("lab-hanging.toml", "lab rod, hanging", 3.0),
    lambda: scene("lab-pendulum.toml", "lab pendulum", 3.0, reference="dop853"),
    lambda: scene("lab-pendulum.toml", "lab pendulum", 30.0, reference="dop853"),
    lambda: scene("tentacle.toml", "tentacle", 1.0),
    lambda: Problem("rubber rod, 1 s", rubber(), 1.0),
    lambda: Problem("two segments, 1 s", two_segments(), 1.0),
]


def rows(problem):
    """The rows of a problem, one per request."""
    exact = problem.run(method=problem.reference, **REFERENCE)
    if not exact.success:
        raise SystemExit(f"{problem.name}: no reference: {exact.message}")
    right, cheapest = problem.tips(exact), None
    for request in REQUESTS:
        runs = [problem.run(method="auto", rtol=request) for _ in range(REPEATS)]
        found, seconds = runs[0], min(run.stats.wall_time for run in runs)
        tips = problem.tips(found)
        error = np.linalg.norm(tips - right[: len(tips)], axis=1).max()
        cheapest = cheapest or seconds
        yield (
            problem.name,
            f"{request:.0e}",
            "rounding" if error < ROUNDING else f"{error:.1e}",
            f"{found.stats.time_error:.1e}",
            "yes" if found.success else found.status.replace("_", " "),
            method(found.message),
            f"{found.stats.steps:,}",
            f"{found.stats.nfev:,}",
            f"{seconds / cheapest:.1f}",
        )


def method(message):
    """The chosen method, extracted from the message."""
    _, _, said = message.partition("Method: ")
    return said.partition(",")[0].rstrip(".") or "unknown"


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--scene", nargs="*", default=[""], metavar="TEXT", help="those with TEXT in the name"
    )
    chosen = parser.parse_args().scene
    print("| scene | asked for | reached | estimate | met | method | steps | evaluations | run time |")
    print("|---|---|---|---|---|---|---|---|---|")
    for make in GALLERY:
        problem = make()
        if any(text in problem.name for text in chosen):
            for row in rows(problem):
                print("|", " | ".join(row), "|")
                sys.stdout.flush()


if __name__ == "__main__":
    main()
