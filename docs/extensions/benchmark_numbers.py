"""The directive `headline-numbers`: a short table of run times from `docs/benchmarks.json`."""

import json
import sys
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

DOCS = Path(__file__).parents[1]
NUMBERS = DOCS / "benchmarks.json"

# What counts as the fastest run within an error is decided where the benchmarks are written.
sys.path.insert(0, str(DOCS.parent / "benches" / "python" / "peers"))
from rubber_rod_report import ONE_PERCENT, fastest  # noqa: E402

PEER = "PyElastica, clamp in mid-element"


def in_words(seconds: float) -> str:
    for size, unit in ((1.0, "s"), (1e-3, "ms")):
        if seconds >= size:
            return f"{seconds / size:.3g}\N{NO-BREAK SPACE}{unit}"
    return f"{seconds / 1e-6:.3g}\N{NO-BREAK SPACE}µs"


def table(numbers: dict) -> str:
    """The table in Markdown."""
    lab = numbers["lab"]["rows"][0]
    steps = {row["coordinates"]: row["step"] for row in numbers["kernels"]["rows"]}
    runs = numbers["rubber_rod"]["runs"]["Rubber rod"]
    own, peer = (
        fastest([run for run in runs if run["code"] == code], ONE_PERCENT) for code in ("lissom", PEER)
    )
    rows = [
        (
            f"Steel wire, {lab['case']}",
            in_words(lab["seconds"]),
            f"{in_words(lab['report'])} (the lab's report)",
        ),
        ("One implicit step of a soft rod with 12 coordinates", in_words(steps[12]), ""),
        ("The same with 36 coordinates", in_words(steps[36]), ""),
        (
            "Rubber rod, 1 s, tip error below 1 %",
            in_words(own["seconds"]),
            f"{in_words(peer['seconds'])} ({PEER})",
        ),
    ]
    lines = ["| | lissom | others |", "|---|---|---|", *(f"| {' | '.join(row)} |" for row in rows)]
    return "\n".join([*lines, "", f"{numbers['lab']['machine'].split(';')[0]}."])


class HeadlineNumbers(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        self.env.note_dependency(str(NUMBERS))
        return self.parse_text_to_nodes(table(json.loads(NUMBERS.read_text())))


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_directive("headline-numbers", HeadlineNumbers)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
