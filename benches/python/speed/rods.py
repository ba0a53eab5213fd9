"""The rods of `benches/rod.rs`, as arguments for both lissom and the NumPy reference."""

from typing import Any

import lissom

STRAINS = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")

STEPS = 100
STEP = 1e-2

Arguments = list[dict[str, Any]]


def soft(length: float, numbers: tuple[int, ...]) -> dict[str, Any]:
    return {
        "length": length,
        "radius": 0.01,
        "young_modulus": 1e6,
        "shear_modulus": 4e5,
        "density": 1000.0,
        "modes": {strain: number for strain, number in zip(STRAINS, numbers, strict=True) if number},
        "retardation_time": 0.01,
    }


LAB = soft(1.0, (0, 3, 0, 0, 0, 0)) | {
    "radius": 1e-3,
    "young_modulus": 210e9,
    "shear_modulus": 80e9,
    "density": 7800.0,
    "retardation_time": 1e-4,
}

#: Rods of the kernels by name; the numbers are the numbers of coordinates.
KERNELS: dict[str, Arguments] = {
    "lab-3": [LAB],
    "two-12": [soft(0.3, (2, 2, 2, 0, 0, 0))] * 2,
    "two-18": [soft(0.3, (2, 2, 2, 1, 1, 1))] * 2,
    "two-24": [soft(0.3, (2, 2, 2, 2, 2, 2))] * 2,
    "two-36": [soft(0.3, (3, 3, 3, 3, 3, 3))] * 2,
}

SEGMENTS = (1, 2, 4, 8, 16, 32, 64, 128)
MODES = (1, 2, 3, 4, 6, 8, 12, 16)


def rod(arguments: Arguments) -> lissom.Rod:
    return lissom.Rod([lissom.Segment(**segment) for segment in arguments])


def state(n: int) -> list[list[float]]:
    """Coordinates, velocities, accelerations."""
    return [[0.1] * n, [0.2] * n, [0.3] * n]
