"""What commands say."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import click


class Saved(NamedTuple):
    """Where results are."""

    target: Path
    files: list[str]
    #: 0 if all that was wanted is where it was wanted.
    code: int


def say(name: str, outcome: str, good: bool, facts: Sequence[tuple[str, str]], saved: Saved) -> None:
    """What was done, and where its results are."""
    click.echo(click.style(f"{name}: {outcome}", bold=True, fg=None if good else "red"))
    rows = [*facts, ("results", f"{saved.target}/"), *(("", file) for file in saved.files)]
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        click.echo(f"  {name:<{width}}  {value}")


def note(what: str, extra: str) -> None:
    """Say what is left out, and which extra of the package it takes."""
    click.echo(f"{what}; install it with: pip install 'lissom[{extra}]'", err=True)


def progress_bar(total: float, what: str, unit: str) -> Any:
    """A progress bar on stderr; nothing where that is not a terminal."""
    from tqdm import tqdm

    form = "{desc}: {percentage:3.0f}%|{bar}| {n:.3g}/{total:.3g} {unit} [{elapsed}<{remaining}]"
    return tqdm(
        total=total,
        desc=what,
        unit=unit,
        bar_format=form,
        file=sys.stderr,
        disable=True if sys.stderr is None else None,
        leave=False,
    )
