"""The reports of equilibria and of natural modes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .._lissom import EquilibriumPath
from ..results import Array
from ..studies import ModesStudy, Slides, StaticsStudy
from ..views import Member, view
from . import motion, page, plots, theme
from .text import quantity

#: Modes that are animated; the table has all of them.
ANIMATED = 4

#: Frames of one vibration.
FRAMES = 49

#: Largest deflection of an animated mode, relative to the rod's length; in coordinates for a pendulum.
AMPLITUDE = 0.15

#: Modes in the table of the command line.
LISTED = 10


def write(study: StaticsStudy | ModesStudy, path: Path) -> None:
    """Write the report of a study to ``path``."""
    built = statics(study) if isinstance(study, StaticsStudy) else modes(study)
    path.write_text(page.render(built), encoding="utf-8")


def statics(study: StaticsStudy) -> page.Page:
    """What the report of an equilibrium says."""
    found, path = study.found, study.found.path
    if path is None:
        load_factor, q = np.array([0.0, 1.0]), np.stack([study.scene.q0, found.q])
        label, caption = ("", ""), "0 is the start, 1 the equilibrium."
        factors = None
    else:
        load_factor, q = path.load_factor, path.q
        label = ("load factor ", "")
        caption = "Equilibria while the loads grow, the last one first; between them shapes are interpolated."
        factors = load_factor
    slides = Slides(study.scene, load_factor, q, label, opens_at=len(q) - 1, factors=factors)
    sections = motion.sections("Shape", slides, caption)
    if path is not None:
        sections.append(page.Section("Stiffness", _stiffness(path)))
    if found.success and slides.view.members:
        sections.append(page.Section("Links", [_wrenches(study, slides.view.members)]))
    sections += [
        page.Section("Result", [found.message, page.Table(("", ""), summary(study))]),
        page.Section("Scene", [page.Source("The scene file", study.scene.text)]),
    ]
    return page.Page(
        title=study.scene.name,
        lead="Equilibrium at rest, "
        + ("let go from q0." if study.from_start else "from the unloaded state."),
        outcome=outcome(study),
        sections=sections,
    )


def outcome(study: StaticsStudy) -> tuple[str, bool]:
    """How it went, and whether that is good."""
    found = study.found
    if not found.success:
        return f"Failed: {found.status}", False
    return f"In equilibrium, {found.stability or 'stability unknown'}", bool(found.is_stable)


def summary(study: StaticsStudy) -> list[tuple[str, str]]:
    """The equilibrium in words and numbers."""
    found = study.found
    rows: list[tuple[str, str]] = [("stability", found.stability or "unknown")]
    for frame in view(study.scene.model).frames:
        x, y, z = frame.pose(found.q, study.scene.simulation.t0)[:3, 3]
        rows.append((frame.name, f"({x:.6g}, {y:.6g}, {z:.6g}) m"))
    lowest = found.lowest_eigenvalue
    rows += [
        ("lowest stiffness", f"{lowest:.4g} of the elastic one" if np.isfinite(lowest) else "unknown"),
        ("Newton iterations", str(found.nit)),
        ("time", quantity(study.wall_time, "s")),
    ]
    if found.path is not None:
        rows += [
            (point.kind, f"at load factor {point.load_factor:.6g}") for point in found.path.critical_points
        ]
    return rows


def _wrenches(study: StaticsStudy, members: Sequence[Member]) -> page.Table:
    """What each link gets through its joint at rest."""
    q, t = study.found.q[None], np.array([study.scene.simulation.t0])
    rest, u = np.zeros_like(q), study.scene.model.u0[None]

    def components(values: Array) -> str:
        # What rounding leaves of a zero says nothing.
        least = 1e-9 * float(np.abs(values).max())
        return "(" + ", ".join(f"{0.0 if abs(value) < least else value:.4g}" for value in values) + ")"

    rows = []
    for member in members:
        wrench = member.wrench(q, rest, rest, t, u)[0]
        rows.append((member.name, member.carrier, components(wrench[3:]), components(wrench[:3])))
    columns = ("link", "carried by", "force (N)", "moment (N m)")
    caption = "What each link gets through its joint, in the axes of the world; the moment about the joint."
    return page.Table(columns, rows, caption=caption)


def _stiffness(path: EquilibriumPath) -> list[page.Part]:
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
    figure = plots.Figure([[plot]], 320, plots.MOTION)
    return [page.Figure(figure, "Smallest eigenvalue of the tangent stiffness; unstable below zero.")]


def modes(study: ModesStudy) -> page.Page:
    """What the report of natural modes says."""
    count = min(ANIMATED, len(study.found.frequency))
    animated = [
        section
        for k in range(count)
        for section in motion.sections(
            f"Mode {k + 1}: {frequency(study, k)}",
            _vibration(study, k),
            "Deflections are exaggerated or reduced.",
            f"mode {k + 1}",
        )
    ]
    return page.Page(
        title=study.scene.name,
        lead="Natural modes about "
        + ("the initial shape." if study.statics is None else "the equilibrium at rest."),
        outcome=("Stable" if study.found.is_stable else "Unstable", study.found.is_stable),
        sections=[
            *animated,
            page.Section("Modes", [page.Table(COLUMNS, table(study), frozenset(COLUMNS))]),
            page.Section("Scene", [page.Source("The scene file", study.scene.text)]),
        ],
    )


#: Columns of the table of modes.
COLUMNS = ("mode", "frequency (Hz)", "damping ratio", "decay rate (1/s)")


def table(study: ModesStudy) -> list[tuple[str, str, str, str]]:
    """The modes in numbers."""
    found = study.found
    return [
        (str(k + 1), f"{hertz:.6g}", f"{ratio:.4g}", f"{-s.real + 0.0:.4g}")
        for k, (hertz, ratio, s) in enumerate(
            zip(found.frequency, found.damping_ratio, found.eigenvalues, strict=True)
        )
    ]


def frequency(study: ModesStudy, k: int) -> str:
    """The frequency of a mode in words."""
    hertz = study.found.frequency[k]
    if hertz > 0:
        return f"{hertz:.4g} Hz"
    return "grows without oscillation" if study.found.eigenvalues[k].real > 0 else "rigid-body motion"


def _vibration(study: ModesStudy, k: int) -> Slides:
    """One period of a mode."""
    phase = np.linspace(0.0, 2.0 * np.pi, FRAMES)
    shape = study.found.shapes[:, k]
    shape = shape * (AMPLITUDE / _deflection(study, shape))
    hertz = study.found.frequency[k]
    period = 1.0 / hertz if hertz > 0 else 1.0
    q = study.q + np.real(np.exp(1j * phase)[:, None] * shape)
    return Slides(study.scene, phase / (2.0 * np.pi) * period, q)


def _deflection(study: ModesStudy, shape: Array) -> float:
    """Largest deflection of a shape, relative to the model's size; without links its largest coordinate."""
    seen = view(study.scene.model)
    if not seen.is_spatial:
        return float(np.abs(shape).max())

    def largest(part: Array) -> float:
        # Of small motions: the shape itself may be a bend of many turns.
        size = float(np.abs(part).max()) * seen.size
        if size == 0.0:
            return 0.0
        small = part * (1e-4 / size)
        t0 = study.scene.simulation.t0
        moved = 0.0
        for link in seen.links:
            bent, straight = (link.pose(q, link.stations, t0)[:, :3, 3] for q in (study.q + small, study.q))
            moved = max(moved, float(np.linalg.norm(bent - straight, axis=1).max()))
        for solid in seen.solids:
            there, here = (solid.pose(q, t0)[:3, 3] for q in (study.q + small, study.q))
            moved = max(moved, float(np.linalg.norm(there - here)))
        return moved * (size / 1e-4) / seen.size

    deflection = float(np.hypot(largest(np.real(shape)), largest(np.imag(shape))))
    # Torsion of a straight rod deflects nothing: a radian of it is shown.
    return (
        deflection
        if deflection > 1e-9 * float(np.abs(shape).max()) * seen.size
        else float(np.abs(shape).max() * seen.size * AMPLITUDE)
    )
