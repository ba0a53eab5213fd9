"""PD control of a finger that two tendons bend: the height of its tip follows a target, at 100 Hz.

Tendons only pull, so the sign of the demand says which one does. Without an integral part gravity leaves an
error; a tension that holds the finger at the target, found by statics, takes it away.
"""

import numpy as np

import lissom

soft = lissom.Segment(0.1, 0.006, 1e6, 4e5, 1000.0, modes={"bend_y": 4}, retardation_time=0.02)
upper = lissom.Tendon("upper", [lissom.Along("rod", (0.0, 0.004))], tension=lissom.Input("upper"))
lower = lissom.Tendon("lower", [lissom.Along("rod", (0.0, -0.004))], tension=lissom.Input("lower"))
finger = lissom.Rod([soft], actuators=[upper, lower])

TARGET = 0.02  # m
PROPORTIONAL, DERIVATIVE = 60.0, 1.5  # N/m, N s/m
LARGEST = 10.0  # N


def tensions(demand):
    """Both tensions for a demand: the upper tendon lifts the tip, the lower one takes it down."""
    return np.clip([demand, -demand], 0.0, LARGEST)


def run(hold, duration=2.0):
    """Times and heights of the tip under PD control around a demand that is always there."""
    simulation = lissom.Simulation(finger, dt=1e-3, q0=lissom.statics(finger).q)
    heights = [finger.pose(simulation.q)[2, 3]]
    while simulation.t < duration:
        speed = finger.velocity(simulation.q, simulation.v)[5]
        demand = hold + PROPORTIONAL * (TARGET - heights[-1]) - DERIVATIVE * speed
        status = simulation.step(tensions(demand), duration=0.01)
        assert status == "finished", simulation.message
        heights.append(finger.pose(simulation.q)[2, 3])
    return np.linspace(0.0, duration, len(heights)), np.array(heights)


def holding():
    """The demand that holds the tip at the target, by bisection over equilibria."""
    low, high = -LARGEST, LARGEST
    for _ in range(40):
        middle = 0.5 * (low + high)
        pulls = tensions(middle)
        held = lissom.Rod(
            [soft],
            actuators=[
                lissom.Tendon(name, [lissom.Along("rod", (0.0, side))], tension=pull)
                for name, side, pull in (("upper", 0.004, pulls[0]), ("lower", -0.004, pulls[1]))
            ],
        )
        low, high = (middle, high) if held.pose(lissom.statics(held).q)[2, 3] < TARGET else (low, middle)
    return 0.5 * (low + high)


if __name__ == "__main__":
    for name, hold in (("PD alone", 0.0), ("PD and the holding tension", holding())):
        times, heights = run(hold)
        moving = np.flatnonzero(np.abs(heights - heights[-1]) > 1e-3)
        error = 1e3 * abs(heights[-1] - TARGET)
        print(f"{name} ({hold:.2f} N): {error:.3f} mm from the target at the end,")
        print(f"    within 1 mm of that after {times[moving[-1] + 1]:.2f} s")
