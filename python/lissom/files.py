"""Files of results: those of scene runs, and common functions for all results."""

from __future__ import annotations

import importlib.util
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ._lissom import __version__
from .folders import SUMMARY
from .results import Run, energies, shapes, statistics

if TYPE_CHECKING:
    import xarray

    from ._lissom import Scene

#: Modules that write NetCDF.
NETCDF = ("xarray", "h5netcdf", "h5py")


def dataset(run: Run) -> xarray.Dataset:
    """The trajectory with dimensions, units and the scene, as an xarray.Dataset."""
    import xarray

    wants, coordinates = run.wants, run.view.coordinates
    names = [coordinate.name for coordinate in coordinates]
    units = [coordinate.unit for coordinate in coordinates]
    data = xarray.Dataset(
        coords={
            "time": ("time", run.t, {"units": "s", "long_name": "time"}),
            "coordinate": ("coordinate", names, {"long_name": "generalised coordinate"}),
            "unit": ("coordinate", units, {"long_name": "unit of the coordinate"}),
        },
        attrs={
            # HDF5 strings cannot contain NUL.
            "title": run.scene.name.replace("\0", "\N{REPLACEMENT CHARACTER}"),
            "source": f"lissom {__version__}",
            "scene": run.scene.text,
            **imported(run.scene),
            "statistics": json.dumps(plain(statistics(run))),
        },
    )
    per_state = ("time", "coordinate")
    data["q"] = (per_state, run.q, {"long_name": "generalised coordinates", "units": "see unit"})
    if "velocity" in wants:
        data["v"] = (per_state, run.v, {"long_name": "generalised velocities", "units": "see unit, per s"})
    if "acceleration" in wants:
        data["a"] = (
            per_state,
            run.a,
            {"long_name": "generalised accelerations", "units": "see unit, per s2"},
        )
    if "energy" in wants:
        for name, values in energies(run.balance).items():
            data[f"energy_{name}"] = ("time", values, {"long_name": f"energy: {name}", "units": "J"})
    for shape in shapes(run):
        # NetCDF allows no slash in names.
        suffix = shape.suffix.replace("/", "\N{DIVISION SLASH}")
        X = f"X{suffix}"
        arc_length = {"units": "m", "long_name": "arc length of the unstretched rod"}
        data = data.assign_coords(
            {
                "shape_time": ("shape_time", run.t[shape.at], {"units": "s", "long_name": "time of a shape"}),
                X: (X, shape.link.stations, arc_length),
                "axis": ("axis", ["x", "y", "z"]),
            }
        )
        attributes = {"units": "m", "long_name": "position of the centre line in the world"}
        data[f"position{suffix}"] = (("shape_time", X, "axis"), shape.positions, attributes)
    return data


def imported(scene: Scene) -> dict[str, str]:
    """The contents of the files that a scene imports, by name, as JSON.

    Bytes that are not UTF-8 are restored by ``encode(errors="surrogateescape")``.
    """
    contents = {name: content.decode(errors="surrogateescape") for name, content in scene.imports.items()}
    return {"imports": json.dumps(contents)} if contents else {}


def write_trajectory(run: Run, folder: Path) -> str:
    """Write ``trajectory.nc``, or ``trajectory.npz`` if the extra ``files`` fails; return the reason.

    The file is created in memory, because HDF5 ends the process if it cannot write to its own file.
    """
    failure = ""
    try:
        content = None if missing(*NETCDF) else dataset(run).to_netcdf(engine="h5netcdf")
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


def missing(*modules: str) -> list[str]:
    """The modules that cannot be imported."""
    return [module for module in modules if importlib.util.find_spec(module) is None]
