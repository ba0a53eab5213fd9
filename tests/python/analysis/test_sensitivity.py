"""Derivatives of runs compared with central differences of complete runs, and forward with adjoint."""

import numpy as np
import pytest

import lissom
from lissom.analysis.parameters import model_with, value_of

TIGHT = {"rtol": 1e-13, "atol": 1e-13}


def arm(**changes):
    options = {"modes": {"bend_y": 2, "stretch": 1}, "retardation_time": 0.02} | changes
    lower = lissom.Segment(0.3, 0.012, 4e5, 1.5e5, 1100, **options)
    upper = lissom.Segment(0.2, 0.009, 3e5, 1e5, 1000, **options)
    return lissom.Rod([lower, upper], gravity=(0.3, 0.0, -9.81), tip_mass=0.01)


def jointed():
    finger = lissom.Segment(0.2, 0.01, 3e5, 1.5e5, 1100, modes={"bend_y": 2}, retardation_time=0.02)
    rod = [finger]
    return lissom.Robot(
        [
            lissom.Link("upper", rod=rod, joint=lissom.Revolute((0, 1, 0), stiffness=0.3, damping=0.01)),
            lissom.Link("lower", rod=rod, parent="upper", joint=lissom.Revolute((0, 1, 0), damping=0.002)),
        ]
    )


NAMES = [
    "segments[0].young_modulus",
    "segments[1].radius",
    "segments[0].length",
    "segments[1].density",
    "segments[0].retardation_time",
    "gravity[2]",
    "gravity[0]",
    "tip_mass",
    "q0[1]",
    "v0[3]",
]


def by_differences(model, name, states, **options):
    """Fourth-order central differences of complete runs; the step balances truncation and rounding."""
    from lissom.analysis.parameters import START, model_with, value_of

    start = START.fullmatch(name)
    value = 0.0 if start else value_of(model, name)
    step = 1e-3 * (abs(value) or 1.0)

    def run(change):
        moved, begin = model, {}
        if start:
            begin[start["which"]] = np.zeros(model.n)
            begin[start["which"]][int(start["index"])] = change
        else:
            moved = model_with(model, {name: value + change})
        result = lissom.simulate(moved, **states, **begin, **options, **TIGHT)
        places = np.array([moved.pose(q, link=moved.links[-1].name)[:3, 3] for q in result.q])
        return result.q, result.v, places

    nodes = {k: run(k * step) for k in (-2, -1, 1, 2)}
    weights = {-2: 1 / 12, -1: -2 / 3, 1: 2 / 3, 2: -1 / 12}
    return [sum(weights[k] * nodes[k][i] for k in nodes) / step for i in range(3)]


@pytest.mark.parametrize(
    "options",
    [
        {"method": "newmark"},
        {"method": "newmark", "beta": 0.3025, "gamma": 0.6},
        {"method": "generalised_alpha", "rho_inf": 0.6},
        {"method": "hht", "alpha": -0.2},
    ],
)
@pytest.mark.parametrize("name", NAMES)
def test_forward_derivatives_are_those_of_whole_runs(name, options):
    # The last step is shorter than the others.
    span = {"t_end": 0.123, "dt": 0.01}
    found = lissom.sensitivity(arm(), 0.123, [name], dt=0.01, **options, **TIGHT)
    q, v, places = by_differences(arm(), name, span, **options)
    for derivative, expected in ((found.dq, q), (found.dv, v), (found.position()[1], places)):
        assert np.abs(derivative[..., 0] - expected).max() < 1e-7 * np.abs(expected).max()


@pytest.mark.parametrize(
    "name", ["link[0].joint.stiffness", "link[1].joint.damping", "link[0].rod.segment[0].young_modulus"]
)
def test_robots_with_joints(name):
    found = lissom.sensitivity(jointed(), 0.2, [name], **TIGHT)
    q, v, places = by_differences(jointed(), name, {"t_end": 0.2})
    for derivative, expected in ((found.dq, q), (found.dv, v), (found.position()[1], places)):
        assert np.abs(derivative[..., 0] - expected).max() < 1e-7 * np.abs(expected).max()


@pytest.mark.parametrize("options", [{}, {"method": "generalised_alpha", "rho_inf": 0.3}, {"method": "hht"}])
def test_adjoint_is_forward(options):
    rng = np.random.default_rng(4)
    names = [*NAMES[:8], "q0", "v0"]
    forward = lissom.sensitivity(arm(), 0.123, names, **options)
    on_q, on_v = rng.standard_normal((2, *forward.q.shape))

    def objective(t, q, v):
        assert t.shape == (len(q),)
        return float((on_q * q).sum() + (on_v * v).sum()), on_q, on_v

    adjoint = lissom.sensitivity(arm(), 0.123, names, objective=objective, **options)
    expected = np.einsum("mn,mnp->p", on_q, forward.dq) + np.einsum("mn,mnp->p", on_v, forward.dv)
    assert adjoint.value == objective(forward.t, forward.q, forward.v)[0]
    np.testing.assert_allclose(adjoint.gradient, expected, rtol=1e-9)
    assert adjoint.names == forward.names
    assert adjoint.dq is None


def test_positions_between_steps():
    found = lissom.sensitivity(arm(), 0.1, ["gravity[2]", "segments[0].length"], dt=0.005, **TIGHT)
    at_steps, derivative = found.position()
    again, derivative_again = found.position(t=found.t)
    np.testing.assert_allclose(again, at_steps, atol=1e-14)
    np.testing.assert_allclose(derivative_again, derivative, atol=1e-13)


def test_loads_in_time():
    load = lissom.Load(force=lissom.Harmonic((0, 0, 0.05), 3.0), at=0.5)
    rod = lissom.Rod(arm().segments, loads=[load])
    found = lissom.sensitivity(rod, 0.2, ["segments[0].young_modulus"], **TIGHT)
    q, _, _ = by_differences(rod, "segments[0].young_modulus", {"t_end": 0.2})
    assert np.abs(found.dq[..., 0] - q).max() < 1e-7 * np.abs(q).max()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        (["segments[0].young_modulos"], "did you mean 'young_modulus'"),
        (["segments[7].radius"], "2 entries"),
        (["q0[9]"], "an index below 6"),
        (["q0", "q0[1]"], "is listed twice"),
        (["gravity[2]", "gravity[2]"], "is listed twice"),
        (["segments[0].radius", "rod[0].segment[0].radius"], "first as 'segments[0].radius'"),
        (["segments[0].length.x"], "segments[0].length has no parts"),
        (
            ["segments.length"],
            "segments has 2 entries, expected the number of one, such as 'segments[0].length'",
        ),
        ([], "at least one"),
        (["gravity"], "a finite number"),
        (["rod[1].segment[0].radius"], "rod[1]: the model is one rod, expected rod[0]"),
    ],
)
def test_names_are_refused(parameters, message):
    with pytest.raises(ValueError, match=message.replace("[", r"\[")):
        lissom.sensitivity(arm(), 0.1, parameters)


def test_what_nothing_depends_on_is_refused():
    # A planar rod with stretch and bending has no torsion, and does not depend on its shear modulus.
    with pytest.raises(ValueError, match=r"nothing depends on 'segments\[0\]\.shear_modulus'"):
        lissom.sensitivity(arm(), 0.1, ["segments[0].shear_modulus"])


def test_methods_and_models_are_refused():
    with pytest.raises(ValueError, match="rk45"):
        lissom.sensitivity(arm(), 0.1, ["q0"], method="rk45")
    with pytest.raises(ValueError, match="rho_inf"):
        lissom.sensitivity(arm(), 0.1, ["q0"], method="radau", rho_inf=0.8)
    with pytest.raises(TypeError, match="adaptive"):
        lissom.sensitivity(arm(), 0.1, ["q0"], adaptive=True)
    looped = lissom.Robot(
        [lissom.Link("a", rod=arm().segments)], loops=[lissom.Loop("a", None, lissom.Distance(0.4))]
    )
    with pytest.raises(ValueError, match="closed loops"):
        lissom.sensitivity(looped, 0.1, ["q0"])
    held = lissom.Tendon("held", [lissom.Along(offset=(0, 0.006))], length=0.499)
    with pytest.raises(
        ValueError, match="tendons that do not stretch, whose runs are not differentiated yet"
    ):
        lissom.sensitivity(lissom.Rod(arm().segments, actuators=[held]), 0.1, ["q0"])


@pytest.mark.parametrize("name", ["t_end", "t0", "dt"])
def test_times_are_numbers(name):
    for value, kind, message in (
        ("soon", TypeError, "number"),
        (np.nan, ValueError, "NaN"),
        ([0.1], ValueError, ""),
    ):
        arguments = {"t_end": 0.1, "parameters": ["q0"]} | {name: value}
        with pytest.raises(kind, match=f"^{name}: .*{message}"):
            lissom.sensitivity(arm(), **arguments)


def stopped():
    """A rod on a joint that swings against a stop."""
    finger = lissom.Segment(0.2, 0.01, 3e5, 1.2e5, 1100, modes={"bend_y": 2}, retardation_time=0.02)
    joint = lissom.Revolute((0, 1, 0), limits=(-3.0, 1.5), limit_stiffness=5.0, damping=0.002)
    return lissom.Robot([lissom.Link("a", rod=[finger], joint=joint)])


@pytest.mark.parametrize("key", ["limit_stiffness", "limits[1]", "limits[0]", "damping"])
def test_what_acts_in_some_states_only(key):
    """Stops are inactive in the states that test whether forces are affine."""
    name = f"link[0].joint.{key}"
    found = lissom.sensitivity(stopped(), 0.6, [name], dt=0.005, **TIGHT)
    assert found.q[:, 0].max() > 1.5
    # Small enough that no step begins on the other side of the stop.
    value = value_of(stopped(), name)
    step = 1e-5 * abs(value)

    def end(change):
        return lissom.simulate(model_with(stopped(), {name: value + change}), 0.6, dt=0.005, **TIGHT).q[-1]

    expected = (end(step) - end(-step)) / (2 * step)
    assert np.abs(found.dq[-1, :, 0] - expected).max() <= 1e-5 * np.abs(expected).max() + 1e-15


def floating():
    """A floating rod, with a body on a spherical joint at its tip: spatial rotations of both."""
    segment = lissom.Segment(
        0.3, 0.012, 4e5, 1.5e5, 1100, modes={"bend_y": 2, "bend_z": 1}, retardation_time=0.02
    )
    head = lissom.Body(0.05, inertia=[1e-4, 2e-4, 2.5e-4], centre=(0.03, 0.01, 0.0))
    links = [
        lissom.Link("rod", rod=[segment], joint=lissom.Free()),
        lissom.Link("head", body=head, joint=lissom.Spherical(), parent="rod"),
    ]
    return lissom.Robot(links)


@pytest.mark.parametrize("options", [{}, {"method": "generalised_alpha", "rho_inf": 0.6}])
@pytest.mark.parametrize(
    "name", ["link[0].rod.segment[0].young_modulus", "bodies", "q0[4]", "v0[3]", "v0[10]"]
)
def test_rotations_in_space(name, options):
    model = floating()
    name = "link[1].body.mass" if name == "bodies" else name
    start = 0.5 * np.random.default_rng(8).standard_normal((2, model.n))
    start[1, 3:6] *= 4.0
    span = {"t_end": 0.1, "dt": 0.005, "q0": start[0], "v0": start[1]}
    found = lissom.sensitivity(model, parameters=[name], **span, **options, **TIGHT)
    which, index = (name[:2], int(name[3:-1])) if name[1] == "0" else (None, 0)

    def run(change):
        begin = {"q0": start[0].copy(), "v0": start[1].copy()}
        moved = model
        if which:
            begin[which][index] += change
        else:
            from lissom.analysis.parameters import model_with, value_of

            moved = model_with(model, {name: value_of(model, name) * (1.0 + change)})
        return lissom.simulate(moved, **(span | begin), **options, **TIGHT).q

    step = 1e-3
    expected = (run(-2 * step) - 8 * run(-step) + 8 * run(step) - run(2 * step)) / (12 * step)
    if not which:
        from lissom.analysis.parameters import value_of

        expected /= value_of(model, name)
    assert np.abs(found.dq[..., 0] - expected).max() < 1e-7 * np.abs(expected).max()


def test_runs_are_differentiated_up_to_half_a_turn():
    model = floating()
    v0 = np.zeros(model.n)
    v0[3] = 20.0
    assert lissom.sensitivity(model, 0.15, ["q0"], v0=v0).dq.shape == (16, model.n, model.n)
    with pytest.raises(lissom.LissomError, match=r"passes half a turn at t = 0\.1[56]"):
        lissom.sensitivity(model, 0.3, ["q0"], v0=v0)
    with pytest.raises(lissom.LissomError, match="half a turn"):
        lissom.sensitivity(model, 0.3, ["q0"], v0=v0, objective=lambda t, q, v: (0.0, q, v))


def test_objectives_are_checked():
    with pytest.raises(TypeError, match=r"expected \(value"):
        lissom.sensitivity(arm(), 0.1, ["q0"], objective=lambda t, q, v: 1.0)
    with pytest.raises(ValueError, match="dvalue/dv has shape"):
        lissom.sensitivity(arm(), 0.1, ["q0"], objective=lambda t, q, v: (1.0, q, v[:1]))


def test_failed_runs_say_why():
    with pytest.raises(lissom.LissomError, match="did not come to its end"):
        lissom.sensitivity(arm(), 0.1, ["q0"], max_steps=2)
