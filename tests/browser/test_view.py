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

    def __init__(self, browser, model, phone=None, **options):
        self.view = lissom.Simulation(model, dt=2e-3).view(port=0, block=False, **options)
        self.problems = []
        width, height = phone or (1000, 700)
        size = {"width": width, "height": height}
        self.page = browser.new_page(viewport=size, is_mobile=bool(phone), has_touch=bool(phone))
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


#: What a phone shows: the picture, the controls, sizes of what fingers press, and the width of the page.
ON_A_PHONE = """() => {
  const place = (node) => { const r = node.getBoundingClientRect(); return [r.x, r.y, r.right, r.bottom]; };
  const seen = (selector) => [...document.querySelectorAll(selector)].filter((node) => node.offsetWidth);
  return {
    picture: place(document.querySelector('canvas')),
    panel: place(document.querySelector('.mantine-Paper-root:has(.mantine-ScrollArea-root)')),
    heights: seen('.mantine-Button-root, .mantine-Slider-root, .mantine-Select-input').map((node) =>
      node.getBoundingClientRect().height),
    thumbs: seen('.mantine-Slider-thumb').map((node) => node.getBoundingClientRect().width),
    page: document.documentElement.scrollWidth,
  };
}"""

#: Least height of controls and width of the thumbs of sliders, pixels of the page.
CONTROL, THUMB = 24, 22


class Fingers:
    """Fingers on the screen of a phone."""

    def __init__(self, page):
        self.page = page
        self.session = page.context.new_cdp_session(page)

    def drag(self, *ways, stay=False):
        """Each finger from one place to another, in steps."""
        self._send("touchStart", [start for start, _ in ways])
        for part in np.linspace(0.125, 1.0, 8):
            self._send("touchMove", [np.add(a, part * np.subtract(b, a)) for a, b in ways])
        if not stay:
            self.lift()

    def lift(self):
        self._send("touchEnd", [])

    def _send(self, kind, points):
        touches = [{"x": float(x), "y": float(y), "id": i} for i, (x, y) in enumerate(points)]
        self.session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touches})
        self.page.wait_for_timeout(60)


def camera_of(shown):
    (client,) = shown.view._server.get_clients().values()
    return np.array(client.camera.position), np.array(client.camera.look_at), client.camera


def on_the_page(shown, place):
    """Where a place of the model is on the page, pixels."""
    at, towards, camera = camera_of(shown)
    back = (at - towards) / np.linalg.norm(at - towards)
    right = np.cross(camera.up_direction, back)
    right /= np.linalg.norm(right)
    x, y, width, height = shown.page.evaluate(
        "(() => { const r = document.querySelector('canvas').getBoundingClientRect();"
        " return [r.x, r.y, r.width, r.height]; })()"
    )
    away = np.asarray(place) - at
    scale = 0.5 * height / np.tan(0.5 * camera.fov) / -(away @ back)
    up = np.cross(back, right)
    return x + 0.5 * width + scale * (away @ right), y + 0.5 * height - scale * (away @ up)


def test_a_phone_shows_the_model_above_and_controls_below(live):
    shown = live(phone=(390, 844))
    found = shown.page.evaluate(ON_A_PHONE)
    assert found["page"] == 390
    left, top, right, bottom = found["picture"]
    # The controls begin below the picture, and are as wide as the page.
    assert (left, top, right) == (0, 0, 390)
    assert found["panel"][0] == 0
    assert found["panel"][2] == 390
    assert bottom - 1 < found["panel"][1] < 0.7 * 844
    assert bottom > 0.5 * 844
    assert len(found["heights"]) > 5
    assert min(found["heights"]) >= CONTROL
    assert min(found["thumbs"]) >= THUMB
    # All of the rod is in the picture, in its first view.
    shown.wait(lambda: np.linalg.norm(camera_of(shown)[0]) < 3.0)
    for place in ((0, 0, 0), (0.3, 0, 0)):
        x, y = on_the_page(shown, place)
        assert 0 < x < 390
        assert 0 < y < bottom


def test_fingers_turn_zoom_slide_and_pull(live):
    shown = live(phone=(390, 844))
    fingers = Fingers(shown.page)
    shown.wait(lambda: np.linalg.norm(camera_of(shown)[0]) < 3.0)
    shown.page.wait_for_timeout(1000)
    before, centre, _ = camera_of(shown)
    fingers.drag(((60, 380), (180, 380)))
    shown.wait(lambda: np.linalg.norm(camera_of(shown)[0] - before) > 0.2)
    shown.page.wait_for_timeout(1000)
    turned, still, _ = camera_of(shown)
    distance = np.linalg.norm(before - centre)
    np.testing.assert_allclose(still, centre, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(turned - centre), distance, rtol=1e-6)
    fingers.drag(((180, 380), (100, 380)), ((210, 380), (290, 380)))
    shown.page.wait_for_timeout(1000)
    near, middle, _ = camera_of(shown)
    assert np.linalg.norm(near - middle) < 0.95 * distance
    box = shown.page.locator(".mantine-Slider-thumb").first.bounding_box()
    thumb = (box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    fingers.drag((thumb, np.add(thumb, (80, 0))))
    shown.wait(lambda: shown.view._motion.u[0] > 0.0)
    # The handle at the tip, once the rod has come to rest.
    shown.page.get_by_role("button", name="Centre", exact=True).tap()
    shown.wait(lambda: shown.read("kinetic") < 1e-6)
    shown.page.wait_for_timeout(1000)
    tip = on_the_page(shown, shown.view._motion.place(0))
    fingers.drag((tip, np.subtract(tip, (0, 60))), stay=True)
    shown.wait(lambda: shown.view._motion.pulled is not None)
    shown.wait(lambda: np.linalg.norm(shown.view._motion.force) > 0.0)
    fingers.lift()
    shown.wait(lambda: shown.view._motion.pulled is None)
