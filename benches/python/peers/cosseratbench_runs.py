"""The public benchmark `cosseratbench` with lissom and the other solvers that it knows, in one sitting.

    pip install 'lissom[cosseratbench]' 'cosseratbench[all]'
    python benches/python/peers/cosseratbench_runs.py [--solver NAME] [--experiment NAME] [--ordinary]
        [--limit SECONDS]

Runs every experiment in its ordinary case, and lissom in all variants that the benchmark defines, one after
the other, each in a process of its own that is ended after the limit. Writes the tables of DIR/peers.md (DIR
is docs unless `-o DIR` is given) and all results to results/peers/cosseratbench.json; runs that are in there
already are not repeated unless `--fresh` is given.
"""

import argparse
import json
import subprocess
import sys
import time
import warnings
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))
import machine
from peers import cosseratbench_report
from speed.report import with_section

ROOT = Path(__file__).parents[3]
RESULTS = ROOT / "results" / "peers" / "cosseratbench.json"
LISSOM = "lissom"
SOLVERS = (LISSOM, "pyelastica", "mujoco")
#: Seconds after which a run is given up.
LIMIT = 600.0
#: What a process needs beside the run itself, seconds: imports, compilation, the warm-up.
MARGIN = 60.0

Row = dict[str, Any]


def solver_of(name: str, limit: float, options: dict[str, float]) -> Any:
    """lissom's own adaptor, or one of the benchmark's."""
    from cosseratbench import registry

    if name == LISSOM:
        from lissom.cli.evidence.cosseratbench import LissomSolver

        return LissomSolver(max_seconds=limit, **options)
    return registry.load_solver(name, **options)


def timed(solver: Any) -> list[float]:
    """Processor times of the calls of a solver from now on, seconds: what else runs counts little in them."""
    times, run = [], solver.run

    def measured(*args: Any, **options: Any) -> Any:
        start = time.process_time()
        try:
            return run(*args, **options)
        finally:
            times.append(time.process_time() - start)

    solver.run = measured
    return times


def one(task: Row) -> Row:
    """The summary of a run, as the benchmark writes it, with its processor time and warnings."""
    from cosseratbench import registry
    from cosseratbench.experiment import run

    experiment = registry.load_experiment(task["experiment"])
    solver = solver_of(task["solver"], task["limit"], task["options"])
    times = timed(solver)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = run(
            experiment,
            solver,
            values=task["parameters"],
            options=task["options"],
            n_elements=task["n_elements"],
        )
    said = sorted({str(warning.message) for warning in caught if "Accuracy" in warning.category.__name__})
    more = {"variant": task["variant"], "warnings": said, "processor_time": times[-1] if times else None}
    return result.summary() | more


def tasks(solvers: list[str], experiments: list[str], limit: float, with_variants: bool) -> list[Row]:
    """The ordinary cases for all solvers, then the variants for lissom."""
    from cosseratbench import registry, variations

    found = []
    for variants in (False, True)[: 1 + with_variants]:
        for name in experiments or registry.names(registry.EXPERIMENTS):
            experiment = registry.load_experiment(name)
            for variant in variations.variants(experiment, ["all"]):
                if bool(variant.varied) != variants:
                    continue
                for solver in solvers if not variants else [s for s in solvers if s == LISSOM]:
                    found.append(
                        {
                            "experiment": name,
                            "variant": variant.key,
                            "solver": solver,
                            "parameters": dict(variant.parameters),
                            "options": dict(variant.options),
                            "n_elements": variant.n_elements,
                            "limit": limit,
                        }
                    )
    return found


def ended(task: Row, failure: str) -> Row:
    named = {key: task[key] for key in ("experiment", "variant", "solver")}
    return named | {
        "outcome": "ended",
        "failure": failure,
        "metrics": {},
        "processor_time": None,
        "warnings": [],
    }


def in_process(task: Row) -> Row:
    """A run in a process of its own."""
    command = [sys.executable, __file__, "--one", json.dumps(task)]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=task["limit"] + MARGIN, check=False
        )
    except subprocess.TimeoutExpired:
        return ended(task, f"not finished after {2 * task['limit'] + MARGIN:.0f} s")
    if done.returncode != 0:
        return ended(task, (done.stderr.strip().splitlines() or ["no message"])[-1])
    return json.loads(done.stdout.splitlines()[-1])


def versions(solvers: list[str]) -> str:
    names = ["cosseratbench", *solvers, "numpy"]
    found = []
    for name in names:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            import lissom

            found.append(f"{name} {lissom.__version__ if name == LISSOM else 'unknown'}")
    return ", ".join(found)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--one", help=argparse.SUPPRESS)
    parser.add_argument("--solver", action="append", choices=SOLVERS)
    parser.add_argument("--experiment", action="append")
    parser.add_argument("--limit", type=float, default=LIMIT, help="seconds for a run")
    parser.add_argument("--ordinary", action="store_true", help="no variants")
    parser.add_argument("--tables", action="store_true", help="only write the tables of the known runs")
    parser.add_argument("--fresh", action="store_true", help="repeat all runs")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs", metavar="DIR")
    options = parser.parse_args()
    if options.one:
        print(json.dumps(one(json.loads(options.one))))
        return
    described = machine.description()
    solvers = options.solver or list(SOLVERS)
    kept = [] if options.fresh or not RESULTS.exists() else json.loads(RESULTS.read_text())["rows"]
    known = {(row["experiment"], row["variant"], row["solver"]): row for row in kept}
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    wanted = (
        []
        if options.tables
        else tasks(solvers, options.experiment or [], options.limit, not options.ordinary)
    )
    for task in wanted:
        key = (task["experiment"], task["variant"], task["solver"])
        if key in known:
            continue
        known[key] = in_process(task)
        row = known[key]
        print(
            *key, row["outcome"], row["processor_time"], row["metrics"], row.get("failure") or "", flush=True
        )
        about = (
            f"{described}; {versions(solvers)}; {datetime.now(UTC):%Y-%m-%d}; "
            f"`python benches/python/peers/cosseratbench_runs.py --limit {options.limit:g}`."
        )
        RESULTS.write_text(json.dumps({"about": about, "rows": list(known.values())}, indent=1))
    found = json.loads(RESULTS.read_text())
    page = options.output / "peers.md"
    text = page.read_text(encoding="utf-8")
    for name, section in cosseratbench_report.sections(found["rows"], found["about"]).items():
        text = with_section(text, name, section)
    page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
