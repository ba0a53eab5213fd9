"""Sections: properties, errors, rods with them compared with the NumPy reference and exact solutions."""

import copy
import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom
from lissom import Section
from reference.rod import torsion_of_rectangle
from rod_cases import COUPLED, Case, mixed_segments, random_states, rich_bodies, rich_loads

SECTIONS = [
    Section.circle(0.01),
    Section.hollow_circle((0.02, 0.01), 0.005),
    Section.rectangle(0.1, height=(0.2, 0.1)),
    Section.ellipse(semi_axis_y=0.1, semi_axis_z=0.2),
    Section.given(COUPLED, 0.7, (1.0, 2.0, 2.5), centre=(0.1, 0.2)),
]
STEEL = {"young_modulus": 2.1e11, "shear_modulus": 8e10, "density": 7800.0}
WEIGHTLESS = (0.0, 0.0, 0.0)


@pytest.mark.parametrize("section", SECTIONS, ids=lambda section: section.shape)
def test_sections_are_values(section):
    assert copy.deepcopy(section) == section == pickle.loads(pickle.dumps(section))
    assert eval(repr(section), {"Section": Section}) == section
    material = {} if section.shape == "given" else STEEL
    segment = lissom.Segment(0.5, section=section, modes={"bend_y": 2}, **material)
    names = {"Segment": lissom.Segment, "Section": Section}
    assert segment == pickle.loads(pickle.dumps(segment)) == eval(repr(segment), names)
    assert segment.section == section
    assert sum(section == other for other in SECTIONS) == 1


def test_a_radius_is_a_circle():
    by_radius = lissom.Segment(0.5, (0.02, 0.01), modes={"bend_y": 2}, **STEEL)
    assert by_radius == lissom.Segment(
        0.5, section=Section.circle((0.02, 0.01)), modes={"bend_y": 2}, **STEEL
    )
    assert by_radius.radius == (0.02, 0.01)
    assert lissom.Segment(0.5, section=SECTIONS[2], modes={}, **STEEL).radius is None
    assert by_radius.shear_correction == 1.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Section.circle(0.0), r"radius: got 0, expected a finite number > 0"),
        (lambda: Section.hollow_circle(0.1, 0.1), r"inner: got \[0\.1, 0\.1\], expected less than the outer"),
        (lambda: Section.hollow_circle(0.1, -0.1), r"inner: got -0\.1, expected a finite number >= 0"),
        (lambda: Section.rectangle((0.1, np.nan), 0.1), r"width\[1\]: got NaN"),
        (lambda: Section.ellipse(0.1, -1.0), r"semi_axis_z: got -1"),
        (lambda: Section.given(np.eye(6), 0.0), r"mass: got 0"),
        (
            lambda: Section.given(np.eye(5), 1.0),
            r"stiffness: expected shape \(6,\) or \(6, 6\), got an array",
        ),
        (lambda: Section.given(np.triu(np.ones((6, 6))), 1.0), r"stiffness\[1\]\[0\].*a symmetric matrix"),
        (lambda: Section.given(np.eye(6), 1.0, (1, 1, 3)), r"inertia.*as every body has"),
        (lambda: Section.circle(1.0).area(1.5), r"x: got 1\.5.*0 to 1"),
        (lambda: SECTIONS[4].area(), r"given section has no shape"),
        (lambda: lissom.Segment(1.0, modes={}, **STEEL), r"radius: got neither radius nor section"),
        (lambda: lissom.Segment(1.0, 0.1, section=SECTIONS[0], modes={}, **STEEL), r"got both radius and"),
        (lambda: lissom.Segment(1.0, 0.1, modes={}), r"young_modulus.*\n?.*shear_modulus.*\n?.*density"),
        (lambda: lissom.Segment(1.0, 0.1, **STEEL), r"modes: got none, expected a dict"),
        (
            lambda: lissom.Segment(1.0, section=SECTIONS[4], modes={}, density=1.0),
            r"density: got 1.*given section",
        ),
        (
            lambda: lissom.Segment(1.0, section=SECTIONS[4], modes={}, shear_correction=0.9),
            r"shear_correction.*given section is complete",
        ),
        (
            lambda: lissom.Segment(1.0, section=Section.given((1, 0, 1, 1, 1, 1), 1.0), modes={"bend_y": 1}),
            r"section\.stiffness\[1\]\[1\]: got 0, expected a positive stiffness, as bend_y has modes",
        ),
        (
            lambda: lissom.Segment(
                1.0,
                section=Section.given(np.eye(6) + np.eye(6, k=1) + np.eye(6, k=-1), 1.0),
                modes={"torsion": 1, "bend_y": 1, "bend_z": 1},
            ),
            r"section\.stiffness: got a matrix that is not positive definite",
        ),
        (lambda: lissom.Segment(1.0, 0.1, modes={}, shear_correction="best", **STEEL), r"'best'.*'cowper'"),
        (
            lambda: lissom.Segment(1.0, 0.1, modes={}, shear_correction=(1, -1), **STEEL),
            r"shear_correction\[1\]",
        ),
    ],
)
def test_what_is_wrong_is_named(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_what_has_the_wrong_type_is_named():
    with pytest.raises(TypeError, match="width: expected a number or"):
        Section.rectangle("wide", 1.0)
    with pytest.raises(TypeError, match="shear_correction"):
        lissom.Segment(1.0, 0.1, modes={}, shear_correction=[1, 2, 3], **STEEL)


def test_constants():
    rectangle = Section.rectangle(0.02, (0.05, 0.03))
    assert_allclose(rectangle.area(0.5), 0.02 * 0.04)
    assert_allclose(rectangle.second_moments(1.0), (0.02 * 0.03**3 / 12, 0.03 * 0.02**3 / 12))
    assert_allclose(rectangle.torsion_constant(), torsion_of_rectangle(0.05, 0.02), rtol=1e-12)
    # Timoshenko and Goodier, section 109.
    assert_allclose(Section.rectangle(2.0, 2.0).torsion_constant(), 0.140577 * 2.0**4, rtol=2e-6)
    assert_allclose(Section.ellipse(2.0, 1.0).torsion_constant(), np.pi * 8 / 5)
    # Cowper 1966, table 1.
    assert_allclose(rectangle.cowper(0.3), [10 * 1.3 / 15.3] * 2)
    assert_allclose(Section.circle(1.0).cowper(0.5), [0.9, 0.9])
    assert rectangle.half_extents() == (0.01, 0.025)
    # An ellipse with its radii of gyration represents a given section.
    ellipse = lissom.Segment(1.0, section=Section.ellipse(0.2, 0.1), modes={}, **STEEL)
    inertia = ellipse.inertia()
    given = Section.given(ellipse.stiffness(), inertia[3, 3], inertia[:3, :3])
    assert_allclose(given.half_extents(), (0.2, 0.1))


def test_stiffness_and_inertia_of_a_segment():
    segment = lissom.Segment(
        2.0, section=Section.rectangle(0.02, (0.05, 0.03)), modes={}, shear_correction="cowper", **STEEL
    )
    assert segment.shear_correction == "cowper"
    A, (I_y, I_z) = 0.02 * 0.04, (0.02 * 0.04**3 / 12, 0.04 * 0.02**3 / 12)
    E, G, rho = STEEL.values()
    nu = E / (2 * G) - 1
    k = 10 * (1 + nu) / (12 + 11 * nu)
    J = torsion_of_rectangle(0.04, 0.02)
    assert_allclose(segment.stiffness(1.0), np.diag([G * J, E * I_y, E * I_z, E * A, k * G * A, k * G * A]))
    # The rotary inertia about the axis is that of the polar moment, not of the torsion constant.
    assert_allclose(segment.inertia(1.0), rho * np.diag([I_y + I_z, I_y, I_z, A, A, A]))
    with pytest.raises(ValueError, match=r"X: got 3.*from 0 to 2"):
        segment.stiffness(3.0)
    offset = lissom.Segment(1.0, section=Section.given(np.eye(6), 2.0, centre=(0.1, 0.3)), modes={})
    w, v = np.array([1.0, -2.0, 0.5]), np.array([0.3, 0.2, -0.1])
    c = np.array([0.0, 0.1, 0.3])
    momentum = 2.0 * (v + np.cross(w, c))
    assert_allclose(offset.inertia() @ [*w, *v], [*np.cross(c, momentum), *momentum])


def mixed_case():
    return Case(
        mixed_segments(),
        tip_mass=0.05,
        loads=rich_loads()[:2],
        bodies=rich_bodies()[:1],
        base_orientation=(0.8, 0.2, -0.4, 0.4),
        base_position=(1.0, 2.0, 3.0),
    )


def test_a_rod_of_all_sections_agrees_with_the_reference():
    case = mixed_case()
    q, qd, qdd = random_states(case, seed=1)
    wanted = case.reference.inverse_dynamics(q, qd, qdd)
    assert_allclose(case.lissom.inverse_dynamics(q, qd, qdd), wanted, rtol=0, atol=1e-10 * abs(wanted).max())
    mass = case.reference.mass_matrix(q)
    assert_allclose(case.lissom.mass_matrix(q), mass, rtol=0, atol=1e-10 * mass.max())
    found, energy = case.lissom.energy(q, qd), case.reference.energy(q, qd)
    for name in ("kinetic", "elastic", "gravitational", "loads"):
        assert_allclose(getattr(found, name), getattr(energy, name), rtol=1e-10)


def test_tangents_agree_with_central_differences():
    case = mixed_case()
    state = random_states(case, seed=2)
    for i, tangent in enumerate(case.lissom.tangent(*state)):
        differences = np.empty_like(tangent)
        for k, scale in enumerate(case.coordinate_scale):
            near, far = state.copy(), state.copy()
            near[i, k] += 1e-5 * scale
            far[i, k] -= 1e-5 * scale
            ends = [case.lissom.inverse_dynamics(*moved) for moved in (near, far)]
            differences[:, k] = (ends[0] - ends[1]) / (2e-5 * scale)
        assert_allclose(tangent, differences, rtol=0, atol=1e-7 * abs(tangent).max())


def test_a_given_section_is_the_shape_that_has_its_numbers():
    modes = {"torsion": 1, "bend_y": 2, "bend_z": 2, "shear_y": 1, "stretch": 1}
    shape = lissom.Segment(
        0.7, section=Section.rectangle(0.02, 0.03), modes=modes, shear_correction=(0.8, 0.9), **STEEL
    )
    inertia = shape.inertia()
    given = lissom.Segment(
        0.7, section=Section.given(shape.stiffness(), inertia[3, 3], inertia[:3, :3]), modes=modes
    )
    rods = lissom.Rod([shape]), lissom.Rod([given])
    q = np.linspace(-0.2, 0.3, rods[0].n)
    found, wanted = (rod.inverse_dynamics(q, 2 * q, 3 * q) for rod in rods)
    assert_allclose(found, wanted, rtol=1e-12)


def strip(modes, rotary=True, width=0.02, height=0.005, length=1.0):
    shape = lissom.Segment(length, section=Section.rectangle(width, height), modes=modes, **STEEL)
    if rotary:
        return shape
    return lissom.Segment(
        length, section=Section.given(shape.stiffness(), shape.inertia()[3, 3]), modes=modes
    )


def test_frequencies_in_the_two_planes_are_as_the_roots_of_the_second_moments():
    rod = lissom.Rod([strip({"bend_y": 8, "bend_z": 8}, rotary=False)], gravity=WEIGHTLESS)
    frequency = lissom.modes(rod, np.zeros(rod.n)).frequency
    about_y, about_z = (
        lissom.modes(lissom.Rod([strip({bend: 8}, rotary=False)], gravity=WEIGHTLESS), np.zeros(8)).frequency
        for bend in ("bend_y", "bend_z")
    )
    assert_allclose(about_z / about_y, 0.02 / 0.005, rtol=1e-10)
    assert_allclose(frequency, np.sort(np.concatenate([about_y, about_z])), rtol=1e-10)
    # Euler and Bernoulli: 1.8751^2 sqrt(E I / rho A) / L^2.
    I, A = 0.02 * 0.005**3 / 12, 0.02 * 0.005
    exact = 1.8751040687119611**2 * np.sqrt(2.1e11 * I / (7800.0 * A)) / (2 * np.pi)
    assert_allclose(frequency[0], exact, rtol=1e-8)


def test_bend_and_twist_of_a_coupled_section_are_exact():
    """Under a moment about the axis of the resulting curvature, the strain is uniform."""
    modes = dict.fromkeys(("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"), 1)
    segment = lissom.Segment(0.6, section=Section.given(COUPLED, 0.7), modes=modes)
    compliance = np.linalg.inv(COUPLED)
    size, axes = np.linalg.eigh(compliance[:3, :3])
    for curvature, axis in zip(size, axes.T, strict=True):
        moment = 2.0 / curvature * axis
        assert np.count_nonzero(np.abs(axis) > 0.02) > 1, "bend and twist together"
        rod = lissom.Rod([segment], gravity=WEIGHTLESS, loads=[lissom.Load(moment=moment, frame="body")])
        found = lissom.statics(rod)
        assert found.success
        wanted = compliance @ [*moment, 0, 0, 0]
        assert_allclose(found.q, wanted, rtol=1e-9, atol=1e-9 * abs(wanted).max())
        assert_allclose(wanted[:3], 2.0 * axis)


def test_planar_rods_of_any_section_stay_in_their_plane():
    rod = lissom.Rod([strip({"bend_y": 3})])
    assert rod.kernel == "planar"
    q = np.array([0.3, -0.2, 0.1])
    in_space = lissom.Rod([strip({"bend_y": 3, "bend_z": 1})])
    assert in_space.kernel == "spatial"
    wanted = in_space.inverse_dynamics([*q, 0.0], [*q, 0.0], [*q, 0.0])
    assert_allclose(rod.inverse_dynamics(q, q, q), wanted[:3], rtol=1e-12)
    # A mass beside the plane rotates with it.
    beside = Section.given(COUPLED, 0.7, (2e-4, 1.5e-4, 1e-4), centre=(0.01, 0.02))
    rods = [
        lissom.Rod([lissom.Segment(0.6, section=beside, modes=modes)], gravity=(1.0, 2.0, -9.0))
        for modes in ({"bend_y": 3}, {"bend_y": 3, "bend_z": 1})
    ]
    assert [rod.kernel for rod in rods] == ["planar", "spatial"]
    wanted = rods[1].inverse_dynamics([*q, 0.0], [*q, 0.0], [*q, 0.0])
    assert_allclose(rods[0].inverse_dynamics(q, q, q), wanted[:3], rtol=1e-12)
    energies = rods[0].energy(q, q), rods[1].energy([*q, 0.0], [*q, 0.0])
    assert_allclose(energies[0].gravitational, energies[1].gravitational, rtol=1e-12)
    assert_allclose(energies[0].kinetic, energies[1].kinetic, rtol=1e-12)


@pytest.mark.parametrize("segment", range(3), ids=["rectangle", "ellipse", "given"])
def test_the_energy_balance_of_a_run_closes(segment):
    rod = Case([mixed_segments()[segment] | {"retardation_time": 0.02}], tip_force=(0, 0.1, 0)).lissom
    balance = lissom.simulate(rod, 0.05, dt=0.01, method="radau", rtol=1e-9, atol=1e-11).balance
    assert balance.dissipated[-1] > 1e-3 * balance.scale
    assert balance.drift < 1e-6


def test_what_a_fluid_makes_way_for():
    """Buoyancy and added mass of a closed tube are those of a solid one; a given section has no outline."""
    modes = {"bend_y": 2}
    tube = lissom.Segment(0.5, section=Section.hollow_circle(0.02, 0.015), modes=modes, **STEEL)
    full = lissom.Segment(0.5, 0.02, modes=modes, **STEEL)
    rest = np.zeros(2)
    water = lissom.Fluid(1000.0)
    forces = []
    for segment in (tube, full):
        dry, wet = lissom.Rod([segment]), lissom.Rod([segment], fluid=water)
        forces.append(wet.inverse_dynamics(rest, rest, rest) - dry.inverse_dynamics(rest, rest, rest))
    assert abs(forces[0]).max() > 0
    assert_allclose(forces[0], forces[1], rtol=1e-9)
    given = lissom.Segment(0.5, section=SECTIONS[4], modes=modes)
    with pytest.raises(ValueError, match=r"fluid: got a fluid around segments\[1\], whose section is given"):
        lissom.Rod([full, given], fluid=water)


def test_scenes_take_sections():
    text = """
version = 1
[[rod]]
[[rod.segment]]
length = 0.3
young_modulus = 2e11
shear_modulus = 8e10
density = 7800
shear_correction = "cowper"
modes = { bend_y = 2, torsion = 1 }
[rod.segment.section]
shape = "rectangle"
width = 0.01
height = [0.002, 0.001]
[simulation]
t_end = 1
"""
    scene = lissom.Scene.loads(text)
    (segment,) = scene.model.segments
    assert segment.section == Section.rectangle(0.01, (0.002, 0.001))
    assert segment.shear_correction == "cowper"
    assert "rectangle" in str(scene.model.explain())
