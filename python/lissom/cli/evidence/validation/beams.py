"""Beams under tip loads, held ends and vibrating beams of other codes' test suites."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Literal

import numpy as np

from ...._lissom import (
    Body,
    Joint,
    Link,
    Load,
    Loop,
    LoopEnd,
    Planar,
    Prismatic,
    Revolute,
    Robot,
    Rod,
    Section,
    Segment,
    Spherical,
    Weld,
    modes,
    simulate,
    statics,
)
from . import exact, exact_space
from .case import Answer, Array, Case, Curve, Plot
from .dynamics import unfinished
from .rods import WEIGHTLESS, Plane, at_rest, tip
from .statics import planar_points, planar_tip

THEME = "Beams of other test suites"

BEAM = "beam"

# Cantilever of the benchmark

#: cosseratbench: L = 1 m, radius 20 mm, E = 3 G = 1 MPa, a force of 7.5e-3 N.
SMALL_RADIUS, SMALL_YOUNG, SMALL_FORCE = 0.02, 1e6, 7.5e-3
SMALL_BENDING = SMALL_YOUNG * np.pi / 4.0 * SMALL_RADIUS**4


def small() -> Answer:
    """Deflection of the tip; the rod can stretch and shear."""
    strains = {"bend_y": 6, "stretch": 2, "shear_z": 4}
    segment = Segment(1.0, SMALL_RADIUS, SMALL_YOUNG, SMALL_YOUNG / 3.0, 1000.0, strains)
    rod = Rod([segment], gravity=WEIGHTLESS, tip_force=(0.0, 0.0, -SMALL_FORCE))
    x = np.linspace(0.0, 1.0, 21)
    linear = -SMALL_FORCE * x**2 * (3.0 - x) / (6.0 * SMALL_BENDING)
    answer = at_rest(
        [("lissom", rod)], lambda rod, q: -tip(rod, q)[2], lambda: [("linear theory", x, linear)]
    )
    return replace(answer, plot=lambda: replace(answer.plot(), to_scale=False))


# Soft in shear

#: Batista (2016), IJSS 81: E I = 10, force 10, G A = 500 and 10; without stretch.
SOFT_BENDING, SOFT_FORCE, SOFT_SHEARS = 10.0, 10.0, (500.0, 10.0)


@cache
def soft_shape(shear: float) -> exact.PlanarShape:
    """By collocation."""
    return exact.planar_rod(1.0, lambda X: SOFT_BENDING + 0.0 * X, force=(0.0, -SOFT_FORCE), GA=shear)


def soft() -> Answer:
    """Cantilevers that shear as much as they bend."""
    rods = []
    for shear in SOFT_SHEARS:
        section = Section.given((SOFT_BENDING, SOFT_BENDING, SOFT_BENDING, 1e7, shear, shear), mass=1.0)
        segment = Segment(1.0, section=section, modes={"bend_y": 10, "shear_z": 10})
        rods.append(
            (
                f"lissom, G A = {shear:g}",
                Rod([segment], gravity=WEIGHTLESS, tip_force=(0.0, 0.0, -SOFT_FORCE)),
            )
        )
    return at_rest(
        rods,
        lambda rod, q: tip(rod, q)[[0, 2]],
        lambda: [planar_points(f"collocation, G A = {shear:g}", soft_shape(shear)) for shear in SOFT_SHEARS],
    )


# An eighth of a circle, pushed

#: Ibrahimbegovic, Frey and Kozar (1995), IJNME 38: L = 10, E = G = 1e4, A = 1, I = J = 1e-2.
EIGHTH_LENGTH, EIGHTH_STIFFNESS = 10.0, (100.0, 100.0, 100.0, 1e4, 1e4, 1e4)
EIGHTH_MOMENT = (0.0, 0.0, 2.0 * np.pi * 100.0 / 10.0 / 8.0)
EIGHTH_FORCE = (0.0, 0.0, 1.0 / 16.0)
#: Moments fixed in space and turning with the tip.
FRAMES: tuple[tuple[str, Literal["world", "body"]], ...] = (("fixed", "world"), ("turning", "body"))


@cache
def eighth_line(follows: bool) -> Array:
    """Centre line by shooting."""
    straight = (0.0, 0.0, 0.0)
    return exact_space.pushed_rod(
        EIGHTH_LENGTH, EIGHTH_STIFFNESS, straight, EIGHTH_FORCE, EIGHTH_MOMENT, follows=follows
    )


def eighth() -> Answer:
    """A moment that bends to an eighth of a circle, and a small force across; fixed and turning moment."""
    strains = dict.fromkeys(("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"), 6)
    section = Section.given(np.diag(EIGHTH_STIFFNESS), mass=1.0)
    segment = Segment(EIGHTH_LENGTH, section=section, modes=strains)
    rods = [
        (
            f"lissom, {name}",
            Rod(
                [segment],
                gravity=WEIGHTLESS,
                tip_force=EIGHTH_FORCE,
                loads=[Load(moment=EIGHTH_MOMENT, frame=frame)],
            ),
        )
        for name, frame in FRAMES
    ]
    plane = Plane(("x", "z"))
    return at_rest(
        rods,
        tip,
        lambda: [
            (f"shooting, {name}", *plane.of(eighth_line(follows)[::20]))
            for name, follows in (("fixed", False), ("turning", True))
        ],
        plane,
    )


# Bend of 45 degrees by GXBeam

#: test/examples/curved.jl (MIT): G A is not reduced, G J = E / 12.
GX_STIFFNESS = (5e6 / 6.0, 1e7 / 12.0, 1e7 / 12.0, 1e7, 5e6, 5e6)
GX_RADIUS, GX_FORCE = 100.0, 600.0
GX_LENGTH = GX_RADIUS * np.pi / 4.0


@cache
def gx_line() -> Array:
    """Centre line by shooting."""
    curvature, force = (0.0, 0.0, 1.0 / GX_RADIUS), (0.0, 0.0, GX_FORCE)
    return exact_space.pushed_rod(GX_LENGTH, GX_STIFFNESS, curvature, force, (0.0, 0.0, 0.0))


def gx_displacement(end: Array) -> Array:
    """Displacement of the tip in GXBeam's axes: x across, y along the beam's start."""
    start = np.array([np.sin(np.pi / 4.0), 1.0 - np.cos(np.pi / 4.0), 0.0]) * GX_RADIUS
    along, across, up = end - start
    return np.array([across, along, up])


def gx_bend() -> Answer:
    """The bend under 600."""
    strains = dict.fromkeys(("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"), 8)
    segment = Segment(
        GX_LENGTH,
        section=Section.given(np.diag(GX_STIFFNESS), mass=1.0),
        modes=strains,
        reference_strain=(0.0, 0.0, 1.0 / GX_RADIUS, 1.0, 0.0, 0.0),
    )
    rod = Rod([segment], gravity=WEIGHTLESS, tip_force=(0.0, 0.0, GX_FORCE))
    return at_rest(
        [("lissom", rod)],
        lambda rod, q: gx_displacement(tip(rod, q)),
        lambda: [("shooting", gx_line()[::20, 0], gx_line()[::20, 2])],
    )


# Held bent and twisted

#: Newton's example_cable_bend_twist_analytic.py: 14 bodies 0.1 m apart; its joints of 400 and 120 N m/rad.
HELD_LENGTH, HELD_BENDING, HELD_TORSION = 1.4, 40.0, 12.0
HELD_ANGLES = tuple(np.radians((30.0, 60.0, 90.0)))


def held_end(angle: float) -> LoopEnd:
    """Where the end of a cable with constant strains (twist, bend, 0) of ``angle`` / L is."""
    rate = np.array([angle, angle, 0.0]) / HELD_LENGTH
    size = float(np.linalg.norm(rate))
    axis, turn = rate / size, size * HELD_LENGTH
    along = np.array([1.0, 0.0, 0.0])
    straight = (axis @ along) * axis
    around = along - straight
    # The integral of the rotated axis of the rod.
    place = (
        HELD_LENGTH * straight + (np.sin(turn) * around + (1.0 - np.cos(turn)) * np.cross(axis, along)) / size
    )
    return LoopEnd(position=place, orientation=(np.cos(turn / 2.0), *(np.sin(turn / 2.0) * axis)))


def held_cable(angle: float) -> Robot:
    """A cable whose far end is held where constant bend and twist would bring it."""
    stiffness = (HELD_TORSION, HELD_BENDING, HELD_BENDING, 1e6, 1e6, 1e6)
    section = Section.given(stiffness, mass=1.0, inertia=(2e-4, 1e-4, 1e-4))
    rod = [Segment(HELD_LENGTH, section=section, modes={"torsion": 6, "bend_y": 6, "bend_z": 6})]
    return Robot(
        [Link(BEAM, rod=rod)],
        gravity=WEIGHTLESS,
        loops=[Loop(LoopEnd(BEAM, HELD_LENGTH), held_end(angle), Weld(), name="end")],
    )


def held() -> Answer:
    """Smallest and largest twist and bend along the cable."""
    X = np.linspace(0.0, HELD_LENGTH, 15)
    values, curves, failures = [], [], []
    for angle in HELD_ANGLES:
        model = held_cable(angle)
        found = statics(model)
        strain = model.strain(found.q, X, link=BEAM)[:, :2] * HELD_LENGTH
        values += [*strain.min(axis=0), *strain.max(axis=0)]
        name = f"{np.degrees(angle):.0f}°"
        curves += [Curve(f"twist, {name}", X, strain[:, 0]), Curve(f"bend, {name}", X, strain[:, 1])]
        curves.append(Curve(f"helix, {name}", X, angle + 0.0 * X, joined=False))
        failures += [] if found.success else [found.message]
    return Answer(values, lambda: Plot("X (m)", "strain × L", curves), " ".join(failures))


# Twist under tension

TENSIONS = (1.0, 10.0, 30.0)
#: The rope of cosseratbench: L = 1 m, radius 10 mm, E = 1 MPa, G = E / 3, so that E I = 1.5 G J.
SHAFT_BENDING = 1e6 * np.pi / 4.0 * 0.01**4
SHAFT_TORSION = SHAFT_BENDING / 1.5
#: Final width of the bisection for the angle, rad.
ANGLE_WIDTH = 1e-7


def shaft(angle: float, tension: float) -> Robot:
    """A rod between clamps; the far one is turned by an angle, slides along and is pulled."""
    section = Section.given(
        (SHAFT_TORSION, SHAFT_BENDING, SHAFT_BENDING, 1e4, 1e4, 1e4), mass=0.3, inertia=(1.6e-5, 8e-6, 8e-6)
    )
    rod = [Segment(0.25, section=section, modes={"torsion": 1, "bend_y": 6, "bend_z": 6})] * 4
    turn = (np.cos(angle / 2.0), np.sin(angle / 2.0), 0.0, 0.0)
    end = LoopEnd(position=(1.0, 0.0, 0.0), orientation=turn)
    return Robot(
        [Link(BEAM, rod=rod)],
        gravity=WEIGHTLESS,
        loads=[Load(force=(tension * SHAFT_BENDING, 0.0, 0.0), link=BEAM)],
        loops=[Loop(LoopEnd(BEAM, 1.0), end, Prismatic((1.0, 0.0, 0.0)), name="end")],
    )


def twisted_straight(model: Robot, angle: float) -> Array:
    """The straight twisted rod."""
    q = np.zeros(model.n)
    for i, name in enumerate(model.coordinates):
        if "torsion" in name:
            q[i] = angle
    return q


def twist_to_buckling() -> Answer:
    """Moment and angle at which the straight rod becomes unstable."""
    found = []
    for tension in TENSIONS:
        low, high = 8.0, 30.0
        while high - low > ANGLE_WIDTH:
            angle = 0.5 * (low + high)
            model = shaft(angle, tension)
            stable = modes(model, twisted_straight(model, angle)).is_stable
            low, high = (angle, high) if stable else (low, angle)
        found.append(0.5 * (low + high) * SHAFT_TORSION / SHAFT_BENDING)

    def plot() -> Plot:
        pulls = np.linspace(1.0, 32.0, 13)
        wanted = [exact_space.twisted_under_tension(float(pull)) for pull in pulls]
        return Plot(
            "T L² / (E I)",
            "M L / (E I)",
            [Curve("exact", pulls, wanted), Curve("lissom", TENSIONS, found, joined=False)],
        )

    return Answer(found, plot)


# Vibrations with all ends

#: Slender, so that rotary inertia is negligible.
THIN, THIN_YOUNG, THIN_DENSITY = 1e-4, 1e9, 1000.0
ENDS = {
    "cc": "clamped, clamped",
    "cf": "clamped, free",
    "cp": "clamped, pinned",
    "cs": "clamped, sliding",
    "pp": "pinned, pinned",
    "ff": "free, free",
}
COUNT = 3


def beam_with(ends: str) -> Robot:
    """A slender beam in the plane of x and z with two ends by their first letters."""
    joint: Joint = {"c": Weld(), "p": Revolute((0.0, 1.0, 0.0)), "f": Planar((0.0, 1.0, 0.0))}[ends[0]]
    held: dict[str, Joint] = {"c": Weld(), "p": Spherical(), "s": Prismatic((0.0, 0.0, 1.0))}
    segment = Segment(1.0, THIN, THIN_YOUNG, 0.4 * THIN_YOUNG, THIN_DENSITY, {"bend_y": 16}, nodes=32)
    loops = []
    if ends[1] != "f":
        # In line the tip is free: without stretch it would hold the beam straight to first order as well.
        loops = [Loop(LoopEnd(BEAM, 1.0), LoopEnd(position=(1.0, 0.0, 0.0)), held[ends[1]], name="end")]  # type: ignore[arg-type]
    return Robot([Link(BEAM, rod=[segment], joint=joint)], gravity=WEIGHTLESS, loops=loops)


def bending_frequencies() -> Array:
    """Euler-Bernoulli."""
    return np.concatenate([exact_space.beam_roots(ends, COUNT) ** 2 for ends in ENDS])


def bending_vibrations() -> Answer:
    """Frequencies for all ends."""
    bending = THIN_YOUNG * np.pi / 4.0 * THIN**4
    unit = np.sqrt(bending / (THIN_DENSITY * np.pi * THIN**2))
    found = []
    for ends in ENDS:
        model = beam_with(ends)
        omega = modes(model, np.zeros(model.n)).angular_frequency / unit
        found.append(omega[omega > 1e-2][:COUNT])
    number = np.arange(1, COUNT + 1)

    def plot() -> Plot:
        curves = []
        for ends, by_lissom in zip(ENDS, found, strict=True):
            curves.append(Curve(ENDS[ends], number, exact_space.beam_roots(ends, COUNT) ** 2))
            curves.append(Curve(f"lissom, {ENDS[ends]}", number, by_lissom, joined=False))
        return Plot("mode", "ω / √(E I / (ρ A L⁴))", curves)

    return Answer(np.concatenate(found), plot)


#: Rods that can only stretch or only twist: ends, and frequencies in units of the speed of waves / L.
BARS = {"cc": (1.0, 2.0, 3.0), "cf": (0.5, 1.5, 2.5), "ff": (1.0, 2.0, 3.0)}


def bar_frequencies() -> Array:
    """d'Alembert's, for stretch and for torsion."""
    return np.pi * np.concatenate([*BARS.values(), *BARS.values()])


def bar_vibrations() -> Answer:
    """Frequencies of stretch and of torsion with both ends held, one and none."""
    found = []
    for strain, modulus in (("stretch", THIN_YOUNG), ("torsion", 0.4 * THIN_YOUNG)):
        along = strain == "stretch"
        for ends in BARS:
            segment = Segment(1.0, 0.01, THIN_YOUNG, 0.4 * THIN_YOUNG, THIN_DENSITY, {strain: 12}, nodes=28)
            axis = (1.0, 0.0, 0.0)
            joint = (Prismatic(axis) if along else Revolute(axis)) if ends[0] == "f" else Weld()
            end = LoopEnd(position=axis)
            loops = [Loop(LoopEnd(BEAM, 1.0), end, Weld(), name="end")] if ends[1] == "c" else []
            model = Robot([Link(BEAM, rod=[segment], joint=joint)], gravity=WEIGHTLESS, loops=loops)
            omega = modes(model, np.zeros(model.n)).angular_frequency / np.sqrt(modulus / THIN_DENSITY)
            found.append(omega[omega > 1e-2][:COUNT])
    number = np.arange(1, COUNT + 1)
    names = [f"{strain}, {ENDS[ends]}" for strain in ("stretch", "torsion") for ends in BARS]

    def plot() -> Plot:
        return Plot(
            "mode",
            "ω L / c",
            [Curve("exact", np.tile(number, 6), bar_frequencies(), joined=False)]
            + [Curve(f"lissom, {name}", number, values) for name, values in zip(names, found, strict=True)],
        )

    return Answer(np.concatenate(found), plot)


# Motion between clamps

#: AeroBeams' biclampedBeam.jl (MIT): L = 1, E I = 1, G A = 1e4, E A = 1e6, rho A = 1, no rotary inertia, let
#: go from
#: the deflection (sin pi x - pi x (1 - x)) / 1000, for two periods of what it takes for the first mode. A
#: hundredth of
#: that here: the original deflection stretches the beam, which changes the middle by 2e-3 of itself.
LET_GO, AEROBEAMS_HERTZ = 1e-5, 3.5653
GO_TIMES = np.linspace(0.0, 2.0 / AEROBEAMS_HERTZ, 201)
GO_STEP = 1e-4
#: Indices of the times in the table.
GO_SHOWN = (25, 50, 100, 150, 200)
#: lissom's rods with shear need some rotary inertia; this one lowers the first frequency by 2e-8 of it.
GO_INERTIA = 1e-8


def released_shape(x: Array) -> Array:
    """Deflection of the start."""
    return np.asarray(LET_GO * (np.sin(np.pi * x) - np.pi * x * (1.0 - x)))


@cache
def released_exact() -> exact_space.Vibration:
    """The motion by linear theory."""
    return exact_space.clamped_motion(1.0, 1e4, 1.0, released_shape, GO_TIMES, degree=60)


def clamped_beam() -> Robot:
    """The beam between clamps; it deflects so little that it need not stretch."""
    section = Section.given(
        (1.0, 1.0, 1.0, 1e6, 1e4, 1e4), mass=1.0, inertia=(2.0 * GO_INERTIA,) + (GO_INERTIA,) * 2
    )
    segment = Segment(1.0, section=section, modes={"bend_y": 20, "shear_z": 20, "stretch": 4}, nodes=48)
    end = LoopEnd(position=(1.0, 0.0, 0.0))
    return Robot(
        [Link(BEAM, rod=[segment])],
        gravity=WEIGHTLESS,
        loops=[Loop(LoopEnd(BEAM, 1.0), end, Weld(), name="end")],
    )


def released() -> Answer:
    """Deflection of the middle over two periods."""
    model, wanted = clamped_beam(), released_exact()
    x, w, theta = wanted.x, wanted.start, wanted.angle
    frames = np.tile(np.eye(3), (len(x), 1, 1))
    frames[:, 0, 0] = frames[:, 2, 2] = np.cos(theta)
    frames[:, 2, 0], frames[:, 0, 2] = np.sin(theta), -np.sin(theta)
    start = model.coordinates_of(np.column_stack([x, 0.0 * x, w]), frames, X=x, link=BEAM)
    motion = simulate(model, GO_TIMES[-1], q0=start.q, dt=GO_STEP, t_eval=GO_TIMES)
    middle = model.pose(motion.q, 0.5, link=BEAM)[:, 2, 3] / LET_GO
    return Answer(
        middle[list(GO_SHOWN)] if motion.success else [np.nan],
        lambda: Plot(
            "time (s)",
            "middle, relative",
            [
                Curve("lissom", GO_TIMES, middle),
                Curve("linear beam", GO_TIMES[::5], wanted.middle[::5] / LET_GO, joined=False),
            ],
        ),
        unfinished(motion),
    )


# Heavy beams

#: MoorDyn's tests/beam.cpp (BSD-3): L = 10 m, E I = 1e7 N m^2, E A = 1.5e9 N, 100 kg/m, g = 9.80665 m/s^2.
HEAVY_LENGTH, HEAVY_BENDING, HEAVY_STRETCH, HEAVY_MASS, HEAVY_GRAVITY = 10.0, 1e7, 1.5e9, 100.0, 9.80665


def heavy_deflections() -> list[float]:
    """Tip of the cantilever and middle of the beam between pins, one of which slides, by linear theory."""
    unit = HEAVY_MASS * HEAVY_GRAVITY * HEAVY_LENGTH**4 / HEAVY_BENDING
    return [-unit / 8.0, -5.0 * unit / 384.0]


def heavy() -> Answer:
    """Both beams under their weight."""
    section = Section.given((HEAVY_BENDING,) * 3 + (HEAVY_STRETCH, 1e8, 1e8), mass=HEAVY_MASS)
    rod = [Segment(HEAVY_LENGTH, section=section, modes={"bend_y": 8})]
    position = (HEAVY_LENGTH, 0.0, 0.0)
    slider = Link("slider", joint=Prismatic((1.0, 0.0, 0.0)), position=position, body=Body(mass=1.0))
    pin = Loop(LoopEnd(BEAM, HEAVY_LENGTH), LoopEnd("slider"), Spherical(), name="pin")
    gravity = (0.0, 0.0, -HEAVY_GRAVITY)
    robots = {
        "cantilever": Robot([Link(BEAM, rod=rod)], gravity=gravity),
        "pinned": Robot(
            [Link(BEAM, rod=rod, joint=Revolute((0.0, 1.0, 0.0))), slider], gravity=gravity, loops=[pin]
        ),
    }
    lines, failures = {}, []
    for name, model in robots.items():
        found = statics(model)
        lines[name] = model.pose(found.q, np.linspace(0.0, HEAVY_LENGTH, 101), link=BEAM)[:, :3, 3]
        failures += [] if found.success else [found.message]

    def plot() -> Plot:
        x = np.linspace(0.0, HEAVY_LENGTH, 21)
        size = HEAVY_MASS * HEAVY_GRAVITY / (24.0 * HEAVY_BENDING)
        free = -size * x**2 * (6.0 * HEAVY_LENGTH**2 - 4.0 * HEAVY_LENGTH * x + x**2)
        pinned = -size * x * (HEAVY_LENGTH**3 - 2.0 * HEAVY_LENGTH * x**2 + x**3)
        return Plot(
            "x (m)",
            "z (m)",
            [
                *(Curve(f"lissom, {name}", line[:, 0], line[:, 2]) for name, line in lines.items()),
                Curve("linear theory, cantilever", x, free, joined=False),
                Curve("linear theory, pinned", x, pinned, joined=False),
            ],
        )

    return Answer([lines["cantilever"][-1, 2], lines["pinned"][50, 2]], plot, " ".join(failures))


CASES = (
    Case(
        "Cantilever, small force",
        THEME,
        "The cantilever of the benchmark cosseratbench: L = 1 m, radius 20 mm, E = 1 MPa, a force of 7.5 "
        "mN at its tip. "
        "Linear theory leaves out shear and the square of the slope, which are below 1e-3.",
        "F L³ / (3 E I)",
        "exact",
        "deflection of the tip (m)",
        lambda: [SMALL_FORCE / (3.0 * SMALL_BENDING)],
        small,
        1e-3,
        others="in a simulation with 20 elements PyElastica 7.3e-2, MuJoCo 7.4e-2",
    ),
    Case(
        "Soft in shear",
        THEME,
        "Cantilever with E I = 10, L = 1 under a force of 10, without stretch, with G A = 500 and 10: it "
        "shears as much "
        "as it bends; 10 modes of bending and of shear.",
        "Case of Batista 2016; Chebyshev collocation",
        "computed",
        "tip x, z for each",
        lambda: np.concatenate([planar_tip(soft_shape(shear)) for shear in SOFT_SHEARS]),
        soft,
        1e-9,
    ),
    Case(
        "An eighth of a circle, pushed",
        THEME,
        "L = 10, E I = G J = 100, E A = G A = 1e4: a moment that bends to an eighth of a circle and a "
        "force of 1/16 "
        "across. With a moment fixed in space and with one that turns with the tip; 6 modes a strain.",
        "Case of Ibrahimbegovic, Frey and Kozar 1995; Runge-Kutta shooting",
        "computed",
        "tip x, y, z for both moments",
        lambda: np.concatenate([eighth_line(follows)[-1] for follows in (False, True)]),
        eighth,
        1e-9,
    ),
    Case(
        "45-degree bend, GXBeam",
        THEME,
        "The bend of 45 degrees above as GXBeam has it: G A without shear correction, force 600; 8 modes a "
        "strain.",
        "Reissner-Simo equations, Runge-Kutta shooting",
        "computed",
        "displacement of the tip in GXBeam's axes",
        lambda: gx_displacement(gx_line()[-1]),
        gx_bend,
        1e-8,
        others="GXBeam with 16 elements 5e-4 (−13.577384, −23.545303, 53.458008); Bathe and Bolourchi "
        "1979 4e-3 (−13.4, −23.5, 53.4)",
    ),
    Case(
        "Cable held bent and twisted",
        THEME,
        "A straight cable of 1.4 m with E I = 40 and G J = 12 N m², whose end is held where a constant "
        "bend and twist of "
        "30, 60 and 90 degrees each would bring it: both are constant along it, and do not mix.",
        "Case of Newton's example_cable_bend_twist_analytic; helix",
        "exact",
        "smallest twist and bend, largest twist and bend for each, × L",
        lambda: np.repeat(HELD_ANGLES, 4),
        held,
        1e-9,
    ),
    Case(
        "Twist under tension",
        THEME,
        "The rope of the benchmark cosseratbench, L = 1 m, radius 10 mm, E = 1 MPa, between clamps, one of "
        "which slides, "
        "twisted until the straight rope is unstable; tension 1, 10 and 30 E I / L². 4 segments with 6 "
        "modes of each bend.",
        "Love 1927, 272; 2 b (cos b − cos a) = T sin b",
        "exact",
        "critical moment × L / (E I) for each",
        lambda: [exact_space.twisted_under_tension(tension) for tension in TENSIONS],
        twist_to_buckling,
        1e-6,
        others="PyElastica 1.1e-2 in a simulation; MuJoCo cannot",
    ),
    Case(
        "Beams with all ends",
        THEME,
        "Clamped and clamped, free, pinned or sliding, pinned and pinned, free and free: loops hold the "
        "far end; "
        "slenderness 1 / 10 000, 16 modes.",
        "Euler-Bernoulli theory (Blevins 1979, table 8-1)",
        "exact",
        "first three ω / √(E I / (ρ A L⁴)) of each",
        bending_frequencies,
        bending_vibrations,
        1e-6,
    ),
    Case(
        "Bars with all ends",
        THEME,
        "Stretching and twisting of a bar with both ends held, one and none; 12 modes.",
        "d'Alembert's wave equation",
        "exact",
        "first three ω L / c of each",
        bar_frequencies,
        bar_vibrations,
        1e-7,
    ),
    Case(
        "Soft beam between clamps, let go",
        THEME,
        "L = 1, E I = 1, G A = 1e4, ρ A = 1, let go from the deflection (sin π x − π x (1 − x)) / 100 000, "
        "a hundredth of the original one, which stretches the beam. The theory has no "
        "rotary inertia; lissom needs some with shear, here 1e-8. The start is curved at the clamps, so "
        "that errors fall slowly with the number of modes: 20 of bending and of shear.",
        "Case of AeroBeams' biclampedBeam; Timoshenko's linear beam by Chebyshev collocation, all modes",
        "computed",
        "middle after 1/4, 1/2, 1, 3/2 and 2 times 0.28048 s, × 100 000",
        lambda: released_exact().middle[list(GO_SHOWN)] / LET_GO,
        released,
        5e-4,
        others="AeroBeams compares with one mode of 3.5653 Hz; the first frequency is 3.5520 Hz",
    ),
    Case(
        "Heavy beams",
        THEME,
        "L = 10 m, E I = 1e7 N m², 100 kg/m: a cantilever, and a beam between pins, one of which slides. "
        "Linear theory "
        "leaves out the square of the slope, 3e-4 here.",
        "Case of MoorDyn's tests/beam.cpp; linear theory, w L⁴ / (8 E I), 5 w L⁴ / (384 E I)",
        "exact",
        "deflection of the tip and of the middle (m)",
        heavy_deflections,
        heavy,
        5e-4,
        others="MoorDyn accepts 5e-1",
    ),
)
