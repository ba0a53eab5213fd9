"""A tree of rigid bodies in Pinocchio."""

import numpy as np
import pinocchio
from foreign_coordinates import Coordinates, JointCoordinates
from pinocchio import SE3
from rigid_trees import Member, Tree, rotation
from rotation_vectors import angular_acceleration_at_constant_rate, angular_velocity, quaternion, rotated

Revolute, Prismatic = pinocchio.JointModelRevoluteUnaligned, pinocchio.JointModelPrismaticUnaligned

SAME = {
    "revolute": JointCoordinates(1),
    "prismatic": JointCoordinates(1),
    "cylindrical": JointCoordinates(2),
    "universal": JointCoordinates(2),
}


def scalar_last(phi: np.ndarray) -> np.ndarray:
    return np.roll(quaternion(phi), -1)


# A ball turns by a quaternion, with the angular velocity in the axes that turn.
SPHERICAL = JointCoordinates(3, scalar_last, angular_velocity, angular_acceleration_at_constant_rate)


def free_rate(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Both velocities in the axes of the body."""
    return np.concatenate([rotated(-q[3:], v[:3]), angular_velocity(q[3:], v[3:])])


def free_bias(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    linear, angular = np.split(free_rate(q, v), 2)
    turning = angular_acceleration_at_constant_rate(q[3:], v[3:])
    return np.concatenate([-np.cross(angular, linear), turning])


FREE = JointCoordinates(6, lambda q: np.concatenate([q[:3], scalar_last(q[3:])]), free_rate, free_bias)


def planar_rate(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """In the axes of the body."""
    c, s = np.cos(q[2]), np.sin(q[2])
    return np.array([c * v[0] + s * v[1], -s * v[0] + c * v[1], v[2]])


def planar_bias(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    x, y, turning = planar_rate(q, v)
    return np.array([turning * y, -turning * x, 0.0 * turning])


PLANAR = JointCoordinates(
    3, lambda q: np.array([q[0], q[1], np.cos(q[2]), np.sin(q[2])]), planar_rate, planar_bias
)
COORDINATES = SAME | {"spherical": SPHERICAL, "free": FREE, "planar": PLANAR}


def planar_axes(normal: np.ndarray) -> np.ndarray:
    """Columns x, y and the normal: x is the joint's less its part along the normal."""
    x = np.array([1.0, 0.0, 0.0]) - normal[0] * normal
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(normal, x), normal]).T


def composite(*parts: pinocchio.JointModel) -> pinocchio.JointModelComposite:
    joint = pinocchio.JointModelComposite()
    for part in parts:
        joint.addJoint(part)
    return joint


def joint_models(each: Member) -> list[pinocchio.JointModel]:
    """Pinocchio's joints of one of lissom's, from the parent to the child."""
    match each.kind:
        case "revolute":
            return [Revolute(each.axes[0])]
        case "prismatic":
            return [Prismatic(each.axes[0])]
        case "cylindrical":
            return [composite(Prismatic(each.axes[0]), Revolute(each.axes[0]))]
        case "universal":
            # Not `JointModelUniversal`, whose axes must be at a right angle. Not a composite joint either:
            # Pinocchio's derivatives of these are not those of its own inverse dynamics (4.1.0).
            return [Revolute(axis) for axis in each.axes]
        case "planar":
            return [pinocchio.JointModelPlanar()]
        case "spherical":
            return [pinocchio.JointModelSpherical()]
        case "free":
            return [pinocchio.JointModelFreeFlyer()]
    return []


class PinocchioTree:
    """What Pinocchio computes of a tree, in lissom's coordinates."""

    def __init__(self, tree: Tree) -> None:
        self.model = pinocchio.Model()
        self.model.gravity.linear = tree.gravity
        # Number of the joint that carries a member, and where its base is in the axes of that joint.
        places: list[tuple[int, SE3]] = []
        armature: list[float] = []
        for index, each in enumerate(tree.members):
            carrier, place = (0, SE3.Identity()) if each.parent is None else places[each.parent]
            place = place * SE3(rotation(each.orientation), each.position)
            turn = planar_axes(each.axes[0]) if each.kind == "planar" else np.eye(3)
            frame = SE3(turn, np.zeros(3))
            for number, joint in enumerate(joint_models(each)):
                carrier = self.model.addJoint(carrier, joint, place * frame, f"joint{index}.{number}")
                place = frame.inverse()
                armature += [each.armature] * joint.nv
            inertia = pinocchio.Inertia(each.mass, each.centre, each.inertia)
            self.model.appendBodyToJoint(carrier, inertia, place)
            places.append((carrier, place))
        self.model.armature = np.array(armature)
        self.data = self.model.createData()
        self.coordinates = Coordinates(
            [COORDINATES[each.kind] for each in tree.members if each.kind != "weld"]
        )

    def foreign(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> tuple[np.ndarray, ...]:
        """Configuration, velocities and accelerations of Pinocchio."""
        here = self.coordinates
        return here.configuration(q), here.rate(q, v), here.rate(q, a) + here.bias(q, v)

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        tau = pinocchio.rnea(self.model, self.data, *self.foreign(q, v, a))
        return self.coordinates.matrix(q).T @ tau

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        mass = pinocchio.crba(self.model, self.data, self.coordinates.configuration(q))
        upper = np.triu(mass)
        B = self.coordinates.matrix(q)
        return B.T @ (upper + np.triu(mass, 1).T) @ B

    def forward_dynamics(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        configuration, rate, _ = self.foreign(q, v, v)
        found = pinocchio.aba(self.model, self.data, configuration, rate, np.zeros(q.size))
        return self.coordinates.acceleration(q, v, found)

    def tangent(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> tuple[np.ndarray, ...]:
        there = self.foreign(q, v, a)
        tau = pinocchio.rnea(self.model, self.data, *there).copy()
        by_configuration, by_rate, mass = (
            np.array(matrix) for matrix in pinocchio.computeRNEADerivatives(self.model, self.data, *there)
        )
        mass = np.triu(mass) + np.triu(mass, 1).T
        return self.coordinates.tangents(q, v, a, tau, (by_configuration, by_rate, mass))
