"""Figures for papers: shapes of a motion with their true sections, as polygons, sharp at any size.

Surfaces are seen from far away (orthographic), and drawn from the farthest triangle to the nearest.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import MotionResult
from ..analysis.between import state_at
from ..common import disk
from ..common.arguments import number, path_of
from ..common.extras import missing
from ..model import views
from .parts import Part, parts
from .report import symbols
from .report.motion import eye_of

Array = NDArray[np.float64]

#: Suffixes of figures: two of lines, one of pixels, with this many an inch.
SUFFIXES, RESOLUTION = (".pdf", ".svg", ".png"), 300

#: Names of directions from which a model is seen, in the world's axes.
DIRECTIONS = {
    "front": (0.0, -1.0, 0.0),
    "back": (0.0, 1.0, 0.0),
    "right": (1.0, 0.0, 0.0),
    "left": (-1.0, 0.0, 0.0),
    "top": (0.0, 0.0, 1.0),
    "bottom": (0.0, 0.0, -1.0),
}

#: Metres in an inch.
INCH = 0.0254

#: Narrowest and widest figure, metres.
WIDTHS = (0.01, 2.0)

#: Number of shapes if no times are given.
SHAPES = 5

#: Share of white in the first of several shapes.
PALEST = 0.7

#: Light on surfaces that face away from it, and its direction: to the right, upwards, to the viewer.
SHADE, LIGHT = 0.5, np.array([-0.35, 0.55, 0.76])

#: Larger triangles are cut, relative to the diagonal of the figure: they are sorted by their middles.
LARGEST = 0.04

#: Margin around the drawing, longest scale bar, length of the axes in the corner, relative to its width.
MARGIN, BAR, AXIS = 0.06, 0.2, 0.09

#: Each shape is drawn this much nearer to the viewer than the one before, relative to the diagonal of all:
#: parts that have hardly moved do not show through each other.
NEARER = 0.004

#: Axes that point to the viewer are left out: those that are seen shorter than this.
SHORT_AXIS = 0.2

#: More times than these are told by the first, the last and their number.
TOLD = 6

#: Size of letters and widths of lines, points.
LETTERS, STROKE, HAIR = 7.0, 1.0, 0.15


@dataclass(frozen=True)
class Triangles:
    """Corners (m, 3, 3) in the axes of the figure, the third towards the viewer, and colours (m, 4)."""

    corners: Array
    colours: Array


def of_motion(
    result: MotionResult,
    path: str | os.PathLike[str],
    times: ArrayLike | None,
    view: str | ArrayLike | None,
    width: float,
) -> None:
    """Write a figure of a motion at some times."""
    path = path_of(path)
    if path.suffix not in SUFFIXES:
        raise ValueError(f"path: {path.name!r} has to end with one of {', '.join(SUFFIXES)}")
    if result.model is None:
        raise ValueError("result: its model is not known; it has to be one of `simulate`, not of `newmark`")
    if len(result.t) == 0:
        raise ValueError(f"result: it has no states to show; {result.message}")
    seen = views.view(result.model)
    if not seen.is_spatial:
        raise ValueError("result: figures show rods and bodies, and its model has none")
    t = _times(result, times)
    width = number("width", width)
    if not WIDTHS[0] <= width <= WIDTHS[1]:
        raise ValueError(f"width: {width:g} m is not between {WIDTHS[0]:g} and {WIDTHS[1]:g} m")
    towards = None if view is None else _direction(view)
    if missing("matplotlib"):
        raise ImportError("pictures need matplotlib: pip install 'lissom[plot]'")
    found, t = _shapes(result, seen, t)
    axes = _axes(seen, found, towards)
    with disk.replacing(path) as partial:
        _write(partial, path.suffix[1:], found, t, axes, width)


def _times(result: MotionResult, times: ArrayLike | None) -> Array:
    first, last = float(result.t[0]), float(result.t[-1])
    if times is None:
        return np.unique(np.linspace(first, last, SHAPES))
    given = [number(f"times[{i}]", value) for i, value in enumerate(np.atleast_1d(np.asarray(times, object)))]
    if not given:
        raise ValueError("times: there is none; give at least one, in seconds")
    for i, value in enumerate(given):
        if not first <= value <= last:
            raise ValueError(
                f"times[{i}]: {value:g} s is not within the motion, from {first:g} to {last:g} s"
            )
    return np.array(sorted(given))


def _direction(view: str | ArrayLike) -> Array:
    """The direction from the model to the viewer."""
    if isinstance(view, str):
        if view not in DIRECTIONS:
            raise ValueError(f"view: got {view!r}, expected a direction or one of {', '.join(DIRECTIONS)}")
        return np.array(DIRECTIONS[view])
    given: list[Any] = list(np.atleast_1d(np.asarray(view, object)))
    towards = np.array([number(f"view[{i}]", value) for i, value in enumerate(given)])
    if towards.shape != (3,) or not np.isfinite(towards).all() or not towards.any():
        raise ValueError("view: expected three finite numbers, the direction from the model to the viewer")
    largest: float = np.abs(towards).max()
    return np.asarray(towards / largest)


def _shapes(result: MotionResult, seen: views.View, t: Array) -> tuple[list[Part], Array]:
    states = [state_at(result, time) for time in t]
    before = np.searchsorted(result.t, t, side="right").clip(1) - 1
    q, v = (np.stack(values) for values in zip(*states, strict=True))
    with np.errstate(over="ignore", invalid="ignore"):
        found, is_there = parts(seen, q, v, result.u[before], t)
    if not is_there.any():
        raise ValueError("times: none of the states at these times is finite")
    return found, t[is_there]


def _axes(seen: views.View, found: Sequence[Part], towards: Array | None) -> Array:
    """Axes of the figure in the world as rows: to the right, upwards, to the viewer."""
    shapes = range(len(found[0].centres))
    moving = [part for part in found if part.layer != "obstacles"] or found
    points = np.concatenate([part.vertices(k) for part in moving for k in shapes])
    low, high = points.min(axis=0), points.max(axis=0)
    axis, _, is_up = symbols.floor(seen.glyphs.gravity, low, high)
    up = np.zeros(3)
    up[axis] = 1.0 if is_up else -1.0
    return seen_from(eye_of(high - low) if towards is None else towards, up)


def seen_from(towards: Array, up: Array) -> Array:
    """Axes of a figure as rows: to the right, upwards, to the viewer, who is in a direction."""
    towards = towards / np.linalg.norm(towards)
    if abs(towards @ up) > 1.0 - 1e-9:
        # Seen from above or below: the next axis is up.
        up = np.roll(np.abs(up), -1)
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(towards, right), towards])


def triangles(found: Sequence[Part], axes: Array) -> Triangles:
    """All triangles that face the viewer, the farthest first."""
    corners: list[Array] = []
    colours: list[Array] = []
    nearer: list[Array] = []
    shapes = len(found[0].centres)
    for part in found:
        base = symbols.LEGEND[part.layer]
        colour = np.array([int(base[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
        is_still = part.layer == "obstacles"
        for k in range(1 if is_still else shapes):
            pale = 0.0 if is_still or shapes == 1 else PALEST * (1.0 - k / (shapes - 1))
            of_part = (part.vertices(k) @ axes.T)[part.triangles]
            normal = np.cross(of_part[:, 1] - of_part[:, 0], of_part[:, 2] - of_part[:, 0])
            normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
            if part.is_open:
                normal *= np.where(normal[:, 2:] < 0.0, -1.0, 1.0)
            is_seen = normal[:, 2] > 0.0
            light = SHADE + (1.0 - SHADE) * np.maximum(normal[is_seen] @ LIGHT, 0.0)
            shaded = (light[:, None] * colour) * (1.0 - pale) + pale
            corners.append(of_part[is_seen])
            colours.append(np.column_stack([shaded, np.full(len(shaded), part.opacity)]))
            nearer.append(np.full(len(shaded), 0.0 if is_still else float(k)))
    rows = np.column_stack([np.concatenate(colours), np.concatenate(nearer)])
    every, rows = _cut(np.concatenate(corners), rows)
    diagonal = float(np.linalg.norm(np.ptp(every.reshape(-1, 3), axis=0)))
    order = np.argsort(every[..., 2].mean(axis=1) + NEARER * diagonal * rows[:, 4], kind="stable")
    return Triangles(every[order], rows[order, :4])


def _cut(corners: Array, colours: Array) -> tuple[Array, Array]:
    """Triangles whose longest sides are halved until they are short."""
    extent = np.ptp(corners.reshape(-1, 3), axis=0)
    most = LARGEST * float(np.linalg.norm(extent))
    done: list[tuple[Array, Array]] = []
    while len(corners):
        sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=-1)
        is_short = sides.max(axis=1) <= most
        done.append((corners[is_short], colours[is_short]))
        corners, colours, longest = corners[~is_short], colours[~is_short], sides[~is_short].argmax(axis=1)
        rows = np.arange(len(corners))
        a, b, c = (corners[rows, (longest + i) % 3] for i in range(3))
        middle = 0.5 * (a + b)
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        colours = np.concatenate([colours, colours])
    return np.concatenate([part[0] for part in done]), np.concatenate([part[1] for part in done])


def round_length(most: float) -> float:
    """The largest length of 1, 2 or 5 times a power of ten up to `most`."""
    power = 10.0 ** math.floor(math.log10(most))
    return max(factor * power for factor in (1.0, 2.0, 5.0) if factor * power <= most * (1.0 + 1e-9))


def length_in_words(metres: float) -> str:
    """A length with the unit in which it is a short number."""
    for unit, size in (("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("µm", 1e-6)):
        if metres >= size * (1.0 - 1e-9):
            return f"{metres / size:.4g} {unit}"
    return f"{metres:.3g} m"


def times_in_words(t: Array) -> str:
    """The times of the shapes."""
    if len(t) > TOLD:
        return f"t = {t[0]:.4g} to {t[-1]:.4g} s, {len(t)} shapes"
    return f"t = {', '.join(f'{time:.4g}' for time in t)} s"


def _write(
    path: os.PathLike[str], kind: str, found: Sequence[Part], t: Array, axes: Array, width: float
) -> None:
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    drawn = triangles(found, axes)
    low, high = (end(drawn.corners[..., :2].reshape(-1, 2), axis=0) for end in (np.min, np.max))
    margin = MARGIN * float((high - low).max())
    low, high = low - margin, high + margin
    # Below the drawing: the axes, the scale bar, and the times.
    wide = float(high[0] - low[0])
    below = 1.9 * AXIS * wide
    low = low - np.array([0.0, below])
    tall = float(high[1] - low[1])
    # Letters remain as they are, so text of a given font is the same in figures of all widths.
    with rc_context({"font.size": LETTERS, "pdf.fonttype": 42, "svg.fonttype": "none", "svg.hashsalt": "0"}):
        figure = Figure(figsize=(width / INCH, width / INCH * tall / wide))
        plot = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        plot.set_axis_off()
        plot.set_xlim(low[0], high[0])
        plot.set_ylim(low[1], high[1])
        plot.add_collection(polygons(drawn), autolim=False)
        corner(plot, axes, low + 0.9 * AXIS * wide, AXIS * wide)
        _bar(plot, np.array([high[0] - margin, low[1] + 0.5 * AXIS * wide]), wide)
        at = low + np.array([2.3, 0.5]) * AXIS * wide
        plot.text(at[0], at[1], times_in_words(t), ha="left", va="bottom")
        dated = {"pdf": "CreationDate", "svg": "Date"}
        metadata: dict[str, Any] = {dated[kind]: None} if kind in dated else {}
        figure.savefig(path, format=kind, dpi=RESOLUTION, metadata=metadata)


def polygons(drawn: Triangles) -> Any:
    """The triangles as a collection of Matplotlib."""
    from matplotlib.collections import PolyCollection

    # Edges in the colour of the faces close the gaps that viewers leave between neighbours.
    edges = np.where(drawn.colours[:, 3:] < 1.0, 0.0, drawn.colours)
    return PolyCollection(
        list(drawn.corners[..., :2]), facecolors=drawn.colours, edgecolors=edges, linewidths=HAIR, snap=False
    )


def corner(plot: Any, axes: Array, place: Array, length: float) -> None:
    """The axes of the world, as they are seen; those towards the viewer are left out."""
    for i, name in enumerate("xyz"):
        along = axes[:2, i]
        seen = float(np.linalg.norm(along))
        if seen < SHORT_AXIS:
            continue
        head = f"-|>,head_length={0.4 * seen:.3f},head_width={0.2 * seen:.3f}"
        arrow = {"arrowstyle": head, "linewidth": STROKE, "shrinkA": 0, "shrinkB": 0, "color": "black"}
        plot.annotate("", place + 0.75 * length * along, place, arrowprops=arrow)
        plot.text(*(place + 0.95 * length * along), name, ha="center", va="center", style="italic")


def _bar(plot: Any, end: Array, wide: float) -> None:
    """A bar of a round length, which ends here."""
    length = round_length(BAR * wide)
    plot.plot(
        [end[0] - length, end[0]], [end[1]] * 2, color="black", linewidth=2.0 * STROKE, solid_capstyle="butt"
    )
    plot.text(end[0] - 0.5 * length, end[1] + 0.012 * wide, length_in_words(length), ha="center", va="bottom")
