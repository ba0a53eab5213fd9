"""Errors of the pile's runs, and what each code takes for an error."""

import numpy as np
from pile_scene import GRAVITY, LENGTH, TIMES, Pile

# Of the length of a rod.
TOLERANCES = (1e-2, 5e-3, 3e-3, 1e-3)
# A rod has touched if it is farther from where it would have fallen to, in its lengths. Falls in steps of
# backward Euler, which lissom makes while others hit the floor, are off by half of that.
TOUCHED = 1e-3


def touched(points: np.ndarray, pile: Pile) -> np.ndarray:
    """Which rods have touched something by each time, shape (times, rods)."""
    along = LENGTH * np.array([0.0, 0.5, 1.0])
    starts = pile.starts[:, None] + along[:, None] * pile.directions[:, None]
    falls = np.array([[0.0, 0.0, -0.5 * GRAVITY * time**2] for time in TIMES])
    away = np.linalg.norm(points - starts - falls[:, None, None], axis=-1).max(axis=-1)
    return away > TOUCHED * LENGTH


def errors(points: np.ndarray, reference: np.ndarray, pile: Pile) -> np.ndarray:
    """Root mean square distance of the rods that have touched, at each time, in lengths of a rod."""
    squares = ((points - reference) ** 2).sum(axis=-1).mean(axis=-1)
    each = [
        row[those].mean() if those.any() else 0.0
        for row, those in zip(squares, touched(reference, pile), strict=True)
    ]
    return np.sqrt(each) / LENGTH


def with_errors(runs: list[dict], piles: dict[int, Pile]) -> list[dict]:
    """The runs with their errors at each time against the last, finest run of the same code and pile."""
    references = {(run["code"], run["rods"]): run for run in runs}
    found = []
    for run in runs:
        reference = references[run["code"], run["rods"]]
        if run["points"] is None:
            error = np.full(len(TIMES), np.inf)
        else:
            error = errors(np.array(run["points"]), np.array(reference["points"]), piles[run["rods"]])
        found.append({**run, "errors": error.tolist(), "reference": run is reference})
    return found


def certain(run: dict, runs: list[dict]) -> float:
    """The largest error of a run and of those with smaller steps: errors may cancel by chance."""
    return max(
        max(other["errors"])
        for other in runs
        if other["size"] == run["size"] and other["step"] <= run["step"]
    )


def frontier(runs: list[dict]) -> list[tuple[float, float]]:
    """Run times and errors of the runs that no cheaper one is better than, the cheapest first."""
    best: list[tuple[float, float]] = []
    measured = [run for run in runs if not run["reference"]]
    for seconds, error in sorted((run["seconds"], certain(run, measured)) for run in measured):
        if np.isfinite(error) and (not best or error < best[-1][1]):
            best.append((seconds, error))
    return best


def time_at(best: list[tuple[float, float]], tolerance: float) -> str:
    """Interpolated between the runs around the error, both in logarithms."""
    for index, (seconds, error) in enumerate(best):
        if error <= tolerance:
            if index == 0:
                return f"≤ {seconds:.2g} s"
            before, larger = best[index - 1]
            share = np.log(larger / tolerance) / np.log(larger / error)
            return f"{before * (seconds / before) ** share:.2g} s"
    return f"– ({best[-1][1]:.1e} in {best[-1][0]:.2g} s)" if best else "–"


def groups(runs: list[dict]) -> dict[int, dict[str, list[dict]]]:
    """Runs by pile and code, in the order of the codes."""
    found: dict[int, dict[str, list[dict]]] = {}
    for run in runs:
        found.setdefault(run["rods"], {}).setdefault(run["code"], []).append(run)
    return found


def times(runs: list[dict]) -> list[str]:
    lines = ["| rods | code | " + " | ".join(f"{tolerance:g}" for tolerance in TOLERANCES) + " |"]
    lines += ["|---" * (2 + len(TOLERANCES)) + "|"]
    for rods, codes in sorted(groups(runs).items()):
        for code, own in codes.items():
            best = frontier(own)
            cells = " | ".join(time_at(best, tolerance) for tolerance in TOLERANCES)
            lines.append(f"| {rods} | {code} | {cells} |")
    return lines


def settled(states: list[dict]) -> list[str]:
    lines = [
        "| rods | code | centre of mass, mm | largest overlap, mm | kinetic energy, mJ |",
        "|---|---|---|---|---|",
    ]
    for state in sorted(states, key=lambda state: state["rods"]):
        values = state["settled"]
        lines.append(
            f"| {state['rods']} | {state['code']} | {1e3 * values['height']:.1f} "
            f"| {1e3 * values['overlap']:.2f} | {1e3 * values['kinetic']:.1f} |"
        )
    return lines


def agreement(runs: list[dict], piles: dict[int, Pile]) -> list[str]:
    """The distance of the finest runs of two codes."""
    lines = []
    for rods, codes in sorted(groups(runs).items()):
        finest = {code: np.array(own[-1]["points"]) for code, own in codes.items() if own[-1]["points"]}
        if "lissom" in finest:
            ours = finest.pop("lissom")
            for code, theirs in finest.items():
                distance = " ".join(f"{value:.1e}" for value in errors(theirs, ours, piles[rods]))
                lines.append(f"- {rods} rods, {code} and lissom: {distance}")
    return lines


def all_runs(runs: list[dict]) -> list[str]:
    heads = " | ".join(f"{time:g} s" for time in TIMES)
    lines = [
        f"| rods | code | discretisation | step, ms | s for 0.1 s | {heads} |",
        "|---" * (5 + len(TIMES)) + "|",
    ]
    for run in runs:
        errors_of = (
            ["reference"] * len(TIMES) if run["reference"] else [f"{each:.1e}" for each in run["errors"]]
        )
        lines.append(
            f"| {run['rods']} | {run['code']} | {run['discretisation']} | {1e3 * run['step']:g} "
            f"| {run['seconds']:.3g} | {' | '.join(errors_of)} |"
        )
    return lines


def markdown(runs: list[dict], states: list[dict], piles: dict[int, Pile], machine: list[str]) -> str:
    measured = with_errors(runs, piles)
    return "\n".join(
        [
            *machine,
            "",
            "Processor time for 0.1 s of motion, by the largest of the errors at these times:",
            "",
            *times(measured),
            "",
            *(["After 0.3 s:", "", *settled(states), ""] if states else []),
            "Distance of the finest runs after " + ", ".join(f"{time:g}" for time in TIMES) + " s:",
            "",
            *agreement(measured, piles),
            "",
            "All runs, with their errors:",
            "",
            *all_runs(measured),
            "",
        ]
    )
