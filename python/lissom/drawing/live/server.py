"""The server of a live view, with the loop between clock, motion, controls and drawing."""

from __future__ import annotations

import threading
import time
from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..._lissom import Simulation
from ...model.visuals import Visual
from ..report.layers import Strand, Thing
from .canvas import Canvas
from .controls import Controls, show
from .gate import quiet, serve
from .motion import Motion
from .playback import Playback
from .shape import Shape
from .sliders import sliders
from .trace import Trace

__all__ = ["LiveView"]

#: Maximum numbers of frames and of text updates per second.
PICTURES, TEXTS = 30.0, 6.0

#: Interval in seconds between checks for an open page.
LOOK = 0.05

#: Pages are served only to this machine.
HOST = "127.0.0.1"

#: Radius of the spring of a pull, relative to the model's size.
SPRING = 0.004


class LiveView:
    """A page that shows a running simulation and allows interaction.

    Created by `Simulation.view`. A context manager, which stops the server at its end.
    """

    def __init__(
        self,
        simulation: Simulation,
        *,
        port: int,
        speed: float,
        paused: bool,
        ranges: Mapping[str, Sequence[float]] | None,
        title: str,
        allow_hosts: Collection[str] = (),
        dark: bool = False,
        visuals: Sequence[Visual] = (),
    ) -> None:
        self._motion = motion = Motion(simulation, visuals)
        own = sliders(motion, ranges)
        self._shape = Shape(motion.view, motion.q, motion.v, motion.t, motion.u)
        self._playback = Playback(motion, speed, paused)
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None
        self._is_served = self._has_ended = False
        # Other threads may read the time during a step.
        self._t = motion.t
        self._reported_at = 0.0
        self._pictures = 0
        self._server = serve(HOST, port, title, allow_hosts)
        show(self._server, dark)
        self._server.gui.main_panel.dock_right()
        self._canvas = Canvas(self._server, self._shape.stage)
        self._trace = Trace(motion.view)
        self._controls = Controls(self._server, self._playback, own, self._shape, dark)
        self._draw()

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http://localhost:{self._server.get_port()}"

    @property
    def is_open(self) -> bool:
        """Whether the page is served."""
        return not self._closing.is_set()

    @property
    def t(self) -> float:
        """Time of the current frame, seconds."""
        return self._t

    @property
    def pictures(self) -> int:
        """Number of frames drawn."""
        return self._pictures

    def __enter__(self) -> LiveView:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def serve(self) -> None:
        """Run until `stop` is called or Ctrl-C is pressed."""
        try:
            self._is_served = True
            while not self._closing.is_set():
                begun = time.perf_counter()
                is_seen = self._frame()
                period = 1.0 / PICTURES if is_seen else LOOK
                self._closing.wait(max(0.0, period - (time.perf_counter() - begun)))
        except KeyboardInterrupt:
            pass
        finally:
            self._closing.set()
            self._end()

    def start(self) -> None:
        """Run in a thread until `stop` is called."""
        self._thread = threading.Thread(target=self.serve, name="lissom view", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Stop the server; may be called repeatedly."""
        self._closing.set()
        if self._thread is not None:
            self._thread.join()
        elif not self._is_served:
            self._end()

    def _end(self) -> None:
        """Stop the server, once."""
        if not self._has_ended:
            self._has_ended = True
            with quiet():
                self._server.stop()

    def _frame(self) -> bool:
        """One iteration of the loop; returns whether a page is open. The motion waits for the first page."""
        self._controls.do()
        if not self._server.get_clients():
            self._playback.hold()
            return False
        self._playback.frame()
        self._draw()
        return True

    def _draw(self) -> None:
        motion = self._motion
        things = self._shape.things(motion.q, motion.v, motion.t, motion.u)
        if self._controls.is_traced:
            self._trace.follow(motion.q, motion.t)
            things.append(self._trace.line)
        else:
            self._trace.clear()
        now = time.perf_counter()
        with self._server.atomic():
            ends = self._controls.follow()
            self._canvas.draw(things if ends is None else [*things, self._spring(ends)])
            if now - self._reported_at > 1.0 / TEXTS:
                self._reported_at = now
                self._controls.update()
        self._t = motion.t
        self._pictures += 1

    def _spring(self, ends: NDArray[np.float64]) -> Thing:
        radius = np.array([SPRING * self._shape.stage.size])
        return Strand("pull", "forces", ends[None], radius)
