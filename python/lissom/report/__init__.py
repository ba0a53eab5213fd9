"""The report of a run: one HTML file with the motion, the coordinates, the energies, the statistics."""

from __future__ import annotations

from pathlib import Path

from ..results import Run
from ..views import Member
from . import actuators, curves, motion, page, text


def write(run: Run, path: Path) -> None:
    """Write the report of ``run`` to ``path``. Needs plotly."""
    path.write_text(page.render(build(run)), encoding="utf-8")


def build(run: Run) -> page.Page:
    """What the report says."""
    sections = [
        *motion.sections("Motion", run, text.animation(run)),
        *(_links(run) if run.view.members else _whole(run)),
        *_actuators(run),
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


def _whole(run: Run) -> list[page.Section]:
    """The curves of a model that is looked at as a whole."""
    return [
        *(
            page.Section(frame.name.capitalize(), [page.Figure(curves.position(run, frame))])
            for frame in run.view.frames
        ),
        page.Section(
            "Coordinates", [page.Figure(curves.coordinates(run), text.coordinates(run.view.coordinates))]
        ),
    ]


def _links(run: Run) -> list[page.Section]:
    """The curves of a robot: of the link that is picked."""
    at = curves.instants(run)
    options = [(member.name, _member(run, member, at)) for member in run.view.members]
    return [page.Section("Links", [page.Choice("Link", options)])]


def _actuators(run: Run) -> list[page.Section]:
    """What actuators do over time; nothing where there are none."""
    figure = actuators.figure(run)
    return [] if figure is None else [page.Section("Actuators", [page.Figure(figure)])]


def _member(run: Run, member: Member, at: curves.Instants) -> list[page.Part]:
    """The curves of a link."""
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
