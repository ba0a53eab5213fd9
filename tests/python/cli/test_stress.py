"""The stress test: its short version, the evaluation of cells, and the criteria of a regression."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import lissom
from lissom.cli import commands
from lissom.cli.evidence import stress
from lissom.cli.evidence.stress import judge, rods, table
from lissom.cli.evidence.stress.cell import KINDS, Cell, Outcome
from lissom.cli.exits import REGRESSED


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Results of the short run, which must not have regressions."""
    target = tmp_path_factory.mktemp("stress") / "out"
    done = CliRunner().invoke(
        commands, ["stress", "--quick", "-o", str(target)], standalone_mode=False, catch_exceptions=False
    )
    assert done.return_value == 0, done.output
    return target


def test_the_short_run_regresses_nowhere_and_is_written(folder):
    summary = json.loads((folder / "summary.json").read_text())
    assert (summary["quick"], summary["regressions"], summary["counts"]["wrong"]) == (True, [], 0)
    assert len(summary["groups"]) == len(stress.GROUPS)
    for group in summary["groups"].values():
        assert group["cells"], "every group has cells in the short run"
        for cell in group["cells"]:
            assert cell["outcome"] == "accurate" or cell["reason"], cell
    page = (folder / "report.html").read_text()
    for group in summary["groups"].values():
        assert group["title"].replace("'", "&#x27;") in page


def test_the_table_has_every_cell():
    cells = {make().name: {f"{cell.row} | {cell.column}" for cell in make().cells} for make in stress.GROUPS}
    committed = table.committed()
    assert {name: set(group) for name, group in committed.items()} == cells
    assert {kind for group in committed.values() for kind in group.values()} <= set(KINDS)


def test_what_became_worse_is_a_regression_and_what_is_wrong_always():
    expected = {"g": {"a": "accurate", "b": "refused", "c": "failed", "d": "wrong"}}
    worse = {"g": {"a": "slow", "b": "failed", "c": "refused", "d": "wrong", "new": "failed"}}
    assert table.regressions(worse, expected) == [
        "g: a: accurate before, slow now",
        "g: b: refused before, failed now",
        "g: d: wrong",
    ]
    assert table.improvements(worse, expected) == 2
    assert table.regressions(expected, expected) == ["g: d: wrong"]


def test_a_regression_is_exit_code_3(monkeypatch, tmp_path):
    group = stress.Group("g", "G", "row", "column", [Cell("r", "c", lambda: Outcome("wrong", "w"), True)], "")
    monkeypatch.setattr(stress, "GROUPS", (lambda: group,))
    arguments = ["stress", "--quick", "--no-report", "-o", str(tmp_path / "out")]
    done = CliRunner().invoke(commands, arguments, standalone_mode=False, catch_exceptions=False)
    assert done.return_value == REGRESSED == 3
    assert "1 cells regressed or are wrong" in done.output


def test_the_table_is_updated_by_whole_runs_only():
    done = CliRunner().invoke(commands, ["stress", "--quick", "--update"])
    assert done.exit_code == 2
    assert "leave --quick out" in done.output


@pytest.mark.parametrize(
    ("error", "kind"),
    [(ValueError("no"), "refused"), (lissom.LissomError("no"), "failed"), (ZeroDivisionError("no"), "wrong")],
)
def test_what_is_raised_is_an_outcome(error, kind):
    def work():
        raise error

    outcome = Cell("r", "c", work).run()
    assert outcome.kind == kind
    assert "no" in outcome.reason


def test_the_judge_sees_what_is_wrong():
    rod = rods.rod(rods.BENDING)
    times = np.linspace(0.0, 0.2, 11)
    right = judge.reference(rod, times)
    assert judge.fixed(rod, times, right, "newmark", 1e-3).kind == "accurate"
    coarse = judge.fixed(rod, times, right, "newmark", 0.1)
    assert coarse.kind == "failed"
    assert "step is too long" in coarse.reason
    other = judge.reference(rods.rod(rods.BENDING, radius=0.01), times)
    for judged in (
        judge.requested(rod, times, other),
        judge.adaptive(rod, times, other, "radau"),
        judge.fixed(rod, times, other, "newmark", 1e-3),
    ):
        assert judged.kind == "wrong"


def test_the_judge_sees_shapes_that_are_not_in_equilibrium():
    light, heavy = (rods.rod(rods.BENDING, density=density) for density in (100.0, 1000.0))
    assert judge.equilibrium(heavy, lissom.statics(heavy)).kind == "accurate"
    assert judge.equilibrium(heavy, lissom.statics(light)).kind == "wrong"
    straight = np.zeros(heavy.n)
    assert judge.vibrations(heavy, straight, lissom.modes(light, straight)).kind == "wrong"
