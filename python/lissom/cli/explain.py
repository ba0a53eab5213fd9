"""``lissom explain``: what is computed for a scene, and what its steps cost."""

from __future__ import annotations

from pathlib import Path

import click

from .scenes import SCENE, load, refusals_of


@click.command("explain")
@click.argument("scene", type=SCENE)
def command(scene: Path) -> int:
    """Show what is computed for SCENE and what its steps cost.

    Prints what is computed, what is skipped, and why; then times some steps. Writes no files.

    Exit code: 0 done, 2 bad input.
    """
    from ..drawing.report import text

    loaded = load(scene)
    click.echo(loaded.model.explain(), nl=False)
    with refusals_of(scene):
        steps = text.cost_of_steps(loaded)
    for title, rows in (("output", text.outputs(loaded)), ("steps", steps)):
        click.echo(f"  {title}")
        width = max(len(name) for name, _ in rows)
        for name, value in rows:
            click.echo(f"    {name:<{width}}  {value}")
    return 0
