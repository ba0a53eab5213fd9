"""Part 3 of the lab, the spring pendulum: figures 4 to 6 and table 1."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ...._lissom import MotionResult, SpringPendulum, simulate
from ....drawing.report import plots, theme
from ....drawing.report.page import Figure, Lesson, Section, Table
from ....drawing.report.plots import Axis, Curve, Plot
from ....drawing.report.text import quantity
from . import published
from .part import NUMERIC, RUN_COLUMNS, Part, run_cells, steps_too_long_on_purpose, stopped, timed_run
from .setup import COARSE_STEP, PENDULUM, Setup

#: Simulated time of table 1, and of the figures, seconds.
LONG, SHOWN = 1000.0, 20.0

#: Tolerance of the reference solution.
REFERENCE_TOLERANCE = 1e-12

#: Motions by name, with the colours and styles of their curves.
Paths = dict[str, tuple[Any, str, plots.Style]]

TIME = Axis("time (s)")

#: Number of points of a curve.
POINTS = 2001

#: The short step of the report's table 1, seconds.
REPORT_STEP = 1e-2

#: Implicit steps per period from which on the path is right to some percent (phase error (ω h)² / 12).
STEPS_PER_PERIOD = 10


@steps_too_long_on_purpose()
def part(setup: Setup) -> Part:
    """The motion by both methods, and run times for 1000 s."""
    pendulum = SpringPendulum(mass=setup.mass, stiffness=setup.stiffness)
    start = (setup.angle, setup.elongation)
    times = np.linspace(0.0, SHOWN, POINTS)
    tight: dict[str, Any] = {"rtol": REFERENCE_TOLERANCE, "atol": REFERENCE_TOLERANCE}
    reference = simulate(pendulum, SHOWN, q0=start, method="rk45", t_eval=times, **tight)
    explicit = simulate(pendulum, SHOWN, q0=start, method="rk45", t_eval=times)
    fine = simulate(pendulum, SHOWN, q0=start, dt=setup.dt, t_eval=times)
    coarse = simulate(pendulum, SHOWN, q0=start, dt=COARSE_STEP)
    paths: Paths = {
        f"implicit, step {setup.dt:g} s": (fine, theme.BLUE, "solid"),
        "explicit": (explicit, theme.ORANGE, "dash"),
        "reference": (reference, theme.GREY, "dot"),
    }
    error = largest_difference(fine, reference)
    right, wrong = energies(pendulum, reference)
    runs = long_runs(pendulum, setup)
    sections = [
        figure_4(pendulum, paths, setup, error),
        figure_5(pendulum, coarse, reference),
        figure_6(reference.t, right, wrong),
        table_1(runs, setup),
    ]
    numbers = {
        "table_1": runs,
        "implicit_error_20_s": error if fine.success and reference.success else None,
        "energy_change_right": float(np.ptp(right)),
        "energy_change_report": float(np.ptp(wrong)),
    }
    return Part(sections, numbers)


def figure_4(pendulum: SpringPendulum, paths: Paths, setup: Setup, error: float) -> Section:
    """The motion by both methods."""
    over = min(motion.t[-1] for motion, *_ in paths.values())
    ended = "".join(stopped(f"The run “{name}”", motion) for name, (motion, *_) in paths.items())
    return Section(
        "Figure 4: the spring pendulum",
        [
            Figure(
                trajectories(pendulum, paths),
                f"From the angle {setup.angle:.4g} rad and the elongation {setup.elongation:g} m, at rest.",
            ),
            Lesson(
                f"Over {over:g} s the implicit path at a step of {setup.dt:g} s departs from the reference "
                f"by at most {error:.2g} (rad or m).{ended} Large motions are chaotic: in longer runs only "
                "energies can be compared."
            ),
        ],
    )


def figure_5(pendulum: SpringPendulum, coarse: MotionResult, reference: MotionResult) -> Section:
    """The motion with a step of 1 s."""
    spring, swing = small_periods(pendulum)
    resolved = min(spring, swing) / STEPS_PER_PERIOD > COARSE_STEP
    verdict = "" if resolved else "A step of 1 s is too long for this pendulum: "
    if coarse.success and not reference.success:
        found = f"the path goes on to {SHOWN:g} s.{stopped('The reference', reference)}"
    elif coarse.success:
        found = (
            f"after {SHOWN:g} s the angle is {coarse.q[-1, 0]:,.1f} rad instead of {reference.q[-1, 0]:.1f}."
        )
    else:
        found = (
            f"the path has left the pendulum's after the first step, and at {coarse.t[-1]:g} s Newton's "
            "method does not converge: the step's equations may have several solutions far from the last "
            "state, or none. lissom says so and stops; a loop that accepts the step anyway goes on with "
            "something else."
        )
    return Section(
        "Figure 5: a step of 1 s",
        [
            Figure(
                coarse_figure(coarse, reference),
                f"The pendulum's own periods of small motions are {spring:.2g} s (the spring) and "
                f"{swing:.2g} s (the swing).",
            ),
            Lesson(f"{verdict}{found} A run time says nothing without an error beside it."),
        ],
    )


def figure_6(t: Any, right: Any, wrong: Any) -> Section:
    """The energy by the correct formula and by the report's."""
    return Section(
        "Figure 6: energy",
        [
            Figure(
                energy_figure(t, right, wrong),
                "Change of the total energy along the reference path, by the right kinetic energy and by the "
                "report's.",
            ),
            Lesson(
                "The report prints the kinetic energy with 1/(l + q₂)². It is ½ m (q̇₂² + (l + q₂)² q̇₁²): "
                f"with the printed one the total wanders by {quantity(float(np.ptp(wrong)), 'J')}, with the "
                f"right one by {quantity(float(np.ptp(right)), 'J', 2)}."
            ),
        ],
    )


def small_periods(pendulum: SpringPendulum) -> tuple[float, float]:
    """Periods in seconds of small motions about rest: along the spring, and of the swing."""
    hanging = pendulum.length + pendulum.mass * pendulum.gravity / pendulum.stiffness
    squares = (pendulum.mass / pendulum.stiffness, hanging / pendulum.gravity)
    spring, swing = 2.0 * np.pi * np.sqrt(squares)
    return float(spring), float(swing)


def largest_difference(motion: MotionResult, reference: MotionResult) -> float:
    """Largest difference of coordinates, as far as both motions go."""
    both = min(len(motion.q), len(reference.q))
    return float(np.max(np.abs(motion.q[:both] - reference.q[:both])))


def long_runs(pendulum: SpringPendulum, setup: Setup) -> list[dict[str, Any]]:
    """Timed runs of 1000 s by both methods with both steps, beside the report's run times."""
    runs = []
    start = (setup.angle, setup.elongation)
    for step in (COARSE_STEP, setup.dt):
        beside = published.of_step(published.PENDULUM, step, setup.is_the_labs(PENDULUM))
        output = np.arange(0.0, LONG + 0.5 * step, step)
        variants: dict[str, dict[str, Any]] = {
            "implicit": {"dt": step},
            "explicit": {"method": "rk45", "rtol": 1e-3, "atol": 1e-6, "t_eval": output},
        }
        for method, options in variants.items():
            simulation = partial(simulate, pendulum, LONG, q0=start, **options)
            motion, numbers = timed_run(None if beside is None else beside[method], simulation)
            assert motion.balance is not None, "a model was simulated"
            drift = motion.balance.drift
            runs.append({"step": step, "method": method, **numbers, "energy_drift": drift})
    return runs


def table_1(runs: list[dict[str, Any]], setup: Setup) -> Section:
    """Run times beside the report's."""
    rows = [
        (
            f"{run['step']:g} s",
            run["method"],
            *run_cells(run),
            f"{run['energy_drift']:.2g}",
        )
        for run in runs
    ]
    columns = ("step", "method", *RUN_COLUMNS, "energy drift")
    caption = (
        f"{LONG:g} s simulated. Explicit: Dormand-Prince at ode45's default tolerances, with output at the "
        "step. Energy drift: largest change of the total, relative to the largest energy that moved."
    )
    implicit, explicit = runs[2:]
    if implicit["success"] and explicit["success"]:
        ratio = implicit["lissom_seconds"] / explicit["lissom_seconds"]
        here = f"here, at a step of {setup.dt:g} s, it takes {ratio:.2g} times as long"
    else:
        here = f"here, at a step of {setup.dt:g} s, a run stopped before its end, and there is no such ratio"
    beside = published.PENDULUM[REPORT_STEP]
    return Section(
        "Table 1: run time of the pendulum",
        [
            Table(columns, rows, NUMERIC | {"energy drift"}, caption),
            Lesson(
                f"In the report the implicit method at a step of {REPORT_STEP:g} s takes "
                f"{beside['implicit'] / beside['explicit']:.0f} times as long as the explicit one; {here}. "
                "Such a ratio is one of implementations more than of methods."
            ),
        ],
    )


def energies(pendulum: SpringPendulum, motion: Any) -> tuple[Any, Any]:
    """Change of the total energy along a motion, with the correct kinetic energy and with the report's."""
    right = motion.balance
    r = pendulum.length + motion.q[:, 1]
    printed = 0.5 * pendulum.mass * (motion.v[:, 1] ** 2 + motion.v[:, 0] ** 2 / r**2)
    wrong = printed + right.elastic + right.gravitational
    return right.total - right.total[0], wrong - wrong[0]


def trajectories(pendulum: SpringPendulum, paths: Paths) -> plots.Figure:
    """Figure 4."""
    path, angle, elongation = [], [], []
    for name, (motion, colour, style) in paths.items():
        turned, longer = motion.q.T
        r = pendulum.length + longer
        path.append(Curve(name, r * np.cos(turned), r * np.sin(turned), colour, style, 1.6))
        angle.append(Curve(name, motion.t, turned, colour, style, 1.6))
        elongation.append(Curve(name, motion.t, longer, colour, style, 1.6))
    rows = [
        [Plot(Axis("x (m)"), Axis("y (m)"), path, to_scale=True)],
        [Plot(TIME, Axis("angle (rad)"), angle), Plot(TIME, Axis("elongation (m)"), elongation)],
    ]
    return plots.Figure(rows, 320)


def coarse_figure(coarse: Any, reference: Any) -> plots.Figure:
    """Figure 5."""
    rows = []
    for i, label in enumerate(("angle (rad)", "elongation (m)")):
        curves = [
            Curve("reference", reference.t, reference.q[:, i], theme.GREY, width=1.6),
            Curve("implicit, step 1 s", coarse.t, coarse.q[:, i], theme.RED, "dot", mark="disc"),
        ]
        rows.append([Plot(TIME, Axis(label), curves)])
    return plots.Figure(rows, 250)


def energy_figure(t: Any, right: Any, wrong: Any) -> plots.Figure:
    """Figure 6."""
    curves = [
        Curve("as printed in the report", t, wrong, theme.RED, width=1.6),
        Curve("right", t, right, theme.GREEN, width=2.4),
    ]
    return plots.Figure([[Plot(TIME, Axis("change of the total (J)"), curves)]], 400)
