"""Rods on a rotating base."""

from __future__ import annotations

from functools import cache

import numpy as np

from ...._lissom import BaseMotion, Harmonic, MotionResult, Rod, Segment, modes, simulate, statics
from . import exact
from .case import Answer, Array, Case, Curve, Plot
from .dynamics import unfinished
from .rods import BENDING, LENGTH, RADIUS, WEIGHTLESS

THEME = "Rotation"

# Spin-up manoeuvre: a flexible beam accelerated to a constant speed

#: Stiffnesses (N, N m^2), mass per length (kg/m) and length (m) of a circular section; the rotary inertia of
#: the publication, 6e-4 kg m, is that of a circle too.
BEND, SHEAR, STRETCH, MASS, SPAN = 1.4e4, 1e7, 2.8e7, 1.2, 10.0
#: Duration of the acceleration in seconds, and the final speed in rad/s.
RISE, SPEED = 15.0, 6.0
END = 20.0


def turned(t: float) -> tuple[float, float, float]:
    """Angle of the base with its rate and acceleration."""
    if t >= RISE:
        return SPEED * t - SPEED * RISE / 2.0, SPEED, 0.0
    phase, mean = 2.0 * np.pi * t / RISE, SPEED / RISE
    return (
        mean * (t**2 / 2.0 + (RISE / (2.0 * np.pi)) ** 2 * (np.cos(phase) - 1.0)),
        mean * (t - RISE / (2.0 * np.pi) * np.sin(phase)),
        mean * (1.0 - np.cos(phase)),
    )


def spun_rod() -> Rod:
    """The beam as a circular rod with these stiffnesses."""
    radius = 2.0 * np.sqrt(BEND / STRETCH)
    area = np.pi * radius**2
    young = STRETCH / area
    shear = 0.4 * young
    segment = Segment(
        SPAN,
        radius,
        young,
        shear,
        MASS / area,
        {"bend_z": 6, "stretch": 3, "shear_y": 4},
        shear_correction=SHEAR / (shear * area),
    )
    return Rod([segment], gravity=WEIGHTLESS, base_motion=BaseMotion(axis=(0, 0, 1), angle=turned))


def tip_in_shadow(rod: Rod, q: Array, t: Array) -> Array:
    """Displacement of the tip along and perpendicular to the undeformed rotating beam, shape (m, 2)."""
    tip = rod.pose(q, rod.length, t=t)[:, :3, 3]
    angle = np.array([turned(time)[0] for time in t])
    along = tip[:, 0] * np.cos(angle) + tip[:, 1] * np.sin(angle) - SPAN
    across = tip[:, 1] * np.cos(angle) - tip[:, 0] * np.sin(angle)
    return np.column_stack([along, across])


@cache
def linear_beam() -> tuple[Array, Array]:
    """Times and tip deflection by the classical linear equations."""
    return exact.turned_beam(BEND, MASS, SPAN, turned, END)


def spin_up() -> tuple[Rod, MotionResult]:
    """The whole manoeuvre."""
    rod = spun_rod()
    t = np.linspace(0.0, END, 801)
    return rod, simulate(rod, END, method="radau", rtol=1e-7, atol=1e-9, t_eval=t)


def largest_lag() -> Answer:
    """Largest lag of the tip."""
    rod, motion = spin_up()
    across = tip_in_shadow(rod, motion.q, motion.t)[:, 1]
    t, wanted = linear_beam()
    return Answer(
        [across.min() if motion.success else np.nan],
        lambda: Plot(
            "time (s)",
            "tip, across (m)",
            [
                Curve("lissom", motion.t, across),
                Curve("linear beam", t[::200], wanted[::200], joined=False),
            ],
        ),
        unfinished(motion),
    )


def steady_stretch() -> Answer:
    """Elongation of the beam at its final speed."""
    rod = spun_rod()
    found = statics(rod, t=END)
    longer = tip_in_shadow(rod, found.q[None], np.array([END]))[0, 0]
    _, motion = spin_up()
    along = tip_in_shadow(rod, motion.q, motion.t)[:, 0]
    return Answer(
        [longer if found.success else np.nan],
        lambda: Plot(
            "time (s)",
            "tip, along (m)",
            [
                Curve("lissom", motion.t, along),
                Curve("exact, steady", [RISE, END], [exact_stretch()] * 2, joined=False),
            ],
        ),
        "" if found.success else found.message,
    )


def exact_stretch() -> float:
    """E A u'' = -rho A w^2 (x + u), clamped at x = 0 and free at x = L."""
    k = SPEED * np.sqrt(MASS / STRETCH)
    return float(np.tan(k * SPAN) / k - SPAN)


# Frequencies of a rotor blade

#: Speeds of rotation in units of sqrt(E I / (rho A)) / L^2.
SPEEDS = (0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0)
DENSITY = 1000.0


def wanted_flapping() -> list[float]:
    """Reference values at all speeds."""
    return [exact.flapping_blade(speed) for speed in SPEEDS]


def flapping() -> Answer:
    """Flapping frequencies of a slender blade clamped at the axis."""
    unit = np.sqrt(BENDING / (DENSITY * np.pi * RADIUS**2)) / LENGTH**2
    thin = 0.1
    found = []
    for speed in SPEEDS:
        turning = BaseMotion(axis=(0, 0, 1), angle=Harmonic(rate=speed * unit * thin))
        segment = Segment(LENGTH, thin * RADIUS, 1e9, 4e8, DENSITY, {"bend_y": 8})
        rod = Rod([segment], gravity=WEIGHTLESS, base_motion=turning)
        found.append(modes(rod, np.zeros(8)).angular_frequency[0] / (unit * thin))
    return Answer(
        found,
        lambda: Plot(
            "speed",
            "first frequency",
            [
                Curve("lissom", SPEEDS, found),
                Curve("power series", SPEEDS, wanted_flapping(), joined=False),
            ],
        ),
    )


# Whirl of a turning shaft

#: Speeds of rotation in units of the first frequency: below it and far above it.
WHIRLS = (0.5, 3.0)
THIN, WHIRL_COUNT = 1e-4, 4


def wanted_whirls() -> Array:
    """The plane waves of a round shaft at rest, seen from the turning base: sums and differences."""
    plane = exact.cantilever_roots(2) ** 2
    found = []
    for ratio in WHIRLS:
        speed = ratio * plane[0]
        found.append(np.sort(np.abs([plane - speed, plane + speed]).ravel()))
    return np.concatenate(found)


def whirls() -> Answer:
    """Frequencies of a slender round cantilever that turns about its axis."""
    unit = np.sqrt(1e9 * THIN**2 / (4.0 * DENSITY))
    found = []
    for ratio in WHIRLS:
        speed = ratio * exact.cantilever_roots(1)[0] ** 2 * unit
        turning = BaseMotion(axis=(1, 0, 0), angle=Harmonic(rate=speed))
        segment = Segment(LENGTH, THIN, 1e9, 4e8, DENSITY, {"bend_y": 8, "bend_z": 8})
        rod = Rod([segment], gravity=WEIGHTLESS, base_motion=turning)
        found.append(modes(rod, np.zeros(rod.n)).angular_frequency[:WHIRL_COUNT] / unit)
    number = np.arange(1, WHIRL_COUNT + 1)

    def plot() -> Plot:
        wanted = wanted_whirls().reshape(len(WHIRLS), -1)
        curves = []
        for ratio, by_lissom, exact_ones in zip(WHIRLS, found, wanted, strict=True):
            curves.append(Curve(f"lissom, {ratio:g} ω₁", number, by_lissom))
            curves.append(Curve(f"exact, {ratio:g} ω₁", number, exact_ones, joined=False))
        return Plot("mode", "frequency × L² √(ρA / EI)", curves)

    return Answer(np.concatenate(found), plot)


CASES = (
    Case(
        "Spin-up, largest lag",
        THEME,
        "L = 10 m, EI = 1.4e4 N m², GA = 1e7 N, EA = 2.8e7 N, 1.2 kg/m, turned from rest to 6 rad/s within "
        "15 s: the spin-up manoeuvre of Simo and Vu-Quoc 1986. 6 modes of bending, 3 of stretch, 4 of shear.",
        "Linear beam with centrifugal stiffening (Kane, Ryan and Banerjee 1987)",
        "computed",
        "smallest tip displacement across (m)",
        lambda: [linear_beam()[1].min()],
        largest_lag,
        5e-3,
    ),
    Case(
        "Spin-up, steady stretch",
        THEME,
        "The same beam at its final speed of 6 rad/s.",
        "Centrifugal force on an elastic bar",
        "exact",
        "tip displacement along (m)",
        lambda: [exact_stretch()],
        steady_stretch,
        1e-5,
    ),
    Case(
        "Rotor blade, flapping",
        THEME,
        "A slender blade clamped at the axis of rotation, at speeds from 0 to 12 √(EI / (ρA L⁴)); 8 modes.",
        "Wright, Smith, Thresher and Wang 1982, power series",
        "exact",
        "first frequency × L² √(ρA / EI)",
        wanted_flapping,
        flapping,
        5e-6,
    ),
    Case(
        "Shaft, whirling",
        THEME,
        "A slender round cantilever that turns about its own axis, at half and at three times its first "
        "frequency: "
        "seen from the base, its vibrations are faster and slower by the speed, by Coriolis forces.",
        "Euler-Bernoulli theory at rest, in turning axes",
        "exact",
        "first four frequencies × L² √(ρA / EI) at each speed",
        wanted_whirls,
        whirls,
        1e-5,
    ),
)
