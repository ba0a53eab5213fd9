"""Visuals in reports, figures, films, the live view and files of meshes."""

import json
import re
import struct

import numpy as np
import pytest

import lissom
from lissom.drawing import meshfiles, parts
from lissom.drawing.report import motion
from lissom.drawing.report.layers import Mesh, Solid, rotations
from lissom.drawing.report.visuals import creased, is_closed
from lissom.model import views
from lissom.model.visuals import MOST_TRIANGLES
from lissom.results.runs import Made
from lissom.urdf.pictures import prism, solid_of

RED = "#c81e28"


def arm():
    """A bar on a hinge, with a soft finger at its end."""
    bar = lissom.Body(0.2, centre=(0.1, 0, 0), inertia=np.diag([1e-5, 7e-4, 7e-4]))
    soft = lissom.Segment(0.1, 8e-3, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 2})
    links = [
        lissom.Link("bar", body=bar, joint=lissom.Revolute((0, 1, 0))),
        lissom.Link("finger", rod=[soft], parent="bar", position=(0.2, 0, 0)),
    ]
    return lissom.Robot(links)


@pytest.fixture(scope="module")
def swing():
    return lissom.simulate(arm(), 0.3, dt=5e-3)


def brick(link="bar", **options):
    points, faces = solid_of("box", (0.2, 0.02, 0.04))
    return lissom.Visual(link, points + np.array([0.1, 0, 0]), faces, **{"colour": RED, **options})


def test_reports_show_them_in_place_of_bodies(swing):
    run = Made(
        swing, swing.model, [brick(name="bar of aluminium"), brick("finger", colour=None, opacity=0.5)]
    )
    scene = motion.scene_of(run)
    own, of_rod = scene.of(Mesh)
    assert [(mesh.name, mesh.colour, mesh.opacity) for mesh in (own, of_rod)] == [
        ("bar of aluminium", RED, 1.0),
        ("finger", None, 0.5),
    ]
    assert not scene.of(Solid, "bodies")
    at = motion.frames(run)
    for mesh, link, X in ((own, "bar", None), (of_rod, "finger", 0.0)):
        poses = swing.pose(X, link=link)[at]
        np.testing.assert_allclose(mesh.centres, poses[:, :3, 3], atol=1e-12)
        np.testing.assert_allclose(rotations(mesh.turns), poses[:, :3, :3], atol=1e-12)
    assert "visuals" in scene.layers
    assert "bodies" not in scene.layers
    assert "visuals" in scene.in_words
    # The box of the view includes all corners of the mesh in all shapes.
    corners = mesh_corners(own)
    assert np.all(corners >= scene.low)
    assert np.all(corners <= scene.high)


def mesh_corners(mesh):
    return mesh.corners @ np.swapaxes(rotations(mesh.turns), 1, 2) + mesh.centres[:, None]


def test_what_the_player_reads_is_the_mesh(swing, tmp_path):
    """The numbers of the page, decoded as the player does."""
    path = tmp_path / "arm.html"
    swing.report(path, visuals=[brick()])
    assert path.stat().st_size < 600_000
    scene = motion.scene_of(Made(swing, swing.model, [brick()]))
    (mesh,) = scene.of(Mesh)
    from lissom.drawing.report.packing import encode

    numbers = mesh.numbers
    for name, expected, tolerance in (
        ("corners", mesh.corners, 2e-6),
        ("normals", mesh.normals, 4e-3),
        ("faces", mesh.faces, 0.4),
    ):
        kept = numbers[name]
        values, kind = (kept, "u2") if isinstance(kept, np.ndarray) else (kept.values, kept.type)
        content, (kind, shape, low, step) = encode(values, kind)
        size = int(kind[1])
        whole = np.frombuffer(content, np.uint8).reshape(size, -1).T.copy().view(f"<u{size}").reshape(shape)
        decoded = np.cumsum(whole.astype(np.int64), axis=0) % 256**size * np.asarray(step) + np.asarray(low)
        np.testing.assert_allclose(decoded, expected, atol=tolerance)


def test_the_page_holds_the_module_that_draws_them(swing, tmp_path):
    swing.report(tmp_path / "arm.html", visuals=[brick()])
    page = (tmp_path / "arm.html").read_text()
    assert "visualsModule" in page
    assert '"kind":"mesh"' in re.sub(r"\s", "", page)


def glb(content):
    size, _ = struct.unpack_from("<I4s", content, 12)
    return json.loads(content[20 : 20 + size])


def test_files_of_meshes_have_them_with_their_colours(swing, tmp_path):
    swing.save(tmp_path / "arm.glb", visuals=[brick(name="look")])
    tree = glb((tmp_path / "arm.glb").read_bytes())
    node = next(node for node in tree["nodes"] if node["name"] == "look")
    material = tree["materials"][tree["meshes"][node["mesh"]]["primitives"][0]["material"]]
    red = material["pbrMetallicRoughness"]["baseColorFactor"]
    np.testing.assert_allclose(red, [((200 / 255 + 0.055) / 1.055) ** 2.4, 0.012983, 0.021219, 1], atol=1e-5)
    assert "doubleSided" not in material
    moved = {channel["target"]["node"] for channel in tree["animations"][0]["channels"]}
    assert tree["nodes"].index(node) in moved
    # One instant: corners are where the pose of the link says.
    swing.save(tmp_path / "arm.obj", t=0.2, visuals=[brick(name="look")])
    lines = (tmp_path / "arm.obj").read_text().split("o look\n")[1].split("\no ")[0].splitlines()
    found = np.array([line.split()[1:] for line in lines if line.startswith("v ")], float)
    pose = swing.pose(link="bar")[np.searchsorted(swing.t, 0.2 - 1e-9)]
    expected = (brick().points) @ pose[:3, :3].T + pose[:3, 3]
    away = np.linalg.norm(found[:, None] - expected, axis=2).min(axis=1)
    assert away.max() < 1e-7
    swing.save(tmp_path / "arm.ply", t=0.2, visuals=[brick()])
    assert bytes([200, 30, 40]) in (tmp_path / "arm.ply").read_bytes()


def test_open_surfaces_are_seen_from_both_sides(swing, tmp_path):
    sheet = lissom.Visual("bar", [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0)], [(0, 1, 2)])
    swing.save(tmp_path / "arm.glb", visuals=[sheet])
    tree = glb((tmp_path / "arm.glb").read_bytes())
    (material,) = [each for each in tree["materials"] if each["name"] == "visuals"]
    assert material["doubleSided"]


def test_figures_films_and_equilibria(swing, tmp_path):
    pytest.importorskip("matplotlib")
    model = swing.model
    swing.picture(tmp_path / "a.svg", times=[0.1], visuals=[brick(colour="#00ff00")])
    swing.picture(tmp_path / "b.svg", times=[0.1])
    # Lit green surfaces have neither red nor blue.
    green = r"fill: #00[0-9a-f]{2}00"
    assert re.search(green, (tmp_path / "a.svg").read_text())
    assert not re.search(green, (tmp_path / "b.svg").read_text())
    swing.animate(tmp_path / "a.gif", fps=10, visuals=[brick()])
    rest = lissom.statics(model, q0=[np.pi / 2, 0, 0])
    rest.picture(tmp_path / "r.png", model, visuals=[brick()])
    rest.report(tmp_path / "r.html", model, visuals=[brick()])
    rest.save(tmp_path / "r.glb", model, visuals=[brick(name="look")])
    assert any(node["name"] == "look" for node in glb((tmp_path / "r.glb").read_bytes())["nodes"])
    modes = lissom.modes(model, rest.q)
    modes.report(tmp_path / "m.html", model, rest.q, visuals=[brick()])
    modes.animate(tmp_path / "m.gif", model, rest.q, fps=5, duration=0.4, visuals=[brick()])
    assert '"kind":"mesh"' in re.sub(r"\s", "", (tmp_path / "m.html").read_text())


def test_the_live_view_moves_their_nodes(swing):
    pytest.importorskip("viser")
    simulation = lissom.Simulation(arm(), dt=5e-3)
    with simulation.view(port=0, block=False, paused=True, visuals=[brick(name="look")]) as view:
        node = view._canvas._nodes["/visuals/look"]
        assert node.color == (200, 30, 40)
        assert not any(name.startswith("/bodies") for name in view._canvas._nodes)
        before = np.array(node.wxyz)
        q = np.array([0.5, 0.0, 0.0])
        view._canvas.draw(view._shape.things(q, 0 * q, 0.0, np.zeros(0)))
        turned = rotations(np.array(node.wxyz))
    np.testing.assert_allclose(turned, arm().pose(q, link="bar")[:3, :3], atol=1e-6)
    assert not np.allclose(before, node.wxyz)


def test_what_is_wrong_is_said_before_anything_is_written(swing, tmp_path):
    path = tmp_path / "x.html"
    for visuals, error, message in (
        (
            [brick("fingr")],
            ValueError,
            r"visuals\[0\].link: got 'fingr', which is no link of the model; did you mean 'finger'",
        ),
        ([brick("x")], ValueError, "expected one of bar, finger"),
        ([1], TypeError, r"visuals\[0\]: expected a Visual, got int"),
        (brick(), TypeError, "visuals: expected a sequence of Visual, got Visual"),
    ):
        with pytest.raises(error, match=message):
            swing.report(path, visuals=visuals)
        with pytest.raises(error, match=message):
            swing.save(tmp_path / "x.glb", visuals=visuals)
        assert not path.exists()
    points = np.random.default_rng(1).normal(size=(300, 3))
    faces = np.tile([[0, 1, 2]], (MOST_TRIANGLES // 2 + 1, 1))
    large = lissom.Visual("bar", points, faces)
    with pytest.raises(
        ValueError, match=f"visuals: {2 * len(faces)} triangles are more than {MOST_TRIANGLES}"
    ):
        swing.report(path, visuals=[large, large])
    with pytest.raises(ValueError, match="visuals: only files of meshes have it"):
        swing.save(tmp_path / "x.npz", visuals=[brick()])


def test_of_models_without_links_there_are_none(tmp_path):
    swing = lissom.simulate(lissom.SpringPendulum(), 0.1)
    with pytest.raises(ValueError, match="which is no link of the model; expected one of none"):
        swing.report(tmp_path / "x.html", visuals=[brick()])


def test_edges_are_sharp_where_sides_meet_and_smooth_on_round_walls():
    points, faces, normals = creased(*solid_of("box", (1, 2, 3)))
    # Three normals at each of eight corners, each along an axis.
    assert len(points) == 24
    np.testing.assert_allclose(np.sort(np.abs(normals), axis=1), np.tile([0, 0, 1], (24, 1)), atol=1e-15)
    outward = np.einsum("ij,ij->i", points, normals)
    assert np.all(outward > 0.0)
    points, faces, normals = creased(*prism(1.0, 2.0))
    # Two at each corner of a prism: one of the wall, one of the end.
    assert len(points) == 96
    is_wall = np.abs(normals[:, 2]) < 0.5
    radial = points[is_wall, :2] / np.linalg.norm(points[is_wall, :2], axis=1, keepdims=True)
    np.testing.assert_allclose(normals[is_wall, :2], radial, atol=1e-3)
    # The triangles are the same ones.
    a, b, c = (points[corner] for corner in faces.T)
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(2 * np.pi)
    points, faces, normals = creased(*solid_of("sphere", (1.0,)))
    assert len(points) == 290
    # Within a quarter of the angle between its circles.
    np.testing.assert_allclose(normals, points, atol=np.pi / 12 / 4)


def test_fans_of_many_triangles_take_no_long_time():
    count = 20_000
    angle = 2 * np.pi * np.arange(count) / count
    rim = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    points = np.concatenate([[[0, 0, 1.0]], rim])
    k = np.arange(count)
    faces = np.stack([0 * k, 1 + k, 1 + (k + 1) % count], axis=-1)
    corners, _, normals = creased(points, faces)
    assert len(corners) == count + 1
    np.testing.assert_allclose(normals[np.all(corners == [0, 0, 1], axis=1)], [[0, 0, 1]], atol=1e-6)


def test_closed_surfaces():
    for tag, sizes in (("box", (1, 1, 1)), ("sphere", (1,)), ("cylinder", (1, 2)), ("capsule", (1, 2))):
        points, faces = solid_of(tag, sizes)
        assert is_closed(points, faces)
        assert not is_closed(points, faces[1:])
        turned = faces.copy()
        turned[0] = turned[0, ::-1]
        assert not is_closed(points, turned)
        # Corners that are given once for each triangle are the same.
        assert is_closed(points[faces.reshape(-1)], np.arange(faces.size).reshape(-1, 3))


def test_views_without_visuals_are_as_they_were():
    model = arm()
    seen = views.drawn(model)
    assert [solid.name for solid in seen.solids] == ["bar"]
    assert not seen.visuals
    q = np.zeros((1, 3))
    found, _ = parts.parts(seen, q, q, np.zeros((1, 0)), np.zeros(1))
    assert {part.layer for part in found} == {"rods", "bodies"}
    assert meshfiles.WRITERS
