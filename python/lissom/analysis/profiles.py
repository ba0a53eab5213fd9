"""Confidence intervals within bounds: on a logarithmic scale, or by profiles of the sum of squares."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Residuals and their Jacobian at values of the parameters.
Evaluated = Callable[[Array], tuple[Array, Array]]

#: An end of an interval is found if the square root of the sum of squares is right to this part.
CLOSE = 1e-2

#: Most steps of the search for an end, and most doublings of the way to one beyond.
MOST_STEPS, MOST_DOUBLINGS = 20, 40

#: What the sum of squares at one value of a parameter is relative to its change when the others have settled.
SETTLED = 1e-4


class OutOfRuns(Exception):
    """There are no runs left."""


def on_scale(values: Array, width: Array, lowest: Array) -> Array:
    """Intervals (p, 2) of values and half widths (p,), which stay positive where the lowest value is.

    There the logarithm of the value has the half width ``width / value``: the same for narrow intervals.
    """
    intervals = np.stack([values - width, values + width], axis=1)
    is_positive = (lowest >= 0.0) & (values > 0.0) & np.isfinite(width)
    with np.errstate(over="ignore"):
        factor = np.exp(width[is_positive] / values[is_positive])
    intervals[is_positive] = np.stack([values[is_positive] / factor, values[is_positive] * factor], axis=1)
    return intervals


@dataclass
class Profile:
    """The least sum of squares at each value of one parameter.

    An end of the interval is where it is `more` above the least one of all (Venzon and Moolgavkar 1988).
    """

    evaluated: Evaluated
    #: The best values (p,), Jacobian and sum of squares there, and by how much that grows to the ends.
    best: Array
    jacobian: Array
    least: float
    more: float
    #: Bounds (p,) of the values.
    lowest: Array
    highest: Array

    def end(self, which: int, side: int, guess: float) -> float:
        """The end of the interval of a parameter below (-1) or above (1), or the bound before it.

        Raises OutOfRuns if `evaluated` does.
        """
        best = float(self.best[which])
        self._last, self._others = best, np.delete(self.best, which)
        # How the others follow to first order.
        of_others = np.delete(self.jacobian, which, axis=1)
        self._slope = -np.linalg.lstsq(of_others, self.jacobian[:, which], rcond=None)[0]
        bound = float((self.lowest, self.highest)[side > 0][which])
        if best == bound:
            return bound
        far = bound
        if not np.isfinite(far):
            far = guess
            for _ in range(MOST_DOUBLINGS):
                if self._above(which, far) > 0.0:
                    break
                far = best + 2.0 * (far - best)
            else:
                return side * np.inf
        return self._between(which, best, far)

    def _between(self, which: int, near: float, far: float) -> float:
        """The end between a value that belongs to the interval and another one.

        By regula falsi (Dowell and Jarratt 1971, the Illinois rule): the square root is almost linear.
        """
        below, above = -1.0, self._above(which, far)
        if above <= 0.0:
            return far
        # The least sum of squares can be infinite where runs fail.
        last = 0
        for _ in range(MOST_STEPS):
            part = below / (below - above) if np.isfinite(above) else 0.5
            middle = near + min(max(part, 0.05), 0.95) * (far - near)
            found = self._above(which, middle)
            if abs(found) <= CLOSE:
                return middle
            if found < 0.0:
                near, below = middle, found
                above *= 0.5 if last < 0 else 1.0
                last = -1
            else:
                far, above = middle, found
                below *= 0.5 if last > 0 else 1.0
                last = 1
        return near

    def _above(self, which: int, value: float) -> float:
        """How far the square root of the growth is above that of the end, relative to it."""
        grown = max(self._square(which, value) - self.least, 0.0)
        return float(np.sqrt(grown / self.more) - 1.0)

    def _square(self, which: int, value: float) -> float:
        """The least sum of squares with one value held, from where the others were last."""
        from scipy.optimize import least_squares

        def whole(others: Array) -> Array:
            return np.insert(others, which, value)

        if not len(self._others):
            residual = self.evaluated(whole(self._others))[0]
            return float(residual @ residual)
        keep = np.arange(len(self.best)) != which
        lowest, highest = self.lowest[keep], self.highest[keep]
        start = np.clip(self._others + self._slope * (value - self._last), lowest, highest)
        if not np.isfinite(self.evaluated(whole(start))[0]).all():
            start = self._others
            if not np.isfinite(self.evaluated(whole(start))[0]).all():
                return np.inf
        found = least_squares(
            lambda others: self.evaluated(whole(others))[0],
            start,
            lambda others: self.evaluated(whole(others))[1][:, keep],
            bounds=(lowest, highest),
            x_scale="jac",
            ftol=SETTLED,
            xtol=SETTLED,
        )
        self._last, self._others = value, found.x
        return float(2.0 * found.cost)
