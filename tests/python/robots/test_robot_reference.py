"""The NumPy reference of robots, validated before its use.

Poses give velocities by differences in time, velocities give energies and momenta, and these give generalised
forces by Lagrange's equations and by Newton's laws for the complete robot. Only the velocities are shared
with the recursion. Robots with a single rod agree with the reference rod.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import lissom
from reference import joint
from reference.random_robots import coordinate_scale, quaternions, random_states, robots, seeds, vectors
from reference.robot import build
from rod_cases import random_states as states_of_rods
from rod_cases import rich_rod

# Robots with rods take a tenth of a second each.
few = settings(max_examples=6)
#: Time increment of fourth-order differences, seconds; the robots move on much longer time scales.
STEP = 1e-3
RUBBER = {"young_modulus": 1e5, "shear_modulus": 4e4, "density": 1000.0, "radius": 0.03}
BLOCK = {"mass": 0.4, "centre": (0.05, -0.02, 0.1), "inertia": (2e-3, 3e-3, 4e-3)}


def rate(function, step=STEP):
    """Derivative at zero by fourth-order differences."""
    near, far = function(step) - function(-step), function(2 * step) - function(-2 * step)
    return (8 * near - far) / (12 * step)


def motion(state):
    """q and v of the motion with constant acceleration through a state, as functions of time."""
    q, v, a = state
    return lambda t: q + t * v + t**2 / 2 * a, lambda t: v + t * a


def assert_close(actual, desired, tolerance=1e-10):
    """Compares relative to the largest value, because entries may vanish."""
    assert_allclose(actual, desired, rtol=0, atol=tolerance * max(1e-3, np.abs(desired).max(initial=0)))


def axial(skew):
    return np.array([skew[2, 1] - skew[1, 2], skew[0, 2] - skew[2, 0], skew[1, 0] - skew[0, 1]]) / 2


def places(robot):
    """A place on every link."""
    for link in robot.links:
        length = robot.length(link.name)
        yield {"link": link.name, "X": None if length is None else 0.3 * length}


def without_dissipation(description):
    """Only loads with a potential and no damping, as Lagrange's equations require."""
    links = [dict(link) for link in description["links"]]
    for link in links:
        link["joint"] = {key: value for key, value in link["joint"].items() if key != "damping"}
        if "rod" in link:
            link["rod"] = [segment | {"retardation_time": 0.0} for segment in link["rod"]]
    loads = [load | {"frame": "world", "moment": (0, 0, 0)} for load in description["loads"]]
    return description | {"links": links, "loads": loads}


# From poses to velocities, energies and momenta


@few
@given(robots(max_links=3), seeds)
def test_velocities_are_rates_of_poses_and_accelerations_of_velocities(description, seed):
    robot = build(description)
    state = random_states(robot, seed)
    (q, v, a), (at, speed) = state, motion(state)
    for place in places(robot):
        pose = robot.pose(q, **place)
        turning = rate(lambda t, place=place: robot.pose(at(t), **place))
        velocity = [*axial(turning[:3, :3] @ pose[:3, :3].T), *turning[:3, 3]]
        # The error of the differences is about a fifth derivative times STEP^4 = 1e-12.
        assert_allclose(robot.velocity(q, v, **place), velocity, rtol=0, atol=1e-7)
        acceleration = rate(lambda t, place=place: robot.velocity(at(t), speed(t), **place))
        assert_allclose(robot.acceleration(q, v, a, **place), acceleration, rtol=1e-7, atol=1e-7)


@few
@given(robots(max_links=4), seeds)
def test_momentum_is_the_rate_of_the_first_moment(description, seed):
    robot = build(description)
    state = random_states(robot, seed)
    (q, v, _), (at, speed) = state, motion(state)
    momentum = robot.momentum(q, v)
    moved = rate(lambda t: robot.momentum(at(t), speed(t)).first)
    assert_close(moved, momentum.linear, 1e-7)
    assert_allclose(robot.centre_of_mass(q), momentum.first / momentum.mass, atol=1e-11)
    masses = [body.mass for part in robot.parts for body in getattr(part, "bodies", ())]
    for link in robot.links:
        for segment in link.rod or ():
            base, tip = np.broadcast_to(segment.radius, 2)
            masses.append(segment.density * segment.length * np.pi * (base**2 + base * tip + tip**2) / 3)
    assert_allclose(momentum.mass, sum(masses), rtol=1e-11)


def test_momenta_and_energies_of_a_dumbbell_by_hand():
    """Point masses of 1 and 3 kg at x = -1 and 2 on a free frame."""
    ends = [
        {"name": "right", "parent": "left", "position": (3, 0, 0), "body": {"mass": 3.0}},
    ]
    left = {"name": "left", "joint": {"type": "free"}, "position": (-1, 0, 0), "body": {"mass": 1.0}}
    robot = build({"links": [left, *ends], "gravity": (0, 0, -10)})
    # The frame moves upwards by 1 m/s and rotates about z by 2 rad/s: the right end moves along y by 6 m/s.
    q, v = np.zeros(6), np.array([0, 0, 1.0, 0, 0, 2.0])
    momentum = robot.momentum(q, v)
    assert_allclose(momentum.mass, 4)
    assert_allclose(momentum.linear, [0, 18, 4])
    # r x m v: (-1, 0, 0) x (0, 0, 1) and (2, 0, 0) x 3 (0, 6, 1)
    assert_allclose(momentum.angular, [0, 1 - 6, 36])
    assert_allclose(robot.centre_of_mass(q), [5 / 4, 0, 0])
    assert_allclose(robot.energy(q, v), [1 / 2 + 3 / 2 * 37, 0, 0, 0], atol=1e-14)
    q[2] = 0.5
    assert_allclose(robot.energy(q, v).gravitational, 4 * 10 * 0.5)


# From energies and momenta to forces


@few
@given(robots(max_links=4), seeds)
def test_lagranges_equations_along_any_direction(description, seed):
    """w . tau = d/dt (w . M v) - D_w (T - V) for directions w of the coordinates."""
    robot = build(without_dissipation(description))
    state = random_states(robot, seed)
    (q, v, _), (at, speed) = state, motion(state)
    tau = robot.inverse_dynamics(*state)
    momentum_rate = rate(lambda t: robot.mass_matrix(at(t)) @ speed(t))

    def lagrangian(q):
        energy = robot.energy(q, v)
        return 2 * energy.kinetic - energy.total

    scale = coordinate_scale(robot)
    for w in scale * np.random.default_rng(seed).standard_normal((2, robot.n)):
        gradient = rate(lambda h, w=w: lagrangian(q + h * w))
        size = max(np.abs(w) @ np.abs(tau), np.abs(w) @ np.abs(momentum_rate), 1)
        assert_allclose(w @ tau, w @ momentum_rate - gradient, rtol=0, atol=1e-7 * size)


@few
@given(robots(max_links=5), seeds)
def test_mass_matrix(description, seed):
    """Symmetric, positive definite, derivative of the forces, and consistent with the kinetic energy."""
    robot = build(description)
    q, v, a = random_states(robot, seed)
    mass = robot.mass_matrix(q)
    assert_close(mass, mass.T)
    scale = coordinate_scale(robot)
    scaled = mass * np.outer(scale, scale)
    units = 1 / np.sqrt(np.diag(scaled))
    # Scaled to a unit diagonal, because only then the condition number is meaningful.
    assert np.linalg.eigvalsh(scaled * np.outer(units, units)).min() > 0
    forces = robot.inverse_dynamics(q, v, np.column_stack([a, a[:, None] + np.eye(robot.n)]))
    assert_allclose(
        forces[:, 1:] - forces[:, :1], mass, atol=1e-10 * max(np.abs(forces).max(), np.abs(mass).max())
    )
    assert_allclose(robot.energy(q, v).kinetic, v @ mass @ v / 2, rtol=1e-9, atol=1e-14)


@few
@given(robots(max_links=4, floating=True), seeds)
def test_what_a_free_base_needs_is_the_rate_of_momentum(description, seed):
    """Newton's and Euler's laws for the complete robot, without internal forces."""
    description = description | {"loads": []}
    description["links"][0] |= {"position": (0, 0, 0), "orientation": (1, 0, 0, 0)}
    robot = build(description)
    state = random_states(robot, seed)
    (q, v, _), (at, speed) = state, motion(state)
    tau = robot.inverse_dynamics(*state)
    force, moment = tau[:3], joint.exp(q[3:6]) @ np.linalg.solve(joint.tangent(q[3:6]).T, tau[3:6])
    momentum = robot.momentum(q, v)
    weight = momentum.mass * robot.gravity
    assert_close(force, rate(lambda t: robot.momentum(at(t), speed(t)).linear) - weight, 1e-7)
    about_origin = moment + np.cross(q[:3], force)
    torque = rate(lambda t: robot.momentum(at(t), speed(t)).angular) - np.cross(momentum.first, robot.gravity)
    assert_close(about_origin, torque, 1e-7)


@few
@given(robots(max_links=3), seeds)
def test_power_of_loads(description, seed):
    """The generalised forces of loads have the power of their wrenches."""
    loads = [{key: load[key] for key in load if key != "along"} for load in description["loads"]]
    loads += [{"link": "link0", "force": (1, 2, 3), "moment": (0.1, 0.2, 0.3), "frame": "body"}]
    robot = build(description | {"loads": loads})
    q, v, a = random_states(robot, seed)
    saved = (
        build(description | {"loads": []}).inverse_dynamics(q, v, a) - robot.inverse_dynamics(q, v, a)
    ) @ v
    power = 0.0
    for load in loads:
        place = {"link": load["link"], "X": load.get("at")}
        turn = robot.pose(q, **place)[:3, :3] if load["frame"] == "body" else np.eye(3)
        power += robot.velocity(q, v, **place) @ [*(turn @ load["moment"]), *(turn @ load["force"])]
    assert_allclose(saved, power, rtol=0, atol=1e-9)


def test_springs_dampers_and_armatures_of_joints():
    spring = {"stiffness": 5.0, "rest": 0.3, "damping": 0.7, "armature": 0.2}
    for kind in ({"type": "revolute"}, {"type": "prismatic"}, {"type": "screw", "lead": 2.0}):
        link = {"name": "block", "body": BLOCK, "joint": kind | {"axis": (1, 2, 3)}}
        plain = build({"links": [link]})
        sprung = build({"links": [link | {"joint": link["joint"] | spring}]})
        q, v, a = np.array([[0.9], [2.0], [-3.0]])
        extra = sprung.inverse_dynamics(q, v, a) - plain.inverse_dynamics(q, v, a)
        assert_allclose(extra, 5.0 * (0.9 - 0.3) + 0.7 * 2.0 + 0.2 * -3.0, rtol=1e-13)
        assert_allclose(sprung.mass_matrix(q) - plain.mass_matrix(q), 0.2, rtol=1e-13)
        more = np.subtract(sprung.energy(q, v), plain.energy(q, v))
        assert_allclose(more, [0.2 * 2.0**2 / 2, 5.0 * 0.6**2 / 2, 0, 0], rtol=1e-13)


# One rod is unchanged


def as_robot(case):
    """The description of the rod of a case."""
    arguments = case.arguments
    tip = {"link": "rod", "force": arguments["tip_force"], "moment": arguments["tip_moment"]}
    return {
        "gravity": arguments["gravity"],
        "links": [
            {
                "name": "rod",
                "rod": arguments["segments"],
                "position": arguments["base_position"],
                "orientation": arguments["base_orientation"],
            }
        ],
        "loads": [tip, *({"link": "rod"} | load for load in arguments["loads"])],
        "bodies": [
            {"link": "rod"} | body for body in [{"mass": arguments["tip_mass"]}, *arguments["bodies"]]
        ],
    }


@pytest.fixture(scope="module")
def rich():
    case = rich_rod()
    return case, as_robot(case)


def test_one_rod_is_the_rod_that_there_is(rich):
    case, description = rich
    robot = build(description)
    q, v, a = states_of_rods(case, 1)
    X = np.array([0.0, 0.1, 0.4, 0.9, case.length])
    poses = np.array([robot.pose(q, at, link="rod") for at in X])
    velocities = np.array([robot.velocity(q, v, at, link="rod") for at in X])
    for rod in (case.reference, case.lissom):
        assert_close(robot.inverse_dynamics(q, v, a), rod.inverse_dynamics(q, v, a))
        assert_close(robot.mass_matrix(q), rod.mass_matrix(q))
    assert_close(poses, case.reference.poses(q, X))
    assert_close(poses, case.lissom.pose(q, X))
    assert_close(velocities, [case.lissom.velocity(q, v, at) for at in X])
    assert_close(np.array(robot.energy(q, v)), np.array(case.reference.energy(q, v)))


def test_a_rod_on_a_free_joint_is_a_rod_on_a_moving_base(rich):
    """The forces along the rod, and those of the joint as the wrench of the base."""
    case, description = rich
    [link] = description["links"]
    link = link | {"joint": {"type": "free"}, "position": (0, 0, 0), "orientation": (1, 0, 0, 0)}
    robot = build(description | {"links": [link]})
    state = random_states(robot, 4)
    base, rod = np.split(state, [6], axis=1)
    at, _ = motion(base)

    def orientation(t):
        x, y, z, w = Rotation.from_rotvec(at(t)[3:]).as_quat()
        return np.array([w, x, y, z])

    moving = lissom.BaseMotion(translation=lambda t: at(t)[:3], rotation=orientation)
    whole = case.lissom
    moved = lissom.Rod(
        whole.segments,
        gravity=whole.gravity,
        base_motion=moving,
        tip_force=whole.tip_force,
        tip_moment=whole.tip_moment,
        tip_mass=whole.tip_mass,
        loads=whole.loads,
        bodies=whole.bodies,
    )
    tau = robot.inverse_dynamics(*state)
    moment, force = np.split(moved.base_wrench(*rod, t=0.0), 2)
    phi = base[0, 3:]
    of_joint = [*force, *(joint.tangent(phi).T @ joint.exp(phi).T @ moment)]
    # The base motion is differentiated numerically there.
    assert_close(tau, np.array([*of_joint, *moved.inverse_dynamics(*rod, t=0.0)]), 1e-9)


def test_a_rod_of_two_segments_is_two_rods_welded(rich):
    case, description = rich
    [link] = description["links"]
    first, *rest = link["rod"]
    # At the weld a place belongs to two links; loads and bodies of the whole rod are attached to either.
    ends = [
        link | {"rod": [first]},
        {"name": "more", "parent": "rod", "joint": {"type": "weld"}, "rod": rest},
    ]

    def moved(thing):
        places = thing.get("along", [thing.get("at")])
        if None in places:
            return [thing | {"link": "more"}]
        if min(places) >= 0.4 and "along" in thing:
            return [thing | {"link": "more", "along": [X - 0.4 for X in places]}]
        if "along" in thing:
            low, high = places
            return [
                thing | {"along": (low, 0.4)},
                thing | {"link": "more", "along": (0.0, high - 0.4)},
            ]
        if thing["at"] > 0.4:
            return [thing | {"link": "more", "at": thing["at"] - 0.4}]
        return [thing]

    cut = description | {
        "links": ends,
        "loads": [part for load in description["loads"] for part in moved(load)],
        "bodies": [part for body in description["bodies"] for part in moved(body)],
    }
    whole, cut = build(description), build(cut)
    q, v, a = states_of_rods(case, 2)
    assert_close(cut.inverse_dynamics(q, v, a), whole.inverse_dynamics(q, v, a))
    assert_close(cut.mass_matrix(q), whole.mass_matrix(q))
    assert_close(np.array(cut.energy(q, v)), np.array(whole.energy(q, v)))
    assert_close(cut.momentum(q, v).flat(), whole.momentum(q, v).flat())
    assert_close(cut.pose(q, 0.2, link="more"), whole.pose(q, 0.6, link="rod"))
    assert_close(cut.forward_dynamics(q, v), whole.forward_dynamics(q, v), 1e-8)


def test_welded_bodies_are_bodies_of_the_rod(rich):
    _, description = rich
    links = [
        {"name": f"body{k}", "parent": "rod", "at": body.get("at"), "body": body}
        for k, body in enumerate(
            {key: each[key] for key in each if key != "link"} for each in description["bodies"]
        )
    ]
    for link in links:
        link["body"] = {key: link["body"][key] for key in link["body"] if key != "at"}
    whole, hung = (
        build(description),
        build(description | {"links": description["links"] + links, "bodies": []}),
    )
    q, v, a = 0.3 * np.random.default_rng(3).standard_normal((3, whole.n))
    assert_close(hung.inverse_dynamics(q, v, a), whole.inverse_dynamics(q, v, a))
    assert_close(hung.mass_matrix(q), whole.mass_matrix(q))
    assert_close(np.array(hung.energy(q, v)), np.array(whole.energy(q, v)))


# Invariances


def turned(description, orientation, shift):
    """The same robot in a rotated and translated world."""
    w, x, y, z = orientation
    turn = Rotation.from_quat([x, y, z, w])

    def moved(link):
        if "parent" in link:
            return link
        w, x, y, z = link.get("orientation", (1, 0, 0, 0))
        x, y, z, w = (turn * Rotation.from_quat([x, y, z, w])).as_quat()
        position = turn.apply(link.get("position", (0, 0, 0))) + shift
        return link | {"position": position, "orientation": (w, x, y, z)}

    return {
        "gravity": turn.apply(description["gravity"]),
        "links": [moved(link) for link in description["links"]],
        "loads": [
            load | {key: turn.apply(load[key]) for key in ("force", "moment")}
            if load["frame"] == "world"
            else load
            for load in description["loads"]
        ],
    }, turn.as_matrix()


@few
@given(robots(max_links=4), seeds, quaternions(), vectors(3.0))
def test_forces_do_not_depend_on_the_frame(description, seed, orientation, shift):
    other, turn = turned(description, orientation, np.array(shift))
    one, other = build(description), build(other)
    q, v, a = random_states(one, seed)
    assert_close(other.inverse_dynamics(q, v, a), one.inverse_dynamics(q, v, a))
    assert_close(other.mass_matrix(q), one.mass_matrix(q))
    link = one.names[-1]
    pose = one.pose(q, link=link)
    assert_allclose(other.pose(q, link=link)[:3, :3], turn @ pose[:3, :3], atol=1e-11)
    assert_allclose(other.pose(q, link=link)[:3, 3], turn @ pose[:3, 3] + shift, atol=1e-11)


def test_branches_have_no_common_entries_and_their_order_does_not_matter():
    trunk = {"name": "trunk", "joint": {"type": "free"}, "body": BLOCK}
    arm = {"length": 0.3, "modes": {"bend_y": 2, "torsion": 1}, **RUBBER}
    left = {"name": "left", "parent": "trunk", "joint": {"type": "revolute", "axis": (0, 1, 0)}, "rod": [arm]}
    right = {"name": "right", "parent": "trunk", "joint": {"type": "spherical"}, "body": BLOCK}
    tool = {"name": "tool", "parent": "left", "at": 0.1, "joint": {"type": "spherical"}, "body": BLOCK}
    robot = build({"links": [trunk, left, right, tool]})
    other = build({"links": [trunk, right, left, tool]})
    order = [k for name in other.names for k in range(robot.n)[robot.slice(name)]]
    q, v, a = random_states(robot, 5)
    mass = robot.mass_matrix(q)
    assert_allclose(mass[robot.slice("right"), robot.slice("left")], 0, atol=0)
    assert_allclose(mass[robot.slice("right"), robot.slice("tool")], 0, atol=0)
    assert np.abs(mass[robot.slice("left"), robot.slice("tool")]).max() > 1e-4
    assert_close(other.mass_matrix(q[order]), mass[np.ix_(order, order)], 1e-12)
    forces = robot.inverse_dynamics(q, v, a)
    assert_close(other.inverse_dynamics(q[order], v[order], a[order]), forces[order], 1e-12)


def three_hinges(axes):
    """A robot with three hinges in series, two of massless frames, at its end, and one with a ball joint."""
    base = {"name": "base", "joint": {"type": "prismatic", "axis": (1, 1, 0)}, "body": BLOCK}
    place = {"position": (0.1, 0.2, 0), "orientation": (0.8, 0, 0.6, 0)}
    rod = {"rod": [{"length": 0.3, "modes": {"bend_y": 1, "bend_z": 1}, **RUBBER}]}
    links, parent = [base], "base"
    for name, axis, more in zip("abc", axes, (place, {}, rod), strict=True):
        hinge = {"type": "revolute", "axis": axis}
        links.append({"name": name, "parent": parent, "joint": hinge, **more})
        parent = name
    ball = {"name": "c", "parent": "base", "joint": {"type": "spherical"}, **place, **rod}
    return build({"links": links}), build({"links": [base, ball]})


@pytest.mark.parametrize("angles", [(0.3, 0.7, -0.4), (2.0, -0.6, 1.0), (-1.0, 1.2, 2.5)])
def test_a_spherical_joint_is_three_revolute_ones(angles):
    """By the map of the coordinates: phi(angles), its derivative and the rate of the derivative."""
    axes = np.eye(3)[[2, 1, 0]]
    hinged, ball = three_hinges(axes)
    rng = np.random.default_rng(1)
    q, v, a = 0.5 * rng.standard_normal((3, hinged.n))
    q[1:4] = angles

    def rotation_vector(angles):
        return Rotation.from_euler("ZYX", angles).as_rotvec()

    def derivative(angles):
        return np.column_stack([rate(lambda h, u=u: rotation_vector(angles + h * u)) for u in np.eye(3)])

    at, _ = motion((q[1:4], v[1:4], a[1:4]))
    A = derivative(q[1:4])
    mapped = np.array([q, v, a])
    mapped[0, 1:4], mapped[1, 1:4] = rotation_vector(q[1:4]), A @ v[1:4]
    mapped[2, 1:4] = A @ a[1:4] + rate(lambda t: derivative(at(t))) @ v[1:4]
    assert_allclose(ball.pose(mapped[0], link="c"), hinged.pose(q, link="c"), atol=1e-11)
    forces = ball.inverse_dynamics(*mapped)
    forces[1:4] = A.T @ forces[1:4]
    # The differences have ten correct digits.
    assert_close(forces, hinged.inverse_dynamics(q, v, a), 1e-8)
    whole = np.eye(hinged.n)
    whole[1:4, 1:4] = A
    assert_close(whole.T @ ball.mass_matrix(mapped[0]) @ whole, hinged.mass_matrix(q), 1e-8)


@pytest.mark.parametrize(
    ("kind", "parts"),
    [
        (
            {"type": "universal", "axis1": (0, 1, 1), "axis2": (1, 0, 2)},
            [{"type": "revolute", "axis": (0, 1, 1)}, {"type": "revolute", "axis": (1, 0, 2)}],
        ),
        (
            {"type": "cylindrical", "axis": (0, 1, 1)},
            [{"type": "prismatic", "axis": (0, 1, 1)}, {"type": "revolute", "axis": (0, 1, 1)}],
        ),
        (
            {"type": "planar", "normal": (1, 0, 1)},
            [
                {"type": "prismatic", "axis": (1, 0, -1)},
                {"type": "prismatic", "axis": (0, 1, 0)},
                {"type": "revolute", "axis": (1, 0, 1)},
            ],
        ),
        (
            {"type": "free"},
            [*({"type": "prismatic", "axis": tuple(axis)} for axis in np.eye(3)), {"type": "spherical"}],
        ),
    ],
    ids=lambda part: part["type"] if isinstance(part, dict) else "",
)
def test_joints_are_rows_of_simpler_ones(kind, parts):
    base = {"name": "base", "joint": {"type": "spherical"}, "body": BLOCK}
    place = {"position": (0.1, 0.2, 0), "orientation": (0.8, 0, 0.6, 0)}
    links, parent = [base], "base"
    for k, part in enumerate(parts):
        links.append({"name": str(k), "parent": parent, "joint": part} | (place if k == 0 else {}))
        parent = str(k)
    row = build({"links": [*links[:-1], links[-1] | {"body": BLOCK}]})
    one = build({"links": [base, {"name": "one", "parent": "base", "joint": kind, "body": BLOCK, **place}]})
    q, v, a = random_states(one, 7)
    assert_close(one.inverse_dynamics(q, v, a), row.inverse_dynamics(q, v, a), 1e-12)
    assert_close(one.mass_matrix(q), row.mass_matrix(q), 1e-12)


def test_wrapped_states_are_the_same_motion():
    """Accelerations and twists of every link; forces by the virtual power of equal velocities."""
    description = {
        "links": [
            {"name": "base", "joint": {"type": "free"}, "body": BLOCK},
            {"name": "arm", "parent": "base", "joint": {"type": "spherical"}, "body": BLOCK},
        ]
    }
    robot = build(description)
    q, v, a = random_states(robot, 11)
    for phi in (slice(3, 6), slice(6, 9)):
        q[phi] *= 4.0 / np.linalg.norm(q[phi])
    wrapped = robot.wrap(q, v, a)
    assert np.linalg.norm(wrapped[0][3:6]) <= np.pi
    for link in robot.names:
        assert_allclose(robot.pose(wrapped[0], link=link), robot.pose(q, link=link), atol=1e-13)
        assert_close(robot.velocity(*wrapped[:2], link=link), robot.velocity(q, v, link=link), 1e-12)
        assert_close(robot.acceleration(*wrapped, link=link), robot.acceleration(q, v, a, link=link), 1e-11)
    power = robot.inverse_dynamics(q, v, a) @ v
    assert_allclose(robot.inverse_dynamics(*wrapped) @ wrapped[1], power, rtol=1e-11)


def test_several_motions_at_once_are_the_same_as_one_by_one():
    robot, _ = three_hinges(np.eye(3))
    q, v, _ = random_states(robot, 1)
    motions = np.random.default_rng(2).standard_normal((robot.n, 3))
    one_by_one = np.column_stack([robot.inverse_dynamics(q, v, motion) for motion in motions.T])
    assert_close(robot.inverse_dynamics(q, v, motions), one_by_one)


# In time


def runge_kutta(robot, q, v, duration, steps):
    """The free motion by the classical fourth-order method; rotation vectors are wrapped after every step."""
    h = duration / steps

    def change(y):
        return np.array([y[1], robot.forward_dynamics(*y)])

    y = np.array([q, v])
    for _ in range(steps):
        k1 = change(y)
        k2 = change(y + h / 2 * k1)
        k3 = change(y + h / 2 * k2)
        k4 = change(y + h * k3)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        y[0], y[1], _ = robot.wrap(*y, np.zeros(robot.n))
    return y


def flying(more):
    trunk = {"name": "trunk", "joint": {"type": "free"}, "body": BLOCK}
    return build({"gravity": (0, 0, 0), "links": [trunk, *more]})


def free_robots():
    spring = {"stiffness": 2.0, "rest": 0.2, "armature": 0.01}
    rigid = [
        {
            "name": "a",
            "parent": "trunk",
            "joint": {"type": "revolute", "axis": (0, 1, 1), **spring},
            "body": BLOCK,
        },
        {"name": "b", "parent": "a", "position": (0.1, 0, 0), "joint": {"type": "spherical"}, "body": BLOCK},
        {
            "name": "c",
            "parent": "trunk",
            "joint": {"type": "prismatic", "axis": (1, 0, 0), **spring},
            "body": BLOCK,
        },
    ]
    arm = {"length": 0.3, "modes": {"bend_y": 1, "bend_z": 1}, **RUBBER}
    soft = [
        {"name": "a", "parent": "trunk", "joint": {"type": "revolute", "axis": (0, 1, 0)}, "rod": [arm]},
        {
            "name": "b",
            "parent": "a",
            "at": 0.2,
            "joint": {"type": "revolute", "axis": (0, 0, 1)},
            "body": BLOCK,
        },
        {
            "name": "c",
            "parent": "a",
            "at": 0.0,
            "joint": {"type": "revolute", "axis": (1, 0, 0)},
            "body": BLOCK,
        },
    ]
    return {"rigid": (flying(rigid), 0.1, (16, 32)), "soft": (flying(soft), 0.06, (4, 8))}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rigid", "soft"])
def test_free_robots_keep_energy_and_momenta(name):
    """Changes decrease with the fourth power of the step."""
    robot, duration, numbers = free_robots()[name]
    q, v, _ = random_states(robot, 3, size=1.0)
    q[3:6] *= 3.1 / np.linalg.norm(q[3:6])

    def kept(q, v):
        momentum = robot.momentum(q, v)
        return np.array([robot.energy(q, v).total, *momentum.linear, *momentum.angular])

    start = kept(q, v)
    errors = []
    for steps in numbers:
        y, changes = (q, v), []
        for _ in range(2):
            y = runge_kutta(robot, *y, duration / 2, steps // 2)
            changes.append(kept(*y) - start)
        # Of energy, momentum and angular momentum; an error may pass zero, but not at both times.
        errors.append([np.abs(part).max() for part in np.split(np.array(changes), [1, 4], axis=1)])
    coarse, fine = np.array(errors)
    assert fine.max() < 3e-6
    assert_allclose(np.log2(coarse.max() / fine.max()), 4, atol=0.3)
    # For smaller errors, higher-order terms are visible.
    assert np.all(fine < coarse / 2**3)
