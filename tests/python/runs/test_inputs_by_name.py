"""Inputs by their names in place of arrays, wherever rows or controllers take inputs."""

import re

import numpy as np
import pytest

import lissom
from lissom import sensors

SEGMENT = lissom.Segment(
    0.2, 0.01, 3e5, poisson_ratio=0.45, density=1100, modes={"bend_y": 3, "bend_z": 2}, retardation_time=0.02
)
PLACE = [lissom.Along(offset=(0, 0.006))]
ACTUATORS = [
    lissom.Tendon("pull", PLACE, tension=lissom.Input("pull", 0.5)),
    lissom.Tendon("hold", PLACE, tension=lissom.Input("hold", 0.1)),
]
WIND = lissom.Load(force=lissom.Input("wind", (0.0, 0.01, 0.0)))


def rod(default=0.5):
    pull = lissom.Tendon("pull", PLACE, tension=lissom.Input("pull", default))
    return lissom.Rod([SEGMENT], actuators=[pull, ACTUATORS[1]], loads=[WIND])


def numbers(pull=0.5, hold=0.1, wind=(0.0, 0.01, 0.0), default=0.5):
    """The inputs in the order of the model."""
    given = {"pull": pull, "hold": hold} | {f"wind.{axis}": x for axis, x in zip("xyz", wind, strict=True)}
    return [given[name] for name in rod(default).inputs]


#: Rows by names, and the same as numbers.
ROWS = {
    "dicts": (
        [{"pull": 1.0}, {"hold": 0.4, "wind": (0.0, 0.0, 0.02)}],
        [numbers(pull=1.0), numbers(hold=0.4, wind=(0.0, 0.0, 0.02))],
    ),
    "a dict and an array": (
        ({"pull": 1.0}, numbers(hold=0.3)),
        [numbers(pull=1.0), numbers(hold=0.3)],
    ),
    "a dict of rows": (
        {"pull": [1.0, 2.0], "wind": [[0, 0, 0], [0, 0, 0.02]], "hold": 0.3},
        [numbers(1.0, 0.3, (0, 0, 0)), numbers(2.0, 0.3, (0, 0, 0.02))],
    ),
}


@pytest.mark.parametrize("kind", ROWS)
def test_rows_by_name_are_rows_of_numbers(kind):
    named, array = ROWS[kind]
    model = rod()
    by_name = lissom.simulate_many(model, 0.02, u=named)
    np.testing.assert_array_equal(by_name.q, lissom.simulate_many(model, 0.02, u=array).q)
    found = lissom.statics_many(model, named)
    np.testing.assert_array_equal(found.u, array)
    np.testing.assert_array_equal(found.q, lissom.statics_many(model, array).q)
    steps = [lissom.Simulations(model, 2, dt=0.01) for _ in range(2)]
    steps[0].step(named)
    steps[1].step(array)
    np.testing.assert_array_equal(steps[0].u, array)
    np.testing.assert_array_equal(steps[0].q, steps[1].q)
    zero = np.zeros((2, model.n))
    np.testing.assert_array_equal(
        model.base_wrench(found.q, zero, zero, u=named), model.base_wrench(found.q, zero, zero, u=array)
    )
    force = sensors.ActuatorForce(model, "pull")
    np.testing.assert_array_equal(
        force.measure([0.0, 0.0], found.q, zero, zero, u=named), [[row[3]] for row in np.array(array)]
    )


def test_one_dict_is_that_of_all_rows():
    model, starts = rod(), np.zeros((3, 5))
    found = lissom.statics_many(model, {"pull": 1.0}, starts)
    np.testing.assert_array_equal(found.u, [numbers(pull=1.0)] * 3)
    runs = lissom.simulate_many(model, 0.02, q0=starts, u={"pull": 1.0})
    np.testing.assert_array_equal(runs.q[2], lissom.simulate_many(model, 0.02, u=[numbers(pull=1.0)]).q[0])
    assert len(lissom.statics_many(model, {"pull": 1.0})) == 1


def test_what_a_dict_leaves_out_is_that_of_the_model_of_its_row():
    models = [rod(0.5), rod(0.9)]
    for u in ({"hold": 0.3}, [{"hold": 0.3}, {"hold": 0.3}], {"hold": [0.3, 0.3]}):
        found = lissom.statics_many(models, u)
        np.testing.assert_array_equal(found.u, [numbers(0.5, 0.3), numbers(0.9, 0.3)])
        runs = lissom.simulate_many(models, 0.02, u=u)
        np.testing.assert_array_equal(runs.q, lissom.simulate_many(models, 0.02, u=found.u).q)
    np.testing.assert_array_equal(lissom.statics_many(models).u, [numbers(0.5), numbers(0.9)])


def test_control_steps_of_rows_by_name():
    model = rod()
    pulls = np.array([[0.1, 0.2], [0.3, 0.4]])
    array = [[numbers(pull) for pull in row] for row in pulls]
    wanted = lissom.simulate_many(model, 0.02, u=array).q
    for u in (
        [[{"pull": pull} for pull in row] for row in pulls],
        {"pull": pulls},
        [{"pull": row} for row in pulls],
    ):
        np.testing.assert_array_equal(lissom.simulate_many(model, 0.02, u=u).q, wanted)


def test_steps_keep_what_a_dict_leaves_out():
    steps = lissom.Simulations(rod(), 2, dt=0.01)
    steps.step([numbers(hold=0.3), numbers(hold=0.4)])
    steps.step({"pull": 2.0})
    np.testing.assert_array_equal(steps.u, [numbers(2.0, 0.3), numbers(2.0, 0.4)])
    steps.step([{"pull": 1.0}, {}])
    np.testing.assert_array_equal(steps.u, [numbers(1.0, 0.3), numbers(2.0, 0.4)])


def test_a_controller_may_return_names():
    """Inputs that it leaves out stay as they are."""
    model = rod()
    by_name = lissom.simulate(
        model, 0.04, control=lambda t, q, v: {"pull": t} if t < 0.02 else {"hold": 0.3}, control_step=0.01
    )
    array = lissom.simulate(
        model,
        0.04,
        control=lambda t, q, v: numbers(t) if t < 0.02 else numbers(0.01, 0.3),
        control_step=0.01,
    )
    np.testing.assert_array_equal(by_name.q, array.q)
    np.testing.assert_array_equal(by_name.u, array.u)
    with pytest.raises(
        ValueError, match=r"control: got 'pul', expected one of the inputs: .*'pull'.* \(at t = 0\)"
    ):
        lissom.simulate(model, 0.04, control=lambda t, q, v: {"pul": 1.0})


def test_reports_and_peaks_of_equilibria_take_names(tmp_path):
    model = rod()
    found = lissom.statics(model, u={"pull": 1.0})
    peaks = [found.peaks(model, u=u) for u in ({"pull": 1.0}, numbers(1.0))]
    assert repr(peaks[0]) == repr(peaks[1])
    found.report(tmp_path / "report.html", model, u={"pull": 1.0})


def test_measured_inputs_by_name():
    model = rod()
    pulls = [{"pull": pull} for pull in (0.2, 0.6, 1.0)]
    tips = model.pose(lissom.statics_many(model, pulls).q)[:, :3, 3]
    guess = {"segments[0].young_modulus": 2e5}
    frequencies = lissom.modes(model, lissom.statics(model, u=pulls[2]).q, u=pulls[2]).frequency[:2]
    # A recording that goes on after the last measured place.
    steps = [{"pull": 0.1 * i} for i in range(6)]
    run = lissom.simulate(model, 0.05, control=lambda t, q, v: steps[round(t / 0.01)], control_step=0.01)
    for data in (
        lambda named: lissom.StaticShapes(tips, u=named(pulls)),
        lambda named: lissom.NaturalFrequencies(frequencies, u=named(pulls[2:])[0]),
        lambda named: lissom.RecordedMotion(
            run.t[1:5], run.pose()[1:5, :3, 3], u=named(steps), control_step=0.01
        ),
    ):
        by_name = lissom.fit(model, data(list), guess)
        array = lissom.fit(model, data(lambda rows: [numbers(**row) for row in rows]), guess)
        np.testing.assert_array_equal(by_name.values, array.values)
        np.testing.assert_allclose(by_name.values, 3e5, rtol=1e-3)
    with pytest.raises(ValueError, match=r"u\[1\]: got 'pul', expected one of the inputs"):
        lissom.fit(model, lissom.StaticShapes(tips, u=[{}, {"pul": 1.0}, {}]), guess)


@pytest.mark.parametrize(
    ("u", "message"),
    [
        ([{"pull": 1.0}, {"pul": 1.0}], "u[1]: got 'pul', expected one of the inputs"),
        ([{"pull": float("nan")}], "u[0]['pull']: got NaN, expected a finite number"),
        (
            {"wind": [1.0, 2.0]},
            "u['wind']: got list, expected 3 numbers, or rows of them: the input is a vector",
        ),
        (
            {"pull": [1.0, 2.0], "hold": [1.0, 2.0, 3.0]},
            "u: got rows of shape [3] of 'hold' and of [2] of another input, expected the same of all",
        ),
    ],
)
def test_wrong_names_and_values_have_their_row(u, message):
    for call in (
        lambda: lissom.simulate_many(rod(), 0.02, u=u),
        lambda: lissom.statics_many(rod(), u),
        lambda: lissom.Simulations(rod(), 2, dt=0.01).step(u),
    ):
        with pytest.raises(ValueError, match=re.escape(message)):
            call()
