"""Reports of equilibria and of natural modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..._lissom import ContinuationResult, EquilibriumPath, ModesResult, Scene, StaticsResult
from ...analysis.advice import about_model
from ...common import disk
from ...model.views import Member
from ...results.runs import Array
from ...results.studies import ModesStudy, Setting, Slides, StaticsStudy, setting_for, way
from ..oscillation import frequency, is_overdamped, is_rounding, mode_motion
from . import motion, page, peaks, plots, theme
from .text import BEYOND_LIMITS, quantity

#: Number of animated modes; the table contains all of them.
ANIMATED = 4

#: Frames of one vibration.
FRAMES = 49

#: Values below this fraction of their terms are rounding errors of zero.
ROUNDING = 1e-12

#: Errors by the number of modes, relative to the length, about which `statics` warns.
DOUBTFUL = 1e-2

#: Number of modes in the table of the command line.
LISTED = 10


def write(study: StaticsStudy | ModesStudy, path: Path) -> None:
    """Write the report of a study to ``path``."""
    built = statics(study) if isinstance(study, StaticsStudy) else modes(study)
    disk.write(path, page.render(built))


def statics(study: StaticsStudy) -> page.Page:
    """The report of the equilibrium of a scene."""
    scene, start = study.scene, "released from q0." if study.from_start else "from the unloaded state."
    built = equilibrium(
        setting_for(study.found, scene.model), study.found, scene.name, scene.q0, study.wall_time
    )
    return replace(
        built,
        lead=f"Equilibrium at rest, {start}",
        sections=[*built.sections, _source(scene)],
    )


def equilibrium(
    setting: Setting,
    found: StaticsResult,
    title: str,
    start: Array | None = None,
    wall_time: float | None = None,
) -> page.Page:
    """The report of an equilibrium. Without a path it also shows the initial shape, if given."""
    path, shown = found.path, setting.view
    if path is not None:
        sections = _along(setting, path)
    elif start is None:
        alone = Slides(setting, np.zeros(1), found.q[None])
        sections = motion.sections("Shape", alone, "The equilibrium shape.")
    else:
        both = Slides(
            setting,
            np.array([0.0, 1.0]),
            np.stack([start, found.q]),
            ("way from start to equilibrium: ", ""),
            opens_at=1,
            outline=("initial shape", start),
        )
        sections = motion.sections("Shape", both, "0 is the start, 1 the equilibrium.")
    if found.success and shown.members:
        sections.append(page.Section("Links", [_wrenches(setting, found.q, shown.members)]))
    if found.success:
        sections += peaks.of_equilibrium(setting, found.q)
    rows = summary(setting, found, wall_time)
    sections.append(page.Section("Result", [found.message, page.Table(("", ""), rows)]))
    lead = f"{shown.title}, {setting.model.n} generalised coordinates, at rest."
    return page.Page(
        title=title,
        lead=lead,
        outcome=outcome(found, peaks.exceeded_at_rest(setting, found.q)),
        advice=about_model(setting.model),
        sections=sections,
    )


def continuation(setting: Setting, found: ContinuationResult, title: str) -> page.Page:
    """The report of a path of equilibria."""
    path = found.path
    factor = path.load_factor
    rows = [
        ("equilibria", f"{len(path.q):,}"),
        ("load factor", f"from {factor[0]:.6g} to {factor[-1]:.6g}"),
    ]
    if (np.diff(factor) < 0.0).any():
        # The path turns at limit points, which may lie between two of its points.
        reached = [*factor, *(point.load_factor for point in path.critical_points)]
        rows.append(("load factor, least and largest", f"{min(reached):.6g}, {max(reached):.6g}"))
    if path.u is not None:
        names = setting.model.inputs
        for name, column in zip(names, path.u.T, strict=True):
            rows.append((f"input {name}", f"from {column[0]:.6g} to {column[-1]:.6g}"))
    rows += [
        ("stability at the end", path.stability[-1] or "unknown"),
        *_criticals(path),
        ("Newton iterations", f"{found.nit:,}"),
    ]
    return page.Page(
        title=title,
        advice=about_model(setting.model),
        lead=f"{setting.view.title}, {setting.model.n} generalised coordinates: a path of equilibria.",
        outcome=("Finished." if found.success else f"Ended early: {found.status}", found.success),
        sections=[
            *_along(setting, path),
            page.Section("Result", [found.message, page.Table(("", ""), rows)]),
        ],
    )


def _along(setting: Setting, path: EquilibriumPath) -> list[page.Section]:
    """A path of equilibria: the shapes, starting with the last one, and their stiffness."""
    factor = path.load_factor
    is_rising = bool((np.diff(factor) > 0.0).all())
    slides = Slides(
        setting,
        factor if is_rising else way(path),
        path.q,
        ("load factor ", ""),
        opens_at=len(path.q) - 1,
        # On a path of inputs all loads act fully.
        factors=factor if path.u is None else None,
        inputs=path.u,
        labels=None if is_rising else factor,
        outline=("initial shape", path.q[0]),
    )
    what = "while the loads grow" if path.u is None else "while the inputs change"
    if not is_rising:
        what = "along the path"
    caption = f"Equilibria {what}, the last one first; between them shapes are interpolated."
    return [
        *motion.sections("Shape", slides, caption),
        page.Section("Stiffness", _stiffness(path, plots.MOTION if is_rising else "")),
    ]


def _source(scene: Scene) -> page.Section:
    return page.Section("Scene", [page.Source("The scene file", scene.text)])


def outcome(found: StaticsResult, beyond: Sequence[str] = ()) -> tuple[str, bool]:
    """The outcome, and whether it is good: accurate, stable, and with no sentence about a limit."""
    if found.status == "interrupted":
        return (
            f"Interrupted at load factor {found.load_factor:.6g}; what was found until then is shown.",
            False,
        )
    if not found.success:
        return f"Failed: {found.status}", False
    verdict, error = f"In equilibrium, {found.stability or 'stability unknown'}", found.space_error
    if error is not None and error.relative > DOUBTFUL:
        return f"{verdict}, but the modes leave an error of {error.relative:.0%} of the length", False
    return BEYOND_LIMITS.format(what=verdict) if beyond else verdict, bool(found.is_stable) and not beyond


def summary(setting: Setting, found: StaticsResult, wall_time: float | None) -> list[tuple[str, str]]:
    """The equilibrium in words and numbers."""
    rows: list[tuple[str, str]] = [("stability", found.stability or "unknown")]
    inputs = zip(setting.model.inputs, setting.u, strict=True)
    rows += [(f"input {name}", f"{value:.6g}") for name, value in inputs]
    for frame in setting.view.frames:
        x, y, z = _rounded(frame.pose(found.q, setting.t)[:3, 3], ROUNDING * setting.view.size)
        rows.append((frame.name, f"({x:.6g}, {y:.6g}, {z:.6g}) m"))
    lowest = found.lowest_eigenvalue
    rows += [
        ("lowest stiffness", f"{lowest:.4g} of the elastic one" if np.isfinite(lowest) else "unknown"),
        *_space_error(found),
        ("Newton iterations", str(found.nit)),
    ]
    if wall_time is not None:
        rows.append(("time", quantity(wall_time, "s")))
    return rows + ([] if found.path is None else _criticals(found.path))


def _space_error(found: StaticsResult) -> list[tuple[str, str]]:
    """The error due to the finite number of modes, if it is known."""
    error = found.space_error
    if error is None:
        return []
    return [("error by the number of modes", f"about {error.relative:.0e} of the length")]


def _rounded(values: Array, least: float) -> list[float]:
    """The values with small ones replaced by zero."""
    return [0.0 if abs(value) < least else float(value) for value in values]


def _criticals(path: EquilibriumPath) -> list[tuple[str, str]]:
    return [(point.kind, f"at load factor {point.load_factor:.6g}") for point in path.critical_points]


def _wrenches(setting: Setting, at: Array, members: Sequence[Member]) -> page.Table:
    """Wrench transmitted through each link's joint at rest."""
    q, t = at[None], np.array([setting.t])
    rest, u = np.zeros_like(q), setting.u[None]

    wrenches = [member.wrench(q, rest, rest, t, u)[0] for member in members]
    largest = max(float(np.abs(wrench[3:]).max()) for wrench in wrenches)

    def components(values: Array, arm: float) -> str:
        least = max(1e-9 * float(np.abs(values).max()), ROUNDING * largest * arm)
        return "(" + ", ".join(f"{value:.4g}" for value in _rounded(values, least)) + ")"

    size = setting.view.size
    rows = [
        (member.name, member.carrier, components(wrench[3:], 1.0), components(wrench[:3], size))
        for member, wrench in zip(members, wrenches, strict=True)
    ]
    columns = ("link", "carried by", "force (N)", "moment (N m)")
    caption = "What each link gets through its joint, in the axes of the world; the moment about the joint."
    return page.Table(columns, rows, caption=caption)


def _stiffness(path: EquilibriumPath, clock: str) -> list[page.Part]:
    critical = path.critical_points
    curves = [
        plots.Curve("lowest eigenvalue", path.load_factor, path.lowest_eigenvalue, theme.BLUE, mark="disc"),
        plots.Curve(
            "critical points",
            np.array([point.load_factor for point in critical]),
            np.zeros(len(critical)),
            theme.RED,
            joined=False,
            mark="diamond",
        ),
    ]
    shown = curves if critical else curves[:1]
    plot = plots.Plot(plots.Axis("load factor"), plots.Axis("stiffness / elastic stiffness"), shown)
    figure = plots.Figure([[plot]], 320, clock)
    return [page.Figure(figure, "Smallest eigenvalue of the tangent stiffness; unstable below zero.")]


def modes(study: ModesStudy) -> page.Page:
    """The report of the natural modes of a scene."""
    scene, about = study.scene, "initial shape" if study.statics is None else "equilibrium at rest"
    built = vibrations(setting_for(study.found, scene.model), study.q, study.found, scene.name)
    return replace(
        built,
        lead=f"Natural modes about the {about}.",
        sections=[*built.sections, _source(scene)],
    )


def vibrations(setting: Setting, q: Array, found: ModesResult, title: str) -> page.Page:
    """The report of natural modes about a shape."""
    count = min(ANIMATED, len(found.frequency))
    animated = [
        section
        for k in range(count)
        for section in motion.sections(
            f"Mode {k + 1}: {frequency(found, k)}",
            _vibration(setting, q, found, k),
            "Deflections are exaggerated or reduced.",
            f"mode {k + 1}",
        )
    ]
    of_all = _table_of_modes(found)
    return page.Page(
        title=title,
        advice=about_model(setting.model),
        lead=f"{setting.view.title}: natural modes, {len(found.frequency)} of them.",
        outcome=outcome_of_modes(found),
        sections=[*animated, page.Section("Modes", [found.message, of_all])],
    )


def outcome_of_modes(found: ModesResult) -> tuple[str, bool]:
    """The outcome, and whether it is good: stable, and at least the slowest vibration is resolved."""
    verdict = "Stable" if found.is_stable else "Unstable"
    if len(found.frequency) and changes(found, 0):
        return f"{verdict}, but the rods have too few modes for the first frequency", False
    return verdict, found.is_stable


def changes(found: ModesResult, k: int) -> str:
    """The frequency that more modes of the rods would give, if it is another one; otherwise empty."""
    if found.refined_frequency is None:
        return ""
    was, becomes = found.frequency[k], found.refined_frequency[k]
    return f"{becomes:.4g}" if abs(was - becomes) > RESOLVED * max(was, becomes) else ""


#: Relative change of a frequency with more modes up to which it counts as resolved, as in messages.
RESOLVED = 1e-2

#: Columns of the table of modes, and the one beside the frequency where more modes change some.
COLUMNS = ("mode", "frequency (Hz)", "damping ratio", "decay rate (1/s)")
WITH_MORE_MODES = "with more modes (Hz)"


def _table_of_modes(found: ModesResult) -> page.Table:
    refined = [changes(found, k) for k in range(len(found.frequency))]
    rows: list[tuple[str, ...]] = list(table(found))
    columns: tuple[str, ...] = COLUMNS
    if any(refined):
        columns = (*COLUMNS[:2], WITH_MORE_MODES, *COLUMNS[2:])
        rows = [(*row[:2], other, *row[2:]) for row, other in zip(rows, refined, strict=True)]
    return page.Table(columns, rows, frozenset(columns))


def table(found: ModesResult) -> list[tuple[str, str, str, str]]:
    """Table of the modes."""

    def oscillates(k: int, hertz: float) -> str:
        if is_overdamped(found, k):
            return "overdamped"
        return "0" if is_rounding(found, k) else f"{hertz:.6g}"

    return [
        (str(k + 1), oscillates(k, hertz), f"{ratio:.4g}", f"{-s.real + 0.0:.4g}")
        for k, (hertz, ratio, s) in enumerate(
            zip(found.frequency, found.damping_ratio, found.eigenvalues, strict=True)
        )
    ]


def _vibration(setting: Setting, q: Array, found: ModesResult, k: int) -> Slides:
    """One period of a mode."""
    hertz = found.frequency[k]
    period = 1.0 if is_rounding(found, k) else 1.0 / hertz
    phase = np.linspace(0.0, 1.0, FRAMES)
    states = mode_motion(setting, q, found.shapes[:, k], phase)
    return Slides(setting, phase * period, states, outline=("undeflected shape", q))
