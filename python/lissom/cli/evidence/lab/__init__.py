"""The numerical-methods lab from which lissom originated, computed again: nine figures and three tables.

All results are computed by lissom and arranged in the order of the lab; the numbers of the report are shown
beside them where known.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from ...._lissom import __version__
from ....common import disk
from ....drawing.report import page
from ....results.files import write_report, write_summary
from ....results.folders import MARK
from . import pendulum, rod, roots
from .part import Part

#: Parts in the order of the page.
PARTS: dict[str, Callable[[], Part]] = {"roots": roots.part, "pendulum": pendulum.part, "rod": rod.part}

LEAD = (
    "Root finding, time integration, the spring pendulum, the Cosserat rod: figures 1 to 9 and tables 1 to "
    "3, computed anew by lissom, with the lab report's own numbers beside them and a word where it was wrong."
)


def compute(bar: Callable[[float, str, str], Any]) -> Iterator[tuple[str, Part]]:
    """Compute the parts by name. ``bar(total, what, unit)`` creates a progress bar, like tqdm."""
    with bar(len(PARTS), "Lab", "parts") as progress:
        for name, part in PARTS.items():
            yield name, part()
            progress.update(1)


def write(parts: Mapping[str, Part], folder: Path) -> list[str]:
    """Write the numbers and ``lab.html`` of these parts into an empty folder; return problems with
    writing."""
    write_summary({MARK: __version__, **{name: part.numbers for name, part in parts.items()}}, folder)
    return write_report(_report, parts, folder / "lab.html")


def _report(parts: Mapping[str, Part], path: Path) -> None:
    disk.write(path, page.render(build(list(parts.values()))))


def build(parts: list[Part]) -> page.Page:
    """The page of the lab."""
    sections = [section for part in parts for section in part.sections]
    return page.Page(title="The lab, rerun", lead=LEAD, sections=sections, contents=True)
