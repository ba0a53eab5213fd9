"""Elements of a URDF file as checked values, with problems at their places."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from math import isfinite, sqrt

from .document import RUN_XACRO, Document, Element
from .imported import Left
from .inertia import quaternion
from .problems import MOST_PROBLEMS, counted
from .reasons import NAMESPACE, REASONS, TEXT, nearest, unknown

#: No suggestions are searched among more words than this.
_MOST_GUESSES = 300

#: Quaternions are often rounded; the norm may differ from one by this much, as for a `Link`.
_QUATERNION_TOLERANCE = 1e-3

#: Attributes of <geometry> that are read, by shape.
_SHAPES = {
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
}

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_REFUSED = re.compile(r"(\w+)[^:]*: (got .*?), (expected .*)")


class Elements:
    """Reads the elements of a document; problems and what is left out go to the document."""

    def __init__(self, file: str, data: bytes) -> None:
        self.document = Document(file, data)

    def guess(self, word: str, words: Iterable[str]) -> str | None:
        """The probable intention, if it can be found quickly."""
        words = list(words)
        if len(words) > _MOST_GUESSES or len(self.document.problems) > MOST_PROBLEMS:
            return None
        return nearest(word, words)

    def problem(self, element: Element, attribute: str | None, wrong: str, right: str) -> None:
        line, column = self.document.place_of(element, attribute, is_value=True)
        key = element.path if attribute is None else f"{element.path}@{attribute}"
        self.document.note(line, column, key, wrong, right)

    def leave(self, element: Element, reason: str, attribute: str | None = None) -> None:
        line, column = self.document.place_of(element, attribute, is_value=False)
        name = "" if attribute is None else f"@{attribute}"
        left = Left(line, column, element.path + name, element.what + name, reason)
        self.document.left.append(left)

    def refused(
        self, error: ValueError, element: Element, places: dict[str, tuple[Element | None, str | None]]
    ) -> None:
        """Assign problems reported by a body or joint to the positions of its values in the file."""
        for sentence in str(error).splitlines():
            match = _REFUSED.fullmatch(sentence)
            place, wrong, right = match.groups() if match else ("", sentence, "")
            at, attribute = places.get(place, (None, None))
            if place == "inertia":
                right += " (mend_inertia=True takes the nearest)"
            self.problem(at or element, attribute if at else None, wrong, right)

    # Elements

    def open(
        self, element: Element, attributes: Sequence[str], once: Sequence[str] = (), many: Sequence[str] = ()
    ) -> dict[str, Element]:
        """The supported children, each at most once; lists all others."""
        reasons = REASONS.get(element.tag, {})
        for name in element.attributes:
            if name in attributes:
                continue
            if name == "xmlns" or name.startswith("xmlns:"):
                reason = NAMESPACE
            else:
                reason = reasons.get("@" + name) or unknown("attribute", name, tuple(attributes))
            self.leave(element, reason, name)
        found: dict[str, Element] = {}
        for child in element.children:
            if child.tag in many:
                continue
            if child.tag not in once:
                reason = reasons.get(child.tag) or unknown("element", child.tag, (*once, *many))
                self.leave(child, reason)
            elif child.tag in found:
                wrong = f"got a second <{child.tag}>; the first one is in line {found[child.tag].line}"
                self.problem(child, None, wrong, "expected one at most")
            else:
                found[child.tag] = child
        if element.text is not None:
            path, what = f"{element.path}/text()", f"{element.what}/text()"
            self.document.left.append(Left(*element.text, path, what, TEXT))
        return found

    def text(self, element: Element, attribute: str, expected: str) -> str | None:
        value = element.attributes.get(attribute)
        if value and not _is_xacro(value):
            return value
        if value:
            self.problem(element, attribute, f'got "{value}"', RUN_XACRO)
            return None
        wrong = f"got no attribute {attribute}" if value is None else 'got ""'
        self.problem(element, attribute, wrong, f"expected {expected}")
        return None

    def numbers(
        self, element: Element | None, attribute: str, default: Sequence[float] | None, count: int = 3
    ) -> tuple[float, ...] | None:
        """`count` finite numbers; the default if missing; None if invalid."""
        value = element.attributes.get(attribute) if element else None
        if element is None or (value is None and default is not None):
            assert default is not None, "elements that must be there are looked for before their numbers"
            return tuple(default)
        expected = "expected a finite number" if count == 1 else f"expected {count} finite numbers"
        if value is None:
            self.problem(element, attribute, f"got no attribute {attribute}", expected)
            return None
        words = value.split()
        numbers = tuple(float(word) for word in words if _NUMBER.fullmatch(word))
        if len(numbers) == len(words) == count and all(map(isfinite, numbers)):
            return numbers
        if _is_xacro(value):
            expected = RUN_XACRO
        if len(numbers) == len(words) and all(map(isfinite, numbers)):
            wrong = f'got {counted(len(numbers), "number")}: "{value}"'
        else:
            wrong = f'got "{value}"'
        self.problem(element, attribute, wrong, expected)
        return None

    def number(self, element: Element | None, attribute: str, default: float | None) -> float | None:
        values = self.numbers(element, attribute, None if default is None else (default,), 1)
        return None if values is None else values[0]

    def pose(
        self, origin: Element | None, beside: Sequence[str] = ()
    ) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Position and quaternion (w, x, y, z) beside other attributes; the identity if invalid."""
        nowhere, upright = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
        if origin is None:
            return nowhere, upright
        self.open(origin, ("xyz", "rpy", "quat_xyzw", *beside))
        position = self.numbers(origin, "xyz", nowhere) or nowhere
        if "quat_xyzw" not in origin.attributes:
            angles = self.numbers(origin, "rpy", nowhere) or nowhere
            return position, upright if not any(angles) else quaternion(*angles)
        if "rpy" in origin.attributes:
            self.problem(origin, "rpy", "got rpy beside quat_xyzw", "expected one of them")
        x, y, z, w = self.numbers(origin, "quat_xyzw", None, 4) or (0.0, 0.0, 0.0, 1.0)
        norm = sqrt(w * w + x * x + y * y + z * z)
        if not abs(norm - 1) <= _QUATERNION_TOLERANCE:
            right = "expected a quaternion x y z w of norm 1"
            self.problem(origin, "quat_xyzw", f"got a quaternion of norm {norm:.6g}", right)
            return position, upright
        return position, (w / norm, x / norm, y / norm, z / norm)

    def geometry(
        self, element: Element, geometry: Element | None, others: tuple[str, ...]
    ) -> tuple[str | None, Element] | None:
        """The one shape of a <geometry>, with its kind; of others without one."""
        if geometry is None:
            self.problem(element, None, "got no <geometry>", "expected <geometry> with a shape")
            return None
        found = self.open(geometry, (), (*_SHAPES, *others), () if others else ("mesh",))
        if len(geometry.children) != 1:
            number = len(geometry.children) or "no"
            self.problem(geometry, None, f"got {number} shapes", "expected one")
            return None
        child = geometry.children[0]
        return (child.tag if child.tag in found else None), child

    def sizes(self, tag: str, shape: Element) -> list[float] | None:
        """The sizes of a shape; None if invalid."""
        self.open(shape, _SHAPES[tag])
        sizes = [self.numbers(shape, name, None, 3 if name == "size" else 1) for name in _SHAPES[tag]]
        if None in sizes:
            return None
        given = [number for size in sizes for number in size or ()]
        if min(given) > 0.0:
            return given
        shown = ", ".join(f"{number:g}" for number in given)
        self.problem(shape, None, f"got the sizes {shown}", "expected positive ones")
        return None


def _is_xacro(value: str) -> bool:
    return "${" in value or "$(" in value
