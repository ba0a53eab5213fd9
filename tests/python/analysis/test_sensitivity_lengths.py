"""Gradients with respect to lengths, by one pass over a run, compared with differences of complete runs."""

import numpy as np
import pytest

import lissom
from lissom._lissom import machine
from lissom.analysis.parameters import model_with, resolved, value_of

TIGHT = {"rtol": 1e-13, "atol": 1e-13}

#: Step of fourth-order differences, relative to the length.
STEP = 2e-3
WEIGHTS = {-2: 1 / 12, -1: -2 / 3, 1: 2 / 3, 2: -1 / 12}


def segment(length=0.3, **options):
    modes = {"bend_y": 2, "bend_z": 2, "torsion": 1, "stretch": 1}
    return lissom.Segment(length, **MATERIAL | {"radius": 0.012, "modes": modes} | options)


MATERIAL = {"young_modulus": 4e5, "shear_modulus": 1.5e5, "density": 1100, "retardation_time": 0.02}
LOAD = {"force": (0.1, 0.2, -0.1), "moment": (0.01, 0.0, 0.02)}
TWO = [segment(), segment(0.2)]
IN_A_PLANE = {"bend_y": 3}


def rod(*segments, **options):
    return lissom.Rod(list(segments) or TWO, **{"gravity": (0.3, 1.0, -9.0)} | options)


def tree():
    links = [
        lissom.Link("arm", rod=TWO, joint=lissom.Revolute((0, 1, 0), stiffness=0.3, damping=0.01)),
        lissom.Link("ball", rod=TWO[1:], parent="arm", joint=lissom.Spherical(), position=(0, 0.01, 0)),
        lissom.Link("branch", rod=TWO[:1], parent="arm", orientation=(0.5, 0.5, 0.5, 0.5)),
        lissom.Link("tool", parent="ball", body=lissom.Body(0.02, centre=(0.01, 0, 0), inertia=(1e-6,) * 3)),
    ]
    motor = lissom.Motor("arm", torque=0.05)
    loads = [lissom.Load(force=(0.01, 0.02, -0.01), link="branch")]
    return lissom.Robot(links, loads=loads, actuators=[motor])


def floating():
    links = [
        lissom.Link("base", joint=lissom.Free(), rod=TWO),
        lissom.Link("slide", rod=TWO[1:], parent="base", joint=lissom.Prismatic((1, 0, 0))),
    ]
    return lissom.Robot(links)


def along(**options):
    return [lissom.Along(offset=(0.003, -0.006), **options)]


ALONE = {
    "in space": rod(),
    "dead load and body at the tip": rod(loads=[lissom.Load(**LOAD)], tip_mass=0.02),
    "follower load": rod(loads=[lissom.Load(**LOAD, frame="body")]),
    "tapered": rod(segment(radius=(0.012, 0.008)), segment(0.2, radius=(0.008, 0.003))),
    "rectangular": rod(segment(radius=None, section=lissom.Section.rectangle(0.02, 0.015))),
    "in a plane": rod(
        segment(modes=IN_A_PLANE, reference_strain=(0, 2.0, 0, 1, 0, 0)),
        segment(0.2, modes=IN_A_PLANE),
        gravity=(0.3, 0.0, -9.0),
    ),
    "curved": rod(segment(reference_strain=(1.0, 2.0, -1.0, 1, 0, 0)), segment(0.2)),
    "piecewise constant": rod(segment(basis="piecewise_constant", modes={"bend_y": 3, "bend_z": 3}), TWO[1]),
    "tree": tree(),
    "floating": floating(),
    "tendon": rod(actuators=[lissom.Tendon("pull", along(), tension=2.0)]),
    "chamber": rod(actuators=[lissom.Chamber("push", along(), 2e-5, 3e4)]),
}


def lengths_of(model):
    if isinstance(model, lissom.Rod):
        return [f"segments[{i}].length" for i in range(len(model.segments))]
    return [
        f"link[{i}].rod.segment[{j}].length"
        for i, link in enumerate(model.links)
        for j in range(len(link.rod or ()))
    ]


def objective_for(shape):
    on_q, on_v = np.random.default_rng(5).standard_normal((2, *shape))
    return lambda t, q, v: (float((on_q * q).sum() + (on_v * v).sum()), on_q, on_v)


def assert_adjoint_is_forward(model, given, rtol):
    forward = lissom.sensitivity(model, **given)
    objective = objective_for(forward.q.shape)
    gradient = lissom.sensitivity(model, objective=objective, **given).gradient
    _, on_q, on_v = objective(forward.t, forward.q, forward.v)
    expected = np.einsum("mn,mnp->p", on_q, forward.dq) + np.einsum("mn,mnp->p", on_v, forward.dv)
    np.testing.assert_allclose(gradient, expected, rtol=rtol)


def begin(model):
    rng = np.random.default_rng(3)
    return {"q0": 0.05 * rng.standard_normal(model.n), "v0": 0.1 * rng.standard_normal(model.n)}


@pytest.mark.parametrize("options", [{"method": "newmark"}, {"method": "generalised_alpha", "rho_inf": 0.4}])
@pytest.mark.parametrize("name", ALONE)
def test_gradients_are_those_of_whole_runs(name, options):
    model = ALONE[name]
    names = lengths_of(model)
    # Sweeps of portable packs have no derivatives by lengths, so that other models are used.
    if machine()[0] != "no wide registers":
        found = [parameter.length_of for parameter in resolved(model, names, by_adjoint=True)]
        assert found == list(range(len(names)))
    # The last step is shorter than the others.
    given = {"t_end": 0.031, "dt": 2e-3} | begin(model) | options | TIGHT
    objective = objective_for((17, model.n))
    gradient = lissom.sensitivity(model, parameters=names, objective=objective, **given).gradient

    def value(name, change):
        run = lissom.simulate(model_with(model, {name: value_of(model, name) + change}), **given)
        return objective(run.t, run.q, run.v)[0]

    for parameter, found in zip(names, gradient, strict=True):
        step = STEP * value_of(model, parameter)
        expected = sum(weight * value(parameter, k * step) for k, weight in WEIGHTS.items()) / step
        assert abs(found - expected) < 1e-7 * np.abs(gradient).max()


@pytest.mark.parametrize("options", [{}, {"rtol": 1e-3}])
def test_steps_that_are_solved_loosely(options):
    # The unsolved residual of a step also depends on the length, and the derivative includes that.
    model = ALONE["in space"]
    given = {"t_end": 0.03, "dt": 2e-3, "parameters": lengths_of(model)} | begin(model) | options
    assert_adjoint_is_forward(model, given, rtol=1e-8)


def test_stages_of_radau():
    model = ALONE["tree"]
    given = {"t_end": 0.05, "method": "radau", "rtol": 1e-6, "parameters": lengths_of(model)} | begin(model)
    assert_adjoint_is_forward(model, given, rtol=1e-7)


NOT_ALONE = {
    "load inside": rod(loads=[lissom.Load(**LOAD, at=0.25)]),
    "load at the place where the segment ends": rod(loads=[lissom.Load(**LOAD, at=0.3)]),
    "load along a part": rod(loads=[lissom.Load(force=(0.0, 0.2, -0.1), along=(0.0, 0.3))]),
    "support": rod(supports=[lissom.Support(stiffness=(10, 10, 10))]),
    "tendon to a place": rod(actuators=[lissom.Tendon("pull", along(along=(0.0, 0.4)), tension=2.0)]),
    "tendon that comes nearer": rod(
        actuators=[
            lissom.Tendon("pull", [lissom.Along(offset=([0.008, 0.004], 0.0))], tension=2.0),
        ]
    ),
    "tendon that stretches": rod(
        actuators=[lissom.Tendon("pull", along(), length=0.49, stiffness=1e3)],
    ),
    "tendon with friction": rod(actuators=[lissom.Tendon("pull", along(), tension=2.0, friction=0.2)]),
    "fluid": rod(fluid=lissom.Fluid(1000.0)),
}


@pytest.mark.parametrize("name", NOT_ALONE)
def test_lengths_that_more_depends_on_take_other_models(name):
    model = NOT_ALONE[name]
    names = ["segments[0].length", "segments[1].length"]
    assert all(parameter.length_of is None for parameter in resolved(model, names, by_adjoint=True))
    given = {"t_end": 0.01, "dt": 2e-3, "parameters": names} | begin(model)
    if "friction" in name:
        given["method"] = "generalised_alpha"
    assert_adjoint_is_forward(model, given, rtol=1e-9)


def test_a_length_with_a_table_is_refused_before_the_run():
    curved = np.tile([0.0, 2.0, 0.0, 1.0, 0.0, 0.0], (3, 1))
    table = [0.0, 0.1, 0.3], curved * [[1.0], [2.0], [0.5]]
    model = rod(segment(reference_strain=table))
    with pytest.raises(ValueError, match="can change by itself"):
        lissom.sensitivity(model, 0.01, ["segments[0].length"], objective=objective_for((2, model.n)))
