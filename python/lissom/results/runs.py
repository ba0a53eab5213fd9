"""The result of a scene: a run and its statistics."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from .._lissom import Balance, LissomError, Model, MotionResult, Scene, __version__
from ..model.views import Link, View, drawn
from ..model.visuals import Visual
from .folders import MARK

Array = NDArray[np.float64]

#: Options of ``simulate`` named in messages of the solvers, and the corresponding keys of scenes.
SCENE_KEYS = {"t_eval": "output.dt"}

#: Advice of the solvers that does not apply to scenes.
NOT_FOR_SCENES = ", or give the accelerations (`a0` of `newmark`)"

#: Message for runs whose energies are not finite.
NO_ENERGIES = "Its energy balance is not finite: energies overflow or are NaN."

#: Maximum number of times at which the centre line is stored: more than the eye can distinguish.
MAX_SHAPES = 2000

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
    """A simulated scene, complete or up to a failure or interruption."""

    scene: Scene
    #: Times, states, statistics.
    motion: MotionResult
    #: Whether the user stopped it.
    interrupted: bool = False
    #: Meshes that stand for links.
    visuals: Sequence[Visual] = ()
    #: Text before and after the times of an animation.
    label: ClassVar[tuple[str, str]] = ("t = ", " s")
    #: Labels of an animation: its times.
    labels: ClassVar[None] = None
    #: The state at which an animation opens.
    opens_at: ClassVar[int] = 0

    @cached_property
    def t(self) -> Array:
        """Times in seconds, shape (m,), m > 0: a run that failed immediately has its initial state."""
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
        """Accelerations, shape (m, n); NaN if none could be found."""
        return self.motion.a if self._has_states else np.full_like(self.q, np.nan)

    @cached_property
    def u(self) -> Array:
        """Inputs from these times on, shape (m, inputs)."""
        return self.motion.u if self._has_states else self.scene.model.u0[None]

    @property
    def clock(self) -> Array:
        """Times at which the model is drawn, seconds, shape (m,)."""
        return self.t

    @property
    def load_factor(self) -> Array:
        """Load factors, shape (m,): always 1."""
        return np.ones(len(self.t))

    @property
    def outline(self) -> tuple[str, Array]:
        """Label and coordinates (n,) of the shape drawn dashed."""
        return "initial shape", self.q[0]

    @property
    def message(self) -> str:
        """The message of the run, in terms of scene keys."""
        return in_words_of_a_scene(self.motion.message)

    @cached_property
    def advice(self) -> list[str]:
        """Advice on the step, modes, method and units of the scene, after its run; often empty."""
        from ..analysis.advice import advice

        return advice(self.scene, self.motion.doubt)

    @property
    def has_energies(self) -> bool:
        """False if energies that the scene requests are not finite."""
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
        except LissomError:  # the initial state overflows
            beyond = [math.inf]
            return Balance(
                kinetic=beyond,
                elastic=beyond,
                gravitational=beyond,
                loads=beyond,
                dissipated=beyond,
                work=beyond,
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
        """The view of the model, for files and drawings."""
        return drawn(self.scene.model, self.visuals)

    @property
    def wants(self) -> frozenset[str]:
        """The quantities that the scene requests."""
        return frozenset(self.scene.simulation.quantities)

    def instants(self, most: int) -> NDArray[np.intp]:
        """Indices of at most `most` times, evenly spaced, first and last included."""
        return instants(len(self.t), most)


@dataclass(frozen=True)
class Made:
    """A motion of a model created in Python, for reports."""

    motion: MotionResult
    model: Model
    #: Meshes that stand for links.
    visuals: Sequence[Visual] = ()
    label: ClassVar[tuple[str, str]] = Run.label
    labels: ClassVar[None] = None
    opens_at: ClassVar[int] = Run.opens_at
    wants: ClassVar[frozenset[str]] = frozenset({"energy"})

    @property
    def t(self) -> Array:
        """Times in seconds, shape (m,)."""
        return self.motion.t

    @property
    def q(self) -> Array:
        """Coordinates, shape (m, n)."""
        return self.motion.q

    @property
    def v(self) -> Array:
        """Velocities, shape (m, n)."""
        return self.motion.v

    @property
    def a(self) -> Array:
        """Accelerations, shape (m, n)."""
        return self.motion.a

    @property
    def u(self) -> Array:
        """Inputs from these times on, shape (m, inputs)."""
        return self.motion.u

    @property
    def clock(self) -> Array:
        """Times at which the model is drawn, seconds, shape (m,)."""
        return self.t

    @property
    def load_factor(self) -> Array:
        """Load factors, shape (m,): always 1."""
        return np.ones(len(self.t))

    @property
    def outline(self) -> tuple[str, Array]:
        """Label and coordinates (n,) of the shape drawn dashed."""
        return "initial shape", self.q[0]

    @cached_property
    def view(self) -> View:
        """The view of the model, for drawings."""
        return drawn(self.model, self.visuals)

    @cached_property
    def balance(self) -> Balance:
        """Energy balance at the times kept."""
        assert self.motion.balance is not None, "a model was simulated"
        return self.motion.balance

    @property
    def has_energies(self) -> bool:
        """Whether all energies are finite."""
        return bool(np.isfinite(self.balance.drift))

    def instants(self, most: int) -> NDArray[np.intp]:
        """Indices of at most `most` times, evenly spaced, first and last included."""
        return instants(len(self.t), most)


#: Parts of a model by their numbers, whose tables in scenes have names in the singular.
PARTS = re.compile(r"\b(contact|link|load|loop|magnet|segment|support)s\[")


def in_words_of_a_scene(message: str) -> str:
    """A message of a solver with scene keys in place of the options of ``simulate``."""
    advice = re.sub(PARTS, r"\1[", message.replace(NOT_FOR_SCENES, ""))
    return re.sub(r"`(\w+)`", lambda name: f"`{SCENE_KEYS.get(name[1], name[1])}`", advice)


def instants(count: int, most: int) -> NDArray[np.intp]:
    """At most ``most`` of ``count`` indices, evenly spaced, first and last included."""
    # At least one apart, so that none occurs twice.
    return np.linspace(0, count - 1, min(most, count)).round().astype(np.intp)


def statistics(run: Run) -> dict[str, Any]:
    """Summary of the run as plain JSON data."""
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


def energies(parts: Balance) -> dict[str, Array]:
    """The energy balance by name, in the order used in tables and figures."""
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
    """A link at some of the stored times."""

    link: Link
    #: Suffix of the names of its variables; empty if there is only one link.
    suffix: str
    #: Indices of the times.
    at: NDArray[np.intp]
    #: Positions of the centre line, (times, sections, 3), metres.
    positions: Array


def shapes(run: Run) -> list[Shapes]:
    """The links of a model in motion; empty if the scene does not request them."""
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
