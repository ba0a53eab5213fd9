"""Quantiles of the runs of an ensemble."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._lissom import EnsembleResult

Array = NDArray[np.float64]

#: Quantiles of the lower and upper edge of the band.
BAND = (0.05, 0.95)


def quantiles(result: EnsembleResult) -> Array:
    """Lower edge of the band, median and upper edge of the coordinates of the completed runs.

    Returns
    -------
    ndarray, shape (3, m, n)

    Raises
    ------
    ValueError
        If only the final states were saved, or no run was completed.
    """
    if result.keep != "states":
        raise ValueError(
            f"result: it has kept {result.keep!r}, expected 'states', all of which spread over time"
        )
    if not result.success.any():
        raise ValueError(f"result: no run came to its end; {result.message[0]}")
    return band(result.q[result.success])


def band(values: Array) -> Array:
    """Lower edge of the band, median, and upper edge of the first axis: three rows."""
    return np.asarray(np.quantile(values, (BAND[0], 0.5, BAND[1]), axis=0))
