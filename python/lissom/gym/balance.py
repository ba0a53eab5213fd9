"""A flexible pole on a cart, to be balanced upright.

The robot is that of the regulator in ``examples/python/cart_pole_lqr.py``.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from .._lissom import Body, Input, Link, Motor, Prismatic, Revolute, Robot, Segment
from .task import Array, Outcome, Start, States, Task

#: Maximum force on the cart, newtons.
FORCE = 20.0
#: Half the length of the track, metres.
TRACK = 1.5
#: Maximum inclination of the pole, radians.
LEAN = 0.8
#: Cost per step at the end of the track, and at the maximum force.
AWAY, EFFORT = 0.1, 0.01


def cart_pole(
    young_modulus: float = 2e7, density: float = 1100.0, cart_mass: float = 1.0, length: float = 0.5
) -> Robot:
    """A cart on a rail along x with a hinge perpendicular to it, which carries a flexible pole.

    Parameters
    ----------
    young_modulus : float
        Young's modulus of the pole, pascals.
    density : float
        Density of the pole, kilograms per cubic metre.
    cart_mass : float
        Mass of the cart, kilograms.
    length : float
        Length of the pole, metres.
    """
    pole = Segment(
        length, 0.006, young_modulus, 0.4 * young_modulus, density, {"bend_y": 2}, retardation_time=0.002
    )
    return Robot(
        [
            Link("cart", body=Body(cart_mass), joint=Prismatic((1, 0, 0))),
            Link("hinge", parent="cart", joint=Revolute((0, 1, 0), damping=1e-4)),
            Link("pole", parent="hinge", rod=[pole], orientation=(np.sqrt(0.5), 0, -np.sqrt(0.5), 0)),
        ],
        actuators=[Motor("cart", Input("force"))],
    )


class Balance(Task):
    """Hold a flexible pole upright by pushing the cart on which it is hinged.

    The action is the force on the cart; 1 means `FORCE`. Observations are the coordinates (position of the
    cart, angle of the hinge, two bending modes) and their rates. The reward of a step is one, minus `AWAY`
    times the squared position relative to the length of the track, minus `EFFORT` times the squared action.
    An episode ends when the pole leans by more than `LEAN` or the cart leaves the track.
    """

    dt: ClassVar[float] = 5e-3
    control_step: ClassVar[float] = 0.02
    max_episode_steps: ClassVar[int] = 500
    window: ClassVar = ((-1.6, 0.0, -0.3), (1.6, 0.0, 0.7))

    def __init__(self) -> None:
        self.robot: Robot = cart_pole()
        place, angle, *bending = self.robot.coordinates
        limits = {place: TRACK, angle: LEAN} | dict.fromkeys(bending, 100.0)
        self.channels = limits | {
            f"rate of {name}": 1e3 if name in (place, angle) else 1e5 for name in limits
        }

    def start(self, robot: Robot, random: np.random.Generator) -> Start:
        """Near the middle of the track, with a straight and slightly inclined pole; there is no goal."""
        q, v = np.zeros((2, robot.n))
        q[:2] = random.uniform(-0.1, 0.1, 2)
        v[:2] = random.uniform(-0.1, 0.1, 2)
        return Start(q, v, np.empty(0))

    def inputs(self, actions: Array) -> Array:
        """The force on the cart, newtons."""
        force: Array = FORCE * actions
        return force

    def outcome(self, states: States) -> Outcome:
        """No information beside the observations."""
        away = states.q[:, 0] / TRACK
        effort = EFFORT * (states.actions * states.actions).sum(axis=-1)
        return Outcome(np.concatenate([states.q, states.v], axis=-1), 1.0 - AWAY * (away * away) - effort, {})
