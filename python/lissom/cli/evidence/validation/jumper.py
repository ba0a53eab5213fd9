"""A flexible jumper between a riser and a vessel that moves, in still water."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...._lissom import (
    BaseMotion,
    Fluid,
    Free,
    Link,
    Loop,
    LoopEnd,
    Revolute,
    Robot,
    Segment,
    Spherical,
    StaticsResult,
    simulate,
    statics,
)
from . import exact_lines
from .case import Answer, Array, Case, Curve, Plot
from .exact_lines import Line

THEME = "Line in water, in motion"

#: Lowe and Langley 2006 as MoorDyn's tests/lowe_and_langley_2006.cpp (BSD-3) has it, SI units: ends, length,
#: diameter, mass per length, stiffness of stretch and of bending, coefficients of drag and of added mass.
RISER, VESSEL, LENGTH = np.array([-100.0, 0.0, -55.0]), np.array([0.0, 0.0, -5.0]), 170.0
DIAMETER, MASS, STRETCH, BENDING, DRAG, ADDED_MASS = 0.396, 165.0, 5e8, 120.8e3, 1.0, 1.0
WATER, GRAVITY = 1000.0, 9.807
#: Amplitude, m, and period, s, of the vessel; it sets out within the first period.
AMPLITUDE, PERIOD = 10.0, 27.0
#: Time after that, s, for which tensions are compared; its samples; steps of a table of the motion.
SHOWN, EVERY, TABLE_STEP = 54.0, 2.0, 0.05

#: Segments and modes of bending each way of each; time steps, s. Stretch, 1e-4, is left out.
SEGMENTS, BENDS, STEP = 6, 5, 0.1
#: Forces on the top and on the bottom at rest, kN, of MoorDyn's test: horizontal, vertical.
AT_REST = (11.40, 45.71, 11.40, 24.04)


@dataclass(frozen=True)
class Motion:
    """A motion of the vessel, and published tensions at the top, kN, every two seconds from the second on."""

    name: str
    axis: int
    tensions: tuple[float, ...]


MOTIONS = (
    Motion(
        "surge",
        0,
        (
            *(
                45.77,
                42.58,
                41.48,
                42.55,
                44.45,
                46.60,
                46.99,
                46.37,
                46.60,
                48.38,
                50.76,
                52.21,
                51.40,
                48.18,
            ),
            *(44.22, 41.77, 41.87, 43.48, 45.64, 47.02, 46.68, 46.31, 47.31, 49.63, 51.72, 52.21, 50.02),
        ),
    ),
    Motion(
        "sway",
        1,
        (
            *(
                46.09,
                44.35,
                44.80,
                46.60,
                48.41,
                49.12,
                47.80,
                45.64,
                44.38,
                45.28,
                47.06,
                48.73,
                48.99,
                47.25,
            ),
            *(45.16, 44.38, 45.73, 47.60, 48.99, 48.67, 46.73, 44.77, 44.64, 46.15, 47.99, 49.05, 48.28),
        ),
    ),
)


def line() -> Line:
    """The jumper as a line in water."""
    area = np.pi * DIAMETER**2 / 4.0
    x, _, z = VESSEL - RISER
    return Line(float(x), float(z), LENGTH, STRETCH, (MASS - WATER * area) * GRAVITY)


def forces_exactly() -> list[float]:
    """Forces on the top and on the bottom at rest, kN."""
    H, V, _, _ = exact_lines.stiff_cable(line(), BENDING)
    return [1e-3 * H, 1e-3 * V, 1e-3 * H, 1e-3 * (line().weight * LENGTH - V)]


def setting_out(t: Array) -> Array:
    """How far the vessel is from its place, m: a sine that sets out smoothly."""
    part = np.minimum(t / PERIOD, 1.0)
    return AMPLITUDE * part**3 * (10.0 - 15.0 * part + 6.0 * part**2) * np.sin(2.0 * np.pi * t / PERIOD)


def robot(motion: Motion | None) -> Robot:
    """The jumper in the plane, or in space if the vessel leaves the plane."""
    second_moment = np.pi * DIAMETER**4 / 64.0
    young = BENDING / second_moment
    across = motion is not None and motion.axis == 1
    strains = {"bend_y": BENDS} | ({"bend_z": BENDS} if across else {})
    segment = Segment(
        LENGTH / SEGMENTS,
        DIAMETER / 2.0,
        young,
        young / 3.0,
        MASS / (np.pi * DIAMETER**2 / 4.0),
        strains,
    )
    joint = Spherical() if across else Revolute((0.0, 1.0, 0.0))
    links = [Link("jumper", joint=joint, rod=[segment] * SEGMENTS, position=RISER)]
    if motion is None:
        top = LoopEnd(position=VESSEL)
    else:
        t = np.arange(0.0, PERIOD + SHOWN + 2.0 * STEP, TABLE_STEP)
        moved = np.zeros((len(t), 3))
        moved[:, motion.axis] = setting_out(t)
        links.append(Link("vessel", joint=Free(motion=BaseMotion(translation=(t, moved))), position=VESSEL))
        top = LoopEnd("vessel")
    return Robot(
        links,
        gravity=(0.0, 0.0, -GRAVITY),
        loops=[Loop(LoopEnd("jumper", LENGTH), top, Spherical(), name="top")],
        fluid=Fluid(WATER, drag_coefficients=(DRAG, 0.0), added_mass_coefficient=ADDED_MASS),
    )


def still() -> tuple[Robot, StaticsResult]:
    """The jumper at rest."""
    model = robot(None)
    s = np.linspace(0.0, LENGTH, 401)
    x, z = exact_lines.hanging_shape(line(), exact_lines.hanging(line()), s)
    start = model.coordinates_of(np.column_stack([x, 0.0 * x, z]), X=s, link="jumper").q
    return model, statics(model, start)


def at_rest() -> Answer:
    """Forces at rest."""
    model, found = still()
    nothing = np.zeros(model.n)
    low = model.base_wrench(found.q, nothing, nothing)[3:]
    up = np.ravel(model.loop_forces(found.q, nothing, nothing, name="top"))[3:]
    values = 1e-3 * np.array([-up[0], -up[2], -low[0], low[2]])

    def plot() -> Plot:
        s = np.linspace(0.0, LENGTH, 121)
        shape = model.pose(found.q, s, link="jumper")[:, :3, 3]
        _, _, x, z = exact_lines.stiff_cable(line(), BENDING)
        return Plot(
            "x (m)",
            "z (m)",
            [
                Curve("lissom", shape[:, 0], shape[:, 2]),
                Curve("collocation", x[::4] + RISER[0], z[::4] + RISER[2], joined=False),
            ],
            to_scale=True,
        )

    return Answer(np.abs(values), plot, "" if found.success else found.message)


def tensions(motion: Motion) -> tuple[Array, Array, str]:
    """Times after the vessel has set out, tensions at the top, kN, and what went wrong."""
    rest, found = still()
    model = robot(motion)
    start = np.zeros(model.n)
    known = dict(zip(rest.coordinates, found.q, strict=True))
    # A ball joint turns about y where the hinge does.
    known["jumper.rotation_y"] = found.q[0]
    for i, name in enumerate(model.coordinates):
        start[i] = known.get(name, 0.0)
    result = simulate(model, PERIOD + SHOWN, dt=STEP, q0=start)
    states = zip(result.t, result.q, result.v, result.a, strict=True)
    forces = [np.ravel(model.loop_forces(q, v, a, t=t, name="top"))[3:] for t, q, v, a in states]
    return (
        result.t - PERIOD,
        1e-3 * np.linalg.norm(forces, axis=1),
        "" if result.success else result.message,
    )


def moved() -> Answer:
    """Tensions at the published times."""
    at = EVERY * np.arange(1, len(MOTIONS[0].tensions) + 1)
    values, curves, failures = [], [], []
    for motion in MOTIONS:
        t, tension, failure = tensions(motion)
        failures += [failure] if failure else []
        values += list(np.interp(at, t, tension))
        curves += [
            Curve(f"lissom, {motion.name}", t[t >= 0.0], tension[t >= 0.0]),
            Curve(f"published, {motion.name}", at, motion.tensions, joined=False),
        ]
    return Answer(values, lambda: Plot("t (s)", "tension at the top (kN)", curves), " ".join(failures))


CASES = (
    Case(
        "Jumper, at rest",
        THEME,
        "A flexible pipe of 170 m between a riser 55 m and a vessel 5 m below the surface, 100 m apart: 396 "
        "mm, 165 kg/m, E I = 120.8 kN m², in water of 1000 kg/m³; lissom's does not stretch.",
        "Kirchhoff's rod with stretch, Chebyshev collocation",
        "computed",
        "horizontal and vertical force at the top and at the bottom (kN)",
        forces_exactly,
        at_rest,
        1e-4,
        others="Lowe and Langley as MoorDyn quotes them: 1e-4, four digits; MoorDyn accepts 0.2 kN",
    ),
    Case(
        "Jumper, moved",
        THEME,
        "The vessel moves by 10 m with a period of 27 s, along and across the pipe. The third published "
        "motion, up and down, lifts the end out of the water, which lissom's fluid has no surface for.",
        "Lowe and Langley 2006, as MoorDyn has digitised them",
        "published",
        "tension at the top every two seconds, surge and then sway (kN)",
        lambda: np.concatenate([motion.tensions for motion in MOTIONS]),
        moved,
        1e-2,
        others="MoorDyn accepts 1 kN; 34 lumped masses by an independent code are within 0.3 kN in these "
        "points",
    ),
)
