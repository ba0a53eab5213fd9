"""Places on links at which glyphs are drawn."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..._lissom import Link, Robot

Array = NDArray[np.float64]


class OnLink(Protocol):
    """A part that lies on a link."""

    @property
    def link(self) -> str | None:
        """Name of the link; None for the only one."""

    @property
    def at(self) -> float | None:
        """Arc length of its place; None for the tip."""


def place_of(robot: Robot, part: OnLink) -> tuple[Link, float | None]:
    """The link that carries a part, and the arc length of its place there; None without a rod."""
    name = part.link or robot.links[0].name
    link = next(link for link in robot.links if link.name == name)
    if part.at is not None or link.rod is None:
        return link, part.at
    return link, sum(segment.length for segment in link.rod)


def poses(robot: Robot, link: str, X: Array | None, q: Array, t: float | Array) -> Array:
    """Poses (..., places, 4, 4) of places on a rod, or of the single one of a body."""
    found = robot.pose(q, X, link=link, t=t)
    return found if X is not None else found[..., None, :, :]
