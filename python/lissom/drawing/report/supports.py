"""Symbols of supports and of clamped bases."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...model.glyphs.joints import Pose
from ...model.glyphs.supports import SupportGlyph
from . import arrows, theme
from .layers import BREAK, Dots, DrawnStates, Solid, Strand, Thing, quaternions

Array = NDArray[np.float64]

LAYERS: dict[str, str] = {"supports": theme.GREEN}

#: Half the width of a clamp's plate, and of the windings of a spring, relative to the model's size.
PLATE, WINDING = 0.045, 0.02

#: Number of windings of a spring.
WINDINGS = 5

#: Radii of anchor balls and of spring wires, relative to the model's size.
ANCHOR, SPRING = 0.012, 0.0035


def supports(glyphs: Sequence[SupportGlyph], shown: DrawnStates) -> list[Thing]:
    """Springs from their anchors to the supported sections; only anchors for rigidly held directions."""
    if not glyphs:
        return []
    anchors = np.stack([glyph.anchor for glyph in glyphs])[None]
    names = [f"support of {glyph.name}" for glyph in glyphs]
    things: list[Thing] = [Dots(names, "supports", anchors, ANCHOR * shown.size)]
    for glyph, name in zip(glyphs, names, strict=True):
        if glyph.holds_places:
            points = _spring(glyph.anchor, glyph.pose(shown.q, shown.t)[..., :3, 3], shown.size)
            things.append(Strand(name, "supports", points, np.full(len(points), SPRING * shown.size)))
    return things


def _spring(anchor: Array, ends: Array, size: float) -> Array:
    """A zigzag (shapes, points, 3) from an anchor to points (shapes, 3)."""
    along = np.concatenate([[0.0, 0.15], np.linspace(0.15, 0.85, 2 * WINDINGS + 1)[1:-1], [0.85, 1.0]])
    across = np.zeros_like(along)
    across[2:-2] = (-1.0) ** np.arange(len(along) - 4)
    reach = ends - anchor
    # A spring that is hardly stretched has small windings.
    width = np.minimum(WINDING * size, 0.2 * np.linalg.norm(reach, axis=-1))
    points = anchor + along[:, None] * reach[:, None]
    points += (width[:, None] * across)[..., None] * arrows.across(reach)[:, None]
    return np.concatenate([points, np.broadcast_to(BREAK, (len(ends), 1, 3))], axis=1)


def clamps(frames: Sequence[Pose], shown: DrawnStates) -> list[Thing]:
    """Plates behind bases that are welded to the world."""
    half = max(PLATE * shown.size, 1.5 * shown.radius)
    behind = np.eye(4)
    behind[0, 3] = -half / 8
    plates: list[Thing] = []
    for clamp in frames:
        poses = np.broadcast_to(clamp(shown.q, shown.t), (len(shown.q), 4, 4)) @ behind
        size = np.array([half / 8, half, half])
        turns = quaternions(poses[:, :3, :3])
        plates.append(Solid("clamp", "supports", "box", size, poses[:, :3, 3], turns))
    return plates
