"""Screws: beside hinges with sliders that follow them, and spindles with known motions."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom
from lissom import Body, Free, Link, Loop, Mimic, Motor, Prismatic, Revolute, Robot, Screw, Spherical

BLOCK = Body(0.7, centre=(0.1, -0.2, 0.05), inertia=np.diag([0.02, 0.03, 0.04]))
AXIS = (0, 3, 4)
PLACE = {"parent": "base", "position": (0.1, 0.2, 0), "orientation": (0.8, 0, 0.6, 0)}
MASS, INERTIA, LEAD = 2.0, 3e-4, 0.02


@pytest.mark.parametrize("lead", [0.7, -0.02, 0.0, 40.0])
def test_a_screw_is_a_hinge_with_a_slider_that_follows_it(lead):
    base = Link("base", joint=Spherical(), body=BLOCK)
    tip = Link("tip", parent="nut", position=(0.1, 0, 0.3), joint=Revolute((1, 0, 0)), body=BLOCK)
    screw = Robot([base, Link("nut", joint=Screw(AXIS, lead), body=BLOCK, **PLACE), tip])
    slide = Prismatic(AXIS, mimic=Mimic("turn", multiplier=lead / (2 * np.pi)))
    turn = Link("turn", joint=Revolute(AXIS), **PLACE)
    row = Robot([base, turn, Link("nut", parent="turn", joint=slide, body=BLOCK), tip])
    q, v, a = np.random.default_rng(5).standard_normal((3, 5))
    size = max(1.0, abs(lead)) ** 2
    assert_allclose(
        screw.inverse_dynamics(q, v, a), row.inverse_dynamics(q, v, a), rtol=1e-11, atol=1e-12 * size
    )
    assert_allclose(screw.mass_matrix(q), row.mass_matrix(q), rtol=1e-11, atol=1e-12 * size)
    for link in ("nut", "tip"):
        assert_allclose(screw.pose(q, link=link), row.pose(q, link=link), atol=1e-13 * size)
        assert_allclose(screw.velocity(q, v, link=link), row.velocity(q, v, link=link), atol=1e-12 * size)
    runs = [
        lissom.simulate(robot, 0.3, q0=0.1 * q, v0=v, method="dop853", rtol=1e-10, atol=1e-12)
        for robot in (screw, row)
    ]
    assert_allclose(runs[0].q[-1], runs[1].q[-1], atol=1e-8)


def spindle(**joint):
    body = Body(MASS, inertia=np.diag([1.0, 1.0, INERTIA]))
    return Link("nut", joint=Screw((0, 0, -2), LEAD, **joint), body=body)


@pytest.mark.parametrize("method", ["auto", "newmark", "radau"])
def test_a_nut_winds_down_its_spindle(method):
    """m g p = (J + m p^2) times the angular acceleration, with the translation p per radian."""
    p = LEAD / (2 * np.pi)
    options = {"dt": 1e-3} if method == "newmark" else {}
    run = lissom.simulate(Robot([spindle()]), 1.0, method=method, **options)
    angle = MASS * 9.81 * p / (INERTIA + MASS * p**2) / 2
    assert run.model.coordinates == ("nut.angle",)
    assert_allclose(run.q[-1], angle, rtol=1e-3 if method == "auto" else 1e-8)
    assert_allclose(run.pose(link="nut")[-1][2, 3], -p * run.q[-1, 0], rtol=1e-12)


def test_friction_and_springs_hold_a_nut():
    p = LEAD / (2 * np.pi)
    weight = MASS * 9.81 * p
    stuck = lissom.simulate(Robot([spindle(friction=1.01 * weight)]), 1.0, method="newmark", dt=1e-3)
    assert abs(stuck.q[-1, 0]) < 0.02
    sprung = lissom.statics(Robot([spindle(stiffness=0.5, rest=-0.1)]))
    assert_allclose(sprung.q, [weight / 0.5 - 0.1], rtol=1e-9)
    stopped = lissom.statics(Robot([spindle(limits=(-1.0, 2.0), limit_stiffness=50.0)]), q0=[1.9])
    assert_allclose(stopped.q, [2.0 + weight / 50.0], rtol=1e-9)


def test_motors_lift_by_screws():
    p = LEAD / (2 * np.pi)
    lift = Robot([spindle()], actuators=[Motor("nut", torque=-2 * MASS * 9.81 * p)])
    run = lissom.simulate(lift, 0.5, method="newmark", dt=1e-3)
    angle = -MASS * 9.81 * p / (INERTIA + MASS * p**2) * 0.5**2 / 2
    assert_allclose(run.q[-1], angle, rtol=1e-8)


def test_a_prescribed_angle_moves_what_it_carries():
    ball = Link("ball", parent="nut", joint=Prismatic((1, 0, 0)), body=Body(0.1))
    turning = Link("nut", joint=Screw((0, 0, 1), LEAD, motion=([0, 1], [0, 4 * np.pi], "linear")))
    run = lissom.simulate(Robot([turning, ball], gravity=(0, 0, 0)), 0.25, method="radau", q0=[0.1])
    # In the turning frame the ball is thrown outwards: r'' = w^2 r.
    assert_allclose(run.q[-1], 0.1 * np.cosh(np.pi), rtol=1e-4)
    assert_allclose(run.pose(link="ball")[-1][2, 3], 2 * LEAD * 0.25, rtol=1e-9)


def test_scenes_and_repr_keep_the_screw(tmp_path):
    joint = Screw((0, 0, 1), -LEAD, stiffness=2.0, limits=(-1, np.inf), limit_stiffness=3.0)
    assert eval(repr(joint), {"inf": np.inf} | {name: getattr(lissom, name) for name in ("Screw",)}) == joint
    robot = Robot([Link("nut", joint=joint, body=BLOCK)])
    path = tmp_path / "nut.toml"
    robot.to_scene().save(path)
    assert 'type = "screw"' in path.read_text()
    assert lissom.Scene.load(path).model.links == robot.links


def test_a_screw_closes_no_loop():
    links = [Link("arm", joint=Revolute((0, 1, 0)), body=Body(1))]
    with pytest.raises((TypeError, ValueError), match=r"Screw|screw"):
        Robot(links, loops=[Loop("arm", None, Screw((0, 0, 1), LEAD))])
    with pytest.raises((TypeError, ValueError), match=r"Free|free"):
        Robot(links, loops=[Loop("arm", None, Free())])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Screw((0, 0, 0), LEAD), "axis"),
        (lambda: Screw((0, 0, 1), float("inf")), "lead"),
        (lambda: Screw((0, 0, 1)), "lead"),
        (lambda: Screw((0, 0, 1), LEAD, limits=(1, 0), limit_stiffness=1), "limits"),
    ],
)
def test_invalid_screws_are_refused(make, message):
    with pytest.raises((TypeError, ValueError), match=message):
        make()
