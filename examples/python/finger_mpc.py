"""Model-predictive control of the finger of `finger_pd.py`: its tip draws a figure of eight, at 100 Hz.

Every 10 ms a linear model says where the tip will be in the next 0.2 s, and a quadratic program finds the
tensions that keep it nearest to its way, within their limits and rates. The model is exact for small motions
about an equilibrium and for tensions that are held in between; it is made anew at every step, or once at the
start. PD control has the same limits. Controllers see the state of the simulation as it is, without noise.

Needs SciPy, PIQP and threadpoolctl (`pip install scipy piqp threadpoolctl`); with `--plot FILE` Matplotlib
draws the ways of the tip.
"""

import argparse
import time
from dataclasses import dataclass

import numpy as np
import piqp
from finger_pd import CONTROL_STEP, feedback, finger, holding, tensions, tip
from scipy.linalg import expm
from threadpoolctl import threadpool_limits

import lissom

LARGEST = 2.0  # N
FASTEST = 20.0  # N/s
STEPS = 20  # of a prediction
# How much the square of a change by a newton, and of a newton itself, counts beside that of a metre.
CHANGE, EFFORT = 1e-6, 1e-7

PERIOD, WIDTH, HEIGHT = 1.0, 0.03, 0.015  # of the figure of eight, s and m
DURATION = 3.0  # s
SETTLED = 0.5  # s: from where on errors count, since the finger begins at rest


def target(t):
    """Where the tip shall be across the finger, at one time or many."""
    phase = 2 * np.pi * np.asarray(t) / PERIOD
    return np.stack([WIDTH * np.sin(phase), HEIGHT * np.sin(2 * phase)], axis=-1)


def within_limits(u, before):
    """Tensions that the motors can give when they gave others a step before."""
    change = FASTEST * CONTROL_STEP
    return np.clip(u, np.maximum(before - change, 0.0), np.minimum(before + change, LARGEST))


class Prediction:
    """Where the tip goes in the next steps, by a linear model about a state at rest.

    With the deviations x from that state, x' = A x + B (u - u0) + f: f is the acceleration there.
    """

    def __init__(self, q, u):
        self.q, self.u = q, u
        linear = lissom.linearise(finger, q, "inputs", ["tip_position_y", "tip_position_z"], u=u, held=True)
        states, inputs = linear.B.shape
        # One exponential has all that happens in a step while u and f are held (Van Loan 1978).
        rates = np.zeros((states + inputs + 1, states + inputs + 1))
        rates[:states] = np.column_stack([linear.A, linear.B, np.zeros(states)])
        rates[finger.n : states, -1] = finger.forward_dynamics(q, np.zeros(finger.n), u=u)
        step = expm(CONTROL_STEP * rates)[:states]
        A, B, f = step[:, :states], step[:, states:-1], step[:, -1]
        rows = [linear.C]
        for _ in range(STEPS):
            rows.append(rows[-1] @ A)
        self.of_state = np.array(rows[1:])
        self.drift = tip(q) + np.cumsum([row @ f for row in rows[:-1]], axis=0)
        # Each step answers to the tensions of all steps up to it.
        answers = np.array([row @ B for row in rows[:-1]])
        lag = np.subtract.outer(np.arange(STEPS), np.arange(STEPS))[..., None, None]
        self.of_inputs = np.where(lag < 0, 0.0, answers[lag[..., 0, 0]]).transpose(0, 2, 1, 3)

    def untouched(self, q, v):
        """The way of the tip if no tendon pulls, of shape (STEPS, 2)."""
        held = self.of_inputs.sum(axis=2) @ self.u
        return self.drift + self.of_state @ np.concatenate([q - self.q, v]) - held


class PredictiveControl:
    """The tensions with the least squares of errors, of changes and, so that few pull, of themselves."""

    def __init__(self, relinearise):
        self.relinearise = relinearise
        self.prediction = None
        inputs = len(finger.inputs)
        self.size = STEPS * inputs
        self.differences = np.eye(self.size) - np.eye(self.size, k=-inputs)
        self.cost = CHANGE * self.differences.T @ self.differences + EFFORT * np.eye(self.size)

    def __call__(self, t, q, v, before):
        if self.relinearise or self.prediction is None:
            self.prediction = Prediction(q, before)
        answers = self.prediction.of_inputs.reshape(-1, self.size)
        way = target(t + CONTROL_STEP * np.arange(1, STEPS + 1))
        error = self.prediction.untouched(q, v) - way
        gradient = answers.T @ error.ravel()
        gradient[: before.size] -= CHANGE * before
        # Rates of the first step are about what the tendons pull now.
        change = np.full(self.size, FASTEST * CONTROL_STEP)
        last = np.concatenate([before, np.zeros(self.size - before.size)])
        solver = piqp.DenseSolver()
        solver.setup(
            (answers.T @ answers + self.cost) / CHANGE,
            gradient / CHANGE,
            G=self.differences,
            h_l=last - change,
            h_u=last + change,
            x_l=np.zeros(self.size),
            x_u=np.full(self.size, LARGEST),
        )
        status = solver.solve()
        if status != piqp.PIQP_SOLVED:
            raise SystemExit(f"at {t:.2f} s: {status}")
        return solver.result.x[: before.size]


class ProportionalControl:
    """PD control of `finger_pd.py`; if `hold`, on top of the tensions that hold the finger there."""

    def __init__(self, hold):
        self.held = np.zeros((round(PERIOD / CONTROL_STEP), len(finger.inputs)))
        if hold:
            self.held[:] = [holding(target(CONTROL_STEP * step)) for step in range(len(self.held))]

    def __call__(self, t, q, v, before):
        held = self.held[round(t / CONTROL_STEP + 1) % len(self.held)]
        demand = feedback(q, v, target(t + CONTROL_STEP))
        return tensions(demand + held[::2] - held[1::2])


@dataclass
class Run:
    """What a controller did: times, places of the tip, tensions, seconds that each control step took."""

    t: np.ndarray
    tip: np.ndarray
    u: np.ndarray
    seconds: np.ndarray

    @property
    def errors(self):
        """Distances of the tip from its target, metres, once it has got there."""
        settled = self.t > SETTLED
        return np.linalg.norm(self.tip - target(self.t), axis=1)[settled]


def follow(control, duration=DURATION):
    """Let a controller move the finger, from where it hangs without tensions."""
    simulation = lissom.Simulation(finger, dt=1e-3, q0=lissom.statics(finger).q)
    steps = round(duration / CONTROL_STEP)
    run = Run(np.empty(steps), np.empty((steps, 2)), np.empty((steps, 4)), np.empty(steps))
    for step in range(steps):
        start = time.perf_counter()
        u = control(simulation.t, simulation.q, simulation.v, simulation.u)
        run.seconds[step] = time.perf_counter() - start
        run.u[step] = within_limits(u, simulation.u)
        status = simulation.step(run.u[step], duration=CONTROL_STEP)
        assert status == "finished", simulation.message
        run.t[step], run.tip[step] = simulation.t, tip(simulation.q)
    return run


def controllers():
    """By their names."""
    return {
        "PD": ProportionalControl(hold=False),
        "PD and holding tensions": ProportionalControl(hold=True),
        "MPC, one linear model": PredictiveControl(relinearise=False),
        "MPC, a new one each step": PredictiveControl(relinearise=True),
    }


def main():
    """Print the errors and the times of all controllers."""
    parser = argparse.ArgumentParser(description="Model-predictive control of a tendon finger.")
    parser.add_argument("--plot", help="picture of the ways of the tip")
    arguments = parser.parse_args()
    # For matrices as small as these more threads only wait for each other.
    with threadpool_limits(1):
        runs = {name: follow(control) for name, control in controllers().items()}
    print("                            error of the tip (mm)  control step (ms)     largest tension, rate")
    print("                              r.m.s.      largest  median  99 %  worst       (N)       (N/s)")
    for name, run in runs.items():
        error, worst = 1e3 * np.sqrt(np.mean(run.errors**2)), 1e3 * run.errors.max()
        median, most, longest = 1e3 * np.quantile(run.seconds, [0.5, 0.99, 1.0])
        rate = np.abs(np.diff(run.u, axis=0, prepend=0.0)).max() / CONTROL_STEP
        print(
            f"{name:26} {error:9.3f} {worst:12.3f} {median:7.2f} {most:5.2f} {longest:6.2f}"
            f" {run.u.max():9.2f} {rate:11.1f}"
        )
    late = sum(np.count_nonzero(run.seconds > CONTROL_STEP) for run in runs.values())
    print(f"{late} of {sum(run.t.size for run in runs.values())} control steps took more than 10 ms")
    if arguments.plot:
        draw(arguments.plot, runs)


def draw(path, runs):
    """The ways of the tip, and the tensions of the last controller."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (ways, pulls) = pyplot.subplots(1, 2, figsize=(11, 4.4), layout="constrained")
    period = np.linspace(0.0, PERIOD, 200)
    ways.plot(*1e3 * target(period).T, "k--", linewidth=1, label="target")
    for name, run in runs.items():
        ways.plot(*1e3 * run.tip.T, linewidth=1, label=name)
    ways.set(xlabel="y [mm]", ylabel="z [mm]", aspect="equal", title="Tip")
    ways.legend(fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=3)
    for name, pull in zip(finger.inputs, run.u.T, strict=True):
        pulls.step(run.t, pull, where="pre", linewidth=1, label=name)
    pulls.set(xlabel="t [s]", ylabel="tension [N]", title="Tensions of MPC with a new model each step")
    pulls.legend(fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=4)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main()
