"""The rods of the matrix, as variations of one rod."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from ...._lissom import Rod, Segment

#: A soft rod of one metre that bends, stretches and shears in a plane.
SOFT: Mapping[str, Any] = {
    "length": 1.0,
    "radius": 0.02,
    "young_modulus": 1e7,
    "density": 1000.0,
    "modes": {"bend_y": 3, "stretch": 1, "shear_z": 1},
    "retardation_time": 1e-3,
}

#: The same rod with bending only.
BENDING: Mapping[str, Any] = {**SOFT, "modes": {"bend_y": 3}}

#: Shear modulus relative to Young's modulus for Poisson's ratio 1/4.
SHEAR = 0.4


def segment(base: Mapping[str, Any] = SOFT, **changes: Any) -> Segment:
    """A segment; its shear modulus follows from Young's modulus unless it is given."""
    values = {**base, **changes}
    return Segment(**({"shear_modulus": SHEAR * values["young_modulus"]} | values))


def rod(base: Mapping[str, Any] = SOFT, *, of_rod: Mapping[str, Any] | None = None, **changes: Any) -> Rod:
    """A variation of the rod with one segment; ``of_rod`` contains arguments of Rod."""
    return Rod([segment(base, **changes)], **(of_rod or {}))


def chain(count: int, modes: dict[str, int]) -> Rod:
    """The soft rod divided into this number of segments."""
    return Rod([segment(length=1.0 / count, modes=modes)] * count)


def undamped(damped: Rod) -> Rod:
    """The same rod without damping."""
    return changed(damped, [_copy(part, retardation_time=0.0) for part in damped.segments])


def changed(like: Rod, segments: Iterable[Segment]) -> Rod:
    """The same rod with other segments."""
    return Rod(
        segments,
        base_orientation=like.base_orientation,
        gravity=like.gravity,
        tip_force=like.tip_force,
        tip_moment=like.tip_moment,
        tip_mass=like.tip_mass,
        loads=like.loads,
        bodies=like.bodies,
        base_motion=like.base_motion,
    )


def _copy(part: Segment, **changes: Any) -> Segment:
    names = (
        "length",
        "radius",
        "young_modulus",
        "shear_modulus",
        "density",
        "modes",
        "retardation_time",
        "reference_strain",
        "shear_correction",
        "nodes",
        "basis",
    )
    return Segment(**({name: getattr(part, name) for name in names} | changes))
