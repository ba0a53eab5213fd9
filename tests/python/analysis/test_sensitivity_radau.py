"""Derivatives of runs of Radau IIA compared with differences of runs with the same steps, in NumPy."""

import numpy as np
import pytest

import lissom
from lissom.analysis.parameters import model_with, value_of
from reference.radau import run

TIGHT = {"rtol": 1e-8, "atol": 1e-10}


def stiff_rod(**changes):
    options = {"modes": {"bend_y": 1, "stretch": 1}, "retardation_time": 1e-3} | changes
    finger = lissom.Segment(0.3, (0.012, 0.008), 4e5, 1.5e5, 1100, **options)
    return lissom.Rod([finger], gravity=(0.3, 0.0, -9.81), tip_mass=0.01)


def pushed():
    finger = lissom.Segment(0.2, 0.01, 3e5, 1.5e5, 1100, modes={"bend_y": 2}, retardation_time=0.02)
    push = lissom.Tendon("push", [lissom.Along("finger", (0.0, 0.006))], tension=lissom.Input("push", 0.02))
    link = lissom.Link("finger", rod=[finger], joint=lissom.Revolute((0, 1, 0), stiffness=0.3, damping=0.01))
    return lissom.Robot([link], actuators=[push])


def differences(states_of, step):
    weights = {-2: 1 / 12, -1: -2 / 3, 1: 2 / 3, 2: -1 / 12}
    nodes = {k: states_of(k * step) for k in weights}
    return [sum(weights[k] * nodes[k][i] for k in nodes) / step for i in range(2)]


NAMES = [
    "segments[0].young_modulus",
    "segments[0].radius[0]",
    "segments[0].length",
    "segments[0].retardation_time",
    "gravity[2]",
    "tip_mass",
    "q0[0]",
    "v0[1]",
]


@pytest.mark.parametrize("name", NAMES)
def test_derivatives_are_those_of_the_discrete_solution(name):
    model = stiff_rod()
    found = lissom.sensitivity(model, 0.05, [name], method="radau", **TIGHT)
    sizes = np.diff(found.t)
    assert sizes.max() > 2.0 * sizes.min()
    zeros = np.zeros(model.n)

    def states_of(change):
        moved, q, v = model, zeros.copy(), zeros.copy()
        if name[0] in "qv":
            {"q": q, "v": v}[name[0]][int(name[3])] = change
        else:
            moved = model_with(model, {name: value_of(model, name) + change})
        return run(moved, found.t, q, v)

    expected = differences(states_of, 1e-3 * (1.0 if name[0] in "qv" else abs(value_of(model, name))))
    for derivative, of_runs in zip((found.dq, found.dv), expected, strict=True):
        assert np.abs(derivative[..., 0] - of_runs).max() < 1e-7 * np.abs(of_runs).max()


@pytest.mark.slow
def test_inputs_of_control_steps():
    model, u = pushed(), np.array([[0.05], [0.2], [0.1]])
    options = {"u": u, "control_step": 0.03, "method": "radau", **TIGHT}
    found = lissom.sensitivity(model, 0.08, ["u", "link[0].joint.stiffness"], **options)
    assert found.names[:3] == ("u[0][0]", "u[1][0]", "u[2][0]")
    leg = np.minimum((found.t[:-1] + 1e-9) / 0.03, 2).astype(int)
    zeros = np.zeros(model.n)
    for i in range(3):

        def states_of(change, i=i):
            held = u.copy()
            held[i] += change
            return run(model, found.t, zeros, zeros, held[leg])

        expected = differences(states_of, 1e-2)
        for derivative, of_runs in zip((found.dq, found.dv), expected, strict=True):
            assert np.abs(derivative[..., i] - of_runs).max() < 1e-7 * np.abs(of_runs).max()


@pytest.mark.parametrize("rtol", [1e-3, 1e-8])
def test_adjoint_is_forward(rtol):
    rng = np.random.default_rng(4)
    model = pushed()
    names = ["link[0].rod.segment[0].radius", "link[0].rod.segment[0].density", "gravity[2]"]
    names += ["link[0].rod.segment[0].young_modulus", "link[0].joint.damping", "u", "q0", "v0"]
    options = {"method": "radau", "rtol": rtol, "u": [[0.05], [0.2]], "control_step": 0.06}
    forward = lissom.sensitivity(model, 0.1, names, **options)
    on_q, on_v = rng.standard_normal((2, *forward.q.shape))

    def objective(t, q, v):
        return float((on_q * q).sum() + (on_v * v).sum()), on_q, on_v

    adjoint = lissom.sensitivity(model, 0.1, names, objective=objective, **options)
    expected = np.einsum("mn,mnp->p", on_q, forward.dq) + np.einsum("mn,mnp->p", on_v, forward.dv)
    np.testing.assert_allclose(adjoint.gradient, expected, rtol=1e-8)


def test_loose_tolerances_leave_derivatives_near_those_of_the_motion():
    """Other methods and steps have only the motion itself in common."""
    names = ["segments[0].young_modulus", "gravity[2]", "q0[0]"]
    loose = lissom.sensitivity(stiff_rod(), 0.1, names, method="radau", rtol=1e-5)
    fine = lissom.sensitivity(stiff_rod(), 0.1, names, dt=2e-5, rtol=1e-10)
    assert len(loose.t) < 100
    np.testing.assert_allclose(loose.dq[-1], fine.dq[-1], rtol=1e-4, atol=1e-5 * np.abs(fine.dq[-1]).max())


def test_every_accepted_step_is_told():
    model = stiff_rod()
    steps = lissom.simulate(model, 0.1, method="radau", t_eval="steps")
    assert len(steps.t) == steps.stats.steps + 1
    at = lissom.simulate(model, 0.1, method="radau", t_eval=steps.t)
    for stored, asked in zip((steps.q, steps.v, steps.a), (at.q, at.v, at.a), strict=True):
        np.testing.assert_array_equal(stored, asked)
    explicit = lissom.simulate(model, 0.01, method="rk45", t_eval="steps")
    assert len(explicit.t) == explicit.stats.steps + 1
    fixed = lissom.simulate(model, 0.1, t_eval="steps")
    np.testing.assert_array_equal(fixed.t, lissom.simulate(model, 0.1).t)
    with pytest.raises(ValueError, match="t_eval='steps'"):
        lissom.simulate(model, 0.1, method="auto", t_eval="steps")
    with pytest.raises((TypeError, ValueError), match="t_eval"):
        lissom.simulate(model, 0.1, method="radau", t_eval="step")
