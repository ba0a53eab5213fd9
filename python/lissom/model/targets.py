"""Target poses of links, for inverse kinematics with `Robot.reach`.

`Target` only holds data. It is validated when it is created; the compiled core does the computing.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .._lissom import check_target
from ..common.arguments import suggesting

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike


@suggesting
@dataclass(frozen=True)
class Target:
    """The target pose of a link, for `Robot.reach`.

    Parameters
    ----------
    link : str
        Name of the link.
    pose : array_like, shape (4, 4), (3,), (3, 3) or (4,)
        Target in the world: a homogeneous matrix as returned by `Robot.pose`; a position alone, metres; or an
        orientation alone, as a rotation matrix or a quaternion (w, x, y, z).
    X : float, optional
        Arc length of the link's unstretched rod, metres; by default its tip. None for a rigid link.
    point : array_like, shape (3,)
        The point to place, in the axes of the section or body, metres.
    position_weight : float or array_like, shape (3,)
        Weights of the position errors along the world axes; zero ignores an axis.
    orientation_weight : float or array_like, shape (3,)
        Weights of the orientation errors about the target's axes; zero ignores an axis:
        ``(0, 1, 1)`` prescribes the direction of the x axis but not the rotation about it.

    Raises
    ------
    ValueError, TypeError
        If a value is invalid.
    """

    link: str
    pose: ArrayLike
    _: KW_ONLY
    X: float | None = None
    point: ArrayLike = (0.0, 0.0, 0.0)
    position_weight: ArrayLike = 1.0
    orientation_weight: ArrayLike = 1.0

    def __post_init__(self) -> None:
        check_target(self)
        # Immutable numbers and tuples, so that equal targets compare equal.
        for name in ("pose", "point", "position_weight", "orientation_weight"):
            object.__setattr__(self, name, _tuples(np.asarray(getattr(self, name), dtype=float).tolist()))

    def __iter__(self) -> Iterator[Target]:
        """The target alone: one target serves where several are expected."""
        yield self


# Pickles refer to the class by this module, whatever moves. Set within the class it would hide `KW_ONLY`.
Target.__module__ = "lissom"


def _tuples(value: Any) -> Any:
    """The value with tuples in place of lists."""
    return tuple(map(_tuples, value)) if isinstance(value, list) else value
