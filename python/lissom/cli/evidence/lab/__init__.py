"""The numerical-methods lab from which lissom originated, computed again: nine figures and three tables.

All results are computed by lissom and arranged in the order of the lab; the numbers of the report are shown
beside them where known.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ...._lissom import __version__
from ....common import disk
from ....drawing.report import page
from ....results.files import write_report, write_summary
from ....results.folders import MARK
from . import pendulum, rod, roots
from .part import Part
from .setup import LABS, Setup

__all__ = ["PARTS", "Setup", "build", "compute", "write"]

#: Parts in the order of the page.
PARTS: dict[str, Callable[[Setup], Part]] = {"roots": roots.part, "pendulum": pendulum.part, "rod": rod.part}

LEAD = (
    "Root finding, time integration, the spring pendulum, the Cosserat rod: figures 1 to 9 and tables 1 to "
    "3, computed anew by lissom, with the lab report's own numbers beside them and a word where it was wrong."
)

#: What of the report stands beside results with other parameters.
BESIDE = "The report's run times stand only beside runs of its own models and steps."


def compute(bar: Callable[[float, str, str], Any], setup: Setup = LABS) -> Iterator[tuple[str, Part]]:
    """Compute the parts by name. ``bar(total, what, unit)`` creates a progress bar, like tqdm."""
    with bar(len(PARTS), "Lab", "parts") as progress:
        for name, part in PARTS.items():
            yield name, part(setup)
            progress.update(1)


def write(parts: Mapping[str, Part], folder: Path, setup: Setup = LABS) -> list[str]:
    """Write the numbers and ``lab.html`` of these parts into an empty folder; return problems with
    writing."""
    numbers = {name: part.numbers for name, part in parts.items()}
    write_summary({MARK: __version__, "setup": asdict(setup), **numbers}, folder)
    return write_report(_report, (parts, setup), folder / "lab.html")


def _report(done: tuple[Mapping[str, Part], Setup], path: Path) -> None:
    parts, setup = done
    disk.write(path, page.render(build(list(parts.values()), setup)))


def build(parts: list[Part], setup: Setup = LABS) -> page.Page:
    """The page of the lab."""
    sections = [section for part in parts for section in part.sections]
    changes = setup.changes()
    lead = LEAD if not changes else f"{LEAD} Changed here: {'; '.join(changes)}. {BESIDE}"
    return page.Page(title="The lab, rerun", lead=lead, sections=sections, contents=True)
