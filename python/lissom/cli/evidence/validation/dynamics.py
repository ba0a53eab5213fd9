"""Motions of rods."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from ...._lissom import MotionResult, Rod, Segment, modes, simulate
from . import exact
from .case import Answer, Array, Case, Curve, Plot
from .rods import GRAVITY, WEIGHTLESS, centre_line, shape_plot, tip
from .statics import WIRE, planar_points, planar_tip

THEME = "Dynamics"


def tips_over_time(rod: Rod, motion: MotionResult, points: list[Curve]) -> Plot:
    """The tip's coordinates in the plane of bending."""
    path = tip(rod, motion.q)
    curves = [Curve("x, lissom", motion.t, path[:, 0]), Curve("z, lissom", motion.t, path[:, 2])]
    return Plot("time (s)", "tip (m)", [*curves, *points])


def unfinished(motion: MotionResult) -> str:
    """Reason of a failed run; empty for a success."""
    return "" if motion.success else motion.message


# Lab wire, released

#: Tip (x, z) in metres of the released wire by time in seconds, from an independent prototype.
RELEASED = {
    0.1: (0.9970663766, -0.0712500678),
    0.5: (0.9807178651, -0.1838140514),
    1.0: (0.9273593387, -0.3468061965),
    3.0: (0.9338616378, -0.333168186),
}


def release() -> Answer:
    """Three seconds of the lab's wire, at tight tolerances."""
    rod = Rod([Segment(**WIRE, modes={"bend_y": 3}, retardation_time=1e-4)])
    t = np.linspace(0.0, 3.0, 301)
    motion = simulate(rod, 3.0, method="radau", rtol=1e-10, atol=1e-13, t_eval=t)
    at = np.searchsorted(t, np.array(list(RELEASED)) - 1e-9)
    times, wanted = list(RELEASED), np.array(list(RELEASED.values()))
    return Answer(
        tip(rod, motion.q[at])[:, [0, 2]].ravel() if motion.success else [np.nan],
        lambda: tips_over_time(
            rod,
            motion,
            [
                Curve("x, independent", times, wanted[:, 0], joined=False),
                Curve("z, independent", times, wanted[:, 1], joined=False),
            ],
        ),
        unfinished(motion),
    )


# Decay of a mode

DECAY_PERIODS, DECAY_RATIO = 5.0, 0.02
#: Initial tip deflection in units of the length: small enough for linear motion.
DECAY_SIZE = 1e-6


def decaying() -> Answer:
    """Release of the wire in its first mode."""
    free = Rod([Segment(**WIRE, modes={"bend_y": 6})], gravity=WEIGHTLESS)
    first = modes(free, np.zeros(6))
    omega = first.angular_frequency[0]
    rod = Rod(
        [Segment(**WIRE, modes={"bend_y": 6}, retardation_time=2.0 * DECAY_RATIO / omega)], gravity=WEIGHTLESS
    )
    shape = first.shapes[:, 0]
    size = tip(free, DECAY_SIZE * shape / np.abs(shape).max())[2]
    q0 = DECAY_SIZE / size * DECAY_SIZE * shape / np.abs(shape).max()
    t_end = DECAY_PERIODS * 2.0 * np.pi / omega
    t = np.linspace(0.0, t_end, 201)
    motion = simulate(rod, t_end, q0=q0, method="radau", rtol=1e-9, atol=1e-18, t_eval=t)
    return Answer(
        tip(rod, motion.q)[[50, 100, 150, 200], 2] / DECAY_SIZE if motion.success else [np.nan],
        lambda: Plot(
            "periods",
            "tip / its start",
            [
                Curve("lissom", DECAY_PERIODS * t / t_end, tip(rod, motion.q)[:, 2] / DECAY_SIZE),
                Curve(
                    "exact",
                    DECAY_PERIODS * t[::5] / t_end,
                    decay(DECAY_PERIODS * t[::5] / t_end),
                    joined=False,
                ),
            ],
        ),
        unfinished(motion),
    )


def decay(periods: Array) -> Array:
    """A released damped oscillator after this number of undamped periods."""
    phase = 2.0 * np.pi * periods
    damped = np.sqrt(1.0 - DECAY_RATIO**2)
    return np.asarray(
        np.exp(-DECAY_RATIO * phase)
        * (np.cos(damped * phase) + DECAY_RATIO / damped * np.sin(damped * phase))
    )


# Tapered rod, released

TAPER: dict[str, Any] = {
    "length": 0.5,
    "radius": (0.02, 0.01),
    "young_modulus": 1e6,
    "shear_modulus": 4e5,
    "density": 1000.0,
    "modes": {"bend_y": 10},
    "retardation_time": 0.1,
}
TAPER_SECONDS = 12.0


def taper_radius(X: Array) -> Array:
    """Radius along the rod."""
    base, end = TAPER["radius"]
    return np.asarray(base + (end - base) * X / TAPER["length"])


@cache
def taper_shape() -> exact.PlanarShape:
    """Equilibrium by collocation."""
    return exact.planar_rod(
        TAPER["length"],
        lambda X: TAPER["young_modulus"] * np.pi / 4.0 * taper_radius(X) ** 4,
        weight=lambda X: TAPER["density"] * GRAVITY * np.pi * taper_radius(X) ** 2,
    )


def taper_motion() -> tuple[Rod, MotionResult]:
    """Release from horizontal."""
    rod = Rod([Segment(**TAPER)])
    t = np.linspace(0.0, TAPER_SECONDS, 501)
    return rod, simulate(rod, TAPER_SECONDS, method="radau", rtol=1e-8, atol=1e-10, t_eval=t)


def taper_rest() -> Answer:
    """Final shape."""
    rod, motion = taper_motion()
    return Answer(
        tip(rod, motion.q[-1])[[0, 2]] if motion.success else [np.nan],
        lambda: shape_plot(
            [
                (f"lissom, t = {motion.t[i]:g} s", centre_line(rod, motion.q[i]))
                for i in (0, 5, 10, 15, 25, 500)
            ],
            [planar_points("at rest, by collocation", taper_shape())],
        ),
        unfinished(motion),
    )


def taper_energy() -> Answer:
    """Defect of the energy balance relative to the moved energy."""
    _, motion = taper_motion()
    balance = motion.balance
    if balance is None:
        return Answer([np.nan], lambda: Plot("", "", []), "the run has no balance of energy")
    return Answer(
        [balance.drift],
        lambda: Plot(
            "time (s)",
            "energy (J)",
            [
                Curve(name, motion.t, getattr(balance, name))
                for name in ("kinetic", "elastic", "gravitational", "dissipated", "total")
            ],
        ),
        unfinished(motion),
    )


# Rubber rod

#: Tip (x, z) after one second in metres, from an independent prototype; accurate to about 1e-4.
RUBBER_TIP = (0.22337, -0.93122)
#: Newmark's step in seconds: halving it moves the tip by 1e-5 m.
RUBBER_STEP = 5e-4


def rubber() -> Answer:
    """A soft rod without damping."""
    strains = {"bend_y": 8, "stretch": 4, "shear_z": 4}
    rod = Rod([Segment(1.0, 0.02, 5e6, 5e6 / 3.0, 1000.0, strains)])
    motion = simulate(rod, 1.0, dt=RUBBER_STEP)
    return Answer(
        tip(rod, motion.q[-1])[[0, 2]] if motion.success else [np.nan],
        lambda: tips_over_time(
            rod,
            motion,
            [Curve("independent", [1.0, 1.0], list(RUBBER_TIP), joined=False)],
        ),
        unfinished(motion),
    )


CASES = (
    Case(
        "Lab wire, let go",
        THEME,
        "Held out horizontally and let go; three modes, retardation time 1e-4 s. Radau at a tolerance of "
        "1e-10.",
        "Independent prototype, shares no code with lissom",
        "computed",
        "tip x, z at 0.1, 0.5, 1, 3 s (m)",
        lambda: [value for pair in RELEASED.values() for value in pair],
        release,
        1e-7,
        scale=1.0,
    ),
    Case(
        "Decay of the first mode",
        THEME,
        "The wire without weight, let go in its first mode of 1 µm, with Kelvin-Voigt damping of ratio 0.02.",
        "Damped oscillator",
        "exact",
        "tip / its start after 1.25, 2.5, 3.75, 5 periods",
        lambda: decay(np.array([1.25, 2.5, 3.75, 5.0])),
        decaying,
        1e-5,
        scale=1.0,
    ),
    Case(
        "Tapered rod comes to rest",
        THEME,
        "L = 0.5 m, radius 20 to 10 mm, E = 1 MPa, 1000 kg/m³, retardation time 0.1 s, let go from "
        "horizontal; after 12 s it hangs still. 10 modes.",
        "Chebyshev collocation of the static shape",
        "computed",
        "tip x, z (m)",
        lambda: planar_tip(taper_shape()),
        taper_rest,
        1e-6,
        scale=TAPER["length"],
    ),
    Case(
        "Tapered rod, energy balance",
        THEME,
        "On the way there kinetic, elastic, gravitational and dissipated energy add up to what they were.",
        "Conservation of energy",
        "exact",
        "largest drift / energy that moved",
        lambda: [0.0],
        taper_energy,
        1e-5,
        scale=1.0,
    ),
    Case(
        "Rubber rod, let go",
        THEME,
        "L = 1 m, radius 20 mm, E = 5 MPa, G = E/3, 1000 kg/m³, no damping, after 1 s; 8 modes of "
        "bending, 4 of stretch and of shear. Beside PyElastica and MuJoCo: docs/benchmarks.md.",
        "Independent prototype, converged to about 1e-4",
        "computed",
        "tip x, z at 1 s (m)",
        lambda: RUBBER_TIP,
        rubber,
        3e-4,
        scale=1.0,
    ),
)
