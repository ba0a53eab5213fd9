"""Quantities for the colours of rods: curvature, stress and speed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...model import fibres, views

Array = NDArray[np.float64]

#: Names with units, in the order of the player's menu.
CURVATURE, STRESS, SPEED = "curvature (1/m)", "axial stress (Pa)", "speed (m/s)"

#: Maximum number of stations between which speeds are interpolated: each one costs a call for all shapes.
SPEED_STATIONS = 13


def along(
    link: views.Link, q: Array, v: Array, t: Array, u: Array, half: Array, at: Sequence[int]
) -> dict[str, Array]:
    """Values (shapes, stations) by name; non-finite ones are omitted.

    Stations have half extents ``half`` (stations, 2) and are in the segments ``at``.
    """
    # The last state of a failed run can overflow.
    with np.errstate(over="ignore", invalid="ignore"):
        found = _quantities(link, q, v, t, u, half, at)
    return {name: values for name, values in found.items() if np.isfinite(values).all()}


def _quantities(
    link: views.Link, q: Array, v: Array, t: Array, u: Array, half: Array, at: Sequence[int]
) -> dict[str, Array]:
    found: dict[str, Array] = {}
    if link.strain is not None:
        strain = link.strain(q, link.stations)
        found[CURVATURE] = np.linalg.norm(strain[..., 1:3], axis=-1)
        stress = fibres.axial_stress(link, q, link.stations, t, u, half, at)
        if stress is not None:
            found[STRESS] = stress
    if link.velocity is not None and np.any(v):
        few = np.linspace(0.0, link.length, SPEED_STATIONS)
        velocity = np.stack([link.velocity(q, v, float(X), t)[:, 3:] for X in few], axis=1)
        speed = np.linalg.norm(velocity, axis=-1)
        found[SPEED] = np.stack([np.interp(link.stations, few, each) for each in speed])
    return found
