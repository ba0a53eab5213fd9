"""Random trees of rigid bodies in plain data, and lissom's robot of one."""

from dataclasses import dataclass

import numpy as np

import lissom

COORDINATES = {
    "weld": 0,
    "revolute": 1,
    "prismatic": 1,
    "cylindrical": 2,
    "universal": 2,
    "planar": 3,
    "spherical": 3,
    "free": 6,
}
MOVING = [kind for kind, count in COORDINATES.items() if count]
# A body that is free in the middle of a tree is rare.
INNER = 2 * [kind for kind in COORDINATES if kind != "free"] + ["free"]
AXES = {"weld": 0, "universal": 2, "spherical": 0, "free": 0}
ANGLES = {"revolute": 1, "cylindrical": 1, "universal": 2, "planar": 1}
WITH_ARMATURE = ("revolute", "prismatic")

# Decimetres, like links of robots.
LENGTH = 0.1
# Probability that a link hangs on the one before it, or else on that one's parent, and so on.
ONWARDS = 0.6


@dataclass(frozen=True)
class Member:
    """A joint and the rigid body behind it; parents stand before children, subtrees in one piece.

    `orientation` and `principal_axes` are quaternions w, x, y, z; `principal` the moments of inertia about
    the centre of mass in those axes, which are relative to those of the link.
    """

    parent: int | None
    position: np.ndarray
    orientation: np.ndarray
    kind: str
    axes: tuple[np.ndarray, ...]
    armature: float
    mass: float
    centre: np.ndarray
    principal: np.ndarray
    principal_axes: np.ndarray

    @property
    def inertia(self) -> np.ndarray:
        turn = rotation(self.principal_axes)
        return turn @ np.diag(self.principal) @ turn.T


@dataclass(frozen=True)
class Tree:
    members: tuple[Member, ...]
    gravity: np.ndarray

    @property
    def depth(self) -> int:
        depths: list[int] = []
        for member in self.members:
            depths.append(1 if member.parent is None else depths[member.parent] + 1)
        return max(depths)


def rotation(quaternion: np.ndarray) -> np.ndarray:
    """The matrix of a unit quaternion w, x, y, z."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def direction(rng: np.random.Generator, size: int = 3) -> np.ndarray:
    vector = rng.normal(size=size)
    return vector / np.linalg.norm(vector)


def member(rng: np.random.Generator, parent: int | None, kind: str, decades: float) -> Member:
    mass = 10.0 ** rng.uniform(-0.5 * decades, 0.5 * decades)
    # Moments of inertia of a cuboid, which always belong to some body.
    squares = (LENGTH * rng.uniform(0.2, 1.0, size=3)) ** 2
    return Member(
        parent=parent,
        position=LENGTH * rng.normal(size=3),
        orientation=direction(rng, 4),
        kind=kind,
        axes=tuple(direction(rng) for _ in range(AXES.get(kind, 1))),
        armature=1e-2 * mass * LENGTH**2 if kind in WITH_ARMATURE and rng.random() < 0.5 else 0.0,
        mass=mass,
        centre=0.5 * LENGTH * rng.normal(size=3),
        principal=mass / 12.0 * (squares.sum() - squares),
        principal_axes=direction(rng, 4),
    )


def random_tree(seed: int, links: int, root: str, decades: float, serial: bool = False) -> Tree:
    """A tree with all kinds of joints and masses over so many decades; `root` is its first joint's kind."""
    rng = np.random.default_rng(seed)
    members: list[Member] = []
    for index in range(links):
        if index == 0:
            members.append(member(rng, None, root, decades))
            continue
        parent = index - 1
        while not serial and members[parent].parent is not None and rng.random() > ONWARDS:
            parent = members[parent].parent
        # The second link moves, so that something does.
        members.append(member(rng, parent, str(rng.choice(MOVING if index == 1 else INNER)), decades))
    return Tree(tuple(members), 9.81 * direction(rng))


def state(tree: Tree, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates with rotation vectors up to half a turn, velocities, accelerations."""
    rng = np.random.default_rng(seed)
    q: list[float] = []
    for each in tree.members:
        if each.kind in ("free", "planar"):
            q += list(LENGTH * rng.normal(size=3 if each.kind == "free" else 2))
        if each.kind in ("spherical", "free"):
            q += list(rng.uniform(0.0, np.pi) * direction(rng))
        elif each.kind in ("prismatic", "cylindrical"):
            q.append(LENGTH * rng.normal())
        q += list(rng.uniform(-np.pi, np.pi, size=ANGLES.get(each.kind, 0)))
    return np.array(q), rng.normal(size=len(q)), rng.normal(size=len(q))


def joint(each: Member) -> lissom.Joint:
    make = getattr(lissom, each.kind.capitalize())
    options = {"armature": each.armature} if each.kind in WITH_ARMATURE else {}
    return make(*each.axes, **options)


def robot(tree: Tree) -> lissom.Robot:
    """lissom's."""
    links = [
        lissom.Link(
            f"link{index}",
            parent=None if each.parent is None else f"link{each.parent}",
            position=each.position,
            orientation=each.orientation,
            joint=joint(each),
            body=lissom.Body(each.mass, centre=each.centre, inertia=each.inertia),
        )
        for index, each in enumerate(tree.members)
    ]
    return lissom.Robot(links, gravity=tree.gravity)
