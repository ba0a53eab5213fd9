"""The site has a page for everything that is public, and its notebooks contain no outputs."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import lissom
from lissom import gym, methods, sensors, urdf
from lissom.drawing.live import server

DOCS = Path(__file__).parents[3] / "docs"
DIRECTIVE = re.compile(r"^\.\. auto(?:class|function|exception):: (\w+)$", re.M)
# Called by scenes and `Robot.from_urdf`.
BEHIND_OTHERS = {"imported_from", "robot_from_urdf"}
NOTEBOOKS = sorted(DOCS.glob("notebooks/*.ipynb"))


def documented() -> set[str]:
    """Full names of all items in the reference."""
    found = set()
    for page in DOCS.glob("api/*.md"):
        text = page.read_text()
        for module, names in re.findall(r"currentmodule:: ([\w.]+)\n(.*?)```", text, re.S):
            found |= {f"{module}.{name}" for name in DIRECTIVE.findall(names)}
    return found


def test_every_public_name_is_in_the_reference():
    public = {f"lissom.{name}" for name in lissom.__all__ if name != "__version__"}
    public |= {f"lissom.sensors.{name}" for name in sensors.__all__}
    public |= {f"lissom.methods.{name}" for name in methods.__all__}
    public |= {f"lissom.gym.{name}" for name in gym.__all__}
    public |= {f"lissom.drawing.live.server.{name}" for name in server.__all__}
    public |= {f"lissom.urdf.{name}" for name in set(urdf.__all__) - BEHIND_OTHERS}
    assert documented() == public


def test_every_scene_is_in_the_gallery():
    text = (DOCS / "gallery.md").read_text()
    scenes = {path.stem for path in (DOCS.parent / "scenes").glob("*.toml")}
    assert set(re.findall(r"^## (.+)$", text, re.M)) == scenes
    assert set(re.findall(r'class="scene-report" href="reports/(.+?)\.html"', text)) == scenes
    assert {name.replace("-", "_") for name in re.findall(r"^:link: gallery\.html#(.+)$", text, re.M)} == {
        name.replace("-", "_") for name in scenes
    }


def test_every_scene_has_a_small_film():
    """The gallery loads them when they are played: they move, and all together are as large as one report."""
    films = {path.stem: path for path in (DOCS / "static" / "films").glob("*.webp")}
    assert films.keys() == {path.stem for path in (DOCS.parent / "scenes").glob("*.toml")}
    assert sum(path.stat().st_size for path in films.values()) < 600_000
    for name, path in films.items():
        assert path.stat().st_size < 80_000, name
        with Image.open(path) as film:
            if name == "lab-hanging":
                # It hangs still, as it has to.
                assert getattr(film, "n_frames", 1) == 1
                continue
            assert film.n_frames > 20, name
            first = np.asarray(film.convert("RGB"), float)
            film.seek(film.n_frames // 2)
            assert np.abs(np.asarray(film.convert("RGB"), float) - first).max() > 50, name


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.name)
def test_notebooks_are_committed_without_outputs(path):
    cells = json.loads(path.read_text())["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert code
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in code)
