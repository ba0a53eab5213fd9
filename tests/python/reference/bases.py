"""Strains in other bases, and varying reference strains, for the NumPy reference of the rod."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.polynomial.legendre import legvander
from numpy.polynomial.polynomial import polyvander
from scipy.interpolate import CubicHermiteSpline

from . import rod


def functions(basis, modes, x):
    """The functions of a basis at the fractions x, shape (len(x), modes)."""
    x = np.asarray(x, float)
    if basis == "hermite":
        knots, identity = np.linspace(0, 1, modes // 2), np.eye(modes)
        return CubicHermiteSpline(knots, identity[::2], identity[1::2] / knots[1])(x)
    if basis == "monomial":
        return polyvander(x, modes - 1)
    return {"legendre": legvander, "chebyshev": chebvander}[basis](2 * x - 1, modes - 1)


@dataclass(frozen=True)
class Segment(rod.Segment):
    """A segment with functions of `kind`, equally many for each strain, and a reference strain of X."""

    kind: str = "legendre"
    reference: Callable = lambda X: (0, 0, 0, 1, 0, 0)

    def basis(self, X):
        strains, numbers = self.coordinates
        B_Phi = np.zeros((6, self.n))
        B_Phi[strains, range(self.n)] = functions(self.kind, numbers.max() + 1, [X / self.length])[0, numbers]
        return B_Phi


class Rod(rod.Rod):
    def _strain(self, i, X, B_Phi, q):
        return np.asarray(self.segments[i].reference(X)) + B_Phi @ q[self.dofs[i]]
