"""Sections at the stations of a rod, and strain and stress of their outermost fibres."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .views import Link

Array = NDArray[np.float64]

#: The strains in their order.
STRAINS = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")


def segments(link: Link, X: Array) -> list[int]:
    """The segment at each arc length (stations,); at a boundary the preceding one, as for `Rod.strain`."""
    ends = np.cumsum([segment.length for segment in link.segments])
    return [min(int(np.searchsorted(ends, station)), len(ends) - 1) for station in X]


def fractions(link: Link, X: Array, at: Sequence[int]) -> Array:
    """The place of each arc length (stations,) in its segment ``at``, from 0 to 1."""
    lengths = np.array([segment.length for segment in link.segments])
    starts = np.cumsum(lengths) - lengths
    places: Array = np.clip((X - starts[list(at)]) / lengths[list(at)], 0.0, 1.0)
    return places


def half_extents(link: Link, X: Array, at: Sequence[int]) -> Array:
    """Half extents of the sections along y and z (stations, 2), metres."""
    places = fractions(link, X, at)
    return np.array([link.segments[i].section.half_extents(at) for i, at in zip(at, places, strict=True)])


def axial_strain(link: Link, change: Array, half: Array, at: Sequence[int]) -> Array:
    """The largest strain along the rod in each section, (shapes, stations).

    That of the outermost fibre due to stretch and bending, from the change of the strains (shapes, stations,
    6) relative to the reference strain. Exact for circles and ellipses, where the fibre of largest bending
    strain is on the boundary, and at the corners of rectangles.
    """
    # Bending about y causes axial strain along z.
    bending = np.abs(change[..., 1:3] * half[:, ::-1])
    is_square = np.array([link.segments[i].section.shape == "rectangle" for i in at])
    outermost = np.where(is_square, bending.sum(axis=-1), np.hypot(bending[..., 0], bending[..., 1]))
    strain: Array = np.abs(change[..., 3]) + outermost
    return strain


def axial_stress(
    link: Link,
    q: Array,
    X: Array,
    t: Array,
    u: Array,
    half: Array,
    at: Sequence[int],
    without_modes: Array | float = 0.0,
) -> Array | None:
    """The largest elastic stress along the rod in each section, pascals, (shapes, stations).

    Young's modulus times the elastic part of `axial_strain`: active strains are free of stress. For
    coordinates (shapes, n), times (shapes,) and inputs (shapes, inputs); `without_modes` is added to the
    strains. None if a segment has no modulus.
    """
    moduli = [segment.young_modulus for segment in link.segments]
    if link.elastic_wrench is None or None in moduli:
        return None
    wrench = link.elastic_wrench(q, X, t, u)
    elastic = _strains(link, wrench, X, at) + without_modes
    stress: Array = np.array(moduli, float)[list(at)] * axial_strain(link, elastic, half, at)
    return stress


def strains_without_modes(link: Link, wrench: Array, X: Array, at: Sequence[int]) -> Array:
    """Strains that the rod would have but for want of modes, (shapes, stations, 6).

    From moments and forces (shapes, stations, 6) in its sections by the balance of forces, divided by the
    stiffness.
    """
    return np.where(_have_modes(link, at), 0.0, _strains(link, wrench, X, at))


def missing_strains(
    link: Link, wrench: Array, q: Array, X: Array, t: Array, u: Array, at: Sequence[int]
) -> Array:
    """What strains with modes lack in shapes at rest, (shapes, stations, 6).

    From the difference of the moments and forces (shapes, stations, 6) by the balance of forces and those of
    the material, for rods along which no actuators act. Zero if those of the material are not known.
    """
    if link.elastic_wrench is None:
        return np.zeros(wrench.shape)
    missing = _strains(link, wrench - link.elastic_wrench(q, X, t, u), X, at)
    return np.where(_have_modes(link, at), missing, 0.0)


def _have_modes(link: Link, at: Sequence[int]) -> NDArray[np.bool_]:
    """Whether the strains have modes, (stations, 6)."""
    have = [[bool(segment.modes.get(strain)) for strain in STRAINS] for segment in link.segments]
    return np.array(have)[list(at)]


def _strains(link: Link, wrench: Array, X: Array, at: Sequence[int]) -> Array:
    """Elastic strains that belong to moments and forces on what is beyond sections."""
    return np.asarray(-np.linalg.solve(_stiffnesses(link, X, at), wrench[..., None])[..., 0], float)


def _stiffnesses(link: Link, X: Array, at: Sequence[int]) -> Array:
    """Stiffnesses (stations, 6, 6) of the sections."""
    places = fractions(link, X, at)
    parts = [(link.segments[i], place) for i, place in zip(at, places, strict=True)]
    return np.array([segment.stiffness(place * segment.length) for segment, place in parts])
