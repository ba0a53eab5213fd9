"""Small films of the scenes, which the cards of the gallery play under the pointer. Run by `make pictures`.

Animated WebP, drawn as figures for papers are, without a browser: all take about as much as one report.
"""

import io
import sys
from pathlib import Path

import numpy as np
from gallery import CAMERAS, FRONT, ROOT, direction
from matplotlib.figure import Figure
from PIL import Image

import lissom
from lissom.drawing.figures import extent
from lissom.drawing.painting import polygons, seen_from, triangles
from lissom.drawing.parts import parts
from lissom.model.views import view

HERE = ROOT / "docs" / "static" / "films"

#: Pictures of a film, and milliseconds for which each is shown.
PICTURES, PACE = 32, 90

#: Width and height, pixels, and quality from 0 to 100.
SIZE, QUALITY = (280, 210), 40

#: Pixels of an inch: only the widths of lines follow from it.
RESOLUTION = 70

#: Margin relative to the width.
MARGIN = 0.04

UP = np.array([0.0, 0.0, 1.0])


def film(path: Path) -> None:
    """The film of a scene."""
    scene = lissom.Scene.load(path)
    motion = scene.run()
    at = np.linspace(0, len(motion.t) - 1, PICTURES).astype(int)
    what = view(scene.model)
    draw = in_space if what.is_spatial else in_the_plane
    pictures = [as_pixels(figure) for figure in draw(what, motion, at, CAMERAS.get(path.stem, FRONT))]
    target = HERE / f"{path.stem}.webp"
    pictures[0].save(
        target, save_all=True, append_images=pictures[1:], duration=PACE, loop=0, quality=QUALITY, method=6
    )
    print(f"{target.name}: {target.stat().st_size / 1e3:.0f} kB")


def in_space(what, motion, at, camera):
    """A figure for each picture, all of the same part of space."""
    found, is_there = parts(what, motion.q[at], motion.v[at], motion.u[at], motion.t[at], is_smooth=True)
    axes = seen_from(direction(camera), UP)
    low, high = fitted(*(corner[:2] for corner in extent(found, axes)))
    for k in range(int(is_there.sum())):
        figure, plot = empty(low, high)
        plot.add_collection(polygons(triangles(found, axes, [k])), autolim=False)
        yield figure


def in_the_plane(what, motion, at, camera):
    """A mass on its spring."""
    path = what.sketch.mass(motion.q)
    low, high = fitted(np.minimum(path.min(axis=0), 0.0), np.maximum(path.max(axis=0), 0.0))
    for q in motion.q[at]:
        figure, plot = empty(low, high)
        plot.plot(*what.sketch.line(q).T, color="#33415c")
        plot.plot(*what.sketch.mass(q[None]).T, "o", color="#21918c", markersize=11)
        yield figure


def fitted(low, high):
    """A rectangle with a margin around another one, of the shape of a film."""
    middle, size = 0.5 * (low + high), (1.0 + 2.0 * MARGIN) * (high - low)
    tall = max(size[1], size[0] * SIZE[1] / SIZE[0])
    half = 0.5 * np.array([tall * SIZE[0] / SIZE[1], tall])
    return middle - half, middle + half


def empty(low, high):
    figure = Figure(figsize=(SIZE[0] / RESOLUTION, SIZE[1] / RESOLUTION), dpi=RESOLUTION)
    plot = figure.add_axes((0, 0, 1, 1), xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    plot.set_axis_off()
    return figure, plot


def as_pixels(figure):
    memory = io.BytesIO()
    figure.savefig(memory, format="png")
    return Image.open(memory).convert("RGB")


def main(names) -> None:
    HERE.mkdir(exist_ok=True)
    for path in sorted((ROOT / "scenes").glob("*.toml")):
        if not names or path.stem in names:
            film(path)


if __name__ == "__main__":
    main(sys.argv[1:])
