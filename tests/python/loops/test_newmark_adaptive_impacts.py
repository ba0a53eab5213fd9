"""Adaptive steps of the Newmark family through impacts, and of closed loops."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from test_loops import exact_windows, windows

import lissom

SPEED = 3.0
DAMPED = [
    {"method": "generalised_alpha", "rho_inf": 0.8},
    {"method": "generalised_alpha", "rho_inf": 0.3},
    {"method": "hht"},
]


def slider(name, axis=(1, 0, 0), position=(0, 0, 0), mass=1.0, **joint):
    return lissom.Link(name, joint=lissom.Prismatic(axis, **joint), position=position, body=lissom.Body(mass))


@pytest.mark.parametrize("options", [*DAMPED, {"method": "average_acceleration"}])
def test_a_joint_stop_returns_the_velocity(options):
    robot = lissom.Robot(
        [slider("b", limits=(-1, 0.5), limit_stiffness=1e5, stiffness=1e-9)], gravity=(0, 0, 0)
    )
    steps, errors = [], []
    for rtol in (1e-5, 1e-7):
        found = lissom.simulate(robot, 0.5, v0=[SPEED], adaptive=True, rtol=rtol, **options)
        assert found.success
        errors.append(abs(found.v[-1, 0] + SPEED))
        steps.append(found.stats.steps)
        # Half a period of the oscillation in the stop.
        flight = 0.5 / SPEED + np.pi / np.sqrt(1e5)
        assert_allclose(found.q[-1], 0.5 - SPEED * (0.5 - flight), atol=100.0 * rtol)
    assert errors[0] < 1e-3
    assert errors[1] < 1e-5
    assert steps[1] < 15 * steps[0]


def test_a_ball_leaves_an_oblique_wall_as_light_does():
    ball = lissom.Link("b", joint=lissom.Free(), body=lissom.Body(1.0, inertia=1e-3 * np.eye(3)))
    normal = np.array([-1.0, 0.1, 0.0]) / np.hypot(1.0, 0.1)
    wall = lissom.Contact(
        lissom.Ball("b", 0.05), lissom.HalfSpace((0.5, 0, 0), normal), stiffness=1e5, dissipation=0
    )
    robot = lissom.Robot([ball], gravity=(0, 0, 0), contacts=[wall])
    start = np.array([SPEED, 0.0, 0.0])
    exact = start - 2.0 * (start @ normal) * normal
    for rtol, error in ((1e-5, 2e-3), (1e-7, 2e-5)):
        found = lissom.simulate(robot, 1.0, v0=[*start, 0, 0, 0], method="newmark", adaptive=True, rtol=rtol)
        assert found.success
        assert_allclose(found.v[-1, :3], exact, atol=error)
        assert found.stats.steps < 2000
        # Nothing changes in free flight.
        away = found.t > 0.4
        assert np.ptp(found.v[away, :3], axis=0).max() < error


def test_two_balls_keep_their_momentum():
    """Of equal mass they exchange their velocities."""
    contact = lissom.Contact(lissom.Ball("a", 0.05), lissom.Ball("b", 0.05), stiffness=1e5, dissipation=0)
    robot = lissom.Robot(
        [slider("a"), slider("b", position=(0.5, 0, 0))], gravity=(0, 0, 0), contacts=[contact]
    )
    found = lissom.simulate(robot, 0.5, v0=[SPEED, 0.0], method="newmark", adaptive=True)
    assert found.success
    assert_allclose(found.v.sum(axis=1), SPEED, atol=1e-5)
    assert_allclose(found.v[-1], [0.0, SPEED], atol=1e-4)


def test_steps_grow_again_in_free_flight():
    """Accelerations there are exactly zero, the estimate too."""
    robot = lissom.Robot([slider("b", limits=(-1e3, 0.5), limit_stiffness=1e5)], gravity=(0, 0, 0))
    found = lissom.simulate(
        robot, 2.0, v0=[SPEED], method="average_acceleration", adaptive=True, rtol=1e-6, dt=1e-3
    )
    assert found.success
    assert_allclose(found.v[-1], -SPEED, rtol=1e-4)
    flight = np.diff(found.t)[found.t[:-1] > 0.3]
    assert flight.max() <= 1e-3 * (1.0 + 1e-9)
    assert np.median(flight) == pytest.approx(1e-3)


CRANK, ROD, MASSES, INERTIAS = 0.1, 0.3, (0.2, 0.5, 1.0), (0.002, 0.00375)


def crank_motion(angle, speed, times):
    """The motion of the same mechanism with one degree of freedom: half of m(angle) speed^2 is constant."""

    def mass(x):
        # Rates per unit of the crank's speed: of the rod's angle, its centre, and the piston.
        tilt = np.arcsin(CRANK * np.sin(x) / ROD)
        turning = -CRANK * np.cos(x) / (ROD * np.cos(tilt))
        centre = (
            -CRANK * np.sin(x) + 0.5 * ROD * np.sin(tilt) * turning,
            CRANK * np.cos(x) + 0.5 * ROD * np.cos(tilt) * turning,
        )
        piston = -CRANK * np.sin(x) + ROD * np.sin(tilt) * turning
        return (
            INERTIAS[0]
            + INERTIAS[1] * turning**2
            + MASSES[1] * (centre[0] ** 2 + centre[1] ** 2)
            + MASSES[2] * piston**2
        )

    energy = mass(angle) * speed**2
    exact = solve_ivp(
        lambda t, x: np.sqrt(energy / mass(x)),
        (0.0, times[-1]),
        [angle],
        "DOP853",
        times,
        rtol=1e-11,
        atol=1e-11,
    )
    return exact.y[0]


@pytest.mark.parametrize("options", [{"method": "newmark"}, *DAMPED])
def test_a_slider_crank_follows_the_motion_of_one_freedom(options):
    hinge = lissom.Revolute((0, 1, 0))
    crank = lissom.Link("crank", joint=hinge, body=lissom.Body(MASSES[0], inertia=INERTIAS[0] * np.eye(3)))
    rod = lissom.Link(
        "rod",
        parent="crank",
        position=(CRANK, 0, 0),
        joint=hinge,
        body=lissom.Body(MASSES[1], centre=(ROD / 2, 0, 0), inertia=INERTIAS[1] * np.eye(3)),
    )
    piston = slider("piston", position=(CRANK + ROD, 0, 0), mass=MASSES[2])
    loop = lissom.Loop(("rod", None, (ROD, 0, 0)), "piston", hinge)
    robot = lissom.Robot([crank, rod, piston], gravity=(0, 0, 0), loops=[loop])
    steps, errors = [], []
    for rtol in (1e-4, 1e-5, 1e-6):
        found = lissom.simulate(
            robot,
            0.8,
            q0=[2.0, -2.308, -0.1541],
            v0=[5.0, -4.27, -0.4],
            adaptive=True,
            rtol=rtol,
            atol=rtol,
            **options,
        )
        assert found.success, found.message
        exact = crank_motion(found.q[0, 0], found.v[0, 0], found.t)
        errors.append(np.abs(found.q[:, 0] - exact).max())
        steps.append(found.stats.steps)
        # Velocities satisfy the constraints, and accelerations stay of their size.
        x = CRANK * np.cos(found.q[:, 0]) + ROD * np.cos(found.q[:, 0] + found.q[:, 1])
        rate = -CRANK * np.sin(found.q[:, 0]) * found.v[:, 0] - ROD * np.sin(
            found.q[:, 0] + found.q[:, 1]
        ) * (found.v[:, 0] + found.v[:, 1])
        assert_allclose(found.q[:, 2] + CRANK + ROD, x, atol=1e-9)
        assert_allclose(found.v[1:, 2], rate[1:], atol=1e-9)
        assert np.abs(found.a).max() < 1e3
    assert errors[-1] < 1e-3
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(-2.0, abs=0.4)


def test_loops_pass_singular_positions():
    robot, v0 = windows(2)
    exact = exact_windows(2)
    errors, steps = [], []
    for tolerance in (1e-4, 1e-6):
        found = lissom.simulate(
            robot, 4.0, v0=v0, method="newmark", adaptive=True, rtol=tolerance, atol=tolerance
        )
        assert found.success, found.message
        assert np.abs(robot.loop_gaps(found.q)).max() < 1e-12
        errors.append(np.abs(found.q[:, 0] - exact(found.t)).max())
        steps.append(found.stats.steps)
    assert errors[1] < 2e-3
    assert errors[1] < 0.1 * errors[0]
    assert steps[1] < 2000


def test_a_driven_crank_moves_its_slider():
    """Constraints that depend on time."""
    hinge = lissom.Revolute((0, 0, 1))
    body = lissom.Body(0.2, centre=(0.1, 0, 0), inertia=np.diag([1e-4, 8e-4, 8e-4]))
    driven = lissom.Revolute((0, 0, 1), motion=lambda t: 3 * t + 0.3)
    crank = lissom.Link("crank", joint=driven, body=body)
    rod = lissom.Link("rod", parent="crank", position=(0.2, 0, 0), joint=hinge, body=body)
    loop = lissom.Loop(("rod", None, (0.5, 0, 0)), "slider", hinge)
    robot = lissom.Robot([crank, rod, slider("slider", mass=0.5)], gravity=(0, -9.81, 0), loops=[loop])

    def slide(t):
        return 0.2 * np.cos(3 * t + 0.3) + np.sqrt(0.25 - (0.2 * np.sin(3 * t + 0.3)) ** 2)

    q0 = [-0.3 - np.arcsin(0.2 * np.sin(0.3) / 0.5), slide(0)]
    found = lissom.simulate(robot, 1.5, q0=q0, method="newmark", adaptive=True)
    assert found.success, found.message
    assert_allclose(found.q[:, 1], slide(found.t), atol=1e-10)
