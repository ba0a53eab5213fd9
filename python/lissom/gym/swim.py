"""An eel that swims forward.

A tapered body of 40 cm floats in still water and moves in a plane. Four muscles along it bend it to either
side; drag and added mass of the water propel it (docs/fluid.md).
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from .._lissom import ActiveStrain, Fluid, Input, Link, Planar, Robot, Segment
from .task import Array, Outcome, Start, States, Task

#: Length of the body, metres.
LENGTH = 0.4
#: Radii of head and tail, metres.
RADII = (0.012, 0.005)
#: Density of the body and of the water, kilograms per cubic metre: the body is neutrally buoyant.
DENSITY = 1000.0
#: Number of muscles along the body; the activation of each one is largest in its middle and zero at its
#: neighbours' middles.
MUSCLES = 4
#: Maximum curvature of a muscle, radians per metre.
CURVATURE = 8.0
#: Cost per step with all muscles at maximum curvature.
EFFORT = 0.05


def eel(
    young_modulus: float = 5e5,
    retardation_time: float = 0.02,
    drag_coefficients: tuple[float, float] = (1.2, 0.02),
) -> Robot:
    """Return the eel. It swims along the x axis unless it turns.

    Parameters
    ----------
    young_modulus : float
        Young's modulus, pascals.
    retardation_time : float
        Retardation time of the material, seconds.
    drag_coefficients : (float, float)
        Drag coefficients perpendicular to the body and along it.
    """
    body = Segment(
        LENGTH,
        RADII,
        young_modulus,
        poisson_ratio=0.5,
        density=DENSITY,
        modes={"bend_z": 5},
        retardation_time=retardation_time,
    )
    stations = np.linspace(0.0, LENGTH, MUSCLES + 2)
    hats = np.eye(MUSCLES + 2)[1:-1]
    return Robot(
        # The rod begins at the head and extends backward.
        [Link("eel", rod=[body], joint=Planar((0, 0, 1)), orientation=(0, 0, 0, 1))],
        gravity=(0, 0, 0),
        fluid=Fluid(DENSITY, drag_coefficients=drag_coefficients),
        actuators=[
            ActiveStrain("eel", "bend_z", (stations, hat), Input(f"muscle[{k}]"), name=f"muscle[{k}]")
            for k, hat in enumerate(hats)
        ],
    )


def velocity(robot: Robot, q: Array, v: Array) -> Array:
    """Velocity of the centre of mass in the plane, shape (k, 2), metres per second."""
    # The momentum of a body translated at unit speed equals its mass.
    unit = np.zeros_like(v)
    unit[:, 0] = 1.0
    mass = np.abs(robot.momentum(q, unit)[:, 3:4])
    average: Array = robot.momentum(q, v)[:, 3:5] / mass
    return average


class Swim(Task):
    """Swim forward with little effort.

    Actions are muscle activations; 1 means a curvature of `CURVATURE` to one side. Observations are the sine
    and cosine of the head's angle, the five bending modes, the velocity of the centre of mass along and
    across the head, and the rates of the angle and the modes. The reward of a step is the speed of the centre
    of mass along x in body lengths per second, minus `EFFORT` times the mean square of the actions.
    """

    dt: ClassVar[float] = 1.25e-3
    control_step: ClassVar[float] = 0.04
    max_episode_steps: ClassVar[int] = 250
    failed_reward: ClassVar[float] = -10.0
    window: ClassVar = ((-0.8, -1.0, 0.0), (3.2, 1.0, 0.0))

    def __init__(self) -> None:
        self.robot: Robot = eel()
        bending = self.robot.coordinates[3:]
        self.channels = (
            {"sine": 1.0, "cosine": 1.0}
            | dict.fromkeys(bending, 200.0)
            | {"speed along": 10.0, "speed across": 10.0, "rate of angle": 200.0}
            | {f"rate of {name}": 1e4 for name in bending}
        )

    def start(self, robot: Robot, random: np.random.Generator) -> Start:
        """At rest and straight, with a small deviation of the heading; there is no goal."""
        q = np.zeros(robot.n)
        q[2] = random.uniform(-0.2, 0.2)
        return Start(q, np.zeros(robot.n), np.empty(0))

    def inputs(self, actions: Array) -> Array:
        """Curvatures, radians per metre."""
        curvatures: Array = CURVATURE * actions
        return curvatures

    def outcome(self, states: States) -> Outcome:
        """The infos contain the speed along x in metres per second."""
        ahead, aside = states.ask(velocity).T
        # NumPy may use another loop for sines of strided arrays than for a single number.
        angle = np.ascontiguousarray(states.q[:, 2])
        sine, cosine = np.sin(angle), np.cos(angle)
        along = cosine * ahead + sine * aside
        across = cosine * aside - sine * ahead
        swings = np.stack([sine, cosine], axis=-1)
        speeds = np.stack([along, across], axis=-1)
        effort = EFFORT * (states.actions * states.actions).mean(axis=-1)
        return Outcome(
            np.concatenate([swings, states.q[:, 3:], speeds, states.v[:, 2:]], axis=-1),
            ahead / LENGTH - effort,
            {"speed": ahead.copy()},
        )
