"""Critical loads of straight rods, and their behaviour beyond."""

from __future__ import annotations

import numpy as np

from ...._lissom import Load, Rod, Section, Segment, continuation, modes
from . import exact
from .case import Answer, Array, Case, Curve, Plot
from .rods import BENDING, GRAVITY, LENGTH, SHEAR, WEIGHTLESS, YOUNG, at_rest, density_for, round_rod, tip

THEME = "Buckling"

EULER = 0.25 * np.pi**2 * BENDING / LENGTH**2


def lowest_eigenvalues(rod: Rod, load: float, name: str) -> Answer:
    """First critical load of a rod under ``load``, and the stability along its path."""
    path = continuation(rod).path
    if not path.critical_points:
        return Answer([np.nan], _nothing, "no critical point was found")
    critical = load * path.critical_points[0].load_factor

    def plot() -> Plot:
        return Plot(
            name,
            "lowest eigenvalue, relative",
            [
                Curve("lissom", load * path.load_factor, path.lowest_eigenvalue),
                Curve("critical point by lissom", [critical], [0.0], joined=False),
            ],
        )

    return Answer([critical], plot)


def _nothing() -> Plot:
    return Plot("", "", [])


def euler() -> Answer:
    """A column under an axial force."""
    rod = round_rod({"bend_y": 8}, nodes=24, tip_force=(-2.0 * EULER, 0.0, 0.0))
    return lowest_eigenvalues(rod, 2.0 * EULER * LENGTH**2 / BENDING, "P L² / (E I)")


def standing() -> Answer:
    """A column under its own weight."""
    rod = round_rod(
        {"bend_y": 10},
        nodes=28,
        density=density_for(12.0),
        # Upright with gravity along -x: a base rotated by 90 degrees would be inclined by a rounding error,
        # and the column would lean to that side without a bifurcation.
        gravity=(-GRAVITY, 0.0, 0.0),
    )
    return lowest_eigenvalues(rod, 12.0, "ρ A g L³ / (E I)")


# Deep narrow beam

#: Ten times as high as wide, along body z; tip force in units of sqrt(E I_z G J_t) / L^2.
DEEP = Section.rectangle(width=0.01, height=0.1)
DEEP_FORCE = 8.0


def sideways() -> Answer:
    """A cantilever loaded in its stiff plane."""
    segment = Segment(
        LENGTH,
        section=DEEP,
        young_modulus=YOUNG,
        shear_modulus=SHEAR,
        density=1000.0,
        modes={"torsion": 10, "bend_z": 10},
        nodes=28,
    )
    twist, _, bend, *_ = np.diag(segment.stiffness())
    force = (0.0, 0.0, -DEEP_FORCE * np.sqrt(twist * bend) / LENGTH**2)
    rod = Rod([segment], gravity=WEIGHTLESS, tip_force=force)
    return lowest_eigenvalues(rod, DEEP_FORCE, "P L² / √(E I_z G J_t)")


# Buckled columns

RATIOS = (1.1, 1.5, 3.0)


def buckled() -> Answer:
    """Columns buckled to one side."""
    rods = [
        (
            f"lissom, P / P_E = {ratio:g}",
            round_rod({"bend_y": 10}, nodes=28, tip_force=(-ratio * EULER, 0.0, 0.0)),
        )
        for ratio in RATIOS
    ]
    return at_rest(rods, buckled_values, buckled_tips, starts=lambda rod: 1e-2 * np.eye(rod.n)[0])


def buckled_values(rod: Rod, q: Array) -> Array:
    """Tip position, deflection and tip angle."""
    x, _, z = tip(rod, q)
    return np.array([x, -z, q[0] * LENGTH])


def buckled_tips() -> list[tuple[str, Array, Array]]:
    """Reference points of the plot."""
    tips = np.array([exact.buckled_column(ratio) for ratio in np.linspace(1.001, 3.5, 40)])
    return [("tips by elliptic integrals", tips[:, 0], -tips[:, 1])]


# Beck's column

#: Slender, so that rotary inertia is negligible.
BECK_RADIUS, BECK_YOUNG, BECK_DENSITY, BECK_MODES = 1e-4, 1e9, 1000.0, 10
BECK_BENDING = BECK_YOUNG * np.pi / 4.0 * BECK_RADIUS**4

#: Range of the critical load in units of E I / L^2, and final width of the bisection.
BECK_LOADS = (15.0, 25.0)
BECK_WIDTH = 1e-8


def beck(load: float) -> Rod:
    """A cantilever under a follower force of ``load`` E I / L^2 at its tip."""
    segment = Segment(
        LENGTH,
        BECK_RADIUS,
        BECK_YOUNG,
        0.4 * BECK_YOUNG,
        BECK_DENSITY,
        {"bend_y": BECK_MODES},
        nodes=28,
    )
    force = (-load * BECK_BENDING / LENGTH**2, 0.0, 0.0)
    return Rod([segment], gravity=WEIGHTLESS, loads=[Load(force=force, frame="body")])


def flutter() -> Answer:
    """Load at which the straight column begins to flutter, from its modes."""
    low, high = BECK_LOADS
    while high - low > BECK_WIDTH:
        middle = 0.5 * (low + high)
        rod = beck(middle)
        if modes(rod, np.zeros(rod.n)).is_stable:
            low = middle
        else:
            high = middle

    def plot() -> Plot:
        loads = np.linspace(0.0, 25.0, 126)
        unit = np.sqrt(BECK_BENDING / (BECK_DENSITY * np.pi * BECK_RADIUS**2)) / LENGTH**2
        slowest = [modes(beck(p), np.zeros(BECK_MODES)) for p in loads]
        pair = np.array([np.sort(found.angular_frequency)[:2] for found in slowest]) / unit
        growth = np.array([max(found.eigenvalues.real.max(), 0.0) for found in slowest]) / unit
        return Plot(
            "P L² / (E I)",
            "in √(E I / (ρ A L⁴))",
            [
                Curve("first frequency by lissom", loads, pair[:, 0]),
                Curve("second frequency by lissom", loads, pair[:, 1]),
                Curve("rate of growth by lissom", loads, growth),
                Curve("Beck's load", [exact.becks_column()], [0.0], joined=False),
            ],
        )

    return Answer([0.5 * (low + high)], plot)


CASES = (
    Case(
        "Euler column",
        THEME,
        "Clamped and free, inextensible, straight; 8 modes. The bifurcation on the path of loading.",
        "Euler 1744, π²/4",
        "exact",
        "buckling load × L² / (E I)",
        lambda: [0.25 * np.pi**2],
        euler,
        1e-9,
    ),
    Case(
        "Buckled columns",
        THEME,
        "The same column under 1.1, 1.5 and 3 times its Euler load, let go from 1/100 rad to one side; 10 "
        "modes.",
        "Timoshenko and Gere 1961, 2.7, elliptic integrals",
        "exact",
        "x/L, deflection/L, tip angle for each",
        lambda: [value for ratio in RATIOS for value in exact.buckled_column(ratio)],
        buckled,
        1e-7,
        scale=1.0,
    ),
    Case(
        "Standing column",
        THEME,
        "Clamped upright, under its own weight alone; 10 modes.",
        "Greenhill 1881, first zero of a Bessel function",
        "exact",
        "critical ρ A g L³ / (E I)",
        lambda: [exact.self_buckling()],
        standing,
        1e-9,
    ),
    Case(
        "Deep narrow beam",
        THEME,
        "A cantilever with a rectangular section, ten times as high as wide, under a force at the tip in its "
        "stiff plane, in which it is rigid. It tips over sideways; 10 modes of torsion and of bending.",
        "Prandtl 1899, first zero of a Bessel function",
        "exact",
        "critical P L² / √(E I_z G J_t)",
        lambda: [exact.lateral_buckling()],
        sideways,
        1e-9,
    ),
    Case(
        "Beck's column",
        THEME,
        "A cantilever under a compressive force that follows its tip has no buckled equilibrium: it "
        "flutters. 10 modes, slenderness 1 / 10 000.",
        "Beck 1952, double root of the frequency equation",
        "exact",
        "flutter load × L² / (E I)",
        lambda: [exact.becks_column()],
        flutter,
        1e-6,
    ),
)
