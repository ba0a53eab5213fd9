"""Natural frequencies."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from ...._lissom import Rod, Segment, modes
from . import exact
from .case import Answer, Array, Case, Curve, Plot
from .rods import WEIGHTLESS
from .statics import WIRE

THEME = "Frequencies"


def frequencies_of(rod: Rod, count: int, wanted: Callable[[], ArrayLike], names: tuple[str, str]) -> Answer:
    """First frequencies of a straight rod without weight in hertz; the plot also shows the reference
    values."""
    found = modes(rod, np.zeros(rod.n)).frequency[:count]

    def plot() -> Plot:
        number = np.arange(1, count + 1)
        expected = np.asarray(wanted())
        return Plot(
            "mode",
            "frequency / that of " + names[1] + " − 1",
            [Curve(f"lissom, {names[0]}", number, found / expected[:count] - 1.0, joined=False)],
        )

    return Answer(found, plot)


# The lab's wire

WIRE_STIFFNESS = WIRE["young_modulus"] * np.pi / 4.0 * WIRE["radius"] ** 4
WIRE_MASS = WIRE["density"] * np.pi * WIRE["radius"] ** 2


def euler_bernoulli(count: int) -> Array:
    """Frequencies of the lab's wire."""
    rate = np.sqrt(WIRE_STIFFNESS / WIRE_MASS) / WIRE["length"] ** 2
    return np.asarray(exact.cantilever_roots(count) ** 2 * rate / (2.0 * np.pi))


def wire(count: int, wanted: Callable[[], ArrayLike], name: str, bends: int) -> Answer:
    """The lab's wire, straight."""
    rod = Rod([Segment(**WIRE, modes={"bend_y": bends})], gravity=WEIGHTLESS)
    return frequencies_of(rod, count, wanted, (f"{bends} modes", name))


# A thick beam

BEAM_RADIUS, BEAM_YOUNG, BEAM_SHEAR, BEAM_DENSITY = 0.05, 1e7, 4e6, 1000.0
BEAM_CORRECTION = 0.9
BEAM_COUNT = 4


@cache
def timoshenko() -> Array:
    """Frequencies of a beam of one metre with shear and rotary inertia, hertz."""
    area = np.pi * BEAM_RADIUS**2
    second_moment = area * BEAM_RADIUS**2 / 4.0
    omega = exact.timoshenko_frequencies(
        BEAM_YOUNG * second_moment,
        BEAM_CORRECTION * BEAM_SHEAR * area,
        BEAM_DENSITY * area,
        BEAM_DENSITY * second_moment,
        1.0,
        BEAM_COUNT,
    )
    return np.asarray(omega / (2.0 * np.pi))


def thick_beam() -> Answer:
    """The beam, straight."""
    bends = {"bend_y": 12, "shear_z": 12}
    segment = Segment(
        1.0,
        BEAM_RADIUS,
        BEAM_YOUNG,
        BEAM_SHEAR,
        BEAM_DENSITY,
        bends,
        shear_correction=BEAM_CORRECTION,
        nodes=28,
    )
    rod = Rod([segment], gravity=WEIGHTLESS)
    return frequencies_of(rod, BEAM_COUNT, timoshenko, ("12 modes", "theory"))


# Bars

BAR_COUNT = 3


def bar_frequencies() -> Array:
    """Frequencies of stretch, then of torsion."""
    odd = 2.0 * np.arange(1, BAR_COUNT + 1) - 1.0
    speeds = np.sqrt(np.array([BEAM_YOUNG, BEAM_SHEAR]) / BEAM_DENSITY)
    return np.ravel(np.outer(speeds, odd / 4.0))


def bar() -> Answer:
    """Two rods, one that can only stretch and one that can only twist."""
    found = []
    for strain in ("stretch", "torsion"):
        segment = Segment(1.0, BEAM_RADIUS, BEAM_YOUNG, BEAM_SHEAR, BEAM_DENSITY, {strain: 12}, nodes=24)
        rod = Rod([segment], gravity=WEIGHTLESS)
        found.append(modes(rod, np.zeros(rod.n)).frequency[:BAR_COUNT])

    def plot() -> Plot:
        number = np.arange(1, BAR_COUNT + 1)
        expected = bar_frequencies().reshape(2, BAR_COUNT)
        curves = [
            Curve(f"lissom, {name}", number, values, joined=False)
            for name, values in zip(("stretching", "twisting"), found, strict=True)
        ]
        curves += [
            Curve(f"exact, {name}", number, values)
            for name, values in zip(("stretching", "twisting"), expected, strict=True)
        ]
        return Plot("mode", "frequency (Hz)", curves)

    return Answer(np.concatenate(found), plot)


#: Frequencies of the lab's wire with six modes in hertz, by an independent Galerkin computation.
GALERKIN = (1.451787, 9.098290, 25.48286)

CASES = (
    Case(
        "Cantilever, Euler-Bernoulli",
        THEME,
        "The lab's wire, straight, without weight; 14 modes. lissom has rotary inertia, which the theory "
        "has not: it costs the fifth mode 3e-5.",
        "Euler-Bernoulli theory, cos b cosh b = −1",
        "exact",
        "first five frequencies (Hz)",
        lambda: euler_bernoulli(5),
        lambda: wire(5, lambda: euler_bernoulli(5), "Euler-Bernoulli", 14),
        2e-4,
    ),
    Case(
        "Lab wire, 6 modes",
        THEME,
        "The same wire with six modes.",
        "Independent Galerkin computation",
        "computed",
        "first three frequencies (Hz)",
        lambda: GALERKIN,
        lambda: wire(3, lambda: GALERKIN, "the independent computation", 6),
        2e-6,
    ),
    Case(
        "Cantilever, Timoshenko",
        THEME,
        "Slenderness 1 / 20, E = 10 MPa, G = 4 MPa, shear correction 0.9; 12 modes of bending and of shear.",
        "Timoshenko 1921, zeros of the transfer matrix",
        "exact",
        "first four frequencies (Hz)",
        timoshenko,
        thick_beam,
        1e-6,
    ),
    Case(
        "Bar, stretching and twisting",
        THEME,
        "The same rod with 12 modes of stretch, and with 12 of torsion.",
        "d'Alembert's wave equation, (2 n − 1) c / (4 L)",
        "exact",
        "first three frequencies each (Hz)",
        bar_frequencies,
        bar,
        1e-8,
    ),
)
