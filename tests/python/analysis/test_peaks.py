"""Peaks of results: closed forms, the places and times where they are, and what has none."""

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

import lissom
from lissom import cli
from lissom.analysis.limits import sentences
from lissom.analysis.peaks import largest_of

STEEL = {"young_modulus": 210e9, "shear_modulus": 80e9, "density": 7800.0}
GRAVITY = 9.81


def of(peaks, quantity, part=None):
    found = [peak for peak in peaks if peak.quantity == quantity and part in (None, peak.part)]
    assert len(found) == 1, (quantity, [str(peak) for peak in peaks])
    return found[0]


@given(st.floats(1e-3, 1e3), st.floats(0.002, 0.01))
@settings(max_examples=20, deadline=None)
def test_a_cantilever_under_its_weight_bends_most_at_the_clamp(metre, slenderness):
    """Euler and Bernoulli: M = w L^2 / 2, stress M r / I, in any unit of length."""
    length, radius = metre, slenderness * metre
    modulus = 1e9 * STEEL["density"] * GRAVITY * metre  # hardly bends
    segment = lissom.Segment(length, radius, modulus, modulus / 2.6, 7800.0, modes={"bend_y": 4})
    rod = lissom.Rod([segment])
    found = lissom.statics(rod)
    weight = STEEL["density"] * np.pi * radius**2 * GRAVITY
    peaks = found.peaks(rod)
    moment = of(peaks, "bending moment")
    assert moment.value == pytest.approx(weight * length**2 / 2.0, rel=1e-3)
    assert (moment.X, moment.index, moment.part) == (0.0, 0, "rod")
    stress = of(peaks, "axial stress")
    assert stress.X == 0.0
    assert stress.value == pytest.approx(moment.value * radius / (np.pi * radius**4 / 4.0), rel=2e-3)
    assert of(peaks, "axial strain").value == pytest.approx(stress.value / modulus)
    assert of(peaks, "curvature").value == pytest.approx(stress.value / modulus / radius)


def test_a_hanging_rod_is_pulled_by_its_weight_at_the_clamp():
    down = (np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0)
    segment = lissom.Segment(2.0, 1e-3, **STEEL, modes={"bend_y": 2, "stretch": 3})
    rod = lissom.Rod([segment], base_orientation=down)
    peaks = lissom.statics(rod).peaks(rod)
    weight = STEEL["density"] * np.pi * 1e-6 * 2.0 * GRAVITY
    assert of(peaks, "tension").value == pytest.approx(weight, rel=1e-6)
    assert of(peaks, "tension").X == 0.0
    assert of(peaks, "stretch").value == pytest.approx(weight / (np.pi * 1e-6 * 210e9), rel=1e-6)


def test_what_jumps_between_segments_is_seen_on_its_larger_side():
    thick = lissom.Segment(0.5, 4e-3, **STEEL, modes={"bend_y": 1})
    thin = lissom.Segment(0.5, 2e-3, **STEEL, modes={"bend_y": 3})
    rod = lissom.Rod([thick, thin])
    found = lissom.statics(rod, space_error=False)
    peaks = found.peaks(rod)
    curvature = of(peaks, "curvature")
    sides = np.abs(rod.strain(found.q, [0.5, np.nextafter(0.5, 1.0)])[:, 1])
    assert sides[1] > 2.0 * sides[0]
    assert curvature.value == pytest.approx(sides[1], rel=0.02)
    stiffness = STEEL["young_modulus"] * np.pi * 2e-3**4 / 4.0
    rest = np.zeros(rod.n)
    moment = np.abs(rod.internal_wrench(found.q, rest, rest, [0.5])[0, 1])
    assert curvature.value == pytest.approx(moment / stiffness)
    assert pytest.approx(0.5) == curvature.X


def test_curvature_of_few_modes_is_that_of_the_balance():
    """A force at the tip of a wire with one mode: F L / E I at the clamp, not its mean; the radius counts."""
    length, radius, force = 0.5, 1e-3, 0.02
    stiffness = STEEL["young_modulus"] * np.pi * radius**4 / 4.0
    exact = force * length / stiffness
    options = {"modes": {"bend_y": 1}, "min_bend_radius": 0.99 / exact}
    segment = lissom.Segment(length, radius, **STEEL, **options)
    rod = lissom.Rod([segment], gravity=(0.0, 0.0, 0.0), tip_force=(0.0, 0.0, force))
    peaks = lissom.statics(rod, space_error=False).peaks(rod)
    assert of(peaks, "curvature").value == pytest.approx(exact, rel=1e-3)
    assert of(peaks, "curvature").X == 0.0
    assert of(peaks, "curvature").share == pytest.approx(0.99, rel=1e-3)
    assert of(peaks, "curvature of the modes").value == pytest.approx(exact / 2.0, rel=1e-3)
    assert of(peaks, "axial stress").value == pytest.approx(exact * radius * STEEL["young_modulus"], rel=1e-3)


def test_curvature_over_an_edge_does_not_depend_on_the_modes():
    """A cable over the edge of a box: few and many modes give the same smallest radius."""

    def curvature(count, modes):
        part = lissom.Segment(1.0 / count, 4e-3, 2.5e8, 1e8, 2400.0, {"bend_y": modes})
        box = lissom.Box((0.2, 0.0, -0.05), (0.1, 0.1, 0.05))
        link = lissom.Link("cable", rod=[part] * count, position=(0.0, 0.0, 0.05))
        robot = lissom.Robot([link], contacts=[lissom.Contact("cable", box)])
        return of(lissom.statics(robot, space_error=False).peaks(robot), "curvature").value

    assert curvature(4, 4) == pytest.approx(curvature(16, 4), rel=5e-3)


def test_peaks_of_a_motion_are_the_largest_of_its_states():
    segment = lissom.Segment(
        0.4, (8e-3, 5e-3), 1e6, 4e5, 1100.0, modes={"bend_y": 3, "bend_z": 2, "torsion": 2}
    )
    tendon = lissom.Tendon("pull", [lissom.Along(offset=(0.004, 0.002))], tension=lissom.Input("pull", 2.0))
    robot = lissom.Robot([lissom.Link("finger", rod=[segment])], actuators=[tendon])
    run = lissom.simulate(robot, 0.3, dt=2e-3)
    peaks = run.peaks()
    X = np.linspace(0.0, 0.4, 49)
    strain = robot.strain(run.q, X)
    sizes = np.hypot(strain[..., 1], strain[..., 2])
    curvature = of(peaks, "curvature", "finger")
    assert curvature.value == pytest.approx(sizes.max(), rel=1e-12)
    at = np.unravel_index(sizes.argmax(), sizes.shape)
    assert curvature.index == at[0]
    assert curvature.t == run.t[at[0]]
    assert pytest.approx(X[at[1]]) == curvature.X
    wrench = robot.internal_wrench(run.q, run.v, run.a, X, t=run.t, u=run.u)
    moment = of(peaks, "bending moment")
    assert moment.value == pytest.approx(np.hypot(wrench[..., 1], wrench[..., 2]).max(), rel=1e-12)
    torque = of(peaks, "torque", "finger")
    assert abs(torque.value) == pytest.approx(np.abs(wrench[..., 0]).max(), rel=1e-12)
    assert of(peaks, "tension", "pull").value == pytest.approx(2.0)
    assert of(peaks, "tension", "pull").index == 0
    # Strains without modes are no quantity of this robot.
    assert not [peak for peak in peaks if peak.quantity in ("stretch", "shear")]


def test_the_outermost_fibre_of_a_rectangle_is_at_a_corner():
    section = lissom.Section.rectangle(0.02, 0.01)
    segment = lissom.Segment(
        0.3,
        section=section,
        young_modulus=1e9,
        shear_modulus=4e8,
        density=1000.0,
        modes={"bend_y": 1, "bend_z": 1},
    )
    load = lissom.Load(force=(0.0, 0.5, 0.7))
    rod = lissom.Rod([segment], loads=[load], gravity=(0.0, 0.0, 0.0))
    found = lissom.statics(rod, space_error=False)
    half_y, half_z = section.half_extents(0.0)
    rest = np.zeros(rod.n)
    _, about_y, about_z, tension, _, _ = np.abs(rod.internal_wrench(found.q, rest, rest, [0.0])[0])
    area, of_y, of_z = 0.02 * 0.01, 0.02 * 0.01**3 / 12.0, 0.01 * 0.02**3 / 12.0
    expected = (about_y / of_y * half_z + about_z / of_z * half_y + tension / area) / 1e9
    assert of(found.peaks(rod), "axial strain").value == pytest.approx(expected)


def test_a_ball_at_rest_presses_with_its_weight():
    ball = lissom.Link("ball", body=lissom.Body(0.2), joint=lissom.Prismatic((0, 0, 1)))
    floor = lissom.Contact(
        lissom.Ball("ball", 0.05), lissom.HalfSpace((0, 0, 0), (0, 0, 1)), stiffness=1e4, name="floor"
    )
    robot = lissom.Robot([ball], contacts=[floor])
    peaks = lissom.statics(robot, q0=[0.05]).peaks(robot)
    force, overlap = of(peaks, "contact force"), of(peaks, "overlap")
    assert force.value == pytest.approx(0.2 * GRAVITY, rel=1e-6)
    assert overlap.value == pytest.approx(0.2 * GRAVITY / 1e4, rel=1e-2)
    assert (force.part, force.X, overlap.unit) == ("floor", None, "m")


def test_tensions_within_closed_loops_hold_what_loops_hold():
    """Two wires with their tips held together carry a plate: the balance includes the loop's force."""
    scene = lissom.Scene.load("scenes/hoop.toml")
    run = lissom.simulate(scene.model, 0.02, q0=scene.q0, dt=1e-3)
    robot, X = scene.model, np.linspace(0.0, 2.0, 5)
    together = robot.internal_wrench(run.q, run.v, run.a, X, t=run.t, u=run.u)
    apart = [robot.internal_wrench(run.q, run.v, run.a, [x], t=run.t, u=run.u)[:, 0] for x in X]
    np.testing.assert_array_equal(together, np.stack(apart, axis=1))
    assert of(run.peaks(), "bending moment").value > 0.0


def test_peaks_in_words():
    peak = lissom.Peak("tension", "N", "cable", 12.5, None, 0.25, 3)
    assert str(peak) == "tension of cable: 12.5 N, t = 0.25 s"
    peak = lissom.Peak("axial strain", "1", "rod", 0.02, 0.1, 0.25, 3)
    assert str(peak) == "axial strain of rod: 0.02 at X = 0.1 m, t = 0.25 s"


def test_results_without_a_model_have_no_peaks():
    run = lissom.newmark(lambda t, q, v, a: a + q, (0.0, 1.0), [1.0], [0.0], dt=0.1)
    with pytest.raises(ValueError, match="does not contain its model"):
        run.peaks()
    rod = lissom.Rod([lissom.Segment(1.0, 1e-3, **STEEL, modes={"bend_y": 3})])
    found = lissom.statics(rod)
    other = lissom.Rod([lissom.Segment(1.0, 1e-3, **STEEL, modes={"bend_y": 5})])
    with pytest.raises(ValueError, match="5 coordinates, the result has 3"):
        found.peaks(other)
    with pytest.raises(TypeError, match="model: expected a Model"):
        found.peaks("rod")


def test_active_strains_are_free_of_stress():
    segment = lissom.Segment(1.0, 0.01, 2e9, 8e8, 1000.0, modes={"bend_y": 3})
    bent = lissom.ActiveStrain("finger", "bend_y", 1.0, amount=2.0)
    robot = lissom.Robot([lissom.Link("finger", rod=[segment])], actuators=[bent], gravity=(0, 0, 0))
    peaks = lissom.statics(robot).peaks(robot)
    assert of(peaks, "axial strain").value == pytest.approx(0.02)
    assert of(peaks, "axial stress").value < 1e-10 * 2e9 * 0.02
    assert of(peaks, "curvature").X == 0.0


def test_torque_and_tension_have_the_signs_of_torsion_and_stretch():
    segment = lissom.Segment(1.0, 0.01, 2e9, 8e8, 1000.0, modes={"torsion": 2, "stretch": 1})
    for sign in (1.0, -1.0):
        rod = lissom.Rod([segment], gravity=(0, 0, 0), tip_moment=(sign * 0.02, 0, 0), tip_force=(sign, 0, 0))
        peaks = lissom.statics(rod).peaks(rod)
        assert of(peaks, "torque").value == pytest.approx(sign * 0.02)
        assert of(peaks, "torque").X == 0.0
        assert of(peaks, "torsion").value == pytest.approx(sign * 0.02 / (8e8 * np.pi * 1e-8 / 2.0))
        assert of(peaks, "tension").value == pytest.approx(sign)
        assert of(peaks, "stretch").value == pytest.approx(sign / (2e9 * np.pi * 1e-4))


def test_moments_between_two_loads_are_seen_however_near_they_are():
    segment = lissom.Segment(1.0, 0.01, 2e9, 8e8, 1000.0, modes={"bend_y": 4})
    pair = [lissom.Load(moment=(0, 0.1, 0), at=0.5), lissom.Load(moment=(0, -0.1, 0), at=0.501)]
    rod = lissom.Rod([segment], gravity=(0, 0, 0), loads=pair)
    moment = of(lissom.statics(rod, space_error=False).peaks(rod), "bending moment")
    assert moment.value == pytest.approx(0.1)
    assert 0.5 <= moment.X <= 0.501


@pytest.mark.parametrize("nodes", [16, 48])
def test_the_force_of_a_contact_is_its_resultant(nodes):
    segment = lissom.Segment(0.5, 0.01, 1e7, 4e6, 1000.0, modes={"bend_y": 2}, nodes=nodes)
    rod = lissom.Link("rod", rod=[segment], joint=lissom.Prismatic((0, 0, 1)))
    floor = lissom.Contact("rod", lissom.HalfSpace(), name="floor")
    robot = lissom.Robot([rod], contacts=[floor])
    peaks = lissom.statics(robot, q0=[0.0105, 0.0, 0.0], space_error=False).peaks(robot)
    weight = 1000.0 * np.pi * 1e-4 * 0.5 * GRAVITY
    assert of(peaks, "contact force").value == pytest.approx(weight, rel=1e-6)


def cantilever(**limits):
    """Two equal segments, of which the first has limits."""
    of = {"length": 0.5, "radius": 2e-3, **STEEL, "modes": {"bend_y": 3}}
    return lissom.Rod([lissom.Segment(**of, **limits), lissom.Segment(**of)])


def test_a_peak_has_the_limit_of_its_segment():
    plain = lissom.statics(cantilever()).peaks(cantilever())
    size = {name: of(plain, name).value for name in ("curvature", "axial strain", "axial stress")}
    assert all(peak.limit is None and peak.share is None for peak in plain)
    limits = {
        "min_bend_radius": 0.8 / size["curvature"],
        "max_strain": 2.0 * size["axial strain"],
        "max_stress": 0.5 * size["axial stress"],
    }
    rod = cantilever(**limits)
    peaks = lissom.statics(rod).peaks(rod)
    shares = {name: of(peaks, name).share for name in size}
    assert shares == pytest.approx({"curvature": 0.8, "axial strain": 0.5, "axial stress": 2.0})
    assert of(peaks, "bending moment").limit is None
    beyond = sentences(peaks)
    assert len(beyond) == 1
    assert "axial stress of rod" in beyond[0]
    assert f"{limits['max_stress']:.4g} Pa is allowed" in beyond[0]


def test_a_weak_segment_has_its_peak_beside_the_largest_one():
    """The tip bears a tenth of what the clamp bears, and is bent to a quarter of its curvature."""
    segments = [
        lissom.Segment(0.5, 2e-3, **STEEL, modes={"bend_y": 3}, **limits)
        for limits in ({}, {"min_bend_radius": 100.0})
    ]
    rod = lissom.Rod(segments)
    found = lissom.statics(rod)
    largest, limited = [peak for peak in found.peaks(rod) if peak.quantity == "curvature"]
    assert (largest.X, largest.limit) == (0.0, None)
    assert limited.limit == pytest.approx(0.01)
    assert pytest.approx(0.5) == limited.X
    assert limited.value == pytest.approx(abs(rod.strain(found.q, limited.X)[1]), rel=1e-3)
    assert set(largest_of([largest, limited])) == {largest, limited}


def test_limits_change_no_motion_and_survive_files(tmp_path):
    plain, limited = cantilever(), cantilever(min_bend_radius=0.1, max_strain=0.01, max_stress=1e8)
    runs = [lissom.simulate(rod, 0.05, dt=1e-3) for rod in (plain, limited)]
    assert np.array_equal(runs[0].q, runs[1].q)
    path = tmp_path / "limited.toml"
    limited.to_scene().save(path)
    again = lissom.Scene.load(path).model
    assert again.segments == limited.segments
    assert again.segments != plain.segments


@pytest.mark.parametrize("limit", ["max_strain", "max_stress"])
def test_given_sections_have_no_outermost_fibre_to_limit(limit):
    section = lissom.Section.given((1.0,) * 6, 1.0)
    with pytest.raises(ValueError, match=f"{limit}.*outermost fibre"):
        lissom.Segment(1.0, section=section, modes={"bend_y": 2}, **{limit: 1.0})
    assert (
        lissom.Segment(1.0, section=section, modes={"bend_y": 2}, min_bend_radius=1.0).min_bend_radius == 1.0
    )


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
@pytest.mark.parametrize("limit", ["min_bend_radius", "max_strain", "max_stress"])
def test_limits_are_positive(limit, value):
    with pytest.raises(ValueError, match=limit):
        cantilever(**{limit: value})


def test_the_report_and_the_command_line_name_what_is_exceeded(tmp_path):
    rod = cantilever(min_bend_radius=1e3)
    scene = tmp_path / "limited.toml"
    rod.to_scene().save(scene)
    result = CliRunner().invoke(
        cli.commands, ["statics", str(scene), "-o", str(tmp_path / "out")], standalone_mode=False
    )
    assert "Beyond `min_bend_radius`, " in result.output
    report = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "1.42e+03 times" in report or "times what is allowed: curvature of" in report
    assert ">limit<" in report


@pytest.mark.parametrize("modes", [{"bend_y": 2}, {"bend_y": 2, "stretch": 1}, {"stretch": 1}])
def test_forces_count_in_stress_where_strains_have_no_modes(modes):
    """A wire of 0.4 mm radius under 500 N: N / A, and the moment of a force across over E I."""
    segment = lissom.Segment(1.0, 4e-4, **STEEL, modes=modes, max_stress=1e8)
    force = (500.0, 0.0, 0.0) if "bend_y" in modes else (0.0, 0.0, 1e-3)
    rod = lissom.Rod([segment], loads=[lissom.Load(force=force)], gravity=(0, 0, 0))
    peaks = lissom.statics(rod, space_error=False).peaks(rod)
    area, size = np.pi * 4e-4**2, 0.25 * np.pi * 4e-4**4
    right = 500.0 / area if "bend_y" in modes else 1e-3 * 1.0 * 4e-4 / size
    assert of(peaks, "axial stress").value == pytest.approx(right, rel=1e-6)
    assert of(peaks, "axial stress").share == pytest.approx(right / 1e8, rel=1e-6)
    assert of(peaks, "axial strain").value == pytest.approx(right / STEEL["young_modulus"], rel=1e-6)


def test_tendons_along_a_rod_are_no_force_in_its_fibres():
    """The balance of forces in a section holds the tension of the tendon, too: the sum is zero here."""
    segment = lissom.Segment(0.2, 4e-3, 1e6, poisson_ratio=0.4, density=1000.0, modes={"bend_y": 2})
    pull = lissom.Tendon("pull", [lissom.Along("finger", (0.0, 3e-3))], tension=1.0)
    robot = lissom.Robot([lissom.Link("finger", rod=[segment])], actuators=[pull], gravity=(0, 0, 0))
    found = lissom.statics(robot, space_error=False)
    stress = of(found.peaks(robot), "axial stress").value
    assert stress == pytest.approx(1.0 * 3e-3 * 4e-3 / (0.25 * np.pi * 4e-3**4), rel=1e-6)
