"""``lissom validate``: comparison with known answers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..common import disk
from ..common.interruption import interruption
from .exits import OUTSIDE_TOLERANCE
from .saving import output_option, results_folder, save, unwritten

if TYPE_CHECKING:
    from .evidence.validation import Outcome


@click.command("validate")
@output_option("Folder for the report and the numbers.", Path("results/validation"))
@click.option(
    "--update-docs",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write the table as Markdown to FILE as well.",
)
@click.option("--no-report", is_flag=True, help="Write the numbers only.")
def command(output: Path, update_docs: Path | None, no_report: bool) -> int:
    """Compare lissom with known answers.

    Compares with closed forms, independent solutions, other codes and published numbers, in some ten seconds
    (a minute with PyElastica). Prints a table; writes an HTML report with a plot for each case, and the
    numbers. Names the cases that are left out because a code is not installed.

    Exit code: 0 all cases are within their tolerance; 1 the results could not be written; 2 bad input; 3 a
    case is outside its tolerance; 130 interrupted (finished cases are written, FILE is not).
    """
    from .evidence import validation
    from .evidence.validation import pages as report
    from .evidence.validation import table

    def said(outcomes: Iterable[Outcome]) -> Iterator[Outcome]:
        for outcome in outcomes:
            yield outcome
            _print_outcome(outcome)

    with results_folder(output) as folder:
        click.echo(click.style(table.head(), bold=True))
        outcomes = interruption.collect(said(validation.run_all(validation.CASES)))
        pages = None if no_report else report.write
        saved = save(folder, lambda partial: validation.write(outcomes, partial, pages))
    good = not any(outcome.outside for outcome in outcomes)
    click.echo(click.style(table.verdict(outcomes), bold=True, fg=None if good else "red"))
    for file in saved.files:
        click.echo(f"  {saved.target / file}")
    if update_docs is not None and not interruption.requested:
        try:
            disk.write(update_docs, table.markdown(outcomes))
        except OSError as error:
            return unwritten(update_docs, error)
        click.echo(f"  {update_docs}")
    return saved.code if good else OUTSIDE_TOLERANCE


def _print_outcome(outcome: Outcome) -> None:
    from .evidence.validation import table

    click.echo(click.style(table.line(outcome), fg="red" if outcome.outside else None))
    if outcome.failure:
        click.echo(f"  {outcome.failure}", err=True)
