"""Symbols of what is drawn beside links: joints, arrows of loads, supports, gravity, current, floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..marks import JointMark, LoadMark, Marks, Pose, SupportMark
from . import theme
from .layers import LEGEND, Trace
from .solids import placed

Array = NDArray[np.float64]

#: Sizes relative to that of the model: half an axis of a joint, the largest arrow of a force, the radius of
#: the ring of a moment.
AXIS, ARROW, RING = 0.055, 0.28, 0.09

#: The head of an arrow: its length and its radius, and at most this part of the arrow.
HEAD, HEAD_RADIUS, MOST_HEAD = 0.08, 0.026, 0.6

#: An arrow at its largest is at least this part of the largest one of its kind, so that it can be seen.
LEAST_ARROW = 1 / 3

#: Corners of the head of an arrow.
CORNERS = 6

#: A ring of a moment goes so far around, in so many points.
AROUND, POINTS_AROUND = 1.5 * np.pi, 13

#: Half the width of the plate that a base is clamped to, and of the windings of a spring.
PLATE, WINDING = 0.045, 0.02

#: Windings of a spring.
WINDINGS = 5

#: Gravity and current: length and distance from the corner of the box, relative to its diagonal.
CORNER_ARROW, CORNER_GAP = 0.13, 0.04

#: The floor is so far within the box, relative to half its height: at its very side it would be cut.
FLOOR_GAP = 0.02

#: Break of a line.
BREAK = np.full((1, 3), np.nan)


@dataclass(frozen=True)
class Shown:
    """The shapes in which something is shown."""

    #: Coordinates (shapes, n), times and load factors (shapes,).
    q: Array
    t: Array
    load_factor: Array
    #: Length in metres to which symbols are scaled.
    size: float
    #: Radius of the thickest rod as it is drawn, and half the length of the axis of a joint, metres.
    radius: float
    half_axis: float


def symbols(marks: Marks, shown: Shown) -> list[Trace]:
    """Everything that is drawn of the robot itself."""
    return [
        *_joints(marks.joints, shown),
        *_forces([mark for mark in marks.loads if mark.kind == "force"], shown),
        *_moments([mark for mark in marks.loads if mark.kind == "moment"], shown),
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
        norm = float(np.linalg.norm(vector))
        if norm == 0.0:
            continue
        arrow = np.asarray(vector, float) / norm * CORNER_ARROW * diagonal
        across = _across(arrow) * CORNER_GAP * diagonal
        beside = (np.arange(number) - 0.5 * (number - 1))[:, None] * across
        extent = CORNER_GAP * diagonal + 0.5 * np.abs(arrow) + np.abs(beside[-1])
        inwards = np.sign(0.5 * (low + high) - corner) * extent
        tails = (corner + inwards + beside - 0.5 * arrow)[None]
        text = f"{layer}: {norm:.3g} {'m/s²' if layer == 'gravity' else 'm/s'}"
        traces += _arrows(layer, tails, np.broadcast_to(arrow, tails.shape), diagonal / 2.5, text)
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
        local, width = _joint_lines(mark, shown.q[:, mark.travel], shown.half_axis)
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


def _joint_lines(mark: JointMark, travel: Array, half: float) -> tuple[Array, float]:
    """Lines in the frame of a joint, and how wide they are; ``travel`` (shapes, displacements) is covered."""
    if mark.kind == "turning":
        return np.array([[-half, 0.0, 0.0], [half, 0.0, 0.0], *BREAK]), 7.0
    low, high = travel.min(axis=0) - half, travel.max(axis=0) + half
    if mark.kind == "sliding":
        (a,), (b,), gap = low, high, 0.3 * half
        rails = [[a, -gap, 0.0], [b, -gap, 0.0], *BREAK, [a, gap, 0.0], [b, gap, 0.0], *BREAK]
        return np.array(rails), 3.0
    (a, c), (b, d) = low, high
    corners = [[0.0, a, c], [0.0, b, c], [0.0, b, d], [0.0, a, d], [0.0, a, c], *BREAK]
    return np.array(corners), 3.0


def _vectors(mark: LoadMark, shown: Shown) -> tuple[Array, Array, Array]:
    """Poses (shapes, places, 4, 4) of places of a load, and its vectors in its own axes and the world's."""
    poses = mark.pose(shown.q, shown.t)
    # Half of it, so that vectors of the largest doubles can be turned; what is beyond them is not drawn.
    value = 0.5 * shown.load_factor[:, None] * np.nan_to_num(mark.value(shown.t), posinf=0.0, neginf=0.0)
    own = np.broadcast_to(value[:, None], (*poses.shape[:2], 3))
    world = np.einsum("kpij,kpj->kpi", poses[..., :3, :3], own) if mark.follows else own
    return poses, own, world


def _drawn_lengths(vectors: Sequence[Array], largest: float) -> list[Array]:
    """The same vectors (shapes, places, 3) as long as they are drawn.

    Each keeps its course in time. The largest one is as long as ``largest``; others are to scale with it, but
    at their largest at least `LEAST_ARROW` of that.
    """
    # Squares of large numbers are beyond doubles.
    sizes = [float(np.abs(vector).max()) for vector in vectors]
    vectors = [vector / (size or 1.0) for vector, size in zip(vectors, sizes, strict=True)]
    norms = [float(np.linalg.norm(vector, axis=-1).max()) for vector in vectors]
    shares = [size / (max(sizes) or 1.0) * norm for size, norm in zip(sizes, norms, strict=True)]
    return [
        vector * (largest * max(LEAST_ARROW, share / max(shares)) / norm) if norm > 0.0 else vector
        for vector, norm, share in zip(vectors, norms, shares, strict=True)
    ]


def _forces(marks: Sequence[LoadMark], shown: Shown) -> list[Trace]:
    """Arrows from where a force pulls, or to where it pushes; combs of arrows where it is spread."""
    found = [_vectors(mark, shown) for mark in marks]
    traces: list[Trace] = []
    tails, arrows, combs, names = [], [], [], []
    # Newtons and newtons per metre are no lengths that compare.
    for is_spread in (False, True):
        chosen = [i for i, mark in enumerate(marks) if mark.is_spread == is_spread]
        if not chosen:
            continue
        size = ARROW * shown.size * (0.6 if is_spread else 1.0)
        drawn = _drawn_lengths([found[i][2] for i in chosen], size)
        for i, arrow in zip(chosen, drawn, strict=True):
            poses = found[i][0]
            place = poses[..., :3, 3]
            length = np.linalg.norm(arrow, axis=-1)
            inwards = -marks[i].outwards * np.einsum("kpi,kpi->kp", arrow, poses[..., :3, 0])
            # What would lie within the rod is drawn before it.
            pushes = np.ones_like(length) if is_spread else (inwards > 0.5 * length).astype(float)
            tails.append(place - pushes[..., None] * arrow)
            arrows.append(arrow)
            names += [f"force on {marks[i].name}"] * arrow.shape[1]
            if is_spread:
                breaks = np.broadcast_to(BREAK, (len(arrow), 1, 3))
                combs.append(np.concatenate([tails[-1], breaks], axis=1))
    if arrows:
        traces += _arrows(
            "forces", np.concatenate(tails, axis=1), np.concatenate(arrows, axis=1), shown.size, names
        )
    if combs:
        looks = {"mode": "lines", "line": {"color": theme.RED, "width": 2}, "hoverinfo": "skip"}
        traces.append(Trace("forces", "scatter3d", np.concatenate(combs, axis=1), looks))
    return traces


def _moments(marks: Sequence[LoadMark], shown: Shown) -> list[Trace]:
    """Rings about the axes of moments, with a head that says which way round."""
    found = [_vectors(mark, shown) for mark in marks]
    rings, ends, heads, names = [], [], [], []
    for is_spread in (False, True):
        chosen = [i for i, mark in enumerate(marks) if mark.is_spread == is_spread]
        if not chosen:
            continue
        drawn = _drawn_lengths([found[i][2] for i in chosen], shown.radius + RING * shown.size)
        for i, vector in zip(chosen, drawn, strict=True):
            poses, own, _ = found[i]
            radius = np.linalg.norm(vector, axis=-1)[..., None]
            first, second = _axes_across(vector, poses, own, marks[i].follows)
            angle = np.linspace(0.0, AROUND, POINTS_AROUND)[:, None]
            centre = poses[..., None, :3, 3]
            ring = centre + radius[..., None] * (
                np.cos(angle) * first[..., None, :] + np.sin(angle) * second[..., None, :]
            )
            shapes, places = ring.shape[:2]
            breaks = np.broadcast_to(BREAK, (shapes, places, 1, 3))
            rings.append(np.concatenate([ring, breaks], axis=2).reshape(shapes, -1, 3))
            forward = np.cos(AROUND) * second - np.sin(AROUND) * first
            ends.append(ring[..., -1, :])
            heads.append(0.6 * radius * forward)
            names += [f"moment on {marks[i].name}"] * (places * (POINTS_AROUND + 1))
    if not rings:
        return []
    looks = {**LEGEND["moments"], "text": names, "hoverinfo": "text"}
    end, head = np.concatenate(ends, axis=1), np.concatenate(heads, axis=1)
    return [
        Trace("moments", "scatter3d", np.concatenate(rings, axis=1), looks),
        _cones("moments", theme.MAGENTA, end, head, HEAD_RADIUS / HEAD),
    ]


def _axes_across(vector: Array, poses: Array, own: Array, follows: bool) -> tuple[Array, Array]:
    """Two unit vectors across each vector (shapes, places, 3) that move without jumps: as its axes do."""
    peak = own.reshape(-1, 3)[int(np.argmax(np.abs(own.reshape(-1, 3)).max(axis=1)))]
    least = int(np.argmin(np.abs(peak)))
    start = poses[..., :3, least] if follows else np.broadcast_to(np.eye(3)[least], vector.shape)
    axis = _unit(vector)
    first = _unit(start - np.einsum("kpi,kpi->kp", start, axis)[..., None] * axis)
    return first, np.cross(axis, first)


def _supports(marks: Sequence[SupportMark], shown: Shown) -> list[Trace]:
    """Springs from their anchors to what they hold; anchors alone where directions are held."""
    if not marks:
        return []
    anchors = np.stack([mark.anchor[:3, 3] for mark in marks])[None]
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
        _spring(mark.anchor[:3, 3], mark.pose(shown.q, shown.t)[..., :3, 3], shown.size)
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
    points += (width[:, None] * across)[..., None] * _across(reach)[:, None]
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


def _arrows(layer: str, tails: Array, arrows: Array, size: float, text: str | list[str]) -> list[Trace]:
    """Arrows (shapes, arrows, 3) of a layer: shafts and heads."""
    length = np.linalg.norm(arrows, axis=-1, keepdims=True)
    head = np.minimum(HEAD * size, MOST_HEAD * length)
    along = _unit(arrows)
    necks = tails + arrows - head * along
    breaks = np.full_like(tails, np.nan)
    shafts = np.stack([tails, necks, breaks], axis=2).reshape(len(tails), -1, 3)
    texts = text if isinstance(text, str) else [each for each in text for _ in range(3)]
    colour = LEGEND[layer]["line"]["color"]
    looks: dict[str, Any] = {**LEGEND[layer], "text": texts, "hoverinfo": "text"}
    return [
        Trace(layer, "scatter3d", shafts, looks),
        _cones(layer, colour, necks, head * along, HEAD_RADIUS / HEAD),
    ]


def _cones(layer: str, colour: str, base: Array, heads: Array, slenderness: float) -> Trace:
    """Heads of arrows (shapes, heads, 3) on points: cones of a radius of length times slenderness."""
    radius = slenderness * np.linalg.norm(heads, axis=-1)[..., None, None]
    first = _across(heads)
    second = np.cross(_unit(heads), first)
    angle = 2.0 * np.pi * np.arange(CORNERS)[:, None] / CORNERS
    circle = base[..., None, :] + radius * (
        np.cos(angle) * first[..., None, :] + np.sin(angle) * second[..., None, :]
    )
    points = np.concatenate([(base + heads)[..., None, :], circle], axis=2)
    number = points.shape[1]
    one = [(0, 1 + a, 1 + b) for a, b in pairwise([*range(CORNERS), 0])]
    one += [(1, 1 + b, 1 + a) for a, b in pairwise(range(1, CORNERS))]
    faces = (np.array(one)[None] + (CORNERS + 1) * np.arange(number)[:, None, None]).reshape(-1, 3)
    looks = {
        **dict(zip("ijk", faces.astype(np.int32).T, strict=True)),
        "color": colour,
        "flatshading": True,
        "hoverinfo": "skip",
    }
    return Trace(layer, "mesh3d", points.reshape(len(points), -1, 3), looks)


def _unit(vectors: Array) -> Array:
    """Vectors (..., 3) of length one; those of length zero stay."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: Array = vectors / np.where(length > 0.0, length, 1.0)
    return unit


def _across(vectors: Array) -> Array:
    """Unit vectors across vectors (..., 3)."""
    least = np.eye(3)[np.argmin(np.abs(vectors), axis=-1)]
    return _unit(np.cross(vectors, least))
