"""Pulses in tables of loads and commands, and prescribed motions that start at once or from rest."""

import copy
import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom
from lissom import BaseMotion, Body, Link, Prismatic, Revolute, Robot
from reference import newmark

FIXED = ("newmark", "hht", "generalised_alpha")
METHODS = (*FIXED, "rk45", "dop853", "radau")
EVERY = (*METHODS, "auto")
ALONG_X = (1, 0, 0)
EDGE = 1e-6


def pulse(force, start, duration, edge=EDGE):
    """A table of forces along x: zero, but for a pulse."""
    times = [-1.0, start, start + edge, start + duration - edge, start + duration, 9.0]
    return times, [[force * part, 0, 0] for part in (0, 0, 1, 1, 0, 0)]


def slider(force, mass=1.0, **joint):
    link = Link("slider", body=Body(mass), joint=Prismatic(ALONG_X, **joint))
    return Robot([link], loads=[lissom.Load(force=force, link="slider")], gravity=(0, 0, 0))


def coast(t, mass, table):
    """Velocity and position of a free particle, by the antiderivatives of a table of forces."""
    times, values = np.asarray(table[0]), np.asarray(table[1])[:, 0]
    fine = np.union1d(np.union1d(t, times[times <= t[-1]]), np.linspace(t[0], t[-1], 1001))
    force = np.interp(fine, times, values)
    h = np.diff(fine)
    v = np.append(0, np.cumsum(h * (force[1:] + force[:-1]) / 2)) / mass
    x = np.append(0, np.cumsum(h * v[:-1] + h**2 * (2 * force[:-1] + force[1:]) / 6 / mass))
    return np.interp(t, fine, v), np.interp(t, fine, x)


# ------------------------------------------------------------------------------------------------ loads


@pytest.mark.parametrize("method", EVERY)
@pytest.mark.parametrize("start", [0.0, 0.0021, 0.0337])
def test_no_pulse_is_lost(method, start):
    table = pulse(1000.0, start, 5.7e-3)
    motion = lissom.simulate(slider(table), 0.1, method=method, t_eval=np.linspace(0, 0.1, 21))
    v, x = coast(motion.t, 1.0, table)
    assert motion.success
    assert_allclose(motion.v[:, 0], v, atol=2e-3 * 5.7)
    assert_allclose(motion.q[:, 0], x, atol=2e-3 * 0.57)


@pytest.mark.parametrize("method", FIXED)
def test_steps_end_at_corners_and_return_to_their_grid(method):
    table = pulse(1000.0, 0.0337, 5.7e-3)
    motion = lissom.simulate(slider(table), 0.1, method=method)
    corners = np.array(table[0][1:-1])
    assert_allclose(motion.t, np.sort(np.append(np.linspace(0, 0.1, 11), corners)), atol=1e-15)
    v, _ = coast(motion.t, 1.0, table)
    assert_allclose(motion.v[:, 0], v, atol=1e-6)
    # Corners on the grid change nothing.
    ramp = ([0.0, 0.03, 0.05, 0.1], [[0, 0, 0], [0, 0, 0], [9, 0, 0], [2, 0, 0]])
    assert_allclose(lissom.simulate(slider(ramp), 0.1, method=method).t, np.linspace(0, 0.1, 11), atol=1e-15)


@pytest.mark.parametrize("method", FIXED)
def test_the_order_is_two_with_corners_within_steps(method):
    table = ([0.0, 0.113, 0.371, 0.3953, 2.0], [[0, 0, 0], [4, 0, 0], [-2, 0, 0], [1, 0, 0], [1, 0, 0]])
    model = slider(table, stiffness=30.0)
    exact = lissom.simulate(model, 1.0, method="dop853", rtol=1e-12, atol=1e-13, t_eval=[1.0])
    errors = []
    for dt in (0.02, 0.01, 0.005, 0.0025):
        motion = lissom.simulate(model, 1.0, method=method, dt=dt)
        errors.append(abs(motion.q[-1] - exact.q[-1]).max() + abs(motion.v[-1] - exact.v[-1]).max())
    assert errors[-1] < 2e-3
    assert 3.0**3 < errors[0] / errors[-1] < 5.2**3


SCHEMES = (
    {"method": "newmark"},
    {"method": "hht"},
    {"method": "hht", "alpha": -0.3},
    {"method": "generalised_alpha"},
    {"method": "generalised_alpha", "rho_inf": 0.2},
)


@pytest.mark.parametrize("edge", [0.0, 1e-12, 1e-9, 1e-6])
@pytest.mark.parametrize("method", [*SCHEMES, *({"method": name} for name in EVERY[3:])])
def test_edges_may_be_as_steep_as_they_like(method, edge):
    """1000 N for 0.1 ms give 1 kg a speed of 0.1 m/s; edges of no width are as narrow as numbers allow."""
    allowed = {"auto": 2e-3}.get(method["method"], 2e-4)
    for start in (0.0, 0.02, 0.02 - edge, 0.0205, 0.0213):
        # On both sides of the times of steps.
        up, down = (max(edge, 2 * np.spacing(t)) for t in (start, start + 1e-4))
        times = [start, start + up, start + 1e-4, start + 1e-4 + down]
        model = slider((times, [[0, 0, 0], [1000, 0, 0], [1000, 0, 0], [0, 0, 0]]))
        for dt in (1e-2, 1e-3):
            motion = lissom.simulate(model, 0.1, dt=dt, **method)
            assert motion.success
            assert not motion.doubt
            assert motion.v[-1, 0] == pytest.approx(0.1, rel=2e-6 if method in SCHEMES else allowed)
            assert motion.q[-1, 0] == pytest.approx(0.1 * (0.1 - start - 5e-5), rel=1e-4 + allowed)
            # Work is as much as the motion has.
            assert motion.balance.work[-1] == pytest.approx(motion.balance.kinetic[-1], rel=1e-3)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("width", [1e-3, 1e-6, 1e-9, 1e-10])
def test_no_pulse_is_too_short(scheme, width):
    """As the impulse of a blow: a triangle of any width that times can tell apart."""
    times = [0.0, 0.0533, 0.0533 + width / 2, 0.0533 + width]
    model = slider((times, [[0, 0, 0], [0, 0, 0], [2 / width, 0, 0], [0, 0, 0]]))
    motion = lissom.simulate(model, 0.2, dt=0.01, **scheme)
    # Steps of that width are rounded as the time is.
    assert motion.v[-1, 0] == pytest.approx(1.0, rel=1e-6 + 4 * np.spacing(0.05) / width)


@pytest.mark.parametrize("width", [1e-8, 1e-9, 1e-10])
@pytest.mark.parametrize("method", FIXED)
def test_steps_after_a_steep_edge_do_not_go_on_with_its_slope(method, width):
    """A plate that turns in its plane is pushed at an edge: its centre of mass moves like a particle."""
    centre, force, start = np.array([0.1, 0.2, 0.05]), np.array([3.0, 2.0, 1.0]), 0.30234
    plate = Link("plate", joint=lissom.Planar((0, 0, 1)), body=Body(1.0, centre=centre, inertia=(0.05,) * 3))
    push = lissom.Load(force=([0, start, start + width], [0 * force, 0 * force, force]), link="plate")
    robot = Robot([plate], loads=[push], gravity=(0, 0, 0))
    motion = lissom.simulate(robot, 0.6, method=method, dt=5e-3, q0=[0.1] * 3, v0=[0.3] * 3)
    assert motion.success, motion.message
    places = robot.pose(motion.q, link="plate") @ np.append(centre, 1)
    arm = robot.pose(motion.q[0], link="plate")[:3, :3] @ centre
    velocity = np.add([0.3, 0.3, 0], np.cross([0, 0, 0.3], arm))
    pushed = np.maximum(motion.t - start, 0)[:, None]
    expected = places[0, :3] + velocity * motion.t[:, None] + force * [1, 1, 0] * pushed**2 / 2
    assert_allclose(places[:, :3], expected, atol=2e-4)


@pytest.mark.parametrize("method", [*SCHEMES, {"method": "radau"}])
def test_jumps_next_to_each_other_are_seen_one_by_one(method):
    """From a plateau to the next one in little more than what a step takes for one time."""
    dt, start = 0.0123, -0.96187
    first, second = start + 1.2434e-14, start + 1.23125e-11
    times = [
        -0.9631,
        -0.9631 + 1.5e-16,
        start,
        start + 2e-16,
        first,
        second,
        second + dt,
        second + dt + 3e-13,
    ]
    times = np.maximum.accumulate(times)
    heights = [0.0, 0.5, 0.5, 0.0, 0.0, 1.0, 1.0, 0.0]
    keep = np.append(np.diff(times) > 0, True)
    model = slider(
        (times[keep], [[height, 0, 0] for height, kept in zip(heights, keep, strict=True) if kept])
    )
    motion = lissom.simulate(model, -1.0 + 35 * dt, t0=-1.0, dt=dt, **method)
    exact = np.trapezoid(np.array(heights)[keep], times[keep])
    assert motion.v[-1, 0] == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("method", ["newmark", "hht", "generalised_alpha"])
def test_the_step_after_a_jump_has_two_stages(method):
    """Those of Alexander (1977), and after them the method begins anew."""
    p, k, c, h = newmark.PRESETS[method], 30.0, 4.0, 0.05
    jump = 3 * h
    table = ([0.0, jump, jump + 1e-13, 9.0], [[2.0, 0, 0], [2.0, 0, 0], [-5.0, 0, 0], [-5.0, 0, 0]])
    model = slider(table, stiffness=k, damping=c)
    found = lissom.simulate(model, 6 * h, method=method, dt=h, q0=[0.1], v0=[0.3])
    at = np.searchsorted(found.t, jump + 1e-12) - 1
    q, v = found.q[at, 0], found.v[at, 0]
    assert np.diff(found.t[at : at + 3]) == pytest.approx(h)

    # y' = f(y): y1 = y0 + g h f(y1), y2 = y0 + h ((1 - g) f(y1) + g f(y2)), and g a root of 2 g^2 - 4 g + 1.
    g = min(np.roots([2.0, -4.0, 1.0]))
    of, constant = np.array([[0.0, 1.0], [-k, -c]]), np.array([0.0, -5.0])
    implicit, start = np.eye(2) - g * h * of, np.array([q, v])
    first = np.linalg.solve(implicit, start + g * h * constant)
    second = np.linalg.solve(implicit, start + h * (1 - g) * (of @ first + constant) + g * h * constant)
    assert_allclose([found.q[at + 1, 0], found.v[at + 1, 0]], second, rtol=1e-7)

    # Algorithmic accelerations are ahead as if accelerations had changed at that rate before.
    q, v = second
    a, a_first = (-5.0 - k * q - c * v for q, v in (second, first))
    start = a + (p.alpha_m - p.alpha_f) * (a - a_first) / (1 - g)

    def equations(x):
        end = ((1 - p.alpha_f) * x[2] + p.alpha_f * a - p.alpha_m * start) / (1 - p.alpha_m)
        return np.array(
            [
                x[0] - q - h * v - h**2 * ((0.5 - p.beta) * start + p.beta * end),
                x[1] - v - h * ((1 - p.gamma) * start + p.gamma * end),
                x[2] + k * x[0] + c * x[1] + 5.0,
            ]
        )

    expected = newmark.root(equations, np.array([q, v, a]))
    assert_allclose([found.q[at + 2, 0], found.v[at + 2, 0]], expected[:2], rtol=1e-7)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_pulses_within_steps_keep_their_impulse(scheme):
    """Straight lines are integrated exactly, wherever their corners are in the steps."""
    for corner in (0.0213, 0.021, 0.0215, 0.02098):
        times = [0.0, corner, corner + 1e-4, corner + 2e-4, corner + 9e-4]
        model = slider((times, [[0, 0, 0], [0, 0, 0], [900, 0, 0], [-100, 0, 0], [0, 0, 0]]))
        for dt in (1e-2, 1e-3):
            motion = lissom.simulate(model, 0.1, dt=dt, **scheme)
            assert motion.v[-1, 0] == pytest.approx(0.05, rel=1e-9)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_mechanism_follows_a_load_of_corners(scheme):
    """A load with several corners in every step, on a mechanism with a loop."""

    def bar(name, length, **options):
        return Link(name, joint=Revolute((0, 1, 0)), body=Body(0.5, centre=(length / 2, 0, 0)), **options)

    times = np.arange(0, 0.2, 1.3e-3)
    forces = np.random.default_rng(0).normal(0, 20, (times.size, 3))
    links = [
        bar("crank", 0.2),
        bar("rod", 0.5, parent="crank", position=(0.2, 0, 0)),
        bar("rocker", 0.4, position=(0.4, 0, 0)),
    ]
    pin = lissom.Loop(("rod", None, (0.5, 0, 0)), ("rocker", None, (0.4, 0, 0)), Revolute((0, 1, 0)))
    robot = Robot(links, loops=[pin], loads=[lissom.Load(link="rod", force=(times, forces))])
    start = lissom.simulate(robot, 1e-6, q0=[-1.2, 0.9, -1.7]).q[-1]
    exact = lissom.simulate(robot, 0.15, q0=start, method="dop853", rtol=1e-10, atol=1e-12)
    motion = lissom.simulate(robot, 0.15, q0=start, dt=5e-3, **scheme)
    assert exact.success
    assert motion.success
    assert_allclose(motion.q[-1], exact.q[-1], atol=4e-3)


@pytest.mark.parametrize("method", FIXED)
def test_jumps_of_commands_are_seen_by_runs_step_by_step(method):
    table = ([0.0, 0.02, 0.02 + 1e-13, 0.0434, 0.0434 + 1e-13], [0.0, 0.0, 3.0, 3.0, 0.0])
    link = Link("slider", body=Body(1.0), joint=Prismatic(ALONG_X, stiffness=100.0))
    model = Robot([link], actuators=[lissom.Motor("slider", torque=table)], gravity=(0, 0, 0))
    whole = lissom.simulate(model, 0.1, method=method)
    stepped = lissom.Simulation(model, dt=0.01, method=method)
    for k in range(10):
        assert stepped.step() == "finished"
        # Saved at the jump as elsewhere.
        stepped = pickle.loads(pickle.dumps(stepped)) if k % 2 else copy.copy(stepped)
    assert_allclose(stepped.q, whole.q[-1], rtol=1e-12)
    exact = lissom.simulate(model, 0.1, method="dop853", rtol=1e-11, atol=1e-13)
    fine = lissom.simulate(model, 0.1, method=method, dt=1e-4)
    assert_allclose(fine.q[-1], exact.q[-1], rtol=1e-5)
    with pytest.raises(ValueError, match=r"by a table that jumps, .* expected edges that take some time"):
        lissom.sensitivity(model, 0.1, ["link[0].joint.stiffness"], method=method)


def test_a_beam_feels_a_short_pulse():
    segment = lissom.Segment(0.5, 0.01, 1e7, 4e6, 1000.0, {"bend_y": 3}, retardation_time=1e-3)
    times, values = pulse(5.0, 0.0203, 1.5e-3)
    load = lissom.Load(force=(times, [[0, 0, x] for x, _, _ in values]))
    rod = lissom.Rod([segment], loads=[load], gravity=(0, 0, 0))
    found, exact = (
        lissom.simulate(rod, 0.1, method=method, dt=0.002, t_eval=np.linspace(0, 0.1, 51))
        for method in ("newmark", "radau")
    )
    tips = [np.array([rod.pose(q, 0.5)[2, 3] for q in motion.q]) for motion in (found, exact)]
    assert abs(tips[0] - tips[1]).max() < 0.05 * abs(tips[1]).max()


def test_tables_of_many_times_do_not_make_many_steps():
    times = np.linspace(0, 1, 100_001)
    zero = np.zeros_like(times)
    rng = np.random.default_rng(2)
    for force, most in ((np.sin(20 * times), 1001), (rng.standard_normal(times.size), 9001)):
        motion = lissom.simulate(slider((times, np.stack([force, zero, zero], 1))), 1.0, dt=1e-3)
        assert motion.success
        assert len(motion.t) <= most
    hit = 1000 * np.exp(-(((times - 0.50037) / 1e-4) ** 2))
    motion = lissom.simulate(slider((times, np.stack([hit, zero, zero], 1))), 1.0, dt=1e-3)
    assert len(motion.t) < 1040
    assert motion.v[-1, 0] == pytest.approx(1000 * 1e-4 * np.sqrt(np.pi), rel=0.03)


@pytest.mark.parametrize("method", FIXED)
def test_commands_in_tables_lose_nothing_either(method):
    motor = lissom.Motor(
        "slider", torque=([0.0, 0.0213, 0.0214, 0.0231, 0.0232], [0.0, 0.0, 300.0, 300.0, 0.0])
    )
    link = Link("slider", body=Body(1.0), joint=Prismatic(ALONG_X))
    motion = lissom.simulate(Robot([link], actuators=[motor], gravity=(0, 0, 0)), 0.1, method=method)
    assert motion.v[-1, 0] == pytest.approx(300 * 1.8e-3, rel=1e-3)


@pytest.mark.parametrize("method", FIXED)
def test_runs_step_by_step_and_many_runs_end_steps_at_the_same_corners(method):
    model = slider(pulse(1000.0, 0.0337, 5.7e-3), stiffness=100.0)
    whole = lissom.simulate(model, 0.1, method=method)
    stepped = lissom.Simulation(model, dt=0.01, method=method)
    for _ in range(10):
        assert stepped.step() == "finished"
    assert_allclose(stepped.q, whole.q[-1], rtol=1e-12)
    many = lissom.simulate_many(model, 0.1, q0=[[0.0], [0.1]], method=method)
    assert_allclose(many.t, whole.t)
    assert_allclose(many.q[0], whole.q)
    others = [model, slider(pulse(1000.0, 0.0444, 5e-3))]
    # Of models with different tables, the times that all share: those without corners.
    many = lissom.simulate_many(others, 0.1, method=method)
    assert_allclose(many.t, 0.01 * np.arange(11))
    for row, other in enumerate(others):
        assert_allclose(many.q[row], lissom.simulate(other, 0.1, method=method, t_eval=many.t).q)
    assert lissom.simulate_many(others, 0.1, method=method, t_eval=[0.1]).success.all()


@pytest.mark.parametrize("method", FIXED)
def test_derivatives_know_the_corners(method):
    model = slider(pulse(30.0, 0.0337, 5.7e-3), stiffness=100.0)
    name = "link[0].joint.stiffness"
    found = lissom.sensitivity(model, 0.2, [name], method=method, rtol=1e-13, atol=1e-13)
    ends = []
    for change in (-1e-2, 1e-2):
        moved = lissom.analysis.parameters.model_with(model, {name: 100.0 + change})
        ends.append(lissom.simulate(moved, 0.2, method=method, rtol=1e-13, atol=1e-13).q)
    difference = (ends[1] - ends[0]) / 2e-2
    assert found.q.shape == difference.shape
    assert_allclose(found.dq[..., 0], difference, atol=1e-6 * abs(difference).max())


# ------------------------------------------------------------------------------------ prescribed motions

SPEED = 0.4
START = (([0.0, 2.0], [0.0, 2 * SPEED], "linear"), 0.0)
LATER = (([0.0, 0.1234, 2.1234], [0.0, 0.0, 2 * SPEED], "linear"), 0.1234)


def towed(motion, *, stiffness=40.0):
    """A particle of one kilogram on a spring behind a slider that moves as prescribed."""
    return Robot(
        [
            Link("clamp", body=Body(0.3), joint=Prismatic(ALONG_X, motion=motion)),
            Link("mass", parent="clamp", body=Body(1.0), joint=Prismatic(ALONG_X, stiffness=stiffness)),
        ],
        gravity=(0, 0, 0),
    )


@pytest.mark.parametrize("method", EVERY)
@pytest.mark.parametrize(("motion", "start"), [START, LATER])
def test_a_clamp_that_starts_at_once(method, motion, start):
    """A mass on a spring stays behind: its coordinate is -v / w sin(w t)."""
    robot, w = towed(motion), np.sqrt(40.0)
    found = lissom.simulate(robot, 1.0, method=method, dt=2e-3)
    assert found.success
    t = found.t - start
    moving = t > 0
    assert_allclose(found.q[:, 0], -SPEED / w * np.sin(w * t * moving), atol=5e-5)
    assert_allclose(found.v[moving, 0], -SPEED * np.cos(w * t[moving]), atol=5e-4)
    assert_allclose(found.v[~moving, 0], 0, atol=1e-12)
    # The drive gives the clamp its momentum, and the spring does the rest.
    balance = found.balance
    # States between long steps are those of polynomials.
    assert balance.drift < (1e-2 if method in ("dop853", "auto") else 1e-4)
    assert balance.work[-1] == pytest.approx(
        0.15 * SPEED**2 + 1.0 * SPEED**2 * (1 - np.cos(w * t[-1])), rel=2e-3
    )


@pytest.mark.parametrize("method", METHODS)
def test_a_pendulum_whose_pivot_starts_at_once(method):
    """The impulse passes through the pivot: L dtheta/dt = -v, and the energy of the swing follows."""
    length = 0.7
    links = [
        Link("pivot", body=Body(0.1), joint=Prismatic(ALONG_X, motion=LATER[0])),
        Link("bob", parent="pivot", body=Body(2.0, centre=(0, 0, -length)), joint=Revolute((0, 1, 0))),
    ]
    robot = Robot(links)
    found = lissom.simulate(robot, 0.1234 + 1e-3, method=method, dt=1e-4)
    # About +y, an angle moves the bob towards -x.
    assert found.v[-1, 0] == pytest.approx(SPEED / length, rel=1e-4)
    longer = lissom.simulate(robot, 1.0, method=method, dt=1e-3)
    height = 0.5 * SPEED**2 / 9.81
    assert longer.q[:, 0].max() == pytest.approx(np.arccos(1 - height / length), rel=1e-4)
    assert longer.balance.drift < 1e-3


@pytest.mark.parametrize("method", ["newmark", "generalised_alpha", "radau", "dop853"])
def test_an_elastic_chain_with_several_corners(method):
    """By modes of the chain relative to the clamp: each jump of its velocity is an impulse."""
    n, k = 4, 90.0
    times, values = [0.05, 0.3317, 0.47, 0.8], [0.0, 0.1, 0.1, 0.02]
    links = [Link("clamp", body=Body(0.2), joint=Prismatic(ALONG_X, motion=(times, values, "linear")))]
    for i in range(n):
        links.append(
            Link(f"{i}", parent=links[-1].name, body=Body(0.5), joint=Prismatic(ALONG_X, stiffness=k))
        )
    robot = Robot(links, gravity=(0, 0, 0))
    found = lissom.simulate(robot, 1.2, method=method, dt=5e-4, t_eval=np.linspace(0, 1.2, 121))
    stiffness = 2 * k * np.eye(n) - k * np.eye(n, k=1) - k * np.eye(n, k=-1)
    stiffness[-1, -1] = k
    square, shapes = np.linalg.eigh(stiffness / 0.5)
    w = np.sqrt(square)
    jumps = np.diff(np.append(0, np.append(np.diff(values) / np.diff(times), 0)))
    relative = np.zeros((121, n))
    for t, jump in zip(times, jumps, strict=True):
        since = np.maximum(found.t - t, 0)
        modal = -jump * (shapes.T @ np.ones(n)) * np.sin(w * since[:, None]) / w
        relative += modal @ shapes.T
    coordinates = np.diff(np.insert(relative, 0, 0, axis=1), axis=1)
    assert_allclose(found.q, coordinates, atol=2e-4)
    assert found.balance.drift < 2e-3


@pytest.mark.parametrize("method", METHODS)
def test_a_rod_whose_base_starts_at_once_stays_behind(method):
    """Just after the start the rod has not moved yet."""
    segment = lissom.Segment(0.5, 0.01, 1e6, 4e5, 1000.0, {"bend_y": 4, "bend_z": 2}, retardation_time=1e-3)
    for table in (
        ([0.0, 1.0], [[0, 0, 0], [0, 0.1, 0.3]], "linear"),
        ([0.0, 1e-3, 1.0], [[0, 0, 0], [0, 0, 0], [0, 0.1, 0.3]], "linear"),
    ):
        start = table[0][-2]
        rod = lissom.Rod([segment], gravity=(0, 0, 0), base_motion=BaseMotion(translation=table))
        found = lissom.simulate(rod, start + 4e-4, method=method, dt=1e-4)
        velocity = rod.velocity(found.q[-1], found.v[-1], 0.4, t=found.t[-1])[3:]
        assert np.abs(velocity).max() < 0.3 * np.linalg.norm((0.1, 0.3))
        assert found.balance.drift < 1e-2
        # Half of the impulse of what prescribes the velocity, times that velocity.
        assert found.balance.work[-1] > 0


@pytest.mark.parametrize("method", ["newmark", "radau", "rk45"])
def test_a_base_that_turns_at_once(method):
    """A body free to turn about the same axis keeps its orientation."""
    spin = BaseMotion(axis=(0, 0, 1), angle=([0.02, 1.02], [0.0, 3.0], "linear"))
    body = Body(1.0, inertia=(0.1, 0.1, 0.2))
    robot = Robot([Link("rotor", body=body, joint=Revolute((0, 0, 1)))], base_motion=spin, gravity=(0, 0, 0))
    found = lissom.simulate(robot, 0.5, method=method)
    assert_allclose(found.q[:, 0], -3.0 * np.maximum(found.t - 0.02, 0), atol=1e-9)
    quaternions = ([0.02, 1.02], [[1, 0, 0, 0], [np.cos(0.5), 0, 0, np.sin(0.5)]], "linear")
    robot = Robot(robot.links, base_motion=BaseMotion(rotation=quaternions), gravity=(0, 0, 0))
    found = lissom.simulate(robot, 1.0, method=method, t_eval=[1.0], dt=1e-3)
    x = 0.98
    turn = 2 * np.arctan2(x * np.sin(0.5), 1 - x + x * np.cos(0.5))
    assert found.q[0, 0] == pytest.approx(-turn, abs=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_a_run_that_stops_at_a_corner_goes_on_from_there(method):
    robot = towed(LATER[0])
    # The first run ends where the clamp has not started yet, the second one begins with the start.
    first = lissom.simulate(robot, 0.1234, method=method, dt=1e-3)
    second = lissom.simulate(robot, 0.5, t0=0.1234, q0=first.q[-1], v0=first.v[-1], method=method, dt=1e-3)
    w = np.sqrt(40.0)
    assert second.q[-1, 0] == pytest.approx(-SPEED / w * np.sin(w * (0.5 - 0.1234)), abs=2e-5)
    stepped = lissom.Simulation(robot, dt=1e-3, method=method)
    for _ in range(500):
        assert stepped.step() == "finished"
    assert stepped.q[0] == pytest.approx(second.q[-1, 0], abs=2e-5)


def test_holds_are_held_and_velocities_are_those_of_the_lines():
    table = ([0.0, 1.0, 2.0, 3.0], [0.0, 0.1, 0.1, 0.0])
    for kind, least in (("linear", 0.1), ("monotone", 0.1), ("cubic", 0.0)):
        robot = towed((*table, kind))
        held = [robot.pose([0.0], link="clamp", t=t)[0, 3] for t in np.linspace(1, 2, 21)]
        assert least - 1e-12 <= min(held)
        assert max(held) <= 0.1 + 1e-12 or kind == "cubic"
        assert robot.links[0].joint.motion[2] == kind
        joint = robot.links[0].joint
        for copied in (pickle.loads(pickle.dumps(joint)), copy.deepcopy(joint)):
            assert copied.motion[2] == kind
    robot = towed((*table, "linear"))
    speed = [robot.velocity([0.0], [0.0], link="clamp", t=t)[3] for t in (-1, 0, 0.5, 1, 1.5, 2, 2.5, 3, 9)]
    assert_allclose(speed, [0, 0, 0.1, 0.1, 0, 0, -0.1, -0.1, 0], atol=1e-15)


def test_monotone_tables_are_those_of_scipy():
    interpolate = pytest.importorskip("scipy.interpolate")
    rng = np.random.default_rng(5)
    for _ in range(5):
        times = np.cumsum(rng.uniform(0.1, 2, 9))
        values = np.round(rng.standard_normal(9), 1)
        pchip = interpolate.PchipInterpolator(times, values)
        robot = towed((times, values, "monotone"))
        for t in rng.uniform(times[0], times[-1], 20):
            assert robot.pose([0.0], link="clamp", t=t)[0, 3] == pytest.approx(pchip(t), abs=1e-14)
            speed = robot.velocity([0.0], [0.0], link="clamp", t=t)[3]
            assert speed == pytest.approx(pchip(t, 1), abs=1e-12)
            acceleration = robot.acceleration([0.0], [0.0], [0.0], link="clamp", t=t)[3]
            assert acceleration == pytest.approx(pchip(t, 2), abs=1e-10)


@pytest.mark.filterwarnings("ignore:A prescribed motion lasts only a few steps")
@pytest.mark.parametrize("method", ["newmark", "generalised_alpha", "hht", "radau", "rk45"])
@pytest.mark.parametrize("dt", [1e-2, 7e-3, 1e-3])
@pytest.mark.parametrize("times", [(0.05, 0.15), (0.0503, 0.1212), (0.05, 0.06)], ids=str)
def test_what_nothing_holds_does_not_move_with_a_carriage(method, dt, times):
    """A body on a rail along a carriage stays where it is. The acceleration of a ramp jumps at its ends."""
    start, end = times
    ramp = ([0.0, start, end, 0.2], [0.0, 0.0, 0.1, 0.1], "monotone")
    robot = towed(ramp, stiffness=0.0)
    run = lissom.simulate(robot, 0.2, method=method, dt=dt)
    at = robot.pose(run.q, link="mass", t=run.t)[:, 0, 3]
    rest = robot.velocity(run.q[-1], run.v[-1], link="mass", t=0.2)[3]
    # Within a piece the acceleration is a straight line, of which steps of order two miss this; the alpha
    # methods see means of accelerations, whose impulse has an error of that order as well.
    largest = 6.0 * 0.1 / (end - start) ** 2
    step = min(dt, end - start)
    order_two = 0.0 if method in ("radau", "rk45") else largest * step**2
    assert abs(rest) <= (1e-9 if method == "newmark" else largest * step**2 / (end - start) + 1e-6)
    assert abs(at).max() <= order_two + abs(rest) * (0.2 - start) + 2e-6
    # Two percent of the way are doubted, a little more where what is left is a velocity.
    assert run.doubt or abs(at).max() < 0.03 * 0.1


@pytest.mark.filterwarnings("ignore:A prescribed motion lasts only a few steps")
@pytest.mark.parametrize("dt", [1e-2, 2e-3, 1e-3])
def test_a_bump_of_many_times_within_a_step_leaves_no_velocity(dt):
    times = np.r_[0, np.linspace(0.0203, 0.0283, 9), 0.1, 0.2]
    values = np.r_[0, [0, 1, 4, 8, 10, 8, 4, 1, 0], 0, 0] * 1e-3
    robot = towed((times, values, "monotone"), stiffness=0.0)
    run = lissom.simulate(robot, 0.2, dt=dt)
    at = robot.pose(run.q, link="mass", t=run.t)[:, 0, 3]
    assert abs(at).max() < 3e-3
    assert abs(run.v[-1, 0]) < 1e-10


def test_a_rod_on_a_base_that_ramps_is_that_of_radau():
    wire = lissom.Segment(0.3, 2e-3, 1e9, 4e8, 1200.0, {"bend_y": 2}, retardation_time=1e-3)
    ramp = lissom.BaseMotion(
        translation=([0.0, 0.05, 0.15, 0.4], [[0] * 3, [0] * 3, [0, 0, 0.1], [0, 0, 0.1]], "monotone")
    )
    rod = lissom.Rod([wire], base_motion=ramp)
    exact = lissom.simulate(rod, 0.4, method="radau", rtol=1e-9, atol=1e-12).q[-1]
    off = [abs(lissom.simulate(rod, 0.4, dt=dt).q[-1] - exact).max() for dt in (2e-3, 1e-3, 5e-4)]
    assert 3.2 < off[0] / off[1] < 5.0
    assert 3.2 < off[1] / off[2] < 5.0


def test_what_makes_no_sense_is_refused():
    table = ([0.0, 1.0], [0.0, 1.0])
    with pytest.raises(ValueError, match=r'motion\.interpolation: got "cubical", expected one of'):
        towed((*table, "cubical"))
    with pytest.raises(ValueError, match=r"force\.interpolation: got monotone, expected .*linear"):
        lissom.Load(force=([0, 1], np.zeros((2, 3)), "monotone"))
    assert lissom.Load(force=([0, 1], np.zeros((2, 3)), "linear")).force[2] == "linear"
    with pytest.raises(ValueError, match=r"t_span\[1\]|t_end"):
        lissom.simulate(towed((*table, "monotone")), 2.0)
    assert lissom.simulate(towed((*table, "linear")), 2.0).success
    with pytest.raises(ValueError, match="linear table"):
        lissom.sensitivity(towed((*table, "linear")), 0.5, ["link[1].joint.stiffness"])
    with pytest.raises(ValueError, match=r'monotone table, expected .* or method "radau"'):
        lissom.sensitivity(towed((*table, "monotone")), 0.5, ["link[1].joint.stiffness"])


SCENE = """
version = 1
[[link]]
name = "clamp"
joint = {{ type = "prismatic", axis = [1, 0, 0], motion = {motion} }}
body = {{ mass = 0.3 }}
[[link]]
name = "mass"
parent = "clamp"
joint = {{ type = "prismatic", axis = [1, 0, 0], stiffness = 40 }}
body = {{ mass = 1 }}
[scene]
gravity = [0, 0, 0]
[simulation]
t_end = 0.5
"""


def test_scenes_name_the_interpolation():
    scene = lissom.Scene.loads(
        SCENE.format(motion='{ times = [0, 2], values = [0, 0.8], interpolation = "linear" }')
    )
    assert scene.model.links[0].joint.motion[2] == "linear"
    found = lissom.simulate(scene.model, 0.5, dt=1e-3)
    w = np.sqrt(40.0)
    assert found.q[-1, 0] == pytest.approx(-SPEED / w * np.sin(w * 0.5), abs=1e-5)
    with pytest.raises(lissom.SceneError, match="only times and values are interpolated"):
        lissom.Scene.loads(SCENE.format(motion='{ amplitude = 1, frequency = 1, interpolation = "linear" }'))
    with pytest.raises(lissom.SceneError, match="interpolation"):
        lissom.Scene.loads(SCENE.format(motion='{ times = [0, 2], values = [0, 1], interpolation = "x" }'))


# ------------------------------------------------------------------------------------- starts from rest


def quintic(s):
    return s**3 * (10 - 15 * s + 6 * s**2)


STARTS = {
    "quintic": quintic,
    "cycloid": lambda s: s - np.sin(2 * np.pi * s) / (2 * np.pi),
    "t^4": lambda s: s**4,
    "t^5": lambda s: s**5,
}


@pytest.mark.parametrize("name", STARTS)
@pytest.mark.parametrize("duration", [0.05, 0.5, 500.0])
def test_motions_may_start_with_zero_acceleration(name, duration):
    """In seconds, and in milliseconds."""

    def move(t):
        return 0.2 * STARTS[name](min(max(t / duration, 0.0), 1.0))

    scale = (duration / 0.5) ** 2
    robot = towed(move, stiffness=40.0 / scale)
    times = np.linspace(0, 0.9 * duration, 181)
    found = lissom.simulate(robot, 0.9 * duration, dt=duration / 200, t_eval=times)
    table = np.linspace(0, duration, 400)
    splined = towed((table, [move(t) for t in table]), stiffness=40.0 / scale)
    expected = lissom.simulate(splined, 0.9 * duration, dt=duration / 200, t_eval=times)
    assert found.success
    assert_allclose(found.q, expected.q, atol=1e-4)
