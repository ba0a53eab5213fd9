"""The command line: a file for each command.

Exit codes: 0 done, 1 the simulation failed or could not be written, 2 bad input, 3 a case of the validation
gallery is outside its tolerance or the stress test regressed, 130 interrupted.
Modules that take time to import (NumPy, xarray) are imported where they are used, so that ``--help`` is
quick; a command itself is imported when it is called or listed.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from typing import NoReturn

import click

from ..common.interruption import interruption
from .exits import INTERRUPTED

#: The commands, each in the module with its name, in the order in which people need them.
COMMANDS = (
    "new",
    "run",
    "view",
    "sweep",
    "check",
    "explain",
    "statics",
    "modes",
    "lab",
    "validate",
    "stress",
    "schema",
    "doctor",
    "completion",
)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """The command ``lissom``, without the care for Ctrl-C during imports that ``__main__.main`` takes."""
    try:
        interruption.answer()
        code = commands.main(arguments, prog_name="lissom", standalone_mode=False)
    except click.ClickException as error:
        error.show()
        if about := _about_keys(error):
            click.echo(about, err=True)
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


def _about_keys(error: click.ClickException) -> str:
    """How commands set keys of scenes, after an option that may stand for one, or a key in its place."""
    command = error.ctx.command if isinstance(error, click.UsageError) and error.ctx else None
    if command is None or all(parameter.name != "changes" for parameter in command.params):
        return ""
    if not isinstance(error, click.NoSuchOption):
        is_key = "extra argument" in error.message and "=" in error.message
        return "Keys of the scene are set by --set KEY=VALUE." if is_key else ""
    import json

    from .._lissom import Scene, meant

    keys = json.loads(Scene.schema())["definitions"]["Simulation"]["properties"]
    known = [key for key, about in keys.items() if not about.get("deprecated")]
    word = error.option_name.lstrip("-").replace("-", "_")
    is_option = len(word) == 1 or (error.possibilities and word not in known)
    key = None if is_option else meant(word, known)
    return f"Keys of the scene are set by --set simulation.{key}=VALUE." if key else ""


def _say_version(context: click.Context, _: click.Parameter, wanted: bool) -> None:
    if not wanted or context.resilient_parsing:
        return
    from .. import __version__

    click.echo(f"lissom, version {__version__}")
    context.exit()


class _Imported(click.Group):
    """Imports commands by their names, and shows them as they are listed."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        # For an unknown name, click searches all of them for similar ones.
        for name in (cmd_name,) if cmd_name in COMMANDS else COMMANDS:
            if name not in self.commands:
                self.add_command(import_module(f".{name}", __package__).command)
        return self.commands.get(cmd_name)


@click.group(
    cls=_Imported, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110}
)
@click.option(
    "--version",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=_say_version,
    help="Show the version and exit.",
)
@click.option(
    "--import-anywhere",
    is_flag=True,
    help="Let scenes import files outside their own folder.",
)
def commands(import_anywhere: bool) -> None:
    """Simulate soft robots.

    A scene is a TOML file that describes a robot and a simulation. Start with "lissom new NAME", which
    writes a commented scene, and "lissom run NAME.toml"; "lissom schema" lists the keys.
    """
