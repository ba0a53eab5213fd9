"""Symbols of joints: bars for rotations, rails for translations, frames for planes, balls."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...model.glyphs.joints import JointGlyph
from . import theme
from .layers import BREAK, Dots, DrawnStates, Strand, Thing
from .solids import placed

Array = NDArray[np.float64]

LAYERS: dict[str, str] = {"joints": theme.PURPLE}

#: Thickness of the bars and rails of joints, relative to half an axis; radius of their balls, relative to the
#: model's size.
BAR, RAIL, BALL = 0.16, 0.08, 0.016


def joints(
    glyphs: Sequence[JointGlyph], shown: DrawnStates, layer: str = "joints", name: str = ""
) -> list[Thing]:
    """All objects drawn for joints, under one name or as those of their links."""
    things: list[Thing] = []
    balls, names = [], []
    for glyph in glyphs:
        poses = glyph.pose(shown.q, shown.t)
        of_glyph = name or f"joint of {glyph.name}"
        if glyph.kind == "ball":
            balls.append(np.broadcast_to(poses[..., None, :3, 3], (len(shown.q), 1, 3)))
            names.append(of_glyph)
            continue
        local, thickness = _lines(glyph, shown, layer)
        radius = np.full(len(shown.q), thickness * shown.half_axis)
        things.append(Strand(of_glyph, layer, placed(poses, local), radius))
    if balls:
        things.append(Dots(names, layer, np.concatenate(balls, axis=1), BALL * shown.size))
    return things


def _lines(glyph: JointGlyph, shown: DrawnStates, layer: str) -> tuple[Array, float]:
    """Lines in the frame of a joint, and their thickness; rails cover the whole range of motion."""
    half = shown.half_axis
    if glyph.kind == "turning":
        return np.array([[-half, 0.0, 0.0], [half, 0.0, 0.0], *BREAK]), BAR
    travel = np.broadcast_to(glyph.travel(shown.q, shown.t), (len(shown.q), 3))
    name = f"{layer} {glyph.kind} {glyph.name}"
    low = -shown.largest.of(f"{name} back", -travel.min(axis=0)) - half
    high = shown.largest.of(f"{name} forth", travel.max(axis=0)) + half
    if glyph.kind == "sliding":
        a, b, gap = low[0], high[0], 0.3 * half
        rails = [[a, -gap, 0.0], [b, -gap, 0.0], *BREAK, [a, gap, 0.0], [b, gap, 0.0], *BREAK]
        return np.array(rails), RAIL
    (_, a, c), (_, b, d) = low, high
    corners = [[0.0, a, c], [0.0, b, c], [0.0, b, d], [0.0, a, d], [0.0, a, c], *BREAK]
    return np.array(corners), RAIL
