"""How far lissom's rigid robots are from Pinocchio's and MuJoCo's: random trees, random states.

Coordinates are measured in units in which the inertia that each one meets by itself is one (the square root
of the diagonal of the mass matrix), so that metres, radians, and masses of many sizes count alike. A
deviation is the largest of an array, relative to the array's largest entry.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from mujoco_trees import MujocoTree
from pinocchio_trees import PinocchioTree
from rigid_trees import random_tree, robot, state

# What counts as rounding. lissom sees inertia from the origin of the world, which costs the square of
# distance over size: up to 4 m and 3 cm here, so 2e4 times the 2e-16 of a number, and some operations.
ROUNDING = 1e-11

# What the peer's inverse dynamics finds of force at lissom's accelerations, and these beside the peer's.
FORCE_LEFT, ACCELERATION = "forward dynamics, force left", "forward dynamics, acceleration"

TREES, QUICK_TREES = 50, 5
LINKS = (4, 20)
# Metres from the origin of the world.
DISTANCES = (0.0, 1.0, 10.0, 100.0, 1000.0)


@dataclass(frozen=True)
class Group:
    """Trees of a kind: `decades` is the range of their masses as a power of ten."""

    name: str
    root: str
    decades: float = 1.0
    serial: bool = False


GROUPS = (
    Group("welded bases", "weld"),
    Group("spherical bases", "spherical"),
    Group("floating bases", "free"),
    Group("serial robots", "revolute", serial=True),
    Group("masses over six decades", "revolute", decades=6.0),
    Group("floating bases, masses over six decades", "free", decades=6.0),
)


def deviation(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one - other).max() / np.abs(other).max())


def compared(group: Group, seed: int) -> Iterator[tuple[str, str, float]]:
    """The peer, what is compared, and the deviation, of one tree."""
    links = int(np.random.default_rng(seed).integers(*LINKS, endpoint=True))
    tree = random_tree(seed, links, group.root, group.decades, group.serial)
    ours = robot(tree)
    q, v, a = state(tree, seed)
    mass = ours.mass_matrix(q)
    unit = 1.0 / np.sqrt(np.diag(mass))
    square = np.outer(unit, unit)
    condition = float(np.linalg.cond(mass * square))
    # Velocities and accelerations of one in those units.
    v, a = v * unit / np.abs(unit).max(), a * unit / np.abs(unit).max()
    tau, acceleration = ours.inverse_dynamics(q, v, a), ours.forward_dynamics(q, v)
    yield "", "links", len(tree.members)
    yield "", "depth", tree.depth
    yield "", "coordinates", ours.n
    yield "", "condition", condition
    for name, make in (("Pinocchio", PinocchioTree), ("MuJoCo", MujocoTree)):
        theirs = make(tree)
        yield name, "inverse dynamics", deviation(tau * unit, theirs.inverse_dynamics(q, v, a) * unit)
        yield name, "mass matrix", deviation(mass * square, theirs.mass_matrix(q) * square)
        # Accelerations inherit the condition of the mass matrix in all codes; forces do not.
        left = theirs.inverse_dynamics(q, v, acceleration) * unit
        at_rest = theirs.inverse_dynamics(q, v, 0.0 * a) * unit
        yield name, FORCE_LEFT, float(np.abs(left).max() / np.abs(at_rest).max())
        yield name, ACCELERATION, deviation(acceleration / unit, theirs.forward_dynamics(q, v) / unit)
        if isinstance(theirs, PinocchioTree):
            names = ("dtau/dq", "dtau/dv", "dtau/da")
            pairs = zip(names, ours.tangent(q, v, a), theirs.tangent(q, v, a), strict=True)
            for what, own, other in pairs:
                yield name, what, deviation(own * square, other * square)


def measure(quick: bool) -> Iterator[dict]:
    """One row for each kind of trees: the largest deviations of all of them."""
    trees = QUICK_TREES if quick else TREES
    for number, group in enumerate(GROUPS):
        print(f"agreement: {group.name}", file=sys.stderr)
        largest: dict[str, dict[str, float]] = {}
        for seed in range(trees):
            for peer, what, value in compared(group, 1000 * number + seed):
                found = largest.setdefault(peer, {})
                found[what] = max(found.get(what, 0.0), value)
        sizes = largest.pop("")
        yield {
            "part": "agreement",
            "group": group.name,
            "trees": trees,
            "sizes": sizes,
            "largest": largest,
            "agrees": all(map(agrees, largest.values())),
        }


def agrees(deviations: dict[str, float]) -> bool:
    """To rounding."""
    return all(value <= ROUNDING for what, value in deviations.items() if what != ACCELERATION)


def away(quick: bool) -> Iterator[dict]:
    """The same at ever larger distances from the origin of the world, for one robot that floats."""
    tree = random_tree(3, 10, "free", 1.0)
    ours, peers = robot(tree), (("Pinocchio", PinocchioTree(tree)), ("MuJoCo", MujocoTree(tree)))
    q, v, a = state(tree, 3)
    for distance in DISTANCES[::2] if quick else DISTANCES:
        q[:3] = distance * np.array([0.6, 0.0, 0.8])
        row = {"part": "away", "distance": distance}
        for name, theirs in peers:
            mass = theirs.mass_matrix(q)
            unit = 1.0 / np.sqrt(np.diag(mass))
            square = np.outer(unit, unit)
            row[name] = {
                "inverse dynamics": deviation(
                    ours.inverse_dynamics(q, v, a) * unit, theirs.inverse_dynamics(q, v, a) * unit
                ),
                "mass matrix": deviation(ours.mass_matrix(q) * square, mass * square),
                ACCELERATION: deviation(
                    ours.forward_dynamics(q, v) / unit, theirs.forward_dynamics(q, v) / unit
                ),
            }
        yield row
