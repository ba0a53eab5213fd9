"""Radau IIA and runs to an accuracy with closed loops: published and exact answers, orders, stiff rods, moving bases."""

import numpy as np
import pytest
from test_loops import (
    about_z,
    bricard,
    exact_windows,
    slider_crank,
    squeezer,
    windows,
    wire,
)

import lissom
from lissom import BaseMotion, Body, Free, Harmonic, Link, Loop, Revolute, Robot, Segment, Spherical, Weld


def radau(robot, t_end, tolerance, **options):
    motion = lissom.simulate(robot, t_end, method="radau", rtol=tolerance, atol=1e-2 * tolerance, **options)
    assert motion.success, motion.message
    return motion


def test_errors_fall_with_the_tolerance_and_forces_with_them():
    robot, v0 = windows(1)
    exact = exact_windows(1)
    wanted = radau(robot, 0.6, 1e-11, v0=v0, t_eval=[0.6])
    force = robot.loop_forces(wanted.q[-1], wanted.v[-1], wanted.a[-1])
    errors, of_forces = [], []
    for tolerance in (1e-4, 1e-6, 1e-8):
        motion = radau(robot, 0.6, tolerance, v0=v0, t_eval="steps")
        errors.append(np.abs(motion.q[:, 0] - exact(motion.t)).max())
        found = robot.loop_forces(motion.q[-1], motion.v[-1], motion.a[-1])
        of_forces.append(np.abs(found - force).max() / np.abs(force).max())
        assert np.abs(robot.loop_gaps(motion.q)).max() < 1e-13
        rates = np.gradient(robot.loop_gaps(motion.q), motion.t, axis=0)
        assert np.abs(rates).max() < 1e-8
        np.testing.assert_allclose(motion.balance.total, motion.balance.total[0], rtol=0, atol=300 * tolerance)
    for found in (errors, of_forces):
        assert found[0] < 1e-2
        assert found[1] < 0.05 * found[0]
        assert found[2] < 0.05 * found[1]
