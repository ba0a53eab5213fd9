"""Many rods with friction: smooth forces, few iterations per step, accuracy of the equations."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

RADIUS, LENGTH = 0.01, 0.3
FLOOR = lissom.HalfSpace()


def pile(layers: int, *, friction: float = 0.3) -> lissom.Robot:
    """Layers of three rods that lie across each other, slightly rotated, above a floor."""
    segment = lissom.Segment(
        LENGTH,
        RADIUS,
        1e6,
        poisson_ratio=0.45,
        density=1000,
        modes={"torsion": 1, "bend_y": 3, "bend_z": 3},
        retardation_time=0.01,
    )
    random = np.random.default_rng(2)
    links = []
    for i in range(3 * layers):
        layer, across = divmod(i, 3)
        turn = 0.5 * np.pi * (layer % 2) + random.uniform(-0.2, 0.2)
        middle = np.array([0.0, 0.0, 0.012 + 0.022 * layer])
        middle[1 - layer % 2] = 0.09 * (across - 1)
        along = np.array([np.cos(turn), np.sin(turn), 0.0])
        links.append(
            lissom.Link(
                f"rod {i}",
                joint=lissom.Free(),
                rod=[segment],
                position=middle - 0.5 * LENGTH * along,
                orientation=(np.cos(0.5 * turn), 0, 0, np.sin(0.5 * turn)),
            )
        )
    names = [link.name for link in links]
    contacts = [lissom.Contact(name, FLOOR, friction=friction, name=f"{name} on floor") for name in names]
    contacts += [lissom.Contact(a, b, friction=friction) for i, a in enumerate(names) for b in names[:i]]
    return lissom.Robot(links, contacts=contacts)


@pytest.fixture(scope="module")
def fallen():
    """Four layers that fall onto each other."""
    robot = pile(4)
    with pytest.warns(lissom.AccuracyWarning, match="Impacts are shorter"):
        run = lissom.simulate(robot, 0.12, dt=1e-3)
    assert run.success, run.message
    return robot, run


def test_forces_between_rods_do_not_depend_on_rounding(fallen):
    # With stiffnesses of 1e5 N/m, and friction of newtons that reverses within 1e-4 m/s, a change of the
    # coordinates by 1e-15 changes forces by about 1e-9. Without convergence of the nearest points they jumped
    # by 0.1.
    robot, run = fallen
    random = np.random.default_rng(1)
    for q, v in zip(run.q[::10], run.v[::10], strict=True):
        forces = robot.inverse_dynamics(q, v, np.zeros(robot.n))
        for _ in range(10):
            nearby = q + 1e-15 * random.choice([-1.0, 1.0], robot.n)
            assert_allclose(robot.inverse_dynamics(nearby, v, np.zeros(robot.n)), forces, rtol=0, atol=1e-7)


def rolling_ball() -> lissom.Robot:
    body = lissom.Body(1.0, inertia=(4e-3, 4e-3, 4e-3))
    contact = lissom.Contact(lissom.Ball("ball", 0.1), FLOOR, stiffness=1e5, friction=0.3)
    link = lissom.Link("ball", joint=lissom.Free(), body=body, position=(0, 0, 0.0999))
    return lissom.Robot([link], contacts=[contact])


@pytest.mark.parametrize("what", ["rods", "ball"])
def test_forces_do_not_depend_on_what_was_evaluated_before(fallen, what):
    # Contact points of a shape are looked for once, for all velocities in it.
    if what == "rods":
        robot, fresh = fallen[0], pile(4)
        q, v = fallen[1].q[-1], fallen[1].v[-1]
    else:
        robot, fresh = rolling_ball(), rolling_ball()
        q, v = np.zeros(robot.n), np.zeros(robot.n)
    a = np.zeros(robot.n)
    other = v + np.random.default_rng(3).uniform(-0.1, 0.1, robot.n)
    robot.inverse_dynamics(q, v, a)
    robot.energy(q + 1e-3, v)
    robot.inverse_dynamics(q, v, a)
    found = robot.inverse_dynamics(q, other, a)
    assert len(robot.touches(q, other)) > 0
    assert_allclose(found, fresh.inverse_dynamics(q, other, a), rtol=0, atol=0)
    assert np.abs(found - fresh.inverse_dynamics(q, v, a)).max() > 1e-3


def test_steps_of_a_pile_take_few_iterations(fallen):
    # 7 iterations; line searches by the size of the next increment took 20.
    robot, run = fallen
    assert len(robot.touches(run.q[-1], run.v[-1])) > 100
    assert run.stats.newton_iterations <= 10 * run.stats.steps
    # 120 steps, and parts of those in which the first rods rebound.
    assert run.stats.steps <= 150


@pytest.mark.filterwarnings("ignore:Impacts are shorter:lissom.AccuracyWarning")
@pytest.mark.parametrize("friction", [0.0, 0.3, 2.0])
def test_what_steps_solve_for_does_not_depend_on_how(friction):
    # Errors of accelerations of one millionth are tolerated: tighter tolerances lead to the same states.
    robot = pile(2, friction=friction)
    # Steps that resolve impacts choose their sizes: these have larger errors.
    methods = [
        lissom.methods.Newmark(rho_inf=0.8, rtol=rtol, atol=1e-3 * rtol, impacts="stopped")
        for rtol in (1e-6, 1e-9)
    ]
    runs = [lissom.simulate(robot, 0.04, dt=1e-3, method=method) for method in methods]
    assert all(run.success for run in runs)
    assert_allclose(runs[0].q, runs[1].q, rtol=0, atol=1e-7)
    assert_allclose(runs[0].v, runs[1].v, rtol=0, atol=1e-4)


def test_momentum_changes_by_weight_and_floor_alone(fallen):
    # Independent of friction within the pile; the floor's impulse is summed at the ends of the steps.
    robot, run = fallen
    names = [contact.name for contact in robot.contacts if contact.name.endswith("floor")]
    weight = 9.81 * 12 * 1000 * np.pi * RADIUS**2 * LENGTH
    momentum = np.array([robot.momentum(q, v)[3:] for q, v in zip(run.q, run.v, strict=True)])
    pushed = np.zeros(3)
    for q, v in zip(run.q[1:], run.v[1:], strict=True):
        pushed += 1e-3 * sum(robot.contact_forces(q, v, name=name)[3:] for name in names)
    change = momentum[-1] - momentum[0] + np.array([0, 0, weight * 0.12])
    assert_allclose(pushed, change, rtol=0, atol=0.02 * weight * 0.12)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Impacts are shorter:lissom.AccuracyWarning")
def test_four_hundred_rods_in_one_run():
    robot = pile(134)
    assert robot.n == 402 * 13
    dt, steps = 2e-3, 4
    run = lissom.simulate(robot, steps * dt, dt=dt)
    assert run.success, run.message
    # Layers are 2 mm apart: what lies in the middle falls freely until the floor stops the lowest one.
    fallen = run.q.reshape(steps + 1, 402, 13)[-1, 3:, 2]
    assert_allclose(fallen, -0.5 * 9.81 * (steps * dt) ** 2, rtol=1e-3)
