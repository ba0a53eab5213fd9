"""Sizes of the source, which CONTRIBUTING.md lists: none grows without being seen."""

import importlib.util
import itertools
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def house():
    spec = importlib.util.spec_from_file_location("house", ROOT / "benches" / "python" / "house.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_files_are_no_longer_than_they_should_be(house):
    files = [*house.files("src", suffix=".rs"), *house.files("python", suffix=".py")]
    assert len(files) > 500
    assert [path for path in files if house.lines(path) > house.LARGE_FILE] == []


def test_functions_are_no_longer_than_they_should_be(house):
    rust = map(house.functions, house.files("src", suffix=".rs"))
    python = map(house.python_functions, house.files("python", suffix=".py"))
    lengths = list(itertools.chain.from_iterable([*rust, *python]))
    assert len(lengths) > 5000
    # Two lists of cases in tests.
    assert sum(length > house.LARGE_FUNCTION for length in lengths) <= 2


@pytest.mark.parametrize(
    ("of", "methods", "in_one"), [("model", 88, 17), ("second-order systems", 4, 4), ("effects", 23, 5)]
)
def test_traits_do_not_grow(house, of, methods, in_one):
    numbers = [number for number, _ in house.methods(ROOT / house.TRAITS[of])]
    assert 0 < sum(numbers) <= methods
    assert max(numbers) <= in_one
