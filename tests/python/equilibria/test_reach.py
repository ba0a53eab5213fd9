"""`Robot.reach`: inverse of `pose`, closed forms, unreachable targets, limits, preferences, errors."""

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import lissom
from reference.random_robots import random_states, robots, seeds
from reference.robot import build

few = settings(max_examples=15)
BODY = lissom.Body(1.0, centre=(0.1, 0.02, 0.01), inertia=(0.01, 0.01, 0.01))


def arm(lengths, axes, limits=None):
    """Rigid links along x, each on a hinge; the last frame is the hand."""
    links, stops = [], {"limits": limits, "limit_stiffness": 1e3} if limits else {}
    for i, axis in enumerate(axes):
        links.append(
            lissom.Link(
                f"link{i}",
                body=BODY,
                joint=lissom.Revolute(axis, **stops),
                parent=f"link{i - 1}" if i else None,
                position=(lengths[i - 1], 0, 0) if i else (0, 0, 0),
            )
        )
    hand = lissom.Link("hand", parent=f"link{len(axes) - 1}", position=(lengths[-1], 0, 0))
    return lissom.Robot([*links, hand])


PLANAR = arm([1.0, 0.7], [(0, 0, 1)] * 2)
SEVEN = arm([0.2, 0.4, 0.1, 0.3, 0.1, 0.2, 0.1], [(0, 0, 1), (0, 1, 0), (1, 0, 0)] * 2 + [(0, 1, 0)])


def soft(modes, length=0.3, **changes):
    return lissom.Segment(length, 0.01, 1e6, poisson_ratio=0.4, density=1000, modes=modes, **changes)


def off(robot, found, link, pose, X=None):
    """Distance of a link from its target."""
    here = robot.pose(found.q, X, link=link)
    turn = Rotation.from_matrix(pose[:3, :3].T @ here[:3, :3]).magnitude()
    return np.linalg.norm(here[:3, 3] - pose[:3, 3]), turn


def misfit(robot, q, link, pose):
    here = robot.pose(q, link=link)
    turn = Rotation.from_matrix(pose[:3, :3].T @ here[:3, :3]).as_rotvec()
    return (here[:3, 3] - pose[:3, 3]) / reach_of(robot), turn


def reach_of(robot):
    """Length equivalent to a radian."""
    reach = {}
    for link in robot.links:
        start = reach[link.parent] + np.linalg.norm(link.position) if link.parent else 0.0
        own = sum(part.length for part in link.rod) if link.rod else 0.0
        if link.body:
            gyration = np.sqrt(0.5 * np.trace(link.body.inertia) / link.body.mass)
            own = max(own, np.linalg.norm(link.body.centre) + gyration)
        reach[link.name] = start + own
    return max(reach.values()) or 1.0


@few
@given(robots(), seeds)
def test_poses_of_random_states_are_reached_or_it_is_said_honestly(description, seed):
    reference, robot = build(description), build(description, lissom)
    there, here, around = random_states(reference, seed)
    link = robot.links[-1].name
    pose = robot.pose(there, link=link)
    found = robot.reach(link, pose, q0=here)
    # Reported errors are correct.
    distance, turn = off(robot, found, link, pose)
    assert_allclose(found.position_error, distance, rtol=1e-6, atol=1e-12)
    assert_allclose(found.orientation_error, turn, rtol=1e-6, atol=1e-7)
    assert_allclose(found.pose, robot.pose(found.q, link=link), rtol=0, atol=1e-12)
    for linked, dofs in zip(reference.links, reference.joint_dofs, strict=True):
        phi = found.q[dofs][linked.joint.rotation_vector]
        assert np.linalg.norm(phi) <= np.pi * (1 + 1e-15)
    assert found.success == (found.status == "reached")
    if found.success:
        assert distance <= 1e-9 * reach_of(robot) * (1 + 1e-6)
        assert found.orientation_error <= 1e-9
    elif found.status == "nearest":
        # No small change reduces the error.
        least = np.linalg.norm(misfit(robot, found.q, link, pose))
        sizes = np.abs(around) / np.linalg.norm(around)
        for k in range(robot.n):
            for step in (1e-3, -1e-3):
                q = found.q.copy()
                q[k] += step * sizes[k]
                assert np.linalg.norm(misfit(robot, q, link, pose)) >= least * (1 - 1e-7)
    # Repeated calls give the same result bitwise.
    assert np.array_equal(found.q, robot.reach(link, pose, q0=here).q)


def test_most_random_poses_are_reached():
    rng = np.random.default_rng(0)
    states = rng.uniform(-2.5, 2.5, (60, 7))
    poses = SEVEN.pose(states, link="hand")
    found = [SEVEN.reach("hand", pose, q0=rng.uniform(-1, 1, 7)) for pose in poses]
    assert all(each.success for each in found)
    alone = [SEVEN.reach("hand", pose, restarts=0) for pose in poses]
    assert all(each.starts == 1 for each in alone)
    # From the straight arm, where many directions are singular.
    assert sum(each.success for each in alone) > 45


@given(st.floats(0.35, 1.65), st.floats(-3, 3), st.sampled_from([-1, 1]))
def test_a_planar_arm_finds_both_elbows(distance, direction, side):
    target = distance * np.array([np.cos(direction), np.sin(direction), 0])
    found = PLANAR.reach("hand", target, q0=[direction - 0.5 * side, side])
    assert found.status == "reached"
    bend = np.arccos((distance**2 - 1 - 0.49) / (2 * 0.7))
    shoulder = direction - np.arctan2(0.7 * np.sin(bend), 1 + 0.7 * np.cos(bend))
    expected = np.array([shoulder, bend])
    if np.sign(np.sin(found.q[1])) < 0:
        expected = np.array([2 * direction - shoulder, -bend])
    assert_allclose(np.exp(1j * found.q), np.exp(1j * expected), rtol=0, atol=1e-8)


def test_a_start_at_which_nothing_seems_to_help_is_left():
    """Stretched towards a nearer target: the gradient vanishes at a maximum of the error."""
    for target in ([1.2, 0, 0], [-1.2, 0, 0], [0.31, 0, 0]):
        found = PLANAR.reach("hand", target, q0=[0, 0], restarts=0)
        assert found.status == "reached", target
    straight = lissom.Rod([soft({"bend_y": 2, "bend_z": 2})])
    assert straight.reach("rod", [0.2, 0, 0], restarts=0).status == "reached"


@given(st.floats(-2.8, 2.8).filter(lambda angle: abs(angle) > 0.05))
def test_a_constant_curvature_reaches_its_point(angle):
    """One mode: the tip of an arc of that angle is at L (sin a, 1 - cos a) / a."""
    rod = lissom.Rod([soft({"bend_z": 1})])
    point = 0.3 * np.array([np.sin(angle), 1 - np.cos(angle), 0]) / angle
    found = rod.reach("rod", point)
    assert found.status == "reached"
    assert_allclose(found.q, angle / 0.3, rtol=1e-7)
    # Also in the middle of the rod.
    found = rod.reach("rod", rod.pose([angle / 0.3], 0.15)[:3, 3], X=0.15, q0=[0.1])
    assert_allclose(found.q, angle / 0.3, rtol=1e-7)


@given(st.floats(0.01, 1e3), st.floats(-3, 3))
def test_out_of_reach_the_nearest_point_is_that_of_the_sphere(beyond, direction):
    along = np.array([np.cos(direction), np.sin(direction), 0])
    found = PLANAR.reach("hand", (1.7 + beyond) * along, q0=[0.4, 1.0], restarts=0)
    assert (found.status, found.success) == ("nearest", False)
    assert_allclose(found.position_error, beyond, rtol=1e-12, atol=1e-12)
    assert_allclose(found.pose[:3, 3], 1.7 * along, rtol=0, atol=1e-6)
    assert found.nit < 40
    assert "not reached" in found.message
    # If the target is too near, the folded arm is nearest.
    near = PLANAR.reach("hand", 0.1 * along, q0=[0.4, 1.0])
    assert near.status == "nearest"
    assert_allclose(near.position_error, 0.2, rtol=1e-12)


def test_targets_beside_a_plane_and_beyond_a_soft_rod():
    above = PLANAR.reach("hand", [0.9, 0.5, 0.3])
    assert above.status == "nearest"
    assert_allclose(above.position_error, 0.3, rtol=1e-12)
    assert_allclose(above.pose[:2, 3], [0.9, 0.5], rtol=0, atol=1e-9)
    rod = lissom.Rod([soft({"bend_y": 3, "bend_z": 3})])
    far = rod.reach("rod", [0.7, 0, 0], q0=np.full(6, 0.8))
    assert far.status == "nearest"
    assert_allclose(far.position_error, 0.4, rtol=1e-12)
    assert_allclose(far.q, 0, rtol=0, atol=1e-5)


def test_weights_choose_what_is_given_up():
    """A point of the plane and an angle are three conditions for two joints."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("z", 2.0).as_matrix()
    pose[:2, 3] = 0.9, 0.4
    place = PLANAR.reach("hand", pose, orientation_weight=0)
    assert place.status == "reached"
    assert (place.orientation_error, place.position_error < 1e-8) == (0, True)
    turn = PLANAR.reach("hand", pose, position_weight=0)
    assert turn.status == "reached"
    assert_allclose(turn.q.sum() % (2 * np.pi), 2.0, rtol=1e-9)
    both = [PLANAR.reach("hand", pose, position_weight=weight) for weight in (0.1, 1, 10)]
    assert [each.status for each in both] == ["nearest"] * 3
    assert both[0].position_error > both[1].position_error > both[2].position_error > 1e-3
    assert both[0].orientation_error < both[1].orientation_error < both[2].orientation_error
    # Along one axis only.
    height = PLANAR.reach("hand", [9, 0.4, 9], position_weight=(0, 1, 0))
    assert height.status == "reached"
    assert_allclose(height.pose[1, 3], 0.4, rtol=0, atol=1e-8)


def test_a_point_beside_a_link_and_a_direction():
    target = [0.3, 0.5, 0.4]
    point = (0.05, 0.02, -0.1)
    found = SEVEN.reach("hand", target, point=point)
    assert found.success
    pose = SEVEN.pose(found.q, link="hand")
    assert_allclose(pose[:3, :3] @ point + pose[:3, 3], target, rtol=0, atol=1e-8)
    # The x axis along y, with any twist.
    wanted = Rotation.from_euler("z", 90, degrees=True).as_matrix()
    found = SEVEN.reach("hand", wanted, orientation_weight=(0, 1, 1), q0=np.full(7, 0.3))
    assert found.success
    assert_allclose(found.pose[:3, 0], [0, 1, 0], rtol=0, atol=1e-8)
    quaternion = Rotation.from_matrix(wanted).as_quat(scalar_first=True)
    turned = SEVEN.reach("hand", quaternion)
    assert_allclose(turned.pose[:3, :3], wanted, rtol=0, atol=1e-8)


def test_limits_of_joints_and_bounds_hold():
    limited = arm([1.0, 0.7], [(0, 0, 1)] * 2, limits=(-0.5, 0.8))
    target = [0.0, 1.5, 0.0]
    assert PLANAR.reach("hand", target).status == "reached"
    found = limited.reach("hand", target)
    assert (found.status, found.success) == ("at_limits", False)
    assert_allclose(found.q, 0.8, rtol=0, atol=0)
    assert found.at_limits == ["link0.angle", "link1.angle"]
    assert "link0.angle and link1.angle are held back" in found.message
    # A start outside the limits is projected; one inside may end at the other elbow.
    elbow = limited.reach("hand", PLANAR.pose([0.1, 0.5], link="hand")[:3, 3], q0=[9, -9])
    assert elbow.status == "reached"
    assert np.all((elbow.q >= -0.5) & (elbow.q <= 0.8))
    # Given bounds apply in addition to the limits of joints; fixed coordinates stay.
    fixed = limited.reach("hand", [1.0, 0.7, 0.0], bounds=([0.0, -9], [0.0, 9]), q0=[0, 0.1])
    assert fixed.status == "at_limits"
    assert_allclose(fixed.q, [0, 0.8], rtol=0, atol=0)
    free = PLANAR.reach("hand", [1.0, 0.7, 0.0], bounds=([0.0, -np.inf], [0.0, np.inf]), q0=[0, 0.1])
    assert_allclose(free.q, [0, np.pi / 2], rtol=0, atol=1e-8)


@given(seeds)
def test_random_arms_stay_within_limits(seed):
    rng = np.random.default_rng(seed)
    limited = arm([0.3] * 7, [(0, 0, 1), (0, 1, 0), (1, 0, 0)] * 2 + [(0, 1, 0)], limits=(-1.2, 1.5))
    pose = limited.pose(rng.uniform(-1.2, 1.5, 7), link="hand")
    found = limited.reach("hand", pose)
    assert np.all((found.q >= -1.2) & (found.q <= 1.5))
    assert found.status in ("reached", "nearest", "at_limits")
    distance, turn = off(limited, found, "hand", pose)
    assert (distance < 1e-8 and turn < 1e-7) == found.success


def energy_of(rod):
    return lambda q: rod.energy(q, np.zeros(rod.n)).elastic


def least_energy(rod, target, start, link="rod"):
    """SciPy's minimum, with the gradient of the energy at zero gravity and the Jacobian of the pose."""
    stiffness = rod.tangent(np.zeros(rod.n), np.zeros(rod.n), np.zeros(rod.n))[0]
    scale = np.abs(stiffness).max()
    found = minimize(
        lambda q: q @ stiffness @ q / (2 * scale),
        start,
        jac=lambda q: stiffness @ q / scale,
        constraints={
            "type": "eq",
            "fun": lambda q: rod.pose(q, link=link)[:3, 3] - target,
            "jac": lambda q: rod.jacobian(q, link=link)[3:],
        },
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 500},
    )
    assert found.success, found
    return found.x


@pytest.mark.parametrize("target", [(0.22, 0.12, 0.08), (0.1, -0.15, 0.1), (0.28, 0.03, 0.0)])
def test_of_all_shapes_the_one_with_least_energy(target):
    rod = lissom.Rod([soft({"bend_y": 3, "bend_z": 3, "torsion": 2, "stretch": 1})], gravity=(0, 0, 0))
    any_shape = rod.reach("rod", target)
    found = rod.reach("rod", target, prefer="energy")
    assert found.status == any_shape.status == "reached"
    energy = energy_of(rod)
    assert energy(found.q) <= energy(any_shape.q) * (1 + 1e-9)
    expected = least_energy(rod, target, found.q + 0.01 * np.arange(rod.n))
    assert_allclose(energy(found.q), energy(expected), rtol=1e-7)
    assert energy(found.q - expected) < 1e-6 * energy(expected)
    # The gradient is a linear combination of the rows of the Jacobian.
    gradient = rod.inverse_dynamics(found.q, np.zeros(rod.n), np.zeros(rod.n))
    jacobian = rod.jacobian(found.q, link="rod")[3:]
    rest = gradient - jacobian.T @ np.linalg.lstsq(jacobian.T, gradient, rcond=None)[0]
    sizes = np.where(np.arange(rod.n) < rod.n - 1, 1 / 0.3, 1)
    assert np.linalg.norm(rest * sizes) < 1e-6 * np.linalg.norm(gradient * sizes)


def test_springs_of_joints_count_and_have_a_rest():
    """Two sliders in series with the sum 0.3: the forces of their springs become equal."""
    slide = [
        lissom.Prismatic((1, 0, 0), stiffness=2.0, rest=0.05),
        lissom.Prismatic((1, 0, 0), stiffness=6.0, rest=-0.01),
    ]
    links = [
        lissom.Link(name, body=BODY, joint=joint, parent=parent)
        for name, joint, parent in zip("ab", slide, [None, "a"], strict=True)
    ]
    robot = lissom.Robot(links)
    found = robot.reach("b", [0.3, 0, 0], prefer="energy")
    force = (0.3 - 0.04) / (1 / 2 + 1 / 6)
    assert_allclose(found.q, [0.05 + force / 2, -0.01 + force / 6], rtol=1e-8)


def test_the_nearest_to_the_start():
    rng = np.random.default_rng(3)
    q0 = rng.uniform(-1, 1, 7)
    target = SEVEN.pose(rng.uniform(-1, 1, 7), link="hand")[:3, 3]
    found = SEVEN.reach("hand", target, q0=q0, prefer="start")
    assert found.status == "reached"

    def constrained(weights):
        return minimize(
            lambda q: weights @ (q - q0) ** 2 / 2,
            found.q + 0.01,
            jac=lambda q: weights * (q - q0),
            constraints={
                "type": "eq",
                "fun": lambda q: SEVEN.pose(q, link="hand")[:3, 3] - target,
                "jac": lambda q: SEVEN.jacobian(q, link="hand")[3:],
            },
            method="SLSQP",
            options={"ftol": 1e-15, "maxiter": 500},
        ).x

    assert_allclose(found.q, constrained(np.ones(7)), rtol=0, atol=1e-5)
    weights = np.array([100.0, 1, 1, 1, 1, 1, 0])
    found = SEVEN.reach("hand", target, q0=q0, prefer=weights)
    assert found.status == "reached"
    assert_allclose(found.q[:6], constrained(weights)[:6], rtol=0, atol=1e-4)
    # Also within limits.
    bounds = (q0 - 0.3, q0 + 0.6)
    within = SEVEN.reach("hand", target, q0=q0, prefer="start", bounds=bounds)
    if within.success:
        assert np.all((within.q >= bounds[0]) & (within.q <= bounds[1]))


def test_least_energy_within_bounds():
    rod = lissom.Rod([soft({"bend_y": 4})], gravity=(0, 0, 0))
    target = (0.2, 0, -0.15)
    free = rod.reach("rod", target, prefer="energy")
    limit = 0.8 * abs(free.q[0])
    bounds = ([-limit, -np.inf, -np.inf, -np.inf], [limit, np.inf, np.inf, np.inf])
    held = rod.reach("rod", target, prefer="energy", bounds=bounds)
    assert free.status == held.status == "reached"
    assert_allclose(abs(held.q[0]), limit, rtol=1e-12)
    energy = energy_of(rod)
    assert energy(held.q) > energy(free.q)
    # As if the coordinate had been fixed at this value from the start.
    fixed = ([held.q[0], -np.inf, -np.inf, -np.inf], [held.q[0], np.inf, np.inf, np.inf])
    again = rod.reach("rod", target, prefer="energy", bounds=fixed)
    assert_allclose(energy(again.q), energy(held.q), rtol=1e-8)


def hand():
    finger = soft({"bend_y": 2, "bend_z": 2, "torsion": 1}, length=0.1)
    links = [lissom.Link("palm", body=BODY, joint=lissom.Free())]
    for i in range(3):
        angle = 2 * np.pi * i / 3
        links.append(
            lissom.Link(
                f"finger{i}",
                rod=[finger],
                parent="palm",
                position=(0, 0.04 * np.cos(angle), 0.04 * np.sin(angle)),
            )
        )
    return lissom.Robot(links)


def test_three_fingertips_at_once():
    robot = hand()
    rng = np.random.default_rng(4)
    sizes = np.concatenate([[0.1] * 3, [0.5] * 3, np.tile([2, 6, 3, 6, 3], 3)])
    there = sizes * rng.uniform(-1, 1, robot.n)
    names = [f"finger{i}" for i in range(3)]
    points = {name: robot.pose(there, link=name)[:3, 3] for name in names}
    found = robot.reach(points)
    assert found.status == "reached"
    assert found.position_error.shape == (3,)
    assert found.pose.shape == (3, 4, 4)
    for i, name in enumerate(names):
        assert_allclose(robot.pose(found.q, link=name)[:3, 3], points[name], rtol=0, atol=1e-9)
        assert_allclose(found.pose[i], robot.pose(found.q, link=name), rtol=0, atol=1e-15)
    # A grasp of an object with the palm fixed, and with minimum energy of the fingers.
    held = lissom.Target("palm", robot.pose(there, link="palm"))
    targets = [held, *(lissom.Target(name, points[name], X=0.1) for name in names)]
    grasp = robot.reach(targets, prefer="energy")
    assert grasp.status == "reached"
    zeros = np.zeros(robot.n)
    assert robot.energy(grasp.q, zeros).elastic <= robot.energy(there, zeros).elastic * (1 + 1e-9)
    # An unreachable target leaves an error at all of them.
    apart = robot.reach({"finger0": [1, 0, 0], "finger1": [-1, 0, 0]})
    assert apart.status == "nearest"
    assert np.all(apart.position_error > 0.5)


def test_a_floating_robot_turns_as_far_as_it_takes():
    """Rotation vectors beyond half a turn are replaced, and a start just before half a turn may pass it."""
    robot = lissom.Robot([lissom.Link("ball", body=BODY, joint=lissom.Spherical())])
    start = np.array([0, 0, 3.1])
    for angle in (3.3, -0.1, 6.2):
        wanted = Rotation.from_rotvec([0.0, 0.02, angle])
        found = robot.reach("ball", wanted.as_matrix(), q0=start, restarts=0)
        assert found.status == "reached", angle
        assert np.linalg.norm(found.q) <= np.pi
        assert (Rotation.from_rotvec(found.q.copy()).inv() * wanted).magnitude() < 1e-8
    # Just on the other side: the way is short, and the discontinuity does not matter.
    near = robot.reach("ball", Rotation.from_rotvec([0, 0, 3.2]).as_matrix(), q0=start, prefer="start")
    assert near.status == "reached"
    assert_allclose(near.q, [0, 0, 3.2 - 2 * np.pi], rtol=0, atol=1e-8)
    # At exactly half a turn all ways are equally good.
    assert robot.reach("ball", np.diag([1.0, -1, -1])).status == "reached"


def test_bases_that_move_are_reached_at_a_time():
    motion = lissom.BaseMotion(translation=lambda t: (0, 0, t))
    rod = lissom.Rod([soft({"bend_y": 2, "bend_z": 2})], base_motion=motion)
    found = rod.reach("rod", [0.2, 0.1, 2.05], t=2.0)
    assert found.status == "reached"
    assert_allclose(rod.pose(found.q, t=2.0)[:3, 3], [0.2, 0.1, 2.05], rtol=0, atol=1e-9)
    with pytest.raises(TypeError, match="t: got none"):
        rod.reach("rod", [0.2, 0.1, 2.05])


def test_joints_that_are_driven_follow():
    finger = {"body": lissom.Body(0.1, centre=(0.1, 0, 0.01))}
    mimic = lissom.Revolute((0, 0, 1), mimic=lissom.Mimic("left", multiplier=-1.0))
    sway = lissom.Prismatic((0, 0, 1), motion=lambda t: 0.1 * t)
    robot = lissom.Robot(
        [
            lissom.Link("lift", body=BODY, joint=sway),
            lissom.Link("left", joint=lissom.Revolute((0, 0, 1)), parent="lift", **finger),
            lissom.Link("right", joint=mimic, parent="lift", **finger),
        ]
    )
    assert robot.n == 1
    found = robot.reach("right", [0.1 * np.cos(0.4), -0.1 * np.sin(0.4), 0.2], point=(0.1, 0, 0), t=2.0)
    assert found.status == "reached"
    assert_allclose(found.q, 0.4, rtol=0, atol=1e-8)


def test_at_the_edge_of_reach_it_is_reached_but_there_is_nothing_to_prefer():
    edge = [1.7, 0, 0]
    found = PLANAR.reach("hand", edge, q0=[0.3, 0.4])
    assert found.status == "reached"
    settled = PLANAR.reach("hand", edge, q0=[0.3, 0.4], prefer="start")
    assert settled.status in ("reached", "not_settled")
    assert settled.position_error < 1e-8
    assert settled.success == (settled.status == "reached")


def test_rods_that_would_have_to_turn_inside_out_are_not_followed():
    rod = lissom.Rod([soft({"stretch": 1})])
    found = rod.reach("rod", [-0.1, 0, 0])
    assert (found.status, found.success) == ("inverted", False)
    assert "turned inside out" in found.message
    rod.check_shape(found.q)


def test_searches_end():
    found = SEVEN.reach("hand", [0.2, 0.4, 0.3], max_iter=1, restarts=0)
    assert (found.status, found.nit, found.starts) == ("iteration_limit", 1, 1)
    nothing = lissom.Robot([lissom.Link("fixed", body=BODY)])
    assert nothing.reach("fixed", [0, 0, 0]).status == "reached"
    stuck = nothing.reach("fixed", [0, 0, 1])
    assert (stuck.status, stuck.position_error) == ("nearest", 1)


def test_results_are_plain_records():
    found = SEVEN.reach("hand", [0.2, 0.4, 0.3])
    for other in (copy.deepcopy(found), pickle.loads(pickle.dumps(found))):
        assert np.array_equal(other.q, found.q)
        assert np.array_equal(other.pose, found.pose)
        assert (other.status, other.position_error) == (found.status, found.position_error)
    assert isinstance(found.position_error, float)
    with pytest.raises(ValueError, match="read-only"):
        found.q[0] = 1
    assert "reached" in repr(found)
    target = lissom.Target("hand", np.eye(4), X=None)
    assert target == lissom.Target("hand", np.eye(4).tolist())
    assert pickle.loads(pickle.dumps(target)) == target


ROD = lissom.Rod([soft({"bend_y": 2})])
SHEARED = np.eye(4)
SHEARED[:2, 1] = 0.6, 0.8
MIRROR = np.diag([1.0, 1, -1, 1])
REFUSED = {
    r"link: got 'hnad', expected one of the links: .*; did you mean 'hand'\?": lambda: SEVEN.reach(
        "hnad", [0, 0, 0]
    ),
    r"link\['hnad'\]: got 'hnad'.*did you mean 'hand'": lambda: SEVEN.reach({"hnad": [0, 0, 0]}),
    "pose: expected a homogeneous matrix .* got an array of shape \\(2,\\)": lambda: SEVEN.reach(
        "hand", np.zeros(2)
    ),
    r"orientation: got columns 0 and 1 with the scalar product 0.6, expected a rotation matrix": lambda: (
        SEVEN.reach("hand", SHEARED)
    ),
    r"orientation: got a column 0 of length 2": lambda: SEVEN.reach("hand", 2 * np.eye(3)),
    r"orientation: got a reflection": lambda: SEVEN.reach("hand", MIRROR),
    r"pose\[3\]: got \(0, 0, 0, 2\), expected \(0, 0, 0, 1\)": lambda: SEVEN.reach(
        "hand", np.diag([1, 1, 1, 2])
    ),
    r"pose: got a quaternion of norm 2": lambda: SEVEN.reach("hand", [2.0, 0, 0, 0]),
    r"position\[1\]: got NaN": lambda: SEVEN.reach("hand", [0, np.nan, 0]),
    r"orientation\[0\]\[0\]: got inf": lambda: SEVEN.reach("hand", np.diag([np.inf, 1, 1])),
    r"X: got 0.1 on 'hand', which has no rod": lambda: SEVEN.reach("hand", [0, 0, 0], X=0.1),
    r"X: got 0.5, expected an arc length in \[0, 0.3\]": lambda: ROD.reach("rod", [0, 0, 0], X=0.5),
    r"point\[0\]: got NaN": lambda: ROD.reach("rod", [0, 0, 0], point=(np.nan, 0, 0)),
    r"position_weight\[2\]: got -1": lambda: ROD.reach("rod", [0, 0, 0], position_weight=(1, 1, -1)),
    r"position_weight: got no weight at all": lambda: ROD.reach("rod", [0, 0, 0], position_weight=0),
    r"position_weight: expected a number or three": lambda: ROD.reach(
        "rod", [0, 0, 0], position_weight=(1, 1)
    ),
    r"q0: expected 2 values, got 1": lambda: ROD.reach("rod", [0, 0, 0], q0=[0]),
    r"q0\[1\]: got NaN": lambda: ROD.reach("rod", [0, 0, 0], q0=[0, np.nan]),
    r"q0: got a rod that": lambda: ROD.reach("rod", [0, 0, 0], q0=[0, 1e6]),
    r"bounds\[0\]: expected 2 values, got 3": lambda: ROD.reach("rod", [0, 0, 0], bounds=([0] * 3, 1)),
    r"bounds\[:, 0\]: got 1 to -1 for rod.bend_y\[0\]": lambda: ROD.reach("rod", [0, 0, 0], bounds=(1, -1)),
    r"bounds\[:, 0\]: got NaN to 1": lambda: ROD.reach("rod", [0, 0, 0], bounds=(np.nan, 1)),
    r'prefer: got "ease", expected "start", "energy"': lambda: ROD.reach("rod", [0, 0, 0], prefer="ease"),
    r'prefer: got "energy", expected something elastic': lambda: SEVEN.reach(
        "hand", [0, 0, 0], prefer="energy"
    ),
    r"prefer\[1\]: got -1": lambda: ROD.reach("rod", [0, 0, 0], prefer=[1, -1]),
    r"prefer: got zeros": lambda: ROD.reach("rod", [0, 0, 0], prefer=[0, 0]),
    r"tol: got 0": lambda: ROD.reach("rod", [0, 0, 0], tol=0),
    r"max_iter: got -1": lambda: ROD.reach("rod", [0, 0, 0], max_iter=-1),
    r"restarts: got 1000000": lambda: ROD.reach("rod", [0, 0, 0], restarts=10**6),
    r"targets: got none": lambda: ROD.reach([]),
    r"pose: leave out pose, X, point and weights": lambda: ROD.reach({"rod": [0, 0, 0]}, X=0.1),
    r"link\[1\].X: got 0.1 on 'hand'": lambda: SEVEN.reach(
        [lissom.Target("hand", [0, 0, 0]), lissom.Target("hand", [0, 0, 0], X=0.1)]
    ),
    r"link\['rod'\].position\[0\]: got NaN": lambda: ROD.reach({"rod": [np.nan, 0, 0]}),
    r"link\['rod'\].pose: expected a homogeneous": lambda: ROD.reach({"rod": [[0.0]]}),
    r"pose\[3\]: got \(0, 0, 0, 0\)": lambda: lissom.Target("rod", np.zeros((4, 4))),
}


def test_one_target_serves_as_a_sequence_of_it():
    segment = lissom.Segment(0.3, 0.01, 1e6, poisson_ratio=0.4, density=1e3, modes={"bend_y": 2, "bend_z": 2})
    robot = lissom.Robot([lissom.Link("arm", rod=[segment])])
    target = lissom.Target("arm", [0.25, 0.05, 0.1], orientation_weight=0)
    one, several = robot.reach(target), robot.reach([target])
    assert one.success
    np.testing.assert_array_equal(one.q, several.q)
    np.testing.assert_allclose(robot.pose(one.q, link="arm")[:3, 3], target.pose, atol=1e-8)
    assert list(target) == [target]


@pytest.mark.parametrize("message", REFUSED)
def test_what_makes_no_sense_is_refused(message):
    with pytest.raises(ValueError, match=message):
        REFUSED[message]()


@pytest.mark.parametrize(
    ("message", "call"),
    [
        ("pose: expected where the link shall be, got None", lambda: ROD.reach("rod")),
        ("link: expected the name of a link, a mapping", lambda: ROD.reach(3)),
        ("link: expected the name of a link, a mapping", lambda: ROD.reach(["rod"])),
        ("link: expected names of links", lambda: ROD.reach({3: [0, 0, 0]})),
        ("bounds: expected lower and upper", lambda: ROD.reach("rod", [0, 0, 0], bounds=3)),
        ("bounds: expected lower and upper", lambda: ROD.reach("rod", [0, 0, 0], bounds=(1, 2, 3))),
        ("pose", lambda: ROD.reach("rod", "there")),
        ("link: expected the name", lambda: lissom.Target(3, [0, 0, 0])),
        ("X: expected a real number", lambda: lissom.Target("rod", [0, 0, 0], X="tip")),
    ],
)
def test_what_is_no_number_is_refused(message, call):
    with pytest.raises(TypeError, match=message):
        call()


@pytest.mark.parametrize("weights", [(1, 100), (1, 1000), (1e4, 1), (1e160, 1), (1e-12, 1)])
def test_what_can_be_reached_is_reached_whatever_counts_how_much(weights):
    random = np.random.default_rng(3)
    for _ in range(5):
        wanted = SEVEN.pose(random.uniform(-2, 2, SEVEN.n), link="hand")
        found = SEVEN.reach("hand", wanted, position_weight=weights[0], orientation_weight=weights[1])
        assert found.success, found.message
        assert_allclose(SEVEN.pose(found.q, link="hand"), wanted, atol=1e-8)


def test_weights_decide_between_what_cannot_be_had_together():
    """Two targets half a metre apart for one point: the mean, weighted by the squares of the weights."""
    targets = [
        lissom.Target("hand", (x, 0.5, 0), position_weight=weight) for x, weight in ((0.8, 2), (1.3, 1))
    ]
    found = PLANAR.reach(targets)
    assert found.status == "nearest"
    assert_allclose(PLANAR.pose(found.q, link="hand")[:3, 3], (0.9, 0.5, 0), atol=1e-6)
