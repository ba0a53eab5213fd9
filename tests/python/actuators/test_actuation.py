"""Actuators of `lissom` compared with the NumPy reference, which shares no formula with them."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from numpy.testing import assert_allclose

import lissom
from reference.actuation import ActiveStrain, Actuated, Chamber, Motor, Tendon
from reference.random_actuators import make, random_others, random_tendons
from reference.random_robots import random_states, robots, seeds
from reference.robot import build

# Shrinking would take minutes.
few = settings(max_examples=5, phases=[Phase.generate])
RUBBER = {"length": 0.2, "radius": 0.012, "young_modulus": 1e5, "shear_modulus": 4e4, "density": 1000.0}
#: Two planar rods; tendons may lie beside the plane.
PLANAR = {
    "links": [
        {"name": "arm", "rod": [RUBBER | {"modes": {"bend_y": 2, "stretch": 1, "shear_z": 1}}] * 2},
        {
            "name": "finger",
            "parent": "arm",
            "joint": {"type": "revolute", "axis": (0, 1, 0)},
            "rod": [RUBBER | {"modes": {"bend_y": 2}}],
        },
    ]
}
#: Enough coordinates that the tree of links is solved link by link.
LONG = {
    "links": [
        {"name": "arm", "rod": [RUBBER | {"modes": {"torsion": 1, "bend_y": 2, "bend_z": 2}}] * 4},
        {
            "name": "tool",
            "parent": "arm",
            "joint": {"type": "revolute", "axis": (0, 1, 0), "stiffness": 0.1},
            "body": {"mass": 0.05, "centre": (0.03, 0, 0), "inertia": (1e-4, 1e-4, 1e-4)},
        },
    ]
}
KINDS = {
    "embedded": random_tendons,
    "points": lambda seed, links: random_tendons(seed, links, points=True),
    "friction": lambda seed, links: random_tendons(seed, links, friction=True),
    "others": random_others,
}
kinds = pytest.mark.parametrize("drawn", KINDS.values(), ids=KINDS)
#: Tolerance with friction: the rotation rate of a tendon has kinks, which quadrature does not resolve.
LOOSE = 1e-4


def with_actuators(description, actuators, nodes=32):
    """The robot in `lissom`, with enough nodes that its rods are exact to rounding."""
    links = [
        link | {"rod": [segment | {"nodes": nodes} for segment in link["rod"]]} if "rod" in link else link
        for link in description["links"]
    ]
    made = [make(each, lissom) for each in actuators]
    return build(description | {"links": links, "actuators": made}, lissom)


def assert_close(actual, desired, tolerance=1e-9, least=1e-6):
    """Compares relative to the largest value, or to `least`, because entries may vanish."""
    assert_allclose(actual, desired, rtol=0, atol=tolerance * max(least, np.abs(desired).max(initial=0)))


def assert_forces_agree(description, seed, drawn):
    reference, plain = build(description), with_actuators(description, [])
    q, v, a = random_states(reference, seed)
    actuated = Actuated(reference, q)
    without = plain.inverse_dynamics(q, v, a)
    for each in drawn(seed, description["links"]):
        actuator = make(each)
        force = with_actuators(description, [each]).inverse_dynamics(q, v, a) - without
        expected = actuated.force(actuator, v)
        tolerance = LOOSE if getattr(actuator, "friction", 0) > 0 else 1e-8
        # Differences of all forces have an error of some hundred times the rounding errors of these.
        scale = max(np.abs(expected).max(), 1e-5 * np.abs(without).max(), 1e-5)
        assert_allclose(force, expected, rtol=0, atol=tolerance * scale, err_msg=str(each))


@kinds
@few
@given(robots(max_links=4), seeds)
def test_forces_of_random_actuators_are_those_of_the_reference(drawn, description, seed):
    assert_forces_agree(description, seed, drawn)


@kinds
@pytest.mark.parametrize(("description", "kernel"), [(PLANAR, "planar"), (LONG, "spatial")])
def test_forces_in_the_plane_and_on_long_chains(description, kernel, drawn):
    assert with_actuators(description, []).kernel == kernel
    assert_forces_agree(description, 3, drawn)


@kinds
@few
@given(robots(max_links=4), seeds)
def test_lengths_volumes_and_gradients_are_those_of_the_reference(drawn, description, seed):
    reference = build(description)
    q, v, _ = random_states(reference, seed)
    actuated = Actuated(reference, q)
    descriptions = drawn(seed, description["links"])
    robot = with_actuators(description, descriptions)
    for each, own in zip(descriptions, robot.actuators, strict=True):
        actuator = make(each)
        if isinstance(actuator, Tendon):
            value, gradient = actuated.length(actuator), actuated.length_gradient(actuator)
            assert_close(robot.actuator_force(own.name, q, v), actuated.tension(actuator, v), 1e-8)
        elif isinstance(actuator, Chamber):
            value, gradient = actuated.volume_and_gradient(actuator)
        elif isinstance(actuator, Motor):
            gradient = np.eye(robot.n)[robot.slice(actuator.joint).start]
            value = q @ gradient
        else:
            continue
        assert_allclose(robot.actuator_length(own.name, q), value, rtol=1e-9, atol=1e-15)
        # Lengths between points of one link do not change, nor do volumes along rigid parts; the reference
        # computes them with the rounding error of a metre, and of the volume.
        least = {Tendon: 1e-3, Chamber: abs(value)}.get(type(actuator), 0.0)
        assert_close(robot.actuator_gradient(own.name, q), gradient, least=least)
        assert_close(robot.actuator_rate(own.name, q, v), gradient @ v, least=least)


@kinds
@few
@given(robots(max_links=4), seeds)
def test_tangents_with_actuators_are_the_derivatives(drawn, description, seed):
    reference = build(description)
    robot = with_actuators(description, drawn(seed, description["links"]), nodes=12)
    state = random_states(reference, seed)
    step = 1e-6
    size = np.abs(robot.inverse_dynamics(*state)).max()
    for part, tangent in enumerate(robot.tangent(*state)):
        differences = np.empty((robot.n, robot.n))
        for k in range(robot.n):
            shift = np.zeros((3, robot.n))
            shift[part, k] = step
            ahead, behind = robot.inverse_dynamics(*(state + shift)), robot.inverse_dynamics(*(state - shift))
            differences[:, k] = (ahead - behind) / (2 * step)
        atol = 1e-6 * np.abs(differences).max(initial=0) + 1e-14 / step * size
        assert_allclose(tangent, differences, rtol=0, atol=atol)


# Friction is smoothed over 0.1 m/s here, which is said.
@pytest.mark.filterwarnings("ignore:Friction of the tendon:lissom.AccuracyWarning")
@kinds
def test_long_chains_move_alike_link_by_link_and_with_all_entries(drawn):
    """Newmark steps are solved link by link, those of Radau with the full matrix."""
    robot = with_actuators(LONG, drawn(1, LONG["links"]), nodes=8)
    tips = []
    for options in ({"dt": 2e-4}, {"method": "radau", "rtol": 1e-7, "atol": 1e-7, "dt": 0.01}):
        motion = lissom.simulate(robot, 0.03, **options)
        assert motion.success, motion.message
        tips.append(robot.pose(motion.q[-1], link="arm")[:3, 3])
    start = robot.pose(np.zeros(robot.n), link="arm")[:3, 3]
    assert np.linalg.norm(tips[1] - start) > 5e-3
    assert_allclose(tips[0], tips[1], rtol=0, atol=2e-3 * np.linalg.norm(tips[1] - start))


@pytest.mark.parametrize("kind", [Tendon, Chamber, ActiveStrain])
def test_actuators_do_not_see_how_a_rod_is_divided(kind):
    """One segment, or the same rod in two: the power is the same for a common motion."""
    rubber = {"young_modulus": 1e5, "shear_modulus": 4e4, "density": 1000.0, "nodes": 24}
    modes = {"torsion": 1, "bend_y": 1, "bend_z": 1, "stretch": 1}
    strains = np.array([0.8, 1.5, -2.0, 0.05])
    offset = (([0.0, 0.1, 0.3], [0.01, 0.0, 0.008]), (0.01, -0.01))
    path = [lissom.Along("rod", offset, (0.05, 0.27))]
    made = {
        Tendon: lambda: lissom.Tendon("it", path, tension=2.0),
        Chamber: lambda: lissom.Chamber("it", path, 1e-4, 1e4),
        ActiveStrain: lambda: lissom.ActiveStrain("rod", "bend_y", (0.2, 1.0), 2.0, name="it"),
    }[kind]

    def power(lengths):
        rod = [lissom.Segment(length, 0.01, modes=modes, **rubber) for length in lengths]
        robots = [
            lissom.Robot([lissom.Link("rod", rod=rod)], actuators=actuators) for actuators in ([made()], [])
        ]
        q, v = np.tile(strains, len(lengths)), np.tile([1.0, -2.0, 0.5, 0.1], len(lengths))
        forces = [robot.inverse_dynamics(q, 0 * q, 0 * q) for robot in robots]
        return (forces[0] - forces[1]) @ v

    assert_allclose(power([0.1, 0.2]), power([0.3]), rtol=1e-9)
