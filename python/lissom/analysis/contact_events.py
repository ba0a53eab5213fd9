"""Times at which surfaces begin and cease to touch during a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .._lissom import MotionResult, Robot
from ..common.arguments import with_number
from .between import LARGEST_CHANGE, quintic

Array = NDArray[np.float64]

#: Accuracy of the times of events, relative to the step.
ACCURACY = 1e-12


@dataclass(frozen=True)
class ContactEvent:
    """A time at which two surfaces begin or cease to touch.

    Attributes
    ----------
    t : float
        Time, seconds.
    contact : str
        Name of the contact.
    kind : {'touch', 'lift_off'}
        Whether the surfaces begin or cease to touch.
    q, v : ndarray, shape (n,)
        Coordinates and velocities at this time.
    """

    # Pickles refer to the class by this module, whatever moves.
    __module__ = "lissom"

    t: float
    contact: str
    kind: Literal["touch", "lift_off"]
    q: Array
    v: Array

    def __post_init__(self) -> None:
        with_number(self, "t")


def events_of(result: MotionResult) -> list[ContactEvent]:
    """Events of a motion, in the order of their times."""
    robot = result.model
    if robot is None:
        raise ValueError("result: a result of `newmark` does not contain its model: use one of `simulate`")
    if not isinstance(robot, Robot) or not robot.contacts:
        return []
    found = []
    before = _touching(robot, result.q[0], result.t[0]) if len(result.t) else set()
    for k in range(len(result.t) - 1):
        after = _touching(robot, result.q[k + 1], result.t[k + 1])
        for name in before ^ after:
            found.append(_event(robot, result, k, name, begins=name in after))
        before = after
    return sorted(found, key=lambda event: (event.t, event.contact))


def _touching(robot: Robot, q: Array, t: float) -> set[str]:
    return {touch.contact for touch in robot.touches(q, t=t)}


def _event(robot: Robot, result: MotionResult, k: int, name: str, *, begins: bool) -> ContactEvent:
    """The event of a contact between state k and the next one, by bisection."""
    start, h = result.t[k], result.t[k + 1] - result.t[k]
    lower, upper = 0.0, 1.0
    if np.abs(result.q[k + 1] - result.q[k]).max() > LARGEST_CHANGE:
        # The coordinates jump, so interpolation is impossible: report the event at the end of the step.
        lower = upper
    polynomial = quintic(result, k)
    while upper - lower > ACCURACY:
        middle = 0.5 * (lower + upper)
        q = polynomial(middle)[0]
        if (name in _touching(robot, q, start + middle * h)) == begins:
            upper = middle
        else:
            lower = middle
    q, v = polynomial(upper)
    return ContactEvent(float(start + upper * h), name, "touch" if begins else "lift_off", q, v)
