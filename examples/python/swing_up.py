"""A flexible pendulum is swung up with the least effort, by shooting.

A motor too weak to lift the pendulum at once turns its base; the torques of equal control steps are chosen so
that ∫ torque² dt is least and the pendulum stands upright, straight and at rest, at the end. One run and its
derivatives with respect to the inputs of all control steps give how the end depends on the torques.

    python examples/python/swing_up.py [--time seconds] [--controls number] [--torque newton metres]
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares, minimize

import lissom

LENGTH = 0.5
UPRIGHT = np.pi
PRICE = 0.3  # of torque beside what is missed, in the first search
DT = 5e-3  # of the steps, seconds


def pendulum() -> lissom.Robot:
    """A rubber rod that hangs from a motor; straight down where its coordinates are zero."""
    soft = lissom.Segment(
        LENGTH,
        radius=0.008,
        young_modulus=3e7,
        poisson_ratio=0.5,
        density=1100.0,
        modes={"bend_y": 1},
        retardation_time=0.005,
    )
    down = (np.sqrt(0.5), 0, np.sqrt(0.5), 0)
    link = lissom.Link("pole", rod=[soft], joint=lissom.Revolute((0, 1, 0)), orientation=down)
    return lissom.Robot([link], actuators=[lissom.Motor("pole", lissom.Input("torque"))])


@dataclass
class Shooting:
    """The state at the end as a function of the torques, and its derivatives; runs are counted."""

    t_end: float
    controls: int
    robot: lissom.Robot = field(default_factory=pendulum)
    runs: int = field(default=0, init=False)
    _torques: np.ndarray | None = field(default=None, init=False)
    _found: lissom.SensitivityResult | None = field(default=None, init=False)

    @property
    def control_step(self) -> float:
        return self.t_end / self.controls

    def motion(self, torques) -> lissom.SensitivityResult:
        """The run under these torques, with its derivatives; the last one is kept."""
        if self._torques is None or not np.array_equal(torques, self._torques):
            self._found = lissom.sensitivity(
                self.robot,
                self.t_end,
                ["u"],
                u=np.asarray(torques)[:, None],
                control_step=self.control_step,
                dt=DT,
                rtol=1e-11,
            )
            self._torques = np.array(torques)
            self.runs += 1
        return self._found

    def miss(self, torques):
        """What the end lacks of standing upright, straight and at rest."""
        motion = self.motion(torques)
        end = np.concatenate([motion.q[-1], motion.v[-1]])
        end[0] -= UPRIGHT
        return end

    def slopes_of_miss(self, torques):
        motion = self.motion(torques)
        return np.concatenate([motion.dq[-1], motion.dv[-1]])

    def effort(self, torques) -> float:
        """The integral of the squared torque, N² m² s."""
        return self.control_step * float(torques @ torques)


def swing_up(shooting: Shooting, largest: float):
    """Torques of the least effort, as SciPy's result in units of the largest torque.

    Least squares come first: they weigh what is missed against torque, and lead from pushes to and fro at the
    frequency of small swings, to where SLSQP needs few steps for the least effort that misses nothing.
    """
    rate = np.sqrt(1.5 * 9.81 / LENGTH)
    t = (np.arange(shooting.controls) + 0.5) * shooting.control_step
    n = shooting.robot.n
    # Radians and radians per metre, a tenth of what they change by in a second.
    weights = np.array([1.0] * n + [0.1] * n)

    def miss(x):
        return weights * shooting.miss(largest * x)

    def slopes(x):
        return largest * weights[:, None] * shooting.slopes_of_miss(largest * x)

    rough = least_squares(
        lambda x: np.concatenate([miss(x), PRICE * x]),
        0.5 * np.sin(rate * t),
        jac=lambda x: np.concatenate([slopes(x), PRICE * np.eye(len(x))]),
        bounds=(-1, 1),
        ftol=1e-3,
    )
    return minimize(
        lambda x: x @ x / len(x),
        rough.x,
        jac=lambda x: 2 * x / len(x),
        method="SLSQP",
        bounds=[(-1, 1)] * len(t),
        constraints={"type": "eq", "fun": miss, "jac": slopes},
        options={"ftol": 1e-5, "maxiter": 200},
    )


def main(argv=None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--time", type=float, default=2.0)
    parser.add_argument("--controls", type=int, default=25)
    parser.add_argument("--torque", type=float, default=0.3)
    options = parser.parse_args(argv)
    shooting = Shooting(options.time, options.controls)
    begin = time.perf_counter()
    found = swing_up(shooting, options.torque)
    seconds = time.perf_counter() - begin
    if not found.success:
        raise SystemExit(found.message)
    print(f"{shooting.runs} runs with their derivatives, {seconds:.1f} s")
    torques = options.torque * found.x
    motion = shooting.motion(torques)
    q, v = motion.q, motion.v
    robot = shooting.robot
    heights = [robot.pose(state, link="pole")[2, 3] for state in q]
    supplied = robot.energy(q[-1], v[-1]).total - robot.energy(q[0], v[0]).total
    print(f"integral of torque²  {shooting.effort(torques):8.4f} N² m² s")
    print(f"largest torque       {np.abs(torques).max():8.4f} N m")
    print(f"energy at the end    {supplied:8.4f} J more than hanging")
    print(f"tip at the start     {heights[0]:8.4f} m")
    print(f"tip at the end       {heights[-1]:8.4f} m of {LENGTH} m")
    print(f"speed of the motor   {v[-1, 0]:8.1e} rad/s at the end")


if __name__ == "__main__":
    main()
