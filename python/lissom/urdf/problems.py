"""Problems of a URDF file, and their text."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

#: Maximum number of problems in a message, and maximum lengths of a key and of its sentence.
MOST_PROBLEMS = 100

LONGEST_KEY = 200

_LONGEST_SENTENCE = 1000


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
            parts.append(short(self.key, LONGEST_KEY))
        sentence = short(self.wrong, _LONGEST_SENTENCE)
        if self.right:
            sentence += "; " + short(self.right, _LONGEST_SENTENCE)
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
        shown = [f"{problem}\n{problem.snippet}".rstrip() for problem in self.problems[:MOST_PROBLEMS]]
        rest = len(self.problems) - len(shown)
        return "\n".join([*shown, f"and {counted(rest, 'more problem')}"] if rest else shown)


class UrdfWarning(UserWarning):
    """Some content of a URDF file was not imported."""


def counted(number: int, what: str) -> str:
    return f"{number} {what}" + ("" if number == 1 else "s")


def short(text: str, most: int) -> str:
    """The text shortened to one line."""
    text = re.sub(r"[\x00-\x1f\x7f]", lambda found: repr(found[0])[1:-1], text)
    return text if len(text) <= most else text[:most] + "..."
