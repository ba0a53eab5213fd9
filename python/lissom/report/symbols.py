"""Symbols of what is drawn beside links and loads: joints, supports, gravity, current, floor."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..marks import JointMark, Marks, Pose, SupportMark
from . import arrows, theme
from .actuators import actuators
from .layers import BREAK, Shown, Trace
from .loads import loads
from .solids import placed

Array = NDArray[np.float64]

#: Half an axis of a joint, half the width of the plate that a base is clamped to and of the windings of a
#: spring, relative to the model's size.
AXIS, PLATE, WINDING = 0.055, 0.045, 0.02

#: Windings of a spring.
WINDINGS = 5

#: Gravity and current: length and distance from the corner of the box, and what the heads of their arrows are
#: scaled to, relative to its diagonal.
CORNER_ARROW, CORNER_GAP, CORNER_HEAD = 0.13, 0.04, 0.4

#: The floor is so far within the box, relative to half its height: at its very side it would be cut.
FLOOR_GAP = 0.02


def symbols(marks: Marks, shown: Shown) -> list[Trace]:
    """Everything that is drawn of the robot itself."""
    return [
        *_joints(marks.joints, shown),
        *actuators(marks.actuators, marks.joints, shown),
        *loads(marks.loads, shown),
        *_supports(marks.supports, shown),
        *_clamps(marks.clamps, shown),
    ]


def around(marks: Marks, low: Array, high: Array, eye: Array) -> list[Trace]:
    """Gravity, the current and the floor in and below a box that is seen from ``eye``."""
    diagonal = float(np.linalg.norm(high - low))
    traces: list[Trace] = []
    # In the upper corners that are behind the box, on the left and on the right.
    depth = int(np.argmax(np.abs(eye[:2])))
    is_right = np.cross([0.0, 0.0, 1.0], eye) > 0.0
    left, right = np.where(is_right, low, high), np.where(is_right, high, low)
    for corner in (left, right):
        corner[depth] = low[depth] if eye[depth] > 0.0 else high[depth]
        corner[2] = high[2]
    for layer, vector, corner, number in (
        ("gravity", marks.gravity, left, 1),
        ("current", marks.current, right, 3),
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
        text = f"{layer}: {norm:.3g} {'m/s²' if layer == 'gravity' else 'm/s'}"
        traces += arrows.arrows(
            layer, tails, np.broadcast_to(arrow, tails.shape), CORNER_HEAD * diagonal, text
        )
    floor = _floor(marks.gravity, low, high)
    if floor is not None:
        traces.append(floor)
    return traces


def _joints(marks: Sequence[JointMark], shown: Shown) -> list[Trace]:
    """Thick lines about which something turns, rails along which it slides, frames of planes, balls."""
    lines: dict[float, list[Array]] = {7.0: [], 3.0: []}
    texts: dict[float, list[str]] = {7.0: [], 3.0: []}
    balls, names = [], []
    for mark in marks:
        poses = mark.pose(shown.q, shown.t)
        text = f"joint of {mark.name}"
        if mark.kind == "ball":
            balls.append(poses[:, None, :3, 3])
            names.append(text)
            continue
        local, width = _joint_lines(mark, shown)
        lines[width].append(placed(poses, local))
        texts[width] += [text] * len(local)
    traces = [
        Trace(
            "joints",
            "scatter3d",
            np.concatenate(found, axis=1),
            {
                "mode": "lines",
                "line": {"color": theme.PURPLE, "width": width},
                "text": texts[width],
                "hoverinfo": "text",
            },
        )
        for width, found in lines.items()
        if found
    ]
    if balls:
        marker = {"size": 6, "color": theme.PURPLE}
        looks = {"mode": "markers", "marker": marker, "text": names, "hoverinfo": "text"}
        traces.append(Trace("joints", "scatter3d", np.concatenate(balls, axis=1), looks))
    return traces


def _joint_lines(mark: JointMark, shown: Shown) -> tuple[Array, float]:
    """Lines in the frame of a joint, and how wide they are; they cover all of the way."""
    half = shown.half_axis
    if mark.kind == "turning":
        return np.array([[-half, 0.0, 0.0], [half, 0.0, 0.0], *BREAK]), 7.0
    travel = mark.travel(shown.q, shown.t)
    low, high = travel.min(axis=0) - half, travel.max(axis=0) + half
    if mark.kind == "sliding":
        a, b, gap = low[0], high[0], 0.3 * half
        rails = [[a, -gap, 0.0], [b, -gap, 0.0], *BREAK, [a, gap, 0.0], [b, gap, 0.0], *BREAK]
        return np.array(rails), 3.0
    (_, a, c), (_, b, d) = low, high
    corners = [[0.0, a, c], [0.0, b, c], [0.0, b, d], [0.0, a, d], [0.0, a, c], *BREAK]
    return np.array(corners), 3.0


def _supports(marks: Sequence[SupportMark], shown: Shown) -> list[Trace]:
    """Springs from their anchors to what they hold; anchors alone where directions are held."""
    if not marks:
        return []
    anchors = np.stack([mark.anchor for mark in marks])[None]
    names = [f"support of {mark.name}" for mark in marks]
    marker = {"symbol": "diamond", "size": 6, "color": theme.GREEN}
    traces = [
        Trace(
            "supports",
            "scatter3d",
            anchors,
            {"mode": "markers", "marker": marker, "text": names, "hoverinfo": "text"},
        )
    ]
    springs = [
        _spring(mark.anchor, mark.pose(shown.q, shown.t)[..., :3, 3], shown.size)
        for mark in marks
        if mark.holds_places
    ]
    if springs:
        looks = {"mode": "lines", "line": {"color": theme.GREEN, "width": 3}, "hoverinfo": "skip"}
        traces.append(Trace("supports", "scatter3d", np.concatenate(springs, axis=1), looks))
    return traces


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


def _clamps(clamps: Sequence[Pose], shown: Shown) -> list[Trace]:
    """Plates behind the bases that are welded to the world."""
    half = max(PLATE * shown.size, 1.5 * shown.radius)
    box = np.array([[x, y, z] for x in (-half / 4, 0.0) for y in (-half, half) for z in (-half, half)])
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
    faces += [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    looks = {
        **dict(zip("ijk", np.array(faces, np.int32).T, strict=True)),
        "color": theme.GREEN,
        "flatshading": True,
        "opacity": 0.75,
        "name": "clamp",
        "hoverinfo": "name",
    }
    return [
        Trace("supports", "mesh3d", placed(np.asarray(clamp(shown.q, shown.t)), box), looks)
        for clamp in clamps
    ]


def _floor(gravity: Sequence[float], low: Array, high: Array) -> Trace | None:
    """The side of a box to which things fall, where that is one side."""
    down = np.asarray(gravity, float)
    axis = int(np.argmax(np.abs(down)))
    if np.count_nonzero(down) != 1:
        return None
    corners = np.array([low, low, high, high])
    side, centre = (high if down[axis] > 0.0 else low)[axis], 0.5 * (low + high)[axis]
    corners[:, axis] = side + FLOOR_GAP * (centre - side)
    first, second = (i for i in range(3) if i != axis)
    corners[[1, 3], first] = [high[first], low[first]]
    corners[[1, 3], second] = [low[second], high[second]]
    looks = {"i": [0, 0], "j": [1, 2], "k": [2, 3], "color": theme.GREY, "opacity": 0.15, "hoverinfo": "skip"}
    return Trace("floor", "mesh3d", corners[None], looks)
