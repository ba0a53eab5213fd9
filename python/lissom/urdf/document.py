"""XML with the position of every element and attribute."""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass, field
from xml.parsers import expat

from .imported import Left
from .problems import LONGEST_KEY, UrdfError, UrdfProblem, short

#: Number of characters shown on either side of a problem.
_LINE_AROUND = 80

#: Supported content is at most four elements deep (robot/link/inertial/mass); unknown deeper content is
#: listed.
_DEEPEST = 5

#: Python's codecs for names of hosts and for its own literals: no file has these encodings.
_NOT_OF_FILES = ("idna", "punycode", "unicode-escape", "raw-unicode-escape", "undefined")

_ATTRIBUTE = re.compile(rb"""\s+([^\s=]+)\s*=\s*(?:"([^"]*)"|'([^']*)')""")
_ENCODING = re.compile(rb"""<\?xml[^>]*?\sencoding\s*=\s*["']([A-Za-z][\w.-]*)["']""")

RUN_XACRO = "expected plain URDF; run xacro first: xacro robot.urdf.xacro > robot.urdf"


@dataclass(slots=True)
class Element:
    """An element with its position: line and column from 1, and its first byte in the text."""

    tag: str
    attributes: dict[str, str]
    path: str
    what: str
    line: int
    column: int
    start: int
    children: list[Element] = field(default_factory=list)
    text: tuple[int, int] | None = None
    #: Line and column of the name and of the value of every attribute, once they were needed.
    places: dict[str, tuple[tuple[int, int], tuple[int, int]]] | None = None


class Refused(Exception):
    """Ends the reading of a file; the problem is already recorded."""


class Document:
    """The elements of a text, and its problems."""

    def __init__(self, file: str, data: bytes) -> None:
        self.file = file
        self.problems: list[UrdfProblem] = []
        self.left: list[Left] = []
        self.root: Element | None = None
        self.lines: list[str] = []
        self._stack: list[Element | None] = []
        self._xacro_prefixes = {"xacro"}
        self._xacro: list[tuple[int, int, str]] = []
        try:
            # Line ends as required by XML, so that lines agree with those of editors.
            self.data = self._decoded(data).replace(b"\r\n", b"\n").replace(b"\r", b"\n")
            self.lines = self.data.decode("utf-8").split("\n")
            self._parse()
        except Refused:
            raise UrdfError(self.problems) from None

    def _decoded(self, data: bytes) -> bytes:
        """The text in UTF-8."""
        encoding = "utf-8"
        marks = (
            (codecs.BOM_UTF8, "utf-8-sig"),
            (codecs.BOM_UTF32_LE, "utf-32"),
            (codecs.BOM_UTF32_BE, "utf-32"),
            (codecs.BOM_UTF16_LE, "utf-16"),
            (codecs.BOM_UTF16_BE, "utf-16"),
            (b"<\0?\0", "utf-16-le"),
            (b"\0<\0?", "utf-16-be"),
        )
        found = next((name for mark, name in marks if data.startswith(mark)), None)
        if found is not None:
            encoding = found
        elif declared := _ENCODING.match(data):
            name = declared[1].decode("ascii").lower()
            # A text that was read byte by byte cannot have such an encoding, whatever it declares.
            encoding = "utf-8" if name.startswith(("utf-16", "utf-32", "utf16", "ucs-2", "ucs-4")) else name
        try:
            if codecs.lookup(encoding).name in _NOT_OF_FILES:
                raise LookupError(encoding)
            return data.decode(encoding).encode("utf-8")
        except UnicodeDecodeError as error:
            before = data[: error.start].decode(encoding, "replace")
            line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
            self.note(line, column, "", f"not text in {encoding.upper()}: {error.reason}", "")
        except (LookupError, UnicodeError):
            self.note(
                1, 1, "", f'got the encoding "{encoding}"', "expected one that Python knows, such as UTF-8"
            )
        raise Refused

    def _parse(self) -> None:
        parser = expat.ParserCreate("utf-8")
        parser.ordered_attributes = True
        parser.StartElementHandler = self._started
        parser.EndElementHandler = self._ended
        parser.CharacterDataHandler = self._characters
        parser.ProcessingInstructionHandler = self._instruction
        parser.StartDoctypeDeclHandler = self._doctype
        self._parser = parser
        try:
            parser.Parse(self.data, True)
        except expat.ExpatError as error:
            wrong = f"not well-formed XML: {expat.ErrorString(error.code)}"
            self.note(error.lineno, error.offset + 1, "", wrong, "")
            raise Refused from None
        finally:
            # Break the reference cycle between the parser and this object.
            del self._parser
        if self._xacro:
            line, column, what = self._xacro[0]
            more = (
                f" and {len(self._xacro) - 1} more of xacro" if len(self._xacro) > 1 else ", which is xacro"
            )
            self.note(line, column, "", f"got {short(what, LONGEST_KEY)}{more}", RUN_XACRO)
            raise Refused

    def _place(self) -> tuple[int, int]:
        return self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber + 1

    def _started(self, tag: str, listed: list[str]) -> None:
        attributes = dict(zip(listed[::2], listed[1::2], strict=True))
        line, column = self._place()
        for name, value in attributes.items():
            if name.startswith("xmlns:") and value.rstrip("/").endswith("/xacro"):
                self._xacro_prefixes.add(name.removeprefix("xmlns:"))
        depth = len(self._stack)
        for name in (tag, *attributes):
            if ":" in name and name.split(":")[0] in self._xacro_prefixes:
                self._xacro.append((line, column, f"<{tag}>" if name == tag else f"the attribute {name}"))
        if depth >= _DEEPEST:
            self._stack.append(None)
            return
        above = self._stack[-1] if depth else None
        # Shortened, because every child repeats them.
        shown = short(tag, LONGEST_KEY)
        path, what = (f"{above.path}/{shown}", f"{above.what}/{shown}") if above else (shown, shown)
        if above and "name" in attributes:
            path += f"[{short(attributes['name'], LONGEST_KEY)}]"
        element = Element(tag, attributes, path, what, line, column, self._parser.CurrentByteIndex)
        if above:
            above.children.append(element)
        else:
            self.root = element
        self._stack.append(element)

    def _ended(self, tag: str) -> None:
        self._stack.pop()

    def _characters(self, text: str) -> None:
        element = self._stack[-1]
        if element is None or element.text is not None or not text.strip():
            return
        line, column = self._place()
        element.text = line, column + len(text) - len(text.lstrip())

    def _instruction(self, target: str, data: str) -> None:
        path = f"<?{target}?>"
        self.left.append(Left(*self._place(), path, path, "a processing instruction for other programs"))

    def _doctype(self, name: str, system: str | None, public: str | None, internal: int) -> None:
        # The parser has read its name and identifiers.
        start = self.data.rfind(b"<!DOCTYPE", 0, self._parser.CurrentByteIndex + len(b"<!DOCTYPE"))
        line = self.data.count(b"\n", 0, start) + 1
        column = len(self.data[self.data.rfind(b"\n", 0, start) + 1 : start].decode("utf-8")) + 1
        if system or public or internal:
            right = "expected none: URDF needs no entities, and none are expanded or opened here"
            self.note(line, column, "", "got a document type with declarations (DOCTYPE)", right)
            raise Refused
        self.left.append(
            Left(line, column, "<!DOCTYPE>", "<!DOCTYPE>", "a document type says nothing about the robot")
        )

    def note(self, line: int, column: int, key: str, wrong: str, right: str) -> None:
        """Record a problem."""
        text = self.lines[line - 1] if line <= len(self.lines) else ""
        first = max(0, column - 1 - _LINE_AROUND)
        number, shown = str(line), text[first : column - 1 + _LINE_AROUND]
        snippet = ""
        # Nothing is shown of a file that is no robot: a scene may name any file of the user.
        if shown.strip() and self.root is not None and self.root.tag == "robot":
            shown = re.sub(r"[\x00-\x1f\x7f]", " ", shown)
            marked = re.match(r"<?[^\s\"'/<>]+|.?", text[column - 1 : column - 1 + _LINE_AROUND])
            mark = " " * (column - 1 - first) + "^" * max(1, len(marked[0]) if marked else 1)
            margin = " " * len(number)
            snippet = f"{margin} |\n{number} | {shown}\n{margin} | {mark}"
        self.problems.append(UrdfProblem(self.file, line, column, key, wrong, right, snippet))

    def place_of(self, element: Element, attribute: str | None, *, is_value: bool) -> tuple[int, int]:
        """Line and column of an element, or of the name or the value of one of its attributes."""
        if attribute is None or attribute not in element.attributes:
            return element.line, element.column
        if element.places is None:
            element.places = self._places(element)
        name, value = element.places.get(attribute, 2 * ((element.line, element.column),))
        return value if is_value else name

    def _places(self, element: Element) -> dict[str, tuple[tuple[int, int], tuple[int, int]]]:
        """Line and column of the name and of the value of every attribute, in one pass over the element."""
        places = {}
        at = element.start + 1 + len(element.tag.encode("utf-8"))
        line, column, seen = element.line, element.column, element.start
        while found := _ATTRIBUTE.match(self.data, at):
            value = found.start(2) if found[2] is not None else found.start(3)
            of_both = []
            for to in (found.start(1), value):
                between = self.data[seen:to].decode("utf-8")
                newlines = between.count("\n")
                column = len(between) - between.rfind("\n") if newlines else column + len(between)
                line, seen = line + newlines, to
                of_both.append((line, column))
            places[found[1].decode("utf-8")] = (of_both[0], of_both[1])
            at = found.end()
        return places
