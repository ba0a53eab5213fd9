"""`simulate` and `sweep` take inputs that are held; controllers are asked for by their signature."""

import numpy as np
import pytest

import lissom


@pytest.fixture(scope="module")
def rod():
    return pulled(0.0)


def pulled(default):
    soft = lissom.Segment(
        0.15, 0.006, 250e3, poisson_ratio=0.49, density=1070, modes={"bend_y": 2}, retardation_time=0.02
    )
    path = [lissom.Along(offset=(0.0, 0.004))]
    pull = lissom.Tendon("pull", path, tension=lissom.Input("pull", default))
    return lissom.Rod([soft], gravity=(0, 0, 0), actuators=[pull])


@pytest.mark.parametrize("method", ["newmark", "radau", "rk45", "quasi_static"])
@pytest.mark.parametrize("u", [[0.3], {"pull": 0.3}])
def test_held_inputs_are_those_by_default(rod, method, u):
    held = lissom.simulate(rod, 0.1, u=u, method=method)
    by_default = lissom.simulate(pulled(0.3), 0.1, method=method)
    # What Newton's iterations leave depends on the forces at the start.
    np.testing.assert_allclose(held.q, by_default.q, rtol=1e-5, atol=1e-7)
    np.testing.assert_array_equal(held.u, by_default.u)


def test_a_controller_begins_with_them(rod):
    found = lissom.simulate(rod, 0.05, u=[0.3], control=lambda t, q, v: {})
    np.testing.assert_array_equal(found.u, np.full((len(found.t), 1), 0.3))


def test_functions_go_to_control(rod):
    with pytest.raises(TypeError, match=r"u: got a function, .* write `control=lambda t, q, v: u\(t\)`"):
        lissom.simulate(rod, 0.1, u=lambda t: [t])


def test_auto_takes_them(rod):
    held = lissom.simulate(rod, 0.1, u=[0.3], method="auto", rtol=1e-6)
    by_default = lissom.simulate(pulled(0.3), 0.1, method="auto", rtol=1e-6)
    apart = np.abs(rod.pose(held.q)[:, :3, 3] - rod.pose(by_default.q)[:, :3, 3]).max()
    assert apart < 2e-6 * 0.15
    assert held.stats.space_error == pytest.approx(by_default.stats.space_error, rel=0.1)
    assert held.stats.steps <= 1.5 * by_default.stats.steps


@pytest.mark.parametrize("control", [lambda t: [t], lambda: [0.3], lambda t, q: [t], lambda t, q, v, u: [t]])
def test_controllers_of_other_arguments_are_told_theirs(rod, control):
    with pytest.raises(TypeError, match=r"control: is called as control\(t, q, v\), but takes \("):
        lissom.simulate(rod, 0.1, control=control)


@pytest.mark.parametrize(
    "control", [lambda *a: [0.3], lambda t, q, v, gain=1.0: [0.3], lambda t, q=0, v=0: [0.3]]
)
def test_controllers_that_can_be_called_are(rod, control):
    assert lissom.simulate(rod, 0.05, control=control).success


def test_sweeps_hold_inputs_too(rod):
    pytest.importorskip("xarray")
    radii = [0.005, 0.006]
    found = lissom.sweep(rod, {"segments[0].radius": radii}, t_end=0.1, u={"pull": 0.3})
    assert found.success.all()
    np.testing.assert_array_equal(found.q[1], lissom.simulate(rod, 0.1, u=[0.3]).q[-1])


def test_sweeps_measure_with_them(rod):
    pytest.importorskip("xarray")
    found = lissom.sweep(
        rod, {"segments[0].radius": [0.006]}, t_end=0.05, u=[0.3], measure=lambda run: run.u[-1, 0]
    )
    assert float(found.measured[0]) == 0.3
