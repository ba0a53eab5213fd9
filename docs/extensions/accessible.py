"""What the theme leaves out for screen readers and keyboards: levels of headings, focus for what scrolls."""

import re
from pathlib import Path

from sphinx.application import Sphinx

# Captions of the navigation; code, tables and formulas that may be wider than the page.
MENDED = [
    (re.compile(r'(<p class="caption" role="heading")>'), r'\1 aria-level="2">'),
    (re.compile(r"<pre(?![^>]*tabindex)"), r'<pre tabindex="0"'),
    (re.compile(r'<div class="table-wrapper(?![^>]*tabindex)'), r'<div tabindex="0" class="table-wrapper'),
    (re.compile(r'<div class="math"'), r'<div tabindex="0" class="math"'),
]


def mend(app: Sphinx, problem: Exception | None) -> None:
    """Adds to every page what is missing; pages that have it stay as they are."""
    if problem is not None or app.builder.format != "html":
        return
    for path in Path(app.outdir).rglob("*.html"):
        text = path.read_text()
        mended = text
        for pattern, replacement in MENDED:
            mended = pattern.sub(replacement, mended)
        if mended != text:
            path.write_text(mended)


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("build-finished", mend)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
