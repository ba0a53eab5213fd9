"""Friction of tendons where embedded and straight parts meet, with the angle computed from poses."""

import numpy as np
import pytest

import lissom

FRICTION, TENSION, LENGTH = 0.7, 3.0, 0.3
HOLE = np.array([0.2, 0.05, 0.12])
MODES = {"torsion": 2, "bend_y": 2, "bend_z": 2, "stretch": 1, "shear_y": 1}
SEGMENT = lissom.Segment(
    LENGTH, 0.01, 1e6, 4e5, 1000.0, MODES, reference_strain=(0.5, 2.0, -1.0, 1.0, 0.0, 0.0), nodes=32
)


def offset(X):
    return np.array([0.006 + 0.004 * X / LENGTH, -0.005])


def embedded():
    return lissom.Along(
        "rod", offset=((offset(0.0)[0], offset(LENGTH)[0]), offset(0.0)[1]), along=(0.0, LENGTH)
    )


def rod(*tendons):
    link = lissom.Link("rod", rod=[SEGMENT])
    return lissom.Robot([link], gravity=(0, 0, 0), actuators=tendons)


def tendon(name, path, friction=FRICTION, sliding=1.0):
    return lissom.Tendon(name, path, tension=TENSION, friction=friction, sliding=sliding)


def place(robot, q, X):
    pose = robot.pose(q, X, link="rod")
    return pose[:3, :3] @ [0.0, *offset(X)] + pose[:3, 3]


def corner(robot, q, X):
    """Angle between the embedded path, by differences of positions, and the straight part at its end."""
    sign = 1 if X == 0.0 else -1
    h = sign * 1e-4
    weights = np.array([-25 / 12, 4.0, -3.0, 4 / 3, -1 / 4]) / h
    inside = sum(w * place(robot, q, X + k * h) for k, w in enumerate(weights))
    straight = (HOLE - place(robot, q, X)) * -sign
    return np.arctan2(np.linalg.norm(np.cross(inside, straight)), inside @ straight)


def turning(robot, q):
    """Total turning angle of the embedded path, from many points."""
    places = np.array([place(robot, q, X) for X in np.linspace(0, LENGTH, 4001)])
    ways = np.diff(places, axis=0)
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    turns = 2 * np.arcsin(np.linalg.norm(np.diff(ways, axis=0), axis=1) / 2)
    return turns.sum() + (turns[0] + turns[-1]) / 2


def state(seed):
    n = rod().n
    return np.random.default_rng(seed).normal(size=n) * np.array([2.0] * 6 + [0.05] * (n - 6))


def pull(robot, q):
    """Generalised forces of the tendon alone."""
    return robot.inverse_dynamics(q, 0 * q, 0 * q) - rod().inverse_dynamics(q, 0 * q, 0 * q)


@pytest.mark.parametrize("sliding", [1.0, -0.5])
@pytest.mark.parametrize("seed", range(4))
def test_behind_the_end_of_a_rod(seed, sliding):
    q = state(seed)
    hole = lissom.Via(None, tuple(HOLE))
    whole = rod(tendon("t", [embedded(), hole], sliding=sliding))
    inside = rod(tendon("t", [embedded()], sliding=sliding))
    straight = rod(tendon("t", [lissom.Via("rod", (0, *offset(LENGTH)), at=LENGTH), hole], friction=0.0))
    angle = turning(whole, q) + corner(whole, q, LENGTH)
    assert corner(whole, q, LENGTH) > 0.2
    ratio = np.exp(-FRICTION * sliding * angle)
    np.testing.assert_allclose(pull(whole, q), pull(inside, q) + ratio * pull(straight, q), rtol=0, atol=2e-5)


@pytest.mark.parametrize("seed", range(4))
def test_before_the_beginning_of_a_rod(seed):
    """The tendon goes from a hole in the world to a rod on a hinge: the straight part has no friction."""
    hole = lissom.Via(None, tuple(HOLE))

    def robot(path, friction=FRICTION):
        link = lissom.Link("rod", rod=[SEGMENT], joint=lissom.Revolute((0, 1, 0)))
        return lissom.Robot(
            [link], gravity=(0, 0, 0), actuators=[tendon("t", path, friction)] if path else []
        )

    q = np.append(0.3 * seed, state(seed))
    free = robot([]).inverse_dynamics(q, 0 * q, 0 * q)
    forces = {
        name: each.inverse_dynamics(q, 0 * q, 0 * q) - free
        for name, each in {
            "whole": robot([hole, embedded()]),
            "straight": robot([hole, lissom.Via("rod", (0, *offset(0.0)), at=0.0)]),
            "inside": robot([embedded()]),
        }.items()
    }
    ratio = np.exp(-FRICTION * corner(robot([]), q, 0.0))
    expected = forces["straight"] + ratio * forces["inside"]
    np.testing.assert_allclose(forces["whole"], expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("order", ["behind", "before", "between"])
def test_tangents_against_differences(order):
    hole = lissom.Via(None, tuple(HOLE))
    links = [
        lissom.Link("rod", rod=[SEGMENT], joint=lissom.Revolute((0, 1, 0))),
        lissom.Link(
            "tip", rod=[SEGMENT], parent="rod", joint=lissom.Revolute((0, 0, 1)), position=(0.05, 0, 0)
        ),
    ]

    def on(link):
        return lissom.Along(link, (0.006, -0.005), along=(0.0, LENGTH))

    paths = {
        "behind": [on("rod"), on("tip"), hole],
        "before": [hole, on("rod"), on("tip")],
        "between": [on("rod"), lissom.Via("tip", (0, 0.02, 0), at=0.0), on("tip"), hole],
    }
    pulled = lissom.Tendon("t", paths[order], tension=TENSION, friction=FRICTION, friction_velocity=0.3)
    robot = lissom.Robot(links, actuators=[pulled])
    random = np.random.default_rng(5)
    q, v = 0.4 * random.normal(size=(2, robot.n))
    stiffness, damping, _ = robot.tangent(q, v, 0 * q)
    h = 1e-5
    for which, exact in (("q", stiffness), ("v", damping)):
        for k in range(robot.n):
            e = h * np.eye(robot.n)[k]
            ends = [
                robot.inverse_dynamics(q + s * e, v, 0 * q)
                if which == "q"
                else robot.inverse_dynamics(q, v + s * e, 0 * q)
                for s in (1, -1)
            ]
            difference = (ends[0] - ends[1]) / (2 * h)
            np.testing.assert_allclose(exact[:, k], difference, rtol=0, atol=1e-7 * np.abs(exact).max())


def test_a_tendon_that_leaves_along_itself_loses_nothing():
    plain = lissom.Segment(LENGTH, 0.01, 1e6, 4e5, 1000.0, {"bend_y": 2})
    path = [lissom.Along(offset=(0.0, 0.008)), lissom.Via(None, (2 * LENGTH, 0.0, 0.008))]
    at_rest = np.zeros(2)
    with_friction, without = (
        lissom.Rod([plain], gravity=(0, 0, 0), actuators=[tendon("t", path, mu)]) for mu in (FRICTION, 0.0)
    )
    forces = [each.inverse_dynamics(at_rest, at_rest, at_rest) for each in (with_friction, without)]
    np.testing.assert_allclose(*forces, rtol=0, atol=1e-12)
