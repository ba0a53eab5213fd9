"""Paths of frames and arches with limit points and bifurcations."""

from __future__ import annotations

from functools import cache
from typing import Literal

import numpy as np

from ...._lissom import (
    ContinuationResult,
    Link,
    Load,
    Loop,
    LoopEnd,
    Revolute,
    Robot,
    Rod,
    Section,
    Segment,
    Spherical,
    Weld,
    continuation,
    statics,
)
from . import exact_frames
from .case import Answer, Array, Case, Curve, Plot
from .exact_frames import Beam, LeeFrame
from .rods import WEIGHTLESS

THEME = "Frames and arches"

FRAME = "frame"
#: What cannot deform in the plane, or only out of it; lengths of rigid corners relative to the legs.
RIGID, CORNER = 1e12, 1e-9


def plane_section(beam: Beam) -> Section:
    """The section of a beam that bends and stretches in the plane of x and z."""
    return Section.given((RIGID, beam.EI, RIGID, beam.EA, RIGID, RIGID), mass=1.0)


def corner(beam: Beam) -> Segment:
    """A rigid right angle, from up to the right or from the right to down."""
    length = CORNER * beam.length
    turn = (0.0, 0.5 * np.pi / length, 0.0, 1.0, 0.0, 0.0)
    return Segment(length, section=plane_section(beam), modes={}, reference_strain=turn)


# Lee's frame

#: Legs of 120, E = 7.2e6, A = 6, I = 2; the load at a fifth of the second leg (inches, pounds).
LEG = Beam(120.0, 7.2e6 * 2.0, 7.2e6 * 6.0)
AT = LEG.length / 5.0
Frame = Literal["world", "body"]
#: Scale of the loads of paths, and those of the two limit points as starts of the shooting: angle and force
#: of the
#: first foot, and load, as `LeeFrame` has them (found by following the path once).
FULL: dict[Frame, float] = {"world": 40e3, "body": 45e3}
STARTS: dict[Frame, tuple[tuple[float, float, float, float], ...]] = {
    "world": ((0.655677, -3.51317, -14.20178, 18.55676), (-1.358709, -5.29108, -4.8357, -9.41455)),
    "body": ((0.705329, -7.05019, -16.68202, 35.4383), (-0.880812, -2.76781, -3.35829, -13.90958)),
}
#: Modes of bending and stretch of a leg.
BENDS, STRETCHES = 12, 8
#: Points of the published paths, displacement down and load / 1000, as digitised for AeroBeams
#: (test/referenceData/LeeFrame*Load/u3.txt, MIT): every fourth.
DIGITISED: dict[Frame, tuple[tuple[float, float], ...]] = {
    "world": (
        (0.26426, 0.35036),
        (5.3074, 6.3286),
        (14.537, 11.813),
        (27.626, 15.589),
        (40.873, 18.287),
        (53.814, 18.219),
        (61.263, 11.737),
        (58.106, 5.7417),
        (51.088, -1.8774),
        (51.21, -6.5011),
        (55.463, -9.2648),
        (66.678, -8.0929),
        (81.314, -2.6299),
        (87.868, 3.6447),
        (92.198, 14.79),
        (93.747, 27.176),
        (94.74, 40.167),
    ),
    "body": (
        (0.30164, 0.44932),
        (7.7382, 8.5842),
        (14.892, 13.808),
        (22.194, 17.25),
        (29.78, 20.688),
        (37.47, 24.134),
        (44.099, 26.946),
        (50.784, 30.022),
        (57.949, 32.973),
        (65.77, 35.067),
        (72.643, 35.176),
        (76.7, 31.851),
        (77.198, 25.352),
        (74.622, 19.304),
        (70.816, 14.765),
        (65.953, 10.68),
        (59.824, 5.9297),
        (54.044, 1.3085),
        (49.444, -3.8018),
        (45.985, -9.0968),
        (45.498, -13.505),
        (50.121, -12.995),
        (57.435, -10.493),
        (63.968, -8.6875),
        (73.437, -6.6931),
        (80.959, -3.9805),
        (84.781, 0.2221),
        (87.896, 7.8717),
        (89.778, 19.255),
        (90.857, 30.188),
        (91.123, 40.123),
    ),
}


def lee_frame(frame: Frame) -> Robot:
    """The frame under its full load."""
    strains = {"bend_y": BENDS, "stretch": STRETCHES}
    section = plane_section(LEG)
    rod = [
        Segment(LEG.length, section=section, modes=strains),
        corner(LEG),
        Segment(AT, section=section, modes={"bend_y": BENDS // 2, "stretch": STRETCHES // 2}),
        Segment(LEG.length - AT, section=section, modes=strains),
    ]
    half = np.sqrt(0.5)
    link = Link(FRAME, rod=rod, joint=Revolute((0.0, 1.0, 0.0)), orientation=(half, 0.0, -half, 0.0))
    end = (2.0 + CORNER) * LEG.length
    foot = Loop(
        LoopEnd(FRAME, end), LoopEnd(position=(LEG.length, 0.0, LEG.length)), Spherical(), name="foot"
    )
    push = Load(force=(0.0, 0.0, -FULL[frame]), link=FRAME, at=loaded_point(), frame=frame)
    return Robot([link], gravity=WEIGHTLESS, loops=[foot], loads=[push])


def loaded_point() -> float:
    """Arc length of the load."""
    return (1.0 + CORNER) * LEG.length + AT


def lee_moved(model: Robot, q: Array) -> Array:
    """Displacement of the loaded point to the right and down, shape (..., 2)."""
    place = model.pose(q, loaded_point(), link=FRAME)[..., :3, 3]
    return np.stack([place[..., 0] - AT, LEG.length - place[..., 2]], axis=-1)


def lee_path(frame: Frame, max_step: float = 0.25) -> tuple[Robot, ContinuationResult]:
    """The whole path."""
    model = lee_frame(frame)
    return model, continuation(model, bounds=(-1.0, 1.0), max_step=max_step)


@cache
def lee_wanted(frame: Frame) -> Array:
    """Both limit loads with the displacements there, by shooting."""
    lee = LeeFrame(LEG, AT, follows=frame == "body")
    return np.concatenate([lee.limit(start) for start in STARTS[frame]])


def lee_plot(frame: Frame, model: Robot, found: ContinuationResult) -> Plot:
    """The path beside the published points."""
    moved, load = lee_moved(model, found.path.q), FULL[frame] * found.path.load_factor / 1e3
    down, published = np.transpose(DIGITISED[frame])
    return Plot(
        "displacement down",
        "load / 1000",
        [Curve("lissom", moved[:, 1], load), Curve("published", down, published, joined=False)],
    )


def lee(frame: Frame) -> Answer:
    """Limit points."""
    model, found = lee_path(frame)
    points = [point for point in found.path.critical_points if point.kind == "limit"]
    values = [
        value for point in points for value in (FULL[frame] * point.load_factor, *lee_moved(model, point.q))
    ]
    return Answer(values, lambda: lee_plot(frame, model, found), "" if found.success else found.message)


def lee_published(frame: Frame) -> Answer:
    """Largest distance of the published points from the path, in units of 100 inches and 20 000 pounds."""
    model, found = lee_path(frame, max_step=0.1)
    unit = np.array([100.0, 20.0])
    path = np.column_stack([lee_moved(model, found.path.q)[:, 1], FULL[frame] * found.path.load_factor / 1e3])
    path, points = path / unit, np.array(DIGITISED[frame]) / unit
    start, along = path[:-1], np.diff(path, axis=0)
    share = np.einsum("psi,si->ps", points[:, None] - start, along) / np.einsum("si,si->s", along, along)
    nearest = start + np.clip(share, 0.0, 1.0)[..., None] * along
    distance = np.linalg.norm(points[:, None] - nearest, axis=-1).min(axis=1)
    return Answer(
        [distance.max()], lambda: lee_plot(frame, model, found), "" if found.success else found.message
    )


# Arch

#: AeroBeams' archUnderFollowerPressure.jl: R = 2.54 m, 120 degrees, A = 4.05e-4 m^2, I = 13.1e-8 m^4, E =
#: 70.4 GPa.
ARCH_RADIUS, OPENING = 2.54, 2.0 * np.pi / 3.0
ARCH = Beam(ARCH_RADIUS * OPENING, 70.4e9 * 13.1e-8, 70.4e9 * 4.05e-4, -1.0 / ARCH_RADIUS)
#: Largest pressure of the paths, in units of E I / R^3, and the start of the shooting: drop, thrust, moment,
#: pressure.
PRESSURE, ARCH_START = 40.0, (0.0164, 28.3, 0.268, 27.89)
PARTS = 4


def arch(stretches: int) -> Robot:
    """An arch between clamps under pressure, that can stretch or not."""
    strains = {"bend_y": 8} | ({"stretch": stretches} if stretches else {})
    segment = Segment(
        ARCH.length / PARTS,
        section=plane_section(ARCH),
        modes=strains,
        reference_strain=(0.0, 1.0 / ARCH_RADIUS, 0.0, 1.0, 0.0, 0.0),
    )
    quarter = 0.25 * OPENING
    rise = (np.cos(quarter), 0.0, -np.sin(quarter), 0.0)
    fall = (np.cos(quarter), 0.0, np.sin(quarter), 0.0)
    span = 2.0 * ARCH_RADIUS * np.sin(0.5 * OPENING)
    clamp = LoopEnd(position=(span, 0.0, 0.0), orientation=fall)
    pressure = PRESSURE * ARCH.EI / ARCH_RADIUS**3
    return Robot(
        [Link(FRAME, rod=[segment] * PARTS, orientation=rise)],
        gravity=WEIGHTLESS,
        loads=[Load(force=(0.0, 0.0, -pressure), along=(0.0, ARCH.length), link=FRAME, frame="body")],
        loops=[Loop(LoopEnd(FRAME, ARCH.length), clamp, Weld(), name="clamp")],
    )


def crown_drop(model: Robot, q: Array) -> Array:
    """How far the crown has come down, in units of R."""
    height = model.pose(q, 0.5 * ARCH.length, link=FRAME)[..., 2, 3]
    return np.asarray((1.0 - np.cos(0.5 * OPENING)) - height / ARCH_RADIUS)


def arch_path(kind: Literal["limit", "bifurcation"], stretches: int, point: tuple[float, float]) -> Answer:
    """The symmetric path of the arch and its first critical point of a kind."""
    model = arch(stretches)
    upper = 0.5 if kind == "bifurcation" else 1.0
    found = continuation(model, bounds=(0.0, upper))
    critical = [event for event in found.path.critical_points if event.kind == kind]
    if not critical:
        return Answer([np.nan], lambda: Plot("", "", []), f"no {kind} was found")
    first = critical[0]
    values = [PRESSURE * first.load_factor]
    if kind == "limit":
        values.append(float(crown_drop(model, first.q)))
    return Answer(
        values,
        lambda: Plot(
            "drop of the crown / R",
            "q R³ / (E I)",
            [
                Curve("lissom", crown_drop(model, found.path.q), PRESSURE * found.path.load_factor),
                Curve("reference", [point[1]], [point[0]], joined=False),
            ],
        ),
        "" if found.success else found.message,
    )


@cache
def arch_limit() -> tuple[float, float]:
    """First limit of the pressure and drop of the crown."""
    return exact_frames.arch_limit(ARCH, OPENING, ARCH_START)


# Bent frame

#: AeroBeams' rightAngledFrame.jl: legs of 0.24 m, A = 0.18e-4 m^2, I = 0.135e-8 m^4, E = 71.24 GPa.
BENT = Beam(0.24, 7.124e10 * 0.135e-8, 7.124e10 * 0.18e-4)
BENT_FORCES = (500.0, 1500.0, 2500.0, 4000.0)
#: Force (N) and displacement to the left / L as digitised for AeroBeams (u1.txt): every sixth point.
BENT_DIGITISED = (
    (5.6372, 0.003655),
    (248.33, 0.19058),
    (609.01, 0.42242),
    (1058.9, 0.66321),
    (1594.2, 0.84282),
    (2064.5, 0.94037),
    (2610.3, 0.98891),
    (3107.1, 0.95193),
    (3570.2, 0.94828),
    (3752.2, 0.88996),
    (4116.3, 0.85811),
)


@cache
def bent_wanted() -> Array:
    """Displacements / L and turns / pi, by integration from the tip."""
    unit = np.array([BENT.length, BENT.length, np.pi])
    return np.concatenate([np.array(exact_frames.bent_frame(BENT, force)) / unit for force in BENT_FORCES])


def bent_frame() -> Answer:
    """A force that stays normal to the tip pulls the second leg up."""
    leg = Segment(BENT.length, section=plane_section(BENT), modes={"bend_y": BENDS, "stretch": 4})
    values, lines, failures = [], [], []
    for force in (1000.0, 2000.0, 3000.0, *BENT_FORCES):
        push = Load(force=(0.0, 0.0, -force), frame="body")
        rod = Rod([leg, corner(BENT), leg], gravity=WEIGHTLESS, loads=[push])
        found = statics(rod)
        tip = rod.pose(found.q, rod.length)
        left, up = tip[0, 3] / BENT.length - 1.0, tip[2, 3] / BENT.length + 1.0
        # Clockwise from hanging: the tip points up to the left in the end.
        turn = (-0.5 - np.arctan2(tip[2, 0], tip[0, 0]) / np.pi) % 2.0
        lines.append((force, -left))
        if force in BENT_FORCES:
            values += [left, up, turn]
        failures += [] if found.success else [found.message]
    x, y = np.transpose(sorted(lines))
    digitised = np.transpose(BENT_DIGITISED)
    return Answer(
        values,
        lambda: Plot(
            "force (N)",
            "displacement to the left / L",
            [Curve("lissom", x, y), Curve("published", digitised[0], digitised[1], joined=False)],
        ),
        " ".join(failures),
    )


#: Frame of the load, its name, and what the published paths say of the limit points.
LEE: tuple[tuple[Frame, str, str], ...] = (
    ("world", "dead", "published path as digitised, 18 761 and −9466: 1e-2"),
    ("body", "following", "published path as digitised, 35 527 and −13 917: 3e-3"),
)

CASES = (
    *(
        Case(
            f"Lee's frame, {name} load",
            THEME,
            f"Two legs of 120 at a right angle between pins, E = 7.2e6, A = 6, I = 2, with a {name} load "
            f"at a fifth of "
            f"the second leg. The path to {FULL[frame]:.0f} has two limit points; {BENDS} modes of bending "
            f"and "
            f"{STRETCHES} of stretch in a leg.",
            "Case of Lee, Manuel and Rossow 1968; Runge-Kutta shooting",
            "computed",
            "load, displacement to the right and down at both",
            lambda frame=frame: lee_wanted(frame),  # type: ignore[misc]
            lambda frame=frame: lee(frame),  # type: ignore[misc]
            1e-6,
            others=others,
        )
        for frame, name, others in LEE
    ),
    *(
        Case(
            f"Lee's frame, {name} load, published",
            THEME,
            f"The same path beside {len(DIGITISED[frame])} of the published points, as AeroBeams has "
            f"digitised them.",
            "Published path, AeroBeams' test/referenceData",
            "published",
            "largest distance of a point from the path, in units of 100 (down) and 20 000 (load)",
            lambda: [0.0],
            lambda frame=frame: lee_published(frame),  # type: ignore[misc]
            2e-2,
            scale=1.0,
        )
        for frame, name, _ in LEE
    ),
    Case(
        "Arch under pressure, sway",
        THEME,
        "An arch of 120 degrees between clamps under a pressure that stays normal to it, without stretch; "
        "4 segments "
        "with 8 modes. It buckles to one side before it snaps.",
        "Timoshenko and Gere 1961, 7.6; k tan α cot k α = 1",
        "exact",
        "buckling pressure × R³ / (E I)",
        lambda: [exact_frames.arch_sway(OPENING)],
        lambda: arch_path("bifurcation", 0, (exact_frames.arch_sway(OPENING), 0.0)),
        1e-9,
    ),
    Case(
        "Arch under pressure, snap",
        THEME,
        "The same arch with R = 2.54 m, E A R² / (E I) = 2e4, on its symmetric path, which goes on beyond "
        "that point to a "
        "limit.",
        "Case of AeroBeams' archUnderFollowerPressure; Runge-Kutta shooting",
        "computed",
        "limit of q R³ / (E I), drop of the crown / R",
        lambda: arch_limit(),
        lambda: arch_path("limit", 4, arch_limit()),
        1e-6,
    ),
    Case(
        "Bent frame, following force",
        THEME,
        "Legs of 240 mm at a right angle, E I = 96.2 N m², clamped; a force of 0.5, 1.5, 2.5 and 4 kN at "
        "the tip stays "
        "normal to it.",
        "Case of AeroBeams' rightAngledFrame; integration from the tip",
        "exact",
        "displacement along and up / L, turn / π for each",
        bent_wanted,
        bent_frame,
        1e-6,
        others="published points as AeroBeams has digitised them: within 2e-2 up to 2.6 kN; beyond that the "
        "displacement along falls to 0.86 at 4.1 kN, where equilibrium has 1.00",
    ),
)
