"""Derivatives of runs with respect to inputs of control steps, compared with central differences."""

import warnings

import numpy as np
import pytest
from test_sensitivity import TIGHT

import lissom


def arm():
    """A finger with a tendon below it, on a motor."""
    finger = lissom.Segment(
        0.2, 0.01, 3e5, 1.5e5, 1100, modes={"bend_y": 2, "stretch": 1}, retardation_time=0.02
    )
    tendon = lissom.Tendon(
        "flexor", [lissom.Along("finger", (0.0, -0.006))], tension=lissom.Input("pull", 0.5)
    )
    motor = lissom.Motor("finger", torque=lissom.Input("torque"))
    link = lissom.Link("finger", rod=[finger], joint=lissom.Revolute((0, 1, 0), damping=0.01))
    return lissom.Robot([link], actuators=[tendon, motor])


U = np.array([[1.0, 0.02], [1.0, 0.02], [2.5, -0.03], [0.8, 0.01]])


def run(model, u, t_end=0.123, control_step=0.035, **options):
    rows = iter(u)
    found = lissom.simulate(
        model, t_end, control=lambda t, q, v: next(rows), control_step=control_step, **options, **TIGHT
    )
    assert found.success
    return found


def differences(of, value, step):
    """Fourth-order differences."""
    weights = {-2: 1 / 12, -1: -2 / 3, 1: 2 / 3, 2: -1 / 12}
    return sum(weight * of(value + k * step) for k, weight in weights.items()) / step


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"method": "newmark", "beta": 0.3025, "gamma": 0.6},
        {"method": "generalised_alpha", "rho_inf": 0.6},
        {"method": "hht", "alpha": -0.2},
    ],
)
def test_derivatives_with_respect_to_inputs_are_those_of_whole_runs(options):
    # Neither control steps nor the run are multiples of the step; two rows are equal.
    model = arm()
    found = lissom.sensitivity(
        model, 0.123, ["u", "q0[1]"], u=U, control_step=0.035, dt=0.01, **options, **TIGHT
    )
    assert found.names == (*(f"u[{k}][{i}]" for k in range(4) for i in range(2)), "q0[1]")
    np.testing.assert_array_equal(found.q, run(model, U, dt=0.01, **options).q)
    for k in range(4):
        for i in range(2):

            def moved(value, k=k, i=i):
                u = U.copy()
                u[k, i] = value
                result = run(model, u, dt=0.01, **options)
                return np.stack([result.q, result.v])

            # Rows remain nearly equal: steps after larger jumps are of another kind.
            expected = differences(moved, U[k, i], 1e-6)
            column = found.names.index(f"u[{k}][{i}]")
            derivative = np.stack([found.dq[..., column], found.dv[..., column]])
            for j in range(2):
                assert np.abs(derivative[j] - expected[j]).max() < 1e-7 * np.abs(expected[j]).max()


@pytest.mark.parametrize(
    "name", ["link[0].rod.segment[0].young_modulus", "link[0].rod.segment[0].radius", "link[0].joint.damping"]
)
def test_other_parameters_are_differentiated_under_the_inputs(name):
    from lissom.analysis.parameters import model_with, value_of

    model = arm()
    found = lissom.sensitivity(model, 0.123, [name], u=U, control_step=0.035, **TIGHT)
    value = value_of(model, name)
    expected = differences(lambda p: run(model_with(model, {name: p}), U).q, value, 1e-3 * value)
    assert np.abs(found.dq[..., 0] - expected).max() < 1e-7 * np.abs(expected).max()


@pytest.mark.parametrize("options", [{}, {"method": "generalised_alpha", "rho_inf": 0.3}, {"method": "hht"}])
def test_adjoint_is_forward(options):
    names = ["u", "link[0].rod.segment[0].young_modulus", "gravity[2]", "v0"]
    rng = np.random.default_rng(5)
    held = {"u": U, "control_step": 0.035} | options
    forward = lissom.sensitivity(arm(), 0.123, names, **held)
    on_q, on_v = rng.standard_normal((2, *forward.q.shape))

    def objective(t, q, v):
        return float((on_q * q).sum() + (on_v * v).sum()), on_q, on_v

    adjoint = lissom.sensitivity(arm(), 0.123, names, objective=objective, **held)
    expected = np.einsum("mn,mnp->p", on_q, forward.dq) + np.einsum("mn,mnp->p", on_v, forward.dv)
    np.testing.assert_allclose(adjoint.gradient, expected, rtol=1e-9)


def test_constant_inputs_are_one_row():
    model = arm()
    one = lissom.sensitivity(model, 0.1, ["u"], u=[1.0, 0.01], **TIGHT)
    assert one.names == ("u[0][0]", "u[0][1]")
    rows = lissom.sensitivity(model, 0.1, ["u"], u=np.tile([1.0, 0.01], (5, 1)), control_step=0.02, **TIGHT)
    np.testing.assert_allclose(
        one.dq, rows.dq.reshape(*rows.dq.shape[:2], 5, 2).sum(2), rtol=1e-9, atol=1e-12
    )


def test_without_inputs_the_defaults_are_held():
    by_default = lissom.sensitivity(arm(), 0.1, ["v0"])
    given = lissom.sensitivity(arm(), 0.1, ["v0"], u=[0.5, 0.0])
    np.testing.assert_array_equal(by_default.dq, given.dq)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"u": U[:3]}, r"u: got shape \(3, 2\), expected \(4, 2\)"),
        ({"u": U[:, :1]}, r"u: got shape \(4, 1\), expected \(4, 2\)"),
        ({"u": np.where(U > 2, np.nan, U)}, "finite"),
        ({"u": None}, "control_step: got 0.035 without `u`"),
        ({"control_step": -1.0}, "control_step: got -1.0"),
        ({"parameters": ["u[4]"]}, r"'u\[4\]', expected an index below 4, the number of steps"),
        ({"parameters": ["u[0][2]"]}, "an index below 2, the number of inputs"),
        ({"parameters": ["u", "u[1][0]"]}, "is listed twice"),
        ({"parameters": ["u"], "u": None, "control_step": None}, "'u', expected"),
    ],
)
def test_bad_inputs_are_refused_before_the_run(changes, message):
    arguments = {"parameters": ["v0"], "u": U, "control_step": 0.035} | changes
    names = arguments.pop("parameters")
    with pytest.raises(ValueError, match=message):
        lissom.sensitivity(arm(), 0.123, names, **arguments)


def test_models_without_inputs_take_none():
    rod = lissom.Rod([lissom.Segment(0.2, 0.01, 3e5, 1.5e5, 1100, modes={"bend_y": 1})])
    with pytest.raises(ValueError, match="u: this model has no inputs"):
        lissom.sensitivity(rod, 0.1, ["v0"], u=[1.0])


def test_a_start_that_jumps_too_far_for_its_step():
    """Tensions at once: the first step has two stages, where that of the method has no solution."""
    segment = lissom.Segment(
        0.2, 4.6e-3, 4e8, 1.4e8, 1200.0, {"torsion": 1, "bend_y": 2, "bend_z": 2}, retardation_time=1e-3
    )
    paths = [[lissom.Along("rod", place)] for place in ((3.7e-3, 0.0), (-1.8e-3, 3.2e-3))]
    tendons = [lissom.Tendon(f"t{i}", path, tension=lissom.Input(f"t{i}")) for i, path in enumerate(paths)]
    model = lissom.Rod([segment], actuators=tendons)
    start = np.array([[60.0, 90.0], [20.0, 40.0], [70.0, 10.0]])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lissom.AccuracyWarning)
        found = lissom.sensitivity(model, 0.03, ["u"], u=start, control_step=0.01, dt=0.01, **TIGHT)
        for k, i in np.ndindex(3, 2):

            def moved(value, k=k, i=i):
                u = start.copy()
                u[k, i] = value
                return run(model, u, dt=0.01, t_end=0.03, control_step=0.01).q

            expected = differences(moved, start[k, i], 1e-3)
            derivative = found.dq[..., found.names.index(f"u[{k}][{i}]")]
            assert np.abs(derivative - expected).max() < 1e-6 * np.abs(expected).max()
