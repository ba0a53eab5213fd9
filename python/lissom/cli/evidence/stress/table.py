"""The committed outcomes, and regressions."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from ....common import disk
from .cell import KINDS, Kind

if TYPE_CHECKING:
    from . import Done

NAME = "expected.json"

#: Group, then "row | column", then outcome.
Table = dict[str, dict[str, Kind]]


def committed() -> Table:
    """The table of this version."""
    table: Table = json.loads(files(__package__).joinpath(NAME).read_text(encoding="utf-8"))
    return table


def of(done: list[Done]) -> Table:
    """The outcomes as a table."""
    return {
        group.group.name: {
            f"{cell.row} | {cell.column}": outcome.kind
            for cell, outcome in zip(group.group.cells, group.outcomes, strict=True)
        }
        for group in done
    }


def regressions(found: Table, expected: Table) -> list[str]:
    """Cells with wrong outcomes, and cells with better outcomes in the table. New cells are not compared."""
    worse = []
    for group, cells in found.items():
        for name, kind in cells.items():
            before = expected.get(group, {}).get(name)
            if kind == "wrong":
                worse.append(f"{group}: {name}: wrong")
            elif before is not None and KINDS.index(kind) > KINDS.index(before):
                worse.append(f"{group}: {name}: {before} before, {kind} now")
    return worse


def improvements(found: Table, expected: Table) -> int:
    """Number of cells that are new or better than in the table."""
    return sum(
        group not in expected
        or name not in expected[group]
        or KINDS.index(kind) < KINDS.index(expected[group][name])
        for group, cells in found.items()
        for name, kind in cells.items()
    )


def update(found: Table) -> Path:
    """Rewrite the committed table in the sources of this package."""
    path = Path(__file__).parent / NAME
    disk.write(path, json.dumps(found, indent=1) + "\n")
    return path
