"""``lissom statics``: the equilibrium of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .exits import FAILED
from .saving import output_option, results_folder, save_study
from .scenes import SCENE, inputs_option, load, refusals_of, set_option
from .words import Saved, print_outcome, unsaid

if TYPE_CHECKING:
    from ..results.studies import StaticsStudy


@click.command("statics")
@click.argument("scene", type=SCENE)
@output_option("Folder for the results; results/NAME-statics unless given.")
@click.option(
    "--from-start", is_flag=True, help="Release the model at the scene's q0 instead of growing the loads."
)
@inputs_option
@set_option
@click.option(
    "--no-stability", is_flag=True, help="Do not judge stability, which takes long for large models."
)
@click.option("--no-report", is_flag=True, help="Write the numbers only.")
def command(
    scene: Path,
    output: Path | None,
    from_start: bool,
    inputs: Mapping[str, Any],
    changes: Mapping[str, Any],
    no_stability: bool,
    no_report: bool,
) -> int:
    """Find the equilibrium of SCENE.

    Increases the loads from the unloaded state, and reports stability and buckling. The settings of the
    simulation are not used.

    Exit code: 0 done; 1 no equilibrium was found (the last good state is written); 2 bad input (nothing is
    written); 130 interrupted with Ctrl-C (what was found is written).
    """
    from ..results import studies

    loaded = load(scene, changes)
    target = output if output is not None else Path("results") / f"{scene.stem}-statics"
    with results_folder(target) as folder:
        with refusals_of(scene):
            done = studies.study_statics(loaded, from_start, not no_stability, inputs or None)
        saved = save_study(done, folder, no_report)
    return print_statics(done, saved)


def print_statics(done: StaticsStudy, saved: Saved, problem: str = "") -> int:
    """Print the result and any problem; return the exit code."""
    from ..analysis.advice import about_model
    from ..drawing.report import peaks
    from ..drawing.report import studies as words
    from ..results.studies import setting_for

    setting, message = setting_for(done.found, done.scene.model), done.found.message
    beyond = peaks.exceeded_at_rest(setting, done.found.q)
    outcome, good = words.outcome(done.found, beyond)
    facts = unsaid("advice", about_model(done.scene.model), message)
    facts += unsaid("limit", beyond, message)
    facts += words.summary(setting, done.found, done.wall_time)
    print_outcome(done.scene.name, outcome, good, facts, saved)
    if message:
        click.echo(message)
    if problem and done.found.success:
        click.echo(f"No modes: {problem}", err=True)
    return FAILED if problem or not done.found.success else saved.code
