"""Runs as functions in PyTorch, checked with its own gradient checker: `make test-torch`."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import lissom

torch = pytest.importorskip("torch", reason="PyTorch is large: only `make test-torch` installs it")

import lissom.torch  # noqa: E402

TIGHT = {"rtol": 1e-13, "atol": 1e-13}
NAMES = ["gravity[2]", "segments[0].length"]
Q0, V0 = np.array([0.3, -0.2]), np.array([0.5, 0.1])


def finger():
    soft = lissom.Segment(0.3, 0.01, 3e5, 1.2e5, 1100, modes={"bend_y": 2}, retardation_time=0.02)
    return lissom.Rod([soft])


def leaf(x):
    return torch.tensor(np.asarray(x), dtype=torch.float64, requires_grad=True)


def test_gradients_pass_the_checker():
    run = lissom.torch.simulation(finger(), 0.3, NAMES, t=[0.1, 0.3], **TIGHT)

    def states(gravity, length, q0, v0):
        return run(dict(zip(NAMES, (gravity, length), strict=True)), q0, v0)[1:]

    assert torch.autograd.gradcheck(states, (leaf(-9.81), leaf(0.3), leaf(Q0), leaf(V0)), atol=1e-6)


def test_gradients_of_a_batch_pass_the_checker():
    run = lissom.torch.simulation(finger(), 0.1, ["gravity[2]"], t=[0.1], **TIGHT)

    def states(gravity, q0):
        return run({"gravity[2]": gravity}, q0, V0)[1:]

    assert torch.autograd.gradcheck(states, (leaf([-9.81, 2.0]), leaf([Q0, -Q0])), atol=1e-6)


def test_states_are_those_of_simulate():
    run = lissom.torch.simulation(finger(), 0.3)
    t, q, v = run({}, [Q0.tolist(), (-Q0).tolist()], V0)
    assert (t.shape, q.shape) == ((31,), (2, 31, 2))
    for i, q0 in enumerate((Q0, -Q0)):
        plain = lissom.simulate(finger(), 0.3, q0=q0, v0=V0)
        assert_array_equal(q[i], plain.q)
        assert_array_equal(v[i], plain.v)


def test_a_run_that_fails_is_nan():
    q0 = leaf(Q0)
    q = lissom.torch.simulation(finger(), 0.2, t=[0.2], max_steps=3)({}, q0, V0)[1]
    assert torch.isnan(q).all()
    q.sum().backward()
    assert torch.isnan(q0.grad).all()


def test_calls_that_do_not_fit_are_refused():
    run = lissom.torch.simulation(finger(), 0.2, ["gravity[2]"])
    with pytest.raises(ValueError, match=r"expected torch\.float64"):
        run({"gravity[2]": torch.tensor(-1.0)}, Q0, V0)
    with pytest.raises(ValueError, match=r"q0: got shape \(3,\)"):
        run({"gravity[2]": -1.0}, np.zeros(3), V0)
    with pytest.raises(ValueError, match="broadcast"):
        run({"gravity[2]": [-1.0, 1.0, 2.0]}, [Q0.tolist(), Q0.tolist()], V0)
    with pytest.raises(ValueError, match="values: got"):
        run({}, Q0, V0)


def test_gradients_with_respect_to_inputs_pass_the_checker():
    soft = lissom.Segment(0.2, 0.01, 3e5, 1.5e5, 1100, modes={"bend_y": 1}, retardation_time=0.02)
    motor = lissom.Motor("finger", torque=lissom.Input("torque"))
    link = lissom.Link("finger", rod=[soft], joint=lissom.Revolute((0, 1, 0), damping=0.01))
    robot = lissom.Robot([link], actuators=[motor])
    run = lissom.torch.simulation(robot, 0.25, t=[0.1, 0.25], control_step=0.1, **TIGHT)
    u = np.array([[[0.02], [-0.03], [0.01]], [[0.0], [0.01], [0.0]]])

    def states(q0, u):
        return run({}, q0, np.zeros(2), u)[1:]

    assert torch.autograd.gradcheck(states, (leaf([0.1, 0.2]), leaf(u)), atol=1e-6)
    with pytest.raises(ValueError, match=r"u: got shape \(2, 2, 1\), expected \(\.\.\., 3, 1\)"):
        states(leaf([0.1, 0.2]), leaf(u[:, :2]))
    with pytest.raises(ValueError, match="inputs and a control_step need each other"):
        run({}, np.zeros(2), np.zeros(2))
