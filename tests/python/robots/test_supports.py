"""Elastic supports: forces compared with an independent reference, and beams supported at both ends."""

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import lissom
from reference import rod as reference_rod
from reference import supports as reference
from rod_cases import TWO_SUPPORTS, assert_tangents_agree_with_differences, rich_segments

SUPPORTS = [
    *TWO_SUPPORTS,
    {"at": 0.4, "stiffness": (5, 5, 5)},
]


def beam(
    modes=10, radius=1e-2, rigidity=1.0, weight=0.0, *, gravity=1.0, supports=(), strains=("bend_y",), **rod
):
    """One metre with a given E I; rho A = 1 kg/m, or the value for a weight under gravity."""
    young = rigidity / (np.pi / 4 * radius**4)
    density = (weight / gravity if weight else 1.0) / (np.pi * radius**2)
    segment = lissom.Segment(
        1.0, radius, young, 0.4 * young, density, dict.fromkeys(strains, modes), nodes=modes + 14
    )
    return lissom.Rod([segment], gravity=(0, 0, -gravity if weight else 0), supports=supports, **rod)


# Defaults and validation


def test_defaults_are_the_documented_ones():
    support = lissom.Support()
    zero = (0.0, 0.0, 0.0)
    assert support.stiffness == support.rotational_stiffness == zero
    assert support.damping == support.rotational_damping == zero
    assert (support.at, support.position, support.orientation) == (None, None, None)
    assert beam().supports == ()


def test_one_number_stands_for_all_axes():
    support = lissom.Support(stiffness=2, rotational_stiffness=np.float32(0.5), damping=[1, 2, 3])
    assert support.stiffness == (2.0, 2.0, 2.0)
    assert support.rotational_stiffness == (0.5, 0.5, 0.5)
    assert support.damping == (1.0, 2.0, 3.0)


def test_copies_and_pickles_are_equal():
    for arguments in SUPPORTS:
        support = lissom.Support(**arguments)
        assert support == pickle.loads(pickle.dumps(support)) == copy.deepcopy(support)
        assert eval(repr(support), {"Support": lissom.Support}) == support
        assert support != lissom.Support(stiffness=1.0)
    rod = pickle.loads(pickle.dumps(beam(supports=[lissom.Support(stiffness=3)])))
    assert rod.supports == (lissom.Support(stiffness=3),)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"stiffness": -1}, "stiffness: got -1, expected a finite number >= 0"),
        ({"damping": (0, float("nan"), 0)}, r"damping\[1\]: got NaN"),
        ({"position": (0, 0, float("inf"))}, "position"),
        ({"orientation": (1, 1, 0, 0)}, "a quaternion .* of norm 1"),
        ({"at": -1}, "at: got -1"),
        ({"stiffness": (1, 2)}, "stiffness: expected"),
    ],
)
def test_what_makes_no_sense_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        lissom.Support(**arguments)


def test_a_place_beyond_the_end_is_refused():
    with pytest.raises(ValueError, match=r"supports\[0\].at: got 2"):
        beam(supports=[lissom.Support(stiffness=1, at=2.0)])
    with pytest.raises(TypeError, match=r"supports\[0\]: expected lissom\.Support, got int"):
        beam(supports=[3])


def test_scenes_have_supports():
    text = """
version = 1
[[rod]]
[[rod.support]]
at = 0.5
stiffness = [0, 0, 20]
rotational_stiffness = 0.1
damping = 1
position = [0.5, 0, 0.1]
[[rod.support]]
orientation = [0, 0, 0, 1]
rotational_damping = [0, 1, 0]
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
    first = lissom.Support(
        at=0.5, stiffness=(0, 0, 20), rotational_stiffness=0.1, damping=1, position=(0.5, 0, 0.1)
    )
    second = lissom.Support(orientation=(0, 0, 0, 1), rotational_damping=(0, 1, 0))
    assert lissom.Scene.loads(text).model.supports == (first, second)
    with pytest.raises(lissom.SceneError, match=r"rod\[0\]\.support\[0\]\.stiffness\[2\]: got -20"):
        lissom.Scene.loads(text.replace("[0, 0, 20]", "[0, 0, -20]"))


def test_explained():
    assert "springs at 1 place" in beam(supports=[lissom.Support(stiffness=1)]).explain()
    assert "supports" in beam().explain().split("skipped")[1]


# Comparison with the reference


@pytest.mark.parametrize("seed", range(3))
def test_forces_agree_with_the_reference(seed):
    base = {"base_position": (0.3, -2.0, 1.0), "base_orientation": (0.8, 0.2, -0.4, 0.4)}
    segments = rich_segments()
    rod = lissom.Rod(
        [lissom.Segment(**segment) for segment in segments],
        supports=[lissom.Support(**support) for support in SUPPORTS],
        **base,
    )
    wanted = reference.Rod(
        [reference_rod.Segment(**segment) for segment in segments],
        supports=[reference.Support(**support) for support in SUPPORTS],
        **base,
    )
    q, qd, qdd = 0.3 * np.random.default_rng(seed).standard_normal((3, rod.n))
    tau = wanted.inverse_dynamics(q, qd, qdd)
    assert_allclose(rod.inverse_dynamics(q, qd, qdd), tau, rtol=0, atol=1e-7 * np.abs(tau).max())


@pytest.mark.parametrize("strains", [("bend_y", "stretch"), ("torsion", "bend_y", "bend_z", "stretch")])
def test_tangents_agree_with_central_differences(strains):
    """In motion, so that dampers count as well: what they feel turns with the rod."""
    in_plane = len(strains) == 2
    supports = [
        {"damping": (0.2, 0.1, 0.3), "rotational_damping": (0.0, 0.03, 0.0), "stiffness": (20, 40, 5)},
        {"at": 0.4, "rotational_stiffness": 0.3, "position": (0.4, 0.0, 0.2), "damping": 0.4},
    ]
    held = [lissom.Support(**support) for support in (supports if in_plane else SUPPORTS)]
    rod = beam(2, 0.05, strains=strains, supports=held)
    assert_tangents_agree_with_differences(rod, 0.5 * np.random.default_rng(4).standard_normal((3, rod.n)))


vectors = st.tuples(*3 * [st.floats(-1, 1)])
positive = st.tuples(*3 * [st.floats(0, 10)])


@settings(deadline=None, max_examples=30)
@given(positive, positive, vectors, st.floats(0, 1), st.integers(0, 10**6))
def test_a_spring_pulls_with_stiffness_times_displacement(stiffness, rotational, position, at, seed):
    """Force and moment by poses and Jacobians of the place."""
    strains = ("torsion", "bend_y", "bend_z", "stretch")
    q = np.random.default_rng(seed).standard_normal(12)
    spring = lissom.Support(stiffness=stiffness, rotational_stiffness=rotational, at=at, position=position)
    rods = [beam(3, 0.05, strains=strains, supports=supports) for supports in ([], [spring])]
    free, held = (rod.inverse_dynamics(q, 0 * q, 0 * q) for rod in rods)
    pose, jacobian = rods[0].pose(q, at), rods[0].jacobian(q, at)
    force = -np.multiply(stiffness, pose[:3, 3] - position)
    # The anchor has the axes of the world; c_i e_i x a_i summed over the axes e_i of the section.
    factors = np.sum(rotational) / 2 - np.array(rotational)
    moment = sum(c * np.cross(e, a) for c, e, a in zip(factors, pose[:3, :3].T, np.eye(3), strict=True))
    pulled = jacobian.T @ np.concatenate([moment, force])
    assert_allclose(free - held, pulled, rtol=0, atol=1e-9 * (1 + np.abs(free).max()))


@pytest.mark.parametrize("angle", [1e-3, 0.5, 2.0])
def test_a_turn_about_one_axis_meets_the_sine_of_its_angle(angle):
    rod = beam(1, strains=("torsion",), supports=[lissom.Support(rotational_stiffness=(3.0, 100, 50))])
    free = beam(1, strains=("torsion",))
    difference = rod.inverse_dynamics([angle], [0], [0]) - free.inverse_dynamics([angle], [0], [0])
    assert_allclose(difference, 3.0 * np.sin(angle), rtol=1e-12)
    energy = rod.energy([angle], [0]).elastic - free.energy([angle], [0]).elastic
    assert_allclose(energy, 3.0 * (1 - np.cos(angle)), rtol=1e-9)


def test_twist_is_free_where_only_the_direction_is_held():
    rod = beam(1, strains=("torsion",), supports=[lissom.Support(rotational_stiffness=(0, 100, 100))])
    free = beam(1, strains=("torsion",))
    for angle in (0.3, 4.0, 40.0):
        assert_allclose(
            rod.inverse_dynamics([angle], [0], [0]), free.inverse_dynamics([angle], [0], [0]), rtol=1e-12
        )


def test_dampers_resist_velocity():
    support = lissom.Support(damping=(0, 0, 2.0), rotational_damping=(0, 0.5, 0))
    rod, free = beam(3, supports=[support]), beam(3)
    q, qd = np.array([0.5, -0.3, 0.2]), np.array([1.0, 2.0, -1.0])
    motion = rod.jacobian(q, 1.0) @ qd
    power = rod.dissipated_power(q, qd) - free.dissipated_power(q, qd)
    assert_allclose(power, 2.0 * motion[5] ** 2 + 0.5 * motion[1] ** 2, rtol=1e-12)
    difference = rod.inverse_dynamics(q, qd, 0 * q) - free.inverse_dynamics(q, qd, 0 * q)
    assert_allclose(difference @ qd, power, rtol=1e-10)


# Beams held at both ends


@pytest.mark.parametrize("stiffness", [0.0, 1.0, 30.0, 1e4, 1e7])
def test_propped_cantilever(stiffness):
    """Deflection at the prop w L^4 / 8 E I / (1 + k L^3 / 3 E I), the limit of small loads."""
    w = 1e-5
    rod = beam(weight=w, supports=[lissom.Support(stiffness=(0, 0, stiffness))])
    found = lissom.statics(rod)
    assert found.success, found.message
    deflection = -rod.pose(found.q, 1.0)[2, 3]
    assert_allclose(deflection, w / 8 / (1 + stiffness / 3), rtol=1e-8)
    assert found.stability == "stable"


def frequencies(support, number=2):
    rod = beam(14, 1e-4, supports=[support])
    return lissom.modes(rod, np.zeros(rod.n)).angular_frequency[:number]


@pytest.mark.parametrize(
    ("rotational", "exact"),
    [(0.0, [15.418206, 49.964862]), (1.0, [22.373285, 61.672823])],
    ids=["pinned", "clamped"],
)
def test_frequencies_of_beams_held_at_both_ends(rotational, exact):
    """Approached from below, with an error inversely proportional to the stiffness."""
    errors = []
    for stiffness in (1e5, 1e6, 1e7):
        hold = lissom.Support(
            stiffness=(0, 0, stiffness), rotational_stiffness=(0, rotational * stiffness, 0)
        )
        errors.append(1 - frequencies(hold) / exact)
    errors = np.array(errors)
    assert (errors[:2] > 0).all()
    assert_allclose(errors[1] / errors[0], 0.1, rtol=0.02)
    assert_allclose(errors[2], 0, atol=1e-4)


def test_a_moving_beam_on_springs_keeps_its_energy():
    supports = [
        lissom.Support(stiffness=(0, 20, 50), rotational_stiffness=0.2),
        lissom.Support(at=0.4, stiffness=10, position=(0.4, 0.1, 0.05)),
    ]
    rod = beam(2, 0.05, weight=1.0, strains=("torsion", "bend_y", "bend_z"), supports=supports)
    q0 = np.random.default_rng(1).standard_normal(rod.n) * 0.5
    run = lissom.simulate(rod, 0.3, q0=q0, method="radau", rtol=1e-8, atol=1e-10)
    assert run.success, run.message
    assert run.balance.drift < 1e-7
    assert np.ptp(run.balance.elastic) > 0.1


def test_what_dampers_take_is_in_the_balance():
    supports = [lissom.Support(stiffness=(0, 0, 50), damping=0.3, rotational_damping=0.02)]
    rod = beam(4, 0.05, weight=1.0, supports=supports)
    run = lissom.simulate(rod, 2.0, method="radau", rtol=1e-8, atol=1e-10)
    assert run.success, run.message
    assert run.balance.drift < 1e-6
    assert run.balance.dissipated[-1] > 0.1 * np.ptp(run.balance.gravitational)


def test_preloaded_springs_are_in_equilibrium_without_loads():
    """A preloaded spring bends a weightless rod; the load factor scales loads, not supports."""
    rod = beam(supports=[lissom.Support(stiffness=(0, 0, 0.5), position=(1.0, 0, -0.3))])
    found = lissom.statics(rod)
    assert found.success, found.message
    z = rod.pose(found.q, 1.0)[2, 3]
    assert -0.3 < z < -0.02
    force = 0.5 * (-0.3 - z)
    pulled = lissom.statics(beam(tip_force=(0, 0, force)))
    assert_allclose(found.q, pulled.q, rtol=0, atol=1e-7)


def test_linearised_and_continued():
    rod = beam(6, weight=1.0, supports=[lissom.Support(stiffness=(0, 0, 10), damping=0.1)])
    found = lissom.statics(rod)
    model = lissom.linearise(rod, found.q)
    assert (np.linalg.eigvals(model.A).real < 0).all()
    assert lissom.continuation(rod).success


# Clamps at the far end, of any stiffness

STIFF = [1e3, 1e7, 1e12, 1e16]


def clamp(stiffness, x=1.0, angle=0.0):
    """Holds the tip at x on the axis, rotated about it."""
    orientation = (np.cos(angle / 2), np.sin(angle / 2), 0.0, 0.0)
    return lissom.Support(
        stiffness=stiffness, rotational_stiffness=stiffness, position=(x, 0, 0), orientation=orientation
    )


@pytest.mark.parametrize("stiffness", [1e4, 1e10, 1e16])
@pytest.mark.parametrize("strains", [("bend_y", "stretch"), ("torsion", "bend_y", "bend_z", "stretch")])
def test_a_heavy_clamped_beam_from_the_straight_rod(stiffness, strains):
    """w L^4 / 384 E I in the middle, as long as the deflection is small relative to its radius."""
    rod = beam(8, weight=1e-3, supports=[clamp(stiffness)], strains=strains)
    found = lissom.statics(rod)
    assert found.status == "converged", found.message
    assert found.stability == "stable"
    assert found.nit < 10
    assert found.lowest_eigenvalue == pytest.approx(1.0, abs=1e-3)
    sag = -rod.pose(found.q, 0.5)[2, 3]
    assert_allclose(sag, 1e-3 / 384, rtol=max(1e-4, 100 / stiffness))


@pytest.mark.parametrize("stiffness", STIFF)
def test_an_elastica_between_clamps(stiffness):
    """Compressed by a fifth of the length: four times the elastica from clamp to inflection."""
    rod = beam(14, supports=[clamp(stiffness, 0.8)])
    found = lissom.statics(rod, np.full(rod.n, 0.1))
    assert found.success, found.message
    assert found.stability == "stable"
    assert found.nit < 25
    if not 1e6 < stiffness < 1e13:
        # Too soft; or the force is a rounding error of the position times the stiffness.
        return

    def shortened(m):
        k, e = ellipk(m), ellipe(m)
        return 2 * e / k - 1 - 0.8

    m = brentq(shortened, 1e-6, 0.9)
    force = -rod.base_wrench(found.q, 0 * found.q, 0 * found.q)[3]
    assert_allclose(abs(force), (4 * ellipk(m)) ** 2, rtol=1e-5)


@pytest.mark.parametrize("stiffness", STIFF)
def test_a_twisted_and_shortened_rod_is_followed_into_its_helix(stiffness):
    """Step by step, each from the previous shape: it buckles, then coils."""
    strains = ("torsion", "bend_y", "bend_z")
    q, shapes = np.random.default_rng(0).normal(0, 0.1, 24), []
    for step in np.linspace(0, 1, 9)[1:]:
        rod = beam(8, strains=strains, supports=[clamp(stiffness, 1 - 0.15 * step, 6 * step)])
        # Supports of 1e16 N/m have forces that rounding of the shape decides.
        found = lissom.statics(rod, q + 1e-3, space_error=False)
        assert found.success, found.message
        assert found.nit < 60
        q = found.q
        shapes.append(rod.pose(q, 1.0))
    assert_allclose(shapes[-1][:3, 3], [0.85, 0, 0], atol=max(1e-9, 100 / stiffness))


@pytest.mark.parametrize("stiffness", [1e8, 1e12, 1e16])
def test_frequencies_do_not_suffer_from_stiffness(stiffness):
    """Up to the rotary inertia of the exact beam (Euler-Bernoulli, radius 1e-4), with all axes held."""
    hold = lissom.Support(stiffness=stiffness, rotational_stiffness=stiffness)
    rod = beam(14, 1e-4, strains=("torsion", "bend_y", "bend_z"), supports=[hold])
    found = lissom.modes(rod, np.zeros(rod.n))
    exact = np.repeat([22.3732854481, 61.6728228676], 2)
    assert_allclose(found.angular_frequency[:4], exact, rtol=2e-6)
    assert found.stability == "stable"
    # The same about the equilibrium found by statics.
    at_rest = lissom.statics(rod)
    assert_allclose(lissom.modes(rod, at_rest.q).angular_frequency[:4], exact, rtol=2e-6)


@pytest.mark.parametrize("stiffness", [1e5, 1e10, 1e15])
def test_a_clamped_column_buckles_at_four_pi_squared(stiffness):
    load = 50.0
    hold = lissom.Support(stiffness=(0, stiffness, stiffness), rotational_stiffness=stiffness)
    rod = beam(12, supports=[hold], tip_force=(-load, 0, 0))
    found = lissom.continuation(rod)
    assert found.success, found.message
    point = found.path.critical_points[0]
    assert point.kind == "bifurcation"
    assert_allclose(point.load_factor * load, 4 * np.pi**2, rtol=max(1e-8, 100 / stiffness))
    side = lissom.statics(rod, 0.1 * point.directions[0])
    assert side.success, side.message
    assert side.stability == "stable"
