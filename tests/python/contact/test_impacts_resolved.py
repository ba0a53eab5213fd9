"""Steps of fixed size that resolve impacts: against exact rebounds, and against Radau's method by itself."""

import copy

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom
from lissom import Ball, Body, Contact, Free, HalfSpace, Link, Prismatic, Robot, Segment

G = 9.81
FLOOR = HalfSpace((0, 0, 0), (0, 0, 1))
RESOLVED = lissom.methods.Newmark(impacts="resolved")


def ball(stiffness, dissipation=0.0, mass=1.0, unit=1.0):
    """A ball above a floor, in metres over `unit`."""
    links = [Link("ball", joint=Prismatic((0, 0, 1)), body=Body(mass))]
    contact = Contact(Ball("ball", 0.1 / unit), FLOOR, stiffness=stiffness, dissipation=dissipation * unit)
    return Robot(links, contacts=[contact], gravity=(0, 0, -G / unit))


@pytest.mark.parametrize(
    ("stiffness", "height", "dt"),
    [(1e5, 10.0, 1e-2), (1e8, 1.0, 1e-2), (1e8, 1.0, 3e-3), (1e10, 0.1, 1e-2), (1e10, 0.1, 1e-3)],
)
def test_an_ideal_ball_returns(stiffness, height, dt):
    # Centres fall by the height until the surfaces touch; what is pressed comes back.
    robot = ball(stiffness)
    result = lissom.simulate(robot, 2.3 * np.sqrt(2 * height / G), dt=dt, q0=[0.1 + height], method=RESOLVED)
    top = result.q[result.t > 1.2 * np.sqrt(2 * height / G), 0].max() - 0.1
    # The step after the impact (backward Euler) loses g dt^2 / 2, and the top lies within half a step
    # of one of the times.
    lost = G * dt**2 * (1 / 2 + 1 / 8)
    assert height * (1 - 2e-4) - lost < top < height * (1 + 2e-4)
    energy = np.array([robot.energy(q, v).total for q, v in zip(result.q, result.v, strict=True)])
    assert np.all(np.diff(energy) < 2e-4 * G * height)
    assert result.doubt is None
    assert result.balance.drift < 2e-4 + lost / height


def test_an_inelastic_ball_returns_as_its_law_says():
    robot = ball(1e6, dissipation=0.1)
    result = lissom.simulate(robot, 1.0, dt=1e-2, q0=[1.1], method=RESOLVED)
    fine = lissom.simulate(robot, 1.0, q0=[1.1], method="radau", rtol=1e-10, atol=1e-12, t_eval=result.t)
    assert_allclose(result.q, fine.q, atol=2e-3)
    # What the impact takes out is in the balance.
    assert_allclose(result.balance.dissipated[-1], fine.balance.dissipated[-1], rtol=2e-3)
    assert result.balance.drift < 2e-3


@pytest.mark.parametrize("unit", [1.0, 1e-3])
def test_the_last_of_three_balls_goes_on(unit):
    """Momentum and energy leave no other end for equal masses in a row."""
    links = [Link(f"ball {i}", joint=Prismatic((1, 0, 0)), body=Body(1.0)) for i in range(3)]
    contacts = [
        Contact(
            Ball(f"ball {i}", 0.1 / unit), Ball(f"ball {i + 1}", 0.1 / unit), stiffness=1e6, dissipation=0.0
        )
        for i in range(2)
    ]
    row = Robot(links, contacts=contacts, gravity=(0, 0, 0))
    q0, v0 = np.array([0, 0.5, 1.0]) / unit, np.array([1.0, 0, 0]) / unit
    result = lissom.simulate(row, 2.0, dt=1e-2, q0=q0, v0=v0, method=RESOLVED)
    assert_allclose(result.v[-1] * unit, [0, 0, 1], atol=1e-4)
    with pytest.warns(lissom.AccuracyWarning, match=r'impacts="resolved"'):
        stopped = lissom.simulate(row, 2.0, dt=1e-2, q0=q0, v0=v0)
    assert stopped.v[-1, 2] * unit < 0.5


@pytest.mark.parametrize("retardation_time", [0.0, 1e-3])
def test_a_rod_that_falls_on_its_end(retardation_time):
    """Its waves make the rebound: an impulse by the mass at its end would not."""
    segment = Segment(
        0.3,
        0.01,
        1e6,
        poisson_ratio=0.5,
        density=1000,
        modes={"stretch": 5},
        retardation_time=retardation_time,
    )
    upright = (np.sqrt(0.5), 0, -np.sqrt(0.5), 0)
    rod = Link("rod", joint=Free(), rod=[segment], position=(0, 0, 0.06), orientation=upright)
    robot = Robot([rod], contacts=[Contact("rod", FLOOR, dissipation=0.0)])
    result = lissom.simulate(robot, 0.25, dt=1e-2, method=RESOLVED)
    fine = lissom.simulate(robot, 0.25, method="radau", rtol=1e-7, atol=1e-10, t_eval=result.t)

    def middle(q):
        return robot.pose(q, [0.15], link="rod")[0, 2, 3]

    tops = [max(middle(q) for q in run.q[15:]) for run in (result, fine)]
    assert tops[1] > 0.18
    assert_allclose(tops[0], tops[1], atol=1.5e-3)
    assert result.stats.nfev < 0.3 * fine.stats.nfev


def test_steps_go_on_from_a_saved_state():
    robot = ball(1e5)
    whole = lissom.Simulation(robot, dt=1e-2, q0=[0.6], method=RESOLVED)
    # After the first impact at 0.32 s.
    whole.step(duration=0.33)
    other = copy.copy(whole)
    for simulation in (whole, other):
        assert simulation.step(duration=0.3) == "finished"
    assert whole.q[0] > 0.55
    assert whole.q[0] == other.q[0]


def test_what_cannot_be_resolved_is_refused():
    with pytest.raises(ValueError, match=r"impacts: got 'resolved', expected 'stopped': adaptive steps"):
        lissom.methods.Newmark(adaptive=True, impacts="resolved")
    with pytest.raises(ValueError, match=r"impacts: got \"?'?bounced"):
        lissom.methods.Newmark(impacts="bounced")
    tendon = lissom.Tendon(
        "rope", path=[lissom.Via(None, (0, 0, 1)), lissom.Via("ball", (0, 0, 0))], length=0.5
    )
    robot = ball(1e5)
    tied = Robot(robot.links, contacts=robot.contacts, actuators=[tendon])
    with pytest.raises(ValueError, match=r"impacts: .*tendons with a `stiffness`"):
        lissom.simulate(tied, 0.1, q0=[0.6], method=RESOLVED)
