"""The NumPy references of actuators compared with closed forms, differences, and published robots."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from numpy.testing import assert_allclose

from reference.actuation import ActiveStrain, Actuated, Along, Chamber, Motor, Tendon, Via
from reference.random_actuators import make, random_others, random_tendons
from reference.random_robots import random_states, robots, seeds
from reference.robot import build
from reference.tendon_rod import (
    RUCKER_AND_WEBSTER,
    RUCKER_AND_WEBSTER_TIPS,
    TILL,
    TILL_VALUES,
    TendonRod,
    helical,
    helix,
)

L, D, KAPPA, STRETCH = 0.4, 0.01, 3.0, 0.97
# Shrinking would take minutes.
few = settings(max_examples=4, phases=[Phase.generate])


def bent(**modes):
    """A rod, and its shape with constant curvature about y and constant stretch."""
    segment = {"length": L, "radius": 0.01, "young_modulus": 1e5, "shear_modulus": 4e4, "density": 1000.0}
    modes = {"bend_y": 1, "stretch": 1, **modes}
    robot = build({"links": [{"name": "rod", "rod": [segment | {"modes": modes}]}]})
    q = np.zeros(robot.n)
    strains = list(robot.links[0].rod[0].coordinates[0])
    q[strains.index(1)], q[strains.index(3)] = KAPPA, STRETCH - 1
    return Actuated(robot, q)


def test_length_and_gradient_of_a_parallel_tendon():
    tendon = Tendon("t", [Along("rod", (0.0, D))], tension=1.0)
    actuated = bent()
    # u_x = stretch + (kappa x d)_x = stretch + kappa_y z.
    assert_allclose(actuated.length(tendon), L * (STRETCH + KAPPA * D), rtol=1e-12)
    assert_allclose(actuated.length_gradient(tendon), [L * D, L], rtol=1e-12)


def test_length_of_a_helix_on_a_twisted_rod():
    """The rod's twist adds to that of the helix: length = L hypot(stretch, D (pitch + twist))."""
    pitch, twist = 12.0, 5.0
    offset = (lambda X: D * np.cos(pitch * X), lambda X: D * np.sin(pitch * X))
    actuated = bent(torsion=1)
    actuated = Actuated(actuated.robot, [twist, 0.0, STRETCH - 1])
    tendon = Tendon("t", [Along("rod", offset)], tension=1.0, friction=0.3, sliding=1.0)
    speed = np.hypot(STRETCH, D * (pitch + twist))
    assert_allclose(actuated.length(tendon), L * speed, rtol=1e-12)
    # A helix turns its tangent by D (pitch + twist)^2 / speed per unit length.
    turned = sum(part.turned[-1] for part in actuated.parts(tendon.path))
    assert_allclose(turned, L * D * (pitch + twist) ** 2 / speed, rtol=1e-9)


def test_friction_of_a_parallel_tendon():
    """On an arc of angle a: T d int exp(-mu kappa X) dX."""
    mu, tension = 0.4, 2.0
    tendon = Tendon("t", [Along("rod", (0.0, -D))], tension=tension, friction=mu, sliding=1.0)
    felt = (1 - np.exp(-mu * KAPPA * L)) / (mu * KAPPA)
    assert_allclose(bent().force(tendon, np.zeros(2)), tension * felt * np.array([-D, 1]), rtol=1e-10)


def test_volume_of_a_bent_chamber():
    chamber = Chamber("c", [Along("rod", (0.002, D), (0.1, 0.3))], 3e-5, 1e4)
    volume, gradient = bent().volume_and_gradient(chamber)
    assert_allclose(volume, 3e-5 * 0.2 * (STRETCH + KAPPA * D), rtol=1e-12)
    assert_allclose(gradient, 3e-5 * 0.2 * np.array([D, 1]), rtol=1e-11)


def test_active_strain_of_a_uniform_rod():
    """The rod is in equilibrium where its strain equals the active strain."""
    actuated = bent()
    EI = np.pi * 0.01**4 / 4 * 1e5
    force = actuated.force(ActiveStrain("rod", "bend_y", 1.0, KAPPA), np.zeros(2))
    assert_allclose(force, [-EI * L * KAPPA, 0], rtol=1e-12, atol=1e-14)


def test_a_servo_pulls_towards_its_position():
    hinge = {"type": "revolute", "axis": (0, 1, 0)}
    body = {"mass": 1.0, "inertia": (1.0, 1.0, 1.0)}
    robot = build({"links": [{"name": "bar", "joint": hinge, "body": body}]})
    motor = Motor("bar", position=0.5, gains=(3.0, 0.2))
    assert_allclose(Actuated(robot, [0.1]).force(motor, [2.0]), [-3.0 * 0.4 + 0.2 * 2.0], rtol=1e-14)


def test_a_straight_line_between_points():
    slide = {"type": "prismatic", "axis": (1, 0, 0)}
    robot = build({"links": [{"name": "cart", "joint": slide, "body": {"mass": 1.0}}]})
    tendon = Tendon("t", [Via(None, (0, 3, 0)), Via("cart")], tension=1.0)
    actuated = Actuated(robot, [4.0])
    assert_allclose(actuated.length(tendon), 5.0, rtol=1e-15)
    assert_allclose(actuated.length_gradient(tendon), [0.8], rtol=1e-15)


@few
@given(robots(max_links=3), seeds)
def test_gradients_are_differences_of_lengths_and_volumes(description, seed):
    robot = build(description)
    q = random_states(robot, seed)[0]
    direction = np.random.default_rng(seed).standard_normal(robot.n)
    step = 1e-4
    links = description["links"]
    tendons = [make(each) for each in random_tendons(seed, links, points=True)]
    chambers = [make(each) for each in random_others(seed, links) if each[0] == "Chamber"]

    def along(x):
        actuated = Actuated(robot, q + x * direction, gradients=False)
        lengths = [actuated.length(each) for each in tendons]
        return np.array(lengths + [actuated.volume_and_gradient(each)[0] / each.area for each in chambers])

    # Fourth-order differences.
    difference = (8 * (along(step) - along(-step)) - along(2 * step) + along(-2 * step)) / (12 * step)
    actuated = Actuated(robot, q)
    gradients = [actuated.length_gradient(each) for each in tendons]
    gradients += [actuated.volume_and_gradient(each)[1] / each.area for each in chambers]
    rates = np.array(gradients) @ direction
    # Lengths are sums and differences of places, which are rounded.
    size = np.abs(along(0.0)).max(initial=0.0) + np.abs(q).max(initial=0.0) + 1.0
    rounding = 8 * np.finfo(float).eps * size / step
    assert_allclose(rates, difference, rtol=1e-7, atol=1e-7 * np.abs(rates).max(initial=0.0) + rounding)


@pytest.mark.parametrize("seed", range(3))
def test_work_of_friction_is_lost(seed):
    """The end of a sliding tendon does at least as much work as the robot receives, in either direction."""
    rng = np.random.default_rng(seed)
    actuated = bent()
    tendon = Tendon("t", [Along("rod", (0.0, -D))], tension=1.0, friction=0.5, friction_velocity=1e-9)
    v = rng.standard_normal(2)
    rate = actuated.length_gradient(tendon) @ v
    assert actuated.force(tendon, v) @ v * np.sign(rate) > 0
    assert -actuated.force(tendon, v) @ v <= -rate + 1e-15


@pytest.mark.parametrize(("tension", "values"), TILL_VALUES.items())
def test_tendon_robot_of_till(tension, values):
    tip, lengths, moment = TILL.equilibrium([tension])
    assert_allclose([tip[0], tip[2], lengths[0], moment[1]], values, rtol=0, atol=2e-12)
    assert_allclose(tip[1], 0, atol=1e-15)


@pytest.mark.slow
@pytest.mark.parametrize(("tensions", "tip"), RUCKER_AND_WEBSTER_TIPS.items())
def test_robot_of_rucker_and_webster(tensions, tip):
    assert_allclose(RUCKER_AND_WEBSTER.equilibrium(tensions)[0], tip, rtol=0, atol=6e-12)


def test_helical_tendon_by_shooting_and_in_closed_form():
    rate = 2 * np.pi / 0.3
    rod = TendonRod(0.3, 1e-3, 5e9, 2e9, 1000.0, [helical(8e-3, 0.0, rate)])
    tip, *_ = rod.equilibrium([1.0])
    assert_allclose(helix(rod, rate, 1.0)[:3, 3], tip, rtol=0, atol=1e-11)
