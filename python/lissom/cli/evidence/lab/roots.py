"""Part 1 of the lab, root finding: figures 1 to 3."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...._lissom import root
from ....drawing.report import plots, theme
from ....drawing.report.page import Figure, Lesson, Section, Table
from ....drawing.report.plots import Axis, Curve, Note, Plot
from .part import Part
from .setup import Setup

#: Results by function, start and Jacobian.
Searches = dict[tuple[str, float, str], Any]

COLOURS = {"analytic": theme.BLUE, "forward": theme.ORANGE, "central": theme.GREEN}
STYLES: dict[str, plots.Style] = {"analytic": "solid", "forward": "dash", "central": "dot"}

#: The lab's stopping rule: ||R|| below this, or this number of iterations.
TOLERANCE, MOST_ITERATIONS = 1e-6, 1000

#: lissom's statuses in words.
OUTCOMES = {
    "converged_residual": "root found",
    "already_root": "the start is a root",
    "stationary_point": "stationary point, not a root",
}

#: Smaller residuals, including zero, are plotted at this value.
LEAST_SHOWN = 1e-17

#: Point at which the error of difference Jacobians is shown.
DIFFERENCED_AT = 6.0


def f(x: Any) -> Any:
    """x^4 - 4x^3 + 5x^2 - 2x + 1/4 = (x^2 - 2x + 1/2)^2."""
    return x**4 - 4.0 * x**3 + 5.0 * x**2 - 2.0 * x + 0.25


def f2(x: Any) -> Any:
    """f - 1/4 = x (x - 2) (x - 1)^2."""
    return f(x) - 0.25


def slope(x: Any) -> Any:
    """Derivative of both."""
    return 4.0 * x**3 - 12.0 * x**2 + 10.0 * x - 2.0


#: Argument of ``root`` for each Jacobian.
JACOBIANS: dict[str, Any] = {"analytic": slope, "forward": "forward", "central": "central"}

FUNCTIONS = {"f": f, "f₂": f2}


def lab_loop(function: Any, x: float) -> int:
    """Number of iterations of the lab's loop, x <- x - pinv(J) R."""
    for iteration in range(MOST_ITERATIONS):
        if abs(function(x)) < TOLERANCE:
            return iteration
        x -= float(np.linalg.pinv([[slope(x)]])[0, 0]) * function(x)
    return MOST_ITERATIONS


def part(setup: Setup) -> Part:
    """All searches, from all starts and with all Jacobians."""
    starts = setup.start
    searches = {
        (name, start, jacobian): root(function, start, jac=jac, tol=TOLERANCE, history=True)
        for name, function in FUNCTIONS.items()
        for start in starts
        for jacobian, jac in JACOBIANS.items()
    }
    stuck = lab_loop(f, 1.0)
    steps, errors = difference_errors()
    numbers = {
        "searches": [
            {
                "function": name,
                "start": start,
                "jacobian": jacobian,
                "x": float(found.x),
                "status": found.status,
                "iterations": found.nit,
                "evaluations": found.nfev,
                "residuals": [float(r) for r in _history(found)["residual_norm"]],
            }
            for (name, start, jacobian), found in searches.items()
        ],
        "lab_loop_iterations_from_1": stuck,
        "difference_errors": {"step": steps.tolist(), **{k: e.tolist() for k, e in errors.items()}},
    }
    sections = [figure_1(searches, starts), figure_2(searches, starts, stuck), figure_3(steps, errors)]
    return Part(sections, numbers)


def figure_1(searches: Searches, starts: tuple[float, ...]) -> Section:
    """The functions and the iterates."""
    counted = [
        f"{found.nit} steps from x = {start:g}"
        for start in starts
        if (found := searches["f", start, "analytic"]).status == "converged_residual"
    ]
    # One example is enough, and no start needs to lead to a root.
    example = f": {counted[0]}, without ever becoming faster" if counted else ""
    return Section(
        "Figure 1: the functions and the iterates",
        [
            "f(x) = x⁴ − 4x³ + 5x² − 2x + 1/4 and f₂ = f − 1/4, with the points that Newton's method visits "
            "(analytic Jacobian; those outside the frame are not drawn).",
            Figure(functions(searches, starts)),
            Lesson(
                "f = (x² − 2x + 1/2)² has two double roots, 1 ± 1/√2. At a double root the derivative "
                "vanishes with the function, so Newton's method only halves its error in each step"
                f"{example}. f₂ = x (x − 2) (x − 1)² has simple roots at 0 and 2, where convergence is "
                "quadratic at last, and a double one at 1."
            ),
        ],
    )


def figure_2(searches: Searches, starts: tuple[float, ...], stuck: int) -> Section:
    """Convergence of the searches; ``stuck`` is the number of iterations of the lab's loop from x = 1."""
    rows = [
        (
            name,
            f"{start:g}",
            jacobian,
            f"{found.x:.10g}",
            OUTCOMES.get(found.status, found.status),
            str(found.nit),
            str(found.nfev),
        )
        for (name, start, jacobian), found in searches.items()
    ]
    columns = ("function", "start", "Jacobian", "x", "outcome", "iterations", "evaluations")
    return Section(
        "Figure 2: convergence with the three Jacobians",
        [
            Figure(
                convergence(searches, starts),
                "Residual at each iterate (zero is drawn at 10⁻¹⁷). The dotted line is the lab's tolerance, "
                "10⁻⁶. The curves of the three Jacobians may cover each other.",
            ),
            Table(columns, rows, frozenset({"x", "iterations", "evaluations"})),
            Lesson(
                "The report calls x = 1 a saddle of f. It is a local maximum, with f(1) = 1/4 and f'(1) = 0: "
                f"the Jacobian is singular, pinv(0) = 0, and the lab's loop stands still ({stuck} iterations "
                "here, without moving). Differences leave such a point only by their own truncation or "
                "rounding error, which is luck. lissom says “stationary point, not a root”."
            ),
        ],
    )


def figure_3(steps: Any, errors: dict[str, Any]) -> Section:
    """Error of difference Jacobians."""
    return Section(
        "Figure 3: the error of difference Jacobians",
        [
            Figure(
                difference_figure(steps, errors),
                f"Relative error of f'({DIFFERENCED_AT:g}) against the step h. To the right truncation "
                "grows as h (forward) and h² (central), to the left rounding grows as 1/h.",
            ),
            Lesson(
                "The best step is about √ε x for forward and ε^(1/3) x for central differences, ε = "
                "2.2·10⁻¹⁶; it gives about 8 and 11 digits. A step chosen without regard to the size of x "
                "loses them."
            ),
        ],
    )


def _history(found: Any) -> dict[str, Any]:
    history: dict[str, Any] = found.history
    return history


def functions(searches: Searches, starts: tuple[float, ...]) -> plots.Figure:
    """Figure 1."""
    x = np.linspace(-0.35, 2.6, 400)
    styles: tuple[plots.Style, ...] = ("solid", "dash")
    curves = [
        Curve(name, x, function(x), theme.GREY, style, 2.0)
        for (name, function), style in zip(FUNCTIONS.items(), styles, strict=True)
    ]
    for (name, start, jacobian), found in searches.items():
        if jacobian != "analytic":
            continue
        visited = _history(found)["x"]
        near = visited[np.abs(visited) < 3.2]
        curves.append(
            Curve(
                f"{name} from {start:g}",
                near,
                FUNCTIONS[name](near),
                theme.SERIES[starts.index(start)],
                joined=False,
                mark="disc" if name == "f" else "diamond",
            )
        )
    roots = np.array([1.0 - np.sqrt(0.5), 1.0 + np.sqrt(0.5)])
    curves.append(Curve("double roots of f", roots, np.zeros(2), theme.RED, joined=False, mark="ring"))
    plot = Plot(Axis("x", range=(-0.35, 2.6)), Axis("value", range=(-0.35, 1.6)), curves)
    return plots.Figure([[plot]], 440)


def convergence(searches: Searches, starts: tuple[float, ...]) -> plots.Figure:
    """Figure 2."""
    rows = []
    for name in FUNCTIONS:
        row = []
        for start in starts:
            curves = []
            for jacobian, style in STYLES.items():
                residuals = np.maximum(
                    _history(searches[name, start, jacobian])["residual_norm"], LEAST_SHOWN
                )
                iterations = np.arange(len(residuals))
                curves.append(Curve(jacobian, iterations, residuals, COLOURS[jacobian], style, mark="disc"))
            y = Axis("|R|", log=True, range=(10**-17.5, 10**3.5))
            tolerance = Note("y", TOLERANCE, theme.GREY)
            row.append(Plot(Axis("iteration"), y, curves, f"{name} from {start:g}", [tolerance]))
        rows.append(row)
    return plots.Figure(rows, 290)


def difference_errors() -> tuple[Any, dict[str, Any]]:
    """Steps, and the relative error of the derivative for each kind of difference."""
    x, steps = DIFFERENCED_AT, np.logspace(-16, 0, 129)
    after, before = x + steps, x - steps
    with np.errstate(divide="ignore", invalid="ignore"):
        found = {
            "forward": (f(after) - f(x)) / (after - x),
            "central": (f(after) - f(before)) / (after - before),
        }
    errors = {kind: np.abs(derivative / slope(x) - 1.0) for kind, derivative in found.items()}
    # A step below rounding gives no derivative.
    return steps, {kind: np.nan_to_num(error, nan=1.0, posinf=1.0) for kind, error in errors.items()}


def difference_figure(steps: Any, errors: dict[str, Any]) -> plots.Figure:
    """Figure 3."""
    epsilon = np.finfo(float).eps
    best = {"forward": (np.sqrt(epsilon), "√ε x"), "central": (np.cbrt(epsilon), "ε^(1/3) x")}
    curves = [Curve(kind, steps, error, COLOURS[kind]) for kind, error in errors.items()]
    notes = [
        Note("x", float(best[kind][0] * DIFFERENCED_AT), COLOURS[kind], best[kind][1]) for kind in errors
    ]
    x, y = Axis("step h", log=True), Axis("relative error", log=True)
    return plots.Figure([[Plot(x, y, curves, notes=notes)]], 420)
