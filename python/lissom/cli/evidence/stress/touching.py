"""Objects that fall, slide, are wedged or piled up: fast, stiff and sticky contacts, and contacts at ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from ...._lissom import Body, Free, Link, MotionResult, Prismatic, Revolute, Robot, Segment
from ....model.contacts import Ball, Box, Capsule, Contact, HalfSpace
from . import judge
from .cell import Cell, Group, Outcome

GRAVITY = 9.81

#: Largest excess of the energy over its initial value, relative to the largest kinetic energy: no force does
#: positive work.
ENERGY_TOLERANCE = 1e-2

#: Largest increase of the energy after a decrease, which indicates steps that are too long.
RISE_TOLERANCE = 1e-2

#: Largest error of the contact force on bodies at rest, relative to their weight, and largest speed and
#: acceleration of bodies at rest, in coordinates of metres and radians (curvatures times the length).
WEIGHT_TOLERANCE, REST, STILL = 2e-2, 5e-3, 0.05

#: Fixed steps in seconds; the first one is the default.
STEPS = {"10 ms": 1e-2, "1 ms": 1e-3, "0.1 ms": 1e-4}

LENGTH = 0.3
RUBBER: dict[str, Any] = {
    "radius": 0.01,
    "young_modulus": 1e6,
    "poisson_ratio": 0.45,
    "density": 1000.0,
    "modes": {"torsion": 1, "bend_y": 3, "bend_z": 3},
    "retardation_time": 0.01,
}
#: Weight of the rod, newtons.
WEIGHT = GRAVITY * 1000.0 * np.pi * 0.01**2 * LENGTH
FLOOR = HalfSpace()


@dataclass(frozen=True)
class Scene:
    """Objects that are released, and the duration of the motion."""

    robot: Robot
    time: float = 0.4
    start: dict[str, Any] = field(default_factory=dict)
    #: Force on floors and walls in the end, newtons; None if unknown.
    weight: float | None = WEIGHT


def free_rod(name: str, height: float, *, tilt: float = 0.0, y: float = 0.0, **changes: Any) -> Link:
    """A rod centred above the origin; if tilted, its tip is lower than its base."""
    segment = Segment(LENGTH, **(RUBBER | changes))
    place = (-0.5 * LENGTH * np.cos(tilt), y, height + 0.5 * LENGTH * np.sin(tilt))
    turn = (np.cos(0.5 * tilt), 0, np.sin(0.5 * tilt), 0)
    return Link(name, joint=Free(), rod=[segment], position=place, orientation=turn)


def thrown(link: Link, velocity: tuple[float, float, float], contact: Contact) -> Scene:
    """A free link with a velocity."""
    robot = Robot([link], contacts=[contact])
    v0 = np.zeros(robot.n)
    v0[:3] = velocity
    return Scene(robot, start={"v0": v0})


def impact(speed: float, tilt: float) -> Scene:
    """A rod that hits a floor."""
    low = 0.012 + 0.5 * LENGTH * np.sin(tilt)
    return thrown(free_rod("rod", low, tilt=tilt), (0, 0, -speed), Contact("rod", FLOOR, friction=0.5))


def sliding(friction: float) -> Scene:
    """A rod that lands obliquely and slides."""
    return thrown(free_rod("rod", 0.011), (0.7, 0.7, 0.0), Contact("rod", FLOOR, friction=friction))


def stiffness(value: float) -> Scene:
    """A rod that falls on a floor softer or stiffer than its material."""
    contact = Contact("rod", FLOOR, friction=0.5, stiffness=value)
    return Scene(Robot([free_rod("rod", 0.02, tilt=0.05)], contacts=[contact]))


def masses(ratio: float) -> Scene:
    """A ball with this multiple of the rod's mass is dropped on a rod that bridges two pegs."""
    radius = 0.03
    mass = ratio * WEIGHT / GRAVITY
    ball = Link(
        "ball",
        joint=Prismatic((0, 0, 1)),
        body=Body(mass, inertia=0.4 * mass * radius**2 * np.eye(3)),
        position=(0, 0, 0.021 + radius),
    )
    bars = [Capsule((x, -0.1, -0.01), (x, 0.1, -0.01), 0.01) for x in (-0.1, 0.1)]
    pegs = [Contact("rod", bar, friction=0.5, name=f"peg {i}") for i, bar in enumerate(bars)]
    rod = free_rod("rod", 0.0101, young_modulus=1e6 * max(1.0, ratio))
    contacts = [*pegs, Contact("rod", Ball("ball", radius), friction=0.5)]
    return Scene(Robot([rod, ball], contacts=contacts), weight=(1.0 + ratio) * WEIGHT)


def wedged(friction: float) -> Scene:
    """A rod falls between two walls that meet at 40 degrees."""
    slope = np.radians(70.0)
    walls = [HalfSpace((0, 0, 0), (0, side * np.sin(slope), np.cos(slope))) for side in (1, -1)]
    contacts = [Contact("rod", wall, friction=friction, name=f"wall {i}") for i, wall in enumerate(walls)]
    return Scene(Robot([free_rod("rod", 0.04, y=0.003)], contacts=contacts))


def taper() -> Scene:
    """A falling rod with a tip a third as thick as its base."""
    rod = free_rod("rod", 0.155, tilt=0.5 * np.pi, radius=(0.01, 0.0033))
    return Scene(Robot([rod], contacts=[Contact("rod", FLOOR, friction=0.5)]), weight=None)


def clamped(obstacle: Any) -> Scene:
    """A rod clamped at its base sinks onto the obstacle below."""
    rod = Link("rod", rod=[Segment(LENGTH, **RUBBER)])
    return Scene(Robot([rod], contacts=[Contact("rod", obstacle, friction=0.5)]), weight=None)


def box_of(name: str, half: tuple[float, float, float], density: float = 1000.0, **options: Any) -> Link:
    """A free box."""
    squares = np.square(half)
    mass = float(8.0 * density * np.prod(half))
    body = Body(mass, inertia=mass / 3.0 * np.diag(squares.sum() - squares))
    return Link(name, joint=Free(), body=body, **options)


def corner_first(speed: float) -> Scene:
    """A rotating box hits a floor with a corner."""
    half = (0.04, 0.03, 0.02)
    turn = (np.cos(0.4), np.sin(0.4) * 0.6, np.sin(0.4) * 0.8, 0)
    box = box_of("box", half, position=(0, 0, 0.06), orientation=turn)
    floor = Contact(Box((0, 0, 0), half, link="box"), FLOOR, stiffness=1e5, friction=0.5)
    robot = Robot([box], contacts=[floor])
    v0 = np.array([0.5, 0.0, -speed, 3.0, -5.0, 8.0])
    return Scene(robot, start={"v0": v0}, weight=float(box.body.mass) * GRAVITY if box.body else None)


def stacked(number: int) -> Scene:
    """Boxes dropped on each other and on a table, each one rotated relative to the one below."""
    half = (0.04, 0.03, 0.02)
    links = [
        box_of(
            f"box {i}",
            half,
            position=(0.004 * i, -0.003 * i, 0.021 + 0.042 * i),
            orientation=(np.cos(0.2 * i), 0, 0, np.sin(0.2 * i)),
        )
        for i in range(number)
    ]
    shapes = [Box((0, 0, -0.05), (0.2, 0.2, 0.05))]
    shapes += [Box((0, 0, 0), half, link=link.name) for link in links]
    contacts = [
        Contact(upper, lower, stiffness=1e5, friction=0.5, name=str(i))
        for i, (lower, upper) in enumerate(pairwise(shapes))
    ]
    weight = sum(link.body.mass for link in links if link.body) * GRAVITY
    return Scene(Robot(links, contacts=contacts), weight=float(weight))


def on_edge(speed: float) -> Scene:
    """A rotating box hits an edge of a fixed box with an edge."""
    half = (0.04, 0.03, 0.02)
    turn = (np.cos(0.4), np.sin(0.4) * 0.6, np.sin(0.4) * 0.8, 0)
    box = box_of("box", half, position=(0, 0, 0.06), orientation=turn)
    table = Box((-0.2, 0, -0.05), (0.2, 0.2, 0.05))
    contact = Contact(Box((0, 0, 0), half, link="box"), table, stiffness=1e5, friction=0.5)
    v0 = np.array([0.2, 0.0, -speed, 3.0, -5.0, 8.0])
    return Scene(Robot([box], contacts=[contact]), start={"v0": v0}, weight=None)


def on_board(ratio: float) -> Scene:
    """A rod is dropped on a free board, with this multiple of its mass, that bridges two pegs."""
    half = (0.15, 0.05, 0.005)
    mass = ratio * WEIGHT / GRAVITY
    board = box_of("board", half, mass / float(8.0 * np.prod(half)), position=(0, 0, 0.005))
    shape = Box((0, 0, 0), half, link="board")
    stiff = 1e5 * max(1.0, ratio)
    pegs = [
        Contact(
            Ball("board", 0.005, position=(x, y, 0)), FLOOR, stiffness=stiff, friction=0.5, name=f"{x} {y}"
        )
        for x in (-0.1, 0.1)
        for y in (-0.04, 0.04)
    ]
    contacts = [*pegs, Contact("rod", shape, friction=0.5, name="rod")]
    return Scene(
        Robot([board, free_rod("rod", 0.025, tilt=0.02)], contacts=contacts), weight=(1 + ratio) * WEIGHT
    )


def paddle(rate: float) -> Scene:
    """A freely rotating plate hits a rod at rest."""
    half = (0.1, 0.003, 0.2)
    plate = Link("plate", joint=Revolute((0, 0, 1)), body=box_of("plate", half).body)
    rod = free_rod("rod", 0.0, tilt=-0.5 * np.pi, y=0.05, radius=0.004)
    contact = Contact("rod", Box((0, 0, 0), half, link="plate"), friction=0.3)
    robot = Robot([plate, rod], contacts=[contact], gravity=(0, 0, 0))
    v0 = np.zeros(robot.n)
    v0[0] = rate
    return Scene(robot, start={"v0": v0}, weight=None)


def pile(count: int) -> Scene:
    """Rods dropped crosswise into a box."""
    side = 0.2
    walls = [FLOOR]
    walls += [HalfSpace((-side * x, -side * y, 0), (x, y, 0)) for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    links = []
    for i in range(count):
        angle = 0.5 * np.pi * (i % 2) + 0.1 * i
        links.append(
            Link(
                f"rod {i}",
                joint=Free(),
                rod=[Segment(LENGTH, **RUBBER)],
                position=(-0.5 * LENGTH * np.cos(angle), -0.5 * LENGTH * np.sin(angle), 0.012 + 0.022 * i),
                orientation=(np.cos(0.5 * angle), 0, 0, np.sin(0.5 * angle)),
            )
        )
    names = [link.name for link in links]
    contacts = [
        Contact(name, wall, friction=0.3, name=f"{name}, wall {k}")
        for name in names
        for k, wall in enumerate(walls)
    ]
    contacts += [
        Contact(a, b, friction=0.3, name=f"{a}, {b}") for i, a in enumerate(names) for b in names[i + 1 :]
    ]
    return Scene(Robot(links, contacts=contacts), time=0.15, weight=count * WEIGHT)


CASES: dict[str, Callable[[], Scene]] = {
    "flat at 1 m/s": partial(impact, 1.0, 0.0),
    "flat at 10 m/s": partial(impact, 10.0, 0.0),
    "askew at 10 m/s": partial(impact, 10.0, 0.3),
    "end first at 10 m/s": partial(impact, 10.0, 1.5),
    "slides without friction": partial(sliding, 0.0),
    "slides, friction 0.5": partial(sliding, 0.5),
    "slides, friction 5": partial(sliding, 5.0),
    "floor a hundredth as stiff": partial(stiffness, 1e4),
    "floor as stiff": partial(stiffness, 1e6),
    "floor 100 000 times as stiff": partial(stiffness, 1e11),
    "under a ball of a thousandth of its mass": partial(masses, 1e-3),
    "under a ball of its mass": partial(masses, 1.0),
    "under a ball of a thousand times its mass": partial(masses, 1e3),
    "wedged without friction": partial(wedged, 0.0),
    "wedged, friction 0.5": partial(wedged, 0.5),
    "wedged, friction 5": partial(wedged, 5.0),
    "on the tip of a taper": taper,
    "on a box that ends at the clamp": partial(clamped, Box((0.05, 0, -0.06), (0.05, 0.1, 0.045))),
    "on a peg at the clamp": partial(clamped, Capsule((0.001, -0.1, -0.0205), (0.001, 0.1, -0.0205), 0.01)),
    "box, corner first at 3 m/s": partial(corner_first, 3.0),
    "box, on the edge of another at 3 m/s": partial(on_edge, 3.0),
    "boxes, three on a fixed one": partial(stacked, 3),
    "on a free board of its mass": partial(on_board, 1.0),
    "hit by a paddle at 10 rad/s": partial(paddle, 10.0),
    "2 in a box": partial(pile, 2),
    "5 in a box": partial(pile, 5),
}


def touching(make: Callable[[], Scene], dt: float) -> Outcome:
    """Energy only decreases, and contact forces carry the weight of bodies at rest."""
    scene = make()
    robot = scene.robot
    motion = judge.run(robot, scene.time, dt=dt, **scene.start)
    if not motion.success:
        return judge.failure(motion)
    cost = motion.stats.nfev
    if not np.isfinite(motion.q).all():
        return Outcome("wrong", "the states are not finite", None, cost)
    energies = [robot.energy(q, v) for q, v in zip(motion.q, motion.v, strict=True)]
    total = np.array([energy.total for energy in energies])
    scale = max(energy.kinetic for energy in energies)
    gain = float(np.max(total - total[0])) / scale
    if gain > ENERGY_TOLERANCE:
        reason = f"the energy grows by {gain:.1e} of the largest kinetic one"
        if motion.doubt is not None:
            return Outcome("failed", f"{reason}, as the result says", gain, cost)
        return Outcome("wrong", reason, gain, cost)
    off = carried(scene, motion)
    if off > WEIGHT_TOLERANCE:
        return Outcome("wrong", f"at rest what carries it is off by {off:.1e} of the weight", off, cost)
    rise = float(np.max(total - np.minimum.accumulate(total))) / scale
    if rise > RISE_TOLERANCE:
        reason = (
            f"the step is too long: after a fall the energy rises by {rise:.1e} of the largest kinetic one"
        )
        return Outcome("failed", reason, rise, cost)
    return judge.right_motion(rise, cost, "energy, and what carries the weight")


def carried(scene: Scene, motion: MotionResult) -> float:
    """Relative difference between the contact force of all obstacles and the weight; zero while bodies
    move."""
    robot, q, v, a = scene.robot, motion.q[-1], motion.v[-1], motion.a[-1]
    moves = max(np.abs(v).max() / REST, np.abs(a).max() / STILL) * LENGTH > 1.0
    if scene.weight is None or moves:
        return 0.0
    fixed = [contact for contact in robot.contacts if getattr(contact.b, "link", contact.b) is None]
    names = [contact.name for contact in fixed]
    force = sum(robot.contact_forces(q, v, name=name)[5] for name in names)
    return float(abs(force / scene.weight - 1.0))


def group() -> Group:
    """Contact."""
    return Group(
        "contact",
        "Contact",
        "a soft rod",
        "step",
        [
            Cell(case, step, partial(touching, make, dt), quick=dt == 1e-3 and "box" not in case)
            for case, make in CASES.items()
            for step, dt in STEPS.items()
            # Many rods take too long with the shortest step.
            if dt >= 1e-3 or "in a box" not in case
        ],
        "Soft rods that fall on floors, pegs and each other, from rest or at up to 10 m/s. Nothing does "
        "work on them: the energy never exceeds that of the start, and where all has come to rest the "
        "obstacles carry the weight. A step that half resolves an impact gives back a part of what the step "
        "before took; that counts as failed.",
    )
