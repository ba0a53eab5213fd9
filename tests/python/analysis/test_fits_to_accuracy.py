"""`fit` and `sensitivity` with `method="auto"`: chosen once, and checked with the fitted values."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lissom
from lissom.analysis import accurate
from lissom.analysis.accurate import AccurateRuns

LENGTH, MASS, RADIUS = 0.5, 0.8, 0.01
T = np.linspace(0.0, 4.0, 81)
TORQUE = 0.4 * np.sign(np.sin(np.arange(20)))
STEP = 0.2


def arm(stiffness=3.0, damping=0.02):
    """A stiff rod on a hinge with a spring and a motor."""
    joint = lissom.Revolute((0, 1, 0), stiffness=stiffness, damping=damping)
    rod = [lissom.Segment(LENGTH, RADIUS, 1e9, 4e8, MASS / (np.pi * RADIUS**2 * LENGTH), {})]
    motor = lissom.Motor("arm", torque=lissom.Input("torque"))
    return lissom.Robot([lissom.Link("arm", joint=joint, rod=rod)], gravity=(9.81, 0, 0), actuators=[motor])


def measured(stiffness, damping, times=T, start=0.9):
    """Places of the mass under the torques, by equations of this test."""
    inertia = MASS * (LENGTH**2 / 3 + RADIUS**2 / 4)
    weight = MASS * 9.81 * LENGTH / 2
    state, found = np.array([start, 0.0]), []
    for i, torque in enumerate(TORQUE):

        def rhs(t, y, torque=torque):
            return [y[1], (torque - stiffness * y[0] - damping * y[1] - weight * np.sin(y[0])) / inertia]

        begin, end = STEP * i, STEP * (i + 1)
        here = times[(times > begin + 1e-9) & (times < end + 1e-9)]
        solution = solve_ivp(rhs, (begin, end), state, "DOP853", rtol=1e-12, atol=1e-13, dense_output=True)
        found.append(solution.sol(here)[0])
        state = solution.y[:, -1]
    angle = np.concatenate(found)
    return LENGTH * np.stack([np.cos(angle), 0.0 * angle, -np.sin(angle)], axis=1)


GUESS = {"links[0].joint.stiffness": (0.5, 2.0, 20.0), "links[0].joint.damping": (1e-3, 0.05, 1.0)}


def fitted(data, guess=GUESS, **options):
    robot = arm(guess["links[0].joint.stiffness"][1])
    u = {"u": TORQUE[:, None], "control_step": STEP, "q0": [0.9]}
    return lissom.fit(robot, data, guess, **u, **options)


@pytest.mark.parametrize("method", ["auto", lissom.methods.Auto(rtol=1e-6)])
def test_fitted_values_are_as_accurate_as_the_runs(method):
    options = {"method": method} | ({"rtol": 1e-6} if method == "auto" else {})
    found = fitted((T[1:], measured(3.0, 0.02)), **options)
    assert found.success
    np.testing.assert_allclose(found.values, [3.0, 0.02], rtol=1e-4)
    assert "The time error with the fitted values is" in found.message
    assert "1e-6 was asked for" in found.message.replace("1e-06", "1e-6")
    by_steps = fitted((T[1:], measured(3.0, 0.02)))
    assert np.abs(by_steps.values - [3.0, 0.02]).max() > 100 * np.abs(found.values - [3.0, 0.02]).max()


def test_the_objective_is_smooth():
    """Evaluations at close values change as their derivatives say: steps do not jump with the values."""
    robot = arm()
    runs = [
        lissom.sensitivity(
            arm(3.0 * (1 + eps)), 4.0, ["links[0].joint.stiffness"], q0=[0.9], method="auto", rtol=1e-5
        )
        for eps in (-1e-4, 0.0, 1e-4)
    ]
    ends = np.array([run.q[-1, 0] for run in runs])
    assert (ends[2] - ends[0]) / 6e-4 == pytest.approx(runs[1].dq[-1, 0, 0], rel=1e-3)
    assert robot.n == 1


def test_a_sensitivity_is_as_accurate_as_asked():
    robot = arm()
    found = lissom.sensitivity(
        robot,
        4.0,
        ["links[0].joint.stiffness"],
        q0=[0.9],
        u=TORQUE[:, None],
        control_step=STEP,
        method="auto",
        rtol=1e-7,
    )
    right = measured(3.0, 0.02)
    positions, _ = found.position(link="arm", t=T[1:])
    assert np.abs(positions - right).max() < 1e-7 * LENGTH
    moved = (measured(3.0 + 1e-4, 0.02) - measured(3.0 - 1e-4, 0.02)) / 2e-4
    _, derivatives = found.position(link="arm", t=T[1:])
    np.testing.assert_allclose(derivatives[..., 0], moved, atol=1e-4 * np.abs(moved).max())


def test_values_far_from_the_first_ones_are_doubted():
    # The spring of the first values holds the rod; with a soft one it stands upside down, and falls.
    start = {"q0": [3.1], "dt": 0.05}
    runs = AccurateRuns(arm(1e3), 8.0, start, lissom.methods.Auto(rtol=1e-3)).chosen()
    sentence, doubt = runs.verdict(arm(10.0, 0.0), q0=[3.1])
    assert "1e-03 was asked for" in sentence
    assert not doubt
    _, doubt = runs.verdict(arm(0.01, 0.0), q0=[3.1])
    assert doubt.startswith(
        "The steps were chosen for the first values; with the fitted ones the time error is"
    )


def test_a_fit_tells_its_doubt(monkeypatch):
    monkeypatch.setattr(accurate, "MARGIN", 1e9)
    monkeypatch.setattr(accurate, "TRIED", (1e4,))
    with pytest.warns(lissom.AccuracyWarning, match="The steps were chosen for the first values"):
        found = fitted((T[1:], measured(3.0, 0.02)), method="auto", rtol=1e-6)
    assert "fit again from these values" in found.message


@pytest.mark.parametrize("name", ["atol", "predictor"])
def test_auto_chooses_the_rest(name):
    value = 1e-6 if name == "atol" else "zero"
    with pytest.raises(ValueError, match=f'{name}: the method "auto" takes `rtol`'):
        fitted((T[1:], measured(3.0, 0.02)), method="auto", **{name: value})
    with pytest.raises(ValueError, match=f'{name}: the method "auto" takes `rtol`'):
        lissom.sensitivity(arm(), 1.0, ["q0"], method="auto", **{name: value})
    with pytest.raises(ValueError, match="rtol"):
        lissom.sensitivity(arm(), 1.0, ["q0"], method="auto", rtol=1.0)
