"""`method="auto"` with inputs: controllers are called once; errors are those of the loop."""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lissom
from reference.standing import Chain

PERIOD = 0.02


class Driven(Chain):
    """A chain with torques in its joints, held for equal times; it hangs where gravity is negative."""

    torque = 0.0

    def rhs(self, t, state):
        found = super().rhs(t, state)
        apart = state[: self.n, None] - state[: self.n]
        found[self.n :] += np.linalg.solve(self.inertia * np.cos(apart), self.relative.T @ self.torque)
        return found

    def motion(self, q0, torques, times, step, solver="DOP853"):
        """Ends of all links at increasing times, under rows of torques or a controller of relative angles."""
        state = np.concatenate([np.linalg.solve(self.relative, q0), np.zeros(self.n)])
        found, given = [], []
        ends = np.minimum(np.arange(round(times[-1] / step + 0.499) + 1) * step, times[-1])
        for i, (begin, end) in enumerate(itertools.pairwise(ends)):
            if callable(torques):
                given.append(torques(begin, self.relative @ state[: self.n], self.relative @ state[self.n :]))
            self.torque = np.asarray(given[i] if callable(torques) else torques[i], float)
            last = end == ends[-1]
            here = times[(times >= begin - 1e-12) & ((times < end - 1e-12) | last)]
            solution = solve_ivp(
                self.rhs, (begin, end), state, solver, rtol=1e-11, atol=1e-13, dense_output=True
            )
            assert solution.success
            found.append(solution.sol(here).T if len(here) else np.empty((0, 2 * self.n)))
            state = solution.y[:, -1]
        angles = np.concatenate(found)[:, : self.n]
        along = np.stack([np.cos(angles), np.zeros_like(angles), -np.sin(angles)], axis=-1)
        return np.cumsum(self.lengths[:, None] * along, axis=1), np.array(given)


def robot(chain):
    """The same chain of rods without modes, with a motor in every joint."""
    links, motors = [], []
    for i in range(chain.n):
        density = chain.masses[i] / (np.pi * chain.radii[i] ** 2 * chain.lengths[i])
        segment = lissom.Segment(chain.lengths[i], chain.radii[i], 1e9, 4e8, density, {})
        joint = lissom.Revolute((0, 1, 0), stiffness=chain.springs[i], damping=chain.dampers[i])
        where = {"parent": f"link{i - 1}"} if i else {}
        links.append(lissom.Link(f"link{i}", rod=[segment], joint=joint, **where))
        motors.append(lissom.Motor(f"link{i}", torque=lissom.Input(f"torque{i}")))
    return lissom.Robot(links, gravity=(-chain.gravity, 0, 0), actuators=motors)


def ends_of(model, motion):
    found = [model.pose(motion.q, link=link.name, t=motion.t)[:, :3, 3] for link in model.links]
    return np.stack(found, axis=1)


def distance(a, b, chain):
    return np.linalg.norm(a - b, axis=2).max() / chain.lengths.sum()


def arm(unit=1.0):
    """Two links that hang; lengths in units of so many metres."""
    return Driven(unit * np.array([0.6, 0.4]), [1.0, 0.5], gravity=-9.81 * unit, dampers=0.02 * unit**2)


class Counted:
    """A controller that counts its calls, with the times of these."""

    def __init__(self, law):
        self.law, self.times = law, []

    def __call__(self, t, q, v):
        self.times.append(t)
        return self.law(t, q, v)


class PD:
    """Follows a desired motion about these angles."""

    def __init__(self, about, unit=1.0):
        self.about, self.scale = np.array(about), unit**2 * np.array([6.0, 2.0])

    def __call__(self, t, q, v):
        wanted = self.about + np.array([0.8, -0.5]) * np.sin(4.0 * t)
        return 1.5 * self.scale * (wanted - q) - 0.12 * self.scale * v


class PI(PD):
    """With a memory: calls from the start a second time would begin with a wrong sum."""

    def __init__(self, about, unit=1.0):
        super().__init__(about, unit)
        self.sum, self.last = np.zeros(2), -np.inf

    def __call__(self, t, q, v):
        assert t > self.last, "the controller was called again for an earlier time"
        self.last = t
        apart = self.about + 0.3 - q
        self.sum += PERIOD * apart
        return self.scale * (1.5 * apart + 1.0 * self.sum - 0.12 * v)


def bang(t, q, v):
    """Chatters about the line on which it switches."""
    return -2.0 * np.sign(v + 3.0 * q)


HANGING, UPRIGHT = (0.0, 0.3), (np.pi, 0.3)
AWAY = np.array([-0.7, 0.1])


def run(model, control, about, rtol, **options):
    return lissom.simulate(
        model,
        2.0,
        q0=np.add(about, AWAY),
        method="auto",
        rtol=rtol,
        control=control,
        control_step=PERIOD,
        dt=0.01,
        **options,
    )


@pytest.mark.parametrize("rtol", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("about", [HANGING, UPRIGHT], ids=["hanging", "upright"])
@pytest.mark.parametrize("law", [PD, PI])
def test_a_loop_is_as_accurate_as_asked(law, about, rtol):
    # Upright, the arm falls under the inputs alone: differences grow e-fold in less than 0.2 s.
    chain = arm()
    model, control = robot(chain), Counted(law(about))
    motion = run(model, control, about, rtol)
    assert motion.success
    assert motion.doubt is None
    np.testing.assert_allclose(control.times, PERIOD * np.arange(100), rtol=0, atol=1e-12)
    right, _ = chain.motion(np.add(about, AWAY), law(about), motion.t, PERIOD)
    assert distance(ends_of(model, motion), right, chain) < motion.stats.time_error <= rtol
    # The controller saw the states that are returned.
    again, states = law(about), zip(motion.t[:-1:2], motion.q[::2], motion.v[::2], strict=False)
    expected = [again(t, q, v) for t, q, v in states]
    np.testing.assert_allclose(motion.u[:-1:2], expected, rtol=0, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("rtol", [1e-2, 1e-4, 1e-6])
def test_a_chattering_loop_is_accurate_under_the_inputs_that_it_had(rtol):
    chain = arm()
    model, control = robot(chain), Counted(bang)
    motion = run(model, control, HANGING, rtol)
    assert motion.success
    assert len(control.times) == 100
    assert (np.diff(np.sign(motion.u[:, 0])) != 0).sum() > 20
    right, _ = chain.motion(np.add(HANGING, AWAY), motion.u[:-1:2], motion.t, PERIOD, "LSODA")
    assert distance(ends_of(model, motion), right, chain) < motion.stats.time_error <= rtol


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_units_do_not_matter(unit):
    found = []
    for one in (1.0, unit):
        chain = arm(one)
        model = robot(chain)
        motion = run(model, PD(UPRIGHT, one), UPRIGHT, 1e-4)
        found.append(motion)
        right, _ = chain.motion(np.add(UPRIGHT, AWAY), PD(UPRIGHT, one), motion.t, PERIOD)
        assert distance(ends_of(model, motion), right, chain) < 1e-4
    assert found[0].stats.steps == found[1].stats.steps
    np.testing.assert_allclose(found[1].u, unit**2 * found[0].u, rtol=1e-6, atol=1e-6 * unit**2)


def test_a_step_that_does_not_divide_the_time():
    chain = arm()
    motion = lissom.simulate(
        robot(chain),
        1.0,
        q0=AWAY,
        method="auto",
        control=Counted(PD(HANGING)),
        control_step=0.03,
        t_eval=[0.4, 1.0],
    )
    right, given = chain.motion(AWAY, PD(HANGING), np.array([0.4, 1.0]), 0.03)
    assert len(given) == 34
    assert distance(ends_of(robot(chain), motion), right, chain) < motion.stats.time_error <= 1e-4


@pytest.mark.parametrize("kind", [RuntimeError, KeyboardInterrupt])
def test_a_controller_that_fails_leaves_what_was_computed(kind):
    control = Counted(PD(HANGING))

    def fails(t, q, v):
        if t > 0.5:
            raise kind
        return control(t, q, v)

    with pytest.raises(kind) as caught:
        run(robot(arm()), fails, HANGING, 1e-4)
    motion = caught.value.result
    assert motion.status == "interrupted"
    assert motion.t[-1] == pytest.approx(0.52)
    assert len(control.times) == 26


def test_contact_in_the_loop():
    """A link that is pressed on a wall: a spring that only pushes, in equations of the test."""
    stiffness, mass, length = 2e3, 1.0, 0.5
    body = lissom.Body(mass, centre=(length, 0, 0), inertia=(1e-9, 1e-9, 1e-9))
    motor = lissom.Motor("arm", torque=lissom.Input("torque"))
    joint = lissom.Revolute((0, 1, 0), damping=0.05, limits=(-2.0, 0.3), limit_stiffness=stiffness)
    model = lissom.Robot([lissom.Link("arm", joint=joint, body=body)], gravity=(0, 0, 0), actuators=[motor])
    times = []

    def law(t, q, v):
        times.append(t)
        return [1.5 * (0.6 - q[0]) - 0.2 * v[0]]

    motion = lissom.simulate(
        model, 2.0, q0=[-0.5], method="auto", rtol=1e-3, control=law, control_step=PERIOD
    )
    assert motion.success
    assert len(times) == 100
    assert motion.q.max() > 0.3
    inertia = mass * length**2 + 1e-9
    state, found = np.array([-0.5, 0.0]), []
    for _ in range(100):
        torque = law(0.0, state[:1], state[1:])[0]

        def rhs(t, y, torque=torque):
            stop = stiffness * max(y[0] - 0.3, 0.0)
            return [y[1], (torque - 0.05 * y[1] - stop) / inertia]

        state = solve_ivp(rhs, (0, PERIOD), state, "LSODA", rtol=1e-10, atol=1e-12).y[:, -1]
        found.append(state[0])
    assert np.abs(motion.q[2::2, 0] - found).max() < 1e-3


def test_inputs_that_are_held_count():
    chain, held = arm(), [1.5, -0.4]
    model = robot(chain)
    motion = lissom.simulate(model, 1.5, q0=AWAY, method="auto", rtol=1e-5, u=held)
    right, _ = chain.motion(AWAY, [held], motion.t, 1.5)
    assert distance(ends_of(model, motion), right, chain) < motion.stats.time_error <= 1e-5
    by_name = {"torque1": -0.4, "torque0": 1.5}
    named = lissom.simulate(model, 1.5, q0=AWAY, method="auto", rtol=1e-5, u=by_name)
    np.testing.assert_array_equal(named.q, motion.q)
    (row,) = lissom.simulate_many(model, 1.5, q0=[AWAY], method="auto", rtol=1e-5, u=[held]).q
    np.testing.assert_array_equal(row, motion.q)


def test_rows_of_inputs_count_in_many_runs():
    chain = arm()
    model, random = robot(chain), np.random.default_rng(3)
    u = random.normal(size=(2, 10, 2))
    found = lissom.simulate_many(
        model, 1.0, q0=AWAY, method="auto", rtol=1e-5, u=u, control_step=0.1, dt=0.02
    )
    for row in range(2):
        right, _ = chain.motion(AWAY, u[row], found.t, 0.1)
        ends = np.stack([model.pose(found.q[row], link=link.name)[:, :3, 3] for link in model.links], axis=1)
        assert distance(ends, right, chain) < 1e-5


@pytest.mark.parametrize("rtol", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("about", [HANGING, UPRIGHT], ids=["hanging", "upright"])
def test_step_by_step_as_accurate_as_asked(about, rtol):
    chain = arm()
    model, law = robot(chain), PD(about)
    simulation = lissom.Simulation(model, dt=PERIOD, q0=np.add(about, AWAY), method="auto", rtol=rtol)
    assert simulation.time_error < rtol
    shapes, errors = [simulation.q], []
    for _ in range(100):
        assert simulation.step(law(simulation.t, simulation.q, simulation.v)) == "finished"
        shapes.append(simulation.q)
        errors.append(simulation.time_error)
    assert simulation.t == 2.0
    times = PERIOD * np.arange(101)
    right, _ = chain.motion(np.add(about, AWAY), PD(about), times, PERIOD)
    ends = np.stack([model.pose(np.array(shapes), link=link.name)[:, :3, 3] for link in model.links], axis=1)
    assert distance(ends, right, chain) < simulation.time_error <= rtol
    assert (np.diff(errors) >= 0).all()
    assert simulation.doubt is None
    assert "was asked for" in simulation.message


def test_copies_and_pickles_go_on_with_the_error():
    import pickle

    law, model = PD(UPRIGHT), robot(arm())
    simulation = lissom.Simulation(model, dt=PERIOD, q0=np.add(UPRIGHT, AWAY), method="auto", rtol=1e-3)

    def advance(each, steps):
        for _ in range(steps):
            each.step(law(each.t, each.q, each.v))

    advance(simulation, 30)
    others = [simulation.copy(), pickle.loads(pickle.dumps(simulation))]
    for each in (simulation, *others):
        advance(each, 30)
    for each in others:
        np.testing.assert_array_equal(each.q, simulation.q)
        assert each.time_error == simulation.time_error
    simulation.reset()
    assert simulation.t == 0.0
    assert simulation.time_error < others[0].time_error


def test_steps_of_a_motion_that_multiplies_errors_are_doubted():
    pendulum = lissom.SpringPendulum()
    simulation = lissom.Simulation(pendulum, dt=0.5, q0=[1.5, 0.5], method="auto", rtol=1e-4)
    for _ in range(400):
        simulation.step()
    assert simulation.time_error > 1e-4
    assert "1e-4 was asked for and exceeded at t =" in simulation.doubt
    assert lissom.Simulation(pendulum, dt=0.5).time_error is None


@pytest.mark.parametrize(("q0", "t_end", "step"), [(1e-6, 8.0, 0.5), (1e-3, 5.0, 0.2)])
def test_errors_grow_under_inputs_that_never_change(q0, t_end, step):
    """A pendulum that falls from above, without a torque: no controller takes errors back."""
    body = lissom.Body(1.0, centre=(0.5, 0, 0), inertia=(0, 1 / 12, 1 / 12))
    arm = lissom.Link("arm", joint=lissom.Revolute((0, 1, 0)), body=body)
    motor = lissom.Motor("arm", torque=lissom.Input("torque"))
    standing = lissom.Robot([arm], gravity=(-9.81, 0, 0), actuators=[motor])
    times = np.arange(0.0, t_end + 0.5 * step, step)
    exact = solve_ivp(
        lambda t, x: [x[1], 1.5 * 9.81 * np.sin(x[0])],
        (0, t_end),
        [q0, 0.0],
        "DOP853",
        times,
        rtol=1e-12,
        atol=1e-15,
    )
    assert exact.success

    def apart(angles):
        return np.abs(2 * np.sin(0.5 * (np.asarray(angles) - exact.y[0][: len(angles)]))).max()

    found = lissom.simulate(
        standing,
        t_end,
        q0=[q0],
        method="auto",
        rtol=1e-3,
        control=lambda t, q, v: [0.0],
        control_step=step,
        t_eval=times,
    )
    assert apart(found.q[:, 0]) < found.stats.time_error
    assert found.success == (found.stats.time_error < 1e-3)
    simulation = lissom.Simulation(standing, dt=step, method="auto", rtol=1e-3, q0=[q0])
    angles = [q0]
    for _ in times[1:]:
        simulation.step([0.0])
        angles.append(simulation.q[0])
    assert apart(angles) < simulation.time_error
    assert (simulation.doubt is None) == (simulation.time_error <= 1e-3)
