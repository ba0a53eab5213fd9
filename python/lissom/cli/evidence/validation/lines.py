"""Lines that hang between two points and rest on a floor: mooring lines, cables and chains."""

from __future__ import annotations

from functools import cache

import numpy as np

from ...._lissom import (
    Contact,
    HalfSpace,
    Link,
    Loop,
    LoopEnd,
    Revolute,
    Robot,
    Section,
    Segment,
    Spherical,
    StaticsResult,
    modes,
    statics,
)
from . import exact_lines
from .case import Answer, Array, Case, Curve, Plot
from .exact_lines import Line
from .rods import GRAVITY

THEME = "Lines and chains"

NAME = "line"
#: Number of points of a line, for its start and for its picture.
POINTS = 401

#: Bending stiffness of lines that have none, in units of weight x length^3: forces change by about 30 times
#: as
#: much, in units of the weight.
BENDING = 1e-8
#: Segments of a line, and modes of bending and stretch of each.
SEGMENTS, BENDS, STRETCHES = 20, 4, 2
#: Above this stiffness, relative to the weight, stretch changes no digit.
STIFF = 1e7


def robot(
    line: Line,
    section: Section,
    *,
    segments: int = SEGMENTS,
    bends: int = BENDS,
    contacts: tuple[Contact, ...] = (),
) -> Robot:
    """A line from a hinge at the origin to a hook, in the plane of x and z."""
    strains = {"bend_y": bends}
    if abs(line.weight) * line.length * STIFF > line.EA:
        strains["stretch"] = STRETCHES
    rod = [Segment(line.length / segments, section=section, modes=strains)] * segments
    hook = Loop(LoopEnd(NAME, line.length), LoopEnd(position=(line.x, 0.0, line.z)), Spherical(), name="hook")
    return Robot(
        [Link(NAME, joint=Revolute((0.0, 1.0, 0.0)), rod=rod)],
        gravity=(0.0, 0.0, -GRAVITY * np.sign(line.weight)),
        loops=[hook],
        contacts=contacts,
    )


def section_of(line: Line, bending: float, radius: float = 0.0) -> Section:
    """A section of these stiffnesses; torsion and shear do not matter in the plane."""
    mass = abs(line.weight) / GRAVITY
    turning = mass * radius**2 / 4.0
    stiffness = (bending, bending, bending, line.EA, 1.0, 1.0)
    return Section.given(stiffness, mass=mass, inertia=(2.0 * turning, turning, turning))


def settled(model: Robot, x: Array, z: Array, s: Array) -> StaticsResult:
    """Equilibrium found from a curve."""
    start = model.coordinates_of(np.column_stack([x, 0.0 * x, z]), X=s, link=NAME).q
    return statics(model, start)


def end_forces(model: Robot, q: Array) -> Array:
    """Forces of a line on what holds it, (x, z) at A and at B."""
    still = np.zeros(model.n)
    low = model.base_wrench(q, still, still)[3:]
    up = np.ravel(model.loop_forces(q, still, still, name="hook"))[3:]
    return np.array([-low[0], -low[2], up[0], up[2]])


def picture(model: Robot, q: Array, line: Line, points: tuple[str, Array, Array]) -> Plot:
    """The line by lissom beside points."""
    found = model.pose(q, np.linspace(0.0, line.length, POINTS), link=NAME)[:, :3, 3]
    name, x, z = points
    return Plot(
        "x (m)",
        "z (m)",
        [Curve("lissom", found[:, 0], found[:, 2]), Curve(name, x, z, joined=False)],
        to_scale=True,
    )


# MoorPy's table

#: Lines of MoorPy's tests/test_catenary.py (BSD-3) by number, with their published forces on A and B, N,
#: horizontal and vertical. Lines 1 and 3 are line 2 with friction of the floor, which equilibria do not have.
MOORED: dict[int, tuple[Line, tuple[float, float, float, float]]] = {
    2: (
        Line(400.0, 200.0, 500.0, 7.51e12, 800.0),
        (96643.42815934008, 0.0, -96643.42815934008, -237751.75535996316),
    ),
    4: (
        Line(400.0, 200.0, 500.0, 7.51e12, 200.0),
        (43694.580989249596, -22365.599350216216, -43694.580989249596, -77634.40064978378),
    ),
    5: (
        Line(89.9, 59.2, 130.0, 7.51e8, 881.05),
        (31373.229006023103, -26650.341270116318, -31373.229006023103, -87886.15872988368),
    ),
    6: (
        Line(37.96888656874307, 20.49078283711694, 100.0, 7.51e8, -881.0549577007893),
        (6428.437434537766, 53178.729367882406, -6428.437434537766, 34926.76640219652),
    ),
    7: (
        Line(246.22420940032947, 263.55766330843164, 360.62566262396927, 7e8, 3.08735),
        (71116.8, 75567.3, -71116.8, -76680.6),
    ),
    8: (
        Line(246.22420940032947, 263.55766330843164, 360.63566262396927, 7e8, 3.08735),
        (56804.6, 60803.4, -56804.6, -60803.4),
    ),
    9: (
        Line(246.22420940032947, 263.55766330843164, 360.64566262396927, 7e8, 3.08735),
        (46077.1, 48765.2, -46077.1, -49878.6),
    ),
    10: (
        Line(119.3237383002058, 52.49668849178113, 130.36140355177318, 7e8, 34.91060469991227),
        (72694.145, 29715.173, -72694.145, -34266.168),
    ),
}
#: The line that rests on a floor.
ON_FLOOR = 2
#: What MoorPy's published forces miss, relative to the largest; tests compute it again.
MOORPY = {2: 1.1e-7, 4: 3.0e-7, 5: 6.7e-8, 6: 2.2e-8, 7: 5.7e-7, 8: 3.6e-2, 9: 4.3e-6, 10: 6.9e-6}


def moored_wanted(number: int) -> Array:
    """Forces on A and B."""
    line, _ = MOORED[number]
    if number == ON_FLOOR:
        H, V = exact_lines.resting(line)
        return np.array([H, 0.0, -H, -V])
    H, V = exact_lines.hanging(line)
    return np.array([H, V - line.weight * line.length, -H, -V])


def moored(number: int) -> Answer:
    """A line of the table."""
    line, _ = MOORED[number]
    s = np.linspace(0.0, line.length, POINTS)
    if number == ON_FLOOR:
        model, found, forces = rested(line)
        x, z = exact_lines.resting_shape(line, exact_lines.resting(line), s)
    else:
        x, z = exact_lines.hanging_shape(line, exact_lines.hanging(line), s)
        model = robot(line, section_of(line, BENDING * abs(line.weight) * line.length**3))
        found = settled(model, x, z, s)
        forces = end_forces(model, found.q)
    every = POINTS // 20
    return Answer(
        forces,
        lambda: picture(model, found.q, line, ("catenary", x[::every], z[::every])),
        failure="" if found.success else found.message,
    )


#: A floor under a line: radius of the line, m, stiffness, N/m^2, segments and their modes.
FLOOR_RADIUS, FLOOR_STIFFNESS, FLOOR_SEGMENTS, FLOOR_BENDS = 0.1, 1e6, 10, 6


def rested(line: Line) -> tuple[Robot, StaticsResult, Array]:
    """A line that partly rests on a floor, its equilibrium, and its forces on A and B.

    The floor is as much higher as the line sinks in, so that what rests is at the height of A.
    """
    s = np.linspace(0.0, line.length, POINTS)
    x, z = exact_lines.resting_shape(line, exact_lines.resting(line), s)
    height = line.weight / FLOOR_STIFFNESS - FLOOR_RADIUS
    contact = Contact(NAME, HalfSpace((0.0, 0.0, height)), stiffness=FLOOR_STIFFNESS, name="floor")
    section = section_of(line, BENDING * line.weight * line.length**3, FLOOR_RADIUS)
    model = robot(line, section, segments=FLOOR_SEGMENTS, bends=FLOOR_BENDS, contacts=(contact,))
    found = settled(model, x, z, s)
    return model, found, end_forces(model, found.q)


def moored_setting(number: int) -> str:
    """A line in words."""
    line, _ = MOORED[number]
    stretch = "" if line.EA > 1e12 else f", E A = {line.EA:.3g} N"
    words = f"From (0, 0) to ({line.x:.6g}, {line.z:.6g}) m, {line.length:.9g} m long, "
    words += f"{line.weight:.6g} N/m{stretch}"
    if number == ON_FLOOR:
        words += ", 203 m of it on a floor without friction"
    elif line.weight < 0.0:
        words += ": it floats up"
    return words + "."


def moored_others(number: int) -> str:
    """Error of the published values."""
    words = f"MoorPy {MOORPY[number]:.0e}"
    if number == 8:
        words += (
            " (the vertical forces in its table are equal and opposite: nothing carries the weight of 1113 N)"
        )
    return words


# Cables between two hooks

#: The rope of cosseratbench: L = 1 m.
ROPE_RADIUS, ROPE_YOUNG, ROPE_DENSITY = 0.005, 1e6, 1000.0
ROPE_AREA = np.pi * ROPE_RADIUS**2
ROPE_BENDING = ROPE_YOUNG * ROPE_AREA * ROPE_RADIUS**2 / 4.0
SPANS = (0.6, 0.8, 0.95)


def rope(span: float) -> Line:
    """The rope between hooks of equal height."""
    return Line(span, 0.0, 1.0, ROPE_YOUNG * ROPE_AREA, ROPE_DENSITY * ROPE_AREA * GRAVITY)


def rope_without_bending() -> list[float]:
    """Sag and horizontal force of the elastic catenary."""
    wanted = []
    for span in SPANS:
        line = rope(span)
        forces = exact_lines.hanging(line)
        _, z = exact_lines.hanging_shape(line, forces, np.array(0.5))
        wanted += [-float(z), forces[0]]
    return wanted


@cache
def rope_with_bending() -> list[float]:
    """The same with the bending stiffness."""
    wanted = []
    for span in SPANS:
        H, _, _, z = exact_lines.stiff_cable(rope(span), ROPE_BENDING)
        wanted += [-float(z[len(z) // 2]), H]
    return wanted


def ropes(bending: float) -> Answer:
    """Sag and horizontal force for all spans."""
    values: list[float] = []
    curves, failures = [], []
    s = np.linspace(0.0, 1.0, POINTS)
    for span in SPANS:
        line = rope(span)
        x, z = exact_lines.hanging_shape(line, exact_lines.hanging(line), s)
        model = robot(line, section_of(line, bending))
        found = settled(model, x, z, s)
        shape = model.pose(found.q, s, link=NAME)[:, :3, 3]
        values += [-shape[POINTS // 2, 2], end_forces(model, found.q)[0]]
        curves.append(Curve(f"lissom, {span:g} m", shape[:, 0], shape[:, 2]))
        curves.append(Curve(f"catenary, {span:g} m", x[::20], z[::20], joined=False))
        failures += [] if found.success else [found.message]
    return Answer(values, lambda: Plot("x (m)", "z (m)", curves, to_scale=True), " ".join(failures))


# Ropes that cross

#: How much lower the hooks of the rope above are, m; stiffness of the contact, N/m: the ropes sink 0.02 mm
#: into each
#: other.
DROP, CROSSING_STIFFNESS = 0.1, 1e7
CROSSING_SPAN, CROSSING_SEGMENTS, CROSSING_BENDS = 0.8, 8, 6


@cache
def crossing_exact() -> Array:
    """Heights of both middles and the force between the ropes."""
    line = rope(CROSSING_SPAN)
    return np.array(exact_lines.crossing_cables(line, ROPE_BENDING, DROP, 2.0 * ROPE_RADIUS))


def crossing() -> Answer:
    """Equilibrium from shapes that do not touch."""
    line = rope(CROSSING_SPAN)
    segment = Segment(
        line.length / CROSSING_SEGMENTS,
        ROPE_RADIUS,
        ROPE_YOUNG,
        ROPE_YOUNG / 3.0,
        ROPE_DENSITY,
        {"bend_y": CROSSING_BENDS, "stretch": STRETCHES},
    )
    half, hinge = float(np.sqrt(0.5)), Revolute((0.0, 1.0, 0.0))
    rod = [segment] * CROSSING_SEGMENTS
    middle = 0.5 * line.x
    links = [
        Link("below", joint=hinge, rod=rod),
        Link(
            "above",
            joint=hinge,
            rod=rod,
            position=(middle, -middle, -DROP),
            orientation=(half, 0.0, 0.0, half),
        ),
    ]
    hooks = {"below": (line.x, 0.0, 0.0), "above": (middle, middle, -DROP)}
    loops = [
        Loop(LoopEnd(name, line.length), LoopEnd(position=hook), Spherical(), name=name)
        for name, hook in hooks.items()
    ]
    contact = Contact("above", "below", stiffness=CROSSING_STIFFNESS, name="crossing")
    model = Robot(links, loops=loops, contacts=[contact])
    start = np.zeros(model.n)
    for link, sign in zip(links, (1.0, -1.0), strict=True):
        # A little more than the force between them, so that they are apart.
        s, x, z = exact_lines.pressed_cable(line, ROPE_BENDING, sign * 0.36 * line.weight * line.length)
        s, x = np.append(s, line.length - s[-2::-1]), np.append(x, line.x - x[-2::-1])
        points = np.column_stack([x, 0.0 * x, np.append(z, z[-2::-1])])
        alone = Robot([Link(link.name, joint=hinge, rod=rod)])
        start[model.slice(link.name)] = alone.coordinates_of(points, X=s).q
    found = statics(model, start)
    heights = [model.pose(found.q, 0.5 * line.length, link=link.name)[2, 3] for link in links]
    force = np.ravel(model.contact_forces(found.q, np.zeros(model.n)))[5]
    s = np.linspace(0.0, line.length, 101)
    shapes = {name: model.pose(found.q, s, link=name)[:, :3, 3] for name in hooks}

    def plot() -> Plot:
        _, x, z = exact_lines.pressed_cable(line, ROPE_BENDING, crossing_exact()[2])
        _, y, lifted = exact_lines.pressed_cable(line, ROPE_BENDING, -crossing_exact()[2])
        return Plot(
            "along the rope (m)",
            "z (m)",
            [
                Curve("lissom, below", shapes["below"][:, 0], shapes["below"][:, 2]),
                Curve("lissom, above", shapes["above"][:, 1] + middle, shapes["above"][:, 2]),
                Curve("collocation, below", x[::4], z[::4], joined=False),
                Curve("collocation, above", y[::4], lifted[::4] - DROP, joined=False),
            ],
            to_scale=True,
        )

    return Answer([*heights, force], plot, "" if found.success else found.message)


# Hanging cable

CABLE_RADIUS, CABLE_YOUNG, CABLE_DENSITY = 0.002, (1e7, 1e8), 1000.0
CABLE_COUNT = 2


def cable_frequencies() -> Array:
    """By collocation."""
    area = np.pi * CABLE_RADIUS**2
    return np.concatenate(
        [
            exact_lines.swinging_cable(
                1.0,
                young * area,
                young * area * CABLE_RADIUS**2 / 4.0,
                CABLE_DENSITY * area,
                CABLE_DENSITY * area * CABLE_RADIUS**2 / 4.0,
                GRAVITY,
            )[:CABLE_COUNT]
            for young in CABLE_YOUNG
        ]
    )


def swinging_cables() -> Answer:
    """Modes about the stretched equilibrium."""
    frequencies, curves = [], []
    for young in CABLE_YOUNG:
        segment = Segment(0.25, CABLE_RADIUS, young, young / 3.0, CABLE_DENSITY, {"bend_y": 6, "stretch": 2})
        half = np.sqrt(0.5)
        link = Link(
            NAME,
            joint=Revolute((0.0, 1.0, 0.0)),
            rod=[segment] * 4,
            orientation=(half, 0.0, half, 0.0),
        )
        model = Robot([link])
        rest = statics(model)
        found = modes(model, rest.q)
        frequencies.append(found.angular_frequency[:CABLE_COUNT])
        for mode in range(CABLE_COUNT):
            q = rest.q + 1e-3 * np.real(found.shapes[:, mode]) / np.abs(found.shapes[:, mode]).max()
            line = model.pose(q, np.linspace(0.0, 1.0, 101), link=NAME)[:, :3, 3]
            curves.append(
                Curve(
                    f"mode {mode + 1}, E = {young:.0e} Pa", line[:, 0] / np.abs(line[:, 0]).max(), line[:, 2]
                )
            )
    return Answer(np.concatenate(frequencies), lambda: Plot("x, relative", "z (m)", curves))


# Chains in three depths

#: MoorDyn's tests/quasi_static_chain.cpp (BSD-3): depth, distance and length, m; tension at the fairlead and
#: at the anchor by quasi-static codes, N, to four digits.
CHAINS = (
    (50.0, 400.0, 410.0, 991.6e3, 826.2e3),
    (200.0, 700.0, 760.0, 2065.4e3, 1402.2e3),
    (600.0, 1500.0, 1700.0, 5232.6e3, 3244.2e3),
)
CHAIN_DIAMETER, CHAIN_MASS, CHAIN_STRETCH, WATER = 0.252, 390.0, 1.674e9, 1025.0


def chain(depth: float, distance: float, length: float) -> Line:
    """A chain from its anchor to the fairlead, weighed in water."""
    weight = (CHAIN_MASS - WATER * np.pi / 4.0 * CHAIN_DIAMETER**2) * GRAVITY
    return Line(distance, depth, length, CHAIN_STRETCH, float(weight))


def chain_tensions() -> Array:
    """Published tensions."""
    return np.ravel([[fairlead, anchor] for *_, fairlead, anchor in CHAINS])


@cache
def chain_exact() -> Array:
    """Tensions of the elastic catenary that rests on a floor."""
    tensions = []
    for depth, distance, length, _, _ in CHAINS:
        H, V = exact_lines.resting(chain(depth, distance, length))
        tensions += [np.hypot(H, V), H]
    return np.array(tensions)


def hung_chains() -> Answer:
    """Tensions of all chains with their shapes."""
    tensions, curves, failures = [], [], []
    for depth, distance, length, _, _ in CHAINS:
        line = chain(depth, distance, length)
        s = np.linspace(0.0, length, POINTS)
        x, z = exact_lines.resting_shape(line, exact_lines.resting(line), s)
        model, found, forces = rested(line)
        tensions += [np.hypot(*forces[2:]), abs(forces[0])]
        shape = model.pose(found.q, s, link=NAME)[:, :3, 3]
        curves.append(Curve(f"lissom, {depth:g} m", shape[:, 0], shape[:, 2] - depth))
        curves.append(Curve(f"catenary, {depth:g} m", x[::20], z[::20] - depth, joined=False))
        failures += [] if found.success else [found.message]
    return Answer(tensions, lambda: Plot("x (m)", "z (m)", curves, to_scale=True), " ".join(failures))


CASES = (
    *(
        Case(
            f"MoorPy, line {number}",
            THEME,
            moored_setting(number),
            "Line of MoorPy's tests/test_catenary.py; elastic catenary",
            "exact",
            "horizontal and vertical force on A, on B (N)",
            lambda number=number: moored_wanted(number),  # type: ignore[misc]
            lambda number=number: moored(number),  # type: ignore[misc]
            5e-5 if number == ON_FLOOR else 5e-6,
            others=moored_others(number),
        )
        for number in MOORED
    ),
    Case(
        "Chains in three depths",
        THEME,
        "Chains of 252 mm, 390 kg/m, E A = 1.674e9 N, in water of 1025 kg/m³ and depths of 50, 200 and 600 "
        "m, that "
        "partly rest on the ground: 410, 760 and 1700 m long over 400, 700 and 1500 m.",
        "Case of MoorDyn's tests/quasi_static_chain.cpp; elastic catenary on a floor",
        "exact",
        "tension at the fairlead and at the anchor for each (N)",
        chain_exact,
        hung_chains,
        2e-4,
        others="quasi-static codes as MoorDyn quotes them 1e-2 in 50 m, 3e-3 in 200 m, 1e-3 in 600 m; "
        "MoorDyn accepts 1e-1",
    ),
    Case(
        "Rope between hooks, catenary",
        THEME,
        "The rope of the benchmark cosseratbench, L = 1 m, radius 5 mm, E = 1 MPa, 1000 kg/m³, hung from "
        "two hooks of "
        "equal height 0.6, 0.8 and 0.95 m apart, with a thousandth of its bending stiffness.",
        "Elastic catenary (Irvine 1981)",
        "exact",
        "sag (m) and horizontal force (N) for each",
        rope_without_bending,
        lambda: ropes(1e-3 * ROPE_BENDING),
        5e-5,
    ),
    Case(
        "Rope between hooks, stiff",
        THEME,
        "The same with all its bending stiffness, which lifts the sag by 8e-3, 4e-4 and −1e-3 of it: so "
        "much does any "
        "rod differ from the catenary with which the benchmark compares.",
        "Kirchhoff's rod with stretch, Chebyshev collocation",
        "computed",
        "sag (m) and horizontal force (N) for each",
        rope_with_bending,
        lambda: ropes(ROPE_BENDING),
        1e-6,
        others="beside the catenary without bending, at 0.8 m: PyElastica 1.4e-4, MuJoCo 1.2e-2 of the sag",
    ),
    Case(
        "Ropes that cross",
        THEME,
        "Two of these ropes over 0.8 m that cross at right angles without friction; the one above hangs from "
        "hooks 0.1 m lower. Each is held in its upright plane, which the benchmark's motions are free to "
        "leave.",
        "Case of cosseratbench; symmetric halves by Chebyshev collocation",
        "computed",
        "heights of the middles below and above (m), force between them (N)",
        crossing_exact,
        crossing,
        5e-4,
        others="in motions the lift is wrong by 5e-4 with MuJoCo, 3e-3 with PyElastica, 4e-1 with lissom",
    ),
    Case(
        "Hanging cable",
        THEME,
        "L = 1 m, radius 2 mm, 1000 kg/m³, E = 10 and 100 MPa, hung from a pin and stretched by its "
        "weight; modes about "
        "that equilibrium.",
        "Linear rod with bending, stretch and rotary inertia, Chebyshev collocation",
        "computed",
        "first two angular frequencies for each (rad/s)",
        cable_frequencies,
        swinging_cables,
        1e-7,
        others="period of the first in simulations by cosseratbench: PyElastica 1.4e-4, MuJoCo 2.1e-5",
    ),
)
