"""``lissom view``: a scene in motion, live in a browser."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from ..common.interruption import interruption
from .exits import FAILED
from .scenes import SCENE, load, refusals_of, set_option, visuals_of, visuals_option
from .words import line, note


@click.command("view")
@click.argument("scene", type=SCENE)
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=8080,
    show_default=True,
    help="Port of the page. If it is taken, the next free one; 0 for any free one.",
)
@click.option(
    "--speed",
    type=click.FloatRange(0.0, min_open=True),
    default=1.0,
    show_default=True,
    help="Simulated seconds per second.",
)
@click.option("--paused", is_flag=True, help="Start paused.")
@click.option("--dark", is_flag=True, help="Show a dark page at first.")
@set_option
@visuals_option
@click.option(
    "--allow-host",
    "allow_hosts",
    multiple=True,
    metavar="NAME",
    help="Name of a host whose pages may use the view, such as that of a proxy; may be given several times.",
)
def command(
    scene: Path,
    port: int,
    speed: float,
    paused: bool,
    dark: bool,
    changes: Mapping[str, Any],
    visuals: bool,
    allow_hosts: tuple[str, ...],
) -> int:
    """Simulate SCENE live in a browser.

    In the page you can pause and step, change inputs with sliders and pull the tip. It is served to this
    machine only, until Ctrl-C. Writes no files, and ignores t_end and output of the scene.

    Exit code: 1 viser is missing or no port is free; 2 bad input; 130 ended with Ctrl-C.
    """
    from ..common.extras import missing

    if missing("viser"):
        note("Live views need viser", "view")
        return FAILED
    from ..drawing.live import of_scene

    loaded = load(scene, changes)
    pictures = visuals_of(scene, loaded) if visuals else ()
    try:
        with refusals_of(scene):
            view = of_scene(
                loaded,
                port=port,
                speed=speed,
                paused=paused,
                allow_hosts=allow_hosts,
                dark=dark,
                visuals=pictures,
            )
    except OSError as error:
        click.echo(f"--port: no page can be served at {port}: {error}", err=True)
        return FAILED
    try:
        interruption.answer()
        click.echo(f"{line(loaded.name)}: open {view.url} in a browser; Ctrl-C ends.")
        view.serve()
    except KeyboardInterrupt:
        # Before the page was served.
        pass
    finally:
        interruption.defer()
        view.stop()
    return 0
