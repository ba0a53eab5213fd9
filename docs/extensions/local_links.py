"""Looks for links of the built site that lead nowhere: `local_links.py results/site`."""

import sys
from functools import lru_cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """Where a page leads, and the places in it that can be led to."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.targets: list[str] = []
        self.places: set[str] = set()
        self.feed(path.read_text())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("href", "src") and value:
                self.targets.append(value)
            elif name in ("id", "name") and value:
                self.places.add(value)


page = lru_cache(maxsize=None)(Page)


def broken(site: Path) -> list[str]:
    """One line for each link that leads nowhere."""
    found = []
    for path in sorted(site.rglob("*.html")):
        for target in page(path).targets:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            goal = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not goal.is_file():
                found.append(f"{path.relative_to(site)}: {target}")
            elif (
                parts.fragment and goal.suffix == ".html" and unquote(parts.fragment) not in page(goal).places
            ):
                found.append(f"{path.relative_to(site)}: {target}: no such place")
    return found


if __name__ == "__main__":
    problems = broken(Path(sys.argv[1]).resolve())
    print("\n".join(problems) or "All links within the site lead somewhere.")
    sys.exit(bool(problems))
