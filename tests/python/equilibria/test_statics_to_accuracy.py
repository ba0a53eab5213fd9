"""`statics(rtol=...)`: modes that an accuracy takes, beside shooting solutions."""

import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import lissom

STEEL = {"young_modulus": 210e9, "shear_modulus": 80e9, "density": 7800}
PLACES = np.linspace(0, 1, 9)

#: Radius at the base, relative to the length, and forces in newtons that bend cones of one metre far, by the
#: part of the radius at the tip.
RADIUS = 0.005
FORCES = {1.0: 234.0, 0.1: 5.0}


def cone(modes, tip=0.1, length=1.0, force=None, **of_rod):
    """A cantilever whose diameter shrinks to a part of it, under a force at the tip."""
    segment = lissom.Segment(length, (RADIUS * length, RADIUS * tip * length), **STEEL, modes=modes)
    force = (0, 0, -FORCES[tip] * length**2) if force is None else force
    return lissom.Rod([segment], gravity=(0, 0, 0), tip_force=force, **of_rod)


def shot(tip, length, force):
    """x and z of an inextensible cone at the places, by shooting: a dead force at the tip bends it."""

    def derivatives(s, state):
        turn, x, z = state[0], *state[2:]
        bending = 210e9 * np.pi / 4 * (RADIUS * length * (1 - (1 - tip) * s / length)) ** 4
        return [state[1] / bending, -force * np.cos(turn), np.cos(turn), -np.sin(turn) + 0 * (x + z)]

    def run(moment):
        span = (0, length)
        return solve_ivp(
            derivatives,
            span,
            [0, moment, 0, 0],
            rtol=1e-10,
            atol=1e-12,
            t_eval=length * PLACES,
            method="LSODA",
        ).y

    moment = brentq(lambda moment: run(moment)[1, -1], 0, 2 * force * length, xtol=1e-12 * force * length)
    return run(moment)[2:].T


def error(model, q, exact, length=1.0):
    """Largest distance of the places from an exact shape in the plane of x and z, relative to the length."""
    found = model.pose(q, length * PLACES)[:, :3, 3]
    return np.hypot(*(found[:, [0, 2]] - exact).T).max() / length


@pytest.mark.parametrize("tip", [1.0, 0.1])
@pytest.mark.parametrize("rtol", [1e-2, 1e-3, 1e-4])
def test_an_accuracy_that_is_reached_is_right(rtol, tip):
    """Shear and stretch, which the reference leaves out, move the tip by less than 2e-5 of the length."""
    exact = shot(tip, 1.0, FORCES[tip])
    found = lissom.statics(cone({"bend_y": 1}, tip), rtol=rtol)
    assert found.success
    assert found.space_error.relative <= rtol
    assert error(found.model, found.q, exact) <= rtol + 2e-5
    # The given number of modes would not do.
    given = lissom.statics(cone({"bend_y": 1}, tip), space_error=False)
    assert error(cone({"bend_y": 1}, tip), given.q, exact) > rtol
    (segment,) = found.model.segments
    assert isinstance(found.model, lissom.Rod)
    assert segment.modes["bend_y"] > 1
    assert f"Modes chosen: bend_y {segment.modes['bend_y']}" in found.message
    again = lissom.statics(found.model)
    assert_allclose(again.q, found.q, rtol=1e-7, atol=1e-9)


def test_other_units_and_directions_give_the_same_modes():
    """Lengths in millimetres beside metres, and everything turned."""
    found = lissom.statics(cone({"bend_y": 1}), rtol=1e-3)
    small = lissom.statics(cone({"bend_y": 1}, length=1e-3), rtol=1e-3)
    assert small.model.segments[0].modes == found.model.segments[0].modes
    assert_allclose(small.space_error.relative, found.space_error.relative, rtol=1e-4)
    half = np.sqrt(0.5)
    turned = cone(
        {"bend_y": 1}, force=(0, FORCES[0.1], 0), base_position=(1, 2, 3), base_orientation=(half, half, 0, 0)
    )
    there = lissom.statics(turned, rtol=1e-3)
    assert there.model.segments[0].modes == found.model.segments[0].modes
    tip, other = (each.model.pose(each.q)[:3, 3] for each in (found, there))
    assert_allclose(other - [1, 2, 3], [tip[0], -tip[2], tip[1]], atol=1e-9)


def test_names_of_links_do_not_matter():
    def robot(first, second):
        wires = [lissom.Segment(0.5, (2e-3, 1e-3), **STEEL, modes={"bend_y": 1}) for _ in range(2)]
        links = [lissom.Link(first, rod=wires[:1]), lissom.Link(second, parent=first, rod=wires[1:])]
        return lissom.Robot(links)

    one, other = (lissom.statics(robot(*names), rtol=1e-4) for names in (("a", "b"), ("z", "a")))
    modes = [[segment.modes for link in each.model.links for segment in link.rod] for each in (one, other)]
    assert modes[0] == modes[1]
    assert_allclose(one.q, other.q, rtol=1e-12)
    assert "in 2 segments" in one.message


def test_inputs_time_and_start_belong_to_the_search():
    """A tendon's tension is an input; the modes are those for its value, and a start is taken over."""
    finger = lissom.Segment(0.2, (4e-3, 1e-3), 1e8, 4e7, 1200, {"bend_y": 2})
    pull = lissom.Tendon("pull", [lissom.Along(offset=(0, 0.005))], tension=lissom.Input("pull", 0.0))
    rod = lissom.Rod([finger], actuators=[pull], gravity=(0, 0, 0))
    idle = lissom.statics(rod, rtol=1e-3)
    pulled = lissom.statics(rod, u={"pull": 1.0}, rtol=1e-3)
    assert sum(pulled.model.segments[0].modes.values()) > sum(idle.model.segments[0].modes.values())
    assert_allclose(pulled.u, [1.0])
    from_there = lissom.statics(rod, [5.0, 0.0], u={"pull": 1.0}, rtol=1e-3)
    assert from_there.success
    tips = [each.model.pose(each.q)[:3, 3] for each in (pulled, from_there)]
    assert_allclose(tips[0], tips[1], atol=2e-3 * 0.2)


def test_a_start_chooses_the_side():
    """A column that has buckled stays on the side from which it is released."""
    column = lissom.Segment(1.0, 0.01, 1e9, 4e8, 1000, {"bend_y": 1})
    load = 2.0 * np.pi**2 / 4 * 1e9 * np.pi / 4 * 0.01**4
    rod = lissom.Rod([column], gravity=(0, 0, 0), tip_force=(-load, 0, 0))
    sides = [lissom.statics(rod, [side], rtol=1e-3) for side in (1.0, -1.0)]
    heights = [each.model.pose(each.q)[2, 3] for each in sides]
    assert all(each.success for each in sides)
    assert_allclose(heights[0], -heights[1], rtol=1e-6)
    assert abs(heights[0]) > 0.3


def test_what_has_no_modes_keeps_them():
    assert lissom.statics(lissom.SpringPendulum(), rtol=1e-3).model is None
    hinge = lissom.Link(
        "arm", joint=lissom.Revolute((0, 1, 0), stiffness=3), body=lissom.Body(1.0, inertia=(1, 1, 1))
    )
    found = lissom.statics(lissom.Robot([hinge]), rtol=1e-3)
    assert found.success
    assert found.model is None


def test_an_accuracy_out_of_reach_is_a_status():
    """A moment in the middle makes the curvature jump, which polynomials do not follow."""
    wire = lissom.Segment(1.0, 1e-3, **STEEL, modes={"bend_y": 2})
    rod = lissom.Rod([wire], gravity=(0, 0, 0), loads=[lissom.Load(moment=(0, 0.3, 0), at=0.5)])
    found = lissom.statics(rod, rtol=1e-8)
    assert (found.success, found.status) == (False, "accuracy_not_reached")
    assert "cut the rod into more segments" in found.message
    assert "Modes chosen" in found.message
    # The best equilibrium is kept; its modes are those that the load excites.
    assert found.space_error.relative < 1e-3
    assert found.stability is None
    halves = [lissom.Segment(0.5, 1e-3, **STEEL, modes={"bend_y": 2})] * 2
    cut = lissom.Rod(halves, gravity=(0, 0, 0), loads=[lissom.Load(moment=(0, 0.3, 0), at=0.5)])
    assert lissom.statics(cut, rtol=1e-8).success


def test_no_equilibrium_is_a_status_too():
    wire = lissom.Segment(1.0, 5e-3, **STEEL, modes={"bend_y": 1})
    falling = lissom.Robot([lissom.Link("rod", joint=lissom.Free(), rod=[wire])])
    found = lissom.statics(falling, rtol=1e-2)
    assert not found.success
    assert found.status == "unheld"
    assert found.model is not None


def test_what_makes_no_sense_is_refused():
    rod = cone({"bend_y": 1})
    with pytest.raises(ValueError, match=r"space_error: .*`lissom.choose_modes`"):
        lissom.statics(rod, rtol=1e-3, space_error=False)
    for rtol in (0.0, -1.0, 1.0, np.nan):
        with pytest.raises(ValueError, match=r"rtol: got .*, expected a number in \[1e-11, 0.1\]"):
            lissom.statics(rod, rtol=rtol)
        with pytest.raises(ValueError, match="rtol: got"):
            lissom.statics(lissom.SpringPendulum(), rtol=rtol)
    pieces = lissom.Rod([lissom.Segment(1.0, 1e-3, **STEEL, modes={"bend_y": 4}, basis="piecewise_constant")])
    with pytest.raises(ValueError, match=r"segments\[0\].basis"):
        lissom.statics(pieces, rtol=1e-3)


def test_a_result_with_its_model_is_pickled():
    found = lissom.statics(cone({"bend_y": 1}), rtol=1e-2)
    copy = pickle.loads(pickle.dumps(found))
    assert copy.model == found.model
    assert copy.message == found.message


@pytest.mark.parametrize("over", [0.9, 1.5])
def test_columns_without_modes_to_buckle_are_not_called_stable(over):
    """A straight column has no curvature: accuracy asks for no modes of bending, above Euler's load too."""
    wire = lissom.Segment(1.0, 1e-2, 1e9, 4e8, 1000.0, modes={"bend_y": 6})
    load = over * np.pi**2 / 4 * 1e9 * np.pi / 4 * 1e-8
    rod = lissom.Rod([wire], gravity=(0, 0, 0), tip_force=(-load, 0, 0))
    assert lissom.statics(rod).stability == ("stable" if over < 1 else "divergence")
    found = lissom.statics(rod, rtol=1e-4)
    assert found.success
    assert found.stability is None
    assert "Stability is not judged" in found.message
