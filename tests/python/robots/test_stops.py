"""Joint stops, and tendons with a stiffness, met in flight: adaptive methods must not step across them."""

import numpy as np
import pytest

import lissom

GRAVITY = 9.81
MASS, STIFFNESS = 2.0, 1e6

#: Adaptive methods, at their default tolerances.
ADAPTIVE = {
    "rk45": {"method": "rk45"},
    "dop853": {"method": "dop853"},
    "radau": {"method": "radau"},
    "auto": {"method": "auto"},
    "newmark": {"method": "newmark", "adaptive": True},
    "generalised_alpha": {"method": "generalised_alpha", "adaptive": True},
}


def slider(**joint):
    return lissom.Link("slider", joint=lissom.Prismatic((0, 0, 1), **joint), body=lissom.Body(MASS))


def against_a_stop(height):
    return lissom.Robot([slider(limits=(-np.inf, height), limit_stiffness=STIFFNESS)])


def on_a_rope(height):
    """A rope to a point in the world below the slider holds it at this height."""
    path = [lissom.Via(None, (0, 0, -1.0)), lissom.Via("slider", (0, 0, 0))]
    rope = lissom.Tendon("rope", path, length=1.0 + height, stiffness=STIFFNESS)
    return lissom.Robot([slider()], actuators=[rope])


def highest(height, speed):
    """Height that a body reaches which is thrown up against a spring, from the energy."""
    coming = speed**2 - 2 * GRAVITY * height
    if coming <= 0.0:
        return 0.5 * speed**2 / GRAVITY
    weight = MASS * GRAVITY
    return height + (np.sqrt(weight**2 + STIFFNESS * MASS * coming) - weight) / STIFFNESS


@pytest.mark.parametrize("make", [against_a_stop, on_a_rope])
@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("part", [0.3, 0.7, 0.9, 0.97, 1.03])
def test_a_throw_ends_at_a_stop(make, method, part):
    """The apex would be at 1 / `part` of the height of the stop; beyond 1 the stop is not reached."""
    speed = 3.0
    height = part * 0.5 * speed**2 / GRAVITY
    robot = make(height)
    run = lissom.simulate(robot, 0.7, v0=[speed], t_eval=np.linspace(0, 0.7, 1401), **ADAPTIVE[method])
    assert run.success, run.message
    z, reached = run.q[:, 0], highest(height, speed)
    assert z.max() < reached + 1e-4 * height
    # Nothing dissipates: it comes back as fast as it went.
    balance = run.balance
    assert np.ptp(balance.total) < 1e-2 * balance.kinetic.max()


def thrown_back(height, speed, t):
    """Height at a time at which a body thrown up against a spring falls again, in closed form."""
    coming = np.sqrt(speed**2 - 2 * GRAVITY * height)
    rate, sinking = np.sqrt(STIFFNESS / MASS), MASS * GRAVITY / STIFFNESS
    # On the spring it swings about the point at which the spring holds the weight.
    lasts = 2 * np.arctan2(coming / rate, sinking) / rate
    left = t - (speed - coming) / GRAVITY - lasts
    assert left > 0.0
    return height - coming * left - 0.5 * GRAVITY * left**2


@pytest.mark.parametrize("make", [against_a_stop, on_a_rope])
@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("over", [1e-1, 2e-2, 1e-3, 1e-6])
def test_a_stop_that_is_just_reached_throws_back(make, method, over):
    """The apex would be above the stop by this part of its height: in few long steps, which could pass it."""
    speed = np.sqrt(2 * GRAVITY * (1.0 + over))
    end = 2.0 * speed / GRAVITY
    run = lissom.simulate(make(1.0), end, v0=[speed], **ADAPTIVE[method])
    assert run.success, run.message
    np.testing.assert_allclose(run.q[-1, 0], thrown_back(1.0, speed, end), atol=2e-4)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_body_that_bounces_on_a_stop_comes_to_rest(method):
    """Many bounces, each lower than the one before: none takes more than some tens of steps."""
    joint = {"limits": (0.0, np.inf), "limit_stiffness": STIFFNESS, "limit_dissipation": 0.3}
    run = lissom.simulate(lissom.Robot([slider(**joint)]), 2.0, q0=[0.1], **ADAPTIVE[method])
    assert run.success, run.message
    assert run.stats.steps < 20_000
    assert run.q[:, 0].min() > -2e-3
    balance = run.balance
    assert np.ptp(balance.total) < 2e-2 * balance.kinetic.max()


@pytest.mark.parametrize("method", ADAPTIVE)
def test_one_joint_at_rest_on_its_stop_does_not_hide_another(method):
    lying = slider(limits=(0.0, np.inf), limit_stiffness=STIFFNESS, limit_dissipation=1.0)
    thrown = lissom.Link(
        "thrown",
        joint=lissom.Prismatic((0, 0, 1), limits=(-np.inf, 0.4), limit_stiffness=STIFFNESS),
        body=lissom.Body(MASS),
    )
    robot = lissom.Robot([lying, thrown])
    rest = -MASS * GRAVITY / STIFFNESS
    run = lissom.simulate(robot, 0.5, q0=[rest, 0.0], v0=[0.0, 3.0], **ADAPTIVE[method])
    assert run.success, run.message
    assert run.q[:, 1].max() < highest(0.4, 3.0) + 4e-5
