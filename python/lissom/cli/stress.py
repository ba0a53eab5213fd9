"""``lissom stress``: hard cases."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import click

from ..common.interruption import interruption
from .exits import REGRESSED
from .saving import output_option, results_folder, save
from .words import print_outcome, progress_bar


@click.command("stress")
@output_option("Folder for the results.", Path("results/stress"))
@click.option("--quick", is_flag=True, help="Run a few cases in seconds; all of them take some minutes.")
@click.option("--update", is_flag=True, help="Replace the committed table, with which runs are compared.")
@click.option("--no-report", is_flag=True, help="Write the numbers only.")
def command(output: Path, quick: bool, update: bool, no_report: bool) -> int:
    """Run hundreds of hard cases and judge each result.

    The cases vary slenderness, stiffness, size, time step, number of turns, buckling, ill-posed input and
    more. Each result is accurate, slow, refused, failed with a reason, or wrong: inaccurate but reported as
    success. Writes a report with a heat map for every group.

    Exit code: 0 nothing became worse than in the committed table; 3 something did, or is wrong; 1 the results
    could not be written; 2 bad input; 130 interrupted (finished groups are written).
    """
    from .evidence import stress as matrix
    from .evidence.stress import pages, table

    if update and quick:
        raise click.UsageError("--update takes the whole matrix: leave --quick out")

    def counted(groups: Iterable[matrix.Done]) -> Iterator[matrix.Done]:
        with progress_bar(len(matrix.GROUPS), "Stress test", "groups") as bar:
            for group in groups:
                yield group
                bar.update(1)

    with results_folder(output) as folder:
        done = interruption.collect(counted(matrix.run(quick)))
        found, expected = table.of(done), table.committed()
        if update and not interruption.requested:
            try:
                expected = found
                click.echo(table.update(found))
            except OSError as error:
                click.echo(f"The table could not be written: {error}", err=True)
        worse = table.regressions(found, expected)
        report = None if no_report else pages.write
        saved = save(folder, lambda partial: matrix.write(done, partial, quick, worse, report))
    counts = [(group.group.title, _counts(group.counts)) for group in done]
    outcome = "nothing regressed" if not worse else f"{len(worse)} cells regressed or are wrong"
    print_outcome("Stress test", outcome, not worse, [*counts, ("all", _counts(matrix.total(done)))], saved)
    for cell in worse:
        click.echo(cell, err=True)
    better = table.improvements(found, expected)
    if better:
        click.echo(f"{better} cells are new or better than in the committed table; --update keeps that.")
    return REGRESSED if worse else saved.code


def _counts(counts: Mapping[Any, int]) -> str:
    return ", ".join(f"{count} {kind}" for kind, count in counts.items() if count)
