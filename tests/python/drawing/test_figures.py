"""Figures for papers: what they show, where, and how large."""

import re

import numpy as np
import pytest

import lissom
from lissom.drawing import figures

pytest.importorskip("matplotlib")
from PIL import Image

SEGMENT = lissom.Segment(0.3, 0.01, 1e6, poisson_ratio=0.4, density=1000.0, modes={"bend_y": 3, "bend_z": 1})
INCH = 0.0254

#: Differences of red, green and blue in the colour of rods, not in that of obstacles.
COLOURED = 50


@pytest.fixture(scope="module")
def robot():
    hand = lissom.Link("hand", parent="arm", body=lissom.Body(0.01, inertia=np.diag([1e-6, 2e-6, 2e-6])))
    return lissom.Robot(
        [lissom.Link("arm", rod=[SEGMENT]), hand],
        actuators=[lissom.Tendon("pull", [lissom.Along("arm", (0.0, 0.006))], tension=0.5)],
        contacts=[
            lissom.Contact("arm", lissom.Sphere((0.2, 0.2, -0.2), 0.05), stiffness=1e4, name="ball"),
            lissom.Contact("arm", lissom.HalfSpace((0, 0, -0.5), (0, 0, 1)), stiffness=1e4, name="floor"),
        ],
    )


@pytest.fixture(scope="module")
def motion(robot):
    return lissom.simulate(robot, 0.2, dt=2e-3)


@pytest.fixture(scope="module")
def straight():
    """A rod that stays as it is: 0.3 m along x, 0.02 m thick."""
    return lissom.simulate(lissom.Rod([SEGMENT], gravity=(0, 0, 0)), 0.02)


def drawn(path):
    """Rows and columns of the pixels of rods, and the picture."""
    pixels = np.asarray(Image.open(path).convert("RGB")).astype(int)
    return np.nonzero(np.ptp(pixels, axis=-1) > COLOURED), pixels


def bar(pixels):
    """Length of the scale bar in pixels: the longest row of black."""
    is_black = pixels.max(axis=-1) < 60
    rows = ["".join("x" if black else " " for black in row) for row in is_black]
    return max(len(run) for row in rows for run in row.split())


@pytest.mark.parametrize(("view", "high"), [("front", 0.02), ("top", 0.02), ((0, -1, 1), 0.02)])
def test_the_bar_measures_the_rod(view, high, straight, tmp_path):
    straight.picture(tmp_path / "x.png", times=[0.01], view=view)
    (rows, columns), pixels = drawn(tmp_path / "x.png")
    assert pixels.shape[1] == pytest.approx(0.085 / INCH * figures.RESOLUTION, abs=1)
    scale = 0.05 / bar(pixels)
    assert np.ptp(columns) * scale == pytest.approx(0.3, rel=0.02)
    assert np.ptp(rows) * scale == pytest.approx(high, rel=0.1)


def test_from_the_end_rods_are_their_sections(tmp_path):
    section = lissom.Section.rectangle(0.03, 0.01)
    segment = lissom.Segment(
        0.3, young_modulus=1e6, poisson_ratio=0.4, density=1e3, section=section, modes={"bend_y": 1}
    )
    result = lissom.simulate(lissom.Rod([segment], gravity=(0, 0, 0)), 0.02)
    result.picture(tmp_path / "x.png", times=[0.0], view="right", width=0.1)
    (rows, columns), pixels = drawn(tmp_path / "x.png")
    width, height = section.half_extents()
    assert np.ptp(columns) / np.ptp(rows) == pytest.approx(width / height, rel=0.03)
    scale = 0.005 / bar(pixels)
    assert np.ptp(columns) * scale == pytest.approx(0.03, rel=0.03)


def test_what_is_nearer_hides_what_is_behind(tmp_path):
    """A ball before and behind a rod, seen from the front."""
    for y, is_hidden in ((-0.1, True), (0.1, False)):
        ball = lissom.Contact("arm", lissom.Sphere((0.15, y, 0), 0.05), stiffness=1e4)
        robot = lissom.Robot([lissom.Link("arm", rod=[SEGMENT])], gravity=(0, 0, 0), contacts=[ball])
        lissom.simulate(robot, 0.02).picture(tmp_path / "x.png", times=[0.0], view="front")
        (_, columns), _ = drawn(tmp_path / "x.png")
        is_blue = np.zeros(columns.max() + 1, bool)
        is_blue[columns] = True
        middle = (columns.min() + columns.max()) // 2
        assert is_blue[middle] != is_hidden


def test_later_shapes_are_darker(motion, tmp_path):
    motion.picture(tmp_path / "x.svg", times=[0.0, 0.2], view="front")
    text = (tmp_path / "x.svg").read_text()
    assert "t = 0, 0.2 s" in text
    found = figures._shapes(motion, figures.views.view(motion.model), np.array([0.0, 0.2]))[0]
    triangles = figures.triangles(found, np.eye(3))
    assert len(re.findall(r"<path d=", text)) > 1000
    rods = triangles.colours[triangles.colours[:, 3] < 1.0, :3]
    assert rods.min() < 0.2
    assert rods.max() > 0.9


def test_all_formats_are_written_again_alike(motion, tmp_path):
    for suffix in figures.SUFFIXES:
        for name in ("a", "b"):
            motion.picture(tmp_path / f"{name}{suffix}", times=[0.1])
        first, second = ((tmp_path / f"{name}{suffix}").read_bytes() for name in "ab")
        assert first == second
        assert first.startswith({".pdf": b"%PDF", ".svg": b"<?xml", ".png": b"\x89PNG"}[suffix])


def test_lengths_of_bars_are_round():
    assert [figures.round_length(most) for most in (0.099, 0.1, 0.0499, 3.0)] == pytest.approx(
        [0.05, 0.1, 0.02, 2.0]
    )
    words = [figures.length_in_words(length) for length in (2.0, 0.1, 0.05, 0.005, 2e-4, 5e-6)]
    assert words == ["2 m", "10 cm", "5 cm", "5 mm", "200 µm", "5 µm"]


def test_many_times_are_told_briefly():
    assert figures.times_in_words(np.array([0.0, 0.25])) == "t = 0, 0.25 s"
    assert figures.times_in_words(np.linspace(0, 1, 9)) == "t = 0 to 1 s, 9 shapes"


@pytest.mark.parametrize(
    ("options", "kind", "message"),
    [
        ({"times": []}, ValueError, "times: there is none"),
        ({"times": [0.1, 0.3]}, ValueError, r"times\[1\]: 0.3 s is not within the motion, from 0 to 0.2 s"),
        ({"times": ["now"]}, TypeError, r"times\[0\]"),
        ({"view": "side"}, ValueError, "view: got 'side', expected a direction or one of front, back"),
        ({"view": (0, 0, 0)}, ValueError, "view: expected three finite numbers"),
        ({"view": (1, 0)}, ValueError, "view: expected three finite numbers"),
        ({"width": 0.0}, ValueError, r"width: 0 m is not between 0.01 and 2 m"),
        ({"width": "wide"}, TypeError, "width"),
    ],
)
def test_invalid_options(options, kind, message, motion, tmp_path):
    with pytest.raises(kind, match=message):
        motion.picture(tmp_path / "x.pdf", **options)
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_drawn(motion, tmp_path):
    with pytest.raises(ValueError, match=r"has to end with one of \.pdf, \.svg, \.png"):
        motion.picture(tmp_path / "x.eps")
    with pytest.raises(ValueError, match="figures show rods and bodies"):
        lissom.simulate(lissom.SpringPendulum(), 0.1).picture(tmp_path / "x.pdf")
    oscillator = lissom.newmark(lambda t, q, v, a: a + q, (0, 1), [1.0], [0.0], dt=0.1)
    with pytest.raises(ValueError, match="its model is not known"):
        oscillator.picture(tmp_path / "x.pdf")
