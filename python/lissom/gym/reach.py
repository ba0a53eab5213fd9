"""An arm with tendons that brings its tip to a point.

A hanging silicone arm, 25 cm long, in two sections. Three tendons end at the first section and three others,
between them, at the tip. Targets are equilibrium positions of the tip under random tensions, so all of them
can be reached.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from .._lissom import Along, ConvergenceError, Input, Robot, Rod, Segment, Tendon, statics
from .task import Array, Outcome, Start, States, Task

#: Length of the arm, metres.
LENGTH = 0.25
#: Distance of the tendons from the axis, metres.
OFFSET = 0.007
#: Number of tendons per section.
TENDONS = 3
#: Maximum tension, newtons.
TENSION = 6.0
#: Distance over which the reward falls to 1/e, metres.
NEAR = 0.05
#: Distance at which the target counts as reached, metres.
REACHED = 0.01
#: Cost per step with all tendons at maximum tension.
EFFORT = 0.02
#: Maximum number of equilibria computed for a target.
TRIES = 20


def arm(young_modulus: float = 6e5, density: float = 1070.0, retardation_time: float = 0.05) -> Rod:
    """Return the arm, optionally with another material.

    Parameters
    ----------
    young_modulus : float
        Young's modulus, pascals.
    density : float
        Density, kilograms per cubic metre.
    retardation_time : float
        Retardation time of the material, seconds.
    """
    section = Segment(
        LENGTH / 2,
        0.01,
        young_modulus,
        poisson_ratio=0.5,
        density=density,
        modes={"bend_y": 3, "bend_z": 3},
        retardation_time=retardation_time,
    )
    return Rod(
        [section, section],
        # The x axis of the rod points down.
        base_orientation=(np.sqrt(0.5), 0, np.sqrt(0.5), 0),
        actuators=[
            Tendon(name, [Along(None, offset, along=(0.0, end))], tension=Input(name))
            for name, offset, end in _tendons()
        ],
    )


def _tendons() -> list[tuple[str, tuple[float, float], float]]:
    """Name, offset and end of each tendon; the tendons of a section are evenly spaced around it."""
    found = []
    for section, end, turned in (("upper", LENGTH / 2, 0.0), ("lower", LENGTH, np.pi / TENDONS)):
        for k in range(TENDONS):
            angle = turned + 2 * np.pi * k / TENDONS
            offset = (OFFSET * float(np.cos(angle)), OFFSET * float(np.sin(angle)))
            found.append((f"{section}[{k}]", offset, end))
    return found


class Reach(Task):
    """Bring the tip of a tendon arm to a target and keep it there.

    Actions set the tensions from zero (-1) to `TENSION` (1). Observations are the coordinates of the arm and
    their rates, the position of the tip, and the vector from the tip to the target. The reward of a step is
    ``exp(-distance / NEAR)`` minus `EFFORT` times the mean square of the tensions relative to `TENSION`.
    """

    dt: ClassVar[float] = 5e-3
    control_step: ClassVar[float] = 0.01
    max_episode_steps: ClassVar[int] = 200
    window: ClassVar = ((-0.25, -0.25, -0.3), (0.25, 0.25, 0.05))

    def __init__(self) -> None:
        self.robot: Robot = arm()
        names = self.robot.coordinates
        self.channels = (
            dict.fromkeys(names, 100.0)
            | {f"rate of {name}": 1e4 for name in names}
            | {f"tip {axis}": 2 * LENGTH for axis in "xyz"}
            | {f"way to target {axis}": 4 * LENGTH for axis in "xyz"}
        )

    def start(self, robot: Robot, random: np.random.Generator) -> Start:
        """At rest, hanging down; the goal is the position of the target.

        Raises
        ------
        ConvergenceError
            If no equilibrium was found for any of `TRIES` random sets of tensions.
        """
        for _ in range(TRIES):
            tensions = random.uniform(0.0, TENSION, len(robot.inputs))
            held = statics(robot, u=tensions, space_error=False)
            if held.success:
                return Start(np.zeros(robot.n), np.zeros(robot.n), robot.pose(held.q)[:3, 3].copy())
        raise ConvergenceError(f"no equilibrium of the arm was found in {TRIES} tries: {held.message}")

    def inputs(self, actions: Array) -> Array:
        """Tensions, newtons."""
        tensions: Array = TENSION / 2 * (actions + 1.0)
        return tensions

    def outcome(self, states: States) -> Outcome:
        """The infos contain the distance of the tip from the target, and whether the target counts as
        reached."""
        tips = states.ask(lambda robot, q, v: robot.pose(q)[:, :3, 3])
        ways = states.goals - tips
        distance = np.sqrt((ways * ways).sum(axis=-1))
        pulled = (states.actions + 1.0) / 2
        effort = EFFORT * (pulled * pulled).mean(axis=-1)
        return Outcome(
            np.concatenate([states.q, states.v, tips, ways], axis=-1),
            np.exp(-distance / NEAR) - effort,
            {"distance": distance, "is_success": distance < REACHED},
        )
