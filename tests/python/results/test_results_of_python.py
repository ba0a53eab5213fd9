"""Results of models created in Python: drawn, saved, loaded, passed to other programs."""

import ast
import dataclasses
import importlib.util
import inspect
import io
import json
import pickle
import re
import shutil
import time
import warnings
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st
from test_pickle import assert_same

import lissom
from lissom.analysis.base import ParameterResult
from lissom.drawing import pictures
from lissom.drawing.report import layers, studies
from lissom.model.views import view
from lissom.results import io as result_files
from lissom.results import records
from lissom.results.studies import setting_for, study_statics

matplotlib = pytest.importorskip("matplotlib")
pyplot = pytest.importorskip("matplotlib.pyplot")
matplotlib.use("Agg")

SCENES = Path(__file__).parents[3] / "scenes"
MATERIAL = {"young_modulus": 1e6, "poisson_ratio": 0.5, "density": 1000.0}


def segment(length=0.2, modes=2):
    return lissom.Segment(length, 0.01, **MATERIAL, modes={"bend_y": modes})


def rod(length=0.2, modes=2):
    return lissom.Rod([segment(length, modes)])


def robot(length=0.2, modes=2):
    upper = lissom.Link("upper", rod=[segment(length, modes)], joint=lissom.Revolute((0, 1, 0)))
    body = lissom.Link("hand", parent="upper", body=lissom.Body(0.1, centre=(0.05, 0, 0)))
    return lissom.Robot([upper, body, lissom.Link("lower", parent="upper", rod=[segment(length, modes)])])


def pendulum(length=1.0, modes=2):
    return lissom.SpringPendulum(length=length)


def coarse(search, model, **options):
    """Equilibria with their errors, which few modes make large."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lissom.AccuracyWarning)
        return search(model, **options)


MODELS = {"rod": rod, "robot": robot, "pendulum": pendulum}
KINDS = {
    "simulate": lambda model: lissom.simulate(model, 0.02, dt=2e-3),
    "explicit": lambda model: lissom.simulate(model, 0.01, method="rk45"),
    "failed": lambda model: lissom.simulate(model, 1.0, dt=1e-2, max_steps=0),
    "statics": lambda model: coarse(lissom.statics, model),
    "continuation": lambda model: coarse(lissom.continuation, model, max_steps=4),
    "modes": lambda model: lissom.modes(model, np.zeros(model.n)),
    "simulate_many": lambda model: lissom.simulate_many(model, 0.01, q0=np.zeros((2, model.n))),
}


@pytest.fixture(autouse=True)
def _closed_figures():
    yield
    pyplot.close("all")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("kept")


@settings(max_examples=40, deadline=None)
@given(
    kind=st.sampled_from(sorted(KINDS)),
    name=st.sampled_from(sorted(MODELS)),
    suffix=st.sampled_from([".lissom", ".npz", ".nc"]),
    length=st.floats(0.1, 0.5),
    modes=st.integers(1, 3),
)
def test_what_is_saved_comes_back_bit_by_bit(folder, kind, name, suffix, length, modes):
    model = MODELS[name](length, modes)
    result = KINDS[kind](model)
    path = folder / f"result{suffix}"
    result.save(path)
    again = lissom.load(path)
    if getattr(result, "model", None) is not None:
        # Models are compared by their results.
        assert pickle.dumps(again.model) == pickle.dumps(result.model)
        np.testing.assert_array_equal(again.a, result.a)
    else:
        assert_same(again, result)
    for array in ("t", "q", "v", "u"):
        if isinstance(getattr(result, array, None), np.ndarray):
            assert getattr(again, array).tobytes() == getattr(result, array).tobytes()


def test_a_trajectory_in_netcdf_has_dimensions_and_units(tmp_path):
    result = KINDS["simulate"](robot())
    result.save(tmp_path / "x.nc")
    with xarray.open_dataset(tmp_path / "x.nc", engine="h5netcdf") as data:
        assert data["q"].dims == ("time", "coordinate")
        assert list(data["coordinate"].values) == list(robot().coordinates)
        assert data["time"].attrs["units"] == "s"
        assert data["energy_kinetic"].attrs["units"] == "J"
        tip = robot().pose(result.q[-1], link="lower", t=result.t[-1])[:3, 3]
        np.testing.assert_array_equal(data["tip"].sel(frame="lower")[-1], tip)
        np.testing.assert_allclose(data["position_lower"][-1, -1], tip, rtol=1e-13, atol=1e-15)


def test_numpy_reads_the_arrays(tmp_path):
    result = KINDS["simulate"](rod())
    result.save(tmp_path / "x.npz")
    with np.load(tmp_path / "x.npz", allow_pickle=False) as arrays:
        np.testing.assert_array_equal(arrays["q"], result.q)


def test_datasets_of_what_rests_and_vibrates():
    model = rod()
    assert list(lissom.statics(model).to_xarray(model)["unit"].values) == ["rad/m"] * 2
    vibrations = lissom.modes(model, np.zeros(2))
    data = vibrations.to_xarray(model)
    np.testing.assert_array_equal(data["shape_real"], vibrations.shapes.real)
    with pytest.raises(ValueError, match="it has 3 coordinates, the result has 2"):
        vibrations.to_xarray(rod(modes=3))


@pytest.mark.parametrize("name", MODELS)
def test_plots_show_the_numbers(name):
    model = MODELS[name]()
    result = lissom.simulate(model, 0.1)
    axes = result.plot()
    drawn = {line.get_label(): line for one in axes for line in one.get_lines()}
    np.testing.assert_array_equal(drawn["kinetic"].get_ydata(), result.balance.kinetic)
    for i, coordinate in enumerate(view(model).coordinates):
        np.testing.assert_array_equal(drawn[coordinate.name].get_ydata(), result.q[:, i])
    assert len(lissom.modes(model, np.zeros(model.n)).plot()) == 2


def test_a_plot_of_a_path_marks_critical_points():
    column = lissom.Rod([segment()], gravity=(0, 0, 0), tip_force=(-1000.0, 0, 0))
    result = lissom.continuation(column)
    axes = result.plot(column)
    lines = axes[-1].get_lines()
    np.testing.assert_array_equal(lines[0].get_ydata(), result.path.lowest_eigenvalue)
    critical = result.path.critical_points
    assert critical
    assert [text.get_text() for text in axes[0].texts] == [point.kind for point in critical]
    assert [line.get_xdata()[0] for line in lines[2:]] == [point.load_factor for point in critical]


def test_a_plot_of_statics_is_the_shape():
    model = rod()
    result = lissom.statics(model)
    line = result.plot(model)[0].get_lines()[0]
    tip = model.pose(result.q)[:3, 3]
    np.testing.assert_allclose([values[-1] for values in line.get_data_3d()], tip, rtol=1e-13, atol=1e-15)


def test_only_models_are_taken_for_models(tmp_path):
    model = rod()
    rest, path = lissom.statics(model), lissom.continuation(model, max_steps=2)
    for call in (rest.plot, rest.to_xarray, path.plot, lambda wrong: rest.save(tmp_path / "x.nc", wrong)):
        with pytest.raises(TypeError, match="model: expected a Model"):
            call("rod")


def test_an_animation_has_the_pictures_of_its_time(tmp_path):
    image = pytest.importorskip("PIL.Image")
    lissom.simulate(pendulum(), 0.5).animate(tmp_path / "x.gif", fps=10, speed=0.5)
    with image.open(tmp_path / "x.gif") as film:
        assert film.n_frames == 11
        assert film.info["duration"] == 100


def test_pictures_are_the_nearest_states():
    t = np.array([0.0, 0.1, 0.35, 1.0])
    assert list(pictures._pictures(t, 4.0, 1.0)) == [0, 2, 2, 3, 3]
    assert list(pictures._pictures(t[:1], 4.0, 1.0)) == [0]


def test_a_report_is_written(tmp_path):
    lissom.simulate(rod(), 0.05).report(tmp_path / "x.html", title="A finger")
    assert "<title>A finger</title>" in (tmp_path / "x.html").read_text(encoding="utf-8")


#: Buckling load of a clamped column of `segment`.
EULER = np.pi**3 / 16 * 1e6 * 0.01**4 / 0.2**2


def column(ratio=1.5, push=0.0):
    """At this multiple of its buckling load, pushed to one side by a fraction of it."""
    return lissom.Rod([segment(modes=3)], gravity=(0, 0, 0), tip_force=(-ratio * EULER, 0, push * EULER))


def buckled():
    """The path on which it buckles to one side."""
    (point, *_) = lissom.continuation(column()).path.critical_points
    options = {"load_factor": point.load_factor, "direction": point.directions[0]}
    return lissom.continuation(column(), point.q, **options)


def sections(built):
    return {section.title: section.parts for section in built.sections}


def build(result, model, **options):
    """The page of an equilibrium or of a path."""
    what = studies.continuation if isinstance(result, lissom.ContinuationResult) else studies.equilibrium
    return what(setting_for(result, model), result, "A rod", **options)


@pytest.mark.parametrize("name", MODELS)
def test_reports_of_what_rests_and_vibrates(name, tmp_path):
    model = MODELS[name]()
    rest = lissom.statics(model, np.full(model.n, -0.1))
    lissom.modes(model, rest.q).report(tmp_path / "modes.html", model, rest.q, title="Modes <of> it")
    rest.report(tmp_path / "rest.html", model)
    assert "<title>Modes &lt;of&gt; it</title>" in (tmp_path / "modes.html").read_text(encoding="utf-8")
    assert "<title>Equilibrium</title>" in (tmp_path / "rest.html").read_text(encoding="utf-8")


def test_the_report_of_a_path_shows_its_equilibria():
    result = buckled()
    built = build(result, column())
    (player,) = sections(built)["Shape"]
    shown, factor = player.scene, result.path.load_factor
    assert shown.opens_at == len(factor) - 1
    np.testing.assert_array_equal(shown.t, factor)
    (tube,) = shown.of(layers.Tube)
    tip = column().pose(result.path.q)[:, :3, 3]
    np.testing.assert_allclose(tube.centres[:, -1], tip, atol=1e-9)
    rows = dict(sections(built)["Result"][1].rows)
    assert rows["load factor"] == f"from {factor[0]:.6g} to 1"
    assert rows["stability at the end"] == "stable"


def test_the_report_of_a_scene_says_the_same_of_its_equilibrium():
    scene = lissom.Scene.load(SCENES / "lab-horizontal.toml")
    study = study_statics(scene)
    of_scene = sections(studies.statics(study))
    made = sections(build(lissom.statics(scene.model), scene.model))
    assert made["Result"][1].rows == [row for row in of_scene["Result"][1].rows if row[0] != "time"]
    ours, theirs = made["Shape"][0].scene, of_scene["Shape"][0].scene
    assert ours.in_words == theirs.in_words
    np.testing.assert_array_equal(ours.of(layers.Tube)[0].centres, theirs.of(layers.Tube)[0].centres)


def test_a_path_whose_loads_turn_back_is_shown_from_end_to_end():
    """Bent to the wrong side: the loads decrease to a limit point, and increase again."""
    model = column(2.0, push=0.02)
    wrong = lissom.statics(model, q0=[2.5, 0.0, 0.0])
    result = lissom.continuation(model, wrong.q, load_factor=1.0, direction=-wrong.q)
    factor = result.path.load_factor
    assert [factor[0], factor[-1]] == [1.0, 1.0]
    assert factor.min() < 0.9
    (player,) = sections(build(result, model))["Shape"]
    shown = player.scene
    assert (np.diff(shown.t) > 0.0).all()
    assert [shown.t[0], shown.t[-1]] == [0.0, 1.0]
    np.testing.assert_array_equal(shown.labels, factor)
    assert "labels" in shown.document()
    (stiffness, *_) = sections(build(result, model))["Stiffness"]
    assert stiffness.figure.clock == ""


def test_an_equilibrium_without_a_path_is_shown_alone():
    for model, name in ((rod(), "rod"), (pendulum(), "mass")):
        rest = lissom.statics(model, np.full(model.n, -0.1))
        assert rest.path is None
        (player,) = sections(build(rest, model))["Shape"]
        assert len(player.scene.t) == 1
        assert {"paths", "initial shape"}.isdisjoint(player.scene.layers)
        assert name in player.scene.in_words


def test_modes_are_shown_beside_the_undeflected_shape():
    model = rod()
    q = lissom.statics(model).q
    found = lissom.modes(model, q)
    built = studies.vibrations(setting_for(found, model), q, found, "A rod")
    shown = built.sections[0].parts[0].scene
    (outline,) = shown.of(layers.Line, "initial shape")
    assert shown.names["initial shape"] == "undeflected shape"
    (link,) = view(model).links
    np.testing.assert_allclose(outline.points[0, :-1], model.pose(q, link.stations)[:, :3, 3], atol=1e-12)


def test_tables_have_zeros_for_what_rounding_leaves():
    """Links that hang vertically: their joints carry their weights without moments."""
    joint = lissom.Revolute((0, 1, 0))
    links = [
        lissom.Link("upper", rod=[segment()], joint=joint, orientation=(np.sqrt(0.5), 0, np.sqrt(0.5), 0)),
        lissom.Link("hand", parent="upper", joint=joint, body=lissom.Body(0.1, centre=(0.05, 0, 0))),
    ]
    model = lissom.Robot(links)
    shown = sections(build(lissom.statics(model), model))
    weight = 9.81 * (0.1 + 1000.0 * np.pi * 0.01**2 * 0.2)
    (table,) = shown["Links"]
    assert [row[0] for row in table.rows] == ["upper", "hand"]
    assert [row[2] for row in table.rows] == [f"(0, 0, {weight:.4g})", f"(0, 0, {0.981:.4g})"]
    assert [row[3] for row in table.rows] == ["(0, 0, 0)", "(0, 0, 0)"]
    assert dict(shown["Result"][1].rows)["hand"] == "(0, 0, -0.2) m"


def test_inputs_of_a_path_are_those_of_its_report(tmp_path):
    pull = lissom.Tendon("pull", [lissom.Along(offset=(0, 0.005))], tension=lissom.Input("tension", 1.0))
    model = lissom.Rod([segment()], actuators=[pull])
    result = lissom.continuation(model, inputs={"tension": (0.5, 2.0)})
    rows = dict(sections(build(result, model))["Result"][1].rows)
    assert rows["input tension"] == "from 0.5 to 2"
    result.animate(tmp_path / "x.gif", model, fps=5, duration=0.4)


def test_a_film_of_a_path_goes_from_its_beginning_to_its_end(tmp_path, monkeypatch):
    result, seen = buckled(), []
    monkeypatch.setattr(pictures, "_draw_film", lambda *film: seen.append(film))
    result.animate(tmp_path / "x.gif", column(), fps=10, duration=2.0)
    ((_, fps, _, _, states, titles),) = seen
    q = states.q
    assert (fps, len(titles)) == (10.0, 20)
    np.testing.assert_allclose(q[[0, -1]], result.path.q[[0, -1]], rtol=1e-14)
    assert titles[0] == f"load factor {result.path.load_factor[0]:.3f}"
    # Every picture lies between two equilibria.
    steps = np.abs(np.diff(q, axis=0)).max(axis=0)
    assert (steps < np.ptp(result.path.q, axis=0).max() / 5).all()


@pytest.mark.parametrize("name", MODELS)
def test_a_film_of_a_mode_is_one_period_about_the_equilibrium(name, tmp_path, monkeypatch):
    model, seen = MODELS[name](), []
    rest = lissom.statics(model, np.full(model.n, -0.1))
    found = lissom.modes(model, rest.q)
    monkeypatch.setattr(pictures, "_draw_film", lambda *film: seen.append(film))
    found.animate(tmp_path / "x.gif", model, rest.q, mode=1, fps=20, duration=1.0)
    ((_, _, _, _, states, titles),) = seen
    q = states.q
    np.testing.assert_allclose(q.mean(axis=0), rest.q, atol=1e-12 * np.abs(q).max())
    # All move along the mode shape.
    away, shape = q - rest.q, found.shapes[:, 1].real
    np.testing.assert_allclose(away, np.outer(away @ shape, shape) / (shape @ shape), atol=1e-9)
    np.testing.assert_allclose(away[0], -away[10], atol=1e-9)
    assert titles == [f"mode 2 of {model.n}: {found.frequency[1]:.4g} Hz"] * 20


def test_films_of_paths_and_modes_are_written(tmp_path):
    image = pytest.importorskip("PIL.Image")
    model = rod()
    path, found = lissom.continuation(model, max_steps=4), lissom.modes(model, np.zeros(2))
    path.animate(tmp_path / "path.gif", model, fps=10, duration=0.6)
    found.animate(tmp_path / "mode.gif", model, np.zeros(2), fps=10, duration=0.6)
    for name in ("path", "mode"):
        with image.open(tmp_path / f"{name}.gif") as film:
            assert film.n_frames == 6


def test_equilibria_do_not_move():
    rest = lissom.statics(rod())
    assert not hasattr(rest, "animate")
    with pytest.raises(AttributeError, match=r"continuation\(model\)\.animate") as error:
        rest.animate("x.gif")
    assert (error.value.name, error.value.obj) == ("animate", rest)
    with pytest.raises(AttributeError, match="has no attribute 'q1'"):
        _ = rest.q1


def test_a_timeline_has_the_rods_at_every_time(tmp_path):
    model = robot()
    result = lissom.simulate(model, 0.05)
    result.save(tmp_path / "x.vtkhdf")
    with h5py.File(tmp_path / "x.vtkhdf") as file:
        root = file["VTKHDF"]
        steps = root["Steps"].attrs["NSteps"]
        np.testing.assert_array_equal(root["Steps/Values"], result.t)
        points = root["Points"][:].reshape(steps, -1, 3)
        for number, link in enumerate(("upper", "lower")):
            tip = model.pose(result.q, link=link, t=result.t)[:, :3, 3]
            np.testing.assert_allclose(points[:, 25 * number + 24], tip, rtol=1e-12, atol=1e-15)
        speed = root["PointData/speed"][:].reshape(steps, -1)
        twist = model.velocity(result.q, result.v, link="lower", t=result.t)
        np.testing.assert_allclose(speed[:, 49], np.linalg.norm(twist[:, 3:], axis=1), rtol=1e-12, atol=1e-15)
        radius = root["PointData/radius"][:].reshape(steps, -1)
        np.testing.assert_allclose(radius[:, :50], 0.01, rtol=1e-14)


# Invalid arguments.


@pytest.mark.parametrize("name", ["x.txt", "x", "x.NC", ""])
def test_unknown_suffixes_are_refused(name, tmp_path):
    result = lissom.statics(rod())
    for call in (result.save, lissom.load, lissom.simulate(rod(), 0.01).animate):
        with pytest.raises(ValueError, match="has to end with one of"):
            call(tmp_path / name if name else name)


@pytest.mark.parametrize("suffix", [".lissom", ".npz", ".nc", ".vtkhdf", ".gif", ".html"])
def test_places_that_cannot_be_written(suffix, tmp_path):
    result = lissom.simulate(rod(), 0.01)
    path = tmp_path / "nowhere" / f"x{suffix}"
    write = {".gif": result.animate, ".html": result.report}.get(suffix, result.save)
    with pytest.raises(OSError, match="nowhere"):
        write(path)


@pytest.mark.parametrize(
    ("call", "extra", "module"),
    [
        (lambda result, folder: result.save(folder / "x.nc"), "files", "h5netcdf"),
        (lambda result, folder: result.save(folder / "x.vtkhdf"), "files", "h5py"),
        (lambda result, folder: result.to_xarray(), "files", "xarray"),
        (lambda result, folder: result.plot(), "plot", "matplotlib"),
        (lambda result, folder: result.animate(folder / "x.gif"), "plot", "matplotlib"),
        (lambda result, folder: lissom.load(folder / "x.nc"), "files", "h5py"),
    ],
)
def test_missing_extras_are_named(call, extra, module, tmp_path, monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == module else find(name))
    with pytest.raises(ImportError, match=rf"{module}.*pip install 'lissom\[{extra}\]'"):
        call(lissom.simulate(rod(), 0.01), tmp_path)


def test_films_without_ffmpeg(tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(FileNotFoundError, match="ffmpeg"):
        lissom.simulate(rod(), 0.01).animate(tmp_path / "x.mp4")
    assert not (tmp_path / "x.mp4").exists()


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"model": "rod"}, TypeError, "model: expected a Model"),
        ({"model": rod(modes=3)}, ValueError, "model: it has 3 coordinates, the result has 2"),
        ({"t": np.nan}, ValueError, "t: got nan"),
        ({"t": "now"}, TypeError, "t: expected a real number, got str"),
        ({"u": [1.0]}, ValueError, "u: expected 0 values, got 1"),
        ({"u": [[1.0], 2.0]}, TypeError, "u: expected a one-dimensional array of real numbers, got list"),
        ({"title": 1}, TypeError, "title: expected a str, got int"),
    ],
)
def test_senseless_reports_are_refused(options, error, message, tmp_path):
    path, model = tmp_path / "x.html", rod()
    for result, q in (
        (lissom.statics(model), ()),
        (lissom.continuation(model, max_steps=2), ()),
        (lissom.modes(model, [0.0, 0.0]), ([0.0, 0.0],)),
    ):
        given = {"model": model} | options
        with pytest.raises(error, match=message):
            result.report(path, given.pop("model"), *q, **given)
    assert not path.exists()


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"mode": 2}, ValueError, "mode: got 2, expected a number from 0 to 1"),
        ({"mode": -1}, ValueError, "mode: got -1"),
        ({"mode": 1.0}, TypeError, "mode: expected a whole number, got float"),
        ({"q": [0.0]}, ValueError, "q: expected 2 values, got 1"),
        ({"q": [0.0, np.inf]}, ValueError, "q: expected finite numbers, got inf"),
        ({"duration": 0}, ValueError, "duration: 0 is not a finite number above zero"),
        ({"duration": 1e9}, ValueError, "duration: 2.5e.10 pictures are more than 3000"),
        ({"fps": "fast"}, TypeError, "fps: expected a real number, got str"),
        ({"path": "x.png"}, ValueError, "has to end with one of"),
    ],
)
def test_senseless_films_of_modes_are_refused(options, error, message, tmp_path):
    model = rod()
    found = lissom.modes(model, [0.0, 0.0])
    given = {"path": tmp_path / "x.gif", "q": [0.0, 0.0]} | options
    with pytest.raises(error, match=message):
        found.animate(given.pop("path"), model, given.pop("q"), **given)
    assert list(tmp_path.iterdir()) == []


def test_paths_without_equilibria_are_not_shown(tmp_path):
    model = pendulum()
    result = lissom.continuation(model)
    assert len(result.path.q) == 0
    for call, name in ((result.report, "x.html"), (result.animate, "x.gif")):
        with pytest.raises(ValueError, match="it has no equilibria to show"):
            call(tmp_path / name, model)


@pytest.mark.parametrize(
    "options", [{"fps": 0}, {"fps": 1e9}, {"speed": 0.0}, {"speed": np.nan}, {"speed": 1e-9}]
)
def test_senseless_animations_are_refused(options, tmp_path):
    with pytest.raises(ValueError, match=r"fps|speed"):
        lissom.simulate(rod(), 0.01).animate(tmp_path / "x.gif", **options)
    assert not (tmp_path / "x.gif").exists()


def test_functions_of_python_cannot_be_kept(tmp_path):
    for force in (lambda t: (0.0, 0.0, t), pushed):
        model = lissom.Rod([segment()], loads=[lissom.Load(force=force)])
        result = lissom.simulate(model, 0.01)
        with pytest.raises(ValueError, match="Harmonic"):
            result.save(tmp_path / "x.lissom")
    assert not (tmp_path / "x.lissom").exists()


def pushed(t):
    return (0.0, 0.0, t)


def test_results_without_a_model(tmp_path):
    result = lissom.newmark(lambda t, q, v, a: a + q, (0.0, 1.0), [1.0], [0.0], dt=0.1)
    result.save(tmp_path / "x.nc")
    assert_same(lissom.load(tmp_path / "x.nc"), result)
    assert len(result.plot()) == 1
    for call in (result.animate, result.report, result.save):
        with pytest.raises(ValueError, match="its model is not known"):
            call(tmp_path / {"animate": "x.gif", "report": "x.html", "save": "x.vtkhdf"}[call.__name__])


def kept(tmp_path, tree, arrays=b""):
    """A file with this record."""
    text = tree if isinstance(tree, bytes) else json.dumps(tree).encode()
    path = tmp_path / "x.lissom"
    path.write_bytes(
        result_files.HEAD + result_files.VERSION + len(text).to_bytes(8, "little") + text + arrays
    )
    return path


def tree_of(result):
    """The tree of a record, and the bytes of its arrays."""
    content = records.write(result)
    end = 8 + int.from_bytes(content[:8], "little")
    return json.loads(content[8:end]), content[end:]


@pytest.mark.parametrize(
    "tree",
    [
        # Functions and classes that are no part of a result.
        {"made": ["MotionResult", "__subclasses__", [], {}]},
        {"made": ["Scene", "loads", ["version = 1"], {}]},
        {"made": ["Section", "__subclasses__", [], {}]},
        {"made": ["Section", "_restore_", [], {}]},
        {"made": ["Segment", "circle", [1.0], {}]},
        {"made": ["print", None, ["heard"], {}]},
        {"made": ["FitResult", None, ["a"], {}]},
        {"fields": ["dict", {"a": 1}]},
        {"fields": ["Link", {"nothing": 1}]},
        {"fields": ["Robot", {}]},
        {"namespace": {"__class__": 1}},
        {"model": 0},
        {"model": -1},
        {"unknown": 1},
        {"float": "1.0"},
        {"array": ["<f8", [1]], "tuple": []},
        # Arrays of objects, and more memory than the file has bytes.
        {"array": ["O", [1]]},
        {"array": ["O,f8", [1]]},
        {"array": ["(2,)f8", [1]]},
        {"array": ["V8", [1]]},
        {"array": ["<f8", [1 << 45]]},
        {"array": ["<f8", [0, -1]]},
        {"array": ["<f8", [True]]},
        {"array": ["U0", [1 << 40]]},
        {"scalar": ["<f8", [1]]},
        b'{"a":NaN}',
        b"[" * 200_000,
        b"\xff",
        [1, 2],
        None,
    ],
    ids=lambda tree: str(tree)[:40],
)
def test_files_hold_results_and_nothing_else(tree, tmp_path, capsys):
    with pytest.raises(ValueError, match="no result"):
        lissom.load(kept(tmp_path, tree, bytes(8)))
    assert capsys.readouterr().out == ""


def test_bytes_that_belong_to_no_array_are_refused(tmp_path):
    tree, arrays = tree_of(lissom.statics(rod()))
    assert lissom.load(kept(tmp_path, tree, arrays)).success
    for other in (arrays + b"x", arrays[:-1]):
        with pytest.raises(ValueError, match="no result"):
            lissom.load(kept(tmp_path, tree, other))


def test_reading_takes_time_in_proportion_to_the_file(tmp_path):
    """No value of a record can be named twice, so that no file is larger in memory than on the disk."""
    tree, arrays = tree_of(fitted())
    begun = time.process_time()
    lissom.load(kept(tmp_path, tree, arrays))
    once = time.process_time() - begun
    deep = json.dumps(tree).replace('"runs":', '"runs":' + "[" * 50 + "]" * 50 + ',"again":')
    with pytest.raises(ValueError, match="no result"):
        lissom.load(kept(tmp_path, deep.encode(), arrays))
    assert time.process_time() - begun < 50 * (once + 0.1)


def fitted():
    finger = lissom.Segment(0.3, 0.01, 3e5, 4e5, 1100, modes={"bend_y": 2}, retardation_time=0.02)
    model = lissom.Rod([finger])
    run = lissom.simulate(model, 0.1)
    tips = [model.pose(q)[:3, 3] for q in run.q[1:]]
    return lissom.fit(model, (run.t[1:], tips), {"segments[0].young_modulus": (1e5, 5e5, 1e6)})


def derived():
    return lissom.sensitivity(rod(), 0.05, parameters=["segments[0].young_modulus"], dt=5e-3)


WRONG = ["a word", 1.5, None, True, [], {"tuple": []}, {"dict": []}, {"namespace": {}}]


@pytest.mark.parametrize("make", [fitted, derived], ids=["fit", "sensitivity"])
def test_every_field_of_a_record_has_its_type(make, tmp_path):
    result = make()
    tree, arrays = tree_of(result)
    (name, values) = tree["fields"]
    assert_same(lissom.load(kept(tmp_path, tree, arrays)), result)
    for field, kind in records._annotations(name).items():
        for wrong in WRONG:
            value = records._Reader(memoryview(b"")).value(wrong)
            if records.fits(value, kind):
                continue
            changed = {"fields": [name, values | {field: wrong}]}
            with pytest.raises(ValueError, match="no result"):
                lissom.load(kept(tmp_path, changed, arrays))


def summarised():
    return lissom.simulate_many(rod(), 0.02, q0=np.zeros((3, rod().n)), dt=5e-3, keep="summary")


def vibrating():
    return lissom.modes(rod(), np.zeros(rod().n))


def resting():
    return lissom.statics(rod())


def differentiated():
    return lissom.equilibrium_sensitivity(rod(), ["segments[0].young_modulus"], frequencies=1)


@pytest.mark.parametrize(
    ("make", "attribute", "wrong"),
    [
        (summarised, "lowest", {"array": ["<f8", [0, 3]]}),
        (summarised, "mean", "a word"),
        (summarised, "message", {"tuple": []}),
        (summarised, "message", {"tuple": [1, 2, 3]}),
        (summarised, "slack", {"tuple": []}),
        (summarised, "stats", {"dict": [["steps", 1]]}),
        (vibrating, "shapes", None),
        (vibrating, "frequency", {"array": ["<f8", [0]]}),
        (resting, "q", {"array": ["<f8", [0]]}),
        (fitted, "names", {"tuple": []}),
        (fitted, "places", {"tuple": []}),
        (fitted, "covariance", {"array": ["<f8", [0]]}),
        (fitted, "data", {"tuple": [None]}),
        (fitted, "t", {"array": ["<f8", [0]]}),
        (derived, "names", {"tuple": ["a", "b"]}),
        (derived, "gradient", {"array": ["<f8", [0]]}),
        (derived, "_parameters", {"tuple": []}),
        (differentiated, "names", {"tuple": []}),
        (differentiated, "dq", {"array": ["<f8", [0, 1]]}),
    ],
    ids=lambda value: getattr(value, "__name__", str(value)[:30]),
)
def test_fields_of_a_record_have_the_same_lengths(make, attribute, wrong, tmp_path):
    """Other lengths and types, also in compiled results: they were only noticed by plots and datasets."""
    tree, arrays = tree_of(make())
    ((kind, content),) = tree.items()
    state = content[1] if kind == "fields" else content[2][0]["namespace"]
    before = 0
    if attribute not in state:
        # One of the recording of a fit.
        before = bytes_before(state, "data")
        ((_, (_, state)),) = state["data"]["tuple"][0].items()
    before += bytes_before(state, attribute)
    size = bytes_of(state[attribute])
    state[attribute] = wrong
    with pytest.raises(ValueError, match="no result"):
        lissom.load(kept(tmp_path, tree, arrays[:before] + arrays[before + size :]))


def test_fits_of_older_versions_are_read(tmp_path):
    """They had one recording, whose arrays were fields of the result."""
    result = fitted()
    tree, arrays = tree_of(result)
    (_, state) = tree["fields"]
    own = dict(state["data"]["tuple"][0]["fields"][1])
    del own["kind"]
    older = {}
    for name, node in state.items():
        older |= own if name == "data" else {name: node}
    tree["fields"][1] = older
    found = lissom.load(kept(tmp_path, tree, arrays))
    for name in ("residuals", "measured", "t", "places", "noise", "values"):
        np.testing.assert_array_equal(getattr(found, name), getattr(result, name))
    assert found.data[0].kind == result.data[0].kind


def bytes_before(state, attribute):
    """Number of bytes of the arrays in the fields before one."""
    return sum(map(bytes_of, [state[name] for name in list(state)[: list(state).index(attribute)]]))


def bytes_of(node):
    """Number of bytes of the arrays in a node."""
    if isinstance(node, list):
        return sum(map(bytes_of, node))
    if not isinstance(node, dict):
        return 0
    if set(node) <= {"array", "scalar"} and node:
        ((dtype, shape),) = node.values()
        return np.dtype(dtype).itemsize * int(np.prod(shape))
    return sum(map(bytes_of, node.values()))


@pytest.mark.parametrize(
    "tree",
    [
        {"dict": [[i * (2**61 - 1), 0] for i in range(20_000)]},
        {"array": ["<f8", [10**4000] * 2000]},
        {"array": ["f8," * 200_000, [1]]},
    ],
    ids=["colliding keys", "sizes", "dtype"],
)
@pytest.mark.timeout(20)
def test_small_files_are_read_quickly(tree, tmp_path):
    with pytest.raises(ValueError, match="no result"):
        lissom.load(kept(tmp_path, tree, bytes(8)))


def test_a_model_is_kept_once(tmp_path):
    result = lissom.sensitivity(
        rod(), 0.05, parameters=["segments[0].young_modulus", "segments[0].density"], dt=5e-3
    )
    text = json.dumps(tree_of(result)[0])
    assert text.count('["Rod", ') == 1
    result.save(tmp_path / "x.lissom")
    again = lissom.load(tmp_path / "x.lissom")
    assert again._parameters[0]._model is again._model


def test_files_of_old_versions_name_their_version(tmp_path):
    path = tmp_path / "x.lissom"
    path.write_bytes(b"lissom record 1\n0.2.0\n\x80\x05N.")
    with pytest.raises(ValueError, match=r"was written by version '0\.2\.0'.*load it with that version"):
        lissom.load(path)


@pytest.mark.parametrize("module", records.CHECKED)
def test_fields_of_all_records_can_be_compared(module):
    for name in records.PARTS[module]:
        assert records._annotations(name)


@pytest.mark.parametrize("model", [rod(), robot()], ids=["rod", "robot"])
def test_datasets_can_be_written_as_zarr(model, tmp_path):
    data = lissom.simulate(model, 0.02).to_xarray()
    data.to_zarr(tmp_path / "x.zarr", zarr_format=2)
    with xarray.open_zarr(tmp_path / "x.zarr") as read:
        assert read.equals(data)
        assert read.attrs == data.attrs


@pytest.mark.parametrize("chunked", [False, True])
def test_netcdf_files_cannot_swell(chunked, tmp_path):
    path = tmp_path / "x.nc"
    with h5py.File(path, "w") as file:
        options = {"chunks": (1 << 16,), "compression": "gzip"} if chunked else {"chunks": (1 << 16,)}
        file.create_dataset(result_files.RECORD, (1 << 42,), np.uint8, **options)
    with pytest.raises(ValueError, match="no result"):
        lissom.load(path)


def test_netcdf_files_cannot_lead_elsewhere(tmp_path):
    lissom.statics(rod()).save(tmp_path / "kept.nc")
    with h5py.File(tmp_path / "x.nc", "w") as file:
        file[result_files.RECORD] = h5py.ExternalLink(tmp_path / "kept.nc", result_files.RECORD)
    with pytest.raises(ValueError, match="no result"):
        lissom.load(tmp_path / "x.nc")


@pytest.mark.parametrize("compression", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
def test_npz_files_cannot_swell(compression, tmp_path):
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "|u1", "fortran_order": False, "shape": (1 << 42,)}
    )
    body = header.getvalue() + bytes(1 << 20 if compression == zipfile.ZIP_DEFLATED else 8)
    with zipfile.ZipFile(tmp_path / "x.npz", "w", compression) as archive:
        archive.writestr(result_files.MEMBER, body)
    with pytest.raises(ValueError, match="no result"):
        lissom.load(tmp_path / "x.npz")


@pytest.mark.parametrize("scene", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
@pytest.mark.filterwarnings("ignore::lissom.urdf.UrdfWarning")
def test_results_of_all_scenes_can_be_kept(scene, tmp_path):
    result = lissom.simulate(lissom.Scene.load(scene).model, 2e-3, dt=1e-3)
    result.save(tmp_path / "x.lissom")
    assert_same(lissom.load(tmp_path / "x.lissom"), result)


@pytest.mark.parametrize("module", ["contacts", "_lissom"])
def test_every_part_of_models_can_stand_in_a_record(module):
    parts = vars(importlib.import_module(f"lissom.{module}")).values()
    classes = [part for part in parts if isinstance(part, type) and dataclasses.is_dataclass(part)]
    public = {part.__name__ for part in classes if hasattr(lissom, part.__name__)}
    assert public
    assert public - {"Joint", "Touch"} <= records.CLASSES.keys()


@settings(max_examples=60, deadline=None)
@given(at=st.floats(0, 1, exclude_max=True), value=st.integers(0, 255), cut=st.booleans())
def test_damaged_files_are_refused_or_read(folder, at, value, cut):
    content = io.BytesIO(result_files.HEAD + result_files.record(lissom.statics(rod())))
    damaged = bytearray(content.getvalue())
    place = int(at * len(damaged))
    damaged[place] = value
    (folder / "damaged.lissom").write_bytes(damaged[:place] if cut else damaged)
    try:
        result = lissom.load(folder / "damaged.lissom")
    except ValueError:
        return
    assert not cut
    assert isinstance(result, lissom.StaticsResult)


@pytest.mark.parametrize("suffix", [".lissom", ".npz", ".nc"])
def test_files_of_others_are_refused(suffix, tmp_path):
    path = tmp_path / f"x{suffix}"
    path.write_bytes(b"something else")
    with pytest.raises(ValueError, match=r"x\.(lissom|npz|nc)"):
        lissom.load(path)


def test_the_version_that_wrote_a_file_is_named(tmp_path):
    path = tmp_path / "x.lissom"
    path.write_bytes(result_files.HEAD + b"9.9.9\n" + records.write(None)[:-1])
    with pytest.raises(ValueError, match=r"written by version '9\.9\.9'"):
        lissom.load(path)


def test_the_stubs_say_what_the_methods_take():
    folder = Path(lissom.__file__).parent
    stub = ast.parse((folder / "_lissom.pyi").read_text(encoding="utf-8"))
    classes = {node.name: node.body for node in stub.body if isinstance(node, ast.ClassDef)}
    # Objects from Python are reported by their class.
    (shown,) = (
        node
        for node in ast.parse((folder / "analysis" / "base.py").read_text(encoding="utf-8")).body
        if isinstance(node, ast.ClassDef) and node.name == "ParameterResult"
    )
    classes["ParameterResult"] = next(node.body for node in shown.body if isinstance(node, ast.If))
    owners = [
        owner for owner in result_files.RESULTS if not issubclass(getattr(lissom, owner), ParameterResult)
    ]
    seen = 0
    for owner in (*owners, "Simulation", "ParameterResult"):
        of_stub = {
            node.name: node
            for node in classes[owner]
            if isinstance(node, ast.FunctionDef)
            and not any(ast.unparse(d) == "property" for d in node.decorator_list)
        }
        own = vars(ParameterResult if owner == "ParameterResult" else getattr(lissom, owner)).items()
        methods = {k: f for k, f in own if inspect.isfunction(f) and not k.startswith("_")}
        for name, function in methods.items():
            arguments = of_stub[name].args
            names = [a.arg for a in (*arguments.args, *arguments.kwonlyargs)]
            parameters = inspect.signature(function).parameters
            assert list(parameters) == names
            defaults = [p.default for p in parameters.values() if p.default is not p.empty]
            documented = [ast.literal_eval(d) for d in (*arguments.defaults, *arguments.kw_defaults) if d]
            assert defaults == documented
            seen += 1
        known = (
            "plot",
            "animate",
            "picture",
            "report",
            "save",
            "to_xarray",
            "view",
            "contact_events",
            "peaks",
            "pose",
        )
        assert {n for n in of_stub if n in known} == set(methods)
    assert seen == 38


EVIL = "</script><script>alert(1)</script><!-- <!--<script> \"'> \u2028 javascript:alert(2)"


def test_names_do_not_end_the_data_of_a_report(tmp_path):
    """A name with the start of a comment was data that no browser could read."""
    result = lissom.simulate(lissom.Robot([lissom.Link(EVIL, rod=[segment()])]), 0.02, dt=5e-3)
    result.report(tmp_path / "x.html", title=EVIL)
    text = (tmp_path / "x.html").read_text(encoding="utf-8")
    data = re.findall(r'<script type="application/json"[^>]*>(.*?)</script>', text, re.DOTALL)
    assert len(data) > 2
    for each in data:
        assert "<" not in each
        json.loads(each)
    assert any(EVIL in json.dumps(json.loads(each), ensure_ascii=False).replace('\\"', '"') for each in data)
    assert text.count("<script") == len(data) + 1


def test_names_are_no_formulas_in_plots():
    from matplotlib import pyplot

    result = lissom.simulate(lissom.Robot([lissom.Link(r"$\frac$", rod=[segment()])]), 0.02, dt=5e-3)
    axes = result.plot()
    axes[0].figure.canvas.draw()
    pyplot.close(axes[0].figure)


@pytest.mark.parametrize("suffix", [".lissom", ".npz", ".nc"])
def test_a_flipped_bit_is_found(suffix, tmp_path):
    """Within the numbers of a record it gave another number."""
    result = lissom.simulate(lissom.Rod([segment()]), 0.01)
    path = tmp_path / f"x{suffix}"
    result.save(path)
    content = path.read_bytes()
    # The last copy is that of the record.
    at = content.rindex(np.ascontiguousarray(result.q).tobytes()[-24:])
    for place in range(at, at + 24, 5):
        changed = bytearray(content)
        changed[place] ^= 1
        path.write_bytes(changed)
        with pytest.raises(ValueError, match="is damaged: the checksum" if suffix != ".npz" else "path: "):
            lissom.load(path)


def test_records_without_a_checksum_are_read(tmp_path):
    result = lissom.simulate(lissom.Rod([segment()]), 0.01)
    path = tmp_path / "x.lissom"
    path.write_bytes(result_files.HEAD + result_files.VERSION + records.write(result))
    assert_same(lissom.load(path), result)


def test_a_path_without_points_has_nothing_to_show(tmp_path):
    model = lissom.Rod([segment()], loads=[lissom.Load(force=(0, 0, 1e6))])
    path = lissom.continuation(model, np.full(model.n, 20.0), load_factor=1.0)
    assert not path.success
    assert len(path.path.q) == 0
    for call in (path.report, path.animate):
        with pytest.raises(ValueError, match="it has no equilibria to show"):
            call(tmp_path / {"report": "x.html", "animate": "x.gif"}[call.__name__], model)
