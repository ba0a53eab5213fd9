"""Damage to bytes: a list of changes as text, one a line, so that lines can be left out."""

import numpy as np

#: Bytes that formats give a meaning to.
TELLING = (
    b"\x00",
    b"\xff",
    b"\n",
    b'"',
    b"{",
    b"[",
    b"<",
    b"&",
    b"PK\x03\x04",
    b"\x93NUMPY",
    b"\x89HDF\r\n\x1a\n",
)

#: Largest part of a content that one change moves, and size of what "many" inserts, bytes.
LONGEST = 4096
MANY = 200_000


def changes(rng: np.random.Generator) -> list[str]:
    """Some changes; places are parts of the content in millionths, so that they suit every content."""
    return [_change(rng) for _ in range(int(rng.choice([1, 1, 1, 2, 3, 8])))]


def _change(rng) -> str:
    kind = str(rng.choice(["flip", "set", "insert", "delete", "repeat", "cut", "move", "many"], p=PARTS))
    return f"{kind} {int(rng.integers(10**6))} {int(rng.integers(LONGEST))} {int(rng.integers(256))}"


PARTS = [0.35, 0.15, 0.12, 0.12, 0.08, 0.08, 0.08, 0.02]


def damaged(content: bytes, lines: list[str]) -> bytes:
    """The content after these changes."""
    for line in lines:
        kind, *numbers = line.split()
        where, length, byte = map(int, numbers)
        at = where * len(content) // 10**6
        before, after = content[:at], content[at:]
        match kind:
            case "flip":
                after = bytes([after[0] ^ 1 << byte % 8]) + after[1:] if after else after
            case "set":
                after = bytes([byte]) + after[1:]
            case "insert":
                after = TELLING[byte % len(TELLING)] + after
            case "delete":
                after = after[1 + length % 64 :]
            case "repeat":
                after = after[:length] + after
            case "cut":
                after = b""
            case "move":
                after = after[length:] + after[:length]
            case "many":
                after = TELLING[byte % len(TELLING)] * MANY + after
        content = before + after
    return content
