"""Actuators of `lissom` against the NumPy reference, which shares no formula with them."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from numpy.testing import assert_allclose

import lissom
from reference.actuation import ActiveStrain, Actuated, Chamber, Motor, Tendon
from reference.random_actuators import make, random_actuators
from reference.random_robots import random_states, robots, seeds
from reference.robot import build

# Shrinking would take minutes.
few = settings(max_examples=6, phases=[Phase.generate])


def with_actuators(description, actuators, nodes=32):
    """The robot by `lissom`, with so many nodes that its rods are exact to rounding."""
    links = [
        link | {"rod": [segment | {"nodes": nodes} for segment in link["rod"]]} if "rod" in link else link
        for link in description["links"]
    ]
    made = [make(each, lissom) for each in actuators]
    return build(description | {"links": links, "actuators": made}, lissom)


def assert_close(actual, desired, tolerance=1e-9):
    """Relative to the largest value: entries may vanish."""
    assert_allclose(actual, desired, rtol=0, atol=tolerance * max(1e-6, np.abs(desired).max(initial=0)))


@few
@given(robots(max_links=4), seeds)
def test_forces_of_random_actuators_are_those_of_the_reference(description, seed):
    reference, plain = build(description), with_actuators(description, [])
    q, v, a = random_states(reference, seed)
    actuated = Actuated(reference, q)
    for each in random_actuators(seed, description["links"]):
        robot, actuator = with_actuators(description, [each]), make(each)
        force = robot.inverse_dynamics(q, v, a) - plain.inverse_dynamics(q, v, a)
        expected = actuated.force(actuator, v)
        # Table offsets have jumps in their second derivative, and |dt/dX| may have kinks: friction sees both.
        has_friction = getattr(actuator, "friction", 0) > 0
        scale = max(np.abs(expected).max(), 1e-6 * np.abs(plain.inverse_dynamics(q, v, a)).max(), 1e-6)
        assert_allclose(force, expected, rtol=0, atol=(1e-4 if has_friction else 1e-8) * scale)


@few
@given(robots(max_links=4), seeds)
def test_lengths_volumes_and_gradients_are_those_of_the_reference(description, seed):
    reference = build(description)
    q, v, _ = random_states(reference, seed)
    actuated = Actuated(reference, q)
    drawn = random_actuators(seed, description["links"])
    robot = with_actuators(description, drawn)
    for each, own in zip(drawn, robot.actuators, strict=True):
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
        assert_close(robot.actuator_gradient(own.name, q), gradient)
        assert_close(robot.actuator_rate(own.name, q, v), gradient @ v)


@few
@given(robots(max_links=4), seeds)
def test_tangents_with_actuators_are_the_derivatives(description, seed):
    drawn = random_actuators(seed, description["links"])
    reference, robot = build(description), with_actuators(description, drawn, nodes=12)
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


@pytest.mark.parametrize("kind", [Tendon, Chamber, ActiveStrain])
def test_actuators_of_several_rods_do_not_see_how_a_rod_is_divided(kind):
    """One segment, or the same rod in two: lengths, volumes and forces of a shape that both have."""
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

    def work(pieces):
        rod = [lissom.Segment(length, 0.01, modes=modes, **rubber) for length in pieces]
        robots = [
            lissom.Robot([lissom.Link("rod", rod=rod)], actuators=actuators) for actuators in ([made()], [])
        ]
        q, v = np.tile(strains, len(pieces)), np.tile([1.0, -2.0, 0.5, 0.1], len(pieces))
        forces = [robot.inverse_dynamics(q, 0 * q, 0 * q) for robot in robots]
        return (forces[0] - forces[1]) @ v

    assert_allclose(work([0.1, 0.2]), work([0.3]), rtol=1e-9)
