"""`Model.to_scene` and `Scene.save`: models made in Python as scene files."""

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import lissom
from lissom import Body, Contact, Free, Link, Load, Loop, Motor, Prismatic, Revolute, Robot, Spherical

ROOT = Path(__file__).parents[3]
SCENES = sorted((ROOT / "scenes").glob("*.toml"))
PARTS = ("gravity", "links", "base_motion", "fluid", "loops", "contacts")
OF_LINKS = ("loads", "bodies", "supports")
KINDS = ("Tendon", "Chamber", "Motor", "ActiveStrain")

pytestmark = pytest.mark.filterwarnings("ignore::lissom.urdf.UrdfWarning")


def assert_same(found, model):
    assert type(found) is type(model)
    if isinstance(model, lissom.SpringPendulum):
        for key in ("length", "mass", "stiffness", "gravity"):
            assert getattr(found, key) == getattr(model, key)
        return
    for key in PARTS:
        one, other = getattr(found, key), getattr(model, key)
        assert np.array_equal(one, other) if key == "gravity" else one == other, key
    places = {link.name: i for i, link in enumerate(model.links)}
    for key in OF_LINKS:
        parts = sorted(getattr(model, key), key=lambda part: places.get(part.link, 0))
        assert [str(part) for part in getattr(found, key)] == [str(part) for part in parts], key
    actuators = sorted(model.actuators, key=lambda part: KINDS.index(type(part).__name__))
    assert list(found.actuators) == actuators
    if isinstance(model, lissom.Rod):
        assert found.segments == model.segments
        for key in ("base_position", "base_orientation", "tip_force", "tip_moment", "tip_mass"):
            assert_array_equal(getattr(found, key), getattr(model, key))


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_models_of_the_gallery_are_read_back_equal(path):
    scene = lissom.Scene.load(path)
    back = scene.model.to_scene(t_end=scene.simulation.t_end, q0=scene.q0, v0=scene.v0)
    assert_same(back.model, scene.model)
    assert_array_equal(back.q0, scene.q0)
    assert_array_equal(back.v0, scene.v0)
    # The text of a text is itself.
    again = back.model.to_scene(t_end=scene.simulation.t_end, q0=scene.q0, v0=scene.v0)
    assert again.text == back.text


def hose(name, **options):
    segment = lissom.Segment(0.4, 0.01, 1e6, 4e5, 1000.0, {"torsion": 1, "bend_y": 2, "bend_z": 2})
    return Link(name, rod=[segment], **options)


def gripper():
    """Parts in another order than that of scenes, and at all places."""
    times, lengths = [0.0, 1.0], [0.41, 0.39]
    links = [
        Link("carriage", joint=Prismatic((1, 0, 0), damping=2.0), body=Body(2.0, inertia=np.eye(3) * 1e-2)),
        hose("left", parent="carriage", joint=Revolute((0, 1, 0), stiffness=1.0)),
        hose(
            "right", parent="carriage", position=(0, 0.1, 0), orientation=(np.sqrt(0.5), 0, 0, np.sqrt(0.5))
        ),
        Link("ball", joint=Free(), body=Body(0.1, inertia=np.eye(3) * 1e-5), position=(0.2, 0, -0.5)),
        Link("camera", parent="left", at=0.1, body=Body(0.02), position=(0, 0, 0.02)),
    ]
    return Robot(
        links,
        gravity=(0, 1, -9.0),
        loads=[
            Load(link="right", force=(0, 0.1, 0), along=(0.1, 0.2)),
            Load(link="carriage", force=lissom.Harmonic(amplitude=(1, 0, 0), frequency=2.0)),
            Load(link="left", moment=([0.0, 0.5], [[0, 0, 0], [0, 0.01, 0]]), at=0.3, frame="body"),
        ],
        bodies=[Body(0.01, link="right", at=0.2), Body(0.03, link="carriage", centre=(0, 0, 0.1))],
        supports=[lissom.Support(link="left", at=0.2, stiffness=(1, 2, 3), position=(0.2, 0, 0))],
        actuators=[
            Motor("left", torque=lissom.Input("knee", 0.1)),
            lissom.Tendon("pull", [lissom.Along("left", (0, 0.005))], length=(times, lengths), stiffness=1e4),
            lissom.ActiveStrain("left", "bend_y", amount=lissom.Input("muscle")),
        ],
        loops=[Loop(("right", 0.4), ("ball", None, (0, 0, 0.1)), Spherical(), name="grip")],
        contacts=[
            Contact("left", lissom.Box((0, 0, -1), (1, 1, 0.1)), stiffness=1e4),
            Contact(lissom.Ball("ball", 0.05), lissom.HalfSpace((0, 0, -2)), stiffness=1e5),
        ],
        fluid=lissom.Fluid(1000.0, velocity=(0.1, 0, 0)),
        base_motion=lissom.BaseMotion(
            translation=([0, 1, 2, 3], [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0]])
        ),
    )


def test_robots_are_read_back_equal_and_move_alike(tmp_path):
    robot = gripper()
    scene = robot.to_scene(t_end=0.01, dt=1e-3, name="gripper", method="newmark")
    assert_same(scene.model, robot)
    assert scene.name == "gripper"
    assert sorted(scene.model.inputs) == sorted(robot.inputs)
    order = [robot.inputs.index(name) for name in scene.model.inputs]
    assert_allclose(scene.model.u0, robot.u0[order])
    q = np.random.default_rng(0).normal(size=(3, robot.n)) * 0.1
    found, expected = (model.inverse_dynamics(*q, t=0.3) for model in (scene.model, robot))
    assert_allclose(found, expected, rtol=1e-12, atol=1e-12 * abs(expected).max())
    file = tmp_path / "gripper.toml"
    scene.save(file)
    assert lissom.Scene.load(file).text == scene.text


BENT = lissom.Segment(
    0.3, (0.01, 0.005), 1e6, poisson_ratio=0.45, density=1100.0, modes={"bend_y": 2, "stretch": 1}, nodes=9
)
BOX = lissom.Segment(
    0.2,
    section=lissom.Section.rectangle(0.02, 0.01),
    young_modulus=1e6,
    shear_modulus=4e5,
    density=1000.0,
    modes={"bend_z": 2},
    retardation_time=0.01,
    reference_strain=(0.0, 1.0, 0.5, 1.0, 0.0, 0.0),
    basis="legendre",
)
#: Rods with defaults, poses, materials and parts.
RODS = {
    "defaults": {"segments": [BENT]},
    "materials": {"segments": [BENT, BOX], "gravity": (0, 1, 0)},
    "pose": {
        "segments": [BENT],
        "base_position": (0.1, -0.2, 0.3),
        "base_orientation": (np.sqrt(0.5), 0, np.sqrt(0.5), 0),
    },
    "tip": {"segments": [BOX], "tip_force": (0, 0, -1), "tip_moment": (0, 0.1, 0), "tip_mass": 0.02},
    "parts": {
        "segments": [BENT],
        "loads": [Load(force=(0, 0, -1), at=0.2), Load(moment=(0, 0.1, 0))],
        "bodies": [Body(0.01, at=0.1)],
        "contacts": [Contact("rod", lissom.HalfSpace((0, 0, -1)), stiffness=1e4)],
        "fluid": lissom.Fluid(1000.0),
        "actuators": [lissom.Tendon("pull", [lissom.Along("rod", (0, 0.003))], tension=1.0)],
    },
}


@pytest.mark.parametrize("name", RODS)
def test_rods_are_equal_by_what_describes_them(name):
    rod = lissom.Rod(**RODS[name])
    back = rod.to_scene().model
    for other in (lissom.Rod(**RODS[name]), back, copy.copy(rod), pickle.loads(pickle.dumps(rod))):
        assert other == rod
        assert hash(other) == hash(rod)
    assert rod != lissom.Rod(**RODS[name] | {"gravity": (0, 0, -1)})
    robot = Robot(rod.links)
    assert rod != robot
    assert robot == Robot(rod.links)
    assert robot.to_scene().model == robot
    assert rod != lissom.SpringPendulum()
    assert rod != "rod"


def test_pendulums_are_equal_by_their_numbers():
    pendulum = lissom.SpringPendulum(mass=2.0, gravity=0.0)
    assert pendulum.to_scene().model == pendulum == lissom.SpringPendulum(mass=2.0, gravity=-0.0)
    assert hash(pendulum) == hash(lissom.SpringPendulum(mass=2.0, gravity=-0.0))
    assert pendulum != lissom.SpringPendulum()


def test_what_files_cannot_hold_is_named():
    slider = Link("slider", joint=Prismatic((1, 0, 0)), body=Body(1.0))
    functions = {
        r"loads\[1\]: .*function of Python": {
            "loads": [Load(force=(0, 0, 1)), Load(force=lambda t: (t, 0, 0))]
        },
        r"actuators\[0\]: .*function": {"actuators": [Motor("slider", torque=lambda t: t)]},
        r"base_motion: .*function": {"base_motion": lissom.BaseMotion(translation=lambda t: (t, 0, 0))},
    }
    for message, parts in functions.items():
        with pytest.raises(ValueError, match=message):
            Robot([slider], **parts).to_scene()
    moved = Link("moved", joint=Prismatic((1, 0, 0), motion=np.sin), body=Body(1.0))
    with pytest.raises(ValueError, match=r"links\['moved'\]\.joint: .*function"):
        Robot([moved, Link("mass", joint=Prismatic((0, 1, 0)), body=Body(1.0))]).to_scene()
    with pytest.raises(ValueError, match="q0: expected 1 values, got 2"):
        Robot([slider]).to_scene(q0=[0, 1])
    with pytest.raises(TypeError, match="q0: expected a one-dimensional array of real numbers, got str"):
        Robot([slider]).to_scene(q0="up")
    with pytest.raises(
        TypeError, match=r"output\.every: expected a number, a text.*got builtin_function_or_method"
    ):
        Robot([slider]).to_scene(output={"every": max})
    with pytest.raises(TypeError, match="name: expected a str, got int"):
        Robot([slider]).to_scene(name=3)
    with pytest.raises(lissom.SceneError, match="t_and"):
        Robot([slider]).to_scene(t_and=3.0)


def test_imported_files_are_saved_beside(tmp_path):
    scene = lissom.Scene.load(ROOT / "scenes" / "arm.toml")
    file = tmp_path / "new" / "arm.toml"
    file.parent.mkdir()
    scene.save(file)
    back = lissom.Scene.load(file)
    assert back.text == scene.text
    assert back.imports == scene.imports
    scene.save(file)
    (file.parent / next(iter(scene.imports))).write_text("other", encoding="utf-8")
    with pytest.raises(FileExistsError, match="another file of this name"):
        scene.save(file)
    # The model of a URDF file needs no file.
    whole = scene.model.to_scene(q0=scene.q0)
    assert not whole.imports
    assert_same(whole.model, scene.model)


def test_layers_of_grids_are_saved_beside(tmp_path):
    places = np.stack(np.meshgrid(*[np.linspace(-1, 1, 33)] * 3, indexing="ij"), axis=-1)
    grid = lissom.DistanceGrid(np.linalg.norm(places, axis=-1)[:4] - 1.0, 0.1, (0, 0, -9))
    ball = Link("ball", joint=Free(), body=Body(0.2, inertia=1e-4 * np.eye(3)))
    model = Robot([ball], contacts=[Contact(lissom.Ball("ball", 0.02), grid, stiffness=1e3)])
    file = tmp_path / "grid.toml"
    model.to_scene(name="grid", t_end=0.1).save(file)
    assert len(list(tmp_path.iterdir())) == 5
    assert lissom.Scene.load(file).model == model


def on_a_hill(rows=40, columns=30):
    x, y = np.meshgrid(np.linspace(0, 3, rows), np.linspace(0, 2, columns), indexing="ij")
    hill = lissom.HeightField(0.1 * np.sin(x) * np.cos(y), spacing=0.05)
    times = np.linspace(0, 2, 1200)
    push = Load(force=(times, np.column_stack([np.sin(times), 0 * times, times])), link="ball")
    ball = Link("ball", joint=Free(), body=Body(0.2, inertia=1e-4 * np.eye(3)))
    return Robot([ball], contacts=[Contact(lissom.Ball("ball", 0.02), hill, stiffness=1e3)], loads=[push])


def test_large_arrays_are_saved_beside(tmp_path):
    model = on_a_hill()
    scene = model.to_scene(name="hill", t_end=0.1)
    file = tmp_path / "hill.toml"
    scene.save(file)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "hill-heights.csv",
        "hill-times.csv",
        "hill-values.csv",
        "hill.toml",
    ]
    text = file.read_text(encoding="utf-8")
    assert len(text) < 1000
    assert '{ file = "hill-heights.csv" }' in text
    assert_array_equal(np.loadtxt(tmp_path / "hill-heights.csv", delimiter=","), model.contacts[0].b.heights)
    back = lissom.Scene.load(file)
    assert_same(back.model, model)
    assert sorted(back.imports) == ["hill-heights.csv", "hill-times.csv", "hill-values.csv"]
    # What the file named before belongs to it; others stay.
    on_a_hill(rows=41).to_scene(name="hill", t_end=0.1).save(file)
    assert len(lissom.Scene.load(file).model.contacts[0].b.heights) == 41
    (tmp_path / "new-heights.csv").write_text("1 2\n", encoding="utf-8")
    with pytest.raises(FileExistsError, match=r"new-heights\.csv"):
        scene.save(tmp_path / "new.toml")
    assert not (tmp_path / "new.toml").exists()
    # Saved once more, with the files that are there.
    (tmp_path / "copy").mkdir()
    back.save(tmp_path / "copy" / "hill.toml")
    assert_same(lissom.Scene.load(tmp_path / "copy" / "hill.toml").model, model)
    assert_same(lissom.Scene.loads(back.text, imports=back.imports).model, model)
    assert_same(pickle.loads(pickle.dumps(back)).model, model)
    assert_same(copy.deepcopy(back).model, model)
    study = lissom.sweep(back, {"scene.gravity[2]": [-9.81, -1.62]}, t_end=0.01)
    assert study.status.values.tolist() == ["finished", "finished"]


def test_arrays_of_users_files(tmp_path):
    scene = """version = 1
[[link]]
name = "slider"
[link.joint]
type = "prismatic"
axis = [1, 0, 0]
motion = { times = { file = "t.txt" }, values = { file = "x.csv" } }
[[link]]
name = "ball"
joint = { type = "free" }
body = { mass = 1, inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }
[simulation]
t_end = 1.0
"""
    file = tmp_path / "scene.toml"
    file.write_text(scene, encoding="utf-8")

    def written(times, values):
        (tmp_path / "t.txt").write_bytes(times)
        (tmp_path / "x.csv").write_bytes(values)

    np.savetxt(tmp_path / "t.txt", [0.0, 0.5, 1.0], header="seconds")
    (tmp_path / "x.csv").write_text("\ufeff0\n\n1e-1\n0.3", encoding="utf-8")
    times, values = lissom.Scene.load(file).model.links[0].joint.motion[:2]
    assert_array_equal(times, [0, 0.5, 1])
    assert_array_equal(values, [0, 0.1, 0.3])
    for times, values, message in [
        (
            b"0\n1\n",
            b"0\nx1\n",
            r"x\.csv:2:1: got \"x1\"; expected a number: commas.*\n +\|\n2 \| x1\n  \| \^\^",
        ),
        (b"0\n1\n", b"0,0\n1,2,3\n", r"x\.csv:2:1: got 3 numbers; expected 2, as in the rows above"),
        (b"0\n1\n", b"0\n1,\n", r"x\.csv:2:3: got \"\"; expected a number"),
        (b"0\n1\n", b"\xff\n", "not text in UTF-8"),
        (b"0\n1\n", b"", "values"),
        (b"0,1\n2,3\n", b"0\n1\n", r"times"),
        (b"0\n-1\n", b"0\n1\n", r"scene\.toml:7:12: .*times"),
    ]:
        written(times, values)
        with pytest.raises(lissom.SceneError, match=message):
            lissom.Scene.load(file)
    (tmp_path / "x.csv").unlink()
    with pytest.raises(
        lissom.SceneError, match=r"motion\.values: .*No such file.*x\.csv.*; expected a file with rows"
    ):
        lissom.Scene.load(file)
    file.write_text(scene.replace("x.csv", "../x.csv"), encoding="utf-8")
    with pytest.raises(lissom.SceneError, match="leads out of the folder"):
        lissom.Scene.load(file)
    with pytest.raises(lissom.SceneError, match=r"none of the files in `imports`: \[\"t\.txt\"\]"):
        lissom.Scene.loads(scene, imports={"t.txt": b"0\n1\n"})
