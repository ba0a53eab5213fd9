"""One value for several numbers of a model, functions of parameters, and intervals within bounds."""

import math

import numpy as np
import pytest

import lissom
from lissom.analysis import makers, searches
from lissom.analysis.profiles import OutOfRuns, Profile, on_scale

COUNT = 4

SCENE = """version = 1
[[rod]]
[[rod.segment]]
length = 0.1
section = { shape = "circle", radius = 0.01 }
young_modulus = 3e5
poisson_ratio = 0.4
density = 1100
modes = { bend_y = 1 }
[[rod.segment]]
length = 0.2
section = { shape = "circle", radius = 0.01 }
young_modulus = 4e5
poisson_ratio = 0.4
density = 1100
modes = { bend_y = 1 }
[simulation]
t_end = 0.1
"""


def rod(young=3e5, damping=0.02, radius=0.01, count=COUNT):
    material = {"young_modulus": young, "poisson_ratio": 0.4, "density": 1100}
    segment = lissom.Segment(0.3 / count, radius, **material, modes={"bend_y": 1}, retardation_time=damping)
    return lissom.Rod([segment] * count)


def measured(model, noise=0.0, t_end=0.5, seed=4):
    run = lissom.simulate(model, t_end)
    tips = np.array([model.pose(q)[:3, 3] for q in run.q[1:]])
    return run.t[1:], tips + noise * np.random.default_rng(seed).standard_normal(tips.shape)


SHARED = {
    "segments[*].young_modulus": (1e5, 2e5, 1e6),
    "segments[*].retardation_time": (1e-3, 0.01, 0.1),
}


def test_a_shared_value_is_found_for_all_segments():
    found = lissom.fit(rod(2e5), measured(rod()), SHARED)
    np.testing.assert_allclose(found.values, [3e5, 0.02], rtol=1e-6)
    assert [segment.young_modulus for segment in found.model.segments] == [found.values[0]] * COUNT
    assert [segment.retardation_time for segment in found.model.segments] == [found.values[1]] * COUNT
    assert found.names == tuple(SHARED)


def test_a_function_of_parameters_is_fitted_alike():
    """Including the exact derivatives, so that it takes the same runs."""
    data = measured(rod(), 1e-3)
    shared = lissom.fit(rod(), data, SHARED)
    found = lissom.fit(
        lambda young, damping: rod(young, damping),
        data,
        {"young": (1e5, 2e5, 1e6), "damping": (1e-3, 0.01, 0.1)},
    )
    np.testing.assert_allclose(found.values, shared.values, rtol=1e-7)
    np.testing.assert_allclose(found.covariance, shared.covariance, rtol=1e-6)
    assert found.runs == shared.runs
    assert found.model.segments == rod(*found.values.tolist()).segments


@pytest.mark.filterwarnings("ignore:The finite number of modes:lissom.AccuracyWarning")
def test_functions_take_starts_shapes_and_frequencies_too():
    def taper(ratio):
        # Without damping, which lowers frequencies.
        return rod(damping=0.0, radius=(0.01, 0.01 * ratio), count=2)

    right = taper(0.7)
    run = lissom.simulate(right, 0.4, q0=[0.5, 0.2])
    tips = np.array([right.pose(q)[:3, 3] for q in run.q[1:]])
    found = lissom.fit(taper, (run.t[1:], tips), {"ratio": (0.2, 1.0, 2.0), "q0[0]": 0.1}, q0=[0.0, 0.2])
    np.testing.assert_allclose(found.values, [0.7, 0.5], rtol=1e-6)
    shape = right.pose(lissom.statics(right, space_error=False).q)[:3, 3]
    found = lissom.fit(taper, lissom.StaticShapes([shape]), {"ratio": (0.2, 0.9, 2.0)})
    assert found.values[0] == pytest.approx(0.7, rel=1e-6)
    rest = lissom.statics(right, space_error=False)
    frequencies = lissom.modes(right, rest.q).frequency
    found = lissom.fit(taper, lissom.NaturalFrequencies(frequencies), {"ratio": (0.2, 0.9, 2.0)})
    assert found.values[0] == pytest.approx(0.7, rel=1e-6)


@pytest.mark.parametrize(
    ("model", "parameters", "kind", "message"),
    [
        (lambda young: rod(young), {"yuong": 3e5}, ValueError, "got 'yuong', .*did you mean 'young'"),
        (
            lambda young: "rod",
            {"young": 3e5},
            TypeError,
            "expected a function that makes a Rod or a Robot, got str",
        ),
        (
            "rod",
            {"young": 3e5},
            TypeError,
            "expected a Rod or a Robot, or a function that makes one, got str",
        ),
        (rod(), {"segments[*].young_modlus": 3e5}, ValueError, "did you mean 'young_modulus'"),
        (rod(), {"segments[*]": 3e5}, ValueError, "expected the name of a finite number"),
        (rod(), {"bodies[*].mass": 3e5}, ValueError, r"bodies\[0\]: the model has 0 entries"),
        (
            rod(),
            {"segments[*].young_modulus": 3e5, "segments[1].young_modulus": 3e5},
            ValueError,
            "is listed twice, first as",
        ),
    ],
)
def test_what_cannot_be_fitted(model, parameters, kind, message):
    with pytest.raises(kind, match=message):
        lissom.fit(model, measured(rod()), parameters)


def test_shared_derivatives_are_sums():
    """Of motions, places, equilibria and frequencies; also by the adjoint."""
    model, wanted = rod(), ("young_modulus", "radius", "length", "retardation_time")
    each = [f"segments[{i}].{what}" for what in wanted for i in range(COUNT)]
    shared = [f"segments[*].{what}" for what in wanted]

    def summed(values):
        return values.reshape(*values.shape[:-1], len(wanted), COUNT).sum(axis=-1)

    one, many = (lissom.sensitivity(model, 0.3, names) for names in (shared, each))
    # Differences of fourth order: the lengths stand in products.
    for found, right in zip((one.dq, one.position()[1]), (many.dq, many.position()[1]), strict=True):
        np.testing.assert_allclose(found, summed(right), rtol=1e-6, atol=1e-9 * np.abs(summed(right)).max())
    objective = {"objective": lambda t, q, v: (float(q[-1, 0]), at_end(q), np.zeros_like(v))}
    one, many = (lissom.sensitivity(model, 0.3, names, **objective) for names in (shared, each))
    np.testing.assert_allclose(one.gradient, summed(many.gradient), rtol=1e-7)
    one, many = (
        lissom.equilibrium_sensitivity(model, names, frequencies=2)
        for names in ([n for n in names if "retardation" not in n] for names in (shared, each))
    )
    wanted = wanted[:-1]
    np.testing.assert_allclose(one.dq, summed(many.dq), rtol=1e-7, atol=1e-10)
    np.testing.assert_allclose(one.dfrequencies, summed(many.dfrequencies), rtol=1e-6, atol=1e-9)


def at_end(q):
    weight = np.zeros_like(q)
    weight[-1, 0] = 1.0
    return weight


def test_values_that_differ_are_told():
    model = lissom.Rod([rod(1e5).segments[0], rod(2e5).segments[0]])
    with pytest.raises(ValueError, match=r"has the values 100000, 200000, expected equal ones"):
        lissom.sensitivity(model, 0.1, ["segments[*].young_modulus"])
    # A fit sets them.
    found = lissom.fit(
        model, measured(rod(count=2)), {"segments[*].young_modulus": (1e5, 2e5, 1e6)}, max_runs=2
    )
    assert len({segment.young_modulus for segment in found.model.segments}) == 1


def test_sweeps_set_all():
    values = [3e5, 4e5]
    found = lissom.sweep(rod(), {"segments[*].young_modulus": values}, t_end=0.1)
    right = [lissom.simulate(rod(value), 0.1).q[-1] for value in values]
    np.testing.assert_array_equal(found.q, right)
    scene = lissom.Scene.loads(SCENE)
    found = lissom.sweep(scene, {"rod[*].segment[*].young_modulus": values})
    for i, value in enumerate(values):
        other = SCENE.replace("4e5", "3e5").replace("3e5", repr(value))
        np.testing.assert_array_equal(found.q[i], lissom.Scene.loads(other).run().q[-1])
    with pytest.raises(ValueError, match=r"link\[0\]|link: "):
        lissom.sweep(scene, {"link[*].joint.damping": values})


def pulled(friction=(0.1, 0.1)):
    """Two tendons, and a motor at the joint of the rod, which has no friction."""
    where = ((0.0, 0.006), (0.0, -0.006))
    tendons = [
        lissom.Tendon(f"pull {i}", [lissom.Along(offset=offset)], tension=1.0 + i, friction=each)
        for i, (offset, each) in enumerate(zip(where, friction, strict=True))
    ]
    segment = rod(count=1).segments[0]
    arm = lissom.Link("arm", rod=[segment] * 2, joint=lissom.Revolute((0, 1, 0), stiffness=1.0, damping=0.01))
    return lissom.Robot([arm], actuators=[lissom.Motor("arm", torque=0.1), *tendons])


def test_actuators_of_one_kind_are_counted_by_themselves():
    """As in scenes, where each kind has a list of its own."""
    names = ["tendons[0].friction", "tendons[1].friction"]
    each = lissom.sensitivity(pulled(), 0.1, names)
    by_all = lissom.sensitivity(pulled(), 0.1, ["actuators[1].friction", "actuators[2].friction"])
    np.testing.assert_array_equal(each.dq, by_all.dq)
    for name in ("tendon[*].friction", "tendons[*].friction"):
        both = lissom.sensitivity(pulled(), 0.1, [name])
        np.testing.assert_allclose(both.dq[..., 0], each.dq.sum(axis=-1), rtol=1e-5, atol=1e-9)
    found = lissom.sweep(pulled(), {"tendons[*].friction": [0.0, 0.2]}, t_end=0.1)
    right = [lissom.simulate(pulled((each, each)), 0.1).q[-1] for each in (0.0, 0.2)]
    np.testing.assert_array_equal(found.q, right)
    by_torque = lissom.sensitivity(pulled(), 0.1, ["motors[0].torque"])
    np.testing.assert_array_equal(by_torque.dq, lissom.sensitivity(pulled(), 0.1, ["actuators[0].torque"]).dq)
    with pytest.raises(ValueError, match=r"tendons\[2\]: the model has 2 entries at tendons"):
        lissom.sensitivity(pulled(), 0.1, ["tendons[2].friction"])
    with pytest.raises(ValueError, match=r"chambers\[0\]: the model has 0 entries at chambers"):
        lissom.sensitivity(pulled(), 0.1, ["chambers[*].pressure"])
    with pytest.raises(ValueError, match="is listed twice, first as"):
        lissom.sensitivity(pulled(), 0.1, ["tendons[*].friction", "actuators[2].friction"])
    with pytest.raises(ValueError, match=r"values 0\.1, 0\.2, expected equal ones"):
        lissom.sensitivity(pulled((0.1, 0.2)), 0.1, ["tendons[*].friction"])


def tree():
    """A rigid link between two rods of their own materials."""
    segment = rod(count=1).segments[0]
    joint = {"joint": lissom.Revolute((0, 1, 0), stiffness=1.0, damping=0.01)}
    links = [
        lissom.Link("lower", rod=[segment] * 2),
        lissom.Link("plate", body=lissom.Body(0.1, inertia=(1e-4, 1e-4, 1e-4)), parent="lower", **joint),
        lissom.Link("upper", rod=[segment], parent="plate", **joint),
    ]
    return lissom.Robot(links)


def test_links_are_named_by_their_names():
    names = ["links[upper].joint.stiffness", "links[lower].rod.segments[*].young_modulus"]
    found = lissom.sensitivity(tree(), 0.05, names)
    right = ["links[2].joint.stiffness", "links[0].rod.segments[*].young_modulus"]
    np.testing.assert_array_equal(found.dq, lissom.sensitivity(tree(), 0.05, right).dq)
    with pytest.raises(
        ValueError, match=r"number of one, such as 'links\[0\].uper', or the name of one, such as"
    ):
        lissom.sensitivity(tree(), 0.05, ["links[uper].joint.stiffness"])
    with pytest.raises(ValueError, match="is listed twice, first as"):
        lissom.sensitivity(tree(), 0.05, ["links[upper].joint.stiffness", "links[2].joint.stiffness"])
    scene = tree().to_scene(t_end=0.05)
    values = [1.0, 2.0]
    by_name = lissom.sweep(scene, {"link[upper].joint.stiffness": values})
    np.testing.assert_array_equal(by_name.q, lissom.sweep(scene, {"link[2].joint.stiffness": values}).q)
    for path in ("[upper].joint", "links[].joint", "links[a[0]].joint"):
        with pytest.raises(ValueError, match="expected a path of keys"):
            lissom.sensitivity(tree(), 0.05, [path])


def test_stars_leave_out_links_without_rods():
    every = lissom.sensitivity(tree(), 0.05, ["links[*].rod.segments[*].young_modulus"]).dq
    each = [f"links[{i}].rod.segments[*].young_modulus" for i in (0, 2)]
    summed = lissom.sensitivity(tree(), 0.05, each).dq.sum(axis=-1)
    np.testing.assert_allclose(every[..., 0], summed, rtol=1e-6, atol=1e-9 * np.abs(summed).max())
    with pytest.raises(ValueError, match=r"expected 'links\[\*\]\.rod\.segments\[0\]\.young_modulus'"):
        lissom.sensitivity(tree(), 0.05, ["segments[*].young_modulus"])


# Intervals.


def square(model, data):
    """Sum of squares of a model's residuals, by its own run."""
    run = lissom.simulate(model, data[0][-1])
    tips = np.array([model.pose(q)[:3, 3] for q in run.q[1:]])
    return float(((tips - data[1]) ** 2).sum())


def test_ends_within_bounds_are_those_of_the_likelihood():
    """The sum of squares there has grown by the square of Student's quantile."""
    from scipy.stats import t as student

    data = measured(rod(), 0.1, 0.2)
    bounds = {"segments[*].young_modulus": (1.5e5, 2.5e5, 2e6)}
    found = lissom.fit(rod(), data, bounds)
    (low, high), value = found.intervals[0], found.values[0]
    freedom = data[1].size - 1
    quantile = student.ppf(0.975, freedom)
    linear = quantile * math.sqrt(found.covariance[0, 0]) / value
    # Otherwise the linear interval would do.
    assert value * math.exp(-linear) < 1.5e5
    assert 1.5e5 <= low < value < high <= 2e6
    least = square(rod(value), data)
    allowed = least * (1.0 + quantile**2 / freedom)
    for end in (low, high):
        assert end in (1.5e5, 2e6) or square(rod(end), data) == pytest.approx(
            allowed, abs=0.05 * (allowed - least)
        )
    # Where an end is the bound, that still belongs to the interval.
    for end in {1.5e5, 2e6} & {low, high}:
        assert square(rod(end), data) <= allowed


def test_what_is_positive_has_positive_intervals():
    values, width = np.array([1.0, 1.0, 0.0, 1.0]), np.array([0.9, 1e-3, 0.5, np.inf])
    found = on_scale(values, width, np.array([0.0, 0.0, 0.0, 0.0]))
    np.testing.assert_allclose(found[0], [math.exp(-0.9), math.exp(0.9)])
    np.testing.assert_allclose(found[1], [1 - 1e-3, 1 + 1e-3], atol=1e-6)
    np.testing.assert_array_equal(found[2:], [[-0.5, 0.5], [-np.inf, np.inf]])
    np.testing.assert_allclose(on_scale(values, width, np.full(4, -1.0))[0], [0.1, 1.9])
    # Wide ones leave the bound, also of values that are almost zero, and their profiles are asked.
    values, width = np.array([1.0, 8.4e-4, 1e-14]), np.array([1.1, 0.043, 0.05])
    np.testing.assert_array_equal(
        on_scale(values, width, np.zeros(3)), np.stack([values - width, values + width], axis=1)
    )


def test_values_at_a_bound_have_intervals_that_begin_there():
    data = measured(rod(), 1e-3)
    name = "segments[*].young_modulus"
    found = lissom.fit(
        rod(), data, {name: (4e5, 5e5, 1e6), "segments[*].retardation_time": (1e-3, 0.01, 0.1)}
    )
    assert found.at_bounds == (name,)
    assert found.intervals[0, 0] == 4e5 < found.intervals[0, 1] < 1e6
    assert "At a bound: segments[*].young_modulus; the intervals end there." in found.message


def barely_damped(damping=0.02):
    """A rod of which a short and noisy motion hardly tells the damping."""
    material = {"young_modulus": 3e5, "shear_modulus": 4e5, "density": 1100, "retardation_time": damping}
    return lissom.Rod([lissom.Segment(0.3, 0.01, **material, modes={"bend_y": 2})])


def loaded(young=3e5, mass=0.0):
    """A rod with a mass at its tip and a tendon whose tension is known."""
    pull = lissom.Tendon("pull", [lissom.Along(offset=(0, 0.008))], tension=lissom.Input("pull", 0.0))
    segment = lissom.Segment(
        0.2, 0.01, young, poisson_ratio=0.4, density=1100, modes={"bend_y": 2}, retardation_time=0.0
    )
    return lissom.Rod([segment], tip_mass=mass, actuators=[pull])


@pytest.mark.filterwarnings("ignore:The finite number of modes:lissom.AccuracyWarning")
@pytest.mark.slow
@pytest.mark.parametrize("mass", [0.0, 5e-4])
def test_intervals_near_a_bound_cover_as_often_as_they_say(mass):
    """A mass at its bound of zero, and one that is as large as its error."""
    rng = np.random.default_rng(3)
    inputs, places = [[0.0], [1.0], [2.0], [3.0]], (0.1, 0.2)
    bounds = {"segments[0].young_modulus": (1e5, 2.5e5, 1e6), "tip_mass": (0, 1e-3, 0.1)}
    right = loaded(mass=mass)
    found = [lissom.statics(right, u=u, space_error=False).q for u in inputs]
    exact = np.array([[right.pose(q, X)[:3, 3] for X in places] for q in found])
    covered, trials = np.zeros(2), 100
    for _ in range(trials):
        data = lissom.StaticShapes(exact + 1e-3 * rng.standard_normal(exact.shape), u=inputs)
        low, high = lissom.fit(loaded(), data, bounds, places=places).intervals.T
        assert (low >= [1e5, 0.0]).all()
        covered += (low <= [3e5, mass]) & (high >= [3e5, mass])
    # 95 of 100 on average, with a standard deviation of 2.2: the bound is three of these below.
    assert (covered >= 88).all(), covered


@pytest.mark.parametrize("highest", [1.0, 50.0, np.inf])
@pytest.mark.parametrize(("seed", "is_at_bound"), [(1, False), (3, True)])
def test_intervals_of_values_at_zero_end_where_the_data_say(seed, is_at_bound, highest):
    """Also of values that are positive by rounding alone, or much smaller than their errors."""
    from scipy.optimize import brentq
    from scipy.stats import t as student

    name = "segments[0].retardation_time"
    data = measured(barely_damped(), 0.04, 0.3, seed)

    def of(damping):
        return square(barely_damped(damping), data)

    found = lissom.fit(barely_damped(), data, {name: (0, 1e-2, highest)})
    assert found.at_bounds == ((name,) if is_at_bound else ())
    assert 0.0 < found.values[0] < 0.1 * math.sqrt(found.covariance[0, 0])
    freedom = data[1].size - 1
    quantile = student.ppf(0.975, freedom)
    least = of(found.values[0])
    allowed = least * (1.0 + quantile**2 / freedom)
    assert of(0.0) < allowed
    end = brentq(lambda damping: of(damping) - allowed, found.values[0], 1.0)
    # Far from that of the linear interval.
    assert end > 2.0 * (found.values[0] + quantile * math.sqrt(found.covariance[0, 0]))
    np.testing.assert_allclose(found.intervals, [[0.0, end]], rtol=0.02)


@pytest.mark.filterwarnings("ignore:The finite number of modes:lissom.AccuracyWarning")
def test_what_is_not_determined_lies_between_its_bounds():
    rest = lissom.statics(rod(count=1), np.zeros(1), space_error=False)
    shape = lissom.StaticShapes([rod(count=1).pose(rest.q)[:3, 3]])
    bounds = {"segments[0].young_modulus": (1e5, 2e5, 1e6), "segments[0].density": (1e3, 1.2e3, 2e3)}
    found = lissom.fit(rod(count=1), shape, bounds)
    assert found.undetermined == tuple(bounds)
    np.testing.assert_array_equal(found.intervals, [[1e5, 1e6], [1e3, 2e3]])


def test_profiles_against_a_grid():
    """Two coefficients of a decay, of which the other one settles at each value of one."""
    x = np.linspace(0.0, 1.0, 12)
    data = 2.0 * np.exp(-1.5 * x) + 0.1 * np.random.default_rng(5).standard_normal(12)

    def evaluated(p):
        decay = np.exp(-p[1] * x)
        return p[0] * decay - data, np.stack([decay, -p[0] * x * decay], axis=1)

    from scipy.optimize import least_squares

    best = least_squares(lambda p: evaluated(p)[0], [1.0, 1.0], xtol=1e-12, ftol=1e-12).x
    least = float(np.sum(evaluated(best)[0] ** 2))
    more = 0.3
    rates = np.linspace(0.0, 12.0, 12001)
    decays = np.exp(-rates[:, None] * x)
    heights = decays @ data / (decays**2).sum(axis=1)
    squares = ((heights[:, None] * decays - data) ** 2).sum(axis=1)
    inside = rates[squares <= least + more]
    for lowest, highest in ((0.0, np.inf), (-np.inf, np.inf), (1.0, 1.6), (0.0, 50.0)):
        profile = Profile(
            evaluated,
            best,
            evaluated(best)[1],
            least,
            more,
            np.array([-np.inf, lowest]),
            np.array([np.inf, highest]),
        )
        found = [profile.end(1, side, best[1] + side * 0.5) for side in (-1, 1)]
        right = [max(inside[0], lowest), min(inside[-1], highest)]
        np.testing.assert_allclose(found, right, rtol=0, atol=0.02)


def test_profiles_without_an_end_and_without_runs():
    def evaluated(p):
        return np.array([np.tanh(p[0]), 1.0]), np.array([[1.0 - np.tanh(p[0]) ** 2], [0.0]])

    nowhere = np.array([np.inf])
    # The sum of squares grows by less than one for ever.
    profile = Profile(evaluated, np.zeros(1), evaluated(np.zeros(1))[1], 1.0, 1.5, -nowhere, nowhere)
    assert [profile.end(0, side, side * 1.0) for side in (-1, 1)] == [-np.inf, np.inf]

    def exhausted(p):
        raise OutOfRuns

    with pytest.raises(OutOfRuns):
        Profile(exhausted, np.zeros(1), np.ones((2, 1)), 1.0, 0.5, -nowhere, nowhere).end(0, 1, 1.0)


def test_profiles_end_where_runs_fail():
    """There the sum of squares jumps, which regula falsi alone does not find in any number of steps."""
    runs = []

    def evaluated(p):
        runs.append(p[0])
        residual = p[0] if p[0] <= 1e-3 else np.inf
        return np.array([residual, 1.0]), np.array([[1.0], [0.0]])

    nowhere = np.array([np.inf])
    for highest in (np.inf, 1e6):
        profile = Profile(evaluated, np.zeros(1), np.eye(2, 1), 1.0, 1.0, -nowhere, np.array([highest]))
        assert profile.end(0, 1, 1e6) == pytest.approx(1e-3, rel=0.01)
    assert max(runs) == 1e6
    # The first guess is taken, not the bound.
    runs.clear()
    profile = Profile(evaluated, np.zeros(1), np.eye(2, 1), 1.0, 1e-8, -nowhere, np.array([1e6]))
    assert profile.end(0, 1, 1.1e-4) == pytest.approx(1e-4, rel=0.01)
    assert max(runs) == 1.1e-4
    # There is nothing between the value and its bound, or its guess.
    runs.clear()
    assert [profile.end(0, -1, 0.0), Profile.end(profile, 0, 1, 0.0)] == [0.0, 0.0]
    assert not runs


def test_too_few_runs_for_profiles_are_told(monkeypatch):
    data = measured(rod(), 0.1, 0.2)
    bounds = {"segments[*].young_modulus": (1.5e5, 2.5e5, 2e6)}
    monkeypatch.setattr(searches.Profile, "end", lambda *_: (_ for _ in ()).throw(OutOfRuns))
    found = lissom.fit(rod(), data, bounds)
    assert found.success
    name = "segments[*].young_modulus"
    assert (
        f"Ends of the intervals of {name} are those of the covariance, cut at their bounds: "
        "100 runs (max_runs) did not find them"
    ) in found.message
    assert 1.5e5 <= found.intervals[0, 0] < found.intervals[0, 1] <= 2e6


@pytest.mark.parametrize("kind", [ValueError, KeyboardInterrupt])
def test_what_happens_in_profiles_is_told(kind, monkeypatch):
    """A run that fails there counts, and Ctrl-C there does not take back that the search has converged."""
    data = measured(rod(), 1e-3)
    bounds = {"segments[*].young_modulus": (4e5, 5e5, 1e6), "segments[*].retardation_time": (1e-3, 0.01, 0.1)}
    whole = lissom.fit(rod(), data, bounds)
    real, ends = makers.model_with, []

    def failing(model, values):
        if ends == [None]:
            ends.append(kind("enough"))
            raise ends[-1]
        return real(model, values)

    def end(*arguments):
        if not ends:
            ends.append(None)
        return real_end(*arguments)

    real_end = searches.Profile.end
    monkeypatch.setattr(makers, "model_with", failing)
    monkeypatch.setattr(searches.Profile, "end", end)
    if kind is KeyboardInterrupt:
        with pytest.raises(KeyboardInterrupt) as caught:
            lissom.fit(rod(), data, bounds)
        found = caught.value.result
        assert "Interrupted after" in found.message
        assert "the intervals are those of the covariance, cut at their bounds" in found.message
        low, high = found.intervals.T
        assert (low >= [4e5, 1e-3]).all()
        assert (high <= [1e6, 0.1]).all()
    else:
        found = lissom.fit(rod(), data, bounds)
        assert f"1 of {found.runs} trial runs failed" in found.message
        assert "enough" in found.message
    assert found.success
    assert found.message.startswith("Converged")
    assert found.at_bounds == whole.at_bounds == ("segments[*].young_modulus",)
    np.testing.assert_array_equal(found.values, whole.values)


def test_messages_are_in_words():
    data = measured(rod(), 1e-3)
    found = lissom.fit(rod(), data, SHARED)
    assert found.message.startswith(
        "Converged: the values are within 0.001 of their uncertainty from the best ones."
    )
    found = lissom.fit(rod(), measured(rod()), SHARED)
    assert found.message.startswith("Converged: the ")
    found = lissom.fit(rod(), data, SHARED, max_runs=1)
    assert not found.success
    assert found.message.startswith("Not converged: 1 run (max_runs) did not suffice")
