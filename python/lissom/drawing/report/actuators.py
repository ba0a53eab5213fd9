"""Actuators in reports: tendons (thicker for higher tension), chambers, motors, and their curves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..._lissom import LissomError
from ...model.glyphs.actuators import ActuatorGlyph
from ...model.glyphs.joints import JointGlyph
from ...results.runs import Made, Run
from . import curves, plots, theme
from .layers import DrawnStates, Strand
from .solids import placed

Array = NDArray[np.float64]

LAYERS: dict[str, str] = {"tendons": theme.GOLD, "chambers": theme.CYAN, "motors": theme.PURPLE}

#: Radii of the tendon with the highest tension and of a slack one, relative to the model's size.
THICK, THIN = 0.009, 0.0025

#: Opacity of chambers, through which objects behind them are visible.
OPACITY = 0.6

#: Radius and half the length of a motor, relative to half the axis of a joint.
MOTOR_RADIUS, MOTOR_HALF = 0.3, 0.35


def actuators(
    glyphs: Sequence[ActuatorGlyph], joints: Sequence[JointGlyph], shown: DrawnStates
) -> list[Strand]:
    """All objects drawn for actuators."""
    return [*_tendons(glyphs, shown), *_chambers(glyphs, shown), *_motors(glyphs, joints, shown)]


def _tendons(glyphs: Sequence[ActuatorGlyph], shown: DrawnStates) -> list[Strand]:
    """Tubes along the paths of tendons, with radii that increase with the tension."""
    tendons = [glyph for glyph in glyphs if glyph.kind == "tendon" and glyph.way is not None]
    tensions = [
        np.maximum(_finite(glyph.force(shown.q, shown.v, shown.t, shown.u)), 0.0) for glyph in tendons
    ]
    pulls = max((float(tension.max()) for tension in tensions), default=0.0)
    largest = float(shown.largest.of("tension", pulls)) or 1.0
    strands = []
    for glyph, tension in zip(tendons, tensions, strict=True):
        assert glyph.way is not None
        radius = shown.size * (THIN + (THICK - THIN) * tension / largest)
        text = f"tendon {glyph.name}, at most {tension.max():.3g} N"
        strands.append(Strand(text, "tendons", glyph.way(shown.q, shown.t), radius))
    return strands


def _chambers(glyphs: Sequence[ActuatorGlyph], shown: DrawnStates) -> list[Strand]:
    """Tubes with the cross-sectional areas of chambers."""
    return [
        Strand(
            f"chamber {glyph.name}",
            "chambers",
            glyph.way(shown.q, shown.t),
            np.full(len(shown.q), glyph.radius),
            OPACITY,
        )
        for glyph in glyphs
        if glyph.kind == "chamber" and glyph.way is not None
    ]


def _motors(
    glyphs: Sequence[ActuatorGlyph], joints: Sequence[JointGlyph], shown: DrawnStates
) -> list[Strand]:
    """Drums around the axes of revolute joints and screws, boxes on the rails of prismatic ones."""
    strands = []
    for glyph in glyphs:
        joint = None if glyph.coordinate is None else _joint(joints, *glyph.coordinate)
        if joint is None:
            continue
        half = shown.half_axis
        ends = np.array([[-MOTOR_HALF * half, 0.0, 0.0], [MOTOR_HALF * half, 0.0, 0.0]])
        way = placed(joint.pose(shown.q, shown.t), ends)
        radius = np.full(len(way), MOTOR_RADIUS * half)
        strands.append(Strand(f"motor {glyph.name}", "motors", way, radius))
    return strands


def _joint(joints: Sequence[JointGlyph], link: str, coordinate: str) -> JointGlyph | None:
    """The glyph of a joint's coordinate."""
    kinds = ("turning",) if coordinate.startswith("angle") else ("sliding", "plane")
    found = [glyph for glyph in joints if glyph.name == link and glyph.kind in kinds]
    # For a joint with two axes, the second coordinate has index one.
    return found[-1 if coordinate.endswith("[1]") else 0] if found else None


def _finite(values: Array) -> Array:
    # The last state of a failed run can overflow.
    return np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)


def figure(run: Run | Made) -> plots.Figure | None:
    """Forces and lengths of actuators over time, one plot per quantity; None if they are unknown."""
    at = curves.instants(run)
    q, v, t, u = run.q[at], run.v[at], run.t[at], run.u[at]
    plots: dict[str, list[tuple[str, Array]]] = {}
    try:
        for glyph in run.view.glyphs.actuators:
            of_force, of_length = glyph.quantities
            plots.setdefault(of_force, []).append((glyph.name, glyph.force(q, v, t, u)))
            if glyph.kind != "active strain":
                plots.setdefault(of_length, []).append((glyph.name, glyph.length(q, t)))
    except (ValueError, LissomError):
        # The last state of a failed run can overflow.
        return None
    return curves.stacked(t, plots) if plots else None
