"""The imported and the ignored content of a URDF file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from .._lissom import Box, Capsule, ConvexMesh, Link, Loop, Sphere
from ..model.visuals import Visual
from .problems import LONGEST_KEY, counted, short
from .reasons import FIRST

#: Number of lines named for entries of the same kind.
_LINES_NAMED = 3


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
        return f"{self.line}:{self.column}: {short(self.path, LONGEST_KEY)}: {self.reason}"


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
    loops : tuple of Loop
        The loops of the file, for a `Robot`.
    shapes : tuple of Box, Sphere, Capsule or ConvexMesh
        The shapes for contact of the file, on their links, if they were asked for. A `Contact` says what
        each of them touches.
    visuals : tuple of Visual
        The meshes and shapes for pictures of the file, on their links, if they were asked for. Pass them to
        what draws, such as `MotionResult.report`.
    """

    links: tuple[Link, ...]
    not_taken: tuple[Left, ...]
    joints: dict[str, str] = field(default_factory=dict)
    name: str = ""
    file: str = ""
    loops: tuple[Loop, ...] = ()
    shapes: tuple[Box | Sphere | Capsule | ConvexMesh, ...] = ()
    visuals: tuple[Visual, ...] = ()

    def __str__(self) -> str:
        size = f'robot "{short(self.name, LONGEST_KEY)}", {counted(len(self.links), "link")}'
        head = f"{self.file}: {size}, {counted(len(self.joints), 'joint')}"
        for number, what in (
            (len(self.loops), "loop"),
            (len(self.shapes), "shape"),
            (len(self.visuals), "visual"),
        ):
            head += f", {counted(number, what)}" if number else ""
        if not self.not_taken:
            return f"{head}; everything was taken over"
        groups: dict[tuple[str, str], list[Left]] = {}
        for left in self.not_taken:
            groups.setdefault((left.what, left.reason), []).append(left)
        rank = {reason: i for i, reason in enumerate(FIRST)}
        ordered = sorted(groups.items(), key=lambda group: rank.get(group[0][1], len(rank)))
        lines = [f"{head}; not taken over:"]
        for (what, reason), entries in ordered:
            lines.append(f"  {short(what, LONGEST_KEY)} ({_places(entries)}): {reason}")
        return "\n".join(lines)


def _places(entries: Sequence[Left]) -> str:
    """``line 3``, ``12; lines 3, 9, 17 and 9 more``."""
    if len(entries) == 1:
        return f"line {entries[0].line}"
    named = ", ".join(str(left.line) for left in entries[:_LINES_NAMED])
    rest = len(entries) - _LINES_NAMED
    return f"{len(entries)}; lines {named}" + (f" and {rest} more" if rest > 0 else "")
