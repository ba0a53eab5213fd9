"""`[import]` in scenes: the links of a URDF file, and errors in it."""

import json
import os
import pickle
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import lissom
from lissom.urdf import UrdfWarning

SCENES = Path(__file__).parents[3] / "scenes"

URDF = """<robot name="arm">
  <link name="base"/>
  <link name="hand">
    <inertial><origin xyz="0.1 0 0"/><mass value="0.5"/>
      <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="wrist" type="revolute"><parent link="base"/><child link="hand"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1"/></joint>
</robot>
"""

SCENE = """version = 1
[import]
urdf = "arm.urdf"
limit_stiffness = 100
q0 = [0.3]
[[link]]
name = "finger"
parent = "hand"
position = [0.2, 0, 0]
[[link.load]]
force = [0, 0.1, 0]
[[link.rod.segment]]
length = 0.1
radius = 5e-3
young_modulus = 1e6
poisson_ratio = 0.5
density = 1000
modes = { bend_y = 2, bend_z = 1 }
[simulation]
t_end = 0.05
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "arm.urdf").write_text(URDF, encoding="utf-8")
    (tmp_path / "arm.toml").write_text(SCENE, encoding="utf-8")
    return tmp_path


def run(*arguments, cwd):
    return subprocess.run(
        [sys.executable, "-m", "lissom", *arguments], cwd=cwd, capture_output=True, text=True, check=False
    )


def test_a_scene_is_the_robot_that_python_would_make(folder):
    scene = lissom.Scene.load(folder / "arm.toml")
    imported = lissom.urdf.read_urdf(folder / "arm.urdf", limit_stiffness=100)
    finger = lissom.Link(
        "finger",
        parent="hand",
        position=(0.2, 0, 0),
        rod=[
            lissom.Segment(0.1, 5e-3, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 2, "bend_z": 1})
        ],
    )
    load = lissom.Load(force=(0, 0.1, 0), link="finger")
    robot = lissom.Robot([*imported.links, finger], loads=[load])
    assert scene.model.links == robot.links
    np.testing.assert_array_equal(scene.q0, [0.3, 0, 0, 0])
    zero = np.zeros(4)
    np.testing.assert_array_equal(
        scene.model.inverse_dynamics(scene.q0, zero, zero), robot.inverse_dynamics(scene.q0, zero, zero)
    )
    assert scene.imports == {"arm.urdf": URDF.encode()}
    assert scene.run().success


def test_the_file_is_seen_from_the_folder_of_the_scene(folder, monkeypatch):
    with pytest.raises(lissom.SceneError, match="cannot be read") as caught:
        lissom.Scene.loads(SCENE)
    assert [problem.key for problem in caught.value.problems] == ["import.urdf"]
    scene = lissom.Scene.loads(SCENE, str(folder / "other.toml"))
    monkeypatch.chdir(folder)
    assert lissom.Scene.loads(SCENE).model.links == scene.model.links


def test_a_pickled_scene_needs_the_file_no_more(folder):
    scene = lissom.Scene.load(folder / "arm.toml")
    text = pickle.dumps(scene)
    shutil.rmtree(folder)
    again = pickle.loads(text)
    assert again.imports == scene.imports
    np.testing.assert_array_equal(again.q0, scene.q0)
    np.testing.assert_array_equal(again.run().q, scene.run().q)


def test_what_is_not_taken_over_is_a_warning(folder):
    (folder / "arm.toml").write_text(SCENE.replace("limit_stiffness = 100\n", ""), encoding="utf-8")
    with pytest.warns(UrdfWarning, match=r"arm\.urdf.*not taken over:\n.*limit") as caught:
        lissom.Scene.load(folder / "arm.toml")
    assert len(caught) == 1
    checked = run("check", "arm.toml", cwd=folder)
    assert checked.returncode == 0, checked.stderr
    assert "limit" in checked.stderr
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        (folder / "arm.toml").write_text(SCENE, encoding="utf-8")
        lissom.Scene.load(folder / "arm.toml")


def test_problems_of_the_file_stand_among_those_of_the_scene(folder):
    bad = URDF.replace('value="0.5"', 'value="heavy"').replace('link="base"', 'link="bas"')
    (folder / "arm.urdf").write_text(bad, encoding="utf-8")
    (folder / "arm.toml").write_text(SCENE.replace("radius = 5e-3", "radius = -1"), encoding="utf-8")
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.load(folder / "arm.toml")
    found = [(Path(problem.file).name, problem.line, problem.key) for problem in caught.value.problems]
    assert found == [
        ("arm.urdf", 4, "robot/link[hand]/inertial/mass@value"),
        ("arm.urdf", 7, "robot/joint[wrist]/parent@link"),
        ("arm.toml", 14, "link[0].rod.segment[0].radius"),
    ]
    assert "did you mean" in caught.value.problems[1].right
    assert 'link="bas"' in caught.value.problems[1].snippet
    checked = run("check", "arm.toml", cwd=folder)
    assert checked.returncode == 2
    assert "arm.urdf:4:" in checked.stderr


def test_results_keep_the_file(folder):
    done = run("run", "arm.toml", "-o", "results", "--no-report", cwd=folder)
    assert done.returncode == 0, done.stderr
    kept = folder / "results" / "trajectory.nc"
    if kept.exists():
        import xarray

        with xarray.open_dataset(kept, engine="h5netcdf") as data:
            text, imports = data.attrs["scene"], data.attrs["imports"]
    else:
        with np.load(folder / "results" / "trajectory.npz") as data:
            text, imports = str(data["scene"]), str(data["imports"])
    assert text == SCENE
    assert json.loads(imports) == {"arm.urdf": URDF}
    done = run("modes", "arm.toml", "-o", "modes", "--no-report", cwd=folder)
    assert done.returncode == 0, done.stderr
    with np.load(folder / "modes" / "modes.npz") as data:
        assert json.loads(str(data["imports"])) == {"arm.urdf": URDF}


def test_the_shipped_arm_is_good():
    with pytest.warns(UrdfWarning, match="limit@effort"):
        scene = lissom.Scene.load(SCENES / "arm.toml")
    assert scene.model.coordinates[:3] == ("upper.angle", "fore.angle", "left.displacement")
    assert scene.q0[2] == 0.02
    assert lissom.simulate(scene.model, 0.1, q0=scene.q0, v0=scene.v0, dt=2e-3).success


def test_results_keep_files_in_any_encoding_and_links_with_any_name(folder):
    text = URDF.replace("<robot", '<?xml version="1.0" encoding="iso-8859-1"?>\n<robot').replace(
        "hand", "hän/d"
    )
    (folder / "arm.urdf").write_bytes(text.encode("latin-1"))
    scene = SCENE.replace('"hand"', '"hän/d"').replace('"finger"', '"finger/1"')
    (folder / "arm.toml").write_text(scene, encoding="utf-8")
    done = run("run", "arm.toml", "-o", "results", "--no-report", cwd=folder)
    assert done.returncode == 0, done.stderr
    import xarray

    with xarray.open_dataset(folder / "results" / "trajectory.nc", engine="h5netcdf") as data:
        imports = json.loads(data.attrs["imports"])
    assert imports["arm.urdf"].encode(errors="surrogateescape") == text.encode("latin-1")


@pytest.mark.parametrize("name", ["/dev/zero", "/etc/passwd", "../secret.txt", "pipe"])
@pytest.mark.timeout(20)
def test_scenes_import_only_files_of_their_folder(name, folder):
    home = folder / "home"
    home.mkdir()
    os.mkfifo(home / "pipe")
    (folder / "secret.txt").write_text("a secret\n", encoding="utf-8")
    (home / "arm.toml").write_text(SCENE.replace("arm.urdf", name), encoding="utf-8")
    with pytest.raises(lissom.SceneError, match=r"not a regular file|leads out of the folder") as caught:
        lissom.Scene.load(home / "arm.toml")
    assert [problem.key for problem in caught.value.problems] == ["import.urdf"]


def test_other_files_are_imported_where_that_is_asked_for(folder):
    home = folder / "home"
    home.mkdir()
    (home / "arm.toml").write_text(SCENE.replace("arm.urdf", "../arm.urdf"), encoding="utf-8")
    assert lissom.Scene.load(home / "arm.toml", anywhere=True).model.n == 4
    text = (home / "arm.toml").read_text(encoding="utf-8")
    assert lissom.Scene.loads(text, str(home / "arm"), anywhere=True).model.n == 4
    assert run("check", "arm.toml", cwd=home).returncode == 2
    assert run("--import-anywhere", "check", "arm.toml", cwd=home).returncode == 0


def test_nothing_is_shown_of_a_file_that_is_no_robot(folder):
    (folder / "arm.urdf").write_text("password = 1234\n<robot>\n", encoding="utf-8")
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.load(folder / "arm.toml")
    assert "1234" not in str(caught.value)
    (folder / "arm.urdf").write_text("<key1234 password='1234'>1234</key1234>\n", encoding="utf-8")
    with pytest.raises(lissom.SceneError, match="an element of another format") as caught:
        lissom.Scene.load(folder / "arm.toml")
    assert "1234" not in str(caught.value)
