"""Loads at each frame: arrows for forces, rings for moments."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...model.glyphs.loads import LoadGlyph
from . import arrows, theme
from .layers import BREAK, Arrows, DrawnStates, Largest, Strand, Thing

Array = NDArray[np.float64]

LAYERS: dict[str, str] = {"forces": theme.RED, "moments": theme.MAGENTA}

#: Length of the largest force arrow and radius of the largest moment ring, relative to the model's size.
ARROW, RING = 0.28, 0.09

#: At its largest, every arrow has at least this fraction of the length of the largest one of its kind, to
#: remain visible.
LEAST_ARROW = 1 / 3

#: Angle covered by a moment ring, and its number of points.
AROUND, POINTS_AROUND = 1.5 * np.pi, 25

#: Radii of the bar at the tails of distributed arrows and of the wire of rings, relative to the model's size.
COMB, WIRE = 0.0035, 0.007


def loads(glyphs: Sequence[LoadGlyph], shown: DrawnStates) -> list[Thing]:
    """Forces and moments."""
    return [
        *_forces([glyph for glyph in glyphs if glyph.kind == "force"], shown),
        *_moments([glyph for glyph in glyphs if glyph.kind == "moment"], shown),
    ]


def _forces(glyphs: Sequence[LoadGlyph], shown: DrawnStates) -> list[Thing]:
    """Arrows that start at a pulling force or end at a pushing one; combs of arrows for distributed
    forces."""
    found = [_vectors(glyph, shown) for glyph in glyphs]
    things: list[Thing] = []
    tails, pulls, combs, names = [], [], [], []
    # Newtons and newtons per metre need separate scales.
    for is_spread in (False, True):
        chosen = [i for i, glyph in enumerate(glyphs) if glyph.is_spread == is_spread]
        if not chosen:
            continue
        size = ARROW * shown.size * (0.6 if is_spread else 1.0)
        drawn = drawn_lengths([found[i][2] for i in chosen], size, shown.largest, f"force {is_spread}")
        for i, arrow in zip(chosen, drawn, strict=True):
            poses = found[i][0]
            place = poses[..., :3, 3]
            length = np.linalg.norm(arrow, axis=-1)
            inwards = -glyphs[i].outwards * np.einsum("kpi,kpi->kp", arrow, poses[..., :3, 0])
            # Arrows that would lie within the rod are drawn in front of it.
            pushes = np.ones_like(length) if is_spread else (inwards > 0.5 * length).astype(float)
            tails.append(place - pushes[..., None] * arrow)
            pulls.append(arrow)
            names += [f"force on {glyphs[i].name}"] * arrow.shape[1]
            if is_spread:
                breaks = np.broadcast_to(BREAK, (len(arrow), 1, 3))
                combs.append(np.concatenate([tails[-1], breaks], axis=1))
    if pulls:
        tail, pull = np.concatenate(tails, axis=1), np.concatenate(pulls, axis=1)
        things.append(arrows.arrows("forces", tail, pull, shown.size, names))
    if combs:
        radius = np.full(len(shown.q), COMB * shown.size)
        things.append(Strand("spread forces", "forces", np.concatenate(combs, axis=1), radius))
    return things


def _moments(glyphs: Sequence[LoadGlyph], shown: DrawnStates) -> list[Thing]:
    """Rings about the axes of moments, with a head for the sense of rotation."""
    found = [_vectors(glyph, shown) for glyph in glyphs]
    rings, ends, heads, names = [], [], [], []
    for is_spread in (False, True):
        chosen = [i for i, glyph in enumerate(glyphs) if glyph.is_spread == is_spread]
        if not chosen:
            continue
        size = shown.radius + RING * shown.size
        drawn = drawn_lengths([found[i][2] for i in chosen], size, shown.largest, f"moment {is_spread}")
        for i, vector in zip(chosen, drawn, strict=True):
            poses, own, _ = found[i]
            radius = np.linalg.norm(vector, axis=-1)[..., None]
            first, second = _axes_across(vector, poses, own, glyphs[i].follows)
            angle = np.linspace(0.0, AROUND, POINTS_AROUND)[:, None]
            centre = poses[..., None, :3, 3]
            ring = centre + radius[..., None] * (
                np.cos(angle) * first[..., None, :] + np.sin(angle) * second[..., None, :]
            )
            shapes, places = ring.shape[:2]
            breaks = np.broadcast_to(BREAK, (shapes, places, 1, 3))
            rings.append(np.concatenate([ring, breaks], axis=2).reshape(shapes, -1, 3))
            forward = np.cos(AROUND) * second - np.sin(AROUND) * first
            ends.append(ring[..., -1, :])
            heads.append(0.6 * radius * forward)
            names += [f"moment on {glyphs[i].name}"] * places
    if not rings:
        return []
    end, head = np.concatenate(ends, axis=1), np.concatenate(heads, axis=1)
    return [
        Strand(
            ", ".join(dict.fromkeys(names)),
            "moments",
            np.concatenate(rings, axis=1),
            np.full(len(shown.q), WIRE * shown.size),
        ),
        # Heads only: each has the length of its vector.
        Arrows(
            names,
            "moments",
            end,
            head,
            head=2.0 * shown.size,
            head_radius=2.0 * shown.size * arrows.HEAD_RADIUS / arrows.HEAD,
            radius=WIRE * shown.size,
            most=1.0,
        ),
    ]


def _vectors(glyph: LoadGlyph, shown: DrawnStates) -> tuple[Array, Array, Array]:
    """Poses (shapes, places, 4, 4) of a load's places, and its vectors in its own axes and in world axes."""
    poses = glyph.pose(shown.q, shown.t)
    # Halved, so that rotations of the largest doubles do not overflow; non-finite vectors are not drawn.
    value = (
        0.5
        * shown.load_factor[:, None]
        * np.nan_to_num(glyph.value(shown.t, shown.u), posinf=0.0, neginf=0.0)
    )
    own = np.broadcast_to(value[:, None], (*poses.shape[:2], 3))
    world = np.einsum("kpij,kpj->kpi", poses[..., :3, :3], own) if glyph.follows else own
    return poses, own, world


def drawn_lengths(vectors: Sequence[Array], length: float, largest: Largest, kind: str) -> list[Array]:
    """Scale vectors (shapes, places, 3) to the lengths at which they are drawn.

    Each vector keeps its variation in time. The largest one has the length
    ``length``; the others are to scale, but have at least the fraction `LEAST_ARROW` of that at their
    largest.
    """
    # Squares of large numbers overflow.
    sizes = [float(np.abs(vector).max()) for vector in vectors]
    vectors = [vector / (size or 1.0) for vector, size in zip(vectors, sizes, strict=True)]
    norms = [float(np.linalg.norm(vector, axis=-1).max()) for vector in vectors]
    peaks = largest.of(kind, np.array([size * norm for size, norm in zip(sizes, norms, strict=True)]))
    shares = peaks / (peaks.max() or 1.0)
    return [
        vector * (length * max(LEAST_ARROW, share) * (size / peak)) if norm > 0.0 else vector
        for vector, size, norm, peak, share in zip(vectors, sizes, norms, peaks, shares, strict=True)
    ]


def _axes_across(vector: Array, poses: Array, own: Array, follows: bool) -> tuple[Array, Array]:
    """Two unit vectors perpendicular to each vector (shapes, places, 3), without jumps over the shapes."""
    peak = own.reshape(-1, 3)[int(np.argmax(np.abs(own.reshape(-1, 3)).max(axis=1)))]
    least = int(np.argmin(np.abs(peak)))
    start = poses[..., :3, least] if follows else np.broadcast_to(np.eye(3)[least], vector.shape)
    axis = arrows.unit(vector)
    first = arrows.unit(start - np.einsum("kpi,kpi->kp", start, axis)[..., None] * axis)
    return first, np.cross(axis, first)
