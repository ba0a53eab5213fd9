"""Rods from very thin to very thick, soft to stiff, light to heavy, with few or many modes and segments."""

from __future__ import annotations

from functools import partial

from . import analyses, rods
from .cell import Group

SLENDERNESS = (5, 10, 50, 100, 500, 1000, 5000)
MODULI = (1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12)
DENSITIES = (1.0, 10.0, 100.0, 1e3, 5e3, 2e4)
TAPERS = (2, 5, 10, 50, 100)
MODES = (1, 2, 3, 5, 8, 12, 16, 20)
SEGMENTS = (1, 2, 4, 8, 16, 32, 64)
TIP_MASSES = (1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6)
THIN_RADII = (1e-3, 1e-4, 1e-5)

COLUMNS = "analysis"


def slenderness() -> Group:
    """Ratio of length to radius; all planar strains."""
    made = [(f"{ratio:g}", partial(rods.rod, radius=1.0 / ratio)) for ratio in SLENDERNESS]
    return Group(
        "slenderness",
        "Slenderness",
        "length / radius",
        COLUMNS,
        analyses.cells(made, quick=["50"]),
        "A rod of one metre, E = 10 MPa, that bends, stretches and shears. " + analyses.TEXT,
    )


def modulus() -> Group:
    """Young's modulus; all planar strains."""
    made = [(f"{E:.0e}", partial(rods.rod, young_modulus=E)) for E in MODULI]
    return Group(
        "modulus",
        "Young's modulus",
        "E (Pa)",
        COLUMNS,
        analyses.cells(made, quick=["1e+07"]),
        "The same rod, 2 cm in radius, from jelly to diamond. " + analyses.TEXT,
    )


def density() -> Group:
    """Density; all planar strains."""
    made = [(f"{rho:g}", partial(rods.rod, density=rho)) for rho in DENSITIES]
    return Group(
        "density", "Density", "density (kg/m³)", COLUMNS, analyses.cells(made, quick=["1"]), analyses.TEXT
    )


def taper() -> Group:
    """Ratio of the radii at base and tip."""
    made = [(f"1:{ratio}", partial(rods.rod, radius=(0.02, 0.02 / ratio))) for ratio in TAPERS]
    return Group(
        "taper", "Taper", "radius of tip : base", COLUMNS, analyses.cells(made, quick=["1:10"]), analyses.TEXT
    )


def modes() -> Group:
    """Number of bending modes."""
    made = [(str(count), partial(rods.rod, rods.BENDING, modes={"bend_y": count})) for count in MODES]
    return Group(
        "modes",
        "Modes of one strain",
        "bending modes",
        COLUMNS,
        analyses.cells(made, quick=["8"]),
        "The tip is compared on the same modes: how many a rod needs is another question. " + analyses.TEXT,
    )


def segments() -> Group:
    """Number of segments."""
    made = [(str(count), partial(rods.chain, count, {"bend_y": 2})) for count in SEGMENTS]
    return Group(
        "segments",
        "Segments",
        "segments of two bending modes",
        COLUMNS,
        analyses.cells(made, quick=["4"]),
        analyses.TEXT,
    )


def masses() -> Group:
    """Nearly singular mass matrices."""
    heavy = [
        (f"tip mass {mass:g} kg", partial(rods.rod, rods.BENDING, of_rod={"tip_mass": mass}))
        for mass in TIP_MASSES
    ]
    twisting = {"torsion": 2, "bend_y": 2, "bend_z": 2}
    thin = [
        (
            f"radius {radius:g} m, twisting",
            partial(rods.rod, radius=radius, modes=twisting, young_modulus=1e11),
        )
        for radius in THIN_RADII
    ]
    return Group(
        "masses",
        "Nearly singular mass matrices",
        "what makes them so",
        COLUMNS,
        analyses.cells([*heavy, *thin], quick=["tip mass 1e-09 kg", "tip mass 1000 kg"]),
        "Masses at the tip beside a rod of 1.3 kg; wires whose inertia of twisting is next to nothing. "
        + analyses.TEXT,
    )
