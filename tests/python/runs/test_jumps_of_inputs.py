"""Inputs and loads that jump, in fixed steps that do not resolve what the jumps excite."""

import numpy as np
import pytest

import lissom
from lissom import Along, Input, Rod, Segment, Tendon

HOLD = 0.01


def arm(tensions, *, radius=2.5e-3, young_modulus=5e7, retardation_time=0.01, torsion=2):
    """A slender arm of 200 mm with three tendons."""
    modes = {"bend_y": 3, "bend_z": 3} | ({"torsion": torsion} if torsion else {})
    segment = Segment(
        0.2, radius, young_modulus, young_modulus / 3, 1200.0, modes, retardation_time=retardation_time
    )
    angles = 2 * np.pi * np.arange(3) / 3
    places = 0.8 * radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    tendons = [
        Tendon(f"t{i}", [Along("rod", tuple(place))], tension=tension)
        for i, (place, tension) in enumerate(zip(places, tensions, strict=True))
    ]
    return Rod([segment], actuators=tendons)


def steered(**options):
    return arm([Input(f"t{i}") for i in range(3)], **options)


def held(inputs):
    return lambda t, q, v: inputs[min(round(t / HOLD), len(inputs) - 1)]


def error(motion, model, reference):
    """The largest error of the tip as a part of the length."""
    tips = [model.pose(q)[:, :3, 3] for q in (motion.q, reference.q)]
    return np.linalg.norm(tips[0] - tips[1], axis=1).max() / 0.2


@pytest.fixture(scope="module")
def case():
    """A motion under tensions that jump every 10 ms, by Radau's method."""
    inputs = np.random.default_rng(0).uniform(0, 3, (30, 3))
    times = HOLD * np.arange(len(inputs) + 1)
    model = steered()
    options = {"control": held(inputs), "control_step": HOLD, "t_eval": times}
    reference = lissom.simulate(model, times[-1], method="radau", rtol=1e-7, atol=1e-9, **options)
    assert reference.success
    return model, inputs, options, reference


@pytest.mark.parametrize("method", ["newmark", "hht", "generalised_alpha"])
@pytest.mark.parametrize(("dt", "allowed"), [(1e-2, 0.03), (5e-3, 0.03), (2e-3, 4e-3), (1e-3, 1e-3)])
def test_jumps_that_excite_torsion_are_followed(case, method, dt, allowed):
    """Torsion decays in 0.1 ms. Steps of 10 and 5 ms did not converge, those of 2 ms were off by 2.5 %."""
    model, _, options, reference = case
    motion = lissom.simulate(model, reference.t[-1], method=method, dt=dt, **options)
    assert motion.success
    assert error(motion, model, reference) < allowed


def test_tables_that_jump_are_inputs_that_jump(case):
    model, inputs, options, _ = case
    begins = HOLD * np.arange(len(inputs))
    times = np.sort(np.append(begins[1:], np.nextafter(begins[1:], 1.0)))
    times = np.concatenate([[0.0], times, [HOLD * len(inputs)]])
    tables = [(times, np.repeat(column, 2)) for column in inputs.T]
    for dt in (1e-2, 2e-3):
        by_table = lissom.simulate(arm(tables), times[-1], dt=dt, t_eval=options["t_eval"])
        by_inputs = lissom.simulate(model, times[-1], dt=dt, **options)
        assert error(by_table, model, by_inputs) < 1e-3


def test_steps_after_small_jumps_are_those_of_the_method():
    """Average acceleration: what moves coordinates by less than a thousandth needs no step of its own."""
    model = steered(torsion=0)
    inputs = 0.5 + 1e-6 * np.random.default_rng(1).uniform(0, 1, (10, 3))
    motion = lissom.simulate(model, 0.1, dt=1e-3, control=held(inputs), control_step=HOLD)
    for k in np.arange(10, 100, 10):
        mean = 0.5 * (motion.a[k] + motion.a[k + 1])
        np.testing.assert_allclose(motion.v[k + 1], motion.v[k] + 1e-3 * mean, rtol=1e-9, atol=1e-9)


def test_the_balance_closes_over_jumps(case):
    model, inputs, _, _ = case
    motion = lissom.simulate(model, 0.3, dt=2e-3, control=held(inputs), control_step=HOLD)
    assert motion.balance.drift < 5e-3
    assert (np.diff(motion.balance.dissipated) >= 0).all()


def test_without_damping_the_balance_shows_what_steps_lose():
    """Vibrations whose energy the steps after jumps remove."""
    inputs = np.random.default_rng(0).uniform(0, 0.2, (10, 3))
    model = steered(young_modulus=5e8, retardation_time=0.0, torsion=0)
    motion = lissom.simulate(model, 0.1, dt=HOLD, control=held(inputs), control_step=HOLD)
    assert motion.success
    assert motion.balance.drift > 1e-2
    assert not motion.balance.dissipated.any()


def test_what_steps_do_not_resolve_is_doubted():
    """18 Hz with little damping, in steps of 10 ms."""
    model = steered(radius=4.6e-3, young_modulus=4e8, retardation_time=1e-3, torsion=1)
    inputs = np.random.default_rng(3).uniform(0, 96, (10, 3)).repeat(5, axis=0)
    times = HOLD * np.arange(len(inputs) + 1)
    options = {"control": held(inputs), "control_step": HOLD, "t_eval": times}
    reference = lissom.simulate(model, times[-1], method="radau", rtol=1e-6, atol=1e-8, **options)
    with pytest.warns(lissom.AccuracyWarning, match=r"does not resolve a vibration of 18"):
        motion = lissom.simulate(model, times[-1], **options)
    assert 0.05 < error(motion, model, reference) < 0.2


def test_what_steps_resolve_is_not_doubted():
    model = steered(radius=5e-3, young_modulus=3e7, retardation_time=0.05)
    inputs = np.random.default_rng(3).uniform(0, 3, (10, 3)).repeat(5, axis=0)
    times = HOLD * np.arange(len(inputs) + 1)
    options = {"control": held(inputs), "control_step": HOLD, "t_eval": times}
    reference = lissom.simulate(model, times[-1], method="radau", rtol=1e-6, atol=1e-8, **options)
    motion = lissom.simulate(model, times[-1], **options)
    assert motion.doubt is None
    assert error(motion, model, reference) < 1e-3


def test_runs_step_by_step_have_the_same_bits(case):
    model, inputs, _, _ = case
    run = lissom.simulate(model, 0.1, dt=2e-3, control=held(inputs), control_step=HOLD)
    simulation = lissom.Simulation(model, dt=2e-3)
    for k in range(10):
        assert simulation.step(inputs[k], duration=HOLD) == "finished"
    np.testing.assert_array_equal(simulation.q, run.q[-1])
    np.testing.assert_array_equal(simulation.v, run.v[-1])
