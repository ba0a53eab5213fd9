"""The tables of docs/peers.md."""

from collections.abc import Mapping, Sequence
from typing import Any

from peers.rubber_rod_report import fastest
from speed.report import table, time

Row = Mapping[str, Any]

# Times as fast as the motion of the octopus, at one percent.
REAL_TIME, END, ONE_PERCENT = 20.0, 6.0, 1e-2
# Largest ratio of run times: derivatives beside Pinocchio's, steps beside MuJoCo's.
DERIVATIVES, STEP = 2.0, 1.0
TOLERANCES = (5e-2, 2e-2, ONE_PERCENT, 5e-3)


def small(value: float | None) -> str:
    return "fails" if value is None else f"{value:.1e}"


def percent(value: float | None) -> str:
    return "fails" if value is None else f"{100.0 * value:.2g} %"


def verdict(ratio: float, goal: float) -> str:
    return f"{ratio:.2g}, {'reached' if ratio <= goal else 'not reached'}"


def agreement(rows: Sequence[Row]) -> str:
    lines = [
        (
            f"{row['group']}: {row['trees']}, up to {row['sizes']['links']:.0f} links, depth "
            f"{row['sizes']['depth']:.0f}, {row['sizes']['coordinates']:.0f} coordinates, condition "
            f"{row['sizes']['condition']:.0e}",
            peer,
            *(small(found[what]) if what in found else "–" for what in WHAT),
            "yes" if row["agrees"] else "**no**",
        )
        for row in rows
        for peer, found in row["largest"].items()
    ]
    return table(("trees", "peer", *WHAT, "rounding"), lines)


#: As agreement.py calls them.
WHAT = (
    "inverse dynamics",
    "mass matrix",
    "dtau/dq",
    "dtau/dv",
    "dtau/da",
    "forward dynamics, force left",
    "forward dynamics, acceleration",
)


def away(rows: Sequence[Row]) -> str:
    what = ("inverse dynamics", "mass matrix", "forward dynamics, acceleration")
    lines = [
        (f"{row['distance']:g} m", peer, *(small(row[peer][each]) for each in what))
        for row in rows
        for peer in ("Pinocchio", "MuJoCo")
    ]
    return table(("distance", "peer", *what), lines)


def functions(rows: Sequence[Row]) -> str:
    names = list(rows[0]["functions"])
    lines = [
        (
            row["joints"],
            *(time(row["functions"][name]) for name in names),
            verdict(
                row["functions"]["lissom, derivatives"] / row["functions"]["Pinocchio, derivatives"],
                DERIVATIVES,
            ),
        )
        for row in rows
    ]
    return table(("joints", *names, f"ratio of derivatives, goal {DERIVATIVES:g}"), lines)


def steps(rows: Sequence[Row]) -> str:
    names = list(rows[0]["steps"])
    lines = [
        (
            row["joints"],
            *(time(row["steps"][name]) for name in names),
            verdict(row["steps"]["lissom"] / row["steps"]["MuJoCo, Euler"], STEP),
            f"{row['iterations']:.1f}, {row['tangents']:.1f}",
            *(small(row["errors"][name]) for name in ("lissom", "MuJoCo", "MuJoCo, fine")),
        )
        for row in rows
    ]
    columns = (
        "joints",
        *names,
        f"ratio to Euler, goal {STEP:g}",
        "lissom's iterations and tangents a step",
        "error, lissom",
        "error, MuJoCo",
        "error, MuJoCo with steps of 1/64",
    )
    return table(columns, lines)


def references(rows: Sequence[Row]) -> str:
    return "\n".join(
        f"- {'In water' if row['water'] else 'Without water'}: {row['modes']} modes of bending in the plane "
        f"of an arm, steps of {row['step']:g} s; twice the step changes it by "
        f"{percent(row['twice the step'])}, four more modes by {percent(row['more modes'])}."
        for row in rows
    )


def codes(runs: Sequence[Row]) -> dict[str, list[dict]]:
    """Runs by code; what failed is far off."""
    found: dict[str, list[dict]] = {}
    for run in runs:
        error = float("inf") if run["error"] is None else run["error"]
        found.setdefault(run["code"], []).append({**run, "error": error})
    return found


def octopus_times(runs: Sequence[Row]) -> str:
    """The fastest run within an error for every code, and its most exact one."""
    lines = []
    for code, own in codes(runs).items():
        # One run that has its own idea of an error stands for itself.
        tolerances = TOLERANCES if len(own) > 1 else ()
        chosen = [(percent(tolerance), fastest(own, tolerance)) for tolerance in tolerances]
        chosen.append(("smallest", min(own, key=lambda run: run["error"])))
        for wanted, run in chosen:
            if run is None:
                lines.append((code, wanted, "not reached", "", "", "", ""))
                continue
            speed = f"{END / run['seconds']:.3g}"
            lines.append(
                (
                    code,
                    wanted,
                    percent(run["error"]),
                    time(run["seconds"]),
                    speed,
                    run["discretisation"],
                    run["step"],
                )
            )
    columns = ("code", "wanted error", "error", "run time", "times real time", "", "steps")
    return table(columns, lines)


def verdict_of_octopus(runs: Sequence[Row]) -> str:
    """What the octopus says about the goal, and about MuJoCo where it runs as well."""
    found = codes(runs)
    ours = fastest(found["lissom"], ONE_PERCENT)
    if ours is None:
        return "No run of lissom is within one percent."
    speed = END / ours["seconds"]
    text = (
        f"At {percent(ONE_PERCENT)} lissom is {speed:.3g} times faster than real time; the goal of "
        f"{REAL_TIME:g} is {'reached' if speed >= REAL_TIME else 'not reached'}."
    )
    if "MuJoCo" in found:
        theirs = fastest(found["MuJoCo"], ONE_PERCENT)
        text += (
            " MuJoCo does not come within it."
            if theirs is None
            else f" MuJoCo takes {theirs['seconds'] / ours['seconds']:.3g} times as long as lissom."
        )
    return text


def convergence(runs: Sequence[Row]) -> str:
    """MuJoCo's smallest errors, by the number of links."""
    best: dict[str, float] = {}
    for run in codes(runs)["MuJoCo"]:
        best[run["discretisation"]] = min(best.get(run["discretisation"], float("inf")), run["error"])
    cells = [(name, "fails" if error == float("inf") else percent(error)) for name, error in best.items()]
    return table(("MuJoCo", "smallest error of all steps"), cells)


def arm_references(rows: Sequence[Row]) -> str:
    return "\n".join(
        f"- {row['modes']} modes of each strain in each segment, steps of {row['step']:g} s; twice the step "
        f"changes it by {percent(row['twice the step'])}, two more modes by {percent(row['more modes'])}. "
        f"The tip moves by up to {row['reach']:.2g} m."
        for row in rows
    )


def arm_agreement(rows: Sequence[Row]) -> str:
    what = ("tendons", "tip", "accelerations")
    names = ("nodes a segment", "generalised forces of tendons", "place of the tip", "accelerations")
    return table(names, [(row["nodes"], *(small(row[each]) for each in what)) for row in rows])


def against(rows: Sequence[Row], first: str) -> list[tuple]:
    """Lines of control steps, beginning with a cell of their own, with times over lissom's."""
    (ours,) = (row["seconds"] for row in rows if row["code"] == "lissom")
    return [
        (
            first,
            row["code"],
            row["discretisation"],
            time(row["step"]),
            percent(row["error"]),
            time(row["seconds"]),
            f"{1.0 / row['seconds']:.3g}",
            f"{row['seconds'] / ours:.2g}",
        )
        for row in rows
    ]


#: Of what `against` gives.
AGAINST = ("code", "", "steps", "error", "control step", "control steps a second", "time over lissom's")


def control_steps(rows: Sequence[Row]) -> str:
    """The fastest way of each code to be within an error, and how it compares with lissom's."""
    lines = []
    for tolerance in dict.fromkeys(row["tolerance"] for row in rows):
        lines += against([row for row in rows if row["tolerance"] == tolerance], percent(tolerance))
    return table(("wanted error", *AGAINST), lines)


def rows_at_once(rows: Sequence[Row]) -> str:
    return " ".join(
        f"`lissom.Simulations` of {row['rows']} arms takes {time(row['seconds'])} for a control step of one, "
        f"{1.0 / row['seconds']:.3g} a second on one core, with steps of {time(row['step'])}."
        for row in rows
    )


def arm_convergence(rows: Sequence[Row]) -> str:
    """The smallest error of all steps, by discretisation."""
    best: dict[tuple[str, str], list[float]] = {}
    for row in rows:
        errors = best.setdefault((row["code"], row["discretisation"]), [])
        if row["error"] is not None:
            errors.append(row["error"])
    lines = [(*name, percent(min(errors, default=None))) for name, errors in best.items()]
    return table(("code", "", "smallest error of all steps"), lines)


def sections(rows: Sequence[Row], about: str) -> dict[str, str]:
    """The text of every section of what was measured, by its name; `about` says on what."""
    found = {row["part"] for row in rows}

    def part(name: str) -> list[Row]:
        return [row for row in rows if row["part"] == name]

    texts: dict[str, str] = {}
    if {"agreement", "arms", "octopus", "tendon arm"} <= found:
        texts["about"] = about
    if "agreement" in found:
        texts |= {"agreement": agreement(part("agreement")), "away": away(part("away"))}
    if "arms" in found:
        texts |= {"functions": functions(part("arms")), "steps": steps(part("arms"))}
    if "octopus" in found:
        water = [row for row in part("octopus") if row["water"]]
        without = [row for row in part("octopus") if not row["water"]]
        texts |= {
            "references": references(part("octopus reference")),
            "water": f"{verdict_of_octopus(water)}\n\n{octopus_times(water)}",
            "without": f"{verdict_of_octopus(without)}\n\n{octopus_times(without)}\n\n{convergence(without)}",
        }
    if "tendon arm" in found:
        texts |= {
            "arm_about": about,
            "arm_references": arm_references(part("tendon arm reference")),
            "arm_agreement": arm_agreement(part("tendon arm agreement")),
            "arm_steps": control_steps(part("tendon arm")),
            "arm_rows": rows_at_once(part("tendon arms")),
            "arm_convergence": arm_convergence(part("tendon arm candidate")),
        }
    return texts
