"""Rods whose stretch has no modes say so where axial forces would change their length."""

import numpy as np
import pytest

import lissom

LENGTH, RADIUS, YOUNG = 0.15, 0.006, 250e3
EA = YOUNG * np.pi * RADIUS**2


def rod(modes=None, gravity=(0, 0, 0), **parts):
    modes = {"bend_y": 4, "bend_z": 4} if modes is None else modes
    segment = lissom.Segment(LENGTH, RADIUS, YOUNG, poisson_ratio=0.49, density=1070, modes=modes)
    return lissom.Rod([segment], gravity=gravity, **parts)


def tendons(tension):
    angles = 2.0 * np.pi * np.arange(3) / 3.0
    return [
        lissom.Tendon(
            f"t{i}",
            [lissom.Along(offset=(0.004 * np.cos(angle), 0.004 * np.sin(angle)))],
            tension=lissom.Input(f"t{i}", tension),
        )
        for i, angle in enumerate(angles)
    ]


CASES = {
    "tendons": ({"actuators": tendons(2.0)}, -6.0 / EA),
    "chamber": ({"actuators": [lissom.Chamber("c", [lissom.Along()], area=5e-5, pressure=2e4)]}, 1.0 / EA),
    "tip force": ({"tip_force": (-1.0, 0, 0), "modes": {"torsion": 1}}, -1.0 / EA),
    "weight": (
        {"gravity": (40.0, 0, 0)},
        0.5 * 1070 * 40.0 * LENGTH / YOUNG,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_what_is_left_out_is_the_force_over_the_stiffness(name):
    given, strain = CASES[name]
    found = lissom.statics(rod(**given))
    assert found.success
    assert found.space_error.rigid_stretch == pytest.approx(strain, rel=1e-6)
    word = "shorten" if strain < 0 else "stretch"
    assert "Stretch has no modes in segments[0] and counts as rigid" in found.message
    assert f"E A = {EA:.3g} N" in found.message
    assert f"would {word} it by {100 * abs(strain):.0f} %. Give it `modes` of stretch." in found.message


@pytest.mark.parametrize("name", CASES)
def test_with_modes_of_stretch_nothing_is_left_out(name):
    given, _ = CASES[name]
    given = given | {"modes": given.get("modes", {"bend_y": 4, "bend_z": 4}) | {"stretch": 2}}
    found = lissom.statics(rod(**given))
    assert found.space_error.rigid_stretch == 0.0
    assert "counts as rigid" not in found.message


def test_in_the_plane_too():
    planar = rod({"bend_y": 4}, tip_force=(1.0, 0, 0))
    assert lissom.statics(planar).space_error.rigid_stretch == pytest.approx(1.0 / EA, rel=1e-6)


def test_what_hardly_presses_needs_no_word():
    found = lissom.statics(rod(actuators=tendons(0.05)))
    assert found.space_error.rigid_stretch == pytest.approx(-0.15 / EA, rel=1e-6)
    assert "counts as rigid" not in found.message


def test_the_segment_with_most_is_named():
    def part(young):
        return lissom.Segment(0.1, RADIUS, young, poisson_ratio=0.49, density=1070, modes={"bend_y": 2})

    two = lissom.Rod([part(2e6), part(2e5)], gravity=(0, 0, 0), tip_force=(1.0, 0, 0))
    found = lissom.statics(two)
    assert found.space_error.rigid_stretch == pytest.approx(1.0 / (2e5 * np.pi * RADIUS**2), rel=1e-6)
    assert "no modes in segments[1]" in found.message


def test_the_advice_on_scenes_has_it():
    said = rod(actuators=tendons(2.0)).to_scene().advice()
    assert any("Give it `modes` of stretch" in sentence for sentence in said)
    assert not any("stretch" in sentence for sentence in rod().to_scene().advice())


def test_peaks_show_no_strain_that_is_rounding():
    straight = rod(actuators=tendons(2.0))
    quantities = {peak.quantity for peak in lissom.statics(straight).peaks(straight)}
    assert not quantities & {"axial strain", "axial stress"}
