"""Rods in a fluid: forces compared with an independent reference, and motions with known solutions."""

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import lissom
from reference import fluid as reference
from reference import rod as reference_rod
from rod_cases import random_segments, rich_segments, with_section

AREA = np.pi * 1e-4

ARGUMENTS = {
    "density": 800.0,
    "velocity": (0.3, -0.7, 0.5),
    "viscous_drag": (0.4, 0.1),
    "drag_coefficients": (1.2, 0.05),
    "added_mass_coefficient": 0.9,
}


def arm(fluid=None, *, modes=4, density=1000.0, gravity=(0, 0, 0), strains=("bend_y",), damping=0.0, **rod):
    """One metre of a rod with A = 1e-4 pi and E I = 1 / (4 pi)^(1/2) or so: E = 1e8."""
    segment = lissom.Segment(
        1.0, 0.01, 1e8, 4e7, density, dict.fromkeys(strains, modes), retardation_time=damping
    )
    return lissom.Rod([segment], gravity=gravity, fluid=fluid, **rod)


# Defaults and validation


def test_defaults_are_the_documented_ones():
    fluid = lissom.Fluid(1000)
    assert fluid.density == 1000.0
    assert fluid.velocity == (0.0, 0.0, 0.0)
    assert fluid.viscous_drag == fluid.drag_coefficients == (0.0, 0.0)
    assert fluid.added_mass_coefficient == 1.0
    assert fluid.buoyancy is True
    assert arm().fluid is None
    assert arm(fluid).fluid == fluid


def test_copies_and_pickles_are_equal():
    fluid = lissom.Fluid(**ARGUMENTS, buoyancy=False)
    assert fluid == pickle.loads(pickle.dumps(fluid)) == copy.deepcopy(fluid)
    assert eval(repr(fluid), {"Fluid": lissom.Fluid}) == fluid
    assert fluid != lissom.Fluid(**ARGUMENTS)
    assert pickle.loads(pickle.dumps(arm(fluid))).fluid == fluid


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"density": -1}, "density: got -1, expected a finite number >= 0"),
        ({"velocity": (0, np.nan, 0)}, "velocity"),
        ({"viscous_drag": (0, -1)}, r"viscous_drag\[1\]: got -1"),
        ({"drag_coefficients": (np.inf, 0)}, r"drag_coefficients\[0\]: got inf"),
        ({"added_mass_coefficient": -0.5}, "added_mass_coefficient: got -0.5"),
    ],
)
def test_what_makes_no_sense_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        lissom.Fluid(**({"density": 1.0} | arguments))


def test_scenes_have_a_fluid():
    text = """
version = 1
[[rod]]
[rod.fluid]
density = 800
velocity = [0.3, -0.7, 0.5]
viscous_drag = [0.4, 0.1]
drag_coefficients = [1.2, 0.05]
added_mass_coefficient = 0.9
[[rod.segment]]
length = 1.0
radius = 0.01
young_modulus = 1e6
poisson_ratio = 0.5
density = 1000
modes = { bend_y = 3 }
[simulation]
t_end = 1
"""
    assert lissom.Scene.loads(text).model.fluid == lissom.Fluid(**ARGUMENTS)
    with pytest.raises(lissom.SceneError, match=r"rod\[0\]\.fluid\.density: got -800"):
        lissom.Scene.loads(text.replace("density = 800", "density = -800"))


def test_explained():
    words = arm(lissom.Fluid(1000.0, viscous_drag=(1, 1)), gravity=(0, 0, -9.81)).explain()
    for part in ("added mass", "drag", "buoyancy"):
        assert part in words.split("skipped")[0]
    assert "fluid" in arm().explain().split("skipped")[1]


# Comparison with the reference


def both(segments, fluid, *, nodes=None, **rod):
    return (
        lissom.Rod(
            [lissom.Segment(**with_section(segment, lissom), nodes=nodes) for segment in segments],
            fluid=lissom.Fluid(**fluid),
            **rod,
        ),
        reference.Rod(
            [reference_rod.Segment(**with_section(segment, reference_rod)) for segment in segments],
            fluid=reference.Fluid(**fluid),
            **rod,
        ),
    )


PARTS = {
    "all": ARGUMENTS,
    "at rest": ARGUMENTS | {"velocity": (0, 0, 0)},
    "viscous": {"density": 0.0, "viscous_drag": (0.4, 0.1), "velocity": (0.3, -0.7, 0.5)},
    "quadratic": ARGUMENTS | {"viscous_drag": (0, 0), "added_mass_coefficient": 0.0, "buoyancy": False},
    "added mass": {"density": 800.0, "velocity": (0.3, -0.7, 0.5), "buoyancy": False},
    "buoyancy": {"density": 800.0, "added_mass_coefficient": 0.0},
}


@pytest.mark.parametrize("fluid", PARTS.values(), ids=PARTS)
def test_forces_agree_with_the_reference(fluid):
    base = {"base_position": (0.3, -2.0, 1.0), "base_orientation": (0.8, 0.2, -0.4, 0.4)}
    rod, wanted = both(rich_segments(), fluid, **base)
    q, qd, qdd = np.array([[0.3], [1.0], [3.0]]) * np.random.default_rng(3).standard_normal((3, rod.n))
    tau = wanted.inverse_dynamics(q, qd, qdd)
    assert_allclose(rod.inverse_dynamics(q, qd, qdd), tau, rtol=0, atol=1e-6 * np.abs(tau).max())
    mass = wanted.mass_matrix(q)
    assert_allclose(rod.mass_matrix(q), mass, rtol=0, atol=1e-7 * np.abs(mass).max())


fluids = st.fixed_dictionaries(
    {
        "density": st.floats(0, 2000),
        "velocity": st.tuples(*3 * [st.floats(-2, 2)]),
        "viscous_drag": st.tuples(*2 * [st.floats(0, 5)]),
        "drag_coefficients": st.tuples(*2 * [st.floats(0, 2)]),
        "added_mass_coefficient": st.floats(0, 2),
        "buoyancy": st.booleans(),
    }
)


@settings(deadline=None, max_examples=8)
@given(
    random_segments().filter(lambda segment: any(segment["modes"].values())), fluids, st.integers(0, 10**6)
)
def test_random_rods_agree_with_the_reference(segment, fluid, seed):
    """Where the velocity changes its sign along the rod, |v| v has a kink: m nodes err by about m^-3."""
    rod, wanted = both([segment], fluid, nodes=64, gravity=(1.0, -2.0, -9.0))
    random = np.random.default_rng(seed)
    q, qd, qdd = 0.2 * random.standard_normal((3, rod.n)) / max(1.0, segment["length"])
    tau = wanted.inverse_dynamics(q, qd, qdd)
    assert_allclose(rod.inverse_dynamics(q, qd, qdd), tau, rtol=0, atol=1e-5 * np.abs(tau).max(initial=0))


# Known solutions


def test_a_rod_in_a_fluid_of_its_own_density_floats():
    rod = arm(lissom.Fluid(1000.0), gravity=(0.3, 0.5, -9.81), strains=("bend_y", "bend_z", "stretch"))
    free = arm(strains=("bend_y", "bend_z", "stretch"))
    q = np.random.default_rng(2).standard_normal(rod.n) * 0.2
    weight = np.abs(arm(gravity=(0, 0, -9.81), strains=("bend_y", "bend_z", "stretch")).mass_matrix(q)).max()
    difference = rod.inverse_dynamics(q, 0 * q, 0 * q) - free.inverse_dynamics(q, 0 * q, 0 * q)
    assert np.abs(difference).max() < 1e-14 * 9.81 * weight
    assert_allclose(rod.energy(q, 0 * q).total, free.energy(q, 0 * q).total, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("coefficient", [0.0, 1.0, 2.5])
def test_added_mass_lowers_the_frequencies(coefficient):
    """By sqrt(m / (m + m_a)) for a rod that only bends, except for its rotary inertia."""
    fluid = lissom.Fluid(800.0, added_mass_coefficient=coefficient)
    segment = lissom.Segment(1.0, 1e-4, 1e9, 4e8, 1000.0, {"bend_y": 6})
    dry, wet = (lissom.Rod([segment], gravity=(0, 0, 0), fluid=fluid) for fluid in (None, fluid))
    dry, wet = (lissom.modes(rod, np.zeros(6)).angular_frequency[:3] for rod in (dry, wet))
    assert_allclose(wet / dry, np.sqrt(1000 / (1000 + 800 * coefficient)), rtol=1e-6)
    assert_allclose(wet[0] / dry[0], np.sqrt(1000 / (1000 + 800 * coefficient)), rtol=1e-8)


@pytest.mark.parametrize("drag", [0.02, 0.5, 20.0])
def test_viscous_drag_of_one_mode(drag):
    """m q'' + c q' + k q = 0: drag per length divided by mass per length is twice the decay rate."""
    segment = lissom.Segment(1.0, 1e-4, 1e9, 4e8, 1000.0, {"bend_y": 1})
    fluid = lissom.Fluid(0.0, viscous_drag=(drag * 1e-5, 0))
    rod = lissom.Rod([segment], gravity=(0, 0, 0), fluid=fluid)
    mass = rod.mass_matrix([0.0])[0, 0]
    stiffness = rod.tangent([0.0], [0.0], [0.0])[0][0, 0]
    line_mass = 1000 * np.pi * 1e-8
    rate = drag * 1e-5 / line_mass
    natural = np.sqrt(stiffness / mass + 0j)
    wanted = -rate / 2 + np.array([1, -1]) * np.sqrt(rate**2 / 4 - natural**2)
    (found,) = lissom.modes(rod, [0.0]).eigenvalues
    assert np.abs(wanted - found).min() < 2e-8 * np.abs(found)


def test_tangential_drag_is_felt_by_stretching():
    segment = lissom.Segment(1.0, 0.01, 1e8, 4e7, 1000.0, {"stretch": 1})
    rod = lissom.Rod([segment], gravity=(0, 0, 0), fluid=lissom.Fluid(0.0, viscous_drag=(5.0, 2.0)))
    # v = X qd: the generalised force of the drag is 2 int X^2.
    assert_allclose(rod.inverse_dynamics([0.0], [0.3], [0.0]), 2.0 / 3 * 0.3, rtol=1e-12)
    quadratic = lissom.Rod(
        [segment], gravity=(0, 0, 0), fluid=lissom.Fluid(10.0, drag_coefficients=(1.0, 0.5), buoyancy=False)
    )
    wanted = 0.5 * 10 * 0.02 * np.pi * 0.5 * 0.3**2 / 4
    assert_allclose(quadratic.inverse_dynamics([0.0], [0.3], [0.0]), wanted, rtol=1e-12)
    assert_allclose(quadratic.inverse_dynamics([0.0], [-0.3], [0.0]), -wanted, rtol=1e-12)


def test_drag_is_smooth_at_rest():
    fluid = lissom.Fluid(1000.0, drag_coefficients=(1.2, 0.1), viscous_drag=(0.3, 0.1))
    rod = arm(fluid, strains=("torsion", "bend_y", "bend_z", "stretch"))
    zero = np.zeros(rod.n)
    parts = rod.tangent(zero, zero, zero)
    assert all(np.isfinite(part).all() for part in parts)
    viscous = arm(
        lissom.Fluid(1000.0, viscous_drag=(0.3, 0.1)), strains=("torsion", "bend_y", "bend_z", "stretch")
    )
    assert_allclose(parts[1], viscous.tangent(zero, zero, zero)[1], rtol=0, atol=1e-15)


def test_a_current_bends_a_rod_and_the_motion_comes_to_rest_there():
    fluid = lissom.Fluid(1000.0, (0, 0, 0.7), drag_coefficients=(1.2, 0.01), viscous_drag=(0.5, 0.1))
    rod = arm(fluid, gravity=(0, 0, -9.81), damping=0.02)
    found = lissom.statics(rod)
    assert found.success, found.message
    assert_allclose(rod.inverse_dynamics(found.q, 0 * found.q, 0 * found.q), 0, atol=1e-9)
    run = lissom.simulate(rod, 20.0, method="radau", rtol=1e-6, atol=1e-9)
    assert run.success, run.message
    assert rod.pose(found.q, 1.0)[2, 3] > 0.01
    assert_allclose(run.q[-1], found.q, rtol=0, atol=1e-6 * np.abs(found.q).max())


def test_drag_keeps_a_cable_in_a_current():
    """Its stiffness is that of follower loads, and alone would lead to flutter."""
    cable = lissom.Segment(1.0, 0.003, 1e6, 1e6 / 3, 2000.0, {"bend_y": 8})
    down = (np.sqrt(0.5), 0, np.sqrt(0.5), 0)
    stream = lissom.Fluid(1000.0, (0.5, 0, 0), drag_coefficients=(1.2, 0.01))
    rod = lissom.Rod([cable], base_orientation=down, fluid=stream)
    found = lissom.statics(rod)
    zero = np.zeros(rod.n)
    stiffness, _, mass = rod.tangent(found.q, zero, zero)
    assert np.abs(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).imag).max() > 1
    modes = lissom.modes(rod, found.q)
    assert modes.is_stable
    assert modes.damping_ratio.min() > 0.1
    assert found.stability == "stable"
    assert found.path.stability[-1] == "stable"
    assert "Without damping, drag and Coriolis forces" in found.message
    push = 1e-3 * np.random.default_rng(1).standard_normal(rod.n)
    motion = lissom.simulate(rod, 10.0, q0=found.q + push, method="radau", rtol=1e-6)
    assert_allclose(motion.q[-1], found.q, atol=1e-4)


def test_drag_does_not_save_a_column_from_buckling():
    column = {"strains": ("bend_y",), "tip_force": (-1.2 * np.pi**2 / 4 * 1e8 * np.pi / 4 * 1e-8, 0, 0)}
    for fluid in [None, lissom.Fluid(1000.0, viscous_drag=(50.0, 1.0)), lissom.Fluid(1000.0, (0, 0.1, 0))]:
        rod = arm(fluid, **column)
        found = lissom.statics(rod)
        assert found.stability == "divergence"
        assert not lissom.modes(rod, found.q).is_stable


def test_a_stiff_rod_across_a_stream_bends_like_a_beam():
    """Linear beam under the load 1/2 rho d C u^2: deflection w L^4 / 8 E I."""
    fluid = lissom.Fluid(1000.0, (0, 0, 1e-3), drag_coefficients=(1.2, 0.0), added_mass_coefficient=0)
    rod = arm(fluid)
    w = 0.5 * 1000 * 0.02 * 1.2 * 1e-6
    rigidity = 1e8 * np.pi / 4 * 1e-8
    assert_allclose(rod.pose(lissom.statics(rod).q, 1.0)[2, 3], w / 8 / rigidity, rtol=1e-6)


def test_added_mass_turns_a_rod_across_the_stream():
    """Munk's moment: m_a u_n u_t per length on a section at an angle to the current."""
    segment = lissom.Segment(1.0, 0.01, 1e8, 4e7, 1000.0, {"bend_y": 1})
    fluid = lissom.Fluid(1000.0, (0.3, 0, 0.2), buoyancy=False)
    rod = lissom.Rod([segment], gravity=(0, 0, 0), fluid=fluid)
    # Section X rotates by X q about y: the generalised force is m_a u_x u_z / 2.
    tau = rod.inverse_dynamics([0.0], [0.0], [0.0])
    assert_allclose(np.abs(tau), 1000 * AREA * 0.3 * 0.2 / 2, rtol=1e-12)
    energies = [rod.energy([q], [0.0]).loads for q in (-1e-5, 1e-5)]
    assert_allclose(tau[0], (energies[1] - energies[0]) / 2e-5, rtol=1e-7)


@pytest.mark.parametrize("fluid", PARTS.values(), ids=PARTS)
def test_the_energy_balance_of_a_run_closes(fluid):
    rod = arm(
        lissom.Fluid(**fluid),
        modes=2,
        gravity=(0, 0, -9.81),
        strains=("torsion", "bend_y", "bend_z"),
        damping=1e-3,
    )
    run = lissom.simulate(rod, 0.5, method="radau", rtol=1e-7, atol=1e-9)
    assert run.success, run.message
    assert run.balance.drift < 1e-5


def test_without_drag_nothing_is_lost():
    rod = arm(lissom.Fluid(900.0, (0.5, 0.3, 0.2)), modes=3, gravity=(0, 0, -9.81))
    assert rod.dissipated_power(np.ones(3), np.ones(3)) == 0.0
    assert rod.supplied_power(np.ones(3), np.ones(3)) == 0.0
    run = lissom.simulate(rod, 1.0, q0=[1.0, 0.3, 0.1], method="radau", rtol=1e-9, atol=1e-11)
    assert run.balance.drift < 1e-7


# Bodies

WATER = 1000.0
BALL = {"volume": 8e-4, "drag_area": 0.01, "drag_coefficient": 0.47}
VERTICAL = lissom.Prismatic((0, 0, 1))


def diver(body, fluid, joint=VERTICAL, **robot):
    return lissom.Robot([lissom.Link("diver", body=body, joint=joint)], fluid=fluid, **robot)


@pytest.mark.parametrize("mass", [0.3, 0.8, 5.0])
@pytest.mark.parametrize("coefficient", [0.0, 0.5, 1.0])
def test_a_body_starts_with_the_acceleration_of_its_buoyancy_and_added_mass(mass, coefficient):
    density = mass / BALL["volume"]
    body = lissom.Body(mass, volume=BALL["volume"], added_mass_coefficient=coefficient)
    expected = (WATER - density) * 9.81 / (WATER * coefficient + density)
    for joint, which in ((VERTICAL, 0), (lissom.Free(), 2)):
        if joint != VERTICAL:
            body = lissom.Body(
                mass, volume=BALL["volume"], added_mass_coefficient=coefficient, inertia=(1e-3,) * 3
            )
        robot = diver(body, lissom.Fluid(WATER), joint)
        found = robot.forward_dynamics(np.zeros(robot.n), np.zeros(robot.n))
        assert found[which] == pytest.approx(expected, abs=1e-12)
        assert abs(np.delete(found, which)).max(initial=0) < 1e-12
    without = diver(body, lissom.Fluid(WATER, buoyancy=False), lissom.Free())
    fall = without.forward_dynamics(np.zeros(6), np.zeros(6))[2]
    assert fall == pytest.approx(-9.81 * density / (WATER * coefficient + density), abs=1e-12)
    vacuum = diver(lissom.Body(mass), lissom.Fluid(WATER))
    assert vacuum.forward_dynamics([0.0], [0.0])[0] == pytest.approx(-9.81)


@pytest.mark.parametrize("method", ["newmark", "generalised_alpha", "radau", "rk45", "dop853", "auto"])
def test_terminal_speed_and_its_approach(method):
    """m* dv/dt = W - k v^2 from rest: v = u tanh(t W / (m* u)), u = sqrt(W / k)."""
    body = lissom.Body(2.0, **BALL)
    robot = diver(body, lissom.Fluid(WATER))
    weight = (2.0 - WATER * BALL["volume"]) * 9.81
    terminal = np.sqrt(2 * weight / (WATER * 0.47 * 0.01))
    moved = 2.0 + 0.5 * WATER * BALL["volume"]
    found = lissom.simulate(robot, 4.0, method=method, dt=5e-3)
    expected = -terminal * np.tanh(found.t * weight / (moved * terminal))
    assert_allclose(found.v[:, 0], expected, atol=1e-3 * terminal)
    assert found.v[-1, 0] == pytest.approx(-terminal, rel=1e-3)
    assert found.balance.drift < 1e-3


def test_viscous_drag_is_exponential_and_a_current_carries_along():
    fluid = lissom.Fluid(WATER, (0.3, 0, 0))
    body = lissom.Body(0.5, viscous_drag=1.5, volume=5e-4, inertia=(1e-3,) * 3)
    robot = diver(body, fluid, lissom.Free())
    found = lissom.simulate(robot, 1.0, method="radau", v0=[0, 0.2, 0, 0, 0, 0])
    decay = np.exp(-found.t * 1.5 / (0.5 + 0.25))
    assert_allclose(found.v[:, 0], 0.3 * (1 - decay), atol=1e-6)
    assert_allclose(found.v[:, 1], 0.2 * decay, atol=1e-6)
    assert_allclose(found.v[:, 2:], 0, atol=1e-9)
    assert found.balance.drift < 1e-6


def test_a_body_rights_itself_about_its_centre_of_volume():
    """A pendulum under its own float: the period of (rho V c - m d) g against the moment of inertia."""
    up = {"volume": 1e-3, "centre_of_volume": (0.01, 0.0, 0.06)}
    body = lissom.Body(1.4, centre=(0, 0, -0.02), inertia=(0.01,) * 3, **up)
    robot = diver(body, lissom.Fluid(WATER), lissom.Revolute((0, 1, 0)))
    rest = np.arctan2(-0.01 * 1.0, 1.0 * 0.06 + 1.4 * 0.02)
    found = lissom.statics(robot)
    assert found.q[0] == pytest.approx(rest, abs=1e-9)
    assert found.stability == "stable"
    inertia = 0.01 + 1.4 * 0.02**2 + 0.5 * (0.01**2 + 0.06**2)
    stiffness = 9.81 * np.hypot(0.01, 0.06 + 1.4 * 0.02)
    frequency = lissom.modes(robot, found.q).frequency[0]
    assert frequency == pytest.approx(np.sqrt(stiffness / inertia) / (2 * np.pi), rel=1e-9)


def swimmers(motion=None, **fluid):
    """Links and a rod with wet bodies, each with a volume beside its mass."""

    def wet(mass, centre, above):
        return lissom.Body(
            mass,
            centre=centre,
            inertia=(2e-3, 3e-3, 4e-3),
            volume=3e-4,
            centre_of_volume=above,
            drag_area=0.02,
            drag_coefficient=0.8,
            viscous_drag=0.3,
            added_mass_coefficient=0.7,
        )

    soft = lissom.Segment(0.3, 0.01, 4e5, 1.5e5, 1100, {"torsion": 1, "bend_y": 2, "bend_z": 2, "stretch": 1})
    first, last = wet(0.3, (0.1, 0.02, -0.03), (0.08, -0.05, 0.04)), wet(0.1, (0, 0.01, 0), (0.02, 0, 0.03))
    on_rod = lissom.Body(0.05, at=0.2, link="rod", volume=1e-4, drag_area=0.01)
    return lissom.Robot(
        [
            lissom.Link("first", body=first, joint=lissom.Spherical()),
            lissom.Link("rod", parent="first", position=(0.1, 0, 0), rod=[soft]),
            lissom.Link("last", parent="rod", body=last, joint=lissom.Revolute((0, 1, 1))),
        ],
        bodies=[on_rod],
        fluid=lissom.Fluid(**(ARGUMENTS | fluid)),
        base_motion=motion,
    )


MOVED = lissom.BaseMotion(
    translation=lissom.Harmonic((0.1, 0.2, -0.1), 1.1), axis=(1, 2, 0), angle=lissom.Harmonic(0.4, 0.9)
)


@pytest.mark.parametrize("motion", [None, MOVED])
def test_tangents_of_wet_bodies_are_derivatives(motion):
    robot = swimmers(motion)
    at = {} if motion is None else {"t": 0.3}
    q, v, a = 0.5 * np.random.default_rng(3).standard_normal((3, robot.n))
    step = 1e-6
    for part, tangent in enumerate(robot.tangent(q, v, a, **at)):
        for k in range(robot.n):
            shift = np.zeros((3, robot.n))
            shift[part, k] = step
            ends = [robot.inverse_dynamics(*(np.array([q, v, a]) + s * shift), **at) for s in (1, -1)]
            difference = (ends[0] - ends[1]) / (2 * step)
            assert_allclose(tangent[:, k], difference, atol=1e-7 * max(1, abs(difference).max()))
    mass = robot.tangent(q, v, a, **at)[2]
    found = robot.forward_dynamics(q, v, **at)
    bias = robot.inverse_dynamics(q, v, np.zeros(robot.n), **at)
    assert_allclose(mass @ found, -bias, atol=1e-9 * abs(bias).max())


@pytest.mark.parametrize("motion", [None, MOVED])
def test_powers_of_wet_bodies_are_the_change_of_their_energies(motion):
    robot = swimmers(motion)
    q, v = 0.4 * np.random.default_rng(4).standard_normal((2, robot.n))
    q[3:] *= 0.3
    start = {"q0": q, "v0": v, "method": "radau", "rtol": 1e-9, "atol": 1e-10}
    found = lissom.simulate(robot, 0.3, **start)
    assert found.balance.drift < 1e-6
    assert np.all(np.diff(found.balance.dissipated) > 0)


def test_the_added_mass_of_a_body_is_neither_mass_nor_weight():
    wet = diver(lissom.Body(0.5, **BALL), lissom.Fluid(WATER))
    dry = diver(lissom.Body(0.5), None)
    q, v = [0.4], [1.5]
    energy, expected = wet.energy(q, v), dry.energy(q, v)
    assert energy.gravitational == pytest.approx(expected.gravitational)
    assert energy.loads == pytest.approx(-WATER * BALL["volume"] * 9.81 * 0.4)
    assert energy.kinetic == pytest.approx(0.5 * (0.5 + 0.4) * 1.5**2)
    assert_allclose(wet.momentum(q, v), dry.momentum(q, v))
    assert "fluid around bodies" in str(wet.explain())
    assert "fluid around bodies" not in str(diver(lissom.Body(0.5), lissom.Fluid(WATER)).explain())


def test_wet_bodies_are_plain_data():
    body = lissom.Body(
        0.5, **BALL, centre_of_volume=(0, 0, 0.1), added_mass_coefficient=0.3, viscous_drag=0.2
    )
    assert body == pickle.loads(pickle.dumps(body)) == copy.deepcopy(body)
    assert body != lissom.Body(0.5)
    assert (body.volume, body.drag_area, body.drag_coefficient) == tuple(BALL.values())
    assert (body.centre_of_volume, body.added_mass_coefficient, body.viscous_drag) == ((0, 0, 0.1), 0.3, 0.2)
    dry = lissom.Body(0.5)
    assert (dry.volume, dry.drag_area, dry.centre_of_volume) == (0, 0, None)
    robot = diver(body, lissom.Fluid(WATER))
    assert pickle.loads(pickle.dumps(robot)).links[0].body == body
    for name in ("volume", "drag_area", "drag_coefficient", "viscous_drag", "added_mass_coefficient"):
        with pytest.raises(ValueError, match=f"{name}: got -1"):
            lissom.Body(0.5, **(BALL | {name: -1.0}))


def test_scenes_have_wet_bodies():
    scene = lissom.Scene.loads("""
version = 1
fluid = { density = 1000 }
[[link]]
name = "diver"
joint = { type = "prismatic", axis = [0, 0, 1] }
[link.body]
mass = 0.5
volume = 8e-4
drag_area = 0.01
drag_coefficient = 0.47
centre_of_volume = [0, 0, 0.1]
[simulation]
t_end = 1
""")
    assert scene.model.links[0].body == lissom.Body(0.5, **BALL, centre_of_volume=(0, 0, 0.1))
    rod = lissom.Scene.loads("""
version = 1
[[rod]]
fluid = { density = 1000 }
[[rod.segment]]
length = 0.4
radius = 0.01
young_modulus = 1e6
poisson_ratio = 0.4
density = 1000
modes = { bend_y = 2 }
[[rod.body]]
mass = 0.1
volume = 2e-4
viscous_drag = 0.3
added_mass_coefficient = 1
[simulation]
t_end = 1
""")
    expected = lissom.Body(0.1, volume=2e-4, viscous_drag=0.3, added_mass_coefficient=1)
    assert rod.model.bodies == (expected,)
