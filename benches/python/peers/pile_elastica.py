"""The pile in PyElastica: discrete Cosserat rods by position Verlet.

With lissom's laws of contact and damping (pile_elastica_laws.py), or with PyElastica's own contacts, without
friction between rods and without damping.
"""

from itertools import combinations

import elastica
import numpy as np
from pile_elastica_laws import RetardedCouples, RodContact, WallContact
from pile_scene import (
    AREA,
    DENSITY,
    FRICTION,
    GRAVITY,
    LENGTH,
    RADIUS,
    SHEAR_MODULUS,
    SLIP_VELOCITY,
    STIFFNESS,
    TIMES,
    WALLS,
    YOUNG_MODULUS,
    Clock,
    Motion,
    Pile,
    State,
)

# Of PyElastica's own linear damper, of the critical one; the loss of MuJoCo's pile (pile_mujoco.py).
DAMPING_RATIO = 0.16


class Simulator(elastica.BaseSystemCollection, elastica.Forcing, elastica.Contact, elastica.Damping):
    """Rods that have weight, touch, and are damped."""


def rod(start: np.ndarray, direction: np.ndarray, elements: int) -> elastica.CosseratRod:
    made = elastica.CosseratRod.straight_rod(
        elements,
        start,
        direction,
        np.cross([0.0, 0.0, 1.0], direction),
        LENGTH,
        RADIUS,
        DENSITY,
        youngs_modulus=YOUNG_MODULUS,
        shear_modulus=SHEAR_MODULUS,
    )
    # PyElastica multiplies the shear stiffness with a fixed correction of 27/28; lissom does not.
    for axis in (0, 1):
        made.shear_matrix[axis, axis, :] = SHEAR_MODULUS * AREA
    return made


def largest_stable_step(elements: int) -> float:
    """Of an explicit scheme of second order: 2 over the largest frequency, of stretch and shear."""
    stretch = 2.0 * np.sqrt(YOUNG_MODULUS / DENSITY) * elements / LENGTH
    return 2.0 / np.hypot(stretch, np.sqrt(4.0 * SHEAR_MODULUS / (DENSITY * RADIUS**2)))


def touching_as_in_lissom(simulator: Simulator, rods: list, walls: list, step: float) -> None:
    for each in rods:
        for wall in walls:
            simulator.detect_contact_between(each, wall).using(WallContact, step=step)
    for one, other in combinations(rods, 2):
        # The first is the later one, as in lissom's pile.
        simulator.detect_contact_between(other, one).using(RodContact, step=step)
    for each in rods:
        simulator.dampen(each).using(RetardedCouples, step=step)


def touching_as_built_in(simulator: Simulator, rods: list, walls: list, elements: int) -> None:
    piece = LENGTH / elements
    stiffness = STIFFNESS * piece
    damping = 2.0 * DAMPING_RATIO * np.sqrt(stiffness * DENSITY * AREA * piece)
    friction = np.full(3, FRICTION)
    for each in rods:
        for wall in walls:
            simulator.detect_contact_between(each, wall).using(
                elastica.RodPlaneContactWithAnisotropicFriction,
                k=stiffness,
                nu=damping,
                slip_velocity_tol=SLIP_VELOCITY,
                static_mu_array=friction,
                kinetic_mu_array=friction,
            )
    for one, other in combinations(rods, 2):
        simulator.detect_contact_between(one, other).using(
            elastica.RodRodContact, k=0.5 * stiffness, nu=0.5 * damping
        )


class Simulated:
    """A pile that has not moved yet."""

    def __init__(self, pile: Pile, elements: int, step: float, *, built_in: bool = False) -> None:
        self._simulator = Simulator()
        self._rods = [rod(*placed, elements) for placed in zip(pile.starts, pile.directions, strict=True)]
        walls = [elastica.Plane(np.array(point), np.array(normal)) for point, normal in WALLS]
        for each in [*self._rods, *walls]:
            self._simulator.append(each)
        for each in self._rods:
            self._simulator.add_forcing_to(each).using(
                elastica.GravityForces, acc_gravity=np.array([0.0, 0.0, -GRAVITY])
            )
        if built_in:
            touching_as_built_in(self._simulator, self._rods, walls, elements)
        else:
            touching_as_in_lissom(self._simulator, self._rods, walls, step)
        self._simulator.finalize()
        self._stepper, self._step, self._now = elastica.PositionVerlet(), step, 0.0

    def _advance(self, until: float) -> None:
        for _ in range(round((until - self._now) / self._step)):
            self._now = self._stepper.step(self._simulator, self._now, self._step)

    def _lines(self) -> np.ndarray:
        return np.array([each.position_collection.T.copy() for each in self._rods])

    def motion(self, until: float = TIMES[-1]) -> Motion:
        """Up to the last of the times, or for timing only up to an earlier one."""
        clock, points = Clock(), []
        for time in TIMES:
            if time <= until:
                with clock:
                    self._advance(time)
            lines = self._lines()
            points.append(lines[:, [0, lines.shape[1] // 2, -1]])
        return Motion(np.array(points), clock.seconds)

    def state(self, time: float) -> State:
        self._advance(time)
        kinetic = sum(
            each.compute_translational_energy() + each.compute_rotational_energy() for each in self._rods
        )
        return State(self._lines(), float(kinetic))
