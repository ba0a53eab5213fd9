"""What reports show of robots: layers that are switched, arrows that follow loads, links that are picked."""

import html
from html.parser import HTMLParser

import numpy as np
import pytest

import lissom
from lissom import report, studies
from lissom.report import page
from lissom.report import studies as study_reports
from lissom.results import Run

#: Joints, loads and supports of every kind; a name that would be markup.
SCENE = """version = 1
[scene]
name = "Every joint"
[fluid]
density = 1
velocity = [0.3, 0, 0]
viscous_drag = [0.1, 0.1]
[[link]]
name = "sled"
position = [0, 0, 0.3]
joint = { type = "planar", normal = [0, 0, 1] }
body = { mass = 0.3, inertia = [[1e-4, 0, 0], [0, 3e-4, 0], [0, 0, 3e-4]] }
v0 = [0.2, 0.1, 0]
[[link]]
name = "arm"
parent = "sled"
joint = { type = "universal", axis1 = [0, 1, 0], axis2 = [0, 0, 1] }
q0 = [0.3, 0.2, 0, 0]
[[link.load]]
force = { times = [0, 0.1], values = [[0, 0, 0], [0, 1, 0]] }
[[link.load]]
along = [0.05, 0.2]
force = [0, 0, -2]
[[link.load]]
at = 0.1
frame = "body"
moment = { amplitude = [0.02, 0, 0], frequency = 10 }
[[link.rod.segment]]
length = 0.25
radius = 0.01
young_modulus = 1e6
poisson_ratio = 0.4
density = 1070
retardation_time = 0.01
modes = { bend_y = 1, bend_z = 1 }
[[link]]
name = "<b>ball</b>"
parent = "arm"
joint = { type = "spherical" }
body = { mass = 0.03, centre = [0.05, 0, 0.0], inertia = [[1e-6, 0, 0], [0, 1e-5, 0], [0, 0, 1e-5]] }
[[link]]
name = "post"
[[link.load]]
frame = "body"
force = [-1, 0, 0]
[[link.support]]
at = 0.2
stiffness = 20
position = [0.2, 0, 0.25]
[[link.rod.segment]]
length = 0.3
radius = 0.01
young_modulus = 1e6
poisson_ratio = 0.4
density = 1070
modes = { bend_y = 2 }
[simulation]
t_end = 0.1
dt = 1e-3
[simulation.output]
dt = 0.01
"""

#: Arrows of forces: first what is at a point, then what is spread, in the order of the loads.
ON_ARM, ON_POST, SPREAD = 0, 1, slice(2, 7)


@pytest.fixture(scope="module")
def run():
    scene = lissom.Scene.loads(SCENE)
    return Run(scene, scene.run())


@pytest.fixture(scope="module")
def built(run):
    return report.build(run)


@pytest.fixture(scope="module")
def animation(built):
    return built.sections[0].parts[0].figure


def in_layer(figure, layer, kind):
    """The traces of a layer that draw something, by their places among all."""
    return [
        (i, trace)
        for i, trace in enumerate(figure.data)
        if trace.legendgroup == layer and trace.type == kind and not trace.showlegend
    ]


def points(figure, i, shape):
    """The points of a trace in one of the shapes, (points, 3)."""
    frame = figure.frames[shape]
    trace = frame.data[frame.traces.index(i)] if i in frame.traces else figure.data[i]
    return np.stack([trace.x, trace.y, trace.z], axis=1).astype(float)


def test_every_layer_has_one_entry_in_the_legend(animation):
    legend = [trace for trace in animation.data if trace.showlegend]
    names = [trace.name for trace in legend]
    assert names == [
        *("rods", "bodies", "joints", "forces", "moments", "supports", "current", "gravity", "floor"),
        *("tips", "paths", "initial shape"),
    ]
    assert [trace.legendgroup for trace in legend] == names
    assert {trace.legendgroup for trace in animation.data if not trace.showlegend} == set(names)
    # What is nowhere shows in the legend, and nowhere else.
    assert all(trace.x == (None,) for trace in legend)


def test_frames_have_what_moves_and_nothing_else(animation):
    for i, trace in enumerate(animation.data):
        first, *others = (points(animation, i, shape) for shape in range(len(animation.frames)))
        moves = not all(np.array_equal(first, other, equal_nan=True) for other in others)
        assert (i in animation.frames[0].traces) == moves, trace.name
    assert len({frame.traces for frame in animation.frames}) == 1
    still = {
        trace.legendgroup for i, trace in enumerate(animation.data) if i not in animation.frames[0].traces
    }
    assert {"gravity", "current", "floor", "paths"} <= still
    ((_, clamp),) = in_layer(animation, "supports", "mesh3d")
    assert clamp.name == "clamp"


def arrows(animation, layer, shape):
    """Tails and heads of the arrows of a layer."""
    (shafts, _), *_ = in_layer(animation, layer, "scatter3d")
    ((cones, _),) = in_layer(animation, layer, "mesh3d")
    tails = points(animation, shafts, shape)[::3]
    return tails, points(animation, cones, shape)[::7]


def test_arrows_follow_their_loads(run, animation):
    model = run.scene.model
    lengths = []
    for shape in range(len(animation.frames)):
        tails, heads = arrows(animation, "forces", shape)
        arrow = heads - tails
        q = run.q[shape]
        # Grows with its load, from nothing, and keeps its direction.
        tip = model.pose(q, link="arm")[:3, 3]
        np.testing.assert_allclose(tails[ON_ARM], tip, atol=1e-6)
        np.testing.assert_allclose(arrow[ON_ARM][[0, 2]], 0.0, atol=1e-6)
        lengths.append(arrow[ON_ARM][1])
        # Turns with the rod, and ends where it pushes.
        pose = model.pose(q, link="post")
        np.testing.assert_allclose(heads[ON_POST], pose[:3, 3], atol=1e-6)
        along = arrow[ON_POST] / np.linalg.norm(arrow[ON_POST])
        np.testing.assert_allclose(along, -pose[:3, 0], atol=1e-5)
        # A comb that stands on the rod.
        places = model.pose(q, np.linspace(0.05, 0.2, 5), link="arm")[:, :3, 3]
        np.testing.assert_allclose(heads[SPREAD], places, atol=1e-6)
        np.testing.assert_allclose(arrow[SPREAD][:, :2], 0.0, atol=1e-6)
        assert np.all(arrow[SPREAD][:, 2] < -0.01)
    np.testing.assert_allclose(lengths, lengths[-1] * np.linspace(0, 1, 11), atol=1e-6)
    assert lengths[-1] > 0.02


def test_rings_go_round_their_moments(run, animation):
    ((ring, _),) = in_layer(animation, "moments", "scatter3d")
    seen = set()
    for shape in (1, 2, 3, 6, 7, 8):
        around = points(animation, ring, shape)[:13]
        pose = run.scene.model.pose(run.q[shape], 0.1, link="arm")
        axis, moment = pose[:3, 0], 0.02 * np.sin(20 * np.pi * run.t[shape])
        radii = around - pose[:3, 3]
        np.testing.assert_allclose(radii @ axis, 0.0, atol=1e-6)
        sizes = np.linalg.norm(radii, axis=1)
        np.testing.assert_allclose(sizes, sizes[0], rtol=1e-4)
        turn = np.cross(radii[:-1], radii[1:]) @ axis
        assert np.all(turn * moment > 0.0), "the right-hand rule"
        seen.add(np.sign(moment))
    assert seen == {-1.0, 1.0}


def test_joints_move_with_the_robot(run, animation):
    wide = [trace for trace in in_layer(animation, "joints", "scatter3d") if trace[1].mode == "lines"]
    ((balls, _),) = (
        trace for trace in in_layer(animation, "joints", "scatter3d") if trace[1].mode == "markers"
    )
    axes, frames = wide
    assert axes[1].line.width > frames[1].line.width
    model = run.scene.model
    for shape in (0, 10):
        tip = model.pose(run.q[shape], link="arm")[:3, 3]
        np.testing.assert_allclose(points(animation, balls, shape), [tip], atol=1e-6)
        normal, *cross = points(animation, axes[0], shape).reshape(3, 3, 3)
        sled = model.pose(run.q[shape], link="sled")[:3, 3]
        for line in (normal, *cross):
            np.testing.assert_allclose(0.5 * (line[0] + line[1]), sled, atol=1e-6)
        np.testing.assert_allclose((normal[1] - normal[0])[:2], 0.0, atol=1e-6)
    # The plane does not move, and all of the way lies in it.
    assert frames[0] not in animation.frames[0].traces
    corners = points(animation, frames[0], 0)[:4]
    np.testing.assert_allclose(corners[:, 2], 0.3, atol=1e-6)
    way = run.q[:, run.scene.model.slice("sled")][:, :2]
    assert np.all(corners[:, :2].min(axis=0) < way.min(axis=0))
    assert np.all(corners[:, :2].max(axis=0) > way.max(axis=0))


def test_springs_reach_from_their_anchor_to_the_rod(run, animation):
    anchors, springs = in_layer(animation, "supports", "scatter3d")
    np.testing.assert_allclose(points(animation, anchors[0], 0), [[0.2, 0, 0.25]], atol=1e-6)
    for shape in (0, 10):
        spring = points(animation, springs[0], shape)
        held = run.scene.model.pose(run.q[shape], 0.2, link="post")[:3, 3]
        np.testing.assert_allclose(spring[0], [0.2, 0, 0.25], atol=1e-6)
        np.testing.assert_allclose(spring[-2], held, atol=1e-6)


def test_gravity_current_and_floor_are_where_they_should(animation):
    space = animation.layout.scene
    low, high = np.array([space[f"{axis}axis"].range for axis in "xyz"]).T
    for layer, direction in (("gravity", [0, 0, -1]), ("current", [1, 0, 0])):
        tails, heads = arrows(animation, layer, 0)
        for arrow in heads - tails:
            np.testing.assert_allclose(arrow / np.linalg.norm(arrow), direction, atol=1e-5)
        # What leaves the box is cut off.
        assert np.all((tails > low) & (tails < high) & (heads > low) & (heads < high))
    ((floor, _),) = in_layer(animation, "floor", "mesh3d")
    corners = points(animation, floor, 0)
    assert np.ptp(corners[:, 2]) == 0.0
    assert low[2] < corners[0, 2] < low[2] + 0.05 * (high - low)[2]


def test_everything_is_within_the_box(animation):
    space = animation.layout.scene
    low, high = np.array([space[f"{axis}axis"].range for axis in "xyz"]).T
    for i, trace in enumerate(animation.data):
        if trace.showlegend:
            continue
        for shape in (0, len(animation.frames) - 1):
            there = points(animation, i, shape)
            assert np.nanmin(there - low) > -1e-6, trace.name
            assert np.nanmin(high - there) > -1e-6, trace.name


class Page(HTMLParser):
    """The options of the pickers of a page, and what is hidden at first."""

    def __init__(self, text):
        super().__init__()
        self.options, self.hidden, self.sources, self._inside = [], [], [], False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self._inside = tag == "option"
        if attributes.get("class") == "option":
            self.hidden.append("hidden" in attributes)
            self.sources.append([])
        if attributes.get("class") == "figure" and self.sources:
            self.sources[-1].append(attributes["data-source"])

    def handle_data(self, data):
        if self._inside:
            self.options.append(data)
        self._inside = False


def test_the_reader_picks_a_link(run, built):
    text = page.render(built)
    shown = Page(text)
    assert shown.options == ["sled", "arm", "<b>ball</b>", "post"]
    assert shown.hidden == [False, True, True, True]
    for source in [source for sources in shown.sources for source in sources]:
        assert text.count(f'id="{source}"') == 1
    assert "<b>ball" not in text.replace(html.escape("<b>ball"), "").split("<script")[0]
    assert [section.title for section in built.sections] == ["Motion", "Links", "Energy", "Solver", "Scene"]


def test_the_curves_are_those_of_the_link(run, built):
    (choice,) = built.sections[1].parts
    model = run.scene.model
    for name, parts in choice.options:
        position, coordinates, wrench = (part.figure for part in parts)
        poses = model.pose(run.q, link=name)
        np.testing.assert_allclose([trace.y for trace in position.data], poses[:, :3, 3].T, atol=1e-6)
        names = model.coordinates[model.slice(name)]
        assert tuple(trace.name for trace in coordinates.data) == names
        for trace, values in zip(coordinates.data, run.q[:, model.slice(name)].T, strict=True):
            np.testing.assert_allclose(trace.y, values, atol=1e-6)
        expected = model.joint_wrench(run.q, run.v, run.a, link=name, t=run.t)
        found = np.array([trace.y for trace in wrench.data])
        np.testing.assert_allclose(found, expected[:, [3, 4, 5, 0, 1, 2]].T, rtol=1e-5, atol=1e-6)
        assert [axis.title.text for axis in wrench.select_yaxes()] == ["force (N)", "moment (N m)"]


def test_one_link_leaves_nothing_to_pick():
    text = """version = 1
[[link]]
name = "pole"
joint = { type = "revolute", axis = [0, 1, 0] }
body = { mass = 1, centre = [0.3, 0, 0] }
[simulation]
t_end = 0.05
dt = 1e-2
"""
    scene = lissom.Scene.loads(text)
    titles = [section.title for section in report.build(Run(scene, scene.run())).sections]
    assert titles == ["Motion", "Pole", "Coordinates", "Energy", "Solver", "Scene"]


def test_many_links_share_the_numbers_of_the_page():
    link = """[[link]]
name = "link{0}"
joint = {{ type = "revolute", axis = [0, 1, 0] }}
position = [{0}, 0, 0]
body = {{ mass = 1, centre = [0.1, 0, 0] }}
"""
    many = "version = 1\n" + "".join(link.format(i) for i in range(60))
    scene = lissom.Scene.loads(f"{many}[simulation]\nt_end = 1.0\ndt = 1e-3\n")
    done = Run(scene, scene.run())
    (choice,) = report.build(done).sections[1].parts
    figures = [part.figure for _, parts in choice.options for part in parts]
    numbers = sum(len(trace.y) for figure in figures for trace in figure.data)
    assert len(done.t) * 60 * 10 > 2 * report.curves.MAX_NUMBERS
    assert 0.9 * report.curves.MAX_NUMBERS < numbers <= report.curves.MAX_NUMBERS


def test_an_equilibrium_is_shown_first_with_the_loads_that_hold_it():
    quiet = SCENE.replace("[0.05, 0.2]\nforce = [0, 0, -2]", "[0.05, 0.2]\nforce = [0, 0, -0.2]")
    quiet = quiet.replace("velocity = [0.3, 0, 0]\n", "")
    for name in ("planar", "spherical", "universal"):
        # Nothing holds these.
        quiet = quiet.replace(f'type = "{name}"', 'type = "revolute", stiffness = 1, axis = [0, 1, 0] #')
    lines = [line for line in quiet.splitlines() if not line.startswith(("q0", "v0"))]
    study = studies.study_statics(lissom.Scene.loads("\n".join(lines).replace("#", "} #")))
    assert study.found.success
    built = study_reports.statics(study)
    animation = built.sections[0].parts[0].figure
    last = len(animation.frames) - 1
    assert animation.layout.sliders[0].active == last > 0
    (rod, _), _ = in_layer(animation, "rods", "mesh3d")
    shown = np.stack([animation.data[rod].x, animation.data[rod].y, animation.data[rod].z], axis=1)
    np.testing.assert_array_equal(shown, points(animation, rod, last))
    # Arrows are as long as the load factor says; the table says what joints carry in the end.
    factor = study.found.path.load_factor
    lengths = [
        np.linalg.norm(np.subtract(*arrows(animation, "forces", shape)), axis=1)
        for shape in range(len(animation.frames))
    ]
    np.testing.assert_allclose(lengths, np.outer(factor, lengths[-1]), atol=1e-5)
    assert lengths[-1][ON_POST] > 0.02
    (table,) = next(section for section in built.sections if section.title == "Links").parts
    model, rest = study.scene.model, np.zeros(study.scene.model.n)
    for name, _, force, moment in table.rows:
        wrench = model.joint_wrench(study.found.q, rest, rest, link=name, t=0.0)
        numbers = [float(number) for text in (moment, force) for number in text.strip("()").split(",")]
        np.testing.assert_allclose(numbers, wrench, rtol=1e-3, atol=1e-8)
