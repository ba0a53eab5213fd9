"""Equilibria keep the inputs and the time of their search, and what is made of them takes these."""

import pickle

import numpy as np
import pytest
from click.testing import CliRunner

import lissom
from lissom import cli
from lissom.results import records
from lissom.results.studies import setting_for

TENSION = 0.3


@pytest.fixture(scope="module")
def rod():
    soft = lissom.Segment(
        0.15, 0.006, 250e3, poisson_ratio=0.49, density=1070, modes={"bend_y": 3, "stretch": 1}
    )
    path = [lissom.Along(offset=(0.0, 0.004))]
    pull = lissom.Tendon("pull", path, tension=lissom.Input("pull", 0.0))
    return lissom.Rod([soft], gravity=(0, 0, 0), actuators=[pull])


@pytest.fixture(scope="module")
def found(rod):
    return lissom.statics(rod, u={"pull": TENSION})


def tension_in(peaks):
    return next(peak.value for peak in peaks if peak.part == "pull")


def test_peaks_have_the_tension_of_the_search(rod, found):
    assert found.u.tolist() == [TENSION]
    assert found.t == 0.0
    assert tension_in(found.peaks(rod)) == TENSION
    assert tension_in(found.peaks(rod, u=[0.1])) == 0.1


def test_rows_of_many_equilibria_too(rod):
    many = lissom.statics_many(rod, {"pull": [0.1, 0.2]})
    assert [tension_in(row.peaks(rod)) for row in many] == [0.1, 0.2]
    assert [row.u.tolist() for row in many] == many.u.tolist()


def test_and_copies_and_files(rod, found, tmp_path):
    found.save(tmp_path / "found.lissom", rod)
    for copy in (pickle.loads(pickle.dumps(found)), lissom.load(tmp_path / "found.lissom")):
        assert copy.u.tolist() == [TENSION]
        assert copy.t == 0.0
        assert tension_in(copy.peaks(rod)) == TENSION


def test_reports_show_them(rod, found, tmp_path):
    found.report(tmp_path / "rest.html", rod)
    text = (tmp_path / "rest.html").read_text(encoding="utf-8")
    assert "input pull" in text
    assert f"{TENSION:g} N" in text


def test_paths_and_vibrations_keep_what_is_held(rod, found):
    path = lissom.continuation(rod, u=[TENSION], load_factor=1.0, q0=found.q, t=2.0)
    vibrations = lissom.modes(rod, found.q, u=[TENSION], t=2.0)
    for result in (path, vibrations):
        copy = records.read(records.write(result))
        assert result.u.tolist() == copy.u.tolist() == [TENSION]
        assert result.t == copy.t == 2.0
        assert setting_for(copy, rod).u.tolist() == [TENSION]


def test_loads_are_those_at_the_time_of_the_search():
    soft = lissom.Segment(0.3, 0.01, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 3})
    ramp = ([0.0, 1.0], [[0, 0, 0], [0, 0, 0.2]])
    rod = lissom.Rod([soft], gravity=(0, 0, 0), loads=[lissom.Load(force=ramp)])
    found = lissom.statics(rod, t=1.0)
    moment = next(peak for peak in found.peaks(rod) if peak.quantity == "bending moment")
    assert moment.t == 1.0
    assert moment.value == pytest.approx(0.2 * rod.pose(found.q)[0, 3], rel=1e-6)


def test_results_of_older_versions_know_neither(rod, found):
    maker, (state,) = found.__reduce__()
    del state.u, state.t
    older = maker(state)
    assert older.u is None
    assert older.t is None
    assert tension_in(older.peaks(rod)) == 0.0


def test_other_models_are_refused(rod, found):
    bare = lissom.Rod(rod.segments, gravity=(0, 0, 0))
    with pytest.raises(ValueError, match="model: it has 0 inputs, the result has 1"):
        found.peaks(bare)


def test_records_with_inputs_of_another_kind_are_damaged(found):
    maker, (state,) = found.__reduce__()
    state.u = np.zeros((2, 2))
    with pytest.raises((records.Damaged, TypeError, ValueError)):
        records.read(records.write(maker(state)))


@pytest.mark.parametrize("command", ["statics", "modes"])
def test_the_command_line_takes_inputs(command, rod, tmp_path):
    rod.to_scene(name="pulled").save(tmp_path / "pulled.toml")
    arguments = [
        command,
        str(tmp_path / "pulled.toml"),
        "--input",
        f"pull={TENSION}",
        "-o",
        str(tmp_path / "out"),
    ]
    done = CliRunner().invoke(cli.commands, arguments, standalone_mode=False, catch_exceptions=False)
    assert done.return_value == 0, done.output
    if command == "statics":
        assert f"input pull {TENSION:g}" in " ".join(done.output.split())
    kept = np.load(next((tmp_path / "out").glob("*.npz")))
    np.testing.assert_allclose(kept["q"], lissom.statics(rod, u=[TENSION]).q, atol=1e-9)


@pytest.mark.parametrize("given", ["pull", "pull=x", "=3", "push=1"])
def test_wrong_inputs_of_the_command_line_are_named(given, rod, tmp_path):
    rod.to_scene(name="pulled").save(tmp_path / "pulled.toml")
    arguments = ["statics", str(tmp_path / "pulled.toml"), "--input", given, "-o", str(tmp_path / "out")]
    done = CliRunner().invoke(cli.commands, arguments)
    assert done.exit_code == 2
    assert given.partition("=")[0] in done.output
