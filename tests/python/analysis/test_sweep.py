"""Sweeps: every point equals a separate run, is computed once, in any process."""

import concurrent.futures
import json
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import click
import numpy as np
import pytest
import zarr
from hypothesis import given
from hypothesis import strategies as st

import lissom
from lissom.analysis.sweeps import executors
from lissom.analysis.sweeps.source import source_of
from lissom.cli.sweep import Over
from lissom.model import paths

SCENES = Path(__file__).parents[3] / "scenes"
E = "rod[0].segment[0].young_modulus"
G = "scene.gravity[2]"
TEXT = """
version = 1
[scene]
name = "soft \\"arm\\""
gravity = [0, 0, -9.81]
[[rod]]
q0 = [0.1, 0.0]
[[rod.segment]]
length = 0.3
radius = 0.01
young_modulus = 1e6
poisson_ratio = 0.4
density = 1000.0
modes = { bend_y = 2 }
retardation_time = 0.01
[simulation]
t_end = 0.1
dt = 5e-3
"""


def scene(text=TEXT):
    return lissom.Scene.loads(text)


def rod(young_modulus=1e6, modes=2):
    """A model created by a function, which other processes find by its name."""
    soft = lissom.Segment(
        0.3,
        0.01,
        young_modulus,
        density=1000.0,
        modes={"bend_y": int(modes)},
        retardation_time=0.01,
        poisson_ratio=0.4,
    )
    return lissom.Rod([soft])


def tip_speed(result):
    """The measured quantity of a run."""
    velocity = result.model.velocity(result.q, result.v, t=result.t)
    return {"speed": np.linalg.norm(velocity[:, 3:], axis=1).max(), "last": velocity[-1]}


def slow_rod(young_modulus, seconds):
    """A rod that is slow to create."""
    time.sleep(seconds)
    return rod(young_modulus)


def assert_points_are_runs(found, values, make):
    """Every point of a sweep over a parameter is bitwise equal to its run."""
    for i, value in enumerate(values):
        alone, model = make(value)
        point = found.isel({found.q.dims[0]: i})
        np.testing.assert_array_equal(point.q, alone.q[-1])
        np.testing.assert_array_equal(point.v, alone.v[-1])
        np.testing.assert_array_equal(point.lowest, alone.q.min(axis=0))
        np.testing.assert_array_equal(point.highest, alone.q.max(axis=0))
        positions = model.pose(alone.q)[:, :3, 3]
        np.testing.assert_array_equal(point.position[0], positions[-1])
        np.testing.assert_array_equal(point.position_lowest[0], positions.min(axis=0))
        np.testing.assert_array_equal(point.position_highest[0], positions.max(axis=0))
        assert (str(point.status.item()), point.steps.item()) == (alone.status, alone.stats.steps)
        assert str(point.message.item()) == alone.message
    assert found.is_done.all()


def test_points_of_a_scene_are_its_runs():
    values = [5e5, 1e6, 2e6]
    found = lissom.sweep(scene(), {E: values})

    def alone(value):
        changed = scene(TEXT.replace("1e6", repr(value)))
        return changed.run(), changed.model

    assert_points_are_runs(found, values, alone)
    assert found[E].values.tolist() == values
    assert list(found.place.values) == ["rod"]


def test_points_of_a_model_and_of_a_function_are_runs_of_simulate():
    values = np.array([5e5, 1e6])
    options = {"t_end": 0.1, "dt": 5e-3, "q0": [0.1, 0.0]}
    model = lissom.Rod([lissom.Segment(0.3, 0.01, 1e6, 3.5e5, 1000.0, {"bend_y": 2})])

    def of_model(value):
        changed = lissom.Rod([lissom.Segment(0.3, 0.01, value, 3.5e5, 1000.0, {"bend_y": 2})])
        return lissom.simulate(changed, **options), changed

    assert_points_are_runs(lissom.sweep(model, {E: values}, **options), values, of_model)

    def of_function(value):
        return lissom.simulate(rod(value), **options), rod(value)

    found = lissom.sweep(rod, {"young_modulus": values}, **options)
    assert_points_are_runs(found, values, of_function)


def test_all_values_meet_all_others_or_the_same_of_the_others():
    parameters = {E: [5e5, 1e6, 2e6], G: [-9.81, 0.0]}
    grid = lissom.sweep(scene(), parameters)
    assert grid.q.dims == (E, G, "coordinate")
    for i, j in np.ndindex(3, 2):
        text = TEXT.replace("1e6", repr(parameters[E][i])).replace("-9.81]", f"{parameters[G][j]}]")
        np.testing.assert_array_equal(grid.q[i, j], scene(text).run().q[-1])
    zipped = lissom.sweep(scene(), {E: [5e5, 1e6], G: [-9.81, 0.0]}, combine="zip")
    assert zipped.q.dims == ("point", "coordinate")
    np.testing.assert_array_equal(zipped.q, grid.q.values[[0, 1], [0, 1]])
    assert zipped[G].dims == ("point",)


def test_states_at_all_times_may_be_kept():
    found = lissom.sweep(scene(), {E: [5e5, 1e6]}, keep="states", places=[0.1, 0.3])
    alone = scene().run()
    np.testing.assert_array_equal(found.time, alone.t)
    np.testing.assert_array_equal(found.q[1], alone.q)
    np.testing.assert_array_equal(found.position[1, :, 0], scene().model.pose(alone.q, 0.1)[:, :3, 3])
    assert list(found.place.values) == ["X = 0.1", "X = 0.3"]
    with pytest.raises(ValueError, match=r"keep: .*'simulation\.dt' changes the times"):
        lissom.sweep(scene(), {"simulation.dt": [5e-3, 1e-2]}, keep="states")
    given = lissom.sweep(scene(), {"simulation.dt": [5e-3, 1e-2]}, keep="states", t_eval=[0.0, 0.05, 0.1])
    assert given.q.shape == (2, 3, 2)


def test_what_is_measured_is_there_by_name():
    found = lissom.sweep(scene(), {E: [5e5, 1e6]}, measure=tip_speed)
    alone = tip_speed(scene().run())
    assert found.speed[1] == alone["speed"]
    np.testing.assert_array_equal(found["last"][1], alone["last"])
    only = lissom.sweep(scene(), {E: [1e6]}, measure=lambda result: result.q.max())
    assert only.measured.item() == scene().run().q.max()

    def broken(result):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        lissom.sweep(scene(), {E: [1e6]}, measure=broken)


def test_numbers_of_modes_may_be_swept():
    found = lissom.sweep(rod, {"modes": [2, 3]}, t_end=0.05)
    assert found.success.all()
    assert not np.isnan(found.position).any()
    assert np.isnan(found.q[1]).all()
    assert not np.isnan(found.q[0]).any()


def test_a_point_that_makes_no_sense_and_one_that_fails_disturb_no_other():
    found = lissom.sweep(touchy, {"young_modulus": [1e6, 2e6], "force": [0.0, 1e300]}, t_end=0.05, dt=5e-3)
    assert found.success.values.tolist() == [[True, False], [True, False]]
    assert found.reached.values[0, 1] < 0.05
    assert str(found.status.values[1, 1]) == "refused"
    assert "no such rod" in str(found.message.values[1, 1])
    assert np.isnan(found.position[1, 1]).all()
    np.testing.assert_array_equal(found.q[1, 0], lissom.simulate(touchy(2e6, 0.0), 0.05, dt=5e-3).q[-1])


def touchy(young_modulus, force):
    """A rod that is invalid if the modulus and the force are both large."""
    if young_modulus == 2e6 and force > 0.0:
        raise ValueError("no such rod")
    soft = lissom.Segment(0.3, 0.01, young_modulus, 0.36 * young_modulus, 1000.0, {"bend_y": 2})
    push = lissom.Load(force=([0.0, 0.02, 0.021], [(0, 0, 0), (0, 0, 0), (0, 0, force)]))
    return lissom.Rod([soft], loads=[push])


REFUSED = {
    "did you mean": ({"rod[0].segment[0].yuong_modulus": [1e6]}, "unknown key; did you mean `young_modulus`"),
    "no table": ({"rad[0].segment[0].radius": [1e-2]}, "rad: the scene has no such key.*did you mean 'rod'"),
    "a default": ({"gravity[2]": [-1.6]}, r"gravity: the scene has no such key.*for 'scene.gravity\[2\]'"),
    "no segment": ({"rod[0].segment[3].radius": [1e-2]}, r"rod\[0\].segment\[3\]: the scene has 1 entry"),
    "no path": ({"rod[.x": [1.0]}, "expected a path of keys"),
    "index first": ({"[0].radius": [1e-2]}, "expected a path of keys"),
    "star first": ({"[*].radius": [1e-2]}, "expected a path of keys"),
    "value": ({E: [1e6, -1.0]}, r"young_modulus'\]\[1\]: got -1.0: .*expected a finite number > 0"),
    "nan": ({E: [1e6, np.nan]}, r"young_modulus'\]\[1\]: got nan, expected a finite number"),
    "twice": ({E: [1e6, 1e6]}, "is listed twice: give each value once"),
    "no values": ({E: []}, "got no values"),
}


@pytest.mark.parametrize(("parameters", "message"), REFUSED.values(), ids=REFUSED)
def test_what_makes_no_sense_is_refused_before_the_first_run(parameters, message, tmp_path, monkeypatch):
    monkeypatch.setattr("lissom.analysis.sweeps.run_points", pytest.fail)
    with pytest.raises(ValueError, match=message):
        lissom.sweep(scene(), parameters, store=tmp_path / "store")
    assert not (tmp_path / "store").exists()


def test_other_arguments_are_refused():
    for changes, error in (
        ({"parameters": {}}, TypeError),
        ({"parameters": {E: 1e6}}, TypeError),
        ({"parameters": {E: [None]}}, TypeError),
        ({"combine": "both"}, ValueError),
        ({"combine": "zip", "parameters": {E: [1e6], G: [0.0, 1.0]}}, ValueError),
        ({"keep": "all"}, ValueError),
        ({"measure": 3}, TypeError),
        ({"executor": 3}, TypeError),
        ({"progress": 3}, TypeError),
        ({"control": lambda *_: 0}, TypeError),
        ({"control_step": 0.1}, TypeError),
        ({"model": 3}, TypeError),
        ({"dt": -1.0}, ValueError),
        ({"nonsense": 1}, TypeError),
        ({"model": rod, "parameters": {"yuong_modulus": [1e6]}}, ValueError),
        ({"model": rod(), "parameters": {E: [1e6]}}, TypeError),
    ):
        with pytest.raises(error):
            lissom.sweep(**({"model": scene(), "parameters": {E: [1e6]}} | changes))
    # What is refused is not offered.
    with pytest.raises(TypeError, match=r"'nonsense', expected executor, .*, predictor") as caught:
        lissom.sweep(scene(), {E: [1e6]}, nonsense=1)
    assert "control" not in str(caught.value)
    with pytest.raises(ValueError, match="did you mean 'young_modulus'"):
        lissom.sweep(rod, {"yuong_modulus": [1e6]}, t_end=0.1)
    with pytest.raises(ValueError, match="did you mean 'young_modulus'"):
        lissom.sweep(rod(), {"segments[0].yuong_modulus": [1e6]}, t_end=0.1)


def test_a_store_is_gone_on_with_and_nothing_is_made_twice(tmp_path, monkeypatch):
    values, store = np.linspace(5e5, 2e6, 12), tmp_path / "store.zarr"
    whole = lissom.sweep(scene(), {E: values})
    made = []
    real = lissom.analysis.sweeps.run_points

    def counted(source, points, wants):
        made.extend(point[E] for point in points)
        if len(made) > 6:
            made[:] = made[: -len(points)]
            raise KeyboardInterrupt
        return real(source, points, wants)

    for module in ("lissom.analysis.sweeps", "lissom.analysis.sweeps.executors"):
        monkeypatch.setattr(f"{module}.run_points", counted)
    # Tasks of one point each.
    monkeypatch.setattr("lissom.analysis.sweeps.executors.TASK", 0.0)
    with pytest.raises(KeyboardInterrupt) as caught:
        lissom.sweep(scene(), {E: values}, store=store)
    partly = caught.value.result
    assert partly.is_done.values.tolist() == [True] * 6 + [False] * 6
    np.testing.assert_array_equal(partly.q[:6], whole.q[:6])
    assert np.isnan(partly.q[6:]).all()
    again = []
    monkeypatch.setattr(
        "lissom.analysis.sweeps.executors.run_points",
        lambda source, points, wants: again.extend(p[E] for p in points) or real(source, points, wants),
    )
    monkeypatch.setattr(
        "lissom.analysis.sweeps.run_points",
        lambda source, points, wants: again.extend(p[E] for p in points) or real(source, points, wants),
    )
    found = lissom.sweep(scene(), {E: values}, store=store)
    assert made + again == values.tolist()
    assert_equal(found, whole)
    again.clear()
    assert_equal(lissom.sweep(scene(), {E: values}, store=store), whole)
    assert again == []


def assert_equal(found, other):
    """Equal except for run times."""
    assert found.drop_vars("wall_time").identical(other.drop_vars("wall_time"))


def missing(chunk):
    chunk.unlink()


def cut(chunk):
    content = chunk.read_bytes()
    chunk.write_bytes(content[: len(content) // 2])


def empty(chunk):
    chunk.write_bytes(b"")


def another(chunk):
    """A valid chunk with other numbers."""
    array = zarr.open_array(str(chunk.parent), mode="r+")
    values = array[:]
    array[:] = values + 1.0 if values.dtype.kind == "f" else values[::-1]


@pytest.mark.parametrize("damage", [missing, cut, empty, another])
@pytest.mark.parametrize("name", ["q", "status", "success", "checksum"])
def test_damaged_points_of_a_store_are_named_and_run_again(damage, name, tmp_path):
    values, store = np.linspace(5e5, 2e6, 6), tmp_path / "store.zarr"
    whole = lissom.sweep(scene(), {E: values}, store=store)
    (chunk, *_) = sorted(path for path in (store / name).iterdir() if not path.name.startswith("."))
    before = zarr.open_array(str(store / name), mode="r")[:]
    damage(chunk)
    if damage is another and np.array_equal(zarr.open_array(str(store / name), mode="r")[:], before):
        return  # the same value for every point
    with pytest.warns(RuntimeWarning, match=r"of 6 points are damaged \(\d to 5\); they are run again"):
        found = lissom.sweep(scene(), {E: values}, store=store)
    assert_equal(found, whole)
    reported = []
    assert_equal(lissom.sweep(scene(), {E: values}, store=store, progress=reported.append), whole)
    assert reported[0] == 6, "nothing is run a third time"


def chunks_but_marks(store):
    """As of a copy that was not finished."""
    for chunk in store.glob("*/[0-9]*"):
        if chunk.parent.name != "is_done":
            chunk.unlink()


def exchanged(store):
    """Results and checksums of two points, exchanged in all arrays."""
    for folder in store.iterdir():
        if folder.is_dir():
            array = zarr.open_array(str(folder), mode="r+")
            array[:] = array[:][::-1]


def of_single_precision(store):
    metadata = store / "q" / ".zarray"
    metadata.write_text(metadata.read_text().replace("<f8", "<f4"))


def of_other_width(store):
    metadata = json.loads((store / "q" / ".zarray").read_text())
    (store / "q" / ".zarray").write_text(json.dumps(metadata | {"shape": [2, 3], "chunks": [2, 3]}))


def without_metadata(store):
    (store / "status" / ".zarray").write_text("{")


@pytest.mark.parametrize(
    "damage", [chunks_but_marks, exchanged, of_single_precision, of_other_width, without_metadata]
)
def test_damaged_stores_are_run_again(damage, tmp_path):
    store = tmp_path / "store.zarr"
    whole = lissom.sweep(scene(), {E: [5e5, 2e6]}, store=store)
    damage(store)
    with pytest.warns(RuntimeWarning, match=r"2 of 2 points are damaged \(0 to 1\); they are run again"):
        assert_equal(lissom.sweep(scene(), {E: [5e5, 2e6]}, store=store), whole)
    assert_equal(lissom.sweep(scene(), {E: [5e5, 2e6]}, store=store), whole)


def test_marks_and_files_of_others_do_not_matter(tmp_path):
    store = tmp_path / "store.zarr"
    whole = lissom.sweep(scene(), {E: [5e5, 2e6]}, store=store)
    (store / "is_done" / "0").unlink()
    (store / "notes.txt").write_text("mine")
    reported = []
    assert_equal(lissom.sweep(scene(), {E: [5e5, 2e6]}, store=store, progress=reported.append), whole)
    assert reported[0] == 2
    assert zarr.open_array(str(store / "is_done"), mode="r")[:].all()
    with pytest.raises(ValueError, match="is a file"):
        lissom.sweep(scene(), {E: [5e5, 2e6]}, store=store / "notes.txt")


def test_a_store_without_an_array_is_damaged(tmp_path):
    store = tmp_path / "store.zarr"
    lissom.sweep(scene(), {E: [1e6, 2e6]}, store=store)
    shutil.rmtree(store / "is_done")
    with pytest.raises(ValueError, match="damaged"):
        lissom.sweep(scene(), {E: [1e6, 2e6]}, store=store)


def test_a_store_of_another_sweep_is_refused(tmp_path):
    store = tmp_path / "store.zarr"
    lissom.sweep(scene(), {E: [1e6]}, store=store)
    for changes, what in (
        ({"parameters": {E: [2e6]}}, "parameters"),
        ({"model": scene(TEXT.replace("0.3", "0.4"))}, "model"),
        ({"dt": 1e-3}, "options"),
        ({"keep": "states"}, "keep"),
        ({"places": [0.1]}, "places"),
        ({"measure": tip_speed}, "measure"),
    ):
        with pytest.raises(ValueError, match=rf"another sweep \(other .*{what}"):
            lissom.sweep(**({"model": scene(), "parameters": {E: [1e6]}, "store": store} | changes))
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "file").write_text("mine")
    with pytest.raises(ValueError, match="no store of a sweep"):
        lissom.sweep(scene(), {E: [1e6]}, store=tmp_path / "other")
    assert (tmp_path / "other" / "file").read_text() == "mine"


@pytest.mark.parametrize("kind", ["ThreadPoolExecutor", "ProcessPoolExecutor"])
def test_executors_make_the_same(kind, tmp_path):
    parameters = {E: np.linspace(5e5, 2e6, 9), G: [-9.81, 0.0]}
    whole, reported = lissom.sweep(scene(), parameters), []
    context = {} if kind[0] == "T" else {"mp_context": __import__("multiprocessing").get_context("spawn")}
    with getattr(concurrent.futures, kind)(2, **context) as executor:
        found = lissom.sweep(
            scene(), parameters, executor=executor, store=tmp_path / "s", progress=reported.append
        )
    assert_equal(found, whole)
    assert reported == sorted(reported)
    assert reported[-1] == 18


def test_a_cancelled_task_is_handed_out_again():
    class Careless(concurrent.futures.ThreadPoolExecutor):
        cancelled = 0

        def submit(self, *arguments):
            if self.cancelled < 2:
                self.cancelled += 1
                future = concurrent.futures.Future()
                future.cancel()
                future.set_running_or_notify_cancel()
                return future
            return super().submit(*arguments)

    with Careless(2) as executor:
        found = lissom.sweep(scene(), {E: np.linspace(5e5, 2e6, 9)}, executor=executor)
    assert_equal(found, lissom.sweep(scene(), {E: np.linspace(5e5, 2e6, 9)}))


@pytest.mark.slow
def test_ctrl_c_leaves_a_store_that_is_gone_on_with(tmp_path):
    parameters = {"young_modulus": np.linspace(5e5, 2e6, 40).tolist(), "seconds": [0.02]}
    timer = threading.Timer(0.1, signal.raise_signal, [signal.SIGINT])

    def interrupt_soon(done):
        # The first run is one by itself; the 39 others take 0.8 s of sleep.
        if done >= 1 and timer.ident is None:
            timer.start()

    with pytest.raises(KeyboardInterrupt) as caught:
        lissom.sweep(slow_rod, parameters, store=tmp_path / "s", t_end=0.05, progress=interrupt_soon)
    timer.join()
    done = int(caught.value.result.is_done.sum())
    assert 1 <= done < 40
    reported = []
    found = lissom.sweep(slow_rod, parameters, store=tmp_path / "s", t_end=0.05, progress=reported.append)
    assert reported[0] == done
    assert_equal(found, lissom.sweep(slow_rod, parameters, t_end=0.05))


DASK = """
import os, signal, sys, threading, time
import numpy as np
import dask
import lissom
from distributed import Client, LocalCluster

TEXT = {text!r}
E = {E!r}


def main():
    dask.config.set({{"distributed.worker.daemon": False}})
    scene, values = lissom.Scene.loads(TEXT), np.linspace(5e5, 2e6, 60)
    whole = lissom.sweep(scene, {{E: values}}, dt=2e-5)
    options = dict(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None)
    with LocalCluster(**options) as cluster, Client(cluster) as client:
        first = set(client.run(os.getpid).values())
        reported = []

        def kill(done):
            reported.append(done)
            if done >= 10 and len(reported) > 2 and victim:
                os.kill(victim.pop(), signal.SIGKILL)

        victim = [min(first)]
        found = lissom.sweep(scene, {{E: values}}, dt=2e-5, executor=client, store=sys.argv[1], progress=kill)
        assert not victim, "nobody was killed"
        deadline = time.monotonic() + 30
        while set(client.run(os.getpid).values()) == first and time.monotonic() < deadline:
            time.sleep(0.2)
        assert set(client.run(os.getpid).values()) != first
    assert found.is_done.all()
    assert reported[-1] == 60 and reported == sorted(set(reported)), reported
    assert found.drop_vars("wall_time").identical(whole.drop_vars("wall_time"))
    print("same")


if __name__ == "__main__":
    main()
"""


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_a_worker_of_dask_that_is_killed_loses_nothing_and_makes_nothing_twice(tmp_path):
    pytest.importorskip("distributed")
    program = tmp_path / "program.py"
    program.write_text(DASK.format(text=TEXT, E=E))
    done = subprocess.run(
        [sys.executable, program, tmp_path / "store"],
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert done.stdout.strip() == "same", done.stderr[-3000:]


@pytest.mark.filterwarnings("ignore::lissom.urdf.UrdfWarning")
@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_documents_of_all_scenes_come_through(path):
    original = lissom.Scene.load(path)
    source = source_of(original, {})
    again = source.case({"simulation.dt": original.simulation.dt})
    assert paths.plain(again.model) == paths.plain(original.model)
    assert again.options.keys() == original.options.keys()
    for name, value in original.options.items():
        np.testing.assert_array_equal(again.options[name], value, name)


@pytest.mark.filterwarnings("ignore::lissom.urdf.UrdfWarning")
@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_models_of_all_scenes_are_made_again(path):
    model = lissom.Scene.load(path).model
    source = source_of(model, {"t_end": 1.0})
    gravity = model.gravity
    path, value = ("gravity[0]", gravity[0]) if isinstance(model, lissom.Robot) else ("gravity", gravity)
    same = source.case({path: value}).model
    assert paths.plain(same) == paths.plain(model)
    assert type(same) is type(model)


def test_parts_of_robots_are_reached_by_the_names_of_scenes():
    model = lissom.Scene.load(SCENES / "finger.toml").model
    source = source_of(model, {"t_end": 1.0})
    changed = source.case({"link[1].rod.segment[0].young_modulus": 3e5, "link[0].body.mass": 0.03}).model
    assert changed.links[1].rod[0].young_modulus == 3e5
    assert changed.links[0].body.mass == 0.03
    assert changed.links[1].rod[0].length == model.links[1].rod[0].length
    with pytest.raises(ValueError, match="did you mean 'links'"):
        source.case({"lnks[0].body.mass": 0.03})


@given(
    st.recursive(
        st.booleans() | st.integers(-(2**60), 2**60) | st.floats(allow_nan=False) | st.text(),
        lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
        max_leaves=8,
    )
)
def test_what_is_written_as_toml_is_read_again(value):
    import tomllib

    assert tomllib.loads(paths.document_text({"key": value})) == {"key": value}


@given(st.lists(st.from_regex(r"[A-Za-z0-9_-]+", fullmatch=True) | st.integers(0, 99), min_size=1))
def test_paths_are_their_parts(found):
    if isinstance(found[0], int):
        found = ["rod", *found]
    assert paths.parts(paths.up_to(found, len(found))) == found


@pytest.mark.parametrize("text", ["", ".", "a.", ".a", "a..b", "a[", "a[]", "a[-1]", "[0]", "a b", "a.[0]"])
def test_what_is_no_path_is_refused(text):
    with pytest.raises(ValueError, match="expected a path"):
        paths.parts(text)


def test_chunks_take_about_a_second_and_are_shared_at_the_end():
    chunks = executors.Chunks(range(1000), 2, 10**6)
    assert chunks.next() == [0]
    chunks.took(1, 0.01)
    assert len(chunks.next()) == 100
    chunks.took(100, 10.0)
    assert len(chunks.next()) == 10
    chunks.left = type(chunks.left)(range(8))
    assert len(chunks.next()) == 2
    bounded = executors.Chunks(range(1000), None, 7)
    bounded.took(1, 1e-6)
    assert len(bounded.next()) == 7


def test_without_xarray_or_zarr_the_extra_is_named(monkeypatch):
    monkeypatch.setattr(
        "lissom.analysis.sweeps.missing", lambda *names: [name for name in names if name == "zarr"]
    )
    with pytest.raises(ImportError, match=r"zarr: pip install 'lissom\[sweep\]'"):
        lissom.sweep(scene(), {E: [1e6]}, store="somewhere")


def command(*arguments, cwd):
    """Run `lissom sweep` as a process."""
    program = [sys.executable, "-m", "lissom", "sweep", *map(str, arguments)]
    return subprocess.run(program, cwd=cwd, capture_output=True, text=True, timeout=100, check=False)


@pytest.mark.slow
def test_the_command_writes_numbers_and_a_report(tmp_path):
    import xarray

    (tmp_path / "arm.toml").write_text(TEXT)
    over = ["--over", f"{E}=5e5:2e6:3:log", "--over", f"{G}=-9.81,0.0"]
    done = command("arm.toml", *over, "--workers", 2, "--store", "store.zarr", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    folder = tmp_path / "results" / "arm-sweep"
    assert sorted(file.name for file in folder.iterdir()) == ["report.html", "summary.json", "sweep.nc"]
    found = xarray.load_dataset(folder / "sweep.nc", engine="h5netcdf")
    whole = lissom.sweep(scene(), {E: [5e5, 1e6, 2e6], G: [-9.81, 0.0]})
    np.testing.assert_allclose(found[E], [5e5, 1e6, 2e6], rtol=1e-12)
    np.testing.assert_allclose(found.position, whole.position, rtol=1e-9)
    page = (folder / "report.html").read_text()
    for text in ("z of rod at the end (m)", E, "6 of 6 runs succeeded"):
        assert text in page
    again = command("arm.toml", *over, "--store", "store.zarr", "--no-report", cwd=tmp_path)
    assert again.returncode == 0
    assert sorted(file.name for file in folder.iterdir()) == ["summary.json", "sweep.nc"]


def test_the_command_says_what_failed(tmp_path):
    (tmp_path / "pushed.toml").write_text(TEXT.replace("[[rod]]", "[[rod]]\ntip_force = [0, 0, 0]"))
    done = command("pushed.toml", "--over", "rod[0].tip_force[2]=0,1e300", cwd=tmp_path)
    assert done.returncode == 1
    assert "1 of 2 runs succeeded" in done.stdout
    assert "Runs that failed" in (tmp_path / "results" / "pushed-sweep" / "report.html").read_text()


@pytest.mark.parametrize(
    ("over", "message"),
    [
        ("", "expected KEY=FROM:TO:N, "),
        ("a", "expected KEY=FROM:TO:N, "),
        ("a=", "expected KEY=FROM:TO:N, "),
        ("=1", "expected KEY=FROM:TO:N, "),
        ("a=1,,2", "a value between commas is missing"),
        ("a=1:2", "got 2 parts between colons"),
        ("a=1:2:3:log:5", "got 5 parts between colons"),
        ("a=x:2:3", "FROM is 'x', expected a finite number"),
        ("a=...:2:3", "FROM is '...', expected a finite number"),
        ("a=1:inf:3", "TO is 'inf', expected a finite number"),
        ("a=1::3", "TO is '', expected a finite number"),
        ("a=1:2:x", "N is 'x', expected how many values: a whole number"),
        ("a=1:2:3.5", "N is '3.5', expected how many values: a whole number"),
        ("a=1:2:1", "N is 1, expected at least two values"),
        ("a=1:2:999999999999", "N is 999999999999, expected at least two values, and at most 1,000,000"),
        ("a=1:1:3", "FROM and TO are both 1"),
        ("a=0:1:3:log", "a bound is 0, expected bounds > 0 with log"),
        ("a=1:2:3:lin", "'lin' follows N, expected nothing or 'log'"),
    ],
)
def test_the_command_refuses_what_is_no_range(over, message):
    with pytest.raises(click.BadParameter) as error:
        Over().convert(over, None, None)
    assert error.value.message.startswith(f"{over!r}: ")
    assert message in error.value.message


def test_the_command_says_what_is_wrong_with_a_range(tmp_path):
    (tmp_path / "arm.toml").write_text(TEXT)
    done = command("arm.toml", "--over", "a=1:2:x", cwd=tmp_path)
    assert done.returncode == 2
    assert "N is 'x', expected" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "results").exists()


def test_the_command_refuses_unknown_keys_and_other_stores(tmp_path):
    (tmp_path / "arm.toml").write_text(TEXT)
    done = command("arm.toml", "--over", "rod[0].segment[0].yuong_modulus=1,2", cwd=tmp_path)
    assert (done.returncode, "did you mean `young_modulus`" in done.stderr) == (2, True)
    assert command("arm.toml", "--over", f"{E}=1e6,2e6", "--store", "s", cwd=tmp_path).returncode == 0
    done = command("arm.toml", "--over", f"{E}=1e6,3e6", "--store", "s", cwd=tmp_path)
    assert (done.returncode, "another sweep" in done.stderr) == (2, True)
    done = command("arm.toml", "--over", f"{E}=1,2", "--over", f"{E}=1,2", cwd=tmp_path)
    assert (done.returncode, "twice" in done.stderr) == (2, True)


def test_ctrl_c_leaves_the_command_what_was_done(tmp_path):
    (tmp_path / "arm.toml").write_text(TEXT)
    program = [sys.executable, "-m", "lissom", "sweep", "arm.toml", "--over", f"{E}=5e5:2e6:400"]
    program += ["--over", "simulation.dt=2e-5,1.9e-5", "--store", "store.zarr"]
    process = subprocess.Popen(
        program, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    deadline = time.monotonic() + 60
    while not (tmp_path / "store.zarr" / "is_done" / "0").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    said, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "not made" in said
    assert (tmp_path / "results" / "arm-sweep" / "sweep.nc").exists()


def test_the_file_that_a_scene_imports_is_no_parameter(tmp_path):
    """All points share it; the value of each point was overwritten by the name of the one that was read."""
    text = '<robot name="r"><link name="a"/><link name="b"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>'
    text += '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
    text += '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint></robot>'
    (tmp_path / "one.urdf").write_text(text, encoding="utf-8")
    (tmp_path / "two.urdf").write_text(text.replace('mass value="1"', 'mass value="2"'), encoding="utf-8")
    path = tmp_path / "scene.toml"
    path.write_text(
        'version = 1\n[import]\nurdf = "one.urdf"\n[simulation]\nt_end = 0.1\ndt = 0.01\n', encoding="utf-8"
    )
    scene = lissom.Scene.load(path)
    with pytest.raises(ValueError, match=r"import\.urdf: an imported file is read with the scene"):
        lissom.sweep(scene, {"import.urdf": ["one.urdf", "two.urdf"]}, workers=1)
    assert lissom.sweep(scene, {"simulation.dt": [0.01, 0.02]}, workers=1).sizes["simulation.dt"] == 2


def test_an_array_whose_description_is_damaged_is_made_again(tmp_path):
    """It had held nothing, so that all points were as they had been, but the variable was left out."""
    scene = lissom.Scene.load(SCENES / "lab-pendulum.toml")
    grid = {"simulation.t_end": [0.01, 0.02]}
    before = lissom.sweep(scene, grid, store=tmp_path / "store", workers=1).load()
    (tmp_path / "store" / "is_doubtful" / ".zattrs").write_text("{", encoding="utf-8")
    again = lissom.sweep(scene, grid, store=tmp_path / "store", workers=1).load()
    assert sorted(before) == sorted(again)
    assert before.drop_vars("wall_time").equals(again.drop_vars("wall_time"))
