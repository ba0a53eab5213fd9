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


def written(data: Data) -> bytes:
    """The NetCDF file of a data set.

    It is created in memory, because HDF5 ends the process if it cannot write to its own file.
    """
    import h5netcdf

    content = io.BytesIO()
    with h5netcdf.File(content, "w") as file:
        file.attrs.update(data.attributes)
        for name, variable in {**data.coordinates, **data.variables}.items():
            _write(file, name, variable, _auxiliary(data, name))
    return content.getvalue()


def _write(file: Any, name: str, variable: Variable, auxiliary: str) -> None:
    import h5py

    values = np.asarray(variable.values)
    for dimension, size in zip(variable.dimensions, values.shape, strict=True):
        if dimension not in file.dimensions:
            file.dimensions[dimension] = size
    is_text = values.dtype.kind == "U"
    made = file.create_variable(
        name,
        variable.dimensions,
        h5py.string_dtype() if is_text else values.dtype,
        values.astype(object) if is_text else values,
        # NaN marks missing numbers.
        fillvalue=None if is_text else np.nan,
    )
    made.attrs.update(variable.attributes)
    if auxiliary:
        made.attrs["coordinates"] = auxiliary


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
