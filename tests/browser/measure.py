"""Sizes of reports, and the time until their first view responds: ``python measure.py REPORT...``."""

import os
import sys
from pathlib import Path
from statistics import median

from playwright.sync_api import sync_playwright

from conftest import ARGUMENTS, PATIENCE

LOADS = int(os.environ.get("LOADS", "3"))

#: Records when the first view, of lissom or plotly, is drawn and the page is idle.
WATCH = """
const look = () => {
  if (!document.querySelector('.player[data-state=ready], .js-plotly-plot .plot-container')) return;
  observer.disconnect();
  requestIdleCallback(() => { window.interactive ??= performance.now(); });
};
const observer = new MutationObserver(look);
observer.observe(document, { childList: true, subtree: true, attributes: true });
"""

THERE = "() => window.interactive"


def main(paths):
    with sync_playwright() as playwright:
        program = os.environ.get("LISSOM_CHROMIUM")
        for path in map(Path, paths):
            times = []
            for _ in range(LOADS):
                # A new browser for each report: one that has drawn before has initialised its graphics.
                browser = playwright.chromium.launch(executable_path=program, args=ARGUMENTS)
                page = browser.new_page(viewport={"width": 1100, "height": 900})
                page.add_init_script(WATCH)
                page.goto(path.resolve().as_uri(), timeout=PATIENCE)
                times.append(page.wait_for_function(THERE, timeout=PATIENCE).json_value())
                browser.close()
            print(f"{path}: {path.stat().st_size / 1e6:.2f} MB, {median(times) / 1e3:.2f} s", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
