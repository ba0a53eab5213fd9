"""Motion of the right-angle frame."""

from __future__ import annotations

import numpy as np

from ...._lissom import Load, MotionResult, Rod, Section, Segment, modes, simulate
from . import exact
from .case import Answer, Array, Case, Curve, Plot
from .dynamics import unfinished
from .rods import WEIGHTLESS
from .statics import CORNER

THEME = "Right-angle frame in motion"

#: Simo and Vu-Quoc (1988), On the dynamics in space of rods undergoing large motions, Computer Methods in
#: Applied Mechanics and Engineering 66, example 5.2: length of a leg; stiffness of (torsion, bend_y, bend_z,
#: stretch, shear_y, shear_z); mass and inertia per length.
LEG = 10.0
STIFFNESS = (1e3, 1e3, 1e3, 1e6, 1e6, 1e6)
MASS, INERTIA = 1.0, (20.0, 10.0, 10.0)
#: Force on the elbow, normal to the plane of the legs, over time.
PUSH_TIMES, PUSH = (0.0, 1.0, 2.0), (0.0, 50.0, 0.0)
END = 30.0

#: Modes of torsion and of each bending, of stretch and of each shear, per leg: two more change the extremes
#: below by 3e-4.
BENDS, STRETCHES = 8, 6
#: Newmark's step; the corners of the force are ends of steps. Halving it changes the extremes below by 6e-5.
STEP = 5e-3


def frame_rod() -> Rod:
    """Two legs with a rigid corner between them, loaded at the corner."""
    section = Section.given(np.diag(STIFFNESS), mass=MASS, inertia=INERTIA)
    bends = dict.fromkeys(("torsion", "bend_y", "bend_z"), BENDS)
    stretches = dict.fromkeys(("stretch", "shear_y", "shear_z"), STRETCHES)
    leg = Segment(LEG, section=section, modes=bends | stretches)
    turn = (0.0, 0.0, 0.5 * np.pi / CORNER, 1.0, 0.0, 0.0)
    corner = Segment(CORNER, section=section, modes={}, reference_strain=turn)
    push = Load(force=(PUSH_TIMES, np.outer(PUSH, (0.0, 0.0, 1.0))), at=LEG)
    return Rod([leg, corner, leg], gravity=WEIGHTLESS, loads=[push])


def pushed() -> tuple[Rod, MotionResult]:
    """The whole motion."""
    rod = frame_rod()
    return rod, simulate(rod, END, dt=STEP, t_eval=np.linspace(0.0, END, 3001))


# Small vibrations

COUNT = 6
#: Above the last of these frequencies.
HIGHEST = 2.0


def wanted_frequencies() -> Array:
    """Frequencies of small vibrations."""
    return exact.frame_frequencies(LEG, STIFFNESS, MASS, INERTIA, COUNT, HIGHEST)


def frequencies() -> Answer:
    """Frequencies of the frame at rest."""
    rod = frame_rod()
    found = modes(rod, np.zeros(rod.n)).angular_frequency[:COUNT]
    number = np.arange(1, COUNT + 1)
    return Answer(
        found,
        lambda: Plot(
            "mode",
            "angular frequency",
            [Curve("lissom", number, found), Curve("exact", number, wanted_frequencies(), joined=False)],
        ),
    )


# Motion

#: Largest and smallest displacement of the tip and smallest one of the elbow, normal to the plane, each with
#: its time, by Exudyn 1.13.6 with 40 and 80 elements per leg and a step of 5e-3, extrapolated to zero element
#: length (benches/python/peers/exudyn_frame.py). 20 and 40 elements give the same values within 8e-4.
EXTREMES = (8.2521, 7.4365, -9.7270, 15.8716, -4.0599, 10.8635)


def extreme(t: Array, values: Array, at: int) -> tuple[float, float]:
    """Extreme of the parabola through three neighbouring values, and its time."""
    before, middle, after = values[at - 1 : at + 2]
    shift = 0.5 * (before - after) / (before - 2.0 * middle + after)
    return float(middle - 0.25 * (before - after) * shift), float(t[at] + shift * (t[1] - t[0]))


def motion() -> Answer:
    """Swinging of the frame with bending and torsional displacements as large as the frame."""
    rod, result = pushed()
    tip, elbow = (rod.pose(result.q, X)[:, 2, 3] for X in (rod.length, LEG))
    t = result.t
    extremes = (
        *extreme(t, tip, int(tip.argmax())),
        *extreme(t, tip, int(tip.argmin())),
        *extreme(t, elbow, int(elbow.argmin())),
    )
    return Answer(
        extremes if result.success else [np.nan],
        lambda: Plot(
            "time",
            "displacement across the plane",
            [
                Curve("tip, lissom", t, tip),
                Curve("elbow, lissom", t, elbow),
                Curve("tip, Exudyn", EXTREMES[1:4:2], EXTREMES[0:4:2], joined=False),
                Curve("elbow, Exudyn", EXTREMES[5:], EXTREMES[4:5], joined=False),
            ],
        ),
        unfinished(result),
    )


def energy() -> Answer:
    """Defect of the energy compared with the work of the force."""
    _, result = pushed()
    balance = result.balance
    if balance is None:
        return Answer([np.nan], lambda: Plot("", "", []), "the run has no balance of energy")
    stored = balance.kinetic + balance.elastic
    free = result.t >= PUSH_TIMES[-1]
    return Answer(
        [stored[free].min() / balance.work[-1], stored[free].max() / balance.work[-1]],
        lambda: Plot(
            "time",
            "energy",
            [
                Curve("kinetic", result.t, balance.kinetic),
                Curve("elastic", result.t, balance.elastic),
                Curve("kinetic and elastic", result.t, stored),
                Curve("work of the push", result.t[::100], balance.work[::100], joined=False),
            ],
        ),
        unfinished(result),
    )


CASES = (
    Case(
        "Frame, frequencies",
        THEME,
        "Two legs of length 10 at 90 degrees (the corner is a rigid arc of 1e-9), clamped at one end; G J = "
        "E I = 1e3, E A = G A = 1e6, ρ A = 1, ρ I = diag(20, 10, 10), without units, as in Simo and Vu-Quoc "
        "1988; 8 modes of torsion and of each bending, 6 of stretch and of each shear in a leg.",
        "Timoshenko's theory in space, zeros of the transfer matrix",
        "exact",
        "first six angular frequencies",
        wanted_frequencies,
        frequencies,
        1e-8,
    ),
    Case(
        "Frame, pushed",
        THEME,
        "The same frame, pushed at the elbow across its plane by a force that grows to 50 at t = 1 and falls "
        "to 0 at t = 2, until t = 30. The publication has curves only, so that the extremes of another code "
        "stand here: Exudyn 1.13.6 with 40 and 80 elements a leg, extrapolated.",
        "Case of Simo and Vu-Quoc 1988, example 5.2; Exudyn",
        "computed",
        "largest and smallest displacement of the tip, smallest of the elbow, each with its time",
        lambda: EXTREMES,
        motion,
        1e-4,
        scale=LEG,
    ),
    Case(
        "Frame, energy",
        THEME,
        "After the push nothing is lost or won: kinetic and elastic energy are the work of the push.",
        "Conservation of energy",
        "exact",
        "smallest and largest energy after the push / work of the push",
        lambda: [1.0, 1.0],
        energy,
        2e-5,
        scale=1.0,
    ),
)
