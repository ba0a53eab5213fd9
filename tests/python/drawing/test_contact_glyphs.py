"""Contacts in drawings and plots, and advice about impacts."""

from pathlib import Path

import numpy as np
import pytest

import lissom
from lissom import (
    Ball,
    Box,
    Capsule,
    Contact,
    ConvexMesh,
    DistanceGrid,
    Free,
    HalfSpace,
    HeightField,
    Link,
    Mesh,
    Robot,
    Sphere,
    Tube,
)
from lissom.analysis.advice import about_impacts, impact_time
from lissom.drawing.report import contacts, symbols
from lissom.drawing.report.layers import Arrows, Dots, DrawnStates, Line, Solid, Strand
from lissom.drawing.report.layers import Mesh as Mesh3d
from lissom.model.glyphs.contacts import contact_glyphs

SCENES = Path(__file__).parents[3] / "scenes"

LOW, HIGH = np.array([-1.0, -2.0, 0.0]), np.array([1.0, 2.0, 1.0])


def robot(*obstacles, ball=None):
    rubber = {"radius": 0.01, "young_modulus": 1e6, "poisson_ratio": 0.4, "density": 1000}
    rod = lissom.Segment(0.5, modes={"bend_y": 2, "bend_z": 1}, **rubber)
    found = [Contact("rod", obstacle, name=str(i)) for i, obstacle in enumerate(obstacles)]
    found += [Contact(ball, obstacles[0], stiffness=1e3, name="ball")] if ball else []
    return Robot([Link("rod", joint=Free(), rod=[rod])], contacts=found)


def drawn(made, q):
    q = np.asarray(q, float)
    at = np.zeros(len(q))
    shown = DrawnStates(q, 0.0 * q, np.zeros((len(q), 0)), at, at, 1.0, 0.01, 0.05)
    return contacts.contacts(contact_glyphs(made), shown, LOW, HIGH)


def test_a_floor_is_a_plate_whose_top_is_the_plane():
    floor = HalfSpace((0.3, 0.2, -0.1), (0.1, -0.2, 2.0))
    (plate,) = drawn(robot(floor), np.tile([0, 0, 5, 0, 0, 0, 0, 0, 0], (2, 1)))
    assert isinstance(plate, Solid)
    assert plate.layer == "obstacles"
    w, x, y, z = plate.turns[0]
    normal = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    np.testing.assert_allclose(normal, np.array(floor.normal) / np.linalg.norm(floor.normal), atol=1e-12)
    top = plate.centres[0] + plate.size[2] * normal
    assert (top - floor.point) @ normal == pytest.approx(0.0, abs=1e-12)
    # The plate extends below the complete box.
    assert plate.size[0] > 1.0
    assert plate.size[1] > 2.0


def test_fields_and_meshes_are_drawn_by_lines_on_them():
    heights = np.array([[0.0, 0.1, 0.3], [0.2, 0.0, 0.1]])
    turn = (0.8, 0.6, 0, 0)
    field = HeightField(heights, (0.5, 0.25), (1, 2, -3), turn)
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
    sharp, rounded = ConvexMesh(points, faces), ConvexMesh(points, faces, 0.1)
    things = drawn(robot(field, sharp, rounded), np.tile([0, 0, 5, 0, 0, 0, 0, 0, 0], (2, 1)))
    # The rod is below the continuation of the field, and is pushed.
    lines, edges, bars, pushes = things
    assert [type(thing) for thing in things] == [Line, Line, Strand, Arrows]
    assert pushes.layer == "contact"
    assert {thing.layer for thing in things[:3]} == {"obstacles"}
    assert bars.radius == [0.1]
    # What moves behind obstacles is seen.
    assert bars.opacity == contacts.OPACITY < 1.0
    # Every height twice: along its row and its column. The axes are turned about x by 2 acos(0.8).
    found = lines.points[0][~np.isnan(lines.points[0, :, 0])] - [1, 2, -3]
    assert len(found) == 12
    c, s = 0.8**2 - 0.6**2, 2 * 0.8 * 0.6
    wanted = [
        [0.5 * i, c * 0.25 * j - s * heights[i, j], s * 0.25 * j + c * heights[i, j]]
        for i in range(2)
        for j in range(3)
    ]
    np.testing.assert_allclose(found[:6], wanted, atol=1e-12)
    # Each of the six edges once, with breaks in between.
    for drawing in (edges, bars):
        ends = np.nan_to_num(drawing.points[0], nan=-1.0)
        pairs = {tuple(map(tuple, ends[k : k + 2])) for k in range(0, len(ends), 3)}
        assert len(pairs) == 6
        assert {end for pair in pairs for end in pair} == set(map(tuple, np.array(points, float)))


def test_grids_and_meshes_are_drawn_by_their_surfaces():
    places = np.stack(np.meshgrid(*[np.linspace(-1, 1, 41)] * 3, indexing="ij"), axis=-1)
    turn = (0.8, 0.6, 0, 0)
    ball = DistanceGrid(np.linalg.norm(places, axis=-1) - 0.7, 0.05, (1, 2, -3), turn)
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float) - [0, 0, 5]
    # Seen from inside: they are turned.
    inner = Mesh(points, [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
    made = robot(ball, inner)
    things = drawn(made, np.tile([0, 0, 5, 0, 0, 0, 0, 0, 0], (2, 1)))
    (sphere, tetrahedron) = (thing for thing in things if thing.layer == "obstacles")
    assert isinstance(sphere, Mesh3d)
    assert sphere.opacity == contacts.OPACITY < 1.0
    c, s = 0.8**2 - 0.6**2, 2 * 0.8 * 0.6
    middle = np.add([1, 2, -3], [1, c - s, c + s])
    np.testing.assert_allclose(np.linalg.norm(sphere.corners - middle, axis=1), 0.7, atol=2e-3)
    volumes = []
    for thing in (sphere, tetrahedron):
        assert not thing.is_open
        a, b, c = (thing.corners[corner] for corner in thing.faces.T)
        volumes.append(np.einsum("fi,fi->", a, np.cross(b, c)) / 6)
    np.testing.assert_allclose(volumes, [4 / 3 * np.pi * 0.7**3, 1 / 6], rtol=5e-3)
    # Functions with the same zeros have the same surface, however small they are.
    flat = DistanceGrid(1e-7 * (np.sum(places**2, axis=-1) - 0.49), 0.05, (1, 2, -3), turn)
    (drop,) = (thing for thing in drawn(robot(flat), np.zeros((1, 9))) if thing.layer == "obstacles")
    np.testing.assert_allclose(np.linalg.norm(drop.corners - middle, axis=1), 0.7, atol=2e-3)
    # A surface that crosses the border has an edge.
    half = DistanceGrid(places[..., 2] + 4.0 - 3.9, 0.05, (0, 0, -9))
    (cut,) = (thing for thing in drawn(robot(half), np.zeros((1, 9))) if thing.layer == "obstacles")
    assert cut.is_open
    np.testing.assert_allclose(cut.corners[:, 2], -8.1, atol=1e-5)


def test_tubes_are_drawn_around_their_smooth_centre_lines():
    points = np.array([(0, 0, -3), (1, 0.4, -3), (2, 0, -3)])
    made = robot(Tube(points, 0.3))
    (pipe,) = (
        thing
        for thing in drawn(made, np.tile([0, 0, 5, 0, 0, 0, 0, 0, 0], (2, 1)))
        if thing.layer == "obstacles"
    )
    assert isinstance(pipe, Strand)
    assert pipe.radius == [0.3]
    assert pipe.opacity == contacts.OPACITY < 1.0
    line = pipe.points[0]
    np.testing.assert_allclose(line[[0, -1]], points[[0, -1]], atol=1e-12)
    # The parabola through three points at equal distances.
    np.testing.assert_allclose(line[:, 1], 0.4 * line[:, 0] * (2 - line[:, 0]), atol=1e-12)
    assert len(line) > 8
    carried = Link("block", joint=Free(), body=lissom.Body(1.0, inertia=(1, 1, 1)))
    ball = Link("ball", joint=Free(), body=lissom.Body(1.0, inertia=(1, 1, 1)), position=(0, 0, 50))
    pair = Contact(Ball("ball", 0.1), Tube(points, 0.3, link="block"), stiffness=1e3)
    q = np.zeros((1, 12))
    q[0, :3] = [1, 2, 3]
    (moved,) = (
        thing for thing in drawn(Robot([carried, ball], contacts=[pair]), q) if thing.layer == "shapes"
    )
    np.testing.assert_allclose(moved.points[0], np.add(line, [1, 2, 3]), atol=1e-12)


def test_obstacles_and_balls_are_where_they_are():
    obstacles = [
        Sphere((0, 0, -1), 0.2),
        Capsule((0, 0, -2), (0, 1, -2), 0.1),
        Box((1, 0, -3), (0.1, 0.2, 0.3), (0.8, 0.6, 0, 0)),
    ]
    made = robot(*obstacles, ball=Ball("rod", 0.05, at=0.2, position=(0, 0, 0.03)))
    q = np.array([[0, 0, 0, 0, 0, 0, 0, 0, 0], [0.1, 0.2, 0.3, 0, 0, 0.5, 0.1, 0.2, 0.3]])
    sphere, rod, ends, box, ball = drawn(made, q)
    assert isinstance(sphere, Dots)
    assert isinstance(rod, Strand)
    assert isinstance(ends, Dots)
    assert isinstance(box, Solid)
    assert sphere.radius == 0.2
    np.testing.assert_array_equal(sphere.points, [[[0, 0, -1]]])
    np.testing.assert_array_equal(rod.points, [[[0, 0, -2], [0, 1, -2]]])
    assert rod.radius == [0.1]
    assert ends.radius == 0.1
    np.testing.assert_array_equal(box.centres, [[1, 0, -3]])
    np.testing.assert_array_equal(box.size, [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(box.turns, [[0.8, 0.6, 0, 0]])
    poses = made.pose(q, 0.2, link="rod")
    np.testing.assert_allclose(ball.points[:, 0], poses[:, :3, 3] + 0.03 * poses[:, :3, 2], atol=1e-15)
    assert {thing.layer for thing in (sphere, rod, ends, box, ball)} <= set(symbols.LEGEND)


def test_shapes_on_links_are_drawn_where_these_go():
    half = (0.1, 0.2, 0.3)
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
    shapes = [
        Box((0.5, 0, 0), half, link="block"),
        HalfSpace((0, 0, 0.1), link="block"),
        Sphere((0, 1, 0), 0.2, link="block"),
        Capsule((0, 0, 0), (0, 0, 1), 0.1, link="block"),
        ConvexMesh(points, faces, link="block"),
    ]
    block = Link("block", joint=Free(), body=lissom.Body(1.0, inertia=(1, 1, 1)))
    ball = Link("ball", joint=Free(), body=lissom.Body(1.0, inertia=(1, 1, 1)), position=(0, 0, 50))
    pairs = [Contact(Ball("ball", 0.1), shape, stiffness=1e3, name=str(i)) for i, shape in enumerate(shapes)]
    made = Robot([block, ball], contacts=pairs)
    q = np.zeros((2, 12))
    # A quarter turn about z, and a shift along x.
    q[1, :6] = [3, 0, 0, 0, 0, np.pi / 2]
    things = [thing for thing in drawn(made, q) if thing.layer == "shapes"]
    assert [type(thing) for thing in things] == [Solid, Solid, Dots, Strand, Dots, Strand]
    box, plate, sphere, bar, _, edges = things
    np.testing.assert_allclose(box.centres, [[0.5, 0, 0], [3, 0.5, 0]], atol=1e-12)
    np.testing.assert_allclose(np.abs(box.turns[1]), np.sqrt([0.5, 0, 0, 0.5]), atol=1e-12)
    np.testing.assert_allclose(box.size, half)
    np.testing.assert_allclose(plate.centres[:, 2] + plate.size[2], 0.1)
    np.testing.assert_allclose(sphere.points[:, 0], [[0, 1, 0], [2, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(bar.points[1], [[3, 0, 0], [3, 0, 1]], atol=1e-12)
    assert edges.points.shape[0] == 2
    assert contact_glyphs(made).pairs[0].between == "a ball on ball and a box on block"


def test_arrows_point_where_what_touches_is_pushed():
    made = robot(HalfSpace((0, 0, 0), (0, 0, 1)))
    high, low = np.zeros(9), np.zeros(9)
    high[2], low[2] = 0.5, 0.009
    things = drawn(made, [high, low])
    arrows = [thing for thing in things if isinstance(thing, Arrows)]
    assert len(arrows) == 1
    assert arrows[0].layer in symbols.LEGEND
    np.testing.assert_array_equal(arrows[0].vectors[0], 0.0)
    up = arrows[0].vectors[1]
    assert 1 <= len(up) <= contacts.MOST_ARROWS
    assert np.all(up[:, 2] > 0.0)
    np.testing.assert_array_equal(up[:, :2], 0.0)
    # No arrows without contact.
    assert not [thing for thing in drawn(made, [high]) if isinstance(thing, Arrows)]


def test_merged_arrows_keep_the_force():
    made = robot(HalfSpace((0, 0, 0), (0, 0, 1)))
    q = np.zeros(9)
    q[2] = 0.009
    touches = made.touches(q)
    assert len(touches) > contacts.MOST_ARROWS
    merged = contacts._merged(touches)
    assert len(merged) == contacts.MOST_ARROWS
    whole = contact_glyphs(made).pairs[0].force(q[None], 0.0 * q[None], np.zeros(1))
    np.testing.assert_allclose(merged[:, 1].sum(axis=0), whole[0], rtol=1e-12)


def test_reports_of_scenes_with_contact_plot_its_force(tmp_path):
    made = lissom.Scene.load(SCENES / "falling_rod.toml")
    motion = made.run(t_end=0.3, t_eval=None)
    path = tmp_path / "report.html"
    lissom.drawing.report.write_result(motion, path)
    page = path.read_text()
    for wanted in (
        "that the second surface of floor exerts",
        "that the second surface of peg exerts",
        "obstacles",
    ):
        assert wanted in page
    # A model without contacts has no such section.
    (single,) = [lissom.Segment(0.1, 0.01, 1e6, poisson_ratio=0.4, density=1000, modes={"bend_y": 1})]
    lissom.drawing.report.write_result(lissom.simulate(lissom.Rod([single]), 0.05), path)
    assert "that the second surface of" not in path.read_text()


TEXT = (SCENES / "falling_rod.toml").read_text()


def test_steps_that_do_not_resolve_an_impact_are_advised():
    made = lissom.Scene.loads(TEXT)
    assert about_impacts(made) == []
    # The law k d with a mass m: half a period at sqrt(k / m).
    contact = made.model.contacts[0]
    stiffness = np.pi / 4 * 2e5 / (1 - 0.45**2)
    mass = 1000 * np.pi * 0.012**2
    assert impact_time(made.model, contact) == pytest.approx(np.pi * np.sqrt(mass / stiffness), rel=1e-12)
    (said,) = about_impacts(lissom.Scene.loads(TEXT.replace("dt = 1e-3", "dt = 2e-3")))
    assert "'floor'" in said
    assert "0.0016 s" in said
    # Methods with adaptive steps resolve impacts.
    radau = TEXT.replace("dt = 1e-3", 'dt = 2e-3\nmethod = "radau"')
    assert about_impacts(lissom.Scene.loads(radau)) == []


def test_stiff_contact_is_advised_by_its_own_stiffness():
    text = TEXT.replace("friction = 0.2", "friction = 0.2\nstiffness = 1e8")
    (said,) = about_impacts(lissom.Scene.loads(text))
    assert "'peg'" in said
