"""Solvers: random equations with poles, jumps, undefined regions and stiffness, compared with SciPy.

A case is a script that defines `problem`. A success is wrong if SciPy's runs with far tighter tolerances,
which must agree with each other, end elsewhere, while SciPy's run with the tolerances of the case ends near
them.
"""

import traceback
import warnings
from pathlib import Path

import numpy as np
from scipy import integrate, optimize

import lissom
from fuzz import judge

NAME = "solvers"
SUFFIX = ".py"

HEAD = "import numpy as np\n\n"
#: Errors are in units of the tolerance of a step, atol + rtol |y|; they accumulate and grow. A success is
#: wrong beyond `ALLOWED` units and `WORSE` times the error of SciPy's run with the same method.
ALLOWED = 300.0
WORSE = 30.0
#: The limit for Newmark's method, which SciPy does not have and whose errors accumulate faster.
NEWMARK_ALLOWED = 1e4
#: Maximum number of evaluations of a case, and of SciPy: runs without a solution may not end.
EVALUATIONS = 200_000
#: Minimum number of steps of a SciPy run, so that it does not step over short events.
LEAST_STEPS = 300
#: A root is wrong if it differs from SciPy's by this fraction of its size.
ROOT_FAR = 1e-2


# Creating cases.


def _number(rng, low=-3.0, high=3.0) -> str:
    return f"{rng.choice([-1, 1]) * 10 ** rng.uniform(low, high):.4g}"


def _matrix(rng, n) -> str:
    matrix = rng.normal(size=(n, n)) * 10 ** rng.uniform(-1, 2)
    if rng.random() < 0.7:  # a stable one
        matrix -= (np.abs(np.linalg.eigvals(matrix)).max() + 0.1) * np.eye(n)
    return f"np.array({np.round(matrix, 4).tolist()})"


def _terms(rng, n) -> str:
    """One term of a right-hand side of n components."""
    a, b = _number(rng), _number(rng, -1, 1)
    c = f"{rng.uniform(0, 1.2):.4g}"
    w = f"{10 ** rng.uniform(0, 2.5):.4g}"
    choices = [
        f"{_matrix(rng, n)} @ y",
        f"{b} * y",
        f"-{10 ** rng.uniform(0, 7):.3g} * (y - np.cos(t))",
        f"{b} / (y - {c})",
        f"{b} / (t - {c}) * np.ones({n})",
        f"1 / ((t - {c}) ** 2 + 1e-4) * np.ones({n})",
        f"{a} * np.sign(np.sin({w} * t)) * np.ones({n})",
        f"np.where(y > {c}, {b}, {a})",
        f"np.where(t > {c}, {b}, 0.0) * np.ones({n})",
        f"np.floor({b} * t) * y",
        f"np.sqrt({c} - y)",
        f"np.log(y + {c})",
        f"np.where(t > {c}, np.nan, {b}) * np.ones({n})",
        f"np.where(y > {c}, np.inf, {b})",
        "np.arcsin(y)",
        f"{b} * y ** 2",
        f"{b} * y ** 3",
        f"np.exp({b} * y)",
        f"{b} * np.sin({w} * t) * np.ones({n})",
        f"{a} * np.exp(-(({c} - t) * 1e3) ** 2) * np.ones({n})",
        "np.sqrt(np.abs(y))",
        f"{b} * np.abs(y) ** (1 / 3)",
        f"1e308 * np.ones({n})",
        "1e200 * y",
        "1e-200 * y",
        "0.0 * y",
        f"{b} * np.roll(y, 1) * t",
    ]
    if n >= 2:
        choices += [
            f"{w} * np.concatenate([[y[1], -y[0]], np.zeros({n - 2})])",
            f"np.concatenate([[y[1], {w} * (1 - y[0] ** 2) * y[1] - y[0]], np.zeros({n - 2})])",
        ] * 2
    return str(rng.choice(choices))


def _sum(rng, make, n) -> str:
    return " + ".join(make(rng, n) for _ in range(int(rng.choice([1, 1, 2, 2, 3]))))


def _text(**entries) -> str:
    return (
        HEAD + "problem = {\n" + "".join(f"    {key!r}: {text},\n" for key, text in entries.items()) + "}\n"
    )


def _ivp(rng) -> str:
    n = int(rng.choice([1, 2, 3]))
    end = float(rng.choice([1.0, 1.0, 2.0, 10.0, -1.0, 1e-6, 1e4]))
    rtol = 10.0 ** int(rng.integers(-9, -1))
    y0 = np.round(rng.normal(size=n) * rng.choice([0, 1, 1, 1, 1e-8, 1e8]), 6).tolist()
    options = {}
    if rng.random() < 0.3:
        options["t_eval"] = f"np.linspace(0.0, {end}, 7)"
    if rng.random() < 0.3:
        options["dense_output"] = "True"
    if rng.random() < 0.2:
        options["max_step"] = f"{abs(end) / 10:g}"
    if rng.random() < 0.1:
        options["first_step"] = f"{abs(end) * 10 ** rng.uniform(-12, 0):.3g}"
    return _text(
        kind="'ivp'",
        fun=f"lambda t, y: {_sum(rng, _terms, n)}",
        t_span=f"(0.0, {end})",
        y0=repr(y0),
        method=repr(str(rng.choice(["rk45", "dop853", "radau"]))),
        rtol=f"{rtol:g}",
        atol=f"{rtol * 10.0 ** int(rng.integers(-4, 1)):g}",
        options="{" + ", ".join(f"{key!r}: {text}" for key, text in options.items()) + "}",
    )


def _equations(rng, n) -> str:
    a, b, c = _number(rng), _number(rng, -1, 1), f"{rng.normal():.4g}"
    return str(
        rng.choice(
            [
                f"{a} * (x - {c})",
                f"(x - {c}) ** 3",
                f"x ** 2 - {b}",
                f"x ** 2 + {abs(float(b))}",
                f"{a} / (x - {c})",
                f"(x - {b}) / (x - {c})",
                f"np.sign(x - {c})",
                f"np.where(x > {c}, 1 + x ** 2, -1 - x ** 2)",
                f"np.sqrt(x - {c}) - {b}",
                f"np.log(x - {c})",
                f"np.exp(x) - {b}",
                "np.exp(-x)",
                f"np.arctan({a} * (x - {c}))",
                f"np.tan(x - {c})",
                f"np.abs(x - {c})",
                f"(x - {c}) ** 9",
                f"np.where(np.abs(x) > {abs(float(a))}, np.nan, x - {c})",
                f"1e200 * (x - {c})",
                f"1e-200 * (x - {c})",
                f"1e160 * x ** 2 - {a}",
                f"np.sin({a} * x) + {b} * x",
                f"{_matrix(rng, n)} @ x - {b}",
                f"np.roll(x, 1) * x - {b}",
                f"np.full({n}, x.sum() - {b})",
                f"np.full({n}, np.nan)",
                "0.0 * x",
            ]
        )
    )


def _root(rng) -> str:
    n = int(rng.choice([1, 2, 3]))
    options = {}
    if rng.random() < 0.3:
        options |= {"xtol": "1e-8", "tol": "0.0"}
    if rng.random() < 0.3:
        options["jac"] = "'central'"
    if rng.random() < 0.2:
        options["accelerate"] = "True"
    if rng.random() < 0.2:
        options["keep_jacobian"] = "True"
    return _text(
        kind="'root'",
        fun=f"lambda x: {_sum(rng, _equations, n)}",
        x0=repr(np.round(rng.normal(size=n) * rng.choice([0, 1, 1, 3, 1e5]), 5).tolist()),
        method=repr(str(rng.choice(["newton", "line_search", "trust_region"]))),
        options="{" + ", ".join(f"{key!r}: {text}" for key, text in options.items()) + "}",
    )


def _newmark(rng) -> str:
    n = int(rng.choice([1, 2]))
    stiffness = 10 ** rng.uniform(0, 5)
    damping = rng.choice([0.0, 0.01, 0.1, 2.0]) * np.sqrt(stiffness)
    force = _terms(rng, n).replace("y", "q")
    periods = float(rng.choice([0.5, 2.0, 10.0]))
    rtol = 10.0 ** int(rng.integers(-7, -2))
    return _text(
        kind="'newmark'",
        force=f"lambda t, q, v: -{stiffness:.4g} * q - {damping:.4g} * v + {force}",
        t_end=f"{periods * 2 * np.pi / np.sqrt(stiffness):.4g}",
        q0=repr(np.round(rng.normal(size=n), 4).tolist()),
        v0=repr(np.round(rng.normal(size=n), 4).tolist()),
        rtol=f"{rtol:g}",
        atol=f"{rtol * 1e-2:g}",
        adaptive=repr(bool(rng.random() < 0.8)),
    )


def make(rng: np.random.Generator) -> bytes:
    return str([_ivp, _ivp, _root, _newmark][int(rng.integers(4))](rng)).encode()


# Running and judging.


class Enough(Exception):
    """The run needs too many evaluations."""

    def __init__(self) -> None:
        super().__init__("too many evaluations")


def counted(fun, limit=EVALUATIONS):
    calls = 0

    def count(*arguments):
        nonlocal calls
        calls += 1
        if calls > limit:
            raise Enough
        return fun(*arguments)

    return count


def prepare() -> None:
    np.seterr(all="ignore")
    warnings.simplefilter("ignore")


def where(path: Path) -> str:
    space: dict = {}
    exec(compile(path.read_bytes(), str(path), "exec"), space)
    problem = space["problem"]
    return f"{problem['kind']} {problem.get('method', '')}".strip()


def run(path: Path, clock) -> judge.Outcome:
    place = "?"
    try:
        space: dict = {}
        exec(compile(path.read_bytes(), str(path), "exec"), space)
        problem = space["problem"]
        place = f"{problem['kind']} {problem.get('method', '')}".strip()
        return {"ivp": _run_ivp, "root": _run_root, "newmark": _run_newmark}[problem["kind"]](problem, place)
    except Enough:
        return judge.Outcome("slow", "too many evaluations")
    except (KeyError, NameError, SyntaxError) as error:
        return judge.Outcome("undecided", f"the script itself: {error!r}")
    except KeyboardInterrupt:
        if clock.over:
            return judge.Outcome("slow", "ended by Ctrl-C")
        raise
    except BaseException as error:
        if any(frame.name == "<lambda>" for frame in traceback.extract_tb(error.__traceback__)):
            return judge.Outcome("undecided", f"the equations' own {error!r}")
        return judge.of_exception(error, place, (MemoryError,))


#: SciPy's names of the methods.
SCIPY_METHODS = {"rk45": "RK45", "dop853": "DOP853", "radau": "Radau"}


def scipy_end(fun, t_span, y0, **options) -> np.ndarray | None:
    """SciPy's final state; None if it is not reached in reasonable time."""
    try:
        method = SCIPY_METHODS[options.pop("method")]
        found = integrate.solve_ivp(counted(fun), t_span, y0, method=method, **options)
    except (Enough, ValueError, np.linalg.LinAlgError, OverflowError):
        return None
    return found.y[:, -1] if found.success and np.isfinite(found.y).all() else None


def reference(fun, t_span, y0) -> np.ndarray | None:
    """The final states of runs of two methods with tight tolerances; None if one of them fails."""
    tight = {"rtol": 1e-11, "atol": 1e-14, "max_step": abs(t_span[1] - t_span[0]) / LEAST_STEPS}
    ends = [scipy_end(fun, t_span, y0, method=method, **tight) for method in ("dop853", "radau")]
    return None if any(end is None for end in ends) else np.array(ends)


def units(end, right, rtol, atol) -> float:
    """An error in units of the tolerance."""
    return float(np.max(np.abs(end - right) / (atol + rtol * np.abs(right) + 1e-300)))


def _run_ivp(problem, place) -> judge.Outcome:
    fun, t_span, y0 = problem["fun"], problem["t_span"], np.array(problem["y0"])
    rtol, atol, options = problem["rtol"], problem["atol"], problem.get("options", {})
    same = {"method": problem["method"], "rtol": rtol, "atol": atol}
    found = lissom.solve_ivp(counted(fun), t_span, y0, **same, **options)
    if not found.success:
        return judge.Outcome("failed", f"{found.reason}: {found.message}")
    if not np.isfinite(found.y).all():
        return judge.found("nan", place, "a state of a success is not finite")
    if found.t[-1] != t_span[1]:
        return judge.found("wrong", place, "success, but the end is elsewhere")
    if found.sol is not None:
        between = found.sol(found.t)
        if not np.isfinite(between).all():
            return judge.found("nan", place, "the dense output of a success is not finite")
        scale = np.abs(found.y).max() + atol
        if not np.abs(between - found.y).max() <= 1e-3 * scale:
            return judge.found("wrong", place, "the dense output does not meet the states")
    ends = reference(fun, t_span, y0)
    if ends is None:
        return judge.Outcome("undecided", "SciPy finds no end")
    if units(ends[0], ends[1], rtol, atol) > 1.0:
        return judge.Outcome("undecided", "SciPy's tight runs disagree")
    error = units(found.y[:, -1], ends[0], rtol, atol)
    if error <= ALLOWED:
        return judge.Outcome("done", f"{error:.2g} units")
    scipy = scipy_end(fun, t_span, y0, **same, **options)
    theirs = np.inf if scipy is None else units(scipy, ends[0], rtol, atol)
    if error <= WORSE * theirs:
        return judge.Outcome("done", f"{error:.2g} units, SciPy {theirs:.2g}")
    return judge.found("wrong", place, f"off by {error:.2g} units of the tolerance, SciPy by {theirs:.2g}")


def _run_root(problem, place) -> judge.Outcome:
    fun = problem["fun"]
    found = lissom.root(counted(fun), np.array(problem["x0"]), method=problem["method"], **problem["options"])
    if not found.success:
        return judge.Outcome("failed", f"{found.status}: {found.message}")
    x = np.asarray(found.x)
    value = np.asarray(fun(x))
    if not (np.isfinite(x).all() and np.isfinite(value).all()):
        return judge.found("nan", place, "the root or its residual is not finite")
    if not np.array_equal(value, found.fun):
        return judge.found("wrong", place, "`fun` is not the function at `x`")
    tol = problem["options"].get("tol", "1e-6")
    if found.status in ("converged_residual", "already_root") and np.linalg.norm(value) <= float(tol):
        return judge.Outcome("done", found.status)
    try:
        tight = optimize.root(counted(fun), x, method="hybr", options={"xtol": 1e-13})
    except (Enough, ValueError, TypeError):
        return judge.Outcome("undecided", "SciPy finds no root")
    off = float(np.max(np.abs(tight.x - x) / (1 + np.abs(x))))
    better = np.linalg.norm(tight.fun) <= 1e-3 * np.linalg.norm(value)
    if better and off > ROOT_FAR:
        return judge.found("wrong", place, f"{found.status}: SciPy finds a root {off:.2g} away")
    jumps = _jumps(fun, x)
    if jumps:
        return judge.found("wrong", place, f"{found.status}: {jumps}")
    return judge.Outcome("done", found.status)


def _jumps(fun, x) -> str | None:
    """Whether a reported root is a jump or a pole: a residual as large as that of its neighbours."""
    size = np.linalg.norm(fun(x))
    for step in (1e-7, 1e-4):
        for sign in (-1, 1):
            near = np.linalg.norm(fun(x + sign * step * (1 + np.abs(x))))
            if np.isfinite(near) and size > 1e-3 and near < 0.5 * size and step == 1e-7:
                return f"the residual {size:.2g} is halved a hair away"
    return None


def _run_newmark(problem, place) -> judge.Outcome:
    force, end = problem["force"], problem["t_end"]
    q0, v0 = np.array(problem["q0"]), np.array(problem["v0"])
    rtol, atol, adaptive = problem["rtol"], problem["atol"], problem["adaptive"]
    found = lissom.newmark(
        counted(lambda t, q, v, a: a - force(t, q, v)),
        (0.0, end),
        q0,
        v0,
        dt=end / 100,
        rtol=rtol,
        atol=atol,
        adaptive=adaptive,
        max_steps=20_000 if adaptive else None,
    )
    if not found.success:
        return judge.Outcome("failed", f"{found.status}: {found.message}")
    if not all(np.isfinite(part).all() for part in (found.q, found.v, found.a)):
        return judge.found("nan", place, "a state of a success is not finite")
    if not adaptive:
        return judge.Outcome("done", "fixed steps promise no accuracy")
    n = len(q0)
    ends = reference(
        lambda t, y: np.concatenate([y[n:], force(t, y[:n], y[n:])]), (0, end), np.append(q0, v0)
    )
    if ends is None:
        return judge.Outcome("undecided", "SciPy finds no end")
    if units(ends[0], ends[1], rtol, atol) > 1.0:
        return judge.Outcome("undecided", "SciPy's tight runs disagree")
    # Components that pass through zero at the end were held to the tolerance where they were large.
    atol = atol + rtol * np.repeat([np.abs(found.q).max(), np.abs(found.v).max()], n)
    error = units(np.append(found.q[-1], found.v[-1]), ends[0], rtol, atol)
    if error > NEWMARK_ALLOWED:
        return judge.found("wrong", place, f"off by {error:.2g} units of the tolerance")
    return judge.Outcome("done", f"{error:.2g} units")
