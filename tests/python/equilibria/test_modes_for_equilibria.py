"""Numbers of modes that are chosen for an equilibrium: beside models with many segments, and exact shapes."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

STEEL = {"young_modulus": 210e9, "shear_modulus": 80e9, "density": 7800}


def cone(modes, pieces=1, length=1.0, tip=0.1):
    """A cantilever whose diameter shrinks to a tenth, in pieces of equal length."""
    ends = np.linspace(0, 1, pieces + 1)

    def radius(x):
        return 0.02 * length * (1 - (1 - tip) * x)

    segments = [
        lissom.Segment(length / pieces, (radius(a), radius(b)), **STEEL, modes=modes)
        for a, b in itertools.pairwise(ends)
    ]
    return lissom.Rod(segments, gravity=(0, 0, 0), tip_force=(0, 0, -2000 * length**2))


def places(robot, q, number=9):
    return robot.pose(q, np.linspace(0, robot.length, number))[:, :3, 3]


@pytest.mark.parametrize("length", [1.0, 1e-3])
@pytest.mark.parametrize("rtol", [1e-2, 1e-3])
def test_a_cone_gets_the_modes_that_its_shape_needs(rtol, length):
    chosen = lissom.choose_modes(cone({"bend_y": 1}, length=length), rtol=rtol)
    found = lissom.statics(chosen)
    assert found.success
    fine = cone({"bend_y": 6}, pieces=40, length=length)
    exact = places(fine, lissom.statics(fine).q)
    error = np.linalg.norm(places(chosen, found.q) - exact, axis=1).max()
    assert error < rtol * length
    # A third of the modes is not enough.
    fewer = cone({"bend_y": max(1, chosen.segments[0].modes["bend_y"] // 3)}, length=length)
    poor = lissom.statics(fewer, space_error=False)
    assert np.linalg.norm(places(fewer, poor.q) - exact, axis=1).max() > rtol * length
    assert chosen.kernel == "planar"


def test_a_moment_at_the_tip_needs_one_mode():
    """A circle is exact."""
    wire = lissom.Segment(1.0, 1e-3, **STEEL, modes={"bend_y": 7})
    bending = 210e9 * np.pi * 1e-12 / 4
    rod = lissom.Rod([wire], gravity=(0, 0, 0), tip_moment=(0, -bending * np.pi, 0))
    chosen = lissom.choose_modes(rod, rtol=1e-6)
    assert chosen.segments[0].modes == {"bend_y": 1}
    tip = chosen.pose(lissom.statics(chosen).q)[:3, 3]
    assert_allclose(np.abs(tip), [0, 0, 2 / np.pi], atol=1e-9)


@pytest.mark.parametrize("rtol", [1e-3, 1e-5])
def test_a_beam_between_walls_is_measured_along_its_length(rtol):
    """Its tip is held, so that no mode moves it: deflections are those of a beam with both ends clamped.
    They are small beside its radius: tension has no part in them."""
    force = 4.0
    wire = lissom.Segment(1.0, 5e-3, **STEEL, modes={"bend_y": 2})
    robot = lissom.Robot(
        [lissom.Link("wire", rod=[wire])],
        loops=[
            lissom.Loop(lissom.LoopEnd("wire", 1.0), lissom.LoopEnd(None, position=(1, 0, 0)), lissom.Weld())
        ],
        gravity=(0, 0, -9.81),
        loads=[lissom.Load(link="wire", at=0.5, force=(0, 0, -force))],
    )
    chosen = lissom.choose_modes(robot, rtol=rtol)
    found = lissom.statics(chosen)
    assert found.success
    bending = 210e9 * np.pi * 5e-3**4 / 4
    weight = 7800 * np.pi * 5e-3**2 * 9.81
    deflection = force / (192 * bending) + weight / (384 * bending)
    middle = chosen.pose(found.q, [0.5], link="wire")[0, 2, 3]
    assert_allclose(-middle, deflection, atol=rtol + 2e-6)


def test_what_lies_on_something_is_released():
    wire = lissom.Segment(1.0, 5e-3, young_modulus=1e6, poisson_ratio=0.5, density=1000, modes={})
    peg = lissom.Capsule((0.5, -0.1, -0.05), (0.5, 0.1, -0.05), 0.02)
    rod = lissom.Link("rod", rod=[wire])
    robot = lissom.Robot([rod], contacts=[lissom.Contact("rod", peg)])
    chosen = lissom.choose_modes(robot, rtol=1e-2)
    found = lissom.statics(chosen)
    assert found.success
    fine = lissom.Segment(
        0.1,
        5e-3,
        young_modulus=1e6,
        poisson_ratio=0.5,
        density=1000,
        modes={"bend_y": 3, "stretch": 1, "shear_z": 1},
    )
    exact = lissom.Robot([lissom.Link("rod", rod=[fine] * 10)], contacts=[lissom.Contact("rod", peg)])
    there = lissom.statics(exact)
    assert there.success
    x = np.linspace(0, 1, 9)
    found, there = (
        model.pose(q, x, link="rod")[:, :3, 3] for model, q in ((chosen, found.q), (exact, there.q))
    )
    assert np.linalg.norm(found - there, axis=1).max() < 1e-2


def test_an_interval_belongs_to_a_motion():
    with pytest.raises(ValueError, match=r"dt: only for motions"):
        lissom.choose_modes(cone({"bend_y": 1}), dt=0.1)


def test_no_equilibrium_no_choice():
    """Nothing holds a rod that falls."""
    wire = lissom.Segment(1.0, 5e-3, **STEEL, modes={"bend_y": 1})
    falling = lissom.Robot([lissom.Link("rod", joint=lissom.Free(), rod=[wire])])
    with pytest.raises(lissom.LissomError, match="No modes were chosen, because a trial failed"):
        lissom.choose_modes(falling, rtol=1e-2)


@pytest.mark.parametrize("rtol", [1e-2, 1e-3])
def test_ends_that_are_held_need_what_trials_without_modes_lack(rtol):
    """Clamped at both ends, a wire without any modes is welded to what it hangs between."""
    wire = lissom.Segment(1.0, 2e-3, **STEEL, modes={"bend_y": 3})
    end = lissom.Loop(lissom.LoopEnd("wire", 1.0), lissom.LoopEnd(None, position=(1, 0, 0)), lissom.Weld())
    chosen = lissom.choose_modes(lissom.Robot([lissom.Link("wire", rod=[wire])], loops=[end]), rtol=rtol)
    assert lissom.statics(chosen).success


def test_coils_are_cut_into_segments():
    """What a load changes swings with each turn, which few polynomials do not see."""

    def spring(pieces):
        coil = lissom.Segment(1.0 / pieces, 2e-3, **STEEL, modes={}, reference_strain=(3, 0, 60, 1, 0, 0))
        return lissom.Rod([coil] * pieces, gravity=(0, 0, 0), tip_force=(0, 0, 30))

    with pytest.raises(
        ValueError, match=r"segments\[0\].reference_strain: got 9.6 turns, expected at most 3"
    ):
        lissom.choose_modes(spring(1), rtol=1e-3)
    chosen = lissom.choose_modes(spring(4), rtol=1e-3)
    modes = {"torsion": 6, "bend_y": 6, "bend_z": 6, "stretch": 4, "shear_y": 4, "shear_z": 4}
    coil = lissom.Segment(1.0 / 24, 2e-3, **STEEL, modes=modes, reference_strain=(3, 0, 60, 1, 0, 0))
    fine = lissom.Rod([coil] * 24, gravity=(0, 0, 0), tip_force=(0, 0, 30))
    found, exact = (places(rod, lissom.statics(rod).q, 33) for rod in (chosen, fine))
    assert np.linalg.norm(found - exact, axis=1).max() < 1e-3
