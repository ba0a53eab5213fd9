"""Rods in space under random loads, beside shapes that SoRoSim computed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...._lissom import Load, Rod, Segment
from .case import Answer, Array, Case
from .rods import Plane, at_rest, tip

THEME = "Beside SoRoSim"

#: Modes of each of two segments.
MODES = {"torsion": 4, "bend_y": 8, "bend_z": 8}


@dataclass(frozen=True)
class Bank:
    """A round rod along x, clamped, and samples of its bank: gravity, m/s^2; moment and force at the middle,
    moment and force at the tip, in axes of the world, N m and N; place of the tip, m."""

    name: str
    length: float
    radius: float
    young: float
    poisson: float
    density: float
    samples: tuple[tuple[float, ...], ...]


#: Every hundredth shape of data/reference/sorosim/sorosim_statics in ContinuumRoboticsLab/opencr-mujoco
#: (MIT), as printed there, to four decimals.
STEEL = Bank(
    "steel",
    0.6,
    0.0008,
    200e9,
    0.33,
    7870.0,
    (
        (
            *(-5.8693, -6.145, -4.9017, 0.0117, 0.0724, 0.032, -0.0606, 0.0297, 0.1883),
            *(-0.0582, 0.018, -0.0518, -0.1742, 0.0763, 0.0618, 0.5669, -0.0666, -0.1519),
        ),
        (
            *(7.6852, 5.7509, -2.0249, 0.0275, -0.0482, -0.0576, -0.146, 0.1064, -0.0859),
            *(0.0499, 0.0229, 0.0582, 0.1585, -0.0314, -0.1179, 0.5863, 0.0607, -0.0889),
        ),
        (
            *(-6.5503, -5.2162, 5.1109, -0.0337, 0.0706, 0.0168, 0.144, 0.1181, 0.0729),
            *(-0.0315, 0.0225, 0.07, 0.1141, -0.0688, 0.1492, 0.5779, 0.1371, -0.0168),
        ),
        (
            *(4.0749, 8.4702, -2.8083, -0.0464, 0.0646, -0.0081, 0.1018, -0.1534, -0.078),
            *(0.052, -0.0502, -0.0343, -0.1628, 0.0022, -0.1162, 0.5376, -0.1265, -0.2111),
        ),
        (
            *(9.3977, -1.8585, -2.1132, -0.0744, 0.0213, -0.0202, -0.0946, -0.1022, 0.1436),
            *(-0.0089, -0.0704, 0.037, -0.0017, -0.1497, 0.1327, 0.4969, -0.0817, 0.2871),
        ),
    ),
)
PLASTIC = Bank(
    "plastic",
    0.4,
    0.005,
    70e6,
    0.4,
    1200.0,
    (
        (
            *(-3.9137, 8.3341, 3.3855, -0.058, 0.0069, -0.0138, -0.1644, 0.2252, 0.1107),
            *(0.0466, 0.0112, -0.0361, -0.1519, 0.2078, 0.154, 0.3381, 0.1518, 0.1286),
        ),
        (
            *(-6.3383, 7.4859, -0.1544, 0.0529, 0.0255, -0.0125, 0.248, -0.0368, 0.1647),
            *(0.0185, 0.0452, 0.0349, -0.1989, 0.054, 0.218, 0.3439, 0.169, 0.0724),
        ),
        (
            *(-6.5954, -5.8401, -4.3162, 0.0375, -0.0339, 0.0324, -0.1642, 0.1937, -0.1597),
            *(0.0573, -0.0086, -0.0155, 0.0368, -0.2541, 0.1552, 0.3539, -0.1579, 0.0504),
        ),
        (
            *(-6.6286, 6.9583, 1.9699, 0.0367, 0.0423, 0.0214, 0.1883, 0.1528, 0.1766),
            *(-0.0002, 0.0401, 0.0447, 0.2267, -0.1283, 0.1488, 0.3802, 0.1108, -0.0085),
        ),
        (
            *(4.9494, 8.0195, 2.7252, -0.0387, 0.0162, 0.0429, -0.2173, -0.1334, 0.158),
            *(-0.0016, 0.0052, 0.0598, 0.0264, -0.2677, 0.1327, 0.3755, 0.0921, 0.0812),
        ),
    ),
)


def rod(bank: Bank, sample: tuple[float, ...]) -> Rod:
    """The rod under the loads of a sample."""
    gravity, moment, force, tip_moment, tip_force, _ = np.reshape(sample, (6, 3))
    segment = Segment(
        bank.length / 2.0,
        bank.radius,
        bank.young,
        poisson_ratio=bank.poisson,
        density=bank.density,
        modes=MODES,
    )
    loads = [
        Load(force=force, moment=moment, at=bank.length / 2.0),
        Load(force=tip_force, moment=tip_moment),
    ]
    return Rod([segment] * 2, gravity=gravity, loads=loads)


def tips() -> Array:
    """Published places of the tips."""
    return np.concatenate([sample[-3:] for bank in (STEEL, PLASTIC) for sample in bank.samples])


def shapes() -> Answer:
    """All equilibria."""
    models = [
        (f"{bank.name} {i}", rod(bank, sample))
        for bank in (STEEL, PLASTIC)
        for i, sample in enumerate(bank.samples, 1)
    ]
    places = tips().reshape(-1, 3)
    return at_rest(
        models,
        tip,
        lambda: [("SoRoSim, tips", places[:, 0], places[:, 2])],
        Plane(),
    )


CASES = (
    Case(
        "Random loads, SoRoSim",
        THEME,
        "A wire of spring steel, 0.6 m, and a rod of plastic, 0.4 m, with gravity in any direction and a "
        "force and a moment at the middle and at the tip: ten of the thousand shapes that opencr-mujoco "
        "compares with. Loads are printed to four decimals, which moves tips by some tenths of a millimetre.",
        "SoRoSim, as ContinuumRoboticsLab/opencr-mujoco has it",
        "computed",
        "tips x, y, z, five of steel and five of plastic (m)",
        tips,
        shapes,
        1e-3,
    ),
)
