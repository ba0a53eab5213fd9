"""Independent magnets: pairs of magnetic charges (Gilbert's model), and the elastica in a uniform field.

A dipole of the moment m is the limit of two charges +-|m|/d at +-d/2 along m. Charges attract and repel each
other as electric ones do; errors are even powers of d, of which Richardson's extrapolation removes two.
"""

import numpy as np
from scipy.special import ellipk, ellipkinc

#: Vacuum magnetic permeability in N/A^2, CODATA 2022.
MU_0 = 1.25663706127e-6

#: Distances of the charges of a dipole, relative to what is between two dipoles.
DISTANCES = (0.02, 0.01, 0.005)

#: Factors that remove the errors of second and fourth order.
FACTORS = (1 / 45, -20 / 45, 64 / 45)


def charges(moment, at, distance):
    """Charges of a dipole in ampere metres, and their positions."""
    size = np.linalg.norm(moment)
    arm = np.asarray(moment, float) / size * distance / 2
    return [(size / distance, at + arm), (-size / distance, at - arm)]


def pushes(first, second, distance):
    """Forces on the charges of the first of two dipoles, with their positions, and the energy."""
    forces, energy = [], 0.0
    for own, place in charges(*first, distance):
        force = np.zeros(3)
        for other, there in charges(*second, distance):
            way = place - there
            far = np.linalg.norm(way)
            force += MU_0 / (4 * np.pi) * own * other * way / far**3
            energy += MU_0 / (4 * np.pi) * own * other / far
        forces.append((place, force))
    return forces, energy


def between(first, second):
    """Moment about the first dipole and force on it, and the energy; a dipole is its moment and its place."""
    first, second = ((np.asarray(moment, float), np.asarray(at, float)) for moment, at in (first, second))
    apart = np.linalg.norm(first[1] - second[1])
    sums = [np.zeros(3), np.zeros(3), 0.0]
    for relative, factor in zip(DISTANCES, FACTORS, strict=True):
        forces, energy = pushes(first, second, relative * apart)
        sums[0] = sums[0] + factor * sum(np.cross(place - first[1], force) for place, force in forces)
        sums[1] = sums[1] + factor * sum(force for _, force in forces)
        sums[2] += factor * energy
    return sums


def in_uniform_field(moment, field):
    """Moment on a dipole, from the forces on its charges, and its energy."""
    pair = charges(np.asarray(moment, float), np.zeros(3), 1.0)
    field = np.asarray(field, float)
    torque = sum(np.cross(place, charge * field) for charge, place in pair)
    return torque, -sum(charge * place @ field for charge, place in pair)


def load_of_slope(slope, angle):
    """F L^2 / (E I) of the force at the tip of a cantilever, at an angle to it, that turns it by `slope`.

    With psi = pi - angle + slope, E I psi'^2 / 2 = F (cos psi - cos psi_L): a pendulum's swing in time.
    """
    start, end = np.pi - angle, np.pi - angle + slope
    k = np.sin(end / 2)
    phase = np.arcsin(np.clip(np.sin(start / 2) / k, -1.0, 1.0))
    return (ellipk(k**2) - ellipkinc(phase, k**2)) ** 2
