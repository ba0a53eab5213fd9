"""``lissom schema``: the keys of scenes."""

from __future__ import annotations

import click


@click.command("schema")
def command() -> int:
    """Print the JSON Schema of scenes."""
    from .._lissom import Scene

    click.echo(Scene.schema(), nl=False)
    return 0
