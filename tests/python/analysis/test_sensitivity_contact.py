"""Derivatives of runs with impacts and friction compared with differences of complete runs."""

import numpy as np
import pytest

import lissom
from lissom.analysis.parameters import START, model_with, value_of
from reference.radau import run

#: Accuracy of the differences, relative to the largest.
ACCURACY = 1e-4

FLOOR = lissom.HalfSpace((0, 0, 0), (0, 0, 1))


def thrown():
    """A ball that bounces, slides and begins to roll."""
    body = lissom.Body(0.1, inertia=[4e-5] * 3)
    contact = lissom.Contact(
        lissom.Ball("ball", 0.03), FLOOR, stiffness=5e3, dissipation=0.2, friction=0.4, slip_velocity=0.02
    )
    link = lissom.Link("ball", body=body, joint=lissom.Planar((0, 1, 0)))
    # Along x, and down along the second axis of the joint.
    return lissom.Robot([link], contacts=[contact]), [0.0, -0.08, 0.0], [0.8, 0.0, 0.0]


def fallen():
    """A rod that falls onto the floor, where a part of it rests."""
    finger = lissom.Segment(0.3, 0.01, 2e5, 8e4, 1100, modes={"bend_y": 3}, retardation_time=0.05)
    floor = lissom.HalfSpace((0, 0, -0.05), (0, 0, 1))
    contact = lissom.Contact(
        "finger", floor, stiffness=2e4, dissipation=0.5, friction=0.3, slip_velocity=0.05
    )
    robot = lissom.Robot([lissom.Link("finger", rod=[finger])], contacts=[contact])
    return robot, [0.0] * 3, [0.0] * 3


def draped():
    """A stiff thin rod that falls onto the floor, whose contact is as stiff as its loads need."""
    wire = lissom.Segment(0.5, 1e-3, 5e9, 2e9, 1500, modes={"bend_y": 3}, retardation_time=0.02)
    contact = lissom.Contact("wire", lissom.HalfSpace((0, 0, -0.03)), friction=0.3, slip_velocity=0.05)
    robot = lissom.Robot([lissom.Link("wire", rod=[wire])], contacts=[contact])
    assert robot._contact_stiffness()[0] < 0.1 * np.pi / 4 * 5e9
    return robot, [0.0] * 3, [0.0] * 3


OF_BALL = [
    "link[0].body.mass",
    "contact[0].stiffness",
    "contact[0].friction",
    "gravity[2]",
    "q0[1]",
    "v0[0]",
]
OF_ROD = ["link[0].rod.segment[0].young_modulus", "link[0].rod.segment[0].length", "contact[0].friction"]
OF_ROD += ["contact[0].b.point[2]", "gravity[2]", "v0[1]"]
CASES = [(thrown, 0.3, name) for name in OF_BALL] + [(fallen, 0.25, name) for name in OF_ROD]
# They change the stiffness, too.
OF_WIRE = [f"link[0].rod.segment[0].{name}" for name in ("young_modulus", "radius", "length", "density")]
CASES += [(draped, 0.15, name) for name in [*OF_WIRE, "gravity[2]"]]


def moved(model, q0, v0, name, change):
    """The model and its initial state with another value of one parameter."""
    begin = {"q0": np.array(q0), "v0": np.array(v0)}
    if known := START.fullmatch(name):
        begin[known["which"]][int(known["index"])] += change
        return model, begin
    return model_with(model, {name: value_of(model, name) + change}), begin


@pytest.mark.slow
@pytest.mark.parametrize(("make", "t_end", "name"), CASES)
def test_derivatives_go_through_contact(make, t_end, name):
    """Runs with the same steps in NumPy. Forces have kinks, which no stage may pass in a difference."""
    model, q0, v0 = make()
    options = {"method": "radau", "rtol": 1e-7, "atol": 1e-9}
    found = lissom.sensitivity(model, t_end, [name], q0=q0, v0=v0, **options)
    events = lissom.simulate(model, t_end, q0=q0, v0=v0, t_eval="steps", **options).contact_events()
    assert events, "something has touched"
    step = 1e-7 * (0.1 if START.fullmatch(name) else abs(value_of(model, name)))

    def states_of(change):
        other, begin = moved(model, q0, v0, name, change)
        return run(other, found.t, begin["q0"], begin["v0"])

    ahead, behind = states_of(step), states_of(-step)
    for derivative, more, less in zip((found.dq, found.dv), ahead, behind, strict=True):
        expected = (more - less) / (2 * step)
        assert np.abs(derivative[..., 0] - expected).max() < ACCURACY * np.abs(expected).max()


def test_they_approach_those_of_the_motion():
    """Steps are fixed although kinks move within them; tighter tolerances reduce the effect."""
    model, q0, v0 = thrown()

    def derivative(rtol):
        options = {"method": "radau", "rtol": rtol, "atol": 1e-2 * rtol}
        found = lissom.sensitivity(model, 0.3, ["gravity[2]"], q0=q0, v0=v0, **options)
        return np.concatenate([found.dq[-1, :, 0], found.dv[-1, :, 0]])

    def end(change):
        other, begin = moved(model, q0, v0, "gravity[2]", change)
        result = lissom.simulate(
            other, 0.3, method="radau", rtol=1e-12, atol=1e-14, t_eval=[0.0, 0.3], **begin
        )
        return np.concatenate([result.q[-1], result.v[-1]])

    expected = (end(1e-4) - end(-1e-4)) / 2e-4
    errors = [np.abs(derivative(rtol) - expected).max() for rtol in (1e-6, 1e-9, 1e-12)]
    assert errors[0] < 5e-2 * np.abs(expected).max()
    assert errors[2] < 2e-5 * np.abs(expected).max()
    assert errors[0] > 3 * errors[1] > 9 * errors[2]


@pytest.mark.parametrize("make", [thrown, fallen])
def test_adjoint_is_forward(make):
    model, q0, v0 = make()
    names = ["gravity[2]", "contact[0].friction", "contact[0].stiffness", "q0", "v0"]
    options = {"q0": q0, "v0": v0, "method": "radau", "rtol": 1e-6}
    forward = lissom.sensitivity(model, 0.2, names, **options)
    on_q, on_v = np.random.default_rng(4).standard_normal((2, *forward.q.shape))

    def objective(t, q, v):
        return 0.0, on_q, on_v

    adjoint = lissom.sensitivity(model, 0.2, names, objective=objective, **options)
    expected = np.einsum("mn,mnp->p", on_q, forward.dq) + np.einsum("mn,mnp->p", on_v, forward.dv)
    np.testing.assert_allclose(adjoint.gradient, expected, rtol=1e-8)


def test_the_newmark_family_is_refused_with_the_reason():
    model, q0, v0 = thrown()
    with pytest.raises(ValueError, match='expected method "radau"'):
        lissom.sensitivity(model, 0.1, ["gravity[2]"], q0=q0, v0=v0)
