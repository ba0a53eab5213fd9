"""``lissom lab``: the numerical-methods lab, rerun."""

from __future__ import annotations

from pathlib import Path

import click

from ..common.interruption import interruption
from .saving import output_option, results_folder, save
from .words import progress_bar


@click.command("lab")
@output_option("Folder for the results.", Path("results/lab"))
def command(output: Path) -> int:
    """Rerun the numerical-methods lab.

    Reproduces its nine figures and three tables and compares them with the numbers of its report, in some
    seconds. Replaces earlier results; refuses a folder that contains anything else.

    Exit code: 0 done; 1 the results could not be written; 2 bad input; 130 interrupted (finished parts are
    written).
    """
    from .evidence import lab as numerical_lab

    with results_folder(output) as folder:
        parts = dict(interruption.collect(numerical_lab.compute(progress_bar)))
        saved = save(folder, lambda partial: numerical_lab.write(parts, partial))
    for file in saved.files:
        click.echo(saved.target / file)
    return saved.code
