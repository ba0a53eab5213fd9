"""Contacts too soft for a rod are said, with a stiffness that bears it: nothing sinks through obstacles."""

import re

import numpy as np
import pytest

import lissom

# A wire of a metre over a bar that reaches across it, and the height of the middle of the bar.
LENGTH, RADIUS, YOUNG_MODULUS, PLACE, HEIGHT, HALF = 1.0, 2e-3, 5e10, 0.6, -0.05, 7.5e-3

CUBE = [(i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
FACES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
FACES += [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]


def obstacle(kind):
    """A bar along y, or a ball."""
    middle, (left, right) = (PLACE, 0.0, HEIGHT), ((PLACE, y, HEIGHT) for y in (-0.3, 0.3))
    if kind == "box":
        return lissom.Box(middle, (HALF, 0.3, HALF))
    if kind == "capsule":
        return lissom.Capsule(left, right, HALF)
    if kind == "mesh":
        corners = np.array(CUBE) * (0.7 * HALF, 0.3, 0.7 * HALF) + middle
        return lissom.ConvexMesh(corners, FACES, radius=0.3 * HALF)
    if kind == "pipe":
        return lissom.Tube([left, right], HALF, wall=0.6 * HALF)
    return lissom.Sphere(middle, HALF)


def over_a_bar(kind, stiffness, *, radius=RADIUS, half=None, load=30.0):
    """The clamped wire, whose weight w has w L^3 / (E I) = 30."""
    density = load * YOUNG_MODULUS * radius**2 / 4 / (9.81 * LENGTH**3)
    segment = lissom.Segment(
        LENGTH, radius, YOUNG_MODULUS, poisson_ratio=0.3, density=density, modes={"bend_y": 6}
    )
    shape = lissom.Box((PLACE, 0, HEIGHT), (half, 0.3, half)) if half else obstacle(kind)
    contact = lissom.Contact("rod", shape, stiffness=stiffness, name="bar")
    return lissom.Robot([lissom.Link("rod", rod=[segment])], contacts=[contact])


def height(robot, q):
    """Of the middle of the rod above the middle of the bar; infinite where it does not reach there."""
    places = robot.pose(q, np.linspace(0, LENGTH, 401), link="rod")[:, :3, 3]
    return np.interp(PLACE, places[:, 0], places[:, 2], right=-np.inf) - HEIGHT


def named(message):
    """The stiffness to which a message raises that of the contact."""
    found = re.search(
        r'contact "bar" is soft for its load.* raise `stiffness` from \S+ to (\S+) N/m\^2', message
    )
    assert found, message
    return float(found.group(1))


@pytest.mark.parametrize("kind", ["box", "capsule", "mesh", "pipe", "sphere"])
@pytest.mark.parametrize("stiffness", [1e3, 1e4, 1e5, 3e5])
@pytest.mark.parametrize("way", ["released", "loaded", "loaded in steps"])
@pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")
def test_a_wire_does_not_sink_through_a_bar(kind, stiffness, way):
    def searched(stiffness):
        robot = over_a_bar(kind, stiffness)
        options = {"released": {"q0": np.zeros(robot.n)}, "loaded in steps": {"load_steps": 5}}
        return robot, lissom.statics(robot, **options.get(way, {}))

    robot, found = searched(stiffness)
    assert not found.success
    assert found.status == "deep_penetration", found.message
    assert height(robot, found.q) > 0
    robot, found = searched(named(found.message))
    assert found.success, found.message
    assert height(robot, found.q) > 0
    assert found.deepest.share < 0.35


@pytest.mark.parametrize("stiffness", [3e2, 3e3, 3e4])
@pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")
def test_a_path_into_a_bar_thinner_than_the_wire_does_not_go_on_behind_it(stiffness):
    """At its end the axis of the wire is in the bar; a search from there could leave on either side."""
    robot = over_a_bar("box", stiffness, radius=5.6e-3, half=3.7e-3, load=40.0)
    found = lissom.statics(robot, load_steps=5)
    assert not found.success
    assert height(robot, found.q) > 0
    robot = over_a_bar("box", named(found.message), radius=5.6e-3, half=3.7e-3, load=40.0)
    found = lissom.statics(robot, load_steps=5)
    assert found.success, found.message
    assert height(robot, found.q) > 0


@pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")
def test_continuation_ends_at_the_bar_and_names_the_stiffness():
    robot = over_a_bar("capsule", 1e4)
    path = lissom.continuation(robot, load_factor=0.0, bounds=(0.0, 1.0))
    assert path.status == "deep_penetration", path.message
    assert height(robot, path.path.q[-1]) > 0
    robot = over_a_bar("capsule", named(path.message))
    path = lissom.continuation(robot, load_factor=0.0, bounds=(0.0, 1.0))
    assert path.success, path.message
    assert height(robot, path.path.q[-1]) > 0


@pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")
def test_newtons_method_does_not_jump_behind_the_bar():
    """From a shape above it, the equilibrium behind is the only one of so soft a contact."""
    robot = over_a_bar("box", 1e3)
    found = lissom.statics(robot, np.zeros(robot.n), method="newton")
    assert not found.success
    assert height(robot, found.q) > 0


@pytest.mark.parametrize("stiffness", [1.0, 10.0, 100.0])
def test_a_ball_does_not_sink_through_a_shelf(stiffness):
    """A ball of 10 N on a rail. One typed number suffices: nothing bears more than the weight."""

    def dropped(stiffness):
        rail = lissom.Prismatic((0, 0, 1))
        link = lissom.Link("ball", joint=rail, body=lissom.Body(10 / 9.81), position=(0, 0, 0.1))
        shelf = lissom.Box((0, 0, 0), (0.2, 0.2, 0.02))
        contacts = [
            lissom.Contact(lissom.Ball("ball", 0.03), shelf, stiffness=stiffness, name="bar"),
            lissom.Contact(lissom.Ball("ball", 0.03), lissom.HalfSpace((0, 0, -1)), stiffness=1e5),
        ]
        return lissom.statics(lissom.Robot([link], contacts=contacts), [0.0])

    found = dropped(stiffness)
    assert found.status == "deep_penetration", found.message
    assert found.q[0] > -0.1
    number = re.search(r'"bar" is soft .* to (\S+) N/m', found.message)
    assert number, found.message
    found = dropped(float(number.group(1)))
    assert found.success, found.message
    assert found.q[0] > -0.1
    assert found.deepest.share < 0.35
