"""The pile in lissom: rods that bend and twist, in the default steps of `simulate`."""

import numpy as np
from pile_runs import Resolutions
from pile_scene import LENGTH, TIMES, Clock, Motion, Pile, State
from speed import contact

import lissom

# Modes of torsion, bending about y, bending about z.
STRAINS = ("torsion", "bend_y", "bend_z")
MODES = {2: (1, 2, 2), 3: (1, 3, 3), 5: (2, 5, 5), 6: (3, 6, 6), 8: (4, 8, 8)}
STEPS = (5e-3, 2e-3, 1e-3, 5e-4, 2e-4)
# Points of a centre line whose overlap is measured.
VERTICES = 61


def scene(rods: int) -> Pile:
    """Where the rods of `python benches/python/speed/contact.py --pile` start."""
    robot = contact.pile(rods)
    ends = [
        np.array([robot.pose(np.zeros(robot.n), X, link=f"rod {i}")[:3, 3] for i in range(rods)])
        for X in (0.0, LENGTH)
    ]
    return Pile(ends[0], (ends[1] - ends[0]) / LENGTH)


def resolutions(rods: int) -> Resolutions:
    """Of bending modes and steps; finer references of many rods would take many minutes."""
    if rods < 50:
        pairs = tuple((size, step) for size in (2, 3, 5) for step in STEPS)
        return Resolutions(pairs, (8, 1e-4 if rods < 20 else 2e-4), (3, 5e-4))
    pairs = tuple((size, step) for size in (2, 3) for step in STEPS[:4])
    return Resolutions((*pairs, (5, 1e-3), (5, 5e-4), (6, 2e-4)), (8, 2e-4), (3, 1e-3))


class Simulated:
    """A pile that has not moved yet, by the number of bending modes."""

    def __init__(self, pile: Pile, size: int, step: float) -> None:
        self._rods, self._step = pile.rods, step
        self._robot = contact.pile(pile.rods, modes=dict(zip(STRAINS, MODES[size], strict=True)))

    def _places(self, q: np.ndarray, X: np.ndarray) -> np.ndarray:
        """Of the centre lines at arc lengths, shape (..., rods, X, 3)."""
        return np.stack(
            [
                np.stack([self._robot.pose(q, at, link=f"rod {rod}")[..., :3, 3] for at in X], axis=-2)
                for rod in range(self._rods)
            ],
            axis=-3,
        )

    def motion(self) -> Motion:
        clock = Clock()
        with clock:
            run = lissom.simulate(self._robot, TIMES[-1], t_eval=[0.0, *TIMES], dt=self._step)
        if not run.success:
            return Motion(np.full((len(TIMES), self._rods, 3, 3), np.inf), clock.seconds)
        return Motion(self._places(run.q[1:], np.array([0.0, 0.5, 1.0]) * LENGTH), clock.seconds)

    def state(self, time: float) -> State:
        run = lissom.simulate(self._robot, time, dt=self._step)
        if not run.success:
            raise ArithmeticError(run.message)
        lines = self._places(run.q[-1], np.linspace(0.0, LENGTH, VERTICES))
        return State(lines, self._robot.energy(run.q[-1], run.v[-1]).kinetic)
