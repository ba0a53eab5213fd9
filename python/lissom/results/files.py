"""Files of results: those of scene runs, and common functions for all results."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._lissom import __version__
from ..common.extras import missing
from .folders import SUMMARY
from .netcdf import Data, Variable, written
from .runs import Array, Run, energies, shapes, statistics

if TYPE_CHECKING:
    from .._lissom import Scene

#: Modules that write trajectories, and those that write an xarray.Dataset as NetCDF.
HDF5 = ("h5py",)
NETCDF = ("xarray", "h5netcdf", *HDF5)


def trajectory(run: Run) -> Data:
    """The trajectory with dimensions, units and the scene."""
    wants, described = run.wants, run.view.coordinates
    coordinates = {
        "time": Variable(("time",), run.t, {"units": "s", "long_name": "time"}),
        "coordinate": Variable(
            ("coordinate",),
            np.array([coordinate.name for coordinate in described], str),
            {"long_name": "generalised coordinate"},
        ),
        "unit": Variable(
            ("coordinate",),
            np.array([coordinate.unit for coordinate in described], str),
            {"long_name": "unit of the coordinate"},
        ),
    }
    attributes = {
        # HDF5 strings cannot contain NUL.
        "title": run.scene.name.replace("\0", "\N{REPLACEMENT CHARACTER}"),
        "source": f"lissom {__version__}",
        "scene": run.scene.text,
        **imported(run.scene),
        "statistics": json.dumps(plain(statistics(run))),
    }

    def per_state(values: Array, name: str, unit: str) -> Variable:
        return Variable(("time", "coordinate"), values, {"long_name": name, "units": unit})

    variables = {"q": per_state(run.q, "generalised coordinates", "see unit")}
    if "velocity" in wants:
        variables["v"] = per_state(run.v, "generalised velocities", "see unit, per s")
    if "acceleration" in wants:
        variables["a"] = per_state(run.a, "generalised accelerations", "see unit, per s2")
    if "energy" in wants:
        for name, values in energies(run.balance).items():
            described_as = {"long_name": f"energy: {name}", "units": "J"}
            variables[f"energy_{name}"] = Variable(("time",), values, described_as)
    for shape in shapes(run):
        # NetCDF allows no slash in names.
        suffix = shape.suffix.replace("/", "\N{DIVISION SLASH}")
        X = f"X{suffix}"
        arc_length = {"units": "m", "long_name": "arc length of the unstretched rod"}
        coordinates["shape_time"] = Variable(
            ("shape_time",), run.t[shape.at], {"units": "s", "long_name": "time of a shape"}
        )
        coordinates[X] = Variable((X,), shape.link.stations, arc_length)
        coordinates["axis"] = Variable(("axis",), np.array(["x", "y", "z"]), {})
        variables[f"position{suffix}"] = Variable(
            ("shape_time", X, "axis"),
            shape.positions,
            {"units": "m", "long_name": "position of the centre line in the world"},
        )
    return Data(coordinates, variables, attributes)


def imported(scene: Scene) -> dict[str, str]:
    """The contents of the files that a scene imports, by name, as JSON.

    Bytes that are not UTF-8 are restored by ``encode(errors="surrogateescape")``.
    """
    contents = {name: content.decode(errors="surrogateescape") for name, content in scene.imports.items()}
    return {"imports": json.dumps(contents)} if contents else {}


def write_trajectory(run: Run, folder: Path) -> str:
    """Write ``trajectory.nc``, or ``trajectory.npz`` if the extra ``files`` fails; return the reason."""
    failure = ""
    try:
        content = None if missing(*HDF5) else written(trajectory(run))
    except Exception as error:
        content, failure = None, in_words(error)
    if content is not None:
        (folder / "trajectory.nc").write_bytes(content)
        return ""
    np.savez_compressed(folder / "trajectory.npz", **arrays(run))
    return failure


def arrays(run: Run) -> dict[str, Any]:
    """The arrays of ``trajectory.npz`` by name."""
    found: dict[str, Any] = {
        "t": run.t,
        "q": run.q,
        "coordinates": np.array([coordinate.name for coordinate in run.view.coordinates]),
        "units": np.array([coordinate.unit for coordinate in run.view.coordinates]),
        "scene": np.array(run.scene.text),
        **imported(run.scene),
        "statistics": np.array(json.dumps(plain(statistics(run)))),
    }
    if "velocity" in run.wants:
        found["v"] = run.v
    if "acceleration" in run.wants:
        found["a"] = run.a
    if "energy" in run.wants:
        found |= {f"energy_{name}": values for name, values in energies(run.balance).items()}
    for shape in shapes(run):
        found["shape_time"] = run.t[shape.at]
        found[f"X{shape.suffix}"], found[f"position{shape.suffix}"] = shape.link.stations, shape.positions
    return found


def write_summary(numbers: dict[str, Any], folder: Path) -> None:
    """Write ``summary.json``, which marks folders of lissom."""
    text = json.dumps(plain(numbers), indent=2, allow_nan=False) + "\n"
    (folder / SUMMARY).write_text(text, encoding="utf-8")


def plain(value: Any) -> Any:
    """The value as valid JSON: numbers that are not finite become null."""
    if isinstance(value, dict):
        return {key: plain(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [plain(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def in_words(error: Exception) -> str:
    """An error from other packages on one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())


def write_report(report: Callable[[Any, Path], None] | None, subject: Any, path: Path) -> list[str]:
    """Write a report, if requested. A failure affects no other file; return its reason, if any."""
    if report is None:
        return []
    try:
        report(subject, path)
    except Exception as error:
        path.unlink(missing_ok=True)
        return [f"The report could not be written: {in_words(error)}"]
    return []


def write(run: Run, folder: Path, report: Callable[[Run, Path], None] | None) -> list[str]:
    """Write the files of a run: computed data first, then what can be derived from them.

    Parameters
    ----------
    run : Run
        The simulated run.
    folder : Path
        An empty folder.
    report : callable or None
        Writes the report of the run to a file.

    Returns
    -------
    failures : list of str
        Missing or incomplete files, with the reasons.
    """
    failure = write_trajectory(run, folder)
    write_summary(statistics(run), folder)
    failures = [f"trajectory.nc could not be written, trajectory.npz was: {failure}"] if failure else []
    return failures + write_report(report, run, folder / "report.html")
