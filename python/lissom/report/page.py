"""A self-contained HTML page: text, tables and plotly figures, nothing loaded from anywhere."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from .._lissom import __version__


@dataclass(frozen=True)
class Figure:
    """A plotly figure with a sentence below it."""

    figure: Any
    caption: str = ""


@dataclass(frozen=True)
class Table:
    """A table; cells are text, numbers are right-aligned when the column's name is in ``numeric``."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    numeric: frozenset[str] = frozenset()
    caption: str = ""


@dataclass(frozen=True)
class Lesson:
    """A sentence that stands out."""

    text: str


@dataclass(frozen=True)
class Source:
    """Text to be shown as it is, folded away at first."""

    title: str
    text: str


#: Browsers enforce that the page loads nothing and talks to nobody. Plotly compiles its shaders with eval.
CONTENT_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; "
    "style-src 'unsafe-inline'; img-src data: blob:"
)


@dataclass(frozen=True)
class Choice:
    """Parts of which the reader picks what is shown; the first one at first."""

    #: What is picked.
    what: str
    #: By their names.
    options: Sequence[tuple[str, Sequence[Part]]]


Part = str | Figure | Table | Lesson | Source | Choice


@dataclass(frozen=True)
class Section:
    """A card of the page."""

    title: str
    parts: Sequence[Part]


@dataclass(frozen=True)
class Page:
    """What a page says, from top to bottom."""

    title: str
    lead: str
    sections: Sequence[Section]
    #: Short facts under the title: (value, what it is).
    tiles: Sequence[tuple[str, str]] = ()
    #: How it went, and whether that is good.
    outcome: tuple[str, bool] | None = None
    #: Links to the sections.
    contents: bool = False


def render(page: Page) -> str:
    """The page as one HTML text, about 5 MB of which are plotly itself."""
    from plotly.offline import get_plotlyjs

    figures = _figures([part for section in page.sections for part in section.parts])
    numbers = {id(figure): i for i, figure in enumerate(figures)}
    assets = files(__package__)
    return "\n".join(
        [
            "<!doctype html>",
            '<html lang="en"><head><meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{CONTENT_POLICY}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{html.escape(page.title)}</title>",
            f"<style>\n{(assets / 'page.css').read_text(encoding='utf-8')}</style></head>",
            "<body><main>",
            _header(page),
            *(_section(section, i, numbers) for i, section in enumerate(page.sections)),
            f"<footer>Made by lissom {__version__}. This file needs nothing but a browser.</footer>",
            "</main>",
            *(_data(figure, numbers) for figure in figures),
            f"<script>{get_plotlyjs()}</script>",
            f"<script>\n{(assets / 'page.js').read_text(encoding='utf-8')}</script>",
            "</body></html>\n",
        ]
    )


def _figures(parts: Sequence[Part]) -> list[Figure]:
    """All figures, in their order."""
    found: list[Figure] = []
    for part in parts:
        match part:
            case Figure():
                found.append(part)
            case Choice(_, options):
                found += [figure for _, shown in options for figure in _figures(shown)]
    return found


def _header(page: Page) -> str:
    lines = [f"<header><h1>{html.escape(page.title)}</h1>", f'<p class="lead">{html.escape(page.lead)}</p>']
    if page.outcome is not None:
        text, good = page.outcome
        lines.append(f'<p class="outcome {"good" if good else "bad"}">{html.escape(text)}</p>')
    if page.tiles:
        tiles = [f"<b>{html.escape(value)}</b><span>{html.escape(what)}</span>" for value, what in page.tiles]
        lines.append(f'<div class="tiles">{"".join(f"<div class=tile>{tile}</div>" for tile in tiles)}</div>')
    if page.contents:
        links = [f'<a href="#section-{i}">{html.escape(s.title)}</a>' for i, s in enumerate(page.sections)]
        lines.append(f"<nav>{''.join(links)}</nav>")
    return "\n".join([*lines, "</header>"])


def _section(section: Section, number: int, figures: dict[int, int]) -> str:
    parts = "\n".join(_part(part, figures) for part in section.parts)
    return f'<section id="section-{number}"><h2>{html.escape(section.title)}</h2>\n{parts}\n</section>'


def _part(part: Part, figures: dict[int, int]) -> str:
    match part:
        case str():
            return f"<p>{html.escape(part)}</p>"
        case Lesson(text):
            return f'<p class="lesson">{html.escape(text)}</p>'
        case Source(title, text):
            return f"<details><summary>{html.escape(title)}</summary><pre>{html.escape(text)}</pre></details>"
        case Figure(figure, caption):
            place = f'style="height:{figure.layout.height}px" data-source="figure-{figures[id(part)]}"'
            return f'<div class="figure" {place}></div>{_caption(caption)}'
        case Table():
            return _table(part)
        case Choice():
            return _choice(part, figures)


def _choice(choice: Choice, figures: dict[int, int]) -> str:
    names = "".join(f"<option>{html.escape(name)}</option>" for name, _ in choice.options)
    what = html.escape(choice.what)
    shown = "\n".join(
        f'<div class="option"{" hidden" if i else ""}>\n'
        + "\n".join(_part(part, figures) for part in parts)
        + "</div>"
        for i, (_, parts) in enumerate(choice.options)
    )
    # Browsers keep what was picked when a page is loaded anew, unless they are told not to.
    select = f'<select autocomplete="off">{names}</select>'
    return f'<div class="choice"><label>{what} {select}</label>\n{shown}</div>'


def _data(figure: Figure, figures: dict[int, int]) -> str:
    # A script element ends at "</", wherever that stands.
    json = figure.figure.to_json().replace("</", "<\\/")
    return f'<script type="application/json" id="figure-{figures[id(figure)]}">{json}</script>'


def _table(table: Table) -> str:
    numeric = [column in table.numeric for column in table.columns]

    def cells(tag: str, row: Sequence[str]) -> str:
        return "".join(
            f"<{tag}{' class=number' if number else ''}>{html.escape(cell)}</{tag}>"
            for cell, number in zip(row, numeric, strict=True)
        )

    head = f"<thead><tr>{cells('th', table.columns)}</tr></thead>" if any(table.columns) else ""
    rows = "".join(f"<tr>{cells('td', row)}</tr>" for row in table.rows)
    return f'<div class="scroll"><table>{head}<tbody>{rows}</tbody></table></div>{_caption(table.caption)}'


def _caption(text: str) -> str:
    return f'<p class="caption">{html.escape(text)}</p>' if text else ""
