"""Scene files from Python. Rejected scenes and places of errors are tested in Rust (tests/crate/scene.rs)."""

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

import lissom

SCENES = Path(__file__).parents[3] / "scenes"

WIRE = """version = 1
[[rod]]
q0 = [0.1, 0.2]
[[rod.segment]]
length = 2.0
radius = [2e-3, 1e-3]
young_modulus = 3e5
poisson_ratio = 0.5
density = 1000
modes = { bend_y = 1, bend_z = 1 }
[simulation]
t_end = 0.5
"""


def test_a_scene_makes_the_rod_that_python_would_make():
    scene = lissom.Scene.loads(WIRE, "wire")
    modes = {"bend_y": 1, "bend_z": 1}
    segment = lissom.Segment(2.0, (2e-3, 1e-3), 3e5, density=1000, modes=modes, poisson_ratio=0.5)
    assert isinstance(scene.model, lissom.Rod)
    assert scene.model.segments == (segment,)
    assert scene.name == "wire"
    assert scene.text == WIRE
    np.testing.assert_array_equal(scene.q0, [0.1, 0.2])
    np.testing.assert_array_equal(scene.v0, [0.0, 0.0])
    q, zero = np.array([0.3, -0.2]), np.zeros(2)
    same = lissom.Rod([segment]).inverse_dynamics(q, zero, zero)
    np.testing.assert_array_equal(scene.model.inverse_dynamics(q, zero, zero), same)


def test_documented_defaults_of_the_simulation():
    settings = lissom.Scene.loads(WIRE).simulation
    assert (settings.method, settings.dt, settings.jac) == ("newmark", 1e-2, "analytic")
    assert (settings.t_end, settings.rtol, settings.atol) == (0.5, 1e-6, None)
    assert settings.output_dt is None
    assert settings.quantities == ("velocity", "acceleration", "energy", "shape")


@pytest.mark.parametrize("method", ["newmark", "hht", "generalised_alpha", "rk45", "dop853", "radau"])
def test_a_scene_runs_as_simulate_does(method):
    scene = lissom.Scene.loads(WIRE + f"method = '{method}'\ndt = 2e-3\n")
    found = scene.run()
    same = lissom.simulate(scene.model, 0.5, q0=[0.1, 0.2], method=method, dt=2e-3)
    assert found.success
    assert len(found.t) == 251
    np.testing.assert_array_equal(found.t, same.t)
    np.testing.assert_array_equal(found.q, same.q)


def test_options_of_a_run_replace_those_of_the_scene():
    scene = lissom.Scene.loads(WIRE + "output.dt = 0.1\n")
    np.testing.assert_allclose(scene.run().t, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5])
    assert len(scene.run(t_eval=None, dt=0.25).t) == 3
    with pytest.raises(TypeError, match="speed"):
        scene.run(speed=3)


def test_the_last_time_is_the_duration_whatever_the_output_dt():
    for step, count in ((0.1, 6), (0.15, 5), (0.5, 2), (0.3, 3)):
        t = lissom.Scene.loads(WIRE + f"output.dt = {step}\n").run().t
        assert len(t) == count
        assert t[-1] == 0.5


def test_a_scene_makes_the_pendulum():
    scene = lissom.Scene.loads("version = 1\n[pendulum]\nmass = 2\n[simulation]\nt_end = 1\n")
    assert isinstance(scene.model, lissom.SpringPendulum)
    default = lissom.SpringPendulum(mass=2.0)
    for name in ("length", "mass", "stiffness", "gravity"):
        assert getattr(scene.model, name) == getattr(default, name)


@pytest.mark.parametrize("key", ["units", "unit_system", "length_unit"])
def test_units_are_answered_with_those_of_scenes(key):
    for text in (f'{key} = "mm"\n{WIRE}', WIRE.replace("length = 2.0", f'length = 2.0\n{key} = "mm"')):
        with pytest.raises(
            lissom.SceneError, match="unknown key; leave it out: all numbers are in SI units"
        ) as caught:
            lissom.Scene.loads(text)
        assert len(caught.value.problems) == 1


def test_all_problems_come_at_once_each_with_its_place():
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(WIRE.replace("length = 2.0", "lenght = 2.0").replace("1000", "-1000"), "bad.toml")
    misspelt, negative = caught.value.problems
    assert str(misspelt) == "bad.toml:5:1: rod[0].segment[0].lenght: unknown key; did you mean `length`?"
    assert (negative.file, negative.line, negative.column) == ("bad.toml", 9, 11)
    assert negative.key == "rod[0].segment[0].density"
    assert negative.wrong == "got -1000"
    assert negative.right == "expected a finite number > 0 (kg/m^3)"
    assert "density = -1000" in negative.snippet
    assert all(str(problem) in str(caught.value) for problem in caught.value.problems)
    assert isinstance(caught.value, ValueError)


def test_files_are_read_from_any_path_like(tmp_path):
    path = tmp_path / "wire.toml"
    path.write_text(WIRE)
    assert lissom.Scene.load(path).name == "wire"
    assert lissom.Scene.load(str(path)).name == "wire"
    with pytest.raises(FileNotFoundError, match="nothing"):
        lissom.Scene.load(tmp_path / "nothing.toml")
    with pytest.raises(IsADirectoryError):
        lissom.Scene.load(tmp_path)
    with pytest.raises(TypeError):
        lissom.Scene.load(3)


def test_a_file_that_is_not_utf_8_is_refused(tmp_path):
    path = tmp_path / "latin.toml"
    path.write_bytes("version = 1\n# f\xfcr\n".encode("latin-1"))
    with pytest.raises(lissom.SceneError, match=r"latin.toml:2:4: not text in UTF-8") as caught:
        lissom.Scene.load(path)
    assert len(caught.value.problems) == 1


def test_windows_line_ends_and_a_byte_order_mark_are_fine(tmp_path):
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbf" + WIRE.replace("\n", "\r\n").encode())
    assert lissom.Scene.load(path).model.n == 2


def test_the_schema_is_json_and_the_one_in_the_repository():
    schema = lissom.Scene.schema()
    assert schema == (SCENES / "lissom-scene.schema.json").read_text()
    assert set(json.loads(schema)["properties"]) == {
        "version",
        "scene",
        "rod",
        "import",
        "link",
        "loop",
        "contact",
        "base_motion",
        "fluid",
        "tendon",
        "chamber",
        "motor",
        "active_strain",
        "pendulum",
        "simulation",
    }


def test_every_key_of_the_schema_is_documented():
    documented = (SCENES.parent / "docs" / "scenes.md").read_text()
    schema = json.loads(lissom.Scene.schema())
    tables = [schema, *schema["definitions"].values()]
    keys = {key for table in tables for key in table.get("properties", {})}
    assert len(keys) > 30
    undocumented = [key for key in sorted(keys) if not re.search(rf"`\[*(\w+\.)?{key}[`\]]", documented)]
    assert undocumented == []


@pytest.mark.filterwarnings("ignore::lissom.urdf.UrdfWarning")
@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_shipped_scenes_are_good_and_point_editors_to_the_schema(path):
    scene = lissom.Scene.load(path)
    assert scene.model.n > 0
    assert path.read_text().startswith("#:schema ./lissom-scene.schema.json\n")
    assert tomllib.loads(scene.text)["scene"]["name"] == scene.name


def test_the_example_of_the_documentation_is_good():
    text = (SCENES.parent / "docs" / "scenes.md").read_text()
    examples = [block.split("```")[0] for block in text.split("```toml\n")[1:]]
    whole = [example for example in examples if "version = 1" in example]
    assert whole
    for example in whole:
        lissom.Scene.loads(example)


def test_one_output_step_may_be_the_whole_run_wherever_it_starts():
    """t_end - t0 is rounded: 1.2 - 1.1 is less than 0.1."""
    for tenths in range(1, 40):
        t0, t_end = tenths / 10, (tenths + 1) / 10
        settings = f"t0 = {t0}\nt_end = {t_end}\ndt = 0.05\noutput = {{ dt = 0.1 }}\n"
        scene = lissom.Scene.loads(f"version = 1\n[simulation]\n{settings}[pendulum]\n")
        assert scene.run().t.tolist() == [t0, t_end]
    with pytest.raises(lissom.SceneError, match="at most the simulated time"):
        lissom.Scene.loads("version = 1\n[simulation]\nt_end = 1.0\noutput = { dt = 1.01 }\n[pendulum]\n")


ROD_WITH = """version = 1
[scene]
name = "finger"
[[rod]]
load = [{ force = { input = "push", default = [0.0, 0.0, 0.0] } }]
[[rod.segment]]
length = 0.3
radius = 0.01
young_modulus = 1e6
poisson_ratio = 0.5
density = 1000.0
modes = { bend_y = 2 }
[simulation]
t_end = 0.1
dt = 1e-3
"""
TENDON = '[[tendon]]\nname = "t"\n'
PATH = "path = [{ offset = [0, 0.01] }]\n"
#: Invalid actuators of a rod: text, the line below the rod, and the key.
WRONG_ON_A_ROD = {
    "arc lengths that are one": (
        TENDON + "path = [{ along = [0.1, 0.1] }]\ntension = 1.0",
        (3, "tendon[0].path[0].along[1]"),
    ),
    "an arc length beyond the tip": (
        TENDON + "tension = 1.0\npath = [{ along = [0.2, 0.4] }]",
        (4, "tendon[0].path[0].along[1]"),
    ),
    "one point": (TENDON + "path = [{ point = [0, 0, 0] }]\ntension = 1.0", (3, "tendon[0].path")),
    "a point beyond the tip": (
        TENDON + "tension = 1.0\npath = [{ offset = [0, 0] },\n{ point = [0, 0, 0], at = 0.5 }]",
        (5, "tendon[0].path[1].at"),
    ),
    "a stiffness below zero": (TENDON + PATH + "length = 1.0\nstiffness = -1.0", (5, "tendon[0].stiffness")),
    "a tension below zero": (TENDON + PATH + "tension = -1.0", (4, "tendon[0].tension")),
    "a table of tensions below zero": (
        TENDON + PATH + "tension = { times = [0.0, 1.0], values = [1.0, -1.0] }",
        (4, "tendon[0].tension.values[1]"),
    ),
    "two of one name": (
        TENDON + PATH + "tension = 1.0\n" + TENDON + PATH + "tension = 1.0",
        (6, "tendon[1].name"),
    ),
    "inputs of two defaults": (
        TENDON
        + PATH
        + 'tension = { input = "a", default = 1.0 }\n[[chamber]]\nname = "c"\narea = 1e-5\n'
        + PATH
        + 'pressure = { input = "a", default = 2.0 }',
        (9, "chamber[0].pressure"),
    ),
    "an entry of another input": (TENDON + PATH + 'tension = { input = "push.y" }', (4, "tendon[0].tension")),
    "a strain without modes": ('[[active_strain]]\nstrain = "torsion"', (2, "active_strain[0].strain")),
}


@pytest.mark.parametrize("case", WRONG_ON_A_ROD)
def test_what_is_wrong_with_actuators_of_a_rod_is_shown_where_it_is_written(case):
    written, (line, key) = WRONG_ON_A_ROD[case]
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(ROD_WITH + written + "\n")
    problems = caught.value.problems
    assert [problem.key for problem in problems] == [key]
    assert problems[0].line == ROD_WITH.count("\n") + line
