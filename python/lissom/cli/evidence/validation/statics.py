"""Equilibria of rods."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from ...._lissom import Load, Rod, Section, Segment
from . import exact
from .case import Answer, Array, Case
from .rods import (
    BENDING,
    GRAVITY,
    LENGTH,
    RADIUS,
    SHEAR,
    WEIGHTLESS,
    XZ,
    YOUNG,
    Plane,
    Points,
    at_rest,
    density_for,
    round_rod,
    tip,
)

THEME = "Statics"

#: Interval of reference points of a computed line in a plot.
EVERY = 4


def xz(rod: Rod, q: Array) -> Array:
    """Tip in the plane of bending."""
    return tip(rod, q)[[0, 2]]


# Roll-up


def roll_up() -> Answer:
    """One full turn with one constant mode."""
    rod = round_rod({"bend_y": 1}, tip_moment=(0.0, 2.0 * np.pi * BENDING / LENGTH, 0.0))
    turn = np.linspace(0.0, 2.0 * np.pi, 25)
    radius = LENGTH / (2.0 * np.pi)
    circle = ("circle", radius * np.sin(turn), radius * (np.cos(turn) - 1.0))
    return at_rest([("lissom", rod)], lambda rod, q: [*xz(rod, q), q[0] * LENGTH], lambda: [circle])


# Elastica

ELASTICA_LOADS = (1.0, 5.0, 10.0)


def elastica() -> Answer:
    """Tip forces of several magnitudes."""
    rods = [
        (
            f"lissom, α = {alpha:g}",
            round_rod({"bend_y": 10}, nodes=24, tip_force=(0.0, 0.0, -alpha * BENDING)),
        )
        for alpha in ELASTICA_LOADS
    ]
    return at_rest(rods, elastica_values, elastica_tips)


def elastica_tips() -> list[tuple[str, Array, Array]]:
    """Reference points of the plot."""
    tips = np.array([exact.elastica(alpha) for alpha in ELASTICA_LOADS])
    return [("tip by elliptic integrals", tips[:, 0], -tips[:, 1])]


def elastica_values(rod: Rod, q: Array) -> Array:
    """Tip and its angle: the mean curvature times the length."""
    x, z = xz(rod, q)
    return np.array([x, -z, q[0] * LENGTH])


# Magnetic rod

#: Magnetisation along the rod, A/m: that of silicone with particles of a neodymium alloy.
MAGNETISATION = 1e5


def magnetic_elastica() -> Answer:
    """Fields of several sizes, whose moments along a magnetised rod are those of a tip force."""
    moment = MAGNETISATION * np.pi * RADIUS**2
    segment = Segment(
        LENGTH,
        RADIUS,
        YOUNG,
        SHEAR,
        1000.0,
        {"bend_y": 10},
        nodes=24,
        magnetisation=(MAGNETISATION, 0.0, 0.0),
    )
    fields = [(alpha, -alpha * BENDING / LENGTH**2 / moment) for alpha in ELASTICA_LOADS]
    rods = [
        (f"lissom, α = {alpha:g}", Rod([segment], gravity=WEIGHTLESS, field=(0.0, 0.0, size)))
        for alpha, size in fields
    ]
    return at_rest(rods, elastica_values, elastica_tips)


# Heavy elastica

HEAVY_LOADS = (5.0, 20.0)


@cache
def heavy_shape(load: float) -> exact.PlanarShape:
    """Shape of a rod with the weight per length ``load`` E I / L^3."""
    return exact.planar_rod(LENGTH, np.ones_like, weight=lambda X: load + 0.0 * X)


def heavy_elastica() -> Answer:
    """Two weights."""
    rods = [
        (
            f"lissom, β = {load:g}",
            round_rod({"bend_y": 12}, nodes=28, density=density_for(load), gravity=(0.0, 0.0, -GRAVITY)),
        )
        for load in HEAVY_LOADS
    ]
    return at_rest(
        rods,
        xz,
        lambda: [planar_points(f"collocation, β = {load:g}", heavy_shape(load)) for load in HEAVY_LOADS],
    )


def planar_points(name: str, shape: exact.PlanarShape) -> tuple[str, Array, Array]:
    """Points of a computed shape for a plot."""
    return name, shape.x[::EVERY], shape.z[::EVERY]


def planar_tip(shape: exact.PlanarShape) -> list[float]:
    """Tip of a computed shape."""
    return [float(shape.x[-1]), float(shape.z[-1])]


# Lab wire

WIRE: dict[str, Any] = {
    "length": 1.0,
    "radius": 1e-3,
    "young_modulus": 210e9,
    "shear_modulus": 80e9,
    "density": 7800.0,
}


@cache
def wire_shape() -> exact.PlanarShape:
    """The wire under its own weight, by collocation."""
    stiffness = WIRE["young_modulus"] * np.pi / 4.0 * WIRE["radius"] ** 4
    weight = GRAVITY * WIRE["density"] * np.pi * WIRE["radius"] ** 2
    return exact.planar_rod(WIRE["length"], lambda X: stiffness + 0.0 * X, weight=lambda X: weight + 0.0 * X)


def lab_wire() -> Answer:
    """With enough modes for an exact shape."""
    rod = Rod([Segment(**WIRE, modes={"bend_y": 10})])
    return at_rest([("lissom", rod)], xz, lambda: [planar_points("collocation", wire_shape())])


def lab_wire_coordinates() -> Answer:
    """With the lab's three modes."""
    rod = Rod([Segment(**WIRE, modes={"bend_y": 3})])
    return at_rest(
        [("lissom, 3 modes", rod)], lambda rod, q: q, lambda: [planar_points("converged shape", wire_shape())]
    )


# 45-degree bend

BEND_RADIUS = 100.0
BEND_LENGTH = BEND_RADIUS * np.pi / 4.0
BEND_FORCES = (300.0, 450.0, 600.0)
#: Tip positions by force: Simo and Vu-Quoc (1986), A three-dimensional finite-strain rod model II.
BEND_PUBLISHED = {300.0: (58.84, 22.33, 40.08), 600.0: (47.23, 15.79, 53.37)}
#: A square of side 1 as a circle with the same ratio E A / E I; G J = G / 6 is its polar second moment.
BEND_SECTION_RADIUS = 1.0 / np.sqrt(3.0)
BEND_YOUNG, BEND_SHEAR, BEND_CORRECTION = 1e7, 5e6, 5.0 / 6.0
STRAINS = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")


@cache
def bend_shapes() -> tuple[Array, ...]:
    """Centre lines by shooting."""
    bending, shear = BEND_YOUNG / 12.0, BEND_CORRECTION * BEND_SHEAR
    return exact.space_rod(
        BEND_LENGTH,
        (BEND_SHEAR / 6.0, bending, bending, BEND_YOUNG, shear, shear),
        (0.0, 0.0, 1.0 / BEND_RADIUS),
        tuple((0.0, 0.0, force) for force in BEND_FORCES),
    )


def bend(forces: tuple[float, ...], points: Callable[[], Points]) -> Answer:
    """The bend under vertical tip forces."""
    area = np.pi * BEND_SECTION_RADIUS**2
    segment = Segment(
        BEND_LENGTH,
        BEND_SECTION_RADIUS,
        BEND_YOUNG / area,
        BEND_SHEAR / area,
        1.0,
        modes=dict.fromkeys(STRAINS, 8),
        reference_strain=(0.0, 0.0, 1.0 / BEND_RADIUS, 1.0, 0.0, 0.0),
        shear_correction=BEND_CORRECTION,
        nodes=24,
    )
    rods = [
        (f"lissom, {force:g}", Rod([segment], gravity=WEIGHTLESS, tip_force=(0.0, 0.0, force)))
        for force in forces
    ]
    return at_rest(rods, tip, points)


def bend_published() -> Answer:
    """The two forces of the publication."""
    tips = np.array(list(BEND_PUBLISHED.values()))
    return bend(tuple(BEND_PUBLISHED), lambda: [("tips, Simo and Vu-Quoc", *XZ.of(tips))])


def bend_computed() -> Answer:
    """All forces."""
    return bend(
        BEND_FORCES,
        lambda: [
            (f"shooting, {force:g}", *XZ.of(line[:: 2 * EVERY]))
            for force, line in zip(BEND_FORCES, bend_shapes(), strict=True)
        ],
    )


# Timoshenko cantilever

THICK: dict[str, float] = {"length": 3.0, "radius": 0.25, "young_modulus": 1e6, "shear_modulus": 1e4}
THICK_FORCE = -15.0
#: Shear correction of a circle in that case (Gazzola and others 2018).
THICK_CORRECTION = 27.0 / 28.0


def thick_stiffness() -> tuple[float, float, float]:
    """E I, E A and k G A."""
    area = np.pi * THICK["radius"] ** 2
    return (
        THICK["young_modulus"] * area * THICK["radius"] ** 2 / 4.0,
        THICK["young_modulus"] * area,
        THICK_CORRECTION * THICK["shear_modulus"] * area,
    )


def thick_deflection(X: Array) -> Array:
    """Timoshenko's linear theory."""
    EI, _, GA = thick_stiffness()
    return np.asarray(THICK_FORCE * (X / GA + X**2 * (3.0 * THICK["length"] - X) / (6.0 * EI)))


@cache
def thick_shape() -> exact.PlanarShape:
    """The same without linearisation."""
    EI, EA, GA = thick_stiffness()
    return exact.planar_rod(
        THICK["length"], lambda X: EI + 0.0 * X, force=(0.0, THICK_FORCE), EA=EA, GA=GA, degree=24
    )


def thick(values: Any) -> Answer:
    """A beam with shear as large as bending."""
    modes = {"bend_y": 4, "stretch": 4, "shear_z": 4}
    # Poisson's ratio would be 49, which no isotropic material has: use a section with given properties.
    EI, EA, GA = thick_stiffness()
    GJ = THICK["shear_modulus"] * 2.0 * EI / THICK["young_modulus"]
    section = Section.given((GJ, EI, EI, EA, GA, GA), mass=5000.0 * np.pi * THICK["radius"] ** 2)
    segment = Segment(THICK["length"], section=section, modes=modes)
    rod = Rod([segment], gravity=WEIGHTLESS, tip_force=(0.0, 0.0, THICK_FORCE))
    X = np.linspace(0.0, THICK["length"], 25)
    return at_rest([("lissom", rod)], values, lambda: [("linear theory", X, thick_deflection(X))])


# Helix

HELIX_MOMENT = (3.0 * BENDING, 0.0, 12.0 * BENDING)


def helix() -> Answer:
    """End moments that bend and twist."""
    rod = round_rod({"torsion": 1, "bend_y": 14, "bend_z": 14}, nodes=40, tip_moment=HELIX_MOMENT)
    line = exact.helix(HELIX_MOMENT, BENDING, np.linspace(0.0, LENGTH, 49))
    plane = Plane(("x", "y"))
    return at_rest([("lissom", rod)], tip, lambda: [("helix", *plane.of(line))], plane)


# Catenary

#: Weight and horizontal force of the rope in units of E I / L^2 of the rod: large enough for the rod to be
#: nearly a rope.
ROPE_WEIGHT = 1e4
ROPE_PULL = 0.5 * ROPE_WEIGHT


def rope() -> Answer:
    """Clamped in the direction of the rope, with the rope's end force at the tip."""
    slope = -0.5 * ROPE_WEIGHT / ROPE_PULL
    half = -0.5 * np.arctan(slope)
    rod = round_rod(
        {"bend_y": 16},
        nodes=40,
        density=density_for(ROPE_WEIGHT),
        gravity=(0.0, 0.0, -GRAVITY),
        base_orientation=(np.cos(half), 0.0, np.sin(half), 0.0),
        tip_force=(ROPE_PULL * BENDING, 0.0, 0.5 * ROPE_WEIGHT * BENDING),
    )
    x, z = rope_shape(np.linspace(0.0, LENGTH, 25))
    return at_rest([("lissom", rod)], xz, lambda: [("catenary", x, z)])


def rope_shape(X: Array) -> tuple[Array, Array]:
    """The catenary."""
    return exact.catenary(ROPE_WEIGHT, ROPE_PULL, X)


# Follower force

FOLLOWED: dict[str, float] = {"EI": 3.5e7, "EA": 4.2e8, "GA": 1.61538e8, "length": 100.0}
FOLLOWER_FORCES = (30e3, 60e3, 130e3)


@cache
def followed_shape(force: float) -> exact.PlanarShape:
    """Shape by collocation."""
    return exact.planar_rod(
        FOLLOWED["length"],
        lambda X: FOLLOWED["EI"] + 0.0 * X,
        force=(0.0, force),
        follows=True,
        EA=FOLLOWED["EA"],
        GA=FOLLOWED["GA"],
    )


def follower() -> Answer:
    """A force that remains normal to the tip's section."""
    radius = np.sqrt(4.0 * FOLLOWED["EI"] / FOLLOWED["EA"])
    area = np.pi * radius**2
    modes = {"bend_y": 16, "stretch": 12, "shear_z": 12}
    segment = Segment(
        FOLLOWED["length"], radius, FOLLOWED["EA"] / area, FOLLOWED["GA"] / area, 1.0, modes=modes, nodes=40
    )
    rods = [
        (
            f"lissom, {force / 1e3:g} kN",
            Rod([segment], gravity=WEIGHTLESS, loads=[Load(force=(0.0, 0.0, force), frame="body")]),
        )
        for force in FOLLOWER_FORCES
    ]
    return at_rest(
        rods,
        xz,
        lambda: [
            planar_points(f"collocation, {force / 1e3:g} kN", followed_shape(force))
            for force in FOLLOWER_FORCES
        ],
    )


# Right-angle frame

#: Tip force in units of E I / L^2: small enough that errors of linear theory, which are quadratic, are
#: negligible.
FRAME_FORCE = 1e-4
#: Length of the rigid corner in metres: negligible.
CORNER = 1e-9


def frame() -> Answer:
    """Two legs with a force normal to their plane: the first leg twists."""
    leg = Segment(LENGTH, 0.01, 1e9, 4e8, 1000.0, modes={"torsion": 2, "bend_y": 4, "bend_z": 2})
    corner = Segment(
        CORNER,
        0.01,
        1e9,
        4e8,
        1000.0,
        modes={},
        reference_strain=(0.0, 0.0, 0.5 * np.pi / CORNER, 1.0, 0.0, 0.0),
    )
    rod = Rod([leg, corner, leg], gravity=WEIGHTLESS, tip_force=(0.0, 0.0, FRAME_FORCE * BENDING))
    X = np.linspace(0.0, LENGTH, 13)
    y, z = frame_second_leg(X)
    plane = Plane(("y", "z"))
    answer = at_rest(
        [("lissom", rod)], lambda rod, q: tip(rod, q)[2], lambda: [("linear theory", y, z)], plane
    )
    # Such small deflections are not visible to scale.
    return replace(answer, plot=lambda: replace(answer.plot(), to_scale=False))


def frame_second_leg(X: Array) -> tuple[Array, Array]:
    """Linear theory: both legs bend, the first one twists by P L^2 / (G J), and G J = 0.8 E I here."""
    ends = FRAME_FORCE * (1.0 / 3.0 + X / 0.8 + X**2 * (3.0 - X) / 6.0)
    return X, ends


CASES = (
    Case(
        "Roll-up to a circle",
        THEME,
        "A rod under the tip moment 2 π E I / L, with one constant mode.",
        "Euler 1744; exact circle",
        "exact",
        "tip x, z (m); curvature × L",
        lambda: [0.0, 0.0, 2.0 * np.pi],
        roll_up,
        1e-10,
        scale=1.0,
    ),
    Case(
        "Elastica",
        THEME,
        "Inextensible cantilever under dead tip forces α E I / L², α = 1, 5, 10; 10 modes.",
        "Bisshopp and Drucker 1945, elliptic integrals",
        "exact",
        "x/L, deflection/L, tip angle for each",
        lambda: [value for alpha in ELASTICA_LOADS for value in exact.elastica(alpha)],
        elastica,
        1e-7,
        scale=1.0,
    ),
    Case(
        "Magnetic rod",
        THEME,
        "Inextensible cantilever, magnetised along itself, in a uniform field B across it, "
        "M A B L² / (E I) = α = 1, 5, 10; 10 modes.",
        "Wang, Kim, Guo and Zhao 2020, hard-magnetic elastica; elliptic integrals",
        "exact",
        "x/L, deflection/L, tip angle for each",
        lambda: [value for alpha in ELASTICA_LOADS for value in exact.elastica(alpha)],
        magnetic_elastica,
        1e-7,
        scale=1.0,
    ),
    Case(
        "Heavy elastica",
        THEME,
        "Inextensible cantilever under its own weight β E I / L³ per length, β = 5, 20; 12 modes.",
        "Chebyshev collocation",
        "computed",
        "tip x, z for each (m)",
        lambda: [value for load in HEAVY_LOADS for value in planar_tip(heavy_shape(load))],
        heavy_elastica,
        1e-8,
        scale=1.0,
    ),
    Case(
        "Lab wire, sagging",
        THEME,
        "Steel wire, L = 1 m, radius 1 mm, E = 210 GPa, 7800 kg/m³, held out horizontally; 10 modes.",
        "Chebyshev collocation",
        "computed",
        "tip x, z (m)",
        lambda: planar_tip(wire_shape()),
        lab_wire,
        1e-9,
    ),
    Case(
        "Lab wire, 3 modes",
        THEME,
        "The same wire with the lab's three modes of bending.",
        "Independent Galerkin solution",
        "computed",
        "coordinates (rad/m)",
        lambda: [0.238212308, -0.3585635333, 0.1214608904],
        lab_wire_coordinates,
        1e-9,
    ),
    Case(
        "45-degree bend, published",
        THEME,
        "R = 100, section 1 × 1, E = 1e7, G = 5e6, dead tip force 300 and 600 normal to its plane. "
        "Torsion constant G J = G/6 (the polar second moment; Saint-Venant's would be 0.1406 G), shear "
        "correction 5/6; 8 modes a strain. Publications differ by up to 0.6.",
        "Simo and Vu-Quoc 1986, example 7.5",
        "published",
        "tip x, y, z for each",
        lambda: np.ravel(list(BEND_PUBLISHED.values())),
        bend_published,
        2e-3,
        scale=BEND_RADIUS,
    ),
    Case(
        "45-degree bend, recomputed",
        THEME,
        "The same at 300, 450 and 600 beside the same equations solved by shooting.",
        "Reissner-Simo equations, Runge-Kutta shooting",
        "computed",
        "tip x, y, z for each",
        lambda: np.concatenate([line[-1] for line in bend_shapes()]),
        bend_computed,
        1e-6,
        scale=BEND_RADIUS,
    ),
    Case(
        "Timoshenko cantilever, linear",
        THEME,
        "L = 3, radius 0.25, E = 1e6, G = 1e4, shear correction 27/28, tip force −15. Linear theory "
        "leaves out the square of the slope, 0.002 here.",
        "Timoshenko 1921; case of Gazzola and others 2018",
        "exact",
        "deflection of the tip (m)",
        lambda: [float(thick_deflection(np.array(THICK["length"])))],
        lambda: thick(lambda rod, q: tip(rod, q)[2]),
        2e-3,
    ),
    Case(
        "Timoshenko cantilever",
        THEME,
        "The same beam without linearisation. Its Poisson's ratio of 49 is no isotropic material's, so the "
        "stiffness of its section is given.",
        "Reissner's equations, Chebyshev collocation",
        "computed",
        "tip x, z (m)",
        lambda: planar_tip(thick_shape()),
        lambda: thick(xz),
        1e-9,
    ),
    Case(
        "Helix",
        THEME,
        "Straight round rod under the tip moment (3, 0, 12) E I / L, fixed in space: two turns of a "
        "helix; 14 modes of bending each way.",
        "Kirchhoff 1859, closed form",
        "exact",
        "tip x, y, z (m)",
        lambda: exact.helix(HELIX_MOMENT, BENDING, np.array([LENGTH]))[0],
        helix,
        1e-7,
        scale=1.0,
    ),
    Case(
        "Catenary limit",
        THEME,
        "A rod so heavy that it is nearly a rope: w = 10⁴ E I / L³. Clamped in the direction of a "
        "catenary's end, with the pull of its other end as a tip force. A rod differs from a rope by about "
        "E I / (H L²) there; 16 modes.",
        "Leibniz and Bernoulli 1691, limit of no stiffness",
        "exact",
        "tip x, z (m)",
        lambda: np.ravel(rope_shape(np.array([0.0, LENGTH])))[[1, 3]],
        rope,
        1e-3,
        scale=1.0,
    ),
    Case(
        "Follower force",
        THEME,
        "L = 100, E I = 3.5e7, G A = 1.61538e8, E A = 4.2e8; 30, 60 and 130 kN at the tip, always normal "
        "to its section; 16 modes of bending, 12 of stretch and of shear.",
        "Case of Simo and Vu-Quoc 1986, example 7.2; Chebyshev collocation",
        "computed",
        "tip x, z for each (m)",
        lambda: [value for force in FOLLOWER_FORCES for value in planar_tip(followed_shape(force))],
        follower,
        1e-6,
        scale=FOLLOWED["length"],
    ),
    Case(
        "Right-angle frame",
        THEME,
        "Two legs of 1 m at 90 degrees (the corner is a rigid arc of 1 nm), a small force normal to their "
        "plane: both bend, the first one twists.",
        "Linear beam theory, P L³ (2 / (3 E I) + 1 / (G J))",
        "exact",
        "deflection of the tip (m)",
        lambda: [float(frame_second_leg(np.array(LENGTH))[1])],
        frame,
        1e-6,
    ),
)
