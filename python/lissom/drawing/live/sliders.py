"""Ranges of the sliders for the inputs of a model."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...common.arguments import number
from .motion import Motion
from .spring import deflections

#: Displacement of the tips over the range of a slider, relative to the model's size, by linear theory.
MOVED = 0.5

#: Number of steps of a slider.
STEPS = 200


@dataclass(frozen=True)
class Slider:
    """An input with its range and its initial value."""

    name: str
    low: float
    high: float
    start: float

    @property
    def step(self) -> float:
        """Step size of the slider."""
        return (self.high - self.low) / STEPS


def sliders(motion: Motion, ranges: Mapping[str, Sequence[float]] | None = None) -> list[Slider]:
    """A slider for each input, with the given range or one in which the tips move visibly.

    Raises ValueError or TypeError for an invalid range.
    """
    given = _checked({} if ranges is None else ranges, motion.model.inputs)
    reach = _reach(motion)
    pulls = {glyph.pulled_by for glyph in motion.view.glyphs.actuators}
    found = []
    for name, start, high in zip(motion.model.inputs, motion.u.tolist(), reach, strict=True):
        low, high = given.get(name, (0.0 if name in pulls else -high, high))
        # The range includes the current value.
        found.append(Slider(name, min(low, start), max(high, start), start))
    return found


def _checked(ranges: Mapping[str, Sequence[float]], names: Sequence[str]) -> dict[str, tuple[float, float]]:
    if not isinstance(ranges, Mapping):
        raise TypeError(f"ranges: a {type(ranges).__name__} is no mapping of names to (lowest, highest)")
    checked = {}
    for name, ends in ranges.items():
        if name not in names:
            known = ", ".join(names) or "none"
            raise ValueError(f"ranges: the model has no input {name!r}; its inputs: {known}")
        checked[name] = _ends(name, ends)
    return checked


def _ends(name: str, ends: Any) -> tuple[float, float]:
    try:
        low, high = (number(f"ranges[{name!r}]", end) for end in ends)
    except (TypeError, ValueError):
        raise ValueError(f"ranges[{name!r}]: {ends!r} is not a pair of numbers (lowest, highest)") from None
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ValueError(
            f"ranges[{name!r}]: ({low:g}, {high:g}) has to be finite and its second number above its first"
        )
    return low, high


def _reach(motion: Motion) -> list[float]:
    """Upper end of the range of each input."""
    if not motion.model.inputs:
        return []
    moved = deflections(motion.model, list(motion.tips), motion.q, motion.t, motion.u)
    return [
        _round(max(MOVED * (motion.view.size or 1.0) / each, 2.0 * abs(start)))
        if np.isfinite(each) and each > 0.0
        else _round(max(1.0, 2.0 * abs(start)))
        for each, start in zip(moved.tolist(), motion.u.tolist(), strict=True)
    ]


def _round(value: float) -> float:
    """Round up to 1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(power * digit for digit in (1.0, 2.0, 5.0, 10.0) if power * digit >= value * (1.0 - 1e-9))
