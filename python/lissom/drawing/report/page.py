"""Self-contained HTML pages with text, tables, curves and 3-D views."""

from __future__ import annotations

import html
import json
import re
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256

from ..._lissom import __version__
from . import modules, plots, theme
from .numerals import typeset
from .packing import pack
from .scene import Scene


@dataclass(frozen=True)
class Figure:
    """Curves with a caption."""

    figure: plots.Figure
    caption: str = ""


@dataclass(frozen=True)
class Player:
    """An animated 3-D view with a caption."""

    scene: Scene
    #: Name of its clock, shared with curves over the same time.
    clock: str
    #: Short title of the view.
    title: str
    caption: str = ""


@dataclass(frozen=True)
class Table:
    """A table; cells are text, numbers are right-aligned when the column's name is in ``numeric``."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    numeric: frozenset[str] = frozenset()
    caption: str = ""


@dataclass(frozen=True)
class Cell:
    """A cell of a map: its kind, its text and its tooltip."""

    kind: str
    text: str
    details: str


@dataclass(frozen=True)
class Cells:
    """A map of cells in the colours of their kinds."""

    #: Titles of rows and columns.
    corner: str
    rows: Sequence[str]
    columns: Sequence[str]
    #: Cells by row; None for an empty cell.
    cells: Sequence[Sequence[Cell | None]]
    #: Colours by kind.
    colours: Mapping[str, str]
    caption: str = ""


@dataclass(frozen=True)
class Lesson:
    """A highlighted sentence."""

    text: str


@dataclass(frozen=True)
class Source:
    """Preformatted text, initially collapsed."""

    title: str
    text: str


#: Lets the browser enforce that the page loads nothing, sends nothing, and runs only the player's script,
#: which is known by its hash.
CONTENT_POLICY = (
    "default-src 'none'; script-src {scripts}; style-src 'unsafe-inline'; img-src data: blob:; "
    "base-uri 'none'; form-action 'none'"
)

#: Shown by browsers without scripts.
NO_SCRIPTS = "<noscript><p>Views and curves need JavaScript; tables and text do not.</p></noscript>"


@dataclass(frozen=True)
class Choice:
    """Alternative parts, of which the reader selects one."""

    #: Title of the selection.
    what: str
    #: Options by name.
    options: Sequence[tuple[str, Sequence[Part]]]


Part = str | Figure | Player | Table | Cells | Lesson | Source | Choice


@dataclass(frozen=True)
class Section:
    """A card of the page."""

    title: str
    parts: Sequence[Part]


@dataclass(frozen=True)
class Page:
    """The content of a page, from top to bottom."""

    title: str
    lead: str
    sections: Sequence[Section]
    #: Warnings about the results below.
    advice: Sequence[str] = ()
    #: Short facts below the title: (value, description).
    tiles: Sequence[tuple[str, str]] = ()
    #: Outcome, and whether it is a success.
    outcome: tuple[str, bool] | None = None
    #: Whether to add links to the sections.
    contents: bool = False


def render(page: Page) -> str:
    """Render the page as one HTML text, about 110 kB of which are the player."""
    drawn = _drawn([part for section in page.sections for part in section.parts])
    numbers = {id(part): i for i, part in enumerate(drawn)}
    script = modules.script("page") if drawn else ""
    policy = CONTENT_POLICY.format(scripts=_hash(script) if drawn else "'none'")
    return "\n".join(
        [
            "<!doctype html>",
            '<html lang="en"><head><meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{policy}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{html.escape(page.title)}</title>",
            f"<style>\n{modules.asset('page.css')}</style>",
            "</head>",
            "<body><main>",
            _header(page),
            *([NO_SCRIPTS] if drawn else []),
            *(_section(section, i, numbers) for i, section in enumerate(page.sections)),
            f"<footer>Made by lissom {__version__}. This file needs nothing but a browser.</footer>",
            "</main>",
            *(_data(part, numbers) for part in drawn),
            *([f'<script type="module">{script}</script>'] if drawn else []),
            "</body></html>\n",
        ]
    )


def _words(text: str) -> str:
    """Text as markup, with numbers as in print."""
    return html.escape(typeset(text))


def _hash(script: str) -> str:
    """A script as a source of a content policy."""
    return f"'sha256-{b64encode(sha256(script.encode()).digest()).decode()}'"


def _drawn(parts: Sequence[Part]) -> list[Figure | Player]:
    """All parts drawn by scripts, in order."""
    found: list[Figure | Player] = []
    for part in parts:
        match part:
            case Figure() | Player():
                found.append(part)
            case Choice(_, options):
                found += [inner for _, shown in options for inner in _drawn(shown)]
    return found


def _header(page: Page) -> str:
    lines = [f"<header><h1>{_words(page.title)}</h1>", f'<p class="lead">{_words(page.lead)}</p>']
    if page.outcome is not None:
        text, good = page.outcome
        lines.append(f'<p class="outcome {"good" if good else "bad"}">{_words(text)}</p>')
    lines += [f'<p class="lesson">{_words(sentence)}</p>' for sentence in page.advice]
    if page.tiles:
        tiles = [f"<b>{_words(value)}</b><span>{_words(what)}</span>" for value, what in page.tiles]
        lines.append(f'<div class="tiles">{"".join(f"<div class=tile>{tile}</div>" for tile in tiles)}</div>')
    if page.contents:
        links = [f'<a href="#section-{i}">{_words(s.title)}</a>' for i, s in enumerate(page.sections)]
        lines.append(f"<nav>{''.join(links)}</nav>")
    return "\n".join([*lines, "</header>"])


def _section(section: Section, number: int, figures: dict[int, int]) -> str:
    parts = "\n".join(_part(part, figures) for part in section.parts)
    return f'<section id="section-{number}"><h2>{_words(section.title)}</h2>\n{parts}\n</section>'


def _part(part: Part, figures: dict[int, int]) -> str:
    match part:
        case str():
            return f"<p>{_words(part)}</p>"
        case Lesson(text):
            return f'<p class="lesson">{_words(text)}</p>'
        case Source(title, text):
            shown = f'<pre tabindex="0">{html.escape(text)}</pre>'
            return f"<details><summary>{_words(title)}</summary>{shown}</details>"
        case Figure(figure, caption):
            height = figure.height * len(figure.rows)
            place = f'style="min-height:{height}px" data-source="figure-{figures[id(part)]}"'
            return f'<div class="figure" {place}></div>{_caption(caption)}'
        case Player(_, clock, title, caption):
            names = f'data-clock="{html.escape(clock)}" aria-label="{_words(title)}"'
            place = f'data-source="figure-{figures[id(part)]}"'
            return f'<div class="player" role="group" {names} {place}></div>{_caption(caption)}'
        case Table():
            return _table(part)
        case Cells():
            return _cells(part)
        case Choice():
            return _choice(part, figures)


def _choice(choice: Choice, figures: dict[int, int]) -> str:
    names = "".join(f"<option>{_words(name)}</option>" for name, _ in choice.options)
    what = _words(choice.what)
    shown = "\n".join(
        f'<div class="option"{" hidden" if i else ""}>\n'
        + "\n".join(_part(part, figures) for part in parts)
        + "</div>"
        for i, (_, parts) in enumerate(choice.options)
    )
    # Some browsers restore the selection when a page is reloaded.
    select = f'<select autocomplete="off">{names}</select>'
    return f'<div class="choice"><label>{what} {select}</label>\n{shown}</div>'


def _data(part: Figure | Player, figures: dict[int, int]) -> str:
    document = plots.document(part.figure) if isinstance(part, Figure) else part.scene.document()
    content = json.dumps(pack(document), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    # "</" and "<!--" would end a script element, or hide its end.
    escaped = content.replace("<", "\\u003c")
    return f'<script type="application/json" id="figure-{figures[id(part)]}">{escaped}</script>'


def _cells(cells: Cells) -> str:
    kinds = "".join(
        f'<li><i style="background:{colour}"></i>{_words(kind)}</li>'
        for kind, colour in cells.colours.items()
    )
    names = "".join(f'<th scope="col">{_words(name)}</th>' for name in cells.columns)
    rows = []
    for name, row in zip(cells.rows, cells.cells, strict=True):
        shown = "".join(_cell(cell, cells.colours) for cell in row)
        rows.append(f'<tr><th scope="row">{_words(name)}</th>{shown}</tr>')
    corner = f'<th scope="col">{_breakable(_words(cells.corner))}</th>'
    head = f"<thead><tr>{corner}{names}</tr></thead>"
    table = f'<table class="cells">{head}<tbody>{"".join(rows)}</tbody></table>'
    shown = f'<div class="scroll" tabindex="0">{table}</div>'
    return f'<ul class="kinds">{kinds}</ul>{shown}{_caption(cells.caption)}'


def _cell(cell: Cell | None, colours: Mapping[str, str]) -> str:
    if cell is None:
        return "<td></td>"
    title = f'title="{_words(cell.details)}"'
    colour = colours[cell.kind]
    style = f'style="background:{colour};color:{theme.ink_on(colour)}"'
    return f"<td {style} {title}>{_words(cell.text)}</td>"


def _table(table: Table) -> str:
    numeric = [column in table.numeric for column in table.columns]

    def cells(tag: str, row: Sequence[str]) -> str:
        return "".join(
            f"<{tag}{' class=number' if number else ''}>{_breakable(_words(cell))}</{tag}>"
            for cell, number in zip(row, numeric, strict=True)
        )

    head = f"<thead><tr>{cells('th', table.columns)}</tr></thead>" if any(table.columns) else ""
    rows = "".join(f"<tr>{cells('td', row)}</tr>" for row in table.rows)
    shown = f'<div class="scroll" tabindex="0"><table>{head}<tbody>{rows}</tbody></table></div>'
    return shown + _caption(table.caption)


def _breakable(text: str) -> str:
    """Paths of parameters may break where their names do, on narrow screens."""
    return re.sub(r"([A-Za-z\]][._])(?=[A-Za-z\[])", r"\1<wbr>", text)


def _caption(text: str) -> str:
    return f'<p class="caption">{_words(text)}</p>' if text else ""
