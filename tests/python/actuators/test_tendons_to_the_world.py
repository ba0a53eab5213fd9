"""Tendons to points of the world, on moving bases: these points stay, as anchors of supports do."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom
from lissom import Along, Link, Tendon, Via
from lissom.model.glyphs.actuators import actuator_glyphs

POINT = (0.1, 0.3, 0.5)
ROD = lissom.Segment(
    0.3, 0.01, 1e6, 4e5, 1000.0, {"bend_y": 2, "bend_z": 1, "stretch": 1}, retardation_time=0.005
)
#: The base is shaken, and rotates about a general axis.
SHAKEN = {
    "base_motion": lissom.BaseMotion(
        translation=lissom.Harmonic((0.05, 0.02, 0.1), 2.0), axis=(1, 2, 0), angle=lissom.Harmonic(0.3, 1.0)
    )
}
#: Pose of the base at rest.
BASE = {"position": (0.02, -0.01, 0.03), "orientation": (0.9, 0.1, -0.3, 0.3)}
STATE = np.array([1.0, 2.0, -0.5, 0.01]), np.array([3.0, 1.0, -2.0, 0.1])
TENDONS = {
    "a tension": lambda: Tendon("it", [Via(None, POINT), Via("arm", (0, 0, 0.02), 0.1)], tension=2.0),
    "a tension that is set": lambda: Tendon(
        "it", [Via("arm", (0, 0, 0.02)), Via(None, POINT)], tension=lissom.Input("pull", 2.0)
    ),
    "a length": lambda: Tendon(
        "it", [Via(None, POINT), Along("arm", (0, 0.01))], length=0.3, stiffness=30.0, damping=0.2
    ),
    "friction": lambda: Tendon(
        "it",
        [Via(None, POINT), Along("arm", (0.002, 0.01))],
        length=0.3,
        stiffness=30.0,
        damping=0.2,
        friction=0.2,
    ),
}
tendons = pytest.mark.parametrize("tendon", TENDONS)


def robot(*actuators, **more):
    arm = Link("arm", rod=[ROD], **BASE)
    return lissom.Robot([arm], actuators=actuators, **(SHAKEN | {"gravity": (0, 0, -9.81)} | more))


def slope(f, h=1e-5):
    """The derivative at zero, by fourth-order differences."""
    return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h)


def test_a_base_that_rises_shortens_a_tendon_to_the_world():
    mass = Link("mass", joint=lissom.Prismatic((0, 0, 1)), body=lissom.Body(1.0, inertia=(1, 1, 1)))
    lifted = lissom.BaseMotion(translation=lissom.Harmonic((0, 0, 0.1), 1.0))
    spring = Tendon("it", [Via(None, (0, 0, 1)), Via("mass", (0, 0, 0))], length=0.5, stiffness=10.0)
    model = lissom.Robot([mass], gravity=(0, 0, 0), base_motion=lifted, actuators=[spring])
    free = lissom.Robot([mass], gravity=(0, 0, 0), base_motion=lifted)
    rest = [0.0]
    assert_allclose(model.actuator_length("it", rest, t=0.25), 0.9, rtol=1e-14)
    assert_allclose(model.actuator_force("it", rest, rest, t=0.25), 4.0, rtol=1e-13)
    assert_allclose(model.actuator_rate("it", rest, rest, t=0.0), -2 * np.pi * 0.1, rtol=1e-12)
    pulled, alone = (each.inverse_dynamics(rest, rest, rest, t=0.25) for each in (model, free))
    assert_allclose(pulled - alone, -4.0, rtol=1e-12)
    # At rest relative to the falling base: pulled down from above.
    falls = (2 * np.pi) ** 2 * 0.1
    assert_allclose(lissom.statics(model, t=0.25).q, 1.0 - 0.1 + 0.5 + falls / 10.0, rtol=1e-9)


@tendons
def test_lengths_are_those_between_places_in_the_world(tendon):
    model = robot(TENDONS[tendon]())
    q, v = STATE
    glyph = actuator_glyphs(model)[0]
    for t in (0.0, 0.13, 0.3):
        way = glyph.way(q[None], np.array([t]))[0]
        ends = [way[0], way[-1]]
        assert min(np.linalg.norm(end - POINT) for end in ends) == 0.0
        along = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
        assert_allclose(model.actuator_length("it", q, t=t), along, rtol=1e-4)
        rate = slope(lambda s, t=t: model.actuator_length("it", q + s * v, t=t + s))
        assert_allclose(model.actuator_rate("it", q, v, t=t), rate, rtol=1e-8)


@tendons
def test_tangents_are_exact(tendon):
    model = robot(TENDONS[tendon]())
    q, v = STATE
    a, t = np.array([1.0, -2.0, 3.0, 0.2]), 0.13
    of_q, of_v, _ = model.tangent(q, v, a, t=t)
    for k, unit in enumerate(np.eye(model.n)):
        by_q = slope(lambda s, unit=unit: model.inverse_dynamics(q + s * unit, v, a, t=t))
        by_v = slope(lambda s, unit=unit: model.inverse_dynamics(q, v + s * unit, a, t=t))
        scale = 1e-7 * (1 + np.abs(of_q).max())
        assert_allclose(of_q[:, k], by_q, rtol=0, atol=scale)
        assert_allclose(of_v[:, k], by_v, rtol=0, atol=scale)


@tendons
def test_energy_changes_by_what_the_base_and_the_tendon_do(tendon):
    model = robot(TENDONS[tendon]())
    q, v = STATE
    for t in (0.0, 0.13):
        a = model.forward_dynamics(q, v, t=t)
        change = slope(lambda s, t=t, a=a: model.energy(q + s * v + s * s / 2 * a, v + s * a, t=t + s).total)
        power = model.supplied_power(q, v, t=t) - model.dissipated_power(q, v, t=t)
        assert_allclose(change, power, rtol=1e-6)


@tendons
def test_the_balance_of_a_run_closes(tendon):
    model = robot(TENDONS[tendon]())
    # Friction alternates on a shaken base, which reduces the steps.
    t_end = 0.1 if tendon == "friction" else 0.5
    run = lissom.simulate(model, t_end, method="radau", dt=0.01, rtol=1e-8, atol=1e-10)
    assert run.success
    assert run.balance.drift < 1e-6
    # Sensors in a run give the same.
    seen = lissom.sensors.ActuatorLength(model, "it").measure(run.t, run.q, run.v, run.a, run.u)
    assert_allclose(np.ravel(seen), model.actuator_length("it", run.q, t=run.t), rtol=1e-14)
    assert np.ptp(seen) > 1e-3


@pytest.mark.parametrize("is_planar", [False, True])
def test_a_spring_to_the_world_is_a_support(is_planar):
    """A tendon without free length acts like a support with the same stiffness along all axes."""
    if is_planar:
        point = (0.25, 0.0, 0.2)
        motion = lissom.BaseMotion(
            translation=lissom.Harmonic((0.05, 0, 0.1), 2.0), axis=(0, 1, 0), angle=lissom.Harmonic(0.3, 1.0)
        )
        segment = lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, {"bend_y": 2, "stretch": 1})
        more = {"base_motion": motion}
        arm = Link("arm", rod=[segment], position=(0.02, 0, 0.03))
        q, v = np.array([1.0, 2.0, 0.01]), np.array([3.0, 1.0, 0.1])
    else:
        point, more, (q, v) = POINT, SHAKEN, STATE
        arm = Link("arm", rod=[ROD], **BASE)
    spring = Tendon("it", [Via(None, point), Via("arm", (0, 0, 0))], length=0.0, stiffness=30.0)
    pulled = lissom.Robot([arm], actuators=[spring], **more)
    held = lissom.Robot([arm], supports=[lissom.Support(stiffness=30.0, position=point, link="arm")], **more)
    assert held.kernel == ("planar" if is_planar else "spatial")
    for t in (0.0, 0.13, 0.4):
        for ask in ("inverse_dynamics", "base_wrench", "supplied_power", "tangent"):
            one, other = (getattr(each, ask)(q, v, v, t=t) for each in (pulled, held))
            for ours, theirs in zip(np.atleast_1d(one), np.atleast_1d(other), strict=True):
                assert_allclose(ours, theirs, rtol=1e-10, atol=1e-10)
        assert_allclose(pulled.energy(q, v, t=t).total, held.energy(q, v, t=t).total, rtol=1e-12)
        equilibria = [lissom.statics(each, t=t, space_error=False).q for each in (pulled, held)]
        assert_allclose(*equilibria, atol=1e-8)
        linear = [lissom.modes(each, equilibria[1], t=t).frequency for each in (pulled, held)]
        assert_allclose(*linear, rtol=1e-6)
    runs = [lissom.simulate(each, 0.3, dt=1e-3).q[-1] for each in (pulled, held)]
    assert_allclose(*runs, atol=1e-9)


def test_a_base_that_is_moved_to_its_place_and_rests_there_is_one_that_rests():
    tendon = TENDONS["friction"]()
    moved = lissom.BaseMotion(translation=(0.1, 0.0, -0.2), axis=(0, 0, 1), angle=0.4)
    turned = Link("base", orientation=(np.cos(0.2), 0, 0, np.sin(0.2)))
    # About the position of the base in the world.
    place = Link("arm", parent="base", rod=[ROD])
    there = lissom.Robot([Link("arm", rod=[ROD])], base_motion=moved, actuators=[tendon])
    shifted = lissom.Robot(
        [Link("base", position=(0.1, 0.0, -0.2), orientation=turned.orientation), place], actuators=[tendon]
    )
    q, v = STATE
    assert_allclose(
        there.inverse_dynamics(q, v, v, t=0.0), shifted.inverse_dynamics(q, v, v), rtol=1e-11, atol=1e-11
    )
    assert_allclose(there.actuator_length("it", q, t=0.0), shifted.actuator_length("it", q), rtol=1e-13)
