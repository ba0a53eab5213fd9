"""Tendons that do not stretch, in steps of fixed size: closed forms, Radau, random walks of lengths."""

import pickle

import numpy as np
import pytest
from test_inextensible_changes import MASS, ROPE, G, bob, fallen, gone_over, place, rope, run

import lissom

SIZES = np.array([1e-2, 5e-3, 2.5e-3, 1.25e-3, 0.625e-3])


def ball(dt, **options):
    return lissom.simulate(bob(), 0.6, dt=dt, **options, **place(0.3, 0.0))


@pytest.mark.parametrize("method", ["generalised_alpha", "hht"])
def test_a_ball_that_falls_into_its_rope_has_the_order_of_the_method(method):
    end, lost = fallen(0.3, 0.6)
    runs = [ball(dt, method=method) for dt in SIZES]
    assert all(motion.success for motion in runs)
    errors = np.array([np.hypot(*(motion.q[-1][[0, 2]] - end)) for motion in runs])
    assert errors[0] < 5e-4
    assert (errors[:-1] / errors[1:] > 3.3).all()
    for motion, dt in zip(runs, SIZES, strict=True):
        np.testing.assert_allclose(motion.t, np.arange(len(motion.t)) * dt, atol=1e-12)
        assert np.hypot(motion.q[:, 0], motion.q[:, 2]).max() < ROPE + 1e-9
        assert motion.balance.dissipated[-1] == pytest.approx(lost, rel=1e-6)
        assert motion.balance.drift < 10 * dt**2 / ROPE


def test_a_ball_that_goes_over_the_top_falls_where_nothing_pulls():
    speed = np.sqrt(3.5 * G * ROPE)
    _, taut_at, end = gone_over(speed, 0.3)
    errors = []
    for dt in SIZES[1:]:
        motion = lissom.simulate(bob(), taut_at + 0.3, dt=dt, **place(0, -ROPE, speed))
        assert motion.success, motion.message
        errors.append(np.hypot(*(motion.q[-1][[0, 2]] - end)))
    assert errors[-1] < 1e-4
    assert errors[0] / errors[-1] > 3.0**3


def chain(n):
    """Balls on ropes from one to the next, thrown."""
    links, ropes, before = [], [], None
    q, v = np.zeros(6 * n), np.zeros(6 * n)
    for k in range(n):
        body = lissom.Body(0.1 + 0.05 * k, inertia=np.diag([1e-5] * 3))
        links.append(lissom.Link(f"ball {k}", joint=lissom.Free(), body=body))
        path = [lissom.Via(before, (0, 0, 0)), lissom.Via(f"ball {k}", (0, 0, 0))]
        ropes.append(lissom.Tendon(f"rope {k}", path, length=0.3))
        before = f"ball {k}"
        q[6 * k : 6 * k + 3] = (0.25 * (k + 1), 0.02 * k, 0.03 * k)
        v[6 * k : 6 * k + 3] = (0.2 - 0.1 * k, 0.1 * k, 0.3)
    return lissom.Robot(links, gravity=(0, 0, -G), actuators=ropes), {"q0": q, "v0": v}


def body_on_cords(seed):
    rng = np.random.default_rng(seed)
    body = lissom.Body(1.0, inertia=np.diag(rng.uniform(6e-3, 1e-2, 3)))
    cords = []
    for i in range(rng.integers(1, 5)):
        point, anchor = rng.uniform(-0.2, 0.2, 3), rng.uniform((-0.5, -0.5, -0.1), (0.5, 0.5, 0.9))
        length = np.linalg.norm(anchor - point) * rng.uniform(1.0, 1.5)
        if rng.random() < 0.3:
            length = lissom.Harmonic(0.05 * length, rng.uniform(0.5, 3.0), mean=1.1 * length)
        path = [lissom.Via(None, tuple(anchor)), lissom.Via("body", tuple(point))]
        cords.append(lissom.Tendon(f"cord {i}", path, length=length))
    link = lissom.Link("body", joint=lissom.Free(), body=body)
    robot = lissom.Robot([link], gravity=(0, 0, -G), actuators=cords)
    return robot, {"v0": rng.normal(size=6) * [0.5, 0.5, 0.5, 2, 2, 2]}


def errors_of(robot, start, sizes):
    """Of places, beside Radau's method."""
    grid = np.linspace(0, 0.5, 11)
    wanted = run(robot, 0.5, "radau", 1e-9, t_eval=grid, **start)
    assert wanted.success, wanted.message
    errors = []
    for dt in sizes:
        motion = lissom.simulate(robot, 0.5, dt=dt, t_eval=grid, **start)
        assert motion.success, motion.message
        errors.append(np.abs(motion.q[:, :3] - wanted.q[:, :3]).max())
    return np.array(errors)


@pytest.mark.parametrize("n", [2, 3, 5])
def test_chains_on_ropes_have_order_two(n):
    errors = errors_of(*chain(n), (2e-3, 1e-3, 5e-4))
    assert errors[0] / errors[2] > 10.0
    assert errors[2] < 3e-5


def test_bodies_on_cords_have_order_two():
    """Dozens of impacts each."""
    errors = np.array([errors_of(*body_on_cords(seed), (2e-3, 5e-4)) for seed in range(24)])
    assert np.median(errors[:, 0] / errors[:, 1]) > 13.0
    assert np.median(errors[:, 1]) < 5e-6
    assert errors[:, 1].max() < 5e-5


@pytest.mark.parametrize("method", ["generalised_alpha", "hht"])
def test_impacts_of_cords_take_energy_out_and_nothing_puts_any_in(method):
    for seed in (4, 6, 10, 11, 12):
        robot, start = body_on_cords(seed)
        assert all(isinstance(cord.length, float) for cord in robot.actuators)
        motion = lissom.simulate(robot, 1.0, dt=1e-3, method=method, **start)
        balance = motion.balance
        energy = balance.kinetic + balance.gravitational
        assert (np.diff(balance.dissipated) > -1e-12 * balance.scale).all()
        assert balance.dissipated[-1] > 0.01 * balance.scale
        assert energy.max() < energy[0] + 1e-3 * balance.scale
        assert balance.drift < 1e-3


@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
def test_adaptive_steps_end_at_changes(rtol):
    end, lost = fallen(0.3, 0.6)
    motion = lissom.simulate(bob(), 0.6, adaptive=True, rtol=rtol, atol=1e-2 * rtol, **place(0.3, 0.0))
    assert motion.success, motion.message
    assert np.hypot(*(motion.q[-1][[0, 2]] - end)) < 10 * rtol
    assert motion.balance.dissipated[-1] == pytest.approx(lost, rel=10 * rtol)
    assert np.hypot(motion.q[:, 0], motion.q[:, 2]).max() < ROPE + 1e-4 * rtol


def test_bodies_on_cords_in_adaptive_steps():
    errors = []
    for seed in range(8):
        robot, start = body_on_cords(seed)
        grid = np.linspace(0, 0.5, 11)
        wanted = run(robot, 0.5, "radau", 1e-9, t_eval=grid, **start)
        motion = lissom.simulate(robot, 0.5, adaptive=True, rtol=1e-5, atol=1e-7, t_eval=grid, **start)
        assert motion.success, motion.message
        errors.append(np.abs(motion.q[:, :3] - wanted.q[:, :3]).max())
    assert max(errors) < 5e-4


# Lengths that jump


@pytest.mark.parametrize("dt", [1e-3, 3e-3, 1e-2])
def test_a_rope_that_is_let_out_at_once_does_not_push(dt):
    """The ball swings, flies freely, and swings on the longer rope without having gained energy."""
    robot = bob(rope(lambda t: ROPE if t < 0.1 else 1.2 * ROPE))
    motion = lissom.simulate(robot, 0.5, dt=dt, **place(0.3, -0.4))
    assert motion.success, motion.message
    energy = 0.5 * MASS * (motion.v[:, :3] ** 2).sum(1) + MASS * G * motion.q[:, 2]
    assert (np.diff(energy) < 1e-3 * MASS * G * ROPE).all()
    radii = np.hypot(motion.q[:, 0], motion.q[:, 2])
    assert radii.max() == pytest.approx(1.2 * ROPE, abs=1e-8)


@pytest.mark.parametrize("dt", [1e-3, 1e-2])
def test_a_rope_that_is_taken_in_at_once_is_followed_within_a_step(dt):
    robot = bob(rope(lambda t: ROPE if t < 0.1 else 0.9 * ROPE))
    motion = lissom.simulate(robot, 0.3, dt=dt, **place(0.0, -ROPE))
    assert motion.success, motion.message
    radii = np.hypot(motion.q[:, 0], motion.q[:, 2])
    np.testing.assert_allclose(radii[motion.t < 0.1 - dt / 2], ROPE, atol=1e-9)
    np.testing.assert_allclose(radii[motion.t > 0.1 + dt / 2], 0.9 * ROPE, atol=1e-9)
    # What moves it there in no time does not throw it, and lifts it.
    np.testing.assert_allclose(motion.v[-1], 0.0, atol=1e-9)
    assert motion.doubt is None
    assert motion.balance.work[-1] == pytest.approx(MASS * G * 0.1 * ROPE, rel=1e-6)
    assert motion.balance.drift < 1e-6


@pytest.mark.parametrize("way", [0.1, -0.1, -1e-3])
@pytest.mark.parametrize("dt", [1e-3, 1e-2])
def test_where_in_a_step_lengths_jump_does_not_matter(way, dt):
    """Also right behind the end of a step, where their rates mean nothing."""
    ends = []
    for jumps in (lambda t: t > 0.3, lambda t: t >= 0.3, lambda t: t > 0.3 + dt / 2):
        length = lambda t, jumps=jumps: ROPE + way * jumps(t)  # noqa: E731
        motion = lissom.simulate(bob(rope(length)), 0.8, dt=dt, **place(0.3, -0.4))
        assert motion.success, motion.message
        assert motion.doubt is None
        assert motion.balance.scale < 1.0
        ends.append(motion.q[-1])
    np.testing.assert_allclose(ends[1:], [ends[0]] * 2, atol=0.5 * dt)


@pytest.mark.parametrize("dt", [1e-3, 2.5e-4])
def test_what_winches_do_is_in_the_balance(dt):
    """A swinging ball that is pulled up: by a smooth length, and by one that jumps from step to step."""
    start = place(0.3, -0.4)
    motion = lissom.simulate(bob(rope(lissom.Harmonic(0.1, 1.0, mean=ROPE))), 1.0, dt=dt, **start)
    assert motion.success, motion.message
    assert np.ptp(motion.balance.work) > 0.1 * motion.balance.scale
    assert motion.balance.drift < 500 * dt**2 / 1e-3
    jumping = bob(rope(lissom.Input("length", ROPE)))
    lengths = ROPE - 0.1 * np.linspace(0.0, 1.0, 21)
    control = {"control": lambda t, q, v: [lengths[int(20 * t + 1e-6)]], "control_step": 0.05}
    motion = lissom.simulate(jumping, 1.0, dt=dt, **control, **start)
    assert motion.success, motion.message
    assert motion.balance.work[-1] > MASS * G * 0.05
    assert motion.balance.drift < 0.02


def test_lengths_that_are_lowered_from_step_to_step_move_the_load_smoothly():
    """The load falls behind the winch, and has its velocity once it has come to the end of the rope."""
    robot = bob(rope(lissom.Input("length", ROPE)))
    speed, dt = 0.1, 1e-3
    simulation = lissom.Simulation(robot, dt=dt, **place(0, -ROPE))
    for k in range(1, 101):
        simulation.step([ROPE + speed * dt * k])
        if k > 30:
            assert simulation.q[2] == pytest.approx(-ROPE - speed * dt * k, abs=1e-9)
            assert simulation.v[2] == pytest.approx(-speed, rel=1e-3)
    again = pickle.loads(pickle.dumps(simulation))
    # Where the winch stops, the rope stops the load.
    for other in (simulation, again):
        for _ in range(2):
            other.step([ROPE + 0.01])
        np.testing.assert_allclose(other.v, 0.0, atol=1e-9)
        assert other.q[2] == pytest.approx(-ROPE - 0.01, abs=1e-9)
    np.testing.assert_array_equal(simulation.q, again.q)


@pytest.mark.parametrize("steps", [0, 40])
def test_simulations_that_earlier_versions_saved_go_on(steps):
    """Their records have nothing of changes, the last ten numbers."""
    robot = bob(rope(lissom.Input("length", ROPE)))
    simulation = lissom.Simulation(robot, dt=1e-3, **place(0.3, -0.4))
    for _ in range(steps):
        simulation.step([ROPE])
    restore, (model, options, start, numbers, outcome) = simulation.__reduce__()
    again = restore(model, options, start, numbers[:-10], outcome)
    for _ in range(500):
        simulation.step([ROPE])
        again.step([ROPE])
    assert again.status == "finished"
    np.testing.assert_allclose(again.q, simulation.q, atol=1e-6)
    with pytest.raises(ValueError, match="memory"):
        restore(model, options, start, numbers[:-9], outcome)


def test_lengths_that_are_lowered_faster_than_the_load_falls_leave_the_rope_slack():
    robot = bob(rope(lissom.Input("length", ROPE)))
    simulation = lissom.Simulation(robot, dt=1e-3, **place(0, -ROPE))
    for k in range(1, 51):
        simulation.step([ROPE + 5e-3 * k])
    # The step in which it becomes slack is of first order.
    assert simulation.q[2] == pytest.approx(-ROPE - G / 2 * 0.05**2, abs=G * 1e-3 * 0.05)


def test_lengths_that_conflict_on_the_way_end_a_run():
    """At 0.4 s the lower rope has come in as far as the upper one lets it."""
    robot = bob(rope(), rope(lambda t: 0.9 - 0.5 * t, "low", (0, 0, -1.2)))
    motion = lissom.simulate(robot, 1.0, dt=1e-3, **place(0, -ROPE))
    assert motion.status == "loop_open"
    assert "conflict" in motion.message
    assert motion.t[-1] == pytest.approx(0.4, abs=0.011)


def walker(seed):
    """A body on cords, a rod, or balls on ropes, with inputs for lengths; start, step, size of their walk."""
    rng = np.random.default_rng([seed, 7])
    kind = seed % 3
    origin = (0, 0, 0)
    q0 = None
    if kind == 0:
        body, cords = lissom.Body(1.0, inertia=np.diag(rng.uniform(6e-3, 1e-2, 3))), []
        for i in range(rng.integers(1, 8)):
            point, anchor = rng.uniform(-0.2, 0.2, 3), rng.uniform((-0.5, -0.5, -0.5), (0.5, 0.5, 0.9))
            length = lissom.Input(f"u{i}", np.linalg.norm(anchor - point) * rng.uniform(1.0, 1.1))
            path = [lissom.Via(None, tuple(anchor)), lissom.Via("body", tuple(point))]
            cords.append(lissom.Tendon(f"cord {i}", path, length=length))
        links = [lissom.Link("body", joint=lissom.Free(), body=body)]
    elif kind == 1:
        modes = {"bend_y": 3, "bend_z": 3, "stretch": 1, "torsion": 1}
        segment = lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, modes=modes, retardation_time=0.01)
        n = rng.integers(1, 5)
        offsets = [(0.008 * np.cos(a), 0.008 * np.sin(a)) for a in 2 * np.pi * np.arange(n) / n]
        cords = [
            lissom.Tendon(f"t{i}", [lissom.Along(offset=offset)], length=lissom.Input(f"u{i}", 0.3))
            for i, offset in enumerate(offsets)
        ]
        links = None
    else:
        n, before, links, cords = rng.integers(2, 4), None, [], []
        q0 = np.zeros(6 * n)
        for k in range(n):
            ball = lissom.Body(0.2, inertia=np.diag([1e-4] * 3))
            links.append(lissom.Link(f"b{k}", joint=lissom.Free(), body=ball))
            path = [lissom.Via(before, origin), lissom.Via(f"b{k}", origin)]
            cords.append(lissom.Tendon(f"r{k}", path, length=lissom.Input(f"u{k}", 0.3)))
            before = f"b{k}"
            q0[6 * k : 6 * k + 3] = (0.05 * (k + 1), 0, -0.29 * (k + 1))
        path = [lissom.Via(None, (0.4, 0, -0.1)), lissom.Via(before, origin)]
        cords.append(lissom.Tendon("side", path, length=lissom.Input("side", 0.9)))
    if links is None:
        robot = lissom.Rod([segment], gravity=(0, 0, -G), actuators=cords)
    else:
        robot = lissom.Robot(links, gravity=(0, 0, -G), actuators=cords)
    return robot, q0, rng.choice([1e-3, 3e-3, 1e-2]), 10 ** rng.uniform(-4.5, -2.3), rng


def walk(seed):
    """How a run ends whose lengths walk at random from step to step."""
    robot, q0, dt, size, rng = walker(seed)
    simulation = lissom.Simulation(robot, dt=dt, q0=q0)
    start, largest = robot.u0, 0.03 if seed % 3 == 1 else 0.1
    lengths = start.copy()
    for _ in range(100):
        lengths = lengths + size * start * rng.normal(size=len(start))
        lengths = start + np.clip(lengths - start, -largest * start, largest * start)
        simulation.step(lengths)
        if simulation.status != "finished":
            break
    return simulation.status


@pytest.mark.parametrize("first", [0, pytest.param(48, marks=pytest.mark.slow)])
def test_lengths_that_walk_at_random_are_followed(first):
    """Release and take-up do not follow each other without end where lengths jump against each other."""
    last = 240 if first else 48
    statuses = [walk(seed) for seed in range(first, last)]
    assert statuses.count("finished") >= len(statuses) - (1 if first else 0), statuses
