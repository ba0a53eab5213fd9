"""Result folders of commands: options, and safe writing of files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..common.interruption import SAVING, interruption
from ..results.folders import Folder, NotOurs
from .exits import FAILED
from .words import Saved

if TYPE_CHECKING:
    from ..results.studies import ModesStudy, StaticsStudy


def output_option(what: str, default: Path | None = None) -> Callable[[Any], Any]:
    """The option that names the folder."""
    return click.option(
        "-o",
        "--output",
        type=click.Path(path_type=Path),
        default=default,
        show_default=default is not None,
        metavar="DIR",
        help=what,
    )


@contextmanager
def results_folder(target: Path) -> Iterator[Folder]:
    """Create and test the result folder before anything is computed; exit if it cannot be written."""
    try:
        folder = Folder(target)
    except NotOurs as error:
        raise click.UsageError(str(error)) from None
    except OSError as error:
        raise click.exceptions.Exit(unwritten(target, error)) from None
    with folder:
        yield folder


def save(folder: Folder, write: Callable[[Path], list[str]]) -> Saved:
    """Write results, or into a temporary folder if the target fails.

    From here on Ctrl-C is deferred. ``write`` returns messages about files that it could not write.
    """
    interruption.defer(SAVING)
    try:
        return _written(folder, write, 0)
    except OSError as error:
        unwritten(folder.target, error)
    import tempfile

    try:
        with Folder(Path(tempfile.mkdtemp(prefix="lissom-"))) as other:
            saved = _written(other, write, FAILED)
    except OSError as error:
        raise click.exceptions.Exit(unwritten(Path(tempfile.gettempdir()), error)) from None
    click.echo(f"The results are in {saved.target} instead.", err=True)
    return saved


def _written(folder: Folder, write: Callable[[Path], list[str]], code: int) -> Saved:
    failures = write(folder.partial)
    for failure in failures:
        click.echo(failure, err=True)
    return Saved(folder.target, folder.publish(), FAILED if failures else code)


def save_study(done: StaticsStudy | ModesStudy, folder: Folder, no_report: bool) -> Saved:
    """Write an equilibrium or natural modes, with a report unless `no_report`."""
    from ..drawing.report import studies as pages
    from ..results import studies

    interruption.defer(SAVING)
    report = None if no_report else pages.write
    return save(folder, lambda partial: studies.write(done, partial, report))


def unwritten(target: Path, error: Exception) -> int:
    """Say that something could not be written; the exit code."""
    # Without the number of the error, and without a path that repeats the target.
    reason = getattr(error, "strerror", None) or error
    click.echo(f"{target} could not be written: {reason}", err=True)
    return FAILED
