"""Storage of sweep results: in memory, or in a Zarr store from which a later call resumes."""

from __future__ import annotations

import json
import warnings
import zlib
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

#: Attribute of an array that says how it was made, and of the store that says which arrays it has.
LAYOUT = "lissom_layout"
ARRAYS = "lissom_arrays"

#: Names of the arrays that mark finished points, and that hold the checksum of their results.
DONE = "is_done"
CHECKSUM = "checksum"

#: Arrays that hold no results.
OWN = (DONE, CHECKSUM)

#: Number of ranges of damaged points that a warning names.
NAMED = 5


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
        self.put_rows(indices, {name: self._rows(name, records) for name in self.arrays})
        self.done[indices] = True

    def _rows(self, name: str, records: Sequence[Record]) -> Array:
        """The entries of an array."""
        array = self.arrays[name]
        entry = (*array.shape[1:],)
        rows = np.full((len(records), *entry), _nothing(array.dtype), dtype=array.dtype)
        for i, record in enumerate(records):
            # Omit entries with another shape, such as coordinates of robots with other numbers of modes.
            if name in record and record[name].shape == entry:
                rows[i] = record[name]
        return rows

    def put_rows(self, indices: Array, rows: Mapping[str, Array]) -> None:
        """Write the entries of these points in all arrays."""
        for name, values in rows.items():
            self.put(self.arrays[name], indices, values)

    def put(self, array: Any, indices: Array, values: Array) -> None:
        """Write entries of an array."""
        array[indices] = values

    def read(self) -> Mapping[str, Array]:
        """All arrays."""
        return {name: np.asarray(array[...]) for name, array in self.arrays.items()}


def _nothing(dtype: Any) -> Any:
    """Value of missing entries."""
    return np.nan if np.dtype(dtype).kind == "f" else np.zeros((), dtype)[()]


def checksums(name: str, rows: Array) -> Array:
    """Checksums (points,) of the rows of an array; missing entries have zero, and arrays may be added later.

    Linear forms of the bytes, as words of 64 bits, with random odd coefficients modulo 2**64 (Dietzfelbinger
    and others 1997).
    """
    nothing = np.broadcast_to(np.asarray(_nothing(rows.dtype), rows.dtype), rows.shape)
    words = _words(rows) ^ _words(nothing)
    weights = np.random.default_rng(zlib.crc32(name.encode())).integers(
        0, 2**64, words.shape[1], np.uint64
    ) | np.uint64(1)
    sums: Array = (words * weights).sum(axis=1, dtype=np.uint64)
    return sums


def _start(indices: Array) -> Array:
    """Checksums of points without results: different ones, and never zero, as those of missing chunks are."""
    # Odd, so that products with different numbers differ modulo 2**64 (Knuth 1998, section 6.4).
    found: Array = (indices.astype(np.uint64) + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    return found


def _layout(array: Any) -> list[Any]:
    """Type of the elements, shape and fill value of an array, as JSON types."""
    return [np.dtype(array.dtype).str, list(array.shape), repr(array.fill_value)]


def _words(rows: Array) -> Array:
    """Bytes of each row as words of 64 bits."""
    content = np.ascontiguousarray(rows).reshape(len(rows), -1)
    content = content.view(np.uint8).reshape(len(rows), -1)
    padded = np.zeros((len(rows), -(-content.shape[1] // 8) * 8), np.uint8)
    padded[:, : content.shape[1]] = content
    return padded.view(np.uint64)


class Zarr(Memory):
    """A Zarr store. Data are written before the mark of a finished point, and in whole chunks.

    When a store is opened again, the checksum of every point is compared: it shows which ones are finished;
    the marks are for other programs. Damaged points (of a chunk or an array that is missing, cut, changed or
    that of other points) are named in a warning, and count as not finished.
    """

    def __init__(self, path: Path, points: int, identity: Mapping[str, Any]) -> None:
        import zarr

        super().__init__(points)
        # In the form in which the store returns it.
        wanted = json.loads(json.dumps(identity))
        if path.exists() and not path.is_dir():
            raise ValueError(f"store: {path} is a file and no store of a sweep; name another one")
        if path.exists() and any(path.iterdir()):
            self.group = self._opened(path, wanted)
            self.arrays = self._found(path)
            if any(name not in self.arrays for name in OWN):
                raise ValueError(f"store: {path} is damaged: arrays are missing or too short; remove it")
            self._make_missing(path)
            self._marks, self._checksums = (self.arrays.pop(name) for name in OWN)
            self._check(path)
        else:
            # Format 2 supports bytes of fixed length.
            self.group = zarr.open_group(str(path), mode="w-", zarr_format=2)
            self._marks = self._array(DONE, np.zeros((), dtype=bool))
            self._checksums = self._array(CHECKSUM, np.zeros((), dtype=np.uint64))
            self.group.attrs[IDENTITY] = wanted

    def _found(self, path: Path) -> dict[str, Any]:
        """The arrays of the store that are as they were made; others are made again when they are needed."""
        found = {}
        for name in sorted(entry.name for entry in path.iterdir() if entry.is_dir()):
            try:
                array = self.group[name]
                if array.attrs[LAYOUT] == _layout(array) and array.shape[0] == self.points:
                    found[name] = array
            except Exception:  # metadata of any kind raise errors of any kind
                continue
        return found

    def _make_missing(self, path: Path) -> None:
        """Make the arrays again that are lost: points that had nothing in them are as they were."""
        try:
            known = {
                name: (np.dtype(kind), shape) for name, (kind, shape) in self.group.attrs[ARRAYS].items()
            }
            for name, (kind, shape) in known.items():
                if name not in self.arrays:
                    self.arrays[name] = self._array(name, np.zeros(shape, kind))
        except KeyError:  # of an earlier version
            return
        except (AttributeError, TypeError, ValueError) as error:
            raise ValueError(f"store: {path} is damaged: its list of arrays is none; remove it") from error

    def _check(self, path: Path) -> None:
        """Find the finished points whose results are as they were written."""
        marked, written = _readable(self._marks).astype(bool), _readable(self._checksums)
        sums = _start(np.arange(self.points))
        for name, array in self.arrays.items():
            sums += checksums(name, _readable(array))
        self.done = sums == written
        if not np.array_equal(marked, self.done):
            self.put(self._marks, np.arange(self.points), self.done)
        damaged = np.flatnonzero((marked | (written != 0)) & ~self.done)
        if len(damaged) == 0:
            return
        runs = np.split(damaged, np.flatnonzero(np.diff(damaged) != 1) + 1)
        named = ", ".join(f"{run[0]}" if len(run) == 1 else f"{run[0]} to {run[-1]}" for run in runs[:NAMED])
        more = f" and {len(runs) - NAMED} more ranges" if len(runs) > NAMED else ""
        warnings.warn(
            f"store: {path}: the results of {len(damaged)} of {self.points} points are damaged "
            f"({named}{more}); they are run again",
            RuntimeWarning,
            stacklevel=6,
        )

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
            overwrite=True,
        )
        array.attrs[LAYOUT] = _layout(array)
        known = dict(self.group.attrs.get(ARRAYS, {}))
        self.group.attrs[ARRAYS] = known | {name: [np.dtype(value.dtype).str, list(value.shape)]}
        # Dimension names for xarray.
        array.attrs["_ARRAY_DIMENSIONS"] = ["point", *(f"{name}_{i}" for i in range(value.ndim))]
        return array

    def put_rows(self, indices: Array, rows: Mapping[str, Array]) -> None:
        """Write the entries of these points in all arrays, their checksums, and that they are finished."""
        super().put_rows(indices, rows)
        sums = _start(indices)
        for name, values in rows.items():
            sums += checksums(name, values)
        self.put(self._checksums, indices, sums)
        # Before the mark, so that Ctrl-C between the two loses nothing.
        self.done[indices] = True
        self.put(self._marks, indices, np.ones(len(indices), dtype=bool))

    def put(self, array: Any, indices: Array, values: Array) -> None:
        """Write entries of an array as runs of consecutive points."""
        breaks = np.flatnonzero(np.diff(indices) != 1) + 1
        for some, part in zip(np.split(indices, breaks), np.split(values, breaks), strict=True):
            array[int(some[0]) : int(some[-1]) + 1] = part


def _readable(array: Any) -> Array:
    """An array of a store, whose chunks that cannot be read are cleared."""
    rows = array.chunks[0]
    parts = []
    for first in range(0, array.shape[0], rows):
        try:
            parts.append(np.asarray(array[first : first + rows]))
        except Exception:  # bytes of any kind raise errors of any kind
            length = min(rows, array.shape[0] - first)
            parts.append(np.full((length, *array.shape[1:]), _nothing(array.dtype), dtype=array.dtype))
            try:
                array[first : first + rows] = parts[-1]
            except OSError as error:
                raise ValueError(f"store: a chunk of {array.name} cannot be replaced: {error}") from None
    return np.concatenate(parts)
