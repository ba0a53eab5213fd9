"""A tree of rigid bodies in MuJoCo."""

from collections.abc import Iterable

import mujoco
import numpy as np
from foreign_coordinates import Coordinates, JointCoordinates
from rigid_trees import Member, Tree, rotation
from rotation_vectors import angular_acceleration_at_constant_rate, angular_velocity, quaternion

SLIDING = [np.array(axis, float) for axis in np.eye(3)]


# A quaternion, with the angular velocity in the axes that turn.
BALL = JointCoordinates(3, quaternion, angular_velocity, angular_acceleration_at_constant_rate)


def product(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Of quaternions w, x, y, z."""
    (a, u), (b, v) = ((each[0], each[1:]) for each in (one, other))
    return np.array([a * b - u @ v, *(a * v + b * u + np.cross(u, v))])


def free(each: Member) -> JointCoordinates:
    """Place in the world, and linear velocity in its axes; angular velocity in those of the body."""
    turn = rotation(each.orientation)

    def configuration(q: np.ndarray) -> np.ndarray:
        turned = product(each.orientation, quaternion(q[3:]))
        return np.concatenate([each.position + turn @ q[:3], turned])

    def rate(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.concatenate([turn @ v[:3], angular_velocity(q[3:], v[3:])])

    def bias(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.concatenate([0.0 * v[:3], angular_acceleration_at_constant_rate(q[3:], v[3:])])

    return JointCoordinates(6, configuration, rate, bias)


def numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def joint(each: Member) -> tuple[str, list[JointCoordinates]]:
    """What stands in the file for a joint, and its coordinates."""

    def line(kind: str, axis: np.ndarray) -> str:
        return f'<joint type="{kind}" axis="{numbers(axis)}" armature="{each.armature!r}"/>'

    slide, hinge = (lambda axis: line("slide", axis)), (lambda axis: line("hinge", axis))
    turning = '<joint type="ball"/>'
    match each.kind:
        case "revolute":
            return hinge(each.axes[0]), [JointCoordinates(1)]
        case "prismatic":
            return slide(each.axes[0]), [JointCoordinates(1)]
        case "cylindrical":
            return slide(each.axes[0]) + hinge(each.axes[0]), [JointCoordinates(2)]
        case "universal":
            return hinge(each.axes[0]) + hinge(each.axes[1]), [JointCoordinates(2)]
        case "planar":
            normal = each.axes[0]
            x = SLIDING[0] - normal[0] * normal
            x /= np.linalg.norm(x)
            lines = slide(x) + slide(np.cross(normal, x)) + hinge(normal)
            return lines, [JointCoordinates(3)]
        case "spherical":
            return turning, [BALL]
        case "free" if each.parent is None:
            return "<freejoint/>", [free(each)]
        case "free":
            # Those of MuJoCo hang on the world alone.
            return "".join(slide(axis) for axis in SLIDING) + turning, [JointCoordinates(3), BALL]
    return "", []


class MujocoTree:
    """What MuJoCo computes of a tree, in lissom's coordinates."""

    def __init__(self, tree: Tree) -> None:
        children: dict[int | None, list[int]] = {}
        for index, each in enumerate(tree.members):
            children.setdefault(each.parent, []).append(index)
        coordinates: list[JointCoordinates] = []

        def body(index: int) -> str:
            each = tree.members[index]
            lines, own = joint(each)
            coordinates.extend(own)
            return (
                f'<body pos="{numbers(each.position)}" quat="{numbers(each.orientation)}">{lines}'
                f'<inertial pos="{numbers(each.centre)}" quat="{numbers(each.principal_axes)}" '
                f'mass="{each.mass!r}" diaginertia="{numbers(each.principal)}"/>'
                f"{''.join(body(child) for child in children.get(index, []))}</body>"
            )

        bodies = "".join(body(index) for index in children[None])
        self.model = mujoco.MjModel.from_xml_string(
            f"""<mujoco><option gravity="{numbers(tree.gravity)}">
            <flag contact="disable" constraint="disable"/></option>
            <worldbody>{bodies}</worldbody></mujoco>"""
        )
        self.data = mujoco.MjData(self.model)
        self.coordinates = Coordinates(coordinates)

    def place(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> None:
        here = self.coordinates
        self.data.qpos[:] = here.configuration(q)
        self.data.qvel[:] = here.rate(q, v)
        self.data.qacc[:] = here.rate(q, a) + here.bias(q, v)

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        self.place(q, v, a)
        mujoco.mj_inverse(self.model, self.data)
        return self.coordinates.matrix(q).T @ self.data.qfrc_inverse

    def forward_dynamics(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        self.place(q, v, 0.0 * v)
        mujoco.mj_forward(self.model, self.data)
        return self.coordinates.acceleration(q, v, self.data.qacc)

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        self.place(q, 0.0 * q, 0.0 * q)
        mujoco.mj_forward(self.model, self.data)
        mass = np.zeros((q.size, q.size))
        mujoco.mj_fullM(self.model, self.data, mass)
        B = self.coordinates.matrix(q)
        return B.T @ mass @ B
