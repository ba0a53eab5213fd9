"""The moving picture of the README and the landing page: an octopus that swims. Run it by `make pictures`.

The page names `octopus.gif` alone: any other command may write that file.
"""

import io
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

import lissom
from lissom.drawing.figures import extent
from lissom.drawing.painting import polygons, seen_from, triangles
from lissom.drawing.parts import parts
from lissom.model.views import view

HERE = Path(__file__).parent
SCENE = HERE.parents[1] / "scenes" / "octopus.toml"

#: Pictures, and milliseconds for which each is shown.
PICTURES, PACE = 48, 80
COLOURS = 24

#: Width in inches and resolution: 450 pixels.
WIDTH, RESOLUTION = 5.6, 80

#: From where it is seen, and the margin relative to the width.
TOWARDS, MARGIN = np.array([0.49, -0.85, 0.21]), 0.03


def main() -> None:
    scene = lissom.Scene.load(SCENE)
    motion = scene.run()
    at = np.linspace(0, len(motion.t) - 1, PICTURES).astype(int)
    found, _ = parts(view(scene.model), motion.q[at], motion.v[at], motion.u[at], motion.t[at])
    axes = seen_from(TOWARDS, np.array([0.0, 0.0, 1.0]))
    low, high = (corner[:2] for corner in extent(found, axes))
    margin = MARGIN * (high - low)[0]
    low, high = low - margin, high + margin
    pictures = []
    for k in range(PICTURES):
        figure = Figure(figsize=(WIDTH, WIDTH * (high - low)[1] / (high - low)[0]), dpi=RESOLUTION)
        plot = figure.add_axes((0, 0, 1, 1), xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        plot.set_axis_off()
        plot.add_collection(polygons(triangles(found, axes, [k])), autolim=False)
        memory = io.BytesIO()
        figure.savefig(memory, format="png")
        pictures.append(Image.open(memory).convert("RGB").quantize(COLOURS))
    pictures[0].save(
        HERE / "octopus.gif", save_all=True, append_images=pictures[1:], duration=PACE, loop=0, optimize=True
    )


if __name__ == "__main__":
    main()
