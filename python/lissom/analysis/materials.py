"""Derivatives of forces with respect to materials and sections of segments."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._lissom import ActiveStrain, Model, Robot, Segment, has_free_lengths, has_separate_sections
from ..model import paths
from ..model.views import is_rod
from . import differences

Array = NDArray[np.float64]

#: Parameters that affect only a segment's generalised stiffness, and the one that affects only its damping.
OF_STIFFNESS = ("young_modulus", "shear_modulus", "poisson_ratio")
OF_DAMPING = "retardation_time"

#: Prefixes of paths to segments, in a rod and in a robot.
OF_SEGMENTS = ("segment", "segments", "link", "links")

#: Arguments of a segment that affect only its stiffness and the inertia of its sections.
OF_SECTION = ("density", "radius", "section", "shear_correction")

#: Parameters on which the forces depend linearly, anywhere in a model.
LINEAR = ("density", "gravity", "tip_mass")


@dataclass(frozen=True)
class OfSection:
    """A parameter that affects the sections of a segment.

    Attributes
    ----------
    segment : int
        Index of the segment, counted over all rods.
    nearby : tuple of (Segment, float)
        The segment with nearby values, and their weights in the derivative.
    """

    segment: int
    nearby: tuple[tuple[Segment, float], ...]


@dataclass(frozen=True)
class OfMaterial:
    """Derivatives of a segment's generalised stiffness and damping with respect to a material parameter.

    Attributes
    ----------
    value : float
        The parameter's value.
    first : int
        The first of the segment's k coordinates.
    stiffness, damping : ndarray, shape (k, k)
        Derivatives.
    section : OfSection or None
        Set if the inertia of the sections also depends on the parameter.
    """

    value: float
    first: int
    stiffness: Array
    damping: Array
    section: OfSection | None = None


def nodes_of(path: Sequence[paths.Part]) -> differences.Nodes:
    """Values at which models are built for the derivative with respect to the number at a path."""
    return differences.OF_LINEAR if any(part in LINEAR for part in path[-2:]) else differences.CENTRAL


def _nearby(
    segment: Segment, within: Sequence[paths.Part], value: float, nodes: differences.Nodes
) -> tuple[tuple[tuple[Segment, float], ...], Array]:
    """A segment with nearby values, their weights, and the derivative of its generalised stiffness."""
    nearby = differences.terms(paths.replacing(segment, within), value, nodes)
    if within[0] == "density":
        return nearby, np.zeros_like(segment.generalised_stiffness())
    blocks = [weight * other.generalised_stiffness() for other, weight in nearby]
    changed, size = np.sum(blocks, axis=0), np.sum(np.abs(blocks), axis=0)
    changed[np.abs(changed) <= differences.ROUNDING * size] = 0.0
    return nearby, np.asarray(changed)


def _of_modulus(segment: Segment, key: paths.Part) -> Array:
    """The derivative of the generalised stiffness with respect to a modulus or Poisson's ratio."""
    young, shear = segment.young_modulus, segment.shear_modulus
    assert young is not None
    assert shear is not None
    # Cowper's factors depend on both.
    nodes = differences.CENTRAL if segment.shear_correction == "cowper" else differences.OF_LINEAR
    if key == "young_modulus":
        return _nearby(segment, [key], young, nodes)[1]
    _, changed = _nearby(segment, ["shear_modulus"], shear, nodes)
    # Poisson's ratio represents the shear modulus G = E / (2 (1 + nu)).
    return changed if key == "shear_modulus" else -2.0 * shear**2 / young * changed


class Materials:
    """Segments of a model whose material affects only their stiffness and damping."""

    def __init__(self, model: Model) -> None:
        self._model = model

    def derivative(self, path: Sequence[paths.Part]) -> OfMaterial | None:
        """The derivative with respect to the number at a path; None if it does not belong to a segment."""
        segment, number, first, within = self._segment(path)
        if segment is None:
            return None
        key = within[0]
        try:
            value = paths.found(segment, within) if len(within) > 1 else getattr(segment, str(key), None)
        except ValueError:
            return None
        # A radius that is the same at both ends.
        if isinstance(value, tuple) and len(value) == 2 and value[0] == value[1]:
            value = value[0]
        # A section given by its stiffness has no material. Invalid materials are reported elsewhere.
        if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
            return None
        stiffness = segment.generalised_stiffness()
        if key == OF_DAMPING and len(within) == 1:
            return OfMaterial(value, first, np.zeros_like(stiffness), stiffness)
        if key in OF_STIFFNESS and len(within) == 1:
            changed = _of_modulus(segment, key)
            return OfMaterial(value, first, changed, segment.retardation_time * changed)
        # Segments without coordinates affect only coordinates of other links.
        if key not in OF_SECTION or not len(stiffness) or not self._are_separate:
            return None
        nodes = nodes_of(path)
        nearby, changed = _nearby(segment, within, value, nodes)
        if len(nearby) > len(nodes):
            # At the limit of the valid range only one-sided differences exist, which are left to the caller.
            return None
        section = OfSection(number, nearby)
        return OfMaterial(value, first, changed, segment.retardation_time * changed, section)

    def shared(self, several: Sequence[Sequence[paths.Part]]) -> OfMaterial | None:
        """The derivative with respect to one value of several numbers, by all their coordinates.

        None unless all are of stiffness or damping.
        """
        each = [self.derivative(path) for path in several]
        found = [material for material in each if material is not None and material.section is None]
        if len(found) < len(each):
            return None
        first = min(material.first for material in found)
        count = max(material.first + len(material.stiffness) for material in found) - first
        stiffness, damping = np.zeros((2, count, count))
        for material in found:
            own = slice(material.first - first, material.first - first + len(material.stiffness))
            stiffness[own, own] += material.stiffness
            damping[own, own] += material.damping
        return OfMaterial(found[0].value, first, stiffness, damping)

    def free_length(self, path: Sequence[paths.Part]) -> int | None:
        """Index of the segment whose length is at the path, if nothing else depends on that length."""
        segment, number, _, within = self._segment(path)
        if segment is None or list(within) != ["length"] or not self._have_free_lengths:
            return None
        try:
            # Tables along the segment do not allow another length.
            paths.replacing(segment, within)(segment.length * (1.0 + differences.STEP))
        except ValueError:
            return None
        return number

    def _segment(self, path: Sequence[paths.Part]) -> tuple[Segment | None, int, int, Sequence[paths.Part]]:
        """The segment at a path, its number and first coordinate, and the rest of the path."""
        places = [i for i, part in enumerate(path) if isinstance(part, int)]
        depth = 1 if is_rod(self._model) else 2
        if len(places) >= depth and places[depth - 1] + 1 < len(path) and path[0] in OF_SEGMENTS:
            found = self._segments.get(tuple(path[i] for i in places[:depth]))
            if found is not None:
                return *found, path[places[depth - 1] + 1 :]
        return None, 0, 0, ()

    @functools.cached_property
    def _are_separate(self) -> bool:
        return has_separate_sections(self._model)

    @functools.cached_property
    def _have_free_lengths(self) -> bool:
        return has_free_lengths(self._model)

    @functools.cached_property
    def _segments(self) -> dict[tuple[paths.Part, ...], tuple[Segment, int, int]]:
        """Segments by their prefix in a path, with their numbers and first coordinates."""
        model = self._model
        # Contact takes its stiffness from materials, and activation acts through the stiffness.
        if not isinstance(model, Robot) or model.contacts:
            return {}
        if any(isinstance(actuator, ActiveStrain) for actuator in model.actuators):
            return {}
        found: dict[tuple[paths.Part, ...], tuple[Segment, int, int]] = {}
        for i, link in enumerate(model.links):
            segments = tuple(link.rod or ())
            sizes = [sum(segment.modes.values()) for segment in segments]
            # The coordinates of the joint come first.
            first = model.slice(link.name).stop - sum(sizes)
            for j, (segment, size) in enumerate(zip(segments, sizes, strict=True)):
                found[(j,) if is_rod(model) else (i, j)] = segment, len(found), first
                first += size
        return found
