"""Matplotlib figures and animations of results."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._lissom import (
    ContinuationResult,
    EnsembleResult,
    Model,
    ModesResult,
    MotionResult,
    Robot,
    StaticsResult,
    check_model,
)
from ..analysis.equilibria import EquilibriumSensitivityResult
from ..analysis.fitted import FitResult, FittedData
from ..analysis.quantiles import BAND, quantiles
from ..analysis.sensitivities import SensitivityResult
from ..common import disk
from ..common.arguments import number, path_of, whole
from ..common.elsewhere import WRITTEN, of_suffix
from ..common.extras import missing
from ..model import views
from ..model.units import with_unit
from ..model.views import Coordinate, View, view
from ..model.visuals import Visual
from ..results.datasets import coordinates
from ..results.runs import energies, instants
from ..results.studies import Setting, way
from .figures import axes_of, extent, page, with_margin
from .oscillation import frequency, mode_motion
from .painting import polygons, triangles
from .parts import parts

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

#: Suffixes of animations, with the codec of those that need ffmpeg.
CODECS = {".gif": None, ".mp4": "libx264", ".webm": "libvpx-vp9"}

#: Maximum number of frames of an animation; more take minutes to draw.
MOST_PICTURES = 3000

#: Lowest and highest frame rate.
RATES = (1.0, 100.0)

#: Maximum number of points of a curve: more than a screen can show.
MOST_POINTS = 5000

#: Maximum number of parameters with axes of their own.
MOST_PARAMETERS = 12

#: Width and height of animations, inches, and pixels per inch.
FILM, RESOLUTION = (6.0, 5.0), 120

#: Smallest extent of a drawing, metres.
SMALLEST = 1e-6


def _need_matplotlib() -> None:
    if missing("matplotlib"):
        raise ImportError("pictures need matplotlib: pip install 'lissom[plot]'")


def _axes(count: int) -> Any:
    _need_matplotlib()
    from matplotlib import pyplot

    _, axes = pyplot.subplots(count, 1, figsize=(7.0, 2.4 * count), squeeze=False, layout="constrained")
    return axes[:, 0]


def _literal(text: str) -> str:
    """Text that is drawn as it is: Matplotlib takes what stands between dollars for a formula."""
    return text.replace("$", r"\$")


def _curves(axes: Axes, x: Array, values: Array, names: list[str], label: str) -> None:
    for column, name in zip(values.T, names, strict=True):
        axes.plot(x, column, label=_literal(name))
    axes.set_ylabel(_literal(label))
    axes.grid(alpha=0.3)
    if 1 < len(names) <= 12:
        axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))


def _by_kind(known: list[Coordinate]) -> dict[tuple[str, str], list[int]]:
    """Indices of the coordinates by kind and unit; each kind has its own axes."""
    kinds: dict[tuple[str, str], list[int]] = {}
    for i, coordinate in enumerate(known):
        kinds.setdefault((coordinate.kind, coordinate.unit), []).append(i)
    return kinds


def _label(kind: str, unit: str) -> str:
    return f"{kind} ({unit})" if unit else kind


def _draw_coordinates(axes: Any, x: Array, q: Array, known: list[Coordinate]) -> None:
    for one, ((kind, unit), columns) in zip(axes, _by_kind(known).items(), strict=True):
        _curves(one, x, q[:, columns], [known[i].name for i in columns], _label(kind, unit))


def of_motion(result: MotionResult) -> NDArray[Any]:
    """Coordinates by kind, positions of the tips, energies."""
    if len(result.t) == 0:
        raise ValueError(f"result: it has no states to show; {result.message}")
    at = instants(len(result.t), MOST_POINTS)
    t, q, model = result.t[at], result.q[at], result.model
    known = coordinates(model, q.shape[1])
    frames = () if model is None else view(model).frames
    kinds, balance = len(_by_kind(known)), result.balance
    axes = _axes(kinds + len(frames) + (balance is not None))
    _draw_coordinates(axes[:kinds], t, q, known)
    for one, frame in zip(axes[kinds:], frames, strict=False):
        _curves(one, t, frame.pose(q, t)[..., :3, 3], ["x", "y", "z"], f"position of {frame.name} (m)")
    if balance is not None:
        parts = energies(balance)
        _curves(axes[-1], t, np.stack(list(parts.values()), axis=1)[at], list(parts), "energy (J)")
    axes[-1].set_xlabel("time (s)")
    return axes  # type: ignore[no-any-return]


def of_statics(result: StaticsResult, model: Model) -> NDArray[Any]:
    """The equilibrium shape of the model."""
    check_model(model, "model")
    coordinates(model, len(result.q))
    if not np.isfinite(result.q).all():
        raise ValueError(f"result: its coordinates are not finite; {result.message}")
    drawn = _Drawn(view(model), result.q[None], np.array([result.t or 0.0]))
    drawn.show(0)
    verdict = result.stability or result.status
    drawn.axes.set_title(f"Equilibrium, {verdict}")
    return np.array([drawn.axes], dtype=object)


def of_path(result: ContinuationResult, model: Model | None) -> NDArray[Any]:
    """Coordinates and the lowest eigenvalue over the load factor, with the critical points."""
    path = result.path
    if len(path.q) == 0:
        raise ValueError(f"result: it has no equilibria to show; {result.message}")
    known = coordinates(model, path.q.shape[1])
    axes = _axes(len(_by_kind(known)) + 1)
    _draw_coordinates(axes[:-1], path.load_factor, path.q, known)
    _curves(axes[-1], path.load_factor, path.lowest_eigenvalue[:, None], [""], "lowest eigenvalue")
    axes[-1].axhline(0.0, color="black", linewidth=0.8)
    for point in path.critical_points:
        for one in axes:
            one.axvline(point.load_factor, color="tab:red", linestyle=":", linewidth=1.0)
        axes[0].annotate(
            point.kind,
            (point.load_factor, 1.0),
            xytext=(0.0, 3.0),
            textcoords="offset points",
            xycoords=("data", "axes fraction"),
            color="tab:red",
        )
    axes[-1].set_xlabel("load factor")
    return axes  # type: ignore[no-any-return]


def of_modes(result: ModesResult) -> NDArray[Any]:
    """Frequency and damping ratio of each mode."""
    axes = _axes(2)
    numbers = np.arange(1, len(result.frequency) + 1)
    axes[0].bar(numbers, result.frequency)
    axes[0].set_ylabel("frequency (Hz)")
    axes[1].bar(numbers, result.damping_ratio)
    axes[1].set_ylabel("damping ratio")
    if not np.any(result.damping_ratio):
        axes[1].set_ylim(0.0, 1.0)
    axes[1].set_xlabel("mode")
    for one in axes:
        one.xaxis.get_major_locator().set_params(integer=True)
        one.grid(alpha=0.3, axis="y")
    return axes  # type: ignore[no-any-return]


def of_ensemble(result: EnsembleResult, model: Model | None) -> NDArray[Any]:
    """Coordinates by kind: their spread over time, or the final values of each run."""
    if not result.success.any():
        raise ValueError(f"result: no run came to its end; {result.message[0]}")
    known = coordinates(model, result.q.shape[-1])
    kinds = _by_kind(known)
    axes = _axes(len(kinds))
    if result.keep == "states":
        at = instants(len(result.t), MOST_POINTS)
        t, (low, middle, high) = result.t[at], quantiles(result)[:, at]
        _draw_coordinates(axes, t, middle, known)
        for one, columns in zip(axes, kinds.values(), strict=True):
            for column, line in zip(columns, one.lines, strict=True):
                one.fill_between(t, low[:, column], high[:, column], color=line.get_color(), alpha=0.2, lw=0)
        share = f"{100 * (BAND[1] - BAND[0]):.0f}"
        axes[0].set_title(f"median and {share} percent of {result.success.sum()} runs", fontsize="medium")
        axes[-1].set_xlabel("time (s)")
        return axes  # type: ignore[no-any-return]
    rows = np.flatnonzero(result.success)
    _draw_coordinates(axes, rows.astype(float), result.q[rows], known)
    for line in [line for one in axes for line in one.lines]:
        line.set(linestyle="", marker=".")
    axes[-1].set_xlabel("row")
    return axes  # type: ignore[no-any-return]


def of_parameters(result: Any) -> NDArray[Any]:
    """Derivatives of a run or of an equilibrium, or a fit with the measured data."""
    if isinstance(result, FitResult):
        return _of_fit(result)
    assert isinstance(result, SensitivityResult | EquilibriumSensitivityResult)
    if result.dq is None:
        assert result.gradient is not None
        return _bars(result.names, {"derivative of the objective": result.gradient})
    if isinstance(result, EquilibriumSensitivityResult):
        bars = {f"of frequency {k + 1} (Hz)": row for k, row in enumerate(result.dfrequencies)}
        if isinstance(result._model, Robot):
            bars = dict(zip("xyz", result.position()[1], strict=True)) | bars
        return _bars(result.names, bars or {"of the first coordinate": result.dq[0]})
    at = instants(len(result.t), MOST_POINTS)
    names, axes = list(result.names), _axes(min(len(result.names), MOST_PARAMETERS))
    if isinstance(result._model, Robot):
        values, labels, what = result.position(t=result.t[at])[1], ["x", "y", "z"], "tip (m)"
    else:
        known = coordinates(result._model, result.q.shape[1])
        values, labels, what = result.dq[at], [c.name for c in known], "coordinates"
    for i, one in enumerate(axes):
        _curves(one, result.t[at], values[:, :, i], labels, f"{what} per unit of\n{with_unit(names[i])}")
    axes[-1].set_xlabel("time (s)")
    return axes  # type: ignore[no-any-return]


def _bars(names: Sequence[str], of_each: dict[str, Array]) -> NDArray[Any]:
    axes = _axes(len(of_each))
    for one, (label, values) in zip(axes, of_each.items(), strict=True):
        one.barh(np.arange(len(names)), values)
        one.set_yticks(np.arange(len(names)), [_literal(with_unit(name)) for name in names], fontsize="small")
        one.invert_yaxis()
        one.set_xlabel(f"{label} per unit of the parameter")
        one.grid(alpha=0.3, axis="x")
    return axes  # type: ignore[no-any-return]


def _of_fit(result: FitResult) -> NDArray[Any]:
    """Measured data as dots and the fitted model as lines, for each place; residuals below."""
    axes = _axes(2 * sum(max(len(each.places), 1) for each in result.data))
    first = 0
    for i, each in enumerate(result.data):
        last = first + 2 * max(len(each.places), 1)
        _of_recording(each, axes[first:last], "" if len(result.data) == 1 else f"data[{i}]\n")
        first = last
    return axes  # type: ignore[no-any-return]


def _of_recording(data: FittedData, axes: NDArray[Any], title: str) -> None:
    x: Array = np.arange(1.0, 1.0 + len(data.measured)) if data.t is None else np.asarray(data.t)
    below = "time (s)" if data.t is not None else "shape" if data.places else "mode"
    places = data.places or ("",)
    shown = [part.reshape(len(x), len(places), -1) for part in (data.measured, data.fitted, data.residuals)]
    names = list("xyz") if data.places else [""]
    for k, place in enumerate(places):
        upper, lower = axes[2 * k : 2 * k + 2]
        what = f"{title}position of {place}" if place else f"{title}frequency"
        _curves(upper, x, shown[1][:, k], names, f"{what} ({data.unit})")
        for line, values in zip(upper.lines, shown[0][:, k].T, strict=True):
            upper.plot(x, values, ".", color=line.get_color(), markersize=3.0)
        _curves(lower, x, shown[2][:, k], names, f"residual ({data.unit})")
        if data.t is None:
            # Shapes and modes are counted: nothing is between them.
            _as_points(upper.lines[: len(names)], "o")
            _as_points(lower.lines, ".")
            for one in (upper, lower):
                one.xaxis.get_major_locator().set_params(integer=True)
        lower.axhline(0.0, color="black", linewidth=0.8)
    axes[-1].set_xlabel(below)


def _as_points(lines: Iterable[Any], marker: str) -> None:
    """Draw curves as points, which are hollow if they are discs."""
    for line in lines:
        line.set(linestyle="", marker=marker, markerfacecolor="none" if marker == "o" else line.get_color())


class _Drawn:
    """Axes on which a model is drawn at one state after the other."""

    def __init__(self, shown: View, q: Array, t: Array, figure: Any = None) -> None:
        _need_matplotlib()
        if figure is None:
            from matplotlib import pyplot

            figure = pyplot.figure(figsize=(6.0, 5.0))
        if shown.is_spatial:
            self.axes = figure.add_subplot(projection="3d")
            lines = [link.pose(q, link.stations, t)[..., :3, 3] for link in shown.links]
            points = [solid.pose(q, t)[..., None, :3, 3] for solid in shown.solids]
        elif shown.sketch is not None:
            self.axes = figure.add_subplot()
            lines = [np.stack([shown.sketch.line(state) for state in q])]
            points = [shown.sketch.mass(q)[:, None]]
        else:
            raise ValueError("result: nothing is known of how its model looks")
        self._shapes = [(line, "-") for line in lines] + [(point, "o") for point in points]
        self._artists = [self.axes.plot(*shape[0].T, style)[0] for shape, style in self._shapes]
        self._limits()
        for name in "xyz"[: self._shapes[0][0].shape[-1]]:
            getattr(self.axes, f"set_{name}label")(f"{name} (m)")

    def _limits(self) -> None:
        """Set the same scale on all axes, large enough for the whole motion."""
        everything = np.concatenate([shape.reshape(-1, shape.shape[-1]) for shape, _ in self._shapes])
        low, high = everything.min(axis=0), everything.max(axis=0)
        half = 0.55 * max(float((high - low).max()), SMALLEST)
        for name, middle in zip("xyz", (low + high) / 2, strict=False):
            getattr(self.axes, f"set_{name}lim")(middle - half, middle + half)
        if len(low) == 3:
            self.axes.set_box_aspect((1, 1, 1))
            for name in "xyz":
                # Few ticks: labels of three axes in perspective are close together.
                axis = getattr(self.axes, f"{name}axis")
                axis.get_major_locator().set_params(nbins=4)
                axis.labelpad = 9.0
        else:
            self.axes.set_aspect("equal")

    def show(self, i: int) -> None:
        for artist, (shape, _) in zip(self._artists, self._shapes, strict=True):
            if shape.shape[-1] == 3:
                artist.set_data_3d(*shape[i].T)
            else:
                artist.set_data(*shape[i].T)


def _number(name: str, value: Any) -> float:
    return number(name, value)


def animate(
    result: MotionResult,
    path: str | os.PathLike[str],
    fps: float,
    speed: float,
    visuals: Sequence[Visual] = (),
) -> None:
    """Write a motion as a GIF or a video."""
    path, fps, speed = _suffixed(path), _rate(fps), _positive("speed", speed)
    if result.model is None:
        raise ValueError("result: its model is not known; it has to be one of `simulate`, not of `newmark`")
    if len(result.t) == 0:
        raise ValueError(f"result: it has no states to show; {result.message}")
    at = _pictures(result.t, fps, speed)
    t, q = result.t[at], result.q[at]
    shown = _States(q, result.v[at], result.u[at], t)
    _film(path, fps, views.drawn(result.model, visuals), shown, [f"t = {time:.3f} s" for time in t])


def animate_path(
    result: ContinuationResult, path: str | os.PathLike[str], setting: Setting, fps: float, duration: float
) -> None:
    """Write a path of equilibria as a GIF or a video."""
    path, fps, duration = _suffixed(path), _rate(fps), _positive("duration", duration)
    found = result.path
    if len(found.q) == 0:
        raise ValueError(f"result: it has no equilibria to show; {result.message}")
    place, at = way(found), np.linspace(0.0, 1.0, _count(fps, duration))
    # Shapes are interpolated between equilibria, as in reports.
    q = np.stack([np.interp(at, place, column) for column in found.q.T], axis=1).reshape(len(at), -1)
    titles = [f"load factor {factor:.3f}" for factor in np.interp(at, place, found.load_factor)]
    _film(path, fps, setting.view, _at_rest(q, setting), titles)


def animate_mode(
    result: ModesResult,
    path: str | os.PathLike[str],
    setting: Setting,
    q: Array,
    mode: int,
    fps: float,
    duration: float,
) -> None:
    """Write one period of a mode as a GIF or a video."""
    path, fps, duration = _suffixed(path), _rate(fps), _positive("duration", duration)
    mode = whole("mode", mode)
    number = len(result.frequency)
    if not 0 <= mode < number:
        raise ValueError(
            f"mode: got {mode}, expected a number from 0 to {number - 1}: there are {number} modes"
        )
    count = _count(fps, duration)
    # The period ends one frame before it repeats, so that players loop smoothly.
    states = mode_motion(setting, q, result.shapes[:, mode], np.arange(count) / count)
    title = f"mode {mode + 1} of {number}: {frequency(result, int(mode))}"
    _film(path, fps, setting.view, _at_rest(states, setting), [title] * count)


def _suffixed(path: str | os.PathLike[str]) -> Path:
    path = path_of(path)
    if path.suffix not in CODECS:
        instead = of_suffix(path.suffix, WRITTEN, "animate")
        raise ValueError(f"path: {path.name!r} has to end with one of {', '.join(CODECS)}{instead}")
    return path


def _rate(fps: float) -> float:
    fps = _number("fps", fps)
    if not RATES[0] <= fps <= RATES[1]:
        raise ValueError(f"fps: {fps:g} is not between {RATES[0]:g} and {RATES[1]:g} pictures per second")
    return fps


def _positive(name: str, value: float) -> float:
    value = _number(name, value)
    if not (np.isfinite(value) and value > 0.0):
        raise ValueError(f"{name}: {value:g} is not a finite number above zero")
    return value


def _count(fps: float, duration: float) -> int:
    """Number of frames of a video of this duration, seconds."""
    count = fps * duration
    if not count < MOST_PICTURES:
        raise ValueError(
            f"duration: {count:.3g} pictures are more than {MOST_PICTURES}; lower `fps` or `duration`"
        )
    return max(round(count), 1)


def _pictures(t: Array, fps: float, speed: float) -> NDArray[np.intp]:
    """For each frame, the index of the state that is nearest in time."""
    count = (t[-1] - t[0]) * fps / speed
    if not count < MOST_PICTURES:
        raise ValueError(
            f"fps: {count:.3g} pictures are more than {MOST_PICTURES}; lower `fps` or raise `speed`"
        )
    times = t[0] + np.arange(int(count) + 1) * (speed / fps)
    right = np.searchsorted(t, times).clip(1, max(len(t) - 1, 1))
    left = right - 1
    if len(t) == 1:
        return np.zeros(1, dtype=np.intp)
    nearest: NDArray[np.intp] = np.where(times - t[left] <= t[right] - times, left, right)
    return nearest


@dataclass(frozen=True)
class _States:
    """What films show: coordinates, velocities (frames, n), inputs (frames, inputs) and times (frames,)."""

    q: Array
    v: Array
    u: Array
    t: Array


def _at_rest(q: Array, setting: Setting) -> _States:
    inputs = np.broadcast_to(setting.u, (len(q), len(setting.u)))
    return _States(q, np.zeros_like(q), inputs, np.full(len(q), setting.t))


def _film(path: Path, fps: float, shown: View, states: _States, titles: Sequence[str]) -> None:
    """Draw one state after the other, each with its title."""
    _need_matplotlib()
    codec = CODECS[path.suffix]
    if codec is not None and shutil.which("ffmpeg") is None:
        raise FileNotFoundError(
            f"{path.suffix} files need the program ffmpeg, which is not installed; .gif files do not"
        )
    # Fails before minutes of drawing if the file cannot be written.
    with disk.replacing(path) as partial:
        _draw_film(partial, fps, codec, shown, states, titles)


def _draw_film(
    path: Path, fps: float, codec: str | None, shown: View, states: _States, titles: Sequence[str]
) -> None:
    from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=FILM)
    FigureCanvasAgg(figure)
    drawn = _InSpace(shown, states, figure) if shown.is_spatial else _InPlane(shown, states, figure)
    # Both writers accept fractions, contrary to Matplotlib's annotations; GIF counts hundredths of a second.
    rate: Any = fps
    writer: AbstractMovieWriter = PillowWriter(rate) if codec is None else FFMpegWriter(rate, codec)
    with writer.saving(figure, str(path), RESOLUTION):
        for i, title in enumerate(titles):
            drawn.show(i, title)
            writer.grab_frame()


class _InSpace:
    """A figure that shows one shape after the other, as figures for papers do."""

    def __init__(self, shown: View, states: _States, figure: Any) -> None:
        with np.errstate(over="ignore", invalid="ignore"):
            found, is_there = parts(shown, states.q, states.v, states.u, states.t, is_smooth=True)
        if not is_there.any():
            raise ValueError("result: none of its states is finite")
        self._found, self._axes = found, axes_of(shown, found)
        # The last state of a failed run can overflow; the one before stays.
        self._shape = (np.cumsum(is_there) - 1).clip(0)
        low, high = extent(found, self._axes)
        low, high = with_margin(low[:2], high[:2], FILM[0] / FILM[1], FILM[0] / FILM[1])
        self._plot, self._title = page(figure, low, high, self._axes)
        self._polygons: Any = None

    def show(self, i: int, title: str) -> None:
        if self._polygons is not None:
            self._polygons.remove()
        self._polygons = polygons(triangles(self._found, self._axes, [self._shape[i]]))
        self._plot.add_collection(self._polygons, autolim=False)
        self._title.set_text(title)


class _InPlane:
    """A figure of a mass on its line."""

    def __init__(self, shown: View, states: _States, figure: Any) -> None:
        self._drawn = _Drawn(shown, states.q, states.t, figure)

    def show(self, i: int, title: str) -> None:
        self._drawn.show(i)
        self._drawn.axes.set_title(title)
