"""The energy balance of every run."""

import re

import numpy as np
import pytest

import lissom


def finger(damping=0.0, **loads):
    segment = lissom.Segment(
        0.2, 0.01, 3e5, 1e5, 1070.0, {"torsion": 2, "bend_y": 2, "bend_z": 2}, retardation_time=damping
    )
    return lissom.Rod([segment], tip_mass=0.01, **loads)


MOMENT = {"tip_force": (0.0, 0.02, 0.0), "tip_moment": (1e-3, 2e-3, -1e-3)}


def test_the_balance_of_a_linear_motion_is_exact_whatever_the_step():
    """Average acceleration conserves the sum of kinetic, elastic and dissipated energy of a linear system."""
    wire = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800.0, {"bend_y": 2}, retardation_time=0.02)
    rod = lissom.Rod([wire], gravity=(0.0, 0.0, 0.0))
    tiny = 1e-7
    motion = lissom.simulate(rod, 1.0, q0=[tiny, -tiny], dt=1e-2, rtol=1e-12, atol=1e-30)
    found = motion.balance
    assert found.dissipated[-1] > 0.1 * found.scale, "a good part is dissipated"
    assert found.drift < 1e-9


@pytest.mark.parametrize("damping", [0.0, 0.01])
def test_the_balance_closes_under_moments_forces_and_damping(damping):
    drifts = []
    for dt in (2e-3, 1e-3):
        found = lissom.simulate(finger(damping, **MOMENT), 0.4, dt=dt).balance
        assert abs(found.work[-1]) > 0.01 * found.scale, "the moment works"
        drifts.append(found.drift)
    assert drifts[0] < 2e-2
    assert drifts[1] < 0.4 * drifts[0], "second order"


@pytest.mark.parametrize("method", ["newmark", "linear_acceleration", "hht", "generalised_alpha"])
def test_the_work_of_a_constant_moment_is_moment_times_angle(method):
    """In the plane, to rounding, by each method: the way counts, not velocities at its ends."""
    segment = lissom.Segment(0.2, 0.01, 3e5, 1e5, 1070.0, {"bend_y": 3})
    rod = lissom.Rod([segment], tip_moment=(0.0, 2e-2, 0.0))
    dt = 1e-4 if method == "linear_acceleration" else 1e-3
    motion = lissom.simulate(rod, 40 * dt, dt=dt, method=method)
    angle = 0.2 * motion.q[:, 0]
    assert np.ptp(angle) > 1e-5
    np.testing.assert_allclose(motion.balance.work, 2e-2 * (angle - angle[0]), rtol=1e-9, atol=1e-18)


@pytest.mark.parametrize("method", ["rk45", "dop853", "radau"])
def test_the_balance_of_an_accurate_motion_closes(method):
    rod = finger(0.01, **MOMENT)
    found = lissom.simulate(rod, 0.3, dt=0.01, method=method, rtol=1e-9, atol=1e-11).balance
    assert abs(found.work[-1]) > 0.01 * found.scale
    assert found.dissipated[-1] > 0.01 * found.scale
    assert found.drift < 1e-5


def test_what_flowed_does_not_depend_on_the_times_that_are_kept():
    """The balance is integrated over every step, not over the saved times only."""
    rod = finger(0.01, **MOMENT)
    every = lissom.simulate(rod, 0.3, dt=1e-3).balance
    few = lissom.simulate(rod, 0.3, dt=1e-3, t_eval=[0.0, 0.1, 0.15025, 0.3]).balance
    at = [0, 100, 300]
    np.testing.assert_array_equal(few.dissipated[[0, 1, 3]], every.dissipated[at])
    np.testing.assert_array_equal(few.work[[0, 1, 3]], every.work[at])
    between = every.dissipated[150] + 0.25 * (every.dissipated[151] - every.dissipated[150])
    assert abs(few.dissipated[2] - between) < 1e-3 * (every.dissipated[151] - every.dissipated[150])


def test_no_damping_and_no_moment_no_flow():
    found = lissom.simulate(finger(), 0.1).balance
    assert not found.dissipated.any()
    assert not found.work.any()
    assert found.dissipated.shape == found.total.shape == (11,)


def test_the_power_of_the_flows_is_that_of_the_forces():
    """The flows equal the power of the generalised forces of damping and of the moment."""
    rod, free = finger(0.01, **MOMENT), finger(0.0, tip_force=MOMENT["tip_force"])
    generator = np.random.default_rng(1)
    q, v = generator.normal(size=(2, rod.n))
    rest = np.zeros(rod.n)
    change = v @ (rod.inverse_dynamics(q, v, rest) - free.inverse_dynamics(q, v, rest))
    dt = 1e-11
    found = lissom.simulate(rod, dt, q0=q, v0=v, dt=dt).balance
    assert abs((found.dissipated[-1] - found.work[-1]) / dt - change) < 1e-5 * abs(change)


def test_the_balance_is_computed_once():
    motion = lissom.simulate(finger(), 0.1)
    assert motion.balance is motion.balance


def test_newmark_knows_no_energies():
    motion = lissom.newmark(lambda t, q, v, a: a + q, (0, 1), [1.0], [0.0], dt=0.1)
    assert motion.balance is None


def test_a_balance_of_given_energies():
    zeros = np.zeros(3)
    parts = dict.fromkeys(("gravitational", "loads", "dissipated", "work"), zeros)
    found = lissom.Balance(kinetic=[0.0, 1.0, 2.0], elastic=[2.0, 1.0, 0.0], **parts)
    assert (found.drift, found.scale, found.moves) == (0.0, 2.0, True)
    with pytest.raises(ValueError, match="work: got 2 values, expected 3 values"):
        lissom.Balance(kinetic=zeros, elastic=zeros, **{**parts, "work": [0.0, 0.0]})


@pytest.mark.parametrize("value", [np.inf, -np.inf])
@pytest.mark.parametrize("where", ["kinetic", "elastic", "gravitational", "loads", "dissipated", "work"])
@pytest.mark.parametrize("at", [0, 1, 3])
def test_what_is_not_finite_is_no_drift_of_zero(where, at, value):
    energies = {
        name: np.array([0.0, 1.0, 0.0, 1.0])
        for name in ("kinetic", "elastic", "gravitational", "loads", "dissipated", "work")
    }
    energies[where][at] = value
    found = lissom.Balance(**energies)
    assert np.isnan(found.drift)
    assert not np.isfinite(found.scale)
    assert found.moves
    energies[where][at] = np.nan
    with pytest.raises(ValueError, match=re.escape(f"{where}[{at}]: got nan, expected an energy, in joules")):
        lissom.Balance(**energies)


def test_an_empty_balance_has_no_drift():
    nothing = lissom.Balance(kinetic=[], elastic=[], gravitational=[], loads=[], dissipated=[], work=[])
    assert (nothing.drift, nothing.scale, nothing.moves) == (0.0, 0.0, False)


@pytest.mark.parametrize(("name", "value"), [("v0", 1e160), ("q0", 1e160)])
@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
def test_motions_do_not_begin_with_energies_that_overflow(name, value, method):
    rod = lissom.Rod([lissom.Segment(1.0, 0.01, 1e6, 4e5, 1000, modes={"torsion": 1})], gravity=(0, 0, 0))
    motion = lissom.simulate(rod, 1e-200, dt=1e-200, method=method, **{name: [value]})
    assert (motion.success, motion.status) == (False, "no_initial_acceleration")
    assert "energ" in motion.message


def test_reports_of_energies_that_are_not_finite_say_so(tmp_path):
    """The energies of the start overflow."""
    import json

    from lissom.drawing.report import text
    from lissom.results import files, runs

    scene = lissom.Scene.loads(
        """
        version = 1
        [scene]
        gravity = [0, 0, 0]
        [[rod]]
        v0 = [1e160]
        [[rod.segment]]
        length = 1.0
        radius = 0.01
        young_modulus = 1e6
        shear_modulus = 4e5
        density = 1000
        modes = { torsion = 1 }
        [simulation]
        t_end = 1e-3
        dt = 1e-3
        """
    )
    motion = lissom.simulate(scene.model, 1e-200, v0=scene.v0, dt=1e-200)
    assert not motion.success
    assert "energies there are beyond what double precision holds" in motion.message
    run = runs.Run(scene, motion)
    said, good = text.outcome(run)
    assert not good
    assert said.startswith("Failed at 0 s: The motion cannot begin at t = 0: energies there are beyond")
    assert dict(text.summary(run))["energy drift"].startswith("NaN")
    (tmp_path / "out").mkdir()
    files.write(run, tmp_path / "out", None)
    numbers = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert numbers["energy_drift"] is None
    assert "energy balance is not finite" in numbers["message"]


@pytest.mark.parametrize("method", ["rk45", "dop853", "radau"])
@pytest.mark.parametrize("gap", [0.02, 1.0], ids=["pushes", "alone"])
def test_the_balance_of_long_steps_beside_a_prescribed_motion_closes(method, gap):
    """What is free rests for long, and steps become longer than periods of what is prescribed."""
    ball = lissom.Body(0.1)
    push = lissom.Prismatic((1, 0, 0), motion=lissom.Harmonic(0.05, 2.9))
    free = lissom.Prismatic((1, 0, 0))
    links = [
        lissom.Link("pusher", joint=push, body=ball),
        lissom.Link("pushed", joint=free, body=ball, position=(0.2 + gap, 0, 0)),
    ]
    contact = lissom.Contact(
        lissom.Ball("pusher", 0.1), lissom.Ball("pushed", 0.1), stiffness=500.0, dissipation=0.0
    )
    robot = lissom.Robot(links, gravity=(0, 0, 0), contacts=[contact])
    motion = lissom.simulate(robot, 2.0, method=method, rtol=1e-9, atol=1e-12)
    assert (motion.q[-1, 0] > 0.1) == (gap < 0.05)
    assert motion.balance.drift < 2e-3
