"""Scenes with actuators: places of errors, controllers, and the command line."""

import json
import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import lissom
from lissom import cli
from lissom.analysis.advice import advice

SCENES = Path(__file__).parents[3] / "scenes"

SCENE = """version = 1
[[link]]
name = "palm"
joint = { type = "revolute", axis = [0, 1, 0], stiffness = 1 }
body = { mass = 0.1, centre = [0.01, 0.01, 0.02] }
[[link]]
name = "finger"
parent = "palm"
[[link.rod.segment]]
length = 0.2
radius = 0.01
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
retardation_time = 0.02
modes = { bend_y = 1, bend_z = 1 }
[[tendon]]
name = "pull"
path = [
  { link = "palm", point = [0, 0, 0.01] },
  { link = "finger", offset = [0, [0.01, 0.005]], along = [0.02, 0.15] },
]
tension = { input = "pull", default = 2 }
[[chamber]]
name = "blow"
path = [{ link = "finger", offset = [0.01, 0] }]
area = 1e-5
pressure = 1e3
[[motor]]
joint = "palm"
torque = 0.1
[[active_strain]]
link = "finger"
strain = "bend_y"
amount = 0.1
[simulation]
t_end = 0.1
dt = 1e-3
"""

PALM = '{ link = "palm", point = [0, 0, 0.01] }'
ALONG = "along = [0.02, 0.15]"
TENSION = '{ input = "pull", default = 2 }'

#: Original and changed text; and the key of the problem, the marked text, words of the problem and of the
#: expected value.
MISTAKES = {
    "a tendon's key": ("tension", "tensoin", ("tendon[0].tensoin", "tensoin", "unknown key", "`tension`?")),
    "a chamber's key": ("area", "aera", ("chamber[0].aera", "aera", "unknown key", "did you mean `area`?")),
    "a motor's key": (
        "torque",
        "torqe",
        ("motor[0].torqe", "torqe", "unknown key", "did you mean `torque`?"),
    ),
    "an active strain's key": (
        "amount",
        "amuont",
        ("active_strain[0].amuont", "amuont", "unknown key", "did you mean `amount`?"),
    ),
    "a part's key": (
        ALONG,
        "alnog = [0, 1]",
        ("tendon[0].path[1].alnog", "alnog", "unknown key", "`along`?"),
    ),
    "an input's key": (
        TENSION,
        "{ inptu = 1 }",
        ("tendon[0].tension.inptu", "inptu", "unknown key", "did you mean `input`?"),
    ),
    "a table's name": ("[[motor]]", "[[motr]]", ("motr", "motr", "unknown key", "did you mean `motor`?")),
    "a tension of text": (TENSION, '"2"', ("tendon[0].tension", '"2"', 'text "2"', "a number or a table")),
    "an area of text": ("1e-5", '"big"', ("chamber[0].area", '"big"', 'text "big"', "expected a number")),
    "a torque of an array": ("0.1\n[[act", "[1]\n[[act", ("motor[0].torque", "[1]", "an array", "a number")),
    "a strain of a number": ('"bend_y"', "3", ("active_strain[0].strain", "3", "got 3", '"torsion" or')),
    "an offset of text": (
        "[0, [0.01, 0.005]]",
        '[0, "a"]',
        ("tendon[0].path[1].offset[1]", '"a"', 'text "a"', "a number or an array of 2"),
    ),
    "a point in the plane": (
        "point = [0, 0, 0.01]",
        "point = [0, 0]",
        ("tendon[0].path[0].point", "[0, 0]", "2", "an array of 3 numbers"),
    ),
    "a point's link": (
        '"palm", point',
        '"plam", point',
        ("tendon[0].path[0].link", '"plam"', 'no link is called "plam"', 'did you mean "palm"?'),
    ),
    "a part's link": (
        '"finger", offset = [0.01, 0]',
        '"fingr", offset = [0.01, 0]',
        ("chamber[0].path[0].link", '"fingr"', 'no link is called "fingr"', 'did you mean "finger"?'),
    ),
    "an active strain's link": (
        'link = "finger"\nstrain',
        'link = "fingers"\nstrain',
        ("active_strain[0].link", '"fingers"', 'no link is called "fingers"', 'did you mean "finger"?'),
    ),
    "a rigid link": (
        '"finger", offset = [0, [',
        '"palm", offset = [0, [',
        (
            "tendon[0].path[1].link",
            '"palm"',
            "",
            "a link with a rod; through a rigid body leads a point",
        ),
    ),
    "a motor's link": (
        'joint = "palm"',
        'joint = "pam"',
        ("motor[0].joint", '"pam"', 'no coordinate is called "pam"', 'did you mean "palm"?'),
    ),
    "a motor's coordinate": (
        'joint = "palm"',
        'joint = "palm.angel"',
        ("motor[0].joint", '"palm.angel"', "no coordinate is called", 'did you mean "palm.angle"?'),
    ),
    "a joint that is none": (
        'joint = "palm"',
        'joint = "finger"',
        ("motor[0].joint", '"finger"', "a weld joint", "expected a revolute, prismatic"),
    ),
    "a strain of no name": (
        '"bend_y"',
        '"bend_x"',
        ("active_strain[0].strain", '"bend_x"', 'got "bend_x"', "did you mean"),
    ),
    "a strain without modes": (
        '"bend_y"',
        '"torsion"',
        ("active_strain[0].strain", '"torsion"', '"finger" has no modes', "or one of bend_y, bend_z"),
    ),
    "an arc length beyond the rod": (
        ALONG,
        "along = [0, 0.35]",
        ("tendon[0].path[1].along[1]", "0.35", "got 0.35", "an arc length in [0, 0.2] (metres)"),
    ),
    "arc lengths that fall": (
        ALONG,
        "along = [0.15, 0.02]",
        ("tendon[0].path[1].along[1]", "0.02", "got 0.02", "> along[0] = 0.15 (metres)"),
    ),
    "a table that ends before the rod": (
        "[0.01, 0.005]",
        "{ stations = [0, 0.1], values = [0, 0.1] }",
        ("tendon[0].path[1].offset[1].stations[1]", "0.1]", "got 0.1", "expected 0.2"),
    ),
    "a name twice": (
        '"blow"',
        '"pull"',
        ("chamber[0].name", '"pull"', "another actuator", "a different name"),
    ),
    "no name": ('"blow"', '""', ("chamber[0].name", '""', 'got ""', "expected a name")),
    "a negative area": ("1e-5", "-1e-5", ("chamber[0].area", "-1e-5", "got -0.00001", "finite number > 0")),
    "a stiffness of a tension": (
        "tension =",
        "stiffness = 3\ntension =",
        ("tendon[0].stiffness", "3", "it belongs to a tendon of a given length", "remove it"),
    ),
    "a point with an offset": (
        PALM,
        '{ link = "palm", offset = [0, 0], point = [0, 0, 0] }',
        ("tendon[0].path[0].offset", "offset", "a point does not take it", "it takes link, point, at"),
    ),
    "limits of no range": (
        "torque = 0.1",
        "limits = [1, -1]\ntorque = 0.1",
        ("motor[0].limits", "[1, -1]", "got (1, -1)", "the lowest and the highest"),
    ),
    "two defaults of an input": (
        "pressure = 1e3",
        'pressure = { input = "pull", default = 3 }',
        ("chamber[0].pressure", "pressure", "with the default 3", "expected the default 2 as before"),
    ),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_a_mistake_is_refused_where_it_is(case):
    old, new, (key, marked, wrong, right) = MISTAKES[case]
    assert SCENE.count(old) >= 1
    text = SCENE.replace(old, new, 1)
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(text)
    (problem,) = caught.value.problems
    assert problem.key == key
    line = text.splitlines()[problem.line - 1]
    # In the changed text, not in a similar text before it.
    assert line[problem.column - 1 :].startswith(marked)
    assert text.index(new) <= sum(map(len, text.splitlines(True)[: problem.line - 1])) + problem.column - 1
    assert wrong in problem.wrong
    assert right in problem.right
    assert f"scene:{problem.line}:{problem.column}: {key}: " in str(caught.value)


def test_all_mistakes_come_at_once():
    text = SCENE.replace("area = 1e-5", "area = -1").replace("tension", "tensoin").replace('"bend_y"', "3")
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(text)
    keys = {problem.key for problem in caught.value.problems}
    assert {"chamber[0].area", "tendon[0].tensoin", "active_strain[0].strain"} <= keys


def test_a_link_is_meant_where_there_is_one():
    text = SCENE.partition("[[tendon]]")[0].replace("[[link.rod.segment]]", "[[rod.segment]]")
    head, _, tail = text.partition("[[link]]")
    rod = f"{head}[[rod]]\n[[rod.segment]]{tail.partition('[[rod.segment]]')[2]}"
    rod += (
        '[[tendon]]\nname = "pull"\npath = [{ offset = [0, 0.01] }]\ntension = 1\n[simulation]\nt_end = 0.1\n'
    )
    assert [each.name for each in lissom.Scene.loads(rod).model.actuators] == ["pull"]
    # Its own name does no harm: that is how actuators are written.
    named = lissom.Scene.loads(rod.replace("{ offset", '{ link = "rod", offset'))
    assert named.model.actuators == lissom.Scene.loads(rod).model.actuators
    with pytest.raises(lissom.SceneError, match=r"tendon\[0\].path\[0\].link: no link is called"):
        lissom.Scene.loads(rod.replace("{ offset", '{ link = "arm", offset'))


# Controllers


def test_a_controller_sets_the_inputs_of_a_scene():
    scene = lissom.Scene.loads(SCENE)
    seen = []

    def control(t, q, v):
        seen.append((t, q.copy(), v.copy()))
        return [3.0]

    held = scene.run(control=control, control_step=0.02)
    assert held.success
    np.testing.assert_allclose([t for t, _, _ in seen], np.arange(5) * 0.02, atol=1e-15)
    np.testing.assert_array_equal(seen[0][1], scene.q0)
    # As if this had always been the input.
    reported = lissom.Scene.loads(SCENE.replace(TENSION, "3")).run()
    np.testing.assert_allclose(held.q, reported.q, rtol=1e-9, atol=1e-12)
    # Without a controller inputs have their defaults.
    default = lissom.Scene.loads(SCENE.replace(TENSION, "2")).run()
    np.testing.assert_array_equal(scene.run().q, default.q)
    assert np.abs(held.q[-1] - default.q[-1]).max() > 1e-2


def test_a_controller_that_makes_no_sense_is_refused():
    scene = lissom.Scene.loads(SCENE)
    with pytest.raises(ValueError, match="control"):
        scene.run(control=lambda t, q, v: [1.0, 2.0], control_step=0.02)
    with pytest.raises(TypeError, match="control: expected"):
        scene.run(control=3.0)
    with pytest.raises(ValueError, match="control_step"):
        scene.run(control=lambda t, q, v: [1.0], control_step=-1.0)
    with pytest.raises(ZeroDivisionError):
        scene.run(control=lambda t, q, v: 1 / 0, control_step=0.02)


def test_a_pickled_robot_with_offsets_that_vary_has_the_same_bits():
    robot = lissom.Scene.loads(SCENE).model
    finger = lissom.Scene.load(SCENES / "finger.toml").model
    for model in (robot, finger):
        twin = pickle.loads(pickle.dumps(model))
        q, v = np.linspace(0.1, 0.3, model.n), np.linspace(-0.2, 0.4, model.n)
        for at, of in [(0.0, model.n), (0.4, model.n)]:
            forces = [each.inverse_dynamics(q, v, np.zeros(of), t=at) for each in (model, twin)]
            np.testing.assert_array_equal(*forces)
        assert twin.actuators == model.actuators


# The command line


@pytest.fixture
def path(tmp_path):
    file = tmp_path / "finger.toml"
    file.write_text(SCENE)
    return file


def command(*words):
    done = CliRunner().invoke(cli.commands, list(map(str, words)), standalone_mode=False)
    assert done.exception is None, done.exception
    return done.return_value, done.output


def test_explain_says_what_each_actuator_is_compiled_to(path):
    code, said = command("explain", path)
    assert not code
    computed, rest = said.split("  skipped\n")
    skipped, rest = rest.split("  cost\n")
    links, rest = rest.split("  cost of links\n")[1].split("  cost of actuators\n")
    actuators = rest.split("  output\n")[0]
    for what, words in {
        "tendon pull": "commanded tension, never less than zero",
        "tendon pull, along rods": r"finger from 0.02 m to 0.15 m, 16 nodes: from strains only",
        "tendon pull, straight parts": "1: from poses",
        "tendon pull, coupling": "of 3 coordinates",
        "chamber blow": "finger: its volume is linear",
        "motor palm": "commanded force on palm.angle",
        "active strain finger.bend_y": "a reference bend_y of finger",
        "inputs": "pull: set from outside",
    }.items():
        assert re.search(rf"^ +{re.escape(what)}  +{words}", computed, re.MULTILINE), what
    for what, words in {
        "tendon pull": "friction",
        "chamber blow": "tangent",
        "motor palm": "limits, tangent",
        "linear systems by sweeps along the links": "pull couples the links along its path",
    }.items():
        assert re.search(rf"^ +{re.escape(what)}  +{words}$", skipped, re.MULTILINE), what
    names = [line.split()[0] for line in actuators.splitlines()]
    assert names == ["pull", "blow", "palm", "finger.bend_y"]
    # Shares add up to the total, except for rounding to tenths.
    for share in ("residual", "Jacobian"):
        parts = re.findall(rf"([\d.]+) % of the {share}", links + actuators)
        assert len(parts) == 6
        assert sum(map(float, parts)) == pytest.approx(100.0, abs=0.3)


def test_a_robot_without_actuators_pays_nothing_for_them():
    without = lissom.Scene.loads(re.sub(r"(?s)\[\[tendon\]\].*\[sim", "[sim", SCENE)).model
    assert re.search(r"actuators +none\n", without.explain())
    assert "cost of actuators" not in without.explain()
    whole = lissom.Scene.loads(SCENE).model
    for what in ("residual", "tangent"):
        assert whole.multiplications[what] > without.multiplications[what]


def test_actuators_alike_are_told_together():
    tendons = "".join(
        f'[[tendon]]\nname = "t{i}"\npath = [{{ link = "finger", offset = [0, {i}e-3] }}]\ntension = {i}\n'
        for i in range(12)
    )
    text = re.sub(r"(?s)\[\[tendon\]\].*\[sim", f"{tendons}[sim", SCENE)
    said = lissom.Scene.loads(text).model.explain()
    assert re.search(r"^ +12 tendons, t0 to t11  +commanded tension", said, re.MULTILINE)
    assert re.search(r"^ +2 other actuators  +", said, re.MULTILINE)
    assert said.count("t0 to t11") == 3


def test_friction_and_lengths_are_explained():
    text = SCENE.replace(
        f"tension = {TENSION}", "length = 0.15\nstiffness = 40\ndamping = 0.5\nfriction = 0.2"
    )
    said = lissom.Scene.loads(text).model.explain()
    assert "a spring of 40 N/m, damping 0.5 N s/m; slack below the commanded length" in said
    sliding = "direction of sliding from the rate of its length"
    assert re.search(rf"tendon pull, friction +coefficient 0.2: .*; {sliding}", said)
    reported = lissom.Scene.loads(
        text.replace("friction = 0.2", "friction = 0.2\nsliding = 1")
    ).model.explain()
    assert "direction of sliding as commanded" in reported


def test_check_says_what_inputs_are_and_which_tendons_are_slack(path):
    code, said = command("check", path)
    assert code == 0
    assert said.splitlines()[0] == f"{path}: good, 3 generalised coordinates, 4 actuators"
    assert "inputs keep their defaults: pull = 2." in said
    assert "Slack" not in said
    slack = SCENE.replace(f"tension = {TENSION}", "length = 1\nstiffness = 40")
    assert "Slack at the start, because their paths are shorter than their lengths: 'pull'." in advice(
        lissom.Scene.loads(slack)
    )
    path.write_text(SCENE.replace("area", "aera"))
    code, said = command("check", path)
    assert code == 2


def test_run_statics_and_modes_of_actuators(path, tmp_path):
    for name, file in [("run", "trajectory.nc"), ("statics", "equilibrium.npz"), ("modes", "modes.npz")]:
        code, said = command(name, path, "-o", tmp_path / name)
        assert not code, said
        made = {item.name for item in (tmp_path / name).iterdir()}
        assert {file, "summary.json"} <= made
        assert any(item.endswith(".html") for item in made)
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["outcome"] == "finished"
    scene = lissom.Scene.load(path)
    with np.load(tmp_path / "statics" / "equilibrium.npz") as found:
        expected = lissom.statics(scene.model, space_error=False).q
        np.testing.assert_allclose(found["q"], expected, atol=1e-12)
    page = next((tmp_path / "run").glob("*.html")).read_text()
    assert "pull" in page
    assert "blow" in page


def test_statics_on_the_command_line_names_slack_tendons(path, tmp_path):
    path.write_text(SCENE.replace(f"tension = {TENSION}", "length = 1\nstiffness = 40"))
    code, said = command("statics", path, "-o", tmp_path / "out", "--no-report")
    assert not code
    assert "Slack: 'pull'." in said
