"""The tables of the benchmark suite follow from the measured values."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[3]
sys.path.insert(0, str(ROOT / "benches" / "python"))
from speed import native, report, rods  # noqa: E402

KERNEL = {
    "rod": "two-18",
    "coordinates": 18,
    "residual": 1.5e-6,
    "forward": 4e-6,
    "tangent": 5.25e-6,
    "step": 1e-5,
    "numpy": {"residual": 0.25, "forward": 3.5},
}


def cells(table):
    """The cells of a Markdown table, line by line."""
    lines = [line for line in table.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(1.25e-9, "1.25 ns"), (1e-6, "1 µs"), (0.0123, "12.3 ms"), (61.0, "61 s"), (None, "–")],
)
def test_times_have_the_unit_that_suits_them(seconds, text):
    assert report.time(seconds) == text


def test_tables_are_rectangular():
    limit = {
        "rates": {4: 1.5e10, 8: 2e10},
        "products_per_second": 2e10,
        "rows": [
            {
                "rod": "lab-3",
                "coordinates": 3,
                "products": {"residual": 2000, "tangent": 6000, "step": 9000},
                "seconds": {"residual": 2e-7, "tangent": 3e-6, "step": 1.8e-6},
            }
        ],
    }
    sizes = [{"segments": size, "coordinates": 3 * size, "residual": 1e-6 * size} for size in (1, 2, 4, 8)]
    scaling = {"rows": {"segments": [row | {"tangent": 1e-6, "step": 2e-6} for row in sizes]}}
    lab = {"rows": [{"case": "rod", "report": None, "seconds": 1e-3, "end": "finished"}]}
    for table in (
        report.kernels({"rows": [KERNEL]}),
        report.limit(limit),
        report.scaling(scaling),
        report.lab(lab),
    ):
        assert len({len(line) for line in cells(table)}) == 1
    assert "20.0 doubles a nanosecond at most (15.0 by 4 and 20.0 by 8" in report.limit(limit)
    # 2000 products at 20 per nanosecond take 100 ns.
    residual, tangent, step = cells(report.limit(limit))[2:]
    assert residual[2:] == ["2,000", "100 ns", "200 ns", "2.0", "reached"]
    assert tangent[-2:] == ["10.0", "not reached"]
    assert step[-2:] == ["4.0", "reached"]
    assert "inverse dynamics 1.00, tangent 0.00" in report.scaling(scaling)
    assert "never ends" in report.lab(lab)


def test_published_figures_stand_with_their_number_of_coordinates_alone():
    own, other = cells(report.kernels({"rows": [KERNEL, KERNEL | {"coordinates": 12}]}))[2:]
    assert own[-2:] == ["280 µs", "5.4 ms"]
    assert other[-2:] == ["–", "–"]


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.5])
def test_the_order_of_a_power_law_is_its_exponent(exponent):
    sizes = [1, 2, 4, 8]
    assert report.order(sizes, [3e-6 * size**exponent for size in sizes]) == pytest.approx(exponent)


def test_a_section_is_replaced_between_its_marks_and_nothing_else():
    page = "before\n<!-- lab -->\nold\n<!-- /lab -->\nafter\n<!-- limit -->\n<!-- /limit -->\n"
    new = report.with_section(page, "lab", "new\n")
    assert new == page.replace("old", "new")
    assert report.with_section(new, "lab", "new") == new
    assert "both" in report.with_section(new, "limit", "both")
    for wrong in ("no marks", "<!-- lab --> no end", page + page):
        with pytest.raises(ValueError, match="each once"):
            report.with_section(wrong, "lab", "new")


def test_the_page_has_a_section_for_every_part():
    source = (ROOT / "benches" / "python" / "speed" / "suite.py").read_text()
    parts = re.findall(r'"(\w+)": measure_\1', source)
    assert len(parts) == 5
    page = (ROOT / "docs" / "benchmarks.md").read_text()
    for part in parts:
        report.with_section(page, part, "")


def test_commands_that_are_named_exist():
    files = [ROOT / name for name in ("Makefile", "README.md", "CONTRIBUTING.md", "CHANGELOG.md")]
    for folder, kind in (
        ("docs", "*.md"),
        ("docs", "*.json"),
        ("benches", "*.py"),
        ("benches", "*.rs"),
        ("src", "*.rs"),
    ):
        files += (ROOT / folder).rglob(kind)
    named = {
        name
        for file in files
        for name in re.findall(r"benches/python/[\w/]+\.py", file.read_text(encoding="utf-8"))
    }
    assert len(named) > 8
    assert [name for name in sorted(named) if not (ROOT / name).is_file()] == []


def test_rods_are_those_of_the_rust_benchmarks():
    for name, arguments in rods.KERNELS.items():
        assert rods.rod(arguments).n == int(name.split("-")[1])
    source = (ROOT / "benches" / "rod.rs").read_text()
    assert f"segments in {list(rods.SEGMENTS)}" in source
    assert f"modes in {list(rods.MODES)}" in source
    assert f"STEPS: usize = {rods.STEPS};" in source
    assert float(re.search(r"STEP: f64 = (\S+);", source)[1]) == rods.STEP


def test_estimates_are_what_criterion_wrote(tmp_path):
    for name, nanoseconds, throughput in (("a step", 1500.0, None), ("steps", 3e5, {"Elements": 100})):
        folder = tmp_path / name / "new"
        folder.mkdir(parents=True)
        benchmark = {"function_id": name, "throughput": throughput}
        (folder / "benchmark.json").write_text(json.dumps(benchmark))
        iters = [1.0, 2.0, 3.0]
        sample = {"iters": iters, "times": [1.5 * nanoseconds, 2 * nanoseconds, 3.6 * nanoseconds]}
        (folder / "sample.json").write_text(json.dumps(sample))
    found = native.estimates(tmp_path)
    assert found["a step"].each == found["a step"].seconds == pytest.approx(1.5e-6)
    assert found["steps"].each == pytest.approx(3e-6)
    assert found["steps"].median == pytest.approx(3.6e-4)


def test_plots_are_drawn_of_whatever_parts_there_are(tmp_path):
    row = {
        "coordinates": 3,
        "products": {"residual": 2000, "tangent": 6000, "step": 9000},
        "seconds": {"residual": 2e-7, "tangent": 3e-6, "step": 1.8e-6},
    }
    limit = {"products_per_second": 2e10, "rows": [row, row | {"coordinates": 12}]}
    report.plot({}, tmp_path / "nothing.png")
    report.plot({"limit": limit}, tmp_path / "limit.png")
    assert (tmp_path / "limit.png").stat().st_size > (tmp_path / "nothing.png").stat().st_size > 0
    assert np.isfinite(report.order([1, 2], [1.0, 1.0]))
