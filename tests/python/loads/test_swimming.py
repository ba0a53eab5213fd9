"""Rods on a moving base in a fluid and on supports: swimming tails, catheters, shaken frames."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

import lissom
from reference import fluid as reference_fluid
from reference import moving
from reference import rod as reference_rod
from reference import supports as reference_supports
from rod_cases import (
    TWO_SUPPORTS,
    drift,
    quaternion,
    random_segments,
    rich_segments,
    turn,
    vectors,
    with_section,
)

FLUID = {
    "density": 800.0,
    "velocity": (0.3, -0.7, 0.5),
    "viscous_drag": (0.4, 0.1),
    "drag_coefficients": (1.2, 0.05),
    "added_mass_coefficient": 0.9,
}
SUPPORTS = [
    *TWO_SUPPORTS,
    {"at": 0.4, "damping": (1, 2, 0.5)},
]
BASE = {"base_position": (0.3, -2.0, 1.0), "base_orientation": (0.8, 0.2, -0.4, 0.4)}
#: Mass per length and cross-sectional area of the arm.
LINE_MASS, AREA = 1000 * np.pi * 1e-4, np.pi * 1e-4


class Surrounded(reference_fluid.Rod, reference_supports.Rod):
    """The reference in a fluid and on supports."""


WILD = lissom.BaseMotion(translation=drift, rotation=quaternion)


def arm(motion=None, fluid=None, *, strains=("bend_y",), modes=3, damping=0.0, gravity=(0, 0, 0), **rod):
    """One metre with A = 1e-4 pi and E I = 0.79 N m^2."""
    segment = lissom.Segment(
        1.0, 0.01, 1e8, 4e7, 1000.0, dict.fromkeys(strains, modes), retardation_time=damping
    )
    return lissom.Rod([segment], gravity=gravity, base_motion=motion, fluid=fluid, **rod)


# Comparison with the reference


@pytest.mark.parametrize("fluid", [FLUID, {"density": 0.0}], ids=["fluid", "supports alone"])
def test_forces_agree_with_the_reference(fluid):
    gravity, t = (1.0, -2.0, -9.0), 0.7
    rod = lissom.Rod(
        [lissom.Segment(**segment) for segment in rich_segments()],
        supports=[lissom.Support(**support) for support in SUPPORTS],
        fluid=lissom.Fluid(**fluid),
        base_motion=WILD,
        gravity=gravity,
        **BASE,
    )
    still = Surrounded(
        [reference_rod.Segment(**segment) for segment in rich_segments()],
        supports=[reference_supports.Support(**support) for support in SUPPORTS],
        fluid=reference_fluid.Fluid(**fluid),
        gravity=gravity,
        **BASE,
    )

    def base(t):
        turned = Rotation.from_rotvec(turn(t)).as_matrix()
        return turned @ still.base[:9].reshape(3, 3), still.base[9:12] + drift(t)

    wanted = still.on_base(*base(t), *moving.body_twist(base, t))
    q, qd, qdd = np.array([[0.3], [1.0], [3.0]]) * np.random.default_rng(3).standard_normal((3, rod.n))
    tau = wanted.inverse_dynamics(q, qd, qdd)
    assert_allclose(rod.inverse_dynamics(q, qd, qdd, t=t), tau, rtol=0, atol=1e-6 * np.abs(tau).max())


@settings(deadline=None, max_examples=6)
@given(
    random_segments().filter(lambda segment: any(segment["modes"].values())),
    st.tuples(*4 * [vectors(2.0)]),
    st.integers(0, 10**6),
)
def test_random_rods_on_any_base_agree_with_the_reference(segment, motion, seed):
    velocity, acceleration, spin, spin_rate = map(np.array, motion)
    random = np.random.default_rng(seed)
    w, x, y, z = orientation = random.standard_normal(4) / 10 + [1, 0, 0, 0]
    orientation /= np.linalg.norm(orientation)
    position = random.standard_normal(3)
    start = Rotation.from_quat([x, y, z, w])

    def turned(t):
        # With this angular velocity and acceleration at t = 0.
        return (Rotation.from_rotvec(spin * t + 0.5 * spin_rate * t * t) * start).as_quat(scalar_first=True)

    base_motion = lissom.BaseMotion(
        translation=lambda t: (
            position + velocity * t + 0.5 * acceleration * t * t,
            velocity + acceleration * t,
            acceleration,
        ),
        rotation=lambda t: (turned(t), spin, spin_rate),
    )
    fluid = FLUID | {"velocity": random.standard_normal(3)}
    rod = lissom.Rod(
        [lissom.Segment(**with_section(segment, lissom), nodes=64)],
        base_motion=base_motion,
        fluid=lissom.Fluid(**fluid),
    )
    R = Rotation.from_quat([x, y, z, w]).as_matrix()
    eta = np.concatenate([R.T @ spin, R.T @ velocity])
    eta_t = np.concatenate([R.T @ spin_rate, R.T @ (acceleration - np.cross(spin, velocity))])
    wanted = reference_fluid.Rod(
        [reference_rod.Segment(**with_section(segment, reference_rod))], fluid=reference_fluid.Fluid(**fluid)
    ).on_base(R, position, eta, eta_t)
    q, qd, qdd = 0.2 * random.standard_normal((3, rod.n)) / max(1.0, segment["length"])
    tau = wanted.inverse_dynamics(q, qd, qdd)
    # Where a velocity changes its sign along the rod, |v| v has a kink: m nodes err by about m^-3.
    found = rod.inverse_dynamics(q, qd, qdd, t=0.0)
    assert_allclose(found, tau, rtol=0, atol=1e-5 * np.abs(tau).max(initial=0))


# Known solutions


def test_a_base_that_moves_with_the_fluid_rests():
    """Galilean invariance: only the relative velocity matters."""
    velocity = (0.5, -3.0, 0.25)
    carried = lissom.BaseMotion(translation=lissom.Harmonic(rate=velocity))
    strains = {"strains": ("torsion", "bend_y", "bend_z"), "gravity": (0, 0.5, -9.81), **BASE}
    flowing = arm(carried, lissom.Fluid(**(FLUID | {"velocity": velocity})), **strains)
    resting = arm(None, lissom.Fluid(**(FLUID | {"velocity": (0, 0, 0)})), **strains)
    q, v, a = 0.5 * np.random.default_rng(1).standard_normal((3, flowing.n))
    found, wanted = flowing.inverse_dynamics(q, v, a, t=3.0), resting.inverse_dynamics(q, v, a)
    assert_allclose(found, wanted, rtol=0, atol=1e-13 * np.abs(wanted).max())
    shift = flowing.pose(q, 1.0, t=3.0)[:3, 3] - resting.pose(q, 1.0)[:3, 3]
    assert_allclose(shift, 3.0 * np.array(velocity), rtol=1e-12)
    assert_array_equal(flowing.mass_matrix(q), resting.mass_matrix(q))
    # The dissipation is independent of the observer.
    assert_allclose(flowing.dissipated_power(q, v, t=3.0), resting.dissipated_power(q, v), rtol=1e-12, atol=0)


def test_a_base_held_elsewhere_is_a_base_there():
    translation, axis, angle = (0.2, -0.1, 0.3), np.array([1.0, 2.0, -2.0]) / 3, 0.8
    moved = lissom.BaseMotion(translation=translation, axis=axis, angle=[angle])
    turned = Rotation.from_rotvec(angle * axis).as_quat(scalar_first=True)
    there = {"base_position": translation, "base_orientation": turned}
    springs = {"position": (1.1, 0.1, -0.2), "orientation": (0.6, 0.0, 0.8, 0.0)}
    surroundings = {
        "fluid": lissom.Fluid(**FLUID),
        "supports": [
            lissom.Support(stiffness=(3, 1, 2), rotational_stiffness=(0.1, 0.3, 0.2), damping=1.0, **springs)
        ],
        "strains": ("torsion", "bend_y", "bend_z", "stretch"),
        "gravity": (1.0, 0.5, -9.81),
    }
    rods = arm(moved, **surroundings), arm(**surroundings, **there)
    q, v, a = 0.5 * np.random.default_rng(1).standard_normal((3, rods[0].n))

    def same(ask):
        found, wanted = map(ask, rods)
        assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())

    same(lambda rod: rod.inverse_dynamics(q, v, a))
    same(lambda rod: rod.base_wrench(q, v, a))
    for part in ("kinetic", "elastic", "gravitational", "loads"):
        same(lambda rod, part=part: getattr(rod.energy(q, v), part))
    same(lambda rod: rod.dissipated_power(q, v))
    same(lambda rod: rod.supplied_power(q, v, a))
    same(lambda rod: rod.pose(lissom.statics(rod).q, [0.5, 1.0]))


def test_anchors_are_left_where_the_base_at_rest_puts_them():
    """By default: the position of the tip with zero coordinates before the motion."""
    motion = lissom.BaseMotion(translation=lissom.Harmonic(rate=(0, 0, 0.1)))
    rod = arm(motion, supports=[lissom.Support(stiffness=7.0, damping=2.0)])
    zero = np.zeros(rod.n)
    free = arm(motion)
    for t in (0.0, 2.0):
        wrench = rod.base_wrench(zero, zero, zero, t=t) - free.base_wrench(zero, zero, zero, t=t)
        assert_allclose(wrench[3:], [0, 0, 7.0 * 0.1 * t + 2.0 * 0.1], atol=1e-14)
        assert_allclose(rod.energy(zero, zero, t=t).elastic, 0.5 * 7.0 * (0.1 * t) ** 2, atol=1e-15)
        assert_allclose(rod.dissipated_power(zero, zero, t=t), 2.0 * 0.1**2, rtol=1e-13)


def test_a_spring_in_series_with_the_beam_on_a_lifted_base():
    """A base lifted by d moves the tip by d kb / (kb + k), kb = 3 E I / L^3."""
    lift, stiffness = 1e-5, 2.0
    beam = 3 * 1e8 * np.pi / 4 * 1e-8
    rod = arm(
        lissom.BaseMotion(translation=lissom.Harmonic(rate=(0, 0, lift))),
        supports=[lissom.Support(stiffness=(0, 0, stiffness))],
    )
    found = lissom.statics(rod, t=1.0)
    assert found.success, found.message
    z = rod.pose(found.q, 1.0, t=1.0)[2, 3]
    assert_allclose(z, lift * beam / (beam + stiffness), rtol=1e-8)


def test_a_damper_holds_back_the_tip_of_a_steadily_moving_rod():
    speed, damping = 1e-4, 0.3
    rod = arm(
        lissom.BaseMotion(translation=lissom.Harmonic(rate=(0, 0, speed))),
        supports=[lissom.Support(damping=(0, 0, damping))],
    )
    found = lissom.statics(rod, t=2.0)
    z = rod.pose(found.q, 1.0, t=2.0)[2, 3] - 2.0 * speed
    assert_allclose(z, -damping * speed / (3 * 1e8 * np.pi / 4 * 1e-8), rtol=1e-8)


@pytest.mark.parametrize("strains", [("bend_z",), ("bend_y", "bend_z")], ids=["planar", "spatial"])
def test_a_straight_rod_swung_in_a_fluid_meets_the_integrals_of_the_drag(strains):
    """About z with w and dw/dt: v = w x across, so that all forces are integrals of powers of x."""
    speed, rate, t = 3.0, 5.0, 0.4
    rho, viscous, coefficient, added = 800.0, 0.4, 1.2, 0.9

    def swing(now):
        since = now - t
        return speed * since + 0.5 * rate * since**2, speed + rate * since, rate

    spin = lissom.BaseMotion(axis=(0, 0, 1), angle=swing)
    fluid = lissom.Fluid(
        rho,
        viscous_drag=(viscous, 0.1),
        drag_coefficients=(coefficient, 0.05),
        added_mass_coefficient=added,
    )
    rod = arm(spin, fluid, strains=strains)
    zero = np.zeros(rod.n)
    moment, force = rod.base_wrench(zero, zero, zero, t=t).reshape(2, 3)
    diameter, mass = 0.02, LINE_MASS + added * rho * AREA
    quadratic = 0.5 * rho * diameter * coefficient * speed**2
    rotary = 1000 * np.pi / 4 * 1e-8
    drag = [viscous * speed / k + quadratic / (k + 1) for k in (3, 2)]
    assert_allclose(moment, [0, 0, mass * rate / 3 + rotary * rate + drag[0]], rtol=1e-12, atol=1e-12)
    assert_allclose(force, [-mass * speed**2 / 2, mass * rate / 2 + drag[1], 0], rtol=1e-12, atol=1e-12)
    assert_allclose(
        rod.dissipated_power(zero, zero, t=t), viscous * speed**2 / 3 + quadratic * speed / 4, rtol=1e-12
    )


def test_drag_along_the_rod_resists_a_push_along_it():
    """Added mass does not: slender bodies have none along their axis."""
    speed, rate = 0.7, 2.0
    push = lissom.BaseMotion(
        translation=lambda t: ((speed * t + 0.5 * rate * t * t, 0, 0), (speed + rate * t, 0, 0), (rate, 0, 0))
    )
    fluid = lissom.Fluid(800.0, (0.2, 0, 0), viscous_drag=(0.4, 0.1), drag_coefficients=(1.2, 0.05))
    rod = arm(push, fluid)
    zero = np.zeros(rod.n)
    relative = speed - 0.2
    wanted = LINE_MASS * rate + 0.1 * relative + 0.5 * 800 * 0.02 * np.pi * 0.05 * relative**2
    assert_allclose(rod.base_wrench(zero, zero, zero, t=0.0)[3:], [wanted, 0, 0], rtol=1e-12, atol=1e-12)


def test_a_heaved_elastic_tail_gives_the_thrust_of_small_amplitude_theory():
    """c_n y_t + m y_tt + E I y_xxxx = 0, driven at the clamped end (Machin 1958; Wiggins and Goldstein 1998).

    To second order in the slope, the mean drag along the tail is (c_n - c_t) <int y_t y_x dx>.
    """
    rigidity, line_mass, across, along = 1e8 * np.pi / 4 * 1e-8, LINE_MASS, 5.0, 2.0
    amplitude, frequency = 0.01, 1.5
    omega = 2 * np.pi * frequency
    # y = Re (sum_k c_k exp(p_k x)) exp(i w t) with p^4 = (m w^2 - i w c_n) / E I.
    p = ((line_mass * omega**2 - 1j * omega * across) / rigidity) ** 0.25 * np.array([1, 1j, -1, -1j])
    ends = [np.ones(4), p, p**2 * np.exp(p), p**3 * np.exp(p)]
    c = np.linalg.solve(ends, [amplitude, 0, 0, 0])
    x, weights = np.polynomial.legendre.leggauss(40)
    shape = np.exp(np.outer((x + 1) / 2, p))
    y_t, y_x = 1j * omega * shape @ c, shape @ (p * c)
    wanted = (across - along) * weights / 2 @ (y_t * y_x.conj()).real / 2

    heave = lissom.BaseMotion(translation=lissom.Harmonic((0, 0, amplitude), frequency))
    fluid = lissom.Fluid(0.0, viscous_drag=(across, along))
    rod = arm(heave, fluid, modes=6)
    periods, samples = 8, 40
    times = (periods - 1 + np.arange(samples) / samples) / frequency
    run = lissom.simulate(rod, periods / frequency, method="radau", rtol=1e-6, atol=1e-8, t_eval=times)
    assert run.success, run.message
    force = [rod.base_wrench(*state, t=t)[3] for *state, t in zip(run.q, run.v, run.a, run.t, strict=True)]
    # The fluid pushes the tail towards its base, and thus the base forwards.
    assert wanted < 0
    assert_allclose(-np.mean(force), wanted, rtol=1e-3)


# Energy


@pytest.mark.slow
@pytest.mark.parametrize("method", ["radau", "dop853"])
@pytest.mark.parametrize("motion", ["heaved", "wild"])
def test_the_balance_of_a_run_closes(motion, method):
    heaved = lissom.BaseMotion(translation=lissom.Harmonic((0, 0, 0.1), 2.0))
    rod = arm(
        {"heaved": heaved, "wild": WILD}[motion],
        lissom.Fluid(**FLUID),
        supports=[lissom.Support(at=0.6, stiffness=2.0, rotational_stiffness=0.2, damping=0.3)],
        strains=("bend_y",) if motion == "heaved" else ("torsion", "bend_y", "bend_z"),
        modes=2,
        damping=1e-3,
        gravity=(0, 0, -9.81),
    )
    assert rod.kernel == ("planar" if motion == "heaved" else "spatial")
    run = lissom.simulate(rod, 0.5, method=method, rtol=1e-8, atol=1e-10)
    assert run.success, run.message
    assert run.balance.drift < 1e-5
    assert abs(run.balance.work[-1]) > 0.01 * run.balance.scale
    assert run.balance.dissipated[-1] > 0.01 * run.balance.scale


# Scenes


def test_scenes_swim():
    scene = lissom.Scene.loads("""
version = 1
[[rod]]
[rod.base_motion]
axis = [0, 1, 0]
angle = { amplitude = 0.3, frequency = 2 }
[rod.fluid]
density = 1000
drag_coefficients = [1.2, 0.01]
[[rod.support]]
damping = 0.1
[[rod.segment]]
length = 0.2
radius = 0.005
young_modulus = 1e6
poisson_ratio = 0.5
density = 1000
modes = { bend_y = 3 }
[simulation]
t_end = 0.5
method = "radau"
rtol = 1e-6
""")
    run = scene.run()
    assert run.success
    assert run.balance.drift < 1e-4
    assert "supports and fluid evaluated once" in scene.model.explain()
