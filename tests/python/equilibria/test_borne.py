"""Forces that joints and loops bear alone: along no coordinate is anything left of them, but they count."""

import numpy as np
import pytest

import lissom

G = 9.81
SKEW = np.array([[0.6, 0.2, -0.3], [0.2, 0.95, 0.17], [-0.3, 0.17, 0.8]]) * 0.01
#: A turn about no axis of anything.
TURNED = np.array([0.5, -0.3, 0.7, 0.4]) / np.linalg.norm([0.5, -0.3, 0.7, 0.4])


def pinned_body(centre, anchor, attached, stiffness, unit=1.0):
    """A body on a hinge through which the line of a taut cord passes; lengths in metres over ``unit``."""
    m, inertia = 3.0, np.diag([0.1, 0.12, 0.15]) / unit**2
    length = abs(anchor - attached) - 0.5
    cord = lissom.Tendon(
        "cord",
        [lissom.Via(None, (0, 0, anchor / unit)), lissom.Via("body", (0, 0, attached / unit))],
        length=length / unit,
        stiffness=stiffness,
    )
    body = lissom.Body(m, centre=(0, 0, centre / unit), inertia=inertia)
    robot = lissom.Robot(
        [lissom.Link("body", joint=lissom.Revolute((0, 1, 0)), body=body)],
        actuators=[cord],
        gravity=(0, 0, -G / unit),
    )
    # E = T l + m g c cos(theta) with l^2 = a^2 + A^2 - 2 a A cos(theta).
    pull = 0.5 * stiffness
    squared = (pull * attached * anchor / abs(anchor - attached) - m * G * centre) / (0.12 + m * centre**2)
    return robot, squared


@pytest.mark.parametrize("unit", [1.0, 1e-3])
@pytest.mark.parametrize(
    ("centre", "anchor", "stiffness"),
    [
        (0.1, 2.0, 20.0),
        (-0.1, -2.0, 20.0),
        (0.0, 2.0, 20.0),
        (0.0, -2.0, 20.0),
        (-0.1, 2.0, 1e6),
        (-0.1, -2.0, 1e3),
    ],
)
def test_a_taut_cord_whose_pull_the_joint_bears_has_its_stiffness(centre, anchor, stiffness, unit):
    """By a closed form: an inverted pendulum that a cord holds, and a hanging one that a cord upsets."""
    robot, squared = pinned_body(centre, anchor, 0.5, stiffness, unit)
    found = lissom.statics(robot, [0.0], method="newton")
    assert found.status == "converged"
    assert found.stability == ("stable" if squared > 0.0 else "divergence")
    eigenvalue = lissom.modes(robot, [0.0]).eigenvalues[0]
    assert (eigenvalue**2).real == pytest.approx(-squared, rel=1e-9)


def test_a_bead_on_a_rail_under_a_taut_cord_swings():
    cord = lissom.Tendon(
        "cord", [lissom.Via(None, (0, 0, 1)), lissom.Via("bead", (0, 0, 0))], length=0.5, stiffness=20.0
    )
    bead = lissom.Link("bead", joint=lissom.Prismatic((1, 0, 0)), body=lissom.Body(1.0))
    robot = lissom.Robot([bead], actuators=[cord])
    assert lissom.statics(robot).stability == "stable"
    assert lissom.modes(robot, [0.0]).frequency == pytest.approx([np.sqrt(10.0) / (2.0 * np.pi)], rel=1e-9)


@pytest.mark.parametrize("mass", [1e-2, 1.0, 1e2])
@pytest.mark.parametrize("start", [(0.0, 0.0, 0.0), (0.3, 0.2, 0.1), (1.3, -0.8, 2.0)])
@pytest.mark.parametrize(
    "joint", [lissom.Spherical(), lissom.Revolute((0.3, -0.5, 0.8)), lissom.Universal((1, 0, 0), (0, 1, 0))]
)
def test_a_body_that_nothing_turns_is_in_equilibrium_beside_another_one(joint, mass, start):
    """It balances on its joint away from the origin, so that moments of its weight are rounding."""
    weight = lissom.Link(
        "weight", joint=lissom.Prismatic((0, 0, 1), stiffness=30.0), body=lissom.Body(1.0, centre=(0.3, 0, 0))
    )
    balanced = lissom.Link(
        "balanced",
        joint=joint,
        position=(0.33, 0.24, 0.0),
        orientation=tuple(TURNED),
        body=lissom.Body(mass, inertia=mass * SKEW),
    )
    robot = lissom.Robot([weight, balanced])
    found = lissom.statics(robot, [0.1, *start[: robot.n - 1]])
    assert (found.status, found.stability) == ("converged", "neutral")
    assert lissom.modes(robot, found.q).stability == "neutral"
    assert found.nit < 30
    assert found.q[0] == pytest.approx(-G / 30.0, rel=1e-9)


@pytest.mark.parametrize("joint", [lissom.Revolute((0.3, -0.5, 0.8)), lissom.Universal((1, 0, 0), (0, 1, 0))])
@pytest.mark.parametrize("orientation", [(1.0, 0.0, 0.0, 0.0), tuple(TURNED)])
@pytest.mark.parametrize("mass", [0.03, 5.0])
def test_a_body_balanced_on_a_loop_is_neutral(joint, orientation, mass):
    """The loop closes to rounding: the weight beside it by that much is no stiffness."""
    body = lissom.Body(mass, inertia=mass * SKEW)
    robot = lissom.Robot(
        [lissom.Link("body", joint=lissom.Free(), body=body, orientation=orientation)],
        loops=[lissom.Loop("body", (None, None, (0, 0, 0), orientation), joint)],
    )
    assert lissom.statics(robot).stability == "neutral"


def test_forces_of_loops_need_no_inertia():
    """A hanging line without rotary inertia, free to turn about its chord: each end bears half its weight."""
    section = lissom.Section.given((1e-3, 1e-3, 1e-3, 1e4, 1e4, 1e4), 0.1)
    segment = lissom.Segment(0.25, section=section, modes={"bend_y": 2, "bend_z": 2, "torsion": 1})
    line = lissom.Link("line", rod=[segment] * 4, joint=lissom.Spherical())
    robot = lissom.Robot([line], loops=[lissom.Loop("line", (None, None, (0.7, 0, 0)), lissom.Spherical())])
    found = lissom.statics(robot)
    assert found.status == "converged"
    at_rest = np.zeros(robot.n)
    *_, fz = np.reshape(robot.loop_forces(found.q, at_rest, at_rest), (-1, 6))[0]
    assert fz == pytest.approx(-0.5 * 0.1 * G, rel=1e-8)
