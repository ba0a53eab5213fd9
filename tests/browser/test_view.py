"""Live views in a browser: the page shows the motion; buttons, sliders and the handle act on it."""

import re
import time

import numpy as np
import pytest

import lissom
from conftest import PATIENCE

SOFT = lissom.Segment(0.3, 0.012, 1e6, 4e5, 1000.0, modes={"bend_y": 3, "bend_z": 2}, retardation_time=0.02)
FINGER = lissom.Rod(
    [SOFT],
    actuators=[
        lissom.Tendon("upper", [lissom.Along("rod", (0.0, 0.008))], tension=lissom.Input("upper")),
    ],
)

#: Console messages of viser itself.
ITS_OWN = ("THREE.Clock", "GPU stall", "WebGL")


class Live:
    """A live view and a page that shows it."""

    def __init__(self, browser, model, **options):
        self.view = lissom.Simulation(model, dt=2e-3).view(port=0, block=False, **options)
        self.problems = []
        self.page = browser.new_page(viewport={"width": 1000, "height": 700})
        self.page.set_default_timeout(PATIENCE)
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on("console", self._said)
        self.page.on("request", self._requested)
        self.page.goto(self.view.url)
        self.page.wait_for_function("document.body.innerText.includes('real-time factor')")

    def _said(self, message):
        if message.type in ("error", "warning") and not any(its in message.text for its in ITS_OWN):
            self.problems.append(message.text)

    def _requested(self, request):
        if not request.url.startswith((self.view.url, "data:", "blob:")):
            self.problems.append(f"asked for {request.url}")

    def read(self, name):
        """The number beside a name in the readout."""
        found = re.search(rf"^{name}\s+([-\d.e+]+)", self.page.inner_text("body"), re.M)
        return float(found[1])

    def draw(self, frames):
        """Wait until the page has drawn this many frames."""
        self.page.evaluate(
            """frames => new Promise(done => {
                const next = left => left ? requestAnimationFrame(() => next(left - 1)) : done();
                next(frames);
            })""",
            frames,
        )

    def wait(self, condition):
        """Wait until a condition holds."""
        until = time.monotonic() + PATIENCE / 1000
        while not condition():
            assert time.monotonic() < until
            time.sleep(0.1)

    def press(self, name):
        self.page.get_by_role("button", name=name, exact=True).click()


@pytest.fixture
def live(browser):
    opened = []

    def at(model=FINGER, **options):
        opened.append(Live(browser, model, **options))
        return opened[-1]

    yield at
    for each in opened:
        each.page.close()
        each.view.stop()
    assert [each.problems for each in opened] == [[] for _ in opened]


def test_it_plays_and_pauses_and_starts_again(live):
    shown = live()
    shown.wait(lambda: shown.read("time") > 1.0)
    shown.press("Pause")
    shown.wait(lambda: shown.page.get_by_role("button", name="Run", exact=True).count() == 1)
    at = shown.view.t
    shown.press("Step")
    shown.wait(lambda: shown.view.t > at)
    assert shown.view.t == pytest.approx(at + 2e-3)
    shown.press("Reset")
    shown.wait(lambda: shown.view.t == 0.0)
    shown.press("Run")
    shown.wait(lambda: shown.view.t > 0.2)


def test_the_motion_is_seen(live):
    """Pictures of a falling rod differ, and are not a uniform background."""
    shown = live(paused=True)
    canvas = shown.page.locator("canvas").first
    before = canvas.screenshot()
    shown.press("Run")
    shown.wait(lambda: shown.view.t > 0.5)
    after = canvas.screenshot()
    assert before != after
    assert len(before) > 10_000


def test_traces_and_colours_are_drawn(live):
    shown = live(paused=True)
    canvas = shown.page.locator("canvas").first
    shown.press("Run")
    shown.wait(lambda: shown.view.t > 0.5)
    shown.press("Pause")
    shown.wait(lambda: shown.page.get_by_role("button", name="Run", exact=True).count() == 1)
    plain = canvas.screenshot()
    shown.page.get_by_role("combobox").filter(has_text="position along the rod").or_(
        shown.page.locator("input[value='position along the rod']")
    ).first.click()
    shown.page.get_by_role("option", name="curvature (1/m)").click()
    shown.wait(lambda: "blue: 0, yellow:" in shown.page.inner_text("body"))
    shown.page.wait_for_timeout(500)
    coloured = canvas.screenshot()
    assert coloured != plain
    shown.page.get_by_role("checkbox", name="Trace").check()
    # The rod falls from the start again.
    shown.press("Reset")
    shown.wait(lambda: shown.view.t == 0.0)
    shown.press("Run")
    shown.wait(lambda: shown.view.t > 0.5)
    trace = shown.view._canvas._nodes["/paths/trace"]
    assert trace.visible
    assert np.ptp(trace.points.reshape(-1, 3), axis=0).max() > 0.01


def test_a_slider_moves_its_input(live):
    shown = live()
    slider = shown.page.get_by_role("slider").nth(0)
    slider.focus()
    for _ in range(20):
        slider.press("ArrowRight")
    shown.wait(lambda: shown.view._motion._u[-1] > 0.0)
    (name,) = FINGER.inputs
    assert name in shown.page.inner_text("body")


def test_dragging_the_handle_pulls_the_tip(live):
    shown = live()
    # At rest, so that the tip is still there when the page has drawn it.
    shown.wait(lambda: shown.view.t > 5.0)
    box = shown.page.locator("canvas").first.bounding_box()
    # The position of the tip on the screen; the upward arrow of the handle is above it.
    x, y = _on_screen(shown, box)
    mouse = shown.page.mouse
    mouse.move(x, y - 12)
    mouse.move(x, y - 25)
    # The page determines the object under the pointer when it draws, which takes long on a busy machine.
    shown.draw(30)
    mouse.down()
    for step in range(10):
        mouse.move(x, y - 25 - 8 * (step + 1))
        shown.draw(2)
    shown.wait(lambda: "Force: none" not in shown.page.inner_text("body"))
    assert "N" in re.search(r"Force: (.*)", shown.page.inner_text("body"))[1]
    mouse.up()
    shown.wait(lambda: "Force: none" in shown.page.inner_text("body"))


def _on_screen(shown, box):
    """Position of the tip on the screen, pixels."""
    (client,) = shown.view._server.get_clients().values()
    camera = client.camera
    forward = camera.look_at - camera.position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, camera.up_direction)
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    shown.press("Pause")
    shown.wait(lambda: shown.page.get_by_role("button", name="Run", exact=True).count() == 1)
    seen = np.asarray(shown.view._controls._handle.position) - camera.position
    shown.press("Run")
    scale = 0.5 * box["height"] / np.tan(0.5 * camera.fov)
    depth = seen @ forward
    middle = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    return middle[0] + scale * (seen @ right) / depth, middle[1] - scale * (seen @ up) / depth


def test_the_end_of_a_motion_is_shown(live):
    def breaks(t):
        if t > 0.3:
            raise RuntimeError("the valve stuck")
        return (0.0, 0.0, 0.0)

    shown = live(lissom.Rod([SOFT], loads=[lissom.Load(force=breaks)]))
    shown.wait(lambda: "The motion has ended" in shown.page.inner_text("body"))
    assert "the valve stuck" in shown.page.inner_text("body")
    shown.press("Reset")
    shown.wait(lambda: shown.view.t < 0.3)
