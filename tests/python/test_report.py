"""The report of a run."""

import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import lissom
from lissom import report
from lissom.files import dataset
from lissom.results import Run, instants

SCENES = Path(__file__).parents[2] / "scenes"

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


def test_every_figure_has_its_data(page):
    holders = [attributes for tag, attributes in page.tags if attributes.get("class") == "figure"]
    sources = [
        attributes["id"] for tag, attributes in page.tags if attributes.get("type") == "application/json"
    ]
    assert [holder["data-source"] for holder in holders] == sources
    assert len(page.figures) == len(sources) == 5


def test_names_cannot_inject_markup(tentacle, page):
    scripts = [attributes for tag, attributes in page.tags if tag == "script"]
    assert len(scripts) == len(page.figures) + 2, "the figures, plotly, the page's own"
    titles = [tag for tag, _ in page.tags if tag == "title"]
    assert len(titles) == 1


def test_the_animation_shows_the_rod_as_it_moves(tentacle, page):
    animation = page.figures[0]
    assert {trace["type"] for trace in animation["data"]} == {"mesh3d", "scatter3d"}
    frames, steps = animation["frames"], animation["layout"]["sliders"][0]["steps"]
    assert len(frames) == len(steps) == 200
    assert [frame["name"] for frame in frames] == [step["args"][0][0] for step in steps]
    assert [button["label"] for button in animation["layout"]["updatemenus"][0]["buttons"]] == [
        "▶ Play",
        "❚❚ Pause",
    ]
    space = animation["layout"]["scene"]
    lengths = [np.ptp(space[f"{axis}axis"]["range"]) for axis in "xyz"]
    ratios = [space["aspectratio"][axis] for axis in "xyz"]
    np.testing.assert_allclose(np.divide(lengths, ratios), lengths[0] / ratios[0], err_msg="axes to scale")


def test_coordinates_are_labelled_with_units(page):
    axes = {key: value for key, value in page.figures[2]["layout"].items() if key.startswith("yaxis")}
    titles = {axis["title"]["text"] for axis in axes.values()}
    assert titles == {"torsion (rad/m)", "bending about y (rad/m)", "bending about z (rad/m)", "stretch (1)"}


def test_a_pendulum_gets_a_plane_animation(tmp_path):
    pendulum = run("version = 1\n[pendulum]\nq0 = [-0.8, 0.5]\n[simulation]\nt_end = 2\n")
    found = report.build(pendulum)
    titles = [section.title for section in found.sections]
    assert titles == ["Motion", "Coordinates", "Energy", "Solver", "Scene"]
    animation = found.sections[0].parts[0].figure
    _trail, spring, mass, _hinge = animation.data
    r, angle = 1.0 + pendulum.q[0, 1], pendulum.q[0, 0]
    np.testing.assert_allclose([mass.x[0], mass.y[0]], [r * np.cos(angle), r * np.sin(angle)])
    np.testing.assert_allclose([spring.x[-1], spring.y[-1]], [mass.x[0], mass.y[0]])
    assert animation.layout.yaxis.scaleanchor == "x", "axes to scale"


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
    data = dataset(tentacle)
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
