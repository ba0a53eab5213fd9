"""Reports in a browser: contents, playback, keys and touch, saved files."""

import base64
import csv
import io
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe
from PIL import Image

import lissom
from conftest import PATIENCE, ROD, turning_path

PICTURES = Path(__file__).parent / "pictures"

#: Screenshots are compared in squares of this many pixels, with this maximum and mean difference relative to
#: white: letters and edges differ between machines, the drawing does not.
SQUARE, APART, MEAN_APART = 16, 0.16, 0.01

#: Whether the page has drawn everything.
READY = """() => [...document.querySelectorAll('.player, .figure')]
  .every((holder) => holder.dataset.state === 'ready')"""

#: Maximum size of a report of three seconds, bytes.
LARGEST = 2_000_000


def test_reports_are_small(folder):
    for path in folder.iterdir():
        assert path.stat().st_size < LARGEST / 2, path.name


@pytest.mark.parametrize("name", ["motion", "statics", "modes", "path"])
def test_everything_is_drawn(name, opened):
    shown = opened(name)
    shown.page.wait_for_function(READY)
    # The picture is not a uniform background: every canvas has many colours.
    colours = shown.page.evaluate(
        """() => [...document.querySelectorAll('.curves')].map((canvas) => {
          const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
          return new Set(new Uint32Array(data.buffer)).size;
        })"""
    )
    assert all(count > 10 for count in colours)


def test_legends_show_the_marks_of_curves(opened):
    """The critical points of a path are diamonds in its plots, and in their legend."""
    shown = opened("path")
    shown.page.wait_for_function(READY)
    samples = shown.page.locator(".figure .legend i.diamond")
    assert samples.count() > 0
    drawn = samples.first.evaluate(
        "sample => [sample.getBoundingClientRect().width, getComputedStyle(sample).transform]"
    )
    assert drawn[0] > 5
    assert drawn[1] != "none"


#: What the page is drawn from: sizes and colours of canvases, and what is shown.
LAID = """() => {
  const colours = (canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size;
  };
  const canvases = [...document.querySelectorAll('.curves')].filter((canvas) => canvas.offsetWidth);
  const [view] = document.querySelectorAll('.view');
  const still = document.querySelector('.still');
  return {
    curves: canvases.map((canvas) => [canvas.width / canvas.offsetWidth, colours(canvas)]),
    view: view.querySelector('canvas').width / view.offsetWidth,
    still: still && [still.width / view.offsetWidth, colours(still)],
    corner: still && [...still.getContext('2d').getImageData(0, 0, 1, 1).data],
    ground: getComputedStyle(document.body).getPropertyValue('--view').trim(),
  };
}"""


@pytest.mark.parametrize("dark", [False, True])
def test_paper_shows_stills_and_all_plots(dark, opened, tmp_path):
    """Also plots that have not been in sight, in light colours, and the screen is as before afterwards."""
    shown = opened("motion")
    page = shown.page
    page.wait_for_function(READY)
    if dark:
        page.emulate_media(color_scheme="dark")
    before = page.evaluate(LAID)
    assert before["still"] is None
    page.evaluate("() => dispatchEvent(new Event('beforeprint'))")
    paper = page.evaluate(LAID)
    assert paper["ground"] == "#ffffff"
    assert paper["corner"] == [255, 255, 255, 255]
    # Three pixels for each of the page: 288 an inch.
    assert [round(ratio) for ratio, _ in paper["curves"]] == [3] * len(before["curves"])
    assert min(count for _, count in paper["curves"]) > 10
    ratio, colours = paper["still"]
    assert ratio == pytest.approx(3.0, abs=0.02)
    assert colours > 100
    page.evaluate("() => dispatchEvent(new Event('afterprint'))")
    after = page.evaluate(LAID)
    assert (after["still"], after["ground"], after["view"]) == (None, before["ground"], before["view"])
    assert [ratio for ratio, _ in after["curves"]] == [ratio for ratio, _ in before["curves"]]
    printed = page.pdf(path=tmp_path / "x.pdf", format="A4")
    assert printed.startswith(b"%PDF")
    # The still is in it, as are the plots: pixels of canvases are images.
    assert printed.count(b"/Subtype /Image") >= 1 + len(before["curves"])


def test_a_path_whose_loads_turn_back_plays_and_says_its_loads(opened):
    shown = opened("path")
    factor = turning_path()[1].path.load_factor
    assert shown.run("return [clock.start, clock.end, clock.time]") == [0, 1, 1]
    said = []
    for part in np.linspace(0, 1, 41):
        shown.run(f"clock.seek({part})")
        said.append(float(shown.page.locator(".now").text_content().removeprefix("load factor ")))
    assert said[0] == said[-1] == 1.0
    # Down to the limit point and up again, never below it.
    lowest = int(np.argmin(said))
    assert (np.diff(said[: lowest + 1]) <= 0).all()
    assert (np.diff(said[lowest:]) >= 0).all()
    assert factor.min() - 1e-3 <= min(said) <= factor.min() + 0.05
    # The Play button is visible, so this is not a still picture.
    assert shown.page.locator(".play").is_visible()


def test_what_is_written_stands_above_the_model(opened):
    shown = opened("statics", width=390, height=844)
    top = shown.run(
        """const { camera } = player, { matrix } = camera.look(), { low, high } = camera;
        const height = (x, y, z) => (matrix[1] * x + matrix[5] * y + matrix[9] * z + matrix[13])
          / (matrix[3] * x + matrix[7] * y + matrix[11] * z + matrix[15]);
        const corners = [...Array(8).keys()].map((i) =>
          [0, 1, 2].map((axis) => ((i >> axis) & 1 ? high : low)[axis]));
        const highest = Math.max(...corners.map((corner) => height(...corner)));
        return 0.5 * (1 - highest) * player.view.clientHeight;"""
    )
    assert top > 30


def test_scrubbing_while_it_plays(opened):
    shown = opened("motion")
    slider, button = shown.page.locator("input[type=range]"), shown.page.locator(".play")
    for _ in range(3):
        button.click()
        assert shown.run("return clock.plays")
        for value in (900, 100, 500):
            slider.evaluate(
                """(it, value) => {
                  it.value = value;
                  it.dispatchEvent(new Event('input', { bubbles: true }));
                }""",
                value,
            )
        assert shown.run("return [clock.time, clock.plays]") == [1.5, False]
    assert "1.50 s" in slider.get_attribute("aria-valuetext")


def test_it_plays_in_real_time_however_slowly_it_draws(opened):
    """The browser asks for a picture at times of our own, so that a busy machine changes nothing."""
    shown = opened("motion")
    slow, hidden, drawn = shown.run(
        """
        let asked = [], drawn = 0;
        window.requestAnimationFrame = (tick) => asked.push(tick);
        player.stage.draw = () => drawn++;
        // A picture that was asked for before comes too late to count.
        player.isWaiting = false;
        const at = (time) => {
          const now = asked;
          asked = [];
          for (const tick of now) tick(time);
        };
        clock.seek(0);
        const start = performance.now();
        clock.play();
        for (const time of [400, 800, 1200, 1600]) at(start + time);
        const slow = clock.time;
        at(start + 9000);
        return [slow, clock.time, drawn];
        """
    )
    assert abs(slow - 1.6) < 0.1
    # A page in the background is not asked for pictures; the clock waits.
    assert abs(hidden - slow - 1.0) < 1e-6
    assert 4 <= drawn <= 7


def test_one_cursor_through_all(opened):
    shown = opened("motion")
    shown.page.wait_for_function(
        "() => document.querySelectorAll('.figure[data-state=ready] .curves').length >= 3"
    )
    plot = shown.page.locator(".curves").first
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    shown.page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    time = shown.run("return clock.time")
    assert 1.2 < time < 1.8
    assert f"{time:.2f} s" in shown.page.locator(".now").inner_text()


def test_keys_pointer_and_wheel_move_the_camera(opened):
    shown = opened("motion")
    canvas = shown.page.locator(".view canvas").first
    look = """const { around, height, distance, target } = player.camera;
              return [around, height, distance, ...target];"""
    before = shown.run(look)
    canvas.focus()
    for key in ("ArrowLeft", "ArrowUp", "+"):
        shown.page.keyboard.press(key)
    turned = shown.run(look)
    assert turned[0] != before[0]
    assert turned[1] > before[1]
    assert turned[2] < before[2]
    shown.page.keyboard.press(" ")
    assert shown.run("return clock.plays")
    shown.page.keyboard.press(" ")
    assert not shown.run("return clock.plays")
    box = canvas.bounding_box()
    shown.page.mouse.move(box["x"] + 200, box["y"] + 200)
    shown.page.mouse.down()
    shown.page.mouse.move(box["x"] + 260, box["y"] + 220)
    shown.page.mouse.up()
    dragged = shown.run(look)
    np.testing.assert_allclose(dragged[0], turned[0] - 0.008 * 60, atol=1e-6)
    shown.page.mouse.wheel(0, 200)
    assert shown.run(look)[2] > dragged[2]
    shown.page.keyboard.press("0")
    shown.page.wait_for_function("() => document.querySelector('.player').player.camera.isHome")
    np.testing.assert_allclose(shown.run(look), before, atol=1e-6)
    # Every preset shows the complete box.
    for view, axis in (("front", 1), ("side", 0), ("top", 2)):
        shown.page.get_by_role("button", name=f"view: {view}").click()
        along = f"player.camera.frame().back[{axis}]"
        shown.page.wait_for_function(f"() => Math.abs(document.querySelector('.player').{along}) > 0.999")


def test_views_along_an_axis_are_to_scale(opened):
    """Equal lengths near and far are equal there, as the bar says; the first view is in perspective."""
    shown = opened("motion")
    lengths = """
        const { matrix } = player.camera.look(), { low, high } = player.camera, [width, height] = [
          player.view.clientWidth, player.view.clientHeight];
        const at = (...place) => {
          const [x, y, , w] = [0, 1, 2, 3].map((row) =>
            [...place, 1].reduce((sum, value, k) => sum + matrix[4 * k + row] * value, 0));
          return [x / w, y / w];
        };
        // Along x, at the near and at the far side of the box, pixels.
        return [low[1], high[1]].map((y) => {
          const [a, b] = [at(low[0], y, low[2]), at(high[0], y, low[2])];
          return 0.5 * Math.hypot(width * (b[0] - a[0]), height * (b[1] - a[1]));
        });"""
    near, far = shown.run(lengths)
    assert near > 1.05 * far
    shown.page.get_by_role("button", name="view: front").click()
    shown.page.wait_for_function("() => document.querySelector('.player').player.camera.isParallel")
    shown.page.wait_for_timeout(100)
    near, far = shown.run(lengths)
    assert near == pytest.approx(far, rel=1e-5)
    metre = shown.run("return player.view.clientHeight / (2 * player.camera.reach)")
    assert near == pytest.approx(
        shown.run("return player.camera.high[0] - player.camera.low[0]") * metre, rel=1e-5
    )
    # The whole box is seen.
    assert near < shown.run("return player.view.clientWidth")
    shown.page.get_by_role("button", name="view: fit").click()
    shown.page.wait_for_function("() => document.querySelector('.player').player.camera.isHome")
    near, far = shown.run(lengths)
    assert near > 1.05 * far


def test_obstacles_are_seen_through(opened):
    """A sphere stands around the tip: the tip is seen in it, in other colours than without it."""
    shown = opened("inside")
    picture = "player.draw(); return player.canvas.toDataURL()"

    def layers(*hidden):
        url = shown.run(f"player.stage.hidden = new Set({list(hidden)}); {picture}")
        content = base64.b64decode(url.partition(",")[2])
        return np.asarray(Image.open(io.BytesIO(content)).convert("RGB"), float)

    whole, alone, empty, around = layers(), layers("obstacles"), layers("obstacles", "rods"), layers("rods")
    is_rod = np.abs(alone - empty).max(axis=-1) > 40
    is_inside = is_rod & (np.abs(around - empty).max(axis=-1) > 20)
    assert is_inside.sum() > 100
    assert (is_rod & ~is_inside).sum() > 100
    # Half of it is the sphere, half is what is behind.
    behind = alone[is_inside] - empty[is_inside]
    seen = whole[is_inside] - around[is_inside]
    share = (seen * behind).sum() / (behind * behind).sum()
    assert 0.35 < share < 0.65


def test_visuals_move_with_their_links_in_their_colours(opened):
    shown = opened("visuals")

    def pixels(time, *hidden):
        hide = f"player.stage.hidden = new Set({list(hidden)})"
        url = shown.run(f"clock.seek({time}); {hide}; player.draw(); return player.canvas.toDataURL()")
        content = base64.b64decode(url.partition(",")[2])
        return np.asarray(Image.open(io.BytesIO(content)).convert("RGB"), float)

    def red(picture):
        return (picture[..., 0] > 100) & (picture[..., 0] > 2.5 * picture[..., 1:].max(axis=-1))

    first, last, without = pixels(0.0), pixels(0.2), pixels(0.0, "visuals")
    assert red(first).sum() > 1000
    assert not red(without).any()
    # It has swung down: the middle of the red is lower.
    height = [np.nonzero(red(picture))[0].mean() for picture in (first, last)]
    assert height[1] > height[0] + 50
    # The sheet tints what is behind it, on one side and on the other.
    tinted = (first[..., 1] - without[..., 1]) - (first[..., 0] - without[..., 0]) > 40
    assert tinted.sum() > 1000
    shown.page.get_by_role("button", name="view: front").click()
    shown.page.wait_for_timeout(100)
    assert red(pixels(0.0)).sum() > 1000


def test_two_fingers_zoom_and_one_finger_turns(opened):
    shown = opened("motion", 390, 844, touch=True)
    before, after = shown.run(
        """
        const [canvas] = player.canvases;
        canvas.setPointerCapture = () => {};
        const send = (type, id, x, y) => canvas.dispatchEvent(new PointerEvent(type, {
          pointerId: id, clientX: x, clientY: y, pointerType: 'touch', bubbles: true }));
        const before = player.camera.distance;
        send('pointerdown', 1, 100, 200);
        send('pointerdown', 2, 200, 200);
        send('pointermove', 2, 300, 200);
        send('pointerup', 1, 100, 200);
        send('pointerup', 2, 300, 200);
        return [before, player.camera.distance];
        """
    )
    np.testing.assert_allclose(after, before / 2, rtol=1e-6)
    assert shown.page.evaluate("document.documentElement.scrollWidth <= innerWidth"), "nothing sticks out"


#: What a phone shows: widths of page and screen, heights of what thumbs press, tables that are cut.
ON_A_PHONE = """() => ({
  page: document.documentElement.scrollWidth,
  screen: innerWidth,
  heights: [...document.querySelectorAll('.controls button, .controls select, .entry')]
    .filter((control) => control.offsetWidth).map((control) => control.getBoundingClientRect().height),
  cut: [...document.querySelectorAll('table')]
    .filter((table) => table.getBoundingClientRect().right > innerWidth)
    .filter((table) => getComputedStyle(table.parentElement).overflowX !== 'auto').length,
})"""

#: Least height of a control on a phone, pixels.
THUMB = 36


@pytest.mark.parametrize("name", ["motion", "statics", "modes", "path"])
def test_pages_fit_phones(name, opened):
    """Nothing scrolls from side to side but tables within themselves, and controls are large enough."""
    shown = opened(name, 375, 667, touch=True)
    shown.page.wait_for_function(READY)
    found = shown.page.evaluate(ON_A_PHONE)
    assert found["page"] == found["screen"] == 375
    assert found["cut"] == 0
    assert len(found["heights"]) > 5
    assert min(found["heights"]) >= THUMB


def test_colours_and_layers(opened):
    shown = opened("motion")
    picture = "player.draw(); return player.canvases[0].toDataURL()"
    shown.run("clock.seek(0.3)")
    plain = shown.run(picture)
    names = shown.page.locator("label", has_text="Colour").locator("option").all_inner_texts()
    assert names == [
        *("position along the rod", "segment", "curvature (1/m)", "axial stress (Pa)", "speed (m/s)"),
    ]
    seen = {plain}
    for name in names[1:]:
        shown.page.locator("label", has_text="Colour").locator("select").select_option(name)
        seen.add(shown.run(picture))
    assert len(seen) == len(names)
    entry = shown.page.locator(".player .entry", has_text="rod").first
    entry.click()
    assert entry.get_attribute("aria-pressed") == "false"
    assert shown.run(picture) not in seen


def test_statics_open_at_the_result(opened):
    shown = opened("statics")
    assert shown.run("return clock.time === clock.end && clock.end === 1")
    assert "load factor 1" in shown.page.locator(".now").inner_text()


def test_tubes_have_their_true_sections(opened):
    """Distances of corners from the axis, as computed by the browser."""
    shown = opened("motion")
    radii, hole, corner = shown.run(
        """
        clock.seek(0.37);
        player.draw();
        const [tube] = player.stage.tubes;
        const [at, part] = player.stage.find(0.37);
        const { vertices } = tube.skin;
        const { values } = tube.thing.centres;
        const size = 3 * tube.stations;
        const ring = (first, k) => [...Array(24).keys()].map((i) => {
          const p = [...vertices.slice(9 * (24 * first + i), 9 * (24 * first + i) + 3)];
          const c = [0, 1, 2].map((j) => values[at * size + 3 * k + j] * (1 - part)
            + values[(at + 1) * size + 3 * k + j] * part);
          return Math.hypot(p[0] - c[0], p[1] - c[1], p[2] - c[2]);
        });
        return [ring(5, 5), ring(tube.stations + 4 + 5, 5), ring(40, 40)];
        """
    )
    np.testing.assert_allclose(radii, 0.012, rtol=2e-3)
    np.testing.assert_allclose(hole, 0.008, rtol=2e-3)
    np.testing.assert_allclose(max(corner), np.hypot(0.01, 0.005), rtol=2e-3)
    assert min(corner) >= 0.005 * 0.998


def saved(shown, name, tmp_path):
    """Name and content of the file that a button saves."""
    with shown.page.expect_download(timeout=2 * PATIENCE) as waited:
        shown.page.get_by_role("button", name=name, exact=True).locator("visible=true").first.click()
    waited.value.save_as(tmp_path / "file")
    return waited.value.suggested_filename, (tmp_path / "file").read_bytes()


@pytest.mark.parametrize("kind", ["PNG", "GIF"])
def test_what_is_saved_is_what_is_shown(kind, opened, tmp_path):
    shown = opened("motion", 500, 700)
    # A tenth of the motion.
    shown.run("clock.end = 0.3; clock.seek(0.1)")
    name, content = saved(shown, f"save as {kind}", tmp_path)
    assert name == f"Whip.{kind.lower()}"
    picture = Image.open(io.BytesIO(content))
    assert picture.format == kind
    if kind == "GIF":
        assert picture.n_frames == 6
        frames = []
        for i in range(6):
            picture.seek(i)
            frames.append(np.asarray(picture.convert("RGB"), float))
        assert picture.info["duration"] == 50
        assert np.abs(frames[5] - frames[0]).max() > 50
        # The colours of a palette are similar to those of the view.
        ratio = shown.run("player.draw(clock.start); return player.canvases[0].toDataURL()")
        drawn = Image.open(io.BytesIO(base64.b64decode(ratio.partition(",")[2]))).convert("RGB")
        size = (frames[0].shape[1], frames[0].shape[0])
        apart = np.abs(np.asarray(drawn.resize(size), float)[60:] - frames[0][60:])
        assert np.median(apart) < 8.0
    else:
        colours = np.unique(np.asarray(picture.convert("RGB")).reshape(-1, 3), axis=0)
        assert len(colours) > 200


@pytest.mark.parametrize("size", ["as shown", "1920 × 1080", "3840 × 2160"])
def test_pictures_have_the_size_that_was_picked(size, opened, tmp_path):
    """Also after a motion that is drawn with fewer pixels, as on machines without a graphics card."""
    shown = opened("motion", 900, 700)
    laid = "return [player.view.clientWidth, player.view.clientHeight]"
    wanted = shown.run(laid) if size == "as shown" else [int(side) for side in size.split(" × ")]
    coarse = shown.run("player.ratio = 0.6; player.resize(); return player.canvases[0].width")
    shown.page.get_by_label("Size of files").select_option(size)
    picture = Image.open(io.BytesIO(saved(shown, "save as PNG", tmp_path)[1]))
    assert list(picture.size) == wanted
    assert coarse < wanted[0]
    assert shown.run("return player.canvases[0].width") == coarse, "the view is as before"
    # Letters have the same share of all fixed sizes.
    if size != "as shown":
        small = np.asarray(picture.convert("L").resize((1920, 1080)), float)
        label = small[20:50, 18:140] < 128
        assert 0.1 < label.mean() < 0.5


def test_transparent_pictures_have_no_background(opened, tmp_path):
    shown = opened("motion", 900, 700)
    solid, clear = (
        np.asarray(Image.open(io.BytesIO(saved(shown, f"save as {kind}", tmp_path)[1])).convert("RGBA"))
        for kind in ("PNG", "PNG, transparent")
    )
    assert (solid[..., 3] == 255).all()
    assert (clear[..., 3] == 0).mean() > 0.4
    is_solid = clear[..., 3] == 255
    assert is_solid.mean() > 0.02
    np.testing.assert_array_equal(clear[is_solid], solid[is_solid])
    # Before the background of the view it is the other picture, up to the rounding of eight bits.
    share = clear[..., 3:] / 255
    together = share * clear[..., :3] + (1 - share) * solid[60, 3, :3]
    assert np.quantile(np.abs(together - solid[..., :3]), 0.999) <= 3.0


def test_films_have_each_picture_at_its_time(opened, browser, tmp_path):
    """Thirty pictures a second of the size that was picked, however slowly they are drawn."""
    shown = opened("motion", 900, 700)
    shown.run("clock.end = 0.2; clock.seek(0.05)")
    shown.page.get_by_label("Size of files").select_option("1920 × 1080")
    name, content = saved(shown, "save as WebM", tmp_path)
    assert name == "Whip.webm"
    drawn = shown.run(
        """
        player.lay({ width: 960, height: 540, ratio: 1 });
        player.draw(0.1);
        return player.canvases[0].toDataURL();
        """
    )
    # A browser plays it and finds any time in it.
    page = browser.new_page()
    size, duration, frame = page.evaluate(
        """async (film) => {
          const video = document.createElement('video');
          const heard = (name) => new Promise((resolve) => {
            video.addEventListener(name, resolve, { once: true });
          });
          video.src = `data:video/webm;base64,${film}`;
          await heard('loadeddata');
          const moved = heard('seeked');
          video.currentTime = 0.101;
          await moved;
          const canvas = Object.assign(document.createElement('canvas'), { width: 960, height: 540 });
          canvas.getContext('2d').drawImage(video, 0, 0, 960, 540);
          return [[video.videoWidth, video.videoHeight], video.duration, canvas.toDataURL()];
        }""",
        base64.b64encode(content).decode(),
    )
    page.close()
    assert size == [1920, 1080]
    assert duration == pytest.approx(7 / 30, abs=1e-5)
    of_film, of_view = (
        np.asarray(Image.open(io.BytesIO(base64.b64decode(url.partition(",")[2]))).convert("RGB"), float)
        for url in (frame, drawn)
    )
    # Apart from what is written.
    assert np.abs(of_film - of_view)[60:480].mean() < 4.0
    other = np.abs(of_view - np.roll(of_view, 12, axis=0))[60:480].mean()
    assert np.abs(of_film - of_view)[60:480].mean() < 0.5 * other


def test_a_film_can_be_stopped(opened):
    shown = opened("motion", 900, 700)
    shown.page.get_by_label("Size of files").select_option("3840 × 2160")
    shown.page.get_by_role("button", name="save as WebM").click()
    shown.page.get_by_role("button", name="Stop").click()
    shown.page.wait_for_function(
        "() => document.querySelector('.status').textContent === 'WebM not made: it was stopped'"
    )
    assert shown.run("return [player.isSaving, player.laid.width === player.view.clientWidth]") == [
        False,
        True,
    ]


def test_plots_are_saved_as_vectors_pixels_and_numbers(opened, tmp_path):
    """In light colours on a dark page, with a legend, and without the curves that are hidden."""
    shown = opened("motion", 900, 700, "dark")
    shown.page.wait_for_function(READY)
    energy = shown.page.locator("section", has=shown.page.get_by_role("heading", name="Energy"))
    energy.get_by_role("button", name="elastic").click()
    files = {}
    for kind in ("SVG", "PNG", "CSV"):
        with shown.page.expect_download() as waited:
            energy.get_by_role("button", name=f"save the plots as {kind}").first.click()
        assert waited.value.suggested_filename == f"Whip-energy.{kind.lower()}"
        waited.value.save_as(tmp_path / kind)
        files[kind] = (tmp_path / kind).read_bytes()
    root = ElementTree.fromstring(files["SVG"])
    space = "{http://www.w3.org/2000/svg}"
    texts = [text.text for text in root.iter(f"{space}text")]
    assert {"energy (J)", "time (s)", "kinetic", "total"} <= set(texts)
    assert "elastic" not in texts
    assert root.find(f"{space}rect").get("fill") == "#ffffff"
    assert "#1c2330" in {text.get("fill") for text in root.iter(f"{space}text")}, "ink of light pages"
    width, height = float(root.get("width")), float(root.get("height"))
    picture = Image.open(io.BytesIO(files["PNG"])).convert("RGB")
    assert picture.size == (3 * width, 3 * height)
    assert picture.getpixel((1, 3 * height - 1)) == (255, 255, 255)
    assert len(picture.getcolors(1 << 24)) > 50

    rows = list(csv.reader(io.StringIO(files["CSV"].decode("utf-8"), newline="")))
    assert rows[0][:2] == ["time (s)", "energy (J): kinetic"]
    assert "energy (J): elastic" not in rows[0]
    values = np.array(rows[1:], float)
    motion = lissom.Scene.loads(ROD).run()
    at = np.searchsorted(motion.t, values[:, 0] - 1e-6)
    np.testing.assert_allclose(values[:, 0], motion.t[at], rtol=1e-6)
    kinetic, stored = motion.balance.kinetic[at], values[:, rows[0].index("energy (J): kinetic")]
    np.testing.assert_allclose(stored, kinetic, rtol=0, atol=1.1 * np.ptp(kinetic) / 65_533)
    assert stored[0] == kinetic[0] == 0.0


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", ["motion", "statics", "modes"])
def test_nothing_serious_for_those_who_cannot_see_well(name, scheme, opened):
    shown = opened(name, scheme=scheme)
    shown.page.wait_for_function(READY)
    found = Axe().run(shown.page).response["violations"]
    serious = [
        (each["id"], [node["target"] for node in each["nodes"]])
        for each in found
        if each["impact"] in ("serious", "critical")
    ]
    assert serious == []


SHOTS = {
    "motion-light": ("motion", 900, 700, "light", 0.4),
    "motion-dark": ("motion", 900, 700, "dark", 1.1),
    "motion-phone": ("motion", 390, 700, "light", 0.4),
    "statics-light": ("statics", 900, 700, "light", 1.0),
    "modes-light": ("modes", 900, 700, "light", 0.0),
}


@pytest.mark.parametrize("name", SHOTS)
def test_views_look_as_they_did(name, opened, request):
    report, width, height, scheme, time = SHOTS[name]
    shown = opened(report, width, height, scheme, touch=width < 500)
    shown.run(f"clock.seek({time} * clock.end); player.draw()")
    view = shown.page.locator(".view").first
    view.scroll_into_view_if_needed()
    picture = Image.open(io.BytesIO(view.screenshot())).convert("RGB")
    path = PICTURES / f"{name}.png"
    if request.config.getoption("--new-pictures"):
        path.parent.mkdir(exist_ok=True)
        picture.quantize(256).save(path, optimize=True)
    wanted = Image.open(path).convert("RGB")
    assert picture.size == wanted.size
    apart = np.abs(squares(picture) - squares(wanted))
    assert apart.max() < APART
    assert apart.mean() < MEAN_APART


def squares(picture):
    """Mean colours of squares, 0 to 1."""
    small = (picture.width // SQUARE, picture.height // SQUARE)
    return np.asarray(picture.resize(small, Image.Resampling.BOX), float) / 255
