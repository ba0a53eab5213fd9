"""Times at which contact begins and ends, compared with closed forms."""

import itertools

import numpy as np
import pytest

import lissom

G = 9.81
STIFFNESS = 2e4
MASS = 0.1
RADIUS = 0.05


def ball(joint, **constants):
    link = lissom.Link("ball", body=lissom.Body(MASS, inertia=[1e-4] * 3), joint=joint)
    floor = lissom.HalfSpace((0, 0, 0), (0, 0, 1))
    contact = lissom.Contact(
        lissom.Ball("ball", RADIUS), floor, stiffness=STIFFNESS, dissipation=0.0, name="bounce", **constants
    )
    return lissom.Robot([link], contacts=[contact])


def bounces(height, duration):
    """A ball falls on a linear spring: parabolas and parts of a cosine, in turn."""
    omega = np.sqrt(STIFFNESS / MASS)
    fall, speed = np.sqrt(2 * height / G), np.sqrt(2 * G * height)
    sag = G / omega**2
    # x'' = -omega^2 (x - sag) in the overlap x, starting at zero with the impact speed, until zero again.
    pressed = 2 * (np.pi - np.arctan2(speed / omega, sag)) / omega
    found, t = [], fall
    while t < duration:
        found.append((t, "touch"))
        if t + pressed < duration:
            found.append((t + pressed, "lift_off"))
        t += pressed + 2 * speed / G
    return found


@pytest.mark.parametrize(
    ("method", "accuracy"), [("radau", 1e-8), ("rk45", 1e-7), ("dop853", 1e-7), ("newmark", 1e-4)]
)
def test_a_ball_bounces_when_it_should(method, accuracy):
    options = {"t_eval": "steps", "rtol": 1e-9, "atol": 1e-11} if method != "newmark" else {"dt": 1e-4}
    run = lissom.simulate(ball(lissom.Prismatic((0, 0, 1))), 1.5, q0=[0.5 + RADIUS], method=method, **options)
    events, expected = run.contact_events(), bounces(0.5, 1.5)
    assert [event.kind for event in events] == [kind for _, kind in expected]
    assert {event.contact for event in events} == {"bounce"}
    for event, (t, _) in zip(events, expected, strict=True):
        assert abs(event.t - t) < accuracy
        # The state at the event: the height of the ball is its radius, and its speed that of the impact.
        assert abs(event.q[0] - RADIUS) < 10 * accuracy
        assert abs(abs(event.v[0]) - np.sqrt(2 * G * 0.5)) < 1e3 * accuracy


def test_several_contacts_are_told_apart():
    finger = lissom.Segment(0.3, 0.01, 3e5, 1e5, 1100, modes={"bend_y": 2}, retardation_time=0.05)
    floor = lissom.HalfSpace((0, 0, -0.1), (0, 0, 1))
    contacts = [
        lissom.Contact(lissom.Ball("finger", 0.02, at=0.3), floor, stiffness=1e4, name="tip"),
        lissom.Contact(lissom.Ball("finger", 0.02, at=0.15), floor, stiffness=1e4, name="middle"),
    ]
    robot = lissom.Robot([lissom.Link("finger", rod=[finger])], contacts=contacts)
    run = lissom.simulate(robot, 1.0, method="radau", t_eval="steps")
    events = run.contact_events()
    assert [event.t for event in events] == sorted(event.t for event in events)
    first = next(event for event in events if event.contact == "tip")
    assert first.kind == "touch"
    height = robot.pose(first.q, link="finger")[2, 3]
    assert abs(height - (-0.1 + 0.02)) < 1e-9
    # Between its events a contact does not change.
    for name in ("tip", "middle"):
        kinds = [event.kind for event in events if event.contact == name]
        assert all(a != b for a, b in itertools.pairwise(kinds))


def test_without_contacts_there_are_no_events():
    rod = lissom.Rod([lissom.Segment(0.3, 0.01, 3e5, 1e5, 1100, modes={"bend_y": 2})])
    assert lissom.simulate(rod, 0.05).contact_events() == []
    pendulum = lissom.simulate(lissom.SpringPendulum(), 0.05, q0=[-0.5, 0.1])
    assert pendulum.contact_events() == []
    own = lissom.newmark(lambda t, q, v, a: a + q, (0.0, 0.1), [1.0], [0.0], dt=0.01)
    with pytest.raises(ValueError, match="newmark"):
        own.contact_events()


def test_what_touches_all_the_time_has_no_events():
    robot = ball(lissom.Prismatic((0, 0, 1)))
    rest = RADIUS - MASS * G / STIFFNESS
    assert lissom.simulate(robot, 0.1, q0=[rest], dt=1e-3).contact_events() == []
