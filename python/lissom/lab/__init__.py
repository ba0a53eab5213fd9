"""The numerical-methods lab that lissom grew out of, rerun: nine figures and three tables.

All of them are lissom's own computations, arranged along the lab's parts; the report's own numbers stand
beside them where they are known.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .._lissom import __version__
from ..report import page
from ..results import MARK, SUMMARY, atomic_folder
from . import pendulum, rod, roots
from .part import Part

#: The parts in the order of the page.
PARTS: dict[str, Callable[[], Part]] = {"roots": roots.part, "pendulum": pendulum.part, "rod": rod.part}

LEAD = (
    "Root finding, time integration, the spring pendulum, the Cosserat rod: figures 1 to 9 and tables 1 to "
    "3, computed anew by lissom, with the lab report's own numbers beside them and a word where it was wrong."
)


def write(target: Path, bar: Callable[[float, str, str], Any]) -> list[Path]:
    """Run the lab and write ``lab.html`` and the numbers into the folder ``target``; return the files.

    ``bar(total, what, unit)`` makes a progress bar, as tqdm does.
    """
    with atomic_folder(target) as folder:
        parts = {}
        with bar(len(PARTS), "Lab", "parts") as progress:
            for name, compute in PARTS.items():
                parts[name] = compute()
                progress.update(1)
        (folder / "lab.html").write_text(page.render(build(list(parts.values()))), encoding="utf-8")
        numbers = {MARK: __version__, **{name: part.numbers for name, part in parts.items()}}
        (folder / SUMMARY).write_text(
            json.dumps(plain(numbers), indent=2, allow_nan=False) + "\n", encoding="utf-8"
        )
    return [target / "lab.html", target / SUMMARY]


def build(parts: list[Part]) -> page.Page:
    """The page of the lab."""
    sections = [section for part in parts for section in part.sections]
    return page.Page(title="The lab, rerun", lead=LEAD, sections=sections, contents=True)


def plain(value: Any) -> Any:
    """The same in what JSON knows: the report's infinite run time becomes null."""
    if isinstance(value, dict):
        return {key: plain(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [plain(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
