"""A gripper of three tendon fingers holds a ball by friction, and loses it at the predicted load."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

import lissom

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def example():
    return runpy.run_path(str(ROOT / "examples" / "python" / "soft_gripper.py"))


def held_ball(example, friction, slip_velocity, most):
    """The example's hand without weight; a force that increases from 1 s to 4 s pulls the ball down."""
    lifts = example["gripper"](0.05)
    half = lissom.Segment(
        0.05, example["RADIUS"], example["YOUNG"], poisson_ratio=0.45, density=1000, retardation_time=0.01,
        modes={"bend_y": 3},
    )  # fmt: skip
    fingers = [
        lissom.Link(link.name, rod=[half] * 2, position=link.position, orientation=link.orientation)
        for link in lifts.links[1:4]
    ]
    ball = lissom.Link(
        "ball", joint=lissom.Free(), body=lifts.links[4].body, position=(0, 0, -example["HEIGHT"])
    )
    pull = lissom.Load(link="ball", force=([0, 1, 4], [[0, 0, 0], [0, 0, 0], [0, 0, -most]]))
    surface = lissom.Ball("ball", example["BALL"])
    contacts = [
        lissom.Contact(link.name, surface, friction=friction, slip_velocity=slip_velocity) for link in fingers
    ]
    return lissom.Robot(
        [*fingers, ball], gravity=(0, 0, 0), loads=[pull], actuators=lifts.actuators, contacts=contacts
    )


def carried(example, depth, friction):
    """Maximum load of three fingers on a ball at a depth below their bases, by shooting.

    A finger is an elastica with the moment of its tendon, tension times offset, and the force of the ball: at
    the slope t it presses with N along its normal and with friction times N along its axis.
    """
    radius, ball, young = example["RADIUS"], example["BALL"], example["YOUNG"]
    bending = young * np.pi / 4 * radius**4
    moment = example["TENSION"] * example["OFFSET"]
    centre = np.array([depth, ball + radius + example["GAP"]])
    # Line contact with a ball: k (d - s^2 / (2 R)) where positive, with R of both curves.
    stiffness = np.pi / 4 * young / (1 - 0.45**2) * 4 / 3 * np.sqrt(2 * ball)

    def gaps(unknown):
        pressure, length, slope = unknown
        along, inward = np.array([[np.cos(slope), np.sin(slope)], [-np.sin(slope), np.cos(slope)]])
        overlap = (pressure / stiffness) ** (2 / 3)
        axis = centre - (ball + radius - overlap) * inward
        place = axis + (radius - 0.5 * overlap) * inward
        force = pressure * (friction * along - inward)

        def bend(s, y):
            lever = place - y[1:]
            curvature = (moment + lever[0] * force[1] - lever[1] * force[0]) / bending
            return [curvature, np.cos(y[0]), np.sin(y[0])]

        end = solve_ivp(bend, (0, length), [0, 0, 0], rtol=1e-9, atol=1e-12).y[:, -1]
        return [end[0] - slope, *(end[1:] - axis) / depth]

    (pressure, _, slope), _, ok, message = fsolve(gaps, [0.5, depth, 0.0], full_output=True)
    assert ok == 1, message
    return 3 * pressure * (friction * np.cos(slope) + np.sin(slope))


@pytest.mark.parametrize("friction", [0.3, 0.5])
def test_a_ball_slips_at_the_force_that_friction_carries(example, friction):
    creep, most = 1e-5, 1.2
    robot = held_ball(example, friction, creep, most)
    motion = lissom.simulate(robot, 4.0, dt=5e-3)
    assert motion.success, motion.message
    ball = robot.slice("ball")
    down, speed = -motion.q[:, ball][:, 2], -motion.v[:, ball][:, 2]
    slips = np.flatnonzero((motion.t > 1) & (speed > 10 * creep))[0]
    load = most * (motion.t[slips] - 1) / 3
    # Friction at this speed.
    part = speed[slips] / np.hypot(speed[slips], creep)
    wanted = carried(example, example["HEIGHT"] + down[slips], part * friction)
    # One step corresponds to 2 mN.
    assert_allclose(load, wanted, rtol=1e-3, atol=1e-3)
    # Before the ball slips it sticks, except for the regularised creep.
    sticks = (motion.t > 1) & (motion.t < motion.t[slips] - 0.1)
    assert np.all(np.abs(speed[sticks]) < 10 * creep)
    assert speed[-1] > 1.0


def test_balls_are_lifted_that_friction_can_carry(example):
    depth = example["HEIGHT"] + 1e-4
    # Hanging makes fingers slightly stiffer; the lift accelerates by two percent of gravity.
    most = carried(example, depth, example["FRICTION"]) / example["GRAVITY"]
    _, height, _ = example["run"](0.92 * most)
    assert height > 0.95 * example["LIFT"]
    motion, height, _ = example["run"](1.08 * most)
    assert abs(height) < 1e-3
    assert motion.model.touches(motion.q[-1], t=motion.t[-1])
