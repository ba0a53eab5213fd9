"""The tables of docs/peers.md about `cosseratbench`."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from speed.report import table

Row = Mapping[str, Any]

#: Names of the benchmark and in the tables.
SOLVERS = {"lissom": "lissom", "pyelastica": "PyElastica", "mujoco": "MuJoCo"}
ORDINARY = "default"


def outcome(row: Row | None) -> str:
    """Metrics of a run, or how it ended."""
    if row is None:
        return "not run"
    if row["outcome"] == "completed":
        named = (f"{name.replace('_', ' ')} {shown(value)}" for name, value in row["metrics"].items())
        return ", ".join(named)
    if row["outcome"] == "unsupported":
        return "does not express it"
    at = row.get("diverged_at")
    reached = "" if at is None else f" at {at:.3g} s"
    why = re.split(r": |\. | at t = | in the step from t = ", str(row["failure"]))[0]
    return f"**ended{reached}**: {why}"


def shown(value: float | None) -> str:
    return "n/a" if value is None else f"{value:.2g}"


def seconds(row: Row | None) -> str:
    taken = row and row["processor_time"]
    return "" if taken is None else f"{taken:.3g} s"


def ordinary(rows: Sequence[Row]) -> str:
    """All solvers in the ordinary cases."""
    found = {(row["experiment"], row["solver"]): row for row in rows if row["variant"] == ORDINARY}
    lines = []
    for experiment in sorted({row["experiment"] for row in rows}):
        for name, title in SOLVERS.items():
            row = found.get((experiment, name))
            if row is not None:
                lines.append((experiment, title, outcome(row), seconds(row)))
    return table(("experiment", "solver", "result", "processor time"), lines)


def varied(rows: Sequence[Row]) -> str:
    """lissom in all variants."""
    mine = [row for row in rows if row["solver"] == "lissom" and row["variant"] != ORDINARY]
    lines = [
        (row["experiment"], row["variant"].replace("_", " "), outcome(row), seconds(row))
        for row in sorted(mine, key=lambda row: (row["experiment"], row["variant"]))
    ]
    return table(("experiment", "changed", "result", "processor time"), lines)


def sections(rows: Sequence[Row], about: str) -> dict[str, str]:
    """The sections of the page by their names."""
    return {
        "cosseratbench_about": about,
        "cosseratbench": ordinary(rows),
        "cosseratbench_variants": varied(rows),
    }
