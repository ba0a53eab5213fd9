"""NetCDF files as xarray writes them, without xarray, whose import takes longer than many a simulation."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np


class Variable(NamedTuple):
    """A variable of a data set."""

    #: Its dimensions, as many as `values` has.
    dimensions: tuple[str, ...]
    #: Floats or text.
    values: Any
    #: Units and description.
    attributes: Mapping[str, str]


@dataclass(frozen=True)
class Data:
    """A data set with named dimensions."""

    #: Coordinates by name; each describes one dimension.
    coordinates: Mapping[str, Variable]
    variables: Mapping[str, Variable]
    attributes: Mapping[str, str]


#: Name of the scale of a dimension without coordinates, before its size in ten digits (netCDF-C,
#: `DIM_WITHOUT_VARIABLE`).
NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable."


def written(data: Data) -> bytes:
    """The NetCDF file of a data set.

    It is created in memory, because HDF5 ends the process if it cannot write to its own file. NetCDF-4 is
    HDF5 with creation orders and a scale for each dimension; h5netcdf takes five times as long to write it.
    """
    import h5py

    content = io.BytesIO()
    variables = {**data.coordinates, **data.variables}
    sizes = _sizes(variables)
    with h5py.File(content, "w", track_order=True) as file:
        file.attrs.update(data.attributes)
        for name, variable in variables.items():
            _write(file, name, variable, _auxiliary(data, name))
        for number, (dimension, size) in enumerate(sizes.items()):
            _make_scale(file, dimension, size, number)
        for name, variable in variables.items():
            if variable.dimensions != (name,):
                for axis, dimension in enumerate(variable.dimensions):
                    file[name].dims[axis].attach_scale(file[dimension])
    return content.getvalue()


def _sizes(variables: Mapping[str, Variable]) -> dict[str, int]:
    """The sizes of all dimensions."""
    sizes: dict[str, int] = {}
    for name, variable in variables.items():
        for dimension, size in zip(variable.dimensions, np.shape(variable.values), strict=True):
            if sizes.setdefault(dimension, size) != size:
                raise ValueError(f"{name}: {dimension} has {size} entries here and {sizes[dimension]} before")
    return sizes


def _write(file: Any, name: str, variable: Variable, auxiliary: str) -> None:
    import h5py

    values = np.asarray(variable.values)
    is_text = values.dtype.kind == "U"
    made = file.create_dataset(
        name,
        data=values.astype(object) if is_text else values,
        dtype=h5py.string_dtype() if is_text else values.dtype,
        maxshape=_limits(values.shape),
        # NaN marks missing numbers.
        fillvalue=None if is_text else np.nan,
        track_order=True,
    )
    if not is_text:
        made.attrs["_FillValue"] = np.array([np.nan], values.dtype)
    made.attrs.update(variable.attributes)
    if auxiliary:
        made.attrs["coordinates"] = auxiliary


def _make_scale(file: Any, dimension: str, size: int, number: int) -> None:
    """Make the coordinate of a dimension its scale; without one, an array that is no variable."""
    name = dimension
    if dimension not in file:
        limits = _limits((size,))
        file.create_dataset(dimension, (size,), ">f4", maxshape=limits, track_order=True)
        name = f"{NO_VARIABLE}{size:10}"
    file[dimension].make_scale(name)
    file[dimension].attrs["_Netcdf4Dimid"] = np.int32(number)


def _limits(shape: tuple[int, ...]) -> tuple[int | None, ...] | None:
    """Limits of sizes: NetCDF knows no dimension of zero entries but an unlimited one."""
    return tuple(size or None for size in shape) if 0 in shape else None


def _auxiliary(data: Data, name: str) -> str:
    """Coordinates that are no dimensions and describe a variable (CF-1.11, section 5)."""
    if name not in data.variables:
        return ""
    own = data.variables[name].dimensions
    return " ".join(
        known
        for known, coordinate in data.coordinates.items()
        if known not in coordinate.dimensions and set(coordinate.dimensions) <= set(own)
    )
