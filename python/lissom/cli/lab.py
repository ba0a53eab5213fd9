"""``lissom lab``: the numerical-methods lab, rerun."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from ..common.interruption import interruption
from .saving import output_option, results_folder, save
from .words import progress_bar


def _numbers(value: str) -> tuple[float, ...]:
    """One number, or several with commas between them."""
    try:
        return tuple(float(part) for part in value.split(","))
    except ValueError:
        wrong = f"{value!r} is no number: write `--start 6 --start 1`, or `--start 6,1`"
        raise click.BadParameter(wrong) from None


def _number(name: str, what: str, **more: Any) -> Callable[[Any], Any]:
    """An option with a number; without it the value of the lab's report counts."""
    return click.option(f"--{name}", type=float, metavar="NUMBER", help=what, **more)


@click.command("lab")
@output_option("Folder for the results.", Path("results/lab"))
@click.option(
    "--start",
    type=_numbers,
    metavar="NUMBER",
    multiple=True,
    help="Start of Newton's method; several with commas, or by repeating it.  [default: 6,1,0.7]",
)
@_number("dt", "Short implicit step, s; less than 1.  [default: 0.01]")
@_number("mass", "Mass of the pendulum, kg.  [default: 1]")
@_number("stiffness", "Stiffness of its spring, N/m.  [default: 10]")
@_number("angle", "Its angle at the start, rad, from the horizontal.  [default: -pi/4]")
@_number("elongation", "Elongation of its spring at the start, m.  [default: 0.5]")
@_number("radius", "Radius of the rod, m.  [default: 0.001]")
@_number("young-modulus", "Young's modulus of the rod, Pa.  [default: 2.1e11]")
@_number("density", "Density of the rod, kg/m³.  [default: 7800]")
@_number("retardation-time", "Damping of the rod, s.  [default: 0.0001]")
def command(output: Path, start: tuple[tuple[float, ...], ...], **options: float | None) -> int:
    """Rerun the numerical-methods lab.

    Reproduces its nine figures and three tables and compares them with the numbers of its report, in some
    seconds. With parameters other than the lab's, the same experiments are made with these; numbers of the
    report stand only beside its own models and steps. Replaces earlier results; refuses a folder that
    contains anything else.

    Exit code: 0 done; 1 the results could not be written; 2 bad input; 130 interrupted (finished parts are
    written).
    """
    from .evidence import lab as numerical_lab

    given: dict[str, Any] = {name: value for name, value in options.items() if value is not None}
    if start:
        given["start"] = tuple(number for numbers in start for number in numbers)
    try:
        setup = numerical_lab.Setup(**given)
    except ValueError as error:
        raise click.UsageError(f"--{error}") from None
    with results_folder(output) as folder:
        parts = dict(interruption.collect(numerical_lab.compute(progress_bar, setup)))
        saved = save(folder, lambda partial: numerical_lab.write(parts, partial, setup))
    for file in saved.files:
        click.echo(saved.target / file)
    return saved.code
