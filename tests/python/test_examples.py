"""The examples and the README's code run as they stand."""

import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples" / "python").glob("*.py"))
#: What an example takes that tests do not, and how it is run in less time.
NEEDS = {"train_reach": "stable_baselines3"}
SHORT = {"train_reach": ["--steps", "2048", "--envs", "8"]}


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs(example, tmp_path):
    if example.stem in NEEDS:
        pytest.importorskip(NEEDS[example.stem])
    command = [sys.executable, "-W", "error", example, *SHORT.get(example.stem, [])]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip()


def test_sagging_wire_converges():
    example = runpy.run_path(str(ROOT / "examples" / "python" / "sagging_wire.py"))
    rod = example["wire"](7)
    tip = rod.pose(example["equilibrium"](rod), rod.length)[[0, 2], 3]
    assert abs(tip - example["EXACT_TIP"]).max() < 1e-9


def test_finger_holds_its_target_with_the_holding_tension_alone():
    example = runpy.run_path(str(ROOT / "examples" / "python" / "finger_pd.py"))
    target = example["TARGET"]
    errors = [abs(example["run"](hold)[1][-20:] - target).max() for hold in (0.0, example["holding"]())]
    assert errors[0] > 1e-3
    assert errors[1] < 1e-5


def test_regulator_catches_a_pole_that_falls_without_it():
    example = runpy.run_path(str(ROOT / "examples" / "python" / "cart_pole_lqr.py"))
    feedback = example["gains"]()
    assert example["is_caught"](feedback, 0.5, 0.5)
    assert not example["is_caught"](feedback, 1.4, 0.0)
    assert not example["is_caught"](0.0 * feedback, 0.05, 0.0)


def test_tendon_robot_is_as_exact_as_documented():
    """From every sixth row, without friction; docs/tendon_robot.md has all of it."""
    example = runpy.run_path(str(ROOT / "examples" / "python" / "tendon_robot.py"))
    training, validation = example["recordings"]()
    assert (len(training), len(validation)) == (1620, 443)
    model = example["Model"](example["angles_of_pulls"](training), example["WITHOUT"]["friction"])
    x = example["identify"](model, training[::6])
    assert example["error"](model, x, training) < 4.8e-3
    assert example["error"](model, x, validation) < 8.2e-3


def test_derivatives_of_the_tendon_robot_are_exact():
    """One Newton step against differences of equilibria."""
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
