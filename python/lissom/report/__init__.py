"""The report of a run: one HTML file with the motion, the coordinates, the energies, the statistics."""

from __future__ import annotations

from pathlib import Path

from ..results import Run
from . import curves, motion, page, text


def write(run: Run, path: Path) -> None:
    """Write the report of ``run`` to ``path``. Needs plotly."""
    path.write_text(page.render(build(run)), encoding="utf-8")


def build(run: Run) -> page.Page:
    """What the report says."""
    sections = [
        *motion.sections("Motion", run, text.animation(run)),
        *(
            page.Section(frame.name.capitalize(), [page.Figure(curves.position(run, frame))])
            for frame in run.view.frames
        ),
        page.Section("Coordinates", [page.Figure(curves.coordinates(run), text.coordinates(run))]),
        *(
            [
                page.Section(
                    "Energy",
                    [page.Figure(curves.energies(run)), page.Figure(curves.drift(run), text.energy(run))],
                )
            ]
            if "energy" in run.wants
            else []
        ),
        page.Section("Solver", [page.Table(("", ""), text.statistics(run))]),
        page.Section("Scene", [page.Source("The scene file of this run", run.scene.text)]),
    ]
    return page.Page(
        title=run.scene.name,
        lead=text.lead(run),
        outcome=text.outcome(run),
        tiles=text.tiles(run),
        sections=sections,
    )
