"""Doubts about accuracy, collected from computations whose caller says them once."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import TypeVar

from .._lissom import AccuracyWarning

T = TypeVar("T")


def without_doubts(function: Callable[[], T]) -> tuple[T, list[str]]:
    """The result of a function, and its warnings of accuracy in place of issuing them; others are issued."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = function()
    for each in caught:
        if not issubclass(each.category, AccuracyWarning):
            warnings.warn_explicit(each.message, each.category, each.filename, each.lineno)
    return result, [str(each.message) for each in caught if issubclass(each.category, AccuracyWarning)]
