"""Numbers printed in the lab report, in seconds of run time, for comparison."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TypeVar

T = TypeVar("T")

#: Table 1: spring pendulum, 1000 s simulated, by step in seconds.
PENDULUM = {1.0: {"implicit": 0.2586, "explicit": 0.24964}, 1e-2: {"implicit": 98.0278, "explicit": 0.79022}}

#: Table 2: rod, 3 s simulated at a step of 0.01 s, by the name of the base's orientation.
ROD_BY_BASE = {
    "hanging": {"implicit": 5.8227, "explicit": 5.6295},
    "horizontal": {"implicit": 46.239, "explicit": math.inf},
}

#: Table 3: rod from horizontal, 3 s simulated, by step in seconds.
ROD_BY_STEP = {1.0: 1.6964, 1e-2: 43.054}

#: The report's statement about the mass matrix: its determinant, taken for a sign of singularity.
MASS_DETERMINANT = (1e-14, 1e-13)


def of_step(table: Mapping[float, T], step: float, is_the_labs: bool) -> T | None:
    """The report's entry for a step; None if it has none, or the model is another one."""
    return table.get(step) if is_the_labs else None
