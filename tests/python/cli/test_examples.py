"""The examples and the code of the README run unchanged."""

import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

ROOT = Path(__file__).parents[3]
EXAMPLES = sorted((ROOT / "examples" / "python").glob("*.py"))
#: Packages that examples need in addition, and arguments for shorter runs.
NEEDS = {"train_reach": "stable_baselines3", "gait_search": "cma"}
SHORT = {
    "gait_search": ["--time", "0.5", "--evaluations", "40"],
    "swing_up": ["--time", "1.2", "--controls", "12", "--torque", "0.4"],
    "far_taper": ["--segments", "2", "--plot", "arms.png"],
    "train_reach": ["--steps", "2048", "--envs", "8"],
    "crawling_snake": ["--time", "0.5"],
    "overhand_knot": ["--time", "0.02"],
    "plectoneme": ["--levels", "1.7", "--dt", "5e-3"],
    "tendon_robot_fit": ["--every", "160", "--runs", "5"],
}


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs(example, tmp_path):
    if example.stem in NEEDS:
        pytest.importorskip(NEEDS[example.stem])
    command = [sys.executable, "-W", "error", example, *SHORT.get(example.stem, [])]
    # Ends what hangs. The slowest takes 44 s of processor time on a slow machine, and 92 s beside other work.
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=110)
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip()


def test_sagging_wire_converges():
    example = runpy.run_path(str(ROOT / "examples" / "python" / "sagging_wire.py"))
    rod = example["wire"](7)
    tip = rod.pose(example["equilibrium"](rod), rod.length)[[0, 2], 3]
    assert abs(tip - example["EXACT_TIP"]).max() < 1e-9


def test_finger_holds_its_target_with_the_holding_tensions_alone():
    example = runpy.run_path(str(ROOT / "examples" / "python" / "finger_pd.py"))
    errors = [example["run"](hold)[1][-20:].max() for hold in (np.zeros(4), example["holding"]())]
    assert errors[0] > 1e-3
    assert errors[1] < 1e-5


@pytest.fixture
def finger_mpc(monkeypatch):
    """The example of model-predictive control, which imports the finger from its neighbour."""
    pytest.importorskip("piqp")
    monkeypatch.syspath_prepend(ROOT / "examples" / "python")
    yield runpy.run_path(str(ROOT / "examples" / "python" / "finger_mpc.py"))
    sys.modules.pop("finger_pd", None)


def test_prediction_is_what_the_simulation_does_next(finger_mpc):
    """For small motions the prediction error is of second order."""
    finger = finger_mpc["finger"]
    u = np.array([0.2, 0.5, 1.0, 0.1])
    q0 = lissom.statics(finger, u=u).q
    random = np.random.default_rng(0)
    shift, rate = random.normal(size=(2, finger.n))
    pulls = random.normal(size=(finger_mpc["STEPS"], 4))
    errors = []
    for size in (1e-2, 5e-3):
        start, speed, changes = q0 + size * shift, 10 * size * rate, size * pulls
        prediction = finger_mpc["Prediction"](start, u + changes[0])
        inputs = np.einsum("itju,ju->it", prediction.of_inputs, u + changes)
        predicted = prediction.untouched(start, speed) + inputs
        simulation = lissom.Simulation(finger, dt=2e-4, q0=start, v0=speed)
        found = []
        for change in changes:
            assert simulation.step(u + change, duration=finger_mpc["CONTROL_STEP"]) == "finished"
            found.append(finger_mpc["tip"](simulation.q))
        errors.append(np.abs(predicted - found).max())
        moved = np.abs(predicted - finger_mpc["tip"](q0)).max()
        assert errors[-1] < 0.02 * moved
    assert errors[1] < 0.3 * errors[0]


def test_predictive_control_keeps_limits_and_beats_feedback(finger_mpc):
    controllers = finger_mpc["controllers"]()
    runs = [finger_mpc["follow"](control, 0.8) for control in controllers.values()]
    largest = [run.errors.max() for run in runs]
    assert largest[0] > 3 * largest[1] > 6 * largest[2] > 60 * largest[3]
    assert largest[3] < 1e-4
    for run in runs:
        assert run.u.min() >= 0.0
        assert run.u.max() <= finger_mpc["LARGEST"]
        change = np.abs(np.diff(run.u, axis=0, prepend=0.0)).max()
        assert change <= finger_mpc["FASTEST"] * finger_mpc["CONTROL_STEP"] * (1 + 1e-12)


def test_regulator_catches_a_pole_that_falls_without_it():
    example = runpy.run_path(str(ROOT / "examples" / "python" / "cart_pole_lqr.py"))
    feedback = example["gains"]()
    assert example["is_caught"](feedback, 0.5, 0.5)
    assert not example["is_caught"](feedback, 1.4, 0.0)
    assert not example["is_caught"](0.0 * feedback, 0.05, 0.0)


@pytest.mark.slow
def test_tendon_robot_is_as_exact_as_documented():
    """Every sixth row, without friction; docs/tendon_robot.md has the complete comparison."""
    example = runpy.run_path(str(ROOT / "examples" / "python" / "tendon_robot.py"))
    training, validation = example["recordings"]()
    assert (len(training), len(validation)) == (1620, 443)
    model = example["Model"](example["angles_of_pulls"](training), example["WITHOUT"]["friction"])
    x = example["identify"](model, training[::6])
    assert example["error"](model, x, training) < 4.8e-3
    assert example["error"](model, x, validation) < 8.2e-3


@pytest.mark.slow
def test_the_second_tendon_robot_is_as_exact_as_documented():
    """Every sixth row, without friction."""
    example = runpy.run_path(str(ROOT / "examples" / "python" / "tendon_robot.py"))
    drawn = example["ROBOTS"]["v6"]
    training, validation = example["recordings"](drawn)
    assert (len(training), len(validation)) == (1019, 274)
    model = example["Model"](example["angles_of_pulls"](training), example["WITHOUT"]["friction"], drawn)
    x = example["identify"](model, training[::6])
    assert example["error"](model, x, training) < 7.3e-3
    assert example["error"](model, x, validation) < 11.2e-3


def test_derivatives_of_the_tendon_robot_are_exact():
    """One Newton step, compared with differences of equilibria."""
    example = runpy.run_path(str(ROOT / "examples" / "python" / "tendon_robot.py"))
    training, _ = example["recordings"]()
    model = example["Model"](example["angles_of_pulls"](training))
    fit = example["Fit"](model, training[150:400:50])
    x = model.start
    fit.residuals(x)
    jacobian = fit.jacobian(x)
    for k in range(0, len(x), 4):
        step = 1e-3 * model.spread[k] * np.eye(len(x))[k]
        difference = (fit.residuals(x + step) - fit.residuals(x - step)) / (2 * step[k])
        assert_allclose(jacobian[:, k], difference, rtol=0, atol=1e-3 * np.abs(difference).max())


def test_far_taper_reaches_farther_than_any_cylinder_of_its_volume():
    example = runpy.run_path(str(ROOT / "examples" / "python" / "far_taper.py"))
    reach = example["Reach"](0.01)
    cylinder, taper = (example["farthest"](reach, 2, uniform) for uniform in (True, False))
    for lengths in (cylinder, taper):
        assert_allclose(example["volume"](lengths), example["VOLUME"], rtol=1e-6)
    assert reach(taper)[0] > 1.15 * reach(cylinder)[0]
    for factor in (0.9, 1.1):
        length = factor * cylinder[0]
        radius = np.sqrt(example["VOLUME"] / (np.pi * length))
        assert reach([length, radius, radius, radius])[0] < reach(cylinder)[0]


def test_gradient_of_the_taper_is_that_of_equilibria():
    example = runpy.run_path(str(ROOT / "examples" / "python" / "far_taper.py"))
    reach = example["Reach"](0.02)
    lengths = np.array([0.3, 0.015, 0.011, 0.006])
    _, gradient = reach(lengths)
    for k, step in enumerate(1e-4 * np.diag(lengths)):
        difference = (reach(lengths + step)[0] - reach(lengths - step)[0]) / (2 * step[k])
        assert_allclose(gradient[k], difference, rtol=1e-5)
    slopes = example["slopes_of_volume"](lengths)
    for k, step in enumerate(1e-4 * np.diag(lengths)):
        difference = (example["volume"](lengths + step) - example["volume"](lengths - step)) / (2 * step[k])
        assert_allclose(slopes[k], difference, rtol=1e-7)


def test_gait_along_the_gradient_beats_as_many_runs_of_evolution():
    pytest.importorskip("cma")
    example = runpy.run_path(str(ROOT / "examples" / "python" / "gait_search.py"))
    swim = example["Swim"](1.0)
    start = np.array([5.0, 4.0, 6.0, 5.0, 0.0, -0.7, -1.3, -2.0])
    value, gradient = swim.gradient(start)
    changes = 1e-4 * np.eye(len(start))
    difference = (swim.distances(start + changes) - swim.distances(start - changes)) / 2e-4
    assert_allclose(gradient, difference, rtol=0, atol=1e-3 * np.abs(gradient).max())
    gait, by_gradient = example["along_gradient"](swim, start)
    assert_allclose(swim.distances([gait]), by_gradient[-1], rtol=1e-3)
    assert by_gradient[-1] > 1.5 * value
    _, by_chance = example["by_evolution"](swim, start, len(by_gradient), 1)
    assert len(by_chance) >= len(by_gradient)
    assert by_gradient[-1] > by_chance[-1]


def test_swing_up_ends_upright_with_the_least_effort():
    """At the minimum effort, no change of the torques that keeps the final state reduces it."""
    example = runpy.run_path(str(ROOT / "examples" / "python" / "swing_up.py"))
    shooting = example["Shooting"](1.2, 12)
    found = example["swing_up"](shooting, 0.4)
    torques = 0.4 * found.x
    assert found.success
    assert np.abs(shooting.miss(torques)).max() < 1e-4
    assert np.abs(torques).max() < 0.4
    slopes = shooting.slopes_of_miss(torques)
    along = torques - slopes.T @ np.linalg.lstsq(slopes.T, torques)[0]
    assert np.linalg.norm(along) < 0.05 * np.linalg.norm(torques)


def test_code_of_the_readme_runs(capsys):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    assert blocks
    for block in blocks:
        exec(compile(block, "README.md", "exec"), {})
    assert capsys.readouterr().out


def test_links_of_the_readme_lead_somewhere():
    targets = re.findall(r"\]\(([^)#:]+)\)", (ROOT / "README.md").read_text(encoding="utf-8"))
    assert targets
    assert [target for target in targets if not (ROOT / target).exists()] == []
