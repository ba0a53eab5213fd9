"""The largest curvatures, strains, stresses, forces and overlaps of a result, with their places and times."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .._lissom import Robot, Via
from ..common.arguments import with_number
from ..model import fibres
from ..model.views import Link, View

if TYPE_CHECKING:
    from .._lissom import Model, Segment

Array = NDArray[np.float64]

#: Number of places along a segment, both ends included: enough for strains of the degrees in use, whose
#: largest values are mostly at ends.
PLACES = 49

#: Values that are smaller than the largest one of the same unit by this factor are rounding.
ROUNDING = 1e-12

#: Values that differ by less than this, relative to the largest, are equal: the first place is named.
EQUAL = 1e-9

#: Curvatures by the balance of moments and by the modes that differ by more than this, relative to the first,
#: are both shown.
APART = 0.02

#: Units in which rounding is measured by that of others: torsion beside curvature.
COMPARED = {"rad/m": "1/m"}

#: The largest allowable size of each quantity that a segment can limit.
LIMITS: dict[str, Callable[[Segment], float | None]] = {
    "curvature": lambda segment: segment.min_bend_radius and 1.0 / segment.min_bend_radius,
    "axial strain": lambda segment: segment.max_strain,
    "axial stress": lambda segment: segment.max_stress,
}


@dataclass(frozen=True)
class Peak:
    """The largest value of a quantity in one part of a model.

    Attributes
    ----------
    quantity : str
        What it is, such as "curvature" or "tension".
    unit : str
        Its unit; "1" for strains.
    part : str
        Name of the link, actuator, joint, loop or contact.
    value : float
        The value that is largest in size, with its sign. Axial strain and stress are sizes, whether the fibre
        is stretched or pressed.
    X : float or None
        Arc length on the rod, metres; None where the part is no rod.
    t : float
        Time, seconds; of an equilibrium that of its loads.
    index : int
        Index of the state in the result.
    limit : float or None
        The largest allowable size, from `min_bend_radius`, `max_strain` or `max_stress` of the segment at
        this place; None where the segment has none.
    is_at_rest : bool
        Whether it is one of an equilibrium, of which the text says no time.
    """

    # Pickles refer to the class by this module, whatever moves.
    __module__ = "lissom"

    quantity: str
    unit: str
    part: str
    value: float
    X: float | None
    t: float
    index: int
    limit: float | None = None
    is_at_rest: bool = False

    def __post_init__(self) -> None:
        with_number(self, "value")

    @property
    def share(self) -> float | None:
        """Size of the value divided by its limit; None without a limit. Above 1 the limit is exceeded."""
        return None if self.limit is None else abs(self.value) / self.limit

    def __str__(self) -> str:
        place = "" if self.X is None else f" at X = {self.X:.4g} m"
        only = "only " if self.share is not None and self.share > 1.0 else ""
        allowed = "" if self.limit is None else f", {only}{self._sized(self.limit)} is allowed,"
        when = "" if self.is_at_rest else f", t = {self.t:.6g} s"
        value = f"{self._sized(self.value)}{allowed}{place}{when}".removesuffix(",")
        return f"{self.quantity} of {self.part}: {value}"

    def _sized(self, value: float) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        # Data sheets state radii.
        radius = f" (radius {1.0 / value:.4g} m)" if self.quantity == "curvature" and value else ""
        return f"{value:.4g}{unit}{radius}"


@dataclass(frozen=True)
class States:
    """States of a model at some times."""

    view: View
    #: Coordinates, velocities and accelerations, (k, n) each.
    q: Array
    v: Array
    a: Array
    #: Times, seconds, (k,).
    clock: Array
    #: Inputs, (k, inputs).
    u: Array
    #: Whether the states follow each other in time; an equilibrium has none.
    have_times: bool = True

    def at(self, which: NDArray[np.intp]) -> States:
        """Some of them."""
        q, v, a, clock, u = (values[which] for values in (self.q, self.v, self.a, self.clock, self.u))
        return States(self.view, q, v, a, clock, u, self.have_times)

    @property
    def is_at_rest(self) -> bool:
        """Whether nothing moves in any of them."""
        return not (self.v.any() or self.a.any())

    @staticmethod
    def at_rest(view: View, q: Array, t: float, u: Array) -> States:
        """An equilibrium."""
        rest = np.zeros((1, len(q)))
        return States(view, q[None], rest, rest, np.array([t]), u[None], have_times=False)


def peaks_of(model: Model, states: States) -> list[Peak]:
    """Peaks of rods, then of actuators, then of contacts, each in the order of the model."""
    # The last state of a failed run can overflow.
    with np.errstate(over="ignore", invalid="ignore"):
        found = [
            *(peak for link in states.view.links for peak in peaks_of_rod(model, link, states)),
            *_of_actuators(states),
            *(_of_contacts(model, states) if isinstance(model, Robot) else ()),
        ]
    largest: dict[str, float] = {}
    for peak in found:
        unit = COMPARED.get(peak.unit, peak.unit)
        largest[unit] = max(largest.get(unit, 0.0), abs(peak.value))

    def is_rounding(peak: Peak) -> bool:
        return abs(peak.value) < ROUNDING * largest[COMPARED.get(peak.unit, peak.unit)]

    # An actuator that exerts nothing is of interest, rounding is not.
    return [peak for peak in found if peak.value == 0.0 or not is_rounding(peak)]


def largest_of(peaks: Sequence[Peak]) -> list[Peak]:
    """For each quantity of a kind of parts the largest peak, in the order of the first ones.

    Where there are limits, also the one that is nearest to its limit or furthest beyond.
    """
    largest: dict[tuple[str, str, bool], Peak] = {}
    nearest: dict[tuple[str, str, bool], Peak] = {}
    for peak in peaks:
        key = peak.quantity, peak.unit, peak.X is None
        if key not in largest or abs(peak.value) > abs(largest[key].value):
            largest[key] = peak
        if peak.share is not None and peak.share > (nearest[key].share or 0.0 if key in nearest else 0.0):
            nearest[key] = peak
    both = (found[key] for key in largest for found in (largest, nearest) if key in found)
    return list(dict.fromkeys(both))


def has_limit(segment: Segment) -> bool:
    """Whether a segment has a limit."""
    return any(limit(segment) for limit in LIMITS.values())


def _is_actuated(model: Model, link: Link) -> bool:
    """Whether actuators act along the rod: the balance of forces in its sections holds them, too."""
    parts = [
        part for actuator in getattr(model, "actuators", ()) for part in getattr(actuator, "path", [actuator])
    ]
    for part in parts:
        of_part = getattr(part, "link", "")
        # Actuators of a rod name no link, nor do guides in the world.
        if of_part == link.name or (of_part is None and not isinstance(part, Via)):
            return True
    return False


def peaks_of_rod(model: Model, link: Link, states: States) -> Iterator[Peak]:
    """Peaks along a rod."""
    if link.strain is None:
        return
    X = _stations(link)
    at = fibres.segments(link, X)
    strain = link.strain(states.q, X)
    change = strain - link.strain(np.zeros((1, states.q.shape[1])), X)
    wrench = None
    if link.wrench is not None:
        wrench = link.wrench(states.q, states.v, states.a, X, states.clock, states.u)
    is_actuated = _is_actuated(model, link)
    # With actuators along the rod the balance of forces is not that of the material alone.
    of_material = None if is_actuated else wrench
    missing: Array | float = 0.0
    if of_material is not None and states.is_at_rest:
        missing = fibres.missing_strains(link, of_material, states.q, X, states.clock, states.u, at)
        of_modes = np.linalg.norm(strain[..., 1:3], axis=-1)
        strain, change = strain + missing, change + missing
    found = {
        ("curvature", "1/m"): np.linalg.norm(strain[..., 1:3], axis=-1),
        ("torsion", "rad/m"): strain[..., 0],
        ("stretch", "1"): change[..., 3],
        ("shear", "1"): np.linalg.norm(change[..., 4:], axis=-1),
    }
    if of_material is not None and states.is_at_rest:
        most, most_of_modes = found["curvature", "1/m"].max(), of_modes.max()
        if abs(most - most_of_modes) > APART * most:
            found["curvature of the modes", "1/m"] = of_modes
    # Sections that are given by their stiffness have no outermost fibre.
    if all(segment.section.shape != "given" for segment in link.segments):
        half = fibres.half_extents(link, X, at)
        rigid: Array | float = 0.0
        if of_material is not None:
            rigid = fibres.strains_without_modes(link, of_material, X, at)
        fibre = fibres.axial_strain(link, change + rigid, half, at)
        stress = fibres.axial_stress(link, states.q, X, states.clock, states.u, half, at, missing + rigid)
        # What actuators press along a rod without modes of stretch is not known; rounding is none of it.
        if not is_actuated or fibre.max() > ROUNDING:
            found["axial strain", "1"] = fibre
            if stress is not None:
                found["axial stress", "Pa"] = stress
    if wrench is not None:
        found["bending moment", "N m"] = np.linalg.norm(wrench[..., 1:3], axis=-1)
        # The wrench is that on what is beyond a section: signs as those of torsion and stretch.
        found["torque", "N m"] = -wrench[..., 0]
        found["tension", "N"] = -wrench[..., 3]
    for (quantity, unit), values in found.items():
        if not values.any():
            # Strains without modes, and forces that nothing exerts.
            continue
        limit = LIMITS.get(quantity)
        limits = [limit and limit(link.segments[i]) for i in at]
        places = [_largest(values)]
        if any(limits):
            shares = values / np.array([of_place or np.inf for of_place in limits])
            places += [place for place in [_largest(shares)] if place != places[0]]
        for state, station in places:
            value = values[state, station]
            peak = _peak(quantity, unit, link.name, value, X[station], states, state)
            yield replace(peak, limit=limits[station])


def _stations(link: Link) -> Array:
    """Arc lengths at which a rod is looked at: also both sides of what makes strains and forces jump."""
    ends = np.concatenate([[0.0], np.cumsum([segment.length for segment in link.segments])])
    ends[-1] = link.length
    inner = [np.linspace(a, b, PLACES) for a, b in pairwise(ends)]
    for places in inner[1:]:
        places[0] = np.nextafter(places[0], np.inf)
    marks = np.clip(np.array(link.marks), 0.0, link.length)
    beyond = np.nextafter(marks, np.inf)
    return np.sort(np.concatenate([*inner, marks, beyond[beyond <= link.length]]))


def _of_actuators(states: States) -> Iterator[Peak]:
    for glyph in states.view.glyphs.actuators:
        force = glyph.force(states.q, states.v, states.clock, states.u)
        (state,) = _largest(force)
        quantity, _, unit = glyph.quantities[0].rstrip(")").partition(" (")
        yield _peak(quantity, unit or "1", glyph.name, force[state], None, states, state)


def _of_contacts(robot: Robot, states: States) -> Iterator[Peak]:
    for contact in robot.contacts:
        wrench = robot.contact_forces(states.q, states.v, name=contact.name, t=states.clock)
        size = np.linalg.norm(wrench[:, 3:], axis=-1)
        if size.any():
            (state,) = _largest(size)
            yield _peak("contact force", "N", contact.name, size[state], None, states, state)
    deepest: dict[str, tuple[float, float | None, int]] = {}
    for state, (q, v, t) in enumerate(zip(states.q, states.v, states.clock, strict=True)):
        for touch in robot.touches(q, v, t=float(t)) if robot.contacts else ():
            if touch.contact not in deepest or touch.overlap > deepest[touch.contact][0]:
                deepest[touch.contact] = touch.overlap, touch.along[0], state
    for name, (overlap, X, state) in deepest.items():
        yield _peak("overlap", "m", name, overlap, X, states, state)


def _largest(values: Array) -> tuple[int, ...]:
    """Indices of the value that is largest in size, the first of equal ones, or not a number."""
    sizes = np.where(np.isnan(values), np.inf, np.abs(values))
    sizes = sizes >= (1.0 - EQUAL) * sizes.max()
    return tuple(int(i) for i in np.unravel_index(int(np.argmax(sizes)), values.shape))


def _peak(
    quantity: str, unit: str, part: str, value: float, X: float | None, states: States, state: int
) -> Peak:
    place = None if X is None else float(X)
    t, is_at_rest = float(states.clock[state]), not states.have_times
    return Peak(quantity, unit, part, float(value), place, t, state, is_at_rest=is_at_rest)
