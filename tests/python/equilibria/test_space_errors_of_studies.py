"""The error due to the modes in results beside those of `statics`."""

import pickle
import warnings

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

RUBBER = {"young_modulus": 1e6, "shear_modulus": 4e5, "density": 1000}
BENDING = 1e6 * np.pi / 4 * 0.01**4


def rod(modes, force=0.0, **of_rod):
    segment = lissom.Segment(0.5, 0.01, **RUBBER, modes={"bend_y": modes})
    return lissom.Rod([segment], **{"gravity": (0, 0, 0), "tip_force": (0, 0, -force)} | of_rod)


def finger(modes):
    """A cone, which a tendon does not bend into a circle."""
    segment = lissom.Segment(0.2, (4e-3, 1e-3), 1e8, 4e7, 1200, {"bend_y": modes})
    pull = lissom.Tendon("pull", [lissom.Along(offset=(0, 0.003))], tension=lissom.Input("pull", 0.0))
    return lissom.Rod([segment], actuators=[pull], gravity=(0, 0, 0))


def apart(coarse, fine, q, other, length):
    """Largest distance of the places of two models, relative to the length."""
    places = np.linspace(0, length, 17)
    found, exact = coarse.pose(q, places), fine.pose(other, places)
    return np.linalg.norm((found - exact)[:, :3, 3], axis=1).max() / length


def quietly(function, *arguments, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lissom.AccuracyWarning)
        return function(*arguments, **options)


@pytest.mark.parametrize("modes", [1, 2, 3])
def test_a_path_of_loads_has_the_error_of_its_end(modes):
    """The error grows with the load; beside the same path of a model with many modes."""
    force = 4 * BENDING / 0.5**2
    coarse, fine = rod(modes, force), rod(10, force)
    found = quietly(lissom.continuation, coarse)
    assert_allclose(found.space_error_at, 1.0)
    exact = lissom.statics(fine)
    error = apart(coarse, fine, found.path.q[-1], exact.q, 0.5)
    assert 0.5 * error < found.space_error.relative < 3 * error
    of_end = quietly(lissom.statics, coarse).space_error
    assert_allclose(found.space_error.relative, of_end.relative, rtol=1e-3)


def test_an_error_before_the_end_is_found():
    """A path that ends where nothing acts: an input goes to and from its largest value beyond one."""
    coarse, fine = finger(2), finger(9)
    found = quietly(lissom.continuation, coarse, inputs={"pull": (3.0, 0.0)})
    assert found.success
    assert found.space_error_at == 0.0
    exact = lissom.statics(fine, u=[3.0])
    error = apart(coarse, fine, found.path.q[0], exact.q, 0.2)
    assert 0.5 * error < found.space_error.relative < 3 * error


@pytest.mark.parametrize("load_factor", [0.3, 0.6])
def test_a_part_of_the_load_is_the_model_with_that_part(load_factor):
    force = 6 * BENDING / 0.5**2
    whole = rod(2, force)
    found = quietly(lissom.continuation, whole, bounds=(0.0, load_factor))
    part = quietly(lissom.statics, rod(2, load_factor * force), space_error=True)
    assert_allclose(found.space_error_at, load_factor)
    assert_allclose(found.path.q[-1], part.q, rtol=1e-7)
    assert_allclose(found.space_error.relative, part.space_error.relative, rtol=0.1)


def test_what_does_not_grow_with_the_loads_is_judged_where_they_all_act():
    """Forces of supports are no part of the loads."""
    force = 8 * BENDING / 0.5**2
    support = lissom.Support(at=0.25, stiffness=(0, 0, 20 * BENDING / 0.5**3))
    model = rod(1, force, supports=[support])
    assert quietly(lissom.continuation, model, bounds=(0.0, 0.5)).space_error is None
    found = quietly(lissom.continuation, model)
    of_end = quietly(lissom.statics, model).space_error
    assert found.space_error_at == 1.0
    assert_allclose(found.space_error.relative, of_end.relative, rtol=1e-3)


def test_a_coarse_path_warns_and_says_where():
    with pytest.warns(lissom.AccuracyWarning, match="finite number of modes"):
        found = lissom.continuation(rod(1, 8 * BENDING / 0.5**2))
    assert "At load factor 1.000000: The finite number of modes leaves an error of about" in found.message
    copy = pickle.loads(pickle.dumps(found))
    assert copy.space_error_at == found.space_error_at
    assert copy.space_error.shape == found.space_error.shape


def test_a_fine_path_says_nothing():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = lissom.continuation(rod(6, 4 * BENDING / 0.5**2))
    assert found.space_error.relative < 1e-4
    assert "finite number" not in found.message


def test_inputs_for_a_target_have_the_error_of_their_equilibrium():
    target = lissom.Target("rod", (0, 0, 0.1), position_weight=(0, 0, 1))
    coarse, fine = finger(1), finger(8)
    with pytest.warns(lissom.AccuracyWarning, match="finite number of modes"):
        found = lissom.actuate(coarse, target, u=[0.5])
    assert found.success
    assert "finite number of modes" in found.message
    exact = lissom.statics(fine, u=found.u)
    error = apart(coarse, fine, found.q, exact.q, 0.2)
    assert 0.5 * error < found.space_error.relative < 3 * error
    assert lissom.actuate(fine, target, u=[0.5]).space_error.relative < 1e-3


def test_vibrations_have_the_error_of_their_shape():
    force = 8 * BENDING / 0.5**2
    coarse = rod(1, force)
    shape = quietly(lissom.statics, coarse)
    # `statics` has warned before.
    found = lissom.modes(coarse, shape.q)
    assert_allclose(found.space_error.relative, shape.space_error.relative, rtol=0.05)
    assert "Of the shape: The finite number of modes" in found.message
    # Modes of a shape that is held there: no equilibrium, no error.
    held = lissom.modes(coarse, 0.5 * shape.q)
    assert held.space_error is None
    fine = rod(8, force)
    assert lissom.modes(fine, lissom.statics(fine).q).space_error.relative < 1e-3


def test_a_fit_of_a_model_that_is_too_coarse_says_so():
    """Its residuals are small where it was measured: at the tip alone."""
    force = 4 * BENDING / 0.5**2
    exact = rod(8, force)
    tip = exact.pose(lissom.statics(exact).q)[:3, 3]
    data = lissom.StaticShapes([tip])
    with pytest.warns(lissom.AccuracyWarning, match="finite number of modes"):
        found = lissom.fit(rod(1, force), data, {"segments[0].young_modulus": 9e5})
    assert found.space_error.relative > 1e-2
    assert "finite number of modes" in found.message
    assert abs(found.values[0] / 1e6 - 1) > 1e-2
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fine = lissom.fit(rod(6, force), data, {"segments[0].young_modulus": 9e5})
    assert_allclose(fine.values, [1e6], rtol=1e-4)
    assert fine.space_error.relative < 1e-3


def test_frequencies_are_fitted_about_a_shape():
    """The modulus follows the shape, which is wrong, rather than the frequency."""
    force = 8 * BENDING / 0.5**2
    exact = rod(8, force)
    there = lissom.modes(exact, lissom.statics(exact).q)
    data = lissom.NaturalFrequencies(there.frequency[:1])
    found = quietly(lissom.fit, rod(2, force), data, {"segments[0].young_modulus": 1.1e6})
    assert found.space_error.relative > 1e-2
    assert abs(found.values[0] / 1e6 - 1) > 0.1
