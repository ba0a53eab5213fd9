"""``lissom check``: mistakes in scenes, and advice about valid ones."""

from __future__ import annotations

from pathlib import Path

import click

from .exits import BAD_INPUT
from .scenes import Refused, load


@click.command("check")
@click.argument("scenes", type=click.Path(path_type=Path), nargs=-1, required=True, metavar="SCENE...")
def command(scenes: tuple[Path, ...]) -> int:
    """Check scenes without simulating them.

    Lists all mistakes of each SCENE. For a valid one, says what its step, its modes and its
    method can resolve, and questions implausible units.

    Exit code: 0 all are valid, 2 at least one is not.
    """
    from ..analysis.advice import advice, size
    from ..model.starts import check_start

    good = True
    for path in scenes:
        # The others are checked all the same.
        if not path.is_file():
            click.echo(f"{path}: {'not a file' if path.exists() else 'there is no such file'}", err=True)
            good = False
            continue
        try:
            scene = load(path)
        except Refused as error:
            error.show()
            good = False
        else:
            try:
                check_start(scene)
            except ValueError as error:
                click.echo(f"{path}: {' '.join(str(error).split())}", err=True)
                good = False
                continue
            click.echo(f"{path}: good, {size(scene.model)}")
            for sentence in advice(scene):
                click.echo(f"  {sentence}")
    return 0 if good else BAD_INPUT
