"""``lissom modes``: natural frequencies and shapes of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from ..common.interruption import interruption
from .exits import FAILED
from .saving import output_option, results_folder, save_study
from .scenes import SCENE, inputs_option, load, refusals_of, set_option
from .statics import print_statics
from .words import line, print_outcome, unsaid


@click.command("modes")
@click.argument("scene", type=SCENE)
@output_option("Folder for the results; results/NAME-modes unless given.")
@click.option("--at-start", is_flag=True, help="Linearise about the q0 of the scene, not its equilibrium.")
@inputs_option
@set_option
@click.option("--no-report", is_flag=True, help="Write the numbers only.")
def command(
    scene: Path,
    output: Path | None,
    at_start: bool,
    inputs: Mapping[str, Any],
    changes: Mapping[str, Any],
    no_report: bool,
) -> int:
    """Find the natural frequencies and mode shapes of SCENE.

    The modes are those about the equilibrium that "lissom statics" finds. The
    report animates the slowest ones.

    Exit code: 0 done; 1 there are no modes, or no equilibrium was found (then the files of "lissom statics"
    are written); 2 bad input; 130 interrupted with Ctrl-C (as after 1, what was found is written).
    """
    from .._lissom import LissomError
    from ..analysis.advice import about_model
    from ..drawing.oscillation import frequency, oscillates
    from ..drawing.report import studies as words
    from ..results import studies

    loaded = load(scene, changes)
    target = output if output is not None else Path("results") / f"{scene.stem}-modes"
    with results_folder(target) as folder:
        with refusals_of(scene):
            rest = None if at_start else studies.study_statics(loaded, u=inputs or None)
        try:
            interruption.answer()
            with refusals_of(scene):
                done = studies.study_modes(loaded, rest, inputs or None)
        except (LissomError, KeyboardInterrupt) as error:
            if rest is not None:
                return print_statics(rest, save_study(rest, folder, no_report), str(error) or "interrupted")
            if isinstance(error, KeyboardInterrupt):
                raise
            click.echo(line(f"{loaded.name}: {error}"), err=True)
            return FAILED
        saved = save_study(done, folder, no_report)
    rows = unsaid("advice", about_model(loaded.model), done.found.message)
    for k, (number, hertz, ratio, _) in enumerate(words.table(done.found)[: words.LISTED]):
        said = f"{hertz} Hz, damping ratio {ratio}" if oscillates(done.found, k) else frequency(done.found, k)
        becomes = words.changes(done.found, k)
        rows.append((f"mode {number}", f"{said}; {becomes} Hz with more modes" if becomes else said))
    left_out = len(done.found.frequency) - words.LISTED
    if left_out > 0:
        rows.append(("", f"{left_out} more in {done.file}"))
    outcome = f"{len(done.found.frequency)} modes, {done.found.stability or 'stability unknown'}"
    print_outcome(loaded.name, outcome, words.outcome_of_modes(done.found)[1], rows, saved)
    click.echo(done.found.message)
    return saved.code
