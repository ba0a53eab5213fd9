"""The lab's experiments with shortened run times but the same results."""

import json
import math
import sys
import warnings
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from tqdm import tqdm

from lissom import cli
from lissom.cli.evidence import lab
from lissom.cli.evidence.lab import part, pendulum, rod, roots
from lissom.cli.evidence.lab.setup import LABS, Setup
from lissom.cli.lab import command
from lissom.drawing.report.page import Figure

NOTEBOOK = Path(__file__).parents[3] / "docs" / "notebooks" / "6-the-lab.ipynb"


@pytest.fixture(scope="module")
def quick():
    """Table 1 over 20 s instead of 1000 s, and single time measurements."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pendulum, "LONG", 20.0)
        patch.setattr(part, "MOST_REPEATS", 1)
        yield


@pytest.fixture(scope="module")
def parts(quick):
    """All parts."""
    return {name: compute(LABS) for name, compute in lab.PARTS.items()}


def test_all_figures_and_tables_are_there(parts):
    titles = [section.title.split(":")[0] for section in lab.build(list(parts.values())).sections]
    figures = [f"Figure {i}" for i in range(1, 10)]
    assert sorted(titles) == sorted([*figures, "Table 1", "Table 2", "Table 3"])
    assert [title for title in titles if title in figures] == figures


def test_each_curve_of_figure_1_has_a_sign_of_its_own(parts):
    curves = [
        curve
        for section in parts["roots"].sections[:1]
        for figure in section.parts
        if isinstance(figure, Figure)
        for curve in figure.figure.curves
    ]
    signs = [
        (curve.colour, curve.style if curve.joined else (curve.mark or "disc"))
        for curve in curves
        if curve.name
    ]
    assert len(signs) == 9
    assert len(set(signs)) == len(signs)


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
    monkeypatch.setattr(lab, "PARTS", {name: (lambda setup, done=done: done) for name, done in parts.items()})

    def bar(total, what, unit):
        return tqdm(total=total, desc=what, unit=unit, file=sys.stderr, disable=True)

    done = dict(lab.compute(bar))
    assert lab.write(done, tmp_path) == []
    numbers = (tmp_path / "summary.json").read_text()
    assert set(json.loads(numbers)) == {"lissom", "setup", "roots", "pendulum", "rod"}
    assert "Infinity" not in numbers, "the report's infinite run time is no JSON"
    assert (tmp_path / "lab.html").stat().st_size < 8e6


# Parameters of its students


def test_other_parameters_are_used_and_the_reports_run_times_left_out(quick):
    setup = Setup(start=(3.0, -2.0), dt=4e-3, mass=2.0, angle=0.1, density=3900.0)
    parts = {name: compute(setup) for name, compute in lab.PARTS.items()}
    assert {search["start"] for search in parts["roots"].numbers["searches"]} == {3.0, -2.0}
    rows = parts["pendulum"].numbers["table_1"]
    assert [(row["step"], row["report_seconds"]) for row in rows] == [(1.0, None)] * 2 + [(4e-3, None)] * 2
    numbers = parts["rod"].numbers
    assert all(row["report_seconds"] is None for row in numbers["table_2"] + numbers["table_3"])
    # Half the weight of the same stiffness: about half the bending, which is far from small.
    assert 0.5 < numbers["equilibrium"][1] / -0.3585635333 < 0.7
    # The error of Newmark's method is of order two: from 0.01 s, 6.3e-3 m.
    assert numbers["tip_error_by_step"]["0.004"] < 3e-3
    text = lab.page.render(lab.build(list(parts.values()), setup))
    assert "mass 2 kg (report: 1 kg)" in text
    assert "independent" not in text


def test_another_step_alone_leaves_the_reports_time_of_the_long_step(quick):
    rows = rod.part(Setup(dt=5e-3)).numbers["table_3"]
    assert [row["report_seconds"] for row in rows] == [1.6964, None]


def test_stiffer_wires_are_stiffer_in_shear_too():
    """The modulus of shear alone would not be one of a material."""
    assert rod.lab_rod("horizontal", Setup(young_modulus=1e12)).segments[0].poisson_ratio == pytest.approx(
        0.3125
    )


def test_a_run_that_fails_has_no_error(quick):
    """A wire of rubber turns by too much in a second."""
    numbers = rod.part(Setup(young_modulus=1e9)).numbers
    assert numbers["tip_error_by_step"]["1.0"] is None
    assert numbers["table_3"][0]["success"] is False


def words_of(sections):
    """Lessons and captions of a part."""
    parts = [each for section in sections for each in section.parts]
    return " ".join(getattr(each, "text", "") or getattr(each, "caption", "") or "" for each in parts)


def test_a_reference_that_stops_leaves_no_error(quick):
    """A wire with a radius of a metre: the explicit method stops at once."""
    found = rod.part(Setup(radius=1.0))
    assert set(found.numbers["tip_error_by_step"].values()) == {None}
    assert all(run["tip_error"] is None for run in found.numbers["table_3"])
    words = words_of(found.sections)
    assert "tolerance of 1e-10. It stopped at 0" in words
    assert "method finishes" not in words
    assert "see table 2" in words
    assert "the wire is heavy" in words
    assert "its error is not known. The reference stopped at 0" in words


def test_a_run_that_stops_has_no_ratio(quick):
    """An elongation with which the implicit method does not reach the end."""
    found = pendulum.part(Setup(angle=1.0195, elongation=2.0))
    stopped = [run for run in found.numbers["table_1"][2:] if not run["success"]]
    assert stopped, "choose a start with which it stops"
    words = words_of(found.sections)
    assert "a run stopped before its end, and there is no such ratio" in words
    assert "times as long." not in words
    assert "stopped at" in words


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--dt", "2"], "--dt: expected 0.0001 s or more, and less than the long step of 1 s"),
        (["--start", "nan"], "--start: expected numbers from -1e+06 to 1e+06, got nan"),
        (["--start", "1", "--start", "1"], "--start: expected one to 7 different numbers, got 1, 1"),
        (["--start", "1,1"], "--start: expected one to 7 different numbers, got 1, 1"),
        (["--start", "6;1"], "'6;1' is no number: write `--start 6 --start 1`, or `--start 6,1`"),
        (["--mass", "0"], "--mass: expected a positive number, got 0"),
        (
            ["--mass", "1e-9"],
            "--mass: expected 2.5e-06 kg or more, got 1e-09 kg: the spring oscillates at 1e+05 rad/s",
        ),
        (["--stiffness", "1e10"], "--stiffness: expected 4e+06 N/m or less, got 1e+10 N/m: the spring"),
        (["--young-modulus", "inf"], "--young-modulus: expected a positive number, got inf"),
        (
            ["--angle", "45"],
            "--angle: expected radians from -2 pi to 2 pi, got 45; 45 degrees are 0.7854 rad",
        ),
        (["--elongation", "-1"], "--elongation: expected more than -1 m"),
        (["--retardation-time", "-1"], "--retardation-time: expected zero or more, got -1"),
    ],
)
def test_bad_parameters_are_refused(arguments, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        cli.main(["lab", *arguments])
    assert ended.value.code == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_starts_are_given_with_commas_or_one_by_one():
    given = command.make_context("lab", ["--start", "0.5,2", "--start", "-3"]).params["start"]
    assert given == ((0.5, 2.0), (-3.0,))


@pytest.fixture(scope="module")
def notebook():
    """What the cells of the notebook leave behind."""
    cells = [cell for cell in json.loads(NOTEBOOK.read_text())["cells"] if cell["cell_type"] == "code"]
    names = {}
    with warnings.catch_warnings(), matplotlib.rc_context():
        matplotlib.use("agg")
        for cell in cells:
            # Each figure of the notebook is one of its own, as where cells are shown.
            exec("".join(cell["source"]), names)
            matplotlib.pyplot.close("all")
    return names


def test_the_notebook_has_the_numbers_of_the_page(notebook, parts):
    rods = parts["rod"].numbers
    np.testing.assert_allclose(notebook["rest"].q, rods["equilibrium"], rtol=1e-12)
    errors = {str(step): error for step, error in notebook["tip_errors"].items()}
    assert errors == pytest.approx(rods["tip_error_by_step"], rel=1e-9)
    assert np.ptp(notebook["wrong"]) == pytest.approx(parts["pendulum"].numbers["energy_change_report"])
    condition = np.linalg.cond(notebook["masses"])
    assert [condition.min(), condition.max()] == pytest.approx(rods["mass_condition"])
    found = [(s.nit, s.status) for s in notebook["searches"].values()]
    page = parts["roots"].numbers["searches"]
    assert found == [(search["iterations"], search["status"]) for search in page]


def test_the_notebook_has_every_figure_and_table():
    text = NOTEBOOK.read_text()
    assert all(f"**Figure {i}.**" in text for i in range(1, 10))
    assert "**Table 1.**" in text
    assert "**Tables 2 and 3.**" in text
