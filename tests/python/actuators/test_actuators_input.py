"""Invalid actuators are rejected with their place, before any computation."""

import copy
import gc
import pickle
import weakref

import numpy as np
import pytest

import lissom
from lissom import ActiveStrain, Along, Chamber, Input, Link, Motor, Tendon, Via

SOFT = lissom.Segment(0.2, 2e-3, 1e9, 4e8, 1200, {"bend_y": 2, "bend_z": 2})
EMBEDDED = Along("finger", (0, 0.01))


def links():
    """A link with every kind of joint, and a rod on the first one."""
    ball = lissom.Body(1, inertia=(1, 1, 1))

    def link(name, joint):
        return Link(name, parent="base", body=ball, joint=joint)

    return [
        Link("base", body=lissom.Body(1, centre=(0.1, 0, 0)), joint=lissom.Revolute((0, 1, 0))),
        Link("finger", parent="base", rod=[SOFT]),
        link("driven", lissom.Revolute((0, 1, 0), motion=0.2)),
        link("geared", lissom.Revolute((0, 1, 0), mimic=lissom.Mimic("base", multiplier=-2))),
        link("ball", lissom.Spherical()),
        link("bird", lissom.Free()),
        link("tube", lissom.Cylindrical((1, 0, 0))),
    ]


def robot(*actuators, **more):
    return lissom.Robot(links(), actuators=actuators, **more)


def tendon(path=(EMBEDDED,), name="pull", **command):
    return Tendon(name, path, **(command or {"tension": 1.0}))


def refusal(build):
    """The kind of an error, its place, and the complete message."""
    with pytest.raises((ValueError, TypeError)) as caught:
        build()
    said = str(caught.value)
    return caught.type, said.split(": ")[0], said


#: Actuators rejected on construction: kind, place and words of the message.
ALONE = {
    "an arc length that does not increase": (
        lambda: Along("finger", (0, 0.01), (0.1, 0.05)),
        (ValueError, "along[1]", "got 0.05, expected an arc length > along[0] = 0.1"),
    ),
    "a part of no length": (lambda: Along(along=(0.1, 0.1)), (ValueError, "along[1]", "> along[0]")),
    "an arc length before the base": (
        lambda: Along(along=(-0.1, 0.1)),
        (ValueError, "along[0]", "got -0.1, expected an arc length >= 0 (metres)"),
    ),
    "an arc length that is none": (lambda: Along(along=(np.nan, 0.1)), (ValueError, "along[0]", "got NaN")),
    "three ends": (lambda: Along(along=(0, 0.1, 0.2)), (ValueError, "along", "expected 2 values, got 3")),
    "one offset": (lambda: Along(offset=0.01), (TypeError, "offset", "the pair (y, z)")),
    "three offsets": (lambda: Along(offset=(0, 0, 1)), (ValueError, "offset", "got 3 of them")),
    "an offset of NaN": (
        lambda: Along(offset=(0, np.nan)),
        (ValueError, "offset[1]", "got NaN, expected a finite number (metres)"),
    ),
    "an offset that ends in NaN": (
        lambda: Along(offset=(0, (0.01, np.nan))),
        (ValueError, "offset[1][1]", "got NaN"),
    ),
    "stations that do not increase": (
        lambda: Along("finger", (([0, 0.1, 0.05], [1, 2, 3]), 0)),
        (ValueError, "offset[0].stations[2]", "expected more than stations[1] = 0.1"),
    ),
    "a text as offset": (lambda: Along(offset=("a", 0)), (TypeError, "offset[0]", "got str")),
    "a number as link": (lambda: Along(3), (TypeError, "link", "expected a str, got int")),
    "a point in the plane": (
        lambda: Via("base", (0, 0)),
        (ValueError, "point", "expected 3 values, got 2"),
    ),
    "a point at NaN": (lambda: Via("base", (0, 0, np.nan)), (ValueError, "point[2]", "got NaN")),
    "a text as place": (
        lambda: Via("base", (0, 0, 0), at="tip"),
        (TypeError, "at", "expected a real number, got str"),
    ),
    "an empty path": (lambda: tendon([]), (ValueError, "path", "got no parts, expected a part along")),
    "a path of one point": (
        lambda: tendon([Via("base", (0, 0, 0))]),
        (ValueError, "path", "got one point, expected a part along a rod, or two points"),
    ),
    "a part without a list": (
        lambda: tendon(EMBEDDED),
        (TypeError, "path", "expected a sequence of lissom.Along or Via, got Along"),
    ),
    "a number in a path": (
        lambda: tendon([3]),
        (TypeError, "path[0]", "expected lissom.Along or Via, got int"),
    ),
    "neither tension nor length": (
        lambda: tendon(friction=0.1),
        (ValueError, "tension", "got neither tension nor length, expected one of them"),
    ),
    "both tension and length": (
        lambda: tendon(tension=1, length=1, stiffness=1),
        (ValueError, "length", "got both tension and length, expected one of them"),
    ),
    "a damping without stiffness": (
        lambda: tendon(length=0.2, damping=1.0),
        (ValueError, "damping", "a tendon without `stiffness` does not stretch"),
    ),
    "friction without stiffness": (
        lambda: tendon(length=0.2, friction=0.1),
        (ValueError, "friction", "not supported"),
    ),
    "a negative stiffness": (lambda: tendon(length=0.2, stiffness=-1), (ValueError, "stiffness", "got -1")),
    "a stiffness of zero": (lambda: tendon(length=0.2, stiffness=0), (ValueError, "stiffness", "> 0")),
    "a text as stiffness": (
        lambda: tendon(length=0.2, stiffness="a"),
        (TypeError, "stiffness", "expected a real number, got str"),
    ),
    "a stiffness of a tension": (
        lambda: tendon(tension=1, stiffness=1),
        (ValueError, "stiffness", "it belongs to a tendon of a given length"),
    ),
    "a damping of a tension": (
        lambda: tendon(tension=1, damping=1),
        (ValueError, "damping", "it belongs to a tendon of a given length"),
    ),
    "a negative damping": (
        lambda: tendon(length=0.2, stiffness=1, damping=-1),
        (ValueError, "damping", "got -1, expected a finite number >= 0"),
    ),
    "a tension that pushes": (
        lambda: tendon(tension=-1),
        (ValueError, "tension", "got -1, expected a tension >= 0 (newtons): a tendon pulls"),
    ),
    "an infinite tension": (lambda: tendon(tension=np.inf), (ValueError, "tension", "got inf")),
    "a tension of three": (lambda: tendon(tension=(1, 2, 3)), (TypeError, "tension", "got tuple")),
    "a wave of three": (
        lambda: tendon(tension=lissom.Harmonic((1, 2, 3), 1.0)),
        (ValueError, "tension", "a Harmonic of one number"),
    ),
    "an input of three": (
        lambda: tendon(tension=Input("pull", (1, 2, 3))),
        (ValueError, "tension", "an Input of one number, got one of three numbers"),
    ),
    "times that do not increase": (
        lambda: tendon(tension=([0, 1, 0.5], [1, 2, 3])),
        (ValueError, "tension.times[2]", "expected a time > times[1] = 1"),
    ),
    "negative friction": (
        lambda: tendon(tension=1, friction=-0.1),
        (ValueError, "friction", "got -0.1, expected a finite number >= 0"),
    ),
    "friction that is not smoothed": (
        lambda: tendon(tension=1, friction_velocity=0),
        (ValueError, "friction_velocity", "got 0"),
    ),
    "sliding faster than sliding": (
        lambda: tendon(tension=1, sliding=2),
        (ValueError, "sliding", "got 2, expected a direction in [-1, 1]"),
    ),
    "a tendon without a name": (lambda: tendon(name=""), (ValueError, "name", "expected a name")),
    "a tendon called three": (lambda: tendon(name=3), (TypeError, "name", "expected a str, got int")),
    "a negative area": (
        lambda: Chamber("c", [EMBEDDED], -1),
        (ValueError, "area", "got -1, expected a finite number > 0 (square metres)"),
    ),
    "no area": (
        lambda: Chamber("c", [EMBEDDED], None),
        (TypeError, "area", "expected a real number, got NoneType"),
    ),
    "a chamber through a point": (
        lambda: Chamber("c", [EMBEDDED, Via(None, (0, 0, 0))], 1),
        (TypeError, "path[1]", "expected lissom.Along, got Via"),
    ),
    "a chamber nowhere": (lambda: Chamber("c", [], 1), (ValueError, "path", "got no parts")),
    "a pressure of NaN": (lambda: Chamber("c", [EMBEDDED], 1, np.nan), (ValueError, "pressure", "got NaN")),
    "neither torque nor position": (
        lambda: Motor("base"),
        (ValueError, "torque", "got neither torque nor position, expected one of them"),
    ),
    "both torque and position": (
        lambda: Motor("base", 1, position=1, gains=(1, 1)),
        (ValueError, "position", "got both torque and position"),
    ),
    "gains of a torque": (
        lambda: Motor("base", 1, gains=(1, 1)),
        (ValueError, "gains", "got (1, 1), expected none: it belongs to a motor of a given position"),
    ),
    "a position without gains": (
        lambda: Motor("base", position=1),
        (ValueError, "gains", "got none, expected the pair (stiffness, damping)"),
    ),
    "negative gains": (
        lambda: Motor("base", position=1, gains=(-1, 0)),
        (ValueError, "gains[0]", "got -1, expected a finite number >= 0"),
    ),
    "three gains": (
        lambda: Motor("base", position=1, gains=(1, 0, 1)),
        (ValueError, "gains", "expected 2 values, got 3"),
    ),
    "limits in the wrong order": (
        lambda: Motor("base", 1, limits=(1, -1)),
        (ValueError, "limits", "got (1, -1), expected the lowest and the highest torque or force"),
    ),
    "one limit": (lambda: Motor("base", 1, limits=3), (TypeError, "limits", "got int")),
    "a torque of NaN": (lambda: Motor("base", np.nan), (ValueError, "torque", "got NaN")),
    "a motor of joint three": (lambda: Motor(3, 1.0), (TypeError, "joint", "expected a str, got int")),
    "a strain that nobody knows": (
        lambda: ActiveStrain("finger", "bendy"),
        (ValueError, "strain", "did you mean 'bend_y'?"),
    ),
    "a shape of NaN": (
        lambda: ActiveStrain("finger", "bend_y", np.nan),
        (ValueError, "shape", "got NaN, expected a finite number (radians or metres per metre)"),
    ),
    "a shape of three": (lambda: ActiveStrain("finger", "bend_y", (1, 2, 3)), (ValueError, "shape", "[3]")),
    "a tension that is below zero by default": (
        lambda: tendon(tension=Input("pull", -2.0)),
        (ValueError, "tension.default", "got -2, expected a tension >= 0"),
    ),
    "a table of tensions below zero": (
        lambda: tendon(tension=([0, 1, 2], [1.0, -3.0, -1.0])),
        (ValueError, "tension.values[1]", "got -3, expected a tension >= 0"),
    ),
    "a tension that oscillates below zero": (
        lambda: tendon(tension=lissom.Harmonic(-2.0, 1.0, mean=1.5)),
        (ValueError, "tension", "got -0.5, expected a tension >= 0"),
    ),
    "a length below zero": (
        lambda: tendon(length=-0.1, stiffness=1.0),
        (ValueError, "length", "got -0.1, expected a free length >= 0"),
    ),
    "a length that is below zero by default": (
        lambda: tendon(length=Input("l", -0.1), stiffness=1.0),
        (ValueError, "length.default", "got -0.1, expected a free length >= 0"),
    ),
    "an infinite amount": (
        lambda: ActiveStrain("finger", "bend_y", 1, np.inf),
        (ValueError, "amount", "got inf"),
    ),
    "an input without a name": (lambda: Input(""), (ValueError, "name", "expected a name")),
    "an input of NaN": (lambda: Input("pull", np.nan), (ValueError, "default[0]", "got NaN")),
    "an input of two": (lambda: Input("pull", (1, 2)), (ValueError, "default", "one number, or three")),
}


@pytest.mark.parametrize("case", ALONE)
def test_what_makes_no_sense_by_itself_is_refused_where_it_is_written(case):
    build, (kind, place, words) = ALONE[case]
    found, where, said = refusal(build)
    assert (found, where) == (kind, place), said
    assert words in said


#: Actuators rejected by a robot: place and words of the message.
ON_A_ROBOT = {
    "a link that nobody knows": (
        [tendon([Along("fingre")])],
        ("actuators[0].path[0].link", "did you mean 'finger'?"),
    ),
    "a point of a link that nobody knows": (
        [tendon([Via("bsae", (0, 0, 0)), EMBEDDED])],
        ("actuators[0].path[0].link", "did you mean 'base'?"),
    ),
    "no link among several": (
        [tendon([Along()])],
        ("actuators[0].path[0].link", "got none, expected one of the links: 'base', 'finger'"),
    ),
    "a tendon along a rigid body": (
        [tendon([EMBEDDED, Along("base")])],
        (
            "actuators[0].path[1].link",
            "which has no rod, expected a link with a rod; through a rigid body leads",
        ),
    ),
    "a chamber along a rigid body": (
        [Chamber("c", [Along("base")], 1)],
        ("actuators[0].path[0].link", "which has no rod"),
    ),
    "an arc length beyond the tip": (
        [tendon([Along("finger", along=(0, 0.3))])],
        ("actuators[0].path[0].along[1]", "got 0.3, expected an arc length in [0, 0.2] (metres)"),
    ),
    "a point beyond the tip": (
        [tendon([EMBEDDED, Via("finger", (0, 0, 0), at=0.5)])],
        ("actuators[0].path[1].at", "got 0.5, expected an arc length in [0, 0.2] (metres)"),
    ),
    "an arc length of a body": (
        [tendon([Via("base", (0, 0, 0), at=0.1), EMBEDDED])],
        ("actuators[0].path[0].at", "expected none: the point is on a body"),
    ),
    "an arc length of the world": (
        [tendon([Via(None, (0, 0, 0), at=0.1), EMBEDDED])],
        ("actuators[0].path[0].at", "expected none: a point of the world lies on no rod"),
    ),
    "two points of the world": (
        [tendon([Via(None, (0, 0, 0)), Via(None, (0, 0, 1))])],
        ("actuators[0].path", "got only points in the world, expected parts along a rod, or points of which"),
    ),
    "two points of a body": (
        [tendon([Via("base", (0, 0, 0)), Via("base", (0, 0, 1))])],
        ("actuators[0].path", "got only points on one body or section"),
    ),
    "a way of no length": (
        [tendon([Via("finger", (0, 0, 0.01), 0.1), Via("finger", (0, 0, 0.01), 0.1)])],
        ("actuators[0].path", "got only points on one body or section"),
    ),
    "stations of another rod": (
        [tendon([Along("finger", (0, ([0, 0.1], [1, 2])))])],
        ("actuators[0].path[0].offset[1].stations[1]", "got 0.1, expected 0.2"),
    ),
    "a profile of another rod": (
        [tendon([Along("finger", (lissom.Profile(0.3, coefficients=[0.01]), 0))])],
        ("actuators[0].path[0].offset[0]", "got a profile over 0.3 m"),
    ),
    "an offset that is NaN somewhere": (
        [tendon([Along("finger", (lambda X: np.nan, 0))])],
        ("actuators[0].path[0].offset[0]", "got NaN at X = 0"),
    ),
    "two of one name": (
        [tendon(), Motor("base", 1), Motor("tube.angle", 1, name="pull")],
        ("actuators[2].name", 'got "pull", the name of another actuator'),
    ),
    "a joint that nobody knows": (
        [Motor("bsae", 1)],
        (
            "actuators[0].joint",
            "got 'bsae', expected a link with a joint of one coordinate, or one of base.angle",
        ),
    ),
    "a link whose name is written wrong": ([Motor("bse", 1)], ("actuators[0].joint", "did you mean 'base'?")),
    "a joint of two coordinates": (
        [Motor("tube", 1)],
        ("actuators[0].joint", "did you mean 'tube.angle'?"),
    ),
    "a mode of a rod": ([Motor("finger.bend_y[0]", 1)], ("actuators[0].joint", "or one of base.angle")),
    "a joint that is prescribed": (
        [Motor("driven", 1)],
        (
            "actuators[0].joint",
            'got "driven", whose motion is prescribed, expected a joint that moves freely',
        ),
    ),
    "a coordinate that is prescribed": (
        [Motor("driven.angle", 1)],
        ("actuators[0].joint", "a motor with position and gains follows a position"),
    ),
    "a ball": (
        [Motor("ball", 1)],
        ("actuators[0].joint", 'got "ball", a spherical joint, expected a revolute, prismatic'),
    ),
    "a rotation vector": (
        [Motor("ball.rotation_x", 1)],
        ("actuators[0].joint", 'a Load with frame "body" turns and pushes other links'),
    ),
    "what flies": ([Motor("bird.x", 1)], ("actuators[0].joint", 'got "bird", a free joint')),
    "what is welded": ([Motor("finger", 1)], ("actuators[0].joint", 'got "finger", a weld joint')),
    "a strain without modes": (
        [ActiveStrain("finger", "stretch")],
        ("actuators[0].strain", 'got stretch, of which "finger" has no modes'),
    ),
    "a strain of a body": (
        [ActiveStrain("base", "bend_y")],
        ("actuators[0].link", 'got "base", which has no rod'),
    ),
    "inputs of two defaults": (
        [tendon(tension=Input("u", 1)), Motor("base", Input("u", 2))],
        ("actuators[1].torque", 'got the input "u" with the default 2, expected the default 1 as before'),
    ),
    "an object of another kind": (
        [lissom.Load(force=(0, 0, 1))],
        ("actuators[0]", "expected lissom.Tendon, Chamber, Motor or ActiveStrain, got Load"),
    ),
}


@pytest.mark.parametrize("case", ON_A_ROBOT)
def test_what_does_not_fit_a_robot_is_refused_with_its_place(case):
    actuators, (place, words) = ON_A_ROBOT[case]
    _, where, said = refusal(lambda: robot(*actuators))
    assert where == place, said
    assert words in said


def test_a_load_and_an_actuator_cannot_share_an_input_of_two_sizes():
    push = lissom.Load(force=Input("u", (0, 0, 0)), link="base")
    _, where, said = refusal(lambda: robot(Motor("base", Input("u")), loads=[push]))
    assert where == "actuators[0].torque"
    assert "with the default 0, expected the default (0, 0, 0) as before" in said


def test_of_coordinates_that_are_as_near_the_first_is_meant():
    arm = Link("arm", body=lissom.Body(1, inertia=(1, 1, 1)), joint=lissom.Universal((0, 1, 0), (0, 0, 1)))
    _, _, said = refusal(lambda: lissom.Robot([arm], actuators=[Motor("arm", 1)]))
    assert said.endswith("did you mean 'arm.angle[0]'?")


@pytest.mark.parametrize("vector_first", [True, False])
def test_an_entry_of_a_vector_is_no_name_for_another_input(vector_first):
    vector = lissom.Load(
        force=Input("u" if vector_first else "u.x", (0, 0, 0) if vector_first else (1, 2, 3))
    )
    number = tendon([Along()], tension=Input("u.x" if vector_first else "u.x.y"))
    _, where, said = refusal(lambda: lissom.Rod([SOFT], loads=[vector], actuators=[number]))
    name = "u" if vector_first else "u.x"
    assert where == "actuators[0].tension"
    assert f'expected another name: that is an entry of the input "{name}" at loads[0].force, too' in said
    # The names themselves may be the same.
    other = tendon([Along()], tension=Input("u.w"))
    assert len(lissom.Rod([SOFT], loads=[vector], actuators=[other]).inputs) == 4


def test_of_two_loads_the_second_is_refused_too():
    loads = [lissom.Load(force=Input("u", (0, 0, 0))), lissom.Load(moment=Input("u.x", (0, 0, 0)))]
    assert len(lissom.Rod([SOFT], loads=loads).inputs) == 6
    scalar = tendon([Along()], tension=Input("v.z"))
    more = Chamber("c", [Along()], 1e-4, Input("v"))
    assert lissom.Rod([SOFT], actuators=[scalar, more]).inputs == ("v.z", "v")


def test_one_actuator_is_no_sequence():
    _, where, said = refusal(lambda: lissom.Robot(links(), actuators=tendon()))
    assert where == "actuators"
    assert "got Tendon" in said


def test_what_a_function_raises_comes_out_as_it_is():
    def offset(X):
        raise ValueError("my own: no idea")

    with pytest.raises(ValueError, match="my own") as caught:
        robot(tendon([Along("finger", (offset, 0))]))
    assert str(caught.value) == "my own: no idea"
    assert caught.traceback[-1].name == "offset"
    with pytest.raises(ZeroDivisionError, match=r"^division by zero") as caught:
        robot(Motor("base", 1), tendon([EMBEDDED, Along("finger", (lambda X: 1 / 0, 0))]))
    assert str(caught.value) == "division by zero"
    # With a note that names the owner.
    assert caught.value.__notes__ == ["in actuators[1].path[1].offset[0]"]


def test_a_motor_moves_what_mimics():
    geared = robot(Motor("geared", 1.0))
    q = np.zeros(geared.n)
    expected = np.zeros(geared.n)
    expected[geared.coordinates.index("base.angle")] = -2
    np.testing.assert_array_equal(geared.actuator_gradient("geared", q), expected)


def test_a_path_far_outside_its_section_is_none_of_our_business():
    # Real tendons run through holes in disks.
    pulled = robot(tendon([Along("finger", (0, 0.5))]))
    np.testing.assert_allclose(pulled.actuator_length("pull", np.zeros(pulled.n)), 0.2, rtol=1e-12)


def test_on_a_rod_nobody_has_to_name_it():
    path = [Along(None, (0, 0.01), (0, 0.1)), Via(None, (0, 0, 0.02), at=0.2)]
    rod = lissom.Rod([SOFT], actuators=[tendon(path)])
    (found,) = rod.actuators
    assert [part.link for part in found.path] == ["rod", "rod"]
    assert lissom.Rod([SOFT], actuators=rod.actuators).actuators == rod.actuators


@pytest.mark.parametrize("u", [[1.0, 2.0], [], [[1.0]]])
def test_inputs_of_the_wrong_shape_are_refused(u):
    pulled = robot(tendon(tension=Input("u", 1)))
    zeros = np.zeros(pulled.n)
    kind, where, said = refusal(lambda: pulled.inverse_dynamics(zeros, zeros, zeros, u=u))
    assert where == "u", said
    assert kind in (ValueError, TypeError)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_inputs_that_are_no_numbers_are_refused(value):
    pulled = robot(tendon(tension=Input("u", 1)), Motor("base", Input("turn")))
    zeros = np.zeros(pulled.n)
    _, where, said = refusal(lambda: pulled.inverse_dynamics(zeros, zeros, zeros, u=[1.0, value]))
    assert where.startswith("u"), said


@pytest.mark.parametrize("ask", ["actuator_length", "actuator_gradient"])
def test_an_actuator_that_nobody_knows_is_said(ask):
    pulled = robot(tendon())
    _, where, said = refusal(lambda: getattr(pulled, ask)("pul", np.zeros(pulled.n)))
    assert (where, "did you mean 'pull'?" in said) == ("name", True)
    _, _, said = refusal(lambda: getattr(robot(), ask)("pull", np.zeros(pulled.n)))
    assert "expected an actuator, but the robot has none" in said


#: Actuators of every kind, with all options.
ACTUATORS = [
    Tendon(
        "pull",
        [
            Via(None, (0, 0, 0.1)),
            Via("base", (0, 0, 0.01)),
            Along("finger", (0.0, (0.01, 0.005)), (0.0, 0.15)),
        ],
        length=Input("let out", 0.3),
        stiffness=1e3,
        damping=2.0,
        friction=0.1,
        friction_velocity=2e-3,
        sliding=1.0,
    ),
    Tendon("other", [EMBEDDED], tension=lissom.Harmonic(1.0, 2.0, mean=3.0)),
    Chamber("blow", [Along("finger", (0.0, -0.01))], 1e-5, Input("pressure")),
    Motor("tube.angle", position=0.1, gains=(3.0, 0.1), limits=(-1.0, 1.0), name="servo"),
    Motor("base", Input("torque")),
    ActiveStrain("finger", "bend_y", (1.0, 2.0), 0.1),
    Tendon(
        "in time", [Along("finger", (0, ([0.0, 0.2], [0, 0.01])))], tension=([0.0, 1.0], np.array([1.0, 2.0]))
    ),
]


def test_actuators_come_back_as_they_were_given():
    # A profile on part of a rod becomes a table or a profile of the whole part.
    first = robot(*ACTUATORS).actuators
    assert [type(each) for each in first] == [type(each) for each in ACTUATORS]
    assert [each.name for each in first] == [
        "pull",
        "other",
        "blow",
        "servo",
        "base",
        "finger.bend_y",
        "in time",
    ]
    assert robot(*first).actuators == first
    # Defaults, and parts that are the whole rod, do not store its length, which may change.
    assert first[1].path == (Along("finger", (0.0, 0.01)),)
    assert first[1].tension == ACTUATORS[1].tension
    assert first[2].pressure == ACTUATORS[2].pressure
    assert first[6].tension == ((0.0, 1.0), (1.0, 2.0))
    assert first[6].path[0].offset == (0.0, (0.0, 0.01))
    assert first[5].shape == (1.0, 2.0)
    assert first[3:5] == (ACTUATORS[3], Motor("base.angle", Input("torque"), name="base"))


@pytest.mark.parametrize("each", ACTUATORS, ids=lambda each: each.name)
def test_actuators_are_values(each):
    for twin in (copy.copy(each), copy.deepcopy(each), pickle.loads(pickle.dumps(each))):
        assert twin == each
        assert hash(twin) == hash(each)
        assert repr(twin) == repr(each)
    assert f"name={each.name!r}" in repr(each)
    with pytest.raises(AttributeError):
        each.name = "other"


def test_robots_with_actuators_are_copied_and_pickled():
    whole = robot(*ACTUATORS)
    q, v = np.linspace(0.1, 0.2, whole.n), np.linspace(0.3, -0.1, whole.n)
    expected = whole.inverse_dynamics(q, v, 0 * q, t=0.3)
    for twin in (copy.copy(whole), copy.deepcopy(whole), pickle.loads(pickle.dumps(whole))):
        assert twin.actuators == whole.actuators
        assert twin.inputs == whole.inputs
        np.testing.assert_array_equal(twin.inverse_dynamics(q, v, 0 * q, t=0.3), expected)


@pytest.mark.parametrize("where", ["tension", "sliding", "offset"])
def test_functions_of_actuators_are_collected_with_their_robots(where):
    class Pull:
        robot = None

        def __call__(self, t):
            return 1.0

    pull = Pull()
    path = [Along("finger", (0, pull))] if where == "offset" else [EMBEDDED]
    command = {"tension": 1.0} if where == "offset" else {"tension": 1.0, where: pull}
    pull.robot = robot(Tendon("pull", path, **command))
    # Names of the function are restored on the way back.
    assert pull.robot.actuators[0].name == "pull"
    alive = weakref.ref(pull)
    del pull, path, command
    gc.collect()
    assert alive() is None


def test_tendons_between_links_that_are_welded_together_are_refused():
    """Their length is constant, whatever moves."""
    body = lissom.Body(0.1, centre=(0.1, 0, 0))
    links = [
        Link("arm", body=body, joint=lissom.Revolute((0, 1, 0))),
        Link("hand", body=body, parent="arm", position=(0.1, 0, 0)),
        Link("thumb", body=body, parent="hand", position=(0.1, 0, 0)),
        Link("finger", body=body, parent="hand", position=(0.1, 0, 0), joint=lissom.Revolute((0, 1, 0))),
        Link("post", body=body),
    ]

    def robot(*points):
        path = [Via(link, (0, 0, 0.01 * k)) for k, link in enumerate(points)]
        return lissom.Robot(links, actuators=[Tendon("t", path, tension=1.0)])

    for points in [("arm", "hand"), ("thumb", "hand", "arm"), ("post", None)]:
        with pytest.raises(ValueError, match=r"actuators\[0\].path: got only points on .*welded together"):
            robot(*points)
    with pytest.raises(ValueError, match="got only points on one body or section"):
        robot("hand", "hand")
    for points in [("arm", "finger"), ("arm", "hand", None), ("finger", "thumb")]:
        robot(*points)


def test_default_names_of_actuators_do_not_collide():
    links = [Link("a", body=lissom.Body(0.1, centre=(0.1, 0, 0)), joint=lissom.Revolute((0, 1, 0)))]
    motors = [Motor("a", 0.1), Motor("a.angle", 0.1), Motor("a", 0.2), Motor("a", 0.3, name="b")]
    robot = lissom.Robot(links, actuators=motors)
    assert [each.name for each in robot.actuators] == ["a", "a.angle", "a 2", "b"]
    again = lissom.Robot(links, actuators=robot.actuators)
    assert [each.name for each in again.actuators] == ["a", "a.angle", "a 2", "b"]
    with pytest.raises(ValueError, match='got "b", the name of another actuator'):
        lissom.Robot(links, actuators=[Motor("a", 0.1, name="b")] * 2)
    soft = lissom.Segment(0.1, 0.01, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 1})
    muscles = [ActiveStrain(None, "bend_y", (0.0, 1.0)), ActiveStrain(None, "bend_y", (1.0, 0.0))]
    rod = lissom.Rod([soft], actuators=muscles)
    assert [each.name for each in rod.actuators] == ["bend_y", "bend_y 2"]
