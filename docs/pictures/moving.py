"""The moving picture of the README and the landing page: an octopus that swims. Run it by `make pictures`.

The page names `octopus.gif` alone: any other command may write that file.
"""

import io
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from PIL import Image

import lissom
from drawing import draw, frame
from lissom.model.views import view

HERE = Path(__file__).parent
SCENE = HERE.parents[1] / "scenes" / "octopus.toml"

#: Pictures, and milliseconds for which each is shown.
PICTURES, PACE = 48, 80
COLOURS = 48


def main() -> None:
    scene = lissom.Scene.load(SCENE)
    motion = scene.run()
    what = view(scene.model)
    pictures = []
    for i in np.linspace(0, len(motion.t) - 1, PICTURES).astype(int):
        figure = plt.figure(figsize=(5.6, 3.4), dpi=90)
        axes = figure.add_axes((-0.25, -0.35, 1.5, 1.7), projection="3d", computed_zorder=False)
        frame(axes, what, motion, 12, -60)
        draw(axes, what, motion.q[i], float(motion.t[i]))
        memory = io.BytesIO()
        figure.savefig(memory, format="png")
        plt.close(figure)
        pictures.append(Image.open(memory).convert("RGB").quantize(COLOURS))
    pictures[0].save(
        HERE / "octopus.gif", save_all=True, append_images=pictures[1:], duration=PACE, loop=0, optimize=True
    )


if __name__ == "__main__":
    main()
