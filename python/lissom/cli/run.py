"""``lissom run``: simulate a scene."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..common.interruption import STOPPING, interruption
from .exits import FAILED
from .saving import output_option, results_folder, save
from .scenes import SCENE, inputs_option, load, refusals_of, set_option, visuals_of, visuals_option
from .words import Saved, note, print_outcome, progress_bar, unsaid

if TYPE_CHECKING:
    from .._lissom import Scene
    from ..model.visuals import Visual
    from ..results.runs import Run


@click.command("run")
@click.argument("scene", type=SCENE)
@output_option("Folder for the results; results/NAME unless given.")
@click.option("--no-report", is_flag=True, help="Write the trajectory only.")
@inputs_option
@set_option
@visuals_option
def command(
    scene: Path,
    output: Path | None,
    no_report: bool,
    inputs: Mapping[str, Any],
    changes: Mapping[str, Any],
    visuals: bool,
) -> int:
    """Simulate SCENE; write results and a report.

    Writes the trajectory, a summary and an HTML report to the results folder, all at once when they are
    complete. Replaces results of an earlier run; refuses a folder that contains anything else, or that
    another run is writing to. If the folder fails at the end, results go to a temporary folder.

    Exit code: 0 done; 1 the simulation failed (what was computed is written) or something could not be
    written; 2 bad input (nothing is written); 130 interrupted with Ctrl-C (what was computed is written).
    """
    from ..common.extras import missing
    from ..results import files

    loaded = load(scene, changes)
    pictures = visuals_of(scene, loaded) if visuals else ()
    target = output if output is not None else Path("results") / scene.stem
    with results_folder(target) as folder:
        report = None if no_report else _report_of_run
        with refusals_of(scene):
            done = _simulate(loaded, pictures, inputs)
        saved = save(folder, lambda partial: files.write(done, partial, report))
    _summarise(done, saved)
    if missing(*files.HDF5):
        note("Without h5py the trajectory is an .npz file", "files")
    return saved.code if done.motion.success or done.interrupted else FAILED


def _simulate(scene: Scene, visuals: Sequence[Visual], inputs: Mapping[str, Any]) -> Run:
    """Simulate with a progress bar. From the first step on, Ctrl-C stops the simulation, not the program."""
    from .._lissom import AccuracyWarning
    from ..results.runs import Run

    settings = scene.simulation
    with progress_bar(settings.t_end - settings.t0, "Simulating", "s") as bar:

        def progress(t: float) -> bool:
            interruption.defer(STOPPING)
            bar.update(t - settings.t0 - bar.n)
            return interruption.requested

        with warnings.catch_warnings():
            # The summary reports it.
            warnings.simplefilter("ignore", AccuracyWarning)
            motion = scene.run(progress=progress, **({"u": inputs} if inputs else {}))
    return Run(scene, motion, interrupted=motion.status == "interrupted", visuals=visuals)


def _report_of_run(done: Run, path: Path) -> None:
    from ..drawing import report

    report.write(done, path)


def _summarise(done: Run, saved: Saved) -> None:
    from ..drawing.report import peaks, text

    outcome, good = text.outcome(done)
    limits = unsaid("limit", peaks.exceeded_in_motion(done), outcome)
    rows = [(name, said) for name, said in text.summary(done) if name != "advice" or said not in outcome]
    print_outcome(done.scene.name, outcome, good, limits + rows, saved)
