"""A picture and the run time of every scene in `scenes/`, and from these the page `docs/gallery.md`.

Run it by `make pictures`.
"""

import json
import time
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from PIL import Image, ImageChops

import lissom
from lissom.model.views import View, view

HERE = Path(__file__).parent
ROOT = HERE.parents[1]

#: Instants of a motion in one picture; the last one is drawn in full.
INSTANTS = 5

#: Runs of which the fastest one counts.
REPETITIONS = 5

#: Widest picture, pixels.
WIDEST = 640

#: Colours of a picture.
COLOURS = 128

#: White pixels around a picture.
MARGIN = 12

#: From where scenes are looked at: elevation and azimuth in degrees; what is not named, from the front.
CAMERAS = {
    "flying_rod": (20, -75),
    "tentacle": (12, -60),
    "hand": (25, -50),
    "octopus": (10, -60),
    "arm": (15, -60),
    "finger": (35, -70),
    "six_wires": (12, -60),
    "falling_rod": (18, -65),
}
FRONT = (5, -90)


def timed(scene: lissom.Scene) -> tuple[lissom.MotionResult, float]:
    """The motion, and the seconds of the fastest run."""
    times = []
    for _ in range(REPETITIONS):
        start = time.perf_counter()
        motion = scene.run()
        times.append(time.perf_counter() - start)
    return motion, min(times)


def direction(camera: tuple[float, float]) -> np.ndarray:
    """From a model to the viewer, for an elevation and an azimuth in degrees."""
    elevation, azimuth = np.radians(camera)
    across = np.cos(elevation)
    return np.array([across * np.cos(azimuth), across * np.sin(azimuth), np.sin(elevation)])


def picture_in_the_plane(what: View, motion: lissom.MotionResult) -> plt.Figure:
    figure, axes = plt.subplots(figsize=(6, 4), dpi=100)
    axes.plot(*what.sketch.mass(motion.q[:2000]).T, color="#9db4c0", linewidth=0.5)
    axes.plot(*what.sketch.line(motion.q[0]).T, color="#33415c")
    axes.plot(*what.sketch.mass(motion.q[:1]).T, "o", color="#21918c", markersize=14)
    axes.set_aspect("equal")
    axes.set_axis_off()
    return figure


def crop(path: Path) -> None:
    with Image.open(path) as file:
        picture = file.convert("RGB")
    left, top, right, bottom = ImageChops.difference(
        picture, Image.new("RGB", picture.size, "white")
    ).getbbox()
    whole = Image.new("RGB", (right - left + 2 * MARGIN, bottom - top + 2 * MARGIN), "white")
    whole.paste(picture.crop((left, top, right, bottom)), (MARGIN, MARGIN))
    whole.thumbnail((WIDEST, WIDEST), Image.Resampling.LANCZOS)
    whole.quantize(COLOURS).save(path, optimize=True)


def first_comment(text: str) -> str:
    """What a scene says of itself, in its first lines."""
    lines = []
    for line in text.splitlines():
        if line.startswith("#:"):
            continue
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# "))
    return " ".join(lines)


def in_words(seconds: float) -> str:
    return f"{1e3 * seconds:.3g} ms" if seconds < 1.0 else f"{seconds:.3g} s"


def alternative(facts: dict) -> str:
    """What a picture shows, for who does not see it."""
    return f"{facts['title']}, at {INSTANTS} instants of its motion"


def card(name: str, facts: dict) -> str:
    """A picture that leads to the entry of a scene."""
    return f""":::{{grid-item-card}} {name.replace("_", " ").replace("-", " ").capitalize()}
:link: gallery.html#{name.replace("_", "-")}
:link-type: url
:img-top: pictures/{name}.png
:img-alt: {alternative(facts)}
:class-card: scene-card
:::
"""


def entry(name: str, facts: dict) -> str:
    return f"""## {name}

{facts["comment"]}

```{{raw}} html
<a class="scene-report" href="reports/{name}.html" title="Interactive report of {name}">
<img src="_images/{name}.png" alt="{alternative(facts)}: open the interactive report" loading="lazy"></a>
```

{facts["title"]}, {facts["coordinates"]} coordinates. {facts["simulated"]:g} s of motion \
by `{facts["method"]}` take {in_words(facts["seconds"])}.

    lissom run scenes/{name}.toml -o results/{name}

:::{{dropdown}} The text of `scenes/{name}.toml`
```{{literalinclude}} ../scenes/{name}.toml
:language: toml
```
:::
"""


def page(entries: dict) -> str:
    """The gallery: cards, and an entry for each scene."""
    return "\n".join(
        [
            "# Gallery\n",
            "The scenes in `scenes/`, with what they show at "
            f"{INSTANTS} instants (the last one in full), their text and their run time in Python: "
            f"the fastest of {REPETITIONS} runs on one core. Click on the picture of an entry: its report "
            "opens in its place: it plays the motion, and you turn it. Cards play a small film under the "
            "pointer, on phones while they are in sight.\n",
            "::::{grid} 2 3 4 4\n:gutter: 2\n",
            *(card(name, facts) for name, facts in entries.items()),
            "::::\n",
            *(entry(name, facts) for name, facts in entries.items()),
        ]
    )


def main() -> None:
    entries = {}
    for path in sorted((ROOT / "scenes").glob("*.toml")):
        scene = lissom.Scene.load(path)
        motion, seconds = timed(scene)
        what = view(scene.model)
        name = path.stem
        picture = HERE / f"{name}.png"
        if what.is_spatial:
            times = np.linspace(motion.t[0], motion.t[-1], INSTANTS)
            motion.picture(picture, times=times, view=direction(CAMERAS.get(name, FRONT)))
        else:
            figure = picture_in_the_plane(what, motion)
            figure.savefig(picture)
            plt.close(figure)
        crop(picture)
        entries[name] = {
            "comment": first_comment(scene.text),
            "title": what.title,
            "coordinates": scene.model.n,
            "simulated": float(motion.t[-1] - motion.t[0]),
            "method": scene.simulation.method,
            "seconds": seconds,
        }
    (HERE / "gallery.json").write_text(json.dumps(entries, indent=1) + "\n")
    (ROOT / "docs" / "gallery.md").write_text(page(entries))


if __name__ == "__main__":
    main()
