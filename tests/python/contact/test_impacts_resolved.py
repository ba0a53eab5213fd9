"""Steps of fixed size that resolve impacts: against exact rebounds, and against Radau's method by itself."""

import copy
import pickle
import warnings

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import lissom
from lissom import Ball, Body, Contact, Free, HalfSpace, Link, Prismatic, Robot, Segment

G = 9.81
FLOOR = HalfSpace((0, 0, 0), (0, 0, 1))
RESOLVED = lissom.methods.Newmark(impacts="resolved")
STOPPED = lissom.methods.Newmark(impacts="stopped")


def work(stats):
    return stats.nfev + 5 * stats.njev


def ball(stiffness, dissipation=0.0, mass=1.0, unit=1.0):
    """A ball above a floor, in metres over `unit`."""
    links = [Link("ball", joint=Prismatic((0, 0, 1)), body=Body(mass))]
    contact = Contact(Ball("ball", 0.1 / unit), FLOOR, stiffness=stiffness, dissipation=dissipation * unit)
    return Robot(links, contacts=[contact], gravity=(0, 0, -G / unit))


@pytest.mark.parametrize(
    ("stiffness", "height", "dt"),
    [
        *[(1e5, 10.0, 1e-2), (1e8, 1.0, 1e-2), (1e8, 1.0, 3e-3), (1e10, 0.1, 1e-2), (1e10, 0.1, 1e-3)],
        # Impacts of two to nine steps.
        *[(2e4, 1.0, 1e-2), (1e4, 1.0, 1e-2), (1e5, 1.0, 1.2e-3)],
    ],
)
def test_an_ideal_ball_returns(stiffness, height, dt):
    # Centres fall by the height until the surfaces touch; what is pressed comes back.
    robot = ball(stiffness)
    fall = np.sqrt(2 * height / G)
    result = lissom.simulate(
        robot, 2.3 * fall + np.pi / np.sqrt(stiffness), dt=dt, q0=[0.1 + height], method=RESOLVED
    )
    top = result.q[result.t > 1.2 * fall, 0].max() - 0.1
    # The top lies within half a step of one of the times.
    lost = G * dt**2 / 8
    assert height * (1 - 2e-4) - lost < top < height * (1 + 2e-4)
    energy = np.array([robot.energy(q, v).total for q, v in zip(result.q, result.v, strict=True)])
    assert np.all(np.diff(energy) < 2e-4 * G * height)
    assert result.doubt is None
    assert result.balance.drift < 2e-4 + lost / height


def test_an_inelastic_ball_returns_as_its_law_says():
    robot = ball(1e6, dissipation=0.1)
    result = lissom.simulate(robot, 1.0, dt=1e-2, q0=[1.1], method=RESOLVED)
    fine = lissom.simulate(robot, 1.0, q0=[1.1], method="radau", rtol=1e-10, atol=1e-12, t_eval=result.t)
    assert_allclose(result.q, fine.q, atol=2e-4)
    # What the impact takes out is in the balance.
    assert_allclose(result.balance.dissipated[-1], fine.balance.dissipated[-1], rtol=2e-3)
    assert result.balance.drift < 2e-3


@pytest.mark.parametrize("dt", [1e-3, 3e-3, 1e-2, 3e-2])
@pytest.mark.parametrize(("stiffness", "dissipation"), [(1e4, 0.1), (1e4, 0.3), (1e5, 1.0), (1e6, 0.1)])
def test_a_rebound_has_the_speed_of_hunt_and_crossley(stiffness, dissipation, dt):
    # m x'' = m g - k x (1 + c x') in the overlap, for a mass of 1 kg.
    height = 1.0
    speed = np.sqrt(2 * G * height)

    def fall(_t, state):
        return [state[1], G - stiffness * state[0] * max(0.0, 1 + dissipation * state[1])]

    def leave(_t, state):
        return state[0]

    leave.terminal, leave.direction = True, -1
    solved = solve_ivp(fall, (0, 1), [0, speed], events=leave, rtol=1e-10, atol=1e-14, max_step=1e-3)
    robot = ball(stiffness, dissipation)
    result = lissom.simulate(
        robot, np.sqrt(2 * height / G) + solved.t[-1] + 3 * dt, dt=dt, q0=[0.1 + height], method=RESOLVED
    )
    energy = robot.energy(result.q[-1], result.v[-1]).total - G * 0.1
    assert_allclose(energy / (G * height), (solved.y[1, -1] / speed) ** 2, rtol=5e-3, atol=4e-3)


@pytest.mark.parametrize("stiffness", [1e5, 4e3, 1e3])
def test_balls_that_meet_in_mid_air_keep_momentum_and_energy(stiffness):
    links = [
        Link(f"ball {i}", joint=Free(), body=Body(1.0 + i, inertia=(0.01,) * 3), position=(i, 0.05 * i, 0))
        for i in range(2)
    ]
    meet = Contact(Ball("ball 0", 0.1), Ball("ball 1", 0.1), stiffness=stiffness, dissipation=0.0)
    robot = Robot(links, contacts=[meet], gravity=(0, 0, 0))
    result = lissom.simulate(robot, 1.0, dt=1e-2, v0=[2.0, *[0.0] * 11], method=RESOLVED)
    fine = lissom.simulate(robot, 1.0, v0=[2.0, *[0.0] * 11], method="radau", rtol=1e-9, atol=1e-12)
    assert fine.v[-1, 6] > 0.5
    assert_allclose(result.v[-1], fine.v[-1], atol=3e-4)
    assert_allclose(result.v[-1, [0, 1, 2]] + 2 * result.v[-1, [6, 7, 8]], [2, 0, 0], atol=1e-9)


@pytest.mark.parametrize("stiffness", [1e4, 5e3])
def test_a_platform_strikes_a_ball(stiffness):
    """A heavy platform that moves as prescribed passes twice its speed on to a ball at rest."""
    speed = 2.0
    platform = Link("platform", joint=Prismatic((1, 0, 0), motion=lambda t: speed * t - 0.5))
    links = [platform, Link("ball", joint=Prismatic((1, 0, 0)), body=Body(1.0))]
    meet = Contact(Ball("ball", 0.1), Ball("platform", 0.1), stiffness=stiffness, dissipation=0.0)
    robot = Robot(links, contacts=[meet], gravity=(0, 0, 0))
    result = lissom.simulate(robot, 0.5, dt=1e-2, method=RESOLVED)
    assert_allclose(result.v[-1], 2 * speed, rtol=1e-3)


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
        stopped = lissom.simulate(row, 2.0, dt=1e-2, q0=q0, v0=v0, method=STOPPED)
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


def falling_rod(height, **contact):
    """A soft rod above a floor that falls flat, and the energy of its fall. Its impact takes 1.8 ms."""
    segment = Segment(
        0.3, 0.01, 1e6, poisson_ratio=0.45, density=1000, modes={"bend_y": 2}, retardation_time=0.01
    )
    rod = Link("rod", joint=Free(), rod=[segment], position=(0, 0, 0.01 + height))
    robot = Robot([rod], contacts=[Contact("rod", FLOOR, **contact)])
    return robot, 1000 * np.pi * 0.01**2 * 0.3 * G * height


def lost_by(robot, fallen, **options):
    run = lissom.simulate(robot, 0.15, **options)
    assert run.success, run.message
    energy = np.array([robot.energy(q, v).total for q, v in zip(run.q, run.v, strict=True)]) / fallen
    return energy[0] - energy[-1], np.diff(energy).max(), run


@pytest.mark.parametrize("height", np.linspace(0.05, 0.0625, 8))
@pytest.mark.parametrize("dt", [2e-3, 5e-3])
def test_a_soft_rod_that_falls_flat_rebounds(dt, height):
    """Steps that are too long for its impact are made in parts, wherever in a step it begins."""
    robot, fallen = falling_rod(height)
    lost, gained, run = lost_by(robot, fallen, dt=dt)
    exact, _, _ = lost_by(robot, fallen, method="radau", rtol=1e-7, atol=1e-10)
    assert 0.6 < exact < 0.7
    assert_allclose(lost, exact, atol=0.1)
    assert gained < 0.01
    assert run.stats.newton_iterations < 3 * 0.15 / dt + 120
    with pytest.warns(lissom.AccuracyWarning, match="suppress rebounds"):
        stopped, _, _ = lost_by(robot, fallen, dt=dt, method=STOPPED)
    assert_allclose(stopped, 1.0, atol=0.01)


@pytest.mark.filterwarnings(
    "ignore:Between t = .* the energy rises by [123]\\.[0-9] %:lissom.AccuracyWarning"
)
@pytest.mark.parametrize("height", np.linspace(0.05, 0.0625, 8))
@pytest.mark.parametrize("dt", [1e-3, 2e-3, 5e-3])
def test_a_soft_rod_keeps_its_energy_in_an_ideal_impact(dt, height):
    lost, _, _ = lost_by(*falling_rod(height, dissipation=0.0), dt=dt)
    assert_allclose(lost, 0.0, atol=0.08)


def test_a_followed_impact_goes_on_from_a_saved_state():
    robot, _ = falling_rod(0.06)
    whole = lissom.Simulation(robot, dt=1e-3)
    other = copy.copy(whole)
    for _ in range(150):
        whole.step()
        # Within the impact, too.
        other = pickle.loads(pickle.dumps(other))
        other.step()
        assert np.array_equal(other.q, whole.q)
        assert np.array_equal(other.v, whole.v)
    assert whole.v[2] > 0.2


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


def test_work_is_bounded_and_what_is_left_is_doubted():
    """Twenty balls bounce at different times: impacts may take a fixed work, and half of that of all else."""
    number = 20
    links = [Link(f"ball {i}", joint=Prismatic((0, 0, 1)), body=Body(1.0)) for i in range(number)]
    contacts = [Contact(Ball(link.name, 0.1), FLOOR, stiffness=1e8, dissipation=0.0) for link in links]
    robot = Robot(links, contacts=contacts)
    start = {"q0": 0.1 + np.linspace(0.02, 0.05, number)}
    with pytest.warns(lissom.AccuracyWarning, match="Other impacts were resolved"):
        result = lissom.simulate(robot, 0.5, dt=1e-2, **start, method=RESOLVED)
    others = 0
    for q, v in zip(result.q[:-1], result.v[:-1], strict=True):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", lissom.AccuracyWarning)
            step = lissom.simulate(robot, 1e-2, dt=1e-2, q0=q, v0=v, method=STOPPED)
        others += work(step.stats)
    # `FREE_WORK` over `work_of_evaluation`, in microseconds (`impact_resolver.rs`). The impacts of each ball
    # alone take 6600 evaluations together.
    free = 150_000 / (1 + 3 * number + 0.3 * number + 0.007 * number**2)
    assert work(result.stats) < 1.5 * others + free
    with pytest.warns(lissom.AccuracyWarning, match=r'impacts="resolved"'):
        lissom.simulate(robot, 0.5, dt=1e-2, **start, method=STOPPED)
    energy = np.array([robot.energy(q, v).total for q, v in zip(result.q, result.v, strict=True)])
    assert np.all(np.diff(energy) < 1e-3 * (energy[0] - number * G * 0.1))


def test_adaptive_steps_refuse_what_they_do_anyway():
    with pytest.raises(ValueError, match=r"impacts: got 'resolved', expected 'stopped': adaptive steps"):
        lissom.methods.Newmark(adaptive=True, impacts="resolved")


def test_tendons_that_do_not_stretch_go_by_steps_that_stop():
    tendon = lissom.Tendon(
        "rope", path=[lissom.Via(None, (0, 0, 1)), lissom.Via("ball", (0, 0, 0))], length=5.0
    )
    robot = ball(1e5)
    tied = Robot(robot.links, contacts=robot.contacts, actuators=[tendon])
    with pytest.warns(lissom.AccuracyWarning, match="shorter than steps") as caught:
        found = lissom.simulate(tied, 0.5, dt=1e-2, q0=[0.6], method=RESOLVED)
    assert "resolved" not in str(caught[0].message)
    with pytest.warns(lissom.AccuracyWarning):
        stopped = lissom.simulate(tied, 0.5, dt=1e-2, q0=[0.6], method=STOPPED)
    assert np.array_equal(found.q, stopped.q)


@pytest.mark.parametrize(("stiffness", "dissipation"), [(1e5, 0.0), (1e6, 0.1), (1e4, 0.3)])
def test_states_between_the_ends_of_steps(stiffness, dissipation):
    """They are those of the method that resolves the impact, and so is what is dissipated until then."""
    robot = ball(stiffness, dissipation)
    times = np.linspace(0, 1.0, 1001)
    result = lissom.simulate(robot, 1.0, dt=1e-2, q0=[1.1], method=RESOLVED, t_eval=times)
    fine = lissom.simulate(robot, 1.0, q0=[1.1], method="radau", rtol=1e-10, atol=1e-12, t_eval=times)
    assert fine.v.max() > 1.0
    assert_allclose(result.q, fine.q, atol=1e-4)
    assert_allclose(result.v, fine.v, atol=3e-3)
    assert_allclose(result.balance.dissipated, fine.balance.dissipated, atol=2e-3 * G)
    assert result.balance.drift < 2e-4


def tumbling_box(number, friction):
    """A box that is thrown on a floor while it spins, and its start."""
    random = np.random.default_rng(number)
    half, mass = random.uniform(0.03, 0.1, 3), 10.0 ** random.uniform(-1, 1)
    inertia = mass / 3 * (half @ half - half**2)
    box = Link(
        "box",
        joint=Free(),
        body=Body(mass, inertia=tuple(inertia)),
        position=(0, 0, random.uniform(0.3, 0.6)),
    )
    contact = Contact(
        lissom.Box((0, 0, 0), tuple(half), link="box"),
        FLOOR,
        stiffness=mass * 10.0 ** random.uniform(4, 7),
        friction=friction,
        dissipation=[0.0, 0.1, 0.5][number % 3],
    )
    v0 = np.concatenate([random.uniform(-1, 1, 3), random.uniform(-15, 15, 3)])
    return Robot([box], contacts=[contact]), v0


@pytest.mark.parametrize(("number", "friction"), [(20, 0), (28, 0), (31, 0), (2, 0.5), (23, 0.5), (37, 0.5)])
def test_the_balance_of_a_box_that_turns_past_pi_in_an_impact(number, friction):
    robot, v0 = tumbling_box(number, friction)
    for times in (None, np.linspace(0, 1.5, 997)):
        result = lissom.simulate(robot, 1.5, dt=5e-3, v0=v0, method=RESOLVED, t_eval=times)
        assert np.isfinite(result.balance.dissipated).all()
        assert result.balance.drift < 2e-2
    # Also step by step, from a copy of the middle of a flight.
    simulation = lissom.Simulation(robot, dt=5e-3, v0=v0, method=RESOLVED)
    simulation.step(duration=0.5)
    other = copy.copy(simulation)
    for one in (simulation, other):
        assert one.step(duration=1.0) == "finished"
    assert np.array_equal(simulation.q, other.q)
    assert_allclose(simulation.q[2], result.q[-1, 2], atol=1e-12)


def overlapped_chain(number):
    """Four links that lie on balls pressed into a stiff floor, and their start."""
    random = np.random.default_rng(number)
    length, mass, radius = random.uniform(0.1, 0.4), 10.0 ** random.uniform(-1, 1), 0.03
    body = Body(mass, centre=(length / 2, 0, 0), inertia=tuple(mass * length**2 / np.array([100, 12, 12])))
    first = Link("link 0", joint=Free(), body=body, position=(0, 0, radius))
    more = [
        Link(
            f"link {i}",
            parent=f"link {i - 1}",
            joint=lissom.Revolute((0, 1, 0)),
            body=body,
            position=(length, 0, 0),
        )
        for i in range(1, 4)
    ]
    balls = [Ball(link.name, radius, position=(length, 0, 0)) for link in (first, *more)]
    stiffness = mass * 10.0 ** random.uniform(6, 8)
    contacts = [
        Contact(ball, FLOOR, stiffness=stiffness, dissipation=0.1)
        for ball in (*balls, Ball("link 0", radius))
    ]
    robot = Robot([first, *more], contacts=contacts)
    q0 = np.zeros(robot.n)
    q0[2] = -radius * 10.0 ** random.uniform(-2, -0.5)
    return robot, q0


@pytest.mark.parametrize("number", range(12))
def test_what_overlaps_at_the_start_parts_with_the_energy_that_it_has(number):
    robot, q0 = overlapped_chain(number)
    result = lissom.simulate(robot, 0.05, dt=3e-3, q0=q0, method=RESOLVED)
    energy = np.array([robot.energy(q, v).total for q, v in zip(result.q, result.v, strict=True)])
    assert result.success, result.message
    assert energy.max() < energy[0] * (1 + 1e-6)
    # Before it falls back.
    fine = lissom.simulate(robot, 3e-3, q0=q0, method="radau", rtol=1e-8, atol=1e-10)
    assert_allclose(energy[1], robot.energy(fine.q[-1], fine.v[-1]).total, rtol=1e-2)
