"""Wrenches inside a rod where it touches something: what is spread along it is cut."""

import numpy as np
import pytest

import lissom

LENGTH, RADIUS, STIFFNESS = 0.5, 0.01, 1e5


def rod(name, size):
    segment = lissom.Segment(
        LENGTH * size, RADIUS * size, 1e6, poisson_ratio=0.4, density=1e3, modes={"bend_y": 3}
    )
    return lissom.Link(name, rod=[segment], joint=lissom.Free())


def force_beyond(links, contact, q, link, places):
    """Upward force of contact on what lies beyond places of a link."""
    touching, bare = lissom.Robot(links, contacts=[contact]), lissom.Robot(links)
    rest = np.zeros_like(q)

    def force(place):
        wrenches = [robot.internal_wrench(q, rest, rest, place, link=link) for robot in (bare, touching)]
        return (touching.pose(q, place, link=link)[:3, :3] @ (wrenches[0] - wrenches[1])[3:])[2]

    return np.array([force(place) for place in places])


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_pressure_of_a_floor_beyond_a_cut(size):
    """A straight rod, tilted, in a floor along its whole length: depth and force per length are linear."""
    tilt, depth = 0.004, 1e-3 * size
    q = np.zeros(6 + 3)
    q[2], q[4] = RADIUS * size - depth, tilt
    floor = lissom.Contact("rod", lissom.HalfSpace((0, 0, 0)), stiffness=STIFFNESS)
    length = LENGTH * size
    places = np.linspace(0, length, 101)
    found = force_beyond([rod("rod", size)], floor, q, "rod", places)
    exact = STIFFNESS * (depth * (length - places) + np.sin(tilt) * (length**2 - places**2) / 2)
    np.testing.assert_allclose(found, exact, atol=3e-6 * exact[0])


@pytest.mark.parametrize("is_turned", [False, True])
def test_rods_that_lie_on_each_other_balance_beyond_every_cut(is_turned):
    """Forces per length are the same all along, on both rods, also where these go opposite ways."""
    q = np.zeros(2 * (6 + 3))
    q[9 + 2] = 1.9 * RADIUS
    if is_turned:
        q[9], q[9 + 5] = LENGTH, np.pi
    links, contact = [rod("lower", 1), rod("upper", 1)], lissom.Contact("lower", "upper", stiffness=STIFFNESS)
    places = np.linspace(0, LENGTH, 101)
    exact = STIFFNESS * 0.1 * RADIUS * (LENGTH - places)
    for link, sign in (("lower", -1), ("upper", 1)):
        found = force_beyond(links, contact, q, link, places)
        np.testing.assert_allclose(found, sign * exact, atol=1e-9 * exact[0])


def test_what_touches_in_part_is_cut_without_jumps():
    """A tilted rod, of which one half is in the floor: the force beyond a cut is continuous."""
    q = np.zeros(6 + 3)
    q[2], q[4] = RADIUS + 1e-3, 0.004
    floor = lissom.Contact("rod", lissom.HalfSpace((0, 0, 0)), stiffness=STIFFNESS)
    places = np.linspace(0, LENGTH, 1001)
    found = force_beyond([rod("rod", 1)], floor, q, "rod", places)
    depth = np.maximum(np.sin(0.004) * places - 1e-3, 0)
    assert np.all(np.abs(np.diff(found)) <= 1.02 * STIFFNESS * depth.max() * places[1])
    first = 1e-3 / np.sin(0.004)
    beyond = np.maximum(places, first)
    exact = STIFFNESS * np.sin(0.004) * ((LENGTH - first) ** 2 - (beyond - first) ** 2) / 2
    np.testing.assert_allclose(found, exact, atol=1e-5 * exact[0])
