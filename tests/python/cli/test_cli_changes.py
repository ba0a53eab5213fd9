"""`--set` gives keys of scenes other values; options of other programs lead to it."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import lissom
from lissom import cli

SCENE = """version = 1
[scene]
gravity = [0.0, 0.0, -9.81]
[[rod]]
[[rod.segment]]
length = 0.2
radius = 0.01
young_modulus = 1e6
poisson_ratio = 0.45
density = 1100
modes = { bend_y = 2 }
[simulation]
t_end = 0.1
dt = 0.01
"""


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "arm.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


def called(*arguments):
    done = CliRunner().invoke(cli.commands, [str(each) for each in arguments], standalone_mode=False)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done


def said(capsys, *arguments):
    """What a command that refuses its arguments says."""
    with pytest.raises(SystemExit) as ended:
        cli.main([str(each) for each in arguments])
    assert ended.value.code == 2
    return " ".join(capsys.readouterr().err.split())


def test_runs_take_other_values(path, tmp_path):
    changes = ("simulation.dt=2e-3", "simulation.method=hht", "scene.gravity=[0, 0, -1.0]")
    changes += ("rod[0].segment[0].radius=0.02", "simulation.t_end=0.05")
    given = [part for change in changes for part in ("--set", change)]
    done = called("run", path, "-o", tmp_path / "out", "--no-report", *given)
    assert done.return_value == 0, done.output
    text = SCENE.replace("dt = 0.01", 'dt = 2e-3\nmethod = "hht"').replace("-9.81", "-1.0")
    text = text.replace("radius = 0.01", "radius = 0.02").replace("t_end = 0.1", "t_end = 0.05")
    wanted = lissom.Scene.loads(text).run()
    import xarray

    with xarray.open_dataset(tmp_path / "out" / "trajectory.nc", engine="h5netcdf") as found:
        np.testing.assert_array_equal(found.q.values, wanted.q)
        # The scene that is kept is the one that was run.
        kept = lissom.Scene.loads(found.attrs["scene"])
    assert kept.simulation.dt == 2e-3
    assert kept.model == lissom.Scene.loads(text).model
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["lissom"]


@pytest.mark.parametrize("command", ["statics", "modes"])
def test_equilibria_take_other_values(command, path, tmp_path):
    arguments = (command, path, "-o", tmp_path / "out", "--no-report", "--set", "scene.gravity[2]=-1.0")
    assert called(*arguments).return_value == 0
    kept = np.load(next((tmp_path / "out").glob("*.npz")))
    model = lissom.Scene.loads(SCENE.replace("-9.81", "-1.0")).model
    np.testing.assert_allclose(kept["q"], lissom.statics(model).q, atol=1e-9)


def test_sweeps_take_other_values(path, tmp_path):
    over = ("--over", "rod[0].segment[0].radius=0.01,0.02", "--set", "simulation.t_end=0.03")
    assert called("sweep", path, "-o", tmp_path / "out", "--no-report", *over).return_value == 0


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ("simulation.dt", "'simulation.dt' is not KEY=VALUE"),
        ("=3", "'=3' is not KEY=VALUE"),
        ("simulation.dt=-1", "simulation.dt: "),
        ("simulation.setp=1", "simulation.setp: unknown key"),
        ("rod[3].segment[0].radius=1", "the scene has 1 entry at rod"),
        ("dt=1e-3", "did you mean 'simulation.dt'?"),
    ],
)
def test_wrong_changes_are_named(change, expected, path, capsys, tmp_path):
    words = said(capsys, "run", path, "--set", change, "-o", tmp_path / "out")
    assert expected in words, words
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("option", "key"),
    [
        *(("--dt", "dt"), ("--t-end", "t_end"), ("--method", "method"), ("--tend", "t_end")),
        *(("--timestep", "dt"), ("--duration", "t_end"), ("--rtol", "rtol")),
    ],
)
def test_options_of_other_programs_lead_to_keys(option, key, path, capsys):
    words = said(capsys, "run", path, option, "1e-3")
    assert f"No such option '{option}'" in words
    assert words.endswith(f" Keys of the scene are set by --set simulation.{key}=VALUE.")


def test_other_options_do_not(path, capsys):
    assert said(capsys, "run", path, "--zzz", "1").endswith("No such option '--zzz'.")
    assert said(capsys, "lab", "--method", "1").endswith("No such option '--method'.")
    assert "--output" in said(capsys, "run", path, "--outpt", "x")
    assert said(capsys, "run", path, "simulation.dt=1e-3").endswith(
        "Keys of the scene are set by --set KEY=VALUE."
    )
