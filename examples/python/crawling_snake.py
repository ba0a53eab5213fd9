"""A snake that crawls on a floor by a wave of its muscles, with friction that differs by direction.

The case is the continuum snake of PyElastica (Zhang, Chan, Parthasarathy and Gazzola 2019): its muscle
torques are active curvatures here. PyElastica 1.0.0 finds 0.0278 m/s forward and -0.0024 m/s sideways.

    python examples/python/crawling_snake.py [--time seconds] [--slip metres per second]
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from scipy.interpolate import BSpline

import lissom

LENGTH, RADIUS, YOUNG, PERIOD, GRAVITY = 0.35, 0.00385, 1e6, 2.0, 9.80665
TORQUES = np.array([0, 3.4, 3.3, 4.2, 2.6, 3.6, 3.5, 0]) * 1e-3
# Inertia over friction: the friction coefficient at which this number is 0.1.
FROUDE = 0.1


def snake(slip_velocity: float) -> lissom.Robot:
    segment = lissom.Segment(
        LENGTH,
        radius=RADIUS,
        young_modulus=YOUNG,
        poisson_ratio=0.5,
        density=1000,
        modes={"bend_z": 6},
        retardation_time=0.005,
    )
    knots = np.concatenate([np.zeros(3), np.linspace(0, 1, 6), np.ones(3)])
    size = BSpline(knots, TORQUES, 3)
    X = np.linspace(0, LENGTH, 31)
    phase = 1 - X / LENGTH
    curvature = size(phase) / (YOUNG * np.pi / 4 * RADIUS**4)
    rate = 2 * np.pi / PERIOD

    def ramp(t: float) -> float:
        return min(1.0, t / PERIOD)

    # sin(rate t + 2 pi phase), its parts in time apart from those along the rod
    muscles = [
        lissom.ActiveStrain(
            "snake",
            "bend_z",
            (X, curvature * np.cos(2 * np.pi * phase)),
            lambda t: ramp(t) * np.sin(rate * t),
            name="sine",
        ),
        lissom.ActiveStrain(
            "snake",
            "bend_z",
            (X, -curvature * np.sin(2 * np.pi * phase)),
            lambda t: ramp(t) * np.cos(rate * t),
            name="cosine",
        ),
    ]
    forward = LENGTH / (PERIOD**2 * GRAVITY * FROUDE)
    floor = lissom.Contact(
        "snake",
        lissom.HalfSpace(),
        friction=(forward, 1.5 * forward, 2 * forward),
        slip_velocity=slip_velocity,
    )
    link = lissom.Link("snake", joint=lissom.Free(), rod=[segment], position=(0, 0, RADIUS))
    return lissom.Robot([link], gravity=(0, 0, -GRAVITY), actuators=muscles, contacts=[floor])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--time", type=float, default=22.0)
    parser.add_argument("--slip", type=float, default=1e-3)
    options = parser.parse_args()
    robot = snake(options.slip)
    start = time.perf_counter()
    motion = lissom.simulate(robot, options.time, dt=1e-3)
    print(motion.message, f"{time.perf_counter() - start:.1f} s")
    # The first two periods are the start.
    begin, end = np.searchsorted(
        motion.t, [min(2 * PERIOD, 0.2 * options.time), min(10 * PERIOD, options.time)]
    )
    way = robot.centre_of_mass(motion.q[end]) - robot.centre_of_mass(motion.q[begin])
    forward, sideways, _ = way / (motion.t[end] - motion.t[begin])
    print(f"forward {forward:.5f} m/s, sideways {sideways:.5f} m/s")


if __name__ == "__main__":
    main()
