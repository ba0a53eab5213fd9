"""The command line: ``lissom run``, ``statics``, ``modes``, ``check``, ``explain``, ``lab``, ``validate``,
``stress``, ``schema``.

Exit codes: 0 done, 1 the simulation failed or could not be written, 2 bad input, 3 a case of the validation
gallery is outside its tolerance or the stress test regressed, 130 interrupted.
What needs plotly or xarray is imported where it is used, so that ``--help`` is quick.
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

import click

from . import __version__
from .folders import Folder, NotOurs
from .interruption import SAVING, STOPPING, interruption

if TYPE_CHECKING:
    from ._lissom import Scene
    from .evidence.validation import Outcome
    from .results import Run
    from .studies import ModesStudy, StaticsStudy

FAILED = 1
BAD_INPUT = 2
OUTSIDE_TOLERANCE = 3
REGRESSED = 3
INTERRUPTED = 130

SCENE = click.Path(exists=True, dir_okay=False, path_type=Path)
FOLDER = click.Path(path_type=Path)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """The command ``lissom``, without the care for Ctrl-C during imports that ``__main__.main`` takes."""
    try:
        interruption.answer()
        code = commands.main(arguments, prog_name="lissom", standalone_mode=False)
    except click.ClickException as error:
        error.show()
        code = error.exit_code
    except BaseException as error:
        interruption.defer()
        # Modules that are interrupted while they are imported raise errors of all kinds.
        if not interruption.requested and not isinstance(error, click.Abort):
            raise
        click.echo("Interrupted; nothing was written.", err=True)
        code = INTERRUPTED
    interruption.defer()
    sys.exit(INTERRUPTED if interruption.requested else code)


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

    Trajectory, summary and an HTML report appear in the results folder when all of them are complete.
    Results of an earlier run are replaced; a folder with anything else in it is refused, as is one that
    another run is writing into. What cannot be written there at last goes to a temporary folder.

    Exit code: 0 done; 1 the simulation failed (what was computed is written) or something could not be
    written; 2 bad input (nothing is written); 130 interrupted with Ctrl-C (what was computed is written).
    """
    from . import results

    loaded = _load(scene)
    target = output if output is not None else Path("results") / scene.stem
    with _results_folder(target) as folder:
        report = _report_of_run if _reports(no_report) else None
        with _refusals_of(scene):
            done = _simulate(loaded)
        saved = _save(folder, lambda partial: results.write(done, partial, report))
    _summarise(done, saved)
    if results.missing(*results.FILES):
        _note("Without xarray and h5netcdf the trajectory is an .npz file", "files")
    return saved.code if done.motion.success or done.interrupted else FAILED


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

    loaded = _load(scene)
    target = output if output is not None else Path("results") / f"{scene.stem}-statics"
    with _results_folder(target) as folder:
        with _refusals_of(scene):
            done = studies.study_statics(loaded, from_start)
        saved = _save_study(done, folder, no_report)
    return _say_statics(done, saved)


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

    Exit code: 0 done; 1 there are none, or no equilibrium was found (what "lissom statics" writes is written
    then); 2 bad input; 130 interrupted.
    """
    from . import studies
    from ._lissom import LissomError
    from .report import studies as words

    loaded = _load(scene)
    target = output if output is not None else Path("results") / f"{scene.stem}-modes"
    with _results_folder(target) as folder:
        rest = None if at_start else studies.study_statics(loaded)
        try:
            interruption.answer()
            with _refusals_of(scene):
                done = studies.study_modes(loaded, rest)
        except (LissomError, KeyboardInterrupt) as error:
            if rest is not None:
                return _say_statics(rest, _save_study(rest, folder, no_report), str(error) or "interrupted")
            if isinstance(error, KeyboardInterrupt):
                raise
            click.echo(f"{loaded.name}: {error}", err=True)
            return FAILED
        saved = _save_study(done, folder, no_report)
    stable = done.found.is_stable
    rows = [
        (f"mode {number}", f"{hertz} Hz, damping ratio {ratio}")
        for number, hertz, ratio, _ in words.table(done)[: words.LISTED]
    ]
    outcome = f"{len(done.found.frequency)} modes, " + ("stable" if stable else "unstable")
    _say(loaded.name, outcome, stable, rows, saved)
    return saved.code


@commands.command()
@click.argument("scenes", type=SCENE, nargs=-1, required=True, metavar="SCENE...")
def check(scenes: tuple[Path, ...]) -> int:
    """Say what is wrong with scenes.

    Everything that is wrong with each SCENE is listed, nothing is simulated. Of a good one
    it is said what its step, its modes and its method can show.

    Exit code: 0 all are good, 2 at least one is not.
    """
    from .advice import advice

    good = True
    for path in scenes:
        try:
            scene = _load(path)
        except _Refused as error:
            error.show()
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

    Exit code: 0 done, 1 it could not be written, 2 bad input, 130 interrupted (the parts that were done are
    written then).
    """
    from . import results

    if results.missing("plotly"):
        raise click.UsageError("the lab's figures need plotly: pip install 'lissom[report]'")
    from .evidence import lab as numerical_lab

    with _results_folder(output) as folder:
        parts = dict(interruption.collect(numerical_lab.compute(_bar)))
        saved = _save(folder, lambda partial: numerical_lab.write(parts, partial))
    for file in saved.files:
        click.echo(saved.target / file)
    return saved.code


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
    outside its tolerance; 130 interrupted (the cases that were done are written then, FILE is not).
    """
    from .evidence import validation
    from .evidence.validation import pages as report
    from .evidence.validation import table

    def said(outcomes: Iterable[Outcome]) -> Iterator[Outcome]:
        for outcome in outcomes:
            yield outcome
            _say_outcome(outcome)

    with _results_folder(output) as folder:
        click.echo(click.style(table.head(), bold=True))
        outcomes = interruption.collect(said(validation.run_all(validation.CASES)))
        pages = report.write if _reports(no_report) else None
        saved = _save(folder, lambda partial: validation.write(outcomes, partial, pages))
    good = not any(outcome.outside for outcome in outcomes)
    click.echo(click.style(table.verdict(outcomes), bold=True, fg=None if good else "red"))
    for file in saved.files:
        click.echo(f"  {saved.target / file}")
    if update_docs is not None and not interruption.requested:
        try:
            update_docs.write_text(table.markdown(outcomes), encoding="utf-8")
        except OSError as error:
            return _unwritten(update_docs, error)
        click.echo(f"  {update_docs}")
    return saved.code if good else OUTSIDE_TOLERANCE


def _say_outcome(outcome: Outcome) -> None:
    from .evidence.validation import table

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
    could not be written; 2 bad input; 130 interrupted (the groups that were done are written then).
    """
    from .evidence import stress as matrix
    from .evidence.stress import pages, table

    if update and quick:
        raise click.UsageError("--update takes the whole matrix: leave --quick out")

    def counted(groups: Iterable[matrix.Done]) -> Iterator[matrix.Done]:
        with _bar(len(matrix.GROUPS), "Stress test", "groups") as bar:
            for group in groups:
                yield group
                bar.update(1)

    with _results_folder(output) as folder:
        done = interruption.collect(counted(matrix.run(quick)))
        found, expected = table.of(done), table.committed()
        if update and not interruption.requested:
            try:
                expected = found
                click.echo(table.update(found))
            except OSError as error:
                click.echo(f"The table could not be written: {error}", err=True)
        worse = table.regressions(found, expected)
        report = pages.write if _reports(no_report) else None
        saved = _save(folder, lambda partial: matrix.write(done, partial, quick, worse, report))
    counts = [(group.group.title, _counts(group.counts)) for group in done]
    outcome = "nothing regressed" if not worse else f"{len(worse)} cells regressed or are wrong"
    _say("Stress test", outcome, not worse, [*counts, ("all", _counts(matrix.total(done)))], saved)
    for cell in worse:
        click.echo(cell, err=True)
    better = table.improvements(found, expected)
    if better:
        click.echo(f"{better} cells are new or better than in the committed table; --update keeps that.")
    return REGRESSED if worse else saved.code


def _counts(counts: Mapping[Any, int]) -> str:
    return ", ".join(f"{count} {kind}" for kind, count in counts.items() if count)


@commands.command()
def schema() -> int:
    """Print the keys of scenes, as a JSON Schema."""
    from ._lissom import Scene

    click.echo(Scene.schema(), nl=False)
    return 0


class _Refused(click.ClickException):
    """A scene that cannot be used, with everything that is wrong with it."""

    exit_code = BAD_INPUT

    def show(self, file: Any = None) -> None:
        click.echo(self.message, err=True)


class _Unresolved(_Refused):
    """A scene whose open modes could not be chosen."""

    exit_code = FAILED


def _load(path: Path) -> Scene:
    """The scene; raises _Refused, which ends the program unless it is caught."""
    from ._lissom import LissomError, Scene, SceneError

    try:
        with _notes():
            return Scene.load(path)
    except OSError as error:
        raise click.UsageError(f"{path} cannot be read: {error.strerror}") from None
    except SceneError as error:
        raise _Refused(str(error)) from None
    except (LissomError, ValueError) as error:
        raise _Unresolved(f"{path}: {error}") from None


@contextmanager
def _notes() -> Iterator[None]:
    """Within it, what becomes different in the next version is said in a line, and nothing else happens."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", FutureWarning)
        try:
            yield
        finally:
            for warning in caught:
                click.echo(f"Note: {warning.message}", err=True)


@contextmanager
def _refusals_of(path: Path) -> Iterator[None]:
    """Within it, what the solvers find wrong with a scene is one line and the end of the program."""
    try:
        yield
    except ValueError as error:
        click.echo(f"{path}: {' '.join(str(error).split())}", err=True)
        raise click.exceptions.Exit(BAD_INPUT) from None


def _simulate(scene: Scene) -> Run:
    """Simulate with a progress bar. From the first step on Ctrl-C ends the simulation, not the program."""
    from ._lissom import AccuracyWarning
    from .results import Run

    settings = scene.simulation
    with _bar(settings.t_end - settings.t0, "Simulating", "s") as bar:

        def progress(t: float) -> bool:
            interruption.defer(STOPPING)
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
        total=total,
        desc=what,
        unit=unit,
        bar_format=form,
        file=sys.stderr,
        disable=True if sys.stderr is None else None,
        leave=False,
    )


def _reports(no_report: bool) -> bool:
    """Whether a report can be written and is wanted; a note if it is wanted only."""
    from . import results

    if no_report:
        return False
    if results.missing("plotly"):
        _note("Without plotly there is no report", "report")
        return False
    return True


def _report_of_run(done: Run, path: Path) -> None:
    from . import report

    report.write(done, path)


def _summarise(done: Run, saved: _Saved) -> None:
    from .report import text

    outcome, good = text.outcome(done)
    _say(done.scene.name, outcome, good, text.summary(done), saved)


def _say_statics(done: StaticsStudy, saved: _Saved, problem: str = "") -> int:
    """What was found, what is the matter with it; the exit code."""
    from .report import studies as words

    outcome, good = words.outcome(done)
    _say(done.scene.name, outcome, good, words.summary(done), saved)
    if done.found.message:
        click.echo(done.found.message)
    if problem and done.found.success:
        click.echo(f"No modes: {problem}", err=True)
    return FAILED if problem or not done.found.success else saved.code


def _say(name: str, outcome: str, good: bool, facts: Sequence[tuple[str, str]], saved: _Saved) -> None:
    """What was done, and where its results are."""
    click.echo(click.style(f"{name}: {outcome}", bold=True, fg=None if good else "red"))
    rows = [*facts, ("results", f"{saved.target}/"), *(("", file) for file in saved.files)]
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        click.echo(f"  {name:<{width}}  {value}")


@contextmanager
def _results_folder(target: Path) -> Iterator[Folder]:
    """A folder that certainly can be written, before anything is computed; or the end of the program."""
    try:
        folder = Folder(target)
    except NotOurs as error:
        raise click.UsageError(str(error)) from None
    except OSError as error:
        raise click.exceptions.Exit(_unwritten(target, error)) from None
    with folder:
        yield folder


class _Saved(NamedTuple):
    """Where results are."""

    target: Path
    files: list[str]
    #: 0 if all that was wanted is where it was wanted.
    code: int


def _save(folder: Folder, write: Callable[[Path], list[str]]) -> _Saved:
    """Write results, into a temporary folder if the one they are meant for fails them.

    From here on Ctrl-C is deferred. ``write`` returns what it could not write, in words.
    """
    interruption.defer(SAVING)
    try:
        return _written(folder, write, 0)
    except OSError as error:
        _unwritten(folder.target, error)
    try:
        with Folder(Path(tempfile.mkdtemp(prefix="lissom-"))) as other:
            saved = _written(other, write, FAILED)
    except OSError as error:
        raise click.exceptions.Exit(_unwritten(Path(tempfile.gettempdir()), error)) from None
    click.echo(f"The results are in {saved.target} instead.", err=True)
    return saved


def _written(folder: Folder, write: Callable[[Path], list[str]], code: int) -> _Saved:
    failures = write(folder.partial)
    for failure in failures:
        click.echo(failure, err=True)
    return _Saved(folder.target, folder.publish(), FAILED if failures else code)


def _save_study(done: StaticsStudy | ModesStudy, folder: Folder, no_report: bool) -> _Saved:
    from . import studies
    from .report import studies as pages

    interruption.defer(SAVING)
    report = pages.write if _reports(no_report) else None
    return _save(folder, lambda partial: studies.write(done, partial, report))


def _unwritten(target: Path, error: Exception) -> int:
    click.echo(f"{target} could not be written: {error}", err=True)
    return FAILED


def _note(what: str, extra: str) -> None:
    click.echo(f"{what}; it takes: pip install 'lissom[{extra}]'", err=True)
