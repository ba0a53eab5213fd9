"""Traces of the tips."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from ...model.views import View
from ..report.layers import Line

Array = NDArray[np.float64]

#: Number of stored positions per tip: about the last ten seconds at thirty frames per second.
PLACES = 300


class Trace:
    """The last positions of a model's tips, or of the mass of a planar model."""

    def __init__(self, view: View) -> None:
        self._view = view
        self._t = -np.inf
        #: Positions (tips, 3), the oldest first.
        self._places: deque[Array] = deque(maxlen=PLACES)

    def clear(self) -> None:
        """Clear the trace."""
        self._places.clear()
        self._t = -np.inf

    def follow(self, q: Array, t: float) -> None:
        """Add the positions of the tips; start again after a reset of the motion."""
        if t < self._t:
            self.clear()
        if t > self._t:
            self._t = t
            self._places.append(self._tips(q, t))

    def _tips(self, q: Array, t: float) -> Array:
        if self._view.is_spatial:
            poses = [np.asarray(frame.pose(q, t)) for frame in self._view.frames]
            return np.array([pose[:3, 3] for pose in poses]).reshape(-1, 3)
        if self._view.sketch is None:
            return np.zeros((0, 3))
        return np.array([[*self._view.sketch.mass(q[None])[0], 0.0]])

    @property
    def line(self) -> Line:
        """The paths of all tips in one line, with `PLACES` points each, so that the node can be reused."""
        ways = np.array(self._places).reshape(len(self._places), -1, 3)
        # Missing points repeat the first one.
        missing = np.repeat(ways[:1], PLACES - len(ways), axis=0)
        ways = np.concatenate([missing, ways]).transpose(1, 0, 2)
        broken = np.concatenate([ways, np.full((len(ways), 1, 3), np.nan)], axis=1)
        return Line("trace", "paths", broken.reshape(1, -1, 3))
