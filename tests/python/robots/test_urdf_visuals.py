"""Visuals of URDF files: meshes in STL, OBJ and COLLADA, shapes, colours, and files that are refused."""

import io
import subprocess
import sys

import numpy as np
import pytest
import trimesh

import lissom
import lissom.urdf
from lissom.model.visuals import simplified

SIDES = np.array([0.1, 0.04, 0.02])
MATERIALS = '<material name="blue"><color rgba="0 0 1 0.5"/></material>'


def brick(scale=1.0):
    """A box of 0.1 x 0.04 x 0.02 m, in units of 1/scale metres."""
    return trimesh.creation.box(SIDES * scale)


def robot(visual, materials=""):
    return (
        f'<robot name="r">{materials}<link name="palm"><visual name="look">{visual}</visual></link></robot>'
    )


def mesh(name, more=""):
    origin = f'<origin xyz="1 0 0" rpy="0 0 {np.pi / 2:.17g}"/>'
    return f'{origin}<geometry><mesh filename="{name}" {more}/></geometry>'


@pytest.fixture
def read(tmp_path):
    """Reads a robot with a visual beside files."""

    def at(visual, files=(), materials="", folder="", **options):
        for name, content in dict(files).items():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_bytes(content)
        path = tmp_path / folder / "robot.urdf"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(robot(visual, materials))
        return lissom.urdf.read_urdf(path, **{"visuals": True, **options})

    return at


def collada(content, unit):
    """COLLADA content with another unit."""
    text = content.decode()
    assert "<up_axis>" in text
    return text.replace("<up_axis>", f'<unit name="of" meter="{unit}"/><up_axis>').encode()


def painted(colour):
    found = brick(100.0)
    material = trimesh.visual.material.PBRMaterial(baseColorFactor=colour)
    found.visual = trimesh.visual.TextureVisuals(material=material)
    return trimesh.exchange.dae.export_collada(found)


#: The box, turned by 90 degrees about z and moved to (1, 0, 0).
LOW, HIGH = np.array([0.98, -0.05, -0.01]), np.array([1.02, 0.05, 0.01])


@pytest.mark.parametrize(
    ("name", "content", "more"),
    [
        ("m.stl", lambda: brick().export(file_type="stl"), ""),
        ("m.STL", lambda: brick(1e3).export(file_type="stl"), 'scale="0.001 0.001 0.001"'),
        ("m.stl", lambda: brick().export(file_type="stl_ascii").encode(), ""),
        ("m.obj", lambda: brick(1e3).export(file_type="obj").encode(), 'scale="1e-3 1e-3 1e-3"'),
        ("m.dae", lambda: collada(painted([200, 30, 40, 255]), 0.01), ""),
        ("m.dae", lambda: collada(painted([200, 30, 40, 255]), 0.001), 'scale="10 10 -10"'),
    ],
)
def test_meshes_are_read_in_metres_and_placed_on_their_links(read, name, content, more):
    imported = read(mesh(name, more), {name: content()})
    (visual,) = imported.visuals
    assert (visual.link, visual.name, len(visual.faces)) == ("palm", "look", 12)
    np.testing.assert_allclose(visual.points.min(axis=0), LOW, atol=1e-9)
    np.testing.assert_allclose(visual.points.max(axis=0), HIGH, atol=1e-9)
    a, b, c = (visual.points[corner] for corner in visual.faces.T)
    # The outside is outside, also of mirrored meshes: the volume is positive.
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(np.prod(SIDES), rel=1e-6)
    assert visual.colour == ("#c81e28" if name == "m.dae" else None)
    assert not imported.not_taken
    assert "1 visual; everything was taken over" in str(imported)


SHAPES = {
    '<box size="0.1 0.04 0.02"/>': (8, 0.1 * 0.04 * 0.02, 1e-12),
    '<cylinder radius="0.1" length="0.5"/>': (48, np.pi * 0.01 * 0.5, 1e-12),
    # Polyhedra within smooth surfaces.
    '<sphere radius="0.2"/>': (290, 4 / 3 * np.pi * 0.008, 0.03),
    '<capsule radius="0.1" length="0.3"/>': (290, np.pi * 0.01 * (0.3 + 4 / 3 * 0.1), 0.03),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_shapes_become_closed_meshes(read, shape):
    (visual,) = read(f"<geometry>{shape}</geometry>").visuals
    corners, volume, tolerance = SHAPES[shape]
    found = trimesh.Trimesh(visual.points, visual.faces, process=False)
    assert len(visual.points) == corners
    assert found.is_watertight
    assert found.volume == pytest.approx(volume, rel=tolerance)


def test_colours_are_those_of_materials_here_or_of_the_robot(read):
    box = '<geometry><box size="1 1 1"/></geometry>'
    (own,) = read(f'{box}<material name="x"><color rgba="1 0.5 0 1"/></material>').visuals
    assert (own.colour, own.opacity) == ("#ff8000", 1.0)
    (named,) = read(f'{box}<material name="blue"/>', materials=MATERIALS).visuals
    assert (named.colour, named.opacity) == ("#0000ff", 0.5)
    (unknown,) = read(f'{box}<material name="green"/>', materials=MATERIALS).visuals
    assert unknown.colour is None
    dae = {"m.dae": painted([200, 30, 40, 255])}
    (over,) = read(f'{mesh("m.dae")}<material name="blue"/>', dae, MATERIALS).visuals
    assert over.colour == "#0000ff"


def test_packages_are_found_around_the_file_or_given(read, tmp_path):
    stl = brick().export(file_type="stl")
    visual = mesh("package://hand/meshes/m.stl")
    assert read(visual, {"hand/meshes/m.stl": stl}, folder="hand/urdf").visuals
    assert read(visual, {"hand/meshes/m.stl": stl}, folder="arm/urdf").visuals
    elsewhere = read(visual, {"other/meshes/m.stl": stl}, packages={"hand": tmp_path / "other"})
    assert elsewhere.visuals
    there = (tmp_path / "other/meshes/m.stl").as_uri()
    assert read(mesh(there)).visuals


def test_all_that_is_wrong_is_said_at_once_with_places(read):
    long = "0 0 -1"
    files = {
        "text.stl": b"<html>no mesh</html>",
        "cut.dae": painted([1, 2, 3, 255])[:900],
        "bomb.dae": b'<!DOCTYPE x [<!ENTITY a "aaaa">]><COLLADA>&a;</COLLADA>',
        "nan.obj": b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    }
    names = ("gone.stl", *files, "package://nobody/m.stl", "http://x/m.stl", "m.blend", "/dev/zero")
    visuals = "</visual><visual>".join(mesh(name) for name in names)
    visuals += "</visual><visual><geometry><mesh filename='text.stl' scale='0 1 1'/></geometry>"
    visuals += f"</visual><visual><geometry><box size='{long}'/></geometry>"
    visuals += "</visual><visual><geometry><box size='1 1 1'/></geometry>"
    visuals += "<material><color rgba='0 0 2 1'/></material>"
    with pytest.raises(lissom.urdf.UrdfError) as caught:
        read(visuals, files)
    reported = [str(problem) for problem in caught.value.problems]
    assert len(reported) == len(names) + 3
    for name, words in {
        "gone.stl": "which cannot be read: No such file or directory; expected a file of a mesh at /",
        "text.stl": "which has no triangles",
        "cut.dae": "which is no DAE file that can be read: ",
        "bomb.dae": "which is an archive or declares entities",
        "nan.obj": "which has no triangles",
        "nobody": 'and found no folder "nobody" with this file around /',
        "http": "which is no name of a file; expected package://, file:// or a path",
        "m.blend": "No such file",
        "/dev/zero": "not a regular file",
        "mesh@scale": 'got "0 1 1"; expected factors other than zero',
        "box": "got the sizes 0, 0, -1; expected positive ones",
        "rgba": 'got "0 0 2 1"; expected four numbers from 0 to 1',
    }.items():
        assert any(name in line and words in line for line in reported), (name, reported)
    assert all("robot/link[palm]/visual" in line for line in reported)


def test_files_beyond_the_limit_are_refused(read, monkeypatch):
    monkeypatch.setattr("lissom.urdf.pictures.LARGEST", 2**20)
    with pytest.raises(lissom.urdf.UrdfError, match="larger than 1 MiB"):
        read(mesh("m.stl"), {"m.stl": bytes(2**20 + 1)})


def test_large_meshes_are_simplified_and_listed(read):
    fine = trimesh.creation.icosphere(subdivisions=5, radius=0.1)
    assert len(fine.faces) == 20480
    imported = read(mesh("m.stl"), {"m.stl": fine.export(file_type="stl")})
    (visual,) = imported.visuals
    assert 2000 < len(visual.faces) <= 5000
    away = np.linalg.norm(visual.points - [1, 0, 0], axis=1)
    assert away.min() > 0.097
    assert away.max() < 0.1 + 1e-6
    (left,) = imported.not_taken
    assert left.what == "robot/link/visual/geometry/mesh"
    assert (
        left.reason == f"for pictures the mesh is simplified to {len(visual.faces)} triangles: it has 20480"
    )


@pytest.mark.parametrize("most", [1, 2, 12, 100, 5000])
def test_simplified_meshes_have_no_more_triangles_than_asked_for(most):
    fine = trimesh.creation.icosphere(subdivisions=4)
    points, faces = simplified(np.asarray(fine.vertices), np.asarray(fine.faces, np.int64), most)
    assert len(faces) <= most
    if len(faces):
        assert np.ptp(points, axis=0).max() <= 2.0 + 1e-9


def test_without_visuals_nothing_is_opened(read):
    imported = read(mesh("/dev/zero"), visuals=False)
    assert imported.visuals == ()
    assert imported.not_taken[0].reason == "only for pictures; read on request: give visuals=True"


def test_wrong_arguments(read, tmp_path):
    box = '<geometry><box size="1 1 1"/></geometry>'
    with pytest.raises(TypeError, match="visuals: expected True or False, got int"):
        read(box, visuals=1)
    with pytest.raises(TypeError, match="packages: expected a mapping of names to folders, got list"):
        read(box, packages=["x"])
    with pytest.raises(TypeError, match=r"packages\['x'\]: expected a str or a path, got int"):
        read(box, packages={"x": 1})


def test_what_reads_meshes_is_named_where_it_lacks(tmp_path):
    (tmp_path / "m.dae").write_bytes(b"")
    for module, name in (("trimesh", "m.stl"), ("collada", "m.dae")):
        (tmp_path / name).write_bytes(b"")
        code = (
            f"import sys; sys.modules[{module!r}] = None\nimport lissom\nlissom.read_visuals({name!r}, 'a')"
        )
        run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path)
        wanted = f"ImportError: {name[1:]} files need {module}: pip install 'lissom[meshes]'"
        assert wanted in run.stderr, run.stderr


def test_files_of_meshes_without_urdf(tmp_path):
    path = tmp_path / "brick.obj"
    path.write_text(brick(1e3).export(file_type="obj"))
    turn = (np.sqrt(0.5), 0, 0, np.sqrt(0.5))
    (visual,) = lissom.read_visuals(
        path, "palm", scale=1e-3, position=(1, 0, 0), orientation=turn, colour="#102030", opacity=0.5
    )
    assert (visual.name, visual.colour, visual.opacity) == ("brick", "#102030", 0.5)
    np.testing.assert_allclose(visual.points.min(axis=0), LOW, atol=1e-9)
    (few,) = lissom.read_visuals(path, "palm", scale=1e-3, max_triangles=4)
    assert len(few.faces) <= 4
    for options, message in (
        ({"scale": 0.0}, "scale: got 0, expected a finite number above zero"),
        ({"orientation": (1, 1, 0, 0)}, "orientation: got a quaternion of norm 1.41421"),
        ({"max_triangles": 0}, "max_triangles: got 0, expected at least 1"),
        ({"colour": "red"}, "colour: got 'red', expected a hexadecimal colour such as '#8090a0'"),
        ({"opacity": 0.0}, "opacity: got 0, expected a number above 0 and up to 1"),
        ({"position": (1, 2)}, "position: expected 3 values, got 2"),
    ):
        with pytest.raises(ValueError, match=message):
            lissom.read_visuals(path, "palm", **options)
    (tmp_path / "x.step").write_text("")
    with pytest.raises(ValueError, match=r"path: 'x.step' ends with .step, expected one of .stl, .obj, .dae"):
        lissom.read_visuals(tmp_path / "x.step", "palm")
    with pytest.raises(FileNotFoundError):
        lissom.read_visuals(tmp_path / "gone.stl", "palm")


def test_several_colours_of_a_file_are_several_visuals(tmp_path):
    scene = trimesh.Scene()
    for k, colour in enumerate(([200, 30, 40, 255], [10, 20, 30, 255])):
        part = brick()
        part.visual = trimesh.visual.TextureVisuals(
            material=trimesh.visual.material.PBRMaterial(baseColorFactor=colour)
        )
        scene.add_geometry(part, transform=trimesh.transformations.translation_matrix([k, 0, 0]))
    path = tmp_path / "two.dae"
    path.write_bytes(trimesh.exchange.dae.export_collada(list(scene.dump())))
    visuals = lissom.read_visuals(path, "palm")
    assert sorted(visual.colour for visual in visuals) == ["#0a141e", "#c81e28"]
    assert sum(len(visual.faces) for visual in visuals) == 24


def test_other_files_are_not_opened(tmp_path):
    (tmp_path / "m.obj").write_text("mtllib /dev/zero\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n")
    (visual,) = lissom.read_visuals(tmp_path / "m.obj", "palm")
    assert visual.colour is None


def test_damaged_files_are_refused_or_read(tmp_path):
    """Cut, and with other bytes: a ValueError, or a mesh of finite corners."""
    random = np.random.default_rng(1)
    whole = {
        ".stl": brick().export(file_type="stl"),
        ".obj": brick().export(file_type="obj").encode(),
        ".dae": painted([1, 2, 3, 255]),
    }
    refused = 0
    for suffix, content in whole.items():
        for _ in range(60):
            damaged = bytearray(content[: random.integers(len(content)) + 1])
            for place in random.integers(len(damaged), size=3):
                damaged[place] = random.integers(256)
            path = tmp_path / f"m{suffix}"
            path.write_bytes(damaged)
            try:
                visuals = lissom.read_visuals(path, "palm")
            except ValueError:
                refused += 1
            else:
                assert all(np.isfinite(visual.points).all() for visual in visuals)
    assert refused > 30


def test_visuals_say_what_is_wrong_with_them():
    corners = np.eye(3)
    for arguments, message in (
        ((corners, [(0, 1, 3)]), "faces: got the corner 3, expected 0 to 2"),
        ((corners, [(0, 1, -1)]), "faces: got the corner -1, expected 0 to 2"),
        ((corners * np.nan, [(0, 1, 2)]), "points: expected finite numbers"),
        (
            (corners[:, :2], [(0, 1, 2)]),
            r"points: expected an array of real numbers of shape \(n, 3\), got \(3, 2\)",
        ),
        ((corners, []), r"faces: expected an array of whole numbers of shape \(n, 3\), got \(0,\)"),
    ):
        with pytest.raises(ValueError, match=message):
            lissom.Visual("palm", *arguments)
    with pytest.raises(TypeError, match="faces: expected an array of whole numbers, got float64"):
        lissom.Visual("palm", corners, [(0.0, 1.0, 2.0)])
    assert (
        io.StringIO(repr(lissom.Visual("palm", corners, [(0, 1, 2)]))).read() == "Visual('palm', 1 triangles)"
    )


def stl(content):
    return b"\0" * 80 + content


@pytest.mark.parametrize(
    ("suffix", "content", "words"),
    [
        (".stl", b"", "is empty"),
        (".obj", b" \n", "is empty"),
        (".stl", b"version https://git-lfs.github.com/spec/v1\noid sha256:4\n", "is a pointer of Git LFS"),
        (".stl", stl(b"\x05\0\0\0" + b"\0" * 60), "has room for 1 triangles, its head says 5"),
        (".obj", b"v 0 0 0\nf 1 2 3\n", "a triangle names a corner that is missing"),
        (".obj", b"v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n", "has a corner 1e+300 m from its origin"),
    ],
)
def test_damaged_meshes_say_what_is_wrong(tmp_path, suffix, content, words):
    file = tmp_path / f"mesh{suffix}"
    file.write_bytes(content)
    with pytest.raises(ValueError, match=r"^path: 'mesh") as caught:
        lissom.read_visuals(file, "hand")
    assert words in str(caught.value)
