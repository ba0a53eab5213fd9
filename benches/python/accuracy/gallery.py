"""The scenes of the gallery with `method="auto"`: what is asked for, the estimates, and what ends a run.

    python benches/python/accuracy/gallery.py [--scene NAME ...] [--limit 60]

Each scene runs as far as its file says. Prints a Markdown table: time and space error of the result relative
to the length, steps of the run that is returned, processor time of the request; for runs that end without
success the status, how far they came, and the reason. `--limit` is the time of a request in seconds, by the
clock.
"""

import argparse
import time
import warnings
from pathlib import Path

import lissom

SCENES = Path(__file__).parents[3] / "scenes"
REQUESTS = (1e-2, 1e-4, 1e-6)
# What a request takes of the options of a scene: the rest is for the method of the scene.
TAKEN = ("t_end", "t0", "q0", "v0", "t_eval")


def rows(path, limit):
    """The rows of a scene, one per request."""
    scene = lissom.Scene.load(path)
    options = {name: value for name, value in scene.options.items() if name in TAKEN}
    for asked in REQUESTS:
        began = time.process_time()
        found = lissom.simulate(scene.model, method="auto", rtol=asked, max_seconds=limit, **options)
        seconds = time.process_time() - began
        errors = (
            "–" if value is None else f"{value:.0e}"
            for value in (found.stats.time_error, found.stats.space_error)
        )
        reason = "" if found.success else f" at {found.t[-1]:.3g} s: {found.message.partition('. ')[0]}"
        yield (
            f"| {path.stem}, {options['t_end']:g} s | {asked:.0e} | {' | '.join(errors)} "
            f"| {found.stats.steps:,} | {seconds:.2f} s | {found.status.replace('_', ' ')}{reason} |"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--scene", nargs="*", help="names of files without their suffix")
    parser.add_argument("--limit", type=float, default=60.0)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    print("| scene | asked for | time error | space error | steps | time | status |")
    print("|---|---|---|---|---|---|---|")
    for path in sorted(SCENES.glob("*.toml")):
        if not options.scene or path.stem in options.scene:
            for row in rows(path, options.limit):
                print(row, flush=True)


if __name__ == "__main__":
    main()
