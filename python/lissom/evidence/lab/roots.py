"""Part 1 of the lab, root finding: figures 1 to 3."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._lissom import root
from ...report import theme
from ...report.page import Figure, Lesson, Section, Table
from .part import Part

#: Results by function, start and Jacobian.
Searches = dict[tuple[str, float, str], Any]

STARTS = (6.0, 1.0, 0.7)
COLOURS = {"analytic": theme.BLUE, "forward": theme.ORANGE, "central": theme.GREEN}
DASHES = {"analytic": "solid", "forward": "dash", "central": "dot"}

#: The lab's stop: ||R|| below this, or so many iterations.
TOLERANCE, MOST_ITERATIONS = 1e-6, 1000

#: lissom's statuses in words.
OUTCOMES = {
    "converged_residual": "root found",
    "already_root": "the start is a root",
    "stationary_point": "stationary point, not a root",
}

#: Residuals below this are shown at it, zero included.
LEAST_SHOWN = 1e-17

#: Where the error of difference Jacobians is shown.
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


#: What ``root`` takes for each Jacobian.
JACOBIANS: dict[str, Any] = {"analytic": slope, "forward": "forward", "central": "central"}

FUNCTIONS = {"f": f, "f₂": f2}


def lab_loop(function: Any, x: float) -> int:
    """The lab's loop, x <- x - pinv(J) R: the number of iterations that it takes."""
    for iteration in range(MOST_ITERATIONS):
        if abs(function(x)) < TOLERANCE:
            return iteration
        x -= float(np.linalg.pinv([[slope(x)]])[0, 0]) * function(x)
    return MOST_ITERATIONS


def part() -> Part:
    """All searches, from all starts, with all Jacobians."""
    searches = {
        (name, start, jacobian): root(function, start, jac=jac, tol=TOLERANCE, history=True)
        for name, function in FUNCTIONS.items()
        for start in STARTS
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
    return Part([figure_1(searches), figure_2(searches, stuck), figure_3(steps, errors)], numbers)


def figure_1(searches: Searches) -> Section:
    """The functions and the iterates."""
    iterations = searches["f", 6.0, "analytic"].nit
    return Section(
        "Figure 1: the functions and the iterates",
        [
            "f(x) = x⁴ − 4x³ + 5x² − 2x + 1/4 and f₂ = f − 1/4, with the points that Newton's method visits "
            "(analytic Jacobian; the first ones from 6 lie outside the frame).",
            Figure(functions(searches)),
            Lesson(
                "f = (x² − 2x + 1/2)² has two double roots, 1 ± 1/√2. At a double root the derivative "
                "vanishes with the function, so Newton's method only halves its error in each step: "
                f"{iterations} steps from x = 6, without ever becoming faster. f₂ = x (x − 2) (x − 1)² has "
                "simple roots at 0 and 2, where convergence is quadratic at last, and a double one at 1."
            ),
        ],
    )


def figure_2(searches: Searches, stuck: int) -> Section:
    """How the searches converge; ``stuck`` is the number of iterations of the lab's loop from x = 1."""
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
                convergence(searches),
                "Residual at each iterate (zero is drawn at 10⁻¹⁷). The dotted line is the lab's tolerance, "
                "10⁻⁶; the three Jacobians differ by less than the lines are wide.",
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
    """The error of difference Jacobians."""
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


def functions(searches: Searches) -> Any:
    """Figure 1."""
    import plotly.graph_objects as go

    x = np.linspace(-0.35, 2.6, 400)
    figure = go.Figure()
    for (name, function), dash in zip(FUNCTIONS.items(), ("solid", "dash"), strict=True):
        line = {"color": theme.GREY, "width": 2, "dash": dash}
        figure.add_scatter(x=x, y=function(x), name=name, mode="lines", line=line)
    symbols = {"f": "circle", "f₂": "diamond"}
    for (name, start, jacobian), found in searches.items():
        if jacobian != "analytic":
            continue
        colour = theme.SERIES[STARTS.index(start)]
        visited = _history(found)["x"]
        near = visited[visited < 3.2]
        figure.add_scatter(
            x=near,
            y=FUNCTIONS[name](near),
            name=f"{name} from {start:g}",
            mode="markers",
            marker={"color": colour, "size": 8, "symbol": symbols[name]},
        )
    roots = [1.0 - np.sqrt(0.5), 1.0 + np.sqrt(0.5)]
    figure.add_scatter(
        x=roots,
        y=[0.0, 0.0],
        name="double roots of f",
        mode="markers",
        marker={"size": 15, "symbol": "circle-open", "color": theme.RED, "line": {"width": 2}},
    )
    y = theme.axis("value", range=[-0.35, 1.6])
    figure.update_layout(**theme.layout(440, xaxis=theme.axis("x", range=[-0.35, 2.6]), yaxis=y))
    return figure


def convergence(searches: Searches) -> Any:
    """Figure 2."""
    from plotly.subplots import make_subplots

    titles = [f"{name} from {start:g}" for name in FUNCTIONS for start in STARTS]
    figure = make_subplots(
        rows=2, cols=3, subplot_titles=titles, horizontal_spacing=0.07, vertical_spacing=0.15
    )
    for (name, start, jacobian), found in searches.items():
        residuals = _history(found)["residual_norm"]
        row, column = list(FUNCTIONS).index(name) + 1, STARTS.index(start) + 1
        figure.add_scatter(
            y=np.maximum(residuals, LEAST_SHOWN),
            name=jacobian,
            legendgroup=jacobian,
            showlegend=(row, column) == (1, 1),
            mode="lines+markers",
            line={"color": COLOURS[jacobian], "dash": DASHES[jacobian]},
            marker={"size": 5},
            row=row,
            col=column,
        )
        figure.add_hline(
            y=TOLERANCE, line={"color": theme.FAINT, "dash": "dot", "width": 1}, row=row, col=column
        )
    figure.update_xaxes(theme.axis("", rangemode="tozero"))
    figure.update_xaxes(title="iteration", row=2)
    figure.update_yaxes(theme.axis("", type="log", dtick=4, range=[-17.5, 3.5]))
    figure.update_yaxes(title="|R|", col=1)
    figure.update_layout(**theme.layout(600, legend={"orientation": "h", "y": 1.06, "yanchor": "bottom"}))
    return figure


def difference_errors() -> tuple[Any, dict[str, Any]]:
    """Steps, and the relative error of the derivative by each kind of difference."""
    x, steps = DIFFERENCED_AT, np.logspace(-16, 0, 129)
    after, before = x + steps, x - steps
    with np.errstate(divide="ignore", invalid="ignore"):
        found = {
            "forward": (f(after) - f(x)) / (after - x),
            "central": (f(after) - f(before)) / (after - before),
        }
    errors = {kind: np.abs(derivative / slope(x) - 1.0) for kind, derivative in found.items()}
    # A step lost in rounding gives no derivative at all.
    return steps, {kind: np.nan_to_num(error, nan=1.0, posinf=1.0) for kind, error in errors.items()}


def difference_figure(steps: Any, errors: dict[str, Any]) -> Any:
    """Figure 3."""
    import plotly.graph_objects as go

    figure = go.Figure()
    epsilon = np.finfo(float).eps
    best = {"forward": np.sqrt(epsilon), "central": np.cbrt(epsilon)}
    for kind, error in errors.items():
        figure.add_scatter(
            x=steps, y=error, name=kind, mode="lines", line={"color": COLOURS[kind], "width": 1.8}
        )
        figure.add_vline(
            x=float(best[kind] * DIFFERENCED_AT),
            line={"color": COLOURS[kind], "dash": "dot", "width": 1.5},
        )
        figure.add_annotation(
            x=float(np.log10(best[kind] * DIFFERENCED_AT)),
            y=0.0,
            text={"forward": "√ε x", "central": "ε<sup>1/3</sup> x"}[kind],
            font={"color": COLOURS[kind]},
            showarrow=False,
            xanchor="left",
            xshift=5,
            yanchor="bottom",
        )
    figure.update_layout(
        **theme.layout(
            420,
            xaxis=theme.axis("step h", type="log", dtick=2),
            yaxis=theme.axis("relative error", type="log", dtick=2),
        )
    )
    return figure
