"""Settings of all Python tests."""

import os

from hypothesis import settings

# Compiled code makes the first example slow, hence no deadline. Continuous integration must be repeatable.
settings.register_profile("lissom", deadline=None, max_examples=50, derandomize="CI" in os.environ)
settings.load_profile("lissom")


def pytest_configure(config):
    """Marks of SciPy's tests of `solve_ivp`, which test_scipy_ivp.py runs."""
    for mark in ("thread_unsafe", "fail_slow", "slow"):
        config.addinivalue_line("markers", f"{mark}: a mark of SciPy's tests")
