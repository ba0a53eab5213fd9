"""Visuals: triangle meshes that stand for links in pictures. They have no mass and touch nothing."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.arguments import number, sequence, suggesting, text

Array = NDArray[np.float64]

#: Largest number of triangles of all visuals of a drawing: a report takes about 10 bytes for each.
MOST_TRIANGLES = 200_000

_COLOUR = re.compile(r"#[0-9a-fA-F]{6}")


@suggesting
@dataclass(frozen=True, eq=False)
class Visual:
    """A triangle mesh that stands for a link in reports, figures, films, the live view and files of meshes.

    Visuals are pictures: they have no mass and touch nothing. Pass them as `visuals` to what draws.
    `read_visuals` reads them from files, `lissom.urdf.read_urdf(..., visuals=True)` those of a URDF file.

    Parameters
    ----------
    link : str
        The link that carries it; of a link with a rod, its first section.
    points : array_like, shape (v, 3)
        Corners in the frame of the link, metres.
    faces : array_like of int, shape (m, 3)
        Corners of each triangle, anticlockwise seen from outside.
    name : str
        Name in legends; by default that of the link.
    colour : str, optional
        A hexadecimal colour such as ``"#8090a0"``; by default that of bodies.
    opacity : float
        From above 0 to 1.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.

    Examples
    --------
    >>> import lissom
    >>> corners = [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)]
    >>> lissom.Visual("palm", corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], colour="#8090a0")
    Visual('palm', 4 triangles)
    """

    link: str
    points: ArrayLike
    faces: ArrayLike
    _: KW_ONLY
    name: str = ""
    colour: str | None = None
    opacity: float = 1.0

    def __post_init__(self) -> None:
        points, faces = _points(self.points), _faces(self.faces)
        if faces.size and not 0 <= faces.min() <= faces.max() < len(points):
            worst = int(faces.max() if faces.max() >= len(points) else faces.min())
            raise ValueError(
                f"faces: got the corner {worst}, expected 0 to {len(points) - 1}: numbers of points"
            )
        opacity = number("opacity", self.opacity)
        if not 0.0 < opacity <= 1.0:
            raise ValueError(f"opacity: got {opacity:g}, expected a number above 0 and up to 1")
        colour = self.colour
        if colour is not None and not _COLOUR.fullmatch(text("colour", colour)):
            raise ValueError(f"colour: got {colour!r}, expected a hexadecimal colour such as '#8090a0'")
        link = text("link", self.link)
        values = {"link": link, "points": points, "faces": faces, "opacity": opacity}
        for name, value in {**values, "name": text("name", self.name) or link}.items():
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        return f"Visual({self.link!r}, {len(np.asarray(self.faces))} triangles)"


# Pickles refer to the class by this module, whatever moves. Not in the class: `KW_ONLY` is looked up here.
Visual.__module__ = "lissom"


def _points(values: ArrayLike) -> Array:
    points = np.array(_array("points", values, "real numbers", "iuf"), float)
    if not np.isfinite(points).all():
        raise ValueError("points: expected finite numbers")
    points.setflags(write=False)
    return points


def _faces(values: ArrayLike) -> NDArray[np.int64]:
    faces = np.array(_array("faces", values, "whole numbers", "iu"), np.int64)
    faces.setflags(write=False)
    return faces


def _array(name: str, values: ArrayLike, of: str, kinds: str) -> NDArray[Any]:
    try:
        array = np.asarray(values)
    except ValueError:  # lists of different lengths
        array = np.empty((), object)
    if array.ndim != 2 or array.shape[1] != 3 or not len(array):
        raise ValueError(f"{name}: expected an array of {of} of shape (n, 3), got {array.shape}")
    if array.dtype.kind not in kinds:
        raise TypeError(f"{name}: expected an array of {of}, got {array.dtype}")
    return array


def checked(visuals: Any, links: Iterable[str]) -> list[Visual]:
    """The visuals of a drawing, each on a link of the model.

    Raises
    ------
    ValueError, TypeError
        If one is none, names no link, or all are too large for a drawing.
    """
    found: list[Visual] = sequence("visuals", visuals, "Visual")
    names = list(links)
    for i, visual in enumerate(found):
        if not isinstance(visual, Visual):
            raise TypeError(f"visuals[{i}]: expected a Visual, got {type(visual).__name__}")
        if visual.link not in names:
            from .._lissom import meant

            close = meant(visual.link, names)
            right = f"did you mean {close!r}?" if close else f"expected one of {', '.join(names) or 'none'}"
            raise ValueError(
                f"visuals[{i}].link: got {visual.link!r}, which is no link of the model; {right}"
            )
    triangles = sum(len(np.asarray(visual.faces)) for visual in found)
    if triangles > MOST_TRIANGLES:
        raise ValueError(
            f"visuals: {triangles} triangles are more than {MOST_TRIANGLES}; simplify them, as "
            "`read_visuals(..., max_triangles=5000)` does for each"
        )
    return found


def simplified(points: Array, faces: NDArray[np.int64], most: int) -> tuple[Array, NDArray[np.int64]]:
    """A mesh of at most so many triangles: corners in the same cell of a grid become their mean.

    The grid is the finest with which the triangles are few enough (vertex clustering, Rossignac and Borrel
    1993).
    """
    if len(faces) <= most:
        return points, faces
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max()) or 1.0

    def with_cells(cells: int) -> tuple[Array, NDArray[np.int64]]:
        cell = np.minimum((points - low) * (cells / size), cells - 1).astype(np.int64)
        _, group = np.unique(cell, axis=0, return_inverse=True)
        group = group.reshape(-1)
        count = np.bincount(group)
        means = np.stack([np.bincount(group, column) / count for column in points.T], axis=-1)
        a, b, c = named = group[faces].T
        named = named.T[(a != b) & (b != c) & (c != a)]
        # The two sides of thin walls may fall on each other.
        _, first = np.unique(np.sort(named, axis=1), axis=0, return_index=True)
        used, renamed = np.unique(named[np.sort(first)], return_inverse=True)
        return means[used], renamed.reshape(-1, 3)

    few, many = 1, 2
    while len(with_cells(many)[1]) <= most:
        few, many = many, 2 * many
    while many - few > 1:
        middle = (few + many) // 2
        few, many = (middle, many) if len(with_cells(middle)[1]) <= most else (few, middle)
    return with_cells(few)
