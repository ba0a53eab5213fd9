"""Minimises a case: removes lines as long as the same fault appears."""

from collections.abc import Callable

#: Maximum number of runs of the case; each takes milliseconds, or a second if it kills the process.
TRIES = 40


def fewer_lines(text: bytes, fails: Callable[[bytes], bool], tries: int = TRIES) -> bytes:
    """Remove half of the lines, a quarter, ..., then single lines (the first step of Zeller's ddmin)."""
    lines = text.split(b"\n")
    size = max(len(lines) // 2, 1)
    while tries > 0:
        start = 0
        while start < len(lines) and tries > 0:
            less = lines[:start] + lines[start + size :]
            tries -= 1
            if less and fails(b"\n".join(less)):
                lines = less
            else:
                start += size
        if size == 1:
            break
        size //= 2
    return b"\n".join(lines)
