"""Live view: an interactive page that shows a simulation while it is computed (`docs/view.md`).

`motion` and `playback` advance the simulation, `shape` decides what is drawn, `canvas` and `controls` use
viser, and `server` has the main loop.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..._lissom import Scene, Simulation
from ...common.arguments import flag, number, sequence, whole
from ...common.extras import missing
from ...model.visuals import Visual
from .motion import ADAPTIVE

if TYPE_CHECKING:
    from .server import LiveView

#: Default port of the page.
PORT = 8080


def open_view(
    simulation: Simulation,
    *,
    port: int = PORT,
    speed: float = 1.0,
    paused: bool = False,
    ranges: Mapping[str, Sequence[float]] | None = None,
    title: str = "lissom",
    allow_hosts: Sequence[str] = (),
    dark: bool = False,
    visuals: Sequence[Visual] = (),
) -> LiveView:
    """Create the page of a simulation, initially not running; raises as `Simulation.view` does."""
    if missing("viser"):
        raise ImportError("live views need viser: pip install 'lissom[view]'")
    port = whole("port", port)
    if not 0 <= port <= 65535:
        raise ValueError(f"port: {port} is not between 0 and 65535")
    speed = number("speed", speed)
    if not (math.isfinite(speed) and speed > 0.0):
        raise ValueError(f"speed: {speed:g} is not a finite number above zero")
    paused = flag("paused", paused)
    allow_hosts = sequence("allow_hosts", allow_hosts, "names of hosts, such as 'robot.local'")
    if not all(isinstance(host, str) for host in allow_hosts):
        raise TypeError("allow_hosts: expected names of hosts, such as 'robot.local'")
    from .server import LiveView

    return LiveView(
        simulation,
        port=port,
        speed=speed,
        paused=paused,
        ranges=ranges,
        title=title,
        allow_hosts=allow_hosts,
        dark=flag("dark", dark),
        visuals=visuals,
    )


def of_scene(
    scene: Scene,
    *,
    port: int = PORT,
    speed: float = 1.0,
    paused: bool = False,
    allow_hosts: Sequence[str] = (),
    dark: bool = False,
    visuals: Sequence[Visual] = (),
) -> LiveView:
    """Create the page of a scene, initially not running; raises as `Simulation.view` does."""
    return open_view(
        simulation_of(scene),
        port=port,
        speed=speed,
        paused=paused,
        title=scene.name,
        allow_hosts=allow_hosts,
        dark=dark,
        visuals=visuals,
    )


def simulation_of(scene: Scene) -> Simulation:
    """A simulation with the initial state and the method of a scene."""
    settings = scene.simulation
    start: dict[str, Any] = {"t0": settings.t0, "q0": scene.q0, "v0": scene.v0, "dt": settings.dt}
    if settings.method == "auto":
        # The method "auto" requires a run of known length.
        return Simulation(scene.model, method="radau", rtol=settings.rtol, **start)
    if settings.method in ADAPTIVE:
        start |= {"rtol": settings.rtol, "atol": settings.atol}
    return Simulation(scene.model, method=settings.method, **start)
