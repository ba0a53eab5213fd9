"""Import of rigid links and joints from URDF, the XML robot format of ROS.

Content that lissom does not support is never dropped silently: every element, attribute, text, processing
instruction and document type declaration that does not become part of a link, joint or body is listed with
its location and a reason. Children of a listed element belong to its entry. Comments are not listed.
"""

from __future__ import annotations

import codecs
import os
import re
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import lru_cache
from math import cos, isfinite, sin, sqrt
from typing import Any
from xml.parsers import expat

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import disk
from ._lissom import Body, Free, Joint, Link, Mimic, Planar, Prismatic, Revolute, Robot, Weld
from .plain import path_of

#: Maximum number of problems in a message, and maximum lengths of a key and of its sentence.
_MOST_PROBLEMS = 100
_LONGEST_KEY = 200
_LONGEST_SENTENCE = 1000

#: No suggestions are searched among more words than this.
_MOST_GUESSES = 300

#: Number of characters shown on either side of a problem.
_LINE_AROUND = 80

#: Number of lines named for entries of the same kind.
_LINES_NAMED = 3

#: Supported content is at most four elements deep (robot/link/inertial/mass); unknown deeper content is
#: listed.
_DEEPEST = 5

#: Quaternions are often rounded; the norm may differ from one by this much, as for a `Link`.
_QUATERNION_TOLERANCE = 1e-3

#: Tolerance for rounding errors of a tensor, relative to its largest entry, as for `Body`.
_INERTIA_TOLERANCE = 1e-9

_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_NOT_ONE_COORDINATE = ("fixed", "floating", "planar")

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_ATTRIBUTE = re.compile(rb"""\s+([^\s=]+)\s*=\s*(?:"([^"]*)"|'([^']*)')""")
_REFUSED = re.compile(r"(\w+)[^:]*: (got .*?), (expected .*)")
_ENCODING = re.compile(rb"""<\?xml[^>]*?\sencoding\s*=\s*["']([A-Za-z][\w.-]*)["']""")

#: Python's codecs for names of hosts and for its own literals: no file has these encodings.
_NOT_OF_FILES = ("idna", "punycode", "unicode-escape", "raw-unicode-escape", "undefined")

_NO_MIMIC = "this joint has not one coordinate that could follow another one"
_NO_STOPS = "stops are stiff springs, and URDF has no stiffness for them: give limit_stiffness"
_NO_ROOM = (
    "lower and upper are the same: stops need room between them; write type='fixed' for a joint that stays"
)
_NO_LIMIT = (
    "URDF asks for a <limit> of a joint of this type, and there is none: the joint moves without stops"
)
_NO_LIMITS = "a joint of this type has no stops in lissom"
_MENDED = "no body has such moments of inertia: the nearest ones that a body can have are taken"
_NO_FORCES = "joints of this type have no damping and friction in lissom"
_NO_AXIS = "a joint of this type has no axis"
_EFFORT = "a limit of the drive: robots have none until a `Motor` with `limits` is given to them"
_DRIVE = "a limit of the drive; a `Motor` limits torque and force only"
_PICTURE = "only for pictures"
_CONTACT = "shapes for contact are not read"
_NAMESPACE = "a namespace declaration says nothing about the robot"
_TEXT = "text means nothing here: URDF says all in elements and attributes"

#: First elements of other descriptions of robots: SDFormat, MJCF, COLLADA.
_OTHER_FORMATS = ("sdf", "mujoco", "COLLADA")

_RUN_XACRO = "expected plain URDF; run xacro first: xacro robot.urdf.xacro > robot.urdf"

#: Entries that affect the robot's motion come first in a summary.
_FIRST = (_NO_MIMIC, _MENDED, _NO_STOPS, _NO_ROOM, _NO_LIMIT, _NO_LIMITS, _NO_FORCES)

_OTHER_SIMULATORS = "settings of another simulator"
_CONTROL = "drives and controllers are not part of a robot here"
_REASONS: Mapping[str, Mapping[str, str]] = {
    "robot": {
        "@version": "the file is read in the same way whatever its version",
        "material": _PICTURE,
        "transmission": "gears and drives are not read; `armature` of a joint is the inertia of its rotor",
        "gazebo": _OTHER_SIMULATORS,
        "mujoco": _OTHER_SIMULATORS,
        "drake": _OTHER_SIMULATORS,
        "sensor": "a sensor does not move the robot",
        "ros2_control": _CONTROL,
        "loop_joint": "closed loops are not read: the robot stays open there",
    },
    "link": {
        "visual": _PICTURE,
        "collision": _CONTACT,
        "contact": _CONTACT,
        "sensor": "a sensor does not move the robot",
        "gazebo": _OTHER_SIMULATORS,
    },
    "joint": {
        "safety_controller": _CONTROL,
        "calibration": _CONTROL,
        "gazebo": _OTHER_SIMULATORS,
    },
    "limit": {"@effort": _EFFORT, "@velocity": _DRIVE, "@acceleration": _DRIVE, "@jerk": _DRIVE},
}


@dataclass(frozen=True)
class Left:
    """An item of a file that was not imported.

    Parameters
    ----------
    line, column : int
        Location in the file, both from 1; the column counts characters.
    path : str
        Path in the tree: ``robot/link[hand]/visual``, or for an attribute
        ``robot/joint[wrist]/limit@effort``.
    what : str
        The path without names: ``robot/link/visual``, ``robot/joint/limit@effort``.
    reason : str
        The reason.
    """

    line: int
    column: int
    path: str
    what: str
    reason: str

    def __str__(self) -> str:
        return f"{self.line}:{self.column}: {_short(self.path, _LONGEST_KEY)}: {self.reason}"


@dataclass(frozen=True)
class Imported:
    """Content imported from a URDF file. Its string is a summary.

    Parameters
    ----------
    links : tuple of Link
        Links for a `Robot`: parents before their children, depth first, children in the order of the file.
    not_taken : tuple of Left
        Everything else in the file, in its order.
    joints : dict
        Child link of every joint, because coordinates are named after links.
    name : str
        Name of the robot; empty if the file has none.
    file : str
        The file as given.
    """

    links: tuple[Link, ...]
    not_taken: tuple[Left, ...]
    joints: dict[str, str] = field(default_factory=dict)
    name: str = ""
    file: str = ""

    def __str__(self) -> str:
        size = f'robot "{_short(self.name, _LONGEST_KEY)}", {_count(len(self.links), "link")}'
        head = f"{self.file}: {size}, {_count(len(self.joints), 'joint')}"
        if not self.not_taken:
            return f"{head}; everything was taken over"
        groups: dict[tuple[str, str], list[Left]] = {}
        for left in self.not_taken:
            groups.setdefault((left.what, left.reason), []).append(left)
        rank = {reason: i for i, reason in enumerate(_FIRST)}
        ordered = sorted(groups.items(), key=lambda group: rank.get(group[0][1], len(rank)))
        lines = [f"{head}; not taken over:"]
        for (what, reason), entries in ordered:
            lines.append(f"  {_short(what, _LONGEST_KEY)} ({_places(entries)}): {reason}")
        return "\n".join(lines)


@dataclass(frozen=True)
class UrdfProblem:
    """A problem in a file.

    Parameters
    ----------
    file : str
        The file as given.
    line, column : int
        Location, both from 1; the column counts characters.
    key : str
        Element or attribute, such as ``robot/link[hand]/inertial/mass@value``; empty for malformed XML.
    wrong : str
        What was found.
    right : str
        What was expected; may be empty for malformed XML.
    snippet : str
        The line of the file with the location marked.
    """

    file: str
    line: int
    column: int
    key: str
    wrong: str
    right: str
    snippet: str = ""

    def __str__(self) -> str:
        parts = [f"{self.file}:{self.line}:{self.column}"]
        if self.key:
            parts.append(_short(self.key, _LONGEST_KEY))
        sentence = _short(self.wrong, _LONGEST_SENTENCE)
        if self.right:
            sentence += "; " + _short(self.right, _LONGEST_SENTENCE)
        return ": ".join([*parts, sentence])


class UrdfError(ValueError):
    """An invalid URDF file.

    Attributes
    ----------
    problems : list of UrdfProblem
        All problems, in the order of the file.
    """

    problems: list[UrdfProblem]

    def __init__(self, problems: Iterable[UrdfProblem]) -> None:
        self.problems = list(problems)
        super().__init__(self.problems)

    def __str__(self) -> str:
        shown = [f"{problem}\n{problem.snippet}".rstrip() for problem in self.problems[:_MOST_PROBLEMS]]
        rest = len(self.problems) - len(shown)
        return "\n".join([*shown, f"and {_count(rest, 'more problem')}"] if rest else shown)


class UrdfWarning(UserWarning):
    """Some content of a URDF file was not imported."""


def read_urdf(
    path: str | os.PathLike[str],
    *,
    floating: bool = False,
    limit_stiffness: float | None = None,
    mend_inertia: bool = False,
) -> Imported:
    """Read the links and joints of a URDF file.

    Every link of the file becomes a `Link` of the same name with the joint to its parent. A link without
    <inertial> is a frame. ``revolute`` and ``continuous`` become `Revolute`, ``prismatic`` `Prismatic`,
    ``fixed`` `Weld`, ``floating`` `Free`, ``planar`` `Planar`; damping and friction of <dynamics> and <mimic>
    are imported. Referenced files, such as meshes and packages, are not opened.

    Parameters
    ----------
    path : path-like
        The URDF file. Run xacro on a xacro file first.
    floating : bool
        Whether the root link moves freely; by default it is welded to the world.
    limit_stiffness : float, optional
        Stiffness of the stops at joint limits, newton metres per radian for revolute joints and newtons per
        metre for prismatic ones. URDF does not specify it; without it, limits are not imported but listed.
    mend_inertia : bool
        Whether to replace impossible moments of inertia (one larger than the sum of the other two, or a
        negative one) by the nearest possible ones, and list them. By default they are an error.

    Returns
    -------
    Imported
        The links; `not_taken` lists everything that was not imported.

    Raises
    ------
    UrdfError
        If the file is invalid; the message lists all problems with line and column.
    OSError
        If the file cannot be read.
    ValueError, TypeError
        If `limit_stiffness` is not positive.

    Examples
    --------
    >>> import lissom.urdf
    >>> arm = lissom.urdf.read_urdf("arm.urdf")  # doctest: +SKIP
    >>> print(arm)  # doctest: +SKIP
    >>> robot = lissom.Robot(arm.links)  # doctest: +SKIP
    """
    _check_stiffness(limit_stiffness)
    file = path_of(path)
    return imported_from(
        str(file),
        disk.read(file, disk.LARGEST_DESCRIPTION),
        floating=floating,
        limit_stiffness=limit_stiffness,
        mend_inertia=mend_inertia,
    )


def imported_from(
    file: str,
    content: bytes,
    *,
    floating: bool = False,
    limit_stiffness: float | None = None,
    mend_inertia: bool = False,
) -> Imported:
    """Read links and joints from the content of a URDF file.

    Parameters
    ----------
    file : str
        Name of the file in messages.
    content : bytes
        Content of the file.
    floating, limit_stiffness, mend_inertia
        As for `read_urdf`.

    Returns
    -------
    Imported

    Raises
    ------
    UrdfError, ValueError, TypeError
        As `read_urdf` does.
    """
    _check_stiffness(limit_stiffness)
    return _Reader(file, content, limit_stiffness, mend_inertia).imported(floating)


def _check_stiffness(limit_stiffness: float | None) -> None:
    if limit_stiffness is not None:
        # The joint validates the stiffness.
        Revolute((1.0, 0.0, 0.0), limits=(-1.0, 1.0), limit_stiffness=limit_stiffness)


def robot_from_urdf(
    path: str | os.PathLike[str],
    *,
    floating: bool = False,
    limit_stiffness: float | None = None,
    mend_inertia: bool = False,
    links: Iterable[Link] = (),
    gravity: ArrayLike = (0, 0, -9.81),
    **others: Any,
) -> Robot:
    """Create a robot from the links of a URDF file and additional links.

    Parameters
    ----------
    path, floating, limit_stiffness, mend_inertia
        As for `read_urdf`.
    links : iterable of Link
        Additional links, such as rods attached to links of the file.
    gravity, **others
        As for `Robot`.

    Returns
    -------
    Robot

    Warns
    -----
    UrdfWarning
        Once, with a summary of everything that was not imported; `read_urdf` returns the full list.

    Raises
    ------
    UrdfError, OSError
        As for `read_urdf`.
    ValueError, TypeError
        As for `Robot`, for example if a joint moves no mass.

    Examples
    --------
    >>> import lissom, lissom.urdf
    >>> soft = lissom.Segment(0.1, 8e-3, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 3})
    >>> finger = lissom.Link("finger", rod=[soft], parent="hand")
    >>> robot = lissom.urdf.robot_from_urdf("arm.urdf", links=[finger])  # doctest: +SKIP
    """
    imported = read_urdf(path, floating=floating, limit_stiffness=limit_stiffness, mend_inertia=mend_inertia)
    if imported.not_taken:
        warnings.warn(str(imported), UrdfWarning, stacklevel=2)
    return Robot([*imported.links, *links], gravity=gravity, **others)


# Words


def _count(number: int, what: str) -> str:
    return f"{number} {what}" + ("" if number == 1 else "s")


def _short(text: str, most: int) -> str:
    """The text shortened to one line."""
    text = re.sub(r"[\x00-\x1f\x7f]", lambda found: repr(found[0])[1:-1], text)
    return text if len(text) <= most else text[:most] + "..."


def _places(entries: Sequence[Left]) -> str:
    """``line 3``, ``12; lines 3, 9, 17 and 9 more``."""
    if len(entries) == 1:
        return f"line {entries[0].line}"
    named = ", ".join(str(left.line) for left in entries[:_LINES_NAMED])
    rest = len(entries) - _LINES_NAMED
    return f"{len(entries)}; lines {named}" + (f" and {rest} more" if rest > 0 else "")


# Rotations


def _quaternion(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """Quaternion of rotations about the fixed axes x, y, z in this order: Rz(yaw) Ry(pitch) Rx(roll)."""
    (cr, sr), (cp, sp), (cy, sy) = ((cos(angle / 2), sin(angle / 2)) for angle in (roll, pitch, yaw))
    return (
        cy * cp * cr + sy * sp * sr,
        cy * cp * sr - sy * sp * cr,
        cy * sp * cr + sy * cp * sr,
        sy * cp * cr - cy * sp * sr,
    )


def _rotated(tensor: NDArray[np.float64], q: Sequence[float]) -> NDArray[np.float64]:
    """R I R^T: a tensor in the rotated axes."""
    w, x, y, z = q
    R = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    turned: NDArray[np.float64] = R @ tensor @ R.T
    return (turned + turned.T) / 2


def _mended(tensor: NDArray[np.float64]) -> NDArray[np.float64]:
    """The nearest valid inertia tensor in the Frobenius norm; the same object if it is valid.

    Principal moments a <= b <= c are valid if c <= a + b; it follows that none is negative.
    """
    (a, b, c), axes = np.linalg.eigh(tensor)
    excess = (c - a - b) / 3
    if 3 * excess <= _INERTIA_TOLERANCE * np.abs(tensor).max():
        return tensor
    moments = np.array([a + excess, b + excess, c - excess])
    if moments[1] > moments[2]:
        # The moments would change their order; the nearest tensor is that of a needle, or zero.
        moments = np.array([0.0, 1.0, 1.0]) * max(0.0, (b + c) / 2)
    mended: NDArray[np.float64] = axes * moments @ axes.T
    return (mended + mended.T) / 2


# XML with positions


@dataclass(slots=True)
class _Element:
    """An element with its position: line and column from 1, and its first byte in the text."""

    tag: str
    attributes: dict[str, str]
    path: str
    what: str
    line: int
    column: int
    start: int
    children: list[_Element] = field(default_factory=list)
    text: tuple[int, int] | None = None
    #: Line and column of the name and of the value of every attribute, once they were needed.
    places: dict[str, tuple[tuple[int, int], tuple[int, int]]] | None = None


class _Refused(Exception):
    """Ends the reading of a file; the problem is already recorded."""


class _Document:
    """The elements of a text, and its problems."""

    def __init__(self, file: str, data: bytes) -> None:
        self.file = file
        self.problems: list[UrdfProblem] = []
        self.left: list[Left] = []
        self.root: _Element | None = None
        self.lines: list[str] = []
        self._stack: list[_Element | None] = []
        self._xacro_prefixes = {"xacro"}
        self._xacro: list[tuple[int, int, str]] = []
        try:
            # Line ends as required by XML, so that lines agree with those of editors.
            self.data = self._decoded(data).replace(b"\r\n", b"\n").replace(b"\r", b"\n")
            self.lines = self.data.decode("utf-8").split("\n")
            self._parse()
        except _Refused:
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
        raise _Refused

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
            raise _Refused from None
        finally:
            # Break the reference cycle between the parser and this object.
            del self._parser
        if self._xacro:
            line, column, what = self._xacro[0]
            more = (
                f" and {len(self._xacro) - 1} more of xacro" if len(self._xacro) > 1 else ", which is xacro"
            )
            self.note(line, column, "", f"got {_short(what, _LONGEST_KEY)}{more}", _RUN_XACRO)
            raise _Refused

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
        shown = _short(tag, _LONGEST_KEY)
        path, what = (f"{above.path}/{shown}", f"{above.what}/{shown}") if above else (shown, shown)
        if above and "name" in attributes:
            path += f"[{_short(attributes['name'], _LONGEST_KEY)}]"
        element = _Element(tag, attributes, path, what, line, column, self._parser.CurrentByteIndex)
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
            raise _Refused
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

    def place_of(self, element: _Element, attribute: str | None, *, is_value: bool) -> tuple[int, int]:
        """Line and column of an element, or of the name or the value of one of its attributes."""
        if attribute is None or attribute not in element.attributes:
            return element.line, element.column
        if element.places is None:
            element.places = self._places(element)
        name, value = element.places.get(attribute, 2 * ((element.line, element.column),))
        return value if is_value else name

    def _places(self, element: _Element) -> dict[str, tuple[tuple[int, int], tuple[int, int]]]:
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


# URDF


@dataclass(slots=True)
class _JointRead:
    """A joint of the file, as far as it could be read."""

    element: _Element
    name: str
    parent: str | None
    child: str | None
    parts: dict[str, _Element]
    position: tuple[float, ...]
    orientation: tuple[float, ...]
    joint: Joint


@dataclass(slots=True)
class _MimicRead:
    """A coupling of the file: the coordinate of `joint` follows that of `of`."""

    element: _Element
    joint: str
    of: str
    multiplier: float
    offset: float


class _Reader:
    """Reads the elements of a document; `problems` and `left` are the document's."""

    def __init__(self, file: str, data: bytes, limit_stiffness: float | None, mend_inertia: bool) -> None:
        self.document = _Document(file, data)
        self.limit_stiffness = limit_stiffness
        self.mend_inertia = mend_inertia
        self.mimic: list[_MimicRead] = []

    def imported(self, floating: bool) -> Imported:
        """The imported content; raises an error with all problems."""
        root = self.document.root
        assert root is not None, "a document without one is not well-formed"
        links: tuple[Link, ...] = ()
        joints: dict[str, _JointRead] = {}
        if root.tag == "robot":
            links, joints = self._robot(root, floating)
        else:
            # Of other files nothing is shown, not even the name of their first element.
            known = root.tag if root.tag in _OTHER_FORMATS else ""
            wrong = f"got the element <{known}>" if known else "got an element of another format"
            self.document.note(root.line, root.column, known, wrong, "expected <robot>: a file in URDF")
        if self.document.problems:
            raise UrdfError(
                sorted(self.document.problems, key=lambda problem: (problem.line, problem.column))
            )
        return Imported(
            links=links,
            not_taken=tuple(sorted(self.document.left, key=lambda left: (left.line, left.column))),
            joints={name: joint.child or "" for name, joint in joints.items()},
            name=root.attributes.get("name", ""),
            file=self.document.file,
        )

    # Problems, and content that is not imported

    def _guess(self, word: str, words: Iterable[str]) -> str | None:
        """The probable intention, if it can be found quickly."""
        words = list(words)
        if len(words) > _MOST_GUESSES or len(self.document.problems) > _MOST_PROBLEMS:
            return None
        return _nearest(word, words)

    def _problem(self, element: _Element, attribute: str | None, wrong: str, right: str) -> None:
        line, column = self.document.place_of(element, attribute, is_value=True)
        key = element.path if attribute is None else f"{element.path}@{attribute}"
        self.document.note(line, column, key, wrong, right)

    def _leave(self, element: _Element, reason: str, attribute: str | None = None) -> None:
        line, column = self.document.place_of(element, attribute, is_value=False)
        name = "" if attribute is None else f"@{attribute}"
        left = Left(line, column, element.path + name, element.what + name, reason)
        self.document.left.append(left)

    def _refused(
        self, error: ValueError, element: _Element, places: dict[str, tuple[_Element | None, str | None]]
    ) -> None:
        """Assign problems reported by a body or joint to the positions of its values in the file."""
        for sentence in str(error).splitlines():
            match = _REFUSED.fullmatch(sentence)
            place, wrong, right = match.groups() if match else ("", sentence, "")
            at, attribute = places.get(place, (None, None))
            if place == "inertia":
                right += " (mend_inertia=True takes the nearest)"
            self._problem(at or element, attribute if at else None, wrong, right)

    # Elements

    def _open(
        self, element: _Element, attributes: Sequence[str], once: Sequence[str] = (), many: Sequence[str] = ()
    ) -> dict[str, _Element]:
        """The supported children, each at most once; lists all others."""
        reasons = _REASONS.get(element.tag, {})
        for name in element.attributes:
            if name in attributes:
                continue
            if name == "xmlns" or name.startswith("xmlns:"):
                reason = _NAMESPACE
            else:
                reason = reasons.get("@" + name) or _unknown("attribute", name, tuple(attributes))
            self._leave(element, reason, name)
        found: dict[str, _Element] = {}
        for child in element.children:
            if child.tag in many:
                continue
            if child.tag not in once:
                reason = reasons.get(child.tag) or _unknown("element", child.tag, (*once, *many))
                self._leave(child, reason)
            elif child.tag in found:
                wrong = f"got a second <{child.tag}>; the first one is in line {found[child.tag].line}"
                self._problem(child, None, wrong, "expected one at most")
            else:
                found[child.tag] = child
        if element.text is not None:
            path, what = f"{element.path}/text()", f"{element.what}/text()"
            self.document.left.append(Left(*element.text, path, what, _TEXT))
        return found

    def _text(self, element: _Element, attribute: str, expected: str) -> str | None:
        value = element.attributes.get(attribute)
        if value and not _is_xacro(value):
            return value
        if value:
            self._problem(element, attribute, f'got "{value}"', _RUN_XACRO)
            return None
        wrong = f"got no attribute {attribute}" if value is None else 'got ""'
        self._problem(element, attribute, wrong, f"expected {expected}")
        return None

    def _numbers(
        self, element: _Element | None, attribute: str, default: Sequence[float] | None, count: int = 3
    ) -> tuple[float, ...] | None:
        """`count` finite numbers; the default if missing; None if invalid."""
        value = element.attributes.get(attribute) if element else None
        if element is None or (value is None and default is not None):
            assert default is not None, "elements that must be there are looked for before their numbers"
            return tuple(default)
        expected = "expected a finite number" if count == 1 else f"expected {count} finite numbers"
        if value is None:
            self._problem(element, attribute, f"got no attribute {attribute}", expected)
            return None
        words = value.split()
        numbers = tuple(float(word) for word in words if _NUMBER.fullmatch(word))
        if len(numbers) == len(words) == count and all(map(isfinite, numbers)):
            return numbers
        if _is_xacro(value):
            expected = _RUN_XACRO
        if len(numbers) == len(words) and all(map(isfinite, numbers)):
            wrong = f'got {_count(len(numbers), "number")}: "{value}"'
        else:
            wrong = f'got "{value}"'
        self._problem(element, attribute, wrong, expected)
        return None

    def _number(self, element: _Element | None, attribute: str, default: float | None) -> float | None:
        values = self._numbers(element, attribute, None if default is None else (default,), 1)
        return None if values is None else values[0]

    def _pose(self, origin: _Element | None) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Position and quaternion (w, x, y, z); the identity if invalid."""
        nowhere, upright = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
        if origin is None:
            return nowhere, upright
        self._open(origin, ("xyz", "rpy", "quat_xyzw"))
        position = self._numbers(origin, "xyz", nowhere) or nowhere
        if "quat_xyzw" not in origin.attributes:
            angles = self._numbers(origin, "rpy", nowhere) or nowhere
            return position, upright if not any(angles) else _quaternion(*angles)
        if "rpy" in origin.attributes:
            self._problem(origin, "rpy", "got rpy beside quat_xyzw", "expected one of them")
        x, y, z, w = self._numbers(origin, "quat_xyzw", None, 4) or (0.0, 0.0, 0.0, 1.0)
        norm = sqrt(w * w + x * x + y * y + z * z)
        if not abs(norm - 1) <= _QUATERNION_TOLERANCE:
            right = "expected a quaternion x y z w of norm 1"
            self._problem(origin, "quat_xyzw", f"got a quaternion of norm {norm:.6g}", right)
            return position, upright
        return position, (w / norm, x / norm, y / norm, z / norm)

    def _body(self, inertial: _Element) -> Body | None:
        parts = self._open(inertial, (), ("origin", "mass", "inertia"))
        centre, turn = self._pose(parts.get("origin"))
        mass_at, inertia_at = parts.get("mass"), parts.get("inertia")
        mass, entries = None, None
        if mass_at is None:
            self._problem(inertial, None, "got no <mass>", 'expected <mass value="..."/> (kilograms)')
        else:
            self._open(mass_at, ("value",))
            mass = self._number(mass_at, "value", None)
        names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        if inertia_at is None:
            right = f"expected <inertia> with {', '.join(names)} (kg m^2)"
            self._problem(inertial, None, "got no <inertia>", right)
        else:
            self._open(inertia_at, names)
            entries = [self._number(inertia_at, name, None) for name in names]
        if mass is None or entries is None or None in entries:
            return None
        xx, xy, xz, yy, yz, zz = entries
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=np.float64)
        if self.mend_inertia:
            mended = _mended(tensor)
            if mended is not tensor and inertia_at is not None:
                self._leave(inertia_at, _MENDED)
            tensor = mended
        try:
            # As in the file, so that messages contain its numbers.
            body = Body(mass, centre=centre, inertia=tensor)
            if turn != (1.0, 0.0, 0.0, 0.0):
                body = Body(mass, centre=centre, inertia=_rotated(tensor, turn))
        except ValueError as error:
            self._refused(error, inertial, {"mass": (mass_at, "value"), "inertia": (inertia_at, None)})
            return None
        return body

    def _link(self, element: _Element) -> Body | None:
        parts = self._open(element, ("name",), ("inertial",))
        return self._body(parts["inertial"]) if "inertial" in parts else None

    def _limits(
        self, joint: _Element, limit: _Element | None, kind: str | None
    ) -> tuple[float, float] | None:
        """The limits that become stops; lists the others."""
        has_limits = kind in ("revolute", "prismatic")
        if limit is None:
            if has_limits:
                self._leave(joint, _NO_LIMIT, "type")
            return None
        if not has_limits:
            self._leave(limit, _NO_LIMITS)
            return None
        self._open(limit, ("lower", "upper"))
        lower, upper = self._number(limit, "lower", 0.0), self._number(limit, "upper", 0.0)
        if lower is None or upper is None:
            return None
        if lower > upper:
            wrong = f"got lower {lower:g} above upper {upper:g}"
            self._problem(limit, None, wrong, "expected the lower limit below the upper one")
            return None
        if self.limit_stiffness is not None and lower < upper:
            return lower, upper
        reason = _NO_STOPS if self.limit_stiffness is None else _NO_ROOM
        given = [name for name in ("lower", "upper") if name in limit.attributes]
        # In URDF, missing limits are zero.
        for name in given or (None,):
            self._leave(limit, reason, name)
        return None

    def _one_coordinate(self, element: _Element, parts: dict[str, _Element], kind: str | None) -> Joint:
        """A revolute or prismatic joint."""
        axis = self._axis(parts.get("axis"))
        limits = self._limits(element, parts.get("limit"), kind)
        dynamics = parts.get("dynamics")
        if dynamics is not None:
            self._open(dynamics, ("damping", "friction"))
        damping = self._number(dynamics, "damping", 0.0)
        friction = self._number(dynamics, "friction", 0.0)
        make = Prismatic if kind == "prismatic" else Revolute
        try:
            return make(
                axis,
                damping=damping or 0.0,
                friction=friction or 0.0,
                limits=limits,
                limit_stiffness=(self.limit_stiffness or 0.0) if limits else 0.0,
            )
        except ValueError as error:
            places: dict[str, tuple[_Element | None, str | None]] = {
                "axis": (parts.get("axis"), "xyz"),
                "damping": (dynamics, "damping"),
                "friction": (dynamics, "friction"),
                "limits": (parts.get("limit"), None),
            }
            self._refused(error, element, places)
            return Weld()

    def _axis(self, element: _Element | None) -> tuple[float, ...]:
        default = (1.0, 0.0, 0.0)
        if element is not None:
            self._open(element, ("xyz",))
        return self._numbers(element, "xyz", default) or default

    def _kind(self, element: _Element, kind: str | None, parts: dict[str, _Element]) -> Joint:
        if kind not in ("fixed", "floating", "planar"):
            # For an unknown type, at least the numbers are checked.
            return self._one_coordinate(element, parts, kind)
        self._limits(element, parts.get("limit"), kind)
        if "dynamics" in parts:
            self._leave(parts["dynamics"], _NO_FORCES)
        axis = parts.get("axis")
        if kind == "planar":
            normal = self._axis(axis)
            try:
                return Planar(normal)
            except ValueError as error:
                self._refused(error, element, {"normal": (axis, "xyz")})
        elif axis is not None:
            self._leave(axis, _NO_AXIS)
        return Free() if kind == "floating" else Weld()

    def _joint(self, element: _Element) -> _JointRead:
        once = ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic")
        parts = self._open(element, ("name", "type"), once)
        name = self._text(element, "name", "a name")
        kind = self._text(element, "type", f"one of {', '.join(_TYPES)}")
        if kind is not None and kind not in _TYPES:
            guess = self._guess(kind, _TYPES)
            right = f"did you mean {guess}?" if guess else f"expected one of {', '.join(_TYPES)}"
            self._problem(element, "type", f'got "{kind}"', right)
        ends: dict[str, str | None] = {}
        for end in ("parent", "child"):
            if end in parts:
                self._open(parts[end], ("link",))
                ends[end] = self._text(parts[end], "link", "the name of a link")
            else:
                ends[end] = None
                self._problem(element, None, f"got no <{end}>", f'expected <{end} link="..."/>')
        position, orientation = self._pose(parts.get("origin"))
        joint = self._kind(element, kind, parts)
        if "mimic" in parts and kind in _NOT_ONE_COORDINATE:
            self._leave(parts["mimic"], _NO_MIMIC)
        elif "mimic" in parts:
            self._mimic(parts["mimic"], name)
        return _JointRead(
            element, name or "", ends["parent"], ends["child"], parts, position, orientation, joint
        )

    def _mimic(self, element: _Element, joint: str | None) -> None:
        self._open(element, ("joint", "multiplier", "offset"))
        of = self._text(element, "joint", "the name of a joint")
        multiplier = self._number(element, "multiplier", 1.0)
        offset = self._number(element, "offset", 0.0)
        if joint is not None and of is not None and multiplier is not None and offset is not None:
            self.mimic.append(_MimicRead(element, joint, of, multiplier, offset))

    def _couple(self, joints: dict[str, _JointRead]) -> None:
        """Couple mimicking joints; rejects invalid ones, and cycles."""
        right = "expected a revolute, continuous or prismatic joint"
        following: dict[str, _MimicRead] = {}
        for mimic in self.mimic:
            other = joints.get(mimic.of)
            kind = other.element.attributes.get("type") if other else None
            if other is None:
                guess = self._guess(mimic.of, joints)
                wrong = f'got "{mimic.of}", which is no joint of this file'
                self._problem(mimic.element, "joint", wrong, f'did you mean "{guess}"?' if guess else right)
            elif kind in _NOT_ONE_COORDINATE:
                self._problem(mimic.element, "joint", f'got "{mimic.of}", a {kind} joint', right)
            else:
                following[mimic.joint] = mimic
        seen: set[str] = set()
        for start in following:
            trail: list[str] = []
            name = start
            while name in following and name not in seen:
                seen.add(name)
                trail.append(name)
                name = following[name].of
            if name in trail:
                circle = trail[trail.index(name) :]
                closing = max((following[joint] for joint in circle), key=lambda mimic: mimic.element.start)
                wrong = f"got a circle of joints that mimic each other: {' -> '.join([*circle, name])}"
                self._problem(closing.element, "joint", wrong, "expected one that moves by itself")
        if self.document.problems:
            return
        for mimic in following.values():
            joint = joints[mimic.joint]
            link = joints[mimic.of].child or ""
            tie = Mimic(link, multiplier=mimic.multiplier, offset=mimic.offset)
            joint.joint = replace(joint.joint, mimic=tie)

    # The tree

    def _robot(self, root: _Element, floating: bool) -> tuple[tuple[Link, ...], dict[str, _JointRead]]:
        self._open(root, ("name",), (), ("link", "joint"))
        links: dict[str, tuple[_Element, Body | None]] = {}
        joints: dict[str, _JointRead] = {}
        read: list[_JointRead] = []
        for element in root.children:
            if element.tag == "link":
                name = self._text(element, "name", "a name")
                body = self._link(element)
                if name is not None and self._is_new(
                    element, name, links[name][0] if name in links else None
                ):
                    links[name] = element, body
            elif element.tag == "joint":
                joint = self._joint(element)
                read.append(joint)
                other = joints.get(joint.name)
                if joint.name and self._is_new(element, joint.name, other.element if other else None):
                    joints[joint.name] = joint
        if not any(element.tag == "link" for element in root.children):
            self._problem(root, None, "got no links", 'expected at least one: <link name="..."/>')
            return (), joints
        self._couple(joints)
        above, below = self._edges(links, read)
        order = self._walk(links, above, below)
        if self.document.problems:
            return (), joints
        made = []
        for name in order:
            body = links[name][1]
            joint_above = above.get(name)
            if joint_above is None:
                made.append(Link(name, body=body, joint=Free() if floating else Weld()))
                continue
            made.append(
                Link(
                    name,
                    body=body,
                    joint=joint_above.joint,
                    parent=joint_above.parent,
                    position=joint_above.position,
                    orientation=joint_above.orientation,
                )
            )
        return tuple(made), joints

    def _is_new(self, element: _Element, name: str, other: _Element | None) -> bool:
        if other is None:
            return True
        wrong = f'got "{name}", which the {element.tag} in line {other.line} has'
        self._problem(element, "name", wrong, "expected a new name")
        return False

    def _edges(
        self, links: Mapping[str, tuple[_Element, Body | None]], joints: Iterable[_JointRead]
    ) -> tuple[dict[str, _JointRead], dict[str, list[str]]]:
        """The joint above every link except the root, and the child links of every link."""
        above: dict[str, _JointRead] = {}
        below: dict[str, list[str]] = {name: [] for name in links}
        for joint in joints:
            known = True
            for end, name in (("parent", joint.parent), ("child", joint.child)):
                if name is None or name in links:
                    continue
                guess = self._guess(name, links)
                right = f'did you mean "{guess}"?' if guess else "expected the name of a link of this file"
                self._problem(joint.parts[end], "link", f'got "{name}", which is no link of this file', right)
                known = False
            if joint.child is None or joint.child not in links:
                continue
            if joint.child in above:
                other = above[joint.child]
                wrong = (
                    f'got "{joint.child}", which the joint "{other.name}" in line {other.element.line} '
                    "has as its child already"
                )
                self._problem(joint.parts["child"], "link", wrong, "expected a link without another parent")
                continue
            # Also if its parent is unknown, so that it is not a root.
            above[joint.child] = joint
            if known and joint.parent is not None:
                below[joint.parent].append(joint.child)
        return above, below

    def _walk(
        self,
        links: Mapping[str, tuple[_Element, Body | None]],
        above: Mapping[str, _JointRead],
        below: Mapping[str, list[str]],
    ) -> list[str]:
        """The links from the root, depth first; records additional roots and cycles of links."""
        roots = [name for name in links if name not in above]
        for name in roots[1:]:
            wrong = f'got a second root; the first one is "{roots[0]}" in line {links[roots[0]][0].line}'
            right = "expected a joint with this link as its child: all links but one have one"
            self._problem(links[name][0], None, wrong, right)
        order: list[str] = []
        waiting = roots[::-1]
        while waiting:
            name = waiting.pop()
            order.append(name)
            waiting.extend(reversed(below[name]))
        seen = set(order)
        for name in links:
            trail: list[str] = []
            at: str | None = name
            while at is not None and at in links and at not in seen:
                seen.add(at)
                trail.append(at)
                at = above[at].parent
            if at in trail:
                circle = trail[trail.index(at) :][::-1]
                self._circle(circle, above)
        return order

    def _circle(self, circle: Sequence[str], above: Mapping[str, _JointRead]) -> None:
        """Record a cycle of links, at the last of their joints in the file."""
        closing = max((above[name] for name in circle), key=lambda joint: joint.element.start)
        first = circle.index(closing.child or "")
        turned = [*circle[first:], *circle[:first], circle[first]]
        named = turned if len(turned) <= 8 else [*turned[:4], "...", *turned[-3:]]
        wrong = f"got a circle of links: {' -> '.join(named)}"
        self._problem(closing.element, None, wrong, "expected a tree: no link behind itself")


def _is_xacro(value: str) -> bool:
    return "${" in value or "$(" in value


def _nearest(word: str, words: Iterable[str], likeness: float = 0.6) -> str | None:
    if len(word) > _LONGEST_KEY:
        return None
    return next(iter(get_close_matches(word, words, 1, likeness)), None)


@lru_cache(1000)
def _unknown(what: str, name: str, known: tuple[str, ...]) -> str:
    """Reason for not importing an unknown element or attribute, with a suggestion if there is one."""
    guess = _nearest(name.lower(), known, 0.75)
    return f"an unknown {what}; did you mean {guess}?" if guess else f"an unknown {what}"
