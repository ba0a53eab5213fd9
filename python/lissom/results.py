"""Results of a scene: the run with its numbers, and the files that keep them."""

from __future__ import annotations

import importlib.util
import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ._lissom import Balance, LissomError, MotionResult, Scene, __version__
from .folders import MARK, SUMMARY
from .views import Link, View, view

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]

#: What messages of the solvers call options of ``simulate`` that have other names in a scene.
SCENE_KEYS = {"dt": "step", "jac": "jacobian", "t_eval": "output.step"}

#: Advice of the solvers that a scene cannot follow.
NOT_FOR_SCENES = ", or give the accelerations (`a0` of `newmark`)"

#: What is said of a run whose energies are not finite.
NO_ENERGIES = "Its energy balance is not finite: energies overflow or are NaN."

#: Most instants at which the centre line is kept: more than a screen can show or an eye can see.
MAX_SHAPES = 2000

#: Modules that write NetCDF.
FILES = ("xarray", "h5netcdf", "h5py")

#: Counters of the solvers, by their names in ``MotionResult.stats``, in the order in which they are shown.
COUNTERS = {
    "steps": "steps",
    "rejected": "rejected steps",
    "newton_iterations": "Newton iterations",
    "nfev": "evaluations",
    "nfev_jac": "evaluations for difference Jacobians",
    "njev": "Jacobians",
    "nlu": "factorisations",
}


@dataclass(frozen=True)
class Run:
    """A scene that was simulated: to its end, or as far as it came."""

    scene: Scene
    #: Times, states, statistics.
    motion: MotionResult
    #: True when somebody stopped it.
    interrupted: bool = False
    #: What stands around the times of an animation.
    label: ClassVar[tuple[str, str]] = ("t = ", " s")

    @cached_property
    def t(self) -> Array:
        """Times in seconds, shape (m,). A run that failed at once has its initial state, so that m > 0."""
        return self.motion.t if self._has_states else np.array([self.scene.simulation.t0])

    @cached_property
    def q(self) -> Array:
        """Coordinates, shape (m, n)."""
        return self.motion.q if self._has_states else self.scene.q0[None]

    @cached_property
    def v(self) -> Array:
        """Velocities, shape (m, n)."""
        return self.motion.v if self._has_states else self.scene.v0[None]

    @cached_property
    def a(self) -> Array:
        """Accelerations, shape (m, n); NaN where none could be found."""
        return self.motion.a if self._has_states else np.full_like(self.q, np.nan)

    @property
    def clock(self) -> Array:
        """Times at which the model is drawn, seconds, shape (m,)."""
        return self.t

    @property
    def message(self) -> str:
        """How it ended, in the words of a scene."""
        return in_words_of_a_scene(self.motion.message)

    @property
    def has_energies(self) -> bool:
        """False where energies that the scene asked for are not finite."""
        return "energy" not in self.wants or bool(np.isfinite(self.balance.drift))

    @property
    def _has_states(self) -> bool:
        return len(self.motion.t) > 0

    @cached_property
    def balance(self) -> Balance:
        """Energy balance at the times kept."""
        if self._has_states and self.motion.balance is not None:
            return self.motion.balance
        try:
            energy = self.scene.model.energy(self.scene.q0, self.scene.v0, t=self.scene.simulation.t0)
        except LissomError:  # the start is beyond all numbers
            unknown = [math.nan]
            return Balance(
                kinetic=unknown,
                elastic=unknown,
                gravitational=unknown,
                loads=unknown,
                dissipated=unknown,
                work=unknown,
            )
        return Balance(
            kinetic=[energy.kinetic],
            elastic=[energy.elastic],
            gravitational=[energy.gravitational],
            loads=[energy.loads],
            dissipated=[0.0],
            work=[0.0],
        )

    @cached_property
    def view(self) -> View:
        """What there is of the model to be kept and drawn."""
        return view(self.scene.model)

    @property
    def wants(self) -> frozenset[str]:
        """The quantities that the scene asked to keep."""
        return frozenset(self.scene.simulation.quantities)

    def instants(self, most: int) -> NDArray[np.intp]:
        """Indices of at most so many times, evenly spread, first and last included."""
        return instants(len(self.t), most)


def in_words_of_a_scene(message: str) -> str:
    """A message of a solver without names of options that a scene does not have."""
    advice = message.replace(NOT_FOR_SCENES, "")
    return re.sub(r"`(\w+)`", lambda name: f"`{SCENE_KEYS.get(name[1], name[1])}`", advice)


def instants(count: int, most: int) -> NDArray[np.intp]:
    """At most ``most`` of ``count`` indices, evenly spread, first and last included."""
    return np.unique(np.linspace(0, count - 1, min(most, count)).round().astype(np.intp))


def statistics(run: Run) -> dict[str, Any]:
    """The run in numbers, as plain JSON."""
    settings = run.scene.simulation
    simulated = float(run.t[-1] - run.t[0])
    stats = run.motion.stats
    wall_time = stats.wall_time
    counters = {name: getattr(stats, name) for name in COUNTERS}
    with_energy = "energy" in run.wants
    return {
        "scene": run.scene.name,
        MARK: __version__,
        "outcome": "interrupted" if run.interrupted else "finished" if run.motion.success else "failed",
        "message": run.message if run.has_energies else f"{run.message} {NO_ENERGIES}",
        "method": settings.method,
        "coordinates": run.scene.model.n,
        "simulated_seconds": simulated,
        "wall_seconds": wall_time,
        "times_real_time": simulated / wall_time if wall_time > 0.0 else None,
        "time_error": stats.time_error,
        "space_error": stats.space_error,
        "energy_drift": run.balance.drift if with_energy and run.has_energies else None,
        "energy_moved_joules": run.balance.scale if with_energy and run.has_energies else None,
        "counters": counters,
    }


def dataset(run: Run) -> xarray.Dataset:
    """The trajectory with dimensions, units and the scene, as an xarray.Dataset."""
    import xarray

    wants, coordinates = run.wants, run.view.coordinates
    names = [coordinate.name for coordinate in coordinates]
    units = [coordinate.unit for coordinate in coordinates]
    data = xarray.Dataset(
        coords={
            "time": ("time", run.t, {"units": "s", "long_name": "time"}),
            "coordinate": ("coordinate", names, {"long_name": "generalised coordinate"}),
            "unit": ("coordinate", units, {"long_name": "unit of the coordinate"}),
        },
        attrs={
            # HDF5 has no text with NUL in it.
            "title": run.scene.name.replace("\0", "\N{REPLACEMENT CHARACTER}"),
            "source": f"lissom {__version__}",
            "scene": run.scene.text,
            "statistics": json.dumps(plain(statistics(run))),
        },
    )
    per_state = ("time", "coordinate")
    data["q"] = (per_state, run.q, {"long_name": "generalised coordinates", "units": "see unit"})
    if "velocity" in wants:
        data["v"] = (per_state, run.v, {"long_name": "generalised velocities", "units": "see unit, per s"})
    if "acceleration" in wants:
        data["a"] = (
            per_state,
            run.a,
            {"long_name": "generalised accelerations", "units": "see unit, per s2"},
        )
    if "energy" in wants:
        for name, values in energies(run.balance).items():
            data[f"energy_{name}"] = ("time", values, {"long_name": f"energy: {name}", "units": "J"})
    for shape in shapes(run):
        X = f"X{shape.suffix}"
        arc_length = {"units": "m", "long_name": "arc length of the unstretched rod"}
        data = data.assign_coords(
            {
                "shape_time": ("shape_time", run.t[shape.at], {"units": "s", "long_name": "time of a shape"}),
                X: (X, shape.link.stations, arc_length),
                "axis": ("axis", ["x", "y", "z"]),
            }
        )
        attributes = {"units": "m", "long_name": "position of the centre line in the world"}
        data[f"position{shape.suffix}"] = (("shape_time", X, "axis"), shape.positions, attributes)
    return data


def energies(parts: Balance) -> dict[str, Array]:
    """The balance by name, in the order of all tables and figures."""
    named = {
        "kinetic": parts.kinetic,
        "elastic": parts.elastic,
        "gravitational": parts.gravitational,
        "loads": parts.loads,
        "dissipated": parts.dissipated,
        "work": parts.work,
        "total": parts.total,
    }
    return named


@dataclass(frozen=True)
class Shapes:
    """A link at some of the times that are kept."""

    link: Link
    #: What follows the names of its variables; nothing where there is one link only.
    suffix: str
    #: Indices of the times.
    at: NDArray[np.intp]
    #: Of the centre line, (times, sections, 3), metres.
    positions: Array


def shapes(run: Run) -> list[Shapes]:
    """The links of a model in motion; none where the scene does not ask for them."""
    if "shape" not in run.wants:
        return []
    at, links = run.instants(MAX_SHAPES), run.view.links
    return [
        Shapes(
            link,
            f"_{link.name}" if len(links) > 1 else "",
            at,
            link.pose(run.q[at], link.stations, run.t[at])[..., :3, 3],
        )
        for link in links
    ]


def missing(*modules: str) -> list[str]:
    """Those of the modules that cannot be imported."""
    return [module for module in modules if importlib.util.find_spec(module) is None]


def write_trajectory(run: Run, folder: Path) -> str:
    """Write ``trajectory.nc``, or ``trajectory.npz`` where the extra ``files`` fails; why it does, in words.

    The file is made in memory: HDF5 that cannot write to its own file ends the process.
    """
    failure = ""
    try:
        content = None if missing(*FILES) else dataset(run).to_netcdf(engine="h5netcdf")
    except Exception as error:
        content, failure = None, in_words(error)
    if content is not None:
        (folder / "trajectory.nc").write_bytes(content)
        return ""
    np.savez_compressed(folder / "trajectory.npz", **arrays(run))
    return failure


def arrays(run: Run) -> dict[str, Any]:
    """The trajectory by the names that ``trajectory.npz`` has."""
    found: dict[str, Any] = {
        "t": run.t,
        "q": run.q,
        "coordinates": np.array([coordinate.name for coordinate in run.view.coordinates]),
        "units": np.array([coordinate.unit for coordinate in run.view.coordinates]),
        "scene": np.array(run.scene.text),
        "statistics": np.array(json.dumps(plain(statistics(run)))),
    }
    if "velocity" in run.wants:
        found["v"] = run.v
    if "acceleration" in run.wants:
        found["a"] = run.a
    if "energy" in run.wants:
        found |= {f"energy_{name}": values for name, values in energies(run.balance).items()}
    for shape in shapes(run):
        found["shape_time"] = run.t[shape.at]
        found[f"X{shape.suffix}"], found[f"position{shape.suffix}"] = shape.link.stations, shape.positions
    return found


def write_summary(numbers: dict[str, Any], folder: Path) -> None:
    """Write ``summary.json``, by which lissom recognises its own folders."""
    text = json.dumps(plain(numbers), indent=2, allow_nan=False) + "\n"
    (folder / SUMMARY).write_text(text, encoding="utf-8")


def plain(value: Any) -> Any:
    """The same in what JSON knows: numbers that are not finite become null."""
    if isinstance(value, dict):
        return {key: plain(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [plain(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def in_words(error: Exception) -> str:
    """An error of somebody else's code on one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())


def write_report(report: Callable[[Any, Path], None] | None, subject: Any, path: Path) -> list[str]:
    """Write a report, if there is to be one. Its failure costs nothing else: why it failed, if it did."""
    if report is None:
        return []
    try:
        report(subject, path)
    except Exception as error:
        path.unlink(missing_ok=True)
        return [f"The report could not be written: {in_words(error)}"]
    return []


def write(run: Run, folder: Path, report: Callable[[Run, Path], None] | None) -> list[str]:
    """Write the files of a run, what was computed before what can be made from it.

    Parameters
    ----------
    run : Run
        What was simulated.
    folder : Path
        An empty folder.
    report : callable or None
        Writes the report of the run to a file.

    Returns
    -------
    failures : list of str
        What is missing or other than it should be, and why.
    """
    failure = write_trajectory(run, folder)
    write_summary(statistics(run), folder)
    failures = [f"trajectory.nc could not be written, trajectory.npz was: {failure}"] if failure else []
    return failures + write_report(report, run, folder / "report.html")
