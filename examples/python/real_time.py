"""A finger that is simulated in real time, at 1 kHz: what a period takes, and how many come too late.

The numbers are up to the machine and to what else runs there: an operating system that is not made for real
time may take the processor away for milliseconds.
"""

import time

import numpy as np

import lissom

PERIOD = 1e-3  # s
PERIODS = 1000

soft = lissom.Segment(0.1, 0.006, 1e6, 4e5, 1000.0, modes={"bend_y": 4}, retardation_time=0.02)
pull = lissom.Tendon("upper", [lissom.Along("rod", (0.0, 0.004))], tension=lissom.Input("upper"))
finger = lissom.Rod([soft], actuators=[pull])


def run():
    """Seconds after each period's start at which the loop woke up and at which it was done."""
    simulation = lissom.Simulation(finger, dt=PERIOD)
    woken, done = np.empty((2, PERIODS))
    begin = time.perf_counter() + PERIOD
    for period in range(PERIODS):
        start = begin + period * PERIOD
        if (left := start - time.perf_counter()) > 0.0:
            time.sleep(left)
        woken[period] = time.perf_counter() - start
        demand = 2.0 + np.sin(2.0 * np.pi * 2.0 * simulation.t)
        status = simulation.step([demand], duration=PERIOD)
        assert status == "finished", simulation.message
        done[period] = time.perf_counter() - start
    return woken, done


if __name__ == "__main__":
    woken, done = run()
    work = 1e6 * (done - woken)
    print(f"work of a period: median {np.median(work):.0f} µs, longest {work.max():.0f} µs")
    print(f"deadlines missed: {np.count_nonzero(done > PERIOD)} of {PERIODS}")
    print("woken late by (µs)")
    edges = np.array([0.0, 50.0, 100.0, 200.0, 500.0, 1000.0, np.inf])
    late = np.clip(1e6 * woken, 0.0, None)
    for low, high, count in zip(edges, edges[1:], np.histogram(late, edges)[0], strict=False):
        print(f"{low:5.0f} to {high:5.0f}  {count:5d}  {'#' * round(50 * count / PERIODS)}")
