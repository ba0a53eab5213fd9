"""Colours of all figures, readable on light and dark backgrounds."""

from __future__ import annotations

from typing import Any

import numpy as np

BLUE, ORANGE, GREEN, PURPLE, RED, CYAN, GREY = (
    "#3a7bd5",
    "#e8833a",
    "#2ca25f",
    "#9467d1",
    "#d9485f",
    "#17a2b8",
    "#808994",
)

#: For moments, beside forces in red.
MAGENTA = "#c2479a"

#: For tendons.
GOLD = "#d9a520"

#: For rigid bodies.
STEEL = "#9aa5b4"

#: Colours of the parts of the energy, in every figure.
ENERGY_COLOURS = {
    "kinetic": BLUE,
    "elastic": ORANGE,
    "gravitational": GREEN,
    "loads": PURPLE,
    "dissipated": RED,
    "work": CYAN,
    "total": GREY,
}

#: Colours of successive curves.
SERIES = (BLUE, ORANGE, GREEN, PURPLE, RED, CYAN, GREY)

#: Colour scale from the base of a rod to its tip.
ROD_SCALE: list[tuple[float, str]] = [
    (0.0, "#3448a5"),
    (0.45, "#2f8fc4"),
    (0.75, "#43c6a8"),
    (1.0, "#f4d35e"),
]


def sample(scale: list[tuple[float, str]], at: Any) -> list[str]:
    """Colours of a scale at positions from 0 to 1."""
    stops = [stop for stop, _ in scale]
    parts = np.array([[int(colour[i : i + 2], 16) for i in (1, 3, 5)] for _, colour in scale])
    mixed = np.stack([np.interp(at, stops, part) for part in parts.T], axis=-1).round().astype(int)
    return [f"#{red:02x}{green:02x}{blue:02x}" for red, green, blue in np.atleast_2d(mixed)]


def ink_on(colour: str) -> str:
    """Black or white, whichever has the higher contrast on a colour (relative luminance of WCAG 2.2)."""
    parts = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    luminance = float(linear @ [0.2126, 0.7152, 0.0722])
    return "#000000" if (luminance + 0.05) ** 2 > 0.05 * 1.05 else "#ffffff"
