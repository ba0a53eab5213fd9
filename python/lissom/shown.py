"""What results that are written in Python share: read-only arrays, files, datasets, pictures, reports."""

from __future__ import annotations

import os
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray


class Shown:
    """Base of frozen dataclasses that are results with numbers for parameters."""

    def __post_init__(self) -> None:
        self._protect()

    def _protect(self) -> None:
        for field in fields(self):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __setstate__(self, state: dict[str, Any]) -> None:
        # Arrays from pickles and deep copies can be changed.
        self.__dict__.update(state)
        self._protect()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result to a file from which `lissom.load` gives it back with equal bits.

        Parameters
        ----------
        path : path-like
            ``.lissom`` (the smallest), ``.npz`` (NumPy reads its arrays) or ``.nc`` (NetCDF, extra `files`).
            A file that is there is replaced.

        Raises
        ------
        ValueError
            Where the suffix is unknown, or the model has functions of Python, which files cannot keep.
        OSError
            Where the file cannot be written.
        ImportError
            Where an extra is not installed; the message says how to install it.
        """
        from .keeping import save

        save(self, path)  # type: ignore[arg-type]

    def to_xarray(self) -> xarray.Dataset:
        """The result as an ``xarray.Dataset`` with named dimensions and units (extra `files`).

        Returns
        -------
        data : xarray.Dataset
            With the parameters by name.

        Raises
        ------
        ImportError
            Where xarray is not installed.
        """
        from .datasets import dataset

        return dataset(self)

    def plot(self) -> NDArray[Any]:
        """Draw derivatives of positions or coordinates, or what was measured beside what was fitted.

        Returns
        -------
        axes : ndarray of matplotlib.axes.Axes
            One below the other, in a new figure of `pyplot`.

        Raises
        ------
        ImportError
            Where Matplotlib is not installed (extra `plot`).
        """
        from .pictures import of_parameters

        return of_parameters(self)

    def report(self, path: str | os.PathLike[str], *, title: str | None = None) -> None:
        """Write the report: one HTML file that needs nothing but a browser.

        Parameters
        ----------
        path : path-like
            The file to write; one that is there is replaced.
        title : str, optional
            Heading of the page.

        Raises
        ------
        TypeError
            Where the title is no text.
        OSError
            Where the file cannot be written.
        """
        from .report import write_parameters

        if title is not None and not isinstance(title, str):
            raise TypeError(f"title: a {type(title).__name__} is not text")
        write_parameters(self, path, title)  # type: ignore[arg-type]
