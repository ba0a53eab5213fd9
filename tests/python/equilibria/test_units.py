"""The same robots in other units, with other masses, and beside parts that have nothing to do with them.

The status must be the same and the answer the scaled one. There are no expected numbers here: every case is
compared with itself.
"""

import dataclasses

import numpy as np
import pytest

import lissom
from reference.units import L, converted, same, scaled, shape

#: Factors of the numbers of lengths, masses and times.
UNITS = {
    "millimetres": (1e3, 1, 1),
    "kilometres": (1e-3, 1, 1),
    "a thousand times the mass": (1, 1e3, 1),
    "a thousandth of the mass": (1, 1e-3, 1),
    "milliseconds": (1, 1, 1e3),
    "all": (1e3, 1e-3, 1e3),
}


HINGE = lissom.Revolute((0, 1, 0))

#: Runs of a step or two, for their starts, are not accurate.
starts = pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")


def rod(length=0.5, modes=None, radius=5e-3):
    return lissom.Segment(length, radius, 1e6, 4e5, 1000, modes=modes or {"bend_y": 3})


def tree():
    """A rod on a sprung hinge, with a body on a slider at its tip."""
    links = [
        lissom.Link("arm", joint=lissom.Revolute((0, 1, 0), stiffness=0.5), rod=[rod(0.2), rod(0.3)]),
        lissom.Link(
            "slide",
            parent="arm",
            joint=lissom.Prismatic((1, 0, 0), stiffness=30.0),
            body=lissom.Body(0.02, centre=(1e-6, 0, 0), inertia=(1e-6, 1e-6, 1e-6)),
        ),
    ]
    return lissom.Robot(links)


def linkage():
    """A four-bar linkage, open at zero, with a soft coupler and a spring at its crank."""
    links = [
        lissom.Link("crank", joint=lissom.Revolute((0, 1, 0), stiffness=0.3, damping=0.05), body=bar(0.1)),
        lissom.Link("coupler", parent="crank", position=(0.1, 0, 0), joint=HINGE, rod=[rod(0.2)]),
        lissom.Link("rocker", parent="coupler", joint=HINGE, body=bar(0.15)),
    ]
    pin = lissom.Loop(("rocker", None, (0.15, 0, 0)), (None, None, (0.2, 0, -0.05)), HINGE)
    return lissom.Robot(links, loops=[pin])


def bar(length, mass=0.05):
    inertia = mass * length**2 / 12
    return lissom.Body(mass, centre=(length / 2, 0, 0), inertia=(1e-3 * inertia, inertia, inertia))


def arch(mass=1000.0, height=0.0):
    """A straight rod whose hinged end belongs 10 % nearer."""
    segment = lissom.Segment(0.1, 5e-3, 1e6, 4e5, mass, modes={"bend_y": 2, "stretch": 1})
    pin = lissom.Loop("line", (None, None, (0.45, 0, height)), HINGE)
    return lissom.Robot([lissom.Link("line", joint=HINGE, rod=[segment] * 5)], loops=[pin])


CORNERS = [(0.05, 0.05), (-0.05, -0.05), (-0.05, 0.05), (0.05, -0.05)]


def hung(stiffness=None):
    """A plate on four cords that are too long to be taut at the start."""
    plate = lissom.Link(
        "plate", joint=lissom.Free(), body=lissom.Body(0.2, centre=(0, 0, -0.02), inertia=(3e-4, 3e-4, 5e-4))
    )
    cords = [
        lissom.Tendon(
            f"cord {i}",
            [lissom.Via(None, (2 * x, 2 * y, 0.4)), lissom.Via("plate", (x, y, 0))],
            length=lissom.Input(f"length {i}", 0.25),
            stiffness=stiffness,
        )
        for i, (x, y) in enumerate(CORNERS)
    ]
    return lissom.Robot([plate], actuators=cords)


def floor():
    """A ball above a floor."""
    ball = lissom.Link("ball", joint=lissom.Free(), body=lissom.Body(0.1, inertia=(1e-5, 1e-5, 1e-5)))
    contact = lissom.Contact(lissom.Ball("ball", 0.02), lissom.HalfSpace(), stiffness=1e4, dissipation=0.5)
    return lissom.Robot([ball], contacts=[contact])


def start(robot, q0, units):
    return None if q0 is None else shape(robot, q0, units)


ABOVE = [0.01, 0.02, 0.2, 0.1, 0.2, 0.05]
ROBOTS = {
    "tree": (tree, None),
    "linkage": (linkage, None),
    "arch": (arch, None),
    "cords": (hung, ABOVE),
    "cables": (lambda: hung(2e3), ABOVE),
    "floor": (floor, [0, 0, 0.1, 0.1, 0.2, 0.3]),
}

units = pytest.mark.parametrize("units", UNITS.values(), ids=UNITS)


@starts
@units
@pytest.mark.parametrize("name", ["tree", "linkage", "arch", "cords", "cables", "floor"])
def test_starts_of_runs_are_the_same_in_all_units(name, units):
    make, q0 = ROBOTS[name]
    robot = make()
    t_end, dt = 2e-3, 1e-3
    expected = lissom.simulate(robot, t_end, dt=dt, q0=q0)
    factor = units[2]
    other = converted(robot, units)
    found = lissom.simulate(other, t_end * factor, dt=dt * factor, q0=start(robot, q0, units))
    assert found.status == expected.status == "finished"
    same(robot, found.q[0], expected.q[0], units)
    same(robot, found.q[-1], expected.q[-1], units, 1e-5)


@units
def test_reach_is_the_same_in_all_units(units):
    robot = tree()
    wanted = robot.pose([0.3, 1.0, 0.5, 0, -1.0, 0, 0, 0.05], link="slide")
    expected = robot.reach("slide", wanted[:3, 3], prefer="start")
    found = converted(robot, units).reach("slide", scaled(wanted[:3, 3], L, units), prefer="start")
    assert found.status == expected.status == "reached"
    same(robot, found.q, expected.q, units)
    far = robot.reach("slide", (9.0, 0, 9.0), restarts=1)
    found = converted(robot, units).reach("slide", scaled((9.0, 0, 9.0), L, units), restarts=1)
    assert found.status == far.status


@units
def test_modes_are_the_same_in_all_units(units):
    robot = tree()
    q = lissom.statics(robot).q
    expected = lissom.modes(robot, q)
    found = lissom.modes(converted(robot, units), shape(robot, q, units))
    assert found.stability == expected.stability == "stable"
    np.testing.assert_allclose(found.angular_frequency * units[2], expected.angular_frequency, rtol=1e-6)


#: With inextensible cords that are slack at the start, the search for equilibria still fails in all units.
@units
@pytest.mark.parametrize("name", ["tree", "linkage", "arch", "cables", "floor"])
def test_equilibria_are_the_same_in_all_units(name, units):
    make, q0 = ROBOTS[name]
    robot = make()
    expected = lissom.statics(robot, q0)
    found = lissom.statics(converted(robot, units), start(robot, q0, units))
    assert found.status == expected.status
    assert found.success
    assert found.stability == expected.stability
    same(robot, found.q, expected.q, units)


@pytest.mark.filterwarnings("ignore:The finite number of modes:lissom.AccuracyWarning")
@units
def test_paths_are_the_same_in_all_units(units):
    robot = tree()
    expected = lissom.continuation(robot, bounds=(0, 2))
    found = lissom.continuation(converted(robot, units), bounds=(0, 2))
    assert found.status == expected.status == "finished"
    assert len(found.path.load_factor) == len(expected.path.load_factor)
    same(robot, found.path.q[-1], expected.path.q[-1], units)


@units
def test_inputs_for_a_pose_are_the_same_in_all_units(units):
    robot = hung(2e3)
    expected = lissom.actuate(robot, {"plate": (0.01, 0, 0.17)}, q0=ABOVE)
    found = lissom.actuate(
        converted(robot, units), {"plate": scaled((0.01, 0, 0.17), L, units)}, q0=shape(robot, ABOVE, units)
    )
    assert found.status == expected.status
    assert found.success
    np.testing.assert_allclose(found.u, scaled(expected.u, L, units), rtol=1e-5)


@units
def test_chosen_modes_are_the_same_in_all_units(units):
    robot = lissom.Robot([lissom.Link("rod", rod=[rod(0.3, {"bend_y": 2, "stretch": 1})])])
    expected = lissom.choose_modes(robot, 0.1, rtol=1e-2)
    found = lissom.choose_modes(converted(robot, units), 0.1 * units[2], rtol=1e-2, dt=0.01 * units[2])
    assert [s.modes for link in found.links for s in link.rod] == [
        s.modes for link in expected.links for s in link.rod
    ]


def beside(robot, length):
    """The robot with a rod that has nothing to do with it, so light that it does not bend."""
    other = lissom.Segment(length, 5e-3 * length, 1e6, 4e5, 1e-9, modes={"bend_y": 2})
    links = [*robot.links, lissom.Link("other", position=(0, 3, 0), rod=[other])]
    return lissom.Robot(
        links, loops=robot.loops, actuators=robot.actuators, contacts=robot.contacts, gravity=robot.gravity
    )


unrelated = pytest.mark.parametrize("length", [1e-3, 1.0, 1e3])


@starts
@unrelated
@pytest.mark.parametrize("name", ["linkage", "arch"])
def test_starts_do_not_depend_on_unrelated_parts(name, length):
    robot = ROBOTS[name][0]()
    expected = lissom.simulate(robot, 1e-6, dt=1e-6)
    found = lissom.simulate(beside(robot, length), 1e-6, dt=1e-6)
    assert found.status == expected.status == "finished"
    same(robot, found.q[0][: robot.n], expected.q[0], (1, 1, 1), 1e-9)


@unrelated
def test_reach_does_not_depend_on_unrelated_parts(length):
    robot = tree()
    wanted = robot.pose([0.3, 1.0, 0.5, 0, -1.0, 0, 0, 0.05], link="slide")[:3, 3]
    expected = robot.reach("slide", wanted, prefer="start")
    found = beside(robot, length).reach("slide", wanted, prefer="start")
    assert found.status == expected.status == "reached"
    same(robot, found.q[: robot.n], expected.q, (1, 1, 1))
    np.testing.assert_allclose(found.q[robot.n :], 0, atol=1e-9)
    assert np.max(found.position_error) < 1e-9


@unrelated
@pytest.mark.parametrize("name", ["tree", "linkage", "arch"])
def test_equilibria_do_not_depend_on_unrelated_parts(name, length):
    robot = ROBOTS[name][0]()
    expected, found = lissom.statics(robot), lissom.statics(beside(robot, length))
    assert (found.status, found.success, found.stability) == (expected.status, True, expected.stability)
    same(robot, found.q[: robot.n], expected.q, (1, 1, 1))


@pytest.mark.parametrize("length", [1e-3, 1.0, 300.0, 1e3, 1e4])
def test_verdicts_do_not_depend_on_unrelated_parts(length):
    """Beside a heavy rod up to 1e17 times as stiff, nothing of which is a stiffness of the linkage."""
    robot = ROBOTS["linkage"][0]()
    rod = lissom.Segment(length, 0.05 * length, 1e8, 4e7, 1000.0, modes={"bend_y": 2})
    both = lissom.Robot(
        [*robot.links, lissom.Link("other", position=(0, 3, 0), rod=[rod])],
        loops=robot.loops,
        gravity=robot.gravity,
    )
    # The rod is far too heavy for two modes.
    expected, found = lissom.statics(robot), lissom.statics(both, space_error=False)
    assert found.stability == expected.stability == "stable"
    np.testing.assert_allclose(found.lowest_eigenvalue, expected.lowest_eigenvalue, rtol=1e-6)
    modes = lissom.modes(both, found.q)
    assert modes.stability == "stable"
    for frequency in lissom.modes(robot, expected.q).frequency:
        assert np.min(np.abs(modes.frequency / frequency - 1)) < 1e-5


@pytest.mark.parametrize("offset", [1e-3, 1.0, 1e3])
def test_reach_does_not_depend_on_where_the_robot_stands(offset):
    robot = tree()
    first = dataclasses.replace(robot.links[0], position=(0, offset, 0))
    moved = lissom.Robot([first, robot.links[1]])
    wanted = robot.pose([0.3, 1.0, 0.5, 0, -1.0, 0, 0, 0.05], link="slide")[:3, 3]
    expected = robot.reach("slide", wanted, prefer="start")
    found = moved.reach("slide", wanted + np.array([0, offset, 0]), prefer="start")
    assert found.status == expected.status == "reached"
    same(robot, found.q, expected.q, (1, 1, 1))


@pytest.mark.parametrize("centre", [0, 1e-9, 1e-6, 1e-3, 0.1])
def test_reach_of_a_body_does_not_depend_on_its_centre(centre):
    body = lissom.Body(1.0, centre=(centre, 0, 0), inertia=(1e-3, 1e-3, 1e-3))
    robot = lissom.Robot([lissom.Link("body", joint=lissom.Free(), body=body)])
    wanted = robot.pose([1.0, -2.0, 3.0, 0.4, -1.0, 0.6])
    found = robot.reach("body", wanted)
    assert found.status == "reached"
    np.testing.assert_allclose(robot.pose(found.q), wanted, atol=1e-8)


def section(bending, stretching, mass, radius):
    """A section with these stiffnesses in newton square metres and newtons."""
    inertia = tuple(np.array([2, 1, 1]) * radius**2 * mass)
    return lissom.Section.given(np.diag([bending] * 3 + [stretching] * 3), mass=mass, inertia=inertia)


@starts
@pytest.mark.parametrize("mass", [1.0, 1e8])
@pytest.mark.parametrize("length", [1.0, 100.0, 1e4])
def test_straight_lines_are_closed_by_bending_whatever_they_weigh(mass, length):
    """Without gravity, the closed shape depends on the ratio of stiffnesses alone."""

    def closed(mass, length):
        given = section(1.0, 1e6 / length**2, mass, 0.01 * length)
        end = (None, None, (0.98 * length * np.cos(0.2286), 0, 0.98 * length * np.sin(0.2286)))
        line = lissom.Link(
            "line", joint=HINGE, rod=[lissom.Segment(0.2 * length, section=given, modes={"bend_y": 4})] * 5
        )
        robot = lissom.Robot([line], gravity=(0, 0, 0), loops=[lissom.Loop("line", end, HINGE)])
        started = lissom.simulate(robot, 1e-9, dt=1e-9)
        return started.q[0] * np.where(["bend" in name for name in robot.coordinates], length, 1)

    np.testing.assert_allclose(closed(mass, length), closed(1.0, 1.0), atol=1e-6)


@starts
@pytest.mark.parametrize("ratio", [1e3, 1e6, 1e9, 1e12])
def test_straight_ropes_are_closed_without_squeezing_them(ratio):
    given = section(1e4 / ratio * 100, 1e4, 0.1, 0.01)
    modes = {"bend_y": 2, "stretch": 1}
    line = lissom.Link("line", joint=HINGE, rod=[lissom.Segment(1.0, section=given, modes=modes)] * 10)
    robot = lissom.Robot([line], loops=[lissom.Loop("line", (None, None, (8.0, 0, 0)), HINGE)])
    q = lissom.simulate(robot, 1e-9, dt=1e-9).q[0]
    assert np.abs(robot.loop_gaps(q)).max() < 1e-9
    stretch = q[["stretch" in name for name in robot.coordinates]]
    # Squeezing it would take 0.2; Euler's load stretches by pi^2 over the ratio.
    assert np.abs(stretch).max() < 100 / ratio
    # Of both sides it hangs.
    assert robot.pose(q, 5.0)[2, 3] < -1
