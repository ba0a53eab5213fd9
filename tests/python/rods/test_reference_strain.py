"""Rods with stress-free curvature, given by constants, tables and functions of the arc length."""

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_bvp
from scipy.interpolate import PchipInterpolator
from scipy.linalg import expm
from scipy.special import fresnel

import lissom
from reference import bases as reference
from rod_cases import assert_tangents_agree_with_differences

NO_GRAVITY = (0, 0, 0)
PLANAR = {"bend_y": 3}
SPATIAL = {"bend_y": 3, "torsion": 2}


def segment(modes=None, length=1.0, **changes):
    return lissom.Segment(length, 0.01, 1e6, 4e5, 1000.0, modes or PLANAR, **changes)


def at_rest(modes, X, **changes):
    rod = lissom.Rod([segment(modes, **changes)], gravity=NO_GRAVITY)
    assert_array_equal(rod.inverse_dynamics(*np.zeros((3, rod.n))), 0)
    return rod.pose(np.zeros(rod.n), X)


def wound(X):
    """A reference strain with all components varying."""
    return (0.3 * X, 1.5 * np.sin(3 * X), np.exp(-X), 1 + 0.05 * np.cos(X), 0.02 * X, 0.01 - 0.03 * X**2)


@pytest.mark.parametrize("modes", [PLANAR, SPATIAL])
@pytest.mark.parametrize("growth", [-3.0, 1.0, 8.0])
def test_a_curvature_that_grows_with_arc_length_makes_eulers_spiral(modes, growth):
    X = np.array([0.0, 0.3, 0.77, 1.0])
    unit = np.sqrt(np.pi / abs(growth))
    sine, cosine = fresnel(X / unit)
    exact = np.column_stack([unit * cosine, 0 * X, -np.sign(growth) * unit * sine])
    function = at_rest(modes, X, reference_strain=lambda X: (0, growth * X, 0, 1, 0, 0))
    table = at_rest(modes, X, reference_strain=([0, 1], [(0, 0, 0, 1, 0, 0), (0, growth, 0, 1, 0, 0)]))
    for pose in (function, table):
        assert_allclose(pose[-1, :3, 3], exact[-1], rtol=0, atol=1e-12)
        assert_allclose(pose[:, :3, 3], exact, rtol=0, atol=1e-6, err_msg="inside")
        angle = np.arctan2(-pose[:, 2, 0], pose[:, 0, 0])
        assert_allclose(wrapped(angle - growth * X**2 / 2), 0, atol=1e-12)


def wrapped(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


@pytest.mark.parametrize("torsion", [0.0, 2.0, -4.0])
def test_bend_about_an_axis_that_turns_makes_a_helix(torsion):
    """In axes that rotate with the bend, it is constant bend and torsion."""
    bend, X = 3.0, np.array([0.2, 0.5, 1.0])
    constant = at_rest(SPATIAL, X, reference_strain=(torsion, bend, 0, 1, 0, 0))
    turning = at_rest(
        {"torsion": 4, "bend_y": 4, "bend_z": 4},
        X,
        reference_strain=lambda X: (0, bend * np.cos(torsion * X), bend * np.sin(torsion * X), 1, 0, 0),
    )
    for x, still, pose in zip(X, constant, turning, strict=True):
        twist = np.array([[0, 0, bend, 1], [0, 0, -torsion, 0], [-bend, torsion, 0, 0], [0, 0, 0, 0]])
        helix = expm(twist * x)
        assert_allclose(still, helix, atol=1e-12)
        c, s = np.cos(torsion * x), np.sin(torsion * x)
        back = np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
        assert_allclose(pose[:3, 3], helix[:3, 3], atol=1e-9)
        assert_allclose(pose[:3, :3], helix[:3, :3] @ back, atol=1e-9)


@pytest.mark.parametrize("kind", ["legendre", "hermite"])
def test_forces_like_those_of_the_reference(kind):
    modes = {"torsion": 4, "bend_y": 4, "bend_z": 4, "stretch": 4, "shear_z": 4}
    arguments = (0.5, (0.02, 0.015), 1e6, 4e5, 1000.0, modes, 0.01)
    other = {"base_orientation": (0.8, 0.2, -0.4, 0.4), "tip_force": (0.1, 0.5, -0.3), "tip_mass": 0.1}
    rod = lissom.Rod([lissom.Segment(*arguments, reference_strain=wound, basis=kind)], **other)
    slow = reference.Rod([reference.Segment(*arguments, kind=kind, reference=wound)], **other)
    rng = np.random.default_rng(7)
    q, qd, qdd = rng.normal(size=(3, rod.n)) * np.repeat([2, 2, 2, 0.05, 0.05], 4)
    expected = slow.inverse_dynamics(q, qd, qdd)
    assert_allclose(rod.inverse_dynamics(q, qd, qdd), expected, rtol=0, atol=1e-7 * np.abs(expected).max())
    assert_allclose(rod.pose(q, [0.2, 0.5]), slow.poses(q, [0.2, 0.5]), atol=1e-8)


@pytest.mark.parametrize(
    "strain",
    [
        wound,
        ([0, 0.2, 0.5], [(0, 1, 0, 1, 0, 0), (2, 0, 1, 1.1, 0, 0), (0, -3, 0, 0.9, 0.1, 0)]),
    ],
    ids=["function", "table"],
)
def test_tangents_agree_with_central_differences(strain):
    modes = {"torsion": 2, "bend_y": 3, "bend_z": 2, "stretch": 1}
    parts = [segment(modes, 0.5, reference_strain=strain, retardation_time=0.02), segment(PLANAR, 0.4)]
    follower = lissom.Load(force=(0.1, 0.2, 0.3), at=0.3, frame="body")
    rod = lissom.Rod(parts, tip_force=(0.2, -0.1, 0.3), loads=[follower])
    state = np.random.default_rng(3).normal(size=(3, rod.n))
    assert_tangents_agree_with_differences(rod, state)


def test_planes_are_left_only_where_the_reference_strain_does():
    planar = segment(reference_strain=lambda X: (0, np.sin(X), 0, 1 + 0.1 * X, 0, 0.2))
    beside = segment(reference_strain=lambda X: (0, np.sin(X), 0.1 * X, 1, 0, 0))
    turned = segment({"bend_z": 1}, reference_strain=([0, 1], [(0, 0, 0, 1, 0, 0), (0, 0, 1, 1, 0, 0)]))
    assert [lissom.Rod([part]).kernel for part in (planar, beside, turned)] == ["planar", "spatial", "planar"]


def test_both_kernels_agree():
    def strain(X):
        return (0, 4 * np.cos(3 * X), 0, 1 + 0.1 * X, 0, 0.2 * X)

    table = (np.linspace(0, 1, 6), [strain(X) for X in np.linspace(0, 1, 6)])
    for reference_strain in (strain, table):
        flat, spatial = (
            lissom.Rod([segment(modes, reference_strain=reference_strain)], tip_force=(0.1, 0, 0.2))
            for modes in (PLANAR, PLANAR | {"torsion": 1})
        )
        assert (flat.kernel, spatial.kernel) == ("planar", "spatial")
        state = np.random.default_rng(1).normal(size=(3, 3))
        with_torsion = np.column_stack([np.zeros(3), state])
        expected = spatial.inverse_dynamics(*with_torsion)[1:]
        scale = np.abs(expected).max()
        assert_allclose(flat.inverse_dynamics(*state), expected, rtol=0, atol=1e-12 * scale)
        places = [0.0, 0.21, 0.6, 1.0]
        assert_allclose(flat.pose(state[0], places), spatial.pose(with_torsion[0], places), atol=1e-13)


def test_a_curved_rod_under_load_bends_like_the_elastica():
    """Collocation of phi' = kappa0 + m / EI, m' = H sin phi - P cos phi; phi points below the horizon."""
    H, P = 0.02, 0.03
    rod = lissom.Rod(
        [segment({"bend_y": 12}, reference_strain=lambda X: (0, 2 * np.sin(4 * X), 0, 1, 0, 0))],
        gravity=NO_GRAVITY,
        tip_force=(H, 0, -P),
    )
    EI = 1e6 * np.pi * 0.01**4 / 4

    def rate(X, y):
        phi, m, _, _ = y
        bend = 2 * np.sin(4 * X) + m / EI
        return np.array([bend, -P * np.cos(phi) + H * np.sin(phi), np.cos(phi), -np.sin(phi)])

    def ends(a, b):
        return np.array([a[0], a[2], a[3], b[1]])

    X = np.linspace(0, 1, 100)
    exact = solve_bvp(rate, ends, X, np.array([0 * X, 0 * X, X, 0 * X]), tol=1e-9, max_nodes=20000)
    assert exact.success
    found = lissom.statics(rod)
    assert found.success
    _, _, x, z = exact.y[:, -1]
    assert_allclose(rod.pose(found.q, 1.0)[:3, 3], [x, 0, z], atol=1e-8)
    assert np.abs(found.q).max() > 0.4, "the loads matter"


def test_the_energy_balance_of_a_curved_rod_closes():
    rod = lissom.Rod([segment(SPATIAL, reference_strain=wound, retardation_time=0.02)])
    motion = lissom.simulate(rod, 0.05, dt=0.01, method="radau", rtol=1e-7, atol=1e-8)
    assert motion.success
    assert motion.balance.dissipated[-1] > 0.005 * motion.balance.scale
    assert motion.balance.drift < 1e-5


def test_profiles_in_and_out():
    stations, values = np.array([0, 0.3, 1.0]), np.tile([0, 0.5, 0, 1, 0, 0.1], (3, 1)) * [[1], [2], [3]]
    table = segment(reference_strain=(stations, values))
    profile = table.reference_strain
    assert_array_equal(profile.stations, stations)
    assert_array_equal(profile.values, values)
    assert (profile.coefficients, profile.length) == (None, 1.0)
    function = segment(reference_strain=wound)
    assert function.reference_strain.stations is None
    assert_allclose(function.reference_strain([0.1, 0.7]), [wound(0.1), wound(0.7)], atol=1e-14)
    constant = segment(reference_strain=lambda X: (0, 1, 0, 1, 0, 0))
    assert constant == segment(reference_strain=(0, 1, 0, 1, 0, 0))
    assert constant.reference_strain == (0, 1, 0, 1, 0, 0)
    for part in (table, function):
        twins = [
            copy.deepcopy(part),
            pickle.loads(pickle.dumps(part)),
            segment(reference_strain=part.reference_strain),
        ]
        assert all(twin == part for twin in twins)
        assert part != constant
        assert "lissom.Profile" in repr(part)
    assert "of degree" in repr(function.reference_strain)
    assert "table of 3 stations" in repr(profile)
    assert "a table of 3 stations in X" in lissom.Rod([table]).explain()


@given(
    st.lists(st.floats(0.01, 1), min_size=1, max_size=8),
    st.data(),
)
@settings(deadline=None, max_examples=50)
def test_tables_are_interpolated_as_scipy_does(widths, data):
    stations = np.concatenate([[0], np.cumsum(widths)])
    # The reciprocals that SciPy forms of subnormal differences overflow.
    numbers = st.floats(-10, 10, allow_subnormal=False)
    values = data.draw(st.lists(numbers, min_size=len(stations), max_size=len(stations)))
    profile = lissom.Profile(stations[-1], stations=stations, values=values)
    X = np.linspace(0, stations[-1], 57)
    expected = PchipInterpolator(stations, values)(X) if len(stations) > 2 else np.interp(X, stations, values)
    assert_allclose(profile(X), expected, rtol=0, atol=1e-12 * max(1, np.abs(values).max()))


def test_values_of_any_shape():
    table = lissom.Profile(2.0, stations=[0, 1, 2], values=np.arange(18.0).reshape(3, 2, 3))
    assert_allclose(table(1.0), np.arange(6.0, 12).reshape(2, 3))
    assert table([0.5, 1.5]).shape == (2, 2, 3)
    line = lissom.Profile(2.0, coefficients=[1.0, 2.0])
    assert line(0.0) == -1
    assert line(2.0) == 3
    assert pickle.loads(pickle.dumps(table)) == table


@pytest.mark.parametrize(
    ("strain", "message"),
    [
        (
            lambda X: (0, abs(X - 0.3), 0, 1, 0, 0),
            r"does not become smooth at X = 0\.[23]\d*: split the segment",
        ),
        (lambda X: (0, np.log(X) if X else np.nan, 0, 1, 0, 0), r"reference_strain: got NaN at X = 0"),
        (lambda X: (0, X), r"reference_strain\(X\): expected 6 values, got 2"),
        (lambda X: (0, 0, 0, 0.5 - X, 0, 0), r"reference_strain\[3\]: got -0\.5 at X = 1.*stretch > 0"),
        (
            ([0, 0.5], np.tile([0, 0, 0, 1.0, 0, 0], (2, 1))),
            r"reference_strain\.stations\[1\]: got 0\.5, expected 1",
        ),
        (([0, 0, 1], np.tile([0, 0, 0, 1.0, 0, 0], (3, 1))), r"stations\[1\]: got 0, expected more than"),
        (
            ([0, 1], np.tile([0, 0, 0, 1.0, 0], (2, 1))),
            r"values: expected 2 of shape \[6\], one for each station",
        ),
        (([0, 1], [(0, 0, 0, 1, 0, 0)]), r"1 rows, expected one row for each of the 2 stations"),
        (lissom.Profile(2.0, stations=[0, 2], values=np.ones((2, 6))), r"over 2 m, expected one over.*1 m"),
        (lissom.Profile(1.0, stations=[0, 1], values=[1, 2]), r"values of shape \[\]"),
    ],
)
def test_reference_strains_that_are_refused(strain, message):
    with pytest.raises(ValueError, match=message):
        segment(reference_strain=strain)


def test_exceptions_of_the_function_are_raised_unchanged():
    def strain(X):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        segment(reference_strain=strain)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "either stations and values, or coefficients"),
        ({"stations": [0, 1]}, "either stations and values, or coefficients"),
        ({"stations": [0, 2], "values": [1, 1]}, r"stations\[1\]: got 2, expected 1"),
        ({"coefficients": np.ones((200, 2))}, "coefficients: got 200 rows"),
    ],
)
def test_profiles_that_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        lissom.Profile(1.0, **arguments)
    with pytest.raises(ValueError, match="X: got 2"):
        lissom.Profile(1.0, coefficients=[1.0])(2.0)


@pytest.mark.parametrize("turns", [0.25, 1.0, 4.25, 8.25, 20.25])
def test_rods_that_are_wound_at_rest_are_resolved_by_default(turns):
    curvature = 2.0 * np.pi * turns

    def wound(nodes=None):
        reference = (0, curvature, 0, 1, 0, 0)
        segment = lissom.Segment(1.0, 1e-3, 2e9, 8e8, 1200.0, {"bend_y": 2}, 0.0, reference, nodes=nodes)
        return lissom.Rod([segment])

    rod = wound()
    tip = rod.pose([0.0, 0.0], 1.0)[[0, 2], 3]
    exact = np.array([np.sin(curvature), np.cos(curvature) - 1.0]) / curvature
    np.testing.assert_allclose(tip, exact, atol=1e-12)
    many = wound(3 * rod.nodes[0])
    state = ([0.1, 0.2], [0.3, -0.1], [1.0, 2.0])
    right = many.inverse_dynamics(*state)
    np.testing.assert_allclose(rod.inverse_dynamics(*state), right, atol=1e-9 * np.abs(right).max())


def test_a_wound_rest_shape_that_the_nodes_miss_is_refused():
    reference = (0, 2.0 * np.pi * 20.0, 0, 1, 0, 0)
    segment = lissom.Segment(1.0, 1e-3, 2e9, 8e8, 1200.0, {"bend_y": 2}, reference_strain=reference, nodes=12)
    with pytest.raises(ValueError, match="q0: got a rod that turns by more than half a turn"):
        lissom.simulate(lissom.Rod([segment]), 0.1)
