"""The tendon arm in MuJoCo: rigid links with three hinges and springs between each pair, and four tendons.

A link reaches from the middle of a piece of the arm to the middle of the next one: the hinges sit in
mid-piece, so that errors fall with the square of the length of the pieces. Tendons are spatial ones, through
two points of each link, or fixed ones, whose lengths are linear in the angles: the same where nothing twists.
"""

from collections.abc import Callable

import mujoco
import numpy as np
import tendon_arm as arm
from mujoco_trees import numbers

AREA = np.pi * arm.RADIUS**2
SECOND_MOMENT = np.pi * arm.RADIUS**4 / 4.0
# Of a piece: how far from a hinge the points of a tendon are. Farther off its lever is too long where the
# hinge bends, nearer by the points beside a hinge would pass each other.
GAP = 0.1
AXES = "xyz"


def inertial(length: float) -> str:
    """Of a cylinder that begins at the origin of its body."""
    mass = arm.DENSITY * AREA * length
    along = 0.5 * mass * arm.RADIUS**2
    across = 0.5 * along + mass * length**2 / 12.0
    return (
        f'<inertial pos="{numbers([0.5 * length, 0, 0])}" mass="{mass!r}" '
        f'diaginertia="{numbers([along, across, across])}"/>'
    )


def hinges(link: int, length: float) -> str:
    """Those that stand for the torsion and the bending of the piece before a link."""
    bending = arm.YOUNG_MODULUS * SECOND_MOMENT / length
    torsion = 2.0 * arm.SHEAR_MODULUS * SECOND_MOMENT / length
    found = [
        f'<joint name="{name}.{link}" axis="{numbers(axis)}" stiffness="{stiffness!r}" '
        f'damping="{arm.RETARDATION_TIME * stiffness!r}"/>'
        for name, axis, stiffness in zip(AXES, np.eye(3), (torsion, bending, bending), strict=True)
    ]
    # Turns about three axes one after the other twist a little; the next piece twists back.
    return "".join(found if link % 2 else reversed(found))


def spatial(tendon: int, points: list[str]) -> str:
    sites = "".join(f'<site site="{tendon}.{point}"/>' for point in points)
    return f'<spatial name="{tendon}">{sites}</spatial>'


def fixed(tendon: int, pieces: int) -> str:
    """Its length changes by z times the angles about y, and by -y times those about z."""
    y, z = arm.OFFSETS[tendon]
    joints = "".join(
        f'<joint joint="{axis}.{link}" coef="{lever!r}"/>'
        for link in range(1, pieces + 1)
        for axis, lever in (("y", z), ("z", -y))
    )
    return f'<fixed name="{tendon}">{joints}</fixed>'


def model(pieces: int, kind: str, step: float) -> mujoco.MjModel:
    """Of so many pieces, with tendons of the kind "spatial" or "fixed"."""
    piece = arm.LENGTH / pieces
    bounds = [0.0, *((index + 0.5) * piece for index in range(pieces)), arm.LENGTH]
    bodies, points = "", []
    for link in range(pieces + 1):
        length = bounds[link + 1] - bounds[link]
        place = bounds[link] - bounds[max(link - 1, 0)]
        joints = hinges(link, piece) if link else ""
        bodies += f'<body pos="{numbers([place, 0, 0])}">{joints}{inertial(length)}'
        before, behind = (GAP * piece if hinge else 0.0 for hinge in (link, link < pieces))
        for end, along in (("base", before), ("tip", length - behind)):
            points.append(f"{link}.{end}")
            for tendon, offset in enumerate(arm.OFFSETS):
                bodies += f'<site name="{tendon}.{link}.{end}" pos="{numbers([along, *offset])}"/>'
    bodies += f'<site name="tip" pos="{numbers([length, 0, 0])}"/>' + "</body>" * (pieces + 1)
    numbered = range(len(arm.OFFSETS))
    tendons = (spatial(each, points) if kind == "spatial" else fixed(each, pieces) for each in numbered)
    motors = (f'<motor tendon="{each}" gear="-1"/>' for each in numbered)
    # Euler, which takes dampers of joints implicitly, too, has the same errors and run times here.
    return mujoco.MjModel.from_xml_string(
        f"""<mujoco><option gravity="{numbers(arm.GRAVITY)}" integrator="implicitfast" timestep="{step!r}">
        <flag contact="disable" constraint="disable"/></option><size memory="50M"/>
        <worldbody>{bodies}</worldbody>
        <tendon>{"".join(tendons)}</tendon><actuator>{"".join(motors)}</actuator></mujoco>"""
    )


def moved(
    built: mujoco.MjModel,
    data: mujoco.MjData,
    inputs: np.ndarray,
    see: Callable[[mujoco.MjModel, mujoco.MjData], None] = lambda built, data: None,
) -> np.ndarray:
    """Coordinates after every control step from the start; `see` is called after each."""
    mujoco.mj_resetData(built, data)
    substeps = round(arm.CONTROL_STEP / built.opt.timestep)
    q = np.empty((len(inputs), built.nq))
    for step, u in enumerate(inputs):
        data.ctrl[:] = u
        mujoco.mj_step(built, data, nstep=substeps)
        q[step] = data.qpos
        see(built, data)
    return q


def tips(built: mujoco.MjModel) -> np.ndarray:
    """Places of the tip after every control step, metres; infinite where the steps are unstable."""
    data = mujoco.MjData(built)
    found = []

    def see(built: mujoco.MjModel, data: mujoco.MjData) -> None:
        mujoco.mj_kinematics(built, data)
        found.append(data.site("tip").xpos.copy())

    moved(built, data, arm.tensions(), see)
    unstable = any(warning.number for warning in data.warning)
    return np.full((arm.STEPS, 3), np.inf) if unstable else np.array(found)
