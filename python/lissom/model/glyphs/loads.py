"""Geometry of loads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..._lissom import Harmonic, Input, Load, Robot
from .joints import Pose
from .places import place_of, poses

Array = NDArray[np.float64]

#: Number of places at which a distributed force or moment is drawn.
PLACES_OF_FORCES, PLACES_OF_MOMENTS = 5, 3


@dataclass(frozen=True)
class LoadGlyph:
    """A force or a moment on a link."""

    #: The link on which it acts.
    name: str
    kind: Literal["force", "moment"]
    is_spread: bool
    #: Poses (..., places, 4, 4) of the places at which it acts.
    pose: Pose
    #: Newtons or newton metres, per metre if distributed, shape (k, 3), for (k,) times and (k, m) inputs.
    value: Callable[[Array, Array], Array]
    #: Whether the components are in the axes of the places, not in world axes.
    follows: bool
    #: 1 at the tip of a rod, -1 at its base, 0 elsewhere and on bodies.
    outwards: int = 0


def load_glyphs(robot: Robot, load: Load) -> list[LoadGlyph]:
    """The force and the moment of a load, if nonzero."""
    link, at = place_of(robot, load)
    is_spread = load.along is not None
    outwards = 0
    if at is not None and not is_spread:
        length = sum(segment.length for segment in link.rod or ())
        outwards = 1 if np.isclose(at, length) else -1 if at == 0.0 else 0

    def glyph(kind: Literal["force", "moment"], signal: Any, places: int) -> list[LoadGlyph]:
        if isinstance(signal, tuple) and len(signal) == 3 and not any(signal):
            return []
        X = None
        if load.along is not None:
            X = np.linspace(*load.along, places)
        elif at is not None:
            X = np.array([at])
        pose, value = partial(poses, robot, link.name, X), partial(_value, robot, signal)
        return [LoadGlyph(link.name, kind, is_spread, pose, value, load.frame == "body", outwards)]

    return [
        *glyph("force", load.force, PLACES_OF_FORCES),
        *glyph("moment", load.moment, PLACES_OF_MOMENTS),
    ]


def _value(robot: Robot, signal: Any, t: Array, u: Array) -> Array:
    """Values (k, 3) of the force or moment of a load of a robot at times (k,), with inputs (k, m)."""
    if isinstance(signal, Input):
        own = [i for i, name in enumerate(robot.inputs) if name.rpartition(".")[0] == signal.name]
        return u[:, own]
    return value_at(signal, t)


def value_at(signal: Any, t: float | Array) -> Array:
    """Values (..., 3) at times (...) of anything that `Load` accepts as force or moment."""
    times = np.asarray(t, float)
    found: Array
    if isinstance(signal, Input):
        # The default of the input.
        found = np.asarray(signal.default, float)
    elif isinstance(signal, Harmonic):
        phase = 2.0 * np.pi * signal.frequency * times[..., None] + signal.phase
        steady = np.asarray(signal.mean) + np.asarray(signal.rate) * times[..., None]
        found = steady + np.asarray(signal.amplitude) * np.sin(phase)
    elif callable(signal):
        found = np.reshape([signal(float(time)) for time in times.ravel()], (*times.shape, 3))
    elif len(signal) == 2 or isinstance(signal[2], str):
        stations, values = (np.asarray(part, float) for part in signal[:2])
        found = np.stack([np.interp(times, stations, column) for column in values.T], axis=-1)
    else:
        found = np.asarray(signal, float)
    return np.broadcast_to(found, (*times.shape, 3))
