"""The 69 starts of the robustness table: required successes and failures; the status is always correct.

Every start that is not named below must be solved. Starts named with None depend on rounding errors, so that
neither outcome is asserted.
"""

import json

import numpy as np
import pytest

import lissom
import robustness
from problems.roots import FACTORS, PROBLEMS

EXPECTED = {
    "newton": {
        (1, 1): None,
        (1, 10): None,
        (1, 100): None,
        (3, 100): None,
        (7, 1): None,
        (7, 10): None,
        (7, 100): None,
        (11, 10): None,
        (11, 100): None,
        (18, 10): "diverged",
        (18, 100): "diverged",
        (21, 1): None,
        (21, 100): None,
        (22, 10): None,
        (22, 100): None,
    },
    "line_search": {
        (1, 10): "line_search_failed",
        (1, 100): "line_search_failed",
        (3, 100): None,
        (4, 100): None,
        (7, 10): None,
        (7, 100): None,
        (11, 10): None,
        (11, 100): None,
        (21, 1): "line_search_failed",
        (21, 10): "line_search_failed",
        (21, 100): "line_search_failed",
        (22, 10): None,
        (22, 100): None,
    },
    "trust_region": {
        (3, 100): "iteration_limit",
        (7, 10): None,
        (7, 100): None,
        (21, 1): "stationary_point",
        (21, 10): "stationary_point",
        (21, 100): "stationary_point",
        (22, 10): None,
        (22, 100): "iteration_limit",
    },
}


@pytest.mark.parametrize("jacobian", robustness.JACOBIANS)
@pytest.mark.parametrize("method", robustness.METHODS)
def test_every_start(method, jacobian):
    surprises = []
    for number, problem in enumerate(PROBLEMS, 1):
        for factor in FACTORS:
            outcome = robustness.solve(problem, factor, method, jacobian)
            lie = outcome["success"] and not robustness.solved(outcome)
            missed = robustness.solved(outcome) and not outcome["success"]
            if lie or missed:
                surprises.append((problem.name, factor, "lie", outcome))
            expected = EXPECTED[method].get((number, factor), "solved")
            found = "solved" if outcome["success"] else outcome["status"]
            if expected is not None and found != expected:
                surprises.append((problem.name, factor, expected, outcome))
    assert surprises == []


def test_the_stationary_points_are_minima_that_are_no_roots():
    problem = PROBLEMS[20]
    result = lissom.root(problem.fun, problem.standard_start, jac=problem.jac, method="trust_region")
    gradient = problem.jac(result.x).T @ result.fun
    assert np.abs(gradient).max() < 1e-2 * np.linalg.norm(result.fun)
    # The well-known one: (11.41..., -0.8968...), with a sum of squares of 48.98...
    assert result.x == pytest.approx([11.4128, -0.8968], abs=1e-3)
    assert result.residual_norm**2 == pytest.approx(48.9842, abs=1e-3)


def test_the_committed_table_is_this_table():
    """The generated files have the same solvers and starts; SciPy does not outperform the trust region."""
    table = json.loads((robustness.DOCS / "robustness.json").read_text())
    solved = {solver: sum(map(robustness.solved, outcomes.values())) for solver, outcomes in table.items()}
    assert len(solved) == len(robustness.METHODS) * len(robustness.JACOBIANS) + len(robustness.SCIPY)
    assert {len(outcomes) for outcomes in table.values()} == {len(PROBLEMS) * len(FACTORS)}
    lenient = {
        solver: sum(robustness.solved(outcome, 1e-4) for outcome in outcomes.values())
        for solver, outcomes in table.items()
    }
    for jacobian in robustness.JACOBIANS:
        ours = f"lissom trust_region, {jacobian}"
        assert all(solved[ours] >= solved[other] for other in solved if other.startswith("SciPy"))
        assert all(lenient[ours] >= lenient[other] for other in lenient if other.startswith("SciPy"))
    summary = (robustness.DOCS / "robustness.md").read_text()
    for solver, count in solved.items():
        assert f"| {solver} | {count} | {lenient[solver]} |" in summary
