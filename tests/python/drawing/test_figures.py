"""Figures for papers: what they show, where, and how large."""

import dataclasses
import re

import numpy as np
import pytest

import lissom
from lissom.drawing import figures, painting
from lissom.drawing.parts import Part, parts
from lissom.drawing.report import contacts
from lissom.model import views

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


def test_obstacles_dim_what_is_behind_them(tmp_path):
    """A ball before and behind a rod, seen from the front."""
    # The ball is a little blue as well.
    dim = 1.0 - contacts.OPACITY
    for y, low, high in ((-0.1, dim, 1.25 * dim), (0.1, 0.95, 1.05)):
        ball = lissom.Contact("arm", lissom.Sphere((0.15, y, 0), 0.05), stiffness=1e4)
        robot = lissom.Robot([lissom.Link("arm", rod=[SEGMENT])], gravity=(0, 0, 0), contacts=[ball])
        lissom.simulate(robot, 0.02).picture(tmp_path / "x.png", times=[0.0], view="front")
        (rows, columns), pixels = drawn(tmp_path / "x.png")
        colour = np.ptp(pixels, axis=-1)[rows.min() : rows.max() + 1]
        middle, end = ((columns.min() + columns.max()) // 2, columns.min() + 20)
        assert low < colour[:, middle].max() / colour[:, end].max() < high


def test_faces_of_obstacles_are_even(tmp_path):
    """The cut faces of a box have no seams: in a figure of pixels each is of one colour."""
    box = lissom.Contact("arm", lissom.Box((0.15, 0, -0.2), (0.1, 0.1, 0.1)), stiffness=1e4)
    robot = lissom.Robot([lissom.Link("arm", rod=[SEGMENT])], gravity=(0, 0, 0), contacts=[box])
    lissom.simulate(robot, 0.02).picture(tmp_path / "x.png", times=[0.0], view=(1, -2, 1))
    _, pixels = drawn(tmp_path / "x.png")
    colours, counts = np.unique(pixels.reshape(-1, 3), axis=0, return_counts=True)
    is_grey = (np.ptp(colours, axis=1) < COLOURED) & (colours.min(axis=1) > 100) & (colours.max(axis=1) < 250)
    faces = np.sort(counts[is_grey])[-3:].sum()
    # The rest are edges of faces and of letters.
    assert faces > 0.9 * counts[is_grey].sum()


@pytest.mark.parametrize("turn", [0.0, 9.0])
def test_tendons_are_painted_before_the_walls_over_them(turn):
    """Inside a bent rod, too, where triangles of walls and tendons have about the same depth."""
    segment = dataclasses.replace(SEGMENT, modes={"bend_y": 1})
    pull = lissom.Tendon("pull", [lissom.Along("arm", (-0.007, 0.0))], tension=0.5)
    robot = lissom.Robot([lissom.Link("arm", rod=[segment])], actuators=[pull])
    found, _ = parts(
        views.view(robot), np.full((1, 1), turn), np.zeros((1, 1)), np.zeros((1, 0)), np.zeros(1), True
    )
    painted = painting.triangles(found, painting.view_axes(np.array([1.0, -0.5, 0.3]), np.array([0.0, 0, 1])))
    place = np.arange(len(painted.corners))
    middle = painted.corners.mean(axis=1)
    tendon, wall = (np.flatnonzero(painted.is_inside == inside) for inside in (True, False))
    assert len(tendon) > 100
    point, over, depth = painting._over(middle[tendon], painted.corners[wall], 0.05)
    # Walls over a place of the tendon, not those of another part of the bent rod.
    near = np.abs(depth - middle[tendon[point], 2]) < 0.02
    assert near.sum() > 100
    assert (place[tendon[point[near]]] < place[wall[over[near]]]).all()


def test_tendons_follow_bent_rods():
    """The chords of a tendon in a ring of 0.1 m leave its circle by less than 0.2 % of the radius."""
    segment = dataclasses.replace(SEGMENT, modes={"bend_y": 1})
    pull = lissom.Tendon("pull", [lissom.Along("arm", (0.0, 0.0))], tension=0.5)
    robot = lissom.Robot([lissom.Link("arm", rod=[segment])], actuators=[pull])
    state = (np.full((1, 1), 20.0), np.zeros((1, 1)), np.zeros((1, 0)), np.zeros(1))
    found, _ = parts(views.view(robot), *state, True)
    strand = next(part for part in found if part.layer == "tendons")
    points = strand.centres[0]
    middle = 0.5 * (points[1:] + points[:-1])
    centre = robot.pose(state[0][0], 0.0)[:3, 3] - np.array([0.0, 0.0, 0.05])
    assert np.linalg.norm(middle - centre, axis=1) == pytest.approx(0.05, rel=2e-3)


def test_later_shapes_are_painted_over_earlier_ones():
    """Two plates that cross: the later one is whole, though half of it lies behind the earlier one."""
    plate = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    angle = 0.3
    turns = np.array([[1, 0, 0, 0], [np.cos(angle / 2), 0, np.sin(angle / 2), 0]])[:, None]
    corners = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    part = Part("plate", "rods", plate, np.zeros(4, int), corners, np.zeros((2, 1, 3)), turns)
    drawn = painting.triangles([part], np.eye(3))
    lightness = drawn.colours[:, :3].sum(axis=1)
    is_first = lightness > lightness.mean()
    assert is_first.sum() > 100
    assert (~is_first).sum() > 100
    assert np.flatnonzero(is_first).max() < np.flatnonzero(~is_first).min()
    # Both are whole, and sorted within themselves.
    for which in (is_first, ~is_first):
        a, b, c = np.moveaxis(drawn.corners[which], 1, 0)
        area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
        assert area == pytest.approx(4.0)
        depth = drawn.corners[which, :, 2].mean(axis=1)
        assert (np.diff(depth) >= 0.0).all()


def test_obstacles_dim_all_shapes_behind_them(tmp_path):
    """A ball before a rod that falls, or behind it: of three shapes only the ends have their full colour."""
    ball = lissom.Contact("arm", lissom.Sphere((0.15, -0.3, -0.05), 0.15), stiffness=1e4)
    robot = lissom.Robot([lissom.Link("arm", rod=[SEGMENT])], contacts=[ball])
    result = lissom.simulate(robot, 0.2, dt=2e-3)
    result.picture(tmp_path / "x.png", times=[0.0, 0.1, 0.2], view="back")
    _, whole = drawn(tmp_path / "x.png")
    result.picture(tmp_path / "x.png", times=[0.0, 0.1, 0.2], view="front")
    _, dimmed = drawn(tmp_path / "x.png")
    full = 0.75 * np.ptp(whole, axis=-1).max()
    counts = [(np.ptp(pixels, axis=-1) > full).sum() for pixels in (whole, dimmed)]
    assert counts[1] < 0.2 * counts[0]


@pytest.mark.parametrize(
    ("heights", "order"),
    [
        # Heights of a plate in two shapes beside an obstacle at zero: what is painted, from first to last.
        ((0.5, 0.5), "obstacle first second"),
        ((-0.5, -0.5), "first second obstacle"),
        ((-0.5, 0.5), "first obstacle second"),
        # What is before an obstacle is not painted over, although the second shape lies behind it.
        ((0.5, -0.5), "obstacle first second"),
        # In contact.
        ((0.5, -1e-3), "obstacle first second"),
    ],
)
def test_obstacles_are_painted_between_shapes(heights, order):
    corners, bone = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), np.zeros(4, int)
    two, still = np.array([[0, 1, 2], [0, 2, 3]], np.uint32), np.zeros((2, 1, 3))
    turns = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (2, 1, 4))
    moved = still + np.array([0.0, 0.0, 1.0]) * np.array(heights)[:, None, None]
    plates = [
        Part("wall", "obstacles", corners, bone, two, still, turns),
        Part("plate", "rods", corners, bone, two, moved, turns),
    ]
    drawn = painting.triangles(plates, np.eye(3))
    names = {0: "obstacle", 1: "first", 2: "second"}
    saturation = np.ptp(drawn.colours[:, :3], axis=1)
    which = np.where(saturation < 0.15, 0, np.where(saturation < 0.4, 1, 2))
    found = [names[which[i]] for i in np.flatnonzero(np.diff(which, prepend=-1))]
    assert " ".join(found) == order


@pytest.mark.parametrize("aside", [0.0, 2.4e-3, -2.4e-3])
def test_a_catheter_in_a_tube_is_dimmed_along_its_whole_length(aside):
    """The near wall is painted after the rod, the far one before it, also where it presses into one."""
    segment = lissom.Segment(0.2, 1e-3, 5e7, poisson_ratio=0.4, density=1500.0, modes={"bend_y": 1})
    vessel = lissom.Tube([(-0.05, aside, 0), (0.1, aside, 0), (0.25, aside, 0)], radius=3e-3, wall=2e-3)
    rod = lissom.Rod([segment], contacts=[lissom.Contact("rod", vessel)], gravity=(0, 0, 0))
    state = (np.zeros((1, 1)), np.zeros((1, 1)), np.zeros((1, 0)), np.zeros(1))
    found, _ = parts(views.view(rod), *state, True)
    front = painting.view_axes(np.array([0.0, -1.0, 0.0]), np.array([0.0, 0, 1]))
    painted = painting.triangles(found, front)
    is_wall = painted.colours[:, 3] < 1.0
    place, middle = np.arange(len(is_wall)), painted.corners.mean(axis=1)
    catheter, wall = np.flatnonzero(~is_wall), np.flatnonzero(is_wall)
    point, over, depth = painting._over(middle[catheter], painted.corners[wall], 0.05)
    assert len(point) > 100
    # The axis of the tube, seen from -y.
    is_near = depth > -aside
    assert is_near.any()
    assert (~is_near).any()
    assert (place[catheter[point[is_near]]] < place[wall[over[is_near]]]).all()
    assert (place[catheter[point[~is_near]]] > place[wall[over[~is_near]]]).all()


def test_over_finds_what_lies_over_what():
    """Against every point and triangle by themselves."""
    chosen = np.random.default_rng(3)
    side = 0.6
    corners = chosen.random((300, 1, 3)) + 0.5 * side * chosen.random((300, 3, 3))
    points = chosen.random((200, 3))
    found = {pair[:2]: pair[2] for pair in zip(*painting._over(points, corners, side), strict=True)}
    count = 0
    for i, point in enumerate(points):
        for j, (a, b, c) in enumerate(corners):
            s, t = np.linalg.solve(np.stack([b - a, c - a], axis=1)[:2], (point - a)[:2])
            if min(s, t) >= 0.0 and s + t <= 1.0:
                count += 1
                assert found[i, j] == pytest.approx(a[2] + s * (b - a)[2] + t * (c - a)[2])
    assert len(found) == count > 100


def test_an_equilibrium(robot, tmp_path):
    rest = lissom.statics(robot)
    rest.picture(tmp_path / "x.png", robot, view="front", width=0.1)
    _, pixels = drawn(tmp_path / "x.png")
    assert pixels.shape[1] == pytest.approx(0.1 / INCH * figures.RESOLUTION, abs=1)
    lissom.statics(robot).picture(tmp_path / "x.svg", robot)
    assert "t = " not in (tmp_path / "x.svg").read_text()
    with pytest.raises(ValueError, match=r"model: it has 1 coordinates, the result has 4"):
        rest.picture(tmp_path / "y.png", lissom.Rod([lissom.Segment(1.0, 0.1, 1e6, 1e6, 1e3, {"bend_y": 1})]))
    with pytest.raises(ValueError, match="figures show rods and bodies"):
        lissom.statics(lissom.SpringPendulum()).picture(tmp_path / "y.png", lissom.SpringPendulum())
    assert not (tmp_path / "y.png").exists()


def test_magnets_are_arrows_along_their_moments(tmp_path):
    segment = dataclasses.replace(SEGMENT, magnetisation=(0.0, 0.0, 5e3))
    robot = lissom.Robot(
        [lissom.Link("arm", rod=[segment])],
        magnets=[
            lissom.Magnet((0.2, 0.0, 0.0), link="arm"),
            lissom.Magnet((0.1, 0.0, 0.0), link="arm", at=0.1),
        ],
        gravity=(0, 0, 0),
    )
    q = np.array([[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]])
    found, _ = parts(views.view(robot), q, 0.0 * q, np.zeros((2, 0)), np.zeros(2))
    arrows = [part for part in found if part.layer == "magnets"]
    assert len(arrows) == 3
    for part, place in zip(arrows[:2], (0.3, 0.1), strict=True):
        for k in range(2):
            pose = robot.pose(q[k], place, link="arm")
            points = (part.vertices(k) - pose[:3, 3]) @ pose[:3, :3]
            assert points[:, 0].max() == pytest.approx(-points[:, 0].min())
            # The head, 0.6 of the arrow, is at the north pole.
            widest = np.argmax(np.hypot(points[:, 1], points[:, 2]))
            assert points[widest, 0] == pytest.approx(-0.1 * np.ptp(points[:, 0]))
    lengths = [np.ptp(part.vertices(0)[:, 0]) for part in arrows[:2]]
    assert lengths[0] == pytest.approx(2.0 * lengths[1])
    assert len(np.unique(arrows[2].bone)) == 3
    rod = next(part for part in found if part.layer == "rods")
    assert rod.opacity < 1.0


@pytest.mark.parametrize("width", [0.04, 0.05, 0.064, 0.085, 0.3])
def test_words_do_not_run_into_the_bar(width, tmp_path, straight):
    """Nor out of the figure."""
    straight.picture(tmp_path / "x.png", times=[0.0, 0.005, 0.01, 0.015, 0.02], view="front", width=width)
    _, pixels = drawn(tmp_path / "x.png")
    is_black = pixels.max(axis=-1) < 100
    columns = np.nonzero(is_black)[1]
    assert columns.max() < 0.97 * pixels.shape[1]
    length = bar(pixels)
    row = next(
        i for i in range(len(is_black)) if "x" * length in "".join(" x"[b] for b in is_black[i].astype(int))
    )
    beside = is_black[row - 4 : row + 4]
    start = "".join(" x"[b] for b in is_black[row].astype(int)).index("x" * length)
    assert not beside[:, max(start - 10, 0) : start - 1].any()


def test_films_show_sections(straight, tmp_path):
    straight.animate(tmp_path / "x.gif", fps=50)
    with Image.open(tmp_path / "x.gif") as film:
        pixels = np.asarray(film.convert("RGB")).astype(int)
    columns = np.nonzero(np.ptp(pixels, axis=-1) > COLOURED)[1]
    # Seen obliquely, but by far not a line of one or two pixels.
    assert np.ptp(columns) > 0.8 * pixels.shape[1]
    assert np.median(np.bincount(columns)[np.unique(columns)]) > 0.05 * np.ptp(columns)


def test_later_shapes_are_darker(motion, tmp_path):
    motion.picture(tmp_path / "x.svg", times=[0.0, 0.2], view="front")
    text = (tmp_path / "x.svg").read_text()
    assert "t = 0, 0.2 s" in text
    found = figures._shapes(motion, figures.views.view(motion.model), np.array([0.0, 0.2]))[0]
    triangles = painting.triangles(found, np.eye(3))
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
        ({"width": 0.0}, ValueError, r"width: 0 m is not between 0.04 and 2 m"),
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


@pytest.mark.parametrize(("curvature", "factor"), [(0.0, 1), (30.0, 4), (60.0, 8)])
def test_strongly_bent_rods_have_more_sections(curvature, factor):
    """A circle of 30 rad/m over 0.3 m turns by 9 rad: 0.375 rad between 24 sections, 0.094 between 96."""
    segment = lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, {"bend_y": 1}, nodes=200)
    model = lissom.Rod([segment])
    q = np.array([[curvature]])
    found, _ = parts(views.view(model), q, 0 * q, np.zeros((1, 0)), np.zeros(1), is_smooth=True)
    (rod,) = found
    assert rod.centres.shape[1] == 24 * factor + 1
    if factor == 4:
        # Chords of a circle: each is short by the square of half its angle over six.
        angle = curvature * 0.3 / 96
        length = np.linalg.norm(np.diff(rod.centres[0], axis=0), axis=1).sum()
        assert length == pytest.approx(0.3 * np.sin(angle / 2) / (angle / 2), rel=1e-9)
