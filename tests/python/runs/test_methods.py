"""Methods with their options as objects: the same runs as names with keywords, and parts like all others."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import lissom
from lissom import methods

WIRE = lissom.Segment(0.4, 2e-3, 1e8, 4e7, 1200.0, {"bend_y": 2, "bend_z": 2}, retardation_time=1e-3)
ROD = lissom.Rod([WIRE], gravity=(0.0, 0.0, -9.81))
FALLING = lissom.Rod(
    [WIRE], contacts=[lissom.Contact("rod", lissom.HalfSpace((0.0, 0.0, -0.05)), stiffness=1e4)]
)

#: Objects beside the names and keywords that stand for them.
PAIRS = [
    (methods.Newmark(), {"method": "newmark"}),
    (methods.Newmark(beta=0.25, gamma=0.5), {"method": "average_acceleration"}),
    (methods.Newmark(beta=1 / 6, gamma=0.5), {"method": "linear_acceleration"}),
    (methods.Newmark(beta=0.3, gamma=0.6), {"method": "newmark", "beta": 0.3, "gamma": 0.6}),
    (methods.Newmark(alpha=-0.2), {"method": "hht", "alpha": -0.2}),
    (methods.Newmark(alpha=-0.1), {"method": "hht"}),
    (methods.Newmark(rho_inf=0.6), {"method": "generalised_alpha", "rho_inf": 0.6}),
    (methods.Newmark(rho_inf=0.8), {"method": "generalised_alpha"}),
    (methods.Newmark(rho_inf=0.6), {"rho_inf": 0.6}),
    (methods.Newmark(alpha=-0.2), {"method": "newmark", "alpha": -0.2}),
    (methods.Newmark(rtol=1e-9, atol=0.0), {"rtol": 1e-9, "atol": 0.0}),
    (methods.Newmark(rtol=[1e-9, 1e-8, 1e-7, 1e-6]), {"rtol": [1e-9, 1e-8, 1e-7, 1e-6]}),
    (
        methods.Newmark(adaptive=True, rtol=1e-4, max_step=2e-3, min_step=1e-6),
        {"adaptive": True, "rtol": 1e-4, "max_step": 2e-3, "min_step": 1e-6},
    ),
    (methods.Radau(), {"method": "radau"}),
    (methods.Radau(rtol=1e-8, max_step=1e-3), {"method": "radau", "rtol": 1e-8, "max_step": 1e-3}),
    (methods.Radau(atol=[1e-9] * 4), {"method": "radau", "atol": [1e-9] * 4}),
    (methods.RK45(rtol=1e-4, max_steps=10**6), {"method": "rk45", "rtol": 1e-4, "max_steps": 10**6}),
    (methods.DOP853(atol=1e-7), {"method": "dop853", "atol": 1e-7}),
]
OF_STEPS = [
    (methods.Newmark(jac="central", predictor="last"), {"jac": "central", "predictor": "last"}),
    (methods.Newmark(reuse_jacobian=False), {"reuse_jacobian": False}),
    (methods.Newmark(max_steps=7), {"max_steps": 7}),
    (methods.Auto(rtol=1e-3), {"method": "auto", "rtol": 1e-3}),
    (methods.Auto(max_step=5e-3), {"method": "auto", "max_step": 5e-3}),
]


def same(one, other):
    assert one.status == other.status
    for name in ("t", "q", "v"):
        assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize("model", [ROD, FALLING], ids=["rod", "contact"])
@pytest.mark.parametrize(("method", "options"), PAIRS + OF_STEPS, ids=lambda value: str(value)[:50])
def test_objects_stand_for_names_with_keywords(model, method, options):
    run = {"t_end": 0.02, "dt": 2e-3, "q0": [0.0, 0.5, 0.3, 0.0]}
    same(lissom.simulate(model, method=method, **run), lissom.simulate(model, **options, **run))


@pytest.mark.parametrize(("method", "options"), PAIRS, ids=lambda value: str(value)[:50])
def test_everything_that_simulates_takes_them(method, options):
    run = {"t_end": 0.01, "dt": 2e-3, "q0": [0.0, 0.5, 0.3, 0.0]}
    times = {"t_eval": [0.0, 0.004, 0.01]}
    many, known = (
        lissom.simulate_many(ROD, **given, **run, **times) for given in ({"method": method}, options)
    )
    assert_array_equal(many.q, known.q)
    start = {"dt": 2e-3, "q0": run["q0"]}
    options = {name: value for name, value in options.items() if name != "max_steps"}
    for kind in (lissom.Simulation, lambda model, **given: lissom.Simulations(model, 2, **given)):
        steps, others = kind(ROD, method=method, **start), kind(ROD, **options, **start)
        for _ in range(3):
            steps.step()
            others.step()
        assert_array_equal(steps.q, others.q)


@pytest.mark.parametrize(
    ("method", "options"),
    [
        (
            methods.Newmark(rho_inf=0.6, rtol=1e-9),
            {"method": "generalised_alpha", "rho_inf": 0.6, "rtol": 1e-9},
        ),
        (methods.Newmark(alpha=-0.2), {"method": "hht", "alpha": -0.2}),
        (methods.Newmark(), {}),
        (methods.Radau(rtol=1e-8), {"method": "radau", "rtol": 1e-8}),
    ],
    ids=["generalised_alpha", "hht", "newmark", "radau"],
)
def test_derivatives_of_runs_take_them(method, options):
    run = {"t_end": 0.02, "parameters": ["q0"], "dt": 2e-3, "q0": [0.0, 0.5, 0.3, 0.0]}
    one, other = lissom.sensitivity(ROD, method=method, **run), lissom.sensitivity(ROD, **options, **run)
    assert_array_equal(one.dq, other.dq)
    with pytest.raises(ValueError, match=r"rtol: `method` is one of lissom\.methods"):
        lissom.sensitivity(ROD, method=method, rtol=1e-9, **run)


def test_a_simulation_with_one_is_pickled_and_restarted():
    simulation = lissom.Simulation(ROD, dt=1e-3, method=methods.Newmark(rho_inf=0.3), q0=[0.0, 0.5, 0.3, 0.0])
    simulation.step()
    other = pickle.loads(pickle.dumps(simulation))
    assert_array_equal(other.q, simulation.q)
    simulation.step()
    other.step()
    assert_array_equal(other.q, simulation.q)


def test_defaults_are_those_of_simulate():
    assert methods.Newmark() == methods.Newmark(
        rtol=1e-6, atol=None, adaptive=False, jac="analytic", predictor="best"
    )
    assert methods.Radau() == methods.Radau(rtol=1e-6, atol=1e-9, min_step=0.0)
    assert methods.Auto().rtol == 1e-4


@pytest.mark.parametrize("method", [pair[0] for pair in PAIRS + OF_STEPS], ids=str)
def test_they_are_values(method):
    assert eval(repr(method), vars(methods)) == method
    assert pickle.loads(pickle.dumps(method)) == copy.deepcopy(method) == method
    assert hash(copy.copy(method)) == hash(method)
    changed = dataclasses.replace(method, rtol=3e-5)
    assert changed != method
    assert np.all(changed.rtol == 3e-5)
    assert type(method).__module__ == "lissom.methods"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: methods.Newmark(rho_inf=1.2), r"rho_inf: got 1.2, expected a number in \[0, 1\]"),
        (lambda: methods.Newmark(alpha=0.1), r"alpha: got 0.1, expected a number in \[-1/3, 0\]"),
        (lambda: methods.Newmark(gamma=0.4), "gamma: got 0.4"),
        (lambda: methods.Newmark(rho_inf=0.8, beta=0.3), "beta: got 0.3, expected nothing: rho_inf and beta"),
        (
            lambda: methods.Newmark(max_step=0.1),
            "max_step: got 0.1, expected nothing: it is for adaptive steps",
        ),
        (lambda: methods.Newmark(jac="exact"), "jac: got .*exact.*analytic"),
        (lambda: methods.Radau(rtol=-1.0), "rtol: got -1"),
        (lambda: methods.Radau(rtol=[1e-6, np.nan]), r"rtol\[1\]"),
        (lambda: methods.RK45(max_step=0.0), "max_step: got 0, expected a finite number > 0"),
        (lambda: methods.DOP853(max_steps=-1), "max_steps: got -1"),
        (lambda: methods.Auto(rtol=0.5), r"rtol: got 0.5, expected a number in \[1e-11, 0.1\]"),
        (
            lambda: lissom.simulate(ROD, 0.1, method=methods.Radau(), rtol=1e-9),
            "rtol: `method` is one of lissom.methods and has all of its options: leave `rtol` out",
        ),
        (
            lambda: lissom.simulate(ROD, 0.1, method=methods.Newmark(), adaptive=False),
            "adaptive: `method` is one of lissom.methods",
        ),
        (lambda: lissom.simulate(ROD, 0.1, method=methods.Radau(rtol=[1e-6] * 3)), "rtol: got 3 values"),
        (
            lambda: lissom.simulate(ROD, 0.1, method=methods.Auto(), t_eval="steps"),
            "t_eval='steps': the method .auto. takes",
        ),
    ],
)
def test_what_cannot_be_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("method", [3, None, methods.Newmark, WIRE])
def test_other_objects_are_no_methods(method):
    with pytest.raises(
        TypeError, match=r"method: expected the name of a method, or one of lissom\.methods, got"
    ):
        lissom.simulate(ROD, 0.1, method=method)


SCENE = """
version = 1
[[rod]]
[[rod.segment]]
length = 0.4
radius = 2e-3
young_modulus = 1e8
shear_modulus = 4e7
density = 1200
modes = { bend_y = 2 }
[simulation]
t_end = 0.02
dt = 2e-3
"""


@pytest.mark.parametrize("own", ["newmark", "radau", "auto"])
@pytest.mark.parametrize(
    ("method", "options"),
    [
        (methods.Radau(rtol=1e-8), {"method": "radau", "rtol": 1e-8}),
        (methods.Newmark(rho_inf=0.6), {"method": "generalised_alpha", "rho_inf": 0.6}),
        ("auto", {"method": "auto"}),
        ("dop853", {"method": "dop853"}),
    ],
    ids=str,
)
def test_scenes_run_by_another_method(own, method, options):
    """What a scene says of its own method is not handed to another one."""
    scene = lissom.Scene.loads(SCENE + f'method = "{own}"\n')
    run = {"t_end": 0.02, "dt": 2e-3}
    same(scene.run(method=method), lissom.simulate(scene.model, **options, **run))
