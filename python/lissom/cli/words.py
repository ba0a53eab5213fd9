"""Output of commands on the terminal."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import click

#: Characters that command the terminal.
_CONTROLS = re.compile(r"[\x00-\x1f\x7f-\x9f]")


def line(text: str) -> str:
    """Text of a scene on one line, with control characters in the notation of Python."""
    return _CONTROLS.sub(lambda found: repr(found[0])[1:-1], text)


class Saved(NamedTuple):
    """Where results are."""

    target: Path
    files: list[str]
    #: Exit code: 0 if all files are where they were requested.
    code: int


def unsaid(name: str, sentences: Sequence[str], message: str) -> list[tuple[str, str]]:
    """Rows of sentences that the message does not have."""
    return [(name, sentence) for sentence in sentences if sentence not in message]


def print_outcome(
    name: str, outcome: str, good: bool, facts: Sequence[tuple[str, str]], saved: Saved
) -> None:
    """Print the outcome, the facts, and where the results are."""
    click.echo(click.style(line(f"{name}: {outcome}"), bold=True, fg=None if good else "red"))
    rows = [*facts, ("results", f"{saved.target}/"), *(("", file) for file in saved.files)]
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        click.echo(line(f"  {name:<{width}}  {value}"))


def note(what: str, extra: str) -> None:
    """Say what is missing, and which extra of the package provides it."""
    click.echo(f"{what}; to install: pip install 'lissom[{extra}]'", err=True)


def progress_bar(total: float, what: str, unit: str) -> Any:
    """A progress bar on stderr; nothing where that is not a terminal."""
    if sys.stderr is None or not sys.stderr.isatty():
        return _Unseen()
    from tqdm import tqdm

    form = "{desc}: {percentage:3.0f}%|{bar}| {n:.3g}/{total:.3g} {unit} [{elapsed}<{remaining}]"
    return tqdm(
        total=total,
        desc=what,
        unit=unit,
        bar_format=form,
        file=sys.stderr,
        leave=False,
    )


class _Unseen:
    """A progress bar that nobody sees."""

    n = 0.0

    def update(self, more: float) -> None:
        """Nothing: no progress is counted."""

    def __enter__(self) -> _Unseen:
        return self

    def __exit__(self, *_: object) -> None: ...
