"""Rods on a moving base."""

import copy
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lissom
from reference import moving
from reference import rod as reference
from rod_cases import drift, quaternion, turn

ARM = {
    "length": 0.6,
    "radius": 0.02,
    "young_modulus": 1e6,
    "shear_modulus": 4e5,
    "density": 1100.0,
    "modes": {"torsion": 1, "bend_y": 2, "bend_z": 1, "stretch": 1, "shear_y": 1},
}
FLAT = {**ARM, "modes": {"bend_z": 3, "stretch": 1}}
WEIGHTLESS = (0.0, 0.0, 0.0)


def rod_of(motion, segment=ARM, **options):
    return lissom.Rod([lissom.Segment(**segment)], base_motion=motion, **options)


def states(n, seed=1, size=0.3):
    return size * np.random.default_rng(seed).standard_normal((3, n))


TIMES = np.linspace(0.0, 2.0, 401)
WILD = {
    "table": lissom.BaseMotion(
        translation=(TIMES, [drift(t) for t in TIMES]), rotation=(TIMES, [quaternion(t) for t in TIMES])
    ),
    "callable": lissom.BaseMotion(translation=drift, rotation=quaternion),
}


# ------------------------------------------------------------------------------------- against the reference


@pytest.mark.parametrize("form", WILD)
def test_forces_are_those_of_dalembert_in_the_world(form):
    gravity, t, tip_mass = (1.0, -2.0, -9.0), 0.7, 0.3
    rod = rod_of(WILD[form], gravity=gravity, tip_mass=tip_mass)
    q, v, a = states(rod.n)
    shape = reference.Rod([reference.Segment(**ARM)])
    base = moving.pose(drift, turn)
    wanted = moving.generalised_forces(shape, base, q, v, a, t, tip_mass, gravity)
    found = rod.inverse_dynamics(q, v, a, t=t)
    at_rest = rod_of(None, gravity=gravity, tip_mass=tip_mass).inverse_dynamics(q, v, a)
    of_base = abs(found - at_rest)
    assert (of_base > [1e-3, 0.1, 0.1, 0.1, 1.0, 1.0]).all(), "the motion of the base matters"
    np.testing.assert_allclose(found, wanted, atol=1e-5 * of_base.max())


@pytest.mark.parametrize("segments", [1, 4])
def test_tangents_are_derivatives(segments):
    part = {**ARM, "length": ARM["length"] / segments}
    loads = [
        lissom.Load(force=(0.1, 0.2, -0.3), moment=(0.01, 0, 0.02)),
        lissom.Load(force=lissom.Harmonic((0.3, 0, 0.1), 2.0), along=(0.1, 0.4)),
    ]
    rod = lissom.Rod([lissom.Segment(**part)] * segments, base_motion=WILD["table"], loads=loads)
    x, t, h = states(rod.n), 0.4, 1e-5
    found = rod.tangent(*x, t=t)
    for which, tangent in enumerate(found):
        step = np.zeros_like(x)
        for j in range(rod.n):
            step[which] = h * np.eye(rod.n)[j]
            plus, minus = rod.inverse_dynamics(*(x + step), t=t), rod.inverse_dynamics(*(x - step), t=t)
            np.testing.assert_allclose(
                tangent[:, j], (plus - minus) / (2 * h), atol=1e-6 * abs(tangent).max()
            )


def test_poses_and_jacobians_are_those_of_the_base_at_the_time():
    rod = rod_of(WILD["callable"], base_position=(1.0, 2.0, 3.0), base_orientation=(0.8, 0.0, 0.6, 0.0))
    fixed = rod_of(None, base_orientation=(0.8, 0.0, 0.6, 0.0))
    q, _, _ = states(rod.n)
    places = [0.0, 0.25, 0.6]
    times = np.array([0.0, 0.5, 1.1])
    found = rod.pose([q, q, 2 * q], places, t=times)
    for k, t in enumerate(times):
        R = Rotation.from_rotvec(turn(t)).as_matrix()
        shape = fixed.pose([q, q, 2 * q][k], places)
        np.testing.assert_allclose(found[k, :, :3, :3], R @ shape[:, :3, :3], atol=1e-12)
        wanted = shape[:, :3, 3] @ R.T + [1.0, 2.0, 3.0] + drift(t)
        np.testing.assert_allclose(found[k, :, :3, 3], wanted, atol=1e-12)
        np.testing.assert_array_equal(rod.pose([q, q, 2 * q][k], places, t=t), found[k])
        turned = np.kron(np.eye(2), R) @ fixed.jacobian(q, 0.25)
        np.testing.assert_allclose(rod.jacobian(q, 0.25, t=t), turned, atol=1e-12)


def test_where_a_rod_on_a_moving_base_is_takes_a_time():
    moving, still = rod_of(WILD["table"]), rod_of(None)
    q, v, a = states(moving.n)
    asked = {
        "pose": (q, 0.3),
        "jacobian": (q, 0.3),
        "velocity": (q, v, 0.3),
        "base_wrench": (q, v, a),
        "energy": (q, v),
        "dissipated_power": (q, v),
    }
    for name, arguments in asked.items():
        with pytest.raises(TypeError, match="t: got none, expected the time of the state in seconds"):
            getattr(moving, name)(*arguments)
        getattr(moving, name)(*arguments, t=0.3)
        getattr(still, name)(*arguments)
    with pytest.raises(TypeError, match="t: got none"):
        moving.pose([q, q], [0.1, 0.3])
    held = rod_of(lissom.BaseMotion(translation=(1, 2, 3), axis=(0, 0, 1), angle=[0.3]))
    for name, arguments in asked.items():
        getattr(held, name)(*arguments)


# ------------------------------------------------------------------------------------------- exact statements


def test_a_rod_in_free_fall_is_weightless_to_the_last_bit():
    gravity = (0.0, 0.5, -9.81)

    def falling(t):
        g = np.array(gravity)
        return 0.5 * g * t * t, g * t, g

    rod, weightless = (
        rod_of(lissom.BaseMotion(translation=falling), gravity=gravity),
        rod_of(None, gravity=WEIGHTLESS),
    )
    q, v, a = states(rod.n)
    for t in (0.0, 0.3, 50.0):
        np.testing.assert_array_equal(
            rod.inverse_dynamics(q, v, a, t=t), weightless.inverse_dynamics(q, v, a)
        )
    runs = [lissom.simulate(robot, 0.05, q0=q, dt=1e-3) for robot in (rod, weightless)]
    assert all(run.success for run in runs)
    np.testing.assert_array_equal(runs[0].q, runs[1].q)


def test_a_base_of_constant_velocity_changes_nothing_but_the_place():
    flying = lissom.BaseMotion(translation=lissom.Harmonic(rate=(100.0, -7000.0, 3.0)))
    rod, fixed = rod_of(flying), rod_of(None)
    q, v, a = states(rod.n)
    np.testing.assert_array_equal(rod.inverse_dynamics(q, v, a, t=2.0), fixed.inverse_dynamics(q, v, a))
    shift = rod.pose(q, 0.6, t=2.0)[:3, 3] - fixed.pose(q, 0.6)[:3, 3]
    np.testing.assert_allclose(shift, [200.0, -14000.0, 6.0], rtol=1e-12)
    motion = lissom.simulate(rod, 0.05, q0=q, dt=1e-3)
    assert motion.balance.drift < 1e-3


def test_planar_and_spatial_kernels_agree_on_a_base_in_the_plane():
    spin = lissom.BaseMotion(
        translation=lissom.Harmonic((0.1, 0.2, 0.0), 1.0),
        axis=(0, 0, 2),
        angle=lissom.Harmonic(0.5, 0.7, rate=2.0),
    )
    angle = lissom.Harmonic(0.5, 0.7, rate=2.0)

    def as_quaternion(t):
        value = 2.0 * t + 0.5 * np.sin(2 * np.pi * 0.7 * t)
        return np.cos(value / 2), 0.0, 0.0, np.sin(value / 2)

    same = lissom.BaseMotion(translation=spin.translation, rotation=as_quaternion)
    assert spin.angle == angle
    load = lissom.Load(force=(0.1, 0.2, 0.3), moment=(0.0, 0.0, 0.02))
    planar, spatial = (rod_of(motion, FLAT, loads=[load], tip_mass=0.1) for motion in (spin, same))
    assert (planar.kernel, spatial.kernel) == ("planar", "spatial")
    assert "may leave the plane" in spatial.explain()
    q, v, a = states(planar.n)
    t = 0.6
    for ask in ("inverse_dynamics", "tangent", "base_wrench"):
        found, wanted = (getattr(rod, ask)(q, v, a, t=t) for rod in (planar, spatial))
        np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-6)
    for part in ("kinetic", "gravitational", "loads"):
        found, wanted = (getattr(rod.energy(q, v, t=t), part) for rod in (planar, spatial))
        assert found == pytest.approx(wanted, rel=1e-7, abs=1e-7)
    assert planar.supplied_power(q, v, a, t=t) == pytest.approx(
        spatial.supplied_power(q, v, a, t=t), rel=1e-6
    )
    aside = lissom.BaseMotion(axis=(0, 1, 0), angle=lissom.Harmonic(0.1, 1.0))
    assert rod_of(aside, FLAT).kernel == "spatial"
    assert rod_of(lissom.BaseMotion(translation=([0, 1], [[0, 0, 0], [0, 0, 1]])), FLAT).kernel == "spatial"


def test_table_harmonic_and_callables_give_the_same_motion():
    harmonic = lissom.Harmonic((0.02, 0.0, 0.05), 1.5, phase=0.2)
    omega = 2 * np.pi * 1.5

    def with_derivatives(t):
        amplitude, angle = np.array([0.02, 0.0, 0.05]), omega * t + 0.2
        return (
            amplitude * np.sin(angle),
            amplitude * omega * np.cos(angle),
            -amplitude * omega**2 * np.sin(angle),
        )

    times = np.linspace(0.0, 0.5, 301)
    table = (times, [with_derivatives(t)[0] for t in times])
    found = []
    for translation in (harmonic, with_derivatives, lambda t: with_derivatives(t)[0], table):
        rod = rod_of(lissom.BaseMotion(translation=translation), FLAT)
        found.append(lissom.simulate(rod, 0.4, method="radau", rtol=1e-7, atol=1e-7, t_eval=[0.4]).q[0])
    np.testing.assert_allclose(found[1], found[0], atol=1e-9)
    np.testing.assert_allclose(found[2], found[0], atol=1e-6)
    np.testing.assert_allclose(found[3], found[0], atol=1e-4 * abs(found[0]).max())


def test_rotations_with_given_angular_velocities_are_those_by_differences():
    def about_z(t):
        angle = 0.7 * t**2
        half = angle / 2
        return (np.cos(half), 0, 0, np.sin(half)), (0, 0, 1.4 * t), (0, 0, 1.4)

    def flipping(t):
        return (-1) ** int(1000 * t) * np.array(about_z(t)[0])

    rods = [
        rod_of(lissom.BaseMotion(rotation=about_z)),
        rod_of(lissom.BaseMotion(rotation=lambda t: about_z(t)[0])),
        rod_of(lissom.BaseMotion(rotation=flipping)),
        rod_of(lissom.BaseMotion(axis=(0, 0, 1), angle=lambda t: 0.7 * t**2)),
        rod_of(lissom.BaseMotion(axis=(0, 0, 3), angle=lambda t: (0.7 * t**2, 1.4 * t, 1.4))),
    ]
    x = states(rods[0].n)
    wanted = rods[0].inverse_dynamics(*x, t=0.9)
    for rod in rods[1:]:
        np.testing.assert_allclose(rod.inverse_dynamics(*x, t=0.9), wanted, atol=1e-7 * abs(wanted).max())


# ------------------------------------------------------------------------------------------- energy


@pytest.mark.parametrize("form", WILD)
def test_energy_grows_by_the_power_through_the_base(form):
    """dE/dt = power of base and loads + tau . qd along any motion; dE/dt by differences."""
    loads = [lissom.Load(force=(0.1, 0.2, -0.3)), lissom.Load(force=(0.3, 0, 0.1), at=0.3, frame="body")]
    body = lissom.Body(0.1, at=0.4, centre=(0.02, 0.01, 0.0), inertia=(1e-4, 2e-4, 2e-4))
    rod = rod_of(WILD[form], loads=loads, bodies=[body])
    q, v, a = states(rod.n)
    t, h = 0.8, 1e-3
    energy = [
        rod.energy(q + v * s + 0.5 * a * s * s, v + a * s, t=t + s).total for s in (-2 * h, -h, h, 2 * h)
    ]
    rate = np.dot([1, -8, 8, -1], energy) / (12 * h)
    power = rod.supplied_power(q, v, a, t=t) + v @ rod.inverse_dynamics(q, v, a, t=t)
    assert power == pytest.approx(rate, rel=1e-6)


@pytest.mark.parametrize("method", ["radau", "dop853"])
def test_the_balance_of_a_shaken_motion_closes(method):
    damped = {**ARM, "retardation_time": 0.01, "modes": {"bend_y": 2, "bend_z": 1, "torsion": 1}}
    rod = rod_of(WILD["table"], damped, loads=[lissom.Load(force=lissom.Harmonic((0, 0.1, 0), 3.0))])
    found = lissom.simulate(rod, 0.5, method=method, dt=0.05, rtol=1e-8, atol=1e-9).balance
    assert abs(found.work[-1]) > 0.01 * found.scale
    assert found.drift < 1e-5


def test_the_balance_of_fixed_steps_closes_with_their_order():
    rod = rod_of(WILD["table"], {**ARM, "modes": {"bend_y": 2, "torsion": 1}})
    drifts = [lissom.simulate(rod, 0.3, dt=dt, rtol=1e-10).balance.drift for dt in (2e-3, 1e-3)]
    assert drifts[0] < 1e-2
    assert drifts[1] < 0.3 * drifts[0]


def test_the_wrench_of_the_base_holds_a_rod_at_rest_and_one_that_turns():
    mass = 1100.0 * np.pi * 0.02**2 * 0.6
    rod = rod_of(None, FLAT)
    rest = np.zeros(rod.n)
    moment, force = rod.base_wrench(rest, rest, rest).reshape(2, 3)
    np.testing.assert_allclose(force, [0, 0, 9.81 * mass], atol=1e-10)
    np.testing.assert_allclose(moment, [0, -0.3 * 9.81 * mass, 0], atol=1e-10)
    turning = rod_of(
        lissom.BaseMotion(axis=(0, 0, 1), angle=lissom.Harmonic(rate=4.0)), FLAT, gravity=WEIGHTLESS
    )
    force = turning.base_wrench(rest, rest, rest, t=np.pi / 8)[3:]
    np.testing.assert_allclose(force, [0, -mass * 16.0 * 0.3, 0], atol=1e-9)


# ------------------------------------------------------------------------------------------- known answers


def test_a_turning_rod_stretches_as_centrifugal_force_asks():
    """EA u' = rho A w^2 (L^2 - x^2) / 2 for small strains: the tip moves by rho w^2 L^3 / (3 E)."""
    stiff = {**FLAT, "young_modulus": 1e9, "shear_modulus": 4e8, "modes": {"stretch": 3}}
    omega = 5.0
    rod = rod_of(
        lissom.BaseMotion(axis=(0, 1, 0), angle=lissom.Harmonic(rate=omega)), stiff, gravity=WEIGHTLESS
    )
    found = lissom.statics(rod, t=0.3)
    longer = np.linalg.norm(rod.pose(found.q, 0.6, t=0.3)[:3, 3]) - 0.6
    assert longer == pytest.approx(1100.0 * omega**2 * 0.6**3 / 3e9, rel=1e-4)


@pytest.mark.parametrize(
    ("speed", "frequency"), [(0.0, 3.5160), (2.0, 4.1373), (6.0, 7.3604), (12.0, 13.1702)]
)
def test_frequencies_of_a_turning_beam_are_the_published_ones(speed, frequency):
    """Flapping of a uniform clamped beam without hub, frequencies and speeds times L^2 sqrt(rho A / EI).

    Wright, Smith, Thresher and Wang 1982, Vibration modes of centrifugally stiffened beams, J. Appl. Mech.
    """
    slender = {**FLAT, "radius": 1e-3, "young_modulus": 1e9, "shear_modulus": 4e8, "modes": {"bend_y": 6}}
    unit = np.sqrt(1e9 * 1e-6 / 4 / 1100.0) / 0.6**2
    motion = lissom.BaseMotion(axis=(0, 0, 1), angle=lissom.Harmonic(rate=speed * unit))
    rod = rod_of(motion, slender, gravity=WEIGHTLESS)
    found = lissom.modes(rod, np.zeros(rod.n)).angular_frequency[0] / unit
    assert found == pytest.approx(frequency, rel=2e-4)


@pytest.mark.parametrize(
    ("speed", "damping", "stability"),
    [
        (0.0, 0.0, "stable"),
        (0.5, 0.0, "stable"),
        (1.5, 0.0, "stable"),
        (0.5, 1e-3, "stable"),
        (1.5, 1e-3, "flutter"),
    ],
)
def test_a_round_shaft_whirls_above_its_critical_speed_where_it_is_damped(speed, damping, stability):
    """The shaft sees omega -+ Omega; internal damping excites the slow whirl (Kimball 1924)."""
    segment = {**ARM, "modes": {"bend_y": 3, "bend_z": 3}, "retardation_time": damping}
    slow = lissom.modes(rod_of(None, segment, gravity=WEIGHTLESS), np.zeros(6)).angular_frequency[0]
    motion = lissom.BaseMotion(axis=(1, 0, 0), angle=lissom.Harmonic(rate=speed * slow))
    rod = rod_of(motion, segment, gravity=WEIGHTLESS)
    found = lissom.statics(rod)
    modes = lissom.modes(rod, found.q)
    if damping == 0:
        assert modes.angular_frequency[0] == pytest.approx(abs(1 - speed) * slow, rel=1e-2)
    assert found.stability == found.path.stability[-1] == stability
    assert found.is_stable == modes.is_stable
    assert (found.lowest_eigenvalue < 0) == (speed > 1)
    assert ("Without damping, drag and Coriolis forces" in found.message) == (speed > 1)


def test_a_shaft_of_one_plane_is_flung_out_above_its_critical_speed():
    """Without the other plane there are no Coriolis forces for stabilisation."""
    segment = {**ARM, "modes": {"bend_y": 3}}
    slow = lissom.modes(rod_of(None, segment, gravity=WEIGHTLESS), np.zeros(3)).angular_frequency[0]
    motion = lissom.BaseMotion(axis=(1, 0, 0), angle=lissom.Harmonic(rate=1.5 * slow))
    rod = rod_of(motion, segment, gravity=WEIGHTLESS)
    found = lissom.statics(rod)
    assert found.stability == "divergence"
    assert not lissom.modes(rod, found.q).is_stable


def _tip(rod, q, t):
    """Velocity and angular velocity of the tip for a constant shape, by differences of poses."""
    step = 1e-4
    before, now, after = (rod.pose(q, rod.length, t=t + dt) for dt in (-step, 0.0, step))
    rate = (after - before) / (2 * step)
    spin = rate[:3, :3] @ now[:3, :3].T
    return np.array([*rate[:3, 3], spin[2, 1], spin[0, 2], spin[1, 0]])


@pytest.mark.parametrize(
    "motion", [lissom.BaseMotion(axis=(0, 0, 1), angle=lissom.Harmonic(rate=10.0)), WILD["callable"]]
)
def test_linear_models_see_velocities_of_a_turning_base(motion):
    rod = rod_of(motion, base_position=(1.0, 2.0, 3.0), base_orientation=(0.8, 0.0, 0.6, 0.0))
    (q, qd, _), t, step = states(rod.n), 0.7, 1e-4
    wanted = np.transpose(
        [(_tip(rod, q + d, t) - _tip(rod, q - d, t)) / (2 * step) for d in step * np.eye(rod.n)]
    )
    outputs = ["tip_velocity", "tip_angular_velocity"]
    linear = lissom.linearise(rod, q, outputs=outputs, t=t, held=True)
    jacobian = rod.jacobian(q, rod.length, t=t)
    assert np.abs(linear.C[:3, : rod.n]).max() > 0.1
    np.testing.assert_allclose(linear.C[:, : rod.n], wanted, atol=1e-5)
    np.testing.assert_array_equal(linear.C[:, rod.n :], jacobian[[3, 4, 5, 0, 1, 2]])
    velocity = rod.velocity(q, qd, rod.length, t=t)
    np.testing.assert_allclose(velocity - jacobian @ qd, _tip(rod, q, t)[[3, 4, 5, 0, 1, 2]], atol=1e-5)


def test_velocities_are_asked_for_along_the_rod_only():
    rod = rod_of(None)
    with pytest.raises(ValueError, match=r"X: got 0.7, expected an arc length in .0, 0.6."):
        rod.velocity(np.zeros(rod.n), np.zeros(rod.n), 0.7)
    with pytest.raises(ValueError, match="qd: expected 6 values, got 1"):
        rod.velocity(np.zeros(rod.n), [0.0], 0.1)


# ------------------------------------------------------------------------------------------- derivatives


@pytest.mark.parametrize("hertz", [0.3, 20.0, 120.0, 500.0, 1000.0, 12_345.0])
def test_callables_are_right_at_every_frequency(hertz):
    """Forces on the shaken rod, compared with those of the harmonic."""
    amplitude = (1e-4, 0.0, 2e-4)
    harmonic = lissom.Harmonic(amplitude, hertz, phase=0.4)

    def shaken(t):
        return np.array(amplitude) * np.sin(2 * np.pi * hertz * t + 0.4)

    def turned(t):
        angle = 1e-3 * np.sin(2 * np.pi * hertz * t)
        return np.cos(angle / 2), 0.0, np.sin(angle / 2), 0.0

    rest = np.zeros(6)
    pairs = [
        ({"translation": harmonic}, {"translation": shaken}),
        ({"axis": (0, 1, 0), "angle": lissom.Harmonic(1e-3, hertz)}, {"rotation": turned}),
    ]
    for right, prescribed in pairs:
        rods = [rod_of(lissom.BaseMotion(**motion), gravity=WEIGHTLESS) for motion in (right, prescribed)]
        for t in (0.0, 0.0123, 3.3):
            wanted, found = (rod.inverse_dynamics(rest, rest, rest, t=t) for rod in rods)
            size = abs(rods[0].inverse_dynamics(rest, rest, rest, t=0.25 / hertz)).max()
            np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-5 * size + 1e-7)


KINKS = {
    "velocity jumps": lambda t: (0.0, 0.0, 0.1 * abs(t - 0.05)),
    "jumps": lambda t: (0.0, 0.0, 1e-3 * (t >= 0.05)),
    "noise": lambda t: (0.0, 0.0, 1e-6 * np.sin(1e9 * (t % 0.1) ** 2) * (t > 0.02)),
}


@pytest.mark.parametrize("what", KINKS)
def test_motions_without_derivatives_are_refused_and_nothing_is_lost(what):
    rod = rod_of(lissom.BaseMotion(translation=KINKS[what]), FLAT)
    message = r"translation\(t\): got a function without derivatives at t = 0\.0"
    with pytest.raises(ValueError, match=message) as caught:
        lissom.simulate(rod, 0.1, dt=1e-2)
    result = caught.value.result
    assert result.t[0] == 0.0
    assert result.t[-1] == pytest.approx(0.01 if what == "noise" else 0.04)
    assert np.isfinite(result.q).all()
    for ask in (
        lambda: rod.pose(np.zeros(rod.n), 0.1, t=0.05),
        lambda: lissom.statics(rod, t=0.05),
        lambda: lissom.simulate(rod, 0.1, t0=0.05, method="radau"),
        lambda: lissom.simulate(rod, 0.1, t0=0.05, method="auto"),
    ):
        with pytest.raises(ValueError, match=r"without derivatives at t = 0\.05"):
            ask()


def test_where_the_acceleration_jumps_a_motion_goes_on():
    """From rest to constant acceleration and then to constant speed, as a user would write it."""

    def ramp(t):
        s = min(max(t - 0.02, 0.0), 0.05)
        return (0.0, 0.0, 2.0 * s * s + 4.0 * 0.05 * max(t - 0.07, 0.0))

    def with_derivatives(t):
        s = min(max(t - 0.02, 0.0), 0.05)
        return ramp(t), (0.0, 0.0, 4.0 * s), (0.0, 0.0, 4.0 if 0.02 <= t < 0.07 else 0.0)

    found = [
        lissom.simulate(
            rod_of(lissom.BaseMotion(translation=f), {**FLAT, "modes": {"bend_y": 2}}), 0.1, dt=1e-3
        )
        for f in (ramp, with_derivatives)
    ]
    assert found[0].success
    assert found[1].success
    np.testing.assert_allclose(found[0].q, found[1].q, atol=0.03 * abs(found[1].q).max())


def _contradicting(wrong):
    def translation(t):
        x = np.array([0.0, 0.01 * np.sin(20 * t), 0.0])
        v = np.array([0.0, 0.2 * np.cos(20 * t), 0.0])
        a = np.array([0.0, -4.0 * np.sin(20 * t), 0.0])
        return wrong(t, x, v, a)

    return translation


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda t, x, v, a: (x, 1.01 * v, a), "a value and a velocity that contradict each other at t = 0"),
        (lambda t, x, v, a: (x, v, -a if t > 0 else a), "a value and an acceleration that contradict"),
        (lambda t, x, v, a: (x, v, a + 10.0 * (t > 0.03)), "a value and an acceleration that contradict"),
        (lambda t, x, v, a: (x, a, v), "contradict each other at t = 0"),
        (lambda t, x, v, a: (x, v, a * (np.nan if t > 0.03 else 1)), "got NaN at t = 0.03"),
        (lambda t, x, v, a: (x, [0, np.inf, 0], a), "got inf at t = 0,"),
    ],
)
@pytest.mark.parametrize("method", ["newmark", "dop853"])
def test_derivatives_that_contradict_the_values_are_refused(wrong, message, method):
    rod = rod_of(lissom.BaseMotion(translation=_contradicting(wrong)), FLAT)
    with pytest.raises(ValueError, match=message):
        lissom.simulate(rod, 0.1, dt=1e-3, method=method)
    right = rod_of(lissom.BaseMotion(translation=_contradicting(lambda t, *x: x)), FLAT)
    assert lissom.simulate(right, 0.1, dt=1e-3, method=method).success


def test_orientations_of_functions_are_orientations_at_every_time():
    def long(t):
        return np.array(quaternion(t)) * (1.0 if t < 0.03 else 1.1)

    rod = rod_of(lissom.BaseMotion(rotation=long))
    with pytest.raises(
        ValueError,
        match=r"rotation\(t\): got a quaternion of norm 1\.1.* expected a quaternion .w, x, y, z. of norm 1",
    ):
        lissom.simulate(rod, 0.1, dt=1e-2)
    with pytest.raises(ValueError, match="a quaternion of norm 2"):
        rod_of(lissom.BaseMotion(rotation=lambda t: ((0, 2.0, 0, 0), (0, 0, 0), (0, 0, 0)))).pose(
            np.zeros(6), 0.1, t=0
        )

    def spun(t):
        return quaternion(t), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)

    with pytest.raises(ValueError, match="contradict each other"):
        lissom.simulate(rod_of(lissom.BaseMotion(rotation=spun)), 0.1)


def test_values_that_are_not_finite_name_the_time():
    rod = rod_of(lissom.BaseMotion(translation=lambda t: (0, 0, np.nan if t > 0.0501 else 0.1 * t)), FLAT)
    with pytest.raises(
        ValueError, match=r"translation\(t\): got NaN at t = 0\.06, expected finite numbers"
    ) as caught:
        lissom.simulate(rod, 0.1, dt=1e-2)
    assert caught.value.result.t[-1] == pytest.approx(0.05)
    with pytest.raises(ValueError, match="got inf at t = 1"):
        rod_of(lissom.BaseMotion(axis=(0, 0, 1), angle=lambda t: np.inf)).pose(np.zeros(6), 0.1, t=1.0)


# ------------------------------------------------------------------------------------------- callables, data


class Broken(Exception):
    pass


def test_exceptions_of_callables_come_through_and_they_may_ask_their_rod():
    def translation(t):
        rod.pose(np.zeros(rod.n), 0.1, t=0.0) if t > 0.5 else None
        if t > 0.02:
            raise Broken
        return (0.0, 0.0, 0.01 * t)

    rod = rod_of(lissom.BaseMotion(translation=translation), FLAT)
    for method in ("newmark", "radau", "rk45", "auto"):
        with pytest.raises(Broken):
            lissom.simulate(rod, 0.1, method=method)
    rest = np.zeros(rod.n)
    for ask in (
        lambda: rod.pose(rest, 0.1, t=0.1),
        lambda: rod.jacobian(rest, 0.1, t=0.1),
        lambda: rod.base_wrench(rest, rest, rest, t=0.1),
        lambda: rod.energy(rest, rest, t=0.1),
        lambda: lissom.statics(rod, t=0.1),
    ):
        with pytest.raises(Broken):
            ask()
    assert lissom.simulate(rod, 0.01, dt=5e-3).success


def test_a_table_must_cover_the_run():
    rod = rod_of(lissom.BaseMotion(translation=([0.0, 1.0], [[0, 0, 0], [0, 0, 1]])), FLAT)
    for method in ("newmark", "radau", "rk45", "auto"):
        with pytest.raises(
            ValueError, match=r"t_end: got a run from 0 to 1\.5, expected a run within \[0, 1\]"
        ):
            lissom.simulate(rod, 1.5, method=method)
    rest = np.zeros(rod.n)
    for ask in (
        lambda: rod.energy(rest, rest, t=2.0),
        lambda: rod.pose(rest, 0.1, t=-1.0),
        lambda: lissom.statics(rod, t=9.0),
    ):
        with pytest.raises(ValueError, match=r"t: got .*expected a time in \[0, 1\]"):
            ask()
    assert lissom.simulate(rod, 1.0, dt=0.1).success


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"axis": (0, 0, 1)}, "angle: got none, expected an angle about the axis"),
        ({"angle": lissom.Harmonic(1.0, 1.0)}, "axis: got none, expected the axis"),
        ({"axis": (0, 0, 0), "angle": lissom.Harmonic(1.0, 1.0)}, "axis: got a vector of length 0"),
        ({"axis": (0, 0, 1), "angle": lissom.Harmonic((1, 2, 3), 1.0)}, "angle: expected a Harmonic of one"),
        ({"rotation": (1, 0, 0, 0)}, "rotation: got a constant or harmonic one"),
        ({"rotation": quaternion, "axis": (0, 0, 1), "angle": drift}, "rotation: got both"),
        (
            {"rotation": ([0, 1], [[1, 0, 0, 0], [0, 2, 0, 0]])},
            r"rotation\.values\[1\]: got a quaternion of norm 2",
        ),
        ({"rotation": ([0, 1], [[1, 0, 0, 0], [0, 1, 0, 0]])}, r"rotation\.values\[1\]: got a large turn"),
        ({"translation": ([0, 0], [[0, 0, 0]] * 2)}, r"translation\.times\[1\]"),
        ({"translation": (0, 0, np.nan)}, r"translation\[2\]: got NaN"),
    ],
)
def test_motions_that_make_no_sense_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        lissom.BaseMotion(**arguments)


def test_motions_are_plain_data():
    angle = lissom.Harmonic(0.2, 3.0)
    for motion in (
        lissom.BaseMotion(),
        WILD["table"],
        WILD["callable"],
        lissom.BaseMotion(axis=(0, 1, 0), angle=angle),
        lissom.BaseMotion(translation=(1, 2, 3), axis=(0, 1, 0), angle=([0, 1], [0, 2])),
    ):
        assert motion == pickle.loads(pickle.dumps(motion)) == copy.deepcopy(motion)
        assert pickle.loads(pickle.dumps(rod_of(motion))).base_motion == motion
    motion = lissom.BaseMotion(axis=(0, 1, 0), angle=angle)
    assert (motion.axis, motion.angle, motion.rotation, motion.translation) == (
        (0, 1, 0),
        angle,
        None,
        (0, 0, 0),
    )
    assert repr(motion).startswith(
        "BaseMotion(translation=(0.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0), angle=Harmonic"
    )
    assert WILD["callable"].rotation is quaternion
    assert rod_of(None).base_motion is None
    assert "motion of the base" in rod_of(motion).explain().split("skipped")[0]


def test_scenes_move_the_base():
    text = """
        version = 1
        [[rod]]
        [rod.base_motion]
        translation = { amplitude = [0, 0, 0.01], frequency = 2 }
        axis = [0, 0, 1]
        angle = { times = [0, 1, 2], values = [0, 0.5, 2] }
        [[rod.segment]]
        length = 0.5
        radius = 0.01
        young_modulus = 1e6
        shear_modulus = 4e5
        density = 1000
        modes = { bend_y = 2 }
        [simulation]
        t_end = 0.1
    """
    scene = lissom.Scene.loads(text)
    assert isinstance(scene.model, lissom.Rod)
    assert scene.model.base_motion == lissom.BaseMotion(
        translation=lissom.Harmonic((0, 0, 0.01), 2.0), axis=(0, 0, 1), angle=([0, 1, 2], [0, 0.5, 2])
    )
    assert scene.run().success
    quaternions = "rotation = { times = [0, 9], values = [[1, 0, 0, 0], [0.8, 0.6, 0, 0]] }"
    turned = text.replace("axis = [0, 0, 1]", quaternions).replace("angle", "# angle")
    assert lissom.Scene.loads(turned).model.base_motion.rotation is not None
    for old, new, key in [
        ("t_end = 0.1", "t_end = 2.1", "rod[0].base_motion"),
        ("axis = [0, 0, 1]", "axis = [0, 0, 0]", "rod[0].base_motion.axis"),
        ("axis = [0, 0, 1]", "", "rod[0].base_motion.angle"),
        ("axis = [0, 0, 1]", quaternions, "rod[0].base_motion.rotation"),
        ("[0, 1, 2], ", "[0, 1, 1], ", "rod[0].base_motion.angle.times[2]"),
        ("frequency = 2", "frequency = -2", "rod[0].base_motion.translation.frequency"),
        ("values = [0, 0.5, 2]", "", "rod[0].base_motion.angle"),
    ]:
        with pytest.raises(lissom.SceneError) as caught:
            lissom.Scene.loads(text.replace(old, new))
        assert key in [problem.key for problem in caught.value.problems]


def test_results_show_the_rod_where_the_base_is():
    from lissom.results import runs

    scene = lissom.Scene.loads(
        """
        version = 1
        [[rod]]
        base_motion = { translation = { rate = [0, 10, 0] } }
        [[rod.segment]]
        length = 0.5
        radius = 0.01
        young_modulus = 1e9
        shear_modulus = 4e8
        density = 1000
        modes = { bend_y = 2 }
        retardation_time = 0.1
        [simulation]
        t_end = 1.0
        dt = 0.1
        """
    )
    run = runs.Run(scene, scene.run())
    (shape,) = runs.shapes(run)
    np.testing.assert_allclose(shape.positions[:, 0, 1], 10.0 * run.t[shape.at], atol=1e-12)


@pytest.mark.parametrize(
    "shake", [lambda t: (0, 0, 0.01 * np.exp(-(((t - 0.5) / 0.05) ** 2))), lambda t: (1e-3 * t**40, 0, 0)]
)
def test_tails_that_underflow_have_derivatives(shake):
    wire = lissom.Segment(0.4, 1e-3, 2e11, 8e10, 7800, {"bend_y": 1}, retardation_time=1e-2)
    rod = lissom.Rod([wire], base_motion=lissom.BaseMotion(translation=shake))
    for t in np.linspace(0.0, 2.5, 400):
        assert np.isfinite(rod.pose([0.0], 0.0, t=t)).all()
