"""Magnets at each frame: arrows from their south to their north poles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...model.glyphs.magnets import MagnetGlyph
from . import arrows, theme
from .layers import DrawnStates, Thing
from .loads import drawn_lengths

LAYERS: dict[str, str] = {"magnets": theme.PURPLE}

#: Length of the arrow of the largest magnet, relative to the model's size.
ARROW = 0.12


def magnets(glyphs: Sequence[MagnetGlyph], shown: DrawnStates) -> list[Thing]:
    """Arrows through the middle of magnets; of magnetised segments at several places."""
    tails, vectors, names = [], [], []
    # Moments and magnetisations need separate scales.
    for is_spread in (False, True):
        chosen = [glyph for glyph in glyphs if glyph.is_spread == is_spread]
        if not chosen:
            continue
        poses = [glyph.pose(shown.q, shown.t) for glyph in chosen]
        moments = [
            np.einsum("kpij,pj->kpi", pose[..., :3, :3], glyph.moment)
            for pose, glyph in zip(poses, chosen, strict=True)
        ]
        size = ARROW * shown.size
        drawn = drawn_lengths(moments, size, shown.largest, f"magnet {is_spread}")
        for glyph, pose, arrow in zip(chosen, poses, drawn, strict=True):
            tails.append(pose[..., :3, 3] - 0.5 * arrow)
            vectors.append(arrow)
            names += [glyph.name] * arrow.shape[1]
    if not names:
        return []
    tail, vector = np.concatenate(tails, axis=1), np.concatenate(vectors, axis=1)
    return [arrows.arrows("magnets", tail, vector, shown.size, names)]
