"""Results as xarray datasets, with named dimensions, units and long names in CF style."""

from __future__ import annotations

from functools import singledispatch
from typing import TYPE_CHECKING, Any

import numpy as np

from .._lissom import (
    ActuateResult,
    ContinuationResult,
    EnsembleResult,
    Model,
    ModesResult,
    MotionResult,
    ReachResult,
    Robot,
    StaticsResult,
    __version__,
    check_model,
)
from ..analysis.equilibria import EquilibriumSensitivityResult
from ..analysis.fitted import FitResult, FittedData
from ..analysis.sensitivities import SensitivityResult
from ..common.extras import missing
from ..model.views import Coordinate, view
from .runs import energies

if TYPE_CHECKING:
    import xarray

#: Units of arrays whose units differ from coordinate to coordinate.
SEE = "see unit"


def dataset(result: Any, model: Model | None = None) -> xarray.Dataset:
    """The result with dimensions and units."""
    if missing("xarray"):
        raise ImportError("datasets need xarray: pip install 'lissom[files]'")
    return _dataset(result, model)


@singledispatch
def _dataset(result: Any, model: Model | None) -> xarray.Dataset:
    raise TypeError(f"result: there is no dataset of a {type(result).__name__}")


def coordinates(model: Model | None, n: int) -> list[Coordinate]:
    """Descriptions of the coordinates; only their indices if the model is not known."""
    if model is None:
        return [Coordinate(f"q{i}", "", "coordinate") for i in range(n)]
    check_model(model, "model")
    if model.n != n:
        raise ValueError(f"model: it has {model.n} coordinates, the result has {n}")
    return list(view(model).coordinates)


def _begin(model: Model | None, n: int, title: str, **attributes: Any) -> xarray.Dataset:
    import xarray

    known = coordinates(model, n)
    return xarray.Dataset(
        coords={
            "coordinate": ("coordinate", [c.name for c in known], {"long_name": "generalised coordinate"}),
            "unit": ("coordinate", [c.unit for c in known], {"long_name": "unit of the coordinate"}),
        },
        attrs={"Conventions": "CF-1.11", "title": title, "source": f"lissom {__version__}", **attributes},
    )


def _outcome(result: Any) -> dict[str, Any]:
    # NetCDF has no booleans.
    return {"success": int(result.success), "status": result.status, "message": result.message}


@_dataset.register(MotionResult)
def _of_motion(result: MotionResult, model: Model | None) -> xarray.Dataset:
    model = result.model if model is None else model
    data = _begin(model, result.q.shape[1], "Motion", **_outcome(result))
    data = data.assign_coords(time=("time", result.t, {"units": "s", "long_name": "time", "axis": "T"}))
    per_state = ("time", "coordinate")
    data["q"] = (per_state, result.q, {"long_name": "generalised coordinates", "units": SEE})
    data["v"] = (per_state, result.v, {"long_name": "generalised velocities", "units": f"{SEE}, per s"})
    data["a"] = (per_state, result.a, {"long_name": "generalised accelerations", "units": f"{SEE}, per s2"})
    if result.u.shape[1]:
        data["u"] = (("time", "input"), result.u, {"long_name": "inputs from these times on"})
    if result.balance is not None:
        for name, values in energies(result.balance).items():
            data[f"energy_{name}"] = ("time", values, {"long_name": f"energy: {name}", "units": "J"})
    if model is not None and len(result.t):
        data = _with_shapes(data, result, model)
    return data


def _with_shapes(data: xarray.Dataset, result: MotionResult, model: Model) -> xarray.Dataset:
    """Centre lines of the rods and positions of the frames."""
    shown = view(model)
    if shown.links or shown.frames:
        data = data.assign_coords(axis=("axis", ["x", "y", "z"], {"long_name": "axis of the world"}))
    for link in shown.links:
        # NetCDF allows no slash in names.
        suffix = f"_{link.name}".replace("/", "\N{DIVISION SLASH}") if len(shown.links) > 1 else ""
        X = f"X{suffix}"
        arc_length = {"units": "m", "long_name": "arc length of the unstretched rod"}
        data = data.assign_coords({X: (X, link.stations, arc_length)})
        positions = link.pose(result.q, link.stations, result.t)[..., :3, 3]
        attributes = {"units": "m", "long_name": "position of the centre line in the world"}
        data[f"position{suffix}"] = (("time", X, "axis"), positions, attributes)
    if shown.frames:
        tips = np.stack([frame.pose(result.q, result.t)[..., :3, 3] for frame in shown.frames], axis=1)
        names = [frame.name for frame in shown.frames]
        data = data.assign_coords(frame=("frame", names, {"long_name": "frame"}))
        attributes = {"units": "m", "long_name": "position of the frame in the world"}
        data["tip"] = (("time", "frame", "axis"), tips, attributes)
    return data


@_dataset.register(StaticsResult)
def _of_statics(result: StaticsResult, model: Model | None) -> xarray.Dataset:
    data = _begin(model, len(result.q), "Equilibrium", **_outcome(result))
    data["q"] = ("coordinate", result.q, {"long_name": "generalised coordinates", "units": SEE})
    data["load_factor"] = ((), result.load_factor, {"long_name": "part of the loads that acts", "units": "1"})
    data["lowest_eigenvalue"] = ((), result.lowest_eigenvalue, {"long_name": "lowest eigenvalue"})
    if result.u is not None and len(result.u):
        data["u"] = ("input", result.u, {"long_name": "inputs"})
    return data


@_dataset.register(ContinuationResult)
def _of_path(result: ContinuationResult, model: Model | None) -> xarray.Dataset:
    path = result.path
    data = _begin(model, path.q.shape[1], "Path of equilibria", **_outcome(result))
    data["q"] = (("point", "coordinate"), path.q, {"long_name": "generalised coordinates", "units": SEE})
    attributes = {"long_name": "part of the loads that acts", "units": "1"}
    data = data.assign_coords(load_factor=("point", path.load_factor, attributes))
    data["lowest_eigenvalue"] = ("point", path.lowest_eigenvalue, {"long_name": "lowest eigenvalue"})
    data["stability"] = ("point", [verdict or "unknown" for verdict in path.stability])
    if path.u is not None:
        data["u"] = (("point", "input"), path.u, {"long_name": "inputs"})
    return data


@_dataset.register(ModesResult)
def _of_modes(result: ModesResult, model: Model | None) -> xarray.Dataset:
    data = _begin(model, result.shapes.shape[0], "Vibrations", message=result.message)
    data["frequency"] = ("mode", result.frequency, {"long_name": "frequency", "units": "Hz"})
    if result.refined_frequency is not None:
        attributes = {"long_name": "frequency with more modes of the rods", "units": "Hz"}
        data["refined_frequency"] = ("mode", result.refined_frequency, attributes)
    data["damping_ratio"] = ("mode", result.damping_ratio, {"long_name": "damping ratio", "units": "1"})
    # Only xarray reads complex numbers.
    for name, values, unit in (("eigenvalue", result.eigenvalues, "s-1"), ("shape", result.shapes, SEE)):
        dimensions = ("mode",) if values.ndim == 1 else ("coordinate", "mode")
        for part in ("real", "imag"):
            attributes = {"long_name": f"{name}, {part} part", "units": unit}
            data[f"{name}_{part}"] = (dimensions, np.array(getattr(values, part)), attributes)
    return data


@_dataset.register(EnsembleResult)
def _of_ensemble(result: EnsembleResult, model: Model | None) -> xarray.Dataset:
    data = _begin(model, result.q.shape[-1], "Ensemble", keep=result.keep, wall_time=result.wall_time)
    data = data.assign_coords(row=("row", np.arange(len(result)), {"long_name": "number of the run"}))
    in_time = ("time",) if result.keep == "states" else ()
    if in_time or result.mean is not None:
        data = data.assign_coords(time=("time", result.t, {"units": "s", "long_name": "time", "axis": "T"}))
    per_state = ("row", *in_time, "coordinate")
    data["q"] = (per_state, result.q, {"long_name": "generalised coordinates", "units": SEE})
    data["v"] = (per_state, result.v, {"long_name": "generalised velocities", "units": f"{SEE}, per s"})
    for name, extremes in (("lowest", result.lowest), ("highest", result.highest)):
        if extremes is not None:
            data[name] = (("row", "coordinate"), extremes, {"long_name": f"{name} coordinates", "units": SEE})
    if result.poses is not None or result.mean is not None:
        data = data.assign_coords(axis=("axis", ["x", "y", "z"], {"long_name": "axis of the world"}))
    if result.poses is not None:
        attributes = {"units": "m", "long_name": "position of the place in the world"}
        data["position"] = (("row", *in_time, "place", "axis"), result.poses[..., :3, 3], attributes)
    for name, values, unit in (("mean", result.mean, "m"), ("variance", result.variance, "m2")):
        if values is not None:
            attributes = {"units": unit, "long_name": f"{name} of the position over the runs"}
            data[f"position_{name}"] = (("time", "place", "axis"), values, attributes)
    data["reached"] = ("row", result.reached, {"units": "s", "long_name": "last time of the run"})
    # NetCDF has no booleans.
    data["success"] = ("row", result.success.astype(np.int8), {"long_name": "whether the end was reached"})
    data["status"] = ("row", np.asarray(result.status, dtype=str))
    data["message"] = ("row", np.asarray(result.message, dtype=str))
    for name, values in result.stats.items():
        data[f"stats_{name}"] = ("row", np.asarray(values), {"long_name": name.replace("_", " ")})
    return data


def _with_parameters(data: xarray.Dataset, result: Any) -> xarray.Dataset:
    names = {"long_name": "parameter, in whose unit derivatives are"}
    data = data.assign_coords(parameter=("parameter", list(result.names), names))
    if getattr(result, "gradient", None) is not None:
        data["value"] = ((), result.value, {"long_name": "objective"})
        data["gradient"] = ("parameter", result.gradient, {"long_name": "derivatives of the objective"})
    return data


def _with_position(data: xarray.Dataset, result: Any, dimensions: tuple[str, ...]) -> xarray.Dataset:
    """Position of the tip of the last link of a robot, and its derivatives with respect to the parameters."""
    if result.dq is None or not isinstance(result._model, Robot):
        return data
    position, derivative = result.position()
    data = data.assign_coords(axis=("axis", ["x", "y", "z"], {"long_name": "axis of the world"}))
    attributes = {"units": "m", "long_name": "position of the tip of the last link"}
    data["position"] = ((*dimensions, "axis"), position, attributes)
    attributes = {"long_name": "derivatives of the position", "units": "m, per unit of the parameter"}
    data["dposition"] = ((*dimensions, "axis", "parameter"), derivative, attributes)
    return data


@_dataset.register(SensitivityResult)
def _of_sensitivity(result: SensitivityResult, model: Model | None) -> xarray.Dataset:
    data = _begin(result._model, result.q.shape[1], "Derivatives of a run")
    data = data.assign_coords(time=("time", result.t, {"units": "s", "long_name": "time", "axis": "T"}))
    data = _with_parameters(data, result)
    per_state = ("time", "coordinate")
    data["q"] = (per_state, result.q, {"long_name": "generalised coordinates", "units": SEE})
    data["v"] = (per_state, result.v, {"long_name": "generalised velocities", "units": f"{SEE}, per s"})
    for name, values, what in (("dq", result.dq, "coordinates"), ("dv", result.dv, "velocities")):
        if values is not None:
            data[name] = ((*per_state, "parameter"), values, {"long_name": f"derivatives of the {what}"})
    return _with_position(data, result, ("time",))


@_dataset.register(EquilibriumSensitivityResult)
def _of_equilibrium_sensitivity(result: EquilibriumSensitivityResult, model: Model | None) -> xarray.Dataset:
    data = _begin(result._model, len(result.q), "Derivatives of an equilibrium")
    data = _with_parameters(data, result)
    data["q"] = ("coordinate", result.q, {"long_name": "generalised coordinates", "units": SEE})
    if result.dq is not None:
        of_shape = {"long_name": "derivatives of the coordinates"}
        data["dq"] = (("coordinate", "parameter"), result.dq, of_shape)
    if len(result.frequencies):
        data["frequency"] = ("mode", result.frequencies, {"long_name": "natural frequency", "units": "Hz"})
        attributes = {"long_name": "derivatives of the frequencies", "units": "Hz, per unit of the parameter"}
        data["dfrequency"] = (("mode", "parameter"), result.dfrequencies, attributes)
    return _with_position(data, result, ())


@_dataset.register(FitResult)
def _of_fit(result: FitResult, model: Model | None) -> xarray.Dataset:
    data = _begin(None, 0, "Identification", success=int(result.success), message=result.message)
    data = _with_parameters(data.drop_vars(("coordinate", "unit")), result)
    # A NetCDF variable cannot have the same dimension twice.
    data = data.assign_coords(other=("other", list(result.names), {"long_name": "another parameter"}))
    data["value"] = ("parameter", result.values, {"long_name": "value that fits best"})
    for i, end in enumerate(("low", "high")):
        share = f"{end} end of the {100 * result.confidence:g} percent confidence interval"
        data[end] = ("parameter", result.intervals[:, i], {"long_name": share})
    data["covariance"] = (
        ("parameter", "other"),
        result.covariance,
        {"long_name": "covariance of the values"},
    )
    for i, each in enumerate(result.data):
        data = _with_recording(data, each, "" if len(result.data) == 1 else f"_{i}")
    return data


def _with_recording(data: xarray.Dataset, each: FittedData, number: str) -> xarray.Dataset:
    """A recording of a fit; if there are several, names of variables and dimensions end with its number."""
    time, place, shape, mode = (f"{name}{number}" for name in ("time", "place", "shape", "mode"))
    if each.t is not None:
        of_time = {"units": "s", "long_name": "time", "axis": "T"}
        data = data.assign_coords({time: (time, each.t, of_time)})
    if each.places:
        data = data.assign_coords(axis=("axis", ["x", "y", "z"], {"long_name": "axis of the world"}))
        data = data.assign_coords({place: (place, list(each.places), {"long_name": "measured place"})})
    dimensions = (shape if each.t is None else time, place, "axis") if each.places else (mode,)
    measured = {"long_name": "what was measured", "units": each.unit}
    data[f"measured{number}"] = (dimensions, each.measured, measured)
    of_model = {"long_name": "what the model says minus what was measured", "units": each.unit}
    data[f"residual{number}"] = (dimensions, each.residuals, of_model)
    noise = {"long_name": "standard deviation of what was measured", "units": each.unit}
    data[f"noise{number}"] = ((), each.noise, noise)
    return data


def _with_targets(data: xarray.Dataset, result: ReachResult | ActuateResult) -> xarray.Dataset:
    """Poses of the links that have targets, and the remaining errors."""
    poses = np.reshape(result.pose, (-1, 4, 4))
    axes = ("target", "row", "column")
    data["pose"] = (axes, poses, {"long_name": "poses of the links, homogeneous matrices"})
    errors = (
        ("position_error", result.position_error, "m"),
        ("orientation_error", result.orientation_error, "rad"),
    )
    for name, values, unit in errors:
        attributes = {"units": unit, "long_name": name.replace("_", " ")}
        data[name] = ("target", np.reshape(np.asarray(values, float), -1), attributes)
    data.attrs["at_limits"] = ", ".join(result.at_limits)
    return data


@_dataset.register(ReachResult)
def _of_reach(result: ReachResult, model: Model | None) -> xarray.Dataset:
    data = _begin(model, len(result.q), "Inverse kinematics", **_outcome(result))
    data["q"] = ("coordinate", result.q, {"long_name": "generalised coordinates", "units": SEE})
    return _with_targets(data, result)


@_dataset.register(ActuateResult)
def _of_actuate(result: ActuateResult, model: Model | None) -> xarray.Dataset:
    data = _begin(model, len(result.q), "Inputs of an equilibrium", **_outcome(result))
    data["q"] = ("coordinate", result.q, {"long_name": "generalised coordinates", "units": SEE})
    data["u"] = ("input", result.u, {"long_name": "inputs"})
    return _with_targets(data, result)
