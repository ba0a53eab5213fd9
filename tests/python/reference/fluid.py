"""Independent model of a rod in a fluid: drag, added mass and buoyancy in the axes of the section.

Added mass by Kirchhoff's equations (Lamb 1932, section 124) in the frame that moves with the fluid: with the
relative body twist eta_r and its rate, the section requires M_a eta_rt - ad_eta_r^T M_a eta_r. Quadratic
transverse drag after Morison and others (1950), axial drag after Taylor (1952).
"""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from reference import rod


@dataclass(frozen=True)
class Fluid:
    """Same arguments as `lissom.Fluid`."""

    density: float
    velocity: Sequence[float] = (0, 0, 0)
    viscous_drag: Sequence[float] = (0, 0)
    drag_coefficients: Sequence[float] = (0, 0)
    added_mass_coefficient: float = 1.0
    buoyancy: bool = True

    def drag(self, v, area):
        """Force per length for a velocity in the axes of the section."""
        across, along = np.array([0, v[1], v[2]]), np.array([v[0], 0, 0])
        force = -self.viscous_drag[0] * across - self.viscous_drag[1] * along
        pressure = self.density * np.sqrt(area / np.pi)
        force -= pressure * self.drag_coefficients[0] * np.linalg.norm(across) * across
        return force - pressure * np.pi * self.drag_coefficients[1] * abs(v[0]) * along


class Rod(rod.Rod):
    """A rod in a fluid."""

    def __init__(self, segments, *, fluid, **arguments):
        super().__init__(segments, **arguments)
        self.fluid = fluid

    def mass_matrix(self, q):
        still = copy(self)
        still.fluid = replace(self.fluid, velocity=(0, 0, 0), buoyancy=False)
        return super(Rod, still).mass_matrix(q)

    def _load(self, i, X, y, spread):
        wrench = super()._load(i, X, y, spread)
        R, _, eta, eta_t = rod.unpack(y)
        area = self.segments[i].outline_area(X)
        current = R.T @ np.asarray(self.fluid.velocity, float)
        relative = eta - np.concatenate([np.zeros(3), current])
        relative_t = eta_t.copy()
        relative_t[3:] += np.cross(eta[:3], current)[:, None]
        mass = self.fluid.added_mass_coefficient * self.fluid.density * area
        added = mass * np.diag([0.0, 0, 0, 0, 1, 1])
        wrench = wrench + added @ relative_t - (rod.ad(relative).T @ added @ relative)[:, None]
        force = self.fluid.drag(relative[3:], area)
        if self.fluid.buoyancy:
            force = force - self.fluid.density * area * (R.T @ self.gravity)
        wrench[3:] -= force[:, None]
        return wrench
