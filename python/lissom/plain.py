"""Conversion of the numbers in plain data to floats."""

from __future__ import annotations

import numpy as np


def number(name: str, value: object) -> float:
    """A number as a float. Text and times are rejected, although Python can convert some of them."""
    if np.ma.is_masked(value):
        raise TypeError(f"{name}: got a masked value, expected a number")
    found = np.asarray(value)
    if found.ndim == 0 and found.dtype.kind in "biuf":
        return float(found)
    raise TypeError(f"{name}: {value!r:.80} is not a number")


def with_number(thing: object, name: str) -> None:
    """Convert an attribute to a float."""
    object.__setattr__(thing, name, number(name, getattr(thing, name)))


def in_floats(thing: object, *names: str) -> None:
    """Convert attributes to tuples of floats."""
    for name in names:
        values = getattr(thing, name)
        if np.ndim(values) != 1:
            raise TypeError(f"{name}: got {values!r:.80}, expected a sequence of numbers")
        object.__setattr__(thing, name, tuple(number(name, x) for x in values))
