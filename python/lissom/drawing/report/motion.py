"""Animated views of a motion: links in space, or a mass on a line in its plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ...model.views import Sketch, View
from . import contacts, layers, page, solids, symbols, visuals
from .plots import MOTION
from .scene import Scene

Array = NDArray[np.float64]

#: Maximum number of frames per second, as on screens; the player interpolates between frames.
FRAME_RATE = 60.0

#: Maximum number of values in all frames, maximum number of frames, and minimum number of frames.
MAX_NUMBERS, MAX_FRAMES, MIN_FRAMES = 600_000, 900, 60

#: Opacity of rods with tendons or chambers inside.
OPACITY_AROUND_ACTUATORS = 0.4

#: Smallest radius of a rod as drawn, relative to its length, so that wires are visible.
LEAST_RADIUS = 0.006

#: Radius of the ball on a tip, relative to the model's size.
TIP = 0.009

#: Maximum number of points of a tip's path.
MAX_PATH = 1500

#: Symbols are scaled to the size of the model, or to this fraction of the diagonal of the scene if that is
#: larger.
LEAST_SIZE = 0.25

#: Radii of the mass and of the line of a planar model, and half the side of its hinge, relative to the size
#: of the scene.
MASS, LINE, HINGE = 0.035, 0.004, 0.015


class Animated(Protocol):
    """A sequence of shapes of a model that can be animated."""

    @property
    def view(self) -> View:
        """The objects to draw."""

    @property
    def t(self) -> Array:
        """Times at which shapes are shown, shape (m,), increasing."""

    @property
    def labels(self) -> Array | None:
        """Values in the labels of the shapes, shape (m,); None for `t`."""

    @property
    def q(self) -> Array:
        """Coordinates, shape (m, n)."""

    @property
    def v(self) -> Array:
        """Velocities, shape (m, n)."""

    @property
    def u(self) -> Array:
        """Inputs, shape (m, inputs)."""

    @property
    def clock(self) -> Array:
        """Times at which the model is shown, seconds, shape (m,)."""

    @property
    def load_factor(self) -> Array:
        """Load factors, shape (m,)."""

    @property
    def opens_at(self) -> int:
        """Index of the shape that is shown first."""

    @property
    def outline(self) -> tuple[str, Array] | None:
        """Name and coordinates (n,) of a shape drawn dashed."""

    @property
    def label(self) -> tuple[str, str]:
        """Text before and after the value of a label."""

    def instants(self, most: int) -> NDArray[np.intp]:
        """Indices of at most this number of shapes, evenly spaced, including the first and the last."""


def sections(title: str, run: Animated, caption: str, clock: str = MOTION) -> list[page.Section]:
    """The animated motion; empty for models that cannot be drawn."""
    scene = scene_of(run)
    return [] if scene is None else [page.Section(title, [page.Player(scene, clock, title, caption)])]


def scene_of(run: Animated) -> Scene | None:
    """The scene of a motion; None for models that cannot be drawn."""
    if run.view.is_spatial:
        return _in_space(run)
    return None if run.view.sketch is None else _in_plane(run, run.view.sketch)


def _in_space(run: Animated) -> Scene:
    """Links as tubes and ellipsoids, with joints, loads and the paths of their tips."""
    seen = run.view
    at = frames(run)
    q, v, t = run.q[at], run.v[at], run.clock[at]
    drawn: list[layers.Thing] = [*tubes(seen, q, v, t, run.u[at]), *bodies(seen, q, t)]
    drawn += visuals.meshes(seen.visuals, q, t)
    drawn += _tips(run, at)
    low, high = layers.extent(drawn)
    # A body that travels far is small in its bounding box.
    size = max(seen.size, LEAST_SIZE * float(np.linalg.norm(high - low)))
    shown = layers.DrawnStates(
        q, v, run.u[at], t, run.load_factor[at], size, widest(seen), half_axis(seen, size)
    )
    things = [*drawn, *symbols.symbols(seen.glyphs, shown)]
    things += contacts.contacts(seen.glyphs.contacts, shown, low, high, drawn)
    low, high = layers.extent(things)
    low, high = box(low, high, 0.04 * float((high - low).max()))
    eye = eye_of(high - low)
    things += symbols.around(seen.glyphs, low, high, eye)
    ground = symbols.floor(seen.glyphs.gravity, low, high)
    singular = {
        "rods": "rod",
        "bodies": "body",
        "visuals": "visual",
        "tips": "tip",
        "paths": "path of the tip",
    }
    numbers = {
        "rods": seen.links,
        "bodies": seen.solids,
        "visuals": seen.visuals,
        "tips": seen.frames,
        "paths": seen.frames,
    }
    names = {name: singular[name] for name, number in numbers.items() if len(number) == 1}
    names |= {"floor": "grid", "tendons": "tendons, thicker with more tension"}
    if not seen.glyphs.supports:
        names["supports"] = "clamp" if len(seen.glyphs.clamps) == 1 else "clamps"
    if run.outline is not None:
        names["initial shape"] = run.outline[0]
    return _scene(run, at, things, low, high, eye, ground, names)


def frames(run: Animated) -> NDArray[np.intp]:
    """Indices of the displayed shapes: fewer if each one has many values."""
    # Seven values for the pose of a section and three for its colours, in four bytes.
    numbers = 9 * sum(len(link.stations) for link in run.view.links) + 7 * (
        len(run.view.solids) + len(run.view.visuals)
    )
    most = np.clip(MAX_NUMBERS // max(numbers, 1), MIN_FRAMES, MAX_FRAMES)
    return run.instants(int(min(most, max(FRAME_RATE * float(run.t[-1] - run.t[0]), MIN_FRAMES)) + 1))


def tubes(seen: View, q: Array, v: Array, t: Array, u: Array) -> list[layers.Tube]:
    """Links in several shapes, transparent if there is something inside."""
    least = LEAST_RADIUS * seen.size
    is_hollow = any(glyph.way is not None for glyph in seen.glyphs.actuators)
    opacity = OPACITY_AROUND_ACTUATORS if is_hollow else 1.0
    return [solids.tube(link, q, v, t, u, least, opacity) for link in seen.links]


def bodies(seen: View, q: Array, t: Array) -> list[layers.Solid]:
    """Rigid bodies in several shapes."""
    return [solids.ellipsoid(solid, q, t, 2.0 * LEAST_RADIUS * seen.size) for solid in seen.solids]


def widest(seen: View) -> float:
    """Radius of the thickest link as drawn, metres."""
    return max((solids.widest(link, LEAST_RADIUS * seen.size) for link in seen.links), default=0.0)


def half_axis(seen: View, size: float) -> float:
    """Half the length of joint axes: longer than bodies are wide, unless bodies are large."""
    largest = max((float(solid.semi_axes.max()) for solid in seen.solids), default=0.0)
    return float(np.clip(1.3 * largest, symbols.AXIS * size, 2.0 * symbols.AXIS * size))


def _tips(run: Animated, at: NDArray[np.intp]) -> list[layers.Thing]:
    """Tips with their paths, and a shape for comparison."""
    seen, path = run.view, run.instants(MAX_PATH)
    things: list[layers.Thing] = []
    if seen.frames:
        shape = (len(at), 4, 4)
        tips = [np.broadcast_to(frame.pose(run.q[at], run.clock[at]), shape) for frame in seen.frames]
        points = np.stack([pose[:, :3, 3] for pose in tips], axis=1)
        things.append(layers.Dots([frame.name for frame in seen.frames], "tips", points, TIP * seen.size))
        if len(path) > 1:
            paths = [frame.pose(run.q[path], run.clock[path])[:, :3, 3] for frame in seen.frames]
            things.append(layers.Line("paths of tips", "paths", _in_one_line(paths)))
    if seen.links and run.outline is not None:
        name, q = run.outline
        dashed = [link.pose(q, link.stations, run.clock[0])[:, :3, 3] for link in seen.links]
        things.append(layers.Line(name, "initial shape", _in_one_line(dashed), dashed=True))
    return things


def _in_one_line(lines: list[Array]) -> Array:
    """Concatenate lines (points, 3) with breaks between them, (1, points, 3)."""
    return np.concatenate([part for line in lines for part in (line, layers.BREAK)])[None]


def box(low: Array, high: Array, margin: float) -> tuple[Array, Array]:
    """A box around another one, with some room perpendicular to planar motions."""
    low, high = low - margin, high + margin
    centre, size = 0.5 * (low + high), np.maximum(high - low, 0.25 * float((high - low).max()))
    return centre - 0.5 * size, centre + 0.5 * size


def eye_of(size: Array) -> Array:
    """View direction for a box of this size: perpendicular to the plane in which most of the motion
    happens."""
    return np.array([(1.6, -0.7, 0.55), (0.45, -1.6, 0.45), (0.55, -1.15, 1.3)][int(np.argmin(size))])


def _in_plane(run: Animated, sketch: Sketch) -> Scene:
    """A mass on a line, with its path."""
    at = run.instants(MAX_FRAMES)
    path = _flat(sketch.mass(run.q[run.instants(MAX_PATH)]))
    size = float(np.ptp(np.concatenate([path, np.zeros((1, 3))]), axis=0).max()) or 1.0
    things: list[layers.Thing] = list(in_plane(sketch, run.q[at], size))
    if len(path) > 1:
        things.append(layers.Line("path", "paths", path[None]))
    low, high = layers.extent(things)
    low, high = box(low, high, 0.08 * size)
    names = {"supports": "spring and hinge", "bodies": "mass", "paths": "path"}
    ground = (1, float(low[1]), True)
    return _scene(run, at, things, low, high, np.array([0.0, 0.0, 1.0]), ground, names)


def in_plane(sketch: Sketch, q: Array, size: float) -> list[layers.Thing]:
    """A mass, its line and its hinge, in several shapes."""
    lines = _flat(np.stack([sketch.line(each) for each in q]))
    hinge = np.full(3, HINGE * size)
    return [
        layers.Strand("spring", "supports", lines, np.full(len(q), LINE * size)),
        layers.Dots(["mass"], "bodies", _flat(sketch.mass(q))[:, None], MASS * size),
        layers.Solid("hinge", "supports", "box", hinge, np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]])),
    ]


def _flat(points: Array) -> Array:
    """Convert points of a plane (..., 2) to points in space."""
    return np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)


def _scene(
    run: Animated,
    at: NDArray[np.intp],
    things: Sequence[layers.Thing],
    low: Array,
    high: Array,
    eye: Array,
    ground: tuple[int, float, bool],
    names: dict[str, str],
) -> Scene:
    """A scene with these shapes of a motion."""
    opens_at = int(np.searchsorted(at, run.opens_at))
    is_time = run.label[1].strip() == "s"
    around = [thing.name for thing in things if thing.layer in symbols.SURROUNDINGS]
    t = np.asarray(run.t, float)[at]
    labels = None if run.labels is None else run.labels[at]
    legend = symbols.LEGEND
    return Scene(
        t, run.label, is_time, opens_at, things, low, high, eye, ground, legend, names, around, labels
    )
