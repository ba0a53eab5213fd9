"""Keyword arguments that do not exist, where options are handed on: the one that may be meant is named."""

import pytest

import lissom
from lissom.common.arguments import keywords

PENDULUM = lissom.SpringPendulum()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: lissom.sensitivity(PENDULUM, 0.1, ["mass"], metod="radau"),
            r"sensitivity\(\) got an unexpected keyword argument 'metod', expected t0, .*you mean 'method'",
        ),
        (
            lambda: lissom.equilibrium_sensitivity(PENDULUM, ["mass"], tolerance=1e-8),
            r"equilibrium_sensitivity\(\) got .*'tolerance', expected q0, .*; did you mean 'tol'\?",
        ),
        (
            lambda: lissom.sweep(PENDULUM, {"mass": [1.0]}, t_end=0.1, max_step_size=1.0),
            r"sweep\(\) got .*'max_step_size', expected executor, .*; did you mean 'max_steps?'\?",
        ),
        (
            lambda: lissom.sweep(PENDULUM, {"mass": [1.0]}, tend=0.1),
            r"sweep\(\) got .*'tend', .*; did you mean 't_end'\?",
        ),
        (
            lambda: lissom.sensitivity(PENDULUM, 0.1, ["mass"], zzz=1),
            r"'zzz', expected t0, [a-z_0, ]*progress$",
        ),
    ],
)
def test_the_one_that_may_be_meant_is_named(call, message):
    with pytest.raises(TypeError, match=message):
        call()


def test_ends_of_longer_names_are_meant():
    """As of the classes: `orientation` stands for `base_orientation`, though `rotation` is more alike."""
    with pytest.raises(TypeError, match="did you mean 'base_orientation'"):
        keywords("f", ["orientation"], ["rotations", "base_orientation"])
    keywords("f", ["rotations"], ["rotations", "base_orientation"])
