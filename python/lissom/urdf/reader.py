"""Links, joints and bodies from the elements of a URDF file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

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
from ..model.visuals import Visual
from .document import Element
from .elements import Elements
from .imported import Imported
from .inertia import mended, rotated, rotation
from .looks import Material, colour_of, visuals_of
from .pictures import Pictures, prism
from .problems import UrdfError
from .reasons import (
    MENDED,
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
    PICTURES_ON_REQUEST,
    REASONS,
)

_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_NOT_ONE_COORDINATE = ("fixed", "floating", "planar")

#: Joints that close a loop, and those of them that have an axis.
_LOOP_TYPES = ("revolute", "continuous", "prismatic", "planar", "ball", "fixed")
_WITHOUT_AXIS = ("ball", "fixed")


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


class Reader(Elements):
    """Reads links, joints, loops, shapes and visuals."""

    def __init__(
        self,
        file: str,
        data: bytes,
        limit_stiffness: float | None,
        mend_inertia: bool,
        collisions: bool = False,
        loops: bool = False,
        pictures: Pictures | None = None,
    ) -> None:
        super().__init__(file, data)
        self.limit_stiffness = limit_stiffness
        self.mend_inertia = mend_inertia
        self.collisions = collisions
        self.has_loops = loops
        self.pictures = pictures
        self.visuals: list[Visual] = []
        #: Colours and opacities of the robot's materials by name.
        self.materials: dict[str, Material] = {}
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
            visuals=tuple(self.visuals),
        )

    def _body(self, inertial: Element) -> Body | None:
        parts = self.open(inertial, (), ("origin", "mass", "inertia"))
        centre, turn = self.pose(parts.get("origin"))
        mass_at, inertia_at = parts.get("mass"), parts.get("inertia")
        mass, entries = None, None
        if mass_at is None:
            self.problem(inertial, None, "got no <mass>", 'expected <mass value="..."/> (kilograms)')
        else:
            self.open(mass_at, ("value",))
            mass = self.number(mass_at, "value", None)
        names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        if inertia_at is None:
            right = f"expected <inertia> with {', '.join(names)} (kg m^2)"
            self.problem(inertial, None, "got no <inertia>", right)
        else:
            self.open(inertia_at, names)
            entries = [self.number(inertia_at, name, None) for name in names]
        if mass is None or entries is None or None in entries:
            return None
        xx, xy, xz, yy, yz, zz = entries
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=np.float64)
        if self.mend_inertia:
            possible = mended(tensor)
            if possible is not tensor and inertia_at is not None:
                self.leave(inertia_at, MENDED)
            tensor = possible
        try:
            # As in the file, so that messages contain its numbers.
            body = Body(mass, centre=centre, inertia=tensor)
            if turn != (1.0, 0.0, 0.0, 0.0):
                body = Body(mass, centre=centre, inertia=rotated(tensor, turn))
        except ValueError as error:
            self.refused(error, inertial, {"mass": (mass_at, "value"), "inertia": (inertia_at, None)})
            return None
        return body

    def _link(self, element: Element) -> Body | None:
        parts = self.open(element, ("name",), ("inertial",), ("collision", "visual"))
        for visual in [child for child in element.children if child.tag == "visual"]:
            if self.pictures is not None:
                link = element.attributes.get("name", "")
                self.visuals += visuals_of(self, visual, link, self.pictures, self.materials)
            else:
                self.leave(visual, PICTURES_ON_REQUEST if self.has_loops else REASONS["link"]["visual"])
        for collision in [child for child in element.children if child.tag == "collision"]:
            if self.collisions:
                self._collision(collision, element.attributes.get("name", ""))
            else:
                self.leave(collision, ON_REQUEST if self.has_loops else REASONS["link"]["collision"])
        return self._body(parts["inertial"]) if "inertial" in parts else None

    def _collision(self, element: Element, link: str) -> None:
        """A shape for contact on a link, or an entry for what is none."""
        parts = self.open(element, ("name",), ("origin", "geometry"))
        position, orientation = self.pose(parts.get("origin"))
        found = self.geometry(element, parts.get("geometry"), ())
        if found is None:
            return
        tag, shape = found
        if tag is not None:
            sizes = self.sizes(tag, shape)
            if sizes is not None:
                self.shapes.append(_shape(tag, sizes, position, orientation, link))
        elif shape.tag == "mesh":
            self.leave(shape, NO_MESH)

    def _loop_joint(self, element: Element) -> None:
        """A joint that closes a loop."""
        parts = self.open(element, ("name", "type"), ("link1", "link2", "axis"))
        name = self.text(element, "name", "a name") or ""
        kind = element.attributes.get("type", "revolute")
        if kind not in _LOOP_TYPES:
            guess = self.guess(kind, _LOOP_TYPES)
            right = f"did you mean {guess}?" if guess else f"expected one of {', '.join(_LOOP_TYPES)}"
            self.problem(element, "type", f'got "{kind}"', right)
        ends = []
        for tag in ("link1", "link2"):
            if tag not in parts:
                self.problem(element, None, f"got no <{tag}>", f'expected <{tag} link="..."/>')
                continue
            position, orientation = self.pose(parts[tag], ("link",))
            link = self.text(parts[tag], "link", "the name of a link")
            if link is not None:
                end = LoopEnd(link, position=position, orientation=orientation)
                ends.append((parts[tag], end))
        axis = parts.get("axis")
        if kind in _WITHOUT_AXIS:
            if axis is not None:
                self.leave(axis, NO_AXIS)
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
            self.refused(error, element, {"axis": (axis, "xyz"), "normal": (axis, "xyz")})

    def _close(self, links: Iterable[str]) -> None:
        """Check the links of loops, and their names."""
        known = list(links)
        first: dict[str, Element] = {}
        for loop in self.loops:
            if loop.name and self._is_new(loop.element, loop.name, first.get(loop.name)):
                first[loop.name] = loop.element
            for element, end in loop.ends:
                if end.link not in known:
                    guess = self.guess(end.link or "", known)
                    right = (
                        f'did you mean "{guess}"?' if guess else "expected the name of a link of this file"
                    )
                    wrong = f'got "{end.link}", which is no link of this file'
                    self.problem(element, "link", wrong, right)
            if len(loop.ends) == 2 and loop.ends[0][1].link == loop.ends[1][1].link:
                wrong = f'got "{loop.ends[1][1].link}" at both ends'
                self.problem(loop.ends[1][0], "link", wrong, "expected two links")

    def _limits(self, joint: Element, limit: Element | None, kind: str | None) -> tuple[float, float] | None:
        """The limits that become stops; lists the others."""
        has_limits = kind in ("revolute", "prismatic")
        if limit is None:
            if has_limits:
                self.leave(joint, NO_LIMIT, "type")
            return None
        if not has_limits:
            self.leave(limit, NO_LIMITS)
            return None
        self.open(limit, ("lower", "upper"))
        lower, upper = self.number(limit, "lower", 0.0), self.number(limit, "upper", 0.0)
        if lower is None or upper is None:
            return None
        if lower > upper:
            wrong = f"got lower {lower:g} above upper {upper:g}"
            self.problem(limit, None, wrong, "expected the lower limit below the upper one")
            return None
        if self.limit_stiffness is not None and lower < upper:
            return lower, upper
        reason = NO_STOPS if self.limit_stiffness is None else NO_ROOM
        given = [name for name in ("lower", "upper") if name in limit.attributes]
        # In URDF, missing limits are zero.
        for name in given or (None,):
            self.leave(limit, reason, name)
        return None

    def _one_coordinate(self, element: Element, parts: dict[str, Element], kind: str | None) -> Joint:
        """A revolute or prismatic joint."""
        axis = self._axis(parts.get("axis"))
        limits = self._limits(element, parts.get("limit"), kind)
        dynamics = parts.get("dynamics")
        if dynamics is not None:
            self.open(dynamics, ("damping", "friction"))
        damping = self.number(dynamics, "damping", 0.0)
        friction = self.number(dynamics, "friction", 0.0)
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
            self.refused(error, element, places)
            return Weld()

    def _axis(self, element: Element | None) -> tuple[float, ...]:
        default = (1.0, 0.0, 0.0)
        if element is not None:
            self.open(element, ("xyz",))
        return self.numbers(element, "xyz", default) or default

    def _kind(self, element: Element, kind: str | None, parts: dict[str, Element]) -> Joint:
        if kind not in ("fixed", "floating", "planar"):
            # For an unknown type, at least the numbers are checked.
            return self._one_coordinate(element, parts, kind)
        self._limits(element, parts.get("limit"), kind)
        if "dynamics" in parts:
            self.leave(parts["dynamics"], NO_FORCES)
        axis = parts.get("axis")
        if kind == "planar":
            normal = self._axis(axis)
            try:
                return Planar(normal)
            except ValueError as error:
                self.refused(error, element, {"normal": (axis, "xyz")})
        elif axis is not None:
            self.leave(axis, NO_AXIS)
        return Free() if kind == "floating" else Weld()

    def _joint(self, element: Element) -> _JointRead:
        once = ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic")
        parts = self.open(element, ("name", "type"), once)
        name = self.text(element, "name", "a name")
        kind = self.text(element, "type", f"one of {', '.join(_TYPES)}")
        if kind is not None and kind not in _TYPES:
            guess = self.guess(kind, _TYPES)
            right = f"did you mean {guess}?" if guess else f"expected one of {', '.join(_TYPES)}"
            self.problem(element, "type", f'got "{kind}"', right)
        ends: dict[str, str | None] = {}
        for end in ("parent", "child"):
            if end in parts:
                self.open(parts[end], ("link",))
                ends[end] = self.text(parts[end], "link", "the name of a link")
            else:
                ends[end] = None
                self.problem(element, None, f"got no <{end}>", f'expected <{end} link="..."/>')
        position, orientation = self.pose(parts.get("origin"))
        joint = self._kind(element, kind, parts)
        if "mimic" in parts and kind in _NOT_ONE_COORDINATE:
            self.leave(parts["mimic"], NO_MIMIC)
        elif "mimic" in parts:
            self._mimic(parts["mimic"], name)
        return _JointRead(
            element, name or "", ends["parent"], ends["child"], parts, position, orientation, joint
        )

    def _mimic(self, element: Element, joint: str | None) -> None:
        self.open(element, ("joint", "multiplier", "offset"))
        of = self.text(element, "joint", "the name of a joint")
        multiplier = self.number(element, "multiplier", 1.0)
        offset = self.number(element, "offset", 0.0)
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
                guess = self.guess(mimic.of, joints)
                wrong = f'got "{mimic.of}", which is no joint of this file'
                self.problem(mimic.element, "joint", wrong, f'did you mean "{guess}"?' if guess else right)
            elif kind in _NOT_ONE_COORDINATE:
                self.problem(mimic.element, "joint", f'got "{mimic.of}", a {kind} joint', right)
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
                self.problem(closing.element, "joint", wrong, "expected one that moves by itself")
        if self.document.problems:
            return
        for mimic in following.values():
            joint = joints[mimic.joint]
            link = joints[mimic.of].child or ""
            tie = Mimic(link, multiplier=mimic.multiplier, offset=mimic.offset)
            joint.joint = replace(joint.joint, mimic=tie)

    # The tree

    def _robot(self, root: Element, floating: bool) -> tuple[tuple[Link, ...], dict[str, _JointRead]]:
        read_too = ("material",) if self.pictures is not None else ()
        self.open(root, ("name",), (), ("link", "joint", "loop_joint", *read_too))
        # Links may come before the materials that they refer to.
        for element in root.children:
            if self.pictures is not None and element.tag == "material":
                self.materials[element.attributes.get("name", "")] = colour_of(self, element, {})
        links: dict[str, tuple[Element, Body | None]] = {}
        joints: dict[str, _JointRead] = {}
        read: list[_JointRead] = []
        for element in root.children:
            if element.tag == "link":
                name = self.text(element, "name", "a name")
                body = self._link(element)
                if name is not None and self._is_new(
                    element, name, links[name][0] if name in links else None
                ):
                    links[name] = element, body
            elif element.tag == "loop_joint":
                if self.has_loops:
                    self._loop_joint(element)
                else:
                    self.leave(element, NO_LOOPS_HERE)
            elif element.tag == "joint":
                joint = self._joint(element)
                read.append(joint)
                other = joints.get(joint.name)
                if joint.name and self._is_new(element, joint.name, other.element if other else None):
                    joints[joint.name] = joint
        if not any(element.tag == "link" for element in root.children):
            self.problem(root, None, "got no links", 'expected at least one: <link name="..."/>')
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
        self.problem(element, "name", wrong, "expected a new name")
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
                guess = self.guess(name, links)
                right = f'did you mean "{guess}"?' if guess else "expected the name of a link of this file"
                self.problem(joint.parts[end], "link", f'got "{name}", which is no link of this file', right)
                known = False
            if joint.child is None or joint.child not in links:
                continue
            if joint.child in above:
                other = above[joint.child]
                wrong = (
                    f'got "{joint.child}", which the joint "{other.name}" in line {other.element.line} '
                    "has as its child already"
                )
                self.problem(joint.parts["child"], "link", wrong, "expected a link without another parent")
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
            self.problem(links[name][0], None, wrong, right)
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
        self.problem(closing.element, None, wrong, "expected a tree: no link behind itself")


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
    corners, faces = prism(radius, length)
    return ConvexMesh(corners @ turn.T + middle, faces, link=link)
