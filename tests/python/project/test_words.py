"""Old names: each is still accepted, with a warning that gives the new name and the place of the old one."""

import copy
import inspect
import json
import pickle
import re
import subprocess
import sys
import warnings

import pytest

import lissom

SCENE = "version = 1\n[pendulum]\n[simulation]\nt0 = 0.5\n"

#: Keys of scenes: definition in the schema, old name, new name, a text with each (the old one in its first
#: line), expected value in messages.
KEYS = [
    ("Simulation", "duration", "t_end", "duration = 0.25\n", "t_end = 0.75\n", "duration later than t0"),
    ("Simulation", "step", "dt", "step = 2e-3\nt_end = 1\n", "dt = 2e-3\nt_end = 1\n", "write dt"),
    (
        "Simulation",
        "jacobian",
        "jac",
        'jacobian = "central"\nt_end = 1\n',
        'jac = "central"\nt_end = 1\n',
        "jac",
    ),
    (
        "Simulation",
        "tolerance",
        "rtol",
        "tolerance = 1e-3\nt_end = 1\n",
        'rtol = 1e-3\nmethod = "auto"\nt_end = 1\n',
        'write rtol, with method = "auto"',
    ),
    ("Output", "step", "dt", "output.step = 0.1\nt_end = 1\n", "output.dt = 0.1\nt_end = 1\n", "write dt"),
]
IDS = [f"{table}.{old}" for table, old, *_ in KEYS]

#: Old attributes of SimulationSettings, with their values.
ATTRIBUTES = {
    "duration": lambda settings: settings.t_end - settings.t0,
    "step": lambda settings: settings.dt,
    "jacobian": lambda settings: settings.jac,
    "output_step": lambda settings: settings.output_dt,
}

#: Methods of solve_ivp, named by SciPy and by lissom.
METHODS = {"RK45": "rk45", "DOP853": "dop853", "Radau": "radau"}


def path_of(table, key):
    return "simulation." + ("output." if table == "Output" else "") + key


def loaded(text):
    """A scene, and the warnings that came with it."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene = lissom.Scene.loads(text, "old.toml")
    return scene, caught


def test_no_old_key_is_forgotten():
    definitions = json.loads(lissom.Scene.schema())["definitions"]
    found = {
        (table, key): re.match(r"Old name of (\w+): ", inner["description"])[1]
        for table, schema in definitions.items()
        for key, inner in schema.get("properties", {}).items()
        if inner.get("deprecated")
    }
    assert found == {(table, old): new for table, old, new, *_ in KEYS}


@pytest.mark.parametrize(("table", "old", "new", "before", "now", "right"), KEYS, ids=IDS)
def test_an_old_key_means_what_it_meant_and_is_named_once(table, old, new, before, now, right):
    scene, caught = loaded(SCENE + before)
    (warning,) = caught
    assert warning.category is FutureWarning
    assert warning.filename == __file__
    column = 8 if table == "Output" else 1
    said = f"old.toml:5:{column}: {path_of(table, old)}: an old name that the next version refuses; "
    assert str(warning.message).startswith(said)
    assert right in str(warning.message)
    expected, silent = loaded(SCENE + now)
    assert silent == []
    assert scene.simulation == expected.simulation
    assert scene.text == SCENE + before


@pytest.mark.parametrize(("table", "old", "new", "before", "now", "right"), KEYS, ids=IDS)
def test_an_old_key_beside_its_new_one_is_refused_with_its_place(table, old, new, before, now, right):
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(SCENE + before + now.splitlines()[0] + "\n", "both.toml")
    (problem,) = caught.value.problems
    assert (problem.line, problem.column) == (5, 8 if table == "Output" else 1)
    assert problem.key == path_of(table, old)
    assert (problem.wrong, problem.right) == (f"the old name of {new}, which is given, too", "remove it")


@pytest.mark.parametrize(("table", "old", "new", "before", "now", "right"), KEYS, ids=IDS)
def test_values_of_old_keys_are_refused_by_the_new_name_where_they_stand(table, old, new, before, now, right):
    wrong = re.sub(" = .*", " = [true]", before, count=1)
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(SCENE + wrong)
    (problem,) = caught.value.problems
    assert (problem.line, problem.column) == (5, wrong.index("[true]") + 1)
    assert problem.key == path_of(table, new)


def test_numbers_of_old_keys_are_checked_like_those_of_new_ones():
    text = SCENE + "duration = -1\nstep = 0\noutput = { step = nan }\n"
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(text)
    assert [(problem.line, problem.column, problem.key) for problem in caught.value.problems] == [
        (5, 12, "simulation.t_end"),
        (6, 8, "simulation.dt"),
        (7, 19, "simulation.output.dt"),
    ]


def test_an_old_tolerance_chooses_no_other_method():
    text = SCENE + 't_end = 1\nmethod = "radau"\ntolerance = 1e-3\n'
    with pytest.raises(
        lissom.SceneError, match=r":7:1: simulation.tolerance: the method does not take it; remove the method"
    ):
        lissom.Scene.loads(text)


def test_open_modes_take_an_old_tolerance():
    text = """version = 1
[[rod]]
[[rod.segment]]
length = 0.2
radius = 0.01
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
retardation_time = 0.05
modes = "auto"
[simulation]
t_end = 0.02
tolerance = 0.1
"""
    scene, (warning,) = loaded(text)
    assert "old.toml:13:1: simulation.tolerance" in str(warning.message)
    assert scene.simulation.method == "auto"


def test_old_words_are_no_advice():
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(SCENE + "t_end = 1\nstepp = 1\nxxx = 2\n")
    said = str(caught.value)
    assert not re.search(r"`(step|duration|tolerance|jacobian)`|keys here .*\b(step|duration)\b", said)


def test_scenes_with_old_words_are_copied_without_a_word():
    scene, _ = loaded(SCENE + "duration = 0.25\nstep = 1e-3\n")
    for twin in (pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene)):
        assert (twin.text, twin.simulation) == (scene.text, scene.simulation)


def test_warnings_as_errors_refuse_old_words():
    with pytest.raises(FutureWarning, match=r"scene:5:1: simulation.duration"):
        lissom.Scene.loads(SCENE + "duration = 0.25\n")


@pytest.mark.parametrize(("table", "old", "new", "before", "now", "right"), KEYS, ids=IDS)
def test_the_command_line_notes_old_words_and_goes_on(table, old, new, before, now, right, tmp_path):
    (tmp_path / "old.toml").write_text(SCENE + before)
    (tmp_path / "new.toml").write_text(SCENE + now)
    command = [sys.executable, "-W", "error", "-m", "lissom", "check"]
    said = [
        subprocess.run([*command, name], cwd=tmp_path, capture_output=True, text=True)
        for name in ("old.toml", "new.toml")
    ]
    assert [done.returncode for done in said] == [0, 0]
    assert said[0].stdout == said[1].stdout.replace("new.toml", "old.toml")
    assert said[1].stderr == ""
    (note,) = said[0].stderr.splitlines()
    assert re.match(rf"Note: old\.toml:5:\d: {path_of(table, old)}: .*{re.escape(right)}", note)


def test_editors_take_old_files():
    """Required keys may have their old or new name."""
    definitions = json.loads(lissom.Scene.schema())["definitions"]
    for table, old, new, *_ in KEYS:
        schema = definitions[table]
        same = schema["properties"][new] | {"description": "", "deprecated": True}
        same.pop("default", None)
        assert schema["properties"][old] | {"description": ""} == same
        assert new not in schema.get("required", [])
    assert definitions["Simulation"]["oneOf"] == [{"required": ["t_end"]}, {"required": ["duration"]}]


@pytest.mark.parametrize("old", ATTRIBUTES)
def test_old_attributes_of_settings_warn(old):
    settings = lissom.Scene.loads(SCENE + "t_end = 1.25\noutput.dt = 0.1\n").simulation
    with pytest.warns(FutureWarning, match=rf"SimulationSettings\.{old}: .*; write ") as caught:
        found = getattr(settings, old)
    assert len(caught) == 1
    assert found == ATTRIBUTES[old](settings)


def test_completion_leaves_old_attributes_out():
    settings = lissom.Scene.loads(SCENE + "t_end = 1.25\n").simulation
    assert not set(ATTRIBUTES) & set(dir(settings))
    assert {"t_end", "dt"} <= {name for name, _ in inspect.getmembers(settings)}


@pytest.mark.parametrize(("of_scipy", "own"), METHODS.items())
def test_the_spelling_of_scipy_means_the_same(of_scipy, own):
    """Programs written for SciPy are input of `solve_ivp`: no warning, which would be an error here."""
    found = lissom.solve_ivp(lambda t, y: -y, (0.0, 1.0), [1.0], of_scipy)
    for method in (own, getattr(lissom, of_scipy)):
        other = lissom.solve_ivp(lambda t, y: -y, (0.0, 1.0), [1.0], method)
        assert (other.t == found.t).all()


@pytest.mark.parametrize("name", ["rK45", "Dop853", "RADAU", "radau5"])
def test_no_other_spelling_is_taken(name):
    with pytest.raises(ValueError, match=f"method: got '{name}', expected 'rk45', 'dop853' or 'radau'"):
        lissom.solve_ivp(lambda t, y: -y, (0.0, 1.0), [1.0], name)


#: Contents of scenes, the corresponding Python callable, and arguments with another form in scenes: separate
#: tables, arrays of tables, which TOML names in the singular, and arguments of functions, not constructors.
SAME_WORDS = {
    "Rod": (lissom.Rod, {"base", "segment", "load", "body", "support", "magnet", "q0", "v0"}),
    "Segment": (lissom.Segment, set()),
    "Load": (lissom.Load, set()),
    "Body": (lissom.Body, set()),
    "Support": (lissom.Support, set()),
    "Fluid": (lissom.Fluid, set()),
    "BaseMotion": (lissom.BaseMotion, set()),
    "Pendulum": (lissom.SpringPendulum, {"q0", "v0"}),
    "VaryingVector": (lissom.Harmonic, {"times", "values", "interpolation"}),
    "VaryingNumber": (lissom.Harmonic, {"times", "values", "interpolation"}),
    "StrainTable": (lissom.Profile, set()),
    "NumberTable": (lissom.Profile, set()),
    "Simulation": (lissom.simulate, {"output"}),
}


@pytest.mark.parametrize("table", SAME_WORDS)
def test_scenes_have_the_words_of_python(table):
    make, others = SAME_WORDS[table]
    properties = json.loads(lissom.Scene.schema())["definitions"][table]["properties"]
    keys = {key for key, schema in properties.items() if not schema.get("deprecated")}
    assert keys - set(inspect.signature(make).parameters) == others


def test_sections_and_settings_have_the_words_of_python():
    definitions = json.loads(lissom.Scene.schema())["definitions"]
    sections = [definitions[kind["$ref"].rsplit("/", 1)[1]] for kind in definitions["Section"]["anyOf"]]
    assert len(sections) == 5
    for section in sections:
        (shape,) = section["properties"]["shape"]["enum"]
        sizes = inspect.signature(getattr(lissom.Section, shape)).parameters.keys()
        assert section["properties"].keys() - {"shape"} == sizes - {"length"}
    settings = {name for name in dir(lissom.SimulationSettings) if not name.startswith("_")} - set(ATTRIBUTES)
    kept = {"output_dt", "quantities"}
    assert settings - kept == {
        key for key, schema in definitions["Simulation"]["properties"].items() if not schema.get("deprecated")
    } - {"output"}
