"""Actuators: tendons as thick as they pull, chambers, motors; and what they do over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._lissom import LissomError
from ..actuator_marks import ActuatorMark
from ..marks import JointMark
from ..results import Run
from . import arrows, curves, theme
from .layers import Shown, Trace
from .solids import placed

Array = NDArray[np.float64]

#: Radius of the tendon that pulls most, and of one that is slack, relative to the model's size.
THICK, THIN = 0.009, 0.0025

#: Corners of their cross-sections.
CORNERS = 6

#: Radius and half the length of a motor, relative to half the axis of a joint.
MOTOR_RADIUS, MOTOR_HALF = 0.45, 0.4


def actuators(marks: Sequence[ActuatorMark], joints: Sequence[JointMark], shown: Shown) -> list[Trace]:
    """All that is drawn of actuators."""
    return [*_tendons(marks, shown), *_chambers(marks, shown), *_motors(marks, joints, shown)]


def _tendons(marks: Sequence[ActuatorMark], shown: Shown) -> list[Trace]:
    """Tubes along the ways of tendons, as thick as they pull."""
    tendons = [mark for mark in marks if mark.kind == "tendon" and mark.way is not None]
    tensions = [np.maximum(_finite(mark.force(shown.q, shown.v, shown.t)), 0.0) for mark in tendons]
    largest = max((float(tension.max()) for tension in tensions), default=0.0) or 1.0
    traces = []
    for mark, tension in zip(tendons, tensions, strict=True):
        assert mark.way is not None
        radius = shown.size * (THIN + (THICK - THIN) * tension / largest)
        text = f"tendon {mark.name}, at most {tension.max():.3g} N"
        traces.append(_tube("tendons", mark.way(shown.q, shown.t), radius, text, color=theme.GOLD))
    return traces


def _chambers(marks: Sequence[ActuatorMark], shown: Shown) -> list[Trace]:
    """Tubes with the area of chambers."""
    return [
        _tube(
            "chambers",
            mark.way(shown.q, shown.t),
            np.full(len(shown.q), mark.radius),
            f"chamber {mark.name}",
            color=theme.CYAN,
            opacity=0.6,
        )
        for mark in marks
        if mark.kind == "chamber" and mark.way is not None
    ]


def _motors(marks: Sequence[ActuatorMark], joints: Sequence[JointMark], shown: Shown) -> list[Trace]:
    """Drums around the axes of joints, boxes on their rails."""
    traces = []
    for mark in marks:
        joint = None if mark.coordinate is None else _joint(joints, *mark.coordinate)
        if joint is None:
            continue
        half = shown.half_axis
        ends = np.array([[-MOTOR_HALF * half, 0.0, 0.0], [MOTOR_HALF * half, 0.0, 0.0]])
        way = placed(joint.pose(shown.q, shown.t), ends)
        radius = np.full(len(way), MOTOR_RADIUS * half)
        traces.append(_tube("motors", way, radius, f"motor {mark.name}", color=theme.PURPLE, opacity=0.8))
    return traces


def _joint(joints: Sequence[JointMark], link: str, coordinate: str) -> JointMark | None:
    """The mark of a coordinate of a joint."""
    kinds = ("turning",) if coordinate.startswith("angle") else ("sliding", "plane")
    found = [mark for mark in joints if mark.name == link and mark.kind in kinds]
    # Of two axes that turn, the second one has the number one.
    return found[-1 if coordinate.endswith("[1]") else 0] if found else None


def _finite(values: Array) -> Array:
    # The end of a run that failed can be beyond all numbers.
    return np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)


def _tube(layer: str, way: Array, radius: Array, text: str, **looks: Any) -> Trace:
    """Straight pieces (shapes, points, 3) as prisms of a radius in each shape."""
    start, end = way[:, :-1], way[:, 1:]
    along = end - start
    first = arrows.across(along)
    second = np.cross(arrows.unit(along), first)
    angle = 2.0 * np.pi * np.arange(CORNERS)[:, None] / CORNERS
    ring = np.cos(angle) * first[..., None, :] + np.sin(angle) * second[..., None, :]
    ring = ring * radius[:, None, None, None]
    corners = np.stack([start[..., None, :] + ring, end[..., None, :] + ring], axis=2)
    pieces = along.shape[1]
    near, after = np.arange(CORNERS), (np.arange(CORNERS) + 1) % CORNERS
    one = np.concatenate(
        [
            np.stack([near, near + CORNERS, after], axis=1),
            np.stack([after, near + CORNERS, after + CORNERS], axis=1),
        ]
    )
    faces = (one[None] + 2 * CORNERS * np.arange(pieces)[:, None, None]).reshape(-1, 3)
    return Trace(
        layer,
        "mesh3d",
        corners.reshape(len(way), -1, 3),
        {
            **dict(zip("ijk", faces.astype(np.int32).T, strict=True)),
            "flatshading": True,
            "name": text,
            "hoverinfo": "name",
        }
        | looks,
    )


def figure(run: Run) -> Any | None:
    """What actuators do and how long they are over time, a plot a quantity; None where nothing is known."""
    at = curves.instants(run)
    q, v, t = run.q[at], run.v[at], run.t[at]
    plots: dict[str, list[tuple[str, Array]]] = {}
    try:
        for mark in run.view.marks.actuators:
            of_force, of_length = mark.quantities
            plots.setdefault(of_force, []).append((mark.name, mark.force(q, v, t)))
            if mark.kind != "active strain":
                plots.setdefault(of_length, []).append((mark.name, mark.length(q, t)))
    except (ValueError, LissomError):
        # The end of a run that failed can be beyond all numbers.
        return None
    return curves.stacked(t, plots) if plots else None
