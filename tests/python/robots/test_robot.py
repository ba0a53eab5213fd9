"""`lissom.Robot` compared with the NumPy reference, which shares no formula with it."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from numpy.testing import assert_allclose

import lissom
from reference.random_robots import random_states, robots, seeds
from reference.robot import build
from reference.robot_table import PATH

TABLE = json.loads(PATH.read_text(encoding="utf-8"))["robots"]
few = settings(max_examples=10)


def fine(description):
    """The robot with enough nodes that its rods are exact to rounding, as in the reference."""
    links = [
        link | {"rod": [segment | {"nodes": 32} for segment in link["rod"]]} if "rod" in link else link
        for link in description["links"]
    ]
    return build(description | {"links": links}, lissom)


def assert_close(actual, desired, tolerance=1e-9):
    """Compares relative to the largest value, because entries may vanish."""
    assert_allclose(actual, desired, rtol=0, atol=tolerance * max(1e-6, np.abs(desired).max(initial=0)))


@pytest.mark.parametrize("row", TABLE, ids=lambda row: row["name"])
def test_values_are_those_of_the_table(row):
    robot = fine(row["description"])
    assert robot.n == row["n"] == len(robot.coordinates)
    for state in row["states"]:
        q, v, a = (np.array(state[key]) for key in "qva")
        assert_close(robot.inverse_dynamics(q, v, a), state["tau"])
        assert_close(robot.mass_matrix(q), state["mass_matrix"])
        energy = robot.energy(q, v)
        assert_close([energy.kinetic, energy.elastic, energy.gravitational, energy.loads], state["energy"])
        momentum = robot.momentum(q, v)
        assert_close(momentum, np.append(state["angular_momentum"], state["momentum"]))
        for name, link in state["links"].items():
            places = {None: link} if "pose" in link else link
            for X, value in places.items():
                X = None if X is None else float(X)
                assert_close(robot.pose(q, X, link=name), value["pose"])
                assert_close(robot.velocity(q, v, X, link=name), value["velocity"])


@few
@given(robots(), seeds)
def test_random_robots_move_as_the_reference_says(description, seed):
    reference, robot = build(description), fine(description)
    assert robot.n == reference.n
    q, v, a = random_states(reference, seed)
    tau = reference.inverse_dynamics(q, v, a)
    assert_close(robot.inverse_dynamics(q, v, a), tau)
    mass = reference.mass_matrix(q)
    assert_close(robot.mass_matrix(q), mass)
    assert_close(robot.centre_of_mass(q), reference.centre_of_mass(q))
    for link in reference.links:
        X = None if link.rod is None else 0.4 * reference.length(link.name)
        assert_close(robot.pose(q, X, link=link.name), reference.pose(q, X, link=link.name))


@few
@given(robots(), seeds)
def test_tangents_of_random_robots_are_the_derivatives(description, seed):
    reference, robot = build(description), build(description, lissom)
    q, v, a = random_states(reference, seed)
    n = robot.n
    step = 1e-6
    for part, tangent in enumerate(robot.tangent(q, v, a)):
        differences = np.empty((n, n))
        for k in range(n):
            shift = np.zeros((3, n))
            shift[part, k] = step
            differences[:, k] = (
                robot.inverse_dynamics(*(np.array([q, v, a]) + shift))
                - robot.inverse_dynamics(*(np.array([q, v, a]) - shift))
            ) / (2 * step)
        # Differences have errors of the rounding of the forces divided by the step.
        rounding = 1e-15 / step * np.abs(robot.inverse_dynamics(q, v, a)).max()
        size = np.abs(differences).max(initial=0)
        assert_allclose(tangent, differences, rtol=0, atol=1e-6 * size + 10 * rounding)


@few
@given(robots(), seeds)
def test_velocities_are_the_jacobian_times_the_rates(description, seed):
    reference, robot = build(description), build(description, lissom)
    q, v, _ = random_states(reference, seed)
    for link in robot.links:
        jacobian = robot.jacobian(q, link=link.name)
        assert_close(jacobian @ v, robot.velocity(q, v, link=link.name))
        both = robot.jacobian([q, q], link=link.name)
        assert both.shape == (2, 6, robot.n)
        assert_allclose(both[1], jacobian, rtol=0, atol=0)


@few
@given(robots(), seeds)
def test_accelerations_are_the_derivatives_of_velocities(description, seed):
    reference, robot = build(description), build(description, lissom)
    q, v, a = random_states(reference, seed)
    step = 1e-4
    for link in robot.links:
        X = None if link.rod is None else 0.4 * sum(segment.length for segment in link.rod)

        def velocity(t, at=(X, link.name)):
            return robot.velocity(q + v * t + a * t**2 / 2, v + a * t, at[0], link=at[1])

        # Fourth-order differences.
        difference = (8 * (velocity(step) - velocity(-step)) - (velocity(2 * step) - velocity(-2 * step))) / (
            12 * step
        )
        found = robot.acceleration(q, v, a, X, link=link.name)
        assert_close(found, difference, 1e-8)
        assert_allclose(
            robot.acceleration([q, q], [v, v], [a, a], X, link=link.name), [found, found], rtol=0, atol=0
        )


def test_accelerations_know_nothing_of_loads_and_need_no_time_for_them():
    load = lissom.Load(force=lissom.Harmonic((0, 0, 1), 2.0), link="tool")
    robots = [base_and_tool(), base_and_tool(loads=[load])]
    found = [robot.acceleration([], [], [], link="tool") for robot in robots]
    assert_allclose(found, 0, rtol=0, atol=0)


def test_rigid_body_motions_have_no_frequency():
    rod = lissom.Segment(1.0, 5e-3, 1e7, poisson_ratio=0.5, density=1000, modes={"bend_y": 4, "bend_z": 4})
    beam = lissom.Robot([lissom.Link("beam", rod=[rod], joint=lissom.Free())], gravity=(0, 0, 0))
    found = lissom.modes(beam, np.zeros(beam.n))
    assert_allclose(found.frequency[:6], 0, rtol=0, atol=0)
    assert_allclose(found.damping_ratio[:6], 0, rtol=0, atol=0)
    assert_allclose(found.eigenvalues[:6], 0, rtol=0, atol=0)
    # Frequency of a free beam, 22.37 sqrt(EI / (rho A L^4)).
    assert_allclose(found.frequency[6], 22.373 * 0.25 / (2 * np.pi), rtol=0.01)
    assert found.stability == "neutral"


def base_and_tool(**options):
    """Two rigid links without coordinates."""
    half_turn = (0, 0, 1, 0)
    tool = lissom.Link("tool", parent="base", position=(0.1, 0, 0), orientation=half_turn, body=HEAVY_TOOL)
    return lissom.Robot([lissom.Link("base", body=lissom.Body(1.0)), tool], **options)


#: Its centre of mass is beside its base.
HEAVY_TOOL = lissom.Body(0.5, centre=(0.2, 0, 0))


def test_a_joint_without_coordinates_carries_the_weight_behind_it():
    """About the joint, the centre lies 0.2 m backwards."""
    found = base_and_tool().joint_wrench([], [], [], link="tool")
    weight = 0.5 * 9.81
    assert_allclose(found, [0, 0.2 * weight, 0, 0, 0, weight], rtol=1e-14, atol=1e-14)


def test_a_joint_without_coordinates_on_a_base_that_turns_and_rises():
    """The centre of mass moves on a circle of 0.1 m about the z axis, behind the joint."""
    angle, rise = lissom.Harmonic(0.8, 0.5), lissom.Harmonic((0, 0, 0.3), 1.5)
    robot = base_and_tool(base_motion=lissom.BaseMotion(translation=rise, axis=(0, 0, 1), angle=angle))
    for t in (0.0, 0.13, 0.4, 0.13):
        turned, rate = (0.8 * f for f in (np.sin(np.pi * t), np.pi * np.cos(np.pi * t)))
        growth = -(np.pi**2) * turned
        raised = -0.3 * (3 * np.pi) ** 2 * np.sin(3 * np.pi * t)
        along = np.array([np.cos(turned), np.sin(turned), 0])
        across = np.array([-np.sin(turned), np.cos(turned), 0])
        force = 0.5 * (-0.1 * (growth * across - rate**2 * along) + np.array([0, 0, 9.81 + raised]))
        moment = np.cross(-0.2 * along, force)
        found = robot.joint_wrench([], [], [], link="tool", t=t)
        assert_allclose(found, [*moment, *force], rtol=1e-13, atol=1e-13)


def welded(kept_apart):
    """Links welded to a body, to frames, to a tip and inside a rod, on a shaken base."""
    random = np.random.default_rng(5)

    def body():
        inertia = np.diag(random.uniform(0.01, 0.012, 3))
        return lissom.Body(random.uniform(0.1, 1), centre=random.normal(size=3) * 0.1, inertia=inertia)

    def place():
        turn = random.normal(size=4)
        return {"position": random.normal(size=3) * 0.1, "orientation": turn / np.linalg.norm(turn)}

    modes = {"torsion": 1, "bend_y": 2, "bend_z": 1}
    rod = lissom.Segment(0.3, 0.01, 1e6, poisson_ratio=0.5, density=1000, modes=modes)
    links = [
        lissom.Link("base", joint=lissom.Free(), body=body()),
        lissom.Link("box", parent="base", body=body(), **place()),
        lissom.Link("frame", parent="box", **place()),
        lissom.Link("arm", parent="frame", joint=lissom.Revolute((0, 1, 0)), rod=[rod]),
        lissom.Link("tool", parent="arm", body=body(), **place()),
        lissom.Link("ball", parent="tool", joint=lissom.Spherical(), body=body(), **place()),
        lissom.Link("ring", parent="arm", at=0.1, body=body(), **place()),
        lissom.Link("hook", parent="ring", body=body(), **place()),
        lissom.Link("mark", parent="base"),
    ]
    # Links on which something acts remain separate, even if it has no effect.
    apart = [
        lissom.Load(force=(0, 0, 0), link=name) for name in ("box", "frame", "tool", "ring", "hook", "mark")
    ]
    weight = lissom.Load(force=lissom.Harmonic((0.3, 0.1, -0.2), 1.5), link="ball")
    shaken = lissom.BaseMotion(translation=lissom.Harmonic((0.1, 0, 0.05), 2.0))
    return lissom.Robot(links, loads=[weight, *(apart if kept_apart else [])], base_motion=shaken)


def test_links_that_are_welded_cost_nothing_and_change_nothing():
    one, apart = welded(False), welded(True)
    assert one.multiplications["residual"] < apart.multiplications["residual"]
    random = np.random.default_rng(6)
    q, v, a = random.normal(size=(3, one.n))

    def same(found, wanted):
        assert_allclose(found, wanted, rtol=1e-11, atol=1e-11)

    same(one.inverse_dynamics(q, v, a, t=0.3), apart.inverse_dynamics(q, v, a, t=0.3))
    for found, wanted in zip(one.tangent(q, v, a, t=0.3), apart.tangent(q, v, a, t=0.3), strict=True):
        same(found, wanted)
    same(one.momentum(q, v, t=0.3), apart.momentum(q, v, t=0.3))
    for link in one.links:
        at = {"link": link.name, "t": 0.3}
        same(one.pose(q, **at), apart.pose(q, **at))
        same(one.velocity(q, v, **at), apart.velocity(q, v, **at))
        same(one.jacobian(q, **at), apart.jacobian(q, **at))
        same(one.joint_wrench(q, v, a, **at), apart.joint_wrench(q, v, a, **at))
