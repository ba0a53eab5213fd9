"""Fits of several recordings and of several kinds, and from several starts."""

import copy
import dataclasses
import pickle
import re

import numpy as np
import pytest
from scipy.optimize import least_squares

import lissom
from lissom.analysis import searches

YOUNG, DENSITY, DAMPING = (f"segments[*].{name}" for name in ("young_modulus", "density", "retardation_time"))
RIGHT = {YOUNG: 3e5, DENSITY: 1100.0, DAMPING: 0.02}
BOUNDS = {YOUNG: (1e5, 4e5, 1e6), DENSITY: (500.0, 900.0, 2000.0), DAMPING: (1e-3, 0.01, 0.1)}


def arm(young=3e5, density=1100.0, damping=0.02, tension=None):
    """A rod of two segments with a tendon."""
    segment = lissom.Segment(
        0.1, 0.008, young, poisson_ratio=0.45, density=density, modes={"bend_y": 2}, retardation_time=damping
    )
    tension = lissom.Input("pull", 0.0) if tension is None else tension
    pull = lissom.Tendon("pull", [lissom.Along(offset=(0.0, 0.005))], tension=tension)
    return lissom.Rod([segment] * 2, actuators=[pull])


def tips(q, noise=0.0, seed=0):
    positions = np.array([arm().pose(each)[:3, 3] for each in q])
    return positions + noise * np.random.default_rng(seed).standard_normal(positions.shape)


PULLS = np.abs(np.sin(0.9 * np.arange(10.0)))[:, None]


def shapes(spread=0.0, inputs=((0.0,), (1.0,), (2.0,)), seed=0, **given):
    found = [lissom.statics(arm(), u=u).q for u in inputs]
    return lissom.StaticShapes(tips(found, spread, seed), u=inputs, **given)


def frequencies(factor=1.0, **given):
    found = lissom.equilibrium_sensitivity(arm(), ["gravity[2]"], frequencies=2).frequencies
    return lissom.NaturalFrequencies(found * factor, **given)


def motion(u, spread=0.0, q0=None, seed=1, **given):
    rows = iter(np.asarray(u))
    run = lissom.simulate(arm(), 0.05 * len(u), q0=q0, control=lambda t, q, v: next(rows), control_step=0.05)
    return lissom.RecordedMotion(run.t[1:], tips(run.q[1:], spread, seed), u, 0.05, q0=q0, **given)


def test_shapes_motions_and_frequencies_at_once():
    data = [shapes(noise=1e-3), frequencies(noise=0.1), motion(PULLS, noise=1e-3)]
    found = lissom.fit(arm(4e5), data, BOUNDS, rtol=1e-9, tol=1e-12)
    np.testing.assert_allclose(found.values, list(RIGHT.values()), rtol=1e-5)
    assert [each.kind for each in found.data] == ["shapes", "frequencies", "motion"]
    assert [each.unit for each in found.data] == ["m", "Hz", "m"]
    assert [each.noise for each in found.data] == [1e-3, 0.1, 1e-3]
    assert [each.residuals.shape for each in found.data] == [(3, 1, 3), (2,), (50, 1, 3)]
    np.testing.assert_array_equal(found.data[2].measured[:, 0], data[2].positions)
    assert found.undetermined == ()
    with pytest.raises(
        AttributeError, match=r"residuals: this fit has 3 recordings.*data\[0\]\.residuals to data"
    ):
        _ = found.residuals


def test_kinds_that_are_measured_together_determine_what_each_alone_does_not():
    """Frequencies tell little more than the ratio of modulus and density, tendons the modulus."""
    data = [shapes(noise=1e-4), frequencies(noise=1e-2)]
    both = lissom.fit(arm(), data, {name: BOUNDS[name] for name in (YOUNG, DENSITY)})
    np.testing.assert_allclose(both.values, [3e5, 1100.0], rtol=1e-6)
    alone = lissom.fit(arm(), frequencies(noise=1e-2), {name: BOUNDS[name] for name in (YOUNG, DENSITY)})
    assert (np.diag(both.covariance) < np.diag(alone.covariance)).all()


def test_the_noise_of_each_weights_it():
    """Against a least-squares search of its own, by differences."""
    data = [shapes(2e-3, noise=2e-3), frequencies(1.02, noise=0.05)]
    found = lissom.fit(arm(), data, {YOUNG: (1e5, 4e5, 1e6), DENSITY: (500, 900, 2000)}, tol=1e-12)

    def residuals(p):
        model = arm(p[0] * 3e5, p[1] * 1100.0)
        predicted = [model.pose(lissom.statics(model, u=u, tol=1e-12).q)[:3, 3] for u in data[0].u]
        rest = lissom.statics(model, tol=1e-12).q
        squares = lissom.modes(arm(p[0] * 3e5, p[1] * 1100.0, 0.0), rest).frequency[:2]
        return np.concatenate(
            [(predicted - data[0].positions).ravel() / 2e-3, (squares - data[1].values) / 0.05]
        )

    right = least_squares(residuals, [1.0, 1.0], diff_step=1e-5, xtol=1e-12, ftol=1e-12)
    spread = np.sqrt(np.diag(np.linalg.inv(right.jac.T @ right.jac)))
    np.testing.assert_allclose(np.sqrt(np.diag(found.covariance)) / [3e5, 1100.0], spread, rtol=1e-3)
    assert (np.abs(found.values / [3e5, 1100.0] - right.x) < 2 * searches.OFFSET * spread).all()


def test_recordings_of_one_unit_share_an_estimated_noise():
    q0 = [0.5, 0.0, 0.2, 0.0]
    data = [motion(PULLS, 1e-3), motion(PULLS[::-1], 1e-3, q0, seed=2), shapes(1e-3, seed=3)]
    found = lissom.fit(arm(), data, {name: BOUNDS[name] for name in (YOUNG, DAMPING)})
    low, high = found.intervals.T
    assert (low < [3e5, 0.02]).all()
    assert (high > [3e5, 0.02]).all()
    (noise,) = {each.noise for each in found.data}
    assert noise == pytest.approx(1e-3, rel=0.15)
    # Twice the data, the interval of the modulus narrower by about its root.
    one = lissom.fit(arm(), data[0], {name: BOUNDS[name] for name in (YOUNG, DAMPING)})
    assert np.ptp(found.intervals[1]) < 0.85 * np.ptp(one.intervals[1])
    # A list of one recording is that recording.
    again = lissom.fit(arm(), data[:1], {name: BOUNDS[name] for name in (YOUNG, DAMPING)})
    np.testing.assert_array_equal(again.values, one.values)


def test_starts_belong_to_the_motion_beside_equilibria():
    recorded = motion(PULLS, q0=[0.5, 0.0, 0.0, 0.0], noise=1e-3)
    recorded = lissom.RecordedMotion(recorded.t, recorded.positions, PULLS, 0.05, noise=1e-3)
    data = [shapes(noise=1e-3), recorded, frequencies(noise=0.1)]
    found = lissom.fit(arm(), data, {YOUNG: (1e5, 4e5, 1e6), "q0[0]": 0.2}, rtol=1e-9, tol=1e-12)
    np.testing.assert_allclose(found.values, [3e5, 0.5], rtol=1e-5)


REFUSED = {
    "data[1].noise: expected the standard deviation of its numbers in hertz, such as noise=0.1: weights "
    "compare metres with hertz": lambda: lissom.fit(arm(), [shapes(noise=1e-3), frequencies()], {YOUNG: 3e5}),
    "data[0].noise: expected the standard deviation of its numbers in metres, such as noise=1e-3: the other "
    "data have one": lambda: lissom.fit(arm(), [shapes(), shapes(noise=1e-3)], {YOUNG: 3e5}),
    "noise: data in metres and in hertz need a noise each": lambda: lissom.fit(
        arm(), [shapes(), frequencies()], {YOUNG: 3e5}, noise=1e-3
    ),
    "u: each RecordedMotion has its own `u`": lambda: lissom.fit(
        arm(), [motion(PULLS), motion(PULLS)], {YOUNG: 3e5}, u=PULLS
    ),
    "there are 2 motions, each with its own start": lambda: lissom.fit(
        arm(), [motion(PULLS), motion(PULLS)], {"q0[0]": 0.1}
    ),
    "data[1]: positions have shape (3, 3), expected (3, 2, 3)": lambda: lissom.fit(
        arm(), [shapes(places=[0.2]), shapes()], {YOUNG: 3e5}, places=[0.1, 0.2]
    ),
    "data[1].q0: got shape (2,), expected (4,)": lambda: lissom.fit(
        arm(), [motion(PULLS), lissom.RecordedMotion([0.1], [[0, 0, 0]], q0=[0, 0])], {YOUNG: 3e5}
    ),
    "fit() got an unexpected keyword argument 'tolerance'": lambda: lissom.fit(
        arm(), [shapes(noise=1e-3), motion(PULLS, noise=1e-3)], {YOUNG: 3e5}, tolerance=1e-3
    ),
    "t: got times that do not increase": lambda: lissom.RecordedMotion([0.2, 0.1], np.zeros((2, 3))),
    "positions: got shape (1, 3), expected (2, 3) or (2, places, 3)": lambda: lissom.RecordedMotion(
        [0.1, 0.2], np.zeros((1, 3))
    ),
    "noise: got 0.0, expected a number > 0 in metres": lambda: lissom.RecordedMotion(
        [0.1], np.zeros((1, 3)), noise=0.0
    ),
    "noise: got -1, expected a number > 0 in hertz": lambda: lissom.NaturalFrequencies([1.0], noise=-1),
    "starts: got 0, expected a whole number > 0": lambda: lissom.fit(
        arm(), shapes(), {YOUNG: (1e5, 3e5, 1e6)}, starts=0
    ),
    "starts: got 4, expected bounds within which to start: give 'segments[*].density' as "
    "(lowest, guess, highest)": lambda: lissom.fit(
        arm(), shapes(), {YOUNG: (1e5, 3e5, 1e6), DENSITY: 900.0}, starts=4
    ),
}


@pytest.mark.parametrize("message", REFUSED)
def test_what_cannot_be_weighted_is_refused(message):
    with pytest.raises((ValueError, TypeError)) as caught:
        REFUSED[message]()
    assert message in str(caught.value)


@pytest.mark.parametrize("way", [copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_results_of_older_versions_had_one_recording(way):
    found = lissom.fit(arm(), shapes(), {YOUNG: (1e5, 4e5, 1e6)})
    state = dict(vars(found))
    (own,) = state.pop("data")
    state |= {name: getattr(own, name) for name in ("t", "places", "measured", "residuals", "noise")}
    older = object.__new__(lissom.FitResult)
    older.__setstate__(state)
    older = way(older)
    assert older.data[0].kind == "shapes"
    np.testing.assert_array_equal(older.residuals, found.residuals)
    assert "noise" not in vars(older)


# Where searches end.


def driven(young=3e5, damping=0.02):
    """A robot whose tendon is pulled by a sine."""
    return arm(young, 1100.0, damping, lissom.Harmonic(0.8, 2.0, mean=1.0))


def of_sine(noise=1e-3):
    run = lissom.simulate(driven(), 2.0, dt=5e-3)
    return run.t[2::2], tips(run.q[2::2], noise)


FAR = {YOUNG: (2e4, 5e4, 1e7), DAMPING: (1e-4, 3e-4, 0.5)}


def test_several_starts_leave_a_local_minimum():
    """At resonance a soft rod with little damping fits a part of the motion."""
    data = of_sine()
    with pytest.warns(lissom.AccuracyWarning, match="slightly too slow, even with .* steps per period"):
        caught = lissom.fit(driven(), data, FAR, dt=5e-3)
    assert "slightly too slow, even with" in caught.message
    assert caught.data[0].misfit > 5e-3
    assert "are not noise: neighbours have a correlation of" in caught.message
    assert "`starts=10`" in caught.message
    found = lissom.fit(driven(), data, FAR, dt=5e-3, starts=6)
    np.testing.assert_allclose(found.values, [3e5, 0.02], rtol=0.05)
    assert found.data[0].misfit < 1.1e-3
    assert "The best of 6 searches from different points; " in found.message
    assert "are not noise" not in found.message
    again = lissom.fit(driven(), data, FAR, dt=5e-3, starts=6)
    np.testing.assert_array_equal(again.values, found.values)


def test_residuals_larger_than_their_noise_are_told():
    data = shapes(1e-3)
    good = lissom.fit(arm(), data, {YOUNG: (1e5, 4e5, 1e6)}, noise=1e-3)
    assert "times as large as the noise" not in good.message
    bad = lissom.fit(arm(), data, {YOUNG: (1e5, 4e5, 1e6)}, noise=1e-4)
    assert "times as large as the noise: the model leaves out something" in bad.message


def test_searches_end_near_the_best_values_relative_to_their_uncertainty(monkeypatch):
    data = of_sine()
    guess = {YOUNG: (1e5, 2e5, 1e6), DAMPING: (1e-3, 0.01, 0.5)}
    found = lissom.fit(driven(), data, guess, dt=5e-3)
    assert found.message.startswith("Converged: the values are within 0.001 of their uncertainty")
    monkeypatch.setattr(searches, "OFFSET", 0.0)
    right = lissom.fit(driven(), data, guess, dt=5e-3)
    assert right.runs > found.runs
    spread = np.sqrt(np.diag(right.covariance))
    assert (np.abs(found.values - right.values) < 2e-3 * spread).all()


def test_steps_that_are_chosen_do_not_hinder_convergence(monkeypatch):
    """Their errors change from run to run: the sum of squares is not smooth."""
    data = of_sine()
    guess = {YOUNG: (1e5, 2e5, 1e6), DAMPING: (1e-3, 0.01, 0.5)}
    found = lissom.fit(driven(), data, guess, method="radau", rtol=1e-4)
    assert found.success
    assert found.runs <= 8
    monkeypatch.setattr(searches, "OFFSET", 0.0)
    assert lissom.fit(driven(), data, guess, method="radau", rtol=1e-4).runs > found.runs


def test_errors_of_the_time_steps_are_told():
    """Against fits with steps so short that they do not count."""
    data = of_sine()
    guess = {YOUNG: (1e5, 2e5, 1e6), DAMPING: (1e-3, 0.01, 0.5)}
    coarse = lissom.fit(driven(), data, guess, dt=0.02)
    fine = lissom.fit(driven(), data, guess, dt=2.5e-3)
    assert "The time steps move" not in fine.message
    said = re.search(r"The time steps move (\S+) by about (\S+), (\S+) times the half width", coarse.message)
    assert said is not None
    which = coarse.names.index(said[1])
    moved = abs(coarse.values[which] - fine.values[which])
    assert float(said[2]) == pytest.approx(moved, rel=0.3)
    half = 0.5 * np.ptp(coarse.intervals[which])
    assert float(said[3]) == pytest.approx(moved / half, rel=0.3)
    # Steps that are chosen have no size to halve.
    assert "The time steps" not in lissom.fit(driven(), data, guess, method="radau").message


def test_inputs_of_each_step_keep_their_times_when_steps_are_halved():
    u = np.abs(np.sin(0.9 * np.arange(50.0)))[:, None]
    rows = iter(u)
    run = lissom.simulate(arm(), 0.5, control=lambda t, q, v: next(rows), control_step=0.01)
    found = lissom.fit(arm(), (run.t[1:], tips(run.q[1:], 1e-2)), {YOUNG: (1e5, 2e5, 1e6)}, u=u)
    assert "The time steps" not in found.message
    assert found.noise < 1.2e-2


def test_what_nothing_depends_on_stays_at_its_guess():
    found = lissom.fit(arm(), shapes(1e-4), {YOUNG: (1e5, 4e5, 1e6), DAMPING: (1e-3, 0.03, 0.5)})
    assert found.undetermined == (DAMPING,)
    assert found.values[1] == 0.03
    np.testing.assert_array_equal(found.intervals[1], [1e-3, 0.5])


def test_why_static_shapes_do_not_determine_friction():
    """At rest nothing slides: unless `sliding` says which way friction acts, there is none."""
    pulls = np.array([[0.5], [1.0], [1.5]])

    def rubbing(friction, sliding):
        tendon = dataclasses.replace(arm().actuators[0], friction=friction, sliding=sliding)
        return lissom.Rod(arm().segments, gravity=arm().gravity, actuators=[tendon])

    real = rubbing(0.3, 1.0)
    data = lissom.StaticShapes(tips(lissom.statics_many(real, pulls).q), u=pulls, noise=1e-5)
    guesses = {YOUNG: (1e5, 4e5, 1e6), "tendons[*].friction": (0.0, 0.1, 0.6)}
    left_out = lissom.fit(rubbing(0.1, None), data, guesses)
    assert "tendons[*].friction" in left_out.undetermined
    assert "`sliding` of a tendon says which way it acts" in left_out.message
    found = lissom.fit(rubbing(0.1, 1.0), data, guesses)
    assert found.undetermined == ()
    assert "sliding" not in found.message
    np.testing.assert_allclose(found.values, [3e5, 0.3], rtol=1e-3)


def test_data_in_millimetres_are_told():
    data = lissom.StaticShapes(1e3 * np.asarray(shapes().positions), u=shapes().u)
    found = lissom.fit(arm(), data, {YOUNG: (1e5, 4e5, 1e6)})
    assert "are they in metres?" in found.message


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: lissom.fit(arm(), motion(PULLS), {YOUNG: 3e5}, control_stp=0.1),
            r"fit\(\) got an unexpected keyword argument 'control_stp', .*; did you mean 'control_step'",
        ),
        (
            lambda: lissom.fit(arm(), shapes(), {YOUNG: 3e5}, max_run=3),
            r"fit\(\) got .*'max_run', .*; did you mean 'max_runs'",
        ),
    ],
)
def test_keywords_are_those_of_fit(call, message):
    with pytest.raises(TypeError, match=message):
        call()
    with pytest.raises(ValueError, match="u: StaticShapes has its own inputs"):
        lissom.fit(arm(), shapes(), {YOUNG: 3e5}, u=[[0.0]])
