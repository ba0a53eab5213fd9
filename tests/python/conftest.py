"""Settings of all Python tests."""

import os

from hypothesis import settings

# Compiled code makes the first example slow, hence no deadline. Continuous integration must be repeatable.
settings.register_profile("lissom", deadline=None, max_examples=50, derandomize="CI" in os.environ)
settings.load_profile("lissom")
