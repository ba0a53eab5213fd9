"""Compact encoding of arrays in documents for the browser: 8 to 32 bits per number, deflated, as text.

A document is plain data (dictionaries, lists, numbers, text) that contains arrays. `pack` replaces each array
by a reference, and encodes the numbers of all arrays in one text:

    {"array": [first byte, type, shape, low, step]}

``type`` is ``u1``, ``u2`` or ``u4`` for integers of one, two or four bytes, or ``f4`` for single
precision. The integer n stands for ``low + n step``; the largest n stands for NaN. Integers are stored as
differences along the first axis, so that slow changes compress well. Of longer integers all lowest bytes
precede all next ones. ``low`` and ``step`` are single numbers, or one per entry of a short last axis, so that
a small displacement beside a large one keeps its digits. ``player/unpack.js`` decodes the text.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Type = Literal["u1", "u2", "u4", "f4"]

#: Last axes up to this length, such as components of points and quaternions, have a separate scale per entry.
MOST_SCALES = 4

#: Larger values are clipped to this, so that their differences are finite.
LARGEST = 1e300

#: Compression level of deflate: best compression.
LEVEL = 9


@dataclass(frozen=True)
class Numbers:
    """An array of a document with its encoding.

    The error is at most half a step: range / 131,066 for ``u2``, range / 506 for ``u1``; zero stays zero.
    ``u4`` keeps nine digits of the range, for times. ``f4`` keeps seven digits of each number, for values
    over many orders of magnitude.
    """

    values: NDArray[Any]
    type: Type = "u2"


def pack(document: Any) -> dict[str, Any]:
    """Convert a document with NumPy arrays and `Numbers` to plain JSON: ``{"document": ..., "data": text}``.

    An array that occurs several times is packed once.
    """
    parts: list[bytes] = []
    known: dict[tuple[int, Type], tuple[Any, dict[str, Any]]] = {}
    first = 0

    def packed(value: Any) -> Any:
        nonlocal first
        match value:
            case np.ndarray():
                return packed(Numbers(value))
            case Numbers(values, kind):
                key = (id(values), kind)
                if key not in known:
                    content, reference = encode(values, kind)
                    # Keep a reference to the array, so that its id is not reused.
                    known[key] = (values, {"array": [first, *reference]})
                    parts.append(content)
                    first += len(content)
                return known[key][1]
            case Mapping():
                return {key: packed(inner) for key, inner in value.items()}
            case list() | tuple():
                return [packed(inner) for inner in value]
            case np.generic():
                return value.item()
            case _:
                return value

    plain = packed(document)
    data = base64.b64encode(zlib.compress(b"".join(parts), LEVEL)).decode("ascii")
    return {"document": plain, "data": data}


def encode(values: NDArray[Any], kind: Type) -> tuple[bytes, list[Any]]:
    """Encoded bytes of an array, with its type, shape, low and step."""
    values = np.atleast_1d(np.asarray(values, np.float64))
    if kind == "f4":
        with np.errstate(over="ignore"):
            return values.astype("<f4").tobytes(), [kind, list(values.shape), 0, 1]
    values = np.where(np.isfinite(values), np.clip(values, -LARGEST, LARGEST), np.nan)
    largest = 2 ** (8 * int(kind[1])) - 1
    low, step = _scale(values, largest - 1)
    numbers = np.rint(np.where(np.isnan(values), 0.0, values - low) / np.where(step > 0.0, step, 1.0))
    numbers = np.where(np.isnan(values), largest, np.minimum(numbers, largest - 1)).astype(kind)
    numbers[1:] -= numbers[:-1].copy()
    content = numbers.astype(f"<{kind}").reshape(-1, 1).view(np.uint8).T.tobytes()
    return content, [kind, list(values.shape), _plain(low), _plain(step)]


def _scale(values: NDArray[np.float64], steps: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Minimum and step, one for each entry of a short last axis; no step where all values are equal.

    Zero is one of the steps, if it is within the values: what does not move yet has no displacement, not half
    a step.
    """
    short = values.ndim > 1 and values.shape[-1] <= MOST_SCALES
    columns = values.reshape(-1, values.shape[-1] if short else 1)
    low, high = np.zeros(columns.shape[1]), np.zeros(columns.shape[1])
    for i, column in enumerate(columns.T):
        known = column[~np.isnan(column)]
        if len(known):
            low[i], high[i] = known.min(), known.max()
    has_zero = (low < 0.0) & (high >= 0.0)
    # One step is left for moving the minimum.
    step = (high - low) / np.where(has_zero, steps - 1, steps)
    has_zero &= step > 0.0
    low[has_zero] = -np.ceil(-low[has_zero] / step[has_zero]) * step[has_zero]
    return (low, step) if short else (low[0], step[0])


def _plain(values: Any) -> Any:
    return np.asarray(values).tolist()
