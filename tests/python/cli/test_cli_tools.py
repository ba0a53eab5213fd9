"""Commands for scenes: new, doctor, completion; and where advice is shown."""

import html
import os
import re
import shlex
import subprocess
import sys
import tomllib
from importlib import metadata
from importlib.resources import files

import pytest
from click.testing import CliRunner

import lissom
from lissom import cli
from lissom.analysis.advice import advice
from lissom.cli import doctor, new
from lissom.drawing.report.numerals import typeset

KINDS = list(new.KINDS)

SCENE = """version = 1
[scene]
gravity = {gravity}
[[rod]]
[[rod.segment]]
length = 1.0
radius = {radius}
young_modulus = {young_modulus}
poisson_ratio = 0.3
density = {density}
modes = {{ bend_y = 8 }}
[simulation]
t_end = 1.0
method = "radau"
"""
STEEL = {"young_modulus": 2.1e11, "density": 7800.0, "radius": 1e-3, "gravity": [0.0, 0.0, -9.81]}


def called(*arguments):
    """Exit code and output."""
    result = CliRunner().invoke(cli.commands, list(arguments), standalone_mode=False)
    if isinstance(result.exception, SystemExit | lissom.LissomError):
        raise result.exception
    code = result.return_value if result.exception is None else result.exception.exit_code
    message = getattr(result.exception, "message", "")
    return code, result.output + message


@pytest.mark.parametrize("kind", KINDS)
def test_new_scenes_are_good_and_run(kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, said = called("new", "my robot", "--kind", kind)
    assert code == 0
    assert "lissom run 'my robot.toml'" in said
    scene = lissom.Scene.load("my robot.toml")
    assert advice(scene) == []
    motion = scene.run()
    assert motion.status == "finished"
    # Quasi-static motions leave inertia out, and with it the energy that others conserve.
    assert scene.simulation.method == "quasi_static" or motion.balance.drift < 1e-3
    assert lissom.statics(scene.model).success


def test_new_scenes_explain_their_units():
    for kind in KINDS:
        text = (files("lissom.cli") / "templates" / f"{kind}.toml").read_text(encoding="utf-8")
        assert text.startswith("# ")
        assert "SI" in text.splitlines()[0]
        assert text.count("#") > 10


def test_keys_that_are_commented_out_exist():
    """Removing the comment signs gives a valid scene."""
    for kind in KINDS:
        text = (files("lissom.cli") / "templates" / f"{kind}.toml").read_text(encoding="utf-8")
        full, count = re.subn(r"^# (\w+ = )", r"\1", text, flags=re.MULTILINE)
        assert tomllib.loads(full)
        assert lissom.Scene.loads(full).run().status == "finished", (kind, count)


def test_new_leaves_files_as_they_are(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text("mine")
    code, said = called("new", "mine.toml")
    assert (code, (tmp_path / "mine.toml").read_text()) == (2, "mine")
    assert "mine.toml exists; give another name" in said
    for folder in ("absent", "a/b", "mine.toml"):
        code, said = called("new", f"{folder}/mine")
        assert code == 1
        expected = f"{folder}/mine.toml could not be written: there is no folder {folder}; make it first"
        assert expected in said.replace(os.sep, "/")


@pytest.mark.parametrize("name", ["", ".toml", "a/", "a/.toml", "two\nlines", "bell\a"])
def test_new_refuses_what_names_no_file(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, said = called("new", name)
    assert code == 2
    assert f"NAME: got {name!r}, expected a file name, such as arm" in said
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(os.name == "nt", reason="quotes of POSIX shells")
@pytest.mark.parametrize("name", ["my arm", "größe", "it's $HOME", "C:\\temp\\arm"])
def test_the_command_that_new_suggests_works_in_a_shell(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, said = called("new", name)
    assert code == 0
    assert shlex.split(said.split("To simulate it: ")[1]) == ["lissom", "run", f"{name}.toml"]
    assert (tmp_path / f"{name}.toml").is_file()


def test_new_with_a_schema(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert called("new", "mine", "--schema")[0] == 0
    assert (tmp_path / "mine.toml").read_text().startswith("#:schema ./lissom-scene.schema.json\n# ")
    assert (tmp_path / "lissom-scene.schema.json").read_text() == lissom.Scene.schema()


def test_the_doctor_finds_all_well():
    code, said = called("doctor")
    rows = dict(line.split("  ", 1) for line in said.splitlines())
    assert code == 0
    assert rows["lissom"].strip().startswith(lissom.__version__)
    assert "numpy" not in rows["NumPy"]
    assert rows["simulation"].strip().startswith("correct: deflection with an error of")
    assert {"[files]", "[plot]"} <= set(rows)


def test_the_doctor_says_what_is_missing(monkeypatch):
    version = metadata.version
    gone = "h5netcdf"

    def without(package):
        if package == gone:
            raise metadata.PackageNotFoundError(package)
        return version(package)

    monkeypatch.setattr(metadata, "version", without)
    code, said = called("doctor")
    assert code == 0
    assert "h5netcdf missing, h5py" in said
    assert "to install: pip install 'lissom[files]'" in said


def test_the_doctor_sees_what_is_wrong(monkeypatch):
    monkeypatch.setattr(doctor, "FORCE", 1.0)
    code, said = called("doctor")
    assert code == 1
    assert "WRONG" in said


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_of_shells(shell):
    code, script = called("completion", shell)
    assert code == 0
    assert "_LISSOM_COMPLETE" in script


def test_completion_completes():
    code = "from lissom.__main__ import main; main()"
    environment = {"_LISSOM_COMPLETE": "bash_complete", "COMP_WORDS": "lissom sta", "COMP_CWORD": "1"}
    run = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=60
    )
    assert run.stdout.split() == ["plain,statics"]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"young_modulus": 210}, "A Young's modulus of 210 Pa is softer than any gel"),
        ({"young_modulus": 2.1e15}, "A Young's modulus of 2.1e15 Pa is stiffer than diamond"),
        ({"density": 7.8}, "A density of 7.8 kg/m³ is lighter than foam"),
        ({"density": 7.8e6}, "A density of 7.8e6 kg/m³ is heavier than any metal"),
        ({"radius": 5.0, "young_modulus": 1e6}, '"rod" is 10 m wide; lengths are in metres.'),
        ({"gravity": [0, 0, -9810]}, "Gravity is 9810 m/s², on Earth it is 9.81"),
        ({}, None),
        ({"young_modulus": 1e3, "density": 10.0}, None),
        ({"gravity": [0, 0, 0]}, None),
    ],
)
def test_unlikely_units_are_questioned(change, said):
    found = advice(lissom.Scene.loads(SCENE.format(**STEEL | change)))
    about = [sentence for sentence in found if re.search("Pa is|kg/m³ is|m wide|Gravity", sentence)]
    assert len(about) == (said is not None)
    assert said is None or about[0].startswith(said)


def test_what_all_segments_have_in_common_is_said_once():
    segment = SCENE.format(**STEEL | {"density": 7.8}).split("[[rod.segment]]")[1].split("[simulation]")[0]
    text = SCENE.format(**STEEL | {"density": 7.8}).replace(
        "[simulation]", f"[[rod.segment]]{segment}[simulation]"
    )
    found = advice(lissom.Scene.loads(text))
    assert sum("density" in sentence for sentence in found) == 1


def test_a_run_says_what_check_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = SCENE.format(**STEEL | {"density": 7.8})
    (tmp_path / "steel.toml").write_text(text)
    sentences = advice(lissom.Scene.loads(text))
    assert any("density" in sentence for sentence in sentences)
    code, said = called("run", "steel.toml")
    assert code == 0
    page = html.unescape((tmp_path / "results" / "steel" / "report.html").read_text(encoding="utf-8"))
    for sentence in sentences:
        assert said.index(sentence) < said.index("× real time")
        assert page.index(typeset(sentence)) < page.index("as fast as real time")
