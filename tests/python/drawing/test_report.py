"""The report of a run."""

import base64
import hashlib
import io
import json
import re
import zlib
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray

import lissom
from lissom.drawing import report
from lissom.drawing.report import curves, layers, motion, packing, plots, theme
from lissom.drawing.report import page as pages
from lissom.drawing.report.numerals import typeset
from lissom.results.files import trajectory
from lissom.results.netcdf import written
from lissom.results.runs import Run, instants

SCENES = Path(__file__).parents[3] / "scenes"

TENTACLE = """version = 1
[scene]
name = "<script>alert('name')</script> & co"
[[rod]]
tip_force = [0, 0.01, 0]
tip_moment = [0, 0, 1e-3]
[[rod.segment]]
length = 0.2
radius = [0.012, 0.008]
young_modulus = 3e5
poisson_ratio = 0.5
density = 1070
retardation_time = 0.01
modes = { torsion = 1, bend_y = 2, bend_z = 2 }
[[rod.segment]]
length = 0.1
radius = [0.008, 0.004]
young_modulus = 3e5
poisson_ratio = 0.5
density = 1070
modes = { bend_y = 1, stretch = 1 }
[simulation]
t_end = 0.5
dt = 2e-3
"""


def run(text):
    scene = lissom.Scene.loads(text)
    return Run(scene, scene.run())


@pytest.fixture(scope="module")
def tentacle():
    return run(TENTACLE)


class Tags(HTMLParser):
    """The tags of a page, and the JSON of its figures."""

    def __init__(self):
        super().__init__()
        self.tags = []
        self.figures = []
        self._inside_json = False

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self._inside_json = tag == "script" and dict(attrs).get("type") == "application/json"

    def handle_endtag(self, tag):
        self._inside_json = False

    def handle_data(self, data):
        if self._inside_json:
            self.figures.append(json.loads(data))


def unpack(packed):
    """Unpacks the result of `packing.pack` as the player does, independent of the packing code."""
    content = zlib.decompress(base64.b64decode(packed["data"]))

    def read(value):
        if isinstance(value, list):
            return [read(inner) for inner in value]
        if not isinstance(value, dict):
            return value
        if "array" not in value:
            return {key: read(inner) for key, inner in value.items()}
        first, kind, shape, low, step = value["array"]
        count = int(np.prod(shape))
        if kind == "f4":
            return np.frombuffer(content, "<f4", count, first).reshape(shape).astype(float)
        width = int(kind[1])
        planes = [np.frombuffer(content, np.uint8, count, first + i * count) for i in range(width)]
        changes = sum(plane.astype(np.int64) << (8 * i) for i, plane in enumerate(planes)).reshape(shape)
        largest = 2 ** (8 * width) - 1
        numbers = np.cumsum(changes, axis=0) & largest
        return np.where(
            numbers == largest, np.nan, np.array(low) + np.minimum(numbers, largest - 1) * np.array(step)
        )

    return read(packed["document"])


def matrices(turns):
    """Rotation matrices of quaternions."""
    w, x, y, z = np.moveaxis(turns / np.linalg.norm(turns, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


@pytest.fixture(scope="module")
def page(tentacle, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "report.html"
    report.write(tentacle, path)
    tags = Tags()
    tags.feed(path.read_text(encoding="utf-8"))
    return tags


def test_the_page_loads_nothing_from_anywhere(page):
    for tag, attributes in page.tags:
        assert not {"src", "srcset", "action", "background"} & attributes.keys(), (tag, attributes)
        assert tag not in {"link", "iframe", "object", "embed", "img"}
        assert attributes.get("href", "#").startswith("#")
    policies = [attributes["content"] for tag, attributes in page.tags if "http-equiv" in attributes]
    assert len(policies) == 1
    assert policies[0].startswith("default-src 'none'")
    assert "http" not in policies[0]
    assert not re.search(r"script-src[^;]*(unsafe|data:)", policies[0])
    assert "base-uri 'none'" in policies[0]
    assert "form-action 'none'" in policies[0]


def test_the_policy_lets_only_the_player_run(tentacle):
    text = pages.render(report.build(tentacle))
    scripts = re.findall(r"<script(?! type=.application/json)[^>]*>(.*?)</script>", text, re.DOTALL)
    allowed = re.findall(r"script-src ([^;]*);", text)
    digests = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts]
    assert allowed == [f"'sha256-{digest}'" for digest in digests]


def test_every_figure_has_its_data(page):
    holders = [attributes for _, attributes in page.tags if attributes.get("class") in ("figure", "player")]
    sources = [
        attributes["id"] for tag, attributes in page.tags if attributes.get("type") == "application/json"
    ]
    assert [holder["data-source"] for holder in holders] == sources
    assert [holder["class"] for holder in holders] == ["player", *["figure"] * 4]
    assert len(page.figures) == len(sources) == 5


def test_names_cannot_inject_markup(tentacle, page):
    scripts = [attributes for tag, attributes in page.tags if tag == "script"]
    assert len(scripts) == len(page.figures) + 1, "the figures, the player"
    titles = [tag for tag, _ in page.tags if tag == "title"]
    assert len(titles) == 1


def test_the_page_is_small_and_has_all_of_the_player(tentacle):
    text = pages.render(report.build(tentacle))
    assert len(text) < 1_000_000
    (script,) = re.findall(r'<script type="module">(.*?)</script>', text, re.DOTALL)
    assert len(script) < 200_000
    # The name of the elements of SVG looks like an address, but nobody asks there.
    script = script.replace("http://www.w3.org/2000/svg", "")
    assert not re.search(r"https?:|eval\(|innerHTML|^\s*(import|export)\b", script, re.MULTILINE)
    player = Path(report.__file__).parent / "player"
    for file in player.glob("*.js"):
        # Every module comes before those that use it.
        used = re.findall(r'from "lissom/(\w+)\.js"', file.read_text(encoding="utf-8"))
        at = script.index(f"const {file.stem}Module =")
        assert all(script.index(f"const {name}Module =") < at for name in used), file.name


def test_the_animation_shows_the_rod_as_it_moves(tentacle, page):
    reported = unpack(page.figures[0])
    kinds = [thing["kind"] for thing in reported["things"]]
    assert set(kinds) == {"tube", "solid", "strand", "arrows", "dots", "line"}
    tube = reported["things"][kinds.index("tube")]
    # At the saved times of the run, at most sixty per second.
    times = reported["times"]
    assert len(times) == 61
    assert (times[0], times[-1]) == (0.0, 0.5)
    model = tentacle.scene.model
    at = np.searchsorted(tentacle.t, times - 1e-6)
    wanted = model.pose(tentacle.q[at], tube["stations"].ravel().clip(0.0, model.length))
    np.testing.assert_allclose(tube["centres"], wanted[..., :3, 3], atol=1e-5)
    np.testing.assert_allclose(matrices(tube["turns"]), wanted[..., :3, :3], atol=2e-4)
    np.testing.assert_allclose(tube["half"][[0, -1]], [[0.012, 0.012], [0.004, 0.004]], atol=1e-6)
    assert tube["segment"] == [0] * 25 + [1] * 24


def test_rods_are_coloured_by_what_they_do(tentacle, page):
    reported = unpack(page.figures[0])
    tube = next(thing for thing in reported["things"] if thing["kind"] == "tube")
    model = tentacle.scene.model
    at = np.searchsorted(tentacle.t, reported["times"] - 1e-6)
    stations = tube["stations"].ravel().clip(0.0, model.length)
    found = tube["quantities"]
    assert list(found) == ["curvature (1/m)", "axial stress (Pa)", "speed (m/s)"]
    strain = model.strain(tentacle.q[at], stations)
    curvature = np.linalg.norm(strain[..., 1:3], axis=-1)
    np.testing.assert_allclose(found["curvature (1/m)"], curvature, atol=curvature.max() / 250)
    # The outermost fibre: E times the sum of stretch and bending times radius.
    radius = np.array([0.5 * sum(tube["half"][k]) for k in range(len(stations))])
    stress = 3e5 * (np.abs(strain[..., 3] - 1.0) + curvature * radius)
    np.testing.assert_allclose(found["axial stress (Pa)"], stress, atol=stress.max() / 200)
    speed = [model.velocity(tentacle.q[at], tentacle.v[at])[:, 3:]]
    np.testing.assert_allclose(
        found["speed (m/s)"][:, -1], np.linalg.norm(speed[0], axis=1), atol=found["speed (m/s)"].max() / 250
    )


def test_sections_are_drawn_as_they_are():
    text = """version = 1
[[rod]]
[[rod.segment]]
length = 0.2
section = { shape = "hollow_circle", outer = [0.02, 0.01], inner = [0.01, 0.005] }
young_modulus = 3e5
poisson_ratio = 0.5
density = 1070
modes = { bend_y = 1 }
[[rod.segment]]
length = 0.1
section = { shape = "rectangle", width = 0.03, height = 0.01 }
young_modulus = 3e5
poisson_ratio = 0.5
density = 1070
modes = { bend_y = 1 }
[[rod.segment]]
length = 0.1
section = { shape = "ellipse", semi_axis_y = 0.01, semi_axis_z = 0.02 }
young_modulus = 3e5
poisson_ratio = 0.5
density = 1070
modes = { bend_y = 1 }
[simulation]
t_end = 0.02
"""
    (tube,) = motion.scene_of(run(text)).of(layers.Tube)
    np.testing.assert_allclose(tube.half[[0, 24]], [[0.02, 0.02], [0.01, 0.01]], rtol=1e-12)
    np.testing.assert_allclose(tube.hole[:25], 0.5, rtol=1e-6)
    assert not tube.hole[25:].any()
    assert list(tube.square) == [False] * 25 + [True] * 24 + [False] * 24
    np.testing.assert_allclose(tube.half[30], [0.015, 0.005])
    np.testing.assert_allclose(tube.half[60], [0.01, 0.02])


def test_what_is_packed_comes_back_as_exact_as_is_said():
    rng = np.random.default_rng(0)
    walk = np.cumsum(rng.normal(size=(80, 5, 3)), axis=0) * [1.0, 1e-6, 1e6] + [0.0, 5.0, 0.0]
    walk[3, 2] = np.nan
    powers = np.logspace(-30, 30, 50)
    reported = {
        "walk": walk,
        "again": [walk],
        "coarse": packing.Numbers(walk[..., 0], "u1"),
        "powers": packing.Numbers(powers, "f4"),
        "times": packing.Numbers(0.002 * np.arange(50), "u4"),
        "none": np.zeros((0, 3)),
        "same": np.full((4, 2), 7.25),
        "text": "</script>",
    }
    packed = packing.pack(reported)
    assert packed["document"]["walk"] == packed["document"]["again"][0], "packed once"
    found = unpack(packed)
    spans = np.nanmax(walk, axis=(0, 1)) - np.nanmin(walk, axis=(0, 1))
    assert np.all(np.nanmax(np.abs(found["walk"] - walk), axis=(0, 1)) <= 1.01 * spans / 131_066)
    np.testing.assert_array_equal(np.isnan(found["walk"]), np.isnan(walk))
    assert np.nanmax(np.abs(found["coarse"] - walk[..., 0])) <= 1.01 * spans[0] / 506
    np.testing.assert_allclose(found["times"], 0.002 * np.arange(50), rtol=0, atol=1e-10)
    np.testing.assert_allclose(found["powers"], powers, rtol=1e-7)
    assert found["none"].shape == (0, 3)
    np.testing.assert_array_equal(found["same"], reported["same"])
    assert found["text"] == "</script>"


@pytest.mark.parametrize("kind", ["u1", "u2", "u4"])
@pytest.mark.parametrize("range_", [(-1.3, 0.7), (-0.7, 0.0), (0.0, 0.9), (-1e-7, 1e9)])
def test_zero_stays_zero(kind, range_):
    """What does not move yet has no displacement, not half a step of the encoding."""
    values = np.linspace(*range_, 97)
    values[[3, 40]] = 0.0
    found = unpack(packing.pack({"values": packing.Numbers(values, kind)}))["values"]
    assert (found[[3, 40]] == 0.0).all()
    step = (range_[1] - range_[0]) / (2 ** (8 * int(kind[1])) - 3)
    assert np.abs(found - values).max() <= 0.501 * step


def test_curves_that_are_rounding_are_zero():
    """Relative to what has the same unit in the same figure; on logarithmic axes every digit counts."""
    t, noise = np.linspace(0.0, 1.0, 5), np.array([1e-18, -3e-17, np.nan, 2e-17, 1e-17])
    big, small = plots.Curve("big", t, 3.0 + t, ""), plots.Curve("noise", t, noise, "")

    def of(*axes_and_curves):
        rows = [[plots.Plot(plots.Axis("time (s)"), axis, curves)] for axis, curves in axes_and_curves]
        shown = plots.without_rounding(plots.Figure(rows, 200))
        return [curve.y for curve in shown.curves]

    zeros = np.where(np.isnan(noise), np.nan, 0.0)
    beside = of(
        (plots.Axis("bending about y (rad/m)"), [big]), (plots.Axis("bending about z (rad/m)"), [small])
    )
    np.testing.assert_array_equal(beside[1], zeros)
    np.testing.assert_array_equal(beside[0], big.y)
    np.testing.assert_array_equal(of((plots.Axis("position (m)"), [big, small]))[1], zeros)
    of_others = of((plots.Axis("force (N)"), [big]), (plots.Axis("gap (m)"), [small]))
    np.testing.assert_array_equal(of_others[1], noise)
    np.testing.assert_array_equal(of((plots.Axis("error (m)", log=True), [big, small]))[1], noise)


def test_a_total_that_differs_by_rounding_is_constant(tentacle):
    balance = tentacle.balance
    changed = balance.total[0] * (1.0 + np.array([0.0, 1e-16, -3e-16]))
    terms = {name: np.full(3, 2.0) for name in ("kinetic", "elastic", "gravitational", "loads", "dissipated")}
    made = SimpleNamespace(
        t=np.arange(3.0),
        instants=lambda most: np.arange(3),
        balance=SimpleNamespace(**terms, work=np.zeros(3), total=changed),
    )
    (curve,) = curves.drift(made).curves
    assert (curve.y == 0.0).all()
    made.balance.total = changed + np.array([0.0, 1e-9, 0.0])
    assert curves.drift(made).curves[0].y.max() == pytest.approx(1e-9, rel=1e-6)


@pytest.mark.parametrize(
    ("typed", "printed"),
    [
        ("least -3.5e-05, largest 2e+06 N", "least −3.5·10⁻⁵, largest 2·10⁶ N"),
        ("(-0.1, 0, 1.25e-12) m", "(−0.1, 0, 1.25·10⁻¹²) m"),
        ("choose rtol=1e-6 or dt=-1", "choose rtol=1e-6 or dt=-1"),
        ("2026-11-28, link-3, rk45, 0x1e5, 1e-3x", "2026-11-28, link-3, rk45, 0x1e5, 1e-3x"),
        ("2,424 steps of 1 m/s²", "2,424 steps of 1 m/s²"),
    ],
)
def test_numbers_in_words_are_as_in_print(typed, printed):
    assert typeset(typed) == printed


def test_pages_have_one_notation_for_numbers():
    """But sources remain as they are."""
    section = pages.Section(
        "A",
        ["1e-05 of it", pages.Table(("a",), [("-2e-07",)], caption="3e-08"), pages.Source("s", "dt = 1e-9")],
    )
    text = pages.render(pages.Page("T", "4e-06", [section], advice=["5e-06"], tiles=[("6e-06", "drift")]))
    for exponent in ("1·10⁻⁵", "−2·10⁻⁷", "3·10⁻⁸", "4·10⁻⁶", "5·10⁻⁶", "6·10⁻⁶", "dt = 1e-9"):
        assert exponent in text
    assert re.findall(r"\de-\d", text) == ["1e-9"]


def test_beyond_all_numbers_nothing_fails():
    values = np.array([[1e308, -1e308], [np.inf, np.nan], [-1e308, 1e308]])
    found = unpack(packing.pack({"values": values}))["values"]
    np.testing.assert_array_equal(np.isnan(found), ~np.isfinite(values))
    np.testing.assert_allclose(found[[0, 2]], [[1e300, -1e300], [-1e300, 1e300]], rtol=1e-4)


def test_coordinates_are_labelled_with_units(tentacle):
    figure = report.build(tentacle).sections[2].parts[0].figure
    assert [plot.y.title for plot in figure.plots] == [
        *("torsion (rad/m)", "bending about y (rad/m)", "bending about z (rad/m)", "stretch (1)"),
    ]
    assert [plot.x.title for plot in figure.plots] == ["", "", "", "time (s)"]
    assert figure.clock == "motion"


def test_curves_are_told_in_words(tentacle, page):
    (position,) = unpack(page.figures[1])["rows"]
    tip = tentacle.scene.model.pose(tentacle.q)[:, 2, 3]
    assert position[0]["label"].startswith("position of the tip (m) over time (s). x: from ")
    least = f"{tip.min():.3g}"
    assert least.startswith("-"), "the sign is one of print"
    reported = f"z: from {tip[0]:.3g} to {tip[-1]:.3g}, least {least}".replace("-", "−")
    assert reported in position[0]["label"]
    words = unpack(page.figures[0])["words"]
    assert words.startswith("View in space with rod, forces, moments, clamp, gravity, tip, path of the tip")
    assert "from t = 0 s to t = 0.5 s" in words


def test_a_pendulum_gets_a_plane_animation(tmp_path):
    pendulum = run("version = 1\n[pendulum]\nq0 = [-0.8, 0.5]\n[simulation]\nt_end = 2\n")
    found = report.build(pendulum)
    titles = [section.title for section in found.sections]
    assert titles == ["Motion", "Coordinates", "Energy", "Solver", "Scene"]
    shown = found.sections[0].parts[0].scene
    (mass,), (spring,) = shown.of(layers.Dots), shown.of(layers.Strand)
    r, angle = 1.0 + pendulum.q[0, 1], pendulum.q[0, 0]
    np.testing.assert_allclose(mass.points[0, 0], [r * np.cos(angle), r * np.sin(angle), 0.0])
    np.testing.assert_allclose(spring.points[:, -1], mass.points[:, 0])
    # Viewed along z, with y up and equal scales, because one camera serves all axes.
    assert shown.eye.tolist() == [0.0, 0.0, 1.0]
    assert (shown.ground[0], shown.ground[2]) == (1, True)


def test_an_interrupted_run_says_so(tentacle):
    stopped = Run(tentacle.scene, tentacle.motion, interrupted=True)
    text, good = report.build(stopped).outcome
    assert not good
    assert text.startswith("Interrupted at 0.5 s")


def test_long_runs_are_thinned_out():
    kept = instants(10**6, 2000)
    assert len(kept) == 2000
    assert kept[0] == 0
    assert kept[-1] == 10**6 - 1
    np.testing.assert_array_equal(instants(3, 2000), [0, 1, 2])


def test_a_rod_at_rest_has_no_drift():
    hanging = run((SCENES / "lab-hanging.toml").read_text())
    assert hanging.balance.drift == 0.0
    assert not hanging.balance.moves
    assert dict(report.text.summary(hanging))["energy drift"] == "none: nothing moves"


def test_sections_reach_from_base_to_tip_and_meet_the_joints(tentacle):
    (link,) = tentacle.view.links
    found = link.stations
    assert found[0] == 0.0
    assert found[-1] == tentacle.scene.model.length
    assert 0.2 in found
    assert np.all(np.diff(found) > 0.0)


def test_the_dataset_names_every_coordinate(tentacle):
    data = xarray.load_dataset(io.BytesIO(written(trajectory(tentacle))), engine="h5netcdf")
    assert list(data.coordinate.values) == [
        "segment0.torsion.0",
        "segment0.bend_y.0",
        "segment0.bend_y.1",
        "segment0.bend_z.0",
        "segment0.bend_z.1",
        "segment1.bend_y.0",
        "segment1.stretch.0",
    ]
    assert list(data.unit.values) == ["rad/m"] * 6 + ["1"]
    assert all(re.fullmatch(r"s|J|m|see unit.*", data[name].attrs["units"]) for name in data.data_vars)


def test_ink_is_readable_on_the_colours_of_cells():
    assert [theme.ink_on(colour) for colour in ("#ffffff", "#000000", "#e3c34a", "#8b1a2b")] == [
        *("#000000", "#ffffff", "#000000", "#ffffff"),
    ]
    cells = pages.Cells("a", ["1 <"], ["x"], [[pages.Cell("slow", "<b>", 'say "no"')]], {"slow": "#e3c34a"})
    text = pages._part(cells, {})
    assert "background:#e3c34a;color:#000000" in text
    assert "<b>" not in text
    assert 'title="say &quot;no&quot;"' in text
