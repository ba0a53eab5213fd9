"""The lab's experiments with shortened run times but the same results."""

import json
import math
import sys

import numpy as np
import pytest
from tqdm import tqdm

from lissom.cli.evidence import lab
from lissom.cli.evidence.lab import part, pendulum, rod, roots


@pytest.fixture(scope="module")
def parts():
    """All parts, with table 1 over 20 s instead of 1000 s, and single time measurements."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pendulum, "LONG", 20.0)
        patch.setattr(part, "MOST_REPEATS", 1)
        yield {name: compute() for name, compute in lab.PARTS.items()}


def test_all_figures_and_tables_are_there(parts):
    titles = [section.title.split(":")[0] for section in lab.build(list(parts.values())).sections]
    figures = [f"Figure {i}" for i in range(1, 10)]
    assert sorted(titles) == sorted([*figures, "Table 1", "Table 2", "Table 3"])
    assert [title for title in titles if title in figures] == figures


def test_double_roots_converge_linearly_and_the_maximum_is_no_root(parts):
    searches = {(s["function"], s["start"], s["jacobian"]): s for s in parts["roots"].numbers["searches"]}
    assert len(searches) == 18
    for jacobian in roots.JACOBIANS:
        assert searches["f", 1.0, jacobian]["status"] == "stationary_point"
        double = searches["f", 6.0, jacobian]
        assert double["x"] == pytest.approx(1.0 + math.sqrt(0.5), abs=1e-3)
        residuals = np.array(double["residuals"][-6:])
        np.testing.assert_allclose(
            residuals[1:] / residuals[:-1], 0.25, rtol=0.05, err_msg="the error halves"
        )
        assert searches["f₂", 6.0, jacobian]["x"] == pytest.approx(2.0, abs=1e-8)
    assert parts["roots"].numbers["lab_loop_iterations_from_1"] == 1000


def test_difference_errors_are_smallest_at_the_known_steps(parts):
    errors = parts["roots"].numbers["difference_errors"]
    steps = np.array(errors["step"])
    forward, central = (np.array(errors[kind]) for kind in ("forward", "central"))
    assert 1e-9 < steps[forward.argmin()] < 1e-6
    assert 1e-7 < steps[central.argmin()] < 1e-3
    assert central.min() < 1e-9 < forward.min() < 1e-7


def test_the_reports_kinetic_energy_does_not_keep_the_total(parts):
    numbers = parts["pendulum"].numbers
    assert numbers["energy_change_report"] > 1.0
    assert numbers["energy_change_right"] < 1e-8
    assert numbers["implicit_error_20_s"] < 0.02


def test_run_times_stand_beside_the_reports(parts):
    pendulum_rows = parts["pendulum"].numbers["table_1"]
    assert [(run["step"], run["method"], run["report_seconds"]) for run in pendulum_rows] == [
        (1.0, "implicit", 0.2586),
        (1.0, "explicit", 0.24964),
        (0.01, "implicit", 98.0278),
        (0.01, "explicit", 0.79022),
    ]
    table_2 = parts["rod"].numbers["table_2"]
    assert len(table_2) == 8
    assert all(run["success"] for run in table_2), "the explicit method finishes, too"
    assert {(run["base"], run["report_seconds"]) for run in table_2} == {
        ("hanging", 5.8227),
        ("hanging", 5.6295),
        ("horizontal", 46.239),
        ("horizontal", math.inf),
    }
    table_3 = parts["rod"].numbers["table_3"]
    assert [(run["step"], run["report_seconds"]) for run in table_3] == [(1.0, 1.6964), (0.01, 43.054)]


def test_the_rod_does_what_it_is_known_to_do(parts):
    numbers = parts["rod"].numbers
    np.testing.assert_allclose(numbers["equilibrium"], [0.238212308, -0.3585635333, 0.1214608904], rtol=1e-8)
    assert numbers["hanging_tip_motion"] < 1e-6
    low, high = numbers["mass_condition"]
    assert 1e3 < low < high < 1e4
    assert 1e-15 < numbers["mass_determinant"][0] < 1e-12
    errors = numbers["tip_error_by_step"]
    assert errors["0.01"] == pytest.approx(6.3e-3, rel=0.2)
    assert errors["0.001"] == pytest.approx(1.06e-4, rel=0.3)


def test_the_tip_is_where_others_computed_it(parts):
    section = next(s for s in parts["rod"].sections if s.title.startswith("Figure 8"))
    table = section.parts[1]
    assert len(table.rows) == len(rod.INDEPENDENT_TIPS)
    assert all(float(row[-1]) < 1e-6 for row in table.rows)


def test_the_folder_is_written(parts, tmp_path, monkeypatch):
    monkeypatch.setattr(lab, "PARTS", {name: (lambda done=done: done) for name, done in parts.items()})

    def bar(total, what, unit):
        return tqdm(total=total, desc=what, unit=unit, file=sys.stderr, disable=True)

    done = dict(lab.compute(bar))
    assert lab.write(done, tmp_path) == []
    numbers = (tmp_path / "summary.json").read_text()
    assert set(json.loads(numbers)) == {"lissom", "roots", "pendulum", "rod"}
    assert "Infinity" not in numbers, "the report's infinite run time is no JSON"
    assert (tmp_path / "lab.html").stat().st_size < 8e6
