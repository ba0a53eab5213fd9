"""How the forces of robots change with the materials of their segments."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import differences
from ._lissom import Model, Robot, Segment
from .actuators import ActiveStrain
from .sweeps import paths
from .views import is_rod

Array = NDArray[np.float64]

#: Numbers of a segment that only its generalised stiffness depends on, and that of its damping beside it.
OF_STIFFNESS = ("young_modulus", "shear_modulus", "poisson_ratio")
OF_DAMPING = "retardation_time"


@dataclass(frozen=True)
class OfMaterial:
    """How a segment's generalised stiffness and damping change with a number of its material.

    Attributes
    ----------
    value : float
        The number.
    first : int
        The first of the segment's k coordinates.
    stiffness, damping : ndarray, shape (k, k)
        Derivatives.
    """

    value: float
    first: int
    stiffness: Array
    damping: Array


class Materials:
    """Segments of a model on whose material nothing but their stiffness and damping depends."""

    def __init__(self, model: Model) -> None:
        self._model = model

    def derivative(self, path: Sequence[paths.Part]) -> OfMaterial | None:
        """The derivative with respect to the number that a path leads to; None if it is not of a segment."""
        key = path[-1]
        place = tuple(part for part in path if isinstance(part, int))
        if key not in (*OF_STIFFNESS, OF_DAMPING) or place not in self._segments:
            return None
        segment, first = self._segments[place]
        value = getattr(segment, key)
        # A section that is given has no material.
        if value is None:
            return None
        if key == OF_DAMPING:
            stiffness = segment.generalised_stiffness()
            return OfMaterial(value, first, np.zeros_like(stiffness), stiffness)

        def with_value(value: float) -> Array:
            changed: Segment = paths.replaced(segment, [key], value)
            return changed.generalised_stiffness()

        # Cowper's factors depend on Poisson's ratio.
        is_linear = key != "poisson_ratio" and segment.shear_correction != "cowper"
        nodes = differences.OF_LINEAR if is_linear else differences.CENTRAL
        terms = differences.terms(with_value, value, nodes)
        found = np.sum([weight * stiffness for stiffness, weight in terms], axis=0)
        size = np.sum([abs(weight) * np.abs(stiffness) for stiffness, weight in terms], axis=0)
        found[np.abs(found) <= differences.ROUNDING * size] = 0.0
        return OfMaterial(value, first, found, segment.retardation_time * found)

    @functools.cached_property
    def _segments(self) -> dict[tuple[int, ...], tuple[Segment, int]]:
        """By their places in a path, with the first of their coordinates."""
        model = self._model
        # Contact takes its stiffness from materials, and activation acts through the stiffness.
        if not isinstance(model, Robot) or model.contacts:
            return {}
        if any(isinstance(actuator, ActiveStrain) for actuator in model.actuators):
            return {}
        found: dict[tuple[int, ...], tuple[Segment, int]] = {}
        for i, link in enumerate(model.links):
            segments = tuple(link.rod or ())
            sizes = [sum(segment.modes.values()) for segment in segments]
            # Those of the joint come first.
            first = model.slice(link.name).stop - sum(sizes)
            for j, (segment, size) in enumerate(zip(segments, sizes, strict=True)):
                found[(j,) if is_rod(model) else (i, j)] = segment, first
                first += size
        return found
