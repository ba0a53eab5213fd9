"""An interactive simulation: constant inputs, a pulled tip, single steps, and reset.

This module is independent of clocks, servers and drawing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._lissom import Energy, Input, LissomError, Load, Simulation
from ..views import view
from .spring import Spring, spring

Array = NDArray[np.float64]

#: Seconds for which inputs are held at most, and for which the force of a pull is: it follows the tip from
#: one such time to the next. Fixed steps that are longer hold them for a step.
HELD, HELD_WHILE_PULLED = 1 / 60, 1 / 500

#: Seconds in which the spring of a pull comes nearer to where it is held, by a factor e: hands jump.
FOLLOWING = 0.08

#: Methods that choose their steps.
ADAPTIVE = ("rk45", "dop853", "radau")

#: Statuses of steps that are kept, though the motion cannot go on from there.
KEPT = ("unresolved", "inverted", "collapsed")


class Motion:
    """A motion that continues from the state of a simulation, which does not change."""

    def __init__(self, simulation: Simulation) -> None:
        self.model = simulation.model
        self.view = view(self.model)
        self._start: dict[str, Any] = {"q0": simulation.q, "v0": simulation.v, "t0": simulation.t}
        # What a pickle keeps: model, options, start and memory.
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
        #: The number of the tip that is pulled, and where the spring ends; None while nobody pulls.
        self.pulled: tuple[int, Array] | None = None
        #: Where it is held.
        self._target = np.zeros(3)
        self._spring = Spring(0.0, 0.0)
        #: How strong the spring of a pull is, relative to the one that suits the model.
        self.strength = 1.0
        self._trouble = ""
        #: Why the last pull was let go, if that was not the hand's will.
        self.let_go = ""

    def _free_name(self, name: str) -> str:
        """A name that no input of the model has."""
        own = {known.rpartition(".")[0] or known for known in self.model.inputs} | set(self.model.inputs)
        while name in own:
            name += "'"
        return name

    @property
    def t(self) -> float:
        """Seconds."""
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
        """Energies of the model, without the pull."""
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
        """Duration of a single step, seconds: that of the method if it is fixed."""
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
        """Where a tip is (3,), metres."""
        return np.asarray(self.tips[number].pose(self.q, self.t))[:3, 3]

    def set(self, name: str, value: float) -> None:
        """Hold an input at a value from now on."""
        self._u[self._own[self.model.inputs.index(name)]] = value

    def pull(self, number: int, target: Array) -> None:
        """Pull a tip by a spring to a place (3,), metres.

        The spring suits the shape in which the pull begins. One that the method cannot follow is let go.
        """
        self._target = np.array(target, float)
        if self.pulled is None or self.pulled[0] != number:
            self.pulled, self.let_go = (number, self.place(number)), ""
            tip, held = self.tips[number], self.chunk
            self._spring = spring(self.model, tip, self.q, self.t, self.u, held)

    def release(self) -> None:
        """Release the tip."""
        self.pulled = None

    def advance(self, duration: float | None = None) -> bool:
        """Advance by a duration, by default `chunk`; False where the motion could not."""
        duration = duration or self.chunk
        self._trouble = self._step(duration)
        if self._trouble and self.pulled is not None and self._simulation.status not in KEPT:
            self.let_go = self._trouble
            self.release()
            self._trouble = self._step(duration)
        return not self._trouble

    def _step(self, duration: float) -> str:
        """Make a step; why it failed, or nothing."""
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
            # States beyond all numbers, and whatever functions of time raise that the model calls.
            known = isinstance(error, ValueError | LissomError)
            return str(error) if known else f"{type(error).__name__}: {error}"
        return "" if self._simulation.success else self._simulation.message

    def reset(self) -> None:
        """Return to the initial state; inputs keep their values."""
        self.release()
        self._trouble = self.let_go = ""
        self._simulation.reset(**self._start)
