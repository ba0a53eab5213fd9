"""The parameters of the lab, which its students may change."""

from __future__ import annotations

import math
from dataclasses import Field, dataclass, field, fields
from typing import Any

from ....drawing.report import theme

#: The long step that the lab compares with the others, seconds.
COARSE_STEP = 1.0

#: Shortest step, seconds: ten million of these are the 1000 s of table 1.
SHORTEST_STEP = 1e-4

#: Largest natural frequency of the spring, rad/s. In all, the explicit method takes some 5000 s times this in
#: steps (most of them for the reference): seconds.
FASTEST = 2e3

#: Largest start of a search; far beyond, x^4 overflows.
LARGEST_START = 1e6

ROOTS, PENDULUM, ROD = "roots", "pendulum", "rod"


def _parameter(default: Any, unit: str, *parts: str) -> Any:
    """A field with its unit and the parts of the lab in which it counts."""
    return field(default=default, metadata={"unit": unit, "parts": parts})


@dataclass(frozen=True)
class Setup:
    """Parameters of the lab's experiments in SI units; the defaults are those of the lab's report.

    Raises
    ------
    ValueError
        If a value is invalid; the message names it.
    """

    start: tuple[float, ...] = _parameter((6.0, 1.0, 0.7), "", ROOTS)
    dt: float = _parameter(1e-2, "s", PENDULUM, ROD)
    mass: float = _parameter(1.0, "kg", PENDULUM)
    stiffness: float = _parameter(10.0, "N/m", PENDULUM)
    angle: float = _parameter(-math.pi / 4.0, "rad", PENDULUM)
    elongation: float = _parameter(0.5, "m", PENDULUM)
    radius: float = _parameter(1e-3, "m", ROD)
    young_modulus: float = _parameter(210e9, "Pa", ROD)
    density: float = _parameter(7800.0, "kg/m³", ROD)
    retardation_time: float = _parameter(1e-4, "s", ROD)

    def __post_init__(self) -> None:
        if not 1 <= len(self.start) <= len(theme.SERIES) or len(set(self.start)) < len(self.start):
            raise ValueError(
                f"start: expected one to {len(theme.SERIES)} different numbers, got {_shown(self.start)}"
            )
        for start in self.start:
            if not abs(start) <= LARGEST_START:
                raise ValueError(
                    f"start: expected numbers from -{LARGEST_START:g} to {LARGEST_START:g}, got {start:g}"
                )
        if not SHORTEST_STEP <= self.dt < COARSE_STEP:
            raise ValueError(
                f"dt: expected {SHORTEST_STEP:g} s or more, and less than the long step of {COARSE_STEP:g} s "
                f"with which it is compared, got {self.dt:g} s"
            )
        if not abs(self.angle) <= 2.0 * math.pi:
            degrees = f"; {self.angle:g} degrees are {math.radians(self.angle):.4g} rad"
            raise ValueError(
                f"angle: expected radians from -2 pi to 2 pi, got {self.angle:g}"
                + (degrees if math.isfinite(self.angle) else "")
            )
        if not -1.0 < self.elongation < math.inf:
            raise ValueError(
                "elongation: expected more than -1 m, where the spring has no length, got "
                f"{self.elongation:g} m"
            )
        for name in ("mass", "stiffness", "radius", "young_modulus", "density"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise ValueError(
                    f"{name.replace('_', '-')}: expected a positive number, got {getattr(self, name):g}"
                )
        self._check_frequency()
        if not 0.0 <= self.retardation_time < math.inf:
            raise ValueError(f"retardation-time: expected zero or more, got {self.retardation_time:g}")

    def _check_frequency(self) -> None:
        """Reject springs whose oscillations would take the explicit method more than minutes."""
        frequency = math.sqrt(self.stiffness / self.mass)
        if frequency <= FASTEST:
            return
        why = (
            f"the spring oscillates at {frequency:.2g} rad/s, at which the 1000 s of table 1 take too many "
            f"steps (at most {FASTEST:g} rad/s)"
        )
        if self.mass != LABS.mass:
            least = self.stiffness / FASTEST**2
            raise ValueError(f"mass: expected {least:.2g} kg or more, got {self.mass:g} kg: {why}")
        most = self.mass * FASTEST**2
        raise ValueError(f"stiffness: expected {most:.2g} N/m or less, got {self.stiffness:g} N/m: {why}")

    def changes(self) -> list[str]:
        """The parameters that are not those of the lab's report, as ``mass 2 kg (report: 1 kg)``."""
        return [
            f"{each.name.replace('_', ' ')} {_as_text(self, each)} (report: {_as_text(LABS, each)})"
            for each in self._changed()
        ]

    def is_the_labs(self, part: str) -> bool:
        """Whether a part has the lab's own model and start, whatever its step."""
        return not any(part in each.metadata["parts"] and each.name != "dt" for each in self._changed())

    def _changed(self) -> list[Field[Any]]:
        return [each for each in fields(self) if getattr(self, each.name) != getattr(LABS, each.name)]


#: The parameters of the lab's report.
LABS = Setup()


def _as_text(setup: Setup, each: Field[Any]) -> str:
    """A parameter with its unit."""
    return f"{_shown(getattr(setup, each.name))} {each.metadata['unit']}".strip()


def _shown(value: float | tuple[float, ...]) -> str:
    numbers = value if isinstance(value, tuple) else (value,)
    return ", ".join(f"{number:g}" for number in numbers)
