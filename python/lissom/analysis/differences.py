"""Finite-difference derivatives as weighted sums of objects built with nearby values."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

#: Spacing of the difference nodes, relative to the parameter. The truncation error is its fourth power,
#: 2e-11, times the fifth derivative (zero for polynomials up to degree four); the rounding error is about
#: as large.
STEP = 2e-3

#: The same for forces that act in some states only. If only some nodes are in such a state, the difference is
#: wrong. The rounding error is 1e-10 of the forces.
FINE_STEP = 1e-6

#: Nodes and weights of the derivative by four differences, central and to one side (Fornberg 1988, tables 1
#: and 3).
CENTRAL = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))
ONE_SIDED = ((0, -25 / 12), (1, 4.0), (2, -3.0), (3, 4 / 3), (4, -1 / 4))

#: Two nodes, for quantities that are linear in the parameter.
OF_LINEAR = ((-1, -1 / 2), (1, 1 / 2))

#: Sums smaller than this fraction of their terms are rounding errors.
ROUNDING = 1e-13

#: Smaller values count as zero: their squares underflow.
SMALLEST = 1e-154

#: Nodes in steps from the value, with weights.
Nodes = tuple[tuple[int, float], ...]

T = TypeVar("T")


def terms(
    with_value: Callable[[float], T], value: float, nodes: Nodes = CENTRAL, relative: float = STEP
) -> tuple[tuple[T, float], ...]:
    """Objects built with nearby values, and their weights in the derivative.

    Their distance is relative to the value. One-sided differences are used if the value is zero, or
    `with_value` raises a ValueError at the end of the valid range, such as a Poisson ratio of 0.5, or the
    length of a rod with a load at its tip.
    """
    is_zero = abs(value) < SMALLEST
    step = relative * (1.0 if is_zero else abs(value))

    def at(nodes: Nodes, step: float) -> tuple[tuple[T, float], ...]:
        return tuple((with_value(value + k * step), w / step) for k, w in nodes)

    if is_zero:
        return at(ONE_SIDED, step)
    inwards = math.copysign(step, -value)
    refused = None
    for chosen, signed in ((nodes, step), (ONE_SIDED, inwards), (ONE_SIDED, -inwards)):
        try:
            return at(chosen, signed)
        except ValueError as error:
            refused = refused or error
    assert refused is not None
    raise refused
