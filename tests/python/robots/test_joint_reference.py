"""The joints of the NumPy reference: Jacobians compared with derivatives of motions, and known angles."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from reference import joint
from reference.rod import hat

X, Y, Z = np.eye(3)
TILTED = np.array([1.0, -2.0, 0.5])
JOINTS = [
    joint.Weld(),
    joint.Revolute(TILTED),
    joint.Prismatic(TILTED),
    joint.Screw(TILTED, 0.7),
    joint.Cylindrical(TILTED),
    joint.Universal(TILTED, (0.3, 1.0, 1.0)),
    joint.Planar(TILTED),
    joint.Spherical(),
    joint.Free(),
]


def axial(skew):
    assert_allclose(skew, -skew.T, atol=1e-13)
    return np.array([skew[2, 1], skew[0, 2], skew[1, 0]])


@pytest.mark.parametrize("kind", JOINTS, ids=lambda kind: type(kind).__name__)
@pytest.mark.parametrize("size", [0.0, 1e-9, 1.0, 2.5])
def test_jacobians_are_derivatives_of_motions(kind, size):
    q, v, a = np.random.default_rng(kind.n).standard_normal((3, kind.n))
    q *= size
    R, _ = kind.motion(q)
    assert_allclose(R.T @ R, np.eye(3), atol=1e-14)
    S = kind.jacobian(q)
    assert S.shape == (6, kind.n)
    for k, unit in enumerate(np.eye(kind.n)):
        turned = R.T @ joint.along(lambda q: kind.motion(q)[0], q, unit)
        moved = R.T @ joint.along(lambda q: kind.motion(q)[1], q, unit)
        assert_allclose(S[:, k], [*axial(turned), *moved], atol=1e-13)
    # The rate of the twist compared with fourth-order differences in time.
    h = 1e-3
    times = h * np.array([-2, -1, 1, 2])
    twists = [kind.jacobian(q + t * v + t**2 / 2 * a) @ (v + t * a) for t in times]
    rate = np.array([1, -8, 8, -1]) @ np.reshape(twists, (4, 6)) / (12 * h)
    twist, twist_t = kind.twist(q, v, a[:, None])
    assert_allclose(twist, S @ v, atol=1e-14)
    assert_allclose(twist_t[:, 0], rate, atol=1e-8)


def test_every_joint_is_here():
    assert {type(kind) for kind in JOINTS} == set(joint.Joint.__subclasses__())


@pytest.mark.parametrize("angle", [0.0, 1e-8, 1e-3, 1.0, 3.0, np.pi, 5.0])
def test_rotation_vectors(angle):
    """Compared with SciPy's rotations and the closed form of the tangent."""
    phi = angle * joint.unit(TILTED)
    assert_allclose(joint.exp(phi), Rotation.from_rotvec(phi).as_matrix(), atol=1e-14)
    first, second = (0.5, 1 / 6) if angle < 1e-4 else ((1 - np.cos(angle)) / angle**2, 0)
    if angle >= 1e-4:
        second = (1 - np.sin(angle) / angle) / angle**2
    # Near zero the closed form has cancellation: rounding errors divided by the angle.
    closed = np.eye(3) - first * hat(phi) + second * hat(phi) @ hat(phi)
    assert_allclose(joint.tangent(phi), closed, atol=1e-12)


def test_motions_by_hand():
    half = np.sqrt(0.5)
    R, p = joint.Cylindrical((0, 0, 5)).motion(np.array([2.0, np.pi / 2]))
    assert_allclose(R @ X, Y, atol=1e-15)
    assert_allclose(p, [0, 0, 2])
    # About y first, then about the rotated z: the base's x goes to (0, 1, 0), its z to x.
    R, _ = joint.Universal(Y, 2 * Z).motion(np.array([np.pi / 2, np.pi / 2]))
    assert_allclose(R @ X, Y, atol=1e-15)
    assert_allclose(R @ Z, X, atol=1e-15)
    R, p = joint.Free().motion(np.array([1, 2, 3, 0, 0, np.pi / 4]))
    assert_allclose(R @ X, [half, half, 0], atol=1e-15)
    assert_allclose(p, [1, 2, 3])


@pytest.mark.parametrize(
    ("normal", "first", "second"),
    [(Z, X, Y), (-Z, X, -Y), (Y, X, -Z), (X, Y, Z), (-3 * X, Y, -Z), ((1, 0, 1), (1, 0, -1), (0, 1, 0))],
)
def test_axes_of_planar_joints(normal, first, second):
    R, p = joint.Planar(normal).motion(np.array([2.0, 3.0, np.pi / 2]))
    assert_allclose(p, 2 * joint.unit(first) + 3 * joint.unit(second), atol=1e-15)
    # A quarter turn about the normal rotates the first axis to the second.
    assert_allclose(R @ joint.unit(first), joint.unit(second), atol=1e-15)


@pytest.mark.parametrize("angle", [np.pi + 1e-6, 4.0, 2 * np.pi - 0.1, 2 * np.pi + 0.1, 9.0])
@pytest.mark.parametrize("kind", [joint.Spherical(), joint.Free()], ids=["spherical", "free"])
def test_wrapped_motions_are_the_same(kind, angle):
    q, v, a = np.random.default_rng(1).standard_normal((3, kind.n))
    q[kind.rotation_vector] *= angle / np.linalg.norm(q[kind.rotation_vector])
    wrapped = kind.wrapped(q, v, a)
    assert_allclose(np.linalg.norm(wrapped[0][kind.rotation_vector]), abs(angle - 2 * np.pi), rtol=1e-12)
    for old, new in zip(kind.motion(q), kind.motion(wrapped[0]), strict=True):
        assert_allclose(new, old, atol=1e-13)
    twists = kind.twist(q, v, a[:, None]), kind.twist(wrapped[0], wrapped[1], wrapped[2][:, None])
    for old, new in zip(*twists, strict=True):
        assert_allclose(new, old, rtol=1e-10, atol=1e-10)


def test_within_pi_nothing_is_wrapped():
    q, v, a = np.array([[0, 0, np.pi], [1, 2, 3], [4, 5, 6]])
    for old, new in zip((q, v, a), joint.Spherical().wrapped(q, v, a), strict=True):
        assert_allclose(new, old, rtol=0, atol=0)
