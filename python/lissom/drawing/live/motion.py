"""An interactive simulation: constant inputs, a pulled tip, single steps, and reset.

This module is independent of clocks, servers and drawing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._lissom import Energy, Input, LissomError, Load, Simulation
from ...model.views import drawn
from ...model.visuals import Visual
from .spring import Spring, spring

Array = NDArray[np.float64]

#: Maximum time in seconds for which inputs are constant, and for which the force of a pull is: the force is
#: updated with the tip's position after this time. A longer fixed step keeps them constant for one step.
HELD, HELD_WHILE_PULLED = 1 / 60, 1 / 500

#: Time constant in seconds with which the end of the pull's spring follows the hand, because hands jump.
FOLLOWING = 0.08

#: Methods with adaptive steps.
ADAPTIVE = ("rk45", "dop853", "radau")

#: Statuses of failed steps whose state is kept, although the motion cannot continue.
KEPT = ("unresolved", "inverted", "collapsed")


class Motion:
    """A motion that continues from the state of a simulation, which does not change."""

    def __init__(self, simulation: Simulation, visuals: Sequence[Visual] = ()) -> None:
        self.model = simulation.model
        self.view = drawn(self.model, visuals)
        self._start: dict[str, Any] = {"q0": simulation.q, "v0": simulation.v, "t0": simulation.t}
        # The data of a pickle: model, options, start and memory.
        kept: Any = simulation.__reduce__()
        options: dict[str, Any] = kept[1][1]
        #: Frames that can be pulled.
        self.tips = self.view.frames if self.view.with_loads is not None else ()
        pulls = [self._free_name(f"pull of {tip.name}") for tip in self.tips]
        pulled = self.model
        if self.view.with_loads is not None:
            pulled = self.view.with_loads(
                [
                    Load(force=Input(name, (0.0, 0.0, 0.0)), link=tip.link)
                    for name, tip in zip(pulls, self.tips, strict=True)
                ]
            )
        self._simulation = Simulation(pulled, **self._start, **options)
        places = {name: i for i, name in enumerate(pulled.inputs)}
        self._own = [places[name] for name in self.model.inputs]
        self._pulls = [[places[f"{name}.{axis}"] for axis in "xyz"] for name in pulls]
        self._u = pulled.u0
        self._u[self._own] = simulation.u
        adapts = options.get("adaptive", False) or options["method"] in ADAPTIVE
        self._dt = None if adapts else float(options["dt"])
        #: Index of the pulled tip, and position of the spring's end; None without a pull.
        self.pulled: tuple[int, Array] | None = None
        #: Target position of the spring's end.
        self._target = np.zeros(3)
        self._spring = Spring(0.0, 0.0)
        #: Strength of the pull's spring, relative to the default for the model.
        self.strength = 1.0
        self._trouble = ""
        #: Reason why the last pull was released, unless the user released it.
        self.release_reason = ""

    def _free_name(self, name: str) -> str:
        """A name that differs from all inputs of the model."""
        own = {known.rpartition(".")[0] or known for known in self.model.inputs} | set(self.model.inputs)
        while name in own:
            name += "'"
        return name

    @property
    def t(self) -> float:
        """Time, seconds."""
        return self._simulation.t

    @property
    def q(self) -> Array:
        """Coordinates (n,)."""
        return self._simulation.q

    @property
    def v(self) -> Array:
        """Velocities (n,)."""
        return self._simulation.v

    @property
    def u(self) -> Array:
        """Current inputs of the model, (inputs,)."""
        return self._u[self._own]

    @property
    def energy(self) -> Energy:
        """Energies of the model, without those of the pull."""
        return self.model.energy(self.q, self.v, t=self.t, u=self.u)

    @property
    def trouble(self) -> str:
        """Why the motion cannot continue; empty if it can."""
        return self._trouble

    @property
    def chunk(self) -> float:
        """Duration by which the motion is advanced at once, seconds."""
        held = HELD if self.pulled is None else HELD_WHILE_PULLED
        return held if self._dt is None else self._dt * max(1, round(held / self._dt))

    @property
    def step_size(self) -> float:
        """Duration of a single step in seconds: that of the method if it is fixed."""
        return self._dt or HELD

    @property
    def force(self) -> Array:
        """Force (3,) of the pull in world axes, newtons."""
        if self.pulled is None:
            return np.zeros(3)
        number, target = self.pulled
        tip = self.tips[number]
        velocity = tip.jacobian(self.q, self.t)[3:] @ self.v
        if tip.carried is not None:
            velocity = velocity + tip.carried(self.q, self.t)[3:]
        pull = self._spring.stiffness * (target - self.place(number)) - self._spring.damping * velocity
        return np.asarray(self.strength * pull)

    def place(self, number: int) -> Array:
        """Position of a tip (3,), metres."""
        return np.asarray(self.tips[number].pose(self.q, self.t))[:3, 3]

    def set(self, name: str, value: float) -> None:
        """Set an input to a constant value."""
        self._u[self._own[self.model.inputs.index(name)]] = value

    def pull(self, number: int, target: Array) -> None:
        """Pull a tip with a spring towards a position (3,), metres.

        The spring is chosen for the shape at the start of the pull. The pull is released if the method cannot
        follow it.
        """
        self._target = np.array(target, float)
        if self.pulled is None or self.pulled[0] != number:
            self.pulled, self.release_reason = (number, self.place(number)), ""
            tip, held = self.tips[number], self.chunk
            self._spring = spring(self.model, tip, self.q, self.t, self.u, held)

    def release(self) -> None:
        """Release the tip."""
        self.pulled = None

    def advance(self, duration: float | None = None) -> bool:
        """Advance by a duration, by default `chunk`; False if the motion failed."""
        duration = duration or self.chunk
        self._trouble = self._step(duration)
        if self._trouble and self.pulled is not None and self._simulation.status not in KEPT:
            self.release_reason = self._trouble
            self.release()
            self._trouble = self._step(duration)
        return not self._trouble

    def _step(self, duration: float) -> str:
        """Make a step; return the reason of a failure, or an empty text."""
        for places in self._pulls:
            self._u[places] = 0.0
        try:
            if self.pulled is not None:
                number, end = self.pulled
                end = end + (1.0 - np.exp(-duration / FOLLOWING)) * (self._target - end)
                self.pulled = (number, end)
                self._u[self._pulls[number]] = self.force
            self._simulation.step(self._u, duration)
        except Exception as error:
            # Overflow of the state, or an exception of a function of time in the model.
            known = isinstance(error, ValueError | LissomError)
            return str(error) if known else f"{type(error).__name__}: {error}"
        return "" if self._simulation.success else self._simulation.message

    def reset(self) -> None:
        """Return to the initial state; inputs keep their current values."""
        self.release()
        self._trouble = self.release_reason = ""
        self._simulation.reset(**self._start)
