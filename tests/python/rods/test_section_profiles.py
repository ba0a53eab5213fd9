"""Sections as functions of the arc length: tables and callables, exact solutions and linear tapers."""

import copy
import pickle
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

import lissom
from lissom import Section

STEEL = {"young_modulus": 2.1e11, "shear_modulus": 8e10, "density": 7800.0}
LENGTH = 0.5
WEIGHTLESS = (0.0, 0.0, 0.0)
ALL = dict.fromkeys(("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"), 3)
STATIONS = np.array([0.0, 0.1, 0.25, 0.4, 0.5])
RADII = np.array([0.01, 0.02, 0.018, 0.006, 0.004])


def exponential(X):
    return 0.01 * np.exp(-3.0 * X)


def of_circle(radius):
    """Properties of a circular steel section for `Section.given`."""
    E, G, rho = STEEL.values()

    def stiffness(X):
        r = radius(X)
        A, I = np.pi * r**2, np.pi * r**4 / 4
        return (2 * G * I, E * I, E * I, E * A, G * A, G * A)

    def mass(X):
        return rho * np.pi * radius(X) ** 2

    def inertia(X):
        I = rho * np.pi * radius(X) ** 4 / 4
        return np.diag([2 * I, I, I])

    return Section.given(stiffness, mass, inertia, length=LENGTH)


VARYING = [
    Section.circle(exponential, length=LENGTH),
    Section.circle((STATIONS, RADII)),
    Section.hollow_circle((STATIONS, RADII), (0.002, 0.001)),
    Section.rectangle(0.01, lambda X: 0.002 + 0.1 * X**2, length=LENGTH),
    Section.ellipse(semi_axis_y=([0.0, 0.2, LENGTH], [0.01, 0.02, 0.01]), semi_axis_z=0.004),
    of_circle(exponential),
    Section.given((1.0,) * 6, (STATIONS, RADII), centre=([0.0, LENGTH], [[0.0, 0.1], [0.1, 0.0]])),
]


def segment(section, modes=ALL, **more):
    material = {} if section.shape == "given" else STEEL
    return lissom.Segment(LENGTH, section=section, modes=modes, **material, **more)


def rod(section, modes=ALL, **more):
    return lissom.Rod([segment(section, modes)], **more)


def assert_same_rods(first, second, rtol):
    """Compares mass matrix, tangents and stiffness of two rods in a bent state."""
    q = 0.3 * np.cos(np.arange(first.n))
    state = q, 2.0 * q[::-1], 3.0 * q
    rest = np.zeros(first.n)
    pairs = [
        (model.mass_matrix(q), *model.tangent(*state), model.tangent(rest, rest, rest)[0])
        for model in (first, second)
    ]
    for found, wanted in zip(*pairs, strict=True):
        assert_allclose(found, wanted, rtol=0, atol=rtol * abs(wanted).max())


@pytest.mark.parametrize("section", VARYING, ids=lambda section: section.shape)
def test_sections_that_vary_are_values(section):
    assert copy.deepcopy(section) == section == pickle.loads(pickle.dumps(section))
    piece = segment(section)
    assert piece == pickle.loads(pickle.dumps(piece))
    assert piece.section == section
    assert sum(section == other for other in VARYING) == 1
    assert "<lissom.Profile: " in repr(section)
    assert "<lissom.Profile: " in repr(piece)
    assert section != Section.circle(0.01) != piece.section


def test_profiles_come_back():
    section = VARYING[1]
    profile = section.parameters["radius"]
    assert isinstance(profile, lissom.Profile)
    assert Section.circle(profile) == section
    assert Section.hollow_circle((0.03, 0.02), profile).parameters["outer"] == (0.03, 0.02)
    X = np.linspace(0.0, LENGTH, 33)
    assert_allclose(profile(X), PchipInterpolator(STATIONS, RADII)(X), rtol=1e-13)
    assert_allclose([section.half_extents(x / LENGTH)[0] for x in X], profile(X), rtol=1e-13)
    assert_allclose(VARYING[0].area(0.4), np.pi * exponential(0.2) ** 2, rtol=1e-13)
    by_radius = lissom.Segment(LENGTH, exponential, modes={"bend_y": 2}, **STEEL)
    assert by_radius == segment(VARYING[0], {"bend_y": 2})
    assert by_radius.radius(0.2) == pytest.approx(exponential(0.2), rel=1e-13)
    given = segment(VARYING[6])
    assert given.inertia(0.25)[3, 3] == pytest.approx(PchipInterpolator(STATIONS, RADII)(0.25), rel=1e-13)
    # A callable with a constant value is constant.
    assert Section.circle(lambda X: 0.01, length=LENGTH) == Section.circle(0.01)


def test_a_pair_of_numbers_tapers_and_a_pair_of_arrays_is_a_table():
    taper, table = Section.circle([0.02, 0.01]), Section.circle([[0.0, LENGTH], [0.02, 0.01]])
    assert taper.parameters["radius"] == (0.02, 0.01)
    assert table.parameters["radius"].stations.tolist() == [0.0, LENGTH]
    assert_same_rods(rod(table), rod(taper), 1e-12)
    assert rod(table).nodes == rod(taper).nodes


@pytest.mark.parametrize("shape", ["circle", "hollow_circle", "rectangle", "ellipse"])
def test_linear_functions_are_linear_tapers(shape):
    make = getattr(Section, shape)
    ends = [(0.02, 0.015), (0.005, 0.012)][: 1 if shape == "circle" else 2]
    functions = [lambda X, base=base, tip=tip: base + (tip - base) * X / LENGTH for base, tip in ends]
    first, second = rod(make(*functions, length=LENGTH)), rod(make(*ends))
    assert first.nodes == second.nodes
    assert_same_rods(first, second, 1e-12)


@pytest.mark.parametrize("radius", [lambda X: 0.01 - 0.01 * X, exponential], ids=["linear", "exponential"])
def test_a_given_section_with_the_numbers_of_a_circle_is_that_circle(radius):
    given, circle = of_circle(radius), Section.circle(radius, length=LENGTH)
    assert_allclose(given.half_extents(0.3), circle.half_extents(0.3), rtol=1e-13)
    assert_same_rods(rod(given), rod(circle), 1e-10)


@pytest.mark.parametrize("section", VARYING, ids=lambda section: section.shape)
def test_default_nodes_see_how_sections_vary(section):
    """Default quadrature compared with 128 nodes."""
    modes = {"torsion": 2, "bend_y": 3, "bend_z": 3}
    first = lissom.Rod([segment(section, modes)])
    second = lissom.Rod([segment(section, modes, nodes=128)])
    assert first.nodes[0] < 64 < second.nodes[0]
    assert_same_rods(first, second, 1e-10)


@pytest.mark.parametrize("number", [20, 40])
def test_long_tables_are_seen_by_one_rule(number):
    stations = np.linspace(0.0, LENGTH, number)
    section = Section.circle((stations, 0.01 * (2.0 + np.sin(20.0 * stations))))
    default, fine = rod(section), lissom.Rod([segment(section, nodes=256)])
    assert number < default.nodes[0] < number + 30
    q = 0.1 * np.cos(np.arange(default.n))
    wanted = fine.mass_matrix(q)
    assert_allclose(default.mass_matrix(q), wanted, rtol=0, atol=4e-4 * wanted.max())
    # The stiffness is integrated from station to station, for any nodes.
    rest = np.zeros(default.n)
    stiffnesses = [
        lissom.Rod([segment(section, nodes=nodes)], gravity=WEIGHTLESS).tangent(rest, rest, rest)[0]
        for nodes in (None, 256)
    ]
    assert_allclose(*stiffnesses, rtol=1e-12, atol=1e-12 * stiffnesses[1].max())


def test_a_cantilever_of_exponential_stiffness_sags_as_it_should():
    """With E I = B exp(-a X) the tip deflection is F/B int (L - X)^2 exp(a X) dX."""
    a, force = 12.0, 1e-4
    B = STEEL["young_modulus"] * np.pi * 0.01**4 / 4
    exact = force / B * (2 * np.exp(a * LENGTH) - 2 - 2 * a * LENGTH - (a * LENGTH) ** 2) / a**3
    beam = rod(
        Section.circle(exponential, length=LENGTH),
        {"bend_y": 16},
        gravity=WEIGHTLESS,
        tip_force=(0, 0, -force),
    )
    found = lissom.statics(beam)
    assert found.success
    assert_allclose(-beam.pose(found.q, LENGTH)[2, 3], exact, rtol=1e-9)


def test_a_cantilever_of_exponential_width_sounds_as_it_should():
    """With E I and rho A as exp(-b X): w'''' - 2 b w''' + b^2 w'' = p^4 w, with exact roots."""
    b, stiffness, mass = 4.0, 2.0, 0.3

    def clamped_and_free(p):
        # (s^2 - b s)^2 = p^4.
        discriminants = np.array([b**2 + 4 * p**2, b**2 - 4 * p**2], dtype=complex)
        s = np.concatenate([(b + sign * np.sqrt(discriminants)) / 2 for sign in (1, -1)])
        end = np.exp(s * LENGTH)
        # The phase of the determinant is the same for all p beyond b/2, where two roots are conjugate.
        return np.linalg.det([np.ones(4), s, s**2 * end, s**3 * end]).imag

    grid = np.linspace(b / 2 + 0.1, 25.0, 400)
    signs = np.sign([clamped_and_free(p) for p in grid])
    brackets = zip(grid[:-1][signs[1:] != signs[:-1]], grid[1:][signs[1:] != signs[:-1]], strict=True)
    roots = np.array([brentq(clamped_and_free, *bracket, xtol=1e-14) for bracket in brackets])
    assert len(roots) >= 3
    section = Section.given(
        lambda X: stiffness * np.exp(-b * X) * np.ones(6), lambda X: mass * np.exp(-b * X), length=LENGTH
    )
    beam = rod(section, {"bend_y": 14}, gravity=WEIGHTLESS)
    frequency = lissom.modes(beam, np.zeros(beam.n)).frequency
    assert_allclose(frequency[:3], roots[:3] ** 2 * np.sqrt(stiffness / mass) / (2 * np.pi), rtol=1e-9)


@pytest.mark.parametrize("index", [1, 5], ids=["table", "given"])
def test_the_energy_balance_of_a_run_closes(index):
    model = lissom.Rod(
        [segment(VARYING[index], {"torsion": 1, "bend_y": 2, "bend_z": 2}, retardation_time=1e-4)]
    )
    balance = lissom.simulate(model, 0.004, dt=0.001, method="radau", rtol=1e-9, atol=1e-11).balance
    assert balance.drift < 1e-6


def test_a_fluid_makes_way_for_what_varies():
    water = lissom.Fluid(1000.0)
    linear = lissom.Segment(LENGTH, (0.02, 0.01), modes=ALL, **STEEL)
    function = lissom.Segment(LENGTH, lambda X: 0.02 - 0.02 * X, modes=ALL, **STEEL)
    assert_same_rods(lissom.Rod([function], fluid=water), lissom.Rod([linear], fluid=water), 1e-12)
    # Neutrally buoyant everywhere: no net force.
    float_ = lissom.Segment(LENGTH, (STATIONS, RADII), 1e9, 4e8, 1000.0, modes=ALL)
    rest = np.zeros(18)
    force = lissom.Rod([float_], fluid=water).inverse_dynamics(rest, rest, rest)
    assert abs(force).max() < 1e-12 * abs(lissom.Rod([float_]).inverse_dynamics(rest, rest, rest)).max()


def test_the_stiffness_of_pieces_is_the_integral_of_the_table():
    beam = lissom.Rod([segment(VARYING[1], {"bend_y": 3}, basis="piecewise_constant")], gravity=WEIGHTLESS)
    stiffness = beam.tangent(*np.zeros((3, 3)))[0]
    profile = PchipInterpolator(STATIONS, RADII)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    kinks = np.unique([*STATIONS, LENGTH / 3, 2 * LENGTH / 3])
    wanted = np.zeros(3)
    for start, end in pairwise(kinks):
        half, middle = (end - start) / 2, (start + end) / 2
        second_moments = np.pi * profile(middle + half * nodes) ** 4 / 4
        wanted[int(3 * middle / LENGTH)] += half * weights @ (STEEL["young_modulus"] * second_moments)
    assert_allclose(stiffness, np.diag(wanted), rtol=1e-12, atol=1e-12 * wanted.max())


def test_explanations_name_what_varies():
    text = str(rod(VARYING[1]).explain())
    assert "circle: at the cost of a circle; in X radius a table of 5 stations" in text
    assert "for its modes and its taper" in text
    assert "stiffness a polynomial of degree" in str(rod(VARYING[5]).explain())


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: Section.circle(exponential),
            r"radius: a function of the arc length X needs `length`",
        ),
        (
            lambda: Section.circle(lambda X: 0.1 - X, length=0.2),
            r"radius: got -?[0-9.e-]+ at X = 0\.1.*finite number > 0",
        ),
        (lambda: Section.circle(([0, 0.1, 0.3], [0.1, 0, 0.1])), r"radius: got 0 at X = 0\.1, expected"),
        (lambda: Section.circle(([0, 0.2, 0.1], [1, 1, 1])), r"radius\.stations\[2\]: got 0\.1"),
        (lambda: Section.circle(([0, 0.2], [1, 1]), length=0.3), r"radius.*got.*0\.2, expected.*0\.3"),
        (lambda: Section.circle(([0, 0.2], [1, 1, 1])), r"radius\.values: got 3 rows"),
        (lambda: Section.circle(exponential, length=-1.0), r"length: got -1"),
        (lambda: Section.circle(lambda X: np.nan, length=1.0), r"radius: got NaN at X = 0, expected finite"),
        (
            lambda: Section.circle(lambda X: 1 + abs(X - 0.3), length=1.0),
            r"radius: does not become smooth at X",
        ),
        (
            lambda: Section.hollow_circle(0.1, lambda X: 0.2 * X, length=1.0),
            r"inner: got 0\.1 at X = 0\.5, expected less than the outer radius",
        ),
        (
            lambda: Section.rectangle(([0, 0.2], [1, 1]), ([0, 0.3], [1, 1])),
            r"height.*got 0\.3, expected 0\.2, the segment's length",
        ),
        (lambda: segment(Section.circle(exponential, length=1.0)), r"section: got one for 1 m.*0\.5 m"),
        (lambda: Section.given(np.ones(6), lambda X: 1 - 2 * X, length=1.0), r"mass: got 0 at X = 0\.5"),
        (
            lambda: Section.given(lambda X: np.ones(6), lambda X: 1 + X, lambda X: (1, 1, 3 * X), length=1.0),
            r"inertia: got the principal moments .* at X = 0\.66",
        ),
        (
            lambda: Section.given(lambda X: np.eye(6) + X * np.eye(6, k=1), 1.0, length=1.0),
            r"stiffness\[1\]\[0\]: got 0, but 0\.0039.* at X = 0\.0039.*a symmetric matrix",
        ),
        (
            lambda: segment(Section.given(lambda X: (1, 1 - 4 * X, 1, 1, 1, 1), 1.0, length=LENGTH)),
            r"section\.stiffness\[1\]\[1\]: got 0 at X = 0\.25, expected a positive stiffness, as bend_y",
        ),
        (
            lambda: segment(
                Section.given(
                    lambda X: np.eye(6) + 4 * X * (np.eye(6, k=1) + np.eye(6, k=-1)), 1.0, length=LENGTH
                )
            ),
            r"section\.stiffness: got a matrix that is not positive definite at X = ",
        ),
        (
            lambda: Section.given(lambda X: np.ones(5), 1.0, length=1.0),
            r"stiffness\(X\): expected.*\(6,\) or",
        ),
        (lambda: Section.given(np.ones(6), ([0, 1], [[1, 1], [2, 2]])), r"mass, values: expected 2 of shape"),
    ],
)
def test_what_is_wrong_is_named_with_its_place(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_what_has_the_wrong_type_is_named():
    with pytest.raises(TypeError, match=r"radius: expected a number or \(base, tip\) in metres, a table"):
        Section.circle("thick")
    with pytest.raises(TypeError, match=r"mass: expected a number"):
        Section.given(np.ones(6), "heavy")
    with pytest.raises(TypeError, match=r"radius\(X\): expected a number"):
        Section.circle(lambda X: "thick", length=1.0)


def test_what_a_callable_raises_comes_through():
    def fails(X):
        raise KeyError(X)

    with pytest.raises(KeyError):
        Section.circle(fails, length=1.0)


def test_scenes_take_tables_of_sizes():
    text = """
version = 1
[[rod]]
[[rod.segment]]
length = 0.5
radius = { stations = [0, 0.1, 0.25, 0.4, 0.5], values = [0.01, 0.02, 0.018, 0.006, 0.004] }
young_modulus = 2.1e11
shear_modulus = 8e10
density = 7800
modes = { bend_y = 2 }
[simulation]
t_end = 1
"""
    (found,) = lissom.Scene.loads(text).model.segments
    assert found == segment(VARYING[1], {"bend_y": 2})
    with pytest.raises(lissom.SceneError, match=r"radius\.stations\[2\]: got 0\.25.*more than"):
        lissom.Scene.loads(text.replace("0.1, 0.25", "0.3, 0.25"))
    with pytest.raises(lissom.SceneError, match=r"radius: got -0\.01 at X = 0;"):
        lissom.Scene.loads(text.replace("[0.01", "[-0.01"))
