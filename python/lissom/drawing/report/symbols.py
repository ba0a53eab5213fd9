"""Symbols of supports and of the surroundings, and the position of the floor."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...model.glyphs import Glyphs, SupportGlyph
from ...model.glyphs.joints import Pose
from . import arrows
from .actuators import actuators
from .joints import joints
from .layers import BREAK, Dots, DrawnStates, Solid, Strand, Thing, quaternions
from .loads import loads
from .loops import loops
from .magnets import magnets

Array = NDArray[np.float64]

#: Half the axis of a joint, half the width of a clamp's plate, and of the windings of a spring, relative to
#: the model's size.
AXIS, PLATE, WINDING = 0.055, 0.045, 0.02

#: Layers of what is around a model.
SURROUNDINGS = ("gravity", "current", "field")

#: Number of windings of a spring.
WINDINGS = 5

#: Gravity, current and magnetic field: length of the arrows, distance from the corner of the box, and scale
#: of the heads, relative to the diagonal.
CORNER_ARROW, CORNER_GAP, CORNER_HEAD = 0.13, 0.04, 0.4

#: Radii of anchor balls and of spring wires, relative to the model's size.
ANCHOR, SPRING = 0.012, 0.0035


def symbols(glyphs: Glyphs, shown: DrawnStates) -> list[Thing]:
    """All symbols of the robot itself."""
    return [
        *joints(glyphs.joints, shown),
        *loops(glyphs.loops, shown),
        *actuators(glyphs.actuators, glyphs.joints, shown),
        *loads(glyphs.loads, shown),
        *magnets(glyphs.magnets, shown),
        *_supports(glyphs.supports, shown),
        *_clamps(glyphs.clamps, shown),
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


def _supports(glyphs: Sequence[SupportGlyph], shown: DrawnStates) -> list[Thing]:
    """Springs from their anchors to the supported sections; only anchors for rigidly held directions."""
    if not glyphs:
        return []
    anchors = np.stack([glyph.anchor for glyph in glyphs])[None]
    names = [f"support of {glyph.name}" for glyph in glyphs]
    things: list[Thing] = [Dots(names, "supports", anchors, ANCHOR * shown.size)]
    for glyph, name in zip(glyphs, names, strict=True):
        if glyph.holds_places:
            points = _spring(glyph.anchor, glyph.pose(shown.q, shown.t)[..., :3, 3], shown.size)
            things.append(Strand(name, "supports", points, np.full(len(points), SPRING * shown.size)))
    return things


def _spring(anchor: Array, ends: Array, size: float) -> Array:
    """A zigzag (shapes, points, 3) from an anchor to points (shapes, 3)."""
    along = np.concatenate([[0.0, 0.15], np.linspace(0.15, 0.85, 2 * WINDINGS + 1)[1:-1], [0.85, 1.0]])
    across = np.zeros_like(along)
    across[2:-2] = (-1.0) ** np.arange(len(along) - 4)
    reach = ends - anchor
    # A spring that is hardly stretched has small windings.
    width = np.minimum(WINDING * size, 0.2 * np.linalg.norm(reach, axis=-1))
    points = anchor + along[:, None] * reach[:, None]
    points += (width[:, None] * across)[..., None] * arrows.across(reach)[:, None]
    return np.concatenate([points, np.broadcast_to(BREAK, (len(ends), 1, 3))], axis=1)


def _clamps(clamps: Sequence[Pose], shown: DrawnStates) -> list[Thing]:
    """Plates behind bases that are welded to the world."""
    half = max(PLATE * shown.size, 1.5 * shown.radius)
    behind = np.eye(4)
    behind[0, 3] = -half / 8
    plates: list[Thing] = []
    for clamp in clamps:
        poses = np.broadcast_to(clamp(shown.q, shown.t), (len(shown.q), 4, 4)) @ behind
        size = np.array([half / 8, half, half])
        turns = quaternions(poses[:, :3, :3])
        plates.append(Solid("clamp", "supports", "box", size, poses[:, :3, 3], turns))
    return plates


def floor(gravity: Sequence[float], low: Array, high: Array) -> tuple[int, float, bool]:
    """Axis and position of the ground below a box, and whether up is along that axis.

    Perpendicular to gravity if gravity is along an axis, otherwise perpendicular to z.
    """
    down = np.asarray(gravity, float)
    axis = int(np.argmax(np.abs(down))) if np.count_nonzero(down) == 1 else 2
    is_below = bool(down[axis] <= 0.0)
    return axis, float(low[axis] if is_below else high[axis]), is_below
