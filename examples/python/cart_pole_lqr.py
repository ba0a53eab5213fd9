"""A flexible pole on a cart, held upright by a linear quadratic regulator; from how far away it still is.

The gains come from the exact linear model of `linearise` at the upright shape. The region of attraction is
probed by runs of the whole nonlinear model, from random tilts and speeds of the pole.
"""

import numpy as np
from scipy.linalg import solve_continuous_are

import lissom

soft = lissom.Segment(0.5, 0.006, 2e7, 8e6, 1100.0, modes={"bend_y": 2}, retardation_time=0.002)
robot = lissom.Robot(
    [
        lissom.Link("cart", body=lissom.Body(1.0), joint=lissom.Prismatic((1, 0, 0))),
        lissom.Link("hinge", parent="cart", joint=lissom.Revolute((0, 1, 0), damping=1e-4)),
        lissom.Link("pole", parent="hinge", rod=[soft], orientation=(np.sqrt(0.5), 0, -np.sqrt(0.5), 0)),
    ],
    actuators=[lissom.Motor("cart", lissom.Input("force"))],
)
LARGEST = 20.0  # N


def gains():
    """The feedback u = -K [q; v] that makes the least of ∫ x'Qx + u²R dt near the upright shape."""
    model = lissom.linearise(robot, np.zeros(robot.n))
    weights = np.diag([10.0, 10.0, *[0.0] * (robot.n - 2), 1.0, 1.0, *[0.0] * (robot.n - 2)])
    # The motor's force is the generalised force on the first coordinate.
    push = model.B[:, [0]]
    cost = solve_continuous_are(model.A, push, weights, [[0.1]])
    return 10.0 * push.T @ cost


def is_caught(feedback, tilt, speed, duration=4.0):
    """True when the pole stands upright at the end."""
    q0, v0 = np.zeros((2, robot.n))
    q0[1], v0[1] = tilt, speed
    simulation = lissom.Simulation(robot, dt=5e-3, q0=q0, v0=v0)
    while simulation.t < duration:
        u = np.clip(-feedback @ np.concatenate([simulation.q, simulation.v]), -LARGEST, LARGEST)
        if simulation.step(u, duration=0.01) != "finished" or abs(simulation.q[1]) > np.pi:
            return False
    return bool(np.abs(simulation.q[1]) < 0.02)


if __name__ == "__main__":
    feedback = gains()
    random = np.random.default_rng(0)
    starts = random.uniform([0.0, -1.0], [1.5, 1.0], (1000, 2))
    caught = np.array([is_caught(feedback, *start) for start in starts])
    for low in np.arange(0.0, 1.5, 0.25):
        here = (starts[:, 0] >= low) & (starts[:, 0] < low + 0.25)
        count = np.count_nonzero(caught[here])
        print(f"tilted by {low:.2f} to {low + 0.25:.2f} rad: {count} of {here.sum()} caught")
