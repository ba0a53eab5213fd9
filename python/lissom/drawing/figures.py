"""Figures for papers: shapes of a motion with their true sections, as polygons, sharp at any size.

Surfaces are seen from far away (orthographic), and drawn from the farthest triangle to the nearest.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import MotionResult, StaticsResult
from ..analysis.between import state_at
from ..common import disk
from ..common.arguments import number, path_of
from ..common.elsewhere import WRITTEN, of_suffix
from ..common.extras import missing
from ..model import views
from ..model.visuals import Visual
from ..results.studies import Setting
from .painting import polygons, triangles, view_axes
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

#: Narrowest and widest figure, metres. The words beside the bar need the narrowest width
#: (`test_words_do_not_run_into_the_bar`).
WIDTHS = (0.04, 2.0)

#: Number of shapes if no times are given.
SHAPES = 5

#: Margin around the drawing, longest scale bar, length of the axes in the corner, relative to its width.
MARGIN, BAR, AXIS = 0.06, 0.2, 0.09

#: Height of the highest figure, relative to its width.
TALLEST = 2.0

#: Figures below this width are narrow, metres.
NARROW = 0.065

#: Height of a line of words relative to its letters, and a point in metres.
LINE, POINT = 1.8, INCH / 72

#: Mean width of figures, commas and spaces relative to the size of letters (DejaVu Sans).
LETTER = 0.56

#: Axes that point to the viewer are left out: those that are seen shorter than this.
SHORT_AXIS = 0.2

#: More times than these are listed as the first, the last and their number.
LISTED_TIMES = 6

#: Size of letters and widths of lines, points.
LETTERS, STROKE = 7.0, 1.0


@dataclass(frozen=True)
class Room:
    """Room below a drawing: length of the axes and height of a line for words, relative to the width."""

    axis: float = AXIS
    #: Zero if the words stand beside the axes.
    line: float = 0.0

    @property
    def height(self) -> float:
        """The whole height, relative to the width."""
        return 1.9 * self.axis + self.line


#: That of wide figures.
ROOM = Room()


def of_motion(
    result: MotionResult,
    path: str | os.PathLike[str],
    times: ArrayLike | None,
    view: str | ArrayLike | None,
    width: float,
    visuals: Sequence[Visual] = (),
) -> None:
    """Write a figure of a motion at the given times."""
    path, width, towards = _checked(path, width, view)
    if result.model is None:
        raise ValueError("result: its model is not known; it has to be one of `simulate`, not of `newmark`")
    if len(result.t) == 0:
        raise ValueError(f"result: it has no states to show; {result.message}")
    seen = _in_space(views.drawn(result.model, visuals))
    found, t = _shapes(result, seen, _times(result, times))
    _write(path, seen, found, times_in_words(t, _letters(width)), towards, width)


def of_statics(
    result: StaticsResult,
    path: str | os.PathLike[str],
    setting: Setting,
    view: str | ArrayLike | None,
    width: float,
) -> None:
    """Write a figure of an equilibrium."""
    path, width, towards = _checked(path, width, view)
    seen = _in_space(setting.view)
    at, rest = np.array([setting.t]), np.zeros_like(result.q)
    found, is_there = parts(seen, result.q[None], rest[None], np.asarray(setting.u)[None], at, is_smooth=True)
    if not is_there.all():
        raise ValueError(f"result: its coordinates are not finite; {result.message}")
    _write(path, seen, found, "", towards, width)


def _checked(
    path: str | os.PathLike[str], width: float, view: str | ArrayLike | None
) -> tuple[Path, float, Array | None]:
    """The arguments of all figures: path, width, and direction to the viewer."""
    path = path_of(path)
    if path.suffix not in SUFFIXES:
        instead = of_suffix(path.suffix, WRITTEN, "picture")
        raise ValueError(f"path: {path.name!r} has to end with one of {', '.join(SUFFIXES)}{instead}")
    width = number("width", width)
    if not WIDTHS[0] <= width <= WIDTHS[1]:
        raise ValueError(f"width: {width:g} m is not between {WIDTHS[0]:g} and {WIDTHS[1]:g} m")
    towards = None if view is None else _direction(view)
    if missing("matplotlib"):
        raise ImportError("pictures need matplotlib: pip install 'lissom[plot]'")
    return path, width, towards


def _in_space(seen: views.View) -> views.View:
    if not seen.is_spatial:
        raise ValueError("result: figures show rods and bodies, and its model has none")
    return seen


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
        found, is_there = parts(seen, q, v, result.u[before], t, is_smooth=True)
    if not is_there.any():
        raise ValueError("times: none of the states at these times is finite")
    return found, t[is_there]


def extent(found: Sequence[Part], axes: Array) -> tuple[Array, Array]:
    """Lowest and highest coordinates (3,) of everything in all shapes, in the axes of a figure."""
    ends = []
    for part in found:
        for k in range(1 if part.layer == "obstacles" else len(part.centres)):
            points = part.vertices(k) @ axes.T
            ends += [points.min(axis=0), points.max(axis=0)]
    return np.min(ends, axis=0), np.max(ends, axis=0)


def axes_of(seen: views.View, found: Sequence[Part], towards: Array | None = None) -> Array:
    """Axes of the figure in the world as rows: to the right, upwards, to the viewer."""
    moving = [part for part in found if part.layer != "obstacles"] or found
    low, high = extent(moving, np.eye(3))
    axis, _, is_up = symbols.floor(seen.glyphs.gravity, low, high)
    up = np.zeros(3)
    up[axis] = 1.0 if is_up else -1.0
    return view_axes(eye_of(high - low) if towards is None else towards, up)


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


def times_in_words(t: Array, letters: float = math.inf) -> str:
    """The times of the shapes, in brief if they are many or have more letters than fit."""
    words = f"t = {', '.join(f'{time:.4g}' for time in t)} s"
    if len(t) > LISTED_TIMES or (len(t) > 1 and len(words) > letters):
        return f"t = {t[0]:.4g} to {t[-1]:.4g} s, {len(t)} shapes"
    return words


def _letters(width: float) -> float:
    """How many letters fit into the line for words."""
    beside = 0.0 if width < NARROW else 2.3 * AXIS + BAR - MARGIN
    return (1.0 - 2.0 * MARGIN - beside) * width / (LETTER * LETTERS * POINT)


def _write(
    path: Path, seen: views.View, found: Sequence[Part], words: str, towards: Array | None, width: float
) -> None:
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    axes = axes_of(seen, found, towards)
    drawn = triangles(found, axes)
    low, high = (end(drawn.corners[..., :2].reshape(-1, 2), axis=0) for end in (np.min, np.max))
    # In narrow figures the axes stay as long as their letters need, and words have a line of their own.
    room = Room(AXIS * max(1.0, NARROW / width), LINE * LETTERS * POINT / width if width < NARROW else 0.0)
    low, high = with_margin(low, high, 1.0 / TALLEST, room=room)
    kind = path.suffix[1:]
    dated = {"pdf": "CreationDate", "svg": "Date"}
    metadata: dict[str, Any] = {dated[kind]: None} if kind in dated else {}
    # Letters remain as they are, so text of a given font is the same in figures of all widths.
    with (
        disk.replacing(path) as partial,
        rc_context({"font.size": LETTERS, "pdf.fonttype": 42, "svg.fonttype": "none", "svg.hashsalt": "0"}),
    ):
        wide, tall = high - low
        figure = Figure(figsize=(width / INCH, width / INCH * float(tall / wide)))
        plot, caption = page(figure, low, high, axes, room)
        plot.add_collection(polygons(drawn), autolim=False)
        caption.set_text(words)
        figure.savefig(partial, format=kind, dpi=RESOLUTION, metadata=metadata)


def with_margin(
    low: Array, high: Array, least: float, most: float = np.inf, room: Room = ROOM
) -> tuple[Array, Array]:
    """A rectangle with a margin around a drawing, and with room below it for axes, bar and words.

    Its width is between `least` and `most` of its height.
    """
    margin = MARGIN * float((high - low).max())
    low, high = low - margin, high + margin
    wide, tall = high - low
    # The room below is relative to the width.
    wider = max(0.0, least * tall / (1.0 - room.height * least) - wide)
    beside, below = np.array([0.5 * wider, 0.0]), np.array([0.0, room.height * (wide + wider)])
    low, high = low - beside - below, high + beside
    lacking = max(0.0, float(high[0] - low[0]) / most - float(high[1] - low[1]))
    above = np.array([0.0, 0.5 * lacking])
    return low - above, high + above


def page(figure: Any, low: Array, high: Array, axes: Array, room: Room = ROOM) -> tuple[Any, Any]:
    """Axes of Matplotlib over the whole figure with a scale bar, for this rectangle, and a text for words."""
    wide = float(high[0] - low[0])
    plot = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    plot.set_axis_off()
    plot.set_xlim(low[0], high[0])
    plot.set_ylim(low[1], high[1])
    line, axis = room.line * wide, room.axis * wide
    # Axes to the left and downwards need room beside their origin.
    back, down = np.maximum(0.0, -axes[:2].min(axis=1))
    origin = 0.9 + 0.6 * np.array([back, down])
    corner(plot, axes, low + axis * origin + [0.0, line], axis)
    _bar(plot, np.array([high[0] - MARGIN * wide, low[1] + 0.5 * axis + line]), wide)
    at = low + (
        [MARGIN * wide, 0.4 * line]
        if line > 0.0
        else [axis * max(2.3, origin[0] + axes[0].max() + 0.4), 0.5 * axis]
    )
    return plot, plot.text(at[0], at[1], "", ha="left", va="bottom")


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
