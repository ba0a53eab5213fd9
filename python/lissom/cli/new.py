"""``lissom new``: a scene to start from."""

from __future__ import annotations

import os
from pathlib import Path

import click

from ..common import disk
from .exits import FAILED
from .saving import unwritten

#: Descriptions of the templates, by the names of the files in ``templates``.
KINDS = {
    "rod": "a clamped rod",
    "finger": "a finger with tendons",
    "robot": "links, joints and a motor",
    "cable": "a cable over a bar",
    "catheter": "a catheter in a vessel",
}

#: The file that the first line of a scene points editors to.
SCHEMA = "lissom-scene.schema.json"


@click.command("new")
@click.argument("name")
@click.option(
    "--kind",
    type=click.Choice(list(KINDS)),
    default="rod",
    show_default=True,
    help="; ".join(f"{kind}: {what}" for kind, what in KINDS.items()) + ".",
)
@click.option(
    "--schema", is_flag=True, help="Write the schema of scenes next to it, for completion in editors."
)
def command(name: str, kind: str, schema: bool) -> int:
    """Write NAME.toml, a commented scene to start from.

    Never overwrites a file. Exit code: 0 done, 1 the file could not be written, 2 it exists or NAME is not a
    file name.
    """
    from importlib.resources import files

    stem = name.removesuffix(".toml")
    if not stem or stem.endswith(("/", os.sep)) or not name.isprintable():
        raise click.UsageError(f"NAME: got {name!r}, expected a file name, such as arm")
    path = Path(f"{stem}.toml")
    text = (files(__package__) / "templates" / f"{kind}.toml").read_text(encoding="utf-8")
    if schema:
        text = f"#:schema ./{SCHEMA}\n{text}"
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
        if schema:
            _write_schema(path.with_name(SCHEMA))
    except FileExistsError:
        raise click.UsageError(f"{path} exists; give another name") from None
    except OSError as error:
        if not path.parent.is_dir():
            click.echo(
                f"{path} could not be written: there is no folder {path.parent}; make it first", err=True
            )
            return FAILED
        return unwritten(path, error)
    click.echo(f"{path} describes {KINDS[kind]}. To simulate it: lissom run {_quoted(path)}")
    return 0


def _quoted(path: Path) -> str:
    """A path as an argument in the user's shell."""
    import shlex
    import subprocess

    return subprocess.list2cmdline([str(path)]) if os.name == "nt" else shlex.quote(str(path))


def _write_schema(path: Path) -> None:
    from .._lissom import Scene

    disk.write(path, Scene.schema())
