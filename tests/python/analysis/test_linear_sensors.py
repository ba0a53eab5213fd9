"""Linear models with sensors as outputs, and in discrete time, against motions and other programs."""

import re

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import cont2discrete

import lissom
from lissom import sensors


def finger(tension=2.0, **more):
    segment = lissom.Segment(
        0.2,
        0.01,
        1e6,
        poisson_ratio=0.5,
        density=1000,
        modes={"bend_y": 2, "bend_z": 1},
        retardation_time=2e-3,
    )
    pull = lissom.Tendon("pull", [lissom.Along(offset=(0.004, 0.008))], tension=lissom.Input("pull", tension))
    return lissom.Robot([lissom.Link("finger", rod=[segment])], actuators=[pull], **more)


def all_of(robot):
    return [
        sensors.Accelerometer(robot, at=0.15, noise=0.1, bias=3.0),
        sensors.Gyroscope(robot, at=0.2),
        sensors.ForceTorque(robot),
        sensors.ForceTorque(robot, at=0.1, name="section"),
        sensors.ActuatorLength(robot, "pull", delay=0.1),
        sensors.ActuatorForce(robot, "pull"),
        sensors.CurvatureSensor(robot, at=[0.05, 0.15]),
    ]


def test_models_are_printed_in_a_line():
    robot = finger()
    rest = lissom.statics(robot, space_error=False).q
    linear = lissom.linearise(robot, rest, "inputs", "finger_position_z")
    assert repr(linear) == "<LinearModel: 6 states, inputs pull, outputs finger_position_z>"
    assert repr(linear.discrete(1e-3)).endswith("outputs finger_position_z, sampled every 0.001 s>")
    many = lissom.linearise(robot, rest, outputs=["coordinates", "velocities", "finger_position"])
    assert "outputs finger.bend_y[0], ..., finger_position_z" in repr(many)


def test_sensors_of_a_small_motion_read_what_the_linear_model_says():
    """The tension steps up by a little; readings of the motion differ from those at rest by y = C x + D u."""
    robot, step, small = finger(), 1e-3, 1e-3
    rest = lissom.statics(robot, space_error=False)
    carried = all_of(robot)
    linear = lissom.linearise(robot, rest.q, "inputs", carried)
    at = np.arange(1, 40) * step
    run = lissom.simulate(
        finger(2.0 + small), 0.04, q0=rest.q, method="radau", rtol=1e-10, atol=1e-13, t_eval=[0.0, *at]
    )
    sampled = linear.discrete(step)
    x, expected = np.zeros(len(linear.states)), []
    for _ in range(40):
        expected.append(sampled.C @ x + sampled.D @ [small])
        x = sampled.A @ x + sampled.B @ [small]
    still = np.zeros((1, robot.n))
    for sensor in carried:
        read = sensor.measure(run.t, run.q, run.v, run.a, np.full((len(run.t), 1), 2.0 + small))
        before = sensor.measure([0.0], rest.q[None], still, still, [[2.0]])
        rows = [linear.outputs.index(name) for name in sensor.channels]
        change, said = read - before, np.array(expected)[:, rows]
        assert np.abs(said).max() > 1e-6 * small
        # The motion is not linear beyond the first power of the step.
        np.testing.assert_allclose(change, said, atol=2e-3 * np.abs(said).max(), err_msg=sensor.name)


def test_forces_that_the_sensor_does_not_know_are_refused():
    robot = finger()
    q = lissom.statics(robot, space_error=False).q
    with pytest.raises(ValueError, match="load that is an `Input`"):
        lissom.linearise(robot, q, "finger_force_z", sensors.ForceTorque(robot))
    accelerometer = sensors.Accelerometer(robot, at=0.15)
    linear = lissom.linearise(robot, q, "finger_force_z", accelerometer)
    assert np.abs(linear.D).max() > 1.0  # m/s^2 for each newton
    with pytest.raises(ValueError, match="of another robot"):
        lissom.linearise(finger(gravity=(0, 0, 0)), q, "inputs", accelerometer)
    with pytest.raises(ValueError, match="two sensors of one name"):
        lissom.linearise(robot, q, "inputs", [accelerometer, accelerometer])


def test_an_accelerometer_on_a_sliding_mass_reads_force_over_mass():
    slide = lissom.Prismatic((1, 0, 0), stiffness=50.0, damping=0.4)
    push = lissom.Load(link="mass", force=lissom.Input("push", (0, 0, 0)))
    robot = lissom.Robot(
        [lissom.Link("mass", body=lissom.Body(2.0), joint=slide)], loads=[push], gravity=(0, 0, 0)
    )
    linear = lissom.linearise(robot, [0.0], ["push.x"], sensors.Accelerometer(robot))
    np.testing.assert_allclose(linear.C[0], [-50.0 / 2.0, -0.4 / 2.0], rtol=1e-8)
    np.testing.assert_allclose(linear.D[:, 0], [0.5, 0.0, 0.0], atol=1e-9)


def test_loops_leave_sensors_their_independent_coordinates():
    """Two sliders that a loop moves together: one state, half the acceleration for the same force."""
    push = lissom.Load(link="left", force=lissom.Input("push", (0, 0, 0)))
    slide, hinge = lissom.Prismatic((1, 0, 0)), lissom.Revolute((0, 1, 0))
    left = lissom.Link("left", body=lissom.Body(1.0), joint=slide)
    right = lissom.Link("right", body=lissom.Body(3.0), joint=slide)
    links = [left, right]
    robot = lissom.Robot(links, loads=[push], gravity=(0, 0, 0), loops=[lissom.Loop("left", "right", hinge)])
    carried = sensors.Accelerometer(robot, link="right")
    linear = lissom.linearise(robot, [0.0, 0.0], ["push.x"], carried)
    assert linear.A.shape == (2, 2)
    np.testing.assert_allclose(linear.D[:, 0], [0.25, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(linear.C, 0.0, atol=1e-9)


@given(st.floats(0.0, 5.0), st.sampled_from([1e-3, 2e-2]))
@settings(max_examples=25, deadline=None)
def test_delays_are_those_of_held_inputs_shifted(samples, dt):
    """Simulated in the finest steps that both times are multiples of: inputs shifted by the delay."""
    robot = finger()
    q = lissom.statics(robot, space_error=False).q
    linear = lissom.linearise(robot, q, "inputs", [sensors.Accelerometer(robot, at=0.2), "coordinates"])
    fine = 20
    late = round(samples * fine)
    sampled = linear.discrete(dt, delay=late * dt / fine)
    quick = linear.discrete(dt / fine)
    u = np.random.default_rng(1).normal(size=12)
    x, z = np.zeros(len(sampled.states)), np.zeros(len(quick.states))
    for k in range(12):
        shown = sampled.C @ x + sampled.D @ [u[k]]
        for inner in range(fine):
            index = (k * fine + inner - late) // fine
            held = [u[index]] if index >= 0 else [0.0]
            if inner == 0:
                expected = quick.C @ z + quick.D @ held
                np.testing.assert_allclose(shown, expected, atol=1e-9 * max(1.0, np.abs(expected).max()))
            z = quick.A @ z + quick.B @ held
        x = sampled.A @ x + sampled.B @ [u[k]]


def test_without_delay_it_is_what_other_programs_make_of_it():
    robot = finger()
    linear = lissom.linearise(
        robot, lissom.statics(robot, space_error=False).q, "inputs", "finger_position_z"
    )
    sampled = linear.discrete(5e-3)
    for found, expected in zip(sampled, cont2discrete(tuple(linear), 5e-3)[:4], strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)
    system = control.ss(*sampled, sampled.dt)
    assert system.dt == 5e-3
    assert sampled.states == linear.states


@pytest.mark.parametrize(
    ("dt", "delay", "match"),
    [
        (0.0, 0.0, "dt: got 0.0"),
        (float("nan"), 0.0, "dt: got nan"),
        (1e-3, -1e-3, "delay: got -0.001"),
        (1e-3, 2.0, "from zero to 1000 samples"),
    ],
)
def test_times_that_cannot_be(dt, delay, match):
    robot = finger()
    linear = lissom.linearise(robot, lissom.statics(robot, space_error=False).q, "inputs")
    with pytest.raises(ValueError, match=match):
        linear.discrete(dt, delay=delay)
    with pytest.raises(ValueError, match="in discrete time already"):
        linear.discrete(1e-3).discrete(1e-3)


@pytest.mark.parametrize("mass", [2.0, 0.02, 2e-4])
def test_contact_sensors_see_the_contact_however_shallow_it_is(mass):
    """Overlaps from 0.2 mm to 20 nm: the force is the stiffness times the overlap, and balances the load."""
    floor = lissom.Contact(lissom.Ball("ball", 0.05), lissom.HalfSpace(), stiffness=1e5, name="floor")
    robot = lissom.Robot(
        [lissom.Link("ball", body=lissom.Body(mass), joint=lissom.Prismatic((0, 0, 1)))],
        contacts=[floor],
        loads=[lissom.Load(force=lissom.Input("push", (0, 0, 0)))],
    )
    q = lissom.statics(robot, q0=[0.05]).q
    linear = lissom.linearise(robot, q, "inputs", sensors.ContactForce(robot, "floor"))
    assert linear.C[2, 0] == pytest.approx(-1e5)
    gain = linear.D - linear.C @ np.linalg.solve(linear.A, linear.B)
    np.testing.assert_allclose(gain, np.diag([0.0, 0.0, -1.0]), atol=1e-6)


def test_forces_of_tendons_that_do_not_stretch_balance_the_load():
    """A mass on a cord, beside which it can slide: T = |F + m g|, so that dT = (F + m g) . dF / T."""
    slide = lissom.Link("slide", body=lissom.Body(3.0), joint=lissom.Prismatic((1, 0, 0)))
    mass = lissom.Link("mass", parent="slide", body=lissom.Body(1.0), joint=lissom.Prismatic((0, 0, 1)))
    cord = lissom.Tendon("cord", [lissom.Via(None, (0, 0, 1)), lissom.Via("mass", (0, 0, 0))], length=1.0)
    push = lissom.Load(link="mass", force=lissom.Input("push", (0, 0, 0)))
    robot = lissom.Robot([slide, mass], actuators=[cord], loads=[push])
    u = [9.81, 0.0, 0.0]
    q = lissom.statics(robot, u=u, q0=[0.6, 0.2]).q
    linear = lissom.linearise(robot, q, "inputs", sensors.ActuatorForce(robot, "cord"), u=u)
    gain = linear.D - linear.C @ np.linalg.solve(linear.A, linear.B)
    np.testing.assert_allclose(gain, [[np.sqrt(0.5), 0.0, -np.sqrt(0.5)]], atol=1e-6)


def test_readings_with_kinks_have_no_derivative():
    turned = lissom.Link("arm", body=lissom.Body(1.0, centre=(0.5, 0, 0)), joint=lissom.Revolute((0, 1, 0)))
    robot = lissom.Robot([turned], gravity=(0, 0, 0))
    tracker = sensors.PoseTracker(robot, "arm")
    with pytest.raises(lissom.LissomError, match="kink or a jump"):
        lissom.linearise(robot, [np.pi], "forces", tracker)
    C = lissom.linearise(robot, [np.pi - 1e-7], "forces", tracker).C
    np.testing.assert_allclose(np.abs(C[3:, 0]), [0.5, 0.0, 0.0, 0.0], atol=1e-6)
    robot = finger(0.0)
    q = lissom.statics(robot, space_error=False).q
    with pytest.raises(lissom.LissomError, match="tendon without tension"):
        lissom.linearise(robot, q, "inputs", sensors.ActuatorForce(robot, "pull"))


def test_steps_beyond_numbers_are_refused():
    arm = lissom.Link("arm", body=lissom.Body(1.0, centre=(0, 0, 0.5)), joint=lissom.Revolute((0, 1, 0)))
    standing = lissom.linearise(lissom.Robot([arm]), [0.0])
    assert np.linalg.eigvals(standing.A).real.max() > 1.0
    with pytest.raises(lissom.LissomError, match="shorter dt"):
        standing.discrete(1e4)


def test_shapes_that_are_no_equilibria_are_said():
    """With the distance to the equilibrium, in any units; not where forces hold them."""
    soft = lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 3})
    rod = lissom.Rod([soft])
    rest = lissom.statics(rod).q
    # Of four digits too: no warning, which would be an error here.
    lissom.linearise(rod, rest)
    lissom.linearise(rod, rest.round(4))
    with pytest.warns(lissom.AccuracyWarning, match="q is no equilibrium: .* Take `q` of `lissom.statics"):
        found = lissom.linearise(rod, 0 * rest)
    held = lissom.linearise(rod, 0 * rest, held=True)
    np.testing.assert_array_equal(found.A, held.A)
    # Near the equilibrium the displacement is that of the tip, relative to the length.
    near = rest + np.array([0.3, 0.0, 0.0])
    apart = np.linalg.norm(rod.pose(near)[:3, 3] - rod.pose(rest)[:3, 3]) / 0.3
    with pytest.warns(lissom.AccuracyWarning) as caught:
        lissom.linearise(rod, near)
    share = float(re.search(r"by about ([\d.e-]+) of its size", str(caught[0].message))[1])
    assert share == pytest.approx(apart, rel=0.1)
    with pytest.raises(TypeError, match="held: expected True or False, got int"):
        lissom.linearise(rod, rest, held=1)


def test_what_falls_is_no_equilibrium():
    ball = lissom.Link("ball", body=lissom.Body(0.1), joint=lissom.Prismatic((0, 0, 1)))
    with pytest.warns(lissom.AccuracyWarning, match="q is no equilibrium"):
        lissom.linearise(lissom.Robot([ball]), [1.0])
    lissom.linearise(lissom.Robot([ball], gravity=(0, 0, 0)), [1.0])


def test_equilibria_of_loops_and_pendulums_are_some():
    pendulum = lissom.SpringPendulum()
    lissom.linearise(pendulum, lissom.statics(pendulum).q)
    with pytest.warns(lissom.AccuracyWarning, match="q is no equilibrium"):
        lissom.linearise(pendulum, [0.5, 0.0])
