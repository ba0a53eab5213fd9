"""Common bases of results of parameters: read-only arrays, and the methods that `attached` defines."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import os

    import xarray
    from numpy.typing import NDArray


class ReadOnly:
    """Base of frozen dataclasses whose arrays are read-only, also in copies and from pickles."""

    def __post_init__(self) -> None:
        self._protect()

    def _protect(self) -> None:
        for field in fields(self):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __setstate__(self, state: dict[str, Any]) -> None:
        # Arrays from pickles and deep copies are writable.
        self.__dict__.update(state)
        self._protect()


class ParameterResult(ReadOnly):
    """Base of results with one number per parameter."""

    if TYPE_CHECKING:

        def save(self, path: str | os.PathLike[str]) -> None: ...
        def to_xarray(self) -> xarray.Dataset: ...
        def plot(self) -> NDArray[Any]: ...
        def report(self, path: str | os.PathLike[str], *, title: str | None = None) -> None: ...
