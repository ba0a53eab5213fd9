"""Files of meshes, read back: glTF by a small reader here and by trimesh, PLY and OBJ by trimesh.

The reader follows the specification (glTF 2.0, sections 3.6, 3.7, 3.11) and shares nothing with the writer.
"""

import itertools
import json
import struct

import h5py
import numpy as np
import pytest
import trimesh

import lissom
from lissom.drawing import paraview

MATERIAL = {"young_modulus": 2e6, "poisson_ratio": 0.4, "density": 1000.0}

#: From the axes of the file, where y is up, to those of the world, where z is.
FROM_FILE = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])

#: Corners of drawn sections.
CORNERS = 24

#: Smallest share of the area of a disc that a polygon of so many corners has.
SHARE = CORNERS / (2 * np.pi) * np.sin(2 * np.pi / CORNERS)


#: Constants of the format.
COMPONENTS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
SIZES = {"SCALAR": (), "VEC3": (3,), "VEC4": (4,), "MAT4": (4, 4)}


class Gltf:
    """A binary file."""

    def __init__(self, path):
        content = path.read_bytes()
        magic, version, length = struct.unpack("<4sII", content[:12])
        assert (magic, version, length) == (b"glTF", 2, len(content))
        size, kind = struct.unpack("<I4s", content[12:20])
        assert (kind, size % 4) == (b"JSON", 0)
        self.tree = json.loads(content[20 : 20 + size])
        start = 20 + size
        size, kind = struct.unpack("<I4s", content[start : start + 8])
        assert (kind, size) == (b"BIN\0", self.tree["buffers"][0]["byteLength"])
        self.binary = content[start + 8 :]
        assert len(self.binary) == size
        self.nodes = self.tree["nodes"]

    def read(self, number):
        """The numbers of an accessor."""
        accessor = self.tree["accessors"][number]
        view = self.tree["bufferViews"][accessor["bufferView"]]
        shape = (accessor["count"], *SIZES[accessor["type"]])
        kind = np.dtype(COMPONENTS[accessor["componentType"]])
        start = view["byteOffset"] + accessor["byteOffset"]
        assert start % kind.itemsize == 0
        assert accessor["byteOffset"] + int(np.prod(shape)) * kind.itemsize <= view["byteLength"]
        values = np.frombuffer(self.binary, kind, int(np.prod(shape)), start).reshape(shape)
        if "min" in accessor:
            np.testing.assert_array_equal(np.reshape(values, (len(values), -1)).min(axis=0), accessor["min"])
            np.testing.assert_array_equal(np.reshape(values, (len(values), -1)).max(axis=0), accessor["max"])
        return values

    def times(self):
        (animation,) = self.tree["animations"]
        (number,) = {sampler["input"] for sampler in animation["samplers"]}
        return self.read(number).astype(float)

    def at(self, k):
        """Poses of all nodes at the k-th time of the animation."""
        own = [self.own(node) for node in self.nodes]
        moved = {}
        for animation in self.tree.get("animations", []):
            for channel in animation["channels"]:
                sampler, target = animation["samplers"][channel["sampler"]], channel["target"]
                moved.setdefault(target["node"], {})[target["path"]] = self.read(sampler["output"])[k]
        for node, values in moved.items():
            own[node] = self.own(self.nodes[node] | values)
        poses = {}

        def place(node, above):
            poses[node] = above @ own[node]
            for child in self.nodes[node].get("children", []):
                place(child, poses[node])

        for root in self.tree["scenes"][0]["nodes"]:
            place(root, np.eye(4))
        return poses

    @staticmethod
    def own(node):
        if "matrix" in node:
            return np.reshape(node["matrix"], (4, 4)).T.astype(float)
        x, y, z, w = np.array(node.get("rotation", (0, 0, 0, 1)), float)
        assert x * x + y * y + z * z + w * w == pytest.approx(1.0, abs=1e-6)
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        pose = np.eye(4)
        pose[:3, :3] = np.eye(3) + 2 * w * cross + 2 * cross @ cross
        pose[:3, 3] = node.get("translation", (0, 0, 0))
        return pose

    def meshes(self, k=0):
        """Vertices in the world and triangles by name, at the k-th time."""
        poses, found = self.at(k), {}
        for number, node in enumerate(self.nodes):
            if "mesh" not in node:
                continue
            mesh = self.tree["meshes"][node["mesh"]]
            (primitive,) = mesh["primitives"]
            attributes = primitive["attributes"]
            points = self.read(attributes["POSITION"]).astype(float)
            normals = self.read(attributes["NORMAL"]).astype(float)
            if "skin" in node:
                skin = self.tree["skins"][node["skin"]]
                # Written columns first.
                inverse = np.swapaxes(self.read(skin["inverseBindMatrices"]).astype(float), 1, 2)
                carried = np.array([poses[joint] for joint in skin["joints"]]) @ inverse
                weights = self.read(attributes["WEIGHTS_0"]) / 255.0
                np.testing.assert_array_equal(weights.sum(axis=1), 1.0)
                pose = np.einsum("vj,vjab->vab", weights, carried[self.read(attributes["JOINTS_0"])])
            else:
                pose = np.broadcast_to(poses[number], (len(points), 4, 4))
            points = np.einsum("vab,vb->va", pose[:, :3, :3], points) + pose[:, :3, 3]
            normals = np.einsum("vab,vb->va", pose[:, :3, :3], normals)
            triangles = self.read(primitive["indices"]).reshape(-1, 3)
            assert mesh["name"] not in found
            found[mesh["name"]] = points @ FROM_FILE.T, triangles, normals @ FROM_FILE.T
        return found


def load(path):
    """The mesh of a file in the axes of the world, without its skins."""
    found = trimesh.load(path, process=False)
    mesh = found if isinstance(found, trimesh.Trimesh) else found.to_geometry()
    points = np.asarray(mesh.vertices)
    return (points @ FROM_FILE.T if path.suffix == ".glb" else points), mesh.faces


def segment(section=None, radius=0.01, length=0.3):
    size = {"radius": radius} if section is None else {"section": section}
    return lissom.Segment(length, **size, **MATERIAL, modes={"bend_y": 3, "bend_z": 2, "torsion": 1})


def everything(section=None):
    """A robot with everything that files of meshes show."""
    corner = np.array([(0, 2, 0), (0.1, 2, 0), (0, 2.1, 0), (0, 2, 0.1)])
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
    solids = [
        lissom.HalfSpace((0, 0, -3), (0, 0, 1)),
        lissom.Sphere((0.5, 1, 0), 0.2),
        lissom.Capsule((0, 1, 1), (0, 1.3, 1.2), 0.1),
        lissom.Box((1, 1, 0), (0.1, 0.2, 0.3), (np.cos(0.3), 0, 0, np.sin(0.3))),
        lissom.ConvexMesh(corner, faces),
        lissom.ConvexMesh(corner + np.array([0, 1, 0]), faces, 0.02),
        lissom.HeightField(0.01 * np.arange(12).reshape(3, 4) ** 0.5, (0.1, 0.2), (0, 4, 0)),
        lissom.Tube([(0, 6, 0), (0.3, 6, 0.1), (0.5, 6, 0)], 0.05),
    ]
    arm = lissom.Link("arm", rod=[segment(section), segment(section, length=0.2)])
    hand = lissom.Link(
        "hand",
        parent="arm",
        body=lissom.Body(0.05, centre=(0.03, 0, 0), inertia=np.diag([1e-5, 2e-5, 2.5e-5])),
    )
    ball = lissom.Ball("hand", 0.02, position=(0.03, 0, 0))
    return lissom.Robot(
        [arm, hand],
        actuators=[lissom.Tendon("pull", [lissom.Along("arm", (0.0, 0.006))], tension=1.5)],
        magnets=[lissom.Magnet((0.0, 0.3, 0.4), link="hand")],
        contacts=[
            *(lissom.Contact(ball, solid, stiffness=1e3, name=f"on {i}") for i, solid in enumerate(solids)),
            lissom.Contact(
                lissom.Box((0.03, 0, 0.1), (0.02, 0.01, 0.01), link="hand"),
                solids[0],
                stiffness=1e3,
                name="carried",
            ),
        ],
    )


def prism(side, radius):
    """Volume of a corner of a cube with balls around its points (Steiner): V + A r + M r² + 4/3 π r³."""
    area = 1.5 * side**2 + np.sqrt(3) / 2 * side**2
    # Half the lengths of the edges times the angles between the normals.
    edges = 0.5 * (3 * side * np.pi / 2 + 3 * np.sqrt(2) * side * (np.pi - np.arccos(1 / np.sqrt(3))))
    return side**3 / 6 + area * radius + edges * radius**2 + 4 / 3 * np.pi * radius**3


def merged(points, triangles):
    """A mesh without the copies of vertices at sharp edges."""
    found = trimesh.Trimesh(points, triangles, process=False)
    found.merge_vertices(merge_norm=True, merge_tex=True, digits_vertex=6)
    return found


@pytest.fixture(scope="module")
def motion():
    return lissom.simulate(everything(), 0.4, dt=4e-3)


@pytest.fixture(scope="module")
def saved(motion, tmp_path_factory):
    path = tmp_path_factory.mktemp("meshes") / "motion.glb"
    motion.save(path)
    return Gltf(path)


def test_sections_move_as_in_the_result(motion, saved):
    """Each ring of vertices is the section of `pose`, at each time, to 1e-6 of the length."""
    robot, t = motion.model, saved.times()
    assert (t[0], t[-1]) == (0.0, pytest.approx(0.4))
    at = np.array([np.argmin(np.abs(motion.t - each)) for each in t])
    np.testing.assert_allclose(motion.t[at], t, rtol=1e-6)
    X = np.concatenate([np.linspace(0, 0.3, 25), np.linspace(0.3, 0.5, 25)[1:]])
    moved = 0.0
    for k in range(0, len(t), 10):
        points, _, _ = saved.meshes(k)["arm"]
        rings = points[: len(X) * CORNERS].reshape(len(X), CORNERS, 3)
        poses = robot.pose(motion.q[at[k]], X, link="arm", t=motion.t[at[k]])
        own = np.einsum("kab,kca->kcb", poses[:, :3, :3], rings - poses[:, None, :3, 3])
        np.testing.assert_allclose(own[..., 0], 0.0, rtol=0, atol=5e-7)
        np.testing.assert_allclose(np.hypot(own[..., 1], own[..., 2]), 0.01, rtol=0, atol=5e-7)
        # Sections do not turn about the rod: the corners lie where they lay.
        angle = np.arctan2(own[..., 2], own[..., 1])
        np.testing.assert_allclose(angle, np.broadcast_to(angle[0], angle.shape), rtol=0, atol=1e-4)
        moved = max(moved, np.abs(poses[-1, :3, 3] - robot.pose(motion.q[0], link="arm")[:3, 3]).max())
    assert moved > 0.05


def test_bodies_balls_and_tendons_move_as_in_the_result(motion, saved):
    robot = motion.model
    at = np.array([np.argmin(np.abs(motion.t - each)) for each in saved.times()])
    for k in (0, 30, len(at) - 1):
        q, found = motion.q[at[k]], saved.meshes(k)
        pose = robot.pose(q, link="hand", t=motion.t[at[k]])
        centre = pose[:3, :3] @ [0.03, 0, 0] + pose[:3, 3]
        for name in ("hand", "ball of on 0"):
            points = found[name][0]
            # Poles and equator of a ball lie opposite to each other.
            np.testing.assert_allclose(0.5 * (points.min(axis=0) + points.max(axis=0)), centre, atol=2e-3)
        distance = np.linalg.norm(found["ball of on 0"][0] - centre, axis=1)
        np.testing.assert_allclose(distance, 0.02, rtol=0, atol=5e-7)
        inertia = trimesh.Trimesh(*found["hand"][:2]).moment_inertia
        principal = np.linalg.eigvalsh(inertia)
        np.testing.assert_allclose(principal / principal[0], [1.0, 2.0, 2.5], rtol=0.03)
        tip = robot.pose(q, link="arm", t=motion.t[at[k]])
        end = tip[:3, :3] @ [0, 0, 0.006] + tip[:3, 3]
        points = found["tendon pull"][0]
        assert np.linalg.norm(points - end, axis=1).min() < 5e-7


def test_surfaces_are_closed_and_show_their_outside(saved):
    """Also the normals, by which viewers shade."""
    for k in (0, 50):
        for name, (points, triangles, normals) in saved.meshes(k).items():
            mesh = merged(points, triangles)
            if name == "on 6":
                assert mesh.face_normals[:, 2].min() > 0.5
                continue
            if name == "on 7":
                # An open pipe through three points of a parabola, seen from outside.
                assert mesh.is_winding_consistent
                away = mesh.triangles_center - np.mean(points, axis=0)
                assert np.mean(np.einsum("fi,fi->f", mesh.face_normals, away) > 0.0) > 0.8
                continue
            assert mesh.is_watertight, name
            assert mesh.is_winding_consistent, name
            assert mesh.volume > 0.0, name
            np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-5)
            plain = trimesh.Trimesh(points, triangles, process=False)
            # Normals of corners belong to the sides of their triangles.
            facing = np.einsum("fi,fci->fc", plain.face_normals, normals[triangles])
            assert facing.min() > 0.5, name


def test_sizes_are_those_of_the_model(saved):
    found = {name: merged(*mesh[:2]) for name, mesh in saved.meshes(20).items()}
    ball = 4 / 3 * np.pi
    # Balls and rounds have a few percent less, boxes and flat faces are exact.
    exact = {
        "on 1": (ball * 0.2**3, 0.05),
        "on 2": (ball * 0.1**3 + np.pi * 0.1**2 * np.hypot(0.3, 0.2), 0.05),
        "on 3": (8 * 0.1 * 0.2 * 0.3, 1e-6),
        "on 4": (0.1**3 / 6, 1e-5),
        "on 5": (prism(0.1, 0.02), 1e-2),
        "a box on hand": (8 * 0.02 * 0.01 * 0.01, 1e-5),
    }
    for name, (volume, rtol) in exact.items():
        assert found[name].volume == pytest.approx(volume, rel=rtol), name
    np.testing.assert_allclose(found["on 2"].bounds, [[-0.1, 0.9, 0.9], [0.1, 1.4, 1.3]], atol=5e-3)
    # Rounded: edges and corners are 0.02 away from those without a radius.
    np.testing.assert_allclose(found["on 5"].bounds, [[-0.02, 2.98, -0.02], [0.12, 3.12, 0.12]], atol=1e-3)
    assert found["on 0"].bounds[1, 2] == pytest.approx(-3.0, abs=1e-5)


@pytest.mark.parametrize(
    ("section", "area"),
    [
        (lissom.Section.rectangle(0.03, 0.01), 3e-4),
        (lissom.Section.ellipse(0.02, 0.008), SHARE * np.pi * 0.02 * 0.008),
        (lissom.Section.hollow_circle(0.02, 0.015), SHARE * np.pi * (0.02**2 - 0.015**2)),
        (lissom.Section.circle(2e-5), SHARE * np.pi * 4e-10),
    ],
)
@pytest.mark.parametrize("suffix", [".ply", ".obj"])
def test_one_instant_has_the_true_sections(section, area, suffix, tmp_path):
    """Wires, too, which reports draw thicker than they are."""
    rod = lissom.Rod([segment(section)])
    result = lissom.simulate(rod, 0.02, dt=1e-3, q0=np.zeros(rod.n))
    result.save(tmp_path / f"x{suffix}", t=0.0)
    points, triangles = load(tmp_path / f"x{suffix}")
    mesh = merged(1e3 * points, triangles)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(1e9 * 0.3 * area, rel=1e-4)


@pytest.mark.parametrize("suffix", [".glb", ".ply", ".obj"])
def test_an_instant_between_states(suffix, tmp_path):
    rod = lissom.Rod([segment()])
    fine = lissom.simulate(rod, 0.2, dt=1e-3)
    coarse = lissom.simulate(rod, 0.2, dt=1e-3, t_eval=np.arange(0, 0.21, 0.02))
    path = tmp_path / f"x{suffix}"
    coarse.save(path, t=0.155)
    points, _ = load(path)
    tip = rod.pose(fine.q[155])[:3, 3]
    assert fine.t[155] == pytest.approx(0.155)
    far = points[np.linalg.norm(points - tip, axis=1) < 0.0101]
    np.testing.assert_allclose(far.mean(axis=0), tip, atol=2e-5)
    assert np.linalg.norm(rod.pose(coarse.q[8])[:3, 3] - tip) > 1e-3


def test_objects_have_the_names_of_parts(motion, tmp_path):
    motion.save(tmp_path / "x.obj", t=0.1)
    names = [line[2:] for line in (tmp_path / "x.obj").read_text().splitlines() if line.startswith("o ")]
    assert {"arm", "hand", "tendon_pull", "ball_of_on_0", "on_6", "a_box_on_hand"} <= set(names)
    assert len(set(names)) == len(names)


def test_an_equilibrium_is_a_mesh_without_motion(tmp_path):
    rod = lissom.Rod([segment()])
    rest = lissom.statics(rod)
    rest.save(tmp_path / "x.glb", rod)
    found = Gltf(tmp_path / "x.glb")
    assert "animations" not in found.tree
    points, _, _ = found.meshes()["rod"]
    X = np.linspace(0, 0.3, 25)
    rings = points[: 25 * CORNERS].reshape(25, CORNERS, 3)
    np.testing.assert_allclose(rings.mean(axis=1), rod.pose(rest.q, X)[:, :3, 3], rtol=0, atol=3e-7)
    with pytest.raises(ValueError, match=r"model: \.ply files show the model"):
        rest.save(tmp_path / "x.ply")


@pytest.mark.parametrize(
    ("gravity", "up"),
    [((0, 0, -9.81), 2), ((0, -9.81, 0), 1), ((-9.81, 0, 0), 0), ((0, 0, 9.81), 2), ((0, 0, 0), 2)],
)
def test_up_is_up(gravity, up, tmp_path):
    """In glTF y is up."""
    rod = lissom.Rod([segment()], gravity=gravity, base_position=(0.1, 0.2, 0.3))
    lissom.simulate(rod, 0.01).save(tmp_path / "x.glb", t=0.0)
    found = Gltf(tmp_path / "x.glb")
    turn = found.at(0)[0][:3, :3]
    assert np.linalg.det(turn) == 1.0
    sign = 1.0 if gravity[up] <= 0.0 else -1.0
    np.testing.assert_array_equal(turn @ (sign * np.eye(3)[up]), [0, 1, 0])


def test_what_no_file_of_meshes_holds(motion, tmp_path):
    rod = lissom.Rod([segment()])
    run = lissom.simulate(rod, 0.1)
    refused = [
        (lambda: run.save(tmp_path / "x.ply"), "t: .ply files show one instant"),
        (lambda: run.save(tmp_path / "x.obj", t=0.2), "t: 0.2 s is not within the motion, from 0 to 0.1 s"),
        (lambda: run.save(tmp_path / "x.glb", t=np.nan), "t: "),
        (lambda: run.save(tmp_path / "x.npz", t=0.1), "t: only files of meshes have it"),
        (lambda: lissom.statics(rod).save(tmp_path / "x.nc", rod, t=1.0), "t: only files of meshes have it"),
        (
            lambda: lissom.simulate(lissom.SpringPendulum(), 0.1).save(tmp_path / "x.glb"),
            "path: .glb files show rods and bodies",
        ),
        (
            lambda: lissom.newmark(lambda t, q, v, a: a + q, (0, 1), [1.0], [0.0], dt=0.1).save(
                tmp_path / "x.glb"
            ),
            "result: its model is not known",
        ),
    ]
    for call, message in refused:
        with pytest.raises(ValueError, match=message):
            call()
    with pytest.raises(TypeError, match="t: "):
        run.save(tmp_path / "x.glb", t="now")
    assert list(tmp_path.iterdir()) == []


class VtkHdf:
    """A file of PolyData over time, read as VTK File Formats describes it."""

    def __init__(self, path):
        with h5py.File(path) as file:
            root = file["VTKHDF"]
            assert root.attrs["Type"] == b"PolyData"
            steps = root["Steps"]
            self.t = steps["Values"][:]
            self.count = root["NumberOfPoints"][:]
            self.starts = steps["PointOffsets"][:]
            self.points = root["Points"][:]
            self.data = {name: values[:] for name, values in root["PointData"].items()}
            for name in self.data:
                np.testing.assert_array_equal(steps["PointDataOffsets"][name], self.starts)
                assert len(self.data[name]) == len(self.points)
            assert not np.any(steps["CellOffsets"])
            assert not np.any(steps["ConnectivityIdOffsets"])
            self.cells = {}
            for kind in ("Vertices", "Lines", "Polygons", "Strips"):
                offsets, of_all = root[kind]["Offsets"][:], root[kind]["Connectivity"][:]
                assert (root[kind]["NumberOfCells"][:] == len(offsets) - 1).all()
                assert (root[kind]["NumberOfConnectivityIds"][:] == len(of_all)).all()
                assert len(of_all) == offsets[-1]
                self.cells[kind] = [of_all[a:b] for a, b in itertools.pairwise(offsets)]

    def at(self, k):
        """Points of a time, and their data."""
        where = slice(self.starts[k], self.starts[k] + self.count[k])
        return self.points[where], {name: values[where] for name, values in self.data.items()}


def test_timelines_have_bodies_tendons_and_obstacles(motion, saved, tmp_path):
    """The same surfaces as the glTF file, and tendons as lines."""
    motion.save(tmp_path / "x.vtkhdf")
    found, robot = VtkHdf(tmp_path / "x.vtkhdf"), motion.model
    np.testing.assert_array_equal(found.t, motion.t)
    numbers = {name: k for k, name in enumerate(paraview.LAYERS)}
    rods, tendon = found.cells["Lines"]
    assert len(rods) == 49
    for k in (0, 40, 100):
        points, data = found.at(k)
        q, t = motion.q[k], motion.t[k]
        np.testing.assert_allclose(points[rods[-1]], robot.pose(q, link="arm", t=t)[:3, 3], rtol=1e-12)
        tip = robot.pose(q, link="arm", t=t)
        np.testing.assert_allclose(
            points[tendon[-1]], tip[:3, :3] @ [0, 0, 0.006] + tip[:3, 3], rtol=0, atol=1e-9
        )
        assert (data["layer"][tendon] == numbers["tendons"]).all()
        assert (data["radius"][tendon] > 0.0).all()
        assert np.isnan(data["curvature"][tendon]).all()
        triangles = np.array(found.cells["Polygons"])
        layer = data["layer"][triangles]
        assert (layer == layer[:, :1]).all()
        # By then the motion is at one of the times of both files.
        same = int(np.argmin(np.abs(saved.times() - t)))
        if abs(saved.times()[same] - t) > 1e-6:
            continue
        meshes = saved.meshes(same)
        for name, layers in (("hand", "bodies"), ("carried", "shapes"), ("on 1", "obstacles")):
            other = meshes.get(name, meshes.get("a box on hand"))[0]
            of_layer = points[np.unique(triangles[layer[:, 0] == numbers[layers]])]
            near = np.linalg.norm(of_layer[:, None] - other[None], axis=-1).min(axis=0)
            assert near.max() < 2e-6


def test_bodies_alone_have_a_timeline(tmp_path):
    """Rods were needed before."""
    swing = lissom.Link("bob", body=lissom.Body(1.0, centre=(0, 0, -0.5)), joint=lissom.Revolute((0, 1, 0)))
    result = lissom.simulate(lissom.Robot([swing]), 0.1, q0=[0.3])
    result.save(tmp_path / "x.vtkhdf")
    found = VtkHdf(tmp_path / "x.vtkhdf")
    assert found.cells["Lines"] == []
    centre = result.model.pose(result.q[-1], link="bob") @ [0, 0, -0.5, 1]
    points, _ = found.at(len(found.t) - 1)
    np.testing.assert_allclose(0.5 * (points.min(axis=0) + points.max(axis=0)), centre[:3], atol=1e-3)
    with pytest.raises(ValueError, match=r"\.vtkhdf files show rods and bodies"):
        lissom.simulate(lissom.SpringPendulum(), 0.1).save(tmp_path / "y.vtkhdf")
    with pytest.raises(ValueError, match=r"\.vtkhdf files are written of results of `simulate`"):
        lissom.statics(lissom.SpringPendulum()).save(tmp_path / "y.vtkhdf")
    assert not (tmp_path / "y.vtkhdf").exists()


def test_long_timelines_with_many_points_have_fewer_times(tmp_path, monkeypatch):
    result = lissom.simulate(lissom.Rod([segment()]), 0.4, dt=1e-3)
    monkeypatch.setattr(paraview, "MAX_POINTS", 2500)
    result.save(tmp_path / "x.vtkhdf")
    found = VtkHdf(tmp_path / "x.vtkhdf")
    assert (len(found.t), found.t[0], found.t[-1]) == (60, 0.0, result.t[-1])


def test_long_motions_have_as_many_times_as_reports(tmp_path):
    rod = lissom.Rod([segment()])
    lissom.simulate(rod, 1.0, dt=1e-3).save(tmp_path / "x.glb")
    assert len(Gltf(tmp_path / "x.glb").times()) == 61


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".glb", ".pdf"])
def test_rods_of_given_sections_without_inertia_are_drawn_thin(suffix, tmp_path):
    section = lissom.Section.given(stiffness=(0.01, 0.02, 0.02, 1e4, 1e4, 1e4), mass=0.1)
    cable = lissom.Rod([lissom.Segment(1.0, section=section, modes={"bend_y": 4})])
    found = lissom.statics(cable)
    path = tmp_path / f"cable{suffix}"
    if suffix == ".pdf":
        found.picture(path, cable)
    else:
        found.save(path, cable)
    assert path.stat().st_size > 1000
