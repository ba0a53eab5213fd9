"""The installed package as a whole."""

import re
from importlib.metadata import requires, version

import lissom


def test_the_version_is_that_of_the_distribution():
    assert lissom.__version__ == version("lissom")


def test_only_three_packages_are_needed_at_run_time():
    unconditional = [line for line in requires("lissom") or [] if "extra ==" not in line]
    assert {re.match(r"[\w-]+", line)[0] for line in unconditional} == {"numpy", "click", "tqdm"}
