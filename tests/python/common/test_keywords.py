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


SEGMENT = {"length": 0.1, "radius": 0.01, "young_modulus": 3e5, "poisson_ratio": 0.4, "density": 1100.0}
SEGMENT |= {"modes": {"bend_y": 1}}


@pytest.mark.parametrize(
    ("symbol", "meant"),
    [
        *(("E", "young_modulus"), ("G", "shear_modulus"), ("nu", "poisson_ratio"), ("rho", "density")),
        *(("L", "length"), ("l", "length"), ("r", "radius"), ("R", "radius"), ("tau", "retardation_time")),
    ],
)
def test_symbols_stand_for_names(symbol, meant):
    with pytest.raises(TypeError, match=rf"keyword argument '{symbol}', .*; did you mean '{meant}'\?"):
        lissom.Segment(**{symbol: 1.0})
    rod = lissom.Rod([lissom.Segment(**SEGMENT)])
    with pytest.raises(ValueError, match=rf"segments\[0\]\.{symbol}: .*; did you mean '{meant}'\?"):
        lissom.sweep(rod, {f"segments[*].{symbol}": [1.0]}, t_end=0.1)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: lissom.Rod([], orientation=(1, 0, 0, 0)), "did you mean 'base_orientation'"),
        (lambda: lissom.Tendon("t", mu=0.1), "did you mean 'friction'"),
        (lambda: lissom.Tendon("t", T=1.0), "did you mean 'tension'"),
        (lambda: lissom.Contact(("ball", 0.1), "floor", mu=0.1), "did you mean 'friction'"),
        (lambda: lissom.Revolute((0, 1, 0), k=1.0), "did you mean 'stiffness'"),
        (lambda: lissom.Revolute((0, 1, 0), c=1.0), "did you mean 'damping'"),
        (lambda: lissom.Body(m=1.0), "did you mean 'mass'"),
        (lambda: lissom.Rod([], g=1.0), "did you mean 'gravity'"),
        (lambda: lissom.methods.Newmark(rho=0.8), "did you mean 'rho_inf'"),
        (lambda: lissom.simulate(PENDULUM, 0.1, method="explicit"), r'"auto"; did you mean "rk45"\?'),
        (lambda: lissom.simulate(PENDULUM, 0.1, method="implicit"), r'did you mean "newmark"\?'),
        (lambda: lissom.simulate(PENDULUM, 0.1, method="RK45"), r'did you mean "rk45"\?'),
        (lambda: lissom.simulate(PENDULUM, 0.1, method="ode15s"), r'did you mean "radau"\?'),
        (lambda: lissom.simulate(PENDULUM, 0.1, method="newmarc"), r'did you mean "newmark"\?'),
        (lambda: lissom.simulate(PENDULUM, 0.1, method="quux"), r'"auto"$'),
    ],
)
def test_symbols_and_words_of_other_programs(call, message):
    with pytest.raises((TypeError, ValueError), match=message):
        call()


def test_ends_of_longer_names_are_meant():
    """As of the classes: `orientation` stands for `base_orientation`, though `rotation` is more alike."""
    with pytest.raises(TypeError, match="did you mean 'base_orientation'"):
        keywords("f", ["orientation"], ["rotations", "base_orientation"])
    keywords("f", ["rotations"], ["rotations", "base_orientation"])
