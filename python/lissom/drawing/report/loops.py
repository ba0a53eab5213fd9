"""Closed loops in reports: connections, constraint forces and violations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..._lissom import LissomError
from ...model.glyphs.joints import Pose
from ...model.glyphs.loops import LoopGlyph
from ...results.runs import Made, Run
from . import curves, plots, theme
from .joints import joints
from .layers import BREAK, Dots, DrawnStates, Solid, Strand, Thing, quaternions

Array = NDArray[np.float64]

LAYERS: dict[str, str] = {"loops": theme.BLUE}

#: Half the side of a weld, and radius of the balls at the ends of a bar, relative to the model's size.
WELD, BALL = 0.012, 0.013

#: Half the length of an axis, relative to the model's size: shorter than for joints, because one body may
#: have several.
AXIS = 0.045

#: Thickness of a bar, and of the connection between a section or body and a frame at an offset, relative to
#: half the axis of a joint.
BAR, ARM = 0.12, 0.06

#: Offsets smaller than this, relative to the model's size, are drawn without a connection.
BESIDE = 1e-3

#: Maximum number of instants at which forces are evaluated: each one costs a decomposition of all
#: constraints.
INSTANTS = 400

#: Axis title of gaps by unit.
GAPS = {"m": "gap (m)", "cosine": "gap of a cosine (1)", "coordinate": "gap of a gear"}


def loops(glyphs: Sequence[LoopGlyph], shown: DrawnStates) -> list[Thing]:
    """All objects drawn for closed loops; gears between coordinates have no position."""
    things: list[Thing] = []
    shown = replace(shown, half_axis=AXIS * shown.size)
    for glyph in glyphs:
        name = f"loop {glyph.name}"
        things += joints(glyph.joints, shown, "loops", name)
        things += [_arm(name, frame, on, shown) for frame, on in glyph.ends if on is not None]
        if glyph.kind == "weld":
            things += [_weld(name, frame, shown) for frame, _ in glyph.ends[:1]]
        if glyph.kind == "distance":
            points = np.stack([_origin(frame, shown) for frame, _ in glyph.ends], axis=1)
            radius = np.full(len(points), BAR * shown.half_axis)
            things.append(Strand(name, "loops", points, radius))
            things.append(Dots([name, name], "loops", points, BALL * shown.size))
    return [thing for thing in things if not (isinstance(thing, Strand) and np.isnan(thing.points).all())]


def _origin(frame: Pose, shown: DrawnStates) -> Array:
    """Origins (shapes, 3) of a frame."""
    return np.asarray(np.broadcast_to(frame(shown.q, shown.t), (len(shown.q), 4, 4))[..., :3, 3])


def _arm(name: str, frame: Pose, on: Pose, shown: DrawnStates) -> Strand:
    """Connection between a section or body and a frame at an offset; nothing if they coincide."""
    points = np.stack([_origin(on, shown), _origin(frame, shown)], axis=1)
    is_beside = np.linalg.norm(points[:, 1] - points[:, 0], axis=-1).max() > BESIDE * shown.size
    points = points if is_beside else np.broadcast_to(BREAK, points.shape)
    return Strand(name, "loops", points, np.full(len(points), ARM * shown.half_axis))


def _weld(name: str, frame: Pose, shown: DrawnStates) -> Solid:
    poses = np.broadcast_to(frame(shown.q, shown.t), (len(shown.q), 4, 4))
    half = np.full(3, max(WELD * shown.size, 1.2 * shown.radius))
    return Solid(name, "loops", "box", half, poses[:, :3, 3], quaternions(poses[:, :3, :3]))


def forces(run: Run | Made, glyph: LoopGlyph) -> plots.Figure | None:
    """Constraint forces of a loop over time; None without accelerations."""
    at = run.instants(INSTANTS)
    known = at[np.isfinite(run.a[at]).all(axis=1)]
    if len(known) == 0:
        return None
    t = run.t[known]
    try:
        held = glyph.force(run.q[known], run.v[known], run.a[known], t, run.u[known])
    except (ValueError, LissomError):
        # The last state of a failed run can overflow.
        return None
    if glyph.kind == "gear":
        return curves.stacked(t, {"force of the gear": [("force", held)]})
    parts = {"force (N)": held[:, 3:], "moment (N m)": held[:, :3]}
    # Spherical joints and bars transmit no moment.
    seen = {title: part for title, part in parts.items() if title.startswith("force") or np.any(part)}
    return curves.stacked(t, {title: list(zip("xyz", part.T, strict=True)) for title, part in seen.items()})


def gaps(run: Run | Made) -> plots.Figure | None:
    """Gaps of loops over time, one plot per unit; None if they are unknown."""
    at = run.instants(INSTANTS)
    t = run.t[at]
    found: dict[str, list[tuple[str, Array]]] = {}
    try:
        for glyph in run.view.glyphs.loops:
            for unit, values in glyph.gaps(run.q[at], t).items():
                found.setdefault(GAPS[unit], []).append((glyph.name, values))
    except (ValueError, LissomError):
        # The last state of a failed run can overflow.
        return None
    return curves.stacked(t, found) if found else None


def widest(run: Run | Made) -> Array:
    """Largest gap (metres, cosines, or units of a coordinate) of all loops in the displayed states."""
    at = run.instants(INSTANTS)
    of_each = [
        values for glyph in run.view.glyphs.loops for values in glyph.gaps(run.q[at], run.t[at]).values()
    ]
    return np.asarray(np.max(of_each, axis=0))
