"""Confidence intervals within bounds: on a logarithmic scale, or by profiles of the sum of squares."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Residuals and their Jacobian at values of the parameters.
Evaluated = Callable[[Array], tuple[Array, Array]]

#: An end of an interval is found if the square root of the sum of squares is right to this part, or its
#: distance from the best value, which is almost proportional to that.
CLOSE = 1e-2

#: Most steps by regula falsi before bisection, and most doublings of the way to an end.
MOST_STEPS, MOST_DOUBLINGS = 20, 40

#: Largest half width, relative to the value, of an interval computed in the logarithm. Wider ones may extend
#: beyond zero and need a profile, which an interval of the logarithm would not show.
NARROW = 1.0

#: What the sum of squares at one value of a parameter is relative to its change when the others have settled.
SETTLED = 1e-4


class OutOfRuns(Exception):
    """There are no runs left."""


def on_scale(values: Array, width: Array, lowest: Array) -> Array:
    """Intervals (p, 2) of values and half widths (p,), of logarithms where the lowest value is not negative.

    There the logarithm of the value has the half width ``width / value``: the same for narrow intervals.
    Wide ones stay linear.
    """
    intervals = np.stack([values - width, values + width], axis=1)
    is_scale = (lowest >= 0.0) & (values > 0.0) & (width <= NARROW * values)
    factor = np.exp(width[is_scale] / values[is_scale])
    intervals[is_scale] = np.stack([values[is_scale] / factor, values[is_scale] * factor], axis=1)
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

        The search begins at a guess, which is on that side; the end is infinite if nothing is found beyond.
        Raises OutOfRuns if `evaluated` does.
        """
        best = float(self.best[which])
        self._last, self._others = best, np.delete(self.best, which)
        # How the others follow to first order.
        of_others = np.delete(self.jacobian, which, axis=1)
        self._slope = -np.linalg.lstsq(of_others, self.jacobian[:, which], rcond=None)[0]
        bound = float((self.lowest, self.highest)[side > 0][which])
        # There is no number between both.
        if best in (bound, guess):
            return best
        near, below, far = best, -1.0, guess
        for _ in range(MOST_DOUBLINGS):
            far = max(far, bound) if side < 0 else min(far, bound)
            above = self._above(which, far)
            if above > 0.0:
                return self._between(which, (near, below), (far, above))
            if far == bound:
                return bound
            near, below = far, above
            far = best + 2.0 * (far - best)
        return side * np.inf

    def _between(self, which: int, inner: tuple[float, float], outer: tuple[float, float]) -> float:
        """The end between a value that belongs to the interval and another one, each with what `_above` says.

        By regula falsi (Dowell and Jarratt 1971, the Illinois rule): the square root is almost linear. Where
        runs fail it jumps; bisection ends at such a place.
        """
        (near, below), (far, above) = inner, outer
        best = float(self.best[which])
        last = 0
        for step in count():
            is_smooth = np.isfinite(above) and step < MOST_STEPS
            part = below / (below - above) if is_smooth else 0.5
            middle = near + min(max(part, 0.05), 0.95) * (far - near)
            if abs(far - near) <= CLOSE * abs(far - best) or middle in (near, far):
                break
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
        """How far the square root of the growth is above that of the end, relative to it.

        It is infinite where runs fail.
        """
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
