"""The validation gallery: all cases are within tolerance, and failures are reported."""

import json
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.special import ellipeinc, ellipkinc, jn_zeros, jv

from lissom.cli import commands
from lissom.cli.evidence import validation
from lissom.cli.evidence.validation import contacts, exact, peers, table
from lissom.cli.evidence.validation import pages as report
from lissom.cli.evidence.validation.case import Answer, Package, Plot

DOCS = Path(__file__).parents[3] / "docs" / "validation.md"
CASES = {case.name: case for case in validation.CASES}
QUICK = ("Roll-up to a circle", "Euler column")
#: PyElastica is not a dependency of the tests; if it is installed, its cases are included.
#: Cases that take some seconds each.
LONG = frozenset(case.name for case in contacts.CASES)
HERE = [
    pytest.param(case.name, marks=[pytest.mark.slow] * (case.name in LONG))
    for case in validation.CASES
    if case.needs is None or not case.needs.missing
]
NOWHERE = Package("Nowhere", module="a_module_that_is_nowhere", install="pip install nowhere")


@pytest.fixture(scope="module")
def outcome_of():
    """The outcome of a case, which runs once."""

    @cache
    def found(name):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(validation.case, "MOST_REPEATS", 1)
            return validation.run(CASES[name])

    return found


@pytest.fixture(scope="module")
def outcomes(outcome_of):
    """Of all cases that do not take long."""
    return [outcome_of(name) for name in CASES if name not in LONG]


@pytest.fixture
def few(monkeypatch):
    """A gallery of two cases."""
    cases = tuple(CASES[name] for name in QUICK)
    monkeypatch.setattr(validation, "CASES", cases)
    return cases


def lissom_validate(*arguments):
    return commands.main(["validate", *arguments], prog_name="lissom", standalone_mode=False)


@pytest.mark.parametrize("name", HERE)
def test_case(outcome_of, name):
    outcome = outcome_of(name)
    assert outcome.good, outcome.numbers
    assert outcome.seconds > 0
    assert outcome.plot is not None
    for curve in outcome.plot.curves:
        x, y = np.asarray(curve.x), np.asarray(curve.y)
        assert x.shape == y.shape
        assert np.isfinite(x).all()
        assert np.isfinite(y).all()


@pytest.mark.parametrize("name", HERE)
def test_tolerances_are_not_idle(outcome_of, name):
    """A value with an error of twice the tolerance is detected."""
    outcome = outcome_of(name)
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
    rows = [line for line in page.splitlines() if line.startswith("| ") and not line.startswith("| case")]
    left_out = sum("not run: " in row for row in rows)
    assert len(rows) == len(CASES)
    assert f"All {len(CASES) - left_out} cases are within their tolerance." in page
    assert left_out <= len(peers.CASES)


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

    def test_what_is_not_installed_is_left_out_and_named(self, few, tmp_path, capsys, monkeypatch):
        unasked = replace(few[1], name="Beside another", needs=NOWHERE, solve=lambda: pytest.fail("ran"))
        monkeypatch.setattr(validation, "CASES", (few[0], unasked))
        page = tmp_path / "page.md"
        assert lissom_validate("-o", str(tmp_path / "out"), "--update-docs", str(page)) == 0
        reason = "not run: Nowhere is not installed (pip install nowhere)"
        printed = capsys.readouterr().out
        assert any(
            line.startswith("Beside another") and line.endswith(reason) for line in printed.splitlines()
        )
        assert "All 1 cases are within their tolerance. Not run: 1." in printed
        assert f"| – | {reason} | – |" in page.read_text()
        numbers = json.loads((tmp_path / "out" / "summary.json").read_text())
        assert numbers["good"] is True
        case = numbers["cases"][1]
        assert case["good"] is None
        assert case["run_seconds"] is None
        assert f"not run: {case['not_run']}" == reason
        html = (tmp_path / "out" / "report.html").read_text()
        assert "Not run: Nowhere is not installed (pip install nowhere)." in html
        assert html.count('class="figure"') == 1

    def test_what_is_left_out_does_not_hide_a_bad_case(self, few, tmp_path, capsys, monkeypatch):
        bad = replace(few[0], wanted=lambda: [0.0, 0.0, 6.2])
        monkeypatch.setattr(validation, "CASES", (bad, replace(few[1], needs=NOWHERE)))
        assert lissom_validate("-o", str(tmp_path / "out"), "--no-report") == 3
        assert (
            "1 of 1 cases are outside their tolerance: Roll-up to a circle. Not run: 1."
            in capsys.readouterr().out
        )

    def test_a_folder_of_others_is_refused_before_work(self, tmp_path, monkeypatch):
        monkeypatch.setattr(validation, "run_all", lambda *_: pytest.fail("ran"))
        (tmp_path / "thesis.tex").write_text("x")
        with pytest.raises(Exception, match=r"thesis\.tex"):
            lissom_validate("-o", str(tmp_path))
        assert (tmp_path / "thesis.tex").read_text() == "x"


def test_the_report_has_a_section_for_each_case(outcomes):
    page = report.build(outcomes)
    assert [section.title for section in page.sections[1:]] == [name for name in CASES if name not in LONG]
    assert page.outcome == (table.verdict(outcomes), True)


class FakeElastica:
    """The part of PyElastica that is used: a rod that falls as a whole, and a record of its arguments."""

    OneEndFixedBC = GravityForces = object

    def __init__(self):
        self.rod = SimpleNamespace(shear_matrix=np.zeros((3, 3, 10)), position_collection=np.zeros((3, 11)))
        self.made, self.used, self.steps, self.finalized = (), [], [], False
        self.CosseratRod = SimpleNamespace(straight_rod=self.straight_rod)
        self.Constraints = type("Constraints", (), {"constrain": lambda _, rod: self.using(rod)})
        self.Forcing = type("Forcing", (), {"add_forcing_to": lambda _, rod: self.using(rod)})
        self.BaseSystemCollection = type(
            "BaseSystemCollection",
            (),
            {"append": lambda *_: None, "finalize": lambda _: setattr(self, "finalized", True)},
        )

    def straight_rod(self, *made, **materials):
        self.made, self.materials = made, materials
        elements, start, direction, _, length, *_ = made
        along = np.linspace(0.0, length, elements + 1)
        self.rod.position_collection = start[:, None] + direction[:, None] * along
        return self.rod

    def using(self, rod):
        assert rod is self.rod
        return SimpleNamespace(using=lambda what, **settings: self.used.append(settings))

    def PositionVerlet(self):
        return SimpleNamespace(step=self.step)

    def step(self, simulator, now, step):
        assert self.finalized
        self.steps.append(step)
        self.rod.position_collection[2] -= step
        return now + step


@pytest.fixture(scope="module")
def tips():
    """Paths of lissom's tip by the stiffening in stretch and shear."""
    return {stiffening: peers.lissom_tips(stiffening) for stiffening in (1.0, peers.STIFFENING)}


class TestPyElastica:
    """Use of PyElastica's answers, and calls of it, without PyElastica."""

    @pytest.fixture
    def converging(self, tips, monkeypatch):
        """Elements with an error that is a power of their length."""
        monkeypatch.setattr(peers, "lissom_tips", tips.__getitem__)

        def with_order(order, gap=0.0):
            def peer_tips(elements, stiffening):
                error = 3.0 * (peers.LENGTH / (elements - 0.5)) ** order
                return tips[stiffening] + gap + error * np.sin(3.0 * peers.TIMES)[:, None] * [1.0, 0.0, -1.0]

            monkeypatch.setattr(peers, "peer_tips", peer_tips)
            return [validation.run(replace(case, needs=None)) for case in peers.CASES]

        return with_order

    def test_elements_of_second_order_are_good(self, converging):
        outcomes = converging(2)
        assert [outcome.good for outcome in outcomes] == [True] * 3
        assert outcomes[1].error < 1e-12
        assert outcomes[2].found == pytest.approx([2.0], abs=1e-10)

    @pytest.mark.parametrize("order", [1, 3])
    def test_elements_of_another_order_are_not(self, converging, order):
        *_, refined = converging(order)
        assert refined.outside
        assert refined.found == pytest.approx([order], abs=1e-10)

    def test_elements_that_go_elsewhere_are_not(self, converging):
        rubber, stiffened, refined = converging(2, gap=1e-3)
        assert [rubber.good, stiffened.good, refined.good] == [True, False, False]

    def test_what_does_not_reach_the_end_is_not_good(self, converging):
        assert not any(outcome.good for outcome in converging(2, gap=np.nan))

    @pytest.mark.parametrize("stiffening", [1.0, 100.0])
    def test_how_it_is_asked(self, monkeypatch, stiffening):
        fake = FakeElastica()
        monkeypatch.setitem(sys.modules, "elastica", fake)
        assert peers.PYELASTICA.missing == ""
        path = peers.peer_tips.__wrapped__(10, stiffening)
        elements, start, _, _, length, radius, density = fake.made
        assert elements == 10
        # The middle of the first element is at the clamp, the last node at the tip.
        assert start[0] + 0.5 * length / elements == pytest.approx(0.0, abs=1e-15)
        assert start[0] + length == pytest.approx(peers.LENGTH)
        assert (radius, density) == (peers.RADIUS, peers.DENSITY)
        assert fake.materials == {"youngs_modulus": peers.YOUNG, "shear_modulus": peers.SHEAR}
        assert fake.rod.shear_matrix[0, 0] == pytest.approx(stiffening * peers.SHEAR * peers.AREA)
        assert fake.used[0] == {"constrained_position_idx": (0,), "constrained_director_idx": (0,)}
        np.testing.assert_array_equal(fake.used[1]["acc_gravity"], [0.0, 0.0, -9.81])
        assert max(fake.steps) <= 0.45 * peers.largest_stable_step(length / elements, stiffening)
        np.testing.assert_allclose(path[:, 2], -peers.TIMES, atol=1e-12)
        np.testing.assert_allclose(path[:, 0], peers.LENGTH)

    def test_it_is_missing_where_it_is_not_installed(self):
        assert NOWHERE.missing == "Nowhere is not installed (pip install nowhere)"
        assert peers.PYELASTICA.missing in ("", "PyElastica is not installed (pip install pyelastica)")
        assert {case.needs for case in peers.CASES} == {peers.PYELASTICA}


class TestExactValues:
    """The expected values, compared with SciPy."""

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
        # In the axes of the base, rotated by its angle.
        cos, sin = np.cos(-end[0]), np.sin(-end[0])
        x, z = -end[2], -end[3]
        shape = exact.planar_rod(length, lambda X: EI + 0 * X, force=(0.0, force), follows=True, EA=EA, GA=GA)
        np.testing.assert_allclose(
            [shape.x[-1], shape.z[-1], shape.angle[-1]],
            [x * cos - z * sin, x * sin + z * cos, -end[0]],
            rtol=1e-8,
        )

    def test_rotor_blade(self):
        """Wright and others (1982) as reprinted to three digits by Bir (2009), AIAA 2009-1035, table 3a."""
        printed = "3.516 3.682 4.137 4.797 5.585 6.450 7.360 8.300 9.257 10.226 11.202 12.184 13.170"
        found = [exact.flapping_blade(float(speed)) for speed in range(13)]
        np.testing.assert_allclose(found, [float(value) for value in printed.split()], atol=5.1e-4)
        assert found[0] == pytest.approx(exact.cantilever_roots(1)[0] ** 2, rel=1e-12)

    def test_rotor_blade_by_its_energies(self):
        """Rayleigh-Ritz with polynomials, which give upper bounds."""
        x, weights = np.polynomial.legendre.leggauss(40)
        x, weights = 0.5 * (x + 1), 0.5 * weights
        shapes = [
            np.polynomial.Polynomial([0, 0, 1])
            * np.polynomial.Legendre.basis(k, [0, 1]).convert(kind=np.polynomial.Polynomial)
            for k in range(12)
        ]
        w, slope, bend = (np.array([shape.deriv(order)(x) for shape in shapes]) for order in range(3))
        mass, elastic = (a @ (weights[:, None] * a.T) for a in (w, bend))
        pull = slope @ ((0.5 * weights * (1 - x**2))[:, None] * slope.T)
        for speed in (3.0, 12.0):
            square = eigh(elastic + speed**2 * pull, mass, eigvals_only=True)[0]
            assert exact.flapping_blade(speed) == pytest.approx(np.sqrt(square), rel=1e-9)

    def test_newton_that_does_not_converge_says_so(self):
        with pytest.raises(ArithmeticError, match="has not converged"):
            exact.newton(lambda x: x**2 + 1, np.array([0.7]))
