"""Actuators in drawings and plots of reports."""

import numpy as np

import lissom
from lissom import Along, Chamber, Input, Motor, Tendon, Via
from lissom.drawing.report import actuators as drawing
from lissom.drawing.report.layers import DrawnStates
from lissom.model.glyphs.actuators import actuator_glyphs
from lissom.model.views import view

SOFT = lissom.Segment(0.2, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 3, "bend_z": 3, "stretch": 1})


def robot():
    path = [
        Via(None, (-0.05, 0, 0.02)),
        Along("finger", (lambda X: 0.008 * np.cos(20 * X), (0.01, 0.004)), (0.02, 0.15)),
        Via("nail", (0.01, 0, 0.005)),
    ]
    return lissom.Robot(
        [
            lissom.Link("base", body=lissom.Body(0.1), joint=lissom.Revolute((0, 0, 1))),
            lissom.Link("finger", parent="base", rod=[SOFT]),
            lissom.Link("nail", parent="finger", body=lissom.Body(0.01)),
        ],
        actuators=[
            Tendon("flexor", path, tension=Input("pull", 2.0)),
            Chamber("chamber", [Along("finger", (0, -0.004))], 2e-5, 1e3),
            Motor("base", 0.01, name="servo"),
            lissom.ActiveStrain("finger", "bend_y", 1.0, 0.3),
        ],
    )


def states(n):
    rng = np.random.default_rng(7)
    return 0.5 * rng.normal(size=(4, n)), rng.normal(size=(4, n)), np.arange(4.0)


def test_ways_are_as_long_as_their_tendons():
    model = robot()
    q, _, t = states(model.n)
    glyphs = {glyph.name: glyph for glyph in actuator_glyphs(model)}
    for name in ("flexor", "chamber"):
        way = glyphs[name].way(q, t)
        length = np.linalg.norm(np.diff(way, axis=1), axis=-1).sum(axis=1)
        wanted = glyphs[name].length(q, t) / (2e-5 if name == "chamber" else 1.0)
        # Chords of 16 pieces with a total angle below three radians.
        np.testing.assert_allclose(length, wanted, rtol=2e-3)


def test_quantities_are_those_of_the_robot():
    model = robot()
    q, v, t = states(model.n)
    for glyph in actuator_glyphs(model):
        for u in (np.full((4, 1), 2.0), np.linspace(0.0, 3.0, 4)[:, None]):
            wanted = model.actuator_force(glyph.name, q, v, t=t, u=u)
            np.testing.assert_array_equal(glyph.force(q, v, t, u), wanted)
        np.testing.assert_array_equal(glyph.length(q, t), model.actuator_length(glyph.name, q, t=t))
    kinds = [glyph.kind for glyph in actuator_glyphs(model)]
    assert kinds == ["tendon", "chamber", "motor", "active strain"]


def test_tendons_are_as_thick_as_they_pull_and_chambers_as_wide_as_they_are():
    model = robot()
    q, v, t = states(model.n)
    u = np.array([[0.0], [1.0], [2.0], [4.0]])
    shown = DrawnStates(q, v, u, t, np.ones(4), 0.2, 0.01, 0.01)
    found = {strand.layer: strand for strand in drawing.actuators(view(model).glyphs.actuators, [], shown)}
    glyphs = {glyph.name: glyph for glyph in actuator_glyphs(model)}
    for name, layer in (("flexor", "tendons"), ("chamber", "chambers")):
        np.testing.assert_array_equal(found[layer].points, glyphs[name].way(q, t))
    wanted = 0.2 * (drawing.THIN + (drawing.THICK - drawing.THIN) * u[:, 0] / 4.0)
    np.testing.assert_allclose(found["tendons"].radius, wanted)
    np.testing.assert_allclose(np.pi * found["chambers"].radius ** 2, 2e-5)
    assert found["chambers"].opacity < 1.0


def test_actuators_are_drawn_in_layers_of_their_own():
    model = robot()
    run = lissom.simulate(model, 0.05, dt=5e-3)
    bare = lissom.Robot(model.links)
    assert view(bare).glyphs.actuators == []
    shown = DrawnStates(run.q, run.v, run.u, run.t, np.ones(len(run.t)), 0.2, 0.01, 0.01)
    glyphs = view(model).glyphs
    layers = [trace.layer for trace in drawing.actuators(glyphs.actuators, glyphs.joints, shown)]
    assert layers == ["tendons", "chambers", "motors"]
