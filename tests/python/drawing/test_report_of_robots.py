"""Reports of robots: optional layers, arrows that follow loads, selection of links."""

import html
from html.parser import HTMLParser

import numpy as np
import pytest

import lissom
from lissom.drawing import report
from lissom.drawing.report import layers, loads, motion, page, quantities
from lissom.drawing.report import studies as study_reports
from lissom.model.views import view
from lissom.results import studies
from lissom.results.runs import Run

#: Joints, loads and supports of every kind; a name with markup characters.
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

#: Indices of arrows: first concentrated loads, then distributed ones, in the order of the loads.
ON_ARM, ON_POST, SPREAD = 0, 1, slice(2, 7)


@pytest.fixture(scope="module")
def run():
    scene = lissom.Scene.loads(SCENE)
    return Run(scene, scene.run())


@pytest.fixture(scope="module")
def built(run):
    return report.build(run)


@pytest.fixture(scope="module")
def shown(built):
    return built.sections[0].parts[0].scene


def at(values, shape):
    """Values at one of the shapes; constant ones have a single entry."""
    return values[shape if len(values) > 1 else 0]


def stands_still(values):
    return len(layers.still(values)) == 1


def test_every_layer_has_one_entry_in_the_legend(shown):
    reported = shown.document()["layers"]
    names = [
        *("rods", "bodies", "joints", "forces", "moments", "supports", "current", "gravity", "floor"),
        *("tips", "paths", "initial shape"),
    ]
    assert [entry["layer"] for entry in reported] == names
    # What is drawn below a model is no floor that holds anything.
    assert [entry["name"] for entry in reported] == [{"floor": "grid"}.get(name, name) for name in names]
    assert {thing.layer for thing in shown.things} | {"floor"} == set(names)
    colours = {entry["layer"]: entry["colour"] for entry in reported}
    assert colours["forces"] != colours["moments"]


def test_the_document_has_what_moves_over_time_and_the_rest_once(shown):
    moving = set()
    for thing, reported in zip(shown.things, shown.document()["things"], strict=True):
        for name in ("centres", "turns", "points", "tails", "vectors"):
            if name not in reported:
                continue
            values = getattr(thing, name)
            moves = not np.allclose(values, values[:1], rtol=0, atol=2e-6, equal_nan=True)
            assert len(reported[name]) == (len(shown.t) if moves else 1), (thing.name, name)
            if moves:
                moving.add(thing.layer)
    assert {"gravity", "current", "paths", "initial shape"}.isdisjoint(moving)
    assert {"rods", "bodies", "joints", "forces", "moments", "supports", "tips"} <= moving
    (clamp,) = shown.of(layers.Solid, "supports")
    assert clamp.name == "clamp"
    assert stands_still(clamp.centres)


def arrows(shown, layer, shape):
    """Tails and heads of the arrows of a layer."""
    (found,) = shown.of(layers.Arrows, layer)
    tails, vectors = (at(values, shape) for values in (found.tails, found.vectors))
    return tails, tails + vectors


def test_arrows_follow_their_loads(run, shown):
    model = run.scene.model
    lengths = []
    for shape in range(len(shown.t)):
        tails, heads = arrows(shown, "forces", shape)
        arrow = heads - tails
        q = run.q[shape]
        # Increases with its load from zero, and keeps its direction.
        tip = model.pose(q, link="arm")[:3, 3]
        np.testing.assert_allclose(tails[ON_ARM], tip, atol=1e-6)
        np.testing.assert_allclose(arrow[ON_ARM][[0, 2]], 0.0, atol=1e-6)
        lengths.append(arrow[ON_ARM][1])
        # Rotates with the rod, and ends where it pushes.
        pose = model.pose(q, link="post")
        np.testing.assert_allclose(heads[ON_POST], pose[:3, 3], atol=1e-6)
        along = arrow[ON_POST] / np.linalg.norm(arrow[ON_POST])
        np.testing.assert_allclose(along, -pose[:3, 0], atol=1e-5)
        # A comb of arrows on the rod.
        places = model.pose(q, np.linspace(0.05, 0.2, 5), link="arm")[:, :3, 3]
        np.testing.assert_allclose(heads[SPREAD], places, atol=1e-6)
        np.testing.assert_allclose(arrow[SPREAD][:, :2], 0.0, atol=1e-6)
        assert np.all(arrow[SPREAD][:, 2] < -0.01)
    np.testing.assert_allclose(lengths, lengths[-1] * np.linspace(0, 1, 11), atol=1e-6)
    assert lengths[-1] > 0.02


def test_rings_go_round_their_moments(run, shown):
    (ring,) = shown.of(layers.Strand, "moments")
    seen = set()
    for shape in (1, 2, 3, 6, 7, 8):
        around = ring.points[shape][: loads.POINTS_AROUND]
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


def test_joints_move_with_the_robot(run, shown):
    (balls,) = shown.of(layers.Dots, "joints")
    # The plane of the sled's motion and its axis of rotation, then both axes of the arm.
    frame, *axes = shown.of(layers.Strand, "joints")
    assert [bar.name for bar in (frame, *axes)] == ["joint of sled"] * 2 + ["joint of arm"] * 2
    assert all(axis.radius[0] > frame.radius[0] for axis in axes)
    model = run.scene.model
    for shape in (0, 10):
        tip = model.pose(run.q[shape], link="arm")[:3, 3]
        np.testing.assert_allclose(balls.points[shape], [tip], atol=1e-6)
        normal, *cross = (axis.points[shape] for axis in axes)
        sled = model.pose(run.q[shape], link="sled")[:3, 3]
        for line in (normal, *cross):
            np.testing.assert_allclose(0.5 * (line[0] + line[1]), sled, atol=1e-6)
        np.testing.assert_allclose((normal[1] - normal[0])[:2], 0.0, atol=1e-6)
    # The plane does not move, and contains the complete path.
    assert stands_still(frame.points)
    corners = frame.points[0][:4]
    np.testing.assert_allclose(corners[:, 2], 0.3, atol=1e-6)
    way = run.q[:, run.scene.model.slice("sled")][:, :2]
    assert np.all(corners[:, :2].min(axis=0) < way.min(axis=0))
    assert np.all(corners[:, :2].max(axis=0) > way.max(axis=0))


def test_springs_reach_from_their_anchor_to_the_rod(run, shown):
    (anchors,), (spring,) = shown.of(layers.Dots, "supports"), shown.of(layers.Strand, "supports")
    np.testing.assert_allclose(anchors.points[0], [[0.2, 0, 0.25]], atol=1e-6)
    for shape in (0, 10):
        held = run.scene.model.pose(run.q[shape], 0.2, link="post")[:3, 3]
        np.testing.assert_allclose(spring.points[shape][0], [0.2, 0, 0.25], atol=1e-6)
        np.testing.assert_allclose(spring.points[shape][-2], held, atol=1e-6)


def test_gravity_current_and_floor_are_where_they_should(shown):
    low, high = shown.low, shown.high
    for layer, direction in (("gravity", [0, 0, -1]), ("current", [1, 0, 0])):
        tails, heads = arrows(shown, layer, 0)
        for arrow in heads - tails:
            np.testing.assert_allclose(arrow / np.linalg.norm(arrow), direction, atol=1e-5)
        # Items that leave the box may be invisible.
        assert np.all((tails > low) & (tails < high) & (heads > low) & (heads < high))
    axis, place, is_up = shown.ground
    assert (axis, place, is_up) == (2, low[2], True)
    assert shown.surroundings == ["gravity: 9.81 m/s²", "current: 0.3 m/s"]


def test_everything_is_within_the_box(shown):
    for thing in shown.things:
        there = thing.points.reshape(-1, 3)
        assert np.nanmin(there - shown.low) > -1e-6, thing.name
        assert np.nanmin(shown.high - there) > -1e-6, thing.name


class Page(HTMLParser):
    """The options of the pickers of a page, and the initially hidden elements."""

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
    assert [section.title for section in built.sections] == [
        "Motion",
        "Links",
        "Largest values",
        "Energy",
        "Solver",
        "Scene",
    ]


def test_the_curves_are_those_of_the_link(run, built):
    (choice,) = built.sections[1].parts
    model = run.scene.model
    for name, parts in choice.options:
        position, coordinates, wrench = (part.figure for part in parts)
        poses = model.pose(run.q, link=name)
        np.testing.assert_allclose([curve.y for curve in position.curves], poses[:, :3, 3].T, atol=1e-6)
        names = model.coordinates[model.slice(name)]
        assert tuple(curve.name for curve in coordinates.curves) == names
        for curve, values in zip(coordinates.curves, run.q[:, model.slice(name)].T, strict=True):
            np.testing.assert_allclose(curve.y, values, atol=1e-6)
        expected = model.joint_wrench(run.q, run.v, run.a, link=name, t=run.t)
        found = np.array([curve.y for curve in wrench.curves])
        np.testing.assert_allclose(found, expected[:, [3, 4, 5, 0, 1, 2]].T, rtol=1e-5, atol=1e-6)
        assert [plot.y.title for plot in wrench.plots] == ["force (N)", "moment (N m)"]
        for figure in (position, coordinates, wrench):
            assert figure.clock == built.sections[0].parts[0].clock, "one cursor through all"
            assert all(np.array_equal(curve.x, run.t) for curve in figure.curves)


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
    numbers = sum(len(curve.y) for figure in figures for curve in figure.curves)
    assert len(done.t) * 60 * 10 > 2 * report.curves.MAX_NUMBERS
    assert 0.9 * report.curves.MAX_NUMBERS < numbers <= report.curves.MAX_NUMBERS


def test_an_equilibrium_is_shown_first_with_the_loads_that_hold_it():
    quiet = SCENE.replace("[0.05, 0.2]\nforce = [0, 0, -2]", "[0.05, 0.2]\nforce = [0, 0, -0.2]")
    quiet = quiet.replace("velocity = [0.3, 0, 0]\n", "")
    for name in ("planar", "spherical", "universal"):
        # Nothing holds these.
        quiet = quiet.replace(f'type = "{name}"', 'type = "revolute", stiffness = 1, axis = [0, 1, 0] #')
    quiet = quiet.replace("position = [0.2, 0, 0.25]", "position = [0.2, 0, 0.1]")
    lines = [line for line in quiet.splitlines() if not line.startswith(("q0", "v0"))]
    study = studies.study_statics(lissom.Scene.loads("\n".join(lines).replace("#", "} #")))
    assert study.found.success
    built = study_reports.statics(study)
    shown = built.sections[0].parts[0].scene
    last = len(shown.t) - 1
    assert shown.opens_at == last > 0
    assert shown.document()["opensAt"] == last
    post = shown.of(layers.Tube)[1]
    tip = study.scene.model.pose(study.found.q, link="post")[:3, 3]
    np.testing.assert_allclose(post.centres[last, -1], tip, atol=1e-9)
    # Arrows scale with the load factor; the table contains the final forces of joints.
    factor = study.found.path.load_factor
    lengths = [
        np.linalg.norm(np.subtract(*arrows(shown, "forces", shape)), axis=1) for shape in range(last + 1)
    ]
    np.testing.assert_allclose(lengths, np.outer(factor, lengths[-1]), atol=1e-5)
    assert lengths[-1][ON_POST] > 0.02
    (table,) = next(section for section in built.sections if section.title == "Links").parts
    model, rest = study.scene.model, np.zeros(study.scene.model.n)
    for name, _, force, moment in table.rows:
        wrench = model.joint_wrench(study.found.q, rest, rest, link=name, t=0.0)
        numbers = [float(number) for text in (moment, force) for number in text.strip("()").split(",")]
        np.testing.assert_allclose(numbers, wrench, rtol=1e-3, atol=1e-8)


def test_inputs_from_outside_are_drawn_and_plotted_as_they_were():
    """A tendon and a push with inputs that change during the run, not with their defaults."""
    segment = lissom.Segment(
        0.2, 0.01, 1e6, poisson_ratio=0.4, density=1070, modes={"bend_y": 2}, retardation_time=0.02
    )
    path = [lissom.Along("finger", (0.0, 0.006))]
    robot = lissom.Robot(
        [lissom.Link("finger", rod=[segment]), lissom.Link("nail", parent="finger", body=lissom.Body(0.01))],
        actuators=[lissom.Tendon("flexor", path, tension=lissom.Input("pull"))],
        loads=[lissom.Load(force=lissom.Input("push", (0.0, 0.0, 0.0)), link="finger")],
    )

    def control(t, q, v):
        reported = {"pull": 20.0 * t, "push.z": t}
        return [reported.get(name, 0.0) for name in robot.inputs]

    result = lissom.simulate(robot, 0.2, dt=5e-3, control=control)
    pull = result.u[:, robot.inputs.index("pull")]
    assert pull.max() > 3.0
    found = report.build_result(result, "A finger")
    shown = found.sections[0].parts[0].scene
    (drawn,) = shown.of(layers.Strand, "tendons")
    # The thickness represents the tension.
    thin, thick = drawn.radius.min(), drawn.radius.max()
    np.testing.assert_allclose((drawn.radius - thin) / (thick - thin), pull / pull.max(), atol=1e-9)
    (arrow,) = shown.of(layers.Arrows, "forces")
    lengths = arrow.vectors[:, 0, 2]
    up = result.u[:, robot.inputs.index("push.z")]
    np.testing.assert_allclose(lengths, lengths[-1] * up / up[-1], atol=1e-12)
    assert lengths[-1] > 0.0
    (section,) = (section for section in found.sections if section.title == "Actuators")
    tension = section.parts[0].figure.plots[0].curves[0]
    np.testing.assert_allclose(tension.y, pull, atol=1e-12)
    (choice,) = found.sections[1].parts
    wrench = choice.options[0][1][2].figure
    expected = robot.joint_wrench(result.q, result.v, result.a, link="finger", t=result.t, u=result.u)
    np.testing.assert_allclose(wrench.curves[2].y, expected[:, 5], rtol=1e-9)


def test_reports_of_models_made_in_python(tmp_path):
    segment = lissom.Segment(0.2, 0.01, 1e6, poisson_ratio=0.4, density=1070, modes={"bend_y": 2})
    result = lissom.simulate(lissom.Rod([segment]), 0.1, dt=5e-3)
    report.write_result(result, tmp_path / "rod.html", title="A <rod>")
    text = (tmp_path / "rod.html").read_text(encoding="utf-8")
    assert "<title>A &lt;rod&gt;</title>" in text
    titles = [section.title for section in report.build_result(result, "A rod").sections]
    assert titles == ["Motion", "Tip", "Coordinates", "Largest values", "Energy", "Solver"]
    other = lissom.newmark(lambda t, q, v, a: a + q, (0.0, 0.1), [1.0], [0.0], dt=0.01)
    with pytest.raises(ValueError, match="not of `newmark`"):
        report.write_result(other, tmp_path / "other.html")
    assert not (tmp_path / "other.html").exists()


def test_stress_of_reports_leaves_out_active_strains():
    """A rod that an active strain alone bends is free of stress; its curvature is shown."""
    segment = lissom.Segment(1.0, 0.01, 2e9, 8e8, 1000.0, modes={"bend_y": 3})
    bent = lissom.ActiveStrain("finger", "bend_y", 1.0, amount=lissom.Input("bend", 2.0))
    robot = lissom.Robot([lissom.Link("finger", rod=[segment])], actuators=[bent], gravity=(0, 0, 0))
    found = lissom.statics(robot)
    seen = view(robot)
    one = np.zeros(1)
    (tube,) = motion.tubes(seen, found.q[None], np.zeros((1, 3)), one, np.array([[2.0]]))
    np.testing.assert_allclose(tube.quantities[quantities.CURVATURE], 2.0)
    assert tube.quantities[quantities.STRESS].max() < 1e-8 * 2e9 * 0.02
    (tube,) = motion.tubes(seen, found.q[None], np.zeros((1, 3)), one, np.array([[0.0]]))
    np.testing.assert_allclose(tube.quantities[quantities.STRESS], 2e9 * 0.02)
