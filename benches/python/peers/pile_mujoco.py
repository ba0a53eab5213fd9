"""The pile in MuJoCo: each rod is a chain of capsules with three hinges and springs between each pair.

A link reaches from the middle of a piece of the rod to the middle of the next one, so that errors fall with
the square of the length of the pieces.
"""

from collections.abc import Iterable

import mujoco
import numpy as np
from pile_scene import (
    AREA,
    DENSITY,
    DISSIPATION,
    FRICTION,
    GRAVITY,
    LENGTH,
    RADIUS,
    RETARDATION_TIME,
    SECOND_MOMENT,
    SHEAR_MODULUS,
    STIFFNESS,
    TIMES,
    WALLS,
    YOUNG_MODULUS,
    Clock,
    Motion,
    Pile,
    State,
)

# MuJoCo's contacts are springs per mass. This one vibrates as fast as a rod that lies on a wall in lissom,
# and as one that lies along another rod.
RATE = np.sqrt(STIFFNESS / (DENSITY * AREA))
# Share of the acceleration that a constraint decides: one number, so that the spring is linear.
IMPEDANCE = 0.9
# A linear damper with the loss that lissom's law has for the speed of a fall by 20 mm: the rebound is
# 1 - 2/3 c v.
REBOUND = 1.0 - 2.0 / 3.0 * DISSIPATION * np.sqrt(2.0 * GRAVITY * 0.02)
DAMPING_RATIO = -np.log(REBOUND) / np.hypot(np.pi, np.log(REBOUND))


def numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def inertial(length: float) -> str:
    """Of a cylinder that begins at the origin of its body: capsules would count their round ends twice."""
    mass = DENSITY * AREA * length
    along = 0.5 * mass * RADIUS**2
    across = 0.5 * along + mass * length**2 / 12.0
    return (
        f'<inertial pos="{numbers([0.5 * length, 0, 0])}" mass="{mass!r}" '
        f'diaginertia="{numbers([along, across, across])}"/>'
    )


def hinges(link: int, length: float) -> str:
    """Those that stand for the torsion and the bending of the piece before a link."""
    bending = YOUNG_MODULUS * SECOND_MOMENT / length
    torsion = 2.0 * SHEAR_MODULUS * SECOND_MOMENT / length
    found = [
        f'<joint axis="{numbers(axis)}" stiffness="{stiffness!r}" '
        f'damping="{RETARDATION_TIME * stiffness!r}"/>'
        for axis, stiffness in zip(np.eye(3), (torsion, bending, bending), strict=True)
    ]
    # Turns about three axes one after the other twist a little; the next piece twists back.
    return "".join(found if link % 2 else reversed(found))


def chain(rod: int, start: np.ndarray, direction: np.ndarray, pieces: int) -> str:
    """The bodies of a rod, with sites at its ends and in its middle."""
    piece = LENGTH / pieces
    bounds = [0.0, *((index + 0.5) * piece for index in range(pieces)), LENGTH]
    middle = pieces // 2 if pieces % 2 == 0 else (pieces + 1) // 2
    bodies = ""
    for link in range(pieces + 1):
        length = bounds[link + 1] - bounds[link]
        if link:
            place = f'pos="{numbers([bounds[link] - bounds[link - 1], 0, 0])}"'
            joints = hinges(link, piece)
        else:
            across = np.cross([0.0, 0.0, 1.0], direction)
            place = f'pos="{numbers(start)}" xyaxes="{numbers([*direction, *across])}"'
            joints = "<freejoint/>"
        sites = {"start": (0, 0.0), "middle": (middle, 0.5 * LENGTH), "end": (pieces, LENGTH)}
        bodies += f'<body name="{rod}.{link}" {place}>{joints}{inertial(length)}'
        bodies += f'<geom type="capsule" size="{RADIUS!r}" fromto="{numbers([0, 0, 0, length, 0, 0])}"/>'
        for name, (at, along) in sites.items():
            if at == link:
                bodies += f'<site name="{rod}.{name}" pos="{numbers([along - bounds[link], 0, 0])}"/>'
    return bodies + "</body>" * (pieces + 1)


def plane(point: tuple[float, ...], normal: tuple[float, ...]) -> str:
    return f'<geom type="plane" size="1 1 1" pos="{numbers(point)}" zaxis="{numbers(normal)}"/>'


def model(pile: Pile, pieces: int, step: float) -> mujoco.MjModel:
    chains = (
        chain(rod, *placed, pieces)
        for rod, placed in enumerate(zip(pile.starts, pile.directions, strict=True))
    )
    # As in lissom, a rod does not touch itself.
    excluded = (
        f'<exclude body1="{rod}.{i}" body2="{rod}.{j}"/>'
        for rod in range(pile.rods)
        for i in range(pieces + 1)
        for j in range(i)
    )
    # With one impedance, -stiffness and -damping are those of the acceleration.
    solref = numbers([-(RATE**2), -2.0 * DAMPING_RATIO * RATE * IMPEDANCE])
    solimp = numbers([IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2])
    return mujoco.MjModel.from_xml_string(
        f"""<mujoco><option gravity="{numbers([0, 0, -GRAVITY])}" integrator="implicitfast"
        cone="elliptic" timestep="{step!r}"/><size memory="1G"/>
        <default><geom friction="{numbers([FRICTION, 0, 0])}" solref="{solref}" solimp="{solimp}"/></default>
        <worldbody>{"".join(plane(*wall) for wall in WALLS)}{"".join(chains)}</worldbody>
        <contact>{"".join(excluded)}</contact></mujoco>"""
    )


class Simulated:
    """A pile that has not moved yet."""

    code = "MuJoCo"

    def __init__(self, pile: Pile, pieces: int, step: float) -> None:
        self._model = model(pile, pieces, step)
        self._rods, self._links, self._step = pile.rods, pieces + 1, step
        self._data = mujoco.MjData(self._model)

    def _advance(self, until: float) -> None:
        mujoco.mj_step(self._model, self._data, nstep=round((until - self._data.time) / self._step))

    def _unstable(self) -> bool:
        return any(warning.number for warning in self._data.warning)

    def motion(self) -> Motion:
        """Up to the last of the times; infinite where the steps are unstable."""
        clock, points = Clock(), []
        for time in TIMES:
            with clock:
                self._advance(time)
            mujoco.mj_kinematics(self._model, self._data)
            points.append(self._data.site_xpos.reshape(self._rods, 3, 3).copy())
        if self._unstable():
            points = [np.full_like(point, np.inf) for point in points]
        return Motion(np.array(points), clock.seconds)

    def state(self, time: float) -> State:
        self._advance(time)
        mujoco.mj_forward(self._model, self._data)
        mujoco.mj_energyVel(self._model, self._data)
        starts = self._data.xpos[1:].reshape(self._rods, self._links, 3)
        ends = self._data.site_xpos.reshape(self._rods, 3, 3)[:, -1:]
        return State(np.concatenate([starts, ends], axis=1), float(self._data.energy[1]))
