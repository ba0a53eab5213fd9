"""The energy balance of a motion: where the energy is, and what left or entered the system."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ._lissom import Model, Rod

Array = NDArray[np.float64]


#: Energies that move by less than this, relative to the largest part, are at rest.
ROUNDING = 1e3 * float(np.finfo(float).eps)


@dataclass(frozen=True)
class Balance:
    """Energies in joules at each time of a motion, arrays of shape (m,).

    ``total`` is what an exact motion keeps constant: kinetic + elastic + gravitational + loads + dissipated
    - work.
    """

    kinetic: Array
    elastic: Array
    gravitational: Array
    loads: Array
    #: Energy that damping has taken out so far.
    dissipated: Array
    #: Work that tip moments have put in so far: a moment of fixed direction has no potential.
    work: Array

    @property
    def total(self) -> Array:
        """What an exact motion keeps constant."""
        potential = self.elastic + self.gravitational + self.loads
        return self.kinetic + potential + self.dissipated - self.work

    @property
    def scale(self) -> float:
        """The largest energy that moved: kinetic energy reached, or change of another part, in joules."""
        changing = (self.elastic, self.gravitational, self.loads, self.dissipated, self.work)
        return max(float(np.max(self.kinetic)), *(float(np.ptp(part)) for part in changing))

    @property
    def drift(self) -> float:
        """Largest change of the total, relative to the largest energy that moved; zero if nothing moved."""
        defect = float(np.max(np.abs(self.total - self.total[0])))
        return defect / self.scale if self.moves else 0.0

    @property
    def moves(self) -> bool:
        """False where all that moves is rounding of the parts."""
        parts = (self.kinetic, self.elastic, self.gravitational, self.loads)
        largest = max(float(np.max(np.abs(part))) for part in parts)
        return self.scale > ROUNDING * largest


def balance(model: Model, t: Array, q: Array, v: Array) -> Balance:
    """Energy balance along a motion.

    Parameters
    ----------
    model : Model
        What moved.
    t : ndarray, shape (m,)
        Successive times in seconds.
    q, v : ndarray, shape (m, n)
        Coordinates and velocities at these times. What flowed between two of them is taken from the state
        half-way, as the average-acceleration rule does: with every step of that rule, the balance of a linear
        system is exact.

    Returns
    -------
    balance : Balance
        At a cost of two to four model evaluations a time.
    """
    energies = [model.energy(*state) for state in zip(q, v, strict=True)]
    q_between, v_between = (0.5 * (x[1:] + x[:-1]) for x in (q, v))
    powers = [model.dissipated_power(*state) for state in zip(q_between, v_between, strict=True)]
    dissipated = _accumulated(np.array(powers) * np.diff(t))
    work = np.zeros_like(dissipated)
    if isinstance(model, Rod) and any(model.tip_moment):
        steps = zip(_moment_forces(model, q_between), np.diff(q, axis=0), strict=True)
        work = _accumulated(np.array([force @ step for force, step in steps]))
    return Balance(
        kinetic=np.array([energy.kinetic for energy in energies]),
        elastic=np.array([energy.elastic for energy in energies]),
        gravitational=np.array([energy.gravitational for energy in energies]),
        loads=np.array([energy.loads for energy in energies]),
        dissipated=dissipated,
        work=work,
    )


def _accumulated(amounts: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(amounts)])


def _moment_forces(rod: Rod, q: Array) -> list[Array]:
    """Generalised forces of the tip moment: the difference it makes to the rod at rest."""
    without = Rod(
        rod.segments,
        base_position=rod.base_position,
        base_orientation=rod.base_orientation,
        gravity=rod.gravity,
        tip_force=rod.tip_force,
        tip_mass=rod.tip_mass,
    )
    rest = np.zeros(rod.n)
    return [without.inverse_dynamics(x, rest, rest) - rod.inverse_dynamics(x, rest, rest) for x in q]
