"""An overhand knot: a rope that touches itself in several places while it is pulled."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def example():
    return runpy.run_path(str(ROOT / "examples" / "python" / "overhand_knot.py"))


def test_the_rope_has_the_shape_that_was_tied(example):
    robot, q = example["rope"](0.1)
    arc, points = example["tied"]()
    X = np.linspace(0, arc[-1] * (1 - 1e-12), 101)
    wanted = np.column_stack([np.interp(X, arc, column) for column in points.T])
    # Modes smooth the bends at the ends of the polynomial; a millimetre is a fifth of the radius.
    assert_allclose(robot.pose(q, X)[:, :3, 3], wanted, atol=4e-3)
    assert robot.touches(q) == []


def test_a_knot_that_is_pulled_touches_itself_and_loses_energy(example):
    robot, q0 = example["rope"](example["BENDING"] / (2 * 0.06**2))
    motion = lissom.simulate(robot, 0.105, dt=5e-4, q0=q0)
    assert motion.success, motion.message
    total = [robot.energy(q, v).total for q, v in zip(motion.q[::10], motion.v[::10], strict=True)]
    assert np.diff(total).max() < 1e-3 * abs(total[-1] - total[0])
    touches = robot.touches(motion.q[-1], motion.v[-1], t=motion.t[-1])
    assert max(touch.overlap for touch in touches) < 0.1 * example["RADIUS"]
    # Each place is reported from both sides.
    places = np.array([touch.along for touch in touches])
    assert np.any(places[:, 0] < places[:, 1])
    assert np.any(places[:, 0] > places[:, 1])
