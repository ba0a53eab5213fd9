"""Links, the parts of a `Robot`.

They only hold data and validate it when they are created; the compiled core does the computing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass, field
from typing import TYPE_CHECKING

from ._lissom import Joint, Weld, check_link
from .plain import in_floats

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ._lissom import Body, Segment

    Vector = Sequence[float]


#: A rigid connection, which has no parameters.
WELD = Weld()


@dataclass(frozen=True)
class Link:
    """A joint followed by a rod, a rigid body, or a frame alone.

    `position` and `orientation` place the joint frame on the parent, in the axes of the section or body
    there. The joint moves the base of the link relative to that frame. A rod starts at the base, along its x
    axis.

    Parameters
    ----------
    name : str
        Name by which loads, child links and results refer to the link.
    rod : sequence of Segment, optional
        Segments of the rod, from base to tip.
    body : Body, optional
        Rigid body; its centre and inertia are in the axes of the link's base.
    joint : Joint
        Joint between the link and its parent; by default a rigid connection.
    parent : str, optional
        Link that carries this one; it must come earlier in the robot. By default the world.
    at : float, optional
        Arc length of the parent's rod at which the link is attached, metres; by default the tip. None if the
        parent is rigid.
    position : array_like, shape (3,)
        Position of the joint frame on the parent, metres.
    orientation : array_like, shape (4,)
        Orientation of the joint frame: unit quaternion (w, x, y, z) that maps its axes to those of the
        parent.

    Raises
    ------
    ValueError, TypeError
        If parameters are invalid; the message lists all of them. `Robot` checks that parent and place exist.

    Examples
    --------
    >>> import lissom
    >>> palm = lissom.Link("palm", body=lissom.Body(0.3), joint=lissom.Prismatic((0, 1, 0)))
    >>> soft = lissom.Segment(0.1, 8e-3, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 3})
    >>> finger = lissom.Link("finger", rod=[soft], parent="palm", position=(0.05, 0, 0))
    """

    name: str
    _: KW_ONLY
    rod: Sequence[Segment] | None = field(default=None, hash=False)
    body: Body | None = field(default=None, hash=False)
    joint: Joint = WELD
    parent: str | None = None
    at: float | None = None
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Vector = (1.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if isinstance(self.rod, Iterable):
            # Iterators can be read only once.
            object.__setattr__(self, "rod", tuple(self.rod))
        check_link(self)
        # Equal objects compare equal.
        in_floats(self, "position", "orientation")
