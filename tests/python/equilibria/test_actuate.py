"""`actuate`: inverse of `statics`, closed forms, minimal inputs, limits, unreachable targets, errors."""

import copy
import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import lissom

RADIUS, LENGTH, MODULUS, OFFSET = 2e-3, 0.2, 1e9, 0.01
STIFFNESS = MODULUS * np.pi / 4 * RADIUS**4


def tendon(name, angle, default=0.0, along=None, **more):
    offset = (OFFSET * np.cos(angle), OFFSET * np.sin(angle))
    given = {"tension": lissom.Input(name, default)} | more
    return lissom.Tendon(name, [lissom.Along(offset=offset, along=along)], **given)


def tendon_at(name, angle, offset):
    part = lissom.Along("rod", offset=(offset * np.cos(angle), offset * np.sin(angle)))
    return lissom.Tendon(name, [part], tension=lissom.Input(name, 0.0))


def finger(actuators, modes=None, **more):
    modes = modes or {"bend_y": 4, "bend_z": 4}
    segment = lissom.Segment(LENGTH, RADIUS, MODULUS, 4e8, 1200, modes)
    return lissom.Rod([segment], actuators=actuators, **{"gravity": (0, 0, 0)} | more)


def three(default=1.0, **more):
    """Three tendons around a rod with weight."""
    return finger(
        [tendon(name, 2 * np.pi * k / 3, default) for k, name in enumerate("abc")],
        gravity=(0, 0, -9.81),
        **more,
    )


def six(default=1.0):
    """Three tendons to the middle of a rod, and three to its tip."""
    near = [tendon(f"near{k}", 2 * np.pi * k / 3, default, along=(0, LENGTH / 2)) for k in range(3)]
    far = [tendon(f"far{k}", 2 * np.pi * k / 3 + 0.5, default) for k in range(3)]
    return finger(near + far, gravity=(0, 0, -9.81))


def planar():
    """Two antagonistic tendons."""
    return finger([tendon("up", np.pi / 2, 5.0), tendon("down", -np.pi / 2, 3.0)], {"bend_y": 3})


def height(z):
    return lissom.Target("rod", (0, 0, z), position_weight=(0, 0, 1))


def raised(tension):
    """Height of the tip of the arc to which a tendon bends the rod."""
    curvature = tension * OFFSET / STIFFNESS
    return (1 - np.cos(curvature * LENGTH)) / curvature


def test_the_tension_of_an_arc():
    rod = finger([tendon("up", np.pi / 2, 1.0)], {"bend_y": 3})
    found = lissom.actuate(rod, height(raised(4.0)))
    assert found.status == "reached"
    assert found.success
    assert found.stability == "stable"
    assert found.is_stable
    assert_allclose(found.u, [4.0], rtol=1e-7)
    assert_allclose(found.q, lissom.statics(rod, u=[4.0]).q, atol=1e-6)
    assert found.position_error < 1e-9 * LENGTH
    assert_allclose(found.pose, rod.pose(found.q), atol=1e-15)


@pytest.mark.parametrize("seed", range(6))
def test_there_and_back(seed):
    robot = six()
    u = np.random.default_rng(seed).uniform(0.0, 6.0, 6)
    wanted = robot.pose(lissom.statics(robot, u=u).q)
    for target in (wanted, {"rod": wanted}):
        found = lissom.actuate(robot, target)
        assert found.status == "reached", found.message
        assert (found.u >= 0).all()
        assert_allclose(found.q, lissom.statics(robot, found.q, u=found.u).q, atol=1e-8)
        reached = robot.pose(found.q)
        assert_allclose(reached[:3, 3], wanted[:3, 3], atol=2e-9 * LENGTH)
        assert_allclose(reached[:3, :3], wanted[:3, :3], atol=2e-9)
        # Inputs known to have the same effect are not smaller.
        assert np.linalg.norm(found.u) <= np.linalg.norm(u) * (1 + 1e-6)


@pytest.mark.parametrize("seed", range(12))
def test_positions_there_and_back(seed):
    robot = six()
    u = np.random.default_rng(seed).uniform(0.0, 6.0, 6)
    wanted = robot.pose(lissom.statics(robot, u=u).q)[:3, 3]
    found = lissom.actuate(robot, wanted)
    assert found.position_error < 1e-9 * LENGTH
    assert (found.u >= 0).all()
    assert found.status == "reached"
    assert np.linalg.norm(found.u) <= np.linalg.norm(u) * (1 + 1e-6)


def test_lengths_of_tendons_and_back():
    lengths = [
        tendon(
            f"t{k}",
            2 * np.pi * k / 3,
            tension=None,
            length=lissom.Input(f"t{k}", LENGTH - 2e-3),
            stiffness=1e4,
        )
        for k in range(3)
    ]
    robot = finger(lengths, {"bend_y": 3, "bend_z": 3, "stretch": 1})
    u = LENGTH - np.array([6e-3, 3e-3, 2e-3])
    wanted = robot.pose(lissom.statics(robot, u=u).q)[:3, 3]
    found = lissom.actuate(robot, wanted)
    assert found.status == "reached"
    assert_allclose(found.u, u, atol=1e-7)
    assert_allclose(
        robot.actuator_force("t0", found.q, 0 * found.q, u=found.u),
        robot.actuator_force("t0", found.q, 0 * found.q, u=u),
        rtol=1e-3,
    )


def test_of_antagonists_only_one_pulls():
    found = lissom.actuate(planar(), height(raised(2.0)))
    assert found.status == "reached"
    assert_allclose(found.u, [2.0, 0.0], atol=1e-6)
    # A tendon that must not be slack pulls with its minimum tension.
    found = lissom.actuate(planar(), height(raised(2.0)), limits={"down": (0.5, 4.0)})
    assert found.status == "reached"
    assert_allclose(found.u, [2.5, 0.5], atol=1e-6)


def test_the_least_tensions_are_those_of_another_optimiser():
    robot = three(2.0)
    pose = robot.pose(lissom.statics(robot, u=[4.0, 3.0, 2.5]).q)
    target = lissom.Target("rod", pose[:3, 3], position_weight=(0, 1, 1))
    found = lissom.actuate(robot, target)

    def tip(u):
        return robot.pose(lissom.statics(robot, found.q, u=u).q)[1:3, 3]

    other = minimize(
        lambda u: u @ u,
        [4.0, 3.0, 2.5],
        jac=lambda u: 2 * u,
        method="SLSQP",
        bounds=[(0, None)] * 3,
        constraints={"type": "eq", "fun": lambda u: (tip(u) - pose[1:3, 3]) / LENGTH},
        options={"ftol": 1e-12},
    )
    assert found.status == "reached"
    assert other.success
    assert_allclose(found.u, other.x, atol=1e-4)


def test_inputs_that_are_not_named_stay():
    robot, before = six(), np.array([1.0, 2.0, 0.5, 1.0, 1.0, 1.0])
    wanted = robot.pose(lissom.statics(robot, u=[1.0, 2.0, 0.5, 3.0, 1.0, 0.2]).q)[:3, 3]
    found = lissom.actuate(
        robot,
        lissom.Target("rod", wanted, position_weight=(0, 1, 1)),
        inputs=["far0", "far1", "far2"],
        u=before,
    )
    assert found.status == "reached"
    assert_allclose(found.u[:3], before[:3], atol=0)


def test_a_rod_is_brought_into_a_shape():
    robot, stations = six(), np.linspace(0.05, LENGTH, 4)
    u = np.array([3.0, 1.0, 0.0, 0.0, 2.0, 4.0])
    q = lissom.statics(robot, u=u).q
    points = robot.pose(q, stations)[:, :3, 3]
    found = lissom.actuate(
        robot, [lissom.Target("rod", p, X=X) for p, X in zip(points, stations, strict=True)]
    )
    assert found.status == "reached"
    assert found.position_error.shape == found.orientation_error.shape == (4,)
    assert_allclose(robot.pose(found.q, stations)[:, :3, 3], points, atol=1e-8 * LENGTH)


def test_limits_are_named():
    rod = finger([tendon("up", np.pi / 2, 1.0)], {"bend_y": 3})
    found = lissom.actuate(rod, height(raised(4.0)), limits=(0.0, 2.0))
    assert (found.status, found.success, found.at_limits) == ("at_limits", False, ["up"])
    assert_allclose(found.u, [2.0], atol=0)
    assert "'up' is held back" in found.message
    assert_allclose(found.position_error, raised(4.0) - raised(2.0), rtol=1e-9)
    # A tendon cannot push.
    below = lissom.actuate(rod, height(-0.01))
    assert (below.status, below.at_limits) == ("at_limits", ["up"])
    assert_allclose(below.u, [0.0], atol=0)


def test_out_of_reach_it_comes_nearest():
    robot, step = three(), 1e-4
    target = np.array([0.1, 0.15, 0.1])
    found = lissom.actuate(robot, target)
    assert found.status in ("nearest", "at_limits")
    assert not found.success
    assert "'rod' is off by" in found.message

    def off(u):
        return np.linalg.norm(robot.pose(lissom.statics(robot, found.q, u=u).q)[:3, 3] - target)

    assert_allclose(found.position_error, off(found.u), rtol=1e-9)
    for k in range(3):
        for change in (step, -step):
            u = found.u + change * np.eye(3)[k]
            if u[k] >= 0:
                assert off(u) > off(found.u) - 1e-12


def arm():
    """A hinge about -y with a motor: the torque m g l cos(angle) holds it, at most m g l."""
    body = lissom.Body(2.0, centre=(0.5, 0, 0), inertia=(0.1, 0.1, 0.1))
    link = lissom.Link("arm", body=body, joint=lissom.Revolute((0, -1, 0)))
    hand = lissom.Link("hand", parent="arm", position=(1.0, 0, 0))
    return lissom.Robot([link, hand], actuators=[lissom.Motor("arm", torque=lissom.Input("torque", 0.0))])


def test_the_equilibrium_is_lost_where_it_would_snap():
    robot, weight = arm(), 2.0 * 9.81 * 0.5

    def at(angle):
        return {"hand": (np.cos(angle), 0.0, np.sin(angle))}

    start = [-np.pi / 2 + 0.1]
    below = lissom.actuate(robot, at(-0.5), q0=start)
    assert below.status == "reached"
    assert_allclose(below.u, [weight * np.cos(0.5)], rtol=1e-7)
    above = lissom.actuate(robot, at(0.8), q0=start)
    assert above.status == "equilibrium_lost"
    assert not above.success
    assert "buckles or snaps" in above.message
    assert_allclose(above.u, [weight], rtol=1e-3)
    assert -0.1 < above.q[0] <= 1e-6
    assert "unstable, and buckles or snaps" in above.message
    assert "`robot.inverse_dynamics(q, 0 * q, 0 * q)` has the torques of a posture" in above.message


def test_torques_of_a_raised_posture_hold_it_with_a_controller_and_not_alone():
    """What the message about a lost equilibrium advises."""
    robot = arm()
    q = robot.reach(lissom.Target("hand", (np.cos(0.8), 0.0, np.sin(0.8)))).q
    torque = robot.inverse_dynamics(q, 0 * q, 0 * q)
    beside = q + 0.01
    alone = lissom.simulate(robot, 3.0, q0=beside, u=torque)
    assert abs(alone.q - q).max() > 0.1
    held = lissom.simulate(
        robot, 3.0, q0=beside, control=lambda t, now, v: torque - 100.0 * (now - q) - 20.0 * v
    )
    assert abs(held.q - q).max() < 0.011


def test_arms_that_are_pulled_are_not_told_about_torques():
    far = lissom.actuate(three(), (0.0, 0.0, 5.0))
    assert "inverse_dynamics" not in far.message


def test_forces_are_inputs_too():
    load = lissom.Load(force=lissom.Input("push", (0.0, 0.0, 0.1)), at=LENGTH)
    rod = finger([], loads=[load])
    u = np.array([0.0, 0.1, 0.2])
    wanted = rod.pose(lissom.statics(rod, u=u).q)[:3, 3]
    found = lissom.actuate(
        rod,
        lissom.Target("rod", wanted, position_weight=(0, 1, 1)),
        limits={"push": ((0, -1, -1), (0, 1, 1))},
    )
    assert found.status == "reached"
    assert_allclose(found.u, u, atol=1e-6)


def test_loads_are_those_of_their_time():
    table = ([0.0, 1.0], [(0, 0, 0), (0, 0, 0.1)])
    rod = finger([tendon("up", np.pi / 2, 1.0)], {"bend_y": 3}, loads=[lissom.Load(force=table, at=LENGTH)])
    wanted = rod.pose(lissom.statics(rod, u=[3.0], t=0.7).q)[2, 3]
    assert_allclose(lissom.actuate(rod, height(wanted), t=0.7).u, [3.0], rtol=1e-6)
    assert abs(lissom.actuate(rod, height(wanted)).u[0] - 3.0) > 0.1


def test_without_an_equilibrium_to_begin_with():
    # Compressed by more than E A.
    robot = finger([tendon("up", np.pi / 2, 1.0)], {"stretch": 2}, tip_force=(-3e4, 0, 0))
    found = lissom.actuate(robot, height(0.05))
    assert found.status == "no_start"
    assert not found.success
    assert "no equilibrium at the initial inputs" in found.message
    assert np.isfinite(found.u).all()


def test_results_are_copied_and_pickled():
    found = lissom.actuate(planar(), height(raised(2.0)))
    for other in (copy.copy(found), pickle.loads(pickle.dumps(found))):
        assert_allclose(other.u, found.u, atol=0)
        assert other.status == found.status
    assert repr(found).startswith("<ActuateResult: reached, stable, 2 inputs, ")
    with pytest.raises(ValueError, match="read-only"):
        found.u[0] = 1.0


WRONG = [
    ({"target": [1.0, 2.0]}, r"pose: expected a homogeneous matrix"),
    ({"target": [0.1, np.nan, 0.1]}, "nan|NaN"),
    ({"target": []}, "target"),
    ({"target": {"hand": (0, 0, 0)}}, r"target\['hand'\]"),
    (
        {"inputs": ["upp"]},
        r"inputs\[0\]: got 'upp', expected one of the inputs: 'up', 'down'; did you mean 'up'",
    ),
    ({"inputs": []}, "inputs: got none, expected at least one"),
    ({"inputs": 3}, "inputs: expected a sequence of names of inputs, got int"),
    ({"limits": {"left": (0, 1)}}, "limits: got 'left', expected one of the inputs"),
    ({"limits": {"up": (2, 1)}}, r"limits\['up'\]: got 2 to 1"),
    ({"limits": {"up": (-3, -1)}}, r"limits\['up'\]: got -3 to -1"),
    ({"limits": {"up": 1}}, r"limits\['up'\]: expected a pair"),
    ({"u": [1.0]}, "u: expected 2 values, got 1"),
    ({"u": [1.0, np.inf]}, r"u\[1\]: got inf"),
    ({"q0": [0.0]}, "q0: expected 3 values, got 1"),
    ({"tol": 0.0}, "tol: got 0"),
    ({"max_iter": -1}, "max_iter"),
]


@pytest.mark.parametrize(("given", "message"), WRONG)
def test_what_makes_no_sense_is_refused(given, message):
    with pytest.raises((ValueError, TypeError), match=message):
        lissom.actuate(**{"robot": planar(), "target": height(0.01)} | given)


def test_robots_without_inputs_are_refused():
    rod = finger([tendon("up", 0.0, tension=1.0)])
    with pytest.raises(ValueError, match="robot: got a robot without inputs"):
        lissom.actuate(rod, (0.1, 0, 0))
    with pytest.raises(TypeError, match="robot: expected a Robot or a Rod, got SpringPendulum"):
        lissom.actuate(lissom.SpringPendulum(), (0.1, 0, 0))


@pytest.mark.filterwarnings("ignore:The finite number of modes:lissom.AccuracyWarning")
@pytest.mark.parametrize("unit", [1.0, 1e3])
@pytest.mark.parametrize("seed", [2, 4, 6, 9, 11])
def test_the_smallest_inputs_are_found_where_an_equation_hardly_depends_on_them(seed, unit):
    """Rods without stretching: one coordinate of a place follows from the others, but for the weight."""
    random = np.random.default_rng(seed)
    count = int(random.choice([4, 6]))
    modulus, length = 10 ** random.uniform(6, 8), random.uniform(0.15, 0.5)
    moduli = np.array([1.0, 0.37]) * modulus / unit
    modes = {"torsion": 1, "bend_y": 3, "bend_z": 3}
    segment = lissom.Segment(length * unit, 0.008 * unit, *moduli, 1000 / unit**3, modes=modes)
    actuators = [tendon_at(f"t{k}", 2 * np.pi * k / count, 0.01 * unit) for k in range(count)]
    rotation = Rotation.random(random_state=seed)
    x, y, z, w = rotation.as_quat()
    links = [lissom.Link("rod", rod=[segment], orientation=(w, x, y, z))]
    robot = lissom.Robot(links, actuators=actuators, gravity=(0, 0, -9.81 * unit))
    tension = modulus * np.pi / 4 * 0.008**4 / 0.01 / length * unit
    known = random.uniform(0, 1.2, count) * tension
    at_rest = lissom.statics(robot, u=known, space_error=False)
    target = robot.pose(at_rest.q, link="rod")[:3, 3]
    found = lissom.actuate(robot, lissom.Target("rod", target))
    assert found.status == "reached", found.message
    assert_allclose(robot.pose(found.q, link="rod")[:3, 3], target, rtol=0, atol=1e-8 * length * unit)
    assert np.linalg.norm(found.u) <= np.linalg.norm(known) * (1 + 1e-6)
