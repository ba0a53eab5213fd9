"""Results in files that give them back with equal bits: ``save`` and ``load``.

A file has the *record* of a result: what `pickle` writes of it, with its model. `load` reads it with a list
of what may stand there (results, models and NumPy arrays), so that a file cannot name any other function.
NetCDF and NPZ files have arrays that other programs read beside it; `load` uses the record alone.
"""

from __future__ import annotations

import io
import os
import pickle
import zipfile
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from ._lissom import EnsembleResult, MotionResult, __version__
from .datasets import dataset
from .files import NETCDF, missing
from .vtk import timeline

if TYPE_CHECKING:
    from ._lissom import ContinuationResult, Model, ModesResult, StaticsResult

    Result = MotionResult | StaticsResult | ContinuationResult | ModesResult | EnsembleResult

#: With what a file ``.lissom`` begins; the record follows.
HEAD = b"lissom record 1\n"

#: With what a record begins: pickles are valid for one version.
VERSION = f"{__version__}\n".encode()

#: What to do where a model has what files cannot keep.
NO_FUNCTIONS = "give functions of time as tables or `Harmonic`"

#: The name of the record in NetCDF and NPZ files.
RECORD = "lissom_record"

#: What `save` returns; `load` gives nothing else.
RESULTS = ("MotionResult", "StaticsResult", "ContinuationResult", "ModesResult", "EnsembleResult")

#: Of what results and models consist, by module.
PARTS = {
    "_lissom": (
        *RESULTS,
        *("Balance", "BaseMotion", "Body", "CriticalPoint", "EquilibriumPath", "Fluid", "Harmonic", "Input"),
        *("Load", "Profile", "Robot", "Rod", "Section", "Segment", "SpringPendulum", "Statistics", "Support"),
    ),
    "links": (
        *("Cylindrical", "Free", "Link", "Mimic", "Planar", "Prismatic", "Revolute", "Spherical"),
        *("Universal", "Weld"),
    ),
    "actuators": ("ActiveStrain", "Along", "Chamber", "Motor", "Tendon", "Via"),
    "loops": ("Distance", "Gear", "Loop", "LoopEnd"),
}

#: Functions with which NumPy makes arrays again, by their names in its versions 1 and 2.
NUMPY = {
    "_frombuffer": ("numpy.core.numeric", "numpy._core.numeric"),
    "_reconstruct": ("numpy.core.multiarray", "numpy._core.multiarray"),
    "scalar": ("numpy.core.multiarray", "numpy._core.multiarray"),
}


def load(path: str | os.PathLike[str]) -> Result:
    """A result from a file that its method ``save`` has written.

    Parameters
    ----------
    path : path-like
        A file ``.lissom``, ``.npz`` or ``.nc``.

    Returns
    -------
    result : MotionResult, StaticsResult, ContinuationResult, ModesResult or EnsembleResult
        Equal to what was saved, to the last bit, with its model if it had one.

    Raises
    ------
    ValueError
        Where the suffix is unknown, or the file is damaged, of another program, of a version of lissom with
        other results, or names what is not a part of results.
    OSError
        Where the file cannot be read.
    ImportError
        Where the file is NetCDF and the extra `files` is not installed.

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
    path = Path(path)
    read = _by_suffix(path, READERS)
    return _result(read(path), path)


def save(result: Result, path: str | os.PathLike[str], model: Model | None = None) -> None:
    """Write a result to a file of the kind that its suffix says; one that is there is replaced.

    The content is made in memory first: what fails leaves an old file as it was.
    """
    path = Path(path)
    write = _by_suffix(path, WRITERS)
    path.write_bytes(write(result, model))


def _by_suffix(path: Path, known: dict[str, Any]) -> Any:
    if path.suffix not in known:
        kinds = ", ".join(known)
        raise ValueError(f"path: {path.name!r} has to end with one of {kinds}")
    return known[path.suffix]


def record(result: Result) -> bytes:
    """What `load` reads; refused where it could not."""
    try:
        content = pickle.dumps(result, protocol=5)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise ValueError(f"result: a file cannot keep it: {error}; {NO_FUNCTIONS}") from error
    try:
        _Reader(io.BytesIO(content)).load()
    except pickle.UnpicklingError as error:
        raise ValueError(
            f"result: a file cannot keep {error}, which its model has; {NO_FUNCTIONS}"
        ) from error
    return VERSION + content


class _Reader(pickle.Unpickler):
    """Reads nothing but parts of results."""

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) == ("builtins", "getattr"):
            return _restore_of
        if (module, name) in ALLOWED:
            return ALLOWED[module, name]
        if module in NUMPY.get(name, ()):
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"{module}.{name}")


def _restore_of(owner: Any, name: str) -> Any:
    """What pickles of results call `getattr` for, and nothing else."""
    if name != "_restore" or not any(owner is known for known in ALLOWED.values()):
        raise pickle.UnpicklingError(f"attribute {name}")
    return owner._restore


ALLOWED: dict[tuple[str, str], Any] = {
    ("types", "SimpleNamespace"): SimpleNamespace,
    ("numpy", "ndarray"): np.ndarray,
    ("numpy", "dtype"): np.dtype,
    ("builtins", "complex"): complex,
    **{
        (place, name): getattr(import_module(f"lissom.{module}"), name)
        for module, names in PARTS.items()
        for name in names
        for place in (f"lissom.{module}", "lissom")
    },
}


def _result(content: bytes, path: Path) -> Result:
    version, _, pickled = content.partition(b"\n")
    try:
        result = _Reader(io.BytesIO(pickled)).load()
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
    content = path.read_bytes()
    if not content.startswith(HEAD):
        raise ValueError(f"path: {path.name!r} was not written by `save` of this version of lissom")
    return content[len(HEAD) :]


def _write_npz(result: Result, model: Model | None) -> bytes:
    arrays: dict[str, Any] = _arrays(result)
    arrays[RECORD] = np.frombuffer(record(result), np.uint8)
    content = io.BytesIO()
    np.savez_compressed(content, **arrays)
    return content.getvalue()


def _arrays(result: Any) -> dict[str, Any]:
    """Arrays of a result, and of its path, by their names."""
    path = getattr(result, "path", None)
    parts = [result] if path is None else [result, path]
    found = {name: getattr(part, name) for part in parts for name in dir(part) if name[0] != "_"}
    return {name: value for name, value in found.items() if isinstance(value, np.ndarray)}


def _read_npz(path: Path) -> bytes:
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return bytes(arrays[RECORD].tobytes())
    except (KeyError, ValueError, EOFError, AttributeError, TypeError, zipfile.BadZipFile) as error:
        raise ValueError(f"path: {path.name!r} has no result of lissom") from error


def _need_files() -> None:
    absent = missing(*NETCDF)
    if absent:
        raise ImportError(f"NetCDF files need {' and '.join(absent)}: pip install 'lissom[files]'")


def _write_netcdf(result: Result, model: Model | None) -> bytes:
    _need_files()
    if isinstance(result, EnsembleResult):
        raise ValueError("path: results of `simulate_many` can be saved as .lissom or .npz, not as .nc")
    data = dataset(result, model)
    data[RECORD] = ("byte", np.frombuffer(record(result), np.uint8), {"long_name": "what lissom.load reads"})
    return bytes(data.to_netcdf(engine="h5netcdf"))


def _read_netcdf(path: Path) -> bytes:
    _need_files()
    import h5py

    content = io.BytesIO(path.read_bytes())
    try:
        with h5py.File(content, "r") as file:
            return bytes(file[RECORD][:].tobytes())
    except (KeyError, OSError, RuntimeError, ValueError, AttributeError) as error:
        raise ValueError(f"path: {path.name!r} has no result of lissom") from error


def _write_vtk(result: Result, model: Model | None) -> bytes:
    absent = missing("h5py")
    if absent:
        raise ImportError("files for ParaView need h5py: pip install 'lissom[files]'")
    if not isinstance(result, MotionResult):
        raise ValueError("path: .vtkhdf files are written of results of `simulate`")
    return timeline(result)


READERS: dict[str, Callable[[Path], bytes]] = {
    ".lissom": _read_record,
    ".npz": _read_npz,
    ".nc": _read_netcdf,
}
WRITERS: dict[str, Callable[[Any, Any], bytes]] = {
    ".lissom": _write_record,
    ".npz": _write_npz,
    ".nc": _write_netcdf,
    ".vtkhdf": _write_vtk,
}
