"""The site in a browser, checked with axe. `make test-browser` builds the site first."""

from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe

from conftest import PATIENCE

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


def test_the_gallery_opens_reports_in_place(browser):
    page = browser.new_page(color_scheme="dark")
    page.set_default_timeout(PATIENCE)
    page.goto((SITE / "gallery.html").as_uri())
    links = page.locator("a.scene-report")
    count = links.count()
    assert count == len(list(SITE.glob("reports/*.html"))) > 10
    page.locator('a.scene-report[href="reports/hoop.html"]').click()
    frame = page.frame_locator("iframe.scene-report")
    frame.get_by_role("heading", name="Motion").wait_for()
    assert links.count() == count - 1
    page.close()


@pytest.mark.parametrize("moves", ["pointer", "focus", "phone", "reduced"])
def test_cards_play_films(moves, browser, tmp_path):
    """Under the pointer and with the focus; on phones in sight; never for who wants less motion."""
    page = card_page(browser, tmp_path, moves)
    picture = page.locator("img")
    assert picture.get_attribute("src").endswith("finger.png") or moves == "phone"
    if moves == "focus":
        page.locator("a").focus()
    elif moves != "phone":
        page.mouse.move(100, 100)
    if moves == "reduced":
        page.wait_for_timeout(500)
        assert picture.get_attribute("src").endswith("finger.png")
    else:
        page.wait_for_function("document.querySelector('img').src.endsWith('/films/finger.webp')")
        page.mouse.move(700, 500)
        page.evaluate("document.activeElement.blur(); scrollTo(0, 2000)")
        page.wait_for_function("document.querySelector('img').src.endsWith('finger.png')")
    page.close()


def card_page(browser, folder, moves):
    """A page with one card of the gallery."""
    docs = Path(__file__).parents[2] / "docs"
    picture, script = ((docs / name).as_uri() for name in ("pictures/finger.png", "static/gallery.js"))
    (folder / "page.html").write_text(
        f'<!doctype html><script defer src="{script}"></script><body style="height: 4000px">'
        f'<div class="scene-card" style="width: 300px"><a href="#x"><img src="{picture}" width="300">'
    )
    is_phone = moves == "phone"
    page = browser.new_page(
        is_mobile=is_phone,
        has_touch=is_phone,
        reduced_motion="reduce" if moves == "reduced" else "no-preference",
    )
    page.set_default_timeout(PATIENCE)
    page.goto((folder / "page.html").as_uri())
    return page


def test_formulas_have_their_font(browser):
    page = browser.new_page()
    page.goto((SITE / "theory.html").as_uri())
    page.evaluate("document.fonts.ready")
    assert page.evaluate("[...document.fonts].map(font => font.family + ' ' + font.status)") == [
        "Lissom Math loaded"
    ]
    page.close()
