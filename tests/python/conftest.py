"""Settings of all Python tests."""

import os
import signal

from hypothesis import settings

# No deadline, because compilation makes the first example slow. Continuous integration must be repeatable.
settings.register_profile("lissom", deadline=None, max_examples=50, derandomize="CI" in os.environ)
settings.load_profile("lissom")


def pytest_configure(config):
    """Enables Ctrl-C, and registers the marks of SciPy's tests that test_scipy_ivp.py runs."""
    # Shells let background jobs ignore Ctrl-C, and Python inherits this.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    config.addinivalue_line("markers", "slow: takes long, left out of `make test`; SciPy has it too")
    for mark in ("thread_unsafe", "fail_slow"):
        config.addinivalue_line("markers", f"{mark}: a mark of SciPy's tests")
