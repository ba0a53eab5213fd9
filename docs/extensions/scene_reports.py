"""Reports of the scenes in `scenes/`, which the gallery opens: `reports/NAME.html` in the site."""

import warnings
from pathlib import Path

from sphinx.application import Sphinx

SCENES = Path(__file__).parents[2] / "scenes"


def write(app: Sphinx, problem: Exception | None) -> None:
    """Runs the scenes whose report is missing, or older than the scene or lissom."""
    if problem is not None or app.builder.format != "html":
        return
    import lissom
    from lissom.urdf import UrdfWarning

    folder = Path(app.outdir) / "reports"
    folder.mkdir(exist_ok=True)
    package = Path(lissom.__file__).parent
    changed = max(path.stat().st_mtime for path in package.rglob("*") if path.suffix in (".py", ".so", ".js"))
    for path in sorted(SCENES.glob("*.toml")):
        report = folder / f"{path.stem}.html"
        if not report.exists() or report.stat().st_mtime < max(changed, path.stat().st_mtime):
            with warnings.catch_warnings():
                # What is not read of a URDF file is no matter of the gallery.
                warnings.simplefilter("ignore", UrdfWarning)
                scene = lissom.Scene.load(path)
            scene.run().report(report, title=scene.name)


def setup(app: Sphinx) -> dict[str, bool]:
    # After what is done to pages of the site.
    app.connect("build-finished", write, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
