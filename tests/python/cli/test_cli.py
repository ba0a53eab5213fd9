"""The command line, run as a separate process."""

import json
import os
import pty
import re
import resource
import shutil
import signal
import subprocess
import sys
import termios
import time
from pathlib import Path

import click
import numpy as np
import pytest
import xarray

import lissom
from lissom import cli
from lissom.common.interruption import SAVING, Interruption
from lissom.drawing import report
from lissom.results import files, folders, runs, studies

SCENES = Path(__file__).parents[3] / "scenes"

WIRE = """version = 1
[scene]
name = "A wire"
[[rod]]
[[rod.segment]]
length = 1.0
radius = 1e-3
young_modulus = 210e9
shear_modulus = 80e9
density = 7800
modes = { bend_y = 2 }
[simulation]
t_end = 0.1
"""

#: More steps than any test waits for.
ENDLESS = """version = 1
[pendulum]
q0 = [-0.8, 0.5]
[simulation]
t_end = 1000
dt = 1e-6
output.dt = 1e-2
"""


#: Runs code when a module is imported or a file is opened.
AT_IMPORT = """
import os, shutil, signal, sys

class Finder:
    def find_spec(self, name, path=None, target=None):
        happens(name)

def happens(name):
    if name in at:
        at.pop(name)()

def opened(event, arguments):
    if event == "open":
        happens(os.path.basename(str(arguments[0])))

def interrupt(times=1):
    for _ in range(times):
        os.kill(os.getpid(), signal.SIGINT)

def fail():
    raise RuntimeError("broken\\ninstallation")

at = {}
sys.meta_path.insert(0, Finder())
sys.addaudithook(opened)
"""

#: A file that every report contains, read when a report is written.
OF_REPORTS = "page.css"


def lissom_command(*arguments, without=(), at_import="", cwd, **options):
    """Run the command; modules in ``without`` cannot be imported, `at_import` runs code at imports."""
    hide = f"import sys; sys.modules.update(dict.fromkeys({list(without)!r}))"
    occasions = f"{AT_IMPORT}\nat.update({at_import})" if at_import else ""
    program = f"{hide}\n{occasions}\nfrom lissom.__main__ import main; main()"
    command = [sys.executable, "-c", program, *map(str, arguments)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=100, **options)


@pytest.fixture
def scene(tmp_path):
    """Writes a scene and returns its path."""

    def write(text, name="wire.toml"):
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


def no_leftovers(folder):
    """No partial folder is left."""
    return not list(folder.rglob(f"{folders.PARTIAL}*"))


def test_a_good_scene_is_simulated_and_written(scene, tmp_path):
    done = lissom_command("run", scene(WIRE), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stderr == "", "no progress bar where stderr is not a terminal"
    results = tmp_path / "results" / "wire"
    assert {path.name for path in results.iterdir()} == {"trajectory.nc", "report.html", "summary.json"}
    assert no_leftovers(tmp_path)
    for said in (
        "A wire: Finished",
        "Newmark",
        "steps",
        "Newton iterations",
        "evaluations",
        "real time",
        "energy drift",
    ):
        assert said in done.stdout
    summary = json.loads((results / "summary.json").read_text())
    assert (summary["outcome"], summary["method"], summary["coordinates"]) == ("finished", "newmark", 2)
    assert summary["simulated_seconds"] == pytest.approx(0.1)
    assert 0.0 <= summary["energy_drift"] < 1e-2


def test_a_scene_is_explained(scene, tmp_path):
    done = lissom_command("explain", scene(WIRE), cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    computed, rest = done.stdout.split("  skipped\n")
    skipped, rest = rest.split("  cost\n")
    cost, rest = rest.split("  output\n")
    output, steps = rest.split("  steps\n")
    assert "2 coordinates, planar kernel" in computed
    assert "bend_y 2" in computed
    assert "motion in space" in skipped
    assert "stretch and shear" in skipped
    for evaluation in ("residual", "Jacobian", "factorisation", "solution", "mass matrix"):
        assert re.search(rf"{evaluation} +[\d,]+ multiplications\n", cost), evaluation
    assert re.search(r"coordinates +every 10 ms", output)
    assert "not wanted" not in output
    assert re.search(r"multiplications +[\d,]+ a step", steps)
    assert "a step" in steps
    assert [path.name for path in tmp_path.iterdir()] == ["wire.toml"], "nothing is written"


@pytest.mark.parametrize("method", ["newmark", "hht", "generalised_alpha", "rk45", "dop853", "radau"])
def test_every_method_runs_and_is_explained(method, scene, tmp_path):
    path = scene(WIRE.replace("[simulation]", f'[simulation]\nmethod = "{method}"'))
    for command in (["run", path, "--no-report"], ["explain", path]):
        done = lissom_command(*command, cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, ""), method


@pytest.mark.parametrize("name", ["lab-pendulum", "tentacle"])
def test_shipped_scenes_are_explained(name, tmp_path):
    done = lissom_command("explain", SCENES / f"{name}.toml", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "a step" in done.stdout


def test_the_trajectory_is_the_one_of_simulate(scene, tmp_path):
    path = scene(WIRE)
    assert lissom_command("run", path, "-o", tmp_path / "out", "--no-report", cwd=tmp_path).returncode == 0
    loaded = lissom.Scene.load(path)
    motion = loaded.run()
    with xarray.open_dataset(tmp_path / "out" / "trajectory.nc", engine="h5netcdf") as data:
        assert dict(data.sizes) == {"time": 11, "coordinate": 2, "shape_time": 11, "X": 25, "axis": 3}
        np.testing.assert_array_equal(data.time, motion.t)
        np.testing.assert_array_equal(data.q, motion.q)
        np.testing.assert_array_equal(data.v, motion.v)
        np.testing.assert_array_equal(data.a, motion.a)
        assert list(data.coordinate.values) == ["segment0.bend_y.0", "segment0.bend_y.1"]
        assert data.time.attrs["units"] == "s"
        assert data.energy_total.attrs["units"] == "J"
        assert data.attrs["scene"] == WIRE
        assert data.attrs["title"] == "A wire"
        tip = loaded.model.pose(motion.q[-1], 1.0)[:3, 3]
        np.testing.assert_allclose(data.position[-1, -1], tip, atol=1e-15)
        energies = [loaded.model.energy(q, v).kinetic for q, v in zip(motion.q, motion.v, strict=True)]
        np.testing.assert_array_equal(data.energy_kinetic, energies)


def test_energies_that_are_not_wanted_are_not_computed(scene, tmp_path):
    path = scene(WIRE + "output = { quantities = ['velocity'] }\n")
    done = lissom_command("explain", path, cwd=tmp_path)
    for quantity in ("acceleration", "energy", "shape"):
        assert re.search(rf"{quantity} +not wanted\n", done.stdout)
    assert re.search(r"velocity +at no cost\n", done.stdout)

    loaded = lissom.Scene.load(path)
    run = runs.Run(loaded, loaded.run())
    numbers = runs.statistics(run)
    report.build(run)
    assert numbers["energy_drift"] is numbers["energy_moved_joules"] is None
    assert "balance" not in vars(run), "nobody asked for it"
    done = lissom_command("run", path, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "not computed: the scene does not ask for energies" in done.stdout
    assert ">Energy<" not in (tmp_path / "results" / "wire" / "report.html").read_text()


def test_only_the_wanted_quantities_are_written(scene, tmp_path):
    path = scene(WIRE + "output = { dt = 0.05, quantities = ['energy'] }\n")
    assert lissom_command("run", path, "-o", "out", without=["h5py"], cwd=tmp_path).returncode == 0
    with np.load(tmp_path / "out" / "trajectory.npz") as data:
        np.testing.assert_allclose(data["t"], [0.0, 0.05, 0.1])
        kept = set(data.files)
    assert kept >= {"q", "energy_total", "scene"}
    assert not kept & {"v", "a", "position"}


def files_in(folder):
    """Names and contents of all files below a folder."""
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_earlier_results_are_replaced_as_a_whole(scene, tmp_path):
    path = scene(WIRE)
    bare = lissom_command("run", path, without=["h5py"], cwd=tmp_path)
    assert bare.returncode == 0
    results = tmp_path / "results" / "wire"
    earlier = files_in(results)
    assert {str(name) for name in earlier} == {"trajectory.npz", "report.html", "summary.json"}
    assert lissom_command("run", path, "--no-report", cwd=tmp_path).returncode == 0
    assert {found.name for found in results.iterdir()} == {"trajectory.nc", "summary.json"}
    assert (results / "summary.json").read_bytes() != earlier[Path("summary.json")], "run times differ"
    assert no_leftovers(tmp_path)


#: Files that are not results of lissom, with the file that the error message names.
FOREIGN = {
    "any files": ({"chapter.txt": "precious"}, "chapter.txt"),
    "a project with a summary of its own": (
        {"summary.json": '{"lissom": 1}', ".git/HEAD": "ref", "src/main.c": "int main;"},
        ".git",
    ),
    "a summary without our key": ({"summary.json": '{"total": 3}'}, "summary.json"),
    "a summary that is no table": ({"summary.json": '["lissom"]'}, "summary.json"),
    "a summary that is no JSON": ({"summary.json": "lissom"}, "summary.json"),
    "a report without our summary": ({"report.html": "<p>mine</p>"}, "report.html"),
    "notes among our results": ({"summary.json": '{"lissom": "0.1.0"}', "notes.md": "mine"}, "notes.md"),
    "a folder with a name of ours": ({"summary.json": '{"lissom": "0.1.0"}', "lab.html/x": "y"}, "lab.html"),
}


@pytest.mark.parametrize("command", ["run", "lab"])
@pytest.mark.parametrize(("files", "named"), FOREIGN.values(), ids=FOREIGN)
def test_a_folder_of_others_is_left_alone(command, files, named, scene, tmp_path):
    target = tmp_path / "thesis"
    for name, text in files.items():
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        (target / name).write_text(text)
    before = files_in(target)
    # A simulation is rejected before it starts.
    arguments = ["run", scene(ENDLESS)] if command == "run" else ["lab"]
    done = lissom_command(*arguments, "-o", target, cwd=tmp_path)
    assert done.returncode == 2
    assert re.search(
        rf"has {re.escape(named)}( and \d more)?, which lissom did not write; name another", done.stderr
    )
    assert files_in(target) == before


def test_a_file_is_no_folder(scene, tmp_path):
    path = scene(ENDLESS)
    done = lissom_command("run", path, "-o", path, cwd=tmp_path)
    assert done.returncode == 2
    assert "is a file; name another folder" in done.stderr
    assert path.read_text() == ENDLESS


def test_a_link_among_the_results_is_not_followed(scene, tmp_path):
    path = scene(WIRE)
    assert lissom_command("run", path, "-o", "out", cwd=tmp_path).returncode == 0
    (tmp_path / "precious").write_text("mine")
    (tmp_path / "out" / "report.html").unlink()
    (tmp_path / "out" / "report.html").symlink_to(tmp_path / "precious")
    assert lissom_command("run", path, "-o", "out", cwd=tmp_path).returncode == 2
    assert (tmp_path / "precious").read_text() == "mine"


def test_the_current_folder_stays_where_it_is(scene, tmp_path):
    """It is rejected if it contains foreign files, and used if it is empty or contains results."""
    path = scene(WIRE)
    for folder in (".", ".."):
        (tmp_path / "inner").mkdir(exist_ok=True)
        cwd = tmp_path if folder == "." else tmp_path / "inner"
        done = lissom_command("run", path, "-o", folder, cwd=cwd)
        assert done.returncode == 2, done.stdout
        assert "lissom did not write" in done.stderr
    assert files_in(tmp_path) == {Path("wire.toml"): WIRE.encode()}
    inner = tmp_path / "inner"
    identity = inner.stat().st_ino
    for _ in range(2):
        done = lissom_command("run", path, "-o", ".", "--no-report", cwd=inner)
        assert done.returncode == 0, done.stderr
        assert {found.name for found in inner.iterdir()} == {"trajectory.nc", "summary.json"}
    assert inner.stat().st_ino == identity
    assert {found.name for found in tmp_path.iterdir()} == {"wire.toml", "inner"}


def test_results_that_cannot_be_completed_leave_the_earlier_ones(tmp_path):
    with folders.Folder(tmp_path / "out") as folder:
        files.write_summary({folders.MARK: "0.1.0"}, folder.partial)
        assert folder.publish() == ["summary.json"]
    before = files_in(tmp_path)
    assert set(before) == {Path("out/summary.json")}

    def fill_the_disk():
        with folders.Folder(tmp_path / "out") as folder:
            (folder.partial / "summary.json").touch()
            raise OSError("the disk is full")

    with pytest.raises(OSError, match="full"):
        fill_the_disk()
    assert files_in(tmp_path) == before
    assert no_leftovers(tmp_path)


def test_folders_that_a_run_made_go_with_it(tmp_path):
    (tmp_path / "mine").mkdir()
    with folders.Folder(tmp_path / "mine" / "a" / "b") as folder:
        assert folder.partial.is_dir()
    assert list(tmp_path.rglob("*")) == [tmp_path / "mine"]


def test_what_killed_runs_left_is_removed(tmp_path):
    leftover = tmp_path / "out" / f"{folders.PARTIAL}0"
    leftover.mkdir(parents=True)
    (leftover / "trajectory.nc").write_text("half")
    folders.check_target(tmp_path / "out")
    with folders.Folder(tmp_path / "out") as folder:
        assert not leftover.exists()
        files.write_summary({folders.MARK: "0.1.0"}, folder.partial)
        folder.publish()
    assert {found.name for found in (tmp_path / "out").iterdir()} == {"summary.json"}
    folders.check_target(tmp_path / "out")


@pytest.mark.parametrize(
    "command", [["run"], ["statics"], ["modes"], ["lab"], ["validate"], ["stress", "--quick"]]
)
def test_a_second_run_into_a_folder_is_refused_before_work(command, scene, tmp_path):
    takes_scene = command[0] in ("run", "statics", "modes")
    arguments = [*command, *([scene(ENDLESS)] if takes_scene else []), "-o", "out"]
    with folders.Folder(tmp_path / "out") as folder:
        done = lissom_command(*arguments, cwd=tmp_path)
        assert done.returncode == 2
        assert "another run of lissom is writing into out" in done.stderr
        assert folder.partial.is_dir(), "and it goes on"
    assert not (tmp_path / "out").exists()


def test_a_killed_run_holds_no_folder(scene, tmp_path):
    command = [sys.executable, "-m", "lissom", "run", scene(ENDLESS), "-o", "out"]
    with subprocess.Popen(command, cwd=tmp_path) as process:
        try:
            while not list(tmp_path.glob(f"out/{folders.PARTIAL}*")):
                assert process.poll() is None
        finally:
            process.kill()
    assert not no_leftovers(tmp_path)
    assert lissom_command("run", scene(WIRE), "-o", "out", "--no-report", cwd=tmp_path).returncode == 0
    assert no_leftovers(tmp_path)


@pytest.mark.parametrize("command", ["run", "check"])
def test_a_bad_scene_is_refused_with_all_its_problems(command, scene, tmp_path):
    path = scene(WIRE.replace("length = 1.0", "lenght = 1.0").replace("7800", "-1"))
    done = lissom_command(command, path, cwd=tmp_path)
    assert done.returncode == 2
    assert f"{path}:6:1: rod[0].segment[0].lenght: unknown key; did you mean `length`?" in done.stderr
    assert f"{path}:10:11: rod[0].segment[0].density: got -1; expected" in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == [path], "nothing is written"


@pytest.mark.parametrize(
    "arguments", [["run", "nothing.toml"], ["run"], ["walk"], ["run", "--fast", "x"], ["check"]]
)
def test_bad_usage_ends_with_2(arguments, tmp_path):
    done = lissom_command(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr


def test_check_names_good_and_bad_scenes(scene, tmp_path):
    good, bad = scene(WIRE, "good.toml"), scene("version = 3", "bad.toml")
    done = lissom_command("check", good, bad, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout.startswith(f"{good}: good, 2 generalised coordinates\n  The step of 0.01 s resolves")
    assert f"{bad}:1:11: version" in done.stderr
    assert lissom_command("check", *SCENES.glob("*.toml"), cwd=tmp_path).returncode == 0


def test_check_goes_on_after_a_file_that_is_missing(scene, tmp_path):
    good = scene(WIRE, "good.toml")
    done = lissom_command("check", tmp_path / "nothing.toml", tmp_path, good, cwd=tmp_path)
    assert done.returncode == 2
    assert "nothing.toml: there is no such file" in done.stderr
    assert f"{tmp_path}: not a file" in done.stderr
    assert f"{good}: good, " in done.stdout


def test_a_failed_simulation_ends_with_1_and_keeps_what_there_is(scene, tmp_path):
    # A mass in the hinge has no angle, so there is no initial acceleration.
    path = scene("version = 1\n[pendulum]\nq0 = [0, -1]\n[simulation]\nt_end = 1\n")
    done = lissom_command("run", path, "-o", "out", cwd=tmp_path)
    assert done.returncode == 1
    assert "Failed at 0 s" in done.stdout
    assert "give every coordinate a mass." in done.stdout
    assert "`a0`" not in done.stdout, "a scene has no such key"
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["outcome"] == "failed"
    assert (tmp_path / "out" / "report.html").exists()


def test_messages_speak_of_keys_of_the_scene():
    class Motion:
        message = "Reduce `dt` or use adaptive steps; loosen `rtol`, or ask for fewer times with `t_eval`."

    run = runs.Run(lissom.Scene.loads(WIRE), Motion())
    said = "Reduce `dt` or use adaptive steps; loosen `rtol`, or ask for fewer times with `output.dt`."
    assert run.message == said


@pytest.mark.parametrize("command", ["run", "check"])
@pytest.mark.parametrize(
    ("settings", "key"),
    [
        ("t_end = 1e300\nmethod = 'rk45'\noutput = { dt = 1e-300 }", "simulation.output.dt"),
        ("t_end = 1e300\ndt = 1e-300", "simulation.dt"),
        ("t_end = 1e308\ndt = 1e-2", "simulation.dt"),
    ],
)
def test_runs_without_end_are_refused(command, settings, key, scene, tmp_path):
    path = scene(WIRE.replace("t_end = 0.1", settings))
    done = lissom_command(command, path, cwd=tmp_path)
    assert done.returncode == 2
    assert f" {key}: got more than 1.80e308 st" in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == [path], "nothing is written"


def test_what_simulate_refuses_is_one_line(scene, tmp_path, monkeypatch, capsys):
    def refuse(*_):
        raise ValueError("dt: got 3,\n  expected 4")

    path = scene(WIRE)
    monkeypatch.setattr("lissom.cli.run._simulate", refuse)
    with pytest.raises(SystemExit) as ended:
        cli.main(["run", str(path), "-o", str(tmp_path / "out")])
    assert ended.value.code == 2
    assert capsys.readouterr().err == f"{path}: dt: got 3, expected 4\n"
    assert not (tmp_path / "out").exists()


def test_an_interrupted_run_keeps_what_it_has(scene, tmp_path):
    """With a terminal as stderr, so that the progress bar is shown, too."""
    path = scene(ENDLESS)
    ours, theirs = pty.openpty()
    termios.tcsetwinsize(theirs, (24, 80))
    command = [sys.executable, "-m", "lissom", "run", str(path), "-o", "out"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=theirs, text=True) as process:
        try:
            os.close(theirs)
            shown = b""
            while not re.search(rb"Simulating: +\d+%\|.*\| [1-9][\d.]*/1e\+03 s", shown):
                shown += os.read(ours, 1000)
            # An impatient user.
            for _ in range(5):
                process.send_signal(signal.SIGINT)
                time.sleep(0.01)
            said, _ = process.communicate(timeout=60)
        finally:
            process.kill()
            os.close(ours)
    assert process.returncode == 130
    assert "Interrupted at" in said
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["outcome"] == "interrupted"
    assert 0.0 < summary["simulated_seconds"] < 1000.0
    assert (tmp_path / "out" / "trajectory.nc").exists()
    assert no_leftovers(tmp_path)


#: Modules imported before the first step.
EARLY = (
    "lissom.cli",
    "click.core",
    "numpy",
    "numpy._core.multiarray",
    "numpy.linalg",
    "lissom._lissom",
    "lissom.model.views",
)


@pytest.mark.parametrize("module", EARLY)
def test_ctrl_c_before_the_first_step_is_a_word(module, scene, tmp_path):
    interrupt = f"{{{module!r}: lambda: interrupt(3)}}"
    done = lissom_command("run", scene(ENDLESS), "-o", "out", at_import=interrupt, cwd=tmp_path)
    assert (done.returncode, done.stderr.lstrip()) == (130, "Interrupted; nothing was written.\n")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["run", "statics", "modes"])
def test_ctrl_c_while_saving_loses_nothing(command, scene, tmp_path):
    at_import = f"{{{OF_REPORTS!r}: lambda: interrupt(3), 'h5py': lambda: interrupt(2)}}"
    done = lissom_command(command, scene(WIRE), "-o", "out", at_import=at_import, cwd=tmp_path)
    assert done.returncode == 130
    assert set(done.stderr.splitlines()) == {SAVING}
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["outcome"] == "finished"
    assert len(files_in(tmp_path / "out")) == 3
    assert no_leftovers(tmp_path)


def test_ctrl_c_keeps_the_parts_that_are_done(tmp_path):
    program = "from lissom import cli; from lissom.cli.evidence import lab; import os, signal\n"
    program += "lab.PARTS['pendulum'] = lambda setup: os.kill(os.getpid(), signal.SIGINT)\n"
    program += "from lissom.__main__ import main; main()"
    command = [sys.executable, "-c", program, "lab", "-o", "lab"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=100)
    assert (done.returncode, done.stderr) == (130, "")
    numbers = json.loads((tmp_path / "lab" / "summary.json").read_text())
    assert set(numbers) == {"lissom", "setup", "roots"}
    assert (tmp_path / "lab" / "lab.html").exists()


@pytest.mark.slow
@pytest.mark.parametrize("command", ["statics", "modes"])
def test_ctrl_c_keeps_what_a_search_has_found(command, scene, tmp_path):
    """A search that takes steps without end."""
    program = "from lissom.results import studies; import signal, threading\n"
    program += "real, options = studies.statics, {'load_steps': [k / 10**6 for k in range(1, 10**6 + 1)]}\n"
    program += "def statics(*arguments, t, **more):\n"
    program += "    threading.Timer(1.0, signal.raise_signal, [signal.SIGINT]).start()\n"
    program += "    return real(*arguments, t=t, max_steps=10**9, **options, **more)\n"
    program += "studies.statics = statics\n"
    program += "from lissom.__main__ import main; main()"
    line = [sys.executable, "-c", program, command, str(scene(WIRE)), "-o", "out"]
    done = subprocess.run(line, cwd=tmp_path, capture_output=True, text=True, timeout=100)
    assert done.returncode == 130, done.stderr
    assert "Interrupted at load factor" in done.stdout
    assert "Traceback" not in done.stderr
    numbers = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (numbers["study"], numbers["outcome"], numbers["status"]) == ("statics", *["interrupted"] * 2)
    with np.load(tmp_path / "out" / "equilibrium.npz") as kept:
        assert kept["path_load_factor"][-1] == numbers["load_factor"]
        np.testing.assert_array_equal(kept["path_q"][-1], kept["q"])
    assert (tmp_path / "out" / "report.html").exists()
    assert no_leftovers(tmp_path)


@pytest.fixture
def interruption():
    """Enables Ctrl-C in this process."""
    previous = signal.getsignal(signal.SIGINT)
    found = Interruption()
    found.install()
    yield found
    signal.signal(signal.SIGINT, previous)


def test_what_is_computed_until_ctrl_c_is_collected(interruption, capfd):
    def numbers(first):
        yield from range(first)
        os.kill(os.getpid(), signal.SIGINT)
        yield first

    interruption.answer()
    assert interruption.collect(range(3)) == [0, 1, 2]
    assert not interruption.requested
    interruption.answer()
    assert interruption.collect(numbers(3)) == [0, 1, 2]
    os.kill(os.getpid(), signal.SIGINT)
    assert capfd.readouterr().err == "What was computed is being saved; that ends by itself.\n"
    with pytest.raises(KeyboardInterrupt):
        interruption.answer()


def test_ctrl_c_before_anything_is_computed_is_an_interrupt(interruption):
    def nothing():
        os.kill(os.getpid(), signal.SIGINT)
        yield 1

    interruption.answer()
    with pytest.raises(KeyboardInterrupt):
        interruption.collect(nothing())


def test_impatience_does_not_disturb_what_cleans_up(interruption):
    interruption.answer()
    with pytest.raises(KeyboardInterrupt):
        os.kill(os.getpid(), signal.SIGINT)
    os.kill(os.getpid(), signal.SIGINT)
    assert interruption.requested


@pytest.mark.parametrize("command", ["run", "statics", "modes"])
def test_a_report_that_fails_costs_the_report(command, scene, tmp_path):
    broken = f"{{{OF_REPORTS!r}: fail}}"
    done = lissom_command(command, scene(WIRE), "-o", "out", at_import=broken, cwd=tmp_path)
    assert done.returncode == 1
    assert done.stderr == "The report could not be written: RuntimeError: broken installation\n"
    assert (
        f"A wire: {'2 modes' if command == 'modes' else 'Finished' if command == 'run' else 'In equ'}"
        in done.stdout
    )
    names = {found.name for found in (tmp_path / "out").iterdir()}
    assert len(names) == 2
    assert "summary.json" in names


def test_a_trajectory_that_h5py_cannot_write_is_written_by_numpy(scene, tmp_path):
    done = lissom_command(
        "run", scene(WIRE), "-o", "out", "--no-report", at_import="{'h5py.h5': fail}", cwd=tmp_path
    )
    assert done.returncode == 1
    assert "trajectory.nc could not be written, trajectory.npz was: RuntimeError: broken" in done.stderr
    assert {found.name for found in (tmp_path / "out").iterdir()} == {"trajectory.npz", "summary.json"}


def test_results_whose_folder_has_gone_are_written_elsewhere(scene, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    environment = os.environ | {"TMPDIR": str(tmp_path / "elsewhere")}
    gone = "{'h5py': lambda: shutil.rmtree('out')}"
    done = lissom_command("run", scene(WIRE), "-o", "out", at_import=gone, cwd=tmp_path, env=environment)
    assert done.returncode == 1
    assert "out could not be written: " in done.stderr
    (folder,) = (tmp_path / "elsewhere").iterdir()
    assert f"The results are in {folder} instead." in done.stderr
    assert {path.name for path in folder.iterdir()} == {"trajectory.nc", "report.html", "summary.json"}


@pytest.mark.parametrize("limit", [0, 20_000])
@pytest.mark.parametrize("without", [[], ["h5py"]], ids=["netcdf", "npz"])
def test_a_full_disk_is_said_and_leaves_the_earlier_results(limit, without, scene, tmp_path):
    """With a limit for file sizes: zero fails before the first step, 20 kB for the trajectory."""
    path = scene(WIRE.replace("[simulation]", "[simulation]\ndt = 1e-4"))
    with folders.Folder(tmp_path / "out") as folder:
        files.write_summary({folders.MARK: "0.1.0"}, folder.partial)
        folder.publish()
    before = files_in(tmp_path)
    done = lissom_command(
        *("run", path, "-o", "out"),
        without=without,
        cwd=tmp_path,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
    )
    assert done.returncode == 1, done.stderr
    assert done.stderr.startswith("out could not be written: File too large")
    assert "Traceback" not in done.stderr
    assert files_in(tmp_path) == before
    assert no_leftovers(tmp_path)


def test_what_an_extra_is_missing_for_is_said(scene, tmp_path):
    path = scene(WIRE)
    bare = lissom_command("run", path, "-o", "out", without=["h5py"], cwd=tmp_path)
    assert bare.returncode == 0
    assert "pip install 'lissom[files]'" in bare.stderr
    names = {found.name for found in (tmp_path / "out").iterdir()}
    assert names == {"trajectory.npz", "report.html", "summary.json"}


def test_what_cannot_be_written_is_said(scene, tmp_path):
    (tmp_path / "file").touch()
    # A simulation whose results cannot be saved does not start.
    done = lissom_command("run", scene(ENDLESS), "-o", "file/out", cwd=tmp_path)
    assert done.returncode == 1
    assert "could not be written" in done.stderr
    assert "Traceback" not in done.stderr


def test_help_and_version_are_good_and_quick(tmp_path):
    top = lissom_command("--help", cwd=tmp_path)
    assert top.returncode == 0
    assert "..." not in top.stdout.split("Commands:")[1], "no line is cut off"
    assert '"lissom schema"' in top.stdout
    assert "docs/" not in top.stdout, "installed packages have no such folder"
    for command in ("run", "view", "check", "explain", "lab", "validate", "schema"):
        assert re.search(rf"^  {command} ", top.stdout, re.MULTILINE)
        its = lissom_command(command, "-h", cwd=tmp_path)
        assert its.returncode == 0
        assert "Usage: lissom " + command in its.stdout
    assert lissom_command("--version", cwd=tmp_path).stdout == f"lissom, version {lissom.__version__}\n"
    heavy = "{'numpy', 'xarray', 'pandas', 'tqdm', 'scipy', 'matplotlib', 'viser'}"
    program = f"import lissom.cli, sys; print(sorted({heavy} & set(sys.modules)))"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert loaded.stdout == "[]\n"


def test_schema_is_printed(tmp_path):
    assert lissom_command("schema", cwd=tmp_path).stdout == lissom.Scene.schema()


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_shipped_scenes_run(path, tmp_path):
    done = lissom_command("run", path, "-o", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "out" / "report.html").stat().st_size < 9e6


def test_the_shape_at_rest_is_written(scene, tmp_path):
    path = scene(WIRE)
    done = lissom_command("statics", path, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "A wire: In equilibrium, stable" in done.stdout
    folder = tmp_path / "results" / "wire-statics"
    assert {file.name for file in folder.iterdir()} == {"equilibrium.npz", "report.html", "summary.json"}
    q = lissom.statics(lissom.Scene.load(path).model).q
    with np.load(folder / "equilibrium.npz") as kept:
        np.testing.assert_array_equal(kept["q"], q)
        assert kept["path_load_factor"][-1] == 1
    summary = json.loads((folder / "summary.json").read_text())
    assert (summary["study"], summary["outcome"], summary["stability"]) == ("statics", "finished", "stable")
    assert summary["q"] == q.tolist()
    assert 'class="player"' in (folder / "report.html").read_text()
    # The second run replaces the results; releasing the model from the scene's q0 leads to the same shape.
    done = lissom_command("statics", path, "--from-start", "--no-report", "--no-stability", cwd=tmp_path)
    assert done.returncode == 0
    assert {file.name for file in folder.iterdir()} == {"equilibrium.npz", "summary.json"}
    summary = json.loads((folder / "summary.json").read_text())
    np.testing.assert_allclose(summary["q"], q, rtol=1e-8)
    assert summary["stability"] is None


def test_natural_modes_are_written(scene, tmp_path):
    path = scene(WIRE)
    done = lissom_command("modes", path, "-o", "modes", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "A wire: 2 modes, stable" in done.stdout
    assert re.search(r"mode 1 +1\.4\d+ Hz, damping ratio 0\n", done.stdout)
    folder = tmp_path / "modes"
    assert {file.name for file in folder.iterdir()} == {"modes.npz", "report.html", "summary.json"}
    model = lissom.Scene.load(path).model
    found = lissom.modes(model, lissom.statics(model).q)
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["frequency"] == found.frequency.tolist()
    with np.load(folder / "modes.npz") as kept:
        np.testing.assert_array_equal(kept["shapes"], found.shapes)
    report_text = (folder / "report.html").read_text()
    assert "Mode 1: 1.4" in report_text
    done = lissom_command("modes", path, "-o", "modes", "--at-start", "--no-report", cwd=tmp_path)
    assert done.returncode == 0
    at_start = json.loads((folder / "summary.json").read_text())
    assert at_start["frequency"] == lissom.modes(model, [0, 0]).frequency.tolist()
    assert at_start["equilibrium"] is None


@pytest.mark.parametrize("command", ["statics", "modes"])
def test_studies_of_shipped_scenes(command, tmp_path):
    for name in ("lab-pendulum", "tentacle"):
        done = lissom_command(command, SCENES / f"{name}.toml", cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, ""), name


@pytest.mark.parametrize("command", ["statics", "modes"])
def test_studies_refuse_bad_scenes_and_folders_of_others(command, scene, tmp_path):
    done = lissom_command(command, scene(WIRE.replace("length", "lenght"), "bad.toml"), cwd=tmp_path)
    assert done.returncode == 2
    assert "did you mean `length`?" in done.stderr
    assert not (tmp_path / "results").exists()
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("precious")
    done = lissom_command(command, scene(WIRE), "-o", "mine", cwd=tmp_path)
    assert done.returncode == 2
    assert "which lissom did not write" in done.stderr
    done = lissom_command(command, scene(WIRE), "--no-report", cwd=tmp_path)
    assert done.returncode == 0
    (folder,) = (tmp_path / "results").iterdir()
    assert not (folder / "report.html").exists()


def test_a_scene_without_modes(scene, tmp_path):
    text = "version = 1\n[pendulum]\nlength = 1.0\nq0 = [0, -1.0]\n[simulation]\nt_end = 1\n"
    done = lissom_command("modes", scene(text), "--at-start", cwd=tmp_path)
    assert done.returncode == 1
    assert "mass matrix at q is not positive definite" in done.stderr
    assert not (tmp_path / "results").exists()


def rod_scene(simulation="t_end = 0.02", rod="", **changes):
    """The wire with other keys of its segment, or without some."""
    keys = {
        "length": 1.0,
        "radius": 1e-3,
        "young_modulus": 210e9,
        "shear_modulus": 80e9,
        "density": 7800,
        "modes": "{ bend_y = 2 }",
    } | changes
    segment = "\n".join(f"{key} = {value}" for key, value in keys.items() if value is not None)
    return f"version = 1\n[[rod]]\n{rod}\n[[rod.segment]]\n{segment}\n[simulation]\n{simulation}\n"


GIVEN = dict.fromkeys(("radius", "young_modulus", "shear_modulus", "density")) | {
    "section": '{ shape = "given", stiffness = [1, 1, 1, 100, 100, 100], mass = 0.1 }'
}

#: Valid scenes that are unusual.
ODD = {
    "a name with NUL": '[scene]\nname = "a\\u0000b"\n' + rod_scene(),
    "a name of nothing": '[scene]\nname = ""\n' + rod_scene(),
    "a section without size": rod_scene(**GIVEN),
    "a section without size, twisted": rod_scene(**GIVEN | {"modes": "{ torsion = 1 }"}),
    "torsion alone": rod_scene(modes="{ torsion = 1 }", simulation="t_end = 1e-4\nmethod = 'radau'"),
    "no gravity": "[scene]\ngravity = [0, 0, 0]\n" + rod_scene(),
    "coordinates that no node resolves": rod_scene(rod="q0 = [1e8, 1e8]"),
    "velocities beyond doubles": rod_scene(rod="v0 = [1e200, 0]", simulation="t_end = 0.1\nmethod = 'rk45'"),
    "a load beyond doubles": rod_scene(rod="tip_force = [0, 0, 1e300]"),
    "open modes of it": rod_scene(
        rod="tip_force = [1e300, 0, 1e300]",
        modes="'auto'",
        simulation="t_end = 0.1\nmethod = 'auto'\nrtol = 1e-2",
    ),
    "nothing kept": rod_scene(simulation="t_end = 0.1\noutput = { quantities = [] }"),
    "a moment of time": rod_scene(simulation="t_end = 1e-300"),
    "an atom": rod_scene(length=1e-9, radius=1e-12),
    "a pendulum in its hinge": "[pendulum]\nq0 = [0, -1]\n[simulation]\nt_end = 0.1\n",
    "a spring of nothing": "[pendulum]\nmass = 1e300\nstiffness = 1e-300\n[simulation]\nt_end = 0.1\n",
}


def test_too_few_modes_are_said_before_the_report_is_opened(scene, tmp_path):
    """`auto` chooses steps, not modes: what these leave is the first thing that is said."""
    soft = {"young_modulus": 1e5, "shear_modulus": 4e4, "radius": 5e-3, "length": 0.5, "density": 1000}
    text = rod_scene(simulation="t_end = 0.5\nmethod = 'auto'\nrtol = 1e-3", modes="{ bend_y = 1 }", **soft)
    done = lissom_command("run", scene(text), cwd=tmp_path)
    assert "the modes are too few: the space error is" in done.stdout
    assert "0.001 was asked for" in done.stdout


def test_modes_that_are_not_listed_are_counted(scene, tmp_path):
    done = lissom_command("modes", scene(rod_scene(modes="{ bend_y = 8, bend_z = 8 }")), cwd=tmp_path)
    assert "6 more in modes.npz" in done.stdout


@pytest.mark.parametrize(
    "command",
    [
        ["check"],
        ["explain"],
        ["run", "-o", "out"],
        ["statics", "-o", "out"],
        ["statics", "--from-start", "-o", "out"],
        ["modes", "-o", "out"],
        ["modes", "--at-start", "-o", "out"],
    ],
    ids=lambda command: "-".join(word.strip("-") for word in command),
)
@pytest.mark.parametrize("name", ODD)
def test_odd_scenes_end_with_words(name, command, scene, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = (
        ODD[name]
        if ODD[name].startswith("version")
        else "version = 1\n" + ODD[name].replace("version = 1\n", "")
    )
    path = scene(text)
    try:
        code = cli.commands.main([command[0], str(path), *command[1:]], standalone_mode=False)
    except click.ClickException as refusal:
        code = refusal.exit_code
    assert code in (0, 1, 2)
    said = capsys.readouterr()
    assert re.search(r"\bnan\b", said.out) is None
    assert not said.err or "Warning" not in said.err
    assert no_leftovers(tmp_path)
    if (tmp_path / "out").exists():
        assert "trajectory.npz" not in {path.name for path in (tmp_path / "out").iterdir()}
        assert json.loads((tmp_path / "out" / "summary.json").read_text())


@pytest.mark.parametrize("count", [60, 61, 64])
def test_check_advises_on_every_number_of_modes(count, scene, tmp_path):
    """Four more than 60 is the maximum number for a strain."""
    path = scene(rod_scene(modes=f"{{ torsion = {count} }}", simulation="t_end = 1\nmethod = 'radau'"))
    done = lissom_command("check", path, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert f"good, {count} generalised coordinates" in done.stdout


def test_open_modes_that_cannot_be_chosen_are_a_message(scene, tmp_path):
    path = scene("version = 1\n" + ODD["open modes of it"].replace("version = 1\n", ""))
    for command, code in (("check", 2), ("run", 1), ("statics", 1), ("modes", 1), ("explain", 1)):
        done = lissom_command(command, path, cwd=tmp_path)
        assert done.returncode == code
        assert re.fullmatch(
            rf"{path}: .*modes: No modes were chosen, because a trial failed.*\n", done.stderr
        )
    assert list(tmp_path.iterdir()) == [path]


def unresolved(model, q0=None, **options):
    """Statics that give up at once."""
    return lissom.statics(model, q0, method="newton", max_iter=1, **options)


def test_modes_without_an_equilibrium_are_what_statics_found(scene, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(studies, "statics", unresolved)
    path = scene(rod_scene(young_modulus=1e5, shear_modulus=4e4, radius=0.01, density=1000))
    assert cli.commands.main(["modes", str(path), "-o", "out"], standalone_mode=False) == 1
    assert "Failed: " in capsys.readouterr().out
    assert {found.name for found in (tmp_path / "out").iterdir()} == {
        "equilibrium.npz",
        "report.html",
        "summary.json",
    }
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["outcome"] == "failed"


def test_modes_that_are_interrupted_keep_the_equilibrium(scene, tmp_path, monkeypatch):
    def interrupted(model, q, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(studies, "modes", interrupted)
    arguments = ["modes", str(scene(WIRE)), "-o", str(tmp_path / "out"), "--no-report"]
    assert cli.commands.main(arguments, standalone_mode=False) == 1
    assert (tmp_path / "out" / "equilibrium.npz").exists()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
def test_an_output_that_cannot_be_written_to_is_said_in_a_line(tmp_path):
    command = [sys.executable, "-m", "lissom", "schema"]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, cwd=tmp_path)
    assert done.returncode == 1
    assert done.stderr.startswith("lissom: ")
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.skipif(os.name == "nt", reason="a shell of POSIX")
def test_a_run_without_stderr_is_a_run(tmp_path):
    (tmp_path / "wire.toml").write_text(rod_scene(simulation="t_end = 0.1"))
    run = f"{sys.executable} -m lissom run wire.toml --no-report 2>&-"
    assert subprocess.run(run, shell=True, cwd=tmp_path, stdout=subprocess.DEVNULL).returncode == 0
    assert (tmp_path / "results" / "wire" / "summary.json").exists()


def test_names_do_not_command_the_terminal(tmp_path):
    text = 'version = 1\nscene.name = "a\\u001b]0;owned\\u0007\\nb"\n[pendulum]\n[simulation]\nt_end = 0.01\n'
    (tmp_path / "x.toml").write_text(text, encoding="utf-8")
    done = lissom_command("run", "x.toml", "-o", "out", "--no-report", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(r"a\x1b]0;owned\x07\nb: ")
    assert "\x1b" not in done.stdout


def test_links_in_a_circle_are_no_folder(scene, tmp_path):
    path = scene("version = 1\n[pendulum]\n[simulation]\nt_end = 0.01\n")
    (tmp_path / "circle").symlink_to("circle")
    done = lissom_command("run", path, "-o", "circle", "--no-report", cwd=tmp_path)
    assert done.returncode == 1
    assert done.stderr.startswith("circle could not be written")
    assert (tmp_path / "circle").is_symlink()


def test_visuals_of_imported_files_are_drawn_on_request(tmp_path):
    text = (SCENES / "arm.toml").read_text()
    (tmp_path / "arm.toml").write_text(re.sub(r"t_end = [\d.]+", "t_end = 0.05", text))
    shutil.copy(SCENES / "arm.urdf", tmp_path)
    done = lissom_command("run", "arm.toml", "--visuals", "-o", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert '"kind":"mesh"' in (tmp_path / "out/report.html").read_text().replace(": ", ":")
    (tmp_path / "arm.urdf").write_text(
        (SCENES / "arm.urdf")
        .read_text()
        .replace('<box size="0.2 0.04 0.04"/>', '<mesh filename="gone.stl"/>')
    )
    done = lissom_command("run", "arm.toml", "--visuals", "-o", "out2", cwd=tmp_path)
    assert done.returncode == 2
    assert 'mesh@filename: got "gone.stl", which cannot be read' in done.stderr
    assert not (tmp_path / "out2").exists()
    done = lissom_command("run", SCENES / "finger.toml", "--visuals", cwd=tmp_path)
    assert done.returncode == 2
    assert "--visuals: the scene imports no URDF file" in done.stderr


COARSE = """version = 1
[scene]
name = "coarse"
[[rod]]
[[rod.segment]]
length = 0.3
section = { shape = "circle", radius = 0.01 }
young_modulus = 1e6
poisson_ratio = 0.5
density = 1000
modes = { bend_y = 3 }
[simulation]
t_end = 1
dt = 0.05
"""


def test_a_run_names_one_length_of_steps(tmp_path):
    """That which follows from the motion, where there is one; before a run that of the vibrations."""
    (tmp_path / "coarse.toml").write_text(COARSE)
    done = lissom_command("run", "coarse.toml", "--no-report", cwd=tmp_path)
    assert len(re.findall(r"steps of [\d.e-]+ s(?=,| \()", done.stdout)) == 1, done.stdout
    assert "natural frequencies; the next" not in done.stdout
    checked = lissom_command("check", "coarse.toml", cwd=tmp_path)
    assert "needs steps of 0.016 s (10 per period)" in checked.stdout


def test_check_refuses_what_run_refuses(tmp_path):
    text = """version = 1
    [pendulum]
    length = 1
    mass = 1
    stiffness = 100
    [simulation]
    t_end = 1
    dt = 0.01
    method = "quasi_static"
    """
    (tmp_path / "pendulum.toml").write_text(text)
    checked = lissom_command("check", "pendulum.toml", cwd=tmp_path)
    ran = lissom_command("run", "pendulum.toml", cwd=tmp_path)
    assert checked.returncode == ran.returncode == 2
    assert checked.stderr == ran.stderr
    assert checked.stderr.startswith("pendulum.toml: method: got ")
    moving = COARSE.replace("[simulation]", '[simulation]\nmethod = "quasi_static"').replace(
        "[[rod]]", "[[rod]]\nv0 = [1, 0, 0]"
    )
    (tmp_path / "moving.toml").write_text(moving)
    checked = lissom_command("check", "moving.toml", cwd=tmp_path)
    assert checked.returncode == 2
    assert "v0: got 1, expected none" in checked.stderr
