"""Equilibria and natural modes of scenes, and their folders on disk."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ._lissom import LissomError, ModesResult, Scene, StaticsResult, __version__, modes, statics
from .files import imported, write_report, write_summary
from .folders import MARK
from .interruption import interruption
from .results import instants
from .starts import rest_start
from .views import View, view

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Slides:
    """Shapes of a scene's model to be shown one after the other."""

    scene: Scene
    #: What the shapes are labelled by, shape (m,): times in seconds, or load factors.
    t: Array
    #: Coordinates, shape (m, n).
    q: Array
    #: What stands around a label.
    label: tuple[str, str] = ("t = ", " s")
    #: The shape that is shown first.
    opens_at: int = 0
    #: How much of the loads acts, shape (m,); all of them by default.
    factors: Array | None = None

    @cached_property
    def v(self) -> Array:
        """Velocities, shape (m, n): none."""
        return np.zeros_like(self.q)

    @cached_property
    def u(self) -> Array:
        """Inputs, shape (m, inputs): as they are by themselves."""
        u0 = self.scene.model.u0
        return np.broadcast_to(u0, (len(self.q), len(u0)))

    @cached_property
    def load_factor(self) -> Array:
        """How much of the loads acts, shape (m,)."""
        return np.ones(len(self.t)) if self.factors is None else self.factors

    @cached_property
    def view(self) -> View:
        """What there is of the model to be drawn."""
        return view(self.scene.model)

    @cached_property
    def clock(self) -> Array:
        """Times at which the model is shown, seconds: the scene's first, for all shapes."""
        return np.full(len(self.t), self.scene.simulation.t0)

    def instants(self, most: int) -> NDArray[np.intp]:
        """Indices of at most so many shapes, evenly spread, first and last included."""
        return instants(len(self.t), most)


@dataclass(frozen=True)
class StaticsStudy:
    """A scene at rest."""

    #: Name of the file that keeps it.
    file: ClassVar[str] = "equilibrium.npz"

    scene: Scene
    found: StaticsResult
    #: Whether it was let go from the scene's q0, not from the unloaded state.
    from_start: bool
    wall_time: float

    @property
    def numbers(self) -> dict[str, Any]:
        """What was found, as plain JSON."""
        found = self.found
        path = found.path
        return {
            "scene": self.scene.name,
            MARK: __version__,
            "study": "statics",
            "outcome": "finished" if found.success else "failed",
            "status": found.status,
            "message": found.message,
            "load_factor": found.load_factor,
            "stability": found.stability,
            "lowest_eigenvalue": found.lowest_eigenvalue if np.isfinite(found.lowest_eigenvalue) else None,
            "coordinates": self.scene.model.n,
            "q": found.q.tolist(),
            "critical_points": [
                {"kind": point.kind, "load_factor": point.load_factor}
                for point in (path.critical_points if path else [])
            ],
            "newton_iterations": found.nit,
            "wall_seconds": self.wall_time,
        }

    def arrays(self) -> dict[str, Any]:
        """What ``file`` keeps."""
        kept: dict[str, Any] = {"q": self.found.q, "scene": np.array(self.scene.text), **imported(self.scene)}
        if self.found.path is not None:
            kept |= {"path_load_factor": self.found.path.load_factor, "path_q": self.found.path.q}
        return kept


@dataclass(frozen=True)
class ModesStudy:
    """Natural modes of a scene about a shape."""

    #: Name of the file that keeps them.
    file: ClassVar[str] = "modes.npz"

    scene: Scene
    #: How that shape was found; None where it is the scene's q0.
    statics: StaticsStudy | None
    q: Array
    found: ModesResult

    @property
    def numbers(self) -> dict[str, Any]:
        """What was found, as plain JSON."""
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
            "frequency": found.frequency.tolist(),
            "damping_ratio": found.damping_ratio.tolist(),
            "eigenvalues": [[s.real, s.imag] for s in found.eigenvalues.tolist()],
        }

    def arrays(self) -> dict[str, Any]:
        """What ``file`` keeps."""
        found = self.found
        return {
            "q": self.q,
            "frequency": found.frequency,
            "damping_ratio": found.damping_ratio,
            "eigenvalues": found.eigenvalues,
            "shapes": found.shapes,
            "scene": np.array(self.scene.text),
            **imported(self.scene),
        }


def study_statics(scene: Scene, from_start: bool = False) -> StaticsStudy:
    """The equilibrium of a scene: from the unloaded state, or let go from its q0.

    Which shape closed loops have depends on the q0: where there is one they are let go from it.
    """
    start = time.perf_counter()
    begin = scene.q0 if from_start else rest_start(scene)
    (found,) = interruption.collect(map(partial(statics, t=scene.simulation.t0), [scene.model], [begin]))
    return StaticsStudy(scene, found, begin is not None, time.perf_counter() - start)


def study_modes(scene: Scene, rest: StaticsStudy | None) -> ModesStudy:
    """The modes of a scene about its equilibrium, or about its q0 as it is.

    Raises LissomError where there are none, or no equilibrium.
    """
    if rest is not None and not rest.found.success:
        raise LissomError(rest.found.message)
    q = scene.q0 if rest is None else rest.found.q
    (found,) = interruption.collect(map(partial(modes, t=scene.simulation.t0), [scene.model], [q]))
    return ModesStudy(scene, rest, q, found)


def write(
    study: StaticsStudy | ModesStudy, folder: Path, report: Callable[[Any, Path], None] | None
) -> list[str]:
    """Write the files of a study into an empty folder; what could not be written, like ``files.write``."""
    np.savez_compressed(folder / study.file, **study.arrays())
    write_summary(study.numbers, folder)
    return write_report(report, study, folder / "report.html")
