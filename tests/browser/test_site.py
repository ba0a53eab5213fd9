"""The site in a browser, checked with axe. `make test-browser` builds the site first."""

from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe

SITE = Path(__file__).parents[2] / "results" / "site"

#: One page of each kind.
PAGES = {
    "landing": "index.html",
    "first steps": "start.html",
    "how-to": "how-to/no-convergence.html",
    "reference": "api/models.html",
    "gallery": "gallery.html",
    "notebook": "notebooks/1-first-motion.html",
    "formulas": "theory.html",
    "tables": "benchmarks.html",
}


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("kind", PAGES)
def test_axe_finds_nothing_serious(kind, scheme, browser):
    page = browser.new_page(color_scheme=scheme)
    asked, errors = [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto((SITE / PAGES[kind]).as_uri(), wait_until="load")
    found = Axe().run(page).response["violations"]
    page.close()
    serious = [
        (rule["id"], node["html"][:200], node["failureSummary"])
        for rule in found
        if rule["impact"] in ("serious", "critical")
        for node in rule["nodes"]
    ]
    assert serious == []
    assert errors == []
    assert [url for url in asked if not url.startswith(("file:", "data:"))] == []
