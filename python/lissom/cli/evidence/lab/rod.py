"""Part 4 of the lab, the Cosserat rod: figures 7 to 9, tables 2 and 3."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ...._lissom import Rod, Segment, simulate, statics
from ....drawing.report import plots, theme
from ....drawing.report.page import Figure, Lesson, Section, Table
from ....drawing.report.plots import Axis, Curve, Plot
from ....drawing.report.text import quantity
from . import published
from .part import NUMERIC, RUN_COLUMNS, Part, run_cells, steps_too_long_on_purpose, stopped, timed_run
from .setup import COARSE_STEP, LABS, ROD, Setup

#: The lab's steel wire and its two bases.
WIRE: dict[str, Any] = {
    "length": 1.0,
    "radius": LABS.radius,
    "young_modulus": LABS.young_modulus,
    "shear_modulus": 80e9,
    "density": LABS.density,
    "modes": {"bend_y": 3},
    "retardation_time": LABS.retardation_time,
}
BASES = {"horizontal": (1.0, 0.0, 0.0, 0.0), "hanging": (0.7071068, 0.0, 0.7071068, 0.0)}

DURATION = 3.0

#: The step of the report's table 2, seconds.
REPORT_STEP = 1e-2
TOLERANCE = 1e-10

#: Times of the shapes in figure 7, seconds.
SNAPSHOTS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.6, 1.0, 3.0)

#: Error of the tip, relative to the range of its height, above which a run is of no use.
USELESS = 0.1

#: Number of points of a drawn rod.
STATIONS = 60

#: Converged tip positions (x, z) of the horizontal release in metres, by time in seconds, computed
#: independently of lissom.
INDEPENDENT_TIPS = {
    0.1: (0.9970663766, -0.0712500678),
    0.5: (0.9807178651, -0.1838140514),
    1.0: (0.9273593387, -0.3468061965),
    3.0: (0.9338616378, -0.333168186),
}


def lab_rod(base: str, setup: Setup = LABS) -> Rod:
    """The lab's rod with one of its two bases. It bends in a plane: its shear modulus does not count, and
    follows Young's modulus."""
    changed = {
        name: getattr(setup, name) for name in ("radius", "young_modulus", "density", "retardation_time")
    }
    changed["shear_modulus"] = WIRE["shear_modulus"] * (setup.young_modulus / LABS.young_modulus)
    return Rod([Segment(**WIRE | changed)], base_orientation=BASES[base])


@steps_too_long_on_purpose()
def part(setup: Setup) -> Part:
    """The release from horizontal, the hanging rod, and their costs."""
    horizontal, hanging = lab_rod("horizontal", setup), lab_rod("hanging", setup)
    steps = (COARSE_STEP, setup.dt, setup.dt / 10)
    motions = {step: simulate(horizontal, DURATION, dt=step) for step in steps}
    # Those of the curves, and those at which errors are measured.
    times = np.unique(np.concatenate([np.linspace(0.0, DURATION, 601), *(m.t for m in motions.values())]))
    tight: dict[str, Any] = {"rtol": TOLERANCE, "atol": 1e-3 * TOLERANCE}
    reference = simulate(horizontal, DURATION, method="rk45", t_eval=times, **tight)
    still = simulate(hanging, DURATION, dt=setup.dt)
    # The lab's own three modes, however exact they are.
    equilibrium = statics(horizontal, space_error=False).q
    conditions, determinants = mass_matrices(horizontal, reference.q)
    errors = {step: tip_error(horizontal, motion, reference) for step, motion in motions.items()}
    bases, table = runs_by_base(setup), runs_by_step(setup, errors)
    sections = [
        figure_7(horizontal, hanging, reference, still, equilibrium),
        figure_8(horizontal, motions, reference, setup, bases),
        figure_9(reference.t, conditions, determinants),
        table_2(bases, setup),
        table_3(table, reference, float(np.ptp(tip(horizontal, reference.q)[:, 1]))),
    ]
    numbers = {
        "equilibrium": np.asarray(equilibrium).tolist(),
        "hanging_tip_motion": tip_motion(hanging, still),
        "mass_condition": [float(conditions.min()), float(conditions.max())],
        "mass_determinant": [float(determinants.min()), float(determinants.max())],
        "tip_error_by_step": {str(step): error for step, error in errors.items()},
        "table_2": bases,
        "table_3": table,
    }
    return Part(sections, numbers)


def figure_7(horizontal: Rod, hanging: Rod, motion: Any, still: Any, equilibrium: Any) -> Section:
    """Motions with both bases."""
    moved, ended = quantity(tip_motion(hanging, still), digits=2), stopped("The run", still)
    return Section(
        "Figure 7: the rod, let go",
        [
            Figure(
                shapes(horizontal, hanging, motion, still, equilibrium),
                "Left: the wire held out horizontally and let go, at successive times, with the path of its "
                "tip and its equilibrium. Right: the same wire hanging.",
            ),
            Lesson(
                "Base (1, 0, 0, 0) is horizontal, (0.7071068, 0, 0.7071068, 0) hangs along −z. Hanging is an "
                f"equilibrium: over {still.t[-1]:g} s its tip moves by {moved} m.{ended} A method that moves "
                "it by more than rounding, or needs long for it, has an error somewhere."
            ),
        ],
    )


def figure_8(
    rod: Rod, motions: dict[float, Any], reference: Any, setup: Setup, bases: list[dict[str, Any]]
) -> Section:
    """The tip over time."""
    explicit = [run for run in bases if run["method"] == "explicit"]
    finishes = (
        "the explicit method finishes: see table 2"
        if all(run["success"] for run in explicit)
        else "the explicit method can finish, but not with this rod: see table 2"
    )
    caption = f"Reference: explicit, at a tolerance of {TOLERANCE:.0e}.{stopped('It', reference)}"
    return Section(
        "Figure 8: the tip, implicit and explicit",
        [
            Figure(tips(rod, motions, reference), caption),
            *([tip_check(rod, reference)] if setup.is_the_labs(ROD) else []),
            Lesson(
                "The report's explicit method never ended, and the rod's stiffness was blamed. Its forward "
                f"model had left out the elastic and damping forces K q + D q̇. With them {finishes}."
            ),
            Lesson(
                "Three more things that the lab's code did and that cost accuracy or convergence: the "
                "gravity part of the tangent used the strain's variation instead of the frame's rotation; "
                "the first step started from q̈ = 0 instead of M q̈ = forces; the predictor reused q̈. "
                "lissom's tangent is exact, its first step solves for q̈, and every step is iterated until "
                "it has converged, or refused."
            ),
        ],
    )


def figure_9(t: Any, conditions: Any, determinants: Any) -> Section:
    """Whether the mass matrix is singular."""
    weight = "light" if determinants.mean() < 1.0 else "heavy"
    return Section(
        "Figure 9: condition and determinant of the mass matrix",
        [
            Figure(mass_figure(t, conditions, determinants), "Along the release from horizontal."),
            Lesson(
                f"The determinant of M is about {determinants.mean():.0e} (the report: "
                f"{published.MASS_DETERMINANT[0]:.0e} to {published.MASS_DETERMINANT[1]:.0e}), and the "
                "report concludes that M is singular. Its condition number is about "
                f"{conditions.mean():.0f}: of sixteen digits a solve loses about "
                f"{np.log10(conditions.mean()):.1f}. The determinant only says that the wire is {weight}: in "
                "grams it is 10⁹ times larger. Judge by the condition number."
            ),
        ],
    )


def tip(rod: Rod, q: Any) -> Any:
    """Positions of the tip, (x, z) for each state."""
    return rod.pose(q, rod.length)[:, [0, 2], 3]


def tip_error(rod: Rod, motion: Any, reference: Any) -> float | None:
    """Largest distance of the tip from the reference at the motion's own times; None if one has failed."""
    if not motion.success or not reference.success:
        return None
    at = np.searchsorted(reference.t, motion.t - 1e-9)
    common = np.abs(reference.t[np.minimum(at, len(reference.t) - 1)] - motion.t) < 1e-9
    there = tip(rod, motion.q[common]) - tip(rod, reference.q[at[common]])
    return float(np.max(np.linalg.norm(there, axis=1)))


def tip_motion(rod: Rod, motion: Any) -> float:
    """Largest distance of the tip from its start."""
    path = tip(rod, motion.q)
    return float(np.max(np.linalg.norm(path - path[0], axis=1)))


def tip_check(rod: Rod, reference: Any) -> Table:
    """Tip positions beside independently computed ones."""
    rows = []
    for time, (x, z) in INDEPENDENT_TIPS.items():
        at = int(np.argmin(np.abs(reference.t - time)))
        found_x, found_z = tip(rod, reference.q[[at]])[0]
        distance = np.hypot(found_x - x, found_z - z)
        numbers = (f"{number:.8f}" for number in (x, z, found_x, found_z))
        rows.append((f"{time:g}", *numbers, f"{distance:.1e}"))
    columns = ("time (s)", "x, independent", "z, independent", "x, lissom", "z, lissom", "distance (m)")
    caption = "Tip of the released rod in metres, beside a computation that shares no code with lissom."
    return Table(columns, rows, frozenset(columns), caption)


def mass_matrices(rod: Rod, q: Any) -> tuple[Any, Any]:
    """Condition number and determinant of the mass matrix along a motion."""
    matrices = np.array([rod.mass_matrix(state) for state in q])
    return np.linalg.cond(matrices), np.linalg.det(matrices)


def runs_by_base(setup: Setup) -> list[dict[str, Any]]:
    """Timed runs of 3 s with both bases and all methods, beside the report's run times."""
    step = setup.dt
    output = np.arange(0.0, DURATION + 0.5 * step, step)
    variants: dict[str, tuple[str, dict[str, Any]]] = {
        f"implicit, {jacobian} Jacobian": ("implicit", {"dt": step, "jac": jacobian})
        for jacobian in ("analytic", "forward", "central")
    }
    variants["explicit"] = ("explicit", {"method": "rk45", "t_eval": output})
    runs = []
    for base, beside in published.ROD_BY_BASE.items():
        rod = lab_rod(base, setup)
        is_published = setup.is_the_labs(ROD) and step == REPORT_STEP
        for name, (kind, options) in variants.items():
            _, numbers = timed_run(
                beside[kind] if is_published else None, partial(simulate, rod, DURATION, **options)
            )
            runs.append({"base": base, "method": name, **numbers})
    return runs


def table_2(runs: list[dict[str, Any]], setup: Setup) -> Section:
    """Run times by base beside the report's."""
    rows = [
        (
            run["base"],
            run["method"],
            *run_cells(run),
        )
        for run in runs
    ]
    columns = ("base", "method", *RUN_COLUMNS)
    caption = (
        f"{DURATION:g} s simulated at a step of {setup.dt:g} s. The report's implicit run time stands "
        "beside all three Jacobians."
    )
    return Section("Table 2: run time by base", [Table(columns, rows, NUMERIC, caption)])


def runs_by_step(setup: Setup, errors: dict[float, float | None]) -> list[dict[str, Any]]:
    """Timed runs of 3 s from horizontal with both steps, beside the report's run times."""
    rod, runs = lab_rod("horizontal", setup), []
    for step in (COARSE_STEP, setup.dt):
        beside = published.of_step(published.ROD_BY_STEP, step, setup.is_the_labs(ROD))
        motion, numbers = timed_run(beside, partial(simulate, rod, DURATION, dt=step))
        iterations = motion.stats.newton_iterations
        runs.append({"step": step, **numbers, "newton_iterations": iterations, "tip_error": errors[step]})
    return runs


def table_3(runs: list[dict[str, Any]], reference: Any, span: float) -> Section:
    """Run times by step beside the report's; ``span`` is the range of the tip's height."""
    coarse = next(run for run in runs if run["step"] == COARSE_STEP)
    rows = [
        (
            f"{run['step']:g} s",
            *run_cells(run),
            f"{run['newton_iterations']:,}",
            "–" if run["tip_error"] is None else quantity(run["tip_error"], digits=2),
        )
        for run in runs
    ]
    columns = ("step", *RUN_COLUMNS, "Newton iterations", "tip error (m)")
    if not coarse["success"]:
        found = "Newton's method does not converge: the run stops before its end."
    elif coarse["tip_error"] is None:
        found = f"the run ends; its error is not known.{stopped('The reference', reference)}"
    else:
        error = coarse["tip_error"]
        found = f"the tip is off by up to {quantity(error)} m, of a motion that spans {quantity(span)} m"
        found += ": quick, and of no use." if error > USELESS * span else "."
    caption = f"Horizontal base, implicit with the analytic Jacobian, {DURATION:g} s simulated."
    return Section(
        "Table 3: run time by step",
        [
            Table(columns, rows, NUMERIC | {"Newton iterations", "tip error (m)"}, caption),
            Lesson(f"At a step of {COARSE_STEP:g} s {found}"),
        ],
    )


def shapes(horizontal: Rod, hanging: Rod, motion: Any, still: Any, equilibrium: Any) -> plots.Figure:
    """Figure 7."""
    colours = theme.sample(theme.ROD_SCALE, np.linspace(0.0, 1.0, len(SNAPSHOTS)))
    curves = []
    for time, colour in zip(SNAPSHOTS, colours, strict=True):
        if time > motion.t[-1]:
            break
        q = motion.q[int(np.argmin(np.abs(motion.t - time)))]
        curves.append(Curve(f"{time:g} s", *centre_line(horizontal, q), colour, width=3.0))
    path = tip(horizontal, motion.q)
    curves += [
        Curve("path of the tip", path[:, 0], path[:, 1], theme.ORANGE, width=1.0),
        Curve("equilibrium", *centre_line(horizontal, equilibrium), theme.GREY, "dash"),
    ]
    hung = [
        Curve("", *centre_line(hanging, still.q[0]), colours[0], width=4.0),
        Curve("", *centre_line(hanging, still.q[-1]), colours[-1], "dot", width=4.0),
    ]
    row = [
        Plot(Axis("x (m)"), Axis("z (m)"), curves, "horizontal", to_scale=True, width=3.0),
        Plot(Axis("x (m)", range=(-0.3, 0.3)), Axis("z (m)"), hung, "hanging", to_scale=True),
    ]
    return plots.Figure([row], 440)


def centre_line(rod: Rod, q: Any) -> tuple[Any, Any]:
    """Coordinates x and z of a rod's centre line in its plane of motion."""
    line = rod.pose(q, np.linspace(0.0, rod.length, STATIONS))[:, :3, 3]
    return line[:, 0], line[:, 2]


def tips(rod: Rod, motions: dict[float, Any], reference: Any) -> plots.Figure:
    """Figure 8."""
    colours = dict(zip(motions, (theme.RED, theme.BLUE, theme.GREEN), strict=True))
    compared = [("reference", reference, theme.GREY, 2.5, False)]
    for step, motion in motions.items():
        compared.append((f"implicit, step {step:g} s", motion, colours[step], 1.4, step == COARSE_STEP))
    rows = []
    for i, axis in enumerate("xz"):
        curves = [
            Curve(
                name, motion.t, tip(rod, motion.q)[:, i], colour, width=width, mark="disc" if coarse else ""
            )
            for name, motion, colour, width, coarse in compared
        ]
        rows.append([Plot(Axis("time (s)"), Axis(f"{axis} of the tip (m)"), curves)])
    return plots.Figure(rows, 270)


def mass_figure(t: Any, conditions: Any, determinants: Any) -> plots.Figure:
    """Figure 9."""
    curves = [
        Curve("condition number", t, conditions, theme.BLUE, width=2.0),
        Curve("determinant (kg³ m¹²)", t, determinants, theme.RED, width=2.0),
    ]
    return plots.Figure([[Plot(Axis("time (s)"), Axis("value", log=True), curves)]], 400)
