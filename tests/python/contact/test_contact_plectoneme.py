"""A twisted rod that forms a loop and coils around itself, compared with published theory."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def example():
    return runpy.run_path(str(ROOT / "examples" / "python" / "plectoneme.py"))


@pytest.fixture(scope="module")
def twisted(example):
    """Up to the first coil, and some time at rest."""
    robot = example["rod"]((2.0,))
    motion = example["twist"](robot, 1.0, 5e-3)
    assert motion.success, motion.message
    return robot, motion


def test_a_rod_buckles_beyond_the_torque_of_a_long_one(example, twisted):
    # 2 sqrt(B T), Love 1944, art. 272; clamps and viscous drag delay it a little.
    robot, motion = twisted
    torques = np.array([example["torque"](robot, motion, step) for step in range(1, len(motion.t))])
    critical = 2 * np.sqrt(example["BENDING"] * example["TENSION"])
    largest = int(np.argmax(torques))
    assert 1.0 < torques[largest] / critical < 1.3
    ends = robot.pose(motion.q, t=motion.t)[:, 0, 3]
    before = np.flatnonzero(torques[:largest] < 0.9 * critical)
    assert_allclose(ends[before], example["LENGTH"], rtol=5e-3)
    assert torques[-1] < 0.6 * critical
    assert ends[-1] < 0.7 * example["LENGTH"]


def test_a_plectoneme_has_the_torque_of_theory(example, twisted):
    robot, motion = twisted
    radius = example["distance"](robot, motion, -1)
    wanted, _ = example["theory"](radius)
    # Errors from the modes and the end loop.
    assert_allclose(example["torque"](robot, motion, -1), wanted, rtol=0.01)
    # Theory distinguishes this from the torque before coiling, and from that of a thinner rod.
    assert abs(example["theory"](0.9 * radius)[0] / wanted - 1) > 0.03


def test_windings_touch_in_pairs_around_the_loop(twisted):
    robot, motion = twisted
    touches = robot.touches(motion.q[-1], motion.v[-1], t=motion.t[-1])
    places = np.array([touch.along for touch in touches])
    apart = np.abs(np.diff(places, axis=1)).ravel()
    # A continuous line of contact, with places symmetric about the top of the loop.
    assert np.ptp(apart) > 0.05
    tops = places.mean(axis=1)
    assert np.ptp(tops) < 0.02
    # The forces on both strands are equal up to quadrature errors.
    forces = np.array([touch.force for touch in touches])
    assert np.linalg.norm(forces.sum(axis=0)) < 0.01 * np.linalg.norm(forces, axis=1).sum()
