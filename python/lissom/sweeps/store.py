"""Storage of sweep results: in memory, or in a Zarr store from which a later call resumes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .work import Array, Record

#: Approximate size of a chunk in bytes: small enough for fast writes, large enough to keep the number of
#: files low.
CHUNK = 2**20

#: Attribute that identifies the sweep of a store.
IDENTITY = "lissom_sweep"

#: Name of the array that marks finished points.
DONE = "is_done"


class Memory:
    """Results by point index; the last parameter varies fastest."""

    def __init__(self, points: int) -> None:
        self.points = points
        #: Whether each point was written; every point is written once.
        self.done = np.zeros(points, dtype=bool)
        self.arrays: dict[str, Any] = {}

    def begin(self, pattern: Record) -> None:
        """Allocate arrays for records like this one."""
        for name, value in pattern.items():
            if name not in self.arrays:
                self.arrays[name] = self.make(name, value)

    def make(self, name: str, value: Array) -> Any:
        """An array with an entry like this value for each point."""
        return np.full((self.points, *value.shape), _nothing(value.dtype), dtype=value.dtype)

    def write(self, which: Sequence[int], records: Sequence[Record]) -> None:
        """Store the results of these points."""
        indices = np.asarray(which)
        if self.done[indices].any():
            raise RuntimeError(f"points {indices[self.done[indices]].tolist()} were made twice")
        for name, array in self.arrays.items():
            entry = (*array.shape[1:],)
            values = np.full((len(which), *entry), _nothing(array.dtype), dtype=array.dtype)
            for i, record in enumerate(records):
                # Omit entries with another shape, such as coordinates of robots with other numbers of modes.
                if name in record and record[name].shape == entry:
                    values[i] = record[name]
            self.put(array, indices, values)
        self.done[indices] = True

    def put(self, array: Any, indices: Array, values: Array) -> None:
        """Write entries of an array."""
        array[indices] = values

    def read(self) -> Mapping[str, Array]:
        """All arrays."""
        return {name: np.asarray(array[...]) for name, array in self.arrays.items()}


def _nothing(dtype: Any) -> Any:
    """Value of missing entries."""
    return np.nan if np.dtype(dtype).kind == "f" else np.zeros((), dtype)[()]


class Zarr(Memory):
    """A Zarr store. Data are written before the mark of a finished point, and in whole chunks."""

    def __init__(self, path: Path, points: int, identity: Mapping[str, Any]) -> None:
        import zarr

        super().__init__(points)
        # In the form in which the store returns it.
        wanted = json.loads(json.dumps(identity))
        if path.exists() and any(path.iterdir()):
            self.group = self._opened(path, wanted)
            self.done = np.asarray(self.group[DONE][...], dtype=bool)
            self.arrays = {name: array for name, array in self.group.arrays() if name != DONE}
        else:
            # Format 2 supports bytes of fixed length.
            self.group = zarr.open_group(str(path), mode="w-", zarr_format=2)
            self._array(DONE, np.zeros((), dtype=bool))
            self.group.attrs[IDENTITY] = wanted
        self._marks = self.group[DONE]

    @staticmethod
    def _opened(path: Path, wanted: Mapping[str, Any]) -> Any:
        import zarr

        try:
            group = zarr.open_group(str(path), mode="r+")
            found = group.attrs[IDENTITY]
        except (KeyError, ValueError, FileNotFoundError, TypeError):
            raise ValueError(f"store: {path} is no store of a sweep; name another one") from None
        differs = [name for name in wanted if not isinstance(found, dict) or found.get(name) != wanted[name]]
        if differs:
            raise ValueError(
                f"store: {path} is of another sweep (other {', '.join(differs)}); "
                "name another store, or remove it"
            )
        return group

    def make(self, name: str, value: Array) -> Any:
        """An array in the store."""
        return self._array(name, value)

    def _array(self, name: str, value: Array) -> Any:
        rows = max(1, min(self.points, CHUNK // max(value.nbytes, 1)))
        array = self.group.create_array(
            name,
            shape=(self.points, *value.shape),
            chunks=(rows, *(max(1, size) for size in value.shape)),
            dtype=value.dtype,
            fill_value=_nothing(value.dtype),
        )
        # Dimension names for xarray.
        array.attrs["_ARRAY_DIMENSIONS"] = ["point", *(f"{name}_{i}" for i in range(value.ndim))]
        return array

    def write(self, which: Sequence[int], records: Sequence[Record]) -> None:
        """Store the results of these points."""
        super().write(which, records)
        self.put(self._marks, np.asarray(which), np.ones(len(which), dtype=bool))

    def put(self, array: Any, indices: Array, values: Array) -> None:
        """Write entries of an array as runs of consecutive points."""
        breaks = np.flatnonzero(np.diff(indices) != 1) + 1
        for some, part in zip(np.split(indices, breaks), np.split(values, breaks), strict=True):
            array[int(some[0]) : int(some[-1]) + 1] = part
