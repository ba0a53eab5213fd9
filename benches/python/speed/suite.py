"""All benchmarks: `make bench`.

    python benches/python/speed/suite.py [--parts PART ...] [--quick] [-o DIR]

Parts: lab (run times of the lab's scenes), kernels (inverse dynamics, forward dynamics, tangent and Newmark
step compared with the NumPy reference and published figures of CROSP), limit (the kernels relative to this
machine's multiply throughput), scaling (segments and modes), rubber_rod (run time against error, compared
with PyElastica, MuJoCo and SoRoMoX; half an hour). Needs lissom in release mode, numpy, scipy, matplotlib and
cargo.

Writes DIR/benchmarks.json and .png and the sections of DIR/benchmarks.md for the measured parts; DIR is docs
by default. Other parts keep their previous results.
"""

import argparse
import json
import sys
import time
import traceback
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import lissom._lissom
from lissom.drawing.report.text import multiplications

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[3] / "tests" / "python"))
import machine
from peers import rubber_rod, rubber_rod_report
from speed import lab, native, report
from speed.rods import KERNELS, MODES, SEGMENTS, STEP, STEPS, Arguments, rod, state

from reference import rod as reference

ROOT = Path(__file__).parents[3]

#: If a NumPy reference takes longer (seconds), it is not measured again.
PATIENCE = 5.0

Data = dict[str, Any]


def say(what: str) -> None:
    print(f"[{time.strftime('%H:%M:%S')}] {what}", file=sys.stderr, flush=True)


@cache
def natively(group: str, quick: bool) -> dict[str, native.Estimate]:
    """Criterion's results for a group, measured once per run."""
    say(f"criterion: {group}")
    return native.measure(group, quick)


def shortest(run: Callable[[], Any]) -> float:
    """The shortest time of several runs of a slow function, seconds."""
    times: list[float] = []
    while not times or (sum(times) < PATIENCE and len(times) < 5):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


def numpy_reference(arguments: Arguments) -> dict[str, float]:
    """Times of the reference for the same rod."""
    rod = reference.Rod([reference.Segment(**segment) for segment in arguments])
    q, qd, qdd = (np.array(values) for values in state(rod.n))
    return {
        "residual": shortest(lambda: rod.inverse_dynamics(q, qd, qdd)),
        "forward": shortest(lambda: rod.forward_dynamics(q, qd)),
    }


def measure_lab(quick: bool) -> Data:
    rows = []
    for row in lab.rows(repetitions=3 if quick else lab.REPETITIONS):
        say(f"lab: {row['case']}")
        rows.append(row)
    return {"rows": rows}


def measure_kernels(quick: bool) -> Data:
    found = natively("kernels", quick)
    rows = []
    for name, arguments in KERNELS.items():
        say(f"NumPy reference: {name}")
        rows.append(
            {
                "rod": name,
                "coordinates": rod(arguments).n,
                "residual": found[f"residual of {name}"].seconds,
                "tangent": found[f"tangent of {name}"].seconds,
                "forward": found[f"forward dynamics of {name}"].seconds,
                "step": found[f"{STEPS} Newmark steps of {name}"].each,
                "numpy": numpy_reference(arguments),
            }
        )
    return {"rows": rows}


def measure_limit(quick: bool) -> Data:
    rates = {int(name.split()[2]): 1.0 / rate.each for name, rate in natively("machine", quick).items()}
    found = natively("kernels", quick)
    rows = []
    for rod_name, arguments in KERNELS.items():
        model = rod(arguments)
        steps = lissom.simulate(model, STEPS * STEP, dt=STEP).stats
        counts = model.multiplications
        rows.append(
            {
                "rod": rod_name,
                "coordinates": model.n,
                "products": {
                    "residual": counts["residual"],
                    "tangent": counts["tangent"],
                    "step": multiplications(counts, steps) / steps.steps,
                },
                "seconds": {
                    "residual": found[f"residual of {rod_name}"].seconds,
                    "tangent": found[f"tangent of {rod_name}"].seconds,
                    "step": found[f"{STEPS} Newmark steps of {rod_name}"].each,
                },
            }
        )
    return {"rates": rates, "products_per_second": max(rates.values()), "rows": rows}


def measure_scaling(quick: bool) -> Data:
    found = natively("scaling", quick)

    def row(kind: str, size: int, coordinates: int) -> Data:
        name = f"{size} {kind}"
        return {
            kind: size,
            "coordinates": coordinates,
            "residual": found[f"residual of {name}"].seconds,
            "tangent": found[f"tangent of {name}"].seconds,
            "step": found[f"{STEPS // 10} Newmark steps of {name}"].each,
        }

    segments = [
        row("segments", size, 3 * size)
        | {"dense_step": found[f"{STEPS // 10} Newmark steps of {size} segments, dense"].each}
        for size in SEGMENTS
    ]
    return {"rows": {"segments": segments, "modes": [row("modes", size, 3 * size) for size in MODES]}}


def measure_rubber_rod(quick: bool) -> Data:
    say("rubber rod: lissom, then one code after the other")
    folder = ROOT / "results" / "rubber_rod"
    text = rubber_rod.run(folder, quick, list(rubber_rod.RODS))
    data = json.loads((folder / "rubber_rod.json").read_text())
    references = {name: np.array(tips) for name, tips in data["references"].items()}
    compared = {
        comparison: [
            without_path(run)
            for runs in rubber_rod_report.compared(data["runs"], references, comparison).values()
            for run in runs
        ]
        for comparison in rubber_rod_report.COMPARISONS
    }
    return {
        "text": text,
        "plot": str(folder / "rubber_rod.png"),
        "versions": data["versions"],
        "runs": compared,
    }


def without_path(run: Data) -> Data:
    """A run without the path of its tip; a failed run has null as its error."""
    kept = {key: value for key, value in run.items() if key != "tips"}
    return kept | {"error": run["error"] if np.isfinite(run["error"]) else None}


PARTS: dict[str, Callable[[bool], Data]] = {
    "lab": measure_lab,
    "kernels": measure_kernels,
    "limit": measure_limit,
    "scaling": measure_scaling,
    "rubber_rod": measure_rubber_rod,
}


def write(parts: dict[str, Data], measured: list[str], folder: Path) -> None:
    """Writes the data, the corresponding sections and the plots."""
    page = folder / "benchmarks.md"
    text = page.read_text(encoding="utf-8")
    for name in measured:
        data = parts[name]
        if name == "rubber_rod":
            image = "![Largest tip error over run time](rubber_rod.png)"
            text = report.with_section(text, name, f"{image}\n\n{data.pop('text')}")
            (folder / "rubber_rod.png").write_bytes(Path(data.pop("plot")).read_bytes())
        else:
            text = report.with_section(text, name, report.section(getattr(report, name)(data), data))
    page.write_text(text, encoding="utf-8")
    (folder / "benchmarks.json").write_text(json.dumps(parts, indent=1, allow_nan=False) + "\n")
    report.plot(parts, folder / "benchmarks.png")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--parts", nargs="+", choices=list(PARTS), default=list(PARTS), help="all by default")
    parser.add_argument("--quick", action="store_true", help="few repetitions: to try the command")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs", metavar="DIR")
    options = parser.parse_args()
    if lissom._lissom.build_profile != "release":
        sys.exit("This is a debug build of lissom; build it in release mode first.")
    start = time.perf_counter()
    path = options.output / "benchmarks.json"
    parts: dict[str, Data] = json.loads(path.read_text()) if path.exists() else {}
    failed = []
    for name in options.parts:
        say(f"part {name}")
        described = {
            "machine": machine.description(),
            "command": f"make bench PARTS={name}" + (" QUICK=1" if options.quick else ""),
        }
        try:
            parts[name] = described | PARTS[name](options.quick)
            # Written after every part.
            write(parts, [name], options.output)
        except Exception:
            # A failed part does not prevent the others.
            traceback.print_exc()
            failed.append(name)
    seconds = time.perf_counter() - start
    say(f"{', '.join(options.parts)} in {seconds:.0f} s; see {options.output / 'benchmarks.md'}")
    if failed:
        sys.exit(f"Failed: {', '.join(failed)}")


if __name__ == "__main__":
    main()
