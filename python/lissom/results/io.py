"""Saving and loading results bit for bit: ``save`` and ``load``.

A file contains the *record* of a result and its model: data, from which `records` creates results and nothing
else. NetCDF and NPZ files also contain arrays for other
programs; `load` ignores them. Records are not compressed, so loading needs no more memory than the size of
the file.
"""

from __future__ import annotations

import io
import os
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._lissom import __version__
from ..common import disk
from ..common.arguments import path_of, suggesting
from ..common.elsewhere import READ, WRITTEN, of_suffix
from ..common.extras import missing
from . import records
from .datasets import dataset
from .files import NETCDF

if TYPE_CHECKING:
    from .._lissom import (
        ActuateResult,
        ContinuationResult,
        EnsembleResult,
        Model,
        ModesResult,
        MotionResult,
        ReachResult,
        StaticsResult,
    )
    from ..analysis.equilibria import EquilibriumSensitivityResult
    from ..analysis.fitted import FitResult
    from ..analysis.sensitivities import SensitivityResult

    Result = (
        MotionResult
        | StaticsResult
        | ContinuationResult
        | ModesResult
        | EnsembleResult
        | ReachResult
        | ActuateResult
        | SensitivityResult
        | EquilibriumSensitivityResult
        | FitResult
    )

#: A function that writes a result and its model.
Writer = Callable[[Any, Any], bytes]

#: First bytes of a ``.lissom`` file; the record follows.
HEAD = b"lissom record 2\n"

#: First bytes of files of versions up to 0.2.0, whose records were pickles.
OLD_HEAD = b"lissom record 1\n"

#: First line of a record: the version that wrote it.
VERSION = f"{__version__}\n".encode()

#: Separates the version from the checksum of the record in this line. Older records have no checksum.
CHECKSUM = b" crc32:"

#: Hint in messages about models that cannot be saved.
NO_FUNCTIONS = "give functions of time as tables or `Harmonic`"

#: The name of the record in NetCDF and NPZ files.
RECORD = "lissom_record"

#: Name of the record's file within the NPZ archive.
MEMBER = f"{RECORD}.npy"

#: The types that `save` accepts and `load` returns.
RESULTS = (
    *("MotionResult", "StaticsResult", "ContinuationResult", "ModesResult", "EnsembleResult"),
    *("SensitivityResult", "EquilibriumSensitivityResult", "FitResult", "ReachResult", "ActuateResult"),
)


@suggesting
def load(path: str | os.PathLike[str]) -> Result:
    """Load a result from a file written by its ``save`` method.

    Parameters
    ----------
    path : path-like
        A ``.lissom``, ``.npz`` or ``.nc`` file.

    Returns
    -------
    result : MotionResult, StaticsResult, EnsembleResult, SensitivityResult, FitResult and so on
        Bitwise equal to the saved result, with its model if it had one.

    Raises
    ------
    ValueError
        If the suffix is unknown, or if the file is damaged, was written by another program or an incompatible
        version of lissom, or contains anything that is not part of a result.
    OSError
        If the file cannot be read.
    ImportError
        If the file is NetCDF and the extra `files` is not installed.

    Examples
    --------
    >>> import lissom, tempfile, pathlib
    >>> result = lissom.simulate(lissom.SpringPendulum(), 0.1)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     result.save(pathlib.Path(folder) / "swing.lissom")
    ...     again = lissom.load(pathlib.Path(folder) / "swing.lissom")
    >>> bool((again.q == result.q).all())
    True
    """
    path = path_of(path)
    read = _by_suffix(path, READERS)
    return _result(read(path), path)


def save(
    result: Result,
    path: str | os.PathLike[str],
    model: Model | None = None,
    further: Mapping[str, Writer] | None = None,
) -> None:
    """Write a result to a file whose suffix selects the format; an existing file is replaced.

    `further` has the formats of rooms above this one by their suffixes. The content is assembled in memory
    first, so a failure leaves an existing file untouched.
    """
    path = path_of(path)
    write = _by_suffix(path, WRITERS | dict(further or {}))
    disk.write(path, write(result, model))


def _by_suffix(path: Path, known: dict[str, Any]) -> Any:
    if path.suffix not in known:
        kinds = ", ".join(known)
        instead = of_suffix(path.suffix, *((READ, "load") if known is READERS else (WRITTEN, "save")))
        raise ValueError(f"path: {path.name!r} has to end with one of {kinds}{instead}")
    return known[path.suffix]


def record(result: Result) -> bytes:
    """The record for `load`; raises if `load` could not read it."""
    try:
        content = records.write(result)
    except records.NotKept as error:
        raise ValueError(
            f"result: a file cannot keep {error}, which its model has; {NO_FUNCTIONS}"
        ) from error
    return VERSION.rstrip() + CHECKSUM + _checksum(content) + b"\n" + content


def _checksum(content: bytes) -> bytes:
    """The checksum of a record, which finds damage by accident; it does not say who wrote the file."""
    return b"%08x" % zlib.crc32(content)


def _result(content: bytes, path: Path) -> Result:
    line, _, kept_bytes = content.partition(b"\n")
    version, has_checksum, checksum = line.partition(CHECKSUM)
    if has_checksum and checksum != _checksum(kept_bytes):
        raise ValueError(
            f"path: {path.name!r} is damaged: the checksum of its result differs from the one that was saved"
        )
    try:
        result = records.read(kept_bytes)
    except Exception as error:  # bytes of any kind raise errors of any kind
        other = version.decode(errors="replace")[:20]
        reason = (
            f"{type(error).__name__}: {error}"
            if version + b"\n" == VERSION
            else f"it was written by version {other!r}, this is {__version__!r}"
        )
        raise ValueError(f"path: {path.name!r} has no result that lissom can read: {reason}") from error
    if type(result).__name__ not in RESULTS:
        raise ValueError(f"path: {path.name!r} has a {type(result).__name__}, which is no result")
    kept: Result = result
    return kept


def _write_record(result: Result, model: Model | None) -> bytes:
    return HEAD + record(result)


def _read_record(path: Path) -> bytes:
    content = disk.read(path)
    if content.startswith(OLD_HEAD):
        version = content[len(OLD_HEAD) :].partition(b"\n")[0].decode(errors="replace")[:20]
        raise ValueError(
            f"path: {path.name!r} has no result that lissom can read: it was written by "
            f"version {version!r}, whose records {__version__!r} does not read; load it with that version"
        )
    if not content.startswith(HEAD):
        raise ValueError(f"path: {path.name!r} was not written by `save` of this version of lissom")
    return content[len(HEAD) :]


def _write_npz(result: Result, model: Model | None) -> bytes:
    kept = io.BytesIO()
    np.save(kept, np.frombuffer(record(result), np.uint8))
    content = io.BytesIO()
    np.savez_compressed(content, **_arrays(result))
    with zipfile.ZipFile(content, "a", zipfile.ZIP_STORED) as archive:
        archive.writestr(MEMBER, kept.getvalue())
    return content.getvalue()


def _arrays(result: Any) -> dict[str, Any]:
    """Arrays of a result, and of its path, by name."""
    path = getattr(result, "path", None)
    parts = [result] if path is None else [result, path]
    found = {name: getattr(part, name, None) for part in parts for name in dir(part) if name[0] != "_"}
    data = getattr(result, "data", ())
    if isinstance(data, tuple) and len(data) > 1:
        # Of a fit: those of each recording with its number.
        found |= {f"{name}_{i}": value for i, each in enumerate(data) for name, value in vars(each).items()}
    return {name: value for name, value in found.items() if isinstance(value, np.ndarray)}


def _no_result(path: Path) -> ValueError:
    return ValueError(
        f"path: {path.name!r} has no result that `result.save` wrote; read the arrays of other files, as "
        "the trajectory.nc of `lissom run`, with xarray or NumPy"
    )


def _read_npz(path: Path) -> bytes:
    content = disk.read(path)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            # Reject files that expand: neither stored data nor declared arrays may be larger than the file.
            member = archive.getinfo(MEMBER)
            if member.compress_type != zipfile.ZIP_STORED or member.file_size > len(content):
                raise ValueError("its record is compressed")
            kept = io.BytesIO(archive.read(member))
        np.lib.format.read_magic(kept)
        shape, _, kind = np.lib.format.read_array_header_1_0(kept)
        start = kept.tell()
        if kind != np.uint8 or shape != (len(kept.getvalue()) - start,):
            raise ValueError("its record is no array of bytes")
        return kept.getvalue()[start:]
    except Exception as error:  # bytes of any kind raise errors of any kind
        raise _no_result(path) from error


def _need_files() -> None:
    absent = missing(*NETCDF)
    if absent:
        raise ImportError(f"NetCDF files need {' and '.join(absent)}: pip install 'lissom[files]'")


def _write_netcdf(result: Result, model: Model | None) -> bytes:
    _need_files()
    data = dataset(result, model)
    data[RECORD] = ("byte", np.frombuffer(record(result), np.uint8), {"long_name": "what lissom.load reads"})
    return bytes(data.to_netcdf(engine="h5netcdf"))


def _read_netcdf(path: Path) -> bytes:
    _need_files()
    import h5py

    content = disk.read(path)
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            # External links point to other files; compressed or declared data may exceed the memory.
            if not isinstance(file.get(RECORD, getlink=True), h5py.HardLink):
                raise ValueError("its record is elsewhere")
            kept = file[RECORD]
            if kept.dtype != np.uint8 or kept.ndim != 1 or kept.size > len(content):
                raise ValueError("its record is no array of bytes")
            if kept.external is not None or kept.is_virtual or kept.compression is not None:
                raise ValueError("its record is elsewhere, or compressed")
            return bytes(kept[:].tobytes())
    except Exception as error:  # bytes of any kind raise errors of any kind
        raise _no_result(path) from error


def _refuse_vtk(result: Result, model: Model | None) -> bytes:
    raise ValueError("path: .vtkhdf files are written of results of `simulate`")


READERS: dict[str, Callable[[Path], bytes]] = {
    ".lissom": _read_record,
    ".npz": _read_npz,
    ".nc": _read_netcdf,
}
WRITERS: dict[str, Writer] = {
    ".lissom": _write_record,
    ".npz": _write_npz,
    ".nc": _write_netcdf,
    ".vtkhdf": _refuse_vtk,
}
