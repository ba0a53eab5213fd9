"""Strain bases other than Legendre's: equal rods if the spans are equal, convergence otherwise."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import lissom
from reference import bases as reference
from rod_cases import assert_tangents_agree_with_differences

BASES = ("legendre", "chebyshev", "monomial", "piecewise_constant", "hermite")
SMOOTH = ("chebyshev", "monomial", "hermite")
STRAINS = {"torsion": 4, "bend_y": 4, "bend_z": 4, "stretch": 4}
#: Sizes of the coordinates of four strains.
SIZES = np.repeat([2, 2, 2, 0.05], 4)


def segment(modes, length=1.0, **changes):
    arguments = {"radius": (0.01, 0.008), "retardation_time": 0.02} | changes
    radius = arguments.pop("radius")
    return lissom.Segment(length, radius, 1e6, 4e5, 1000.0, modes, **arguments)


def loaded(segments):
    """A rod with loads and bodies of every kind."""
    follower = lissom.Load(force=(0.02, -0.01, 0.03), moment=(0.001, 0, 0.002), at=0.37, frame="body")
    wind = lissom.Load(force=(0, 0.1, 0.02), along=(0.2, 0.9))
    camera = lissom.Body(0.01, at=0.6, centre=(0, 0, 0.01), inertia=(1e-5, 2e-5, 2e-5))
    return lissom.Rod(segments, tip_force=(0.01, 0.02, -0.03), loads=[follower, wind], bodies=[camera])


def change_of_basis(kind, modes):
    """T with q_legendre = T q, so that the functions of both bases agree."""
    x = np.linspace(0, 1, 20)
    T = np.linalg.lstsq(
        reference.functions("legendre", modes, x), reference.functions(kind, modes, x), rcond=None
    )[0]
    assert_allclose(
        reference.functions("legendre", modes, x) @ T, reference.functions(kind, modes, x), atol=1e-12
    )
    return T


def on_all(T, strains=4):
    return np.kron(np.eye(strains), T)


@pytest.mark.parametrize("kind", SMOOTH)
def test_cubics_in_any_basis_are_the_same_rod(kind):
    """Forces, matrices, energies, equilibria and motions, by the change of basis."""
    ours, legendre = (loaded([segment(STRAINS, basis=basis)]) for basis in (kind, "legendre"))
    T = on_all(change_of_basis(kind, 4))
    rng = np.random.default_rng(5)
    state = rng.normal(size=(3, 16)) * SIZES
    there = state @ T.T
    forces = T.T @ legendre.inverse_dynamics(*there)
    assert_allclose(ours.inverse_dynamics(*state), forces, rtol=0, atol=1e-11 * np.abs(forces).max())
    for found, exact in zip(ours.tangent(*state), legendre.tangent(*there), strict=True):
        expected = T.T @ exact @ T
        assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())
    assert_allclose(ours.energy(*state[:2]).total, legendre.energy(*there[:2]).total, rtol=1e-11)
    assert_allclose(ours.dissipated_power(*state[:2]), legendre.dissipated_power(*there[:2]), rtol=1e-11)
    places = [0.1, 0.5, 1.0]
    assert_allclose(ours.pose(state[0], places), legendre.pose(there[0], places), atol=1e-12)


@pytest.mark.parametrize("kind", SMOOTH)
@pytest.mark.parametrize("strains", [["bend_y"], ["torsion", "bend_y", "bend_z"]])
def test_equilibria_and_motions_do_not_depend_on_the_basis_of_cubics(kind, strains):
    modes = dict.fromkeys(strains, 4)
    tips, paths = [], []
    for basis in (kind, "legendre"):
        rod = lissom.Rod([segment(modes, basis=basis)], tip_force=(0.01, 0.02, -0.03))
        rest = lissom.statics(rod, space_error=False)
        assert rest.success
        tips.append(rod.pose(rest.q, 1.0))
        motion = lissom.simulate(rod, 0.1, dt=0.01, rtol=1e-12, atol=1e-13)
        assert motion.success
        paths.append(rod.pose(motion.q, 1.0))
    assert_allclose(*tips, atol=1e-8)
    assert_allclose(*paths, atol=1e-9)


@pytest.mark.parametrize("modes", [2, 6])
@pytest.mark.parametrize("kind", SMOOTH)
def test_forces_like_those_of_the_reference(kind, modes):
    if kind == "hermite" and modes == 2:
        return check_lines()
    arguments = (0.5, (0.02, 0.015), 1e6, 4e5, 1000.0, dict.fromkeys(("torsion", "bend_y"), modes), 0.01)
    other = {"base_orientation": (0.8, 0.2, -0.4, 0.4), "tip_force": (0.1, 0.5, -0.3), "tip_mass": 0.1}
    rod = lissom.Rod([lissom.Segment(*arguments, basis=kind)], **other)
    slow = reference.Rod([reference.Segment(*arguments, kind=kind)], **other)
    q, qd, qdd = np.random.default_rng(7).normal(size=(3, rod.n))
    expected = slow.inverse_dynamics(q, qd, qdd)
    assert_allclose(rod.inverse_dynamics(q, qd, qdd), expected, rtol=0, atol=1e-7 * np.abs(expected).max())
    assert_allclose(rod.pose(q, [0.2, 0.5]), slow.poses(q, [0.2, 0.5]), atol=1e-8)


def check_lines():
    """One piece: a line, as with two powers."""
    hermite, powers = (segment({"torsion": 2, "bend_y": 2}, basis=basis) for basis in ("hermite", "monomial"))
    state = np.random.default_rng(2).normal(size=(3, 4))
    forces = [lissom.Rod([part]).inverse_dynamics(*state) for part in (hermite, powers)]
    assert_allclose(*forces, rtol=1e-13)


@pytest.mark.parametrize("kind", BASES)
def test_tangents_agree_with_central_differences(kind):
    two = dict.fromkeys(("torsion", "bend_y", "shear_z"), 4)
    one = dict.fromkeys(("bend_z", "stretch"), 6)
    rod = loaded([segment(two, 0.7, basis=kind), segment(one, 0.4, basis=kind)])
    state = np.random.default_rng(3).normal(size=(3, rod.n)) * 0.3
    assert_tangents_agree_with_differences(rod, state)


@given(st.integers(1, 6), st.integers(0, 2**32 - 1), st.booleans())
@settings(deadline=None, max_examples=12)
def test_pieces_are_segments_of_one_constant_mode(pieces, seed, is_planar):
    strains = ("bend_y",) if is_planar else ("torsion", "bend_y", "bend_z", "stretch", "shear_y")
    modes = dict.fromkeys(strains, pieces)
    radii = np.linspace(0.01, 0.008, pieces + 1)
    whole = loaded([segment(modes, basis="piecewise_constant"), segment({"bend_y": 2}, 0.3)])
    parts = [
        segment(dict.fromkeys(strains, 1), 1 / pieces, radius=tuple(radii[i : i + 2])) for i in range(pieces)
    ]
    row = loaded([*parts, segment({"bend_y": 2}, 0.3)])
    assert whole.nodes == (sum(row.nodes[:-1]), row.nodes[-1])
    assert whole.kernel == row.kernel == ("planar" if is_planar else "spatial")
    state = np.random.default_rng(seed).normal(size=(3, row.n)) * 0.5
    expected = row.inverse_dynamics(*state)
    assert_allclose(whole.inverse_dynamics(*state), expected, rtol=0, atol=1e-11 * np.abs(expected).max())
    for found, exact in zip(whole.tangent(*state), row.tangent(*state), strict=True):
        assert_allclose(found, exact, rtol=0, atol=1e-11 * np.abs(exact).max())
    places = np.linspace(0, min(whole.length, row.length), 9)
    assert_allclose(whole.pose(state[0], places), row.pose(state[0], places), atol=1e-12)
    assert_allclose(whole.jacobian(state[0], 0.77), row.jacobian(state[0], 0.77), atol=1e-12)


def test_pieces_share_a_reference_strain_that_varies():
    """The reference curvature along the segment is evaluated correctly in each piece."""
    modes = {"bend_y": 5, "torsion": 5}
    rods = [
        lissom.Rod(
            [segment(modes, basis=basis, reference_strain=lambda X: (0, 3 * X, X**2, 1 + 0.1 * X, 0, 0))]
        )
        for basis in ("piecewise_constant", "legendre")
    ]
    places = np.linspace(0, 1, 11)
    assert_allclose(*(rod.pose(np.zeros(rod.n), places) for rod in rods), atol=1e-8)


def order(sizes, errors):
    return np.polyfit(np.log(sizes), np.log(errors), 1)[0]


def tip_error(kind, modes, exact=None):
    """Error of the tip in equilibrium under a force."""
    rod = lissom.Rod([segment({"bend_y": modes}, basis=kind)], gravity=(0, 0, 0), tip_force=(0.01, 0, 0.02))
    rest = lissom.statics(rod)
    assert rest.success
    tip = rod.pose(rest.q, 1.0)[[0, 2], 3]
    return tip if exact is None else np.linalg.norm(tip - exact)


def test_pieces_converge_with_second_order_and_cubics_faster():
    exact = tip_error("legendre", 16)
    assert tip_error("legendre", 14, exact) < 1e-11
    pieces, knots = np.array([4, 8, 16, 32]), np.array([3, 4, 5, 7, 9])
    of_pieces = order(1 / pieces, [tip_error("piecewise_constant", m, exact) for m in pieces])
    of_cubics = order(1 / (knots - 1), [tip_error("hermite", 2 * k, exact) for k in knots])
    assert 1.9 < of_pieces < 2.1
    assert of_cubics > 6.5, "tips converge with twice the order of the strain, four"


def test_long_rows_of_pieces_are_solved_by_sweeps():
    rod = lissom.Rod([segment({"bend_y": 30, "bend_z": 30}, basis="piecewise_constant")])
    assert "sweeps along the segments  " in rod.explain().split("skipped")[0]
    assert lissom.statics(rod).success


def test_more_modes_are_compared_where_they_leave_the_others_as_they_are():
    errors = {}
    for kind in ("chebyshev", "monomial", "hermite", "piecewise_constant"):
        rod = lissom.Rod([segment({"bend_y": 4}, basis=kind)])
        # Where an error is more than twice what is asked, its bound by forces is reported without a run.
        run = lissom.simulate(rod, 0.1, method="auto", rtol=1e-2)
        assert run.success
        errors[kind] = run.stats.space_error
    assert errors["hermite"] is errors["piecewise_constant"] is None
    assert errors["monomial"] == pytest.approx(errors["chebyshev"], rel=0.1)


def test_the_default_and_given_values():
    assert segment({"bend_y": 2}).basis == "legendre"
    assert segment({"bend_y": 2}) == segment({"bend_y": 2}, basis="legendre")
    for kind in BASES[1:]:
        part = segment({"bend_y": 4}, basis=kind)
        assert part != segment({"bend_y": 4})
        assert pickle.loads(pickle.dumps(part)) == part
        assert f"basis='{kind}'" in repr(part)
        assert "segment 1, basis" in lissom.Rod([part]).explain()
    assert "segment 1, basis" not in lissom.Rod([segment({"bend_y": 4})]).explain()


@pytest.mark.parametrize(
    ("kind", "modes", "message"),
    [
        ("hermite", {"bend_y": 5}, r"modes\.bend_y: got 5, expected an even number of Hermite modes"),
        ("hermite", {"bend_y": 4, "torsion": 6}, r"modes\.bend_y: got 4, expected 6 .* share their knots"),
        (
            "piecewise_constant",
            {"bend_y": 4, "bend_z": 3},
            r"modes\.bend_z: got 3, expected 4 .* their pieces",
        ),
        ("fourier", {"bend_y": 4}, r"basis: got 'fourier', expected 'legendre' or .*'hermite'"),
    ],
)
def test_modes_that_a_basis_does_not_have(kind, modes, message):
    with pytest.raises(ValueError, match=message):
        segment(modes, basis=kind)


def test_rods_without_modes_and_mixed_rods():
    rigid = [segment({}, basis=kind) for kind in BASES]
    rod = lissom.Rod([*rigid, *(segment({"bend_y": 4}, basis=kind) for kind in BASES)])
    assert rod.n == 20
    assert_allclose(rod.pose(np.zeros(20), 5.0)[:3, 3], [5, 0, 0], rtol=1e-15)
