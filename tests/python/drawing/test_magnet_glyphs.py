"""Magnets and their field in reports and in the live view."""

import numpy as np

import lissom
from lissom.drawing.live.shape import Shape
from lissom.drawing.report import symbols
from lissom.drawing.report.layers import Arrows
from lissom.model.views import view

FIELD = (0.0, 0.003, 0.004)


def robot(**options):
    rubber = lissom.Segment(
        0.05, 1e-3, 1e6, 4e5, 2000, {"bend_y": 4}, magnetisation=([0, 0.05], [[1e4, 0, 0], [3e4, 0, 0]])
    )
    plain = lissom.Segment(0.05, 1e-3, 1e6, 4e5, 2000, {"bend_y": 4})
    links = [
        lissom.Link("arm", rod=[plain, rubber]),
        lissom.Link("block", parent="arm", body=lissom.Body(0.01)),
    ]
    magnets = [
        lissom.Magnet((0.0, 0.0, 0.02), link="block", position=(0.0, 0.01, 0.0)),
        lissom.Magnet((0.01, 0.0, 0.0), at=0.05, link="arm"),
    ]
    return lissom.Robot(links, magnets=magnets, **options)


def drawn(model, q):
    shape = Shape(view(model), q, np.zeros_like(q), 0.0, np.zeros(len(model.inputs)))
    things = shape.things(q, np.zeros_like(q), 0.0, np.zeros(len(model.inputs)))
    (found,) = [thing for thing in things if thing.layer == "magnets"]
    assert isinstance(found, Arrows)
    return found, shape.stage.around


def test_arrows_go_through_magnets_from_south_to_north():
    model = robot()
    q = 0.1 * np.arange(1.0, model.n + 1)
    found, _ = drawn(model, q)
    assert found.names[:2] == ["magnet on block", "magnet on arm"]
    tails, vectors = found.tails[0], found.vectors[0]
    block, arm = model.pose(q, link="block"), model.pose(q, 0.05, link="arm")
    np.testing.assert_allclose(tails[0] + 0.5 * vectors[0], block[:3, 3] + 0.01 * block[:3, 1], atol=1e-12)
    np.testing.assert_allclose(tails[1] + 0.5 * vectors[1], arm[:3, 3], atol=1e-12)
    lengths = np.linalg.norm(vectors, axis=1)
    np.testing.assert_allclose(vectors[0] / lengths[0], block[:3, 2], atol=1e-12)
    np.testing.assert_allclose(vectors[1] / lengths[1], arm[:3, 0], atol=1e-12)
    # To scale: one has twice the moment of the other.
    np.testing.assert_allclose(lengths[0], 2.0 * lengths[1], rtol=1e-12)


def test_arrows_along_a_segment_have_its_magnetisation():
    model = robot()
    q = 0.1 * np.arange(1.0, model.n + 1)
    found, _ = drawn(model, q)
    assert found.names[2:] == ["magnetisation of arm"] * 3
    vectors = found.vectors[0][2:]
    X = 0.05 * (1.0 + np.array([1, 3, 5]) / 6.0)
    axes = model.pose(q, X, link="arm")[:, :3, 0]
    lengths = np.linalg.norm(vectors, axis=1)
    np.testing.assert_allclose(vectors / lengths[:, None], axes, atol=1e-12)
    np.testing.assert_allclose(lengths / lengths[-1], np.array([4.0, 6.0, 8.0]) / 8.0, rtol=1e-12)


def test_a_constant_field_is_drawn_with_its_size():
    model = robot(field=FIELD)
    _, around = drawn(model, np.zeros(model.n))
    (field,) = [thing for thing in around if thing.layer == "field"]
    assert field.names == ["field: 0.005 T"] * 2
    direction = field.vectors[0] / np.linalg.norm(field.vectors[0], axis=1)[:, None]
    np.testing.assert_allclose(direction, [[0.0, 0.6, 0.8]] * 2, atol=1e-12)
    assert {"magnets", "field"} <= set(symbols.LEGEND)
    # One that varies has no arrow that stays.
    varying = robot(field=lissom.Input("B", FIELD))
    _, around = drawn(varying, np.zeros(varying.n))
    assert {thing.layer for thing in around} == {"gravity"}


def test_robots_without_magnets_have_no_layer_of_them():
    model = lissom.Rod([lissom.Segment(0.05, 1e-3, 1e6, 4e5, 2000, {"bend_y": 4})])
    glyphs = view(model).glyphs
    assert not glyphs.magnets
    assert not any(glyphs.field)
    assert symbols.magnets.magnets(glyphs.magnets, None) == []
