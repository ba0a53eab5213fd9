"""Controls of the page: buttons, sliders and the handle at a tip. Their actions are executed by the main
loop."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from ..._lissom import LissomError
from .playback import PATIENCE, Playback
from .shape import Shape
from .sliders import Slider

Array = NDArray[np.float64]

#: Speeds offered by the page, in addition to the initial one.
SPEEDS = (0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0)

#: Range of the strength of a pull's spring, relative to the default for the model.
WEAKEST, STRONGEST = 0.1, 1.5

#: Default colouring of rods.
ALONG = "position along the rod"

#: Length of the axes of the handle, relative to the model's size.
HANDLE = 0.12


class Controls:
    """The controls of a page.

    Their callbacks run in threads of the server and only queue actions for the main loop.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        playback: Playback,
        sliders: Sequence[Slider],
        shape: Shape,
        dark: bool = False,
    ) -> None:
        self._server = server
        self._playback = playback
        self._motion = playback.motion
        self._todo: SimpleQueue[Callable[[], None]] = SimpleQueue()
        #: Index of the tip with the handle, and whether the user holds it.
        self._tip, self._is_held = 0, False
        #: Whether the paths of the tips are drawn.
        self.is_traced = False
        self._shape = shape
        self._of_motion()
        self._sliders = [self._of_input(each) for each in self._folder("Inputs", sliders)]
        if sliders:
            defaults = server.gui.add_button("All inputs as at the start")
            defaults.on_click(self._later(lambda: self._put_back(sliders)))
        self._handle = self._of_pull(shape.stage.size) if self._motion.tips else None
        self._of_speed()
        self._of_page(dark)
        self._scale = self._of_picture()

        async def opened(client: viser.ClientHandle) -> None:
            self._todo.put(lambda: _step_back(client.camera, server.initial_camera))

        server.on_client_connect(opened)

    def _folder(self, name: str, entries: Sequence[Any]) -> Sequence[Any]:
        """Group controls below a heading, if there are any."""
        if entries:
            self._server.gui.add_markdown(f"**{name}**")
        return entries

    def _later(self, what: Callable[[], None]) -> Callable[[object], None]:
        """A callback that queues an action for the main loop."""

        def leave(_: object) -> None:
            self._todo.put(what)

        return leave

    def _of_motion(self) -> None:
        gui, playback = self._server.gui, self._playback
        self._trouble = gui.add_markdown("", visible=False)
        self._readout = gui.add_markdown("")
        self._run = gui.add_button("Run")
        step = gui.add_button("Step", hint="Pause, and advance by one step")
        reset = gui.add_button("Reset", hint="Back to the start")
        centre = gui.add_button("Centre", hint="Turn the camera to where the model is now")

        async def look(event: viser.GuiEvent[Any]) -> None:
            self._todo.put(lambda: self._look(event.client))

        centre.on_click(look)
        self._run.on_click(self._later(self._toggle))
        step.on_click(self._later(playback.step))
        reset.on_click(self._later(self._reset))

    def _of_speed(self) -> None:
        playback = self._playback
        by_name = {f"{each:g} ×": each for each in sorted({*SPEEDS, playback.speed})}
        speed = self._server.gui.add_dropdown("Speed", list(by_name), initial_value=f"{playback.speed:g} ×")

        def set_speed() -> None:
            playback.speed = by_name[str(speed.value)]

        speed.on_update(self._later(set_speed))

    def _of_page(self, dark: bool) -> None:
        server = self._server
        self._is_dark = server.gui.add_checkbox("Dark", dark, hint="Dark page")
        self._is_dark.on_update(self._later(lambda: show(server, bool(self._is_dark.value))))

    def _of_picture(self) -> Any:
        """Controls for the colours of rods and the traces of tips, with the caption of the colours."""
        gui, shape = self._server.gui, self._shape
        if shape.view.frames or shape.view.sketch is not None:
            trace = gui.add_checkbox("Trace", False, hint="Draw the way that the tips have taken")

            def draw_trace() -> None:
                self.is_traced = bool(trace.value)

            trace.on_update(self._later(draw_trace))
        if not shape.colours:
            return None
        colour = gui.add_dropdown("Colour", [ALONG, *shape.colours])

        def set_colour() -> None:
            shape.colour = None if colour.value == ALONG else str(colour.value)

        colour.on_update(self._later(set_colour))
        return gui.add_markdown("", visible=False)

    def _toggle(self) -> None:
        self._playback.is_paused = not self._playback.is_paused

    def _look(self, client: viser.ClientHandle | None) -> None:
        """Centre the model in the view of a page."""
        places = [
            np.asarray(link.pose(self._motion.q, link.stations, self._motion.t))
            for link in self._motion.view.links
        ]
        if client is None or not places:
            return
        points = np.concatenate(places)[:, :3, 3]
        camera = client.camera
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        shift = middle - camera.look_at
        camera.position = camera.position + shift
        camera.look_at = middle

    def _reset(self) -> None:
        self._is_held = False
        self._playback.reset()

    def _of_input(self, each: Slider) -> Any:
        slider = self._server.gui.add_slider(each.name, each.low, each.high, each.step, each.start)
        # Initial values between the steps of a slider remain exact.
        slider.on_update(
            self._later(lambda: self._motion.set(each.name, _within(slider.value, each.low, each.high)))
        )
        return slider

    def _put_back(self, sliders: Sequence[Slider]) -> None:
        for slider, each in zip(self._sliders, sliders, strict=True):
            slider.value = each.start
            self._motion.set(each.name, each.start)

    def _of_pull(self, size: float) -> Any:
        gui, motion = self._server.gui, self._motion
        gui.add_markdown("**Pull**: drag the handle at the tip")
        names = [tip.name for tip in motion.tips]
        if len(names) > 1:
            chosen = gui.add_dropdown("Tip", names)
            chosen.on_update(self._later(lambda: self._choose(names.index(str(chosen.value)))))
        strength = gui.add_slider("Spring", WEAKEST, STRONGEST, 0.05, 1.0)
        self._force = gui.add_markdown("")

        def set_strength() -> None:
            motion.strength = _within(strength.value, WEAKEST, STRONGEST)

        strength.on_update(self._later(set_strength))
        handle = self._server.scene.add_transform_controls(
            "/handle", HANDLE * size, disable_rotations=True, depth_test=False, position=motion.place(0)
        )

        async def drag(event: viser.TransformControlsEvent) -> None:
            phase, target = event.phase, np.array(handle.position, float)
            self._todo.put(lambda: self._drag(phase, target))

        handle.on_update(drag)
        return handle

    def _choose(self, number: int) -> None:
        self._motion.release()
        self._tip, self._is_held = number, False

    def _drag(self, phase: str, target: Array) -> None:
        if not np.isfinite(target).all():
            raise ValueError("a place that is not finite")
        self._is_held = phase != "end"
        if phase == "start" or (self._is_held and self._motion.pulled is not None):
            self._motion.pull(self._tip, target)
        elif not self._is_held:
            self._motion.release()

    def do(self) -> None:
        """Execute queued actions, as many as there is time for before the next frame."""
        deadline = time.perf_counter() + PATIENCE
        while time.perf_counter() < deadline:
            try:
                what = self._todo.get_nowait()
            except Empty:
                return
            # Messages of a page may hold anything.
            with suppress(ValueError, TypeError, KeyError, OverflowError, LissomError):
                what()

    def follow(self) -> Array | None:
        """Move the handle to the tip; return the two ends (2, 3) of the spring while it is held."""
        if self._handle is None:
            return None
        place = self._motion.place(self._tip)
        if self._motion.pulled is not None:
            return np.stack([place, self._motion.pulled[1]])
        # While the user holds it, the handle's position is the target.
        if not self._is_held and not np.array_equal(np.asarray(self._handle.position), place):
            self._handle.position = place
        return None

    def update(self) -> None:
        """Update time, energy, speed, and the reason of a failure."""
        playback, motion = self._playback, self._motion
        label = "Run" if playback.is_paused else "Pause"
        if self._run.label != label:
            self._run.label = label
        if self._run.disabled != bool(motion.trouble):
            self._run.disabled = bool(motion.trouble)
        if motion.trouble:
            self._trouble.content = f"**The motion has ended.** {_plain(motion.trouble)}"
        self._trouble.visible = bool(motion.trouble)
        self._readout.content = readout(playback)
        if self._scale is not None:
            is_coloured = self._shape.colour is not None
            self._scale.content = f"blue: 0, yellow: {self._shape.largest:.3g}" if is_coloured else ""
            self._scale.visible = is_coloured
        if self._handle is not None:
            norm = float(np.linalg.norm(motion.force))
            said = f"Force: {norm:.3g} N" if motion.pulled is not None else "Force: none"
            if motion.release_reason:
                said = f"Released: {_plain(motion.release_reason)}"
            self._force.content = said


def _step_back(camera: viser.CameraHandle, first: Any) -> None:
    """On pages that are higher than wide, see the whole model across them."""
    if camera.aspect < 1.0:
        # What a page says of its camera when it connects may be from before it was placed.
        place, towards = np.asarray(first.position, float), np.asarray(first.look_at, float)
        # In this order: another place moves the centre of the view, too.
        camera.position = towards + (place - towards) / camera.aspect
        camera.look_at = towards


def show(server: viser.ViserServer, dark: bool) -> None:
    """Show the page light or dark, without what leads to other servers."""
    server.gui.configure_theme(dark_mode=dark, show_logo=False, show_share_button=False)


def readout(playback: Playback) -> str:
    """Time, energy and speed in Markdown."""
    motion = playback.motion
    rows = [("time", f"{motion.t:.3f} s")]
    try:
        energy = motion.energy
    except (LissomError, ValueError):
        rows.append(("energy", "not finite"))
    else:
        rows += [("energy", f"{energy.total:.4g} J"), ("kinetic", f"{energy.kinetic:.3g} J")]
    factor, load = playback.real_time_factor, playback.load
    if factor is None or load is None:
        rows.append(("real-time factor", "paused" if playback.is_paused else "–"))
    else:
        rows.append(("real-time factor", f"{factor:.2f}, computing {100.0 * load:.0f} % of the time"))
    return "\n".join(["| | |", "|---|---|", *(f"| {name} | {value} |" for name, value in rows)])


def _within(value: Any, low: float, high: float) -> float:
    """The value of a slider, which a page may have set beyond its range."""
    number = float(value)
    if not low <= number <= high:
        raise ValueError(f"{number} is not between {low} and {high}")
    return number


def _plain(text: str) -> str:
    """Text with Markdown escaped."""
    return "".join(f"\\{letter}" if letter in "\\`*_{}[]<>#|" else letter for letter in text)
