"""``lissom sweep``: simulate a scene for ranges of its keys."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..common.interruption import interruption
from .exits import BAD_INPUT, FAILED
from .saving import output_option, results_folder, save
from .scenes import SCENE, load, refusals_of, set_option, value_of
from .words import note, print_outcome, progress_bar

if TYPE_CHECKING:
    import xarray

    from ..results.sweeps import SweepStudy

    Converter = click.ParamType[Any]
else:
    # Older versions of click have no type parameter here.
    Converter = click.ParamType

#: The form of `--over`, in words.
FORM = "KEY=FROM:TO:N, KEY=FROM:TO:N:log or KEY=A,B,C"

#: Most values of a key.
MOST = 1_000_000


class Over(Converter):
    """A key of a scene with its values."""

    name = "over"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[str, list[Any]]:
        """The key and the values."""
        key, sign, values = str(value).partition("=")
        try:
            if not (key and sign and values):
                raise ValueError(f"expected {FORM}")
            return key, _range(values) if ":" in values else _list(values)
        except ValueError as error:
            self.fail(f"{value!r}: {error}", param, ctx)


def _range(text: str) -> list[Any]:
    """Evenly spaced numbers; by their logarithms with "log"."""
    parts = text.split(":")
    if len(parts) not in (3, 4):
        raise ValueError(f"got {len(parts)} parts between colons, expected FROM:TO:N or FROM:TO:N:log")
    bounds = [_bound(name, part) for name, part in zip(("FROM", "TO"), parts, strict=False)]
    try:
        count = int(parts[2])
    except ValueError:
        raise ValueError(f"N is {parts[2]!r}, expected how many values: a whole number") from None
    if not 2 <= count <= MOST:
        raise ValueError(f"N is {count}, expected at least two values, and at most {MOST:,}")
    if parts[3:] not in ([], ["log"]):
        raise ValueError(f"{parts[3]!r} follows N, expected nothing or 'log'")
    if bounds[0] == bounds[1]:
        raise ValueError(f"FROM and TO are both {bounds[0]:g}, expected bounds that differ")
    if parts[3:] and min(bounds) <= 0.0:
        raise ValueError(f"a bound is {min(bounds):g}, expected bounds > 0 with log")
    import numpy as np

    spaced = np.geomspace if parts[3:] else np.linspace
    values: list[Any] = spaced(bounds[0], bounds[1], count).tolist()
    return values


def _bound(name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{name} is {text!r}, expected a finite number")
    return value


def _list(text: str) -> list[Any]:
    """Values as they are."""
    values = text.split(",")
    if not all(values):
        raise ValueError("a value between commas is missing")
    return [value_of(each) for each in values]


@click.command("sweep")
@click.argument("scene", type=SCENE)
@click.option(
    "--over",
    type=Over(),
    multiple=True,
    required=True,
    metavar="KEY=VALUES",
    help=f"A key of the scene and its values: {FORM}. Repeat it to combine several keys.",
)
@set_option
@click.option(
    "--store",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Save finished runs in a Zarr store, and resume from it.",
)
@click.option("--workers", type=click.IntRange(1), help="Number of threads; by default one per processor.")
@output_option("Folder for the results; results/NAME-sweep unless given.")
@click.option("--no-report", is_flag=True, help="Write the numbers only.")
def command(
    scene: Path,
    over: tuple[tuple[str, list[Any]], ...],
    changes: Mapping[str, Any],
    store: Path | None,
    workers: int | None,
    output: Path | None,
    no_report: bool,
) -> int:
    """Simulate SCENE over ranges of its keys.

    "lissom sweep arm.toml --over rod[0].segment[0].young_modulus=1e5:1e6:20:log" simulates twenty runs in
    parallel. Writes final states, extremes and tip positions, and a report with response curves and maps.

    Exit code: 0 done; 1 some runs failed (everything is written) or something could not be written; 2 bad
    input (nothing is written); 130 interrupted with Ctrl-C (what was computed is written).
    """
    from ..common.extras import missing
    from ..results import sweeps as results

    needed = ["xarray"] + ["zarr"] * (store is not None)
    if missing(*needed):
        note("Sweeps need xarray, and zarr for a store", "sweep")
        return FAILED
    keys = [key for key, _ in over]
    if len(set(keys)) < len(keys):
        click.echo("--over: the same key is given twice", err=True)
        return BAD_INPUT
    loaded = load(scene, changes)
    target = output if output is not None else Path("results") / f"{scene.stem}-sweep"
    with results_folder(target) as folder:
        start = time.perf_counter()
        with refusals_of(scene):
            found = _sweep(loaded, dict(over), store, workers)
        done = results.SweepStudy(loaded, found, tuple(keys), time.perf_counter() - start)
        saved = save(folder, lambda partial: results.write(done, partial, None if no_report else _report))
    print_outcome(loaded.name, done.outcome, done.is_good, done.summary, saved)
    return saved.code if done.is_good else FAILED


def _sweep(scene: Any, over: dict[str, list[Any]], store: Path | None, workers: int | None) -> xarray.Dataset:
    """The runs, with a bar; on Ctrl-C those that were made."""
    from ..analysis import sweeps

    total = math.prod(map(len, over.values()))
    with progress_bar(total, "Simulating", "runs") as bar:

        def progress(done: int) -> None:
            bar.update(done - bar.n)

        try:
            return sweeps.sweep(scene, over, store=store, workers=workers, progress=progress)
        except KeyboardInterrupt as error:
            result: xarray.Dataset | None = getattr(error, "result", None)
            if result is None or not result.is_done.any():
                raise
            interruption.defer()
            return result


def _report(done: SweepStudy, path: Path) -> None:
    from ..drawing.report import sweeps

    sweeps.write(done, path)
