"""Closed loops in drawings and plots of reports."""

import numpy as np
import pytest

import lissom
from lissom import (
    Body,
    Cylindrical,
    Distance,
    Free,
    Gear,
    Link,
    Loop,
    Planar,
    Prismatic,
    Revolute,
    Robot,
    Spherical,
    Universal,
    Weld,
)
from lissom.drawing import report
from lissom.drawing.report import loops, symbols
from lissom.drawing.report.layers import DrawnStates
from lissom.model.glyphs.loops import ROWS, loop_glyphs
from lissom.model.views import view
from lissom.results.runs import Made

TURNED = (0.8, 0.0, 0.6, 0.0)
KINDS = {
    "pin": Revolute((0, 1, 0)),
    "rail": Prismatic((1, 0, 0)),
    "tube": Cylindrical((0, 1, 0)),
    "cross": Universal((1, 0, 0), (0, 1, 0)),
    "table": Planar((0, 0, 1)),
    "ball": Spherical(),
    "weld": Weld(),
    "bar": Distance(0.4),
}


def robot(name):
    """A rod whose tip is tied to a body, and a gear."""
    rod = lissom.Segment(0.5, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 2, "bend_z": 1})
    body = Body(0.2, centre=(0.1, 0, 0), inertia=np.diag([1e-3, 2e-3, 2e-3]))
    links = [Link("arm", rod=[rod]), Link("block", position=(0.5, 0, 0), joint=Free(), body=body)]
    tied = Loop("arm", ("block", None, (0, 0, 0.1), TURNED), KINDS[name], name=name)
    gear = Loop("arm.bend_y[1]", "arm.bend_y[0]", Gear(0.2), name="gear")
    # Constraints of gears come after all others, for any order of the loops.
    return Robot(links, loops=[gear, tied])


def shown(model, q, v):
    ones = np.ones(len(q))
    return DrawnStates(q, v, np.zeros((len(q), 0)), 0.0 * ones, ones, 1.0, 0.01, 0.05)


@pytest.mark.parametrize("name", KINDS)
def test_marks_are_those_of_the_robot(name):
    model = robot(name)
    rng = np.random.default_rng(3)
    q, v, a = 0.3 * rng.normal(size=(3, 4, model.n))
    t, u = np.zeros(4), np.zeros((4, 0))
    gear, tied = loop_glyphs(model)
    assert (gear.name, tied.name, gear.kind) == ("gear", name, "gear")
    np.testing.assert_array_equal(tied.force(q, v, a, t, u), model.loop_forces(q, v, a, name=name))
    np.testing.assert_array_equal(gear.force(q, v, a, t, u), model.loop_forces(q, v, a, name="gear"))
    gaps = np.abs(model.loop_gaps(q))
    np.testing.assert_array_equal(gear.gaps(q, t)["coordinate"], gaps[:, -1])
    found = np.max(list(tied.gaps(q, t).values()), axis=0)
    np.testing.assert_array_equal(found, gaps[:, :-1].max(axis=1))
    # The distance of the ends is the coordinate of a distance joint and the gap of a spherical one.
    ends = [frame(q, t)[:, :3, 3] for frame, _ in tied.ends]
    apart = ends[1] - ends[0]
    if name == "bar":
        np.testing.assert_allclose(gaps[:, 0], abs(np.linalg.norm(apart, axis=1) - 0.4), atol=1e-14)
    if name in ("ball", "pin", "weld", "cross"):
        np.testing.assert_allclose(
            np.linalg.norm(gaps[:, :3], axis=1), np.linalg.norm(apart, axis=1), atol=1e-14
        )
    assert sum(ROWS[type(KINDS[name])]) == model.constraints - 1


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("pin", {"strand": 2}),
        ("rail", {"strand": 2}),
        ("tube", {"strand": 3}),
        ("cross", {"strand": 3}),
        ("table", {"strand": 3}),
        ("ball", {"strand": 1, "dots": 1}),
        ("weld", {"strand": 1, "solid": 1}),
        ("bar", {"strand": 2, "dots": 1}),
    ],
)
def test_each_kind_is_drawn(name, kinds):
    """Beside the connection to the frame next to the block."""
    model = robot(name)
    q = np.zeros((2, model.n))
    q[1, 3:6] = 0.05
    things = loops.loops(view(model).glyphs.loops, shown(model, q, q))
    assert {thing.layer for thing in things} == {"loops"}
    assert {thing.name for thing in things} == {f"loop {name}"}
    found = [thing.kind for thing in things]
    assert {kind: found.count(kind) for kind in set(found)} == kinds
    place = model.pose(q, link="arm")[:, :3, 3]
    if name == "bar":
        (bar,) = [
            thing for thing in things if thing.kind == "strand" and np.allclose(thing.points[:, 0], place)
        ]
        lengths = np.linalg.norm(bar.points[:, 1] - bar.points[:, 0], axis=1)
        assert lengths[0] == pytest.approx(0.1)
    if name == "ball":
        (ball,) = [thing for thing in things if thing.kind == "dots"]
        np.testing.assert_allclose(ball.points[:, 0], place, atol=1e-15)
    if name == "pin":
        axis = next(thing.points for thing in things if thing.points.shape[1] == 3)
        np.testing.assert_allclose(axis[0, :2].mean(axis=0), place[0], atol=1e-15)
        np.testing.assert_allclose(np.abs(axis[0, 1] - axis[0, 0]), [0, 2 * loops.AXIS, 0], atol=1e-15)


def test_reports_show_forces_and_gaps(tmp_path):
    model = robot("ball")
    motion = lissom.simulate(model, 0.2, q0=[0, 0, 0, 0, 0, -0.1, 0, 0, 0], dt=0.01)
    assert motion.success, motion.message
    made = Made(motion, model)
    built = report.build_result(motion, "Tied")
    (section,) = [section for section in built.sections if section.title == "Closed loops"]
    choice, figure = section.parts
    assert [name for name, _ in choice.options] == ["gear", "ball"]
    gear, ball = (part[0].figure for _, part in choice.options)
    (plot,) = (row[0] for row in gear.rows)
    wanted = model.loop_forces(motion.q, motion.v, motion.a, name="gear", t=motion.t)
    np.testing.assert_allclose(plot.curves[0].y, wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())
    # A ball joint transmits no moment.
    assert [row[0].y.title for row in ball.rows] == ["force (N)"]
    held = model.loop_forces(motion.q, motion.v, motion.a, name="ball", t=motion.t)
    np.testing.assert_array_equal([curve.y for curve in ball.rows[0][0].curves], held[:, 3:].T)
    assert {row[0].y.title for row in figure.figure.rows} == {"gap (m)", "gap of a gear"}
    assert loops.widest(made).max() == np.abs(model.loop_gaps(motion.q)).max()
    path = tmp_path / "tied.html"
    report.write_result(motion, path)
    assert "loop ball" in path.read_text()
    assert "loops" in symbols.LEGEND


def test_models_without_loops_have_no_such_section():
    rod = lissom.Rod([lissom.Segment(0.2, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 2})])
    built = report.build_result(lissom.simulate(rod, 0.1), "Rod")
    assert "Closed loops" not in [section.title for section in built.sections]
    assert view(rod).glyphs.loops == []
