"""Nothing passes through anything unnoticed, with adaptive and with long fixed steps."""

import math

import numpy as np
import pytest

import lissom

CHOOSING = ["radau", "rk45", "dop853", "auto"]
OBSTACLES = {
    "sphere": lissom.Sphere((1, 0, 0), 0.1),
    "small sphere": lissom.Sphere((1, 0.01, 0), 2e-3),
    "plate": lissom.Box((1, 0, 0), (5e-4, 1, 1)),
    "block": lissom.Box((1, 0, 0), (0.1, 1, 1)),
    "wire": lissom.Capsule((1, -1, 0), (1, 1, 0), 5e-4),
    "pipe": lissom.Tube([(1, -1, 0), (1, 1, 0)], 0.06, wall=2e-3),
}


def thrown_ball(obstacle, radius=0.05):
    """A ball of 1 kg without weight that flies along x, stopped by springs of 1e8 N/m."""
    ball = lissom.Link("ball", body=lissom.Body(1.0, inertia=[1e-3] * 3), joint=lissom.Free())
    contact = lissom.Contact(lissom.Ball("ball", radius), obstacle, stiffness=1e8, dissipation=0.0)
    return lissom.Robot([ball], gravity=(0, 0, 0), contacts=[contact])


@pytest.mark.parametrize("name", OBSTACLES)
@pytest.mark.parametrize("method", CHOOSING)
def test_a_thrown_ball_comes_back(method, name):
    """Without dissipation the kinetic energy is restored. Free flight has no error to control the steps."""
    robot = thrown_ball(OBSTACLES[name])
    run = lissom.simulate(robot, 1.0, v0=[3, 0, 0, 0, 0, 0], method=method)
    assert run.success, run.message
    assert run.q[:, 0].max() < 1.0
    assert run.v[-1, 0] < -1.5
    energy = [robot.energy(q, v).kinetic for q, v in zip(run.q[[0, -1]], run.v[[0, -1]], strict=True)]
    assert energy[1] == pytest.approx(energy[0], rel=1e-3)


@pytest.mark.parametrize("name", OBSTACLES)
@pytest.mark.parametrize("dt", [1e-2, 5e-2])
@pytest.mark.filterwarnings("ignore:Impacts are shorter:lissom.AccuracyWarning")
def test_steps_of_one_size_do_not_pass_either(dt, name):
    """A step moves the ball by up to half a metre; impacts shorter than a step stop it."""
    run = lissom.simulate(thrown_ball(OBSTACLES[name]), 0.5, v0=[10, 0, 0, 0, 0, 0], dt=dt)
    assert run.success, run.message
    if name == "small sphere":
        # Hit off-centre: the ball continues around it.
        assert run.q[-1, 1] < -0.05
        ways = np.linspace(run.q[:-1, :3], run.q[1:, :3], 200)
        assert np.linalg.norm(ways - [1, 0.01, 0], axis=-1).min() > 0.048
    else:
        assert run.q[:, 0].max() < 1.0
        assert run.v[-1, 0] < 1e-9 * 10


def test_what_is_too_soft_to_stop_anything_is_said():
    """The ball has 500 J, and the springs of the sphere take only 0.2 J before the ball is inside."""
    ball = lissom.Link("ball", body=lissom.Body(10.0, inertia=[1e-3] * 3), joint=lissom.Free())
    sphere = lissom.Sphere((1, 0, 0.003), 2e-3)
    contact = lissom.Contact(lissom.Ball("ball", 0.05), sphere, stiffness=1e5, dissipation=0.0)
    robot = lissom.Robot([ball], gravity=(0, 0, 0), contacts=[contact])
    run = lissom.simulate(robot, 0.3, v0=[10, 0, 0, 0, 0, 0], dt=0.03)
    assert run.status == "passed_through"
    assert run.t[-1] == pytest.approx(0.09)
    assert "pass through each other" in run.message
    assert "stiffness" in run.message


@pytest.mark.parametrize("method", CHOOSING)
def test_a_ball_that_is_thrown_up_is_kept_by_a_ceiling(method):
    """A single step would bring it back to its start, so the path within the step is checked as well."""
    ball = lissom.Link("ball", body=lissom.Body(1.0, inertia=[1e-3] * 3), joint=lissom.Free())
    ceiling = lissom.Box((0, 0, 1.0), (1, 1, 0.01))
    contact = lissom.Contact(lissom.Ball("ball", 0.02), ceiling, stiffness=1e5, dissipation=0.0)
    robot = lissom.Robot([ball], contacts=[contact])
    speed = math.sqrt(2 * 9.81 * 1.3)
    period = 2 * speed / 9.81
    assert lissom.simulate(robot, 0.3 * period, v0=[0, 0, speed, 0, 0, 0], method=method).success
    run = lissom.simulate(
        robot, period, v0=[0, 0, speed, 0, 0, 0], method=method, t_eval=np.linspace(0, period, 400)
    )
    assert run.success, run.message
    assert 0.95 < run.q[:, 2].max() < 0.99


@pytest.mark.parametrize("method", ["radau", "dop853"])
@pytest.mark.parametrize("offset", [0.0, 0.01])
def test_balls_exchange_their_velocities(method, offset):
    links = [
        lissom.Link(name, body=lissom.Body(1.0, inertia=[1e-3] * 3), joint=lissom.Free(), position=(x, y, 0))
        for name, x, y in (("a", 0, 0), ("b", 1, offset))
    ]
    contact = lissom.Contact(lissom.Ball("a", 0.02), lissom.Ball("b", 0.02), stiffness=1e5, dissipation=0.0)
    robot = lissom.Robot(links, gravity=(0, 0, 0), contacts=[contact])
    v0 = np.zeros(12)
    v0[0] = 3.0
    run = lissom.simulate(robot, 0.6, v0=v0, method=method)
    assert run.success, run.message
    assert run.v[-1, 6] > 2.0
    assert run.v[-1, 0] + run.v[-1, 6] == pytest.approx(3.0, rel=1e-9)


def soft_rod(name, position, orientation=(1, 0, 0, 0)):
    segment = lissom.Segment(
        0.3,
        radius=0.01,
        young_modulus=1e6,
        poisson_ratio=0.45,
        density=1000,
        modes={"bend_y": 3, "bend_z": 3},
        retardation_time=1e-3,
    )
    return lissom.Link(name, rod=[segment], joint=lissom.Free(), position=position, orientation=orientation)


@pytest.mark.parametrize("radius", [0.02, 1e-3])
def test_a_rod_that_falls_on_a_peg_is_caught(radius):
    """Its middle hits first, between two of its nodes if the peg is thin."""
    peg = lissom.Capsule((0.004, -1, 0), (0.004, 1, 0), radius)
    robot = lissom.Robot([soft_rod("rod", (-0.15, 0, 1.0))], contacts=[lissom.Contact("rod", peg)])
    ends = []
    for method in ("radau", "dop853"):
        run = lissom.simulate(robot, 0.5, method=method)
        assert run.success, run.message
        ends.append(robot.pose(run.q[-1], 0.15)[2, 3])
    assert min(ends) > -0.01
    assert ends[0] == pytest.approx(ends[1], abs=1e-3)


@pytest.mark.parametrize("method", ["newmark", "radau", "dop853"])
def test_rods_do_not_cross(method):
    quarter = math.sqrt(0.5)
    still = soft_rod("still", (0.15, -0.15, 0.5), (quarter, 0, 0, quarter))
    robot = lissom.Robot(
        [soft_rod("thrown", (0, 0, 0)), still],
        gravity=(0, 0, 0),
        contacts=[lissom.Contact("thrown", "still")],
    )
    v0 = np.zeros(robot.n)
    v0[list(robot.coordinates).index("thrown.z")] = 5.0
    run = lissom.simulate(robot, 0.2, v0=v0, method=method, dt=1e-3)
    assert run.success, run.message
    middles = [
        [robot.pose(q, 0.15, link=name)[2, 3] for name in ("thrown", "still")] for q in (run.q[0], run.q[-1])
    ]
    assert middles[0][0] < middles[0][1]
    assert middles[1][0] < middles[1][1]
    momentum = robot.momentum(run.q[-1], run.v[-1])
    assert momentum[5] == pytest.approx(robot.momentum(run.q[0], run.v[0])[5], rel=1e-2)


@pytest.mark.parametrize(
    "options", [{"method": "radau", "rtol": 1e-3, "max_steps": 30}, {"dt": 0.02}, {"dt": 0.002}]
)
@pytest.mark.parametrize(
    "section", [lissom.Section.ellipse(0.012, 0.004), lissom.Section.rectangle(0.024, 0.008)]
)
def test_ribbons_do_not_cross(section, options):
    """They lie flat across each other and meet at their thin side, well inside their width."""
    links = []
    for name, height, turn in [("still", 0.0, 0.0), ("thrown", 0.02, 0.25 * math.pi)]:
        along = np.array([math.cos(2 * turn), math.sin(2 * turn), 0.0])
        segment = lissom.Segment(
            0.3,
            section=section,
            young_modulus=2e6,
            poisson_ratio=0.45,
            density=1000,
            modes={"bend_y": 3, "bend_z": 3, "torsion": 2},
        )
        links.append(
            lissom.Link(
                name,
                rod=[segment],
                joint=lissom.Free(),
                position=-0.15 * along + [0, 0, height],
                orientation=(math.cos(turn), 0, 0, math.sin(turn)),
            )
        )
    contact = lissom.Contact("still", "thrown", friction=0.3, stiffness=2e5)
    robot = lissom.Robot(links, gravity=(0, 0, 0), contacts=[contact])
    v0 = np.zeros(robot.n)
    v0[list(robot.coordinates).index("still.z")] = 0.5
    v0[list(robot.coordinates).index("thrown.z")] = -1.0
    run = lissom.simulate(robot, 0.02, v0=v0, t_eval="steps" if "method" in options else None, **options)
    # Radau takes short steps where they touch, long ones would lead to the other side in a few.
    assert run.status in ("finished", "too_many_steps"), run.message
    assert run.t[-1] > 0.008
    still, thrown = (robot.pose(run.q[-1], 0.15, link=name)[2, 3] for name in ("still", "thrown"))
    assert thrown > still


@pytest.mark.parametrize("method", ["radau", "rk45", "dop853", "auto"])
def test_what_spins_freely_is_followed(method):
    """A constant rate has no error to limit the steps: a step with too large a rotation is repeated."""
    body = lissom.Link("body", body=lissom.Body(1.0, inertia=[1e-3] * 3), joint=lissom.Free())
    robot = lissom.Robot([body], gravity=(0, 0, 0))
    run = lissom.simulate(robot, 3.0, v0=[1, 0, 0, 0, -100.0, 0], method=method)
    assert run.success, run.message
    np.testing.assert_allclose(run.v[-1], [1, 0, 0, 0, -100.0, 0], atol=1e-9)
    angle = -100.0 * 3.0
    np.testing.assert_allclose(
        robot.pose(run.q[-1])[:3, 0], [math.cos(angle), 0, -math.sin(angle)], atol=1e-6
    )


@pytest.mark.parametrize("dt", [0.01, 0.005])
@pytest.mark.parametrize("obstacle", ["plate", "wire"])
@pytest.mark.filterwarnings("ignore:Impacts are shorter:lissom.AccuracyWarning")
def test_a_ball_does_not_pass_what_is_thinner_than_itself(obstacle, dt):
    """In steps of a whole impact it is pushed back, though it begins a step deep in front of the obstacle."""
    body = lissom.Link("ball", joint=lissom.Prismatic((1, 0, 0)), body=lissom.Body(1.0))
    thin = {
        "plate": lissom.Box((1, 0, 0), (1e-3, 0.2, 0.2)),
        "wire": lissom.Capsule((1, -0.2, 0), (1, 0.2, 0), 2e-3),
    }[obstacle]
    contact = lissom.Contact(lissom.Ball("ball", 0.02), thin, stiffness=1e5, dissipation=0)
    robot = lissom.Robot([body], gravity=(0, 0, 0), contacts=[contact])
    # The exact depth is v sqrt(m / k), 0.79 of the radius.
    motion = lissom.simulate(robot, 0.6, v0=[5.0], dt=dt)
    if motion.success:
        assert motion.q.max() < 1.0
        assert -5.01 < motion.v[-1, 0] < 0.0
    else:
        assert motion.status == "passed_through"


def ball_over_a_corner():
    """A ball flies over the corner of a turned box, and would be 5 mm deep in it: robot, start and end."""
    link = lissom.Link(
        "ball", joint=lissom.Planar((0, 1, 0)), body=lissom.Body(1.0, inertia=np.eye(3) * 0.01)
    )
    box = lissom.Box((1, 0, 0), (0.05, 1, 0.05), (np.cos(0.4), 0, np.sin(0.4), 0))
    contact = lissom.Contact(lissom.Ball("ball", 0.05), box, stiffness=1e5, dissipation=0)
    robot = lissom.Robot([link], contacts=[contact])
    start = {"q0": [0, 0.0717, 0], "v0": [9.67, -0.0877, 0]}
    exact = lissom.simulate(robot, 0.2068, method="radau", rtol=1e-9, max_step=2e-4, **start)
    assert exact.success, exact.message
    assert exact.v[-1, 1] > 3.3
    return robot, start, exact.q[-1]


@pytest.mark.parametrize("method", ["radau", "rk45", "dop853"])
def test_adaptive_steps_see_what_is_grazed_on_the_way(method):
    robot, start, end = ball_over_a_corner()
    motion = lissom.simulate(robot, 0.2068, method=method, rtol=1e-5, **start)
    assert motion.success, motion.message
    np.testing.assert_allclose(motion.q[-1], end, atol=2e-3)


@pytest.mark.parametrize("method", ["RK45", "DOP853"])
def test_so_do_those_of_solve_ivp(method):
    robot, start, end = ball_over_a_corner()
    motion = lissom.solve_ivp(robot, (0, 0.2068), [*start["q0"], *start["v0"]], method, rtol=1e-5)
    assert motion.success, motion.message
    np.testing.assert_allclose(motion.y[:3, -1], end, atol=2e-3)
