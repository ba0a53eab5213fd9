"""The validation gallery: all of it within tolerance, and honest where it is not."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipeinc, ellipkinc, jn_zeros, jv

from lissom import validation
from lissom.cli import commands
from lissom.report import validation as report
from lissom.validation import exact, table
from lissom.validation.case import Answer, Plot

DOCS = Path(__file__).parents[2] / "docs" / "validation.md"
CASES = {case.name: case for case in validation.CASES}
QUICK = ("Roll-up to a circle", "Euler column")


@pytest.fixture(scope="module")
def outcomes():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(validation.case, "MOST_REPEATS", 1)
        return validation.run_all(validation.CASES)


@pytest.fixture
def few(monkeypatch):
    """A gallery of two cases."""
    cases = tuple(CASES[name] for name in QUICK)
    monkeypatch.setattr(validation, "CASES", cases)
    return cases


def lissom_validate(*arguments):
    return commands.main(["validate", *arguments], prog_name="lissom", standalone_mode=False)


@pytest.mark.parametrize("name", CASES)
def test_case(outcomes, name):
    outcome = next(outcome for outcome in outcomes if outcome.case.name == name)
    assert outcome.good, outcome.numbers
    assert outcome.seconds > 0
    assert outcome.plot is not None
    for curve in outcome.plot.curves:
        x, y = np.asarray(curve.x), np.asarray(curve.y)
        assert x.shape == y.shape
        assert np.isfinite(x).all()
        assert np.isfinite(y).all()


@pytest.mark.parametrize("name", CASES)
def test_tolerances_are_not_idle(outcomes, name):
    """A value that is wrong by twice the tolerance is found out."""
    outcome = next(outcome for outcome in outcomes if outcome.case.name == name)
    scale = outcome.case.scale or np.abs(outcome.wanted).max()
    wrong = outcome.wanted + 2 * outcome.case.tolerance * scale
    answer = Answer(outcome.found, lambda: outcome.plot)
    spoiled = replace(outcome.case, wanted=lambda: wrong, scale=scale, solve=lambda: answer)
    assert not validation.run(spoiled).good


def test_names_are_unique_and_all_are_documented():
    assert len(CASES) == len(validation.CASES)
    page = DOCS.read_text(encoding="utf-8")
    for case in validation.CASES:
        assert f"| {case.name} | {case.source}; *{case.origin}* |" in page
        assert case.setting in page
    assert f"All {len(CASES)} cases are within their tolerance." in page


class TestCommand:
    def test_good(self, few, tmp_path, capsys):
        page = tmp_path / "page.md"
        assert lissom_validate("-o", str(tmp_path / "out"), "--update-docs", str(page)) == 0
        printed = capsys.readouterr().out
        numbers = json.loads((tmp_path / "out" / "summary.json").read_text())
        assert numbers["good"] is True
        assert [case["case"] for case in numbers["cases"]] == list(QUICK)
        assert {"wanted", "found", "error", "tolerance", "run_seconds", "source"} <= set(numbers["cases"][0])
        html = (tmp_path / "out" / "report.html").read_text()
        for case in few:
            for text in (printed, html, page.read_text()):
                assert case.name in text
        assert html.count('class="figure"') == 2
        assert "All 2 cases are within their tolerance." in page.read_text()

    def test_a_spoiled_expectation_is_exit_code_3(self, few, tmp_path, capsys, monkeypatch):
        spoiled = replace(few[0], wanted=lambda: [0.0, 0.0, 6.2])
        monkeypatch.setattr(validation, "CASES", (spoiled, few[1]))
        page = tmp_path / "page.md"
        code = lissom_validate("-o", str(tmp_path / "out"), "--no-report", "--update-docs", str(page))
        assert code == 3
        assert "1 of 2 cases are outside their tolerance: Roll-up to a circle." in capsys.readouterr().out
        assert "Roll-up to a circle **outside**" in page.read_text()
        cases = json.loads((tmp_path / "out" / "summary.json").read_text())["cases"]
        assert [case["good"] for case in cases] == [False, True]
        assert not (tmp_path / "out" / "report.html").exists()

    @pytest.mark.parametrize(
        "answer",
        [
            Answer([np.nan], lambda: Plot("", "", [])),
            Answer([1.0, 2.0], lambda: Plot("", "", [])),
            Answer([2.4674011002723395], lambda: Plot("", "", []), "the solver gave up"),
        ],
        ids=["not a number", "wrong shape", "failure"],
    )
    def test_no_answer_is_not_a_good_one(self, few, tmp_path, monkeypatch, answer):
        monkeypatch.setattr(validation, "CASES", (replace(few[1], solve=lambda: answer),))
        assert lissom_validate("-o", str(tmp_path / "out")) == 3
        (case,) = json.loads((tmp_path / "out" / "summary.json").read_text())["cases"]
        assert case["error"] is None
        assert case["good"] is False

    def test_a_folder_of_others_is_refused_before_work(self, tmp_path, monkeypatch):
        monkeypatch.setattr(validation, "run_all", lambda *_: pytest.fail("ran"))
        (tmp_path / "thesis.tex").write_text("x")
        with pytest.raises(Exception, match=r"thesis\.tex"):
            lissom_validate("-o", str(tmp_path))
        assert (tmp_path / "thesis.tex").read_text() == "x"


def test_the_report_has_a_section_for_each_case(outcomes):
    page = report.build(outcomes)
    assert [section.title for section in page.sections[1:]] == list(CASES)
    assert page.outcome == (table.verdict(outcomes), True)


class TestExactValues:
    """The wanted values beside SciPy."""

    def test_elliptic_integrals(self):
        for k, start in [(0.1, 0.0), (0.9, 0.3), (0.995, 0.8)]:
            first, second = exact.elliptic(k, start)
            assert first == pytest.approx(ellipkinc(np.pi / 2, k**2) - ellipkinc(start, k**2), rel=1e-12)
            assert second == pytest.approx(ellipeinc(np.pi / 2, k**2) - ellipeinc(start, k**2), rel=1e-12)

    def test_self_buckling(self):
        j = np.sqrt(exact.self_buckling() / 2.25)
        assert jv(-1 / 3, j) == pytest.approx(0, abs=1e-14)
        assert j < jn_zeros(0, 1)[0]

    def test_collocation_and_shooting_solve_the_elastica(self):
        x, deflection, angle = exact.elastica(5.0)
        shape = exact.planar_rod(1.0, np.ones_like, force=(0.0, -5.0))
        np.testing.assert_allclose(
            [shape.x[-1], -shape.z[-1], -shape.angle[-1]], [x, deflection, angle], atol=1e-11
        )
        forces = tuple((0.0, 0.0, -force) for force in (1.0, 2.5, 5.0))
        line = exact.space_rod(1.0, (1.0,) * 3 + (1e9,) * 3, (0.0, 0.0, 0.0), forces)[-1]
        np.testing.assert_allclose(line[-1], [x, 0.0, -deflection], atol=1e-7)

    def test_follower_force(self):
        """From the tip inwards the force is known: an initial value problem."""
        EI, EA, GA, length, force = 3.5e7, 4.2e8, 1.61538e8, 100.0, 60e3

        def rate(s, y):
            angle, bend, _, _ = y
            along, across = force * np.sin(angle), force * np.cos(angle)
            stretch, shear = 1 + along / EA, across / GA
            dx = stretch * np.cos(angle) - shear * np.sin(angle)
            dz = stretch * np.sin(angle) + shear * np.cos(angle)
            return [-bend / EI, dx * force, -dx, -dz]

        end = solve_ivp(rate, (0, length), [0, 0, 0, 0], rtol=1e-11, atol=1e-8, method="DOP853").y[:, -1]
        # Seen from the base: turned by its angle.
        cos, sin = np.cos(-end[0]), np.sin(-end[0])
        x, z = -end[2], -end[3]
        shape = exact.planar_rod(length, lambda X: EI + 0 * X, force=(0.0, force), follows=True, EA=EA, GA=GA)
        np.testing.assert_allclose(
            [shape.x[-1], shape.z[-1], shape.angle[-1]],
            [x * cos - z * sin, x * sin + z * cos, -end[0]],
            rtol=1e-8,
        )

    def test_newton_that_does_not_converge_says_so(self):
        with pytest.raises(ArithmeticError, match="has not converged"):
            exact.newton(lambda x: x**2 + 1, np.array([0.7]))
