"""Tables and plots of the rubber rod's runs."""

import math

import numpy as np

# Largest error of the tip over the motion, in metres; the rods are 1 m and 0.6 m long.
TOLERANCES = (5e-2, 1e-2, 5e-3, 1e-3, 1e-4)
ONE_PERCENT = 1e-2

# What is compared, the runs that belong to it, and the reference that they are held against. MuJoCo's cable
# neither stretches nor shears, so it is held against the rod that does not either, as is its flex whose edges
# keep their length.
COMPARISONS = {
    "Rubber rod": (
        "rubber rod",
        "rubber rod",
        lambda code: not code.startswith("MuJoCo flex, inextensible"),
    ),
    "Rubber rod that only bends": (
        "rubber rod",
        "rubber rod, bending only",
        lambda code: code.startswith(("lissom, bending", "MuJoCo cable", "MuJoCo flex, inextensible")),
    ),
    "Two segments": (
        "two segments",
        "two segments",
        lambda code: True,
    ),
}
# Comparison, the other code, tolerances, the goal.
GOALS = (
    ("Rubber rod", "PyElastica, clamp as documented", (ONE_PERCENT,), 1000),
    ("Rubber rod", "PyElastica, clamp in mid-element", (ONE_PERCENT,), 1000),
    ("Rubber rod that only bends", "MuJoCo cable, clamp as documented", (ONE_PERCENT,), 500),
    ("Rubber rod that only bends", "MuJoCo cable, clamp in mid-link", (ONE_PERCENT,), 500),
    ("Rubber rod", "MuJoCo flex, clamp in mid-edge", (5e-2, ONE_PERCENT), None),
    ("Rubber rod that only bends", "MuJoCo flex, inextensible, clamp in mid-edge", (5e-2, ONE_PERCENT), None),
    ("Rubber rod", "SoRoMoX", (ONE_PERCENT,), None),
    ("Two segments", "SoRoMoX", (ONE_PERCENT, 1e-3, 1e-4, 1e-5), 2000),
)


def error_of(run: dict, reference: np.ndarray) -> float:
    """Largest distance of the tip from where it should be, infinite for a run that failed."""
    with np.errstate(invalid="ignore"):
        error = np.linalg.norm(np.array(run["tips"]) - reference, axis=1).max()
    return float(error) if np.isfinite(error) else math.inf


def compared(runs: list[dict], references: dict, comparison: str) -> dict[str, list[dict]]:
    """The runs of a comparison with their errors, by code."""
    case, reference, belongs = COMPARISONS[comparison]
    found: dict[str, list[dict]] = {}
    for run in runs:
        if run["case"] == case and belongs(run["code"]):
            found.setdefault(run["code"], []).append({**run, "error": error_of(run, references[reference])})
    return found


def family(run: dict) -> tuple[str, str]:
    """Runs of a family differ only in their steps."""
    return run["discretisation"], run["step"].split("=")[0]


def fastest(runs: list[dict], tolerance: float) -> dict | None:
    """The fastest run within a tolerance.

    A run counts only if the more costly ones of its family are within the tolerance, too: not one in which
    errors of space and time happened to cancel.
    """
    within = [
        run
        for run in runs
        if all(
            other["error"] <= tolerance
            for other in runs
            if family(other) == family(run) and other["seconds"] >= run["seconds"]
        )
    ]
    return min(within, key=lambda run: run["seconds"], default=None)


def seconds(value: float) -> str:
    return f"{1e3 * value:.3g} ms" if value < 1.0 else f"{value:.3g} s"


def goal_rows(runs: list[dict], references: dict) -> list[str]:
    rows = []
    for comparison, code, tolerances, goal in GOALS:
        found = compared(runs, references, comparison)
        own = [run for name, own in found.items() if name.startswith("lissom") for run in own]
        if not own or code not in found:
            continue
        for tolerance in tolerances:
            ours, theirs = fastest(own, tolerance), fastest(found[code], tolerance)
            if ours is None:
                ratio = "lissom does not reach it"
            elif theirs is None:
                longest = max(found[code], key=lambda run: run["seconds"])
                ratio = (
                    f"more than {longest['seconds'] / ours['seconds']:,.0f}: not reached, "
                    f"its longest run has {longest['error']:.1e} m"
                )
            else:
                ratio = f"{theirs['seconds'] / ours['seconds']:,.0f}"
            rows.append(f"| {comparison} | {code} | {tolerance:.0e} m | {ratio} | {goal or '–'} |")
    return rows


def row(run: dict) -> str:
    return f"{seconds(run['seconds'])} | {run['discretisation']} | {run['step']}"


def time_table(found: dict[str, list[dict]]) -> list[str]:
    lines = ["| tip error | code | processor time | discretisation | steps |", "|---|---|---|---|---|"]
    for tolerance in TOLERANCES:
        for code, runs in found.items():
            run = fastest(runs, tolerance)
            if run is not None:
                lines.append(f"| {tolerance:.0e} m | {code} | {row(run)} |")
    for code, runs in found.items():
        run = min(runs, key=lambda run: run["error"])
        lines.append(f"| smallest: {run['error']:.1e} m | {code} | {row(run)} |")
    return lines


def stiffened_rows(runs: list[dict], references: dict) -> list[str]:
    """PyElastica's rod when it hardly stretches, against the rod that only bends."""
    reference = references["rubber rod, bending only"]
    return [
        f"- PyElastica, {run['discretisation']}, {run['step']}, stretch and shear a hundred times as stiff, "
        f"against the rod that only bends: {error_of(run, reference):.1e}"
        for run in runs
        if run["case"] == "stiffened rubber rod"
    ]


def markdown(
    runs: list[dict], references: dict, changes: dict, left_out: dict, machine: list[str], versions: dict
) -> str:
    lines = [*machine]
    lines += [
        f"- {name}: " + ", ".join(f"{package} {number}" for package, number in packages.items())
        for name, packages in versions.items()
    ]
    lines += [f"- Not measured: {name}: {reason}" for name, reason in left_out.items()]
    lines += ["", "How many times faster lissom is, fastest run against fastest run within a tip error:", ""]
    lines += [
        "| | against | tip error | ratio | goal |",
        "|---|---|---|---|---|",
        *goal_rows(runs, references),
    ]
    for comparison in COMPARISONS:
        found = compared(runs, references, comparison)
        if found:
            lines += [
                "",
                f"{comparison}: processor time of the fastest run within a tip error",
                "",
                *time_table(found),
            ]
    compile_times: dict[str, list[float]] = {}
    for run in runs:
        if run["compile_seconds"]:
            compile_times.setdefault(run["code"].split(",")[0], []).append(run["compile_seconds"])
    lines += ["", "Compiling or building the model, not in the run times:", ""]
    lines += [
        f"- {code}: {seconds(min(times))} to {seconds(max(times))}" for code, times in compile_times.items()
    ]
    lines += ["", "Change of the reference's tip, in metres:", ""]
    lines += [f"- {name}: {change:.1e}" for name, change in changes.items()]
    lines += stiffened_rows(runs, references)
    return "\n".join(lines) + "\n"


def plot(runs: list[dict], references: dict, path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(COMPARISONS), figsize=(6 * len(COMPARISONS), 5))
    codes = list(dict.fromkeys(run["code"] for run in runs))
    for axis, comparison in zip(axes, COMPARISONS, strict=True):
        for code, own in compared(runs, references, comparison).items():
            points = [(run["seconds"], run["error"]) for run in own if run["error"] < 1.0]
            if points:
                marker = "o" if code.startswith("lissom") else "x"
                axis.loglog(*zip(*points, strict=True), marker, color=f"C{codes.index(code)}", label=code)
        axis.axhline(ONE_PERCENT, color="grey", linewidth=0.5)
        axis.set(title=comparison, xlabel="processor time [s]", ylabel="largest tip error [m]")
        axis.grid(alpha=0.3)
        axis.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path, dpi=120)
