"""Runs as functions in JAX, checked with its own gradient checker."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import lissom

jax = pytest.importorskip("jax", reason="the extra 'jax' is not installed")
from jax.test_util import check_grads  # noqa: E402

import lissom.jax  # noqa: E402

TIGHT = {"rtol": 1e-13, "atol": 1e-13}
NAMES = ["gravity[2]", "segments[0].length"]


@pytest.fixture(autouse=True)
def doubles():
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", False)


def finger():
    soft = lissom.Segment(0.3, 0.01, 3e5, 1.2e5, 1100, modes={"bend_y": 2}, retardation_time=0.02)
    return lissom.Rod([soft])


def values(gravity=-9.81, length=0.3):
    return {"gravity[2]": gravity, "segments[0].length": length}


Q0, V0 = np.array([0.3, -0.2]), np.array([0.5, 0.1])


def test_gradients_pass_the_checker():
    run = lissom.jax.simulation(finger(), 0.3, NAMES, t=[0.1, 0.3], **TIGHT)

    def states(gravity, length, q0, v0):
        return run(values(gravity, length), q0, v0)[1:]

    check_grads(states, (-9.81, 0.3, Q0, V0), order=1, modes=["rev"], atol=1e-5, rtol=1e-5, eps=1e-5)


def test_states_are_those_of_simulate():
    run = lissom.jax.simulation(finger(), 0.3)
    t, q, v = jax.jit(run)({}, Q0, V0)
    plain = lissom.simulate(finger(), 0.3, q0=Q0, v0=V0)
    assert_allclose(t, plain.t, rtol=1e-14)
    assert_array_equal(q, plain.q)
    assert_array_equal(v, plain.v)


def test_runs_and_gradients_of_a_batch_are_those_one_by_one(monkeypatch):
    run = lissom.jax.simulation(finger(), 0.2, NAMES, t=[0.2])
    calls = []
    many = lissom.analysis.pullbacks.simulate_many
    monkeypatch.setattr(
        lissom.analysis.pullbacks, "simulate_many", lambda *a, **k: calls.append(1) or many(*a, **k)
    )

    def tip(gravity, q0):
        return run(values(gravity), q0, V0)[1][0, 0]

    gravities, starts = np.array([-9.81, -1.62, 3.0]), np.array([Q0, 0 * Q0, -Q0])
    together = jax.vmap(tip)(gravities, starts)
    assert len(calls) == 1
    assert_array_equal(together, [tip(*row) for row in zip(gravities, starts, strict=True)])
    gradients = jax.vmap(jax.grad(tip, (0, 1)))(gravities, starts)
    for i, row in enumerate(zip(gravities, starts, strict=True)):
        for found, alone in zip(gradients, jax.grad(tip, (0, 1))(*row), strict=True):
            assert_array_equal(found[i], alone)


def test_a_run_that_fails_is_nan_and_disturbs_no_other():
    run = lissom.jax.simulation(finger(), 0.2, t=[0.2], max_steps=20)
    short = lissom.jax.simulation(finger(), 0.2, t=[0.2], max_steps=3)
    assert np.isfinite(run({}, Q0, V0)[1]).all()
    assert np.isnan(short({}, Q0, V0)[1]).all()
    assert np.isnan(jax.grad(lambda q0: short({}, q0, V0)[1].sum())(Q0)).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"parameters": ["q0"]}, "the start is an argument"),
        ({"parameters": ["gravity[7]"]}, "gravity"),
        ({"t": [0.105]}, r"t\[0\]: got 0.105"),
        ({"t": [float("nan")]}, r"t\[0\]: got nan"),
        ({"t": []}, "t: got shape"),
        ({"dt": 0.03}, "whole number of steps"),
        ({"method": "radau"}, "not differentiated here"),
    ],
)
def test_what_has_no_derivatives_is_refused(options, message):
    with pytest.raises(ValueError, match=message):
        lissom.jax.simulation(finger(), 0.2, **options)


def test_calls_that_do_not_fit_are_refused():
    run = lissom.jax.simulation(finger(), 0.2, ["gravity[2]"])
    with pytest.raises(ValueError, match=r"values: got \[\], expected \['gravity\[2\]'\]"):
        run({}, Q0, V0)
    with pytest.raises(ValueError, match=r"q0: got shape \(3,\), expected \(2,\)"):
        run({"gravity[2]": -1.0}, np.zeros(3), V0)
    jax.config.update("jax_enable_x64", False)
    with pytest.raises(ValueError, match="32 bits"):
        run({"gravity[2]": -1.0}, Q0, V0)


def steered():
    """A finger on a motor, with a tendon."""
    soft = lissom.Segment(0.2, 0.01, 3e5, 1.5e5, 1100, modes={"bend_y": 2}, retardation_time=0.02)
    tendon = lissom.Tendon(
        "flexor", [lissom.Along("finger", (0.0, -0.006))], tension=lissom.Input("pull", 0.5)
    )
    motor = lissom.Motor("finger", torque=lissom.Input("torque"))
    link = lissom.Link("finger", rod=[soft], joint=lissom.Revolute((0, 1, 0), damping=0.01))
    return lissom.Robot([link], actuators=[tendon, motor])


U = np.array([[1.0, 0.02], [2.5, -0.03], [0.8, 0.01]])


def test_gradients_with_respect_to_inputs_pass_the_checker():
    run = lissom.jax.simulation(steered(), 0.25, ["gravity[2]"], t=[0.1, 0.25], control_step=0.1, **TIGHT)

    def states(gravity, q0, u):
        return run({"gravity[2]": gravity}, q0, np.zeros(3), u)[1:]

    check_grads(states, (-9.81, 0.1 * np.ones(3), U), order=1, modes=["rev"], atol=1e-5, rtol=1e-5, eps=1e-5)
    batch = np.stack([U, 0.5 * U])

    def last(u):
        return run({"gravity[2]": -9.81}, np.zeros(3), np.zeros(3), u)[1][-1].sum()

    slopes = jax.vmap(jax.grad(last))(batch)
    assert slopes.shape == batch.shape
    for one, u in zip(slopes, batch, strict=True):
        assert_allclose(one, jax.grad(last)(u), rtol=1e-12)
    plain = lissom.sensitivity(steered(), 0.25, ["u"], u=U, control_step=0.1, **TIGHT)
    assert_allclose(slopes[0].ravel(), plain.dq[-1].sum(0), rtol=1e-9)


def test_inputs_are_checked():
    run = lissom.jax.simulation(steered(), 0.25, control_step=0.1)
    with pytest.raises(ValueError, match=r"u: got NoneType: inputs and a control_step need each other"):
        run({}, np.zeros(3), np.zeros(3))
    with pytest.raises(ValueError, match=r"u: got shape \(2, 2\), expected \(3, 2\)"):
        run({}, np.zeros(3), np.zeros(3), U[:2])
    with pytest.raises(ValueError, match="inputs and a control_step need each other"):
        lissom.jax.simulation(steered(), 0.25)({}, np.zeros(3), np.zeros(3), U)
    with pytest.raises(ValueError, match=r"a whole number of steps of 0\.01"):
        lissom.jax.simulation(steered(), 0.25, control_step=0.025)
    with pytest.raises(ValueError, match="this model has no inputs"):
        lissom.jax.simulation(finger(), 0.3, control_step=0.1)
