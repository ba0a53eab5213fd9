"""Run time against error of the integrators of lissom and other packages, in one process.

    python benches/python/integrators/work_precision.py -o DIR [--quick] [--problem NAME ...]
        [--solver TEXT ...]

Needs numpy, scipy, numba and matplotlib. Uses scikit-sundae, diffrax and numbalsoda if they can be imported,
and reports those that cannot. Writes DIR/work_precision.json, .md and .png.

Error: largest component of the difference from a reference solution at the end of the interval (relative for
each component of the stiff problems). Run time: the shortest of several runs, without compilation; the first
run's time is in the JSON file.
"""

import argparse
import json
import platform
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numba
import numpy as np
import scipy
import scipy.integrate

import lissom._lissom
from problems import PROBLEMS, Problem

TOLERANCES = 10.0 ** np.arange(-3, -13, -1)
QUICK_TOLERANCES = 10.0 ** np.arange(-4, -13, -4)
# A measurement is repeated for this many seconds or runs.
SECONDS = 0.5
QUICK_SECONDS = 0.05
MOST_RUNS = 200
# For solvers that would otherwise not terminate.
MOST_STEPS = 200_000
# If a run takes longer (seconds), tighter tolerances are skipped.
LONGEST_RUN = 20.0

EXPLICIT = ("RK45", "DOP853")


@dataclass(frozen=True)
class Solver:
    """`prepare(problem)` returns `run(rtol, atol) -> (y, nfev, steps)`, or None for an unsuitable problem."""

    name: str
    prepare: Callable


@dataclass
class Curve:
    problem: str
    solver: str
    points: list = field(default_factory=list)


# ------------------------------------------------------------------------------------------------ solvers


def for_method(method, problem):
    """Explicit methods for nonstiff problems, implicit methods for stiff ones."""
    return problem.stiff == (method not in EXPLICIT)


def lissom_with(method, kind):
    def prepare(problem):
        if not for_method(method, problem):
            return None
        options = {"method": method.lower(), "t_eval": [problem.t_span[1]]}
        if kind == "native":
            if problem.name != "spring pendulum":
                return None
            fun = lissom.SpringPendulum(length=1.0, mass=1.0, stiffness=40.0, gravity=9.81)
        elif kind == "cfunc":
            fun = problem.cfunc()
            if method == "Radau":
                options["jac"] = problem.cfunc_jacobian()
        else:
            fun = problem.fun
            if method == "Radau":
                options["jac"] = problem.jac

        def run(rtol, atol):
            result = lissom.solve_ivp(fun, problem.t_span, problem.y0, rtol=rtol, atol=atol, **options)
            if not result.success:
                raise RuntimeError(result.message)
            return result.y[:, -1], result.nfev, result.naccepted

        return run

    return prepare


def scipy_with(method):
    def prepare(problem):
        if method != "LSODA" and not for_method(method, problem):
            return None
        options = {"method": method, "t_eval": [problem.t_span[1]]}
        if problem.stiff:
            options["jac"] = problem.jac

        def run(rtol, atol):
            result = scipy.integrate.solve_ivp(
                problem.fun, problem.t_span, problem.y0, rtol=rtol, atol=atol, **options
            )
            if not result.success:
                raise RuntimeError(result.message)
            return result.y[:, -1], result.nfev, None

        return run

    return prepare


def sundae_python(problem):
    """scikit-sundae with a Python right-hand side that writes into the array passed to it."""
    from sksundae.cvode import CVODE

    def rhs(t, y, dydt):
        dydt[:] = problem.fun(t, y)

    options = {"method": "BDF" if problem.stiff else "Adams"}
    if problem.stiff:

        def jacobian(t, y, f, matrix):
            matrix[:, :] = problem.jac(t, y)

        options["jacfn"] = jacobian
    times = np.array(problem.t_span)

    def run(rtol, atol):
        solver = CVODE(rhs, rtol=rtol, atol=atol, max_num_steps=10**9, **options)
        result = solver.solve(times, problem.y0)
        if not result.success:
            raise RuntimeError(result.message)
        return result.y[-1], result.nfev, None

    return run


def sundials_compiled(problem):
    """CVODE with right-hand sides and Jacobians compiled by numba."""
    from cvode import ADAMS, BDF, CompiledCvode

    return CompiledCvode(problem, BDF if problem.stiff else ADAMS).run


def diffrax_with(explicit, implicit):
    def prepare(problem):
        import diffrax
        import jax

        jax.config.update("jax_enable_x64", True)
        import jax.numpy as jnp

        solver_name = implicit if problem.stiff else explicit
        if solver_name is None:
            return None
        solver = getattr(diffrax, solver_name)()
        term = diffrax.ODETerm(problem.jax(jnp))
        t0, t1 = problem.t_span
        y0 = jnp.asarray(problem.y0)

        @jax.jit
        def integrate(rtol, atol):
            solution = diffrax.diffeqsolve(
                term,
                solver,
                t0,
                t1,
                None,
                y0,
                stepsize_controller=diffrax.PIDController(rtol=rtol, atol=atol),
                max_steps=MOST_STEPS,
                throw=False,
            )
            ok = solution.result == diffrax.RESULTS.successful
            return solution.ys[-1], solution.stats["num_steps"], ok

        def run(rtol, atol):
            y, steps, ok = jax.block_until_ready(integrate(rtol, atol))
            if not ok:
                raise RuntimeError("diffrax did not succeed")
            return np.asarray(y), None, int(steps)

        return run

    return prepare


def numbalsoda_with(name):
    def prepare(problem):
        import numbalsoda

        if name == "dop853" and problem.stiff:
            return None
        rhs = numba.cfunc(numbalsoda.lsoda_sig)(problem.write)
        times = np.array(problem.t_span)
        solve = getattr(numbalsoda, name)

        def run(rtol, atol):
            y, success = solve(rhs.address, problem.y0, times, rtol=rtol, atol=atol)
            if not success:
                raise RuntimeError("numbalsoda did not succeed")
            return y[-1], None, None

        return run

    return prepare


SOLVERS = [
    *(
        Solver(f"lissom {method} {kind}", lissom_with(method, kind))
        for method in ("RK45", "DOP853", "Radau")
        for kind in ("Python", "cfunc", "native")
    ),
    *(
        Solver(f"SciPy {method} Python", scipy_with(method))
        for method in ("RK45", "DOP853", "Radau", "LSODA")
    ),
    Solver("CVODE Python", sundae_python),
    Solver("CVODE cfunc", sundials_compiled),
    Solver("diffrax order 5", diffrax_with("Dopri5", "Kvaerno5")),
    Solver("diffrax order 8", diffrax_with("Dopri8", None)),
    Solver("numbalsoda lsoda", numbalsoda_with("lsoda")),
    Solver("numbalsoda dop853", numbalsoda_with("dop853")),
]


# ------------------------------------------------------------------------------------------------ measuring


def reference_state(problem: Problem):
    """The final state, far more accurate than all runs; from the literature if available."""
    if problem.final is not None:
        return problem.final
    options = {"rtol": 3e-14, "atol": 1e-15, "t_eval": [problem.t_span[1]]}
    ours = lissom.solve_ivp(problem.cfunc(), problem.t_span, problem.y0, "dop853", **options).y[:, -1]
    theirs = scipy.integrate.solve_ivp(problem.fun, problem.t_span, problem.y0, "DOP853", **options).y[:, -1]
    assert np.abs(ours - theirs).max() < 1e-11, "the reference solutions of lissom and SciPy differ"
    return ours


def measure(run, seconds):
    """Shortest run time, and the result of the run. The first run, which may compile, is not counted."""
    start = time.perf_counter()
    outcome = run()
    first = time.perf_counter() - start
    best, spent, runs = np.inf, 0.0, 0
    while runs < 2 or (spent < seconds and runs < MOST_RUNS):
        start = time.perf_counter()
        outcome = run()
        elapsed = time.perf_counter() - start
        best, spent, runs = min(best, elapsed), spent + elapsed, runs + 1
        if elapsed > LONGEST_RUN:
            break
    return outcome, best, first


def curve_of(problem, solver, tolerances, seconds, final):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = solver.prepare(problem)
        if run is None:
            return None
        curve = Curve(problem.name, solver.name)
        for tolerance in tolerances:
            atol = tolerance * problem.atol_ratio
            try:
                (y, nfev, steps), best, first = measure(lambda: run(tolerance, atol), seconds)  # noqa: B023
            except Exception as failure:  # a solver that gives up is a result, too
                curve.points.append({"rtol": tolerance, "failure": str(failure)[:200]})
                continue
            weights = 1.0 if problem.error_weights is None else problem.error_weights
            error = float(np.abs((y - final) * weights).max())
            curve.points.append(
                {
                    "rtol": tolerance,
                    "error": error,
                    "seconds": best,
                    "first": first,
                    "nfev": nfev,
                    "steps": steps,
                }
            )
            if best > LONGEST_RUN:
                break
    return curve


def time_at(curve, error):
    """Run time for an error, interpolated logarithmically between the points; NaN outside their range."""
    points = sorted(
        (point["error"], point["seconds"]) for point in curve.points if point.get("error", 0.0) > 0.0
    )
    if not points or not points[0][0] <= error <= points[-1][0]:
        return np.nan
    errors, seconds = np.array(points).T
    return float(np.exp(np.interp(np.log(error), np.log(errors), np.log(seconds))))


# ------------------------------------------------------------------------------------------------ report

# Ratio of run times at equal error: name, slower solver, faster solver, problems, goal.
NONSTIFF = ["spring pendulum", "Pleiades", "Arenstorf", "rigid body"]
STIFF = ["Van der Pol", "Robertson"]
GOALS = [
    *(
        (f"same Python function, {m}", f"SciPy {m} Python", f"lissom {m} Python", problems, 2.5)
        for m, problems in (("RK45", NONSTIFF), ("DOP853", NONSTIFF), ("Radau", STIFF))
    ),
    *(
        (f"cfunc, {m}", f"SciPy {m} Python", f"lissom {m} cfunc", problems, 100.0)
        for m, problems in (("RK45", NONSTIFF), ("DOP853", NONSTIFF), ("Radau", STIFF))
    ),
    ("native pendulum, RK45", "SciPy RK45 Python", "lissom RK45 native", ["spring pendulum"], 300.0),
    ("native pendulum, DOP853", "SciPy DOP853 Python", "lissom DOP853 native", ["spring pendulum"], 300.0),
    ("Radau against CVODE, both compiled", "CVODE cfunc", "lissom Radau cfunc", STIFF, 0.5),
]


def ratios(curves, slower, faster, problem):
    """Ratios of run times at the errors of the faster solver's points."""
    by_name = {(curve.problem, curve.solver): curve for curve in curves}
    one, other = by_name.get((problem, slower)), by_name.get((problem, faster))
    if one is None or other is None:
        return []
    found = [
        time_at(one, point["error"]) / point["seconds"]
        for point in other.points
        if point.get("error", 0.0) > 0.0
    ]
    return [ratio for ratio in found if np.isfinite(ratio)]


def markdown(curves, left_out, machine):
    lines = ["# Run time against error", "", *machine, ""]
    lines += [f"- Not measured: {name}: {reason}" for name, reason in left_out.items()]
    lines += [
        "",
        "## Goals",
        "",
        "How many times faster lissom is at equal error: smallest / median / largest.",
        "",
    ]
    lines += ["| | problem | ratio | goal |", "|---|---|---|---|"]
    for name, slower, faster, problems, goal in GOALS:
        for problem in problems:
            found = ratios(curves, slower, faster, problem)
            if found:
                text = " / ".join(f"{value:.3g}" for value in (min(found), np.median(found), max(found)))
                lines.append(f"| {name} | {problem} | {text} | {goal:g} |")
    lines.append("")
    for problem in dict.fromkeys(curve.problem for curve in curves):
        lines += [f"## {problem}", "", "Error, and microseconds, at a relative tolerance of", ""]
        own = [curve for curve in curves if curve.problem == problem]
        tolerances = sorted({point["rtol"] for curve in own for point in curve.points}, reverse=True)
        lines.append("| | " + " | ".join(f"{tolerance:.0e}" for tolerance in tolerances) + " |")
        lines.append("|---|" + "---|" * len(tolerances))
        for curve in own:
            points = {point["rtol"]: point for point in curve.points}
            cells = []
            for tolerance in tolerances:
                point = points.get(tolerance, {})
                measured = "seconds" in point
                failed = "failed" if "failure" in point else ""
                cells.append(f"{point['error']:.0e}, {1e6 * point['seconds']:.0f}" if measured else failed)
            lines.append(f"| {curve.solver} | " + " | ".join(cells) + " |")
        lines.append("")
    return "\n".join(lines)


def plot(curves, path):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    problems = list(dict.fromkeys(curve.problem for curve in curves))
    solvers = list(dict.fromkeys(curve.solver for curve in curves))
    columns = min(3, len(problems))
    rows = -(-len(problems) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(6 * columns, 5 * rows), squeeze=False)
    for axis, problem in zip(axes.flat, problems, strict=False):
        for curve in curves:
            points = [point for point in curve.points if point.get("error", 0.0) > 0.0]
            if curve.problem != problem or not points:
                continue
            family = curve.solver.split()[0]
            style = {"lissom": "o-", "SciPy": "s--", "CVODE": "^-."}.get(family, "x:")
            axis.loglog(
                [point["seconds"] for point in points],
                [point["error"] for point in points],
                style,
                color=f"C{solvers.index(curve.solver) % 10}",
                label=curve.solver,
                markersize=4,
            )
        axis.set(title=problem, xlabel="seconds", ylabel="error at the end")
        axis.grid(alpha=0.3)
        axis.legend(fontsize=6)
    for axis in list(axes.flat)[len(problems) :]:
        axis.remove()
    figure.tight_layout()
    figure.savefig(path, dpi=120)


def measured_curves(arguments):
    """The curves of the selected problems and solvers, and the reasons why solvers are missing, by their
    names."""
    tolerances = QUICK_TOLERANCES if arguments.quick else TOLERANCES
    seconds = QUICK_SECONDS if arguments.quick else SECONDS
    curves, left_out = [], {}
    for make in PROBLEMS:
        problem = make()
        if arguments.problem and not any(text.lower() in problem.name.lower() for text in arguments.problem):
            continue
        final = reference_state(problem)
        for solver in SOLVERS:
            if arguments.solver and not any(text.lower() in solver.name.lower() for text in arguments.solver):
                continue
            if solver.name in left_out:
                continue
            try:
                curve = curve_of(problem, solver, tolerances, seconds, final)
            except ImportError as failure:
                left_out[solver.name] = f"cannot be imported here ({failure})"
                continue
            if curve is None:
                continue
            curves.append(curve)
            measured = [point for point in curve.points if "seconds" in point]
            if measured:
                last = measured[-1]
                print(
                    f"{problem.name:16} {solver.name:24} rtol {last['rtol']:.0e}: error {last['error']:.1e}, "
                    f"{1e3 * last['seconds']:.3f} ms",
                    file=sys.stderr,
                )
    return curves, left_out


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, default=Path("results/work_precision"))
    parser.add_argument("--quick", action="store_true", help="three tolerances, few repetitions")
    parser.add_argument("--problem", action="append", help="only problems whose name contains this")
    parser.add_argument("--solver", action="append", help="only solvers whose name contains this")
    arguments = parser.parse_args()
    if lissom._lissom.build_profile != "release":
        sys.exit("This is a debug build of lissom; build it in release mode first.")
    curves, left_out = measured_curves(arguments)
    if not curves:
        reasons = "; ".join(f"{name} {why}" for name, why in left_out.items())
        parser.error(f"nothing was measured: {reasons or 'no problem and solver have these names'}")
    machine = [
        f"- {platform.processor() or platform.machine()}, {platform.system()}, "
        f"Python {platform.python_version()}",
        f"- lissom {lissom.__version__}, NumPy {np.__version__}, SciPy {scipy.__version__}, "
        f"numba {numba.__version__}",
        "- `python benches/python/integrators/work_precision.py" + (" --quick`" if arguments.quick else "`"),
    ]
    arguments.output.mkdir(parents=True, exist_ok=True)
    data = {
        "machine": machine,
        "left_out": left_out,
        "curves": [{"problem": c.problem, "solver": c.solver, "points": c.points} for c in curves],
    }
    (arguments.output / "work_precision.json").write_text(json.dumps(data, indent=1))
    text = markdown(curves, left_out, machine)
    (arguments.output / "work_precision.md").write_text(text)
    plot(curves, arguments.output / "work_precision.png")
    print(text)


if __name__ == "__main__":
    main()
