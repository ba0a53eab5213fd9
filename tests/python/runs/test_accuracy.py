"""Requested accuracy: requests are satisfied, and error estimates are correct."""

import sys
from pathlib import Path

import numpy as np
import pytest

import lissom

ROOT = Path(__file__).parents[3]
sys.path.insert(0, str(ROOT / "benches" / "python"))
from accuracy import honesty  # noqa: E402

SCENES = ROOT / "scenes"

# Number of cases of each family, out of those of the script.
HONEST_CASES = 6

# Maximum ratio of claimed to true space error if only the true one satisfies the request.
ALARMED = 5
# Maximum ratio of a claimed error to the true one, so that claims remain meaningful.
OVERSTATED = 100
HANGING = (0.5**0.5, 0.0, 0.5**0.5, 0.0)
STEP = 0.02


def wire(modes=3, **options):
    segment = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800.0, {"bend_y": modes}, retardation_time=1e-4)
    return lissom.Rod([segment], **options)


def rubber(**modes):
    return lissom.Rod([lissom.Segment(1.0, 0.02, 5e6, 5e6 / 3, 1000.0, modes)])


def two_segments():
    modes = {"torsion": 2, "bend_y": 2, "bend_z": 2}
    segment = lissom.Segment(0.3, 0.02, 1e6, 4e5, 1e3, modes, retardation_time=0.01)
    return lissom.Rod([segment, segment], tip_force=(0.0, 0.05, 0.0))


def tentacle():
    return lissom.Scene.load(SCENES / "tentacle.toml").model


PIECEWISE = lissom.Segment(1.0, 0.01, 1e6, 4e5, 1e3, {"bend_y": 4}, basis="piecewise_constant")

# Models, durations, initial coordinates, and the tightest request that a test has time for.
GALLERY = {
    "lab horizontal": (wire, 3.0, None, 1e-8),
    "lab hanging": (lambda: wire(base_orientation=HANGING), 3.0, None, 1e-8),
    "lab pendulum": (lissom.SpringPendulum, 3.0, (-np.pi / 4, 0.5), 1e-8),
    "tentacle": (tentacle, 3.0, None, 1e-4),
    "rubber rod": (lambda: rubber(bend_y=5), 1.0, None, 1e-8),
    "two segments": (two_segments, 1.0, None, 1e-6),
}


def tips(rod, motion):
    if isinstance(rod, lissom.SpringPendulum):
        angle, elongation = motion.q.T
        return (rod.length + elongation)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return rod.pose(motion.q, [rod.length], t=motion.t)[:, 0, :3, 3]


def distance(rod, motion, other, other_rod=None):
    difference = tips(rod, motion) - tips(other_rod or rod, other)
    return np.linalg.norm(difference, axis=1).max() / rod.length


@pytest.mark.parametrize("name", GALLERY)
def test_the_time_error_is_what_was_asked_for_and_what_is_said(name):
    make, t_end, q0, tightest = GALLERY[name]
    rod = make()
    reference = {"method": "dop853" if tightest < 1e-6 else "radau", "rtol": 1e-3 * tightest}
    exact = lissom.simulate(rod, t_end, q0=q0, atol=1e-4 * tightest, dt=STEP, **reference)
    assert exact.success
    for tolerance in [x for x in (1e-2, 1e-4, 1e-6, 1e-8) if x >= tightest]:
        found = lissom.simulate(rod, t_end, q0=q0, method="auto", rtol=tolerance, dt=STEP)
        error = distance(rod, found, exact)
        assert found.success, found.message
        assert found.stats.time_error <= tolerance
        if error > 1e-2 * tightest:  # what the reference leaves
            # An upper bound, not an estimate.
            assert error < found.stats.time_error < OVERSTATED * error


@pytest.mark.parametrize(
    ("coarse", "converged"),
    [(wire(3), wire(10)), (rubber(bend_y=4), rubber(bend_y=12))],
    ids=["lab horizontal", "rubber rod"],
)
def test_the_space_error_is_what_more_modes_change(coarse, converged):
    found = lissom.simulate(coarse, 0.5, method="auto", rtol=1e-5, dt=STEP)
    exact = lissom.simulate(converged, 0.5, method="auto", rtol=1e-6, dt=STEP)
    error = distance(coarse, found, exact, converged)
    assert 0.1 < found.stats.space_error / error < 10
    assert "give it more" in found.message


def test_a_stiff_model_gets_the_implicit_method_and_a_soft_one_the_explicit_one():
    stiff = lissom.simulate(rubber(bend_y=2, stretch=2, shear_z=2), 0.02, method="auto", rtol=1e-2, dt=STEP)
    soft = lissom.simulate(wire(), 0.1, method="auto", rtol=1e-6, dt=STEP)
    still = lissom.simulate(wire(base_orientation=HANGING), 0.1, method="auto", dt=STEP)
    very_stiff = lissom.Segment(0.3, 0.02, 1e6, 4e5, 1e3, {"bend_y": 2, "stretch": 2}, retardation_time=0.1)
    damped = lissom.simulate(lissom.Rod([very_stiff]), 0.1, method="auto", dt=STEP)
    assert stiff.success
    assert "Method: dop853, because its largest rate, 48.782 Hz" in soft.message
    assert "Method: radau, because its largest rate" in still.message
    assert "Method: radau, because its largest rate" in damped.message


def test_nodes_are_added_where_the_accuracy_needs_them():
    jelly = lissom.Segment(1.0, 0.02, 1e4, 4e3, 1e3, {"bend_y": 3}, retardation_time=1e-3)
    rod = lissom.Rod([jelly])
    found = lissom.simulate(rod, 2.0, method="auto", rtol=1e-2, dt=STEP)
    assert found.success
    assert "number of nodes was raised to" in found.message
    assert found.model.nodes[0] > rod.nodes[0]
    # More modes than these change nothing.
    many = lissom.Rod([lissom.Segment(1.0, 0.02, 1e4, 4e3, 1e3, jelly.modes, 1e-3, nodes=96)])
    exact = lissom.simulate(many, 2.0, method="radau", rtol=1e-8, atol=1e-8, dt=STEP)
    assert distance(found.model, found, exact, many) < 3e-2
    assert found.balance.drift < 1e-2


def test_the_steps_alone_can_be_asked_for():
    """The same motion without what is estimated of modes and nodes, and without its run.

    The motion is not linear, and forces leave a doubt.
    """
    calls = []

    def push(t):
        calls.append(t)
        return (0.0, 0.0, 5.0 * np.sin(9.0 * t))

    rod = lissom.Rod([wire().segments[0]], loads=[lissom.Load(force=push, at=0.37)])
    counts, found = [], []
    for space_error in (True, False):
        calls.clear()
        method = lissom.methods.Auto(rtol=2.5e-2, space_error=space_error)
        found.append(lissom.simulate(rod, 0.5, method=method))
        counts.append(len(calls))
    judged, alone = found
    assert np.array_equal(judged.q, alone.q)
    assert judged.stats.time_error == alone.stats.time_error
    assert judged.stats.space_error > 1e-4
    assert alone.stats.space_error is None
    assert "The space error is not estimated." in alone.message
    assert counts[1] < 0.8 * counts[0]
    jelly = lissom.Rod([lissom.Segment(1.0, 0.02, 1e4, 4e3, 1e3, {"bend_y": 3}, retardation_time=1e-3)])
    few = lissom.simulate(jelly, 2.0, method=lissom.methods.Auto(rtol=1e-2, space_error=False))
    assert few.success
    assert few.model.nodes == jelly.nodes


def test_a_space_error_far_beyond_the_request_needs_no_finer_run():
    """Forces and linear responses show it; the reference is a rod of nine modes."""
    calls = []

    def push(t):
        calls.append(t)
        return (0.0, 0.0, 5.0 * np.sin(9.0 * t))

    def made(modes):
        return lissom.Rod([wire(modes).segments[0]], loads=[lissom.Load(force=push, at=0.37)])

    t = np.linspace(0.0, 0.5, 101)
    counts = []
    for space_error in (False, True):
        calls.clear()
        method = lissom.methods.Auto(rtol=1e-3, space_error=space_error)
        found = lissom.simulate(made(3), 0.5, method=method, t_eval=t)
        counts.append(len(calls))
    # Forces in a dozen states and linear responses at a hundred times; a run takes a thousand.
    assert counts[1] < 1.15 * counts[0]
    exact = lissom.simulate(made(9), 0.5, method="radau", rtol=1e-6, atol=1e-8, t_eval=t)
    tips = [motion.model.pose(motion.q, [1.0], t=t)[:, 0, :3, 3] for motion in (found, exact)]
    true = np.linalg.norm(tips[0] - tips[1], axis=1).max()
    assert true < found.stats.space_error < 2.0 * true


def test_nodes_that_are_given_stay():
    segment = lissom.Segment(1.0, 0.02, 1e4, 4e3, 1e3, {"bend_y": 3}, retardation_time=1e-3, nodes=12)
    rod = lissom.Rod([segment])
    found = lissom.simulate(rod, 2.0, method="auto", rtol=1e-3, dt=STEP)
    assert found.model is rod
    assert "as many nodes" not in found.message
    assert found.stats.space_error is None or found.stats.space_error > 1e-3


def test_the_model_of_a_result_is_the_one_that_was_given():
    rod = wire()
    assert lissom.simulate(rod, 0.1, method="auto", dt=STEP).model is rod
    assert lissom.simulate(rod, 0.1).model is rod


def test_a_request_works_no_longer_than_it_may():
    found = lissom.simulate(wire(), 3.0, method="auto", rtol=1e-6, max_steps=20, dt=STEP)
    assert (found.success, found.status) == (False, "too_many_steps")
    assert 0 < found.t[-1] < 3.0


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3])
def test_modes_are_chosen_to_an_accuracy(tolerance):
    open_rod = lissom.Rod([lissom.Segment(1.0, 0.02, 5e6, 5e6 / 3, 1000.0, {}, retardation_time=1e-2)])
    rod = lissom.choose_modes(open_rod, 0.5, rtol=tolerance)
    modes = rod.segments[0].modes
    assert set(modes) <= {"bend_y", "stretch", "shear_z"}  # gravity moves it in a plane
    assert rod.kernel == "planar"
    rich = {"bend_y": 10, "stretch": 6, "shear_z": 6}
    exact_rod = lissom.Rod([lissom.Segment(1.0, 0.02, 5e6, 5e6 / 3, 1000.0, rich, retardation_time=1e-2)])
    found = lissom.simulate(rod, 0.5, method="auto", rtol=tolerance, dt=STEP)
    exact = lissom.simulate(exact_rod, 0.5, method="auto", rtol=1e-2 * tolerance, dt=STEP)
    assert distance(rod, found, exact, exact_rod) < 3 * tolerance
    # The number is minimal: without the last mode of bending the tip is elsewhere.
    fewer = lissom.Segment(1.0, 0.02, 5e6, 5e6 / 3, 1000.0, {"bend_y": 1}, retardation_time=1e-2)
    poor = lissom.simulate(lissom.Rod([fewer]), 0.5, method="auto", rtol=tolerance, dt=STEP)
    assert distance(poor.model, poor, exact, exact_rod) > 3 * tolerance


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("joint", [lissom.Weld(), lissom.Revolute((0, 0, 1))])
def test_modes_are_chosen_for_rods_that_carry_links(joint, size):
    """Trials in space have more modes than the planar choice, and both measure the same places of the body.
    Lengths in another unit, with stiffness and gravity such that the motion is the same."""

    def robot(modes):
        segment = lissom.Segment(
            0.4 * size,
            0.01 * size,
            1e6 * size**2,
            poisson_ratio=0.45,
            density=1050.0,
            modes=modes,
            retardation_time=0.02,
        )
        inertia = np.full(3, 1e-5 * size**5)
        body = lissom.Body(0.05 * size**3, centre=(0, 0.04 * size, 0), inertia=inertia)
        links = [lissom.Link("rod", joint=joint, rod=[segment]), lissom.Link("body", parent="rod", body=body)]
        return lissom.Robot(links, gravity=(0, -9.81 * size, 0))

    chosen = lissom.choose_modes(robot({}), 0.3, rtol=1e-2)
    assert set(chosen.links[0].rod[0].modes) <= {"bend_z", "stretch", "shear_y"}
    times = np.linspace(0, 0.3, 31)
    tips = []
    for model in (chosen, robot({"bend_z": 9, "stretch": 4, "shear_y": 4})):
        motion = lissom.simulate(model, 0.3, method="auto", rtol=1e-3, t_eval=times)
        assert motion.success
        tips.append(model.pose(motion.q, link="body")[:, :3, 3])
    assert np.linalg.norm(tips[0] - tips[1], axis=1).max() < 1e-2 * 0.4 * size


def test_modes_are_chosen_in_the_segments_that_are_named():
    open_segment, fixed = (
        lissom.Segment(0.5, 0.02, 5e6, 5e6 / 3, 1000.0, modes, retardation_time=1e-2)
        for modes in ({}, {"bend_y": 2})
    )
    rod = lissom.choose_modes(lissom.Rod([fixed, open_segment]), 0.2, rtol=1e-2, segments=[1])
    assert rod.segments[0] == fixed
    assert rod.segments[1].modes["bend_y"] >= 1


@pytest.mark.parametrize(
    ("problem", "options"),
    [
        ("rtol: got 1, expected a number in", {"rtol": 1.0}),
        ("t_end: got -1, expected a finite number > 0", {"t_end": -1.0}),
        ("segments: got 3, expected a segment, 0 to 0", {"segments": [3]}),
        ("segments\\[0\\].basis: got piecewise functions", {"rod": lissom.Rod([PIECEWISE])}),
    ],
)
def test_choices_of_modes_that_make_no_sense_are_refused(problem, options):
    with pytest.raises(ValueError, match=problem):
        lissom.choose_modes(**({"rod": wire(), "t_end": 0.1} | options))


def test_no_choice_of_modes_says_why():
    # The weight is a thousand times what the rod can carry: it curls up more than the nodes can resolve.
    soft = lissom.Segment(1.0, 0.001, 1.0, 0.4, 1000.0, {})
    with pytest.raises(lissom.LissomError, match="No modes were chosen, because a trial failed"):
        lissom.choose_modes(lissom.Rod([soft]), 1.0, rtol=0.1)


def test_a_scene_leaves_the_modes_open():
    text = (SCENES / "lab-horizontal.toml").read_text()
    settings = 'method = "newmark"\ndt = 1e-2\njac = "analytic"\n'
    text = text.replace(settings, 'method = "auto"\nrtol = 1e-3\n').replace("3.0", "0.5")
    assert "modes = { bend_y = 3 }" in text
    scene = lissom.Scene.loads(text.replace("modes = { bend_y = 3 }", 'modes = "auto"'))
    assert scene.model.segments[0].modes["bend_y"] >= 3
    assert len(scene.q0) == scene.model.n
    motion = scene.run()
    assert motion.success
    assert motion.stats.space_error <= 1e-3


@pytest.mark.parametrize(
    ("problem", "old", "new"),
    [
        ('modes: "auto", but the method is another; give simulation.method', 'method = "auto"\n', ""),
        (
            'rod\\[0\\].q0: given, but the modes are "auto"',
            "[[rod.segment]]",
            "q0 = [0.1]\n\n[[rod.segment]]",
        ),
        ('modes: got "all"; expected "auto"', '"auto"', '"all"'),
    ],
)
def test_open_modes_that_make_no_sense_are_refused(problem, old, new):
    text = (SCENES / "lab-horizontal.toml").read_text()
    settings = 'method = "newmark"\ndt = 1e-2\njac = "analytic"\n'
    text = text.replace(settings, 'method = "auto"\nrtol = 1e-3\n').replace(
        "modes = { bend_y = 3 }", 'modes = "auto"'
    )
    assert old in text
    with pytest.raises(lissom.SceneError, match=problem):
        lissom.Scene.loads(text.replace(old, new, 1))


def test_chaos_is_not_called_accurate():
    motion = lissom.simulate(lissom.SpringPendulum(), 300.0, q0=[1.5, 0.5], method="auto", rtol=1e-8, dt=1.0)
    assert (motion.success, motion.status) == (False, "accuracy_not_reached")
    assert "shorten the time" in motion.message
    assert motion.t[-1] == 300.0
    assert motion.stats.time_error > 1e-8


def test_no_errors_are_claimed_by_other_methods():
    stats = lissom.simulate(wire(), 0.1).stats
    assert (stats.time_error, stats.space_error) == (None, None)
    stats = lissom.simulate(lissom.SpringPendulum(), 0.1, method="auto").stats
    assert stats.time_error is not None
    assert stats.space_error is None


def test_the_default_accuracy():
    rod = wire()
    default = lissom.simulate(rod, 0.5, method="auto", dt=STEP)
    explicit = lissom.simulate(rod, 0.5, method="auto", rtol=1e-4, dt=STEP)
    np.testing.assert_array_equal(default.q, explicit.q)


@pytest.mark.parametrize(
    ("problem", "options"),
    [
        ("rtol: got 1, expected a number in .*length", {"rtol": 1.0}),
        ("rtol: got 1e-15", {"rtol": 1e-15}),
        ("rtol: got NaN", {"rtol": float("nan")}),
        ('atol: the method "auto" takes `rtol`', {"atol": 1e-6}),
        ('beta: the method "auto" takes `rtol`', {"beta": 0.25}),
        ("dt: got 0", {"dt": 0.0}),
    ],
)
def test_what_makes_no_sense_is_refused(problem, options):
    with pytest.raises(ValueError, match=problem):
        lissom.simulate(wire(), 0.1, method="auto", **options)


def test_a_stopped_run_is_an_interrupted_one():
    motion = lissom.simulate(wire(), 3.0, method="auto", progress=lambda t: True)
    assert (motion.success, motion.status) == (False, "interrupted")


def test_two_runs_the_same_bits():
    first, second = (lissom.simulate(two_segments(), 0.3, method="auto", dt=STEP) for _ in range(2))
    np.testing.assert_array_equal(first.q, second.q)
    assert first.stats.time_error == second.stats.time_error


def test_a_scene_with_method_auto():
    text = (SCENES / "lab-horizontal.toml").read_text()
    settings = 'method = "newmark"\ndt = 1e-2\njac = "analytic"\n'
    assert settings in text
    scene = lissom.Scene.loads(text.replace(settings, 'method = "auto"\nrtol = 1e-5\n').replace("3.0", "0.5"))
    assert (scene.simulation.method, scene.simulation.rtol) == ("auto", 1e-5)
    motion = scene.run()
    assert motion.success
    assert motion.stats.time_error <= 1e-5
    np.testing.assert_array_equal(motion.q, lissom.simulate(scene.model, 0.5, method="auto", rtol=1e-5).q)


@pytest.mark.parametrize(
    ("problem", "settings"),
    [
        ("simulation.atol: method .auto. does not take it", 'method = "auto"\natol = 1e-3'),
        ("simulation.rtol: got 1", 'method = "auto"\nrtol = 1.0'),
    ],
)
def test_what_makes_no_sense_in_a_scene_is_refused(problem, settings):
    text = (SCENES / "lab-horizontal.toml").read_text()
    text = text.replace('method = "newmark"\ndt = 1e-2\njac = "analytic"', settings)
    with pytest.raises(lissom.SceneError, match=problem):
        lissom.Scene.loads(text)


def test_where_nothing_moves_one_mode_is_left():
    segment = lissom.Segment(0.4, 0.01, 3e5, 1e5, 1070.0, {"bend_y": 1}, retardation_time=0.02)
    rod = lissom.Rod([segment], gravity=(0, 0, 0))
    assert lissom.choose_modes(rod, 0.1, rtol=1e-3).n == 1


def undamped_wire():
    return lissom.Rod([lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800.0, {"bend_y": 3})])


def shaken_beam():
    """Excited at its first resonance, with weak damping."""
    beam = lissom.Segment(0.5, 5e-3, 70e9, 26e9, 2700.0, {"bend_y": 2}, retardation_time=1e-6)
    frequency = natural_frequency(lissom.Rod([beam]))
    shaken = lissom.BaseMotion(translation=lissom.Harmonic([0.0, 0.0, 1e-4], frequency))
    return lissom.Rod([beam], base_motion=shaken, gravity=(0, 0, 0))


def pin():
    """A steel pin under a sudden load."""
    pin = lissom.Segment(0.05, 2e-3, 210e9, 80e9, 7800.0, {"bend_y": 2})
    load = lissom.Load(force=([1e-2, 1.001e-2], [[0.0, 0.0, 0.0], [0.0, 0.0, 250.0]]))
    return lissom.Rod([pin], loads=[load])


def struck():
    """Excited by a pulse that is a function of time, late and short."""
    beam = lissom.Segment(0.5, 5e-3, 70e9, 26e9, 2700.0, {"bend_y": 2}, retardation_time=1e-6)
    pulse = lissom.Load(force=lambda t: [0.0, 0.0, 60.0 if 0.7 < t < 0.71 else 0.0])
    return lissom.Rod([beam], loads=[pulse])


def natural_frequency(rod):
    """The first natural frequency in hertz."""
    rest = np.zeros(rod.n)
    stiffness, _, mass = rod.tangent(rest, rest, rest)
    return np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real.min()) / (2 * np.pi)


# Motions that too long steps damp out or miss: rods, durations, requests.
FOLLOWED = {
    "undamped wire": (undamped_wire, 100.0, 1e-2),
    "undamped wire for long": (undamped_wire, 300.0, 1e-2),
    "at resonance": (shaken_beam, 5.0, 1e-2),
    "loaded suddenly": (pin, 0.05, 1e-3),
    "struck late": (struck, 1.0, 1e-2),
}


@pytest.mark.parametrize("name", FOLLOWED)
def test_what_can_be_seen_is_followed(name):
    make, t_end, tolerance = FOLLOWED[name]
    rod = make()
    times = np.linspace(0.0, t_end, 501)
    found = lissom.simulate(rod, t_end, method="auto", rtol=tolerance, t_eval=times)
    exact = lissom.simulate(
        rod, t_end, method="dop853", rtol=1e-9, atol=1e-6 * tolerance, t_eval=times, max_step=2e-3
    )
    assert exact.success
    assert found.success, found.message
    error = distance(rod, found, exact)
    assert error < tolerance
    assert error < found.stats.time_error


def test_what_can_be_seen_is_followed_or_refused():
    found = lissom.simulate(undamped_wire(), 300.0, method="auto", rtol=1e-2, max_steps=500, dt=1.0)
    assert (found.success, found.status) == (False, "too_many_steps")


def test_few_times_are_as_good_as_many():
    rod = undamped_wire()
    few, many = (
        lissom.simulate(rod, 5.0, method="auto", rtol=1e-3, t_eval=times)
        for times in ([2.5, 5.0], np.linspace(0.0, 5.0, 101))
    )
    np.testing.assert_array_equal(few.t, [2.5, 5.0])
    np.testing.assert_array_equal(few.q, many.q[[50, 100]])
    assert few.a.shape == few.q.shape
    assert few.balance.total.shape == (2,)
    assert few.stats.time_error == pytest.approx(many.stats.time_error, rel=1e-6)


@pytest.mark.parametrize("family", list(honesty.FAMILIES))
def test_random_motions_are_within_what_is_claimed(family):
    verdicts = [honesty.judge(family, number, seed=1) for number in range(HONEST_CASES)]
    for verdict in verdicts:
        assert verdict.success, verdict
        assert verdict.missed <= 1, verdict
        assert verdict.hidden <= 1, verdict


@pytest.mark.parametrize("family", list(honesty.SPACE_FAMILIES))
def test_random_rods_are_as_coarse_as_is_claimed(family):
    verdicts = [honesty.judge_space(family, number, seed=1) for number in range(HONEST_CASES)]
    for verdict in verdicts:
        assert verdict.hidden <= 3, verdict
        assert verdict.alarm <= ALARMED, verdict


def test_strains_without_modes_are_tried():
    segment = lissom.Segment(0.5, 4e-3, 2e9, 7e8, 1200.0, {"bend_y": 4}, retardation_time=1e-2)
    aside = lissom.Body(0.02, centre=(0.0, 0.1, 0.0))
    rod = lissom.Rod([segment], bodies=[aside])
    twisting = lissom.Segment(0.5, 4e-3, 2e9, 7e8, 1200.0, {"bend_y": 8, "torsion": 4, "bend_z": 4}, 1e-2)
    found = lissom.simulate(rod, 0.5, method="auto", rtol=1e-3, dt=STEP)
    right = lissom.simulate(lissom.Rod([twisting], bodies=[aside]), 0.5, method="radau", rtol=1e-6, dt=STEP)
    true = distance(rod, found, right, right.model)
    assert true > 1e-2
    assert true < found.stats.space_error < 5 * true


def test_an_unknown_space_error_is_no_secret():
    segment = lissom.Segment(0.3, 5e-3, 1e7, 4e6, 1e3, {"bend_y": 4}, 1e-2, basis="piecewise_constant")
    found = lissom.simulate(lissom.Rod([segment]), 0.2, method="auto", rtol=1e-2, dt=STEP)
    assert found.success
    assert found.stats.space_error is None
    assert "The space error is unknown: its bases are made of pieces" in found.message


def test_nodes_that_change_nothing_are_not_added():
    # Too few modes, with enough nodes for these.
    segment = lissom.Segment(1.0, 0.01, 5e6, 5e6 / 3, 1000.0, {"bend_y": 2}, retardation_time=1e-4)
    found = lissom.simulate(lissom.Rod([segment]), 1.0, method="auto", rtol=1e-3, dt=STEP)
    assert found.stats.space_error > 1e-3
    assert found.model.nodes == lissom.Rod([segment]).nodes


def test_runs_that_must_end_at_the_limit_of_steps_are_not_begun():
    wire = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800, modes={"bend_y": 2, "bend_z": 2})
    rod = lissom.Rod([wire], tip_force=(1e20, 0.0, 1e20))
    result = lissom.simulate(rod, 0.1, method="auto", rtol=1e-2)
    assert result.status == "too_many_steps"
    assert result.message.startswith("At least 2e11 steps are needed to resolve the motion")
    assert result.stats.nfev < 20_000  # a thousand steps of DOP853


def test_errors_of_steps_that_multiply_are_not_taken_for_those_of_nodes():
    stiffness = 7e10 * np.pi / 4 * 16e-12
    column = lissom.Segment(0.5, 2e-3, 7e10, 2.6e10, 2700, {"bend_y": 4})
    follower = lissom.Load(force=(-25 * stiffness / 0.25, 0, 0), frame="body")
    rod = lissom.Rod([column], gravity=(0, 0, 0), loads=[follower])
    result = lissom.simulate(rod, 0.3, q0=[1e-4, 0, 0, 0], method="auto", rtol=1e-2)
    assert result.success
    assert result.model.nodes == rod.nodes


@pytest.mark.parametrize("links", [1, 2])
def test_joints_do_not_hide_what_rods_lack(links):
    """Coordinates of joints lie between those of modes; a copy beside a rod does not change its error."""
    modes = {"bend_y": 3, "shear_z": 1}
    segment = lissom.Segment(
        0.2, 0.01, 3e5, poisson_ratio=0.5, density=1000, modes=modes, retardation_time=0.01
    )

    def error(joint):
        robot = lissom.Robot([lissom.Link(f"arm{i}", rod=[segment], joint=joint) for i in range(links)])
        motion = lissom.simulate(robot, 0.05, method="auto", rtol=1e-2)
        assert motion.success, motion.message
        return motion.stats.space_error

    welded = error(lissom.Weld())
    assert 1e-3 < welded < 1e-2
    assert 0.5 * welded < error(lissom.Revolute((0, 1, 0), stiffness=1.0)) < 2 * welded


@pytest.mark.parametrize("width", [1e-3, 4e-6, 1e-7])
@pytest.mark.parametrize("edge", [0.0, 1e-10])
def test_short_pulses_of_tables_are_followed(width, edge):
    """Steps end at both ends of a pulse, so that few are needed. A spring-mass of 2 rad/s, impulse 1."""
    edge = max(edge, np.spacing(0.2))
    times = [0.1, 0.1 + edge, 0.1 + width, 0.1 + width + edge]
    load = lissom.Load(force=(times, np.outer([0, 1 / width, 1 / width, 0], (1, 0, 0))), link="weight")
    weight = lissom.Link("weight", joint=lissom.Prismatic((1, 0, 0), stiffness=4.0), body=lissom.Body(1.0))
    run = lissom.simulate(lissom.Robot([weight], gravity=(0, 0, 0), loads=[load]), 1.0, method="auto")
    assert run.success, run.message
    assert run.stats.steps < 10_000
    assert run.q[-1, 0] == pytest.approx(0.5 * np.sin(2 * (0.9 - 0.5 * (width + edge))), abs=2e-3)


@pytest.mark.parametrize("beyond", [-1e-6, 0.0, 1e-3, 1.0])
def test_a_start_near_a_full_turn_is_one_of_the_same_motion(beyond):
    """Rates of rotation vectors are singular at a full turn; the motion is not."""
    body = lissom.Body(1.0, centre=(0.1, 0.2, 0.05), inertia=(0.05,) * 3)
    robot = lissom.Robot([lissom.Link("top", joint=lissom.Spherical(), body=body)])
    length = 2 * np.pi + beyond
    motion = lissom.simulate(robot, 0.5, method="auto", q0=[length, 0, 0], v0=[0.1, 0, 0])
    wrapped = lissom.simulate(robot, 0.5, method="dop853", rtol=1e-9, q0=[beyond, 0, 0], v0=[0.1, 0, 0])
    assert motion.success, motion.message
    places = [robot.pose(q, link="top") for q in (motion.q[-1], wrapped.q[-1])]
    np.testing.assert_allclose(places[0], places[1], atol=1e-4)


@pytest.mark.parametrize("unit", [1e-9, 1e-6, 1e3])
@pytest.mark.parametrize("kind", ["ball", "bead", "drawn", "relaxed", "hung", "stopped"])
def test_accuracy_does_not_depend_on_the_unit_of_what_reaches_nowhere(kind, unit):
    """A ball that shakes, a bead on a rope or drawn by a tension, and masses on springs, in two units."""

    def run(unit):
        more = {"relaxed": {"rest": 0.5 * unit}, "stopped": {"limits": (-unit, unit), "limit_stiffness": 1e3}}
        joint = lissom.Prismatic((1, 0, 0), stiffness=30.0, damping=3.0, **more.get(kind, {}))
        inertia = (0.1 * unit**2,) * 3 if kind == "ball" else (0.0,) * 3
        path = [lissom.Via(None, (-unit, 0, 0)), lissom.Via("it", (0, 0, 0))]
        ropes = {
            "bead": lissom.Tendon("rope", path, length=3.0 * unit, stiffness=1.0),
            "drawn": lissom.Tendon("rope", path, tension=2.0 * unit),
        }
        link = lissom.Link("it", joint=joint, body=lissom.Body(1.0, inertia=inertia))
        ropes = [ropes[kind]] if kind in ropes else []
        gravity = (9.81 * unit if kind == "hung" else 0, 0, 0)
        robot = lissom.Robot([link], gravity=gravity, actuators=ropes)
        return lissom.simulate(robot, 1.0, method="auto", rtol=1e-6, q0=[0.3 * unit], v0=[0.2 * unit])

    one, other = run(1.0), run(unit)
    assert other.success
    assert other.stats.steps == one.stats.steps
    np.testing.assert_allclose(other.q[-1] / unit, one.q[-1], rtol=1e-9)


def jumping_rod(jump, as_table=False):
    """A soft rod whose load jumps, as a function of time or as a table with an edge of one spacing."""
    force = np.array([0.0, 0.0, 0.3])
    table = ([jump, np.nextafter(jump, 1.0)], [np.zeros(3), force])
    load = lissom.Load(force=table if as_table else lambda t: force if t >= jump else np.zeros(3))
    segment = lissom.Segment(0.5, 0.01, 1e7, 4e6, 1100.0, {"bend_y": 2}, retardation_time=0.01)
    return lissom.Rod([segment], loads=[load])


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
def test_a_function_that_jumps_limits_no_steps_elsewhere(tolerance):
    jump = 0.3**0.5
    found, known = (
        lissom.simulate(jumping_rod(jump, as_table), 2.0, method="auto", rtol=tolerance, dt=STEP)
        for as_table in (False, True)
    )
    assert found.success
    assert found.stats.steps < known.stats.steps + 20
    exact = lissom.simulate(jumping_rod(jump, as_table=True), 2.0, method="radau", rtol=1e-9, dt=STEP)
    assert distance(found.model, found, exact) < tolerance


@pytest.mark.parametrize("jump", [0.3, 0.3**0.5, 1.7])
def test_steps_after_a_jump_do_not_extrapolate_it(jump):
    """The step over a jump is as short as its place is uncertain: it tells nothing about a usual one."""
    found = lissom.simulate(jumping_rod(jump), 2.0, method="auto", rtol=1e-2, dt=STEP)
    assert found.success
    assert found.stats.unsolved == 0


def test_a_model_keeps_no_ends_of_steps():
    """Those beside jumps are of one request, also where a model with more nodes is returned."""
    rod = jumping_rod(0.3)
    before = lissom.simulate(rod, 2.0, method="radau", rtol=1e-3)
    lissom.simulate(rod, 2.0, method="auto", rtol=1e-3, dt=STEP)
    after = lissom.simulate(rod, 2.0, method="radau", rtol=1e-3)
    np.testing.assert_array_equal(before.t, after.t)


def rubbing_chain():
    """Two heavy links whose dry friction stops them."""
    joint = lissom.Revolute((0, 1, 0), friction=1.0, friction_velocity=1e-3)
    body = lissom.Body(1.0, centre=(0.15, 0, 0), inertia=np.diag([1e-3, 8e-3, 8e-3]))
    links = [
        lissom.Link("upper", joint=joint, body=body),
        lissom.Link("lower", parent="upper", position=(0.3, 0, 0), joint=joint, body=body),
    ]
    return lissom.Robot(links), [0.6, 0.4]


def test_loose_tolerances_do_not_make_dry_friction_costly():
    robot, q0 = rubbing_chain()
    times = np.linspace(0.0, 0.8, 101)
    tight, loose = (
        lissom.simulate(
            robot, 0.8, q0=q0, method="radau", rtol=1e-2 * tolerance, atol=tolerance, t_eval=times
        )
        for tolerance in (1e-4, 1e-2)
    )
    assert loose.success
    assert loose.stats.steps < tight.stats.steps


def test_a_pendulum_that_comes_to_a_stiff_stop_goes_on_with_implicit_steps():
    """Nothing is stiff before it reaches the stop of its hinge."""
    body = lissom.Body(1.0, centre=(0.15, 0, 0), inertia=np.diag([1e-3, 8e-3, 8e-3]))
    hinge = lissom.Revolute((0, 0, 1), limits=(-0.5, 0.5), limit_stiffness=1e6, limit_dissipation=0.5)
    robot = lissom.Robot([lissom.Link("arm", joint=hinge, body=body)], gravity=(0, -9.81, 0))
    found = lissom.simulate(robot, 2.0, q0=[-0.3], method="auto", rtol=1e-2)
    assert found.success
    assert "radau, because explicit steps became short" in found.message
    exact = lissom.simulate(robot, 2.0, q0=[-0.3], method="radau", rtol=1e-9, atol=1e-11, t_eval=found.t)
    # The centre of mass is 0.15 m from the hinge, which is the length.
    assert np.abs(found.q - exact.q).max() < 1e-2


def test_a_ball_in_the_air_is_followed_on_the_stiff_floor():
    """Nothing is stiff before it lands; then it takes 7000 explicit steps, or a tenth of that by Radau."""
    body = lissom.Body(0.1, inertia=2e-5 * np.eye(3))
    floor = lissom.Contact(lissom.Ball("ball", 0.02), lissom.HalfSpace(), stiffness=1e4, friction=0.3)
    robot = lissom.Robot([lissom.Link("ball", joint=lissom.Free(), body=body)], contacts=[floor])
    q0, v0 = [0, 0, 0.05, 0, 0, 0], [0.5, 0, 0, 0, 0, 0]
    found = lissom.simulate(robot, 1.0, q0=q0, v0=v0, method="auto", rtol=1e-2)
    assert found.success
    assert "radau, because contacts are stiff" in found.message
    assert found.stats.steps < 2000
    exact = lissom.simulate(robot, 1.0, q0=q0, v0=v0, method="radau", rtol=1e-9, atol=1e-11, t_eval=found.t)
    assert np.linalg.norm(found.q[:, :3] - exact.q[:, :3], axis=1).max() < 1e-2 * 0.02
