"""A rotor blade with a swept tip, whose frequencies were measured."""

from __future__ import annotations

import numpy as np

from ...._lissom import Harmonic, Link, Revolute, Robot, Section, Segment, modes, statics
from .case import Answer, Array, Case, Curve, Plot
from .exact_space import hubbed_blade
from .rods import WEIGHTLESS
from .statics import CORNER

THEME = "Rotor with a swept tip"

#: Epps and Chandra (1996), The natural frequencies of rotating composite beams with tip sweep, Journal of
#: the American
#: Helicopter Society 41, as GXBeam has it (docs/src/literate/rotating.jl, MIT); inches, pounds, seconds.
#: Hub, straight
#: part, swept part; width and thickness of the section.
HUB, STRAIGHT, TIP, WIDTH, THICKNESS = 2.5, 31.5, 6.0, 1.0, 0.063
YOUNG, POISSON, DENSITY = 1.06e7, 0.325, 2.51e-4
#: Reduction of shear along the width and the thickness, and of torsion.
SHEAR_WIDTH, SHEAR_THICKNESS, TORSION = 1.2000001839588001, 14.625127919304001, 65.85255016982444

AREA = WIDTH * THICKNESS
FLAP, LAG = WIDTH * THICKNESS**3 / 12.0, WIDTH**3 * THICKNESS / 12.0
RIGIDITY = YOUNG / (2.0 * (1.0 + POISSON))
STIFFNESS = (
    RIGIDITY * (FLAP + LAG) / TORSION,
    YOUNG * FLAP,
    YOUNG * LAG,
    YOUNG * AREA,
    RIGIDITY * AREA / SHEAR_WIDTH,
    RIGIDITY * AREA / SHEAR_THICKNESS,
)

SWEEPS, SPEEDS = (0.0, 15.0, 30.0, 45.0), (0.0, 500.0, 750.0)
#: Measured frequencies (Hz) by sweep and speed of the first three modes of flapping, and at 750 revolutions
#: a minute
#: those of the fourth, which is coupled with torsion, and of two more.
MEASURED = (
    ((1.4, 10.2, 14.8), (1.8, 10.1, 14.4), (1.7, 10.2, 14.9), (1.6, 10.2, 14.7)),
    ((10.3, 25.2, 36.1), (10.2, 25.2, 34.8), (10.4, 23.7, 30.7), (10.4, 21.6, 26.1)),
    ((27.7, 47.0, 62.9), (27.2, 44.4, 55.9), (26.6, 39.3, 48.6), (24.8, 35.1, 44.8)),
)
MEASURED_HIGH = ((95.4, 106.6, 132.7), (87.5, 120.1, 147.3), (83.7, 122.6, 166.2), (78.8, 117.7, 162.0))


def blade(sweep: float, speed: float) -> Robot:
    """The blade on its hub; degrees and revolutions a minute."""
    inertia = DENSITY * np.array([FLAP + LAG, FLAP, LAG])
    section = Section.given(STIFFNESS, mass=DENSITY * AREA, inertia=inertia)
    strains = {"torsion": 6, "bend_y": 8, "bend_z": 8, "stretch": 3, "shear_y": 4, "shear_z": 4}
    rod = [Segment(STRAIGHT, section=section, modes=strains)]
    if sweep:
        turn = (0.0, 0.0, -np.radians(sweep) / CORNER, 1.0, 0.0, 0.0)
        rod.append(Segment(CORNER, section=section, modes={}, reference_strain=turn))
    strains = {"torsion": 4, "bend_y": 5, "bend_z": 5, "stretch": 2, "shear_y": 3, "shear_z": 3}
    rod.append(Segment(TIP, section=section, modes=strains))
    turning = Revolute((0.0, 0.0, 1.0), motion=Harmonic(rate=speed * 2.0 * np.pi / 60.0))
    hub = Link("hub", joint=turning)
    return Robot([hub, Link("blade", parent="hub", position=(HUB, 0.0, 0.0), rod=rod)], gravity=WEIGHTLESS)


def flapping_frequencies(sweep: float, speed: float, count: int) -> tuple[float, ...]:
    """Frequencies (Hz) of the modes out of the plane of rotation, which are not coupled to those in it."""
    model = blade(sweep, speed)
    rest = statics(model)
    if not rest.success:
        raise ArithmeticError(rest.message)
    found = modes(model, rest.q)
    strains = [name.split(".")[-1].split("[")[0] for name in model.coordinates]
    out = np.isin(strains, ("torsion", "bend_y", "shear_z"))
    sizes = np.abs(found.shapes) ** 2
    return tuple(found.frequency[sizes[out].sum(axis=0) > 0.5 * sizes.sum(axis=0)][:count])


def flapping() -> Answer:
    """The first three modes, in the order of the measured ones."""
    found = np.array(
        [[flapping_frequencies(sweep, speed, 6)[:3] for speed in SPEEDS] for sweep in SWEEPS]
    ).transpose(2, 0, 1)

    def plot() -> Plot:
        curves = []
        for mode in range(3):
            for i, speed in enumerate(SPEEDS):
                name = f"mode {mode + 1}, {speed:.0f} rpm"
                curves.append(Curve(name, SWEEPS, found[mode][:, i]))
                curves.append(
                    Curve(f"measured, {name}", SWEEPS, np.array(MEASURED[mode])[:, i], joined=False)
                )
        return Plot("sweep (degrees)", "frequency (Hz)", curves)

    return Answer(found.ravel(), plot)


def high() -> Answer:
    """The fourth to sixth mode at the largest speed."""
    found = np.array([flapping_frequencies(sweep, SPEEDS[-1], 6)[3:] for sweep in SWEEPS])

    def plot() -> Plot:
        curves = []
        for mode in range(3):
            curves.append(Curve(f"mode {mode + 4}", SWEEPS, found[:, mode]))
            curves.append(
                Curve(f"measured, {mode + 4}", SWEEPS, np.array(MEASURED_HIGH)[:, mode], joined=False)
            )
        return Plot("sweep (degrees)", "frequency (Hz)", curves)

    return Answer(found.ravel(), plot)


def straight_wanted() -> Array:
    """First three frequencies (Hz) of the straight blade at all speeds."""
    length, mass = STRAIGHT + TIP, DENSITY * AREA
    return np.concatenate(
        [
            hubbed_blade(YOUNG * FLAP, mass, length, HUB, speed * 2.0 * np.pi / 60.0, 3) / (2.0 * np.pi)
            for speed in SPEEDS
        ]
    )


def straight() -> Answer:
    """The blade without sweep."""
    found = np.array([flapping_frequencies(0.0, speed, 6)[:3] for speed in SPEEDS])
    wanted = straight_wanted().reshape(found.shape)

    def plot() -> Plot:
        curves = []
        for mode in range(3):
            curves.append(Curve(f"mode {mode + 1}", SPEEDS, found[:, mode]))
            curves.append(Curve(f"theory, {mode + 1}", SPEEDS, wanted[:, mode], joined=False))
        return Plot("revolutions a minute", "frequency (Hz)", curves)

    return Answer(found.ravel(), plot)


BLADE = (
    "Aluminium, 1 x 0.063 inches, 31.5 inches straight from a hub of 2.5 inches and 6 inches swept by 0, 15, "
    "30 and 45 degrees, at 0, 500 and 750 revolutions a minute"
)

CASES = (
    Case(
        "Rotor, straight blade",
        THEME,
        "The blade below without sweep: 31.5 + 6 inches on a hub of 2.5 inches; 8 modes of bending.",
        "Slender blade with centrifugal force, Ritz's method",
        "computed",
        "first three frequencies of flapping at each speed (Hz)",
        straight_wanted,
        straight,
        1e-3,
    ),
    Case(
        "Rotor, first modes, measured",
        THEME,
        f"{BLADE}. The theory of a straight slender blade, above, is as far off the first measured mode: "
        f"9.2 Hz "
        "where 10.2 were measured.",
        "Epps and Chandra 1996, measured, as GXBeam has it",
        "published",
        "first three frequencies of flapping, each by sweep and speed (Hz)",
        lambda: np.ravel(MEASURED),
        flapping,
        7e-2,
    ),
    Case(
        "Rotor, coupled modes, measured",
        THEME,
        "The same at 750 revolutions a minute: the fourth to sixth mode, of flapping and of torsion, which "
        "the "
        "sweep couples.",
        "Epps and Chandra 1996, measured, as GXBeam has it",
        "published",
        "fourth to sixth frequency by sweep (Hz)",
        lambda: np.ravel(MEASURED_HIGH),
        high,
        4e-2,
    ),
)
