"""Compact encoding of arrays in documents for the browser: 8 or 16 bits per number, deflated, as text.

A document is plain data (dictionaries, lists, numbers, text) with arrays in it. `pack` puts a reference in
the place of each array, and the numbers of all of them into one text:

    {"array": [first byte, type, shape, low, step]}

``type`` is ``u1`` or ``u2``, for numbers in so many bytes, or ``f4`` as they are. A number of bytes n stands
for ``low + n step``, the largest n for NaN, and each is the difference from the one before along the first
axis: what moves slowly then deflates well. Of two bytes all low ones come first. ``low`` and ``step`` are
one number each, or one for each entry of the last axis where that is short, so that a small displacement
beside a large one keeps its digits. ``player/unpack.js`` reads it all.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Type = Literal["u1", "u2", "f4"]

#: Last axes up to this length, such as those of points and quaternions, have a scale for each entry.
MOST_SCALES = 4

#: Larger numbers are packed as this, so that their differences are numbers too.
LARGEST = 1e300

#: Of deflate: small before quick.
LEVEL = 9


@dataclass(frozen=True)
class Numbers:
    """An array of a document and how exact it is.

    Errors are at most half a step: range / 131,068 of ``u2``, range / 508 of ``u1``.
    ``f4`` keeps seven digits of each number; it is for what spans many powers of ten.
    """

    values: NDArray[Any]
    type: Type = "u2"


def pack(document: Any) -> dict[str, Any]:
    """A document, with NumPy arrays and `Numbers` in it, as plain JSON: ``{"document": ..., "data": text}``.

    An array that stands in several places is packed once.
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
                    # The array is kept so that no other one gets its id.
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
    """The bytes of an array, and its type, shape, low and step."""
    values = np.atleast_1d(np.asarray(values, np.float64))
    if kind == "f4":
        with np.errstate(over="ignore"):
            return values.astype("<f4").tobytes(), [kind, list(values.shape), 0, 1]
    values = np.where(np.isfinite(values), np.clip(values, -LARGEST, LARGEST), np.nan)
    largest = 2 ** (8 * int(kind[1])) - 1
    low, step = _scale(values, largest - 1)
    numbers = np.rint(np.where(np.isnan(values), 0.0, values - low) / step)
    numbers = np.where(np.isnan(values), largest, np.minimum(numbers, largest - 1)).astype(kind)
    numbers[1:] -= numbers[:-1].copy()
    content = numbers.astype(f"<{kind}").reshape(-1, 1).view(np.uint8).T.tobytes()
    return content, [kind, list(values.shape), _plain(low), _plain(step)]


def _scale(values: NDArray[np.float64], steps: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Least number and step, one for each entry of a short last axis."""
    short = values.ndim > 1 and values.shape[-1] <= MOST_SCALES
    columns = values.reshape(-1, values.shape[-1] if short else 1)
    low, high = np.zeros(columns.shape[1]), np.zeros(columns.shape[1])
    for i, column in enumerate(columns.T):
        known = column[~np.isnan(column)]
        if len(known):
            low[i], high[i] = known.min(), known.max()
    step = (high - low) / steps
    step[step == 0.0] = 1.0
    return (low, step) if short else (low[0], step[0])


def _plain(values: Any) -> Any:
    return np.asarray(values).tolist()
