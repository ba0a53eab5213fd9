"""The rooms of the source, listed in CONTRIBUTING.md, and their allowed dependencies in `use` lines."""

import re
from itertools import pairwise
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
SOURCE = ROOT / "src"


def modules():
    """The code of every module by its path, such as ("robot", "plan"), without comments and tests.

    The crate hands on the rooms of `src/core`, so that paths are the same in both crates.
    """
    found = {}
    for file in sorted(SOURCE.rglob("*.rs")):
        if file.parent in (SOURCE / "core", SOURCE / "extension") and file.name in ("lib.rs", "build.rs"):
            continue
        path = file.relative_to(SOURCE).with_suffix("").parts
        path = path[path[0] == "core" :]
        code = re.sub(r"^\s*//.*$", "", file.read_text(encoding="utf-8"), flags=re.MULTILINE)
        # Modules within a file, whose `super` is that file.
        code = re.sub(r"^\s+use super::\*;$", "", code, flags=re.MULTILINE)
        found[path[:-1] if path[-1] == "mod" else path] = code.split("#[cfg(test)]\nmod tests")[0]
    found[()] = found.pop(("lib",))
    return found


def leaves(tree):
    """The paths of a use tree: ``a::{b, c::d}`` are ``a::b`` and ``a::c::d``."""
    tree = " ".join(tree.split())
    match = re.fullmatch(r"([^{]*)\{(.*)\}", tree)
    if not match:
        return [tree.split(" as ")[0].strip()]
    head, inner = match.groups()
    # Commas within inner braces separate other trees.
    parts, depth, start = [], 0, 0
    for i, letter in enumerate(inner + ","):
        depth += (letter == "{") - (letter == "}")
        if letter == "," and depth == 0:
            parts.append(inner[start:i])
            start = i + 1
    return [head + leaf for part in parts if part.strip() for leaf in leaves(part.strip())]


class House:
    """Modules and their dependencies."""

    def __init__(self, code):
        self.code = code
        self.handed_on = {module: {} for module in code}
        for module, text in code.items():
            for tree in re.findall(r"\bpub(?:\([^)]*\))? use ([^;]+);", text):
                for path in map(lambda leaf, module=module: self.absolute(module, leaf), leaves(tree)):
                    if path:
                        self.handed_on[module][path[-1]] = path
        self.uses = {module: self.used_by(module) for module in code}

    def absolute(self, module, path):
        """A path from the root of the crate; None if it leads outside."""
        parts = path.split("::")
        if parts[0] == "crate":
            return tuple(parts[1:])
        up = 0
        while parts and parts[0] == "super":
            parts, up = parts[1:], up + 1
        if up:
            return module[: len(module) - up] + tuple(parts)
        if parts[0] == "self":
            return module + tuple(parts[1:])
        return module + tuple(parts) if (*module, parts[0]) in self.code else None

    def home(self, path):
        """The module to which a path leads, through all re-exports."""
        for end in range(len(path), -1, -1):
            module = path[:end]
            if module in self.code:
                rest = path[end:]
                if rest and rest[0] in self.handed_on[module]:
                    return self.home(self.handed_on[module][rest[0]] + rest[1:])
                return module
        raise AssertionError(path)

    def used_by(self, module):
        text = self.code[module]
        paths = [
            leaf
            for tree in re.findall(r"^(?:    )*use ([^;]+);", text, re.MULTILINE)
            for leaf in leaves(tree)
        ]
        paths += re.findall(r"^pub(?:\([^)]*\))? use (crate::[^;]+);", text, re.MULTILINE)
        paths += re.findall(r"\b(?:crate|super)(?:::\w+)+", re.sub(r"\buse [^;]+;", "", text))
        homes = {self.home(path) for path in (self.absolute(module, leaf) for leaf in paths) if path}
        return homes - {module, ()}

    def circles(self):
        """Modules that use each other, directly or through others: strongly connected ones (Tarjan 1972)."""
        order, low, stack, circles = {}, {}, [], []

        def visit(module):
            order[module] = low[module] = len(order)
            stack.append(module)
            for other in self.uses[module]:
                if other not in order:
                    visit(other)
                    low[module] = min(low[module], low[other])
                elif other in stack:
                    low[module] = min(low[module], order[other])
            if low[module] == order[module]:
                at = stack.index(module)
                circles.append(stack[at:])
                del stack[at:]

        for module in self.code:
            if module not in order:
                visit(module)
        return circles


@pytest.fixture(scope="module")
def house():
    return House(modules())


def rooms():
    """The rooms from the bottom up, as listed in CONTRIBUTING.md."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    section = text.split("## Rooms of the crate")[1].split("\nInside `robot`")[0]
    rows = re.findall(r"^\| ((?:`[\w/]+`(?:, )?)+) +\|", section, re.MULTILINE)
    return [tuple(name.split("/")) for row in rows for name in re.findall(r"`([\w/]+)`", row)]


def room_of(module, rooms):
    """The most specific room that contains a module."""
    return max((room for room in rooms if module[: len(room)] == room), key=len, default=None)


def test_every_module_lies_in_a_room(house):
    known = rooms()
    assert [module for module in house.code if module and room_of(module, known) is None] == []
    assert [room for room in known if room not in house.code] == []


def test_rooms_use_only_lower_ones(house):
    known = rooms()
    floor = {room: at for at, room in enumerate(known)}
    upwards = [
        ("/".join(module), "/".join(other))
        for module, others in house.uses.items()
        if module
        for other in others
        if floor[room_of(other, known)] > floor[room_of(module, known)]
    ]
    assert upwards == []


def test_no_files_make_a_circle(house):
    assert [circle for circle in house.circles() if len(circle) > 1] == []


def test_circles_and_paths_are_found():
    code = {
        (): "",
        ("a",): "use crate::b::{self, Thing};",
        ("b",): "pub use inner::Thing;",
        ("b", "inner"): "use super::super::c::deep;",
        ("c",): "fn f() { crate::a::f() }",
    }
    house = House(code)
    assert house.uses[("a",)] == {("b",), ("b", "inner")}
    assert {frozenset(circle) for circle in house.circles() if len(circle) > 1} == {
        frozenset({("a",), ("b", "inner"), ("c",)})
    }
    assert leaves("a::{b, c::{d, e as f}}") == ["a::b", "a::c::d", "a::c::e"]
    assert all(x != y for x, y in pairwise(rooms()))
