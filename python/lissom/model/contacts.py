"""Contact: the surfaces that can touch, and their pressure and friction.

The core describes contacts and their surfaces; their classes here are made from its tables.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from .._lissom import (
    Ball,
    Box,
    Capsule,
    Contact,
    ConvexMesh,
    DistanceGrid,
    HalfSpace,
    HeightField,
    Mesh,
    Sphere,
    Tube,
)
from ..common.arguments import with_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = [
    "Ball",
    "Box",
    "Capsule",
    "Contact",
    "ConvexMesh",
    "DistanceGrid",
    "HalfSpace",
    "HeightField",
    "Mesh",
    "Sphere",
    "Touch",
    "Tube",
]


@dataclass(frozen=True)
class Touch:
    """A place where two surfaces touch. A contact along a rod consists of several.

    Attributes
    ----------
    contact : str
        Name of the contact.
    position : ndarray, shape (3,)
        Position on the first surface, metres; if that is a shape, on the rod or ball that touches it.
    normal : ndarray, shape (3,)
        Unit vector from the second surface to the first.
    force : ndarray, shape (3,)
        Force on the first surface, newtons, friction included.
    overlap : float
        Overlap, metres.
    sliding : ndarray, shape (3,)
        Velocity of the first surface relative to the second, along the surface, m/s.
    along : tuple of float or None
        Arc lengths on the rods of the two surfaces, metres; None for a surface that is not a rod.
    """

    # Pickles refer to the class by this module, whatever moves.
    __module__ = "lissom"

    contact: str
    position: NDArray[np.float64]
    normal: NDArray[np.float64]
    force: NDArray[np.float64]
    overlap: float
    sliding: NDArray[np.float64]
    along: tuple[float | None, float | None]

    def __post_init__(self) -> None:
        with_number(self, "overlap")
