"""Units of parameters, by the names in their paths."""

from __future__ import annotations

import re

#: Units by names that have one unit in all parts of a model; stiffnesses and dampings of joints have several.
UNITS = {
    **dict.fromkeys(("length", "radius", "at", "wall", "patch_radius", "min_bend_radius", "lead"), "m"),
    **dict.fromkeys(("young_modulus", "shear_modulus", "max_stress", "pressure"), "Pa"),
    **dict.fromkeys(("retardation_time", "t0", "t_end", "dt"), "s"),
    **dict.fromkeys(("mass", "tip_mass"), "kg"),
    **dict.fromkeys(("slip_velocity", "stribeck_velocity"), "m/s"),
    **dict.fromkeys(("tension", "force", "tip_force"), "N"),
    **dict.fromkeys(("moment", "tip_moment"), "N m"),
    **dict.fromkeys(("area", "drag_area"), "m²"),
    "density": "kg/m³",
    "gravity": "m/s²",
    "volume": "m³",
    "viscous_drag": "N s/m",
    "dissipation": "s/m",
    "frequency": "Hz",
    "phase": "rad",
}


def unit_of(path: str) -> str:
    """The unit of a parameter given by its path; empty if it has none, or none is known.

    Names alone are those of a function of the user, which has units of its own.
    """
    if "." not in path and "[" not in path:
        return ""
    name = re.match(r"\w+", path.rpartition(".")[2])
    return UNITS.get(name[0], "") if name else ""


def with_unit(path: str) -> str:
    """A parameter with its unit, for axes and tables."""
    unit = unit_of(path)
    return f"{path} ({unit})" if unit else path
