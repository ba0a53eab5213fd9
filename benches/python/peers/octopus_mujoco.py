"""The octopus in MuJoCo: an arm is a chain of rigid links with springs between them.

A link reaches from the middle of a piece of arm to the middle of the next one, the first one from the head:
the joints sit in mid-piece, so that errors fall with the square of the length of the pieces.
"""

from functools import cache

import mujoco
import numpy as np
from mujoco import rollout
from mujoco_trees import numbers
from octopus import END, OUTPUT_STEP, TIMES, Arm, Moment, described

# Gauss points of an integral along a link: exact for what a cone's mass and inertia are.
POINTS = np.polynomial.legendre.leggauss(6)


def integral(function, start: float, end: float) -> float:
    nodes, weights = POINTS
    half = 0.5 * (end - start)
    return float(half * (weights @ function(start + half * (1.0 + nodes))))


def radius(arm: Arm, x: np.ndarray) -> np.ndarray:
    base, tip = arm.radius
    return base + (tip - base) * x / arm.length


def inertial(arm: Arm, start: float, end: float) -> str:
    """Of a frustum whose base is at the origin of its body."""

    def section(x: np.ndarray) -> np.ndarray:
        return arm.density * np.pi * radius(arm, x) ** 2

    mass = integral(section, start, end)
    centre = integral(lambda x: section(x) * x, start, end) / mass
    across = integral(lambda x: section(x) * radius(arm, x) ** 2, start, end) / 4.0
    along = integral(lambda x: section(x) * (x - centre) ** 2, start, end)
    return (
        f'<inertial pos="{numbers([centre - start, 0, 0])}" mass="{mass!r}" '
        f'diaginertia="{numbers([2.0 * across, across + along, across + along])}"/>'
    )


def hinges(arm: Arm, start: float, end: float) -> str:
    """Those that stand for the bending of a piece of arm about y and z."""
    compliance = integral(lambda x: 4.0 / (arm.young_modulus * np.pi * radius(arm, x) ** 4), start, end)
    spring = f'stiffness="{1.0 / compliance!r}" damping="{arm.retardation_time / compliance!r}"'
    return "".join(f'<joint axis="{axis}" {spring}/>' for axis in ("0 1 0", "0 0 1"))


def shares(arm: Arm, moment: Moment, pieces: int) -> dict[int, float]:
    """How much of a moment acts on which link, so that it bends every piece as in the mean."""
    place = moment.at * pieces / arm.length
    before = int(place)
    parts = {before: 1.0 - (place - before), before + 1: place - before}
    return {link: part for link, part in parts.items() if part > 1e-9}


@cache
def model(pieces: int, integrator: str, step: float) -> tuple[mujoco.MjModel, tuple[Moment, ...]]:
    """And what drives its actuators, one after the other."""
    octopus = described()
    actuators, drives, sensors, arms = [], [], [], []
    for number, arm in enumerate(octopus.arms):
        length = arm.length / pieces
        bounds = [0.0, *((np.arange(pieces) + 0.5) * length), arm.length]
        opening, closing = "", ""
        for link in range(pieces + 1):
            start, end = bounds[link], bounds[link + 1]
            if link == 0:
                place = f'pos="{numbers(arm.position)}" quat="{numbers(arm.orientation)}"'
                joints = ""
            else:
                place = f'pos="{numbers([start - bounds[link - 1], 0, 0])}"'
                joints = hinges(arm, (link - 1) * length, link * length)
            opening += f'<body {place}>{joints}{inertial(arm, start, end)}<site name="{number}.{link}"/>'
            closing += "</body>"
        tip = f'<site name="{number}.tip" pos="{numbers([bounds[-1] - bounds[-2], 0, 0])}"/>'
        arms.append(opening + tip + closing)
        sensors.append(f'<framepos objtype="site" objname="{number}.tip"/>')
        for moment in arm.moments:
            for link, share in shares(arm, moment, pieces).items():
                gear = numbers([0, 0, 0, 0, share * moment.amplitude, 0])
                actuators.append(f'<motor site="{number}.{link}" gear="{gear}"/>')
                drives.append(moment)
    built = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option gravity="0 0 0" integrator="{integrator}" timestep="{step!r}">
        <flag contact="disable" constraint="disable"/></option><size memory="50M"/>
        <worldbody><body><freejoint/>
        <inertial pos="0 0 0" mass="{octopus.head_mass!r}" diaginertia="{numbers(octopus.head_inertia)}"/>
        {"".join(arms)}</body></worldbody>
        <actuator>{"".join(actuators)}</actuator><sensor>{"".join(sensors)}</sensor></mujoco>"""
    )
    return built, tuple(drives)


def tips(pieces: int, integrator: str, steps_per_output: int) -> np.ndarray:
    """Places of the tips of all arms at TIMES, of shape (4, 151, 3), in one call of MuJoCo's `rollout`."""
    step = OUTPUT_STEP / steps_per_output
    built, drives = model(pieces, integrator, step)
    data = mujoco.MjData(built)
    # Sensors tell what was before a step, so there is one more.
    count = round(END / step) + 1
    # A moment is constant in a step: what it is in the middle.
    middle = (np.arange(count)[:, None] + 0.5) * step
    frequency, phase = (
        np.array([getattr(drive, name) for drive in drives]) for name in ("frequency", "phase")
    )
    control = np.sin(2.0 * np.pi * frequency * middle + phase)
    size = mujoco.mj_stateSize(built, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    initial = np.zeros(size)
    mujoco.mj_getState(built, data, initial, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    _, sensed = rollout.rollout(built, data, initial[None], control[None])
    found = sensed[0, ::steps_per_output].reshape(TIMES.size, -1, 3).transpose(1, 0, 2)
    unstable = any(warning.number for warning in data.warning)
    return np.full_like(found, np.inf) if unstable else found
