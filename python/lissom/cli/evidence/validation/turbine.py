"""The vertical-axis wind turbine of Sandia with 34 m, whose frequencies were measured."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...._lissom import (
    BaseMotion,
    Harmonic,
    Link,
    Loop,
    LoopEnd,
    Revolute,
    Robot,
    Section,
    Segment,
    Weld,
    modes,
    statics,
)
from .case import Answer, Array, Case, Curve, Plot

THEME = "Wind turbine"

#: Tower, blades and struts as in GXBeam's docs/src/literate/vertical-axis-wind-turbine.jl (MIT), from
#: SAND-91-2228 and
#: SAND-88-1807; SI units. Height; stiffness (torsion, bend_y, bend_z, stretch, shear_y, shear_z), mass and
#: inertia.
HEIGHT = 41.9
TOWER = Section.given(
    (7.0428e9, 9.4072e9, 9.4072e9, 8.4404e9, 2.7053e9, 2.7053e9),
    mass=330.755,
    inertia=(737.282, 368.641, 368.641),
)
#: Sections of the blades at their roots, between, and in the middle: torsion, flat and edge bending,
#: stretch, its
#: coupling with edge bending, shear; mass, its offset times mass, inertia about the axis of torsion and both
#: bendings.
#: The offset is along the chord: as printed there it is across, and the matrix of masses not positive.
BLADES = tuple(
    Section.given(
        np.array(
            [
                [torsion, 0.0, 0.0, 0.0, 0.0, 0.0],
                [0.0, flat, 0.0, 0.0, 0.0, 0.0],
                [0.0, 0.0, edge, coupling, 0.0, 0.0],
                [0.0, 0.0, coupling, stretch, 0.0, 0.0],
                [0.0, 0.0, 0.0, 0.0, shear, 0.0],
                [0.0, 0.0, 0.0, 0.0, 0.0, shear],
            ]
        ),
        mass=mass,
        inertia=(around - offset**2 / mass, turn_flat, turn_edge - offset**2 / mass),
        centre=(offset / mass, 0.0),
    )
    for torsion, flat, edge, stretch, coupling, shear, mass, offset, around, turn_flat, turn_edge in (
        (
            *(1.87992e7, 2.24336e7, 4.09242e8, 3.74563e9, 1.14382e8, 1.20052e9),
            *(146.781, 28.7783, 16.7793, 0.879112, 15.9002),
        ),
        (
            *(6.55493e6, 7.35548e6, 1.84227e8, 2.22783e9, 4.20422e7, 7.14048e8),
            *(87.3025, 16.7316, 7.47649, 0.288241, 7.18825),
        ),
        (
            *(4.00804e6, 4.34302e6, 1.09341e8, 1.76888e9, 2.34071e7, 5.66947e8),
            *(69.3173, 11.5831, 4.44282, 0.170191, 4.27263),
        ),
    )
)
#: Heights at which the sections of a blade change, and the sections from below.
CHANGES, ORDER = (5.8, 11.1, 29.0, 34.7), (0, 1, 2, 1, 0)
#: Points of a blade: distance from the axis and height.
SHAPE = np.array(
    [
        (0.0, 0.0),
        (2.26837, 1.257),
        (3.63183, 2.095),
        (6.76113, 4.19),
        (9.55882, 6.285),
        (11.8976, 8.38),
        (13.7306, 10.475),
        (15.1409, 12.57),
        (16.1228, 14.665),
        (16.7334, 16.76),
        (17.0133, 18.855),
        (17.0987, 20.95),
        (16.9615, 23.045),
        (16.5139, 25.14),
        (15.7435, 27.235),
        (14.5458, 29.33),
        (12.9287, 31.425),
        (10.8901, 33.52),
        (8.547, 35.615),
        (5.93739, 37.71),
        (3.05842, 39.805),
        (1.87486, 40.643),
        (0.0, 41.9),
    ]
)
#: Points of the blade at which struts hold it.
STRUTS = (1, len(SHAPE) - 2)
#: Length of the rigid kinks between straight pieces, m; modes of a piece and of a part of the tower.
KINK = 1e-7
PIECE = {"torsion": 1, "bend_y": 2, "bend_z": 2}
PART, PARTS = {"torsion": 1, "bend_y": 3, "bend_z": 3}, 4

#: Speeds, revolutions a minute, and measured frequencies (Hz) of the first and of the second mode of
#: flapping (of the
#: latter the mean of the modes with both blades to the same side and to opposite sides), read off the points
#: that
#: GXBeam's documentation has of SAND-91-2228.
SPEEDS = (0.0, 34.0)
MEASURED = ((1.067, 2.133), (1.260, 2.649))


def blade() -> tuple[list[Segment], list[float], Array]:
    """A blade in straight pieces with rigid kinks between them: its segments, arc lengths and angles of "
    "its points."""
    segments: list[Segment] = []
    steps = np.diff(SHAPE, axis=0)
    angles = np.arctan2(steps[:, 1], steps[:, 0])
    places = [0.0]
    for i, (step, angle) in enumerate(zip(steps, angles, strict=True)):
        middle = 0.5 * (SHAPE[i, 1] + SHAPE[i + 1, 1])
        section = BLADES[ORDER[int(np.searchsorted(CHANGES, middle))]]
        length = places[-1]
        if i:
            turn = (0.0, (angles[i - 1] - angle) / KINK, 0.0, 1.0, 0.0, 0.0)
            segments.append(Segment(KINK, section=section, modes={}, reference_strain=turn))
            length += KINK
        segments.append(Segment(float(np.hypot(*step)), section=section, modes=PIECE))
        places.append(length + float(np.hypot(*step)))
    return segments, places, angles


def product(a: Sequence[float], b: Sequence[float]) -> tuple[float, float, float, float]:
    """Product of two quaternions (w, x, y, z)."""
    w, x, y, z = a
    W, X, Y, Z = b
    return (
        w * W - x * X - y * Y - z * Z,
        w * X + x * W + y * Z - z * Y,
        w * Y - x * Z + y * W + z * X,
        w * Z + x * Y - y * X + z * W,
    )


#: The tower's axis points up.
HALF = float(np.sqrt(0.5))
UPRIGHT = (HALF, 0.0, -HALF, 0.0)


def on_tower(angle: float, side: int) -> tuple[float, float, float, float]:
    """Orientation relative to the tower of what rises at an angle, to one side or the other."""
    rise = (float(np.cos(angle / 2.0)), 0.0, -float(np.sin(angle / 2.0)), 0.0)
    turned = product((0.0, 0.0, 0.0, 1.0), rise) if side else rise
    return product((HALF, 0.0, HALF, 0.0), turned)


def turbine(speed: float) -> Robot:
    """Tower, two blades and four struts; the top is held, and can turn about the axis."""
    segments, places, angles = blade()
    low, high = SHAPE[STRUTS[0], 1], SHAPE[STRUTS[1], 1]
    root = Segment(float(low), section=TOWER, modes=PIECE)
    part = Segment(float(high - low) / PARTS, section=TOWER, modes=PART)
    top = LoopEnd(position=(0.0, 0.0, HEIGHT), orientation=UPRIGHT)
    links = [Link("tower", rod=[root, *[part] * PARTS, root], orientation=UPRIGHT)]
    loops = [Loop(LoopEnd("tower", HEIGHT), top, Revolute((1.0, 0.0, 0.0)), name="top")]
    for side in (0, 1):
        name = f"blade {side}"
        links.append(Link(name, parent="tower", at=0.0, rod=segments, orientation=on_tower(angles[0], side)))
        end = LoopEnd("tower", HEIGHT, orientation=on_tower(angles[-1], side))
        loops.append(Loop(LoopEnd(name, places[-1]), end, Weld(), name=f"{name} top"))
        for point in STRUTS:
            strut = f"strut {side}, {point}"
            distance, height = SHAPE[point]
            rod = [Segment(float(distance), section=BLADES[0], modes=PIECE)]
            level = on_tower(0.0, side)
            links.append(Link(strut, parent="tower", at=float(height), rod=rod, orientation=level))
            half = angles[point - 1] / 2.0
            held = LoopEnd(name, places[point], orientation=(np.cos(half), 0.0, np.sin(half), 0.0))
            loops.append(Loop(LoopEnd(strut, float(distance)), held, Weld(), name=f"{strut} end"))
    turning = BaseMotion(axis=(0.0, 0.0, 1.0), angle=Harmonic(rate=speed * 2.0 * np.pi / 60.0))
    return Robot(links, loops=loops, base_motion=turning)


def flapping() -> Answer:
    """First and second frequencies of flapping, at rest and turning: each of them twice, the blades' "
    "means."""
    values, found, failures = [], [], []
    for speed in SPEEDS:
        model = turbine(speed)
        rest = statics(model, stability=False)
        failures += [] if rest.success else [rest.message]
        frequency = modes(model, rest.q).frequency
        found.append(frequency[:8])
        # In between are the modes of the blades' edges, 1.6 and 1.7 Hz.
        values += [float(frequency[:2].mean()), float(frequency[4:6].mean())]

    def plot() -> Plot:
        curves = [
            Curve(f"lissom, mode {i + 1}", SPEEDS, [line[i] for line in found]) for i in range(len(found[0]))
        ]
        curves += [
            Curve(f"measured, {i + 1}", SPEEDS, np.array(MEASURED)[:, i], joined=False) for i in (0, 1)
        ]
        return Plot("revolutions a minute", "frequency (Hz)", curves)

    return Answer(values, plot, " ".join(failures))


CASES = (
    Case(
        "34 m turbine, measured",
        THEME,
        "Sandia's vertical-axis turbine: tower, two blades of 22 straight pieces each and four struts, "
        "welded by loops, "
        "the top held, at rest and at 34 revolutions a minute, under its weight. A run of some seconds.",
        "SAND-91-2228, measured, as GXBeam has it",
        "published",
        "first and second frequency of flapping at 0 and 34 revolutions a minute (Hz)",
        lambda: np.ravel(MEASURED),
        flapping,
        6e-2,
    ),
)
