"""The command line: ``lissom run``, ``statics``, ``modes``, ``check``, ``explain``, ``lab``, ``validate``,
``stress``, ``schema``.

Exit codes: 0 done, 1 the simulation failed or could not be written, 2 bad input, 3 a case of the validation
gallery is outside its tolerance or the stress test regressed, 130 interrupted.
What needs plotly or xarray is imported where it is used, so that ``--help`` is quick.
"""

from __future__ import annotations

import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType, TracebackType
from typing import TYPE_CHECKING, Any, NoReturn

import click

from . import __version__

if TYPE_CHECKING:
    from ._lissom import Scene
    from .results import Run
    from .studies import ModesStudy, StaticsStudy
    from .validation import Outcome

FAILED = 1
BAD_INPUT = 2
OUTSIDE_TOLERANCE = 3
REGRESSED = 3
INTERRUPTED = 130

SCENE = click.Path(exists=True, dir_okay=False, path_type=Path)
FOLDER = click.Path(path_type=Path)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Entry point of the command ``lissom``."""
    try:
        code = commands.main(arguments, prog_name="lissom", standalone_mode=False)
    except click.ClickException as error:
        error.show()
        code = error.exit_code
    except click.Abort:
        click.echo("Interrupted; nothing was written.", err=True)
        code = INTERRUPTED
    sys.exit(code)


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(__version__, prog_name="lissom")
def commands() -> None:
    """Simulate soft rods.

    A scene is a TOML file that describes a rod and how to simulate it.

    "lissom schema" lists its keys.
    """


@commands.command()
@click.argument("scene", type=SCENE)
@click.option(
    "-o", "--output", type=FOLDER, help="Folder for the results; results/NAME unless given.", metavar="DIR"
)
@click.option("--no-report", is_flag=True, help="Write the trajectory only.")
def run(scene: Path, output: Path | None, no_report: bool) -> int:
    """Simulate SCENE; write results and a report.

    The results folder, with the trajectory and an HTML report, appears when everything in it is complete.
    Results of an earlier run are replaced; a folder with anything else in it is refused.

    Exit code: 0 done; 1 the simulation failed (what was computed is written); 2 bad input (nothing is
    written); 130 interrupted with Ctrl-C (what was computed is written).
    """
    from . import results

    loaded = _load(scene)
    target = output if output is not None else Path("results") / scene.stem
    try:
        results.check_target(target)
    except results.NotOurs as error:
        raise click.UsageError(str(error)) from None
    except OSError as error:
        return _unwritten(target, error)
    with _refusals_of(scene):
        done = _simulate(loaded)
    reporting = not no_report and not results.missing("plotly")
    try:
        files = results.write(done, target, _report if reporting else None)
    except (OSError, results.NotOurs) as error:
        return _unwritten(target, error)
    _summarise(done, target, files)
    if results.missing("xarray", "h5netcdf", "h5py"):
        _note("Without xarray and h5netcdf the trajectory is an .npz file", "files")
    if not no_report and not reporting:
        _note("Without plotly there is no report", "report")
    if done.interrupted:
        return INTERRUPTED
    return 0 if done.motion.success else FAILED


@commands.command()
@click.argument("scene", type=SCENE)
@click.option(
    "-o",
    "--output",
    type=FOLDER,
    help="Folder for the results; results/NAME-statics unless given.",
    metavar="DIR",
)
@click.option(
    "--from-start", is_flag=True, help="Let go from the scene's q0 instead of loading from nothing."
)
@click.option("--no-report", is_flag=True, help="Write the numbers only.")
def statics(scene: Path, output: Path | None, from_start: bool, no_report: bool) -> int:
    """Find the shape in which SCENE rests.

    The loads grow from nothing; stability and buckling on the way are reported. The settings of the
    simulation are not used.

    Exit code: 0 done; 1 no equilibrium was found (the last good state is written); 2 bad input (nothing is
    written); 130 interrupted.
    """
    from . import studies
    from .report import studies as words

    loaded = _load(scene)
    target = _study_target(scene, output, "statics")
    done = studies.study_statics(loaded, from_start)
    files = _write_study(done, target, no_report)
    outcome, good = words.outcome(done)
    _say(loaded.name, outcome, good, words.summary(done), target, files)
    if done.found.message:
        click.echo(done.found.message)
    return 0 if done.found.success else FAILED


@commands.command()
@click.argument("scene", type=SCENE)
@click.option(
    "-o",
    "--output",
    type=FOLDER,
    help="Folder for the results; results/NAME-modes unless given.",
    metavar="DIR",
)
@click.option("--at-start", is_flag=True, help="About the scene's q0 as it is, instead of its equilibrium.")
@click.option("--no-report", is_flag=True, help="Write the numbers only.")
def modes(scene: Path, output: Path | None, at_start: bool, no_report: bool) -> int:
    """Find the natural frequencies and shapes of SCENE.

    About the equilibrium that "lissom statics" finds. The report animates the slowest ones.

    Exit code: 0 done; 1 there are none, or no equilibrium was found; 2 bad input; 130 interrupted.
    """
    from . import studies
    from ._lissom import LissomError
    from .report import studies as words

    loaded = _load(scene)
    target = _study_target(scene, output, "modes")
    try:
        done = studies.study_modes(loaded, at_start)
    except LissomError as error:
        click.echo(f"{loaded.name}: {error}", err=True)
        return FAILED
    if done.statics is not None and not done.statics.found.success:
        click.echo(f"{loaded.name}: {done.statics.found.message}", err=True)
        return FAILED
    files = _write_study(done, target, no_report)
    stable = done.found.is_stable
    rows = [
        (f"mode {number}", f"{hertz} Hz, damping ratio {ratio}")
        for number, hertz, ratio, _ in words.table(done)[: words.LISTED]
    ]
    outcome = f"{len(done.found.frequency)} modes, " + ("stable" if stable else "unstable")
    _say(loaded.name, outcome, stable, rows, target, files)
    return 0


@commands.command()
@click.argument("scenes", type=SCENE, nargs=-1, required=True, metavar="SCENE...")
def check(scenes: tuple[Path, ...]) -> int:
    """Say what is wrong with scenes.

    Everything that is wrong with each SCENE is listed, nothing is simulated. Of a good one
    it is said what its step, its modes and its method can show.

    Exit code: 0 all are good, 2 at least one is not.
    """
    from ._lissom import SceneError
    from .advice import advice

    good = True
    for path in scenes:
        try:
            scene = _read(path)
        except SceneError as error:
            click.echo(str(error), err=True)
            good = False
        else:
            click.echo(f"{path}: good, {scene.model.n} generalised coordinates")
            for sentence in advice(scene):
                click.echo(f"  {sentence}")
    return 0 if good else BAD_INPUT


@commands.command()
@click.argument("scene", type=SCENE)
def explain(scene: Path) -> int:
    """Say what SCENE is compiled to and what its steps cost.

    Prints what is computed, what is skipped, and why; then makes some steps and measures them. Nothing is
    written. Exit code: 0 done, 2 bad input.
    """
    from .report import text

    loaded = _load(scene)
    click.echo(loaded.model.explain(), nl=False)
    with _refusals_of(scene):
        steps = text.cost_of_steps(loaded)
    for title, rows in (("output", text.outputs(loaded)), ("steps", steps)):
        click.echo(f"  {title}")
        width = max(len(name) for name, _ in rows)
        for name, value in rows:
            click.echo(f"    {name:<{width}}  {value}")
    return 0


@commands.command()
@click.option(
    "-o",
    "--output",
    type=FOLDER,
    default=Path("results/lab"),
    show_default=True,
    metavar="DIR",
    help="Folder for the results.",
)
def lab(output: Path) -> int:
    """Rerun the numerical-methods lab.

    Its nine figures and three tables, beside the report's own numbers; takes some seconds. Earlier results in
    the folder are replaced; a folder with anything else in it is refused.

    Exit code: 0 done, 1 it could not be written, 2 bad input, 130 interrupted (nothing is written then).
    """
    from . import results

    if results.missing("plotly"):
        raise click.UsageError("the lab's figures need plotly: pip install 'lissom[report]'")
    from . import lab as numerical_lab

    try:
        files = numerical_lab.write(output, _bar)
    except results.NotOurs as error:
        raise click.UsageError(str(error)) from None
    except OSError as error:
        return _unwritten(output, error)
    for file in files:
        click.echo(file)
    return 0


@commands.command()
@click.option(
    "-o",
    "--output",
    type=FOLDER,
    default=Path("results/validation"),
    show_default=True,
    metavar="DIR",
    help="Folder for the report and the numbers.",
)
@click.option(
    "--update-docs",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write the table as Markdown to FILE as well.",
)
@click.option("--no-report", is_flag=True, help="Write the numbers only.")
def validate(output: Path, update_docs: Path | None, no_report: bool) -> int:
    """Ask questions with known answers.

    Closed forms, the same equations solved by other means and other codes, published numbers; takes some
    seconds, or a minute with PyElastica. Prints a table, and writes an HTML report with a plot for each case,
    and the numbers. Cases beside a code that is not installed are left out, and named.

    Exit code: 0 all cases are within their tolerance; 1 it could not be written; 2 bad input; 3 a case is
    outside its tolerance; 130 interrupted (nothing is written then).
    """
    from . import results, validation
    from .report import validation as report
    from .validation import table

    try:
        results.check_target(output)
    except results.NotOurs as error:
        raise click.UsageError(str(error)) from None
    except OSError as error:
        return _unwritten(output, error)
    click.echo(click.style(table.head(), bold=True))
    outcomes = validation.run_all(validation.CASES, _say_outcome)
    reporting = not no_report and not results.missing("plotly")
    try:
        files = validation.write(outcomes, output, report.write if reporting else None)
        if update_docs is not None:
            update_docs.write_text(table.markdown(outcomes), encoding="utf-8")
            files.append(update_docs)
    except results.NotOurs as error:
        raise click.UsageError(str(error)) from None
    except OSError as error:
        return _unwritten(output, error)
    good = not any(outcome.outside for outcome in outcomes)
    click.echo(click.style(table.verdict(outcomes), bold=True, fg=None if good else "red"))
    for file in files:
        click.echo(f"  {file}")
    if not no_report and not reporting:
        _note("Without plotly there is no report", "report")
    return 0 if good else OUTSIDE_TOLERANCE


def _say_outcome(outcome: Outcome) -> None:
    from .validation import table

    click.echo(click.style(table.line(outcome), fg="red" if outcome.outside else None))
    if outcome.failure:
        click.echo(f"  {outcome.failure}", err=True)


@commands.command()
@click.option(
    "-o",
    "--output",
    type=FOLDER,
    default=Path("results/stress"),
    show_default=True,
    metavar="DIR",
    help="Folder for the results.",
)
@click.option(
    "--quick", is_flag=True, help="A part of the cases, a few seconds; the whole takes some minutes."
)
@click.option(
    "--update", is_flag=True, help="Make what comes out the table that later runs are held against."
)
@click.option("--no-report", is_flag=True, help="Write the numbers only.")
def stress(output: Path, quick: bool, update: bool, no_report: bool) -> int:
    """Try hard cases: does each end well, or say why not?

    Slenderness, stiffness, sizes, time steps, many turns, buckling, ill-posed input and more. Every case
    ends as accurate, slow, refused or failed with a reason; "wrong" is a wrong result that was called
    success. A report with a heat map for every group is written.

    Exit code: 0 nothing became worse than in the committed table; 3 something did, or is wrong; 1 the results
    could not be written; 2 bad input; 130 interrupted (nothing is written then).
    """
    from . import results
    from . import stress as matrix
    from .stress import table

    if update and quick:
        raise click.UsageError("--update takes the whole matrix: leave --quick out")
    try:
        results.check_target(output)
    except results.NotOurs as error:
        raise click.UsageError(str(error)) from None
    except OSError as error:
        return _unwritten(output, error)
    with _bar(len(matrix.GROUPS), "Stress test", "groups") as bar:
        done = matrix.run(quick, lambda title: bar.update(1))
    found = table.of(done)
    if update:
        click.echo(table.update(found))
    expected = table.committed()
    worse = table.regressions(found, expected)
    report: Callable[..., None] | None = None
    reporting = not no_report and not results.missing("plotly")
    if reporting:
        from .report import stress as pages

        report = pages.write
    try:
        files = matrix.write(done, output, quick, worse, report)
    except (OSError, results.NotOurs) as error:
        return _unwritten(output, error)
    counts = [(group.group.title, _counts(group.counts)) for group in done]
    outcome = "nothing regressed" if not worse else f"{len(worse)} cells regressed or are wrong"
    _say("Stress test", outcome, not worse, [*counts, ("all", _counts(matrix.total(done)))], output, files)
    for cell in worse:
        click.echo(cell, err=True)
    better = table.improvements(found, expected)
    if better:
        click.echo(f"{better} cells are new or better than in the committed table; --update keeps that.")
    if not no_report and not reporting:
        _note("Without plotly there is no report", "report")
    return REGRESSED if worse else 0


def _counts(counts: Mapping[Any, int]) -> str:
    return ", ".join(f"{count} {kind}" for kind, count in counts.items() if count)


@commands.command()
def schema() -> int:
    """Print the keys of scenes, as a JSON Schema."""
    from ._lissom import Scene

    click.echo(Scene.schema(), nl=False)
    return 0


def _load(path: Path) -> Scene:
    """The scene, or the end of the program with everything that is wrong with it."""
    from ._lissom import SceneError

    try:
        return _read(path)
    except SceneError as error:
        click.echo(str(error), err=True)
        raise click.exceptions.Exit(BAD_INPUT) from None


def _read(path: Path) -> Scene:
    from ._lissom import Scene

    try:
        return Scene.load(path)
    except OSError as error:
        raise click.UsageError(f"{path} cannot be read: {error.strerror}") from None


@contextmanager
def _refusals_of(path: Path) -> Iterator[None]:
    """Within it, what ``simulate`` finds wrong with a scene is one line and the end of the program."""
    try:
        yield
    except ValueError as error:
        click.echo(f"{path}: {' '.join(str(error).split())}", err=True)
        raise click.exceptions.Exit(BAD_INPUT) from None


class _Interruption:
    """Turns the first Ctrl-C into a wish that the simulation hears; the second one ends the program."""

    def __init__(self) -> None:
        self.requested = False

    def __enter__(self) -> _Interruption:
        self._previous = signal.signal(signal.SIGINT, self._request)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        signal.signal(signal.SIGINT, self._previous)

    def _request(self, number: int, frame: FrameType | None) -> None:
        if self.requested:
            raise KeyboardInterrupt
        self.requested = True


def _simulate(scene: Scene) -> Run:
    """Simulate with a progress bar; Ctrl-C ends the simulation, not the program."""
    from ._lissom import AccuracyWarning
    from .results import Run

    settings = scene.simulation
    with _Interruption() as interruption, _bar(settings.duration, "Simulating", "s") as bar:

        def progress(t: float) -> bool:
            bar.update(t - settings.t0 - bar.n)
            return interruption.requested

        with warnings.catch_warnings():
            # The summary says it.
            warnings.simplefilter("ignore", AccuracyWarning)
            motion = scene.run(progress=progress)
    return Run(scene, motion, interrupted=motion.status == "interrupted")


def _bar(total: float, what: str, unit: str) -> Any:
    """A progress bar on stderr; nothing where that is not a terminal."""
    from tqdm import tqdm

    form = "{desc}: {percentage:3.0f}%|{bar}| {n:.3g}/{total:.3g} {unit} [{elapsed}<{remaining}]"
    return tqdm(
        total=total, desc=what, unit=unit, bar_format=form, file=sys.stderr, disable=None, leave=False
    )


def _report(done: Run, path: Path) -> None:
    from . import report

    report.write(done, path)


def _summarise(done: Run, target: Path, files: Sequence[Path]) -> None:
    from .report import text

    outcome, good = text.outcome(done)
    _say(done.scene.name, outcome, good, text.summary(done), target, files)


def _say(
    name: str,
    outcome: str,
    good: bool,
    facts: Sequence[tuple[str, str]],
    target: Path,
    files: Sequence[Path],
) -> None:
    """What was done, and where its results are."""
    click.echo(click.style(f"{name}: {outcome}", bold=True, fg=None if good else "red"))
    rows = [*facts, ("results", f"{target}/"), *(("", file.name) for file in files)]
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        click.echo(f"  {name:<{width}}  {value}")


def _study_target(scene: Path, output: Path | None, study: str) -> Path:
    """The folder for the results of a study, or the end of the program when it must not be written."""
    from . import results

    target = output if output is not None else Path("results") / f"{scene.stem}-{study}"
    try:
        results.check_target(target)
    except results.NotOurs as error:
        raise click.UsageError(str(error)) from None
    except OSError as error:
        raise click.exceptions.Exit(_unwritten(target, error)) from None
    return target


def _write_study(done: StaticsStudy | ModesStudy, target: Path, no_report: bool) -> list[Path]:
    """Write a study; the end of the program when that cannot be done."""
    from . import results, studies
    from .report import studies as report

    reporting = not no_report and not results.missing("plotly")
    try:
        files = studies.write(done, target, report.write if reporting else None)
    except (OSError, results.NotOurs) as error:
        raise click.exceptions.Exit(_unwritten(target, error)) from None
    if not no_report and not reporting:
        _note("Without plotly there is no report", "report")
    return files


def _unwritten(target: Path, error: Exception) -> int:
    click.echo(f"{target} could not be written: {error}", err=True)
    return FAILED


def _note(what: str, extra: str) -> None:
    click.echo(f"{what}; it takes: pip install 'lissom[{extra}]'", err=True)
