"""Results of a scene: the run with its numbers, and the files that keep them."""

from __future__ import annotations

import importlib.util
import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._lissom import Balance, LissomError, MotionResult, Rod, Scene, __version__
from .folders import MARK, SUMMARY

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]

#: What messages of the solvers call options of ``simulate`` that scenes have in another form.
SCENE_KEYS = {"t_eval": "output.dt"}

#: Advice of the solvers that a scene cannot follow.
NOT_FOR_SCENES = ", or give the accelerations (`a0` of `newmark`)"

#: What is said of a run whose energies are not finite.
NO_ENERGIES = "Its energy balance is not finite: energies overflow or are NaN."

#: Most instants at which the centre line is kept: more than a screen can show or an eye can see.
MAX_SHAPES = 2000

#: Sections along each segment at which the centre line is kept.
SECTIONS_PER_SEGMENT = 24

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

#: Units of the generalised coordinates: strains of bending and torsion are curvatures, the others are ratios.
STRAIN_UNITS = {
    "torsion": "rad/m",
    "bend_y": "rad/m",
    "bend_z": "rad/m",
    "stretch": "1",
    "shear_y": "1",
    "shear_z": "1",
}


@dataclass(frozen=True)
class Coordinate:
    """What one generalised coordinate is."""

    name: str
    unit: str
    #: Strain component ("bend_y", ...) or, for a pendulum, the name again.
    kind: str
    #: Segment and degree of the mode; zero for a pendulum.
    segment: int = 0
    degree: int = 0


@dataclass(frozen=True)
class Run:
    """A scene that was simulated: to its end, or as far as it came."""

    scene: Scene
    #: Times, states, statistics.
    motion: MotionResult
    #: True when somebody stopped it.
    interrupted: bool = False

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
    def coordinates(self) -> list[Coordinate]:
        """What the generalised coordinates are."""
        model = self.scene.model
        if not isinstance(model, Rod):
            return [Coordinate("angle", "rad", "angle"), Coordinate("elongation", "m", "elongation")]
        return [
            Coordinate(f"segment{i}.{strain}.{degree}", STRAIN_UNITS[strain], strain, i, degree)
            for i, segment in enumerate(model.segments)
            for strain in STRAIN_UNITS
            for degree in range(segment.modes.get(strain, 0))
        ]

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


def sections(rod: Rod) -> Array:
    """Arc lengths at which the centre line is kept, shape (s,), metres."""
    ends = np.concatenate([[0.0], np.cumsum([segment.length for segment in rod.segments])])
    inner = [np.linspace(a, b, SECTIONS_PER_SEGMENT, endpoint=False) for a, b in pairwise(ends)]
    # The sum of the lengths may differ from the rod's length by rounding.
    return np.append(np.concatenate(inner), rod.length)


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

    model, wants = run.scene.model, run.wants
    names = [coordinate.name for coordinate in run.coordinates]
    units = [coordinate.unit for coordinate in run.coordinates]
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
    if "shape" in wants and isinstance(model, Rod):
        at, positions = shapes(run, model)
        data = data.assign_coords(
            shape_time=("shape_time", run.t[at], {"units": "s", "long_name": "time of a shape"}),
            X=("X", sections(model), {"units": "m", "long_name": "arc length of the unstretched rod"}),
            axis=("axis", ["x", "y", "z"]),
        )
        attributes = {"units": "m", "long_name": "position of the centre line in the world"}
        data["position"] = (("shape_time", "X", "axis"), positions, attributes)
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


def shapes(run: Run, rod: Rod) -> tuple[NDArray[np.intp], Array]:
    """Indices of the times at which the centre line is kept; its positions (times, sections, 3) in metres."""
    at = run.instants(MAX_SHAPES)
    stations = sections(rod)
    return at, rod.pose(run.q[at], stations, t=run.t[at])[..., :3, 3]


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
        "coordinates": np.array([coordinate.name for coordinate in run.coordinates]),
        "units": np.array([coordinate.unit for coordinate in run.coordinates]),
        "scene": np.array(run.scene.text),
        "statistics": np.array(json.dumps(plain(statistics(run)))),
    }
    if "velocity" in run.wants:
        found["v"] = run.v
    if "acceleration" in run.wants:
        found["a"] = run.a
    if "energy" in run.wants:
        found |= {f"energy_{name}": values for name, values in energies(run.balance).items()}
    if "shape" in run.wants and isinstance(run.scene.model, Rod):
        at, found["position"] = shapes(run, run.scene.model)
        found["shape_time"], found["X"] = run.t[at], sections(run.scene.model)
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
