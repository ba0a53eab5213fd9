"""NetCDF files of trajectories, written without xarray, as xarray reads and writes them."""

import io
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray

import lissom
from lissom.results.files import trajectory
from lissom.results.netcdf import Data, Variable, written
from lissom.results.runs import Run

SCENES = Path(__file__).parents[3] / "scenes"


def read(content):
    return xarray.load_dataset(io.BytesIO(content), engine="h5netcdf")


def by_xarray(data):
    """The file that xarray writes of the same data."""
    made = xarray.Dataset(dict(data.variables), dict(data.coordinates), dict(data.attributes))
    return bytes(made.to_netcdf(engine="h5netcdf"))


def assert_same_files(data):
    ours, theirs = read(written(data)), read(by_xarray(data))
    xarray.testing.assert_identical(ours, theirs)
    assert ours.encoding["unlimited_dims"] == theirs.encoding["unlimited_dims"]
    for name, variable in ours.variables.items():
        other = theirs.variables[name]
        assert variable.dtype == other.dtype
        for key in ("dtype", "_FillValue", "coordinates"):
            np.testing.assert_equal(variable.encoding.get(key), other.encoding.get(key))
    return ours


@pytest.mark.parametrize("name", ["lab-horizontal", "lab-pendulum", "arm", "octopus"])
def test_a_trajectory_is_written_as_xarray_writes_it(name):
    with warnings.catch_warnings():
        # What a URDF file contains and robots have not.
        warnings.simplefilter("ignore", lissom.urdf.UrdfWarning)
        scene = lissom.Scene.load(SCENES / f"{name}.toml")
    run = Run(scene, lissom.simulate(scene.model, 0.02, q0=scene.q0, v0=scene.v0))
    data = trajectory(run)
    ours = assert_same_files(data)
    np.testing.assert_array_equal(ours.time, run.t)
    np.testing.assert_array_equal(ours.q, run.q)
    assert ours.q.attrs["units"] == "see unit"
    assert list(ours.q.unit.values) == [coordinate.unit for coordinate in run.view.coordinates]
    assert set(ours.coords) == set(data.coordinates)


def test_missing_numbers_unicode_and_empty_dimensions_are_written_as_xarray_writes_them():
    table = Variable(("row", "column"), np.array([[1.0, np.nan], [-np.inf, 5e-324]]), {"units": "Ω·m"})
    data = Data(
        {
            "column": Variable(("column",), np.array(["ä", ""]), {}),
            "unit": Variable(("column",), np.array(["m", "µm²"]), {"long_name": "単位"}),
            "none": Variable(("none",), np.array([], str), {}),
        },
        {
            "table": table,
            "single": Variable(("column",), np.array([1.5, 2.5], np.float32), {}),
            "nothing": Variable(("row", "none"), np.empty((2, 0)), {"units": ""}),
        },
        {"title": "Prüfung", "empty": ""},
    )
    ours = assert_same_files(data)
    np.testing.assert_array_equal(ours.table, table.values)
    assert list(ours.unit.values) == ["m", "µm²"]


def test_sizes_that_differ_are_an_error():
    values = {"a": Variable(("x",), np.zeros(2), {}), "b": Variable(("x",), np.zeros(3), {})}
    with pytest.raises((ValueError, TypeError)):
        written(Data({}, values, {}))
