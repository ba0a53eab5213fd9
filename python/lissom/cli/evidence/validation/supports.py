"""Rods held at both ends: by the clamp at their base and by almost rigid springs at their tip."""

from __future__ import annotations

import numpy as np

from ...._lissom import Load, Rod, Segment, Support, modes
from . import exact
from .buckling import lowest_eigenvalues
from .case import Answer, Array, Case, Curve, Plot
from .rods import BENDING, LENGTH, POINTS, WEIGHTLESS, at_rest, centre_line, density_for, round_rod, tip

THEME = "Held at both ends"

#: Stiffness of the springs in units of E I / L^3 and E I / L; their compliance causes a relative error of a
#: few parts in this number.
STIFFNESS = 1e8


def hold(*, is_clamp: bool) -> Support:
    """Holds the tip perpendicular to the rod, and its direction if it is a clamp; the tip can slide and
    twist."""
    across = STIFFNESS * BENDING / LENGTH**3
    about = STIFFNESS * BENDING / LENGTH if is_clamp else 0.0
    return Support(stiffness=(0.0, across, across), rotational_stiffness=(0.0, about, about))


# Columns

COLUMNS = {"pinned": exact.greenhill_root() ** 2, "clamped": 4.0 * np.pi**2}


def column(end: str) -> Answer:
    """A column under an axial force at a held end."""
    load = 1.25 * COLUMNS[end]
    rod = round_rod(
        {"bend_y": 12},
        nodes=28,
        tip_force=(-load * BENDING / LENGTH**2, 0.0, 0.0),
        supports=[hold(is_clamp=end == "clamped")],
    )
    return lowest_eigenvalues(rod, load, "P L² / (E I)")


# Twist

TWIST = 10.0


def twisted() -> Answer:
    """A shaft under an axial moment: half of it dead and half follower, which together have a potential."""
    moment = (0.5 * TWIST * BENDING / LENGTH, 0.0, 0.0)
    rod = round_rod(
        {"torsion": 1, "bend_y": 12, "bend_z": 12},
        nodes=28,
        tip_moment=moment,
        loads=[Load(moment=moment, frame="body")],
        supports=[hold(is_clamp=True)],
    )
    return lowest_eigenvalues(rod, TWIST, "M L / (E I)")


# Frequencies

#: Slender, so that rotary inertia is negligible.
THIN, YOUNG, DENSITY = 1e-4, 1e9, 1000.0
THIN_BENDING = YOUNG * np.pi / 4.0 * THIN**4
COUNT = 3


def thin(end: str) -> Rod:
    """A beam held at its tip."""
    about = STIFFNESS * THIN_BENDING if end == "clamped" else 0.0
    support = Support(stiffness=(0.0, 0.0, STIFFNESS * THIN_BENDING), rotational_stiffness=(0.0, about, 0.0))
    segment = Segment(LENGTH, THIN, YOUNG, 0.4 * YOUNG, DENSITY, {"bend_y": 16}, nodes=32)
    return Rod([segment], gravity=WEIGHTLESS, supports=[support])


def vibrating() -> Answer:
    """The lowest frequencies of beams with a pinned and with a clamped tip."""
    unit = np.sqrt(THIN_BENDING / (DENSITY * np.pi * THIN**2)) / LENGTH**2
    found = [modes(thin(end), np.zeros(16)).angular_frequency[:COUNT] / unit for end in COLUMNS]

    def plot() -> Plot:
        number = np.arange(1, COUNT + 1)
        curves = []
        for end, by_lissom, wanted in zip(COLUMNS, found, beam_frequencies(), strict=True):
            curves.append(Curve(f"clamped and {end}", number, wanted))
            curves.append(Curve(f"lissom, {end}", number, by_lissom, joined=False))
        return Plot("mode", "ω / √(E I / (ρ A L⁴))", curves)

    return Answer(np.concatenate(found), plot)


def beam_frequencies() -> list[Array]:
    """Euler-Bernoulli frequencies, pinned and clamped."""
    return [exact.held_beam_roots(COUNT, is_clamped=end == "clamped") ** 2 for end in COLUMNS]


# Large deflections

HEAVY = 100.0


def heavy_beam() -> Answer:
    """A beam between two clamps, one of which can slide, under its own weight."""
    rod = round_rod(
        {"bend_y": 16},
        nodes=36,
        density=density_for(HEAVY),
        gravity=(0.0, 0.0, -9.81),
        supports=[hold(is_clamp=True)],
    )

    def values(rod: Rod, q: Array) -> Array:
        return np.array([tip(rod, q)[0], centre_line(rod, q)[POINTS // 2, 2]])

    def points() -> list[tuple[str, Array, Array]]:
        shape = sagging()
        return [("Chebyshev collocation", shape.x, shape.z)]

    return at_rest([("lissom", rod)], values, points)


def sagging() -> exact.PlanarShape:
    """The same by collocation, including the force and moment at the tip."""
    return exact.held_planar_rod(LENGTH, 1.0, HEAVY)


def sag() -> list[float]:
    """Position of the tip, and height of the middle."""
    shape = sagging()
    return [float(shape.x[-1]), exact.interpolated(shape.X, shape.z, 0.5 * LENGTH)]


CASES = (
    *(
        Case(
            f"Column, clamped and {end}",
            THEME,
            f"Axial force at a {end} end that slides along the column; 12 modes. The end is held by "
            "springs of 1e8 times the column's stiffness.",
            source,
            "exact",
            "buckling load × L² / (E I)",
            lambda end=end: [COLUMNS[end]],  # type: ignore[misc]
            lambda end=end: column(end),  # type: ignore[misc]
            1e-6,
        )
        for end, source in (
            ("pinned", "Timoshenko and Gere 1961, 2.1; first root of tan u = u, squared"),
            ("clamped", "Timoshenko and Gere 1961, 2.1; 4π²"),
        )
    ),
    Case(
        "Twisted shaft",
        THEME,
        "Both ends clamped, one free to twist and to slide, under an axial moment, half dead and half "
        "following; 1 mode of torsion and 12 of each bend. Two buckling modes at once.",
        "Greenhill 1883; Love 1927, 272; tan u = u with u = M L / (2 E I)",
        "exact",
        "critical moment × L / (E I)",
        lambda: [2.0 * exact.greenhill_root()],
        twisted,
        1e-6,
    ),
    Case(
        "Beams held at both ends",
        THEME,
        "Clamped and pinned, clamped and clamped; slenderness 1 / 10 000, 16 modes.",
        "Euler and Bernoulli; tan b = tanh b, cos b cosh b = 1",
        "exact",
        "first three ω / √(E I / (ρ A L⁴)) of each",
        lambda: np.concatenate(beam_frequencies()),
        vibrating,
        1e-5,
    ),
    Case(
        "Heavy beam between clamps",
        THEME,
        "ρ A g L³ / (E I) = 100, one clamp free to slide towards the other; 16 modes.",
        "Chebyshev collocation",
        "computed",
        "tip x/L, height of the middle / L",
        sag,
        heavy_beam,
        1e-6,
        scale=1.0,
    ),
)
