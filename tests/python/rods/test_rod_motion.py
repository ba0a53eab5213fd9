"""Rods in motion with `lissom.simulate`: energy, damping, frames, and the published motion of the lab rod."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import lissom
from rod_cases import Case, rich_loads, rich_rod

LAB_TIMES = [0.1, 0.5, 1.0, 3.0]
LAB_TIPS = [
    [0.9970663766, -0.0712500678],
    [0.9807178651, -0.1838140514],
    [0.9273593387, -0.3468061965],
    [0.9338616378, -0.333168186],
]


def lab_rod(retardation_time=1e-4):
    segment = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800.0, {"bend_y": 3}, retardation_time)
    return lissom.Rod([segment])


def tips(rod, motion):
    return np.array([rod.pose(q, rod.length)[[0, 2], 3] for q in motion.q])


def total_energies(rod, motion):
    return np.array([rod.energy(q, v).total for q, v in zip(motion.q, motion.v, strict=True)])


@pytest.mark.parametrize("method", ["rk45", "dop853", "radau"])
def test_lab_rod_released_from_horizontal(method):
    rod = lab_rod()
    motion = lissom.simulate(rod, 3.0, method=method, rtol=1e-9, atol=1e-11, t_eval=LAB_TIMES)
    assert motion.success, motion.message
    assert_allclose(motion.t, LAB_TIMES)
    assert_allclose(tips(rod, motion), LAB_TIPS, atol=2e-7)


def test_newmark_error_of_the_lab_rod():
    """Largest tip error over the 3 s: 6.3e-3 m at 10 ms, 2.5e-3 at 5 ms, 1.06e-4 at 1 ms."""
    rod = lab_rod()
    grid = np.linspace(0, 3, 301)
    exact = tips(rod, lissom.simulate(rod, 3.0, method="dop853", rtol=1e-10, atol=1e-12, t_eval=grid))
    for dt, error in ((1e-2, 6.3e-3), (5e-3, 2.5e-3), (1e-3, 1.06e-4)):
        motion = lissom.simulate(rod, 3.0, dt=dt, t_eval=grid)
        found = np.linalg.norm(tips(rod, motion) - exact, axis=1).max()
        assert_allclose(found, error, rtol=0.02)


def test_energy_is_conserved_as_the_step_is_refined():
    """Without damping, Newmark's energy error decreases with the square of the step."""
    rod = lab_rod(retardation_time=0.0)
    steps = np.array([1e-3, 5e-4, 2.5e-4])
    errors = []
    for dt in steps:
        energy = total_energies(rod, lissom.simulate(rod, 0.5, dt=dt))
        errors.append(np.abs(energy - energy[0]).max())
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert_allclose(order, 2, atol=0.15)


def undamped_rich_rod():
    """Three spatial segments with dead forces and bodies, all conservative."""
    forces = [
        {name: value for name, value in load.items() if name != "moment"}
        for load in rich_loads()
        if load.get("frame") != "body"
    ]
    rod = rich_rod(tip_moment=(0, 0, 0), loads=forces).arguments
    segments = [segment | {"retardation_time": 0.0} for segment in rod["segments"]]
    return Case(**(rod | {"segments": segments})).lissom


def test_energy_of_a_spatial_rod_is_conserved_to_the_tolerance():
    rod = undamped_rich_rod()
    drifts = []
    for rtol in (1e-6, 1e-9):
        motion = lissom.simulate(rod, 0.1, method="dop853", rtol=rtol, atol=rtol * 1e-2)
        assert motion.success, motion.message
        energy = total_energies(rod, motion)
        moved = max(rod.energy(q, v).kinetic for q, v in zip(motion.q, motion.v, strict=True))
        drifts.append(np.abs(energy - energy[0]).max() / moved)
    assert drifts[0] < 1e-4
    assert drifts[1] < 1e-7


def test_damping_takes_energy_out_and_ends_in_equilibrium():
    # Nearly critical damping of the first mode, 3.5 rad/s: after 8 s about e^-24 of the motion remains.
    segment = lissom.Segment(0.4, 0.01, 1e6, 4e5, 1000.0, {"bend_y": 3}, retardation_time=0.5)
    rod = lissom.Rod([segment])
    motion = lissom.simulate(rod, 8.0, dt=1e-2)
    energy = total_energies(rod, motion)
    assert np.diff(energy).max() < 1e-7 * np.ptp(energy)
    rest = np.zeros(rod.n)
    straight = np.abs(rod.inverse_dynamics(rest, rest, rest)).max()
    assert_allclose(rod.inverse_dynamics(motion.q[-1], rest, rest), 0, atol=1e-6 * straight)


def test_rotating_everything_rotates_the_motion():
    turn = Rotation.from_rotvec([0.4, -1.1, 0.7])
    straight = rich_rod().arguments
    w, x, y, z = straight["base_orientation"]
    x, y, z, w = (turn * Rotation.from_quat([x, y, z, w])).as_quat()
    turned = straight | {
        name: turn.apply(straight[name]) for name in ("base_position", "gravity", "tip_force", "tip_moment")
    }
    turned["base_orientation"] = (w, x, y, z)
    turned["loads"] = [
        load
        | {
            name: turn.apply(load[name])
            for name in ("force", "moment")
            if name in load and load.get("frame") != "body"
        }
        for load in straight["loads"]
    ]
    motions, rods = [], []
    for arguments in (straight, turned):
        rods.append(Case(**arguments).lissom)
        motions.append(lissom.simulate(rods[-1], 0.3, dt=5e-3))
    assert_allclose(motions[1].q, motions[0].q, atol=1e-7 * np.abs(motions[0].q).max())
    tip, turned_tip = (
        rod.pose(motion.q[-1], rod.length)[:3, 3] for rod, motion in zip(rods, motions, strict=True)
    )
    assert_allclose(turned_tip, turn.apply(tip), atol=1e-7)


@pytest.mark.parametrize(
    ("modes", "tip", "known_to"),
    [
        ({"bend_y": 8}, [0.2331, -0.9267], 5e-5),
        ({"bend_y": 7, "stretch": 4, "shear_z": 4}, [0.22337, -0.93122], 1e-4),
    ],
    ids=["bending", "bending, stretch and shear"],
)
def test_rubber_rod_falls(modes, tip, known_to):
    """Converged tip after one second, to the known digits."""
    rod = lissom.Rod([lissom.Segment(1.0, 0.02, 5e6, 5e6 / 3, 1000.0, modes)])
    motion = lissom.simulate(rod, 1.0, method="radau", rtol=1e-7, atol=1e-9, t_eval=[1.0])
    assert motion.success, motion.message
    assert_allclose(tips(rod, motion)[-1], tip, atol=known_to)
