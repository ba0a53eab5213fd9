"""Links, joints and bodies from the elements of a URDF file."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite, sqrt

import numpy as np

from .._lissom import (
    Body,
    Box,
    Capsule,
    ConvexMesh,
    Free,
    Joint,
    Link,
    Loop,
    LoopEnd,
    Mimic,
    Planar,
    Prismatic,
    Revolute,
    Sphere,
    Spherical,
    Weld,
)
from .document import RUN_XACRO, Document, Element
from .imported import Imported, Left
from .inertia import mended, quaternion, rotated, rotation
from .problems import MOST_PROBLEMS, UrdfError, counted
from .reasons import (
    MENDED,
    NAMESPACE,
    NO_AXIS,
    NO_FORCES,
    NO_LIMIT,
    NO_LIMITS,
    NO_LOOPS_HERE,
    NO_MESH,
    NO_MIMIC,
    NO_ROOM,
    NO_STOPS,
    ON_REQUEST,
    REASONS,
    TEXT,
    nearest,
    unknown,
)

#: No suggestions are searched among more words than this.
_MOST_GUESSES = 300

#: Quaternions are often rounded; the norm may differ from one by this much, as for a `Link`.
_QUATERNION_TOLERANCE = 1e-3

_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_NOT_ONE_COORDINATE = ("fixed", "floating", "planar")

#: Joints that close a loop, and those of them that have an axis.
_LOOP_TYPES = ("revolute", "continuous", "prismatic", "planar", "ball", "fixed")
_WITHOUT_AXIS = ("ball", "fixed")

#: Attributes of <geometry> that are read, by shape.
_SHAPES = {
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
}

#: Sides of the prism that stands for a cylinder.
_SIDES = 24

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_REFUSED = re.compile(r"(\w+)[^:]*: (got .*?), (expected .*)")

#: First elements of other descriptions of robots: SDFormat, MJCF, COLLADA.
_OTHER_FORMATS = ("sdf", "mujoco", "COLLADA")


@dataclass(slots=True)
class _JointRead:
    """A joint of the file, as far as it could be read."""

    element: Element
    name: str
    parent: str | None
    child: str | None
    parts: dict[str, Element]
    position: tuple[float, ...]
    orientation: tuple[float, ...]
    joint: Joint


@dataclass(slots=True)
class _MimicRead:
    """A coupling of the file: the coordinate of `joint` follows that of `of`."""

    element: Element
    joint: str
    of: str
    multiplier: float
    offset: float


@dataclass(slots=True)
class _LoopRead:
    """A loop of the file, as far as it could be read: its ends with their links, and its joint."""

    element: Element
    name: str
    ends: list[tuple[Element, LoopEnd]]
    kind: Revolute | Prismatic | Planar | Spherical | Weld


Shape = Box | Sphere | Capsule | ConvexMesh


class Reader:
    """Reads the elements of a document; `problems` and `left` are the document's."""

    def __init__(
        self,
        file: str,
        data: bytes,
        limit_stiffness: float | None,
        mend_inertia: bool,
        collisions: bool = False,
        loops: bool = False,
    ) -> None:
        self.document = Document(file, data)
        self.limit_stiffness = limit_stiffness
        self.mend_inertia = mend_inertia
        self.collisions = collisions
        self.has_loops = loops
        self.shapes: list[Shape] = []
        self.loops: list[_LoopRead] = []
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
            loops=tuple(_loop(each) for each in self.loops),
            shapes=tuple(self.shapes),
        )

    # Problems, and content that is not imported

    def _guess(self, word: str, words: Iterable[str]) -> str | None:
        """The probable intention, if it can be found quickly."""
        words = list(words)
        if len(words) > _MOST_GUESSES or len(self.document.problems) > MOST_PROBLEMS:
            return None
        return nearest(word, words)

    def _problem(self, element: Element, attribute: str | None, wrong: str, right: str) -> None:
        line, column = self.document.place_of(element, attribute, is_value=True)
        key = element.path if attribute is None else f"{element.path}@{attribute}"
        self.document.note(line, column, key, wrong, right)

    def _leave(self, element: Element, reason: str, attribute: str | None = None) -> None:
        line, column = self.document.place_of(element, attribute, is_value=False)
        name = "" if attribute is None else f"@{attribute}"
        left = Left(line, column, element.path + name, element.what + name, reason)
        self.document.left.append(left)

    def _refused(
        self, error: ValueError, element: Element, places: dict[str, tuple[Element | None, str | None]]
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
            self._leave(element, reason, name)
        found: dict[str, Element] = {}
        for child in element.children:
            if child.tag in many:
                continue
            if child.tag not in once:
                reason = reasons.get(child.tag) or unknown("element", child.tag, (*once, *many))
                self._leave(child, reason)
            elif child.tag in found:
                wrong = f"got a second <{child.tag}>; the first one is in line {found[child.tag].line}"
                self._problem(child, None, wrong, "expected one at most")
            else:
                found[child.tag] = child
        if element.text is not None:
            path, what = f"{element.path}/text()", f"{element.what}/text()"
            self.document.left.append(Left(*element.text, path, what, TEXT))
        return found

    def _text(self, element: Element, attribute: str, expected: str) -> str | None:
        value = element.attributes.get(attribute)
        if value and not _is_xacro(value):
            return value
        if value:
            self._problem(element, attribute, f'got "{value}"', RUN_XACRO)
            return None
        wrong = f"got no attribute {attribute}" if value is None else 'got ""'
        self._problem(element, attribute, wrong, f"expected {expected}")
        return None

    def _numbers(
        self, element: Element | None, attribute: str, default: Sequence[float] | None, count: int = 3
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
            expected = RUN_XACRO
        if len(numbers) == len(words) and all(map(isfinite, numbers)):
            wrong = f'got {counted(len(numbers), "number")}: "{value}"'
        else:
            wrong = f'got "{value}"'
        self._problem(element, attribute, wrong, expected)
        return None

    def _number(self, element: Element | None, attribute: str, default: float | None) -> float | None:
        values = self._numbers(element, attribute, None if default is None else (default,), 1)
        return None if values is None else values[0]

    def _pose(
        self, origin: Element | None, beside: Sequence[str] = ()
    ) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Position and quaternion (w, x, y, z) beside other attributes; the identity if invalid."""
        nowhere, upright = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
        if origin is None:
            return nowhere, upright
        self._open(origin, ("xyz", "rpy", "quat_xyzw", *beside))
        position = self._numbers(origin, "xyz", nowhere) or nowhere
        if "quat_xyzw" not in origin.attributes:
            angles = self._numbers(origin, "rpy", nowhere) or nowhere
            return position, upright if not any(angles) else quaternion(*angles)
        if "rpy" in origin.attributes:
            self._problem(origin, "rpy", "got rpy beside quat_xyzw", "expected one of them")
        x, y, z, w = self._numbers(origin, "quat_xyzw", None, 4) or (0.0, 0.0, 0.0, 1.0)
        norm = sqrt(w * w + x * x + y * y + z * z)
        if not abs(norm - 1) <= _QUATERNION_TOLERANCE:
            right = "expected a quaternion x y z w of norm 1"
            self._problem(origin, "quat_xyzw", f"got a quaternion of norm {norm:.6g}", right)
            return position, upright
        return position, (w / norm, x / norm, y / norm, z / norm)

    def _body(self, inertial: Element) -> Body | None:
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
            possible = mended(tensor)
            if possible is not tensor and inertia_at is not None:
                self._leave(inertia_at, MENDED)
            tensor = possible
        try:
            # As in the file, so that messages contain its numbers.
            body = Body(mass, centre=centre, inertia=tensor)
            if turn != (1.0, 0.0, 0.0, 0.0):
                body = Body(mass, centre=centre, inertia=rotated(tensor, turn))
        except ValueError as error:
            self._refused(error, inertial, {"mass": (mass_at, "value"), "inertia": (inertia_at, None)})
            return None
        return body

    def _link(self, element: Element) -> Body | None:
        parts = self._open(element, ("name",), ("inertial",), ("collision",))
        for collision in [child for child in element.children if child.tag == "collision"]:
            if self.collisions:
                self._collision(collision, element.attributes.get("name", ""))
            else:
                self._leave(collision, ON_REQUEST if self.has_loops else REASONS["link"]["collision"])
        return self._body(parts["inertial"]) if "inertial" in parts else None

    def _collision(self, element: Element, link: str) -> None:
        """A shape for contact on a link, or an entry for what is none."""
        parts = self._open(element, ("name",), ("origin", "geometry"))
        position, orientation = self._pose(parts.get("origin"))
        geometry = parts.get("geometry")
        if geometry is None:
            self._problem(element, None, "got no <geometry>", "expected <geometry> with a shape")
            return
        found = self._open(geometry, (), tuple(_SHAPES), ("mesh",))
        if len(geometry.children) != 1:
            number = len(geometry.children) or "no"
            self._problem(geometry, None, f"got {number} shapes", "expected one")
            return
        for child in geometry.children:
            if child.tag == "mesh":
                self._leave(child, NO_MESH)
        for tag, shape in found.items():
            self._open(shape, _SHAPES[tag])
            sizes = [self._numbers(shape, name, None, 3 if name == "size" else 1) for name in _SHAPES[tag]]
            if None in sizes:
                continue
            given = [number for size in sizes for number in size or ()]
            if min(given) > 0.0:
                self.shapes.append(_shape(tag, given, position, orientation, link))
            else:
                shown = ", ".join(f"{number:g}" for number in given)
                self._problem(shape, None, f"got the sizes {shown}", "expected positive ones")

    def _loop_joint(self, element: Element) -> None:
        """A joint that closes a loop."""
        parts = self._open(element, ("name", "type"), ("link1", "link2", "axis"))
        name = self._text(element, "name", "a name") or ""
        kind = element.attributes.get("type", "revolute")
        if kind not in _LOOP_TYPES:
            guess = self._guess(kind, _LOOP_TYPES)
            right = f"did you mean {guess}?" if guess else f"expected one of {', '.join(_LOOP_TYPES)}"
            self._problem(element, "type", f'got "{kind}"', right)
        ends = []
        for tag in ("link1", "link2"):
            if tag not in parts:
                self._problem(element, None, f"got no <{tag}>", f'expected <{tag} link="..."/>')
                continue
            position, orientation = self._pose(parts[tag], ("link",))
            link = self._text(parts[tag], "link", "the name of a link")
            if link is not None:
                end = LoopEnd(link, position=position, orientation=orientation)
                ends.append((parts[tag], end))
        axis = parts.get("axis")
        if kind in _WITHOUT_AXIS:
            if axis is not None:
                self._leave(axis, NO_AXIS)
            self.loops.append(_LoopRead(element, name, ends, Spherical() if kind == "ball" else Weld()))
            return
        along = self._axis(axis)
        try:
            joint = (
                Prismatic(along)
                if kind == "prismatic"
                else Planar(along)
                if kind == "planar"
                else Revolute(along)
            )
            self.loops.append(_LoopRead(element, name, ends, joint))
        except ValueError as error:
            self._refused(error, element, {"axis": (axis, "xyz"), "normal": (axis, "xyz")})

    def _close(self, links: Iterable[str]) -> None:
        """Check the links of loops, and their names."""
        known = list(links)
        first: dict[str, Element] = {}
        for loop in self.loops:
            if loop.name and self._is_new(loop.element, loop.name, first.get(loop.name)):
                first[loop.name] = loop.element
            for element, end in loop.ends:
                if end.link not in known:
                    guess = self._guess(end.link or "", known)
                    right = (
                        f'did you mean "{guess}"?' if guess else "expected the name of a link of this file"
                    )
                    wrong = f'got "{end.link}", which is no link of this file'
                    self._problem(element, "link", wrong, right)
            if len(loop.ends) == 2 and loop.ends[0][1].link == loop.ends[1][1].link:
                wrong = f'got "{loop.ends[1][1].link}" at both ends'
                self._problem(loop.ends[1][0], "link", wrong, "expected two links")

    def _limits(self, joint: Element, limit: Element | None, kind: str | None) -> tuple[float, float] | None:
        """The limits that become stops; lists the others."""
        has_limits = kind in ("revolute", "prismatic")
        if limit is None:
            if has_limits:
                self._leave(joint, NO_LIMIT, "type")
            return None
        if not has_limits:
            self._leave(limit, NO_LIMITS)
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
        reason = NO_STOPS if self.limit_stiffness is None else NO_ROOM
        given = [name for name in ("lower", "upper") if name in limit.attributes]
        # In URDF, missing limits are zero.
        for name in given or (None,):
            self._leave(limit, reason, name)
        return None

    def _one_coordinate(self, element: Element, parts: dict[str, Element], kind: str | None) -> Joint:
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
            places: dict[str, tuple[Element | None, str | None]] = {
                "axis": (parts.get("axis"), "xyz"),
                "damping": (dynamics, "damping"),
                "friction": (dynamics, "friction"),
                "limits": (parts.get("limit"), None),
            }
            self._refused(error, element, places)
            return Weld()

    def _axis(self, element: Element | None) -> tuple[float, ...]:
        default = (1.0, 0.0, 0.0)
        if element is not None:
            self._open(element, ("xyz",))
        return self._numbers(element, "xyz", default) or default

    def _kind(self, element: Element, kind: str | None, parts: dict[str, Element]) -> Joint:
        if kind not in ("fixed", "floating", "planar"):
            # For an unknown type, at least the numbers are checked.
            return self._one_coordinate(element, parts, kind)
        self._limits(element, parts.get("limit"), kind)
        if "dynamics" in parts:
            self._leave(parts["dynamics"], NO_FORCES)
        axis = parts.get("axis")
        if kind == "planar":
            normal = self._axis(axis)
            try:
                return Planar(normal)
            except ValueError as error:
                self._refused(error, element, {"normal": (axis, "xyz")})
        elif axis is not None:
            self._leave(axis, NO_AXIS)
        return Free() if kind == "floating" else Weld()

    def _joint(self, element: Element) -> _JointRead:
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
            self._leave(parts["mimic"], NO_MIMIC)
        elif "mimic" in parts:
            self._mimic(parts["mimic"], name)
        return _JointRead(
            element, name or "", ends["parent"], ends["child"], parts, position, orientation, joint
        )

    def _mimic(self, element: Element, joint: str | None) -> None:
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

    def _robot(self, root: Element, floating: bool) -> tuple[tuple[Link, ...], dict[str, _JointRead]]:
        self._open(root, ("name",), (), ("link", "joint", "loop_joint"))
        links: dict[str, tuple[Element, Body | None]] = {}
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
            elif element.tag == "loop_joint":
                if self.has_loops:
                    self._loop_joint(element)
                else:
                    self._leave(element, NO_LOOPS_HERE)
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
        self._close(links)
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

    def _is_new(self, element: Element, name: str, other: Element | None) -> bool:
        if other is None:
            return True
        wrong = f'got "{name}", which the {element.tag} in line {other.line} has'
        self._problem(element, "name", wrong, "expected a new name")
        return False

    def _edges(
        self, links: Mapping[str, tuple[Element, Body | None]], joints: Iterable[_JointRead]
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
        links: Mapping[str, tuple[Element, Body | None]],
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


def _loop(read: _LoopRead) -> Loop:
    (_, a), (_, b) = read.ends
    return Loop(a, b, read.kind, name=read.name)


def _shape(
    tag: str,
    sizes: Sequence[float],
    position: Sequence[float],
    orientation: Sequence[float],
    link: str,
) -> Shape:
    """A shape on a link; those with an axis have it along z, as in URDF."""
    if tag == "box":
        return Box(position, 0.5 * np.array(sizes), orientation, link=link)
    if tag == "sphere":
        return Sphere(position, sizes[0], link=link)
    radius, length = sizes
    turn, middle = rotation(orientation), np.asarray(position, float)
    if tag == "capsule":
        half = 0.5 * length * turn[:, 2]
        return Capsule(middle - half, middle + half, radius, link=link)
    # Regular polygon with the area of the circle.
    angle = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    outer = radius * np.sqrt(2.0 * np.pi / (_SIDES * np.sin(2.0 * np.pi / _SIDES)))
    ring = np.stack([outer * np.cos(angle), outer * np.sin(angle), np.zeros(_SIDES)], axis=-1)
    half = np.array([0.0, 0.0, 0.5 * length])
    corners = np.concatenate([ring - half, ring + half])
    k = np.arange(_SIDES)
    after = (k + 1) % _SIDES
    walls = [(k, after, after + _SIDES), (k, after + _SIDES, k + _SIDES)]
    fan = np.arange(1, _SIDES - 1)
    ends = [(0 * fan, fan + 1, fan), (0 * fan + _SIDES, fan + _SIDES, fan + 1 + _SIDES)]
    faces = np.concatenate([np.stack(each, axis=-1) for each in (*walls, *ends)])
    return ConvexMesh(corners @ turn.T + middle, faces, link=link)


def _is_xacro(value: str) -> bool:
    return "${" in value or "$(" in value
