"""Symbols of effects and of the surroundings, colours of all layers, and the position of the floor."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...model.glyphs import Glyphs
from . import actuators, arrows, contacts, joints, loads, loops, magnets, supports, theme
from .layers import DrawnStates, Thing

Array = NDArray[np.float64]

#: Colours of the layers, in the order of the legend.
LEGEND: dict[str, str] = {
    "rods": theme.ROD_SCALE[1][1],
    "bodies": theme.STEEL,
    "visuals": theme.STEEL,
    **joints.LAYERS,
    **loops.LAYERS,
    **contacts.LAYERS,
    **actuators.LAYERS,
    **loads.LAYERS,
    "contact": theme.BLUE,
    **supports.LAYERS,
    **magnets.LAYERS,
    "current": theme.CYAN,
    "gravity": theme.GREY,
    "field": theme.PURPLE,
    "floor": theme.GREY,
    "tips": theme.ORANGE,
    "paths": theme.ORANGE,
    "initial shape": theme.GREY,
}

#: Half the axis of a joint, relative to the model's size.
AXIS = 0.055

#: Layers of what is around a model.
SURROUNDINGS = ("gravity", "current", "field")

#: Gravity, current and magnetic field: length of the arrows, distance from the corner of the box, and scale
#: of the heads, relative to the diagonal.
CORNER_ARROW, CORNER_GAP, CORNER_HEAD = 0.13, 0.04, 0.4


def symbols(glyphs: Glyphs, shown: DrawnStates) -> list[Thing]:
    """All symbols of the robot itself."""
    return [
        *joints.joints(glyphs.joints, shown),
        *loops.loops(glyphs.loops, shown),
        *actuators.actuators(glyphs.actuators, glyphs.joints, shown),
        *loads.loads(glyphs.loads, shown),
        *magnets.magnets(glyphs.magnets, shown),
        *supports.supports(glyphs.supports, shown),
        *supports.clamps(glyphs.clamps, shown),
    ]


def around(glyphs: Glyphs, low: Array, high: Array, eye: Array) -> list[Thing]:
    """Gravity and current in the upper corners of a box seen from ``eye``, and a field between them."""
    diagonal = float(np.linalg.norm(high - low))
    things: list[Thing] = []
    # In the upper corners on the far side of the box, left and right.
    depth = int(np.argmax(np.abs(eye[:2])))
    is_right = np.cross([0.0, 0.0, 1.0], eye) > 0.0
    left, right = np.where(is_right, low, high), np.where(is_right, high, low)
    for corner in (left, right):
        corner[depth] = low[depth] if eye[depth] > 0.0 else high[depth]
        corner[2] = high[2]
    for layer, vector, unit, corner, number in (
        ("gravity", glyphs.gravity, "m/s²", left, 1),
        ("current", glyphs.current, "m/s", right, 3),
        ("field", glyphs.field, "T", 0.5 * (left + right), 2),
    ):
        norm = math.hypot(*vector)
        if norm == 0.0:
            continue
        arrow = np.asarray(vector, float) / norm * CORNER_ARROW * diagonal
        across = arrows.across(arrow) * CORNER_GAP * diagonal
        beside = (np.arange(number) - 0.5 * (number - 1))[:, None] * across
        extent = CORNER_GAP * diagonal + 0.5 * np.abs(arrow) + np.abs(beside[-1])
        inwards = np.sign(0.5 * (low + high) - corner) * extent
        tails = (corner + inwards + beside - 0.5 * arrow)[None]
        text = f"{layer}: {norm:.3g} {unit}"
        pointing = np.broadcast_to(arrow, tails.shape)
        things.append(arrows.arrows(layer, tails, pointing, CORNER_HEAD * diagonal, [text] * number))
    return things


def floor(gravity: Sequence[float], low: Array, high: Array) -> tuple[int, float, bool]:
    """Axis and position of the ground below a box, and whether up is along that axis.

    Perpendicular to gravity if gravity is along an axis, otherwise perpendicular to z.
    """
    down = np.asarray(gravity, float)
    axis = int(np.argmax(np.abs(down))) if np.count_nonzero(down) == 1 else 2
    is_below = bool(down[axis] <= 0.0)
    return axis, float(low[axis] if is_below else high[axis]), is_below
