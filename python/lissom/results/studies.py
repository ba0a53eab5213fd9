"""Equilibria and natural modes of scenes, and their folders on disk."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from .._lissom import (
    AccuracyWarning,
    ContinuationResult,
    EquilibriumPath,
    LissomError,
    Model,
    ModesResult,
    Scene,
    StaticsResult,
    __version__,
    check_model,
    inputs_by_name,
    modes,
    statics,
)
from ..common.arguments import number, vector
from ..common.interruption import interruption
from ..model.starts import rest_start
from ..model.views import View, drawn
from ..model.visuals import Visual
from .files import imported, write_report, write_summary
from .folders import MARK
from .runs import instants

if TYPE_CHECKING:
    from ..common.arguments import Inputs

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Setting:
    """A model at rest or in vibration, with its time and inputs."""

    model: Model
    #: Time in seconds, for loads that depend on time.
    t: float
    #: The inputs, shape (inputs,).
    u: Array
    #: Meshes that stand for links.
    visuals: Sequence[Visual] = ()

    @cached_property
    def view(self) -> View:
        """The view of the model, for drawings."""
        return drawn(self.model, self.visuals)


@dataclass(frozen=True)
class Slides:
    """A sequence of shapes of a model."""

    setting: Setting
    #: Parameter of each shape, shape (m,), increasing: time in seconds, or position in a sequence.
    t: Array
    #: Coordinates, shape (m, n).
    q: Array
    #: Text before and after a label.
    label: tuple[str, str] = ("t = ", " s")
    #: The shape that is shown first.
    opens_at: int = 0
    #: Load factors, shape (m,); 1 by default.
    factors: Array | None = None
    #: Inputs of each shape, shape (m, inputs); those of the setting by default.
    inputs: Array | None = None
    #: Labels, shape (m,); `t` by default.
    labels: Array | None = None
    #: Label and coordinates (n,) of the shape drawn dashed.
    outline: tuple[str, Array] | None = None

    @cached_property
    def v(self) -> Array:
        """Velocities, shape (m, n): zero."""
        return np.zeros_like(self.q)

    @cached_property
    def u(self) -> Array:
        """Inputs, shape (m, inputs)."""
        u = self.setting.u
        return np.broadcast_to(u, (len(self.q), len(u))) if self.inputs is None else self.inputs

    @cached_property
    def load_factor(self) -> Array:
        """Load factors, shape (m,)."""
        return np.ones(len(self.t)) if self.factors is None else self.factors

    @property
    def view(self) -> View:
        """The view of the model, for drawings."""
        return self.setting.view

    @cached_property
    def clock(self) -> Array:
        """Times at which the model is shown, seconds: one for all shapes."""
        return np.full(len(self.t), self.setting.t)

    def instants(self, most: int) -> NDArray[np.intp]:
        """Indices of at most ``most`` shapes, evenly spaced, first and last included."""
        return instants(len(self.t), most)


def setting_for(
    found: StaticsResult | ContinuationResult | ModesResult,
    model: Model,
    t: float | None = None,
    u: Inputs | None = None,
    visuals: Sequence[Visual] = (),
) -> Setting:
    """The model given for a result, validated, at the time and with the inputs of the result by default."""
    n = _coordinates(found)
    check_model(model, "model")
    if model.n != n:
        raise ValueError(f"model: it has {model.n} coordinates, the result has {n}")
    if t is None:
        # Results of older versions know neither time nor inputs.
        t = 0.0 if found.t is None else found.t
    number("t", t)
    if not np.isfinite(t):
        raise ValueError(f"t: got {t}, expected a finite number (seconds)")
    u0 = model.u0
    if u is not None:
        held = vector("u", inputs_by_name(u, [model]), len(u0))
    else:
        held = u0 if found.u is None else found.u
    if len(held) != len(u0):
        raise ValueError(f"model: it has {len(u0)} inputs, the result has {len(held)}")
    return Setting(model, float(t), held, visuals)


def _coordinates(found: StaticsResult | ContinuationResult | ModesResult) -> int:
    """Number of coordinates of a result."""
    if isinstance(found, ContinuationResult):
        return int(found.path.q.shape[1])
    return int(found.shapes.shape[0]) if isinstance(found, ModesResult) else len(found.q)


def outcome_of(found: StaticsResult) -> str:
    """The outcome of a search as one word, as for runs."""
    return "interrupted" if found.status == "interrupted" else "finished" if found.success else "failed"


def way(path: EquilibriumPath) -> Array:
    """Distance along a path of equilibria, shape (k,), increasing from 0 to 1 even if loads decrease.

    Each step counts by the change of the coordinates and of the load factor, both relative to their ranges.
    """
    q = path.q / (float(np.linalg.norm(np.ptp(path.q, axis=0))) or 1.0)
    factor = path.load_factor / (float(np.ptp(path.load_factor)) or 1.0)
    steps = np.linalg.norm(np.diff(np.column_stack([q, factor]), axis=0), axis=1)
    distance = np.concatenate([[0.0], np.cumsum(steps)])
    return distance / (distance[-1] or 1.0)


@dataclass(frozen=True)
class StaticsStudy:
    """The equilibrium of a scene."""

    #: Name of its data file.
    file: ClassVar[str] = "equilibrium.npz"

    scene: Scene
    found: StaticsResult
    #: Whether it was found by release from the scene's q0, not from the unloaded state.
    from_start: bool
    wall_time: float

    @property
    def numbers(self) -> dict[str, Any]:
        """The results as plain JSON data."""
        found = self.found
        path = found.path
        return {
            "scene": self.scene.name,
            MARK: __version__,
            "study": "statics",
            "outcome": outcome_of(found),
            "status": found.status,
            "message": found.message,
            "load_factor": found.load_factor,
            "stability": found.stability,
            "lowest_eigenvalue": found.lowest_eigenvalue if np.isfinite(found.lowest_eigenvalue) else None,
            "space_error": None if found.space_error is None else found.space_error.relative,
            "coordinates": self.scene.model.n,
            "inputs": None
            if found.u is None
            else dict(zip(self.scene.model.inputs, found.u.tolist(), strict=True)),
            "q": found.q.tolist(),
            "critical_points": [
                {"kind": point.kind, "load_factor": point.load_factor}
                for point in (path.critical_points if path else [])
            ],
            "newton_iterations": found.nit,
            "wall_seconds": self.wall_time,
        }

    def arrays(self) -> dict[str, Any]:
        """Contents of ``file``."""
        kept: dict[str, Any] = {"q": self.found.q, "scene": np.array(self.scene.text), **imported(self.scene)}
        if self.found.path is not None:
            kept |= {"path_load_factor": self.found.path.load_factor, "path_q": self.found.path.q}
        return kept


def _refined(found: ModesResult, kind: Callable[[Array], Any]) -> dict[str, Any]:
    """The frequencies with more modes of the rods, if they are known."""
    return {} if found.refined_frequency is None else {"refined_frequency": kind(found.refined_frequency)}


@dataclass(frozen=True)
class ModesStudy:
    """Natural modes of a scene about a shape."""

    #: Name of its data file.
    file: ClassVar[str] = "modes.npz"

    scene: Scene
    #: Result of the search for this shape; None if the shape is the scene's q0.
    statics: StaticsStudy | None
    q: Array
    found: ModesResult

    @property
    def numbers(self) -> dict[str, Any]:
        """The results as plain JSON data."""
        found = self.found
        return {
            "scene": self.scene.name,
            MARK: __version__,
            "study": "modes",
            "outcome": "finished",
            "equilibrium": None if self.statics is None else self.statics.found.stability,
            "coordinates": self.scene.model.n,
            "q": self.q.tolist(),
            "is_stable": found.is_stable,
            "message": found.message,
            "frequency": found.frequency.tolist(),
            **_refined(found, list),
            "damping_ratio": found.damping_ratio.tolist(),
            "eigenvalues": [[s.real, s.imag] for s in found.eigenvalues.tolist()],
        }

    def arrays(self) -> dict[str, Any]:
        """Contents of ``file``."""
        found = self.found
        return {
            "q": self.q,
            "frequency": found.frequency,
            **_refined(found, np.array),
            "damping_ratio": found.damping_ratio,
            "eigenvalues": found.eigenvalues,
            "shapes": found.shapes,
            "scene": np.array(self.scene.text),
            **imported(self.scene),
        }


def study_statics(
    scene: Scene, from_start: bool = False, stability: bool = True, u: Mapping[str, Any] | None = None
) -> StaticsStudy:
    """Find the equilibrium of a scene from the unloaded state or by release from its q0; judge its stability.

    Ctrl-C ends the search, not the program. The shape of closed loops depends on q0: a scene with loops and
    a q0 is released from it.
    """
    start = time.perf_counter()
    begin = scene.q0 if from_start else rest_start(scene)
    with warnings.catch_warnings():
        # The message of the result has it, too.
        warnings.simplefilter("ignore", AccuracyWarning)
        found = interruption.finish(
            partial(statics, scene.model, begin, t=scene.simulation.t0, stability=stability, u=u)
        )
    return StaticsStudy(scene, found, begin is not None, time.perf_counter() - start)


def study_modes(scene: Scene, rest: StaticsStudy | None, u: Mapping[str, Any] | None = None) -> ModesStudy:
    """Find the modes of a scene about its equilibrium with these inputs or about its q0.

    Raises LissomError if there are no modes, or no equilibrium.
    """
    if rest is not None and not rest.found.success:
        raise LissomError(rest.found.message)
    q = scene.q0 if rest is None else rest.found.q
    found = interruption.finish(partial(modes, scene.model, q, t=scene.simulation.t0, u=u))
    return ModesStudy(scene, rest, q, found)


def write(
    study: StaticsStudy | ModesStudy, folder: Path, report: Callable[[Any, Path], None] | None
) -> list[str]:
    """Write the files of a study into an empty folder; return the failures, like ``files.write``."""
    np.savez_compressed(folder / study.file, **study.arrays())
    write_summary(study.numbers, folder)
    return write_report(report, study, folder / "report.html")
