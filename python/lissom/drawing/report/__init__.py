"""HTML reports of motions in single files: view, coordinates, energies and statistics."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..._lissom import ContinuationResult, EnsembleResult, Model, ModesResult, MotionResult, StaticsResult
from ...analysis.advice import about_model
from ...common import disk
from ...common.arguments import path_of
from ...common.elsewhere import WRITTEN, of_suffix
from ...model.visuals import Visual
from ...results.runs import COUNTERS, Array, Made, Run
from . import actuators, contacts, curves, loops, motion, page, peaks, text

if TYPE_CHECKING:
    from ...analysis.equilibria import EquilibriumSensitivityResult
    from ...analysis.fitted import FitResult
    from ...analysis.sensitivities import SensitivityResult
    from ...model.glyphs.loops import LoopGlyph
    from ...model.views import Member
    from ...results.studies import Setting


def write(run: Run, path: Path) -> None:
    """Write the report of ``run`` to ``path``."""
    disk.write(path, page.render(build(run)))


def _write(built: page.Page, path: str | os.PathLike[str]) -> None:
    """Write a page, unless the suffix is that of another kind of file."""
    path = path_of(path)
    if instead := of_suffix(path.suffix, WRITTEN, "report"):
        raise ValueError(f"path: {path.name!r} has to end with .html{instead}")
    disk.write(path, page.render(built))


def write_result(
    result: MotionResult,
    path: str | os.PathLike[str],
    *,
    title: str = "Motion",
    visuals: Sequence[Visual] = (),
) -> None:
    """Write the report of the result of `simulate` for a model made in Python.

    The report is one HTML file that needs only a browser: the motion in space with everything that acts on
    the model, curves over time, energies, and the cost of the run. Writing takes some tenths of a second; the
    size is about 0.3 MB for a rod and 3 s.

    Parameters
    ----------
    result : MotionResult
        Result of `simulate`; a failed run is shown up to its last state.
    path : path-like
        File to write; an existing file is replaced.
    title : str
        Heading of the page.
    visuals : sequence of Visual
        Meshes that stand for links.

    Raises
    ------
    ValueError, TypeError
        If ``result`` has no model (because it comes from `newmark`) or no state, or a visual is invalid.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> import lissom, lissom.drawing.report, tempfile, pathlib
    >>> finger = lissom.Segment(0.2, 0.01, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 2})
    >>> result = lissom.simulate(lissom.Rod([finger]), 0.1)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     lissom.drawing.report.write_result(result, pathlib.Path(folder) / "finger.html", title="A finger")
    """
    built = build_result(result, title, visuals)
    _write(built, path)


def write_ensemble(
    result: EnsembleResult, path: str | os.PathLike[str], title: str, model: Model | None
) -> None:
    """Write the report of many runs."""
    from . import ensembles

    _write(ensembles.build(result, title, model), path)


def write_parameters(
    result: SensitivityResult | EquilibriumSensitivityResult | FitResult,
    path: str | os.PathLike[str],
    title: str | None,
) -> None:
    """Write the report of derivatives or of a parameter identification."""
    from . import parameters

    _write(parameters.build(result, title), path)


def write_equilibrium(
    result: StaticsResult | ContinuationResult,
    path: str | os.PathLike[str],
    setting: Setting,
    title: str,
) -> None:
    """Write the report of an equilibrium, or of a path of equilibria, of a model made in Python."""
    from . import studies

    if isinstance(result, ContinuationResult):
        if len(result.path.q) == 0:
            raise ValueError(f"result: it has no equilibria to show; {result.message}")
        built = studies.continuation(setting, result, title)
    else:
        if not np.isfinite(result.q).all():
            raise ValueError(f"result: its coordinates are not finite; {result.message}")
        built = studies.equilibrium(setting, result, title)
    _write(built, path)


def write_modes(
    result: ModesResult, path: str | os.PathLike[str], setting: Setting, q: Array, title: str
) -> None:
    """Write the report of natural modes about ``q`` of a model made in Python."""
    from . import studies

    built = studies.vibrations(setting, q, result, title)
    _write(built, path)


def build_result(result: MotionResult, title: str, visuals: Sequence[Visual] = ()) -> page.Page:
    """The report of a motion of a model made in Python."""
    if result.model is None:
        raise ValueError("result: its model is not known; it has to be one of `simulate`, not of `newmark`")
    if len(result.t) == 0:
        raise ValueError(f"result: it has no states to show; {result.message}")
    made = Made(result, result.model, visuals)
    time = text.quantity(float(result.t[-1] - result.t[0]))
    counters = {name: getattr(result.stats, name) for name in COUNTERS}
    rows = [("message", result.message), ("run time", text.quantity(result.stats.wall_time, "s"))]
    rows += [(COUNTERS[name], f"{count:,}") for name, count in counters.items() if count]
    rows += text.hard_steps(result)
    return page.Page(
        title=title,
        lead=f"{made.view.title}, {result.model.n} generalised coordinates, {time} s.",
        outcome=_outcome(result),
        advice=about_model(result.model),
        sections=[*_shown(made), page.Section("Solver", [page.Table(("", ""), rows)])],
    )


def _outcome(result: MotionResult) -> tuple[str, bool]:
    """The outcome of a motion, and whether it is good."""
    if not result.success:
        return f"Ended at {result.t[-1]:.3g} s: {result.message}", False
    return text.finished(result, result.doubt or "")


def build(run: Run) -> page.Page:
    """The report of a run."""
    sections = [
        *_shown(run),
        page.Section("Solver", [page.Table(("", ""), text.statistics(run))]),
        page.Section("Scene", [page.Source("The scene file of this run", run.scene.text)]),
    ]
    return page.Page(
        title=run.scene.name,
        lead=text.lead(run),
        outcome=text.outcome(run),
        advice=run.advice,
        tiles=text.tiles(run),
        sections=sections,
    )


def _shown(run: Run | Made) -> list[page.Section]:
    """Motion and curves."""
    energies: list[page.Part] = []
    if "energy" in run.wants:
        energies = [page.Figure(curves.energies(run)), page.Figure(curves.drift(run), text.energy(run))]
    return [
        *motion.sections("Motion", run, text.animation(run)),
        *(_links(run) if run.view.members else _whole(run)),
        *_actuators(run),
        *_loops(run),
        *_contacts(run),
        *peaks.of_motion(run),
        *([page.Section("Energy", energies)] if energies else []),
    ]


def _whole(run: Run | Made) -> list[page.Section]:
    """Curves of the whole model."""
    return [
        *(
            page.Section(frame.name.capitalize(), [page.Figure(curves.position(run, frame))])
            for frame in run.view.frames
        ),
        page.Section(
            "Coordinates", [page.Figure(curves.coordinates(run), text.coordinates(run.view.coordinates))]
        ),
    ]


def _links(run: Run | Made) -> list[page.Section]:
    """Curves of a robot for the selected link."""
    at = curves.instants(run)
    options = [(member.name, _member(run, member, at)) for member in run.view.members]
    return [page.Section("Links", [page.Choice("Link", options)])]


def _actuators(run: Run | Made) -> list[page.Section]:
    """Curves of actuators over time, if there are any."""
    figure = actuators.figure(run)
    return [] if figure is None else [page.Section("Actuators", [page.Figure(figure)])]


def _loops(run: Run | Made) -> list[page.Section]:
    """Forces and constraint violations of closed loops, if there are any."""
    glyphs = run.view.glyphs.loops
    if not glyphs:
        return []
    forces = [(glyph.name, of_glyph) for glyph in glyphs if (of_glyph := _held(run, glyph))]
    parts: list[page.Part] = []
    if len(forces) > 1:
        parts.append(page.Choice("Loop", forces))
    elif forces:
        parts += forces[0][1]
    gaps = loops.gaps(run)
    if gaps is not None:
        parts.append(page.Figure(gaps, text.gaps(run)))
    return [page.Section("Closed loops", parts)] if parts else []


def _held(run: Run | Made, glyph: LoopGlyph) -> list[page.Part]:
    """Forces of a loop, if they are known."""
    figure = loops.forces(run, glyph)
    return [] if figure is None else [page.Figure(figure, text.held(glyph))]


def _contacts(run: Run | Made) -> list[page.Section]:
    """Contact forces over time, if there are contacts."""
    options: list[tuple[str, list[page.Part]]] = []
    for glyph in run.view.glyphs.contacts.pairs:
        figure = contacts.forces(run, glyph)
        if figure is not None:
            options.append((glyph.name, [page.Figure(figure, text.pressed(glyph))]))
    if not options:
        return []
    parts: list[page.Part] = [page.Choice("Contact", options)] if len(options) > 1 else options[0][1]
    return [page.Section("Contact", parts)]


def _member(run: Run | Made, member: Member, at: curves.Instants) -> list[page.Part]:
    """Curves of a link."""
    parts: list[page.Part] = [page.Figure(curves.position(run, member.frame, at))]
    coordinates = curves.coordinates_of(run, member, at)
    if coordinates is None:
        parts.append(f"{member.name} has no coordinates of its own.")
    else:
        of_modes = text.coordinates(run.view.coordinates[member.coordinates])
        parts.append(page.Figure(coordinates, f"Coordinates of {member.name}. {of_modes}".rstrip()))
    wrench = curves.wrench_of(run, member, at)
    if wrench is not None:
        caption = (
            f"What {member.name} gets through its joint from {member.carrier}, in the axes of the world."
        )
        parts.append(page.Figure(wrench, f"{caption} The moment is about the joint."))
    return parts
