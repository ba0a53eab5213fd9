"""`lissom.sensors` compared with closed forms, differences in time, and their own use in a loop."""

import copy
import pickle
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import lissom
from lissom import sensors

G = 9.81
SOFT = lissom.Segment(
    0.3,
    (0.012, 0.009),
    5e5,
    poisson_ratio=0.4,
    density=1100,
    modes={"torsion": 1, "bend_y": 2, "bend_z": 1, "stretch": 1, "shear_y": 1},
    reference_strain=(0.5, 1.0, -0.5, 1.0, 0.0, 0.0),
    retardation_time=0.02,
)
HAND = lissom.Body(0.05, centre=(0.02, 0.01, 0.0), inertia=(2e-5, 3e-5, 4e-5))
TURN = np.array([0.7, -0.1, 0.5, 0.5]) / np.linalg.norm([0.7, -0.1, 0.5, 0.5])


def shaken_arm(**options):
    """A rod on a hinge on a shaken base, a hand on a ball joint at its tip and a box welded inside."""
    motion = lissom.BaseMotion(
        translation=lissom.Harmonic((0.02, 0, 0.01), 3.0), axis=(1, 2, 0), angle=lissom.Harmonic(0.2, 2.0)
    )
    links = [
        lissom.Link("arm", rod=[SOFT], joint=lissom.Revolute((0, 1, 0), stiffness=1.0, damping=0.05)),
        lissom.Link("hand", parent="arm", joint=lissom.Spherical(), body=HAND),
        lissom.Link("box", parent="arm", at=0.1, position=(0, 0.02, 0), orientation=TURN, body=HAND),
    ]
    return lissom.Robot(links, base_motion=motion, **options)


ARM = shaken_arm()

#: All kinds, with general mounts.
MOUNT = {"point": (0.01, -0.02, 0.03), "orientation": TURN}
KINDS = {
    "marker": lambda **given: sensors.Marker(ARM, "box", point=(0.01, 0, 0.02), **given),
    "pose_tracker": lambda **given: sensors.PoseTracker(ARM, "hand", **MOUNT, **given),
    "velocimeter": lambda **given: sensors.Velocimeter(ARM, "arm", 0.2, **MOUNT, **given),
    "gyroscope": lambda **given: sensors.Gyroscope(ARM, "arm", 0.2, **given),
    "accelerometer": lambda **given: sensors.Accelerometer(ARM, "hand", **given),
    "imu": lambda **given: sensors.Imu(ARM, "arm", 0.2, **MOUNT, **given),
    "encoder": lambda **given: sensors.Encoder(ARM, "hand", **given),
    "tachometer": lambda **given: sensors.Tachometer(ARM, "arm", **given),
    "curvature_sensor": lambda **given: sensors.CurvatureSensor(ARM, "arm", [0.0, 0.1, 0.3], **given),
    "strain_gauge": lambda **given: sensors.StrainGauge(ARM, "arm", [0.1, 0.2], offset=(0.01, 0), **given),
    "joint_sensor": lambda **given: sensors.ForceTorque(ARM, "hand", **given),
    "section_sensor": lambda **given: sensors.ForceTorque(ARM, "arm", 0.12, **given),
}


@pytest.fixture(scope="module")
def run():
    """Times with arbitrary intervals."""
    times = np.sort(np.random.default_rng(2).uniform(0, 0.3, 80))
    done = lissom.simulate(ARM, 0.3, q0=np.linspace(-0.5, 0.4, ARM.n), rtol=1e-4, t_eval=times)
    assert done.success
    assert_array_equal(done.t, times)
    return done


def state_at(t, seed=3):
    """Coordinates as polynomials in time, and their derivatives."""
    q, v, a = np.random.default_rng(seed).normal(size=(3, ARM.n)) * [[0.3], [1.0], [5.0]]
    return q + v * t + a * t**2 / 2, v + a * t, a


def second_difference(f, t, h=2e-3):
    """Sixth-order difference."""
    weights = np.array([2, -27, 270, -490, 270, -27, 2]) / (180 * h**2)
    return sum(w * f(t + k * h) for w, k in zip(weights, range(-3, 4), strict=True))


def rotation_of(quaternion):
    """Rotation matrix by Rodrigues' formula."""
    axis = np.asarray(quaternion[1:])
    cross = np.cross(np.eye(3), axis)
    return np.eye(3) + 2 * quaternion[0] * -cross.T + 2 * cross @ cross


# Readings of ideal sensors.


@pytest.mark.parametrize(("link", "at"), [("arm", 0.2), ("arm", None), ("hand", None), ("box", None)])
def test_accelerometers_feel_the_second_difference_of_their_position_less_gravity(link, at):
    t = 0.37
    marker = sensors.Marker(ARM, link, at, point=MOUNT["point"])
    tracker = sensors.PoseTracker(ARM, link, at, **MOUNT)
    meter = sensors.Accelerometer(ARM, link, at, **MOUNT)
    acceleration = second_difference(lambda s: marker.measure(t + s, state_at(s)[0]), 0.0)
    shown = tracker.measure(t, state_at(0.0)[0])
    assert_allclose(shown[:3], marker.measure(t, state_at(0.0)[0]), rtol=1e-15)
    felt = rotation_of(shown[3:]).T @ (acceleration + np.array([0, 0, G]))
    assert_allclose(meter.measure(t, *state_at(0.0)), felt, rtol=0, atol=1e-7 * np.abs(felt).max())


@pytest.mark.parametrize(("link", "at"), [("arm", 0.2), ("arm", None), ("hand", None), ("box", None)])
def test_velocimeters_and_gyroscopes_show_first_differences(link, at):
    t, h = 0.37, 1e-5
    tracker = sensors.PoseTracker(ARM, link, at, **MOUNT)
    before, now, after = (tracker.measure(t + s, state_at(s)[0]) for s in (-h, 0, h))
    axes = rotation_of(now[3:])
    velocity = axes.T @ (after - before)[:3] / (2 * h)
    spin = axes.T @ (rotation_of(after[3:]) - rotation_of(before[3:])) / (2 * h)
    state = (t, *state_at(0.0)[:2])
    size = np.abs(velocity).max()
    assert_allclose(sensors.Velocimeter(ARM, link, at, **MOUNT).measure(*state), velocity, atol=1e-8 * size)
    turning = [spin[2, 1], spin[0, 2], spin[1, 0]]
    gyroscope = sensors.Gyroscope(ARM, link, at, orientation=TURN)
    assert_allclose(gyroscope.measure(*state), turning, atol=1e-8 * np.abs(turning).max())


def test_the_imu_of_a_pendulum():
    """A point mass on a string measures only the string's force: g cos(angle) + L rate^2."""
    length = 0.7
    bob = lissom.Body(0.1, centre=(length, 0, 0))
    pendulum = lissom.Robot([lissom.Link("bob", body=bob, joint=lissom.Revolute((0, 1, 0)))])
    assert pendulum.kernel == "planar"
    q, v = np.random.default_rng(1).uniform(-3, 3, (2, 20, 1))
    a = [pendulum.forward_dynamics(*state) for state in zip(q, v, strict=True)]
    shown = sensors.Imu(pendulum, point=(length, 0, 0)).measure(np.zeros(20), q, v, a)
    angle, rate = q[:, 0] - np.pi / 2, v[:, 0]
    expected = np.zeros_like(shown)
    expected[:, 1] = rate
    expected[:, 3] = -(G * np.cos(angle) + length * rate**2)
    assert_allclose(shown, expected, atol=1e-13)


def test_the_imu_on_a_turntable():
    spin, radius = 3.0, 0.4
    turning = lissom.BaseMotion(axis=(0, 0, 1), angle=lissom.Harmonic(0, 0, rate=spin))
    table = lissom.Robot([lissom.Link("table", body=lissom.Body(1.0))], base_motion=turning)
    imu = sensors.Imu(table, point=(0, radius, 0.1))
    for t in (0.0, 0.3, 7.1):
        assert_allclose(imu.measure(t, [], [], []), [0, 0, spin, 0, -(spin**2) * radius, G], atol=1e-12)


def test_what_falls_freely_feels_nothing_but_its_spin():
    body = lissom.Body(0.3, inertia=(1e-3, 2e-3, 3e-3))
    stone = lissom.Robot([lissom.Link("stone", body=body, joint=lissom.Free())])
    q = np.zeros(6)
    v = np.array([1.0, -2.0, 3.0, 0.0, 0.0, 5.0])
    a = stone.forward_dynamics(q, v)
    assert_allclose(sensors.Accelerometer(stone).measure(0, q, v, a), 0, atol=1e-14)
    beside = sensors.Imu(stone, point=(0.1, 0, 0.2)).measure(0, q, v, a)
    assert_allclose(beside, [0, 0, 5, -2.5, 0, 0], atol=1e-14)
    assert_allclose(sensors.Accelerometer(stone).measure(0, q, 0 * v, 0 * a), [0, 0, G], rtol=1e-15)


def test_axes_of_a_sensor_are_those_of_its_orientation():
    given = (0.2, *state_at(0.1))
    plain = sensors.Imu(ARM, "hand", point=(0.1, 0, 0)).measure(*given)
    turned = sensors.Imu(ARM, "hand", point=(0.1, 0, 0), orientation=TURN).measure(*given)
    axes = rotation_of(TURN)
    assert_allclose(turned, [*(axes.T @ plain[:3]), *(axes.T @ plain[3:])], rtol=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_trackers_show_the_orientation_as_a_quaternion(seed):
    """Rotations by any angle about any axis, including nearly half turns."""
    random = np.random.default_rng(seed)
    turn = random.normal(size=3)
    turn *= (np.pi - 10.0 ** -random.integers(0, 12)) / np.linalg.norm(turn)
    q = np.array([*random.normal(size=3), *turn])
    box = lissom.Robot([lissom.Link("box", joint=lissom.Free(), body=lissom.Body(1.0, inertia=(1, 1, 1)))])
    shown = sensors.PoseTracker(box).measure(0.0, q)
    pose = box.pose(q)
    assert_allclose(shown[:3], pose[:3, 3], rtol=1e-15)
    assert_allclose(rotation_of(shown[3:]), pose[:3, :3], atol=1e-14)
    assert shown[3] >= 0


def test_strain_gauges_show_how_a_fibre_stretches():
    """By the distance of neighbouring points of the fibre, compared with that without load."""
    X, h, offset = 0.17, 1e-4, (0.004, -0.006)
    gauge = sensors.StrainGauge(ARM, "arm", X, offset=offset)

    def distance(q):
        ends = [sensors.Marker(ARM, "arm", X + s, point=(0, *offset)).measure(0, q) for s in (-h, h)]
        return np.linalg.norm(ends[1] - ends[0])

    for seed in range(3):
        q = state_at(0.0, seed)[0]
        assert_allclose(gauge.measure(0, q), distance(q) / distance(0 * q) - 1, rtol=1e-6)
    assert_array_equal(gauge.measure(0, np.zeros(ARM.n)), 0)


def test_curvature_sensors_show_the_strains_of_bending_and_torsion():
    q = state_at(0.0)[0]
    fibre = sensors.CurvatureSensor(ARM, "arm", [0.1, 0.2])
    assert_array_equal(fibre.measure(0, q), ARM.strain(q, [0.1, 0.2], link="arm")[:, :3].ravel())
    assert fibre.channels[4] == "arm[0.1, 0.2].curvature_sensor[1].bend_y"
    tip = sensors.CurvatureSensor(ARM, "arm")
    assert_array_equal(tip.measure(0, q), ARM.strain(q, 0.3, link="arm")[:3])


def test_force_torque_sensors_are_in_joints_and_in_sections():
    given = (0.4, *state_at(0.2))
    t, *state = given
    axes = ARM.pose(state[0], link="hand", t=t)[:3, :3]
    wrench = ARM.joint_wrench(*state, link="hand", t=t)
    shown = sensors.ForceTorque(ARM, "hand").measure(*given)
    assert_allclose(shown, [*(axes.T @ wrench[:3]), *(axes.T @ wrench[3:])], rtol=1e-12)
    section = sensors.ForceTorque(ARM, "arm", 0.12).measure(*given)
    assert_array_equal(section, ARM.internal_wrench(*state, 0.12, link="arm", t=t))
    # At the base of a rod both are the same.
    both = [sensors.ForceTorque(ARM, "arm", at).measure(*given) for at in (None, 0.0)]
    assert_allclose(both[0], both[1], atol=1e-10 * np.abs(wrench).max())


def test_a_force_torque_sensor_weighs_what_hangs_on_it():
    arm = lissom.Robot(
        [
            lissom.Link("arm", joint=lissom.Revolute((0, 1, 0)), body=lissom.Body(1.0)),
            lissom.Link(
                "tool", parent="arm", position=(0.3, 0, 0), body=lissom.Body(0.2, centre=(0.1, 0, 0))
            ),
        ]
    )
    # A quarter turn about y rotates the x axis downwards.
    shown = sensors.ForceTorque(arm, "tool").measure(0, [np.pi / 2], [0], [0])
    assert_allclose(shown, [0, 0, 0, -0.2 * G, 0, 0], atol=1e-15)


SEGMENT = lissom.Segment(0.4, 0.01, 1e5, poisson_ratio=0.5, density=1000, modes={"bend_y": 4})
LYING = lissom.Robot(
    [lissom.Link("hose", rod=[SEGMENT], joint=lissom.Free())],
    contacts=[lissom.Contact("hose", lissom.HalfSpace((0, 0, -0.01)), name="floor", friction=0.3)],
)


def test_what_lies_on_a_floor_is_weighed():
    found = lissom.statics(LYING)
    assert found.success
    state = (0.0, found.q, np.zeros(LYING.n))
    weight = G * 1000 * np.pi * 0.01**2 * 0.4
    force = sensors.ContactForce(LYING)
    assert_allclose(force.measure(*state), [0, 0, weight], rtol=1e-9, atol=1e-9 * weight)
    assert_allclose(sensors.Tactile(LYING).measure(*state), [weight], rtol=1e-9)
    strip = sensors.Tactile(LYING, "floor", [0, 0.13, 0.27, 0.4])
    cells = strip.measure(*state)
    assert strip.channels == ("floor.tactile[0]", "floor.tactile[1]", "floor.tactile[2]")
    assert_allclose(cells.sum(), weight, rtol=1e-9)
    # Evenly, up to the resolution of the quadrature nodes.
    assert_allclose(cells / weight, [0.325, 0.35, 0.325], atol=0.03)
    assert_allclose(cells[0], cells[2], rtol=1e-9)
    assert_allclose(sensors.Tactile(LYING, cells=[0, 0.13]).measure(*state), cells[:1], rtol=1e-12)


def test_contact_sensors_show_friction_and_let_go():
    found = lissom.statics(LYING)
    v = np.zeros(LYING.n)
    v[0] = 0.5  # slides forward
    force, pressed = sensors.ContactForce(LYING), sensors.Tactile(LYING)
    along, _, normal = force.measure(0, found.q, v)
    assert_allclose(along, -0.3 * normal, rtol=1e-5)
    assert_allclose(pressed.measure(0, found.q, v), [normal], rtol=1e-12)
    lifted = found.q + np.eye(LYING.n)[2] * 0.1
    assert_array_equal(force.measure(0, lifted, v), np.zeros(3))
    assert_array_equal(pressed.measure(0, lifted, v), [0.0])


def test_contact_sensors_over_a_run():
    run = lissom.simulate(LYING, 0.1, dt=1e-3, q0=np.eye(LYING.n)[2] * 2e-3)
    assert run.success
    for sensor in (
        sensors.ContactForce(LYING, noise=0.1, delay=0.01),
        sensors.Tactile(LYING, cells=[0, 0.1]),
    ):
        shown = sensor.record(run)
        states = zip(run.t, run.q, run.v, strict=True)
        assert_array_equal([sensor.read(*state) for state in states], shown)
        assert shown.any()


def test_encoders_and_tachometers_have_the_coordinates_of_joints():
    q, v, _ = state_at(0.0)
    encoder = sensors.Encoder(ARM, "hand")
    assert encoder.channels == tuple(ARM.coordinates[-3:])
    assert encoder.units == ("rad",) * 3
    assert_array_equal(encoder.measure(0, q), q[-3:])
    tachometer = sensors.Tachometer(ARM, "arm.angle")
    assert (tachometer.channels, tachometer.units) == (("arm.angle.rate",), ("rad/s",))
    assert_array_equal(tachometer.measure(0, q, v), v[:1])
    slide = lissom.Robot([lissom.Link("slide", joint=lissom.Prismatic((1, 0, 0)), body=lissom.Body(1.0))])
    assert sensors.Encoder(slide).units == ("m",)
    assert sensors.Tachometer(slide).measure(0, [0.1], [0.2]) == 0.2


FINGER = lissom.Robot(
    [
        lissom.Link("palm", joint=lissom.Revolute((0, 1, 0)), body=HAND),
        lissom.Link("finger", parent="palm", rod=[SOFT]),
        lissom.Link("rail", parent="palm", joint=lissom.Prismatic((0, 1, 0)), body=HAND),
    ],
    actuators=[
        lissom.Tendon("pull", [lissom.Along("finger", (0, 0.005))], tension=lissom.Input("tension", 2.0)),
        lissom.Chamber("air", [lissom.Along("finger", (0.004, 0))], 1e-5, lissom.Input("pressure", 3e3)),
        lissom.Motor("palm", lissom.Harmonic(0.2, 1.0)),
        lissom.Motor("rail.displacement", position=0.1, gains=(30.0, 1.0)),
    ],
)


@pytest.mark.parametrize(
    ("name", "units", "force"),
    [
        ("pull", ("m", "N"), 2.0),
        ("air", ("m^3", "Pa"), 3e3),
        ("palm", ("rad", "N m"), 0.2 * np.sin(2 * np.pi * 0.1)),
        ("rail.displacement", ("m", "N"), 30 * (0.1 - 0.02) - 0.3),
    ],
)
def test_actuators_have_lengths_and_forces(name, units, force):
    q, v = 0.1 * np.random.default_rng(5).normal(size=(2, FINGER.n))
    q[-1], v[-1] = 0.02, 0.3
    length, load = (kind(FINGER, name) for kind in (sensors.ActuatorLength, sensors.ActuatorForce))
    assert (length.units, load.units) == (units[:1], units[1:])
    assert_array_equal(length.measure(0.1, q), [FINGER.actuator_length(name, q)])
    assert_allclose(load.measure(0.1, q, v), [force], rtol=1e-12)
    states = ([0.1, 0.1], [q, 2 * q], [v, v])
    assert_array_equal(load.measure(*states)[0], load.measure(0.1, q, v))
    assert length.measure(*states).shape == (2, 1)


def test_forces_follow_the_inputs():
    q = v = np.zeros(FINGER.n)
    load = sensors.ActuatorForce(FINGER, "pull")
    assert FINGER.inputs == ("tension", "pressure")
    assert load.measure(0, q, v, u=[5.0, 0.0]) == 5.0
    both = load.measure([0, 0], [q, q], [v, v], u=[[5.0, 0.0], [7.0, 0.0]])
    assert_array_equal(both, [[5.0], [7.0]])
    run = SimpleNamespace(t=np.zeros(2), q=[q, q], v=[v, v], u=[[5.0, 0.0], [7.0, 0.0]])
    assert_array_equal(load.record(run), [[5.0], [5.0]], "equal times have one sample")
    assert_array_equal(load.record(run, u=[1.0, 2.0]), [[1.0], [1.0]])
    # Loads also affect the wrench through a section.
    section = sensors.ForceTorque(FINGER, "finger", 0.1)
    pulled, slack = (section.measure(0, q, v, q, [tension, 0.0]) for tension in (5.0, 0.0))
    assert_array_equal(pulled, FINGER.internal_wrench(q, v, q, 0.1, link="finger", t=0, u=[5.0, 0.0]))
    assert pulled.shape == slack.shape == (6,)


# Loops and records.


def loop(sensor, run):
    states = zip(run.t, run.q, run.v, run.a, strict=True)
    return np.array([sensor.read(t, q, v, a) for t, q, v, a in states])


@pytest.mark.parametrize(
    "options", [{}, {"rate": 90.0}, {"delay": 0.013}, {"rate": 170.0, "delay": 0.02}], ids=str
)
@pytest.mark.parametrize("kind", KINDS)
def test_a_record_is_a_loop_to_the_bit(kind, options, run):
    sensor = KINDS[kind](**options)
    record = sensor.record(run)
    assert record.shape == (len(run.t), len(sensor.channels)) == (len(run.t), len(sensor.units))
    assert_array_equal(record, loop(sensor, run))
    assert_array_equal(record, sensor.record(run), "what is read leaves records alone")
    if not options:
        assert_array_equal(record, sensor.measure(run.t, run.q, run.v, run.a))


@pytest.mark.parametrize("kind", KINDS)
def test_so_is_one_with_noise_of_the_same_seed(kind, run):
    sensor = KINDS[kind](noise=0.1, bias=-0.2, rate=200.0, delay=0.01, seed=4)
    record = sensor.record(run)
    assert_allclose(record, loop(sensor, run), rtol=0, atol=0 if kind != "pose_tracker" else 1e-15)
    assert np.abs(record - KINDS[kind](rate=200.0, delay=0.01).record(run)).min() > 0


def test_noise_is_white_with_the_deviation_that_is_given():
    t = np.arange(20000) * 1e-3
    still = SimpleNamespace(t=t, q=np.zeros((len(t), 1)), v=np.zeros((len(t), 1)))
    hinge = lissom.Robot(
        [lissom.Link("a", joint=lissom.Revolute((0, 1, 0)), body=lissom.Body(1.0, centre=(1, 0, 0)))]
    )
    encoder = sensors.Encoder(hinge, noise=0.3, bias=2.0, seed=1)
    shown = encoder.record(still)[:, 0]
    # Five standard deviations of the estimates.
    few = 5 / np.sqrt(len(t))
    assert abs(shown.mean() - 2) < 0.3 * few
    assert abs(shown.std() - 0.3) < 0.3 * few
    correlations = [np.corrcoef(shown[:-k], shown[k:])[0, 1] for k in (1, 2, 10)]
    assert np.abs(correlations).max() < few
    other = sensors.Encoder(hinge, noise=0.3, seed=1, name="other").record(still)[:, 0]
    assert abs(np.corrcoef(shown, other)[0, 1]) < few
    again = sensors.Encoder(hinge, noise=0.3, bias=2.0, seed=1)
    assert_array_equal(again.record(still)[:, 0], shown)
    again.reset(seed=2)
    assert again.seed == 2
    assert abs(np.corrcoef(shown, again.record(still)[:, 0])[0, 1]) < few


def test_each_channel_has_noise_and_bias_of_its_own():
    imu = sensors.Imu(ARM, "hand", noise=[0, 0, 0, 0.1, 0.1, 0.1], bias=[0.2, 0, 0, 0, 0, 0])
    given = (0.0, *state_at(0.0))
    errors = imu.read(*given) - imu.measure(*given)
    assert_allclose(errors[:3], [0.2, 0, 0], atol=1e-15)
    assert (np.abs(errors[3:]) > 1e-4).all()


def test_errors_of_orientations_are_small_turns():
    given = (0.0, state_at(0.0)[0])
    turn = np.array([0.0, 0.3, -0.4])
    ideal = sensors.PoseTracker(ARM, "hand").measure(*given)
    shown = sensors.PoseTracker(ARM, "hand", bias=[1, 2, 3, *turn]).read(*given)
    assert_allclose(shown[:3] - ideal[:3], [1, 2, 3], rtol=1e-12)
    between = rotation_of(ideal[3:]).T @ rotation_of(shown[3:])
    half = np.linalg.norm(turn) / 2
    expected = rotation_of([np.cos(half), *(turn / np.linalg.norm(turn) * np.sin(half))])
    assert_allclose(between, expected, atol=1e-14)
    assert_allclose(np.linalg.norm(shown[3:]), 1, rtol=1e-15)


def clock(steps, dt=1e-3, t=0.0):
    """Times summed up with rounding errors, as in a loop."""
    times = [t]
    for _ in range(steps - 1):
        times.append(times[-1] + dt)
    return np.array(times)


def ramp(times):
    """A motion in which the encoder reads the number of the step."""
    q = np.arange(len(times), dtype=float)[:, None]
    return SimpleNamespace(t=times, q=q, v=0 * q, a=0 * q)


HINGE = lissom.Robot(
    [lissom.Link("a", joint=lissom.Revolute((0, 1, 0)), body=lissom.Body(1.0, centre=(1, 0, 0)))]
)


@pytest.mark.parametrize("start", [0.0, 123.4])
def test_samples_are_held_and_late_by_whole_steps_whatever_rounds(start):
    steps = np.arange(20000)
    motion = ramp(clock(len(steps), t=start))
    late = sensors.Encoder(HINGE, delay=7e-3).record(motion)[:, 0]
    assert_array_equal(late, np.maximum(steps - 7, 0))
    held = sensors.Encoder(HINGE, rate=200.0).record(motion)[:, 0]
    assert_array_equal(held, steps - steps % 5)
    both = sensors.Encoder(HINGE, rate=100.0, delay=3e-3).record(motion)[:, 0]
    assert_array_equal(both, np.maximum(steps - 3, 0) - np.maximum(steps - 3, 0) % 10)


def test_a_slow_loop_is_all_that_is_sampled():
    motion = ramp(clock(50, dt=0.03))
    assert_array_equal(sensors.Encoder(HINGE, rate=1000.0).record(motion), motion.q)


def test_the_ring_has_no_more_than_is_late():
    encoder = sensors.Encoder(HINGE, delay=0.01)
    motion = ramp(clock(1000))
    loop(encoder, motion)
    assert len(encoder._line.samples) <= 12


def test_a_second_reading_at_a_time_is_the_first_one():
    encoder = sensors.Encoder(HINGE, noise=1.0)
    first = encoder.read(0.1, [0.0])
    assert_array_equal(encoder.read(0.1, [5.0]), first)
    assert encoder.read(0.2, [0.0]) != first


def test_what_is_read_belongs_to_who_reads_it():
    encoder = sensors.Encoder(HINGE, rate=1.0)
    encoder.read(0.0, [1.0])[:] = 7.0
    assert encoder.read(0.1, [2.0]) == 1.0


def test_copies_and_pickles_go_on_alone():
    motion = ramp(clock(100))
    options = {"noise": 0.1, "rate": 300.0, "delay": 0.004, "seed": 3}
    whole = loop(sensors.Encoder(HINGE, **options), motion)
    half = sensors.Encoder(HINGE, **options)
    parts = [
        SimpleNamespace(**{k: x[i] for k, x in vars(motion).items()}) for i in (slice(50), slice(50, None))
    ]
    loop(half, parts[0])
    for twin in (half.copy(), copy.copy(half), copy.deepcopy(half), pickle.loads(pickle.dumps(half)), half):
        assert_array_equal(loop(twin, parts[1]), whole[50:])
    half.reset()
    assert_array_equal(loop(half, motion), whole)


def test_sensors_observe_what_has_a_state():
    imu = sensors.Imu(ARM, "hand")
    q, v, a = state_at(0.0)
    simulation = SimpleNamespace(t=0.3, q=q, v=v, a=a, u=np.empty(0))
    assert_array_equal(imu.observe(simulation), imu.measure(0.3, q, v, a))
    encoder = sensors.Encoder(ARM, "arm")
    assert encoder.observe(SimpleNamespace(t=0.3, q=q)) == q[0]
    with pytest.raises(
        TypeError, match=r"simulation: expected an object with t, q, v, a, got SimpleNamespace"
    ):
        imu.observe(SimpleNamespace(t=0.3, q=q, v=v))


def test_what_is_observed_of_a_simulation_is_the_record_of_its_run():
    def kinds():
        yield sensors.Imu(FINGER, "finger", 0.1, noise=0.1, delay=3e-3)
        yield sensors.ForceTorque(FINGER, "finger", 0.1)
        yield sensors.ActuatorForce(FINGER, "pull", rate=400.0)
        yield sensors.ActuatorLength(FINGER, "air")

    simulation = lissom.Simulation(FINGER, dt=1e-3)
    watching = list(kinds())
    seen = [[sensor.observe(simulation) for sensor in watching]]
    for _ in range(6):
        assert simulation.step() == "finished"
        seen.append([sensor.observe(simulation) for sensor in watching])
    run = lissom.simulate(FINGER, 6e-3, dt=1e-3)
    assert run.success
    for k, sensor in enumerate(kinds()):
        assert_array_equal([values[k] for values in seen], sensor.record(run))


def test_a_simulation_is_observed_as_it_is():
    simulation = lissom.Simulation(FINGER, dt=1e-3)
    load, imu = sensors.ActuatorForce(FINGER, "pull"), sensors.Imu(FINGER, "palm")
    assert load.observe(simulation) == 2.0, "the default of the input"
    for pull in (3.0, 5.0):
        assert simulation.step([pull, 0.0]) == "finished"
        assert load.observe(simulation) == pull
        state = simulation.t, simulation.q, simulation.v, simulation.a
        assert_array_equal(imu.observe(simulation), imu.measure(*state))


def test_a_run_without_accelerations_is_not_asked_for_them():
    class Run:
        t, q, v = np.zeros(1), np.zeros((1, ARM.n)), np.zeros((1, ARM.n))

        @property
        def a(self):
            raise AssertionError("not needed")

    assert sensors.Gyroscope(ARM, "hand").record(Run()).shape == (1, 3)


# Invalid input.

ON_ARM = {
    "link: got 'hnad', expected one of the links": lambda: sensors.Imu(ARM, "hnad"),
    "link: got none": lambda: sensors.Imu(ARM),
    "at: got 0.4, expected an arc length in": lambda: sensors.Imu(ARM, "arm", 0.4),
    "at: got 0.1, but link 'hand' has no rod": lambda: sensors.Marker(ARM, "hand", 0.1),
    "at: expected a number, got shape": lambda: sensors.Marker(ARM, "arm", [0.1, 0.2]),
    "at: expected 1 to 10000 numbers, got shape (0,)": lambda: sensors.StrainGauge(ARM, "arm", []),
    "'hand' has no rod": lambda: sensors.CurvatureSensor(ARM, "hand"),
    "point: expected 3 numbers": lambda: sensors.Imu(ARM, "arm", point=(1, 2)),
    "point[1]: got NaN, expected a finite number": lambda: sensors.Imu(ARM, "arm", point=(1, np.nan, 0)),
    "orientation: got a quaternion of norm 2": lambda: sensors.Imu(ARM, "arm", orientation=(2, 0, 0, 0)),
    "actuator: got 'pul', expected one of the actuators: 'pull', 'air'": lambda: sensors.ActuatorForce(
        FINGER, "pul"
    ),
    "actuator: got None, expected one of the actuators: none": lambda: sensors.ActuatorLength(ARM),
    "contact: got None, expected one of the contacts: none in this robot": lambda: sensors.Tactile(ARM),
    "contact: got 'flor', expected one of the contacts: 'floor'": lambda: sensors.ContactForce(LYING, "flor"),
    "cells: got [0, 0], expected two or more arc lengths": lambda: sensors.Tactile(LYING, cells=[0, 0]),
    "offset: expected 2 numbers": lambda: sensors.StrainGauge(ARM, "arm", 0.1, offset=0.1),
    "joint: got 'arm.bend_y[0]', expected a link whose joint": lambda: sensors.Encoder(ARM, "arm.bend_y[0]"),
    "joint: got 'box', expected": lambda: sensors.Encoder(ARM, "box"),
    "joint: got None, expected": lambda: sensors.Tachometer(ARM),
    "noise: expected a number or 6, got shape (2,)": lambda: sensors.Imu(ARM, "arm", noise=[1, 2]),
    "noise: got (-1.0": lambda: sensors.Imu(ARM, "arm", noise=-1),
    "bias: expected a number or 3": lambda: sensors.Marker(ARM, "arm", bias=[1, 2]),
    "rate: got 0.0, expected samples per second": lambda: sensors.Marker(ARM, "arm", rate=0),
    "delay: got -1.0, expected seconds": lambda: sensors.Marker(ARM, "arm", delay=-1),
    "delay: got inf, expected a finite number": lambda: sensors.Marker(ARM, "arm", delay=np.inf),
    "seed: got -1, expected a whole number, not negative": lambda: sensors.Marker(ARM, "arm", seed=-1),
    "seed: expected a whole number, got float": lambda: sensors.Marker(ARM, "arm", seed=0.5),
    "robot: expected a Robot, got Link": lambda: sensors.Marker(ARM.links[0]),
}


@pytest.mark.parametrize("message", ON_ARM)
def test_bad_sensors_are_refused(message):
    with pytest.raises((ValueError, TypeError)) as caught:
        ON_ARM[message]()
    assert message in str(caught.value)


Q = np.zeros(ARM.n)
READINGS = {
    "q: expected shape (10,) or (k, 10), got (2,)": lambda imu: imu.measure(0, [1, 2], Q, Q),
    "q: expected one state, got 2": lambda imu: imu.read([0, 0], [Q, Q], [Q, Q], [Q, Q]),
    "v: got none, expected the velocities: hand.imu needs them": lambda imu: imu.read(0, Q),
    "a: got none, expected the accelerations": lambda imu: imu.read(0, Q, Q),
    "a: expected shape (10,)": lambda imu: imu.measure(0, Q, Q, [Q]),
    "t: expected shape (2,)": lambda imu: imu.measure(0, [Q, Q], [Q, Q], [Q, Q]),
    "v[1, 3]: got NaN, expected a finite number": lambda imu: imu.measure(
        [0, 0], [Q, Q], [Q, bad(3)], [Q, Q]
    ),
    "t: got inf, expected a finite number": lambda imu: imu.read(np.inf, Q, Q, Q),
    "q[0]: expected a real number, got True": lambda imu: imu.read(0, [True, *Q[1:]], Q, Q),
    "result.t: expected times that do not decrease": lambda imu: imu.record(
        SimpleNamespace(t=[1, 0], q=[Q, Q], v=[Q, Q], a=[Q, Q])
    ),
    "a: expected shape (10,), as the coordinates ask for, got shape ()": lambda imu: sensors.Encoder(
        ARM, "arm"
    ).read(0, Q, a=0.0),
    "result: expected many states": lambda imu: imu.record(SimpleNamespace(t=1, q=Q, v=Q, a=Q)),
    "u: expected shape (m,) or (2, m), got (3, 1)": lambda imu: imu.measure(
        [0, 0], [Q, Q], [Q, Q], [Q, Q], [[1], [2], [3]]
    ),
}


def bad(i):
    v = Q.copy()
    v[i] = np.nan
    return v


@pytest.mark.parametrize("message", READINGS)
def test_bad_readings_are_refused(message):
    with pytest.raises((ValueError, TypeError)) as caught:
        READINGS[message](sensors.Imu(ARM, "hand"))
    assert message in str(caught.value)


def test_time_runs_forwards_until_a_reset_and_a_bad_reading_changes_nothing():
    encoder = sensors.Encoder(HINGE)
    encoder.read(0.2, [1.0])
    with pytest.raises(ValueError, match=r"t: got 0\.1, before the last reading at 0\.2"):
        encoder.read(0.1, [2.0])
    with pytest.raises(ValueError, match=r"q\[0\]: got NaN"):
        encoder.read(0.3, [np.nan])
    assert encoder.read(0.25, [3.0]) == 3.0
    encoder.reset()
    assert encoder.read(0.1, [2.0]) == 2.0
    moving = sensors.Marker(ARM, "hand", delay=0.1)
    moving.read(0.0, Q)
    before = list(moving._line.samples)
    with pytest.raises(lissom.LissomError, match="NaN or infinite"):
        moving.read(0.1, Q + 1e300)
    assert len(moving._line.samples) == len(before)
    assert moving._line.last == 0.0


def test_names_say_kind_and_place():
    assert sensors.Imu(ARM, "hand").channels[0] == "hand.imu.angular_velocity_x"
    assert sensors.ForceTorque(ARM, "arm", 0.12).name == "arm[0.12].force_torque"
    assert sensors.Marker(lissom.Rod([SOFT])).channels == ("rod.marker.x", "rod.marker.y", "rod.marker.z")
    assert sensors.Imu(ARM, "hand", name="head").channels[5] == "head.specific_force_z"
    with pytest.raises(AttributeError):
        sensors.Imu(ARM, "hand").noise = 1.0
