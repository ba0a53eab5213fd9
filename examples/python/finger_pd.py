"""PD control of a finger that four tendons bend: its tip goes to a place beside and above, at 100 Hz.

Tendons only pull, so the sign of a demand says which one of two does. Without an integral part gravity leaves
an error; the tensions that hold the finger at the target take it away. `lissom.actuate` finds them.
"""

import numpy as np

import lissom

CONTROL_STEP = 0.01  # s
PROPORTIONAL, DERIVATIVE = 60.0, 1.5  # N/m, N s/m
LARGEST = 10.0  # N
TARGET = np.array([0.01, 0.02])  # of the tip across the finger, m
# Where tendons lie in a section, m, in pairs that pull to opposite sides.
OFFSETS = {"left": (0.004, 0.0), "right": (-0.004, 0.0), "upper": (0.0, 0.004), "lower": (0.0, -0.004)}

soft = lissom.Segment(
    0.1,
    0.006,
    1e6,
    4e5,
    1000.0,
    modes={"torsion": 1, "bend_y": 3, "bend_z": 3},
    retardation_time=0.02,
)
finger = lissom.Rod(
    [soft],
    actuators=[
        lissom.Tendon(name, [lissom.Along("rod", offset)], tension=lissom.Input(name))
        for name, offset in OFFSETS.items()
    ],
)


def tip(q):
    """Where the tip is across the finger, in one state or many."""
    return finger.pose(q)[..., 1:3, 3]


def tensions(demand):
    """Of all tendons, newtons: the sign of a demand says which one of a pair pulls."""
    return np.clip([demand[0], -demand[0], demand[1], -demand[1]], 0.0, LARGEST)


def feedback(q, v, target):
    """What the error of the tip and its speed demand to the side and upwards, newtons."""
    return PROPORTIONAL * (target - tip(q)) - DERIVATIVE * finger.velocity(q, v)[4:6]


def holding(target=TARGET):
    """The least tensions that hold the tip there."""
    wanted = lissom.Target("rod", [0.0, *target], position_weight=(0, 1, 1))
    found = lissom.actuate(finger, wanted, limits=dict.fromkeys(finger.inputs, (0.0, LARGEST)))
    if not found.success:
        raise SystemExit(found.message)
    return found.u


def run(hold, duration=2.0):
    """Times and errors of the tip, metres, under PD control on top of tensions that are always there."""
    simulation = lissom.Simulation(finger, dt=1e-3, q0=lissom.statics(finger).q)
    steps = round(duration / CONTROL_STEP)
    errors = np.empty((steps, 2))
    for step in range(steps):
        u = tensions(feedback(simulation.q, simulation.v, TARGET) + hold[::2] - hold[1::2])
        status = simulation.step(u, duration=CONTROL_STEP)
        assert status == "finished", simulation.message
        errors[step] = tip(simulation.q) - TARGET
    return CONTROL_STEP * np.arange(1, steps + 1), np.linalg.norm(errors, axis=1)


if __name__ == "__main__":
    for name, hold in (("PD alone", np.zeros(4)), ("PD and the holding tensions", holding())):
        times, errors = run(hold)
        moving = np.flatnonzero(np.abs(errors - errors[-1]) > 1e-3)
        pulls = ", ".join(f"{pull:.2f}" for pull in hold)
        print(f"{name} ({pulls} N): {1e3 * errors[-1]:.3f} mm from the target at the end,")
        print(f"    within 1 mm of that from {times[moving[-1] + 1]:.2f} s on")
